//! Logins that wait for the browser to return from the provider.
//!
//! A pending login belongs to the browser that began it: only a request with its cookie finds it, and it is found once. So a page that
//! sends another browser to the station with an answer of its own (login CSRF) begins no session.

use crate::auth::rate_limit::network;
use crate::auth::secret::RandomSecret;
use std::collections::HashMap;
use std::net::IpAddr;
use std::time::{Duration, Instant};

/// A login must return within this time. chosen: enough for a second factor.
pub const LIFETIME: Duration = Duration::from_secs(10 * 60);

/// The most pending logins. chosen: more than a group has computers.
const MAX_PENDING: usize = 512;

/// The secrets of a login that has begun.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct PendingLogin {
    /// In the cookie of the browser.
    pub browser: RandomSecret,
    /// The ID token must repeat it.
    pub nonce: RandomSecret,
    /// Proves to the provider that the same client asks for the token (PKCE).
    pub verifier: RandomSecret,
    /// The address of the browser: an address with many pending logins loses its own first.
    peer: IpAddr,
    begun: Instant,
}

impl PendingLogin {
    /// A login that begins now.
    ///
    /// # Errors
    /// When the operating system supplies no random numbers.
    pub fn new(peer: IpAddr, now: Instant) -> std::io::Result<Self> {
        let (browser, nonce, verifier) = (RandomSecret::new()?, RandomSecret::new()?, RandomSecret::new()?);
        Ok(Self { browser, nonce, verifier, peer: network(peer), begun: now })
    }
}

/// All pending logins by their state.
#[derive(Debug, Default)]
pub struct PendingLogins(HashMap<RandomSecret, PendingLogin>);

impl PendingLogins {
    /// Adds a login. If there are too many, the oldest one of the address with the most of them ends.
    pub fn add(&mut self, state: RandomSecret, login: PendingLogin) {
        self.0.retain(|_, other| login.begun.saturating_duration_since(other.begun) < LIFETIME);
        if self.0.len() >= MAX_PENDING {
            self.remove_one();
        }
        self.0.insert(state, login);
    }

    /// Takes the login of this state out, if this browser began it and it has not expired.
    pub fn take(&mut self, state: &RandomSecret, browser: &RandomSecret, now: Instant) -> Option<PendingLogin> {
        let login = self.0.get(state)?;
        if !login.browser.matches(browser.reveal().as_bytes()) {
            return None;
        }
        let login = self.0.remove(state)?;
        (now.saturating_duration_since(login.begun) < LIFETIME).then_some(login)
    }

    fn remove_one(&mut self) {
        let mut counts: HashMap<IpAddr, usize> = HashMap::new();
        for login in self.0.values() {
            let count = counts.entry(login.peer).or_default();
            *count = count.saturating_add(1);
        }
        let most = counts.into_iter().max_by_key(|(_, count)| *count).map(|(peer, _)| peer);
        let candidates = self.0.iter().filter(|(_, login)| Some(login.peer) == most);
        let oldest = candidates.min_by_key(|(_, login)| login.begun).map(|(state, _)| state.clone());
        if let Some(state) = oldest {
            self.0.remove(&state);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const NEAR: IpAddr = IpAddr::V4(std::net::Ipv4Addr::LOCALHOST);

    fn begin(all: &mut PendingLogins, peer: IpAddr, now: Instant) -> (RandomSecret, PendingLogin) {
        let (state, login) = (RandomSecret::new().unwrap(), PendingLogin::new(peer, now).unwrap());
        all.add(state.clone(), login.clone());
        (state, login)
    }

    #[test]
    fn a_pending_login_is_found_once_by_its_browser_within_ten_minutes() {
        let (mut all, now) = (PendingLogins::default(), Instant::now());
        let (state, login) = begin(&mut all, NEAR, now);
        let (other_state, other) = begin(&mut all, NEAR, now);
        assert_eq!(all.take(&state, &other.browser, now), None, "the state of another browser");
        assert_eq!(all.take(&RandomSecret::new().unwrap(), &login.browser, now), None);
        assert_eq!(all.take(&state, &login.browser, now), Some(login.clone()));
        assert_eq!(all.take(&state, &login.browser, now), None, "a second time");
        assert_eq!(all.take(&other_state, &other.browser, now + LIFETIME), None, "too late");
        let (last, login) = begin(&mut all, NEAR, now);
        assert!(all.take(&last, &login.browser, now + LIFETIME - Duration::from_secs(1)).is_some());
    }

    #[test]
    fn an_address_that_begins_many_logins_loses_its_own_and_no_other() {
        let (mut all, now) = (PendingLogins::default(), Instant::now());
        let (state, login) = begin(&mut all, NEAR, now);
        let flood = "10.0.0.9".parse().unwrap();
        let first = begin(&mut all, flood, now);
        for _ in 0..3 * MAX_PENDING {
            begin(&mut all, flood, now + Duration::from_secs(1));
        }
        assert_eq!(all.0.len(), MAX_PENDING);
        assert!(all.take(&first.0, &first.1.browser, now).is_none());
        assert!(all.take(&state, &login.browser, now).is_some());
        begin(&mut all, NEAR, now + LIFETIME + Duration::from_secs(1));
        assert_eq!(all.0.len(), 1, "those that have expired are removed");
    }
}
