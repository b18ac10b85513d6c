//! Sessions, in memory only: after a restart of the station every user logs in again.
//!
//! A session ends when its user logs out, when the user is removed or gets a new password, when it was not used for
//! [`IDLE_TIMEOUT`], and at its maximum age. The event stream of an open page uses its session all the time, so a page in a
//! control room stays logged in until the maximum age.
//!
//! The session of a user of an OpenID provider has the role of the login until it ends: the station does not learn what changes there.

use super::openid::Identity;
use super::password::Hash;
use super::secret::RandomSecret;
use super::users::{Account, Users};
use super::{Role, User};
use std::collections::HashMap;
use std::sync::Arc;
use std::time::{Duration, Instant};

/// An unused session ends after this time. chosen: longer than a break, shorter than an absence.
pub const IDLE_TIMEOUT: Duration = Duration::from_secs(30 * 60);

/// The maximum age of a session of an operator or engineer: one login per shift. chosen.
pub const MAX_AGE_WRITER: Duration = Duration::from_secs(12 * 3600);

/// The maximum age of a session of a viewer: a wall display in a control room logs in once a month. chosen.
pub const MAX_AGE_VIEWER: Duration = Duration::from_secs(30 * 24 * 3600);

/// The maximum age of a session of a user of an OpenID provider, of any role: a user who is removed there, or gets another role, keeps the
/// session until then. chosen: one login per shift.
pub const MAX_AGE_OPENID: Duration = Duration::from_secs(12 * 3600);

/// The most sessions of one user. A further login ends the session that was unused for longest. chosen.
pub const MAX_PER_USER: usize = 16;

/// The most sessions of all users. chosen.
pub const MAX_SESSIONS: usize = 1024;

/// What a session rests on.
#[derive(Clone, Debug)]
enum Credential {
    /// The password hash at login. A new password ends the session.
    Password(Hash),
    /// What an OpenID provider said at login: the role, and its identifier of the user.
    OpenId(Role, Arc<str>),
}

/// A session.
#[derive(Clone, Debug)]
struct Session {
    name: Arc<str>,
    credential: Credential,
    token: RandomSecret,
    begun: Instant,
    used: Instant,
}

impl Session {
    /// The user of the session; `None` if the session has ended.
    fn user(&self, users: &Users, now: Instant) -> Option<User> {
        let (user, max_age) = match &self.credential {
            Credential::Password(hash) => {
                let account = users.get(&self.name).filter(|account| account.password == *hash)?;
                let max_age = if account.role == Role::Viewer { MAX_AGE_VIEWER } else { MAX_AGE_WRITER };
                (account.user(), max_age)
            }
            Credential::OpenId(role, _) => (User { name: Arc::clone(&self.name), role: *role }, MAX_AGE_OPENID),
        };
        let is_alive = now.saturating_duration_since(self.used) < IDLE_TIMEOUT
            && now.saturating_duration_since(self.begun) < max_age;
        is_alive.then_some(user)
    }

    /// Whether it is that of another role or of another user of the provider than `identity`.
    fn differs(&self, identity: &Identity) -> bool {
        let Credential::OpenId(role, subject) = &self.credential else { return true };
        *role != identity.user.role || *subject != identity.subject
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
    /// Begins a session of a user of the file.
    ///
    /// # Errors
    /// When the operating system supplies no random numbers.
    pub fn begin(
        &mut self,
        account: &Account,
        users: &Users,
        now: Instant,
    ) -> std::io::Result<(RandomSecret, AuthenticatedUser)> {
        self.begin_as(account.user(), Credential::Password(account.password.clone()), users, now)
    }

    /// Begins a session of a user of an OpenID provider. Sessions of this user with another role end.
    ///
    /// # Errors
    /// When the operating system supplies no random numbers.
    pub fn begin_openid(
        &mut self,
        identity: &Identity,
        users: &Users,
        now: Instant,
    ) -> std::io::Result<(RandomSecret, AuthenticatedUser)> {
        let Identity { user, subject } = identity;
        self.0.retain(|_, session| session.name != user.name || !session.differs(identity));
        self.begin_as(user.clone(), Credential::OpenId(user.role, Arc::clone(subject)), users, now)
    }

    /// Whether another user of the provider has a session under the name of this one.
    #[must_use]
    pub fn has_other_subject(&self, identity: &Identity, users: &Users, now: Instant) -> bool {
        self.0.values().any(|session| {
            let Credential::OpenId(_, subject) = &session.credential else { return false };
            session.name == identity.user.name && *subject != identity.subject && session.user(users, now).is_some()
        })
    }

    /// Begins a session with a new identifier and a new token, and removes the sessions that have ended.
    fn begin_as(
        &mut self,
        user: User,
        credential: Credential,
        users: &Users,
        now: Instant,
    ) -> std::io::Result<(RandomSecret, AuthenticatedUser)> {
        self.0.retain(|_, session| session.user(users, now).is_some());
        while self.0.values().filter(|session| session.name == user.name).count() >= MAX_PER_USER {
            self.remove_oldest(|session| session.name == user.name);
        }
        while self.0.len() >= MAX_SESSIONS {
            self.remove_oldest(|_| true);
        }
        let (id, token) = (RandomSecret::new()?, RandomSecret::new()?);
        let name = Arc::clone(&user.name);
        let authenticated = AuthenticatedUser { user, token: token.clone() };
        self.0.insert(id.clone(), Session { name, credential, token, begun: now, used: now });
        Ok((id, authenticated))
    }

    /// The user of a session. Counts as a use of the session.
    pub fn resume(&mut self, id: &RandomSecret, users: &Users, now: Instant) -> Option<AuthenticatedUser> {
        let session = self.0.get_mut(id)?;
        let Some(user) = session.user(users, now) else {
            self.0.remove(id);
            return None;
        };
        session.used = now;
        Some(AuthenticatedUser { user, token: session.token.clone() })
    }

    /// Whether a user has a session that has not ended.
    #[must_use]
    pub fn has_session(&self, name: &str, users: &Users, now: Instant) -> bool {
        self.role_of(name, users, now).is_some()
    }

    /// The role of a user who has a session that has not ended.
    #[must_use]
    pub fn role_of(&self, name: &str, users: &Users, now: Instant) -> Option<Role> {
        let mut sessions = self.0.values().filter(|session| &*session.name == name);
        sessions.find_map(|session| session.user(users, now)).map(|user| user.role)
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

    fn identity(role: Role, subject: &str) -> Identity {
        Identity { user: User { name: Arc::from("openid:ada"), role }, subject: Arc::from(subject) }
    }

    #[test]
    fn a_session_of_an_openid_user_has_the_role_of_the_login_for_twelve_hours_at_most() {
        let (users, start) = (users(), Instant::now());
        for role in Role::ALL {
            let mut sessions = Sessions::default();
            let (id, begun) = sessions.begin_openid(&identity(role, "1"), &users, start).unwrap();
            assert_eq!(begun.user.role, role);
            assert!(sessions.role_of("openid:ada", &users, start + IDLE_TIMEOUT).is_none(), "unused for half an hour");
            let mut now = start;
            while now + IDLE_TIMEOUT / 2 < start + MAX_AGE_OPENID {
                now += IDLE_TIMEOUT / 2;
                let resumed = sessions.resume(&id, &Users::default(), now).unwrap();
                assert_eq!(resumed.user.role, role, "the users' file does not matter");
            }
            assert_eq!(sessions.resume(&id, &users, start + MAX_AGE_OPENID), None);
        }
    }

    #[test]
    fn a_login_with_another_role_ends_the_sessions_of_this_openid_user_alone() {
        let (users, now) = (users(), Instant::now());
        let mut sessions = Sessions::default();
        let ada = begin(&mut sessions, &users, "ada", now);
        let (first, _) = sessions.begin_openid(&identity(Role::Engineer, "1"), &users, now).unwrap();
        let (second, _) = sessions.begin_openid(&identity(Role::Engineer, "1"), &users, now).unwrap();
        assert!(sessions.resume(&first, &users, now).is_some(), "the same role");
        let (third, _) = sessions.begin_openid(&identity(Role::Viewer, "1"), &users, now).unwrap();
        assert_eq!([&first, &second].map(|id| sessions.resume(id, &users, now)), [None, None]);
        assert_eq!(sessions.role_of("openid:ada", &users, now), Some(Role::Viewer));
        assert!([&third, &ada].iter().all(|id| sessions.resume(id, &users, now).is_some()));
    }

    #[test]
    fn two_openid_users_never_have_one_name_at_the_same_time() {
        let (users, now) = (users(), Instant::now());
        let mut sessions = Sessions::default();
        let (id, _) = sessions.begin_openid(&identity(Role::Engineer, "1"), &users, now).unwrap();
        assert!(!sessions.has_other_subject(&identity(Role::Viewer, "1"), &users, now));
        assert!(sessions.has_other_subject(&identity(Role::Engineer, "2"), &users, now));
        assert!(!sessions.has_other_subject(&identity(Role::Engineer, "2"), &users, now + IDLE_TIMEOUT));
        sessions.end(&id);
        assert!(!sessions.has_other_subject(&identity(Role::Engineer, "2"), &users, now));
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
