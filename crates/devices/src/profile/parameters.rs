//! The access to parameters for DP-V1 and for the parameter channel. Access rights, length, mode and type are checked
//! here against the row, before the code of the device runs: errata-bpg-bcg-tpg 23.

use super::address::StationAddress;
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

/// Every nonvolatile value that differs between `before` and `after`, and the one that was `written` even if it does not, as they
/// are stored.
fn changes<B: Behaviour>(before: &B, after: &B, written: Option<Key>) -> impl Iterator<Item = (Key, Octets)> {
    let parameters = stored::<B::Parameter>(after.model().blocks).filter_map(move |at| {
        let (key, value) = (after.storage_key(&at), after.stored_value(&at));
        let is_changed = value != before.stored_value(&at) || written == Some(key);
        is_changed.then(|| (key, at.row.data_type.encode_stored(&value, &after.format(&at))))
    });
    let internal = before.internal_values().iter().zip(after.internal_values());
    let changed = (0..).zip(internal).filter(|(_, (old, new))| old.to_bits() != new.to_bits());
    let internal = changed.map(|(number, (_, new))| (Key::Internal(number), Octets::new(&new.to_be_bytes())));
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

    /// Changes the device. A change that cannot be stored is undone.
    fn change(&mut self, at: &ParameterRef<B::Parameter>, value: &Value) -> Result<(), AccessError> {
        let before = self.behaviour.clone();
        let result = self.behaviour.set(at, value);
        self.behaviour.update();
        result?;
        let unlocked = self.address.unlocked().filter(|_| self.behaviour.resets_to_factory(at, value));
        let written = Some(self.behaviour.storage_key(at));
        let stored = self.store_differences(&before, written, unlocked.as_ref().map(StationAddress::entry));
        match (stored, unlocked) {
            (Err(_), _) => self.behaviour = before,
            (Ok(()), Some(unlocked)) => self.address = unlocked,
            (Ok(()), None) => {}
        }
        stored
    }

    /// Stores every nonvolatile value that differs from `before`, the one that was `written` even if it does not, and the
    /// address if there is one: all of them or none.
    pub(super) fn store_differences(
        &mut self,
        before: &B,
        written: Option<Key>,
        address: Option<(Key, Octets)>,
    ) -> Result<(), AccessError> {
        let Self { behaviour, store, .. } = self;
        let values = || changes(before, behaviour, written).chain(address);
        let is_stored = |(key, octets): (Key, Octets)| store::load(store, key).as_deref() == Some(octets.as_slice());
        if values().all(is_stored) {
            return Ok(());
        }
        store.save_all(&mut values()).map_err(|_| AccessError::StorageFailed)
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
