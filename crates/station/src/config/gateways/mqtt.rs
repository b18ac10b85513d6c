//! The settings of the gateway for MQTT.

use profivac_web_server::host_name::is_loopback;
use profivac_web_server::tables::Credentials;
use serde::Deserialize;
use std::path::PathBuf;
use std::time::Duration;

/// The settings of the MQTT gateway.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Settings {
    /// The broker.
    pub broker: Broker,
    /// The plain topics, if they are published.
    pub plain: Option<Plain>,
    /// The edge node of Sparkplug B, if there is one.
    pub sparkplug: Option<Sparkplug>,
}

/// A broker and how the station logs in there.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Broker {
    /// The host name or address, without brackets.
    pub host: String,
    /// The port.
    pub port: u16,
    /// TLS, unless the connection is unencrypted.
    pub tls: Option<Tls>,
    /// User and password.
    pub credentials: Option<Credentials>,
    /// The client identifier; without it the gateway makes one from the name of the station.
    pub client_id: Option<String>,
    /// Hosts and ports of further brokers, to which the gateway connects while the ones before cannot be reached. Login and certificates
    /// are the same.
    pub standby: Vec<(String, u16)>,
}

impl Broker {
    /// The first host to which the connection leaves this computer without encryption.
    #[must_use]
    pub fn exposed(&self) -> Option<&str> {
        self.addresses().map(|(host, _)| host).find(|host| self.tls.is_none() && !is_loopback(host))
    }

    /// Hosts and ports of all brokers, the first one first.
    pub fn addresses(&self) -> impl Iterator<Item = (&str, u16)> {
        let standby = self.standby.iter().map(|(host, port)| (host.as_str(), *port));
        std::iter::once((self.host.as_str(), self.port)).chain(standby)
    }
}

/// The certificates for a broker with TLS, as files in PEM.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Tls {
    /// Certificates that are trusted in addition to those of the system.
    pub ca_file: Option<PathBuf>,
    /// The certificate of the station with its chain, and its key.
    pub client: Option<(PathBuf, PathBuf)>,
}

/// The plain topics.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Plain {
    /// What all topics begin with; without it the gateway makes it from the name of the station.
    pub prefix: Option<String>,
    /// Where the gateway describes its sensors for Home Assistant, if it does so.
    pub discovery: Option<Discovery>,
}

/// The descriptions for Home Assistant.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Discovery {
    /// What their topics begin with.
    pub prefix: String,
    /// `object_id` gives the name of an entity, for Home Assistant before 2025.10, in place of `default_entity_id`.
    pub has_object_id: bool,
}

/// What identifies a metric of Sparkplug in data.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum DataStyle {
    /// Its name and data type; births have no aliases.
    #[default]
    Names,
    /// The alias of its birth alone.
    Aliases,
}

/// The edge node of Sparkplug B.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Sparkplug {
    /// The group.
    pub group: String,
    /// The edge node; without it the name of the station.
    pub edge_node: Option<String>,
    /// What identifies a metric in data.
    pub data: DataStyle,
    /// The host that must be online before the edge node publishes.
    pub primary_host: Option<String>,
    /// The longest outage after which the samples of the outage are sent; the samples before are not.
    pub backlog: Duration,
}
