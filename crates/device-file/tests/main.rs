//! The tests of this crate in one program: linked once, and what they share is compiled once.

#![allow(clippy::unwrap_used, clippy::panic, reason = "tests")]

#[path = "../../../tests/support/golden.rs"]
mod golden;

mod errors;
mod gallery;
mod hostile;
mod library;
mod like;
mod quantities;
mod round_trip;
mod simulated;
