//! Devices that measure no pressure: numbers in units of their own, codes and commands.

use profivac_client::names::ParameterNames;
use profivac_client::values::{Value, ValueFormat};
use profivac_device_file::{DeviceFile, show};
use profivac_devices::model::{Model, NumberType};

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
