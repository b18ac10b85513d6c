//! Full rate around events: the last seconds are remembered, and written when something happens; then everything is written
//! for as long.

use super::sample::{Micros, Sample};
use std::collections::VecDeque;
use std::time::Duration;

/// The last samples of one gauge.
#[derive(Clone, Debug)]
pub struct RingBuffer {
    span: Duration,
    samples: VecDeque<Sample>,
    /// Everything is written until then.
    open_until: Option<Micros>,
}

/// No gauge is faster than so many samples a second for long.
const MAX_SAMPLES: usize = 10_000;

impl RingBuffer {
    /// Remembers samples for `span`.
    #[must_use]
    pub const fn new(span: Duration) -> Self {
        Self { span, samples: VecDeque::new(), open_until: None }
    }

    /// Remembers a sample, or says that it is to be written at full rate.
    pub fn push(&mut self, sample: Sample) -> bool {
        let (oldest, newest) = (sample.at.before(self.span), sample.at.after(self.span));
        // An end that lies further ahead than any event puts it was set by a clock that was since set back.
        if self.open_until.is_some_and(|end| sample.at <= end && end <= newest.after(self.span)) {
            return true;
        }
        self.open_until = None;
        while self.samples.front().is_some_and(|first| first.at < oldest || first.at > newest)
            || self.samples.len() >= MAX_SAMPLES
        {
            self.samples.pop_front();
        }
        self.samples.push_back(sample);
        false
    }

    /// Something happened at `at`: what is remembered is to be written, and what comes for as long again.
    pub fn trigger(&mut self, at: Micros) -> impl Iterator<Item = Sample> {
        self.open_until = Some(at.after(self.span));
        self.samples.drain(..)
    }
}

#[cfg(test)]
mod tests {
    use super::super::sample::Quality;
    use super::*;

    fn at(second: i64) -> Sample {
        Sample::new(Micros(second * Micros::SECOND), Some(1.0), Quality::Valid)
    }

    #[test]
    fn an_event_brings_what_was_before_it_and_what_follows() {
        let mut ring = RingBuffer::new(Duration::from_secs(5));
        assert!((0..20).all(|second| !ring.push(at(second))));
        let before: Vec<_> =
            ring.trigger(Micros(19 * Micros::SECOND)).map(|sample| sample.at.0 / Micros::SECOND).collect();
        assert_eq!(before, [14, 15, 16, 17, 18, 19]);
        let after: Vec<_> = (20..30).filter(|second| ring.push(at(*second))).collect();
        assert_eq!(after, [20, 21, 22, 23, 24]);
        assert_eq!(ring.trigger(Micros(30 * Micros::SECOND)).count(), 5, "what was written is not brought again");
    }

    #[test]
    fn a_clock_that_was_set_back_does_not_leave_it_open() {
        let mut ring = RingBuffer::new(Duration::from_secs(5));
        ring.push(at(3600));
        assert_eq!(ring.trigger(Micros(3600 * Micros::SECOND)).count(), 1);
        assert!(ring.push(at(3601)));
        assert!((0..10).all(|second| !ring.push(at(second))));
    }

    #[test]
    fn a_clock_that_stands_still_fills_no_memory() {
        let mut ring = RingBuffer::new(Duration::from_secs(5));
        (0..MAX_SAMPLES + 100).for_each(|_| {
            ring.push(at(1));
        });
        assert_eq!(ring.samples.len(), MAX_SAMPLES);
    }
}
