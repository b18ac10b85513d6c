//! A parameter that a device file has beyond the device that it is like. No behaviour gives it a meaning: it keeps what a master writes.
//!
//! chosen: its value before the first write is zero, and it survives the power in any store class.

use crate::model::{
    AccessError, AccessPath, Codes, DataType, Direction, Location, Octets, PressureFormat, Quantity, RawValue, Row,
    Value,
};
use crate::store::{self, Key, MAX_STORED, Store};

/// The row, and where it is.
#[derive(Clone, Copy, Debug)]
pub struct KeptRow {
    /// Slot and instance.
    pub location: &'static Location,
    /// The row.
    pub row: &'static Row,
    /// The present unit and number type of a pressure here.
    pub format: PressureFormat,
}

impl KeptRow {
    /// The key of a part of the stored octets.
    fn key(self, part: usize) -> Key {
        let Location { slot, instance, .. } = *self.location;
        let index = self.row.index;
        match u8::try_from(part) {
            Ok(part @ 1..) => Key::Part { slot, instance, index, part },
            _ => Key::Parameter { slot, instance, index },
        }
    }

    /// The number of its octets on the wire.
    #[must_use]
    pub const fn length(self) -> usize {
        self.row.data_type.length(&self.format)
    }

    /// The octets that were written last; a pressure in the present unit.
    ///
    /// # Errors
    /// [`AccessError::NotReadable`], [`AccessError::NotInChannel`].
    pub fn read(self, path: AccessPath, store: &impl Store) -> Result<Octets, AccessError> {
        if !self.row.access.allows(path, Direction::Read) {
            return Err(AccessError::NotReadable);
        }
        let data_type = self.row.data_type;
        if matches!(data_type, DataType::Visible(_)) && path == AccessPath::ParameterChannel {
            return Err(AccessError::NotInChannel);
        }
        let stored = self.stored(store);
        let value = stored.and_then(|octets| data_type.decode_stored(&octets, &self.format));
        Ok(data_type.encode(&value.unwrap_or_else(|| self.first_value()), &self.format))
    }

    /// Zero, or an empty text.
    const fn first_value(self) -> Value {
        match self.row.data_type {
            DataType::ByType => Value::Pressure(0.0),
            DataType::Float => Value::Float(0.0),
            DataType::Visible(_) | DataType::OctetString(_) | DataType::Array(_) | DataType::Record(_) => {
                Value::Octets(Octets::EMPTY)
            }
            _ => Value::Integer(0),
        }
    }

    /// The stored octets of all parts.
    fn stored(self, store: &impl Store) -> Option<Octets> {
        let (mut octets, mut length) = ([0; u8::MAX as usize], 0_usize);
        for part in 0.. {
            let Some(stored) = store::load(store, self.key(part)) else { break };
            octets.get_mut(length..)?.get_mut(..stored.len())?.copy_from_slice(&stored);
            length = length.saturating_add(stored.len());
            if stored.len() < MAX_STORED || length >= self.length() {
                break;
            }
        }
        octets.get(..length).filter(|octets| !octets.is_empty()).map(Octets::new)
    }

    /// Keeps these octets; a pressure whatever the unit becomes.
    ///
    /// # Errors
    /// [`AccessError::NotWritable`], [`AccessError::WrongLength`], [`AccessError::OutOfRange`] for a number that the row does not have,
    /// [`AccessError::StorageFailed`].
    pub fn write(self, path: AccessPath, octets: &[u8], store: &mut impl Store) -> Result<(), AccessError> {
        if !self.row.access.allows(path, Direction::Write) {
            return Err(AccessError::NotWritable);
        }
        if octets.len() != self.length() {
            return Err(AccessError::WrongLength);
        }
        let value = self.row.data_type.decode(octets, &self.format)?;
        if !self.allows(octets) {
            return Err(AccessError::OutOfRange);
        }
        let stored = self.row.data_type.encode_stored(&value, &self.format);
        let key_and_octets = |(part, octets): (usize, &[u8])| (self.key(part), Octets::new(octets));
        let mut parts = stored.chunks(MAX_STORED).enumerate().map(key_and_octets);
        store.save_all(&mut parts).map_err(|_| AccessError::StorageFailed)
    }

    /// Whether the octets are a number of the row's codes, or within its range.
    fn allows(self, octets: &[u8]) -> bool {
        let number = match (self.row.data_type.raw(octets), &self.row.codes) {
            (Ok(RawValue::Integer(number)), _) => number,
            (Ok(RawValue::Float(number)), Codes::Quantity(Quantity { range: Some((low, high)), .. })) => {
                return (*low as f64..=*high as f64).contains(&f64::from(number));
            }
            _ => return true,
        };
        match self.row.codes {
            Codes::Range(lowest, highest) | Codes::PerMille(lowest, highest) => (lowest..=highest).contains(&number),
            Codes::Names(codes) | Codes::Commands(codes) => codes.iter().any(|code| i64::from(code.number) == number),
            Codes::Quantity(quantity) => quantity.range.is_none_or(|(low, high)| (low..=high).contains(&number)),
            Codes::Plain | Codes::Bits(_) | Codes::Units | Codes::BitCommands(_) | Codes::Version => true,
        }
    }
}
