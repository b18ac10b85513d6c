//! Every row of the tables, and what it means.

use super::table::{
    AnalogInput, Atmosphere, DeviceBlock, Diaphragm, HeatTransfer, HotCathode, INSTANCES, MODEL, OneOfNInput,
    OneOfNTransducer, Parameter, SetPoint,
};
use super::{Bcg450Behaviour, table};
use crate::model::{AccessError, Location, PressureFormat, Value};
use crate::profile::{EmissionCurrent, MeasuringPart, ParameterAccess, ParameterRef, SafeState};
use crate::store::Key;

impl ParameterAccess for Bcg450Behaviour {
    type Parameter = Parameter;

    /// Slot 1 shows the instance of the Channel Instance Selector (28).
    fn is_visible(&self, address: &Location) -> bool {
        address.instance == 0 || address.instance == self.selector
    }

    fn format(&self, _at: &ParameterRef<Parameter>) -> PressureFormat {
        self.presentation.format(table::COUNTS)
    }

    fn get(&self, at: &ParameterRef<Parameter>) -> Value {
        match at.parameter {
            Parameter::Device(row) => self.get_device(row),
            Parameter::OneOfNInput(row) => match row {
                OneOfNInput::BlockType => Value::octets(&OneOfNInput::BLOCK.type_octets()),
                OneOfNInput::ChannelInstanceSelector => self.selector.into(),
                OneOfNInput::PvSelector => self.active.into(),
            },
            Parameter::OneOfNTransducer(OneOfNTransducer::StatusExtension) => self.one_of_n.bits().into(),
            Parameter::Input(row) => self.part(at.instance()).map_or(Value::NONE, |part| self.get_input(part, row)),
            Parameter::SetPoint(row) => self.get_set_point(at.instance(), row),
            Parameter::HeatTransfer(row) => match row {
                HeatTransfer::BlockType => Value::octets(&HeatTransfer::BLOCK.type_octets()),
                HeatTransfer::StatusExtension => self.pirani.status_extension(&self.condition).bits().into(),
                HeatTransfer::SensorAlarm => Value::octets(&self.pirani.sensor_alarm()),
                HeatTransfer::SensorWarning => Value::octets(&self.sensor_warning(1)),
            },
            Parameter::HotCathode(row) => self.get_hot_cathode(row),
            Parameter::Diaphragm(row) => match row {
                Diaphragm::BlockType => Value::octets(&Diaphragm::BLOCK.type_octets()),
                Diaphragm::StatusExtension => self.cdg.status_extension(&self.condition).bits().into(),
                Diaphragm::SensorAlarm => Value::octets(&self.cdg.sensor_alarm()),
                Diaphragm::SensorWarning => Value::octets(&self.sensor_warning(3)),
            },
            Parameter::Atmosphere(row) => match row {
                Atmosphere::StateCommand => Value::octets(&[0, 0]),
                Atmosphere::BlockType => Value::octets(&Atmosphere::BLOCK.type_octets()),
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
            Parameter::OneOfNInput(OneOfNInput::ChannelInstanceSelector) => self.select(value.integer()?),
            Parameter::Input(AnalogInput::DataType) | Parameter::SetPoint(SetPoint::DataType) => {
                self.presentation.set_number(value)
            }
            Parameter::Input(AnalogInput::DataUnits) | Parameter::SetPoint(SetPoint::DataUnits) => {
                self.presentation.set_unit(&MODEL, value)
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
            Parameter::SetPoint(SetPoint::SetpointFunction) => {
                let relay = self.relay_mut(at.instance()).ok_or(AccessError::UnknownIndex)?;
                relay.set_function(value.boolean()?);
                Ok(())
            }
            Parameter::SetPoint(SetPoint::PercentageOfAtmosphere) => {
                self.relay_mut(at.instance()).ok_or(AccessError::UnknownIndex)?.set_percentage(value.integer()?)
            }
            Parameter::HotCathode(HotCathode::StateCommand) => self.hot_cathode_command(value.command()?),
            // The same as command 3 (97).
            Parameter::HotCathode(HotCathode::EmissionStatus) => self.hot_cathode_command((3, value.integer()?)),
            // The gauge chooses the current: one of the four is accepted and has no effect (98).
            Parameter::HotCathode(HotCathode::EmissionCurrent) => EmissionCurrent::ALL
                .iter()
                .any(|current| Value::Float(current.milliamperes()) == *value)
                .then_some(())
                .ok_or(AccessError::OutOfRange),
            Parameter::Atmosphere(Atmosphere::StateCommand) => self.atmosphere_command(value.command()?),
            // Rows without a write mark: refused before this is asked.
            Parameter::Device(_)
            | Parameter::OneOfNInput(_)
            | Parameter::OneOfNTransducer(_)
            | Parameter::Input(_)
            | Parameter::SetPoint(_)
            | Parameter::HeatTransfer(_)
            | Parameter::HotCathode(_)
            | Parameter::Diaphragm(_)
            | Parameter::Atmosphere(_) => Err(AccessError::NotWritable),
        }
    }

    /// The adjustment of the ambient pressure sensor.
    fn internal_values(&self) -> &[f64] {
        core::slice::from_ref(&self.atmosphere.offset_pa)
    }

    fn internal_values_mut(&mut self) -> &mut [f64] {
        core::slice::from_mut(&mut self.atmosphere.offset_pa)
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

impl Bcg450Behaviour {
    fn get_device(&self, row: DeviceBlock) -> Value {
        match row {
            // A command has been carried out when it can be read (35).
            DeviceBlock::StateCommand => Value::Integer(0),
            DeviceBlock::BlockType => Value::octets(&DeviceBlock::BLOCK.type_octets()),
            DeviceBlock::DeviceType => Value::text("CG"),
            DeviceBlock::StandardRevision => Value::text("E54-0997"),
            DeviceBlock::Manufacturer => Value::text(MODEL.vendor),
            DeviceBlock::ModelNumber => Value::text("353-554"),
            // free choice: gauge 100, PROFIBUS board 1.01 (36).
            DeviceBlock::SoftwareRevision => Value::text("100_1.01"),
            DeviceBlock::HardwareRevision => Value::text(MODEL.gsd.hardware),
            DeviceBlock::SerialNumber => self.serial.value(),
            DeviceBlock::DeviceConfiguration => Value::text(MODEL.title),
            DeviceBlock::DeviceState => self.machine.state().code().into(),
            DeviceBlock::ExceptionStatus => self.exception_status().bits().into(),
            DeviceBlock::AlarmDetail => self.alarm().record(),
            DeviceBlock::WarningDetail => self.warning().record(),
            DeviceBlock::AlarmCommon => self.alarm().common.bits().into(),
            DeviceBlock::AlarmDevice0To3 => self.alarm().part(0, 4),
            DeviceBlock::AlarmDevice4To5 => self.alarm().part(4, 6),
            DeviceBlock::AlarmManufacturer => self.alarm().manufacturer.into(),
            DeviceBlock::WarningCommon => self.warning().common.bits().into(),
            DeviceBlock::WarningDevice0To3 => self.warning().part(0, 4),
            DeviceBlock::WarningDevice4To6 => self.warning().part(4, 7),
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
        let Some(relay) = self.relay(instance) else { return Value::NONE };
        match row {
            SetPoint::ProcessValue => Value::Pressure(relay.point.threshold_pa()),
            SetPoint::Status => relay.point.status().into(),
            SetPoint::DataType => self.presentation.number.code().into(),
            SetPoint::DataUnits => self.presentation.unit.code.into(),
            // In every state (56).
            SetPoint::ReadingValid => true.into(),
            SetPoint::SetpointFunction => relay.function().into(),
            SetPoint::PercentageOfAtmosphere => relay.percentage().into(),
            SetPoint::AtmosphereReached => relay.atmosphere_reached().into(),
        }
    }

    fn get_hot_cathode(&self, row: HotCathode) -> Value {
        let current = self.cathode.current();
        match row {
            HotCathode::StateCommand => Value::octets(&[0, 0]),
            HotCathode::BlockType => Value::octets(&HotCathode::BLOCK.type_octets()),
            HotCathode::StatusExtension => self.ba.status_extension(&self.condition).bits().into(),
            HotCathode::SensorAlarm => Value::octets(&self.ba.sensor_alarm()),
            HotCathode::SensorWarning => Value::octets(&self.sensor_warning(2)),
            HotCathode::EmissionStatus => (current as u8).into(),
            HotCathode::EmissionCurrent => Value::Float(current.milliamperes()),
            HotCathode::DegasStatus => if self.cathode.is_degassing() { 3u8 } else { 0 }.into(),
            HotCathode::EmissionUserMode => self.cathode.is_automatic().into(),
        }
    }

    fn select(&mut self, instance: u8) -> Result<(), AccessError> {
        self.selector = Some(instance).filter(|it| INSTANCES.contains(it)).ok_or(AccessError::OutOfRange)?;
        Ok(())
    }

    /// 3.3.3.9
    pub(super) fn hot_cathode_command(&mut self, command: (u8, u8)) -> Result<(), AccessError> {
        let conditions = self.conditions();
        match command {
            (128, mode @ (0 | 1)) => {
                self.cathode.set_automatic(mode == 1);
                Ok(())
            }
            (command, value) => self.cathode.command(command, value, &conditions),
        }
    }

    /// 3.3.5.2 (116)
    fn atmosphere_command(&mut self, command: (u8, u8)) -> Result<(), AccessError> {
        match command {
            (0, _) => {}
            (128, 0) => self.adjust_atmosphere(false),
            (128, 1) => self.adjust_atmosphere(true),
            _ => return Err(AccessError::OutOfRange),
        }
        Ok(())
    }
}
