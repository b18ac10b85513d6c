//! How often somebody may ask: who asks too much waits, and costs the others nothing.
//!
//! | For | At once | Then |
//! |---|---|---|
//! | everything, from one address | 5000 | 500 a second |
//! | logging in, from one address | 20 | 10 a minute |
//! | logging in, under one name | 60 | 60 a minute |
//! | lines in the record about what was refused | 60 | 6 a minute |
//!
//! free choice, all of it: a dozen people behind one proxy do not notice. Who guesses passwords has 14 400 tries a day, and everybody
//! who guesses under one name has 86 400, where a password takes more than a hundred million. No name is ever locked: whoever guesses
//! from one address, or from five, keeps nobody else from logging in.
//!
//! Addresses and names are counted in a limited number of places, chosen by a hash with a key of its own: memory is bounded, whatever
//! comes, and nobody can choose to sit at the place of somebody else. Where a name has its place does not depend on whether anybody has it.

use governor::clock::{Clock, DefaultClock};
use governor::middleware::NoOpMiddleware;
use governor::state::keyed::HashMapStateStore;
use governor::{Quota, RateLimiter};
use std::collections::HashSet;
use std::hash::{BuildHasher, Hash, RandomState};
use std::net::IpAddr;
use std::num::NonZeroU32;
use std::sync::{Mutex, MutexGuard, PoisonError};
use std::time::Duration;

type Limiter<C> = RateLimiter<u16, HashMapStateStore<u16>, C, NoOpMiddleware<<C as Clock>::Instant>>;

/// From so many places is known who has logged in there before. free choice: more than people have computers.
const REMEMBERED: usize = 1024;

/// So much at once, and then one every so often.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct RateLimit {
    /// At once.
    pub burst: NonZeroU32,
    /// Then one in this time.
    pub period: Duration,
}

impl RateLimit {
    /// So many at once, 1 at least, and then one in every `period`.
    #[must_use]
    pub const fn new(burst: u32, period: Duration) -> Self {
        let burst = match NonZeroU32::new(burst) {
            Some(burst) => burst,
            None => NonZeroU32::MIN,
        };
        Self { burst, period }
    }

    fn quota(self) -> Quota {
        Quota::with_period(self.period).unwrap_or(Quota::per_second(NonZeroU32::MIN)).allow_burst(self.burst)
    }
}

/// How often what may be asked.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct RateLimits {
    /// Everything, from one address.
    pub requests: RateLimit,
    /// Logging in, from one address.
    pub logins: RateLimit,
    /// Logging in, under one name.
    pub names: RateLimit,
    /// Changing something, by one person: what they do stays in the audit trail for ever.
    pub acts: RateLimit,
    /// Lines in the record about what was refused.
    pub lines: RateLimit,
}

impl Default for RateLimits {
    fn default() -> Self {
        Self {
            requests: RateLimit::new(5000, Duration::from_millis(2)),
            logins: RateLimit::new(20, Duration::from_secs(6)),
            names: RateLimit::new(60, Duration::from_secs(1)),
            acts: RateLimit::new(600, Duration::from_secs(1)),
            lines: RateLimit::new(60, Duration::from_secs(10)),
        }
    }
}

/// Who has asked how often.
pub struct RateLimiters<C: Clock = DefaultClock> {
    clock: C,
    places: RandomState,
    requests: Limiter<C>,
    logins: Limiter<C>,
    names: Limiter<C>,
    acts: Limiter<C>,
    lines: Limiter<C>,
    came: Mutex<HashSet<(IpAddr, String)>>,
}

impl<C: Clock + Clone> RateLimiters<C> {
    /// Nobody has asked anything yet.
    pub fn new(paces: RateLimits, clock: C) -> Self {
        let limiter = |pace: RateLimit| RateLimiter::new(pace.quota(), HashMapStateStore::default(), clock.clone());
        let RateLimits { requests, logins, names, acts, lines } = paces;
        Self {
            requests: limiter(requests),
            logins: limiter(logins),
            names: limiter(names),
            acts: limiter(acts),
            lines: limiter(lines),
            came: Mutex::default(),
            places: RandomState::new(),
            clock: clock.clone(),
        }
    }

    /// Anything is asked from this address.
    ///
    /// # Errors
    /// How long to wait.
    pub fn request(&self, peer: IpAddr) -> Result<(), Duration> {
        self.check(&self.requests, network(peer))
    }

    /// Somebody logs in from this address under this name.
    ///
    /// # Errors
    /// How long to wait.
    pub fn login(&self, peer: IpAddr, name: &str) -> Result<(), Duration> {
        self.check(&self.logins, network(peer))?;
        let (place, name) = (network(peer), name.to_ascii_lowercase());
        // Many who guess from elsewhere keep nobody out who was here before.
        if self.came().contains(&(place, name.clone())) {
            return Ok(());
        }
        self.check(&self.names, name)
    }

    /// Somebody of this name has logged in from here.
    pub fn remember_login(&self, peer: IpAddr, name: &str) {
        let mut came = self.came();
        if came.len() >= REMEMBERED {
            came.clear();
        }
        came.insert((network(peer), name.to_ascii_lowercase()));
    }

    fn came(&self) -> MutexGuard<'_, HashSet<(IpAddr, String)>> {
        self.came.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Somebody who has logged in changes something.
    ///
    /// # Errors
    /// How long to wait.
    pub fn write_request(&self, name: &str) -> Result<(), Duration> {
        self.check(&self.acts, name.to_ascii_lowercase())
    }

    /// Whether a line about something that was refused may go into the record.
    pub fn may_log(&self) -> bool {
        self.check(&self.lines, ()).is_ok()
    }

    fn check(&self, limiter: &Limiter<C>, who: impl Hash) -> Result<(), Duration> {
        // The lowest 16 bits: so many places there are.
        let place = (self.places.hash_one(who) & 0xFFFF) as u16;
        limiter.check_key(&place).map_err(|refused| refused.wait_time_from(self.clock.now()))
    }
}

/// What one party has: an address of IPv4, or the first half of one of IPv6.
pub fn network(peer: IpAddr) -> IpAddr {
    match peer.to_canonical() {
        IpAddr::V6(address) => IpAddr::V6((address.to_bits() >> 64 << 64).into()),
        other => other,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use governor::clock::FakeRelativeClock;

    const HOME: IpAddr = IpAddr::V4(std::net::Ipv4Addr::LOCALHOST);

    fn rates() -> (RateLimiters<FakeRelativeClock>, FakeRelativeClock) {
        let clock = FakeRelativeClock::default();
        (RateLimiters::new(RateLimits::default(), clock.clone()), clock)
    }

    #[test]
    fn who_guesses_passwords_waits_and_keeps_nobody_else_out() {
        let (rates, clock) = rates();
        let allowed = (0..1000).filter(|number| rates.login(HOME, &number.to_string()).is_ok()).count();
        assert_eq!(allowed, 20);
        assert_eq!(rates.login(HOME, "ada"), Err(Duration::from_secs(6)));
        rates.login("10.0.0.1".parse().unwrap(), "ada").unwrap();
        clock.advance(Duration::from_secs(6));
        rates.login(HOME, "ada").unwrap();
        rates.login(HOME, "ada").unwrap_err();
    }

    #[test]
    fn many_who_guess_under_one_name_wait() {
        let (rates, clock) = rates();
        let everywhere = |number: u32| IpAddr::V4((0x0A00_0000 + number).into());
        let allowed = (0..1000).filter(|number| rates.login(everywhere(*number), "ada").is_ok()).count();
        assert_eq!(allowed, 60);
        assert_eq!(rates.login(everywhere(5000), "ADA"), Err(Duration::from_secs(1)));
        rates.login(everywhere(5000), "bob").unwrap();
        rates.remember_login(everywhere(6000), "Ada");
        rates.login(everywhere(6000), "ada").unwrap();
        rates.login(everywhere(6001), "ada").unwrap_err();
        clock.advance(Duration::from_secs(1));
        rates.login(everywhere(5001), "ada").unwrap();
    }

    #[test]
    fn a_house_full_of_addresses_is_one() {
        let (rates, _) = rates();
        (0..5000).for_each(|number| rates.request(format!("2001:db8::{number:x}").parse().unwrap()).unwrap());
        rates.request("2001:db8::ffff".parse().unwrap()).unwrap_err();
        rates.request("2001:db8:0:1::1".parse().unwrap()).unwrap();
        assert_eq!(network("::ffff:10.0.0.1".parse().unwrap()), "10.0.0.1".parse::<IpAddr>().unwrap());
    }

    #[test]
    fn memory_is_bounded_whoever_asks() {
        let (rates, _) = rates();
        (0..200_000_u32).for_each(|number| rates.request(IpAddr::V4(number.into())).unwrap_or_default());
        assert!(rates.requests.len() <= 65_536);
    }
}
