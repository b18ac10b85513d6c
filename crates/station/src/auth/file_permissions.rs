//! Files that only their owner may read: users, keys, and the station's own file when it says where those are.

use std::fs;
use std::io::Write;
use std::os::unix::fs::PermissionsExt;
use std::path::{Path, PathBuf};
use tempfile::NamedTempFile;

/// What the group and all others may do with a file.
const OTHERS: u32 = 0o077;

/// Why a file is not private.
#[derive(Debug, thiserror::Error)]
pub enum PermissionError {
    /// Others may read or write it.
    #[error("{file} holds secrets and is open to others (mode {mode:o}): chmod 600 {file}", file = .0.display(), mode = .1)]
    Open(PathBuf, u32),
    /// It cannot be looked at.
    #[error("{file}: {error}", file = .0.display(), error = .1)]
    System(PathBuf, std::io::Error),
}

/// Nothing, if only its owner may read or write this file.
///
/// # Errors
/// [`NotPrivate`] says what to do.
pub fn check(file: &Path) -> Result<(), PermissionError> {
    let seen = fs::metadata(file).map_err(|error| PermissionError::System(file.to_owned(), error))?;
    if !seen.is_file() {
        // Whoever reads a pipe waits for ever.
        let error = std::io::Error::other("expected a file, got something else");
        return Err(PermissionError::System(file.to_owned(), error));
    }
    let mode = seen.permissions().mode() & 0o7777;
    if mode & OTHERS == 0 { Ok(()) } else { Err(PermissionError::Open(file.to_owned(), mode)) }
}

/// Writes a file that only its owner may read, completely or not at all.
///
/// # Errors
/// What the system says.
pub fn write(file: &Path, text: &str) -> std::io::Result<()> {
    let folder = file.parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new("."));
    // Such a file is its owner's alone from its first moment.
    let mut new = NamedTempFile::new_in(folder)?;
    new.write_all(text.as_bytes())?;
    new.as_file().sync_all()?;
    new.persist(file)?;
    fs::File::open(folder)?.sync_all()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn set_mode(file: &Path, mode: u32) {
        fs::set_permissions(file, fs::Permissions::from_mode(mode)).unwrap();
    }

    #[test]
    fn what_is_written_is_private_and_what_is_open_is_told() {
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join("users.toml");
        fs::write(&file, "old").unwrap();
        set_mode(&file, 0o644);
        assert!(matches!(check(&file), Err(PermissionError::Open(_, 0o644))));
        write(&file, "new").unwrap();
        check(&file).unwrap();
        assert_eq!(fs::read_to_string(&file).unwrap(), "new");
        for mode in [0o640, 0o604, 0o620, 0o602] {
            set_mode(&file, mode);
            let told = check(&file).unwrap_err().to_string();
            assert!(told.contains(&format!("(mode {mode:o}): chmod 600 ")), "{told}");
        }
        assert!(matches!(check(&folder.path().join("none")), Err(PermissionError::System(..))));
        set_mode(folder.path(), 0o700);
        assert!(matches!(check(folder.path()), Err(PermissionError::System(..))), "no file");
    }
}
