//! The functions on Windows.

use super::Stamp;
use std::fs::{self, File, Metadata, OpenOptions};
use std::io;
use std::os::windows::fs::FileExt as _;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::time::UNIX_EPOCH;

/// Volume and number of a file.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct FileIdentity(file_id::FileId);

/// Who keeps full access to a private file: its owner, the system, the administrators. Well-known identifiers, the same in each language
/// of Windows. Microsoft, "Well-known SIDs".
const KEEPERS: [&str; 3] = ["*S-1-3-4:F", "*S-1-5-18:F", "*S-1-5-32-544:F"];

/// The same for a folder and what is made in it.
const KEEPERS_OF_FOLDER: [&str; 3] = ["*S-1-3-4:(OI)(CI)F", "*S-1-5-18:(OI)(CI)F", "*S-1-5-32-544:(OI)(CI)F"];

/// Opens a file; one that is created gets access for its owner alone.
///
/// # Errors
/// Of the operating system.
pub fn open_private(options: &OpenOptions, file: &Path) -> io::Result<File> {
    let is_new = !file.exists();
    let opened = options.open(file)?;
    if is_new {
        make_private(file)?;
    }
    Ok(opened)
}

/// Takes the access of others to an existing file away.
///
/// # Errors
/// Of the operating system.
pub fn make_private(file: &Path) -> io::Result<()> {
    grant_alone(file, &KEEPERS)
}

/// Takes the access of others to an existing folder away.
///
/// # Errors
/// Of the operating system.
pub fn make_folder_private(folder: &Path) -> io::Result<()> {
    grant_alone(folder, &KEEPERS_OF_FOLDER)
}

/// Replaces the access list of a path. The system call needs `unsafe`, so the program `icacls` of Windows makes it.
fn grant_alone(path: &Path, keepers: &[&str]) -> io::Result<()> {
    let system = std::env::var_os("SystemRoot").map_or_else(|| PathBuf::from(r"C:\Windows"), PathBuf::from);
    let mut icacls = Command::new(system.join("System32").join("icacls.exe"));
    icacls.arg(path).args(["/inheritance:r", "/grant:r"]).args(keepers);
    let done = icacls.stdin(Stdio::null()).stdout(Stdio::null()).stderr(Stdio::null()).status()?;
    match done.success() {
        true => Ok(()),
        false => Err(io::Error::other(format!("icacls could not protect it from other users ({done})"))),
    }
}

/// Always `None`: the access lists of files that others have made are not examined.
///
/// # Errors
/// Of the operating system.
pub fn access_of_others(file: &Path) -> io::Result<Option<u32>> {
    fs::metadata(file).map(|_| None)
}

/// Which file a name stands for; `None` if there is none.
#[must_use]
pub fn identity(file: &Path) -> Option<FileIdentity> {
    file_id::get_file_id(file).ok().map(FileIdentity)
}

/// What changes with the contents of a file; `None` if there is none.
#[must_use]
pub fn stamp(file: &Path) -> Option<Stamp> {
    let metadata = fs::metadata(file).ok()?;
    let changed = metadata.modified().ok().and_then(|time| time.duration_since(UNIX_EPOCH).ok());
    Some(Stamp { file: identity(file), changed, size: metadata.len() })
}

/// A new file has the owner of the program; it takes the access list of its folder.
///
/// # Errors
/// Of the operating system.
pub fn keep_owner(new: &File, before: &Metadata) -> io::Result<()> {
    new.set_permissions(before.permissions())
}

/// Makes a file durable. The names in a folder need nothing: NTFS writes their changes to its journal first.
///
/// # Errors
/// Of the operating system.
pub fn synchronise(path: &Path) -> io::Result<()> {
    if path.is_dir() {
        return Ok(());
    }
    // Windows flushes only what is open for writing.
    OpenOptions::new().write(true).open(path)?.sync_all()
}

/// The octets that are free for this user on the disk of a path; `None` if the disk does not say.
#[must_use]
pub fn free_octets(path: &Path) -> Option<u64> {
    let folder = if path.is_dir() { path } else { path.parent()? };
    let folder = if folder.as_os_str().is_empty() { Path::new(".") } else { folder };
    fs4::available_space(folder).ok()
}

/// Whether this user may make files in a folder: the access lists of Windows are too many to tell without trying.
#[must_use]
pub fn is_folder_writable(folder: &Path) -> bool {
    let trial = folder.join(format!(".profivac-{}", std::process::id()));
    let made = OpenOptions::new().write(true).create_new(true).open(&trial).is_ok();
    if made {
        // A file that cannot be removed stays.
        fs::remove_file(trial).ok();
    }
    made
}

/// Reads all of `octets` at a position. The position of the file moves.
///
/// # Errors
/// Of the operating system, or the end of the file.
pub fn read_exact_at(file: &File, octets: &mut [u8], at: u64) -> io::Result<()> {
    let mut done = 0;
    while let Some(rest) = octets.get_mut(done..).filter(|rest| !rest.is_empty()) {
        match file.seek_read(rest, at.saturating_add(done as u64))? {
            0 => return Err(io::ErrorKind::UnexpectedEof.into()),
            length => done = done.saturating_add(length),
        }
    }
    Ok(())
}
