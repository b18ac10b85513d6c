//! The operations of profivac through models of serial adapters, in simulated time: docs/adapters.md has the table.
//!
//! A model has the documented behaviour of an adapter: the packets of its USB endpoint or the trigger of its FIFO, the time for which it
//! holds characters back, the USB frames, and lost characters. The other end of the line is a virtual gauge that keeps the
//! rules of the line in bit times. Nothing depends on the speed of the computer.

#![allow(clippy::unwrap_used, clippy::panic, reason = "a test")]

use profivac_client::cyclic::CyclicSlave;
use profivac_client::{Gauge, identify, settings};
use profivac_conform::dialogue::SlaveUnderTest;
use profivac_conform::expected::Reason;
use profivac_conform::{CheckResult, Outcome, PortLink, run as run_checks};
use profivac_dp::link::active::BusParameters;
use profivac_dp::link::{Baud, BitTime, CHARACTER_TBIT, Receiver};
use profivac_dp::master::services;
use profivac_host::clock::{duration_of, tbit_of};
use profivac_host::line::{Line, Pace};
use profivac_host::port::{Character, Delivery, LateAnswerRemedy, Notice, Port, PortError};
use profivac_host::readiness::Readiness;
use profivac_host::scan;
use profivac_host::session::{BusSession, Reply, bus_parameters};
use profivac_vacuum::Gas;
use profivac_virtual::device::{GasConditions, VirtualDevice};
use profivac_virtual::device_spec::DeviceSpec;
use profivac_virtual::nonvolatile::NonvolatileMemory;
use std::collections::VecDeque;
use std::ops::ControlFlow;
use std::path::Path;
use std::time::Duration;

const ADDRESS: u8 = 5;

/// A full-speed USB device transfers data in frames of this duration. USB 2.0, 5.2.3.
const FRAME: Duration = Duration::from_millis(1);

/// When an adapter gives received characters to the computer.
#[derive(Clone, Copy)]
enum Holding {
    /// A UART: when `trigger` characters are there, or four characters after the last one.
    Fifo { trigger: usize },
    /// USB: when a packet of this size is full, or `hold` after the first character of it; both in the next frame.
    Packets { size: usize, hold: Duration },
}

/// The received characters that an adapter loses.
#[derive(Clone, Copy)]
enum Loss {
    None,
    /// Every character with a number that this divides.
    Every(u64),
    /// One character, the first being 1.
    One(u64),
    /// All characters up to this one.
    UpTo(u64),
}

impl Loss {
    const fn contains(self, number: u64) -> bool {
        match self {
            Self::None => false,
            Self::Every(every) => number.is_multiple_of(every),
            Self::One(one) => number == one,
            Self::UpTo(last) => number <= last,
        }
    }
}

/// An adapter with its driver.
#[derive(Clone, Copy)]
struct Adapter {
    name: &'static str,
    holding: Holding,
    loses: Loss,
    /// What profivac knows from the driver.
    delivery: Delivery,
}

const fn usb(name: &'static str, size: usize, hold_ms: u64, delivery: Delivery) -> Adapter {
    let holding = Holding::Packets { size, hold: Duration::from_millis(hold_ms) };
    Adapter { name, holding, loses: Loss::None, delivery }
}

/// What profivac assumes about a driver without a latency timer.
const UNKNOWN: Delivery = Delivery::Usb { hold: Duration::from_millis(16), is_known: false };

const fn timer(ms: u64) -> Delivery {
    Delivery::Usb { hold: Duration::from_millis(ms), is_known: true }
}

/// The sizes of the packets are those of the bulk endpoints, less the two octets of status that an FT232 adds. The drivers of
/// CP210x, PL2303 and CH341 set no timer, so each has two rows: characters leave in the next frame, or as late as profivac
/// assumes.
const ADAPTERS: [Adapter; 11] = [
    Adapter {
        name: "16550A, `8250`, trigger 8",
        holding: Holding::Fifo { trigger: 8 },
        loses: Loss::None,
        delivery: Delivery::Fifo { trigger: Some(8) },
    },
    usb("FT232, `ftdi_sio`, latency 1 ms", 62, 1, timer(1)),
    usb("FT232, `ftdi_sio`, latency 16 ms", 62, 16, timer(16)),
    usb("CP210x, `cp210x`, each frame", 64, 0, UNKNOWN),
    usb("CP210x, `cp210x`, held for 16 ms", 64, 16, UNKNOWN),
    usb("PL2303, `pl2303`, each frame", 64, 0, UNKNOWN),
    usb("PL2303, `pl2303`, held for 16 ms", 64, 16, UNKNOWN),
    usb("CH341, `ch341`, each frame", 32, 0, UNKNOWN),
    usb("CH341, `ch341`, held for 16 ms", 32, 16, UNKNOWN),
    Adapter { loses: Loss::Every(500), ..usb("any USB adapter that loses one character of 500", 64, 1, UNKNOWN) },
    usb("any USB adapter that holds for 40 ms, longer than profivac assumes", 64, 40, UNKNOWN),
];

/// An adapter whose line has a virtual BCG450.
struct ModelPort {
    adapter: Adapter,
    baud: Baud,
    line: Line<Vec<VirtualDevice>>,
    now: Duration,
    /// Octets of the computer and the times at which they have left.
    leaving: VecDeque<(Duration, u8)>,
    /// Octets in the adapter and the times at which it received them.
    held: VecDeque<(Duration, u8)>,
    received: u64,
    delivered: Vec<Character>,
}

impl ModelPort {
    fn new(adapter: Adapter, baud: Baud) -> Self {
        let spec: DeviceSpec = format!("bcg450@{ADDRESS}").parse().unwrap();
        let unit = spec.build(NonvolatileMemory::volatile(), baud).unwrap();
        let pressure = |mbar| profivac_client::pressure::Pressure::from_mbar(mbar);
        let around = GasConditions { pressure: pressure(1e-3), atmosphere: pressure(1013.25), gas: Gas::N2 };
        let device = VirtualDevice::new(unit, ADDRESS, baud, around);
        Self {
            adapter,
            baud,
            line: Line::new(vec![device], Receiver::new(BitTime(0)), Pace::ByLine),
            now: Duration::ZERO,
            leaving: VecDeque::new(),
            held: VecDeque::new(),
            received: 0,
            delivered: Vec::new(),
        }
    }

    fn tbit(&self, time: Duration) -> BitTime {
        BitTime(tbit_of(self.baud, time))
    }

    /// The begin of the next USB frame; a UART has none.
    fn next_frame(&self, time: Duration) -> Duration {
        match self.adapter.holding {
            Holding::Fifo { .. } => time,
            Holding::Packets { .. } => {
                let frames = time.as_nanos().div_ceil(FRAME.as_nanos());
                Duration::from_nanos(u64::try_from(frames * FRAME.as_nanos()).unwrap())
            }
        }
    }

    /// When the adapter gives characters to the computer next.
    fn delivers_at(&self) -> Option<Duration> {
        let (first, last) = (self.held.front()?.0, self.held.back()?.0);
        let time = match self.adapter.holding {
            Holding::Fifo { trigger } if self.held.len() >= trigger => self.held.get(trigger - 1)?.0,
            Holding::Fifo { .. } => last + duration_of(self.baud, 4 * CHARACTER_TBIT),
            Holding::Packets { size, .. } if self.held.len() >= size => self.held.get(size - 1)?.0,
            Holding::Packets { hold, .. } => first + hold,
        };
        Some(self.next_frame(time))
    }

    /// Everything that happens until `self.now`.
    fn step(&mut self) {
        while let Some((end, octet)) = self.leaving.pop_front_if(|(end, _)| *end <= self.now) {
            self.line.receive(self.tbit(end), Character::Octet(octet));
        }
        let mut out = Vec::new();
        self.line.advance(self.tbit(self.now), &mut out);
        for octet in out {
            self.received += 1;
            if !self.adapter.loses.contains(self.received) {
                self.held.push_back((self.now, octet));
            }
        }
        if self.delivers_at().is_some_and(|time| time <= self.now) {
            let count = match self.adapter.holding {
                Holding::Fifo { .. } => self.held.len(),
                Holding::Packets { size, .. } => size.min(self.held.len()),
            };
            self.delivered.extend(self.held.drain(..count).map(|(_, octet)| Character::Octet(octet)));
        }
    }
}

impl Port for ModelPort {
    fn name(&self) -> &str {
        "model"
    }

    fn delivery(&self) -> Delivery {
        self.adapter.delivery
    }

    fn readiness(&self) -> Vec<Readiness<'_>> {
        Vec::new()
    }

    fn receive(&mut self, characters: &mut Vec<Character>) -> Result<(), PortError> {
        characters.append(&mut self.delivered);
        Ok(())
    }

    fn send(&mut self, octets: &[u8]) -> Result<(), PortError> {
        let mut end = self.leaving.back().map_or(Duration::ZERO, |(end, _)| *end).max(self.next_frame(self.now));
        for octet in octets {
            end += duration_of(self.baud, CHARACTER_TBIT);
            self.leaving.push_back((end, *octet));
        }
        Ok(())
    }

    fn simulated_time(&self) -> Option<Duration> {
        Some(self.now)
    }

    fn simulate(&mut self, at_most: Duration) {
        let end = self.now + at_most;
        while self.delivered.is_empty() && self.now < end {
            let wakes = self.line.wake_at().map(|time| duration_of(self.baud, time.0));
            let leaves = self.leaving.front().map(|(end, _)| *end);
            let next = [wakes, leaves, self.delivers_at()].into_iter().flatten().min().unwrap_or(end);
            self.now = next.clamp(self.now, end);
            self.step();
        }
    }
}

/// A master on the adapter.
fn session(adapter: Adapter, baud: Baud) -> BusSession {
    let bus = bus_parameters(0, baud, adapter.delivery);
    // Bounds a hang only: simulated time passes at any speed.
    BusSession::new(Box::new(ModelPort::new(adapter, baud)), baud, bus, Duration::from_secs(3600)).unwrap()
}

fn gauge(session: &mut BusSession) -> Result<Gauge<profivac_client::ms2::Ms2<'_>>, String> {
    let slave = identify::wait_for_slave(session, ADDRESS).map_err(|error| error.to_string())?;
    assert_eq!(slave.ident, 0x08E6);
    Gauge::open(session, ADDRESS).map_err(|error| error.to_string())
}

fn scans(adapter: Adapter, baud: Baud) -> Result<(), String> {
    let mut session = session(adapter, baud);
    let mut found = Vec::new();
    scan::probe_all(&mut session, 1..=10, &mut found).map_err(|error| error.to_string())?;
    match &found[..] {
        [station] if station.slave.is_some_and(|slave| slave.ident == 0x08E6) => Ok(()),
        [] => Err("finds no station".to_owned()),
        other => Err(format!("{other:?}")),
    }
}

fn reads(adapter: Adapter, baud: Baud) -> Result<(), String> {
    let mut session = session(adapter, baud);
    let value = gauge(&mut session)?.read("pirani.process-value").map_err(|error| error.to_string())?;
    assert!(!value.text.is_empty());
    Ok(())
}

fn dumps(adapter: Adapter, baud: Baud) -> Result<(), String> {
    let mut session = session(adapter, baud);
    let dump = settings::dump(&mut gauge(&mut session)?).map_err(|error| error.to_string())?;
    let unread = dump.readings.iter().filter(|(_, reading)| reading.is_err()).count();
    assert!(dump.readings.len() > 50, "{}", dump.readings.len());
    if unread > 0 { Err(format!("{unread} parameters were not read")) } else { Ok(()) }
}

fn conforms(adapter: Adapter, baud: Baud) -> Result<(), String> {
    let bus = bus_parameters(0, baud, adapter.delivery);
    let (cfg, user_prm, slot_time) = {
        let mut session = session(adapter, baud);
        let slave = CyclicSlave::find(&mut session, ADDRESS, 0).map_err(|error| error.to_string())?;
        let reply = session.request(&services::get_cfg(ADDRESS)).map_err(|error| error.to_string())?;
        let Reply::Answer { du, .. } = reply else { return Err("no configuration".to_owned()) };
        (du, slave.parameters(baud).user_prm.to_vec(), session.timing().slot_time)
    };
    let subject = SlaveUnderTest { address: ADDRESS, ident: 0x08E6, cfg, user_prm };
    let slot_tbit = bus.slot_tbit.max(u32::try_from(tbit_of(baud, slot_time)).unwrap());
    let bus = BusParameters { slot_tbit, ..bus };
    let mut link = PortLink::new(Box::new(ModelPort::new(adapter, baud)), baud, bus);
    let other_master = link.listen().map_err(|error| error.to_string())?;
    assert_eq!(other_master, None);
    let results = run_checks(&mut link, &subject, |_| ControlFlow::Continue(())).map_err(|error| error.to_string())?;
    let is_silent = |result: &CheckResult| matches!(result.outcome, Outcome::NotTested(Reason::Silent));
    if results.iter().any(is_silent) {
        return Err("ends without a result, because the slave seems not to answer".to_owned());
    }
    let is_undecided = |reason: &Reason| matches!(reason, Reason::Disturbed | Reason::Varies | Reason::Undecided(_));
    let undecided =
        |result: &CheckResult| matches!(&result.outcome, Outcome::NotTested(reason) if is_undecided(reason));
    if link.late_answer().is_some() && results.iter().any(undecided) {
        return Err("ends without a result, because an answer was late".to_owned());
    }
    let broken: Vec<_> = results
        .iter()
        .filter(|result| matches!(result.outcome, Outcome::Broken { .. }))
        .map(|result| result.check.name)
        .collect();
    if broken.is_empty() { Ok(()) } else { Err(format!("{} broken: {}", broken.len(), broken.join(", "))) }
}

type Operation = fn(Adapter, Baud) -> Result<(), String>;

const OPERATIONS: [(&str, Operation); 4] = [("scan", scans), ("read", reads), ("dump", dumps), ("conform", conforms)];

/// A row of the table for each outcome at this rate.
fn rows(adapter: Adapter, baud: Baud) -> Vec<String> {
    let outcome = |operation: Operation| operation(adapter, baud).err().unwrap_or_else(|| "works".to_owned());
    let mut groups: Vec<(String, Vec<&str>)> = Vec::new();
    for (name, operation) in OPERATIONS {
        let outcome = outcome(operation);
        match groups.iter_mut().find(|(known, _)| *known == outcome) {
            Some((_, names)) => names.push(name),
            None => groups.push((outcome, vec![name])),
        }
    }
    let row = |(outcome, names): (String, Vec<&str>)| {
        format!("| {} | {} | {} | {outcome} |\n", adapter.name, baud.bits_per_second(), names.join(", "))
    };
    groups.into_iter().map(row).collect()
}

const BEGIN: &str = "<!-- table of adapter_models: begin -->\n";
const END: &str = "<!-- table of adapter_models: end -->\n";

/// The rates of each model: the highest one that every operation of the table is tried at is that of the adapter.
fn rates(adapter: &Adapter) -> &'static [Baud] {
    match adapter.holding {
        Holding::Fifo { .. } => &[Baud::B9600, Baud::B19200],
        Holding::Packets { .. } => &[Baud::B19200, Baud::B500000],
    }
}

#[test]
fn the_table_of_the_models_is_that_of_the_page_about_adapters() {
    let mut table = "| Model of an adapter | bit/s | Operation | Outcome |\n|---|--:|---|---|\n".to_owned();
    for adapter in ADAPTERS {
        for baud in rates(&adapter) {
            table.extend(rows(adapter, *baud));
        }
    }
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../docs/adapters.md");
    let page = std::fs::read_to_string(&path).unwrap();
    let (before, rest) = page.split_once(BEGIN).unwrap();
    let (old, after) = rest.split_once(END).unwrap();
    if std::env::var("PROFIVAC_BLESS").is_ok_and(|bless| bless == "1") {
        std::fs::write(&path, [before, BEGIN, &table, END, after].concat()).unwrap();
    } else {
        assert!(old == table, "docs/adapters.md differs; PROFIVAC_BLESS=1 accepts this:\n{table}");
    }
}

/// Serves the line until the session reports a late answer.
fn late_answer(session: &mut BusSession) -> Notice {
    let mut notices = (0..1000).filter_map(|_| {
        session.serve(&[], FRAME).unwrap();
        session.next_notice()
    });
    notices.next().unwrap_or_else(|| panic!("no notice"))
}

/// The slot time of a bus that has been configured for a faster adapter is too short for this one.
#[test]
fn a_master_that_is_alone_raises_its_slot_time_after_a_late_answer_and_says_so() {
    let adapter = usb("slow", 64, 40, timer(1));
    let baud = Baud::B19200;
    let mut session = session(adapter, baud);
    let before = session.timing();
    let asked = |session: &mut BusSession| session.request(&services::slave_diag(ADDRESS)).unwrap();
    assert!(matches!(asked(&mut session), Reply::NoAnswer(_)), "the first answer is late");
    let notice = late_answer(&mut session);
    let Notice::LateAnswer { turnaround_ms, remedy: LateAnswerRemedy::Raised, .. } = notice else {
        panic!("{notice:?}")
    };
    assert!(turnaround_ms >= 40, "{turnaround_ms}");
    let after = session.timing();
    assert!(after.slot_time > before.slot_time && after.slot_time > after.turnaround, "{after:?}");
    for _ in 0..20 {
        assert!(matches!(asked(&mut session), Reply::Answer { .. }), "{}", session.timing());
    }
}

#[test]
fn a_slot_time_that_the_user_gave_stays_and_the_notice_says_which_one_is_needed() {
    let mut session = session(usb("slow", 64, 40, timer(1)), Baud::B19200).with_fixed_slot_time();
    let before = session.timing().slot_time;
    let _late = session.request(&services::slave_diag(ADDRESS)).unwrap();
    let notice = late_answer(&mut session);
    assert!(notice.to_string().contains("set the slot time of each master on the line to at least"), "{notice}");
    assert_eq!(session.timing().slot_time, before);
}

/// An answer to FDL status has six characters.
#[test]
fn a_scan_finds_a_slave_although_characters_of_its_first_answers_are_lost() {
    for loses in (1..=6).map(Loss::One).chain([Loss::UpTo(6)]) {
        for adapter in ADAPTERS.into_iter().take(3).map(|adapter| Adapter { loses, ..adapter }) {
            for baud in rates(&adapter) {
                assert_eq!(scans(adapter, *baud), Ok(()), "{} at {baud}", adapter.name);
            }
        }
    }
}

#[test]
fn a_longer_pause_than_assumed_within_an_answer_is_tolerated_and_measured() {
    // Packets of four characters, 30 ms apart: the driver claims 1 ms.
    let adapter = usb("slow", 4, 30, timer(1));
    let baud = Baud::B500000;
    let bus = BusParameters { slot_tbit: 16_383 * 2, ..bus_parameters(0, baud, adapter.delivery) };
    let mut session =
        BusSession::new(Box::new(ModelPort::new(adapter, baud)), baud, bus, Duration::from_secs(3600)).unwrap();
    let reply = session.request(&services::slave_diag(ADDRESS)).unwrap();
    assert!(matches!(reply, Reply::Answer { .. }), "{reply:?}");
    let timing = session.timing();
    assert!(timing.pause >= Duration::from_millis(25) && timing.tolerated_pause >= timing.pause, "{timing}");
}

/// 40 ms are 20000 bit times at 500 kbit/s, and a slot time has at most 16383.
#[test]
fn an_answer_that_no_slot_time_waits_for_is_reported_with_what_to_do() {
    let mut session = session(usb("slow", 64, 40, timer(1)), Baud::B500000);
    let _late = session.request(&services::slave_diag(ADDRESS)).unwrap();
    let notice = late_answer(&mut session).to_string();
    assert!(notice.ends_with("use an adapter with less delay, or a lower rate"), "{notice}");
}
