//! The tests of this crate in one program: linked once, and what they share is compiled once.

#[path = "../../../tests/support/every_file.rs"]
mod every_file;
#[path = "../../../tests/support/golden.rs"]
mod golden;
#[path = "../../../tests/support/until.rs"]
mod until;

mod coming_back;
mod conditions;
mod gsd_slaves;
mod number_formats;
mod ports;
mod readings;
mod scenarios;
mod sensors;
mod twelve_devices;
