//! Webhooks: the station posts changes of alarms to other systems, in order, each at least once.
//!
//! ```text
//! alarm ─ notification, in the transaction of its history ─ delivery thread ─ POST ─ accepted: the notification is deleted
//!                                                              ▲                │
//!                                                              └─ growing pauses ┴─ not accepted
//! ```
//!
//! The queue is a table of the database: a notification is sent when it is on the disk, and stays there until it is accepted, also
//! when the station is killed. Each webhook has a thread of its own, so that a stalled server does not delay the others.
//!
//! | Module | Holds |
//! |---|---|
//! | [`client`] | one POST over HTTP or HTTPS |
//! | [`status`] | the delivery status of all webhooks |
//! | [`delivery`] | the thread that delivers |

pub mod client;
pub mod delivery;
pub mod status;

pub use delivery::{DeliverySettings, DeliveryThread};
pub use status::{DeliveryStatus, WebhookView};
