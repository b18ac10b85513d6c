//! What block devices share: access to parameters, parameter channel, state machine, exceptions, safe state, address.
//!
//! | Module | Knows |
//! |---|---|
//! | `behaviour` | what a device must say for itself ([`Behaviour`]) |
//! | `device`, `bench` | the bus and the bench around it ([`BlockDevice`]) |
//! | `parameters` | the one access to parameters, and their storage |
//! | `channel` | the eight octets of the parameter channel |
//! | `machine` | the device state machine, as a table |
//! | `exceptions` | Exception Status and its records |
//! | `fitted` | which channels of a controller have a gauge |
//! | `part` | a measuring part: sensor, limits, safe state |
//! | `address` | address switch and Set_Slave_Add |

mod address;
mod behaviour;
mod bench;
mod channel;
mod device;
mod exceptions;
mod fitted;
mod machine;
mod parameters;
mod part;

pub use behaviour::{At, Behaviour};
pub use device::{BlockDevice, Serial, Setup};
pub use exceptions::{Common, Details, ExceptionStatus, exception_status};
pub use fitted::Fitted;
pub use machine::{Event, Health, Machine, State, TRANSITIONS, Transition};
pub use part::{Facts, Limits, MeasuringPart, Range, SafeState, Sensor, StatusExtension};
