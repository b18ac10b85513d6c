//! The tests of this crate in one program: linked once, and what they share is compiled once.

#[path = "../../../tests/support/every_file.rs"]
mod every_file;
#[path = "../../../tests/support/foreign_bus.rs"]
mod foreign_bus;
#[path = "../../../tests/support/until.rs"]
mod until;

mod command;
mod dashboard;
mod listen_only;
mod model;
mod slaves;
mod station;
