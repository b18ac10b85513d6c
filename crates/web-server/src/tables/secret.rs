//! Tokens and passwords in files, which are never shown.

use super::{Located, TableProblem};
use crate::auth::file_permissions::{self, PermissionError};
use serde::de::Error;
use serde::{Deserialize, Deserializer};
use std::fmt;
use std::path::{Path, PathBuf};
use toml::Spanned;

/// A token or password that the station sends or expects, and never shows.
#[derive(Clone, PartialEq, Eq)]
pub struct Secret(String);

impl<'de> Deserialize<'de> for Secret {
    /// The error does not repeat the value: it may be the secret without its quotes.
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        String::deserialize(deserializer).map(Self).map_err(|_| D::Error::custom("expected a token in quotes"))
    }
}

impl Secret {
    /// The token itself, for the request to the webhook and the comparison with a request only.
    #[must_use]
    pub fn reveal(&self) -> &str {
        &self.0
    }
}

impl fmt::Debug for Secret {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        formatter.write_str("(secret)")
    }
}

/// A token in the file itself, which HTTP permits.
///
/// # Errors
/// [`TableProblem::Token`].
pub fn token_of(token: &Spanned<Secret>) -> Result<Secret, Located> {
    secret(token.get_ref().0.clone(), token.span())
}

fn secret(token: String, span: std::ops::Range<usize>) -> Result<Secret, Located> {
    let is_usable = !token.is_empty() && token.bytes().all(|octet| octet.is_ascii_graphic());
    if is_usable { Ok(Secret(token)) } else { Err(Located::new(span, TableProblem::Token)) }
}

/// The token in a file, which only its owner may read.
///
/// # Errors
/// [`TableProblem`] with the position of the name of the file.
pub fn secret_of_file(file: &Spanned<PathBuf>, folder: &Path) -> Result<Secret, Located> {
    secret(token_of_file(file, folder)?, file.span())
}

/// The password in a file, which only its owner may read.
///
/// # Errors
/// As [`secret_of_file`].
pub fn password_of_file(file: &Spanned<PathBuf>, folder: &Path) -> Result<Secret, Located> {
    let password = token_of_file(file, folder)?;
    let is_usable = !password.is_empty() && !password.chars().any(char::is_control);
    if is_usable { Ok(Secret(password)) } else { Err(Located::new(file.span(), TableProblem::Password)) }
}

fn token_of_file(file: &Spanned<PathBuf>, folder: &Path) -> Result<String, Located> {
    let path = folder.join(file.get_ref());
    match file_permissions::check(&path) {
        Err(error @ PermissionError::Open(..)) => {
            return Err(Located::new(file.span(), TableProblem::SecretFileOpen(error)));
        }
        // The read below reports why the file cannot be read.
        Ok(()) | Err(PermissionError::System(..)) => {}
    }
    let text = std::fs::read_to_string(&path);
    let text = text.map_err(|error| Located::new(file.span(), TableProblem::SecretFile { file: path, error }))?;
    Ok(text.trim().to_owned())
}

/// The path of a file that only its owner can read.
///
/// # Errors
/// [`PermissionError`] if others have access to it.
pub fn private_file(file: &Spanned<PathBuf>, folder: &Path) -> Result<PathBuf, PermissionError> {
    let path = folder.join(file.get_ref());
    match file_permissions::check(&path) {
        Err(error @ PermissionError::Open(..)) => Err(error),
        // Reading reports why the file cannot be read.
        Ok(()) | Err(_) => Ok(path),
    }
}
