//! Reads parameters by name.

use super::{Gauge, KnownUnit};
use crate::error::{AccessReason, ClientError, Operation};
use crate::names::NamedParameter;
use crate::records::{Records, Unavailable};
use crate::values::{Value, ValueFormat};
use profivac_devices::model::{Access, AccessPath, Codes, DataType, Direction, Role, Row, Unit};

/// How often a parameter is read when another master moves the selector or changes the unit meanwhile.
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
    /// The unit of the value: of a pressure, or `%`.
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
        let (octets, value, unit) = self.read_with_unit(named)?;
        let text = ValueFormat { named, model: self.model, unit }.text(&octets, &value);
        let unit = match named.parameter.row.codes {
            Codes::PerMille(..) => Some("%"),
            Codes::Quantity(quantity) => Some(quantity.unit),
            _ => unit.map(|unit| unit.name),
        };
        Ok(ParameterReading { named: named.clone(), octets, value, text, unit })
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

    /// Reads the unit of all pressures. `None` for a code that the tables do not have.
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
        if let KnownUnit::Given(unit) = self.unit {
            return Ok(Some(unit));
        }
        let unit = match self.unit_parameter()? {
            Some(named) => {
                self.select(&named)?;
                match self.read_record(&named)? {
                    (_, Value::Integer(code)) => u16::try_from(code).ok().and_then(|code| self.model.unit(code)),
                    _ => None,
                }
            }
            None => None,
        };
        self.unit = KnownUnit::Read(unit);
        Ok(unit)
    }

    /// Reads the unit once for the readings of `read`, instead of once for each. Returns also whether it was the same afterwards.
    pub(crate) fn with_one_unit<T>(
        &mut self,
        read: impl FnOnce(&mut Self) -> Result<T, ClientError>,
    ) -> Result<(T, bool), ClientError> {
        let KnownUnit::Read(_) = self.unit else { return Ok((read(self)?, true)) };
        let Some(unit) = self.unit()? else { return Ok((read(self)?, true)) };
        self.unit = KnownUnit::Given(unit);
        let done = read(self);
        self.unit = KnownUnit::Read(Some(unit));
        Ok((done?, self.unit()? == Some(unit)))
    }

    /// A parameter that holds the unit. All instances have the same: the one that the slot shows needs no move of the
    /// selector.
    fn unit_parameter(&mut self) -> Result<Option<NamedParameter>, ClientError> {
        let (names, via) = (self.names(), self.records.via());
        let is_unit = |row: &Row| row.role == Some(Role::Unit) && row.access.allows(via, Direction::Read);
        let mut units = names.all().iter().filter(|named| is_unit(named.parameter.row));
        let Some(first) = units.clone().next() else { return Ok(None) };
        let shown = match first.parameter.location.instance {
            0 => 0,
            _ => self.selected_instance(first.parameter.location.slot)?,
        };
        Ok(units.find(|named| named.parameter.location.instance == shown).or(Some(first)).cloned())
    }

    /// A record with its value and its unit. A pressure counts only if the unit was the same before and after it was read.
    fn read_with_unit(
        &mut self,
        named: &NamedParameter,
    ) -> Result<(Vec<u8>, Value, Option<&'static Unit>), ClientError> {
        if named.parameter.row.data_type != DataType::ByType {
            let (octets, value) = self.read_record(named)?;
            return Ok((octets, value, None));
        }
        let mut before = match self.unit {
            KnownUnit::Given(unit) | KnownUnit::Read(Some(unit)) => Some(unit),
            KnownUnit::Read(None) => self.unit()?,
        };
        for _ in 0..ATTEMPTS {
            self.select(named)?;
            let (octets, value) = self.read_record(named)?;
            let unit = self.unit()?;
            if unit == before {
                return Ok((octets, value, unit));
            }
            before = unit;
        }
        Err(self.unavailable(Unavailable::UnitContention))
    }

    pub(super) fn unit_of(&mut self, named: &NamedParameter) -> Result<Option<&'static Unit>, ClientError> {
        if named.parameter.row.data_type == DataType::ByType { self.unit() } else { Ok(None) }
    }

    /// The octets of a record and the value in them.
    pub(super) fn read_record(&mut self, named: &NamedParameter) -> Result<(Vec<u8>, Value), ClientError> {
        self.recover_selector()?;
        let (slot, index) = (named.parameter.location.slot, named.parameter.row.index);
        let record = self.records.read(slot, index);
        let octets = record
            .map_err(|error| ClientError::from_record(error, Operation::Read, self.context(named), Some(named)))?;
        let value = self.decode(named, Operation::Read, &octets)?;
        Ok((octets, value))
    }

    pub(super) fn decode(&self, named: &NamedParameter, doing: Operation, octets: &[u8]) -> Result<Value, ClientError> {
        Value::of_row(named.parameter.row, octets).map_err(|error| ClientError::Malformed {
            location: self.context(named),
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
            location: self.context(named),
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
