//! Unit and number type: one of each for the whole device. errata-bpg-bcg-tpg 72.

use crate::model::{AccessError, Configuration, Counts, Model, NumberType, PressureFormat, Unit, Value};

/// Data Units and Data Type.
#[derive(Clone, Copy, Debug)]
pub struct Presentation {
    /// Data Units.
    pub unit: &'static Unit,
    /// Data Type.
    pub number: NumberType,
}

/// The highest Integer16: errata-bpg-bcg-tpg 3.
const HIGHEST: u16 = 32767;

impl Presentation {
    /// As it leaves the factory: floats (errata-bpg-bcg-tpg 73).
    #[must_use]
    pub const fn new(unit: &'static Unit) -> Self {
        Self { unit, number: NumberType::Float }
    }

    /// How the pressures of an instance look on the wire.
    #[must_use]
    pub const fn format(&self, counts: Counts) -> PressureFormat {
        PressureFormat { unit: self.unit, number: self.number, counts, max_integer: HIGHEST }
    }

    /// A master writes Data Units.
    ///
    /// # Errors
    /// [`Refusal::Range`] for a code that is not in the table.
    pub fn set_unit(&mut self, model: &Model, value: &Value) -> Result<(), AccessError> {
        self.unit = model.unit(value.integer()?).ok_or(AccessError::OutOfRange)?;
        Ok(())
    }

    /// A master writes Data Type.
    ///
    /// # Errors
    /// [`Refusal::Range`] for a code that is not in the table.
    pub fn set_number(&mut self, value: &Value) -> Result<(), AccessError> {
        self.number = NumberType::from_code(value.integer()?).ok_or(AccessError::OutOfRange)?;
        Ok(())
    }

    /// The configuration fixes the number type (tira41d1 3.2.2.3).
    pub fn configure(&mut self, configuration: &Configuration) {
        self.number = configuration.number().unwrap_or(self.number);
    }
}
