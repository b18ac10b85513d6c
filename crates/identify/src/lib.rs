//! Vacuum plants identified from their data.
//!
//! Units: pressures in Pa, volumes in m³, gas flows in Pa m³/s, pumping speeds in m³/s, temperatures in K, times in s.

// The plants of the tests know the crate by this name.
#[cfg(test)]
extern crate self as profivac_identify;

mod interval;
pub mod plant;
mod profile;
pub mod rise;
pub mod spray;

pub use interval::{Interval, standard_uncertainty};

/// The example of the README runs as a test.
#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct Readme;
