//! A consistent copy of a database while a recorder writes to it.
//!
//! The copy is one read transaction: it contains everything that was committed before it began, and nothing later. The recorder is not
//! delayed; its log grows until the copy ends. The copy is written beside its destination, checked, made durable and then renamed, so
//! that the destination is either absent, the file that was there before, or whole.

use super::error::DatabaseError;
use super::outbox::begin_epoch;
use super::reader::Reader;
use profivac_files::{free_octets, open_private, synchronise};
use rusqlite::Connection;
use rusqlite::backup::{Backup, StepResult};
use std::fs::{self, OpenOptions};
use std::io;
use std::path::{Path, PathBuf};
use std::time::Duration;

/// Pages that are copied between two reports of progress: 1 MiB.
const PAGES_PER_STEP: i32 = 256;

/// The pause after a step for which the source was locked. In its log mode readers are not locked out, so this is rare.
const LOCKED_PAUSE: Duration = Duration::from_millis(50);

/// The most pauses one after the other.
const MAX_PAUSES: u32 = 200;

/// Room that a copy leaves on its disk: the database may be on the same one, and its log grows until the copy ends. chosen
const RESERVE: u64 = 64 << 20;

/// What to do with a file that exists at the destination.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Existing {
    /// It stays, and the copy fails.
    Keep,
    /// The copy takes its place when it is whole.
    Replace,
}

/// The reason why no copy was made.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum BackupError {
    /// The database cannot be read, or the copy is not whole.
    #[error(transparent)]
    Database(#[from] DatabaseError),
    /// The destination exists.
    #[error("{path} exists", path = .0.display())]
    Exists(PathBuf),
    /// The destination is the database itself.
    #[error("{path} is the database itself", path = .0.display())]
    Itself(PathBuf),
    /// The copy cannot be written.
    #[error("{path}: {error}", path = path.display())]
    File {
        /// The copy.
        path: PathBuf,
        /// The error of the system.
        error: io::Error,
    },
    /// The disk has no room for the copy.
    #[error("{path}: expected room for {needed} octets on the disk, found {free}", path = path.display())]
    NoRoom {
        /// The copy.
        path: PathBuf,
        /// The size of the copy with the room that it leaves.
        needed: u64,
        /// The free octets.
        free: u64,
    },
    /// The database stayed locked.
    #[error("{path} is locked by another program", path = .0.display())]
    Locked(PathBuf),
    /// The copy fails the check of SQLite.
    #[error("the copy of {path} is damaged: {found}", path = path.display())]
    Damaged {
        /// The database.
        path: PathBuf,
        /// What SQLite found.
        found: String,
    },
}

impl Reader {
    /// Copies the database to a file. `progress` gets the copied octets and all octets.
    ///
    /// # Errors
    /// [`BackupError`]; the destination is then as it was before.
    pub fn backup(&self, to: &Path, existing: Existing, progress: impl FnMut(u64, u64)) -> Result<(), BackupError> {
        self.backup_with(to, existing, free_octets, progress)
    }

    /// The same for a disk that has the free octets that `free` says.
    fn backup_with(
        &self,
        to: &Path,
        existing: Existing,
        free: impl FnOnce(&Path) -> Option<u64>,
        progress: impl FnMut(u64, u64),
    ) -> Result<(), BackupError> {
        let failed = |error| BackupError::File { path: to.to_owned(), error };
        if is_same(self.path(), to) {
            return Err(BackupError::Itself(to.to_owned()));
        }
        if existing == Existing::Keep && fs::symlink_metadata(to).is_ok() {
            return Err(BackupError::Exists(to.to_owned()));
        }
        let part = part_of(to).map_err(failed)?;
        let made = self.copy_and_check(&part, free, progress).and_then(|()| put(&part, to, existing));
        if made.is_err() {
            remove(&part);
        }
        made
    }

    /// Writes the copy, checks it, and makes it durable.
    fn copy_and_check(
        &self,
        part: &Path,
        free: impl FnOnce(&Path) -> Option<u64>,
        progress: impl FnMut(u64, u64),
    ) -> Result<(), BackupError> {
        let sql = |error| DatabaseError::Sql { path: self.path().to_owned(), error };
        let failed = |error| BackupError::File { path: part.to_owned(), error };
        open_private(OpenOptions::new().write(true).create(true).truncate(true), part).map_err(failed)?;
        let mut copy = Connection::open(part).map_err(sql)?;
        self.copy(&mut copy, part, free, progress)?;
        let found: String = copy.query_row("PRAGMA quick_check(1)", [], |row| row.get(0)).map_err(sql)?;
        if found != "ok" {
            return Err(BackupError::Damaged { path: self.path().to_owned(), found });
        }
        begin_epoch(&copy).map_err(sql)?;
        // One file: without its log the copy can be moved and sent.
        copy.pragma_update(None, "journal_mode", "DELETE").map_err(sql)?;
        copy.close().map_err(|(_, error)| sql(error))?;
        synchronise(part).map_err(failed)
    }

    fn copy(
        &self,
        copy: &mut Connection,
        part: &Path,
        free: impl FnOnce(&Path) -> Option<u64>,
        mut progress: impl FnMut(u64, u64),
    ) -> Result<(), BackupError> {
        let sql = |error| DatabaseError::Sql { path: self.path().to_owned(), error };
        // A read transaction that lasts for the whole copy. Without it each commit of the recorder would start the copy again.
        let transaction = self.connection().unchecked_transaction().map_err(sql)?;
        let octets: i64 = transaction.query_row("PRAGMA page_size", [], |row| row.get(0)).map_err(sql)?;
        let _started: i64 =
            transaction.query_row("SELECT count(*) FROM sqlite_schema", [], |row| row.get(0)).map_err(sql)?;
        let of_pages = |pages: i32| u64::try_from(i64::from(pages).saturating_mul(octets)).unwrap_or(0);
        let pages: i32 = transaction.query_row("PRAGMA page_count", [], |row| row.get(0)).map_err(sql)?;
        let needed = of_pages(pages).saturating_add(RESERVE);
        // A disk that does not say how much it has is tried.
        if let Some(free) = free(part).filter(|free| *free < needed) {
            return Err(BackupError::NoRoom { path: part.to_owned(), needed, free });
        }
        let backup = Backup::new(&transaction, copy).map_err(sql)?;
        let mut pauses: u32 = 0;
        loop {
            let step = backup.step(PAGES_PER_STEP).map_err(sql)?;
            let state = backup.progress();
            progress(of_pages(state.pagecount.saturating_sub(state.remaining)), of_pages(state.pagecount));
            match step {
                StepResult::Done => return Ok(()),
                StepResult::More => pauses = 0,
                _ if pauses < MAX_PAUSES => {
                    pauses = pauses.saturating_add(1);
                    std::thread::sleep(LOCKED_PAUSE);
                }
                _ => return Err(BackupError::Locked(self.path().to_owned())),
            }
        }
    }
}

/// Whether both paths name one file.
fn is_same(one: &Path, other: &Path) -> bool {
    matches!((one.canonicalize(), other.canonicalize()), (Ok(one), Ok(other)) if one == other)
}

/// The name of a copy that is not whole yet: that of the destination with `.part`, in the same folder.
fn part_of(to: &Path) -> io::Result<PathBuf> {
    let name = to.file_name().ok_or(io::ErrorKind::IsADirectory)?;
    let mut name = name.to_owned();
    name.push(".part");
    Ok(to.with_file_name(name))
}

/// Removes a copy that is not whole, and the log of SQLite beside it. If that fails too, the first error is the one to report.
fn remove(part: &Path) {
    for end in ["", "-wal", "-shm", "-journal"] {
        let mut name = part.as_os_str().to_owned();
        name.push(end);
        let _gone = fs::remove_file(name);
    }
}

/// Gives the copy its name, and makes the name durable.
fn put(part: &Path, to: &Path, existing: Existing) -> Result<(), BackupError> {
    let failed = |error| BackupError::File { path: to.to_owned(), error };
    match existing {
        Existing::Replace => fs::rename(part, to).map_err(failed)?,
        // A link is made only if the name is free, also if another program has taken it meanwhile.
        Existing::Keep => match fs::hard_link(part, to) {
            Ok(()) => fs::remove_file(part).map_err(failed)?,
            Err(error) if error.kind() == io::ErrorKind::AlreadyExists => {
                return Err(BackupError::Exists(to.to_owned()));
            }
            // A file system without hard links.
            Err(_) => fs::rename(part, to).map_err(failed)?,
        },
    }
    let folder = to.parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new("."));
    synchronise(folder).map_err(failed)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Recorder, Settings};

    #[test]
    fn a_copy_for_which_the_disk_has_no_room_is_refused_and_leaves_the_file_before() {
        let folder = tempfile::tempdir().unwrap();
        let database = folder.path().join("plant.db");
        let to = folder.path().join("copy.db");
        let part = folder.path().join("copy.db.part");
        let recorder = Recorder::start(&database, Settings::default()).unwrap();
        assert!(recorder.flush());
        fs::write(&to, "the copy of yesterday").unwrap();
        let reader = Reader::open(&database).unwrap();
        let on_disk_with = |octets| reader.backup_with(&to, Existing::Replace, |_| Some(octets), |_, _| ());
        let Err(BackupError::NoRoom { needed, .. }) = on_disk_with(0) else { panic!("a full disk takes no copy") };
        assert!(needed > RESERVE, "{needed}");
        let refused = on_disk_with(needed - 1).unwrap_err();
        assert_eq!(
            refused.to_string(),
            format!("{}: expected room for {needed} octets on the disk, found {}", part.display(), needed - 1)
        );
        assert_eq!(fs::read(&to).unwrap(), b"the copy of yesterday");
        assert!(!part.exists(), "what was begun is removed");
        on_disk_with(needed).unwrap();
        assert_eq!(fs::read(&to).unwrap().get(..6), Some(b"SQLite".as_slice()));
        reader.backup_with(&to, Existing::Replace, |_| None, |_, _| ()).unwrap();
    }
}
