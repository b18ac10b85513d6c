//! Slaves by their GSD files: what the files say about parameters, configuration, data, diagnosis, records and address.

mod alarms;
mod hostile;
mod rig;

use profivac_dp::link::Baud;
use profivac_virtual::scenario::{MasterPresence, Scenario};
use profivac_virtual::station_spec::StationSpec;
use rig::{GET_CFG, Rig, SET_ADDRESS, folder, opened, order, slave, slave_of};
use std::fs;

/// DPV1_Enable, state without bus: closed; switching time of the valves: 100.
const VALVES_PRM: [u8; 6] = [0x80, 0, 0, 0, 0, 100];

const VALVES: &str = "valves.gsd@9:modules=3+7";
const VALVES_CFG: [u8; 2] = [0x20, 0x11];

fn exchanging() -> Rig {
    let mut rig = Rig::new(slave(VALVES));
    rig.set_prm(0xF001, &VALVES_PRM);
    rig.chk_cfg(&VALVES_CFG);
    assert!(rig.diag().starts_with("00 04 00 02 F0 01"));
    rig
}

#[test]
fn outputs_of_the_master_and_inputs_of_the_user_pass_by_module() {
    let mut rig = exchanging();
    assert_eq!(rig.dx(&[0xA5]), "DL 00 00");
    order(&mut rig.slave, "input 2 16#1F 80").unwrap();
    assert_eq!(rig.dx(&[0x5A]), "DL 1F 80");
    order(&mut rig.slave, "input 2 bit 8 on").unwrap();
    order(&mut rig.slave, "input 2 at 0 00").unwrap();
    assert_eq!(rig.dx(&[0x5A]), "DL 00 81");
    let state = rig.slave.state();
    assert_eq!((state.state.as_str(), state.master, state.outputs_safe), ("DATA-EXCH", Some(2), false));
    let shown: Vec<_> =
        state.modules.iter().map(|one| (one.slot, one.name.as_str(), &*one.inputs, &*one.outputs)).collect();
    assert_eq!(shown, [(1, "8 valves", "", "5A"), (2, "16 limit switches", "00 81", "")]);
}

#[test]
fn inputs_beyond_a_module_are_refused_with_the_slots_that_have_inputs() {
    let mut slave = slave(VALVES);
    for (line, sentence) in [
        ("input 1 00", "slot 1 (8 valves) has 0 octets of inputs, got 1; slots with inputs: 2"),
        ("input 2 00 00 00", "slot 2 (16 limit switches) has 2 octets of inputs, got 3; slots with inputs: 2"),
        ("input 2 at 1 00 00", "slot 2 (16 limit switches) has 2 octets of inputs, got 3; slots with inputs: 2"),
        ("input 2 bit 16 on", "slot 2 (16 limit switches) has 2 octets of inputs, got 3; slots with inputs: 2"),
        ("input 3 00", "no module in slot 3; there are 1 (8 valves), 2 (16 limit switches)"),
    ] {
        assert_eq!(order(&mut slave, line).unwrap_err().to_string(), sentence, "{line}");
    }
    assert_eq!(slave.state().modules[1].inputs, "00 00");
}

#[test]
fn the_slave_shows_the_parameters_of_the_master_by_name() {
    let mut rig = Rig::new(slave(VALVES));
    rig.set_prm(0xF001, &[0x80, 0, 0, 1, 1, 0xF4]);
    let state = rig.slave.state();
    let shown: Vec<_> =
        state.parameters.iter().map(|one| (&*one.place, &*one.name, one.value, one.text.as_deref())).collect();
    assert_eq!(shown, [("the station", "State without bus", 1, Some("open")), ("slot 1", "Switching time", 500, None)]);
}

#[test]
fn wrong_parameters_are_prm_fault_and_the_user_reads_why() {
    for (user, why) in [
        (&[0x80, 0, 0, 0, 0][..], "Set_Prm: expected 6 octets of user parameters for the plugged modules, got 5"),
        (&[0x80, 0, 0, 0, 0, 9], "Set_Prm: slot 1: Switching time cannot be 9; possible are 10 to 1000"),
        (&[0x80, 0, 0, 0, 3, 0xE9], "Set_Prm: slot 1: Switching time cannot be 1001; possible are 10 to 1000"),
    ] {
        let mut rig = Rig::new(slave(VALVES));
        rig.set_prm(0xF001, user);
        assert!(rig.diag().starts_with("42 05 00 FF"), "{why}");
        assert_eq!(rig.slave.take_refusal().as_deref(), Some(why));
        assert_eq!(rig.slave.take_refusal(), None, "taken");
        rig.set_prm(0xF001, user);
        assert_eq!(rig.slave.take_refusal(), None, "a master repeats it, and the user has read it");
        rig.set_prm(0xF001, &VALVES_PRM);
        rig.chk_cfg(&VALVES_CFG);
        assert_eq!(rig.slave.state().refused, None);
    }
    let mut rig = Rig::new(slave(VALVES));
    rig.set_prm(0xF002, &VALVES_PRM);
    assert!(rig.diag().starts_with("42 05 00 FF"), "another ident");
}

/// GSD_Revision 1: a master that does not know Ext_User_Prm_Data sends User_Prm_Data.
#[test]
fn a_value_outside_the_list_of_a_bit_area_is_refused() {
    for (direction, diag) in [(0, "02 04 00 02"), (1, "42 05 00 FF"), (2, "02 04 00 02"), (3, "42 05 00 FF")] {
        let mut rig = Rig::new(slave("encoder.gsd@9:modules=1"));
        rig.set_prm(0xF002, &[direction, 0x0A, 0]);
        assert!(rig.diag().starts_with(diag), "{direction}: {}", rig.diag());
    }
}

#[test]
fn the_slave_accepts_exactly_the_configuration_of_its_modules() {
    for cfg in [&[0x20][..], &[0x11, 0x20], &[0x20, 0x11, 0x00], &[0x20, 0x10], &[]] {
        let mut rig = Rig::new(slave(VALVES));
        rig.set_prm(0xF001, &VALVES_PRM);
        rig.chk_cfg(cfg);
        assert!(rig.diag().starts_with("06 05 00 FF"), "{cfg:02X?}");
        let why = rig.slave.take_refusal().unwrap();
        assert!(why.starts_with("Chk_Cfg: expected 20 11, got"), "{why}");
    }
    assert_eq!(exchanging().ms0(GET_CFG, &[]), "DL 20 11");
}

#[test]
fn modules_come_from_the_file_the_command_line_or_a_toml_file() {
    let plugged = |spec: &str| {
        let state = slave(spec).state();
        state.modules.iter().map(|one| (one.slot, one.module)).collect::<Vec<_>>()
    };
    assert_eq!(plugged("pressure.gsd@9"), [(1, 1), (2, 2)], "preset");
    assert_eq!(plugged("encoder.gsd@9:modules=2"), [(1, 2)]);
    assert_eq!(plugged("valves.gsd@9:modules=9+3"), [(1, 9), (2, 3)]);
    let folder = tempfile::tempdir().unwrap();
    let setup = folder.path().join("setup.toml");
    fs::write(&setup, "[modules]\n1 = \"16 limit switches\"\n3 = \"8 valves\"\n").unwrap();
    assert_eq!(plugged(&format!("valves.gsd@9:setup={}", setup.display())), [(1, 7), (3, 3)]);
}

#[test]
fn a_slave_that_cannot_be_built_is_an_error_that_says_what_is_possible() {
    for (text, sentence) in [
        ("encoder.gsd@9", "it has 1 (Class 1), 2 (Class 2); write FILE.gsd@ADDR:modules=NUMBER+NUMBER"),
        ("valves.gsd@9:modules=4", "the file has no module 4; it has 3 (8 valves), 7 (16 limit switches), 9 (Propor"),
        ("valves.gsd@9:modules=3+3+3+3+3", "5 modules; the station takes at most 4"),
        ("nothing.gsd@9", "nothing.gsd cannot be read"),
    ] {
        let StationSpec::Slave(spec) = text.parse().unwrap() else { panic!("{text}") };
        let Err(error) = spec.in_folder(folder()).open(Baud::B19200, None) else { panic!("{text}") };
        assert!(error.to_string().contains(sentence), "{text}: {error}");
    }
    let StationSpec::Slave(spec) = VALVES.parse().unwrap() else { panic!() };
    let Err(error) = spec.in_folder(folder()).open(Baud::B12000000, None) else { panic!() };
    let sentence = "the GSD file does not have 12 Mbit/s; it has 9.6 kbit/s, 19.2 kbit/s, 93.75 kbit/s";
    assert!(error.to_string().contains(sentence), "{error}");
}

/// The types of the file's UnitDiagType are the first octet of a DP-V1 block.
#[test]
fn a_bit_and_an_area_of_the_diagnosis_are_reported_in_the_words_of_the_file() {
    let mut rig = exchanging();
    assert_eq!(rig.dx(&[0]), "DL 00 00");
    assert_eq!(order(&mut rig.slave, "diagnosis bit 24 on").unwrap(), "Supply of valves missing");
    assert_eq!(rig.dx(&[0]), "DH 00 00", "the slave announces it");
    assert_eq!(rig.diag(), "08 04 00 02 F0 01 06 81 00 00 01 00");
    assert_eq!(rig.dx(&[0]), "DL 00 00", "the master has fetched it");
    let both = order(&mut rig.slave, "diagnosis area 32-39 pressure too low").unwrap();
    assert_eq!(both, "Supply of valves missing; Pressure too low");
    assert_eq!(rig.diag(), "08 04 00 02 F0 01 06 81 00 00 01 05");
    order(&mut rig.slave, "diagnosis bit 24 off").unwrap();
    assert_eq!(order(&mut rig.slave, "diagnosis area 32-39 0").unwrap(), "");
    assert_eq!(rig.diag(), "00 04 00 02 F0 01");
    let refused = order(&mut rig.slave, "diagnosis area 32-39 high").unwrap_err().to_string();
    let expected =
        "expected for the bits 32 to 39 a number from 0 to 255, or a text: 5 (Pressure too low), got \"high\"";
    assert_eq!(refused, expected);
}

/// Unit_Diag_!Bit: the text counts when the bit is not set. The types of the file have such bits of their own.
#[test]
fn inverted_bits_are_set_while_they_have_nothing_to_say() {
    let mut rig = slave_of("Max_Diag_Data_Len = 16\nUnit_Diag_!Bit(3) = \"No air\"\nUnit_Diag_Bit(8) = \"Hot\"");
    rig.set_prm(0xF009, &[]);
    rig.chk_cfg(&[0x10]);
    assert_eq!(order(&mut rig.slave, "diagnosis bit 8 on").unwrap(), "Hot");
    assert_eq!(rig.diag(), "08 04 00 02 F0 09 03 08 01");
    assert_eq!(order(&mut rig.slave, "diagnosis bit 3 off").unwrap(), "No air; Hot");
    assert_eq!(rig.diag(), "08 04 00 02 F0 09 03 00 01");
    let mut rig = slave_of(
        "Max_Diag_Data_Len = 16\nDPV1_Slave = 1\nUnit_Diag_!Bit(29) = \"Not this\"\nUnitDiagType = 0x81\nX_Unit_Diag_!Bit(24) = \"No air\"
X_Unit_Diag_Bit(25) = \"Hot\"\nEndUnitDiagType\nUnitDiagType = 0xA0\nX_Unit_Diag_!Bit(26) = \"No oil\"\nX_Unit_Diag_Bit(27) = \"Wet\"
EndUnitDiagType",
    );
    rig.set_prm(0xF009, &[0x80, 0, 0]);
    rig.chk_cfg(&[0x10]);
    assert_eq!(order(&mut rig.slave, "diagnosis bit 25 on").unwrap(), "Hot");
    assert_eq!(rig.diag(), "08 04 00 02 F0 09 05 81 00 00 03");
    assert_eq!(order(&mut rig.slave, "diagnosis bit 25 off").unwrap(), "");
    assert_eq!(rig.diag(), "00 04 00 02 F0 09");
    // Another type.
    order(&mut rig.slave, "diagnosis area 0-7 160").unwrap();
    assert_eq!(order(&mut rig.slave, "diagnosis bit 27 on").unwrap(), "Wet");
    assert_eq!(rig.diag(), "08 04 00 02 F0 09 05 A0 00 00 0C");
    assert_eq!(order(&mut rig.slave, "diagnosis bit 26 off").unwrap(), "No oil; Wet");
    // No type of the file.
    assert_eq!(order(&mut rig.slave, "diagnosis area 0-7 130").unwrap(), "");
    assert_eq!(rig.diag(), "08 04 00 02 F0 09 05 82 00 00 28");
    order(&mut rig.slave, "diagnosis none").unwrap();
    assert_eq!(rig.diag(), "00 04 00 02 F0 09");
}

#[test]
fn the_number_of_an_area_may_have_all_its_bits_and_no_more() {
    let mut rig = slave_of("Max_Diag_Data_Len = 16");
    let highest = u64::MAX;
    order(&mut rig.slave, &format!("diagnosis area 0-63 {highest}")).unwrap();
    assert_eq!(rig.slave.state().diagnosis, "09 FF FF FF FF FF FF FF FF");
    assert!(order(&mut rig.slave, "diagnosis area 0-63 18446744073709551616").is_err());
    order(&mut rig.slave, "diagnosis area 0-2 7").unwrap();
    let refused = order(&mut rig.slave, "diagnosis area 0-2 8").unwrap_err().to_string();
    assert_eq!(refused, "expected for the bits 0 to 2 a number from 0 to 7, got \"8\"");
    order(&mut rig.slave, "diagnosis area 1-1 1").unwrap();
    assert!(order(&mut rig.slave, "diagnosis area 1-1 2").is_err());
}

/// Whether the slave accepts user parameters; otherwise why not.
fn answer_to_prm(statements: &str, user: &[u8]) -> Result<(), String> {
    let mut rig = slave_of(statements);
    rig.set_prm(0xF009, user);
    rig.chk_cfg(&[0x10]);
    let refusal = rig.slave.take_refusal();
    if rig.slave.is_exchanging() { Ok(()) } else { Err(refusal.unwrap_or_default()) }
}

/// Fail_Safe_required counts for a DP-V1 slave, whose first octet has the bit. profibus-wire 2.4.
#[test]
fn fail_safe_is_demanded_of_a_dp_v1_master_alone() {
    let v1 = "DPV1_Slave = 1\nFail_Safe = 1\nFail_Safe_required = 1";
    assert_eq!(answer_to_prm(v1, &[0xC0, 0, 0]), Ok(()));
    let refused =
        Err("Set_Prm: expected Fail_Safe in the first DP-V1 octet: the file has Fail_Safe_required".to_owned());
    assert_eq!(answer_to_prm(v1, &[0x80, 0, 0]), refused);
    assert_eq!(answer_to_prm(v1, &[]), refused, "no octets have no Fail_Safe");
    assert_eq!(answer_to_prm("DPV1_Slave = 1\nFail_Safe = 1", &[0x80, 0, 0]), Ok(()));
    assert_eq!(answer_to_prm("Fail_Safe = 1\nFail_Safe_required = 1", &[]), Ok(()), "DP-V0");
}

/// A master that does not know Ext_User_Prm_Data sends User_Prm_Data.
#[test]
fn short_parameters_are_those_of_user_prm_data_or_a_dp_v1_status_left_out() {
    let lengths = |statements: &str, all: &[usize]| -> Vec<usize> {
        let status = |length: usize| [0x80, 0, 0, 0, 0, 0].into_iter().take(length).collect::<Vec<u8>>();
        all.iter().copied().filter(|length| answer_to_prm(statements, &status(*length)).is_ok()).collect()
    };
    let all = [0, 1, 2, 3, 4, 5, 6];
    let plain = "User_Prm_Data_Len = 2\nUser_Prm_Data = 0x80, 0\nMax_User_Prm_Data_Len = 5\nExt_User_Prm_Data_Const(0) = 0x80, 0, 0, 0, 0";
    assert_eq!(lengths(plain, &all), [2, 5]);
    assert_eq!(
        lengths("DPV1_Slave = 1\nMax_User_Prm_Data_Len = 3\nExt_User_Prm_Data_Const(0) = 0x80, 0, 0", &all),
        [0, 3]
    );
    assert_eq!(lengths("Max_User_Prm_Data_Len = 3\nExt_User_Prm_Data_Const(0) = 0x80, 0, 0", &all), [3], "DP-V0");
    let longer = "DPV1_Slave = 1\nMax_User_Prm_Data_Len = 4\nExt_User_Prm_Data_Const(0) = 0x80, 0, 0, 0";
    assert_eq!(lengths(longer, &all), [4]);
    assert_eq!(lengths("Max_Diag_Data_Len = 16", &all), [0], "no parameters at all");
}

#[test]
fn a_channel_error_has_its_identifier_and_its_direction() {
    let mut rig = exchanging();
    let text = order(&mut rig.slave, "channel-error 2 3 short circuit on").unwrap();
    assert_eq!(text, "slot 2 channel 3: Short circuit");
    // Identifier 1 of two, an input.
    assert_eq!(rig.diag(), "08 04 00 02 F0 01 42 02 81 43 21");
    order(&mut rig.slave, "channel-error 1 0 6 on").unwrap();
    assert_eq!(rig.diag(), "08 04 00 02 F0 01 42 03 80 80 26 81 43 21");
    let refused = order(&mut rig.slave, "channel-error 1 0 burnt on").unwrap_err().to_string();
    assert!(refused.ends_with("got \"burnt\"; texts of the file: 1 (Short circuit), 6 (Line break)"), "{refused}");
    order(&mut rig.slave, "diagnosis none").unwrap();
    assert_eq!(rig.diag(), "00 04 00 02 F0 01");
}

#[test]
fn a_diagnosis_is_never_longer_than_the_file_allows() {
    let mut rig = exchanging();
    let mut reported = 0;
    let refused = loop {
        match order(&mut rig.slave, &format!("channel-error 2 {reported} 1 on")) {
            Ok(_) => reported += 1,
            Err(refused) => break refused.to_string(),
        }
    };
    // 32 octets without the first six are room for eight errors of three octets; without that for the identifiers.
    assert_eq!(reported, 8);
    assert_eq!(
        refused,
        "27 octets of diagnosis behind the first six, and the file allows 26; end another report first"
    );
    assert_eq!(rig.diag().split(' ').count(), 6 + 2 + 24);
    let refused = order(&mut rig.slave, "diagnosis bit 200 on").unwrap_err().to_string();
    assert_eq!(refused, "expected a bit from 0 to 199: the file allows no longer diagnosis");
}

#[test]
fn a_dp_v0_slave_reports_the_bits_behind_its_header() {
    let mut rig = Rig::new(slave("encoder.gsd@9:modules=2"));
    rig.set_prm(0xF002, &[0, 10, 0]);
    rig.chk_cfg(&[0xF1]);
    assert_eq!(rig.dx(&[0, 1, 2, 3]), "DL 00 00 00 00");
    assert_eq!(order(&mut rig.slave, "diagnosis area 4-7 Battery low").unwrap(), "Battery low");
    assert_eq!(order(&mut rig.slave, "diagnosis bit 0 on").unwrap(), "Code disc dirty; Battery low");
    assert_eq!(rig.diag(), "08 04 00 02 F0 02 02 31");
    order(&mut rig.slave, "input 1 u32:305419896").unwrap();
    assert_eq!(rig.dx(&[0, 1, 2, 3]), "DH 12 34 56 78".replace("DH", "DL"));
}

/// Fail_Safe of a DP-V0 file needs no bit of Set_Prm.
#[test]
fn outputs_are_safe_in_clear_and_with_empty_outputs() {
    let mut rig = Rig::new(slave("encoder.gsd@9:modules=2"));
    rig.set_prm(0xF002, &[0, 10, 0]);
    rig.chk_cfg(&[0xF1]);
    let shown = |rig: &Rig| (rig.slave.state().modules[0].outputs.clone(), rig.slave.state().outputs_safe);
    rig.dx(&[1, 2, 3, 4]);
    assert_eq!(shown(&rig), ("01 02 03 04".to_owned(), false));
    rig.dx(&[]);
    assert_eq!(shown(&rig), ("00 00 00 00".to_owned(), true));
    rig.dx(&[1, 2, 3, 4]);
    rig.control(0x02);
    assert_eq!(shown(&rig), ("00 00 00 00".to_owned(), true), "Clear_Data");
    assert!(rig.slave.is_exchanging());
}

#[test]
fn sync_and_freeze_are_understood_if_the_file_says_so() {
    let mut rig = exchanging();
    rig.dx(&[1]);
    rig.control(0x20 | 0x08);
    order(&mut rig.slave, "input 2 FF FF").unwrap();
    assert_eq!(rig.dx(&[2]), "DL 00 00", "frozen");
    assert_eq!(rig.slave.state().modules[0].outputs, "01", "held");
    let mut rig = Rig::new(slave("encoder.gsd@9:modules=1"));
    rig.set_prm(0xF002, &[0, 10, 0]);
    rig.chk_cfg(&[0xD1]);
    rig.control(0x08);
    assert!(rig.diag().starts_with("10 04 00 02"), "Not_Supported: {}", rig.diag());
}

#[test]
fn records_are_read_and_written_over_ms1_and_ms2() {
    let mut rig = exchanging();
    order(&mut rig.slave, "record 1 20 DE AD BE EF").unwrap();
    let ms1 = |rig: &mut Rig, pdu: &[u8]| {
        assert_eq!(rig.send(Some(51), Some(51), pdu), "SC");
        rig.send(Some(51), Some(51), &[])
    };
    assert_eq!(ms1(&mut rig, &[0x5E, 1, 20, 240]), "DL 5E 01 14 04 DE AD BE EF");
    assert_eq!(ms1(&mut rig, &[0x5F, 1, 20, 2, 1, 2]), "DL 5F 01 14 02");
    assert_eq!(order(&mut rig.slave, "record 1 20").unwrap(), "01 02");
    assert_eq!(ms1(&mut rig, &[0x5E, 1, 21, 240]), "DL DE 80 B0 00", "invalid index");
    assert_eq!(ms1(&mut rig, &[0x5E, 3, 20, 240]), "DL DE 80 B2 00", "invalid slot");
    let long = [&[0x5F, 1, 20, 33][..], &[0; 33]].concat();
    assert_eq!(ms1(&mut rig, &long), "DL DF 80 B1 00", "longer than C1_Max_Data_Len");
    let initiate = [0x57, 0, 0, 0, 0, 0x64, 1, 0, 0, 0, 0, 0, 0, 2, 0, 2, 0, 0, 0, 0];
    let opened = rig.send(Some(49), Some(50), &initiate);
    assert!(opened.starts_with("DL 56 30"), "{opened}");
    let ms2 = |rig: &mut Rig, pdu: &[u8]| rig.send(Some(48), Some(50), pdu);
    assert!(ms2(&mut rig, &[]).starts_with("DL 57"));
    assert_eq!(ms2(&mut rig, &[0x5E, 1, 20, 240]), "SC");
    assert_eq!(ms2(&mut rig, &[]), "DL 5E 01 14 02 01 02");
    // I&M0, whose order number begins at its octet 13.
    assert_eq!(ms2(&mut rig, &[0x5F, 0, 255, 4, 8, 0, 0xFD, 0xE8]), "SC");
    assert_eq!(ms2(&mut rig, &[]), "DL 5F 00 FF 04");
    assert_eq!(ms2(&mut rig, &[0x5E, 0, 255, 68]), "SC");
    let im0 = ms2(&mut rig, &[]);
    assert!(im0.contains("45 58 2D 56 41 4C 56 45 53 20"), "EX-VALVES: {im0}");
}

#[test]
fn a_slave_without_ms1_or_ms2_closes_them() {
    let initiate = [0x57, 0, 0, 0, 0, 0x64, 1, 0, 0, 0, 0, 0, 0, 2, 0, 2, 0, 0, 0, 0];
    let mut encoder = Rig::new(slave("encoder.gsd@9:modules=1"));
    assert_eq!(encoder.send(Some(49), Some(50), &initiate), "RS");
    let refused = order(&mut encoder.slave, "record 1 20 00").unwrap_err().to_string();
    assert!(refused.contains("neither C1_Read_Write_supp nor C2_Read_Write_supp"), "{refused}");
    let mut transmitter = Rig::new(slave("pressure.gsd@9"));
    assert!(transmitter.send(Some(49), Some(50), &initiate).starts_with("DL 56 30"));
    transmitter.set_prm(0xF003, &[0x80, 0, 0]);
    transmitter.chk_cfg(&[0x42, 0x84, 8, 5, 0x42, 0x84, 8, 5]);
    assert_eq!(transmitter.send(Some(51), Some(51), &[0x5E, 1, 20, 240]), "RS", "no C1_Read_Write_supp");
    order(&mut transmitter.slave, "input 2 float:-1.5 80").unwrap();
    assert_eq!(transmitter.dx(&[]), "DL 00 00 00 00 00 BF C0 00 00 80");
}

#[test]
fn address_and_records_survive_the_program_in_a_folder() {
    let folder = tempfile::tempdir().unwrap();
    let record: Vec<_> = (0..32).map(|octet| format!("{octet:02X}")).collect();
    {
        let mut rig = Rig::new(opened(VALVES, Some(folder.path())));
        order(&mut rig.slave, &format!("record 1 20 {}", record.join(" "))).unwrap();
        order(&mut rig.slave, "record 0 1 FF").unwrap();
        assert_eq!(rig.ms0(SET_ADDRESS, &[17, 0xF0, 1, 1]), "SC");
        assert_eq!(rig.slave.station_address(), 17);
    }
    let mut rig = Rig::new(opened(VALVES, Some(folder.path())));
    assert_eq!((rig.slave.station_address(), rig.slave.switch_address()), (17, 9));
    assert_eq!(order(&mut rig.slave, "record 1 20").unwrap(), record.join(" "));
    assert_eq!(order(&mut rig.slave, "record 0 1").unwrap(), "FF");
    assert_eq!(rig.ms0(SET_ADDRESS, &[18, 0xF0, 1, 0]), "SC");
    assert_eq!(rig.slave.station_address(), 17, "No_Add_Chg");
    let mut encoder = Rig::new(slave("encoder.gsd@9:modules=1"));
    assert_eq!(encoder.ms0(SET_ADDRESS, &[17, 0xF0, 2, 0]), "RS", "no Set_Slave_Add_supp");
}

#[test]
fn min_tsdr_is_never_above_the_file_s_longest_time() {
    let mut rig = Rig::new(slave(VALVES));
    let [high, low] = 0xF001_u16.to_be_bytes();
    rig.ms0(rig::SET_PRM, &[0, 0, 0, 60, high, low, 0]);
    let end = profivac_dp::link::BitTime(1_000_000);
    let ask = profivac_wire::DataTelegram { da: 9, sa: 3, dsap: None, ssap: None, fc: 0x49, du: &[] };
    let answer = profivac_dp::link::Station::telegram(&mut rig.slave, end, &profivac_wire::Telegram::Data(ask));
    assert_eq!(answer.unwrap().not_before, end + 40, "MaxTsdr_19.2");
}

#[test]
fn power_and_connector_take_the_slave_from_the_bus() {
    let mut rig = exchanging();
    order(&mut rig.slave, "input 2 12 34").unwrap();
    rig.dx(&[7]);
    rig.slave.set_connected(false);
    assert_eq!(rig.dx(&[7]), "silence");
    rig.slave.set_connected(true);
    rig.slave.set_power(false);
    assert_eq!(rig.dx(&[7]), "silence");
    let state = rig.slave.state();
    assert_eq!((state.power, state.state.as_str(), &*state.modules[0].outputs), (false, "WAIT-PRM", "00"));
    rig.slave.set_power(true);
    let state = rig.slave.state();
    assert_eq!((state.state.as_str(), state.master, state.outputs_safe), ("WAIT-PRM", None, true));
    assert_eq!((&*state.modules[0].outputs, &*state.modules[1].inputs), ("00", "12 34"));
}

const SCENARIO: &str = "title = \"a bus\"
until = \"1 s\"
slaves = [\"valves.gsd@9:modules=3+7\"]

[volumes]
chamber = { volume = \"1 l\" }

[gauges]
\"bcg450@5\" = \"chamber\"

[[timeline]]
at = \"0.1 s\"
order = [\"input 9 2 1F 80\", \"channel-error 9 2 0 Short circuit on\"]
power-off = [9]

[[timeline]]
at = \"0.2 s\"
power-on = [9]
expect = [{ device = 9, exchanging = true }]
";

fn scenario(text: &str) -> Result<Scenario, String> {
    let name = folder().join("bus.toml").display().to_string();
    Scenario::parse(text, &name).map_err(|error| error.to_string())
}

#[test]
fn a_scenario_gives_orders_to_its_slaves() {
    let scenario = scenario(SCENARIO).unwrap();
    let mut segment = scenario.memory_segment(2, Baud::B19200).unwrap();
    let mut run = scenario.start(MasterPresence::Present);
    run.step_segment(&mut segment, 0.15);
    let state = segment.stations_mut().1[0].state();
    assert_eq!((&*state.modules[1].inputs, state.power), ("1F 80", false));
    assert_eq!(state.diagnosis_texts, ["slot 2 channel 0: Short circuit"]);
    run.step_segment(&mut segment, 0.5);
    assert!(segment.stations_mut().1[0].state().power);
    let failures: Vec<_> = run.failures().iter().map(ToString::to_string).collect();
    let [failure] = failures.as_slice() else { panic!("{failures:?}") };
    assert!(failure.ends_with("expected the data exchange of slave 9 to be true, got false"), "{failure}");
}

#[test]
fn a_wrong_slave_or_order_of_a_scenario_is_an_error_with_its_position() {
    for (from, to, sentence) in [
        ("modules=3+7", "modules=4", "bus.toml:3:11: "),
        ("modules=3+7", "modules=4", "the file has no module 4; it has 3 (8 valves), "),
        ("valves.gsd@9", "valves.gsd@5", "two devices at address 5"),
        ("input 9 2 1F 80", "input 9 3 1F", "bus.toml:13:10: no module in slot 3"),
        (
            "input 9 2 1F 80",
            "input 5 2 1F",
            "expected the address of a slave by its GSD file, got 5; known: 9 (Example Valve station)",
        ),
        (
            "power-off = [9]",
            "fault = [{ device = 9, name = \"ram\" }]",
            "got 9, which is Example Valve station, a slave by its GSD file; write order = [...] with diagnosis 9 bit 24 on (Supply of",
        ),
        ("input 9 2 1F 80", "pressure 5 2", "expected input ADDR SLOT"),
        ("exchanging = true", "fault = true", "expected only exchanging for a slave by its GSD file"),
    ] {
        let error = scenario(&SCENARIO.replacen(from, to, 1)).unwrap_err();
        assert!(error.contains(sentence), "{to}: {error}");
    }
}
