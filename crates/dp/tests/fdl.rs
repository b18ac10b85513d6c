//! The requests that a station answers on layer 2, and those that it does not. profibus-wire 1.3, 1.4, 1.8 and 1.11.

use crate::rig;

use profivac_dp::link::Station;
use profivac_dp::slave::SlaveState;
use profivac_wire::control::{Control, FrameCount, Function};
use profivac_wire::{DataTelegram, Telegram};
use rig::{Answer, Gauge, MASTER, RS, Rig, SLAVE, Seen, emit, hex, low, text};

fn telegram(da: u8, sa: u8, fc: u8) -> Vec<u8> {
    emit(&Telegram::Data(DataTelegram { da, sa, dsap: None, ssap: None, fc, du: &[] }))
}

#[test]
fn fdl_status_is_answered_in_every_state() {
    let mut rig = Rig::new(Gauge::default());
    let ask = |rig: &mut Rig| assert_eq!(rig.dialogue("10 08 02 49 53 16"), "10 02 08 00 0A 16");
    ask(&mut rig);
    rig.ms0(MASTER, 61, &hex("80 01 01 00 12 34 00"));
    ask(&mut rig);
    rig.ms0(MASTER, 62, &hex("11 21"));
    assert!(matches!(rig.slave.state(), SlaveState::DataExch(..)));
    ask(&mut rig);
}

#[test]
fn ident_returns_vendor_controller_hardware_and_software() {
    let mut rig = Rig::new(Gauge::default());
    let answer = "68 0D 0D 68 02 08 08 02 03 01 00 41 42 43 44 45 46 AD 16";
    assert_eq!(rig.dialogue("10 08 02 4E 58 16"), answer);
}

#[test]
fn a_device_without_ident_strings_closes_ident_and_lsap_status_is_always_closed() {
    let mut rig = Rig::new(Gauge { ident: false, ..Gauge::default() });
    assert_eq!(rig.dialogue("10 08 02 4E 58 16"), "10 02 08 03 0D 16");
    assert_eq!(rig.dialogue("10 08 02 4F 59 16"), "10 02 08 03 0D 16");
}

#[test]
fn sda_is_closed() {
    for fc in [0x73, 0x75, 0x43, 0x65] {
        let mut rig = Rig::new(Gauge::default());
        assert_eq!(rig.raw(&telegram(SLAVE, MASTER, fc)), Some(hex("10 02 08 03 0D 16")), "{fc:02X}");
    }
}

/// profibus-wire 9.1, point 7
#[test]
fn telegrams_for_others_and_those_without_a_reply_are_not_answered() {
    let mut rig = Rig::exchanging(Gauge::default());
    for octets in [
        hex("E5"),
        hex("DC 08 02"),
        hex("DC 08 08"),
        // another station, a response, our own address and 127 as the source
        telegram(9, MASTER, 0x49),
        telegram(SLAVE, 9, 0x08),
        telegram(SLAVE, 9, 0x00),
        telegram(SLAVE, SLAVE, 0x49),
        telegram(SLAVE, 127, 0x49),
        telegram(SLAVE, 127, 0x6D),
        // all stations
        telegram(127, MASTER, 0x49),
        telegram(127, MASTER, 0x4E),
        telegram(127, MASTER, 0x4F),
        telegram(127, MASTER, 0x6D),
        telegram(127, MASTER, 0x75),
        // SDN without a service
        telegram(SLAVE, MASTER, 0x46),
        telegram(SLAVE, MASTER, 0x44),
    ] {
        assert_eq!(rig.raw(&octets), None, "{}", text(&octets));
    }
}

#[test]
fn reserved_and_alternative_function_codes_are_ignored() {
    for fc in 0x40..=0xFFu8 {
        let Control::Request { function, .. } = Control::from_octet(fc) else { continue };
        let ignored = matches!(function, Function::Other(_) | Function::SdnLow | Function::SdnHigh);
        let answer = Rig::new(Gauge::default()).raw(&telegram(SLAVE, MASTER, fc));
        assert_eq!(answer.is_none(), ignored, "{fc:02X}");
    }
}

#[test]
fn priority_makes_no_difference() {
    for (sap, du) in [(60, ""), (61, "80 01 01 00 12 34 00"), (62, "11 21"), (59, ""), (56, ""), (51, ""), (49, "")] {
        let answers = [Function::SrdLow, Function::SrdHigh].map(|function| {
            let fc = Control::Request { function, count: FrameCount::First }.to_octet();
            let du = hex(du);
            let data = DataTelegram { da: SLAVE, sa: MASTER, dsap: Some(sap), ssap: Some(62), fc, du: &du };
            let mut rig = Rig::exchanging(Gauge::default());
            rig.raw(&emit(&Telegram::Data(data)))
        });
        assert_eq!(answers[0], answers[1], "SAP {sap}");
    }
}

/// profibus-wire 10, point 3.
#[test]
fn a_single_access_point_or_an_invalid_one_is_closed() {
    let mut rig = Rig::exchanging(Gauge::default());
    for (dsap, ssap) in [
        (Some(60), None),
        (None, Some(62)),
        (Some(60 | 0x80), Some(62)),
        (Some(60 | 0x40), Some(62)),
        (Some(60), Some(62 | 0x80)),
        (Some(60), Some(62 | 0x40)),
        (Some(63), Some(62)),
        (Some(60), Some(63)),
        (Some(52), Some(62)),
        (Some(54), Some(62)),
    ] {
        assert_eq!(rig.srd(MASTER, dsap, ssap, &[]), RS, "{dsap:?} {ssap:?}");
    }
}

#[test]
fn services_of_ms0_accept_any_source_access_point() {
    let mut rig = Rig::new(Gauge::default());
    for ssap in [0, 50, 54, 62] {
        assert_eq!(rig.srd(MASTER, Some(60), Some(ssap), &[]), low("02 05 00 FF 12 34"), "{ssap}");
    }
}

/// SD3 is the form two open masters use for eight octets; the answer is an SD2.
/// profibus-wire 9.1, point 1
#[test]
fn sd3_is_understood() {
    let gauge = Gauge { configurations: vec![hex("17 27")], inputs: (1..=8).collect(), ..Gauge::default() };
    let mut rig = Rig::new(gauge);
    rig.ms0(MASTER, 61, &hex("80 01 01 00 12 34 00"));
    rig.ms0(MASTER, 62, &hex("17 27"));
    let answer = rig.dialogue("A2 08 02 7D 01 02 03 04 05 06 07 08 AB 16");
    assert_eq!(answer, "68 0B 0B 68 02 08 08 01 02 03 04 05 06 07 08 36 16");
    assert_eq!(rig.device().seen.last(), Some(&Seen::Outputs((1..=8).collect())));
}

/// The answer begins no later than the max T_SDR that the slave declares, 150 bit times at 1.5 Mbit/s.
#[test]
fn an_answer_begins_at_min_tsdr() {
    let at = |rig: &mut Rig| {
        let end = rig.now + 1000;
        let octets = hex("10 08 02 49 53 16");
        let telegram = Telegram::parse(&octets).unwrap();
        rig.slave.telegram(end, &telegram).map(|transmit| transmit.not_before - end)
    };
    let mut rig = Rig::new(Gauge::default());
    assert_eq!(at(&mut rig), Some(11));
    for (reported, holds) in [(20, 20), (0, 20), (150, 150), (151, 150), (255, 150), (1, 11), (11, 11)] {
        assert_eq!(rig.ms0(MASTER, 61, &[0, 1, 1, reported, 0, 0, 0]), Answer::Ack);
        assert_eq!(at(&mut rig), Some(holds), "reported {reported}");
    }
}
