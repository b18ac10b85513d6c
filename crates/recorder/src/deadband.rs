//! The deadband: a sample is kept when the pressure leaves a band around the last kept one, when its quality changes, or when no
//! sample was kept for a while.
//!
//! Pressures are compared by their logarithms, so the band is the same in all thirteen decades. Before a sample that leaves the
//! band, the last sample inside is kept too: a straight line through the kept samples then stays within the band. Where time jumps,
//! because of a gap or a clock step, the samples on both sides are kept.
//!
//! The band of a point has a width in the unit of the point.

use super::recorded::Recorded;
use super::sample::{Micros, Sample};
use std::time::Duration;

/// When a sample is kept.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Deadband {
    /// The band, in decades: 0.002 is about half a percent.
    pub decades: f64,
    /// The longest time between two kept samples.
    pub max_interval: Duration,
}

impl Default for Deadband {
    /// chosen: well below the repeatability of any gauge (2 to 5 %), and one sample a minute.
    fn default() -> Self {
        Self { decades: 0.002, max_interval: Duration::from_secs(60) }
    }
}

/// Selects the samples of one series that are kept.
#[derive(Clone, Copy, Debug)]
pub struct DeadbandFilter<T: Recorded = Sample> {
    kept: Option<T>,
    /// The last sample that was not kept.
    held: Option<T>,
}

impl<T: Recorded> Default for DeadbandFilter<T> {
    fn default() -> Self {
        Self { kept: None, held: None }
    }
}

impl DeadbandFilter {
    /// The samples that are kept now: none, this one, or the one before and this one.
    pub fn push(&mut self, band: &Deadband, sample: Sample) -> impl Iterator<Item = Sample> + use<> {
        self.push_within(band.decades, band.max_interval, sample)
    }
}

impl<T: Recorded> DeadbandFilter<T> {
    /// The samples that are kept now, with a band of this width: decades for pressures, the unit of the point for values of a point.
    pub fn push_within(&mut self, width: f64, max_interval: Duration, sample: T) -> impl Iterator<Item = T> + use<T> {
        let (first, second) = match self.kept {
            Some(kept) if !leaves_band(width, &kept, &sample) && !self.has_jumped(max_interval, &kept, &sample) => {
                let overdue = kept.at().after(max_interval) <= sample.at();
                self.held = (!overdue).then_some(sample);
                (None, overdue.then_some(sample))
            }
            _ => (self.held.take(), Some(sample)),
        };
        self.kept = second.or(self.kept);
        first.into_iter().chain(second)
    }

    /// Whether time went back, or forward by more than the longest interval.
    fn has_jumped(&self, max_interval: Duration, kept: &T, sample: &T) -> bool {
        let last = self.held.map_or(kept.at(), |held| held.at());
        sample.at() < last || sample.at() > last.after(max_interval)
    }

    /// Returns the last sample that was not kept, to be kept after all.
    pub fn flush(&mut self) -> Option<T> {
        let held = self.held.take();
        self.kept = held.or(self.kept);
        held
    }

    /// The time of the last kept sample.
    #[must_use]
    pub fn kept_at(&self) -> Option<Micros> {
        self.kept.map(|kept| kept.at())
    }
}

fn leaves_band<T: Recorded>(width: f64, kept: &T, sample: &T) -> bool {
    let moved = match (kept.on_scale(), sample.on_scale()) {
        (Some(before), Some(now)) => (now - before).abs() > width,
        (None, None) => false,
        (Some(_), None) | (None, Some(_)) => true,
    };
    moved || kept.quality() != sample.quality()
}

#[cfg(test)]
mod tests {
    use super::super::point::PointSample;
    use super::super::quality::Quality;
    use super::*;

    const BAND: Deadband = Deadband { decades: 0.01, max_interval: Duration::from_secs(10) };

    fn at(second: i64, pa: f64) -> Sample {
        Sample::new(Micros(second * Micros::SECOND), Some(pa), Quality::Valid)
    }

    fn filtered(samples: &[Sample]) -> Vec<Sample> {
        let mut filter = DeadbandFilter::default();
        samples.iter().flat_map(|sample| filter.push(&BAND, *sample)).collect()
    }

    #[test]
    fn samples_within_the_band_are_dropped() {
        let steady: Vec<_> = (0..10).map(|second| at(second, 1.0 + 0.001 * second as f64)).collect();
        assert_eq!(filtered(&steady), [steady[0]]);
    }

    #[test]
    fn one_sample_is_kept_per_longest_interval() {
        let steady: Vec<_> = (0..25).map(|second| at(second, 1.0)).collect();
        let kept: Vec<_> = filtered(&steady).iter().map(|sample| sample.at.0 / Micros::SECOND).collect();
        assert_eq!(kept, [0, 10, 20]);
    }

    #[test]
    fn the_last_sample_before_a_step_is_kept() {
        let samples = [at(0, 1.0), at(1, 1.0), at(2, 1.0), at(3, 2.0)];
        assert_eq!(filtered(&samples), [samples[0], samples[2], samples[3]]);
    }

    #[test]
    fn the_samples_on_both_sides_of_a_clock_step_are_kept() {
        let back = [at(100, 1.0), at(101, 1.0), at(40, 1.0), at(41, 1.0)];
        assert_eq!(filtered(&back), [back[0], back[1], back[2]]);
        let forth = [at(100, 1.0), at(101, 1.0), at(160, 1.0), at(161, 1.0)];
        assert_eq!(filtered(&forth), [forth[0], forth[1], forth[2]]);
    }

    #[test]
    fn the_band_has_the_same_width_in_every_decade() {
        for pa in [1e-9, 1e-3, 1.0, 1e5] {
            assert_eq!(filtered(&[at(0, pa), at(1, pa * 1.02)]).len(), 1, "{pa}");
            assert_eq!(filtered(&[at(0, pa), at(1, pa * 1.03)]).len(), 2, "{pa}");
        }
    }

    #[test]
    fn a_sample_of_another_quality_is_kept() {
        let gap = Sample::gap(Micros(Micros::SECOND));
        let over = Sample::new(Micros(2 * Micros::SECOND), Some(1.0), Quality::Overrange);
        assert_eq!(filtered(&[at(0, 1.0), gap, over]), [at(0, 1.0), gap, over]);
    }

    /// The seconds at which values of a point, one a second, are kept.
    fn kept_of_point(width: f64, numbers: &[f64]) -> Vec<i64> {
        let mut filter = DeadbandFilter::default();
        let value = |(second, number): (i64, &f64)| {
            PointSample::new(Micros(second * Micros::SECOND), Some(*number), Quality::Valid)
        };
        let kept = (0..).zip(numbers).flat_map(|it| filter.push_within(width, BAND.max_interval, value(it)));
        kept.map(|sample| sample.at.0 / Micros::SECOND).collect()
    }

    #[test]
    fn the_band_of_a_point_has_a_width_in_its_unit_at_zero_too() {
        assert_eq!(kept_of_point(0.5, &[0.0, 0.5, -0.5, 0.2, 0.6, 1000.0, 1000.5]), [0, 3, 4, 5]);
    }

    #[test]
    fn without_a_width_each_change_of_a_point_is_kept_and_the_last_value_before_it() {
        assert_eq!(kept_of_point(0.0, &[0.0, 0.0, 0.0, 1.0, 1.0, 0.0]), [0, 2, 3, 4, 5]);
    }
}
