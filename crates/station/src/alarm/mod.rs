//! Alarms after ISA-18.2 (IEC 62682).
//!
//! ```text
//! snapshots ─ Inputs ─ Evaluator ─ condition met? ─ delays ─ AlarmState ─ AlarmChange ─┬─ database: state, history, an event
//!                               acknowledge, out of service, plant state ──────────────┘└─ notifications for webhooks
//! ```
//!
//! The state table is `AlarmState::after` in the crate `model`.
//!
//! | Module | Holds |
//! |---|---|
//! | [`plant_state`] | plant states that users declare, and which alarms each suppresses |
//! | [`rule`] | the condition of an alarm, its priority and its delays |
//! | [`evaluate`] | whether a condition is met |
//! | [`registry`] | all alarms, without clock, thread and disk: times and inputs come in, changes go out |
//! | [`persistence`] | the rows, events and notifications of a change |
//! | [`notify`] | which notification target is told of which change |
//! | [`view`] | alarms as the API shows them |
//! | [`performance`] | figures: how many alarms, how often, which |
//! | [`limits`] | the reasons and times that the station accepts |
//! | [`service`] | the alarms of a running station, shared by its threads |
//! | [`suppression`] | the present time on both clocks |
//! | [`thread`] | the thread that evaluates |

pub mod evaluate;
pub mod limits;
pub mod notify;
pub mod performance;
pub mod persistence;
pub mod plant_state;
pub mod registry;
pub mod rule;
pub mod service;
pub mod suppression;
pub mod thread;
pub mod view;

pub use evaluate::Inputs;
pub use limits::{MAX_SHELVED_MINUTES, ReasonError, SHELVED, checked_reason};
pub use notify::{NotificationTarget, QuietHours};
pub use persistence::SettingsChange;
pub use plant_state::{PlantStateError, PlantStateRule};
pub use profivac_model::{
    AlarmChangeKind, AlarmState, AlarmStatus, Attribution, ConditionKind, Declaration, Priority, Suppression,
};
pub use registry::{AlarmChange, AlarmError, AlarmRegistry};
pub use rule::{BusQuantity, Condition, PointTest, Rule, Series};
pub use service::{AlarmResult, AlarmService, AlarmServiceError, PlantStateServiceError};
pub use suppression::AlarmTime;
pub use thread::AlarmThread;
