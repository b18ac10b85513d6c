//! `[[email]]`: recipients of alarm notifications by e-mail.
//!
//! ```toml
//! [[email]]
//! name = "shift"                   # default: the host of the server
//! server = "smtp.example.org"      # or host:port; default 587, with security = "tls" 465
//! security = "starttls"            # the default; tls; none to this computer only
//! from = "Target hall <profivac@example.org>"
//! to = ["shift@example.org"]
//! user = "profivac"
//! password-file = "smtp.password"  # relative to this file
//! ca-file = "our-ca.pem"           # trusted in addition to the certificates of the system
//! link = "https://vacuum.example"  # the address of the dashboard, in each message
//! priority = "medium"              # priority, quiet, unacknowledged-after: as those of [[webhook]]
//! ```

use super::error::{ConfigProblem, Located, NamedItem};
use super::names;
use super::values::{priority, quiet_hours, unacknowledged_after};
use crate::time_span::TimeSpan;
use hyper::Uri;
use hyper::http::uri::Authority;
use profivac_host::text_file::Parsed;
use profivac_station::alarm::Priority;
use profivac_station::config::{Email, MailSecurity, Mailbox};
use profivac_web_server::host_name::is_loopback;
use profivac_web_server::tables::{Secret, ca_certificates, password_of_file};
use serde::Deserialize;
use std::path::{Path, PathBuf};
use toml::Spanned;

/// The most recipients of a message. chosen: a list belongs to the mail server.
const MAX_RECIPIENTS: usize = 50;

/// One `[[email]]`.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields, rename_all = "kebab-case")]
pub struct EmailToml {
    /// The name, unique among webhooks and e-mails. Default: the host of the server.
    name: Option<Spanned<String>>,
    /// Host, or `host:port`. The default port is 587, with `tls` 465, with `none` 25.
    server: Spanned<String>,
    /// `starttls` (default), `tls`, or `none` for a server on this computer.
    security: Option<Spanned<String>>,
    /// The sender, as `name@example.org` or `Name <name@example.org>`.
    from: Spanned<String>,
    /// 1 to 50 recipients.
    to: Spanned<Vec<Spanned<String>>>,
    /// The user at the server, with `password-file`.
    user: Option<Spanned<String>>,
    /// The file with the password, beside this file, which only its owner may read.
    password_file: Option<Spanned<PathBuf>>,
    /// Certificates in PEM that are trusted in addition to those of the system.
    ca_file: Option<Spanned<PathBuf>>,
    /// The address of the dashboard, for the message.
    link: Option<Spanned<Parsed<Uri>>>,
    /// The lowest priority that is sent: `high`, `medium`, `low`. Default: `low`.
    priority: Option<Spanned<String>>,
    /// Hours such as `22:00-06:00`, in the time zone of the computer, in which only alarms of high priority are sent.
    quiet: Option<Spanned<String>>,
    /// Only alarms that no user has acknowledged for this time are sent, 1 s to 1 day.
    unacknowledged_after: Option<Spanned<Parsed<TimeSpan>>>,
}

/// All e-mails of the configuration file at `path`. `taken` are the names of the webhooks, whose notifications wait in the same table.
pub fn emails(given: &[EmailToml], path: &Path, taken: &[&str]) -> Result<Vec<Email>, Located> {
    let mut all: Vec<Email> = Vec::new();
    for given in given {
        let email = email(given, path.parent().unwrap_or(Path::new("")))?;
        if taken.contains(&email.name.as_str()) || all.iter().any(|other| other.name == email.name) {
            let problem = ConfigProblem::Duplicate { item: NamedItem::Email, name: email.name };
            return Err(Located::new(given.name.as_ref().map_or_else(|| given.server.span(), Spanned::span), problem));
        }
        all.push(email);
    }
    Ok(all)
}

fn email(given: &EmailToml, folder: &Path) -> Result<Email, Located> {
    let (security, usual_port) = security(given.security.as_ref())?;
    let wrong_server = |problem| Located::new(given.server.span(), problem);
    let server = given.server.get_ref();
    let authority = server.parse::<Authority>().ok().filter(|it| !server.contains('@') && !it.host().is_empty());
    let authority = authority.ok_or_else(|| wrong_server(ConfigProblem::MailServer(server.clone())))?;
    let host = authority.host().trim_start_matches('[').trim_end_matches(']').to_owned();
    if security == MailSecurity::None && !is_loopback(&host) {
        return Err(wrong_server(ConfigProblem::MailWithoutTls(host)));
    }
    given.name.as_ref().map_or(Ok(()), |name| names::check(NamedItem::Email, name))?;
    let to = given.to.get_ref();
    if to.is_empty() || to.len() > MAX_RECIPIENTS {
        return Err(Located::new(given.to.span(), ConfigProblem::Recipients(to.len())));
    }
    let ca_file = given.ca_file.as_ref().map(|file| {
        let path = folder.join(file.get_ref());
        let wrong = |error| Located::new(file.span(), ConfigProblem::Certificates(error));
        ca_certificates(&path).map_err(wrong).map(|_| path)
    });
    Ok(Email {
        name: given.name.as_ref().map_or_else(|| host.clone(), |name| name.get_ref().clone()),
        port: authority.port_u16().unwrap_or(usual_port),
        host,
        security,
        from: mailbox(&given.from)?,
        to: to.iter().map(mailbox).collect::<Result<_, _>>()?,
        credentials: credentials(given, folder)?,
        ca_file: ca_file.transpose()?,
        link: given.link.as_ref().map(link).transpose()?,
        min_priority: priority(given.priority.as_ref(), Priority::Low)?,
        unacknowledged_after: unacknowledged_after(given.unacknowledged_after.as_ref())?,
        quiet: given.quiet.as_ref().map(quiet_hours).transpose()?,
    })
}

fn security(given: Option<&Spanned<String>>) -> Result<(MailSecurity, u16), Located> {
    let word = given.map_or("starttls", |given| given.get_ref().as_str());
    let found = MailSecurity::ALL.into_iter().find(|(known, ..)| *known == word);
    let span = given.map(Spanned::span).unwrap_or_default();
    let (_, security, port) = found.ok_or_else(|| Located::new(span, ConfigProblem::MailSecurity(word.to_owned())))?;
    Ok((security, port))
}

#[cfg(not(feature = "email"))]
fn mailbox(given: &Spanned<String>) -> Result<Mailbox, Located> {
    Err(Located::new(given.span(), ConfigProblem::WithoutEmail))
}

#[cfg(feature = "email")]
fn mailbox(given: &Spanned<String>) -> Result<Mailbox, Located> {
    let text = given.get_ref();
    let wrong = || Located::new(given.span(), ConfigProblem::MailAddress(text.clone()));
    if text.chars().any(char::is_control) {
        return Err(wrong());
    }
    text.parse().map_err(|_| wrong())
}

fn credentials(given: &EmailToml, folder: &Path) -> Result<Option<(String, Secret)>, Located> {
    match (&given.user, &given.password_file) {
        (None, None) => Ok(None),
        (Some(user), Some(file)) => Ok(Some((user.get_ref().clone(), password_of_file(file, folder)?))),
        (Some(user), None) => Err(Located::new(user.span(), ConfigProblem::MailCredentials)),
        (None, Some(file)) => Err(Located::new(file.span(), ConfigProblem::MailCredentials)),
    }
}

fn link(given: &Spanned<Parsed<Uri>>) -> Result<String, Located> {
    let url = &given.get_ref().0;
    let is_http = matches!(url.scheme_str(), Some("http" | "https"));
    if !is_http || url.authority().is_none_or(|authority| authority.as_str().contains('@')) {
        return Err(Located::new(given.span(), ConfigProblem::MailLink(url.to_string())));
    }
    Ok(url.to_string().trim_end_matches('/').to_owned())
}
