//! MS1: when it is open, the sequence of requests and polls, and refusals. profibus-wire 4.2 to 4.5.

use crate::rig;

use profivac_dp::slave::{Features, Relation, SlaveState};
use profivac_wire::acyclic::AlarmAck;
use rig::{Answer, Gauge, MASTER, RR, RS, Rig, Seen, hex, low, text};

fn waits_for_prm(rig: &Rig) -> bool {
    matches!(rig.slave.state(), SlaveState::WaitPrm(_))
}

/// profibus-wire 4.4 without the early poll: this slave always has its response ready.
#[test]
fn the_printed_dialogue() {
    let mut rig = Rig::exchanging(Gauge::default());
    assert_eq!(rig.dialogue("68 09 09 68 88 82 5C 33 33 5E 01 10 14 4F 16"), "E5");
    let response = "68 0D 0D 68 82 88 08 33 33 5E 01 10 04 11 22 33 44 95 16";
    assert_eq!(rig.dialogue("68 05 05 68 88 82 7C 33 33 EC 16"), response);
    assert_eq!(rig.dialogue("68 0B 0B 68 88 82 7C 33 33 5F 01 20 02 00 64 D2 16"), "E5");
    assert_eq!(rig.dialogue("68 05 05 68 88 82 5C 33 33 CC 16"), "68 09 09 68 82 88 08 33 33 DF 80 B6 00 8D 16");
}

#[test]
fn ms1_opens_and_closes_with_data_exchange() {
    let mut rig = Rig::new(Gauge::default());
    assert_eq!(rig.ms1(""), RS);
    rig.ms0(MASTER, 61, &hex("80 01 01 00 12 34 00 80 00 00"));
    assert_eq!(rig.ms1(""), RS, "WAIT-CFG");
    rig.ms0(MASTER, 62, &hex("11 21"));
    assert_eq!(rig.ms1(""), Answer::Ack);
    rig.ms0(MASTER, 61, &hex("80 01 01 00 12 34 00 80 00 00"));
    assert_eq!(rig.ms1(""), RS, "a new Set_Prm");
}

#[test]
fn ms1_needs_dpv1_enable_and_a_device_with_ms1() {
    let mut rig = Rig::new(Gauge::default());
    rig.start(MASTER, "00 00 00");
    assert_eq!(rig.ms1(""), RS);
    let features = Features { ms1: false, ..Gauge::default().features };
    assert_eq!(Rig::exchanging(Gauge { features, ..Gauge::default() }).ms1(""), RS);
}

#[test]
fn only_the_owner_is_served_from_any_access_point() {
    let mut rig = Rig::exchanging(Gauge::default());
    assert_eq!(rig.srd(3, Some(51), Some(51), &[]), RS);
    // The SIMATIC FC 45 asks from SAP 54.
    assert_eq!(rig.srd(MASTER, Some(51), Some(54), &hex("5E 01 10 04")), Answer::Ack);
    assert_eq!(rig.srd(MASTER, Some(51), Some(54), &[]), low("5E 01 10 04 11 22 33 44"));
}

#[test]
fn an_idle_server_acknowledges_polls() {
    let mut rig = Rig::exchanging(Gauge::default());
    assert_eq!(rig.ms1(""), Answer::Ack);
    assert_eq!(rig.ms1(""), Answer::Ack);
}

#[test]
fn while_a_response_waits_another_request_is_refused_and_changes_nothing() {
    let mut rig = Rig::exchanging(Gauge::default());
    assert_eq!(rig.ms1("5E 01 10 04"), Answer::Ack);
    assert_eq!(rig.ms1("5F 01 10 04 55 66 77 88"), RR);
    assert_eq!(rig.ms1(""), low("5E 01 10 04 11 22 33 44"));
    assert_eq!(rig.device().records[&(1, 16)], [0x11, 0x22, 0x33, 0x44]);
    assert_eq!(rig.ms1(""), Answer::Ack);
}

#[test]
fn a_repeated_poll_gets_the_response_again_and_the_next_poll_nothing() {
    let mut rig = Rig::exchanging(Gauge::default());
    assert_eq!(rig.ms1("5E 01 10 04"), Answer::Ack);
    let response = "68 0D 0D 68 82 88 08 33 33 5E 01 10 04 11 22 33 44 95 16";
    assert_eq!(rig.dialogue("68 05 05 68 88 82 7C 33 33 EC 16"), response);
    assert_eq!(rig.again(), response);
    assert_eq!(rig.again(), response);
    assert_eq!(rig.ms1(""), Answer::Ack);
}

#[test]
fn a_repeated_write_is_executed_once() {
    let mut rig = Rig::exchanging(Gauge::default());
    assert_eq!(rig.ms1("5F 01 10 01 AA"), Answer::Ack);
    assert_eq!(rig.again(), "E5");
    let writes = rig.device().seen.iter().filter(|seen| matches!(seen, Seen::Write(..))).count();
    assert_eq!(writes, 1);
}

#[test]
fn a_request_of_another_master_before_the_poll_changes_nothing() {
    let mut rig = Rig::exchanging(Gauge::default());
    assert_eq!(rig.ms1("5E 01 10 04"), Answer::Ack);
    assert_eq!(rig.ms0(3, 60, &[]), low("00 04 00 02 12 34"));
    assert_eq!(rig.srd(3, Some(51), Some(51), &hex("5E 00 10 04")), RS);
    assert_eq!(rig.dx(MASTER, &[5, 6]), low("01 02"));
    assert_eq!(rig.ms1(""), low("5E 01 10 04 11 22 33 44"));
}

#[test]
fn a_long_record_is_cut_and_a_short_one_keeps_its_length() {
    let mut rig = Rig::exchanging(Gauge::default());
    assert_eq!(rig.ms1_job("5E 01 10 02"), low("5E 01 10 02 11 22"));
    assert_eq!(rig.ms1_job("5E 01 10 F0"), low("5E 01 10 04 11 22 33 44"));
    let whole: Vec<u8> = (0..240).collect();
    rig.device().records.insert((1, 17), whole.clone());
    let Answer::Low(response) = rig.ms1_job("5E 01 11 F0") else { panic!("a response") };
    assert_eq!((&response[..4], &response[4..]), (&hex("5E 01 11 F0")[..], &whole[..]));
    let write: Vec<u8> = hex("5F 01 11 F0").into_iter().chain(whole.iter().rev().copied()).collect();
    assert_eq!(rig.ms1_job(&text(&write)), low("5F 01 11 F0"));
    assert_eq!(rig.device().records[&(1, 17)], whole.iter().rev().copied().collect::<Vec<_>>());
}

#[test]
fn the_device_gets_the_relation_of_every_request() {
    let mut rig = Rig::exchanging(Gauge::default());
    rig.device().seen.clear();
    rig.ms1_job("5E 01 10 04");
    rig.ms1_job("5F 01 10 01 AA");
    let seen = [Seen::Read(Relation::Ms1, 1, 16), Seen::Write(Relation::Ms1, 1, 16, vec![0xAA])];
    assert_eq!(rig.device().seen, seen);
}

/// The table of profibus-wire 4.3.
#[test]
fn malformed_requests_are_refused_by_name() {
    for (request, refusal) in [
        ("5E", "DE 80 B3 00"),
        ("5E 01 10", "DE 80 B3 00"),
        ("5E 01 10 04 00", "DE 80 B3 00"),
        ("5E 01 10 00", "DE 80 B3 00"),
        ("5E 01 10 F1", "DE 80 B3 00"),
        ("5F 01 10 00", "DF 80 B3 00"),
        ("5F 01 10 02 11", "DF 80 B3 00"),
        ("5F 01 10 01 11 22", "DF 80 B3 00"),
        ("5F", "DF 80 B3 00"),
        ("5F 01 10 05 01 02 03 04 05", "DF 80 B1 00"),
        ("5E 09 10 04", "DE 80 B2 00"),
        ("5E 01 63 04", "DE 80 B0 00"),
    ] {
        let mut rig = Rig::exchanging(Gauge::default());
        assert_eq!(rig.ms1_job(request), low(refusal), "{request}");
        assert!(!waits_for_prm(&rig), "{request}");
    }
}

/// profibus-wire 10, point 19: also for the functions only MS2 has, for negative numbers, and for any Alarm_Ack, since no
/// alarm is ever pending.
#[test]
fn an_unknown_function_makes_the_slave_leave() {
    for request in ["00", "48", "51 00 00 01 00", "57 00 00", "58 00 20", "5C 03 02 10", "5C", "DE 80 B0 00", "FF"] {
        let mut rig = Rig::exchanging(Gauge::default());
        assert_eq!(rig.ms1(request), Answer::Ack, "{request}");
        assert!(waits_for_prm(&rig), "{request}");
        assert_eq!(rig.ms1(""), RS, "{request}");
        assert_eq!(rig.dx(MASTER, &[5, 6]), RS, "{request}");
        assert_eq!(rig.ms0(MASTER, 60, &[]), low("02 05 00 FF 12 34"), "{request}");
        assert_eq!(rig.device().seen.last(), Some(&Seen::Exchanging(false)), "{request}");
    }
}

#[test]
fn an_alarm_that_waits_is_acknowledged_once() {
    let alarm = Some(AlarmAck { slot: 3, alarm_type: 2, specifier: 0x10 });
    let mut rig = Rig::exchanging(Gauge { alarm, ..Gauge::default() });
    assert_eq!(rig.ms1("5C 03 02 10"), Answer::Ack);
    assert_eq!(rig.ms1(""), low("5C 03 02 10"));
    assert!(!waits_for_prm(&rig));
    assert_eq!(rig.ms1("5C 03 02 10"), Answer::Ack);
    assert!(waits_for_prm(&rig), "the alarm no longer waits");
}

/// profibus-wire 4.5: a read over SAP 51 does not hold up the acknowledgement.
#[test]
fn a_device_with_extra_alarm_sap_takes_acknowledgements_over_sap_50() {
    let alarm = Some(AlarmAck { slot: 3, alarm_type: 2, specifier: 0x10 });
    let over_50 = |rig: &mut Rig, sa, pdu| rig.srd(sa, Some(50), Some(51), &hex(pdu));
    let mut rig = Rig::exchanging(Gauge { alarm, alarm_access_point: true, ..Gauge::default() });
    assert_eq!(over_50(&mut rig, MASTER, ""), Answer::Ack);
    assert_eq!(over_50(&mut rig, 3, "5C 03 02 10"), RS, "only the owner");
    assert_eq!(rig.ms1("5E 01 10 04"), Answer::Ack);
    assert_eq!(over_50(&mut rig, MASTER, "5C 03 02 10"), Answer::Ack);
    assert_eq!(over_50(&mut rig, MASTER, "5C 03 02 10"), RR, "the response waits");
    assert_eq!(over_50(&mut rig, MASTER, ""), low("5C 03 02 10"));
    assert_eq!(rig.ms1(""), low("5E 01 10 04 11 22 33 44"));
    assert!(!waits_for_prm(&rig));
    for pdu in ["5C 03 02 10", "5E 01 10 04"] {
        let mut rig = Rig::exchanging(Gauge { alarm_access_point: true, ..Gauge::default() });
        assert_eq!(over_50(&mut rig, MASTER, pdu), Answer::Ack);
        assert!(waits_for_prm(&rig), "{pdu}");
    }
}

/// Another master reads the diagnosis without fetching it.
#[test]
fn the_device_learns_that_its_owner_has_fetched_the_diagnosis() {
    let mut rig = Rig::exchanging(Gauge::default());
    let before = rig.slave.device().fetched;
    rig.ms0(3, 60, &[]);
    assert_eq!(rig.slave.device().fetched, before);
    rig.ms0(MASTER, 60, &[]);
    assert_eq!(rig.slave.device().fetched, before + 1);
}

/// profibus-wire 2.1 and 4.5: SAP 50 exists only with Extra_Alarm_SAP; a slave without alarms does not have it.
#[test]
fn a_device_without_extra_alarm_sap_has_no_alarm_access_point() {
    let alarm = |rig: &mut Rig, sa, pdu| rig.srd(sa, Some(50), Some(51), &hex(pdu));
    let mut rig = Rig::new(Gauge::default());
    assert_eq!(alarm(&mut rig, MASTER, ""), RS);
    rig.start(MASTER, "80 00 00");
    for sa in [3, MASTER] {
        for pdu in ["", "5C 03 02 10"] {
            assert_eq!(alarm(&mut rig, sa, pdu), RS, "{sa}: {pdu}");
            assert!(!waits_for_prm(&rig), "{sa}: {pdu}");
        }
    }
}

#[test]
fn a_waiting_response_is_dropped_with_the_relation() {
    let mut rig = Rig::exchanging(Gauge::default());
    assert_eq!(rig.ms1("5E 01 10 04"), Answer::Ack);
    rig.start(MASTER, "80 00 00");
    assert_eq!(rig.ms1(""), Answer::Ack);
}

/// A configuration accepted once more during data exchange does not make the slave leave data exchange: profibus-wire 3.2, transition 10.
#[test]
fn ms1_stays_open_after_a_second_chk_cfg() {
    let mut rig = Rig::exchanging(Gauge::default());
    assert_eq!(rig.ms1("5E 01 10 04"), Answer::Ack);
    assert_eq!(rig.ms0(MASTER, 62, &hex("11 21")), Answer::Ack);
    assert_eq!(rig.ms1(""), low("5E 01 10 04 11 22 33 44"));
}
