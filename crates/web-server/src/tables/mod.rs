//! Tables that the files of a station and of an archive share, with their checks.
//!
//! | Module | Holds |
//! |---|---|
//! | `certificates` | certificates that are trusted in addition to those of the system |
//! | [`openid`] | `[openid]` |
//! | `secret` | tokens and passwords |

mod certificates;
pub mod openid;
mod secret;

pub use certificates::{CertificateError, ca_certificates};
pub use openid::OpenIdProblem;
pub use secret::{Secret, password_of_file, secret_of_file, token_of};

use crate::auth::file_permissions::PermissionError;
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
