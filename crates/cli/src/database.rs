//! The database of a station on the command line: its file, or the station's file that names it.

use crate::failure::Failure;
use jiff::{Timestamp, Zoned};
use profivac_client::suggestion::closest;
use profivac_recorder::{DatabaseError, DescribedPoint, Micros, Point, Reader};
use profivac_station::config::Config;
use std::path::{Path, PathBuf};

/// An open database, and the station's file if it was given.
pub struct Database {
    pub reader: Reader,
    pub path: PathBuf,
    pub config: Option<Config>,
}

impl Database {
    /// Opens the database of a station for reading. The station may continue to record.
    pub fn open(given: &Path) -> Result<Self, Failure> {
        let is_file = given.extension().is_some_and(|extension| extension.eq_ignore_ascii_case("toml"));
        let config = is_file.then(|| profivac_config::read(given)).transpose()?;
        let path = config.as_ref().map_or_else(|| given.to_path_buf(), |config| config.database.clone());
        if !path.exists() {
            let hint = if is_file { format!("; `profivac run {}` makes it", given.display()) } else { String::new() };
            return Err(Failure::usage(format!("{} does not exist{hint}", path.display())));
        }
        Ok(Self { config, ..Self::open_database(&path)? })
    }

    /// Opens a database without its station's file.
    pub fn open_database(path: &Path) -> Result<Self, Failure> {
        let reader = Reader::open(path).map_err(|error| not_a_database(error, path))?;
        Ok(Self { reader, path: path.to_path_buf(), config: None })
    }

    /// The series that `--gauge` selects, or all of them.
    pub fn series(&self, asked: &[String]) -> Result<Vec<String>, Failure> {
        let all = self.reader.series_names()?;
        if asked.is_empty() { Ok(all) } else { matching_series(asked, &all, &self.path) }
    }

    /// The points that `--point` selects, or all of them; the name of a slave selects all its points. The texts of codes are those of the
    /// station's file, if it was given.
    pub fn points(&self, asked: &[String]) -> Result<Vec<DescribedPoint>, Failure> {
        let all = self.reader.points()?;
        let is_asked = |name: &String, point: &Point| *name == point.to_string() || *name == point.slave;
        if let Some(unknown) = asked.iter().find(|name| !all.iter().any(|point| is_asked(name, point))) {
            let known: Vec<_> = all.iter().map(ToString::to_string).collect();
            let hint = match closest(unknown, known.iter().map(String::as_str)) {
                Some(like) => format!("did you mean {like:?}?"),
                None if known.is_empty() => "it has no points of slaves".to_owned(),
                None => format!("known: {}", known.join(", ")),
            };
            return Err(Failure::usage(format!("{} has no point {unknown:?}; {hint}", self.path.display())));
        }
        let is_chosen = |point: &Point| asked.is_empty() || asked.iter().any(|name| is_asked(name, point));
        let directory = self.config.as_ref().map(|config| config.directory.clone()).unwrap_or_default();
        Ok(all.into_iter().filter(is_chosen).map(|point| directory.described(point)).collect())
    }

    /// The name that is no gauge and would select points.
    pub fn point_as_gauge<'n>(&self, asked: &'n [String]) -> Result<Option<&'n String>, Failure> {
        let (series, points) = (self.reader.series_names()?, self.reader.points()?);
        let is_point = |name: &&String| points.iter().any(|point| **name == point.to_string() || **name == point.slave);
        Ok(asked.iter().filter(|name| !series.contains(name)).find(is_point))
    }
}

/// The series that --gauge selects; the name of a controller selects all its channels.
fn matching_series(asked: &[String], all: &[String], path: &Path) -> Result<Vec<String>, Failure> {
    let mut chosen: Vec<String> = Vec::new();
    for name in asked {
        let is_channel =
            |series: &&String| series.strip_prefix(name.as_str()).is_some_and(|rest| rest.starts_with('.'));
        let mut found: Vec<&String> = all.iter().filter(|series| *series == name).collect();
        if found.is_empty() {
            found = all.iter().filter(is_channel).collect();
        }
        if found.is_empty() {
            let hint = match closest(name, all.iter().map(String::as_str)) {
                Some(like) => format!("did you mean {like:?}?"),
                None => format!("known: {}", all.join(", ")),
            };
            return Err(Failure::usage(format!("{} has no gauge {name:?}; {hint}", path.display())));
        }
        for name in found {
            if !chosen.contains(name) {
                chosen.push(name.clone());
            }
        }
    }
    Ok(chosen)
}

/// The failure for a file that is not a station's database.
fn not_a_database(error: DatabaseError, path: &Path) -> Failure {
    let is = |what: &str| Failure::usage(format!("{} is not a database of a station: {what}", path.display()));
    match error {
        DatabaseError::Version { found: 0, .. } => is("it has none of its tables"),
        DatabaseError::Sql { error, .. } => is(&error.to_string()),
        other => other.into(),
    }
}

/// A time on the command line, if it was given.
pub fn time(text: Option<&str>, now: &Zoned) -> Result<Option<Micros>, Failure> {
    Ok(text.map(|text| crate::time_argument::parse_time(text, now)).transpose()?.map(micros))
}

/// A time in the database.
pub fn micros(at: Timestamp) -> Micros {
    Micros(at.as_microsecond())
}

impl From<DatabaseError> for Failure {
    fn from(error: DatabaseError) -> Self {
        Self::usage(error.to_string())
    }
}
