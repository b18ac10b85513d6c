//! `[archive]`: a NATS server to which the station sends what it records, for an archive of many stations.
//!
//! ```toml
//! [archive]
//! plant = "hall"                        # who may read the station in the archive
//! station = "hall-1"                    # one name for each station that sends there
//! samples = "all"                       # or "deadband", or "off"
//! deadband-percent = 5.0                # with samples = "deadband"
//! limit-octets-per-second = 100000      # unless given, without limit
//!
//! [archive.nats]
//! servers = ["tls://nats-1.example", "tls://nats-2.example"]   # or nats:// on this computer; port 4222 unless given
//! credentials = "nats.credentials"      # TOML with user and password, readable by its owner alone
//! ca-file = "our-ca.pem"                # trusted in addition to the certificates of the system
//! ```

use super::super::error::{ArchiveProblem, ConfigProblem, Located};
use super::mqtt::{Credentials, credentials_file};
use crate::host_name::is_loopback;
use hyper::Uri;
use profivac_host::text_file::Parsed;
use profivac_recorder::Forward;
use serde::Deserialize;
use std::path::{Path, PathBuf};
use toml::Spanned;

/// The deadband of `samples = "deadband"` in percent, unless the file has another one: that of large archives.
const DEADBAND_PERCENT: f64 = 5.0;

/// The most characters of a name in a subject.
const LONGEST_NAME: usize = 60;

/// The settings of the station's part of an archive.
#[derive(Clone, Debug, PartialEq)]
pub struct Settings {
    /// The plant.
    pub plant: String,
    /// The name of the station in the archive.
    pub station: String,
    /// Which samples are sent.
    pub samples: Forward,
    /// The most octets per second, on average.
    pub limit: Option<u32>,
    /// The servers.
    pub nats: Nats,
}

// The deadband is a number of the file, never NaN.
impl Eq for Settings {}

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

/// `[archive]` as TOML.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields, rename_all = "kebab-case")]
pub struct ArchiveToml {
    plant: Spanned<String>,
    station: Spanned<String>,
    #[serde(default)]
    samples: SamplesToml,
    deadband_percent: Option<Spanned<f64>>,
    limit_octets_per_second: Option<Spanned<u32>>,
    nats: NatsToml,
}

/// `samples`.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "kebab-case")]
enum SamplesToml {
    All,
    #[default]
    Deadband,
    Off,
}

/// `[archive.nats]`, and `[nats]` in the file of the archive.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields, rename_all = "kebab-case")]
pub struct NatsToml {
    servers: Vec<Spanned<Parsed<Uri>>>,
    #[serde(default)]
    unencrypted: bool,
    credentials: Option<Spanned<PathBuf>>,
    ca_file: Option<PathBuf>,
}

impl ArchiveToml {
    /// The settings, with the defaults of the keys that are absent. Files are beside the file at `path`.
    pub fn into_settings(self, path: &Path) -> Result<Settings, Located> {
        let samples = match (self.samples, &self.deadband_percent) {
            (SamplesToml::Deadband, percent) => {
                let value = percent.as_ref().map_or(DEADBAND_PERCENT, |percent| *percent.get_ref());
                if let Some(percent) = percent.as_ref().filter(|_| !(0.1..=100.0).contains(&value)) {
                    return Err(located(percent, ArchiveProblem::Deadband(value)));
                }
                Forward::Deadband((1.0 + value / 100.0).log10())
            }
            (_, Some(percent)) => return Err(located(percent, ArchiveProblem::DeadbandUnused)),
            (SamplesToml::All, None) => Forward::All,
            (SamplesToml::Off, None) => Forward::Off,
        };
        if let Some(limit) = self.limit_octets_per_second.as_ref().filter(|limit| *limit.get_ref() < 1_000) {
            return Err(located(limit, ArchiveProblem::Limit(*limit.get_ref())));
        }
        Ok(Settings {
            plant: name(&self.plant)?,
            station: name(&self.station)?,
            samples,
            limit: self.limit_octets_per_second.map(Spanned::into_inner),
            nats: self.nats.into_settings(path, self.plant.span())?,
        })
    }
}

impl NatsToml {
    /// The settings. `span` is shown where the list of servers is empty.
    ///
    /// # Errors
    /// Where the file is wrong, and why.
    pub fn into_settings(self, path: &Path, span: std::ops::Range<usize>) -> Result<Nats, Located> {
        let folder = path.parent().unwrap_or(Path::new(""));
        let Some(first) = self.servers.first() else {
            return Err(Located::new(span, ConfigProblem::Archive(ArchiveProblem::NoServer)));
        };
        let tls = first.get_ref().0.scheme_str() == Some("tls");
        let servers = self.servers.iter().map(|url| server(url, tls, self.unencrypted)).collect::<Result<_, _>>()?;
        let credentials = self.credentials.as_ref().map(|file| credentials_file(file, folder)).transpose()?;
        Ok(Nats { servers, tls, credentials, ca_file: self.ca_file.map(|file| folder.join(file)) })
    }
}

/// The URL of a server.
fn server(url: &Spanned<Parsed<Uri>>, tls: bool, unencrypted: bool) -> Result<String, Located> {
    let uri = &url.get_ref().0;
    let Some(authority) = uri.authority().filter(|authority| !authority.as_str().contains('@')) else {
        return Err(located(url, ArchiveProblem::Server));
    };
    match uri.scheme_str() {
        Some("tls") if tls => {}
        Some("nats") if tls => return Err(located(url, ArchiveProblem::MixedServers)),
        Some("nats") if unencrypted || is_loopback(authority.host()) => {}
        Some("nats") => return Err(located(url, ArchiveProblem::Unencrypted)),
        _ => return Err(located(url, ArchiveProblem::Server)),
    }
    let scheme = if tls { "tls" } else { "nats" };
    Ok(format!("{scheme}://{}:{}", authority.host(), authority.port_u16().unwrap_or(4222)))
}

/// A name that is a part of a subject.
fn name(name: &Spanned<String>) -> Result<String, Located> {
    let found = name.get_ref();
    let is_known = |character: char| character.is_ascii_alphanumeric() || matches!(character, '-' | '_');
    match !found.is_empty() && found.len() <= LONGEST_NAME && found.chars().all(is_known) {
        true => Ok(found.clone()),
        false => Err(located(name, ArchiveProblem::Name(found.clone()))),
    }
}

fn located<T>(value: &Spanned<T>, problem: ArchiveProblem) -> Located {
    Located::new(value.span(), ConfigProblem::Archive(problem))
}

#[cfg(test)]
mod tests {
    use super::super::GatewaySettings;
    use crate::config::Config;
    use profivac_recorder::Forward;

    fn read(table: &str) -> Result<Config, String> {
        let text = format!(
            "[station]\nname = \"p\"\nusers = \"users.toml\"\n{table}\n[[segment]]\nname = \"s\"\nport = \"sim:s.toml\"\n"
        );
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("plant.toml");
        std::fs::write(&path, text).unwrap();
        Config::read(&path).map_err(|error| error.to_string())
    }

    const NATS: &str = "[archive.nats]\nservers = [\"nats://127.0.0.1\"]";

    #[test]
    fn a_station_sends_five_percent_unless_the_file_says_otherwise() {
        let config = read(&format!("[archive]\nplant = \"hall\"\nstation = \"hall-1\"\n{NATS}")).unwrap();
        let [GatewaySettings::Archive(settings)] = &config.gateways[..] else { panic!("one gateway") };
        assert_eq!(settings.samples, Forward::Deadband(1.05_f64.log10()));
        assert_eq!(settings.nats.servers, ["nats://127.0.0.1:4222"]);
        assert_eq!(config.outbox(), Some(settings.samples));
        assert_eq!(read("").unwrap().outbox(), None);
    }

    #[test]
    fn a_server_on_another_computer_without_encryption_gives_a_notice() {
        let notices = |servers: &str| {
            let nats = format!("[archive.nats]\nservers = [{servers}]\nunencrypted = true");
            let config = read(&format!("[archive]\nplant = \"hall\"\nstation = \"hall-1\"\n{nats}")).unwrap();
            config.notices().iter().map(ToString::to_string).filter(|notice| !notice.contains("segment")).collect()
        };
        let near: Vec<String> = notices("\"nats://127.0.0.1\", \"nats://[::1]:4223\"");
        assert_eq!(near, [] as [String; 0]);
        let far: Vec<String> = notices("\"nats://127.0.0.1\", \"nats://far.example:4223\"");
        let [notice] = &far[..] else { panic!("{far:?}") };
        assert!(
            notice.starts_with("[archive] connects to far.example without encryption (unencrypted = true): "),
            "{notice}"
        );
    }

    #[test]
    fn a_wrong_table_says_what_is_expected() {
        let cases = [
            ("plant = \"a.b\"\nstation = \"x\"", NATS, "expected 1 to 60 letters, digits, - and _, found \"a.b\""),
            (
                "plant = \"a\"\nstation = \"x\"\nsamples = \"all\"\ndeadband-percent = 5.0",
                NATS,
                "deadband-percent belongs to",
            ),
            ("plant = \"a\"\nstation = \"x\"\ndeadband-percent = 0.0", NATS, "expected 0.1 to 100 percent, found 0"),
            ("plant = \"a\"\nstation = \"x\"\nlimit-octets-per-second = 5", NATS, "expected at least 1000"),
            ("plant = \"a\"\nstation = \"x\"", "[archive.nats]\nservers = []", "expected at least one server"),
            (
                "plant = \"a\"\nstation = \"x\"",
                "[archive.nats]\nservers = [\"nats://far.example\"]",
                "expected tls:// for a server on another computer",
            ),
            (
                "plant = \"a\"\nstation = \"x\"",
                "[archive.nats]\nservers = [\"tls://far.example\", \"nats://near\"]",
                "the first server has tls://",
            ),
            (
                "plant = \"a\"\nstation = \"x\"",
                "[archive.nats]\nservers = [\"mqtt://x\"]",
                "expected a URL like tls://",
            ),
        ];
        for (archive, nats, expected) in cases {
            let error = read(&format!("[archive]\n{archive}\n{nats}")).unwrap_err();
            assert!(error.contains(expected), "{error}\nexpected {expected}");
        }
    }
}
