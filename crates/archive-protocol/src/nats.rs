//! Connections to the servers of NATS, and the names of subjects and messages.

use async_nats::jetstream::{self, Context};
use async_nats::{ConnectError, ConnectErrorKind, ConnectOptions};
use profivac_web_server::client_tls::{fault, is_of_another_name};
use profivac_web_server::tables::archive::{Nats, is_name};
use std::time::Duration;
use thiserror::Error;
use tokio_rustls::rustls;

/// The stream of all batches.
pub const STREAM: &str = "PROFIVAC";

/// What the subjects of all batches match.
pub const SUBJECTS: &str = "profivac.v1.*.*.batch";

/// The longest wait for an answer.
const TIMEOUT: Duration = Duration::from_secs(10);

/// Why the servers cannot be used.
#[derive(Debug, Error)]
#[error("{servers}: {reason}")]
pub struct NatsError {
    /// The URLs of the servers.
    pub servers: String,
    /// What failed.
    pub reason: String,
}

impl NatsError {
    /// An error of these servers.
    pub fn new(nats: &Nats, reason: impl std::fmt::Display) -> Self {
        Self { servers: nats.servers.join(", "), reason: reason.to_string() }
    }
}

/// A server that answers no ping is given up after three of these times: it may be stopped with its connections open. chosen; the
/// library waits a minute.
const PING_INTERVAL: Duration = Duration::from_secs(10);

/// The most messages of a subscription that wait in memory; the library drops others. An archive fetches 256, and then takes them.
const MAX_WAITING: usize = 512;

/// Connects to the first server that answers.
///
/// # Errors
/// [`NatsError`] when there is none, or it refuses the login.
pub async fn connect(nats: &Nats, name: &str) -> Result<Context, NatsError> {
    connect_for(nats, name, MAX_WAITING, INBOX).await
}

/// The subjects of the answers to an archive.
pub const INBOX: &str = "_INBOX";

/// The subjects of the answers to a station begin with it. Each station has subjects of its own: a user who may read the subjects of all
/// answers reads the batches that the servers send to the archives, and could acknowledge them.
pub fn inbox(plant: &str, station: &str) -> String {
    format!("profivac.v1.{plant}.{station}.inbox")
}

/// Connects, with room for `waiting` messages of a subscription, and with answers on subjects that begin with `inbox`.
///
/// # Errors
/// As [`connect`].
pub async fn connect_for(nats: &Nats, name: &str, waiting: usize, inbox: &str) -> Result<Context, NatsError> {
    let mut options = ConnectOptions::new()
        .name(name)
        .custom_inbox_prefix(inbox)
        .connection_timeout(Duration::from_secs(5))
        .request_timeout(Some(TIMEOUT))
        .ping_interval(PING_INTERVAL)
        .require_tls(nats.tls)
        // The file names the servers: their certificates and a tunnel may fit to no other name.
        .ignore_discovered_servers()
        .client_capacity(256)
        .subscription_capacity(waiting);
    if let Some(credentials) = &nats.credentials {
        options = options.user_and_password(credentials.user.clone(), credentials.password.reveal().to_owned());
    }
    if let Some(file) = &nats.ca_file {
        options = options.add_root_certificates(file.clone());
    }
    let client =
        options.connect(nats.servers.as_slice()).await.map_err(|error| NatsError::new(nats, explained(&error)))?;
    let mut context = jetstream::new(client);
    context.set_timeout(TIMEOUT);
    Ok(context)
}

/// Why there is no connection, with what to do. The library repeats the kind of the error as its cause.
fn explained(error: &ConnectError) -> String {
    use ConnectErrorKind::{Authentication, AuthorizationViolation, Io, Tls};
    let kind = error.kind();
    if matches!(kind, AuthorizationViolation | Authentication) {
        return format!("{kind}: compare user and password in the file credentials with the users of the server");
    }
    let advice = match fault(error) {
        Some(rustls::Error::InvalidMessage(_)) => "the server speaks no TLS: write nats://, or give it a certificate",
        Some(found) if is_of_another_name(found) => "write a name of the certificate into servers",
        Some(rustls::Error::InvalidCertificate(_)) => {
            "name a file with the certificate of its issuer in ca-file beside servers"
        }
        _ if matches!(kind, Tls) => "compare nats:// or tls:// in servers, and ca-file, with the server",
        _ if matches!(kind, Io) => "check that it runs, and host and port in servers",
        _ => return error.to_string(),
    };
    format!("{error}; {advice}")
}

/// The subject of the batches of a station.
pub fn subject(plant: &str, station: &str) -> String {
    format!("profivac.v1.{plant}.{station}.batch")
}

/// Plant and station of a subject. They come from the subject and not from the message, because the servers let a station publish only
/// under its own subject.
pub fn of_subject(subject: &str) -> Option<(&str, &str)> {
    let mut parts = subject.strip_prefix("profivac.v1.")?.strip_suffix(".batch")?.split('.');
    match (parts.next(), parts.next(), parts.next()) {
        (Some(plant), Some(station), None) if is_name(plant) && is_name(station) => Some((plant, station)),
        _ => None,
    }
}

/// The header with the id of a message. It is not `Nats-Msg-Id`: with that, the servers drop a second message of any station, so that one
/// could take the ids of another.
pub const BATCH_HEADER: &str = "Profivac-Batch";

/// The id of a message.
pub fn message_id(station: &str, epoch: i64, number: i64) -> String {
    format!("{station}/{epoch}/{number}")
}

/// Epoch and number of a message of this station.
pub fn of_message_id(id: &str, station: &str) -> Option<(i64, i64)> {
    let (epoch, number) = id.strip_prefix(station)?.strip_prefix('/')?.split_once('/')?;
    Some((epoch.parse().ok().filter(|epoch| *epoch > 0)?, number.parse().ok().filter(|number| *number > 0)?))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn subjects_and_ids_are_read_as_they_are_written() {
        assert_eq!(of_subject(&subject("hall", "hall-1")), Some(("hall", "hall-1")));
        assert_eq!(of_message_id(&message_id("hall-1", 5, 7), "hall-1"), Some((5, 7)));
        for wrong in ["profivac.v1.a.batch", "profivac.v1.a.b.c.batch", "profivac.v1..b.batch", "profivac.v2.a.b.batch"]
        {
            assert_eq!(of_subject(wrong), None, "{wrong}");
        }
        for name in ["*", ">", "a/b", "<b>", "a'b", "ü", &"x".repeat(61)] {
            assert_eq!(
                (of_subject(&subject("hall", name)), of_subject(&subject(name, "hall-1"))),
                (None, None),
                "{name}"
            );
        }
        for wrong in ["hall-1/5", "hall-2/5/7", "hall-1/0/7", "hall-1/5/-7", "hall-1/5/7/8", ""] {
            assert_eq!(of_message_id(wrong, "hall-1"), None, "{wrong}");
        }
    }

    #[test]
    fn a_refused_login_names_the_file() {
        let refused = explained(&ConnectError::from(ConnectErrorKind::AuthorizationViolation));
        assert_eq!(
            refused,
            "authorization violation: compare user and password in the file credentials with the users of the server"
        );
    }

    #[test]
    fn a_server_without_tls_says_which_scheme_fits() {
        let cause = rustls::Error::InvalidMessage(rustls::InvalidMessage::InvalidContentType);
        let error = ConnectError::with_source(ConnectErrorKind::Io, std::io::Error::other(cause));
        assert!(explained(&error).ends_with("the server speaks no TLS: write nats://, or give it a certificate"));
    }
}
