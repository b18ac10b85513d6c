#![doc = include_str!("../README.md")]
//!
//! ## Modules
//!
//! | Module | Holds |
//! |---|---|
//! | [`observer`] | the [`Observer`]: telegrams and damaged pieces to the state of the line |
//! | [`station`] | the state of one station, and how its place in the live list is decided |
//! | [`counts`], [`histogram`] | counters with their last minute, durations in fixed buckets |
//! | [`gauge`] | model, configuration and unit of a slave with their origins, and its pressures |
//! | [`parameters`] | parameters that pass in the parameter channel, on MS1 and on MS2 |
//! | [`event`] | changes, as data with a text |
//! | [`report`] | the state of the line as text and numbers |
//! | [`flight`] | the last traffic in memory, and captures of it on disk |

pub mod counts;
pub mod event;
pub mod flight;
pub mod gauge;
pub mod histogram;
#[cfg(test)]
#[allow(clippy::indexing_slicing, clippy::expect_used, reason = "this is test code")]
mod hostile;
pub mod observer;
pub mod parameters;
pub mod report;
pub mod station;

pub use observer::Observer;
pub use profivac_explain::divider::Divider;
pub use profivac_explain::frame::{Chunk, Piece, TimeSource};
pub use profivac_explain::tap::{Tap, TapEvent};
pub use profivac_sim::describe::Hex;
pub use profivac_wire::MAX_TELEGRAM;
