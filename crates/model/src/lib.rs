//! What a station records, shows and publishes: qualities, events, alarms and the audit trail.
//!
//! Each thing has one declaration, which gives its Rust type, its words in the database and in the API, its JSON and, with the feature
//! `openapi`, its schema. The recorder stores these types, the station and the archive send them, the gateways publish them.
//!
//! In JSON a time is in whole milliseconds since 1970 (UTC), and a property without a value is `null`.

// The types keep the attributes of the schemas, which expand to nothing then (docs/decisions, 426).
#[cfg(not(feature = "openapi"))]
extern crate profivac_no_openapi as utoipa;

pub mod alarm;
pub mod alarm_state;
pub mod audit;
pub mod event;
pub mod micros;
pub mod point;
pub mod quality;
pub mod words;

pub use alarm::{
    AlarmChangeKind, AlarmHistoryEntry, AlarmStatus, Attribution, ConditionKind, Declaration, Priority, Suppression,
};
pub use alarm_state::{AlarmInput, AlarmState};
pub use audit::{AuditAction, AuditEntry, Role};
pub use event::{Event, EventKind};
pub use micros::Micros;
pub use point::PointKind;
pub use profivac_devices::Principle;
pub use profivac_devices::reading::Quality;
pub use words::{Word, Words};
