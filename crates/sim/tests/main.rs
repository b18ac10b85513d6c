//! The tests of the simulated segment in one program: linked once, and what they share is compiled once.

#[path = "../../../tests/support/every_file.rs"]
mod every_file;
#[path = "../../../tests/support/golden.rs"]
mod golden;
#[path = "ring/main.rs"]
mod ring;

mod acyclic;
mod class1;
mod common;
mod detection;
mod faults;
mod frame_count;
mod min_tsdr;
mod noise;
mod rates;
mod referee;
mod refusals;
mod reply_matrix;
mod trace;
mod watchdog;
