//! What a session with the servers and the database reports, and the pause before the next one.

use crate::nats::NatsError;
use crate::store::{StoreError, Stored};
use std::time::Duration;
use thiserror::Error;
use tokio::sync::watch;
use tokio::time::sleep;

/// The time between two looks at partitions and retention.
pub const MAINTENANCE_INTERVAL: Duration = Duration::from_secs(3_600);

/// The pauses after a failure.
const FIRST_PAUSE: Duration = Duration::from_millis(500);
const LONGEST_PAUSE: Duration = Duration::from_secs(10);

/// Why an archive has to connect again.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum ArchiveError {
    /// The servers of NATS cannot be used.
    #[error(transparent)]
    Nats(#[from] NatsError),
    /// The database cannot be used.
    #[error(transparent)]
    Store(#[from] StoreError),
}

/// What an archive reports.
#[derive(Debug)]
pub enum Report<'a> {
    /// It takes batches.
    Ready,
    /// It has stored batches, since the start.
    Stored(Stored),
    /// It has failed and connects again.
    Failed(&'a ArchiveError),
}

/// The pauses after failures, and the last failure.
pub struct Retry {
    pause: Duration,
    last: String,
}

impl Default for Retry {
    fn default() -> Self {
        Self { pause: FIRST_PAUSE, last: String::new() }
    }
}

impl Retry {
    /// Reports a failure, unless it is the last one again, and waits.
    pub async fn after(
        &mut self,
        error: &ArchiveError,
        has_stored: bool,
        mut stop: watch::Receiver<bool>,
        report: &mut impl FnMut(Report<'_>),
    ) {
        if error.to_string() != self.last || has_stored {
            report(Report::Failed(error));
        }
        self.last = error.to_string();
        self.pause = if has_stored { FIRST_PAUSE } else { self.pause.saturating_mul(2).min(LONGEST_PAUSE) };
        tokio::select! {
            () = sleep(self.pause) => {}
            () = async { drop(stop.wait_for(|is_stopped| *is_stopped).await) } => {}
        }
    }
}
