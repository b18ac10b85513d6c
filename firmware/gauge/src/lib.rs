//! A gauge on a board: the contexts of [`profivac_board`], the parts of [`profivac_runtime`], and a device.
//!
//! ```text
//! character  octet, time ── LINE (receiver) ── a telegram is complete ── request_work
//! work       BUS (slave, bus side) ── answer ── alarm at its time ── character: send
//! main       sensors ── application ── flash;  BUS: tasks and snapshot, between two telegrams
//! ```
#![no_std]
#![forbid(unsafe_code)]

#[cfg(feature = "diagnostics")]
mod diagnostics;
mod gauge;
#[cfg(feature = "diagnostics")]
mod measure;
mod pages;
mod panic;

pub use gauge::{BUS_RATE, Counters, Gauge, NoSensors, counters, run};
#[cfg(feature = "diagnostics")]
pub use measure::{Request, measure};
pub use pages::{BoardFlash, store};
