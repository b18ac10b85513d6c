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
mod cathode;
pub mod codes;
mod device;
mod exceptions;
mod fitted;
mod hysteresis;
mod parameter_access;
mod parameter_channel;
mod parameters;
mod part;
mod presentation;
mod set_point;
mod simulation;
mod state_machine;

pub use behaviour::Behaviour;
pub use cathode::{Cathode, CathodeConditions, EmissionCurrent, Thresholds};
pub use device::{BlockDevice, SerialNumber, Setup};
pub use exceptions::{CommonExceptions, ExceptionDetails, ExceptionStatus, exception_status};
pub use fitted::FittedChannels;
pub use hysteresis::switched;
pub use parameter_access::{ParameterAccess, ParameterRef};
pub use part::{MeasuringPart, ReadingCondition, SafeState, Sensor, StatusExtension};
pub use presentation::Presentation;
pub use set_point::{HYSTERESIS, Potentiometer, SetPoint};
pub use state_machine::{DeviceState, SelfTestResult, StateEvent, StateMachine, TRANSITIONS, Transition};
