//! Modules and parameters as people write them.

use profivac_gsd::GsdFile;
use profivac_gsd_slave::{Change, GsdSlave, ModuleChoice, Modules, Selection};
use std::sync::Arc;

/// Two parameters of the station, one of them with `=` in its name; a module twice by name; modules with `+`, `,` and `:`.
const FILE: &[u8] = b"#Profibus_DP
Ident_Number = 0x1234
Modular_Station = 1
Max_Module = 5
PrmText = 1
Text(0) = \"off\"
Text(1) = \"on\"
EndPrmText
ExtUserPrmData = 1 \"Start = up\"
Unsigned8 0 0-1
Prm_Text_Ref = 1
EndExtUserPrmData
ExtUserPrmData = 2 \"Delay\"
Unsigned8 5 0-20
EndExtUserPrmData
ExtUserPrmData = 3 \"1:Delay\"
Unsigned8 0 0-9
EndExtUserPrmData
Ext_User_Prm_Data_Ref(0) = 1
Ext_User_Prm_Data_Ref(1) = 3
Module = \"AI+AO, 4:20 mA\" 0x10
3
Ext_Module_Prm_Data_Len = 2
Ext_User_Prm_Data_Ref(0) = 2
Ext_User_Prm_Data_Ref(1) = 2
EndModule
Module = \"valve\" 0x20
7
Ext_Module_Prm_Data_Len = 1
Ext_User_Prm_Data_Ref(0) = 2
EndModule
Module = \"valve\" 0x21
8
EndModule
";

fn slave(selection: &Selection) -> Result<GsdSlave, String> {
    GsdSlave::new(Arc::new(GsdFile::read(FILE)), selection).map_err(|error| error.to_string())
}

fn set(changes: &[&str]) -> Result<Vec<u8>, String> {
    let changes = changes.iter().map(|change| change.parse().unwrap()).collect();
    let selection = Selection { modules: "3+7".parse().unwrap(), changes };
    slave(&selection).map(|slave| slave.user_prm().to_vec())
}

fn toml(text: &str) -> Result<GsdSlave, String> {
    slave(&Selection::from_toml(text).map_err(|error| error.to_string())?)
}

#[test]
fn numbers_with_plus_are_modules_in_slot_order() {
    let slave = slave(&Selection { modules: "3+7".parse().unwrap(), changes: Vec::new() }).unwrap();
    assert_eq!(slave.chk_cfg(), [0x10, 0x20]);
    assert_eq!("8".parse::<Modules>().unwrap(), Modules::InOrder(vec![ModuleChoice::Number(8)]));
    for wrong in ["", "3+", "3,7", "valve"] {
        let error = wrong.parse::<Modules>().unwrap_err().to_string();
        assert!(error.contains("3+7") && error.contains(&format!("{wrong:?}")), "{error}");
    }
}

#[test]
fn a_file_names_modules_with_any_characters_in_their_slots() {
    let slave = toml("[modules]\n1 = \"AI+AO, 4:20 mA\"\n4 = 7\n").unwrap();
    let slots: Vec<_> = slave.layout().modules.iter().map(|module| (module.slot, module.number)).collect();
    assert_eq!(slots, [(1, 3), (4, 7)]);
    let in_order = toml("modules = [7, \"AI+AO, 4:20 mA\"]").unwrap();
    assert_eq!(in_order.chk_cfg(), [0x20, 0x10]);
    assert_eq!(toml("modules = \"7+8\"").unwrap().chk_cfg(), [0x20, 0x21]);
}

#[test]
fn the_last_equals_sign_separates_name_and_value() {
    assert_eq!(set(&["Start = up=on"]).unwrap(), [1, 0, 5, 5, 5]);
    let change = Change { slot: None, target: "a=b".into(), value: "c".into() };
    assert_eq!("a=b=c".parse::<Change>().unwrap(), change);
    for wrong in ["Delay", "=5"] {
        assert!(wrong.parse::<Change>().unwrap_err().to_string().starts_with("expected NAME=VALUE"));
    }
}

#[test]
fn a_name_that_occurs_several_times_needs_slot_or_offset() {
    let error = set(&["Delay=9"]).unwrap_err();
    for part in ["slot 1 offset 0", "slot 1 offset 1", "slot 2 offset 0", "SLOT@OFFSET:NAME"] {
        assert!(error.contains(part), "{error}");
    }
    assert!(set(&["1:Delay=12"]).unwrap_err().contains("0 to 9"), "the file's name counts first");
    assert_eq!(set(&["2:Delay=9"]).unwrap(), [0, 0, 5, 5, 9]);
    assert_eq!(set(&["1@1:Delay=9"]).unwrap(), [0, 0, 5, 9, 5]);
    assert_eq!(set(&["1@1.0:Delay=9"]).unwrap(), [0, 0, 5, 9, 5]);
    assert_eq!(set(&["station:1:Delay=9"]).unwrap(), [0, 9, 5, 5, 5]);
}

#[test]
fn parameters_of_a_file_are_changed_in_their_slots() {
    let text = "modules = [3, 7]\n[parameters]\n\"Start = up\" = \"on\"\n[slot.1.parameters]\n\"@1:Delay\" = 8\n[slot.2.parameters]\nDelay = 9\n";
    assert_eq!(toml(text).unwrap().user_prm(), [1, 0, 5, 8, 9]);
}

#[test]
fn a_wrong_name_has_a_suggestion_and_the_possible_ones() {
    let error = toml("modules = [\"valv\"]").unwrap_err();
    assert!(error.contains("did you mean \"valve\"?") && error.contains("3 (AI+AO, 4:20 mA)"), "{error}");
    let error = set(&["Dealy=1"]).unwrap_err();
    assert!(error.contains("did you mean \"Delay\"?") && error.contains("Start = up"), "{error}");
    let error = set(&["Delay of something else=1"]).unwrap_err();
    assert!(!error.contains("did you mean"), "{error}");
}

#[test]
fn a_module_name_that_occurs_twice_asks_for_the_number() {
    let error = toml("modules = [\"valve\"]").unwrap_err();
    assert!(error.contains("7 (valve), 8 (valve)"), "{error}");
}

#[test]
fn a_value_out_of_range_names_the_possible_ones() {
    assert!(set(&["2:Delay=21"]).unwrap_err().contains("0 to 20"));
    assert!(set(&["Start = up=open"]).unwrap_err().contains("1 (on)"));
}

#[test]
fn an_unknown_number_names_the_modules_of_the_file() {
    let unknown = Selection { modules: "3+4".parse().unwrap(), changes: Vec::new() };
    assert!(slave(&unknown).unwrap_err().contains("the file has no module 4; it has 3 ("));
}

#[test]
fn a_wrong_file_is_refused_with_its_line() {
    for (text, part) in [
        ("[modul]\n1 = 3", "modul"),
        ("[modules]\na = 3", "number of a slot"),
        ("[modules]\n1 = -3", "-3"),
        ("[parameters]\nDelay = 1.5", "whole number"),
        ("[slot.1]\nDelay = 1", "Delay"),
    ] {
        let error = toml(text).unwrap_err();
        assert!(error.contains("line") && error.contains(part), "{error}");
    }
}

#[test]
fn a_slot_that_is_written_twice_is_refused() {
    for text in ["[modules]\n1 = 3\n01 = 7", "[slot.1.parameters]\nDelay = 1\n[slot.01.parameters]\nDelay = 2"] {
        let error = toml(text).unwrap_err();
        assert!(error.contains("slot 1 twice") && error.contains("line"), "{error}");
    }
}

#[test]
fn a_parameter_in_the_table_of_one_slot_that_names_another_is_refused() {
    let change = |place: &str| toml(&format!("modules = [3, 7]\n[slot.2.parameters]\n\"{place}:Delay\" = 9\n"));
    for wrong in ["3", "station", "1@0"] {
        let error = change(wrong).unwrap_err();
        assert!(error.contains(&format!("\"{wrong}:Delay\" stands in slot 2")), "{error}");
    }
    assert_eq!(change("2@0").unwrap().user_prm(), [0, 0, 5, 5, 9]);
}

#[test]
fn a_very_long_name_ends_soon_without_a_suggestion() {
    let name = "m".repeat(100_000);
    let file = format!("#Profibus_DP\nIdent_Number=1\nModule=\"{name}\" 0x10\nEndModule\n");
    let selection = Selection::from_toml(&format!("modules = [\"{name}n\"]")).unwrap();
    let error = GsdSlave::new(Arc::new(GsdFile::read(file.as_bytes())), &selection).unwrap_err().to_string();
    assert!(!error.contains("did you mean"));
}
