//! A simulated line with two masters and all twelve devices, and the counts of what the masters send.

use profivac_client::cyclic::{CyclicSlave, ReportedChannels};
use profivac_client::pressure::Pressure;
use profivac_dp::link::active::{Active, BusParameters};
use profivac_dp::link::{Baud, BitTime, CHARACTER_TBIT, Listening, Receiver, Station, T_SYN_TBIT, Transmit};
use profivac_dp::master::{Mode, Settings};
use profivac_explain::divider::Divider;
use profivac_explain::frame::{Chunk, TimeSource};
use profivac_host::session::BusMaster;
use profivac_listen::Observer;
use profivac_sim::character::Character;
use profivac_sim::{Segment, StationHandle};
use profivac_vacuum::Gas;
use profivac_virtual::device::{GasConditions, VirtualDevice};
use profivac_virtual::device_spec::{DEVICES, DeviceSpec};
use profivac_virtual::nonvolatile::NonvolatileMemory;
use profivac_wire::control::{Control, Function, Status};
use profivac_wire::{DataTelegram, Telegram};
use std::collections::BTreeMap;

pub const MASTERS: [u8; 2] = [1, 2];
pub const FIRST: u8 = 10;

/// The requests that a master has sent to one slave.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Sent {
    pub requests: u64,
    pub repeated: u64,
    pub longest: u64,
    /// Message cycles that ended without a valid answer.
    pub lost: u64,
    /// Answers that refuse.
    pub refused: u64,
    sequence: u64,
}

/// A master that counts its requests when they have left.
pub struct CountingMaster {
    pub master: Box<Active<BusMaster>>,
    pub sent: BTreeMap<u8, Sent>,
    last: Vec<u8>,
    /// The telegram that is to leave next or is leaving.
    outgoing: Vec<u8>,
    /// The slave whose request has no valid answer yet.
    pending: Option<u8>,
    /// The telegrams that have left and that no damage was compared with, with their ends; without octets the end of a message cycle.
    left: Vec<(BitTime, Vec<u8>)>,
}

impl CountingMaster {
    /// Counts an answer to the pending request.
    fn count_answer(&mut self, end: BitTime, telegram: &Telegram<'_>) {
        let Some(slave) = self.pending else { return };
        let status = match telegram {
            Telegram::ShortAck => Status::Ok,
            Telegram::Data(DataTelegram { sa, fc, .. }) if *sa == slave => match Control::from_octet(*fc) {
                Control::Response { status, .. } => status,
                Control::Request { .. } => return,
            },
            Telegram::Data(_) | Telegram::Token { .. } => return,
        };
        self.pending = None;
        self.left.push((end, Vec::new()));
        let is_refusal = !matches!(status, Status::Ok | Status::DataLow | Status::DataHigh | Status::NoReply);
        self.sent.entry(slave).or_default().refused += u64::from(is_refusal);
    }

    /// The pending request was given up.
    fn give_up(&mut self) {
        if let Some(slave) = self.pending.take() {
            self.sent.entry(slave).or_default().lost += 1;
        }
    }

    /// Counts the telegram that has left.
    fn count(&mut self) {
        let is_repetition = self.last == self.outgoing;
        self.last.clone_from(&self.outgoing);
        if !is_repetition {
            self.give_up();
        }
        let Ok(Telegram::Data(DataTelegram { da, fc, .. })) = Telegram::parse(&self.last) else { return };
        let Control::Request { function, .. } = Control::from_octet(fc) else { return };
        if !matches!(function, Function::SrdLow | Function::SrdHigh) {
            return;
        }
        self.pending = Some(da);
        let sent = self.sent.entry(da).or_default();
        sent.requests += 1;
        sent.sequence = if is_repetition { sent.sequence + 1 } else { 0 };
        sent.repeated += u64::from(is_repetition);
        sent.longest = sent.longest.max(sent.sequence);
    }
}

impl Station for CountingMaster {
    fn telegram(&mut self, end: BitTime, telegram: &Telegram<'_>) -> Option<Transmit<'_>> {
        self.count_answer(end, telegram);
        let Transmit { not_before, octets } = self.master.telegram(end, telegram)?;
        self.outgoing = octets.to_vec();
        Some(Transmit { not_before, octets: &self.outgoing })
    }

    fn activity(&mut self, end: BitTime) {
        self.master.activity(end);
    }

    fn sent(&mut self, end: BitTime) {
        self.count();
        self.left.push((end, self.last.clone()));
        self.master.sent(end);
    }

    fn poll(&mut self, now: BitTime) -> Option<Transmit<'_>> {
        let Transmit { not_before, octets } = self.master.poll(now)?;
        self.outgoing = octets.to_vec();
        Some(Transmit { not_before, octets: &self.outgoing })
    }

    fn wake_at(&self) -> Option<BitTime> {
        self.master.wake_at()
    }

    fn listening(&self) -> Listening {
        self.master.listening()
    }
}

/// Receives everything and sends nothing.
struct Silent;

impl Station for Silent {
    fn telegram(&mut self, _: BitTime, _: &Telegram<'_>) -> Option<Transmit<'_>> {
        None
    }

    fn poll(&mut self, _: BitTime) -> Option<Transmit<'_>> {
        None
    }

    fn wake_at(&self) -> Option<BitTime> {
        None
    }

    fn listening(&self) -> Listening {
        Listening::Everything
    }
}

/// What a receiver finds damaged: after an error it waits for T_SYN of idle, so what follows without that pause is the same damage.
struct Damage {
    receiver: Receiver,
    is_waiting: bool,
    last_end: BitTime,
    /// The start of each damage that is not attributed yet.
    starts: Vec<BitTime>,
}

impl Damage {
    fn hear(&mut self, end: BitTime, character: Character) {
        let is_idle = end - self.last_end >= T_SYN_TBIT + CHARACTER_TBIT;
        self.last_end = end;
        self.is_waiting &= !is_idle;
        let before = self.receiver.damaged();
        if character.error {
            self.receiver.character_error(end);
        } else {
            let _ = self.receiver.octet(end, character.octet);
        }
        if self.receiver.damaged() > before && !self.is_waiting {
            self.is_waiting = true;
            self.starts.push(BitTime(end.0 - CHARACTER_TBIT));
        }
    }
}

/// The line.
pub struct Line {
    pub baud: Baud,
    pub segment: Segment,
    pub masters: Vec<StationHandle<CountingMaster>>,
    pub devices: Vec<StationHandle<VirtualDevice>>,
    pub slaves: Vec<CyclicSlave>,
    silent: StationHandle<Silent>,
    /// Characters that follow each other, of which more may come.
    held: Option<Chunk>,
    /// Octets that the listeners have got.
    pub octets: u64,
    damage: Damage,
    /// The damage that a receiver has found.
    pub damaged: u64,
    /// The damage of requests to each slave and of its answers.
    pub damaged_of: BTreeMap<u8, u64>,
    /// The traffic, if it is to be replayed.
    pub recorded: Option<Vec<Chunk>>,
}

/// A listener: what receives the line, and the observer behind it.
pub struct Listener {
    divider: Divider,
    pub observer: Observer,
    pub pieces: u64,
}

impl Listener {
    pub fn new(baud: Baud) -> Self {
        let observer = Observer::new(baud, TimeSource::Exact);
        Self { divider: Divider::new(baud, TimeSource::Exact), observer, pieces: 0 }
    }

    pub fn hear(&mut self, chunk: &Chunk) {
        let mut pieces = Vec::new();
        self.divider.push(chunk, &mut pieces);
        self.pieces += pieces.len() as u64;
        pieces.iter().for_each(|piece| self.observer.piece(piece));
    }
}

impl Line {
    pub fn new(baud: Baud) -> Self {
        let slaves: Vec<_> = (FIRST..)
            .zip(&DEVICES)
            .map(|(address, entry)| {
                let model = entry.model;
                // Each device with another of its configurations and units.
                let index = (usize::from(address) + 3) % model.configurations.len();
                let with_inputs = model.configurations.iter().cycle().skip(index).find(|it| it.inputs.is_some());
                let configuration = with_inputs.unwrap_or(model.default_configuration);
                let unit = &model.units[usize::from(address) % model.units.len()];
                CyclicSlave { address, model, configuration, unit, channels: ReportedChannels::default() }
            })
            .collect();
        let mut segment = Segment::new(baud);
        for rule in RULES {
            segment.allow(rule);
        }
        let devices = slaves.iter().map(|slave| segment.attach(device(slave, baud))).collect();
        let silent = segment.attach(Silent);
        segment.take_characters(silent.id());
        let damage =
            Damage { receiver: Receiver::new(BitTime(0)), is_waiting: false, last_end: BitTime(0), starts: Vec::new() };
        let mut line = Self {
            baud,
            segment,
            masters: Vec::new(),
            devices,
            slaves,
            silent,
            held: None,
            octets: 0,
            damage,
            damaged: 0,
            damaged_of: BTreeMap::new(),
            recorded: None,
        };
        for address in MASTERS {
            let master = line.new_master(address);
            line.masters.push(line.segment.attach(master));
        }
        line
    }

    /// The master of a slave: they take turns.
    pub fn owner(slave: u8) -> usize {
        usize::from(slave % 2)
    }

    fn new_master(&self, address: u8) -> CountingMaster {
        let bus = BusParameters { hsa: 3, ..BusParameters::new(address, self.baud) };
        let mut master = BusMaster::on(bus.check().unwrap(), Settings::new(self.baud), self.segment.now());
        let own = |slave: &&CyclicSlave| MASTERS[Self::owner(slave.address)] == address;
        for slave in self.slaves.iter().filter(own) {
            master.user.add(&slave.parameters(self.baud)).unwrap();
        }
        master.user.set_mode(Mode::Operate);
        CountingMaster {
            master: Box::new(master),
            sent: BTreeMap::new(),
            last: Vec::new(),
            outgoing: Vec::new(),
            pending: None,
            left: Vec::new(),
        }
    }

    /// A master is replaced by one that has just been switched on. Its counts continue.
    pub fn restart(&mut self, index: usize) {
        let mut new = self.new_master(MASTERS[index]);
        let old = self.segment.station_mut(self.masters[index]);
        // Its last telegram may still be leaving, and the answer may still come.
        new.pending = old.pending;
        new.outgoing = std::mem::take(&mut old.outgoing);
        new.sent = std::mem::take(&mut old.sent);
        new.left = std::mem::take(&mut old.left);
        *old = new;
    }

    pub fn master(&self, slave: u8) -> &BusMaster {
        &self.segment.station(self.masters[Self::owner(slave)]).master.user
    }

    pub fn sent(&self, slave: u8) -> Sent {
        self.segment.station(self.masters[Self::owner(slave)]).sent.get(&slave).copied().unwrap_or_default()
    }

    /// Runs for some milliseconds and gives the listeners what was on the line.
    pub fn run(&mut self, ms: u64, listeners: &mut [&mut Listener]) {
        self.run_tbit(self.baud.tbit_of_ms(ms), listeners);
    }

    /// Runs for some bit times and gives the listeners what was on the line.
    pub fn run_tbit(&mut self, tbit: u64, listeners: &mut [&mut Listener]) {
        let end = self.segment.now() + tbit;
        while self.segment.run_until(end).is_err() {}
        let mut chunks = Vec::new();
        for (end, character) in self.segment.take_characters(self.silent.id()) {
            self.damage.hear(end, character);
            let start = BitTime(end.0 - CHARACTER_TBIT);
            if self.held.as_ref().is_some_and(|held| end_of(held) != start) {
                chunks.extend(self.held.take());
            }
            let held = self.held.get_or_insert_with(|| Chunk { start: Some(start), ..Chunk::default() });
            if character.error {
                held.errors.push(held.octets.len());
            }
            held.octets.push(character.octet);
        }
        if self.held.as_ref().is_some_and(|held| end_of(held) + CHARACTER_TBIT < self.segment.now()) {
            chunks.extend(self.held.take());
        }
        self.attribute_damage();
        for chunk in chunks {
            self.octets += chunk.octets.len() as u64;
            listeners.iter_mut().for_each(|listener| listener.hear(&chunk));
            if let Some(recorded) = &mut self.recorded {
                recorded.push(chunk);
            }
        }
    }

    /// Runs until no telegram is on the line: masters and listeners have counted the same ones.
    pub fn settle(&mut self, listeners: &mut [&mut Listener]) {
        while self.held.is_some() {
            self.run_tbit(2, listeners);
        }
    }

    /// Adds the damage to the slave of the request that was sent then, or whose answer was due.
    fn attribute_damage(&mut self) {
        let mut left: Vec<(BitTime, Vec<u8>)> = Vec::new();
        for master in &self.masters {
            left.append(&mut self.segment.station_mut(*master).left.clone());
        }
        left.sort();
        let now = self.segment.now();
        // A telegram that is still leaving is not among them.
        let longest_tbit = 256 * CHARACTER_TBIT;
        let is_known = |start: &BitTime| *start + longest_tbit < now;
        let known: Vec<_> = self.damage.starts.iter().copied().filter(is_known).collect();
        self.damage.starts.retain(|start| !is_known(start));
        for start in known {
            self.damaged += 1;
            let begin = |(end, octets): &&(BitTime, Vec<u8>)| BitTime(end.0 - CHARACTER_TBIT * octets.len() as u64);
            // A receiver that has found an error is not ready for a telegram before T_SYN is over.
            let until = start + CHARACTER_TBIT + T_SYN_TBIT;
            let Some((_, octets)) = left.iter().rev().find(|sent| begin(sent) < until) else { continue };
            let Ok(Telegram::Data(DataTelegram { da, fc, .. })) = Telegram::parse(octets) else { continue };
            if let Control::Request { function: Function::SrdLow | Function::SrdHigh, .. } = Control::from_octet(fc) {
                *self.damaged_of.entry(da).or_default() += 1;
            }
        }
        let first = self.damage.starts.first().copied().unwrap_or(now);
        for master in &self.masters {
            let left = &mut self.segment.station_mut(*master).left;
            let old = left.iter().rposition(|(end, _)| *end + longest_tbit < first).unwrap_or(0);
            left.drain(..old);
        }
    }
}

fn end_of(chunk: &Chunk) -> BitTime {
    chunk.start.unwrap() + CHARACTER_TBIT * chunk.octets.len() as u64
}

fn device(slave: &CyclicSlave, baud: Baud) -> VirtualDevice {
    let spec: DeviceSpec = format!("{}@{}", slave.model.name, slave.address).parse().unwrap();
    let gauge = spec.build(NonvolatileMemory::volatile(), baud).unwrap();
    let pa = |pa| Pressure::from_pa(pa);
    let around =
        GasConditions { pressure: pa(1e-3 * f64::from(slave.address)), atmosphere: pa(101_325.0), gas: Gas::N2 };
    VirtualDevice::new(gauge, slave.address, baud, around)
}

use profivac_sim::Rule;

/// The referee checks other tests; here stations break its rules while noise and restarts confuse them.
const RULES: [Rule; 15] = [
    Rule::Collision,
    Rule::NoTelegram,
    Rule::Gap,
    Rule::Syn,
    Rule::Id1,
    Rule::Id2,
    Rule::BeforeSlotTime,
    Rule::Early,
    Rule::Late,
    Rule::Slot,
    Rule::Unrequested,
    Rule::SecondAnswer,
    Rule::NoToken,
    Rule::SecondToken,
    Rule::Ring,
];
