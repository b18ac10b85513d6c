//! Masters on a line that can be cloned at any time: octets in bit times, and a fault for each telegram.

use profivac_dp::link::active::{Active, BusParameters, Confirmation, FdlUser, Priority, Request, RingState};
use profivac_dp::link::{Baud, BitTime, CHARACTER_TBIT, Received, Receiver, Station};
use profivac_dp::master::services;
use profivac_wire::Telegram;
use profivac_wire::control::Control;

const BAUD: Baud = Baud::B1500000;
/// The end of the GAP.
const HSA: u8 = 7;
/// T_TR and the pause between two scans of the GAP.
const ROTATION_TBIT: u32 = 3_000;
const SLAVE: u8 = 40;
/// The time after a request at which the slave answers.
const SLAVE_TSDR_TBIT: u64 = 20;
/// The time for which a master without power has none.
const OFF_TBIT: u64 = 2_500;

/// Requests the diagnosis of the slave once in a token visit.
#[derive(Clone)]
struct Asker {
    has_asked: bool,
}

impl FdlUser for Asker {
    fn next_request(&mut self, priority: Priority, _: BitTime) -> Option<Request<'_>> {
        if priority == Priority::Low {
            return None;
        }
        self.has_asked = !self.has_asked;
        self.has_asked.then(|| services::slave_diag(SLAVE))
    }

    fn confirm(&mut self, _: BitTime, _: Confirmation<'_>) {}
}

/// The fault of a telegram that begins.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Fate {
    /// None.
    Received,
    /// No station receives it.
    Lost,
    /// The master with this index does not receive it.
    LostBy(usize),
    /// The first character has a wrong parity.
    Damaged,
    /// Two bits of the address of a token are wrong: a token has no check octet.
    TokenTo(u8),
    /// The sender begins this number of bit times later.
    Late(u64),
    /// The master with this index loses its power as the telegram begins, and has it again later, with its initial state.
    PowerOff(usize),
}

#[derive(Clone)]
struct Master {
    address: u8,
    active: Active<Asker>,
    receiver: Receiver,
    /// What it sends next, and when.
    queue: Option<(BitTime, Vec<u8>)>,
    /// It was polled at all times before this.
    polled: BitTime,
    /// When it has power again; `None` while it has.
    returns: Option<BitTime>,
}

impl Master {
    fn new(address: u8, now: BitTime) -> Self {
        let asker = Asker { has_asked: false };
        let active = Active::new(parameters(address).check().unwrap(), asker, now);
        Self { address, active, receiver: Receiver::new(now), queue: None, polled: now, returns: None }
    }
}

fn parameters(address: u8) -> BusParameters {
    BusParameters { hsa: HSA, gap_factor: 1, rotation_tbit: ROTATION_TBIT, ..BusParameters::new(address, BAUD) }
}

/// A telegram on the line.
#[derive(Clone)]
struct Sending {
    /// The index of the master; `None` is the slave.
    sender: Option<usize>,
    octets: Vec<u8>,
    start: BitTime,
    /// The octets that have ended.
    ended: usize,
    fate: Fate,
    collides: bool,
}

impl Sending {
    fn next_end(&self) -> BitTime {
        self.start + CHARACTER_TBIT * (self.ended as u64 + 1)
    }
}

/// The next event.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
enum Event {
    /// An octet of the telegram with this index ends.
    Octet(usize),
    /// A master has power again.
    Return(usize),
    /// A master begins to send.
    Begin(usize),
    SlaveBegins,
    /// A master is polled.
    Poll(usize),
}

/// Two or three masters and a slave.
#[derive(Clone)]
pub struct Line {
    now: BitTime,
    masters: Vec<Master>,
    slave: Receiver,
    slave_queue: Option<BitTime>,
    line: Vec<Sending>,
    /// The tokens that were sent: receiver and sender.
    tokens: Vec<(u8, u8)>,
    collisions: u32,
}

impl Line {
    /// Masters with these addresses, switched on now.
    pub fn new(addresses: &[u8]) -> Self {
        let now = BitTime(0);
        Self {
            now,
            masters: addresses.iter().map(|address| Master::new(*address, now)).collect(),
            slave: Receiver::new(now),
            slave_queue: None,
            line: Vec::new(),
            tokens: Vec::new(),
            collisions: 0,
        }
    }

    /// The next event until `until`, and its time.
    fn next_event(&self, until: BitTime) -> Option<(BitTime, Event)> {
        let octets = self.line.iter().enumerate().map(|(index, one)| (one.next_end(), Event::Octet(index)));
        let slave = self.slave_queue.map(|at| (at, Event::SlaveBegins));
        let masters = self.masters.iter().enumerate().flat_map(|(index, master)| {
            let is_sending = self.line.iter().any(|one| one.sender == Some(index));
            let is_on = master.returns.is_none();
            let begin =
                master.queue.as_ref().filter(|_| is_on && !is_sending).map(|queue| (queue.0, Event::Begin(index)));
            let wake = master.active.wake_at().filter(|_| is_on).map(|at| (at.max(master.polled), Event::Poll(index)));
            let returns = master.returns.map(|at| (at, Event::Return(index)));
            begin.into_iter().chain(wake).chain(returns)
        });
        let earliest = octets.chain(slave).chain(masters).map(|(at, event)| (at.max(self.now), event)).min();
        earliest.filter(|(at, _)| *at <= until)
    }

    /// Runs until a telegram begins, at the latest until `until`. Returns whether one began.
    pub fn run_to_telegram(&mut self, until: BitTime) -> bool {
        while let Some((at, event)) = self.next_event(until) {
            self.now = at;
            match event {
                Event::Octet(index) => self.octet(index),
                Event::Return(index) => self.masters[index] = Master::new(self.masters[index].address, at),
                Event::SlaveBegins => {
                    self.slave_queue = None;
                    self.begin(None, vec![0xE5]);
                    return true;
                }
                Event::Begin(index) => {
                    let (_, octets) = self.masters[index].queue.take().unwrap();
                    if let [0xDC, da, sa] = octets[..] {
                        self.tokens.push((da, sa));
                    }
                    self.begin(Some(index), octets);
                    return true;
                }
                Event::Poll(index) => {
                    let master = &mut self.masters[index];
                    master.polled = at + 1;
                    if let Some(transmit) = master.active.poll(at) {
                        master.queue = Some((transmit.not_before, transmit.octets.to_vec()));
                    }
                }
            }
        }
        self.now = until;
        false
    }

    fn begin(&mut self, sender: Option<usize>, octets: Vec<u8>) {
        let collides = !self.line.is_empty();
        if collides {
            self.collisions += 1;
            self.line.iter_mut().for_each(|other| other.collides = true);
        }
        self.line.push(Sending { sender, octets, start: self.now, ended: 0, fate: Fate::Received, collides });
    }

    /// The next octet of a telegram ends: every station but the sender receives it as the fault permits.
    fn octet(&mut self, index: usize) {
        let one = &mut self.line[index];
        let (position, sender, fate) = (one.ended, one.sender, one.fate);
        one.ended += 1;
        let is_last = one.ended == one.octets.len();
        let is_damaged = one.collides || fate == Fate::Damaged && position == 0;
        let octet = match (fate, position) {
            (Fate::TokenTo(address), 1) => address,
            _ => one.octets[position],
        };
        if is_last {
            self.line.remove(index);
        }
        let now = self.now;
        for (other, master) in self.masters.iter_mut().enumerate() {
            let is_sending = self.line.iter().any(|one| one.sender == Some(other));
            let is_deaf = fate == Fate::Lost || fate == Fate::LostBy(other) || master.returns.is_some();
            if sender != Some(other) && !is_sending && !is_deaf {
                master.receive(now, octet, is_damaged);
            }
        }
        if sender.is_some() && fate != Fate::Lost {
            self.slave_receives(octet, is_damaged);
        }
        if let Some(index) = sender.filter(|_| is_last) {
            self.masters[index].active.sent(now);
        }
    }

    fn slave_receives(&mut self, octet: u8, is_damaged: bool) {
        if is_damaged {
            self.slave.character_error(self.now);
        } else if let Received::Telegram(Telegram::Data(data)) = self.slave.octet(self.now, octet)
            && data.da == SLAVE
            && matches!(data.control(), Control::Request { .. })
        {
            self.slave_queue = Some(self.now + SLAVE_TSDR_TBIT);
        }
    }

    /// The faults that the telegram that has just begun may have.
    pub fn fates(&self) -> Vec<Fate> {
        let one = self.line.last().expect("a telegram has begun");
        let mut fates = vec![Fate::Received, Fate::Lost, Fate::Damaged];
        if self.masters.len() > 2 {
            fates.extend((0..self.masters.len()).filter(|index| one.sender != Some(*index)).map(Fate::LostBy));
        }
        if let [0xDC, da, sa] = one.octets[..] {
            // To itself, to another master, to an address without a station.
            let others = self.masters.iter().map(|master| master.address).filter(|address| *address != sa);
            fates.extend(others.chain([sa, HSA]).filter(|address| *address != da).map(Fate::TokenTo));
        }
        if one.sender.is_some() {
            // Less and more than the slot time, and more than the time after which a token is missed.
            fates.extend([60, 400, 5_000].map(Fate::Late));
        }
        let is_on = |index: &usize| self.masters[*index].returns.is_none();
        fates.extend((0..self.masters.len()).filter(is_on).map(Fate::PowerOff));
        fates
    }

    /// Applies a fault to the telegram that has just begun.
    pub fn apply(&mut self, fate: Fate) {
        match fate {
            Fate::Late(tbit) => {
                let one = self.line.pop().expect("a telegram has begun");
                let sender = one.sender.expect("a master is late");
                self.masters[sender].queue = Some((self.now + tbit, one.octets));
            }
            Fate::PowerOff(index) => {
                let master = &mut self.masters[index];
                (master.returns, master.queue) = (Some(self.now + OFF_TBIT), None);
                self.line.retain(|one| one.sender != Some(index));
            }
            fate => self.line.last_mut().expect("a telegram has begun").fate = fate,
        }
    }

    /// Runs without faults for this time. Returns after which part of it the ring is complete to the end.
    pub fn run_for(&mut self, tbit: u64) -> u64 {
        let (begin, until) = (self.now, self.now + tbit);
        let mut incomplete = begin;
        while self.run_to_telegram(until) {
            if self.missing().is_some() {
                incomplete = self.now;
            }
        }
        incomplete - begin
    }

    /// A master that is not in the ring, or that does not know all of them; `None` if there is none.
    fn missing(&self) -> Option<&Master> {
        self.masters.iter().find(|master| {
            let knows = |other: &Master| master.active.masters().any(|known| known == other.address);
            let is_complete = self.masters.iter().all(knows) && master.active.masters().count() == self.masters.len();
            !is_complete || master.active.ring_state() != RingState::InRing
        })
    }

    /// Runs for `tbit` bit times, and returns the first thing that is wrong with the ring; `None` if it is complete.
    pub fn fault_of_ring(&mut self, tbit: u64) -> Option<String> {
        (self.tokens, self.collisions) = (Vec::new(), 0);
        self.run_for(tbit);
        if let Some(Master { address, active, .. }) = self.missing() {
            let known: Vec<u8> = active.masters().collect();
            return Some(format!("{address} is {:?} and knows {known:?}", active.ring_state()));
        }
        let mut all: Vec<u8> = self.masters.iter().map(|master| master.address).collect();
        all.sort_unstable();
        let successor = |address: u8| *all.iter().find(|other| **other > address).unwrap_or(&all[0]);
        if let Some((da, sa)) = self.tokens.iter().find(|(da, sa)| *da != successor(*sa)) {
            return Some(format!("{sa} passed the token to {da}"));
        }
        let mut pairs = self.tokens.iter().zip(self.tokens.iter().skip(1));
        if let Some(((da, _), (_, sa))) = pairs.find(|((da, _), (_, sa))| da != sa) {
            return Some(format!("{da} got the token, and {sa} passed one on"));
        }
        if self.tokens.len() < 2 * all.len() || self.collisions > 0 {
            return Some(format!("{} tokens, {} collisions", self.tokens.len(), self.collisions));
        }
        None
    }

    pub fn now(&self) -> BitTime {
        self.now
    }
}

impl Master {
    fn receive(&mut self, now: BitTime, octet: u8, is_damaged: bool) {
        if is_damaged {
            self.receiver.character_error(now);
            self.active.activity(now);
            return;
        }
        let Received::Telegram(telegram) = self.receiver.octet(now, octet) else {
            self.active.activity(now);
            return;
        };
        if let Some(transmit) = self.active.telegram(now, &telegram) {
            self.queue = Some((transmit.not_before, transmit.octets.to_vec()));
        }
    }
}
