#![doc = include_str!("../README.md")]
#![warn(missing_docs)]

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
