//! The first round of a segment after its port was opened first: the time in which a gauge is not missed yet.

use super::moment::Moment;
use std::time::{Duration, Instant};

/// The longest wait for the first round. chosen: a silent gauge takes some seconds, and a segment has up to some ten of them.
pub const LONGEST: Duration = Duration::from_secs(30);

/// Whether the station has found out if a gauge or a slave answers.
#[derive(Clone, Copy, Debug)]
pub struct FirstRound {
    /// Until when it is awaited; `None` when the station knows.
    until: Option<Instant>,
    /// The port was open since.
    is_opened: bool,
}

impl FirstRound {
    /// A round that begins now.
    pub fn begin(now: Moment) -> Self {
        Self { until: now.at.checked_add(LONGEST), is_opened: false }
    }

    /// The port was opened. Only the first opening begins the round again: a port that is lost again and again would hide a missing gauge.
    pub fn port_opened(&mut self, now: Moment) {
        if !self.is_opened {
            *self = Self { is_opened: true, ..Self::begin(now) };
        }
    }

    /// The station knows: the slave gave data, or a request to it has failed.
    pub const fn end(&mut self) {
        self.until = None;
    }

    /// Whether the station does not know yet, and has not waited for too long.
    pub fn is_awaited(self, now: Moment) -> bool {
        self.until.is_some_and(|until| now.at < until)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use profivac_recorder::Micros;

    #[test]
    fn a_round_ends_with_an_answer_or_after_its_longest_time() {
        let begin = Moment { at: Instant::now(), wall: Micros(0) };
        let after = |time: Duration| Moment { at: begin.at + time, ..begin };
        let mut round = FirstRound::begin(begin);
        assert!(round.is_awaited(after(LONGEST - Duration::from_millis(1))));
        assert!(!round.is_awaited(after(LONGEST)));
        round.end();
        assert!(!round.is_awaited(begin));
    }

    #[test]
    fn only_the_first_opening_of_the_port_begins_the_round_again() {
        let begin = Moment { at: Instant::now(), wall: Micros(0) };
        let after = |time: Duration| Moment { at: begin.at + time, ..begin };
        let mut round = FirstRound::begin(begin);
        let opened = after(2 * LONGEST);
        round.port_opened(opened);
        assert!(round.is_awaited(opened));
        round.port_opened(after(3 * LONGEST));
        assert!(!round.is_awaited(after(3 * LONGEST)));
        round.end();
        round.port_opened(opened);
        assert!(!round.is_awaited(opened));
    }
}
