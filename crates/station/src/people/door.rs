//! The door: who comes in, and what the record says about it.

use super::access::Access;
use super::password::{self, Hash, Unfit};
use super::rates::{Paces, Rates};
use super::secret::Secret;
use super::sessions::{Known, Sessions};
use super::users::{User, Users, UsersError};
use crate::act::{self, Leave};
use crate::plant::Plant;
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
pub enum Refusal {
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
    Often(Duration),
    /// Too many at once.
    #[error("too many log in at once: try again")]
    Busy,
    /// A new password that will not do.
    #[error(transparent)]
    Unfit(#[from] Unfit),
    /// The system, or the users' file.
    #[error("the station cannot do this: {0}")]
    System(String),
}

/// Which contents of a file were read: they have changed when one of these has.
type Stamp = (u64, i64, i64, u64);

/// Those who may log in, and those who have.
struct Book {
    file: PathBuf,
    users: RwLock<Arc<Users>>,
    sessions: Mutex<Sessions>,
    /// What is tried under a name that nobody has, so that it takes as long.
    nobody: Hash,
    read: Mutex<Option<Stamp>>,
}

/// How one comes in.
enum Way {
    /// Everybody is this one; their pages prove with this token that they are ours.
    Open(Known),
    /// By name and password.
    Book(Book),
}

/// The door of a station.
pub struct Door {
    plant: Arc<Plant>,
    way: Way,
    rates: Rates<DefaultClock>,
    turns: Arc<Semaphore>,
}

impl Door {
    /// The door of a plant.
    ///
    /// # Errors
    /// [`UsersError`] when there are no users to be had from their file.
    pub fn new(plant: Arc<Plant>, access: Access, paces: Paces) -> Result<Self, UsersError> {
        let way = match access {
            Access::Everybody(person) => {
                let token = Secret::new().map_err(|error| UsersError::System(PathBuf::from("/dev/urandom"), error))?;
                Way::Open(Known { person, token })
            }
            Access::Users(file) => Way::Book(Book::open(file)?),
        };
        Ok(Self {
            plant,
            way,
            rates: Rates::new(paces, DefaultClock::default()),
            turns: Arc::new(Semaphore::new(TRIED)),
        })
    }

    /// Whether people log in.
    #[must_use]
    pub const fn has_lock(&self) -> bool {
        matches!(self.way, Way::Book(_))
    }

    /// Whether anybody can log in.
    #[must_use]
    pub fn has_users(&self) -> bool {
        matches!(&self.way, Way::Book(book) if !book.users().is_empty())
    }

    /// How often what may be asked.
    pub const fn rates(&self) -> &Rates<DefaultClock> {
        &self.rates
    }

    /// Who comes with this name of a session.
    pub fn visit(&self, session: Option<&Secret>) -> Option<Known> {
        match &self.way {
            Way::Open(everybody) => Some(everybody.clone()),
            Way::Book(book) => book.sessions().visit(session?, &book.users(), Instant::now()),
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
    ) -> Result<(Secret, Known), Refusal> {
        let Way::Book(book) = &self.way else { return Err(Refusal::NoUsers) };
        self.may_try(peer, name)?;
        let user = book.users().get(name).cloned();
        let hash = user.as_ref().map_or(&book.nobody, |user| &user.password).clone();
        let right = self.tried(move || hash.is(&password)).await?;
        // What somebody typed for a name may be a password: only names that exist are written down.
        let Some(user) = user else {
            self.refused(&format!("somebody at {peer} tried to log in under a name that there is not"));
            return Err(Refusal::Wrong);
        };
        if !right {
            self.refused(&format!("{} was not logged in from {peer}: wrong password", user.name));
            return Err(Refusal::Wrong);
        }
        let begun = book.begin(&user, before)?;
        self.rates.welcome(peer, name);
        self.settle(book);
        self.write_down(&format!("{} ({}) logged in from {peer}", user.name, user.role));
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
    ) -> Result<(Secret, Known), Refusal> {
        let Way::Book(book) = &self.way else { return Err(Refusal::NoUsers) };
        self.may_try(peer, name)?;
        let old = book.users().get(name).cloned().ok_or(Refusal::Wrong)?;
        let hash = old.password.clone();
        if !self.tried(move || hash.is(&current)).await? {
            self.refused(&format!("{name} did not get a new password from {peer}: wrong password"));
            return Err(Refusal::NotYours);
        }
        let owner = name.to_owned();
        let password = self.tried(move || password::check(&new, &owner).and_then(|()| Hash::of(&new))).await??;
        let (file, changed) = (book.file.clone(), User { password, ..old });
        let written = changed.clone();
        let write = move || {
            let user =
                |users: &mut Users| users.get_mut(&written.name).map(|user| user.password = written.password.clone());
            Users::change(&file, user).map_err(|error| Refusal::System(error.to_string()))
        };
        self.tried(write).await??;
        self.look_again();
        let begun = book.begin(&changed, before);
        self.settle(book);
        begun
    }

    /// Ends a session.
    pub fn logout(&self, session: Option<&Secret>, peer: IpAddr) {
        if let (Way::Book(book), Some(id)) = (&self.way, session) {
            let known = self.visit(session);
            book.sessions().end(id);
            if let Some(Known { person, .. }) = known {
                self.write_down(&format!("{} logged out from {peer}", person.name));
            }
            self.settle(book);
        }
    }

    /// Reads the users again if their file has changed, and sees who is here no more. To be called every now and then.
    pub fn look_again(&self) {
        let Way::Book(book) = &self.way else { return };
        self.read_again(book);
        self.settle(book);
    }

    /// Who has no session any more, or has another role, has the mastership no more, and nothing armed.
    fn settle(&self, book: &Book) {
        let Some(holder) = act::holder(&self.plant) else { return };
        let users = book.users();
        let why = match users.get(&holder.name) {
            Some(user) if user.role != holder.role => Leave::Role,
            Some(_) if book.sessions().is_here(&holder.name, &users, Instant::now()) => return,
            _ => Leave::Gone,
        };
        act::gone(&self.plant, &holder.name, why);
    }

    fn read_again(&self, book: &Book) {
        let stamp = stamp(&book.file);
        let mut read = book.read.lock().unwrap_or_else(PoisonError::into_inner);
        if *read == stamp {
            return;
        }
        *read = stamp;
        match Users::read(&book.file) {
            Ok(new) => {
                let old = book.replace(new.clone());
                old.differences(&new).iter().for_each(|sentence| self.write_down(sentence));
            }
            // What is wrong may be a password: only where it stands is written down.
            Err(UsersError::File(error)) => {
                let place = (error.line, error.column);
                self.write_down(&format!(
                    "the users stay as they were: line {}, column {} of their file is wrong",
                    place.0, place.1
                ));
            }
            Err(error) => self.write_down(&format!("the users stay as they were: {error}")),
        }
    }

    /// Something was refused: it goes into the record, unless too much does.
    pub fn refused(&self, sentence: &str) {
        if self.rates.line() {
            self.write_down(sentence);
        }
    }

    fn write_down(&self, sentence: &str) {
        self.plant.remark(None, EventKind::Access, sentence);
    }

    fn may_try(&self, peer: IpAddr, name: &str) -> Result<(), Refusal> {
        self.rates.login(peer, name).map_err(|wait| {
            self.refused(&format!("too many logins from {peer}"));
            Refusal::Often(wait)
        })
    }

    /// Does what takes a processor for a while, when it is its turn, where nobody waits for it.
    async fn tried<T: Send + 'static>(&self, work: impl FnOnce() -> T + Send + 'static) -> Result<T, Refusal> {
        let turn = tokio::time::timeout(TURN, Arc::clone(&self.turns).acquire_owned()).await;
        let Ok(Ok(turn)) = turn else { return Err(Refusal::Busy) };
        let worked = spawn_blocking(move || {
            let _turn = turn;
            work()
        });
        worked.await.map_err(|_| Refusal::Busy)
    }
}

impl Book {
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

    fn begin(&self, user: &User, before: Option<&Secret>) -> Result<(Secret, Known), Refusal> {
        let mut sessions = self.sessions();
        if let Some(before) = before {
            sessions.end(before);
        }
        sessions.begin(user, &self.users(), Instant::now()).map_err(|error| Refusal::System(error.to_string()))
    }
}

/// Nothing, if there is no such file.
fn stamp(file: &PathBuf) -> Option<Stamp> {
    let seen = fs::metadata(file).ok()?;
    Some((seen.ino(), seen.ctime(), seen.ctime_nsec(), seen.size()))
}
