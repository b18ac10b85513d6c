//! The access to parameters for DP-V1 and for the parameter channel. Access rights, length, mode and type are checked
//! here against the row, before the code of the device runs: errata-bpg-bcg-tpg 23.

use super::address::StationAddress;
use super::behaviour::Behaviour;
use super::device::BlockDevice;
#[cfg(feature = "texts")]
use super::kept_row::KeptRow;
use super::parameter_access::ParameterRef;
use crate::model::{
    AccessError, AccessPath, DESCRIBED, DataType, Direction, Octets, ParameterSet, PlacedBlock, Row, Value,
};
#[cfg(feature = "texts")]
use crate::model::{Counts, Location, NumberType, PressureFormat};
use crate::store::{self, Key, Store};
use core::marker::PhantomData;

/// The parameter of a row. A device file can have a number where the device that it is like has a text, or a pressure where it has a
/// number: what the behaviour says there is no value of such a row, so it is none of its parameters.
fn parameter_of<P: ParameterSet>(position: usize, row: &Row) -> Option<P> {
    let parameter = P::of(position, row.index)?;
    if DESCRIBED {
        let own = P::BLOCKS.get(position).and_then(|placed| placed.block.row(row.index));
        own.is_none_or(|own| own.data_type.is_alike(row.data_type)).then_some(parameter)
    } else {
        Some(parameter)
    }
}

/// Finds the parameter at slot and index.
fn locate<B: Behaviour>(behaviour: &B, slot: u8, index: u8) -> Result<ParameterRef<B::Parameter>, AccessError> {
    let mut error = AccessError::UnknownSlot;
    for (position, placed) in behaviour.model().blocks.iter().enumerate() {
        for location in placed.locations.iter().filter(|location| location.slot == slot) {
            error = AccessError::UnknownIndex;
            if let Some(row) = placed.block.row(index)
                && let Some(parameter) = parameter_of(position, row)
                && behaviour.is_visible(location)
            {
                let at = ParameterRef { location, row, parameter };
                if !DESCRIBED || behaviour.has_value(&at) {
                    return Ok(at);
                }
            }
        }
    }
    Err(error)
}

/// Every parameter whose value is stored when a master writes it, at every instance: the rows of each location of each block.
///
/// A chain of `flat_map` and `filter` has the same items and takes four times the octets of a program.
struct StoredParameters<P> {
    blocks: &'static [PlacedBlock],
    block: usize,
    location: usize,
    row: usize,
    parameters: PhantomData<P>,
}

impl<P> StoredParameters<P> {
    const fn new(blocks: &'static [PlacedBlock]) -> Self {
        Self { blocks, block: 0, location: 0, row: 0, parameters: PhantomData }
    }
}

impl<P: ParameterSet> Iterator for StoredParameters<P> {
    type Item = ParameterRef<P>;

    fn next(&mut self) -> Option<ParameterRef<P>> {
        loop {
            let placed = self.blocks.get(self.block)?;
            let Some(location) = placed.locations.get(self.location) else {
                (self.block, self.location) = (self.block.wrapping_add(1), 0);
                continue;
            };
            let Some(row) = placed.block.rows.get(self.row) else {
                (self.location, self.row) = (self.location.wrapping_add(1), 0);
                continue;
            };
            self.row = self.row.wrapping_add(1);
            if row.is_stored()
                && let Some(parameter) = parameter_of(self.block, row)
            {
                return Some(ParameterRef { location, row, parameter });
            }
        }
    }
}

/// Every nonvolatile value that differs between `before` and `after`, the one that was `written` even if it does not, and the
/// address if there is one, as they are stored.
struct Changes<'a, B: Behaviour> {
    before: &'a B,
    after: &'a B,
    written: Option<Key>,
    parameters: StoredParameters<B::Parameter>,
    /// The number of the next internal value.
    internal: u8,
    address: Option<(Key, Octets)>,
}

impl<B: Behaviour> Iterator for Changes<'_, B> {
    type Item = (Key, Octets);

    fn next(&mut self) -> Option<(Key, Octets)> {
        self.parameter().or_else(|| self.internal_value()).or_else(|| self.address.take())
    }
}

impl<B: Behaviour> Changes<'_, B> {
    fn parameter(&mut self) -> Option<(Key, Octets)> {
        let (before, after) = (self.before, self.after);
        for at in self.parameters.by_ref() {
            if DESCRIBED && !after.has_value(&at) {
                continue;
            }
            let (key, value) = (after.storage_key(&at), after.stored_value(&at));
            if value != before.stored_value(&at) || self.written == Some(key) {
                return Some((key, at.row.data_type.encode_stored(&value, &after.format(&at))));
            }
        }
        None
    }

    fn internal_value(&mut self) -> Option<(Key, Octets)> {
        loop {
            let number = self.internal;
            let old = self.before.internal_values().get(usize::from(number))?;
            let new = self.after.internal_values().get(usize::from(number))?;
            self.internal = number.wrapping_add(1);
            if old.to_bits() != new.to_bits() {
                return Some((Key::Internal(number), Octets::new(&new.to_be_bytes())));
            }
        }
    }
}

impl<B: Behaviour, S: Store> BlockDevice<B, S> {
    /// Reads a parameter.
    pub(super) fn get(&self, path: AccessPath, slot: u8, index: u8) -> Result<Octets, AccessError> {
        let at = match locate(&self.behaviour, slot, index) {
            #[cfg(feature = "texts")]
            Err(AccessError::UnknownIndex) => return self.kept(slot, index)?.read(path, &self.store),
            located => located?,
        };
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
        let at = match locate(&self.behaviour, slot, index) {
            #[cfg(feature = "texts")]
            Err(AccessError::UnknownIndex) => return self.kept(slot, index)?.write(path, octets, &mut self.store),
            located => located?,
        };
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
        let at = match locate(&self.behaviour, slot, index) {
            #[cfg(feature = "texts")]
            Err(AccessError::UnknownIndex) => return self.kept(slot, index).ok().map(|row| row.length()),
            located => located.ok()?,
        };
        Some(at.row.data_type.length(&self.behaviour.format(&at)))
    }

    /// The row of a device file at slot and index that the behaviour does not have. Firmware has no device files.
    #[cfg(feature = "texts")]
    fn kept(&self, slot: u8, index: u8) -> Result<KeptRow, AccessError> {
        let behaviour = &self.behaviour;
        let found = behaviour.model().blocks.iter().find_map(|placed| {
            let is_here = |location: &&Location| location.slot == slot && behaviour.is_visible(location);
            Some((placed.locations.iter().find(is_here)?, placed.block.row(index)?))
        });
        let (location, row) = found.ok_or(AccessError::UnknownIndex)?;
        Ok(KeptRow { location, row, format: self.pressure_format(location).ok_or(AccessError::UnknownIndex)? })
    }

    /// The format of pressures at this location: of a pressure there that the behaviour has, else of another one.
    #[cfg(feature = "texts")]
    fn pressure_format(&self, location: &Location) -> Option<PressureFormat> {
        let model = self.behaviour.model();
        let all = model.blocks.iter().enumerate().flat_map(|(position, placed)| {
            let rows = placed.block.rows.iter().filter(|row| row.data_type == DataType::ByType);
            rows.flat_map(move |row| placed.locations.iter().map(move |location| (position, row, location)))
        });
        let mut pressures = all.filter_map(|(position, row, location)| {
            Some(ParameterRef { location, row, parameter: parameter_of::<B::Parameter>(position, row)? })
        });
        let here = pressures.clone().find(|at| at.location.is_at(location));
        let known = here.or_else(|| pressures.next()).map(|at| self.behaviour.format(&at));
        known.or_else(|| {
            let (unit, counts) = (model.units.first()?, Counts::Linear { per_mbar: 1.0 });
            Some(PressureFormat { unit, number: NumberType::Float, counts, max_integer: model.max_integer })
        })
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
        let values = || Changes {
            before,
            after: behaviour,
            written,
            parameters: StoredParameters::new(behaviour.model().blocks),
            internal: 0,
            address,
        };
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
        for at in StoredParameters::<B::Parameter>::new(behaviour.model().blocks) {
            if DESCRIBED && !behaviour.has_value(&at) {
                continue;
            }
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
