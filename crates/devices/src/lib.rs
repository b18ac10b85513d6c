//! Vacuum gauges and controllers with a PROFIBUS interface: their tables and their behaviour.
//!
//! Nothing here knows a telegram or a bit time. A device implements [`profivac_dp::slave::Device`] for the bus and
//! [`Instrument`] for whoever gives it pressure, faults and time.
#![no_std]
#![warn(clippy::indexing_slicing, clippy::arithmetic_side_effects)]

mod instrument;

pub use instrument::{Action, Few, Indicated, Instrument, Part, Principle, REPORT_CAPACITY, Report, Unknown};
