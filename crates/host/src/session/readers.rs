//! Other programs that read from the port of a session and so take answers away.
//!
//! A port names those that it finds when it is opened. One that opens the device later shows itself by missing and damaged answers only:
//! after such an answer the session searches again.

use crate::port::{Notice, Port};
use std::collections::{BTreeSet, VecDeque};
use std::sync::mpsc::{Receiver, channel};
use std::time::{Duration, Instant};

/// The shortest time between two searches. chosen: an absent station of the GAP is a missing answer too, and a search reads the open
/// files of all processes.
const INTERVAL: Duration = Duration::from_secs(30);

/// The search for these programs, and what it has found.
#[derive(Default)]
pub(super) struct OtherReaders {
    /// Missing answers and damaged telegrams at the last search.
    losses: u64,
    begun: Option<Instant>,
    running: Option<Receiver<Vec<Notice>>>,
    /// The processes that have been named.
    named: BTreeSet<u32>,
    notices: VecDeque<Notice>,
}

impl OtherReaders {
    /// Begins a search in a thread if answers are missing since the last one, and takes the result of a search that has ended. `losses` are
    /// the missing answers and damaged telegrams so far.
    pub(super) fn poll(&mut self, losses: u64, port: &dyn Port) {
        if let Some(found) = self.running.as_ref().and_then(|running| running.try_recv().ok()) {
            self.running = None;
            self.name(found);
        }
        let is_due = self.begun.is_none_or(|begun| begun.elapsed() >= INTERVAL);
        if losses <= self.losses || !is_due {
            return;
        }
        (self.losses, self.begun) = (losses, Some(Instant::now()));
        let Some(search) = port.reader_search() else { return };
        let (result, running) = channel();
        self.running = Some(running);
        // The search fails if the session has ended. Without a thread the next search is a later one.
        let search = move || drop(result.send(search()));
        std::thread::Builder::new().name("search for other readers".to_owned()).spawn(search).ok();
    }

    /// Searches at the end of a session, without a thread.
    pub(super) fn search(&mut self, losses: u64, port: &dyn Port) {
        if losses > self.losses || self.running.is_some() {
            self.name(port.reader_search().map(|search| search()).unwrap_or_default());
        }
    }

    /// Each program is named once.
    fn name(&mut self, found: Vec<Notice>) {
        let named = &mut self.named;
        let is_new = |notice: &Notice| match notice {
            Notice::OpenElsewhere { pid, .. } => named.insert(*pid),
            _ => true,
        };
        self.notices.extend(found.into_iter().filter(is_new));
    }

    /// Takes the oldest notice.
    pub(super) fn next_notice(&mut self) -> Option<Notice> {
        self.notices.pop_front()
    }
}
