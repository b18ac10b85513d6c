//! Slaves in the words of their GSD files. All files are invented.

#![allow(clippy::unwrap_used, clippy::panic, reason = "a test")]

use crate::log::{Log, SLAVE};
use profivac_dp::link::Baud;
use profivac_explain::dpv1::DeviceBlocks;
use profivac_explain::gsd::{Described, Extent, Files, Seen};
use profivac_explain::input::Capture;
use profivac_explain::{Decoder, ExplainedPiece};
use profivac_gsd::GsdFile;
use profivac_wire::ext_diag::Block;
use std::sync::Arc;

const BAUD: Baud = Baud::B500000;
const IDENT: u16 = 0xAAAB;

/// A modular station with a parameter of its own and one of a module.
const STATION: &str = "\
#Profibus_DP
Vendor_Name = \"Valves Ltd\"
Model_Name = \"Island\"
Ident_Number = 0xAAAB
500_supp = 1
MaxTsdr_500 = 100
Modular_Station = 1
Max_Module = 4
Max_Diag_Data_Len = 16
PrmText = 1
Text(0) = \"opens\"
Text(1) = \"closes\"
EndPrmText
ExtUserPrmData = 1 \"Valve without bus\"
Bit(0) 0 0-1
Prm_Text_Ref = 1
EndExtUserPrmData
ExtUserPrmData = 2 \"Filter in ms\"
Unsigned8 3 0-9
EndExtUserPrmData
Ext_User_Prm_Data_Const(0) = 0x10
Ext_User_Prm_Data_Ref(0) = 1
Unit_Diag_Bit(0) = \"no supply\"
Unit_Diag_Bit_Help(0) = \"look at fuse F1\"
Unit_Diag_!Bit(1) = \"no air\"
Channel_Diag(16) = \"coil broken\"
Module = \"4DO\" 0x20
1
EndModule
Module = \"4DO HF\" 0x20
2
Channel_Diag(17) = \"coil hot\"
EndModule
Module = \"2AI with status\" 0x10, 0x51
3
Ext_Module_Prm_Data_Len = 1
Ext_User_Prm_Data_Ref(0) = 2
EndModule
";

/// Another device with the same Ident_Number, for which 31 is a module.
const OTHER: &str = "\
#Profibus_DP
Vendor_Name = \"Drives Ltd\"
Model_Name = \"Drive\"
Ident_Number = 0xAAAB
DPV1_Slave = 1
Module = \"speed\" 0x31
Unit_Diag_Bit(24) = \"sensor lost\"
EndModule
UnitDiagType = 161
X_Unit_Diag_Bit(24) = \"too fast\"
X_Unit_Diag_Bit_Help(24) = \"slow down\"
EndUnitDiagType
";

fn files(texts: &[&str]) -> Files {
    Files::new(texts.iter().map(|text| Arc::new(GsdFile::read(text.as_bytes()))))
}

fn explained(log: &Log, texts: &[&str]) -> Vec<ExplainedPiece> {
    let capture = Capture::read(log.text.as_bytes(), BAUD).unwrap();
    let (mut decoder, mut explained) = (Decoder::new(BAUD, capture.times).with_gsd(files(texts)), Vec::new());
    capture.chunks.iter().for_each(|chunk| decoder.push(chunk, &mut explained));
    decoder.end(&mut explained);
    explained
}

fn notes(log: &Log, texts: &[&str]) -> Vec<String> {
    explained(log, texts).into_iter().flat_map(|piece| piece.notes).map(|note| note.text).collect()
}

fn chk_cfg(log: Log, octets: &[u8]) -> Log {
    log.request(SLAVE, 62, octets).ack()
}

/// A slave without any report.
fn quiet() -> Log {
    Log::default().diag_of(SLAVE, IDENT, 0, &[])
}

/// The start-up of an island with 4DO and 2AI.
fn island() -> Log {
    chk_cfg(quiet().prm(IDENT, &[0x11, 5]), &[0x20, 0x10, 0x51])
}

#[test]
fn the_start_up_names_the_slave_its_parameters_and_its_modules() {
    let notes = notes(&island(), &[STATION]);
    assert_eq!(
        notes[0],
        "is present: Island of Valves Ltd by the GSD file (ident AAAB), belongs to master 2, exchanges data"
    );
    assert_eq!(
        notes[2..],
        [
            "its parameters by the GSD file: Valve without bus = closes (1), default opens (0); 1 octet more, of the modules, which Chk_Cfg shows",
            "master 2 asks for the configuration 20 10 51: 1 octet out, 5 in",
            "its modules by the GSD file: slot 1 4DO or 4DO HF, slot 2 2AI with status",
            "its parameters by the GSD file: Valve without bus = closes (1), default opens (0), slot 2 2AI with status: Filter in ms = 5, default 3",
        ]
    );
}

#[test]
fn the_meaning_of_the_telegrams_names_everything() {
    let log = island().prm(IDENT, &[0x10, 3]).exchange(&[0x0F], &[1, 2, 3, 4, 5]);
    let meanings: Vec<_> = explained(&log, &[STATION]).into_iter().map(|piece| piece.meaning).collect();
    let named: Vec<_> = meanings.iter().filter(|meaning| !meaning.is_empty()).collect();
    assert_eq!(
        named,
        [
            "Valve without bus = closes (1), default opens (0); 1 octet more, of the modules, which Chk_Cfg shows",
            "slot 1 4DO or 4DO HF, slot 2 2AI with status",
            "Valve without bus = opens (0); 1 octet more, of the modules, which Chk_Cfg shows",
            "slot 1 4DO or 4DO HF: 0F",
            "slot 2 2AI with status: 01 02 03 04 05",
        ]
    );
}

#[test]
fn data_of_another_length_than_the_modules_have_get_no_names() {
    let log = island().exchange(&[0x0F, 0x0F], &[1, 2, 3, 4]);
    let all = explained(&log, &[STATION]);
    assert!(all.iter().rev().take(2).all(|piece| piece.meaning.is_empty()));
}

#[test]
fn without_a_file_nothing_changes() {
    let without = notes(&island(), &[]);
    assert_eq!(without[0], "is present: an unknown device (ident AAAB), belongs to master 2, exchanges data");
    assert_eq!(without.len(), 3);
    let other = "#Profibus_DP\nIdent_Number = 0x1234\nModule = \"m\" 0x20\nEndModule\n";
    assert_eq!(notes(&island(), &[other]), without, "the file of another ident");
}

#[test]
fn devices_with_one_ident_are_all_named_until_the_configuration_shows_which_one_it_is() {
    let log = chk_cfg(quiet(), &[0x31]).diag(IDENT, &[0x05, 0xA1, 2, 1, 1]);
    let notes = notes(&log, &[STATION, OTHER]);
    assert!(
        notes[0].starts_with("is present: Island of Valves Ltd or Drive of Drives Ltd by the GSD file"),
        "{notes:?}"
    );
    assert_eq!(notes[2], "its modules by the GSD file: slot 1 speed");
    // DPV1_Slave of the one that is left decides what the block is.
    assert!(notes[3].starts_with("its diagnosis: Ext_Diag; manufacturer specific status 33 of slot 2"), "{notes:?}");
}

fn diagnosis(blocks: &[u8]) -> Vec<String> {
    let log = island().diag(IDENT, blocks);
    notes(&log, &[STATION])
        .last()
        .unwrap()
        .strip_prefix("its diagnosis: Ext_Diag; ")
        .unwrap()
        .split("; ")
        .map(str::to_owned)
        .collect()
}

#[test]
fn bits_of_a_diagnosis_have_the_texts_of_the_file() {
    assert_eq!(diagnosis(&[0x02, 0x03]), ["vendor-specific octets 03: no supply (look at fuse F1)"]);
    assert_eq!(diagnosis(&[0x02, 0x00]), ["vendor-specific octets 00: no air"]);
    assert_eq!(diagnosis(&[0x02, 0x06]), ["vendor-specific octets 06, without a text in the GSD file"]);
}

#[test]
fn identifiers_and_channels_are_numbered_both_ways() {
    assert_eq!(
        diagnosis(&[0x42, 0x0D]),
        [
            "with diagnosis: identifier 0 (slot 1, module 4DO or 4DO HF), identifier 2 (slot 2, module 2AI with status), identifier 3 (beyond the modules)"
        ]
    );
    assert_eq!(
        diagnosis(&[0x80, 0x85, 0x30, 0x80, 0x85, 0x31, 0x82, 0x42, 0xB0, 0x81, 0x40, 0x22, 0x81, 0x40, 0x32]),
        [
            "identifier 0 (slot 1, module 4DO or 4DO HF), output channel 5 (bit): error 16 coil broken",
            "identifier 0 (slot 1, module 4DO or 4DO HF), output channel 5 (bit): error 17 coil hot",
            "identifier 2 (slot 2, module 2AI with status), input channel 2 (word): error 16 coil broken",
            "identifier 1 (slot 2, module 2AI with status), input channel 0 (bit): error 2 undervoltage",
            "identifier 1 (slot 2, module 2AI with status), input channel 0 (bit): error 18 without a text in the GSD file",
        ]
    );
}

#[test]
fn identifiers_without_a_configuration_say_that_the_module_is_unknown() {
    let log = quiet().diag(IDENT, &[0x42, 0x01]);
    assert_eq!(
        notes(&log, &[STATION]).last().unwrap(),
        "its diagnosis: Ext_Diag; with diagnosis: identifier 0 (module unknown: no Chk_Cfg that fits was received)"
    );
}

#[test]
fn alarms_and_module_status_of_a_dp_v1_slave_have_slot_module_and_text() {
    let start = chk_cfg(quiet(), &[0x31]);
    let last = |blocks: &[u8]| notes(&start.clone().diag(IDENT, blocks), &[OTHER]).last().unwrap().clone();
    assert_eq!(
        last(&[0x05, 0xA1, 1, 1, 1]),
        "its diagnosis: Ext_Diag; manufacturer specific status 33 of slot 1, appears: 01 (slot 1 is speed): sensor lost",
    );
    assert_eq!(
        last(&[0x05, 0xA1, 0, 1, 1]),
        "its diagnosis: Ext_Diag; manufacturer specific status 33 of slot 0, appears: 01: too fast (slow down)",
    );
    assert_eq!(
        last(&[0x05, 0x82, 0, 0, 0x02]),
        "its diagnosis: Ext_Diag; module status: module 1 (slot 1, speed) wrong module"
    );
    assert_eq!(
        last(&[0x05, 0x82, 0, 0, 0x30]),
        "its diagnosis: Ext_Diag; module status: module 3 (beyond the modules) no module"
    );
    assert_eq!(last(&[0x05, 0x82, 0, 0, 0]), "its diagnosis: Ext_Diag; module status: all valid");
    assert_eq!(
        last(&[0x04, 0x02, 1, 9]),
        "its diagnosis: Ext_Diag; process alarm of slot 1, sequence number 1, appears (slot 1 is speed)"
    );
}

#[test]
fn a_refused_start_up_has_the_reasons_of_the_file() {
    let log = quiet().prm(IDENT, &[]).diag_of(SLAVE, IDENT, 0x42, &[]);
    let refused = notes(&log, &[STATION]);
    let wanted = "Set_Prm refused: the slave reports no reason, and the telegram shows none; by the GSD file: Set_Prm has 0 octets of user parameters, \
                  the station alone has 1 by the GSD file";
    assert!(refused.contains(&wanted.to_owned()), "{refused:?}");
    let log = chk_cfg(quiet(), &[0x20, 0x33]).diag_of(SLAVE, IDENT, 0x04, &[]);
    let refused = notes(&log, &[STATION]);
    let wanted = "Chk_Cfg refused: the configuration of the Island is not known, the master asked for 20 33; by the GSD file: no module for slot 2 begins \
                  with 33 (configuration octet 2); the slot takes 1 (4DO) 20, 2 (4DO HF) 20, 3 (2AI with status) 10 51";
    assert!(refused.contains(&wanted.to_owned()), "{refused:?}");
}

/// What contradicts the file of the island.
fn mismatches(config: &[u8], seen: &Seen<'_>) -> Vec<String> {
    let mut described = Described::new(files(&[STATION]));
    described.identify(IDENT);
    described.configure(config);
    described.mismatches(seen).into_iter().map(|mismatch| mismatch.found).collect()
}

#[test]
fn each_contradiction_between_line_and_file_is_found() {
    let prm = |ident: u16, min_tsdr: u8, user: &[u8]| {
        let [high, low] = ident.to_be_bytes();
        [&[0x88, 1, 10, min_tsdr, high, low, 0][..], user].concat()
    };
    let cfg: &[u8] = &[0x20, 0x10, 0x51];
    let diag = [&[0, 0x0C, 0, 2, 0xAA, 0xAB][..], &[0x0A; 10]].concat();
    let good = prm(IDENT, 100, &[0x11, 9]);
    let seen = Seen { bits_per_second: Some(500_000), set_prm: &good, diagnosis: &diag, longest_tsdr: Some(100) };
    assert_eq!(mismatches(cfg, &seen), [""; 0]);
    let length = "Set_Prm has 1 octet of user parameters, station and modules have 2 by the GSD file";
    assert_eq!(mismatches(cfg, &Seen { set_prm: &prm(IDENT, 11, &[0x10]), ..seen }), [length]);
    assert_eq!(
        mismatches(cfg, &Seen { set_prm: &prm(IDENT, 11, &[0x10, 10]), ..seen }),
        ["Set_Prm, slot 2: Filter in ms = 10, default 3, which the file does not allow: possible are 0 to 9"]
    );
    assert_eq!(
        mismatches(cfg, &Seen { set_prm: &prm(IDENT, 101, &[0x10, 3]), ..seen }),
        ["Set_Prm has min T_SDR 101, MaxTsdr of the GSD file is 100 at this rate"]
    );
    assert_eq!(
        mismatches(cfg, &Seen { set_prm: &prm(0x1234, 11, &[0x10, 3]), ..seen }),
        ["Set_Prm has ident 1234, the slave is AAAB"]
    );
    let mut release = prm(IDENT, 11, &[]);
    release[0] = 0x48;
    assert_eq!(mismatches(cfg, &Seen { set_prm: &release, ..seen }), [""; 0], "Unlock_Req has no parameters");
    let long = [&diag[..], &[0]].concat();
    assert_eq!(
        mismatches(cfg, &Seen { diagnosis: &long, ..seen }),
        ["a diagnosis has 17 octets, Max_Diag_Data_Len is 16"]
    );
    assert_eq!(
        mismatches(cfg, &Seen { bits_per_second: Some(19_200), ..seen }),
        ["the line has 19200 bit/s, which the slave does not have by its GSD file"]
    );
    assert_eq!(
        mismatches(cfg, &Seen { longest_tsdr: Some(101), ..seen }),
        ["an answer began 101 bit times after its request, MaxTsdr is 100"]
    );
    let impossible = mismatches(&[0x33], &Seen { set_prm: &[], ..seen });
    assert!(
        impossible[0].starts_with("the configuration is not possible by the GSD file: no module for slot 1"),
        "{impossible:?}"
    );
}

#[test]
fn of_very_many_equal_modules_a_sentence_names_two_and_the_meaning_all() {
    let more: String = (1..=5).map(|number| format!("Module = \"D{number}\" 0x22\nEndModule\n")).collect();
    let file = format!("{STATION}{more}");
    let log = chk_cfg(quiet(), &[0x22]);
    let all = explained(&log, &[&file]);
    let note = &all.iter().flat_map(|piece| &piece.notes).last().unwrap().text;
    assert_eq!(note, "its modules by the GSD file: slot 1 D1 or D2 or 3 others with the same octets");
    assert!(all.iter().any(|piece| piece.meaning == "slot 1 D1 or D2 or D3 or D4 or D5"));
}

/// The start-up of the island, and then a Set_Prm with the parameter of the station alone.
fn parameterised_again() -> Log {
    island().prm(IDENT, &[0x11])
}

#[test]
fn a_set_prm_is_read_with_the_modules_of_the_chk_cfg_that_follows_it() {
    let again = parameterised_again();
    let of_station = "its parameters by the GSD file: Valve without bus = closes (1), default opens (0)";
    assert_eq!(notes(&again, &[STATION]).last().unwrap(), of_station);
    let other = notes(&chk_cfg(again.clone(), &[0x20]), &[STATION]);
    assert_eq!(
        other.last().unwrap(),
        "its modules by the GSD file: slot 1 4DO or 4DO HF",
        "the parameters say the same"
    );
    let refused = notes(&again.diag_of(SLAVE, IDENT, 0x42, &[]), &[STATION]);
    let refused = refused.iter().find(|note| note.starts_with("Set_Prm refused")).unwrap();
    assert!(!refused.contains("by the GSD file"), "{refused}");

    let mut described = Described::new(files(&[STATION]));
    described.identify(IDENT);
    described.configure(&[0x20, 0x10, 0x51]);
    let prm = [0x88, 1, 10, 11, 0xAA, 0xAB, 0, 0x10];
    let length = "Set_Prm has 1 octet of user parameters, station and modules have 2 by the GSD file";
    let found = |described: &Described| -> Vec<_> {
        described.set_prm_mismatches(&prm).into_iter().map(|one| one.found).collect()
    };
    assert_eq!(found(&described), [length]);
    described.parameterise();
    assert!(
        found(&described).is_empty() && described.mismatches(&Seen { set_prm: &prm, ..Seen::default() }).is_empty()
    );
    described.offer(&[0x20, 0x10, 0x51]);
    assert!(found(&described).is_empty(), "Get_Cfg shows the modules of the slave, not what the master wants");
    described.configure(&[0x20, 0x10, 0x51]);
    assert_eq!(found(&described), [length]);
}

#[test]
fn parameters_that_devices_read_differently_have_the_names_of_these_devices() {
    let named = |model: &str, constant: &str| {
        format!("#Profibus_DP\nModel_Name=\"{model}\"\nIdent_Number=0xAAAB\nExt_User_Prm_Data_Const(0)={constant}\n")
    };
    let devices = [named("A", "1"), named("B", "1"), named("C", "2")];
    let log = quiet().prm(IDENT, &[3]);
    let all = notes(&log, &devices.each_ref().map(String::as_str));
    assert_eq!(
        all.last().unwrap(),
        "its parameters by the GSD file: as A or B: octet 0 is 03, the file has 01 | as C: octet 0 is 03, the file has 02"
    );
}

#[test]
fn of_very_many_devices_with_one_ident_a_sentence_names_twenty() {
    let named = |number: usize| {
        let constant = number % 25;
        format!("#Profibus_DP\nModel_Name=\"M{number}\"\nIdent_Number=0xAAAB\nExt_User_Prm_Data_Const(0)={constant}\n")
    };
    let devices: Vec<String> = (0..600).map(named).collect();
    let devices: Vec<&str> = devices.iter().map(String::as_str).collect();
    let all = notes(&quiet().prm(IDENT, &[3]).diag(IDENT, &[0x42, 0x01]), &devices);
    let parameters = all.iter().find(|note| note.starts_with("its parameters")).unwrap();
    assert!(parameters.contains("as M0 or M25 or ") && parameters.contains(" and 4 more: "), "{parameters}");
    assert!(parameters.ends_with(" and 5 more"), "{parameters}");
    let mut described = Described::new(files(&devices));
    described.identify(IDENT);
    assert_eq!(described.names().len(), 600);
    assert!(described.names_text().ends_with(" or M19 and 580 more"), "{}", described.names_text());
}

#[test]
fn a_chk_cfg_counts_when_the_slave_takes_it() {
    let unanswered = quiet().request(SLAVE, 62, &[0x20]).diag(IDENT, &[0x42, 0x01]);
    assert_eq!(
        notes(&unanswered, &[STATION]).last().unwrap(),
        "its diagnosis: Ext_Diag; with diagnosis: identifier 0 (module unknown: no Chk_Cfg that fits was received)"
    );
    let asked = explained(&unanswered, &[STATION]);
    assert!(asked.iter().any(|piece| piece.meaning == "slot 1 4DO or 4DO HF"), "its meaning is said all the same");
}

#[test]
fn a_configuration_before_the_first_ident_is_kept() {
    let mut described = Described::new(files(&[STATION]));
    described.configure(&[0x20]);
    assert!(described.slots().is_empty());
    described.identify(IDENT);
    assert_eq!(described.modules_text(Extent::All), "slot 1 4DO or 4DO HF");
    described.identify(0x1234);
    described.identify(IDENT);
    assert!(described.slots().is_empty(), "another device has another configuration");
}

#[test]
fn files_that_divide_the_configuration_differently_give_no_module_as_certain() {
    let pair = "#Profibus_DP\nModel_Name=\"Pair\"\nIdent_Number=0xAAAB\nModule=\"pair\" 0x20,0x20\nEndModule\n";
    let mut described = Described::new(files(&[STATION, pair]));
    described.identify(IDENT);
    described.configure(&[0x20, 0x20]);
    assert_eq!(
        described.modules_text(Extent::All),
        "slot 1 4DO or 4DO HF, slot 2 4DO or 4DO HF; by another of the GSD files other modules have these octets"
    );
    assert_eq!(described.outputs(&[1, 2]), "");
    assert_eq!(
        described.identifier_text(1),
        "identifier 1 (module unknown: the GSD files divide the configuration differently)"
    );
}

/// Each slot can have each of ten thousand modules, which have names of more than 200 characters.
#[test]
fn very_many_modules_with_long_names_end_soon_and_are_counted() {
    let name = "n".repeat(200);
    let modules: String = (0..10_000).map(|number| format!("Module=\"{number} {name}\" 0x00\nEndModule\n")).collect();
    let file = format!("#Profibus_DP\nIdent_Number=0xAAAB\nModular_Station=1\n{modules}");
    let mut described = Described::new(files(&[&file]));
    described.identify(IDENT);
    described.configure(&[0x00; 244]);
    let slot = described.slots().last().unwrap();
    assert_eq!((described.slots().len(), slot.modules.len(), slot.more), (244, 100, 9_900));
    assert!(slot.names().ends_with(" or 9998 others with the same octets"), "{}", slot.names());
    assert!(slot.names().len() < 300 && described.block_text(&BLOCK, DeviceBlocks::Unknown).is_some());
}

/// Diagnosis of the first identifier.
const BLOCK: Block<'_> = Block::Identifier(&[0x01]);
