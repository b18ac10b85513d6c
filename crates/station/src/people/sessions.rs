//! Who has logged in. In memory alone: after a restart everybody logs in again.
//!
//! A session ends when its person logs out, is removed or gets a new password; when it was not used for half an hour; and
//! after some time in any case. An open page uses its session as long as it is heard: in a control room it stays for days.

use super::password::Hash;
use super::secret::Secret;
use super::users::{User, Users};
use super::{Person, Role};
use std::collections::HashMap;
use std::sync::Arc;
use std::time::{Duration, Instant};

/// Unused for so long, a session ends. free choice: a closed page is no open door; a lunch is longer than this.
pub const IDLE: Duration = Duration::from_secs(30 * 60);

/// Who may change something logs in once a shift. free choice.
pub const SHIFT: Duration = Duration::from_secs(12 * 3600);

/// Who only looks stays for a month: a screen on the wall of a control room. free choice.
pub const MONTH: Duration = Duration::from_secs(30 * 24 * 3600);

/// So many at once for each person; a further one ends the one that was unused for longest. free choice.
pub const MOST_EACH: usize = 16;

/// So many at once in all. free choice.
pub const MOST: usize = 1024;

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
    fn user<'a>(&self, users: &'a Users, now: Instant) -> Option<&'a User> {
        let user = users.get(&self.name).filter(|user| user.password == self.password)?;
        let longest = if user.role == Role::Viewer { MONTH } else { SHIFT };
        let alive =
            now.saturating_duration_since(self.used) < IDLE && now.saturating_duration_since(self.begun) < longest;
        alive.then_some(user)
    }
}

/// Whoever a session belongs to.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Known {
    /// Who.
    pub person: Person,
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
    pub fn begin(&mut self, user: &User, users: &Users, now: Instant) -> std::io::Result<(Secret, Known)> {
        self.0.retain(|_, session| session.user(users, now).is_some());
        while self.0.values().filter(|session| session.name == user.name).count() >= MOST_EACH {
            self.forget_oldest(|session| session.name == user.name);
        }
        while self.0.len() >= MOST {
            self.forget_oldest(|_| true);
        }
        let (id, token) = (Secret::new()?, Secret::new()?);
        let known = Known { person: user.person(), token: token.clone() };
        let session =
            Session { name: Arc::clone(&user.name), password: user.password.clone(), token, begun: now, used: now };
        self.0.insert(id.clone(), session);
        Ok((id, known))
    }

    /// Whose session this is; it has been used then.
    pub fn visit(&mut self, id: &Secret, users: &Users, now: Instant) -> Option<Known> {
        let session = self.0.get_mut(id)?;
        let Some(user) = session.user(users, now) else {
            self.0.remove(id);
            return None;
        };
        session.used = now;
        Some(Known { person: user.person(), token: session.token.clone() })
    }

    /// Whether somebody of this name has one.
    #[must_use]
    pub fn has(&self, name: &str, users: &Users, now: Instant) -> bool {
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
        assert_eq!(sessions.visit(&id, &users, now), Some(begun.clone()));
        assert_eq!((&*begun.person.name, begun.person.role), ("ada", Role::Engineer));
        assert_eq!(sessions.visit(&Secret::new().unwrap(), &users, now), None);
        sessions.end(&id);
        assert_eq!(sessions.visit(&id, &users, now), None);
    }

    #[test]
    fn unused_it_ends_and_used_it_lasts_a_shift_or_a_month() {
        let (users, start) = (users(), Instant::now());
        for (name, longest) in [("ada", SHIFT), ("bob", MONTH)] {
            let mut sessions = Sessions::default();
            let (used, unused) = (begin(&mut sessions, &users, name, start), begin(&mut sessions, &users, name, start));
            assert_eq!(sessions.visit(&unused, &users, start + IDLE), None, "{name}");
            let mut now = start;
            while now + IDLE / 2 < start + longest {
                now += IDLE / 2;
                assert!(sessions.visit(&used, &users, now).is_some(), "{name} after {:?}", now - start);
            }
            assert_eq!(sessions.visit(&used, &users, start + longest), None, "{name}");
        }
    }

    #[test]
    fn whoever_is_removed_or_gets_a_new_password_is_out_and_a_new_role_holds_at_once() {
        let (old, now) = (users(), Instant::now());
        let mut sessions = Sessions::default();
        let (ada, bob) = (begin(&mut sessions, &old, "ada", now), begin(&mut sessions, &old, "bob", now));
        let mut new = old.clone();
        new.get_mut("ada").unwrap().role = Role::Viewer;
        assert_eq!(sessions.visit(&ada, &new, now).unwrap().person.role, Role::Viewer);
        new.get_mut("ada").unwrap().password = Hash::of("tin whisker plateau").unwrap();
        new.remove("bob").unwrap();
        assert_eq!((sessions.visit(&ada, &new, now), sessions.visit(&bob, &new, now)), (None, None));
        assert_eq!(sessions.visit(&ada, &old, now), None, "an ended session does not come back");
    }

    #[test]
    fn there_are_never_too_many() {
        let (users, start) = (users(), Instant::now());
        let mut sessions = Sessions::default();
        let bob = begin(&mut sessions, &users, "bob", start);
        let first = begin(&mut sessions, &users, "ada", start);
        for second in 1..=MOST_EACH as u64 {
            begin(&mut sessions, &users, "ada", start + Duration::from_secs(second));
        }
        assert_eq!(sessions.0.len(), MOST_EACH + 1);
        assert_eq!(sessions.visit(&first, &users, start), None);
        assert!(sessions.visit(&bob, &users, start).is_some());
        begin(&mut sessions, &users, "bob", start + 2 * IDLE);
        assert_eq!(sessions.0.len(), 1, "those that have ended are forgotten");
    }
}
