//! User parameters of Set_Prm.

use crate::support::file;
use profivac_gsd::{Configuration, DataType, GsdFile, Place, PrmError, Target};

const DEFINITIONS: &str = "\
PrmText=1
Text(0)=\"opens\"
Text(1)=\"closes\"
Text(2)=\"stays\"
Text(3)=\"stays\"
EndPrmText
ExtUserPrmData=1 \"Valve = without bus\"
BitArea(4-6) 1 0-3
Prm_Text_Ref=1
EndExtUserPrmData
ExtUserPrmData=2 \"Limit\"
Signed16 -2 -100-100
EndExtUserPrmData
ExtUserPrmData=3 \"Fixed\"
Unsigned8 7
Changeable=0
EndExtUserPrmData
Modular_Station=1
Max_Module=3
Module=\"m\" 0x10
Ext_Module_Prm_Data_Len=3
Ext_User_Prm_Data_Const(0)=0xA0
Ext_User_Prm_Data_Ref(1)=2
EndModule
Module=\"plain\" 0x20
EndModule
";

fn device(lines: &str) -> GsdFile {
    file(&format!("{DEFINITIONS}{lines}"))
}

fn octets(file: &GsdFile, modules: &[u32]) -> Vec<u8> {
    Configuration::new(file.device(), modules).expect("a configuration").user_prm().expect("user parameters")
}

#[test]
fn user_prm_data_stand_alone_or_are_replaced_as_a_whole() {
    assert_eq!(octets(&device("User_Prm_Data_Len=3\nUser_Prm_Data=1,2,3"), &[2]), [1, 2, 3]);
    assert_eq!(octets(&device("User_Prm_Data=1,2,3\nExt_User_Prm_Data_Const(1)=9"), &[2]), [0, 9]);
    assert_eq!(octets(&device("User_Prm_Data_Len=2\nUser_Prm_Data=1,2,3"), &[2]), [1, 2]);
    assert_eq!(octets(&device("User_Prm_Data_Len=4\nUser_Prm_Data=1,2,3"), &[2]), [1, 2, 3, 0]);
    assert_eq!(octets(&device(""), &[2]), [0_u8; 0]);
}

#[test]
fn the_parameters_of_modules_follow_those_of_the_station() {
    let file = device("Ext_User_Prm_Data_Const(0)=0x80,0x00,0x08");
    assert_eq!(octets(&file, &[1, 2, 1]), [0x80, 0, 8, 0xA0, 0xFF, 0xFE, 0xA0, 0xFF, 0xFE]);
}

#[test]
fn what_is_defined_last_counts_where_definitions_overlap() {
    assert_eq!(octets(&device("Ext_User_Prm_Data_Const(0)=0x8F\nExt_User_Prm_Data_Ref(0)=1"), &[2]), [0x9F]);
    assert_eq!(octets(&device("Ext_User_Prm_Data_Ref(0)=1\nExt_User_Prm_Data_Const(0)=0x8F"), &[2]), [0x8F]);
    assert_eq!(octets(&device("Ext_User_Prm_Data_Const(0)=1,2,3\nExt_User_Prm_Data_Const(1)=9"), &[2]), [1, 9, 3]);
}

#[test]
fn the_length_of_a_module_counts() {
    let module =
        |length: &str| device(&format!("Module=\"n\" 0x10\n{length}\nExt_User_Prm_Data_Const(0)=1,2\nEndModule"));
    assert_eq!(octets(&module(""), &[3]), [1, 2]);
    assert_eq!(octets(&module("Ext_Module_Prm_Data_Len=3"), &[3]), [1, 2, 0]);
    assert_eq!(octets(&module("Ext_Module_Prm_Data_Len=1"), &[3]), [1]);
}

#[test]
fn a_parameter_changes_by_its_name_to_a_number_or_a_text() {
    let file = device("Ext_User_Prm_Data_Ref(0)=1");
    let mut configuration = Configuration::new(file.device(), &[1]).expect("a configuration");
    for (value, octet) in [("opens", 0x00), ("1", 0x10), (" closes ", 0x10), ("0x3", 0x30)] {
        assert_eq!(configuration.set("Valve = without bus", value), Ok(()), "{value}");
        assert_eq!(configuration.user_prm(), Ok(vec![octet, 0xA0, 0xFF, 0xFE]), "{value}");
    }
    assert_eq!(configuration.set("Limit ", "100"), Ok(()));
    assert_eq!(configuration.user_prm(), Ok(vec![0x30, 0xA0, 0x00, 100]));
    let values: Vec<_> = configuration.parameters().iter().map(|one| (one.place, one.offset, one.value)).collect();
    assert_eq!(values, [(Place::Station, 0, 3), (Place::Slot(1), 1, 100)]);
}

#[test]
fn a_wrong_value_is_refused_with_the_possible_values() {
    let file = device("Ext_User_Prm_Data_Ref(0)=1");
    let mut configuration = Configuration::new(file.device(), &[1]).expect("a configuration");
    let mut words = |name: &str, value: &str| configuration.set(name, value).expect_err("an error").to_string();
    let texts = "possible are 0 (opens), 1 (closes), 2 (stays), 3 (stays)";
    assert_eq!(words("Valve = without bus", "4"), format!("Valve = without bus cannot be 4; {texts}"));
    assert_eq!(words("Valve = without bus", "stays"), format!("Valve = without bus cannot be stays; {texts}"));
    assert_eq!(words("Limit", "101"), "Limit cannot be 101; possible are -100 to 100");
    assert_eq!(words("limit", "1"), "no parameter limit; there are Limit, Valve = without bus");
    assert_eq!(configuration.user_prm(), Ok(vec![0x10, 0xA0, 0xFF, 0xFE]), "nothing has changed");
}

#[test]
fn parameters_with_one_name_in_one_octet_are_told_apart_by_their_first_bit() {
    let areas = ["BitArea(0-1)", "BitArea(2-3)", "Bit(4)"];
    let definition = |(kind, number): (&str, usize)| {
        format!(
            "ExtUserPrmData={number} \"Response\"\n{kind} 0 0-1\nEndExtUserPrmData\nExt_User_Prm_Data_Ref(23)={number}\n"
        )
    };
    let lines: String = areas.into_iter().zip(1..).map(definition).collect();
    let file = file(&format!("{lines}Module=\"m\" 0x10\nEndModule"));
    let mut configuration = Configuration::new(file.device(), &[1]).expect("a configuration");
    let target = Target { name: "Response", offset: Some(23), ..Target::default() };
    let error = configuration.set(target, "1").expect_err("three parameters");
    let station = "the station offset 23";
    assert_eq!(
        error.to_string(),
        format!(
            "several parameters Response; say slot, offset and first bit: {station} bits 0-1, {station} bits 2-3, {station} bit 4"
        )
    );
    for (bit, octet) in [(2, 0b0_0100), (4, 0b1_0100), (0, 0b1_0101)] {
        assert_eq!(configuration.set(Target { bit: Some(bit), ..target }, "1"), Ok(()), "bit {bit}");
        assert_eq!(configuration.user_prm().expect("user parameters").last(), Some(&octet), "bit {bit}");
    }
}

#[test]
fn a_name_that_occurs_several_times_asks_for_slot_and_offset() {
    let file = device("Ext_User_Prm_Data_Ref(0)=2\nExt_User_Prm_Data_Ref(2)=2");
    let mut configuration = Configuration::new(file.device(), &[2, 1]).expect("a configuration");
    let error = configuration.set("Limit", "1").expect_err("three");
    assert_eq!(
        error.to_string(),
        "several parameters Limit; say slot, offset and first bit: the station offset 0, the station offset 2, slot 2 offset 1"
    );
    assert_eq!(
        configuration.set(Target { name: "Limit", place: Some(Place::Slot(2)), offset: None, bit: None }, "1"),
        Ok(())
    );
    let elsewhere = Target { name: "Limit", place: Some(Place::Slot(1)), ..Target::default() };
    assert_eq!(
        configuration.set(elsewhere, "1").expect_err("no such place").to_string(),
        "Limit is not at this place; it is at the station offset 0, the station offset 2, slot 2 offset 1"
    );
    let station = Target { name: "Limit", place: Some(Place::Station), offset: Some(2), bit: None };
    assert_eq!(configuration.set(station, "2"), Ok(()));
    assert_eq!(configuration.user_prm(), Ok(vec![0xFF, 0xFE, 0, 2, 0xA0, 0, 1]));
}

#[test]
fn a_parameter_slot_number_is_the_slot_of_its_module() {
    let file = file(
        "Modular_Station=1\nExtUserPrmData=1 \" [slotNumber] \"\nUnsigned8 1 1-2\nEndExtUserPrmData\n\
         Module=\"m\" 0x10\nExt_User_Prm_Data_Ref(0)=1\nEndModule",
    );
    let mut configuration = Configuration::new(file.device(), &[1, 1]).expect("a configuration");
    assert_eq!(configuration.user_prm(), Ok(vec![1, 2]));
    assert_eq!(configuration.parameters().iter().map(|one| one.value).collect::<Vec<_>>(), [1, 2]);
    let target = Target { name: "[slotNumber]", place: Some(Place::Slot(2)), offset: None, bit: None };
    let error = configuration.set(target, "1").expect_err("no value to set");
    assert_eq!(
        error.to_string(),
        "[slotNumber] is always the number of its slot, here 2; plug the module in another slot"
    );
    assert_eq!(configuration.user_prm(), Ok(vec![1, 2]), "nothing has changed");
    let error = Configuration::new(file.device(), &[1, 1, 1]).expect_err("slot 3 is out of range");
    assert_eq!(error.to_string(), "1 (m) sends the number of its slot, which cannot be 3; possible are 1 to 2");
}

#[test]
fn a_fixed_parameter_and_a_covered_one_cannot_change() {
    let file = device("Ext_User_Prm_Data_Ref(0)=3\nExt_User_Prm_Data_Ref(1)=2\nExt_User_Prm_Data_Const(2)=5");
    let mut configuration = Configuration::new(file.device(), &[2]).expect("a configuration");
    assert_eq!(configuration.set("Fixed", "8"), Err(PrmError::NotChangeable { name: "Fixed".to_owned() }));
    let line = file
        .text()
        .lines()
        .collect::<Vec<_>>()
        .iter()
        .rposition(|line| *line == "Ext_User_Prm_Data_Ref(1)=2")
        .map_or(0, |index| index + 1);
    assert_eq!(configuration.set("Limit", "1"), Err(PrmError::Covered { name: "Limit".to_owned(), line }));
    assert_eq!(configuration.user_prm(), Ok(vec![7, 0xFF, 5]), "nothing has changed");
}

#[test]
fn user_parameters_stay_within_the_length_of_the_file_and_of_the_protocol() {
    let file = device("Max_User_Prm_Data_Len=6");
    assert_eq!(octets(&file, &[1, 1]).len(), 6);
    let error = |file: &GsdFile| Configuration::new(file.device(), &[1, 1, 1]).expect("a configuration").user_prm();
    assert_eq!(error(&file), Err(PrmError::TooLong { octets: 9, most: 6, station: 0 }));
    assert_eq!(
        error(&device("Ext_User_Prm_Data_Const(228)=1")),
        Err(PrmError::TooLong { octets: 238, most: 237, station: 229 })
    );
    assert_eq!(error(&device("Ext_User_Prm_Data_Const(227)=1")).map(|octets| octets.len()), Ok(237));
}

#[test]
fn the_value_of_each_type_returns_from_its_octets() {
    let kinds = [
        DataType::Bit(7),
        DataType::BitArea(1, 3),
        DataType::BitArea(0, 7),
        DataType::Unsigned8,
        DataType::Unsigned16,
        DataType::Unsigned32,
        DataType::Signed8,
        DataType::Signed16,
        DataType::Signed32,
    ];
    for kind in kinds {
        let (low, high) = kind.limits();
        for value in [low, low + 1, 0, 1, high / 2, high].into_iter().filter(|value| (low..=high).contains(value)) {
            for before in [0x00, 0xFF] {
                let mut octets = [before; 5];
                kind.put(value, &mut octets);
                assert_eq!(kind.get(&octets), Some(value), "{kind} {value}");
                assert!(
                    octets.get(kind.octets()..).is_some_and(|rest| rest.iter().all(|octet| *octet == before)),
                    "{kind}"
                );
            }
        }
    }
    let mut octets = [0xFF];
    DataType::BitArea(1, 3).put(2, &mut octets);
    assert_eq!(octets, [0b1111_0101]);
    assert_eq!(
        (DataType::Signed32.limits(), DataType::Unsigned32.limits()),
        ((-2_147_483_648, 2_147_483_647), (0, 4_294_967_295))
    );
}

/// Advice that helps: no choice of modules shortens the parameters of the station.
#[test]
fn station_parameters_beyond_the_length_of_the_file_get_advice_of_their_own() {
    let file = device("Max_User_Prm_Data_Len=2\nExt_User_Prm_Data_Const(0)=1,2,3");
    let error = Configuration::new(file.device(), &[2]).expect("a configuration").user_prm().expect_err("too long");
    assert_eq!(
        error.to_string(),
        "the parameters of the station alone have 3 octets, and at most 2 are possible, so no choice of modules helps; correct \
         Max_User_Prm_Data_Len or the offsets in a copy of the file, or ask the vendor for another one"
    );
    let file = device("Max_User_Prm_Data_Len=3\nExt_User_Prm_Data_Const(0)=1,2,3");
    let error = Configuration::new(file.device(), &[1]).expect("a configuration").user_prm().expect_err("too long");
    assert_eq!(error.to_string(), "6 octets of user parameters; at most 3 are possible; choose fewer modules");
}
