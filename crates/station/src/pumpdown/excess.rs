//! The pressure of a pump-down above the usual one: a leak, outgassing, or a virtual leak.

/// How the pressure above the usual one behaves over time.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Excess {
    /// It is constant: as with a leak.
    Constant {
        /// Its mean, in Pa.
        pa: f64,
    },
    /// It falls with a power of the time near 1: as with outgassing.
    Outgassing {
        /// The exponent.
        exponent: f64,
    },
    /// It falls exponentially: as with a virtual leak, a volume behind a small opening.
    VirtualLeak {
        /// The time constant, in s.
        tau_s: f64,
    },
}

/// The excess is fitted where it is larger than this part of the usual pressure, and in at least this number of points. chosen
const LEAST_EXCESS: f64 = 0.5;
const LEAST_POINTS: usize = 10;

/// The least range of time of the fit, and the largest residual of the logarithm. chosen
const LEAST_TIME_RATIO: f64 = 3.0;
const LARGEST_MISFIT: f64 = 0.15;

/// The shape of the pressure above the usual one, from points of seconds, pressure and usual pressure in the order of time.
/// `None` if there is too little of it, or if no shape fits.
#[must_use]
pub fn excess(points: &[(f64, f64, f64)]) -> Option<Excess> {
    let above: Vec<(f64, f64)> = points
        .iter()
        .filter(|(s, pa, usual)| *s > 0.0 && *pa > usual * (1.0 + LEAST_EXCESS))
        .map(|(s, pa, usual)| (*s, (pa - usual).ln()))
        .collect();
    let (first, last) = (above.first()?, above.last()?);
    if above.len() < LEAST_POINTS || last.0 < first.0 * LEAST_TIME_RATIO {
        return None;
    }
    let by_power = line(above.iter().map(|(s, log)| (s.ln(), *log)));
    let by_time = line(above.iter().copied());
    let (found, misfit) = if by_power.slope.abs() < 0.15 {
        (Excess::Constant { pa: by_power.mean.exp() }, by_power.misfit)
    } else if by_time.misfit < by_power.misfit && by_time.slope < 0.0 {
        (Excess::VirtualLeak { tau_s: -by_time.slope.recip() }, by_time.misfit)
    } else {
        (Excess::Outgassing { exponent: -by_power.slope }, by_power.misfit)
    };
    let is_known = !matches!(found, Excess::Outgassing { exponent } if !(0.4..=1.4).contains(&exponent));
    (misfit < LARGEST_MISFIT && is_known).then_some(found)
}

struct Line {
    slope: f64,
    mean: f64,
    /// The root of the mean square of the residuals.
    misfit: f64,
}

fn line(points: impl Iterator<Item = (f64, f64)> + Clone) -> Line {
    let count = points.clone().count().max(1) as f64;
    let (x, y) = points.clone().fold((0.0, 0.0), |(x, y), point| (x + point.0 / count, y + point.1 / count));
    let squares: f64 = points.clone().map(|point| (point.0 - x).powi(2)).sum();
    let products: f64 = points.clone().map(|point| (point.0 - x) * (point.1 - y)).sum();
    let slope = if squares > 0.0 { products / squares } else { 0.0 };
    let missed: f64 = points.map(|point| (point.1 - y - slope * (point.0 - x)).powi(2)).sum();
    Line { slope, mean: y, misfit: (missed / count).sqrt() }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_excess_of_a_leak_of_wet_walls_and_of_a_virtual_leak_differ() {
        let times: Vec<f64> = (0..60).map(|step| 100.0 * 1.08_f64.powi(step)).collect();
        let usual = |s: f64| 1e-5 * 3600.0 / s;
        let found = |more: &dyn Fn(f64) -> f64| {
            let mut random = fastrand::Rng::with_seed(12);
            let mut noisy = |pa: f64| pa * (1.0 + 0.04 * (random.f64() - 0.5));
            excess(&times.iter().map(|s| (*s, noisy(usual(*s) + more(*s)), usual(*s))).collect::<Vec<_>>())
        };
        assert!(matches!(found(&|_| 1e-3), Some(Excess::Constant { pa }) if (pa / 1e-3 - 1.0).abs() < 0.05));
        assert!(
            matches!(found(&|s| 3e-5 * 3600.0 / s), Some(Excess::Outgassing { exponent }) if (exponent - 1.0).abs() < 0.05)
        );
        assert!(
            matches!(found(&|s| 1e-1 * (-s / 2000.0).exp()), Some(Excess::VirtualLeak { tau_s }) if (tau_s / 2000.0 - 1.0).abs() < 0.05)
        );
        assert_eq!(found(&|_| 0.0), None);
        assert_eq!(found(&|s| 1e-2 * (1.0 + 0.9 * (s / 50.0).sin())), None, "none of the three");
    }
}
