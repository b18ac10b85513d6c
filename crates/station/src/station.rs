//! The running station: a recorder, a thread for each segment, the alarm thread, the delivery threads, the one that compares pump-downs
//! and the one that checks the database. It restarts a thread that has ended.

use crate::alarm::{AlarmThread, NotificationTarget};
use crate::comparison::watch::WatchThread;
use crate::config::changes::{FileChange, MAX_CHANGES};
use crate::config::{self, Config};
use crate::database_check::CheckThread;
use crate::gateway_status::StopReports;
use crate::known_file;
use crate::recording::RecorderHandle;
use crate::restarts::Restarts;
use crate::segment::{SegmentHandle, planned_segments};
use crate::services::Services;
use crate::webhook::{DeliverySettings, DeliveryThread, Receiver};
use jiff::civil::Time;
use profivac_recorder::alarms::AlarmBatch;
use profivac_recorder::{AuditAction, AuditEntry, DatabaseError, EventKind, Recorder, Settings, Unwritten};
use profivac_web_server::auth::{Actor, Role, User};
use std::collections::BTreeSet;
use std::slice;
use std::sync::Arc;
use std::time::{Duration, Instant};

/// The longest that a segment may take to stop: its slaves are released within a second.
const STOP_TIMEOUT: Duration = Duration::from_millis(1500);

/// An event is recorded when the alarms have not been evaluated for this time.
const EVALUATION_OVERDUE: Duration = Duration::from_secs(15);

/// The reason why a station does not start.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum StationError {
    /// The database cannot be used.
    #[error(transparent)]
    Database(#[from] DatabaseError),
    /// The system gives no thread.
    #[error("the system gives no thread: {0}")]
    Thread(#[from] std::io::Error),
}

/// A running station.
pub struct Station {
    services: Arc<Services>,
    segments: Vec<SegmentHandle>,
    alarm_thread: Option<AlarmThread>,
    /// The segments of the file whose threads the system has not given yet.
    waiting: Vec<config::Segment>,
    receivers: Vec<Receiver>,
    deliveries: Vec<DeliveryThread>,
    watch: WatchThread,
    check: CheckThread,
    /// The time of the check in the file. The thread has the one before until another thread starts.
    check_at: Option<Time>,
    restarts: Restarts,
    /// The overdue evaluation was recorded as an event.
    is_overdue: bool,
    stop_reports: StopReports,
}

impl Station {
    /// Starts to record and to evaluate alarms.
    ///
    /// # Errors
    /// [`StationError`] when the database cannot be used, or the system gives no threads.
    pub fn start(config: Config) -> Result<Self, StationError> {
        let settings = Settings { retention: config.retention, outbox: config.outbox(), ..Settings::default() };
        let recorder = Recorder::start(&config.database, settings)?;
        let services = Arc::new(Services::new(config.name, config.database, recorder));
        services.recorder().event_now_and_wait(None, EventKind::Station, "the station starts");
        services.recorder().recall_check();
        let changes = known_file::changes_while_stopped(services.recorder(), &config.source);
        record_file_changes(services.recorder(), &changes, Changed::WhileStopped);
        known_file::remember(services.recorder(), &config.source);
        services.plant().set(config.plant);
        services.recorder().set_point_texts(config.directory.points.clone());
        services.directory().set(config.directory);
        services.alarm_editor().set_source(config.source);
        let receivers = Receiver::all(config.webhooks, config.emails);
        services.alarms().start(config.alarms, notification_targets(&receivers))?;
        services.alarms().start_plant_states(config.plant_states)?;
        services.snapshots().set_plan(planned_segments(&config.segments));
        let start = |segment| SegmentHandle::start(segment, services.for_segments());
        let segments = config.segments.into_iter().map(start).collect::<Result<_, _>>()?;
        let alarm_thread = Some(start_alarm_thread(&services)?);
        let watch = WatchThread::start(Arc::clone(services.recorder()))?;
        let check = CheckThread::start(Arc::clone(services.recorder()), config.database_check)?;
        let mut station = Self {
            services,
            segments,
            alarm_thread,
            waiting: Vec::new(),
            receivers: Vec::new(),
            deliveries: Vec::new(),
            watch,
            check,
            check_at: config.database_check,
            restarts: Restarts::default(),
            is_overdue: false,
            stop_reports: StopReports::default(),
        };
        station.start_deliveries(receivers);
        Ok(station)
    }

    /// The parts that the threads of the station share.
    #[must_use]
    pub fn services(&self) -> Arc<Services> {
        Arc::clone(&self.services)
    }

    /// Applies a changed file. Unchanged parts keep running; the database and the address of the dashboard stay as they are until
    /// the station is restarted. A thread that the system does not give is an event, and [`Self::restart_ended_threads`] tries again.
    pub fn reconfigure(&mut self, config: Config) {
        let changes = self.services.alarm_editor().changes_to(&config.source);
        self.services.snapshots().set_plan(planned_segments(&config.segments));
        let mut old = std::mem::take(&mut self.segments);
        self.waiting.clear();
        // What could not be started before is told again.
        self.restarts = Restarts::default();
        for new in config.segments {
            let same =
                old.iter().position(|segment| segment.config().name == new.name && segment.can_reconfigure(&new));
            match same.map(|index| old.remove(index)) {
                Some(mut kept) => {
                    kept.reconfigure(new);
                    self.segments.push(kept);
                }
                None => {
                    // A port cannot be opened twice, and a name has one thread: the segment that has it stops first.
                    let is_in_the_way = |segment: &SegmentHandle| {
                        let config = segment.config();
                        config.port == new.port || config.name == new.name
                    };
                    while let Some(index) = old.iter().position(is_in_the_way) {
                        let stopping = old.remove(index);
                        self.record_event(&stop_sentence(stopping.config(), &new));
                        stopping.stop(Instant::now() + STOP_TIMEOUT);
                    }
                    self.start_segment(new);
                }
            }
        }
        stop_all(old);
        self.services.plant().set(config.plant);
        self.services.recorder().set_point_texts(config.directory.points.clone());
        self.services.directory().set(config.directory);
        self.services.alarm_editor().set_source(config.source.clone());
        let receivers = Receiver::all(config.webhooks, config.emails);
        self.services.alarms().reconfigure_plant_states(config.plant_states);
        self.services.alarms().reconfigure(config.alarms, notification_targets(&receivers));
        self.start_deliveries(receivers);
        self.check_at = config.database_check;
        self.start_changed_check();
        self.record_event("the station's file was read again");
        record_file_changes(self.services.recorder(), &changes, Changed::WhileRunning);
        known_file::remember(self.services.recorder(), &config.source);
    }

    /// Starts the check of the database at another time, if the file has one.
    fn start_changed_check(&mut self) {
        if self.check.at() == self.check_at {
            return;
        }
        let check = CheckThread::start(Arc::clone(self.services.recorder()), self.check_at);
        if let Some(check) = self.attempt(CHECK_THREAD, check) {
            self.check = check;
        }
    }

    fn start_segment(&mut self, segment: config::Segment) {
        let started = SegmentHandle::start(segment.clone(), self.services.for_segments());
        match self.attempt(&thread_of(&segment), started) {
            Some(handle) => self.segments.push(handle),
            None => self.waiting.push(segment),
        }
    }

    /// The thread that was started. That the system does not give it is an event, once.
    fn attempt<T>(&mut self, name: &str, started: std::io::Result<T>) -> Option<T> {
        let (thread, sentence) = self.restarts.attempt(name, started);
        sentence.iter().for_each(|sentence| self.record_event(sentence));
        thread
    }

    /// Starts a delivery thread for each webhook and e-mail. Threads of unchanged ones keep running.
    fn start_deliveries(&mut self, receivers: Vec<Receiver>) {
        let names: Vec<_> = receivers.iter().map(|receiver| receiver.name().to_owned()).collect();
        self.deliveries.retain(|delivery| receivers.contains(delivery.receiver()));
        self.receivers = receivers;
        self.start_missing_deliveries();
        // Notifications of receivers that are no longer in the file are not delivered.
        let recorder = self.services.recorder();
        let others = recorder.open_reader().and_then(|reader| reader.notifications_for_other_webhooks(&names));
        let finished_notifications = others.unwrap_or_default();
        if !finished_notifications.is_empty() {
            let batch = AlarmBatch { finished_notifications, ..AlarmBatch::default() };
            let _queued = recorder.record_alarms(batch, Vec::new());
        }
    }

    /// Starts a delivery thread for each receiver that has none.
    fn start_missing_deliveries(&mut self) {
        let has_thread = |receiver: &Receiver| self.deliveries.iter().any(|delivery| delivery.receiver() == receiver);
        let missing: Vec<_> = self.receivers.iter().filter(|receiver| !has_thread(receiver)).cloned().collect();
        for receiver in missing {
            let name = format!("the thread that delivers to {}", receiver.name());
            let (recorder, status) = (Arc::clone(self.services.recorder()), Arc::clone(self.services.webhooks()));
            let started = DeliveryThread::start(receiver, recorder, status, DeliverySettings::default());
            let started = self.attempt(&name, started);
            self.deliveries.extend(started);
        }
    }

    /// Restarts the alarm thread and the delivery threads if they have ended, and reports an overdue evaluation once.
    fn restart_alarm_threads(&mut self) {
        let Self { services, alarm_thread, restarts, .. } = self;
        let name = |_: &AlarmThread| "the alarm thread".to_owned();
        let alarm_thread = alarm_thread.as_mut_slice();
        let sentences =
            restarts.replace_ended(alarm_thread, AlarmThread::has_ended, name, |_| start_alarm_thread(services));
        sentences.iter().for_each(|sentence| self.record_event(sentence));
        let is_overdue = self.services.alarms().evaluated_ago().is_some_and(|ago| ago > EVALUATION_OVERDUE);
        if is_overdue && !self.is_overdue {
            self.record_event("the alarms have not been evaluated for 15 s");
        }
        self.is_overdue = is_overdue;
        self.deliveries.retain(|delivery| !delivery.has_ended());
        self.start_missing_deliveries();
    }

    /// Restarts every thread that has ended. If the system does not give one, that is an event, and the next call tries again. To be
    /// called every few seconds.
    pub fn restart_ended_threads(&mut self) {
        self.services.control().refusals().flush(Instant::now());
        for segment in std::mem::take(&mut self.waiting) {
            self.start_segment(segment);
        }
        let Self { services, segments, watch, check, restarts, .. } = self;
        let start = |segment: &SegmentHandle| SegmentHandle::start(segment.config().clone(), services.for_segments());
        let name = |segment: &SegmentHandle| thread_of(segment.config());
        let mut sentences = restarts.replace_ended(segments, SegmentHandle::has_ended, name, start);
        let start = |_: &WatchThread| WatchThread::start(Arc::clone(services.recorder()));
        let name = |_: &WatchThread| "the thread that compares pump-downs".to_owned();
        sentences.extend(restarts.replace_ended(slice::from_mut(watch), WatchThread::has_ended, name, start));
        let start = |check: &CheckThread| CheckThread::start(Arc::clone(services.recorder()), check.at());
        let name = |_: &CheckThread| CHECK_THREAD.to_owned();
        sentences.extend(restarts.replace_ended(slice::from_mut(check), CheckThread::has_ended, name, start));
        sentences.iter().for_each(|sentence| self.record_event(sentence));
        self.start_changed_check();
        self.restart_alarm_threads();
    }

    /// Records an event for each part that has stopped or runs again, and returns their sentences. To be called every few seconds.
    pub fn report_stopped_parts(&mut self) -> Vec<String> {
        let changes = self.stop_reports.changes(&self.services.gateways().stopped());
        changes.iter().for_each(|change| self.record_event(change));
        changes
    }

    /// Releases all slaves and stops. Everything recorded is on the disk afterwards.
    ///
    /// # Errors
    /// [`Unwritten`] when the disk does not take it.
    pub fn stop(self) -> Result<(), Unwritten> {
        // The alarm thread stops first: a segment that stops with the station is no alarm.
        drop(self.alarm_thread);
        self.services.alarms().end();
        drop(self.deliveries);
        drop(self.watch);
        drop(self.check);
        stop_all(self.segments);
        self.services.recorder().event_now(None, EventKind::Station, "the station stops");
        self.services.recorder().finish()
    }

    /// Records an event of the whole station.
    pub fn record_event(&self, text: &str) {
        self.services.recorder().event_now(None, EventKind::Station, text);
    }
}

/// The thread that checks the database, for an event.
const CHECK_THREAD: &str = "the thread that checks the database";

/// The thread of a segment, for an event.
fn thread_of(segment: &config::Segment) -> String {
    format!("the thread of segment {}", segment.name)
}

/// Why a segment stops before `new` starts, for an event.
fn stop_sentence(old: &config::Segment, new: &config::Segment) -> String {
    let name = &old.name;
    if *name != new.name {
        return format!(
            "segment {name} stops and releases its gauges and slaves: the station's file gives its port to segment {}",
            new.name
        );
    }
    format!(
        "segment {name} begins anew and releases its gauges and slaves: changed in the station's file: {}",
        restart_reasons(old, new)
    )
}

/// The parts of a segment that differ, other than its gauges.
fn restart_reasons(old: &config::Segment, new: &config::Segment) -> String {
    let keys = [
        ("port", old.port != new.port),
        ("baud", (old.baud, old.detects_baud) != (new.baud, new.detects_baud)),
        ("master", old.master != new.master),
        ("listen-only", old.listen_only != new.listen_only),
        ("device files", old.devices != new.devices),
    ];
    let keys = keys.into_iter().filter(|(_, differs)| *differs).map(|(key, _)| key.to_owned());
    let removed = old.slaves.iter().filter(|slave| !new.slaves.contains(slave));
    let added = new.slaves.iter().filter(|slave| !old.slaves.contains(slave));
    let slaves: BTreeSet<String> = removed.chain(added).map(|slave| format!("slave {}", slave.name)).collect();
    let all: Vec<String> = keys.chain(slaves).collect();
    if all.is_empty() { "the order of the slaves".to_owned() } else { all.join(", ") }
}

/// When the file was changed.
#[derive(Clone, Copy)]
enum Changed {
    /// The running station has read it again.
    WhileRunning,
    /// The station found the change when it started.
    WhileStopped,
}

impl Changed {
    /// The beginning of an event, and the outcome in the audit trail.
    const fn words(self) -> (&'static str, Option<&'static str>) {
        match self {
            Self::WhileRunning => ("the file changes", None),
            Self::WhileStopped => {
                ("the file was changed while the station was stopped:", Some("changed while the station was stopped"))
            }
        }
    }
}

/// Records each change of the file as an event and as a row of the audit trail, by the user `file`.
fn record_file_changes(recorder: &RecorderHandle, changes: &[FileChange], changed: Changed) {
    let actor = Actor { user: User { name: Arc::from("file"), role: Role::Engineer }, peer: None };
    let (event, outcome) = changed.words();
    let record = |text: String, entry: AuditEntry| {
        recorder.event_now(None, EventKind::Station, format!("{event} {text}"));
        let _queued = recorder.audit(entry);
    };
    for FileChange { key, before, after } in changes.iter().take(MAX_CHANGES) {
        let shown = |value: &Option<String>| value.clone().unwrap_or_else(|| "not in the file".to_owned());
        let entry = AuditEntry {
            target: Some(key.clone()),
            before: before.clone(),
            after: after.clone(),
            outcome: outcome.map(str::to_owned),
            ..actor.audit_entry(AuditAction::FileChanged)
        };
        record(format!("{key}: {} -> {}", shown(before), shown(after)), entry);
    }
    if let Some(more) = changes.len().checked_sub(MAX_CHANGES).filter(|more| *more > 0) {
        let outcome = Some(format!("{more} more keys {}", outcome.unwrap_or("have changed")));
        record(format!("{more} more keys"), AuditEntry { outcome, ..actor.audit_entry(AuditAction::FileChanged) });
    }
}

fn start_alarm_thread(services: &Services) -> std::io::Result<AlarmThread> {
    let (alarms, snapshots) = (Arc::clone(services.alarms()), Arc::clone(services.snapshots()));
    AlarmThread::start(alarms, snapshots, Arc::clone(services.recorder()), Arc::clone(services.gateways()))
}

fn notification_targets(receivers: &[Receiver]) -> Vec<NotificationTarget> {
    receivers.iter().map(Receiver::target).collect()
}

/// Stops segments together, so that a slow one does not take the time of another.
fn stop_all(segments: Vec<SegmentHandle>) {
    let end = Instant::now() + STOP_TIMEOUT;
    segments.iter().for_each(SegmentHandle::begin_to_stop);
    segments.into_iter().for_each(|segment| segment.stop(end));
}
