//! Requests of users that wait in memory for the stations which send over HTTPS: such a station polls the archive for them.
//!
//! | Bound | |
//! |---|---|
//! | requests of one station without a reply | [`MAX_WAITING`] |
//! | time until the reply | [`REPLY_TIMEOUT`] |
//! | time of a poll without a request | [`POLL_TIMEOUT`] |
//!
//! A request has a random id that only its station gets. It is handed out once: when the connection breaks in that moment, its user gets no
//! answer, and no acknowledgement is executed twice.

use crate::config::Sender;
use profivac_web_server::auth::secret::RandomSecret;
use std::collections::{HashMap, VecDeque};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::Duration;
use thiserror::Error;
use tokio::sync::oneshot;
use tokio::time::{Instant, timeout};

/// The most requests of one station that wait for their replies. chosen: more than the view passes on to one station.
pub const MAX_WAITING: usize = 16;

/// The longest wait for a reply, as over NATS.
pub const REPLY_TIMEOUT: Duration = Duration::from_secs(10);

/// The longest wait of a poll: shorter than the time after which a connection without octets ends.
pub const POLL_TIMEOUT: Duration = Duration::from_secs(20);

/// A station is connected for this time after a poll: it takes up what it got, and polls again. chosen.
const PRESENCE: Duration = Duration::from_secs(5);

/// Why a station has no reply.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Error)]
pub enum PendingError {
    /// The file of the archive has no such station.
    #[error("no [[station]] of the file of the archive has this plant and this name")]
    Unknown,
    /// The station does not poll.
    #[error("the station does not poll this archive")]
    NotConnected,
    /// As many requests as possible wait.
    #[error("{MAX_WAITING} requests wait for the station")]
    Busy,
    /// The reply did not come in time.
    #[error("no reply within {} s", REPLY_TIMEOUT.as_secs())]
    NoReply,
    /// The reply was too long, or ended early.
    #[error("its reply was not whole, or too long")]
    Incomplete,
    /// The system gives no random numbers.
    #[error("the system of the archive gives no random numbers")]
    NoId,
}

/// A request for a station.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Handed {
    /// The id, with which the reply comes.
    pub id: RandomSecret,
    /// The request as JSON.
    pub body: Vec<u8>,
}

/// Gets the reply to a request. Dropping it tells the user that there is none.
pub type ReplySender = oneshot::Sender<Vec<u8>>;

/// The longest waits.
#[derive(Clone, Copy, Debug)]
struct Times {
    reply: Duration,
    poll: Duration,
    presence: Duration,
}

impl Default for Times {
    fn default() -> Self {
        Self { reply: REPLY_TIMEOUT, poll: POLL_TIMEOUT, presence: PRESENCE }
    }
}

/// The requests of all stations. Clones share them.
#[derive(Clone, Default)]
pub struct Pending {
    stations: Arc<HashMap<(String, String), Mutex<Station>>>,
    times: Times,
}

/// The requests of one station.
#[derive(Default)]
struct Station {
    /// The poll that waits.
    poll: Option<oneshot::Sender<Handed>>,
    /// When the last poll began or ended.
    polled: Option<Instant>,
    /// Requests that no poll has got.
    queue: VecDeque<Handed>,
    /// Where the replies go, for each request that a user waits for.
    replies: HashMap<RandomSecret, ReplySender>,
}

impl Station {
    fn is_connected(&self, presence: Duration) -> bool {
        let is_waiting = self.poll.as_ref().is_some_and(|poll| !poll.is_closed());
        is_waiting || self.polled.is_some_and(|polled| polled.elapsed() < presence)
    }

    fn put(&mut self, request: Handed, reply: ReplySender, presence: Duration) -> Result<(), PendingError> {
        if !self.is_connected(presence) {
            return Err(PendingError::NotConnected);
        }
        if self.replies.len() >= MAX_WAITING {
            return Err(PendingError::Busy);
        }
        self.replies.insert(request.id.clone(), reply);
        let kept = match self.poll.take() {
            Some(poll) => poll.send(request).err(),
            None => Some(request),
        };
        match kept {
            Some(request) => self.queue.push_back(request),
            None => self.polled = Some(Instant::now()),
        }
        Ok(())
    }

    fn withdraw(&mut self, id: &RandomSecret) {
        self.replies.remove(id);
        self.queue.retain(|request| request.id != *id);
    }
}

/// Notes that a station is gone when the connection of its poll ends.
struct Polling<'a> {
    station: &'a Mutex<Station>,
    has_ended: bool,
}

impl Drop for Polling<'_> {
    fn drop(&mut self) {
        if !self.has_ended {
            lock(self.station).polled = None;
        }
    }
}

/// Removes a request when its user no longer waits.
struct Withdrawal<'a>(&'a Mutex<Station>, RandomSecret);

impl Drop for Withdrawal<'_> {
    fn drop(&mut self) {
        lock(self.0).withdraw(&self.1);
    }
}

fn lock(station: &Mutex<Station>) -> MutexGuard<'_, Station> {
    station.lock().unwrap_or_else(PoisonError::into_inner)
}

impl Pending {
    /// Without requests, for these stations.
    #[must_use]
    pub fn of(stations: &[Sender]) -> Self {
        let key = |station: &Sender| (station.plant.clone(), station.name.clone());
        let stations = stations.iter().map(|station| (key(station), Mutex::default())).collect();
        Self { stations: Arc::new(stations), times: Times::default() }
    }

    fn station(&self, plant: &str, station: &str) -> Option<&Mutex<Station>> {
        self.stations.get(&(plant.to_owned(), station.to_owned()))
    }

    /// Passes a request to a station, and returns its reply.
    ///
    /// # Errors
    /// [`PendingError`].
    pub async fn ask(&self, plant: &str, station: &str, body: Vec<u8>) -> Result<Vec<u8>, PendingError> {
        let station = self.station(plant, station).ok_or(PendingError::Unknown)?;
        let id = RandomSecret::new().map_err(|_| PendingError::NoId)?;
        let (reply, replied) = oneshot::channel();
        lock(station).put(Handed { id: id.clone(), body }, reply, self.times.presence)?;
        let _withdrawal = Withdrawal(station, id);
        match timeout(self.times.reply, replied).await {
            Ok(Ok(reply)) => Ok(reply),
            Ok(Err(_)) => Err(PendingError::Incomplete),
            Err(_) => Err(PendingError::NoReply),
        }
    }

    /// The next request to a station; `None` if none came in time. A later poll of the station ends this one at once.
    pub async fn next(&self, plant: &str, station: &str) -> Option<Handed> {
        let station = self.station(plant, station)?;
        let (sender, mut handed) = oneshot::channel();
        {
            let mut state = lock(station);
            state.polled = Some(Instant::now());
            if let Some(request) = state.queue.pop_front() {
                return Some(request);
            }
            state.poll = Some(sender);
        }
        let mut polling = Polling { station, has_ended: false };
        let waited = timeout(self.times.poll, &mut handed).await;
        polling.has_ended = true;
        match waited {
            Ok(request) => request.ok(),
            Err(_) => {
                let mut state = lock(station);
                state.polled = Some(Instant::now());
                // A request that came in this moment is not lost.
                handed.try_recv().ok()
            }
        }
    }

    /// Takes the place of a reply; `None` if no user waits for it: the id is not that of a request to this station, or its time is over.
    #[must_use]
    pub fn replying(&self, plant: &str, station: &str, id: &str) -> Option<ReplySender> {
        lock(self.station(plant, station)?).replies.remove(&RandomSecret::parse(id)?)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use profivac_web_server::tables::Secret;
    use std::collections::BTreeMap;
    use tokio::task::JoinHandle;

    const LONG: Duration = Duration::from_secs(3_600);
    const SHORT: Duration = Duration::from_millis(20);

    /// Without a limit of time.
    const PATIENT: Times = Times { reply: LONG, poll: LONG, presence: LONG };

    fn pending(times: Times) -> Pending {
        let secret = toml::from_str::<BTreeMap<String, Secret>>("a = \"t\"").unwrap()["a"].clone();
        let sender =
            |plant: &str, name: &str| Sender { plant: plant.to_owned(), name: name.to_owned(), token: secret.clone() };
        Pending { times, ..Pending::of(&[sender("hall", "hall-1"), sender("ring", "ring-1")]) }
    }

    fn waiting(pending: &Pending) -> (usize, usize) {
        let state = lock(pending.station("hall", "hall-1").unwrap());
        (state.queue.len(), state.replies.len())
    }

    /// Asks in the background.
    fn ask(pending: &Pending, body: &[u8]) -> JoinHandle<Result<Vec<u8>, PendingError>> {
        let (pending, body) = (pending.clone(), body.to_vec());
        tokio::spawn(async move { pending.ask("hall", "hall-1", body).await })
    }

    /// Polls in the background, and returns when the poll waits.
    async fn poll(pending: &Pending) -> JoinHandle<Option<Handed>> {
        let polling = pending.clone();
        let poll = tokio::spawn(async move { polling.next("hall", "hall-1").await });
        tokio::task::yield_now().await;
        poll
    }

    #[tokio::test]
    async fn a_request_reaches_the_poll_that_waits_and_its_reply_the_user() {
        let pending = pending(PATIENT);
        let poll = poll(&pending).await;
        let asked = ask(&pending, b"one");
        let handed = poll.await.unwrap().unwrap();
        assert_eq!(handed.body, b"one");
        assert!(pending.replying("ring", "ring-1", handed.id.reveal()).is_none(), "another station replies");
        assert!(pending.replying("hall", "hall-1", &"0".repeat(64)).is_none(), "another id");
        pending.replying("hall", "hall-1", handed.id.reveal()).unwrap().send(b"reply".to_vec()).unwrap();
        assert_eq!(asked.await.unwrap(), Ok(b"reply".to_vec()));
        assert!(pending.replying("hall", "hall-1", handed.id.reveal()).is_none(), "a second reply");
        assert_eq!(waiting(&pending), (0, 0));
    }

    #[tokio::test]
    async fn a_station_that_does_not_poll_is_named_at_once() {
        let pending = pending(Times { poll: SHORT, presence: Duration::ZERO, reply: LONG });
        let ask = |station: &'static str| pending.ask("hall", station, Vec::new());
        assert_eq!(ask("hall-1").await, Err(PendingError::NotConnected));
        assert_eq!(ask("ring-1").await, Err(PendingError::Unknown), "the plant is that of another station");
        assert_eq!(pending.next("hall", "hall-1").await, None, "a poll without a request");
        assert_eq!(ask("hall-1").await, Err(PendingError::NotConnected), "it has not polled since");
    }

    #[tokio::test]
    async fn requests_to_a_station_that_never_replies_have_a_bound_and_end() {
        let pending = pending(Times { reply: SHORT, poll: SHORT, presence: LONG });
        assert_eq!(pending.next("hall", "hall-1").await, None);
        let asked: Vec<_> = (0..5_000).map(|_| ask(&pending, b"x")).collect();
        let handed = pending.next("hall", "hall-1").await;
        let (mut busy, mut without_reply) = (0, 0);
        for asked in asked {
            match asked.await.unwrap() {
                Err(PendingError::Busy) => busy += 1,
                Err(PendingError::NoReply) => without_reply += 1,
                other => panic!("{other:?}"),
            }
        }
        assert!(without_reply >= MAX_WAITING && busy > 0, "{busy} busy, {without_reply} without a reply");
        assert_eq!(waiting(&pending), (0, 0), "requests without a user are kept");
        let id = handed.unwrap().id;
        assert!(pending.replying("hall", "hall-1", id.reveal()).is_none(), "a reply after the deadline");
    }

    #[tokio::test]
    async fn no_more_requests_wait_than_the_bound() {
        let pending = pending(Times { poll: Duration::ZERO, ..PATIENT });
        assert_eq!(pending.next("hall", "hall-1").await, None);
        let asked: Vec<_> = (0..MAX_WAITING).map(|_| ask(&pending, b"x")).collect();
        tokio::task::yield_now().await;
        assert_eq!(waiting(&pending), (MAX_WAITING, MAX_WAITING));
        assert_eq!(pending.ask("hall", "hall-1", Vec::new()).await, Err(PendingError::Busy));
        asked.iter().for_each(JoinHandle::abort);
        for asked in asked {
            assert!(asked.await.unwrap_err().is_cancelled());
        }
        assert_eq!(waiting(&pending), (0, 0), "requests of users who are gone");
    }

    #[tokio::test]
    async fn a_later_poll_takes_the_place_of_an_earlier_one() {
        let pending = pending(PATIENT);
        let (first, second) = (poll(&pending).await, poll(&pending).await);
        assert_eq!(first.await.unwrap(), None);
        let asked = ask(&pending, b"one");
        assert_eq!(second.await.unwrap().unwrap().body, b"one");
        asked.abort();
    }

    #[tokio::test]
    async fn a_request_does_not_go_to_a_poll_whose_connection_has_ended() {
        let pending = pending(PATIENT);
        let gone = poll(&pending).await;
        gone.abort();
        assert!(gone.await.unwrap_err().is_cancelled());
        assert_eq!(pending.ask("hall", "hall-1", Vec::new()).await, Err(PendingError::NotConnected));
        let poll = poll(&pending).await;
        let asked = ask(&pending, b"one");
        assert_eq!(poll.await.unwrap().unwrap().body, b"one");
        asked.abort();
    }
}
