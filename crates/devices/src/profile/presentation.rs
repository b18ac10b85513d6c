//! Unit and number type: one of each for the whole device. errata-bpg-bcg-tpg 72.

use crate::model::{
    AccessError, Configuration, Counts, DESCRIBED, INTEGER16_MAX, Model, NumberType, PressureFormat, Unit, Value,
};

/// Data Units and Data Type, and the tables with their codes.
#[derive(Clone, Copy, Debug)]
pub struct Presentation {
    /// The tables of the device.
    pub model: &'static Model,
    /// Data Units.
    pub unit: &'static Unit,
    /// Data Type.
    pub number: NumberType,
}

impl Presentation {
    /// As it leaves the factory: floats (errata-bpg-bcg-tpg 73). A device file can have other units than the device that it is like.
    #[must_use]
    pub fn new(model: &'static Model, factory: &'static Unit) -> Self {
        let unit = if DESCRIBED { model.unit(factory.code).or(model.units.first()) } else { None };
        Self { model, unit: unit.unwrap_or(factory), number: NumberType::Float }
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
    pub fn set_unit(&mut self, value: &Value) -> Result<(), AccessError> {
        self.unit = self.model.unit(value.integer()?).ok_or(AccessError::OutOfRange)?;
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
