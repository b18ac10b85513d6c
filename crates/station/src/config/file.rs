//! The configuration file as TOML: its tables, its keys and their defaults.

use super::alarms::AlarmToml;
use super::default_alarms::DefaultAlarmsToml;
use super::error::{ConfigProblem, Located};
use super::webhooks::WebhookToml;
use super::{Config, Gauge, Segment, TlsFiles, UsersFile};
use profivac_client::pressure::Pressure;
use profivac_dp::link::Baud;
use profivac_host::text_file::{Parsed, baud, usual_baud};
use profivac_vacuum::Gas;
use serde::Deserialize;
use std::collections::BTreeMap;
use std::net::{Ipv4Addr, SocketAddr};
use std::path::{Path, PathBuf};
use std::time::Duration;
use toml::Spanned;

/// The default of `listen`: loopback, so that only this computer reaches the dashboard.
const LISTEN: (Ipv4Addr, u16) = (Ipv4Addr::LOCALHOST, 8080);

/// The default of `poll`.
pub const POLL: Duration = Duration::from_millis(200);

/// The whole file.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ConfigToml {
    #[serde(default)]
    pub station: StationToml,
    tls: Option<TlsToml>,
    #[serde(default)]
    pub segment: Vec<SegmentToml>,
    #[serde(default)]
    pub alarm: Vec<AlarmToml>,
    #[serde(default)]
    pub alarms: DefaultAlarmsToml,
    #[serde(default)]
    pub webhook: Vec<WebhookToml>,
}

/// `[station]`.
#[derive(Debug, Default, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct StationToml {
    name: Option<String>,
    listen: Option<Parsed<SocketAddr>>,
    pub database: Option<Spanned<PathBuf>>,
    users: Option<PathBuf>,
    #[serde(default)]
    pub hosts: Vec<Spanned<String>>,
    /// The former name of `database`.
    pub record: Option<Spanned<PathBuf>>,
}

/// `[tls]`.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct TlsToml {
    certificate: PathBuf,
    key: PathBuf,
}

/// `[[segment]]`.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct SegmentToml {
    pub name: Spanned<String>,
    pub port: Spanned<String>,
    #[serde(default = "usual_baud", deserialize_with = "baud")]
    baud: Baud,
    #[serde(default)]
    pub master: Option<Spanned<u8>>,
    #[serde(default)]
    pub gauge: Vec<GaugeToml>,
}

/// `[[segment.gauge]]`.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct GaugeToml {
    pub name: Spanned<String>,
    pub address: Spanned<u8>,
    pub device: Spanned<String>,
    pub poll: Option<Spanned<Parsed<humantime::Duration>>>,
    gas: Option<Parsed<Gas>>,
    #[serde(default)]
    levels: BTreeMap<String, Parsed<Pressure>>,
}

impl ConfigToml {
    pub fn parse(text: &str) -> Result<Self, Located> {
        toml::from_str(text).map_err(|error| {
            let span = error.span().unwrap_or_default();
            Located::new(span, ConfigProblem::Syntax(error.message().to_owned()))
        })
    }

    /// The names of all gauges.
    pub fn gauge_names(&self) -> impl Iterator<Item = &str> {
        self.segment.iter().flat_map(|segment| &segment.gauge).map(|gauge| gauge.name.get_ref().as_str())
    }

    /// The configuration without alarms and webhooks.
    pub fn into_config(self, path: &Path) -> Config {
        let stem = path.file_stem().map_or_else(|| "station".to_owned(), |stem| stem.to_string_lossy().into_owned());
        let database = self.station.database.or(self.station.record).map(Spanned::into_inner);
        let beside = |file: PathBuf| path.parent().unwrap_or(Path::new("")).join(file);
        let users = UsersFile {
            named: self.station.users.is_some(),
            path: beside(self.station.users.unwrap_or_else(|| PathBuf::from(format!("{stem}.users.toml")))),
        };
        Config {
            listen: self.station.listen.map_or_else(|| SocketAddr::from(LISTEN), |listen| listen.0),
            database: beside(database.unwrap_or_else(|| PathBuf::from(format!("{stem}.db")))),
            name: self.station.name.unwrap_or(stem),
            users,
            hosts: self.station.hosts.into_iter().map(Spanned::into_inner).collect(),
            tls: self.tls.map(|tls| TlsFiles { certificate: beside(tls.certificate), key: beside(tls.key) }),
            segments: self.segment.into_iter().map(SegmentToml::into_segment).collect(),
            alarms: Vec::new(),
            webhooks: Vec::new(),
            renamed_keys: Vec::new(),
        }
    }
}

impl SegmentToml {
    /// The address of the station's master on this segment.
    pub fn master_address(&self) -> u8 {
        self.master.as_ref().map_or(0, |master| *master.get_ref())
    }

    fn into_segment(self) -> Segment {
        Segment {
            master: self.master_address(),
            name: self.name.into_inner(),
            port: self.port.into_inner(),
            baud: self.baud,
            gauges: self.gauge.into_iter().map(GaugeToml::into_gauge).collect(),
        }
    }
}

impl GaugeToml {
    fn into_gauge(self) -> Gauge {
        Gauge {
            name: self.name.into_inner(),
            address: self.address.into_inner(),
            device: self.device.into_inner(),
            poll: self.poll.map_or(POLL, |poll| poll.into_inner().0.into()),
            gas: self.gas.map_or(Gas::N2, |gas| gas.0),
            levels: self.levels.into_iter().map(|(name, level)| (name, level.0)).collect(),
        }
    }
}
