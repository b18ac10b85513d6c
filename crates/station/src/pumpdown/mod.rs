//! Pump-downs in recorded samples: their time ranges and their characteristic numbers.
//!
//! Pure functions over samples, in Pa and seconds. Nothing here reads a file.
//!
//! | Module | Holds |
//! |---|---|
//! | [`mod@time_range`] | time ranges |
//! | [`mod@trace`] | the samples of a series, as sections of one quality |
//! | [`mod@find`] | the search for pump-downs |
//! | [`mod@crossing`] | the time at which a pressure was reached |
//! | [`mod@speed`] | the rate at which the pressure falls |
//! | [`mod@final_slope`] | the slope at the end |
//! | [`mod@rises`] | rises within a pump-down |
//! | [`mod@compare`] | pump-downs beside the usual ones |
//! | [`mod@excess`] | the pressure above the usual one |

pub mod compare;
pub mod crossing;
pub mod excess;
pub mod final_slope;
pub mod find;
pub mod rises;
pub mod speed;
pub mod time_range;
pub mod trace;

#[cfg(test)]
mod tests;

pub use crossing::{Crossing, crossing};
pub use final_slope::{FinalSlope, final_slope};
pub use find::{PumpDown, find, select};
pub use rises::{PressureRise, pressure_rises};
pub use speed::{Fall, falls, quickest};
pub use time_range::TimeRange;
pub use trace::{Section, Trace};
