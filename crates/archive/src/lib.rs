//! What many stations record, in PostgreSQL: the station sends the batches of its outbox to JetStream, the archive takes them from
//! there.
//!
//! ```text
//! database ── outbox ── publisher ──▶ JetStream ──▶ archive ── transaction ──▶ PostgreSQL
//!   station                 │        servers      any number of them
//!                           └──────── HTTPS ──────▶ archive
//! ```
//!
//! `profivac-archive-link` is the station's side, `profivac-archive-protocol` what both exchange.
//!
//! A batch may come twice, late, and out of order. Its rows have keys, so that storing it again changes nothing; a span of a later
//! batch replaces that of an earlier one. The acknowledgement follows the commit. Nothing else makes the effect exactly once.

pub mod config;
pub mod database;
pub mod https;
pub mod metrics;
mod packing;
pub mod pending;
pub mod schema;
pub mod service;
mod session;
pub mod store;
pub mod view;
