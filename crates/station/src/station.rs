//! The station as a whole: a recorder, a thread for each segment, and somebody who starts one again that has died.

use crate::config::Config;
use crate::plant::Plant;
use crate::recorder::{EventKind, Recorder, Settings, StoreError};
use crate::segment::Running;
use std::sync::Arc;

/// Why a station does not begin.
#[derive(Debug, thiserror::Error)]
pub enum StationError {
    /// The record.
    #[error(transparent)]
    Store(#[from] StoreError),
    /// The system.
    #[error("the system gives no thread: {0}")]
    Thread(#[from] std::io::Error),
}

/// A station that runs.
pub struct Station {
    plant: Arc<Plant>,
    segments: Vec<Running>,
}

impl Station {
    /// Begins to record and to watch.
    ///
    /// # Errors
    /// [`StationError`] when the record cannot be kept, or the system gives no threads.
    pub fn start(config: Config) -> Result<Self, StationError> {
        let recorder = Recorder::start(&config.record, Settings::default())?;
        let plant = Arc::new(Plant::new(config.name, config.record, recorder));
        plant.note(None, EventKind::Station, "the station begins");
        let start = |segment| Running::start(segment, Arc::clone(&plant));
        let segments = config.segments.into_iter().map(start).collect::<Result<_, _>>()?;
        Ok(Self { plant, segments })
    }

    /// What all threads share.
    #[must_use]
    pub fn plant(&self) -> Arc<Plant> {
        Arc::clone(&self.plant)
    }

    /// Becomes what a changed file says. What did not change goes on; the record and the address of the dashboard stay as
    /// they are until the station is started again.
    ///
    /// # Errors
    /// When the system gives no threads.
    pub fn become_like(&mut self, config: Config) -> std::io::Result<()> {
        let mut old = std::mem::take(&mut self.segments);
        for new in config.segments {
            let place = old.iter().position(|segment| segment.config().name == new.name && segment.can_become(&new));
            self.segments.push(match place.map(|place| old.remove(place)) {
                Some(mut kept) => {
                    kept.become_like(new);
                    kept
                }
                None => {
                    // A port cannot be opened twice: whoever has it goes first.
                    if let Some(place) = old.iter().position(|segment| segment.config().port == new.port) {
                        old.remove(place).stop();
                    }
                    Running::start(new, Arc::clone(&self.plant))?
                }
            });
        }
        old.into_iter().for_each(Running::stop);
        self.plant.note(None, EventKind::Station, "the file was read again");
        Ok(())
    }

    /// Starts segments again whose thread has died. To be called every now and then.
    ///
    /// # Errors
    /// When the system gives no threads.
    pub fn watch(&mut self) -> std::io::Result<()> {
        for segment in &mut self.segments {
            if segment.has_ended() {
                let config = segment.config().clone();
                self.plant.note(
                    None,
                    EventKind::Station,
                    format!("segment {} has died and is started again", config.name),
                );
                *segment = Running::start(config, Arc::clone(&self.plant))?;
            }
        }
        Ok(())
    }

    /// Gives all slaves back and ends.
    pub fn stop(self) {
        self.segments.into_iter().for_each(Running::stop);
        self.plant.note(None, EventKind::Station, "the station ends");
    }
}
