//! Pump-downs in what was recorded: where they begin and end, and what a vacuum engineer wants to know about one.
//!
//! Pure functions over samples; nothing here reads a file or knows a unit other than Pa and seconds.
//!
//! | Module | Holds |
//! |---|---|
//! | [`mod@trace`] | the samples of a gauge in a span, as pieces of one quality |
//! | [`mod@find`] | the pump-downs there are |
//! | [`mod@passage`] | when a pressure was reached |
//! | [`mod@speed`] | how fast the pressure falls |
//! | [`mod@tail`] | the slope at the end |
//! | [`mod@rises`] | rises within a pump-down |

pub mod crossing;
pub mod final_slope;
pub mod find;
pub mod rises;
pub mod speed;
pub mod trace;

#[cfg(test)]
mod tests;

pub use crossing::{Crossing, crossing};
pub use final_slope::{FinalSlope, final_slope};
pub use find::{PumpDown, TimeRange, find, select};
pub use rises::{PressureRise, pressure_rises};
pub use speed::{Fall, falls, quickest};
pub use trace::{Section, Trace};
