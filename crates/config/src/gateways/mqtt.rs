//! `[mqtt]`: a broker that gets the points of the station, as plain topics and as Sparkplug B.
//!
//! ```toml
//! [mqtt]
//! broker = "mqtts://broker.example"     # or mqtt://; port 8883 or 1883 unless given
//! credentials = "broker.credentials"    # TOML with user and password, readable by its owner alone
//! ca-file = "our-ca.pem"                # trusted in addition to the certificates of the system
//! certificate = "station.pem"           # a client certificate with its key
//! key = "station.key"
//! client-id = "profivac-hall"
//! prefix = "profivac/hall"              # default profivac/NAME OF THE STATION
//! plain = true
//! home-assistant = false
//! home-assistant-object-id = false      # true for Home Assistant before 2025.10
//!
//! [mqtt.sparkplug]
//! group = "TargetHall"
//! edge-node = "station-1"               # default: the name of the station
//! data = "names"                        # or "aliases": what identifies a metric in data
//! primary-host = "scada"
//! backlog = "7 days"
//! ```

use super::super::error::{BrokerUrlProblem, ConfigProblem, Located, MqttProblem};
use crate::time_span::TimeSpan;
use hyper::Uri;
use profivac_host::text_file::Parsed;
use profivac_station::config::gateways::mqtt::{Broker, DataStyle, Discovery, Plain, Settings, Sparkplug, Tls};
use profivac_web_server::host_name::is_loopback;
use profivac_web_server::tables::{ca_certificates, credentials_file, private_file};
use serde::Deserialize;
use std::path::{Path, PathBuf};
use std::time::Duration;
use tokio_rustls::rustls::pki_types::PrivateKeyDer;
use tokio_rustls::rustls::pki_types::pem::PemObject;
use toml::Spanned;

/// The registered port of MQTT.
const PORT: u16 = 1883;

/// The registered port of MQTT over TLS.
const TLS_PORT: u16 = 8883;

/// The longest part of a topic that the file gives, in octets. chosen: a topic has at most 65535.
const LONGEST_NAME: usize = 200;

/// The backlog that is sent after an outage, unless the file has another one.
const BACKLOG: Duration = Duration::from_secs(7 * 86_400);

/// The longest backlog: the longest retention of samples.
const LONGEST_BACKLOG: Duration = Duration::from_secs(36_525 * 86_400);

/// `[mqtt]` as TOML.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields, rename_all = "kebab-case")]
pub struct MqttToml {
    /// The broker: `mqtts://host` (port 8883) or `mqtt://host` (port 1883), or with another port.
    broker: Spanned<Parsed<Uri>>,
    /// Further brokers, for as long as those before cannot be reached; with the same login and certificates.
    #[serde(default)]
    standby: Vec<Spanned<Parsed<Uri>>>,
    /// `true` permits `mqtt://` to another computer. Default: `false`.
    unencrypted: Option<Spanned<bool>>,
    /// A TOML file with `user` and `password`, which only its owner may read.
    credentials: Option<Spanned<PathBuf>>,
    /// Certificates in PEM that are trusted in addition to those of the system.
    ca_file: Option<Spanned<PathBuf>>,
    /// A client certificate in PEM, with `key`.
    certificate: Option<Spanned<PathBuf>>,
    /// Its private key in PEM, which only its owner may read.
    key: Option<Spanned<PathBuf>>,
    /// The client identifier, which no other client of the broker has. Default: `profivac-NAME`.
    client_id: Option<Spanned<String>>,
    /// What plain topics begin with. Default: `profivac/NAME`.
    prefix: Option<Spanned<String>>,
    /// Plain topics. Default: `true`.
    plain: Option<Spanned<bool>>,
    /// Sensors are described for Home Assistant. Default: `false`.
    home_assistant: Option<Spanned<bool>>,
    /// The names of entities for Home Assistant before 2025.10, which does not know `default_entity_id`. Default: `false`.
    home_assistant_object_id: Option<Spanned<bool>>,
    /// Where Home Assistant expects them. Default: `homeassistant`.
    discovery_prefix: Option<Spanned<String>>,
    /// An edge node of Sparkplug B; without the table there is none.
    sparkplug: Option<SparkplugToml>,
}

/// `[mqtt.sparkplug]` as TOML.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields, rename_all = "kebab-case")]
struct SparkplugToml {
    /// The group of the edge node.
    group: Spanned<String>,
    /// Its name. Default: the name of the station.
    edge_node: Option<Spanned<String>>,
    /// What identifies a metric in data: `names` with data types, or the `aliases` of the births. Default: `names`.
    #[serde(default)]
    data: DataStyle,
    /// The host for which births wait. Default: none.
    primary_host: Option<Spanned<String>>,
    /// The longest outage whose samples are sent afterwards. Default: `7 days`.
    backlog: Option<Spanned<Parsed<TimeSpan>>>,
}

impl MqttToml {
    /// The settings, with the defaults of the keys that are absent. Files are beside the file at `path`.
    pub fn into_settings(self, path: &Path) -> Result<Settings, Located> {
        let folder = path.parent().unwrap_or(Path::new(""));
        let broker = self.broker(folder)?;
        let span = self.broker.span();
        let plain = self.plain()?;
        let sparkplug = self.sparkplug.map(SparkplugToml::into_settings).transpose()?;
        if plain.is_none() && sparkplug.is_none() {
            return Err(Located::new(span, ConfigProblem::Mqtt(MqttProblem::Nothing)));
        }
        Ok(Settings { broker, plain, sparkplug })
    }

    fn broker(&self, folder: &Path) -> Result<Broker, Located> {
        let (host, port) = self.address(&self.broker)?;
        let scheme = self.broker.get_ref().0.scheme_str();
        let standby = self.standby.iter().map(|url| match url.get_ref().0.scheme_str() == scheme {
            true => self.address(url),
            false => Err(located(url, MqttProblem::Url(BrokerUrlProblem::OtherScheme))),
        });
        let standby = standby.collect::<Result<_, _>>()?;
        let tls = match scheme {
            Some("mqtts") => {
                let is_permitted = |permitted: &&Spanned<bool>| *permitted.get_ref();
                if let Some(unencrypted) = self.unencrypted.as_ref().filter(is_permitted) {
                    return Err(located(unencrypted, MqttProblem::OnlyWithoutTls));
                }
                Some(self.tls(folder)?)
            }
            _ => self.without_tls().map(|()| None)?,
        };
        let client_id = self.client_id.as_ref().map(client_id).transpose()?;
        let credentials = self.credentials.as_ref().map(|file| credentials_file(file, folder)).transpose()?;
        Ok(Broker { host, port, tls, credentials, client_id, standby })
    }

    /// Host and port of a URL: `mqtts`, or `mqtt` where that is permitted.
    fn address(&self, url: &Spanned<Parsed<Uri>>) -> Result<(String, u16), Located> {
        let wrong = |problem| Err(located(url, problem));
        let uri = &url.get_ref().0;
        let Some(authority) = uri.authority() else { return wrong(MqttProblem::Url(BrokerUrlProblem::NoHost)) };
        if authority.as_str().contains('@') {
            return wrong(MqttProblem::Url(BrokerUrlProblem::User));
        }
        if !matches!(uri.path(), "" | "/") || uri.query().is_some() {
            return wrong(MqttProblem::Url(BrokerUrlProblem::Path));
        }
        if authority.host().is_empty() {
            return wrong(MqttProblem::Url(BrokerUrlProblem::NoHost));
        }
        let is_permitted = self.unencrypted.as_ref().is_some_and(|permitted| *permitted.get_ref());
        let port = match uri.scheme_str() {
            Some("mqtts") => TLS_PORT,
            Some("mqtt") if is_loopback(authority.host()) || is_permitted => PORT,
            Some("mqtt") => return wrong(MqttProblem::Unencrypted),
            _ => return wrong(MqttProblem::Url(BrokerUrlProblem::Scheme)),
        };
        let host = authority.host().trim_start_matches('[').trim_end_matches(']').to_owned();
        Ok((host, authority.port_u16().unwrap_or(port)))
    }

    fn without_tls(&self) -> Result<(), Located> {
        let keys = [("ca-file", &self.ca_file), ("certificate", &self.certificate), ("key", &self.key)];
        let found = keys.into_iter().find_map(|(name, value)| value.as_ref().map(|value| (name, value)));
        found.map_or(Ok(()), |(name, value)| Err(located(value, MqttProblem::OnlyWithTls(name))))
    }

    fn tls(&self, folder: &Path) -> Result<Tls, Located> {
        let certificates = |file: &Spanned<PathBuf>| {
            let path = folder.join(file.get_ref());
            let wrong = |error| located(file, MqttProblem::Certificates(error));
            ca_certificates(&path).map_err(wrong).map(|_| path)
        };
        let client = match (&self.certificate, &self.key) {
            (None, None) => None,
            (Some(certificate), Some(key)) => Some((certificates(certificate)?, private_key(key, folder)?)),
            (Some(certificate), None) => return Err(located(certificate, MqttProblem::HalfCertificate("certificate"))),
            (None, Some(key)) => return Err(located(key, MqttProblem::HalfCertificate("key"))),
        };
        Ok(Tls { ca_file: self.ca_file.as_ref().map(certificates).transpose()?, client })
    }

    fn plain(&self) -> Result<Option<Plain>, Located> {
        let is_on = self.plain.as_ref().is_none_or(|plain| *plain.get_ref());
        let finds_sensors = self.home_assistant.as_ref().is_some_and(|it| *it.get_ref());
        if !is_on {
            return self.nothing_of_plain().map(|()| None);
        }
        let prefix = self.prefix.as_ref().map(prefix).transpose()?;
        let discovery = self.discovery_prefix.as_ref().map(self::prefix).transpose()?;
        let has_object_id = self.home_assistant_object_id.as_ref().is_some_and(|it| *it.get_ref());
        let discovery = finds_sensors
            .then(|| Discovery { prefix: discovery.unwrap_or_else(|| "homeassistant".to_owned()), has_object_id });
        Ok(Some(Plain { prefix, discovery }))
    }

    fn nothing_of_plain(&self) -> Result<(), Located> {
        let keys = [("prefix", &self.prefix), ("discovery-prefix", &self.discovery_prefix)];
        for (name, value) in keys {
            if let Some(value) = value {
                return Err(located(value, MqttProblem::OnlyWithPlain(name)));
            }
        }
        let keys =
            [("home-assistant", &self.home_assistant), ("home-assistant-object-id", &self.home_assistant_object_id)];
        let is_on = |(name, value): (_, &Option<Spanned<bool>>)| {
            let value = value.as_ref().filter(|value| *value.get_ref())?;
            Some(located(value, MqttProblem::OnlyWithPlain(name)))
        };
        keys.into_iter().find_map(is_on).map_or(Ok(()), Err)
    }
}

impl SparkplugToml {
    fn into_settings(self) -> Result<Sparkplug, Located> {
        let backlog = match &self.backlog {
            None => BACKLOG,
            Some(backlog) => {
                let found = backlog.get_ref().0;
                if Duration::from(found) > LONGEST_BACKLOG {
                    return Err(located(backlog, MqttProblem::Backlog(found)));
                }
                found.into()
            }
        };
        Ok(Sparkplug {
            group: element(&self.group)?,
            edge_node: self.edge_node.as_ref().map(element).transpose()?,
            data: self.data,
            primary_host: self.primary_host.as_ref().map(element).transpose()?,
            backlog,
        })
    }
}

fn located<T>(value: &Spanned<T>, problem: MqttProblem) -> Located {
    Located::new(value.span(), ConfigProblem::Mqtt(problem))
}

/// An element of a topic of Sparkplug (tck-id-topic-structure-namespace-valid-group-id and its neighbours).
fn element(value: &Spanned<String>) -> Result<String, Located> {
    const EXPECTED: &str = "1 to 200 octets without + / # and control characters";
    checked(value, EXPECTED, |text| !text.contains(['+', '/', '#']))
}

/// What topics begin with: levels without wildcards, none of them empty.
fn prefix(value: &Spanned<String>) -> Result<String, Located> {
    const EXPECTED: &str =
        "levels like profivac/hall, 1 to 200 octets, without + # and control characters, not beginning with $";
    let is_usable = |text: &str| {
        !text.contains(['+', '#']) && !text.starts_with('$') && text.split('/').all(|level| !level.is_empty())
    };
    checked(value, EXPECTED, is_usable)
}

fn client_id(value: &Spanned<String>) -> Result<String, Located> {
    checked(value, "a client identifier of 1 to 200 octets without control characters", |_| true)
}

fn checked(value: &Spanned<String>, expected: &'static str, is_usable: fn(&str) -> bool) -> Result<String, Located> {
    let text = value.get_ref();
    let has_length = (1..=LONGEST_NAME).contains(&text.len());
    if has_length && !text.chars().any(char::is_control) && is_usable(text) {
        return Ok(text.clone());
    }
    Err(located(value, MqttProblem::Topic { expected, found: text.clone() }))
}

fn private_key(file: &Spanned<PathBuf>, folder: &Path) -> Result<PathBuf, Located> {
    let path = private_file(file, folder).map_err(|error| located(file, MqttProblem::Open(error)))?;
    match PrivateKeyDer::from_pem_file(&path) {
        Ok(_) => Ok(path),
        Err(error) => Err(located(file, MqttProblem::Key { file: path, error })),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use profivac_station::config::gateways::GatewaySettings;
    use std::os::unix::fs::PermissionsExt;

    const SEGMENT: &str = "[[segment]]\nname = 'hall'\nport = 'sim:hall.toml'\n";

    fn parse_in(folder: &Path, table: &str) -> Result<Settings, String> {
        let text = format!("{SEGMENT}[mqtt]\n{table}");
        let config = crate::parse(&text, &folder.join("plant.toml")).map_err(|error| error.to_string())?;
        let [GatewaySettings::Mqtt(settings)] = &config.gateways[..] else { panic!("one gateway") };
        Ok(*settings.clone())
    }

    fn parse(table: &str) -> Result<Settings, String> {
        parse_in(Path::new(""), table)
    }

    #[test]
    fn a_broker_on_this_computer_needs_its_url_and_nothing_else() {
        let settings = parse("broker = 'mqtt://127.0.0.1'").unwrap();
        let Settings { broker, plain, sparkplug } = settings;
        assert_eq!((broker.host.as_str(), broker.port, broker.tls), ("127.0.0.1", 1883, None));
        assert_eq!(plain, Some(Plain { prefix: None, discovery: None }));
        assert_eq!(sparkplug, None);
    }

    #[test]
    fn all_keys_are_read() {
        let settings = parse(
            "broker = 'mqtts://[::1]:8884'\nclient-id = 'hall'\nprefix = 'a/b'\nhome-assistant = true\n\
             home-assistant-object-id = true\n[mqtt.sparkplug]\ngroup = 'G'\ndata = 'aliases'\nedge-node = 'E'\nprimary-host = 'H'\nbacklog = '2 days'",
        );
        let Settings { broker, plain, sparkplug } = settings.unwrap();
        assert_eq!((broker.host.as_str(), broker.port, broker.tls), ("::1", 8884, Some(Tls::default())));
        assert_eq!(broker.client_id.as_deref(), Some("hall"));
        let discovery = Some(Discovery { prefix: "homeassistant".to_owned(), has_object_id: true });
        assert_eq!(plain, Some(Plain { prefix: Some("a/b".to_owned()), discovery }));
        let sparkplug = sparkplug.unwrap();
        assert_eq!((sparkplug.group.as_str(), sparkplug.backlog), ("G", Duration::from_secs(172_800)));
        assert_eq!(sparkplug.data, DataStyle::Aliases);
        assert_eq!((sparkplug.edge_node.as_deref(), sparkplug.primary_host.as_deref()), (Some("E"), Some("H")));
    }

    #[test]
    fn hosts_get_names_and_home_assistant_gets_entity_ids_unless_the_file_says_otherwise() {
        let settings = parse("broker = 'mqtt://[::1]'\nhome-assistant = true\n[mqtt.sparkplug]\ngroup = 'G'").unwrap();
        let discovery = Discovery { prefix: "homeassistant".to_owned(), has_object_id: false };
        assert_eq!(settings.plain.unwrap().discovery, Some(discovery));
        assert_eq!(settings.sparkplug.unwrap().data, DataStyle::Names);
    }

    #[test]
    fn a_wrong_value_is_an_error_with_its_position() {
        for (table, expected) in [
            (
                "broker = 'http://localhost'",
                "plant.toml:5:10: expected a URL like mqtts://broker.example:8883, found another scheme",
            ),
            ("broker = 'mqtt://u:p@localhost'", "found a URL with a user; use credentials instead"),
            (
                "broker = 'mqtt://localhost'\nstandby = ['mqtts://localhost']",
                "6:12: expected a URL like mqtts://broker.example:8883, found another scheme than that of broker",
            ),
            ("broker = 'mqtt://localhost'\nstandby = ['mqtt://b.example']", "6:12: expected mqtts://"),
            ("broker = 'mqtt://localhost/x'", "found a URL with a path"),
            ("broker = 'mqtt://broker.example'", "5:10: expected mqtts:// for a broker on another computer"),
            ("broker = 'mqtt://localhost'\nca-file = 'ca.pem'", "6:11: ca-file belongs to mqtts://"),
            ("broker = 'mqtts://localhost'\nunencrypted = true", "6:15: unencrypted = true belongs to mqtt://"),
            (
                "broker = 'mqtts://localhost'\nkey = 'a.key'",
                "6:7: expected certificate and key together, found key alone",
            ),
            ("broker = 'mqtt://localhost'\nplain = false", "found neither: the gateway would publish nothing"),
            ("broker = 'mqtt://localhost'\nprefix = 'a/#'", "6:10: expected levels like profivac/hall"),
            ("broker = 'mqtt://localhost'\nprefix = '/a'", "6:10: expected levels like profivac/hall"),
            ("broker = 'mqtt://localhost'\nclient-id = ''", "6:13: expected a client identifier"),
            ("broker = 'mqtt://localhost'\nprefx = 'a'", "6:1: unknown field `prefx`"),
            (
                "broker = 'mqtt://localhost'\nplain = false\nprefix = 'a'\n[mqtt.sparkplug]\ngroup = 'G'",
                "7:10: prefix belongs to the plain topics",
            ),
            (
                "broker = 'mqtt://localhost'\nplain = false\nhome-assistant-object-id = true\n[mqtt.sparkplug]\ngroup = 'G'",
                "7:28: home-assistant-object-id belongs to the plain topics",
            ),
            (
                "broker = 'mqtt://localhost'\n[mqtt.sparkplug]\ngroup = 'a'\ndata = 'both'",
                "expected `names` or `aliases`",
            ),
            (
                "broker = 'mqtt://localhost'\n[mqtt.sparkplug]\ngroup = 'a/b'",
                "7:9: expected 1 to 200 octets without + / #",
            ),
            (
                "broker = 'mqtt://localhost'\n[mqtt.sparkplug]\ngroup = 'a'\nbacklog = '36526 days'",
                "8:11: expected a backlog",
            ),
            ("broker = 'mqtt://localhost'\ncredentials = 'no such file'", "no such file cannot be read"),
        ] {
            let error = parse(table).unwrap_err();
            assert!(error.contains(expected), "{table}: {error}");
        }
        let settings = parse("broker = 'mqtt://broker.example'\nunencrypted = true").unwrap();
        assert_eq!(settings.broker.exposed(), Some("broker.example"), "the station says so when it starts");
        assert_eq!(parse("broker = 'mqtt://[::1]'").unwrap().broker.exposed(), None);
        let standby = parse(
            "broker = 'mqtt://127.0.0.1'\nstandby = ['mqtt://b.example:1885', 'mqtt://c.example']\nunencrypted = true",
        );
        let broker = standby.unwrap().broker;
        assert_eq!(broker.addresses().skip(1).collect::<Vec<_>>(), [("b.example", 1885), ("c.example", 1883)]);
        assert_eq!(broker.exposed(), Some("b.example"));
    }

    #[test]
    fn the_credentials_are_read_from_a_private_file_and_never_shown() {
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join("broker.credentials");
        let table = "broker = 'mqtts://broker.example'\ncredentials = 'broker.credentials'";
        std::fs::write(&file, "user = 'hall'\npassword = 'quite secret'\n").unwrap();
        std::fs::set_permissions(&file, std::fs::Permissions::from_mode(0o644)).unwrap();
        let error = parse_in(folder.path(), table).unwrap_err();
        assert!(error.contains("chmod 600"), "{error}");
        std::fs::set_permissions(&file, std::fs::Permissions::from_mode(0o600)).unwrap();
        let settings = parse_in(folder.path(), table).unwrap();
        let credentials = settings.broker.credentials.as_ref().unwrap();
        assert_eq!((credentials.user.as_str(), credentials.password.reveal()), ("hall", "quite secret"));
        assert!(!format!("{settings:?}").contains("quite"));
        std::fs::write(&file, "user = 'hall'\npassword = quite-secret\n").unwrap();
        let error = parse_in(folder.path(), table).unwrap_err();
        assert!(error.contains("6:15: expected user = ") && !error.contains("quite"), "{error}");
    }
}
