//! What block devices share: access to parameters, parameter channel, state machine, exceptions, measuring parts.
//!
//! | Module | Knows |
//! |---|---|
//! | `blocks`, `behaviour` | what a device must say for itself ([`Blocks`], [`Behaviour`]) |
//! | `device`, `bench` | the bus and the bench around it ([`BlockDevice`]) |
//! | `parameters` | the one access to parameters, and their storage |
//! | `channel` | the eight octets of the parameter channel |
//! | `address` | address switch and Set_Slave_Add |
//! | [`codes`] | code tables that all manuals share |
//! | `machine` | the device state machine, as a table |
//! | `exceptions` | Exception Status and its records |
//! | `fitted` | which channels of a controller have a gauge |
//! | `presentation` | unit and number type |
//! | `hysteresis` | a switch with two thresholds |
//! | `part` | a measuring part: sensor, validity, safe state |
//! | `cathode` | emission and degas of a hot cathode |
//! | `set_point` | a relay with a potentiometer |

mod address;
mod behaviour;
mod bench;
mod blocks;
mod cathode;
mod channel;
pub mod codes;
mod device;
mod exceptions;
mod fitted;
mod hysteresis;
mod machine;
mod parameters;
mod part;
mod presentation;
mod set_point;

pub use behaviour::Behaviour;
pub use blocks::{At, Blocks};
pub use cathode::{Cathode, Conditions, Current, Thresholds};
pub use device::{BlockDevice, Serial, Setup};
pub use exceptions::{Common, Details, ExceptionStatus, exception_status};
pub use fitted::Fitted;
pub use hysteresis::switched;
pub use machine::{Event, Health, Machine, State, TRANSITIONS, Transition};
pub use part::{Condition, MeasuringPart, SafeState, Sensor, StatusExtension};
pub use presentation::Presentation;
pub use set_point::{HYSTERESIS, Potentiometer, SetPoint};
