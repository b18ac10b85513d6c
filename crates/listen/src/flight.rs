//! The flight recorder: the last traffic in bounded memory. A trigger writes a capture file with the time before and after it.

use profivac_dp::link::{Baud, BitTime};
use profivac_explain::frame::{Piece, PieceKind};
use profivac_sim::trace::Entry;
use profivac_sim::trace::pcapng::{Times, USER0, file_header, packet};
use std::collections::VecDeque;
use std::fs::{self, OpenOptions};
use std::io::{self, Write};
use std::path::{Path, PathBuf};

/// Limits of a flight recorder.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct FlightLimits {
    /// The memory for traffic in octets. It holds minutes on a usual line, seconds at 12 Mbit/s with full load.
    pub memory_octets: usize,
    /// The time before the trigger in a capture, in milliseconds.
    pub before_ms: u64,
    /// The time behind it.
    pub after_ms: u64,
    /// The largest number of captures on disk.
    pub files: usize,
    /// The largest sum of their sizes in octets.
    pub disk_octets: u64,
}

impl FlightLimits {
    /// The memory of a block, in octets: a full recorder has at least sixteen blocks.
    fn block_octets(&self) -> usize {
        BLOCK_OCTETS.min(self.memory_octets / 16)
    }
}

impl Default for FlightLimits {
    fn default() -> Self {
        Self { memory_octets: 32 << 20, before_ms: 60_000, after_ms: 5000, files: 20, disk_octets: 256 << 20 }
    }
}

/// The octets that a piece needs beside its own: its start, its length, and where its first character error is.
const OVERHEAD: usize = 12;

/// The memory of a block. chosen: small beside the memory of a recorder.
const BLOCK_OCTETS: usize = 64 << 10;

/// A piece of the traffic, as the memory of a block has it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct Stored<'a> {
    start: BitTime,
    length: u16,
    /// A character error, where the piece has one; the first of several.
    error: Option<u16>,
    octets: &'a [u8],
}

impl<'a> Stored<'a> {
    /// The place of an error in a piece without one: the longest piece ends before it.
    const NO_ERROR: u16 = u16::MAX;

    /// The piece, unless it has more than 65 535 octets: no telegram is nearly as long.
    fn of(piece: &'a Piece) -> Option<Self> {
        let length = u16::try_from(piece.octets.len()).ok()?;
        let first_error = piece.errors.first().and_then(|position| u16::try_from(*position).ok());
        let is_damaged = piece.kind == PieceKind::Damaged;
        Some(Self { start: piece.start?, length, error: first_error.filter(|_| is_damaged), octets: &piece.octets })
    }

    /// Adds the piece to a memory.
    fn write(&self, memory: &mut Vec<u8>) {
        memory.extend(self.start.0.to_le_bytes());
        memory.extend(self.length.to_le_bytes());
        memory.extend(self.error.unwrap_or(Self::NO_ERROR).to_le_bytes());
        memory.extend(self.octets);
    }

    /// The first piece of a memory, and the rest.
    fn read(memory: &'a [u8]) -> Option<(Self, &'a [u8])> {
        let (start, rest) = memory.split_first_chunk()?;
        let (length, rest) = rest.split_first_chunk()?;
        let (error, rest) = rest.split_first_chunk()?;
        let length = u16::from_le_bytes(*length);
        let (octets, rest) = rest.split_at_checked(usize::from(length))?;
        let error = Some(u16::from_le_bytes(*error)).filter(|error| *error != Self::NO_ERROR);
        Some((Self { start: BitTime(u64::from_le_bytes(*start)), length, error, octets }, rest))
    }

    /// All pieces of a memory.
    fn all(mut memory: &'a [u8]) -> impl Iterator<Item = Self> {
        std::iter::from_fn(move || {
            let (piece, rest) = Self::read(memory)?;
            memory = rest;
            Some(piece)
        })
    }
}

/// Pieces that follow each other. A full recorder takes the memory of its oldest block for the newest pieces, so it neither gives memory
/// back nor takes any: that would leave gaps in the heap.
#[derive(Clone, Debug)]
struct Block {
    memory: Vec<u8>,
    /// The start of its last piece.
    last: BitTime,
}

impl Block {
    const fn has_room(&self, octets: usize) -> bool {
        self.memory.capacity() - self.memory.len() >= octets
    }
}

/// The reason for a capture.
#[derive(Clone, Debug, PartialEq, Eq)]
struct Trigger {
    at: BitTime,
    reason: String,
}

/// The last traffic of a line.
#[derive(Clone, Debug)]
pub struct FlightRecorder {
    baud: Baud,
    limits: FlightLimits,
    blocks: VecDeque<Block>,
    trigger: Option<Trigger>,
}

/// A capture that is complete in memory and not on disk yet.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Capture {
    /// Why it was made.
    pub reason: String,
    baud: Baud,
    /// The pieces, as blocks have them.
    memory: Vec<u8>,
}

impl Capture {
    /// The contents of the file, as Wireshark and `profivac decode` read it. Making it takes long for a full memory: a bus thread does not.
    #[must_use]
    pub fn file(&self) -> Vec<u8> {
        let mut file = file_header(Some(self.baud), USER0);
        for Stored { start, error, octets, .. } in Stored::all(&self.memory) {
            let errors = error.map(usize::from).into_iter().collect();
            file.extend(packet(&Entry::new(start, octets.to_vec(), errors), Times::Measured, self.baud));
        }
        file
    }
}

/// A capture on disk.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct StoredCapture {
    /// The name of its file.
    pub name: String,
    /// Its size in octets.
    pub octets: u64,
}

impl FlightRecorder {
    /// A flight recorder without traffic.
    #[must_use]
    pub const fn new(baud: Baud, limits: FlightLimits) -> Self {
        Self { baud, limits, blocks: VecDeque::new(), trigger: None }
    }

    /// The memory for traffic that it has taken, in octets.
    #[must_use]
    pub fn memory_octets(&self) -> usize {
        self.blocks.iter().map(|block| block.memory.capacity()).sum()
    }

    /// Adds a piece. The oldest leave when the memory is full.
    pub fn add(&mut self, piece: &Piece) {
        let Some(mut stored) = Stored::of(piece) else { return };
        if let Some(block) = self.blocks.back() {
            stored.start = block.last.max(stored.start);
        }
        let octets = OVERHEAD.saturating_add(piece.octets.len());
        if !self.blocks.back().is_some_and(|block| block.has_room(octets)) {
            self.begin_block(octets);
        }
        if let Some(block) = self.blocks.back_mut() {
            stored.write(&mut block.memory);
            block.last = stored.start;
        }
    }

    /// Begins a block with room for a piece of `octets`, in the memory of the oldest one when no more may be taken.
    fn begin_block(&mut self, octets: usize) {
        let size = self.limits.block_octets().max(octets);
        let mut oldest = None;
        while self.memory_octets().saturating_add(size) > self.limits.memory_octets
            && let Some(block) = self.blocks.pop_front()
        {
            oldest = Some(block.memory).filter(|memory| memory.capacity() >= size);
        }
        let mut memory = oldest.unwrap_or_else(|| Vec::with_capacity(size));
        memory.clear();
        self.blocks.push_back(Block { memory, last: BitTime(0) });
    }

    /// Begins a capture for `reason`. Until it is complete a second trigger makes no other one.
    pub fn trigger(&mut self, at: BitTime, reason: &str) {
        self.trigger.get_or_insert_with(|| Trigger { at, reason: reason.to_owned() });
    }

    /// The capture, if one was triggered and the time behind it has passed.
    pub fn take_capture(&mut self, now: BitTime) -> Option<Capture> {
        let after_tbit = self.baud.tbit_of_ms(self.limits.after_ms);
        let Trigger { at, reason } = self.trigger.take_if(|trigger| now - trigger.at >= after_tbit)?;
        let from = BitTime(at.0.saturating_sub(self.baud.tbit_of_ms(self.limits.before_ms)));
        Some(self.capture(reason, from, at + after_tbit))
    }

    /// A copy of the traffic between two times. The starts of the pieces rise.
    fn capture(&self, reason: String, from: BitTime, to: BitTime) -> Capture {
        let blocks = self.blocks.iter().skip_while(|block| block.last < from);
        let mut memory = Vec::with_capacity(blocks.clone().map(|block| block.memory.len()).sum());
        for block in blocks {
            let within =
                Stored::all(&block.memory).skip_while(|piece| piece.start < from).take_while(|it| it.start <= to);
            within.for_each(|piece| piece.write(&mut memory));
        }
        Capture { reason, baud: self.baud, memory }
    }
}

/// The captures of a segment in one folder.
#[derive(Clone, Debug)]
pub struct CaptureFolder {
    folder: PathBuf,
    limits: FlightLimits,
}

/// Writes a new file that only its owner may read, as the database: it holds the pressures and parameters of the plant.
fn write_private(path: &Path, octets: &[u8]) -> io::Result<()> {
    profivac_files::open_private(OpenOptions::new().write(true).create_new(true), path)?.write_all(octets)
}

/// The end of the name of a capture.
const EXTENSION: &str = ".pcapng";

/// What follows the name of a capture while it is written.
const PARTIAL: &str = ".part";

impl CaptureFolder {
    /// The folder, which is created with the first capture.
    #[must_use]
    pub const fn new(folder: PathBuf, limits: FlightLimits) -> Self {
        Self { folder, limits }
    }

    /// Writes the [`file`](Capture::file) of a capture as `NAME.pcapng` after it has removed the oldest ones, so that all stay within the
    /// limits. The file appears under its name when it is complete. Nothing of a capture that cannot be written stays. One thread at a time
    /// may store captures.
    ///
    /// # Errors
    /// The error of the operating system: the disk is full, or the folder may not be written.
    pub fn store(&self, name: &str, file: &[u8]) -> io::Result<StoredCapture> {
        fs::create_dir_all(&self.folder)?;
        self.remove_partial()?;
        let octets = file.len() as u64;
        let name = format!("{name}{EXTENSION}");
        let partial = self.folder.join(format!("{name}{PARTIAL}"));
        let stored = write_private(&partial, file)
            .and_then(|()| self.make_room(octets))
            .and_then(|()| fs::rename(&partial, self.path(&name)));
        if let Err(error) = stored {
            // The first error is the one to report; the next capture removes the file as well.
            let _ = fs::remove_file(&partial);
            return Err(error);
        }
        Ok(StoredCapture { name, octets })
    }

    /// Removes files that a program left when it ended while it wrote them.
    fn remove_partial(&self) -> io::Result<()> {
        for entry in fs::read_dir(&self.folder)? {
            let entry = entry?;
            if entry.file_name().to_string_lossy().ends_with(PARTIAL) {
                fs::remove_file(entry.path())?;
            }
        }
        Ok(())
    }

    /// The captures, oldest first: their names begin with their time.
    ///
    /// # Errors
    /// The error of the operating system.
    pub fn list(&self) -> io::Result<Vec<StoredCapture>> {
        let entries = match fs::read_dir(&self.folder) {
            Err(error) if error.kind() == io::ErrorKind::NotFound => return Ok(Vec::new()),
            entries => entries?,
        };
        let mut all = Vec::new();
        for entry in entries {
            let entry = entry?;
            let name = entry.file_name().to_string_lossy().into_owned();
            if name.ends_with(EXTENSION) {
                all.push(StoredCapture { name, octets: entry.metadata()?.len() });
            }
        }
        all.sort_by(|one, other| one.name.cmp(&other.name));
        Ok(all)
    }

    /// The contents of a capture. Only a name of [`list`](Self::list) is a capture: no path leaves the folder.
    ///
    /// # Errors
    /// [`io::ErrorKind::NotFound`] for another name; the error of the operating system.
    pub fn read(&self, name: &str) -> io::Result<Vec<u8>> {
        if !self.list()?.iter().any(|capture| capture.name == name) {
            return Err(io::ErrorKind::NotFound.into());
        }
        fs::read(self.path(name))
    }

    fn path(&self, name: &str) -> PathBuf {
        self.folder.join(Path::new(name))
    }

    /// Removes the oldest captures until one with `octets` fits.
    fn make_room(&self, octets: u64) -> io::Result<()> {
        let all = self.list()?;
        let mut sum = all.iter().fold(octets, |sum, capture| sum.saturating_add(capture.octets));
        let mut count = all.len().saturating_add(1);
        for capture in &all {
            if count <= self.limits.files && sum <= self.limits.disk_octets {
                break;
            }
            fs::remove_file(self.path(&capture.name))?;
            (count, sum) = (count.saturating_sub(1), sum.saturating_sub(capture.octets));
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use profivac_sim::trace::pcapng::read;
    use std::os::unix::fs::PermissionsExt;

    const BAUD: Baud = Baud::B19200;

    fn piece(ms: u64, octets: &[u8], errors: Vec<usize>) -> Piece {
        let kind = if errors.is_empty() { PieceKind::Valid } else { PieceKind::Damaged };
        Piece { start: Some(BitTime(BAUD.tbit_of_ms(ms))), octets: octets.to_vec(), errors, kind }
    }

    fn limits() -> FlightLimits {
        FlightLimits { before_ms: 2000, after_ms: 1000, ..FlightLimits::default() }
    }

    #[test]
    fn a_capture_has_the_time_before_and_after_its_trigger_and_is_read_back() {
        let mut recorder = FlightRecorder::new(BAUD, limits());
        for second in 0..10 {
            recorder.add(&piece(second * 1000, &[0xDC, 2, second as u8], if second == 5 { vec![1] } else { vec![] }));
            if second == 5 {
                recorder.trigger(BitTime(BAUD.tbit_of_ms(5000)), "test");
                recorder.trigger(BitTime(BAUD.tbit_of_ms(5500)), "a second one");
                assert_eq!(
                    recorder.take_capture(BitTime(BAUD.tbit_of_ms(5500))),
                    None,
                    "the time behind it has not passed"
                );
            }
        }
        let capture = recorder.take_capture(BitTime(BAUD.tbit_of_ms(9000))).unwrap();
        assert_eq!(capture.reason, "test");
        let trace = read(&capture.file(), Baud::B9600).unwrap();
        let seconds: Vec<u8> = trace.entries.iter().map(|entry| entry.octets[2]).collect();
        assert_eq!((trace.baud, seconds), (BAUD, vec![3, 4, 5, 6]));
        assert_eq!(trace.entries[2].errors, [1]);
        assert_eq!(recorder.take_capture(BitTime(BAUD.tbit_of_ms(20_000))), None, "one trigger makes one capture");
    }

    #[test]
    fn the_memory_is_bounded_and_the_newest_traffic_stays() {
        let limits = FlightLimits { memory_octets: 4096, ..limits() };
        let mut recorder = FlightRecorder::new(BAUD, limits);
        for number in 0..10_000 {
            recorder.add(&piece(number, &[0xE5; 36], vec![]));
            assert!(recorder.memory_octets() <= 4096);
        }
        let pieces: Vec<Stored> = recorder.blocks.iter().flat_map(|block| Stored::all(&block.memory)).collect();
        assert!(pieces.len() > 50, "{}", pieces.len());
        assert_eq!(pieces.last().unwrap().start, BitTime(BAUD.tbit_of_ms(9999)));
        assert!(pieces.is_sorted_by(|one, next| one.start < next.start));
        assert_eq!(recorder.blocks.len(), 16);
        let [from, to] = [9970, 9990].map(|ms| BitTime(BAUD.tbit_of_ms(ms)));
        let capture = recorder.capture("test".to_owned(), from, to);
        let pieces: Vec<Stored> = Stored::all(&capture.memory).collect();
        assert_eq!((pieces.len(), pieces[0].start, pieces[20].start), (21, from, to));
        assert!(pieces.iter().all(|piece| piece.octets == [0xE5; 36] && piece.error.is_none()));
    }

    /// Memory that is given back and taken again all the time would leave gaps in the heap.
    #[test]
    fn a_full_recorder_keeps_its_memory() {
        let mut recorder = FlightRecorder::new(BAUD, FlightLimits { memory_octets: 4096, ..limits() });
        let places = |recorder: &FlightRecorder| {
            let mut all: Vec<usize> = recorder.blocks.iter().map(|block| block.memory.as_ptr().addr()).collect();
            all.sort_unstable();
            all
        };
        let mut fill = |from: u64| {
            (from..from + 1000).for_each(|number| recorder.add(&piece(number, &[0xE5; 36], vec![])));
            places(&recorder)
        };
        assert_eq!(fill(0), fill(1000));
    }

    #[test]
    fn a_piece_that_is_longer_than_a_block_is_kept() {
        let mut recorder = FlightRecorder::new(BAUD, FlightLimits { memory_octets: 1600, ..limits() });
        for number in 0..100 {
            recorder.add(&piece(number, &[0xE5; 36], vec![]));
        }
        recorder.add(&piece(100, &[7; 249], vec![3]));
        recorder.add(&piece(101, &[8; 1], vec![]));
        let capture = recorder.capture("test".to_owned(), BitTime(BAUD.tbit_of_ms(100)), BitTime(u64::MAX));
        let pieces: Vec<(Option<u16>, &[u8])> = Stored::all(&capture.memory).map(|it| (it.error, it.octets)).collect();
        assert_eq!(pieces, [(Some(3), [7; 249].as_slice()), (None, &[8])]);
        assert!(recorder.memory_octets() <= 1600);
    }

    #[test]
    fn the_folder_keeps_the_newest_captures_within_number_and_size() {
        let folder = tempfile::tempdir().unwrap();
        let limits = FlightLimits { files: 3, disk_octets: 100, ..limits() };
        let captures = CaptureFolder::new(folder.path().join("captures"), limits);
        assert_eq!(captures.list().unwrap(), []);
        let capture = |octets: usize| vec![0; octets];
        let names =
            |captures: &CaptureFolder| captures.list().unwrap().into_iter().map(|it| it.name).collect::<Vec<_>>();
        for number in 1..=5 {
            captures.store(&number.to_string(), &capture(10)).unwrap();
        }
        assert_eq!(names(&captures), ["3.pcapng", "4.pcapng", "5.pcapng"]);
        captures.store("6", &capture(85)).unwrap();
        assert_eq!(names(&captures), ["5.pcapng", "6.pcapng"], "the sum of the sizes");
        assert_eq!(captures.read("5.pcapng").unwrap().len(), 10);
        for other in ["4.pcapng", "../captures/5.pcapng", "/etc/passwd", ""] {
            assert_eq!(captures.read(other).unwrap_err().kind(), io::ErrorKind::NotFound, "{other}");
        }
    }

    #[test]
    fn only_its_owner_may_read_a_capture() {
        let folder = tempfile::tempdir().unwrap();
        let captures = CaptureFolder::new(folder.path().join("captures"), limits());
        let name = captures.store("1", &[0; 10]).unwrap().name;
        let file = fs::metadata(folder.path().join("captures").join(name)).unwrap();
        assert_eq!(file.permissions().mode() & 0o777, 0o600);
    }

    /// A folder stands where the file is to appear, so that it cannot be written.
    #[test]
    fn nothing_stays_of_a_capture_that_cannot_be_written() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("captures");
        let captures = CaptureFolder::new(path.clone(), limits());
        fs::create_dir_all(path.join("1.pcapng")).unwrap();
        let capture = [0; 10];
        assert!(captures.store("1", &capture).is_err());
        let files = || fs::read_dir(&path).unwrap().filter(|it| it.as_ref().unwrap().path().is_file()).count();
        assert_eq!(files(), 0);
        fs::write(path.join("0.pcapng.part"), [0; 1000]).unwrap();
        captures.store("2", &capture).unwrap();
        assert_eq!(files(), 1, "what an ended program left is removed");
    }
}
