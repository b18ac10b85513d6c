//! From power-up to data exchange and back: Set_Prm, Chk_Cfg, Get_Cfg and the masters that may send them. profibus-wire 2.2 to 2.7, 3.2
//! and 3.4.

use crate::rig;

use profivac_dp::slave::{Features, SlaveState};
use rig::{Answer, Gauge, MASTER, RR, RS, Rig, Seen, hex, low};

const SET_PRM: u8 = 61;
const CHK_CFG: u8 = 62;
const GET_CFG: u8 = 59;

const LOCK: &str = "80 01 01 00 12 34 00";
const UNLOCK: &str = "40 00 00 00 12 34 00";
const CFG: &str = "11 21";

fn new() -> Rig {
    Rig::new(Gauge::default())
}

fn send(rig: &mut Rig, sa: u8, sap: u8, du: &str) {
    assert_eq!(rig.ms0(sa, sap, &hex(du)), Answer::Ack, "SAP {sap}: {du}");
}

fn wait_cfg() -> Rig {
    let mut rig = new();
    send(&mut rig, MASTER, SET_PRM, LOCK);
    rig
}

fn exchanging() -> Rig {
    let mut rig = wait_cfg();
    send(&mut rig, MASTER, CHK_CFG, CFG);
    rig
}

/// The requests in the order of the first trace of profibus-wire 2.13, with the slave of the examples.
#[test]
fn the_order_of_a_real_master_starts_the_slave() {
    let mut rig = new();
    for (request, answer) in [
        ("10 08 02 49 53 16", "10 02 08 00 0A 16"),
        ("68 05 05 68 88 82 6D 3C 3E F1 16", "68 0B 0B 68 82 88 08 3E 3C 02 05 00 FF 12 34 D8 16"),
        ("68 0C 0C 68 88 82 5D 3D 3E 88 0A 0A 0B 12 34 01 D0 16", "E5"),
        ("68 07 07 68 88 82 7D 3E 3E 11 21 35 16", "E5"),
        ("68 05 05 68 88 82 5D 3C 3E E1 16", "68 0B 0B 68 82 88 08 3E 3C 00 0C 00 02 12 34 E0 16"),
        ("68 05 05 68 08 02 7D AA 55 86 16", "68 05 05 68 02 08 08 01 02 15 16"),
    ] {
        assert_eq!(rig.dialogue(request), answer, "{request}");
    }
    assert_eq!(rig.device().seen.last(), Some(&Seen::Outputs(vec![0xAA, 0x55])));
}

#[test]
fn the_diagnosis_reports_the_state() {
    let mut rig = new();
    assert_eq!(rig.diag(MASTER), "02 05 00 FF");
    send(&mut rig, MASTER, SET_PRM, LOCK);
    assert_eq!(rig.diag(MASTER), "02 04 00 02");
    send(&mut rig, MASTER, SET_PRM, "88 0A 0A 00 12 34 00");
    assert_eq!(rig.diag(MASTER), "02 0C 00 02");
    send(&mut rig, MASTER, CHK_CFG, CFG);
    assert_eq!(rig.diag(MASTER), "00 0C 00 02");
    send(&mut rig, MASTER, SET_PRM, UNLOCK);
    assert_eq!(rig.diag(MASTER), "02 05 00 FF");
}

/// profibus-wire 2.4, the order of evaluation: acknowledged, and reported in the diagnosis.
/// profibus-wire 9.3, point 19
#[test]
fn a_faulty_set_prm_is_prm_fault_from_every_state() {
    for prm in [
        "",
        "80 01 01 00 12 34",
        "80 01 01 00 12 35 00",
        // eight and nine octets, reserved bits in Station_Status and in DPV1_Status_1 to 3, DP-V2
        "80 01 01 00 12 34 00 80",
        "80 01 01 00 12 34 00 80 00",
        "81 01 01 00 12 34 00",
        "84 01 01 00 12 34 00",
        "80 01 01 00 12 34 00 88 00 00",
        "80 01 01 00 12 34 00 90 00 00",
        "80 01 01 00 12 34 00 A0 00 00",
        "80 01 01 00 12 34 00 80 02 00",
        "80 01 01 00 12 34 00 80 00 20",
        "80 01 01 00 12 34 00 80 00 40",
        // watchdog factors of 0
        "88 00 01 00 12 34 00",
        "88 01 00 00 12 34 00",
    ] {
        for mut rig in [new(), wait_cfg(), exchanging()] {
            send(&mut rig, MASTER, SET_PRM, prm);
            assert_eq!(rig.diag(MASTER), "42 05 00 FF", "{prm}");
            assert_eq!(rig.dx(MASTER, &[1, 2]), RS, "{prm}");
        }
    }
}

/// profibus-wire 2.4 refuses reserved bits only. The device gets all octets and may refuse them.
#[test]
fn bits_of_services_that_the_slave_does_not_have_are_accepted() {
    for user in [
        "80 80 00", "80 40 00", "80 20 00", "80 10 00", "80 08 00", "80 04 00", "80 01 00", "80 00 07", "80 00 08",
        "80 00 10", "80 00 80",
    ] {
        let mut rig = new();
        send(&mut rig, MASTER, SET_PRM, &format!("80 01 01 00 12 34 00 {user}"));
        assert_eq!(rig.diag(MASTER), "02 04 00 02", "{user}");
        assert_eq!(rig.device().seen, [Seen::Prm(hex(user))]);
    }
}

#[test]
fn the_device_may_refuse_user_parameters() {
    let mut rig = Rig::new(Gauge { prm_ok: false, ..Gauge::default() });
    send(&mut rig, MASTER, SET_PRM, "80 01 01 00 12 34 00 80 00 00 22 22");
    assert_eq!(rig.diag(MASTER), "42 05 00 FF");
    assert_eq!(rig.device().seen, [Seen::Prm(hex("80 00 00 22 22"))]);
    rig.device().prm_ok = true;
    send(&mut rig, MASTER, SET_PRM, LOCK);
    assert_eq!(rig.diag(MASTER), "02 04 00 02", "the fault is gone with a good one");
}

#[test]
fn a_dp_v0_device_interprets_all_user_parameters_itself() {
    let features = Features { dpv1: false, ms1: false, ..Gauge::default().features };
    for user in ["", "FF", "FF FF", "FF FF FF FF"] {
        let mut rig = Rig::new(Gauge { features, ..Gauge::default() });
        send(&mut rig, MASTER, SET_PRM, &format!("87 01 01 00 12 34 00 {user}"));
        assert_eq!(rig.diag(MASTER), "02 04 00 02", "{user}");
    }
}

#[test]
fn a_slave_without_a_watchdog_ignores_the_factors() {
    let mut rig = new();
    send(&mut rig, MASTER, SET_PRM, "80 00 00 00 12 34 00");
    assert_eq!(rig.diag(MASTER), "02 04 00 02");
}

#[test]
fn a_missing_feature_sets_not_supported_and_is_no_fault() {
    let features = Features { sync: false, freeze: false, ..Gauge::default().features };
    for (prm, bits) in [("A0", "12"), ("90", "12"), ("80", "02")] {
        let mut rig = Rig::new(Gauge { features, ..Gauge::default() });
        send(&mut rig, MASTER, SET_PRM, &LOCK.replacen("80", prm, 1));
        assert_eq!(rig.diag(MASTER), format!("{bits} 04 00 02"));
    }
    let mut rig = new();
    send(&mut rig, MASTER, SET_PRM, &LOCK.replacen("80", "B0", 1));
    assert_eq!(rig.diag(MASTER), "02 04 00 02");
}

/// The table of Lock_Req and Unlock_Req, profibus-wire 2.4 and 3.2, transitions 3, 5 and 6.
#[test]
fn lock_req_and_unlock_req_in_all_combinations() {
    for unlock in ["40", "C0"] {
        let mut rig = exchanging();
        send(&mut rig, MASTER, SET_PRM, &UNLOCK.replacen("40", unlock, 1));
        assert_eq!(rig.diag(MASTER), "02 05 00 FF");
        assert_eq!(rig.device().seen.last(), Some(&Seen::Exchanging(false)));
    }
    let mut rig = exchanging();
    send(&mut rig, MASTER, SET_PRM, "00 00 00 14 FF FF 00");
    assert_eq!(rig.slave.min_tsdr_tbit(), 20, "independent of the ident number");
    assert_eq!(rig.dx(MASTER, &[1, 2]), low("01 02"));
    let mut rig = new();
    send(&mut rig, MASTER, SET_PRM, "00 00 00 14 12 34 00");
    assert_eq!(rig.diag(MASTER), "02 05 00 FF");
}

/// The slave declares its longest T_SDR in the GSD file, and never answers later.
#[test]
fn min_tsdr_is_lowered_to_the_longest_time_of_the_device() {
    for (max_tsdr_tbit, min_tsdr) in [(None, 100), (Some(20), 20), (Some(200), 100), (Some(5), 11)] {
        let mut rig = Rig::new(Gauge { max_tsdr_tbit, ..Gauge::default() });
        send(&mut rig, MASTER, SET_PRM, "00 00 00 64 12 34 00");
        assert_eq!(rig.slave.min_tsdr_tbit(), min_tsdr, "{max_tsdr_tbit:?}");
    }
}

#[test]
fn a_second_set_prm_of_the_owner_leads_back_to_wait_cfg() {
    let mut rig = exchanging();
    send(&mut rig, MASTER, SET_PRM, LOCK);
    assert_eq!(rig.diag(MASTER), "02 04 00 02");
    assert_eq!(rig.dx(MASTER, &[1, 2]), RS);
    let [.., Seen::Safe, Seen::Exchanging(false)] = rig.device().seen[..] else { panic!("outputs are safe") };
}

/// profibus-wire 10, points 6, 7 and 12.
#[test]
fn a_foreign_master_changes_nothing_while_the_slave_is_locked() {
    let foreign = 3;
    for prm in [LOCK, UNLOCK, "00 00 00 14 12 34 00", "80 01 01 00 FF FF 00", ""] {
        for (mut rig, reported) in [(wait_cfg(), "02 04 00 02"), (exchanging(), "00 04 00 02")] {
            send(&mut rig, foreign, SET_PRM, prm);
            send(&mut rig, foreign, CHK_CFG, "FF");
            assert_eq!(rig.diag(foreign), reported, "{prm}");
            assert_eq!(rig.slave.min_tsdr_tbit(), 11, "{prm}");
            assert_eq!(rig.dx(foreign, &[1, 2]), RS, "{prm}");
        }
    }
    let mut rig = exchanging();
    send(&mut rig, MASTER, SET_PRM, UNLOCK);
    send(&mut rig, foreign, SET_PRM, LOCK);
    assert_eq!(rig.diag(MASTER), "02 04 00 03", "unlocked, it is free for any master");
}

#[test]
fn chk_cfg_in_wait_prm_is_acknowledged_and_ignored() {
    let mut rig = new();
    send(&mut rig, MASTER, CHK_CFG, CFG);
    assert_eq!(rig.diag(MASTER), "02 05 00 FF");
    send(&mut rig, MASTER, CHK_CFG, "FF");
    assert_eq!(rig.diag(MASTER), "02 05 00 FF");
}

/// profibus-wire 3.2, transitions 9 and 11.
#[test]
fn a_wrong_configuration_is_cfg_fault() {
    for cfg in ["", "11", "21 11", "11 21 00", "C2", "11 21 11"] {
        for mut rig in [wait_cfg(), exchanging()] {
            send(&mut rig, MASTER, CHK_CFG, cfg);
            assert_eq!(rig.diag(MASTER), "06 05 00 FF", "{cfg}");
            assert_eq!(rig.dx(MASTER, &[1, 2]), RS, "{cfg}");
        }
    }
}

#[test]
fn a_fault_is_reported_until_a_good_set_prm() {
    let mut rig = wait_cfg();
    send(&mut rig, MASTER, CHK_CFG, "FF");
    assert_eq!(rig.diag(MASTER), "06 05 00 FF");
    assert_eq!(rig.diag(MASTER), "06 05 00 FF");
    send(&mut rig, MASTER, SET_PRM, LOCK);
    assert_eq!(rig.diag(MASTER), "02 04 00 02");
}

/// profibus-wire 3.2, transition 10: the same configuration again disturbs nothing, another one begins anew with safe outputs.
#[test]
fn chk_cfg_during_data_exchange_restarts_or_ends_it() {
    let gauge = Gauge { configurations: vec![hex(CFG), hex("21 11")], ..Gauge::default() };
    let mut rig = Rig::exchanging(gauge);
    assert_eq!(rig.dx(MASTER, &[5, 6]), low("01 02"));
    send(&mut rig, MASTER, CHK_CFG, CFG);
    assert_eq!(rig.ms0(MASTER, 57, &[]), low("05 06"));
    send(&mut rig, MASTER, CHK_CFG, "21 11");
    assert_eq!(rig.ms0(MASTER, 57, &[]), low("00 00"));
    assert_eq!(rig.device().seen.last(), Some(&Seen::Safe));
    assert_eq!(rig.ms0(MASTER, GET_CFG, &[]), low("21 11"));
    assert!(matches!(rig.slave.state(), SlaveState::DataExch(..)));
}

/// profibus-wire 2.7
#[test]
fn get_cfg_is_open_to_every_master_in_every_state() {
    for mut rig in [new(), wait_cfg(), exchanging()] {
        let answer = "68 07 07 68 82 88 08 3E 3B 11 21 BD 16";
        assert_eq!(rig.dialogue("68 05 05 68 88 82 5D 3B 3E E0 16"), answer);
        assert_eq!(rig.ms0(3, GET_CFG, &[]), low(CFG));
        assert_eq!(rig.ms0(3, GET_CFG, &[0]), RR);
    }
}

/// Outputs are safe on the way in and on the way out: profibus-wire 3.8.
#[test]
fn outputs_are_safe_outside_data_exchange() {
    let mut rig = exchanging();
    let way_in = [Seen::Prm(Vec::new()), Seen::Safe, Seen::Exchanging(true)];
    assert_eq!(rig.device().seen, way_in);
    rig.device().seen.clear();
    rig.dx(MASTER, &[5, 6]);
    rig.slave.return_to_wait_prm();
    assert_eq!(rig.device().seen, [Seen::Outputs(vec![5, 6]), Seen::Safe, Seen::Exchanging(false)]);
    assert_eq!(rig.diag(MASTER), "02 05 00 FF", "transitions 16 and 17");
    assert_eq!(rig.dx(MASTER, &[5, 6]), RS);
}

/// profibus-wire 2.12: also the one of the functions between masters.
#[test]
fn access_points_that_a_slave_does_not_have_are_closed() {
    for mut rig in [new(), wait_cfg(), exchanging()] {
        // Set_Ext_Prm, Global_Control as SRD, access points 52 and 54
        for sap in [53, 58, 52, 54] {
            assert_eq!(rig.ms0(MASTER, sap, &hex("05 81 00 00 00")), RS, "SAP {sap}");
            assert_eq!(rig.ms0(MASTER, sap, &[]), RS, "SAP {sap}");
        }
    }
}

#[test]
fn power_returns_to_an_unparameterised_slave() {
    let mut rig = exchanging();
    send(&mut rig, MASTER, SET_PRM, "00 00 00 14 12 34 00");
    rig.slave.power_up(9);
    assert_eq!(rig.diag(MASTER), "02 05 00 FF");
    assert_eq!((rig.slave.address(), rig.slave.min_tsdr_tbit()), (9, 11));
    assert_eq!(rig.device().seen.last(), Some(&Seen::Exchanging(false)));
}

/// A device whose images do not fit a telegram cannot exchange data.
#[test]
fn images_that_do_not_fit_a_telegram_are_cfg_fault() {
    for (inputs, outputs) in [(245, 0), (0, 245), (255, 255)] {
        let lengths = Some(profivac_wire::cfg::Lengths { inputs, outputs });
        let mut rig = Rig::new(Gauge { lengths, ..Gauge::default() });
        send(&mut rig, MASTER, SET_PRM, LOCK);
        send(&mut rig, MASTER, CHK_CFG, CFG);
        assert_eq!(rig.diag(MASTER), "06 05 00 FF", "{inputs} and {outputs} octets");
    }
}
