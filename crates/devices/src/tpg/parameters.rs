//! Every row of the tables, and what it means.

use super::settings::{FIRST_THRESHOLD, Settings, flag, of_slot, of_slot_mut};
use super::table::{AnalogInput, DeviceBlock, Parameter, ThresholdControl};
use super::threshold::Threshold;
use super::{Controller, Kind};
use crate::model::{Refusal, Value};
use crate::profile::At;

/// What writing Volatility asks for. 3.2.3.2, errata-bpg-bcg-tpg 143.
const NOTHING: u8 = 0;
const STORE: u8 = 1;
const STORE_AND_HOTSTART: u8 = 2;

impl<K: Kind> Controller<K> {
    pub(super) fn get(&self, at: &At<Parameter>) -> Value {
        let value = match at.parameter {
            Parameter::Device(row) => self.get_device(row),
            Parameter::Channel(row) => self.get_channel(at.address.slot, row),
            Parameter::Threshold(row) => self.threshold(at).and_then(|threshold| get_threshold(threshold, row)),
        };
        value.or_else(|| self.shown().get(at)).unwrap_or(Value::NONE)
    }

    /// What is no setting, and nothing for a setting.
    fn get_device(&self, row: DeviceBlock) -> Option<Value> {
        Some(match row {
            DeviceBlock::SensorOnOff => self.sensor_on_off.into(),
            DeviceBlock::ProgramVersion => K::PROGRAM_VERSION.into(),
            DeviceBlock::Volatility => self.volatility.into(),
            DeviceBlock::AccessCode | DeviceBlock::UnderrangeControl => return None,
        })
    }

    fn get_channel(&self, slot: u8, row: AnalogInput) -> Option<Value> {
        Some(match row {
            AnalogInput::MeasuredValue => Value::Pressure(self.measured_pa(slot)),
            AnalogInput::MeasurementStatus => (self.status(slot) as u8).into(),
            AnalogInput::PressureUnit | AnalogInput::FilterTimeConstant => return None,
        })
    }

    fn threshold(&self, at: &At<Parameter>) -> Option<&Threshold> {
        of_slot(&self.thresholds, FIRST_THRESHOLD, at)
    }

    fn threshold_mut(&mut self, at: &At<Parameter>) -> Result<&mut Threshold, Refusal> {
        of_slot_mut(&mut self.thresholds, FIRST_THRESHOLD, at).ok_or(Refusal::Slot)
    }

    /// The settings as the bus sees them: sets in preparation in place of the active ones (139).
    fn shown(&self) -> Settings {
        let mut shown = self.settings;
        for (limits, threshold) in shown.limits.iter_mut().zip(&self.thresholds) {
            *limits = threshold.open.unwrap_or(*limits);
        }
        shown
    }

    /// A set of thresholds is locked while it is valid (138), the access code 9919 for ever (132), and nothing reaches a
    /// controller whose link is lost (156).
    pub(super) fn permits(&self, at: &At<Parameter>) -> Result<(), Refusal> {
        use ThresholdControl::{LowerThreshold, Source, UpperThreshold};
        let is_valid = || self.threshold(at).is_some_and(|threshold| threshold.open.is_none());
        match at.parameter {
            _ if self.faults.comm => Err(Refusal::Mode),
            Parameter::Device(DeviceBlock::AccessCode) if self.settings.access_code_is_fixed() => {
                Err(Refusal::NotWritable)
            }
            Parameter::Threshold(UpperThreshold | LowerThreshold | Source) if is_valid() => Err(Refusal::Mode),
            _ => Ok(()),
        }
    }

    pub(super) fn set(&mut self, at: &At<Parameter>, value: &Value) -> Result<(), Refusal> {
        match at.parameter {
            Parameter::Device(DeviceBlock::Volatility) => self.store(value.integer()?),
            Parameter::Threshold(ThresholdControl::Validation) => self.validate(at, flag(value)?),
            Parameter::Threshold(row) => self.threshold_mut(at)?.open.as_mut().ok_or(Refusal::Mode)?.set(row, value),
            Parameter::Device(_) | Parameter::Channel(_) => self.settings.set(at, value),
        }
    }

    /// Threshold validation: 0 opens the set for changes, 1 hands it to the controller, once (139).
    fn validate(&mut self, at: &At<Parameter>, valid: bool) -> Result<(), Refusal> {
        let active = of_slot_mut(&mut self.settings.limits, FIRST_THRESHOLD, at).ok_or(Refusal::Slot)?;
        let threshold = of_slot_mut(&mut self.thresholds, FIRST_THRESHOLD, at).ok_or(Refusal::Slot)?;
        match (valid, threshold.open) {
            (false, None) => threshold.open = Some(*active),
            (true, Some(prepared)) if prepared.are_in_order() => {
                *active = prepared;
                threshold.open = None;
            }
            // 137
            (true, Some(_)) => return Err(Refusal::Range),
            (false, Some(_)) | (true, None) => {}
        }
        Ok(())
    }

    /// A request to store. What the controller uses is stored, not what is in preparation.
    fn store(&mut self, request: u8) -> Result<(), Refusal> {
        self.hotstart = match request {
            NOTHING => return Ok(()),
            STORE => [0.0],
            STORE_AND_HOTSTART => [self.switches().into()],
            _ => return Err(Refusal::Range),
        };
        self.kept = self.settings;
        self.volatility = request;
        Ok(())
    }

    /// The value that was stored on request.
    pub(super) fn kept(&self, at: &At<Parameter>) -> Value {
        self.kept.get(at).unwrap_or(Value::NONE)
    }

    pub(super) fn recall(&mut self, at: &At<Parameter>, value: &Value) -> Result<(), Refusal> {
        self.kept.set(at, value)?;
        self.settings = self.kept;
        Ok(())
    }
}

fn get_threshold(threshold: &Threshold, row: ThresholdControl) -> Option<Value> {
    Some(match row {
        ThresholdControl::Validation => u8::from(threshold.open.is_none()).into(),
        // 0 is activated: 141.
        ThresholdControl::SetpointStatus => u8::from(!threshold.activated).into(),
        ThresholdControl::UpperThreshold | ThresholdControl::LowerThreshold | ThresholdControl::Source => return None,
    })
}
