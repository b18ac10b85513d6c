//! A Pirani at an analogue input, with a calibration table.

use crate::sensor::{Measurement, Sensor, SensorStatus};
use profivac_devices::Drive;

/// An analogue input.
pub trait AnalogInput {
    /// The next conversion, in steps of the converter.
    fn convert(&mut self) -> u16;
}

/// A point of a calibration: the steps of the converter at a pressure.
#[derive(Clone, Copy, Debug)]
pub struct CalibrationPoint {
    /// The steps.
    pub steps: u16,
    /// The pressure in Pa, above 0.
    pub pa: f64,
}

/// A Pirani whose heater supply is measured. Between two points of its table the logarithm of the pressure is linear in the steps.
#[derive(Clone, Debug)]
pub struct Pirani<I> {
    input: I,
    /// The points, steps rising.
    table: &'static [CalibrationPoint],
    is_heated: bool,
}

impl<I: AnalogInput> Pirani<I> {
    /// A Pirani at this input.
    pub const fn new(input: I, table: &'static [CalibrationPoint]) -> Self {
        Self { input, table, is_heated: false }
    }

    /// The pressure; the end of the table beyond it.
    fn pressure(&self, steps: u16) -> Option<f64> {
        let above = self.table.iter().position(|point| point.steps >= steps);
        let (low, high) = match above {
            None => return self.table.last().map(|point| point.pa),
            Some(at) => (self.table.get(at.checked_sub(1).unwrap_or(at))?, self.table.get(at)?),
        };
        let span = f64::from(high.steps) - f64::from(low.steps);
        if span <= 0.0 {
            return Some(high.pa);
        }
        let part = (f64::from(steps) - f64::from(low.steps)) / span;
        Some(low.pa * libm::pow(high.pa / low.pa, part))
    }
}

/// Below this, and above the complement, the wire is broken or short. chosen
const RAIL_STEPS: u16 = 8;

/// The highest step of a converter with 12 bits.
const HIGHEST_STEP: u16 = 4095;

impl<I: AnalogInput> Sensor for Pirani<I> {
    fn drive(&mut self, drive: Drive) {
        self.is_heated = drive != Drive::Off;
    }

    fn measure(&mut self) -> Measurement {
        let steps = self.input.convert();
        let is_broken = steps < RAIL_STEPS || steps > HIGHEST_STEP.saturating_sub(RAIL_STEPS);
        let status = if is_broken && self.is_heated { SensorStatus::SensorFailed } else { SensorStatus::Good };
        match self.pressure(steps) {
            Some(pa) => Measurement { pa, status },
            None => Measurement { pa: 0.0, status: SensorStatus::ElectronicsFailed },
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const TABLE: &[CalibrationPoint] = &[
        CalibrationPoint { steps: 200, pa: 0.1 },
        CalibrationPoint { steps: 1000, pa: 10.0 },
        CalibrationPoint { steps: 3800, pa: 100_000.0 },
    ];

    struct Fixed(u16);

    impl AnalogInput for Fixed {
        fn convert(&mut self) -> u16 {
            self.0
        }
    }

    fn at(steps: u16) -> Measurement {
        let mut pirani = Pirani::new(Fixed(steps), TABLE);
        pirani.drive(Drive::On);
        pirani.measure()
    }

    #[test]
    fn between_two_points_the_pressure_is_interpolated_logarithmically() {
        for (steps, pa) in [(200, 0.1), (600, 1.0), (1000, 10.0), (2400, 1000.0), (3800, 100_000.0)] {
            let found = at(steps);
            assert!((found.pa / pa - 1.0).abs() < 1e-9 && found.status == SensorStatus::Good, "{steps}: {found:?}");
        }
    }

    #[test]
    fn beyond_its_ends_the_table_ends_and_at_the_rails_the_sensor_has_failed() {
        assert_eq!((at(100).pa, at(100).status), (0.1, SensorStatus::Good));
        assert_eq!((at(4000).pa, at(4000).status), (100_000.0, SensorStatus::Good));
        assert_eq!(at(0).status, SensorStatus::SensorFailed);
        assert_eq!(at(4095).status, SensorStatus::SensorFailed);
    }
}
