//! Recipients of alarm notifications by e-mail.

use crate::alarm::{NotificationTarget, Priority, QuietHours};
#[cfg(feature = "email")]
pub use lettre::message::Mailbox;
use profivac_web_server::tables::Secret;
use std::fmt;
use std::path::PathBuf;
use std::time::Duration;

/// The address of a sender or recipient: there is none in a program without the feature `email`.
#[cfg(not(feature = "email"))]
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Mailbox(());

/// How a connection to a mail server is encrypted.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum MailSecurity {
    /// Encrypted with STARTTLS before anything is sent; without it nothing is sent.
    Starttls,
    /// Encrypted from the first octet on.
    Tls,
    /// Not encrypted, to this computer only.
    None,
}

impl MailSecurity {
    /// The ways with their words in the file and their usual ports.
    pub const ALL: [(&'static str, Self, u16); 3] =
        [("starttls", Self::Starttls, 587), ("tls", Self::Tls, 465), ("none", Self::None, 25)];
}

/// Recipients of alarm notifications by e-mail, and the server that takes the messages.
#[derive(Clone, PartialEq, Eq)]
pub struct Email {
    /// Its name, unique among the webhooks and e-mails.
    pub name: String,
    /// The host name of the server.
    pub host: String,
    /// Its port.
    pub port: u16,
    /// How the connection is encrypted.
    pub security: MailSecurity,
    /// The sender.
    pub from: Mailbox,
    /// The recipients.
    pub to: Vec<Mailbox>,
    /// User and password at the server.
    pub credentials: Option<(String, Secret)>,
    /// Certificates in PEM that are trusted in addition to those of the system.
    pub ca_file: Option<PathBuf>,
    /// The address of the dashboard in messages, without a slash at its end.
    pub link: Option<String>,
    /// The lowest priority that is sent.
    pub min_priority: Priority,
    /// Only alarms that wait for their acknowledgement for this time are sent; zero: all, at once.
    pub unacknowledged_after: Duration,
    /// The hours in which only alarms of high priority are sent.
    pub quiet: Option<QuietHours>,
}

impl fmt::Debug for Email {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        formatter.debug_struct("Email").field("name", &self.name).field("host", &self.host).finish_non_exhaustive()
    }
}

impl Email {
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

    /// The server, as it is shown.
    #[must_use]
    pub fn origin(&self) -> String {
        format!("smtp://{}:{}", self.host, self.port)
    }
}
