//! The nonvolatile memory of a device: octets under a key.

use crate::model::Octets;
use core::fmt;

/// The key of a stored value.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum Key {
    /// A parameter of the tables. Instance 0 means all instances, or the only one.
    Parameter {
        /// Its slot.
        slot: u8,
        /// The instance in the slot.
        instance: u8,
        /// Its index.
        index: u8,
    },
    /// A further part of the octets of a parameter that are more than [`MAX_STORED`]. The first part is under its [`Key::Parameter`].
    Part {
        /// Its slot.
        slot: u8,
        /// The instance in the slot.
        instance: u8,
        /// Its index.
        index: u8,
        /// The number of the part, 1 to 15.
        part: u8,
    },
    /// The station address.
    Address,
    /// A value without an index: an adjustment, run hours.
    Internal(u8),
}

impl Key {
    /// The key as a number of 32 bits, for a memory that stores it. Each key has its own; the two high bits name the kind.
    #[must_use]
    pub const fn to_u32(self) -> u32 {
        match self {
            Self::Parameter { slot, instance, index } => u32::from_be_bytes([0, slot, instance, index]),
            Self::Part { slot, instance, index, part } => {
                u32::from_be_bytes([PART_KEY | (part & PARTS), slot, instance, index])
            }
            Self::Address => ADDRESS_KEY,
            Self::Internal(number) => u32::from_be_bytes([INTERNAL_KEY, 0, 0, number]),
        }
    }

    /// The key of this number; `None` if no key has it.
    #[must_use]
    pub const fn from_u32(number: u32) -> Option<Self> {
        match number.to_be_bytes() {
            [0, slot, instance, index] => Some(Self::Parameter { slot, instance, index }),
            [INTERNAL_KEY, 0, 0, number] => Some(Self::Internal(number)),
            [first @ 0xC1..=0xCF, slot, instance, index] => {
                Some(Self::Part { slot, instance, index, part: first & PARTS })
            }
            _ if number == ADDRESS_KEY => Some(Self::Address),
            _ => None,
        }
    }
}

/// The number of [`Key::Address`].
const ADDRESS_KEY: u32 = 0x4000_0000;

/// The first octet of the number of a [`Key::Internal`].
const INTERNAL_KEY: u8 = 0x80;

/// The high bits of the first octet of the number of a [`Key::Part`]; the low ones are the number of the part.
const PART_KEY: u8 = 0xC0;
const PARTS: u8 = 0x0F;

/// The memory did not store the values. It still has all old values.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct StoreError;

impl fmt::Display for StoreError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("the memory did not store the values")
    }
}

impl core::error::Error for StoreError {}

/// Nonvolatile memory.
pub trait Store {
    /// Copies the value under `key` to the front of `octets` and returns its length; `None` if there is none or
    /// `octets` is too short for it.
    fn load(&self, key: Key, octets: &mut [u8]) -> Option<usize>;

    /// Stores all these values, or none of them. `Ok` guarantees that they survive a power cut at any later instant; a cut
    /// before that leaves all the old values or all the new ones.
    ///
    /// A memory that takes longer than a slave may take for an answer belongs to an
    /// [`Application`](crate::profile::beside::Application): the slave answers meanwhile, and the acyclic response waits.
    ///
    /// One write of a master may change many values, a factory reset nearly all. A key may come twice, with the same value.
    ///
    /// # Errors
    /// [`StoreError`] when one of them could not be stored: a value of more than [`MAX_STORED`] octets, a full or a broken
    /// memory.
    fn save_all(&mut self, values: &mut dyn Iterator<Item = (Key, Octets)>) -> Result<(), StoreError>;

    /// Stores `octets` under `key`.
    ///
    /// # Errors
    /// As [`save_all`](Self::save_all).
    fn save(&mut self, key: Key, octets: &[u8]) -> Result<(), StoreError> {
        self.save_all(&mut core::iter::once((key, Octets::new(octets))))
    }
}

/// The longest value that a [`Store`] must hold, in octets.
pub const MAX_STORED: usize = 16;

/// A store in RAM for up to `ENTRIES` keys. It keeps its values while the simulated power is off, not after the program
/// has ended.
#[derive(Clone, Debug)]
pub struct RamStore<const ENTRIES: usize = 96> {
    entries: [Option<(Key, Stored)>; ENTRIES],
}

/// The value of an entry.
#[derive(Clone, Copy, Debug)]
struct Stored {
    length: usize,
    octets: [u8; MAX_STORED],
}

impl Stored {
    fn new(octets: &[u8]) -> Option<Self> {
        let mut copy = [0; MAX_STORED];
        copy.get_mut(..octets.len())?.copy_from_slice(octets);
        Some(Self { length: octets.len(), octets: copy })
    }
}

impl<const ENTRIES: usize> Default for RamStore<ENTRIES> {
    fn default() -> Self {
        Self { entries: [None; ENTRIES] }
    }
}

impl<const ENTRIES: usize> Store for RamStore<ENTRIES> {
    fn load(&self, key: Key, octets: &mut [u8]) -> Option<usize> {
        let (_, stored) = self.entries.iter().flatten().find(|(other, _)| *other == key)?;
        octets.get_mut(..stored.length)?.copy_from_slice(stored.octets.get(..stored.length)?);
        Some(stored.length)
    }

    fn save_all(&mut self, values: &mut dyn Iterator<Item = (Key, Octets)>) -> Result<(), StoreError> {
        let before = self.entries;
        for (key, octets) in values {
            if self.put(key, &octets).is_err() {
                self.entries = before;
                return Err(StoreError);
            }
        }
        Ok(())
    }
}

impl<const ENTRIES: usize> RamStore<ENTRIES> {
    fn put(&mut self, key: Key, octets: &[u8]) -> Result<(), StoreError> {
        let stored = Stored::new(octets).ok_or(StoreError)?;
        let of_key = |entry: &Option<(Key, Stored)>| entry.is_some_and(|(other, _)| other == key);
        let position = self.entries.iter().position(of_key).or_else(|| self.entries.iter().position(Option::is_none));
        let entry = position.and_then(|position| self.entries.get_mut(position)).ok_or(StoreError)?;
        *entry = Some((key, stored));
        Ok(())
    }
}

/// The value under `key`.
pub(crate) fn load(store: &impl Store, key: Key) -> Option<Octets> {
    let mut octets = [0; MAX_STORED];
    let length = store.load(key, &mut octets)?;
    octets.get(..length).map(Octets::new)
}

#[cfg(test)]
mod tests {
    use super::*;

    const FIRST: Key = Key::Parameter { slot: 1, instance: 2, index: 39 };
    const SECOND: Key = Key::Internal(0);

    #[test]
    fn a_store_loads_the_value_that_was_saved_last() {
        let mut store = RamStore::<2>::default();
        let mut octets = [0; MAX_STORED];
        assert_eq!(store.load(FIRST, &mut octets), None);
        assert_eq!(store.save(FIRST, &[1, 2, 3]), Ok(()));
        assert_eq!(store.save(SECOND, &[9]), Ok(()));
        assert_eq!(store.save(FIRST, &[4, 5]), Ok(()));
        assert_eq!(store.load(FIRST, &mut octets), Some(2));
        assert_eq!(octets[..2], [4, 5]);
        assert_eq!(store.load(SECOND, &mut octets), Some(1));
    }

    #[test]
    fn a_key_and_its_number_convert_both_ways() {
        let parameter = Key::Parameter { slot: 255, instance: 255, index: 255 };
        let [part, last] = [1, 15].map(|part| Key::Part { slot: 255, instance: 255, index: 255, part });
        for key in [FIRST, parameter, part, last, Key::Address, Key::Internal(0), Key::Internal(255)] {
            assert_eq!(Key::from_u32(key.to_u32()), Some(key));
        }
        for number in [0x0100_0000, 0x4000_0001, 0x8000_0100, 0x8001_0000, 0xC000_0000, 0xD000_0000, u32::MAX] {
            assert_eq!(Key::from_u32(number), None, "{number:#x}");
        }
    }

    #[test]
    fn a_full_store_keeps_its_values() {
        let mut store = RamStore::<1>::default();
        assert_eq!(store.save(FIRST, &[1]), Ok(()));
        assert_eq!(store.save(SECOND, &[2]), Err(StoreError));
        assert_eq!(store.save(FIRST, &[0; MAX_STORED + 1]), Err(StoreError));
        assert_eq!(store.load(FIRST, &mut [0; 0]), None);
        let mut octets = [0; 1];
        assert_eq!(store.load(FIRST, &mut octets), Some(1));
        assert_eq!(octets, [1]);
    }

    #[test]
    fn values_are_stored_together_or_not_at_all() {
        let mut store = RamStore::<2>::default();
        assert_eq!(store.save(FIRST, &[1]), Ok(()));
        let [first, second] = [(FIRST, Octets::new(&[2])), (SECOND, Octets::new(&[3]))];
        let too_many = [first, second, (Key::Address, Octets::new(&[4]))];
        assert_eq!(store.save_all(&mut too_many.into_iter()), Err(StoreError));
        assert_eq!((load(&store, FIRST), load(&store, SECOND)), (Some(Octets::new(&[1])), None));
        assert_eq!(store.save_all(&mut [first, second, first].into_iter()), Ok(()));
        assert_eq!((load(&store, FIRST), load(&store, SECOND)), (Some(first.1), Some(second.1)));
    }
}
