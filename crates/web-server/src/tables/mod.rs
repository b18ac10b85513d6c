//! Tables that the files of a station and of an archive share, with their checks.
//!
//! | Module | Holds |
//! |---|---|
//! | [`archive`] | names, tokens and servers of NATS between stations and archives |
//! | `certificates` | certificates that are trusted in addition to those of the system |
//! | `credentials` | user and password in a file |
//! | [`openid`] | `[openid]` |
//! | `secret` | tokens and passwords |

pub mod archive;
mod certificates;
mod credentials;
pub mod openid;
mod secret;

pub use certificates::{CertificateError, ca_certificates, ca_file};
pub use credentials::{Credentials, CredentialsProblem, credentials_file};
pub use openid::OpenIdProblem;
pub use secret::{Secret, password_of_file, private_file, secret_of_file, token_of};

use crate::auth::file_permissions::PermissionError;
use archive::NatsProblem;
use std::io;
use std::ops::Range;
use std::path::PathBuf;

/// A problem and the octets of the file that cause it.
#[derive(Debug)]
pub struct Located {
    /// The octets.
    pub span: Range<usize>,
    /// The problem.
    pub problem: TableProblem,
}

impl Located {
    /// A problem at these octets.
    #[must_use]
    pub const fn new(span: Range<usize>, problem: TableProblem) -> Self {
        Self { span, problem }
    }
}

/// Why a value of a table cannot be used.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum TableProblem {
    /// A value of `[openid]`.
    #[error(transparent)]
    OpenId(OpenIdProblem),
    /// The servers of NATS cannot be used.
    #[error(transparent)]
    Nats(NatsProblem),
    /// The file with user and password for a broker or server cannot be used.
    #[error(transparent)]
    Credentials(CredentialsProblem),
    /// The certificates cannot be read.
    #[error(transparent)]
    Certificates(CertificateError),
    /// A token contains characters that HTTP does not permit. The token is a secret and is not repeated.
    #[error("expected a token of visible ASCII characters without spaces")]
    Token,
    /// A password cannot be sent. It is a secret and is not repeated.
    #[error("expected a password in one line, without control characters")]
    Password,
    /// The file of a token or password is open to others.
    #[error(transparent)]
    SecretFileOpen(PermissionError),
    /// The file of a token or password cannot be read.
    #[error("{file} cannot be read: {error}", file = file.display())]
    SecretFile {
        /// The file.
        file: PathBuf,
        /// The error of the operating system.
        error: io::Error,
    },
}
