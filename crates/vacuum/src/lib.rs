//! Vacuum as it is: chambers, gases, pumps, and what sensors make of them.
//!
//! Pressures are in Pa, volumes in m³, gas flows in Pa m³/s, conductances and pumping speeds in m³/s, temperatures in K,
//! times in s, whatever a scenario or a screen shows.

pub mod gas;
pub mod sensor;

pub use gas::{Gas, Mixture};
