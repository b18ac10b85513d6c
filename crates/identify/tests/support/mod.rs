//! What the tests of rises and of plants share.

/// A random number of mean 0 and standard deviation 1, between -6 and 6.
pub fn normal(random: &mut fastrand::Rng) -> f64 {
    (0..12).map(|_| random.f64()).sum::<f64>() - 6.0
}
