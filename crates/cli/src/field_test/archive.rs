//! The archive of a field test: one tar file without the names of a computer or a user.

use super::report::{FORMAT, Report};
use crate::failure::Failure;
use crate::output::json;
use crate::whole_file::not_written;
use profivac_dp::link::Baud;
use std::io::{Read, Write};
use std::path::{Path, PathBuf};
use tempfile::NamedTempFile;

/// The folder in the archive.
const FOLDER: &str = "field-test";

const REPORT: &str = "report.json";
const CAPTURE: &str = "capture.pcapng";

/// The largest file of an archive that is read: 256 MiB. chosen: a run of days is smaller.
const LARGEST: u64 = 1 << 28;

/// The contents of an archive.
pub struct Archive {
    /// The results.
    pub report: Report,
    /// A capture file.
    pub capture: Vec<u8>,
}

/// An archive that is a temporary file beside its name until it is complete.
pub struct Output {
    path: PathBuf,
    file: NamedTempFile,
}

impl Output {
    /// Reserves `path`, so that a run does not begin whose result cannot be kept.
    ///
    /// # Errors
    /// A usage error if the file exists, cannot be made, or would be compressed.
    pub fn create(path: &Path) -> Result<Self, Failure> {
        let shown = path.display();
        if path.extension().is_some_and(|extension| extension == "gz" || extension == "tgz") {
            return Err(Failure::usage(format!(
                "expected a name like line.tar, got {shown}: the archive is not compressed; run gzip on it afterwards"
            )));
        }
        if path.exists() {
            return Err(Failure::usage(format!("{shown} exists already: give another name with --out")));
        }
        let folder = path.parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new("."));
        let file = NamedTempFile::with_prefix_in(".field-test-", folder).map_err(|error| not_written(path, &error))?;
        Ok(Self { path: path.to_owned(), file })
    }

    /// Writes the files and gives the archive its name.
    ///
    /// # Errors
    /// A usage error if the disk is full, or the file exists by now.
    pub fn write(mut self, files: &[(&str, &[u8])]) -> Result<(), Failure> {
        let failed = |error: &std::io::Error| not_written(&self.path, error);
        let octets = tar_of(files).map_err(|error| failed(&error))?;
        self.file.write_all(&octets).and_then(|()| self.file.as_file().sync_all()).map_err(|error| failed(&error))?;
        self.file.persist_noclobber(&self.path).map_err(|error| not_written(&self.path, &error.error))?;
        Ok(())
    }
}

/// The files as a tar file. Owner and time of each are 0.
fn tar_of(files: &[(&str, &[u8])]) -> std::io::Result<Vec<u8>> {
    let mut builder = tar::Builder::new(Vec::new());
    for (name, octets) in files {
        let mut header = tar::Header::new_ustar();
        header.set_size(octets.len() as u64);
        header.set_mode(0o644);
        header.set_uid(0);
        header.set_gid(0);
        header.set_mtime(0);
        builder.append_data(&mut header, format!("{FOLDER}/{name}"), *octets)?;
    }
    builder.into_inner()
}

/// The files of an archive.
pub fn files(report: &Report, text: &str, capture: &[u8], pieces: &str) -> Vec<(&'static str, Vec<u8>)> {
    vec![
        ("README", README.as_bytes().to_vec()),
        (REPORT, (json(report) + "\n").into_bytes()),
        ("report.txt", text.as_bytes().to_vec()),
        (CAPTURE, capture.to_vec()),
        ("pieces.csv", pieces.as_bytes().to_vec()),
    ]
}

impl Archive {
    /// Reads an archive.
    ///
    /// # Errors
    /// A usage error that names the file and what is wrong with it.
    pub fn read(path: &Path) -> Result<Self, Failure> {
        let wrong = |reason: String| {
            Failure::usage(format!(
                "{}: expected an archive of `profivac field-test`, {reason}; decompress it first if it is a .gz file",
                path.display()
            ))
        };
        let file = std::fs::File::open(path)
            .map_err(|error| Failure::usage(format!("{} cannot be read: {error}", path.display())))?;
        let (mut report, mut capture) = (None, None);
        let mut archive = tar::Archive::new(file);
        for entry in archive.entries().map_err(|error| wrong(format!("found no tar file: {error}")))? {
            let entry = entry.map_err(|error| wrong(format!("found a damaged tar file: {error}")))?;
            let name = entry.path().ok().and_then(|path| Some(path.file_name()?.to_string_lossy().into_owned()));
            let mut octets = Vec::new();
            let kept = match name.as_deref() {
                Some(REPORT) => &mut report,
                Some(CAPTURE) => &mut capture,
                _ => continue,
            };
            entry
                .take(LARGEST)
                .read_to_end(&mut octets)
                .map_err(|error| wrong(format!("{} cannot be read: {error}", name.unwrap_or_default())))?;
            *kept = Some(octets);
        }
        let report = report.ok_or_else(|| wrong(format!("found no {REPORT}")))?;
        let report: Report =
            serde_json::from_slice(&report).map_err(|error| wrong(format!("found a wrong {REPORT}: {error}")))?;
        if report.format != FORMAT {
            return Err(wrong(format!("found format {} in place of {FORMAT}", report.format)));
        }
        report.options.check().map_err(|error| wrong(error.to_string()))?;
        let capture = capture.ok_or_else(|| wrong(format!("found no {CAPTURE}")))?;
        Ok(Self { report, capture })
    }

    /// The rate of the run.
    ///
    /// # Errors
    /// A usage error if it is no PROFIBUS rate.
    pub fn rate(&self) -> Result<Baud, Failure> {
        let baud = self.report.options.baud;
        let unknown = || Failure::usage(format!("the archive has the rate {baud}, which PROFIBUS does not have"));
        self.report.options.rate().ok_or_else(unknown)
    }
}

/// The contents of the archive, for the person who sends it.
const README: &str = "\
Archive of `profivac field-test`: what profivac measured on one PROFIBUS line at one baud rate.

report.txt      the results for people
report.json     the same for programs; docs/field-test.md describes the keys
capture.pcapng  the telegrams on the line, as `profivac decode` and Wireshark read them
pieces.csv      when the port took or delivered characters, and how many at once; no contents

Not contained: the names of the computer, of a user and of files; the serial number of the adapter.
Records that slaves sent (serial numbers, texts) are zeros, unless `with_serial_numbers` in report.json is true.
If another master was on the line, the data of its telegrams are zeros, and damaged pieces are `x`.

Contained: addresses, ident numbers, diagnoses and configurations of the slaves; the device name, driver and USB
identity of the adapter; the release of the kernel. With `allow_writes`, also measured values of gauges.
Look at report.txt and at `profivac decode capture.pcapng` before you send the archive.

`profivac field-test --replay ARCHIVE` repeats the run without the line and compares the results.
";

#[cfg(test)]
#[allow(clippy::unwrap_used, reason = "a test")]
mod tests {
    use super::*;

    #[test]
    fn the_tar_file_names_no_user_and_has_no_time() {
        let octets = tar_of(&[("README", b"text")]).unwrap();
        let mut archive = tar::Archive::new(octets.as_slice());
        let entry = archive.entries().unwrap().next().unwrap().unwrap();
        let header = entry.header();
        assert_eq!(entry.path().unwrap(), Path::new("field-test/README"));
        assert_eq!((header.uid().unwrap(), header.gid().unwrap(), header.mtime().unwrap()), (0, 0, 0));
        assert_eq!((header.username().unwrap(), header.groupname().unwrap()), (Some(""), Some("")));
    }

    #[test]
    fn an_archive_appears_complete_or_not_at_all() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("line.tar");
        drop(Output::create(&path).unwrap());
        assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 0);
        Output::create(&path).unwrap().write(&[("README", b"text")]).unwrap();
        assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 1);
        let refused = Output::create(&path).err().unwrap().to_string();
        assert!(refused.ends_with("line.tar exists already: give another name with --out"), "{refused}");
    }

    #[test]
    fn a_file_that_is_no_archive_is_refused_with_its_name() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("line.tar");
        for (octets, reason) in [
            (tar_of(&[("README", b"text")]).unwrap(), "found no report.json"),
            (tar_of(&[("report.json", b"{}")]).unwrap(), "found a wrong report.json"),
            (vec![7; 600], "found a damaged tar file"),
        ] {
            std::fs::write(&path, octets).unwrap();
            let refused = Archive::read(&path).err().unwrap().to_string();
            assert!(refused.contains("line.tar: expected an archive") && refused.contains(reason), "{refused}");
        }
    }
}
