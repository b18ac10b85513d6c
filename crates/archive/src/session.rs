//! What a session with the servers and the database reports, and the pause before the next one.

use crate::store::{StoreError, Stored};
use profivac_archive_protocol::nats::NatsError;
use std::pin::pin;
use std::time::Duration;
use thiserror::Error;
use tokio::sync::watch;
use tokio::time::{sleep, timeout};

/// The time between two looks at partitions and retention.
pub const MAINTENANCE_INTERVAL: Duration = Duration::from_secs(3_600);

/// A database that has not answered for this time is reported. chosen: longer than a usual transaction takes.
pub const SILENCE: Duration = Duration::from_secs(30);

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
    /// It has failed and tries again.
    Failed(&'a ArchiveError),
    /// The stream was created with other settings than those of the file; the sentence says what to do.
    OtherStream(String),
    /// The database has not answered for this time. The archive waits on: the system ends the connection when the server is gone.
    Silent(Duration),
}

/// Waits for the database, and reports once when it has not answered within `silence`. A server that is stopped keeps its connections, and
/// no statement ends.
pub async fn noticed<T>(silence: Duration, work: impl Future<Output = T>, report: &mut impl FnMut(Report<'_>)) -> T {
    let mut work = pin!(work);
    match timeout(silence, &mut work).await {
        Ok(done) => done,
        Err(_) => {
            report(Report::Silent(silence));
            work.await
        }
    }
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

#[cfg(test)]
mod tests {
    use super::*;
    use tokio::sync::oneshot;

    #[tokio::test]
    async fn a_database_that_is_silent_is_reported_once_and_waited_for() {
        let (answer, answered) = oneshot::channel();
        let mut answer = Some(answer);
        let mut silences = Vec::new();
        let silence = Duration::from_millis(10);
        // The database answers only after the report.
        let mut report = |it: Report<'_>| {
            if let Report::Silent(time) = it {
                silences.push(time);
            }
            if let Some(answer) = answer.take() {
                answer.send(7).ok();
            }
        };
        // Without a report there is no answer.
        let done = timeout(Duration::from_secs(60), noticed(silence, answered, &mut report)).await;
        assert_eq!(done.expect("no report"), Ok(7));
        assert_eq!(silences, [silence]);
    }

    #[tokio::test]
    async fn a_database_that_answers_is_not_reported() {
        let mut count = 0;
        let done = noticed(Duration::from_secs(3_600), async { 7 }, &mut |_: Report<'_>| count += 1).await;
        assert_eq!((done, count), (7, 0));
    }
}
