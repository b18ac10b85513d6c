//! Every row of the tables, and what it means.

use super::table::{
    AnalogInput, Degas, DeviceBlock, HeatTransfer, HotCathode, INSTANCES, OneOfNInput, OneOfNTransducer, Parameter,
    SetPoint, SideSwitches,
};
use super::{Xpg400Behaviour, Xpg400Model};
use crate::model::{AccessError, Counts, Location, PressureFormat, Value};
use crate::profile::{EmissionCurrent, MeasuringPart, ParameterAccess, ParameterRef, SafeState};
use crate::store::Key;

impl ParameterAccess for Xpg400Behaviour {
    type Parameter = Parameter;

    /// Slot 1 shows the instance of the Channel Instance Selector (28).
    fn is_visible(&self, address: &Location) -> bool {
        address.instance == 0 || address.instance == self.selector
    }

    fn format(&self, at: &ParameterRef<Parameter>) -> PressureFormat {
        self.presentation.format(self.counts(at))
    }

    fn get(&self, at: &ParameterRef<Parameter>) -> Value {
        match at.parameter {
            Parameter::Device(row) => self.get_device(row),
            Parameter::SideSwitches(row) => match row {
                SideSwitches::EmissionOnSwitch => Value::Pressure(self.switchover().pa),
                SideSwitches::SensorCalibrationSwitch => self.side.cal_adj.into(),
            },
            Parameter::OneOfNInput(row) => match row {
                OneOfNInput::AdjustCommand => Value::Integer(0),
                OneOfNInput::BlockType => Value::octets(&OneOfNInput::BLOCK.type_octets()),
                OneOfNInput::ChannelInstanceSelector => self.selector.into(),
                OneOfNInput::PvSelector => self.active().part().instance.into(),
            },
            Parameter::OneOfNTransducer(OneOfNTransducer::StatusExtension) => self.one_of_n.bits().into(),
            Parameter::Input(row) => self.part(at.instance()).map_or(Value::NONE, |part| self.get_input(part, row)),
            Parameter::SetPoint(row) => self.get_set_point(at.instance(), row),
            Parameter::HeatTransfer(row) => match row {
                HeatTransfer::BlockType => Value::octets(&HeatTransfer::BLOCK.type_octets()),
                HeatTransfer::StatusExtension => self.pirani.status_extension(&self.condition).bits().into(),
                HeatTransfer::SensorAlarm => Value::octets(&self.pirani.sensor_alarm()),
                HeatTransfer::SensorWarning => Value::octets(&self.pirani_warning()),
                HeatTransfer::FullScaleState => u8::from(self.is_adjusting()).into(),
            },
            Parameter::HotCathode(row) => match row {
                HotCathode::BlockType => Value::octets(&HotCathode::BLOCK.type_octets()),
                HotCathode::StatusExtension => self.ion.status_extension(&self.condition).bits().into(),
                HotCathode::SensorAlarm => Value::octets(&self.ion.sensor_alarm()),
                HotCathode::SensorWarning => Value::octets(&Self::ION_WARNING),
                HotCathode::EmissionStatus => (self.current() as u8).into(),
            },
            Parameter::Degas(row) => match row {
                Degas::StateCommand => Value::octets(&[0, 0]),
                Degas::EmissionCurrent => Value::Float(self.current().milliamperes()),
                Degas::DegasStatus => if self.cathode.is_degassing() { 3u8 } else { 0 }.into(),
            },
        }
    }

    /// Data Type and Data Units are for IDLE outside cyclic exchange (91).
    fn check_mode(&self, at: &ParameterRef<Parameter>) -> Result<(), AccessError> {
        if is_presentation(at) && !self.machine.is_configurable() { Err(AccessError::WrongMode) } else { Ok(()) }
    }

    /// Unit and number type are one value, whatever the instance (72).
    fn storage_key(&self, at: &ParameterRef<Parameter>) -> Key {
        if is_presentation(at) { at.shared_key() } else { at.key() }
    }

    fn set(&mut self, at: &ParameterRef<Parameter>, value: &Value) -> Result<(), AccessError> {
        match at.parameter {
            Parameter::Device(DeviceBlock::StateCommand) => self.state_command(value.integer()?),
            Parameter::OneOfNInput(OneOfNInput::AdjustCommand) => self.adjust(value.integer()?),
            Parameter::OneOfNInput(OneOfNInput::ChannelInstanceSelector) => self.select(value.integer()?),
            Parameter::Input(AnalogInput::DataType) | Parameter::SetPoint(SetPoint::DataType) => {
                self.presentation.set_number(value)
            }
            Parameter::Input(AnalogInput::DataUnits) | Parameter::SetPoint(SetPoint::DataUnits) => {
                self.presentation.set_unit(&self.kind.variant().model, value)
            }
            Parameter::Input(AnalogInput::SafeState) => {
                let state = SafeState::of(value)?;
                self.part_mut(at.instance()).ok_or(AccessError::UnknownIndex)?.safe_state = state;
                Ok(())
            }
            Parameter::Input(AnalogInput::SafeValue) => {
                self.part_mut(at.instance()).ok_or(AccessError::UnknownIndex)?.safe_value_pa = value.pressure()?;
                Ok(())
            }
            Parameter::HotCathode(HotCathode::EmissionStatus) => self.switch_emission(value.integer()?),
            Parameter::Degas(Degas::StateCommand) => self.hot_cathode_command(value.command()?),
            // The gauge chooses the current: one of the four is accepted and has no effect (98).
            Parameter::Degas(Degas::EmissionCurrent) => EmissionCurrent::ALL
                .iter()
                .any(|current| Value::Float(current.milliamperes()) == *value)
                .then_some(())
                .ok_or(AccessError::OutOfRange),
            // Rows without a write mark: refused before this is asked.
            Parameter::Device(_)
            | Parameter::SideSwitches(_)
            | Parameter::OneOfNInput(_)
            | Parameter::OneOfNTransducer(_)
            | Parameter::Input(_)
            | Parameter::SetPoint(_)
            | Parameter::HeatTransfer(_)
            | Parameter::HotCathode(_)
            | Parameter::Degas(_) => Err(AccessError::NotWritable),
        }
    }

    /// The adjustment of the Pirani.
    fn internal_values(&self) -> &[f64] {
        core::slice::from_ref(&self.pirani.sensor.gain)
    }

    fn internal_values_mut(&mut self) -> &mut [f64] {
        core::slice::from_mut(&mut self.pirani.sensor.gain)
    }
}

/// Data Type or Data Units, of whatever instance.
const fn is_presentation(at: &ParameterRef<Parameter>) -> bool {
    matches!(
        at.parameter,
        Parameter::Input(AnalogInput::DataType | AnalogInput::DataUnits)
            | Parameter::SetPoint(SetPoint::DataType | SetPoint::DataUnits)
    )
}

impl Xpg400Behaviour {
    /// The switchover counts as the Pirani does (66).
    fn counts(&self, at: &ParameterRef<Parameter>) -> Counts {
        match at.parameter {
            Parameter::SetPoint(_) => self.kind.variant().set_point_counts,
            _ => self.part(at.instance()).unwrap_or(&self.pirani).facts.counts,
        }
    }

    fn get_device(&self, row: DeviceBlock) -> Value {
        let version = self.kind.variant();
        match row {
            // A command has been carried out when it can be read (35).
            DeviceBlock::StateCommand => Value::Integer(0),
            DeviceBlock::BlockType => Value::octets(&DeviceBlock::BLOCK.type_octets()),
            DeviceBlock::DeviceType => Value::text("CG"),
            DeviceBlock::StandardRevision => Value::text("E54-0997"),
            DeviceBlock::Manufacturer => Value::text(version.model.vendor),
            DeviceBlock::ModelNumber => Value::text(version.number),
            DeviceBlock::SoftwareRevision => Value::text(version.model.gsd.software),
            DeviceBlock::HardwareRevision => Value::text(version.model.gsd.hardware),
            DeviceBlock::SerialNumber => self.serial.value(),
            DeviceBlock::DeviceConfiguration => Value::text(version.model.title),
            DeviceBlock::DeviceState => self.machine.state().code().into(),
            DeviceBlock::ExceptionStatus => self.exception_status().bits().into(),
            DeviceBlock::AlarmDetail => self.alarm().record(),
            DeviceBlock::WarningDetail => self.warning().record(),
            DeviceBlock::AlarmCommon => self.alarm().common.bits().into(),
            DeviceBlock::AlarmDevice => self.alarm().part(0, 4),
            DeviceBlock::AlarmManufacturer => self.alarm().manufacturer.into(),
            DeviceBlock::WarningCommon => self.warning().common.bits().into(),
            DeviceBlock::WarningDevice => self.warning().part(1, 5),
            DeviceBlock::WarningManufacturer => self.warning().manufacturer.into(),
        }
    }

    fn get_input(&self, part: &MeasuringPart, row: AnalogInput) -> Value {
        match row {
            AnalogInput::ProcessValue => Value::Pressure(part.process_value_pa(&self.condition)),
            AnalogInput::Status => Value::Integer(0),
            AnalogInput::DataType => self.presentation.number.code().into(),
            AnalogInput::DataUnits => self.presentation.unit.code.into(),
            AnalogInput::ReadingValid => part.is_valid(&self.condition).into(),
            AnalogInput::FullScale => Value::Pressure(part.facts.limits.full_scale_pa),
            AnalogInput::SafeState => part.safe_state.code().into(),
            AnalogInput::SafeValue => Value::Pressure(part.safe_value_pa),
            AnalogInput::Overrange => Value::Pressure(part.facts.limits.over_pa),
            AnalogInput::Underrange => Value::Pressure(part.facts.limits.under_pa),
        }
    }

    fn get_set_point(&self, instance: u8, row: SetPoint) -> Value {
        let Some(point) = self.set_point(instance) else { return Value::NONE };
        match row {
            SetPoint::ProcessValue => Value::Pressure(point.threshold_pa()),
            SetPoint::Status => point.status().into(),
            SetPoint::DataType => self.presentation.number.code().into(),
            SetPoint::DataUnits => self.presentation.unit.code.into(),
            // In every state (56).
            SetPoint::ReadingValid => true.into(),
        }
    }

    /// The HPG400-SP has one current, and its code is 1 (97).
    pub(super) fn current(&self) -> EmissionCurrent {
        match self.kind {
            Xpg400Model::Bpg => self.cathode.current(),
            Xpg400Model::Hpg if self.cathode.is_on() => EmissionCurrent::Low,
            Xpg400Model::Hpg => EmissionCurrent::Off,
        }
    }

    fn select(&mut self, instance: u8) -> Result<(), AccessError> {
        self.selector = Some(instance).filter(|it| INSTANCES.contains(it)).ok_or(AccessError::OutOfRange)?;
        Ok(())
    }

    /// A master may switch the emission off, and on where the gauge would (97).
    fn switch_emission(&mut self, value: u8) -> Result<(), AccessError> {
        const EMISSION: u8 = 3;
        let conditions = self.conditions();
        self.cathode.command(EMISSION, value, &conditions)
    }

    /// 3.3.3.8: nothing but degas.
    fn hot_cathode_command(&mut self, (command, value): (u8, u8)) -> Result<(), AccessError> {
        let conditions = self.conditions();
        match command {
            0 | 1 => self.cathode.command(command, value, &conditions),
            _ => Err(AccessError::OutOfRange),
        }
    }
}
