//! TLS: certificate and key, read again when they are renewed.

use crate::auth::file_permissions::{self, PermissionError};
use std::path::{Path, PathBuf};
use std::sync::{Arc, PoisonError, RwLock};
use tokio_rustls::rustls::crypto::ring::default_provider;
use tokio_rustls::rustls::pki_types::pem::{self, PemObject};
use tokio_rustls::rustls::pki_types::{CertificateDer, PrivateKeyDer};
use tokio_rustls::rustls::{self, ServerConfig};

/// Where certificate and key are, as PEM.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct TlsFiles {
    /// Our certificate, and behind it those that vouch for it.
    pub certificate: PathBuf,
    /// Its key, which only its owner may read.
    pub key: PathBuf,
}

/// Why there is no TLS.
#[derive(Debug, thiserror::Error)]
pub enum TlsError {
    /// Others may read the key.
    #[error(transparent)]
    Private(#[from] PermissionError),
    /// What stands in a file, which is never repeated.
    #[error("{file}: expected {what} as PEM: {error}", file = file.display())]
    Pem {
        /// The file.
        file: PathBuf,
        /// What should stand there.
        what: &'static str,
        /// What is wrong.
        error: String,
    },
    /// They do not belong together, or cannot be used.
    #[error("{certificate} and {key} cannot be used together: {error}", certificate = files.certificate.display(), key = files.key.display())]
    Pair {
        /// Both.
        files: TlsFiles,
        /// What is wrong.
        error: rustls::Error,
    },
}

/// Certificate and key as they were read last.
pub struct Keys {
    files: TlsFiles,
    config: RwLock<Arc<ServerConfig>>,
}

impl Keys {
    /// Reads both.
    ///
    /// # Errors
    /// [`TlsError`].
    pub fn read(files: TlsFiles) -> Result<Self, TlsError> {
        let config = RwLock::new(Arc::new(config(&files)?));
        Ok(Self { files, config })
    }

    /// Reads both again; connections that are there go on.
    ///
    /// # Errors
    /// [`TlsError`]; what was read before still holds then.
    pub fn renew(&self) -> Result<(), TlsError> {
        let new = Arc::new(config(&self.files)?);
        *self.config.write().unwrap_or_else(PoisonError::into_inner) = new;
        Ok(())
    }

    /// What the next connection is made with.
    #[must_use]
    pub fn config(&self) -> Arc<ServerConfig> {
        Arc::clone(&self.config.read().unwrap_or_else(PoisonError::into_inner))
    }
}

fn config(files: &TlsFiles) -> Result<ServerConfig, TlsError> {
    file_permissions::check(&files.key)?;
    let certificates = CertificateDer::pem_file_iter(&files.certificate)
        .and_then(Iterator::collect::<Result<Vec<_>, _>>)
        .and_then(|all| if all.is_empty() { Err(pem::Error::NoItemsFound) } else { Ok(all) })
        .map_err(|error| unreadable(&files.certificate, "a certificate", &error))?;
    let key = PrivateKeyDer::from_pem_file(&files.key).map_err(|error| unreadable(&files.key, "a key", &error))?;
    let pair = |error| TlsError::Pair { files: files.clone(), error };
    let mut config = ServerConfig::builder_with_provider(Arc::new(default_provider()))
        .with_safe_default_protocol_versions()
        .map_err(pair)?
        .with_no_client_auth()
        .with_single_cert(certificates, key)
        .map_err(pair)?;
    config.alpn_protocols = vec![b"http/1.1".to_vec()];
    Ok(config)
}

fn unreadable(file: &Path, what: &'static str, error: &pem::Error) -> TlsError {
    let error = match error {
        pem::Error::NoItemsFound => "there is none".to_owned(),
        pem::Error::Io(error) => error.to_string(),
        // Others may repeat what they found.
        _ => "it is damaged".to_owned(),
    };
    TlsError::Pem { file: file.to_owned(), what, error }
}
