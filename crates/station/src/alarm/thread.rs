//! The thread that looks at the plant a few times a second, for as long as the station runs.

use super::evaluate::Inputs;
use crate::services::Services;
use std::sync::Arc;
use std::sync::mpsc::{Receiver, RecvTimeoutError, Sender, channel};
use std::thread::JoinHandle;
use std::time::Duration;

/// How often. free choice: as often as the dashboard is told.
const PERIOD: Duration = Duration::from_millis(250);

/// A thread that looks. It ends when this is dropped.
pub struct AlarmThread {
    stop: Option<Sender<()>>,
    thread: Option<JoinHandle<()>>,
}

impl AlarmThread {
    /// Begins to look.
    ///
    /// # Errors
    /// When the system gives no thread.
    pub fn start(plant: Arc<Services>) -> std::io::Result<Self> {
        let (stop, stopped) = channel();
        let thread = std::thread::Builder::new().name("alarms".to_owned());
        let thread = thread.spawn(move || run(&plant, &stopped))?;
        Ok(Self { stop: Some(stop), thread: Some(thread) })
    }

    /// Whether its thread has ended, which only a defect can bring about.
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

fn run(plant: &Services, stopped: &Receiver<()>) {
    while stopped.recv_timeout(PERIOD) == Err(RecvTimeoutError::Timeout) {
        plant.alarms().evaluate(plant.recorder(), &inputs(plant));
    }
}

/// What the plant shows now.
#[must_use]
pub fn inputs(plant: &Services) -> Inputs {
    Inputs { segments: plant.segments(), gauges: plant.gauges(), recorder_error: plant.recorder().health().error }
}
