//! The settings of a gauge in a file: what is kept without power and can be written, to be compared with another gauge and to
//! be written to its replacement.
//!
//! The file is TOML. `[settings]` is what [`restore`] writes; `[readings]` is what else was read, for people.

use super::error::{ClientError, ErrorKind};
use super::gauge::{Gauge, ParameterReading, PreparedWrite};
use super::names::{NamedParameter, Target, TargetError};
use super::records::{Records, Unavailable};
use profivac_devices::model::{Access, Codes, DataType, Direction};
use serde::Deserialize;
use std::collections::BTreeMap;
use std::fmt::Write;
use toml::Spanned;

/// The values of the parameter that opens and closes a set.
const OPEN: &str = "open-for-changes";
const CLOSED: &str = "valid";

/// What was read of a gauge.
#[derive(Debug)]
pub struct Dump {
    /// The device.
    pub device: &'static str,
    /// Ident_Number.
    pub ident: u16,
    /// Every readable parameter, or why it could not be read.
    pub readings: Vec<ReadResult>,
}

/// A file that was read.
#[derive(Debug)]
pub struct SettingsFile {
    /// The device.
    pub device: String,
    /// Ident_Number.
    pub ident: u16,
    /// Names, values, and where the value stands.
    pub settings: Vec<Setting>,
}

/// One line of a file.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Setting {
    /// The parameter.
    pub name: String,
    /// Its value in words.
    pub value: String,
    /// Line and column of the value, from 1.
    pub at: (usize, usize),
}

/// Why a file is none, or none for this gauge.
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
    /// It is of another kind of device.
    #[error(
        "the file is of {file_device} with the ident number 0x{file_ident:04X}, the gauge is {device} with 0x{ident:04X}"
    )]
    Device {
        /// The device of the file.
        file_device: String,
        /// The ident number of the file.
        file_ident: u16,
        /// The device on the bus.
        device: &'static str,
        /// Its ident number.
        ident: u16,
    },
}

/// A setting that is not what the file says.
#[derive(Debug)]
pub struct Difference {
    /// What would be written.
    pub write: PreparedWrite,
    /// What is there.
    pub current: ParameterReading,
}

/// What became of one setting.
#[derive(Debug)]
pub enum RestoreOutcome {
    /// It was another value, and is the one of the file now.
    Written {
        /// The parameter.
        name: String,
        /// What it was.
        before: String,
        /// What it is.
        after: String,
    },
    /// It is still another value.
    Refused(ClientError),
}

/// Whether a parameter is kept and can be written by request, and is a value.
#[must_use]
pub fn is_setting(named: &NamedParameter) -> bool {
    let row = named.parameter.row;
    row.is_stored()
        && row.access.intersects(Access::WRITE)
        && !row.codes.is_command()
        && row.name != crate::gauge::SELECTOR
}

/// Opens a set for changes.
///
/// # Errors
/// As [`Gauge::write`].
pub fn open_set<R: Records>(gauge: &mut Gauge<R>, lock: &NamedParameter) -> Result<(), ClientError> {
    let order = gauge.prepare(lock, OPEN)?;
    gauge.execute(order).map(|_| ())
}

/// Hands a set over: it holds from here on.
///
/// # Errors
/// As [`Gauge::write`]; most likely the parameters of the set contradict each other.
pub fn close_set<R: Records>(gauge: &mut Gauge<R>, lock: &NamedParameter) -> Result<(), ClientError> {
    let order = gauge.prepare(lock, CLOSED)?;
    gauge.execute(order).map(|_| ())
}

/// How often an instance is read when somebody else moves the selector meanwhile.
const ATTEMPTS: usize = 3;

/// What was read of a parameter, or why it could not be.
pub type ReadResult = (NamedParameter, Result<ParameterReading, ClientError>);

/// Reads what one instance has, and tells before each how many are done. That it was this instance is asked for once, at the
/// end.
fn dump_instance<R: Records>(
    gauge: &mut Gauge<R>,
    group: &[&NamedParameter],
    tell: &mut dyn FnMut(usize),
) -> Result<Vec<ReadResult>, ClientError> {
    let Some(last) = group.last() else { return Ok(Vec::new()) };
    for _ in 0..ATTEMPTS {
        let mut readings = Vec::new();
        for named in group {
            tell(readings.len());
            match gauge.read_once(named) {
                Err(error) if error.kind() == ErrorKind::Line => return Err(error),
                reading => readings.push(((*named).clone(), reading)),
            }
        }
        if gauge.is_still_selected(last)? {
            return Ok(readings);
        }
    }
    Err(gauge.selector_contention())
}

/// Reads everything that can be read.
///
/// # Errors
/// When the line is lost; what the gauge refuses is part of the result.
pub fn dump<R: Records>(gauge: &mut Gauge<R>) -> Result<Dump, ClientError> {
    dump_with_progress(gauge, |_, _| {})
}

/// The same, and tells on the way how many of all are done: on a slow line it takes long.
///
/// # Errors
/// As [`dump`].
pub fn dump_with_progress<R: Records>(
    gauge: &mut Gauge<R>,
    mut tell: impl FnMut(usize, usize),
) -> Result<Dump, ClientError> {
    let names = gauge.names();
    let via = gauge.records().via();
    let is_read = |named: &&NamedParameter| {
        let row = named.parameter.row;
        !row.codes.is_command() && row.access.allows(via, Direction::Read)
    };
    let wanted: Vec<_> = names.all().iter().filter(is_read).collect();
    let place = |named: &NamedParameter| (named.parameter.place.slot, named.parameter.place.instance);
    let mut readings = Vec::new();
    for group in wanted.chunk_by(|a, b| place(a) == place(b)) {
        let before = readings.len();
        readings.extend(dump_instance(gauge, group, &mut |done| tell(before + done, wanted.len()))?);
    }
    tell(readings.len(), wanted.len());
    if readings.is_empty() {
        return Err(gauge.unavailable(Unavailable::NothingReadable));
    }
    Ok(Dump { device: gauge.model().name, ident: gauge.model().ident, readings })
}

impl Dump {
    /// The file.
    #[must_use]
    pub fn to_toml(&self) -> String {
        let mut text = format!("device = \"{}\"\nident = 0x{:04X}\n", self.device, self.ident);
        for (heading, remark, is_wanted) in
            [("settings", "restore writes these", true), ("readings", "these are only for reading", false)]
        {
            writeln!(text, "\n# {remark}\n[{heading}]").ok();
            for (named, reading) in self.readings.iter().filter(|(named, _)| is_setting(named) == is_wanted) {
                match reading {
                    Ok(reading) => writeln!(text, "\"{}\" = {}", named.name, quoted(&reading.text)).ok(),
                    Err(error) => writeln!(text, "# {}: {error}", named.name).ok(),
                };
            }
        }
        text
    }
}

/// A TOML string.
fn quoted(text: &str) -> String {
    let mut quoted = String::from("\"");
    for letter in text.chars() {
        match letter {
            '"' | '\\' => quoted.extend(['\\', letter]),
            _ if letter.is_control() => {
                write!(quoted, "\\u{:04X}", u32::from(letter)).ok();
            }
            _ => quoted.push(letter),
        }
    }
    quoted + "\""
}

/// What serde makes of a file.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Raw {
    device: String,
    ident: u16,
    #[serde(default)]
    settings: BTreeMap<String, Spanned<String>>,
    #[serde(default)]
    #[expect(dead_code, reason = "for people")]
    readings: BTreeMap<String, String>,
}

impl SettingsFile {
    /// Reads the text of a file.
    ///
    /// # Errors
    /// [`FileError::Syntax`] with line and column.
    pub fn parse(text: &str) -> Result<Self, SettingsFileError> {
        let raw: Raw = toml::from_str(text).map_err(|error| {
            let (line, column) = position(text, error.span().map_or(0, |span| span.start));
            SettingsFileError::Syntax { line, column, message: error.message().trim_end().replace('\n', ", ") }
        })?;
        let setting = |(name, value): (String, Spanned<String>)| {
            let at = position(text, value.span().start);
            Setting { name, value: value.into_inner(), at }
        };
        Ok(Self { device: raw.device, ident: raw.ident, settings: raw.settings.into_iter().map(setting).collect() })
    }

    /// Whether it can be for this gauge.
    ///
    /// # Errors
    /// [`FileError::Device`] if not.
    pub fn check<R: Records>(&self, gauge: &Gauge<R>) -> Result<(), SettingsFileError> {
        let model = gauge.model();
        if model.ident == self.ident {
            return Ok(());
        }
        let (device, ident) = (model.name, model.ident);
        Err(SettingsFileError::Device { file_device: self.device.clone(), file_ident: self.ident, device, ident })
    }

    /// The settings in the order in which they are written: unit and number type, then what chooses how something works, then
    /// numbers, and what enables something last.
    ///
    /// # Errors
    /// [`FileError::Syntax`] at a setting this gauge does not have, before anything is asked.
    pub fn in_order<R: Records>(&self, gauge: &Gauge<R>) -> Result<Vec<(NamedParameter, Setting)>, SettingsFileError> {
        let names = gauge.names();
        let mut found = Vec::new();
        for setting in &self.settings {
            let (line, column) = setting.at;
            let device = gauge.model().name;
            match names.find(device, &setting.name) {
                Ok(Target::Parameter(named)) if is_setting(named) => found.push((named.clone(), setting.clone())),
                Ok(_) => {
                    let name = setting.name.clone();
                    return Err(SettingsFileError::NoSetting { line, column, name, device });
                }
                Err(error) => return Err(SettingsFileError::UnknownParameter { line, column, error }),
            }
        }
        found.sort_by_key(|(named, _)| {
            let place = named.parameter.place;
            (write_rank(named), place.slot, place.instance, named.parameter.row.index)
        });
        Ok(found)
    }
}

/// When a setting is written.
fn write_rank(named: &NamedParameter) -> u8 {
    let row = named.parameter.row;
    match (&row.codes, row.data_type) {
        (Codes::Units, _) => 0,
        _ if row.name == "Data Type" => 1,
        (Codes::Names(_) | Codes::Range(..), _) => 2,
        (_, DataType::Boolean) => 4,
        _ => 3,
    }
}

/// Line and column of an octet of a text, from 1.
fn position(text: &str, at: usize) -> (usize, usize) {
    let before = text.get(..at).unwrap_or(text);
    let line = before.matches('\n').count() + 1;
    let column = before.rsplit('\n').next().map_or(0, |last| last.chars().count()) + 1;
    (line, column)
}

/// The setting, if it is not what the file says.
///
/// # Errors
/// [`ClientError`] when it cannot be read, or cannot be written with such a value.
pub fn compare<R: Records>(
    gauge: &mut Gauge<R>,
    named: &NamedParameter,
    setting: &Setting,
) -> Result<Option<Difference>, ClientError> {
    let order = gauge.prepare(named, &setting.value)?;
    let now = match &order.before {
        Some(before) => before.clone(),
        None => gauge.read(named)?,
    };
    Ok((!is_same(named, &order.octets, &now.octets)).then_some(Difference { write: order, current: now }))
}

/// Whether two values are the same. A pressure that was converted between units may differ in its last digit.
fn is_same(named: &NamedParameter, a: &[u8], b: &[u8]) -> bool {
    let number = |octets: &[u8]| octets.try_into().ok().map(f32::from_be_bytes);
    match (named.parameter.row.data_type, number(a), number(b)) {
        (DataType::ByType | DataType::Float, Some(a), Some(b)) => (a - b).abs() <= 1e-6 * a.abs().max(b.abs()),
        _ => a == b,
    }
}

/// Writes one difference and looks whether it is there.
///
/// # Errors
/// [`ClientError`] as [`Gauge::carry_out`], and [`ClientError::Differs`].
pub fn restore<R: Records>(gauge: &mut Gauge<R>, difference: Difference) -> Result<RestoreOutcome, ClientError> {
    let (octets, text, named) =
        (difference.write.octets.clone(), difference.write.text.clone(), difference.write.named.clone());
    match gauge.execute(difference.write) {
        Ok(written) => {
            let after = written.after.as_ref().map_or_else(|| text.clone(), |after| after.text.clone());
            let is_there = written.after.as_ref().is_none_or(|after| is_same(&named, &octets, &after.octets));
            if is_there {
                return Ok(RestoreOutcome::Written { name: named.name, before: difference.current.text, after });
            }
            let place = gauge.context(&named);
            Ok(RestoreOutcome::Refused(ClientError::NotKept { place, written: text, found: after }))
        }
        Err(error) if error.kind() == ErrorKind::Line => Err(error),
        Err(error) => Ok(RestoreOutcome::Refused(error)),
    }
}

#[cfg(test)]
mod tests {
    use super::super::records::RecordError;
    use super::*;
    use profivac_devices::catalog::model_named;
    use profivac_devices::model::AccessPath;

    const FILE: &str = "device = \"bcg450\"\nident = 0x08E6\n\n[settings]\n\"pirani.safe-state\" = \"zero\"\n";

    #[test]
    fn a_file_has_settings_and_where_they_stand() {
        let file = SettingsFile::parse(FILE).unwrap();
        assert_eq!((file.device.as_str(), file.ident), ("bcg450", 0x08E6));
        let at = (5, 23);
        assert_eq!(file.settings, [Setting { name: "pirani.safe-state".to_owned(), value: "zero".to_owned(), at }]);
    }

    #[test]
    fn what_is_no_file_is_told_with_line_and_column() {
        for (text, place) in [
            (FILE.replace("zero\"", "zero"), "line 5, column "),
            (FILE.replace("\"zero\"", "3"), "line 5, column 23: "),
            (FILE.replace("ident", "idend"), "line 2, column 1: "),
            (FILE.replace("0x08E6", "0x108E6"), "line 2, column 9: "),
            (FILE.replace("device = \"bcg450\"\n", ""), "line "),
        ] {
            let said = SettingsFile::parse(&text).unwrap_err().to_string();
            assert!(said.starts_with(place) && !said.contains('\n'), "{said:?} instead of {place}");
        }
    }

    #[test]
    fn texts_are_quoted() {
        assert_eq!(quoted("a \"b\" \\ \u{1}"), "\"a \\\"b\\\" \\\\ \\u0001\"");
        let text = format!("device = {}\nident = 1", quoted("a \"b\" \\ \u{1}"));
        assert_eq!(SettingsFile::parse(&text).unwrap().device, "a \"b\" \\ \u{1}");
    }

    /// A gauge in which another tool moves the selector after every so many reads.
    struct Shared {
        shown: u8,
        reads: usize,
        every: usize,
    }

    impl Records for Shared {
        fn via(&self) -> AccessPath {
            AccessPath::Class2
        }

        fn read(&mut self, slot: u8, index: u8) -> Result<Vec<u8>, RecordError> {
            self.reads += 1;
            if self.every > 0 && self.reads.is_multiple_of(self.every) {
                self.shown = self.shown % 3 + 1;
            }
            Ok(match (slot, index) {
                SELECTOR_PLACE => vec![self.shown],
                // What it says of itself, and nothing else: which instance it is.
                _ => vec![self.shown; 4],
            })
        }

        fn write(&mut self, slot: u8, index: u8, octets: &[u8]) -> Result<(), RecordError> {
            assert_eq!((slot, index), SELECTOR_PLACE, "reading writes nothing else");
            self.shown = octets[0];
            Ok(())
        }
    }

    const SELECTOR_PLACE: (u8, u8) = (1, 46);

    fn dumped(every: usize) -> Result<Dump, ClientError> {
        let records = Shared { shown: 2, reads: 0, every };
        let mut gauge = Gauge::with_model(records, 5, model_named("bcg450").unwrap());
        let dump = dump(&mut gauge);
        dump
    }

    #[test]
    fn a_dump_tells_how_far_it_is() {
        let records = Shared { shown: 2, reads: 0, every: 0 };
        let mut gauge = Gauge::with_model(records, 5, model_named("bcg450").unwrap());
        let mut told = Vec::new();
        let dump = dump_with_progress(&mut gauge, |done, all| told.push((done, all))).unwrap();
        let all = dump.readings.len();
        assert!(all > 50, "{all}");
        assert_eq!(told, (0..=all).map(|done| (done, all)).collect::<Vec<_>>());
    }

    #[test]
    fn every_value_is_of_the_instance_it_is_told_for_whoever_moves_the_selector() {
        for every in [0, 40, 97] {
            for (named, reading) in dumped(every).unwrap().readings {
                let place = named.parameter.place;
                if let (1.., Ok(reading)) = (place.instance, reading) {
                    assert!(
                        named.parameter.row.name == crate::gauge::SELECTOR || reading.octets == [place.instance; 4],
                        "{named} {every}"
                    );
                }
            }
        }
        assert!(dumped(2).unwrap_err().to_string().contains("keeps moving the Channel Instance Selector"));
    }
}
