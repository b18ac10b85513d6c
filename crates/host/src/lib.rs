//! Stations on the ports of a computer.
//!
//! | Module | Holds |
//! |---|---|
//! | [`port`] | serial devices, ptys, TCP: octets in and out, errors in one sentence |
//! | [`mod@line`] | stations that share a line, without port and clock |
//! | [`segment`] | a line on a port, in real time |
//! | [`client`] | a gauge by name: parameters, values, commands, settings |
//! | [`segment_file`] | a segment in memory, described by a file |
//! | [`mod@open`] | ports as people name them |
//! | [`rate`] | the rate of a line, found by listening |
//! | [`live`] | who is on a bus |
//! | [`ms2`] | a record, as a class 2 master reads it |
//! | [`watch`] | a slave to be watched, and what its inputs say |
//! | [`tool`] | a master on a port that asks one thing after the other |
//! | [`clock`] | bit times on the monotonic clock |
//! | [`mod@bench`] | virtual devices: power, pressure, faults |
//! | [`conform`] | whether a slave keeps the rules |
//! | [`explain`] | what was on a line, told in words |
//! | [`gsd`] | GSD files from their tables |
//! | [`instrument`] | devices by name, as a command line has them |
//! | [`scenario`] | a plant, its gauges, what happens, and what has to come of it |
//! | [`scene`] | a whole segment in memory |
//! | [`memory`] | their nonvolatile memory, in a file that survives a power cut |
//! | [`text_file`] | what files that people write have in common |
//! | [`pressure`] | pressures as people write them |

pub mod bench;
pub mod client;
pub mod clock;
pub mod conform;
pub mod explain;
pub mod gsd;
pub mod instrument;
pub mod line;
pub mod live;
pub mod memory;
pub mod ms2;
pub mod open;
pub mod port;
pub mod pressure;
pub mod rate;
pub mod scenario;
pub mod scene;
pub mod segment;
pub mod segment_file;
pub mod text_file;
pub mod tool;
pub mod watch;
