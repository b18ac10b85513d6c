//! A physical model of vacuum plants: chambers, gases, pumps, walls and the sensors of gauges.
//!
//! Units: pressures in Pa, volumes in m³, gas flows in Pa m³/s, conductances and pumping speeds in m³/s, temperatures in K,
//! times in s. Scenarios and displays convert to other units.
//!
//! ```
//! use profivac_vacuum::pump::Roughing;
//! use profivac_vacuum::{Atmosphere, Network};
//!
//! // A chamber of 100 l with a pump of 60 l/s: after ten minutes the pressure is below 1 Pa.
//! let air = Atmosphere::default();
//! let mut plant = Network::new(air);
//! let chamber = plant.add_volume(0.1, air.mixture());
//! plant.add_roughing_pump(chamber, Roughing::dry(0.06, 0.1));
//! plant.advance(600.0);
//! assert!(plant.mixture(chamber).total() < 1.0);
//! ```

pub mod atmosphere;
pub mod conductance;
pub mod gas;
pub mod network;
pub mod permeation;
pub mod pump;
pub mod sensor;
mod series;
pub mod surface;

pub use atmosphere::Atmosphere;
pub use conductance::Conductance;
pub use gas::{Gas, Mixture};
pub use network::Network;

/// The example of the README runs as a test.
#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct Readme;
