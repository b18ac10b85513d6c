//! The settings of a master. They are lost with the power unless the master asks to store them with Volatility:
//! IF300P/IF301P manual 3.2.3.2.

use super::CHANNELS;
use super::channel::TpgGauge;
use super::codes::{Filter, UnderrangeControl};
use super::table::{AnalogInput, DeviceBlock, MBAR, Parameter, UNITS};
use super::threshold::ThresholdSet;
use crate::model::{AccessError, Unit, Value, mbar};
use crate::profile::ParameterRef;

/// Relays 1 to 4, cold cathodes A and B.
pub(super) const THRESHOLDS: usize = 6;

/// The slot of A1, and the slot of relay 1.
pub(super) const FIRST_CHANNEL: u8 = 1;
pub(super) const FIRST_THRESHOLD: u8 = 5;

/// Authorized access code that cannot be changed. 3.2.3.2.
const FIXED_ACCESS_CODE: u16 = 9919;

/// The settings of the controller.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Settings {
    pub unit: &'static Unit,
    pub access_code: u16,
    /// Pressure underrange control.
    pub underrange: UnderrangeControl,
    pub filters: [Filter; CHANNELS],
    pub limits: [ThresholdSet; THRESHOLDS],
}

impl Settings {
    /// The settings of a controller as delivered with these gauges.
    // chosen: the manual gives no initial values. A relay switches at 1e-3 mbar on its own channel; the cold
    // cathodes of both boards are on below 5e-3 mbar on the first Pirani gauge, so that at 1e-3 mbar all channels
    // measure.
    pub fn factory(gauges: &[Option<TpgGauge>; CHANNELS]) -> Self {
        let pirani = (FIRST_CHANNEL..).zip(gauges).find(|(_, gauge)| **gauge == Some(TpgGauge::Pirani));
        let cathodes = cold_cathode(pirani.map_or(FIRST_CHANNEL, |(slot, _)| slot));
        Self {
            unit: &MBAR,
            access_code: 0,
            underrange: UnderrangeControl::RelayRemainsOn,
            filters: [Filter::Medium; CHANNELS],
            limits: [relay(1), relay(2), relay(3), relay(4), cathodes, cathodes],
        }
    }

    /// The value of a parameter that is a setting; `None` for other parameters.
    pub fn get(&self, at: &ParameterRef<Parameter>) -> Option<Value> {
        Some(match at.parameter {
            Parameter::Device(DeviceBlock::AccessCode) => self.access_code.into(),
            Parameter::Device(DeviceBlock::UnderrangeControl) => self.underrange.code().into(),
            Parameter::Input(AnalogInput::PressureUnit) => self.unit.code.into(),
            Parameter::Input(AnalogInput::FilterTimeConstant) => {
                of_slot(&self.filters, FIRST_CHANNEL, at)?.code().into()
            }
            Parameter::Threshold(parameter) => {
                of_slot(&self.limits, FIRST_THRESHOLD, at).and_then(|limits| limits.get(parameter))?
            }
            Parameter::Device(DeviceBlock::SensorOnOff | DeviceBlock::ProgramVersion | DeviceBlock::Volatility)
            | Parameter::Input(AnalogInput::MeasuredValue | AnalogInput::MeasurementStatus) => return None,
        })
    }

    /// Sets a setting.
    pub fn set(&mut self, at: &ParameterRef<Parameter>, value: &Value) -> Result<(), AccessError> {
        match at.parameter {
            Parameter::Device(DeviceBlock::AccessCode) => self.set_access_code(value.integer()?),
            Parameter::Device(DeviceBlock::UnderrangeControl) => {
                self.underrange = value.coded()?;
                Ok(())
            }
            // All blocks of the controller share the unit: errata-bpg-bcg-tpg 147.
            Parameter::Input(AnalogInput::PressureUnit) => {
                let code = value.integer()?;
                self.unit = UNITS.iter().find(|unit| unit.code == code).ok_or(AccessError::OutOfRange)?;
                Ok(())
            }
            Parameter::Input(AnalogInput::FilterTimeConstant) => {
                let filter = value.coded()?;
                of_slot_mut(&mut self.filters, FIRST_CHANNEL, at)
                    .map(|target| *target = filter)
                    .ok_or(AccessError::UnknownSlot)
            }
            Parameter::Threshold(parameter) => of_slot_mut(&mut self.limits, FIRST_THRESHOLD, at)
                .ok_or(AccessError::UnknownSlot)?
                .set(parameter, value),
            Parameter::Device(DeviceBlock::SensorOnOff | DeviceBlock::ProgramVersion | DeviceBlock::Volatility)
            | Parameter::Input(AnalogInput::MeasuredValue | AnalogInput::MeasurementStatus) => {
                Err(AccessError::NotWritable)
            }
        }
    }

    /// 0 to 9999: errata-bpg-bcg-tpg 132.
    fn set_access_code(&mut self, code: u16) -> Result<(), AccessError> {
        if code > 9999 {
            return Err(AccessError::OutOfRange);
        }
        self.access_code = code;
        Ok(())
    }

    /// Whether the access code can be changed.
    pub const fn access_code_is_fixed(&self) -> bool {
        self.access_code == FIXED_ACCESS_CODE
    }
}

const fn relay(source: u8) -> ThresholdSet {
    ThresholdSet { upper_pa: mbar(2e-3), lower_pa: mbar(1e-3), source }
}

const fn cold_cathode(source: u8) -> ThresholdSet {
    ThresholdSet { upper_pa: mbar(1e-2), lower_pa: mbar(5e-3), source }
}

/// The item for the slot of `at`, of a list with one item for each slot from `first` on.
pub(super) fn of_slot<'a, T>(items: &'a [T], first: u8, at: &ParameterRef<Parameter>) -> Option<&'a T> {
    items.get(usize::from(at.location.slot.checked_sub(first)?))
}

/// The same, to be changed.
pub(super) fn of_slot_mut<'a, T>(items: &'a mut [T], first: u8, at: &ParameterRef<Parameter>) -> Option<&'a mut T> {
    items.get_mut(usize::from(at.location.slot.checked_sub(first)?))
}
