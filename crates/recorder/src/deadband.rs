//! The dead band: a sample is kept when the pressure has moved, when its quality has changed, or when none was kept for long.
//!
//! Pressures are compared by their logarithms, over thirteen decades alike. Before a sample that has moved, the last one
//! that had not is kept too: a line through the kept samples then never leaves the band. Where time jumps, because nothing was
//! measured or because somebody set the clock, both sides are kept.

use super::sample::{Micros, Sample};
use std::time::Duration;

/// How much a pressure may move unseen.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Deadband {
    /// In decades: 0.002 is about half a percent.
    pub decades: f64,
    /// At least one sample is kept in so long.
    pub max_interval: Duration,
}

impl Default for Deadband {
    /// free choice: well below what any gauge repeats (2 to 5 %), and a sample a minute.
    fn default() -> Self {
        Self { decades: 0.002, max_interval: Duration::from_secs(60) }
    }
}

/// Thins the samples of one gauge.
#[derive(Clone, Copy, Debug, Default)]
pub struct DeadbandFilter {
    kept: Option<Sample>,
    /// The last one that was not kept.
    held: Option<Sample>,
}

impl DeadbandFilter {
    /// Which samples are kept now: none, this one, or the one before and this one.
    pub fn push(&mut self, band: &Deadband, sample: Sample) -> impl Iterator<Item = Sample> + use<> {
        let (first, second) = match self.kept {
            Some(kept) if !leaves_band(band, &kept, &sample) && !self.has_jumped(band, &kept, &sample) => {
                let overdue = kept.at.after(band.max_interval) <= sample.at;
                self.held = (!overdue).then_some(sample);
                (None, overdue.then_some(sample))
            }
            _ => (self.held.take(), Some(sample)),
        };
        self.kept = second.or(self.kept);
        first.into_iter().chain(second)
    }

    /// Whether time went back, or on by more than is ever left out.
    fn has_jumped(&self, band: &Deadband, kept: &Sample, sample: &Sample) -> bool {
        let last = self.held.map_or(kept.at, |held| held.at);
        sample.at < last || sample.at > last.after(band.max_interval)
    }

    /// The last sample that was not kept, if any, to be kept after all.
    pub fn flush(&mut self) -> Option<Sample> {
        let held = self.held.take();
        self.kept = held.or(self.kept);
        held
    }

    /// When the last sample was kept.
    #[must_use]
    pub fn kept_at(&self) -> Option<Micros> {
        self.kept.map(|kept| kept.at)
    }
}

fn leaves_band(band: &Deadband, kept: &Sample, sample: &Sample) -> bool {
    let moved = match (kept.decades(), sample.decades()) {
        (Some(before), Some(now)) => (now - before).abs() > band.decades,
        (None, None) => false,
        (Some(_), None) | (None, Some(_)) => true,
    };
    moved || kept.quality != sample.quality
}

#[cfg(test)]
mod tests {
    use super::super::sample::Quality;
    use super::*;

    const BAND: Deadband = Deadband { decades: 0.01, max_interval: Duration::from_secs(10) };

    fn at(second: i64, pa: f64) -> Sample {
        Sample::new(Micros(second * Micros::SECOND), Some(pa), Quality::Valid)
    }

    fn thinned(samples: &[Sample]) -> Vec<Sample> {
        let mut thinner = DeadbandFilter::default();
        samples.iter().flat_map(|sample| thinner.push(&BAND, *sample)).collect()
    }

    #[test]
    fn what_stays_in_the_band_is_left_out() {
        let steady: Vec<_> = (0..10).map(|second| at(second, 1.0 + 0.001 * second as f64)).collect();
        assert_eq!(thinned(&steady), [steady[0]]);
    }

    #[test]
    fn one_sample_is_kept_in_the_longest_time() {
        let steady: Vec<_> = (0..25).map(|second| at(second, 1.0)).collect();
        let kept: Vec<_> = thinned(&steady).iter().map(|sample| sample.at.0 / Micros::SECOND).collect();
        assert_eq!(kept, [0, 10, 20]);
    }

    #[test]
    fn before_a_step_the_last_steady_sample_is_kept() {
        let samples = [at(0, 1.0), at(1, 1.0), at(2, 1.0), at(3, 2.0)];
        assert_eq!(thinned(&samples), [samples[0], samples[2], samples[3]]);
    }

    #[test]
    fn where_the_clock_jumps_both_sides_are_kept() {
        let back = [at(100, 1.0), at(101, 1.0), at(40, 1.0), at(41, 1.0)];
        assert_eq!(thinned(&back), [back[0], back[1], back[2]]);
        let forth = [at(100, 1.0), at(101, 1.0), at(160, 1.0), at(161, 1.0)];
        assert_eq!(thinned(&forth), [forth[0], forth[1], forth[2]]);
    }

    #[test]
    fn the_band_is_the_same_in_every_decade() {
        for pa in [1e-9, 1e-3, 1.0, 1e5] {
            assert_eq!(thinned(&[at(0, pa), at(1, pa * 1.02)]).len(), 1, "{pa}");
            assert_eq!(thinned(&[at(0, pa), at(1, pa * 1.03)]).len(), 2, "{pa}");
        }
    }

    #[test]
    fn a_new_quality_is_kept() {
        let gap = Sample::gap(Micros(Micros::SECOND));
        let over = Sample::new(Micros(2 * Micros::SECOND), Some(1.0), Quality::Overrange);
        assert_eq!(thinned(&[at(0, 1.0), gap, over]), [at(0, 1.0), gap, over]);
    }
}
