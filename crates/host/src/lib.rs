#![doc = include_str!("../README.md")]
//!
//! # Modules
//!
//! | Module | Holds |
//! |---|---|
//! | [`port`] | serial devices, ptys, TCP |
//! | [`mod@line`] | stations that share a line, without port and clock |
//! | [`timing`] | what a master measures on its port |
//! | [`segment`] | a line on a port, in real time |
//! | [`session`] | a master on a port that sends one request after the other |
//! | [`scan`] | the stations of a bus |
//! | [`rate`] | detects the baud rate of a line |
//! | [`readiness`] | waits for several sources, wakes a thread |
//! | [`clock`] | bit times on the monotonic clock |
//! | [`text_file`] | helpers for configuration files |

pub mod clock;
pub mod line;
pub mod port;
pub mod rate;
pub mod readiness;
pub mod scan;
pub mod segment;
pub mod session;
pub mod text_file;
pub mod timing;
