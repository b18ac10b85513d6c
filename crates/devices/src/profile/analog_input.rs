//! The rows that the analog input blocks of all block devices have, by their index: a measuring part's value, its
//! range, and what the device shows instead of a value that it must not show.

use super::part::{MeasuringPart, SafeState};
use super::presentation::Presentation;
use crate::model::{AccessError, Value};

/// A row of an analog input block. Set points have the first five of them.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum InputRow {
    /// Process Value.
    ProcessValue,
    /// Status.
    Status,
    /// Data Type.
    DataType,
    /// Data Units.
    DataUnits,
    /// Reading Valid.
    ReadingValid,
    /// Full Scale.
    FullScale,
    /// Safe State.
    SafeState,
    /// Safe Value.
    SafeValue,
    /// Overrange.
    Overrange,
    /// Underrange.
    Underrange,
}

impl InputRow {
    /// The row with this index.
    #[must_use]
    pub const fn from_index(index: u8) -> Option<Self> {
        Some(match index {
            19 => Self::ProcessValue,
            20 => Self::Status,
            21 => Self::DataType,
            22 => Self::DataUnits,
            23 => Self::ReadingValid,
            24 => Self::FullScale,
            39 => Self::SafeState,
            40 => Self::SafeValue,
            44 => Self::Overrange,
            45 => Self::Underrange,
            _ => return None,
        })
    }

    /// Whether this is the index of Data Type or Data Units, which are one value for the whole device:
    /// errata-bpg-bcg-tpg 72.
    #[must_use]
    pub const fn is_presentation(index: u8) -> bool {
        matches!(Self::from_index(index), Some(Self::DataType | Self::DataUnits))
    }
}

impl MeasuringPart {
    /// The value of the row with this index, apart from Process Value and Reading Valid, which depend on the state of
    /// the device.
    #[must_use]
    pub fn input_row(&self, index: u8, presentation: &Presentation) -> Value {
        let Some(row) = InputRow::from_index(index) else { return Value::NONE };
        match row {
            InputRow::ProcessValue | InputRow::ReadingValid => Value::NONE,
            InputRow::Status => Value::Integer(0),
            InputRow::DataType => presentation.number.code().into(),
            InputRow::DataUnits => presentation.unit.code.into(),
            InputRow::FullScale => Value::Pressure(self.spec.limits.full_scale_pa),
            InputRow::SafeState => Value::Integer(self.safe_state.code().into()),
            InputRow::SafeValue => Value::Pressure(self.safe_value_pa),
            InputRow::Overrange => Value::Pressure(self.spec.limits.over_pa),
            InputRow::Underrange => Value::Pressure(self.spec.limits.under_pa),
        }
    }

    /// Writes Safe State or Safe Value.
    ///
    /// # Errors
    /// [`AccessError::OutOfRange`] for a Safe State that is not in the table, [`AccessError::NotWritable`] for other rows.
    pub fn set_input(&mut self, row: InputRow, value: &Value) -> Result<(), AccessError> {
        match row {
            InputRow::SafeState => self.safe_state = value.coded::<SafeState>()?,
            InputRow::SafeValue => self.safe_value_pa = value.pressure()?,
            _ => return Err(AccessError::NotWritable),
        }
        Ok(())
    }
}

impl Presentation {
    /// Writes Data Type or Data Units.
    ///
    /// # Errors
    /// [`AccessError::OutOfRange`] for a code that is not in the table, [`AccessError::NotWritable`] for other rows.
    pub fn set_row(&mut self, row: InputRow, value: &Value) -> Result<(), AccessError> {
        match row {
            InputRow::DataType => self.set_number(value),
            InputRow::DataUnits => self.set_unit(value),
            _ => Err(AccessError::NotWritable),
        }
    }
}
