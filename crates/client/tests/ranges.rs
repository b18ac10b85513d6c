//! The settings that a device has from its factory lie in its measuring range: a file of `dump` can be restored without force.

#![allow(clippy::unwrap_used, clippy::panic, reason = "a test")]

use profivac_client::settings::{self, Difference, SettingsFile};
use profivac_client::{Bus, ClientError};
use profivac_devices::catalog::MODELS;
use profivac_devices::model::{DataType, Scale};

#[test]
fn the_factory_settings_of_every_device_are_restored_without_force() {
    for model in MODELS.into_iter().filter(|model| model.features.dpv1) {
        // One gauge in every unit: the range is converted to it.
        for unit in model.units.iter().filter(|unit| unit.scale == Scale::MBAR || model.name == "bcg450") {
            let spec = format!("{}@5:unit={}", model.name, unit.alias.to_lowercase());
            let mut bus = Bus::on(profivac_virtual::open::devices(&[&spec]).unwrap()).open().unwrap();
            let mut gauge = bus.gauge(5).unwrap();
            let file = SettingsFile::parse(&settings::dump(&mut gauge).unwrap().to_toml()).unwrap();
            let mut pressures = 0;
            for (named, setting) in file.in_order(&gauge).unwrap() {
                let difference: Option<Difference> = settings::compare(&mut gauge, &named, &setting).unwrap();
                assert!(difference.is_none(), "{spec} {named} {setting:?}");
                if named.parameter.row.data_type == DataType::ByType {
                    pressures += 1;
                    match gauge.prepare(&named, &setting.value) {
                        Ok(write) => assert_eq!(write.beyond_range, None),
                        Err(error) => panic!("{spec} {named}: {error}"),
                    }
                }
            }
            assert!(pressures > 0, "{spec}");
        }
    }
}

#[test]
fn a_typed_pressure_outside_the_measuring_range_is_refused_as_a_text_is() {
    use profivac_devices::bcg450::table::{PIRANI, analog_input};
    use profivac_devices::model::Pascal;
    let mut bus = Bus::on(profivac_virtual::open::devices(&["bcg450@5"]).unwrap()).open().unwrap();
    let mut gauge = bus.gauge(5).unwrap();
    let error = gauge.set(&PIRANI, analog_input::SafeValue, Pascal(1e11)).unwrap_err();
    assert!(matches!(error, ClientError::BeyondRange { .. }), "{error}");
    assert_eq!(gauge.get(&PIRANI, analog_input::SafeValue).unwrap(), Pascal(0.0));
}

/// Different gauges may be connected to a channel: it reports the range of the present one.
#[test]
fn a_value_for_a_channel_of_a_controller_is_compared_with_the_range_that_the_channel_reports() {
    let mut bus = Bus::on(profivac_virtual::open::devices(&["img400@7"]).unwrap()).open().unwrap();
    let mut gauge = bus.gauge(7).unwrap();
    for (target, value, range) in [
        ("channel.3/safe-value", "1e-5 hPa", "8e-4 hPa to 1000 hPa"),
        ("channel.4/safe-value", "1e9 hPa", "0.1 hPa to 1000 hPa"),
    ] {
        let refused = gauge.write(target, value).unwrap_err();
        let sentence = format!("{value} is outside the measuring range, which is {range}");
        assert!(refused.to_string().contains(&sentence), "{refused}");
    }
    assert_eq!(gauge.write("channel.3/safe-value", "1e-2 hPa").unwrap().text, "0.01 hPa");
}
