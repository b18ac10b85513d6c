//! The parameters of a device: what its tables lead to.

use crate::model::{Address, Format, Parameters, Refusal, Row, Value};
use crate::store::Key;

/// A parameter that was found: where, and which.
#[derive(Clone, Copy, Debug)]
pub struct At<P> {
    /// Slot and instance.
    pub address: &'static Address,
    /// Its row in the table.
    pub row: &'static Row,
    /// Which one it is.
    pub parameter: P,
}

impl<P> At<P> {
    /// The instance, 0 where the slot has only one.
    #[must_use]
    pub const fn instance(&self) -> u8 {
        self.address.instance
    }

    /// The key of a value that is this instance's own.
    #[must_use]
    pub const fn key(&self) -> Key {
        Key::Parameter { slot: self.address.slot, instance: self.address.instance, index: self.row.id }
    }

    /// The key of a value that all instances share.
    #[must_use]
    pub const fn shared_key(&self) -> Key {
        Key::Parameter { slot: self.address.slot, instance: 0, index: self.row.id }
    }
}

/// The parameters of a device.
pub trait Blocks: Clone {
    /// The parameters of its tables.
    type Parameter: Parameters;

    /// Whether a block stands at this address now: the selected instance, a channel that is fitted.
    fn shows(&self, address: &Address) -> bool;

    /// How the pressures of this parameter look on the wire.
    fn format(&self, at: &At<Self::Parameter>) -> Format;

    /// The value of a parameter.
    fn get(&self, at: &At<Self::Parameter>) -> Value;

    /// Whether the present state lets a parameter be written, whatever the value.
    ///
    /// # Errors
    /// [`Refusal::Mode`] if not.
    fn permits(&self, _at: &At<Self::Parameter>) -> Result<(), Refusal> {
        Ok(())
    }

    /// Takes over a value or carries out a command. Direction, length, type and state fit already.
    ///
    /// # Errors
    /// A [`Refusal`]; no parameter has changed then.
    fn set(&mut self, at: &At<Self::Parameter>, value: &Value) -> Result<(), Refusal>;

    /// Whether this write puts everything back as it left the factory, beyond the parameters.
    fn resets_to_factory(&self, _at: &At<Self::Parameter>, _value: &Value) -> bool {
        false
    }

    /// The value that the memory shall hold: the present one, unless the device stores on request.
    fn kept(&self, at: &At<Self::Parameter>) -> Value {
        self.get(at)
    }

    /// Takes over a value from the memory.
    ///
    /// # Errors
    /// A [`Refusal`]: it cannot be a value of this parameter, and nothing has changed.
    fn recall(&mut self, at: &At<Self::Parameter>, value: &Value) -> Result<(), Refusal> {
        self.set(at, value)
    }

    /// The key under which a nonvolatile parameter is stored.
    fn key(&self, at: &At<Self::Parameter>) -> Key {
        at.key()
    }

    /// Nonvolatile values without an index: adjustments, run hours.
    fn hidden(&self) -> &[f64] {
        &[]
    }

    /// The same, to be recalled.
    fn hidden_mut(&mut self) -> &mut [f64] {
        &mut []
    }
}
