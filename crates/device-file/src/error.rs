//! Errors in a device file, with their positions.

use std::fmt;
use std::ops::Range;

/// An error in a device file.
#[derive(Debug)]
pub struct DeviceFileError {
    /// The file as the user named it.
    pub file: String,
    /// Line and column, from 1; none if the file cannot be read.
    pub position: Option<(usize, usize)>,
    /// What was expected, what was found, what to do.
    pub text: String,
}

impl fmt::Display for DeviceFileError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { file, position, text } = self;
        match position {
            Some((line, column)) => write!(f, "{file}:{line}:{column}: {text}"),
            None => write!(f, "{file}: {text}"),
        }
    }
}

impl std::error::Error for DeviceFileError {}

/// A problem and the octets that cause it, in the texts of a file and of the devices that it is like, one after the other.
#[derive(Debug)]
pub struct Located {
    pub span: Range<usize>,
    pub text: String,
}

/// A problem at `span`.
pub fn problem<T>(span: Range<usize>, text: impl Into<String>) -> Result<T, Located> {
    Err(Located { span, text: text.into() })
}
