//! GSD files of a folder, by ident.

use crate::slave::GsdSlave;
use crate::words::listed;
use profivac_gsd::{Device, GsdFile};
use std::collections::{BTreeMap, BTreeSet};
use std::fmt::Write as _;
use std::fs::{self, File};
use std::io::{self, Read};
use std::path::{Path, PathBuf};
use std::sync::Arc;
use thiserror::Error;

/// The largest file that is read, in octets. chosen: more than ten times the largest one that is known.
pub const MAX_OCTETS: u64 = 16 << 20;

/// At most this many files are read. chosen: ten times the largest public collections.
const MAX_FILES: usize = 20_000;

/// At most this many octets are read in all files together: they stay in memory, and the model of a file needs several times its size.
/// chosen: more than the largest public collections.
const MAX_SUM: u64 = 256 << 20;

/// The devices of GSD files.
#[derive(Clone, Debug, Default)]
pub struct Catalog {
    by_ident: BTreeMap<u16, Vec<Entry>>,
    unread: Vec<Unread>,
    /// The octets of all files that were read.
    octets: u64,
}

/// The GSD files of a folder and its folders.
#[derive(Clone, Debug, Default)]
pub struct FolderFiles {
    /// The files, by path.
    pub files: Vec<PathBuf>,
    /// Folders that cannot be read, and why.
    pub unread: Vec<Unread>,
    /// The octets of all files together.
    octets: u64,
}

/// A device of the catalog: its file and the other files of the same device.
#[derive(Clone, Debug)]
pub struct Entry {
    /// The file that is used: the default language, else English, else the first by name.
    pub path: PathBuf,
    /// Files of the same device in other languages, and copies.
    pub others: Vec<PathBuf>,
    /// The contents.
    pub file: Arc<GsdFile>,
}

/// A file of a folder that is not in the catalog.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Unread {
    /// The file.
    pub path: PathBuf,
    /// Why, and what to do.
    pub reason: String,
}

/// Why there is no catalog.
#[derive(Clone, Debug, PartialEq, Eq, Error)]
#[non_exhaustive]
pub enum CatalogError {
    /// The system refuses to read a path.
    #[error("{path} cannot be read: {reason}; check the path")]
    Read {
        /// The path.
        path: PathBuf,
        /// The words of the system.
        reason: String,
    },
    /// The file cannot be used.
    #[error("{path}: {reason}")]
    File {
        /// The path.
        path: PathBuf,
        /// Why, and what to do.
        reason: String,
    },
    /// A folder has no GSD file.
    #[error("expected GSD files in {path} and its folders, found none whose name ends in .gsd, .gse, .gsg ...")]
    Empty {
        /// The folder.
        path: PathBuf,
    },
    /// The files are too large together.
    #[error("the GSD files up to {path} have more than {} MiB; name fewer of them", MAX_SUM >> 20)]
    TooLarge {
        /// The file or folder.
        path: PathBuf,
    },
    /// Too many files.
    #[error("{path} has more than {MAX_FILES} GSD files; name a folder with fewer")]
    TooMany {
        /// The folder.
        path: PathBuf,
    },
}

/// Why no single device was chosen.
#[derive(Clone, Debug, PartialEq, Eq, Error)]
#[non_exhaustive]
pub enum ChoiceError {
    /// No file has the ident.
    #[error(
        "no GSD file has the ident 0x{0:04X}; get the file from the vendor of the slave, and name it or its folder with --gsd"
    )]
    Unknown(u16),
    /// Several devices have the ident.
    #[error("several devices have the ident 0x{ident:04X}: {files}; name the right file with --gsd")]
    Several {
        /// The ident.
        ident: u16,
        /// Vendor, device and path of each.
        files: String,
    },
}

impl Catalog {
    /// Reads files and folders. A folder is read with its folders; files that are no GSD files for DP slaves are listed in
    /// [`unread`](Self::unread), and a file that is named itself is an error then.
    ///
    /// Files of one folder whose names differ only in the language's letter, and files with the same contents, are one device if they
    /// have one ident.
    ///
    /// # Errors
    ///
    /// [`CatalogError`] names the path, and what to do.
    pub fn read(paths: &[PathBuf]) -> Result<Self, CatalogError> {
        let mut catalog = Self::default();
        for path in paths {
            if path.is_dir() {
                let found = FolderFiles::find(path)?;
                catalog.reserve(path, found.octets)?;
                catalog.unread.extend(found.unread);
                catalog.add_all(found.files);
                continue;
            }
            catalog.reserve(path, fs::metadata(path).map_or(0, |file| file.len().min(MAX_OCTETS)))?;
            let (ident, file) = read(path).map_err(|reason| match reason {
                NotRead::System(reason) => CatalogError::Read { path: path.clone(), reason },
                NotRead::File(reason) => CatalogError::File { path: path.clone(), reason },
            })?;
            catalog.add(ident, path.clone(), file);
        }
        Ok(catalog)
    }

    /// The devices with this ident, by path.
    #[must_use]
    pub fn by_ident(&self, ident: u16) -> &[Entry] {
        self.by_ident.get(&ident).map_or(&[], Vec::as_slice)
    }

    /// All devices, by ident.
    pub fn entries(&self) -> impl Iterator<Item = (u16, &Entry)> {
        self.by_ident.iter().flat_map(|(ident, entries)| entries.iter().map(|entry| (*ident, entry)))
    }

    /// Files of folders that are not in the catalog, and why.
    #[must_use]
    pub fn unread(&self) -> &[Unread] {
        &self.unread
    }

    /// The devices of an ident whose modules give the octets of Get_Cfg. All devices of the ident if none does.
    #[must_use]
    pub fn narrowed(&self, ident: u16, get_cfg: &[u8]) -> Vec<&Entry> {
        let all = self.by_ident(ident);
        let fitting: Vec<_> = all.iter().filter(|entry| GsdSlave::by_chk_cfg(&entry.file, get_cfg).is_ok()).collect();
        if fitting.is_empty() { all.iter().collect() } else { fitting }
    }

    /// The devices with this ident that a slave can be: with the octets of Get_Cfg those of [`narrowed`](Self::narrowed).
    #[must_use]
    pub fn candidates(&self, ident: u16, get_cfg: Option<&[u8]>) -> Vec<&Entry> {
        match get_cfg {
            Some(octets) => self.narrowed(ident, octets),
            None => self.by_ident(ident).iter().collect(),
        }
    }

    /// The only device with this ident; with the octets of Get_Cfg the only one whose modules give them.
    ///
    /// # Errors
    ///
    /// [`ChoiceError`] if no device has the ident, or several have, with the path of each.
    pub fn choose(&self, ident: u16, get_cfg: Option<&[u8]>) -> Result<&Entry, ChoiceError> {
        match self.candidates(ident, get_cfg).as_slice() {
            [only] => Ok(only),
            [] => Err(ChoiceError::Unknown(ident)),
            several => {
                let words = |entry: &&Entry| format!("{} in {}", entry.name(), entry.path.display());
                Err(ChoiceError::Several { ident, files: listed(several.iter().map(words)) })
            }
        }
    }

    /// Counts octets before they are read.
    fn reserve(&mut self, path: &Path, octets: u64) -> Result<(), CatalogError> {
        self.octets = self.octets.saturating_add(octets);
        if self.octets > MAX_SUM { Err(CatalogError::TooLarge { path: path.to_owned() }) } else { Ok(()) }
    }

    /// By folder and name, so that of files of one device the right one comes first.
    fn add_all(&mut self, mut files: Vec<PathBuf>) {
        files.sort_by_cached_key(|path| (without_language(path), language_rank(path), path.clone()));
        for path in files {
            match read(&path) {
                Ok((ident, file)) => self.add(ident, path, file),
                Err(NotRead::System(reason) | NotRead::File(reason)) => self.unread.push(Unread { path, reason }),
            }
        }
    }

    fn add(&mut self, ident: u16, path: PathBuf, file: GsdFile) {
        let entries = self.by_ident.entry(ident).or_default();
        let same = |entry: &&mut Entry| {
            without_language(&entry.path) == without_language(&path) || entry.file.text() == file.text()
        };
        match entries.iter_mut().find(same) {
            Some(entry) if entry.path == path => {}
            Some(entry) => entry.others.push(path),
            None => entries.push(Entry { path, others: Vec::new(), file: Arc::new(file) }),
        }
    }
}

impl Entry {
    /// The device of the file.
    #[must_use]
    pub fn device(&self) -> &Device {
        self.file.device()
    }

    /// Vendor and model: `Vendor Model`.
    #[must_use]
    pub fn name(&self) -> String {
        let general = &self.device().general;
        let mut name = general.vendor_name.as_deref().unwrap_or("unnamed vendor").trim().to_owned();
        let _ = write!(name, " {}", general.model_name.as_deref().unwrap_or("unnamed device").trim());
        name
    }
}

/// Why a file was not read.
enum NotRead {
    System(String),
    File(String),
}

fn read(path: &Path) -> Result<(u16, GsdFile), NotRead> {
    let mut octets = Vec::new();
    let read = File::open(path).and_then(|file| file.take(MAX_OCTETS.saturating_add(1)).read_to_end(&mut octets));
    read.map_err(|error| NotRead::System(error.to_string()))?;
    if u64::try_from(octets.len()).unwrap_or(u64::MAX) > MAX_OCTETS {
        return Err(NotRead::File(format!("expected a GSD file of at most {} MiB, got more", MAX_OCTETS >> 20)));
    }
    let file = GsdFile::read(&octets);
    let general = &file.device().general;
    match general.ident_number.map(u16::try_from) {
        Some(Ok(ident)) => Ok((ident, file)),
        Some(Err(_)) => Err(NotRead::File("expected an Ident_Number from 0 to 0xFFFF; see `profivac gsd check`".into())),
        None => Err(NotRead::File(
            "expected a GSD file of a DP slave, with #Profibus_DP and Ident_Number, and found no Ident_Number; see `profivac gsd check`".into(),
        )),
    }
}

impl FolderFiles {
    /// The GSD files of a folder and its folders. A folder below it that cannot be read is listed.
    ///
    /// # Errors
    ///
    /// [`CatalogError`] if the folder itself cannot be read, has no GSD file, or too many.
    pub fn find(folder: &Path) -> Result<Self, CatalogError> {
        let mut found = Self::default();
        found.walk(vec![folder.to_owned()]);
        let is_unread = |unread: &&Unread| found.files.is_empty() || unread.path == folder;
        if let Some(Unread { path, reason }) = found.unread.iter().find(is_unread).cloned() {
            return Err(CatalogError::Read { path, reason });
        }
        let path = folder.to_owned();
        match found.files.len() {
            0 => Err(CatalogError::Empty { path }),
            1..=MAX_FILES => Ok(found),
            _ => Err(CatalogError::TooMany { path }),
        }
    }

    /// Reads folders and those in them; it ends early when there are too many files. A folder is read once, because links can lead to
    /// one that was read.
    fn walk(&mut self, mut folders: Vec<PathBuf>) {
        let mut read = BTreeSet::new();
        while let Some(folder) = folders.pop().filter(|_| self.files.len() <= MAX_FILES) {
            let done = folder.canonicalize().and_then(|path| match read.insert(path) {
                true => self.read_folder(&folder, &mut folders),
                false => Ok(()),
            });
            if let Err(error) = done {
                self.unread.push(Unread { path: folder, reason: error.to_string() });
            }
        }
        self.files.sort();
    }

    /// Only regular files count, because a pipe has no end.
    fn read_folder(&mut self, folder: &Path, folders: &mut Vec<PathBuf>) -> io::Result<()> {
        for entry in fs::read_dir(folder)? {
            let path = entry?.path();
            if path.is_dir() {
                folders.push(path);
            } else if let Ok(file) = fs::metadata(&path)
                && has_gsd_ending(&path)
                && file.is_file()
            {
                self.octets = self.octets.saturating_add(file.len().min(MAX_OCTETS));
                self.files.push(path);
            }
            if self.files.len() > MAX_FILES {
                break;
            }
        }
        Ok(())
    }
}

/// Whether a name ends in `.gsd`, or in `.gs` and the letter of a language.
#[must_use]
pub fn has_gsd_ending(path: &Path) -> bool {
    language(path).is_some()
}

/// The last letter of `.gsd`, in small letters.
fn language(path: &Path) -> Option<char> {
    let ending = path.extension()?.to_str()?.to_ascii_lowercase();
    let mut rest = ending.strip_prefix("gs")?.chars();
    rest.next().filter(|_| rest.next().is_none())
}

/// The default language comes first, then English.
fn language_rank(path: &Path) -> usize {
    match language(path) {
        Some('d') => 0,
        Some('e') => 1,
        _ => 2,
    }
}

/// What files of one device in several languages have in common: names in any capitals.
fn without_language(path: &Path) -> (PathBuf, String) {
    let folder = path.parent().map(Path::to_owned).unwrap_or_default();
    (folder, path.file_stem().unwrap_or_default().to_string_lossy().to_lowercase())
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, reason = "a test")]

    use super::*;

    /// A folder that is gone stands for one that cannot be read: the tests may run as root, which can read each.
    #[test]
    fn a_folder_that_cannot_be_read_is_listed_and_the_others_are_read() {
        let folder = tempfile::tempdir().unwrap();
        let (file, gone) = (folder.path().join("a.gsd"), folder.path().join("gone"));
        fs::write(&file, "").unwrap();
        let mut found = FolderFiles::default();
        found.walk(vec![folder.path().to_owned(), gone.clone()]);
        assert_eq!(found.files, [file]);
        assert!(matches!(found.unread.as_slice(), [Unread { path, .. }] if *path == gone));
    }
}
