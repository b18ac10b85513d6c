//! Means of samples, their noise, and the straight line through them.

/// More samples are averaged in groups, because they would only cost time.
const MOST_SAMPLES: usize = 400;

/// The least relative noise: a record without noise has the four digits of a display. chosen
pub(super) const LEAST_NOISE: f64 = 1e-4;

/// Means of groups, so that at most [`MOST_SAMPLES`] remain.
pub(crate) fn grouped(samples: &[(f64, f64)]) -> Vec<(f64, f64)> {
    let size = samples.len().div_ceil(MOST_SAMPLES).max(1);
    let mean = |group: &[(f64, f64)]| {
        let count = group.len() as f64;
        let (t, p) = group.iter().fold((0.0, 0.0), |(t, p), sample| (t + sample.0, p + sample.1));
        (t / count, p / count)
    };
    samples.chunks(size).map(mean).collect()
}

/// The noise of a gauge: constant, or proportional to the pressure.
#[derive(Clone, Copy, Debug)]
pub(super) enum Noise {
    Constant(f64),
    Relative(f64),
}

impl Noise {
    /// The noise from second differences, which a smooth rise does not contribute to. The more likely of both kinds.
    pub fn of(samples: &[(f64, f64)]) -> Self {
        let mut sums = [0.0, 0.0];
        let mut logarithms = 0.0;
        let mut count = 0.0;
        for three in samples.windows(3) {
            let [(t0, p0), (t1, p1), (t2, p2)] = three else { continue };
            let part = if t2 > t0 { (t1 - t0) / (t2 - t0) } else { 0.5 };
            let difference = p1 - (p0 + (p2 - p0) * part);
            let square = difference * difference / (1.0 + part * part + (1.0 - part) * (1.0 - part));
            sums[0] += square;
            sums[1] += square / (p1 * p1);
            logarithms += p1.ln();
            count += 1.0;
        }
        // A record without noise has that of its digits.
        let highest = samples.iter().fold(0.0, |highest, (_, p)| f64::max(highest, *p));
        let constant = (sums[0] / count).sqrt().max(LEAST_NOISE * highest);
        let relative = (sums[1] / count).sqrt().max(LEAST_NOISE);
        let likely = -count * relative.ln() - logarithms > -count * constant.ln();
        if likely { Self::Relative(relative) } else { Self::Constant(constant) }
    }

    pub fn at(self, pa: f64) -> f64 {
        match self {
            Self::Constant(constant) => constant,
            Self::Relative(relative) => relative * pa,
        }
    }
}

/// The straight line of the least squares: pressure at the start in Pa, slope in Pa/s, and sum of squares.
pub(super) fn straight(samples: &[(f64, f64, f64)]) -> [f64; 3] {
    let mut sums = [0.0; 5];
    for (t, p, weight) in samples {
        let square = weight * weight;
        let parts = [1.0, *t, t * t, *p, t * p];
        sums.iter_mut().zip(parts).for_each(|(sum, part)| *sum += square * part);
    }
    let [one, t, tt, p, tp] = sums;
    let slope = (one * tp - t * p) / (one * tt - t * t);
    let start = (p - slope * t) / one;
    let chi2 = samples.iter().map(|(t, p, weight)| ((p - start - slope * t) * weight).powi(2)).sum();
    [start, slope, chi2]
}
