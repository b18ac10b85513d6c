//! Reports pump-downs that deviate from the usual ones as events, one for each pump-down of each series.

use super::recorded::{Recorded, recorded};
use super::words::{likeness, sentence};
use crate::pumpdown::compare::{Run, compare};
use crate::pumpdown::{PumpDown, TimeRange};
use crate::recording::RecorderHandle;
use crate::report::series::pump_downs_in;
use jiff::tz::TimeZone;
use profivac_recorder::{DatabaseError, EventKind, Micros, Reader};
use std::collections::HashMap;
use std::sync::Arc;
use std::sync::mpsc::{Receiver, RecvTimeoutError, Sender, channel};
use std::thread::JoinHandle;
use std::time::Duration;

/// The time between two looks. chosen: a deviation of minutes is told within a minute.
const PERIOD: Duration = Duration::from_secs(60);

/// A pump-down is found if it began within this time before a look, in s. chosen
const FOUND_WITHIN_S: i64 = 2 * 3600;

/// The usual pump-downs are searched so far back, in s: 90 days. chosen
const USUAL_WITHIN_S: i64 = 90 * 86_400;

/// A pump-down is compared for this time, in s: a week. chosen
const COMPARED_FOR_S: f64 = 7.0 * 86_400.0;

/// The length of the spans in which a new pump-down is searched, in s; the longer ones for a week.
const WIDTH_S: i64 = 10;
const LONG_WIDTH_S: i64 = 120;

/// Two beginnings this near are those of the same pump-down, in µs: a later sample may move the top.
const SAME_START_US: u64 = 120 * Micros::SECOND as u64;

/// The next look at a running pump-down comes after this part of its age: reading it takes the longer, the older it is.
const AGE_PART: f64 = 0.02;

/// The most events that are searched for a report from before a restart.
const MOST_EVENTS: u32 = 1000;

/// A running pump-down of a series.
#[derive(Debug)]
struct Active {
    start: Micros,
    /// The pump-downs before it.
    past: Vec<Run>,
    /// It was reported.
    is_done: bool,
    next_look: Micros,
}

/// The running pump-downs of all series.
#[derive(Debug, Default)]
pub struct Watch {
    active: HashMap<String, Active>,
}

/// A deviation to report.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Deviation {
    /// The series.
    pub series: String,
    /// A sentence.
    pub text: String,
}

impl Watch {
    /// Looks at all series.
    ///
    /// # Errors
    /// [`DatabaseError`] when the database cannot be read.
    pub fn look(&mut self, reader: &Reader, now: Micros, zone: &TimeZone) -> Result<Vec<Deviation>, DatabaseError> {
        let mut deviations = Vec::new();
        for series in reader.series_names()? {
            if let Some(text) = self.look_at(reader, &series, now, zone)? {
                deviations.push(Deviation { series, text });
            }
        }
        Ok(deviations)
    }

    fn look_at(
        &mut self,
        reader: &Reader,
        series: &str,
        now: Micros,
        zone: &TimeZone,
    ) -> Result<Option<String>, DatabaseError> {
        let known = self.active.get(series);
        if known.is_some_and(|active| now < active.next_look) {
            return Ok(None);
        }
        let Some(one) = running(reader, series, known.map(|active| active.start), now)? else {
            self.active.remove(series);
            return Ok(None);
        };
        let is_same = |active: &&mut Active| active.start.0.abs_diff(one.span.start.0) < SAME_START_US;
        let active = match self.active.get_mut(series).filter(is_same) {
            Some(active) => active,
            None => self
                .active
                .entry(series.to_owned())
                .insert_entry(begun(reader, series, one.span.start, now)?)
                .into_mut(),
        };
        let age_us = (one.span.seconds() * AGE_PART * Micros::SECOND as f64) as i64;
        active.next_look = Micros(now.0.saturating_add(age_us));
        if active.is_done || active.past.is_empty() {
            return Ok(None);
        }
        let own = Recorded::read(reader, series, &one)?;
        let runs: Vec<Run> = active.past.iter().chain([&own.run]).cloned().collect();
        let compared = compare(&runs);
        let text =
            compared.last().and_then(|last| Some(format!("{}: {}", sentence(last, zone)?, likeness(last, None)?)));
        active.is_done = text.is_some();
        Ok(text)
    }
}

/// The running pump-down of a series: not vented, and younger than a week.
fn running(
    reader: &Reader,
    series: &str,
    known: Option<Micros>,
    now: Micros,
) -> Result<Option<PumpDown>, DatabaseError> {
    let ranges = match known {
        Some(start) => vec![(before(start, 600), WIDTH_S)],
        None => vec![(before(now, FOUND_WITHIN_S), WIDTH_S), (before(now, COMPARED_FOR_S as i64), LONG_WIDTH_S)],
    };
    for (start, width) in ranges {
        let range = TimeRange { start, end: now };
        let found = pump_downs_in(reader, &[series.to_owned()], range, width)?;
        let Some(one) = found.last().copied() else { return Ok(None) };
        if one.is_vented || one.span.seconds() > COMPARED_FOR_S {
            return Ok(None);
        }
        // One at the beginning of the range may have begun before it.
        if one.span.start > before(start, -6 * width) {
            return Ok(Some(one));
        }
    }
    Ok(None)
}

fn before(at: Micros, seconds: i64) -> Micros {
    Micros(at.0.saturating_sub(seconds.saturating_mul(Micros::SECOND)))
}

/// A pump-down that was found: with the ones before it, and done if its deviation is already an event.
fn begun(reader: &Reader, series: &str, start: Micros, now: Micros) -> Result<Active, DatabaseError> {
    let events = reader.events(start, now, MOST_EVENTS)?;
    let is_done =
        events.iter().any(|event| event.kind == EventKind::PumpDown && event.gauge.as_deref() == Some(series));
    let range = TimeRange { start: before(start, USUAL_WITHIN_S), end: before(start, 1) };
    let past = if is_done { Vec::new() } else { recorded(reader, series, range)? };
    Ok(Active { start, past: past.into_iter().map(|one| one.run).collect(), is_done, next_look: now })
}

/// A running thread. It ends when this is dropped.
pub struct WatchThread {
    stop: Option<Sender<()>>,
    thread: Option<JoinHandle<()>>,
}

impl WatchThread {
    /// Starts to look.
    ///
    /// # Errors
    /// When the system gives no thread.
    pub fn start(recorder: Arc<RecorderHandle>) -> std::io::Result<Self> {
        let (stop, stopped) = channel();
        let thread = std::thread::Builder::new().name("pump-downs".to_owned());
        let thread = thread.spawn(move || run(&recorder, &stopped))?;
        Ok(Self { stop: Some(stop), thread: Some(thread) })
    }

    /// Whether the thread has ended, which only a defect can cause.
    #[must_use]
    pub fn has_ended(&self) -> bool {
        self.thread.as_ref().is_none_or(JoinHandle::is_finished)
    }
}

impl Drop for WatchThread {
    fn drop(&mut self) {
        self.stop = None;
        if let Some(thread) = self.thread.take() {
            thread.join().ok();
        }
    }
}

fn run(recorder: &RecorderHandle, stopped: &Receiver<()>) {
    let mut watch = Watch::default();
    while stopped.recv_timeout(PERIOD) == Err(RecvTimeoutError::Timeout) {
        // A database that cannot be read now is tried again; the recorder's health reports it.
        let look = recorder.open_reader().and_then(|reader| watch.look(&reader, Micros::now(), &TimeZone::system()));
        for Deviation { series, text } in look.unwrap_or_default() {
            recorder.event_now(Some(&series), EventKind::PumpDown, text);
        }
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, reason = "a test")]

    use super::*;
    use profivac_recorder::{Deadband, Event, Quality, Recorder, Retention, Sample, Settings};

    const DAY_S: i64 = 86_400;

    fn at(day: i64, second: i64) -> Micros {
        Micros((20_000 * DAY_S + day * DAY_S + second) * Micros::SECOND)
    }

    struct Plant {
        folder: tempfile::TempDir,
        recorder: Recorder,
    }

    impl Plant {
        fn new() -> Self {
            let folder = tempfile::tempdir().unwrap();
            let settings = Settings {
                deadband: Deadband { decades: 0.0, max_interval: Duration::ZERO },
                retention: Retention { samples: None, ..Retention::default() },
                ..Settings::default()
            };
            let recorder = Recorder::start(&folder.path().join("plant.db"), settings).unwrap();
            Self { folder, recorder }
        }

        /// A pump-down up to a second of a day, with this pressure of outgassing after an hour in Pa.
        fn pump(&self, day: i64, seconds: std::ops::Range<i64>, outgassing_pa: f64) {
            let mut second = seconds.start;
            while second < seconds.end {
                let s = second as f64;
                let pa =
                    if second < 0 { 1e5 } else { 1e5 * (-s / 20.0).exp() + outgassing_pa * 3600.0 / (s + 1.0) + 1e-6 };
                self.recorder.push(&Arc::from("lock"), Sample::new(at(day, second), Some(pa), Quality::Valid));
                second += 1.max(second / 100);
            }
            assert!(self.recorder.flush());
        }

        fn look(&self, watch: &mut Watch, now: Micros) -> Vec<Deviation> {
            let reader = Reader::open(&self.folder.path().join("plant.db")).unwrap();
            watch.look(&reader, now, &TimeZone::UTC).unwrap()
        }
    }

    #[test]
    fn a_late_pump_down_is_reported_once_as_soon_as_it_is_late_and_a_usual_one_never() {
        let plant = Plant::new();
        for day in 0..10 {
            plant.pump(day, -30..14_400, 1e-4);
        }
        let mut watch = Watch::default();
        assert_eq!(plant.look(&mut watch, at(9, 14_400)), [], "the last usual one");
        // Twice the outgassing: 1e-5 mbar after 720 s instead of 410 s.
        plant.pump(10, -30..600, 2e-4);
        let early = plant.look(&mut watch, at(10, 600));
        let [Deviation { series, text }] = early.as_slice() else { unreachable!("{early:?}") };
        assert_eq!(series, "lock");
        assert!(text.contains("1e-5 mbar not reached after 9 min") && text.contains("usual 6 min 50 s"), "{text}");
        assert!(text.contains("late at low pressure only"), "{text}");
        plant.pump(10, 600..14_400, 2e-4);
        assert_eq!(plant.look(&mut watch, at(10, 14_400)), [], "reported before");
        // After a restart the event tells that it was reported.
        let event = Event {
            at: at(10, 600),
            gauge: Some("lock".to_owned()),
            kind: EventKind::PumpDown.into(),
            text: text.clone(),
        };
        assert!(plant.recorder.record_event_and_wait(event));
        assert_eq!(plant.look(&mut Watch::default(), at(10, 5_000)), [], "reported before the restart");
        plant.pump(11, -30..7_200, 2e-4);
        let next = plant.look(&mut watch, at(11, 7_200));
        let text = &next.first().unwrap().text;
        // Day 20 010 since 1970.
        assert!(
            text.contains("1e-6 mbar not reached after 2 h") && text.contains("; since Monday, 2024-10-14"),
            "{text}"
        );
    }
}
