//! The value of every row of the tables, and the effect of writing it. Numbers in brackets are those of
//! errata-bpg-bcg-tpg.

use super::TpgBehaviour;
use super::codes::{SetpointStatus, Validation, Volatility};
use super::settings::{FIRST_CHANNEL, FIRST_THRESHOLD, Settings, of_slot, of_slot_mut};
use super::table::{self, AnalogInput, DeviceBlock, Parameter, ThresholdControl};
use super::threshold::Threshold;
use crate::model::{AccessError, Location, PressureFormat, Value};
use crate::profile::{ParameterAccess, ParameterRef};
use crate::store::Key;

impl ParameterAccess for TpgBehaviour {
    type Parameter = Parameter;

    /// Every slot can be accessed, with any fitted boards (124).
    fn is_visible(&self, _location: &Location) -> bool {
        true
    }

    fn format(&self, _at: &ParameterRef<Parameter>) -> PressureFormat {
        table::format(self.settings.unit)
    }

    fn get(&self, at: &ParameterRef<Parameter>) -> Value {
        let value = match at.parameter {
            Parameter::Device(row) => self.get_device(row),
            Parameter::Input(row) => self.get_channel(at.location.slot, row),
            Parameter::Threshold(row) => self.threshold(at).and_then(|threshold| get_threshold(threshold, row)),
        };
        value.or_else(|| self.shown().get(at)).unwrap_or(Value::NONE)
    }

    /// A set of thresholds is locked while it is valid (138), the access code 9919 always (132), and every parameter
    /// while the link to the controller is lost (156).
    fn check_mode(&self, at: &ParameterRef<Parameter>) -> Result<(), AccessError> {
        use ThresholdControl::{LowerThreshold, Source, UpperThreshold};
        let is_valid = || self.threshold(at).is_some_and(|threshold| threshold.open.is_none());
        match at.parameter {
            _ if self.faults.comm => Err(AccessError::WrongMode),
            Parameter::Device(DeviceBlock::AccessCode) if self.settings.access_code_is_fixed() => {
                Err(AccessError::NotWritable)
            }
            Parameter::Threshold(UpperThreshold | LowerThreshold | Source) if is_valid() => Err(AccessError::WrongMode),
            _ => Ok(()),
        }
    }

    fn set(&mut self, at: &ParameterRef<Parameter>, value: &Value) -> Result<(), AccessError> {
        match at.parameter {
            Parameter::Device(DeviceBlock::Volatility) => self.store(value.coded()?),
            Parameter::Threshold(ThresholdControl::Validation) => self.validate(at, value.coded()?),
            Parameter::Threshold(row) => {
                self.threshold_mut(at)?.open.as_mut().ok_or(AccessError::WrongMode)?.set(row, value)
            }
            Parameter::Device(_) | Parameter::Input(_) => self.settings.set(at, value),
        }
    }

    /// The value that was stored on request.
    fn stored_value(&self, at: &ParameterRef<Parameter>) -> Value {
        self.kept.get(at).unwrap_or(Value::NONE)
    }

    fn restore(&mut self, at: &ParameterRef<Parameter>, value: &Value) -> Result<(), AccessError> {
        self.kept.set(at, value)?;
        self.settings = self.kept;
        Ok(())
    }

    /// All blocks share the unit (147).
    fn storage_key(&self, at: &ParameterRef<Parameter>) -> Key {
        match at.parameter {
            Parameter::Input(AnalogInput::PressureUnit) => {
                Key::Parameter { slot: FIRST_CHANNEL, instance: 0, index: at.row.index }
            }
            _ => at.key(),
        }
    }

    fn internal_values(&self) -> &[f64] {
        &self.hotstart
    }

    fn internal_values_mut(&mut self) -> &mut [f64] {
        &mut self.hotstart
    }
}

impl TpgBehaviour {
    /// The value of a parameter of the device block; `None` for a setting.
    fn get_device(&self, row: DeviceBlock) -> Option<Value> {
        Some(match row {
            DeviceBlock::SensorOnOff => self.sensor_on_off.into(),
            DeviceBlock::ProgramVersion => program_version(self.model.gsd.software).into(),
            DeviceBlock::Volatility => self.volatility.code().into(),
            DeviceBlock::AccessCode | DeviceBlock::UnderrangeControl => return None,
        })
    }

    fn get_channel(&self, slot: u8, row: AnalogInput) -> Option<Value> {
        Some(match row {
            AnalogInput::MeasuredValue => Value::Pressure(self.measured_pa(slot)),
            AnalogInput::MeasurementStatus => self.status(slot).code().into(),
            AnalogInput::PressureUnit | AnalogInput::FilterTimeConstant => return None,
        })
    }

    fn threshold(&self, at: &ParameterRef<Parameter>) -> Option<&Threshold> {
        of_slot(&self.thresholds, FIRST_THRESHOLD, at)
    }

    fn threshold_mut(&mut self, at: &ParameterRef<Parameter>) -> Result<&mut Threshold, AccessError> {
        of_slot_mut(&mut self.thresholds, FIRST_THRESHOLD, at).ok_or(AccessError::UnknownSlot)
    }

    /// The settings that a master reads: sets in preparation in place of the active ones (139).
    fn shown(&self) -> Settings {
        let mut shown = self.settings;
        for (limits, threshold) in shown.limits.iter_mut().zip(&self.thresholds) {
            *limits = threshold.open.unwrap_or(*limits);
        }
        shown
    }

    /// Executes a write of Threshold validation: 0 opens the set for changes, 1 makes it valid (139).
    fn validate(&mut self, at: &ParameterRef<Parameter>, validation: Validation) -> Result<(), AccessError> {
        let active = of_slot_mut(&mut self.settings.limits, FIRST_THRESHOLD, at).ok_or(AccessError::UnknownSlot)?;
        let threshold = of_slot_mut(&mut self.thresholds, FIRST_THRESHOLD, at).ok_or(AccessError::UnknownSlot)?;
        match (validation, threshold.open) {
            (Validation::OpenForChanges, None) => threshold.open = Some(*active),
            (Validation::Valid, Some(prepared)) if prepared.are_in_order() => {
                *active = prepared;
                threshold.open = None;
            }
            // The lower threshold is above the upper one (137).
            (Validation::Valid, Some(_)) => return Err(AccessError::OutOfRange),
            (Validation::OpenForChanges, Some(_)) | (Validation::Valid, None) => {}
        }
        Ok(())
    }

    /// Executes a write of Volatility. The controller stores the settings that it uses, not those in preparation.
    fn store(&mut self, request: Volatility) -> Result<(), AccessError> {
        self.hotstart = match request {
            Volatility::ReadyToStore => return Ok(()),
            Volatility::Store => [0.0],
            Volatility::StoreAndHotstart => [self.switches().into()],
        };
        self.kept = self.settings;
        self.volatility = request;
        Ok(())
    }
}

fn get_threshold(threshold: &Threshold, row: ThresholdControl) -> Option<Value> {
    Some(match row {
        ThresholdControl::Validation => {
            if threshold.open.is_none() { Validation::Valid } else { Validation::OpenForChanges }.code().into()
        }
        ThresholdControl::SetpointStatus => {
            if threshold.activated { SetpointStatus::Activated } else { SetpointStatus::Deactivated }.code().into()
        }
        ThresholdControl::UpperThreshold | ThresholdControl::LowerThreshold | ThresholdControl::Source => return None,
    })
}

/// Program version: a nibble for each digit of the software version, a zero for its hyphen and one for the number of
/// its letter. 3.2.3.2, errata-bpg-bcg-tpg 131.
fn program_version(software: &str) -> u32 {
    software.bytes().fold(0, |coded, character| match character {
        b'0'..=b'9' => coded << 4 | u32::from(character & 0x0F),
        b'-' => coded << 4,
        // The letters before the digits are shifted out at the front.
        _ => coded << 4 | u32::from(character & 0x0F),
    })
}
