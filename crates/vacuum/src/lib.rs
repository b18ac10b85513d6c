//! Vacuum as it is: chambers, gases, pumps, and what sensors make of them.
//!
//! Pressures are in Pa, volumes in m³, gas flows in Pa m³/s, conductances and pumping speeds in m³/s, temperatures in K,
//! times in s, whatever a scenario or a screen shows.
//!
//! | Module | Holds |
//! |---|---|
//! | [`gas`] | gases and mixtures |
//! | [`atmosphere`] | the air outside |
//! | [`conductance`] | tubes, openings, leaks |
//! | [`pump`] | roughing and turbomolecular pumps |
//! | [`surface`] | walls that give off gas |
//! | [`sensor`] | what sensors make of the gas |
//! | [`network`] | a plant of all these, and its time |

pub mod atmosphere;
pub mod conductance;
pub mod gas;
pub mod network;
pub mod pump;
pub mod sensor;
mod series;
pub mod surface;

pub use atmosphere::Atmosphere;
pub use conductance::Conductance;
pub use gas::{Gas, Mixture};
pub use network::Network;
