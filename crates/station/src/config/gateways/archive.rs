//! The settings of the station's side of an archive.

use hyper::Uri;
use profivac_recorder::Forward;
use profivac_web_server::host_name::is_loopback;
use profivac_web_server::tables::Secret;
use profivac_web_server::tables::archive::Nats;
use serde::Deserialize;
use std::path::PathBuf;

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
    /// Where the batches go.
    pub transport: Transport,
    /// What users of the archive may ask the station for.
    pub requests: Requests,
    /// The hours without an answer of the archive after which there is an alarm; `None` for no alarm.
    pub alarm_hours: Option<f64>,
}

/// What users of the archive may ask a station for. Each permits what those before it permit.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Requests {
    /// Nothing.
    #[default]
    Off,
    /// Trends from the database of the station.
    Read,
    /// An operator of the archive acknowledges alarms of the station.
    Acknowledge,
}

// The deadband is a number of the file, never NaN.
impl Eq for Settings {}

/// Where the batches of a station go.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Transport {
    /// To servers of NATS.
    Nats(Nats),
    /// To the archive itself.
    Https(Https),
}

impl Transport {
    /// The first host to which the connection leaves this computer without encryption.
    #[must_use]
    pub fn exposed(&self) -> Option<&str> {
        match self {
            Self::Nats(nats) => nats.exposed(),
            Self::Https(https) => https.exposed(),
        }
    }

    /// Whether its table names a file with a secret.
    #[must_use]
    pub const fn is_private(&self) -> bool {
        match self {
            Self::Nats(nats) => nats.credentials.is_some(),
            Self::Https(_) => true,
        }
    }
}

/// An archive that takes batches over HTTPS.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Https {
    /// Its URL: `https://` or `http://`, with a host and without a path.
    pub url: Uri,
    /// The URLs of the archives whose users ask the station.
    pub request_urls: Vec<Uri>,
    /// The token of the station.
    pub token: Secret,
    /// Certificates that are trusted in addition to those of the system.
    pub ca_file: Option<PathBuf>,
}

impl Https {
    /// The first host to which a connection leaves this computer without encryption.
    fn exposed(&self) -> Option<&str> {
        let plain = std::iter::once(&self.url).chain(&self.request_urls).filter(|url| url.scheme_str() == Some("http"));
        plain.filter_map(Uri::host).find(|host| !is_loopback(host))
    }
}
