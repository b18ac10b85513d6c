//! What was measured and what happened, in one SQLite file that survives a power cut.
//!
//! ```text
//! push ── ring ── thinner ── sample ┐
//!    └─────────── roll-ups ─────────┤ one transaction a second, or at once for an event
//! event ────────────────────────────┘
//! ```
//!
//! | Module | Holds |
//! |---|---|
//! | [`sample`] | a pressure with its quality |
//! | [`thin`] | the dead band on the logarithm of pressure |
//! | [`ring`] | full rate around events |
//! | [`rollup`] | the levels in which long times are kept and drawn |
//! | [`store`] | the file: tables, transactions, retention |
//! | [`audit`] | who did what: rows that are only ever added |
//! | [`writer`] | the thread that owns the file |
//! | [`alarms`] | where alarms stand, their history, letters to webhooks |
//! | `lock` | where the file lies, and that nobody else records into it |
//! | `clock` | whether somebody has set the clock |
//! | [`reader`] | drawing and reading |
//! | [`export`] | all of it as CSV, piece by piece |
//!
//! Beside the file lie its log (`-wal`, `-shm`) while it is open, and `-lock`, which keeps other stations away and may stay.
//!
//! Times are microseconds since 1970 (UTC), pressures are in Pa. No number stands for "no value": a sample says of what
//! quality it is, and has no pressure where it has none.

pub mod alarms;
pub mod audit;
mod clock;
pub mod database;
pub mod deadband;
pub mod export;
mod lock;
pub mod reader;
pub mod ring;
pub mod sample;
pub mod spans;
pub mod writer;

pub use audit::{AuditAction, AuditEntry};
pub use database::{DatabaseError, Event, EventKind, Retention};
pub use deadband::Deadband;
pub use export::Export;
pub use reader::{Reader, Span};
pub use sample::{Micros, Qualities, Quality, Sample};
pub use writer::{Health, Recorder, Settings, WriteReceipt};
