//! Certificates that are trusted for webhooks, brokers and archives in addition to those of the system.

use super::{Located, TableProblem};
use std::path::{Path, PathBuf};
use tokio_rustls::rustls::pki_types::CertificateDer;
use tokio_rustls::rustls::pki_types::pem::{self, PemObject};
use toml::Spanned;

/// A file without usable certificates.
#[derive(Debug, thiserror::Error)]
#[error("{}", sentence(.file, .error))]
pub struct CertificateError {
    /// The file.
    pub file: PathBuf,
    /// The error of the PEM parser.
    pub error: pem::Error,
}

fn sentence(file: &Path, error: &pem::Error) -> String {
    let file = file.display();
    match error {
        pem::Error::Io(error) => format!("{file} cannot be read: {error}"),
        pem::Error::NoItemsFound => format!("{file} holds no certificates: expected at least one in PEM"),
        other => format!("{file} holds no certificates: {other}"),
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

/// The path of a file with certificates, which can be read now.
///
/// # Errors
/// [`TableProblem::Certificates`].
pub fn ca_file(file: &Spanned<PathBuf>, folder: &Path) -> Result<PathBuf, Located> {
    let path = folder.join(file.get_ref());
    let wrong = |error| Located::new(file.span(), TableProblem::Certificates(error));
    ca_certificates(&path).map_err(wrong).map(|_| path)
}
