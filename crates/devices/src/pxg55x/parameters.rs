//! The value of every row of the tables, and the effect of writing it. Numbers in brackets are those of errata-pxg55x-img400.

use super::codes::SetpointMode;
use super::table::{
    AtmInput, AtmTransducer, CdgInput, CdgTransducer, DeviceBlock, DiscreteOutput, FIRMWARE, OneOfNInput,
    OneOfNTransducer, Parameter, PiraniInput, PiraniTransducer, TripPoint as Row,
};
use super::trip::{TripPoint, TripSide};
use super::{Pxg55xBehaviour, parts};
use crate::model::{AccessError, Block, Counts, Location, PressureFormat, Principle, Value};
use crate::profile::{
    DeviceBlockValues, DeviceState, ExceptionStatus, Identity, InputRow, MeasuringPart, ParameterAccess, ParameterRef,
    SerialNumber, exception_status,
};
use crate::store::Key;

/// The slots of the first trip point and of the first relay (95).
const TRIP_SLOT: u8 = 2;
const RELAY_SLOT: u8 = 4;

impl ParameterAccess for Pxg55xBehaviour {
    type Parameter = Parameter;

    /// Slot 1 shows the instance of the Channel Instance Selector (9.1.1).
    fn is_visible(&self, location: &Location) -> bool {
        location.instance == 0 || location.instance == self.selector
    }

    fn format(&self, at: &ParameterRef<Parameter>) -> PressureFormat {
        self.presentation.format(match at.parameter {
            Parameter::CdgInput(_) | Parameter::PiraniInput(_) | Parameter::AtmInput(_) => {
                self.part(at.instance()).map_or(parts::COUNTS, |part| part.spec.counts)
            }
            Parameter::TripPoint(Row::HighTripPointHysteresis) => self.hysteresis_counts(at, TripSide::High),
            Parameter::TripPoint(Row::LowTripPointHysteresis) => self.hysteresis_counts(at, TripSide::Low),
            _ => parts::COUNTS,
        })
    }

    fn get(&self, at: &ParameterRef<Parameter>) -> Value {
        match at.parameter {
            Parameter::Device(row) => self.get_device(row),
            Parameter::OneOfNInput(OneOfNInput::ChannelInstanceSelector) => self.selector.into(),
            Parameter::OneOfNInput(OneOfNInput::PvSelector) => self.active().part().instance.into(),
            Parameter::OneOfNTransducer(OneOfNTransducer::StatusExtension) => self.one_of_n().bits().into(),
            Parameter::CdgInput(_) | Parameter::PiraniInput(_) | Parameter::AtmInput(_) => {
                let value = |part, row| self.get_input(part, row);
                self.part(at.instance())
                    .zip(CdgInput::from_index(at.row.index))
                    .map_or(Value::NONE, |(part, row)| value(part, row))
            }
            Parameter::CdgTransducer(_) | Parameter::PiraniTransducer(_) | Parameter::AtmTransducer(_) => {
                let value = |part, row| self.get_transducer(part, row);
                let row = PiraniTransducer::from_index(at.row.index);
                self.part(at.instance()).zip(row).map_or(Value::NONE, |(part, row)| value(part, row))
            }
            Parameter::TripPoint(row) => self.trip(at).map_or(Value::NONE, |trip| self.get_trip(trip, row)),
            Parameter::DiscreteOutput(row) => self.get_relay(at, row),
        }
    }

    /// Data Unit can be written in IDLE, Data Type outside data exchange (84), a calculated trip point never (101).
    fn check_mode(&self, at: &ParameterRef<Parameter>) -> Result<(), AccessError> {
        let permitted = match at.parameter {
            Parameter::TripPoint(Row::LowTripPoint) => !self.calculates(at, TripSide::Low),
            Parameter::TripPoint(Row::HighTripPoint) => !self.calculates(at, TripSide::High),
            parameter if is_unit(parameter) => self.machine.is_configurable(),
            parameter if is_number(parameter) => !self.machine.is_exchanging(),
            _ => true,
        };
        if permitted { Ok(()) } else { Err(AccessError::WrongMode) }
    }

    fn resets_to_factory(&self, at: &ParameterRef<Parameter>, value: &Value) -> bool {
        matches!(at.parameter, Parameter::Device(DeviceBlock::StateCommand))
            && value.integer() == Ok(super::FACTORY_RESET)
    }

    /// Unit and number type are one value for all blocks.
    fn storage_key(&self, at: &ParameterRef<Parameter>) -> Key {
        let shared = |row| Key::Parameter { slot: 1, instance: 0, index: row as u8 };
        match at.parameter {
            parameter if is_unit(parameter) => shared(CdgInput::DataUnit),
            parameter if is_number(parameter) => shared(CdgInput::DataType),
            _ => at.key(),
        }
    }

    fn set(&mut self, at: &ParameterRef<Parameter>, value: &Value) -> Result<(), AccessError> {
        match at.parameter {
            Parameter::Device(DeviceBlock::StateCommand) => self.state_command(value.integer()?),
            Parameter::OneOfNInput(OneOfNInput::ChannelInstanceSelector) => self.select(value.integer()?),
            parameter if is_unit(parameter) => self.presentation.set_unit(value),
            parameter if is_number(parameter) => self.presentation.set_number(value),
            Parameter::CdgInput(_) | Parameter::PiraniInput(_) | Parameter::AtmInput(_) => {
                let row = CdgInput::from_index(at.row.index).ok_or(AccessError::UnknownIndex)?;
                self.set_input(at.instance(), row, value)
            }
            Parameter::PiraniTransducer(PiraniTransducer::PiraniOff) => {
                self.heating.mode = value.coded()?;
                Ok(())
            }
            Parameter::TripPoint(row) => self.set_trip(at, row, value),
            // Rows without a write mark: their access rights are checked before.
            Parameter::Device(_)
            | Parameter::OneOfNInput(_)
            | Parameter::OneOfNTransducer(_)
            | Parameter::CdgTransducer(_)
            | Parameter::PiraniTransducer(_)
            | Parameter::AtmTransducer(_)
            | Parameter::DiscreteOutput(_) => Err(AccessError::NotWritable),
        }
    }

    fn internal_values(&self) -> &[f64] {
        &self.stored.values
    }

    fn internal_values_mut(&mut self) -> &mut [f64] {
        &mut self.stored.values
    }
}

/// Whether it is Data Unit, of any block.
const fn is_unit(parameter: Parameter) -> bool {
    matches!(
        parameter,
        Parameter::CdgInput(CdgInput::DataUnit)
            | Parameter::PiraniInput(PiraniInput::DataUnit)
            | Parameter::AtmInput(AtmInput::DataUnit)
            | Parameter::TripPoint(Row::DataUnits)
    )
}

/// Whether it is Data Type, of any block.
const fn is_number(parameter: Parameter) -> bool {
    matches!(
        parameter,
        Parameter::CdgInput(CdgInput::DataType)
            | Parameter::PiraniInput(PiraniInput::DataType)
            | Parameter::AtmInput(AtmInput::DataType)
            | Parameter::TripPoint(Row::DataType)
    )
}

/// The octets of a Block Type ID.
fn block_type(block: &Block) -> Value {
    Value::octets(&block.type_octets())
}

impl DeviceBlockValues for Pxg55xBehaviour {
    fn identity(&self) -> Identity {
        Identity {
            model: self.presentation.model,
            device_type: self.variant.family.device_type,
            model_number: self.variant.number,
            software: FIRMWARE,
            configuration: self.variant.configuration,
        }
    }

    fn serial(&self) -> &SerialNumber {
        &self.serial
    }

    fn device_state(&self) -> DeviceState {
        self.machine.state()
    }

    fn exception_status(&self) -> ExceptionStatus {
        exception_status(&self.alarm::<4>(), &self.warning::<5>())
    }

    /// 10 octets of a PCG55x, 8 of a PSG55x (7.1.12).
    fn alarm_record(&self) -> Value {
        if self.cdg.is_some() { self.alarm::<4>().record() } else { self.alarm::<2>().record() }
    }

    /// 11 octets of a PCG55x, 9 of a PSG55x (7.1.13, 72).
    fn warning_record(&self) -> Value {
        if self.cdg.is_some() { self.warning::<5>().record() } else { self.warning::<3>().record() }
    }
}

impl Pxg55xBehaviour {
    fn get_device(&self, row: DeviceBlock) -> Value {
        match row {
            DeviceBlock::StateCommand
            | DeviceBlock::BlockType
            | DeviceBlock::DeviceType
            | DeviceBlock::StandardRevision
            | DeviceBlock::Manufacturer
            | DeviceBlock::ModelNumber
            | DeviceBlock::FirmwareRevision
            | DeviceBlock::HardwareRevision
            | DeviceBlock::SerialNumber
            | DeviceBlock::DeviceConfiguration
            | DeviceBlock::DeviceState
            | DeviceBlock::ExceptionStatus
            | DeviceBlock::ExceptionDetailAlarm
            | DeviceBlock::ExceptionDetailWarning => self.device_row(&DeviceBlock::BLOCK, row as u8),
            DeviceBlock::BasicDeviceFirmwareRevision => Value::text(FIRMWARE),
            DeviceBlock::RunHours => self.stored.hours().into(),
            DeviceBlock::CommonExceptionAlarm | DeviceBlock::CommonExceptionWarning => {
                Value::octets(&[self.common().bits(), 0])
            }
            // The shorter row of a PSG55x cuts the octets of the instance that it does not have.
            DeviceBlock::DeviceExceptionAlarm => self.alarm::<4>().octets(0, 4),
            DeviceBlock::ManufacturerExceptionAlarm | DeviceBlock::ManufacturerExceptionWarning => {
                self.manufacturer().into()
            }
            DeviceBlock::DeviceExceptionWarning1 => self.one_of_n().bits().into(),
            DeviceBlock::DeviceExceptionWarning2 => self.warning::<5>().octets(1, 5),
            DeviceBlock::AddressSwitch => self.address_switch.into(),
            DeviceBlock::RunHours4 => self.stored.quarters().into(),
        }
    }

    fn get_input(&self, part: &MeasuringPart, row: CdgInput) -> Value {
        match row {
            // A read shows that the command has been executed (78).
            CdgInput::AdjustCommand => Value::octets(&[0, 0]),
            CdgInput::BlockType => block_type(&CdgInput::BLOCK),
            CdgInput::ProcessValue => Value::Pressure(self.process_value_pa(part)),
            CdgInput::ReadingValid => self.is_valid(part).into(),
            CdgInput::AutoZeroEnable => self.auto_zero.into(),
            CdgInput::Status
            | CdgInput::DataType
            | CdgInput::DataUnit
            | CdgInput::FullScale
            | CdgInput::SafeState
            | CdgInput::SafeValue
            | CdgInput::Overrange
            | CdgInput::Underrange => part.input_row(row as u8, &self.presentation),
        }
    }

    fn get_transducer(&self, part: &MeasuringPart, row: PiraniTransducer) -> Value {
        match row {
            PiraniTransducer::BlockType => block_type(match part.part().principle {
                Principle::Diaphragm => &CdgTransducer::BLOCK,
                Principle::Atmosphere => &AtmTransducer::BLOCK,
                Principle::Pirani | Principle::HotCathode | Principle::ColdCathode => &PiraniTransducer::BLOCK,
            }),
            PiraniTransducer::StatusExtension => self.status_extension(part).bits().into(),
            PiraniTransducer::SensorAlarm => Value::octets(&self.sensor_alarm(part.part().instance)),
            // "Always 0", both octets (106).
            PiraniTransducer::SensorWarning => Value::octets(&[0, 0]),
            PiraniTransducer::PiraniOff => self.heating.mode.code().into(),
        }
    }

    fn get_trip(&self, trip: &TripPoint, row: Row) -> Value {
        let (low, high) = (trip.limit(TripSide::Low), trip.limit(TripSide::High));
        match row {
            Row::BlockType => block_type(&Row::BLOCK),
            Row::HighTripPoint => Value::Pressure(high.point_pa),
            Row::HighTripEnable => high.enabled.into(),
            Row::LowTripPoint => Value::Pressure(low.point_pa),
            Row::LowTripEnable => low.enabled.into(),
            Row::Status => u8::from(trip.status()).into(),
            // Always the only instance in the slot of the relay (95).
            Row::DiscreteOutputInstance => Value::Integer(1),
            Row::DataUnits => self.presentation.unit.code.into(),
            Row::DataType => self.presentation.number.code().into(),
            Row::HighTripPointHysteresis => Value::Pressure(high.hysteresis_pa),
            Row::LowTripPointHysteresis => Value::Pressure(low.hysteresis_pa),
            Row::FactorOfAtm => Value::Float(trip.factor),
            Row::SetpointMode => trip.mode.code().into(),
        }
    }

    fn get_relay(&self, at: &ParameterRef<Parameter>, row: DiscreteOutput) -> Value {
        let trip = index(at, RELAY_SLOT).and_then(|relay| self.trips.get(relay));
        match row {
            DiscreteOutput::BlockType => block_type(&DiscreteOutput::BLOCK),
            // No telegram has it: the trip point sets it (93).
            DiscreteOutput::SetpointValue => u8::from(trip.is_some_and(TripPoint::status)).into(),
            DiscreteOutput::Status => self.outputs_have_error().into(),
        }
    }

    fn trip(&self, at: &ParameterRef<Parameter>) -> Option<&TripPoint> {
        self.trips.get(index(at, TRIP_SLOT)?)
    }

    fn trip_mut(&mut self, at: &ParameterRef<Parameter>) -> Result<&mut TripPoint, AccessError> {
        index(at, TRIP_SLOT).and_then(|trip| self.trips.get_mut(trip)).ok_or(AccessError::UnknownSlot)
    }

    /// Whether this trip point calculates this side.
    fn calculates(&self, at: &ParameterRef<Parameter>, side: TripSide) -> bool {
        self.trip(at).and_then(|trip| trip.mode.calculated()) == Some(side)
    }

    /// The scale of a hysteresis begins at its trip point (32).
    fn hysteresis_counts(&self, at: &ParameterRef<Parameter>, side: TripSide) -> Counts {
        let point_pa = self.trip(at).map_or(0.0, |trip| trip.limit(side).point_pa);
        parts::hysteresis_counts(point_pa, side == TripSide::Low)
    }

    /// Sets the Channel Instance Selector to an instance that the gauge has (68).
    fn select(&mut self, instance: u8) -> Result<(), AccessError> {
        self.part(instance).ok_or(AccessError::OutOfRange)?;
        self.selector = instance;
        Ok(())
    }

    fn set_input(&mut self, instance: u8, row: CdgInput, value: &Value) -> Result<(), AccessError> {
        let part = self.part_mut(instance).ok_or(AccessError::UnknownIndex)?;
        match row {
            CdgInput::AdjustCommand => self.adjust(instance, value.command()?.0)?,
            CdgInput::SafeState => part.set_input(InputRow::SafeState, value)?,
            CdgInput::SafeValue => part.set_input(InputRow::SafeValue, value)?,
            CdgInput::AutoZeroEnable => self.auto_zero = value.boolean()?,
            CdgInput::DataUnit => self.presentation.set_unit(value)?,
            CdgInput::DataType => self.presentation.set_number(value)?,
            CdgInput::BlockType
            | CdgInput::ProcessValue
            | CdgInput::Status
            | CdgInput::ReadingValid
            | CdgInput::FullScale
            | CdgInput::Overrange
            | CdgInput::Underrange => return Err(AccessError::NotWritable),
        }
        Ok(())
    }

    fn set_trip(&mut self, at: &ParameterRef<Parameter>, row: Row, value: &Value) -> Result<(), AccessError> {
        let has_atmosphere = self.atm.is_some();
        let trip = self.trip_mut(at)?;
        match row {
            Row::HighTripPoint => trip.limit_mut(TripSide::High).point_pa = value.pressure()?,
            Row::HighTripEnable => trip.limit_mut(TripSide::High).enabled = value.boolean()?,
            Row::LowTripPoint => trip.limit_mut(TripSide::Low).point_pa = value.pressure()?,
            Row::LowTripEnable => trip.limit_mut(TripSide::Low).enabled = value.boolean()?,
            Row::HighTripPointHysteresis => trip.limit_mut(TripSide::High).hysteresis_pa = value.pressure()?,
            Row::LowTripPointHysteresis => trip.limit_mut(TripSide::Low).hysteresis_pa = value.pressure()?,
            Row::FactorOfAtm => trip.factor = factor(value)?,
            Row::SetpointMode => trip.mode = mode(value, has_atmosphere)?,
            Row::DataUnits => self.presentation.set_unit(value)?,
            Row::DataType => self.presentation.set_number(value)?,
            Row::BlockType | Row::Status | Row::DiscreteOutputInstance => return Err(AccessError::NotWritable),
        }
        Ok(())
    }
}

/// The number of slots after the first of its kind.
fn index(at: &ParameterRef<Parameter>, first: u8) -> Option<usize> {
    at.location.slot.checked_sub(first).map(usize::from)
}

/// The factor of the atmosphere.
///
/// chosen: the manual gives no range; a negative factor gives no pressure.
fn factor(value: &Value) -> Result<f32, AccessError> {
    match value {
        Value::Float(factor) if *factor >= 0.0 => Ok(*factor),
        _ => Err(AccessError::OutOfRange),
    }
}

/// The mode of a trip point. The modes that calculate a point need an atmosphere sensor (100).
fn mode(value: &Value, has_atmosphere: bool) -> Result<SetpointMode, AccessError> {
    let mode: SetpointMode = value.coded()?;
    if mode.calculated().is_some() && !has_atmosphere { Err(AccessError::OutOfRange) } else { Ok(mode) }
}
