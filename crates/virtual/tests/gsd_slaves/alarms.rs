//! Alarms of a slave by its GSD file. profibus-wire 4.5.
#![allow(clippy::unwrap_used, reason = "a test that cannot go on stops")]

use super::rig::{Rig, order, slave_of};

/// Diagnostic and process alarms, four in sequence mode.
const FILE: &str = "GSD_Revision = 3
DPV1_Slave = 1
C1_Read_Write_supp = 1
Diagnostic_Alarm_supp = 1
Process_Alarm_supp = 1
Alarm_Type_Mode_supp = 1
Alarm_Sequence_Mode_Count = 4
Extra_Alarm_SAP_supp = 1
Max_Diag_Data_Len = 32
Max_User_Prm_Data_Len = 3
Ext_User_Prm_Data_Const(0) = 0x80,0x60,0x00";

/// The diagnosis without a block.
const NOTHING: &str = "00 04 00 02 F0 09";

/// A slave in data exchange with these DP-V1 octets; its diagnosis is fetched.
fn exchanging(dpv1_status: [u8; 3]) -> Rig {
    let mut rig = slave_of(FILE);
    rig.set_prm(0xF009, &dpv1_status);
    rig.chk_cfg(&[0x10]);
    assert_eq!(rig.diag(), NOTHING);
    assert_eq!(rig.dx(&[]), "DL 00");
    rig
}

fn raise(rig: &mut Rig, line: &str) -> String {
    order(&mut rig.slave, line).unwrap()
}

fn refusal(rig: &mut Rig, line: &str) -> String {
    order(&mut rig.slave, line).unwrap_err().to_string()
}

/// Fetches the diagnosis that the slave announces, and returns its blocks.
fn announced(rig: &mut Rig) -> String {
    assert_eq!(rig.dx(&[]), "DH 00");
    rig.diag().strip_prefix(NOTHING).unwrap().trim().to_owned()
}

/// The response to an acknowledgement over an access point.
fn acknowledge(rig: &mut Rig, sap: u8, slot_type_specifier: [u8; 3]) -> String {
    let [slot, alarm_type, specifier] = slot_type_specifier;
    assert_eq!(rig.send(Some(sap), Some(51), &[0x5C, slot, alarm_type, specifier]), "SC");
    rig.send(Some(sap), Some(51), &[])
}

#[test]
fn an_alarm_waits_until_the_master_acknowledges_it() {
    for sap in [51, 50] {
        let mut rig = exchanging([0x80, 0x60, 0]);
        let words = "process alarm of slot 1, sequence number 0, appears: 12 34";
        assert_eq!(raise(&mut rig, "alarm 1 process appears 12 34"), words);
        assert_eq!(announced(&mut rig), "06 02 01 01 12 34");
        assert_eq!(rig.dx(&[]), "DL 00");
        assert_eq!(rig.diag(), format!("{NOTHING} 06 02 01 01 12 34"), "it stays, without Ext_Diag");
        assert!(rig.slave.state().alarms[0].fetched);
        assert_eq!(rig.slave.take_alarm_notices(), [""; 0]);
        assert_eq!(acknowledge(&mut rig, sap, [1, 2, 1]), "DL 5C 01 02 01");
        assert_eq!(rig.slave.take_alarm_notices(), [format!("the master acknowledged the {words}")]);
        assert_eq!(rig.slave.take_alarm_notices(), [""; 0], "taken");
        assert_eq!(announced(&mut rig), "", "the alarm has left the diagnosis");
        assert_eq!(rig.dx(&[]), "DL 00");
    }
}

#[test]
fn in_type_mode_one_alarm_of_each_type_waits() {
    let mut rig = exchanging([0x80, 0x60, 0]);
    raise(&mut rig, "alarm 1 process");
    let sentence = refusal(&mut rig, "alarm 1 process 01");
    assert!(sentence.starts_with("the process alarm of slot 1, sequence number 0"), "{sentence}");
    assert!(sentence.contains("Alarm_Mode 0"), "{sentence}");
    raise(&mut rig, "alarm 0 diagnostic appears");
    assert_eq!(announced(&mut rig), "04 02 01 00");
    assert_eq!(announced(&mut rig), "04 01 00 09", "each alarm is in a diagnosis of its own");
    assert_eq!(acknowledge(&mut rig, 51, [1, 2, 0]), "DL 5C 01 02 00");
    assert_eq!(raise(&mut rig, "alarm 1 process"), "process alarm of slot 1, sequence number 2");
    assert_eq!(rig.slave.state().alarms.len(), 2);
}

#[test]
fn in_sequence_mode_each_alarm_is_in_a_diagnosis_of_its_own() {
    let mut rig = exchanging([0x80, 0x60, 1]);
    raise(&mut rig, "alarm 1 process 01");
    raise(&mut rig, "alarm 1 process 02");
    assert!(refusal(&mut rig, "alarm 1 process 03").starts_with("2 alarms wait"));
    assert_eq!(announced(&mut rig), "05 02 01 00 01");
    assert_eq!(announced(&mut rig), "05 02 01 08 02");
    assert_eq!(rig.dx(&[]), "DL 00", "the master has both");
    assert_eq!(acknowledge(&mut rig, 51, [1, 2, 8]), "DL 5C 01 02 08");
    assert_eq!(announced(&mut rig), "", "the master has fetched the other alarm before");
    assert_eq!(acknowledge(&mut rig, 51, [1, 2, 0]), "DL 5C 01 02 00");
    assert_eq!(rig.dx(&[]), "DL 00");
    // The master sets 32, and the file has 4.
    let mut rig = exchanging([0x80, 0x60, 7]);
    for number in 0..4 {
        let words = raise(&mut rig, "alarm 1 process");
        assert!(words.ends_with(&format!("sequence number {number}")), "{words}");
    }
    assert!(refusal(&mut rig, "alarm 1 process").starts_with("4 alarms wait"));
}

#[test]
fn the_slave_raises_only_what_file_and_master_allow() {
    let too_long = format!("alarm 1 process{}", " 00".repeat(60));
    let beyond_diagnosis = format!("alarm 1 process{}", " 00".repeat(23));
    for (dpv1_status, line, sentence) in [
        (
            [0x80, 0x60, 0],
            "alarm 1 pull",
            "the file has no Pull_Plug_Alarm_supp for slot 1; alarms of this slot: diagnostic alarms, process alarms",
        ),
        ([0x80, 0x60, 0], "alarm 2 process", "no module in slot 2; there are 1 (4DI)"),
        (
            [0x80, 0x20, 0],
            "alarm 1 process",
            "the master has not enabled process alarms: bit 6 of DPV1_Status_2 in Set_Prm is 0",
        ),
        (
            [0x00, 0x60, 0],
            "alarm 1 process",
            "alarms are acknowledged over MS1: the master must set DPV1_Enable in Set_Prm",
        ),
        ([0x80, 0x60, 0], &too_long, "expected at most 59 octets, got 60"),
        (
            [0x80, 0x60, 0],
            &beyond_diagnosis,
            "27 octets of diagnosis behind the first six, 27 of them of an alarm, and the file allows 26",
        ),
    ] {
        let mut rig = exchanging(dpv1_status);
        let refused = refusal(&mut rig, line);
        assert!(refused.starts_with(sentence), "{line}: {refused}");
        assert_eq!((rig.dx(&[]).as_str(), rig.slave.state().alarms.len()), ("DL 00", 0), "{line}");
    }
    let mut rig = slave_of(FILE);
    assert!(refusal(&mut rig, "alarm 1 process").starts_with("no master exchanges data with the slave"));
}

/// A report has no room beside an alarm that waits; without the alarm it has.
#[test]
fn a_report_leaves_room_for_the_alarms_that_wait() {
    let mut rig = exchanging([0x80, 0x60, 0]);
    raise(&mut rig, &format!("alarm 1 process{}", " 00".repeat(22)));
    let refused = refusal(&mut rig, "diagnosis bit 24 on");
    assert!(refused.contains("26 of them of an alarm, and the file allows 26"), "{refused}");
    announced(&mut rig);
    acknowledge(&mut rig, 51, [1, 2, 0]);
    raise(&mut rig, "diagnosis bit 24 on");
    assert_eq!(rig.slave.state().diagnosis, "05 81 00 00 01");
}

#[test]
fn a_wrong_acknowledgement_ends_the_data_exchange_and_discards_the_alarms() {
    for (fetches, specifier) in [(true, 0x08), (false, 0x00)] {
        let mut rig = exchanging([0x80, 0x60, 0]);
        raise(&mut rig, "alarm 1 process");
        if fetches {
            announced(&mut rig);
        }
        assert_eq!(rig.send(Some(51), Some(51), &[0x5C, 1, 2, specifier]), "SC");
        assert_eq!(rig.slave.state().state, "WAIT-PRM", "sequence number or an alarm that the master does not know");
        let notices = rig.slave.take_alarm_notices();
        assert_eq!(notices, ["discarded with the data exchange: the process alarm of slot 1, sequence number 0"]);
        assert!(!rig.slave.state().diagnosis.contains("02 01"));
    }
}
