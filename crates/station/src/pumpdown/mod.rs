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

pub mod find;
pub mod passage;
pub mod rises;
pub mod speed;
pub mod tail;
pub mod trace;

#[cfg(test)]
mod tests;

pub use find::{Chosen, Span, chosen, find};
pub use passage::{Passage, passage};
pub use rises::{Climb, climbs};
pub use speed::{Fall, falls, quickest};
pub use tail::{Tail, tail};
pub use trace::{Piece, Trace};
