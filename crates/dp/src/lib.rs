//! PROFIBUS DP stations without I/O, clock or allocation.
//!
//! A station is a state machine: telegrams and a time in bit times go in, at most one telegram and the next deadline come
//! out ([`link::Station`]). The same machine runs on a microcontroller, behind a serial port and on a simulated bus.
//!
//! | Module | Knows | Reference |
//! |---|---|---|
//! | [`link`] | bit times, addresses, frame count bits | profibus-wire 1 |
//! | [`slave`] | the services of a passive DP station | profibus-wire 2 to 5 |
//! | [`master`] | a master and its slaves, acyclic services of both classes | profibus-wire 2 to 6 |
//!
//! Modules depend downwards only: `slave` and `master` use `link`, and neither knows what a parameter is.
#![no_std]
#![warn(clippy::indexing_slicing, clippy::arithmetic_side_effects)]

pub mod link;
pub mod master;
pub mod slave;
