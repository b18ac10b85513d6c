//! The settings of the gateway for Prometheus.

use profivac_web_server::server::TlsFiles;
use profivac_web_server::tables::Secret;
use std::net::SocketAddr;

/// The settings of the Prometheus gateway.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Settings {
    /// The address at which it serves `/metrics`.
    pub listen: SocketAddr,
    /// The bearer token that a scrape must have.
    pub token: Option<Secret>,
    /// The certificate of the station, beyond loopback: then the gateway uses TLS.
    pub tls: Option<TlsFiles>,
}
