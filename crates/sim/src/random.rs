//! A small generator of random numbers (SplitMix64): the same seed gives the same numbers on every machine.

/// A sequence of random numbers.
#[derive(Clone, Debug)]
pub struct Random(u64);

impl Random {
    /// The sequence of `seed`.
    #[must_use]
    pub const fn new(seed: u64) -> Self {
        Self(seed)
    }

    /// The next number.
    pub const fn next(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9E37_79B9_7F4A_7C15);
        let mut mixed = self.0;
        mixed = (mixed ^ mixed >> 30).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        mixed = (mixed ^ mixed >> 27).wrapping_mul(0x94D0_49BB_1331_11EB);
        mixed ^ mixed >> 31
    }

    /// A number from 0 to `limit` - 1; 0 if `limit` is 0.
    pub const fn below(&mut self, limit: u64) -> u64 {
        ((self.next() as u128 * limit as u128) >> 64) as u64
    }

    /// A number from 0 to below 1.
    pub const fn fraction(&mut self) -> f64 {
        (self.next() >> 11) as f64 / (1u64 << 53) as f64
    }

    /// One octet.
    pub const fn octet(&mut self) -> u8 {
        (self.next() >> 56) as u8
    }

    /// The number of failures before the first success, for a success of `probability` (geometric distribution).
    pub fn failures_before_success(&mut self, probability: f64) -> u64 {
        if probability <= 0.0 {
            return u64::MAX;
        }
        ((1.0 - self.fraction()).ln() / (-probability).ln_1p()) as u64
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_sequence_is_that_of_the_publication() {
        let mut random = Random::new(1_234_567);
        assert_eq!([random.next(), random.next()], [6_457_827_717_110_365_317, 3_203_168_211_198_807_973]);
    }

    #[test]
    fn failures_before_success_have_the_geometric_mean() {
        let mut random = Random::new(7);
        let total: u64 = (0..100_000).map(|_| random.failures_before_success(0.01)).sum();
        assert!((9_800_000..10_000_000).contains(&total), "{total} instead of 9,900,000 or so");
        assert_eq!(random.failures_before_success(1.0), 0);
        assert_eq!(random.failures_before_success(0.0), u64::MAX);
    }
}
