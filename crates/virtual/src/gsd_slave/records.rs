//! The DP-V1 records and the address of a virtual slave, in the nonvolatile memory of the virtual devices.
//!
//! A stored value has at most [`MAX_STORED`] octets, and a record more. So the instance of a key counts the parts of a record. A part that
//! is shorter than the others, or empty, is the last.

use super::plan::MAX_RECORD;
use crate::nonvolatile::NonvolatileMemory;
use profivac_devices::model::Octets;
use profivac_devices::store::{Key, MAX_STORED, Store, StoreError};
use std::collections::BTreeMap;

/// The number of parts of the longest record, and the empty one behind it.
const MAX_PARTS: u8 = 16;

/// The records by slot and index.
pub(super) struct Records {
    memory: NonvolatileMemory,
    records: BTreeMap<(u8, u8), Vec<u8>>,
}

impl Records {
    /// The records in a memory.
    pub(super) fn new(memory: NonvolatileMemory) -> Self {
        let places = memory.keys().filter_map(|key| match key {
            Key::Parameter { slot, instance: 0, index } => Some((slot, index)),
            _ => None,
        });
        let records = places.map(|place| (place, record_of(&memory, place))).collect();
        Self { memory, records }
    }

    pub(super) fn get(&self, slot: u8, index: u8) -> Option<&[u8]> {
        self.records.get(&(slot, index)).map(Vec::as_slice)
    }

    pub(super) fn iter(&self) -> impl Iterator<Item = ((u8, u8), &[u8])> {
        self.records.iter().map(|(place, octets)| (*place, octets.as_slice()))
    }

    /// Stores a record of at most 240 octets.
    ///
    /// # Errors
    /// [`StoreError`]; nothing has changed then.
    pub(super) fn set(&mut self, slot: u8, index: u8, octets: &[u8]) -> Result<(), StoreError> {
        if octets.len() > MAX_RECORD {
            return Err(StoreError);
        }
        let parts = (0..MAX_PARTS).zip(octets.chunks(MAX_STORED).chain([&[][..]]));
        let mut values = parts.map(|(instance, part)| (Key::Parameter { slot, instance, index }, Octets::new(part)));
        self.memory.save_all(&mut values)?;
        self.records.insert((slot, index), octets.to_vec());
        Ok(())
    }

    /// The address that Set_Slave_Add has stored, and whether it is locked.
    pub(super) fn address(&self) -> Option<(u8, bool)> {
        match part_of(&self.memory, Key::Address)[..] {
            [address @ 0..=125, locked] => Some((address, locked != 0)),
            _ => None,
        }
    }

    /// Stores the address.
    ///
    /// # Errors
    /// [`StoreError`]; nothing has changed then.
    pub(super) fn set_address(&mut self, address: u8, is_locked: bool) -> Result<(), StoreError> {
        self.memory.save(Key::Address, &[address, is_locked.into()])
    }
}

fn record_of(memory: &NonvolatileMemory, (slot, index): (u8, u8)) -> Vec<u8> {
    let mut record = Vec::new();
    for instance in 0..MAX_PARTS {
        let part = part_of(memory, Key::Parameter { slot, instance, index });
        record.extend_from_slice(&part);
        if part.len() < MAX_STORED {
            break;
        }
    }
    record.truncate(MAX_RECORD);
    record
}

fn part_of(memory: &NonvolatileMemory, key: Key) -> Vec<u8> {
    let mut octets = [0; MAX_STORED];
    let length = memory.load(key, &mut octets).unwrap_or(0);
    octets.get(..length).unwrap_or_default().to_vec()
}
