//! Keeps the full sample rate around events: the samples of the last seconds wait in memory and are written when an event occurs;
//! after the event every sample is written for the same time.

use super::recorded::Recorded;
use super::sample::{Micros, Sample};
use std::collections::VecDeque;
use std::time::Duration;

/// The most samples in a ring buffer: more than a gauge sends in a window of 30 s.
const MAX_SAMPLES: usize = 10_000;

/// The last samples of one series.
#[derive(Clone, Debug)]
pub struct RingBuffer<T: Recorded = Sample> {
    window: Duration,
    samples: VecDeque<T>,
    /// Until this time every sample is written.
    full_rate_until: Option<Micros>,
}

impl<T: Recorded> RingBuffer<T> {
    /// Keeps the samples of the last `window`.
    #[must_use]
    pub const fn new(window: Duration) -> Self {
        Self { window, samples: VecDeque::new(), full_rate_until: None }
    }

    /// Keeps a sample, or returns `true` when it is to be written now.
    pub fn push(&mut self, sample: T) -> bool {
        let (oldest, newest) = (sample.at().before(self.window), sample.at().after(self.window));
        // An end beyond twice the window was set before the clock was set back.
        if self.full_rate_until.is_some_and(|end| sample.at() <= end && end <= newest.after(self.window)) {
            return true;
        }
        self.full_rate_until = None;
        while self.samples.front().is_some_and(|first| first.at() < oldest || first.at() > newest)
            || self.samples.len() >= MAX_SAMPLES
        {
            self.samples.pop_front();
        }
        self.samples.push_back(sample);
        false
    }

    /// An event occurred at `at`: returns the kept samples, and lets every sample through for one more window.
    pub fn trigger(&mut self, at: Micros) -> impl Iterator<Item = T> {
        self.full_rate_until = Some(at.after(self.window));
        self.samples.drain(..)
    }
}

#[cfg(test)]
mod tests {
    use super::super::quality::Quality;
    use super::*;

    fn at(second: i64) -> Sample {
        Sample::new(Micros(second * Micros::SECOND), Some(1.0), Quality::Valid)
    }

    #[test]
    fn an_event_returns_the_samples_before_it_and_opens_a_window_after_it() {
        let mut ring = RingBuffer::new(Duration::from_secs(5));
        assert!((0..20).all(|second| !ring.push(at(second))));
        let before: Vec<_> =
            ring.trigger(Micros(19 * Micros::SECOND)).map(|sample| sample.at.0 / Micros::SECOND).collect();
        assert_eq!(before, [14, 15, 16, 17, 18, 19]);
        let after: Vec<_> = (20..30).filter(|second| ring.push(at(*second))).collect();
        assert_eq!(after, [20, 21, 22, 23, 24]);
        assert_eq!(ring.trigger(Micros(30 * Micros::SECOND)).count(), 5, "written samples are not returned again");
    }

    #[test]
    fn a_clock_that_is_set_back_closes_the_window() {
        let mut ring = RingBuffer::new(Duration::from_secs(5));
        ring.push(at(3600));
        assert_eq!(ring.trigger(Micros(3600 * Micros::SECOND)).count(), 1);
        assert!(ring.push(at(3601)));
        assert!((0..10).all(|second| !ring.push(at(second))));
    }

    #[test]
    fn a_clock_that_stands_still_does_not_fill_the_memory() {
        let mut ring = RingBuffer::new(Duration::from_secs(5));
        (0..MAX_SAMPLES + 100).for_each(|_| {
            ring.push(at(1));
        });
        assert_eq!(ring.samples.len(), MAX_SAMPLES);
    }
}
