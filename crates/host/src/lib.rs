//! Ports, lines and clocks of a computer: everything that touches the operating system, and nothing else.
//!
//! | Module | Holds |
//! |---|---|
//! | [`port`] | serial devices, ptys, TCP: octets in and out |
//! | [`mod@line`] | stations that share a line, without port and clock |
//! | [`segment`] | a line on a port, in real time |
//! | [`clock`] | bit times on the monotonic clock |
//! | [`rate`] | the baud rate of a line, found by listening |
//! | [`session`] | a master on a port that sends one request after the other |
//! | [`scan`] | the stations that answer on a bus |
//! | [`text_file`] | what configuration files have in common |

pub mod clock;
pub mod line;
pub mod port;
pub mod rate;
pub mod readiness;
pub mod scan;
pub mod segment;
pub mod session;
pub mod text_file;
