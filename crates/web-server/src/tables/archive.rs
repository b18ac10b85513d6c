//! What the file of a station and that of an archive say alike about the way between them: names, tokens, servers of NATS.

use super::{Credentials, Located, TableProblem, ca_file, credentials_file};
use crate::host_name::is_loopback;
use hyper::Uri;
use profivac_host::text_file::Parsed;
use serde::Deserialize;
use std::path::{Path, PathBuf};
use toml::Spanned;

/// The most characters of a name in a subject.
const LONGEST_NAME: usize = 60;

/// The shortest token of a station: 16 random characters cannot be guessed.
pub const SHORTEST_TOKEN: usize = 16;

/// Servers of NATS, and how to log in there.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Nats {
    /// Their URLs: `nats://` or `tls://`, with host and port.
    pub servers: Vec<String>,
    /// Every connection uses TLS.
    pub tls: bool,
    /// User and password.
    pub credentials: Option<Credentials>,
    /// Certificates that are trusted in addition to those of the system.
    pub ca_file: Option<PathBuf>,
}

impl Nats {
    /// The first host to which the connection leaves this computer without encryption.
    #[must_use]
    pub fn exposed(&self) -> Option<&str> {
        let hosts = self.servers.iter().filter_map(|url| url.strip_prefix("nats://")?.rsplit_once(':'));
        hosts.map(|(host, _port)| host).find(|host| !is_loopback(host))
    }
}

/// The reason why the servers of NATS cannot be used.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum NatsProblem {
    /// No server.
    #[error("expected at least one server in servers of the table nats, found none")]
    NoServer,
    /// The URL is not that of a server.
    #[error("expected a URL like tls://nats.example:4222, without a user")]
    Server,
    /// Servers with and without TLS.
    #[error("the first server has tls://, and this one nats://: give all servers the same scheme")]
    MixedServers,
    /// The connection to another computer is unencrypted, and the file does not say that this is intended.
    #[error(
        "expected tls:// for a server on another computer, found nats://, with which everybody on the way reads the values and the \
         password: use tls://, or write unencrypted = true if the network is separate"
    )]
    Unencrypted,
}

/// `[archive.nats]`, and `[nats]` in the file of the archive.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields, rename_all = "kebab-case")]
pub struct NatsToml {
    /// URLs of the servers: `tls://` or `nats://`, with host and port.
    servers: Vec<Spanned<Parsed<Uri>>>,
    /// `true` permits `nats://` to another computer. Default: `false`.
    #[serde(default)]
    unencrypted: bool,
    /// A TOML file with `user` and `password`, which only its owner may read.
    credentials: Option<Spanned<PathBuf>>,
    /// Certificates in PEM that are trusted in addition to those of the system.
    ca_file: Option<Spanned<PathBuf>>,
}

impl NatsToml {
    /// The settings. `span` is shown where the list of servers is empty.
    ///
    /// # Errors
    /// Where the file is wrong, and why.
    pub fn into_settings(self, path: &Path, span: std::ops::Range<usize>) -> Result<Nats, Located> {
        let folder = path.parent().unwrap_or(Path::new(""));
        let Some(first) = self.servers.first() else {
            return Err(Located::new(span, TableProblem::Nats(NatsProblem::NoServer)));
        };
        let tls = first.get_ref().0.scheme_str() == Some("tls");
        let servers = self.servers.iter().map(|url| server(url, tls, self.unencrypted)).collect::<Result<_, _>>()?;
        let credentials = self.credentials.as_ref().map(|file| credentials_file(file, folder)).transpose()?;
        let ca_file = self.ca_file.map(|file| ca_file(&file, folder)).transpose()?;
        Ok(Nats { servers, tls, credentials, ca_file })
    }
}

/// The URL of a server.
fn server(url: &Spanned<Parsed<Uri>>, tls: bool, unencrypted: bool) -> Result<String, Located> {
    let uri = &url.get_ref().0;
    let Some(authority) = uri.authority().filter(|authority| !authority.as_str().contains('@')) else {
        return Err(located(url, NatsProblem::Server));
    };
    match uri.scheme_str() {
        Some("tls") if tls => {}
        Some("nats") if tls => return Err(located(url, NatsProblem::MixedServers)),
        Some("nats") if unencrypted || is_loopback(authority.host()) => {}
        Some("nats") => return Err(located(url, NatsProblem::Unencrypted)),
        _ => return Err(located(url, NatsProblem::Server)),
    }
    let scheme = if tls { "tls" } else { "nats" };
    Ok(format!("{scheme}://{}:{}", authority.host(), authority.port_u16().unwrap_or(4222)))
}

/// Whether a text can be the name of a plant or station in an archive: it is a part of subjects and of URLs.
#[must_use]
pub fn is_name(text: &str) -> bool {
    let is_known = |character: char| character.is_ascii_alphanumeric() || matches!(character, '-' | '_');
    !text.is_empty() && text.len() <= LONGEST_NAME && text.chars().all(is_known)
}

fn located<T>(value: &Spanned<T>, problem: NatsProblem) -> Located {
    Located::new(value.span(), TableProblem::Nats(problem))
}
