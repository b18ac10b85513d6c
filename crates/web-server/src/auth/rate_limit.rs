//! Limits on requests and logins. A client above its limit waits; other clients are not affected.
//!
//! | Limit on | Burst | Then |
//! |---|---|---|
//! | all requests from one address | 5000 | 500 a second |
//! | logins from one address | 20 | 10 a minute |
//! | logins under one name | 60 | 60 a minute |
//! | steps of logins at an OpenID provider from one address | 40 | 20 a minute |
//! | changes by one user | 600 | 60 a minute |
//! | event-log entries about refused requests | 60 | 6 a minute |
//!
//! chosen, all of it: a dozen users behind one proxy stay below the limits. An attacker at one address has 14 400 guesses a
//! day, all attackers together 86 400 under one name, where a password takes more than a hundred million. No name is ever
//! locked: guesses from one address, or from five, do not keep its user from logging in.
//!
//! Limiters count in a fixed number of buckets, selected by a hash with a random key. So memory is bounded, and an attacker
//! cannot choose the bucket of another client. The bucket of a name does not depend on whether the name exists.

use std::collections::{HashMap, HashSet};
use std::hash::{BuildHasher, Hash, RandomState};
use std::net::IpAddr;
use std::sync::{Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};

/// The number of successful logins (address and name) that are kept. chosen: more than a group has computers.
const MAX_REMEMBERED: usize = 1024;

/// A burst, and a sustained rate after it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct RateLimit {
    /// The size of the burst.
    pub burst: u32,
    /// After the burst, one request in this time.
    pub period: Duration,
}

impl RateLimit {
    /// A burst, then one request in each `period`.
    #[must_use]
    pub const fn new(burst: u32, period: Duration) -> Self {
        Self { burst, period }
    }
}

/// One client below a limit: the generic cell rate algorithm (ITU-T I.371, annex A), which keeps one time for each client.
#[derive(Clone, Copy, Debug)]
pub struct Quota {
    /// When the next request would come if the client sent evenly.
    due: Option<Instant>,
}

impl Quota {
    /// A client without any request so far.
    pub const NEW: Self = Self { due: None };

    /// Counts a request at `now`.
    ///
    /// # Errors
    /// The time to wait. A refused request does not count.
    pub fn check(&mut self, limit: RateLimit, now: Instant) -> Result<(), Duration> {
        let due = self.due.map_or(now, |due| due.max(now));
        let ahead = due - now;
        let tolerance = limit.period.saturating_mul(limit.burst.saturating_sub(1));
        if ahead > tolerance {
            return Err(ahead - tolerance);
        }
        self.due = Some(due + limit.period);
        Ok(())
    }
}

/// The clients below one limit, in a fixed number of buckets.
struct Limiter {
    limit: RateLimit,
    buckets: Mutex<HashMap<u16, Quota>>,
}

impl Limiter {
    fn new(limit: RateLimit) -> Self {
        Self { limit, buckets: Mutex::default() }
    }

    fn check(&self, bucket: u16, now: Instant) -> Result<(), Duration> {
        let mut buckets = self.buckets.lock().unwrap_or_else(PoisonError::into_inner);
        buckets.entry(bucket).or_insert(Quota::NEW).check(self.limit, now)
    }
}

/// The limits of a station.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct RateLimits {
    /// All requests from one address.
    pub requests: RateLimit,
    /// Logins from one address.
    pub logins: RateLimit,
    /// Logins under one name.
    pub names: RateLimit,
    /// Steps of logins at an OpenID provider from one address; a login has two. They do not count as logins with a password, so a
    /// provider that fails does not keep passwords out.
    pub openid: RateLimit,
    /// Changes by one user. The audit trail keeps an entry of each for ever.
    pub writes: RateLimit,
    /// Entries about refused requests in the event log.
    pub log_entries: RateLimit,
}

impl Default for RateLimits {
    fn default() -> Self {
        Self {
            requests: RateLimit::new(5000, Duration::from_millis(2)),
            logins: RateLimit::new(20, Duration::from_secs(6)),
            names: RateLimit::new(60, Duration::from_secs(1)),
            openid: RateLimit::new(40, Duration::from_secs(3)),
            writes: RateLimit::new(600, Duration::from_secs(1)),
            log_entries: RateLimit::new(60, Duration::from_secs(10)),
        }
    }
}

/// The limiters of a station.
pub struct RateLimiters {
    /// The time of a request.
    now: fn() -> Instant,
    hasher: RandomState,
    requests: Limiter,
    logins: Limiter,
    names: Limiter,
    openid: Limiter,
    writes: Limiter,
    log_entries: Limiter,
    /// Addresses and names of successful logins.
    remembered: Mutex<HashSet<(IpAddr, String)>>,
}

impl RateLimiters {
    /// Limiters without any requests so far, with the clock that gives the time of a request.
    pub fn new(limits: RateLimits, now: fn() -> Instant) -> Self {
        let RateLimits { requests, logins, names, openid, writes, log_entries } = limits;
        Self {
            now,
            hasher: RandomState::new(),
            requests: Limiter::new(requests),
            logins: Limiter::new(logins),
            names: Limiter::new(names),
            openid: Limiter::new(openid),
            writes: Limiter::new(writes),
            log_entries: Limiter::new(log_entries),
            remembered: Mutex::default(),
        }
    }

    /// Counts a request from this address.
    ///
    /// # Errors
    /// The time to wait.
    pub fn request(&self, peer: IpAddr) -> Result<(), Duration> {
        self.check(&self.requests, network(peer))
    }

    /// Counts a login from this address under this name.
    ///
    /// # Errors
    /// The time to wait.
    pub fn login(&self, peer: IpAddr, name: &str) -> Result<(), Duration> {
        let (network, name) = (network(peer), name.to_ascii_lowercase());
        self.check(&self.logins, network)?;
        // Guesses from elsewhere never keep out a user who has logged in from this address before.
        if self.remembered().contains(&(network, name.clone())) {
            return Ok(());
        }
        self.check(&self.names, name)
    }

    /// Counts a step of a login at an OpenID provider from this address.
    ///
    /// # Errors
    /// The time to wait.
    pub fn openid(&self, peer: IpAddr) -> Result<(), Duration> {
        self.check(&self.openid, network(peer))
    }

    /// Remembers a successful login: the limit on this name no longer applies to this address.
    pub fn remember_login(&self, peer: IpAddr, name: &str) {
        let mut remembered = self.remembered();
        if remembered.len() >= MAX_REMEMBERED {
            remembered.clear();
        }
        remembered.insert((network(peer), name.to_ascii_lowercase()));
    }

    fn remembered(&self) -> MutexGuard<'_, HashSet<(IpAddr, String)>> {
        self.remembered.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Counts a change by this user.
    ///
    /// # Errors
    /// The time to wait.
    pub fn write_request(&self, name: &str) -> Result<(), Duration> {
        self.check(&self.writes, name.to_ascii_lowercase())
    }

    /// Whether the event log may have another entry about a refused request.
    pub fn may_log(&self) -> bool {
        self.check(&self.log_entries, ()).is_ok()
    }

    fn check(&self, limiter: &Limiter, client: impl Hash) -> Result<(), Duration> {
        // The lowest 16 bits of the hash select one of 65 536 buckets.
        let bucket = (self.hasher.hash_one(client) & 0xFFFF) as u16;
        limiter.check(bucket, (self.now)())
    }
}

/// The part of an address that identifies one client: an IPv4 address, or the first 64 bits of an IPv6 address.
pub fn network(peer: IpAddr) -> IpAddr {
    match peer.to_canonical() {
        IpAddr::V6(address) => IpAddr::V6((address.to_bits() >> 64 << 64).into()),
        other => other,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::cell::Cell;
    use std::sync::LazyLock;

    const LOCAL: IpAddr = IpAddr::V4(std::net::Ipv4Addr::LOCALHOST);

    static BEGIN: LazyLock<Instant> = LazyLock::new(Instant::now);

    thread_local! {
        /// What the clock of a test shows. Each test has a thread of its own.
        static ELAPSED: Cell<Duration> = const { Cell::new(Duration::ZERO) };
    }

    fn limiters() -> RateLimiters {
        RateLimiters::new(RateLimits::default(), || *BEGIN + ELAPSED.get())
    }

    fn advance(time: Duration) {
        ELAPSED.set(ELAPSED.get() + time);
    }

    #[test]
    fn a_burst_passes_then_one_request_in_each_period() {
        let (limit, begin) = (RateLimit::new(3, Duration::from_secs(2)), *BEGIN);
        let mut quota = Quota::NEW;
        let mut check = |ms| quota.check(limit, begin + Duration::from_millis(ms));
        let wait = |ms| Err(Duration::from_millis(ms));
        assert_eq!([check(0), check(0), check(0), check(0)], [Ok(()), Ok(()), Ok(()), wait(2000)]);
        assert_eq!([check(1999), check(2000), check(2000)], [wait(1), Ok(()), wait(2000)]);
        // After a long pause there is one whole burst again, and no more.
        assert_eq!([check(60_000), check(60_000), check(60_000), check(60_000)], [Ok(()), Ok(()), Ok(()), wait(2000)]);
    }

    #[test]
    fn a_clock_that_stands_still_or_goes_back_gives_no_request_more() {
        let limit = RateLimit::new(1, Duration::from_secs(2));
        let mut quota = Quota::NEW;
        let late = *BEGIN + Duration::from_secs(10);
        quota.check(limit, late).unwrap();
        assert_eq!(quota.check(limit, late - Duration::from_secs(5)), Err(Duration::from_secs(7)));
    }

    #[test]
    fn an_address_that_guesses_passwords_waits_and_other_addresses_do_not() {
        let limiters = limiters();
        let allowed = (0..1000).filter(|number| limiters.login(LOCAL, &number.to_string()).is_ok()).count();
        assert_eq!(allowed, 20);
        assert_eq!(limiters.login(LOCAL, "ada"), Err(Duration::from_secs(6)));
        limiters.login("10.0.0.1".parse().unwrap(), "ada").unwrap();
        advance(Duration::from_secs(6));
        limiters.login(LOCAL, "ada").unwrap();
        limiters.login(LOCAL, "ada").unwrap_err();
    }

    #[test]
    fn steps_at_an_openid_provider_are_limited_and_count_as_no_password() {
        let limiters = limiters();
        assert_eq!((0..1000).filter(|_| limiters.openid(LOCAL).is_ok()).count(), 40);
        limiters.openid("10.0.0.1".parse().unwrap()).unwrap();
        limiters.login(LOCAL, "ada").unwrap();
        advance(Duration::from_secs(3));
        limiters.openid(LOCAL).unwrap();
    }

    #[test]
    fn many_addresses_that_guess_under_one_name_wait_and_its_user_does_not() {
        let limiters = limiters();
        let address = |number: u32| IpAddr::V4((0x0A00_0000 + number).into());
        let allowed = (0..1000).filter(|number| limiters.login(address(*number), "ada").is_ok()).count();
        assert_eq!(allowed, 60);
        assert_eq!(limiters.login(address(5000), "ADA"), Err(Duration::from_secs(1)));
        limiters.login(address(5000), "bob").unwrap();
        limiters.remember_login(address(6000), "Ada");
        limiters.login(address(6000), "ada").unwrap();
        limiters.login(address(6001), "ada").unwrap_err();
        advance(Duration::from_secs(1));
        limiters.login(address(5001), "ada").unwrap();
    }

    #[test]
    fn the_addresses_of_one_ipv6_network_count_as_one() {
        let limiters = limiters();
        (0..5000).for_each(|number| limiters.request(format!("2001:db8::{number:x}").parse().unwrap()).unwrap());
        limiters.request("2001:db8::ffff".parse().unwrap()).unwrap_err();
        limiters.request("2001:db8:0:1::1".parse().unwrap()).unwrap();
        assert_eq!(network("::ffff:10.0.0.1".parse().unwrap()), "10.0.0.1".parse::<IpAddr>().unwrap());
    }

    #[test]
    fn memory_is_bounded_for_any_number_of_addresses() {
        let limiters = limiters();
        (0..200_000_u32).for_each(|number| limiters.request(IpAddr::V4(number.into())).unwrap_or_default());
        assert!(limiters.requests.buckets.lock().unwrap().len() <= 65_536);
    }
}
