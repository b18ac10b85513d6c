//! The begin of an answer: not before min T_SDR, not after max T_SDR. profibus-wire 1.12 and 2.4.

#![allow(clippy::unwrap_used, clippy::panic, reason = "a test")]

use crate::common;

use common::*;
use profivac_dp::link::Baud;

/// Set_Prm with this min T_SDR: lock and unlock, ident number.
fn set_prm(status: u8, min_tsdr: u8, ident: u16) -> Vec<u8> {
    let [high, low] = ident.to_be_bytes();
    request(OWN, FIRST, 61, &[status, 0, 0, min_tsdr, high, low, 0])
}

/// The bit times from the end of a Get_Cfg to the start of its answer.
fn tsdr(talk: &mut Talk) -> u64 {
    ask(talk, &request(OTHER, FIRST, 59, &[]));
    let entries = &talk.segment.trace().entries;
    let [.., request, answer] = entries.iter().collect::<Vec<_>>()[..] else { panic!("a request and its answer") };
    answer.start - request.end()
}

/// T_SDR after a Set_Prm, for a slave that had min T_SDR 20 before.
fn after(status: u8, min_tsdr: u8, ident: u16) -> u64 {
    let mut talk = talk(Plain::new());
    ask(&mut talk, &set_prm(0x80, 20, IDENT));
    assert_eq!(tsdr(&mut talk), 20);
    ask(&mut talk, &set_prm(status, min_tsdr, ident));
    tsdr(&mut talk)
}

#[test]
fn the_default_is_eleven_at_every_rate() {
    for baud in Baud::ALL {
        assert_eq!(tsdr(&mut talk_at(baud, Plain::new())), 11, "{baud}");
    }
}

#[test]
fn an_answer_begins_after_the_min_tsdr_that_the_master_set() {
    for min_tsdr in 11..=149 {
        assert_eq!(after(0x80, min_tsdr, IDENT), u64::from(min_tsdr));
    }
}

#[test]
fn values_below_eleven_are_raised_to_eleven_and_zero_keeps_the_value() {
    for min_tsdr in 1..=10 {
        assert_eq!(after(0x80, min_tsdr, IDENT), 11);
    }
    assert_eq!(after(0x80, 0, IDENT), 20);
}

#[test]
fn set_prm_without_lock_changes_min_tsdr_only() {
    // With Lock_Req and Unlock_Req 0 only min T_SDR is evaluated, not even the ident number. profibus-wire 2.4.
    assert_eq!(after(0x00, 30, IDENT), 30);
    assert_eq!(after(0x00, 30, 0xFFFF), 30);
    assert_eq!(after(0x00, 0, IDENT), 20);
}

#[test]
fn a_refused_set_prm_does_not_change_min_tsdr() {
    assert_eq!(after(0x80, 30, 0xFFFF), 20);
    assert_eq!(after(0x40, 30, IDENT), 20, "unlock does not change it");
}

#[test]
fn a_foreign_master_does_not_change_min_tsdr() {
    let mut talk = talk(Plain::new());
    ask(&mut talk, &set_prm(0x80, 20, IDENT));
    ask(&mut talk, &request(OTHER, FIRST, 61, &[0x00, 0, 0, 30, 0x12, 0x34, 0]));
    assert_eq!(tsdr(&mut talk), 20);
}

#[test]
fn the_acknowledgement_of_set_prm_uses_the_previous_min_tsdr() {
    let mut talk = talk(Plain::new());
    let octets = profivac_sim::describe::Hex(&set_prm(0x80, 100, IDENT)).to_string();
    talk.play(&format!("+40 -> {octets}\n11 <- E5\n+40 -> 68 05 05 68 88 83 6D 3C 3E F2 16")).unwrap();
    talk.play("100 <- 68 0B 0B 68 83 88 08 3E 3C 02 04 00 02 12 34 DB 16").unwrap();
}

#[test]
fn power_up_resets_min_tsdr() {
    let mut talk = talk(Plain::new());
    ask(&mut talk, &set_prm(0x80, 20, IDENT));
    talk.station_mut().power_up(TS);
    assert_eq!(tsdr(&mut talk), 11);
}

#[test]
fn every_kind_of_answer_observes_min_tsdr() {
    let mut talk = talk(Plain::new());
    to_data_exch(&mut talk);
    ask(&mut talk, &request(OWN, FIRST, 61, &[0, 0, 0, 33, 0x12, 0x34, 0]));
    for octets in [
        plain(OWN, 0x49, &[]),
        plain(OWN, 0x4E, &[]),
        plain(OWN, FCB_0, &[1, 2]),
        plain(OWN, FCB_0, &[1, 2]),
        request(OWN, FCB_1, 62, &CFG),
        request(OWN, FCB_0, 52, &[]),
        request(OWN, FCB_1, 59, &[1]),
    ] {
        ask(&mut talk, &octets);
        let entries = &talk.segment.trace().entries;
        let answer = &entries[entries.len() - 1];
        assert_eq!(answer.start - entries[entries.len() - 2].end(), 33, "{answer}");
    }
}
