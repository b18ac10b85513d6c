//! The thread that looks at the plant a few times a second, for as long as the station runs.

use super::judge::Sight;
use crate::plant::Plant;
use std::sync::Arc;
use std::sync::mpsc::{Receiver, RecvTimeoutError, Sender, channel};
use std::thread::JoinHandle;
use std::time::Duration;

/// How often. free choice: as often as the dashboard is told.
const PERIOD: Duration = Duration::from_millis(250);

/// A thread that looks. It ends when this is dropped.
pub struct Watcher {
    stop: Option<Sender<()>>,
    thread: Option<JoinHandle<()>>,
}

impl Watcher {
    /// Begins to look.
    ///
    /// # Errors
    /// When the system gives no thread.
    pub fn start(plant: Arc<Plant>) -> std::io::Result<Self> {
        let (stop, stopped) = channel();
        let thread = std::thread::Builder::new().name("alarms".to_owned());
        let thread = thread.spawn(move || watch(&plant, &stopped))?;
        Ok(Self { stop: Some(stop), thread: Some(thread) })
    }

    /// Whether its thread has ended, which only a defect can bring about.
    #[must_use]
    pub fn has_ended(&self) -> bool {
        self.thread.as_ref().is_none_or(JoinHandle::is_finished)
    }
}

impl Drop for Watcher {
    fn drop(&mut self) {
        self.stop = None;
        if let Some(thread) = self.thread.take() {
            thread.join().ok();
        }
    }
}

fn watch(plant: &Plant, stopped: &Receiver<()>) {
    while stopped.recv_timeout(PERIOD) == Err(RecvTimeoutError::Timeout) {
        plant.alarms().look(plant.recorder(), &sight(plant));
    }
}

/// What the plant shows now.
#[must_use]
pub fn sight(plant: &Plant) -> Sight {
    Sight { segments: plant.segments(), gauges: plant.gauges(), unrecorded: plant.recorder().health().error }
}
