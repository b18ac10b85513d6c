//! Rings of several masters in bit times, checked by the referee. profibus-wire 1.13.
#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic, reason = "a test")]

mod attacks;
mod chaos;
mod coming_and_going;
#[path = "../common/mod.rs"]
mod common;
mod contention;
mod foreign;
mod line;
mod lost;
mod two_tokens;
