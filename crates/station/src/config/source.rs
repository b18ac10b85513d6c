//! The file that a configuration was read from.

use std::fmt;
use std::path::{Path, PathBuf};

/// The path and the text of a configuration file, as the station has read it. The text may hold secrets and is not shown.
#[derive(Clone, Default, PartialEq, Eq)]
pub struct ConfigSource {
    path: PathBuf,
    text: String,
}

impl ConfigSource {
    /// The file at `path` with this text.
    #[must_use]
    pub fn new(path: &Path, text: &str) -> Self {
        Self { path: path.to_owned(), text: text.to_owned() }
    }

    /// The path.
    #[must_use]
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// The text when the station read it.
    #[must_use]
    pub fn text(&self) -> &str {
        &self.text
    }
}

impl fmt::Debug for ConfigSource {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        formatter.debug_struct("ConfigSource").field("path", &self.path).finish_non_exhaustive()
    }
}
