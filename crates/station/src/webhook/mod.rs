//! Webhooks and e-mails: the station sends changes of alarms to other systems, in order, each at least once.
//!
//! ```text
//! alarm ─ notification, in the transaction of its history ─ delivery thread ─ POST ─ accepted: the notification is deleted
//!                                                              ▲                │
//!                                                              └─ growing pauses ┴─ not accepted
//! ```
//!
//! The queue is a table of the database: a notification is sent when it is on the disk, and stays there until it is accepted, also
//! when the station is killed. Each receiver has a thread of its own, so that a stalled server does not delay the others.
//!
//! | Module | Holds |
//! |---|---|
//! | [`client`] | one POST over HTTP or HTTPS |
//! | [`email`] | one e-mail over SMTP |
//! | [`receiver`] | a webhook or an e-mail |
//! | [`status`] | the delivery status of all webhooks |
//! | [`delivery`] | the thread that delivers |

pub mod client;
pub mod delivery;
#[cfg_attr(not(feature = "email"), path = "no_email.rs")]
pub mod email;
pub mod receiver;
pub mod status;

pub use delivery::{DeliverySettings, DeliveryThread};
pub use receiver::{Receiver, ReceiverKind};
pub use status::{DeliveryStatus, WebhookView};
