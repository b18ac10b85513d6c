//! A bus in a thread of its own, for asynchronous programs and for several threads.
//!
//! A [`Pending`] result can be awaited in any runtime or waited for without one. Between two requests the thread serves the
//! line: a master in a token ring must pass the token on.

use super::error::ClientError;
use super::gauge::{Gauge, ParameterReading, PressureReading, WriteResult};
use super::identify;
use crate::ms2::Ms2;
use profivac_host::readiness::{self, WakeSource};
use profivac_host::session::{BusSession, SessionError};
use std::future::Future;
use std::io;
use std::pin::Pin;
use std::sync::mpsc::{Receiver, Sender, TryRecvError, channel};
use std::sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError};
use std::task::{Context, Poll, Waker};
use std::thread;
use std::time::Duration;

/// The longest wait of the thread without a request.
const IDLE_WAIT: Duration = Duration::from_secs(1);

/// A request to the thread.
type Job = Box<dyn FnOnce(&mut BusSession) + Send>;

/// A bus in a thread. The thread ends with the last handle, or when the port is lost.
///
/// ```
/// use profivac_client::Bus;
/// # let port = profivac_virtual::open::devices(&["bcg450@5"])?;
/// # fn block_on<T>(future: impl Future<Output = T>) -> T {
/// #     struct Unpark(std::thread::Thread);
/// #     impl std::task::Wake for Unpark {
/// #         fn wake(self: std::sync::Arc<Self>) {
/// #             self.0.unpark();
/// #         }
/// #     }
/// #     let mut future = std::pin::pin!(future);
/// #     let waker = std::sync::Arc::new(Unpark(std::thread::current())).into();
/// #     let mut context = std::task::Context::from_waker(&waker);
/// #     loop {
/// #         match future.as_mut().poll(&mut context) {
/// #             std::task::Poll::Ready(value) => return value,
/// #             std::task::Poll::Pending => std::thread::park(),
/// #         }
/// #     }
/// # }
///
/// # /*
/// let bus = Bus::builder("/dev/ttyUSB0").open_async()?;
/// # */
/// # let bus = Bus::builder("sim").open_async_on(port)?;
/// # block_on(async {
/// let state = bus.gauge(5).parameter("device.device-state").await?;
/// println!("{}", state.text);
/// # Ok::<(), profivac_client::BusError>(())
/// # })?;
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone)]
pub struct AsyncBus {
    jobs: Sender<Job>,
    wake: readiness::Waker,
}

/// A gauge on an [`AsyncBus`].
#[derive(Clone)]
pub struct AsyncGauge {
    bus: AsyncBus,
    address: u8,
}

/// The reason why a request to an [`AsyncBus`] failed.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum BusError {
    /// The gauge or the line failed.
    #[error(transparent)]
    Client(#[from] ClientError),
    /// The thread has ended because its port is lost.
    #[error("the bus is closed")]
    Closed,
    /// The system has no thread or no socket left.
    #[error("{0}")]
    System(#[from] io::Error),
}

impl AsyncBus {
    /// Opens a bus session in a thread of its own, and waits until it is open.
    ///
    /// # Errors
    /// The error of `open`, or [`BusError::System`].
    pub fn open(open: impl FnOnce() -> Result<BusSession, SessionError> + Send + 'static) -> Result<Self, BusError> {
        let (jobs, work) = channel();
        let (wake, source) = readiness::waker()?;
        let (promise, opened) = promise();
        let thread = move || match open() {
            Ok(session) => {
                promise.resolve(Ok(()));
                serve(session, &work, source);
            }
            Err(error) => promise.resolve(Err(error)),
        };
        thread::Builder::new().name("bus".to_owned()).spawn(thread)?;
        opened.wait()?.map_err(ClientError::from)?;
        Ok(Self { jobs, wake })
    }

    /// Runs `work` in the thread of the bus.
    pub fn submit<T: Send + 'static>(&self, work: impl FnOnce(&mut BusSession) -> T + Send + 'static) -> Pending<T> {
        let (promise, pending) = promise();
        // If the thread has ended, the job is dropped with its promise, and the result is `BusError::Closed`.
        self.jobs.send(Box::new(move |session| promise.resolve(work(session)))).ok();
        self.wake.wake();
        pending
    }

    /// The gauge at `address`. Sends nothing yet.
    #[must_use]
    pub fn gauge(&self, address: u8) -> AsyncGauge {
        AsyncGauge { bus: self.clone(), address }
    }
}

/// Serves the line and runs the jobs until the last handle is dropped or the port is lost.
fn serve(mut session: BusSession, work: &Receiver<Job>, mut wake: WakeSource) {
    loop {
        loop {
            match work.try_recv() {
                Ok(job) => job(&mut session),
                Err(TryRecvError::Empty) => break,
                Err(TryRecvError::Disconnected) => return,
            }
        }
        let Ok(readable) = session.serve(&[wake.readiness()], IDLE_WAIT) else { return };
        if readable.first() == Some(&true) && !wake.clear() {
            return;
        }
    }
}

impl AsyncGauge {
    /// Runs several requests with one [`Gauge`], which restores the Channel Instance Selector at the end.
    ///
    /// If the future is dropped, the requests still run to their end.
    ///
    /// # Errors
    /// The error of `work`, or [`BusError::Closed`].
    pub async fn with<T: Send + 'static>(
        &self,
        work: impl FnOnce(&mut Gauge<Ms2<'_>>) -> Result<T, ClientError> + Send + 'static,
    ) -> Result<T, BusError> {
        let address = self.address;
        let pending = self.bus.submit(move |session| {
            let status = identify::wait_for_slave(session, address)?;
            let mut gauge = Gauge::new(Ms2::new(session, address), address, status.ident)?;
            let result = work(&mut gauge)?;
            gauge.restore_selector()?;
            Ok::<_, ClientError>(result)
        });
        Ok(pending.await??)
    }

    /// See [`Gauge::pressure`].
    ///
    /// # Errors
    /// As [`with`](Self::with).
    pub async fn pressure(&self) -> Result<PressureReading, BusError> {
        self.with(|gauge| gauge.pressure()).await
    }

    /// See [`Gauge::parameter`].
    ///
    /// # Errors
    /// As [`with`](Self::with).
    pub async fn parameter(&self, name: &str) -> Result<ParameterReading, BusError> {
        let name = name.to_owned();
        self.with(move |gauge| gauge.parameter(&name)).await
    }

    /// See [`Gauge::write`].
    ///
    /// # Errors
    /// As [`with`](Self::with).
    pub async fn write(&self, name: &str, value: &str) -> Result<WriteResult, BusError> {
        let (name, value) = (name.to_owned(), value.to_owned());
        self.with(move |gauge| gauge.write(&name, &value)).await
    }

    /// See [`Gauge::command`].
    ///
    /// # Errors
    /// As [`with`](Self::with).
    pub async fn command(&self, name: &str) -> Result<WriteResult, BusError> {
        let name = name.to_owned();
        self.with(move |gauge| gauge.command(&name)).await
    }
}

/// The result of a request that runs in the thread of the bus.
pub struct Pending<T>(Arc<Shared<T>>);

/// The side of a [`Pending`] that provides the result.
struct Promise<T>(Arc<Shared<T>>);

struct Shared<T> {
    state: Mutex<State<T>>,
    changed: Condvar,
}

enum State<T> {
    /// No result yet; the waker of the future that waits, if one does.
    Open(Option<Waker>),
    Ready(T),
    /// The promise was dropped, or the result was taken.
    Closed,
}

fn promise<T>() -> (Promise<T>, Pending<T>) {
    let shared = Arc::new(Shared { state: Mutex::new(State::Open(None)), changed: Condvar::new() });
    (Promise(Arc::clone(&shared)), Pending(shared))
}

impl<T> Shared<T> {
    /// The state. A panic cannot leave it half changed, so a poisoned lock is usable.
    fn lock(&self) -> MutexGuard<'_, State<T>> {
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }

    fn settle(&self, state: State<T>) {
        let before = std::mem::replace(&mut *self.lock(), state);
        self.changed.notify_all();
        if let State::Open(Some(waker)) = before {
            waker.wake();
        }
    }
}

impl<T> State<T> {
    /// Takes the result. `None` while it is open.
    fn take(&mut self) -> Option<Result<T, BusError>> {
        match std::mem::replace(self, Self::Closed) {
            Self::Ready(value) => Some(Ok(value)),
            Self::Closed => Some(Err(BusError::Closed)),
            open => {
                *self = open;
                None
            }
        }
    }
}

impl<T> Promise<T> {
    fn resolve(self, value: T) {
        self.0.settle(State::Ready(value));
    }
}

impl<T> Drop for Promise<T> {
    /// Closes a promise that was not resolved.
    fn drop(&mut self) {
        let is_open = matches!(*self.0.lock(), State::Open(_));
        if is_open {
            self.0.settle(State::Closed);
        }
    }
}

impl<T> Pending<T> {
    /// Blocks until the result is there.
    ///
    /// # Errors
    /// [`BusError::Closed`] when the thread has ended.
    pub fn wait(self) -> Result<T, BusError> {
        let mut state = self.0.lock();
        loop {
            if let Some(value) = state.take() {
                return value;
            }
            state = self.0.changed.wait(state).unwrap_or_else(PoisonError::into_inner);
        }
    }
}

impl<T> Future for Pending<T> {
    type Output = Result<T, BusError>;

    fn poll(self: Pin<&mut Self>, context: &mut Context<'_>) -> Poll<Self::Output> {
        let mut state = self.0.lock();
        match state.take() {
            Some(value) => Poll::Ready(value),
            None => {
                *state = State::Open(Some(context.waker().clone()));
                Poll::Pending
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_pending_result_ends_when_its_promise_is_resolved_or_dropped() {
        let (kept, pending) = promise();
        thread::spawn(move || kept.resolve(4711));
        assert_eq!(pending.wait().unwrap(), 4711);
        let (broken, pending) = promise::<u8>();
        drop(broken);
        assert_eq!(pending.wait().unwrap_err().to_string(), "the bus is closed");
    }

    #[test]
    fn a_resolved_promise_wakes_the_task_that_awaits_it() {
        struct Bell(Sender<()>);
        impl std::task::Wake for Bell {
            fn wake(self: Arc<Self>) {
                self.0.send(()).unwrap();
            }
        }
        let (sender, woken) = channel();
        let waker = Waker::from(Arc::new(Bell(sender)));
        let mut context = Context::from_waker(&waker);
        let (kept, mut pending) = promise();
        assert!(Pin::new(&mut pending).poll(&mut context).is_pending());
        kept.resolve("done");
        woken.try_recv().unwrap();
        assert!(matches!(Pin::new(&mut pending).poll(&mut context), Poll::Ready(Ok("done"))));
    }

    #[test]
    fn opening_reports_the_error_of_the_session() {
        let opened = AsyncBus::open(|| Err(SessionError::NeverIdle));
        assert_eq!(opened.err().unwrap().to_string(), "the line is never idle");
    }
}
