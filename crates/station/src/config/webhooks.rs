//! Webhooks that get alarm notifications.

use crate::alarm::{NotificationTarget, Priority, QuietHours};
use hyper::Uri;
use profivac_web_server::tables::Secret;
use std::fmt;
use std::path::PathBuf;
use std::time::Duration;

/// A webhook that gets alarm notifications.
#[derive(Clone, PartialEq, Eq)]
pub struct Webhook {
    /// Its name, unique among the webhooks.
    pub name: String,
    /// Its URL. The part after the host is often a secret and is not shown.
    pub url: Uri,
    /// The token that is sent as `Authorization: Bearer`.
    pub token: Option<Secret>,
    /// Certificates in PEM that are trusted in addition to those of the system.
    pub ca_file: Option<PathBuf>,
    /// The lowest priority that is sent.
    pub min_priority: Priority,
    /// Only alarms that wait for their acknowledgement for this time are sent; zero: all, at once.
    pub unacknowledged_after: Duration,
    /// The hours in which only alarms of high priority are sent.
    pub quiet: Option<QuietHours>,
}

impl fmt::Debug for Webhook {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        let origin = self.origin();
        formatter.debug_struct("Webhook").field("name", &self.name).field("origin", &origin).finish_non_exhaustive()
    }
}

impl Webhook {
    /// What it is told of.
    #[must_use]
    pub fn target(&self) -> NotificationTarget {
        NotificationTarget {
            webhook: self.name.clone(),
            min_priority: self.min_priority,
            unacknowledged_after: self.unacknowledged_after,
            quiet: self.quiet.clone(),
        }
    }

    /// Scheme and host of the URL: the part that may be shown.
    #[must_use]
    pub fn origin(&self) -> String {
        let host = self.url.authority().map_or("", |host| host.as_str());
        format!("{}://{host}", self.url.scheme_str().unwrap_or_default())
    }
}
