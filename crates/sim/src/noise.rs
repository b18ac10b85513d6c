//! Noise: bits that are received inverted.
//!
//! The seed alone determines the inverted bit times, so all receivers of the same noise receive the same bits. The distance
//! to the next inverted bit is drawn directly (it is geometrically distributed), so intervals without errors cost nothing.

use crate::random::Random;
use crate::scheduler::NEVER;
use profivac_dp::link::BitTime;

/// Noise on the whole line, or at one station.
#[derive(Clone, Debug)]
pub struct Noise {
    seed: u64,
    per_bit: f64,
    /// Length of a block in bit times. Each block has its own sequence of distances.
    block: u64,
}

impl Noise {
    /// Noise that inverts each bit, of a character or of the idle line, with the probability `per_bit`.
    ///
    /// # Panics
    /// If `per_bit` is not a number from 0 to 1.
    #[must_use]
    pub fn new(seed: u64, per_bit: f64) -> Self {
        assert!((0.0..=1.0).contains(&per_bit), "the probability of an inverted bit must be 0 to 1, not {per_bit}");
        // About four inverted bits per block: few draws to find a position, few empty blocks to skip.
        let block = (4.0 / per_bit).clamp(64.0, 1e15) as u64;
        Self { seed, per_bit, block }
    }

    /// The first inverted bit time at or after `from`.
    pub(crate) fn next(&self, from: BitTime) -> BitTime {
        if self.per_bit <= 0.0 {
            return NEVER;
        }
        let mut block = from.0 / self.block;
        // Time ends before the last block does.
        while let Some(begin) = block.checked_mul(self.block) {
            if let Some(flip) = self.flips(block, begin).find(|flip| *flip >= from) {
                return flip;
            }
            block += 1;
        }
        NEVER
    }

    /// The inverted bit times of a block that begins at bit time `begin`.
    fn flips(&self, block: u64, begin: u64) -> impl Iterator<Item = BitTime> {
        let mut random = Random::new(self.seed ^ block.wrapping_mul(0xD134_2543_DE82_EF95));
        let mut offset = 0u64;
        std::iter::from_fn(move || {
            let flip = offset.saturating_add(random.failures_before_success(self.per_bit));
            offset = flip.saturating_add(1);
            (flip < self.block).then(|| BitTime(begin.saturating_add(flip)))
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_rate_of_inverted_bits_is_the_probability() {
        let noise = Noise::new(3, 1e-3);
        let (mut at, mut hits) = (BitTime(0), 0);
        while noise.next(at) < BitTime(10_000_000) {
            at = noise.next(at) + 1;
            hits += 1;
        }
        assert!((9_700..10_300).contains(&hits), "{hits} of 10,000,000 bits instead of 10,000 or so");
    }

    #[test]
    fn every_receiver_of_the_same_noise_gets_the_same_bits() {
        let noise = Noise::new(4, 0.01);
        let all: Vec<BitTime> = (0..100_000).map(BitTime).filter(|at| noise.next(*at) == *at).collect();
        for pair in all.windows(2) {
            for from in pair[0].0 + 1..=pair[1].0 {
                assert_eq!(noise.next(BitTime(from)), pair[1]);
            }
        }
    }

    #[test]
    fn a_probability_that_inverts_no_bit_in_all_time_ends_the_search() {
        for per_bit in [f64::MIN_POSITIVE, 1e-300, 1e-30] {
            assert_eq!(Noise::new(1, per_bit).next(BitTime(5)), NEVER, "{per_bit}");
        }
        assert_eq!(Noise::new(1, 0.5).next(BitTime(u64::MAX)), NEVER);
    }

    #[test]
    fn a_number_that_is_no_probability_is_refused() {
        for per_bit in [f64::NAN, -0.1, 1.1, f64::INFINITY] {
            assert!(std::panic::catch_unwind(|| Noise::new(1, per_bit)).is_err(), "{per_bit}");
        }
    }

    #[test]
    fn probabilities_0_and_1_invert_no_bit_and_every_bit() {
        assert_eq!(Noise::new(1, 0.0).next(BitTime(5)), NEVER);
        assert_eq!(Noise::new(1, 1.0).next(BitTime(5)), BitTime(5));
    }
}
