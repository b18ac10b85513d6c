//! `[prometheus]`.

use super::super::error::{ConfigProblem, Located};
use crate::time_span::Listen;
use profivac_host::text_file::Parsed;
use profivac_station::config::gateways::prometheus::Settings;
use profivac_web_server::server::TlsFiles;
use profivac_web_server::tables::secret_of_file;
use serde::Deserialize;
use std::net::Ipv4Addr;
use std::path::{Path, PathBuf};
use toml::Spanned;

/// The default of `listen`: loopback, port 9464.
const LISTEN: (Ipv4Addr, u16) = (Ipv4Addr::LOCALHOST, 9464);

/// `[prometheus]` as TOML.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields, rename_all = "kebab-case")]
pub struct PrometheusToml {
    /// The address. Default: `127.0.0.1:9464`.
    listen: Option<Spanned<Parsed<Listen>>>,
    /// The file with the bearer token of a scrape, which only its owner may read; needed beyond loopback.
    token_file: Option<Spanned<PathBuf>>,
}

impl PrometheusToml {
    /// The settings, with the defaults of the keys that are absent. Other computers need the certificate of the station and a token:
    /// nothing is readable without a login from there.
    pub fn into_settings(self, path: &Path, tls: Option<&TlsFiles>) -> Result<Settings, Located> {
        let folder = path.parent().unwrap_or(Path::new(""));
        let token = self.token_file.map(|file| secret_of_file(&file, folder)).transpose()?;
        let Some(listen) = self.listen else { return Ok(Settings { listen: LISTEN.into(), token, tls: None }) };
        let (span, listen) = (listen.span(), listen.into_inner().0.0);
        let exposed =
            |needs| Err(Located::new(span, ConfigProblem::GatewayExposed { gateway: "prometheus", listen, needs }));
        match (listen.ip().is_loopback(), tls, &token) {
            (true, _, _) => Ok(Settings { listen, token, tls: None }),
            (false, None, _) => exposed("[tls] with certificate and key"),
            (false, Some(_), None) => exposed("token-file, a file with the bearer token of the scrapes"),
            (false, Some(tls), Some(_)) => Ok(Settings { listen, token, tls: Some(tls.clone()) }),
        }
    }
}
