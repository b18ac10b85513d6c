//! The station's side of an archive: it sends the batches of its outbox, and answers what users of the archive ask for.
//!
//! ```text
//! database ── outbox ── publisher ──▶ JetStream, or an archive over HTTPS
//!   station ─────────── responder ◀── requests of users
//! ```
//!
//! | Module | Holds |
//! |---|---|
//! | [`publisher`] | batches to JetStream or to an archive, acknowledgements to the database |
//! | `responder` | the answers to requests |
//! | `post` | the client of an archive that takes batches over HTTPS |

mod post;
pub mod publisher;
mod responder;

pub use post::PostError;
