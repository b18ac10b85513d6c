//! A sensor that plays a list of pressures, for a demonstration without vacuum.

use crate::sensor::{Measurement, Sensor, SensorStatus};

/// A step: the pressure is held for a time.
#[derive(Clone, Copy, Debug)]
pub struct Step {
    /// The duration in seconds.
    pub seconds: f64,
    /// The pressure in Pa.
    pub pa: f64,
}

/// A sensor that plays steps, again and again.
#[derive(Clone, Debug)]
pub struct Scenario {
    steps: &'static [Step],
    at: usize,
    elapsed_s: f64,
}

impl Scenario {
    /// Begins with the first step.
    #[must_use]
    pub const fn new(steps: &'static [Step]) -> Self {
        Self { steps, at: 0, elapsed_s: 0.0 }
    }

    /// Advances the time.
    pub fn advance(&mut self, seconds: f64) {
        self.elapsed_s += seconds;
        let Some(step) = self.steps.get(self.at) else { return };
        if self.elapsed_s >= step.seconds {
            self.elapsed_s = 0.0;
            self.at = self.at.wrapping_add(1);
            if self.at >= self.steps.len() {
                self.at = 0;
            }
        }
    }
}

impl Sensor for Scenario {
    fn measure(&mut self) -> Measurement {
        let pa = self.steps.get(self.at).map_or(0.0, |step| step.pa);
        Measurement { pa, status: SensorStatus::Good }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_steps_follow_each_other_and_begin_again() {
        const STEPS: &[Step] = &[Step { seconds: 1.0, pa: 100.0 }, Step { seconds: 2.0, pa: 1.0 }];
        let mut scenario = Scenario::new(STEPS);
        let played = [0.5, 0.5, 1.0, 1.0, 0.5].map(|seconds| {
            scenario.advance(seconds);
            scenario.measure().pa
        });
        assert_eq!(played, [100.0, 1.0, 1.0, 100.0, 100.0]);
    }
}
