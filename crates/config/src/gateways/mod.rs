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
use profivac_station::alarm::Rule;
use profivac_station::config::gateways::GatewaySettings;
use profivac_web_server::server::TlsFiles;
use prometheus::PrometheusToml;
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

/// The alarm that a gateway has by default.
pub fn alarm(gateway: &GatewaySettings) -> Option<Rule> {
    match gateway {
        GatewaySettings::Archive(settings) => archive::alarm(settings),
        _ => None,
    }
}

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
