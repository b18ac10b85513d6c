//! A PROFIBUS segment in bit times.
mod agenda;
mod bus;
pub mod character;
pub mod describe;
mod driver;
mod ear;
mod fault;
mod noise;
mod random;
mod referee;
pub mod scenario;
mod signal;
pub mod stations;
pub mod trace;

pub use bus::{Bus, Handle, Id};
pub use fault::{Fault, Mangle};
pub use noise::Noise;
pub use random::Random;
pub use referee::{Foul, Limits, Rule};
pub use signal::Tamper;
pub use trace::Trace;
