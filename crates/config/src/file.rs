//! The configuration file as TOML: its tables, its keys and their defaults.

use super::alarms::AlarmToml;
use super::default_alarms::DefaultAlarmsToml;
use super::emails::EmailToml;
use super::error::{ConfigProblem, Located};
use super::gateways::GatewaysToml;
use super::gateways::archive::ArchiveToml;
use super::gateways::epics::EpicsToml;
use super::gateways::modbus::{self, ModbusToml};
use super::gateways::mqtt::MqttToml;
use super::gateways::opcua::OpcuaToml;
use super::gateways::prometheus::PrometheusToml;
use super::names::stem;
use super::plant::{PumpToml, ValveToml, VolumeToml};
use super::plant_states::PlantStateToml;
use super::retention::RetentionToml;
use super::segments::SegmentToml;
use super::views::ViewToml;
use super::webhooks::WebhookToml;
use crate::time_span::{DailyTime, Listen};
use profivac_client::suggestion::with_suggestion;
use profivac_devices::catalog::KnownDevices;
use profivac_host::text_file::Parsed;
use profivac_recorder::Retention;
use profivac_station::config::{Config, ConfigSource, UsersFile};
use profivac_station::directory::Directory;
use profivac_station::plant::PlantPicture;
use profivac_web_server::auth::openid::OpenIdSettings;
use profivac_web_server::server::{PemItem, TlsFiles};
use profivac_web_server::tables::openid::{OpenIdToml, Reach};
use serde::Deserialize;
use std::net::{Ipv4Addr, SocketAddr};
use std::ops::Range;
use std::path::{Path, PathBuf};
use toml::Spanned;

/// The default of `listen`: loopback, so that only this computer reaches the dashboard.
const LISTEN: (Ipv4Addr, u16) = (Ipv4Addr::LOCALHOST, 8080);

/// The whole file.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ConfigToml {
    /// The station itself: its name, its address, its database.
    #[serde(default)]
    pub station: StationToml,
    /// The certificate; without TLS the server listens on loopback only.
    tls: Option<TlsToml>,
    /// An OpenID provider at which users may log in, besides the file of the users.
    openid: Option<OpenIdToml>,
    /// How long rows of the database are kept, in recorded time.
    #[serde(default)]
    pub retention: RetentionToml,
    /// A PROFIBUS segment behind a port.
    #[serde(default)]
    pub segment: Vec<SegmentToml>,
    /// A limit alarm, an alarm of a rise, or one of the bus.
    #[serde(default)]
    pub alarm: Vec<AlarmToml>,
    /// The default alarms, which every segment and gauge has.
    #[serde(default)]
    pub alarms: DefaultAlarmsToml,
    /// A URL that is told of alarms.
    #[serde(default)]
    pub webhook: Vec<WebhookToml>,
    /// Recipients that are told of alarms by e-mail.
    #[serde(default)]
    pub email: Vec<EmailToml>,
    /// A volume in the picture of the plant.
    #[serde(default)]
    pub volume: Vec<VolumeToml>,
    /// A pump in the picture of the plant.
    #[serde(default)]
    pub pump: Vec<PumpToml>,
    /// A valve in the picture of the plant.
    #[serde(default)]
    pub valve: Vec<ValveToml>,
    /// A filter of the overview, or a group of trends, for all users.
    #[serde(default)]
    pub view: Vec<ViewToml>,
    /// What an operator declares about the plant, so that alarms that mean nothing then are suppressed.
    #[serde(default, rename = "plant-state")]
    pub plant_state: Vec<PlantStateToml>,
    /// The gateway for Modbus TCP.
    modbus: Option<ModbusToml>,
    /// What the station sends to an archive of many stations.
    archive: Option<ArchiveToml>,
    /// The gateway for EPICS.
    epics: Option<EpicsToml>,
    /// The gateway for MQTT and Sparkplug.
    mqtt: Option<MqttToml>,
    /// The gateway for OPC UA, in a program with this cargo feature.
    opcua: Option<OpcuaToml>,
    /// The gateway for Prometheus.
    prometheus: Option<PrometheusToml>,
}

/// `[station]`.
#[derive(Debug, Default, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct StationToml {
    /// The name of the station. Default: that of this file, without `.toml`.
    pub name: Option<Spanned<String>>,
    /// The address of the dashboard and of the API. Default: `127.0.0.1:8080`.
    listen: Option<Parsed<Listen>>,
    /// The database, beside this file. Default: the name of this file with `.db`.
    pub database: Option<Spanned<PathBuf>>,
    /// When the station checks the database for damage each day, by the clock of the computer: `03:00`, or `off`. Default: `03:00`.
    #[serde(rename = "database-check")]
    database_check: Option<Parsed<DailyTime>>,
    /// The file of the users, beside this file. Default: the name of this file with `.users.toml`.
    users: Option<PathBuf>,
    /// Names by which browsers reach this computer, besides `localhost` and the address of `listen`.
    #[serde(default)]
    pub hosts: Vec<Spanned<String>>,
    /// A drawing of the plant as SVG, beside this file, of at most 256 KiB. Elements with an `id` such as `gauge:chamber`,
    /// `volume:chamber`, `valve:slide` or `pump:turbo` are live.
    pub drawing: Option<Spanned<PathBuf>>,
    /// Files that describe devices, and folders of them, beside this file; those of the folder `devices` beside it need not be named.
    #[serde(default, rename = "device-files")]
    pub device_files: Vec<Spanned<PathBuf>>,
    /// The former name of `database`.
    pub record: Option<Spanned<PathBuf>>,
}

/// `[tls]`.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct TlsToml {
    /// The certificate in PEM, followed by its chain; beside this file. SIGHUP reads it again.
    certificate: Spanned<PathBuf>,
    /// Its private key in PEM, which only its owner may read.
    key: Spanned<PathBuf>,
}

impl TlsToml {
    fn files(&self, path: &Path) -> TlsFiles {
        let folder = path.parent().unwrap_or(Path::new(""));
        TlsFiles { certificate: folder.join(self.certificate.get_ref()), key: folder.join(self.key.get_ref()) }
    }
}

/// `[tls]` of a file whose other tables do not matter.
#[derive(Deserialize)]
struct OnlyTls {
    tls: TlsToml,
}

/// The octets of the value of `certificate` or `key` in `[tls]`.
pub fn tls_span(text: &str, item: PemItem) -> Option<Range<usize>> {
    let OnlyTls { tls } = toml::from_str(text).ok()?;
    Some(match item {
        PemItem::Certificate => tls.certificate.span(),
        PemItem::Key => tls.key.span(),
    })
}

impl ConfigToml {
    pub fn parse(text: &str) -> Result<Self, Located> {
        toml::from_str(text).map_err(|error| {
            let span = error.span().unwrap_or_default();
            Located::new(span, ConfigProblem::Syntax(with_suggestion(error.message())))
        })
    }

    /// The settings of `[openid]`, whose files are in `folder`.
    pub fn openid(&self, folder: &Path) -> Result<Option<OpenIdSettings>, Located> {
        let hosts: Vec<_> = self.station.hosts.iter().map(|host| host.get_ref().clone()).collect();
        let reach = Reach { listen: self.listen(), hosts: &hosts };
        Ok(self.openid.as_ref().map(|openid| openid.settings(folder, &reach)).transpose()?)
    }

    fn listen(&self) -> SocketAddr {
        self.station.listen.as_ref().map_or_else(|| SocketAddr::from(LISTEN), |listen| listen.0.0)
    }

    /// Takes the tables of the gateways of the file at `path`.
    pub fn take_gateways(&mut self, path: &Path) -> Result<GatewaysToml, Located> {
        let gauges = self.segment.iter().flat_map(|segment| &segment.gauge);
        let slots = gauges.filter_map(|gauge| Some((gauge.name.get_ref().as_str(), gauge.modbus.as_ref()?)));
        let slaves = self.segment.iter().flat_map(|segment| &segment.slave);
        let slots =
            slots.chain(slaves.filter_map(|slave| Some((slave.name.get_ref().as_str(), slave.modbus.as_ref()?))));
        Ok(GatewaysToml {
            epics: self.epics.take(),
            modbus_slots: modbus::check_slots(slots)?,
            archive: self.archive.take(),
            modbus: self.modbus.take(),
            mqtt: self.mqtt.take(),
            opcua: self.opcua.take(),
            prometheus: self.prometheus.take(),
            tls: self.tls.as_ref().map(|tls| tls.files(path)),
            users: users_file(self.station.users.as_deref(), path).path,
        })
    }

    /// The configuration without its source, provider, alarms, plant states, webhooks, e-mails, plant, directory, retention and gateways.
    pub fn into_config(self, path: &Path) -> Config {
        let (stem, listen) = (stem(path), self.listen());
        let database = self.station.database.or(self.station.record).map(Spanned::into_inner);
        let folder = path.parent().unwrap_or(Path::new(""));
        let beside = |file: PathBuf| folder.join(file);
        let users = users_file(self.station.users.as_deref(), path);
        Config {
            listen,
            database: beside(database.unwrap_or_else(|| PathBuf::from(format!("{stem}.db")))),
            retention: Retention::default(),
            database_check: self.station.database_check.map_or_else(DailyTime::default, |at| at.0).0,
            name: self.station.name.map_or(stem, Spanned::into_inner),
            users,
            hosts: self.station.hosts.into_iter().map(Spanned::into_inner).collect(),
            tls: self.tls.map(|tls| tls.files(path)),
            openid: None,
            devices: KnownDevices::BUILT_IN,
            segments: self.segment.into_iter().map(|segment| segment.into_segment(folder)).collect(),
            alarms: Vec::new(),
            plant_states: Vec::new(),
            webhooks: Vec::new(),
            emails: Vec::new(),
            gateways: Vec::new(),
            plant: PlantPicture::default(),
            directory: Directory::default(),
            renamed_keys: Vec::new(),
            source: ConfigSource::default(),
        }
    }
}

/// The part of a file that names the file of the users.
#[derive(Deserialize)]
struct UsersOnly {
    #[serde(default)]
    station: UsersKey,
}

#[derive(Default, Deserialize)]
struct UsersKey {
    users: Option<PathBuf>,
}

/// The file of the users that `text` names, whatever else is in it.
pub fn users_file_of(text: &str, path: &Path) -> Result<PathBuf, Located> {
    let found: UsersOnly = toml::from_str(text).map_err(|error| {
        Located::new(error.span().unwrap_or_default(), ConfigProblem::Syntax(error.message().to_owned()))
    })?;
    Ok(users_file(found.station.users.as_deref(), path).path)
}

/// The file of the users: that of the key `users`, or the default beside the file at `path`.
fn users_file(named: Option<&Path>, path: &Path) -> UsersFile {
    let default = || path.with_file_name(format!("{}.users.toml", stem(path)));
    let beside = |file: &Path| path.parent().unwrap_or(Path::new("")).join(file);
    UsersFile { named: named.is_some(), path: named.map_or_else(default, beside) }
}
