//! The tests of this crate in one program.

#![allow(clippy::expect_used, clippy::unwrap_used, clippy::indexing_slicing, reason = "tests")]

mod catalog;
mod found;
mod selection;
mod slave;
