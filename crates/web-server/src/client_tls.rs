//! TLS to servers of others: brokers, webhooks, databases.

use std::error::Error as StdError;
use std::sync::Arc;
use tokio_rustls::rustls::client::WantsClientCert;
use tokio_rustls::rustls::pki_types::CertificateDer;
use tokio_rustls::rustls::{CertificateError, ClientConfig, ConfigBuilder, Error, RootCertStore, crypto};

/// A configuration that trusts the certificates of the system and those in `trusted`. A certificate of the system that cannot be read
/// is not trusted.
///
/// # Errors
/// When the library offers no protocol version.
pub fn trusting(trusted: Vec<CertificateDer<'static>>) -> Result<ConfigBuilder<ClientConfig, WantsClientCert>, Error> {
    let mut roots = RootCertStore::empty();
    let system = rustls_native_certs::load_native_certs().certs;
    roots.add_parsable_certificates(system.into_iter().chain(trusted));
    let provider = Arc::new(crypto::ring::default_provider());
    let config = ClientConfig::builder_with_provider(provider).with_safe_default_protocol_versions()?;
    Ok(config.with_root_certificates(roots))
}

/// What TLS found wrong, if that is the cause of an error of a connection.
#[must_use]
pub fn fault<'a>(error: &'a (dyn StdError + 'static)) -> Option<&'a Error> {
    let mut cause = Some(error);
    while let Some(error) = cause {
        // An error of the system does not name the one that it holds as its source.
        let held = error.downcast_ref::<std::io::Error>().and_then(std::io::Error::get_ref);
        let found = error.downcast_ref().or_else(|| held.and_then(|held| held.downcast_ref()));
        if found.is_some() {
            return found;
        }
        cause = error.source();
    }
    None
}

/// Whether the certificate of the server is that of another name.
#[must_use]
pub const fn is_of_another_name(fault: &Error) -> bool {
    matches!(
        fault,
        Error::InvalidCertificate(CertificateError::NotValidForName | CertificateError::NotValidForNameContext { .. })
    )
}
