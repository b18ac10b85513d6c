//! The adjustment of the Pirani at atmospheric pressure. tira36e1 3.2.1.1 and 3.3.2.5, errata-bpg-bcg-tpg 103.

use super::Xpg400Behaviour;
use crate::model::{AccessError, mbar};

/// free choice: the manual does not say how long the adjustment runs.
const ADJUST_S: f64 = 10.0;

/// free choice: a Pirani that senses less is not in air, and the adjustment changes nothing. It is kept without power and has
/// no way back, so that one command in high vacuum would make full scale of the air that is not there.
const LOWEST_AIR_PA: f64 = mbar(100.0);

impl Xpg400Behaviour {
    /// AI Block Adjust Command: 1 starts the full scale adjustment. That the pressure is right is up to the user, who is not
    /// refused.
    pub(super) fn adjust(&mut self, command: u8) -> Result<(), AccessError> {
        match command {
            0 => Ok(()),
            1 => self.start_adjustment(),
            _ => Err(AccessError::OutOfRange),
        }
    }

    /// Full Scale State.
    pub(super) fn is_adjusting(&self) -> bool {
        self.adjusting_s > 0.0
    }

    fn start_adjustment(&mut self) -> Result<(), AccessError> {
        if self.is_adjusting() {
            return Err(AccessError::AlreadyInState);
        }
        if !self.is_adjustable() {
            return Err(AccessError::StateConflict);
        }
        self.adjusting_s = ADJUST_S;
        Ok(())
    }

    /// free choice: a Pirani that has failed is not adjusted.
    fn is_adjustable(&self) -> bool {
        self.machine.is_executing() && !self.pirani.failed
    }

    /// free choice: an adjustment that cannot go on leaves everything as it was.
    pub(super) fn follow_adjustment(&mut self) {
        if !self.is_adjustable() {
            self.adjusting_s = 0.0;
        }
    }

    /// Time passes, and at its end the Pirani reads full scale, if it is in air.
    pub(super) fn advance_adjustment(&mut self, seconds: f64) {
        if !self.is_adjusting() {
            return;
        }
        self.adjusting_s -= seconds;
        if !self.is_adjusting() {
            self.stretch_pirani();
        }
    }

    fn stretch_pirani(&mut self) {
        let gain = self.pirani.facts.limits.full_scale_pa / self.pirani.sensor.sensed_pa;
        if self.pirani.sensor.sensed_pa >= LOWEST_AIR_PA && gain > 0.0 {
            self.pirani.sensor.gain = gain;
        }
    }
}
