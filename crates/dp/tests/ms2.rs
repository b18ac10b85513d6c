//! MS2: opening, using and closing connections. profibus-wire 4.6 to 4.8, 4.10 and 4.12.

use crate::rig;

use profivac_dp::link::Baud;
use profivac_dp::slave::{Features, Relation, SlaveState};
use rig::{Answer, Gauge, INITIATE, MASTER, RR, RS, Rig, Seen, hex, low};

const INVALID_REQUEST: &str = "58 00 12";
const INVALID_ADDRESS: &str = "58 00 17";

fn new() -> Rig {
    Rig::new(Gauge::default())
}

/// profibus-wire 4.6.6 without the early poll.
#[test]
fn the_printed_dialogue() {
    let mut rig = new();
    for (request, answer) in [
        (
            "68 19 19 68 88 82 6C 31 32 57 00 00 00 00 64 01 00 00 00 00 00 00 02 00 02 00 00 00 00 99 16",
            "68 09 09 68 82 88 08 32 31 56 30 00 64 5F 16",
        ),
        (
            "68 05 05 68 88 82 7C 30 32 E8 16",
            "68 15 15 68 82 88 08 32 30 57 F0 01 00 00 00 00 00 00 02 00 02 00 00 00 00 C0 16",
        ),
        ("68 09 09 68 88 82 5C 30 32 5E 00 10 1A 50 16", "E5"),
        ("68 05 05 68 88 82 7C 30 32 E8 16", "68 0D 0D 68 82 88 08 32 30 5E 00 10 04 DE AD BE EF 1E 16"),
        ("68 06 06 68 88 82 5C 30 32 48 10 16", "E5"),
        ("68 05 05 68 88 82 7C 30 32 E8 16", "68 06 06 68 82 88 08 32 30 48 BC 16"),
        ("68 08 08 68 88 82 5C 30 32 58 00 20 40 16", "E5"),
        ("68 05 05 68 88 82 7C 30 32 E8 16", "10 02 08 03 0D 16"),
    ] {
        assert_eq!(rig.dialogue(request), answer, "{request}");
    }
}

#[test]
fn the_least_send_timeout_follows_the_rate() {
    for (baud, least) in Baud::ALL.into_iter().zip(["01 90"; 5].into_iter().chain(["00 C8"]).chain(["00 64"; 4])) {
        let mut rig: Rig = Rig::at(Gauge::default(), baud);
        assert_eq!(rig.ms2(1, 49, INITIATE), low(&format!("56 30 {least}")), "{baud}");
    }
}

#[test]
fn connections_are_numbered_downwards_until_none_is_left() {
    let mut rig: Rig<3> = Rig::at(Gauge::default(), Baud::B1500000);
    assert_eq!([rig.connect(1), rig.connect(1), rig.connect(3)], [48, 47, 46]);
    assert_eq!(rig.ms2(4, 49, ""), RS);
    assert_eq!(rig.ms2(4, 49, INITIATE), RS);
    assert_eq!(rig.ms2(1, 47, "58 00 20"), Answer::Ack);
    assert_eq!(rig.ms2(4, 49, ""), Answer::Ack);
    assert_eq!(rig.connect(4), 47);
}

#[test]
fn a_slave_may_have_no_connection_or_all_49() {
    let mut none: Rig<0> = Rig::at(Gauge::default(), Baud::B1500000);
    assert_eq!(none.ms2(1, 49, INITIATE), RS);
    let mut all: Rig<49> = Rig::at(Gauge::default(), Baud::B1500000);
    let saps: Vec<u8> = (0..49).map(|_| all.connect(1)).collect();
    assert_eq!(saps, (0..49).rev().collect::<Vec<u8>>());
    assert_eq!(all.ms2(1, 49, INITIATE), RS);
    let mut two = new();
    for sap in 0..49 {
        assert_eq!(two.ms2(1, sap, ""), RS, "{sap}");
    }
}

#[test]
fn a_dp_v0_device_has_no_connections() {
    let features = Features { dpv1: false, ms1: false, ..Gauge::default().features };
    let mut rig = Rig::new(Gauge { features, ..Gauge::default() });
    assert_eq!(rig.ms2(1, 49, INITIATE), RS);
    assert_eq!(rig.ms2(1, 48, ""), RS);
}

/// C2_Read_Write_supp of a GSD file does not depend on DPV1_Slave.
#[test]
fn a_device_says_whether_it_has_connections() {
    let features = Features { dpv1: false, ms1: false, ..Gauge::default().features };
    let mut with = Rig::new(Gauge { features, ms2: Some(true), ..Gauge::default() });
    assert_eq!(with.ms2(1, 49, INITIATE), low("56 30 00 64"));
    let mut without = Rig::new(Gauge { ms2: Some(false), ..Gauge::default() });
    assert_eq!(without.ms2(1, 49, INITIATE), RS);
}

/// The table of profibus-wire 4.6.5: the response to the first poll, and RS afterwards.
#[test]
fn an_initiate_that_does_not_fit_is_answered_on_the_announced_access_point() {
    for (initiate, answer) in [
        // S_Type 0 with another length than 2, D_Type 0 likewise
        ("57 00 00 00 00 64 01 00 00 00 00 00 00 03 00 02 00 00 00 00 00", INVALID_REQUEST),
        ("57 00 00 00 00 64 01 00 00 00 00 00 00 02 00 01 00 00 00 00", INVALID_REQUEST),
        // too short
        ("57", INVALID_ADDRESS),
        ("57 00 00 00 00 64 01 00 00 00 00 00 00 02 00 02 00 00 00", INVALID_ADDRESS),
        ("57 00 00 00 00 64 01 00 00 00 00 00 01 0A 00 02 00 00 00 00 00 00 00 00 00 00 00", INVALID_ADDRESS),
        // an end point behind a gateway
        ("57 00 00 00 00 64 01 00 00 00 00 00 00 02 01 08 00 00 00 00 00 00 00 00 00 00", INVALID_ADDRESS),
        // API and SCL of the slave's end, Read and Write not supported
        ("57 00 00 00 00 64 01 00 00 00 00 00 00 02 00 02 00 00 01 00", "D7 80 B8 00"),
        ("57 00 00 00 00 64 01 00 00 00 00 00 00 02 00 02 00 00 00 01", "D7 80 B8 00"),
        ("57 00 00 00 00 64 00 00 00 00 00 00 00 02 00 02 00 00 00 00", "D7 80 A9 00"),
    ] {
        let mut rig = new();
        assert_eq!(rig.ms2(1, 49, initiate), low("56 30 00 64"), "{initiate}");
        assert_eq!(rig.ms2(1, 48, ""), low(answer), "{initiate}");
        assert_eq!(rig.ms2(1, 48, ""), RS, "{initiate}");
        assert_eq!(rig.connect(1), 48, "{initiate}");
    }
}

/// profibus-wire 4.6.1: "RR: request too long"; nothing is reserved then. The GSD files declare the limit.
#[test]
fn an_initiate_longer_than_declared_is_refused() {
    for (length, answer) in [(52, low("56 30 00 64")), (53, RR), (244, RR)] {
        let mut rig = new();
        let initiate = format!("{INITIATE}{}", " 00".repeat(length - 20));
        assert_eq!(rig.ms2(1, 49, &initiate), answer, "{length}");
    }
    let mut rig = new();
    assert_eq!(rig.ms2(1, 49, &format!("{INITIATE}{}", " 00".repeat(33))), RR);
    assert_eq!(rig.connect(1), 48);
}

#[test]
fn another_pdu_to_sap_49_gets_the_rm_pdu_and_no_connection() {
    for pdu in ["5E 00 10 04", "48", "58 00 20", "00", "56 30 00 64", "5E"] {
        let mut rig = new();
        assert_eq!(rig.ms2(1, 49, pdu), low("56 30 00 64"), "{pdu}");
        assert_eq!(rig.ms2(1, 48, ""), RS, "{pdu}");
    }
}

#[test]
fn the_response_swaps_the_ends_and_keeps_the_slaves_own_profile() {
    let mut rig = new();
    let initiate = "57 00 00 00 00 64 FF FF 12 34 97 00 01 0A 00 02 07 01 11 22 33 44 55 66 AA BB 00 00";
    assert_eq!(rig.ms2(1, 49, initiate), low("56 30 00 64"));
    let response = "57 F0 01 00 00 00 00 00 00 02 01 0A 00 00 07 01 11 22 33 44 55 66 AA BB";
    assert_eq!(rig.ms2(1, 48, ""), low(response));
}

#[test]
fn only_the_peer_is_served_and_other_masters_change_nothing() {
    let mut rig = new();
    let sap = rig.connect(1);
    assert_eq!(rig.ms2(1, sap, "5E 00 10 04"), Answer::Ack);
    assert_eq!(rig.ms2(3, sap, ""), RS, "another master");
    assert_eq!(rig.srd(1, Some(sap), Some(51), &[]), RS, "another access point");
    assert_eq!(rig.ms2(3, sap, "58 00 20"), RS);
    assert_eq!(rig.ms2(1, sap, ""), low("5E 00 10 04 DE AD BE EF"));
}

#[test]
fn while_a_response_waits_only_an_abort_is_accepted() {
    let mut rig = new();
    let sap = rig.connect(1);
    for pdu in ["5E 00 10 04", "5F 00 10 01 AA", "48", "51 00 00 01 00", "57", "00"] {
        assert_eq!(rig.ms2(1, sap, "5E 00 10 04"), Answer::Ack);
        assert_eq!(rig.ms2(1, sap, pdu), RR, "{pdu}");
        assert_eq!(rig.ms2(1, sap, ""), low("5E 00 10 04 DE AD BE EF"), "{pdu}");
    }
    assert_eq!(rig.ms2(1, sap, "5E 00 10 04"), Answer::Ack);
    assert_eq!(rig.ms2(1, sap, "58 00 20"), Answer::Ack);
    assert_eq!(rig.ms2(1, sap, ""), RS);
}

#[test]
fn an_abort_is_accepted_in_every_phase() {
    let opening = |rig: &mut Rig| rig.ms2(1, 49, INITIATE);
    let refused = |rig: &mut Rig| rig.ms2(1, 49, "57 00 00 00 00 64 00 00 00 00 00 00 00 02 00 02 00 00 00 00");
    let open = |rig: &mut Rig| {
        rig.connect(1);
        Answer::Ack
    };
    let aborting = |rig: &mut Rig| rig.ms2(1, 49, "57");
    for reach in [opening, refused, open, aborting] as [fn(&mut Rig) -> Answer; 4] {
        let mut rig = new();
        reach(&mut rig);
        assert_eq!(rig.ms2(1, 48, "58 00 20"), Answer::Ack);
        assert_eq!(rig.ms2(1, 48, ""), RS);
        assert_eq!(rig.connect(1), 48);
    }
}

#[test]
fn malformed_requests_are_refused_by_name_and_the_connection_stays() {
    let mut rig = new();
    let sap = rig.connect(1);
    for (request, refusal) in [
        ("5E", "DE 80 B3 00"),
        ("5E 01 10 04 00", "DE 80 B3 00"),
        ("5E 01 10 00", "DE 80 B3 00"),
        ("5E 01 10 F1", "DE 80 B3 00"),
        ("5F 01 10 00", "DF 80 B3 00"),
        ("5F 01 10 02 11", "DF 80 B3 00"),
        ("5F 01 10 05 01 02 03 04 05", "DF 80 B1 00"),
        ("5F 01 20 01 00", "DF 80 B6 00"),
        ("5E 09 10 04", "DE 80 B2 00"),
        ("5E 01 63 04", "DE 80 B0 00"),
        ("51 00 00 00", "D1 80 B3 00"),
        ("51 00 00 02 AA", "D1 80 B3 00"),
        ("51 00 00 01 AA", "D1 80 A9 00"),
    ] {
        assert_eq!(rig.ms2_job(1, sap, request), low(refusal), "{request}");
    }
    assert_eq!(rig.ms2_job(1, sap, "5E 00 10 04"), low("5E 00 10 04 DE AD BE EF"));
}

#[test]
fn an_unknown_function_is_answered_by_an_abort() {
    for request in ["00", INITIATE, "57", "56 30 00 64", "5C 03 02 10", "DE 80 B0 00", "58", "58 00", "FF"] {
        let mut rig = new();
        let sap = rig.connect(1);
        assert_eq!(rig.ms2_job(1, sap, request), low(INVALID_REQUEST), "{request}");
        assert_eq!(rig.ms2(1, sap, ""), RS, "{request}");
    }
}

#[test]
fn a_lost_abort_is_repeated_after_the_connection_has_ended() {
    let mut rig = new();
    let sap = rig.connect(1);
    assert_eq!(rig.ms2(1, sap, "00"), Answer::Ack);
    let abort = rig.dialogue("68 05 05 68 88 81 7C 30 32 E7 16");
    assert_eq!(abort, "68 08 08 68 81 88 08 32 30 58 00 12 DD 16");
    assert_eq!(rig.again(), abort);
    assert_eq!(rig.ms2(1, sap, ""), RS);
}

#[test]
fn idle_comes_back_as_it_was_sent() {
    let mut rig = new();
    let sap = rig.connect(1);
    assert_eq!(rig.ms2_job(1, sap, "48"), low("48"));
    assert_eq!(rig.ms2_job(1, sap, "48 AA BB"), low("48 AA BB"));
}

#[test]
fn records_have_up_to_240_octets() {
    let mut rig = new();
    let sap = rig.connect(1);
    let whole: Vec<u8> = (0..240).collect();
    rig.device().records.insert((0, 17), vec![0; 240]);
    let write: Vec<u8> = [&hex("5F 00 11 F0")[..], &whole].concat();
    assert_eq!(rig.srd(1, Some(sap), Some(50), &write), Answer::Ack);
    assert_eq!(rig.ms2(1, sap, ""), low("5F 00 11 F0"));
    assert_eq!(rig.ms2_job(1, sap, "5E 00 11 F0"), Answer::Low([&hex("5E 00 11 F0")[..], &whole].concat()));
    assert_eq!(rig.ms2_job(1, sap, "5E 00 11 01"), low("5E 00 11 01 00"));
}

#[test]
fn ms2_works_in_every_state_of_ms0_and_changes_none() {
    let mut rig = new();
    let sap = rig.connect(1);
    let read = |rig: &mut Rig| rig.ms2_job(1, sap, "5E 00 10 04");
    let record = low("5E 00 10 04 DE AD BE EF");
    assert_eq!(read(&mut rig), record);
    rig.ms0(MASTER, 61, &hex("80 01 01 00 12 34 00"));
    assert_eq!(read(&mut rig), record, "WAIT-CFG");
    rig.ms0(MASTER, 62, &hex("11 21"));
    assert_eq!(read(&mut rig), record, "DATA-EXCH");
    assert_eq!(rig.dx(MASTER, &[5, 6]), low("01 02"));
    rig.ms0(MASTER, 61, &hex("80 01 01 00 FF FF 00"));
    assert_eq!(read(&mut rig), record, "after Prm_Fault");
    assert!(matches!(rig.slave.state(), SlaveState::WaitPrm(_)));
}

#[test]
fn requests_of_other_masters_before_the_poll_change_nothing() {
    let mut rig = Rig::exchanging(Gauge::default());
    let (first, second) = (rig.connect(1), rig.connect(3));
    assert_eq!(rig.ms2(1, first, "5E 00 10 04"), Answer::Ack);
    assert_eq!(rig.dx(MASTER, &[5, 6]), low("01 02"));
    assert_eq!(rig.ms1_job("5E 01 10 04"), low("5E 01 10 04 11 22 33 44"));
    assert_eq!(rig.ms2_job(3, second, "5E 01 10 02"), low("5E 01 10 02 11 22"));
    assert_eq!(rig.dx(MASTER, &[5, 6]), low("01 02"));
    assert_eq!(rig.ms2(1, first, ""), low("5E 00 10 04 DE AD BE EF"));
}

#[test]
fn the_device_gets_the_number_of_the_connection() {
    let mut rig = new();
    let (first, second) = (rig.connect(1), rig.connect(3));
    rig.ms2_job(1, first, "5E 01 10 04");
    rig.ms2_job(3, second, "5F 01 10 01 AA");
    let seen = [Seen::Read(Relation::Ms2(0), 1, 16), Seen::Write(Relation::Ms2(1), 1, 16, vec![0xAA])];
    assert_eq!(rig.device().seen, seen);
}

#[test]
fn a_new_address_and_a_power_cycle_close_every_connection() {
    let mut rig = new();
    rig.connect(1);
    assert_eq!(rig.ms0(MASTER, 55, &hex("09 12 34 00")), Answer::Ack);
    assert_eq!(rig.ms2(1, 48, ""), RS);
    assert_eq!(rig.connect(1), 48);
    rig.slave.power_up(9);
    assert_eq!(rig.ms2(1, 48, ""), RS);
}
