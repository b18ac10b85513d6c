//! Durations in fixed buckets: a quarter of an octave each, so the memory does not grow with the traffic.

/// The number of buckets.
const BUCKETS: usize = 140;

/// The buckets of one octave.
const PER_OCTAVE: u64 = 4;

/// The number of durations, in bit times, by size.
#[derive(Clone, Debug)]
pub struct Histogram {
    counts: Box<[u64; BUCKETS]>,
    count: u64,
    sum_tbit: u64,
    least_tbit: u64,
    greatest_tbit: u64,
}

impl Default for Histogram {
    fn default() -> Self {
        Self { counts: Box::new([0; BUCKETS]), count: 0, sum_tbit: 0, least_tbit: u64::MAX, greatest_tbit: 0 }
    }
}

impl Histogram {
    /// Adds a duration.
    pub fn add(&mut self, tbit: u64) {
        if let Some(count) = self.counts.get_mut(bucket(tbit)) {
            *count = count.saturating_add(1);
        }
        self.count = self.count.saturating_add(1);
        self.sum_tbit = self.sum_tbit.saturating_add(tbit);
        self.least_tbit = self.least_tbit.min(tbit);
        self.greatest_tbit = self.greatest_tbit.max(tbit);
    }

    /// The number of durations.
    #[must_use]
    pub const fn count(&self) -> u64 {
        self.count
    }

    /// The mean in bit times; `None` without durations.
    #[must_use]
    pub fn mean_tbit(&self) -> Option<u64> {
        self.sum_tbit.checked_div(self.count)
    }

    /// The sum of the durations in bit times. It never decreases.
    #[must_use]
    pub const fn sum_tbit(&self) -> u64 {
        self.sum_tbit
    }

    /// The shortest and the longest duration in bit times; `None` without durations.
    #[must_use]
    pub fn range_tbit(&self) -> Option<(u64, u64)> {
        (self.count > 0).then_some((self.least_tbit, self.greatest_tbit))
    }

    /// An upper bound of the duration that `percent` % of the durations do not exceed, in bit times: the end of its bucket.
    #[must_use]
    pub fn percentile_tbit(&self, percent: u64) -> Option<u64> {
        let wanted = self.count.saturating_mul(percent).div_ceil(100).max(1);
        let mut sum = 0_u64;
        let position = self.counts.iter().position(|count| {
            sum = sum.saturating_add(*count);
            sum >= wanted
        })?;
        Some(end_of(position).min(self.greatest_tbit))
    }

    /// The buckets that have durations, with their ends in bit times.
    pub fn buckets(&self) -> impl Iterator<Item = (u64, u64)> + '_ {
        let counts = self.counts.iter().enumerate().filter(|(_, count)| **count > 0);
        counts.map(|(position, count)| (end_of(position), *count))
    }
}

/// The bucket of a duration.
fn bucket(tbit: u64) -> usize {
    let octave = u64::from(tbit.max(PER_OCTAVE).ilog2());
    let part = (tbit >> octave.saturating_sub(2)) & (PER_OCTAVE - 1);
    let part = if tbit < PER_OCTAVE { 0 } else { part };
    let position = octave.saturating_sub(2).saturating_mul(PER_OCTAVE).saturating_add(part);
    usize::try_from(position).unwrap_or(BUCKETS).min(BUCKETS - 1)
}

/// The first duration behind a bucket.
fn end_of(position: usize) -> u64 {
    let position = (position as u64).saturating_add(1);
    let octave = position / PER_OCTAVE;
    (PER_OCTAVE.saturating_add(position % PER_OCTAVE))
        .checked_shl(u32::try_from(octave).unwrap_or(u32::MAX))
        .unwrap_or(u64::MAX)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_duration_is_in_the_bucket_that_ends_behind_it() {
        for tbit in (0..10_000).chain([1 << 20, (1 << 30) + 7, 1 << 35]) {
            let position = bucket(tbit);
            assert!(tbit < end_of(position), "{tbit} is in bucket {position}, which ends at {}", end_of(position));
            assert!(
                position == 0 || tbit >= end_of(position - 1),
                "{tbit} belongs to an earlier bucket than {position}"
            );
        }
        assert_eq!(bucket(u64::MAX), BUCKETS - 1);
    }

    #[test]
    fn the_summary_is_that_of_the_durations() {
        let mut histogram = Histogram::default();
        assert_eq!((histogram.mean_tbit(), histogram.percentile_tbit(50), histogram.range_tbit()), (None, None, None));
        [100; 99].into_iter().chain([1000]).for_each(|tbit| histogram.add(tbit));
        assert_eq!((histogram.count(), histogram.mean_tbit()), (100, Some(109)));
        assert_eq!(histogram.range_tbit(), Some((100, 1000)));
        assert_eq!((histogram.percentile_tbit(50), histogram.percentile_tbit(99)), (Some(112), Some(112)));
        assert_eq!(histogram.percentile_tbit(100), Some(1000));
        assert_eq!(histogram.buckets().map(|(_, count)| count).collect::<Vec<_>>(), [99, 1]);
    }
}
