//! Vacuum gauges and controllers with a PROFIBUS interface: their tables and their behaviour.
//!
//! Nothing here knows a telegram or a bit time. A device implements [`profivac_dp::slave::Device`] for the bus and
//! [`Instrument`] for whoever gives it pressure, faults and time.
//!
//! | Module | Knows |
//! |---|---|
//! | [`model`] | rows, blocks, telegrams, units, codes: tables, no behaviour |
//! | [`store`] | nonvolatile memory as a device sees it |
//! | [`profile`] | what all block devices share |
//! | [`bcg450`], [`pxg55x`] and their like | one device: its tables beside its behaviour |
#![no_std]
#![warn(clippy::indexing_slicing, clippy::arithmetic_side_effects)]

pub mod bcg450;
mod instrument;
pub mod model;
pub mod profile;
pub mod pxg55x;
pub mod store;
pub mod tpg;

pub use instrument::{Action, Few, Indicated, Instrument, Part, Principle, REPORT_CAPACITY, Report, Unknown};
