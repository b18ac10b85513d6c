//! The parameters of a device: from a row of its tables to the value.

use crate::model::{AccessError, Location, ParameterSet, PressureFormat, Row, Value};
use crate::store::Key;

/// A parameter that was found in the tables.
#[derive(Clone, Copy, Debug)]
pub struct ParameterRef<P> {
    /// Slot and instance.
    pub location: &'static Location,
    /// Its row in the table.
    pub row: &'static Row,
    /// The variant of the device's parameter enum.
    pub parameter: P,
}

impl<P> ParameterRef<P> {
    /// The instance, 0 where the slot has only one.
    #[must_use]
    pub const fn instance(&self) -> u8 {
        self.location.instance
    }

    /// The storage key of a value that each instance has for itself.
    #[must_use]
    pub const fn key(&self) -> Key {
        Key::Parameter { slot: self.location.slot, instance: self.location.instance, index: self.row.index }
    }

    /// The storage key of a value that all instances share.
    #[must_use]
    pub const fn shared_key(&self) -> Key {
        Key::Parameter { slot: self.location.slot, instance: 0, index: self.row.index }
    }
}

/// The parameters of a device.
pub trait ParameterAccess: Clone {
    /// The parameters of its tables.
    type Parameter: ParameterSet;

    /// Whether the blocks at this location can be accessed now: the selected instance, a channel that is fitted.
    fn is_visible(&self, location: &Location) -> bool;

    /// Whether the behaviour has a value for this row. A row without one keeps what a master writes.
    fn has_value(&self, _at: &ParameterRef<Self::Parameter>) -> bool {
        true
    }

    /// The format of the pressures of this parameter on the wire.
    fn format(&self, at: &ParameterRef<Self::Parameter>) -> PressureFormat;

    /// The value of a parameter.
    fn get(&self, at: &ParameterRef<Self::Parameter>) -> Value;

    /// Checks whether the present state allows writing a parameter, whatever the value.
    ///
    /// # Errors
    /// [`AccessError::WrongMode`] if not.
    fn check_mode(&self, _at: &ParameterRef<Self::Parameter>) -> Result<(), AccessError> {
        Ok(())
    }

    /// Sets a value or executes a command. Access, length, type and mode are checked before.
    ///
    /// # Errors
    /// An [`AccessError`]; no parameter has changed then.
    fn set(&mut self, at: &ParameterRef<Self::Parameter>, value: &Value) -> Result<(), AccessError>;

    /// Whether this write is a factory reset, which also unlocks the station address.
    fn resets_to_factory(&self, _at: &ParameterRef<Self::Parameter>, _value: &Value) -> bool {
        false
    }

    /// The value to be stored: the present one, unless the device stores on request.
    fn stored_value(&self, at: &ParameterRef<Self::Parameter>) -> Value {
        self.get(at)
    }

    /// Sets a value from the nonvolatile memory.
    ///
    /// # Errors
    /// An [`AccessError`]: it cannot be a value of this parameter, and nothing has changed.
    fn restore(&mut self, at: &ParameterRef<Self::Parameter>, value: &Value) -> Result<(), AccessError> {
        self.set(at, value)
    }

    /// The key under which a nonvolatile parameter is stored.
    fn storage_key(&self, at: &ParameterRef<Self::Parameter>) -> Key {
        at.key()
    }

    /// Nonvolatile values without an index: adjustments, run hours.
    fn internal_values(&self) -> &[f64] {
        &[]
    }

    /// The same values, to be restored.
    fn internal_values_mut(&mut self) -> &mut [f64] {
        &mut []
    }
}
