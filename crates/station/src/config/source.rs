//! The file that a configuration was read from.

use super::Config;
use std::fmt;
use std::path::{Path, PathBuf};

/// Parses the text of a file at a path; the error is a sentence.
pub type Parse = fn(&str, &Path) -> Result<Config, String>;

/// The path and the text of a configuration file, as the station has read it. The text may hold secrets and is not shown.
#[derive(Clone, Default)]
pub struct ConfigSource {
    path: PathBuf,
    text: String,
    /// `None` without a file.
    parse: Option<Parse>,
}

/// Equal files have the same path and text.
impl PartialEq for ConfigSource {
    fn eq(&self, other: &Self) -> bool {
        (&self.path, &self.text) == (&other.path, &other.text)
    }
}

impl ConfigSource {
    /// The file at `path` with this text. The station edits the text, and `parse` checks it then.
    #[must_use]
    pub fn new(path: &Path, text: &str, parse: Parse) -> Self {
        Self { path: path.to_owned(), text: text.to_owned(), parse: Some(parse) }
    }

    /// The path.
    #[must_use]
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// The configuration of an edited text of this file; `None` without a file.
    #[must_use]
    pub fn parse(&self, text: &str) -> Option<Result<Config, String>> {
        self.parse.map(|parse| parse(text, &self.path))
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
