//! The value of every row of the tables, and the effect of writing it. Numbers in brackets are those of
//! errata-pxg55x-img400.

use super::codes::HotCathodeCommand;
use super::table::{AnalogInput, DeviceBlock, Diaphragm, HeatTransfer, HotCathode, Parameter, TripPoint};
use super::{GaugeChannel, Img400Behaviour};
use crate::model::{AccessError, Block, Location, PressureFormat, Value};
use crate::profile::{DeviceState, InputRow, ParameterAccess, ParameterRef};
use crate::store::Key;

impl ParameterAccess for Img400Behaviour {
    type Parameter = Parameter;

    /// Every slot can be accessed, with any fitted gauges (156).
    fn is_visible(&self, _location: &Location) -> bool {
        true
    }

    fn format(&self, at: &ParameterRef<Parameter>) -> PressureFormat {
        match (at.parameter, self.trip(at.location.slot)) {
            (Parameter::Trip(TripPoint::Hysteresis), Some(trip)) => trip.hysteresis_format(self.format()),
            _ => self.format(),
        }
    }

    fn get(&self, at: &ParameterRef<Parameter>) -> Value {
        let slot = at.location.slot;
        match at.parameter {
            Parameter::Device(row) => self.get_device(row),
            Parameter::Input(row) => {
                self.channel(slot).map_or(Value::NONE, |channel| self.get_input(slot, channel, row))
            }
            Parameter::Trip(row) => self.get_trip(slot, row),
            Parameter::HotCathode(row) => self.get_hot_cathode(slot, row),
            Parameter::HeatTransfer(HeatTransfer::BlockType) | Parameter::Diaphragm(Diaphragm::BlockType) => {
                block_type(self.transducer(slot))
            }
            Parameter::HeatTransfer(HeatTransfer::StatusExtension)
            | Parameter::Diaphragm(Diaphragm::StatusExtension) => self.status_extension(slot).bits().into(),
            Parameter::HeatTransfer(HeatTransfer::SensorAlarm) | Parameter::Diaphragm(Diaphragm::SensorAlarm) => {
                Value::octets(&self.sensor_alarm(slot))
            }
            Parameter::HeatTransfer(HeatTransfer::SensorWarning) | Parameter::Diaphragm(Diaphragm::SensorWarning) => {
                Value::octets(&self.sensor_warning(slot))
            }
        }
    }

    /// Data Type is fixed during data exchange (4.4.2, 142).
    fn check_mode(&self, at: &ParameterRef<Parameter>) -> Result<(), AccessError> {
        let is_type = matches!(at.parameter, Parameter::Input(AnalogInput::DataType));
        if is_type && self.machine.is_exchanging() { Err(AccessError::WrongMode) } else { Ok(()) }
    }

    fn set(&mut self, at: &ParameterRef<Parameter>, value: &Value) -> Result<(), AccessError> {
        let slot = at.location.slot;
        match at.parameter {
            Parameter::Device(DeviceBlock::StateCommand) => self.state_command(value.integer()?),
            // It locks the keys, never the bus (129).
            Parameter::Device(DeviceBlock::KeyLock) => {
                self.key_lock = value.coded()?;
                Ok(())
            }
            Parameter::Device(DeviceBlock::ResetErrorCondition) => {
                self.reset_errors(value.integer()?);
                Ok(())
            }
            Parameter::Input(row) => self.set_input(slot, row, value),
            Parameter::Trip(row) => self.set_trip(slot, row, value),
            Parameter::HotCathode(HotCathode::StateCommand) => self.hot_cathode_command(slot, value.command_code()?),
            // A write has the effect of the command (149).
            Parameter::HotCathode(HotCathode::EmissionStatus) => {
                let on = value.boolean()?;
                let command = if on { HotCathodeCommand::EmissionOn } else { HotCathodeCommand::EmissionOff };
                self.hot_cathode_command(slot, command.code())
            }
            Parameter::HotCathode(HotCathode::EmissionCurrent) => {
                self.ion_mut(slot).ok_or(AccessError::UnknownSlot)?.set_current(value)
            }
            // Rows without a write mark: their access rights are checked before.
            Parameter::Device(_) | Parameter::HotCathode(_) | Parameter::HeatTransfer(_) | Parameter::Diaphragm(_) => {
                Err(AccessError::NotWritable)
            }
        }
    }

    /// A trip point is restored directly, not written: its numbers depend on the unit, and a write of one moves
    /// another.
    fn restore(&mut self, at: &ParameterRef<Parameter>, value: &Value) -> Result<(), AccessError> {
        let Parameter::Trip(row) = at.parameter else { return self.set(at, value) };
        let trip = self.trip_mut(at.location.slot).ok_or(AccessError::UnknownSlot)?;
        match row {
            TripPoint::LowTripPoint => trip.restore(Some(value.pressure()?), None),
            TripPoint::UpperThreshold => trip.restore(None, Some(value.pressure()?)),
            // The two determine it.
            TripPoint::Hysteresis => {}
            _ => return self.set(at, value),
        }
        Ok(())
    }

    /// Unit and number type are one value for all channels (4.4.2).
    fn storage_key(&self, at: &ParameterRef<Parameter>) -> Key {
        match at.parameter {
            Parameter::Input(AnalogInput::DataType | AnalogInput::DataUnits) => {
                Key::Parameter { slot: 1, instance: 0, index: at.row.index }
            }
            _ => at.key(),
        }
    }

    fn internal_values(&self) -> &[f64] {
        &self.offsets_pa
    }

    fn internal_values_mut(&mut self) -> &mut [f64] {
        &mut self.offsets_pa
    }
}

fn block_type(block: &Block) -> Value {
    Value::octets(&block.type_octets())
}

impl Img400Behaviour {
    fn get_device(&self, row: DeviceBlock) -> Value {
        match row {
            // A read shows that the command has been executed (26), and 205 cannot be read (128).
            DeviceBlock::StateCommand | DeviceBlock::ResetErrorCondition => Value::Integer(0),
            DeviceBlock::BlockType => block_type(&DeviceBlock::BLOCK),
            DeviceBlock::DeviceState => match self.machine.state() {
                // INIT has a code of its own (20).
                DeviceState::Init => DeviceState::INIT_CODE.into(),
                state => state.code().into(),
            },
            DeviceBlock::ExceptionStatus => self.exception_status().bits().into(),
            DeviceBlock::KeyLock => self.key_lock.code().into(),
            DeviceBlock::ChannelStatus => Value::octets(&self.channel_status()),
        }
    }

    fn get_input(&self, slot: u8, channel: &GaugeChannel, row: AnalogInput) -> Value {
        let part = &channel.part;
        match row {
            // A command has no value: zeros are read (130).
            AnalogInput::BlockAdjustCommand => Value::octets(&[0, 0]),
            AnalogInput::BlockType => block_type(&AnalogInput::BLOCK),
            AnalogInput::ProcessValue => Value::Pressure(self.process_value_pa(slot)),
            AnalogInput::ReadingValid => self.is_valid(slot).into(),
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

    fn get_trip(&self, slot: u8, row: TripPoint) -> Value {
        let Some(trip) = self.trip(slot) else { return Value::NONE };
        match row {
            TripPoint::BlockType => block_type(&TripPoint::BLOCK),
            TripPoint::LowTripPoint => Value::Pressure(trip.low_pa()),
            TripPoint::LowTripEnable => trip.enabled.into(),
            TripPoint::Status => u8::from(trip.is_closed()).into(),
            TripPoint::Hysteresis => Value::Pressure(trip.hysteresis_pa()),
            TripPoint::Channel => trip.channel().into(),
            TripPoint::DataUnits => self.presentation.unit.code.into(),
            TripPoint::DataType => self.presentation.number.code().into(),
            TripPoint::UpperThreshold => Value::Pressure(trip.upper_pa()),
        }
    }

    fn get_hot_cathode(&self, slot: u8, row: HotCathode) -> Value {
        let Some(ion) = self.ion(slot) else { return Value::NONE };
        match row {
            HotCathode::StateCommand => Value::octets(&[0, 0]),
            HotCathode::BlockType => block_type(&HotCathode::BLOCK),
            HotCathode::StatusExtension => self.status_extension(slot).bits().into(),
            HotCathode::SensorAlarm => Value::octets(&self.sensor_alarm(slot)),
            HotCathode::SensorWarning => Value::octets(&self.sensor_warning(slot)),
            HotCathode::EmissionStatus => ion.is_on().into(),
            HotCathode::EmissionCurrent => ion.current(),
            HotCathode::DegasStatus => ion.is_degassing().into(),
        }
    }

    /// The transducer block of channel 3 or 4 (154, 156).
    fn transducer(&self, slot: u8) -> &'static Block {
        let is_diaphragm = self.channel(slot).is_some_and(GaugeChannel::is_diaphragm);
        if is_diaphragm { &const { Diaphragm::BLOCK } } else { &const { HeatTransfer::BLOCK } }
    }

    fn set_input(&mut self, slot: u8, row: AnalogInput, value: &Value) -> Result<(), AccessError> {
        match row {
            AnalogInput::BlockAdjustCommand => self.adjust(slot, value.coded()?),
            AnalogInput::DataType => self.presentation.set_number(value),
            // From the memory only: the user parameters set it (143).
            AnalogInput::DataUnits => self.presentation.set_unit(value),
            AnalogInput::SafeState => {
                self.channel_mut(slot).ok_or(AccessError::UnknownSlot)?.part.set_input(InputRow::SafeState, value)
            }
            AnalogInput::SafeValue => {
                self.channel_mut(slot).ok_or(AccessError::UnknownSlot)?.part.set_input(InputRow::SafeValue, value)
            }
            AnalogInput::BlockType
            | AnalogInput::ProcessValue
            | AnalogInput::Status
            | AnalogInput::ReadingValid
            | AnalogInput::FullScale
            | AnalogInput::Overrange
            | AnalogInput::Underrange => Err(AccessError::NotWritable),
        }
    }

    fn set_trip(&mut self, slot: u8, row: TripPoint, value: &Value) -> Result<(), AccessError> {
        let format = self.format();
        let trip = self.trip_mut(slot).ok_or(AccessError::UnknownSlot)?;
        match row {
            TripPoint::LowTripPoint => trip.set_low(value.pressure()?, format),
            TripPoint::LowTripEnable => {
                trip.enabled = value.boolean()?;
                Ok(())
            }
            TripPoint::Hysteresis => {
                trip.set_hysteresis(value.pressure()?);
                Ok(())
            }
            TripPoint::Channel => trip.set_channel(value.integer()?),
            TripPoint::UpperThreshold => trip.set_upper(value.pressure()?),
            TripPoint::BlockType | TripPoint::Status | TripPoint::DataUnits | TripPoint::DataType => {
                Err(AccessError::NotWritable)
            }
        }
    }
}
