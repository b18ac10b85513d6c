//! The points of a station as process variables of EPICS, over Channel Access and PV Access. Clients read and
//! monitor; where the file permits it they write parameters, send commands and acknowledge alarms.
//!
//! ```text
//! snapshots ── publisher ──▶ world (records, values) ──▶ connections: Channel Access, PV Access
//! ```
//!
//! | Module | Holds |
//! |---|---|
//! | [`record`] | records and samples |
//! | [`names`] | the names of records |
//! | [`field`] | the fields of a record |
//! | [`database`] | the records of a station, and what they read |
//! | [`socket`] | sockets |
//! | [`connection`] | a connection, for both protocols |
//! | [`put`] | puts of clients, where the file permits them |
//! | [`ca`] | Channel Access |
//! | [`pva`] | PV Access |
//! | [`listing`] | lists for `profivac names`, the Archiver Appliance and Phoebus |
//! | [`server`] | all sockets of the gateway |

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
