//! Parses a settings file and fits it to a gauge.

use super::is_setting;
use crate::gauge::Gauge;
use crate::names::{NamedParameter, Target, TargetError};
use crate::records::Records;
use profivac_devices::model::{Codes, DataType, Role};
use profivac_host::text_file::line_and_column;
use serde::Deserialize;
use std::collections::BTreeMap;
use toml::Spanned;

/// A parsed settings file.
#[derive(Debug)]
pub struct SettingsFile {
    /// The device.
    pub device: String,
    /// Ident_Number.
    pub ident: u16,
    /// The settings.
    pub settings: Vec<Setting>,
    /// The settings of the gauge that the file does not hold, because its integers showed only a bound of them.
    pub left_out: Vec<String>,
}

/// One line of a file.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Setting {
    /// The parameter.
    pub name: String,
    /// The value as text.
    pub value: String,
    /// Line and column of the value, from 1.
    pub at: (usize, usize),
}

/// The reason why a file cannot be used, or not for this gauge.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum SettingsFileError {
    /// The file is no TOML, or has other keys.
    #[error("line {line}, column {column}: {message}")]
    Syntax {
        /// From 1.
        line: usize,
        /// From 1.
        column: usize,
        /// The message of the TOML parser.
        message: String,
    },
    /// The gauge has no parameter of this name.
    #[error("line {line}, column {column}: {error}")]
    UnknownParameter {
        /// From 1.
        line: usize,
        /// From 1.
        column: usize,
        /// The error of the search.
        error: TargetError,
    },
    /// The parameter is no setting.
    #[error("line {line}, column {column}: {name} is no setting of {device}")]
    NoSetting {
        /// From 1.
        line: usize,
        /// From 1.
        column: usize,
        /// The name in the file.
        name: String,
        /// The device.
        device: &'static str,
    },
    /// The file belongs to another model.
    #[error(
        "the file is of {file_device} with the ident number 0x{file_ident:04X}, the gauge is {device} with 0x{ident:04X}"
    )]
    Device {
        /// The device of the file.
        file_device: String,
        /// The Ident_Number of the file.
        file_ident: u16,
        /// The device on the bus.
        device: &'static str,
        /// Its Ident_Number.
        ident: u16,
    },
    /// The file belongs to another device with the same Ident_Number.
    #[error(
        "the file is of {file_device}, the gauge is {device}; if it replaces the other device, write device = \"{device}\" in the file"
    )]
    OtherVariant {
        /// The device of the file.
        file_device: String,
        /// The device on the bus.
        device: &'static str,
    },
}

/// The file as serde reads it.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Raw {
    device: String,
    ident: u16,
    #[serde(default, rename = "left-out")]
    left_out: Vec<String>,
    #[serde(default)]
    settings: BTreeMap<String, Spanned<String>>,
    #[serde(default)]
    #[expect(dead_code, reason = "for people")]
    readings: BTreeMap<String, String>,
}

impl SettingsFile {
    /// Parses a file.
    ///
    /// ```
    /// use profivac_client::settings::SettingsFile;
    ///
    /// let file = SettingsFile::parse("device = 'bcg450'\nident = 0x08E6\n[settings]\n'pirani.safe-state' = 'zero'")?;
    /// assert_eq!((file.device.as_str(), file.settings.len()), ("bcg450", 1));
    /// let error = SettingsFile::parse("device = bcg450").unwrap_err().to_string();
    /// assert!(error.starts_with("line 1, column 10: "), "{error}");
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    ///
    /// # Errors
    /// [`SettingsFileError::Syntax`] with line and column.
    pub fn parse(text: &str) -> Result<Self, SettingsFileError> {
        let raw: Raw = toml::from_str(text).map_err(|error| {
            let (line, column) = line_and_column(text, error.span().map_or(0, |span| span.start));
            SettingsFileError::Syntax { line, column, message: error.message().trim_end().replace('\n', ", ") }
        })?;
        let setting = |(name, value): (String, Spanned<String>)| {
            let at = line_and_column(text, value.span().start);
            Setting { name, value: value.into_inner(), at }
        };
        let Raw { device, ident, left_out, .. } = raw;
        Ok(Self { device, ident, settings: raw.settings.into_iter().map(setting).collect(), left_out })
    }

    /// Checks that the file belongs to the model of this gauge.
    ///
    /// # Errors
    /// [`SettingsFileError::Device`], [`SettingsFileError::OtherVariant`].
    pub fn check<R: Records>(&self, gauge: &Gauge<R>) -> Result<(), SettingsFileError> {
        let (device, ident) = (gauge.model().name, gauge.model().ident);
        let file_device = self.device.clone();
        match (ident == self.ident, device.eq_ignore_ascii_case(&file_device)) {
            (true, true) => Ok(()),
            (true, false) => Err(SettingsFileError::OtherVariant { file_device, device }),
            (false, _) => Err(SettingsFileError::Device { file_device, file_ident: self.ident, device, ident }),
        }
    }

    /// The settings in the order of writing: unit and number type first, then modes, then numbers, and enabling Booleans
    /// last.
    ///
    /// # Errors
    /// [`SettingsFileError`] at the first setting that the gauge does not have. Sends nothing.
    pub fn in_order<R: Records>(&self, gauge: &Gauge<R>) -> Result<Vec<(NamedParameter, Setting)>, SettingsFileError> {
        let names = gauge.names();
        let mut found = Vec::new();
        for setting in &self.settings {
            let (line, column) = setting.at;
            let device = gauge.model().name;
            match names.find_whole(device, &setting.name) {
                Ok(Target::Parameter(named)) if is_setting(named) => found.push((named.clone(), setting.clone())),
                Ok(_) => {
                    let name = setting.name.clone();
                    return Err(SettingsFileError::NoSetting { line, column, name, device });
                }
                Err(error) => return Err(SettingsFileError::UnknownParameter { line, column, error }),
            }
        }
        found.sort_by_key(|(named, _)| {
            let location = named.parameter.location;
            (write_rank(named), location.slot, location.instance, named.parameter.row.index)
        });
        Ok(found)
    }
}

/// The rank of a setting in the order of writing.
fn write_rank(named: &NamedParameter) -> u8 {
    let row = named.parameter.row;
    match (&row.codes, row.data_type) {
        _ if row.role == Some(Role::Unit) => 0,
        _ if row.role == Some(Role::NumberType) => 1,
        (Codes::Names(_) | Codes::Range(..) | Codes::PerMille(..), _) => 2,
        (_, DataType::Boolean) => 4,
        _ => 3,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const FILE: &str = "device = \"bcg450\"\nident = 0x08E6\n\n[settings]\n\"pirani.safe-state\" = \"zero\"\n";

    #[test]
    fn a_file_is_parsed_into_settings_with_their_positions() {
        let file = SettingsFile::parse(FILE).unwrap();
        assert_eq!((file.device.as_str(), file.ident), ("bcg450", 0x08E6));
        let at = (5, 23);
        assert_eq!(file.settings, [Setting { name: "pirani.safe-state".to_owned(), value: "zero".to_owned(), at }]);
    }

    #[test]
    fn an_invalid_file_is_an_error_with_line_and_column() {
        for (text, location) in [
            (FILE.replace("zero\"", "zero"), "line 5, column "),
            (FILE.replace("\"zero\"", "3"), "line 5, column 23: "),
            (FILE.replace("ident", "idend"), "line 2, column 1: "),
            (FILE.replace("0x08E6", "0x108E6"), "line 2, column 9: "),
            (FILE.replace("device = \"bcg450\"\n", ""), "line "),
        ] {
            let error = SettingsFile::parse(&text).unwrap_err().to_string();
            assert!(error.starts_with(location) && !error.contains('\n'), "{error:?} instead of {location}");
        }
    }
}
