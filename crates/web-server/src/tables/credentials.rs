//! User and password for a server of others, in a file that only its owner can read.

use super::{Located, Secret, TableProblem, private_file};
use crate::auth::file_permissions::PermissionError;
use profivac_host::text_file;
use serde::Deserialize;
use std::io;
use std::path::{Path, PathBuf};
use toml::Spanned;

/// The login of the station at the broker.
#[derive(Clone, Debug, PartialEq, Eq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Credentials {
    /// The user.
    pub user: String,
    /// The password.
    pub password: Secret,
}

/// The reason why a file with user and password cannot be used.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum CredentialsProblem {
    /// The file is not TOML of that form.
    #[error("expected user = \"…\" and password = \"…\" in {file}: {message}", file = file.display())]
    Content {
        /// The file.
        file: PathBuf,
        /// The message of the parser.
        message: String,
    },
    /// The file cannot be read.
    #[error("{file} cannot be read: {error}", file = file.display())]
    File {
        /// The file.
        file: PathBuf,
        /// The error of the operating system.
        error: io::Error,
    },
    /// The file is open to others.
    #[error(transparent)]
    Open(PermissionError),
}

/// User and password in a file that only its owner can read.
///
/// # Errors
/// [`CredentialsProblem`] with the position of the name of the file.
pub fn credentials_file(file: &Spanned<PathBuf>, folder: &Path) -> Result<Credentials, Located> {
    let wrong = |problem| Located::new(file.span(), TableProblem::Credentials(problem));
    let path = private_file(file, folder).map_err(|error| wrong(CredentialsProblem::Open(error)))?;
    let text = text_file::read(&path);
    let text = text.map_err(|error| wrong(CredentialsProblem::File { file: path.clone(), error }))?;
    // The message of the parser has no part of the file.
    let parsed = toml::from_str(&text).map_err(|error| error.message().to_owned());
    parsed.map_err(|message| wrong(CredentialsProblem::Content { file: path, message }))
}
