//! `[openid]`: an OpenID provider at which users may log in, besides the users' file.
//!
//! ```toml
//! [openid]
//! name = "Keycloak"                              # on the button; default: the host of the issuer
//! issuer = "https://login.example/realms/lab"    # exactly as the provider names itself
//! client-id = "profivac"
//! client-secret-file = "openid.secret"           # relative to this file
//! url = "https://vacuum.example:8443"            # the address of the dashboard; the provider sends browsers to /openid there
//! user-claim = "preferred_username"              # the name of the user; this is the default
//! roles-claim = "realm_access.roles"             # a claim, or the path to one
//! scopes = ["profile"]                           # besides openid; this is the default
//! ca-file = "our-ca.pem"                         # trusted in addition to the certificates of the system
//!
//! [openid.roles]                                 # values of the claim
//! viewer = ["vacuum-viewer"]
//! operator = ["vacuum-operator"]
//! engineer = ["vacuum-engineer"]
//! ```

use super::{Located, TableProblem, ca_certificates, password_of_file};
use crate::auth::Role;
use crate::auth::openid::settings::TIMEOUT;
use crate::auth::openid::{ClientSecret, OpenIdSettings};
use crate::host_name::{host, is_loopback};
use crate::visible_text::{MAX_NAME, TextProblem, check_name};
use hyper::Uri;
use serde::Deserialize;
use std::net::SocketAddr;
use std::path::{Path, PathBuf};
use toml::Spanned;

/// The claim with the name of the user, if the file has none (OpenID Connect Core 1.0, 5.1).
const USER_CLAIM: &str = "preferred_username";

/// The scope besides `openid`, if the file has none: that of the name.
const SCOPE: &str = "profile";

/// The most octets of an issuer, an identifier, a claim or a scope of `[openid]`. chosen.
const MAX_TEXT: usize = 255;

/// Why a value of `[openid]` cannot be used.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum OpenIdProblem {
    /// The issuer is none.
    #[error(
        "expected an issuer like https://login.example/realms/lab, or with http one on this computer, without a user, ? and #, found {0:?}"
    )]
    Issuer(String),
    /// The address of the dashboard is none.
    #[error(
        "expected the address of the dashboard like https://vacuum.example:8443, without a path and without the port that browsers leave \
         out (443 of https, 80 of http), found {0:?}"
    )]
    Url(String),
    /// The station does not answer under this address.
    #[error(
        "expected one of the names in hosts, found {0:?}; add it to hosts, or the station refuses browsers that come back there"
    )]
    UrlHost(String),
    /// Browsers reach the station under names that it does not know.
    #[error(
        "expected url, the address of the dashboard like https://vacuum.example:8443: the station has hosts, or listens beyond loopback"
    )]
    NoUrl,
    /// The name of the provider is empty.
    #[error("expected a name for the provider, found an empty string")]
    NoName,
    /// The name of the provider has characters that are not visible, or is a path.
    #[error(transparent)]
    Name(TextProblem),
    /// The name of the provider has too many characters.
    #[error("expected a provider of at most {MAX_NAME} characters, found {0}; shorten it")]
    LongName(usize),
    /// An identifier, a claim or a scope is empty, too long or has other characters.
    #[error("expected {expected} of 1 to {MAX_TEXT} visible ASCII characters, found {found:?}")]
    Text {
        /// The expected text.
        expected: &'static str,
        /// The value.
        found: String,
    },
    /// No value of the claim has a role.
    #[error("expected in [openid.roles] at least one value of the claim for viewer, operator or engineer")]
    NoRoles,
    /// A value of the claim has two roles.
    #[error("{0:?} has two roles; delete one of both")]
    TwoRoles(String),
}

/// Under which names browsers reach the server.
pub struct Reach<'a> {
    /// The address of the server.
    pub listen: SocketAddr,
    /// Names and addresses in the file.
    pub hosts: &'a [String],
}

/// `[openid]`.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields, rename_all = "kebab-case")]
pub struct OpenIdToml {
    /// The name of the provider on the button of the login. Default: the host of `issuer`.
    name: Option<Spanned<String>>,
    /// The issuer, exactly as the provider names itself: `https://`, or `http://` on this computer.
    issuer: Spanned<String>,
    /// The identifier of the station at the provider.
    client_id: Spanned<String>,
    /// The file with the secret of the station at the provider, beside this file, which only its owner may read.
    client_secret_file: Spanned<PathBuf>,
    /// The address of the dashboard as browsers use it, such as `https://vacuum.example:8443`; the provider sends them to `/openid` there.
    /// Needed with `hosts` and beyond loopback. Default: the address of the server.
    url: Option<Spanned<String>>,
    /// The claim with the name of the user. Default: `preferred_username`.
    user_claim: Option<Spanned<String>>,
    /// The claim with the roles or groups of the user, or the path to it, such as `realm_access.roles`.
    roles_claim: Spanned<String>,
    /// What the station asks for besides `openid`. Default: `profile`.
    scopes: Option<Vec<Spanned<String>>>,
    /// Certificates in PEM that are trusted in addition to those of the system.
    ca_file: Option<Spanned<PathBuf>>,
    /// The roles at this station by values of the claim; the highest one counts.
    roles: Spanned<OpenIdRolesToml>,
}

/// `[openid.roles]`.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct OpenIdRolesToml {
    /// Values of the claim that make a viewer.
    #[serde(default)]
    viewer: Vec<Spanned<String>>,
    /// Values of the claim that make an operator.
    #[serde(default)]
    operator: Vec<Spanned<String>>,
    /// Values of the claim that make an engineer.
    #[serde(default)]
    engineer: Vec<Spanned<String>>,
}

impl OpenIdToml {
    /// The checked settings. Files are in `folder`.
    ///
    /// # Errors
    /// An error with the position and the problem.
    pub fn settings(&self, folder: &Path, reach: &Reach<'_>) -> Result<OpenIdSettings, Located> {
        let issuer_host = issuer_host(&self.issuer)?;
        self.name.as_ref().map_or(Ok(()), check_provider)?;
        let claim = |claim: &Spanned<String>| text("a claim", claim);
        let scopes = self.scopes.as_ref().map(|scopes| scopes.iter().map(|scope| text("a scope", scope)).collect());
        let certificates = |file: &Spanned<PathBuf>| {
            let wrong = |error| Located::new(file.span(), TableProblem::Certificates(error));
            ca_certificates(&folder.join(file.get_ref())).map_err(wrong)
        };
        Ok(OpenIdSettings {
            name: self.name.as_ref().map_or(issuer_host, |name| name.get_ref().clone()),
            issuer: self.issuer.get_ref().clone(),
            client_id: text("an identifier", &self.client_id)?,
            client_secret: ClientSecret(password_of_file(&self.client_secret_file, folder)?.reveal().to_owned()),
            url: self.url(reach)?,
            user_claim: self.user_claim.as_ref().map_or_else(|| Ok(USER_CLAIM.to_owned()), claim)?,
            roles_claim: claim(&self.roles_claim)?,
            roles: roles(&self.roles)?,
            scopes: scopes.unwrap_or_else(|| Ok(vec![SCOPE.to_owned()]))?,
            trusted: self.ca_file.as_ref().map(certificates).transpose()?.unwrap_or_default(),
            timeout: TIMEOUT,
        })
    }

    /// The address of the dashboard without a final slash, under which the station answers.
    fn url(&self, Reach { listen, hosts }: &Reach<'_>) -> Result<Option<String>, Located> {
        let is_near = listen.ip().is_loopback();
        let Some(given) = &self.url else {
            let is_known = is_near && hosts.is_empty();
            return if is_known { Ok(None) } else { Err(located(&self.issuer, OpenIdProblem::NoUrl)) };
        };
        let wrong = || located(given, OpenIdProblem::Url(given.get_ref().clone()));
        let text = given.get_ref().strip_suffix('/').unwrap_or(given.get_ref());
        let url: Uri = text.parse().map_err(|_| wrong())?;
        let origin = origin(&url).ok_or_else(wrong)?;
        let usual_port = if url.scheme_str() == Some("https") { 443 } else { 80 };
        if !origin.eq_ignore_ascii_case(text) || url.port_u16() == Some(usual_port) {
            return Err(wrong());
        }
        let name = url.host().and_then(host).unwrap_or_default();
        let is_accepted = hosts.iter().any(|host| host.eq_ignore_ascii_case(&name))
            || (is_near && is_loopback(&name))
            || (!is_near && hosts.is_empty());
        if is_accepted { Ok(Some(origin)) } else { Err(located(given, OpenIdProblem::UrlHost(name))) }
    }
}

/// Checks the name of a provider.
fn check_provider(name: &Spanned<String>) -> Result<(), Located> {
    let text = name.get_ref();
    check_name(text).map_err(|problem| {
        let is_empty = problem == TextProblem::Empty;
        located(name, if is_empty { OpenIdProblem::NoName } else { OpenIdProblem::Name(problem) })
    })?;
    let found = text.chars().count();
    if found > MAX_NAME { Err(located(name, OpenIdProblem::LongName(found))) } else { Ok(()) }
}

fn located<T>(at: &Spanned<T>, problem: OpenIdProblem) -> Located {
    Located::new(at.span(), TableProblem::OpenId(problem))
}

/// Scheme, host and port of a URL that is https, or http to this computer, and names no user.
fn origin(url: &Uri) -> Option<String> {
    let authority = url.authority()?.as_str();
    let is_protected = match url.scheme_str() {
        Some("https") => true,
        Some("http") => is_loopback(authority),
        _ => false,
    };
    (is_protected && host(authority).is_some())
        .then(|| format!("{}://{authority}", url.scheme_str().unwrap_or_default()))
}

/// The host of an issuer.
fn issuer_host(issuer: &Spanned<String>) -> Result<String, Located> {
    let text = issuer.get_ref();
    let wrong = || located(issuer, OpenIdProblem::Issuer(text.chars().take(MAX_TEXT).collect()));
    let is_plain = text.len() <= MAX_TEXT && text.is_ascii() && !text.contains(['?', '#', ' ']);
    let url: Uri = text.parse().map_err(|_| wrong())?;
    origin(&url).filter(|_| is_plain).ok_or_else(wrong)?;
    url.host().and_then(host).ok_or_else(wrong)
}

/// A text of visible ASCII.
fn text(expected: &'static str, given: &Spanned<String>) -> Result<String, Located> {
    let text = given.get_ref();
    let is_usable = (1..=MAX_TEXT).contains(&text.len()) && text.bytes().all(|octet| octet.is_ascii_graphic());
    let found = || text.chars().take(MAX_TEXT).collect();
    if is_usable { Ok(text.clone()) } else { Err(located(given, OpenIdProblem::Text { expected, found: found() })) }
}

/// The values of the claim with their roles.
fn roles(given: &Spanned<OpenIdRolesToml>) -> Result<Vec<(String, Role)>, Located> {
    let OpenIdRolesToml { viewer, operator, engineer } = given.get_ref();
    let all = [(viewer, Role::Viewer), (operator, Role::Operator), (engineer, Role::Engineer)];
    let mut roles: Vec<(String, Role)> = Vec::new();
    for (value, role) in all.into_iter().flat_map(|(values, role)| values.iter().map(move |value| (value, role))) {
        // A group may have spaces.
        let text = value.get_ref();
        if text.is_empty() || text.len() > MAX_TEXT || text.chars().any(char::is_control) {
            let found = text.chars().take(MAX_TEXT).collect();
            return Err(located(value, OpenIdProblem::Text { expected: "a value of the claim", found }));
        }
        if roles.iter().any(|(other, _)| other == text) {
            return Err(located(value, OpenIdProblem::TwoRoles(text.clone())));
        }
        roles.push((text.clone(), role));
    }
    if roles.is_empty() { Err(located(given, OpenIdProblem::NoRoles)) } else { Ok(roles) }
}
