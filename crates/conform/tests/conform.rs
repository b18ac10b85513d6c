//! Every virtual device keeps all rules, and every check finds a slave that violates its rule.

#![allow(clippy::unwrap_used, clippy::panic, clippy::indexing_slicing, reason = "a test")]

use profivac_conform::dialogue::{self, Link, SlaveUnderTest};
use profivac_conform::probe::Received;
use profivac_conform::{CheckResult, Outcome, checks, run};
use profivac_devices::catalog::MODELS;
use profivac_dp::link::{Baud, BitTime, CHARACTER_TBIT, Received as Decoded, Receiver, Station, T_SYN_TBIT};
use profivac_host::port::PortError;
use profivac_vacuum::Gas;
use profivac_virtual::device::{GasConditions, VirtualDevice};
use profivac_virtual::device_spec::DeviceSpec;
use profivac_virtual::nonvolatile::NonvolatileMemory;
use profivac_wire::{Sap, Telegram};
use std::ops::ControlFlow;
use std::time::Duration;

const BAUD: Baud = Baud::B19200;
const ADDRESS: u8 = 8;

/// A link to a virtual device, in simulated bit times.
struct VirtualLink {
    device: VirtualDevice,
    receiver: Receiver,
    now: BitTime,
}

impl VirtualLink {
    fn new(spec: &str) -> Self {
        let spec: DeviceSpec = spec.parse().unwrap();
        let conditions = GasConditions {
            pressure: "1e-3 mbar".parse().unwrap(),
            atmosphere: "1000 mbar".parse().unwrap(),
            gas: Gas::N2,
        };
        let built = spec.build(NonvolatileMemory::volatile(), BAUD).unwrap();
        let device = VirtualDevice::new(built, ADDRESS, BAUD, conditions);
        Self { device, receiver: Receiver::with_idle(BitTime(0), T_SYN_TBIT), now: BitTime(1000) }
    }
}

impl Link for VirtualLink {
    fn address(&self) -> u8 {
        2
    }

    fn send_and_receive(&mut self, octets: &[u8]) -> Result<Received, PortError> {
        self.now = self.now + 60;
        self.device.poll(self.now);
        let mut received = Received::Nothing;
        for octet in octets {
            self.now = self.now + CHARACTER_TBIT;
            if let Decoded::Telegram(telegram) = self.receiver.octet(self.now, *octet)
                && let Some(answer) = self.device.telegram(self.now, &telegram)
            {
                received = Received::Telegram(answer.octets.to_vec());
            }
        }
        let Received::Telegram(answer) = &received else {
            self.now = self.now + 100;
            return Ok(received);
        };
        self.now = self.now + 11 + CHARACTER_TBIT * answer.len() as u64;
        self.device.sent(self.now);
        // The receiver does not get the answer of its own slave, so it starts again with an idle line.
        self.receiver = Receiver::with_idle(BitTime(0), T_SYN_TBIT);
        Ok(received)
    }

    fn wait(&mut self, time: Duration) -> Result<(), PortError> {
        let end = self.now + BAUD.tbit_of_ms(time.as_millis() as u64);
        while self.now < end {
            self.now = self.now + BAUD.tbit_of_ms(1);
            self.device.poll(self.now);
        }
        Ok(())
    }
}

fn slave(name: &str) -> SlaveUnderTest {
    let model = MODELS.iter().find(|model| model.name == name).unwrap();
    let prm = model.user_prm.first().map_or(&[][..], |prm| prm.octets);
    let cfg = model.configurations.first().unwrap().octets;
    SlaveUnderTest { address: ADDRESS, ident: model.ident, cfg: cfg.to_vec(), user_prm: prm.to_vec() }
}

/// The rules that the slave at the end of `link` violates.
fn violations(link: &mut dyn Link, slave: &SlaveUnderTest) -> Vec<String> {
    let results = run(link, slave, |_| ControlFlow::Continue(())).unwrap();
    let violation = |result: &CheckResult| match &result.outcome {
        Outcome::Violated { expected, shown } => {
            Some(format!("{}: expected {expected}, {shown:02X?}", result.check.name))
        }
        Outcome::Passed | Outcome::Skipped(_) => None,
    };
    results.iter().filter_map(violation).collect()
}

#[test]
fn every_virtual_device_keeps_every_rule() {
    for model in MODELS {
        let name = model.name;
        let mut link = VirtualLink::new(&format!("{name}@{ADDRESS}"));
        assert_eq!(violations(&mut link, &slave(name)), Vec::<String>::new(), "{name}");
    }
}

/// The slave waits for parameters and has no owner.
#[test]
fn a_run_that_ends_after_any_check_releases_the_slave() {
    for count in 1..checks::all().count() {
        let mut link = VirtualLink::new("bcg450@8");
        let mut reported = 0;
        let results = run(&mut link, &slave("bcg450"), |_| {
            reported += 1;
            if reported == count { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
        });
        assert_eq!(results.unwrap().len(), count);
        let diagnosis = dialogue::octets(ADDRESS, 2, Sap::SlaveDiag, 0x6D, &[]);
        let Received::Telegram(answer) = link.send_and_receive(&diagnosis).unwrap() else {
            panic!("no diagnosis after {count}")
        };
        assert_eq!((answer[DU + 1] & 1, answer[DU + 3]), (1, 0xFF), "after {count}");
    }
}

#[test]
fn every_check_has_its_own_name() {
    let mut names: Vec<_> = checks::all().map(|check| check.name).collect();
    let count = names.len();
    names.sort_unstable();
    names.dedup();
    assert_eq!(names.len(), count);
}

/// A link to a virtual device with one fault.
struct FaultyLink {
    link: VirtualLink,
    fault: Fault,
    /// The last answer.
    before: Vec<u8>,
}

/// Changes the answer to a request; `before` is the last answer.
type Fault = fn(request: &[u8], answer: Received, before: &[u8]) -> Received;

impl Link for FaultyLink {
    fn address(&self) -> u8 {
        self.link.address()
    }

    fn send_and_receive(&mut self, octets: &[u8]) -> Result<Received, PortError> {
        let answer = self.link.send_and_receive(octets)?;
        let answer = (self.fault)(octets, answer, &self.before);
        if let Received::Telegram(answer) = &answer {
            self.before = answer.clone();
        }
        Ok(answer)
    }

    fn wait(&mut self, time: Duration) -> Result<(), PortError> {
        self.link.wait(time)
    }
}

const SC: u8 = 0xE5;

fn telegram(octets: &[u8]) -> Received {
    Received::Telegram(octets.to_vec())
}

/// The answer with one octet changed and a new check octet.
fn with(answer: &Received, place: usize, change: impl Fn(u8) -> u8) -> Received {
    let Received::Telegram(octets) = answer else { return answer.clone() };
    let mut octets = octets.clone();
    if octets[0] != 0x68 || place >= octets.len() - 2 {
        return answer.clone();
    }
    octets[place] = change(octets[place]);
    let end = octets.len();
    octets[end - 2] = octets[4..end - 2].iter().fold(0, |sum: u8, octet| sum.wrapping_add(*octet));
    telegram(&octets)
}

fn dsap(request: &[u8]) -> Option<u8> {
    request.get(7).copied().filter(|_| request[0] == 0x68 && request[4] & 0x80 != 0)
}

fn is_rs(answer: &Received) -> bool {
    matches!(answer, Received::Telegram(octets) if octets.len() == 6 && octets[3] == 0x03)
}

/// Replaces RS of this access point by SC.
fn open_instead(request: &[u8], answer: Received, sap: u8) -> Received {
    if dsap(request) == Some(sap) && is_rs(&answer) { telegram(&[SC]) } else { answer }
}

/// The first octet of the data unit of an answer with access points.
const DU: usize = 9;

/// A fault for each check, which the check must find.
const FAULTS: &[(&str, Fault)] = &[
    ("layer2.fdl-status", |request, answer, _| match request {
        [0x10, _, _, 0x49, ..] => telegram(&[0x10, 2, 8, 0x20, 0x2A, 0x16]),
        _ => answer,
    }),
    ("layer2.damaged", |request, answer, _| if request.last() == Some(&0x12) { telegram(&[SC]) } else { answer }),
    (
        "layer2.cut-off",
        |request, answer, _| if request.len() == 3 && request[0] == 0x68 { telegram(&[SC]) } else { answer },
    ),
    ("layer2.not-for-it", |request, answer, _| match request {
        [0x10, 127, ..] => telegram(&[0x10, 2, 8, 0x00, 0x0A, 0x16]),
        _ => answer,
    }),
    ("layer2.no-request", |request, answer, _| if request[0] == 0xDC { telegram(&[SC]) } else { answer }),
    ("layer2.closed", |request, answer, _| open_instead(request, answer, 63)),
    ("layer2.sd3", |request, answer, _| if request[0] == 0xA2 { Received::Nothing } else { answer }),
    ("layer2.repetition", |request, answer, before| {
        // The diagnosis changes with each read.
        if dsap(request) == Some(60) {
            with(&answer, 14, |_| before.len() as u8 ^ before.get(14).copied().unwrap_or(0))
        } else {
            answer
        }
    }),
    ("layer2.one-count", |request, answer, before| match dsap(request) {
        Some(59) if before.get(8) == Some(&60) => telegram(before),
        _ => answer,
    }),
    ("layer2.other-master", |request, answer, before| match request.get(5) {
        Some(0x83) => telegram(before),
        _ => answer,
    }),
    (
        "start-up.diagnosis",
        |request, answer, _| if dsap(request) == Some(60) { with(&answer, DU + 1, |two| two & !0x04) } else { answer },
    ),
    (
        "start-up.get-cfg",
        |request, answer, _| if dsap(request) == Some(59) { with(&answer, DU, |_| 0xC0) } else { answer },
    ),
    ("start-up.not-yet", |request, answer, _| open_instead(request, answer, 56)),
    (
        "start-up.wrong-ident",
        |request, answer, _| if dsap(request) == Some(60) { with(&answer, DU, |one| one & !0x40) } else { answer },
    ),
    ("start-up.short-prm", |request, answer, _| {
        if request.len() == 11 + 6 && dsap(request) == Some(61) {
            telegram(&[0x10, 2, 8, 0x02, 0x0C, 0x16])
        } else {
            answer
        }
    }),
    (
        "start-up.owner",
        |request, answer, _| if dsap(request) == Some(60) { with(&answer, DU + 3, |_| 0xFF) } else { answer },
    ),
    (
        "start-up.wrong-cfg",
        |request, answer, _| if dsap(request) == Some(60) { with(&answer, DU, |one| one & !0x04) } else { answer },
    ),
    ("start-up.lock", |request, answer, _| match (request, is_rs(&answer)) {
        ([0x10, _, 3, 0x6D | 0x5D | 0x7D, ..] | [0x68, _, _, _, _, 3, ..], true) => telegram(&[SC]),
        _ => answer,
    }),
    (
        "start-up.unlock",
        |request, answer, _| if dsap(request) == Some(60) { with(&answer, DU + 3, |_| 2) } else { answer },
    ),
    (
        "start-up.watchdog",
        |request, answer, _| if dsap(request) == Some(60) { with(&answer, DU, |_| 0) } else { answer },
    ),
    ("exchange.inputs", |request, answer, _| match (dsap(request), &answer) {
        (None, Received::Telegram(octets)) if octets[0] == 0x68 => telegram(&[SC]),
        _ => answer,
    }),
    ("exchange.diagnosis-flag", |request, answer, _| match dsap(request) {
        None => with(&answer, 6, |_| 0x0A),
        Some(_) => answer,
    }),
    ("exchange.wrong-length", |request, answer, before| match (dsap(request), is_rs(&answer)) {
        (None, true) if before.first() == Some(&0x68) => telegram(before),
        _ => answer,
    }),
    ("exchange.read", |request, answer, _| if dsap(request) == Some(56) { telegram(&[SC]) } else { answer }),
    ("exchange.global-control", |request, answer, _| match request {
        [0x68, _, _, _, 0xFF, ..] if dsap(request) == Some(58) => telegram(&[SC]),
        _ => answer,
    }),
    ("exchange.ms1-closed", |request, answer, _| open_instead(request, answer, 51)),
    ("ms2.open", |request, answer, _| if dsap(request) == Some(49) { with(&answer, DU + 1, |_| 55) } else { answer }),
    ("ms2.idle", |_, answer, _| with(&answer, DU, |function| if function == 0x48 { 0x49 } else { function })),
    ("ms2.foreign", |request, answer, _| match (request.get(5), dsap(request), is_rs(&answer)) {
        (Some(0x83), Some(0..=48), true) => telegram(&[SC]),
        _ => answer,
    }),
    ("ms2.refusal", |_, answer, _| match &answer {
        Received::Telegram(octets) if octets.get(DU) == Some(&0xDE) => with(&answer, DU + 2, |_| 0xC2),
        _ => answer,
    }),
    (
        "ms2.abort",
        |request, answer, _| {
            if request.get(9) == Some(&0x58) { telegram(&[0x10, 2, 8, 0x02, 0x0C, 0x16]) } else { answer }
        },
    ),
    ("ms2.unknown-function", |_, answer, _| {
        with(&answer, DU, |function| if function == 0x58 { 0x48 } else { function })
    }),
    ("noise.damaged-telegrams", |request, answer, _| match Telegram::parse(request) {
        Err(_) if request.len() > 20 => telegram(&[SC]),
        _ => answer,
    }),
];

#[test]
fn every_check_finds_a_slave_that_violates_its_rule() {
    for check in checks::all() {
        let (_, fault) =
            FAULTS.iter().find(|(name, _)| *name == check.name).unwrap_or_else(|| panic!("{}", check.name));
        let mut link = FaultyLink { link: VirtualLink::new("bcg450@8"), fault: *fault, before: Vec::new() };
        let violations = violations(&mut link, &slave("bcg450"));
        assert!(violations.iter().any(|line| line.starts_with(check.name)), "{}: {violations:#?}", check.name);
    }
}
