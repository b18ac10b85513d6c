//! Waits of tests for a state.

#![allow(dead_code, reason = "every crate uses its own part")]

use std::thread;
use std::time::{Duration, Instant};

/// The longest wait, enough for a busy computer. It only ends a test that would hang.
pub const TIMEOUT: Duration = Duration::from_secs(60);

/// Between two looks a test leaves the processor to the program that it waits for. The outcome does not depend on the length.
pub fn pause() {
    thread::park_timeout(Duration::from_millis(5));
}

/// Waits until `seen` returns a value.
#[track_caller]
pub fn until<T>(what: &str, mut seen: impl FnMut() -> Option<T>) -> T {
    let end = Instant::now() + TIMEOUT;
    loop {
        if let Some(seen) = seen() {
            return seen;
        }
        assert!(Instant::now() < end, "timed out: {what}");
        pause();
    }
}
