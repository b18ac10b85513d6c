//! Certificates that a webhook trusts in addition to those of the system.

use std::path::{Path, PathBuf};
use tokio_rustls::rustls::pki_types::CertificateDer;
use tokio_rustls::rustls::pki_types::pem::{self, PemObject};

/// A file without usable certificates.
#[derive(Debug, thiserror::Error)]
#[error("{file} holds no certificates: {}", pem_problem(.error), file = file.display())]
pub struct CertificateError {
    /// The file.
    pub file: PathBuf,
    /// The error of the PEM parser.
    pub error: pem::Error,
}

fn pem_problem(error: &pem::Error) -> String {
    match error {
        pem::Error::NoItemsFound => "expected at least one in PEM".to_owned(),
        other => other.to_string(),
    }
}

/// Reads the certificates of a PEM file.
///
/// # Errors
/// [`CertificateError`] when the file cannot be read, is not PEM or holds no certificate.
pub fn ca_certificates(file: &Path) -> Result<Vec<CertificateDer<'static>>, CertificateError> {
    let failed = |error| CertificateError { file: file.to_owned(), error };
    let all = CertificateDer::pem_file_iter(file).and_then(Iterator::collect::<Result<Vec<_>, _>>).map_err(failed)?;
    if all.is_empty() { Err(failed(pem::Error::NoItemsFound)) } else { Ok(all) }
}
