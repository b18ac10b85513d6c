//! The file of the sessions, beside the users' file. It holds digests, from which neither a cookie nor a token follows.
//!
//! A file that is lost, damaged, open to others, of another version or of another server is no error: every user logs in again. Two servers
//! with one users' file replace each other's file; neither continues sessions of the other, which it may have ended since.

use super::file_permissions::{self, PermissionError};
use super::sessions::StoredSession;
use serde::{Deserialize, Serialize};
use std::fs::{self, File};
use std::io::{self, Read};
use std::path::{Path, PathBuf};
use std::time::{Duration, SystemTime};

/// The version of the format. A file of another one is not used.
const VERSION: u32 = 1;

/// The most octets: more than [`MAX_SESSIONS`](super::sessions::MAX_SESSIONS) take.
const MAX_SIZE: u64 = 4 << 20;

/// How far the clock may be behind the time of the file: a computer without a clock of its own begins with the last time that it has stored.
/// chosen.
const MAX_BEHIND: Duration = Duration::from_secs(24 * 3600);

/// The reason why the stored sessions are not used.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum SessionFileError {
    /// Others have access to the file, or it is no regular file.
    #[error(transparent)]
    Permission(#[from] PermissionError),
    /// The file cannot be read.
    #[error("{file} cannot be read: {error}", file = .0.display(), error = .1)]
    System(PathBuf, io::Error),
    /// The file is damaged, too long, or of another version.
    #[error("{} is damaged, or another version of profivac wrote it", .0.display())]
    Content(PathBuf),
    /// Another server with the same users' file has written it, or this one at another address.
    #[error("{file} is of the server at {server}: each server needs a users' file of its own", file = .0.display(), server = .1)]
    Server(PathBuf, String),
    /// The clock is more than a day behind the time of the file.
    #[error("the clock of the computer is more than a day before the time at which {} was written: set the clock", .0.display())]
    Clock(PathBuf),
}

#[derive(Debug, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct Contents {
    version: u32,
    /// The address in the settings of the server that wrote the file.
    server: String,
    /// When the file was written, in seconds since 1970.
    written_s: u64,
    sessions: Vec<StoredSession>,
}

/// The file of the sessions of the users of a file.
#[must_use]
pub fn path(users: &Path) -> PathBuf {
    let mut path = users.as_os_str().to_owned();
    path.push("-sessions");
    PathBuf::from(path)
}

/// The stored sessions of the server at this address, and the time since they were stored; `None` if there is no file.
///
/// # Errors
/// [`SessionFileError`].
pub fn read(
    file: &Path,
    server: &str,
    now: SystemTime,
) -> Result<Option<(Vec<StoredSession>, Duration)>, SessionFileError> {
    if !file.exists() {
        return Ok(None);
    }
    file_permissions::check(file)?;
    let mut octets = Vec::new();
    let read = File::open(file).and_then(|file| file.take(MAX_SIZE + 1).read_to_end(&mut octets));
    read.map_err(|error| SessionFileError::System(file.to_owned(), error))?;
    let contents = if octets.len() as u64 > MAX_SIZE { None } else { serde_json::from_slice::<Contents>(&octets).ok() };
    let contents = contents.filter(|contents| contents.version == VERSION);
    let Some(Contents { server: writer, written_s, sessions, .. }) = contents else {
        return Err(SessionFileError::Content(file.to_owned()));
    };
    if writer != server {
        return Err(SessionFileError::Server(file.to_owned(), writer));
    }
    let passed = i128::from(seconds(now)).saturating_sub(i128::from(written_s));
    if passed < -i128::from(MAX_BEHIND.as_secs()) {
        return Err(SessionFileError::Clock(file.to_owned()));
    }
    Ok(Some((sessions, Duration::from_secs(u64::try_from(passed).unwrap_or(0)))))
}

/// Writes the sessions of the server at this address. If that fails, deletes the file: one that is out of date would continue sessions that
/// have ended.
///
/// # Errors
/// The error of the operating system, and what it means for the next start.
pub fn write(file: &Path, server: &str, sessions: Vec<StoredSession>, now: SystemTime) -> io::Result<()> {
    if sessions.is_empty() {
        return remove(file).map_err(|error| with_effect(&error, &undeleted(file, &error)));
    }
    let contents = Contents { version: VERSION, server: server.to_owned(), written_s: seconds(now), sessions };
    let text = serde_json::to_string(&contents).map_err(io::Error::other)?;
    replaced_or_removed(file, file_permissions::write(file, &text))
}

fn replaced_or_removed(file: &Path, replaced: io::Result<()>) -> io::Result<()> {
    replaced.map_err(|error| match remove(file) {
        Ok(()) => with_effect(&error, "after a restart every user logs in again"),
        Err(second) => with_effect(&error, &undeleted(file, &second)),
    })
}

/// For example on a file system that the kernel has made read-only.
fn undeleted(file: &Path, error: &io::Error) -> String {
    let file = file.display();
    format!("{file} cannot be deleted ({error}): delete it, or sessions that have ended continue after a restart")
}

fn with_effect(error: &io::Error, effect: &str) -> io::Error {
    io::Error::new(error.kind(), format!("{error}; {effect}"))
}

fn remove(file: &Path) -> io::Result<()> {
    match fs::remove_file(file) {
        Err(error) if error.kind() != io::ErrorKind::NotFound => Err(error),
        _ => Ok(()),
    }
}

fn seconds(time: SystemTime) -> u64 {
    time.duration_since(SystemTime::UNIX_EPOCH).map_or(0, |time| time.as_secs())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::auth::Role;
    use crate::auth::password::Hash;
    use crate::auth::sessions::Sessions;
    use crate::auth::users::Users;
    use std::os::unix::fs::PermissionsExt;
    use std::time::Instant;

    const SERVER: &str = "127.0.0.1:8080";

    fn sessions() -> Vec<StoredSession> {
        let (mut users, now) = (Users::default(), Instant::now());
        users.add("bob", Role::Viewer, Hash::of("tin whisker plateau").unwrap()).unwrap();
        let mut sessions = Sessions::default();
        sessions.begin(users.get("bob").unwrap(), &users, now).unwrap();
        sessions.stored(&users, None, now)
    }

    #[test]
    fn stored_sessions_are_private_and_have_the_time_of_the_stop() {
        let folder = tempfile::tempdir().unwrap();
        let (file, now) = (path(&folder.path().join("users.toml")), SystemTime::now());
        assert_eq!(read(&file, SERVER, now).unwrap(), None);
        write(&file, SERVER, sessions(), now).unwrap();
        assert_eq!(fs::metadata(&file).unwrap().permissions().mode() & 0o777, 0o600);
        let hour = Duration::from_secs(3600);
        assert_eq!(
            read(&file, SERVER, now + hour).unwrap().map(|(all, stopped)| (all.len(), stopped)),
            Some((1, hour))
        );
        // A clock that is somewhat behind adds nothing; one that is days behind says nothing about the ages.
        assert_eq!(read(&file, SERVER, now - hour).unwrap().map(|(_, stopped)| stopped), Some(Duration::ZERO));
        assert!(matches!(read(&file, SERVER, now - 48 * hour), Err(SessionFileError::Clock(_))));
        assert!(matches!(read(&file, SERVER, SystemTime::UNIX_EPOCH), Err(SessionFileError::Clock(_))));
        write(&file, SERVER, Vec::new(), now).unwrap();
        assert!(!file.exists(), "without sessions there is no file");
    }

    #[test]
    fn a_damaged_or_open_file_is_not_used() {
        let folder = tempfile::tempdir().unwrap();
        let (file, now) = (path(&folder.path().join("users.toml")), SystemTime::now());
        write(&file, SERVER, sessions(), now).unwrap();
        let text = fs::read_to_string(&file).unwrap();
        let long = " ".repeat(usize::try_from(MAX_SIZE).unwrap()) + &text;
        for wrong in ["", &text[..text.len() / 2], &text.replace("\"version\":1", "\"version\":2"), &long] {
            file_permissions::write(&file, wrong).unwrap();
            assert!(matches!(read(&file, SERVER, now), Err(SessionFileError::Content(_))), "{}", wrong.len());
        }
        file_permissions::write(&file, &text).unwrap();
        assert!(read(&file, SERVER, now).is_ok());
        fs::set_permissions(&file, fs::Permissions::from_mode(0o640)).unwrap();
        assert!(matches!(read(&file, SERVER, now), Err(SessionFileError::Permission(_))));
    }

    #[test]
    fn a_server_continues_no_sessions_of_another_one_with_the_same_users() {
        let folder = tempfile::tempdir().unwrap();
        let (file, now) = (path(&folder.path().join("users.toml")), SystemTime::now());
        write(&file, "127.0.0.1:9090", sessions(), now).unwrap();
        let error = read(&file, SERVER, now).unwrap_err();
        assert!(matches!(&error, SessionFileError::Server(_, other) if other == "127.0.0.1:9090"), "{error}");
        write(&file, SERVER, sessions(), now).unwrap();
        assert!(read(&file, SERVER, now).is_ok() && read(&file, "127.0.0.1:9090", now).is_err());
    }

    #[test]
    fn a_file_that_cannot_be_replaced_is_deleted() {
        let folder = tempfile::tempdir().unwrap();
        let (file, now) = (path(&folder.path().join("users.toml")), SystemTime::now());
        write(&file, SERVER, sessions(), now).unwrap();
        let full = io::Error::from(io::ErrorKind::StorageFull);
        assert!(replaced_or_removed(&file, Err(full)).is_err() && !file.exists());
        let none = folder.path().join("none").join("users.toml-sessions");
        let error = write(&none, SERVER, sessions(), now).unwrap_err().to_string();
        assert!(error.ends_with("; after a restart every user logs in again") && !none.exists(), "{error}");
    }

    #[test]
    fn a_file_that_can_neither_be_replaced_nor_deleted_is_named() {
        let folder = tempfile::tempdir().unwrap();
        let (file, now) = (path(&folder.path().join("users.toml")), SystemTime::now());
        // A folder can be neither.
        fs::create_dir(&file).unwrap();
        for sessions in [sessions(), Vec::new()] {
            let error = write(&file, SERVER, sessions, now).unwrap_err().to_string();
            let advice = format!("{} cannot be deleted (", file.display());
            assert!(error.contains(&advice) && error.ends_with("continue after a restart"), "{error}");
        }
    }
}
