//! Authentication of requests: login with a password or at an OpenID provider, sessions, and the event log of logins and refusals. A
//! user without a session has no control authority and no armed commands.

use crate::auth::openid::{BegunLogin, Identity, OpenIdError, OpenIdProvider, ReturnedLogin, is_openid};
use crate::auth::password::{self, Hash, PasswordError};
use crate::auth::rate_limit::{RateLimiters, RateLimits};
use crate::auth::secret::RandomSecret;
use crate::auth::session_file;
use crate::auth::sessions::{AuthenticatedUser, Sessions};
use crate::auth::users::{Account, Users, UsersError};
use crate::auth::{Access, User};
use profivac_files::{Stamp, stamp};
use std::net::{IpAddr, SocketAddr};
use std::path::PathBuf;
use std::sync::{Arc, Mutex, MutexGuard, OnceLock, PoisonError, RwLock};
use std::time::{Duration, Instant, SystemTime};
use tokio::sync::Semaphore;
use tokio::task::spawn_blocking;

/// Password hashes that run at the same time. Each takes a processor and 19 MiB for some ten milliseconds. chosen.
const MAX_HASHES: usize = 2;

/// The longest wait for a password hash to begin.
const HASH_TIMEOUT: Duration = Duration::from_secs(10);

/// How often the times of the last uses of sessions are stored, while no session begins or ends. chosen: a power cut makes a session unused
/// for a few minutes longer than it was.
const USES_PERIOD: Duration = Duration::from_secs(5 * 60);

/// The pause after the sessions could not be stored. chosen.
const STORE_PAUSE: Duration = Duration::from_secs(10);

/// Why a login or a change of password is refused.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum AuthError {
    /// The station has no users' file.
    #[error("this station has no users and no login")]
    NoUsers,
    /// The station has no OpenID provider.
    #[error("this station has no OpenID provider")]
    NoProvider,
    /// The login at the provider fails.
    #[error(transparent)]
    OpenId(#[from] OpenIdError),
    /// The user has no password at this station.
    #[error("the provider keeps the password of this user: change it there")]
    ForeignPassword,
    /// The name or the password is wrong; the answer does not say which.
    #[error("wrong name or password")]
    WrongCredentials,
    /// The current password is wrong.
    #[error("the current password is wrong")]
    WrongPassword,
    /// The client is above a rate limit, and may try again after this time.
    #[error("too many logins; try again later")]
    TooOften(Duration),
    /// Too many password hashes wait.
    #[error("too many logins at the same time; try again")]
    Busy,
    /// The new password is refused.
    #[error(transparent)]
    NewPassword(#[from] PasswordError),
    /// The users' file cannot be changed.
    #[error("the password cannot be stored: {0}")]
    Users(#[from] UsersError),
    /// The work for a login has panicked.
    #[error("a defect of the program; the station continues to run")]
    Defect,
    /// The operating system supplies no random numbers.
    #[error("no session can begin: {0}")]
    Random(std::io::Error),
}

/// The reason why a user can no longer have control.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ReleaseReason {
    /// The last session of the user has ended: logout, timeout, or removal of the account.
    SessionEnded,
    /// The user has another role.
    RoleChanged,
}

/// What a program does about its users besides checking their passwords.
pub trait AccessObserver: Send + Sync {
    /// Records a login, a logout, a refusal, or a change of the users' file. The sentence names no password.
    fn record(&self, sentence: &str);

    /// Sessions may have ended or roles changed: `ended` says why a user has no session of this role any more.
    fn sessions_changed(&self, ended: &dyn Fn(&User) -> Option<ReleaseReason>);
}

/// The users of a station and their sessions.
struct UserDirectory {
    file: PathBuf,
    users: RwLock<Arc<Users>>,
    sessions: Mutex<Sessions>,
    /// The hash that is verified for an unknown name, so that the answer takes as long as for a known one.
    dummy: Hash,
    stamp: Mutex<Option<Stamp>>,
    session_file: PathBuf,
    stored: Mutex<StoredState>,
}

/// What the file of the sessions has.
#[derive(Default)]
struct StoredState {
    /// The state of the sessions that was stored.
    changes: u64,
    /// The last attempt, if there was one.
    at: Option<Instant>,
    /// Whether the last attempt failed.
    has_failed: bool,
}

/// The authentication of requests.
pub struct Authenticator {
    /// The address in the settings of the server, which tells its file of sessions from those of other servers.
    server: String,
    observer: Arc<dyn AccessObserver>,
    /// The user of every request while there is no directory. The token proves that a change comes from a page of the station.
    anonymous: AuthenticatedUser,
    /// The users who log in.
    directory: OnceLock<UserDirectory>,
    /// The provider at which users may log in besides.
    provider: Option<OpenIdProvider>,
    /// The file that becomes the directory as soon as it has users, and its stamp when it was last read.
    awaited: Option<(PathBuf, Mutex<Option<Stamp>>)>,
    limiters: RateLimiters,
    hash_slots: Arc<Semaphore>,
}

impl Authenticator {
    /// Reads the users' file, if there is one. `server` is the address in the settings.
    ///
    /// # Errors
    /// [`UsersError`] when the file cannot be read.
    pub fn new(
        observer: Arc<dyn AccessObserver>,
        server: SocketAddr,
        access: Access,
        limits: RateLimits,
    ) -> Result<Self, UsersError> {
        let token = RandomSecret::new().map_err(|error| UsersError::System(PathBuf::from("/dev/urandom"), error))?;
        let (user, directory, awaited) = match access {
            Access::Anonymous(user) => (user, None, None),
            Access::Users(file) => (User::anonymous(), Some(UserDirectory::open(file)?), None),
            Access::UsersWhenPresent(file) => (User::anonymous(), None, Some((file, Mutex::default()))),
        };
        let authenticator = Self {
            server: server.to_string(),
            observer,
            anonymous: AuthenticatedUser { user, token, cookie_age: None },
            directory: directory.map_or_else(OnceLock::new, OnceLock::from),
            provider: None,
            awaited,
            limiters: RateLimiters::new(limits, Instant::now),
            hash_slots: Arc::new(Semaphore::new(MAX_HASHES)),
        };
        Ok(authenticator)
    }

    /// Lets users log in at this provider besides.
    #[must_use]
    pub fn with_provider(self, provider: Option<OpenIdProvider>) -> Self {
        Self { provider, ..self }
    }

    /// The OpenID provider, if users log in.
    #[must_use]
    pub fn provider(&self) -> Option<&OpenIdProvider> {
        self.provider.as_ref().filter(|_| self.requires_login())
    }

    /// Continues the sessions from before a restart. A file of sessions that is lost or damaged is no error: every user logs in again.
    /// Control authority and armed commands do not continue.
    pub fn restore_sessions(&self) {
        let Some(directory) = self.directory() else { return };
        match session_file::read(&directory.session_file, &self.server, SystemTime::now()) {
            Ok(None) => {}
            Ok(Some((stored, stopped))) => {
                let users = directory.users();
                let now = Instant::now();
                let count = directory.sessions().restore(stored, stopped, &users, self.provider_digest(), now);
                directory.stored.lock().unwrap_or_else(PoisonError::into_inner).at = Some(now);
                if count > 0 {
                    self.record_event(&format!("sessions that continue after the restart: {count}"));
                }
            }
            Err(error) => self.record_event(&format!("every user logs in again: {error}")),
        }
    }

    /// Stores the sessions if one has begun or ended, or if the last uses were stored minutes ago. Waits for the disk. A failure is an event
    /// and nothing else: sessions begin and continue without the file.
    pub fn store_sessions(&self) {
        self.store_sessions_after(USES_PERIOD);
    }

    /// Stores the sessions and their last uses, for the next start.
    pub fn store_sessions_at_stop(&self) {
        self.store_sessions_after(Duration::ZERO);
    }

    fn store_sessions_after(&self, period: Duration) {
        let store = |directory: &UserDirectory| directory.store_sessions(&self.server, self.provider_digest(), period);
        if let Some(Err(error)) = self.directory().map(store) {
            self.record_event(&format!("the sessions cannot be stored: {error}"));
        }
    }

    /// What decides which users of the OpenID provider have which role.
    fn provider_digest(&self) -> Option<&str> {
        self.provider.as_ref().map(OpenIdProvider::digest)
    }

    /// The users who log in; `None` while every request is that of the anonymous user.
    fn directory(&self) -> Option<&UserDirectory> {
        self.directory.get()
    }

    /// Whether users log in.
    #[must_use]
    pub fn requires_login(&self) -> bool {
        self.directory().is_some()
    }

    /// Whether there is at least one account.
    #[must_use]
    pub fn has_users(&self) -> bool {
        self.directory().is_some_and(|directory| !directory.users().is_empty())
    }

    /// The rate limiters.
    pub const fn limiters(&self) -> &RateLimiters {
        &self.limiters
    }

    /// The user of a session.
    pub fn authenticate(&self, session: Option<&RandomSecret>) -> Option<AuthenticatedUser> {
        match self.directory() {
            None => Some(self.anonymous.clone()),
            Some(directory) => directory.sessions().resume(session?, &directory.users(), Instant::now()),
        }
    }

    /// Checks name and password and begins a session. The session `before` ends.
    ///
    /// # Errors
    /// [`AuthError`].
    pub async fn login(
        &self,
        name: &str,
        password: String,
        before: Option<&RandomSecret>,
        peer: IpAddr,
    ) -> Result<(RandomSecret, AuthenticatedUser), AuthError> {
        let Some(directory) = self.directory() else { return Err(AuthError::NoUsers) };
        self.check_login_rate(peer, name)?;
        let account = directory.users().get(name).cloned();
        let hash = account.as_ref().map_or(&directory.dummy, |account| &account.password).clone();
        let is_right = self.run_limited(move || hash.matches(&password)).await?;
        // The log never contains an unknown name: a user may have typed the password into the field for the name.
        let Some(account) = account else {
            self.record_refusal(&format!("login from {peer} refused: unknown name"));
            return Err(AuthError::WrongCredentials);
        };
        if !is_right {
            self.record_refusal(&format!("login of {} from {peer} refused: wrong password", account.name));
            return Err(AuthError::WrongCredentials);
        }
        let begun = directory.begin(&account, before)?;
        self.limiters.remember_login(peer, name);
        self.release_control_if_gone(directory);
        self.record_event(&format!("{} ({}) logged in from {peer}", account.name, account.role));
        Ok(begun)
    }

    /// Begins a login at the OpenID provider, for a browser whose page has this origin.
    ///
    /// # Errors
    /// [`AuthError`].
    pub async fn begin_openid(&self, origin: Option<&str>, peer: IpAddr) -> Result<BegunLogin, AuthError> {
        let provider = self.provider().ok_or(AuthError::NoProvider)?;
        self.check_openid_rate(peer)?;
        let begun = provider.begin(peer, origin).await;
        Ok(begun.inspect_err(|error| self.record_refused_openid(provider, peer, error))?)
    }

    /// Completes a login at the OpenID provider and begins a session. The session `before` ends.
    ///
    /// # Errors
    /// [`AuthError`].
    pub async fn finish_openid(
        &self,
        returned: &ReturnedLogin,
        browser: Option<&RandomSecret>,
        before: Option<&RandomSecret>,
        peer: IpAddr,
    ) -> Result<(RandomSecret, AuthenticatedUser), AuthError> {
        let (Some(directory), Some(provider)) = (self.directory(), self.provider()) else {
            return Err(AuthError::NoProvider);
        };
        self.check_openid_rate(peer)?;
        let refused = |error: &OpenIdError| self.record_refused_openid(provider, peer, error);
        let identity = provider.finish(returned, browser).await.inspect_err(refused)?;
        let begun = directory.begin_openid(&identity, before).inspect_err(|error| {
            if let AuthError::OpenId(error) = error {
                refused(error);
            }
        })?;
        self.release_control_if_gone(directory);
        let Identity { user, subject } = identity;
        self.record_event(&format!("{} ({}) logged in from {peer}, subject {subject:?}", user.name, user.role));
        Ok(begun)
    }

    /// The log never contains what the browser sent: state and code are secrets.
    fn record_refused_openid(&self, provider: &OpenIdProvider, peer: IpAddr, error: &OpenIdError) {
        self.record_refusal(&format!("login from {peer} by {} refused: {error}", provider.name()));
    }

    /// Changes a password. All sessions of the user end, and a new one begins.
    ///
    /// # Errors
    /// [`AuthError`].
    pub async fn change_password(
        &self,
        name: &str,
        (current, new): (String, String),
        before: Option<&RandomSecret>,
        peer: IpAddr,
    ) -> Result<(RandomSecret, AuthenticatedUser), AuthError> {
        let Some(directory) = self.directory() else { return Err(AuthError::NoUsers) };
        if is_openid(name) {
            return Err(AuthError::ForeignPassword);
        }
        self.check_login_rate(peer, name)?;
        let old = directory.users().get(name).cloned().ok_or(AuthError::WrongCredentials)?;
        let hash = old.password.clone();
        if !self.run_limited(move || hash.matches(&current)).await? {
            self.record_refusal(&format!("change of the password of {name} from {peer} refused: wrong password"));
            return Err(AuthError::WrongPassword);
        }
        let owner = name.to_owned();
        let password = self.run_limited(move || password::check(&new, &owner).and_then(|()| Hash::of(&new))).await??;
        let (file, account) = (directory.file.clone(), Account { password, ..old });
        let changed = account.clone();
        let store = move || {
            Users::change(&file, |users| {
                users.get_mut(&changed.name).map(|account| account.password = changed.password.clone())
            })
        };
        self.run_limited(store).await??;
        self.reload_users();
        let begun = directory.begin(&account, before);
        self.release_control_if_gone(directory);
        begun
    }

    /// Ends a session. For a user of an OpenID provider, returns the address at which the browser ends the session there, if it has one.
    pub fn logout(&self, session: Option<&RandomSecret>, peer: IpAddr) -> Option<String> {
        let (directory, id) = (self.directory()?, session?);
        let authenticated = self.authenticate(session);
        directory.sessions().end(id);
        if let Some(AuthenticatedUser { user, .. }) = &authenticated {
            self.record_event(&format!("{} logged out from {peer}", user.name));
        }
        self.release_control_if_gone(directory);
        let provider = self.provider().filter(|_| authenticated.is_some_and(|it| is_openid(&it.user.name)))?;
        provider.end_session_url()
    }

    /// Reads the users' file again if it has changed, and releases the control authority of a user whose last session has ended.
    /// The server calls this periodically.
    pub fn reload_users(&self) {
        match self.directory() {
            Some(directory) => {
                self.read_users_if_changed(directory);
                self.release_control_if_gone(directory);
            }
            None => self.begin_logins_if_users_are_present(),
        }
    }

    /// From the first user on, every request needs a login: a station that was started without users takes them without a restart.
    fn begin_logins_if_users_are_present(&self) {
        let Some((file, before)) = &self.awaited else { return };
        let now = stamp(file);
        let mut before = before.lock().unwrap_or_else(PoisonError::into_inner);
        if now.is_none() || *before == now {
            return;
        }
        *before = now;
        match UserDirectory::open(file.clone()) {
            Ok(directory) if directory.users().is_empty() => {}
            Ok(directory) => {
                let added = Users::default().differences(&directory.users());
                // Only this function sets it, under a lock.
                self.directory.set(directory).ok();
                self.record_event("the station has users: every request needs a login from now on");
                added.iter().for_each(|change| self.record_event(&change.to_string()));
            }
            Err(error) => self.record_unreadable_users(&error),
        }
    }

    /// A user without a session, or with another role than before, loses control authority and armed commands.
    fn release_control_if_gone(&self, directory: &UserDirectory) {
        let users = directory.users();
        self.observer.sessions_changed(&|user| match users.get(&user.name) {
            Some(account) if account.role != user.role => Some(ReleaseReason::RoleChanged),
            _ => match directory.sessions().role_of(&user.name, &users, Instant::now()) {
                None => Some(ReleaseReason::SessionEnded),
                Some(role) => (role != user.role).then_some(ReleaseReason::RoleChanged),
            },
        });
    }

    fn read_users_if_changed(&self, directory: &UserDirectory) {
        let now = stamp(&directory.file);
        let mut before = directory.stamp.lock().unwrap_or_else(PoisonError::into_inner);
        if *before == now {
            return;
        }
        *before = now;
        match Users::read(&directory.file) {
            Ok(new) => {
                let old = directory.replace(new.clone());
                old.differences(&new).iter().for_each(|change| self.record_event(&change.to_string()));
            }
            Err(error) => self.record_unreadable_users(&error),
        }
    }

    fn record_unreadable_users(&self, error: &UsersError) {
        match error {
            // The message of the parser may repeat a password: the log has the position only.
            UsersError::File(error) => self.record_event(&format!(
                "the users stay as they were: line {}, column {} of their file is wrong",
                error.line, error.column
            )),
            error => self.record_event(&format!("the users stay as they were: {error}")),
        }
    }

    /// Records a refused request, unless there are too many.
    pub fn record_refusal(&self, sentence: &str) {
        if self.limiters.may_log() {
            self.record_event(sentence);
        }
    }

    fn record_event(&self, sentence: &str) {
        self.observer.record(sentence);
    }

    fn check_login_rate(&self, peer: IpAddr, name: &str) -> Result<(), AuthError> {
        self.limiters.login(peer, name).map_err(|wait| {
            self.record_refusal(&format!("too many logins from {peer}"));
            AuthError::TooOften(wait)
        })
    }

    fn check_openid_rate(&self, peer: IpAddr) -> Result<(), AuthError> {
        self.limiters.openid(peer).map_err(|wait| {
            self.record_refusal(&format!("too many logins from {peer}"));
            AuthError::TooOften(wait)
        })
    }

    /// Runs `work` on a blocking thread, at most [`MAX_HASHES`] at a time.
    async fn run_limited<T: Send + 'static>(&self, work: impl FnOnce() -> T + Send + 'static) -> Result<T, AuthError> {
        let slot = tokio::time::timeout(HASH_TIMEOUT, Arc::clone(&self.hash_slots).acquire_owned()).await;
        let Ok(Ok(slot)) = slot else { return Err(AuthError::Busy) };
        let task = spawn_blocking(move || {
            let _slot = slot;
            work()
        });
        task.await.map_err(|_| AuthError::Defect)
    }
}

impl UserDirectory {
    fn open(file: PathBuf) -> Result<Self, UsersError> {
        let stamp = stamp(&file);
        let users = Users::read(&file)?;
        let system = |error| UsersError::System(file.clone(), error);
        let unknown = RandomSecret::new().map_err(system)?;
        let dummy = Hash::of(unknown.reveal()).map_err(|error| system(std::io::Error::other(error)))?;
        Ok(Self {
            users: RwLock::new(Arc::new(users)),
            sessions: Mutex::default(),
            dummy,
            stamp: Mutex::new(stamp),
            session_file: session_file::path(&file),
            stored: Mutex::default(),
            file,
        })
    }

    fn users(&self) -> Arc<Users> {
        Arc::clone(&self.users.read().unwrap_or_else(PoisonError::into_inner))
    }

    fn replace(&self, new: Users) -> Arc<Users> {
        std::mem::replace(&mut *self.users.write().unwrap_or_else(PoisonError::into_inner), Arc::new(new))
    }

    fn sessions(&self) -> MutexGuard<'_, Sessions> {
        self.sessions.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Stores the sessions, unless none has begun or ended and the last uses were stored less than `period` ago. Only the first of several
    /// failures is an error.
    fn store_sessions(&self, server: &str, provider: Option<&str>, period: Duration) -> std::io::Result<()> {
        // Held while the file is written: an earlier state never replaces a later one.
        let mut stored = self.stored.lock().unwrap_or_else(PoisonError::into_inner);
        let now = Instant::now();
        let since = stored.at.map(|at| now.saturating_duration_since(at));
        let (changes, sessions) = {
            let sessions = self.sessions();
            let is_changed = stored.changes != sessions.changes();
            let pause = if stored.has_failed { STORE_PAUSE.min(period) } else { Duration::ZERO };
            let is_due = if is_changed {
                since.is_none_or(|since| since >= pause)
            } else {
                since.is_some_and(|since| since >= period)
            };
            if !is_due {
                return Ok(());
            }
            (sessions.changes(), sessions.stored(&self.users(), provider, now))
        };
        let written = session_file::write(&self.session_file, server, sessions, SystemTime::now());
        let has_failed_before = stored.has_failed;
        let changes = if written.is_ok() { changes } else { stored.changes };
        *stored = StoredState { changes, at: Some(now), has_failed: written.is_err() };
        if has_failed_before { Ok(()) } else { written }
    }

    fn begin(
        &self,
        account: &Account,
        before: Option<&RandomSecret>,
    ) -> Result<(RandomSecret, AuthenticatedUser), AuthError> {
        let mut sessions = self.sessions();
        if let Some(before) = before {
            sessions.end(before);
        }
        sessions.begin(account, &self.users(), Instant::now()).map_err(AuthError::Random)
    }

    fn begin_openid(
        &self,
        identity: &Identity,
        before: Option<&RandomSecret>,
    ) -> Result<(RandomSecret, AuthenticatedUser), AuthError> {
        let (mut sessions, users, now) = (self.sessions(), self.users(), Instant::now());
        if let Some(before) = before {
            sessions.end(before);
        }
        if sessions.has_other_subject(identity, &users, now) {
            return Err(OpenIdError::SameName(Arc::clone(&identity.user.name)).into());
        }
        sessions.begin_openid(identity, &users, now).map_err(AuthError::Random)
    }
}
