#![doc = include_str!("../README.md")]
//!
//! # Modules
//!
//! | Module | Holds |
//! |---|---|
//! | [`bus`] | [`Bus`] and [`BusBuilder`]: open a port and become a master on it |
//! | [`async_bus`] | [`AsyncBus`]: the same from several threads, and in any async runtime |
//! | [`gauge`] | [`Gauge`]: pressure, parameters, commands |
//! | [`names`] | parameters by the words or numbers of the manual |
//! | [`values`] | values as text, and their octets |
//! | [`pressure`] | [`Pressure`] with its units |
//! | [`conditions`] | the conditions of a command |
//! | [`settings`] | the settings of a gauge as a file; compare and restore |
//! | [`cyclic`] | the cyclic data of a slave |
//! | [`discover`] | finds out how to exchange data with a slave |
//! | [`identify`] | the model of the device at an address |
//! | [`address`] | a new station address for a slave |
//! | [`gsd`] | the GSD file of a device |
//! | [`st`] | function blocks for a PLC, in structured text |
//! | [`records`] | records of a slave, independent of the service |
//! | [`ms2`] | records over MS2 |
//! | [`class1`] | records over MS1 and the parameter channel |
//! | [`suggestion`] | suggestions for mistyped names |
//! | `error` | [`ClientError`]: address, parameter, reason and advice |

pub mod address;
pub mod async_bus;
pub mod bus;
pub mod class1;
pub mod cyclic;
pub mod discover;
mod error;
pub mod gauge;
pub mod gsd;
pub mod identify;
pub mod ms2;
pub mod names;
pub mod pressure;
pub mod records;
#[cfg(feature = "settings")]
pub mod settings;
pub mod st;
pub mod suggestion;
pub mod values;

pub use async_bus::{AsyncBus, AsyncGauge, Pending};
pub use bus::{Bus, BusBuilder};
pub use error::{
    AccessReason, Advice, ClientError, FoundPressure, Operation, ParameterContext, PressureLimit, TypedError, Unmet,
};
pub use gauge::conditions::{self, Condition};
pub use gauge::{Defects, Gauge, ParameterReading, PreparedWrite, WriteResult};
pub use pressure::Pressure;
pub use records::ErrorKind;
