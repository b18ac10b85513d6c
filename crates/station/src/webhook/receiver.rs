//! A webhook or an e-mail: what the delivery and the alarms need of both.

use crate::alarm::NotificationTarget;
use crate::config::{Email, Webhook};
use profivac_model::words;
use std::path::Path;

words! {
    /// What a receiver is.
    #[derive(Default)]
    pub enum ReceiverKind {
        /// An address that gets a POST.
        #[default]
        Webhook = "webhook",
        /// Recipients of e-mails.
        Email = "email",
    }
}

/// A receiver of alarm notifications.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Receiver {
    /// An address that gets a POST.
    Webhook(Webhook),
    /// Recipients of e-mails.
    Email(Email),
}

impl From<Webhook> for Receiver {
    fn from(webhook: Webhook) -> Self {
        Self::Webhook(webhook)
    }
}

impl From<Email> for Receiver {
    fn from(email: Email) -> Self {
        Self::Email(email)
    }
}

impl Receiver {
    /// The receivers of a configuration.
    #[must_use]
    pub fn all(webhooks: Vec<Webhook>, emails: Vec<Email>) -> Vec<Self> {
        webhooks.into_iter().map(Self::from).chain(emails.into_iter().map(Self::from)).collect()
    }

    /// Its name, unique among all receivers.
    #[must_use]
    pub fn name(&self) -> &str {
        match self {
            Self::Webhook(webhook) => &webhook.name,
            Self::Email(email) => &email.name,
        }
    }

    /// What it is.
    #[must_use]
    pub const fn kind(&self) -> ReceiverKind {
        match self {
            Self::Webhook(_) => ReceiverKind::Webhook,
            Self::Email(_) => ReceiverKind::Email,
        }
    }

    /// The part of its address that may be shown.
    #[must_use]
    pub fn origin(&self) -> String {
        match self {
            Self::Webhook(webhook) => webhook.origin(),
            Self::Email(email) => email.origin(),
        }
    }

    /// What it is told of.
    #[must_use]
    pub fn target(&self) -> NotificationTarget {
        match self {
            Self::Webhook(webhook) => webhook.target(),
            Self::Email(email) => email.target(),
        }
    }

    /// The file with certificates that it trusts besides those of the system.
    #[must_use]
    pub fn ca_file(&self) -> Option<&Path> {
        match self {
            Self::Webhook(webhook) => webhook.ca_file.as_deref(),
            Self::Email(email) => email.ca_file.as_deref(),
        }
    }
}
