//! The running station: a recorder, a thread for each segment, the alarm thread, the delivery threads and the one that compares
//! pump-downs. It restarts a thread that has ended.

use crate::alarm::{AlarmThread, NotificationTarget};
use crate::comparison::watch::WatchThread;
use crate::config::Config;
use crate::config::changes::{FileChange, MAX_CHANGES};
use crate::gateway_status::StopReports;
use crate::segment::SegmentHandle;
use crate::services::Services;
use crate::webhook::{DeliverySettings, DeliveryThread, Receiver};
use profivac_recorder::alarms::AlarmBatch;
use profivac_recorder::{AuditAction, AuditEntry, DatabaseError, EventKind, Recorder, Settings, Unwritten};
use profivac_web_server::auth::{Actor, Role, User};
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
    deliveries: Vec<DeliveryThread>,
    watch: WatchThread,
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
        services.plant().set(config.plant);
        services.directory().set(config.directory);
        services.alarm_editor().set_source(config.source);
        let receivers = Receiver::all(config.webhooks, config.emails);
        services.alarms().start(config.alarms, notification_targets(&receivers))?;
        services.alarms().start_plant_states(config.plant_states)?;
        let start = |segment| SegmentHandle::start(segment, services.for_segments());
        let segments = config.segments.into_iter().map(start).collect::<Result<_, _>>()?;
        let alarm_thread = Some(start_alarm_thread(&services)?);
        let watch = WatchThread::start(Arc::clone(services.recorder()))?;
        let (is_overdue, stop_reports) = (false, StopReports::default());
        let mut station =
            Self { services, segments, alarm_thread, deliveries: Vec::new(), watch, is_overdue, stop_reports };
        station.start_deliveries(receivers)?;
        Ok(station)
    }

    /// The parts that the threads of the station share.
    #[must_use]
    pub fn services(&self) -> Arc<Services> {
        Arc::clone(&self.services)
    }

    /// Applies a changed file. Unchanged parts keep running; the database and the address of the dashboard stay as they are until
    /// the station is restarted.
    ///
    /// # Errors
    /// When the system gives no threads.
    pub fn reconfigure(&mut self, config: Config) -> std::io::Result<()> {
        let changes = self.services.alarm_editor().changes_to(&config.source);
        let mut old = std::mem::take(&mut self.segments);
        for new in config.segments {
            let same =
                old.iter().position(|segment| segment.config().name == new.name && segment.can_reconfigure(&new));
            self.segments.push(match same.map(|index| old.remove(index)) {
                Some(mut kept) => {
                    kept.reconfigure(new);
                    kept
                }
                None => {
                    // A port cannot be opened twice: the segment that has it stops first.
                    if let Some(index) = old.iter().position(|segment| segment.config().port == new.port) {
                        old.remove(index).stop(Instant::now() + STOP_TIMEOUT);
                    }
                    SegmentHandle::start(new, self.services.for_segments())?
                }
            });
        }
        stop_all(old);
        self.services.plant().set(config.plant);
        self.services.directory().set(config.directory);
        self.services.alarm_editor().set_source(config.source);
        let receivers = Receiver::all(config.webhooks, config.emails);
        self.services.alarms().reconfigure_plant_states(config.plant_states);
        self.services.alarms().reconfigure(config.alarms, notification_targets(&receivers));
        self.start_deliveries(receivers)?;
        self.record_event("the station's file was read again");
        self.record_file_changes(&changes);
        Ok(())
    }

    /// Starts a delivery thread for each webhook and e-mail. Threads of unchanged ones keep running.
    fn start_deliveries(&mut self, receivers: Vec<Receiver>) -> std::io::Result<()> {
        let names: Vec<_> = receivers.iter().map(|receiver| receiver.name().to_owned()).collect();
        self.deliveries.retain(|delivery| receivers.contains(delivery.receiver()));
        for receiver in receivers {
            if !self.deliveries.iter().any(|delivery| *delivery.receiver() == receiver) {
                self.start_delivery(receiver)?;
            }
        }
        // Notifications of receivers that are no longer in the file are not delivered.
        let recorder = self.services.recorder();
        let others = recorder.open_reader().and_then(|reader| reader.notifications_for_other_webhooks(&names));
        let finished_notifications = others.unwrap_or_default();
        if !finished_notifications.is_empty() {
            let batch = AlarmBatch { finished_notifications, ..AlarmBatch::default() };
            let _queued = recorder.record_alarms(batch, Vec::new());
        }
        Ok(())
    }

    fn start_delivery(&mut self, receiver: Receiver) -> std::io::Result<()> {
        let (recorder, status) = (Arc::clone(self.services.recorder()), Arc::clone(self.services.webhooks()));
        self.deliveries.push(DeliveryThread::start(receiver, recorder, status, DeliverySettings::default())?);
        Ok(())
    }

    /// Restarts the alarm thread and the delivery threads if they have ended, and reports an overdue evaluation once.
    fn restart_alarm_threads(&mut self) -> std::io::Result<()> {
        if self.alarm_thread.as_ref().is_some_and(AlarmThread::has_ended) {
            self.record_event("the alarm thread has ended and is restarted");
            self.alarm_thread = Some(start_alarm_thread(&self.services)?);
        }
        let is_overdue = self.services.alarms().evaluated_ago().is_some_and(|ago| ago > EVALUATION_OVERDUE);
        if is_overdue && !self.is_overdue {
            self.record_event("the alarms have not been evaluated for 15 s");
        }
        self.is_overdue = is_overdue;
        let ended = self.deliveries.iter().filter(|delivery| delivery.has_ended());
        let ended: Vec<_> = ended.map(|delivery| delivery.receiver().clone()).collect();
        self.deliveries.retain(|delivery| !delivery.has_ended());
        ended.into_iter().try_for_each(|receiver| self.start_delivery(receiver))
    }

    /// Restarts every thread that has ended. To be called every few seconds.
    ///
    /// # Errors
    /// When the system gives no threads.
    pub fn restart_ended_threads(&mut self) -> std::io::Result<()> {
        self.services.control().refusals().flush(Instant::now());
        for segment in &mut self.segments {
            if segment.has_ended() {
                let config = segment.config().clone();
                let text = format!("the thread of segment {} has ended and is restarted", config.name);
                self.services.recorder().event_now(None, EventKind::Station, text);
                *segment = SegmentHandle::start(config, self.services.for_segments())?;
            }
        }
        if self.watch.has_ended() {
            self.record_event("the thread that compares pump-downs has ended and is restarted");
            self.watch = WatchThread::start(Arc::clone(self.services.recorder()))?;
        }
        self.restart_alarm_threads()
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
        stop_all(self.segments);
        self.services.recorder().event_now(None, EventKind::Station, "the station stops");
        self.services.recorder().finish()
    }

    /// Records each change of the file as an event and as a row of the audit trail, by the user `file`.
    fn record_file_changes(&self, changes: &[FileChange]) {
        let recorder = self.services.recorder();
        let actor = Actor { user: User { name: Arc::from("file"), role: Role::Engineer }, peer: None };
        for FileChange { key, before, after } in changes.iter().take(MAX_CHANGES) {
            let shown = |value: &Option<String>| value.clone().unwrap_or_else(|| "not in the file".to_owned());
            self.record_event(&format!("the file changes {key}: {} -> {}", shown(before), shown(after)));
            let (target, before, after) = (Some(key.clone()), before.clone(), after.clone());
            let _queued =
                recorder.audit(AuditEntry { target, before, after, ..actor.audit_entry(AuditAction::FileChanged) });
        }
        if let Some(more) = changes.len().checked_sub(MAX_CHANGES).filter(|more| *more > 0) {
            self.record_event(&format!("the file changes {more} more keys"));
            let outcome = Some(format!("{more} more keys have changed"));
            let _queued = recorder.audit(AuditEntry { outcome, ..actor.audit_entry(AuditAction::FileChanged) });
        }
    }

    fn record_event(&self, text: &str) {
        self.services.recorder().event_now(None, EventKind::Station, text);
    }
}

fn start_alarm_thread(services: &Services) -> std::io::Result<AlarmThread> {
    let (alarms, snapshots) = (Arc::clone(services.alarms()), Arc::clone(services.snapshots()));
    AlarmThread::start(alarms, snapshots, Arc::clone(services.recorder()))
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
