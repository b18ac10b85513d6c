//! Chk_Cfg from modules.

use crate::support::file;
use profivac_gsd::{Configuration, ConfigurationError, GsdFile, Module};

const MODULES: &str = "Module=\"in\" 0x10\n5\nEndModule\nModule=\"out\" 0x20\n7\nEndModule\nModule=\"both\" 0x10,0x42,0x84,0x08,0x05\n9\nEndModule\nModule=\"free\" 0x00\n0\nEndModule\n";

fn modular(lines: &str) -> GsdFile {
    file(&format!("Modular_Station=1\nMax_Module=4\n{MODULES}{lines}"))
}

fn error(file: &GsdFile, numbers: &[u32]) -> String {
    Configuration::new(file.device(), numbers).expect_err("no configuration").to_string()
}

#[test]
fn the_identifiers_of_the_modules_follow_each_other() {
    let file = modular("");
    let configuration = Configuration::new(file.device(), &[7, 0, 9, 5]).expect("a configuration");
    assert_eq!(configuration.chk_cfg(), [0x20, 0x00, 0x10, 0x42, 0x84, 0x08, 0x05, 0x10]);
    let slots: Vec<_> = configuration.modules().iter().map(|plugged| (plugged.slot, plugged.module.number)).collect();
    assert_eq!(slots, [(1, 7), (2, 0), (3, 9), (4, 5)]);
}

#[test]
fn diagnosis_counts_identifiers_and_not_modules() {
    let file = modular("Channel_Diag(16)=\"of the device\"");
    let configuration = Configuration::new(file.device(), &[7, 9, 5]).expect("a configuration");
    let module = |identifier| configuration.module_of_identifier(identifier).map(|plugged| plugged.module.number);
    assert_eq!([0, 1, 2, 3, 4].map(module), [Some(7), Some(9), Some(9), Some(5), None]);
    assert_eq!(configuration.channel_text(1, 16), Some("of the device"));
}

#[test]
fn an_unknown_module_is_refused_with_the_modules_of_the_file() {
    assert_eq!(error(&modular(""), &[5, 6]), "the file has no module 6; it has 5 (in), 7 (out), 9 (both), 0 (free)");
}

#[test]
fn a_station_takes_no_more_modules_than_the_file_says() {
    assert!(Configuration::new(modular("").device(), &[5; 4]).is_ok());
    assert_eq!(error(&modular(""), &[5; 5]), "5 modules; the station takes at most 4");
}

#[test]
fn a_compact_station_has_one_of_its_modules() {
    let file = file(MODULES);
    assert!(Configuration::new(file.device(), &[7]).is_ok());
    assert_eq!(error(&file, &[7, 7]), "2 modules for a compact station; choose one");
    let none = Configuration::preset(file.device()).expect_err("no module is preset");
    assert!(matches!(none, ConfigurationError::NoModule { .. }), "{none}");
}

#[test]
fn the_only_module_of_a_compact_station_needs_no_choice() {
    let file = file("Module=\"only\" 0x33\nEndModule");
    assert_eq!(Configuration::preset(file.device()).map(|one| one.chk_cfg()), Ok(vec![0x33]));
}

#[test]
fn a_slot_takes_only_its_modules() {
    let file = modular("SlotDefinition\nSlot(1)=\"first\" 5 5,7\nSlot(2)=\"second\" 0 0-7\nEndSlotDefinition");
    assert!(Configuration::new(file.device(), &[7, 0]).is_ok());
    assert!(Configuration::new(file.device(), &[7, 0, 9]).is_ok(), "slot 3 is not defined");
    assert_eq!(error(&file, &[7, 9]), "slot 2 does not take 9 (both); it takes 5 (in), 7 (out), 0 (free)");
    assert_eq!(Configuration::preset(file.device()).map(|one| one.chk_cfg()), Ok(vec![0x10, 0x00]));
}

#[test]
fn slots_count_from_zero_if_the_file_has_a_slot_zero() {
    let file = modular("SlotDefinition\nSlot(0)=\"head\" 5 5\nSlot(1)=\"next\" 7 7\nEndSlotDefinition");
    let configuration = Configuration::new(file.device(), &[5, 7]).expect("a configuration");
    assert_eq!(configuration.modules().iter().map(|plugged| plugged.slot).collect::<Vec<_>>(), [0, 1]);
    assert!(Configuration::new(file.device(), &[7, 5]).is_err());
}

#[test]
fn fixed_modules_stay_and_preset_modules_may_go() {
    let lines = "Module=\"head\" 0x30\n20\nPreset=1\nEndModule\nModule=\"tail\" 0x31\n21\nPreset=1\nEndModule";
    let fixed = modular(&format!("FixPresetModules=1\n{lines}"));
    assert_eq!(Configuration::preset(fixed.device()).map(|one| one.chk_cfg()), Ok(vec![0x30, 0x31]));
    assert!(Configuration::new(fixed.device(), &[20, 21, 5]).is_ok());
    assert_eq!(error(&fixed, &[20, 5]), "21 (tail) is always plugged, in slot 2; put it there");
    assert_eq!(error(&fixed, &[20, 5, 21]), "21 (tail) is always plugged, in slot 2; put it there");
    assert_eq!(error(&fixed, &[21, 20]), "20 (head) is always plugged, in slot 1; put it there");
    let slots = "SlotDefinition\nSlot(1)=\"one\" 21 5,21\nSlot(2)=\"two\" 20 20\nEndSlotDefinition";
    let defined = modular(&format!("FixPresetModules=1\n{lines}\n{slots}"));
    assert!(Configuration::new(defined.device(), &[21, 20]).is_ok());
    assert_eq!(error(&defined, &[5, 20]), "21 (tail) is always plugged; add it to the modules");
    let free = modular(lines);
    assert_eq!(Configuration::preset(free.device()).map(|one| one.chk_cfg()), Ok(vec![0x30, 0x31]));
    assert!(Configuration::new(free.device(), &[5]).is_ok());
}

#[test]
fn inputs_and_outputs_stay_within_the_lengths_of_the_file() {
    let file = modular("Max_Input_Len=2\nMax_Output_Len=1\nMax_Data_Len=2");
    assert!(Configuration::new(file.device(), &[5, 5]).is_ok());
    let most = "are possible; choose fewer modules";
    assert_eq!(error(&file, &[5, 5, 5]), format!("3 octets of inputs; at most 2 {most}"));
    assert_eq!(error(&file, &[7, 7]), format!("2 octets of outputs; at most 1 {most}"));
    assert_eq!(error(&file, &[5, 5, 7]), format!("3 octets of inputs and outputs; at most 2 {most}"));
}

#[test]
fn chk_cfg_has_at_most_244_octets() {
    let file = file("Modular_Station=1\nModule=\"free\" 0\nEndModule");
    assert!(Configuration::new(file.device(), &[1; 244]).is_ok());
    assert_eq!(error(&file, &[1; 245]), "245 modules; the station takes at most 244");
}

#[test]
fn each_direction_has_at_most_244_octets_on_every_station() {
    let large = "Module=\"in\" 0x40,0xBF\nEndModule\nModule=\"out\" 0x80,0xBF\nEndModule\nModule=\"53 in\" 0x40,0xB4\nEndModule\nModule=\"52 in\" 0x40,0xB3\nEndModule\n";
    let modular = file(&format!("Modular_Station=1\n{large}"));
    assert!(Configuration::new(modular.device(), &[1, 1, 1, 4]).is_ok());
    let most = "at most 244 are possible; choose fewer modules";
    assert_eq!(error(&modular, &[1, 1, 1, 3]), format!("245 octets of inputs; {most}"));
    assert_eq!(error(&modular, &[2, 2, 2, 2]), format!("256 octets of outputs; {most}"));
    let compact = file("Module=\"in\" 0x40,0xFF,0x40,0xFF\nEndModule");
    assert_eq!(error(&compact, &[1]), format!("256 octets of inputs; {most}"));
}

#[test]
fn modules_without_an_identifier_are_no_configuration_and_a_cut_identifier_is_sent() {
    let file = file("Modular_Station=1\nModule=\"none\"\nEndModule\nModule=\"cut\" 0xC6\nEndModule");
    assert_eq!(
        error(&file, &[1, 1]),
        "the modules have no identifier, and Chk_Cfg needs one; choose a module that has"
    );
    assert_eq!(Configuration::new(file.device(), &[1, 2]).map(|one| one.chk_cfg()), Ok(vec![0xC6]));
}

#[test]
fn modules_are_in_the_slots_that_are_given_and_slots_may_be_free() {
    let file = modular("SlotDefinition\nSlot(2)=\"second\" 5 5\nSlot(5)=\"fifth\" 7 7\nEndSlotDefinition");
    let [input, output, ..] = file.device().modules.as_slice() else { panic!("modules") };
    let slots = |one: &Configuration<'_>| one.modules().iter().map(|plugged| plugged.slot).collect::<Vec<_>>();
    let configuration =
        Configuration::in_slots(file.device(), [(5, output), (1, output), (2, input)]).expect("a configuration");
    assert_eq!((slots(&configuration), configuration.chk_cfg()), (vec![1, 2, 5], vec![0x20, 0x10, 0x20]));
    let preset = Configuration::preset(file.device()).expect("a configuration");
    assert_eq!((slots(&preset), preset.chk_cfg()), (vec![2, 5], vec![0x10, 0x20]));
    let error = |modules: &[(u32, &Module)]| {
        Configuration::in_slots(file.device(), modules.iter().copied()).expect_err("no configuration").to_string()
    };
    assert_eq!(error(&[(5, input)]), "slot 5 does not take 5 (in); it takes 7 (out)");
    assert_eq!(error(&[(1, input), (2, input), (1, output)]), "two modules in slot 1; put one into another slot");
}

#[test]
fn slots_end_with_max_module_unless_the_file_defines_more() {
    let of = |definition: &str, slot: u32| {
        let file = file(&format!("Modular_Station=1\nMax_Module=2\n{definition}Module=\"in\" 0x10\n1\nEndModule"));
        let modules = file.device().modules.iter().map(|module| (slot, module));
        Configuration::in_slots(file.device(), modules).map(|one| one.chk_cfg()).map_err(|error| error.to_string())
    };
    for slot in [1, 2] {
        assert_eq!(of("", slot), Ok(vec![0x10]));
    }
    for slot in [0, 3] {
        let error = format!("the station has no slot {slot}; by Max_Module it has the slots 1 to 2");
        assert_eq!(of("", slot), Err(error));
    }
    assert_eq!(of("SlotDefinition\nSlot(9)=\"ninth\" 1 1\nEndSlotDefinition\n", 9), Ok(vec![0x10]));
}

#[test]
fn a_configuration_with_a_module_for_safety_says_that_its_octets_lack_parameters() {
    let safe = "Module=\"safe\" 0x30\n20\nF_Ext_Module_Prm_Data_Len=1\nF_Ext_User_Prm_Data_Const(0)=5\nEndModule";
    let file = modular(safe);
    let warnings = |numbers: &[u32]| {
        let configuration = Configuration::new(file.device(), numbers).expect("a configuration");
        assert_eq!(configuration.user_prm(), Ok(vec![]));
        configuration.warnings().iter().map(ToString::to_string).collect::<Vec<_>>()
    };
    assert_eq!(
        warnings(&[5, 20]),
        [
            "slot 2: 20 (safe) has parameters for PROFIsafe, which are not in the user parameters; take them from the safety controller"
        ]
    );
    assert_eq!(warnings(&[5, 7]), [""; 0]);
}
