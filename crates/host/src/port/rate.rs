//! Which rates are near enough.

/// The tolerated deviation of the rate is one part in this many: a character of 11 bits is then still sampled correctly.
const RATE_TOLERANCE: u32 = 50;

/// The first of `rates` that deviates too much from `wanted`.
pub fn wrong_rate(wanted: u32, rates: impl IntoIterator<Item = Option<u32>>) -> Option<u32> {
    rates.into_iter().flatten().find(|offered| offered.abs_diff(wanted) > wanted / RATE_TOLERANCE)
}
