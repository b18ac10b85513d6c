//! The requests of users to one segment, and the order in which it answers them.
//!
//! Previews and executions come first: the parameters of a gauge are read one after the other, and the segment looks for a command
//! between two of them. While a gauge has no free MS2 connection, its requests are tried again, for as long as a slave keeps the
//! connections of a master that was killed. The gauges are sampled meanwhile, so a request leaves no gap in the recording. A preview or
//! a reading whose requester has given up is dropped, also between two parameters.
//!
//! | Request | Gauge has no free connection | Otherwise |
//! |---|---|---|
//! | preview, reading | tried again every [`RETRY_INTERVAL`], up to [`LEFTOVER_TIME`] | answered |
//! | execution | refused: the operator expects it now | answered |

use super::execute;
use super::moment::Moment;
use super::requests::{self, BlockReading, BlockReadingEnd, has_no_connection};
use super::services::SegmentServices;
use crate::control::error::{ChangedSinceArmed, OperationError, Unavailable};
use crate::control::operation::{Operation, OperationPreview};
use crate::control::requests::{Answer, SegmentRequest};
use crate::view::Block;
use profivac_client::cyclic::CyclicSlave;
use profivac_client::names::NamedParameter;
use profivac_client::records::Records;
use profivac_recorder::EventKind;
use std::collections::VecDeque;
use std::sync::mpsc::Receiver;
use std::time::{Duration, Instant};

/// How long a slave keeps the connection of a master that is gone: two Send_Timeouts of 5 s without a request and one in which its
/// Abort waits for a poll (profibus-wire 4.9), and a second more.
pub const LEFTOVER_TIME: Duration = Duration::from_secs(16);

/// The time between two requests to a gauge without a free connection. chosen.
pub const RETRY_INTERVAL: Duration = Duration::from_millis(500);

/// The port was lost during a request.
#[derive(Debug)]
pub struct PortLost;

/// The wait of a request for a free connection.
#[derive(Clone, Copy, Debug, Default)]
struct Wait {
    since: Option<Instant>,
    try_at: Option<Instant>,
}

impl Wait {
    fn is_due(&self, now: Instant) -> bool {
        self.try_at.is_none_or(|at| at <= now)
    }
}

/// A preview that waits.
struct Preview {
    gauge: String,
    operation: Operation,
    answer: Answer<Result<OperationPreview, OperationError>>,
    wait: Wait,
}

/// A reading of all blocks of a gauge.
struct Read {
    gauge: String,
    reading: BlockReading,
    answer: Answer<Result<Vec<Block>, Unavailable>>,
    wait: Wait,
}

/// A command that comes before all readings.
enum Command {
    Preview(Preview),
    /// An execution, which never waits: see [`SegmentRequest::Execute`].
    Execute(SegmentRequest),
}

impl Command {
    fn is_due(&self, now: Instant) -> bool {
        match self {
            Self::Preview(preview) => preview.wait.is_due(now),
            Self::Execute(_) => true,
        }
    }
}

/// The requests of one segment.
pub struct Inbox {
    receiver: Receiver<SegmentRequest>,
    commands: VecDeque<Command>,
    reads: VecDeque<Read>,
    /// The gauge of the last execution and the parameter that it wrote, until they were taken.
    operated: Option<(String, NamedParameter)>,
}

impl Inbox {
    /// The requests that come through `receiver`.
    pub const fn new(receiver: Receiver<SegmentRequest>) -> Self {
        Self { receiver, commands: VecDeque::new(), reads: VecDeque::new(), operated: None }
    }

    /// Takes the requests that have come. Each has a place in the queue until it is answered, so there is a limited number.
    fn fill(&mut self) {
        while let Ok(request) = self.receiver.try_recv() {
            let wait = Wait::default();
            match request {
                SegmentRequest::Blocks(gauge, answer) => {
                    self.reads.push_back(Read { gauge, reading: BlockReading::default(), answer, wait });
                }
                SegmentRequest::Preview(gauge, operation, answer) => {
                    self.commands.push_back(Command::Preview(Preview { gauge, operation, answer, wait }));
                }
                execute @ SegmentRequest::Execute(..) => self.commands.push_back(Command::Execute(execute)),
            }
        }
    }

    /// Answers one command, or reads parameters until a command comes. `slave` gives the slave of a gauge in data exchange, `records`
    /// the access to the records of a slave, `clock` the time.
    ///
    /// # Errors
    /// [`PortLost`]. Where a write finds the port lost, the next cycle finds it lost too.
    pub fn answer_next<R: Records>(
        &mut self,
        services: &SegmentServices,
        slave: impl FnOnce(&str) -> Result<CyclicSlave, Unavailable>,
        records: impl FnOnce(&CyclicSlave) -> R,
        clock: impl Fn() -> Moment,
    ) -> Result<(), PortLost> {
        self.fill();
        let now = clock();
        self.drop_abandoned(services, now.at);
        let due = self.commands.iter().position(|command| command.is_due(now.at));
        if let Some(command) = due.and_then(|index| self.commands.remove(index)) {
            match command {
                Command::Preview(preview) => self.preview(services, preview, slave, records, now),
                Command::Execute(request) => self.operated = execute(services, request, slave, records, now.at),
            }
            return Ok(());
        }
        let due = self.reads.iter().position(|read| read.wait.is_due(now.at));
        match due.and_then(|index| self.reads.remove(index)) {
            Some(read) => self.read(services, read, slave, records, clock),
            None => Ok(()),
        }
    }

    /// Drops the requests whose requesters have given up. An execution has a time of its own.
    fn drop_abandoned(&mut self, services: &SegmentServices, now: Instant) {
        self.commands.retain(|command| match command {
            Command::Preview(preview) => preview.answer.is_awaited(now),
            Command::Execute(_) => true,
        });
        self.reads.retain(|read| {
            let is_awaited = read.answer.is_awaited(now);
            if !is_awaited {
                requests::end_progress(&services.snapshots, &read.gauge);
            }
            is_awaited
        });
    }

    fn preview<R: Records>(
        &mut self,
        services: &SegmentServices,
        mut preview: Preview,
        slave: impl FnOnce(&str) -> Result<CyclicSlave, Unavailable>,
        records: impl FnOnce(&CyclicSlave) -> R,
        now: Moment,
    ) {
        let Preview { gauge, operation, .. } = &preview;
        let result =
            slave(gauge).map_err(Into::into).and_then(|slave| execute::preview(&slave, records(&slave), operation));
        let is_full =
            matches!(&result, Err(OperationError::Unavailable(Unavailable::Client(error))) if has_no_connection(error));
        if preview.wait.continues(services, &preview.gauge, is_full, now) {
            self.commands.push_back(Command::Preview(preview));
        } else {
            // A requester that timed out takes no answer.
            preview.answer.send(result).ok();
        }
    }

    fn read<R: Records>(
        &mut self,
        services: &SegmentServices,
        mut read: Read,
        slave: impl FnOnce(&str) -> Result<CyclicSlave, Unavailable>,
        records: impl FnOnce(&CyclicSlave) -> R,
        clock: impl Fn() -> Moment,
    ) -> Result<(), PortLost> {
        let end = slave(&read.gauge).map_or_else(BlockReadingEnd::Failed, |slave| {
            let Read { gauge, reading, answer, .. } = &mut read;
            let is_interrupted = || {
                self.fill();
                let now = clock().at;
                !answer.is_awaited(now) || self.commands.iter().any(|command| command.is_due(now))
            };
            reading.read_on(&services.snapshots, gauge, &slave, records(&slave), is_interrupted)
        });
        let is_full = matches!(&end, BlockReadingEnd::Failed(Unavailable::Client(error)) if has_no_connection(error));
        if read.wait.continues(services, &read.gauge, is_full, clock()) {
            self.reads.push_back(read);
            return Ok(());
        }
        let (answer, is_lost) = match end {
            BlockReadingEnd::Interrupted => {
                self.reads.push_front(read);
                return Ok(());
            }
            BlockReadingEnd::Complete => (Ok(std::mem::take(&mut read.reading).into_blocks()), false),
            BlockReadingEnd::Failed(error) => {
                let is_lost = matches!(error, Unavailable::PortLost);
                (Err(error), is_lost)
            }
        };
        requests::end_progress(&services.snapshots, &read.gauge);
        read.answer.send(answer).ok();
        if is_lost { Err(PortLost) } else { Ok(()) }
    }

    /// The gauge with which an operation was executed since the last call, and the parameter that was written.
    pub const fn take_operated(&mut self) -> Option<(String, NamedParameter)> {
        self.operated.take()
    }

    /// Refuses all requests, because the segment does not run.
    pub fn refuse_all(&mut self, services: &SegmentServices, problem: &str) {
        self.fill();
        let down = || Unavailable::SegmentDown(problem.to_owned());
        for read in self.reads.drain(..) {
            requests::end_progress(&services.snapshots, &read.gauge);
            read.answer.send(Err(down())).ok();
        }
        for command in self.commands.drain(..) {
            match command {
                Command::Preview(preview) => preview.answer.send(Err(down().into())).ok(),
                Command::Execute(SegmentRequest::Execute(_, _, answer)) => answer.send(Err(down().into())).ok(),
                Command::Execute(_) => None,
            };
        }
    }
}

impl Wait {
    /// Notes whether the gauge has no free connection. Returns whether the request is to be tried again; an event says so once.
    fn continues(&mut self, services: &SegmentServices, gauge: &str, is_full: bool, now: Moment) -> bool {
        let waited = self.since.map(|since| now.at.saturating_duration_since(since));
        let event = |text: String| services.recorder.event_at(now.wall, Some(gauge), EventKind::Bus, text);
        if !is_full {
            if let Some(waited) = waited {
                event(format!("{gauge}: an MS2 connection is free after {:.1} s", waited.as_secs_f64()));
            }
            *self = Self::default();
            return false;
        }
        if waited.is_some_and(|waited| waited >= LEFTOVER_TIME) {
            event(format!(
                "{gauge}: no MS2 connection is free after {:.0} s: another class 2 master holds them",
                LEFTOVER_TIME.as_secs_f64()
            ));
            return false;
        }
        if waited.is_none() {
            event(format!(
                "{gauge}: waiting up to {:.0} s for an MS2 connection left by an earlier connection, for example of a station that was \
                 killed",
                LEFTOVER_TIME.as_secs_f64()
            ));
        }
        self.since.get_or_insert(now.at);
        self.try_at = Some(now.at + RETRY_INTERVAL);
        true
    }
}

/// Executes an armed command, unless it is too late, or its user has lost control. Returns the name of its gauge and the parameter that
/// it writes.
fn execute<R: Records>(
    services: &SegmentServices,
    request: SegmentRequest,
    slave: impl FnOnce(&str) -> Result<CyclicSlave, Unavailable>,
    records: impl FnOnce(&CyclicSlave) -> R,
    now: Instant,
) -> Option<(String, NamedParameter)> {
    let SegmentRequest::Execute(command, begin_by, answer) = request else { return None };
    let readback = if now >= begin_by {
        Err(Unavailable::SegmentBusy(command.gauge.clone()).into())
    } else if services.control.may_send(&command) {
        slave(&command.gauge).map_err(Into::into).and_then(|slave| execute::execute(&slave, records(&slave), &command))
    } else {
        Err(ChangedSinceArmed::ControlLost { user: command.user.to_string() }.into())
    };
    answer.send(readback).ok();
    Some((command.gauge, command.operation.named))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::control::operation::OperationRequest;
    use crate::services::Services;
    use profivac_client::ErrorKind;
    use profivac_client::records::RecordError;
    use profivac_devices::model::AccessPath;
    use profivac_recorder::{Micros, Recorder, Settings};
    use profivac_virtual::device_spec::entry;
    use std::cell::{Cell, RefCell};
    use std::sync::mpsc::{SyncSender, sync_channel};
    use tempfile::TempDir;

    /// The records of a gauge, all empty. Whether a connection is free and what happens at a read is up to the test.
    struct TestRecords<'a> {
        is_free: bool,
        /// It does not answer.
        is_gone: bool,
        at_read: &'a dyn Fn(),
    }

    impl Records for TestRecords<'_> {
        fn via(&self) -> AccessPath {
            AccessPath::Class2
        }

        fn read(&mut self, _: u8, _: u8) -> Result<Vec<u8>, RecordError> {
            (self.at_read)();
            if self.is_gone {
                return Err(profivac_client::records::Interruption::NoAnswer.into());
            }
            if self.is_free { Ok(Vec::new()) } else { Err(profivac_client::records::Unavailable::NoConnection.into()) }
        }

        fn write(&mut self, _: u8, _: u8, _: &[u8]) -> Result<(), RecordError> {
            Ok(())
        }
    }

    /// How long the requesters of the tests wait.
    const AWAITED: Duration = Duration::from_secs(60);

    struct Fixture {
        _folder: TempDir,
        services: SegmentServices,
        sender: SyncSender<SegmentRequest>,
        inbox: RefCell<Inbox>,
        now: Cell<Instant>,
        is_free: Cell<bool>,
        is_gone: Cell<bool>,
        /// How often the gauge was asked.
        asked: Cell<usize>,
    }

    impl Fixture {
        fn new() -> Self {
            let folder = tempfile::tempdir().unwrap();
            let file = folder.path().join("plant.db");
            let recorder = Recorder::start(&file, Settings::default()).unwrap();
            let (sender, receiver) = sync_channel(8);
            Self {
                services: Services::new("hall".to_owned(), file, recorder).for_segments(),
                _folder: folder,
                sender,
                inbox: RefCell::new(Inbox::new(receiver)),
                now: Cell::new(Instant::now()),
                is_free: Cell::new(true),
                is_gone: Cell::new(false),
                asked: Cell::new(0),
            }
        }

        fn slave() -> CyclicSlave {
            let model = entry("bcg450").unwrap().model;
            let unit = model.unit_named("mbar").unwrap();
            let configuration = model.default_configuration;
            CyclicSlave { address: 5, model, configuration, unit, channels: Default::default() }
        }

        /// Answers a request, or a part of one. `at_read` runs at each read of a record.
        fn step(&self, at_read: impl Fn()) {
            let at_read = || {
                self.asked.set(self.asked.get() + 1);
                at_read();
            };
            let records = |_: &CyclicSlave| TestRecords {
                is_free: self.is_free.get(),
                is_gone: self.is_gone.get(),
                at_read: &at_read,
            };
            let slave = |_: &str| Ok(Self::slave());
            self.inbox.borrow_mut().answer_next(&self.services, slave, records, || self.moment()).unwrap();
        }

        fn moment(&self) -> Moment {
            Moment { at: self.now.get(), wall: Micros::now() }
        }

        fn pass(&self, time: Duration) {
            self.now.set(self.now.get() + time);
        }

        fn answer<T>(&self) -> (Answer<T>, Receiver<T>) {
            Answer::channel(self.now.get() + AWAITED, Vec::new())
        }

        fn blocks(&self) -> Receiver<Result<Vec<Block>, Unavailable>> {
            let (answer, receiver) = self.answer();
            self.sender.send(SegmentRequest::Blocks("chamber".to_owned(), answer)).unwrap();
            receiver
        }

        fn preview(&self) -> Receiver<Result<OperationPreview, OperationError>> {
            let (answer, receiver) = self.answer();
            let request = OperationRequest { command: Some("ba.degas-on".to_owned()), ..OperationRequest::default() };
            let operation = Operation::resolve(Self::slave().model, &request).unwrap();
            self.sender.send(SegmentRequest::Preview("chamber".to_owned(), operation, answer)).unwrap();
            receiver
        }

        fn events(&self) -> Vec<String> {
            assert!(self.services.recorder.flush());
            let reader = self.services.recorder.open_reader().unwrap();
            let events = reader.events(Micros(0), Micros(i64::MAX), 100).unwrap();
            events.into_iter().rev().map(|event| event.text).collect()
        }
    }

    #[test]
    fn a_command_is_answered_between_two_parameters_of_a_reading() {
        let fixture = Fixture::new();
        let blocks = fixture.blocks();
        let command = RefCell::new(None);
        // The command comes while the third parameter is read.
        fixture.step(|| {
            if fixture.asked.get() == 3 {
                *command.borrow_mut() = Some(fixture.preview());
            }
        });
        assert_eq!(fixture.asked.get(), 3, "the reading pauses");
        assert!(blocks.try_recv().is_err());
        fixture.step(|| ());
        let command = command.take().unwrap();
        assert!(command.try_recv().is_ok(), "the command is answered");
        fixture.step(|| ());
        let count = |blocks: &[Block]| blocks.iter().map(|block| block.parameters.len()).sum::<usize>();
        let interrupted = blocks.try_recv().unwrap().unwrap();
        let whole = fixture.blocks();
        fixture.step(|| ());
        assert_eq!(
            count(&interrupted),
            count(&whole.try_recv().unwrap().unwrap()),
            "no parameter is lost or read twice"
        );
        assert_eq!(fixture.services.snapshots.read_progress(), []);
    }

    #[test]
    fn a_command_comes_before_a_reading_that_was_requested_earlier() {
        let fixture = Fixture::new();
        let (blocks, command) = (fixture.blocks(), fixture.preview());
        fixture.step(|| ());
        assert!(command.try_recv().is_ok() && blocks.try_recv().is_err());
    }

    #[test]
    fn a_reading_of_a_gauge_that_does_not_answer_ends_at_its_first_parameter() {
        let fixture = Fixture::new();
        let blocks = fixture.blocks();
        fixture.is_gone.set(true);
        fixture.step(|| ());
        let error = blocks.try_recv().unwrap().unwrap_err();
        assert!(matches!(&error, Unavailable::Client(error) if error.kind() == ErrorKind::Line), "{error}");
        assert!(fixture.asked.get() <= 2, "{} reads, with the restoring of the selector", fixture.asked.get());
    }

    #[test]
    fn a_request_whose_requester_has_given_up_is_dropped_and_asks_the_gauge_nothing() {
        let fixture = Fixture::new();
        let (blocks, command) = (fixture.blocks(), fixture.preview());
        fixture.pass(AWAITED);
        fixture.step(|| ());
        fixture.step(|| ());
        assert_eq!(fixture.asked.get(), 0);
        let dropped = std::sync::mpsc::TryRecvError::Disconnected;
        assert_eq!((blocks.try_recv().err(), command.try_recv().err()), (Some(dropped), Some(dropped)));
    }

    #[test]
    fn a_reading_ends_between_two_parameters_when_its_requester_gives_up() {
        let fixture = Fixture::new();
        let abandoned = fixture.blocks();
        fixture.step(|| fixture.pass(AWAITED));
        let asked = fixture.asked.get();
        let next = fixture.blocks();
        fixture.step(|| ());
        assert!(next.try_recv().unwrap().is_ok(), "the next reading is done in one step");
        let whole = fixture.asked.get() - asked;
        assert!(asked < whole, "{asked} of {whole} reads before the requester gave up");
        assert_eq!(abandoned.try_recv().err(), Some(std::sync::mpsc::TryRecvError::Disconnected));
        assert_eq!(fixture.services.snapshots.read_progress(), []);
    }

    #[test]
    fn requests_wait_for_connections_that_an_earlier_master_left_behind() {
        let fixture = Fixture::new();
        fixture.is_free.set(false);
        let (blocks, command) = (fixture.blocks(), fixture.preview());
        fixture.step(|| ());
        fixture.step(|| ());
        let asked = fixture.asked.get();
        fixture.pass(RETRY_INTERVAL - Duration::from_millis(1));
        fixture.step(|| ());
        assert_eq!(fixture.asked.get(), asked, "not before the next time");
        fixture.pass(Duration::from_secs(9));
        fixture.step(|| ());
        fixture.step(|| ());
        assert!(fixture.asked.get() > asked && blocks.try_recv().is_err() && command.try_recv().is_err());
        fixture.is_free.set(true);
        fixture.pass(RETRY_INTERVAL);
        fixture.step(|| ());
        fixture.step(|| ());
        assert!(command.try_recv().is_ok());
        assert!(blocks.try_recv().unwrap().is_ok());
        let events = fixture.events();
        let waiting = "chamber: waiting up to 16 s for an MS2 connection left by an earlier connection, for example of a station \
                       that was killed";
        let free = "chamber: an MS2 connection is free after 10.0 s";
        assert_eq!(events, [waiting, waiting, free, free], "each request says so once");
    }

    #[test]
    fn a_request_gives_up_when_no_slave_keeps_a_connection_any_longer() {
        let fixture = Fixture::new();
        fixture.is_free.set(false);
        let (blocks, command) = (fixture.blocks(), fixture.preview());
        for time in [LEFTOVER_TIME - Duration::from_millis(1), RETRY_INTERVAL] {
            fixture.step(|| ());
            fixture.step(|| ());
            assert!(blocks.try_recv().is_err() && command.try_recv().is_err());
            fixture.pass(time);
        }
        let error = |text: String| assert!(text.contains("it has no MS2 connection, or none left"), "{text}");
        fixture.step(|| ());
        fixture.step(|| ());
        error(blocks.try_recv().unwrap().unwrap_err().to_string());
        error(command.try_recv().unwrap().unwrap_err().to_string());
        assert!(
            fixture.events()[3].ends_with("no MS2 connection is free after 16 s: another class 2 master holds them")
        );
    }
}
