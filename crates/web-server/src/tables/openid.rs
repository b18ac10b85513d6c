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

use super::certificates::ca_certificates;
use super::error::{ConfigProblem, Located, MAX_OPENID_TEXT as MAX_TEXT, NamedItem, OpenIdProblem};
use super::names;
use super::webhooks::password_of_file;
use crate::auth::Role;
use crate::auth::openid::settings::TIMEOUT;
use crate::auth::openid::{ClientSecret, OpenIdSettings};
use crate::host_name::{host, is_loopback};
use hyper::Uri;
use serde::Deserialize;
use std::net::SocketAddr;
use std::path::{Path, PathBuf};
use toml::Spanned;

/// The claim with the name of the user, if the file has none (OpenID Connect Core 1.0, 5.1).
const USER_CLAIM: &str = "preferred_username";

/// The scope besides `openid`, if the file has none: that of the name.
const SCOPE: &str = "profile";

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
        self.name.as_ref().map_or(Ok(()), |name| names::check(NamedItem::Provider, name))?;
        let claim = |claim: &Spanned<String>| text("a claim", claim);
        let scopes = self.scopes.as_ref().map(|scopes| scopes.iter().map(|scope| text("a scope", scope)).collect());
        let certificates = |file: &Spanned<PathBuf>| {
            let wrong = |error| Located::new(file.span(), ConfigProblem::Certificates(error));
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

fn located<T>(at: &Spanned<T>, problem: OpenIdProblem) -> Located {
    Located::new(at.span(), ConfigProblem::OpenId(problem))
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

#[cfg(test)]
mod tests {
    use super::super::{Config, NamedItem};
    use super::*;
    use std::fs;
    use std::os::unix::fs::PermissionsExt;
    use tempfile::TempDir;

    const SEGMENT: &str = "[[segment]]\nname = \"hall\"\nport = \"/dev/ttyUSB0\"\n";

    const OPENID: &str = "[openid]\nissuer = \"https://login.example/realms/lab\"\nclient-id = \"profivac\"\n\
        client-secret-file = \"openid.secret\"\nroles-claim = \"realm_access.roles\"\n";

    const ROLES: &str =
        "[openid.roles]\noperator = [\"vacuum\"]\nengineer = [\"vacuum-engineer\", \"staff of the lab\"]\n";

    /// A folder with the secret.
    fn folder(mode: u32) -> TempDir {
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join("openid.secret");
        fs::write(&file, "s3cret: & more\n").unwrap();
        fs::set_permissions(&file, fs::Permissions::from_mode(mode)).unwrap();
        folder
    }

    fn parse(text: &str) -> Result<Config, String> {
        let folder = folder(0o600);
        let file = folder.path().join("hall.toml");
        Config::parse(text, &file).map_err(|error| error.to_string().replace(&file.display().to_string(), "hall.toml"))
    }

    #[test]
    fn a_table_describes_a_provider() {
        let config = parse(&format!("{OPENID}{ROLES}{SEGMENT}")).unwrap();
        assert!(config.is_private(), "the file names a secret");
        assert!(matches!(config.access(), crate::auth::Access::Users(_)), "the users' file must exist");
        let settings = config.openid.unwrap();
        let OpenIdSettings { name, issuer, client_id, url, user_claim, roles_claim, scopes, .. } = &settings;
        assert_eq!((name.as_str(), issuer.as_str()), ("login.example", "https://login.example/realms/lab"));
        assert_eq!((client_id.as_str(), url), ("profivac", &None));
        assert_eq!((user_claim.as_str(), roles_claim.as_str()), ("preferred_username", "realm_access.roles"));
        assert_eq!(scopes, &["profile"]);
        assert_eq!(settings.client_secret.0, "s3cret: & more");
        let roles =
            [("vacuum", Role::Operator), ("vacuum-engineer", Role::Engineer), ("staff of the lab", Role::Engineer)];
        assert_eq!(settings.roles, roles.map(|(value, role)| (value.to_owned(), role)));
        assert!(!format!("{settings:?}").contains("s3cret"));
    }

    #[test]
    fn wrong_values_are_errors_with_their_position() {
        let with = |line: &str| parse(&format!("{OPENID}{line}\n{ROLES}{SEGMENT}")).unwrap_err();
        let replaced =
            |old: &str, new: &str| parse(&format!("{OPENID}{ROLES}{SEGMENT}").replace(old, new)).unwrap_err();
        for issuer in [
            "http://login.example",
            "login.example",
            "https://",
            "https://a@login.example",
            "https://login.example?a",
            "https://login.example/#a",
            "ftp://login.example",
            "https://lög.example",
            "",
        ] {
            let error = replaced("https://login.example/realms/lab", issuer);
            assert!(error.starts_with("hall.toml:2:10: expected an issuer like https://"), "{issuer}: {error}");
        }
        for (line, expected) in [
            ("name = \"\"", "hall.toml:6:8: expected a name for the provider, found an empty string"),
            ("url = \"https://vacuum.example/dashboard\"", "hall.toml:6:7: expected the address of the dashboard like"),
            ("url = \"https://vacuum.example:443\"", "hall.toml:6:7: expected the address of the dashboard like"),
            ("url = \"http://vacuum.example\"", "hall.toml:6:7: expected the address of the dashboard like"),
            (
                "url = \"https://vacuum.example\"",
                "hall.toml:6:7: expected one of the names in hosts, found \"vacuum.example\"",
            ),
            ("user-claim = \"\"", "hall.toml:6:14: expected a claim of 1 to 255 visible ASCII characters, found \"\""),
            (
                "scopes = [\"a b\"]",
                "hall.toml:6:11: expected a scope of 1 to 255 visible ASCII characters, found \"a b\"",
            ),
            ("ca-file = \"none.pem\"", "none.pem cannot be read"),
            ("issuer-url = \"a\"", "hall.toml:6:1: unknown field `issuer-url`"),
        ] {
            let error = with(line);
            assert!(error.contains(expected), "{line}: {error}");
        }
        for (old, new, expected) in [
            ("\"profivac\"", "\"\"", "hall.toml:3:13: expected an identifier of 1 to 255 visible ASCII characters"),
            ("openid.secret", "none", "none cannot be read"),
            ("[\"vacuum\"]", "[\"vacuum-engineer\"]", "\"vacuum-engineer\" has two roles; delete one of both"),
            ("[\"vacuum\"]", "[\"a\\u0007\"]", "expected a value of the claim of 1 to 255"),
            ("engineer = [\"vacuum-engineer\", \"staff of the lab\"]\n", "boss = [\"a\"]\n", "unknown field `boss`"),
            ("roles-claim = \"realm_access.roles\"\n", "", "missing field `roles-claim`"),
        ] {
            let error = replaced(old, new);
            assert!(error.contains(expected), "{new}: {error}");
        }
        let none = parse(&format!("{OPENID}[openid.roles]\n{SEGMENT}")).unwrap_err();
        assert!(none.contains("expected in [openid.roles] at least one value"), "{none}");
        assert_eq!(NamedItem::Provider.to_string(), "provider");
    }

    #[test]
    fn a_secret_that_others_can_read_is_refused() {
        let folder = folder(0o640);
        let error = Config::parse(&format!("{OPENID}{ROLES}{SEGMENT}"), &folder.path().join("hall.toml")).unwrap_err();
        assert!(
            error.to_string().contains("openid.secret is open to others (mode 640)")
                || error.to_string().contains("(mode 640): chmod 600"),
            "{error}"
        );
    }

    #[test]
    fn the_address_is_one_under_which_the_station_answers() {
        let with = |station: &str, url: &str| {
            let url = if url.is_empty() { String::new() } else { format!("url = {url:?}\n") };
            parse(&format!("[station]\n{station}\n{OPENID}{url}{ROLES}{SEGMENT}"))
                .map(|config| config.openid.unwrap().url)
        };
        let (hosts, public) = ("hosts = [\"vacuum.example\"]", "listen = \"0.0.0.0:8443\"");
        let found = |url: &str| Ok(Some(url.to_owned()));
        assert_eq!(with("", ""), Ok(None));
        assert_eq!(with("", "http://localhost:8080/"), found("http://localhost:8080"));
        assert_eq!(with(hosts, "https://vacuum.example"), found("https://vacuum.example"));
        assert_eq!(with(public, "https://any.example:8443"), found("https://any.example:8443"));
        for station in [hosts, public] {
            let error = with(station, "").unwrap_err();
            assert!(error.contains("expected url, the address of the dashboard"), "{station}: {error}");
        }
        for (station, url) in
            [(hosts, "https://other.example"), (public, "http://any.example:8443"), ("", "https://[::2]")]
        {
            with(station, url).unwrap_err();
        }
    }
}
