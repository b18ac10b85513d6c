//! The ways in which outgassing slows down: the wall has less and less to give, or the gas returns to it.

use nalgebra::Vector4;

/// The time constants of return as a part of the length of the record: from a twentieth to ten times. A longer one is a
/// straight line, which no record distinguishes from a leak.
pub(super) const TAUS: [f64; 2] = [0.05, 10.0];

/// The number of time constants.
pub(super) const TAU_STEPS: usize = 16;

/// Exponents of outgassing that does not return: near 1 for metals in the first day, 1/2 for hydrogen (Elsey 1975; Grinham and Chew,
/// Appl. Sci. Converg. Technol. 26 (2017) 95).
const EXPONENTS: [f64; 5] = [0.5, 0.8, 0.9, 1.0, 1.1];

/// The exponents of the share beside water that returns.
pub(super) const SHARE_EXPONENTS: [f64; 2] = [0.5, 1.0];

/// A way in which outgassing slows down, with the lags of its two parts.
pub(super) struct Slowing {
    /// The time of pumping before, in s.
    pub start_s: f64,
    /// The time constant with which gas returns to the wall, in s.
    pub tau_s: Option<f64>,
    pub lags: Vec<f64>,
    /// The lags of the share that does not return.
    pub others: Option<Vec<f64>>,
}

/// The integral of the relative rate less 1 up to each time of a record, for outgassing that falls with an exponent (Simpson).
fn staying(times: &[f64], start_s: f64, exponent: f64) -> Vec<f64> {
    let less = |t: f64| (-exponent * (t / start_s).ln_1p()).exp_m1();
    let (mut sum, mut before, mut last) = (0.0, 0.0, 0.0);
    let mut integral = |t: &f64| {
        let end = less(*t);
        sum += (t - before) / 6.0 * (last + 4.0 * less(f64::midpoint(before, *t)) + end);
        (before, last) = (*t, end);
        sum
    };
    times.iter().map(&mut integral).collect()
}

/// The same for water that returns to the wall: u' = t0/c - u/tau, c' = 1 - c u / (tau t0), with the age c of the wall and the
/// pressure u divided by b (fourth order Runge-Kutta).
fn returning(times: &[f64], start_s: f64, tau_s: f64) -> Vec<f64> {
    let rate = |[u, c]: [f64; 2]| [start_s / c - u / tau_s, 1.0 - c * u / (tau_s * start_s)];
    let (mut state, mut before) = ([0.0, start_s], 0.0);
    let mut advance = |t: &f64| {
        let step = t - before;
        let at = |slope: [f64; 2], part: f64| [state[0] + slope[0] * step * part, state[1] + slope[1] * step * part];
        let first = rate(state);
        let second = rate(at(first, 0.5));
        let third = rate(at(second, 0.5));
        let fourth = rate(at(third, 1.0));
        for (index, value) in state.iter_mut().enumerate() {
            *value += step / 6.0 * (first[index] + 2.0 * second[index] + 2.0 * third[index] + fourth[index]);
        }
        before = *t;
        state[0] - t
    };
    times.iter().map(&mut advance).collect()
}

/// All ways of slowing down for a time of pumping.
pub(super) fn slowings(times: &[f64], start_s: f64) -> Vec<Slowing> {
    let length = times.last().copied().unwrap_or(0.0);
    let inverse = EXPONENTS.map(|exponent| Slowing {
        start_s,
        tau_s: None,
        lags: staying(times, start_s, exponent),
        others: None,
    });
    let taus = steps(TAUS[0] * length, TAUS[1] * length, TAU_STEPS);
    inverse.into_iter().chain(taus.flat_map(|tau_s| saturating(times, start_s, tau_s))).collect()
}

/// The ways that saturate with a time constant.
pub(super) fn saturating(times: &[f64], start_s: f64, tau_s: f64) -> [Slowing; SHARE_EXPONENTS.len()] {
    let returns = returning(times, start_s, tau_s);
    SHARE_EXPONENTS.map(|exponent| Slowing {
        start_s,
        tau_s: Some(tau_s),
        lags: returns.clone(),
        others: Some(staying(times, start_s, exponent)),
    })
}

/// Numbers from one to another in equal ratios.
pub(super) fn steps(from: f64, to: f64, count: usize) -> impl Iterator<Item = f64> {
    (0..count).map(move |step| from * (to / from).powf(step as f64 / count.saturating_sub(1).max(1) as f64))
}

impl Slowing {
    /// The row of a sample: constant, time, and the two lags.
    pub fn row(&self, index: usize, t: f64) -> Vector4<f64> {
        let lag = |lags: &Vec<f64>| lags.get(index).copied().unwrap_or(0.0);
        Vector4::new(1.0, t, lag(&self.lags), self.others.as_ref().map_or(0.0, lag))
    }
}
