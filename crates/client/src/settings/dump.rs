//! Reads the parameters of a gauge and composes the settings file.

use super::is_setting;
use crate::cyclic::ChannelValue;
use crate::error::ClientError;
use crate::gauge::{Gauge, ParameterReading};
use crate::names::NamedParameter;
use crate::records::ErrorKind;
use crate::records::{Records, Unavailable};
use crate::values::Value;
use profivac_devices::catalog::model_named;
use profivac_devices::model::{DataType, Direction, Role, Scale};
use profivac_devices::profile::DeviceState;
use std::collections::BTreeMap;
use std::fmt::Write;

/// The values read from a gauge.
///
/// ```
/// use profivac_client::Bus;
/// use profivac_client::settings::{self, IN_IDLE, ReadResult};
///
/// # let mut bus = Bus::on(profivac_virtual::open::devices(&["bcg450@5"])?).open()?;
/// let dump = settings::dump(&mut bus.gauge(5)?)?;
/// let is_pirani = |(named, _): &&ReadResult| named.name == "pirani.process-value";
/// let (pirani, _) = dump.readings.iter().find(is_pirani).ok_or("not read")?;
/// assert_eq!(dump.invalid_reason(pirani).as_deref(), Some(IN_IDLE));
/// assert!(dump.to_toml().starts_with("device = \"bcg450\""));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
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

/// Slot and index of Device State in every block device.
const DEVICE_STATE: (u8, u8) = (0, 25);

/// Why a gauge in IDLE has no pressure.
pub const IN_IDLE: &str = "the gauge is in IDLE";

/// Why a setting is not in the file, and what to do.
const ENDS_OF_INTEGERS: &str =
    "its integer stands for every pressure beyond: choose the data type float and dump again, or add the line by hand";

/// How often an instance is read when another master moves the selector meanwhile.
const ATTEMPTS: usize = 3;

/// A parameter with its value or the error of reading it: an entry of [`Dump::readings`].
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

    /// The text of a setting that the file must not hold: an end of the integers. The gauge may hold any pressure beyond it, which the end
    /// must not replace.
    fn bound(&self, reading: &ParameterReading) -> Option<String> {
        let model = model_named(self.device)?;
        let unit = model.unit_named(reading.unit?)?;
        let is_pressure = reading.named.parameter.row.data_type == DataType::ByType;
        match reading.octets.as_slice() {
            _ if !is_pressure => None,
            [0, 0] if unit.scale != Scale::Counts => Some(format!("{}, or less than one unit", reading.text)),
            octets if octets == model.max_integer.to_be_bytes() => Some(reading.text.clone()),
            _ => None,
        }
    }

    /// The settings that the file does not hold, with the bounds of their pressures.
    fn left_out(&self) -> Vec<(&NamedParameter, String)> {
        let settings = self.readings.iter().filter(|(named, _)| is_setting(named));
        settings.filter_map(|(named, reading)| Some((named, self.bound(reading.as_ref().ok()?)?))).collect()
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
        let left_out = self.left_out();
        if !left_out.is_empty() {
            let names: Vec<_> = left_out.iter().map(|(named, _)| quoted(&named.name)).collect();
            writeln!(text, "# restore cannot write these: {ENDS_OF_INTEGERS}\nleft-out = [{}]", names.join(", ")).ok();
        }
        for (heading, note, is_wanted) in
            [("settings", "restore writes these", true), ("readings", "these are only for reading", false)]
        {
            writeln!(text, "\n# {note}\n[{heading}]").ok();
            for (named, reading) in self.readings.iter().filter(|(named, _)| is_setting(named) == is_wanted) {
                let bound = left_out.iter().find(|(other, _)| other.name == named.name);
                match reading {
                    Ok(_) if let Some((_, bound)) = bound => {
                        writeln!(text, "# {}: {bound}: {ENDS_OF_INTEGERS}", named.name).ok()
                    }
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

#[cfg(test)]
mod tests {
    use super::super::SettingsFile;
    use super::*;
    use crate::names::ParameterNames;
    use crate::records::RecordError;
    use crate::values::ValueFormat;
    use profivac_devices::model::{AccessPath, Length};

    #[test]
    fn texts_are_quoted() {
        assert_eq!(quoted("a \"b\" \\ \u{1}"), "\"a \\\"b\\\" \\\\ \\u0001\"");
        let text = format!("device = {}\nident = 1", quoted("a \"b\" \\ \u{1}"));
        assert_eq!(SettingsFile::parse(&text).unwrap().device, "a \"b\" \\ \u{1}");
    }

    /// errata-bpg-bcg-tpg 70: a restore would write 327.67 mbar over a higher Safe Value.
    #[test]
    fn a_setting_that_is_the_highest_integer_is_no_line_that_a_restore_writes() {
        let model = model_named("bcg450").unwrap();
        // Safe Value of the Pirani.
        let named = ParameterNames::of(model).at(1, 1, 40).unwrap().clone();
        let dumped = |octets: &[u8], unit: &'static str| {
            let value = Value::decode(DataType::ByType, octets).unwrap();
            let format = ValueFormat { named: &named, model, unit: model.unit_named(unit) };
            let text = format.text(octets, &value);
            let reading =
                ParameterReading { named: named.clone(), octets: octets.to_vec(), value, text, unit: Some(unit) };
            let readings = vec![(named.clone(), Ok(reading))];
            Dump { device: "bcg450", ident: model.ident, readings, pressures: BTreeMap::new() }.to_toml()
        };
        let text = dumped(&[0x7F, 0xFF], "Pascal");
        assert!(text.contains("\n# pirani.safe-value: 32767 Pascal or more: its integer stands"), "{text}");
        let file = SettingsFile::parse(&text).unwrap();
        assert_eq!((file.settings.len(), file.left_out), (0, vec!["pirani.safe-value".to_owned()]));
        // 5e-3 mbar in Pascal is 0.
        let text = dumped(&[0, 0], "Pascal");
        assert!(text.contains("\n# pirani.safe-value: 0 Pascal, or less than one unit: "), "{text}");
        let file = SettingsFile::parse(&text).unwrap();
        assert_eq!((file.settings.len(), file.left_out), (0, vec!["pirani.safe-value".to_owned()]));
        for (octets, unit, line) in [
            (&[0x7F, 0xFE][..], "Pascal", "32766 Pascal"),
            (&[0, 1], "Pascal", "1 Pascal"),
            // The logarithmic scale has no pressure at 0: it is the Safe Value 0 (errata-bpg-bcg-tpg 74).
            (&[0, 0], "COUNTS", "0 COUNTS"),
            (&[0, 0, 0, 0], "Pascal", "0 Pascal"),
            (&[0x46, 0xFF, 0xFE, 0x00], "Pascal", "32767 Pascal"),
        ] {
            let text = dumped(octets, unit);
            assert!(text.contains(&format!("\n\"pirani.safe-value\" = \"{line}\"\n")), "{text}");
            assert_eq!(SettingsFile::parse(&text).unwrap().left_out, Vec::<String>::new());
        }
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
        let mut reported = Vec::new();
        let dump = dump_with_progress(&mut gauge, |done, all| reported.push((done, all))).unwrap();
        let all = dump.readings.len();
        assert!(all > 50, "{all}");
        assert_eq!(reported, (0..=all).map(|done| (done, all)).collect::<Vec<_>>());
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
