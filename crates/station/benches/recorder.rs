//! The cost of recording, and the time to read a year for a trend: `cargo bench -p profivac-station`.
//!
//! The year is written once and takes minutes and gigabytes: PROFIVAC_BENCH_SAMPLES sets the number of samples (by
//! default a hundred million, one every 0.3 s).

#![allow(clippy::unwrap_used, reason = "a benchmark")]

use profivac_recorder::alarms::AlarmBatch;
use profivac_recorder::database::Database;
use profivac_recorder::spans::PendingSpans;
use profivac_recorder::{Micros, Quality, Reader, Recorder, Sample, Settings};
use std::fs;
use std::path::Path;
use std::sync::Arc;
use std::time::{Duration, Instant};

const BEGIN: i64 = 1_767_225_600 * Micros::SECOND;
const YEAR: i64 = 365 * 86_400 * Micros::SECOND;

fn main() {
    let folder = tempfile::tempdir().unwrap();
    recording(&folder.path().join("recording.db"));
    drawing(&folder.path().join("year.db"));
}

/// 125 gauges at 50 Hz, with typical noise.
fn recording(path: &Path) {
    const GAUGES: usize = 125;
    const RATE: i64 = 50;
    const SECONDS: i64 = 20;
    let gauges: Vec<Arc<str>> = (0..GAUGES).map(|number| Arc::from(format!("gauge {number}"))).collect();
    let mut random = fastrand::Rng::with_seed(1);
    let recorder = Recorder::start(path, Settings::default()).unwrap();
    let before = processor_time();
    let begun = Instant::now();
    for tick in 0..SECONDS * RATE {
        let at = Micros(BEGIN + tick * Micros::SECOND / RATE);
        for gauge in &gauges {
            let pa = 1e-4 * (1.0 + 0.01 * random.f64());
            recorder.push(gauge, Sample::new(at, Some(pa), Quality::Valid));
        }
        let due = Duration::from_millis((tick * 1000 / RATE).unsigned_abs());
        std::thread::sleep(due.saturating_sub(begun.elapsed()));
    }
    assert!(recorder.flush());
    let share = (processor_time() - before).as_secs_f64() / begun.elapsed().as_secs_f64();
    let lost = recorder.health().lost_samples;
    println!("125 gauges at 50 Hz: {:.1} % of a core, {lost} lost (to reach: 20 %)", share * 100.0);
}

/// A year of one gauge at 2000 pixels, and pieces of it.
fn drawing(path: &Path) {
    let count = std::env::var("PROFIVAC_BENCH_SAMPLES").ok().and_then(|text| text.parse().ok()).unwrap_or(100_000_000);
    let mut store = Database::open(path, Micros(BEGIN)).unwrap();
    let gauge = store.series_index("chamber");
    let mut random = fastrand::Rng::with_seed(1);
    let begun = Instant::now();
    let (mut samples, mut additions) = (Vec::new(), PendingSpans::default());
    for number in 0..count {
        let at = Micros(BEGIN + (i128::from(number) * i128::from(YEAR) / i128::from(count)) as i64);
        let sample = Sample::new(at, Some(1e-4 * (1.0 + random.f64())), Quality::Valid);
        samples.push((gauge, sample));
        additions.add(gauge, &sample);
        if samples.len() == 100_000 || number + 1 == count {
            store.write(&samples, &additions, &[], &AlarmBatch::default()).unwrap();
            samples.clear();
            additions.clear();
        }
    }
    let size = fs::metadata(path).unwrap().len() / 1_000_000;
    println!("{count} samples written in {:.0} s, {size} MB", begun.elapsed().as_secs_f64());
    let reader = Reader::open(path).unwrap();
    for (name, part) in [("a year", 1), ("a month", 12), ("a day", 365), ("an hour", 8760)] {
        let begun = Instant::now();
        let bins = reader.trend("chamber", Micros(BEGIN), Micros(BEGIN + YEAR / part), 2000).unwrap();
        println!("{name} in {} bins: {:.1} ms (to reach: 100 ms)", bins.len(), begun.elapsed().as_secs_f64() * 1e3);
    }
}

/// The processor time of this process, in user and system mode.
fn processor_time() -> Duration {
    let stat = fs::read_to_string("/proc/self/stat").unwrap();
    let fields: Vec<_> = stat.rsplit(')').next().unwrap().split_whitespace().collect();
    // Fields 14 and 15 of proc(5), in clock ticks of 10 ms; two precede the bracket.
    let ticks: u64 = fields[11].parse::<u64>().unwrap() + fields[12].parse::<u64>().unwrap();
    Duration::from_millis(ticks * 10)
}
