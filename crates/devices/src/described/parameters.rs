//! The value of the rows of a described device, and the effect of writing them.

use super::trip::TripRow;
use super::{BlockBehaviour, DescribedBehaviour, Meaning, Sensing};
use crate::model::code_table::{code_of, value_of};
use crate::model::{AccessError, DataType, Location, ParameterSet, PlacedBlock, PressureFormat, Role, Value};
use crate::profile::{
    Cathode, DeviceBlockValues, DeviceRow, DeviceState, ExceptionStatus, Identity, InputRow, ParameterAccess,
    ParameterRef, SerialNumber, exception_status,
};
use crate::store::Key;

/// A row of a described device.
#[derive(Clone, Copy, Debug)]
pub struct DescribedParameter {
    /// The position of its block.
    block: usize,
}

impl ParameterSet for DescribedParameter {
    const BLOCKS: &'static [PlacedBlock] = &[];

    fn of(position: usize, _index: u8) -> Option<Self> {
        Some(Self { block: position })
    }
}

/// Whether a value can be one of this type.
const fn fits(value: &Value, data_type: DataType) -> bool {
    match value {
        Value::Boolean(_) => matches!(data_type, DataType::Boolean),
        Value::Integer(_) => data_type.is_integer(),
        Value::Float(_) => matches!(data_type, DataType::Float),
        Value::Pressure(_) => matches!(data_type, DataType::ByType),
        Value::Octets(_) => matches!(
            data_type,
            DataType::Visible(_) | DataType::OctetString(_) | DataType::Array(_) | DataType::Record(_)
        ),
    }
}

type At = ParameterRef<DescribedParameter>;

impl DescribedBehaviour {
    fn meaning_of(&self, at: &At) -> Option<Meaning> {
        self.meaning(at.parameter.block, at.location, at.row)
    }

    fn value(&self, meaning: Meaning, at: &At) -> Value {
        let part = |position: usize| self.sensing().get(position);
        let of_part = |position: usize, value: &dyn Fn(&Sensing) -> Value| part(position).map_or(Value::NONE, value);
        let placed = self.description.model.blocks.get(at.parameter.block);
        match meaning {
            Meaning::Device(_) => placed.map_or(Value::NONE, |placed| self.device_row(placed.block, at.row.index)),
            Meaning::BlockType => placed.map_or(Value::NONE, |placed| Value::octets(&placed.block.type_octets())),
            Meaning::Selector => self.selector.into(),
            Meaning::PvSelector => self.active().map_or(0, |part| part.part().instance).into(),
            Meaning::OneOfN => self.one_of_n.bits().into(),
            Meaning::Presentation(InputRow::DataType) => Value::Integer(self.presentation.number.code().into()),
            Meaning::Presentation(_) => self.presentation.unit.code.into(),
            Meaning::Input(position, InputRow::ProcessValue) => {
                of_part(position, &|it| Value::Pressure(it.part.process_value_pa(&self.condition)))
            }
            Meaning::Input(position, InputRow::ReadingValid) => {
                of_part(position, &|it| Value::Integer(it.part.is_valid(&self.condition).into()))
            }
            Meaning::Input(position, _) => of_part(position, &|it| it.part.input_row(at.row.index, &self.presentation)),
            Meaning::Status(position) => {
                of_part(position, &|it| it.part.status_extension(&self.condition).bits().into())
            }
            Meaning::SensorAlarm(position) => of_part(position, &|it| Value::octets(&it.part.sensor_alarm())),
            Meaning::Emission(position) => of_part(position, &|it| Value::Integer(it.cathode.is_on().into())),
            Meaning::Degas(position) => of_part(position, &|it| Value::Integer(it.cathode.is_degassing().into())),
            Meaning::Command(_) => value_of(0, at.row.data_type),
            Meaning::Trip(number, row) => self.trips.get(number).map_or(Value::NONE, |trip| match row {
                TripRow::Threshold => Value::Pressure(trip.threshold_pa),
                TripRow::Hysteresis => Value::Pressure(trip.hysteresis_pa),
                TripRow::Enable => Value::Integer(trip.enabled.into()),
                TripRow::Status => trip.status().into(),
                TripRow::Source => trip.source.into(),
            }),
        }
    }

    fn set_trip(&mut self, number: usize, row: TripRow, value: &Value) -> Result<(), AccessError> {
        let source = if row == TripRow::Source { value.integer()? } else { 0 };
        if source > 0 && self.position(source).is_none() {
            return Err(AccessError::OutOfRange);
        }
        let trip = self.trips.get_mut(number).ok_or(AccessError::UnknownIndex)?;
        match row {
            TripRow::Threshold => trip.threshold_pa = value.pressure()?,
            TripRow::Hysteresis => trip.hysteresis_pa = value.pressure()?,
            TripRow::Enable => trip.enabled = value.boolean()?,
            TripRow::Source => trip.source = source,
            TripRow::Status => return Err(AccessError::NotWritable),
        }
        Ok(())
    }

    fn set_emission(&mut self, position: usize, value: &Value) -> Result<(), AccessError> {
        let code = value.integer()?;
        let conditions = self.conditions(position);
        let it = self.sensing.get_mut(position).ok_or(AccessError::UnknownIndex)?;
        it.cathode.write_emission_status(code, &conditions)
    }
}

impl ParameterAccess for DescribedBehaviour {
    type Parameter = DescribedParameter;

    /// The instance of the Channel Instance Selector; every one where the device has no selector.
    fn is_visible(&self, location: &Location) -> bool {
        let mut rows = self.description.model.blocks.iter().flat_map(|placed| placed.block.rows);
        location.instance == 0
            || location.instance == self.selector
            || !rows.any(|row| row.role == Some(Role::InstanceSelector))
    }

    fn has_value(&self, at: &At) -> bool {
        self.meaning_of(at).is_some_and(|meaning| fits(&self.value(meaning, at), at.row.data_type))
    }

    fn format(&self, at: &At) -> PressureFormat {
        let part = self.part_at(at.location).and_then(|position| self.sensing().get(position));
        self.format_of(part.map(|it| &it.part).or_else(|| self.active()))
    }

    fn get(&self, at: &At) -> Value {
        self.meaning_of(at).map_or(Value::NONE, |meaning| self.value(meaning, at))
    }

    /// Data Type and Data Units can be written in IDLE outside data exchange (errata-bpg-bcg-tpg 91).
    fn check_mode(&self, at: &At) -> Result<(), AccessError> {
        let is_presentation = matches!(self.meaning_of(at), Some(Meaning::Presentation(_)));
        let has_machine = self.has(BlockBehaviour::StateMachine);
        if is_presentation && has_machine && !self.machine.is_configurable() {
            Err(AccessError::WrongMode)
        } else {
            Ok(())
        }
    }

    fn storage_key(&self, at: &At) -> Key {
        if matches!(self.meaning_of(at), Some(Meaning::Presentation(_))) { at.shared_key() } else { at.key() }
    }

    fn set(&mut self, at: &At, value: &Value) -> Result<(), AccessError> {
        match self.meaning_of(at).ok_or(AccessError::UnknownIndex)? {
            Meaning::Device(DeviceRow::StateCommand) => self.state_command(value.integer()?),
            Meaning::Selector => {
                let instance = value.integer()?;
                if !self.description.model.has_instance(at.location.slot, instance) {
                    return Err(AccessError::OutOfRange);
                }
                self.selector = instance;
                Ok(())
            }
            Meaning::Presentation(row) => self.presentation.set_row(row, value),
            Meaning::Input(position, row) => {
                let it = self.sensing.get_mut(position).ok_or(AccessError::UnknownIndex)?;
                it.part.set_input(row, value)
            }
            Meaning::Emission(position) => self.set_emission(position, value),
            Meaning::Command(position) => {
                let code = code_of(value).ok_or(AccessError::OutOfRange)?;
                let name = at.row.codes.code(code.into()).ok_or(AccessError::OutOfRange)?.name;
                self.execute(position, name)
            }
            Meaning::Trip(number, row) => self.set_trip(number, row, value),
            Meaning::Device(_)
            | Meaning::BlockType
            | Meaning::PvSelector
            | Meaning::OneOfN
            | Meaning::Status(_)
            | Meaning::SensorAlarm(_)
            | Meaning::Degas(_) => Err(AccessError::NotWritable),
        }
    }

    /// Power-up executes no command and switches no emission.
    fn restore(&mut self, at: &At, value: &Value) -> Result<(), AccessError> {
        match self.meaning_of(at) {
            Some(Meaning::Device(_) | Meaning::Command(_) | Meaning::Emission(_)) => Ok(()),
            _ => self.set(at, value),
        }
    }

    /// The zero adjustments.
    fn internal_values(&self) -> &[f64] {
        &self.offsets_pa
    }

    fn internal_values_mut(&mut self) -> &mut [f64] {
        &mut self.offsets_pa
    }
}

impl DescribedBehaviour {
    /// Executes a Device Block State Command. Reset sets the volatile values to those after power-up.
    fn state_command(&mut self, number: u8) -> Result<(), AccessError> {
        if self.machine.command(number)? {
            let thresholds = self.description.thresholds;
            self.sensing_mut().iter_mut().for_each(|it| it.cathode = Cathode::new(thresholds));
        }
        Ok(())
    }
}

impl DeviceBlockValues for DescribedBehaviour {
    fn identity(&self) -> Identity {
        let model = self.description.model;
        Identity {
            model,
            device_type: "CG",
            model_number: model.title,
            software: model.gsd.software,
            configuration: model.title,
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
        self.alarm().record_of(self.count.saturating_mul(2))
    }

    fn warning_record(&self) -> Value {
        self.warning().record_of(self.count.saturating_mul(2).saturating_add(1))
    }
}
