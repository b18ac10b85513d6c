//! The tests of this crate in one program: linked once, and what they share is compiled once.

#[path = "../../../tests/support/every_file.rs"]
mod every_file;
#[path = "../../../tests/support/until.rs"]
mod until;

mod backup;
mod clock;
mod common;
mod disk;
#[cfg(feature = "parquet")]
mod parquet;
mod points;
mod power_cut;
mod recorder;
