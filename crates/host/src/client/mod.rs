//! Gauges by name.

pub mod names;
