//! What a foreign master sees, as a test waits for it.

use std::sync::mpsc::{Receiver, RecvTimeoutError, Sender, channel};
use std::time::{Duration, Instant};

/// Nothing is expected to take this long; it only ends a test that would hang.
const PATIENCE: Duration = Duration::from_secs(60);

/// Something a master sees.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Event {
    /// Data exchange with the gauge has begun or ended.
    Exchanging(bool),
    /// Other inputs than before.
    Inputs(Vec<u8>),
    /// The gauge has answered, but to the master it is not there.
    Unheeded,
}

/// A running master. It stops when this is dropped.
pub struct Watched {
    events: Receiver<Event>,
    /// Whatever must live as long as the master, and ends it when it goes.
    _master: Box<dyn Send>,
}

impl Watched {
    /// Starts a master that is given where to tell what it sees.
    pub fn start<M: Send + 'static>(start: impl FnOnce(Sender<Event>) -> M) -> Self {
        let (sender, events) = channel();
        Self { _master: Box::new(start(sender)), events }
    }

    /// What the master sees from now on, as long as anybody has patience.
    fn events(&self, what: &str) -> impl Iterator<Item = Event> {
        let deadline = Instant::now() + PATIENCE;
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

    /// Waits for so many answers that the master does not heed, and for nothing else.
    pub fn until_unheeded(&self, answers: usize) {
        let mut events = self.events("an answer that is not heeded").take(answers);
        assert!(events.all(|event| event == Event::Unheeded));
    }
}
