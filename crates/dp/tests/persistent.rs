//! One slave fails permanently, in each possible way: the error has a text, the master tries the slave more and more slowly, and
//! the others are not affected. profibus-wire 3.9 and 3.10.
//!
//! The bound for the others: no cycle is longer than one in which all slaves work, plus one message cycle of the faulty slave
//! with all its repetitions, plus one Global_Control. This follows from one message per slave and cycle.
#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic, reason = "helpers of tests are tests")]

use crate::support;

use profivac_dp::link::active::{Active, Failure};
use profivac_dp::link::{Baud, BitTime};
use profivac_dp::master::{ExchangeError, Master, Mode, Settings, SlaveParameters};
use profivac_wire::control::Status;
use support::line::{From, Line};
use support::plain::Plain;
use support::{bus, hex, is_housekeeping};

const IDENT: u16 = 0x1234;
/// Two octets in, two octets out.
const CFG: [u8; 2] = [0x11, 0x21];
/// The faulty slave; its place is in the middle of the cycle.
const BAD: u8 = 8;
const OTHERS: [u8; 4] = [3, 5, 20, 77];
/// A cycle in which all five work: messages of 290 bit times, the token, T_ID1.
const GOOD_CYCLE: u64 = 5 * 290 + 33 + 37;
/// Global_Control and T_ID2.
const CONTROL: u64 = 143 + 150;
/// The longest request here (Set_Prm, 132 bit times), T_SL, as much noise as an answer has, T_SL: and all that twice.
const WORST_MESSAGE: u64 = 2 * (132 + 300 + 250 + 300);

type Bus = Line<Master<8, 32>>;

fn settings() -> Settings {
    // Ten seconds are a long run in bit times.
    let baud = Baud::B1500000;
    Settings { control_cycles: 50, ready_tbit: baud.tbit_of_ms(50), ..Settings::new(baud) }
}

fn line() -> Bus {
    let mut master: Active<Master<8, 32>> = Master::on(bus().check().unwrap(), settings(), BitTime(0));
    let order = [OTHERS[0], OTHERS[1], BAD, OTHERS[2], OTHERS[3]];
    for address in order {
        master.user.add(&SlaveParameters::new(address, IDENT, &CFG)).unwrap();
    }
    master.user.set_mode(Mode::Operate);
    let mut line = Line::new(master);
    // The faulty slave is the first on the line, independent of its place in the cycle.
    for address in [BAD].into_iter().chain(OTHERS) {
        let mut device = Plain::new(IDENT, &CFG);
        device.inputs = vec![1, address];
        line.attach(device, address);
    }
    line
}

/// Every answer of the faulty slave becomes these octets.
fn answers(line: &mut Bus, octets: Vec<u8>) {
    line.telegram_fault =
        Some(Box::new(move |from, sent| if from == From::Slave(0) { octets.clone() } else { sent.to_vec() }));
}

/// Its answers to everything but FDL status become these octets.
fn answers_services(line: &mut Bus, octets: &'static str) {
    line.telegram_fault = Some(Box::new(move |from, sent| match (from, sent) {
        (From::Slave(0), [0x10, _, _, 0, ..]) => sent.to_vec(),
        (From::Slave(0), _) => hex(octets),
        _ => sent.to_vec(),
    }));
}

/// An answer to Slave_Diag from slave 8 to master 2.
fn diag(du: [u8; 6]) -> Vec<u8> {
    let mut octets = vec![0x68, 11, 11, 0x68, 0x82, 0x88, 0x08, 0x3E, 0x3C];
    octets.extend(du);
    let fcs = octets[4..].iter().fold(0u8, |sum, octet| sum.wrapping_add(*octet));
    octets.extend([fcs, 0x16]);
    octets
}

/// Its diagnosis becomes this one.
fn diagnoses(line: &mut Bus, du: [u8; 6]) {
    line.telegram_fault = Some(Box::new(move |from, sent| match (from, sent) {
        (From::Slave(0), [0x68, _, _, _, 0x82, 0x88, _, 0x3E, 0x3C, ..]) => diag(du),
        _ => sent.to_vec(),
    }));
}

/// A fault, its name, and the text of the error.
struct Fault {
    name: &'static str,
    apply: fn(&mut Bus),
    error: ExchangeError,
    words: &'static str,
    /// The number of messages from the first of a new try to the fault.
    messages: usize,
}

const FAULTS: &[Fault] = &[
    Fault {
        name: "it never answers",
        apply: |line| answers(line, Vec::new()),
        error: ExchangeError::NoAnswer(Failure::Silence),
        words: "no answer",
        messages: 1,
    },
    Fault {
        name: "it answers FDL status and nothing else",
        apply: |line| answers_services(line, ""),
        error: ExchangeError::NoAnswer(Failure::Silence),
        words: "no answer",
        // FDL status, then Slave_Diag three times, because the slave was absent before.
        messages: 4,
    },
    Fault {
        name: "it answers with octets that are no telegram",
        apply: |line| answers(line, vec![0x55, 0xAA, 0x68, 0xFF, 0x10, 0x00, 0x16, 0x33]),
        error: ExchangeError::NoAnswer(Failure::Damaged),
        words: "the answer is damaged",
        messages: 1,
    },
    Fault {
        name: "it refuses Set_Prm",
        apply: |line| line.slaves[0].device_mut().accepts_prm = false,
        error: ExchangeError::PrmFault,
        words: "it does not accept its parameters (Prm_Fault)",
        messages: 4,
    },
    Fault {
        name: "it refuses Chk_Cfg",
        apply: |line| line.slaves[0].device_mut().cfg = vec![0x10],
        error: ExchangeError::CfgFault,
        words: "it does not accept its configuration (Cfg_Fault)",
        messages: 4,
    },
    Fault {
        name: "it is another device",
        apply: |line| line.slaves[0].device_mut().ident = 0x4321,
        error: ExchangeError::Ident { expected: IDENT, received: 0x4321 },
        words: "it is another device: ident number 4321 instead of 1234",
        messages: 1,
    },
    Fault {
        name: "it belongs to another master",
        apply: |line| diagnoses(line, [0x00, 0x0C, 0x00, 0x05, 0x12, 0x34]),
        error: ExchangeError::Owned { master: 5 },
        words: "it belongs to master 5",
        messages: 1,
    },
    Fault {
        name: "it always asks for parameters",
        apply: |line| diagnoses(line, [0x02, 0x05, 0x00, 0xFF, 0x12, 0x34]),
        error: ExchangeError::PrmReq,
        words: "it asks to be parameterised again (Prm_Req)",
        messages: 4,
    },
    Fault {
        name: "it answers RS",
        apply: |line| answers_services(line, "10 02 08 03 0D 16"),
        error: ExchangeError::Refused(Status::ServiceNotActivated),
        words: "it does not exchange data with us (RS)",
        messages: 1,
    },
    Fault {
        name: "it answers UE",
        apply: |line| answers_services(line, "10 02 08 01 0B 16"),
        error: ExchangeError::Refused(Status::UserError),
        words: "its application has failed (UE)",
        messages: 1,
    },
    Fault {
        name: "it answers RR",
        apply: |line| answers_services(line, "10 02 08 02 0C 16"),
        error: ExchangeError::Refused(Status::NoResource),
        words: "it has no room for the data (RR)",
        messages: 1,
    },
    Fault {
        name: "it acknowledges everything",
        apply: |line| answers_services(line, "E5"),
        error: ExchangeError::Refused(Status::NoReply),
        words: "it acknowledges where it should answer with data",
        messages: 1,
    },
];

/// The traffic in a number of bit times: the longest cycle, and the number of messages to the faulty slave.
fn watch(line: &mut Bus, tbit: u64) -> (u64, usize) {
    let first = line.trace.len();
    let end = line.now + tbit;
    let mut longest = 0;
    let mut cycles = line.master.user.cycles();
    line.run_until(tbit + 100_000, |line| {
        if line.master.user.cycles() != cycles {
            cycles = line.master.user.cycles();
            longest = longest.max(line.master.user.cycle_tbit());
        }
        line.now >= end
    });
    let asked =
        line.trace[first..].iter().filter(|entry| entry.from == From::Master && !is_housekeeping(&entry.octets));
    let asked = asked.filter(|entry| match entry.octets[..] {
        [0x10, da, ..] | [0x68, _, _, _, da, ..] => da & 0x7F == BAD,
        _ => false,
    });
    (longest, asked.count())
}

#[test]
fn a_faulty_slave_is_reported_retried_slowly_and_costs_the_others_at_most_one_message() {
    for fault in FAULTS {
        let mut line = line();
        (fault.apply)(&mut line);
        line.run_until(500_000, |line| {
            line.master.user.exchanging() == OTHERS.len() && line.master.user.exchange_error(BAD) == Some(fault.error)
        });
        assert_eq!(fault.error.to_string(), fault.words);
        // One second until the pauses have grown, then two seconds are measured.
        line.run_for(1_500_000);
        let before = OTHERS.map(|address| *line.master.user.counters(address).unwrap());
        let cycles = line.master.user.cycles();
        while line.master.user.next_event().is_some() {}
        let (longest, asked) = watch(&mut line, 3_000_000);

        assert_eq!(line.master.user.exchange_error(BAD), Some(fault.error), "{}", fault.name);
        assert!(longest <= GOOD_CYCLE + WORST_MESSAGE + CONTROL, "{}: {longest}", fault.name);
        // Every 250 ms, eight or nine times; a repetition of each message that fails in silence.
        let (least, most) = (7 * fault.messages, 10 * fault.messages * 2);
        assert!((least..=most).contains(&asked), "{}: {asked} messages", fault.name);
        for (address, before) in OTHERS.into_iter().zip(before) {
            let after = line.master.user.counters(address).unwrap();
            assert_eq!(
                (after.lost, after.repetitions, after.starts),
                (before.lost, before.repetitions, 1),
                "{}",
                fault.name
            );
            let missed = (after.exchanges - before.exchanges).abs_diff(line.master.user.cycles() - cycles);
            assert!(missed <= 1, "{}: {address} is exchanged with in every cycle", fault.name);
        }
        // On average the others are no slower than with a slave that works.
        let average = 3_000_000 / u64::from(line.master.user.cycles() - cycles);
        assert!(average < GOOD_CYCLE, "{}: {average}", fault.name);
    }
}

#[test]
fn a_fault_that_lasts_is_reported_once() {
    for fault in FAULTS {
        let mut line = line();
        (fault.apply)(&mut line);
        line.run_for(1_000_000);
        let reported: Vec<_> = std::iter::from_fn(|| line.master.user.next_event()).collect();
        let errors = reported.iter().filter(|event| event.address == BAD && event.kind.to_string() == fault.words);
        assert_eq!(errors.count(), 1, "{}: {reported:?}", fault.name);
    }
}

#[test]
fn a_repaired_slave_returns_within_the_longest_pause() {
    for fault in FAULTS {
        let mut line = line();
        (fault.apply)(&mut line);
        line.run_for(3_000_000);
        line.telegram_fault = None;
        let device = line.slaves[0].device_mut();
        (device.accepts_prm, device.cfg, device.ident) = (true, CFG.to_vec(), IDENT);
        let limit = settings().pause_max_tbit + 20_000;
        line.run_until(limit, |line| line.master.user.inputs(BAD) == Some(&[1, BAD][..]));
        assert_eq!(line.master.user.exchange_error(BAD), None, "{}", fault.name);
    }
}

/// The slave neither refuses nor becomes ready: the master polls it in every cycle for a time and then with the usual pause.
#[test]
fn a_slave_that_is_never_ready_gets_its_time_and_then_a_pause() {
    let mut line = line();
    diagnoses(&mut line, [0x02, 0x0C, 0x00, 0x02, 0x12, 0x34]);
    line.run_until(200_000, |line| line.master.user.exchange_error(BAD) == Some(ExchangeError::NotReady));
    assert_eq!(ExchangeError::NotReady.to_string(), "it does not become ready (Station_Not_Ready)");
    line.run_for(3_000_000);
    let (longest, _) = watch(&mut line, 3_000_000);
    assert!(longest <= GOOD_CYCLE + WORST_MESSAGE + CONTROL, "{longest}");
    let reported = std::iter::from_fn(|| line.master.user.next_event());
    assert_eq!(
        reported.filter(|event| event.address == BAD && event.kind.to_string().contains("not become ready")).count(),
        1
    );
    assert_eq!(line.master.user.counters(OTHERS[0]).unwrap().lost, 0);
}

/// The slave loses its parameters after a few exchanges, each time.
#[test]
fn a_slave_that_leaves_exchange_every_time_is_started_four_times_a_second_at_most() {
    let mut line = line();
    line.run_until(500_000, |line| line.master.user.exchanging() == 5);
    let mut falls = 0;
    let mut longest = 0;
    let end = line.now + 6_000_000;
    while line.now < end {
        let exchanges = line.master.user.counters(BAD).unwrap().exchanges;
        line.run_until(1_000_000, |line| {
            longest = longest.max(line.master.user.cycle_tbit());
            line.master.user.counters(BAD).unwrap().exchanges > exchanges + 3
        });
        line.slaves[0].power_up(BAD);
        falls += 1;
        while line.master.user.next_event().is_some() {}
    }
    // Four seconds: 0, 10, 30, 70, 150, 310 ms, then every 250.
    assert!((18..=22).contains(&falls), "{falls}");
    assert!(longest <= GOOD_CYCLE + WORST_MESSAGE + CONTROL, "{longest}");
    for address in OTHERS {
        let counters = line.master.user.counters(address).unwrap();
        assert_eq!((counters.lost, counters.repetitions, counters.starts), (0, 0, 1));
    }
}
