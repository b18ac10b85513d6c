//! The file of an archive.
//!
//! ```toml
//! [archive]
//! samples-days = 730            # how long samples are kept; spans, events, alarms and audit stay
//! replicas = 3                  # of the stream: the number of servers that hold each batch
//! stream-octets = 10_000_000_000
//!
//! [nats]
//! servers = ["tls://nats-1.example", "tls://nats-2.example", "tls://nats-3.example"]
//! credentials = "nats.credentials"
//!
//! [postgres]
//! connection = "host=db.example user=profivac dbname=profivac"
//! password-file = "postgres.password"
//! ca-file = "our-ca.pem"        # trusted in addition to the certificates of the system
//!
//! [https]                       # for stations without NATS; with it, [nats] may be absent
//! listen = "0.0.0.0:8443"       # beyond loopback with [https.tls] only
//!
//! [https.tls]
//! certificate = "archive.pem"
//! key = "archive.key"
//!
//! [[station]]                   # each station that sends over HTTPS
//! plant = "hall"
//! name = "hall-1"
//! token-file = "hall-1.token"   # the same text as in the file of that name at the station
//!
//! [view]                        # the page of all stations
//! listen = "127.0.0.1:8090"     # beyond loopback with [view.tls] and users only
//! users = "archive.users"       # `profivac user add` makes it; without it every user of this computer may look
//! hosts = ["archive.example"]   # names of this computer, without ports
//!
//! [prometheus]                  # metrics of the archive itself
//! listen = "127.0.0.1:9465"     # beyond loopback with [prometheus.tls] and token-file only
//!
//! [[plant]]
//! name = "hall"
//! readers = ["hall_operators"]  # roles of PostgreSQL that may read the stations of this plant
//! users = ["ada"]               # users of the page who see them; unless given, all users
//! ```

use crate::database::{Database, DatabaseProblem, PostgresToml};
use profivac_host::text_file::{self, line_and_column};
use profivac_web_server::auth::openid::OpenIdSettings;
use profivac_web_server::server::TlsFiles;
use profivac_web_server::tables::archive::{Nats, NatsToml, SHORTEST_TOKEN, is_name};
use profivac_web_server::tables::openid::{OpenIdToml, Reach};
use profivac_web_server::tables::{Secret, secret_of_file};
use serde::Deserialize;
use std::net::{Ipv4Addr, SocketAddr};
use std::path::{Path, PathBuf};
use thiserror::Error;
use toml::Spanned;

/// How long samples are kept, unless the file says otherwise.
const SAMPLES_DAYS: i64 = 730;

/// The most octets of the stream, unless the file says otherwise: 10 GB.
const STREAM_OCTETS: i64 = 10_000_000_000;

/// The least octets of the stream: some batches of the largest size. chosen.
const LEAST_STREAM_OCTETS: i64 = 10_000_000;

/// Where the archive serves its metrics, unless the file says otherwise.
const METRICS: (Ipv4Addr, u16) = (Ipv4Addr::LOCALHOST, 9465);

/// A plant: a group of stations.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Plant {
    /// Its name.
    pub name: String,
    /// Roles of PostgreSQL that may read its stations.
    pub readers: Vec<String>,
    /// Users of the view who see its stations; `None`: all.
    pub users: Option<Vec<String>>,
}

/// The settings of an archive.
#[derive(Clone, Debug)]
pub struct Config {
    /// How many days samples are kept.
    pub samples_days: u32,
    /// The number of servers that hold each batch.
    pub replicas: usize,
    /// The most octets of the stream: when it is full, batches stay at their stations.
    pub stream_octets: i64,
    /// The servers of NATS, if stations send there.
    pub nats: Option<Nats>,
    /// Where stations send without NATS.
    pub https: Option<Https>,
    /// The database.
    pub database: Database,
    /// Plants, with those who may read them.
    pub plants: Vec<Plant>,
    /// The page of all stations, if the archive serves it.
    pub view: Option<View>,
    /// Its metrics, if the archive serves them.
    pub prometheus: Option<Prometheus>,
}

/// Where the archive serves its metrics.
#[derive(Clone, Debug)]
pub struct Prometheus {
    /// The address to listen on. With port 0 the system chooses a port.
    pub listen: SocketAddr,
    /// The bearer token that a scrape must have; absent on loopback only.
    pub token: Option<Secret>,
    /// Certificate and key; absent on loopback only.
    pub tls: Option<TlsFiles>,
}

/// Where the archive serves the page of all stations.
#[derive(Clone, Debug)]
pub struct View {
    /// The address to listen on. With port 0 the system chooses a port.
    pub listen: SocketAddr,
    /// The file of the users who log in; without it every user of this computer may look.
    pub users: Option<PathBuf>,
    /// Host names and addresses of this computer, without ports.
    pub hosts: Vec<String>,
    /// Certificate and key; absent on loopback only.
    pub tls: Option<TlsFiles>,
    /// The OpenID provider at which users may log in besides.
    pub openid: Option<OpenIdSettings>,
}

/// Where the archive takes batches over HTTPS.
#[derive(Clone, Debug)]
pub struct Https {
    /// The address to listen on. With port 0 the system chooses a port.
    pub listen: SocketAddr,
    /// Certificate and key; absent on loopback only.
    pub tls: Option<TlsFiles>,
    /// The stations that may send.
    pub stations: Vec<Sender>,
}

/// A station that sends over HTTPS.
#[derive(Clone, Debug)]
pub struct Sender {
    /// Its plant.
    pub plant: String,
    /// Its name in the archive.
    pub name: String,
    /// Its token.
    pub token: Secret,
}

/// The reason why a file is no file of an archive.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum ConfigError {
    /// The file cannot be read.
    #[error("{file} cannot be read: {error}", file = file.display())]
    Read {
        /// The file.
        file: PathBuf,
        /// The error of the system.
        error: std::io::Error,
    },
    /// A position of the file is wrong.
    #[error("{file}:{line}:{column}: {message}", file = file.display())]
    Position {
        /// The file.
        file: PathBuf,
        /// The line, from 1.
        line: usize,
        /// The column, from 1.
        column: usize,
        /// The fault.
        message: String,
    },
    /// `[postgres]` is wrong.
    #[error("{file}: {problem}", file = file.display())]
    Database {
        /// The file.
        file: PathBuf,
        /// The fault.
        problem: DatabaseProblem,
    },
    /// A value is out of range.
    #[error("{file}: {problem}", file = file.display())]
    Value {
        /// The file.
        file: PathBuf,
        /// The fault.
        problem: ValueProblem,
    },
}

/// A number in `[archive]` that is out of range, or a table that does not fit the others.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Error)]
#[non_exhaustive]
pub enum ValueProblem {
    /// Neither `[nats]` nor `[https]`.
    #[error("expected [nats], [https] or both, found neither: no batch would come")]
    NoSource,
    /// `[[station]]` without `[https]`.
    #[error("[[station]] belongs to [https], which is absent: add it, or delete [[station]]")]
    NoHttps,
    /// `[https]` without `[[station]]`.
    #[error(
        "expected a [[station]] with plant, name and token-file for each station that sends to [https], found none"
    )]
    NoStations,
    /// `[https]` on an address that other computers reach, without `[https.tls]`.
    #[error("listening beyond loopback on {0} needs TLS: add [https.tls] with certificate and key")]
    NeedsTls(SocketAddr),
    /// `[view]` on an address that other computers reach, without `[view.tls]`.
    #[error("listening beyond loopback on {0} needs TLS: add [view.tls] with certificate and key")]
    ViewNeedsTls(SocketAddr),
    /// `[prometheus]` on an address that other computers reach, without `[prometheus.tls]` or `token-file`.
    #[error(
        "listening beyond loopback on {0} needs TLS and a token: add [prometheus.tls] with certificate and key, and token-file to [prometheus]"
    )]
    MetricsNeedTls(SocketAddr),
    /// `[view]` on an address that other computers reach, or behind a proxy, without users.
    #[error(
        "a page that other computers reach, or that has [view.openid], needs users: add users = \"archive.users\" to [view], and `profivac user add NAME \
         --role viewer FILE.toml` adds the first"
    )]
    ViewNeedsUsers,
    /// `users` of a `[[plant]]`, and a page without a login.
    #[error(
        "users of [[plant]] are users of the page: add users = \"archive.users\" to [view], or delete users of [[plant]]"
    )]
    PlantNeedsUsers,
    /// The archive has no users.
    #[error("expected users = \"archive.users\" in [view], found none: the page of this archive has no users")]
    NoUsersFile,
    /// `replicas`.
    #[error("expected replicas = 1, 3 or 5, found {0}")]
    Replicas(i64),
    /// `samples-days`.
    #[error("expected samples-days from 1 to 36525, found {0}")]
    SamplesDays(i64),
    /// `stream-octets`.
    #[error("expected stream-octets of at least 10000000, found {0}")]
    StreamOctets(i64),
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct Toml {
    /// Retention and the stream.
    #[serde(default)]
    archive: ArchiveToml,
    /// Servers of NATS, if stations send there.
    nats: Option<NatsToml>,
    /// Where stations send without NATS.
    https: Option<HttpsToml>,
    /// The database.
    postgres: PostgresToml,
    /// A station that sends over HTTPS.
    #[serde(default)]
    station: Vec<SenderToml>,
    /// A plant, with the roles that may read it.
    #[serde(default)]
    plant: Vec<PlantToml>,
    /// The page of all stations; without the table there is none.
    view: Option<ViewToml>,
    /// Metrics of the archive itself; without the table there are none.
    prometheus: Option<PrometheusToml>,
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields, rename_all = "kebab-case")]
struct PrometheusToml {
    /// The address. Beyond loopback it needs `tls` and `token-file`. Default: `127.0.0.1:9465`.
    listen: Option<SocketAddr>,
    /// The file with the bearer token of a scrape, which only its owner may read.
    token_file: Option<Spanned<PathBuf>>,
    /// The certificate.
    tls: Option<TlsToml>,
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct ViewToml {
    /// The address. Beyond loopback it needs `tls` and `users`.
    listen: SocketAddr,
    /// The file of the users; without it every user of this computer may look.
    users: Option<PathBuf>,
    /// Names by which browsers reach this computer, without ports.
    #[serde(default)]
    hosts: Vec<String>,
    /// The certificate.
    tls: Option<TlsToml>,
    /// An OpenID provider at which users may log in, besides the file of the users, which it needs.
    openid: Option<OpenIdToml>,
}

#[derive(Debug, Default, Deserialize)]
#[serde(deny_unknown_fields, rename_all = "kebab-case")]
struct ArchiveToml {
    /// How many days samples are kept, 1 to 36525. Default: 730.
    samples_days: Option<i64>,
    /// The servers that hold each batch: 1, 3 or 5, used when the stream is created. Default: 1.
    replicas: Option<i64>,
    /// The most octets of the stream, at least 10000000. Default: 10000000000.
    stream_octets: Option<i64>,
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct HttpsToml {
    /// The address. Beyond loopback it needs `tls`.
    listen: SocketAddr,
    /// The certificate.
    tls: Option<TlsToml>,
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct TlsToml {
    /// The certificate in PEM, followed by its chain; read again each minute.
    certificate: PathBuf,
    /// Its private key in PEM, which only its owner may read.
    key: PathBuf,
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields, rename_all = "kebab-case")]
struct SenderToml {
    /// The plant of the station.
    plant: Spanned<String>,
    /// The name of the station in the archive.
    name: Spanned<String>,
    /// The file with its token, of at least 16 characters, which only its owner may read.
    token_file: Spanned<PathBuf>,
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct PlantToml {
    /// The name of the plant, as in the files of its stations.
    name: Spanned<String>,
    /// Roles of PostgreSQL that may read it, which exist.
    readers: Vec<String>,
    /// Users of the page who see it. Default: all users.
    users: Option<Vec<String>>,
}

impl Config {
    /// Reads a file and the files that it names.
    ///
    /// # Errors
    /// [`ConfigError`] with the position and what is expected there.
    pub fn read(file: &Path) -> Result<Self, ConfigError> {
        let text = text_file::read(file).map_err(|error| ConfigError::Read { file: file.to_owned(), error })?;
        let at = |offset: usize, message: String| {
            let (line, column) = line_and_column(&text, offset);
            ConfigError::Position { file: file.to_owned(), line, column, message }
        };
        let toml: Toml = toml::from_str(&text)
            .map_err(|error| at(error.span().map_or(0, |span| span.start), error.message().to_owned()))?;
        let folder = file.parent().unwrap_or(Path::new(""));
        let wrong = |problem| ConfigError::Value { file: file.to_owned(), problem };
        let nats = toml.nats.map(|nats| nats.into_settings(file, 0..0)).transpose();
        let nats = nats.map_err(|error| at(error.span.start, error.problem.to_string()))?;
        let plants = plants(toml.plant).map_err(|(offset, message)| at(offset, message))?;
        let stations = senders(toml.station, folder).map_err(|(offset, message)| at(offset, message))?;
        let https = https(toml.https, stations, folder).map_err(wrong)?;
        if nats.is_none() && https.is_none() {
            return Err(wrong(ValueProblem::NoSource));
        }
        let openid = toml.view.as_ref().and_then(|view| {
            let reach = Reach { listen: view.listen, hosts: &view.hosts };
            Some(view.openid.as_ref()?.settings(folder, &reach))
        });
        let openid = openid.transpose().map_err(|error| at(error.span.start, error.problem.to_string()))?;
        let view = toml.view.map(|view| self::view(view, openid, folder)).transpose().map_err(wrong)?;
        let prometheus = toml.prometheus.map(|table| {
            let token = table.token_file.as_ref().map(|file| secret_of_file(file, folder)).transpose();
            let token = token.map_err(|error| at(error.span.start, error.problem.to_string()))?;
            prometheus(table, token, folder).map_err(wrong)
        });
        let prometheus = prometheus.transpose()?;
        let has_users = view.as_ref().is_none_or(|view| view.users.is_some());
        if !has_users && plants.iter().any(|plant| plant.users.is_some()) {
            return Err(wrong(ValueProblem::PlantNeedsUsers));
        }
        let ArchiveToml { samples_days, replicas, stream_octets } = toml.archive;
        let found = replicas.unwrap_or(1);
        let replicas = usize::try_from(found).ok().filter(|it| [1, 3, 5].contains(it));
        let replicas = replicas.ok_or_else(|| wrong(ValueProblem::Replicas(found)))?;
        let found = samples_days.unwrap_or(SAMPLES_DAYS);
        let samples_days = u32::try_from(found).ok().filter(|days| (1..=36_525).contains(days));
        let samples_days = samples_days.ok_or_else(|| wrong(ValueProblem::SamplesDays(found)))?;
        let stream_octets = stream_octets.unwrap_or(STREAM_OCTETS);
        if stream_octets < LEAST_STREAM_OCTETS {
            return Err(wrong(ValueProblem::StreamOctets(stream_octets)));
        }
        Ok(Self {
            samples_days,
            replicas,
            stream_octets,
            nats,
            https,
            database: Database::new(&toml.postgres, folder)
                .map_err(|problem| ConfigError::Database { file: file.to_owned(), problem })?,
            plants,
            view,
            prometheus,
        })
    }
}

/// The file of the users of an archive; `None` if `file` is not that of an archive.
///
/// # Errors
/// [`ConfigError`] when the file of an archive names no users.
pub fn users_file(file: &Path) -> Result<Option<PathBuf>, ConfigError> {
    let Ok(text) = text_file::read(file) else { return Ok(None) };
    let Ok(tables) = text.parse::<toml::Table>() else { return Ok(None) };
    if !tables.contains_key("postgres") {
        return Ok(None);
    }
    let users = tables.get("view").and_then(|view| view.get("users")).and_then(toml::Value::as_str);
    let missing = || ConfigError::Value { file: file.to_owned(), problem: ValueProblem::NoUsersFile };
    Ok(Some(file.parent().unwrap_or(Path::new("")).join(users.ok_or_else(missing)?)))
}

/// `[view]`.
fn view(toml: ViewToml, openid: Option<OpenIdSettings>, folder: &Path) -> Result<View, ValueProblem> {
    let ViewToml { listen, users, hosts, tls, openid: _ } = toml;
    let is_near = listen.ip().is_loopback();
    if tls.is_none() && !is_near {
        return Err(ValueProblem::ViewNeedsTls(listen));
    }
    if users.is_none() && !(is_near && hosts.is_empty() && openid.is_none()) {
        return Err(ValueProblem::ViewNeedsUsers);
    }
    let tls = tls.map(|tls| tls.in_folder(folder));
    Ok(View { listen, users: users.map(|file| folder.join(file)), hosts, tls, openid })
}

/// `[prometheus]`.
fn prometheus(toml: PrometheusToml, token: Option<Secret>, folder: &Path) -> Result<Prometheus, ValueProblem> {
    let listen = toml.listen.unwrap_or(METRICS.into());
    if !listen.ip().is_loopback() && (token.is_none() || toml.tls.is_none()) {
        return Err(ValueProblem::MetricsNeedTls(listen));
    }
    Ok(Prometheus { listen, token, tls: toml.tls.map(|tls| tls.in_folder(folder)) })
}

impl TlsToml {
    fn in_folder(self, folder: &Path) -> TlsFiles {
        TlsFiles { certificate: folder.join(self.certificate), key: folder.join(self.key) }
    }
}

/// `[https]` with its stations.
fn https(toml: Option<HttpsToml>, stations: Vec<Sender>, folder: &Path) -> Result<Option<Https>, ValueProblem> {
    let Some(HttpsToml { listen, tls }) = toml else {
        return match stations.is_empty() {
            true => Ok(None),
            false => Err(ValueProblem::NoHttps),
        };
    };
    if stations.is_empty() {
        return Err(ValueProblem::NoStations);
    }
    if tls.is_none() && !listen.ip().is_loopback() {
        return Err(ValueProblem::NeedsTls(listen));
    }
    let tls = tls.map(|tls| tls.in_folder(folder));
    Ok(Some(Https { listen, tls, stations }))
}

/// The plants with their readers, or the offset of what is wrong and the reason. A plant with another name has no station.
fn plants(toml: Vec<PlantToml>) -> Result<Vec<Plant>, (usize, String)> {
    let mut all: Vec<Plant> = Vec::new();
    for PlantToml { name, readers, users } in toml {
        check_name(&name)?;
        if all.iter().any(|other| other.name == *name.get_ref()) {
            return Err((name.span().start, format!("the plant {} is given twice: join both tables", name.get_ref())));
        }
        all.push(Plant { name: name.into_inner(), readers, users });
    }
    Ok(all)
}

fn check_name(name: &Spanned<String>) -> Result<(), (usize, String)> {
    let found = name.get_ref();
    match is_name(found) {
        true => Ok(()),
        false => Err((name.span().start, format!("expected 1 to 60 letters, digits, - and _, found {found:?}"))),
    }
}

/// The stations, or the offset of what is wrong and the reason. A token and a name belong to one station.
fn senders(toml: Vec<SenderToml>, folder: &Path) -> Result<Vec<Sender>, (usize, String)> {
    let mut all: Vec<Sender> = Vec::new();
    for SenderToml { plant, name, token_file } in toml {
        for name in [&plant, &name] {
            check_name(name)?;
        }
        let start = token_file.span().start;
        let token =
            secret_of_file(&token_file, folder).map_err(|error| (error.span.start, error.problem.to_string()))?;
        let length = token.reveal().len();
        if length < SHORTEST_TOKEN {
            let expected = format!("expected a token of at least {SHORTEST_TOKEN} characters, found {length}");
            return Err((start, format!("{expected}: `openssl rand -hex 32` makes one")));
        }
        if let Some(other) = all.iter().find(|other| other.token == token) {
            return Err((start, format!("{} has the same token: give each station a token of its own", other.name)));
        }
        if all.iter().any(|other| other.name == *name.get_ref()) {
            let message = format!("the name {} is given twice: give each station a name of its own", name.get_ref());
            return Err((name.span().start, message));
        }
        all.push(Sender { plant: plant.into_inner(), name: name.into_inner(), token });
    }
    Ok(all)
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::os::unix::fs::PermissionsExt;

    fn read(text: &str) -> Result<Config, String> {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("archive.toml");
        std::fs::write(&path, text).unwrap();
        for (name, token) in
            [("a.token", "0123456789abcdef"), ("b.token", "fedcba9876543210"), ("short.token", "short")]
        {
            let file = folder.path().join(name);
            std::fs::write(&file, token).unwrap();
            std::fs::set_permissions(&file, std::fs::Permissions::from_mode(0o600)).unwrap();
        }
        Config::read(&path).map_err(|error| error.to_string())
    }

    const NATS: &str = "[nats]\nservers = [\"nats://127.0.0.1\"]\n";
    const POSTGRES: &str = "[postgres]\nconnection = \"host=/run/postgresql dbname=p\"\n";

    #[test]
    fn the_defaults_need_two_tables() {
        let config = read(&format!("{NATS}{POSTGRES}")).unwrap();
        assert_eq!((config.samples_days, config.replicas, config.stream_octets), (730, 1, 10_000_000_000));
        assert!(config.prometheus.is_none());
    }

    #[test]
    fn metrics_are_on_loopback_unless_the_file_says_otherwise() {
        let config = read(&format!("{NATS}{POSTGRES}[prometheus]\ntoken-file = \"a.token\"\n")).unwrap();
        let metrics = config.prometheus.unwrap();
        assert_eq!(metrics.listen, "127.0.0.1:9465".parse().unwrap());
        assert_eq!(metrics.token.unwrap().reveal(), "0123456789abcdef");
    }

    const HTTPS: &str = "[https]\nlisten = \"127.0.0.1:0\"\n";

    fn station(name: &str, token: &str) -> String {
        format!("[[station]]\nplant = \"hall\"\nname = \"{name}\"\ntoken-file = \"{token}.token\"\n")
    }

    #[test]
    fn an_archive_without_nats_has_stations_with_tokens() {
        let text = format!("{HTTPS}{POSTGRES}{}{}", station("hall-1", "a"), station("hall-2", "b"));
        let config = read(&text).unwrap();
        assert!(config.nats.is_none());
        let https = config.https.unwrap();
        let stations: Vec<_> = https.stations.iter().map(|it| (it.name.as_str(), it.token.reveal())).collect();
        assert_eq!(stations, [("hall-1", "0123456789abcdef"), ("hall-2", "fedcba9876543210")]);
        assert!(!format!("{https:?}").contains("0123456789abcdef"));
    }

    #[test]
    fn a_wrong_table_for_https_says_what_is_expected() {
        let one = station("hall-1", "a");
        let cases = [
            (POSTGRES.to_owned(), "expected [nats], [https] or both, found neither"),
            (format!("{HTTPS}{POSTGRES}"), "expected a [[station]] with"),
            (format!("{NATS}{POSTGRES}{one}"), "[[station]] belongs to [https]"),
            (format!("[https]\nlisten = \"0.0.0.0:8443\"\n{POSTGRES}{one}"), "0.0.0.0:8443 needs TLS: add [https.tls]"),
            (format!("{HTTPS}{POSTGRES}{one}{}", station("hall-2", "a")), "hall-1 has the same token"),
            (format!("{HTTPS}{POSTGRES}{one}{}", station("hall-1", "b")), "the name hall-1 is given twice"),
            (format!("{HTTPS}{POSTGRES}{}", station("hall-1", "short")), "at least 16 characters, found 5"),
            (format!("{HTTPS}{POSTGRES}{}", station("hall-1", "absent")), "absent.token"),
            (format!("{HTTPS}{POSTGRES}{}", station("hall.1", "a")), "archive.toml:7:8: expected 1 to 60 letters"),
            (format!("{NATS}{POSTGRES}[view]\nlisten = \"0.0.0.0:1\"\n"), "0.0.0.0:1 needs TLS: add [view.tls]"),
            (
                format!(
                    "{NATS}{POSTGRES}[view]\nlisten = \"0.0.0.0:1\"\ntls = {{ certificate = \"c\", key = \"k\" }}\n"
                ),
                "needs users: add users = \"archive.users\" to [view]",
            ),
            (
                format!("{NATS}{POSTGRES}[prometheus]\nlisten = \"0.0.0.0:1\"\ntoken-file = \"a.token\"\n"),
                "0.0.0.0:1 needs TLS and a token: add [prometheus.tls]",
            ),
            (
                format!(
                    "{NATS}{POSTGRES}[prometheus]\nlisten = \"0.0.0.0:1\"\ntls = {{ certificate = \"c\", key = \"k\" }}\n"
                ),
                "and token-file to [prometheus]",
            ),
            (format!("{NATS}{POSTGRES}[prometheus]\ntoken-file = \"absent\"\n"), "archive.toml:6:14: "),
            (format!("{NATS}{POSTGRES}[view]\nlisten = \"[::1]:1\"\nhosts = [\"a.example\"]\n"), "needs users"),
            (
                format!(
                    "{NATS}{POSTGRES}[view]\nlisten = \"[::1]:1\"\n[[plant]]\nname = \"a\"\nreaders = []\nusers = [\"ada\"]\n"
                ),
                "users of [[plant]] are users of the page",
            ),
            (
                format!(
                    "{NATS}{POSTGRES}[[plant]]\nname = \"a\"\nreaders = []\n[[plant]]\nname = \"a\"\nreaders = []\n"
                ),
                "archive.toml:9:8: the plant a is given twice",
            ),
        ];
        for (text, expected) in cases {
            let error = read(&text).unwrap_err();
            assert!(error.contains(expected), "{error}\nexpected {expected}");
        }
    }

    #[test]
    fn a_wrong_file_says_where_and_what_is_expected() {
        let cases = [
            (format!("{NATS}{POSTGRES}[archive]\nreplicas = 2\n"), "expected replicas = 1, 3 or 5, found 2"),
            (format!("{NATS}{POSTGRES}[archive]\nreplicas = 300\n"), "expected replicas = 1, 3 or 5, found 300"),
            (
                format!("{NATS}{POSTGRES}[archive]\nsamples-days = -1\n"),
                "expected samples-days from 1 to 36525, found -1",
            ),
            (
                format!("{NATS}{POSTGRES}[archive]\nstream-octets = -1\n"),
                "expected stream-octets of at least 10000000, found -1",
            ),
            (
                format!("{NATS}{POSTGRES}[[plant]]\nname = \"hall one\"\nreaders = []\n"),
                "archive.toml:6:8: expected 1 to 60 letters, digits, - and _, found \"hall one\"",
            ),
            (format!("{NATS}{POSTGRES}[archive]\nsamples-days = 0\n"), "expected samples-days from 1"),
            (
                format!("{NATS}{POSTGRES}[archive]\nstream-octets = 7\n"),
                "expected stream-octets of at least 10000000, found 7",
            ),
            (format!("{NATS}{POSTGRES}[archive]\nsample-days = 7\n"), "archive.toml:6:1: unknown field"),
            (
                format!("{NATS}[postgres]\nconnection = \"host=db.example sslmode=disable\"\n"),
                "the database is on another computer",
            ),
            (
                format!("{NATS}[postgres]\nconnection = \"hostaddr=192.0.2.1 sslmode=disable\"\n"),
                "the database is on another computer",
            ),
            (
                format!("{NATS}[postgres]\nconnection = \"host=localhost hostaddr=192.0.2.1 sslmode=disable\"\n"),
                "the database is on another computer",
            ),
            (
                format!("{NATS}[postgres]\nconnection = \"host=db.example\"\nca-file = \"absent\"\n"),
                "absent cannot be read",
            ),
            (format!("{NATS}[postgres]\nconnection = \"host=/x password=y\"\n"), "put it into a file"),
            (format!("{NATS}[postgres]\nconnection = \"hostess=/x\"\n"), "expected connection ="),
            (format!("{NATS}ca-file = \"absent.pem\"\n{POSTGRES}"), "archive.toml:3:11: "),
            (format!("[nats]\nservers = [\"nats://far\"]\n{POSTGRES}"), "archive.toml:2:12: expected tls://"),
        ];
        for (text, expected) in cases {
            let error = read(&text).unwrap_err();
            assert!(error.contains(expected), "{error}\nexpected {expected}");
        }
    }
}
