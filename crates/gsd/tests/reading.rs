//! User parameters of a Set_Prm back to named values.

use crate::support::file;
use profivac_gsd::{Fit, GsdFile, Reading};

const DEFINITIONS: &str = "\
PrmText=1
Text(0)=\"opens\"
Text(1)=\"closes\"
EndPrmText
ExtUserPrmData=1 \"Valve\"
BitArea(4-5) 1 0-1
Prm_Text_Ref=1
EndExtUserPrmData
ExtUserPrmData=2 \"Limit\"
Signed16 -2 -100-100
EndExtUserPrmData
ExtUserPrmData=3 \"[SlotNumber]\"
Unsigned8 0 0-9
EndExtUserPrmData
Modular_Station=1
Max_Module=3
Module=\"plain\" 0x20
EndModule
Module=\"limited\" 0x10
Ext_Module_Prm_Data_Len=4
Ext_User_Prm_Data_Const(0)=0xA0
Ext_User_Prm_Data_Ref(1)=2
Ext_User_Prm_Data_Ref(3)=3
EndModule
Module=\"short\" 0x10
Ext_Module_Prm_Data_Len=1
Ext_User_Prm_Data_Const(0)=0xB0
EndModule
Module=\"other\" 0x10
Ext_Module_Prm_Data_Len=4
Ext_User_Prm_Data_Const(0)=0xC0
EndModule
";

fn device(lines: &str) -> GsdFile {
    file(&format!("{DEFINITIONS}{lines}"))
}

fn read<'a>(file: &'a GsdFile, chk_cfg: &[u8], user: &[u8]) -> Reading<'a> {
    Fit::new(file.device(), chk_cfg).unwrap().read_prm(user)
}

fn values(reading: &Reading<'_>) -> Vec<String> {
    reading.values.iter().map(|value| format!("{} octet {}: {value}", value.place, value.octet)).collect()
}

fn differences(reading: &Reading<'_>) -> Vec<String> {
    reading.differences.iter().map(|one| format!("{}: {one}", one.place)).collect()
}

#[test]
fn parameters_of_station_and_modules_get_their_names_texts_and_defaults() {
    let file = device("Ext_User_Prm_Data_Const(0)=0x0F\nExt_User_Prm_Data_Ref(0)=1");
    let reading = read(&file, &[0x20, 0x10], &[0x0F, 0xA0, 0xFF, 0xFE, 2]);
    assert_eq!(
        values(&reading),
        [
            "the station octet 0: Valve = opens (0), default closes (1)",
            "slot 2 octet 2: Limit = -2",
            "slot 2 octet 4: [SlotNumber] = 2",
        ]
    );
    assert_eq!(differences(&reading), [""; 0]);
    assert!(reading.has_right_length());
    assert_eq!(reading.values.iter().filter(|value| !value.is_usual()).count(), 1);
}

#[test]
fn a_value_that_the_file_does_not_allow_is_named_with_the_possible_ones() {
    let file = device("");
    let reading = read(&file, &[0x10], &[0xA0, 0x00, 101, 3]);
    assert_eq!(
        values(&reading),
        [
            "slot 1 octet 1: Limit = 101, default -2, which the file does not allow: possible are -100 to 100",
            "slot 1 octet 3: [SlotNumber] = 3, the slot is 1",
        ]
    );
}

#[test]
fn octets_that_differ_from_constants_or_are_not_defined_are_named() {
    let file = device("Ext_User_Prm_Data_Const(0)=0x0F\nExt_User_Prm_Data_Ref(0)=1\nExt_User_Prm_Data_Const(2)=7");
    let reading = read(&file, &[0x20], &[0x1E, 0x03, 0x07]);
    assert_eq!(
        differences(&reading),
        ["the station: octet 0 is 1E, the file has 1F", "the station: octet 1 is 03, the file defines nothing there",]
    );
    assert_eq!(differences(&read(&file, &[0x20], &[0x1F, 0x00, 0x07])), [""; 0]);
}

#[test]
fn the_length_by_the_file_and_in_the_telegram_are_known() {
    let file = device("Ext_User_Prm_Data_Const(0)=1,2");
    let longer = read(&file, &[0x20], &[1, 2, 9]);
    assert_eq!((longer.expected, longer.found, longer.has_right_length()), (2, 3, false));
    assert_eq!(differences(&longer), ["slot 1: octet 2 is 09, the file defines nothing there"]);
    let shorter = read(&file, &[0x10], &[1, 2, 0xA0, 0]);
    assert_eq!((shorter.expected, shorter.found), (3, 4), "the module `short` fits best");
    assert_eq!(read(&file, &[0x20], &[1]).expected, 2);
}

#[test]
fn where_definitions_overlap_both_are_named_and_the_later_one_counts() {
    let file = device("Ext_User_Prm_Data_Ref(0)=2\nExt_User_Prm_Data_Ref(1)=1\nExt_User_Prm_Data_Const(3)=5");
    let reading = read(&file, &[0x20], &[0x00, 0x00, 0x00, 0x05]);
    assert_eq!(
        values(&reading),
        [
            "the station octet 0: Limit = 0, but the file defines Valve in the same bits later, which counts",
            "the station octet 1: Valve = opens (0), default closes (1)",
        ]
    );
    let file = device("Ext_User_Prm_Data_Ref(0)=1\nExt_User_Prm_Data_Const(0)=0x20");
    let reading = read(&file, &[0x20], &[0x20]);
    assert_eq!(
        values(&reading),
        ["the station octet 0: Valve = 2, but the file defines a constant in the same bits later, which counts"]
    );
    assert!(reading.values.iter().all(profivac_gsd::ReadValue::is_usual));
}

#[test]
fn user_prm_data_alone_are_constants() {
    let file = device("User_Prm_Data_Len=2\nUser_Prm_Data=1,2");
    assert_eq!(differences(&read(&file, &[0x20], &[1, 3])), ["the station: octet 1 is 03, the file has 02"]);
}

#[test]
fn dp_v1_status_octets_are_named_by_their_bits() {
    let file = device("DPV1_Slave=1\nExt_User_Prm_Data_Const(0)=0x80,0x20,0x00,0x55");
    let reading = read(&file, &[0x20], &[0x84, 0x40, 0x0A, 0x56]);
    assert_eq!(
        differences(&reading),
        [
            "the station: DP-V1 status octet 1: WD_BASE_1MS on",
            "the station: DP-V1 status octet 2: PROCESS_ALARM on, DIAGNOSTIC_ALARM off",
            "the station: DP-V1 status octet 3: PRM_STRUCTURE on, ALARM_MODE 2",
            "the station: octet 3 is 56, the file has 55",
        ]
    );
}

#[test]
fn of_modules_with_equal_identifiers_the_one_whose_length_and_constants_fit_is_taken() {
    let file = device("Ext_User_Prm_Data_Const(0)=0x01");
    let module = |user: &[u8]| read(&file, &[0x10], user).modules[0].1.name.clone();
    assert_eq!(module(&[1, 0xA0, 0, 0, 1]), "limited");
    assert_eq!(module(&[1, 0xB0]), "short");
    assert_eq!(module(&[1, 0xC0, 0, 0, 0]), "other");
    let both = read(&file, &[0x10, 0x10], &[1, 0xC0, 0, 0, 0, 0xB0]);
    let names: Vec<_> = both.modules.iter().map(|(slot, module)| (*slot, module.name.as_str())).collect();
    assert_eq!(names, [(1, "other"), (2, "short")]);
}

#[test]
fn the_station_is_read_before_its_modules_are_known() {
    let file = device("Ext_User_Prm_Data_Ref(0)=1");
    let reading = file.device().read_station_prm(&[0x10, 0xA0, 0x00]);
    assert_eq!(values(&reading), ["the station octet 0: Valve = closes (1)"]);
    assert_eq!((reading.expected, reading.found), (1, 3));
}

/// Every configuration that the file makes is read back to the values that it was made of.
#[test]
fn what_a_configuration_writes_is_read_back() {
    let file = device("Ext_User_Prm_Data_Ref(0)=1");
    let mut configuration = profivac_gsd::Configuration::new(file.device(), &[1, 2, 4]).unwrap();
    configuration.set("Valve", "opens").unwrap();
    configuration.set("Limit", "-100").unwrap();
    let reading = read(&file, &configuration.chk_cfg(), &configuration.user_prm().unwrap());
    let written: Vec<_> = configuration.parameters().iter().map(|one| (one.place, one.value)).collect();
    assert_eq!(reading.values.iter().map(|one| (one.place, one.value)).collect::<Vec<_>>(), written);
    assert_eq!(differences(&reading), [""; 0]);
    assert!(reading.has_right_length());
}

/// Slots with thousands of modules of equal octets: hours of comparing, unless equal parameters are compared once and different ones only
/// up to a limit.
#[test]
fn the_comparison_with_very_many_modules_ends_soon() {
    let parameters = "ExtUserPrmData=1 \"p\"\nUnsigned8 0 0-9\nEndExtUserPrmData\n";
    let station = |module: &dyn Fn(usize) -> String| {
        let modules: String = (1..=10_000)
            .map(|number| format!("Module=\"m{number}\" 0x00\nExt_Module_Prm_Data_Len={}\nEndModule\n", module(number)))
            .collect();
        file(&format!("{parameters}Modular_Station=1\n{modules}"))
    };
    let equal = station(&|_| "1\nExt_User_Prm_Data_Ref(0)=1".to_owned());
    let reading = read(&equal, &[0x00; 237], &[3; 237]);
    assert!(reading.has_right_length() && reading.values.iter().all(|value| value.value == 3));
    assert_eq!(reading.values.len(), 237);
    let different = station(&|number| format!("{}\nExt_User_Prm_Data_Const(0)={}", number % 200, number % 251));
    let reading = read(&different, &[0x00; 244], &[3; 60]);
    assert_eq!((reading.modules.len(), reading.found), (244, 60));
}

#[test]
fn of_equal_modules_with_equal_parameters_the_first_is_taken() {
    let twin = "Module=\"twin\" 0x10\nExt_Module_Prm_Data_Len=1\nExt_User_Prm_Data_Const(0)=0xB0\nEndModule";
    let file = device(twin);
    let reading = read(&file, &[0x10, 0x10], &[0xB0, 0xB0]);
    let names: Vec<_> = reading.modules.iter().map(|(slot, module)| (*slot, module.name.as_str())).collect();
    assert_eq!(names, [(1, "short"), (2, "short")]);
    let [short, twin] =
        ["short", "twin"].map(|name| file.device().modules_named(name).next().unwrap().prm.definition());
    assert_eq!(short, twin, "the lines of the file do not count");
}
