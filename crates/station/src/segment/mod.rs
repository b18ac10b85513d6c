//! A segment: a thread that owns a port and a master, and shares nothing with other segments but the station's services.
//! Below `edge` no code asks the system for the time, so tests run a segment in virtual time.
//!
//! ```text
//! Waiting ── port opens ── Running ── gauges are searched, parameterised, sampled ──┐
//!    ▲                       ▲ └──────────── serve, sample, answer requests ────────┤
//!    └── port is lost ───────┴──────────────────────────────────────────────────────┘
//!        (growing pauses)
//! ```
//!
//! | Module | Holds |
//! |---|---|
//! | `find` | the search for a gauge at its address |
//! | `first_round` | the time after the first opening of a port in which a gauge is not missed yet |
//! | `runner` | what both kinds of segment do: open, serve, pause, open again, reconfigure, publish, stop |
//! | `polled_line` | the line of a segment that a master of the station polls |
//! | `heard_line` | the line of a segment on which the station only listens |
//! | `polled_gauge` | a gauge that is polled: search, data exchange, samples |
//! | `heard_gauge` | a gauge of another master: samples |
//! | `shown_gauge` | what both show and record |
//! | `loss` | why a slave of the station's master gives no data |
//! | `slave` | a slave by its GSD file: its points and its diagnosis |
//! | `allowance` | a limit for the events of such a slave |
//! | `edge`, `moment` | the time, ports and commands from outside |
//! | `readings` | the readings of a gauge, from the values in its inputs |
//! | `execute` | preview and execution of an operation |
//! | `records` | the access to the records of a slave: MS2 or the parameter channel |
//! | `requests` | reading the parameters of a gauge |
//! | `planned` | the segments of a file before they start |
//! | `inbox` | the requests of users to a segment, and their order |
//! | `watched` | the parameters that gateways show beside the pressures |
//! | `bus_map` | the stations on the bus |
//! | `line_observer` | live list, statistics and flight recorder of a line |
//! | [`handle`] | starts, reconfigures and stops the thread |
//! | [`demo_segment`] | a segment in memory |

mod allowance;
mod bus_map;
pub mod demo_segment;
mod edge;
mod execute;
mod find;
mod first_round;
pub mod handle;
mod heard_gauge;
mod heard_line;
mod inbox;
mod line_observer;
mod loss;
mod moment;
mod planned;
mod polled_gauge;
mod polled_line;
mod readings;
mod records;
mod requests;
mod runner;
mod services;
mod shown_gauge;
mod slave;
#[cfg(test)]
mod virtual_time;
mod watched;

pub use demo_segment::DemoSegment;
pub use handle::SegmentHandle;
pub use planned::planned_segments;
pub use polled_gauge::{planned_parameters, planned_readings};
pub use readings::corrected;
pub use services::SegmentServices;
