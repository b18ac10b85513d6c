//! Zero and gain adjust, auto zero, run hours: the stored values without an index. tira56e1 8.1.1, 8.1.11, 8.2.1,
//! 8.3.1, 7.1.14 and 7.1.23. Numbers in brackets are those of errata-pxg55x-img400.

use super::Pxg55xBehaviour;
use super::parts::{CDG_ZERO_PA, LOWEST_AIR_PA};
use crate::model::{AccessError, Principle};
use crate::profile::{DeviceState, Sensor};

/// chosen: the manual gives no number for "periodically" (8.1.11).
const AUTO_ZERO_S: f64 = 600.0;

/// The counter counts quarters of an hour (7.1.23).
const QUARTER_S: f64 = 900.0;

/// Adjustments and run hours.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct StoredAdjustments {
    /// Quarter hours, gain and offset of the Pirani, offset of the diaphragm, gain of the atmosphere sensor. Offsets in
    /// Pa.
    pub values: [f64; 5],
    /// The rest of a quarter of an hour. Lost with the power, as on a gauge that counts in its memory.
    part_s: f64,
    /// The time since the last auto zero.
    since_auto_zero_s: f64,
}

impl StoredAdjustments {
    /// As from the factory.
    pub const fn new() -> Self {
        Self { values: [0.0, 1.0, 0.0, 0.0, 1.0], part_s: 0.0, since_auto_zero_s: 0.0 }
    }

    /// The adjustments of the factory with the present run hours.
    pub const fn readjusted(&self) -> Self {
        let [quarters, ..] = self.values;
        let [_, gain, offset, cdg, atm] = Self::new().values;
        Self { values: [quarters, gain, offset, cdg, atm], ..*self }
    }

    /// ID 212.
    #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "whole, and saturating")]
    pub const fn quarters(&self) -> u32 {
        let [quarters, ..] = self.values;
        quarters as u32
    }

    /// ID 36 saturates (76).
    pub fn hours(&self) -> u16 {
        u16::try_from(self.quarters() / 4).unwrap_or(u16::MAX)
    }

    /// Operating hours, to the second.
    pub fn run_hours(&self) -> f64 {
        (f64::from(self.quarters()) * QUARTER_S + self.part_s) / 3600.0
    }

    /// Advances the run hours. Returns whether an auto zero is due.
    fn advance(&mut self, seconds: f64) -> bool {
        let [quarters, ..] = &mut self.values;
        let whole = libm::floor((self.part_s + seconds) / QUARTER_S);
        *quarters = (*quarters + whole).min(f64::from(u32::MAX));
        self.part_s = (self.part_s + seconds - whole * QUARTER_S).max(0.0);
        self.since_auto_zero_s += seconds;
        let due = self.since_auto_zero_s >= AUTO_ZERO_S;
        if due {
            self.since_auto_zero_s = 0.0;
        }
        due
    }
}

/// The offset of a zero adjust, with which the sensor reads zero now.
fn zero(sensor: &Sensor) -> f64 {
    -sensor.sensed_pa * sensor.gain
}

/// Gain and offset with which the sensor reads `target_pa` now and its zero stays where it is.
fn gain(sensor: &Sensor, target_pa: f64) -> Result<(f64, f64), AccessError> {
    let zero_pa = -sensor.offset_pa / sensor.gain;
    let gain = target_pa / (sensor.sensed_pa - zero_pa);
    // A sensor that reads zero or less has no gain for the target.
    if gain > 0.0 && gain.is_finite() { Ok((gain, -zero_pa * gain)) } else { Err(AccessError::StateConflict) }
}

impl Pxg55xBehaviour {
    /// Executes an Analog Input Block Adjust Command; it has no target value (78). Commands without a name are accepted
    /// and have no effect (79).
    ///
    /// A zero adjust works at any pressure: the user is responsible for the right one.
    pub(super) fn adjust(&mut self, instance: u8, command: u8) -> Result<(), AccessError> {
        let principle = self.part(instance).map(|part| part.spec.part.principle);
        match (principle, command) {
            (Some(Principle::Diaphragm), 0) => self.adjustable(instance).map(|()| self.zero_cdg()),
            (Some(Principle::Pirani), 0) => self.adjustable(instance).map(|()| self.zero_pirani()),
            (Some(Principle::Pirani), 1) => self.adjustable(instance).and_then(|()| self.gain_pirani()),
            (Some(Principle::Atmosphere), 1) => self.adjustable(instance).and_then(|()| self.gain_atm()),
            _ => Ok(()),
        }
    }

    /// Checks whether a part can be adjusted.
    ///
    /// chosen: in EXECUTING and IDLE, with a sensor that reads and has not failed.
    fn adjustable(&self, instance: u8) -> Result<(), AccessError> {
        let reads = self.part(instance).is_some_and(|part| part.reading_pa.is_some() && !part.failed);
        let state = matches!(self.machine.state(), DeviceState::Executing | DeviceState::Idle);
        if reads && state { Ok(()) } else { Err(AccessError::StateConflict) }
    }

    fn zero_cdg(&mut self) {
        let Some(cdg) = &self.cdg else { return };
        let [_, _, _, offset, _] = &mut self.stored.values;
        *offset = zero(&cdg.sensor);
    }

    fn zero_pirani(&mut self) {
        let [_, _, offset, _, _] = &mut self.stored.values;
        *offset = zero(&self.pirani.sensor);
    }

    /// Adjusts the Pirani so that the present pressure is full scale (8.2.1).
    fn gain_pirani(&mut self) -> Result<(), AccessError> {
        if self.pirani.sensor.sensed_pa < LOWEST_AIR_PA {
            return Err(AccessError::StateConflict);
        }
        let full_scale_pa = self.pirani.spec.limits.full_scale_pa;
        let [_, pirani_gain, pirani_offset, _, _] = &mut self.stored.values;
        (*pirani_gain, *pirani_offset) = gain(&self.pirani.sensor, full_scale_pa)?;
        Ok(())
    }

    /// Adjusts the atmosphere sensor to the diaphragm, in a chamber that is vented: 8.3.1, (80, 164).
    fn gain_atm(&mut self) -> Result<(), AccessError> {
        let (Some(cdg), Some(atm)) = (&self.cdg, &self.atm) else { return Ok(()) };
        let pa = cdg.sensor.indicated_pa();
        if cdg.failed || !atm.measuring_range().contains(pa) {
            return Err(AccessError::StateConflict);
        }
        let [.., atm_gain] = &mut self.stored.values;
        (*atm_gain, _) = gain(&atm.sensor, pa)?;
        Ok(())
    }

    /// Copies the stored adjustments to the sensors.
    pub(super) fn apply_adjustments(&mut self) {
        let [_, pirani_gain, pirani_offset, cdg_offset, atm_gain] = self.stored.values;
        (self.pirani.sensor.gain, self.pirani.sensor.offset_pa) = (pirani_gain, pirani_offset);
        if let Some(cdg) = &mut self.cdg {
            cdg.sensor.offset_pa = cdg_offset;
        }
        if let Some(atm) = &mut self.atm {
            atm.sensor.gain = atm_gain;
        }
    }

    /// Advances the run hours, and adjusts the zero of the diaphragm while the Pirani reads a pressure below its range
    /// (91).
    pub(super) fn advance_adjustments(&mut self, seconds: f64) {
        let due = self.stored.advance(seconds);
        let below_range = self.pirani.reading_pa.is_some_and(|pa| pa <= CDG_ZERO_PA) && !self.pirani.failed;
        let able = self.machine.is_executing() && self.cdg.as_ref().is_some_and(|cdg| !cdg.failed);
        if due && self.auto_zero && below_range && able {
            self.zero_cdg();
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn run_hours_count_in_quarters_and_saturate() {
        let mut stored = StoredAdjustments::new();
        stored.advance(899.0);
        assert_eq!((stored.quarters(), stored.hours()), (0, 0));
        stored.advance(1.0);
        assert_eq!((stored.quarters(), stored.hours()), (1, 0));
        stored.advance(3.0 * 900.0 + 450.0);
        assert_eq!((stored.quarters(), stored.hours()), (4, 1));
        assert_eq!(stored.run_hours(), 1.125);
        stored.advance(3600.0 * 70_000.0);
        assert_eq!((stored.quarters(), stored.hours()), (280_004, u16::MAX));
        stored.advance(1e15);
        assert_eq!(stored.quarters(), u32::MAX);
    }

    #[test]
    fn a_gain_adjust_keeps_the_zero_of_the_sensor() {
        let mut sensor = Sensor { sensed_pa: 5.0, ..Sensor::in_air() };
        sensor.offset_pa = zero(&sensor);
        assert_eq!(sensor.indicated_pa(), 0.0);
        sensor.sensed_pa = 90_000.0;
        (sensor.gain, sensor.offset_pa) = gain(&sensor, 100_000.0).unwrap();
        assert!((sensor.indicated_pa() - 100_000.0).abs() < 1e-6);
        sensor.sensed_pa = 5.0;
        assert!(sensor.indicated_pa() < 1e-9);
    }

    #[test]
    fn a_sensor_that_reads_zero_has_no_gain_adjust() {
        let sensor = Sensor { sensed_pa: 0.0, ..Sensor::in_air() };
        assert_eq!(gain(&sensor, 100_000.0), Err(AccessError::StateConflict));
    }
}
