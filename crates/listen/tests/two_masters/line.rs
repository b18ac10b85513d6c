//! A simulated line with two masters and all twelve devices, and the counts of what the masters send.

use profivac_client::cyclic::{CyclicSlave, ReportedChannels};
use profivac_client::pressure::Pressure;
use profivac_dp::link::active::{Active, BusParameters};
use profivac_dp::link::{Baud, BitTime, CHARACTER_TBIT, Listening, Station, T_SYN_TBIT, Transmit};
use profivac_dp::master::{Mode, Settings};
use profivac_explain::divider::Divider;
use profivac_explain::frame::{Chunk, TimeSource};
use profivac_host::session::BusMaster;
use profivac_listen::Observer;
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

/// A master that counts its requests before they reach the line.
pub struct CountingMaster {
    pub master: Box<Active<BusMaster>>,
    pub sent: BTreeMap<u8, Sent>,
    last: Vec<u8>,
    /// The slave whose request has no valid answer yet.
    pending: Option<u8>,
}

impl CountingMaster {
    /// Counts an answer to the pending request.
    fn count_answer(&mut self, telegram: &Telegram<'_>) {
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
        let is_refusal = !matches!(status, Status::Ok | Status::DataLow | Status::DataHigh | Status::NoReply);
        self.sent.entry(slave).or_default().refused += u64::from(is_refusal);
    }

    /// The pending request was given up.
    fn give_up(&mut self) {
        if let Some(slave) = self.pending.take() {
            self.sent.entry(slave).or_default().lost += 1;
        }
    }

    fn count(&mut self, octets: &[u8]) {
        let is_repetition = self.last == octets;
        self.last.clear();
        self.last.extend_from_slice(octets);
        if !is_repetition {
            self.give_up();
        }
        let Ok(Telegram::Data(DataTelegram { da, fc, .. })) = Telegram::parse(octets) else { return };
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
        self.count_answer(telegram);
        let Transmit { not_before, octets } = self.master.telegram(end, telegram)?;
        let octets = octets.to_vec();
        self.count(&octets);
        Some(Transmit { not_before, octets: &self.last })
    }

    fn activity(&mut self, end: BitTime) {
        self.master.activity(end);
    }

    fn sent(&mut self, end: BitTime) {
        self.master.sent(end);
    }

    fn poll(&mut self, now: BitTime) -> Option<Transmit<'_>> {
        let Transmit { not_before, octets } = self.master.poll(now)?;
        let octets = octets.to_vec();
        self.count(&octets);
        Some(Transmit { not_before, octets: &self.last })
    }

    fn wake_at(&self) -> Option<BitTime> {
        self.master.wake_at()
    }

    fn listening(&self) -> Listening {
        self.master.listening()
    }
}

/// The line.
pub struct Line {
    pub baud: Baud,
    pub segment: Segment,
    pub masters: Vec<StationHandle<CountingMaster>>,
    pub devices: Vec<StationHandle<VirtualDevice>>,
    pub slaves: Vec<CyclicSlave>,
    /// The start of the next entry of the trace that no listener has got.
    fed: BitTime,
    /// Octets on the line.
    pub octets: u64,
    /// Transmissions on the line with a character that was received with an error, or that are no telegram. A receiver that has found an
    /// error waits for T_SYN of idle, so what follows without that pause is the same damage.
    pub damaged: u64,
    damage_end: Option<BitTime>,
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
                let place = (usize::from(address) + 3) % model.configurations.len();
                let with_inputs = model.configurations.iter().cycle().skip(place).find(|it| it.inputs.is_some());
                let configuration = with_inputs.unwrap_or(model.default_configuration);
                let unit = &model.units[usize::from(address) % model.units.len()];
                CyclicSlave { address, model, configuration, unit, channels: ReportedChannels::default() }
            })
            .collect();
        let mut segment = Segment::new(baud);
        segment.set_trace_length(4096);
        for rule in RULES {
            segment.allow(rule);
        }
        let devices = slaves.iter().map(|slave| segment.attach(device(slave, baud))).collect();
        let mut line = Self {
            baud,
            segment,
            masters: Vec::new(),
            devices,
            slaves,
            fed: BitTime(0),
            octets: 0,
            damaged: 0,
            damage_end: None,
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
        CountingMaster { master: Box::new(master), sent: BTreeMap::new(), last: Vec::new(), pending: None }
    }

    /// A master is replaced by one that has just been switched on. Its counts continue.
    pub fn restart(&mut self, place: usize) {
        let mut new = self.new_master(MASTERS[place]);
        let old = self.segment.station_mut(self.masters[place]);
        // The answer to its last request may still come.
        new.pending = old.pending;
        new.sent = std::mem::take(&mut old.sent);
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
        let now = self.segment.now();
        let entries = self.segment.trace().entries.iter();
        assert!(
            self.segment.trace().entries.len() < 4096 || self.segment.trace().entries[0].start < self.fed,
            "the trace is too short"
        );
        let mut fed = self.fed;
        for entry in entries.filter(|entry| entry.start >= self.fed && entry.end() <= now) {
            let octets = entry.octets.to_vec();
            self.octets += octets.len() as u64;
            let is_damaged = !entry.errors.is_empty() || Telegram::parse(&octets).is_err();
            let is_same = self.damage_end.is_some_and(|end| entry.start - end < T_SYN_TBIT);
            self.damaged += u64::from(is_damaged && !is_same);
            self.damage_end = is_damaged.then_some(entry.start + CHARACTER_TBIT * octets.len() as u64);
            let chunk = Chunk { start: Some(entry.start), octets, errors: entry.errors.clone(), is_continued: false };
            listeners.iter_mut().for_each(|listener| listener.hear(&chunk));
            if let Some(recorded) = &mut self.recorded {
                recorded.push(chunk);
            }
            fed = entry.start + 1;
        }
        self.fed = fed;
    }
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
