//! What a device is, in tables: blocks and their rows, cyclic telegrams, units, codes. No behaviour.
//!
//! Everything outside that wants to know a device (a master by name, a GSD file, a page of documentation) reads a
//! [`Model`].

pub(crate) mod access;
pub(crate) mod block;
pub(crate) mod codes;
mod cyclic;
mod device;
mod instance;
mod pressure;
mod refusal;
pub(crate) mod value;

pub use access::{Access, Direction, Via};
pub use block::{Address, Block, Parameters, Place, Row, Storage};
pub use codes::{Code, Codes, Need, code};
pub use cyclic::{Configuration, Field, Telegram};
pub(crate) use cyclic::{configuration, telegram};
pub(crate) use device::faults;
pub use device::{Dialect, FaultList, Gsd, Instruction, Model, UserPrm};
pub use instance::{Facts, Limits, Range, Shows};
pub use pressure::{Counts, Format, NumberType, Scale, Unit, mbar};
pub use refusal::Refusal;
pub use value::{DataType, Octets, Value, put};
