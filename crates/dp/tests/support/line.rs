//! A line in bit times: one master, some slaves, and the faults of the test. Every octet reaches every station that does not
//! send; two stations that send at once fail the test.

use super::plain::Plain;
use super::{is_housekeeping, text};
use profivac_dp::link::active::{Active, FdlUser};
use profivac_dp::link::{Baud, BitTime, CHARACTER_TBIT, Received, Receiver, Station, Transmit};
use profivac_dp::slave::Slave;

/// The sender of a telegram.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum From {
    Master,
    /// The slave with this place in [`Line::slaves`].
    Slave(usize),
}

/// One telegram that was on the line, as it left its sender.
#[derive(Clone, Debug)]
pub struct Entry {
    pub from: From,
    pub start: BitTime,
    pub end: BitTime,
    pub octets: Vec<u8>,
}

/// A telegram that a station returned, with its earliest start.
type Given = Option<(BitTime, Vec<u8>)>;

/// Changes a telegram on the line to other octets, or to none.
type TelegramFault = Box<dyn FnMut(From, &[u8]) -> Vec<u8>>;

/// A telegram on its way.
struct Flight {
    entry: Entry,
    /// The octets that arrive.
    received: Vec<u8>,
    /// The number of octets that have arrived.
    arrived: usize,
}

pub struct Line<R> {
    pub master: Active<R>,
    master_receiver: Receiver,
    pub slaves: Vec<Slave<Plain>>,
    receivers: Vec<Receiver>,
    flight: Option<Flight>,
    pub telegram_fault: Option<TelegramFault>,
    pub trace: Vec<Entry>,
    pub now: BitTime,
    /// The number of deadlines since time advanced. A poll ends a deadline.
    deadlines_since: u32,
}

/// The most deadlines at one bit time that all stations of a test can have.
const DEADLINES: u32 = 10_000;

impl<R: FdlUser> Line<R> {
    pub fn new(master: Active<R>) -> Self {
        Self {
            master,
            master_receiver: Receiver::new(BitTime(0)),
            slaves: Vec::new(),
            receivers: Vec::new(),
            flight: None,
            telegram_fault: None,
            trace: Vec::new(),
            now: BitTime(0),
            deadlines_since: 0,
        }
    }

    pub fn attach(&mut self, device: Plain, address: u8) {
        self.slaves.push(Slave::new(device, address, Baud::B1500000));
        self.receivers.push(Receiver::new(self.now));
    }

    /// Lets the bus run until `done`, and fails the test if that takes longer than `limit_tbit`.
    pub fn run_until(&mut self, limit_tbit: u64, mut done: impl FnMut(&mut Self) -> bool) {
        let limit = self.now + limit_tbit;
        while !done(self) {
            if self.now > limit {
                self.fail("this takes too long");
            }
            self.step();
        }
    }

    pub fn run_for(&mut self, tbit: u64) {
        let end = self.now + tbit;
        while self.now < end {
            self.step();
        }
    }

    /// One character, or one deadline.
    fn step(&mut self) {
        let character = self.flight.as_ref().map(|flight| flight.entry.start + (flight.arrived as u64 + 1) * 11);
        let wake = self.slaves.iter().filter_map(Station::wake_at).chain(self.master.wake_at()).min();
        match (character, wake) {
            (Some(character), wake) if wake.is_none_or(|wake| character <= wake) => self.character(character),
            (_, Some(wake)) => self.deadline(self.now.max(wake)),
            _ => self.fail("no station has a deadline"),
        }
    }

    fn deadline(&mut self, now: BitTime) {
        self.deadlines_since = if now == self.now { self.deadlines_since + 1 } else { 0 };
        if self.deadlines_since > DEADLINES {
            self.fail("a deadline is never over");
        }
        self.now = now;
        let mut all = vec![(From::Master, given(self.master.poll(now)))];
        for (index, slave) in self.slaves.iter_mut().enumerate() {
            all.push((From::Slave(index), given(slave.poll(now))));
        }
        self.take_off(all);
    }

    /// The next octet of the telegram on the line has ended.
    fn character(&mut self, end: BitTime) {
        self.now = end;
        let Some(mut flight) = self.flight.take() else { return };
        let octet = flight.received.get(flight.arrived).copied();
        flight.arrived += 1;
        let from = flight.entry.from;
        // A telegram that does not arrive takes its normal time.
        let length = if flight.received.is_empty() { flight.entry.octets.len() } else { flight.received.len() };
        let over = flight.arrived >= length;
        if over {
            match from {
                From::Master => self.master.sent(end),
                From::Slave(index) => self.slaves[index].sent(end),
            }
        } else {
            self.flight = Some(flight);
        }
        let Some(octet) = octet else { return };
        let mut answers = Vec::new();
        if from != From::Master {
            answers.push((From::Master, give(&mut self.master, &mut self.master_receiver, end, octet)));
        }
        for (index, slave) in self.slaves.iter_mut().enumerate().filter(|(index, _)| from != From::Slave(*index)) {
            answers.push((From::Slave(index), give(slave, &mut self.receivers[index], end, octet)));
        }
        self.take_off(answers);
    }

    fn take_off(&mut self, telegrams: Vec<(From, Given)>) {
        for (from, (not_before, octets)) in telegrams.into_iter().filter_map(|(from, given)| Some((from, given?))) {
            if self.flight.is_some() {
                self.fail(&format!("{from:?} speaks at {not_before} while another does: {}", text(&octets)));
            }
            let start = not_before.max(self.now);
            let end = start + octets.len() as u64 * CHARACTER_TBIT;
            let received = self
                .telegram_fault
                .as_mut()
                .map_or_else(|| octets.clone(), |telegram_fault| telegram_fault(from, &octets));
            let entry = Entry { from, start, end, octets };
            self.trace.push(entry.clone());
            self.flight = Some(Flight { entry, received, arrived: 0 });
        }
    }

    /// The messages and answers from entry `first` of the trace on.
    pub fn messages(&self, first: usize) -> Vec<String> {
        let of_interest = self.trace[first..].iter().filter(|entry| !is_housekeeping(&entry.octets));
        of_interest.map(|entry| text(&entry.octets)).collect()
    }

    fn fail(&self, what: &str) -> ! {
        for entry in self.trace.iter().rev().take(30).rev() {
            println!("{:>9} {:>9} {:?}: {}", entry.start, entry.end, entry.from, text(&entry.octets));
        }
        panic!("at {}: {what}", self.now);
    }
}

fn given(transmit: Option<Transmit<'_>>) -> Given {
    transmit.map(|transmit| (transmit.not_before, transmit.octets.to_vec()))
}

/// One octet for one station.
fn give(station: &mut impl Station, receiver: &mut Receiver, end: BitTime, octet: u8) -> Given {
    match receiver.octet(end, octet) {
        Received::Telegram(telegram) => given(station.telegram(end, &telegram)),
        Received::Nothing | Received::Damaged(_) => {
            station.activity(end);
            None
        }
    }
}
