//! The tests of this crate in one program: linked once, and what they share is compiled once.

#[path = "../../../tests/support/every_file.rs"]
mod every_file;

mod bcg450;
mod beside;
mod errata;
mod img400;
mod pxg55x;
mod slave_model;
mod state_machine;
mod support;
mod tpg;
mod xpg400;
