//! The adjustment of the Pirani at atmospheric pressure. tira36e1 3.2.1.1 and 3.3.2.5, errata-bpg-bcg-tpg 103.

use super::Xpg400Behaviour;
use super::codes::AdjustCommand;
use super::parts::LOWEST_AIR_PA;
use crate::model::AccessError;

/// chosen: the manual does not say how long the adjustment runs.
const ADJUST_S: f64 = 10.0;

impl Xpg400Behaviour {
    /// Executes an AI Block Adjust Command. The user is responsible for the right pressure; the gauge does not check
    /// it.
    pub(super) fn adjust(&mut self, code: u8) -> Result<(), AccessError> {
        match AdjustCommand::from_code(code.into()).ok_or(AccessError::OutOfRange)? {
            AdjustCommand::Inactive => Ok(()),
            AdjustCommand::FullScaleAdjust => self.start_adjustment(),
        }
    }

    /// Full Scale State: the adjustment runs.
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

    /// chosen: a Pirani that has failed is not adjusted.
    fn is_adjustable(&self) -> bool {
        self.machine.is_executing() && !self.pirani.failed
    }

    /// Ends an adjustment that is no longer possible.
    ///
    /// chosen: the old adjustment stays.
    pub(super) fn check_adjustment(&mut self) {
        if !self.is_adjustable() {
            self.adjusting_s = 0.0;
        }
    }

    /// Advances the time of the adjustment. At its end the Pirani reads full scale, if it is in air.
    pub(super) fn advance_adjustment(&mut self, seconds: f64) {
        if !self.is_adjusting() {
            return;
        }
        self.adjusting_s -= seconds;
        if !self.is_adjusting() {
            self.adjust_pirani();
        }
    }

    /// chosen: below the lowest pressure of air the adjustment changes nothing. The device stores it and has no command to
    /// take it back, so one command in high vacuum would make the gauge unusable.
    fn adjust_pirani(&mut self) {
        let gain = self.pirani.spec.limits.full_scale_pa / self.pirani.sensor.sensed_pa;
        if self.pirani.sensor.sensed_pa >= LOWEST_AIR_PA && gain > 0.0 {
            self.pirani.sensor.gain = gain;
        }
    }
}
