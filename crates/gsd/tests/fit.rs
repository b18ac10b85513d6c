//! Configuration octets to the modules that give them.

use crate::support::file;
use profivac_gsd::{Configuration, Fit, FitError, FittedSlot, GsdFile};

const MODULES: &str = "\
Modular_Station=1
Max_Module=4
Module=\"in\" 0x10
EndModule
Module=\"out\" 0x20
EndModule
Module=\"out HF\" 0x20
EndModule
Module=\"three\" 0x10,0x20,0x31
EndModule
Module=\"empty\" 0x00
EndModule
Module=\"silent\"
EndModule
";

fn device(lines: &str) -> GsdFile {
    file(&format!("{MODULES}{lines}"))
}

fn names(slot: &FittedSlot<'_>) -> String {
    slot.modules.iter().map(|module| module.name.as_str()).collect::<Vec<_>>().join(" or ")
}

fn slots(file: &GsdFile, octets: &[u8]) -> Vec<(u32, String)> {
    let fit = Fit::new(file.device(), octets).expect("modules");
    fit.slots.iter().map(|slot| (slot.slot, names(slot))).collect()
}

fn slot(number: u32, names: &str) -> (u32, String) {
    (number, names.to_owned())
}

#[test]
fn every_module_with_the_octets_is_named() {
    let file = device("");
    assert_eq!(slots(&file, &[0x10, 0x20, 0x00]), [slot(1, "in"), slot(2, "out or out HF"), slot(3, "empty")]);
}

#[test]
fn a_module_with_several_identifiers_is_one_module_and_another_division_is_said() {
    let file = device("");
    let fit = Fit::new(file.device(), &[0x20, 0x10, 0x20, 0x31]).unwrap();
    let found: Vec<_> = fit.slots.iter().map(|slot| (names(slot), slot.identifiers.clone())).collect();
    assert_eq!(found, [("out or out HF".to_owned(), 0..1), ("three".to_owned(), 1..4)]);
    assert!(!fit.has_other_division, "no module has 31 alone");
    let file = device("Module=\"both\" 0x31\nEndModule");
    let fit = Fit::new(file.device(), &[0x10, 0x20, 0x31]).unwrap();
    assert_eq!(fit.slots.len(), 1, "the fewest modules");
    assert!(fit.has_other_division);
}

#[test]
fn inputs_outputs_and_identifiers_of_each_slot_have_their_places() {
    let file = device("");
    let fit = Fit::new(file.device(), &[0x20, 0x00, 0x10, 0x20, 0x31]).unwrap();
    let places: Vec<_> = fit.slots.iter().map(|slot| (slot.inputs.clone(), slot.outputs.clone())).collect();
    assert_eq!(places, [(0..0, 0..1), (0..0, 1..1), (0..3, 1..4)]);
    let at = |identifier| fit.slot_of_identifier(identifier).map(|slot| slot.slot);
    assert_eq!([at(0), at(1), at(2), at(4), at(5)], [Some(1), Some(2), Some(3), Some(3), None]);
    assert_eq!(fit.slot(3).map(names), Some("three".to_owned()));
}

#[test]
fn the_slots_say_which_of_equal_modules_it_is_and_which_slots_are_free() {
    let definitions = "SlotDefinition\nSlot(1)=\"a\" 1 1,3\nSlot(2)=\"b\" 2 2\nSlot(3)=\"x\" 1 1\nSlot(4)=\"c\" 3 2-3\nSlot(5)=\"d\" 1 1\nEndSlotDefinition";
    let file = device(definitions);
    assert_eq!(slots(&file, &[0x10, 0x20]), [slot(1, "in"), slot(2, "out")]);
    assert_eq!(slots(&file, &[0x20, 0x20]), [slot(1, "out HF"), slot(2, "out")]);
    let fit = Fit::new(file.device(), &[0x10, 0x20, 0x20]).unwrap();
    let found: Vec<_> = fit.slots.iter().map(|slot| (slot.slot, names(slot))).collect();
    assert_eq!(found, [slot(1, "in"), slot(2, "out"), slot(4, "out HF or out")], "slot 3 is free, the default first");
}

#[test]
fn a_module_that_is_always_plugged_has_the_first_slot() {
    let fixed =
        "FixPresetModules=1\nModule=\"head\"\nPreset=1\nEndModule\nModule=\"fixed out\" 0x20\nPreset=1\nEndModule";
    let file = device(fixed);
    assert_eq!(
        slots(&file, &[0x20, 0x20]),
        [slot(1, "head"), slot(2, "fixed out"), slot(3, "fixed out or out or out HF")]
    );
    let error = Fit::new(file.device(), &[0x10]).unwrap_err();
    assert_eq!(
        error.to_string(),
        "no module for slot 2 begins with 10 (configuration octet 1); the slot takes 8 (fixed out) 20"
    );
}

#[test]
fn octets_of_no_module_are_named_with_what_the_slot_takes() {
    let file = device("SlotDefinition\nSlot(1)=\"a\" 1 1\nSlot(2)=\"b\" 2 2\nEndSlotDefinition");
    let error = Fit::new(file.device(), &[0x10, 0x31]).unwrap_err();
    assert_eq!(
        error.to_string(),
        "no module for slot 2 begins with 31 (configuration octet 2); the slot takes 2 (out) 20"
    );
}

#[test]
fn more_modules_than_the_station_takes_and_damaged_octets_are_refused() {
    let file = device("");
    assert_eq!(Fit::new(file.device(), &[0x10; 5]).unwrap_err(), FitError::TooManyModules { given: 5, most: 4 });
    let words = |octets: &[u8]| Fit::new(file.device(), octets).unwrap_err().to_string();
    assert_eq!(words(&[]), "the configuration is no list of identifiers: no identifier");
    assert_eq!(
        words(&[0x10, 0xC0]),
        "the configuration is no list of identifiers: the last identifier announces more octets than follow"
    );
}

#[test]
fn modules_without_identifiers_are_all_named_and_those_that_the_octets_do_not_show_are_said() {
    let other = "Module=\"silent HF\"\nEndModule\n";
    let file = device(&format!(
        "Max_Module=2\n{other}SlotDefinition\nSlot(1)=\"a\" 6 6-7\nSlot(2)=\"b\" 2 2-3\nEndSlotDefinition"
    ));
    let fit = Fit::new(file.device(), &[0x20]).unwrap();
    let found: Vec<_> = fit.slots.iter().map(names).collect();
    assert_eq!(found, ["silent or silent HF", "out or out HF"]);
    assert!(!fit.may_hide_module, "each slot has a module");
    let file = device("SlotDefinition\nSlot(1)=\"a\" 1 1\nSlot(2)=\"b\" 2 2,6\nEndSlotDefinition");
    assert!(Fit::new(file.device(), &[0x10]).unwrap().may_hide_module, "slot 2 may have it");
    let file = device("");
    assert!(Fit::new(file.device(), &[0x10]).unwrap().may_hide_module);
    assert!(!Fit::new(file.device(), &[0x10; 4]).unwrap().may_hide_module, "Max_Module is 4");
}

#[test]
fn slot_254_is_the_last_one() {
    let far = |slot: u32| {
        device(&format!(
            "ExtUserPrmData=1 \"[SlotNumber]\"\nUnsigned8 {slot} {slot}\nEndExtUserPrmData\nModule=\"far\" 0x30\n\
             Ext_User_Prm_Data_Ref(0)=1\nEndModule\nSlotDefinition\nSlot({slot})=\"a\" 7 7\nEndSlotDefinition"
        ))
    };
    assert_eq!(slots(&far(254), &[0x30]), [slot(254, "far")]);
    let file = far(255);
    assert!(file.device().slots.is_empty(), "the line is a problem");
    assert!(Fit::new(file.device(), &[0x30]).is_err());
}

#[test]
fn the_fitted_modules_are_a_configuration_with_the_same_octets() {
    let file = device("");
    let octets = [0x10, 0x20, 0x31, 0x00, 0x20];
    let fit = Fit::new(file.device(), &octets).unwrap();
    assert_eq!(fit.configuration().map(|configuration| configuration.chk_cfg()), Ok(octets.to_vec()));
}

/// Modules that divide the octets in very many ways, and slots for each of them.
#[test]
fn the_search_ends_soon_where_many_modules_fit() {
    let modules: String = (1..=60)
        .map(|length| format!("Module=\"m{length}\" {}\nEndModule\n", vec!["0x00"; length].join(",")))
        .collect();
    let slots: String = (1..=244).map(|slot| format!("Slot({slot})=\"s\" 1 1-60\n")).collect();
    let file = file(&format!("Modular_Station=1\n{modules}SlotDefinition\n{slots}EndSlotDefinition"));
    let fit = Fit::new(file.device(), &[0x00; 244]).unwrap();
    assert_eq!(fit.slots.len(), 5);
    assert!(fit.has_other_division);
}

#[test]
fn every_preset_is_found_again_by_its_octets() {
    let file = device("SlotDefinition\nSlot(1)=\"a\" 4 4\nSlot(2)=\"b\" 3 2-3\nEndSlotDefinition");
    let preset = Configuration::preset(file.device()).unwrap();
    let fit = Fit::new(file.device(), &preset.chk_cfg()).unwrap();
    let first: Vec<_> = fit.slots.iter().map(|slot| (slot.slot, slot.modules[0].number)).collect();
    let wanted: Vec<_> = preset.modules().iter().map(|one| (one.slot, one.module.number)).collect();
    assert_eq!(first, wanted);
}
