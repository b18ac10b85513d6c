//! Alarms after ISA-18.2 (IEC 62682): what is watched, where it stands, who knows.
//!
//! ```text
//! plant ─ Sight ─ Judge ─ holds? ─ delays ─ State ─ Change ─┬─ the record: where it stands, its history, an event
//!                                    people ───────────────┘└─ letters to webhooks
//! ```
//!
//! | Module | Holds |
//! |---|---|
//! | [`state`] | the table of states |
//! | [`rule`] | what is watched, and when it is an alarm |
//! | [`judge`] | whether a condition holds |
//! | [`book`] | all alarms, pure: time and sight come in, changes go out |
//! | [`paper`] | what is written of them: rows, events, letters |
//! | [`desk`] | the alarms of a running station, shared by its threads |
//! | [`watcher`] | the thread that looks |
//! | [`view`] | alarms as the API has them |

pub mod evaluate;
pub mod persistence;
pub mod registry;
pub mod rule;
pub mod service;
pub mod state;
pub mod thread;
pub mod view;

pub use evaluate::Inputs;
pub use persistence::NotificationTarget;
pub use registry::{
    AlarmChange, AlarmError, AlarmRegistry, AlarmStatus, AlarmTime, Attribution, ChangeKind, OutOfService,
};
pub use rule::{Condition, Priority, Rule, Subject};
pub use service::{AlarmService, AlarmServiceError};
pub use state::AlarmState;
pub use thread::AlarmThread;
