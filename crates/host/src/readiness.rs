//! Waits for several sources at once, and wakes a thread that waits.
//!
//! File descriptors stay behind [`Readiness`]: ports, sockets, standard input and signal pipes are all waited for in the same
//! way. Windows can wait so for sockets alone: what is none there, a serial port or standard input, has a thread that passes its octets on
//! through a [`pair`].

use rustix::event::{PollFd, PollFlags, Timespec, poll};
use rustix::fd::{AsFd, BorrowedFd, OwnedFd};
use rustix::io::Errno;
use std::io::{self, Read, Write};
use std::sync::Arc;
use std::time::Duration;

/// A source that can be waited for: it becomes readable when it has data or was closed.
#[derive(Clone, Copy, Debug)]
pub struct Readiness<'a>(BorrowedFd<'a>);

impl<'a> Readiness<'a> {
    /// The readiness of a file, a socket or a pipe.
    pub fn of(source: &'a impl AsFd) -> Self {
        Self(source.as_fd())
    }

    /// The same source, for as long as the caller wants.
    ///
    /// # Errors
    /// The system has no descriptor left.
    pub fn keep(&self) -> io::Result<KeptReadiness> {
        self.0.try_clone_to_owned().map(KeptReadiness)
    }
}

/// A source that outlives what it was borrowed from.
#[derive(Debug)]
pub struct KeptReadiness(OwnedFd);

impl KeptReadiness {
    /// Becomes readable with the source.
    #[must_use]
    pub fn readiness(&self) -> Readiness<'_> {
        Readiness(self.0.as_fd())
    }
}

impl AsFd for Readiness<'_> {
    fn as_fd(&self) -> BorrowedFd<'_> {
        self.0
    }
}

/// Waits until one of `sources` is readable, at most for `timeout`. Returns for each source whether it is readable.
///
/// A signal may end the wait early; then no source is readable.
///
/// ```
/// use profivac_host::readiness::{self, wait};
/// use std::time::Duration;
///
/// let (waker, mut source) = readiness::waker()?;
/// assert_eq!(wait(&[source.readiness()], Duration::ZERO)?, [false]);
/// waker.wake();
/// assert_eq!(wait(&[source.readiness()], Duration::ZERO)?, [true]);
/// source.clear();
/// # Ok::<(), std::io::Error>(())
/// ```
///
/// # Errors
/// The error of the system call.
pub fn wait(sources: &[Readiness<'_>], timeout: Duration) -> io::Result<Vec<bool>> {
    // Windows refuses to wait for nothing.
    #[cfg(windows)]
    if sources.is_empty() {
        std::thread::sleep(timeout);
        return Ok(Vec::new());
    }
    let mut events: Vec<_> = sources.iter().map(|source| PollFd::from_borrowed_fd(source.0, PollFlags::IN)).collect();
    // A timeout that the system cannot represent is longer than any program runs: wait without a limit.
    let timeout = Timespec::try_from(timeout).ok();
    match poll(&mut events, timeout.as_ref()) {
        Ok(_) | Err(Errno::INTR) => Ok(events.iter().map(|event| !event.revents().is_empty()).collect()),
        Err(errno) => Err(errno.into()),
    }
}

/// Waits until the other side of the socket `source` has closed it, at most for `timeout`, whether octets of it are waiting or not. Returns
/// whether it has.
///
/// # Errors
/// The error of the system call.
pub(crate) fn wait_until_closed(source: Readiness<'_>, timeout: Duration) -> io::Result<bool> {
    // Linux reports HUP only when both directions are closed.
    #[cfg(target_os = "linux")]
    let closed = PollFlags::RDHUP;
    #[cfg(not(any(target_os = "linux", windows)))]
    let closed = PollFlags::HUP;
    // Windows reports HUP unasked, and refuses a question for it.
    #[cfg(windows)]
    let closed = PollFlags::empty();
    let mut event = [PollFd::from_borrowed_fd(source.0, closed)];
    let timeout = Timespec::try_from(timeout).ok();
    match poll(&mut event, timeout.as_ref()) {
        Ok(number) => Ok(number > 0),
        Err(Errno::INTR) => Ok(false),
        Err(errno) => Err(errno.into()),
    }
}

/// One end of a connection within this program.
#[cfg(unix)]
pub type Local = std::os::unix::net::UnixStream;

/// One end of a connection within this program.
#[cfg(windows)]
pub type Local = std::net::TcpStream;

/// Two ends of a connection within this program, which can be waited for.
///
/// # Errors
/// The system has no socket left.
#[cfg(unix)]
pub fn pair() -> io::Result<(Local, Local)> {
    Local::pair()
}

/// Two ends of a connection within this program, which can be waited for.
///
/// Windows has no such pair: it is a connection over the loopback address, to a listener that takes this one connection alone.
///
/// # Errors
/// The system has no socket left.
#[cfg(windows)]
pub fn pair() -> io::Result<(Local, Local)> {
    let listener = std::net::TcpListener::bind((std::net::Ipv4Addr::LOCALHOST, 0))?;
    let near = Local::connect(listener.local_addr()?)?;
    let ours = near.local_addr()?;
    loop {
        // Another program may connect first: its connection is closed.
        let (far, from) = listener.accept()?;
        if from == ours {
            near.set_nodelay(true)?;
            far.set_nodelay(true)?;
            return Ok((near, far));
        }
    }
}

/// Wakes the thread that waits for the [`WakeSource`]. When the last clone is dropped, the source stays readable.
#[derive(Clone, Debug)]
pub struct Waker(Arc<Local>);

/// The end of a [`Waker`] that a thread waits for.
#[derive(Debug)]
pub struct WakeSource(Local);

/// Creates a waker and the source that it makes readable.
///
/// # Errors
/// The system has no socket left.
pub fn waker() -> io::Result<(Waker, WakeSource)> {
    let (waker, source) = pair()?;
    waker.set_nonblocking(true)?;
    source.set_nonblocking(true)?;
    Ok((Waker(Arc::new(waker)), WakeSource(source)))
}

impl Waker {
    /// Makes the source readable. Never blocks.
    pub fn wake(&self) {
        // A full socket has woken the thread already.
        (&*self.0).write_all(&[0]).ok();
    }
}

impl WakeSource {
    /// Becomes readable when the waker wakes or its last clone is dropped.
    #[must_use]
    pub fn readiness(&self) -> Readiness<'_> {
        Readiness::of(&self.0)
    }

    /// Makes the source unreadable again. Returns whether a waker still exists.
    pub fn clear(&mut self) -> bool {
        let mut octets = [0; 64];
        !matches!(self.0.read(&mut octets), Ok(0))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_source_is_readable_after_its_waker_was_used_and_after_it_was_dropped() {
        let (waker, mut source) = waker().unwrap();
        waker.wake();
        waker.wake();
        assert_eq!(wait(&[source.readiness()], Duration::ZERO).unwrap(), [true]);
        assert!(source.clear());
        assert_eq!(wait(&[source.readiness()], Duration::ZERO).unwrap(), [false]);
        drop(waker);
        assert_eq!(wait(&[source.readiness()], Duration::ZERO).unwrap(), [true]);
        assert!(!source.clear());
    }
}
