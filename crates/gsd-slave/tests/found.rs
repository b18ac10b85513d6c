//! Octets of Get_Cfg to modules.

use profivac_gsd::GsdFile;
use profivac_gsd_slave::{FoundModules, GsdSlave};
use std::sync::Arc;

fn found(lines: &str, octets: &[u8]) -> Option<FoundModules> {
    let file = GsdFile::read(format!("#Profibus_DP\nIdent_Number=0x1234\n{lines}\n").as_bytes());
    GsdSlave::by_chk_cfg(&Arc::new(file), octets)
}

fn labels(found: &FoundModules) -> Vec<String> {
    found.slots.iter().map(profivac_gsd_slave::FoundSlot::label).collect()
}

fn modular(modules: &[&str]) -> String {
    let lines = modules.iter().enumerate().map(|(number, octets)| {
        let number = number + 1;
        format!("Module=\"m{number}\" {octets}\n{number}\nEndModule\n")
    });
    format!("Modular_Station=1\nMax_Module=3\n{}", lines.collect::<String>())
}

#[test]
fn all_modules_with_the_octets_are_named() {
    let found = found(&modular(&["0x10", "0x20", "0x10"]), &[0x20, 0x10]).unwrap();
    assert_eq!(labels(&found), ["slot 1 m2", "slot 2 m1 or m3"]);
    assert!(!found.is_unique() && !found.is_divided_otherwise);
    assert_eq!(found.slave.chk_cfg(), [0x20, 0x10]);
}

#[test]
fn a_module_with_several_identifiers_is_preferred_and_the_other_division_is_said() {
    let found = found(&modular(&["0x10", "0x10,0x20", "0x20"]), &[0x10, 0x20]).unwrap();
    assert_eq!(labels(&found), ["slot 1 m2"]);
    assert!(found.is_divided_otherwise);
}

#[test]
fn a_division_that_leaves_a_rest_is_given_up() {
    let found = found(&modular(&["0x10,0x10", "0x10", "0x10,0x20"]), &[0x10, 0x10, 0x20]).unwrap();
    assert_eq!(labels(&found), ["slot 1 m2", "slot 2 m3"]);
    assert!(!found.is_divided_otherwise);
}

#[test]
fn octets_that_no_modules_give_have_no_answer() {
    let modules = modular(&["0x10", "0x20"]);
    assert!(found(&modules, &[0x10, 0x11]).is_none());
    assert!(found(&modules, &[]).is_none());
    assert!(found(&modules, &[0x10, 0x10, 0x10]).is_some());
    assert!(found(&modules, &[0x10, 0x10, 0x10, 0x10]).is_none(), "Max_Module is 3");
}

#[test]
fn a_compact_station_has_one_of_its_modules() {
    let modules = modular(&["0x10", "0x10,0x20"]).replace("Modular_Station=1", "Modular_Station=0");
    assert_eq!(labels(&found(&modules, &[0x10, 0x20]).unwrap()), ["slot 1 m2"]);
    assert!(found(&modules, &[0x10, 0x10]).is_none());
}

#[test]
fn only_modules_that_the_slot_takes_count_and_slots_can_be_free() {
    let slots = "SlotDefinition\nSlot(1)=\"a\" 1 1,2\nSlot(2)=\"b\" 3 3\nSlot(3)=\"c\" 1 1\nEndSlotDefinition\n";
    let lines = modular(&["0x10", "0x20", "0x10"]) + slots;
    assert_eq!(labels(&found(&lines, &[0x10, 0x10]).unwrap()), ["slot 1 m1", "slot 2 m3"]);
    assert_eq!(labels(&found(&lines, &[0x20, 0x10, 0x10]).unwrap()), ["slot 1 m2", "slot 2 m3", "slot 3 m1"]);
    assert!(found(&lines, &[0x10, 0x20]).is_none());
}

#[test]
fn a_fixed_module_without_octets_keeps_its_slot() {
    let lines = "FixPresetModules=1\n".to_owned() + &modular(&["", "0x10"]).replace("\n1\n", "\n1\nPreset=1\n");
    assert_eq!(labels(&found(&lines, &[0x10]).unwrap()), ["slot 1 m1", "slot 2 m2"]);
}

/// A search without memory would take twice as long with each further octet.
#[test]
fn octets_with_very_many_divisions_are_divided_at_once() {
    let lines = modular(&["0x10", "0x10,0x10", "0x10,0x10,0x10"]).replace("Max_Module=3", "Max_Module=244");
    let mut octets = vec![0x10; 243];
    assert!(found(&lines, &octets).unwrap().is_divided_otherwise);
    octets.push(0x77);
    assert!(found(&lines, &octets).is_none());
}
