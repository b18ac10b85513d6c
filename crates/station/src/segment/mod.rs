//! A segment: a thread that owns a port and a master, and shares nothing with other segments but the station's services.
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
//! | `gauge_session` | a gauge: data exchange, samples |
//! | `readings` | the readings of a gauge, from the values in its inputs |
//! | `execute` | preview and execution of an operation |
//! | `records` | the access to the records of a slave: MS2 or the parameter channel |
//! | `requests` | reading the parameters of a gauge |
//! | `inbox` | the requests of users to a segment, and their order |
//! | `watched` | the parameters that gateways show beside the pressures |
//! | `bus_map` | the stations on the bus |
//! | `thread` | the thread |
//! | `listen_thread` | the thread of a segment on which the station only listens |
//! | `line_observer` | live list, statistics and flight recorder of a line |
//! | [`handle`] | starts, reconfigures and stops the thread |
//! | [`demo_segment`] | a segment in memory |

mod bus_map;
pub mod demo_segment;
mod execute;
mod find;
mod gauge_session;
pub mod handle;
mod inbox;
mod line_observer;
mod listen_thread;
mod readings;
mod records;
mod requests;
mod services;
mod thread;
mod watched;

pub use demo_segment::DemoSegment;
pub use gauge_session::{planned_gauge, planned_parameters, planned_readings};
pub use handle::SegmentHandle;
pub use readings::corrected;
pub use services::SegmentServices;
