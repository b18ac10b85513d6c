//! Records samples, spans, events, alarms and the audit trail in one SQLite database that survives a power cut.
//!
//! ```text
//! push ── ring buffer ── deadband ── sample ┐
//!    └─────────────────────────────── span ─┤ one transaction a second, or at once for events and alarms
//! event, alarms, audit ─────────────────────┘
//! ```
//!
//! Beside the database SQLite keeps its log (`-wal`, `-shm`) while it is open. The recorder keeps the lock file `-lock`, so that no
//! other station writes to the database; this file may remain.
//!
//! Times are microseconds since 1970 (UTC), pressures are in Pa. A sample without a pressure has `None`, and its quality says why.
//!
//! A [`Point`] of a slave has values in its own unit. They take the same way, in tables of their own.

/// The example of the README, as a doctest.
#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct Readme;

pub mod alarms;
pub mod audit;
pub mod backup;
pub mod batch;
pub mod check;
pub mod clock;
mod connection;
pub mod database;
pub mod deadband;
pub mod error;
pub mod export;
mod lock;
pub mod outbox;
#[cfg(feature = "parquet")]
pub mod parquet;
pub mod point;
pub mod quality;
pub mod reader;
pub mod recorded;
pub mod retention;
pub mod ring;
pub mod sample;
pub mod schema;
pub mod spans;
pub mod state;
pub mod summary;
pub mod trend;
pub mod validity;
pub mod writer;

pub use check::Check;
pub use clock::{Clock, SystemClock};
pub use database::Retention;
pub use deadband::Deadband;
pub use error::{AuditError, DatabaseError};
pub use export::{Chunk, Chunks, Export, Exported};
pub use lock::is_in_use;
pub use outbox::Forward;
pub use point::{CodeText, DescribedPoint, Point, PointKind, PointSample, PointSummary};
pub use profivac_model::{AuditAction, AuditEntry, Event, EventKind};
pub use quality::{Qualities, Quality};
pub use reader::{Occurrence, Occurrences, Reader, Span};
pub use sample::{Micros, Sample};
pub use state::{LastCheck, StationState};
pub use trend::{PointTrend, Trend};
pub use writer::{Health, Load, Recorder, Settings, Unwritten, WriteReceipt};
