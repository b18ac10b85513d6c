//! The access to parameters for DP-V1 and for the parameter channel. Access rights, length, mode and type are checked
//! here against the row, before the code of the device runs: errata-bpg-bcg-tpg 23.

use super::behaviour::Behaviour;
use super::device::BlockDevice;
use super::parameter_access::ParameterRef;
use crate::model::{AccessError, AccessPath, DataType, Direction, Octets, ParameterSet, PlacedBlock, Value};
use crate::store::{self, Key, Store};

/// Finds the parameter at slot and index.
fn locate<B: Behaviour>(behaviour: &B, slot: u8, index: u8) -> Result<ParameterRef<B::Parameter>, AccessError> {
    let mut error = AccessError::UnknownSlot;
    for (position, placed) in behaviour.model().blocks.iter().enumerate() {
        for location in placed.locations.iter().filter(|location| location.slot == slot) {
            error = AccessError::UnknownIndex;
            if let (Some(row), Some(parameter)) = (placed.block.row(index), B::Parameter::of(position, index))
                && behaviour.is_visible(location)
            {
                return Ok(ParameterRef { location, row, parameter });
            }
        }
    }
    Err(error)
}

/// Every parameter whose value is stored when a master writes it, at every instance.
fn stored<P: ParameterSet>(blocks: &'static [PlacedBlock]) -> impl Iterator<Item = ParameterRef<P>> {
    blocks.iter().enumerate().flat_map(|(position, placed)| {
        placed.locations.iter().flat_map(move |location| {
            placed.block.rows.iter().filter(|row| row.is_stored()).filter_map(move |row| {
                P::of(position, row.index).map(|parameter| ParameterRef { location, row, parameter })
            })
        })
    })
}

/// A nonvolatile value before and after a change, as it is stored.
struct StoredChange {
    key: Key,
    before: Octets,
    after: Octets,
}

/// The values that are stored although they did not change.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum AlsoStored {
    None,
    /// The value that the master wrote.
    Written(Key),
    All,
}

impl AlsoStored {
    fn contains(self, key: Key) -> bool {
        match self {
            Self::None => false,
            Self::Written(written) => written == key,
            Self::All => true,
        }
    }
}

/// Every nonvolatile value that differs between `before` and `after`, and those that `also` contains.
fn changes<B: Behaviour>(before: &B, after: &B, also: AlsoStored) -> impl Iterator<Item = StoredChange> {
    let parameters = stored::<B::Parameter>(after.model().blocks).filter_map(move |at| {
        let (key, old, new) = (after.storage_key(&at), before.stored_value(&at), after.stored_value(&at));
        let encode = |value, of: &B| at.row.data_type.encode_stored(value, &of.format(&at));
        (old != new || also.contains(key)).then(|| StoredChange {
            key,
            before: encode(&old, before),
            after: encode(&new, after),
        })
    });
    let internal = (0..).zip(before.internal_values().iter().zip(after.internal_values()));
    let internal = internal.filter_map(move |(number, (old, new))| {
        let key = Key::Internal(number);
        (old.to_bits() != new.to_bits() || also.contains(key)).then(|| StoredChange {
            key,
            before: Octets::new(&old.to_be_bytes()),
            after: Octets::new(&new.to_be_bytes()),
        })
    });
    parameters.chain(internal)
}

impl<B: Behaviour, S: Store> BlockDevice<B, S> {
    /// Reads a parameter.
    pub(super) fn get(&self, path: AccessPath, slot: u8, index: u8) -> Result<Octets, AccessError> {
        let at = locate(&self.behaviour, slot, index)?;
        if !at.row.access.allows(path, Direction::Read) {
            return Err(AccessError::NotReadable);
        }
        if path == AccessPath::ParameterChannel && matches!(at.row.data_type, DataType::Visible(_)) {
            return Err(AccessError::NotInChannel);
        }
        Ok(at.row.data_type.encode(&self.behaviour.get(&at), &self.behaviour.format(&at)))
    }

    /// Writes a parameter. `Ok` means that a nonvolatile value is stored.
    pub(super) fn set(&mut self, path: AccessPath, slot: u8, index: u8, octets: &[u8]) -> Result<(), AccessError> {
        let at = locate(&self.behaviour, slot, index)?;
        if !at.row.access.allows(path, Direction::Write) {
            return Err(AccessError::NotWritable);
        }
        let format = self.behaviour.format(&at);
        if octets.len() != at.row.data_type.length(&format) {
            return Err(AccessError::WrongLength);
        }
        self.behaviour.check_mode(&at)?;
        let value = at.row.data_type.decode(octets, &format)?;
        self.change(&at, &value)
    }

    /// The length of a parameter; `None` if there is none at this slot and index.
    pub(super) fn length(&self, slot: u8, index: u8) -> Option<usize> {
        let at = locate(&self.behaviour, slot, index).ok()?;
        Some(at.row.data_type.length(&self.behaviour.format(&at)))
    }

    /// Changes the device. A change that cannot be stored is undone, in the device and in the memory.
    fn change(&mut self, at: &ParameterRef<B::Parameter>, value: &Value) -> Result<(), AccessError> {
        let before = self.behaviour.clone();
        let result = self.behaviour.set(at, value);
        self.behaviour.update();
        result?;
        let mut stored = self.store_differences(&before, Some(self.behaviour.storage_key(at)));
        if self.behaviour.resets_to_factory(at, value) {
            stored = stored.and_then(|()| self.address.unlock(&mut self.store));
        }
        if stored.is_err() {
            let failed = core::mem::replace(&mut self.behaviour, before);
            self.undo_differences(&failed);
        }
        stored
    }

    /// Stores every nonvolatile value that differs from `before`, and the one that was `written` even if it does not.
    pub(super) fn store_differences(&mut self, before: &B, written: Option<Key>) -> Result<(), AccessError> {
        let Self { behaviour, store, store_is_behind, .. } = self;
        let also = match written {
            _ if *store_is_behind => AlsoStored::All,
            Some(key) => AlsoStored::Written(key),
            None => AlsoStored::None,
        };
        // A value that several instances share is saved once: the others find it stored.
        for StoredChange { key, after, .. } in changes(before, behaviour, also) {
            if store::load(store, key).as_deref() != Some(after.as_slice()) {
                store.save(key, &after).map_err(|_| AccessError::StorageFailed)?;
            }
        }
        *store_is_behind = false;
        Ok(())
    }

    /// Stores the old values again where the memory has those of a change that `failed`. If that fails too, the next change
    /// stores all values.
    fn undo_differences(&mut self, failed: &B) {
        let Self { behaviour, store, store_is_behind, .. } = self;
        for StoredChange { key, before, after } in changes(behaviour, failed, AlsoStored::None) {
            if store::load(store, key).as_deref() == Some(after.as_slice()) && store.save(key, &before).is_err() {
                *store_is_behind = true;
            }
        }
    }

    /// Restores the stored values; values that the parameter cannot have are ignored.
    pub(super) fn restore(&mut self) {
        Self::restore_values(&mut self.behaviour, &self.store, &mut |_| {});
    }

    /// Restores the stored values to a behaviour that has started. Calls `refused` with the key of each value that its
    /// parameter cannot have: another device stored it, and the factory value stays.
    pub(super) fn restore_values(behaviour: &mut B, store: &S, refused: &mut dyn FnMut(Key)) {
        for at in stored::<B::Parameter>(behaviour.model().blocks) {
            let key = behaviour.storage_key(&at);
            let Some(octets) = store::load(store, key) else { continue };
            let format = behaviour.format(&at);
            let value = at.row.data_type.decode_stored(&octets, &format);
            if value.is_none_or(|value| behaviour.restore(&at, &value).is_err()) {
                refused(key);
            }
        }
        for (number, internal) in (0..).zip(behaviour.internal_values_mut()) {
            let Some(octets) = store::load(store, Key::Internal(number)) else { continue };
            match octets.as_slice().try_into().map(f64::from_be_bytes) {
                Ok(value) if value.is_finite() => *internal = value,
                _ => refused(Key::Internal(number)),
            }
        }
    }
}
