//! I&M0 behind index 255. profibus-wire 5.

use crate::rig;

use rig::{Answer, Gauge, Rig, hex, low};

const SELECT: &str = "5F 00 FF 04 08 00 FD E8";
const SELECTED: &str = "5F 00 FF 04";
const READ: &str = "5E 00 FF 44";
const NOTHING_SELECTED: &str = "DE 80 B5 00";

fn im0() -> Answer {
    let record = Gauge::default().im0.into_iter().flatten();
    Answer::Low(hex("5E 00 FF 44 08 00 FD E8").into_iter().chain(record).collect())
}

/// profibus-wire 5.4
#[test]
fn the_printed_dialogue() {
    let mut rig = Rig::new(Gauge::default());
    rig.connect(2);
    for (request, answer) in [
        ("68 0D 0D 68 88 82 5C 30 32 5F 00 FF 04 08 00 FD E8 17 16", "E5"),
        ("68 05 05 68 88 82 7C 30 32 E8 16", "68 09 09 68 82 88 08 32 30 5F 00 FF 04 D6 16"),
        ("68 09 09 68 88 82 5C 30 32 5E 00 FF 44 69 16", "E5"),
        (
            "68 05 05 68 88 82 7C 30 32 E8 16",
            "68 4D 4D 68 82 88 08 32 30 5E 00 FF 44 08 00 FD E8 20 20 20 20 20 20 20 20 20 20 01 23 44 45 4D 4F 2D \
             31 20 20 20 20 20 20 20 20 20 20 20 20 20 20 30 30 30 30 34 32 20 20 20 20 20 20 20 20 20 20 00 01 56 01 \
             02 03 00 00 00 00 00 00 01 01 00 00 6E 16",
        ),
    ] {
        assert_eq!(rig.dialogue(request), answer, "{request}");
    }
}

#[test]
fn i_and_m0_is_read_through_ms1_as_well() {
    let mut rig = Rig::exchanging(Gauge::default());
    assert_eq!(rig.ms1_job(SELECT), low(SELECTED));
    assert_eq!(rig.ms1_job(READ), im0());
}

#[test]
fn the_selection_holds_for_more_than_one_read_and_a_short_read_is_cut() {
    let mut rig = Rig::new(Gauge::default());
    let sap = rig.connect(1);
    assert_eq!(rig.ms2_job(1, sap, SELECT), low(SELECTED));
    assert_eq!(rig.ms2_job(1, sap, "5E 00 FF 04"), low("5E 00 FF 04 08 00 FD E8"));
    assert_eq!(rig.ms2_job(1, sap, "5E 00 FF F0"), im0());
}

#[test]
fn every_connection_selects_for_itself() {
    let mut rig = Rig::exchanging(Gauge::default());
    let (first, second) = (rig.connect(1), rig.connect(3));
    assert_eq!(rig.ms2_job(1, first, SELECT), low(SELECTED));
    assert_eq!(rig.ms2_job(3, second, READ), low(NOTHING_SELECTED));
    assert_eq!(rig.ms1_job(READ), low(NOTHING_SELECTED));
    assert_eq!(rig.ms2_job(1, first, READ), im0());
}

#[test]
fn the_selection_ends_with_the_connection() {
    let mut rig = Rig::exchanging(Gauge::default());
    let sap = rig.connect(1);
    assert_eq!(rig.ms2_job(1, sap, SELECT), low(SELECTED));
    assert_eq!(rig.ms2(1, sap, "58 00 20"), Answer::Ack);
    assert_eq!(rig.connect(1), sap);
    assert_eq!(rig.ms2_job(1, sap, READ), low(NOTHING_SELECTED));
    assert_eq!(rig.ms1_job(SELECT), low(SELECTED));
    rig.start(2, "80 00 00");
    assert_eq!(rig.ms1_job(READ), low(NOTHING_SELECTED));
}

/// The errors of profibus-wire 5.1.
#[test]
fn a_call_that_does_not_fit_is_refused_by_name() {
    for (request, refusal) in [
        (READ, NOTHING_SELECTED),
        ("5E 01 FF 44", "DE 80 B2 00"),
        ("5F 01 FF 04 08 00 FD E8", "DF 80 B2 00"),
        ("5F 00 FF 04 09 00 FD E8", "DF 80 B8 00"),
        ("5F 00 FF 04 08 00 FD E9", "DF 80 B0 00"),
        ("5F 00 FF 05 08 00 FD E8 00", "DF 80 B6 00"),
        ("5F 00 FF 03 08 00 FD", "DF 80 B6 00"),
    ] {
        let mut rig = Rig::new(Gauge::default());
        let sap = rig.connect(1);
        assert_eq!(rig.ms2_job(1, sap, request), low(refusal), "{request}");
    }
}

#[test]
fn i_and_m0_is_read_only() {
    let mut rig = Rig::new(Gauge::default());
    let sap = rig.connect(1);
    let record = "55 ".repeat(64);
    assert_eq!(rig.ms2_job(1, sap, &format!("5F 00 FF 44 08 00 FD E8 {record}")), low("DF 80 B6 00"));
    assert_eq!(rig.ms2_job(1, sap, &format!("5F 00 FF 44 08 00 FD E9 {record}")), low("DF 80 B0 00"));
}

#[test]
fn a_refused_call_leaves_nothing_selected() {
    let mut rig = Rig::new(Gauge::default());
    let sap = rig.connect(1);
    assert_eq!(rig.ms2_job(1, sap, SELECT), low(SELECTED));
    assert_eq!(rig.ms2_job(1, sap, "5F 00 FF 04 08 00 FD E9"), low("DF 80 B0 00"));
    assert_eq!(rig.ms2_job(1, sap, READ), low(NOTHING_SELECTED));
}

#[test]
fn the_slave_refuses_i_and_m0_without_calling_a_device_that_has_none() {
    let mut rig = Rig::exchanging(Gauge { im0: None, ..Gauge::default() });
    let sap = rig.connect(1);
    rig.device().seen.clear();
    for slot in ["00", "01", "09"] {
        assert_eq!(rig.ms2_job(1, sap, &SELECT.replacen("5F 00", &format!("5F {slot}"), 1)), low("DF 80 B0 00"));
        assert_eq!(rig.ms1_job(&format!("5E {slot} FF 44")), low("DE 80 B0 00"));
    }
    assert_eq!(rig.device().seen, []);
}
