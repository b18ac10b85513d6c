//! Sessions, in memory only: after a restart of the station every user logs in again.
//!
//! A session ends when its user logs out, when the user is removed or gets a new password, when it was not used for
//! [`IDLE_TIMEOUT`], and at its maximum age. The event stream of an open page uses its session all the time, so a page in a
//! control room stays logged in until the maximum age.

use super::password::Hash;
use super::secret::RandomSecret;
use super::users::{Account, Users};
use super::{Role, User};
use std::collections::HashMap;
use std::sync::Arc;
use std::time::{Duration, Instant};

/// An unused session ends after this time. free choice: longer than a break, shorter than an absence.
pub const IDLE_TIMEOUT: Duration = Duration::from_secs(30 * 60);

/// The maximum age of a session of an operator or engineer: one login per shift. free choice.
pub const MAX_AGE_WRITER: Duration = Duration::from_secs(12 * 3600);

/// The maximum age of a session of a viewer: a wall display in a control room logs in once a month. free choice.
pub const MAX_AGE_VIEWER: Duration = Duration::from_secs(30 * 24 * 3600);

/// The most sessions of one user. A further login ends the session that was unused for longest. free choice.
pub const MAX_PER_USER: usize = 16;

/// The most sessions of all users. free choice.
pub const MAX_SESSIONS: usize = 1024;

/// A session.
#[derive(Clone, Debug)]
struct Session {
    name: Arc<str>,
    /// The password hash at login. A new password ends the session.
    password: Hash,
    token: RandomSecret,
    begun: Instant,
    used: Instant,
}

impl Session {
    /// The account of the session; `None` if the session has ended.
    fn account<'a>(&self, users: &'a Users, now: Instant) -> Option<&'a Account> {
        let account = users.get(&self.name).filter(|account| account.password == self.password)?;
        let max_age = if account.role == Role::Viewer { MAX_AGE_VIEWER } else { MAX_AGE_WRITER };
        let is_alive = now.saturating_duration_since(self.used) < IDLE_TIMEOUT
            && now.saturating_duration_since(self.begun) < max_age;
        is_alive.then_some(account)
    }
}

/// The user of a session, and the token of the session.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct AuthenticatedUser {
    /// The user.
    pub user: User,
    /// The token that the page sends with every change (see `x-csrf-token`).
    pub token: RandomSecret,
}

/// All sessions by their identifiers.
#[derive(Debug, Default)]
pub struct Sessions(HashMap<RandomSecret, Session>);

impl Sessions {
    /// Begins a session with a new identifier and a new token, and removes the sessions that have ended.
    ///
    /// # Errors
    /// When the operating system supplies no random numbers.
    pub fn begin(
        &mut self,
        account: &Account,
        users: &Users,
        now: Instant,
    ) -> std::io::Result<(RandomSecret, AuthenticatedUser)> {
        self.0.retain(|_, session| session.account(users, now).is_some());
        while self.0.values().filter(|session| session.name == account.name).count() >= MAX_PER_USER {
            self.remove_oldest(|session| session.name == account.name);
        }
        while self.0.len() >= MAX_SESSIONS {
            self.remove_oldest(|_| true);
        }
        let (id, token) = (RandomSecret::new()?, RandomSecret::new()?);
        let authenticated = AuthenticatedUser { user: account.user(), token: token.clone() };
        let (name, password) = (Arc::clone(&account.name), account.password.clone());
        self.0.insert(id.clone(), Session { name, password, token, begun: now, used: now });
        Ok((id, authenticated))
    }

    /// The user of a session. Counts as a use of the session.
    pub fn resume(&mut self, id: &RandomSecret, users: &Users, now: Instant) -> Option<AuthenticatedUser> {
        let session = self.0.get_mut(id)?;
        let Some(account) = session.account(users, now) else {
            self.0.remove(id);
            return None;
        };
        session.used = now;
        Some(AuthenticatedUser { user: account.user(), token: session.token.clone() })
    }

    /// Whether a user has a session that has not ended.
    #[must_use]
    pub fn has_session(&self, name: &str, users: &Users, now: Instant) -> bool {
        self.0.values().any(|session| &*session.name == name && session.account(users, now).is_some())
    }

    /// Ends a session.
    pub fn end(&mut self, id: &RandomSecret) {
        self.0.remove(id);
    }

    fn remove_oldest(&mut self, is_candidate: impl Fn(&Session) -> bool) {
        let candidates = self.0.iter().filter(|(_, session)| is_candidate(session));
        let oldest = candidates.min_by_key(|(_, session)| session.used);
        if let Some(id) = oldest.map(|(id, _)| id.clone()) {
            self.0.remove(&id);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn users() -> Users {
        let mut users = Users::default();
        let hash = Hash::of("tin whisker plateau").unwrap();
        users.add("ada", Role::Engineer, hash.clone()).unwrap();
        users.add("bob", Role::Viewer, hash).unwrap();
        users
    }

    fn begin(sessions: &mut Sessions, users: &Users, name: &str, now: Instant) -> RandomSecret {
        sessions.begin(users.get(name).unwrap(), users, now).unwrap().0
    }

    #[test]
    fn a_session_has_its_user_until_it_ends() {
        let (users, now) = (users(), Instant::now());
        let mut sessions = Sessions::default();
        let (id, begun) = sessions.begin(users.get("ada").unwrap(), &users, now).unwrap();
        assert_eq!(sessions.resume(&id, &users, now), Some(begun.clone()));
        assert_eq!((&*begun.user.name, begun.user.role), ("ada", Role::Engineer));
        assert_eq!(sessions.resume(&RandomSecret::new().unwrap(), &users, now), None);
        sessions.end(&id);
        assert_eq!(sessions.resume(&id, &users, now), None);
    }

    #[test]
    fn an_unused_session_ends_and_a_used_one_lasts_until_its_maximum_age() {
        let (users, start) = (users(), Instant::now());
        for (name, max_age) in [("ada", MAX_AGE_WRITER), ("bob", MAX_AGE_VIEWER)] {
            let mut sessions = Sessions::default();
            let (used, unused) = (begin(&mut sessions, &users, name, start), begin(&mut sessions, &users, name, start));
            assert!(sessions.has_session(name, &users, start), "{name}");
            assert!(!sessions.has_session(name, &users, start + IDLE_TIMEOUT), "{name}");
            assert_eq!(sessions.resume(&unused, &users, start + IDLE_TIMEOUT), None, "{name}");
            let mut now = start;
            while now + IDLE_TIMEOUT / 2 < start + max_age {
                now += IDLE_TIMEOUT / 2;
                assert!(sessions.resume(&used, &users, now).is_some(), "{name} after {:?}", now - start);
            }
            assert_eq!(sessions.resume(&used, &users, start + max_age), None, "{name}");
        }
    }

    #[test]
    fn removal_or_a_new_password_ends_a_session_and_a_new_role_applies_at_once() {
        let (old, now) = (users(), Instant::now());
        let mut sessions = Sessions::default();
        let (ada, bob) = (begin(&mut sessions, &old, "ada", now), begin(&mut sessions, &old, "bob", now));
        let mut new = old.clone();
        new.get_mut("ada").unwrap().role = Role::Viewer;
        assert_eq!(sessions.resume(&ada, &new, now).unwrap().user.role, Role::Viewer);
        new.get_mut("ada").unwrap().password = Hash::of("tin whisker plateau").unwrap();
        new.remove("bob").unwrap();
        assert_eq!((sessions.resume(&ada, &new, now), sessions.resume(&bob, &new, now)), (None, None));
        assert_eq!(sessions.resume(&ada, &old, now), None, "an ended session stays ended");
    }

    #[test]
    fn the_number_of_sessions_is_limited() {
        let (users, start) = (users(), Instant::now());
        let mut sessions = Sessions::default();
        let bob = begin(&mut sessions, &users, "bob", start);
        let first = begin(&mut sessions, &users, "ada", start);
        for second in 1..=MAX_PER_USER as u64 {
            begin(&mut sessions, &users, "ada", start + Duration::from_secs(second));
        }
        assert_eq!(sessions.0.len(), MAX_PER_USER + 1);
        assert_eq!(sessions.resume(&first, &users, start), None);
        assert!(sessions.resume(&bob, &users, start).is_some());
        begin(&mut sessions, &users, "bob", start + 2 * IDLE_TIMEOUT);
        assert_eq!(sessions.0.len(), 1, "sessions that have ended are removed");
    }
}
