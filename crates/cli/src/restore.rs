//! `profivac restore`: writes a settings file to a gauge.

use crate::advice;
use crate::diff::{differences, load, ordered_settings};
use crate::failure::Failure;
use crate::gauge::{AnyGauge, GaugeOptions};
use crate::output::{json, notice, out};
use clap::Args;
use profivac_client::PreparedWrite;
use profivac_client::names::NamedParameter;
use profivac_client::settings::{Difference, RestoreOutcome, Setting, close_set, compare, open_set, restore};
use profivac_devices::model::Storage;
use serde::Serialize;
use std::path::{Path, PathBuf};

/// Write the settings in a file of `profivac dump` to a gauge, for instance to a replacement.
///
/// The command refuses the file of a device with another ident number. It writes only settings that differ: unit and data type first,
/// enabling parameters last. It reads each setting back and reports it. After a setting that the gauge refuses it continues with the next.
#[derive(Args, Debug)]
#[command(after_help = EXAMPLES)]
pub struct Arguments {
    #[command(flatten)]
    options: GaugeOptions,
    /// Show the changes without writing them
    #[arg(long)]
    dry_run: bool,
    /// Write pressures outside the measuring range of the gauge
    #[arg(long)]
    force: bool,
    /// Print JSON
    #[arg(long)]
    json: bool,
    /// The settings file
    #[arg(value_name = "FILE")]
    file: PathBuf,
}

const EXAMPLES: &str = "\
Examples:
  profivac restore --port /dev/ttyUSB0 --address 5 gauge.toml --dry-run
  profivac restore --port /dev/ttyUSB0 --address 5 gauge.toml";

/// A written value may change another setting, so the settings are compared this often again.
const ROUNDS: usize = 2;

/// A setting in the JSON output.
#[derive(Debug, Serialize)]
struct Row {
    name: String,
    before: String,
    /// The new value; with --dry-run the value that would be written.
    after: Option<String>,
    error: Option<String>,
}

/// Compares, writes, reads back.
pub fn run(arguments: &Arguments) -> Result<(), Failure> {
    let file = load(&arguments.file)?;
    let mut rows = Vec::new();
    let done = arguments.options.with_gauge(|gauge| {
        let settings = ordered_settings(&file, &arguments.file, gauge)?;
        // All values are compared before the first is written.
        let found = differences(gauge, &settings, &arguments.file)?;
        if !arguments.force {
            check_ranges(&found, &settings, &arguments.file)?;
        }
        if arguments.dry_run {
            rows = found.iter().map(planned).collect();
            return Ok(());
        }
        let done = write_all(gauge, &settings, &mut rows);
        remind_to_store(&settings, &rows);
        done
    });
    print(arguments, &rows);
    if !file.left_out.is_empty() {
        notice(&left_out(&file.left_out));
    }
    if let Err(failure) = done {
        let written = rows.iter().filter(|row| row.error.is_none()).count();
        if written > 0 {
            notice(&format_args!(
                "{written} settings were written before the failure; `profivac diff` shows the others"
            ));
        }
        return Err(failure);
    }
    let refused = rows.iter().filter(|row| row.error.is_some()).count();
    if refused > 0 {
        return Err(Failure::refused(format!("the gauge refused {refused} of {} differing settings", rows.len())));
    }
    let verb = if arguments.dry_run { "would be" } else { "were" };
    notice(&format_args!("{} of {} settings differed and {verb} written", rows.len(), file.settings.len()));
    Ok(())
}

/// The settings that the gauge keeps as they are, because the file has only a bound of them.
fn left_out(names: &[String]) -> String {
    format!(
        "not in the file, because the integers of the gauge showed only a bound: {}; set them by hand, or dump the other gauge with the data \
         type float",
        names.join(", ")
    )
}

/// A pressure outside the measuring range is an error of the file: nothing is written.
fn check_ranges(found: &[Difference], settings: &[(NamedParameter, Setting)], path: &Path) -> Result<(), Failure> {
    for PreparedWrite { named, beyond_range, .. } in found.iter().map(|difference| &difference.write) {
        let Some(error) = beyond_range else { continue };
        let setting = settings.iter().find(|(other, _)| other.name == named.name);
        let (line, column) = setting.map_or((0, 0), |(_, setting)| setting.at);
        let sentence = format!("{}: line {line}, column {column}: {named}: {error}", path.display());
        return Err(Failure::usage(format!("{sentence}; to write it all the same add --force")));
    }
    Ok(())
}

fn planned(difference: &Difference) -> Row {
    let Difference { write, current } = difference;
    Row { name: write.named.name.clone(), before: current.text.clone(), after: Some(write.text.clone()), error: None }
}

/// The lock of the parameter set that is open for changes, if any.
struct OpenSet(Option<NamedParameter>);

impl OpenSet {
    /// Closes the open set if `next` is in another one, and opens that.
    fn move_to(&mut self, gauge: &mut AnyGauge<'_>, next: Option<&NamedParameter>) -> Result<(), Failure> {
        let next = next.and_then(|named| gauge.names().lock_of(named).cloned());
        let name = |lock: &Option<NamedParameter>| lock.as_ref().map(|lock| lock.name.clone());
        if name(&self.0) != name(&next) {
            if let Some(lock) = self.0.take() {
                close_set(gauge, &lock)?;
            }
            if let Some(lock) = &next {
                open_set(gauge, lock)?;
            }
            self.0 = next;
        }
        Ok(())
    }
}

fn write_all(
    gauge: &mut AnyGauge<'_>,
    settings: &[(NamedParameter, Setting)],
    rows: &mut Vec<Row>,
) -> Result<(), Failure> {
    let mut lock = OpenSet(None);
    for round in 0..=ROUNDS {
        for (named, setting) in settings {
            // A setting that was refused is not written again.
            if round > 0 && rows.iter().any(|row| row.name == named.name && row.error.is_some()) {
                continue;
            }
            let Some(difference) = compare(gauge, named, setting)? else { continue };
            if round == ROUNDS {
                rows.push(conflicting(named, &difference));
                continue;
            }
            lock.move_to(gauge, Some(named))?;
            rows.push(write_one(gauge, named, difference)?);
        }
        lock.move_to(gauge, None)?;
    }
    Ok(())
}

/// The row of a setting that another setting keeps changing.
fn conflicting(named: &NamedParameter, difference: &Difference) -> Row {
    let error = format!("another setting of the file changes it again after {} is written", difference.write.text);
    Row { name: named.name.clone(), before: difference.current.text.clone(), after: None, error: Some(error) }
}

fn write_one(gauge: &mut AnyGauge<'_>, named: &NamedParameter, difference: Difference) -> Result<Row, Failure> {
    let before = difference.current.text.clone();
    Ok(match restore(gauge, difference)? {
        RestoreOutcome::Written { name, before, after } => Row { name, before, after: Some(after), error: None },
        RestoreOutcome::Refused(error) => {
            Row { name: named.name.clone(), before, after: None, error: Some(advice::sentence(&error)) }
        }
    })
}

/// Prints a notice if a written setting is stored on request only.
fn remind_to_store(settings: &[(NamedParameter, Setting)], rows: &[Row]) {
    let on_request = |(named, _): &(NamedParameter, Setting)| {
        named.parameter.row.storage == Storage::OnRequest && rows.iter().any(|row| row.name == named.name)
    };
    if settings.iter().any(on_request) {
        notice(&format_args!(
            "the device stores some of these settings only on request; send `profivac write ... store` to keep them without power"
        ));
    }
}

fn print(arguments: &Arguments, rows: &[Row]) {
    if arguments.json {
        out(&json(&rows));
        return;
    }
    for row in rows {
        match (&row.after, &row.error) {
            (Some(after), _) => out(&format!("{}: {} -> {after}", row.name, row.before)),
            (None, Some(error)) => out(&format!("{}: {} unchanged: {error}", row.name, row.before)),
            (None, None) => {}
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use profivac_client::Gauge;
    use profivac_client::records::{Interruption, RecordError, Records};
    use profivac_client::settings::SettingsFile;
    use profivac_devices::model::AccessPath;
    use profivac_virtual::device_spec::entry;
    use std::collections::BTreeMap;

    /// Records that accept every write until `writes_left` is used up. The first `moves` writes to relay 3 switch relay 1 off.
    struct FailingRecords {
        records: BTreeMap<(u8, u8), Vec<u8>>,
        writes_left: usize,
        moves: usize,
    }

    impl FailingRecords {
        fn gauge(writes_left: usize, moves: usize) -> AnyGauge<'static> {
            let records: Box<dyn Records> = Box::new(Self { records: BTreeMap::new(), writes_left, moves });
            Gauge::with_model(records, 5, entry("img400").unwrap().model)
        }
    }

    impl Records for FailingRecords {
        fn via(&self) -> AccessPath {
            AccessPath::Class2
        }

        fn read(&mut self, slot: u8, index: u8) -> Result<Vec<u8>, RecordError> {
            match self.writes_left {
                0 => Err(Interruption::NoAnswer.into()),
                _ => Ok(self.records.get(&(slot, index)).cloned().unwrap_or_else(|| vec![0])),
            }
        }

        fn write(&mut self, slot: u8, index: u8, octets: &[u8]) -> Result<(), RecordError> {
            self.writes_left = self.writes_left.saturating_sub(1);
            match self.writes_left {
                0 => Err(Interruption::NoAnswer.into()),
                _ => {
                    self.records.insert((slot, index), octets.to_vec());
                    if slot == 7 && self.moves > 0 {
                        self.moves -= 1;
                        self.records.insert((5, 20), vec![0]);
                        self.records.insert((7, 20), vec![u8::from(self.moves == 0)]);
                    }
                    Ok(())
                }
            }
        }
    }

    const FILE: &str = r#"
device = "img400"
ident = 0x0947
[settings]
"relay.1/low-trip-enable" = "true"
"relay.2/low-trip-enable" = "true"
"relay.3/low-trip-enable" = "true"
"device.key-lock" = "full-lock"
"#;

    fn restored(mut gauge: AnyGauge<'_>) -> (Vec<Row>, Result<(), Failure>) {
        let text = FILE.replace("\"device.key-lock\" = \"full-lock\"\n", "");
        let settings = SettingsFile::parse(&text).unwrap().in_order(&gauge).unwrap();
        let mut rows = Vec::new();
        let done = write_all(&mut gauge, &settings, &mut rows);
        (rows, done)
    }

    fn names(rows: &[Row]) -> Vec<&str> {
        rows.iter().map(|row| row.name.as_str()).collect()
    }

    #[test]
    fn a_lost_line_ends_the_restore_and_reports_what_was_written() {
        let all = ["relay.1/low-trip-enable", "relay.2/low-trip-enable", "relay.3/low-trip-enable"];
        let (rows, done) = restored(FailingRecords::gauge(100, 0));
        assert_eq!(names(&rows), all);
        done.unwrap();
        let (rows, done) = restored(FailingRecords::gauge(3, 0));
        assert_eq!(names(&rows), all[..2]);
        let error = done.unwrap_err().to_string();
        let lost = "img400 at address 5, relay.3/low-trip-enable (slot 7, index 20): writing was cut short: no answer; it may have been written, read it";
        assert_eq!(error, lost);
    }

    #[test]
    fn a_setting_that_another_setting_changed_is_written_again() {
        let (rows, done) = restored(FailingRecords::gauge(100, 1));
        done.unwrap();
        let expected = [
            "relay.1/low-trip-enable",
            "relay.2/low-trip-enable",
            "relay.3/low-trip-enable",
            "relay.1/low-trip-enable",
        ];
        assert_eq!(names(&rows), expected);
        assert!(rows.iter().all(|row| row.error.is_none()), "{rows:?}");
    }

    /// Key Lock does not survive power loss, so `dump` never writes it as a setting.
    #[test]
    fn a_volatile_parameter_is_no_setting() {
        let gauge = FailingRecords::gauge(1, 0);
        let error = SettingsFile::parse(FILE).unwrap().in_order(&gauge).unwrap_err().to_string();
        assert_eq!(error, "line 8, column 21: device.key-lock is no setting of img400");
    }
}
