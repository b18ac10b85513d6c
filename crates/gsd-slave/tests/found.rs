//! Octets of Get_Cfg to a slave. The search itself has its tests in profivac-gsd.

use profivac_gsd::GsdFile;
use profivac_gsd_slave::{FoundModules, FoundSlot, GsdSlave};
use std::sync::Arc;

fn found(octets: &[u8]) -> Result<FoundModules, String> {
    let file = GsdFile::read(
        b"#Profibus_DP\nIdent_Number=0x1234\nModular_Station=1\nMax_Module=3
Module=\"DI\" 0x10\n1\nEndModule
Module=\"DO\" 0x20\n2\nEndModule
Module=\"DI HF\" 0x10\n3\nEndModule
Module=\"both\" 0x11,0x21\n4\nEndModule
Module=\"2DI\" 0x11\n5\nEndModule
Module=\"2DO\" 0x21\n6\nEndModule\n",
    );
    GsdSlave::by_chk_cfg(&Arc::new(file), octets).map_err(|error| error.to_string())
}

#[test]
fn all_modules_with_the_octets_are_named_and_the_slave_has_the_first() {
    let found = found(&[0x20, 0x10]).unwrap();
    let labels: Vec<_> = found.slots.iter().map(FoundSlot::label).collect();
    assert_eq!(labels, ["slot 1 DO", "slot 2 DI or DI HF"]);
    assert!(!found.is_unique() && !found.is_divided_otherwise);
    assert_eq!(found.slave.chk_cfg(), [0x20, 0x10]);
    assert_eq!(found.slave.layout().in_slot(2).unwrap().number, 1);
}

#[test]
fn octets_that_other_modules_divide_otherwise_are_not_unique() {
    assert!(found(&[0x20]).unwrap().is_unique());
    let found = found(&[0x11, 0x21]).unwrap();
    assert!(found.is_divided_otherwise && !found.is_unique());
    assert_eq!(found.slots[0].label(), "slot 1 both");
}

#[test]
fn octets_of_no_modules_are_refused_with_the_possible_ones() {
    assert!(found(&[0x20, 0x12]).unwrap_err().contains("DI HF"));
    assert!(found(&[0x10, 0x10, 0x10, 0x10]).unwrap_err().contains('3'), "Max_Module");
    assert!(found(&[]).is_err());
}

#[test]
fn modules_with_one_number_and_different_parameters_are_told_apart() {
    let slot = |other: &str| {
        let lines = format!(
            "#Profibus_DP\nIdent_Number=1\nModule=\"a\" 0x10\n1\nExt_Module_Prm_Data_Len=1\nEndModule
Module=\"b\" 0x10\n1\n{other}EndModule\n"
        );
        GsdSlave::by_chk_cfg(&Arc::new(GsdFile::read(lines.as_bytes())), &[0x10]).unwrap().slots.remove(0)
    };
    assert!(!slot("").has_equal_parameters);
    assert!(slot("Ext_Module_Prm_Data_Len=1\n").has_equal_parameters);
}

#[test]
fn a_module_without_identifiers_that_may_be_plugged_besides_makes_the_modules_not_unique() {
    let file = |most: u32| {
        let lines = format!(
            "#Profibus_DP\nIdent_Number=1\nModular_Station=1\nMax_Module={most}\nModule=\"a\" 0x10\nEndModule
Module=\"silent\"\nEndModule\n"
        );
        GsdSlave::by_chk_cfg(&Arc::new(GsdFile::read(lines.as_bytes())), &[0x10]).unwrap()
    };
    assert!(file(2).may_hide_module && !file(2).is_unique());
    assert!(file(1).is_unique());
}
