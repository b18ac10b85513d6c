//! Unit and number type: one of each for the whole device. errata-bpg-bcg-tpg 72.

use crate::model::{AccessError, Configuration, Counts, INTEGER16_MAX, Model, NumberType, PressureFormat, Unit, Value};

/// Data Units and Data Type.
#[derive(Clone, Copy, Debug)]
pub struct Presentation {
    /// Data Units.
    pub unit: &'static Unit,
    /// Data Type.
    pub number: NumberType,
}

impl Presentation {
    /// As it leaves the factory: floats (errata-bpg-bcg-tpg 73).
    #[must_use]
    pub const fn new(unit: &'static Unit) -> Self {
        Self { unit, number: NumberType::Float }
    }

    /// The format of the pressures of an instance on the wire.
    #[must_use]
    pub const fn format(&self, counts: Counts) -> PressureFormat {
        PressureFormat { unit: self.unit, number: self.number, counts, max_integer: INTEGER16_MAX }
    }

    /// Sets Data Units.
    ///
    /// # Errors
    /// [`AccessError::OutOfRange`] for a code that is not in the table.
    pub fn set_unit(&mut self, model: &Model, value: &Value) -> Result<(), AccessError> {
        self.unit = model.unit(value.integer()?).ok_or(AccessError::OutOfRange)?;
        Ok(())
    }

    /// Sets Data Type.
    ///
    /// # Errors
    /// [`AccessError::OutOfRange`] for a code that is not in the table.
    pub fn set_number(&mut self, value: &Value) -> Result<(), AccessError> {
        self.number = value.coded()?;
        Ok(())
    }

    /// The configuration determines the number type (tira41d1 3.2.2.3).
    pub fn configure(&mut self, configuration: &Configuration) {
        self.number = configuration.number().unwrap_or(self.number);
    }
}
