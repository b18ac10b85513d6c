//! A trip point: the relay closes below a pressure and opens above another. BG 5530 4.4.3, errata-pxg55x-img400 137 to 144.

use crate::model::{Format, Refusal, mbar};

/// A relay and its trip point.
#[derive(Clone, Debug)]
pub(super) struct Trip {
    low_pa: f64,
    upper_pa: f64,
    /// Low Trip Enable.
    pub enabled: bool,
    /// The channel that is compared, from 1.
    channel: u8,
    closed: bool,
}

impl Trip {
    // free choice: the manual gives no defaults
    pub const FACTORY: Self =
        Self { low_pa: mbar(1e-3), upper_pa: mbar(2e-3), enabled: false, channel: 1, closed: false };

    pub const fn is_closed(&self) -> bool {
        self.closed
    }

    pub const fn channel(&self) -> u8 {
        self.channel
    }

    pub const fn low_pa(&self) -> f64 {
        self.low_pa
    }

    pub const fn upper_pa(&self) -> f64 {
        self.upper_pa
    }

    /// Hysteresis as a pressure: the number between the two switching points, which is no difference of pressures in COUNTS
    /// (32, 138).
    pub fn hysteresis_pa(&self, format: &Format) -> f64 {
        format.pa_of(self.hysteresis(format)).unwrap_or_default()
    }

    fn hysteresis(&self, format: &Format) -> f64 {
        format.number_of(self.upper_pa) - format.number_of(self.low_pa)
    }

    /// Low Trip Point. Hysteresis stays, the upper threshold moves along (140).
    pub fn set_low(&mut self, pa: f64, format: &Format) -> Result<(), Refusal> {
        let moved = Self { low_pa: pa, ..self.clone() }.with_hysteresis(self.hysteresis(format), format)?;
        *self = moved;
        Ok(())
    }

    /// Hysteresis: the upper threshold follows (4.4.3, ID 201).
    pub fn set_hysteresis(&mut self, pa: f64, format: &Format) -> Result<(), Refusal> {
        *self = self.clone().with_hysteresis(format.number_of(pa), format)?;
        Ok(())
    }

    /// Rounding of the unit must not put the upper threshold below the trip point.
    fn with_hysteresis(self, number: f64, format: &Format) -> Result<Self, Refusal> {
        let upper_pa = format.pa_of(format.number_of(self.low_pa) + number).ok_or(Refusal::Range)?;
        Ok(Self { upper_pa: upper_pa.max(self.low_pa), ..self })
    }

    /// Low Trip Upper Threshold: not below the trip point (141).
    pub fn set_upper(&mut self, pa: f64) -> Result<(), Refusal> {
        if pa < self.low_pa {
            return Err(Refusal::Range);
        }
        self.upper_pa = pa;
        Ok(())
    }

    /// Power returns: both switching points as they were stored, without moving each other.
    pub fn recall(&mut self, low_pa: Option<f64>, upper_pa: Option<f64>) {
        self.low_pa = low_pa.unwrap_or(self.low_pa);
        // A power cut between the two must not leave them crossed.
        self.upper_pa = upper_pa.unwrap_or(self.upper_pa).max(self.low_pa);
    }

    /// The channel, 1 to 4 (144).
    pub fn set_channel(&mut self, channel: u8) -> Result<(), Refusal> {
        self.channel = Some(channel).filter(|channel| (1..=4).contains(channel)).ok_or(Refusal::Range)?;
        Ok(())
    }

    /// Compares a reading in Pa: closes below the trip point, opens above the upper threshold (137). No reading, no
    /// condition (144).
    pub fn follow(&mut self, reading: Option<f64>) {
        self.closed = match reading.filter(|_| self.enabled) {
            None => false,
            Some(pa) if pa < self.low_pa => true,
            Some(pa) if pa > self.upper_pa => false,
            Some(_) => self.closed,
        };
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::img400::table::{COUNTS, HIGHEST_COUNT, MODEL};
    use crate::model::NumberType;

    #[test]
    fn rounding_never_puts_the_upper_threshold_below_the_trip_point() {
        for unit in MODEL.units {
            let format = Format { unit, number: NumberType::Float, counts: COUNTS, highest: HIGHEST_COUNT };
            let mut trip = Trip::FACTORY;
            assert_eq!(trip.set_hysteresis(0.0, &format), Ok(()));
            for step in 1..1000 {
                assert_eq!(trip.set_low(libm::exp10(f64::from(step) / 90.0 - 6.0), &format), Ok(()));
                assert!(trip.upper_pa() >= trip.low_pa(), "{} {}", unit.name, trip.low_pa());
            }
        }
    }
}
