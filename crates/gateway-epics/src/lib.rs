//! The points of a station as process variables of EPICS, over Channel Access and PV Access. Clients read and
//! monitor; where the file permits it they write parameters, send commands and acknowledge alarms.
//!
//! ```text
//! snapshots ── publisher ──▶ world (records, values) ──▶ connections: Channel Access, PV Access
//! ```

pub mod ca;
pub mod connection;
pub mod database;
pub mod field;
pub mod listing;
pub mod names;
pub mod put;
pub mod pva;
pub mod record;
pub mod server;
pub mod socket;

pub use names::{NameError, Row};
pub use server::{EpicsError, start};
