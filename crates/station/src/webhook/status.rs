//! The delivery status of all webhooks, for the API.

use super::receiver::ReceiverKind;
use crate::view::unix_ms;
use profivac_recorder::{DatabaseError, Micros, Reader};
use serde::Serialize;
use std::collections::BTreeMap;
use std::sync::{Mutex, MutexGuard, PoisonError};
use utoipa::ToSchema;

/// The delivery status of a webhook.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, ToSchema)]
pub struct WebhookView {
    /// Its name.
    pub name: String,
    /// Where its notifications go.
    pub kind: ReceiverKind,
    /// Scheme and host of its URL, or of the mail server; the rest often is a secret.
    pub at: String,
    /// Notifications that wait for delivery.
    pub waiting: usize,
    /// Notifications delivered since the station started.
    pub delivered: u64,
    /// Notifications given up since the station started.
    pub given_up: u64,
    /// When the last notification was delivered, in milliseconds since 1970.
    pub delivered_ms: Option<i64>,
    /// The reason why the next notification is not delivered; the station tries again.
    pub problem: Option<String>,
    /// Since when the delivery fails, in milliseconds since 1970.
    pub failing_since_ms: Option<i64>,
}

/// The delivery status of all webhooks, by name.
#[derive(Default)]
pub struct DeliveryStatus {
    webhooks: Mutex<BTreeMap<String, WebhookView>>,
}

impl DeliveryStatus {
    fn webhooks(&self) -> MutexGuard<'_, BTreeMap<String, WebhookView>> {
        self.webhooks.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// The status of all webhooks, by name. The number of waiting notifications comes from the database.
    ///
    /// # Errors
    /// [`DatabaseError`] when the database cannot be read.
    pub fn views(&self, reader: &Reader) -> Result<Vec<WebhookView>, DatabaseError> {
        let mut views: Vec<_> = self.webhooks().values().cloned().collect();
        for view in &mut views {
            view.waiting = reader.queued_notifications(&view.name)?.len();
        }
        Ok(views)
    }

    /// Adds a webhook.
    pub(super) fn add(&self, name: &str, kind: ReceiverKind, origin: String) {
        let view = WebhookView { name: name.to_owned(), kind, at: origin, ..WebhookView::default() };
        self.webhooks().insert(name.to_owned(), view);
    }

    /// Removes a webhook.
    pub(super) fn remove(&self, name: &str) {
        self.webhooks().remove(name);
    }

    /// A notification was delivered. Returns whether the delivery failed before.
    pub(super) fn delivered(&self, name: &str) -> bool {
        self.webhooks().get_mut(name).is_some_and(|view| {
            view.delivered = view.delivered.saturating_add(1);
            view.delivered_ms = Some(unix_ms(Micros::now()));
            view.failing_since_ms = None;
            view.problem.take().is_some()
        })
    }

    /// A delivery failed. Returns whether it is the first failure in a row.
    pub(super) fn failed(&self, name: &str, problem: &str) -> bool {
        self.webhooks().get_mut(name).is_some_and(|view| {
            view.failing_since_ms.get_or_insert_with(|| unix_ms(Micros::now()));
            view.problem.replace(problem.to_owned()).is_none()
        })
    }

    /// Notifications were given up.
    pub(super) fn gave_up(&self, name: &str, count: usize) {
        if let Some(view) = self.webhooks().get_mut(name) {
            view.given_up = view.given_up.saturating_add(count as u64);
        }
    }
}
