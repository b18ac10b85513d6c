//! Every row of the tables, and what it means. Numbers in brackets are those of errata-bpg-bcg-tpg.

use super::Controller;
use super::settings::{FIRST_CHANNEL, FIRST_THRESHOLD, Settings, flag, of_slot, of_slot_mut};
use super::table::{self, AnalogInput, DeviceBlock, Parameter, ThresholdControl};
use super::threshold::Threshold;
use crate::model::{Address, Format, Refusal, Value};
use crate::profile::{At, Blocks};
use crate::store::Key;

/// What writing Volatility asks for. 3.2.3.2, errata-bpg-bcg-tpg 143.
const NOTHING: u8 = 0;
const STORE: u8 = 1;
const STORE_AND_HOTSTART: u8 = 2;

impl Blocks for Controller {
    type Parameter = Parameter;

    /// Every slot is there, whatever boards are fitted (124).
    fn shows(&self, _address: &Address) -> bool {
        true
    }

    fn format(&self, _at: &At<Parameter>) -> Format {
        table::format(self.settings.unit)
    }

    fn get(&self, at: &At<Parameter>) -> Value {
        let value = match at.parameter {
            Parameter::Device(row) => self.get_device(row),
            Parameter::Channel(row) => self.get_channel(at.address.slot, row),
            Parameter::Threshold(row) => self.threshold(at).and_then(|threshold| get_threshold(threshold, row)),
        };
        value.or_else(|| self.shown().get(at)).unwrap_or(Value::NONE)
    }

    /// A set of thresholds is locked while it is valid (138), the access code 9919 for ever (132), and nothing reaches
    /// a controller whose link is lost (156).
    fn permits(&self, at: &At<Parameter>) -> Result<(), Refusal> {
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

    fn set(&mut self, at: &At<Parameter>, value: &Value) -> Result<(), Refusal> {
        match at.parameter {
            Parameter::Device(DeviceBlock::Volatility) => self.store(value.integer()?),
            Parameter::Threshold(ThresholdControl::Validation) => self.validate(at, flag(value)?),
            Parameter::Threshold(row) => self.threshold_mut(at)?.open.as_mut().ok_or(Refusal::Mode)?.set(row, value),
            Parameter::Device(_) | Parameter::Channel(_) => self.settings.set(at, value),
        }
    }

    /// The value that was stored on request.
    fn kept(&self, at: &At<Parameter>) -> Value {
        self.kept.get(at).unwrap_or(Value::NONE)
    }

    fn recall(&mut self, at: &At<Parameter>, value: &Value) -> Result<(), Refusal> {
        self.kept.set(at, value)?;
        self.settings = self.kept;
        Ok(())
    }

    /// One unit in all blocks (147).
    fn key(&self, at: &At<Parameter>) -> Key {
        match at.parameter {
            Parameter::Channel(AnalogInput::PressureUnit) => {
                Key::Parameter { slot: FIRST_CHANNEL, instance: 0, index: at.row.id }
            }
            _ => at.key(),
        }
    }

    fn hidden(&self) -> &[f64] {
        &self.hotstart
    }

    fn hidden_mut(&mut self) -> &mut [f64] {
        &mut self.hotstart
    }
}

impl Controller {
    /// What is no setting, and nothing for a setting.
    fn get_device(&self, row: DeviceBlock) -> Option<Value> {
        Some(match row {
            DeviceBlock::SensorOnOff => self.sensor_on_off.into(),
            DeviceBlock::ProgramVersion => program_version(self.model.gsd.software).into(),
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
}

fn get_threshold(threshold: &Threshold, row: ThresholdControl) -> Option<Value> {
    Some(match row {
        ThresholdControl::Validation => u8::from(threshold.open.is_none()).into(),
        // 0 is activated: 141.
        ThresholdControl::SetpointStatus => u8::from(!threshold.activated).into(),
        ThresholdControl::UpperThreshold | ThresholdControl::LowerThreshold | ThresholdControl::Source => return None,
    })
}

/// Program version: a nibble for each digit of the software version, a zero for its hyphen and one for the number of
/// its letter. 3.2.3.2, errata-bpg-bcg-tpg 131.
fn program_version(software: &str) -> u32 {
    software.bytes().fold(0, |coded, character| match character {
        b'0'..=b'9' => coded << 4 | u32::from(character & 0x0F),
        b'-' => coded << 4,
        // The letters before the digits fall out at the front.
        _ => coded << 4 | u32::from(character & 0x0F),
    })
}
