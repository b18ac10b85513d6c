//! Webhooks: others are told of alarms over HTTP, each at least once and in order, whatever happens meanwhile.
//!
//! ```text
//! alarm ─ letter, in the transaction of its history ─ courier of the webhook ─ POST ─ taken: the letter is deleted
//!                                                        ▲                      │
//!                                                        └─ growing pauses ─────┴─ not taken
//! ```
//!
//! The queue is the record itself: what is not on the disk is not sent, and what was not taken is still there after a kill. Each
//! webhook has a thread of its own, so that one that hangs holds up nobody.
//!
//! | Module | Holds |
//! |---|---|
//! | [`client`] | one POST over HTTP or HTTPS |
//! | [`courier`] | the thread that delivers |

pub mod client;
pub mod delivery;

pub use delivery::{DeliverySettings, DeliveryThread};

use crate::view::unix_ms;
use profivac_recorder::{DatabaseError, Micros, Reader};
use serde::Serialize;
use std::collections::BTreeMap;
use std::sync::{Mutex, MutexGuard, PoisonError};
use utoipa::ToSchema;

/// How a webhook is.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, ToSchema)]
pub struct WebhookView {
    /// Its name.
    pub name: String,
    /// Scheme and host; what follows is often a secret.
    pub at: String,
    /// How many letters wait.
    pub waiting: usize,
    /// How many it has taken since the station began.
    pub delivered: u64,
    /// How many were given up since the station began.
    pub given_up: u64,
    /// When it took one last, in milliseconds since 1970.
    pub delivered_ms: Option<i64>,
    /// Why it does not take the next one, if it does not; it is tried again.
    pub problem: Option<String>,
    /// Since when, in milliseconds since 1970.
    pub failing_since_ms: Option<i64>,
}

/// How all webhooks are, for whoever wants to know.
#[derive(Default)]
pub struct DeliveryStatus {
    all: Mutex<BTreeMap<String, WebhookView>>,
}

impl DeliveryStatus {
    fn all(&self) -> MutexGuard<'_, BTreeMap<String, WebhookView>> {
        self.all.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// All of them, by name. How many letters wait stands in the record.
    ///
    /// # Errors
    /// [`StoreError`] when the record cannot be read.
    pub fn views(&self, reader: &Reader) -> Result<Vec<WebhookView>, DatabaseError> {
        let mut views: Vec<_> = self.all().values().cloned().collect();
        for view in &mut views {
            view.waiting = reader.queued_notifications(&view.name)?.len();
        }
        Ok(views)
    }

    fn begin(&self, name: &str, at: String) {
        self.all().insert(name.to_owned(), WebhookView { name: name.to_owned(), at, ..WebhookView::default() });
    }

    fn end(&self, name: &str) {
        self.all().remove(name);
    }

    /// Says whether it failed before.
    fn delivered(&self, name: &str) -> bool {
        self.all().get_mut(name).is_some_and(|view| {
            view.delivered = view.delivered.saturating_add(1);
            view.delivered_ms = Some(unix_ms(Micros::now()));
            view.failing_since_ms = None;
            view.problem.take().is_some()
        })
    }

    /// Says whether it did not fail before.
    fn failed(&self, name: &str, problem: &str) -> bool {
        self.all().get_mut(name).is_some_and(|view| {
            view.failing_since_ms.get_or_insert_with(|| unix_ms(Micros::now()));
            view.problem.replace(problem.to_owned()).is_none()
        })
    }

    fn gave_up(&self, name: &str, count: usize) {
        if let Some(view) = self.all().get_mut(name) {
            view.given_up = view.given_up.saturating_add(count as u64);
        }
    }
}
