//! Sessions, in memory, and what a file has of them, so that they survive a restart of the station.
//!
//! A session ends when its user logs out, when the user is removed or gets a new password, when it was not used for
//! [`IDLE_TIMEOUT`], and at its maximum age. The event stream of an open page uses its session all the time, so a page in a
//! control room stays logged in until the maximum age. The session of a wall display ends at [`MAX_AGE_WALL`] alone.
//!
//! The session of a user of an OpenID provider has the role of the login until it ends: the station does not learn what changes there.
//!
//! | Session | Survives a restart |
//! |---|---|
//! | of a user of the users' file | if the user has the role and the password of the login |
//! | of a viewer of an OpenID provider | if the station still uses this provider, with the same claims and roles |
//! | of an operator or engineer of an OpenID provider | no |

use super::openid::Identity;
use super::password::Hash;
use super::secret::{RandomSecret, SecretDigest};
use super::users::{Account, Users};
use super::{Role, User};
use serde::{Deserialize, Serialize};
use std::collections::HashMap;
use std::sync::Arc;
use std::time::{Duration, Instant};

/// An unused session ends after this time. chosen: longer than a break, shorter than an absence.
pub const IDLE_TIMEOUT: Duration = Duration::from_secs(30 * 60);

/// The maximum age of a session of an operator or engineer: one login per shift. chosen.
pub const MAX_AGE_WRITER: Duration = Duration::from_secs(12 * 3600);

/// The maximum age of a session of a viewer: a screen in a control room logs in once a month. chosen.
pub const MAX_AGE_VIEWER: Duration = Duration::from_secs(30 * 24 * 3600);

/// The maximum age of a session of a wall display, used or not: it logs in once a year. chosen: browsers keep a cookie for 400 days at most.
pub const MAX_AGE_WALL: Duration = Duration::from_secs(365 * 24 * 3600);

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
    /// The password hash and the role at login. A new password ends the session; another role applies at once.
    Password(Hash, Role),
    /// What an OpenID provider said at login: the role, and its identifier of the user.
    OpenId(Role, Arc<str>),
}

/// A session.
#[derive(Clone, Debug)]
struct Session {
    name: Arc<str>,
    credential: Credential,
    begun: Instant,
    /// How old the session was at `begun`: the station was restarted since the login.
    age_before: Duration,
    used: Instant,
    /// How long the session was unused at `used`.
    unused_before: Duration,
}

impl Session {
    /// The account of a user of the file; `None` if the session has ended or is that of a user of a provider.
    fn account<'a>(&self, users: &'a Users) -> Option<&'a Account> {
        let Credential::Password(hash, _) = &self.credential else { return None };
        users.get(&self.name).filter(|account| account.password == *hash)
    }

    /// The user of the session; `None` if the session has ended.
    fn user(&self, users: &Users, now: Instant) -> Option<User> {
        let (user, max_age, max_unused) = match &self.credential {
            Credential::Password(..) => {
                let account = self.account(users)?;
                let (max_age, max_unused) = match (account.is_wall, account.role) {
                    (true, _) => (MAX_AGE_WALL, MAX_AGE_WALL),
                    (false, Role::Viewer) => (MAX_AGE_VIEWER, IDLE_TIMEOUT),
                    (false, _) => (MAX_AGE_WRITER, IDLE_TIMEOUT),
                };
                (account.user(), max_age, max_unused)
            }
            Credential::OpenId(role, _) => {
                (User { name: Arc::clone(&self.name), role: *role }, MAX_AGE_OPENID, IDLE_TIMEOUT)
            }
        };
        (self.unused(now) < max_unused && self.age(now) < max_age).then_some(user)
    }

    fn age(&self, now: Instant) -> Duration {
        self.age_before.saturating_add(now.saturating_duration_since(self.begun))
    }

    fn unused(&self, now: Instant) -> Duration {
        self.unused_before.saturating_add(now.saturating_duration_since(self.used))
    }

    /// The user with the token of the session, which has the identifier `id`; `None` if the session has ended.
    fn authenticated(&self, id: &RandomSecret, users: &Users, now: Instant) -> Option<AuthenticatedUser> {
        let user = self.user(users, now)?;
        let is_wall = self.account(users).is_some_and(|account| account.is_wall);
        let cookie_age = is_wall.then(|| MAX_AGE_WALL.saturating_sub(self.age(now)));
        Some(AuthenticatedUser { user, token: id.session_token(), cookie_age })
    }

    /// Whether it is that of another role or of another user of the provider than `identity`.
    fn differs(&self, identity: &Identity) -> bool {
        let Credential::OpenId(role, subject) = &self.credential else { return true };
        *role != identity.user.role || *subject != identity.subject
    }

    /// The session as the file has it; `None` if it does not survive a restart.
    fn stored(&self, id: &SecretDigest, provider: Option<&str>, now: Instant) -> Option<StoredSession> {
        let (role, credential) = match &self.credential {
            Credential::Password(hash, role) => {
                (*role, StoredCredential::Password { hash: SecretDigest::of(hash.as_str()) })
            }
            Credential::OpenId(Role::Viewer, subject) => {
                let (provider, subject) = (provider?.to_owned(), subject.to_string());
                (Role::Viewer, StoredCredential::OpenId { provider, subject })
            }
            Credential::OpenId(..) => return None,
        };
        Some(StoredSession {
            id: id.clone(),
            name: self.name.to_string(),
            role,
            credential,
            age_s: self.age(now).as_secs(),
            unused_s: self.unused(now).as_secs(),
        })
    }
}

/// A session as the file has it, without anything that a thief of the file could use.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct StoredSession {
    /// The digest of the identifier.
    id: SecretDigest,
    /// The name of the user.
    name: String,
    /// The role at login.
    role: Role,
    /// What the session rests on.
    credential: StoredCredential,
    /// The age, in seconds.
    age_s: u64,
    /// The time since the last use, in seconds.
    unused_s: u64,
}

/// What a stored session rests on.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case", deny_unknown_fields)]
enum StoredCredential {
    /// The digest of the password hash.
    Password {
        /// The digest.
        hash: SecretDigest,
    },
    /// A user of an OpenID provider.
    #[serde(rename = "openid")]
    OpenId {
        /// The digest of the provider, its claims and the roles.
        provider: String,
        /// What the provider calls the user.
        subject: String,
    },
}

impl StoredSession {
    /// The session after a stop of `stopped`; `None` if its user has another role or password than at login, is no user any more, or is a
    /// user of another provider than `provider`, or of it with other claims or roles.
    fn restored(
        self,
        stopped: Duration,
        users: &Users,
        provider: Option<&str>,
        now: Instant,
    ) -> Option<(SecretDigest, Session)> {
        let Self { id, name, role, credential, age_s, unused_s } = self;
        let credential = match credential {
            StoredCredential::Password { hash } => {
                let account = users.get(&name).filter(|account| account.role == role)?;
                if SecretDigest::of(account.password.as_str()) != hash {
                    return None;
                }
                Credential::Password(account.password.clone(), role)
            }
            StoredCredential::OpenId { provider: of, subject }
                if role == Role::Viewer && provider == Some(of.as_str()) =>
            {
                Credential::OpenId(role, Arc::from(subject))
            }
            StoredCredential::OpenId { .. } => return None,
        };
        let before = |seconds| Duration::from_secs(seconds).saturating_add(stopped);
        let (age_before, unused_before) = (before(age_s), before(unused_s));
        let session = Session { name: Arc::from(name), credential, begun: now, age_before, used: now, unused_before };
        session.user(users, now).is_some().then_some((id, session))
    }
}

/// The user of a session, and the token of the session.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct AuthenticatedUser {
    /// The user.
    pub user: User,
    /// The token that the page sends with every change (see `x-csrf-token`).
    pub token: RandomSecret,
    /// How long the browser keeps the cookie of the session, also when it is closed; `None`: until it is closed.
    pub cookie_age: Option<Duration>,
}

/// All sessions by the digests of their identifiers.
#[derive(Debug, Default)]
pub struct Sessions {
    all: HashMap<SecretDigest, Session>,
    /// How often a session has begun or ended by a logout or login.
    changes: u64,
}

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
        let credential = Credential::Password(account.password.clone(), account.role);
        let cookie_age = account.is_wall.then_some(MAX_AGE_WALL);
        self.begin_as(account.user(), credential, cookie_age, users, now)
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
        self.all.retain(|_, session| session.name != user.name || !session.differs(identity));
        self.begin_as(user.clone(), Credential::OpenId(user.role, Arc::clone(subject)), None, users, now)
    }

    /// Whether another user of the provider has a session under the name of this one.
    #[must_use]
    pub fn has_other_subject(&self, identity: &Identity, users: &Users, now: Instant) -> bool {
        self.all.values().any(|session| {
            let Credential::OpenId(_, subject) = &session.credential else { return false };
            session.name == identity.user.name && *subject != identity.subject && session.user(users, now).is_some()
        })
    }

    /// Begins a session with a new identifier and a new token, and removes the sessions that have ended.
    fn begin_as(
        &mut self,
        user: User,
        credential: Credential,
        cookie_age: Option<Duration>,
        users: &Users,
        now: Instant,
    ) -> std::io::Result<(RandomSecret, AuthenticatedUser)> {
        self.all.retain(|_, session| session.user(users, now).is_some());
        while self.count_of(&user.name) >= MAX_PER_USER {
            self.remove_oldest(now, |session| session.name == user.name);
        }
        while self.all.len() >= MAX_SESSIONS {
            self.remove_oldest(now, |_| true);
        }
        let id = RandomSecret::new()?;
        let name = Arc::clone(&user.name);
        let authenticated = AuthenticatedUser { user, token: id.session_token(), cookie_age };
        let (age_before, unused_before) = (Duration::ZERO, Duration::ZERO);
        let session = Session { name, credential, begun: now, age_before, used: now, unused_before };
        self.all.insert(id.digest(), session);
        self.changes = self.changes.wrapping_add(1);
        Ok((id, authenticated))
    }

    /// The user of a session. Counts as a use of the session.
    pub fn resume(&mut self, id: &RandomSecret, users: &Users, now: Instant) -> Option<AuthenticatedUser> {
        let digest = id.digest();
        let session = self.all.get_mut(&digest)?;
        let Some(authenticated) = session.authenticated(id, users, now) else {
            self.all.remove(&digest);
            return None;
        };
        (session.used, session.unused_before) = (now, Duration::ZERO);
        Some(authenticated)
    }

    /// Whether a user has a session that has not ended.
    #[must_use]
    pub fn has_session(&self, name: &str, users: &Users, now: Instant) -> bool {
        self.role_of(name, users, now).is_some()
    }

    /// The role of a user who has a session that has not ended.
    #[must_use]
    pub fn role_of(&self, name: &str, users: &Users, now: Instant) -> Option<Role> {
        let mut sessions = self.all.values().filter(|session| &*session.name == name);
        sessions.find_map(|session| session.user(users, now)).map(|user| user.role)
    }

    /// Ends a session.
    pub fn end(&mut self, id: &RandomSecret) {
        if self.all.remove(&id.digest()).is_some() {
            self.changes = self.changes.wrapping_add(1);
        }
    }

    /// A number that is another one after a session has begun, or has ended by a logout or login.
    #[must_use]
    pub const fn changes(&self) -> u64 {
        self.changes
    }

    /// The sessions that survive a restart. `provider` is the digest of the OpenID provider, its claims and the roles.
    #[must_use]
    pub fn stored(&self, users: &Users, provider: Option<&str>, now: Instant) -> Vec<StoredSession> {
        let alive = self.all.iter().filter(|(_, session)| session.user(users, now).is_some());
        alive.filter_map(|(id, session)| session.stored(id, provider, now)).collect()
    }

    /// Continues stored sessions after a stop of `stopped`, within the bounds of all sessions. Returns how many have not ended.
    pub fn restore(
        &mut self,
        mut stored: Vec<StoredSession>,
        stopped: Duration,
        users: &Users,
        provider: Option<&str>,
        now: Instant,
    ) -> usize {
        stored.sort_by_key(|session| session.unused_s);
        for (id, session) in stored.into_iter().filter_map(|session| session.restored(stopped, users, provider, now)) {
            if self.all.len() < MAX_SESSIONS && self.count_of(&session.name) < MAX_PER_USER {
                self.all.insert(id, session);
            }
        }
        self.all.len()
    }

    fn count_of(&self, name: &str) -> usize {
        self.all.values().filter(|session| &*session.name == name).count()
    }

    fn remove_oldest(&mut self, now: Instant, is_candidate: impl Fn(&Session) -> bool) {
        let candidates = self.all.iter().filter(|(_, session)| is_candidate(session));
        let oldest = candidates.max_by_key(|(_, session)| session.unused(now));
        if let Some(id) = oldest.map(|(id, _)| id.clone()) {
            self.all.remove(&id);
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
        assert_eq!(sessions.all.len(), MAX_PER_USER + 1);
        assert_eq!(sessions.resume(&first, &users, start), None);
        assert!(sessions.resume(&bob, &users, start).is_some());
        begin(&mut sessions, &users, "bob", start + 2 * IDLE_TIMEOUT);
        assert_eq!(sessions.all.len(), 1, "sessions that have ended are removed");
    }

    /// The sessions after a restart with a stop of this length, as the file has them.
    fn restarted(sessions: &Sessions, stopped: Duration, users: &Users, now: Instant) -> Sessions {
        let text = serde_json::to_string(&sessions.stored(users, Some("https://login.example"), now)).unwrap();
        let mut new = Sessions::default();
        new.restore(serde_json::from_str(&text).unwrap(), stopped, users, Some("https://login.example"), now);
        new
    }

    #[test]
    fn a_session_survives_a_restart_with_its_token_and_its_age() {
        let (users, start) = (users(), Instant::now());
        let mut sessions = Sessions::default();
        let (id, begun) = sessions.begin(users.get("ada").unwrap(), &users, start).unwrap();
        let half = IDLE_TIMEOUT / 2;
        let mut now = start;
        while now + half < start + MAX_AGE_WRITER {
            sessions = restarted(&sessions, Duration::ZERO, &users, now);
            assert_eq!(sessions.resume(&id, &users, now), Some(begun.clone()), "after {:?}", now - start);
            now += half;
        }
        // A quarter of an hour is left.
        let mut last = restarted(&sessions, Duration::ZERO, &users, now);
        assert_eq!(last.resume(&id, &users, now), Some(begun));
        assert!(restarted(&last, half, &users, now).all.is_empty(), "the time of the stop counts");
        assert_eq!(last.resume(&id, &users, now + half), None, "a restart makes no session longer");
    }

    #[test]
    fn a_session_that_has_ended_or_whose_user_has_changed_does_not_survive_a_restart() {
        let (users, now) = (users(), Instant::now());
        let mut sessions = Sessions::default();
        let (ended, stays) = (begin(&mut sessions, &users, "ada", now), begin(&mut sessions, &users, "ada", now));
        sessions.end(&ended);
        let mut new = restarted(&sessions, IDLE_TIMEOUT / 2, &users, now);
        assert!(new.resume(&ended, &users, now).is_none() && new.resume(&stays, &users, now).is_some());
        assert!(restarted(&sessions, IDLE_TIMEOUT, &users, now).all.is_empty(), "unused for half an hour");
        let changes: [fn(&mut Users); 3] = [
            |users: &mut Users| users.remove("ada").unwrap(),
            |users: &mut Users| users.set_role("ada", Role::Operator).unwrap(),
            |users: &mut Users| users.get_mut("ada").unwrap().password = Hash::of("tin whisker plateau").unwrap(),
        ];
        for change in changes {
            let mut changed = users.clone();
            change(&mut changed);
            let mut new = Sessions::default();
            assert_eq!(new.restore(sessions.stored(&users, None, now), Duration::ZERO, &changed, None, now), 0);
        }
    }

    #[test]
    fn of_the_users_of_a_provider_only_viewers_survive_a_restart_and_only_at_this_provider() {
        let (users, now) = (users(), Instant::now());
        for role in Role::ALL {
            let mut sessions = Sessions::default();
            let (id, _) = sessions.begin_openid(&identity(role, "1"), &users, now).unwrap();
            let mut new = restarted(&sessions, IDLE_TIMEOUT / 2, &users, now);
            assert_eq!(new.resume(&id, &users, now).is_some(), role == Role::Viewer, "{role}");
            for provider in [None, Some("https://other.example")] {
                let stored = sessions.stored(&users, Some("https://login.example"), now);
                assert_eq!(Sessions::default().restore(stored, Duration::ZERO, &users, provider, now), 0);
            }
        }
    }

    #[test]
    fn a_wall_display_is_logged_in_for_a_year_whether_it_runs_or_not() {
        let (mut users, start) = (users(), Instant::now());
        users.add_wall("wall", Hash::of("tin whisker plateau").unwrap()).unwrap();
        let mut sessions = Sessions::default();
        let (id, begun) = sessions.begin(users.get("wall").unwrap(), &users, start).unwrap();
        assert_eq!((begun.user.role, begun.cookie_age), (Role::Viewer, Some(MAX_AGE_WALL)));
        let month = Duration::from_secs(30 * 24 * 3600);
        assert!(sessions.resume(&id, &users, start + month).is_some());
        let mut new = restarted(&sessions, 11 * month, &users, start + month);
        let resumed = new.resume(&id, &users, start + month).unwrap();
        assert_eq!(resumed.cookie_age, Some(MAX_AGE_WALL - 12 * month));
        assert!(restarted(&sessions, MAX_AGE_WALL, &users, start).all.is_empty());
        users.remove("wall").unwrap();
        assert_eq!(new.resume(&id, &users, start + month), None);
    }

    #[test]
    fn the_stored_sessions_are_bounded_and_hold_neither_identifiers_nor_tokens_nor_hashes() {
        let (users, now) = (users(), Instant::now());
        let mut sessions = Sessions::default();
        let (id, begun) = sessions.begin(users.get("bob").unwrap(), &users, now).unwrap();
        let stored = sessions.stored(&users, None, now);
        let text = serde_json::to_string(&stored).unwrap();
        let hash = users.get("bob").unwrap().password.as_str();
        assert!([id.reveal(), begun.token.reveal(), hash].iter().all(|secret| !text.contains(*secret)), "{text}");
        let many = (0..2 * MAX_SESSIONS).map(|number| {
            let id = SecretDigest::of(&number.to_string());
            StoredSession { id, unused_s: number as u64 % 100, ..stored[0].clone() }
        });
        let mut new = Sessions::default();
        assert_eq!(new.restore(many.collect(), Duration::ZERO, &users, None, now), MAX_PER_USER);
        assert!(new.all.values().all(|session| session.unused(now) == Duration::ZERO), "those used last");
    }
}
