//! The gateways to control systems: one table of the file for each. A program without a gateway reads its table as well, so that
//! the same file has the same errors everywhere.

pub mod modbus;
pub mod prometheus;

use super::TlsFiles;
use super::error::Located;
use modbus::ModbusToml;
use prometheus::PrometheusToml;
use std::collections::BTreeMap;
use std::net::SocketAddr;
use std::path::Path;

/// The tables of the gateways in the file.
#[derive(Debug, Default)]
pub struct GatewaysToml {
    /// `[modbus]`.
    pub modbus: Option<ModbusToml>,
    /// The first slot of each gauge that the file gives one in the map of Modbus.
    pub modbus_slots: BTreeMap<String, u16>,
    /// `[prometheus]`.
    pub prometheus: Option<PrometheusToml>,
    /// `[tls]`, for gateways that use the certificate of the station.
    pub tls: Option<TlsFiles>,
}

/// The settings of a gateway.
#[derive(Clone, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum GatewaySettings {
    /// `[modbus]`.
    Modbus(modbus::Settings),
    /// `[prometheus]`.
    Prometheus(prometheus::Settings),
}

impl GatewaySettings {
    /// The name of its table, which is also that of the gateway.
    #[must_use]
    pub const fn name(&self) -> &'static str {
        match self {
            Self::Modbus(_) => "modbus",
            Self::Prometheus(_) => "prometheus",
        }
    }

    /// Where it listens beyond this computer without encryption and login, because its protocol has none.
    #[must_use]
    pub const fn unprotected(&self) -> Option<SocketAddr> {
        match self {
            Self::Modbus(settings) if !settings.listen.ip().is_loopback() => Some(settings.listen),
            Self::Modbus(_) | Self::Prometheus(_) => None,
        }
    }

    /// Whether it names a file with a secret.
    #[must_use]
    pub const fn is_private(&self) -> bool {
        match self {
            Self::Modbus(_) => false,
            Self::Prometheus(settings) => settings.token.is_some(),
        }
    }
}

/// The settings of all gateways of the file at `path`.
pub fn settings(toml: GatewaysToml, path: &Path) -> Result<Vec<GatewaySettings>, Located> {
    let GatewaysToml { modbus, modbus_slots, prometheus, tls } = toml;
    let modbus = modbus.map(|it| it.into_settings(modbus_slots)).transpose()?.map(GatewaySettings::Modbus);
    let prometheus =
        prometheus.map(|it| it.into_settings(path, tls.as_ref())).transpose()?.map(GatewaySettings::Prometheus);
    Ok(modbus.into_iter().chain(prometheus).collect())
}
