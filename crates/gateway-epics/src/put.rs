//! Puts: a client asks, the station does it on another thread, and the connection gives the result to the client.
//!
//! A client that waits for the result of a put reads the record next: `caput -c` shows it as the new value. So the result comes when the
//! station has read the parameter again.

use crate::database::World;
use crate::record::{Put, Record};
use profivac_gateway::command::given;
use profivac_gateway::{Commander, PointValue, Signal, Subject, Value, WriteError, WriteRequest};
use profivac_recorder::Micros;
use profivac_station::config::gateways::write::Write;
use profivac_station::services::Services;
use std::net::IpAddr;
use std::sync::Arc;
use std::time::Duration;
use tokio::sync::mpsc::{UnboundedReceiver, UnboundedSender, unbounded_channel};
use tokio::sync::watch;
use tokio::time::timeout;

/// The most puts of one client that wait. Together with the limit of the commander it bounds the results.
const MAX_WAITING: usize = 8;

/// How long the result of a put waits at most for the value that the station reads after the write. chosen: the station reads it before all
/// other parameters, and p4p waits 5 s for a put.
const READ_BACK: Duration = Duration::from_secs(4);

/// A value that a client puts.
#[derive(Clone, Debug, PartialEq)]
pub enum PutValue {
    /// A number.
    Number(f64),
    /// A text.
    Text(String),
}

/// The reason why a put was not done.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum PutError {
    /// The gateway does not write this name for this client.
    #[error("the gateway is read-only for this name and this client")]
    ReadOnly,
    /// Too many puts of the client wait.
    #[error("{MAX_WAITING} puts of this client wait already: try again")]
    Busy,
    /// The file of the station has changed.
    #[error("the record no longer exists")]
    UnknownRecord,
    /// The value has no type that can be written, in words.
    #[error("{0}")]
    Value(&'static str),
    /// A number in place of a command.
    #[error("expected a command such as ba.degas-on, found {0}")]
    NoCommand(f64),
    /// No number of an occurrence.
    #[error("expected the number of the occurrence to be acknowledged, found {0}")]
    NoOccurrence(String),
    /// The station does not do it.
    #[error(transparent)]
    Refused(#[from] WriteError),
}

/// A put that has ended.
#[derive(Debug)]
pub struct Finished<R> {
    /// The request of the client.
    pub request: R,
    /// Nothing, or why it was not done.
    pub result: Result<(), PutError>,
}

/// Writes as the user of the file.
pub struct Writer {
    commander: Commander,
    write: Write,
    worlds: watch::Receiver<Arc<World>>,
}

impl Writer {
    /// A writer with these settings. What it writes is seen in `worlds` when the station has read it again.
    #[must_use]
    pub fn new(services: Arc<Services>, write: Write, worlds: watch::Receiver<Arc<World>>) -> Self {
        Self { commander: Commander::new(services, write.users.clone()), write, worlds }
    }
}

/// The value of a parameter that a put writes, as the station reads it afterwards.
struct ReadBack {
    subject: Subject,
    signal: Signal,
    /// When the put began.
    begun: Micros,
    /// How often the point had changed then.
    version: u64,
}

impl ReadBack {
    /// Of a put that begins now; `None` where the record is no parameter.
    fn of(record: &Record, world: &World) -> Option<Self> {
        let (point, value) = (world.snapshot.points.get(record.point)?, world.snapshot.values.get(record.point)?);
        let (subject, version) = (point.subject.clone(), value.version);
        let of_now = Self { subject, signal: point.signal, begun: Micros::now(), version };
        (record.put == Put::Parameter).then_some(of_now)
    }

    /// Whether this value was read after the write, which ended at `written`. One that was read while the write waited is the old one.
    fn is_done(&self, value: &PointValue, written: Micros) -> bool {
        let is_since = |time: Micros| value.at.is_some_and(|at| at >= time);
        value.value != Value::None && is_since(self.begun) && (value.version != self.version || is_since(written))
    }

    /// Waits until the value is there, at most for [`READ_BACK`].
    async fn wait(self, mut worlds: watch::Receiver<Arc<World>>) {
        let written = Micros::now();
        let is_done = |world: &Arc<World>| {
            let mut all = world.snapshot.iter();
            let own = all.find(|(point, _)| point.signal == self.signal && point.subject == self.subject);
            // A parameter that the file does not have any more is not read again.
            own.is_none_or(|(_, value)| self.is_done(value, written))
        };
        timeout(READ_BACK, worlds.wait_for(is_done)).await.ok();
    }
}

/// The puts of one client.
pub struct Puts<R> {
    writer: Option<Arc<Writer>>,
    peer: IpAddr,
    waiting: usize,
    results: UnboundedSender<Finished<R>>,
    receiver: Option<UnboundedReceiver<Finished<R>>>,
}

impl<R: Send + 'static> Puts<R> {
    /// For a client at this address; without a writer no client writes.
    #[must_use]
    pub fn new(writer: Option<Arc<Writer>>, peer: IpAddr) -> Self {
        let (results, receiver) = unbounded_channel();
        let writer = writer.filter(|writer| writer.write.permits(peer));
        Self { writer, peer, waiting: 0, results, receiver: Some(receiver) }
    }

    /// Whether this client may put a value into a record.
    #[must_use]
    pub fn permits(&self, record: &Record) -> bool {
        self.writer.is_some() && record.put != Put::Refused
    }

    /// The results, once; the connection waits for them.
    pub const fn take_results(&mut self) -> Option<UnboundedReceiver<Finished<R>>> {
        self.receiver.take()
    }

    /// A result has been taken.
    pub const fn finished(&mut self) {
        self.waiting = self.waiting.saturating_sub(1);
    }

    /// Begins a put. Its result comes later; if the client waits for it, when the station has read the parameter again.
    ///
    /// # Errors
    /// [`PutError`] when it does not begin.
    pub fn begin(
        &mut self,
        request: R,
        record: &Record,
        value: &PutValue,
        world: &World,
        is_awaited: bool,
    ) -> Result<(), PutError> {
        let writer = self.writer.as_ref().filter(|_| record.put != Put::Refused);
        let writer = Arc::clone(writer.ok_or(PutError::ReadOnly)?);
        if self.waiting >= MAX_WAITING {
            return Err(PutError::Busy);
        }
        let write = request_of(record, value, world)?;
        self.waiting = self.waiting.saturating_add(1);
        let (results, peer) = (self.results.clone(), self.peer);
        let read_back = ReadBack::of(record, world).filter(|_| is_awaited);
        tokio::spawn(async move {
            let done = writer.commander.execute(&writer.write.user, write, Some(peer)).await;
            let result = done.map_err(PutError::from);
            if result.is_ok()
                && let Some(read_back) = read_back
            {
                read_back.wait(writer.worlds.clone()).await;
            }
            // A client that is gone needs no result.
            results.send(Finished { request, result }).ok();
        });
        Ok(())
    }
}

/// What a put means.
fn request_of(record: &Record, value: &PutValue, world: &World) -> Result<WriteRequest, PutError> {
    let point = world.snapshot.points.get(record.point).ok_or(PutError::UnknownRecord)?;
    match (record.put, &point.subject) {
        (Put::Parameter, Subject::Parameter { gauge, target, .. }) => {
            let (gauge, target) = (Arc::clone(gauge), Arc::clone(target));
            Ok(WriteRequest::Parameter { gauge, target, value: parameter_text(record.signal, value, world) })
        }
        (Put::Command, Subject::Gauge(gauge)) => match value {
            PutValue::Text(command) => Ok(WriteRequest::Command { gauge: Arc::clone(gauge), command: command.clone() }),
            PutValue::Number(number) => Err(PutError::NoCommand(*number)),
        },
        (Put::Acknowledge, Subject::Alarm(alarm)) => {
            Ok(WriteRequest::Acknowledge { alarm: Arc::clone(alarm), occurrence: occurrence(value)? })
        }
        _ => Err(PutError::ReadOnly),
    }
}

/// The value of a parameter as the station reads it. A number for a pressure or a percentage is in the unit of the record; a
/// text may have a unit.
fn parameter_text(signal: Signal, value: &PutValue, world: &World) -> String {
    let number = match value {
        PutValue::Number(number) => Some(*number),
        PutValue::Text(text) => text.trim().parse().ok(),
    };
    match (signal, number, value) {
        (Signal::ParameterPressure, Some(number), _) => {
            given(signal, &Value::Float(number * world.database.settings().unit_pa()))
        }
        (Signal::ParameterPercentage, Some(number), _) => given(signal, &Value::Float(number)),
        (_, Some(number), PutValue::Number(_)) => given(signal, &Value::Float(number)),
        (_, _, PutValue::Text(text)) => text.trim().to_owned(),
        (_, None, PutValue::Number(number)) => number.to_string(),
    }
}

#[expect(clippy::cast_possible_truncation, reason = "a number without a fraction and below 2^53")]
fn occurrence(value: &PutValue) -> Result<i64, PutError> {
    match value {
        PutValue::Number(number) if number.fract() == 0.0 && number.abs() < 9e15 => Ok(*number as i64),
        PutValue::Number(number) => Err(PutError::NoOccurrence(number.to_string())),
        PutValue::Text(text) => text.trim().parse().map_err(|_| PutError::NoOccurrence(text.clone())),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use profivac_gateway::State;

    const BEGUN: Micros = Micros(1_000);
    const WRITTEN: Micros = Micros(2_000);

    fn read_back() -> ReadBack {
        let name = |text: &str| Arc::<str>::from(text);
        let subject = Subject::Parameter { gauge: name("chamber"), target: name("a.limit"), name: name("Limit") };
        ReadBack { subject, signal: Signal::ParameterNumber, begun: BEGUN, version: 7 }
    }

    fn value(number: Option<f64>, at: i64, version: u64) -> PointValue {
        let state = if number.is_some() { State::Ok } else { State::Stale };
        PointValue { value: number.map_or(Value::None, Value::Float), state, at: Some(Micros(at)), version }
    }

    #[test]
    fn the_result_of_a_put_waits_for_the_value_that_is_read_after_the_write() {
        let is_done = |value| read_back().is_done(&value, WRITTEN);
        assert!(!is_done(value(Some(12.5), 500, 7)), "the old value");
        assert!(!is_done(value(None, 2_000, 8)), "stale after the write");
        assert!(!is_done(value(Some(12.5), 1_500, 7)), "read once more before the write");
        assert!(is_done(value(Some(20.0), 3_000, 9)));
        assert!(is_done(value(Some(20.0), 1_900, 9)), "read while the audit trail was written");
        assert!(is_done(value(Some(12.5), 3_000, 7)), "the same number as before");
    }
}
