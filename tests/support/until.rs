//! Waits of tests for a state.

use std::time::{Duration, Instant};

/// The longest wait, enough for a busy computer. It only ends a test that would hang.
pub const TIMEOUT: Duration = Duration::from_secs(60);

/// Waits until `seen` returns a value.
#[track_caller]
pub fn until<T>(what: &str, mut seen: impl FnMut() -> Option<T>) -> T {
    let end = Instant::now() + TIMEOUT;
    loop {
        if let Some(seen) = seen() {
            return seen;
        }
        assert!(Instant::now() < end, "timed out: {what}");
        std::thread::yield_now();
    }
}
