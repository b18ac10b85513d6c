//! What was on a line, told in words.
pub mod frame;
pub mod input;
pub mod printed;
