//! The station as a whole: a recorder, a thread for each segment, and somebody who starts one again that has died.

use crate::alarm::{AlarmThread, NotificationTarget};
use crate::config::{Config, Webhook};
use crate::segment::SegmentHandle;
use crate::services::Services;
use crate::webhook::{DeliverySettings, DeliveryThread};
use profivac_recorder::alarms::AlarmBatch;
use profivac_recorder::{DatabaseError, EventKind, Recorder, Settings};
use std::sync::Arc;
use std::time::{Duration, Instant};

/// How long a segment may take to end: its slaves have a second to let go.
const STOP_TIMEOUT: Duration = Duration::from_millis(1500);

/// Why a station does not begin.
#[derive(Debug, thiserror::Error)]
pub enum StationError {
    /// The record.
    #[error(transparent)]
    Store(#[from] DatabaseError),
    /// The system.
    #[error("the system gives no thread: {0}")]
    Thread(#[from] std::io::Error),
}

/// A station that runs.
pub struct Station {
    plant: Arc<Services>,
    segments: Vec<SegmentHandle>,
    /// Nobody looks for alarms any more when the station ends.
    watcher: Option<AlarmThread>,
    couriers: Vec<DeliveryThread>,
    /// Somebody was told that nobody looks for alarms.
    told: bool,
}

/// When nobody has looked for alarms for so long, an event says so.
const EVALUATION_OVERDUE: Duration = Duration::from_secs(15);

impl Station {
    /// Begins to record and to watch.
    ///
    /// # Errors
    /// [`StationError`] when the record cannot be kept, or the system gives no threads.
    pub fn start(config: Config) -> Result<Self, StationError> {
        let recorder = Recorder::start(&config.database, Settings::default())?;
        let plant = Arc::new(Services::new(config.name, config.database, recorder));
        plant.record_event_and_wait(None, EventKind::Station, "the station begins");
        plant.alarms().begin(&plant, config.alarms, notification_targets(&config.webhooks))?;
        let start = |segment| SegmentHandle::start(segment, Arc::clone(&plant));
        let segments = config.segments.into_iter().map(start).collect::<Result<_, _>>()?;
        let watcher = Some(AlarmThread::start(Arc::clone(&plant))?);
        let mut station = Self { plant, segments, watcher, couriers: Vec::new(), told: false };
        station.start_deliveries(config.webhooks)?;
        Ok(station)
    }

    /// What all threads share.
    #[must_use]
    pub fn services(&self) -> Arc<Services> {
        Arc::clone(&self.plant)
    }

    /// Becomes what a changed file says. What did not change goes on; the record and the address of the dashboard stay as
    /// they are until the station is started again.
    ///
    /// # Errors
    /// When the system gives no threads.
    pub fn reconfigure(&mut self, config: Config) -> std::io::Result<()> {
        let mut old = std::mem::take(&mut self.segments);
        for new in config.segments {
            let place =
                old.iter().position(|segment| segment.config().name == new.name && segment.can_reconfigure(&new));
            self.segments.push(match place.map(|place| old.remove(place)) {
                Some(mut kept) => {
                    kept.reconfigure(new);
                    kept
                }
                None => {
                    // A port cannot be opened twice: whoever has it goes first.
                    if let Some(place) = old.iter().position(|segment| segment.config().port == new.port) {
                        old.remove(place).stop(Instant::now() + STOP_TIMEOUT);
                    }
                    SegmentHandle::start(new, Arc::clone(&self.plant))?
                }
            });
        }
        stop(old);
        self.plant.alarms().reconfigure(self.plant.recorder(), config.alarms, notification_targets(&config.webhooks));
        self.start_deliveries(config.webhooks)?;
        self.plant.record_event(None, EventKind::Station, "the file was read again");
        Ok(())
    }

    /// A courier for each webhook; those whose webhook stays go on.
    fn start_deliveries(&mut self, webhooks: Vec<Webhook>) -> std::io::Result<()> {
        let names: Vec<_> = webhooks.iter().map(|webhook| webhook.name.clone()).collect();
        self.couriers.retain(|courier| webhooks.contains(courier.webhook()));
        for webhook in webhooks {
            if !self.couriers.iter().any(|courier| *courier.webhook() == webhook) {
                self.couriers.push(DeliveryThread::start(
                    webhook,
                    Arc::clone(&self.plant),
                    DeliverySettings::default(),
                )?);
            }
        }
        // What was meant for somebody who does not stand in the file any more is for nobody.
        let gone = self
            .plant
            .open_reader()
            .and_then(|reader| reader.notifications_for_other_webhooks(&names))
            .unwrap_or_default();
        if !gone.is_empty() {
            let _room = self
                .plant
                .recorder()
                .record_alarms(AlarmBatch { finished_notifications: gone, ..AlarmBatch::default() }, Vec::new());
        }
        Ok(())
    }

    /// Starts what has died, and tells when nobody has looked for alarms for long.
    fn restart_alarm_threads(&mut self) -> std::io::Result<()> {
        if self.watcher.as_ref().is_some_and(AlarmThread::has_ended) {
            self.plant.record_event(None, EventKind::Station, "who looks for alarms has died and is started again");
            self.watcher = Some(AlarmThread::start(Arc::clone(&self.plant))?);
        }
        let is_late = self.plant.alarms().evaluated_ago().is_some_and(|ago| ago > EVALUATION_OVERDUE);
        if is_late && !self.told {
            self.plant.record_event(None, EventKind::Station, "nobody has looked for alarms for long");
        }
        self.told = is_late;
        let dead = self.couriers.iter().filter(|courier| courier.has_ended());
        let dead: Vec<_> = dead.map(|courier| courier.webhook().clone()).collect();
        self.couriers.retain(|courier| !courier.has_ended());
        for webhook in dead {
            self.couriers.push(DeliveryThread::start(webhook, Arc::clone(&self.plant), DeliverySettings::default())?);
        }
        Ok(())
    }

    /// Starts segments again whose thread has died. To be called every now and then.
    ///
    /// # Errors
    /// When the system gives no threads.
    pub fn restart_ended_threads(&mut self) -> std::io::Result<()> {
        for segment in &mut self.segments {
            if segment.has_ended() {
                let config = segment.config().clone();
                self.plant.record_event(
                    None,
                    EventKind::Station,
                    format!("segment {} has died and is started again", config.name),
                );
                *segment = SegmentHandle::start(config, Arc::clone(&self.plant))?;
            }
        }
        self.restart_alarm_threads()
    }

    /// Gives all slaves back and ends. Everything that was recorded is on the disk then, if the disk takes it.
    pub fn stop(self) {
        // Before the segments: that they end is no alarm.
        drop(self.watcher);
        self.plant.alarms().end();
        drop(self.couriers);
        stop(self.segments);
        self.plant.record_event(None, EventKind::Station, "the station ends");
        // The recorder's health says so if it cannot write, and nobody is left to read that.
        let _written = self.plant.recorder().finish();
    }
}

fn notification_targets(webhooks: &[Webhook]) -> Vec<NotificationTarget> {
    webhooks
        .iter()
        .map(|webhook| NotificationTarget { webhook: webhook.name.clone(), min_priority: webhook.min_priority })
        .collect()
}

/// Stops segments together: one that is slow does not take the time of another.
fn stop(segments: Vec<SegmentHandle>) {
    let end = Instant::now() + STOP_TIMEOUT;
    segments.iter().for_each(SegmentHandle::begin_to_stop);
    segments.into_iter().for_each(|segment| segment.stop(end));
}
