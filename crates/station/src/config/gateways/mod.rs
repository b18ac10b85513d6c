//! The gateways to control systems: one table of the file for each. A program without a gateway reads its table as well, so that
//! the same file has the same errors everywhere.

pub mod epics;
pub mod prometheus;

use super::error::Located;
use epics::EpicsToml;
use prometheus::PrometheusToml;
use std::path::Path;

/// The tables of the gateways in the file.
#[derive(Debug, Default)]
pub struct GatewaysToml {
    /// `[epics]`.
    pub epics: Option<EpicsToml>,
    /// `[prometheus]`.
    pub prometheus: Option<PrometheusToml>,
}

/// The settings of a gateway.
#[derive(Clone, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum GatewaySettings {
    /// `[epics]`.
    Epics(epics::Settings),
    /// `[prometheus]`.
    Prometheus(prometheus::Settings),
}

impl GatewaySettings {
    /// The name of its table, which is also that of the gateway.
    #[must_use]
    pub const fn name(&self) -> &'static str {
        match self {
            Self::Epics(_) => "epics",
            Self::Prometheus(_) => "prometheus",
        }
    }
}

impl GatewaySettings {
    /// Whether other computers reach the gateway and its protocol has neither login nor encryption.
    #[must_use]
    pub fn is_open_to_network(&self) -> bool {
        match self {
            Self::Epics(settings) => settings.is_open_to_network(),
            _ => false,
        }
    }
}

/// The settings of all gateways of the file at `path`.
pub fn settings(toml: GatewaysToml, path: &Path) -> Result<Vec<GatewaySettings>, Located> {
    let GatewaysToml { epics, prometheus } = toml;
    let epics = epics.map(|it| it.into_settings(path)).transpose()?.map(GatewaySettings::Epics);
    let prometheus = prometheus.map(|it| it.into_settings(path)).transpose()?.map(GatewaySettings::Prometheus);
    Ok(epics.into_iter().chain(prometheus).collect())
}
