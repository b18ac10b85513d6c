//! The parameters of a device: what its tables lead to.

use crate::model::{AccessError, Location, ParameterSet, PressureFormat, Row, Value};
use crate::store::Key;

/// A parameter that was found: where, and which.
#[derive(Clone, Copy, Debug)]
pub struct ParameterRef<P> {
    /// Slot and instance.
    pub location: &'static Location,
    /// Its row in the table.
    pub row: &'static Row,
    /// Which one it is.
    pub parameter: P,
}

impl<P> ParameterRef<P> {
    /// The instance, 0 where the slot has only one.
    #[must_use]
    pub const fn instance(&self) -> u8 {
        self.location.instance
    }

    /// The key of a value that is this instance's own.
    #[must_use]
    pub const fn key(&self) -> Key {
        Key::Parameter { slot: self.location.slot, instance: self.location.instance, index: self.row.index }
    }

    /// The key of a value that all instances share.
    #[must_use]
    pub const fn shared_key(&self) -> Key {
        Key::Parameter { slot: self.location.slot, instance: 0, index: self.row.index }
    }
}

/// The parameters of a device.
pub trait ParameterAccess: Clone {
    /// The parameters of its tables.
    type Parameter: ParameterSet;

    /// Whether a block stands at this address now: the selected instance, a channel that is fitted.
    fn is_visible(&self, address: &Location) -> bool;

    /// How the pressures of this parameter look on the wire.
    fn format(&self, at: &ParameterRef<Self::Parameter>) -> PressureFormat;

    /// The value of a parameter.
    fn get(&self, at: &ParameterRef<Self::Parameter>) -> Value;

    /// Whether the present state lets a parameter be written, whatever the value.
    ///
    /// # Errors
    /// [`Refusal::Mode`] if not.
    fn check_mode(&self, _at: &ParameterRef<Self::Parameter>) -> Result<(), AccessError> {
        Ok(())
    }

    /// Takes over a value or carries out a command. Direction, length, type and state fit already.
    ///
    /// # Errors
    /// A [`Refusal`]; no parameter has changed then.
    fn set(&mut self, at: &ParameterRef<Self::Parameter>, value: &Value) -> Result<(), AccessError>;

    /// Whether this write puts everything back as it left the factory, beyond the parameters.
    fn resets_to_factory(&self, _at: &ParameterRef<Self::Parameter>, _value: &Value) -> bool {
        false
    }

    /// The value that the memory shall hold: the present one, unless the device stores on request.
    fn stored_value(&self, at: &ParameterRef<Self::Parameter>) -> Value {
        self.get(at)
    }

    /// Takes over a value from the memory.
    ///
    /// # Errors
    /// A [`Refusal`]: it cannot be a value of this parameter, and nothing has changed.
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

    /// The same, to be recalled.
    fn internal_values_mut(&mut self) -> &mut [f64] {
        &mut []
    }
}
