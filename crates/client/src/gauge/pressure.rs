//! The pressure of a gauge with its quality, which the function of the cyclic data decides.

use super::{Gauge, ParameterReading};
use crate::cyclic::{
    BLOCK_TYPE, ChannelValue, Reported, ReportedChannels, ValueStatus, open_instances, unranged_instances,
};
use crate::error::ClientError;
use crate::names::NamedParameter;
use crate::records::Records;
use crate::values::{Value, pressure_format};
use profivac_devices::model::{DataType, Field, HeldPressure, MeasuringRange, Model, NumberType, Role};
use profivac_devices::profile::{ExceptionStatus, StatusExtension};
use profivac_devices::reading::is_pressure;

/// Slot and index of Exception Status in every block device.
const EXCEPTION_STATUS: (u8, u8) = (0, 26);

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
    pub fn pressure(&mut self) -> Result<ChannelValue, ClientError> {
        let names = self.names();
        let selector = names.all().iter().find(|named| named.parameter.row.role == Some(Role::PvSelector));
        let active = selector.map(|selector| self.read_parameter(selector)).transpose()?;
        let active = match active.map(|reading| reading.value) {
            Some(Value::Integer(instance)) => u8::try_from(instance).unwrap_or_default(),
            _ => 0,
        };
        // One Of N Status Extension is that of the whole gauge: errata-bpg-bcg-tpg 58, errata-pxg55x-img400 165.
        let one_of_n = selector
            .and_then(|selector| names.all().iter().find(|named| is_status(named) && named.is_same_instance(selector)));
        let mut first = None;
        let model = self.model;
        let is_value = |named: &&NamedParameter| {
            has_role(named, Role::ProcessValue)
                && model.parts.iter().any(|spec| spec.part.instance == instance_of(named))
                && (active == 0 || named.parameter.location.instance == active)
        };
        for value in names.all().iter().filter(is_value) {
            let reading = self.reading_of(value, one_of_n)?;
            if reading.is_valid() {
                return Ok(reading);
            }
            first = first.or(Some(reading));
        }
        first.ok_or_else(|| self.unknown_parameter("process-value"))
    }

    /// Reads a Process Value with the quality that Reading Valid and Status Extension of the same instance, Exception Status
    /// and the range of the part give it.
    ///
    /// ```
    /// # use profivac_client::Bus;
    /// use profivac_devices::reading::Quality;
    ///
    /// # let mut bus = Bus::on(profivac_virtual::open::devices(&["bcg450@5"])?).open()?;
    /// let mut gauge = bus.gauge(5)?;
    /// let named = gauge.find("cdg.process-value")?;
    /// // The gauge is in IDLE, so there is no pressure.
    /// let reading = gauge.pressure_of(&named)?;
    /// assert_ne!(reading.quality, Quality::Valid);
    /// assert_eq!(reading.pressure(), None);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    ///
    /// # Errors
    /// As [`read`](Self::read).
    pub fn pressure_of(&mut self, named: &NamedParameter) -> Result<ChannelValue, ClientError> {
        self.reading_of(named, None)
    }

    /// The reading of a Process Value; `status` is read in place of the status of its instance.
    fn reading_of(
        &mut self,
        named: &NamedParameter,
        status: Option<&NamedParameter>,
    ) -> Result<ChannelValue, ClientError> {
        let names = self.names();
        let instance = instance_of(named);
        let reading = self.read_parameter(named)?;
        let held = self.held_pressure(&reading);
        let of_instance =
            |role| names.all().iter().find(move |other| has_role(other, role) && other.is_same_instance(named));
        let status = status.or_else(|| of_instance(Role::StatusExtension));
        let extension = status.map(|status| self.status_extension(status)).transpose()?;
        let reading_valid = of_instance(Role::ReadingValid).map(|valid| self.read_parameter(valid)).transpose()?;
        // PROFIBUS writes FF, the manuals write 1: errata-bpg-bcg-tpg 26.
        let is_declared_valid = reading_valid.map(|valid| matches!(valid.value, Value::Integer(1 | 0xFF)));
        let extension = match (extension, is_declared_valid) {
            (Some(extension), Some(false)) => Some(extension | StatusExtension::INVALID),
            (None, Some(false)) => Some(StatusExtension::INVALID),
            (None, Some(true)) => Some(StatusExtension::empty()),
            (extension, _) => extension,
        };
        let status = match extension {
            Some(extension) if has_channel_status(self.model) => ValueStatus::Channel(extension),
            Some(extension) => ValueStatus::Gauge(extension),
            None => ValueStatus::None,
        };
        let others_measure = match status {
            ValueStatus::Channel(status) if status.contains(StatusExtension::INVALID) => {
                self.has_measuring_channel(instance)?
            }
            _ => false,
        };
        let exception = self.exception_status()?;
        let channels = self.reported_channel(named)?;
        Ok(Reported { instance, held, status, exception, others_measure }.value(self.model, &channels))
    }

    fn status_extension(&mut self, status: &NamedParameter) -> Result<StatusExtension, ClientError> {
        Ok(match self.read_parameter(status)?.value {
            Value::Integer(bits) => StatusExtension::from_bits_retain(u8::try_from(bits).unwrap_or(u8::MAX)),
            _ => StatusExtension::INVALID,
        })
    }

    /// Whether the status of another channel declares its reading valid.
    fn has_measuring_channel(&mut self, instance: u8) -> Result<bool, ClientError> {
        let names = self.names();
        for status in names.all().iter().filter(|named| is_status(named) && instance_of(named) != instance) {
            match self.status_extension(status) {
                Ok(extension) if !extension.contains(StatusExtension::INVALID) => return Ok(true),
                // A channel without a gauge may have no status.
                Ok(_) | Err(ClientError::Refused { .. }) => {}
                Err(error) => return Err(error),
            }
        }
        Ok(false)
    }

    /// Exception Status; without bits for a device that has none.
    fn exception_status(&mut self) -> Result<ExceptionStatus, ClientError> {
        let (slot, index) = EXCEPTION_STATUS;
        let names = self.names();
        let Some(named) = names.at(slot, 0, index) else { return Ok(ExceptionStatus::empty()) };
        Ok(match self.read_parameter(named)?.value {
            Value::Integer(bits) => ExceptionStatus::from_bits_retain(u8::try_from(bits).unwrap_or(u8::MAX)),
            _ => ExceptionStatus::empty(),
        })
    }

    /// The principle and the range of the channel of a Process Value, as far as the tables leave them open and the device reports
    /// them. They are read each time: another gauge may have been connected.
    fn reported_channel(&mut self, value: &NamedParameter) -> Result<ReportedChannels, ClientError> {
        let instance = instance_of(value);
        let mut reported = ReportedChannels::default();
        if open_instances(self.model).contains(&instance) {
            match self.read_raw(instance, BLOCK_TYPE) {
                Ok(octets) => reported = ReportedChannels::from_block_types([(instance, octets.as_slice())]),
                Err(ClientError::Refused { .. }) => {}
                Err(error) => return Err(error),
            }
        }
        Ok(match self.reported_range(value)? {
            Some(range) => reported.with_range(instance, range),
            None => reported,
        })
    }

    /// The range that the channel of a pressure reports, where different gauges may be connected. `None` elsewhere.
    pub(super) fn reported_range(&mut self, named: &NamedParameter) -> Result<Option<MeasuringRange>, ClientError> {
        let is_pressure = named.parameter.row.data_type == DataType::ByType;
        if !is_pressure || !unranged_instances(self.model).contains(&instance_of(named)) {
            return Ok(None);
        }
        let lowest_pa = self.range_end(named, Role::Underrange)?;
        let highest_pa = self.range_end(named, Role::Overrange)?;
        Ok(lowest_pa.zip(highest_pa).map(|(lowest_pa, highest_pa)| MeasuringRange { lowest_pa, highest_pa }))
    }

    /// The end of the range that the channel of a Process Value reports. `None` if it reports none.
    fn range_end(&mut self, value: &NamedParameter, role: Role) -> Result<Option<f64>, ClientError> {
        let names = self.names();
        let Some(end) = names.all().iter().find(|other| has_role(other, role) && other.is_same_instance(value)) else {
            return Ok(None);
        };
        match self.read_parameter(end) {
            Ok(reading) => Ok(self.pressure_pa(&reading).filter(|pa| is_pressure(*pa))),
            Err(ClientError::Refused { .. }) => Ok(None),
            Err(error) => Err(error),
        }
    }

    /// A reading in Pa; `None` for a parameter that is no pressure, and for an integer that is the highest of its format or less than
    /// one unit: these stand for every pressure beyond them.
    ///
    /// ```
    /// # use profivac_client::Bus;
    /// # let mut bus = Bus::on(profivac_virtual::open::devices(&["bcg450@5:unit=mbar"])?).open()?;
    /// let mut gauge = bus.gauge(5)?;
    /// let reading = gauge.read("pirani.full-scale")?;
    /// assert_eq!(gauge.pressure_pa(&reading), Some(1e5));
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    #[must_use]
    pub fn pressure_pa(&self, reading: &ParameterReading) -> Option<f64> {
        match self.held_pressure(reading)? {
            HeldPressure::Exact(pa) => Some(pa),
            HeldPressure::AtLeast(_) | HeldPressure::Below(_) => None,
        }
    }

    /// The pressure of a reading as far as its octets hold it; `None` for a parameter that is no pressure.
    fn held_pressure(&self, reading: &ParameterReading) -> Option<HeldPressure> {
        let Value::Number(_) = reading.value else { return None };
        let unit = self.model.unit_named(reading.unit?)?;
        let is_integer = reading.octets.len() == NumberType::Integer.octets();
        let number_type = if is_integer { NumberType::Integer } else { NumberType::Float };
        pressure_format(self.model, &reading.named, unit, number_type)?.measured(&reading.octets)
    }
}

/// The number of the measuring part or channel of a parameter.
const fn instance_of(named: &NamedParameter) -> u8 {
    let location = named.parameter.location;
    if location.instance > 0 { location.instance } else { location.slot }
}

fn has_role(named: &NamedParameter, role: Role) -> bool {
    named.parameter.row.role == Some(role)
}

fn is_status(named: &NamedParameter) -> bool {
    has_role(named, Role::StatusExtension)
}

/// Whether the device is a controller whose channels have a status extension each.
fn has_channel_status(model: &Model) -> bool {
    let inputs = model.configurations.iter().filter_map(|configuration| configuration.inputs);
    inputs.into_iter().any(|telegram| telegram.fields.contains(&Field::ChannelStatus))
}
