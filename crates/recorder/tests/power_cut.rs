//! A process that records is killed a hundred times at random: the database stays consistent and loses no acknowledged event.

#![allow(clippy::unwrap_used, clippy::panic, reason = "a test")]

use profivac_recorder::{Event, EventKind, Micros, Quality, Reader, Recorder, Sample, Settings};
use std::io::{BufRead, BufReader, Write};
use std::path::Path;
use std::process::{Command, Stdio};
use std::sync::Arc;

/// The environment variable that tells the child process its database.
const DATABASE: &str = "PROFIVAC_TEST_RECORD_INTO";

const BEGIN: i64 = 1_767_225_600 * Micros::SECOND;

/// The child process: records a sample and an event, and prints a line when the event is acknowledged.
#[test]
fn child_records_until_it_is_killed() {
    let Some(path) = std::env::var_os(DATABASE) else { return };
    let recorder = Recorder::start(Path::new(&path), Settings::default()).unwrap();
    let gauge: Arc<str> = Arc::from("chamber");
    let begin = count(Path::new(&path)) as i64;
    for number in begin.. {
        let at = Micros(BEGIN + number * Micros::SECOND);
        // Each pressure is outside the deadband of the one before.
        recorder.push(&gauge, Sample::new(at, Some(10_f64.powi((number % 10) as i32)), Quality::Valid));
        let event = Event { at, gauge: None, kind: EventKind::Note.into(), text: number.to_string() };
        assert!(recorder.record_event_and_wait(event));
        println!("acknowledged {number}");
        std::io::stdout().flush().unwrap();
    }
}

fn count(path: &Path) -> usize {
    Reader::open(path).unwrap().events(Micros(0), Micros(i64::MAX), u32::MAX).unwrap().len()
}

#[test]
fn a_hundred_kills_lose_no_acknowledged_event() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("plant.db");
    drop(Recorder::start(&path, Settings::default()).unwrap());
    let mut random = fastrand::Rng::with_seed(10);
    for _ in 0..100 {
        let acknowledged = kill_after(random.usize(1..30), random.usize(0..20_000), &path);
        let connection = rusqlite::Connection::open(&path).unwrap();
        let check: String = connection.query_row("PRAGMA integrity_check", [], |row| row.get(0)).unwrap();
        assert_eq!(check, "ok");
        let reader = Reader::open(&path).unwrap();
        let last = Micros(BEGIN + acknowledged * Micros::SECOND);
        let samples = reader.samples("chamber", Micros(0), last).unwrap();
        assert_eq!(samples.len() as i64, acknowledged + 1, "one sample per event");
        let events = reader.events(Micros(0), last, u32::MAX).unwrap();
        assert_eq!(events.len() as i64, acknowledged + 1, "every acknowledged event");
    }
}

/// Lets the child acknowledge `lines` events, spins `spins` times and kills it. Returns the number of the last acknowledged event.
fn kill_after(lines: usize, spins: usize, path: &Path) -> i64 {
    let mut child = Command::new(std::env::current_exe().unwrap())
        .args(["power_cut::child_records_until_it_is_killed", "--exact", "--nocapture"])
        .env(DATABASE, path)
        .stdout(Stdio::piped())
        .stderr(Stdio::null())
        .spawn()
        .unwrap();
    let mut output = BufReader::new(child.stdout.take().unwrap()).lines();
    let number_in = |line: &str| line.strip_prefix("acknowledged ").and_then(|number| number.parse::<i64>().ok());
    let mut last =
        output.by_ref().map_while(Result::ok).filter_map(|line| number_in(&line)).take(lines).last().unwrap();
    (0..spins).for_each(|_| std::hint::spin_loop());
    child.kill().unwrap();
    child.wait().unwrap();
    // Lines printed before the kill count too.
    for line in output.map_while(Result::ok) {
        last = number_in(&line).unwrap_or(last);
    }
    last
}
