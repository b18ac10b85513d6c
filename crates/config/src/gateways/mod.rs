//! The gateways to control systems: one table of the file for each. A program without a gateway reads its table as well, so that
//! the same file has the same errors everywhere.

pub mod archive;
pub mod epics;
pub mod modbus;
pub mod mqtt;
pub mod opcua;
pub mod prometheus;
pub mod write;

use super::error::Located;
use archive::ArchiveToml;
use epics::EpicsToml;
use modbus::ModbusToml;
use mqtt::MqttToml;
use opcua::OpcuaToml;
use profivac_web_server::server::TlsFiles;
use prometheus::PrometheusToml;
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use write::Write;

/// The tables of the gateways in the file.
#[derive(Debug, Default)]
pub struct GatewaysToml {
    /// `[archive]`.
    pub archive: Option<ArchiveToml>,
    /// `[epics]`.
    pub epics: Option<EpicsToml>,
    /// `[mqtt]`.
    pub mqtt: Option<MqttToml>,
    /// `[modbus]`.
    pub modbus: Option<ModbusToml>,
    /// The first slot of each gauge that the file gives one in the map of Modbus.
    pub modbus_slots: BTreeMap<String, u16>,
    /// `[opcua]`.
    pub opcua: Option<OpcuaToml>,
    /// `[prometheus]`.
    pub prometheus: Option<PrometheusToml>,
    /// `[tls]`, for gateways that use the certificate of the station.
    pub tls: Option<TlsFiles>,
    /// The file of the users, for gateways with a login.
    pub users: PathBuf,
}

/// The settings of a gateway.
#[derive(Clone, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum GatewaySettings {
    /// `[archive]`.
    Archive(Box<archive::Settings>),
    /// `[epics]`.
    Epics(epics::Settings),
    /// `[mqtt]`.
    Mqtt(Box<mqtt::Settings>),
    /// `[modbus]`.
    Modbus(modbus::Settings),
    /// `[opcua]`.
    Opcua(opcua::Settings),
    /// `[prometheus]`.
    Prometheus(prometheus::Settings),
}

impl GatewaySettings {
    /// The name of its table, which is also that of the gateway.
    #[must_use]
    pub const fn name(&self) -> &'static str {
        match self {
            Self::Archive(_) => "archive",
            Self::Epics(_) => "epics",
            Self::Mqtt(_) => "mqtt",
            Self::Modbus(_) => "modbus",
            Self::Opcua(_) => "opcua",
            Self::Prometheus(_) => "prometheus",
        }
    }

    /// The broker or server on another computer to which it connects without encryption.
    #[must_use]
    pub fn unencrypted_broker(&self) -> Option<&str> {
        match self {
            Self::Archive(it) => it.transport.exposed(),
            Self::Mqtt(it) => it.broker.exposed(),
            Self::Epics(_) | Self::Modbus(_) | Self::Opcua(_) | Self::Prometheus(_) => None,
        }
    }

    /// Where it listens for other computers without encryption and login, because its protocol has none.
    #[must_use]
    pub fn unprotected(&self) -> Option<String> {
        match self {
            Self::Epics(settings) => settings.is_open_to_network().then(|| settings.addresses()),
            Self::Modbus(settings) => (!settings.listen.ip().is_loopback()).then(|| settings.listen.to_string()),
            Self::Archive(_) | Self::Mqtt(_) | Self::Opcua(_) | Self::Prometheus(_) => None,
        }
    }

    /// As which user its clients write, where they may.
    #[must_use]
    pub fn writer(&self) -> Option<&Write> {
        match self {
            Self::Epics(settings) => settings.write.as_ref(),
            Self::Archive(_) | Self::Modbus(_) | Self::Mqtt(_) | Self::Opcua(_) | Self::Prometheus(_) => None,
        }
    }

    /// Whether its table holds secrets or names the files that hold them.
    #[must_use]
    pub fn is_private(&self) -> bool {
        match self {
            Self::Archive(it) => it.transport.is_private(),
            Self::Epics(_) | Self::Modbus(_) | Self::Opcua(_) => false,
            Self::Mqtt(it) => {
                it.broker.credentials.is_some() || it.broker.tls.as_ref().is_some_and(|tls| tls.client.is_some())
            }
            Self::Prometheus(settings) => settings.token.is_some(),
        }
    }
}

/// The settings of all gateways of the file at `path`.
pub fn settings(toml: GatewaysToml, path: &Path) -> Result<Vec<GatewaySettings>, Located> {
    let GatewaysToml { archive, epics, modbus, modbus_slots, mqtt, opcua, prometheus, tls, users } = toml;
    let archive = archive.map(|it| it.into_settings(path)).transpose()?;
    let archive = archive.map(|it| GatewaySettings::Archive(Box::new(it)));
    let epics = epics.map(|it| it.into_settings(&users)).transpose()?.map(GatewaySettings::Epics);
    let modbus = modbus.map(|it| it.into_settings(modbus_slots)).transpose()?.map(GatewaySettings::Modbus);
    let mqtt = mqtt.map(|it| it.into_settings(path)).transpose()?.map(|it| GatewaySettings::Mqtt(Box::new(it)));
    let opcua = opcua.map(|it| it.into_settings(path, users)).transpose()?.map(GatewaySettings::Opcua);
    let prometheus =
        prometheus.map(|it| it.into_settings(path, tls.as_ref())).transpose()?.map(GatewaySettings::Prometheus);
    Ok(archive.into_iter().chain(epics).chain(modbus).chain(mqtt).chain(opcua).chain(prometheus).collect())
}
