//! Stations that share a line, without port and clock.
//!
//! A character from outside is decoded once and delivered to every station. A telegram of a station goes outside and to
//! every other station, never back to its sender. The same [`Line`] serves one gauge on a serial port and a whole segment
//! in memory.

use crate::port::Character;
use profivac_dp::link::{BitTime, CHARACTER_TBIT, Listening, Received, Receiver, Station, Transmit};
use profivac_wire::{BROADCAST, Telegram};
use std::collections::VecDeque;

/// How octets leave the line.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Pace {
    /// They arrive when they are written: a pty, TCP.
    Instant,
    /// A telegram is written at once, and the port takes eleven bit times for an octet: a serial device.
    ByPort,
    /// An octet is written when its last bit would have passed: ptys at the pace of a line, and segments in memory.
    ByLine,
}

/// The most telegrams that wait. chosen: more than all stations of a segment have to send at the same time.
const MAX_WAITING: usize = 256;

/// A telegram of a station that is waiting or being sent.
#[derive(Clone, Debug)]
struct Outgoing {
    /// The index of the station.
    sender: usize,
    not_before: BitTime,
    octets: Vec<u8>,
    /// The positions of octets that noise has changed.
    hits: Vec<usize>,
    /// When its transmission started.
    started: Option<BitTime>,
    /// The number of octets sent.
    octets_sent: usize,
}

/// The telegrams that wait, first to last; more than [`MAX_WAITING`] are dropped.
#[derive(Clone, Debug, Default)]
struct Queue {
    waiting: VecDeque<Outgoing>,
    dropped: u32,
}

impl Queue {
    fn extend(&mut self, telegram: Option<Outgoing>) {
        let Some(telegram) = telegram else { return };
        if self.waiting.len() < MAX_WAITING {
            self.waiting.push_back(telegram);
        } else {
            self.count_dropped();
        }
    }

    const fn count_dropped(&mut self) {
        self.dropped = self.dropped.saturating_add(1);
    }
}

/// Noise that damages octets at random.
#[derive(Clone, Debug)]
struct Noise {
    probability: f64,
    rng: fastrand::Rng,
}

impl Noise {
    /// Whether noise hits the next octet.
    fn hits(&mut self) -> bool {
        self.probability > 0.0 && self.rng.f64() < self.probability
    }

    /// Flips a bit in some octets. Returns their positions.
    fn corrupt(&mut self, octets: &mut [u8]) -> Vec<usize> {
        let mut hits = Vec::new();
        for (position, octet) in octets.iter_mut().enumerate() {
            if self.hits() {
                *octet ^= 1 << self.rng.u8(..8);
                hits.push(position);
            }
        }
        hits
    }
}

/// A collection of stations: a `Vec`, an array, or stations of several types.
pub trait Stations {
    /// The type of a station.
    type Station: Station + ?Sized;

    /// All stations, always in the same order.
    fn all(&self) -> impl Iterator<Item = &Self::Station>;

    /// All stations, mutable, in the same order.
    fn all_mut(&mut self) -> impl Iterator<Item = &mut Self::Station>;
}

impl<S: Station> Stations for Vec<S> {
    type Station = S;

    fn all(&self) -> impl Iterator<Item = &S> {
        self.iter()
    }

    fn all_mut(&mut self) -> impl Iterator<Item = &mut S> {
        self.iter_mut()
    }
}

impl<S: Station, const N: usize> Stations for [S; N] {
    type Station = S;

    fn all(&self) -> impl Iterator<Item = &S> {
        self.iter()
    }

    fn all_mut(&mut self) -> impl Iterator<Item = &mut S> {
        self.iter_mut()
    }
}

/// Stations on one line.
#[derive(Clone, Debug)]
pub struct Line<C> {
    stations: C,
    receiver: Receiver,
    pace: Pace,
    queue: Queue,
    noise: Noise,
    /// How late the answer of a slave may begin, in bit times; `None` is without a limit.
    lateness_limit_tbit: Option<u64>,
    /// Noise has changed the last octet that went outside.
    is_last_hit: bool,
}

impl<C: Stations> Line<C> {
    /// Joins `stations`; `receiver` decodes the characters from outside.
    #[must_use]
    pub fn new(stations: C, receiver: Receiver, pace: Pace) -> Self {
        let noise = Noise { probability: 0.0, rng: fastrand::Rng::with_seed(0) };
        Self { stations, receiver, pace, queue: Queue::default(), noise, lateness_limit_tbit: None, is_last_hit: false }
    }

    /// Drops answers of slaves that would begin more than `tbit` bit times late: on a real line the master has repeated its
    /// request by then, or another station sends.
    #[must_use]
    pub const fn with_lateness_limit(mut self, tbit: u64) -> Self {
        self.lateness_limit_tbit = Some(tbit);
        self
    }

    /// Sets the probability with which noise damages an octet in either direction, 0 to 1. Every run damages the same
    /// octets.
    pub const fn set_noise(&mut self, part: f64) {
        self.noise.probability = part;
    }

    /// The stations.
    pub const fn stations(&self) -> &C {
        &self.stations
    }

    /// The stations, mutable.
    pub const fn stations_mut(&mut self) -> &mut C {
        &mut self.stations
    }

    /// From now on the line counts as idle after `idle_tbit` bit times without a character.
    pub const fn set_idle(&mut self, idle_tbit: u64) {
        self.receiver.set_idle(idle_tbit);
    }

    /// Starts again after the port was lost: drops the telegrams that wait, and decodes with a new `receiver`.
    pub fn reset(&mut self, receiver: Receiver) {
        self.receiver = receiver;
        self.queue.waiting.clear();
    }

    /// Whether noise has changed the last octet that went outside at [`Pace::ByLine`]: a receiver finds its parity wrong.
    #[must_use]
    pub const fn is_last_hit(&self) -> bool {
        self.is_last_hit
    }

    /// The number of damaged telegrams from outside.
    pub const fn damaged_telegrams(&self) -> u32 {
        self.receiver.damaged()
    }

    /// The number of telegrams of the stations that were dropped: too late, or too many.
    pub const fn dropped_telegrams(&self) -> u32 {
        self.queue.dropped
    }

    /// Receives a character from outside that ended at `end`. A telegram that a port has taken ends first if its time is over: the stations
    /// see both in the order in which they were on the line, also when the program runs late.
    pub fn receive(&mut self, end: BitTime, character: Character) {
        if self.pace == Pace::ByPort {
            self.finish_due(end);
        }
        let received = match character {
            Character::Octet(octet) if !self.noise.hits() => self.receiver.octet(end, octet),
            // A flipped bit is a parity error.
            Character::Octet(_) | Character::Error => {
                self.receiver.character_error(end);
                Received::Nothing
            }
        };
        match received {
            Received::Telegram(telegram) => deliver(&mut self.stations, &mut self.queue, None, end, &telegram),
            Received::Nothing | Received::Damaged(_) => self.report_activity(None, end),
        }
    }

    /// Advances to `now`: runs the stations and sends what is due. Appends the octets that go outside to `out`.
    pub fn advance(&mut self, now: BitTime, out: &mut Vec<u8>) {
        self.transmit_due(now, out);
        for (sender, station) in self.stations.all_mut().enumerate() {
            if wake_at(sender, station, &self.queue).is_some_and(|wake_at| wake_at <= now) {
                let transmit = station.poll(now);
                self.queue.extend(transmit.map(|transmit| outgoing(sender, transmit)));
            }
        }
        self.transmit_due(now, out);
    }

    /// When to call [`advance`](Self::advance) next if no character arrives before.
    pub fn wake_at(&self) -> Option<BitTime> {
        let wakes = self.stations.all().enumerate();
        let wakes = wakes.filter_map(|(number, station)| wake_at(number, station, &self.queue));
        let leaves = self.queue.waiting.front().map(|first| self.next_octet(first));
        wakes.chain(leaves).min()
    }

    /// When the first telegram of the queue starts or sends its next octet.
    fn next_octet(&self, first: &Outgoing) -> BitTime {
        match (first.started, self.pace) {
            (None, _) => first.not_before,
            (Some(began), Pace::Instant) => began,
            (Some(began), Pace::ByPort | Pace::ByLine) => began + octets_tbit(first.octets_sent.saturating_add(1)),
        }
    }

    /// Sends the telegrams that are due, one after the other. Two answers at once would be a collision on a real line; this
    /// line has none.
    fn transmit_due(&mut self, now: BitTime, out: &mut Vec<u8>) {
        while self.queue.waiting.front().is_some_and(|first| self.next_octet(first) <= now)
            && let Some(first) = self.queue.waiting.pop_front()
        {
            if self.is_too_late(&first, now) {
                self.queue.count_dropped();
                continue;
            }
            let rest = self.transmit_next(first, now, out);
            rest.into_iter().for_each(|rest| self.queue.waiting.push_front(rest));
        }
    }

    /// Completes the octets of the telegram under way until `now`. The port has all of them.
    fn finish_due(&mut self, now: BitTime) {
        let is_due = |line: &Self| {
            let first = line.queue.waiting.front();
            first.is_some_and(|first| first.started.is_some() && line.next_octet(first) <= now)
        };
        while is_due(self)
            && let Some(first) = self.queue.waiting.pop_front()
        {
            let rest = self.transmit_next(first, now, &mut Vec::new());
            rest.into_iter().for_each(|rest| self.queue.waiting.push_front(rest));
        }
    }

    /// Whether a telegram is an answer whose time has passed by more than the limit.
    fn is_too_late(&self, first: &Outgoing, now: BitTime) -> bool {
        let is_slave = self
            .stations
            .all()
            .nth(first.sender)
            .is_some_and(|station| matches!(station.listening(), Listening::Own(_)));
        let limit = self.lateness_limit_tbit.filter(|_| is_slave && first.started.is_none());
        limit.is_some_and(|limit| now > first.not_before + limit)
    }

    /// Starts a telegram or sends its next octet. Returns the telegram unless it is complete.
    fn transmit_next(&mut self, mut first: Outgoing, now: BitTime, out: &mut Vec<u8>) -> Option<Outgoing> {
        let due = self.next_octet(&first);
        if first.started.is_none() {
            if self.pace == Pace::ByPort {
                self.receiver.own_telegram(now);
            }
            first.started = Some(now);
            first.hits = self.noise.corrupt(&mut first.octets);
            if self.pace != Pace::ByLine {
                out.extend_from_slice(&first.octets);
            }
            return Some(first);
        }
        if self.pace == Pace::ByLine {
            out.extend(first.octets.get(first.octets_sent));
            self.is_last_hit = first.hits.contains(&first.octets_sent);
        }
        first.octets_sent = first.octets_sent.saturating_add(1);
        if self.pace == Pace::Instant || first.octets_sent >= first.octets.len() {
            self.finish_telegram(&first, due);
            return None;
        }
        self.report_activity(Some(first.sender), due);
        Some(first)
    }

    /// Tells the stations that listen to all traffic that another station is sending.
    fn report_activity(&mut self, sender: Option<usize>, end: BitTime) {
        for (number, station) in self.stations.all_mut().enumerate() {
            if Some(number) != sender && station.listening() == Listening::Everything {
                station.activity(end);
            }
        }
    }

    /// Completes a telegram: the sender gets its notification, the others receive it.
    fn finish_telegram(&mut self, first: &Outgoing, end: BitTime) {
        if let Some(sender) = self.stations.all_mut().nth(first.sender) {
            sender.sent(end);
        }
        if !first.hits.is_empty() {
            self.report_activity(Some(first.sender), end);
        } else if let Ok(telegram) = Telegram::parse(&first.octets) {
            deliver(&mut self.stations, &mut self.queue, Some(first.sender), end, &telegram);
        }
    }
}

/// When a station wants to be called. A master whose telegram has not left yet waits for its end: a disturbance that looks like the answer
/// may have come during the transmission, and the next telegram needs an idle line behind this one.
fn wake_at<S: Station + ?Sized>(number: usize, station: &S, queue: &Queue) -> Option<BitTime> {
    let is_sending = || queue.waiting.iter().any(|outgoing| outgoing.sender == number);
    let may_wake = station.listening() != Listening::Everything || !is_sending();
    may_wake.then(|| station.wake_at()).flatten()
}

fn deliver(
    stations: &mut impl Stations,
    queue: &mut Queue,
    sender: Option<usize>,
    end: BitTime,
    telegram: &Telegram<'_>,
) {
    for (number, station) in stations.all_mut().enumerate() {
        if Some(number) != sender && is_delivered_to(telegram, station.listening()) {
            queue.extend(station.telegram(end, telegram).map(|transmit| outgoing(number, transmit)));
        }
    }
}

/// Whether a station receives a telegram.
const fn is_delivered_to(telegram: &Telegram<'_>, listening: Listening) -> bool {
    match (listening, telegram) {
        (Listening::Everything, _) => true,
        (Listening::Own(address), Telegram::Data(data)) => data.da == address || data.da == BROADCAST,
        (Listening::Own(_), Telegram::ShortAck | Telegram::Token { .. }) => false,
    }
}

fn outgoing(sender: usize, transmit: Transmit<'_>) -> Outgoing {
    Outgoing {
        sender,
        not_before: transmit.not_before,
        octets: transmit.octets.to_vec(),
        hits: Vec::new(),
        started: None,
        octets_sent: 0,
    }
}

fn octets_tbit(octets: usize) -> u64 {
    CHARACTER_TBIT.saturating_mul(octets as u64)
}

#[cfg(test)]
mod tests {
    use super::*;
    use profivac_dp::link::T_SYN_TBIT;

    const REQUEST: [u8; 6] = [0x10, 8, 2, 0x49, 0x53, 0x16];
    const ANSWER: [u8; 6] = [0x10, 2, 8, 0, 0x0A, 0x16];

    /// Answers FDL status and records what it receives.
    #[derive(Clone, Debug, Default)]
    struct Recorder {
        address: u8,
        passive: bool,
        notes: Vec<(u64, String)>,
        wake_at: Option<BitTime>,
        octets: Vec<u8>,
    }

    impl Recorder {
        fn at(address: u8) -> Self {
            Self { address, ..Self::default() }
        }

        fn note(&mut self, at: BitTime, what: impl Into<String>) {
            self.notes.push((at.0, what.into()));
        }
    }

    impl Station for Recorder {
        fn telegram(&mut self, end: BitTime, telegram: &Telegram<'_>) -> Option<Transmit<'_>> {
            let Telegram::Data(data) = telegram else { return None };
            self.note(end, format!("{} to {}", data.sa, data.da));
            if data.da != self.address || data.fc != 0x49 {
                return None;
            }
            self.octets = ANSWER.to_vec();
            Some(Transmit { not_before: end + 11, octets: &self.octets })
        }

        fn activity(&mut self, end: BitTime) {
            self.note(end, "busy");
        }

        fn sent(&mut self, end: BitTime) {
            self.note(end, "sent");
        }

        fn poll(&mut self, now: BitTime) -> Option<Transmit<'_>> {
            self.wake_at = None;
            self.octets = REQUEST.to_vec();
            Some(Transmit { not_before: now, octets: &self.octets })
        }

        fn wake_at(&self) -> Option<BitTime> {
            self.wake_at
        }

        fn listening(&self) -> Listening {
            if self.passive { Listening::Own(self.address) } else { Listening::Everything }
        }
    }

    fn line(pace: Pace, stations: Vec<Recorder>) -> Line<Vec<Recorder>> {
        Line::new(stations, Receiver::with_idle(BitTime(0), T_SYN_TBIT), pace)
    }

    fn notes(line: &Line<Vec<Recorder>>, station: usize) -> Vec<(u64, &str)> {
        line.stations()[station].notes.iter().map(|(at, what)| (*at, what.as_str())).collect()
    }

    #[test]
    fn a_master_is_not_called_while_its_own_telegram_leaves() {
        let mut line = line(Pace::ByPort, vec![Recorder { wake_at: Some(BitTime(100)), ..Recorder::at(2) }]);
        let mut out = Vec::new();
        line.advance(BitTime(100), &mut out);
        assert_eq!(out, REQUEST);
        // Something that looks like an answer has come.
        line.stations_mut()[0].wake_at = Some(BitTime(120));
        assert_eq!(line.wake_at(), Some(BitTime(111)), "the end of the first octet");
        line.advance(BitTime(130), &mut out);
        assert_eq!((out.len(), line.stations()[0].wake_at), (REQUEST.len(), Some(BitTime(120))));
        line.advance(BitTime(166), &mut out);
        assert_eq!(notes(&line, 0), [(166, "sent")]);
    }

    #[test]
    fn a_telegram_ends_before_the_characters_that_came_behind_it() {
        let mut line = line(Pace::ByPort, vec![Recorder { wake_at: Some(BitTime(100)), ..Recorder::at(2) }]);
        let mut out = Vec::new();
        line.advance(BitTime(100), &mut out);
        // The program runs late: the telegram ended at 166.
        line.receive(BitTime(150), Character::Octet(0x10));
        line.receive(BitTime(190), Character::Octet(0x10));
        line.advance(BitTime(300), &mut out);
        assert_eq!(notes(&line, 0), [(150, "busy"), (166, "sent"), (190, "busy")]);
        assert_eq!(out, REQUEST);
    }

    /// A measured pause raised the tolerated one beyond the time that a master waits.
    #[test]
    fn octets_before_an_own_telegram_neither_join_nor_hide_its_answer() {
        let octets: [&[Character]; 3] =
            [&[Character::Octet(0x68), Character::Octet(5)], &[Character::Octet(0x00)], &[Character::Error]];
        for before in octets {
            let mut line = line(Pace::ByPort, vec![Recorder { wake_at: Some(BitTime(300)), ..Recorder::at(2) }]);
            for (character, end) in before.iter().zip((200..).step_by(11)) {
                line.receive(BitTime(end), *character);
            }
            line.set_idle(5000);
            line.advance(BitTime(300), &mut Vec::new());
            line.advance(BitTime(366), &mut Vec::new());
            for (octet, end) in ANSWER.iter().zip((400..).step_by(11)) {
                line.receive(BitTime(end), Character::Octet(*octet));
            }
            assert_eq!(notes(&line, 0).last(), Some(&(455, "8 to 2")), "{before:?}");
            assert_eq!(line.damaged_telegrams(), 1, "{before:?}");
        }
    }

    #[test]
    fn a_request_is_answered_not_before_its_time() {
        let mut line = line(Pace::Instant, vec![Recorder::at(8)]);
        REQUEST.iter().for_each(|octet| line.receive(BitTime(100), Character::Octet(*octet)));
        let mut out = Vec::new();
        line.advance(BitTime(110), &mut out);
        assert_eq!((out.as_slice(), line.wake_at()), (&[][..], Some(BitTime(111))));
        line.advance(BitTime(115), &mut out);
        assert_eq!((out.as_slice(), line.wake_at()), (&ANSWER[..], None));
        assert_eq!(notes(&line, 0).last(), Some(&(115, "sent")));
    }

    #[test]
    fn stations_receive_requests_and_answers_of_others_but_not_their_own() {
        let mut line = line(Pace::Instant, vec![Recorder::at(8), Recorder::at(9)]);
        REQUEST.iter().for_each(|octet| line.receive(BitTime(100), Character::Octet(*octet)));
        line.advance(BitTime(111), &mut Vec::new());
        let telegrams = |station| {
            let notes = notes(&line, station);
            notes.into_iter().filter(|(_, what)| *what != "busy").collect::<Vec<_>>()
        };
        assert_eq!(telegrams(0), [(100, "2 to 8"), (111, "sent")]);
        assert_eq!(telegrams(1), [(100, "2 to 8"), (111, "8 to 2")]);
    }

    #[test]
    fn a_station_that_listens_to_its_own_address_gets_no_other_telegram() {
        let mut passive = Recorder::at(9);
        passive.passive = true;
        let mut line = line(Pace::Instant, vec![Recorder::at(8), passive]);
        REQUEST.iter().for_each(|octet| line.receive(BitTime(100), Character::Octet(*octet)));
        for telegram in [
            [0x10, 9, 2, 0x49, 0x54, 0x16],
            // Global_Control without a data unit, to all stations
            [0x10, 127, 2, 0x46, 0xC7, 0x16],
        ] {
            telegram.iter().for_each(|octet| line.receive(BitTime(100), Character::Octet(*octet)));
        }
        line.advance(BitTime(111), &mut Vec::new());
        assert_eq!(notes(&line, 1), [(100, "2 to 9"), (100, "2 to 127"), (111, "sent")]);
    }

    #[test]
    fn a_paced_line_gives_each_octet_its_eleven_bit_times() {
        let mut line = line(Pace::ByLine, vec![Recorder::at(8), Recorder::at(2)]);
        line.stations_mut()[1].wake_at = Some(BitTime(50));
        let mut left = Vec::new();
        while let Some(at) = line.wake_at() {
            let mut out = Vec::new();
            line.advance(at, &mut out);
            left.extend(out.into_iter().map(|octet| (at.0, octet)));
        }
        let request = REQUEST.iter().zip(1..).map(|(octet, number)| (50 + 11 * number, *octet));
        let answer = ANSWER.iter().zip(1..).map(|(octet, number)| (50 + 66 + 11 + 11 * number, *octet));
        assert_eq!(left, request.chain(answer).collect::<Vec<_>>());
        let busy = |from: u64| (1..6).map(move |number| (from + 11 * number, "busy"));
        let answered = [(116, "sent")].into_iter().chain(busy(127)).chain([(193, "8 to 2")]);
        assert_eq!(notes(&line, 1), answered.collect::<Vec<_>>());
        let asked = busy(50).chain([(116, "2 to 8"), (193, "sent")]);
        assert_eq!(notes(&line, 0), asked.collect::<Vec<_>>());
    }

    #[test]
    fn a_port_that_paces_gets_a_telegram_at_once() {
        let mut line = line(Pace::ByPort, vec![Recorder::at(2)]);
        line.stations_mut()[0].wake_at = Some(BitTime(50));
        let mut out = Vec::new();
        line.advance(BitTime(50), &mut out);
        assert_eq!(out, REQUEST);
        line.advance(BitTime(115), &mut out);
        assert_eq!(notes(&line, 0), []);
        line.advance(BitTime(120), &mut out);
        assert_eq!((out.len(), notes(&line, 0)), (REQUEST.len(), vec![(116, "sent")]));
    }

    #[test]
    fn a_broken_character_breaks_the_telegram_for_every_station() {
        let mut line = line(Pace::Instant, vec![Recorder::at(8), Recorder::at(9)]);
        REQUEST[..3].iter().for_each(|octet| line.receive(BitTime(100), Character::Octet(*octet)));
        line.receive(BitTime(100), Character::Error);
        REQUEST[4..].iter().for_each(|octet| line.receive(BitTime(100), Character::Octet(*octet)));
        for station in [0, 1] {
            assert_eq!(notes(&line, station), [(100, "busy"); REQUEST.len()]);
        }
        assert_eq!(line.damaged_telegrams(), 1);
    }

    /// On a real line the master repeats its request meanwhile. A master that is late still has the token.
    #[test]
    fn an_answer_that_is_too_late_is_dropped_and_counted() {
        let mut slave = Recorder::at(8);
        slave.passive = true;
        let line = line(Pace::ByPort, vec![slave, Recorder::at(2)]).with_lateness_limit(100);
        for (now, sent, dropped) in [(211, ANSWER.to_vec(), 0), (212, vec![], 1)] {
            let mut line = line.clone();
            REQUEST.iter().for_each(|octet| line.receive(BitTime(100), Character::Octet(*octet)));
            let mut out = Vec::new();
            line.advance(BitTime(now), &mut out);
            assert_eq!((out, line.dropped_telegrams()), (sent, dropped));
        }
        let mut line = line;
        line.stations_mut()[1].wake_at = Some(BitTime(50));
        let mut out = Vec::new();
        line.advance(BitTime(1000), &mut out);
        assert_eq!(out, REQUEST);
    }

    /// Requests that come faster than a paced line sends the answers do not fill the memory.
    #[test]
    fn a_line_keeps_a_limited_number_of_telegrams() {
        let mut line = line(Pace::ByLine, vec![Recorder::at(8)]);
        for _ in 0..MAX_WAITING + 10 {
            REQUEST.iter().for_each(|octet| line.receive(BitTime(100), Character::Octet(*octet)));
        }
        assert_eq!((line.queue.waiting.len(), line.dropped_telegrams()), (MAX_WAITING, 10));
    }

    #[test]
    fn telegrams_from_before_a_reset_are_neither_answered_nor_completed() {
        let mut line = line(Pace::Instant, vec![Recorder::at(8)]);
        REQUEST.iter().for_each(|octet| line.receive(BitTime(100), Character::Octet(*octet)));
        line.reset(Receiver::with_idle(BitTime(105), T_SYN_TBIT));
        let mut out = Vec::new();
        line.advance(BitTime(200), &mut out);
        assert_eq!(out, [], "an answer to a request from before");
        REQUEST.iter().for_each(|octet| line.receive(BitTime(105 + 33), Character::Octet(*octet)));
        line.advance(BitTime(300), &mut out);
        assert_eq!(out, [], "an answer before the line was idle");
        REQUEST.iter().for_each(|octet| line.receive(BitTime(400), Character::Octet(*octet)));
        line.advance(BitTime(500), &mut out);
        assert_eq!(out, ANSWER);
    }
}
