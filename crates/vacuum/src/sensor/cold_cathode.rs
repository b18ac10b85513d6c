//! Cold cathode: a discharge in a magnetic field, which ignites after a delay.

use super::imperfections::Tolerance;
use super::{Drive, GasExchange, Range};
use fastrand::Rng;

/// The exponent n of `I = k p^n`. Inverted magnetrons have n from 1.0 to 1.2 above 1e-9 Torr ("The influence of the magnetic
/// field strength upon the characteristic curve of a cold cathode ionization gauge").
const EXPONENT: f64 = 1.1;

/// The pressure of the knee in Pa, and the exponent below it: below 1e-9 Torr the slope is steeper than above (the same source).
/// chosen: 1.4. The gauge linearises with the exponent above the knee, so it reads too low below it.
const KNEE_PA: f64 = 1.33e-7;
const EXPONENT_BELOW: f64 = 1.4;

/// The largest pumping speed of an inverted magnetron, in m³/s, and the pressure in Pa at which it is half of that.
///
/// Mukugi et al., Vacuum 44 (1993) 591: at most 0.1 l/s, negligible in ultra-high vacuum. chosen: the pressure.
const MOST_PUMPED: f64 = 1e-4;
const HALF_PUMPED_PA: f64 = 1e-5;

/// The mean ignition dose: pressure times delay, in Pa s. Kendall and Drubetsky (AVS Symposium 2005, VT-TuM2): seconds at
/// 1e-6 Torr, hours or days at 1e-11 Torr, with large variations between starts. chosen: proportional to 1/p.
const IGNITION_PA_S: f64 = 2e-4;

/// A cold cathode.
#[derive(Clone, Debug)]
pub struct ColdCathode {
    range: Range,
    /// The dose since the high voltage was switched on, in Pa s.
    dose_pa_s: f64,
    /// The number of ignitions.
    ignitions: u64,
    burns: bool,
}

impl ColdCathode {
    /// General knowledge: a spread of 15 % and more between gauges, and an unsteady discharge.
    pub const TOLERANCE: Tolerance = Tolerance {
        gain: 0.15,
        zero_pa: 0.0,
        zero_pa_per_k: 0.0,
        noise: 0.02,
        floor_pa: 0.0,
        drift_pa: 0.0,
        lag_s: 0.02,
    };

    pub const fn new(range: Range) -> Self {
        Self { range, dose_pa_s: 0.0, ignitions: 0, burns: false }
    }

    /// The discharge current as `p^n`; 0 before ignition.
    pub fn signal(&mut self, pa: f64, drive: Drive, seconds: f64, seed: u64) -> f64 {
        self.burn(pa, drive, seconds, seed);
        if !self.burns {
            return 0.0;
        }
        let current = pa.powf(EXPONENT);
        let below = if pa < KNEE_PA { (pa / KNEE_PA).powf(EXPONENT_BELOW - EXPONENT) } else { 1.0 };
        current * below / (1.0 + current / self.saturation())
    }

    /// The gas that it pumps while it burns.
    pub fn gas_exchange(&self, pa: f64) -> GasExchange {
        let speed = if self.burns { MOST_PUMPED * pa / (pa + HALF_PUMPED_PA) } else { 0.0 };
        GasExchange { outgassing: 0.0, speed }
    }

    /// Ignites or extinguishes the discharge. chosen: it extinguishes two decades below the range.
    fn burn(&mut self, pa: f64, drive: Drive, seconds: f64, seed: u64) {
        if drive == Drive::Off || pa < self.range.lowest_pa / 100.0 {
            self.burns = false;
            self.dose_pa_s = 0.0;
        } else if !self.burns {
            self.dose_pa_s += pa * seconds;
            self.burns = self.dose_pa_s >= self.ignition_dose_pa_s(seed);
            self.ignitions += u64::from(self.burns);
        }
    }

    /// The dose of the next ignition in Pa s, random from half to one and a half of the mean.
    fn ignition_dose_pa_s(&self, seed: u64) -> f64 {
        IGNITION_PA_S * (0.5 + Rng::with_seed(seed.wrapping_add(self.ignitions)).f64())
    }

    /// The pressure of nitrogen for a discharge current, limited at saturation.
    pub fn nitrogen_pa(&self, signal: f64) -> f64 {
        let share = (signal / self.saturation()).clamp(0.0, 0.95);
        (share * self.saturation() / (1.0 - share)).powf(1.0 / EXPONENT)
    }

    /// The saturation current. General knowledge: near the end of the range.
    fn saturation(&self) -> f64 {
        (3.0 * self.range.highest_pa).powf(EXPONENT)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const RANGE: Range = Range { lowest_pa: 1e-7, highest_pa: 1.0 };

    /// The delay of ignition in s, in steps of a hundredth of the expected delay.
    fn delay(pa: f64, seed: u64) -> f64 {
        let mut cathode = ColdCathode::new(RANGE);
        let step = IGNITION_PA_S / pa / 100.0;
        let steps = (1..1000).find(|_| cathode.signal(pa, Drive::On, step, seed) > 0.0).unwrap();
        f64::from(steps) * step
    }

    #[test]
    fn ignition_takes_seconds_at_1e_6_mbar_and_a_thousand_times_that_at_1e_9() {
        for seed in 0..20 {
            let (short, long) = (delay(1e-4, seed), delay(1e-7, seed));
            assert!((0.9..3.2).contains(&short), "{short}");
            assert!((long / short / 1000.0 - 1.0).abs() < 0.02, "{long} against {short}");
        }
        assert_ne!(delay(1e-4, 1), delay(1e-4, 2), "chance");
    }

    #[test]
    fn the_discharge_ends_without_high_voltage_and_ignites_anew() {
        let mut cathode = ColdCathode::new(RANGE);
        assert_eq!(cathode.signal(1e-4, Drive::Off, 1e6, 1), 0.0);
        assert!(cathode.signal(1e-4, Drive::On, 10.0, 1) > 0.0);
        assert_eq!(cathode.signal(1e-4, Drive::Off, 0.0, 1), 0.0);
        assert_eq!(cathode.signal(1e-4, Drive::On, 0.1, 1), 0.0);
        assert_eq!(cathode.signal(1e-11, Drive::On, 1e9, 1), 0.0, "too little gas for a discharge");
    }

    #[test]
    fn the_current_is_a_power_of_the_pressure_and_saturates() {
        let mut cathode = ColdCathode::new(RANGE);
        let mut current = |pa| cathode.signal(pa, Drive::On, 1e6, 1);
        assert!((current(1e-3) / current(1e-4) / 10f64.powf(EXPONENT) - 1.0).abs() < 1e-3);
        assert!(current(1e4) / current(1e3) < 1.01);
    }

    #[test]
    fn below_the_knee_the_indication_is_too_low() {
        let mut cathode = ColdCathode::new(Range { lowest_pa: 1e-9, highest_pa: 1.0 });
        let mut indicated = |pa: f64| {
            let signal = cathode.signal(pa, Drive::On, 1e9, 1);
            cathode.nitrogen_pa(signal) / pa
        };
        assert!((indicated(KNEE_PA) - 1.0).abs() < 1e-9);
        assert!((indicated(0.1 * KNEE_PA) - 0.1_f64.powf(0.3 / 1.1)).abs() < 1e-3, "{}", indicated(0.1 * KNEE_PA));
    }

    #[test]
    fn nitrogen_is_indicated_correctly_within_the_range_and_limited_above() {
        let mut cathode = ColdCathode::new(RANGE);
        for pa in [1.4e-7, 1e-5, 1e-3, 0.1, 1.0] {
            let signal = cathode.signal(pa, Drive::On, 1e6, 1);
            assert!((cathode.nitrogen_pa(signal) / pa - 1.0).abs() < 1e-9, "{pa} Pa");
        }
        let signal = cathode.signal(1e5, Drive::On, 1e6, 1);
        assert!((10.0..100.0).contains(&cathode.nitrogen_pa(signal)));
        assert_eq!(cathode.nitrogen_pa(-1.0), 0.0);
    }
}
