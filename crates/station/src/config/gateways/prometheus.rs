//! `[prometheus]`.

use super::super::error::Located;
use profivac_host::text_file::Parsed;
use serde::Deserialize;
use std::net::{Ipv4Addr, SocketAddr};
use std::path::Path;

/// The default of `listen`: loopback, port 9464.
const LISTEN: (Ipv4Addr, u16) = (Ipv4Addr::LOCALHOST, 9464);

/// The settings of the Prometheus gateway.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Settings {
    /// The address at which it serves `/metrics`.
    pub listen: SocketAddr,
}

/// `[prometheus]` as TOML.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct PrometheusToml {
    listen: Option<Parsed<SocketAddr>>,
}

impl PrometheusToml {
    /// The settings, with the defaults of the keys that are absent.
    pub fn into_settings(self, _path: &Path) -> Result<Settings, Located> {
        Ok(Settings { listen: self.listen.map_or_else(|| SocketAddr::from(LISTEN), |listen| listen.0) })
    }
}
