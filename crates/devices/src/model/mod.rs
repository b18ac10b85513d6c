//! What a device is, in tables: blocks and their rows, cyclic telegrams, units, codes. No behaviour.
//!
//! Everything outside that wants to know a device (a master by name, a GSD file, a page of documentation) reads a
//! [`Model`].

pub(crate) mod access;
mod access_error;
pub(crate) mod block;
pub(crate) mod codes;
mod cyclic;
mod device;
mod part_spec;
mod pressure;
pub(crate) mod value;

pub use access::{Access, AccessPath, Direction};
pub use access_error::AccessError;
pub use block::{Block, Location, ParameterSet, PlacedBlock, Row, Storage};
pub use codes::{Code, Codes, Precondition, code};
pub use cyclic::{Configuration, Field, Telegram};
pub(crate) use cyclic::{configuration, telegram};
pub(crate) use device::faults;
pub use device::{ChannelRules, FaultList, Gsd, Model, TaskKind, UserPrm};
pub use part_spec::{Clipping, Limits, PartSpec, RangeStatus};
pub use pressure::{Counts, NumberType, PressureFormat, Scale, Unit, mbar};
pub use value::{DataType, Octets, Value, put};
