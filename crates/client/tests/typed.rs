//! Typed parameters: every model, and the errors of a handle that does not fit.

#![allow(clippy::unwrap_used, clippy::panic, reason = "a test")]

use profivac_client::{Bus, ClientError, TypedError};
use profivac_devices::bcg450::table::{BA, PIRANI, SETPOINT_A, analog_input, set_point};
use profivac_devices::model::Pascal;
use profivac_devices::profile::DeviceState;

fn bus(devices: &[&str]) -> Bus {
    Bus::builder("virtual").open_on(profivac_virtual::open::devices(devices).unwrap()).unwrap()
}

#[test]
fn a_typed_pressure_has_the_same_value_in_every_unit_of_the_device() {
    for unit in ["mbar", "torr", "pascal", "counts"] {
        let mut bus = bus(&[&format!("bcg450@5:unit={unit}")]);
        let mut gauge = bus.gauge(5).unwrap();
        gauge.write_typed(&BA, analog_input::SafeValue, Pascal(0.5)).unwrap();
        let Pascal(pa) = gauge.read_typed(&BA, analog_input::SafeValue).unwrap();
        assert!((pa / 0.5 - 1.0).abs() < 1e-6, "{pa} Pa in {unit}");
    }
}

#[test]
fn a_pressure_in_counts_without_a_scale_is_an_error_and_no_wrong_pressure() {
    let read = |unit: &str| {
        let mut bus = bus(&[&format!("bcg450@5:unit={unit}")]);
        bus.gauge(5).unwrap().read_typed(&SETPOINT_A, set_point::ProcessValue)
    };
    assert!(read("mbar").is_ok());
    let error = read("counts").unwrap_err();
    assert!(matches!(error, ClientError::Typed { error: TypedError::NoUnit, .. }), "{error}");
}

#[test]
fn a_handle_of_another_model_works_where_the_row_is_the_same_and_is_an_error_elsewhere() {
    let mut bus = bus(&["psg550@7", "bcg450@5"]);
    assert_eq!(bus.gauge(7).unwrap().device_state().unwrap(), DeviceState::Idle);
    let error = bus.gauge(7).unwrap().read_typed(&PIRANI, analog_input::SafeValue);
    match error {
        Ok(_) => {}
        Err(ClientError::Typed { error: TypedError::NotOnModel { location, .. }, .. }) => {
            assert_eq!(location, "Pirani")
        }
        Err(other) => panic!("{other}"),
    }
    let missing = bus.gauge(5).unwrap().read_typed(
        &profivac_devices::img400::table::RELAY_7,
        profivac_devices::bcg450::table::device_block::DeviceState,
    );
    assert!(matches!(missing, Err(ClientError::Typed { error: TypedError::NotOnModel { .. }, .. })), "{missing:?}");
}
