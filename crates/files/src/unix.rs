//! The functions on Unix.

use super::Stamp;
use rustix::fs::{Access, access, statvfs};
use std::fs::{self, File, Metadata, OpenOptions, Permissions};
use std::io;
use std::os::unix::fs::{FileExt as _, MetadataExt as _, OpenOptionsExt as _, PermissionsExt as _, fchown};
use std::path::Path;
use std::time::Duration;

/// Device and inode.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct FileIdentity(u64, u64);

/// The modes of a file and of a folder for their owner alone.
const OWNER: u32 = 0o600;
const OWNER_OF_FOLDER: u32 = 0o700;

/// The mode bits of the group and of others.
const OTHERS: u32 = 0o077;

/// Opens a file; one that is created gets access for its owner alone.
///
/// # Errors
/// Of the operating system.
pub fn open_private(options: &OpenOptions, file: &Path) -> io::Result<File> {
    options.clone().mode(OWNER).open(file)
}

/// Takes the access of others to an existing file away.
///
/// # Errors
/// Of the operating system.
pub fn make_private(file: &Path) -> io::Result<()> {
    fs::set_permissions(file, Permissions::from_mode(OWNER))
}

/// Takes the access of others to an existing folder away.
///
/// # Errors
/// Of the operating system.
pub fn make_folder_private(folder: &Path) -> io::Result<()> {
    fs::set_permissions(folder, Permissions::from_mode(OWNER_OF_FOLDER))
}

/// The mode of a file to which the group or others have access; `None` for one that its owner has alone.
///
/// # Errors
/// Of the operating system.
pub fn access_of_others(file: &Path) -> io::Result<Option<u32>> {
    let mode = fs::metadata(file)?.permissions().mode() & 0o7777;
    Ok((mode & OTHERS != 0).then_some(mode))
}

/// Which file a name stands for; `None` if there is none.
#[must_use]
pub fn identity(file: &Path) -> Option<FileIdentity> {
    fs::metadata(file).ok().map(|file| FileIdentity(file.dev(), file.ino()))
}

/// What changes with the contents of a file; `None` if there is none.
#[must_use]
pub fn stamp(file: &Path) -> Option<Stamp> {
    let metadata = fs::metadata(file).ok()?;
    let changed = u64::try_from(metadata.ctime()).ok().zip(u32::try_from(metadata.ctime_nsec()).ok());
    Some(Stamp {
        file: Some(FileIdentity(metadata.dev(), metadata.ino())),
        changed: changed.map(|(seconds, nanoseconds)| Duration::new(seconds, nanoseconds)),
        size: metadata.size(),
    })
}

/// Gives a new file the owner, the group and the mode of the file that it replaces.
///
/// # Errors
/// Of the operating system.
pub fn keep_owner(new: &File, before: &Metadata) -> io::Result<()> {
    let created = new.metadata()?;
    if (created.uid(), created.gid()) != (before.uid(), before.gid()) {
        fchown(new, Some(before.uid()), Some(before.gid()))?;
    }
    new.set_permissions(before.permissions())
}

/// Makes a file, or the names in a folder, durable.
///
/// # Errors
/// Of the operating system.
pub fn synchronise(path: &Path) -> io::Result<()> {
    File::open(path)?.sync_all()
}

/// The octets that are free for this user on the disk of a path; `None` if the disk does not say.
#[must_use]
pub fn free_octets(path: &Path) -> Option<u64> {
    let disk = statvfs(path).ok()?;
    Some(disk.f_bavail.saturating_mul(disk.f_frsize))
}

/// Whether this user may make files in a folder.
#[must_use]
pub fn is_folder_writable(folder: &Path) -> bool {
    access(folder, Access::WRITE_OK | Access::EXEC_OK).is_ok()
}

/// Reads all of `octets` at a position, without moving the position of the file.
///
/// # Errors
/// Of the operating system, or the end of the file.
pub fn read_exact_at(file: &File, octets: &mut [u8], at: u64) -> io::Result<()> {
    file.read_exact_at(octets, at)
}
