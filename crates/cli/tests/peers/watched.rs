//! Events of a foreign master, for which a test waits.

use std::sync::mpsc::{Receiver, RecvTimeoutError, Sender, channel};
use std::time::{Duration, Instant};

/// A timeout that only ends a test that would hang.
const TIMEOUT: Duration = Duration::from_secs(60);

/// An event of a master.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Event {
    /// Data exchange with the gauge has begun or ended.
    Exchanging(bool),
    /// The inputs have changed.
    Inputs(Vec<u8>),
    /// The gauge has answered, but the master does not accept the answer.
    Unheeded,
}

/// A running master. It stops when this is dropped.
pub struct Watched {
    events: Receiver<Event>,
    /// Ends the master when it is dropped.
    _master: Box<dyn Send>,
}

impl Watched {
    /// Starts a master that sends its events to a channel.
    pub fn start<M: Send + 'static>(start: impl FnOnce(Sender<Event>) -> M) -> Self {
        let (sender, events) = channel();
        Self { _master: Box::new(start(sender)), events }
    }

    /// The events of the master from now on, until the timeout.
    fn events(&self, what: &str) -> impl Iterator<Item = Event> {
        let deadline = Instant::now() + TIMEOUT;
        std::iter::from_fn(move || match self.events.recv_timeout(deadline - Instant::now()) {
            Ok(event) => Some(event),
            Err(RecvTimeoutError::Timeout) => panic!("still waiting for {what}"),
            Err(RecvTimeoutError::Disconnected) => panic!("the master has ended before {what}"),
        })
    }

    /// Waits for inputs that `fit`.
    pub fn until(&self, what: &str, fit: impl Fn(&[u8]) -> bool) {
        let fits = |event: Event| matches!(event, Event::Inputs(inputs) if fit(&inputs));
        assert!(self.events(what).any(fits));
    }

    /// Waits until data are exchanged.
    pub fn until_exchanging(&self) {
        assert!(self.events("data exchange").any(|event| event == Event::Exchanging(true)));
    }

    /// Waits until the master misses the gauge.
    pub fn until_lost(&self) {
        assert!(self.events("the end of data exchange").any(|event| event == Event::Exchanging(false)));
    }

    /// Waits for this number of answers that the master ignores, without other events.
    pub fn until_unheeded(&self, answers: usize) {
        let mut events = self.events("an answer that is not heeded").take(answers);
        assert!(events.all(|event| event == Event::Unheeded));
    }
}
