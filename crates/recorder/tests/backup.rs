//! A copy of a database while a recorder writes to it.

#![allow(clippy::unwrap_used, clippy::panic, clippy::indexing_slicing, reason = "a test")]

use crate::common::keep_everything;
use profivac_recorder::backup::{BackupError, Existing};
use profivac_recorder::{Micros, Quality, Reader, Recorder, Sample};
use std::fs;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use tempfile::TempDir;

/// 2026-01-01.
const NEW_YEAR: i64 = 1_767_225_600 * Micros::SECOND;

/// Samples that take more than one step to copy.
const MANY: i64 = 100_000;

/// A recorder that keeps every sample, and its folder.
struct Station {
    folder: TempDir,
    recorder: Recorder,
}

impl Station {
    fn new() -> Self {
        let folder = tempfile::tempdir().unwrap();
        let recorder = Recorder::start(&folder.path().join("plant.db"), keep_everything()).unwrap();
        Self { folder, recorder }
    }

    fn path(&self, name: &str) -> PathBuf {
        self.folder.path().join(name)
    }

    fn reader(&self) -> Reader {
        Reader::open(&self.path("plant.db")).unwrap()
    }

    /// Records one sample for each second, and waits until they are in the database.
    fn record(&self, seconds: std::ops::Range<i64>) {
        let gauge: Arc<str> = Arc::from("chamber");
        for second in seconds {
            self.recorder.push(&gauge, sample(second));
            // The recorder's queue is bounded.
            assert!(second % 1_000 != 0 || self.recorder.flush());
        }
        assert!(self.recorder.flush());
    }

    /// The names of all files, in order.
    fn files(&self) -> Vec<String> {
        let names = fs::read_dir(self.folder.path()).unwrap().map(|file| file.unwrap().file_name());
        let mut names: Vec<_> = names.map(|name| name.into_string().unwrap()).collect();
        names.retain(|name| !name.starts_with("plant.db"));
        names.sort();
        names
    }
}

fn sample(second: i64) -> Sample {
    Sample::new(Micros(NEW_YEAR + second * Micros::SECOND), Some(1e-6 * (1.0 + second as f64)), Quality::Valid)
}

fn samples(path: &Path) -> Vec<Sample> {
    Reader::open(path).unwrap().samples("chamber", Micros(0), Micros(i64::MAX)).unwrap()
}

#[test]
fn a_copy_has_everything_that_was_recorded_before_and_nothing_that_is_recorded_meanwhile() {
    let station = Station::new();
    station.record(0..MANY);
    let mut steps = Vec::new();
    let to = station.path("copy.db");
    let copied = station.reader().backup(&to, Existing::Keep, |done, all| {
        let next = MANY + steps.len() as i64;
        station.record(next..next + 1);
        steps.push((done, all));
    });
    copied.unwrap();
    let copy = samples(&to);
    assert_eq!(copy.len(), MANY as usize);
    assert!(copy.iter().enumerate().all(|(second, found)| *found == sample(second as i64)));
    assert_eq!(samples(&station.path("plant.db")).len(), copy.len() + steps.len());
    assert!(steps.len() > 2, "{steps:?}");
    assert!(steps.windows(2).all(|pair| pair[0].0 < pair[1].0), "each step copies more: {steps:?}");
    assert!(steps.last().is_some_and(|(done, all)| done == all), "{steps:?}");
    assert_eq!(station.files(), ["copy.db"], "a copy is one file");
}

#[test]
fn a_station_continues_in_a_copy() {
    let station = Station::new();
    station.record(0..10);
    let to = station.path("copy.db");
    station.reader().backup(&to, Existing::Keep, |_, _| ()).unwrap();
    let recorder = Recorder::start(&to, keep_everything()).unwrap();
    recorder.push(&Arc::from("chamber"), sample(10));
    assert!(recorder.flush());
    assert_eq!(samples(&to), (0..=10).map(sample).collect::<Vec<_>>());
}

#[test]
fn an_existing_file_stays_unless_it_is_to_be_replaced() {
    let station = Station::new();
    station.record(0..10);
    let to = station.path("copy.db");
    fs::write(&to, "mine").unwrap();
    let kept = station.reader().backup(&to, Existing::Keep, |_, _| ()).unwrap_err();
    assert!(matches!(kept, BackupError::Exists(_)), "{kept}");
    assert_eq!(fs::read(&to).unwrap(), b"mine");
    station.reader().backup(&to, Existing::Replace, |_, _| ()).unwrap();
    assert_eq!(samples(&to).len(), 10);
    assert_eq!(station.files(), ["copy.db"]);
}

#[test]
fn the_database_is_not_replaced_by_its_copy() {
    let station = Station::new();
    station.record(0..10);
    let link = station.path("link.db");
    std::os::unix::fs::symlink(station.path("plant.db"), &link).unwrap();
    for to in [station.path("plant.db"), link] {
        let refused = station.reader().backup(&to, Existing::Replace, |_, _| ()).unwrap_err();
        assert!(matches!(refused, BackupError::Itself(_)), "{refused}");
    }
    assert_eq!(samples(&station.path("plant.db")).len(), 10);
}

#[test]
fn a_copy_that_fails_leaves_nothing() {
    let station = Station::new();
    station.record(0..10);
    fs::create_dir(station.path("folder")).unwrap();
    fs::write(station.path("folder/file"), "").unwrap();
    let into_folder = station.reader().backup(&station.path("folder"), Existing::Replace, |_, _| ()).unwrap_err();
    assert!(matches!(into_folder, BackupError::File { .. }), "{into_folder}");
    let absent = station.reader().backup(&station.path("absent/copy.db"), Existing::Keep, |_, _| ()).unwrap_err();
    assert!(absent.to_string().contains("absent/copy.db"), "{absent}");
    assert_eq!(station.files(), ["folder"]);
}
