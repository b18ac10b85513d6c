//! Octets to telegrams and back.
//!
//! The lowest layer of profivac: it knows what the octets on a PROFIBUS line mean and nothing about when they may be sent,
//! who may send them or what a parameter is. Everything is parsed once, completely, into types that borrow the octets, and
//! the same types emit themselves.
//!
//! | Module | Holds | Reference |
//! |---|---|---|
//! | [`telegram`] | SD1, SD2, SD3, SD4, SC | profibus-wire 1.2 to 1.6 |
//! | [`control`] | the frame control octet | profibus-wire 1.4, 1.5 |
//! | [`ident`] | what a station says of itself | profibus-wire 1.11 |
//! | [`sap`] | which service a service access point stands for | profibus-wire 2.1 |
//! | [`diag`], [`prm`], [`mod@cfg`], [`global`], [`address`] | the DP-V0 data units | profibus-wire 2.3 to 2.11 |
//! | [`ext_diag`] | the blocks of an extended diagnosis | profibus-wire 2.3.1, 2.3.2 |
//! | [`acyclic`] | the DP-V1 PDUs of MS1 and MS2 | profibus-wire 4 and 5 |
//!
//! ```
//! use profivac_wire::{Frame, Telegram, control::Control};
//!
//! // Slave 8 asks to be diagnosed: Slave_Diag from master 2, profibus-wire 2.3.
//! let octets = [0x68, 5, 5, 0x68, 0x88, 0x82, 0x6D, 0x3C, 0x3E, 0xF1, 0x16];
//! let Ok(Telegram::Frame(frame)) = Telegram::parse(&octets) else { panic!("a valid telegram") };
//! assert_eq!((frame.da, frame.sa, frame.dsap), (8, 2, Some(60)));
//! assert!(matches!(frame.control(), Control::Request { .. }));
//!
//! let mut out = [0; profivac_wire::MAX_TELEGRAM];
//! let length = Telegram::Frame(frame).emit(&mut out)?;
//! assert_eq!(out.get(..length), Some(&octets[..]));
//! # Ok::<(), profivac_wire::Full>(())
//! ```
#![no_std]
#![warn(clippy::indexing_slicing, clippy::arithmetic_side_effects)]

pub mod acyclic;
pub mod address;
pub mod cfg;
pub mod control;
pub mod diag;
pub mod ext_diag;
pub mod global;
pub mod ident;
mod octets;
pub mod prm;
pub mod sap;
pub mod telegram;

#[cfg(test)]
mod testing;

pub use octets::{Reader, TooLong, TooShort, Writer};
pub use sap::Sap;
pub use telegram::{BROADCAST, DataTelegram, MAX_DU, MAX_TELEGRAM, Telegram, TelegramError, TelegramLength};
