//! Reads parameters by name.

use super::Gauge;
use crate::error::{AccessReason, ClientError, Operation};
use crate::names::NamedParameter;
use crate::records::{Records, Unavailable};
use crate::values::{Value, ValueFormat};
use profivac_devices::model::{Access, AccessPath, Codes, DataType, Direction, Role, Row, Unit};

/// How often a parameter is read when another master moves the selector meanwhile.
const ATTEMPTS: usize = 3;

/// A parameter that was read.
#[derive(Clone, Debug)]
pub struct ParameterReading {
    /// The parameter.
    pub named: NamedParameter,
    /// The octets of the record.
    pub octets: Vec<u8>,
    /// The decoded value.
    pub value: Value,
    /// The value as text, in the words of the manual.
    pub text: String,
    /// The unit of a pressure.
    pub unit: Option<&'static str>,
}

impl<R: Records> Gauge<R> {
    /// Reads a parameter in the words of the manual (`pirani.process-value`) or by its numbers (`1:1/19`).
    ///
    /// ```
    /// # use profivac_client::Bus;
    /// # let mut bus = Bus::on(profivac_virtual::open::devices(&["bcg450@5:unit=mbar"])?).open()?;
    /// let mut gauge = bus.gauge(5)?;
    /// let reading = gauge.read("pirani.full-scale")?;
    /// assert_eq!((reading.text.as_str(), reading.unit), ("1000 mbar", Some("mbar")));
    /// assert_eq!(gauge.read("device.device-state")?.text, "IDLE");
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    ///
    /// # Errors
    /// [`ClientError::Target`] for an unknown name, [`ClientError::Access`] if the table does not allow to read it this way,
    /// [`ClientError::Malformed`] for a record of a wrong length; refusals and errors of the line.
    pub fn read(&mut self, name: &str) -> Result<ParameterReading, ClientError> {
        let named = self.find(name)?;
        self.read_parameter(&named)
    }

    /// Reads a parameter that [`find`](Self::find) or [`names`](Self::names) found.
    ///
    /// ```
    /// # use profivac_client::Bus;
    /// # let mut bus = Bus::on(profivac_virtual::open::devices(&["bcg450@5"])?).open()?;
    /// let mut gauge = bus.gauge(5)?;
    /// for named in gauge.names().at_index(1, 24) {
    ///     println!("{named}: {}", gauge.read_parameter(named)?.text);
    /// }
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    ///
    /// # Errors
    /// As [`read`](Self::read).
    pub fn read_parameter(&mut self, named: &NamedParameter) -> Result<ParameterReading, ClientError> {
        if named.parameter.row.role == Some(Role::InstanceSelector) {
            // The value before this gauge moved it.
            self.restore_selector()?;
        }
        for _ in 0..ATTEMPTS {
            let reading = self.read_once(named)?;
            if self.is_still_selected(named)? {
                return Ok(reading);
            }
        }
        Err(self.selector_contention())
    }

    /// Reads a parameter without checking that the selector [did not move](Self::is_still_selected) meanwhile.
    pub(crate) fn read_once(&mut self, named: &NamedParameter) -> Result<ParameterReading, ClientError> {
        self.check_access(named, Direction::Read)?;
        self.select(named)?;
        let (octets, value) = self.read_record(named)?;
        let unit = self.unit_of(named)?;
        let text = ValueFormat { named, model: self.model, unit }.format(&value);
        Ok(ParameterReading { named: named.clone(), octets, value, text, unit: unit.map(|unit| unit.name) })
    }

    /// Reads a record that is in no table.
    ///
    /// ```
    /// # use profivac_client::Bus;
    /// # let mut bus = Bus::on(profivac_virtual::open::devices(&["bcg450@5"])?).open()?;
    /// assert_eq!(bus.gauge(5)?.read_raw(0, 25)?, [2]);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    ///
    /// # Errors
    /// [`ClientError::Refused`] if the device has no such record.
    pub fn read_raw(&mut self, slot: u8, index: u8) -> Result<Vec<u8>, ClientError> {
        if !self.model.features.dpv1 && self.records.via() != AccessPath::ParameterChannel {
            return Err(self.unavailable(Unavailable::NoDpv1));
        }
        self.recover_selector()?;
        self.records
            .read(slot, index)
            .map_err(|error| ClientError::from_record(error, Operation::Read, self.raw_context(slot, index), None))
    }

    /// The unit of all pressures, read once. `None` for a code that the tables do not have.
    ///
    /// ```
    /// # use profivac_client::Bus;
    /// # let mut bus = Bus::on(profivac_virtual::open::devices(&["bcg450@5:unit=torr"])?).open()?;
    /// let unit = bus.gauge(5)?.unit()?.ok_or("no unit")?;
    /// assert_eq!(unit.name, "Torr");
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    ///
    /// # Errors
    /// The errors of reading.
    pub fn unit(&mut self) -> Result<Option<&'static Unit>, ClientError> {
        if self.unit.is_none() {
            let names = self.names();
            let via = self.records.via();
            let selected = self.present_instance();
            let is_selected = |named: &&NamedParameter| Some(named.parameter.place.instance) == selected;
            let is_unit = |row: &Row| row.codes == Codes::Units && row.access.allows(via, Direction::Read);
            let mut units = names.all().iter().filter(|named| is_unit(named.parameter.row));
            // All instances have the same unit: prefer the one that needs no move of the selector.
            let Some(named) = units.clone().find(is_selected).or_else(|| units.next()) else { return Ok(None) };
            self.select(named)?;
            if let (_, Value::Integer(code)) = self.read_record(named)? {
                self.unit = u16::try_from(code).ok().and_then(|code| self.model.unit(code));
            }
        }
        Ok(self.unit)
    }

    pub(super) fn unit_of(&mut self, named: &NamedParameter) -> Result<Option<&'static Unit>, ClientError> {
        if named.parameter.row.data_type == DataType::ByType { self.unit() } else { Ok(None) }
    }

    /// The octets of a record and the value in them.
    pub(super) fn read_record(&mut self, named: &NamedParameter) -> Result<(Vec<u8>, Value), ClientError> {
        self.recover_selector()?;
        let (slot, index) = (named.parameter.place.slot, named.parameter.row.index);
        let record = self.records.read(slot, index);
        let octets = record
            .map_err(|error| ClientError::from_record(error, Operation::Read, self.context(named), Some(named)))?;
        let value = self.decode(named, Operation::Read, &octets)?;
        Ok((octets, value))
    }

    pub(super) fn decode(&self, named: &NamedParameter, doing: Operation, octets: &[u8]) -> Result<Value, ClientError> {
        Value::decode(named.parameter.row.data_type, octets).map_err(|error| ClientError::Malformed {
            place: self.context(named),
            doing,
            error,
        })
    }

    /// Fails without a request if the table forbids the access.
    pub(super) fn check_access(&self, named: &NamedParameter, direction: Direction) -> Result<(), ClientError> {
        let via = self.records.via();
        if named.parameter.row.access.allows(via, direction) {
            return Ok(());
        }
        Err(ClientError::Access {
            place: self.context(named),
            reason: access_reason(named.parameter.row, via, direction),
        })
    }
}

/// The reason why the access column of a row forbids an access, and which service allows it.
fn access_reason(row: &Row, via: AccessPath, direction: Direction) -> AccessReason {
    let (access, marks) = (row.access, row.access_text);
    let acyclic = Access::READ.union(Access::WRITE);
    let other = [AccessPath::Class2, AccessPath::Class1, AccessPath::ParameterChannel]
        .into_iter()
        .find(|other| *other != via && access.allows(*other, direction));
    match other {
        Some(path) => AccessReason::OtherPath { marks, path },
        None if direction == Direction::Write && access.contains(Access::USER_PRM) => {
            AccessReason::UserParameters { marks }
        }
        None if access.intersects(Access::CYCLIC_IN | Access::CYCLIC_OUT) && !access.intersects(acyclic) => {
            AccessReason::CyclicOnly { marks }
        }
        None if direction == Direction::Read => AccessReason::NotReadable { marks },
        None => AccessReason::ReadOnly { marks },
    }
}
