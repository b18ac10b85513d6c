//! The parameter channel of a master: the printed tasks, AK 0 between them, and wrong answers.
//! profibus-wire 6.1, tira56e1 4.3, IF300P manual 3.2.2 and 4.1, BG 5530 App. D and E.
#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic, reason = "helpers of tests are tests")]

use crate::support;

use profivac_dp::link::{Baud, BitTime};
use profivac_dp::master::pkw::{AnswerMismatch, ErrorNumber, Task, TaskError, Value};
use profivac_dp::master::{Handle, HandlerState, Master, Mode, PkwParameters, Settings, SlaveParameters, SubmitError};
use profivac_wire::{DataTelegram, Telegram};
use support::rig::MasterRig;
use support::{bus, hex, text};

type Station = MasterRig<Master<1, 32>>;

/// Ten exchanges for a task.
const GAUGE: PkwParameters = PkwParameters { cycles: 10, ..PkwParameters::GAUGE };
const CONTROLLER: PkwParameters = PkwParameters { cycles: 10, ..PkwParameters::CONTROLLER };

/// The octets of the outputs in an exchange.
fn outputs(octets: &[u8]) -> Vec<u8> {
    match Telegram::parse(octets).unwrap() {
        Telegram::Data(DataTelegram { da: 8, dsap: None, du, .. }) => du.to_vec(),
        other => panic!("no exchange: {other:?}"),
    }
}

/// Slave 8 answers the exchange with these inputs: the channel, and an octet that is something else.
fn hear(rig: &mut Station, channel: &[u8]) {
    let du = [channel, &[0x77]].concat();
    let data = DataTelegram { da: 2, sa: 8, dsap: None, ssap: None, fc: 0x08, du: &du };
    let mut octets = [0; 255];
    let length = Telegram::Data(data).emit(&mut octets).unwrap();
    rig.receive_octets(11, &octets[..length]);
}

const NOTHING: [u8; 8] = [0; 8];

/// Nine octets in and out: the channel and one more. The next exchange was asked for; user output 55.
fn exchanging() -> Station {
    let settings = Settings { control_cycles: 0, ..Settings::new(Baud::B1500000) };
    let mut rig = MasterRig::new(Master::on(bus().check().unwrap(), settings, BitTime(0)));
    rig.station.user.add(&SlaveParameters::new(8, 0x1234, &[0x97, 0xA7, 0x10, 0x20])).unwrap();
    rig.station.user.set_mode(Mode::Operate);
    let ready = "68 0B 0B 68 82 88 08 3E 3C 00 0C 00 02 12 34 E0 16";
    rig.next_request();
    for answer in ["10 02 08 00 0A 16", "68 0B 0B 68 82 88 08 3E 3C 02 05 00 FF 12 34 D8 16", "E5", "E5", ready] {
        rig.receive(answer);
        rig.next_request();
    }
    rig.next_request();
    hear(&mut rig, &NOTHING);
    rig.station.user.outputs_mut(8).unwrap()[8] = 0x55;
    rig
}

/// One exchange: returns the channel in the outputs; the slave answers `answer`.
fn exchange(rig: &mut Station, answer: &[u8]) -> String {
    let sent = outputs(&rig.next_request().octets);
    assert_eq!(sent[8], 0x55, "the rest of the outputs is the user's");
    hear(rig, answer);
    text(&sent[..8])
}

/// The octets of the task after AK 0, and its outcome when the slave answers `answer`.
fn instructed(rig: &mut Station, handle: Handle<Task>, answer: &str) -> (String, Result<Value, TaskError>) {
    assert_eq!(exchange(rig, &NOTHING), text(&NOTHING), "AK 0 first");
    let instruction = exchange(rig, &hex(answer));
    let outcome = rig.station.user.outcome(handle).expect("an outcome");
    (instruction, outcome)
}

/// The examples of the manuals: BG 5530 App. D and E, IF300P manual 3.2.4.2 and 4.1, and the signatures of tira56e1 4.3.1.
#[test]
fn reads_and_writes_as_printed() {
    use Value::{Byte, DoubleWord, Word};
    let mut rig = exchanging();
    for (slot, index, instruction, answer, value) in [
        (1, 22, "10 01 16 00 00 00 00 00", "10 01 16 00 00 00 13 08", Word(0x1308)),
        (0, 25, "10 00 19 00 00 00 00 00", "B0 00 19 00 00 00 00 04", Byte(4)),
        (1, 19, "10 01 13 00 00 00 00 00", "20 01 13 00 42 C8 00 00", DoubleWord(100f32.to_bits())),
    ] {
        let handle = rig.station.user.pkw_read(8, slot, index, None, &GAUGE).unwrap();
        assert_eq!(instructed(&mut rig, handle, answer), (instruction.to_owned(), Ok(value)));
        assert_eq!(rig.station.user.outcome(handle), None, "once");
    }
    let threshold = DoubleWord(0x3B03_126F);
    for (slot, index, value, parameters, instruction, answer, reported) in [
        (2, 15, Byte(4), GAUGE, "A0 02 0F 00 00 00 00 04", "B0 02 0F 00 00 00 00 04", Byte(4)),
        (1, 15, Word(0xFF00), GAUGE, "20 01 0F 00 00 00 FF 00", "10 01 0F 00 00 00 FF 00", Word(0xFF00)),
        (10, 21, threshold, CONTROLLER, "30 0A 15 00 3B 03 12 6F", "20 0A 15 00 3B 03 12 6F", threshold),
        // A controller is written bytes as words and answers bytes.
        (10, 20, Byte(0), CONTROLLER, "20 0A 14 00 00 00 00 00", "B0 0A 14 00 00 00 00 00", Byte(0)),
        (10, 23, Word(3), CONTROLLER, "20 0A 17 00 00 00 00 03", "B0 0A 17 00 00 00 00 03", Byte(3)),
    ] {
        let handle = rig.station.user.pkw_write(8, slot, index, value, &parameters).unwrap();
        assert_eq!(instructed(&mut rig, handle, answer), (instruction.to_owned(), Ok(reported)));
    }
    // The channel returns to AK 0 afterwards.
    assert_eq!(exchange(&mut rig, &NOTHING), text(&NOTHING));
}

/// tira56e1 4.3.3: all numbers reach the user, also those that no manual has.
#[test]
fn a_refusal_has_the_number_of_the_slave() {
    let mut rig = exchanging();
    for number in [0, 1, 2, 3, 5, 13, 17, 18, 201, 202, 0x1234] {
        let handle = rig.station.user.pkw_read(8, 1, 19, None, &GAUGE).unwrap();
        let answer = format!("70 01 13 00 00 00 {:02X} {:02X}", number >> 8, number & 0xFF);
        let (_, outcome) = instructed(&mut rig, handle, &answer);
        assert_eq!(outcome, Err(TaskError::Refused(ErrorNumber(number))));
    }
    assert_eq!(TaskError::Refused(ErrorNumber(201)).to_string(), "the slave refused the task: error number 201");
}

/// errata-pxg55x-img400 11: a slave needs several cycles; the master sends the task until the slave answers it, and then AK 0
/// until the slave answers that. The master does not take an old answer for the answer to the next task.
#[test]
fn the_master_waits_for_a_slow_slave_in_both_directions() {
    let mut rig = exchanging();
    let read = hex("10 01 13 00 00 00 00 00");
    let old = hex("20 01 13 00 42 C8 00 00");
    let new = hex("20 01 13 00 43 48 00 00");
    for (old, new, value) in [(&NOTHING.to_vec(), &old, 100f32), (&old, &new, 200.0)] {
        let handle = rig.station.user.pkw_read(8, 1, 19, None, &GAUGE).unwrap();
        for _ in 0..2 {
            assert_eq!(exchange(&mut rig, old), text(&NOTHING));
            assert_eq!(rig.station.user.outcome(handle), None);
            if *old == NOTHING {
                break;
            }
        }
        if *old != NOTHING {
            assert_eq!(exchange(&mut rig, &NOTHING), text(&NOTHING));
        }
        for _ in 0..3 {
            assert_eq!(exchange(&mut rig, &NOTHING), text(&read));
            assert_eq!(rig.station.user.outcome(handle), None);
        }
        assert_eq!(exchange(&mut rig, new), text(&read));
        let value = Value::DoubleWord(value.to_bits());
        assert_eq!(rig.station.user.outcome(handle), Some(Ok(value)));
    }
}

/// The error of a read of 1/19, four octets wide, when the slave always answers `answer`.
fn reported(answer: &str) -> String {
    let mut rig = exchanging();
    let handle = rig.station.user.pkw_read(8, 1, 19, Some(4), &GAUGE).unwrap();
    exchange(&mut rig, &NOTHING);
    for _ in 0..9 {
        assert_eq!(rig.station.user.outcome(handle), None);
        exchange(&mut rig, &hex(answer));
    }
    match rig.station.user.outcome(handle) {
        Some(Err(error)) => error.to_string(),
        other => panic!("{answer}: {other:?}"),
    }
}

#[test]
fn an_answer_that_does_not_fit_is_ignored_and_reported_at_the_timeout() {
    for (answer, words) in [
        ("00 01 13 00 42 C8 00 00", "no response in time"),
        ("20 02 13 00 42 C8 00 00", "the parameter channel answers about 2/19 instead of 1/19"),
        ("20 01 14 00 42 C8 00 00", "the parameter channel answers about 1/20 instead of 1/19"),
        ("30 01 13 00 42 C8 00 00", "the parameter channel answers with AK 3, which is no answer"),
        ("F0 01 13 00 42 C8 00 00", "the parameter channel answers with AK 15, which is no answer"),
        ("10 01 13 00 00 00 00 04", "the parameter channel answers with 2 octets instead of 4"),
        ("B0 01 13 00 00 00 00 04", "the parameter channel answers with 1 octets instead of 4"),
        ("10 01 13 00 00 01 00 04", "the parameter channel answers with octets that should be 0"),
        ("B0 01 13 00 00 00 01 04", "the parameter channel answers with octets that should be 0"),
        ("70 01 13 00 01 00 00 04", "the parameter channel answers with octets that should be 0"),
    ] {
        assert_eq!(reported(answer), words, "{answer}");
    }
}

/// Every other value of AK, slot and index.
#[test]
fn no_forged_answer_becomes_a_value() {
    for position in 0..3 {
        for octet in 0..=255u8 {
            let mut answer = hex("20 01 13 00 42 C8 00 00");
            // The lower nibble is reserved, and AK 7 is a refusal.
            if (answer[position] ^ octet) & if position == 0 { 0xF0 } else { 0xFF } == 0 {
                continue;
            }
            answer[position] = octet;
            let mut rig = exchanging();
            let handle = rig.station.user.pkw_read(8, 1, 19, Some(4), &GAUGE).unwrap();
            exchange(&mut rig, &NOTHING);
            exchange(&mut rig, &answer);
            let reported = rig.station.user.outcome(handle);
            assert!(!matches!(reported, Some(Ok(_))), "{answer:02X?}: {reported:?}");
        }
    }
}

/// The answer to a write has the width of the written value.
#[test]
fn a_write_is_answered_in_its_width() {
    let mut rig = exchanging();
    let handle = rig.station.user.pkw_write(8, 2, 20, Value::Byte(1), &GAUGE).unwrap();
    exchange(&mut rig, &NOTHING);
    for _ in 0..9 {
        exchange(&mut rig, &hex("10 02 14 00 00 00 00 01"));
    }
    let wrong = AnswerMismatch::Width { expected: 1, received: 2 };
    assert_eq!(rig.station.user.outcome(handle), Some(Err(TaskError::Mismatch(wrong))));
}

/// An exchange that was sent before the task was submitted does not count for it.
#[test]
fn an_exchange_under_way_does_not_count_as_ak_0() {
    let mut rig = exchanging();
    rig.station.user.outputs_mut(8).unwrap()[..8].copy_from_slice(&hex("10 01 13 00 00 00 00 00"));
    assert_eq!(text(&outputs(&rig.next_request().octets)[..8]), "10 01 13 00 00 00 00 00", "the octets of the user");
    let handle = rig.station.user.pkw_read(8, 1, 19, None, &GAUGE).unwrap();
    hear(&mut rig, &NOTHING);
    let (_, outcome) = instructed(&mut rig, handle, "20 01 13 00 42 C8 00 00");
    assert_eq!(outcome, Ok(Value::DoubleWord(100f32.to_bits())));
}

/// The master sends no task to a slave that never returns to AK 0.
#[test]
fn a_slave_that_does_not_return_to_ak_0_is_named() {
    let mut rig = exchanging();
    let handle = rig.station.user.pkw_read(8, 1, 19, None, &GAUGE).unwrap();
    for _ in 0..10 {
        assert_eq!(exchange(&mut rig, &hex("20 01 13 00 42 C8 00 00")), text(&NOTHING));
    }
    assert_eq!(rig.station.user.outcome(handle), Some(Err(TaskError::Mismatch(AnswerMismatch::Unrequested))));
}

#[test]
fn an_invalid_request_is_refused_at_once() {
    let mut rig = exchanging();
    let user = &mut rig.station.user;
    let elsewhere = PkwParameters { inputs_at: 2, ..GAUGE };
    assert_eq!(user.pkw_read(8, 1, 19, None, &elsewhere), Err(SubmitError::NoChannel));
    let elsewhere = PkwParameters { outputs_at: usize::MAX, ..GAUGE };
    assert_eq!(user.pkw_read(8, 1, 19, None, &elsewhere), Err(SubmitError::NoChannel));
    assert_eq!(user.pkw_read(9, 1, 19, None, &GAUGE), Err(SubmitError::NotExchanging(9)));
    let handle = user.pkw_read(8, 1, 19, None, &GAUGE).unwrap();
    assert_eq!(user.pkw_write(8, 1, 19, Value::Byte(0), &GAUGE), Err(SubmitError::Busy));
    assert_eq!(user.outcome(handle), None);
    user.set_mode(Mode::Clear);
    assert_eq!(user.pkw_read(8, 1, 19, None, &GAUGE), Err(SubmitError::NotOperating));
}

/// Clear sends zeros, and so no task.
#[test]
fn a_task_ends_with_operate() {
    let mut rig = exchanging();
    let handle = rig.station.user.pkw_read(8, 1, 19, None, &GAUGE).unwrap();
    exchange(&mut rig, &NOTHING);
    rig.station.user.set_mode(Mode::Clear);
    rig.next_request();
    rig.next_telegram();
    assert_eq!(rig.station.user.outcome(handle), Some(Err(TaskError::NotOperating)));
}

/// After a restart both slave and master have dropped the task.
#[test]
fn a_task_ends_with_data_exchange() {
    let mut rig = exchanging();
    let handle = rig.station.user.pkw_write(8, 1, 19, Value::Byte(1), &GAUGE).unwrap();
    exchange(&mut rig, &NOTHING);
    rig.next_request();
    rig.receive("10 02 08 03 0D 16");
    assert_eq!(rig.station.user.state(8), Some(HandlerState::Diag1));
    while rig.station.user.outcome(handle).is_none() {
        rig.next_telegram();
    }
    assert_eq!(rig.station.user.outputs_mut(8).unwrap(), [0, 0, 0, 0, 0, 0, 0, 0, 0x55], "the channel is zero again");
}
