//! TLS: certificate and key, which can be read again while the server runs.

use super::http2;
use crate::auth::file_permissions::{self, PermissionError};
use std::fmt;
use std::path::{Path, PathBuf};
use std::sync::{Arc, PoisonError, RwLock};
use tokio_rustls::rustls::crypto::ring::default_provider;
use tokio_rustls::rustls::pki_types::pem::{self, PemObject};
use tokio_rustls::rustls::pki_types::{CertificateDer, PrivateKeyDer};
use tokio_rustls::rustls::{self, ServerConfig};

/// The paths of certificate and key, both in PEM.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct TlsFiles {
    /// The certificate of the station, followed by its intermediate certificates.
    pub certificate: PathBuf,
    /// The key of the certificate. Only its owner may have access to the file.
    pub key: PathBuf,
}

/// The contents that a PEM file must have.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum PemItem {
    /// At least one certificate.
    Certificate,
    /// A private key.
    Key,
}

impl fmt::Display for PemItem {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        formatter.write_str(match self {
            Self::Certificate => "a certificate",
            Self::Key => "a key",
        })
    }
}

/// Why TLS cannot be used.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum TlsError {
    /// Others have access to the key.
    #[error(transparent)]
    Private(#[from] PermissionError),
    /// A file has no certificate or key. Its contents are never repeated.
    #[error("{file}: expected {expected} in PEM, found {}", pem_problem(.error), file = file.display())]
    Pem {
        /// The file.
        file: PathBuf,
        /// The item that the file must contain.
        expected: PemItem,
        /// The error of the PEM parser.
        error: pem::Error,
    },
    /// The key does not belong to the certificate, or its algorithm is not supported.
    #[error("{certificate} and {key} cannot be used together: {error}", certificate = files.certificate.display(), key = files.key.display())]
    Pair {
        /// Both files.
        files: TlsFiles,
        /// The error of the TLS library.
        error: rustls::Error,
    },
}

/// Certificate and key in use.
pub struct Keys {
    files: TlsFiles,
    config: RwLock<Arc<ServerConfig>>,
}

impl Keys {
    /// Reads certificate and key.
    ///
    /// # Errors
    /// [`TlsError`].
    pub fn read(files: TlsFiles) -> Result<Self, TlsError> {
        let config = RwLock::new(Arc::new(config(&files)?));
        Ok(Self { files, config })
    }

    /// Reads certificate and key again for new connections. Open connections keep theirs.
    ///
    /// # Errors
    /// [`TlsError`]. The former certificate and key stay in use then.
    pub fn renew(&self) -> Result<(), TlsError> {
        let new = Arc::new(config(&self.files)?);
        *self.config.write().unwrap_or_else(PoisonError::into_inner) = new;
        Ok(())
    }

    /// The TLS configuration for a new connection.
    #[must_use]
    pub fn config(&self) -> Arc<ServerConfig> {
        Arc::clone(&self.config.read().unwrap_or_else(PoisonError::into_inner))
    }
}

fn config(files: &TlsFiles) -> Result<ServerConfig, TlsError> {
    file_permissions::check(&files.key)?;
    let pem = |file: &Path, expected| {
        let file = file.to_owned();
        move |error| TlsError::Pem { file, expected, error }
    };
    let certificates = CertificateDer::pem_file_iter(&files.certificate)
        .and_then(Iterator::collect::<Result<Vec<_>, _>>)
        .and_then(|all| if all.is_empty() { Err(pem::Error::NoItemsFound) } else { Ok(all) })
        .map_err(pem(&files.certificate, PemItem::Certificate))?;
    let key = PrivateKeyDer::from_pem_file(&files.key).map_err(pem(&files.key, PemItem::Key))?;
    let pair = |error| TlsError::Pair { files: files.clone(), error };
    let mut config = ServerConfig::builder_with_provider(Arc::new(default_provider()))
        .with_safe_default_protocol_versions()
        .map_err(pair)?
        .with_no_client_auth()
        .with_single_cert(certificates, key)
        .map_err(pair)?;
    config.alpn_protocols = vec![http2::PROTOCOL.to_vec(), b"http/1.1".to_vec()];
    Ok(config)
}

/// The error of the PEM parser without the parts that could repeat the contents of the file.
fn pem_problem(error: &pem::Error) -> String {
    match error {
        pem::Error::NoItemsFound => "none".to_owned(),
        pem::Error::Io(error) => error.to_string(),
        _ => "damaged data".to_owned(),
    }
}
