//! Reading what was recorded on behalf of many who ask at once: on threads that may wait for the disk, and only a few of them.

use super::problem::Problem;
use crate::services::Services;
use axum::body::Body;
use profivac_recorder::{DatabaseError, Export, Reader};
use std::sync::Arc;
use std::time::Duration;
use tokio::sync::{Semaphore, mpsc};
use tokio::task::{JoinError, spawn_blocking};
use tokio_stream::wrappers::ReceiverStream;

/// So many read at once. free choice: more would only make the disk seek, and keep the segments from the processor.
const READERS: usize = 4;

/// Others wait so long for their turn.
const TURN: Duration = Duration::from_secs(10);

/// Whoever takes no piece of an export for so long has gone.
const SLOWEST: Duration = Duration::from_secs(60);

/// What was recorded.
#[derive(Clone)]
pub struct DatabaseReaders {
    plant: Arc<Services>,
    turns: Arc<Semaphore>,
}

impl DatabaseReaders {
    /// The archive of a plant.
    pub fn of(plant: Arc<Services>) -> Self {
        Self { plant, turns: Arc::new(Semaphore::new(READERS)) }
    }

    /// Reads when it is our turn.
    pub async fn read<T: Send + 'static>(
        &self,
        question: impl FnOnce(Reader) -> Result<T, Problem> + Send + 'static,
    ) -> Result<T, Problem> {
        let plant = Arc::clone(&self.plant);
        self.turn(move || question(plant.open_reader()?)).await?
    }

    /// An export as the body of an answer. A piece is read when the one before was taken; between them it is nobody's turn.
    pub fn stream_export(&self, mut export: Export) -> Body {
        let (pieces, body) = mpsc::channel(1);
        let archive = self.clone();
        tokio::spawn(async move {
            loop {
                let (piece, rest) = match archive.turn(move || (export.next(), export)).await {
                    Ok((Some(piece), rest)) => (piece.map_err(Problem::from), rest),
                    Ok((None, _)) | Err(_) => return,
                };
                export = rest;
                let piece = piece.map_err(|problem| std::io::Error::other(problem.to_string()));
                if pieces.send_timeout(piece, SLOWEST).await.is_err() {
                    return;
                }
            }
        });
        Body::from_stream(ReceiverStream::new(body))
    }

    async fn turn<T: Send + 'static>(&self, work: impl FnOnce() -> T + Send + 'static) -> Result<T, Problem> {
        let turn = tokio::time::timeout(TURN, Arc::clone(&self.turns).acquire_owned()).await;
        let Ok(Ok(turn)) = turn else {
            return Err(Problem::unavailable("too much is being read at once: ask again later"));
        };
        // The turn ends with the work, even if whoever asked has gone.
        let worked = spawn_blocking(move || {
            let _turn = turn;
            work()
        });
        worked.await.map_err(|error| task_failed(&error))
    }
}

/// Why work on another thread came to nothing.
pub fn task_failed(error: &JoinError) -> Problem {
    if error.is_panic() { Problem::defect() } else { Problem::unavailable("the station is stopping") }
}

impl From<DatabaseError> for Problem {
    fn from(error: DatabaseError) -> Self {
        Self::unavailable(error.to_string())
    }
}
