//! Helpers for the tests of the master: a rig where the test plays the rest of the bus telegram by telegram, a line that joins
//! one master and some slaves octet by octet, and a plain device for the slaves.
#![allow(
    clippy::unwrap_used,
    clippy::expect_used,
    clippy::panic,
    reason = "these are tests, outside of test functions"
)]

pub mod line;
pub mod plain;
pub mod rig;

pub use crate::octets::{hex, text};

use profivac_dp::link::Baud;
use profivac_dp::link::active::BusParameters;

/// Master 2 at 1.5 Mbit/s (T_SL 300, T_ID1 37, T_ID2 150). Its GAP is small and scanned once in 100 target rotation
/// times, so that dialogues rarely contain it: [`is_housekeeping`].
pub fn bus() -> BusParameters {
    BusParameters { gap_factor: 100, hsa: 2, ..BusParameters::new(2, Baud::B1500000) }
}

/// Whether a telegram is a token, or an FDL status request to the GAP of [`bus`].
pub fn is_housekeeping(octets: &[u8]) -> bool {
    matches!(octets, [0xDC, ..] | [0x10, 0 | 1, 2, 0x49, ..])
}

/// Reproducible pseudo-random numbers: a test prints its seed and can be run with it again.
pub struct Random(u64);

impl Random {
    pub fn new(seed: u64) -> Self {
        println!("seed {seed:#x}");
        Self(seed)
    }

    pub fn next(&mut self) -> u64 {
        // SplitMix64
        self.0 = self.0.wrapping_add(0x9E37_79B9_7F4A_7C15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
        z ^ (z >> 31)
    }

    pub fn below(&mut self, bound: usize) -> usize {
        (self.next() % bound as u64) as usize
    }
}
