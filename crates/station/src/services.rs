//! What all threads of the station share: what is seen of each segment now, the recorder, and the questions that are asked.

use crate::alarm::AlarmService;
use crate::control::ControlState;
use crate::control::armed_commands::ArmedCommand;
use crate::control::operation::{Operation, OperationError, OperationPreview, Readback};
use crate::view::{Block, Gauge, ReadProgress, RecorderView, Segment, SegmentState, Station, duration_ms, unix_ms};
use crate::webhook::DeliveryStatus;
use profivac_recorder::{DatabaseError, Event, EventKind, Micros, Quality, Reader, Recorder, Sample};
use std::collections::BTreeMap;
use std::path::PathBuf;
use std::sync::mpsc::{Receiver, RecvTimeoutError, SyncSender, sync_channel};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError, RwLock};
use std::time::{Duration, Instant};
use tokio::sync::Semaphore;

/// What a segment shows.
#[derive(Clone, Debug, PartialEq)]
pub struct SegmentSnapshot {
    /// The segment.
    pub segment: Segment,
    /// Its gauges, in the order of the file.
    pub gauges: Vec<Gauge>,
}

/// Something that a segment is asked to do beside its cycle.
pub enum SegmentRequest {
    /// The blocks of the gauge of this name, with what their parameters show.
    Blocks(String, SyncSender<Result<Vec<Block>, String>>),
    /// What the gauge of this name says to what somebody wants; nothing is changed.
    Preview(String, Operation, SyncSender<Result<OperationPreview, OperationError>>),
    /// What was armed is to be done, unless it is not begun by then.
    Execute(Box<ArmedCommand>, Instant, SyncSender<Result<Readback, OperationError>>),
}

/// Why a question has no answer.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum SegmentRequestError {
    /// There is no such gauge.
    #[error("there is no gauge {0:?}")]
    Unknown(String),
    /// The segment is asked too much at once.
    #[error("the segment is busy with other questions")]
    Busy,
    /// The segment does not run, or the gauge does not answer.
    #[error("{0}")]
    Refused(String),
    /// It took too long.
    #[error("no answer in time")]
    Timeout,
}

/// So many questions may wait for a segment.
const QUESTIONS: usize = 8;

/// So many of them may be for the parameters of a gauge: who only looks leaves room for those who act.
const LOOKS: usize = 2;

/// So long may an answer take: a few hundred parameters at a slow rate.
const PATIENCE: Duration = Duration::from_secs(60);

fn now(gauge: Option<&str>, kind: EventKind, text: String) -> Event {
    Event { at: Micros::now(), gauge: gauge.map(str::to_owned), kind, text }
}

/// A segment that has shown nothing for so long hangs in something that takes longer than anything should.
const QUIET: Duration = Duration::from_secs(15);

/// A segment as it is to be seen so long after it was shown.
fn segment_after(segment: &Segment, since: Duration) -> Segment {
    let mut segment = segment.clone();
    if since > QUIET {
        segment.state = SegmentState::Waiting;
        segment.trouble = Some(format!("its thread has given no sign of life for {} s", since.as_secs()));
    }
    segment
}

/// A gauge as it is to be seen so long after it was shown: its readings grow old.
fn gauge_after(gauge: &Gauge, since: Duration) -> Gauge {
    let age_ms = gauge.age_ms.map(|age| age.saturating_add(duration_ms(since)));
    Gauge { age_ms, ..gauge.clone() }
}

/// The way to a segment.
#[derive(Clone)]
struct Line {
    sender: SyncSender<SegmentRequest>,
    looks: Arc<Semaphore>,
}

/// What all threads share.
pub struct Services {
    name: String,
    started: Micros,
    file: PathBuf,
    recorder: Recorder,
    /// Segments by name, with when they were shown last.
    scenery: RwLock<BTreeMap<String, (Instant, SegmentSnapshot)>>,
    questions: Mutex<BTreeMap<String, Line>>,
    acts: ControlState,
    reading: Mutex<Vec<ReadProgress>>,
    alarms: AlarmService,
    webhooks: DeliveryStatus,
}

impl Services {
    /// A plant that nothing is known of yet. `file` is the recorder's.
    #[must_use]
    pub fn new(name: String, file: PathBuf, recorder: Recorder) -> Self {
        Self {
            name,
            started: Micros::now(),
            file,
            recorder,
            scenery: RwLock::new(BTreeMap::new()),
            questions: Mutex::new(BTreeMap::new()),
            acts: ControlState::default(),
            reading: Mutex::new(Vec::new()),
            alarms: AlarmService::default(),
            webhooks: DeliveryStatus::default(),
        }
    }

    /// Its name.
    #[must_use]
    pub fn name(&self) -> &str {
        &self.name
    }

    /// The alarms.
    #[must_use]
    pub const fn alarms(&self) -> &AlarmService {
        &self.alarms
    }

    /// How those are who are told of alarms.
    #[must_use]
    pub const fn webhooks(&self) -> &DeliveryStatus {
        &self.webhooks
    }

    /// The recorder.
    pub const fn recorder(&self) -> &Recorder {
        &self.recorder
    }

    /// Who may act, and what is armed.
    pub const fn control(&self) -> &ControlState {
        &self.acts
    }

    /// How far the parameters of gauges are read that are being read now.
    #[must_use]
    pub fn read_progress(&self) -> Vec<ReadProgress> {
        self.reading.lock().unwrap_or_else(PoisonError::into_inner).clone()
    }

    /// So many parameters of a gauge are read; all means that nothing is being read any more.
    pub fn set_read_progress(&self, gauge: &str, done: usize, of: usize) {
        let mut reading = self.reading.lock().unwrap_or_else(PoisonError::into_inner);
        reading.retain(|other| other.gauge != gauge);
        if done < of {
            reading.push(ReadProgress { gauge: gauge.to_owned(), done, of });
        }
    }

    /// When it began.
    #[must_use]
    pub const fn started(&self) -> Micros {
        self.started
    }

    /// A reader of what was recorded.
    ///
    /// # Errors
    /// [`StoreError`] when the file is gone.
    pub fn open_reader(&self) -> Result<Reader, DatabaseError> {
        Reader::open(&self.file)
    }

    /// Something happened now; it is on the disk when this returns, unless the disk does not take it in time. For people:
    /// whoever serves a line [remarks](Self::remark).
    pub fn record_event_and_wait(&self, gauge: Option<&str>, kind: EventKind, text: impl Into<String>) {
        // The recorder's health says so if it cannot write.
        let _written = self.recorder.record_event_and_wait(now(gauge, kind, text.into()));
    }

    /// Something happened now. Never waits for the disk.
    pub fn record_event(&self, gauge: Option<&str>, kind: EventKind, text: impl Into<String>) {
        self.recorder.record_event(now(gauge, kind, text.into()));
    }

    /// What a segment shows from now on.
    pub fn publish(&self, scenery: SegmentSnapshot) {
        let mut all = self.scenery.write().unwrap_or_else(PoisonError::into_inner);
        all.insert(scenery.segment.name.clone(), (Instant::now(), scenery));
    }

    /// What the gauges of a segment show from now on; all else stays.
    pub fn publish_gauges(&self, segment: &str, gauges: Vec<Gauge>) {
        let mut all = self.scenery.write().unwrap_or_else(PoisonError::into_inner);
        if let Some((shown, scenery)) = all.get_mut(segment) {
            *shown = Instant::now();
            scenery.gauges = gauges;
        }
    }

    /// A segment has not ended in time: what it recorded ends here.
    pub fn abandon(&self, segment: &str) {
        self.record_event(None, EventKind::Station, format!("segment {segment} did not end in time and was left"));
        let readings =
            self.gauges().into_iter().filter(|gauge| gauge.segment == segment).flat_map(|gauge| gauge.readings);
        for reading in readings.filter(|reading| reading.quality != Quality::Gap.word()) {
            self.recorder.push(&Arc::from(reading.series), Sample::gap(Micros::now()));
        }
    }

    /// A segment is not there any more.
    pub fn forget(&self, segment: &str) {
        self.scenery.write().unwrap_or_else(PoisonError::into_inner).remove(segment);
        self.lines().remove(segment);
    }

    /// A segment takes questions from now on, here.
    pub fn accept_requests(&self, segment: &str) -> Receiver<SegmentRequest> {
        let (sender, receiver) = sync_channel(QUESTIONS);
        let looks = Arc::new(Semaphore::new(LOOKS));
        self.lines().insert(segment.to_owned(), Line { sender, looks });
        receiver
    }

    fn lines(&self) -> MutexGuard<'_, BTreeMap<String, Line>> {
        self.questions.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// The station.
    #[must_use]
    pub fn station(&self) -> Station {
        let health = self.recorder.health();
        let recorder = RecorderView {
            written_ms: health.last_write.map(unix_ms),
            error: health.error,
            lost: health.lost_samples,
            lost_events: health.lost_events,
        };
        Station {
            name: self.name.clone(),
            version: env!("CARGO_PKG_VERSION"),
            started_ms: unix_ms(self.started),
            now_ms: unix_ms(Micros::now()),
            recorder,
        }
    }

    /// All segments, by name.
    #[must_use]
    pub fn segments(&self) -> Vec<Segment> {
        let all = self.scenery.read().unwrap_or_else(PoisonError::into_inner);
        all.values().map(|(shown, scenery)| segment_after(&scenery.segment, shown.elapsed())).collect()
    }

    /// All gauges, segment by segment.
    #[must_use]
    pub fn gauges(&self) -> Vec<Gauge> {
        let all = self.scenery.read().unwrap_or_else(PoisonError::into_inner);
        let after = |(shown, scenery): &(Instant, SegmentSnapshot)| {
            let since = shown.elapsed();
            scenery.gauges.iter().map(|gauge| gauge_after(gauge, since)).collect::<Vec<_>>()
        };
        all.values().flat_map(after).collect()
    }

    /// The gauge of this name.
    #[must_use]
    pub fn gauge(&self, name: &str) -> Option<Gauge> {
        self.gauges().into_iter().find(|gauge| gauge.name == name)
    }

    /// The blocks of a gauge with what their parameters show now. Waits for the segment.
    ///
    /// # Errors
    /// [`NoAnswer`] says why there are none.
    pub fn blocks(&self, name: &str) -> Result<Vec<Block>, SegmentRequestError> {
        let (segment, _) = self.segment_and_port(name)?;
        let looks = self.line(&segment).ok_or_else(|| SegmentRequestError::Unknown(name.to_owned()))?.looks;
        let _place = looks.try_acquire().map_err(|_| SegmentRequestError::Busy)?;
        let ask = |answer| SegmentRequest::Blocks(name.to_owned(), answer);
        self.ask(&segment, name, ask)?.map_err(SegmentRequestError::Refused)
    }

    /// What a gauge says to what somebody wants; nothing is changed. Waits for the segment.
    ///
    /// # Errors
    /// [`Refusal`] says why it cannot be.
    pub fn preview(&self, name: &str, choice: Operation) -> Result<OperationPreview, OperationError> {
        let (segment, _) = self.segment_and_port(name)?;
        self.ask(&segment, name, |answer| SegmentRequest::Preview(name.to_owned(), choice, answer))?
    }

    /// What was armed is done, unless the segment has not begun by then. Waits for the segment.
    ///
    /// # Errors
    /// [`Refusal`] says what came of it instead.
    pub fn execute(&self, order: ArmedCommand, begin_by: Instant) -> Result<Readback, OperationError> {
        let (name, was) = (order.gauge.clone(), order.line.clone());
        let is = self.segment_and_port(&name)?;
        if was != is {
            let words = |(segment, port): &(String, String)| format!("segment {segment} at {port}");
            let sentence = format!("{name} was on {} when it was armed and is on {} now", words(&was), words(&is));
            return Err(OperationError::Changed(sentence));
        }
        match self.ask(&was.0, &name, |answer| SegmentRequest::Execute(Box::new(order), begin_by, answer)) {
            Ok(came) => came,
            Err(SegmentRequestError::Timeout) => {
                Err(OperationError::OutcomeUnknown("the gauge has not answered in time".to_owned()))
            }
            Err(SegmentRequestError::Refused(sentence)) => Err(OperationError::OutcomeUnknown(sentence)),
            Err(error @ (SegmentRequestError::Unknown(_) | SegmentRequestError::Busy)) => Err(error.into()),
        }
    }

    /// The segment of a gauge, and the port of that.
    ///
    /// # Errors
    /// [`NoAnswer::Unknown`].
    pub fn segment_and_port(&self, gauge: &str) -> Result<(String, String), SegmentRequestError> {
        let all = self.scenery.read().unwrap_or_else(PoisonError::into_inner);
        let has = |scenery: &SegmentSnapshot| scenery.gauges.iter().any(|other| other.name == gauge);
        let scenery = all.values().map(|(_, scenery)| scenery).find(|scenery| has(scenery));
        let line = scenery.map(|SegmentSnapshot { segment, .. }| (segment.name.clone(), segment.port.clone()));
        line.ok_or_else(|| SegmentRequestError::Unknown(gauge.to_owned()))
    }

    /// The way to a segment.
    fn line(&self, segment: &str) -> Option<Line> {
        self.lines().get(segment).cloned()
    }

    /// Asks a segment about a gauge, and waits for the answer.
    fn ask<T>(
        &self,
        segment: &str,
        gauge: &str,
        question: impl FnOnce(SyncSender<T>) -> SegmentRequest,
    ) -> Result<T, SegmentRequestError> {
        let line = self.line(segment).ok_or_else(|| SegmentRequestError::Unknown(gauge.to_owned()))?;
        let (sender, answer) = sync_channel(1);
        line.sender.try_send(question(sender)).map_err(|_| SegmentRequestError::Busy)?;
        answer.recv_timeout(PATIENCE).map_err(|error| match error {
            RecvTimeoutError::Timeout => SegmentRequestError::Timeout,
            RecvTimeoutError::Disconnected => SegmentRequestError::Refused("the segment was stopped".to_owned()),
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::view::BusStationState;

    #[test]
    fn what_is_shown_grows_old_and_a_thread_that_hangs_is_told() {
        let gauge = Gauge {
            name: "chamber".to_owned(),
            segment: "hall".to_owned(),
            address: 5,
            device: "bcg450".to_owned(),
            standing: BusStationState::Exchanging,
            trouble: None,
            exceptions: Vec::new(),
            gas: "n2".to_owned(),
            levels: Vec::new(),
            readings: Vec::new(),
            poll_ms: 200,
            age_ms: Some(12),
        };
        assert_eq!(gauge_after(&gauge, Duration::from_secs(3)).age_ms, Some(3012));
        let segment = Segment {
            name: "hall".to_owned(),
            port: "/dev/ttyUSB0".to_owned(),
            baud: 19200,
            master: 0,
            state: SegmentState::Running,
            trouble: None,
            cycle_ms: None,
            damaged: 0,
            stations: Vec::new(),
        };
        assert_eq!(segment_after(&segment, QUIET), segment);
        let hangs = segment_after(&segment, Duration::from_secs(20));
        assert_eq!(hangs.trouble.as_deref(), Some("its thread has given no sign of life for 20 s"));
        assert_eq!(hangs.state, SegmentState::Waiting);
    }
}
