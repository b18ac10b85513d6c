//! Queries of the database on blocking threads, few at a time.

use crate::services::Services;
use axum::body::Body;
use profivac_recorder::Reader;
use profivac_web_server::problem::{Problem, task_failed};
use std::fmt::Display;
use std::sync::Arc;
use std::time::Duration;
use tokio::sync::{Semaphore, mpsc};
use tokio::task::spawn_blocking;
use tokio_stream::wrappers::ReceiverStream;

/// Queries that run at the same time. chosen: more would make the disk seek and slow down the segments.
const MAX_QUERIES: usize = 4;

/// The longest wait for a query to begin.
const QUERY_TIMEOUT: Duration = Duration::from_secs(10);

/// An export ends when its client takes no chunk for this time.
const CHUNK_TIMEOUT: Duration = Duration::from_secs(60);

/// Readers of the database.
#[derive(Clone)]
pub struct DatabaseReaders {
    services: Arc<Services>,
    slots: Arc<Semaphore>,
}

impl DatabaseReaders {
    /// Readers of the database of a station.
    pub fn of(services: Arc<Services>) -> Self {
        Self { services, slots: Arc::new(Semaphore::new(MAX_QUERIES)) }
    }

    /// Runs a query as soon as a slot is free.
    pub async fn read<T: Send + 'static>(
        &self,
        query: impl FnOnce(Reader) -> Result<T, Problem> + Send + 'static,
    ) -> Result<T, Problem> {
        let services = Arc::clone(&self.services);
        self.run_in_slot(move || query(services.recorder().open_reader()?)).await?
    }

    /// An export as the body of an answer. Each chunk is read when the client has taken the one before; between two chunks the
    /// export has no slot. Empty chunks are not sent.
    pub fn stream_export<T, E>(&self, mut export: impl Iterator<Item = Result<T, E>> + Send + 'static) -> Body
    where
        T: Into<Vec<u8>> + Send + 'static,
        E: Display + Send + 'static,
    {
        let (chunks, body) = mpsc::channel(1);
        let readers = self.clone();
        tokio::spawn(async move {
            loop {
                let (chunk, rest) = match readers.run_in_slot(move || (export.next(), export)).await {
                    Ok((Some(chunk), rest)) => (chunk, rest),
                    Ok((None, _)) | Err(_) => return,
                };
                export = rest;
                let chunk = chunk.map(Into::into).map_err(|error| std::io::Error::other(error.to_string()));
                if chunk.as_ref().is_ok_and(Vec::is_empty) {
                    continue;
                }
                if chunks.send_timeout(chunk, CHUNK_TIMEOUT).await.is_err() {
                    return;
                }
            }
        });
        Body::from_stream(ReceiverStream::new(body))
    }

    async fn run_in_slot<T: Send + 'static>(&self, work: impl FnOnce() -> T + Send + 'static) -> Result<T, Problem> {
        let slot = tokio::time::timeout(QUERY_TIMEOUT, Arc::clone(&self.slots).acquire_owned()).await;
        let Ok(Ok(slot)) = slot else {
            return Err(Problem::unavailable("too many queries of the database at the same time; try again later"));
        };
        // The slot is free when the work ends, even if the client has disconnected.
        let task = spawn_blocking(move || {
            let _slot = slot;
            work()
        });
        task.await.map_err(|error| task_failed(&error))
    }
}
