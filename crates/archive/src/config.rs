//! The file of an archive.
//!
//! ```toml
//! [archive]
//! samples-days = 730            # how long samples are kept; spans, events, alarms and audit stay
//! replicas = 3                  # of the stream: the number of servers that hold each batch
//! stream-octets = 10_000_000_000
//!
//! [nats]
//! servers = ["tls://nats-1.example", "tls://nats-2.example", "tls://nats-3.example"]
//! credentials = "nats.credentials"
//!
//! [postgres]
//! connection = "host=db.example user=profivac dbname=profivac"
//! password-file = "postgres.password"
//! ca-file = "our-ca.pem"        # trusted in addition to the certificates of the system
//!
//! [[plant]]
//! name = "hall"
//! readers = ["hall_operators"]  # roles of PostgreSQL that may read the stations of this plant
//! ```

use crate::database::{Database, DatabaseProblem, PostgresToml};
use profivac_host::text_file::{self, line_and_column};
use profivac_station::config::gateways::archive::{Nats, NatsToml};
use serde::Deserialize;
use std::path::{Path, PathBuf};
use thiserror::Error;

/// How long samples are kept, unless the file says otherwise.
const SAMPLES_DAYS: u32 = 730;

/// The most octets of the stream, unless the file says otherwise: 10 GB.
const STREAM_OCTETS: u64 = 10_000_000_000;

/// The least octets of the stream: some batches of the largest size. free choice.
const LEAST_STREAM_OCTETS: i64 = 10_000_000;

/// The settings of an archive.
#[derive(Clone, Debug)]
pub struct Config {
    /// How many days samples are kept.
    pub samples_days: u32,
    /// The number of servers that hold each batch.
    pub replicas: usize,
    /// The most octets of the stream: when it is full, batches stay at their stations.
    pub stream_octets: i64,
    /// The servers of NATS.
    pub nats: Nats,
    /// The database.
    pub database: Database,
    /// Plants, with the roles that may read them.
    pub plants: Vec<(String, Vec<String>)>,
}

/// The reason why a file is no file of an archive.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum ConfigError {
    /// The file cannot be read.
    #[error("{file} cannot be read: {error}", file = file.display())]
    Read {
        /// The file.
        file: PathBuf,
        /// The error of the system.
        error: std::io::Error,
    },
    /// A place of the file is wrong.
    #[error("{file}:{line}:{column}: {message}", file = file.display())]
    Place {
        /// The file.
        file: PathBuf,
        /// The line, from 1.
        line: usize,
        /// The column, from 1.
        column: usize,
        /// The fault.
        message: String,
    },
    /// `[postgres]` is wrong.
    #[error("{file}: {problem}", file = file.display())]
    Database {
        /// The file.
        file: PathBuf,
        /// The fault.
        problem: DatabaseProblem,
    },
    /// A value is out of range.
    #[error("{file}: {problem}", file = file.display())]
    Value {
        /// The file.
        file: PathBuf,
        /// The fault.
        problem: ValueProblem,
    },
}

/// A number in `[archive]` that is out of range.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Error)]
#[non_exhaustive]
pub enum ValueProblem {
    /// `replicas`.
    #[error("expected replicas = 1, 3 or 5, found {0}")]
    Replicas(u8),
    /// `samples-days`.
    #[error("expected samples-days from 1 to 36525, found {0}")]
    SamplesDays(u32),
    /// `stream-octets`.
    #[error("expected stream-octets of at least 10000000, found {0}")]
    StreamOctets(u64),
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct Toml {
    #[serde(default)]
    archive: ArchiveToml,
    nats: NatsToml,
    postgres: PostgresToml,
    #[serde(default)]
    plant: Vec<PlantToml>,
}

#[derive(Debug, Default, Deserialize)]
#[serde(deny_unknown_fields, rename_all = "kebab-case")]
struct ArchiveToml {
    samples_days: Option<u32>,
    replicas: Option<u8>,
    stream_octets: Option<u64>,
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct PlantToml {
    name: String,
    readers: Vec<String>,
}

impl Config {
    /// Reads a file and the files that it names.
    ///
    /// # Errors
    /// [`ConfigError`] with the place and what is expected there.
    pub fn read(file: &Path) -> Result<Self, ConfigError> {
        let text = text_file::read(file).map_err(|error| ConfigError::Read { file: file.to_owned(), error })?;
        let place = |offset: usize, message: String| {
            let (line, column) = line_and_column(&text, offset);
            ConfigError::Place { file: file.to_owned(), line, column, message }
        };
        let toml: Toml = toml::from_str(&text)
            .map_err(|error| place(error.span().map_or(0, |span| span.start), error.message().to_owned()))?;
        let folder = file.parent().unwrap_or(Path::new(""));
        let wrong = |problem| ConfigError::Value { file: file.to_owned(), problem };
        let nats = toml.nats.into_settings(file, 0..0);
        let nats = nats.map_err(|error| place(error.span.start, error.problem.to_string()))?;
        let ArchiveToml { samples_days, replicas, stream_octets } = toml.archive;
        let replicas = replicas.unwrap_or(1);
        if ![1, 3, 5].contains(&replicas) {
            return Err(wrong(ValueProblem::Replicas(replicas)));
        }
        let samples_days = samples_days.unwrap_or(SAMPLES_DAYS);
        if !(1..=36_525).contains(&samples_days) {
            return Err(wrong(ValueProblem::SamplesDays(samples_days)));
        }
        let found = stream_octets.unwrap_or(STREAM_OCTETS);
        let stream_octets = i64::try_from(found).ok().filter(|octets| *octets >= LEAST_STREAM_OCTETS);
        let stream_octets = stream_octets.ok_or_else(|| wrong(ValueProblem::StreamOctets(found)))?;
        Ok(Self {
            samples_days,
            replicas: usize::from(replicas),
            stream_octets,
            nats,
            database: Database::new(&toml.postgres, folder)
                .map_err(|problem| ConfigError::Database { file: file.to_owned(), problem })?,
            plants: toml.plant.into_iter().map(|plant| (plant.name, plant.readers)).collect(),
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn read(text: &str) -> Result<Config, String> {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("archive.toml");
        std::fs::write(&path, text).unwrap();
        Config::read(&path).map_err(|error| error.to_string())
    }

    const NATS: &str = "[nats]\nservers = [\"nats://127.0.0.1\"]\n";
    const POSTGRES: &str = "[postgres]\nconnection = \"host=/run/postgresql dbname=p\"\n";

    #[test]
    fn the_defaults_need_two_tables() {
        let config = read(&format!("{NATS}{POSTGRES}")).unwrap();
        assert_eq!((config.samples_days, config.replicas, config.stream_octets), (730, 1, 10_000_000_000));
    }

    #[test]
    fn a_wrong_file_says_where_and_what_is_expected() {
        let cases = [
            (format!("{NATS}{POSTGRES}[archive]\nreplicas = 2\n"), "expected replicas = 1, 3 or 5, found 2"),
            (format!("{NATS}{POSTGRES}[archive]\nsamples-days = 0\n"), "expected samples-days from 1"),
            (
                format!("{NATS}{POSTGRES}[archive]\nstream-octets = 7\n"),
                "expected stream-octets of at least 10000000, found 7",
            ),
            (format!("{NATS}{POSTGRES}[archive]\nsample-days = 7\n"), "archive.toml:6:1: unknown field"),
            (
                format!("{NATS}[postgres]\nconnection = \"host=db.example sslmode=disable\"\n"),
                "the database is on another computer",
            ),
            (
                format!("{NATS}[postgres]\nconnection = \"hostaddr=192.0.2.1 sslmode=disable\"\n"),
                "the database is on another computer",
            ),
            (
                format!("{NATS}[postgres]\nconnection = \"host=localhost hostaddr=192.0.2.1 sslmode=disable\"\n"),
                "the database is on another computer",
            ),
            (
                format!("{NATS}[postgres]\nconnection = \"host=db.example\"\nca-file = \"absent\"\n"),
                "absent cannot be read",
            ),
            (format!("{NATS}[postgres]\nconnection = \"host=/x password=y\"\n"), "put it into a file"),
            (format!("{NATS}[postgres]\nconnection = \"hostess=/x\"\n"), "expected connection ="),
            (format!("[nats]\nservers = [\"nats://far\"]\n{POSTGRES}"), "archive.toml:2:12: expected tls://"),
        ];
        for (text, expected) in cases {
            let error = read(&text).unwrap_err();
            assert!(error.contains(expected), "{error}\nexpected {expected}");
        }
    }
}
