//! Puts: a client asks, the station does it on another thread, and the connection gives the result to the client.

use crate::database::World;
use crate::record::{Put, Record};
use profivac_gateway::command::given;
use profivac_gateway::{Commander, Signal, Subject, Value, WriteError, WriteRequest};
use profivac_station::config::gateways::write::Write;
use profivac_station::services::Services;
use std::net::IpAddr;
use std::sync::Arc;
use tokio::sync::mpsc::{UnboundedReceiver, UnboundedSender, unbounded_channel};

/// The most puts of one client that wait. Together with the limit of the commander it bounds the results.
const MAX_WAITING: usize = 8;

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
}

impl Writer {
    /// A writer with these settings.
    #[must_use]
    pub fn new(services: Arc<Services>, write: Write) -> Self {
        Self { commander: Commander::new(services, write.users.clone()), write }
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

    /// Begins a put. Its result comes later.
    ///
    /// # Errors
    /// [`PutError`] when it does not begin.
    pub fn begin(&mut self, request: R, record: &Record, value: &PutValue, world: &World) -> Result<(), PutError> {
        let writer = self.writer.as_ref().filter(|_| record.put != Put::Refused);
        let writer = Arc::clone(writer.ok_or(PutError::ReadOnly)?);
        if self.waiting >= MAX_WAITING {
            return Err(PutError::Busy);
        }
        let write = request_of(record, value, world)?;
        self.waiting = self.waiting.saturating_add(1);
        let (results, peer) = (self.results.clone(), self.peer);
        tokio::spawn(async move {
            let done = writer.commander.execute(&writer.write.user, write, Some(peer)).await;
            let result = done.map_err(PutError::from);
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
