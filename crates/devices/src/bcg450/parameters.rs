//! The value of every row of the tables, and the effect of writing it. Numbers in brackets are those of errata-bpg-bcg-tpg.

use super::codes::{AtmosphereCommand, DegasStatus, HotCathodeCommand};
use super::parts::INSTANCES;
use super::table::{
    AnalogInput, Atmosphere, DeviceBlock, Diaphragm, HeatTransfer, HotCathode, OneOfNInput, OneOfNTransducer,
    Parameter, SetPoint,
};
use super::{Bcg450Behaviour, Relay};
use crate::model::{AccessError, DESCRIBED, Location, PressureFormat, Value};
use crate::profile::{
    DeviceBlockValues, DeviceState, EmissionCurrent, ExceptionStatus, Identity, InputRow, MeasuringPart,
    ParameterAccess, ParameterRef, SerialNumber, exception_status,
};
use crate::store::Key;

impl ParameterAccess for Bcg450Behaviour {
    type Parameter = Parameter;

    /// Slot 1 shows the instance of the Channel Instance Selector (28).
    fn is_visible(&self, location: &Location) -> bool {
        location.instance == 0 || location.instance == self.selector
    }

    fn format(&self, at: &ParameterRef<Parameter>) -> PressureFormat {
        let part = self.part(at.instance()).unwrap_or(&self.pirani);
        self.presentation.format(Self::counts(part))
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
            Parameter::SetPoint(row) => {
                self.relay(at.instance()).map_or(Value::NONE, |relay| self.get_set_point(relay, row))
            }
            Parameter::HeatTransfer(row) => match row {
                HeatTransfer::BlockType => Value::octets(&HeatTransfer::BLOCK.type_octets()),
                HeatTransfer::StatusExtension => self.pirani.status_extension(&self.condition).bits().into(),
                HeatTransfer::SensorAlarm => Value::octets(&self.pirani.sensor_alarm()),
                HeatTransfer::SensorWarning => Value::octets(&self.pirani_warning()),
            },
            Parameter::HotCathode(row) => self.get_hot_cathode(row),
            Parameter::Diaphragm(row) => match row {
                Diaphragm::BlockType => Value::octets(&Diaphragm::BLOCK.type_octets()),
                Diaphragm::StatusExtension => self.cdg.status_extension(&self.condition).bits().into(),
                Diaphragm::SensorAlarm => Value::octets(&self.cdg.sensor_alarm()),
                Diaphragm::SensorWarning => Value::octets(&Self::CDG_WARNING),
            },
            Parameter::Atmosphere(row) => match row {
                Atmosphere::StateCommand => Value::octets(&[0, 0]),
                Atmosphere::BlockType => Value::octets(&Atmosphere::BLOCK.type_octets()),
            },
        }
    }

    /// Data Type and Data Units can be written in IDLE outside data exchange (91).
    fn check_mode(&self, at: &ParameterRef<Parameter>) -> Result<(), AccessError> {
        if is_presentation(at) && !self.machine.is_configurable() { Err(AccessError::WrongMode) } else { Ok(()) }
    }

    /// Unit and number type are one value for all instances (72).
    fn storage_key(&self, at: &ParameterRef<Parameter>) -> Key {
        if is_presentation(at) { at.shared_key() } else { at.key() }
    }

    fn set(&mut self, at: &ParameterRef<Parameter>, value: &Value) -> Result<(), AccessError> {
        match at.parameter {
            Parameter::Device(DeviceBlock::StateCommand) => self.state_command(value.integer()?),
            Parameter::OneOfNInput(OneOfNInput::ChannelInstanceSelector) => self.select(value.integer()?),
            Parameter::Input(_) | Parameter::SetPoint(SetPoint::DataType | SetPoint::DataUnits) => {
                self.set_input(at, value)
            }
            Parameter::SetPoint(SetPoint::SetpointFunction) => {
                self.relay_mut(at.instance()).ok_or(AccessError::UnknownIndex)?.set_function(value.boolean()?);
                Ok(())
            }
            Parameter::SetPoint(SetPoint::PercentageOfAtmosphere) => {
                self.relay_mut(at.instance()).ok_or(AccessError::UnknownIndex)?.set_percentage(value.integer()?)
            }
            Parameter::HotCathode(HotCathode::StateCommand) => self.hot_cathode_command(value.command_code()?),
            Parameter::HotCathode(HotCathode::EmissionStatus) => {
                let conditions = self.conditions();
                self.cathode.write_emission_status(value.integer()?, &conditions)
            }
            Parameter::HotCathode(HotCathode::EmissionCurrent) => EmissionCurrent::check(value),
            Parameter::Atmosphere(Atmosphere::StateCommand) => self.atmosphere_command(value.command_code()?),
            // Rows without a write mark: their access rights are checked before.
            Parameter::Device(_)
            | Parameter::OneOfNInput(_)
            | Parameter::OneOfNTransducer(_)
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

/// Whether it is Data Type or Data Units, of any instance.
const fn is_presentation(at: &ParameterRef<Parameter>) -> bool {
    matches!(at.parameter, Parameter::Input(_) | Parameter::SetPoint(_)) && InputRow::is_presentation(at.row.index)
}

impl DeviceBlockValues for Bcg450Behaviour {
    fn identity(&self) -> Identity {
        // chosen: gauge 100, PROFIBUS board 1.01 (36).
        Identity {
            model: self.presentation.model,
            device_type: "CG",
            model_number: "353-554",
            software: "100_1.01",
            configuration: self.presentation.model.title,
        }
    }

    fn serial(&self) -> &SerialNumber {
        &self.serial
    }

    fn device_state(&self) -> DeviceState {
        self.machine.state()
    }

    fn exception_status(&self) -> ExceptionStatus {
        exception_status(&self.alarm(), &self.warning())
    }

    fn alarm_record(&self) -> Value {
        self.alarm().record_of(self.alarm_details())
    }

    fn warning_record(&self) -> Value {
        self.warning().record_of(self.alarm_details().saturating_add(1))
    }
}

impl Bcg450Behaviour {
    fn get_device(&self, row: DeviceBlock) -> Value {
        match row {
            DeviceBlock::AlarmCommon => self.alarm().common.bits().into(),
            DeviceBlock::AlarmDevice0To3 => self.alarm().octets(0, 4),
            DeviceBlock::AlarmDevice4To5 => self.alarm().octets(4, 6),
            DeviceBlock::AlarmManufacturer => self.alarm().manufacturer.into(),
            DeviceBlock::WarningCommon => self.warning().common.bits().into(),
            DeviceBlock::WarningDevice0To3 => self.warning().octets(0, 4),
            DeviceBlock::WarningDevice4To6 => self.warning().octets(4, 7),
            DeviceBlock::WarningManufacturer => self.warning().manufacturer.into(),
            DeviceBlock::StateCommand
            | DeviceBlock::BlockType
            | DeviceBlock::DeviceType
            | DeviceBlock::StandardRevision
            | DeviceBlock::Manufacturer
            | DeviceBlock::ModelNumber
            | DeviceBlock::SoftwareRevision
            | DeviceBlock::HardwareRevision
            | DeviceBlock::SerialNumber
            | DeviceBlock::DeviceConfiguration
            | DeviceBlock::DeviceState
            | DeviceBlock::ExceptionStatus
            | DeviceBlock::AlarmDetail
            | DeviceBlock::WarningDetail => self.device_row(&DeviceBlock::BLOCK, row as u8),
        }
    }

    fn get_input(&self, part: &MeasuringPart, row: AnalogInput) -> Value {
        match row {
            AnalogInput::ProcessValue => Value::Pressure(part.process_value_pa(&self.condition)),
            AnalogInput::ReadingValid => part.is_valid(&self.condition).into(),
            AnalogInput::Status
            | AnalogInput::DataType
            | AnalogInput::DataUnits
            | AnalogInput::FullScale
            | AnalogInput::SafeState
            | AnalogInput::SafeValue
            | AnalogInput::Overrange
            | AnalogInput::Underrange => part.input_row(row as u8, &self.presentation),
        }
    }

    fn get_set_point(&self, relay: &Relay, row: SetPoint) -> Value {
        match row {
            SetPoint::SetpointFunction => relay.function().into(),
            SetPoint::PercentageOfAtmosphere => relay.percentage().into(),
            SetPoint::AtmosphereReached => relay.atmosphere_reached().into(),
            SetPoint::ProcessValue
            | SetPoint::Status
            | SetPoint::DataType
            | SetPoint::DataUnits
            | SetPoint::ReadingValid => relay.point.row(row as u8, &self.presentation),
        }
    }

    fn get_hot_cathode(&self, row: HotCathode) -> Value {
        let current = self.cathode.current();
        match row {
            HotCathode::StateCommand => Value::octets(&[0, 0]),
            HotCathode::BlockType => Value::octets(&HotCathode::BLOCK.type_octets()),
            HotCathode::StatusExtension => self.ba.status_extension(&self.condition).bits().into(),
            HotCathode::SensorAlarm => Value::octets(&self.ba.sensor_alarm()),
            HotCathode::SensorWarning => Value::octets(&self.ba_warning()),
            HotCathode::EmissionStatus => (current as u8).into(),
            HotCathode::EmissionCurrent => Value::Float(current.milliamperes()),
            HotCathode::DegasStatus => {
                if self.cathode.is_degassing() { DegasStatus::On } else { DegasStatus::Off }.code().into()
            }
            HotCathode::EmissionUserMode => self.cathode.is_automatic().into(),
        }
    }

    fn select(&mut self, instance: u8) -> Result<(), AccessError> {
        let (first, last) = INSTANCES;
        let is_known = |chosen: &u8| {
            if DESCRIBED { self.presentation.model.has_instance(1, *chosen) } else { (first..=last).contains(chosen) }
        };
        self.selector = Some(instance).filter(is_known).ok_or(AccessError::OutOfRange)?;
        Ok(())
    }

    /// A write of an analog input block, or of Data Type or Data Units of a set point.
    fn set_input(&mut self, at: &ParameterRef<Parameter>, value: &Value) -> Result<(), AccessError> {
        let row = InputRow::from_index(at.row.index).ok_or(AccessError::NotWritable)?;
        if is_presentation(at) {
            return self.presentation.set_row(row, value);
        }
        self.part_mut(at.instance()).ok_or(AccessError::UnknownIndex)?.set_input(row, value)
    }

    /// 3.3.3.9
    pub(super) fn hot_cathode_command(&mut self, code: u16) -> Result<(), AccessError> {
        let conditions = self.conditions();
        match HotCathodeCommand::from_code(code).ok_or(AccessError::OutOfRange)? {
            HotCathodeCommand::Inactive => {}
            HotCathodeCommand::DegasOff => self.cathode.stop_degas(),
            HotCathodeCommand::DegasOn => return self.cathode.start_degas(&conditions),
            HotCathodeCommand::EmissionOff => self.cathode.switch_off(),
            HotCathodeCommand::EmissionOn => return self.cathode.switch_on(&conditions),
            HotCathodeCommand::ManualMode => self.cathode.set_automatic(false),
            HotCathodeCommand::AutomaticMode => self.cathode.set_automatic(true),
        }
        Ok(())
    }

    /// 3.3.5.2 (116)
    fn atmosphere_command(&mut self, code: u16) -> Result<(), AccessError> {
        match AtmosphereCommand::from_code(code).ok_or(AccessError::OutOfRange)? {
            AtmosphereCommand::Inactive => {}
            AtmosphereCommand::AtmosphereAdjust => return self.adjust_atmosphere(),
            AtmosphereCommand::AtmosphereAdjustOff => self.reset_atmosphere(),
        }
        Ok(())
    }
}
