//! Imperfections of real sensors: errors of zero and gain, drift, noise, lag.
//!
//! The errors of a sensor are drawn once from its seed. Noise and drift are functions of seed and time only, so a run gives
//! the same result in steps of a bus cycle and of an hour.

use super::REFERENCE_K;
use fastrand::Rng;
use std::f64::consts::TAU;

/// The rate at which noise changes, in 1/s.
const NOISE_RATE: f64 = 100.0;

/// The periods of slow drift, in s. chosen: about an hour, a shift and a day, without a common multiple.
const DRIFT_PERIODS_S: [f64; 3] = [3_900.0, 27_000.0, 97_000.0];

/// The spread of the imperfections of one kind of sensor: standard deviations unless stated otherwise.
#[derive(Clone, Copy, Debug)]
pub struct Tolerance {
    /// Error of the gain, relative.
    pub gain: f64,
    /// Error of the zero, in Pa.
    pub zero_pa: f64,
    /// Temperature coefficient of the zero, in Pa/K.
    pub zero_pa_per_k: f64,
    /// Noise of the signal, relative to it.
    pub noise: f64,
    /// Noise without a signal, in Pa.
    pub floor_pa: f64,
    /// Drift of the zero over days, in Pa.
    pub drift_pa: f64,
    /// Time constant, in s.
    pub lag_s: f64,
}

/// The imperfections of one sensor. They apply to the signal, in Pa of nitrogen where the sensor is linear.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Imperfections {
    /// The seed of noise and drift.
    pub seed: u64,
    /// Factor of the signal.
    pub gain: f64,
    /// Offset, in Pa.
    pub zero_pa: f64,
    /// Offset per K above 23 °C, in Pa/K.
    pub zero_pa_per_k: f64,
    /// Standard deviation of the noise, relative to the signal.
    pub noise: f64,
    /// Standard deviation of the noise without a signal, in Pa.
    pub floor_pa: f64,
    /// Drift of the zero over hours and days, in Pa.
    pub drift_pa: f64,
    /// Time constant of the signal, in s.
    pub lag_s: f64,
}

impl Imperfections {
    /// Draws the imperfections of a sensor with this tolerance.
    pub(super) fn new(tolerance: &Tolerance, seed: u64) -> Self {
        let mut rng = Rng::with_seed(seed);
        Self {
            seed,
            gain: 1.0 + tolerance.gain * normal(&mut rng),
            zero_pa: tolerance.zero_pa * normal(&mut rng),
            zero_pa_per_k: tolerance.zero_pa_per_k * normal(&mut rng),
            noise: tolerance.noise,
            floor_pa: tolerance.floor_pa,
            drift_pa: tolerance.drift_pa,
            lag_s: tolerance.lag_s,
        }
    }

    /// Applies the imperfections to a signal, at a time in s since the first step and a temperature in K.
    pub(super) fn apply(&self, signal: f64, time_s: f64, temperature_k: f64) -> f64 {
        let mut rng = Rng::with_seed(self.seed ^ moment(time_s));
        let [relative, floor] = [normal(&mut rng), normal(&mut rng)];
        let zero_pa = self.zero_pa + self.zero_pa_per_k * (temperature_k - REFERENCE_K) + self.drift(time_s);
        signal * self.gain * (1.0 + self.noise * relative) + zero_pa + self.floor_pa * floor
    }

    /// The drift of the zero in Pa: slow waves with phases from the seed, 0 at time 0.
    fn drift(&self, time_s: f64) -> f64 {
        if self.drift_pa == 0.0 {
            return 0.0;
        }
        let mut rng = Rng::with_seed(!self.seed);
        let wave = |period_s: f64| {
            let phase = rng.f64();
            (TAU * (time_s / period_s + phase)).sin() - (TAU * phase).sin()
        };
        DRIFT_PERIODS_S.map(wave).into_iter().sum::<f64>() * self.drift_pa
    }
}

/// The number of the interval of constant noise. The small offset corrects the rounding of sums of hundredths.
#[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "a count, and saturating")]
fn moment(time_s: f64) -> u64 {
    ((time_s * NOISE_RATE + 1e-3) as u64).wrapping_mul(0x9E37_79B9_7F4A_7C15)
}

/// A random number of mean 0 and standard deviation 1, at most 3.5: the sum of four uniform numbers is sufficiently normal.
fn normal(rng: &mut Rng) -> f64 {
    const HALF: f64 = 32_767.5;
    let bits = rng.u64(..);
    let sum: f64 = [0, 16, 32, 48].map(|shift| ((bits >> shift & 0xFFFF) as f64 - HALF) / (2.0 * HALF)).iter().sum();
    sum * 3f64.sqrt()
}

/// A first-order lag. It begins at its first input.
#[derive(Clone, Copy, Debug, Default)]
pub struct Lag(Option<f64>);

impl Lag {
    /// Whether its last value was 0.
    pub fn is_at_zero(&self) -> bool {
        self.0 == Some(0.0)
    }

    /// Advances by `seconds` with a constant input and returns the value; exact for any step.
    pub fn follow(&mut self, input: f64, seconds: f64, lag_s: f64) -> f64 {
        let value = self.0.map_or(input, |value| input + (value - input) * (-seconds / lag_s).exp());
        // Avoids 0 / 0 without lag and without time.
        let value = if lag_s > 0.0 { value } else { input };
        self.0 = Some(value);
        value
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const QUIET: Tolerance =
        Tolerance { gain: 0.0, zero_pa: 0.0, zero_pa_per_k: 0.0, noise: 0.0, floor_pa: 0.0, drift_pa: 0.0, lag_s: 0.0 };

    #[test]
    fn noise_has_its_mean_and_its_deviation() {
        let imperfections = Imperfections::new(&Tolerance { noise: 0.02, floor_pa: 0.0, ..QUIET }, 7);
        let values: Vec<f64> =
            (0..20_000).map(|k| imperfections.apply(5.0, f64::from(k) / 100.0, REFERENCE_K)).collect();
        let mean = values.iter().sum::<f64>() / 20_000.0;
        let deviation = (values.iter().map(|value| (value - mean).powi(2)).sum::<f64>() / 20_000.0).sqrt();
        assert!((mean - 5.0).abs() < 3e-3, "{mean}");
        assert!((deviation / 0.1 - 1.0).abs() < 0.03, "{deviation}");
    }

    #[test]
    fn successive_values_of_the_noise_are_uncorrelated() {
        let imperfections = Imperfections::new(&Tolerance { floor_pa: 1.0, ..QUIET }, 7);
        let values: Vec<f64> =
            (0..20_000).map(|k| imperfections.apply(0.0, f64::from(k) / 100.0, REFERENCE_K)).collect();
        let correlation = values.windows(2).map(|pair| pair[0] * pair[1]).sum::<f64>() / 20_000.0;
        assert!(correlation.abs() < 0.03, "{correlation}");
    }

    #[test]
    fn the_zero_moves_with_temperature_and_time() {
        let mut imperfections = Imperfections::new(&QUIET, 1);
        (imperfections.zero_pa, imperfections.zero_pa_per_k) = (3.0, 0.5);
        assert_eq!(imperfections.apply(10.0, 0.0, REFERENCE_K + 4.0), 15.0);
        imperfections.drift_pa = 0.1;
        assert_eq!(imperfections.apply(10.0, 0.0, REFERENCE_K), 13.0, "no drift yet");
        let hours = [1.0, 8.0, 30.0].map(|hours| imperfections.apply(10.0, 3600.0 * hours, REFERENCE_K) - 13.0);
        assert!(hours.iter().all(|drift| drift.abs() > 1e-3 && drift.abs() < 0.6), "{hours:?}");
    }

    #[test]
    fn a_lag_reaches_63_percent_in_one_time_constant_with_any_steps() {
        for steps in [1u32, 7, 100] {
            let mut lag = Lag::default();
            assert_eq!(lag.follow(1.0, 0.0, 0.08), 1.0);
            let mut value = 1.0;
            for _ in 0..steps {
                value = lag.follow(101.0, 0.08 / f64::from(steps), 0.08);
            }
            assert!((value - (101.0 - 100.0 / std::f64::consts::E)).abs() < 1e-9, "{steps} steps: {value}");
        }
    }

    #[test]
    fn without_a_time_constant_there_is_no_lag() {
        let mut lag = Lag::default();
        lag.follow(1.0, 0.0, 0.0);
        assert_eq!(lag.follow(2.0, 0.0, 0.0), 2.0);
    }
}
