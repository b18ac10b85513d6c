//! What the edge node knows after a restart: a small file beside the database.

use profivac_recorder::Micros;
use serde::{Deserialize, Serialize};
use std::fs::File;
use std::io::Write;
use std::path::{Path, PathBuf};

/// The file, as JSON.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
struct Kept {
    /// The number of the last CONNECT.
    bd_seq: Option<u8>,
    /// All samples up to this time were delivered, in microseconds since 1970.
    delivered_us: Option<i64>,
}

/// The memory of the edge node.
#[derive(Debug)]
pub struct Memory {
    path: PathBuf,
    kept: Kept,
}

impl Memory {
    /// Reads the file. Without it the edge node has never been connected; a file that is damaged is the same, with a sentence.
    #[must_use]
    pub fn read(path: PathBuf) -> (Self, Option<String>) {
        let (kept, problem) = match std::fs::read(&path) {
            Ok(text) => match serde_json::from_slice(&text) {
                Ok(kept) => (kept, None),
                Err(error) => (Kept::default(), Some(without_memory(&path, &error.to_string()))),
            },
            Err(error) if error.kind() == std::io::ErrorKind::NotFound => (Kept::default(), None),
            Err(error) => (Kept::default(), Some(without_memory(&path, &error.to_string()))),
        };
        (Self { path, kept }, problem)
    }

    /// The number of the next CONNECT: one more than the last, from 0 to 255 (tck-id-topics-nbirth-bdseq-increment,
    /// tck-id-message-flow-edge-node-birth-publish-will-message-payload-bdSeq). It is kept before it is used.
    ///
    /// # Errors
    /// The error of the operating system; the number holds.
    pub fn next_bd_seq(&mut self) -> (u8, std::io::Result<()>) {
        let number = self.kept.bd_seq.map_or(0, |last| last.wrapping_add(1));
        self.kept.bd_seq = Some(number);
        (number, self.write())
    }

    /// The time up to which all samples were delivered; `None` before the first connection.
    #[must_use]
    pub fn delivered(&self) -> Option<Micros> {
        self.kept.delivered_us.map(Micros)
    }

    /// The samples up to `at` were delivered.
    ///
    /// # Errors
    /// The error of the operating system.
    pub fn deliver(&mut self, at: Micros) -> std::io::Result<()> {
        self.kept.delivered_us = Some(at.0);
        self.write()
    }

    /// Replaces the file as a whole or not at all, also at a power cut. It waits for the disk; the gateway has a thread of its own.
    fn write(&self) -> std::io::Result<()> {
        let new = self.path.with_extension("sparkplug.new");
        let mut file = File::create(&new)?;
        file.write_all(&serde_json::to_vec(&self.kept)?)?;
        file.sync_all()?;
        std::fs::rename(new, &self.path)
    }
}

fn without_memory(path: &Path, error: &str) -> String {
    format!(
        "{}: {error}; the edge node continues without it: bdSeq begins at 0, and samples of an outage are not sent",
        path.display()
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bd_seq_goes_on_after_a_restart_and_wraps_after_255() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("hall.sparkplug");
        let (mut memory, problem) = Memory::read(path.clone());
        assert_eq!((problem, memory.delivered()), (None, None));
        let numbers: Vec<u8> = (0..3).map(|_| memory.next_bd_seq().0).collect();
        assert_eq!(numbers, [0, 1, 2]);
        memory.deliver(Micros(5)).unwrap();
        let (mut memory, _) = Memory::read(path.clone());
        assert_eq!((memory.next_bd_seq().0, memory.delivered()), (3, Some(Micros(5))));
        std::fs::write(&path, "{\"bd_seq\":255,\"delivered_us\":7}").unwrap();
        assert_eq!(Memory::read(path).0.next_bd_seq().0, 0);
    }

    #[test]
    fn a_damaged_file_is_reported_and_does_not_stop_the_edge_node() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("hall.sparkplug");
        std::fs::write(&path, "{").unwrap();
        let (mut memory, problem) = Memory::read(path);
        assert!(problem.unwrap().contains("hall.sparkplug"));
        assert_eq!(memory.next_bd_seq().0, 0);
    }
}
