//! The value of every row of the tables, and the effect of writing it. Numbers in brackets are those of errata-bpg-bcg-tpg.

use super::codes::{DegasStatus, HotCathodeCommand};
use super::parts::INSTANCES;
use super::table::{
    AnalogInput, Degas, DeviceBlock, HeatTransfer, HotCathode, OneOfNInput, OneOfNTransducer, Parameter, SetPoint,
    SideSwitches,
};
use super::{Xpg400Behaviour, Xpg400Model};
use crate::model::{AccessError, Counts, DESCRIBED, Location, PressureFormat, Value};
use crate::profile::{
    DeviceBlockValues, DeviceState, EmissionCurrent, ExceptionStatus, Identity, InputRow, MeasuringPart,
    ParameterAccess, ParameterRef, RelaySetPoint, SerialNumber, exception_status,
};
use crate::store::Key;

impl ParameterAccess for Xpg400Behaviour {
    type Parameter = Parameter;

    /// Slot 1 shows the instance of the Channel Instance Selector (28).
    fn is_visible(&self, location: &Location) -> bool {
        location.instance == 0 || location.instance == self.selector
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
            Parameter::SetPoint(row) => {
                self.set_point(at.instance()).map_or(Value::NONE, |point| self.get_set_point(point, row))
            }
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
                Degas::DegasStatus => {
                    if self.cathode.is_degassing() { DegasStatus::On } else { DegasStatus::Off }.code().into()
                }
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
            Parameter::OneOfNInput(OneOfNInput::AdjustCommand) => self.adjust(value.integer()?),
            Parameter::OneOfNInput(OneOfNInput::ChannelInstanceSelector) => self.select(value.integer()?),
            Parameter::Input(_) | Parameter::SetPoint(SetPoint::DataType | SetPoint::DataUnits) => {
                self.set_input(at, value)
            }
            // A master may switch the emission off, and on where the gauge would (97).
            Parameter::HotCathode(HotCathode::EmissionStatus) => {
                let conditions = self.conditions();
                self.cathode.write_emission_status(value.integer()?, &conditions)
            }
            Parameter::Degas(Degas::StateCommand) => self.hot_cathode_command(value.command_code()?),
            Parameter::Degas(Degas::EmissionCurrent) => EmissionCurrent::check(value),
            // Rows without a write mark: their access rights are checked before.
            Parameter::Device(_)
            | Parameter::SideSwitches(_)
            | Parameter::OneOfNInput(_)
            | Parameter::OneOfNTransducer(_)
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

/// Whether it is Data Type or Data Units, of any instance.
const fn is_presentation(at: &ParameterRef<Parameter>) -> bool {
    matches!(at.parameter, Parameter::Input(_) | Parameter::SetPoint(_)) && InputRow::is_presentation(at.row.index)
}

impl DeviceBlockValues for Xpg400Behaviour {
    fn identity(&self) -> Identity {
        let variant = self.model.variant();
        Identity {
            model: self.presentation.model,
            device_type: "CG",
            model_number: variant.number,
            software: self.presentation.model.gsd.software,
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
        self.alarm().record()
    }

    fn warning_record(&self) -> Value {
        self.warning().record()
    }
}

impl Xpg400Behaviour {
    /// The COUNTS of a parameter; those of the switchover are those of the Pirani (66).
    fn counts(&self, at: &ParameterRef<Parameter>) -> Counts {
        match at.parameter {
            Parameter::SetPoint(_) => self.model.variant().set_point_counts,
            _ => self.part(at.instance()).unwrap_or(&self.pirani).spec.counts,
        }
    }

    fn get_device(&self, row: DeviceBlock) -> Value {
        match row {
            DeviceBlock::AlarmCommon => self.alarm().common.bits().into(),
            DeviceBlock::AlarmDevice => self.alarm().octets(0, 4),
            DeviceBlock::AlarmManufacturer => self.alarm().manufacturer.into(),
            DeviceBlock::WarningCommon => self.warning().common.bits().into(),
            DeviceBlock::WarningDevice => self.warning().octets(1, 5),
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

    fn get_set_point(&self, point: &RelaySetPoint, row: SetPoint) -> Value {
        point.row(row as u8, &self.presentation)
    }

    /// The HPG400-SP has one current, and its code is 1 (97).
    pub(super) fn current(&self) -> EmissionCurrent {
        match self.model {
            Xpg400Model::Bpg => self.cathode.current(),
            Xpg400Model::Hpg if self.cathode.is_on() => EmissionCurrent::Low,
            Xpg400Model::Hpg => EmissionCurrent::Off,
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

    /// 3.3.3.8: nothing but degas.
    fn hot_cathode_command(&mut self, code: u16) -> Result<(), AccessError> {
        let conditions = self.conditions();
        match HotCathodeCommand::from_code(code).ok_or(AccessError::OutOfRange)? {
            HotCathodeCommand::Inactive => {}
            HotCathodeCommand::DegasOff => self.cathode.stop_degas(),
            HotCathodeCommand::DegasOn => return self.cathode.start_degas(&conditions),
        }
        Ok(())
    }
}
