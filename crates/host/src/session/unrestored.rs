//! Records that a client changed for a moment and that still have this value, because the line was lost.

use super::BusSession;
use std::collections::BTreeMap;

/// A record of one octet that a client changed for a moment and could not set back because the line was lost.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct UnrestoredRecord {
    /// The slot.
    pub slot: u8,
    /// The index.
    pub index: u8,
    /// The value that the client wrote.
    pub written: u8,
    /// The value before.
    pub original: u8,
}

impl BusSession {
    /// Keeps a record of the slave at `address` that could not be set back, for the next client of this slave.
    pub fn keep_unrestored(&mut self, address: u8, record: UnrestoredRecord) {
        self.unrestored.insert(address, record);
    }

    /// Takes the record that [`keep_unrestored`](Self::keep_unrestored) kept for the slave at `address`.
    pub fn take_unrestored(&mut self, address: u8) -> Option<UnrestoredRecord> {
        self.unrestored.remove(&address)
    }

    /// Takes all kept records by address. A program that opens a new session on the same line hands them over to it.
    pub fn take_all_unrestored(&mut self) -> BTreeMap<u8, UnrestoredRecord> {
        std::mem::take(&mut self.unrestored)
    }
}
