//! A gauge on a microcontroller, as far as it needs no hardware: every part runs and is tested on any computer.
//!
//! | Module | Contents |
//! |---|---|
//! | [`clock`] | ticks of a timer to bit times |
//! | [`bus`] | the receiver of the character interrupt, and the slave of the work interrupt |
//! | [`flash`] | a store in two pages of flash |
//! | [`sensor`] | a sensor of one's own behind a device |
//! | [`pirani`] | a Pirani at an analogue input, with a calibration table |
//! | [`scenario`] | a sensor that plays a list of pressures |
#![no_std]
#![forbid(unsafe_code)]

pub mod bus;
pub mod clock;
pub mod flash;
#[cfg(feature = "defmt")]
mod log;
pub mod pirani;
pub mod scenario;
pub mod sensor;
