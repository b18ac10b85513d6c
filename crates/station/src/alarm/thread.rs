//! The thread that evaluates the alarms several times a second.

use super::evaluate::Inputs;
use super::rule::Rule;
use super::service::AlarmService;
use crate::gateway_status::GatewayStatuses;
use crate::recording::RecorderHandle;
use crate::snapshot::SnapshotStore;
use std::sync::Arc;
use std::sync::mpsc::{Receiver, RecvTimeoutError, Sender, channel};
use std::thread::JoinHandle;
use std::time::Duration;

/// The time between two evaluations. chosen: the period of the dashboard's stream.
const PERIOD: Duration = Duration::from_millis(250);

/// A running alarm thread. It ends when this is dropped.
pub struct AlarmThread {
    stop: Option<Sender<()>>,
    thread: Option<JoinHandle<()>>,
}

impl AlarmThread {
    /// Starts to evaluate.
    ///
    /// # Errors
    /// When the system gives no thread.
    pub fn start(
        alarms: Arc<AlarmService>,
        snapshots: Arc<SnapshotStore>,
        recorder: Arc<RecorderHandle>,
        gateways: Arc<GatewayStatuses>,
    ) -> std::io::Result<Self> {
        let (stop, stopped) = channel();
        let suggesting = Arc::clone(&snapshots);
        let thread = std::thread::Builder::new().name("alarms".to_owned());
        let present = move || inputs(&snapshots, &recorder, &gateways);
        let thread = thread.spawn(move || run(&alarms, &suggesting, present, &stopped))?;
        Ok(Self { stop: Some(stop), thread: Some(thread) })
    }

    /// Whether the thread has ended, which only a defect can cause.
    #[must_use]
    pub fn has_ended(&self) -> bool {
        self.thread.as_ref().is_none_or(JoinHandle::is_finished)
    }
}

impl Drop for AlarmThread {
    fn drop(&mut self) {
        self.stop = None;
        if let Some(thread) = self.thread.take() {
            thread.join().ok();
        }
    }
}

fn run(alarms: &AlarmService, snapshots: &SnapshotStore, present: impl Fn() -> Inputs, stopped: &Receiver<()>) {
    while stopped.recv_timeout(PERIOD) == Err(RecvTimeoutError::Timeout) {
        for rule in alarms.evaluate(&present()) {
            suggest_capture(snapshots, &rule);
        }
    }
}

/// An alarm about a gauge or a segment triggers the flight recorder of its segment.
fn suggest_capture(snapshots: &SnapshotStore, rule: &Rule) {
    let of_gauge = || Some(snapshots.connection(rule.condition.gauge()?)?.segment);
    if let Some(segment) = rule.condition.segment().map(str::to_owned).or_else(of_gauge) {
        snapshots.buses().suggest_capture(&segment, &format!("alarm {}", rule.name));
    }
}

/// The present snapshots, and the states of the recorder and the archive.
#[must_use]
pub fn inputs(snapshots: &SnapshotStore, recorder: &RecorderHandle, gateways: &GatewayStatuses) -> Inputs {
    Inputs {
        segments: snapshots.segments(),
        gauges: snapshots.gauges(),
        buses: snapshots.buses().reports(),
        recorder_error: recorder.health().error,
        damage: recorder.damage_sentence(),
        archive: gateways.archive(),
    }
}
