//! The nonvolatile memory of a virtual device: in the process, or in a file that survives a power cut.
//!
//! Every change writes a new file, synchronises it, renames it over the old one and synchronises the folder. So at any
//! instant the file has either the old content or the new one. It is text with one value per line; the last line has the
//! check sum of all others:
//!
//! ```text
//! # nonvolatile memory of bcg450 at address 5
//! parameter 1:2/39 = 01
//! address = 05 00
//! end, check sum 3DE0C46B
//! ```

use profivac_devices::model::Octets;
use profivac_devices::store::{Key, MAX_STORED, Store, StoreError};
use profivac_host::port::{Notice, StoreDamage};
use std::collections::{BTreeMap, BTreeSet};
use std::fmt::Write;
use std::fs;
use std::io::{self, ErrorKind};
use std::path::{Path, PathBuf};

/// The file operations of the memory, step by step.
pub trait Disk: Send {
    /// Reads a file.
    ///
    /// # Errors
    /// The error of the system.
    fn read(&self, path: &Path) -> io::Result<Vec<u8>>;

    /// Creates or replaces a file.
    ///
    /// # Errors
    /// The error of the system.
    fn write(&mut self, path: &Path, octets: &[u8]) -> io::Result<()>;

    /// Returns when a file, or the list of files of a folder, is safe from a power cut.
    ///
    /// # Errors
    /// The error of the system.
    fn synchronise(&mut self, path: &Path) -> io::Result<()>;

    /// Renames a file, replacing the target.
    ///
    /// # Errors
    /// The error of the system.
    fn rename(&mut self, from: &Path, to: &Path) -> io::Result<()>;
}

/// The file system of the computer.
struct HostDisk;

impl Disk for HostDisk {
    fn read(&self, path: &Path) -> io::Result<Vec<u8>> {
        fs::read(path)
    }

    fn write(&mut self, path: &Path, octets: &[u8]) -> io::Result<()> {
        fs::write(path, octets)
    }

    fn synchronise(&mut self, path: &Path) -> io::Result<()> {
        profivac_files::synchronise(path)
    }

    fn rename(&mut self, from: &Path, to: &Path) -> io::Result<()> {
        fs::rename(from, to)
    }
}

/// The stored values of a device.
pub struct NonvolatileMemory {
    title: Title,
    entries: BTreeMap<Key, Vec<u8>>,
    file: Option<(PathBuf, Box<dyn Disk>)>,
}

/// The result of opening a memory.
pub struct OpenedMemory {
    /// The memory.
    pub memory: NonvolatileMemory,
    /// A file that was not used as it was; the memory is then empty.
    pub set_aside: Option<SetAside>,
}

/// A file whose values are not used, or not all of them. It is kept, and never overwritten.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct SetAside {
    /// Why its values are not used.
    pub damage: StoreDamage,
    /// Its new name.
    pub kept_as: PathBuf,
}

impl SetAside {
    /// The notice about the device of this name with this setting of its address switch.
    #[must_use]
    pub fn notice(self, device: &str, address: u8) -> Notice {
        let Self { damage, kept_as } = self;
        Notice::StoreDamaged { device: device.to_owned(), address, damage, kept_as }
    }
}

impl NonvolatileMemory {
    /// A memory that ends with the process.
    #[must_use]
    pub fn volatile() -> Self {
        Self { title: Title { device: String::new(), address: 0 }, entries: BTreeMap::new(), file: None }
    }

    /// The memory of the device `name` at `address` in `folder`. Creates the folder. A file that is damaged, or that belongs to
    /// another device, is renamed.
    ///
    /// # Errors
    /// The error of the system if the memory cannot be written.
    pub fn open(folder: &Path, name: &str, address: u8) -> io::Result<OpenedMemory> {
        fs::create_dir_all(folder)?;
        let title = Title { device: name.to_owned(), address };
        Self::open_on(Box::new(HostDisk), folder.join(format!("{name}-{address}.state")), title)
    }

    fn open_on(mut disk: Box<dyn Disk>, path: PathBuf, title: Title) -> io::Result<OpenedMemory> {
        let (entries, damage) = match disk.read(&path) {
            Ok(octets) => match parse(&octets) {
                Some((device, entries)) if device == title.device => (entries, None),
                Some((device, _)) => (BTreeMap::new(), Some(StoreDamage::OtherDevice(device))),
                None => (BTreeMap::new(), Some(StoreDamage::Damaged)),
            },
            Err(error) if error.kind() == ErrorKind::NotFound => (BTreeMap::new(), None),
            Err(error) => return Err(error),
        };
        let set_aside = match damage {
            Some(damage) => Some(SetAside { damage, kept_as: set_aside(&mut *disk, &path)? }),
            None => None,
        };
        let mut memory = Self { title, entries, file: Some((path, disk)) };
        memory.write()?;
        Ok(OpenedMemory { memory, set_aside })
    }

    /// The keys of the stored values.
    pub(crate) fn keys(&self) -> impl Iterator<Item = Key> + '_ {
        self.entries.keys().copied()
    }

    /// A copy of the values that ends with the process.
    #[must_use]
    pub fn to_volatile(&self) -> Self {
        Self { title: self.title.clone(), entries: self.entries.clone(), file: None }
    }

    /// Drops values that the device does not take. The file with them is kept under another name, which is returned; `None`
    /// if nothing was dropped.
    ///
    /// # Errors
    /// The error of the system if the file cannot be copied or written.
    pub fn drop_refused(&mut self, refused: &BTreeSet<Key>) -> io::Result<Option<SetAside>> {
        let before = self.entries.len();
        self.entries.retain(|key, _| !refused.contains(key));
        let dropped = before.saturating_sub(self.entries.len());
        let Some((path, disk)) = self.file.as_mut().filter(|_| dropped > 0) else { return Ok(None) };
        let kept_as = set_aside(&mut **disk, path)?;
        self.write()?;
        Ok(Some(SetAside { damage: StoreDamage::Refused(dropped), kept_as }))
    }

    /// Writes all entries; a power cut leaves the old file or the new one.
    fn write(&mut self) -> io::Result<()> {
        let text = print(&self.title, &self.entries);
        let Some((path, disk)) = &mut self.file else { return Ok(()) };
        let fresh = path.with_extension("new");
        disk.write(&fresh, text.as_bytes())?;
        disk.synchronise(&fresh)?;
        disk.rename(&fresh, path)?;
        disk.synchronise(path.parent().unwrap_or(Path::new(".")))
    }
}

impl Store for NonvolatileMemory {
    fn load(&self, key: Key, octets: &mut [u8]) -> Option<usize> {
        let stored = self.entries.get(&key)?;
        octets.get_mut(..stored.len())?.copy_from_slice(stored);
        Some(stored.len())
    }

    fn save_all(&mut self, values: &mut dyn Iterator<Item = (Key, Octets)>) -> Result<(), StoreError> {
        let before = self.entries.clone();
        for (key, octets) in values {
            self.entries.insert(key, octets.to_vec());
        }
        let fits = self.entries.values().all(|octets| octets.len() <= MAX_STORED);
        let is_written = fits && self.write().is_ok();
        if !is_written {
            self.entries = before;
        }
        is_written.then_some(()).ok_or(StoreError)
    }
}

/// Renames a file to a free name.
fn set_aside(disk: &mut dyn Disk, path: &Path) -> io::Result<PathBuf> {
    let named = |number: u32| path.with_extension(format!("damaged-{number}"));
    let is_free = |aside: &PathBuf| disk.read(aside).is_err_and(|error| error.kind() == ErrorKind::NotFound);
    let aside = (1..).map(named).find(is_free).ok_or(ErrorKind::AlreadyExists)?;
    disk.rename(path, &aside)?;
    Ok(aside)
}

const END: &str = "end, check sum ";
const TITLE: &str = "# nonvolatile memory of ";
const AT_ADDRESS: &str = " at address ";

/// The first line of a file.
#[derive(Clone, Debug)]
struct Title {
    device: String,
    /// The address on the command line. A file may be renamed for another address.
    address: u8,
}

fn print(title: &Title, entries: &BTreeMap<Key, Vec<u8>>) -> String {
    let Title { device, address } = title;
    let mut text = format!("{TITLE}{device}{AT_ADDRESS}{address}\n");
    for (key, octets) in entries {
        text.push_str(&key_text(*key));
        text.push_str(" =");
        for octet in octets {
            // Writing to a string cannot fail.
            let _ = write!(text, " {octet:02X}");
        }
        text.push('\n');
    }
    let sum = crc32fast::hash(text.as_bytes());
    let _ = writeln!(text, "{END}{sum:08X}");
    text
}

fn key_text(key: Key) -> String {
    match key {
        Key::Parameter { slot, instance, index } => format!("parameter {slot}:{instance}/{index}"),
        Key::Part { slot, instance, index, part } => format!("part {part} {slot}:{instance}/{index}"),
        Key::Address => "address".to_owned(),
        Key::Internal(number) => format!("hidden {number}"),
    }
}

/// Parses a file: the device of its title, and the entries. `None` if it differs from the output of `print`.
fn parse(octets: &[u8]) -> Option<(String, BTreeMap<Key, Vec<u8>>)> {
    let text = std::str::from_utf8(octets).ok()?;
    let body = text.get(..text.rfind(END)?)?;
    let end = text.get(body.len()..)?;
    if end != format!("{END}{:08X}\n", crc32fast::hash(body.as_bytes())) {
        return None;
    }
    let mut lines = body.lines();
    let (device, _) = lines.next()?.strip_prefix(TITLE)?.split_once(AT_ADDRESS)?;
    let entries: Option<_> = lines.filter(|line| !line.starts_with('#')).map(parse_line).collect();
    Some((device.to_owned(), entries?))
}

fn parse_line(line: &str) -> Option<(Key, Vec<u8>)> {
    let (key, octets) = line.split_once(" =")?;
    let octets = octets.split_whitespace().map(|octet| u8::from_str_radix(octet, 16).ok());
    Some((parse_key(key)?, octets.collect::<Option<_>>()?))
}

fn parse_key(text: &str) -> Option<Key> {
    if text == "address" {
        return Some(Key::Address);
    }
    let (kind, location) = text.split_once(' ')?;
    match kind {
        "hidden" => Some(Key::Internal(location.parse().ok()?)),
        "parameter" => {
            let (slot, instance, index) = parse_numbers(location)?;
            Some(Key::Parameter { slot, instance, index })
        }
        "part" => {
            let (part, location) = location.split_once(' ')?;
            let ((slot, instance, index), part) = (parse_numbers(location)?, part.parse().ok()?);
            Some(Key::Part { slot, instance, index, part }).filter(|key| Key::from_u32(key.to_u32()) == Some(*key))
        }
        _ => None,
    }
}

/// Slot, instance and index.
fn parse_numbers(text: &str) -> Option<(u8, u8, u8)> {
    let (slot, rest) = text.split_once(':')?;
    let (instance, index) = rest.split_once('/')?;
    Some((slot.parse().ok()?, instance.parse().ok()?, index.parse().ok()?))
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::sync::{Arc, Mutex};

    const PARAMETER: Key = Key::Parameter { slot: 1, instance: 2, index: 39 };
    const PATH: &str = "folder/bcg450-5.state";

    fn load(memory: &NonvolatileMemory, key: Key) -> Option<Vec<u8>> {
        let mut octets = [0; MAX_STORED];
        memory.load(key, &mut octets).map(|length| octets[..length].to_vec())
    }

    /// A disk whose power is cut after a number of steps. Names and contents that were not synchronised may survive or not,
    /// independently.
    #[derive(Clone, Default)]
    struct Fragile(Arc<Mutex<Content>>);

    #[derive(Clone, Default)]
    struct Content {
        files: Vec<File>,
        /// The names of the files as a program sees them.
        names: Names,
        /// The names that survive a power cut.
        kept: Names,
        steps: usize,
        last_step: Option<usize>,
    }

    type Names = BTreeMap<PathBuf, usize>;

    #[derive(Clone, Default)]
    struct File {
        octets: Vec<u8>,
        kept: Vec<u8>,
    }

    impl Content {
        /// Counts a step. Fails from the last one on.
        fn step(&mut self) -> io::Result<()> {
            self.steps += 1;
            match self.last_step {
                Some(last) if self.steps > last => Err(ErrorKind::BrokenPipe.into()),
                _ => Ok(()),
            }
        }

        fn octets(&self, path: &Path) -> io::Result<Vec<u8>> {
            Ok(self.files[*self.names.get(path).ok_or(ErrorKind::NotFound)?].octets.clone())
        }

        fn put(&mut self, path: &Path, octets: &[u8]) {
            self.names.insert(path.to_owned(), self.files.len());
            self.files.push(File { octets: octets.to_vec(), kept: Vec::new() });
        }
    }

    impl Disk for Fragile {
        fn read(&self, path: &Path) -> io::Result<Vec<u8>> {
            self.0.lock().unwrap().octets(path)
        }

        /// Writes half of the octets if the power is cut.
        fn write(&mut self, path: &Path, octets: &[u8]) -> io::Result<()> {
            let mut content = self.0.lock().unwrap();
            let done = content.step();
            content.put(path, if done.is_ok() { octets } else { &octets[..octets.len() / 2] });
            done
        }

        fn synchronise(&mut self, path: &Path) -> io::Result<()> {
            let mut content = self.0.lock().unwrap();
            content.step()?;
            if path == Path::new("folder") {
                content.kept = content.names.clone();
            } else {
                let file = content.names[path];
                content.files[file].kept = content.files[file].octets.clone();
            }
            Ok(())
        }

        fn rename(&mut self, from: &Path, to: &Path) -> io::Result<()> {
            let mut content = self.0.lock().unwrap();
            content.step()?;
            let file = content.names.remove(from).ok_or(ErrorKind::NotFound)?;
            content.names.insert(to.to_owned(), file);
            Ok(())
        }
    }

    fn title() -> Title {
        Title { device: "bcg450".to_owned(), address: 5 }
    }

    fn open(disk: &Fragile) -> OpenedMemory {
        NonvolatileMemory::open_on(Box::new(disk.clone()), PATH.into(), title()).unwrap()
    }

    /// The possible disks after a power cut: of names and of contents only the synchronised ones, or all.
    fn after_the_cut(disk: &Fragile) -> [Fragile; 4] {
        let content = disk.0.lock().unwrap().clone();
        [(false, false), (false, true), (true, false), (true, true)].map(|(all_names, all_contents)| {
            let names = if all_names { &content.names } else { &content.kept };
            let mut left = Content::default();
            for (path, file) in names {
                let File { octets, kept } = &content.files[*file];
                left.put(path, if all_contents { octets } else { kept });
            }
            Fragile(Arc::new(Mutex::new(left)))
        })
    }

    #[test]
    fn a_power_cut_at_any_step_leaves_all_old_values_or_all_new_ones() {
        let pair = |value| [(PARAMETER, Octets::new(&[value])), (Key::Internal(0), Octets::new(&[value]))];
        let mut seen_new = false;
        for last_step in 0..=4 {
            let disk = Fragile::default();
            let mut memory = open(&disk).memory;
            memory.save_all(&mut pair(1).into_iter()).unwrap();
            memory.save(Key::Address, &[5, 0]).unwrap();
            let steps = disk.0.lock().unwrap().steps;
            disk.0.lock().unwrap().last_step = Some(steps + last_step);
            let saved = memory.save_all(&mut pair(2).into_iter());
            assert_eq!(saved.is_ok(), last_step == 4);
            assert_eq!(load(&memory, PARAMETER), Some(vec![if saved.is_ok() { 2 } else { 1 }]));
            for disk in after_the_cut(&disk) {
                let OpenedMemory { memory, set_aside: aside } = open(&disk);
                assert_eq!(aside, None, "after step {last_step}");
                let value = load(&memory, PARAMETER).unwrap();
                assert!(value == [2] || (value == [1] && saved.is_err()), "{value:?} after step {last_step}");
                assert_eq!(load(&memory, Key::Internal(0)).unwrap(), value, "after step {last_step}");
                assert_eq!(load(&memory, Key::Address), Some(vec![5, 0]));
                seen_new |= value == [2];
            }
        }
        assert!(seen_new);
    }

    #[test]
    fn saved_values_survive_opening_again() {
        let folder = tempfile::tempdir().unwrap();
        let open = || NonvolatileMemory::open(&folder.path().join("deep/er"), "bcg450", 5).unwrap();
        let mut memory = open().memory;
        let longest: Vec<u8> = (0..16).collect();
        memory.save(PARAMETER, &longest).unwrap();
        let part = Key::Part { slot: 0, instance: 0, index: 200, part: 3 };
        memory.save(part, &[7, 8]).unwrap();
        memory.save(Key::Internal(3), &[]).unwrap();
        assert_eq!(memory.save(Key::Address, &[0; MAX_STORED + 1]), Err(StoreError));
        let OpenedMemory { memory, set_aside: aside } = open();
        assert_eq!((load(&memory, PARAMETER), load(&memory, Key::Internal(3))), (Some(longest), Some(vec![])));
        assert_eq!((load(&memory, Key::Address), aside), (None, None));
    }

    #[test]
    fn every_altered_or_missing_octet_is_detected_and_the_file_is_renamed() {
        let disk = Fragile::default();
        let mut memory = open(&disk).memory;
        memory.save(PARAMETER, &[1]).unwrap();
        let octets = disk.read(Path::new(PATH)).unwrap();
        let altered = (0..octets.len()).map(|position| {
            let mut altered = octets.clone();
            altered[position] ^= 1;
            altered
        });
        for damaged in altered.chain((0..octets.len()).map(|length| octets[..length].to_vec())) {
            let disk = Fragile::default();
            disk.0.lock().unwrap().put(Path::new(PATH), &damaged);
            for number in 1..3 {
                let OpenedMemory { memory, set_aside: aside } = open(&disk);
                let SetAside { damage, kept_as } = aside.unwrap();
                assert_eq!(kept_as, Path::new(PATH).with_extension(format!("damaged-{number}")));
                assert_eq!(damage, StoreDamage::Damaged);
                assert_eq!((load(&memory, PARAMETER), disk.read(&kept_as).unwrap()), (None, damaged.clone()));
                disk.0.lock().unwrap().put(Path::new(PATH), &damaged);
            }
        }
    }

    #[test]
    fn the_file_of_another_device_is_renamed_and_that_of_another_address_is_used() {
        for (device, address, is_used) in [("pcg550", 5, false), ("bcg450", 9, true), ("bcg450", 5, true)] {
            let disk = Fragile::default();
            let other = Title { device: device.to_owned(), address };
            let text = print(&other, &BTreeMap::from([(PARAMETER, vec![1])]));
            disk.0.lock().unwrap().put(Path::new(PATH), text.as_bytes());
            let OpenedMemory { memory, set_aside } = open(&disk);
            assert_eq!(load(&memory, PARAMETER).is_some(), is_used, "{device} {address}");
            let Some(SetAside { damage, kept_as }) = set_aside.filter(|_| !is_used) else { continue };
            assert_eq!(damage, StoreDamage::OtherDevice("pcg550".to_owned()));
            assert_eq!(disk.read(&kept_as).unwrap(), text.as_bytes());
        }
    }

    #[test]
    fn a_file_with_refused_values_is_kept_and_the_other_values_are_used() {
        let disk = Fragile::default();
        let mut memory = open(&disk).memory;
        memory.save(PARAMETER, &[1]).unwrap();
        memory.save(Key::Internal(2), &[3]).unwrap();
        let before = disk.read(Path::new(PATH)).unwrap();
        assert_eq!(memory.drop_refused(&BTreeSet::new()).unwrap(), None);
        let SetAside { damage, kept_as } = memory.drop_refused(&BTreeSet::from([Key::Internal(2)])).unwrap().unwrap();
        assert_eq!((damage, disk.read(&kept_as).unwrap()), (StoreDamage::Refused(1), before));
        assert_eq!((load(&memory, PARAMETER), load(&memory, Key::Internal(2))), (Some(vec![1]), None));
        let OpenedMemory { memory, set_aside } = open(&disk);
        assert_eq!((load(&memory, PARAMETER), load(&memory, Key::Internal(2)), set_aside), (Some(vec![1]), None, None));
    }
}
