//! PROFIBUS telegrams and DP data units: from octets to types and back.
//!
//! This crate knows the formats of a PROFIBUS line. It has no clock, no state and no allocation: timing, stations and
//! services are in `profivac-dp`. Each format is parsed once and completely into a type that borrows the octets, and the same
//! type emits itself. After `parse`, no access can fail. Codes without a meaning are kept and emitted unchanged. Exceptions:
//!
//! - [`mod@cfg`] and [`ext_diag`] are lists: each item is parsed when its turn comes, and may be an error. A configuration has no
//!   `emit`; its octets are kept as they are.
//! - Reserved octets of Call and Initiate are not kept and emitted as 0.
//! - A PDU of [`acyclic`] with an unknown function number is an error, and so are access points that a PDU cannot have.
//!
//! "profibus-wire 2.3" and "errata-bpg-bcg-tpg 14" in the documentation of this crate are sections of the specification in
//! `docs/spec` of the repository, not crates.
//!
//! | Module | Holds | Reference |
//! |---|---|---|
//! | [`telegram`] | SD1, SD2, SD3, SD4, SC | profibus-wire 1.2 to 1.6 |
//! | [`control`] | the frame control octet | profibus-wire 1.4, 1.5 |
//! | [`ident`] | identification of a station | profibus-wire 1.11 |
//! | [`sap`] | service access points | profibus-wire 2.1 |
//! | [`diag`], [`prm`], [`mod@cfg`], [`global`], [`address`] | the DP-V0 data units | profibus-wire 2.3 to 2.11 |
//! | [`ext_diag`] | the blocks of an extended diagnosis | profibus-wire 2.3.1, 2.3.2 |
//! | [`acyclic`] | the DP-V1 PDUs of MS1 and MS2 | profibus-wire 4 and 5 |
//!
//! ```
//! use profivac_wire::{Telegram, control::Control};
//!
//! // Master 2 requests the diagnosis of slave 8: Slave_Diag, profibus-wire 2.3.
//! let octets = [0x68, 5, 5, 0x68, 0x88, 0x82, 0x6D, 0x3C, 0x3E, 0xF1, 0x16];
//! let Ok(Telegram::Data(request)) = Telegram::parse(&octets) else { panic!("expected a data telegram") };
//! assert_eq!((request.da, request.sa, request.dsap), (8, 2, Some(60)));
//! assert!(matches!(request.control(), Control::Request { .. }));
//!
//! let mut out = [0; profivac_wire::MAX_TELEGRAM];
//! let length = Telegram::Data(request).emit(&mut out)?;
//! assert_eq!(out.get(..length), Some(&octets[..]));
//! # Ok::<(), profivac_wire::TooLong>(())
//! ```
//!
//! # Features
//!
//! The crate is `no_std` without an allocator and has no default features. `defmt` derives `defmt::Format` for the public
//! types.
#![no_std]
#![warn(missing_docs, clippy::indexing_slicing, clippy::arithmetic_side_effects)]

pub mod acyclic;
pub mod address;
pub mod cfg;
pub mod control;
pub mod diag;
pub mod ext_diag;
#[cfg(feature = "defmt")]
mod format;
pub mod global;
pub mod ident;
mod octets;
pub mod prm;
pub mod sap;
pub mod telegram;

#[cfg(test)]
mod testing;

/// The example of the README runs as a test.
#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct Readme;

pub use octets::{Reader, TooLong, TooShort, Writer};
pub use sap::Sap;
pub use telegram::{
    BROADCAST, DataTelegram, MAX_DU, MAX_TELEGRAM, Telegram, TelegramError, TelegramLength, emit_sd2_with,
};
