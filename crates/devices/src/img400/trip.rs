//! A trip point: the relay closes below a pressure and opens above another. BG 5530 4.4.3, errata-pxg55x-img400 137 to
//! 144.

use super::parts;
use crate::model::{AccessError, PressureFormat, mbar};
use crate::profile::switched;

/// A relay and its trip point.
#[derive(Clone, Debug)]
pub(super) struct TripRelay {
    low_pa: f64,
    upper_pa: f64,
    /// Low Trip Enable.
    pub enabled: bool,
    /// The channel that is compared, from 1.
    channel: u8,
    closed: bool,
}

impl TripRelay {
    // chosen: the manual gives no defaults
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

    /// Hysteresis, in Pa (138).
    pub const fn hysteresis_pa(&self) -> f64 {
        self.upper_pa - self.low_pa
    }

    /// The format of Hysteresis on the wire: in COUNTS it is a distance from the trip point (32).
    pub const fn hysteresis_format(&self, format: PressureFormat) -> PressureFormat {
        PressureFormat { counts: parts::hysteresis_counts(self.low_pa), ..format }
    }

    /// Sets Low Trip Point. The number of Hysteresis stays, and the upper threshold moves with the trip point (140).
    pub fn set_low(&mut self, pa: f64, format: PressureFormat) -> Result<(), AccessError> {
        let number = self.hysteresis_format(format).number_from_pa(self.hysteresis_pa());
        let moved = Self { low_pa: pa, ..self.clone() };
        let hysteresis_pa = moved.hysteresis_format(format).pa_from_number(number).ok_or(AccessError::OutOfRange)?;
        *self = Self { upper_pa: pa + hysteresis_pa, ..moved };
        Ok(())
    }

    /// Sets Hysteresis; the upper threshold follows (4.4.3, ID 201).
    pub const fn set_hysteresis(&mut self, pa: f64) {
        self.upper_pa = self.low_pa + pa;
    }

    /// Sets Low Trip Upper Threshold, which is not below the trip point (141).
    pub fn set_upper(&mut self, pa: f64) -> Result<(), AccessError> {
        if pa < self.low_pa {
            return Err(AccessError::OutOfRange);
        }
        self.upper_pa = pa;
        Ok(())
    }

    /// Restores the switching points as they were stored; neither moves the other.
    pub fn restore(&mut self, low_pa: Option<f64>, upper_pa: Option<f64>) {
        self.low_pa = low_pa.unwrap_or(self.low_pa);
        // A power cut between the two must not leave them crossed.
        self.upper_pa = upper_pa.unwrap_or(self.upper_pa).max(self.low_pa);
    }

    /// Sets the channel, 1 to 4 (144).
    pub fn set_channel(&mut self, channel: u8) -> Result<(), AccessError> {
        self.channel = Some(channel).filter(|channel| (1..=4).contains(channel)).ok_or(AccessError::OutOfRange)?;
        Ok(())
    }

    /// Compares a reading in Pa: closes below the trip point, opens above the upper threshold (137), and opens without
    /// a reading (144).
    pub fn update(&mut self, reading: Option<f64>) {
        self.closed = switched(reading.filter(|_| self.enabled), self.low_pa, self.upper_pa, self.closed);
    }
}
