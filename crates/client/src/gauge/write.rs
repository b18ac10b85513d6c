//! Writes parameters and sends commands: checked against the table, the measuring range and the conditions, then read back.

use super::conditions::{self, Condition};
use super::{Gauge, KnownUnit, ParameterReading};
use crate::error::{ClientError, Operation};
use crate::names::NamedParameter;
use crate::records::Records;
use crate::values::{BeyondRange, Value, ValueError, ValueFormat, whole_number};
use profivac_devices::model::{Code, Direction, NumberType, Role, Row, Unit};

/// A parameter that was written.
#[derive(Clone, Debug)]
pub struct WriteResult {
    /// The parameter.
    pub named: NamedParameter,
    /// The value before, if it is readable.
    pub before: Option<ParameterReading>,
    /// The value that was read back, if it is readable.
    pub after: Option<ParameterReading>,
    /// The written value as text.
    pub text: String,
}

/// A value for a parameter, checked but not sent.
#[derive(Clone, Debug)]
pub struct PreparedWrite {
    /// The parameter.
    pub named: NamedParameter,
    /// The octets of the record.
    pub octets: Vec<u8>,
    /// The value as text.
    pub text: String,
    /// The entry of the code table, if the parameter has one.
    pub code: Option<&'static Code>,
    /// The present value, if it is readable.
    pub before: Option<ParameterReading>,
    /// The pressure is outside the measuring range of the gauge.
    pub beyond_range: Option<BeyondRange>,
    /// The unit of a pressure, in which the octets are.
    unit: Option<&'static Unit>,
}

impl<R: Records> Gauge<R> {
    /// Writes a parameter in the words of the manual, and reads it back. A pressure has its unit: `1e-3 mbar`.
    ///
    /// ```
    /// # use profivac_client::{Bus, ClientError};
    /// # let mut bus = Bus::on(profivac_virtual::open::devices(&["bcg450@5"])?).open()?;
    /// let mut gauge = bus.gauge(5)?;
    /// let written = gauge.write("pirani.safe-value", "12.5 Pascal")?;
    /// assert_eq!(written.after.ok_or("not readable")?.text, "0.125 mbar");
    /// assert!(matches!(gauge.write("pirani.safe-value", "12.5"), Err(ClientError::Value { .. })));
    /// assert!(matches!(gauge.write("pirani.safe-value", "1e9 mbar"), Err(ClientError::BeyondRange { .. })));
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    ///
    /// # Errors
    /// [`ClientError::Target`] for an unknown parameter; the errors of [`prepare`](Self::prepare) and
    /// [`execute`](Self::execute).
    pub fn write(&mut self, name: &str, value: &str) -> Result<WriteResult, ClientError> {
        let named = self.find_whole(name)?;
        let write = self.prepare(&named, value)?;
        self.execute(write)
    }

    /// Sends a command by name, such as `execute` or `degas on`, if its conditions are met.
    ///
    /// ```
    /// # use profivac_client::Bus;
    /// use profivac_devices::profile::DeviceState;
    ///
    /// # let mut bus = Bus::on(profivac_virtual::open::devices(&["bcg450@5"])?).open()?;
    /// let mut gauge = bus.gauge(5)?;
    /// if gauge.device_state()? == DeviceState::Idle {
    ///     gauge.command("execute")?;
    /// }
    /// assert_eq!(gauge.device_state()?, DeviceState::Executing);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    ///
    /// # Errors
    /// As [`write`](Self::write); [`ClientError::Condition`] if a condition is not met.
    pub fn command(&mut self, name: &str) -> Result<WriteResult, ClientError> {
        let names = self.names();
        let (named, code) = names.command(name)?.ok_or_else(|| self.unknown_parameter(name))?;
        let write = self.prepare(named, code.name)?;
        self.execute(write)
    }

    /// Checks a value for a parameter, and the conditions of a command. Reads the present value; writes nothing.
    ///
    /// ```
    /// # use profivac_client::{Bus, ClientError};
    /// # let mut bus = Bus::on(profivac_virtual::open::devices(&["bcg450@5"])?).open()?;
    /// let mut gauge = bus.gauge(5)?;
    /// let named = gauge.find("pirani.safe-state")?;
    /// let write = gauge.prepare(&named, "full-scale")?;
    /// assert_eq!(write.octets, [1]);
    /// gauge.execute(write)?;
    /// assert!(matches!(gauge.prepare(&named, "never"), Err(ClientError::Value { .. })));
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    ///
    /// # Errors
    /// [`ClientError::Value`] for a text that is no value, [`ClientError::BeyondRange`] for a pressure outside the measuring
    /// range, [`ClientError::Condition`] for a command whose conditions are not met; the errors of reading.
    pub fn prepare(&mut self, named: &NamedParameter, text: &str) -> Result<PreparedWrite, ClientError> {
        let write = self.prepare_unchecked(named, text)?;
        self.check(write)
    }

    /// As [`prepare`](Self::prepare), but accepts a pressure outside the measuring range, for the case that it is intended.
    ///
    /// ```
    /// # use profivac_client::Bus;
    /// # let mut bus = Bus::on(profivac_virtual::open::devices(&["bcg450@5"])?).open()?;
    /// let mut gauge = bus.gauge(5)?;
    /// let named = gauge.find("pirani.safe-value")?;
    /// let write = gauge.prepare_forced(&named, "1e9 mbar")?;
    /// let beyond = write.beyond_range.as_ref().ok_or("it is inside")?;
    /// assert_eq!((beyond.lowest.as_str(), beyond.highest.as_str()), ("5e-10 mbar", "1500 mbar"));
    /// gauge.execute(write)?;
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    ///
    /// # Errors
    /// As [`prepare`](Self::prepare), without [`ClientError::BeyondRange`].
    pub fn prepare_forced(&mut self, named: &NamedParameter, text: &str) -> Result<PreparedWrite, ClientError> {
        let write = self.prepare_unchecked(named, text)?;
        conditions::check(self, named, write.code)?;
        Ok(write)
    }

    /// Checks only that the text is a value of the parameter: not the measuring range, which
    /// [`PreparedWrite::beyond_range`] reports, and not the [conditions](Self::conditions) of a command.
    ///
    /// # Errors
    /// [`ClientError::Value`], and the errors of reading the present value.
    pub fn prepare_unchecked(&mut self, named: &NamedParameter, text: &str) -> Result<PreparedWrite, ClientError> {
        self.prepare_with(named, |gauge, format, number| {
            format.parse(text, number).map_err(|error| gauge.value_error(named, error))
        })
    }

    pub(super) fn value_error(&self, named: &NamedParameter, error: ValueError) -> ClientError {
        ClientError::Value { location: self.context(named), error: Box::new(error) }
    }

    /// Fails if the value is outside the measuring range, or a condition of the command is not met.
    pub(super) fn check(&mut self, write: PreparedWrite) -> Result<PreparedWrite, ClientError> {
        if let Some(error) = write.beyond_range {
            return Err(ClientError::BeyondRange { location: self.context(&write.named), error: Box::new(error) });
        }
        conditions::check(self, &write.named, write.code)?;
        Ok(write)
    }

    /// Prepares the octets that `encode` makes for the present number type of the gauge.
    pub(super) fn prepare_with(
        &mut self,
        named: &NamedParameter,
        encode: impl FnOnce(&Self, &ValueFormat<'_>, NumberType) -> Result<Vec<u8>, ClientError>,
    ) -> Result<PreparedWrite, ClientError> {
        self.check_access(named, Direction::Write)?;
        let row = named.parameter.row;
        let is_readable = row.access.allows(self.records.via(), Direction::Read) && !row.codes.is_command();
        let before = if is_readable { Some(self.read_parameter(named)?) } else { None };
        let number = match before.as_ref().map(|before| before.octets.len()) {
            Some(2) => NumberType::Integer,
            _ => NumberType::Float,
        };
        let unit = self.unit_of(named)?;
        let format = ValueFormat { named, model: self.model, unit };
        let octets = encode(self, &format, number)?;
        let value = self.decode(named, Operation::Write, &octets)?;
        let text = format.format(&value);
        let beyond_range = match self.reported_range(named)? {
            Some(range) => format.beyond_reported_range(&value, range),
            None => format.beyond_range(&value),
        };
        let code = code_of(row, &value);
        Ok(PreparedWrite { named: named.clone(), octets, text, code, before, beyond_range, unit })
    }

    /// The conditions of a prepared write, each with the present state of the gauge.
    ///
    /// ```
    /// # use profivac_client::Bus;
    /// # let mut bus = Bus::on(profivac_virtual::open::devices(&["bcg450@5"])?).open()?;
    /// let mut gauge = bus.gauge(5)?;
    /// let names = gauge.names();
    /// let (named, code) = names.command("degas on")?.ok_or("no such command")?;
    /// let write = gauge.prepare_unchecked(named, code.name)?;
    /// let conditions = gauge.conditions(&write)?;
    /// assert!(conditions.iter().any(|condition| condition.unmet.is_some()), "the gauge is in IDLE");
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    ///
    /// # Errors
    /// The errors of reading.
    pub fn conditions(&mut self, write: &PreparedWrite) -> Result<Vec<Condition>, ClientError> {
        conditions::all(self, &write.named, write.code)
    }

    /// Sends a prepared write and reads the parameter back.
    ///
    /// # Errors
    /// [`ClientError::Refused`] with the codes of the device; [`ClientError::Interrupted`] or [`ClientError::WriteLost`] if no answer
    /// came; [`ClientError::NotReadBack`]; [`ClientError::UnitChanged`] if the gauge has another unit than when the value was prepared;
    /// the errors of reading. [`ClientError::write_effect`] says whether the device has the value.
    pub fn execute(&mut self, write: PreparedWrite) -> Result<WriteResult, ClientError> {
        let PreparedWrite { named, octets, text, before, unit, .. } = write;
        // Another master may have moved the selector since.
        self.invalidate_selector();
        self.recover_selector()?;
        let present = self.unit_of(&named)?;
        if present != unit {
            let [prepared, present] = [unit, present].map(|unit| unit.map_or("an unknown unit", |unit| unit.name));
            return Err(ClientError::UnitChanged { location: self.context(&named), prepared, present });
        }
        self.select(&named)?;
        let (slot, index) = (named.parameter.location.slot, named.parameter.row.index);
        let written = self.records.write(slot, index, &octets);
        written
            .map_err(|error| ClientError::from_record(error, Operation::Write, self.context(&named), Some(&named)))?;
        if named.parameter.row.role == Some(Role::Unit) {
            self.unit = KnownUnit::Read(None);
        }
        // The caller moves the selector on purpose: it stays where it is.
        if named.parameter.row.role == Some(Role::InstanceSelector) {
            self.selector_state = None;
        }
        let read_back = before.is_some().then(|| self.read_parameter(&named)).transpose();
        let after = read_back
            .map_err(|error| ClientError::NotReadBack { location: self.context(&named), error: Box::new(error) })?;
        Ok(WriteResult { named, before, after, text })
    }
}

/// The entry of the code table for a value.
fn code_of(row: &'static Row, value: &Value) -> Option<&'static Code> {
    match value {
        Value::Integer(number) => row.codes.code(*number),
        Value::Number(number) => row.codes.code(whole_number(*number)?),
        Value::Octets(octets) => match octets.as_slice() {
            [command, value] => row.codes.code(u16::from_be_bytes([*command, *value]).into()),
            _ => None,
        },
        Value::Text(_) => None,
    }
}
