#![doc = include_str!("../README.md")]
#![warn(missing_docs)]

pub mod clock;
pub mod keep_alive;
pub mod line;
pub mod port;
pub mod rate;
pub mod readiness;
pub mod scan;
pub mod segment;
pub mod session;
pub mod text_file;
pub mod timing;
