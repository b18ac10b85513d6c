//! A threshold control block: a pair of thresholds with a source. IF300P/IF301P manual 3.2.4.2,
//! errata-bpg-bcg-tpg 137 to 142.

use super::table::ThresholdControl;
use crate::model::{AccessError, Value};

/// The thresholds and the source of a block, which become valid together.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct ThresholdSet {
    /// The function is deactivated above it, in Pa.
    pub upper_pa: f64,
    /// The function is activated below it, in Pa.
    pub lower_pa: f64,
    /// Slot of the analog input block that is compared.
    pub source: u8,
}

impl ThresholdSet {
    /// The value of a parameter of the set.
    pub fn get(&self, parameter: ThresholdControl) -> Option<Value> {
        Some(match parameter {
            ThresholdControl::UpperThreshold => Value::Pressure(self.upper_pa),
            ThresholdControl::LowerThreshold => Value::Pressure(self.lower_pa),
            ThresholdControl::Source => self.source.into(),
            ThresholdControl::Validation | ThresholdControl::SetpointStatus => return None,
        })
    }

    /// Sets a parameter of the set. Neither threshold is zero (137), the source is the slot of a channel (140).
    pub fn set(&mut self, parameter: ThresholdControl, value: &Value) -> Result<(), AccessError> {
        let positive = |pa: f64| if pa > 0.0 { Ok(pa) } else { Err(AccessError::OutOfRange) };
        match parameter {
            ThresholdControl::UpperThreshold => self.upper_pa = positive(value.pressure()?)?,
            ThresholdControl::LowerThreshold => self.lower_pa = positive(value.pressure()?)?,
            ThresholdControl::Source => match value.integer()? {
                source @ 1..=4 => self.source = source,
                _ => return Err(AccessError::OutOfRange),
            },
            ThresholdControl::Validation | ThresholdControl::SetpointStatus => return Err(AccessError::NotWritable),
        }
        Ok(())
    }

    /// Whether the lower threshold is not above the upper one: errata-bpg-bcg-tpg 137.
    pub fn are_in_order(&self) -> bool {
        self.lower_pa <= self.upper_pa
    }

    /// Moves the upper threshold to the lower one if it lies below.
    pub const fn uncross(&mut self) {
        self.upper_pa = self.upper_pa.max(self.lower_pa);
    }
}

/// The state of a block.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Threshold {
    /// The set in preparation, while Threshold validation is 0. The controller does not use it (139).
    pub open: Option<ThresholdSet>,
    /// Whether the function is activated.
    pub activated: bool,
}
