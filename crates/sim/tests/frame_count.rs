//! Repetitions: the table of profibus-wire 1.9, row by row.
//!
//! Each Data_Exchange samples the inputs, and the first input counts the samples, so an answer shows whether its request was
//! executed.

#![allow(clippy::unwrap_used, clippy::panic, reason = "a test")]

use crate::common;

use common::*;
use profivac_wire::{DataTelegram, Telegram};

/// A slave in data exchange. The last counted request of its owner had FCB = 1.
fn exchanging() -> Talk {
    let mut talk = talk(Plain::new());
    to_data_exch(&mut talk);
    talk
}

/// One Data_Exchange. Returns the number of the input sample in the answer.
fn exchange(talk: &mut Talk, fc: u8) -> u8 {
    let answer = ask(talk, &plain(OWN, fc, &[fc, 0]));
    let Ok(Telegram::Data(telegram)) = Telegram::parse(&answer) else { panic!("data") };
    telegram.du[0]
}

/// The number of outputs that the device received.
fn executed(talk: &Talk) -> usize {
    talk.station().device().outputs.iter().flatten().count()
}

#[test]
fn a_first_request_is_always_executed_and_sets_fcb() {
    let mut talk = exchanging();
    assert_eq!([exchange(&mut talk, FIRST), exchange(&mut talk, FIRST)], [1, 2]);
    // The stored FCB is 1: a counted request with FCB = 1 repeats the first, one with FCB = 0 is new.
    assert_eq!([exchange(&mut talk, FCB_1), exchange(&mut talk, FCB_0)], [2, 3]);
    assert_eq!(executed(&talk), 3);
}

#[test]
fn a_toggled_fcb_is_a_new_request() {
    let mut talk = exchanging();
    assert_eq!([FCB_0, FCB_1, FCB_0].map(|fc| exchange(&mut talk, fc)), [1, 2, 3]);
    assert_eq!(executed(&talk), 3);
}

#[test]
fn the_same_fcb_is_a_repetition_and_gets_the_same_answer_without_being_executed() {
    let mut talk = exchanging();
    let request = plain(OWN, FCB_0, &[1, 2]);
    let answer = ask(&mut talk, &request);
    for _ in 0..5 {
        assert_eq!(ask(&mut talk, &request), answer);
    }
    // Other data do not make it a new request.
    assert_eq!(ask(&mut talk, &plain(OWN, FCB_0, &[3, 4])), answer);
    assert_eq!(executed(&talk), 1);
}

#[test]
fn another_requester_with_the_same_fcb_is_new() {
    let mut talk = exchanging();
    assert_eq!(exchange(&mut talk, FCB_0), 1);
    let rd_inp = request(OTHER, FCB_0, 56, &[]);
    assert!(ask(&mut talk, &rd_inp).contains(&2), "RD_Inp of the other master is executed");
    assert_eq!(exchange(&mut talk, FCB_0), 3, "and then the owner with the same FCB is new as well");
    assert_eq!(executed(&talk), 2);
}

#[test]
fn uncounted_requests_keep_the_stored_fcb_and_answer() {
    for between in [
        plain(OWN, 0x49, &[]),
        plain(OWN, 0x4E, &[]),
        plain(OWN, 0x4F, &[]),
        request(OWN, 0x46, 58, &[0, 0]),
        request(OWN, 0x4D, 59, &[]),
        request(OTHER, 0x4C, 60, &[]),
    ] {
        let mut talk = exchanging();
        let first = ask(&mut talk, &plain(OWN, FCB_0, &[1, 2]));
        ask_or_silence(&mut talk, &between);
        assert_eq!(ask(&mut talk, &plain(OWN, FCB_0, &[1, 2])), first, "after {between:02X?}");
        assert_eq!(executed(&talk), 1);
    }
}

#[test]
fn requests_to_other_stations_keep_the_stored_fcb_and_answer() {
    let to_another = DataTelegram { da: 9, sa: OWN, dsap: None, ssap: None, fc: FCB_1, du: &[1, 2] };
    for between in [emit(&Telegram::Data(to_another)), vec![0xDC, TS, OWN], vec![0xDC, OWN, OWN]] {
        let mut talk = exchanging();
        let first = ask(&mut talk, &plain(OWN, FCB_0, &[1, 2]));
        assert_eq!(ask_or_silence(&mut talk, &between), None);
        assert_eq!(ask(&mut talk, &plain(OWN, FCB_0, &[1, 2])), first);
    }
}

#[test]
fn a_damaged_request_keeps_the_stored_fcb_and_answer() {
    let mut talk = exchanging();
    let first = ask(&mut talk, &plain(OWN, FCB_0, &[1, 2]));
    let mut damaged = plain(OWN, FCB_1, &[1, 2]);
    damaged[7] ^= 0x10;
    assert_eq!(ask_or_silence(&mut talk, &damaged), None);
    assert_eq!(ask(&mut talk, &plain(OWN, FCB_0, &[1, 2])), first);
    assert_eq!(executed(&talk), 1);
}

#[test]
fn uncounted_requests_are_executed_each_time() {
    let mut talk = exchanging();
    assert_eq!([0x4D, 0x4D, 0x4C].map(|fc| exchange(&mut talk, fc)), [1, 2, 3]);
}

#[test]
fn the_stored_fcb_belongs_to_the_station_and_not_to_a_service() {
    let mut talk = exchanging();
    let diag = ask(&mut talk, &request(OWN, FCB_0, 60, &[]));
    // FCB toggles across services; Get_Cfg with the FCB of the diagnosis is a repetition of it.
    assert_eq!(ask(&mut talk, &request(OWN, FCB_0, 59, &[])), diag);
    assert_ne!(ask(&mut talk, &request(OWN, FCB_1, 59, &[])), diag);
    assert_eq!(exchange(&mut talk, FCB_0), 1);
}

#[test]
fn answers_without_data_are_stored_too() {
    // SC: the repeated Set_Prm is not evaluated again, although it would now be refused.
    let mut talk = exchanging();
    assert_eq!(ask(&mut talk, &request(OWN, FCB_0, 61, &LOCK)), [0xE5]);
    assert_eq!(ask(&mut talk, &request(OWN, FCB_0, 61, &[0x80, 0, 0, 11, 0, 0, 0])), [0xE5]);
    assert_eq!(talk.station().state().to_string(), "WAIT-CFG");
    // The answers RS and RR are repeated.
    let rs = ask(&mut talk, &plain(OWN, FCB_1, &[1, 2]));
    assert_eq!(ask(&mut talk, &request(OWN, FCB_1, 60, &[])), rs);
    let rr = ask(&mut talk, &request(OWN, FCB_0, 60, &[1]));
    assert_eq!(ask(&mut talk, &request(OWN, FCB_0, 60, &[])), rr);
}

#[test]
fn a_repeated_request_gets_the_same_diagnosis() {
    let mut talk = exchanging();
    let first = ask(&mut talk, &request(OWN, FCB_0, 60, &[]));
    talk.station_mut().device_mut().ext_diag = vec![2, 1];
    assert_eq!(ask(&mut talk, &request(OWN, FCB_0, 60, &[])), first);
    assert_ne!(ask(&mut talk, &request(OWN, FCB_1, 60, &[])), first);
}

#[test]
fn nothing_is_stored_after_power_up_and_after_a_new_address() {
    // Before the first request, a counted request with either FCB is new.
    for fc in [FCB_0, FCB_1] {
        assert_eq!(ask(&mut talk(Plain::new()), &request(OWN, fc, 61, &LOCK)), [0xE5]);
    }
    let mut talk = exchanging();
    assert_eq!(exchange(&mut talk, FCB_0), 1);
    talk.station_mut().power_up(TS);
    assert_eq!(ask(&mut talk, &request(OWN, FCB_0, 61, &LOCK)), [0xE5]);
    assert_eq!(talk.station().state().to_string(), "WAIT-CFG");
}
