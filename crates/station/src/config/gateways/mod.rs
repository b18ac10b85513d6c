//! The gateways to control systems: one table of the file for each. A program without a gateway reads its table as well, so that
//! the same file has the same errors everywhere.

pub mod opcua;
pub mod prometheus;

use super::error::Located;
use opcua::OpcuaToml;
use prometheus::PrometheusToml;
use std::path::{Path, PathBuf};

/// The tables of the gateways in the file.
#[derive(Debug, Default)]
pub struct GatewaysToml {
    /// `[opcua]`.
    pub opcua: Option<OpcuaToml>,
    /// `[prometheus]`.
    pub prometheus: Option<PrometheusToml>,
    /// The file of the users, for gateways with a login.
    pub users: PathBuf,
}

/// The settings of a gateway.
#[derive(Clone, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum GatewaySettings {
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
            Self::Opcua(_) => "opcua",
            Self::Prometheus(_) => "prometheus",
        }
    }
}

/// The settings of all gateways of the file at `path`.
pub fn settings(toml: GatewaysToml, path: &Path) -> Result<Vec<GatewaySettings>, Located> {
    let GatewaysToml { opcua, prometheus, users } = toml;
    let opcua = opcua.map(|it| it.into_settings(path, users)).transpose()?.map(GatewaySettings::Opcua);
    let prometheus = prometheus.map(|it| it.into_settings(path)).transpose()?.map(GatewaySettings::Prometheus);
    Ok(opcua.into_iter().chain(prometheus).collect())
}
