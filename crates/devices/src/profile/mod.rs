//! The features that block devices share: access to parameters, parameter channel, state machine, exceptions, measuring
//! parts.
//!
//! | Module | Contents |
//! |---|---|
//! | `behaviour`, `parameter_access` | the interface of a device ([`Behaviour`], [`ParameterAccess`]) |
//! | `device`, `simulation` | the device on the bus and in a simulation ([`BlockDevice`]) |
//! | [`beside`] | a device that works beside its slave |
//! | `parameters` | the access to parameters, and their storage |
//! | `parameter_channel`, `channel_service` | the eight octets of the parameter channel, and its tasks |
//! | `device_block`, `analog_input` | the rows that the blocks of several devices share |
//! | `address` | address switch and Set_Slave_Add |
//! | [`codes`] | code tables that all manuals share |
//! | `state_machine` | the device states, as a table |
//! | `exceptions` | Exception Status and its records |
//! | `fitted` | the channels of a controller that have a gauge |
//! | `presentation` | unit and number type |
//! | `hysteresis` | a switch with two thresholds |
//! | `part` | a measuring part: sensor, validity, safe state |
//! | `cathode` | emission and degas of a hot cathode |
//! | `set_point` | a relay with a potentiometer |
//! | `transition` | the transition command of the cyclic outputs |

mod address;
mod analog_input;
mod behaviour;
pub mod beside;
mod cathode;
mod channel_service;
pub mod codes;
mod device;
mod device_block;
mod exceptions;
mod fitted;
mod hysteresis;
#[cfg(feature = "texts")]
mod kept_row;
mod parameter_access;
mod parameter_channel;
mod parameters;
mod part;
mod presentation;
mod set_point;
mod simulation;
mod state_machine;
mod transition;

pub use analog_input::InputRow;
pub use behaviour::Behaviour;
pub use cathode::{Cathode, CathodeConditions, EmissionCurrent, Thresholds};
pub use device::{BlockDevice, SerialNumber, Setup};
pub use device_block::{DeviceBlockValues, DeviceRow, Identity};
pub use exceptions::{CommonExceptions, ExceptionDetails, ExceptionStatus, exception_status};
pub use fitted::FittedChannels;
pub use hysteresis::switched;
pub use parameter_access::{ParameterAccess, ParameterRef};
pub use part::{MeasuringPart, ReadingCondition, SafeState, Sensor, StatusExtension};
pub use presentation::Presentation;
pub use set_point::{HYSTERESIS, PotentiometerScale, RelaySetPoint};
pub use state_machine::{DeviceState, SelfTestResult, StateCommand, StateEvent, StateMachine, TRANSITIONS, Transition};
pub use transition::TransitionCommand;
