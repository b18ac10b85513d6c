//! The gateways to control systems: one table of the file for each. A program without a gateway reads its table as well, so that
//! the same file has the same errors everywhere.

pub mod prometheus;

use super::TlsFiles;
use super::error::Located;
use prometheus::PrometheusToml;
use std::path::Path;

/// The tables of the gateways in the file.
#[derive(Debug, Default)]
pub struct GatewaysToml {
    /// `[prometheus]`.
    pub prometheus: Option<PrometheusToml>,
    /// `[tls]`, for gateways that use the certificate of the station.
    pub tls: Option<TlsFiles>,
}

/// The settings of a gateway.
#[derive(Clone, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum GatewaySettings {
    /// `[prometheus]`.
    Prometheus(prometheus::Settings),
}

impl GatewaySettings {
    /// The name of its table, which is also that of the gateway.
    #[must_use]
    pub const fn name(&self) -> &'static str {
        match self {
            Self::Prometheus(_) => "prometheus",
        }
    }

    /// Whether it names a file with a secret.
    #[must_use]
    pub const fn is_private(&self) -> bool {
        match self {
            Self::Prometheus(settings) => settings.token.is_some(),
        }
    }
}

/// The settings of all gateways of the file at `path`.
pub fn settings(toml: GatewaysToml, path: &Path) -> Result<Vec<GatewaySettings>, Located> {
    let GatewaysToml { prometheus, tls } = toml;
    let prometheus =
        prometheus.map(|it| it.into_settings(path, tls.as_ref())).transpose()?.map(GatewaySettings::Prometheus);
    Ok(prometheus.into_iter().collect())
}
