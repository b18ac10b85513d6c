//! Every device keeps all rules, and every rule finds the slave that does not.

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
const PLACE: u8 = 8;

/// A device at the other end of a wire, in bit times.
struct Memo {
    device: VirtualDevice,
    receiver: Receiver,
    now: BitTime,
}

impl Memo {
    fn of(spec: &str) -> Self {
        let spec: DeviceSpec = spec.parse().unwrap();
        let conditions = GasConditions {
            pressure: "1e-3 mbar".parse().unwrap(),
            atmosphere: "1000 mbar".parse().unwrap(),
            gas: Gas::N2,
        };
        let unit = spec.build(NonvolatileMemory::volatile(), BAUD).unwrap();
        let device = VirtualDevice::new(unit, PLACE, BAUD, conditions);
        Self { device, receiver: Receiver::with_idle(BitTime(0), T_SYN_TBIT), now: BitTime(1000) }
    }
}

impl Link for Memo {
    fn address(&self) -> u8 {
        2
    }

    fn send_and_receive(&mut self, octets: &[u8]) -> Result<Received, PortError> {
        self.now = self.now + 60;
        self.device.poll(self.now);
        let mut heard = Received::Nothing;
        for octet in octets {
            self.now = self.now + CHARACTER_TBIT;
            if let Decoded::Telegram(telegram) = self.receiver.octet(self.now, *octet)
                && let Some(answer) = self.device.telegram(self.now, &telegram)
            {
                heard = Received::Telegram(answer.octets.to_vec());
            }
        }
        let Received::Telegram(answer) = &heard else {
            self.now = self.now + 100;
            return Ok(heard);
        };
        self.now = self.now + 11 + CHARACTER_TBIT * answer.len() as u64;
        self.device.sent(self.now);
        // The slave does not hear itself, but a receiver that saw nothing may begin anew.
        self.receiver = Receiver::with_idle(BitTime(0), T_SYN_TBIT);
        Ok(heard)
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

fn subject(name: &str) -> SlaveUnderTest {
    let model = MODELS.iter().find(|model| model.name == name).unwrap();
    let prm = model.user_prm.first().map_or(&[][..], |prm| prm.octets);
    let cfg = model.configurations.first().unwrap().octets;
    SlaveUnderTest { address: PLACE, ident: model.ident, cfg: cfg.to_vec(), user_prm: prm.to_vec() }
}

/// The checks that a slave on `wire` does not pass.
fn broken(wire: &mut dyn Link, subject: &SlaveUnderTest) -> Vec<String> {
    let findings = run(wire, subject, |_| ControlFlow::Continue(())).unwrap();
    let told = |finding: &CheckResult| match &finding.outcome {
        Outcome::Violated { expected, shown } => {
            Some(format!("{}: expected {expected}, {shown:02X?}", finding.check.name))
        }
        Outcome::Passed | Outcome::Skipped(_) => None,
    };
    findings.iter().filter_map(told).collect()
}

#[test]
fn every_device_keeps_every_rule() {
    for model in MODELS {
        let name = model.name;
        let mut wire = Memo::of(&format!("{name}@{PLACE}"));
        assert_eq!(broken(&mut wire, &subject(name)), Vec::<String>::new(), "{name}");
    }
}

/// Broken off after any check, it waits for parameters and nobody owns it.
#[test]
fn who_breaks_off_leaves_the_slave_released() {
    for count in 1..checks::all().count() {
        let mut wire = Memo::of("bcg450@8");
        let mut told = 0;
        let findings = run(&mut wire, &subject("bcg450"), |_| {
            told += 1;
            if told == count { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
        });
        assert_eq!(findings.unwrap().len(), count);
        let diagnosis = dialogue::octets(PLACE, 2, Sap::SlaveDiag, 0x6D, &[]);
        let Received::Telegram(answer) = wire.send_and_receive(&diagnosis).unwrap() else {
            panic!("no diagnosis after {count}")
        };
        assert_eq!((answer[DU + 1] & 1, answer[DU + 3]), (1, 0xFF), "after {count}");
    }
}

#[test]
fn names_are_told_once() {
    let mut names: Vec<_> = checks::all().map(|check| check.name).collect();
    let count = names.len();
    names.sort_unstable();
    names.dedup();
    assert_eq!(names.len(), count);
}

/// A slave with one fault.
struct Faulty {
    memo: Memo,
    fault: Fault,
    before: Vec<u8>,
}

/// What the fault makes of a request and its answer; `before` is the answer before.
type Fault = fn(asked: &[u8], came: Received, before: &[u8]) -> Received;

impl Link for Faulty {
    fn address(&self) -> u8 {
        self.memo.address()
    }

    fn send_and_receive(&mut self, octets: &[u8]) -> Result<Received, PortError> {
        let came = self.memo.send_and_receive(octets)?;
        let came = (self.fault)(octets, came, &self.before);
        if let Received::Telegram(came) = &came {
            self.before = came.clone();
        }
        Ok(came)
    }

    fn wait(&mut self, time: Duration) -> Result<(), PortError> {
        self.memo.wait(time)
    }
}

const SC: u8 = 0xE5;

fn telegram(octets: &[u8]) -> Received {
    Received::Telegram(octets.to_vec())
}

/// The answer with an octet of its data unit or head replaced, and a new sum.
fn with(came: &Received, place: usize, change: impl Fn(u8) -> u8) -> Received {
    let Received::Telegram(octets) = came else { return came.clone() };
    let mut octets = octets.clone();
    if octets[0] != 0x68 || place >= octets.len() - 2 {
        return came.clone();
    }
    octets[place] = change(octets[place]);
    let end = octets.len();
    octets[end - 2] = octets[4..end - 2].iter().fold(0, |sum: u8, octet| sum.wrapping_add(*octet));
    telegram(&octets)
}

fn dsap(asked: &[u8]) -> Option<u8> {
    asked.get(7).copied().filter(|_| asked[0] == 0x68 && asked[4] & 0x80 != 0)
}

fn is_rs(came: &Received) -> bool {
    matches!(came, Received::Telegram(octets) if octets.len() == 6 && octets[3] == 0x03)
}

/// RS where the slave says so becomes something else.
fn open_instead(asked: &[u8], came: Received, sap: u8) -> Received {
    if dsap(asked) == Some(sap) && is_rs(&came) { telegram(&[SC]) } else { came }
}

/// The first octet of the data unit of an answer with access points.
const DU: usize = 9;

/// For each check a fault that it must find.
const FAULTS: &[(&str, Fault)] = &[
    ("layer2.fdl-status", |asked, came, _| match asked {
        [0x10, _, _, 0x49, ..] => telegram(&[0x10, 2, 8, 0x20, 0x2A, 0x16]),
        _ => came,
    }),
    ("layer2.damaged", |asked, came, _| if asked.last() == Some(&0x12) { telegram(&[SC]) } else { came }),
    ("layer2.cut-off", |asked, came, _| if asked.len() == 3 && asked[0] == 0x68 { telegram(&[SC]) } else { came }),
    ("layer2.not-for-it", |asked, came, _| match asked {
        [0x10, 127, ..] => telegram(&[0x10, 2, 8, 0x00, 0x0A, 0x16]),
        _ => came,
    }),
    ("layer2.no-request", |asked, came, _| if asked[0] == 0xDC { telegram(&[SC]) } else { came }),
    ("layer2.closed", |asked, came, _| open_instead(asked, came, 63)),
    ("layer2.sd3", |asked, came, _| if asked[0] == 0xA2 { Received::Nothing } else { came }),
    ("layer2.repetition", |asked, came, before| {
        // The diagnosis counts how often it was read.
        if dsap(asked) == Some(60) {
            with(&came, 14, |_| before.len() as u8 ^ before.get(14).copied().unwrap_or(0))
        } else {
            came
        }
    }),
    ("layer2.one-count", |asked, came, before| match dsap(asked) {
        Some(59) if before.get(8) == Some(&60) => telegram(before),
        _ => came,
    }),
    ("layer2.other-master", |asked, came, before| match asked.get(5) {
        Some(0x83) => telegram(before),
        _ => came,
    }),
    (
        "start-up.diagnosis",
        |asked, came, _| if dsap(asked) == Some(60) { with(&came, DU + 1, |two| two & !0x04) } else { came },
    ),
    ("start-up.get-cfg", |asked, came, _| if dsap(asked) == Some(59) { with(&came, DU, |_| 0xC0) } else { came }),
    ("start-up.not-yet", |asked, came, _| open_instead(asked, came, 56)),
    (
        "start-up.wrong-ident",
        |asked, came, _| if dsap(asked) == Some(60) { with(&came, DU, |one| one & !0x40) } else { came },
    ),
    ("start-up.short-prm", |asked, came, _| {
        if asked.len() == 11 + 6 && dsap(asked) == Some(61) { telegram(&[0x10, 2, 8, 0x02, 0x0C, 0x16]) } else { came }
    }),
    ("start-up.owner", |asked, came, _| if dsap(asked) == Some(60) { with(&came, DU + 3, |_| 0xFF) } else { came }),
    (
        "start-up.wrong-cfg",
        |asked, came, _| if dsap(asked) == Some(60) { with(&came, DU, |one| one & !0x04) } else { came },
    ),
    ("start-up.lock", |asked, came, _| match (asked, is_rs(&came)) {
        ([0x10, _, 3, 0x6D | 0x5D | 0x7D, ..] | [0x68, _, _, _, _, 3, ..], true) => telegram(&[SC]),
        _ => came,
    }),
    ("start-up.unlock", |asked, came, _| if dsap(asked) == Some(60) { with(&came, DU + 3, |_| 2) } else { came }),
    ("start-up.watchdog", |asked, came, _| if dsap(asked) == Some(60) { with(&came, DU, |_| 0) } else { came }),
    ("exchange.inputs", |asked, came, _| match (dsap(asked), &came) {
        (None, Received::Telegram(octets)) if octets[0] == 0x68 => telegram(&[SC]),
        _ => came,
    }),
    ("exchange.diagnosis-flag", |asked, came, _| match dsap(asked) {
        None => with(&came, 6, |_| 0x0A),
        Some(_) => came,
    }),
    ("exchange.wrong-length", |asked, came, before| match (dsap(asked), is_rs(&came)) {
        (None, true) if before.first() == Some(&0x68) => telegram(before),
        _ => came,
    }),
    ("exchange.read", |asked, came, _| if dsap(asked) == Some(56) { telegram(&[SC]) } else { came }),
    ("exchange.global-control", |asked, came, _| match asked {
        [0x68, _, _, _, 0xFF, ..] if dsap(asked) == Some(58) => telegram(&[SC]),
        _ => came,
    }),
    ("exchange.ms1-closed", |asked, came, _| open_instead(asked, came, 51)),
    ("ms2.open", |asked, came, _| if dsap(asked) == Some(49) { with(&came, DU + 1, |_| 55) } else { came }),
    ("ms2.idle", |_, came, _| with(&came, DU, |function| if function == 0x48 { 0x49 } else { function })),
    ("ms2.foreign", |asked, came, _| match (asked.get(5), dsap(asked), is_rs(&came)) {
        (Some(0x83), Some(0..=48), true) => telegram(&[SC]),
        _ => came,
    }),
    ("ms2.refusal", |_, came, _| match &came {
        Received::Telegram(octets) if octets.get(DU) == Some(&0xDE) => with(&came, DU + 2, |_| 0xC2),
        _ => came,
    }),
    (
        "ms2.abort",
        |asked, came, _| if asked.get(9) == Some(&0x58) { telegram(&[0x10, 2, 8, 0x02, 0x0C, 0x16]) } else { came },
    ),
    ("ms2.unknown-function", |_, came, _| with(&came, DU, |function| if function == 0x58 { 0x48 } else { function })),
    ("noise.damaged-telegrams", |asked, came, _| match Telegram::parse(asked) {
        Err(_) if asked.len() > 20 => telegram(&[SC]),
        _ => came,
    }),
];

#[test]
fn every_rule_finds_the_slave_that_does_not_keep_it() {
    for check in checks::all() {
        let (_, fault) =
            FAULTS.iter().find(|(name, _)| *name == check.name).unwrap_or_else(|| panic!("{}", check.name));
        let mut wire = Faulty { memo: Memo::of("bcg450@8"), fault: *fault, before: Vec::new() };
        let broken = broken(&mut wire, &subject("bcg450"));
        assert!(broken.iter().any(|line| line.starts_with(check.name)), "{}: {broken:#?}", check.name);
    }
}
