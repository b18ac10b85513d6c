//! Waits without the interpreter lock, which Ctrl-C ends.

use crate::failure::Failure;
use pyo3::{PyResult, Python};
use std::mem;
use std::pin::pin;
use std::process;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::task::{Context, Poll, Wake, Waker};
use std::thread::{self, Thread};
use std::time::Duration;

/// The longest wait between two looks for a signal. chosen: a user takes it for at once.
const SIGNAL_INTERVAL: Duration = Duration::from_millis(50);

/// Wakes the thread that waits.
struct Unpark(Thread);

impl Wake for Unpark {
    fn wake(self: Arc<Self>) {
        self.0.unpark();
    }
}

/// Waits for the result of a request. Other threads of the interpreter run meanwhile.
///
/// # Errors
/// The exception of a signal handler: `KeyboardInterrupt` for Ctrl-C. The request then still runs to its end.
pub fn wait<T>(py: Python<'_>, future: impl Future<Output = T>) -> PyResult<T> {
    let waker = Waker::from(Arc::new(Unpark(thread::current())));
    let (mut context, mut future) = (Context::from_waker(&waker), pin!(future));
    loop {
        if let Poll::Ready(value) = future.as_mut().poll(&mut context) {
            return Ok(value);
        }
        py.detach(|| thread::park_timeout(SIGNAL_INTERVAL));
        py.check_signals()?;
    }
}

/// What a thread of this process serves. A fork does not copy the thread, so the child must not use it, not even to drop it.
pub struct Owned<T> {
    inner: Mutex<Option<T>>,
    process: u32,
    name: &'static str,
}

impl<T> Owned<T> {
    /// Owned by this process. `name` is for errors.
    pub fn new(inner: T, name: &'static str) -> Self {
        Self { inner: Mutex::new(Some(inner)), process: process::id(), name }
    }

    /// A poisoned lock is usable: no code between lock and unlock leaves a value half changed.
    fn lock(&self) -> MutexGuard<'_, Option<T>> {
        self.inner.lock().unwrap_or_else(PoisonError::into_inner)
    }

    fn is_forked(&self) -> bool {
        process::id() != self.process
    }

    /// Closes it without the interpreter lock: the end of a gauge may wait for the line. Returns whether it was open. No effect in
    /// a forked process.
    pub fn close(&self, py: Python<'_>) -> bool
    where
        T: Send,
    {
        if self.is_forked() {
            return false;
        }
        let inner = self.lock().take();
        let was_open = inner.is_some();
        py.detach(|| drop(inner));
        was_open
    }
}

impl<T: Clone> Owned<T> {
    /// A handle.
    ///
    /// # Errors
    /// It is closed, or this process is a fork of its owner.
    pub fn get(&self) -> Result<T, Failure> {
        let (name, process) = (self.name, self.process);
        if self.is_forked() {
            return Err(Failure::usage(format!(
                "this {name} belongs to process {process}, and a fork does not copy its thread; open it again in process {}",
                process::id()
            )));
        }
        self.lock().clone().ok_or_else(|| Failure::line(format!("the {name} is closed; open it again")))
    }
}

impl<T> Drop for Owned<T> {
    /// Without the lock: another thread may have held it when the process was forked, and no thread gives it back.
    fn drop(&mut self) {
        let is_forked = self.is_forked();
        let inner = self.inner.get_mut().unwrap_or_else(PoisonError::into_inner).take();
        if is_forked {
            mem::forget(inner);
        }
    }
}
