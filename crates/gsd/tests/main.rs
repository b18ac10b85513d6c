//! The tests of this crate in one program: linked once, and what they share is compiled once.

#![allow(clippy::expect_used, clippy::unwrap_used, reason = "tests")]

#[path = "../../../tests/support/every_file.rs"]
mod every_file;

mod any_octets;
mod configuration;
mod diagnosis;
mod encoding;
mod fit;
mod model;
mod oddities;
mod parameters;
mod reading;
mod support;
mod writing;
