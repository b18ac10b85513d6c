//! Values of rows of each kind, as text and from text.

use super::*;
use crate::names::{ParameterNames, Target};
use profivac_devices::catalog::model_named;
use profivac_devices::model::{DataType, NumberType, Quantity};

fn with<T>(device: &str, target: &str, unit: &str, ask: impl FnOnce(&ValueFormat<'_>) -> T) -> T {
    let model = model_named(device).unwrap();
    let names = ParameterNames::of(model);
    let Ok(Target::Parameter(named)) = names.find(model.name, target) else { panic!("{target}") };
    ask(&ValueFormat { named, model, unit: model.unit_named(unit) })
}

fn parsed(device: &str, target: &str, text: &str) -> String {
    with(device, target, "mbar", |meaning| match meaning.parse(text, NumberType::Float) {
        Ok(octets) => hex(&octets),
        Err(error) => error.to_string(),
    })
}

fn shown(device: &str, target: &str, octets: &[u8]) -> String {
    with(device, target, "mbar", |meaning| meaning.format(&Value::of_row(meaning.row(), octets).unwrap()))
}

#[test]
fn values_are_formatted_with_names_and_units() {
    for (device, target, octets, text) in [
        ("bcg450", "device.device-state", &[4][..], "EXECUTING"),
        ("bcg450", "pirani.process-value", &5.5e-3f32.to_be_bytes(), "5.5e-3 mbar"),
        ("bcg450", "pirani.full-scale", &1000f32.to_be_bytes(), "1000 mbar"),
        ("bcg450", "pirani.process-value", &[0x61, 0xA8], "25000 mbar"),
        ("bcg450", "pirani.data-units", &1308u16.to_be_bytes(), "mbar"),
        ("pcg550", "pirani.data-unit", &0x1309u16.to_be_bytes(), "Pascal"),
        ("bcg450", "pirani.data-type", &[8], "float"),
        ("bcg450", "pirani.reading-valid", &[1], "true"),
        ("bcg450", "device.serial-number", b"4711      ", "4711"),
        ("bcg450", "device.exception-status", &[0xA1], "alarm-device-common, warning-device-specific, expanded-format"),
        ("bcg450", "one-of-n.one-of-n-status-extension", &[0], "none"),
        ("bcg450", "ba.emission-current", &0.025f32.to_be_bytes(), "0.025 mA"),
        ("img400", "channel.1/emission-current", &5f32.to_be_bytes(), "45-mA"),
        ("img400", "device.device-state", &[100], "INIT"),
        ("bcg450", "device.device-exception-detail-alarm-4-5", &[1, 0xFE], "01 FE"),
        // The examples of the manual, and numbers that are no version.
        ("tpg500", "device.program-version", &[0x50, 0x97, 0x31, 0x01], "509731-A"),
        ("tpg300", "device.program-version", &[0x50, 0x97, 0x80, 0x06], "509780-F"),
        ("tpg300", "device.program-version", &[0x50, 0x97, 0x80, 0x00], "1352105984"),
        ("tpg300", "device.program-version", &[0x50, 0x97, 0x80, 0x16], "1352106006"),
        ("tpg300", "device.program-version", &[0x5A, 0x97, 0x80, 0x06], "1519878150"),
    ] {
        assert_eq!(shown(device, target, octets), text, "{device} {target}");
    }
}

/// tira41d1 3.3.3.6, tira36e1 3.3.3.6, tira56e1 7.1.14 and 7.1.23.
#[test]
fn a_number_of_a_table_has_the_unit_and_the_step_of_its_manual() {
    for (device, target, octets, number, text) in [
        ("bcg450", "ba.emission-current", &5f32.to_be_bytes()[..], 5.0, "5 mA"),
        ("bpg400", "ba.emission-current", &20f32.to_be_bytes(), 20.0, "20 mA"),
        ("pcg550", "device.run-hours", &7u16.to_be_bytes(), 7.0, "7 h"),
        ("pcg550", "device.run-hours-4", &7u32.to_be_bytes(), 1.75, "1.75 h"),
        ("psg550", "device.run-hours", &u16::MAX.to_be_bytes(), 65_535.0, "65535 h"),
        ("psg550", "device.run-hours-4", &u32::MAX.to_be_bytes(), 1_073_741_823.75, "1073741823.75 h"),
    ] {
        with(device, target, "mbar", |format| {
            let value = Value::of_row(format.row(), octets).unwrap();
            assert_eq!((&value, format.format(&value).as_str()), (&Value::Number(number), text), "{device} {target}");
            assert_eq!(format.parse(text, NumberType::Float).unwrap(), octets, "{device} {target}");
        });
    }
}

/// A float of 32 bits has the digits that it was written with.
#[test]
fn a_cyclic_value_in_a_unit_has_the_digits_of_its_type() {
    let text = |data_type: DataType, factor: f64, octets: &[u8]| {
        let codes = Codes::Quantity(Quantity { unit: "sccm", factor, range: None });
        let flow = CyclicValue { name: "flow", is_output: false, telegram: 1, octet: 0, bit: 0, data_type, codes };
        cyclic_text(&flow, octets)
    };
    assert_eq!(text(DataType::Float, 1.0, &23.4_f32.to_be_bytes()).as_deref(), Some("23.4 sccm"));
    assert_eq!(text(DataType::Float, 0.1, &23.4_f32.to_be_bytes()).as_deref(), Some("2.34 sccm"));
    assert_eq!(text(DataType::Uint32, 0.25, &u32::MAX.to_be_bytes()).as_deref(), Some("1073741823.75 sccm"));
    assert_eq!(text(DataType::Int16, 0.1, &(-3_i16).to_be_bytes()).as_deref(), Some("-0.3 sccm"));
}

/// Tenths of a percent are a detail of the record.
#[test]
fn a_percentage_is_a_number_of_percent() {
    for (tenths, percent, text) in [(50_u16, 5.0, "5 %"), (1_400, 140.0, "140 %"), (125, 12.5, "12.5 %")] {
        with("bcg450", "setpoint-a.percentage-of-atmosphere", "mbar", |format| {
            let value = Value::of_row(format.row(), &tenths.to_be_bytes()).unwrap();
            assert_eq!((&value, format.format(&value).as_str()), (&Value::Number(percent), text));
            assert_eq!(format.parse(text, NumberType::Float).unwrap(), tenths.to_be_bytes());
        });
    }
}

#[test]
fn values_are_parsed_by_name_number_and_unit() {
    for (device, target, text, octets) in [
        ("bcg450", "pirani.safe-state", "use-safe-value", "03"),
        ("bcg450", "pirani.safe-state", "Full Scale", "01"),
        ("bcg450", "pirani.safe-state", "2", "02"),
        ("bcg450", "pirani.safe-value", "0.125 mbar", "3E 00 00 00"),
        ("bcg450", "pirani.safe-value", "12.5 Pascal", "3E 00 00 00"),
        ("bcg450", "pirani.safe-value", "12.5Pa", "3E 00 00 00"),
        ("bcg450", "pirani.safe-value", "1.25e-1mbar", "3E 00 00 00"),
        ("bcg450", "pirani.data-units", "Torr", "05 15"),
        ("bcg450", "pirani.data-units", "1308", "05 1C"),
        ("pcg550", "pirani.data-unit", "0x1308", "13 08"),
        ("bcg450", "ba.hot-cathode-block-state-command", "degas-on", "01 01"),
        ("bcg450", "ba.hot-cathode-block-state-command", "01 00", "01 00"),
        ("pcg550", "trip-point.1/low-trip-enable", "on", "01"),
        ("img400", "channel.1/emission-current", "45-mA", "40 A0 00 00"),
        ("bcg450", "ba.emission-current", "5 mA", "40 A0 00 00"),
        ("bcg450", "ba.emission-current", "5", "40 A0 00 00"),
        ("img400", "reset-error-condition", "reset-all", "80"),
    ] {
        assert_eq!(parsed(device, target, text), octets, "{device} {target} {text}");
    }
}

#[test]
fn a_text_that_is_no_value_is_an_error_with_the_accepted_ones() {
    for (device, target, text, sentence) in [
        ("bcg450", "pirani.safe-state", "never", "one of zero, full-scale, hold-last-value, use-safe-value"),
        ("bcg450", "pirani.safe-state", "4", "one of zero, full-scale, hold-last-value, use-safe-value"),
        ("bcg450", "pirani.safe-value", "-1 mbar", PRESSURE),
        ("bcg450", "pirani.safe-value", "-1", PRESSURE),
        ("bcg450", "pirani.safe-value", "nan mbar", PRESSURE),
        ("bcg450", "pirani.safe-value", "inf mbar", PRESSURE),
        ("bcg450", "pirani.safe-value", "much", PRESSURE),
        ("bcg450", "setpoint-a.percentage-of-atmosphere", "140.1 %", "a percentage from 1 % to 140 %, such as '50 %'"),
        ("bcg450", "ba.emission-current", "25 mA", "a number from 0 mA to 20 mA"),
        ("bcg450", "ba.emission-current", "5 A", "a number from 0 mA to 20 mA"),
        ("bcg450", "pirani.data-units", "psi", "one of COUNTS, Torr, Micron, mbar, Pascal"),
        ("pcg550", "trip-point.1/low-trip-enable", "2", "true or false"),
        (
            "bcg450",
            "device.device-block-state-command",
            "256",
            "one of inactive, reset, abort, recover, execute, stop, perform-diagnostic",
        ),
        ("bcg450", "device.device-configuration", &"x".repeat(51), "up to 50 ASCII characters"),
    ] {
        let said = parsed(device, target, text);
        assert_eq!(said, format!("expected {sentence}, got {text:?}"));
    }
}

const PRESSURE: &str = "a pressure of 0 or more with its unit, such as '1500 mbar'";

#[test]
fn a_pressure_without_a_unit_is_an_error_that_shows_the_unit_of_the_gauge() {
    let sentence = |device, unit, target, text| {
        with(device, target, unit, |format| format.parse(text, NumberType::Float).unwrap_err().to_string())
    };
    assert_eq!(
        sentence("bcg450", "mbar", "pirani.safe-value", "0.5"),
        format!("expected {PRESSURE}, got \"0.5\" without a unit; in the present unit of the gauge it is '0.5 mbar'")
    );
    let torr = sentence("pcg550", "Torr", "trip-point.1/high-trip-point", "1e-3");
    assert!(
        torr.ends_with("got \"1e-3\" without a unit; in the present unit of the gauge it is '1e-3 Torr'"),
        "{torr}"
    );
    assert_eq!(
        sentence("bcg450", "mbar", "pirani.safe-value", "0.2 bananas"),
        format!(
            "expected {PRESSURE}, got \"0.2 bananas\"; the units of the gauge are COUNTS, Torr, Micron, mbar, Pascal"
        )
    );
    let unknown = sentence("tpg300", "none of them", "relay.1/upper-threshold", "1");
    assert!(unknown.ends_with("such as '1 mbar', got \"1\" without a unit"), "{unknown}");
}

fn beyond(device: &str, unit: &str, target: &str, text: &str) -> Option<String> {
    with(device, target, unit, |format| {
        let octets = format.parse(text, NumberType::Float).unwrap();
        let value = Value::decode(DataType::ByType, &octets).unwrap();
        format.beyond_range(&value).map(|error| error.to_string())
    })
}

#[test]
fn a_pressure_outside_the_measuring_range_is_reported_with_the_range_in_the_unit_of_the_gauge() {
    for (device, unit, target, text, sentence) in [
        (
            "bcg450",
            "mbar",
            "pirani.safe-value",
            "1e9 mbar",
            Some("1e9 mbar is outside the measuring range, which is 5e-10 mbar to 1500 mbar"),
        ),
        (
            "bcg450",
            "Pascal",
            "pirani.safe-value",
            "1e9 mbar",
            Some("1e11 Pascal is outside the measuring range, which is 5e-8 Pascal to 1.5e5 Pascal"),
        ),
        (
            "bcg450",
            "mbar",
            "pirani.safe-value",
            "1e-13 mbar",
            Some("1e-13 mbar is outside the measuring range, which is 5e-10 mbar to 1500 mbar"),
        ),
        // tira41d1 3.2.5.1: the end of the range means "never", and Zero is a Safe Value.
        ("bcg450", "mbar", "pirani.safe-value", "1500 mbar", None),
        ("bcg450", "Torr", "pirani.safe-value", "1500 mbar", None),
        ("bcg450", "mbar", "pirani.safe-value", "0 mbar", None),
        ("bcg450", "counts", "pirani.safe-value", "1500 mbar", None),
        // One range for all parts of a combined gauge.
        ("bcg450", "mbar", "pirani.safe-value", "1e-8 mbar", None),
        ("pcg550", "mbar", "trip-point.1/high-trip-point", "1500 mbar", None),
        (
            "pcg550",
            "mbar",
            "trip-point.2/low-trip-point",
            "1501 mbar",
            Some("1501 mbar is outside the measuring range, which is 5e-5 mbar to 1500 mbar"),
        ),
        // A difference may be smaller than every pressure.
        ("pcg550", "mbar", "trip-point.1/low-trip-point-hysteresis", "1e-9 mbar", None),
        (
            "pcg550",
            "mbar",
            "trip-point.1/low-trip-point-hysteresis",
            "2000 mbar",
            Some("2000 mbar is outside the measuring range, which is 0 mbar to 1500 mbar"),
        ),
        (
            // The device reports the range of the connected gauge.
            "img400",
            "hPa",
            "channel.3/safe-value",
            "1e-5 hPa",
            None,
        ),
        // The tables of a controller have no range of the gauges that may be connected.
        ("tpg300", "mbar", "relay.1/upper-threshold", "1e9 mbar", None),
    ] {
        assert_eq!(beyond(device, unit, target, text).as_deref(), sentence, "{device} {target} {text}");
    }
}

/// COUNTS of a difference depend on the trip point: a number from the scale of pressures would be false.
#[test]
fn a_hysteresis_is_not_converted_to_counts() {
    let parse = |text| {
        with("pcg550", "trip-point.1/low-trip-point-hysteresis", "counts", |format| {
            format.parse(text, NumberType::Integer).map_err(|error| error.problem)
        })
    };
    assert_eq!(parse("1 mbar"), Err(ValueProblem::NotConvertible { unit: Some("COUNTS") }));
    assert_eq!(parse("100 counts").unwrap(), [0, 100]);
}

#[test]
fn counts_are_converted_on_the_scale_of_the_part() {
    let octets = |device, target, text| {
        with(device, target, "counts", |meaning| meaning.parse(text, NumberType::Integer).map(|octets| hex(&octets)))
    };
    // 10^(COUNTS/2000 - 12.5) mbar
    assert_eq!(octets("bcg450", "pirani.safe-value", "1 mbar").unwrap(), "61 A8");
    assert_eq!(octets("bcg450", "pirani.safe-value", "25000 counts").unwrap(), "61 A8");
    assert!(octets("bcg450", "pirani.safe-value", "25000.5 counts").is_err());
    assert!(octets("bcg450", "pirani.safe-value", "65536 counts").is_err());
}

#[test]
fn every_formatted_name_is_parsed() {
    for model in profivac_devices::catalog::MODELS {
        let names = ParameterNames::of(model);
        for named in names.all() {
            let meaning = ValueFormat { named, model, unit: model.unit_named("mbar") };
            for code in named.parameter.row.codes.codes() {
                let octets = meaning.parse(code.name, NumberType::Float).unwrap();
                let value = Value::of_row(named.parameter.row, &octets).unwrap();
                assert_eq!(meaning.format(&value), code.name, "{named}");
            }
        }
    }
}

/// errata-bpg-bcg-tpg 70, errata-pxg55x-img400 16.
#[test]
fn the_highest_integer_is_shown_as_this_or_more_and_not_taken_as_a_value() {
    let text = |device, target, octets: &[u8]| {
        with(device, target, "Pascal", |format| format.text(octets, &Value::of_row(format.row(), octets).unwrap()))
    };
    assert_eq!(text("bcg450", "pirani.full-scale", &[0x7F, 0xFF]), "32767 Pascal or more");
    assert_eq!(text("bcg450", "pirani.full-scale", &[0x7F, 0xFE]), "32766 Pascal");
    assert_eq!(text("bcg450", "pirani.full-scale", &32767_f32.to_be_bytes()), "32767 Pascal");
    assert_eq!(text("bcg450", "pirani.data-units", &[0x7F, 0xFF]), "32767");
    let threshold = "relay.1/low-trip-point";
    assert_eq!(text("img400", threshold, &[0xFF, 0xFF]), "65535 Pascal or more");
    assert_eq!(text("img400", threshold, &[0x7F, 0xFF]), "32767 Pascal");
    let refused = with("bcg450", "pirani.safe-value", "Pascal", |format| {
        format.parse("32767 Pascal or more", NumberType::Integer).unwrap_err().to_string()
    });
    assert!(refused.ends_with(", which is the end of the integers and no value: write a pressure"), "{refused}");
}

/// The limit, the example and the next step belong to the integers of the device.
#[test]
fn a_pressure_that_an_integer_cannot_hold_is_refused_with_its_limits() {
    for (device, target, unit, example) in [
        ("bcg450", "pirani.safe-value", "Pascal", "0 to 32767 in whole numbers with its unit, such as '32766 Pascal'"),
        ("bcg450", "pirani.safe-value", "mbar", "0 to 32767 in whole numbers with its unit, such as '1500 mbar'"),
        ("bcg450", "pirani.safe-value", "Micron", "0 to 32767 in whole numbers with its unit, such as '32766 Micron'"),
        ("img400", "relay.1/low-trip-point", "Pascal", "0 to 65535 in whole numbers with its unit, such as '1 Pascal'"),
    ] {
        with(device, target, unit, |format| {
            let error = format.parse(&format!("70000 {unit}"), NumberType::Integer).unwrap_err().to_string();
            let expected = format!("expected a pressure of {example} (for other pressures choose the data type float)");
            assert!(error.starts_with(&expected), "{error}");
            let (_, rest) = error.split_once('\'').unwrap();
            let (shown, _) = rest.split_once('\'').unwrap();
            format.parse(shown, NumberType::Integer).unwrap();
        });
    }
}

/// A device that keeps a text reads it as blanks before the first write: a dump of it can be compared and restored.
#[test]
fn an_empty_text_is_blanks() {
    assert_eq!(parsed("bcg450", "device.device-configuration", ""), hex(&[b' '; 50]));
}
