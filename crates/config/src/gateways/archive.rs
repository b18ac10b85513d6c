//! `[archive]`: where the station sends what it records, for an archive of many stations: to servers of NATS, or to the archive itself.
//!
//! ```toml
//! [archive]
//! plant = "hall"                        # who may read the station in the archive
//! station = "hall-1"                    # one name for each station that sends there
//! samples = "all"                       # or "deadband", or "off"
//! deadband-percent = 5.0                # with samples = "deadband"
//! limit-octets-per-second = 100000      # unless given, without limit
//! requests = "read"                     # what users of the archive may ask for: "off" (the default), "read", "acknowledge"
//! alarm-hours = 4.0                     # without an answer of the archive, until the alarm "station: not archived"; 0: no alarm
//!
//! [archive.nats]
//! servers = ["tls://nats-1.example", "tls://nats-2.example"]   # or nats:// on this computer; port 4222 unless given
//! credentials = "nats.credentials"      # TOML with user and password, readable by its owner alone
//! ca-file = "our-ca.pem"                # trusted in addition to the certificates of the system
//!
//! [archive.https]                       # instead of [archive.nats]
//! url = "https://archive.example:8443"  # or http:// on this computer
//! token-file = "archive.token"          # the token of this station, readable by its owner alone
//! ca-file = "our-ca.pem"                # trusted in addition to the certificates of the system
//! request-urls = ["https://archive-2.example:8443"]   # the archives whose users ask the station; unless given, that of url
//! ```

use super::super::error::{ArchiveProblem, ConfigProblem, Located};
use hyper::Uri;
use profivac_host::text_file::Parsed;
use profivac_recorder::Forward;
use profivac_station::alarm::{Condition, Priority, Rule};
use profivac_station::config::gateways::archive::{Https, Requests, Settings, Transport};
use profivac_web_server::host_name::is_loopback;
use profivac_web_server::tables::archive::{NatsToml, SHORTEST_TOKEN, is_name};
use profivac_web_server::tables::{ca_file, secret_of_file};
use serde::Deserialize;
use std::path::{Path, PathBuf};
use std::time::Duration;
use toml::Spanned;

/// The deadband of `samples = "deadband"` in percent, unless the file has another one: that of large archives.
const DEADBAND_PERCENT: f64 = 5.0;

/// The hours without an answer of the archive until there is an alarm, unless the file says otherwise. chosen: a server that starts again, or
/// an update at night, is none.
const ALARM_HOURS: f64 = 4.0;

/// The alarm about an archive.
pub fn alarm(settings: &Settings) -> Option<Rule> {
    let condition = Condition::NotArchived { limit: settings.alarm_hours? };
    let (name, priority) = ("station: not archived".to_owned(), Priority::Medium);
    Some(Rule { name, condition, priority, delay: Duration::ZERO, off_delay: Duration::ZERO, message: None })
}

/// The most archives that a station asks for requests.
const MAX_REQUEST_URLS: usize = 8;

/// `[archive]` as TOML.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields, rename_all = "kebab-case")]
pub struct ArchiveToml {
    /// The plant of the station in the archive.
    plant: Spanned<String>,
    /// The name of the station in the archive, which no other one has.
    station: Spanned<String>,
    /// `deadband` (default), `all`, or `off`: then spans only.
    #[serde(default)]
    samples: SamplesToml,
    /// A sample is sent when the pressure has changed by this percentage. Default: 5.
    deadband_percent: Option<Spanned<f64>>,
    /// The most octets in a second, on average. Default: no limit.
    limit_octets_per_second: Option<Spanned<u32>>,
    /// What users of the archive may ask the station for: `off` (default), `read` for trends, `acknowledge` for alarms too.
    requests: Option<Spanned<Requests>>,
    /// Hours without an answer of the archive until there is an alarm, up to 720; 0 for no alarm. Default: 4.
    alarm_hours: Option<Spanned<f64>>,
    /// Servers of NATS; this or `https`.
    nats: Option<NatsToml>,
    /// The archive itself, without NATS.
    https: Option<HttpsToml>,
}

/// `[archive.https]`.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields, rename_all = "kebab-case")]
struct HttpsToml {
    /// The URL of the archive, without a path.
    url: Spanned<Parsed<Uri>>,
    /// `true` permits `http://` to another computer. Default: `false`.
    #[serde(default)]
    unencrypted: bool,
    /// The file with the token of the station, of at least 16 characters, which only its owner may read.
    token_file: Spanned<PathBuf>,
    /// Certificates in PEM that are trusted in addition to those of the system.
    ca_file: Option<Spanned<PathBuf>>,
    /// URLs of the archives whose users ask the station, up to 8. Default: that of `url`.
    request_urls: Option<Spanned<Vec<Spanned<Parsed<Uri>>>>>,
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
        let transport = match (self.nats, self.https) {
            (Some(nats), None) => Transport::Nats(nats.into_settings(path, self.plant.span())?),
            (None, Some(https)) => Transport::Https(https.into_settings(path)?),
            (None, None) => return Err(located(&self.plant, ArchiveProblem::NoTransport)),
            (Some(_), Some(https)) => return Err(located(&https.url, ArchiveProblem::TwoTransports)),
        };
        let requests = self.requests.as_ref().map_or(Requests::Off, |requests| *requests.get_ref());
        let alarm_hours = self.alarm_hours.as_ref().map_or(ALARM_HOURS, |hours| *hours.get_ref());
        if let Some(given) = self.alarm_hours.as_ref().filter(|_| !(0.0..=720.0).contains(&alarm_hours)) {
            return Err(located(given, ArchiveProblem::AlarmHours(alarm_hours)));
        }
        Ok(Settings {
            plant: name(&self.plant)?,
            station: name(&self.station)?,
            samples,
            limit: self.limit_octets_per_second.map(Spanned::into_inner),
            transport,
            requests,
            alarm_hours: (alarm_hours > 0.0).then_some(alarm_hours),
        })
    }
}

impl HttpsToml {
    /// The settings. Files are beside the file at `path`.
    fn into_settings(self, path: &Path) -> Result<Https, Located> {
        let folder = path.parent().unwrap_or(Path::new(""));
        let url = url_of_archive(&self.url, self.unencrypted)?;
        let request_urls = match &self.request_urls {
            None => vec![url.clone()],
            Some(urls) if urls.get_ref().is_empty() || urls.get_ref().len() > MAX_REQUEST_URLS => {
                return Err(located(urls, ArchiveProblem::RequestUrls(urls.get_ref().len())));
            }
            Some(urls) => {
                let urls = urls.get_ref().iter().map(|url| url_of_archive(url, self.unencrypted));
                urls.collect::<Result<_, _>>()?
            }
        };
        let token = secret_of_file(&self.token_file, folder)?;
        let found = token.reveal().len();
        if found < SHORTEST_TOKEN {
            return Err(located(&self.token_file, ArchiveProblem::ShortToken { least: SHORTEST_TOKEN, found }));
        }
        let ca_file = self.ca_file.map(|file| ca_file(&file, folder)).transpose()?;
        Ok(Https { url, request_urls, token, ca_file })
    }
}

/// The URL of an archive: without a path, and encrypted unless the file permits otherwise.
fn url_of_archive(url: &Spanned<Parsed<Uri>>, unencrypted: bool) -> Result<Uri, Located> {
    let uri = &url.get_ref().0;
    let is_plain = uri.path_and_query().is_none_or(|path| path.as_str() == "/");
    let Some(authority) = uri.authority().filter(|it| is_plain && !it.as_str().contains('@')) else {
        return Err(located(url, ArchiveProblem::Url));
    };
    match uri.scheme_str() {
        Some("https") => {}
        Some("http") if unencrypted || is_loopback(authority.host()) => {}
        Some("http") => return Err(located(url, ArchiveProblem::UnencryptedUrl)),
        _ => return Err(located(url, ArchiveProblem::Url)),
    }
    Ok(uri.clone())
}

/// A name that is a part of a subject.
fn name(name: &Spanned<String>) -> Result<String, Located> {
    let found = name.get_ref();
    match is_name(found) {
        true => Ok(found.clone()),
        false => Err(located(name, ArchiveProblem::Name(found.clone()))),
    }
}

fn located<T>(value: &Spanned<T>, problem: ArchiveProblem) -> Located {
    Located::new(value.span(), ConfigProblem::Archive(problem))
}

#[cfg(test)]
mod tests {
    use profivac_recorder::Forward;
    use profivac_station::config::Config;
    use profivac_station::config::gateways::GatewaySettings;
    use profivac_station::config::gateways::archive::{Requests, Transport};
    use std::os::unix::fs::PermissionsExt;

    fn read(table: &str) -> Result<Config, String> {
        let text = format!(
            "[station]\nname = \"p\"\nusers = \"users.toml\"\n{table}\n[[segment]]\nname = \"s\"\nport = \"sim:s.toml\"\n"
        );
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("plant.toml");
        std::fs::write(&path, text).unwrap();
        for (name, text) in [("archive.token", "secret-of-hall-1\n"), ("short.token", "secret\n")] {
            let token = folder.path().join(name);
            std::fs::write(&token, text).unwrap();
            std::fs::set_permissions(&token, std::fs::Permissions::from_mode(0o600)).unwrap();
        }
        crate::read(&path).map_err(|error| error.to_string())
    }

    const NATS: &str = "[archive.nats]\nservers = [\"nats://127.0.0.1\"]";

    #[test]
    fn a_station_sends_five_percent_unless_the_file_says_otherwise() {
        let config = read(&format!("[archive]\nplant = \"hall\"\nstation = \"hall-1\"\n{NATS}")).unwrap();
        let [GatewaySettings::Archive(settings)] = &config.gateways[..] else { panic!("one gateway") };
        assert_eq!(settings.samples, Forward::Deadband(1.05_f64.log10()));
        let Transport::Nats(nats) = &settings.transport else { panic!("NATS") };
        assert_eq!(nats.servers, ["nats://127.0.0.1:4222"]);
        assert_eq!(config.outbox(), Some(settings.samples));
        assert_eq!(read("").unwrap().outbox(), None);
    }

    #[test]
    fn an_archive_that_is_silent_for_four_hours_is_an_alarm_unless_the_file_says_otherwise() {
        let limit = |more: &str| {
            let config = read(&format!("[archive]\nplant = \"hall\"\nstation = \"hall-1\"\n{more}\n{NATS}")).unwrap();
            let rule = config.alarms.iter().find(|rule| rule.name == "station: not archived");
            rule.and_then(|rule| rule.condition.limit())
        };
        assert_eq!([limit(""), limit("alarm-hours = 0.5"), limit("alarm-hours = 0.0")], [Some(4.0), Some(0.5), None]);
        assert!(read("").unwrap().alarms.iter().all(|rule| rule.name != "station: not archived"));
    }

    const HTTPS: &str = "[archive.https]\ntoken-file = \"archive.token\"\nurl = ";

    #[test]
    fn a_station_sends_to_an_archive_without_nats_with_its_token() {
        let read =
            |more: &str| read(&format!("[archive]\nplant = \"hall\"\nstation = \"hall-1\"\n{HTTPS}{more}")).unwrap();
        let config = read("\"https://archive.example:8443\"");
        let [GatewaySettings::Archive(settings)] = &config.gateways[..] else { panic!("one gateway") };
        let Transport::Https(https) = &settings.transport else { panic!("HTTPS") };
        assert_eq!((https.url.port_u16(), https.token.reveal()), (Some(8443), "secret-of-hall-1"));
        assert!(!format!("{settings:?}").contains("secret-of-hall-1"));
        assert!(config.gateways[0].is_private());
        assert_eq!(https.request_urls, std::slice::from_ref(&https.url));
        let far = read("\"http://far.example\"\nunencrypted = true");
        assert_eq!(far.gateways[0].unencrypted_broker(), Some("far.example"));
    }

    #[test]
    fn a_station_without_nats_takes_requests_from_each_archive_that_its_file_names() {
        let table = |requests: &str, urls: &str| {
            let archive = format!("[archive]\nplant = \"hall\"\nstation = \"hall-1\"\nrequests = \"{requests}\"\n");
            read(&format!("{archive}{HTTPS}\"https://a.example\"\nrequest-urls = [{urls}]"))
        };
        let config = table("acknowledge", "\"https://a.example\", \"https://b.example:8443\"").unwrap();
        let [GatewaySettings::Archive(settings)] = &config.gateways[..] else { panic!("one gateway") };
        let Transport::Https(https) = &settings.transport else { panic!("HTTPS") };
        let hosts: Vec<_> = https.request_urls.iter().filter_map(|url| url.host()).collect();
        assert_eq!((settings.requests, &hosts[..]), (Requests::Acknowledge, &["a.example", "b.example"][..]));
        for (urls, expected) in [
            ("", "expected 1 to 8 URLs in request-urls, found 0"),
            ("\"https://b.example/path\"", "expected a URL like https://"),
            ("\"http://b.example\"", "expected https:// for an archive on another computer"),
        ] {
            let error = table("read", urls).unwrap_err();
            assert!(error.contains(expected), "{error}\nexpected {expected}");
        }
    }

    #[test]
    fn a_server_on_another_computer_without_encryption_gives_a_notice() {
        let notices = |servers: &str| {
            let nats = format!("[archive.nats]\nservers = [{servers}]\nunencrypted = true");
            let config = read(&format!("[archive]\nplant = \"hall\"\nstation = \"hall-1\"\n{nats}")).unwrap();
            crate::notices(&config)
                .iter()
                .map(ToString::to_string)
                .filter(|notice| !notice.contains("segment"))
                .collect()
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
            ("plant = \"a\"\nstation = \"x\"\nalarm-hours = -1.0", NATS, "expected 0 to 720 hours, found -1"),
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
            ("plant = \"a\"\nstation = \"x\"", "", "expected [archive.nats] or [archive.https], found neither"),
            ("plant = \"a\"\nstation = \"x\"", &format!("{NATS}\n{HTTPS}\"https://archive.example\""), "found both"),
            ("plant = \"a\"\nstation = \"x\"", &format!("{HTTPS}\"http://far.example\""), "expected https://"),
            (
                "plant = \"a\"\nstation = \"x\"",
                &format!("{HTTPS}\"https://far.example/path\""),
                "expected a URL like https://",
            ),
            (
                "plant = \"a\"\nstation = \"x\"",
                "[archive.https]\nurl = \"https://far.example\"\ntoken-file = \"absent\"",
                "absent",
            ),
            (
                "plant = \"a\"\nstation = \"x\"",
                "[archive.https]\nurl = \"https://far.example\"\ntoken-file = \"short.token\"",
                "expected a token of at least 16 characters, found 6: `openssl rand -hex 32` makes one",
            ),
        ];
        for (archive, nats, expected) in cases {
            let error = read(&format!("[archive]\n{archive}\n{nats}")).unwrap_err();
            assert!(error.contains(expected), "{error}\nexpected {expected}");
        }
    }
}
