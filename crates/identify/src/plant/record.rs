//! A record of a plant: samples, the state of the valve, and the volume.

/// The fewest samples.
pub const LEAST_SAMPLES: usize = 30;

/// The groups of a phase: more samples are averaged, in groups that are even over the logarithm of time.
const GROUPS: f64 = 180.0;

/// The logarithm of the pressure changes by less than this within a group, so that a straight line describes it.
const GROUP_CHANGE: f64 = 0.1;

/// The groups of a phase before their time alone ends them: the samples of a gauge with more noise than [`GROUP_CHANGE`] would be a
/// group each. chosen
const MOST_GROUPS: usize = 1500;

/// The least noise of a sample, of the logarithm: a record without noise has the four digits of a display. chosen
const LEAST_NOISE: f64 = 1e-4;

/// The state of the valve to the pump from a time on.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Phase {
    /// The start, in s.
    pub from_s: f64,
    /// Whether the valve to the pump is open.
    pub pumped: bool,
}

/// A known amount of gas that enters at once while the valve is closed, to measure the volume.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Dose {
    /// The time, in s.
    pub at_s: f64,
    /// The amount, in Pa m³.
    pub amount: f64,
}

/// The volume of the chamber.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Volume {
    /// It is known, in m³.
    Given(f64),
    /// It follows from a dose.
    FromDose(Dose),
}

/// A record of a plant.
#[derive(Clone, Debug, PartialEq)]
pub struct PlantRecord {
    /// Seconds since the start of the pump-down, and pressures in Pa.
    pub samples: Vec<(f64, f64)>,
    /// The phases, in the order of time; the first one begins with the record.
    pub phases: Vec<Phase>,
    /// The volume.
    pub volume: Volume,
    /// The standard uncertainty of the gauge's sensitivity as a fraction, which no fit reduces.
    pub gauge_uncertainty: f64,
}

/// The pressures of a sample, in Pa: below any vacuum that a gauge can measure, above any pressure of a chamber. chosen
const POSSIBLE_PA: std::ops::RangeInclusive<f64> = 1e-15..=1e9;

/// The reason why a record cannot be fitted.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum NotIdentified {
    /// Too few samples.
    #[error("expected at least {LEAST_SAMPLES} samples, got {0}")]
    Few(usize),
    /// A number is not finite, a pressure not possible, or the times do not rise.
    #[error("expected rising times and pressures from 1e-15 to 1e9 Pa, got something else in sample {0}")]
    Sample(usize),
    /// The record has no phases, or they are not in order.
    #[error("expected phases in the order of time, the first one with the valve open")]
    Phases,
    /// The volume or the dose is not above zero, or the uncertainty of the gauge is below it.
    #[error("expected a volume or a dose above zero, and no uncertainty below zero")]
    Volume,
    /// The dose is not within a phase with a closed valve.
    #[error("expected the dose while the valve is closed")]
    DoseWhilePumped,
    /// No sample lies in a phase with a closed valve, so its times are those of another day or gauge.
    #[error("expected samples while the valve is closed, found none")]
    NoRise,
    /// The method found no minimum.
    #[error("the fit found no minimum: the record does not look like a pump-down")]
    NoMinimum,
    /// The caller stopped the search.
    #[error("the search was stopped")]
    Stopped,
}

/// The mean of some samples: time in s, logarithm of the pressure in Pa, and their number.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Group {
    pub at_s: f64,
    pub ln_pa: f64,
    pub count: f64,
}

impl PlantRecord {
    pub(super) fn pumped_at(&self, seconds: f64) -> bool {
        self.phases.iter().rev().find(|phase| phase.from_s <= seconds).is_none_or(|phase| phase.pumped)
    }

    pub(super) const fn dose(&self) -> Option<Dose> {
        match self.volume {
            Volume::FromDose(dose) => Some(dose),
            Volume::Given(_) => None,
        }
    }

    fn has_sample_in(&self, index: usize) -> bool {
        let [from, to] =
            [index, index + 1].map(|index| self.phases.get(index).map_or(f64::INFINITY, |phase| phase.from_s));
        self.samples.iter().any(|(t, _)| *t > from && *t <= to)
    }

    pub(super) fn check(&self) -> Result<(), NotIdentified> {
        let good = |(t, pa): &(f64, f64)| t.is_finite() && *t >= 0.0 && POSSIBLE_PA.contains(pa);
        if let Some(index) = self.samples.iter().position(|sample| !good(sample)) {
            return Err(NotIdentified::Sample(index));
        }
        let rises = |pair: &[(f64, f64)]| pair.first().map(|(t, _)| *t) < pair.get(1).map(|(t, _)| *t);
        if let Some(index) = self.samples.windows(2).position(|pair| !rises(pair)) {
            return Err(NotIdentified::Sample(index));
        }
        if self.samples.len() < LEAST_SAMPLES {
            return Err(NotIdentified::Few(self.samples.len()));
        }
        let ordered = self.phases.windows(2).all(|pair| pair[0].from_s < pair[1].from_s);
        if !ordered || !self.phases.first().is_some_and(|phase| phase.pumped) {
            return Err(NotIdentified::Phases);
        }
        if !self.phases.iter().enumerate().all(|(index, phase)| phase.pumped || self.has_sample_in(index)) {
            return Err(NotIdentified::NoRise);
        }
        let positive = |number: f64| number.is_finite() && number > 0.0;
        match self.volume {
            Volume::Given(m3) if !positive(m3) => Err(NotIdentified::Volume),
            Volume::FromDose(dose) if !positive(dose.amount) => Err(NotIdentified::Volume),
            Volume::FromDose(dose) if self.pumped_at(dose.at_s) => Err(NotIdentified::DoseWhilePumped),
            _ if !(self.gauge_uncertainty.is_finite() && self.gauge_uncertainty >= 0.0) => Err(NotIdentified::Volume),
            Volume::Given(_) | Volume::FromDose(_) => Ok(()),
        }
    }

    /// Means of samples, even over the logarithm of the time since the valve or the dose changed something.
    pub(super) fn groups(&self) -> Vec<Group> {
        let mut changes: Vec<f64> = self.phases.iter().map(|phase| phase.from_s).collect();
        changes.extend(self.dose().map(|dose| dose.at_s));
        changes.sort_by(f64::total_cmp);
        let mut groups = Vec::new();
        for (index, change) in changes.iter().enumerate() {
            let end = changes.get(index + 1).copied().unwrap_or(f64::INFINITY);
            let here: Vec<_> = self.samples.iter().filter(|(t, _)| t > change && *t <= end).copied().collect();
            // The first phase begins with the record, whatever its time.
            let here =
                if index == 0 { self.samples.iter().filter(|(t, _)| *t <= end).copied().collect() } else { here };
            grouped(&here, &mut groups);
        }
        groups
    }
}

/// Adds the groups of the samples of a phase.
fn grouped(samples: &[(f64, f64)], groups: &mut Vec<Group>) {
    let (Some((start, _)), Some((end, _))) = (samples.first(), samples.last()) else { return };
    let shortest = ((end - start) / 1e5).max(1e-9);
    let part = |t: f64| (((t - start) / shortest).ln_1p() / 100_001_f64.ln() * GROUPS).floor();
    let mut rest = samples;
    let before = groups.len();
    while let Some((t, first)) = rest.first() {
        let change = if groups.len() - before < MOST_GROUPS { GROUP_CHANGE } else { f64::INFINITY };
        let inside = |(at, pa): &&(f64, f64)| part(*at) <= part(*t) && (pa / first).ln().abs() < change;
        let size = rest.iter().take_while(inside).count().max(1);
        let (group, others) = rest.split_at(size.min(rest.len()));
        let count = group.len() as f64;
        let sum = group.iter().fold([0.0; 2], |[t, y], (at, pa)| [t + at, y + pa.ln()]);
        groups.push(Group { at_s: sum[0] / count, ln_pa: sum[1] / count, count });
        rest = others;
    }
}

/// The noise of the logarithm of a sample, from second differences, to which a smooth curve contributes little.
pub(super) fn noise(samples: &[(f64, f64)]) -> f64 {
    let square = |three: &[(f64, f64)]| {
        let [a, b, c] = three else { return None };
        let part = (b.0 - a.0) / (c.0 - a.0);
        let difference = (b.1 / a.1).ln() - (c.1 / a.1).ln() * part;
        Some(difference * difference / (1.0 + (1.0 - part).powi(2) + part.powi(2)))
    };
    let mut squares: Vec<f64> = samples.windows(3).filter_map(square).collect();
    let middle = squares.len() / 2;
    if squares.is_empty() {
        return LEAST_NOISE;
    }
    // The median of the squares of normal numbers is 0.4549 of their mean. It ignores the steep start and the steps.
    let median = *squares.select_nth_unstable_by(middle, f64::total_cmp).1;
    (median / 0.4549).sqrt().max(LEAST_NOISE)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_million_samples_of_a_noisy_gauge_are_few_groups() {
        let mut random = fastrand::Rng::with_seed(6);
        let samples: Vec<(f64, f64)> =
            (0..1_000_000).map(|second| (f64::from(second), 10_f64.powf(random.f64()))).collect();
        let mut groups = Vec::new();
        grouped(&samples, &mut groups);
        assert!(groups.len() <= MOST_GROUPS + GROUPS as usize + 1, "{}", groups.len());
        let all: f64 = groups.iter().map(|group| group.count).sum();
        assert_eq!(all, 1e6);
    }
}
