//! Reactions of a slave to invalid requests. profibus-wire 1.8, 2.2 to 2.8, 3.4 and 3.9.

use crate::common;

use common::*;
use profivac_dp::link::{Baud, BitTime};
use profivac_dp::slave::{Features, Slave};
use profivac_sim::stations::Tester;
use profivac_sim::{Fault, Segment, TelegramFault};
use profivac_wire::{DataTelegram, Telegram};

const SC: [u8; 1] = [0xE5];

fn exchanging() -> Talk {
    let mut talk = talk(Plain::new());
    to_data_exch(&mut talk);
    talk
}

/// The diagnosis after a Set_Prm from power-up.
fn diagnosis_after(device: Plain, prm: &[u8]) -> String {
    let mut talk = talk(device);
    assert_eq!(ask(&mut talk, &request(OWN, FIRST, 61, prm)), SC, "always acknowledged");
    diagnosis(&mut talk)
}

fn dpv1() -> Plain {
    Plain { features: Features { dpv1: true, ..Features::default() }, ..Plain::new() }
}

#[test]
fn a_faulty_set_prm_is_acknowledged_and_reported_in_the_diagnosis() {
    for (what, prm) in [
        ("too short", &[0x80, 0, 0, 11, 0x12, 0x34][..]),
        ("empty", &[]),
        ("wrong ident, high", &[0x80, 0, 0, 11, 0x13, 0x34, 0]),
        ("wrong ident, low", &[0x80, 0, 0, 11, 0x12, 0x35, 0]),
        ("watchdog with a factor 0", &[0x88, 0, 1, 11, 0x12, 0x34, 0]),
        ("watchdog with the other factor 0", &[0x88, 1, 0, 11, 0x12, 0x34, 0]),
        ("user parameters the device does not take", &[0x80, 0, 0, 11, 0x12, 0x34, 0, 1]),
    ] {
        assert_eq!(diagnosis_after(Plain::new(), prm), "42 05 00 FF", "{what}");
    }
}

#[test]
fn a_dpv1_slave_checks_reserved_bits_and_lengths() {
    for (what, prm, expected) in [
        ("no user parameters", &[0x80, 0, 0, 11, 0x12, 0x34, 0][..], "02 04 00 02"),
        ("the three octets", &[0x80, 0, 0, 11, 0x12, 0x34, 0, 0x80, 0, 0], "02 04 00 02"),
        ("one octet", &[0x80, 0, 0, 11, 0x12, 0x34, 0, 0x80], "42 05 00 FF"),
        ("two octets", &[0x80, 0, 0, 11, 0x12, 0x34, 0, 0x80, 0], "42 05 00 FF"),
        ("reserved in Station_Status", &[0x81, 0, 0, 11, 0x12, 0x34, 0], "42 05 00 FF"),
        ("reserved in DPV1_Status_1", &[0x80, 0, 0, 11, 0x12, 0x34, 0, 0x08, 0, 0], "42 05 00 FF"),
        ("reserved in DPV1_Status_2", &[0x80, 0, 0, 11, 0x12, 0x34, 0, 0, 0x02, 0], "42 05 00 FF"),
        ("reserved in DPV1_Status_3", &[0x80, 0, 0, 11, 0x12, 0x34, 0, 0, 0, 0x40], "42 05 00 FF"),
        ("publisher of DP-V2", &[0x80, 0, 0, 11, 0x12, 0x34, 0, 0x20, 0, 0], "42 05 00 FF"),
    ] {
        assert_eq!(diagnosis_after(dpv1(), prm), expected, "{what}");
    }
}

#[test]
fn a_dpv0_slave_ignores_reserved_bits() {
    assert_eq!(diagnosis_after(Plain::new(), &[0x87, 0, 0, 11, 0x12, 0x34, 0]), "02 04 00 02");
}

#[test]
fn an_unsupported_function_is_reported_and_set_prm_is_accepted() {
    let device = Plain { features: Features::default(), ..Plain::new() };
    assert_eq!(diagnosis_after(device, &[0xB0, 0, 0, 11, 0x12, 0x34, 0]), "12 04 00 02");
    assert_eq!(diagnosis_after(Plain::new(), &[0xB0, 0, 0, 11, 0x12, 0x34, 0]), "02 04 00 02");
}

#[test]
fn a_wrong_configuration_leads_back_to_wait_prm() {
    for wrong in [&[0x11, 0x22][..], &[0x21, 0x11], &[0x11], &[0x11, 0x21, 0x00], &[], &[0xC1]] {
        let mut talk = talk(Plain::new());
        to_wait_cfg(&mut talk);
        assert_eq!(ask(&mut talk, &request(OWN, FCB_0, 62, wrong)), SC);
        assert_eq!(diagnosis(&mut talk), "06 05 00 FF", "{wrong:02X?}");
    }
}

#[test]
fn a_valid_start_after_an_invalid_one_clears_the_fault() {
    let mut talk = talk(Plain::new());
    ask(&mut talk, &request(OWN, FIRST, 61, &[0x80, 0, 0, 11, 0, 0, 0]));
    assert_eq!(diagnosis(&mut talk), "42 05 00 FF");
    to_wait_cfg(&mut talk);
    ask(&mut talk, &request(OWN, FIRST, 62, &[0x11]));
    assert_eq!(diagnosis(&mut talk), "06 05 00 FF");
    to_data_exch(&mut talk);
    assert_eq!(diagnosis(&mut talk), "00 04 00 02");
}

#[test]
fn a_foreign_master_changes_nothing_while_the_slave_has_an_owner() {
    for octets in [
        request(OTHER, FIRST, 61, &LOCK),
        request(OTHER, FIRST, 61, &[0x40, 0, 0, 0, 0x12, 0x34, 0]),
        request(OTHER, FIRST, 61, &[0x80, 0, 0, 11, 0, 0, 0]),
        request(OTHER, FIRST, 61, &[0x80]),
        request(OTHER, FIRST, 62, &CFG),
        request(OTHER, FIRST, 62, &[0x11]),
    ] {
        let mut talk = exchanging();
        assert_eq!(ask(&mut talk, &octets), SC);
        assert_eq!(diagnosis(&mut talk), "00 04 00 02", "after {octets:02X?}");
    }
}

#[test]
fn a_foreign_master_cannot_exchange_data_or_send_global_control() {
    let mut talk = exchanging();
    assert_eq!(ask(&mut talk, &plain(OTHER, FIRST, &[1, 2])), [0x10, OTHER, TS, 3, 14, 0x16]);
    ask_or_silence(&mut talk, &request(OTHER, 0x46, 58, &[0x02, 0]));
    assert_eq!(talk.station().device().outputs.iter().flatten().count(), 0);
    ask(&mut talk, &plain(OWN, FIRST, &[1, 2]));
    ask_or_silence(&mut talk, &request(OTHER, 0x46, 58, &[0x02, 0]));
    assert_eq!(talk.station().device().outputs.last(), Some(&Some(vec![1, 2])));
}

#[test]
fn after_unlock_another_master_may_take_the_slave() {
    let mut talk = exchanging();
    assert_eq!(ask(&mut talk, &request(OWN, FCB_0, 61, &[0x40, 0, 0, 0, 0x12, 0x34, 0])), SC);
    assert_eq!(diagnosis(&mut talk), "02 05 00 FF");
    assert_eq!(ask(&mut talk, &request(OTHER, FIRST, 61, &LOCK)), SC);
    assert_eq!(diagnosis(&mut talk), "02 04 00 03");
}

#[test]
fn outputs_of_a_wrong_length_are_answered_once_and_end_the_exchange() {
    for wrong in [&[][..], &[1], &[1, 2, 3], &[0; 244]] {
        let mut talk = exchanging();
        ask(&mut talk, &plain(OWN, FCB_0, &[7, 7]));
        assert_eq!(ask(&mut talk, &plain(OWN, FCB_1, wrong))[..4], [0x68, 5, 5, 0x68], "{} octets", wrong.len());
        assert_eq!(talk.station().device().outputs.last(), Some(&None), "outputs are safe");
        assert_eq!(ask(&mut talk, &plain(OWN, FCB_0, &[1, 2])), [0x10, OWN, TS, 3, 13, 0x16]);
        assert_eq!(diagnosis(&mut talk), "02 05 00 FF");
    }
}

#[test]
fn a_single_extension_or_one_of_another_type_is_not_an_access_point() {
    for (dsap, ssap) in [
        (Some(60), None),
        (None, Some(62)),
        (Some(60 | 0x40), Some(62)),
        (Some(60 | 0x80), Some(62)),
        (Some(60), Some(62 | 0x40)),
        (Some(60), Some(63)),
    ] {
        let telegram = DataTelegram { da: TS, sa: OWN, dsap, ssap, fc: FIRST, du: &[] };
        let answer = ask(&mut talk(Plain::new()), &emit(&Telegram::Data(telegram)));
        assert_eq!(answer, [0x10, OWN, TS, 3, 13, 0x16], "{dsap:?} {ssap:?}");
    }
}

#[test]
fn sda_is_not_a_service_of_dp() {
    for fc in [0x43, 0x45, 0x63, 0x55] {
        assert_eq!(ask(&mut talk(Plain::new()), &request(OWN, fc, 61, &LOCK)), [0x10, OWN, TS, 3, 13, 0x16]);
    }
}

#[test]
fn a_slave_does_not_answer_telegrams_for_other_stations() {
    let telegram = |da, sa, fc| emit(&Telegram::Data(DataTelegram { da, sa, dsap: None, ssap: None, fc, du: &[] }));
    let mut cases = vec![
        ("SC", vec![0xE5]),
        ("a token for the slave", vec![0xDC, TS, OWN]),
        ("a token for another", vec![0xDC, OWN, OTHER]),
        ("a request for another", telegram(9, OWN, 0x49)),
        ("a request for all", telegram(127, OWN, 0x49)),
        ("a request from its own address", telegram(TS, TS, 0x49)),
        ("a request from all", telegram(TS, 127, 0x49)),
        ("an answer", telegram(TS, OWN, 0x00)),
        ("Global_Control", request(OWN, 0x46, 58, &[0, 0])),
        ("Global_Control at low priority", request(OWN, 0x44, 58, &[0, 0])),
        ("Slave_Diag as a send without answer", request(OWN, 0x46, 60, &[])),
    ];
    for code in [0x0, 0x1, 0x2, 0x7, 0x8, 0xA, 0xB] {
        cases.push(("a reserved function", telegram(TS, OWN, 0x40 | code)));
        cases.push(("the other table of functions", telegram(TS, OWN, 0xC0 | code)));
    }
    for (what, octets) in cases {
        let mut talk = exchanging();
        assert_eq!(ask_or_silence(&mut talk, &octets), None, "{what}: {octets:02X?}");
        assert_eq!(diagnosis(&mut talk), "00 04 00 02", "{what} changes nothing");
    }
}

/// Slave_Diag of the owner, which the slave answers if it is undamaged.
const SLAVE_DIAG: [u8; 11] = [0x68, 5, 5, 0x68, 0x80 | TS, 0x80 | OWN, FIRST, 60, 62, 0xF1, 0x16];

#[test]
fn a_slave_does_not_answer_a_telegram_with_an_altered_octet() {
    for index in 0..SLAVE_DIAG.len() {
        for flipped in 1..=0xFF {
            let mut octets = SLAVE_DIAG;
            octets[index] ^= flipped;
            let mut talk = talk(Plain::new());
            assert_eq!(ask_or_silence(&mut talk, &octets), None, "octet {index} as {:02X}", octets[index]);
        }
    }
    assert!(ask_or_silence(&mut talk(Plain::new()), &SLAVE_DIAG).is_some());
}

#[test]
fn a_slave_does_not_answer_a_damaged_telegram_and_answers_again_after_t_syn() {
    for bit in 0..11 * SLAVE_DIAG.len() {
        let mut talk = talk(Plain::new());
        let tester = talk.tester();
        talk.segment.inject(Fault::Telegram(tester, TelegramFault::Flip(vec![bit])));
        assert_eq!(ask_or_silence(&mut talk, &SLAVE_DIAG), None, "bit {bit}");
        assert!(talk.ask(33, &SLAVE_DIAG).unwrap().is_some(), "after bit {bit}");
    }
}

#[test]
fn after_a_damaged_telegram_a_slave_answers_only_after_t_syn() {
    for (what, index) in [("the length", 2), ("the data", 8), ("the check octet", 9), ("the end", 10)] {
        let mut damaged = SLAVE_DIAG;
        damaged[index] ^= 1;
        for idle in 0..=33 {
            let mut segment = Segment::new(Baud::B1500000);
            segment.attach(Slave::<_>::new(Plain::new(), TS, Baud::B1500000));
            let tester = segment.attach(Tester::new());
            segment.exempt(tester.id());
            segment.station_mut(tester).send(BitTime(400), &damaged);
            segment.station_mut(tester).send(BitTime(400 + 11 * 11 + idle), &SLAVE_DIAG);
            segment.run_until(BitTime(1000)).unwrap();
            let answers = segment.station(tester).received.len();
            assert_eq!(answers, usize::from(idle == 33), "{what} damaged, {idle} bit times");
        }
    }
}

#[test]
fn a_slave_does_not_answer_a_telegram_with_lost_or_inserted_octets() {
    for index in 0..SLAVE_DIAG.len() {
        for fault in
            [TelegramFault::Lose(index), TelegramFault::Insert(index, 0x10), TelegramFault::Insert(index, 0xFF)]
        {
            let mut talk = talk(Plain::new());
            let tester = talk.tester();
            talk.segment.inject(Fault::Telegram(tester, fault.clone()));
            assert_eq!(ask_or_silence(&mut talk, &SLAVE_DIAG), None, "{fault:?}");
            assert!(talk.ask(400, &SLAVE_DIAG).unwrap().is_some(), "after {fault:?}");
        }
    }
}
