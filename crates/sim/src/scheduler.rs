//! The earliest of many times: a tournament tree with one time for each place.
//!
//! A time changes far more often than it is reached (every exchange moves a watchdog), so a heap of events would mostly hold
//! obsolete entries. Here each place has one time, and a change costs a few comparisons.

use profivac_dp::link::BitTime;

/// The time that is never reached.
pub(crate) const NEVER: BitTime = BitTime(u64::MAX);

/// One time for each place, with the earliest at the root.
#[derive(Clone, Debug)]
pub(crate) struct Scheduler {
    /// A binary tree: node 1 is the root, the children of `n` are `2n` and `2n + 1`, the second half are the places.
    earliest: Vec<BitTime>,
}

impl Scheduler {
    /// A scheduler with `places` places, all at [`NEVER`].
    pub(crate) fn new(places: usize) -> Self {
        Self { earliest: vec![NEVER; places.next_power_of_two() * 2] }
    }

    /// Grows to `places` places in total and keeps the times.
    pub(crate) fn grow(&mut self, places: usize) {
        let had = self.places();
        if places > had {
            let mut grown = Self::new(places);
            (0..had).for_each(|index| grown.set(index, self.earliest[had + index]));
            *self = grown;
        }
    }

    fn places(&self) -> usize {
        self.earliest.len() / 2
    }

    /// Sets the time of `place`.
    pub(crate) fn set(&mut self, index: usize, time: BitTime) {
        let mut node = self.places() + index;
        if self.earliest[node] == time {
            return;
        }
        self.earliest[node] = time;
        while node > 1 {
            let winner = self.earliest[node].min(self.earliest[node ^ 1]);
            node /= 2;
            if self.earliest[node] == winner {
                break;
            }
            self.earliest[node] = winner;
        }
    }

    /// The earliest time.
    pub(crate) fn earliest_time(&self) -> BitTime {
        self.earliest[1]
    }

    /// The lowest place with the earliest time.
    pub(crate) fn earliest_index(&self) -> usize {
        let mut node = 1;
        while node < self.places() {
            node *= 2;
            if self.earliest[node] != self.earliest_time() {
                node += 1;
            }
        }
        node - self.places()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::random::Random;

    #[test]
    fn the_earliest_time_is_first_and_the_lowest_place_wins() {
        let mut scheduler = Scheduler::new(1);
        scheduler.grow(100);
        let mut times = [NEVER; 100];
        let mut random = Random::new(1);
        for _ in 0..10_000 {
            let (index, time) = (random.below(100) as usize, BitTime(random.below(50)));
            times[index] = time;
            scheduler.set(index, time);
            let first = times.iter().min().unwrap();
            assert_eq!(scheduler.earliest_time(), *first);
            assert_eq!(Some(scheduler.earliest_index()), times.iter().position(|time| time == first));
        }
    }

    #[test]
    fn growing_keeps_the_times() {
        let mut scheduler = Scheduler::new(2);
        scheduler.set(1, BitTime(7));
        scheduler.grow(9);
        assert_eq!((scheduler.earliest_time(), scheduler.earliest_index()), (BitTime(7), 1));
    }
}
