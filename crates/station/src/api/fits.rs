//! Fits of plants: one at a time on a thread of their own, stopped when their user has gone or after a time limit.

use profivac_web_server::problem::{Problem, task_failed};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};
use tokio::sync::{OwnedSemaphorePermit, Semaphore};
use tokio::task::spawn_blocking;

/// The longest wait for the fit of another user. chosen
const WAIT: Duration = Duration::from_secs(30);

/// The longest fit. chosen: a usual one takes seconds
pub const LONGEST: Duration = Duration::from_secs(120);

/// The permit for one fit. A fit needs a processor core, and the segments need one too.
#[derive(Clone)]
pub struct Fits {
    permit: Arc<Semaphore>,
    wait: Duration,
}

/// The permit, taken.
pub struct Fit {
    permit: OwnedSemaphorePermit,
}

/// Stops a fit when its request ends.
struct StopWhenDropped(Arc<AtomicBool>);

impl Drop for StopWhenDropped {
    fn drop(&mut self) {
        self.0.store(true, Ordering::Relaxed);
    }
}

impl Fits {
    /// A permit that is free.
    pub fn new() -> Self {
        Self { permit: Arc::new(Semaphore::new(1)), wait: WAIT }
    }

    /// Waits until no other fit runs.
    pub async fn begin(&self) -> Result<Fit, Problem> {
        match tokio::time::timeout(self.wait, Arc::clone(&self.permit).acquire_owned()).await {
            Ok(Ok(permit)) => Ok(Fit { permit }),
            Ok(Err(_)) | Err(_) => {
                Err(Problem::unavailable("the station fits another plant at present; try again later"))
            }
        }
    }
}

impl Fit {
    /// Runs the work, which calls its argument often and ends when that is true. The permit is free when the work ends.
    pub async fn run<T: Send + 'static>(
        self,
        work: impl FnOnce(&dyn Fn() -> bool) -> T + Send + 'static,
    ) -> Result<T, Problem> {
        let gone = Arc::new(AtomicBool::new(false));
        let _stop = StopWhenDropped(Arc::clone(&gone));
        let task = spawn_blocking(move || {
            let _permit = self.permit;
            let begun = Instant::now();
            work(&|| gone.load(Ordering::Relaxed) || begun.elapsed() > LONGEST)
        });
        task.await.map_err(|error| task_failed(&error))
    }
}

#[cfg(test)]
#[allow(clippy::unwrap_used, reason = "a test")]
mod tests {
    use super::*;
    use std::sync::mpsc::channel;

    #[tokio::test(flavor = "multi_thread", worker_threads = 2)]
    async fn a_fit_is_stopped_when_its_request_ends_and_the_next_one_begins_after_it() {
        let fits = Fits::new();
        let (begun, has_begun) = channel();
        let (ended, has_ended) = channel();
        let first = fits.begin().await.unwrap();
        let request = tokio::spawn(first.run(move |stopped: &dyn Fn() -> bool| {
            begun.send(()).unwrap();
            while !stopped() {
                std::thread::yield_now();
            }
            ended.send(()).unwrap();
        }));
        tokio::task::block_in_place(|| has_begun.recv()).unwrap();
        request.abort();
        let second = fits.begin().await.unwrap();
        // The permit is free only after the first one has ended.
        assert!(has_ended.try_recv().is_ok());
        assert!(!second.run(|stopped: &dyn Fn() -> bool| stopped()).await.unwrap());
    }

    #[tokio::test]
    async fn a_fit_that_cannot_begin_is_refused_with_the_reason() {
        let fits = Fits { wait: Duration::ZERO, ..Fits::new() };
        let _first = fits.begin().await.unwrap();
        let problem = fits.begin().await.err().unwrap();
        assert!(problem.to_string().contains("fits another plant at present; try again later"), "{problem}");
    }
}
