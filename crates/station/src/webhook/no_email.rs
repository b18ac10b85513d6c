//! What replaces e-mails in a program without the feature `email`: its configuration has no [`Email`], so nothing is sent.

use crate::config::Email;
use profivac_recorder::alarms::Notification;
use std::time::Duration;
use tokio_rustls::rustls::pki_types::CertificateDer;

/// Nothing is sent.
#[derive(Debug, thiserror::Error)]
#[error("this program was built without e-mail")]
pub struct MailError;

impl MailError {
    /// Whether the server would refuse this message again, and would take others.
    #[must_use]
    pub const fn is_about_message(&self) -> bool {
        false
    }
}

/// Sends no messages.
pub struct Mailer;

impl Mailer {
    /// There is no mailer.
    ///
    /// # Errors
    /// Always [`MailError`].
    pub fn new(_email: Email, _trusted: Vec<CertificateDer<'static>>, _timeout: Duration) -> Result<Self, MailError> {
        Err(MailError)
    }

    /// Sends nothing.
    ///
    /// # Errors
    /// Always [`MailError`].
    #[expect(clippy::unused_async, reason = "the signature with the feature")]
    pub async fn send(&self, _notification: &Notification) -> Result<(), MailError> {
        Err(MailError)
    }
}
