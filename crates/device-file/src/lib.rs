//! Devices described in a file: a TOML file of a manual's tables becomes the same [`Model`] that the compiled devices have, and
//! [`show`] writes any model as such a file.
//!
//! [`DeviceFile::read`] checks a file completely and keeps nothing; [`DeviceFile::model`] makes the model, once for each content: a
//! program that loads a file again gets the model that it has.
//!
//! ```
//! use profivac_device_file::DeviceFile;
//!
//! let file = DeviceFile::parse(
//!     r#"
//!     format = 1
//!     name = "bpg402"
//!     title = "BPG402-SP"
//!     like = "bcg450"
//!     ident = 0x1234
//!     "#,
//! )?;
//! let model = file.model()?;
//! assert_eq!((model.title, model.ident), ("BPG402-SP", 0x1234));
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
#![warn(missing_docs)]

mod check;
mod conditions;
mod device;
mod error;
mod intern;
mod library;
mod like;
mod schema;
mod show;
mod toml_file;
mod words;

pub use error::DeviceFileError;
pub use intern::{MAX_MODELS, TooManyModels, built_in_like, description, left_out, of_models};
pub use library::{is_device_file, known_devices, usual_files};
pub use schema::SCHEMA;
pub use show::show;
pub use toml_file::FORMAT;

use device::Device;
use like::Chain;
use profivac_devices::model::Model;
use profivac_host::text_file;
use std::path::{Path, PathBuf};

/// The largest device file, in octets.
pub const MAX_OCTETS: u64 = 1 << 20;

/// A device file whose tables are complete and free of contradictions.
#[derive(Debug)]
pub struct DeviceFile {
    device: Device,
    parents: Vec<String>,
    texts: String,
}

impl DeviceFile {
    /// Reads and checks a file of at most 1 MiB, with the files that it is like.
    ///
    /// # Errors
    /// The position in the file, what was expected, what was found, and what to do.
    pub fn read(path: &Path) -> Result<Self, DeviceFileError> {
        let label = path.display().to_string();
        let (own, text) = read(path).map_err(|text| DeviceFileError { file: label.clone(), position: None, text })?;
        Self::of(&label, Some(own), text, &read)
    }

    /// Checks the text of a file that is like no other file.
    ///
    /// # Errors
    /// As [`read`](Self::read).
    pub fn parse(text: &str) -> Result<Self, DeviceFileError> {
        let no_files =
            |_: &Path| Err("a text that is in no file can only be like a device that profivac has".to_owned());
        Self::of("device file", None, text.to_owned(), &no_files)
    }

    fn of(label: &str, path: Option<PathBuf>, text: String, read: like::ReadFile<'_>) -> Result<Self, DeviceFileError> {
        let mut chain = Chain::new(read);
        let device = chain.device(label, path, text)?;
        Ok(Self { device, parents: chain.parents().map(str::to_owned).collect(), texts: chain.texts() })
    }

    /// The name of the device.
    #[must_use]
    pub fn name(&self) -> &str {
        &self.device.name
    }

    /// Whether both have the same contents.
    fn is_same(&self, other: &Self) -> bool {
        self.texts == other.texts
    }

    /// The devices that this one is like, the nearest first.
    pub fn parents(&self) -> impl Iterator<Item = &str> {
        self.parents.iter().map(String::as_str)
    }

    /// The model. It lives as long as the program; the same content gives the same model.
    ///
    /// # Errors
    /// The program has loaded [`MAX_MODELS`] different contents.
    pub fn model(self) -> Result<&'static Model, TooManyModels> {
        intern::model(self.texts, self.device)
    }
}

/// The text of a file, and a path that is the same for every way to name it.
fn read(path: &Path) -> Result<(PathBuf, String), String> {
    let failed = |error: std::io::Error| format!("the file cannot be read: {error}");
    let own = path.canonicalize().map_err(failed)?;
    // Opening a pipe could wait for ever.
    if !own.is_file() {
        return Err("expected a file, found a folder or a device of the system; check the path".to_owned());
    }
    let text = text_file::read_at_most(&own, MAX_OCTETS).map_err(failed)?;
    Ok((own, text))
}
