//! A relay with a potentiometer. tira41d1 3.2.5, errata-bpg-bcg-tpg 106 to 109.

use super::analog_input::InputRow;
use super::presentation::Presentation;
use crate::model::{Value, log, mbar};

/// The scale of the potentiometer of a relay: p = 10^(`per_volt` x U + `at_0_v`) mbar.
#[derive(Debug, PartialEq)]
pub struct PotentiometerScale {
    /// The decades of one volt.
    pub per_volt: f64,
    /// The logarithm of the pressure in mbar at 0 V.
    pub at_0_v: f64,
    /// Above this pressure in Pa the relay stays open, whatever the threshold.
    pub highest_pa: f64,
}

/// The highest voltage of a potentiometer.
const HIGHEST_V: f64 = 10.0;

/// The hysteresis: 10 % of the threshold (108).
pub const HYSTERESIS: f64 = 0.1;

/// Potentiometer and contacts.
#[derive(Clone, Debug)]
pub struct RelaySetPoint {
    scale: &'static PotentiometerScale,
    volts: f64,
    closed: bool,
}

impl RelaySetPoint {
    /// A set point whose potentiometer is at 0 V.
    ///
    /// chosen: the manuals do not give a setting; at 0 V the relay hardly ever closes.
    #[must_use]
    pub const fn new(scale: &'static PotentiometerScale) -> Self {
        Self { scale, volts: 0.0, closed: false }
    }

    /// The same after power-up: the potentiometer keeps its setting.
    #[must_use]
    pub const fn restarted(&self) -> Self {
        Self { volts: self.volts, ..Self::new(self.scale) }
    }

    /// Turns the potentiometer; a voltage beyond its end counts as its end.
    pub const fn turn(&mut self, volts: f64) {
        self.volts = volts.clamp(0.0, HIGHEST_V);
    }

    /// The setting of the potentiometer, in Pa.
    #[must_use]
    pub fn threshold_pa(&self) -> f64 {
        mbar(log::exp10(self.scale.per_volt * self.volts + self.scale.at_0_v))
    }

    /// Whether the contacts are closed.
    #[must_use]
    pub const fn is_closed(&self) -> bool {
        self.closed
    }

    /// Status: a closed relay sets both low exceptions (106).
    #[must_use]
    pub const fn status(&self) -> u8 {
        if self.closed { 0x0A } else { 0 }
    }

    /// The value of the row with this index; empty for a row that set points do not have.
    #[must_use]
    pub fn row(&self, index: u8, presentation: &Presentation) -> Value {
        let Some(row) = InputRow::from_index(index) else { return Value::NONE };
        match row {
            InputRow::ProcessValue => Value::Pressure(self.threshold_pa()),
            InputRow::Status => self.status().into(),
            InputRow::DataType => presentation.number.code().into(),
            InputRow::DataUnits => presentation.unit.code.into(),
            // In every state: errata-bpg-bcg-tpg 56.
            InputRow::ReadingValid => true.into(),
            InputRow::FullScale
            | InputRow::SafeState
            | InputRow::SafeValue
            | InputRow::Overrange
            | InputRow::Underrange => Value::NONE,
        }
    }

    /// Opens the contacts.
    pub const fn open(&mut self) {
        self.closed = false;
    }

    /// Closes below the threshold and opens 10 % above it; opens at once if it is not `allowed` to be closed.
    pub fn follow(&mut self, allowed: bool, pa: f64) {
        let threshold_pa = self.threshold_pa().min(self.scale.highest_pa);
        self.switch(allowed, pa < threshold_pa, pa <= threshold_pa * (1.0 + HYSTERESIS));
    }

    /// Closes the contacts if `closes`, keeps closed ones closed if `stays`; opens them if not `allowed`.
    pub const fn switch(&mut self, allowed: bool, closes: bool, stays: bool) {
        self.closed = allowed && (closes || self.closed && stays);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// HPG400-SP, errata-bpg-bcg-tpg 107 and 109.
    static HPG: PotentiometerScale = PotentiometerScale { per_volt: 0.9, at_0_v: -6.0, highest_pa: mbar(100.0) };

    #[test]
    fn a_relay_stays_open_above_the_highest_pressure() {
        let mut point = RelaySetPoint::new(&HPG);
        point.turn(10.0);
        assert!((point.threshold_pa() / mbar(1000.0) - 1.0).abs() < 1e-9, "the threshold is that of the potentiometer");
        for (pressure, closed) in [(500.0, false), (99.0, true), (109.0, true), (111.0, false)] {
            point.follow(true, mbar(pressure));
            assert_eq!(point.is_closed(), closed, "{pressure} mbar");
        }
    }

    #[test]
    fn a_relay_that_is_not_allowed_to_close_opens_at_once() {
        let mut point = RelaySetPoint::new(&HPG);
        point.turn(5.0);
        point.follow(true, mbar(1e-6));
        assert_eq!(point.status(), 0x0A);
        point.follow(false, mbar(1e-6));
        assert_eq!(point.status(), 0);
    }
}
