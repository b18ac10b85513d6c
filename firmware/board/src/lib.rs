//! Boards: what a gauge needs of a microcontroller, behind one set of safe functions.
//!
//! Three contexts run on one core. Each interrupts those below it and ends before they go on:
//!
//! | Context | Runs | Handler |
//! |---|---|---|
//! | character | at every character, error or end of sending, and at the alarm | [`Handlers::character`], [`Handlers::sent`], [`Handlers::alarm`] |
//! | work | after [`request_work`] | [`Handlers::work`] |
//! | main | else | `main` |
//!
//! This crate has the only `unsafe` code of the project: registers, interrupts, the start, and [`Exclusive`].
#![no_std]
#![allow(unsafe_code)]
// Addresses and bits of registers are constants, and no value comes from the line.
#![allow(clippy::arithmetic_side_effects, clippy::indexing_slicing, clippy::precedence)]

mod cortex;
mod exclusive;
#[cfg(feature = "defmt")]
mod log;
#[cfg(target_abi = "eabihf")]
mod memory;
mod outgoing;
#[cfg(feature = "qemu")]
mod qemu;
#[cfg(feature = "rp2040")]
mod rp2040;
mod start;
#[cfg(any(feature = "stm32f407", feature = "stm32f411"))]
mod stm32f4;

pub use cortex::{request_work, restart, wait};
pub use exclusive::Exclusive;
#[cfg(feature = "defmt")]
pub use log::time_us;
pub use outgoing::prepare;
#[cfg(feature = "qemu")]
pub use qemu::*;
#[cfg(feature = "rp2040")]
pub use rp2040::*;
pub use start::{free_stack, hold_work, masked};
#[cfg(any(feature = "stm32f407", feature = "stm32f411"))]
pub use stm32f4::*;

/// A character that is not valid: parity, stop bit, or lost.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct LineError;

/// What a program does in the contexts above `main`.
#[derive(Clone, Copy, Debug)]
pub struct Handlers {
    /// A character ended, at the present [`ticks`].
    pub character: fn(Result<u8, LineError>),
    /// The time of [`set_alarm`] has come.
    pub alarm: fn(),
    /// The last bit has left.
    pub sent: fn(),
    /// [`request_work`] was called.
    pub work: fn(),
}

/// A light of the board.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Light {
    /// Green: on in data exchange, flashing without it.
    Bus,
    /// Red: a fault of the device, or a bit rate that the port does not have.
    Fault,
}
