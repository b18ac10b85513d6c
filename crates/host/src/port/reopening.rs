//! A port that comes back: an adapter that is plugged in again, a serial server or hub that was restarted.
//!
//! While it is gone nothing is heard and what is sent goes nowhere, as on a cable that hangs in the air. It is looked for in
//! a thread of its own, because opening may wait: for a name server, for a host that does not answer.

use super::remark::{Remark, Remarks};
use super::{Character, Port, PortError};
use profivac_dp::link::Baud;
use rustix::fd::{AsFd, BorrowedFd};
use std::os::unix::net::UnixStream;
use std::sync::Arc;
use std::sync::mpsc::{Receiver, RecvTimeoutError, Sender, channel};
use std::time::Duration;

/// The pause before the first attempt, and the longest: it doubles in between. free choice: a hub that is restarted is found
/// at once, and an adapter that is gone for a week costs nothing.
const FIRST_PAUSE: Duration = Duration::from_millis(50);
const LONGEST_PAUSE: Duration = Duration::from_secs(2);

/// How a port is opened again.
pub type Opener = Arc<dyn Fn() -> Result<Box<dyn Port>, PortError> + Send + Sync>;

/// A port and how to get it back.
pub struct Reopening {
    name: String,
    is_timed: bool,
    opener: Opener,
    state: State,
    generation: u32,
    remarks: Remarks,
}

enum State {
    There(Box<dyn Port>),
    Gone(Search),
}

impl Reopening {
    /// A port that is open, and that `opener` opens again whenever it is lost.
    #[must_use]
    pub fn new(port: Box<dyn Port>, opener: Opener) -> Self {
        let (name, is_timed) = (port.name().to_owned(), port.is_timed());
        Self { name, is_timed, opener, state: State::There(port), generation: 0, remarks: Remarks::default() }
    }

    /// A lost port is looked for; any other error stays one.
    fn survive(&mut self, done: Result<(), PortError>) -> Result<(), PortError> {
        match done {
            Err(PortError::Lost(_)) => {
                self.remarks.extend([Remark::Lost(self.name.clone())]);
                self.state = State::Gone(Search::begin(Arc::clone(&self.opener), &self.name)?);
                Ok(())
            }
            done => done,
        }
    }

    /// Takes the port if it was found.
    fn look(&mut self) {
        if let State::Gone(search) = &self.state
            && let Ok(port) = search.found.try_recv()
        {
            self.state = State::There(port);
            self.generation = self.generation.wrapping_add(1);
            self.remarks.extend([Remark::Back(self.name.clone())]);
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
            State::There(port) => port.watched(),
            State::Gone(search) => vec![search.bell.as_fd()],
        }
    }

    fn receive(&mut self, heard: &mut Vec<Character>) -> Result<(), PortError> {
        self.look();
        let State::There(port) = &mut self.state else { return Ok(()) };
        let done = port.receive(heard);
        self.survive(done)
    }

    fn send(&mut self, octets: &[u8]) -> Result<(), PortError> {
        let State::There(port) = &mut self.state else { return Ok(()) };
        let done = port.send(octets);
        self.survive(done)
    }

    fn set_baud(&mut self, baud: Baud) -> Result<(), PortError> {
        match &mut self.state {
            State::There(port) => port.set_baud(baud),
            State::Gone(_) => Err(PortError::Lost(self.name.clone())),
        }
    }

    fn next_remark(&mut self) -> Option<Remark> {
        let of_port = || match &mut self.state {
            State::There(port) => port.next_remark(),
            State::Gone(_) => None,
        };
        self.remarks.next().or_else(of_port)
    }

    fn generation(&self) -> u32 {
        self.generation
    }
}

/// The search for a port. It ends when it is dropped.
struct Search {
    found: Receiver<Box<dyn Port>>,
    /// Becomes readable when the search is over.
    bell: UnixStream,
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
            if let Some(port) = look_for(&opener, &interest_there) {
                // Nobody is interested any more if this fails.
                found_here.send(port).ok();
            }
            drop(rope);
        };
        std::thread::Builder::new().name("search for a port".to_owned()).spawn(search).map_err(failed)?;
        Ok(Self { found, bell, _interest: interest })
    }
}

/// Opens the port again and again until it is there, or nobody wants it.
fn look_for(opener: &Opener, interest: &Receiver<()>) -> Option<Box<dyn Port>> {
    let mut pause = FIRST_PAUSE;
    while interest.recv_timeout(pause) == Err(RecvTimeoutError::Timeout) {
        if let Ok(port) = opener() {
            return Some(port);
        }
        pause = pause.saturating_mul(2).min(LONGEST_PAUSE);
    }
    None
}
