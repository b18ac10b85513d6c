#![doc = include_str!("../README.md")]

pub mod action_text;
pub mod device;
pub mod device_spec;
pub mod gas_pressure;
pub mod gsd_slave;
pub mod memory_segment;
pub mod nonvolatile;
pub mod open;
pub mod scenario;
pub mod segment_file;
pub mod station_spec;
