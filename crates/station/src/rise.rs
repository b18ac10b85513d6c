//! Rate of rise: after the valve to the pump is closed, the shape of the pressure rise separates a leak from outgassing.
//!
//! A leak lets in the same amount of gas every second, so its pressure is a straight line. Outgassing slows down as the pressure
//! approaches equilibrium, so its pressure bends. The fitted function is
//!
//! ```text
//! p(t) = p0 + (Q_leak / V) t + k (1 - exp(-t / tau))
//! ```
//!
//! For a given tau this is linear in the three other unknowns; tau is searched on a logarithmic scale. Where a straight line fits
//! equally well, the result has no bend.

/// The parts of a rise. Rates in Pa/s; multiplied by a volume in m³ they are flows in Pa m³/s.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Rise {
    /// The pressure at the start, in Pa.
    pub start_pa: f64,
    /// The part that does not slow down, in Pa/s: leaks, permeation.
    pub steady_pa_per_s: f64,
    /// The part that slows down, if it can be separated from the steady one.
    pub bend: Option<Bend>,
    /// The root mean square of the residuals, in Pa.
    pub residual_pa: f64,
    /// The explained part of the variation, 0 to 1.
    pub explained: f64,
}

/// The part of a rise that slows down.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Bend {
    /// The final height of the rise, in Pa.
    pub height_pa: f64,
    /// The time constant in seconds: after it the rise has reached 63 % of its height.
    pub tau_s: f64,
}

impl Bend {
    /// The rate at the start, in Pa/s.
    #[must_use]
    pub fn initial_pa_per_s(&self) -> f64 {
        self.height_pa / self.tau_s
    }
}

/// The reason why samples cannot be fitted.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum NoRise {
    /// Too few samples.
    #[error("expected at least {LEAST} samples, got {0}")]
    Few(usize),
    /// All samples have the same time.
    #[error("all samples have the same time")]
    NoTime,
}

/// The fewest samples: three unknowns, and some more to test the fit.
const LEAST: usize = 8;

/// The number of values of tau, from a twentieth of the time to three times the time.
const STEPS: i32 = 60;

/// A bend must reduce the residuals to this part: noise alone reduces them less. free choice.
const WORTH: f64 = 0.8;

/// Fits samples: seconds since the valve was closed, and pressures in Pa.
///
/// # Errors
/// [`NoRise`] when there is too little to fit.
pub fn fit(samples: &[(f64, f64)]) -> Result<Rise, NoRise> {
    if samples.len() < LEAST {
        return Err(NoRise::Few(samples.len()));
    }
    let (first, last) =
        samples.iter().fold((f64::MAX, f64::MIN), |(first, last), (t, _)| (first.min(*t), last.max(*t)));
    let time = last - first;
    if time <= 0.0 {
        return Err(NoRise::NoTime);
    }
    let samples: Vec<_> = samples.iter().map(|(t, p)| (t - first, *p)).collect();
    let straight = solve(&samples, None);
    let bent = (0..=STEPS)
        .map(|step| time * 10_f64.powf(f64::from(step) / f64::from(STEPS) * 60_f64.log10() - 20_f64.log10()))
        .filter_map(|tau| solve(&samples, Some(tau)))
        // Gas does not leak out of a chamber under vacuum, and outgassing is not negative.
        .filter(|fit| fit.bend.is_some_and(|bend| bend.height_pa > 0.0) && fit.steady_pa_per_s >= 0.0)
        .min_by(|one, two| one.residual_pa.total_cmp(&two.residual_pa));
    let straight = straight.ok_or(NoRise::NoTime)?;
    Ok(bent.filter(|bent| bent.residual_pa < WORTH * straight.residual_pa).unwrap_or(straight))
}

/// The least-squares fit for one tau, or for a straight line.
fn solve(samples: &[(f64, f64)], tau: Option<f64>) -> Option<Rise> {
    let row = |t: f64| [1.0, t, tau.map_or(0.0, |tau| -(-t / tau).exp_m1())];
    let unknowns = if tau.is_some() { 3 } else { 2 };
    let mut normal = [[0.0; 4]; 3];
    for (t, p) in samples {
        let row = row(*t);
        for (line, one) in normal.iter_mut().zip(row) {
            let values = row.into_iter().chain([*p]);
            line.iter_mut().zip(values).for_each(|(sum, other)| *sum += one * other);
        }
    }
    let [start_pa, steady_pa_per_s, height_pa] = eliminate(normal, unknowns)?;
    let mean = samples.iter().map(|(_, p)| p).sum::<f64>() / samples.len() as f64;
    let explained_at =
        |t: f64| row(t).into_iter().zip([start_pa, steady_pa_per_s, height_pa]).map(|(x, a)| x * a).sum::<f64>();
    let missed: f64 = samples.iter().map(|(t, p)| (p - explained_at(*t)).powi(2)).sum();
    let varied: f64 = samples.iter().map(|(_, p)| (p - mean).powi(2)).sum();
    Some(Rise {
        start_pa,
        steady_pa_per_s,
        bend: tau.map(|tau_s| Bend { height_pa, tau_s }),
        residual_pa: (missed / samples.len() as f64).sqrt(),
        explained: if varied > 0.0 { 1.0 - missed / varied } else { 1.0 },
    })
}

/// Solves the first `unknowns` of three equations by elimination with pivots; `None` if they are singular.
fn eliminate(mut lines: [[f64; 4]; 3], unknowns: usize) -> Option<[f64; 3]> {
    let lines = lines.get_mut(..unknowns)?;
    for column in 0..unknowns {
        let pivot =
            (column..unknowns).max_by(|one, two| lines[*one][column].abs().total_cmp(&lines[*two][column].abs()))?;
        lines.swap(column, pivot);
        let head = lines[column];
        if head[column].abs() <= f64::EPSILON * head[3].abs().max(f64::MIN_POSITIVE) {
            return None;
        }
        for (place, line) in lines.iter_mut().enumerate() {
            if place != column {
                let factor = line[column] / head[column];
                line.iter_mut().zip(head).for_each(|(value, above)| *value -= factor * above);
            }
        }
    }
    let mut solution = [0.0; 3];
    for (place, line) in lines.iter().enumerate() {
        solution[place] = line[3] / line[place];
    }
    solution.iter().all(|value| value.is_finite()).then_some(solution)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn samples(rise: impl Fn(f64) -> f64) -> Vec<(f64, f64)> {
        (0..600).map(|second| (f64::from(second), rise(f64::from(second)))).collect()
    }

    fn near(found: f64, expected: f64, percent: f64) {
        assert!((found / expected - 1.0).abs() < percent / 100.0, "{found} is not {expected}");
    }

    #[test]
    fn a_leak_is_a_straight_line() {
        let rise = fit(&samples(|t| 1e-4 + 2e-6 * t)).unwrap();
        near(rise.steady_pa_per_s, 2e-6, 0.1);
        near(rise.start_pa, 1e-4, 0.1);
        assert_eq!(rise.bend, None);
        assert!(rise.explained > 0.999);
    }

    #[test]
    fn outgassing_is_a_bend() {
        let rise = fit(&samples(|t| 1e-4 + 5e-4 * (1.0 - (-t / 90.0).exp()))).unwrap();
        let bend = rise.bend.unwrap();
        near(bend.height_pa, 5e-4, 3.0);
        near(bend.tau_s, 90.0, 5.0);
        assert!(rise.steady_pa_per_s < 0.02 * bend.initial_pa_per_s());
    }

    #[test]
    fn a_leak_and_outgassing_are_separated() {
        let rise = fit(&samples(|t| 1e-4 + 1e-6 * t + 4e-4 * (1.0 - (-t / 60.0).exp()))).unwrap();
        near(rise.steady_pa_per_s, 1e-6, 3.0);
        near(rise.bend.unwrap().height_pa, 4e-4, 3.0);
    }

    #[test]
    fn noise_is_no_bend() {
        let mut random = fastrand::Rng::with_seed(3);
        for _ in 0..20 {
            let noisy: Vec<_> = samples(|t| 1e-4 + 2e-6 * t)
                .iter()
                .map(|(t, p)| (*t, p * (1.0 + 0.02 * (random.f64() - 0.5))))
                .collect();
            let rise = fit(&noisy).unwrap();
            assert_eq!(rise.bend, None);
            near(rise.steady_pa_per_s, 2e-6, 2.0);
        }
    }

    #[test]
    fn pressures_of_every_magnitude_are_fitted() {
        for size in [1e-9, 1e-3, 1e3] {
            let rise = fit(&samples(|t| size * (1.0 + 0.01 * t + 4.0 * (1.0 - (-t / 60.0).exp())))).unwrap();
            near(rise.steady_pa_per_s, 0.01 * size, 3.0);
            near(rise.bend.unwrap().height_pa, 4.0 * size, 3.0);
        }
    }

    #[test]
    fn too_few_samples_are_no_rise() {
        assert_eq!(fit(&[(0.0, 1.0); 3]), Err(NoRise::Few(3)));
        assert_eq!(fit(&[(1.0, 1.0); 20]), Err(NoRise::NoTime));
        let flat = fit(&samples(|_| 1e-4)).unwrap();
        assert!(flat.steady_pa_per_s.abs() < 1e-12 && flat.bend.is_none());
    }
}
