//! The settings of a station, as its file has them after all checks. `profivac-config` reads the file.
//!
//! | Module | Holds |
//! |---|---|
//! | `alarm_settings`, `default_settings` | settings of alarms in the text of the file, and their change |
//! | [`changes`] | what differs between two texts of the file |
//! | `default_alarms` | what holds for the default alarms without settings |
//! | `emails`, `webhooks` | who is told of alarms |
//! | [`gateways`] | the gateways to control systems |
//! | `slave` | a slave by its GSD file, and its points |
//! | `source` | path and text of the file |

mod alarm_settings;
pub mod changes;
pub mod default_alarms;
mod default_settings;
mod emails;
pub mod gateways;
mod slave;
mod source;
mod webhooks;

pub use alarm_settings::{AlarmSettings, SettingsError};
pub use default_alarms::settings_by_default;
pub use default_settings::DefaultAlarmSettings;
pub use emails::{Email, MailSecurity, Mailbox};
pub use slave::{PointType, PointValue, Slave, SlavePoint, WatchedRecord, unit};
pub use source::{ConfigSource, Parse};
pub use webhooks::Webhook;

use crate::alarm::{PlantStateRule, Rule};
use crate::directory::Directory;
use crate::plant::PlantPicture;
use gateways::GatewaySettings;
use profivac_client::cyclic::IntegerRange;
use profivac_client::pressure::Pressure;
use profivac_devices::catalog::KnownDevices;
use profivac_devices::model::{Configuration, Model, Unit};
use profivac_dp::link::Baud;
use profivac_recorder::{Forward, Retention};
use profivac_vacuum::Gas;
use profivac_web_server::auth::Access;
use profivac_web_server::auth::openid::OpenIdSettings;
use profivac_web_server::server::TlsFiles;
use std::net::SocketAddr;
use std::path::PathBuf;
use std::time::Duration;

/// The default of `poll`.
pub const POLL: Duration = Duration::from_millis(200);

/// The port of a segment in memory without a file.
pub const MEMORY_PORT: &str = "in memory";

/// Whether a port leads to devices in memory.
#[must_use]
pub fn is_virtual(port: &str) -> bool {
    port.starts_with("sim:") || port == MEMORY_PORT
}

/// The configuration of a station.
#[derive(Clone, Debug, PartialEq)]
pub struct Config {
    /// The devices that the station knows.
    pub devices: KnownDevices,
    /// The name of the station.
    pub name: String,
    /// The address of the dashboard and the API.
    pub listen: SocketAddr,
    /// The path of the database.
    pub database: PathBuf,
    /// How long rows of the database are kept.
    pub retention: Retention,
    /// When the database is checked for damage each day, by the time zone of the computer; `None` never.
    pub database_check: Option<jiff::civil::Time>,
    /// The users' file.
    pub users: UsersFile,
    /// Host names and addresses of this computer, without ports.
    pub hosts: Vec<String>,
    /// The certificate and its key, if the station uses TLS.
    pub tls: Option<TlsFiles>,
    /// The OpenID provider at which users may log in besides.
    pub openid: Option<OpenIdSettings>,
    /// The segments.
    pub segments: Vec<Segment>,
    /// The alarms of the file, then the default alarms.
    pub alarms: Vec<Rule>,
    /// The plant states, in the order of the file.
    pub plant_states: Vec<PlantStateRule>,
    /// The webhooks that receive alarm notifications.
    pub webhooks: Vec<Webhook>,
    /// The recipients of alarm notifications by e-mail.
    pub emails: Vec<Email>,
    /// The gateways to control systems.
    pub gateways: Vec<GatewaySettings>,
    /// The picture of the plant; empty if the file has none.
    pub plant: PlantPicture,
    /// The labels of the gauges, and the views.
    pub directory: Directory,
    /// Keys that are written with a former name.
    pub renamed_keys: Vec<RenamedKey>,
    /// The file itself.
    pub source: ConfigSource,
}

impl Config {
    /// Which samples go into the outbox, if the record is sent to an archive.
    #[must_use]
    pub fn outbox(&self) -> Option<Forward> {
        self.gateways.iter().find_map(|gateway| match gateway {
            GatewaySettings::Archive(settings) => Some(settings.samples),
            _ => None,
        })
    }

    /// How users authenticate: by the users' file; while there is none, every request is that of an anonymous viewer. With an OpenID
    /// provider there must be a file, so that a provider that is down locks no engineer out.
    #[must_use]
    pub fn access(&self) -> Access {
        let UsersFile { path, named } = &self.users;
        if *named || self.openid.is_some() || path.exists() {
            Access::Users(path.clone())
        } else {
            Access::UsersWhenPresent(path.clone())
        }
    }

    /// Whether the file holds secrets or names the files that hold them, so that only its owner may read it. The URL of a
    /// webhook is often a secret.
    #[must_use]
    pub fn is_private(&self) -> bool {
        let has_secrets = self.openid.is_some() || self.gateways.iter().any(GatewaySettings::is_private);
        self.users.named || self.tls.is_some() || !self.webhooks.is_empty() || !self.emails.is_empty() || has_secrets
    }
}

/// A key that is written with a former name. The station accepts it.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{file}:{line}:{column}: the key {old} is now called {new}; the former name still works", file = file.display())]
pub struct RenamedKey {
    /// The configuration file.
    pub file: PathBuf,
    /// The line of the key, from 1.
    pub line: usize,
    /// The column of the key, from 1.
    pub column: usize,
    /// The former name.
    pub old: &'static str,
    /// The current name.
    pub new: &'static str,
}

/// The file that holds the users.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct UsersFile {
    /// Its path.
    pub path: PathBuf,
    /// Whether the configuration file names it. A named file must exist.
    pub named: bool,
}

/// A segment.
#[derive(Clone, Debug, PartialEq)]
pub struct Segment {
    /// Its name, unique in the station.
    pub name: String,
    /// Its port.
    pub port: String,
    /// Its baud rate.
    pub baud: Baud,
    /// The baud rate is not in the file: the station finds it by listening.
    pub detects_baud: bool,
    /// The station only listens and sends nothing.
    pub listen_only: bool,
    /// The address of the station's master. A segment that only listens has none.
    pub master: u8,
    /// Its gauges.
    pub gauges: Vec<Gauge>,
    /// Its other slaves, by their GSD files.
    pub slaves: Vec<Slave>,
    /// The devices that the station knows.
    pub devices: KnownDevices,
}

/// A gauge.
#[derive(Clone, Debug, PartialEq)]
pub struct Gauge {
    /// Its name, unique in the station.
    pub name: String,
    /// Its bus address.
    pub address: u8,
    /// The tables of its device.
    pub device: &'static Model,
    /// The sampling interval.
    pub poll: Duration,
    /// The gas in the chamber.
    pub gas: Gas,
    /// The configuration of a gauge of another master, if the file names it.
    pub configuration: Option<&'static Configuration>,
    /// The unit of a gauge of another master, if the file names it.
    pub unit: Option<&'static Unit>,
    /// Horizontal lines in the trend: name and pressure.
    pub levels: Vec<(String, Pressure)>,
}

impl Gauge {
    /// A gauge with the defaults of all other keys.
    #[must_use]
    pub const fn plain(name: String, address: u8, device: &'static Model) -> Self {
        Self { name, address, device, poll: POLL, gas: Gas::N2, configuration: None, unit: None, levels: Vec::new() }
    }

    /// The pressures that the integers of the configuration show, if the file names configuration and unit.
    #[must_use]
    pub fn integer_range(&self) -> Option<IntegerRange> {
        IntegerRange::of(self.device, self.configuration?, self.unit?)
    }

    /// The pressures that the integers of the configuration show in each unit, if the file names the configuration and no unit. Empty for
    /// floats.
    #[must_use]
    pub fn integer_ranges(&self) -> Vec<IntegerRange> {
        match (self.configuration, self.unit) {
            (Some(configuration), None) => IntegerRange::in_every_unit(self.device, configuration),
            _ => Vec::new(),
        }
    }

    /// Whether both entries describe the same slave: address and device model are equal.
    #[must_use]
    pub fn is_same_slave(&self, other: &Self) -> bool {
        (self.address, self.device) == (other.address, other.device)
    }
}
