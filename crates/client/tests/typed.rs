//! Typed parameters: every model, and the errors of a handle that does not fit.

#![allow(clippy::unwrap_used, clippy::panic, reason = "a test")]

use profivac_client::{Bus, ClientError, TypedError};
use profivac_devices::bcg450::table::{BA, PIRANI, analog_input};
use profivac_devices::model::Pascal;
use profivac_devices::profile::DeviceState;
use profivac_devices::pxg55x::table::{TRIP_POINT_1, trip_point};

fn bus(devices: &[&str]) -> Bus {
    Bus::on(profivac_virtual::open::devices(devices).unwrap()).open().unwrap()
}

#[test]
fn a_typed_pressure_has_the_same_value_in_every_unit_of_the_device() {
    for unit in ["mbar", "torr", "pascal", "counts"] {
        let mut bus = bus(&[&format!("bcg450@5:unit={unit}")]);
        let mut gauge = bus.gauge(5).unwrap();
        gauge.set(&BA, analog_input::SafeValue, Pascal(0.5)).unwrap();
        let Pascal(pa) = gauge.get(&BA, analog_input::SafeValue).unwrap();
        assert!((pa / 0.5 - 1.0).abs() < 1e-6, "{pa} Pa in {unit}");
    }
}

#[test]
fn a_pressure_in_counts_without_a_scale_is_an_error_and_no_wrong_pressure() {
    let read = |unit: &str| {
        let mut bus = bus(&[&format!("pcg550@5:unit={unit}")]);
        bus.gauge(5).unwrap().get(&TRIP_POINT_1, trip_point::LowTripPointHysteresis)
    };
    assert!(read("mbar").is_ok());
    let error = read("counts").unwrap_err();
    assert!(matches!(error, ClientError::Typed { error: TypedError::NoUnit, .. }), "{error}");
}

#[test]
fn a_handle_of_another_model_works_where_the_row_is_the_same_and_is_an_error_elsewhere() {
    let mut bus = bus(&["psg550@7", "bcg450@5"]);
    assert_eq!(bus.gauge(7).unwrap().device_state().unwrap(), DeviceState::Idle);
    // The Pirani of both is instance 1 of slot 1, and their manuals print the same row for Safe Value.
    bus.gauge(7).unwrap().write("pirani.safe-value", "2 mbar").unwrap();
    let Pascal(pa) = bus.gauge(7).unwrap().get(&PIRANI, analog_input::SafeValue).unwrap();
    assert!((pa / 200.0 - 1.0).abs() < 1e-6, "{pa}");
    // Process Value has another name there, so the handle does not fit.
    let other = bus.gauge(7).unwrap().get(&PIRANI, analog_input::ProcessValue);
    assert!(
        matches!(other, Err(ClientError::Typed { error: TypedError::NotOnModel { location: "Pirani", .. }, .. })),
        "{other:?}"
    );
    let missing = bus
        .gauge(5)
        .unwrap()
        .get(&profivac_devices::img400::table::RELAY_7, profivac_devices::bcg450::table::device_block::DeviceState);
    assert!(matches!(missing, Err(ClientError::Typed { error: TypedError::NotOnModel { .. }, .. })), "{missing:?}");
}

/// Number type 3 is Integer16: tira41d1 3.2.2.3.
#[test]
fn a_small_pressure_is_refused_where_the_gauge_would_hold_0_by_write_and_by_set() {
    let mut bus = bus(&["bcg450@5:unit=mbar"]);
    let mut gauge = bus.gauge(5).unwrap();
    // 1e-46 is 0 as a 32-bit float.
    for number in ["1e-46 mbar", "5e-7 mbar"] {
        let written = gauge.write("pirani.safe-value", number);
        assert!(matches!(written, Err(ClientError::Value { .. } | ClientError::BeyondRange { .. })), "{written:?}");
        gauge.write("pirani.data-type", "integer").ok();
        let error = gauge.write("pirani.safe-value", number).unwrap_err();
        assert!(matches!(error, ClientError::Value { .. }), "{error}");
        assert!(error.to_string().contains("so small that the gauge would hold 0"), "{error}");
    }
    for pa in [5e-5, 1e-44, 150.0] {
        let set = gauge.set(&PIRANI, analog_input::SafeValue, Pascal(pa));
        assert!(matches!(set, Err(ClientError::Value { .. })), "{pa}: {set:?}");
    }
    for pa in [0.0, 100.0] {
        gauge.set(&PIRANI, analog_input::SafeValue, Pascal(pa)).unwrap();
        assert_eq!(gauge.get(&PIRANI, analog_input::SafeValue).unwrap(), Pascal(pa));
    }
}

/// errata-bpg-bcg-tpg 70: an end of the integers stands for every pressure beyond it.
#[test]
fn an_end_of_the_integers_is_an_error_and_no_pressure() {
    let mut bus = bus(&["bcg450@5:unit=pascal"]);
    let mut gauge = bus.gauge(5).unwrap();
    gauge.set(&BA, analog_input::SafeValue, Pascal(0.0)).unwrap();
    gauge.write("ba.data-type", "integer").unwrap();
    // 1000 mbar are 100000 Pascal.
    let error = gauge.get(&PIRANI, analog_input::FullScale).unwrap_err();
    assert!(matches!(error, ClientError::Typed { error: TypedError::HighestInteger { .. }, .. }), "{error}");
    assert_eq!(gauge.read("pirani.full-scale").unwrap().text, "32767 Pascal or more");
    // In IDLE the gauge shows its Safe Value.
    assert_eq!(gauge.get(&BA, analog_input::SafeValue).unwrap(), Pascal(0.0));
    let error = gauge.get(&BA, analog_input::ProcessValue).unwrap_err();
    assert!(matches!(error, ClientError::Typed { error: TypedError::BelowOneUnit, .. }), "{error}");
}
