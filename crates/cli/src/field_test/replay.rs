//! A line that answers as the slaves of an archive did.
//!
//! Each recorded request has its recorded answers in their order. The last one is repeated, because a master may ask more
//! often than it did. A request that the archive does not contain is not answered, and is counted.

use super::archive::Archive;
use super::capture::{self, Packet, pieces};
use super::redact::Redaction;
use super::report::{Report, Slave, Step, text};
use crate::failure::Failure;
use profivac_host::port::{Character, Direction, Port, PortError};
use profivac_host::readiness::Readiness;
use serde_json::Value;
use std::collections::{HashMap, VecDeque};
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::{Arc, Mutex, PoisonError};
use std::time::Duration;

/// The answers to one request, in their order.
type Answers = VecDeque<Vec<Character>>;

/// The answers to each request of a step.
type StepAnswers = HashMap<Vec<u8>, Answers>;

/// The recorded steps.
pub struct Replay {
    steps: VecDeque<StepAnswers>,
    /// The step that runs. Its ports share the answers.
    current: Arc<Mutex<StepAnswers>>,
    redaction: Redaction,
    unknown: Arc<AtomicUsize>,
}

impl Replay {
    /// The steps of an archive.
    ///
    /// # Errors
    /// A usage error if the capture is damaged or does not fit the report.
    pub fn of(archive: &Archive) -> Result<Self, Failure> {
        let damaged = |reason: &str| Failure::usage(format!("the capture of the archive is damaged: {reason}"));
        let packets = capture::read(&archive.capture, archive.rate()?).map_err(|error| damaged(&error.to_string()))?;
        let mut rest = packets.as_slice();
        let mut steps = VecDeque::new();
        for step in &archive.report.steps {
            let split = rest.split_at_checked(step.packets);
            let (packets, behind) = split.ok_or_else(|| damaged("it has fewer packets than the report"))?;
            steps.push_back(answers(packets));
            rest = behind;
        }
        let redaction = Redaction::new(archive.report.options.with_serial_numbers, None);
        Ok(Self { steps, current: Arc::default(), redaction, unknown: Arc::default() })
    }

    /// The next step begins.
    pub fn begin_step(&mut self) {
        self.current = Arc::new(Mutex::new(self.steps.pop_front().unwrap_or_default()));
    }

    /// A port on the line of the present step.
    pub fn open(&self) -> Box<dyn Port> {
        Box::new(ReplayPort {
            answers: Arc::clone(&self.current),
            redaction: self.redaction,
            unknown: Arc::clone(&self.unknown),
            pending: Vec::new(),
            now: Duration::ZERO,
        })
    }

    /// The number of requests so far that the archive does not contain.
    pub fn unknown_requests(&self) -> Arc<AtomicUsize> {
        Arc::clone(&self.unknown)
    }
}

/// The packets after each sent packet, before the next one.
fn answers(packets: &[Packet]) -> StepAnswers {
    let mut answers = StepAnswers::new();
    let mut request: Option<Vec<u8>> = None;
    for packet in packets {
        match packet.direction {
            Direction::Sent => {
                let octets = packet.entry.octets.to_vec();
                answers.entry(octets.clone()).or_default().push_back(Vec::new());
                request = Some(octets);
            }
            Direction::Received => {
                let answer = request.as_ref().and_then(|request| answers.get_mut(request)).and_then(VecDeque::back_mut);
                answer.into_iter().for_each(|answer| answer.extend(characters(packet)));
            }
        }
    }
    answers
}

fn characters(packet: &Packet) -> impl Iterator<Item = Character> + '_ {
    packet.entry.octets.iter().enumerate().map(|(index, octet)| {
        if packet.entry.errors.contains(&index) { Character::Error } else { Character::Octet(*octet) }
    })
}

/// A port without a rate that answers at once. Its time passes only while the program waits, so a slow computer changes no result.
struct ReplayPort {
    answers: Arc<Mutex<StepAnswers>>,
    redaction: Redaction,
    unknown: Arc<AtomicUsize>,
    pending: Vec<Character>,
    now: Duration,
}

impl ReplayPort {
    fn answer(&mut self, request: &[u8]) {
        let request = self.redaction.of(Direction::Sent, request);
        let mut answers = self.answers.lock().unwrap_or_else(PoisonError::into_inner);
        let Some(answers) = answers.get_mut(&request) else {
            self.unknown.fetch_add(1, Ordering::Relaxed);
            return;
        };
        let next = if answers.len() > 1 { answers.pop_front() } else { answers.front().cloned() };
        self.pending.extend(next.unwrap_or_default());
    }
}

impl Port for ReplayPort {
    fn name(&self) -> &str {
        "archive"
    }

    fn readiness(&self) -> Vec<Readiness<'_>> {
        Vec::new()
    }

    fn receive(&mut self, characters: &mut Vec<Character>) -> Result<(), PortError> {
        characters.append(&mut self.pending);
        Ok(())
    }

    fn send(&mut self, octets: &[u8]) -> Result<(), PortError> {
        let all: Vec<_> = octets.iter().copied().map(Character::Octet).collect();
        for range in pieces(&all) {
            self.answer(octets.get(range).unwrap_or_default());
        }
        Ok(())
    }

    fn simulated_time(&self) -> Option<Duration> {
        Some(self.now)
    }

    fn simulate(&mut self, at_most: Duration) {
        if self.pending.is_empty() {
            self.now = self.now.saturating_add(at_most);
        }
    }
}

/// The outcome of a rule whose requests are not in the archive.
pub const NOT_RECORDED: &str = "not-recorded";

fn names(rules: &[Value]) -> impl Iterator<Item = &str> {
    rules.iter().map(|rule| text(rule, "name"))
}

/// How a replay differs from its archive.
#[derive(Debug, Default)]
pub struct Comparison {
    /// One sentence for each difference.
    pub differences: Vec<String>,
    /// Rules with the same outcome.
    pub same_rules: usize,
    /// Rules of an archive that was made with others.
    pub unknown_rules: usize,
}

impl Comparison {
    /// Compares results; times differ with every run.
    pub fn of(recorded: &Report, replayed: &Report) -> Self {
        let mut comparison = Self::default();
        let names =
            |report: &Report| report.steps.iter().map(|step: &Step| (step.name, step.address)).collect::<Vec<_>>();
        comparison.check("the steps", &names(recorded), &names(replayed));
        comparison.check("the stations", &recorded.stations, &replayed.stations);
        let addresses = |report: &Report| report.slaves.iter().map(|slave| slave.address).collect::<Vec<_>>();
        comparison.check("the slaves", &addresses(recorded), &addresses(replayed));
        for (recorded, replayed) in recorded.slaves.iter().zip(&replayed.slaves) {
            comparison.slave(recorded, replayed);
        }
        comparison
    }

    fn slave(&mut self, recorded: &Slave, replayed: &Slave) {
        let of = |what: &str| format!("{what} of slave {}", recorded.address);
        self.check(&of("the diagnosis"), &recorded.diagnosis, &replayed.diagnosis);
        self.check(&of("the configuration"), &recorded.configuration, &replayed.configuration);
        self.check(&of("the note about the rules"), &recorded.rules_note, &replayed.rules_note);
        self.rules(&of("the rules"), &recorded.rules, &replayed.rules);
        let counts = |slave: &Slave| {
            slave.figures.as_ref().map(|figures| {
                (figures.requests, figures.answered, figures.damaged, figures.missing, figures.lost_characters)
            })
        };
        let what = of("requests, answers, damaged and missing answers, and lost characters");
        self.check(&what, &counts(recorded), &counts(replayed));
        self.check(&of("the note about the figures"), &recorded.figures_note, &replayed.figures_note);
    }

    /// The answers in an archive fit the requests of the rules with which it was made. Other rules cannot be compared.
    fn rules(&mut self, what: &str, recorded: &[Value], replayed: &[Value]) {
        if !names(recorded).eq(names(replayed)) {
            self.unknown_rules = self.unknown_rules.saturating_add(replayed.len());
            return;
        }
        for (recorded, replayed) in recorded.iter().zip(replayed) {
            let outcome = text(replayed, "outcome");
            let before = self.differences.len();
            self.check(&format!("{} of {what}", text(recorded, "name")), &text(recorded, "outcome"), &outcome);
            self.same_rules = self.same_rules.saturating_add(usize::from(self.differences.len() == before));
        }
    }

    /// A difference is shown as the report has it.
    fn check<T: PartialEq + serde::Serialize>(&mut self, what: &str, recorded: &T, replayed: &T) {
        if recorded != replayed {
            let [recorded, replayed] = [recorded, replayed].map(|result| serde_json::json!(result));
            self.differences.push(format!("{what}: {recorded} in the archive, {replayed} in the replay"));
        }
    }
}

#[cfg(test)]
#[allow(clippy::unwrap_used, reason = "a test")]
mod tests {
    use super::*;
    use profivac_dp::link::BitTime;
    use profivac_sim::trace::Entry;

    const REQUEST: [u8; 6] = [0x10, 5, 0, 0x49, 0x4E, 0x16];

    fn packet(direction: Direction, octets: &[u8], errors: &[usize]) -> Packet {
        Packet { direction, entry: Entry::new(BitTime(0), octets, errors.to_vec()) }
    }

    #[test]
    fn a_request_gets_its_answers_in_their_order_and_the_last_one_again() {
        let packets = [
            packet(Direction::Sent, &REQUEST, &[]),
            packet(Direction::Received, &[1, 0], &[1]),
            packet(Direction::Sent, &REQUEST, &[]),
            packet(Direction::Sent, &REQUEST, &[]),
            packet(Direction::Received, &[2], &[]),
            packet(Direction::Received, &[3], &[]),
        ];
        let steps = [answers(&packets)].into();
        let mut replay = Replay { steps, current: Arc::default(), redaction: Redaction::NONE, unknown: Arc::default() };
        replay.begin_step();
        let mut port = replay.open();
        let mut ask = |request: &[u8]| {
            let mut answer = Vec::new();
            port.send(request).unwrap();
            port.receive(&mut answer).unwrap();
            answer
        };
        assert_eq!(ask(&REQUEST), [Character::Octet(1), Character::Error]);
        assert_eq!(ask(&REQUEST), []);
        // A token before the request is a packet of its own.
        let last = [Character::Octet(2), Character::Octet(3)];
        assert_eq!(ask(&[&[0xDC, 0, 0][..], &REQUEST].concat()), last);
        assert_eq!(ask(&REQUEST), last);
        assert_eq!(replay.unknown_requests().load(Ordering::Relaxed), 1);
    }
}
