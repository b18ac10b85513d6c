//! The permits for connections and for live streams: bounded in all, for one address and for one user, with permits kept for logins.
//!
//! A connection is *open to eviction* until a user is known on it. When all permits are taken, the oldest such connection of the address
//! that has the most of them ends, so that a client that only connects, or only begins handshakes, makes room for the next client. A
//! connection with a user holds its permit; a quarter of the permits is never held. A station that sends to an archive holds permits as a
//! user does. They do not count among those of its address: many stations may be behind one address.
//!
//! | Permits | Connections | Live streams |
//! |---|---|---|
//! | in all | [`Permits::new`] | three quarters of the connections |
//! | held | three quarters | |
//! | of one user | a quarter | an eighth |
//! | of one station | [`MAX_HELD_BY_STATION`] | |
//! | of one session | | [`MAX_STREAMS_PER_SESSION`] |
//! | of one remote address, without stations | a quarter | an eighth |
//!
//! All clients of a proxy on this computer have a loopback address, so loopback has no bound of its own.

use super::rate_limit::network;
use super::secret::RandomSecret;
use std::collections::{BTreeMap, HashMap};
use std::net::IpAddr;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use tokio::sync::{OwnedSemaphorePermit, Semaphore, oneshot};

/// The most live streams of one session. chosen: more windows than a control room opens. With HTTP/1.1 a browser opens six connections to one
/// server.
pub const MAX_STREAMS_PER_SESSION: usize = 16;

/// One user or one address may use the total divided by this number. chosen: enough for dozens of pages.
const SHARE: usize = 4;

/// The connections that one station holds: one for batches, one for requests, and those in whose place it has opened others.
pub const MAX_HELD_BY_STATION: usize = 4;

/// The most bodies of requests without a session that one connection reads at the same time. chosen: a connection of HTTP/2 has many requests,
/// and a client without a login shall fill no more memory with them than with a few connections of HTTP/1.1.
const MAX_BODIES_BEFORE_LOGIN: usize = 4;

/// The holder of a permit.
#[derive(Clone, Debug, PartialEq, Eq)]
enum Holder {
    /// A user.
    User(Arc<str>),
    /// A station that sends to an archive.
    Station(Arc<str>),
}

/// A connection.
struct Open {
    peer: IpAddr,
    /// The user or the station that is known on it.
    holder: Option<Holder>,
    /// Dropped to end the connection.
    _evict: oneshot::Sender<()>,
}

/// All connections, the oldest first.
#[derive(Default)]
struct OpenConnections {
    next: u64,
    open: BTreeMap<u64, Open>,
}

impl OpenConnections {
    fn count(&self, is_counted: impl Fn(&Open) -> bool) -> usize {
        self.open.values().filter(|open| is_counted(open)).count()
    }

    /// Ends the oldest connection of `peer` that has no holder. Returns whether there was one.
    fn evict_of(&mut self, peer: IpAddr) -> bool {
        let oldest =
            self.open.iter().find(|(_, open)| open.holder.is_none() && open.peer == peer).map(|(number, _)| *number);
        oldest.is_some_and(|number| self.open.remove(&number).is_some())
    }

    /// The address with the most connections that have no holder; among equal ones the one with the oldest.
    fn greediest(&self) -> Option<IpAddr> {
        let mut counts: HashMap<IpAddr, (usize, std::cmp::Reverse<u64>)> = HashMap::new();
        for (number, open) in self.open.iter().filter(|(_, open)| open.holder.is_none()) {
            let (count, _) = counts.entry(open.peer).or_insert((0, std::cmp::Reverse(*number)));
            *count = count.saturating_add(1);
        }
        counts.into_iter().max_by_key(|(_, rank)| *rank).map(|(peer, _)| peer)
    }
}

/// The permits for the connections of a server.
#[derive(Clone)]
pub struct Permits {
    max: usize,
    connections: Arc<Mutex<OpenConnections>>,
}

/// The permit of one connection. Dropping it frees the permit.
pub struct Permit {
    number: u64,
    permits: Permits,
    /// Places for the bodies of requests without a session.
    bodies: Arc<Semaphore>,
}

/// Ends when the permit is needed for another connection.
pub type Evicted = oneshot::Receiver<()>;

impl Permits {
    /// At most `max` connections.
    #[must_use]
    pub fn new(max: usize) -> Self {
        Self { max, connections: Arc::default() }
    }

    /// The permits of one user, and of one remote address.
    fn share(&self) -> usize {
        (self.max / SHARE).max(1)
    }

    /// A permit for a connection from `peer`, if need be that of an older one without a holder; `None` if all permits are held.
    #[must_use]
    pub fn take(&self, peer: IpAddr) -> Option<(Arc<Permit>, Evicted)> {
        let peer = network(peer);
        let mut connections = self.lock();
        let own = connections.count(|open| open.peer == peer && !matches!(open.holder, Some(Holder::Station(_))));
        if !peer.is_loopback() && own >= self.share() && !connections.evict_of(peer) {
            return None;
        }
        if connections.open.len() >= self.max {
            let greediest = connections.greediest()?;
            connections.evict_of(greediest);
        }
        let number = connections.next;
        connections.next = number.saturating_add(1);
        let (evict, evicted) = oneshot::channel();
        connections.open.insert(number, Open { peer, holder: None, _evict: evict });
        drop(connections);
        let bodies = Arc::new(Semaphore::new(MAX_BODIES_BEFORE_LOGIN));
        Some((Arc::new(Permit { number, permits: self.clone(), bodies }), evicted))
    }

    fn lock(&self) -> MutexGuard<'_, OpenConnections> {
        self.connections.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

impl Permit {
    /// Holds the permit for a user, as far as the user and all users together have permits left. Without one the connection works and
    /// stays open to eviction.
    pub fn hold(&self, user: &Arc<str>) {
        self.hold_for(Holder::User(Arc::clone(user)), self.permits.share());
    }

    /// Holds the permit for a station that has shown its token, within [`MAX_HELD_BY_STATION`] and the bound of all holders.
    pub fn hold_for_station(&self, station: &Arc<str>) {
        self.hold_for(Holder::Station(Arc::clone(station)), MAX_HELD_BY_STATION);
    }

    /// A place for the body of a request without a session; `None` while the connection reads four of them.
    #[must_use]
    pub fn body_before_login(&self) -> Option<OwnedSemaphorePermit> {
        Arc::clone(&self.bodies).try_acquire_owned().ok()
    }

    fn hold_for(&self, holder: Holder, max_own: usize) {
        let max_held = self.permits.max.saturating_sub(self.permits.share());
        let mut connections = self.permits.lock();
        if connections.open.get(&self.number).is_none_or(|open| open.holder.as_ref() == Some(&holder)) {
            return;
        }
        let others = |connections: &OpenConnections, is_counted: &dyn Fn(&Holder) -> bool| {
            let all = connections.open.iter().filter(|(number, _)| **number != self.number);
            all.filter(|(_, open)| open.holder.as_ref().is_some_and(is_counted)).count()
        };
        let has_permit =
            others(&connections, &|other| *other == holder) < max_own && others(&connections, &|_| true) < max_held;
        if let Some(open) = connections.open.get_mut(&self.number) {
            open.holder = has_permit.then_some(holder);
        }
    }
}

impl Drop for Permit {
    fn drop(&mut self) {
        self.permits.lock().open.remove(&self.number);
    }
}

/// The client of a live stream.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct StreamClient {
    /// Its address.
    pub peer: IpAddr,
    /// Its user.
    pub user: Arc<str>,
    /// Its session; `None` where users do not log in.
    pub session: Option<RandomSecret>,
}

/// The bound that a further live stream would exceed.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum StreamLimit {
    /// Of one session.
    #[error("expected at most {0} live streams of one session: close another page of the dashboard")]
    Session(usize),
    /// Of one user.
    #[error("expected at most {0} live streams of one user: close another page of the dashboard")]
    User(usize),
    /// Of one remote address.
    #[error("expected at most {0} live streams from one address: close another page of the dashboard")]
    Address(usize),
    /// Of all clients.
    #[error("expected at most {0} live streams of all users: try again later")]
    All(usize),
}

/// The permits for the live streams of a server.
#[derive(Clone)]
pub struct StreamPermits {
    max_connections: usize,
    streams: Arc<Mutex<OpenStreams>>,
}

#[derive(Default)]
struct OpenStreams {
    next: u64,
    open: BTreeMap<u64, StreamClient>,
}

/// The permit of one live stream. Dropping it frees the permit.
pub struct StreamPermit {
    number: u64,
    permits: StreamPermits,
}

impl StreamPermits {
    /// The permits on a server with `max_connections` connections.
    #[must_use]
    pub fn new(max_connections: usize) -> Self {
        Self { max_connections, streams: Arc::default() }
    }

    /// A permit for a stream.
    ///
    /// # Errors
    /// The [`StreamLimit`] that it would exceed.
    pub fn take(&self, client: StreamClient) -> Result<StreamPermit, StreamLimit> {
        let client = StreamClient { peer: network(client.peer), ..client };
        let part = (self.max_connections / SHARE / 2).max(1);
        let all = self.max_connections.saturating_sub(self.max_connections / SHARE).max(1);
        let mut streams = self.lock();
        let count = |is_counted: &dyn Fn(&StreamClient) -> bool| {
            streams.open.values().filter(|other| is_counted(other)).count()
        };
        let StreamClient { peer, user, session } = &client;
        if session.is_some() && count(&|other| other.session == *session) >= MAX_STREAMS_PER_SESSION {
            return Err(StreamLimit::Session(MAX_STREAMS_PER_SESSION));
        }
        if count(&|other| other.user == *user) >= part {
            return Err(StreamLimit::User(part));
        }
        if !peer.is_loopback() && count(&|other| other.peer == *peer) >= part {
            return Err(StreamLimit::Address(part));
        }
        if streams.open.len() >= all {
            return Err(StreamLimit::All(all));
        }
        let number = streams.next;
        streams.next = number.saturating_add(1);
        streams.open.insert(number, client);
        drop(streams);
        Ok(StreamPermit { number, permits: self.clone() })
    }

    fn lock(&self) -> MutexGuard<'_, OpenStreams> {
        self.streams.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

impl Drop for StreamPermit {
    fn drop(&mut self) {
        self.permits.lock().open.remove(&self.number);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn address(text: &str) -> IpAddr {
        text.parse().unwrap()
    }

    fn is_evicted(evicted: &mut Evicted) -> bool {
        evicted.try_recv() == Err(oneshot::error::TryRecvError::Closed)
    }

    #[test]
    fn one_client_alone_cannot_take_all_connections() {
        let permits = Permits::new(16);
        let take = |peer: &str| permits.take(address(peer));
        let user: Arc<str> = Arc::from("vera");
        let own: Vec<_> = (0..4).map(|_| take("10.0.0.1").unwrap()).collect();
        own.iter().for_each(|(permit, _)| permit.hold(&user));
        assert!(take("10.0.0.1").is_none(), "an address has a quarter of the places");
        let network: Vec<_> = (0..4).map(|number| take(&format!("2001:db8::{number:x}")).unwrap()).collect();
        network.iter().for_each(|(permit, _)| permit.hold(&Arc::from("olga")));
        assert!(take("2001:db8::ffff").is_none(), "the addresses of one IPv6 network count as one client");
        drop(own);
        assert!(take("10.0.0.1").is_some(), "a closed connection frees its place");
        drop(network);
        assert!(permits.lock().open.is_empty(), "no connection that has ended is kept");
    }

    #[test]
    fn a_connection_without_a_user_makes_room_for_the_next_one() {
        let permits = Permits::new(8);
        let mut silent: Vec<_> = (0..8).map(|_| permits.take(address("127.0.0.1")).unwrap()).collect();
        let (login, _login) = permits.take(address("127.0.0.1")).unwrap();
        assert!(is_evicted(&mut silent[0].1), "the oldest ends");
        assert!(silent[1..].iter_mut().all(|(_, evicted)| !is_evicted(evicted)));
        login.hold(&Arc::from("ada"));
        // However many come after it, the connection of the user stays.
        let mut flood: Vec<_> = (0..50).map(|_| permits.take(address("127.0.0.1")).unwrap()).collect();
        assert_eq!(
            flood.iter_mut().map(|(_, evicted)| is_evicted(evicted)).filter(|is_evicted| !is_evicted).count(),
            7
        );
        assert!(permits.lock().open.get(&login.number).is_some_and(|open| open.holder.is_some()));
    }

    #[test]
    fn stations_behind_one_address_neither_end_the_connections_of_each_other_nor_lose_them_to_others() {
        let permits = Permits::new(512);
        let station = |number: usize| Arc::from(format!("hall-{number}"));
        let mut stations = Vec::new();
        for number in 0..190 {
            for _ in 0..2 {
                let (permit, evicted) = permits.take(address("10.0.0.1")).unwrap();
                permit.hold_for_station(&station(number));
                stations.push((permit, evicted));
            }
        }
        assert!(
            !stations.iter_mut().any(|(_, evicted)| is_evicted(evicted)),
            "a station has ended that of another one"
        );
        // However many come from there without a token, they have a bound, and the stations stay.
        let mut others: Vec<_> = (0..600).map(|_| permits.take(address("10.0.0.1")).unwrap()).collect();
        let ended = others.iter_mut().map(|(_, evicted)| is_evicted(evicted)).filter(|is_evicted| *is_evicted).count();
        assert_eq!(others.len() - ended, 128);
        assert!(!stations.iter_mut().any(|(_, evicted)| is_evicted(evicted)), "a station has lost its connection");
        // A station with a token holds no more than its own.
        let greedy: Vec<_> = (0..20).map(|_| permits.take(address("10.0.0.2")).unwrap()).collect();
        greedy.iter().for_each(|(permit, _)| permit.hold_for_station(&station(1_000)));
        assert_eq!(
            permits.lock().count(|open| open.holder == Some(Holder::Station(station(1_000)))),
            MAX_HELD_BY_STATION
        );
        // All stations together leave a quarter to others.
        for number in 200..400 {
            let (permit, evicted) = permits.take(address("10.0.0.3")).unwrap();
            permit.hold_for_station(&station(number));
            stations.push((permit, evicted));
        }
        assert_eq!(permits.lock().count(|open| open.holder.is_some()), 384);
    }

    #[test]
    fn the_address_with_the_most_connections_without_a_user_loses_one() {
        let permits = Permits::new(8);
        let (_first, mut first) = permits.take(address("10.0.0.9")).unwrap();
        let mut greedy: Vec<_> = (0..7).map(|_| permits.take(address("127.0.0.1")).unwrap()).collect();
        let next = permits.take(address("10.0.0.8")).unwrap();
        assert!(!is_evicted(&mut first) && is_evicted(&mut greedy[0].1));
        drop(next);
    }

    #[test]
    fn a_user_holds_a_quarter_and_all_users_three_quarters_of_the_connections() {
        let permits = Permits::new(16);
        let mut all = Vec::new();
        for user in ["ada", "olga", "vera", "hugo", "ines"] {
            for _ in 0..6 {
                let (permit, evicted) = permits.take(address("127.0.0.1")).unwrap();
                permit.hold(&Arc::from(user));
                all.push((permit, evicted));
            }
        }
        let held = |user: &str| permits.lock().count(|open| open.holder == Some(Holder::User(Arc::from(user))));
        assert_eq!(["ada", "olga", "vera", "hugo", "ines"].map(held), [4, 4, 4, 0, 0]);
        assert!(permits.take(address("127.0.0.1")).is_some(), "a quarter is kept for logins");
    }

    #[test]
    fn live_streams_are_bounded_per_session_user_address_and_in_all() {
        let permits = StreamPermits::new(256);
        let client = |peer: &str, user: &str, session: &Option<RandomSecret>| StreamClient {
            peer: address(peer),
            user: Arc::from(user),
            session: session.clone(),
        };
        let take_all = |peer: &str, user: &str, session: &Option<RandomSecret>| {
            let mut taken = Vec::new();
            loop {
                match permits.take(client(peer, user, session)) {
                    Ok(permit) => taken.push(permit),
                    Err(limit) => return (taken, limit),
                }
            }
        };
        let new = || Some(RandomSecret::new().unwrap());
        let (one, limit) = take_all("127.0.0.1", "vera", &new());
        assert_eq!((one.len(), limit), (16, StreamLimit::Session(16)));
        let more: Vec<_> = (0..4).map(|_| take_all("127.0.0.1", "vera", &new())).collect();
        let taken: Vec<_> = more.iter().map(|(permits, limit)| (permits.len(), *limit)).collect();
        let (session, user) = ((16, StreamLimit::Session(16)), (0, StreamLimit::User(32)));
        assert_eq!(taken, [session, user, user, user]);
        let remote: Vec<_> = ["a", "b", "c", "d", "e"].map(|user| take_all("10.0.0.1", user, &new())).into();
        assert_eq!(remote[4].1, StreamLimit::Address(32));
        let local: Vec<_> = (0..20).map(|user| take_all("127.0.0.1", &user.to_string(), &new())).collect();
        assert_eq!(local[19].1, StreamLimit::All(192));
        drop(one);
        assert!(permits.take(client("127.0.0.1", "vera", &new())).is_ok(), "a closed stream frees its place");
        drop((more, remote, local));
        assert!(permits.lock().open.is_empty());
    }
}
