//! The samples of one gauge, from a station's database or from a CSV file.

use crate::failure::Failure;
use jiff::Timestamp;
use profivac_client::suggestion::closest;
use profivac_recorder::{Micros, Quality, Reader, Sample};
use profivac_station::pumpdown::TimeRange;
use profivac_station::report::series::{known, series};
use std::collections::BTreeMap;
use std::path::Path;

/// The end of the year 9999, in seconds since 1970: no later time is a time of a sample.
const LAST_SECOND: f64 = 253_402_300_800.0;

/// The samples of a gauge.
pub struct Source {
    pub gauge: String,
    pub samples: Vec<Sample>,
}

/// Reads the samples of a gauge. Without a name the file must have one gauge only.
pub fn read(path: &Path, gauge: Option<&str>) -> Result<Source, Failure> {
    let has = |wanted: &str| path.extension().is_some_and(|extension| extension.eq_ignore_ascii_case(wanted));
    if has("csv") {
        let text = std::fs::read_to_string(path)
            .map_err(|error| Failure::usage(format!("{} cannot be read: {error}", path.display())))?;
        let all = csv(&text).map_err(|wrong| Failure::usage(format!("{}:{wrong}", path.display())))?;
        let names: Vec<String> = all.keys().cloned().collect();
        let name = chosen(gauge, &names, path)?;
        let samples = all.get(&name).cloned().unwrap_or_default();
        return Ok(Source { gauge: name, samples });
    }
    let config = has("toml").then(|| profivac_config::read(path)).transpose()?;
    let database = config.as_ref().map_or_else(|| path.to_path_buf(), |config| config.database.clone());
    if !database.exists() {
        return Err(Failure::usage(format!(
            "{} does not exist; `profivac run` makes it, and `profivac identify` also reads the CSV of `profivac monitor --csv`",
            database.display()
        )));
    }
    let reader = Reader::open(&database)
        .map_err(|error| Failure::usage(format!("{} is no database of a station: {error}", database.display())))?;
    let name = chosen(gauge, &reader.series_names()?, &database)?;
    let span = known(&reader, std::slice::from_ref(&name))?;
    let span = span.ok_or_else(|| Failure::usage(format!("{} contains no samples yet", database.display())))?;
    let samples = series(&reader, &name, TimeRange { ..span })?.samples;
    Ok(Source { gauge: name, samples })
}

/// The gauge with this name, or the only one.
fn chosen(gauge: Option<&str>, names: &[String], path: &Path) -> Result<String, Failure> {
    let list = || names.iter().map(|name| format!("{name:?}")).collect::<Vec<_>>().join(", ");
    match (gauge, names) {
        (_, []) => Err(Failure::usage(format!("expected samples, {} has none", path.display()))),
        (None, [only]) => Ok(only.clone()),
        (None, _) => {
            Err(Failure::usage(format!("{} has several gauges: choose one of {} with --gauge", path.display(), list())))
        }
        (Some(gauge), _) if names.iter().any(|name| name == gauge) => Ok(gauge.to_owned()),
        (Some(gauge), _) => {
            let hint = closest(gauge, names.iter().map(String::as_str));
            let hint = hint.map_or_else(list, |name| format!("{name:?}"));
            Err(Failure::usage(format!("{} has no gauge {gauge:?}: expected {hint}", path.display())))
        }
    }
}

/// Why a CSV file has no samples, and in which line.
#[derive(Debug, thiserror::Error)]
#[error("{line}: {problem}")]
struct CsvError {
    /// From 1.
    line: usize,
    problem: CsvProblem,
}

/// Why a line of a CSV file has no sample.
#[derive(Debug, thiserror::Error)]
enum CsvProblem {
    #[error("expected a heading, found an empty file")]
    Empty,
    /// The beginning of the heading.
    #[error(
        "expected the columns of an export (time,gauge,pressure_pa,quality) or of `profivac monitor --csv` \
         (unix_time,...,address,...,mbar,...,quality), found {0:?}"
    )]
    Heading(String),
    #[error("expected at least {expected} fields, found {found}")]
    Fields { expected: usize, found: usize },
    #[error("expected a time, found {0:?}")]
    Time(String),
    #[error("expected a pressure above 0, found {0:?}")]
    Pressure(String),
}

/// The columns that a file of `monitor --csv` or of an export has.
struct Columns {
    time: usize,
    is_unix: bool,
    gauge: usize,
    instance: Option<usize>,
    pressure: usize,
    pa: f64,
    quality: usize,
}

impl Columns {
    fn of(heading: &str) -> Result<Self, CsvProblem> {
        let names = fields(heading);
        let index = |name: &str| names.iter().position(|column| column == name);
        let export = [index("time"), index("gauge"), index("pressure_pa"), index("quality")];
        let monitor = [index("unix_time"), index("address"), index("mbar"), index("quality")];
        match (export, monitor) {
            ([Some(time), Some(gauge), Some(pressure), Some(quality)], _) => {
                Ok(Self { time, is_unix: false, gauge, instance: None, pressure, pa: 1.0, quality })
            }
            (_, [Some(time), Some(gauge), Some(pressure), Some(quality)]) => {
                let instance = index("instance");
                Ok(Self { time, is_unix: true, gauge, instance, pressure, pa: 100.0, quality })
            }
            _ => Err(CsvProblem::Heading(heading.chars().take(80).collect())),
        }
    }

    /// The gauge and the sample of a row; the reason why it has none. A row without a pressure has no sample.
    fn row(&self, line: &str) -> Result<Option<(String, Sample)>, CsvProblem> {
        let all = fields(line);
        let at = |index: usize| all.get(index).map(String::as_str);
        let last = self.time.max(self.gauge).max(self.pressure).max(self.quality);
        let missing = || CsvProblem::Fields { expected: last.saturating_add(1), found: all.len() };
        let (time, gauge) = (at(self.time).ok_or_else(missing)?, at(self.gauge).ok_or_else(missing)?);
        let (pressure, quality) = (at(self.pressure).ok_or_else(missing)?, at(self.quality).ok_or_else(missing)?);
        let wrong_time = || CsvProblem::Time(time.to_owned());
        let at_micros = if self.is_unix {
            let seconds = time.parse().ok().filter(|seconds| (0.0..LAST_SECOND).contains(seconds));
            (seconds.ok_or_else(wrong_time)? * 1e6) as i64
        } else {
            time.parse::<Timestamp>().map_err(|_| wrong_time())?.as_microsecond()
        };
        let Some(quality) = Quality::ALL.into_iter().find(|known| known.word() == quality) else { return Ok(None) };
        if pressure.is_empty() {
            return Ok(None);
        }
        let number = pressure.parse::<f64>().ok().filter(|number| number.is_finite() && *number > 0.0);
        let number = number.ok_or_else(|| CsvProblem::Pressure(pressure.to_owned()))?;
        let instance = self.instance.and_then(at).filter(|instance| !matches!(*instance, "" | "0" | "1"));
        let name = instance.map_or_else(|| gauge.to_owned(), |instance| format!("{gauge}.{instance}"));
        Ok(Some((name, Sample::new(Micros(at_micros), Some(number * self.pa), quality))))
    }
}

/// The samples of each gauge in the order of time; the first error.
fn csv(text: &str) -> Result<BTreeMap<String, Vec<Sample>>, CsvError> {
    let mut lines = text.lines().enumerate();
    let (_, heading) = lines.next().ok_or(CsvError { line: 1, problem: CsvProblem::Empty })?;
    let columns = Columns::of(heading.trim_start_matches('\u{feff}'));
    let columns = columns.map_err(|problem| CsvError { line: 1, problem })?;
    let mut all: BTreeMap<String, Vec<Sample>> = BTreeMap::new();
    for (number, line) in lines.filter(|(_, line)| !line.trim().is_empty()) {
        let row = columns.row(line).map_err(|problem| CsvError { line: number.saturating_add(1), problem })?;
        if let Some((gauge, sample)) = row {
            all.entry(gauge).or_default().push(sample);
        }
    }
    all.values_mut().for_each(|samples| samples.sort_by_key(|sample| sample.at));
    Ok(all)
}

/// The fields of a row (RFC 4180).
fn fields(line: &str) -> Vec<String> {
    let mut all = Vec::new();
    let (mut field, mut quoted) = (String::new(), false);
    let mut letters = line.chars().peekable();
    while let Some(letter) = letters.next() {
        match letter {
            '"' if quoted && letters.peek() == Some(&'"') => {
                letters.next();
                field.push('"');
            }
            '"' => quoted = !quoted,
            ',' if !quoted => all.push(std::mem::take(&mut field)),
            _ => field.push(letter),
        }
    }
    all.push(field);
    all
}

#[cfg(test)]
#[allow(clippy::unwrap_used, reason = "a test")]
mod tests {
    use super::*;

    #[test]
    fn an_export_and_the_rows_of_monitor_are_read() {
        let export = csv("time,gauge,pressure_pa,quality\n\
            2026-11-22T10:00:01.500000Z,chamber,2e-3,valid\n2026-11-22T10:00:02Z,\"a, b\",,missing\n")
        .unwrap();
        let [sample] = export["chamber"][..] else { panic!("{export:?}") };
        assert_eq!((sample.pa, sample.at.0 % 1_000_000), (Some(2e-3), 500_000));
        assert_eq!(export.len(), 1);
        let monitor = csv("unix_time,address,device,pressure,unit,mbar,instance,state,remarks,exchanges,lost,quality,limit_mbar,inputs\n\
            1.500,5,bcg450,5e-6,mbar,5e-6,2,DATA,\"device, warning\",1234,5,valid,,\n")
        .unwrap();
        let [sample] = monitor["5.2"][..] else { panic!("{monitor:?}") };
        assert!((sample.pa.unwrap() / 5e-4 - 1.0).abs() < 1e-9 && sample.at.0 == 1_500_000);
    }

    #[test]
    fn a_wrong_file_is_refused_with_its_line() {
        let heading = "time,gauge,pressure_pa,quality\n";
        for (text, expected) in [
            (String::new(), "1: expected a heading, found an empty file"),
            ("a,b\n".to_owned(), "1: expected the columns of an export"),
            (format!("{heading}noon,x,1,valid\n"), "2: expected a time, found \"noon\""),
            (format!("{heading}2026-11-22T10:00:00Z,x,-1,valid\n"), "2: expected a pressure above 0, found \"-1\""),
            (format!("{heading}2026-11-22T10:00:00Z,x\n"), "2: expected at least 4 fields, found 2"),
            ("unix_time,address,mbar,quality\nnan,5,1,valid\n".to_owned(), "2: expected a time, found \"nan\""),
            ("unix_time,address,mbar,quality\n1e300,5,1,valid\n".to_owned(), "2: expected a time, found \"1e300\""),
            ("quality,mbar,address,unix_time\nvalid,1,5\n".to_owned(), "2: expected at least 4 fields, found 3"),
        ] {
            let error = csv(&text).unwrap_err().to_string();
            assert!(error.starts_with(expected), "{error}");
        }
    }
}
