//! A port that is opened again after it was lost: an adapter that is plugged in again, a serial server that was restarted.
//!
//! A lost port behaves like a disconnected cable: nothing is received, and sent octets are dropped. A thread of its own
//! opens it again, because opening may block on a name server or on a host that does not answer.

use super::notice::{Notice, Notices};
use super::{Character, Delivery, Port, PortError, ReaderSearch};
use crate::readiness::{self, Readiness, WakeSource};
use profivac_dp::link::Baud;
use std::sync::Arc;
use std::sync::mpsc::{Receiver, RecvTimeoutError, Sender, channel};
use std::time::Duration;

/// The pause before the first attempt, and the longest pause; it doubles in between. chosen: a restarted server is
/// found at once, and an adapter that is away for a week costs nothing.
const MIN_PAUSE: Duration = Duration::from_millis(50);
const MAX_PAUSE: Duration = Duration::from_secs(2);

/// Opens a port again. `None`: not yet possible.
pub type Opener = Arc<dyn Fn() -> Option<Box<dyn Port>> + Send + Sync>;

/// A port that is opened again whenever it is lost.
pub struct Reopening {
    name: String,
    delivery: Delivery,
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
    /// Wraps a port that is open; `opener` opens it again whenever it is lost.
    #[must_use]
    pub fn new(port: Box<dyn Port>, opener: Opener) -> Self {
        let (name, delivery) = (port.name().to_owned(), port.delivery());
        Self { name, delivery, opener, state: State::Open(port), generation: 0, notices: Notices::default() }
    }

    /// Starts the search for a lost port. Passes other errors on.
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

    /// Takes the port if the search has opened it.
    fn take_reopened(&mut self) {
        if let State::Lost(search) = &self.state
            && let Ok(port) = search.opened.try_recv()
        {
            self.delivery = port.delivery();
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

    fn delivery(&self) -> Delivery {
        self.delivery
    }

    fn readiness(&self) -> Vec<Readiness<'_>> {
        match &self.state {
            State::Open(port) => port.readiness(),
            State::Lost(search) => vec![search.ended.readiness()],
        }
    }

    fn receive(&mut self, characters: &mut Vec<Character>) -> Result<(), PortError> {
        self.take_reopened();
        let State::Open(port) = &mut self.state else { return Ok(()) };
        let done = port.receive(characters);
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

    fn reader_search(&self) -> Option<ReaderSearch> {
        match &self.state {
            State::Open(port) => port.reader_search(),
            State::Lost(_) => None,
        }
    }

    fn generation(&self) -> u32 {
        self.generation
    }
}

/// The search for a port. It ends when it is dropped.
struct Search {
    opened: Receiver<Box<dyn Port>>,
    /// Becomes readable when the search has ended.
    ended: WakeSource,
    /// Carries no messages. The thread ends when it is dropped.
    _interest: Sender<()>,
}

impl Search {
    fn begin(opener: Opener, name: &str) -> Result<Self, PortError> {
        let failed = |error| PortError::system(name, error);
        let (found_here, found) = channel();
        let (interest, interest_there) = channel();
        let (waker, ended) = readiness::waker().map_err(failed)?;
        let search = move || {
            if let Some(port) = open_repeatedly(&opener, &interest_there) {
                // Fails if the search was dropped.
                found_here.send(port).ok();
            }
            drop(waker);
        };
        std::thread::Builder::new().name("search for a port".to_owned()).spawn(search).map_err(failed)?;
        Ok(Self { opened: found, ended, _interest: interest })
    }
}

/// Opens the port repeatedly until it succeeds or the search is dropped.
fn open_repeatedly(opener: &Opener, interest: &Receiver<()>) -> Option<Box<dyn Port>> {
    let mut pause = MIN_PAUSE;
    while interest.recv_timeout(pause) == Err(RecvTimeoutError::Timeout) {
        if let Some(port) = opener() {
            return Some(port);
        }
        pause = pause.saturating_mul(2).min(MAX_PAUSE);
    }
    None
}
