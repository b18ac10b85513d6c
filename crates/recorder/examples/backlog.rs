//! Makes the database of a station that was without a network for days: its recorder ran with a clock of these days, and the outbox has
//! a batch for each second of them, up to the present.
//!
//! ```text
//! cargo run --release -p profivac-recorder --example backlog -- record.db 7 chamber foreline
//! ```
//!
//! Each series has a sample a second. Prints the number of batches that wait. `contrib/archive/cases.py` lets a station send them.

use profivac_recorder::clock::ClockTime;
use profivac_recorder::{Clock, Forward, Micros, Quality, Recorder, Sample, Settings};
use std::error::Error;
use std::path::PathBuf;
use std::sync::Arc;
use std::sync::atomic::{AtomicI64, Ordering};
use std::time::{Duration, Instant};

const DAY_S: i64 = 86_400;

/// A clock that is set forward second by second.
struct Steps {
    begin: ClockTime,
    seconds: AtomicI64,
}

impl Clock for Steps {
    fn now(&self) -> ClockTime {
        let seconds = self.seconds.load(Ordering::SeqCst);
        let monotonic = self.begin.monotonic + Duration::from_secs(seconds.unsigned_abs());
        ClockTime { monotonic, wall: Micros(self.begin.wall.0 + seconds * Micros::SECOND) }
    }
}

fn main() -> Result<(), Box<dyn Error>> {
    let mut arguments = std::env::args_os().skip(1);
    let path = PathBuf::from(arguments.next().ok_or("expected a new database: backlog FILE DAYS SERIES...")?);
    if path.exists() {
        return Err(format!("{} exists: name a file that does not", path.display()).into());
    }
    let days: i64 = arguments.next().and_then(|text| text.to_str()?.parse().ok()).ok_or("expected a number of days")?;
    let series: Vec<Arc<str>> = arguments.map(|name| Arc::from(name.to_string_lossy())).collect();
    let seconds = days * DAY_S;
    let begin = Micros(Micros::now().0 - seconds * Micros::SECOND);
    let begin = ClockTime { monotonic: Instant::now(), wall: begin };
    let clock = Arc::new(Steps { begin, seconds: AtomicI64::new(0) });
    let settings = Settings { outbox: Some(Forward::All), ..Settings::default() };
    let recorder = Recorder::start_with_clock(&path, settings, Arc::clone(&clock) as Arc<dyn Clock>)?;
    for second in 0..seconds {
        clock.seconds.store(second, Ordering::SeqCst);
        // Each pressure is outside the deadband of the one before.
        let pressure = if second % 2 == 0 { 1.0e-3 } else { 2.0e-3 };
        for name in &series {
            recorder.push(name, Sample::new(clock.now().wall, Some(pressure), Quality::Valid));
        }
        if !recorder.flush() {
            return Err("the disk has not answered for ten seconds".into());
        }
    }
    if recorder.finish().is_err() {
        return Err("the disk has not answered for ten seconds".into());
    }
    println!("{seconds}");
    Ok(())
}
