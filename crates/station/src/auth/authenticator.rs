//! The door: who comes in, and what the record says about it.

use super::access::Access;
use super::password::{self, Hash, PasswordError};
use super::rate_limit::{RateLimiters, RateLimits};
use super::secret::Secret;
use super::sessions::{AuthenticatedUser, Sessions};
use super::users::{Account, Users, UsersError};
use crate::control::{self, ReleaseReason};
use crate::services::Services;
use governor::clock::DefaultClock;
use profivac_recorder::EventKind;
use std::fs;
use std::net::IpAddr;
use std::os::unix::fs::MetadataExt;
use std::path::PathBuf;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError, RwLock};
use std::time::{Duration, Instant};
use tokio::sync::Semaphore;
use tokio::task::spawn_blocking;

/// So many passwords are tried at once: each takes a processor and 19 MiB for some ten milliseconds. free choice.
const TRIED: usize = 2;

/// Others wait so long for their turn.
const TURN: Duration = Duration::from_secs(10);

/// Why somebody is not let in.
#[derive(Debug, PartialEq, Eq, thiserror::Error)]
pub enum AuthError {
    /// Nobody logs in here.
    #[error("nobody logs in here: the station has no users")]
    NoUsers,
    /// Name or password; which of them is not told.
    #[error("this name and this password do not belong together")]
    Wrong,
    /// The password that is to be replaced.
    #[error("this is not your password")]
    NotYours,
    /// Too often.
    #[error("too many tries: wait")]
    TooOften(Duration),
    /// Too many at once.
    #[error("too many log in at once: try again")]
    Busy,
    /// A new password that will not do.
    #[error(transparent)]
    Unfit(#[from] PasswordError),
    /// The system, or the users' file.
    #[error("the station cannot do this: {0}")]
    System(String),
}

/// Which contents of a file were read: they have changed when one of these has.
type Stamp = (u64, i64, i64, u64);

/// Those who may log in, and those who have.
struct UserDirectory {
    file: PathBuf,
    users: RwLock<Arc<Users>>,
    sessions: Mutex<Sessions>,
    /// What is tried under a name that nobody has, so that it takes as long.
    nobody: Hash,
    read: Mutex<Option<Stamp>>,
}

/// How one comes in.
enum AuthMode {
    /// Everybody is this one; their pages prove with this token that they are ours.
    Anonymous(AuthenticatedUser),
    /// By name and password.
    Users(UserDirectory),
}

/// The door of a station.
pub struct Authenticator {
    plant: Arc<Services>,
    way: AuthMode,
    rates: RateLimiters<DefaultClock>,
    turns: Arc<Semaphore>,
}

impl Authenticator {
    /// The door of a plant.
    ///
    /// # Errors
    /// [`UsersError`] when there are no users to be had from their file.
    pub fn new(plant: Arc<Services>, access: Access, paces: RateLimits) -> Result<Self, UsersError> {
        let way = match access {
            Access::Anonymous(person) => {
                let token = Secret::new().map_err(|error| UsersError::System(PathBuf::from("/dev/urandom"), error))?;
                AuthMode::Anonymous(AuthenticatedUser { user: person, token })
            }
            Access::Users(file) => AuthMode::Users(UserDirectory::open(file)?),
        };
        Ok(Self {
            plant,
            way,
            rates: RateLimiters::new(paces, DefaultClock::default()),
            turns: Arc::new(Semaphore::new(TRIED)),
        })
    }

    /// Whether people log in.
    #[must_use]
    pub const fn requires_login(&self) -> bool {
        matches!(self.way, AuthMode::Users(_))
    }

    /// Whether anybody can log in.
    #[must_use]
    pub fn has_users(&self) -> bool {
        matches!(&self.way, AuthMode::Users(book) if !book.users().is_empty())
    }

    /// How often what may be asked.
    pub const fn rates(&self) -> &RateLimiters<DefaultClock> {
        &self.rates
    }

    /// Who comes with this name of a session.
    pub fn authenticate(&self, session: Option<&Secret>) -> Option<AuthenticatedUser> {
        match &self.way {
            AuthMode::Anonymous(everybody) => Some(everybody.clone()),
            AuthMode::Users(book) => book.sessions().resume(session?, &book.users(), Instant::now()),
        }
    }

    /// Begins a session for whoever knows this name and its password; the one they had before ends.
    ///
    /// # Errors
    /// [`Refusal`].
    pub async fn login(
        &self,
        name: &str,
        password: String,
        before: Option<&Secret>,
        peer: IpAddr,
    ) -> Result<(Secret, AuthenticatedUser), AuthError> {
        let AuthMode::Users(book) = &self.way else { return Err(AuthError::NoUsers) };
        self.check_login_rate(peer, name)?;
        let user = book.users().get(name).cloned();
        let hash = user.as_ref().map_or(&book.nobody, |user| &user.password).clone();
        let right = self.run_limited(move || hash.matches(&password)).await?;
        // What somebody typed for a name may be a password: only names that exist are written down.
        let Some(user) = user else {
            self.record_refusal(&format!("somebody at {peer} tried to log in under a name that there is not"));
            return Err(AuthError::Wrong);
        };
        if !right {
            self.record_refusal(&format!("{} was not logged in from {peer}: wrong password", user.name));
            return Err(AuthError::Wrong);
        }
        let begun = book.begin(&user, before)?;
        self.rates.remember_login(peer, name);
        self.release_control_if_gone(book);
        self.record_event(&format!("{} ({}) logged in from {peer}", user.name, user.role));
        Ok(begun)
    }

    /// Gives somebody who knows their password a new one. All their sessions end, and this one begins anew.
    ///
    /// # Errors
    /// [`Refusal`].
    pub async fn change_password(
        &self,
        name: &str,
        (current, new): (String, String),
        before: Option<&Secret>,
        peer: IpAddr,
    ) -> Result<(Secret, AuthenticatedUser), AuthError> {
        let AuthMode::Users(book) = &self.way else { return Err(AuthError::NoUsers) };
        self.check_login_rate(peer, name)?;
        let old = book.users().get(name).cloned().ok_or(AuthError::Wrong)?;
        let hash = old.password.clone();
        if !self.run_limited(move || hash.matches(&current)).await? {
            self.record_refusal(&format!("{name} did not get a new password from {peer}: wrong password"));
            return Err(AuthError::NotYours);
        }
        let owner = name.to_owned();
        let password = self.run_limited(move || password::check(&new, &owner).and_then(|()| Hash::of(&new))).await??;
        let (file, changed) = (book.file.clone(), Account { password, ..old });
        let written = changed.clone();
        let write = move || {
            let user =
                |users: &mut Users| users.get_mut(&written.name).map(|user| user.password = written.password.clone());
            Users::change(&file, user).map_err(|error| AuthError::System(error.to_string()))
        };
        self.run_limited(write).await??;
        self.reload_users();
        let begun = book.begin(&changed, before);
        self.release_control_if_gone(book);
        begun
    }

    /// Ends a session.
    pub fn logout(&self, session: Option<&Secret>, peer: IpAddr) {
        if let (AuthMode::Users(book), Some(id)) = (&self.way, session) {
            let known = self.authenticate(session);
            book.sessions().end(id);
            if let Some(AuthenticatedUser { user: person, .. }) = known {
                self.record_event(&format!("{} logged out from {peer}", person.name));
            }
            self.release_control_if_gone(book);
        }
    }

    /// Reads the users again if their file has changed, and sees who is here no more. To be called every now and then.
    pub fn reload_users(&self) {
        let AuthMode::Users(book) = &self.way else { return };
        self.read_users_if_changed(book);
        self.release_control_if_gone(book);
    }

    /// Who has no session any more, or has another role, has the mastership no more, and nothing armed.
    fn release_control_if_gone(&self, book: &UserDirectory) {
        let Some(holder) = control::holder(&self.plant) else { return };
        let users = book.users();
        let why = match users.get(&holder.name) {
            Some(user) if user.role != holder.role => ReleaseReason::RoleChanged,
            Some(_) if book.sessions().has_session(&holder.name, &users, Instant::now()) => return,
            _ => ReleaseReason::SessionEnded,
        };
        control::release_user(&self.plant, &holder.name, why);
    }

    fn read_users_if_changed(&self, book: &UserDirectory) {
        let stamp = stamp(&book.file);
        let mut read = book.read.lock().unwrap_or_else(PoisonError::into_inner);
        if *read == stamp {
            return;
        }
        *read = stamp;
        match Users::read(&book.file) {
            Ok(new) => {
                let old = book.replace(new.clone());
                old.differences(&new).iter().for_each(|change| self.record_event(&change.to_string()));
            }
            // What is wrong may be a password: only where it stands is written down.
            Err(UsersError::File(error)) => {
                let place = (error.line, error.column);
                self.record_event(&format!(
                    "the users stay as they were: line {}, column {} of their file is wrong",
                    place.0, place.1
                ));
            }
            Err(error) => self.record_event(&format!("the users stay as they were: {error}")),
        }
    }

    /// Something was refused: it goes into the record, unless too much does.
    pub fn record_refusal(&self, sentence: &str) {
        if self.rates.may_log() {
            self.record_event(sentence);
        }
    }

    fn record_event(&self, sentence: &str) {
        self.plant.record_event(None, EventKind::Access, sentence);
    }

    fn check_login_rate(&self, peer: IpAddr, name: &str) -> Result<(), AuthError> {
        self.rates.login(peer, name).map_err(|wait| {
            self.record_refusal(&format!("too many logins from {peer}"));
            AuthError::TooOften(wait)
        })
    }

    /// Does what takes a processor for a while, when it is its turn, where nobody waits for it.
    async fn run_limited<T: Send + 'static>(&self, work: impl FnOnce() -> T + Send + 'static) -> Result<T, AuthError> {
        let turn = tokio::time::timeout(TURN, Arc::clone(&self.turns).acquire_owned()).await;
        let Ok(Ok(turn)) = turn else { return Err(AuthError::Busy) };
        let worked = spawn_blocking(move || {
            let _turn = turn;
            work()
        });
        worked.await.map_err(|_| AuthError::Busy)
    }
}

impl UserDirectory {
    fn open(file: PathBuf) -> Result<Self, UsersError> {
        let read = stamp(&file);
        let users = Users::read(&file)?;
        let system = |error| UsersError::System(file.clone(), error);
        let nobody = Secret::new().map_err(system)?;
        let nobody = Hash::of(nobody.reveal()).map_err(|error| system(std::io::Error::other(error)))?;
        Ok(Self {
            users: RwLock::new(Arc::new(users)),
            sessions: Mutex::default(),
            nobody,
            read: Mutex::new(read),
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

    fn begin(&self, user: &Account, before: Option<&Secret>) -> Result<(Secret, AuthenticatedUser), AuthError> {
        let mut sessions = self.sessions();
        if let Some(before) = before {
            sessions.end(before);
        }
        sessions.begin(user, &self.users(), Instant::now()).map_err(|error| AuthError::System(error.to_string()))
    }
}

/// Nothing, if there is no such file.
fn stamp(file: &PathBuf) -> Option<Stamp> {
    let seen = fs::metadata(file).ok()?;
    Some((seen.ino(), seen.ctime(), seen.ctime_nsec(), seen.size()))
}
