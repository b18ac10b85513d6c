#![doc = include_str!("../README.md")]
//!
//! # Modules
//!
//! | Module | Holds |
//! |---|---|
//! | [`device`] | a virtual device: a slave, its power switch, faults, and the pressure around it |
//! | [`device_spec`] | devices from text such as `bcg450@5:unit=torr` |
//! | [`action_text`] | faults, switches and potentiometers as users write them |
//! | [`gas_pressure`] | pressures that a chamber can have, from text |
//! | [`nonvolatile`] | nonvolatile memory in a file that survives a power cut |
//! | [`memory_segment`] | a segment in memory, faster than real time |
//! | [`segment_file`] | a segment in memory, described by a file, in real time |
//! | [`scenario`] | a plant, its gauges, events, and the expected results |
//! | [`mod@open`] | ports by name, `sim:FILE.toml` included |

pub mod action_text;
pub mod device;
pub mod device_spec;
pub mod gas_pressure;
pub mod memory_segment;
pub mod nonvolatile;
pub mod open;
pub mod scenario;
pub mod segment_file;
