//! A settings file compared with a gauge and written to it.

use crate::failure::Failure;
use profivac_client::names::NamedParameter;
use profivac_client::records::Records;
use profivac_client::settings::{self, Difference, RestoreOutcome, Setting, SettingsFile, close_set, open_set};
use profivac_client::{ClientError, Gauge};

/// How often all settings are compared and written: a setting may change another one.
const ROUNDS: usize = 3;

/// A setting: name, value before, value after, error.
pub type Row = (String, String, Option<String>, Option<String>);

/// The settings of the file that differ from the gauge.
pub fn differences<R: Records>(gauge: &mut Gauge<R>, text: &str) -> Result<Vec<Difference>, Failure> {
    let mut found = Vec::new();
    for (named, setting) in ordered(gauge, text)? {
        found.extend(compare(gauge, &named, &setting)?);
    }
    Ok(found)
}

/// Writes the settings that differ. All are compared before the first is written.
pub fn restore<R: Records>(gauge: &mut Gauge<R>, text: &str, force: bool) -> Result<Vec<Row>, Failure> {
    let planned = differences(gauge, text)?;
    let beyond = planned.iter().find_map(|it| Some((&it.write.named, it.write.beyond_range.as_ref()?)));
    if let (Some((named, error)), false) = (beyond, force) {
        return Err(Failure::usage(format!("{named}: {error}; to write it all the same pass force=True")));
    }
    let settings = ordered(gauge, text)?;
    let mut rows: Vec<Row> = Vec::new();
    for _ in 0..ROUNDS {
        if !write_differing(gauge, &settings, &mut rows)? {
            return Ok(rows);
        }
    }
    for (named, setting) in &settings {
        let is_refused = rows.iter().any(|row| row.0 == named.name && row.3.is_some());
        if let (false, Some(difference)) = (is_refused, compare(gauge, named, setting)?) {
            let error = "another setting of the file changes it again".to_owned();
            rows.push((named.name.clone(), difference.current.text, None, Some(error)));
        }
    }
    Ok(rows)
}

fn ordered<R: Records>(gauge: &Gauge<R>, text: &str) -> Result<Vec<(NamedParameter, Setting)>, Failure> {
    let file = SettingsFile::parse(text).map_err(|error| Failure::of_file(&error))?;
    file.check(gauge).map_err(|error| Failure::of_file(&error))?;
    file.in_order(gauge).map_err(|error| Failure::of_file(&error))
}

/// A value that the gauge cannot have is an error of the file.
fn compare<R: Records>(
    gauge: &mut Gauge<R>,
    named: &NamedParameter,
    setting: &Setting,
) -> Result<Option<Difference>, Failure> {
    settings::compare(gauge, named, setting).map_err(|error| match error {
        ClientError::Value { error, .. } => {
            let (line, column) = setting.at;
            Failure::usage(format!("line {line}, column {column}: {named}: {error}"))
        }
        error => error.into(),
    })
}

/// Writes what differs once. Returns whether anything was written.
fn write_differing<R: Records>(
    gauge: &mut Gauge<R>,
    settings: &[(NamedParameter, Setting)],
    rows: &mut Vec<Row>,
) -> Result<bool, Failure> {
    let (mut open, mut has_written): (Option<NamedParameter>, bool) = (None, false);
    let mut work = || -> Result<(), Failure> {
        for (named, setting) in settings {
            if rows.iter().any(|row| row.0 == named.name && row.3.is_some()) {
                continue;
            }
            let Some(difference) = compare(gauge, named, setting)? else { continue };
            let lock = gauge.names().lock_of(named).cloned();
            if lock.as_ref().map(|lock| &lock.name) != open.as_ref().map(|open| &open.name) {
                if let Some(open) = open.take() {
                    close_set(gauge, &open)?;
                }
                if let Some(lock) = &lock {
                    open_set(gauge, lock)?;
                }
                open = lock;
            }
            let before = difference.current.text.clone();
            match settings::restore(gauge, difference)? {
                RestoreOutcome::Written { name, before, after } => {
                    has_written = true;
                    rows.push((name, before, Some(after), None));
                }
                RestoreOutcome::Refused(error) => {
                    rows.push((named.name.clone(), before, None, Some(error.to_string())));
                }
            }
        }
        Ok(())
    };
    let done = work();
    // The set is closed after an error, too; the first error is reported.
    let closed = open.map_or(Ok(()), |lock| close_set(gauge, &lock));
    done?;
    closed?;
    Ok(has_written)
}
