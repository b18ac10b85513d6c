//! Output files: a file is written completely or not at all.

use crate::failure::Failure;
use std::fs::{self, File, OpenOptions};
use std::io::{self, BufWriter, Write};
use std::path::{Path, PathBuf};

/// An existing file may be the only copy of its contents: without `force` it is an error. A device or a pipe is no such file.
///
/// # Errors
/// A usage error that names the file.
pub fn check_absent(path: &Path, force: bool) -> Result<(), Failure> {
    if !force && fs::metadata(path).is_ok_and(|existing| existing.is_file()) {
        let name = path.display();
        return Err(Failure::usage(format!(
            "{name} exists already and was not changed; choose another name, or add --force to overwrite it"
        )));
    }
    Ok(())
}

/// Writes a text as [`write()`] does.
///
/// # Errors
/// As [`write()`].
pub fn write_text(path: &Path, text: &str) -> Result<(), Failure> {
    write(path, |to| to.write_all(text.as_bytes()).map_err(|error| not_written(path, &error)))
}

/// Writes a file beside its destination, and gives it its name when it is whole. It replaces an existing file and keeps its
/// permissions. A device or a pipe is written directly.
///
/// # Errors
/// That of `contents`, or a usage error that names the file; then the destination is as it was.
pub fn write<T>(
    path: &Path,
    contents: impl FnOnce(&mut (dyn Write + Send)) -> Result<T, Failure>,
) -> Result<T, Failure> {
    let failed = |error: io::Error| not_written(path, &error);
    if fs::metadata(path).is_ok_and(|existing| !existing.is_file()) {
        let device = OpenOptions::new().write(true).open(path).map_err(failed)?;
        return fill(device, path, contents).map(|(_, done)| done);
    }
    // Behind a link, the file itself is replaced and not the link.
    let destination = fs::canonicalize(path).unwrap_or_else(|_| path.to_owned());
    let part = part_of(&destination);
    let written = File::create(&part).map_err(failed).and_then(|file| {
        if let Ok(existing) = fs::metadata(&destination) {
            file.set_permissions(existing.permissions()).map_err(failed)?;
        }
        let (file, done) = fill(file, path, contents)?;
        file.sync_all().and_then(|()| fs::rename(&part, &destination)).map_err(failed)?;
        Ok(done)
    });
    if written.is_err() {
        // The error of the write is reported.
        fs::remove_file(&part).ok();
    }
    written
}

/// The error of a file that cannot be written.
pub fn not_written(path: &Path, error: &io::Error) -> Failure {
    Failure::usage(format!("{} cannot be written: {error}", path.display()))
}

fn fill<T>(
    file: File,
    path: &Path,
    contents: impl FnOnce(&mut (dyn Write + Send)) -> Result<T, Failure>,
) -> Result<(File, T), Failure> {
    let mut to = BufWriter::new(file);
    let done = contents(&mut to)?;
    let file = to.into_inner().map_err(|error| not_written(path, error.error()))?;
    Ok((file, done))
}

fn part_of(path: &Path) -> PathBuf {
    let mut part = path.as_os_str().to_owned();
    part.push(".part");
    PathBuf::from(part)
}

#[cfg(test)]
#[allow(clippy::unwrap_used, reason = "a test")]
mod tests {
    use super::*;
    use std::os::unix::fs::PermissionsExt;

    fn names(folder: &Path) -> Vec<String> {
        let entries = fs::read_dir(folder).unwrap();
        entries.map(|entry| entry.unwrap().file_name().into_string().unwrap()).collect()
    }

    #[test]
    fn a_file_that_cannot_be_written_whole_leaves_the_old_one() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("report.html");
        let fail = |to: &mut (dyn Write + Send)| {
            to.write_all(b"the first half").unwrap();
            Err::<(), _>(Failure::usage("the disk is full".to_owned()))
        };
        assert!(write(&path, fail).is_err());
        assert!(names(folder.path()).is_empty(), "{:?}", names(folder.path()));
        write_text(&path, "old").unwrap();
        assert!(write(&path, fail).is_err());
        assert_eq!(names(folder.path()), ["report.html"]);
        assert_eq!(fs::read_to_string(&path).unwrap(), "old");
        write_text(&path, "new").unwrap();
        assert_eq!((names(folder.path()).len(), fs::read_to_string(&path).unwrap()), (1, "new".to_owned()));
    }

    #[test]
    fn a_replaced_file_keeps_its_permissions_and_the_link_to_it() {
        let folder = tempfile::tempdir().unwrap();
        let [path, link] = ["private.html", "link.html"].map(|name| folder.path().join(name));
        write_text(&path, "old").unwrap();
        fs::set_permissions(&path, fs::Permissions::from_mode(0o600)).unwrap();
        std::os::unix::fs::symlink(&path, &link).unwrap();
        write_text(&link, "new").unwrap();
        assert!(link.is_symlink());
        assert_eq!(fs::read_to_string(&path).unwrap(), "new");
        assert_eq!(fs::metadata(&path).unwrap().permissions().mode() & 0o777, 0o600);
    }

    #[test]
    fn an_existing_file_is_an_error_without_force() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("all.csv");
        assert!(check_absent(&path, false).is_ok());
        write_text(&path, "mine").unwrap();
        assert!(check_absent(&path, false).is_err() && check_absent(&path, true).is_ok());
        assert!(check_absent(Path::new("/dev/null"), false).is_ok());
    }

    #[test]
    fn a_full_device_is_an_error_and_is_not_replaced() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("device");
        std::os::unix::fs::symlink("/dev/full", &path).unwrap();
        assert!(write_text(&path, "text").is_err());
        assert_eq!(names(folder.path()), ["device"]);
        assert!(path.is_symlink());
    }
}
