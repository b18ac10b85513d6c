//! Rings of several masters in bit times, checked by the referee. profibus-wire 1.13.
#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic, reason = "a test")]

mod broken_stations;
mod contention;
mod foreign;
mod join_and_leave;
mod line;
mod lost;
mod random_faults;
mod two_tokens;
