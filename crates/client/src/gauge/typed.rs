//! Parameters as Rust types: the compiler knows the value of a parameter from its row.

use super::{Gauge, ParameterReading, WriteResult};
use crate::error::{ClientError, TypedError};
use crate::names::NamedParameter;
use crate::records::Records;
use crate::values::pressure_format;
use profivac_devices::model::{
    Counts, DataType, HeldPressure, Location, NumberType, ParameterValue, PressureFormat, Role, Row, Scale,
    TypedParameter, Unit, Value as ParameterData,
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
    /// # let mut bus = Bus::on(profivac_virtual::open::devices(&["bcg450@5"])?).open()?;
    /// let mut gauge = bus.gauge(5)?;
    /// gauge.set(&PIRANI, analog_input::SafeValue, Pascal(12.5))?;
    /// assert_eq!(gauge.get(&PIRANI, analog_input::SafeValue)?, Pascal(12.5));
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    ///
    /// # Errors
    /// [`ClientError::Typed`] if the model has no such parameter, the value is outside its code table, or a pressure is the highest integer
    /// of its format, or a measured pressure the integer 0; the errors of [`read`](Self::read).
    pub fn get<P: TypedParameter>(&mut self, location: &Location, _parameter: P) -> Result<P::Value, ClientError> {
        let named = self.typed_parameter::<P>(location)?;
        let ParameterReading { octets, unit, .. } = self.read_parameter(&named)?;
        let number = if octets.len() == NumberType::Integer.octets() { NumberType::Integer } else { NumberType::Float };
        let format = self.pressure_format(&named, unit, number)?;
        let is_pressure = named.parameter.row.data_type == DataType::ByType;
        let is_measured = named.parameter.row.role == Some(Role::ProcessValue);
        let bound = match format.measured(&octets) {
            Some(HeldPressure::AtLeast(_)) if is_pressure => {
                Some(TypedError::HighestInteger { octets: octets.clone() })
            }
            // A setting may be 0.
            Some(HeldPressure::Below(_)) if is_measured => Some(TypedError::BelowOneUnit),
            _ => None,
        };
        if let Some(error) = bound {
            return Err(ClientError::Typed { location: self.context(&named), error });
        }
        let value = named.parameter.row.data_type.decode(&octets, &format).ok();
        let value = value.as_ref().and_then(P::Value::from_value);
        value.ok_or_else(|| ClientError::Typed {
            location: self.context(&named),
            error: TypedError::UnknownCode { octets },
        })
    }

    /// Writes a parameter as a Rust type and reads it back, with the same checks as [`write`](Self::write).
    ///
    /// # Errors
    /// [`ClientError::Typed`] if the model has no such parameter; [`ClientError::Value`] for a pressure that the gauge cannot hold:
    /// an integer holds whole units only; the errors of [`write`](Self::write).
    pub fn set<P: TypedParameter>(
        &mut self,
        location: &Location,
        _parameter: P,
        value: P::Value,
    ) -> Result<WriteResult, ClientError> {
        let named = self.typed_parameter::<P>(location)?;
        let data_type = named.parameter.row.data_type;
        let value = value.to_value(data_type);
        let write = self.prepare_with(&named, |gauge, format, number| match value {
            ParameterData::Pressure(pa) if data_type == DataType::ByType => {
                let location = || gauge.context(&named);
                let unit = format.unit.and_then(|unit| pressure_format(gauge.model, &named, unit, number));
                let unit =
                    unit.ok_or_else(|| ClientError::Typed { location: location(), error: TypedError::NoUnit })?;
                let octets = format.encode_pressure(unit.number_from_pa(pa), number);
                octets.map_err(|problem| {
                    gauge.value_error(&named, format.value_error(&format!("{pa} Pa"), number, problem))
                })
            }
            value => Ok(data_type.encode(&value, &NO_PRESSURE).to_vec()),
        })?;
        let write = self.check(write)?;
        self.execute(write)
    }

    /// Reads the state of the device, on every model that has one: a TPG300 and a TPG500 have none.
    ///
    /// ```
    /// # use profivac_client::Bus;
    /// use profivac_devices::profile::DeviceState;
    ///
    /// # let mut bus = Bus::on(profivac_virtual::open::devices(&["bcg450@5", "img400@6"])?).open()?;
    /// assert_eq!(bus.gauge(5)?.device_state()?, DeviceState::Idle);
    /// println!("{}", bus.gauge(6)?.device_state()?.name());
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    ///
    /// # Errors
    /// As [`get`](Self::get): [`TypedError::NotOnModel`] on a TPG300 or TPG500.
    pub fn device_state(&mut self) -> Result<DeviceState, ClientError> {
        let location = &bcg450::table::DEVICE;
        let block_device = bcg450::table::device_block::DeviceState;
        match self.model.typed_row::<bcg450::table::device_block::DeviceState>(location) {
            Some(_) => self.get(location, block_device),
            None => self.get(&img400::table::DEVICE, img400::table::device_block::DeviceState),
        }
    }

    /// The parameter that `P` names at a location of this model.
    fn typed_parameter<P: TypedParameter>(&self, location: &Location) -> Result<NamedParameter, ClientError> {
        let row: Option<&Row> = self.model.typed_row::<P>(location);
        let named = row.and_then(|row| self.names.at(location.slot, location.instance, row.index)).cloned();
        named.ok_or_else(|| ClientError::Typed {
            location: self.raw_context(location.slot, P::ROW.index),
            error: TypedError::NotOnModel { parameter: P::ROW.name, location: location.name },
        })
    }

    /// How a parameter writes its pressures in this unit. The unit matters only for a pressure.
    fn pressure_format(
        &self,
        named: &NamedParameter,
        unit: Option<&'static str>,
        number: NumberType,
    ) -> Result<PressureFormat, ClientError> {
        if named.parameter.row.data_type != DataType::ByType {
            return Ok(NO_PRESSURE);
        }
        let unit = unit.and_then(|unit| self.model.unit_named(unit));
        let format = unit.and_then(|unit| pressure_format(self.model, named, unit, number));
        format.ok_or_else(|| ClientError::Typed { location: self.context(named), error: TypedError::NoUnit })
    }
}

/// The format of a value that is no pressure: no field of it matters.
const NO_PRESSURE: PressureFormat = PressureFormat {
    unit: &Unit { code: 0, name: "", alias: "", scale: Scale::MBAR },
    number: NumberType::Float,
    counts: Counts::Linear { per_mbar: 1.0 },
    max_integer: u16::MAX,
};
