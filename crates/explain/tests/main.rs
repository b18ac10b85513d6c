//! The tests of this crate in one program: linked once, and what they share is compiled once.

#[path = "../../../tests/support/every_file.rs"]
mod every_file;
#[path = "../../../tests/support/golden.rs"]
mod golden;

mod decoded;
mod device_blocks;
mod explain;
mod gsd;
mod layouts;
mod log;
