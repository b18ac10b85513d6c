//! Files that only their owner may read: the users' file, keys, and a configuration file that names them.

use profivac_files::{access_of_others, make_private, synchronise};
use std::fs;
use std::io::Write;
use std::path::{Path, PathBuf};
use tempfile::NamedTempFile;

/// The reason why a file cannot be used for secrets.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum PermissionError {
    /// The group or others have access; the second value is the mode.
    #[error("{file} holds secrets and is open to others (mode {mode:o}): chmod 600 {file}", file = .0.display(), mode = .1)]
    Open(PathBuf, u32),
    /// The operating system refuses, or the path is not a regular file.
    #[error("{file}: {error}", file = .0.display(), error = .1)]
    System(PathBuf, std::io::Error),
}

/// Checks that only its owner may access a file.
///
/// # Errors
/// [`PermissionError`], which names the remedy.
pub fn check(file: &Path) -> Result<(), PermissionError> {
    let metadata = fs::metadata(file).map_err(|error| PermissionError::System(file.to_owned(), error))?;
    if !metadata.is_file() {
        // Reading a pipe could block for ever.
        let error = std::io::Error::other("expected a regular file");
        return Err(PermissionError::System(file.to_owned(), error));
    }
    match access_of_others(file).map_err(|error| PermissionError::System(file.to_owned(), error))? {
        None => Ok(()),
        Some(mode) => Err(PermissionError::Open(file.to_owned(), mode)),
    }
}

/// Writes a file that only its owner may access. The file is replaced as a whole or not at all.
///
/// # Errors
/// The error of the operating system.
pub fn write(file: &Path, text: &str) -> std::io::Result<()> {
    let folder = file.parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new("."));
    let mut new = NamedTempFile::new_in(folder)?;
    make_private(new.path())?;
    new.write_all(text.as_bytes())?;
    new.as_file().sync_all()?;
    new.persist(file)?;
    synchronise(folder)
}

#[cfg(unix)]
#[cfg(test)]
mod tests {
    use super::*;
    use std::os::unix::fs::PermissionsExt as _;

    fn set_mode(file: &Path, mode: u32) {
        fs::set_permissions(file, fs::Permissions::from_mode(mode)).unwrap();
    }

    #[test]
    fn a_written_file_is_private_and_an_open_file_is_an_error() {
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
            let error = check(&file).unwrap_err().to_string();
            assert!(error.contains(&format!("(mode {mode:o}): chmod 600 ")), "{error}");
        }
        assert!(matches!(check(&folder.path().join("none")), Err(PermissionError::System(..))));
        set_mode(folder.path(), 0o700);
        assert!(matches!(check(folder.path()), Err(PermissionError::System(..))), "a folder is no regular file");
    }
}
