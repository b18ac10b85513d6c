//! The settings of a gauge as a file. Settings are the writable parameters that survive power loss. A file can be compared
//! with a gauge and written to its replacement.
//!
//! The file is TOML. [`restore`] writes `[settings]`; `[readings]` contains the other values, for the reader of the file. Pressures
//! have their unit, so a file fits a gauge with another unit; a pressure without one is an error.
//!
//! ```
//! # use profivac_client::Bus;
//! use profivac_client::settings::{self, RestoreOutcome, SettingsFile};
//!
//! # let mut bus = Bus::on(profivac_virtual::open::devices(&["bcg450@5:unit=mbar", "bcg450@6:unit=torr"])?).open()?;
//! bus.gauge(5)?.write("pirani.safe-value", "12.5 Pa")?;
//! let file = SettingsFile::parse(&settings::dump(&mut bus.gauge(5)?)?.to_toml())?;
//!
//! let mut replacement = bus.gauge(6)?;
//! file.check(&replacement)?;
//! for (named, setting) in file.in_order(&replacement)? {
//!     if let Some(difference) = settings::compare(&mut replacement, &named, &setting)? {
//!         // A value outside the measuring range would be reported here.
//!         assert!(difference.write.beyond_range.is_none());
//!         match settings::restore(&mut replacement, difference)? {
//!             RestoreOutcome::Written { name, before, after } => println!("{name}: {before} -> {after}"),
//!             RestoreOutcome::Refused(error) => println!("{error}"),
//!         }
//!     }
//! }
//! assert_eq!(replacement.read("pirani.safe-value")?.text, "0.125 mbar");
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

use super::cyclic::ChannelValue;
use super::error::{ClientError, ErrorKind};
use super::gauge::{Gauge, ParameterReading, PreparedWrite};
use super::names::{NamedParameter, Target, TargetError};
use super::records::{Records, Unavailable};
use super::values::Value;
use profivac_devices::model::{Access, Codes, DataType, Direction, Role};
use profivac_devices::profile::DeviceState;
use profivac_host::text_file::line_and_column;
use serde::Deserialize;
use std::collections::BTreeMap;
use std::fmt::Write;
use toml::Spanned;

/// The values of the parameter that opens and closes a set.
const OPEN: &str = "open-for-changes";
const CLOSED: &str = "valid";

/// The values read from a gauge.
#[derive(Debug)]
pub struct Dump {
    /// The device.
    pub device: &'static str,
    /// Ident_Number.
    pub ident: u16,
    /// Every readable parameter, each with its value or the error of reading it.
    pub readings: Vec<ReadResult>,
    /// The Process Values with their quality, by name.
    pub pressures: BTreeMap<String, ChannelValue>,
}

/// A parsed settings file.
#[derive(Debug)]
pub struct SettingsFile {
    /// The device.
    pub device: String,
    /// Ident_Number.
    pub ident: u16,
    /// The settings.
    pub settings: Vec<Setting>,
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

/// A setting whose value differs from the file.
#[derive(Debug)]
pub struct Difference {
    /// The write that would apply the value of the file.
    pub write: PreparedWrite,
    /// The present value.
    pub current: ParameterReading,
}

/// The result of restoring one setting.
#[derive(Debug)]
pub enum RestoreOutcome {
    /// The value of the file was written and read back.
    Written {
        /// The parameter.
        name: String,
        /// The value before.
        before: String,
        /// The value now.
        after: String,
    },
    /// The value was not applied.
    Refused(ClientError),
}

/// Whether a parameter is a setting: a value that survives power loss and that a request can write.
///
/// ```
/// use profivac_client::names::ParameterNames;
/// use profivac_client::settings::is_setting;
/// use profivac_devices::catalog::model_named;
///
/// let names = ParameterNames::of(model_named("bcg450").ok_or("no such model")?);
/// let settings: Vec<_> = names.all().iter().filter(|named| is_setting(named)).map(|named| named.name.as_str()).collect();
/// assert!(settings.contains(&"pirani.safe-value") && !settings.contains(&"pirani.process-value"));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[must_use]
pub fn is_setting(named: &NamedParameter) -> bool {
    let row = named.parameter.row;
    row.is_stored()
        && row.access.intersects(Access::WRITE)
        && !row.codes.is_command()
        && row.role != Some(Role::InstanceSelector)
}

/// Opens a set of parameters for changes.
///
/// # Errors
/// As [`Gauge::write`].
pub fn open_set<R: Records>(gauge: &mut Gauge<R>, lock: &NamedParameter) -> Result<(), ClientError> {
    let write = gauge.prepare(lock, OPEN)?;
    gauge.execute(write).map(|_| ())
}

/// Closes a set of parameters, which applies its values.
///
/// # Errors
/// As [`Gauge::write`]; the device refuses if the values contradict each other.
pub fn close_set<R: Records>(gauge: &mut Gauge<R>, lock: &NamedParameter) -> Result<(), ClientError> {
    let write = gauge.prepare(lock, CLOSED)?;
    gauge.execute(write).map(|_| ())
}

/// Slot and index of Device State in every block device.
const DEVICE_STATE: (u8, u8) = (0, 25);

/// Why a gauge in IDLE has no pressure.
pub const IN_IDLE: &str = "the gauge is in IDLE";

/// How often an instance is read when another master moves the selector meanwhile.
const ATTEMPTS: usize = 3;

/// A parameter with its value or the error of reading it.
pub type ReadResult = (NamedParameter, Result<ParameterReading, ClientError>);

/// The parameters of one instance, and its Process Values with their quality.
type InstanceDump = (Vec<ReadResult>, Vec<(String, ChannelValue)>);

/// Reads the parameters of one instance, and reports the count before each. Checks the selector once, at the end.
fn dump_instance<R: Records>(
    gauge: &mut Gauge<R>,
    group: &[&NamedParameter],
    report: &mut dyn FnMut(usize),
) -> Result<InstanceDump, ClientError> {
    let Some(last) = group.last() else { return Ok(InstanceDump::default()) };
    for _ in 0..ATTEMPTS {
        let ((readings, is_selected), has_unit) = gauge.with_one_unit(|gauge| {
            let (mut readings, mut pressures) = InstanceDump::default();
            for named in group {
                report(readings.len());
                match gauge.read_once(named) {
                    Err(error) if error.kind() == ErrorKind::Line => return Err(error),
                    reading => readings.push(((*named).clone(), reading)),
                }
            }
            // Before anything else is read, which may move the selector back.
            let is_selected = gauge.is_still_selected(last)?;
            let is_pressure = |named: &&&NamedParameter| named.parameter.row.role == Some(Role::ProcessValue);
            for named in group.iter().filter(|_| is_selected).filter(is_pressure) {
                match gauge.pressure_of(named) {
                    Err(error) if error.kind() == ErrorKind::Line => return Err(error),
                    // The value has an error too, or this service does not read its status.
                    Err(_) => {}
                    Ok(pressure) => pressures.push((named.name.clone(), pressure)),
                }
            }
            Ok(((readings, pressures), is_selected))
        })?;
        if is_selected && has_unit {
            return Ok(readings);
        }
    }
    Err(gauge.selector_contention())
}

/// Reads every readable parameter.
///
/// # Errors
/// The line was lost. A refusal of the gauge is part of the result.
pub fn dump<R: Records>(gauge: &mut Gauge<R>) -> Result<Dump, ClientError> {
    dump_with_progress(gauge, |_, _| {})
}

/// Reads every readable parameter and reports how many of all are done: on a slow line this takes long.
///
/// ```
/// # use profivac_client::{Bus, settings};
/// # let mut bus = Bus::on(profivac_virtual::open::devices(&["bcg450@5"])?).open()?;
/// let mut last = (0, 0);
/// let dump = settings::dump_with_progress(&mut bus.gauge(5)?, |done, all| last = (done, all))?;
/// assert_eq!(last, (dump.readings.len(), dump.readings.len()));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// # Errors
/// As [`dump`].
pub fn dump_with_progress<R: Records>(
    gauge: &mut Gauge<R>,
    mut report: impl FnMut(usize, usize),
) -> Result<Dump, ClientError> {
    let names = gauge.names();
    let via = gauge.records().via();
    let is_read = |named: &&NamedParameter| {
        let row = named.parameter.row;
        !row.codes.is_command() && row.access.allows(via, Direction::Read)
    };
    let wanted: Vec<_> = names.all().iter().filter(is_read).collect();
    let location = |named: &NamedParameter| (named.parameter.location.slot, named.parameter.location.instance);
    let (mut readings, mut pressures) = (Vec::new(), BTreeMap::new());
    for group in wanted.chunk_by(|a, b| location(a) == location(b)) {
        let before = readings.len();
        let (read, with_quality) = dump_instance(gauge, group, &mut |done| report(before + done, wanted.len()))?;
        readings.extend(read);
        pressures.extend(with_quality);
    }
    report(readings.len(), wanted.len());
    if readings.is_empty() {
        return Err(gauge.unavailable(Unavailable::NothingReadable));
    }
    Ok(Dump { device: gauge.model().name, ident: gauge.model().ident, readings, pressures })
}

impl Dump {
    /// Why the value of a Process Value is no measured pressure. `None` for a valid one and for every other parameter.
    #[must_use]
    pub fn invalid_reason(&self, named: &NamedParameter) -> Option<String> {
        let pressure = self.pressures.get(&named.name).filter(|pressure| !pressure.is_valid())?;
        // In IDLE the status bits of the reading mean nothing.
        Some(if self.is_idle() { IN_IDLE.to_owned() } else { pressure.text() })
    }

    fn is_idle(&self) -> bool {
        let (slot, index) = DEVICE_STATE;
        let idle = Value::Integer(DeviceState::Idle.code().into());
        self.readings.iter().any(|(named, reading)| {
            let at = (named.parameter.location.slot, named.parameter.row.index);
            at == (slot, index) && reading.as_ref().is_ok_and(|reading| reading.value == idle)
        })
    }

    /// The file as TOML.
    #[must_use]
    pub fn to_toml(&self) -> String {
        let mut text = format!("device = \"{}\"\nident = 0x{:04X}\n", self.device, self.ident);
        for (heading, note, is_wanted) in
            [("settings", "restore writes these", true), ("readings", "these are only for reading", false)]
        {
            writeln!(text, "\n# {note}\n[{heading}]").ok();
            for (named, reading) in self.readings.iter().filter(|(named, _)| is_setting(named) == is_wanted) {
                match reading {
                    Ok(reading) => {
                        let reason = self.invalid_reason(named).map(|reason| format!("  # not valid: {reason}"));
                        let reason = reason.unwrap_or_default();
                        writeln!(text, "\"{}\" = {}{reason}", named.name, quoted(&reading.text)).ok()
                    }
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

/// The file as serde reads it.
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
        Ok(Self { device: raw.device, ident: raw.ident, settings: raw.settings.into_iter().map(setting).collect() })
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
        (Codes::Units, _) => 0,
        _ if row.role == Some(Role::NumberType) => 1,
        (Codes::Names(_) | Codes::Range(..) | Codes::PerMille(..), _) => 2,
        (_, DataType::Boolean) => 4,
        _ => 3,
    }
}

/// Compares a setting with the gauge. `None` if the values are equal.
///
/// # Errors
/// [`ClientError`] if the parameter cannot be read or does not accept the value.
pub fn compare<R: Records>(
    gauge: &mut Gauge<R>,
    named: &NamedParameter,
    setting: &Setting,
) -> Result<Option<Difference>, ClientError> {
    // A file may contain what the gauge had; `Difference::write` says whether the value is outside the measuring range.
    let write = gauge.prepare_forced(named, &setting.value)?;
    let current = match &write.before {
        Some(before) => before.clone(),
        None => gauge.read_parameter(named)?,
    };
    Ok((!is_same(named, &write.octets, &current.octets)).then_some(Difference { write, current }))
}

/// Whether two values are equal. A pressure converted between units may differ in the last digit.
fn is_same(named: &NamedParameter, a: &[u8], b: &[u8]) -> bool {
    let number = |octets: &[u8]| octets.try_into().ok().map(f32::from_be_bytes);
    match (named.parameter.row.data_type, number(a), number(b)) {
        (DataType::ByType | DataType::Float, Some(a), Some(b)) => (a - b).abs() <= 1e-6 * a.abs().max(b.abs()),
        _ => a == b,
    }
}

/// Writes the value of the file and reads it back.
///
/// # Errors
/// [`ClientError`] of the line. A refusal and [`ClientError::NotKept`] are part of the result.
pub fn restore<R: Records>(gauge: &mut Gauge<R>, difference: Difference) -> Result<RestoreOutcome, ClientError> {
    let (octets, text, named) =
        (difference.write.octets.clone(), difference.write.text.clone(), difference.write.named.clone());
    match gauge.execute(difference.write) {
        Ok(written) => {
            let after = written.after.as_ref().map_or_else(|| text.clone(), |after| after.text.clone());
            let is_kept = written.after.as_ref().is_none_or(|after| is_same(&named, &octets, &after.octets));
            if is_kept {
                return Ok(RestoreOutcome::Written { name: named.name, before: difference.current.text, after });
            }
            let location = gauge.context(&named);
            Ok(RestoreOutcome::Refused(ClientError::NotKept { location, written: text, found: after }))
        }
        Err(error) if error.kind() == ErrorKind::Line => Err(error),
        Err(error) => Ok(RestoreOutcome::Refused(error)),
    }
}

#[cfg(test)]
mod tests {
    use super::super::records::RecordError;
    use super::*;
    use crate::names::ParameterNames;
    use profivac_devices::catalog::model_named;
    use profivac_devices::model::{AccessPath, Length};

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
            let said = SettingsFile::parse(&text).unwrap_err().to_string();
            assert!(said.starts_with(location) && !said.contains('\n'), "{said:?} instead of {location}");
        }
    }

    #[test]
    fn texts_are_quoted() {
        assert_eq!(quoted("a \"b\" \\ \u{1}"), "\"a \\\"b\\\" \\\\ \\u0001\"");
        let text = format!("device = {}\nident = 1", quoted("a \"b\" \\ \u{1}"));
        assert_eq!(SettingsFile::parse(&text).unwrap().device, "a \"b\" \\ \u{1}");
    }

    /// A gauge whose selector another master moves after every `every` reads.
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
            let named = ParameterNames::of(model_named("bcg450").unwrap());
            let mut data_types = named.at_index(slot, index).map(|named| named.parameter.row.data_type);
            // Every record contains the number of the instance only.
            Ok(match data_types.next().unwrap().octets() {
                Length::Exactly(length) | Length::AtMost(length) => vec![self.shown; length.into()],
                Length::ByNumberType => vec![self.shown; 4],
            })
        }

        fn write(&mut self, slot: u8, index: u8, octets: &[u8]) -> Result<(), RecordError> {
            assert_eq!((slot, index), SELECTOR, "reading writes nothing else");
            self.shown = octets[0];
            Ok(())
        }
    }

    const SELECTOR: (u8, u8) = (1, 46);

    fn dumped(every: usize) -> Result<Dump, ClientError> {
        let records = Shared { shown: 2, reads: 0, every };
        let mut gauge = Gauge::with_model(records, 5, model_named("bcg450").unwrap());
        dump(&mut gauge)
    }

    #[test]
    fn a_dump_reports_its_progress() {
        let records = Shared { shown: 2, reads: 0, every: 0 };
        let mut gauge = Gauge::with_model(records, 5, model_named("bcg450").unwrap());
        let mut told = Vec::new();
        let dump = dump_with_progress(&mut gauge, |done, all| told.push((done, all))).unwrap();
        let all = dump.readings.len();
        assert!(all > 50, "{all}");
        assert_eq!(told, (0..=all).map(|done| (done, all)).collect::<Vec<_>>());
    }

    #[test]
    fn every_value_belongs_to_its_instance_while_another_master_moves_the_selector() {
        // An instance takes fewer than 40 reads, so one of two attempts is undisturbed.
        for every in [0, 80, 97] {
            for (named, reading) in dumped(every).unwrap().readings {
                let location = named.parameter.location;
                if let (1.., Ok(reading)) = (location.instance, reading) {
                    let is_selector = named.parameter.row.role == Some(Role::InstanceSelector);
                    let of_instance = reading.octets.iter().all(|octet| *octet == location.instance);
                    assert!(is_selector || of_instance, "{named} {every}");
                }
            }
        }
        let error = dumped(2).unwrap_err();
        assert!(matches!(error, ClientError::Unavailable { reason: Unavailable::SelectorContention, .. }), "{error}");
    }
}
