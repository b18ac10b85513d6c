//! Parameters as Rust types: the compiler knows the value of a parameter from its row.

use super::{Gauge, PreparedWrite, WriteResult, code_of, conditions};
use crate::error::{ClientError, Operation, TypedError};
use crate::names::NamedParameter;
use crate::records::Records;
use crate::values::ValueFormat;
use profivac_devices::model::{
    Counts, DataType, Direction, Location, NumberType, ParameterValue, PressureFormat, Row, Scale, TypedParameter,
};
use profivac_devices::profile::DeviceState;
use profivac_devices::{bcg450, img400};

impl<R: Records> Gauge<R> {
    /// Reads a parameter as a Rust type: an enum for a code table, `Pascal` for a pressure, a number, a Boolean or octets.
    ///
    /// The handle of one model also works on another model whose table has the same row at this location.
    ///
    /// ```
    /// use profivac_client::Bus;
    /// use profivac_devices::bcg450::table::{PIRANI, analog_input};
    /// use profivac_devices::model::Pascal;
    ///
    /// # let mut bus = Bus::builder("sim").open_on(profivac_virtual::open::devices(&["bcg450@5"])?)?;
    /// let mut gauge = bus.gauge(5)?;
    /// gauge.write_typed(&PIRANI, analog_input::SafeValue, Pascal(12.5))?;
    /// assert_eq!(gauge.read_typed(&PIRANI, analog_input::SafeValue)?, Pascal(12.5));
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    ///
    /// # Errors
    /// [`ClientError::Typed`] if the model has no such parameter or the value is outside its code table; the errors of
    /// [`read`](Self::read).
    pub fn read_typed<P: TypedParameter>(
        &mut self,
        location: &Location,
        _parameter: P,
    ) -> Result<P::Value, ClientError> {
        let named = self.typed_parameter::<P>(location)?;
        let octets = self.read(&named)?.octets;
        let format = self.pressure_format(&named, octets.len())?;
        let value = named.parameter.row.data_type.decode(&octets, &format).ok();
        let value = value.as_ref().and_then(P::Value::from_value);
        value.ok_or_else(|| ClientError::Typed {
            place: self.context(&named),
            error: TypedError::UnknownCode { octets },
        })
    }

    /// Writes a parameter as a Rust type and reads it back. Checks the conditions of a command before.
    ///
    /// # Errors
    /// [`ClientError::Typed`] if the model has no such parameter; the errors of [`execute`](Self::execute).
    pub fn write_typed<P: TypedParameter>(
        &mut self,
        location: &Location,
        _parameter: P,
        value: P::Value,
    ) -> Result<WriteResult, ClientError> {
        let named = self.typed_parameter::<P>(location)?;
        self.check_access(&named, Direction::Write)?;
        let row = named.parameter.row;
        let is_readable = row.access.allows(self.records.via(), Direction::Read) && !row.codes.is_command();
        let before = if is_readable { Some(self.read(&named)?) } else { None };
        let length = before.as_ref().map_or(4, |before| before.octets.len());
        let format = self.pressure_format(&named, length)?;
        let octets = row.data_type.encode(&value.to_value(row.data_type), &format).to_vec();
        let value = self.decode(&named, Operation::Write, &octets)?;
        let unit = self.unit_of(&named)?;
        let text = ValueFormat { named: &named, model: self.model, unit }.format(&value);
        let code = code_of(row, &value);
        conditions::check(self, &named, code)?;
        self.execute(PreparedWrite { named, octets, text, code, before })
    }

    /// Reads the state of the device, on every model that has one: a TPG300 and a TPG500 have none.
    ///
    /// ```
    /// # use profivac_client::Bus;
    /// use profivac_devices::profile::DeviceState;
    ///
    /// # let mut bus = Bus::builder("sim").open_on(profivac_virtual::open::devices(&["bcg450@5", "img400@6"])?)?;
    /// assert_eq!(bus.gauge(5)?.device_state()?, DeviceState::Idle);
    /// println!("{}", bus.gauge(6)?.device_state()?.name());
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    ///
    /// # Errors
    /// As [`read_typed`](Self::read_typed): [`TypedError::NotOnModel`] on a TPG300 or TPG500.
    pub fn device_state(&mut self) -> Result<DeviceState, ClientError> {
        let location = &bcg450::table::DEVICE;
        let block_device = bcg450::table::device_block::DeviceState;
        match self.model.typed_row::<bcg450::table::device_block::DeviceState>(location) {
            Some(_) => self.read_typed(location, block_device),
            None => self.read_typed(&img400::table::DEVICE, img400::table::device_block::DeviceState),
        }
    }

    /// The parameter that `P` names at a location of this model.
    fn typed_parameter<P: TypedParameter>(&self, location: &Location) -> Result<NamedParameter, ClientError> {
        let row: Option<&Row> = self.model.typed_row::<P>(location);
        let named = row.and_then(|row| self.names.at(location.slot, location.instance, row.index)).cloned();
        named.ok_or_else(|| ClientError::Typed {
            place: self.raw_context(location.slot, P::ROW.index),
            error: TypedError::NotOnModel { parameter: P::ROW.name, location: location.name },
        })
    }

    /// How a parameter writes its pressures. `length` is the number of its octets. The unit matters only for a pressure, and
    /// the scale of the instance only for a pressure in COUNTS.
    fn pressure_format(&mut self, named: &NamedParameter, length: usize) -> Result<PressureFormat, ClientError> {
        let is_pressure = named.parameter.row.data_type == DataType::ByType;
        let unit = if is_pressure { self.unit()? } else { self.model.units.first() };
        let instance = super::instance_of(named);
        let spec = self.model.parts.iter().find(|spec| spec.part.instance == instance);
        let needs_scale = is_pressure && unit.is_some_and(|unit| unit.scale == Scale::Counts);
        let counts = spec.map(|spec| spec.counts).or((!needs_scale).then_some(Counts::Linear { per_mbar: 1.0 }));
        let (Some(unit), Some(counts)) = (unit, counts) else {
            return Err(ClientError::Typed { place: self.context(named), error: TypedError::NoUnit });
        };
        let number = if is_pressure && length == 2 { NumberType::Integer } else { NumberType::Float };
        Ok(PressureFormat { unit, number, counts, max_integer: u16::MAX })
    }
}
