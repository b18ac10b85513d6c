//! The response watchdog, exact to the bit time. profibus-wire 2.4 and 3.6.

#![allow(clippy::unwrap_used, clippy::panic, reason = "a test")]

use crate::common;

use common::*;
use profivac_dp::link::{Baud, BitTime};
use profivac_dp::slave::{Features, Slave};
use profivac_sim::Segment;
use profivac_sim::stations::Tester;
use profivac_wire::{DataTelegram, Telegram};

/// Set_Prm with a watchdog of 10 ms x 5 x 12.
const WATCHDOG_600_MS: [u8; 7] = [0x88, 5, 12, 11, 0x12, 0x34, 0];

/// A slave in data exchange, parameterised by `prm`, and the end of the last request of its owner.
fn exchanging(baud: Baud, prm: &[u8]) -> (Talk, BitTime) {
    let mut device = Plain::new();
    device.features = Features { dpv1: prm.len() > 7, ..device.features };
    let mut talk = talk_at(baud, device);
    assert_eq!(ask(&mut talk, &request(OWN, FIRST, 61, prm)), [0xE5]);
    let (_, end) = asked(&mut talk, &request(OWN, FIRST, 62, &CFG));
    assert_eq!(talk.station().state().to_string(), "DATA-EXCH");
    (talk, end)
}

/// Sends a request. Returns the answer and the end of the request.
fn asked(talk: &mut Talk, octets: &[u8]) -> (Option<Vec<u8>>, BitTime) {
    let before = talk.segment.trace().entries.len();
    let answer = ask_or_silence(talk, octets);
    (answer, talk.segment.trace().entries[before].end())
}

/// Asserts that the slave exchanges data until one bit time before `deadline` and has left data exchange at `deadline`.
fn expires_at(talk: &mut Talk, deadline: BitTime) {
    talk.segment.run_until(BitTime(deadline.0 - 1)).unwrap();
    assert_eq!(talk.station().state().to_string(), "DATA-EXCH", "one bit time before {deadline}");
    talk.segment.run_until(deadline).unwrap();
    assert_eq!(talk.station().state().to_string(), "WAIT-PRM", "at {deadline}");
    assert_eq!(talk.station().device().outputs.last(), Some(&None), "outputs are safe");
}

#[test]
fn the_watchdog_expires_at_the_parameterised_time_at_every_rate() {
    for baud in Baud::ALL {
        let (mut talk, end) = exchanging(baud, &WATCHDOG_600_MS);
        let expected = BitTime(end.0 + u64::from(baud.bits_per_second()) * 600 / 1000);
        expires_at(&mut talk, expected);
        assert_eq!(diagnosis(&mut talk), "02 05 00 FF", "{baud}");
    }
}

#[test]
fn the_base_may_be_one_millisecond() {
    let prm = [0x88, 5, 7, 11, 0x12, 0x34, 0, 0x04, 0, 0];
    let (mut talk, end) = exchanging(Baud::B500000, &prm);
    expires_at(&mut talk, end + 35 * 500);
}

#[test]
fn the_longest_time_is_650_seconds() {
    let prm = [0x88, 255, 255, 11, 0x12, 0x34, 0];
    let (mut talk, end) = exchanging(Baud::B12000000, &prm);
    expires_at(&mut talk, end + 255 * 255 * 120_000);
}

#[test]
fn every_request_of_the_owner_restarts_the_watchdog() {
    for (what, octets) in [
        ("Data_Exchange", plain(OWN, FCB_0, &[1, 2])),
        ("Slave_Diag", request(OWN, FCB_0, 60, &[])),
        ("Get_Cfg", request(OWN, FCB_0, 59, &[])),
        ("RD_Inp", request(OWN, FCB_0, 56, &[])),
        ("Chk_Cfg", request(OWN, FCB_0, 62, &CFG)),
        ("a repetition", request(OWN, FCB_1, 62, &CFG)),
        ("a closed access point", request(OWN, FCB_0, 52, &[])),
        ("FDL status", plain(OWN, 0x49, &[])),
        ("Global_Control", request(OWN, 0x46, 58, &[0, 0])),
        ("Global_Control to all", to_all(OWN, &[0, 0])),
    ] {
        let (mut talk, _) = exchanging(Baud::B1500000, &WATCHDOG_600_MS);
        let (_, end) = asked(&mut talk, &octets);
        println!("{what}");
        expires_at(&mut talk, end + 600 * 1500);
    }
}

#[test]
fn no_other_telegram_restarts_the_watchdog() {
    for (what, octets) in [
        ("Slave_Diag of another master", request(OTHER, FCB_0, 60, &[])),
        ("Data_Exchange of another master", plain(OTHER, FCB_0, &[1, 2])),
        ("Set_Prm of another master", request(OTHER, FCB_0, 61, &LOCK)),
        ("FDL status of another master", plain(OTHER, 0x49, &[])),
        ("Global_Control of another master", to_all(OTHER, &[0, 0])),
        ("Global_Control to another group", to_all(OWN, &[0, 2])),
        ("a token", vec![0xDC, TS, OWN]),
        ("a damaged request", vec![0x10, TS, OWN, 0x49, 0, 0x16]),
    ] {
        let (mut talk, end) = exchanging(Baud::B1500000, &WATCHDOG_600_MS);
        asked(&mut talk, &octets);
        println!("{what}");
        expires_at(&mut talk, end + 600 * 1500);
    }
}

#[test]
fn the_watchdog_runs_in_wait_cfg() {
    let mut talk = talk(Plain::new());
    let (_, end) = asked(&mut talk, &request(OWN, FIRST, 61, &WATCHDOG_600_MS));
    let deadline = end + 600 * 1500;
    talk.segment.run_until(BitTime(deadline.0 - 1)).unwrap();
    assert_eq!(talk.station().state().to_string(), "WAIT-CFG");
    talk.segment.run_until(deadline).unwrap();
    assert_eq!(talk.station().state().to_string(), "WAIT-PRM");
}

#[test]
fn a_late_request_reaches_a_slave_that_has_left_data_exchange() {
    // The request begins in time and ends at the bit time at which the watchdog expires.
    let (mut talk, end) = exchanging(Baud::B1500000, &WATCHDOG_600_MS);
    let request = plain(OWN, FCB_0, &[1, 2]);
    let begin = end.0 + 600 * 1500 - 11 * request.len() as u64;
    let hex = profivac_sim::describe::Hex(&request).to_string();
    talk.play(&format!("@{begin} -> {hex}\n11 <- 10 02 08 03 0D 16")).unwrap();
}

#[test]
fn without_watchdog_the_outputs_are_kept() {
    let (mut talk, end) = exchanging(Baud::B1500000, &LOCK);
    asked(&mut talk, &plain(OWN, FCB_0, &[1, 2]));
    talk.segment.run_until(end + 1_500_000 * 86_400).unwrap();
    assert_eq!(talk.station().state().to_string(), "DATA-EXCH");
    assert_eq!(talk.station().device().outputs.last(), Some(&Some(vec![1, 2])));
}

#[test]
fn each_slave_has_its_own_watchdog() {
    // Both slaves have an owner, but only one still gets requests.
    let baud = Baud::B1500000;
    let mut segment = Segment::new(baud);
    let slaves = [8, 9].map(|address| segment.attach(Slave::new(Plain::new(), address, baud)));
    let tester = segment.attach(Tester::new());
    let mut time = 0;
    let mut send = |segment: &mut Segment, da, fc, dsap: Option<u8>, du: &[u8]| {
        time += 2000;
        let telegram = DataTelegram { da, sa: OWN, dsap, ssap: dsap.map(|_| 62), fc, du };
        segment.station_mut(tester).send(BitTime(time), &emit(&Telegram::Data(telegram)));
    };
    for da in [8, 9] {
        send(&mut segment, da, FIRST, Some(61), &WATCHDOG_600_MS);
        send(&mut segment, da, FIRST, Some(62), &CFG);
    }
    for turn in 0..500 {
        send(&mut segment, 8, if turn % 2 == 0 { FCB_0 } else { FCB_1 }, None, &[1, 2]);
    }
    segment.run_until(BitTime(1_005_000)).unwrap();
    assert_eq!(slaves.map(|slave| segment.station(slave).state().to_string()), ["DATA-EXCH", "WAIT-PRM"]);
}

fn to_all(sa: u8, du: &[u8]) -> Vec<u8> {
    emit(&Telegram::Data(DataTelegram { da: 127, sa, dsap: Some(58), ssap: Some(62), fc: 0x46, du }))
}
