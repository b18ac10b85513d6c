//! Devices that measure no pressure: numbers in units of their own, codes and commands.

use profivac_client::gsd::gsd;
use profivac_client::names::ParameterNames;
use profivac_client::values::{Value, ValueFormat};
use profivac_device_file::{DeviceFile, show};
use profivac_devices::model::{Codes, CyclicValue, DataType, Model, NumberType};
use profivac_gsd::GsdFile;
use std::path::Path;

const TURBO: &str = r#"format = 1
name = "turbo"
title = "Turbo pump"
vendor = "A maker"
manual = "none"
ident = 0x1234
user-parameters = [{ name = "none", octets = "" }]
configurations = [{ inputs = 1, octets = "13" }]
[services]
dpv1 = true
[inputs]
1 = ["ignored 4"]
[codes.command]
commands = [{ code = 1, name = "start" }, { code = 2, name = "vent", risk = "lets air in" }]
[[block]]
name = "Pump"
at = [{ slot = 0, name = "Pump" }]
parameters = [
  { index = 1, name = "Rotation Speed", type = "UINT16", access = "1/2_R", store = "V", unit = "Hz" },
  { index = 2, name = "Temperature", type = "INT16", access = "1/2_R", store = "V", unit = "°C", factor = 0.1 },
  { index = 3, name = "Set Speed", type = "UINT16", access = "1/2_R/W", store = "N", unit = "Hz", range = [200, 1000] },
  { index = 4, name = "Flow", type = "FLOAT", access = "1/2_R/W", store = "N", unit = "sccm" },
  { index = 6, name = "Pulses", type = "UINT32", access = "1/2_R/W", store = "N", unit = "Hz" },
  { index = 7, name = "Set Flow", type = "FLOAT", access = "1/2_R/W", store = "N", unit = "sccm", range = [0, 100] },
  { index = 8, name = "Set Temperature", type = "INT16", access = "1/2_R/W", store = "N", unit = "°C", factor = 0.1, range = [3, 1003] },
  { index = 5, name = "Command", type = "UINT8", access = "1/2_W", codes = "command" },
]
"#;

fn model(text: &str) -> &'static Model {
    DeviceFile::parse(text).unwrap_or_else(|error| panic!("{error}")).model().unwrap()
}

/// What reading these octets says.
fn shown(model: &'static Model, index: u8, octets: &[u8]) -> String {
    let names = ParameterNames::shared(model);
    let named = names.at(0, 0, index).unwrap();
    let value = Value::of_row(named.parameter.row, octets).unwrap();
    ValueFormat { named, model, unit: None }.text(octets, &value)
}

fn parsed(model: &'static Model, index: u8, text: &str) -> Result<Vec<u8>, String> {
    let named = ParameterNames::shared(model).at(0, 0, index).unwrap();
    ValueFormat { named, model, unit: None }.parse(text, NumberType::Float).map_err(|error| error.to_string())
}

#[test]
fn a_number_has_the_unit_and_the_factor_of_its_row() {
    let model = model(TURBO);
    assert_eq!(shown(model, 1, &1500_u16.to_be_bytes()), "1500 Hz");
    assert_eq!(shown(model, 2, &(-103_i16).to_be_bytes()), "-10.3 °C");
    assert_eq!(shown(model, 2, &3_i16.to_be_bytes()), "0.3 °C");
    assert_eq!(shown(model, 4, &2.5_f32.to_be_bytes()), "2.5 sccm");
    for text in ["900 Hz", "900Hz", "900"] {
        assert_eq!(parsed(model, 3, text), Ok(900_u16.to_be_bytes().to_vec()), "{text}");
    }
    assert_eq!(parsed(model, 2, "-10.3 °C"), Ok((-103_i16).to_be_bytes().to_vec()));
    assert_eq!(parsed(model, 4, "2.5 sccm"), Ok(2.5_f32.to_be_bytes().to_vec()));
    for text in ["1200 Hz", "100", "900.5 Hz", "900 rpm", "", "nan"] {
        let refused = parsed(model, 3, text).unwrap_err();
        assert!(refused.contains("a number from 200 Hz to 1000 Hz"), "{text}: {refused}");
    }
    // A large number keeps each of its digits, and a fraction of a step is none.
    let pulses = 123_456_789_u32.to_be_bytes();
    assert_eq!(shown(model, 6, &pulses), "123456789 Hz");
    assert_eq!(parsed(model, 6, "123456789 Hz"), Ok(pulses.to_vec()));
    assert!(parsed(model, 6, "600000.5 Hz").is_err());
    // The range of the manual holds for a float as well.
    assert_eq!(parsed(model, 7, "100 sccm"), Ok(100_f32.to_be_bytes().to_vec()));
    for text in ["100.1 sccm", "-0.1", "nan"] {
        assert!(parsed(model, 7, text).unwrap_err().contains("a number from 0 sccm to 100 sccm"), "{text}");
    }
    assert!(parsed(model, 8, "0.2 °C").unwrap_err().contains("a number from 0.3 °C to 100.3 °C"));
    let again = model_of(&show(model));
    assert_eq!(format!("{:?}", again.blocks), format!("{:?}", model.blocks));
}

fn model_of(shown: &str) -> &'static Model {
    model(&shown.replacen("name = \"turbo\"", "name = \"again\"", 1))
}

#[test]
fn a_device_without_pressures_needs_no_units_and_a_gauge_does() {
    assert_eq!(model(TURBO).units.len(), 1);
    let said =
        |text: &str| DeviceFile::parse(text).map(|_| "read".to_owned()).unwrap_or_else(|error| error.to_string());
    for (old, new, expected) in [
        (
            "\"FLOAT\", access = \"1/2_R/W\", store = \"N\", unit = \"sccm\" }",
            "\"BY_TYPE\", access = \"1/2_R/W\", store = \"N\", unit = \"sccm\" }",
            "a unit is for a number; BY_TYPE has none, delete it",
        ),
        (
            "\"FLOAT\", access = \"1/2_R/W\", store = \"N\", unit = \"sccm\" }",
            "\"BY_TYPE\", access = \"1/2_R\" }",
            "expected the key units;",
        ),
        ("factor = 0.1 }", "factor = 0.0 }", "expected a factor from 1e-9 to 1e9"),
        (
            "unit = \"°C\", factor = 0.1 }",
            "factor = 0.1 }",
            "factor is for a number with a unit; add unit, or delete factor",
        ),
        (
            "codes = \"command\"",
            "codes = \"command\", unit = \"Hz\"",
            "a number in a unit has no codes and no per-mille",
        ),
        ("range = [200, 1000]", "range = [1000, 200]", "expected the lower limit first"),
    ] {
        assert_eq!(TURBO.matches(old).count(), 1, "{old}");
        let found = said(&TURBO.replace(old, new));
        assert!(found.contains(expected), "{new}: {found}");
    }
}

/// The pump with values in its cyclic data.
fn with_values(values: &str) -> String {
    let head = "[services]\ndpv1 = true\n[inputs]\n1 = [\"ignored 4\"]\n";
    assert_eq!(TURBO.matches(head).count(), 1);
    TURBO.replace(
        head,
        &format!("values = [\n{values}\n]\n{head}[codes.state]\nnames = [{{ code = 3, name = \"at speed\" }}]\n"),
    )
}

#[test]
fn values_of_the_cyclic_data_are_in_the_tables_and_the_same_after_a_file() {
    let text = with_values(
        r#"{ name = "speed", inputs = 1, type = "UINT16", unit = "Hz", factor = 0.5 },
           { name = "state", inputs = 1, octet = 2, type = "UINT8", codes = "state" },
           { name = "alarm", inputs = 1, octet = 3, bit = 7, type = "BOOLEAN" },"#,
    );
    let model = model(&text);
    let of = |value: &CyclicValue| (value.name, value.octet, value.bit, value.data_type);
    let values: Vec<_> = model.values_of(&model.configurations[0], false).map(of).collect();
    let expected =
        [("speed", 0, 0, DataType::Uint16), ("state", 2, 0, DataType::Uint8), ("alarm", 3, 7, DataType::Boolean)];
    assert_eq!(values, expected);
    assert_eq!(model.values_of(&model.configurations[0], true).count(), 0, "of the outputs");
    let again = model_of(&show(model));
    assert_eq!(format!("{:?}", again.values), format!("{:?}", model.values));
}

#[test]
fn a_value_is_within_octets_without_a_meaning_and_has_a_type_that_fits() {
    for (value, expected) in [
        (r#"{ name = "speed", type = "UINT16" }"#, "expected either inputs or outputs"),
        (r#"{ name = "speed", inputs = 1, outputs = 1, type = "UINT16" }"#, "expected either inputs or outputs"),
        (r#"{ name = "speed", inputs = 2, type = "UINT16" }"#, "expected a telegram, one of: 1; found 2"),
        (
            r#"{ name = "speed", inputs = 1, octet = 3, type = "UINT16" }"#,
            "the octets 3 to 4 of telegram 1 are not within",
        ),
        (r#"{ name = "speed", inputs = 1, type = "VSTRING(4)" }"#, "expected the type of a value, one of: BOOLEAN"),
        (r#"{ name = "speed", inputs = 1, type = "UINT8", bit = 1 }"#, "bit is for a BOOLEAN"),
        (r#"{ name = "speed", inputs = 1, type = "BOOLEAN", bit = 8 }"#, "expected a bit from 0"),
        (r#"{ name = "speed", inputs = 1, type = "FLOAT", codes = "state" }"#, "have no codes"),
        (
            r#"{ name = "speed", inputs = 1, type = "UINT8", codes = "command" }"#,
            "expected a table of [codes] with names",
        ),
        (r#"{ name = "Speed", inputs = 1, type = "UINT8" }"#, "small letters, digits and hyphens"),
        (
            r#"{ name = "speed", inputs = 1, type = "UINT8", unit = "turns per minute" }, { name = "speed", inputs = 1, type = "UINT8" }"#,
            "is here twice",
        ),
    ] {
        let found =
            DeviceFile::parse(&with_values(value)).map(|_| "read".to_owned()).unwrap_or_else(|error| error.to_string());
        assert!(found.contains(expected), "{value}: {found}");
    }
}

/// An identifier with data of the manufacturer, as a TIC 253 has, and one with consistent octets.
#[test]
fn octets_without_a_meaning_may_have_an_identifier_with_types_of_the_manufacturer() {
    let with = |octets: &str| TURBO.replace("octets = \"13\"", &format!("octets = \"{octets}\""));
    for octets in ["41 83 01", "41 03 01", "40 83", "93"] {
        assert_eq!(model(&with(octets)).configurations[0].input_octets(), 4, "{octets}");
    }
    for octets in ["41 82 01", "41 83", "23", "C1 80 83 01"] {
        let error = DeviceFile::parse(&with(octets)).unwrap_err().to_string();
        assert!(error.contains("the octets do not announce the telegrams"), "{octets}: {error}");
    }
}

/// Its user parameters have no unit, so its GSD file has no parameter for one.
#[test]
fn the_gsd_file_of_a_device_without_user_parameters_has_none() {
    let file = GsdFile::read(gsd(model(TURBO)).as_bytes());
    assert_eq!((file.device().parameters.len(), file.device().general.max_user_prm_data_len), (0, Some(0)));
}

/// Fail_Safe and Check_Cfg_Mode are bits of DPV1_Status_1 and 2. A string without room for these octets is the code of a unit.
#[test]
fn the_strings_of_a_file_match_themselves_and_no_other_unit() {
    let strings = r#"user-parameters = [
  { name = "status", octets = "C0 01 00" },
  { name = "one unit", octets = "13 08" },
  { name = "another unit", octets = "13 09" },
]"#;
    let model = model(&TURBO.replace("user-parameters = [{ name = \"none\", octets = \"\" }]", strings));
    let name = |user: &[u8]| model.user_prm(user).map(|prm| prm.name);
    assert_eq!(name(&[0xC0, 1, 0]), Some("status"));
    assert_eq!(name(&[0x80, 1, 0]), None);
    assert_eq!([name(&[0x13, 8]), name(&[0x13, 9])], [Some("one unit"), Some("another unit")]);
    assert_eq!([name(&[0x13, 0x0A]), name(&[0x53, 8])], [None; 2]);
}

/// The station owns the slave with the three octets, which its GSD file has not.
#[test]
fn a_dpv1_device_without_user_parameters_takes_dpv1_status() {
    let takes = |text: &str, user: &[u8]| model(text).user_prm(user).is_some();
    for user in [&[][..], &[0, 0, 0], &[0x40, 1, 0]] {
        assert!(takes(TURBO, user), "{user:02X?}");
    }
    for user in [&[0][..], &[0, 0, 1], &[4, 0, 0], &[0, 0, 0, 0]] {
        assert!(!takes(TURBO, user), "{user:02X?}");
    }
    assert!(!takes(&TURBO.replace("dpv1 = true", "dpv1 = false"), &[0, 0, 0]));
}

/// tira41d1 3.3.3.6 and tira54e1 7.1.14.
#[test]
fn the_files_of_the_gallery_have_the_units_of_their_numbers() {
    for (file, name, unit) in [("bpg402.toml", "Emission Current", "mA"), ("cdg.toml", "Run hours", "h")] {
        let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../docs/devices/files").join(file);
        let model = DeviceFile::read(&path).unwrap().model().unwrap();
        let mut rows = model.blocks.iter().flat_map(|placed| placed.block.rows);
        let codes = &rows.find(|row| row.name == name).unwrap().codes;
        assert!(matches!(codes, Codes::Quantity(quantity) if quantity.unit == unit), "{file}: {codes:?}");
    }
}
