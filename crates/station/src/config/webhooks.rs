//! Webhooks in the file: who is told of alarms over HTTP.
//!
//! ```toml
//! [[webhook]]
//! name = "on call"                 # the host's if nothing is said
//! url = "https://alarms.example.org/profivac"
//! token-file = "on-call.token"     # beside this file; or token = "…"
//! priority = "medium"              # the lowest it is told of; low if nothing is said
//! ca-file = "our-ca.pem"           # trusted beside those of the system
//! ```

use super::SpannedMessage;
use super::alarms::priority;
use crate::alarm::Priority;
use crate::auth::file_permissions::{self, PermissionError};
use hyper::Uri;
use profivac_host::text_file::Parsed;
use serde::de::Error;
use serde::{Deserialize, Deserializer};
use std::fmt;
use std::net::IpAddr;
use std::path::{Path, PathBuf};
use toml::Spanned;

/// Something that is sent and never shown.
#[derive(Clone, PartialEq, Eq)]
pub struct Secret(String);

impl<'de> Deserialize<'de> for Secret {
    /// What stands there instead is not repeated: it may be the secret without its quotes.
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        String::deserialize(deserializer).map(Self).map_err(|_| D::Error::custom("expected a token in quotes"))
    }
}

impl Secret {
    /// What it is: to be sent, and for nothing else.
    #[must_use]
    pub fn reveal(&self) -> &str {
        &self.0
    }
}

impl fmt::Debug for Secret {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        formatter.write_str("(secret)")
    }
}

/// Somebody who is told of alarms.
#[derive(Clone, PartialEq, Eq)]
pub struct Webhook {
    /// Its name, which no other has.
    pub name: String,
    /// Where it is. What follows the host is often a secret, and is not shown.
    pub url: Uri,
    /// Sent as `Authorization: Bearer`.
    pub token: Option<Secret>,
    /// Who vouches for it, beside those whom the system trusts.
    pub ca_file: Option<PathBuf>,
    /// The lowest priority it is told of.
    pub min_priority: Priority,
}

impl fmt::Debug for Webhook {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        formatter.debug_struct("Webhook").field("name", &self.name).field("at", &self.origin()).finish_non_exhaustive()
    }
}

impl Webhook {
    /// Scheme and host: as much of the address as may be shown.
    #[must_use]
    pub fn origin(&self) -> String {
        format!(
            "{}://{}",
            self.url.scheme_str().unwrap_or_default(),
            self.url.authority().map_or("", |host| host.as_str())
        )
    }
}

/// A webhook of the file.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields, rename_all = "kebab-case")]
pub struct WebhookToml {
    name: Option<Spanned<String>>,
    url: Spanned<Parsed<Uri>>,
    token: Option<Spanned<Secret>>,
    token_file: Option<Spanned<PathBuf>>,
    ca_file: Option<Spanned<PathBuf>>,
    priority: Option<Spanned<String>>,
}

/// All webhooks of the file at `path`.
pub fn webhooks(written: &[WebhookToml], path: &Path) -> Result<Vec<Webhook>, SpannedMessage> {
    let mut all: Vec<Webhook> = Vec::new();
    for written in written {
        let webhook = webhook(written, path.parent().unwrap_or(Path::new("")))?;
        if all.iter().any(|other| other.name == webhook.name) {
            let place = written.name.as_ref().map_or_else(|| written.url.span(), Spanned::span);
            return Err((place, format!("the webhook {:?} stands twice: name tells them apart", webhook.name)));
        }
        all.push(webhook);
    }
    Ok(all)
}

fn webhook(written: &WebhookToml, folder: &Path) -> Result<Webhook, SpannedMessage> {
    let url = written.url.get_ref().0.clone();
    let complain =
        |what: &str| Err((written.url.span(), format!("expected an address like https://host/path, {what}")));
    let Some(authority) = url.authority() else { return complain("got one without a host") };
    if authority.as_str().contains('@') {
        return complain("got one with a password: token and token-file are for that");
    }
    let token = token(written, folder)?;
    match url.scheme_str() {
        Some("https") => {}
        Some("http") if token.is_none() || is_loopback(authority.host()) => {}
        Some("http") => return complain("got http with a token, which everybody on the way could read"),
        _ => return complain("got another scheme"),
    }
    let name = written.name.as_ref().map_or_else(|| authority.host().to_owned(), |name| name.get_ref().clone());
    if name.trim().is_empty() {
        return Err((
            written.name.as_ref().map_or_else(|| written.url.span(), Spanned::span),
            "expected the name of a webhook, got nothing".to_owned(),
        ));
    }
    let ca_file = written.ca_file.as_ref().map(|file| {
        let path = folder.join(file.get_ref());
        crate::webhook::certificates(&path).map_err(|error| (file.span(), error)).map(|_| path)
    });
    let least = priority(written.priority.as_ref(), Priority::Low, &[])?.unwrap_or(Priority::Low);
    Ok(Webhook { name, url, token, ca_file: ca_file.transpose()?, min_priority: least })
}

fn token(written: &WebhookToml, folder: &Path) -> Result<Option<Secret>, SpannedMessage> {
    let (place, token) = match (&written.token, &written.token_file) {
        (None, None) => return Ok(None),
        (Some(token), None) => (token.span(), token.get_ref().0.clone()),
        (None, Some(file)) => {
            let path = folder.join(file.get_ref());
            let failed = |error| (file.span(), format!("{} cannot be read: {error}", path.display()));
            match file_permissions::check(&path) {
                Err(error @ PermissionError::Open(..)) => return Err((file.span(), error.to_string())),
                // Why it cannot be read is told by reading it.
                Ok(()) | Err(PermissionError::System(..)) => {}
            }
            (file.span(), std::fs::read_to_string(&path).map_err(failed)?.trim().to_owned())
        }
        (Some(_), Some(file)) => return Err((file.span(), "expected token or token-file, got both".to_owned())),
    };
    // What it says is not told: it is a secret.
    let fits = !token.is_empty() && token.bytes().all(|octet| octet.is_ascii_graphic());
    if fits {
        Ok(Some(Secret(token)))
    } else {
        Err((place, "expected a token of visible ASCII without spaces".to_owned()))
    }
}

fn is_loopback(host: &str) -> bool {
    let address = host.trim_start_matches('[').trim_end_matches(']').parse::<IpAddr>();
    host == "localhost" || address.is_ok_and(|address| address.is_loopback())
}
