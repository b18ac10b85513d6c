//! The pressure of a gauge, and whether it is valid.

use super::{Gauge, ParameterReading};
use crate::error::ClientError;
use crate::names::NamedParameter;
use crate::pressure::Pressure;
use crate::records::Records;
use crate::values::{Value, pressure_format};
use profivac_devices::model::{NumberType, Role};
use profivac_devices::reading::is_pressure;

/// A pressure reading with its validity.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PressureReading {
    /// In Pa. `None` unless the device declares the reading valid.
    pub pa: Option<f64>,
    /// The measuring instance, or the slot of a channel.
    pub instance: u8,
}

impl PressureReading {
    /// The pressure with its units. `None` unless the reading is valid.
    #[must_use]
    pub fn pressure(&self) -> Option<Pressure> {
        self.pa.map(Pressure::from_pa)
    }

    /// Whether the device declares the reading valid.
    #[must_use]
    pub const fn is_valid(&self) -> bool {
        self.pa.is_some()
    }
}

impl<R: Records> Gauge<R> {
    /// Reads the pressure: of the instance that the PV Selector names, or of the first valid channel of a controller.
    ///
    /// ```
    /// # use profivac_client::Bus;
    /// # let mut bus = Bus::on(profivac_virtual::open::devices(&["bcg450@5"])?).open()?;
    /// # bus.gauge(5)?.command("execute")?;
    /// let reading = bus.gauge(5)?.pressure()?;
    /// let pressure = reading.pressure().ok_or("the reading is not valid")?;
    /// println!("{} mbar, {} Pa, {} Torr", pressure.mbar(), pressure.pa(), pressure.torr());
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    ///
    /// # Errors
    /// As [`read`](Self::read).
    pub fn pressure(&mut self) -> Result<PressureReading, ClientError> {
        let names = self.names();
        let selector = names.all().iter().find(|named| named.parameter.row.role == Some(Role::PvSelector));
        let active = selector.map(|selector| self.read_parameter(selector)).transpose()?;
        let active = match active.map(|reading| reading.value) {
            Some(Value::Integer(instance)) => u8::try_from(instance).unwrap_or_default(),
            _ => 0,
        };
        let parts = self.model.parts;
        let is_value = |named: &&NamedParameter| {
            let parameter = named.parameter;
            parameter.row.role == Some(Role::ProcessValue)
                && parts.iter().any(|spec| spec.part.instance == instance_of(named))
                && (active == 0 || parameter.place.instance == active)
        };
        let mut first = None;
        for value in names.all().iter().filter(is_value) {
            let pressure = self.pressure_of(value)?;
            if pressure.is_valid() {
                return Ok(pressure);
            }
            first = first.or(Some(pressure));
        }
        first.ok_or_else(|| self.unknown_parameter("process-value"))
    }

    /// Reads a Process Value. It is valid if Reading Valid and Status Extension of the same instance say so.
    ///
    /// ```
    /// # use profivac_client::Bus;
    /// # let mut bus = Bus::on(profivac_virtual::open::devices(&["bcg450@5"])?).open()?;
    /// let mut gauge = bus.gauge(5)?;
    /// let named = gauge.find("cdg.process-value")?;
    /// // The gauge is in IDLE.
    /// assert_eq!(gauge.pressure_of(&named)?.pressure(), None);
    /// assert!(!gauge.is_valid(&named)?);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    ///
    /// # Errors
    /// As [`read`](Self::read).
    pub fn pressure_of(&mut self, named: &NamedParameter) -> Result<PressureReading, ClientError> {
        let reading = self.read_parameter(named)?;
        let is_valid = self.is_valid(named)?;
        let pa = self.pa(&reading).filter(|pa| is_valid && is_pressure(*pa));
        Ok(PressureReading { pa, instance: instance_of(named) })
    }

    /// Whether Reading Valid and Status Extension of the same instance declare the reading valid.
    ///
    /// # Errors
    /// As [`read`](Self::read).
    pub fn is_valid(&mut self, named: &NamedParameter) -> Result<bool, ClientError> {
        let names = self.names();
        let mut is_valid = true;
        for other in names.all().iter().filter(|other| other.is_same_instance(named)) {
            is_valid &= match other.parameter.row.role {
                // PROFIBUS writes FF, the manuals write 1: errata-bpg-bcg-tpg 26.
                Some(Role::ReadingValid) => matches!(self.read_parameter(other)?.value, Value::Integer(1 | 0xFF)),
                Some(Role::StatusExtension) => {
                    matches!(self.read_parameter(other)?.value, Value::Integer(bits) if bits & 1 == 0)
                }
                _ => true,
            };
        }
        Ok(is_valid)
    }

    /// A reading in Pa.
    fn pa(&self, reading: &ParameterReading) -> Option<f64> {
        let Value::Number(number) = reading.value else { return None };
        pressure_format(self.model, &reading.named, self.unit?, NumberType::Float)?.pa_from_number(number)
    }
}

/// The number of the measuring part or channel of a parameter.
const fn instance_of(named: &NamedParameter) -> u8 {
    let place = named.parameter.place;
    if place.instance > 0 { place.instance } else { place.slot }
}
