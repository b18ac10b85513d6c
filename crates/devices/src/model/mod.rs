//! The tables of a device: blocks and their rows, cyclic telegrams, units, codes. No behaviour.
//!
//! Clients, GSD files and the pages of the documentation read a [`Model`].

#[doc(hidden)]
pub mod access;
mod access_error;
mod alarm_words;
mod block;
#[doc(hidden)]
pub mod block_macros;
#[doc(hidden)]
pub mod code_table;
#[doc(hidden)]
pub mod codes;
mod cyclic;
mod device;
mod fault;
pub(crate) mod log;
mod octets;
mod part_spec;
mod pressure;
#[doc(hidden)]
pub mod role;
pub(crate) mod typed;
#[doc(hidden)]
pub mod value;

pub use access::{Access, AccessPath, Direction};
pub use access_error::AccessError;
pub use alarm_words::{AlarmBit, AlarmWords};
pub use block::{Block, Location, ParameterSet, PlacedBlock, Row, RowTexts, Storage, text};
pub use code_table::{CodeTable, UnknownCode};
pub use codes::{Code, Codes, Precondition, Quantity, code};
pub use cyclic::{
    Configuration, CyclicValue, Field, MAX_COMMANDS, MAX_IMAGE, Telegram, announces, configuration, is_short,
    octets_of, telegram,
};
pub(crate) use device::DESCRIBED;
pub use device::{ChannelRules, Gsd, Model, TaskKind, UserPrm};
#[doc(hidden)]
pub use fault::faults;
pub use fault::{Fault, FaultList};
pub use octets::Octets;
pub use part_spec::{Clipping, Limits, MeasuringRange, Part, PartSpec, Principle, RangeStatus};
pub use pressure::{Counts, HeldPressure, INTEGER16_MAX, NumberType, PressureFormat, Scale, Unit, mbar};
pub use role::Role;
pub use typed::{ParameterValue, Pascal, TypedParameter};
pub use value::{DataType, Length, LengthError, RawValue, Value, command_code};
