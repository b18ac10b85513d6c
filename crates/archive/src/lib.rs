//! What many stations record, in PostgreSQL: the station sends the batches of its outbox to JetStream, the archive takes them from
//! there.
//!
//! ```text
//! database ── outbox ── publisher ──▶ JetStream ──▶ archive ── transaction ──▶ PostgreSQL
//!   station                          servers      any number of them
//! ```
//!
//! | Module | Holds |
//! |---|---|
//! | [`publisher`] | the station's part: batches to JetStream, acknowledgements to the database |
//! | [`config`] | the file of an archive |
//! | [`database`] | the connection to PostgreSQL |
//! | [`schema`] | tables, views and migrations of PostgreSQL |
//! | [`store`] | batches to rows, in transactions |
//! | [`service`] | the loop of an archive: take, store, acknowledge |
//! | `nats` | connections to the servers, names of subjects and messages |
//!
//! A batch may come twice, late, and out of order. Its rows have keys, so that storing it again changes nothing; a span of a later
//! batch replaces that of an earlier one. The acknowledgement follows the commit. Nothing else makes the effect exactly once.

pub mod config;
pub mod database;
mod nats;
pub mod publisher;
pub mod schema;
pub mod service;
pub mod store;

pub use nats::NatsError;
