#![doc = include_str!("../README.md")]
//!
//! ## Modules
//!
//! | Module | Holds | Reference |
//! |---|---|---|
//! | [`link`] | bit times, the receiver, addresses, frame count bits, the token ring | profibus-wire 1 |
//! | [`slave`] | the services of a passive DP station | profibus-wire 2 to 5 |
//! | [`master`] | a master and its slaves, acyclic services of both classes | profibus-wire 2 to 6 |
//!
//! Modules depend downwards only: `slave` and `master` use `link`, and neither knows the parameters of a device.
#![no_std]
#![warn(missing_docs, clippy::indexing_slicing, clippy::arithmetic_side_effects)]

pub mod link;
pub mod master;
pub mod slave;
