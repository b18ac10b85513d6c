//! Who has logged in. In memory alone: after a restart everybody logs in again.
//!
//! A session ends when its person logs out, is removed or gets a new password; when it was not used for half an hour; and
//! after some time in any case. An open page uses its session as long as it is heard: in a control room it stays for days.

use super::password::Hash;
use super::secret::Secret;
use super::users::{Account, Users};
use super::{Role, User};
use std::collections::HashMap;
use std::sync::Arc;
use std::time::{Duration, Instant};

/// Unused for so long, a session ends. free choice: a closed page is no open door; a lunch is longer than this.
pub const IDLE_TIMEOUT: Duration = Duration::from_secs(30 * 60);

/// Who may change something logs in once a shift. free choice.
pub const MAX_AGE_WRITER: Duration = Duration::from_secs(12 * 3600);

/// Who only looks stays for a month: a screen on the wall of a control room. free choice.
pub const MAX_AGE_VIEWER: Duration = Duration::from_secs(30 * 24 * 3600);

/// So many at once for each person; a further one ends the one that was unused for longest. free choice.
pub const MAX_PER_USER: usize = 16;

/// So many at once in all. free choice.
pub const MAX_SESSIONS: usize = 1024;

/// A session.
#[derive(Clone, Debug)]
struct Session {
    name: Arc<str>,
    /// The password it was begun with.
    password: Hash,
    token: Secret,
    begun: Instant,
    used: Instant,
}

impl Session {
    /// Whose it is, unless it has ended.
    fn user<'a>(&self, users: &'a Users, now: Instant) -> Option<&'a Account> {
        let user = users.get(&self.name).filter(|user| user.password == self.password)?;
        let longest = if user.role == Role::Viewer { MAX_AGE_VIEWER } else { MAX_AGE_WRITER };
        let alive = now.saturating_duration_since(self.used) < IDLE_TIMEOUT
            && now.saturating_duration_since(self.begun) < longest;
        alive.then_some(user)
    }
}

/// Whoever a session belongs to.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct AuthenticatedUser {
    /// Who.
    pub user: User,
    /// What their page proves with that it is ours.
    pub token: Secret,
}

/// All sessions, by their secret names.
#[derive(Debug, Default)]
pub struct Sessions(HashMap<Secret, Session>);

impl Sessions {
    /// Begins one; the names of the session and of its token are new. Those that have ended are forgotten.
    ///
    /// # Errors
    /// When the system gives no random numbers.
    pub fn begin(
        &mut self,
        user: &Account,
        users: &Users,
        now: Instant,
    ) -> std::io::Result<(Secret, AuthenticatedUser)> {
        self.0.retain(|_, session| session.user(users, now).is_some());
        while self.0.values().filter(|session| session.name == user.name).count() >= MAX_PER_USER {
            self.forget_oldest(|session| session.name == user.name);
        }
        while self.0.len() >= MAX_SESSIONS {
            self.forget_oldest(|_| true);
        }
        let (id, token) = (Secret::new()?, Secret::new()?);
        let known = AuthenticatedUser { user: user.user(), token: token.clone() };
        let session =
            Session { name: Arc::clone(&user.name), password: user.password.clone(), token, begun: now, used: now };
        self.0.insert(id.clone(), session);
        Ok((id, known))
    }

    /// Whose session this is; it has been used then.
    pub fn resume(&mut self, id: &Secret, users: &Users, now: Instant) -> Option<AuthenticatedUser> {
        let session = self.0.get_mut(id)?;
        let Some(user) = session.user(users, now) else {
            self.0.remove(id);
            return None;
        };
        session.used = now;
        Some(AuthenticatedUser { user: user.user(), token: session.token.clone() })
    }

    /// Whether somebody has a session that has not ended.
    #[must_use]
    pub fn has_session(&self, name: &str, users: &Users, now: Instant) -> bool {
        self.0.values().any(|session| &*session.name == name && session.user(users, now).is_some())
    }

    /// Ends one.
    pub fn end(&mut self, id: &Secret) {
        self.0.remove(id);
    }

    fn forget_oldest(&mut self, of: impl Fn(&Session) -> bool) {
        let oldest = self.0.iter().filter(|(_, session)| of(session)).min_by_key(|(_, session)| session.used);
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

    fn begin(sessions: &mut Sessions, users: &Users, name: &str, now: Instant) -> Secret {
        sessions.begin(users.get(name).unwrap(), users, now).unwrap().0
    }

    #[test]
    fn a_session_knows_its_person_until_it_is_ended() {
        let (users, now) = (users(), Instant::now());
        let mut sessions = Sessions::default();
        let (id, begun) = sessions.begin(users.get("ada").unwrap(), &users, now).unwrap();
        assert_eq!(sessions.resume(&id, &users, now), Some(begun.clone()));
        assert_eq!((&*begun.user.name, begun.user.role), ("ada", Role::Engineer));
        assert_eq!(sessions.resume(&Secret::new().unwrap(), &users, now), None);
        sessions.end(&id);
        assert_eq!(sessions.resume(&id, &users, now), None);
    }

    #[test]
    fn unused_it_ends_and_used_it_lasts_a_shift_or_a_month() {
        let (users, start) = (users(), Instant::now());
        for (name, longest) in [("ada", MAX_AGE_WRITER), ("bob", MAX_AGE_VIEWER)] {
            let mut sessions = Sessions::default();
            let (used, unused) = (begin(&mut sessions, &users, name, start), begin(&mut sessions, &users, name, start));
            assert!(
                sessions.has_session(name, &users, start) && !sessions.has_session(name, &users, start + IDLE_TIMEOUT),
                "{name}"
            );
            assert_eq!(sessions.resume(&unused, &users, start + IDLE_TIMEOUT), None, "{name}");
            let mut now = start;
            while now + IDLE_TIMEOUT / 2 < start + longest {
                now += IDLE_TIMEOUT / 2;
                assert!(sessions.resume(&used, &users, now).is_some(), "{name} after {:?}", now - start);
            }
            assert_eq!(sessions.resume(&used, &users, start + longest), None, "{name}");
        }
    }

    #[test]
    fn whoever_is_removed_or_gets_a_new_password_is_out_and_a_new_role_holds_at_once() {
        let (old, now) = (users(), Instant::now());
        let mut sessions = Sessions::default();
        let (ada, bob) = (begin(&mut sessions, &old, "ada", now), begin(&mut sessions, &old, "bob", now));
        let mut new = old.clone();
        new.get_mut("ada").unwrap().role = Role::Viewer;
        assert_eq!(sessions.resume(&ada, &new, now).unwrap().user.role, Role::Viewer);
        new.get_mut("ada").unwrap().password = Hash::of("tin whisker plateau").unwrap();
        new.remove("bob").unwrap();
        assert_eq!((sessions.resume(&ada, &new, now), sessions.resume(&bob, &new, now)), (None, None));
        assert_eq!(sessions.resume(&ada, &old, now), None, "an ended session does not come back");
    }

    #[test]
    fn there_are_never_too_many() {
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
        assert_eq!(sessions.0.len(), 1, "those that have ended are forgotten");
    }
}
