#![doc = include_str!("../README.md")]

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
