//! A port that comes back: an adapter that is plugged in again, a serial server or hub that was restarted.
//!
//! While it is gone nothing is heard and what is sent goes nowhere, as on a cable that hangs in the air. It is looked for in
//! a thread of its own, because opening may wait: for a name server, for a host that does not answer.

use super::notice::{Notice, Notices};
use super::{Character, Port, PortError};
use profivac_dp::link::Baud;
use rustix::fd::{AsFd, BorrowedFd};
use std::os::unix::net::UnixStream;
use std::sync::Arc;
use std::sync::mpsc::{Receiver, RecvTimeoutError, Sender, channel};
use std::time::Duration;

/// The pause before the first attempt, and the longest: it doubles in between. free choice: a hub that is restarted is found
/// at once, and an adapter that is gone for a week costs nothing.
const MIN_PAUSE: Duration = Duration::from_millis(50);
const MAX_PAUSE: Duration = Duration::from_secs(2);

/// How a port is opened again.
pub type Opener = Arc<dyn Fn() -> Result<Box<dyn Port>, PortError> + Send + Sync>;

/// A port and how to get it back.
pub struct Reopening {
    name: String,
    is_timed: bool,
    opener: Opener,
    state: State,
    generation: u32,
    notices: Notices,
}

enum State {
    Open(Box<dyn Port>),
    Lost(Search),
}

impl Reopening {
    /// A port that is open, and that `opener` opens again whenever it is lost.
    #[must_use]
    pub fn new(port: Box<dyn Port>, opener: Opener) -> Self {
        let (name, is_timed) = (port.name().to_owned(), port.is_timed());
        Self { name, is_timed, opener, state: State::Open(port), generation: 0, notices: Notices::default() }
    }

    /// A lost port is looked for; any other error stays one.
    fn handle_loss(&mut self, done: Result<(), PortError>) -> Result<(), PortError> {
        match done {
            Err(PortError::Lost(_)) => {
                self.notices.extend([Notice::Lost(self.name.clone())]);
                self.state = State::Lost(Search::begin(Arc::clone(&self.opener), &self.name)?);
                Ok(())
            }
            done => done,
        }
    }

    /// Takes the port if it was found.
    fn take_reopened(&mut self) {
        if let State::Lost(search) = &self.state
            && let Ok(port) = search.opened.try_recv()
        {
            self.state = State::Open(port);
            self.generation = self.generation.wrapping_add(1);
            self.notices.extend([Notice::Reopened(self.name.clone())]);
        }
    }
}

impl Port for Reopening {
    fn name(&self) -> &str {
        &self.name
    }

    fn is_timed(&self) -> bool {
        self.is_timed
    }

    fn watched(&self) -> Vec<BorrowedFd<'_>> {
        match &self.state {
            State::Open(port) => port.watched(),
            State::Lost(search) => vec![search.readable.as_fd()],
        }
    }

    fn receive(&mut self, heard: &mut Vec<Character>) -> Result<(), PortError> {
        self.take_reopened();
        let State::Open(port) = &mut self.state else { return Ok(()) };
        let done = port.receive(heard);
        self.handle_loss(done)
    }

    fn send(&mut self, octets: &[u8]) -> Result<(), PortError> {
        let State::Open(port) = &mut self.state else { return Ok(()) };
        let done = port.send(octets);
        self.handle_loss(done)
    }

    fn set_baud(&mut self, baud: Baud) -> Result<(), PortError> {
        match &mut self.state {
            State::Open(port) => port.set_baud(baud),
            State::Lost(_) => Err(PortError::Lost(self.name.clone())),
        }
    }

    fn next_notice(&mut self) -> Option<Notice> {
        let of_port = || match &mut self.state {
            State::Open(port) => port.next_notice(),
            State::Lost(_) => None,
        };
        self.notices.next().or_else(of_port)
    }

    fn generation(&self) -> u32 {
        self.generation
    }
}

/// The search for a port. It ends when it is dropped.
struct Search {
    opened: Receiver<Box<dyn Port>>,
    /// Becomes readable when the search is over.
    readable: UnixStream,
    /// Never says anything; the thread notices when it is gone.
    _interest: Sender<()>,
}

impl Search {
    fn begin(opener: Opener, name: &str) -> Result<Self, PortError> {
        let failed = |error| PortError::system(name, error);
        let (found_here, found) = channel();
        let (interest, interest_there) = channel();
        let (bell, rope) = UnixStream::pair().map_err(failed)?;
        let search = move || {
            if let Some(port) = open_repeatedly(&opener, &interest_there) {
                // Nobody is interested any more if this fails.
                found_here.send(port).ok();
            }
            drop(rope);
        };
        std::thread::Builder::new().name("search for a port".to_owned()).spawn(search).map_err(failed)?;
        Ok(Self { opened: found, readable: bell, _interest: interest })
    }
}

/// Opens the port again and again until it is there, or nobody wants it.
fn open_repeatedly(opener: &Opener, interest: &Receiver<()>) -> Option<Box<dyn Port>> {
    let mut pause = MIN_PAUSE;
    while interest.recv_timeout(pause) == Err(RecvTimeoutError::Timeout) {
        if let Ok(port) = opener() {
            return Some(port);
        }
        pause = pause.saturating_mul(2).min(MAX_PAUSE);
    }
    None
}
