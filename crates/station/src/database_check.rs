//! Checks the whole database for damage once a day. The check goes on piece by piece, and waits while the recorder is busy.

use crate::recording::RecorderHandle;
use jiff::Timestamp;
use jiff::civil::Time;
use jiff::tz::TimeZone;
use profivac_recorder::check::GiveUp;
use profivac_recorder::{DatabaseError, EventKind, LastCheck, Micros};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{Receiver, RecvTimeoutError, Sender, channel};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

/// The time between two looks at the clock. chosen
const PERIOD: Duration = Duration::from_secs(60);

/// The pause while the recorder is busy. chosen: the recorder writes once a second.
const LOAD_PAUSE: Duration = Duration::from_secs(1);

/// The pause after a check that could not be made. chosen
const RETRY: Duration = Duration::from_secs(3600);

/// A running thread. It ends when this is dropped.
pub struct CheckThread {
    at: Option<Time>,
    stops: Arc<AtomicBool>,
    stop: Option<Sender<()>>,
    /// `None` if the file turns the check off.
    thread: Option<JoinHandle<()>>,
}

impl CheckThread {
    /// Starts to check at this time of the day, by the time zone of the computer; `None` never checks.
    ///
    /// # Errors
    /// When the system gives no thread.
    pub fn start(recorder: Arc<RecorderHandle>, at: Option<Time>) -> std::io::Result<Self> {
        let (stop, stopped) = channel();
        let stops = Arc::new(AtomicBool::new(false));
        let spawn = |at| {
            let daily = Daily { recorder, at, stops: Arc::clone(&stops), stopped };
            std::thread::Builder::new().name("database check".to_owned()).spawn(move || daily.run())
        };
        let thread = at.map(spawn).transpose()?;
        Ok(Self { at, stops, stop: Some(stop), thread })
    }

    /// The time of the day.
    #[must_use]
    pub const fn at(&self) -> Option<Time> {
        self.at
    }

    /// Whether the thread has ended, which only a defect can cause.
    #[must_use]
    pub fn has_ended(&self) -> bool {
        self.thread.as_ref().is_some_and(JoinHandle::is_finished)
    }
}

impl Drop for CheckThread {
    fn drop(&mut self) {
        self.stops.store(true, Ordering::Relaxed);
        self.stop = None;
        if let Some(thread) = self.thread.take() {
            thread.join().ok();
        }
    }
}

/// What is known about the next check.
struct Next {
    is_due: bool,
    /// Not before this time.
    retry_at: Instant,
    /// Why the last one could not be made, as the event says.
    problem: Option<String>,
}

impl Next {
    /// After a damage the operator has repaired the database, or restored a copy: it is checked at once.
    fn after_start(recorder: &RecorderHandle) -> Self {
        Self { is_due: recorder.damage().is_some(), retry_at: Instant::now(), problem: None }
    }
}

/// What the thread does.
struct Daily {
    recorder: Arc<RecorderHandle>,
    at: Time,
    stops: Arc<AtomicBool>,
    stopped: Receiver<()>,
}

impl Daily {
    fn run(self) {
        let (recorder, stops) = (Arc::clone(&self.recorder), Arc::clone(&self.stops));
        let give_up: GiveUp = Arc::new(move || stops.load(Ordering::Relaxed) || recorder.load().is_high());
        let mut next = Next::after_start(&self.recorder);
        while self.wait(PERIOD) && self.look(&mut next, &give_up) {}
    }

    /// Checks the database if it is time. Returns `false` when the station stops.
    fn look(&self, next: &mut Next, give_up: &GiveUp) -> bool {
        next.is_due |= self.is_due();
        if !next.is_due || Instant::now() < next.retry_at {
            return true;
        }
        match check(&self.recorder, give_up, |pause| self.wait(pause)) {
            Ok(Some(found)) => {
                report(&self.recorder, found);
                *next = Next { is_due: false, ..Next::after_start(&self.recorder) };
            }
            Ok(None) => return false,
            Err(error) => {
                let text =
                    format!("the database could not be checked for damage: {error}; it is tried again every hour");
                next.retry_at = Instant::now() + RETRY;
                if next.problem.replace(text.clone()).as_ref() != Some(&text) {
                    self.recorder.event_now(None, EventKind::Station, text);
                }
            }
        }
        true
    }

    /// Returns `false` when the station stops, at once.
    fn wait(&self, pause: Duration) -> bool {
        self.stopped.recv_timeout(pause) == Err(RecvTimeoutError::Timeout)
    }

    /// Whether the time of the day has passed since the last check, or since the station began to record.
    fn is_due(&self) -> bool {
        let last = self.recorder.last_check().map(|check| check.at);
        let since = last.or_else(|| self.recorder.open_reader().and_then(|reader| reader.recording_since()).ok()?);
        since.is_none_or(|since| has_passed(self.at, since, Micros::now(), &TimeZone::system()))
    }
}

/// Whether a time of the day has passed since `since`. A check in the future, which a wrong clock made, says nothing.
fn has_passed(at: Time, since: Micros, now: Micros, zone: &TimeZone) -> bool {
    let next = || {
        let since = Timestamp::from_microsecond(since.0).ok()?.to_zoned(zone.clone());
        let same_day = since.with().time(at).build().ok()?;
        if same_day > since { Some(same_day) } else { since.tomorrow().ok()?.with().time(at).build().ok() }
    };
    now < since || next().is_none_or(|next| now.0 >= next.timestamp().as_microsecond())
}

/// Checks the database. Returns the damage; `None` when the station stops.
fn check(
    recorder: &RecorderHandle,
    give_up: &GiveUp,
    wait: impl Fn(Duration) -> bool,
) -> Result<Option<Vec<String>>, DatabaseError> {
    let mut check = match recorder.begin_check(Arc::clone(give_up)) {
        Ok(check) => check,
        Err(error) if error.is_damage() => return Ok(Some(vec![error.to_string()])),
        Err(error) => return Err(error),
    };
    let is_done = paced(|| check.step(), || recorder.load().is_high(), wait)?;
    Ok(is_done.then(|| check.found().to_vec()))
}

/// Makes the steps of a check, and none while the recorder is busy. After a step it rests for the time of the step. Returns `false` when
/// the station stops.
fn paced<E>(
    mut step: impl FnMut() -> Result<bool, E>,
    is_busy: impl Fn() -> bool,
    wait: impl Fn(Duration) -> bool,
) -> Result<bool, E> {
    loop {
        let begun = Instant::now();
        let pause = if is_busy() {
            LOAD_PAUSE
        } else if step()? {
            begun.elapsed()
        } else {
            return Ok(true);
        };
        if !wait(pause) {
            return Ok(false);
        }
    }
}

/// Keeps the outcome of a check. Damage, and its end, is an event.
fn report(recorder: &RecorderHandle, found: Vec<String>) {
    let was_damaged = recorder.damage().is_some();
    recorder.store_check(LastCheck { at: Micros::now(), found });
    match recorder.damage_sentence() {
        Some(sentence) => recorder.event_now(None, EventKind::Station, sentence),
        None if was_damaged => {
            recorder.event_now(None, EventKind::Station, "the check of the database finds no damage any more");
        }
        None => {}
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, reason = "a test")]

    use super::*;
    use profivac_recorder::{Reader, Recorder, Settings};
    use std::cell::{Cell, RefCell};
    use std::convert::Infallible;
    use std::fs::OpenOptions;
    use std::os::unix::fs::FileExt;
    use std::path::Path;

    const HOUR: i64 = 3600 * Micros::SECOND;

    fn never() -> GiveUp {
        Arc::new(|| false)
    }

    fn handle(path: &Path) -> RecorderHandle {
        let recorder = Recorder::start(path, Settings::default()).unwrap();
        let handle = RecorderHandle::new(recorder, path.to_owned());
        handle.recall_check();
        handle
    }

    fn station_events(recorder: &RecorderHandle) -> Vec<String> {
        assert!(recorder.flush());
        let events = recorder.open_reader().unwrap().events(Micros(0), Micros(i64::MAX), 100).unwrap();
        events.into_iter().rev().filter(|event| event.kind == EventKind::Station).map(|event| event.text).collect()
    }

    #[test]
    fn no_step_is_made_while_the_recorder_is_busy_and_the_check_goes_on_afterwards() {
        let (log, busy_for, steps) = (RefCell::new(Vec::new()), Cell::new(0), Cell::new(4));
        let is_done = paced(
            || {
                assert_eq!(busy_for.get(), 0, "the recorder is not busy");
                log.borrow_mut().push("step");
                steps.set(steps.get() - 1);
                // The recorder gets busy during the second step.
                busy_for.set(if steps.get() == 2 { 3 } else { 0 });
                Ok::<_, Infallible>(steps.get() > 0)
            },
            || busy_for.get() > 0,
            |pause| {
                if busy_for.get() > 0 && log.borrow().last() != Some(&"step") {
                    assert_eq!(pause, LOAD_PAUSE);
                }
                log.borrow_mut().push("pause");
                busy_for.set(0.max(busy_for.get() - 1));
                true
            },
        );
        assert_eq!(is_done, Ok(true));
        // One pause after each step, and two more until the recorder is no longer busy.
        assert_eq!(*log.borrow(), ["step", "pause", "step", "pause", "pause", "pause", "step", "pause", "step"]);
    }

    #[test]
    fn a_station_that_stops_ends_the_check_at_the_next_pause() {
        let steps = Cell::new(0);
        let step = || {
            steps.set(steps.get() + 1);
            Ok::<_, Infallible>(true)
        };
        assert_eq!(paced(step, || false, |_| steps.get() < 3), Ok(false));
        assert_eq!(steps.get(), 3);
    }

    #[test]
    fn a_check_is_due_at_the_first_three_o_clock_after_the_last_one() {
        let three = jiff::civil::time(3, 0, 0, 0);
        let zone = TimeZone::fixed(jiff::tz::offset(2));
        // Midnight of the zone is 22 h UTC.
        let at = |hour: i64| Micros((20_000 * 24 - 2 + hour) * HOUR);
        let passed = |since, now| has_passed(three, at(since), at(now), &zone);
        assert!(!passed(1, 2) && passed(1, 3), "before three o'clock of the same day");
        assert!(!passed(3, 26) && passed(3, 27), "a check at three is followed by one on the next day");
        assert!(!passed(9, 17) && passed(9, 33), "a station that runs from nine to five checks in the morning");
        assert!(passed(50, 49), "the last check is in the future: the clock was set back");
    }

    #[test]
    fn damage_is_an_event_a_state_and_a_sentence_until_a_check_finds_none() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("plant.db");
        let recorder = handle(&path);
        assert!(recorder.flush());
        assert_eq!((recorder.last_check(), recorder.damage()), (None, None));
        report(&recorder, check(&recorder, &never(), |_| true).unwrap().unwrap());
        assert_eq!((recorder.last_check().unwrap().found, station_events(&recorder).len()), (Vec::new(), 0));
        report(&recorder, vec!["Tree 5 page 7 is wrong".to_owned(), "Tree 6 too".to_owned()]);
        let sentence = recorder.damage_sentence().unwrap();
        assert!(sentence.starts_with("the database is damaged: Tree 5 page 7 is wrong; Tree 6 too; "), "{sentence}");
        assert!(sentence.contains("profivac doctor") && sentence.contains("plant.db"), "{sentence}");
        assert_eq!(station_events(&recorder), std::slice::from_ref(&sentence));
        let last = recorder.last_check();
        drop(recorder);
        let recorder = handle(&path);
        assert_eq!((recorder.last_check(), recorder.damage_sentence()), (last, Some(sentence.clone())));
        report(&recorder, check(&recorder, &never(), |_| true).unwrap().unwrap());
        assert_eq!(recorder.damage(), None);
        assert_eq!(
            station_events(&recorder),
            [sentence, "the check of the database finds no damage any more".to_owned()]
        );
    }

    #[test]
    fn a_damaged_page_is_found_by_the_check() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("plant.db");
        let recorder = handle(&path);
        assert!(recorder.flush());
        // The log is written back, so that the file has all pages.
        drop(recorder);
        let file = OpenOptions::new().write(true).open(&path).unwrap();
        // Pages after the first one, which holds the list of tables.
        file.write_all_at(&[0xA5; 2 * 4096], 4096).unwrap();
        let recorder = handle(&path);
        let found = check(&recorder, &never(), |_| true).unwrap().unwrap();
        assert!(!found.is_empty());
    }

    /// All rows of all tables, without the times of recording.
    fn contents(path: &Path) -> Vec<String> {
        let connection = rusqlite::Connection::open(path).unwrap();
        let sql = "SELECT name FROM sqlite_schema WHERE type = 'table' ORDER BY name";
        let names: Vec<String> =
            connection.prepare(sql).unwrap().query_map([], |row| row.get(0)).unwrap().map(Result::unwrap).collect();
        let mut all = Vec::new();
        for name in names.iter().filter(|name| *name != "recording_period") {
            let mut select = connection.prepare(&format!("SELECT * FROM {name}")).unwrap();
            let columns = select.column_count();
            let mut rows = select.query([]).unwrap();
            while let Some(row) = rows.next().unwrap() {
                let cells = (0..columns).map(|column| format!("{:?}", row.get_ref(column).unwrap()));
                all.push(format!("{name}: {}", cells.collect::<Vec<_>>().join(", ")));
            }
        }
        all
    }

    #[test]
    fn a_check_writes_nothing_but_its_outcome() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("plant.db");
        let recorder = handle(&path);
        recorder.event_now_and_wait(None, EventKind::Note, "a row");
        let before = contents(&path);
        report(&recorder, check(&recorder, &never(), |_| true).unwrap().unwrap());
        assert!(recorder.flush());
        let (outcome, after): (Vec<_>, Vec<_>) =
            contents(&path).into_iter().partition(|row| row.starts_with("station_state: "));
        assert_eq!((outcome.len(), after), (1, before));
        assert!(Reader::open(&path).unwrap().last_check().unwrap().is_some());
    }

    /// Looks once with this last check. Returns whether the database was checked.
    fn looks(last: Option<LastCheck>) -> bool {
        let folder = tempfile::tempdir().unwrap();
        let recorder = Arc::new(handle(&folder.path().join("plant.db")));
        assert!(recorder.flush());
        last.iter().for_each(|last| recorder.store_check(last.clone()));
        let (_stop, stopped) = channel();
        let stops = Arc::default();
        let daily = Daily { recorder: Arc::clone(&recorder), at: jiff::civil::time(3, 0, 0, 0), stops, stopped };
        assert!(daily.look(&mut Next::after_start(&recorder), &never()));
        recorder.last_check() != last
    }

    #[test]
    fn a_station_checks_when_days_have_passed_or_the_last_check_found_damage() {
        let checked = |at: Micros, found: &[&str]| {
            let found = found.iter().map(|text| (*text).to_owned()).collect();
            looks(Some(LastCheck { at, found }))
        };
        let now = Micros::now();
        assert!(!looks(None), "the first check of a new database is at three o'clock");
        assert!(!checked(now, &[]) && checked(now.before(Duration::from_secs(2 * 86_400)), &[]));
        assert!(checked(now, &["page 7 is damaged"]), "it may be repaired");
    }

    #[test]
    fn a_thread_that_is_dropped_ends_at_once_also_without_a_check() {
        let folder = tempfile::tempdir().unwrap();
        let recorder = Arc::new(handle(&folder.path().join("plant.db")));
        for at in [None, Some(jiff::civil::time(3, 0, 0, 0))] {
            let thread = CheckThread::start(Arc::clone(&recorder), at).unwrap();
            assert!(!thread.has_ended() && thread.at() == at);
            drop(thread);
        }
    }
}
