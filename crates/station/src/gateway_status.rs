//! The state of the gateways to control systems, for the API: clients, errors, dropped updates.

use crate::view::{StoppedPart, unix_ms};
use profivac_recorder::Micros;
use serde::Serialize;
use std::collections::{BTreeMap, BTreeSet};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};
use utoipa::ToSchema;

/// The state of a gateway.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, ToSchema)]
pub struct GatewayView {
    /// Its name: `archive`, `epics`, `opcua`, `mqtt`, `sparkplug`, `modbus`, `prometheus`.
    pub name: String,
    /// Whether it serves its clients, or is connected to its broker.
    pub is_running: bool,
    /// Where it listens, or the broker to which it connects.
    pub address: Option<String>,
    /// Why it does not run; it tries again.
    pub problem: Option<String>,
    /// Connected clients; for a broker 1 while it is connected.
    pub clients: u64,
    /// Values and answers that were sent since the station started.
    pub sent: u64,
    /// Updates that a slow client did not get because a newer one of the same value replaced them.
    pub dropped_updates: u64,
    /// Requests and connections that were refused or could not be understood.
    pub refused: u64,
    /// The last error, in a sentence.
    pub last_error: Option<String>,
    /// When it occurred, in milliseconds since 1970.
    pub last_error_ms: Option<i64>,
    /// The batches of the gateway `archive`; `null` for others.
    pub archive: Option<ArchiveView>,
}

/// What waits for the archive, and what it says about the station.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, ToSchema)]
pub struct ArchiveView {
    /// Batches that wait in the database of the station.
    pub waiting: u64,
    /// When the first of them was made, in milliseconds since 1970.
    pub oldest_ms: Option<i64>,
    /// When the archive last said what its database has, in milliseconds since 1970.
    pub last_answer_ms: Option<i64>,
    /// Batches that were deleted since the last one was taken, because too many wait.
    pub lost: u64,
    /// Batches of the station that the archive has put aside.
    pub put_aside: u64,
    /// Why it has put the last one aside, in a sentence.
    pub put_aside_reason: Option<String>,
}

/// The archive at one moment, for alarms and for the head of the pages.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct ArchiveState {
    /// The time since its last answer. Before the first one since the gateway began, or since the oldest batch that waits was made.
    pub silence: Duration,
    /// What an operator has to know whatever the time of the last answer, in a sentence.
    pub problem: Option<String>,
}

/// A batch that was put aside is a problem for this time. chosen: a shift sees it, and an old one does not hide a new one.
const PUT_ASIDE_SHOWN: Duration = Duration::from_secs(4 * 3_600);

/// An archive without an answer for this time is shown in the head of the pages. chosen: stations with a constant pressure send each two
/// minutes.
const SILENCE_SHOWN: Duration = Duration::from_secs(900);

/// An archive has this time for its first answer. chosen: it is connected in seconds.
const FIRST_ANSWER: Duration = Duration::from_secs(300);

impl ArchiveState {
    /// What the head of the pages shows, in a sentence.
    fn shown(self) -> Option<String> {
        let minutes = self.silence.as_secs() / 60;
        let silent = || format!("the archive has not answered for {minutes} min");
        self.problem.or_else(|| (self.silence >= SILENCE_SHOWN).then(silent))
    }
}

/// The times of an archive, by a clock that is never set.
#[derive(Debug)]
struct ArchiveTimes {
    answered: Instant,
    /// The batches that were put aside up to the last answer.
    counted: Option<u64>,
    /// When there were more.
    put_aside: Option<Instant>,
}

/// The state of one gateway, which the gateway writes.
#[derive(Debug)]
pub struct GatewayStatus {
    view: Mutex<GatewayView>,
    archive: Mutex<Option<ArchiveTimes>>,
}

impl GatewayStatus {
    fn new(name: &str) -> Self {
        let view = GatewayView {
            name: name.to_owned(),
            is_running: false,
            address: None,
            problem: None,
            clients: 0,
            sent: 0,
            dropped_updates: 0,
            refused: 0,
            last_error: None,
            last_error_ms: None,
            archive: None,
        };
        Self { view: Mutex::new(view), archive: Mutex::default() }
    }

    /// The gateway serves its clients at `address`, or is connected to the broker there.
    pub fn runs(&self, address: String) {
        let mut view = self.lock();
        view.is_running = true;
        view.address = Some(address);
        view.problem = None;
    }

    /// The gateway does not run; it tries again.
    pub fn fails(&self, problem: &str) {
        let mut view = self.lock();
        view.is_running = false;
        view.clients = 0;
        view.problem = Some(problem.to_owned());
        note_error(&mut view, problem);
    }

    /// An error that does not end the gateway.
    pub fn error(&self, error: &str) {
        note_error(&mut self.lock(), error);
    }

    /// A client has connected.
    pub fn client_connected(&self) {
        let mut view = self.lock();
        view.clients = view.clients.saturating_add(1);
    }

    /// A client has disconnected.
    pub fn client_disconnected(&self) {
        let mut view = self.lock();
        view.clients = view.clients.saturating_sub(1);
    }

    /// Sets the number of clients, where a library counts them.
    pub fn set_clients(&self, clients: u64) {
        self.lock().clients = clients;
    }

    /// `count` more values or answers were sent.
    pub fn sent(&self, count: u64) {
        let mut view = self.lock();
        view.sent = view.sent.saturating_add(count);
    }

    /// `count` more updates were replaced by newer ones before a client took them.
    pub fn dropped_updates(&self, count: u64) {
        let mut view = self.lock();
        view.dropped_updates = view.dropped_updates.saturating_add(count);
    }

    /// A request or a connection was refused, with a sentence why.
    pub fn refused(&self, reason: &str) {
        let mut view = self.lock();
        view.refused = view.refused.saturating_add(1);
        note_error(&mut view, reason);
    }

    /// The batches that wait for the archive, since when, and how many were deleted because too many wait.
    pub fn batches(&self, waiting: u64, oldest: Option<Micros>, lost: u64) {
        let mut view = self.lock();
        let archive = view.archive.get_or_insert_default();
        (archive.waiting, archive.oldest_ms, archive.lost) = (waiting, oldest.map(unix_ms), lost);
        drop(view);
        self.times().get_or_insert_with(ArchiveTimes::starting);
    }

    /// The archive has taken a batch, or there was none to take.
    pub fn archive_answered(&self) {
        self.lock().archive.get_or_insert_default().last_answer_ms = Some(unix_ms(Micros::now()));
        self.times().get_or_insert_with(ArchiveTimes::starting).answered = Instant::now();
    }

    /// The archive has put so many batches of the station aside, the last one for this reason.
    pub fn put_aside(&self, count: u64, reason: Option<&str>) {
        let mut view = self.lock();
        let archive = view.archive.get_or_insert_default();
        (archive.put_aside, archive.put_aside_reason) = (count, reason.map(str::to_owned));
        drop(view);
        let mut times = self.times();
        let times = times.get_or_insert_with(ArchiveTimes::starting);
        // What was put aside before the start of the station is no news.
        if times.counted.replace(count).is_some_and(|before| before < count) {
            times.put_aside = Some(Instant::now());
        }
    }

    /// The archive at this moment; `None` for other gateways.
    #[must_use]
    pub fn archive(&self) -> Option<ArchiveState> {
        let view = self.lock().archive.clone()?;
        let times = self.times();
        let times = times.as_ref()?;
        let is_recent = times.put_aside.is_some_and(|at| at.elapsed() < PUT_ASIDE_SHOWN);
        let reason = || view.put_aside_reason.as_deref().unwrap_or("the archive says no reason");
        let put_aside = || format!("the archive has put {} batches aside: {}", view.put_aside, reason());
        let lost = format!("{} batches were deleted, because too many wait for the archive", view.lost);
        let problem = (view.lost > 0).then_some(lost).or_else(|| is_recent.then(put_aside));
        let waits = view.oldest_ms.filter(|_| view.last_answer_ms.is_none());
        let waits = waits.map(|oldest| unix_ms(Micros::now()).saturating_sub(oldest));
        let waits = waits.and_then(|ms| Some(Duration::from_millis(u64::try_from(ms).ok()?)));
        Some(ArchiveState { silence: silence(times.answered.elapsed(), waits), problem })
    }

    fn times(&self) -> MutexGuard<'_, Option<ArchiveTimes>> {
        self.archive.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// The present state.
    #[must_use]
    pub fn view(&self) -> GatewayView {
        self.lock().clone()
    }

    fn lock(&self) -> MutexGuard<'_, GatewayView> {
        self.view.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

impl ArchiveTimes {
    fn starting() -> Self {
        Self { answered: Instant::now(), counted: None, put_aside: None }
    }
}

/// How long an archive has been silent. `waits` is the age of the oldest batch as long as the archive has not answered since the gateway began:
/// a restart of the station does not end the silence.
fn silence(since: Duration, waits: Option<Duration>) -> Duration {
    if since < FIRST_ANSWER { since } else { waits.map_or(since, |waits| waits.max(since)) }
}

fn note_error(view: &mut GatewayView, error: &str) {
    view.last_error = Some(error.to_owned());
    view.last_error_ms = Some(unix_ms(Micros::now()));
}

/// The states of all gateways, by name.
#[derive(Debug, Default)]
pub struct GatewayStatuses {
    gateways: Mutex<BTreeMap<String, Arc<GatewayStatus>>>,
}

impl GatewayStatuses {
    /// Adds a gateway that does not run yet. A former gateway of that name is forgotten.
    #[must_use]
    pub fn add(&self, name: &str) -> Arc<GatewayStatus> {
        let status = Arc::new(GatewayStatus::new(name));
        self.lock().insert(name.to_owned(), Arc::clone(&status));
        status
    }

    /// Removes a gateway that has stopped.
    pub fn remove(&self, name: &str) {
        self.lock().remove(name);
    }

    /// The states of all gateways, by name.
    #[must_use]
    pub fn views(&self) -> Vec<GatewayView> {
        self.lock().values().map(|status| status.view()).collect()
    }

    /// The archive at this moment, if the station sends to one.
    #[must_use]
    pub fn archive(&self) -> Option<ArchiveState> {
        self.lock().values().find_map(|status| status.archive())
    }

    /// What the head of the pages says about the archive, in a sentence.
    #[must_use]
    pub fn archive_problem(&self) -> Option<String> {
        self.archive().and_then(ArchiveState::shown)
    }

    /// The gateways that cannot run, by name.
    #[must_use]
    pub fn stopped(&self) -> Vec<StoppedPart> {
        let stopped = |view: GatewayView| view.problem.map(|problem| StoppedPart { name: view.name, problem });
        self.views().into_iter().filter_map(stopped).collect()
    }

    fn lock(&self) -> MutexGuard<'_, BTreeMap<String, Arc<GatewayStatus>>> {
        self.gateways.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

/// Finds the parts that have stopped or run again since the last look, so that each change is reported once.
#[derive(Debug, Default)]
pub struct StopReports {
    reported: BTreeSet<String>,
}

impl StopReports {
    /// A sentence for each part that has stopped since the last look, and for each one whose problem is over.
    pub fn changes(&mut self, stopped: &[StoppedPart]) -> Vec<String> {
        let present = stopped.iter().map(|part| part.name.clone()).collect();
        let before = std::mem::replace(&mut self.reported, present);
        // A broker with a standby gives another reason at each attempt: only the first one is reported.
        let begun = stopped.iter().filter(|part| !before.contains(&part.name));
        let begun = begun.map(|part| format!("{} does not run: {}; the station tries again", part.name, part.problem));
        let over = before.difference(&self.reported).map(|name| format!("{name}: the problem is over"));
        begun.chain(over).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_part_that_stops_is_reported_once_and_once_more_when_it_runs_again() {
        let statuses = GatewayStatuses::default();
        let mut reports = StopReports::default();
        let (modbus, epics) = (statuses.add("modbus"), statuses.add("epics"));
        assert!(reports.changes(&statuses.stopped()).is_empty(), "a part that starts has not failed");
        modbus.fails("cannot listen on 127.0.0.1:502: address in use");
        epics.runs("ca 127.0.0.1:5064".to_owned());
        let first = reports.changes(&statuses.stopped());
        let expected =
            "modbus does not run: cannot listen on 127.0.0.1:502: address in use; the station tries again".to_owned();
        assert_eq!(first, [expected]);
        modbus.fails("cannot listen on 127.0.0.1:502: address in use");
        assert!(reports.changes(&statuses.stopped()).is_empty(), "it was reported");
        modbus.runs("127.0.0.1:502".to_owned());
        assert_eq!(reports.changes(&statuses.stopped()), ["modbus: the problem is over"]);
        assert!(statuses.stopped().is_empty());
    }

    #[test]
    fn a_restart_does_not_end_the_silence_of_an_archive() {
        let [minute, hour] = [60, 3_600].map(Duration::from_secs);
        assert_eq!(silence(minute, Some(72 * hour)), minute, "the archive may answer yet");
        assert_eq!(silence(FIRST_ANSWER, Some(72 * hour)), 72 * hour);
        assert_eq!(silence(FIRST_ANSWER, Some(minute)), FIRST_ANSWER);
        assert_eq!(silence(5 * hour, None), 5 * hour, "it has answered, or nothing waits");
    }

    #[test]
    fn batches_that_are_put_aside_or_deleted_are_a_problem_in_words() {
        let statuses = GatewayStatuses::default();
        assert_eq!(statuses.archive(), None, "a station without an archive");
        let archive = statuses.add("archive");
        assert_eq!(statuses.archive(), None, "the gateway has not begun");
        archive.batches(3, Some(Micros(5_000)), 0);
        assert_eq!(statuses.archive_problem(), None);
        archive.put_aside(1, Some("a time before 2000"));
        assert_eq!(statuses.archive_problem(), None, "it was put aside before the start");
        archive.put_aside(2, Some("a time before 2000"));
        let problem = statuses.archive_problem().unwrap();
        assert_eq!(problem, "the archive has put 2 batches aside: a time before 2000");
        archive.batches(3, Some(Micros(5_000)), 7);
        let problem = statuses.archive_problem().unwrap();
        assert_eq!(problem, "7 batches were deleted, because too many wait for the archive");
        archive.archive_answered();
        let view = archive.view().archive.unwrap();
        assert_eq!((view.waiting, view.oldest_ms, view.put_aside, view.lost), (3, Some(5), 2, 7));
        assert!(view.last_answer_ms.is_some());
        let silent = ArchiveState { silence: Duration::from_secs(960), problem: None };
        assert_eq!(silent.shown().as_deref(), Some("the archive has not answered for 16 min"));
    }

    #[test]
    fn a_gateway_reports_its_clients_errors_and_dropped_updates() {
        let statuses = GatewayStatuses::default();
        let status = statuses.add("modbus");
        status.runs("127.0.0.1:1502".to_owned());
        status.client_connected();
        status.client_connected();
        status.client_disconnected();
        status.dropped_updates(3);
        status.refused("a write");
        let [view] = &statuses.views()[..] else { panic!("one gateway") };
        assert_eq!((view.is_running, view.clients, view.dropped_updates, view.refused), (true, 1, 3, 1));
        assert_eq!((view.last_error.as_deref(), view.problem.as_deref()), (Some("a write"), None));
        status.fails("the port is in use");
        let view = status.view();
        assert_eq!((view.is_running, view.clients), (false, 0));
        assert_eq!(view.problem.as_deref(), Some("the port is in use"));
        statuses.remove("modbus");
        assert!(statuses.views().is_empty());
    }
}
