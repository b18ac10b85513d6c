//! `[[webhook]]`: HTTP addresses that receive alarm notifications.
//!
//! ```toml
//! [[webhook]]
//! name = "on call"                 # default: the host of the URL
//! url = "https://alarms.example.org/profivac"
//! token-file = "on-call.token"     # relative to this file; or token = "…"
//! priority = "medium"              # the lowest priority that is sent; default low
//! ca-file = "our-ca.pem"           # trusted in addition to the certificates of the system
//! quiet = "22:00-06:00"            # then alarms of high priority only, in the time zone of the computer
//! unacknowledged-after = "10 min"  # only alarms that no user has acknowledged for this time
//! ```

use super::error::{ConfigProblem, Located, NamedItem, WebhookUrlProblem};
use super::names;
use super::values::{priority, quiet_hours, unacknowledged_after};
use crate::time_span::TimeSpan;
use hyper::Uri;
use profivac_host::text_file::Parsed;
use profivac_station::alarm::Priority;
use profivac_station::config::Webhook;
use profivac_web_server::host_name::is_loopback;
use profivac_web_server::tables::{Secret, ca_certificates, secret_of_file, token_of};
use serde::Deserialize;
use std::path::{Path, PathBuf};
use toml::Spanned;

/// One `[[webhook]]`.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields, rename_all = "kebab-case")]
pub struct WebhookToml {
    /// The name, unique among webhooks and e-mails. Default: the host of the URL.
    name: Option<Spanned<String>>,
    /// The URL: `https://`, or `http://` to this computer or without a token.
    url: Spanned<Parsed<Uri>>,
    /// Sent as `Authorization: Bearer`; then only its owner may read this file.
    token: Option<Spanned<Secret>>,
    /// The file with the token, beside this file, which only its owner may read; in place of `token`.
    token_file: Option<Spanned<PathBuf>>,
    /// Certificates in PEM that are trusted in addition to those of the system.
    ca_file: Option<Spanned<PathBuf>>,
    /// The lowest priority that is sent: `high`, `medium`, `low`. Default: `low`.
    priority: Option<Spanned<String>>,
    /// Hours such as `22:00-06:00`, in the time zone of the computer, in which only alarms of high priority are sent.
    quiet: Option<Spanned<String>>,
    /// Only alarms that no user has acknowledged for this time are sent, 1 s to 1 day.
    unacknowledged_after: Option<Spanned<Parsed<TimeSpan>>>,
}

impl WebhookToml {
    fn name_or_url(&self) -> std::ops::Range<usize> {
        self.name.as_ref().map_or_else(|| self.url.span(), Spanned::span)
    }
}

/// All webhooks of the configuration file at `path`.
pub fn webhooks(given: &[WebhookToml], path: &Path) -> Result<Vec<Webhook>, Located> {
    let mut all: Vec<Webhook> = Vec::new();
    for given in given {
        let webhook = webhook(given, path.parent().unwrap_or(Path::new("")))?;
        if all.iter().any(|other| other.name == webhook.name) {
            let problem = ConfigProblem::Duplicate { item: NamedItem::Webhook, name: webhook.name };
            return Err(Located::new(given.name_or_url(), problem));
        }
        all.push(webhook);
    }
    Ok(all)
}

fn webhook(given: &WebhookToml, folder: &Path) -> Result<Webhook, Located> {
    let url = given.url.get_ref().0.clone();
    let wrong = |problem| Err(Located::new(given.url.span(), ConfigProblem::WebhookUrl(problem)));
    let Some(authority) = url.authority() else { return wrong(WebhookUrlProblem::NoHost) };
    if authority.as_str().contains('@') {
        return wrong(WebhookUrlProblem::Password);
    }
    let token = token(given, folder)?;
    match url.scheme_str() {
        Some("https") => {}
        Some("http") if token.is_none() || is_loopback(authority.host()) => {}
        Some("http") => return wrong(WebhookUrlProblem::TokenWithoutTls),
        _ => return wrong(WebhookUrlProblem::Scheme),
    }
    given.name.as_ref().map_or(Ok(()), |name| names::check(NamedItem::Webhook, name))?;
    let name = given.name.as_ref().map_or_else(|| authority.host().to_owned(), |name| name.get_ref().clone());
    let ca_file = given.ca_file.as_ref().map(|file| {
        let path = folder.join(file.get_ref());
        let wrong = |error| Located::new(file.span(), ConfigProblem::Certificates(error));
        ca_certificates(&path).map_err(wrong).map(|_| path)
    });
    let min_priority = priority(given.priority.as_ref(), Priority::Low)?;
    let ca_file = ca_file.transpose()?;
    let unacknowledged_after = unacknowledged_after(given.unacknowledged_after.as_ref())?;
    let quiet = given.quiet.as_ref().map(quiet_hours).transpose()?;
    Ok(Webhook { name, url, token, ca_file, min_priority, unacknowledged_after, quiet })
}

fn token(given: &WebhookToml, folder: &Path) -> Result<Option<Secret>, Located> {
    match (&given.token, &given.token_file) {
        (None, None) => Ok(None),
        (Some(token), None) => Ok(Some(token_of(token)?)),
        (None, Some(file)) => Ok(Some(secret_of_file(file, folder)?)),
        (Some(_), Some(file)) => Err(Located::new(file.span(), ConfigProblem::TwoTokens)),
    }
}
