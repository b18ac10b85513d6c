//! A bus in a thread of its own, for programs that do more than wait for one gauge: whoever holds a [`Bus`] hands in work, and
//! gets an [`Answer`] that can be awaited in any runtime or waited for without one.
//!
//! Between two pieces of work the thread goes on serving the line: a master in a ring must pass the token on.

use super::error::ClientError;
use super::gauge::{Gauge, ParameterReading, PressureReading, WriteResult};
use super::identify;
use crate::ms2::Ms2;
use profivac_host::session::{BusSession, SessionError};
use std::future::Future;
use std::io::{Read, Write};
use std::os::fd::AsFd;
use std::os::unix::net::UnixStream;
use std::pin::Pin;
use std::sync::mpsc::{Receiver, Sender, channel};
use std::sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError};
use std::task::{Context, Poll, Waker};
use std::thread;
use std::time::Duration;

/// How long the thread sleeps at most where nobody hands anything in.
const IDLE_WAIT: Duration = Duration::from_secs(1);

/// A piece of work.
type Job = Box<dyn FnOnce(&mut BusSession) + Send>;

/// A bus in a thread. The thread ends when the last of its handles is gone, or the port.
#[derive(Clone)]
pub struct Bus {
    jobs: Sender<Job>,
    wake: Arc<UnixStream>,
}

/// A gauge on a [`Bus`].
#[derive(Clone)]
pub struct RemoteGauge {
    bus: Bus,
    address: u8,
}

/// Why there is no answer.
#[derive(Debug, thiserror::Error)]
pub enum BusError {
    /// The gauge, or the line.
    #[error(transparent)]
    Client(#[from] ClientError),
    /// The thread has ended, because its port is gone.
    #[error("the bus is closed")]
    Closed,
    /// The system has no thread or no socket left.
    #[error("{0}")]
    System(std::io::Error),
}

impl Bus {
    /// Makes the master in a thread of its own, and waits until it is there.
    ///
    /// # Errors
    /// What `make` says, and [`BusError::System`].
    pub fn open(make: impl FnOnce() -> Result<BusSession, SessionError> + Send + 'static) -> Result<Self, BusError> {
        let (jobs, work) = channel();
        let (bell, heard) = UnixStream::pair().map_err(BusError::System)?;
        bell.set_nonblocking(true).and_then(|()| heard.set_nonblocking(true)).map_err(BusError::System)?;
        let (promise, made) = promise();
        let thread = move || match make() {
            Ok(tool) => {
                promise.resolve(Ok(()));
                serve(tool, &work, heard);
            }
            Err(error) => promise.resolve(Err(error)),
        };
        thread::Builder::new().name("bus".to_owned()).spawn(thread).map_err(BusError::System)?;
        made.wait()?.map_err(ClientError::from)?;
        Ok(Self { jobs, wake: Arc::new(bell) })
    }

    /// Hands in work for the master.
    pub fn submit<T: Send + 'static>(&self, work: impl FnOnce(&mut BusSession) -> T + Send + 'static) -> Pending<T> {
        let (promise, answer) = promise();
        // A job that cannot be sent is dropped, and its promise with it: the answer is that the bus is closed.
        self.jobs.send(Box::new(move |tool| promise.resolve(work(tool)))).ok();
        // A full bell rings already.
        (&*self.wake).write_all(&[0]).ok();
        answer
    }

    /// The gauge at `address`.
    #[must_use]
    pub fn gauge(&self, address: u8) -> RemoteGauge {
        RemoteGauge { bus: self.clone(), address }
    }
}

/// Serves the line, and does what is handed in, until nobody can hand anything in any more or the port is gone.
fn serve(mut tool: BusSession, work: &Receiver<Job>, mut bell: UnixStream) {
    let mut rung = [0; 64];
    loop {
        loop {
            match work.try_recv() {
                Ok(job) => job(&mut tool),
                Err(std::sync::mpsc::TryRecvError::Empty) => break,
                Err(std::sync::mpsc::TryRecvError::Disconnected) => return,
            }
        }
        let Ok(readable) = tool.serve(&[bell.as_fd()], IDLE_WAIT) else { return };
        if readable.first() == Some(&true) && bell.read(&mut rung).is_ok_and(|octets| octets == 0) {
            return;
        }
    }
}

impl RemoteGauge {
    /// Works with the gauge over MS2, and leaves it as it was found.
    ///
    /// # Errors
    /// What the work says; [`BusError::Closed`].
    pub async fn with<T: Send + 'static>(
        &self,
        work: impl FnOnce(&mut Gauge<Ms2<'_>>) -> Result<T, ClientError> + Send + 'static,
    ) -> Result<T, BusError> {
        let address = self.address;
        let answer = self.bus.submit(move |tool| {
            let seen = identify::wait_for_slave(tool, address)?;
            let mut gauge = Gauge::new(Ms2::new(tool, address), address, seen.ident)?;
            let done = work(&mut gauge);
            let left = gauge.restore_selector();
            let done = done?;
            left.map(|()| done)
        });
        Ok(answer.await??)
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

/// What will be known when the work is done.
pub struct Pending<T>(Arc<Shared<T>>);

/// The other end of an answer.
struct Promise<T>(Arc<Shared<T>>);

struct Shared<T> {
    state: Mutex<State<T>>,
    changed: Condvar,
}

enum State<T> {
    Open(Option<Waker>),
    Ready(T),
    /// Broken, or taken already.
    Closed,
}

fn promise<T>() -> (Promise<T>, Pending<T>) {
    let shared = Arc::new(Shared { state: Mutex::new(State::Open(None)), changed: Condvar::new() });
    (Promise(Arc::clone(&shared)), Pending(shared))
}

impl<T> Shared<T> {
    /// Nothing in here can be half done.
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
    /// What is there, if anything ever will be.
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
    /// One that was not kept will not be.
    fn drop(&mut self) {
        let is_open = matches!(*self.0.lock(), State::Open(_));
        if is_open {
            self.0.settle(State::Closed);
        }
    }
}

impl<T> Pending<T> {
    /// Waits for it.
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
    fn an_answer_is_there_when_the_promise_is_kept_or_broken() {
        let (kept, answer) = promise();
        thread::spawn(move || kept.resolve(4711));
        assert_eq!(answer.wait().unwrap(), 4711);
        let (broken, answer) = promise::<u8>();
        drop(broken);
        assert_eq!(answer.wait().unwrap_err().to_string(), "the bus is closed");
    }

    #[test]
    fn whoever_awaits_is_woken() {
        struct Bell(Sender<()>);
        impl std::task::Wake for Bell {
            fn wake(self: Arc<Self>) {
                self.0.send(()).unwrap();
            }
        }
        let (sender, woken) = channel();
        let waker = Waker::from(Arc::new(Bell(sender)));
        let mut context = Context::from_waker(&waker);
        let (kept, mut answer) = promise();
        assert!(Pin::new(&mut answer).poll(&mut context).is_pending());
        kept.resolve("done");
        woken.try_recv().unwrap();
        assert!(matches!(Pin::new(&mut answer).poll(&mut context), Poll::Ready(Ok("done"))));
    }

    #[test]
    fn a_port_that_is_not_there_is_told_at_once() {
        let opened = Bus::open(|| Err(SessionError::NeverIdle));
        assert_eq!(opened.err().unwrap().to_string(), "the line is never quiet");
    }
}
