//! What tells a real sensor from its formula: errors of zero and gain, drift, noise, lag.
//!
//! Which errors a sensor has is drawn from its seed once. Noise and drift are functions of seed and time and nothing else,
//! so a run is the same again whether time passes in steps of a bus cycle or of an hour.

use super::REFERENCE_K;
use fastrand::Rng;
use std::f64::consts::TAU;

/// Noise changes this often, in 1/s.
const NOISE_RATE: f64 = 100.0;

/// The periods of slow drift, in s. free choice: an hour, a shift, a day and a bit, so that they never come together.
const DRIFT_PERIODS_S: [f64; 3] = [3_900.0, 27_000.0, 97_000.0];

/// How far sensors of a kind may be off: standard deviations where nothing else is said.
#[derive(Clone, Copy, Debug)]
pub struct Tolerance {
    /// Error of the gain, relative.
    pub gain: f64,
    /// Error of the zero.
    pub zero_pa: f64,
    /// How the zero moves with the temperature.
    pub zero_pa_per_k: f64,
    /// Noise of the signal, relative to it.
    pub noise: f64,
    /// Noise that is there without a signal.
    pub floor_pa: f64,
    /// How far the zero wanders in days.
    pub drift_pa: f64,
    /// Time constant, in s.
    pub lag_s: f64,
}

/// What is wrong with one sensor. All of it concerns the signal, in Pa of nitrogen where the sensor is linear.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Imperfections {
    /// What its noise and its drift are drawn from.
    pub seed: u64,
    /// What the signal is multiplied by.
    pub gain: f64,
    /// What is added, in Pa.
    pub zero_pa: f64,
    /// What is added for each K above 23 °C, in Pa.
    pub zero_pa_per_k: f64,
    /// Standard deviation of the noise, relative to the signal.
    pub noise: f64,
    /// Standard deviation of the noise that is there without a signal, in Pa.
    pub floor_pa: f64,
    /// How far the zero wanders in hours and days, in Pa.
    pub drift_pa: f64,
    /// Time constant of the signal, in s.
    pub lag_s: f64,
}

impl Imperfections {
    /// Those of a sensor of this kind.
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

    /// The signal at a time, in s since the sensor was new, and at a temperature.
    pub(super) fn apply(&self, signal: f64, time_s: f64, temperature_k: f64) -> f64 {
        let mut rng = Rng::with_seed(self.seed ^ moment(time_s));
        let [relative, floor] = [normal(&mut rng), normal(&mut rng)];
        let zero_pa = self.zero_pa + self.zero_pa_per_k * (temperature_k - REFERENCE_K) + self.drift(time_s);
        signal * self.gain * (1.0 + self.noise * relative) + zero_pa + self.floor_pa * floor
    }

    /// How far the zero has wandered, in Pa: slow waves, each beginning where the seed says, and nothing at the beginning.
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

/// The number of a moment in which the noise is the same. A little is added: sums of hundredths fall short of whole numbers.
#[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "a count, and saturating")]
fn moment(time_s: f64) -> u64 {
    ((time_s * NOISE_RATE + 1e-3) as u64).wrapping_mul(0x9E37_79B9_7F4A_7C15)
}

/// A number of mean 0 and standard deviation 1, never beyond 3.5: the sum of four even ones is normal enough here.
fn normal(rng: &mut Rng) -> f64 {
    const HALF: f64 = 32_767.5;
    let bits = rng.u64(..);
    let sum: f64 = [0, 16, 32, 48].map(|shift| ((bits >> shift & 0xFFFF) as f64 - HALF) / (2.0 * HALF)).iter().sum();
    sum * 3f64.sqrt()
}

/// A first-order lag. A new one is where its input is.
#[derive(Clone, Copy, Debug, Default)]
pub struct Lag(Option<f64>);

impl Lag {
    /// The input has been this for so long; exact for any step.
    pub fn follow(&mut self, input: f64, seconds: f64, lag_s: f64) -> f64 {
        let value = self.0.map_or(input, |value| input + (value - input) * (-seconds / lag_s).exp());
        // Without a lag and without time nothing is divided by nothing.
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
        let flaws = Imperfections::new(&Tolerance { noise: 0.02, floor_pa: 0.0, ..QUIET }, 7);
        let values: Vec<f64> = (0..20_000).map(|k| flaws.apply(5.0, f64::from(k) / 100.0, REFERENCE_K)).collect();
        let mean = values.iter().sum::<f64>() / 20_000.0;
        let deviation = (values.iter().map(|value| (value - mean).powi(2)).sum::<f64>() / 20_000.0).sqrt();
        assert!((mean - 5.0).abs() < 3e-3, "{mean}");
        assert!((deviation / 0.1 - 1.0).abs() < 0.03, "{deviation}");
    }

    #[test]
    fn successive_values_of_the_noise_have_nothing_to_do_with_each_other() {
        let flaws = Imperfections::new(&Tolerance { floor_pa: 1.0, ..QUIET }, 7);
        let values: Vec<f64> = (0..20_000).map(|k| flaws.apply(0.0, f64::from(k) / 100.0, REFERENCE_K)).collect();
        let correlation = values.windows(2).map(|pair| pair[0] * pair[1]).sum::<f64>() / 20_000.0;
        assert!(correlation.abs() < 0.03, "{correlation}");
    }

    #[test]
    fn the_zero_moves_with_temperature_and_time() {
        let mut flaws = Imperfections::new(&QUIET, 1);
        (flaws.zero_pa, flaws.zero_pa_per_k) = (3.0, 0.5);
        assert_eq!(flaws.apply(10.0, 0.0, REFERENCE_K + 4.0), 15.0);
        flaws.drift_pa = 0.1;
        assert_eq!(flaws.apply(10.0, 0.0, REFERENCE_K), 13.0, "no drift yet");
        let hours = [1.0, 8.0, 30.0].map(|hours| flaws.apply(10.0, 3600.0 * hours, REFERENCE_K) - 13.0);
        assert!(hours.iter().all(|drift| drift.abs() > 1e-3 && drift.abs() < 0.6), "{hours:?}");
    }

    #[test]
    fn a_step_is_followed_to_63_percent_in_one_time_constant_whatever_the_steps() {
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
