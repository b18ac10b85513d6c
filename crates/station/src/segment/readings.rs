//! The readings of a gauge, from the values in its inputs.

use crate::config;
use crate::view::{self, BusStationState};
use profivac_client::cyclic::{Cause, ChannelValue, CyclicSlave, CyclicValues};
use profivac_client::pressure::Pressure;
use profivac_devices::Principle;
use profivac_recorder::{Quality, validity};
use profivac_vacuum::Gas;
use std::time::Duration;

/// The gas factors of a Pirani hold from 1 to 100 Pa: BCG450 manual, page 54.
const PIRANI_PA: (f64, f64) = (1.0, 100.0);

/// The gas factors of an ion gauge hold below 0.1 Pa: BCG450 manual, page 54.
const ION_PA: f64 = 0.1;

/// An assumption on which the pressures of a gauge depend.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Assumed {
    /// The unit: a status is that of the gauge, a number is not.
    Unit,
    /// The configuration, which divides the inputs into fields: nothing in them is certain.
    Configuration,
}

impl Assumed {
    /// Whether a reading with this quality and cause may be false. In another unit a number that is no pressure may be one.
    pub const fn concerns(self, quality: Quality, cause: Option<Cause>) -> bool {
        match self {
            Self::Unit => {
                quality.has_pressure() || matches!((quality, cause), (Quality::Fault, Some(Cause::NoPressure)))
            }
            Self::Configuration => !matches!(quality, Quality::Stale),
        }
    }

    /// What the reading would be if the assumption is right.
    pub fn cause(self, reading: &view::Reading, unit: &str) -> String {
        let sign = match reading.quality {
            Quality::Overrange => "> ",
            Quality::Underrange => "< ",
            _ => "",
        };
        let value = reading.bound_pa().map(|pa| format!("{sign}{:.1e} mbar", Pressure::from_pa(pa).mbar()));
        let value = value.unwrap_or_else(|| reading.quality.label().to_owned());
        match self {
            Self::Unit => format!("{value} if the unit is {unit}"),
            Self::Configuration => format!("{value} if configuration and unit are the assumed ones"),
        }
    }
}

/// The state of a gauge that exchanges data.
pub fn state_of(values: &CyclicValues) -> BusStationState {
    if values.has_fault() { BusStationState::Fault } else { BusStationState::DataExchange }
}

/// The readings of a gauge whose last data exchange was `silence` ago.
pub fn readings_of(
    gauge: &config::Gauge,
    slave: &CyclicSlave,
    values: &CyclicValues,
    silence: Duration,
) -> Vec<view::Reading> {
    let is_only = values.values.len() == 1;
    values.values.iter().map(|value| reading(gauge, slave, value, is_only, silence)).collect()
}

/// A reading of a gauge whose last data exchange was `silence` ago. The only reading of a gauge has its name.
fn reading(
    gauge: &config::Gauge,
    slave: &CyclicSlave,
    value: &ChannelValue,
    is_only: bool,
    silence: Duration,
) -> view::Reading {
    // A TPG300 or TPG500 does not report which gauges its channels have.
    let principle = slave.principle(value.instance);
    let name = &gauge.name;
    let quality = validity::quality_after(value.quality, silence);
    let is_fresh = quality == value.quality;
    view::Reading {
        series: if is_only { name.clone() } else { format!("{name}.{}", value.instance) },
        instance: value.instance,
        principle,
        pa: value.pa.filter(|_| is_fresh),
        limit_pa: value.limit_pa.filter(|_| is_fresh),
        corrected_pa: value.pa.filter(|_| is_fresh).and_then(|pa| corrected(pa, principle?, gauge.gas)),
        quality,
        cause: value.cause.filter(|_| is_fresh).map(|cause| cause.to_string()),
        is_defect: is_fresh && value.cause.is_some_and(is_defect),
    }
}

/// Whether the device itself reports a defect, not only a number that is no pressure.
const fn is_defect(cause: Cause) -> bool {
    matches!(cause, Cause::Alarms(_) | Cause::ChannelError | Cause::GaugeError)
}

/// The pressure of a gas at which a sensor that was calibrated for nitrogen indicates `pa`, where the factors hold.
#[must_use]
pub fn corrected(pa: f64, principle: Principle, gas: Gas) -> Option<f64> {
    match principle {
        Principle::Diaphragm | Principle::Atmosphere => Some(pa),
        _ if gas == Gas::N2 => Some(pa),
        Principle::Pirani => (PIRANI_PA.0..=PIRANI_PA.1).contains(&pa).then(|| pa * gas.pirani_factor()),
        Principle::HotCathode | Principle::ColdCathode => (pa < ION_PA).then(|| pa * gas.ion_factor()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use profivac_client::cyclic::ReportedChannels;
    use profivac_devices::catalog::model_named;

    /// A TPG300 has neither alarms nor exceptions: Measurement Status 3 is a defect, and a number that is no pressure is none.
    #[test]
    fn the_status_of_a_channel_reports_a_defect_and_a_number_that_is_no_pressure_does_not() {
        let model = model_named("tpg300").unwrap();
        let (configuration, unit) = (model.default_configuration, model.unit_named("Pascal").unwrap());
        let slave = CyclicSlave { address: 7, model, configuration, unit, channels: ReportedChannels::default() };
        let channel = |pressure: f32, status: u8| [&pressure.to_be_bytes()[..], &[status]].concat();
        let channels = [channel(2.5, 0), channel(5.0, 3), channel(0.0, 5), channel(f32::NAN, 0)].concat();
        let values = slave.decode_inputs(&[vec![0; 8], channels].concat());
        let gauge = config::Gauge::plain("rack".to_owned(), 7, model);
        let shown = |silence| readings_of(&gauge, &slave, &values, silence);
        let of_each: Vec<_> = shown(Duration::ZERO).iter().map(|it| (it.quality, it.is_defect)).collect();
        let expected =
            [(Quality::Valid, false), (Quality::Fault, true), (Quality::Missing, false), (Quality::Fault, false)];
        assert_eq!(of_each, expected);
        assert!(shown(validity::MAX_SILENCE).iter().all(|it| !it.is_defect), "nothing is known of old readings");
    }

    #[test]
    fn gas_factors_are_used_only_where_they_hold() {
        assert_eq!(corrected(10.0, Principle::Pirani, Gas::Ar), Some(17.0));
        assert_eq!(corrected(1e4, Principle::Pirani, Gas::Ar), None);
        assert_eq!(corrected(1e4, Principle::Pirani, Gas::N2), Some(1e4));
        assert_eq!(corrected(1e4, Principle::Diaphragm, Gas::Ar), Some(1e4));
        assert_eq!(corrected(1.0, Principle::HotCathode, Gas::He), None);
        let helium = corrected(1e-4, Principle::HotCathode, Gas::He).unwrap();
        assert!((helium / 5.9e-4 - 1.0).abs() < 1e-12);
    }
}
