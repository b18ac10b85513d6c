//! What a session with the servers and the database reports, and the pause before the next one.

use crate::metrics::{Metrics, Retained};
use crate::store::{Dropped, Store, StoreError, Stored};
use profivac_archive_protocol::nats::NatsError;
use profivac_recorder::Micros;
use std::pin::pin;
use std::time::Duration;
use thiserror::Error;
use tokio::sync::watch;
use tokio::time::{Instant, sleep, timeout};

/// The time between two looks at partitions and retention.
const MAINTENANCE_INTERVAL: Duration = Duration::from_secs(3_600);

/// The same while a reader holds partitions that are to be dropped. chosen: each look delays statements by up to a second for each of
/// them.
const HELD_INTERVAL: Duration = Duration::from_secs(300);

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

impl ArchiveError {
    /// Counts the error.
    pub fn count(&self, metrics: &Metrics) {
        match self {
            Self::Nats(_) => metrics.nats_failed(),
            Self::Store(error) => metrics.database_failed(error.state()),
        }
    }
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
    /// What happens to samples that are older than the retention, in a sentence.
    Retention(String),
    /// Days that are over and could not be packed, in a sentence.
    Packing(String),
    /// Roles of the database to which the views show nothing, in a sentence.
    Roles(String),
    /// A batch of a station was put aside; the sentence says why. Later ones of the station with such a reason are not reported for an hour.
    PutAside(String),
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

/// The looks at partitions and retention.
pub struct Maintenance {
    /// When the next one is due.
    pub at: Instant,
    /// What the last one said.
    said: Vec<String>,
}

impl Default for Maintenance {
    fn default() -> Self {
        Self { at: Instant::now(), said: Vec::new() }
    }
}

impl Maintenance {
    /// Makes partitions, names roles without rows, and drops the samples that are older than the retention, in words before and after. While a reader holds some of
    /// them, it looks again sooner, and says the same only once.
    ///
    /// # Errors
    /// [`StoreError`] when the database refuses.
    pub async fn run(
        &mut self,
        store: &mut Store,
        metrics: &Metrics,
        report: &mut impl FnMut(Report<'_>),
    ) -> Result<(), StoreError> {
        noticed(SILENCE, store.maintain(Micros::now()), report).await?;
        let mut said: Vec<String> = noticed(SILENCE, store.roles_without_rows(), report).await?.into_iter().collect();
        self.say(&said, Report::Roles, report);
        let old = noticed(SILENCE, store.old_days(Micros::now()), report).await?;
        let before: Vec<_> = old.sentence().into_iter().collect();
        self.say(&before, Report::Retention, report);
        said.extend(before);
        let dropped = match old.are_few() {
            true => noticed(SILENCE, store.drop_days(&old), report).await?,
            false => Dropped::default(),
        };
        let after: Vec<_> = dropped.gone().into_iter().chain(dropped.stays()).collect();
        self.say(&after, Report::Retention, report);
        said.extend(after);
        self.said = said;
        let pause = if dropped.held() > 0 { HELD_INTERVAL } else { MAINTENANCE_INTERVAL };
        self.at = Instant::now() + pause;
        let now = Micros::now();
        let waiting = old.partitions().saturating_sub(dropped.partitions) as u64;
        let [gone, timeouts] = [dropped.partitions, dropped.timeouts].map(|count| count as u64);
        metrics.retained(Retained { last: now, next: now.after(pause), dropped: gone, waiting, timeouts });
        Ok(())
    }

    fn say(&self, sentences: &[String], of: fn(String) -> Report<'static>, report: &mut impl FnMut(Report<'_>)) {
        let new = sentences.iter().filter(|sentence| !self.said.contains(sentence));
        new.for_each(|sentence| report(of(sentence.clone())));
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
