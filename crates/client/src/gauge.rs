//! A gauge by name: what it measures, its parameters, its commands.

use super::conditions::{self, Condition};
use super::error::{ClientError, Location, Operation};
use super::identify;
use super::names::{NamedParameter, ParameterNames, Target, TargetError};
use super::records::{RecordError, Records};
use super::values::{Value, ValueFormat};
use crate::ms2::Ms2;
use profivac_devices::model::{
    AccessPath, Code, Codes, DataType, Direction, Model, NumberType, PressureFormat, Row, Unit,
};
use profivac_host::session::BusSession;
use std::sync::Arc;

/// The name of the parameter that says which instance a slot shows: tira41d1 3.2.1.2, tira56e1 9.1.1.
const SELECTOR: &str = "Channel Instance Selector";

/// How often the selector is written when telegrams are lost on the way.
const ATTEMPTS: usize = 3;

/// A gauge, reached over `R`.
///
/// Where several instances share a slot, the Channel Instance Selector is moved to the one that is asked for and put back by
/// [`finish`](Self::finish).
pub struct Gauge<R> {
    records: R,
    address: u8,
    model: &'static Model,
    names: Arc<ParameterNames>,
    unit: Option<&'static Unit>,
    selector_state: Option<SelectorState>,
    selector_moved: bool,
}

/// What no instance is called: the one that is shown has to be asked for.
const UNKNOWN: u8 = 0;

/// Which instance is shown, and which was at the beginning.
#[derive(Clone, Copy, Debug)]
struct SelectorState {
    original: u8,
    current: u8,
}

/// A parameter that was read.
#[derive(Clone, Debug)]
pub struct ParameterReading {
    /// The parameter.
    pub named: NamedParameter,
    /// Its octets.
    pub octets: Vec<u8>,
    /// What they mean.
    pub value: Value,
    /// The same in words.
    pub text: String,
    /// The unit, if it is a pressure.
    pub unit: Option<&'static str>,
}

/// A parameter that was written.
#[derive(Clone, Debug)]
pub struct WriteResult {
    /// The parameter.
    pub named: NamedParameter,
    /// What it was, if it can be read.
    pub before: Option<ParameterReading>,
    /// What it is now, if it can be read.
    pub after: Option<ParameterReading>,
    /// What was written, in words.
    pub text: String,
}

/// What is to be written, checked but not sent.
#[derive(Clone, Debug)]
pub struct PreparedWrite {
    /// The parameter.
    pub named: NamedParameter,
    /// The octets.
    pub octets: Vec<u8>,
    /// The same in words.
    pub text: String,
    /// Its code, if it is one of a table.
    pub code: Option<&'static Code>,
    /// What it was.
    pub before: Option<ParameterReading>,
}

/// A pressure of a gauge.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PressureReading {
    /// In Pa; nothing unless the reading is valid.
    pub pa: Option<f64>,
    /// The instance or slot that measures.
    pub instance: u8,
}

impl<'a> Gauge<Ms2<'a>> {
    /// The gauge at `address`, over MS2: nothing is claimed and nothing is changed.
    ///
    /// # Errors
    /// [`ClientError`] when nobody is there, or nobody known.
    pub fn open(tool: &'a mut BusSession, address: u8) -> Result<Self, ClientError> {
        let seen = identify::wait_for_slave(tool, address)?;
        Self::new(Ms2::new(tool, address), address, seen.ident)
    }
}

impl<R: Records> Gauge<R> {
    /// The gauge with this ident number at the end of `records`.
    ///
    /// # Errors
    /// [`ClientError::Unknown`] when no known device has it.
    pub fn new(mut records: R, address: u8, ident: u16) -> Result<Self, ClientError> {
        let model = identify::model(ident, address, &mut records)?;
        Ok(Self::with_model(records, address, model))
    }

    /// A gauge that is known already.
    pub fn with_model(records: R, address: u8, model: &'static Model) -> Self {
        Self {
            records,
            address,
            model,
            names: Arc::new(ParameterNames::of(model)),
            unit: None,
            selector_state: None,
            selector_moved: false,
        }
    }

    /// The same, of which it is known that its pressures are in `unit`.
    #[must_use]
    pub fn with_unit(self, unit: &'static Unit) -> Self {
        Self { unit: Some(unit), ..self }
    }

    /// Its tables.
    #[must_use]
    pub const fn model(&self) -> &'static Model {
        self.model
    }

    /// The address of the slave.
    #[must_use]
    pub const fn address(&self) -> u8 {
        self.address
    }

    /// Its parameters.
    #[must_use]
    pub fn names(&self) -> Arc<ParameterNames> {
        Arc::clone(&self.names)
    }

    /// The way to it.
    pub const fn records(&mut self) -> &mut R {
        &mut self.records
    }

    /// The parameter that `text` stands for. What stands for the instance that is shown becomes that instance.
    ///
    /// # Errors
    /// [`ClientError::Target`], and what reading the selector may lead to.
    pub fn find(&mut self, text: &str) -> Result<NamedParameter, ClientError> {
        let names = self.names();
        match names.find(self.model.name, text)? {
            Target::Parameter(named) => Ok(named.clone()),
            Target::Raw { .. } => {
                let (device, text) = (self.model.name, text.to_owned());
                Err(TargetError::Unknown { device, text, alike: Vec::new() }.into())
            }
            Target::CurrentInstance { slot, index } => {
                let instance = self.selected_instance(slot)?;
                let named = names.at(slot, instance, index).cloned();
                named.ok_or_else(|| ClientError::Access {
                    place: self.raw_location(slot, index),
                    reason: format!("slot {slot} shows instance {instance} now, which has no index {index}; say {slot}:INSTANCE/{index}"),
                })
            }
        }
    }

    /// Reads a parameter by name or numbers.
    ///
    /// # Errors
    /// [`ClientError`] says what was refused, why, and what to do.
    pub fn parameter(&mut self, text: &str) -> Result<ParameterReading, ClientError> {
        let named = self.find(text)?;
        self.read(&named)
    }

    /// Reads a parameter.
    ///
    /// # Errors
    /// As [`parameter`](Self::parameter).
    pub fn read(&mut self, named: &NamedParameter) -> Result<ParameterReading, ClientError> {
        for _ in 0..ATTEMPTS {
            let reading = self.read_once(named)?;
            if self.is_still_selected(named)? {
                return Ok(reading);
            }
        }
        Err(self.selector_contention())
    }

    /// Reads a parameter of the instance that was shown last. Whether it [still is](Self::still_shows) is for the caller to ask.
    pub(super) fn read_once(&mut self, named: &NamedParameter) -> Result<ParameterReading, ClientError> {
        self.check_access(named, Direction::Read)?;
        self.select(named)?;
        let octets = self.read_record(named)?;
        let value = Value::of(named.parameter.row, &octets);
        let unit = self.unit_of(named)?;
        let text = ValueFormat { named, model: self.model, unit }.format(&value);
        Ok(ParameterReading { named: named.clone(), octets, value, text, unit: unit.map(|unit| unit.name) })
    }

    /// Reads a record that stands in no table.
    ///
    /// # Errors
    /// [`ClientError::Refused`], most likely.
    pub fn read_raw(&mut self, slot: u8, index: u8) -> Result<Vec<u8>, ClientError> {
        if !self.model.features.dpv1 && self.records.via() != AccessPath::ParameterChannel {
            let (device, address) = (self.model.name, self.address);
            return Err(ClientError::Unavailable {
                device,
                address,
                reason: "it has no DP-V1 services; say --via pkw".to_owned(),
            });
        }
        self.records
            .read(slot, index)
            .map_err(|error| ClientError::from_record(error, Operation::Read, self.raw_location(slot, index), None))
    }

    /// The pressure of the whole gauge: of the instance that the PV Selector names; of a controller, of the first channel that
    /// is valid.
    ///
    /// # Errors
    /// As [`parameter`](Self::parameter).
    pub fn pressure(&mut self) -> Result<PressureReading, ClientError> {
        let names = self.names();
        let selector = names.all().iter().find(|named| named.parameter.row.name.contains("PV Selector"));
        let active = selector.map(|selector| self.read(selector)).transpose()?;
        let active = active.and_then(|reading| reading.octets.first().copied()).unwrap_or_default();
        let is_value = |named: &&NamedParameter| {
            let parameter = named.parameter;
            parameter.row.name.contains("Value (PV)")
                && self.model.parts.iter().any(|facts| facts.part.instance == instance_of(named))
                && (active == 0 || parameter.place.instance == active)
        };
        let mut first = None;
        for value in names.all().iter().filter(is_value).collect::<Vec<_>>() {
            let pressure = self.pressure_of(value)?;
            if pressure.pa.is_some() {
                return Ok(pressure);
            }
            first = first.or(Some(pressure));
        }
        first.ok_or_else(|| self.unknown_parameter("process-value"))
    }

    /// The pressure of a Process Value, if Reading Valid and Status Extension of the same part say that it is one.
    ///
    /// # Errors
    /// As [`parameter`](Self::parameter).
    pub fn pressure_of(&mut self, named: &NamedParameter) -> Result<PressureReading, ClientError> {
        let reading = self.read(named)?;
        let is_valid = self.is_valid(named)?;
        let instance = instance_of(named);
        Ok(PressureReading { pa: self.pa(&reading, instance).filter(|_| is_valid), instance })
    }

    /// Whether Reading Valid and Status Extension beside a parameter say that what is measured there is a pressure.
    ///
    /// # Errors
    /// As [`parameter`](Self::parameter).
    pub fn is_valid(&mut self, named: &NamedParameter) -> Result<bool, ClientError> {
        let names = self.names();
        let mut is_valid = true;
        for beside in names.all().iter().filter(|other| other.is_same_instance(named)) {
            is_valid &= match beside.parameter.row.name {
                "Reading Valid" => self.read(beside)?.value == Value::Integer(1),
                "Status Extension" => self.read(beside)?.octets.first().is_some_and(|octet| octet & 1 == 0),
                _ => true,
            };
        }
        Ok(is_valid)
    }

    /// What a reading is in Pa.
    fn pa(&self, reading: &ParameterReading, instance: u8) -> Option<f64> {
        let Value::Number(number) = reading.value else { return None };
        let facts = self.model.parts.iter().find(|facts| facts.part.instance == instance)?;
        let format =
            PressureFormat { unit: self.unit?, number: NumberType::Float, counts: facts.counts, max_integer: u16::MAX };
        format.pa_from_number(number)
    }

    /// Checks a value for a parameter, reads what is there, and sends nothing.
    ///
    /// # Errors
    /// [`ClientError::Value`] for what the parameter does not take, [`ClientError::Condition`] for a command whose
    /// conditions are not met.
    pub fn prepare(&mut self, named: &NamedParameter, text: &str) -> Result<PreparedWrite, ClientError> {
        let order = self.prepare_unchecked(named, text)?;
        conditions::check(self, named, order.code)?;
        Ok(order)
    }

    /// The same without the conditions: those are for the caller to [ask for](Self::conditions).
    ///
    /// # Errors
    /// [`ClientError::Value`] for what the parameter does not take.
    pub fn prepare_unchecked(&mut self, named: &NamedParameter, text: &str) -> Result<PreparedWrite, ClientError> {
        self.check_access(named, Direction::Write)?;
        let readable = named.parameter.row.access.allows(self.records.via(), Direction::Read);
        let before = if readable && !named.parameter.row.codes.is_command() { Some(self.read(named)?) } else { None };
        let number = match before.as_ref().map(|before| before.octets.len()) {
            Some(2) => NumberType::Integer,
            _ => NumberType::Float,
        };
        let unit = self.unit_of(named)?;
        let meaning = ValueFormat { named, model: self.model, unit };
        let octets = meaning.parse(text, number);
        let octets = octets.map_err(|error| ClientError::Value { place: self.location(named), error })?;
        let value = Value::of(named.parameter.row, &octets);
        let text = meaning.format(&value);
        let code = code_of(named.parameter.row, &value);
        Ok(PreparedWrite { named: named.clone(), octets, text, code, before })
    }

    /// All conditions of what is to be written, with what is the case now.
    ///
    /// # Errors
    /// What reading may lead to.
    pub fn conditions(&mut self, order: &PreparedWrite) -> Result<Vec<Condition>, ClientError> {
        conditions::all(self, &order.named, order.code)
    }

    /// Sends what was prepared, and reads it back.
    ///
    /// # Errors
    /// [`ClientError::Refused`] with the manual's reason.
    pub fn execute(&mut self, order: PreparedWrite) -> Result<WriteResult, ClientError> {
        let PreparedWrite { named, octets, text, before, .. } = order;
        // Somebody else may have moved the selector since.
        self.invalidate_selector();
        self.select(&named)?;
        let (slot, index) = (named.parameter.place.slot, named.parameter.row.index);
        let written = self.records.write(slot, index, &octets);
        written
            .map_err(|error| ClientError::from_record(error, Operation::Write, self.location(&named), Some(&named)))?;
        if named.parameter.row.codes == Codes::Units {
            self.unit = None;
        }
        // Whoever moves it wants it there.
        if named.parameter.row.name == SELECTOR {
            self.selector_state = None;
        }
        let after = if before.is_some() { Some(self.read(&named)?) } else { None };
        Ok(WriteResult { named, before, after, text })
    }

    /// Writes a parameter by name or numbers.
    ///
    /// # Errors
    /// [`ClientError`] says what was refused, why, and what to do.
    pub fn write(&mut self, text: &str, value: &str) -> Result<WriteResult, ClientError> {
        let named = self.find(text)?;
        let order = self.prepare(&named, value)?;
        self.execute(order)
    }

    /// Carries out a command by its name: `execute`, `degas on`. Its conditions are checked before.
    ///
    /// # Errors
    /// As [`write`](Self::write).
    pub fn command(&mut self, name: &str) -> Result<WriteResult, ClientError> {
        let names = self.names();
        let (device, text) = (self.model.name, name.to_owned());
        let unknown = TargetError::Unknown { device, text, alike: Vec::new() };
        let (named, code) = names.command(name)?.ok_or(unknown)?;
        let order = self.prepare(named, code.name)?;
        self.execute(order)
    }

    /// Puts the Channel Instance Selector back. Whoever does not call this leaves it where it is.
    ///
    /// # Errors
    /// When it cannot be put back.
    pub fn restore_selector(&mut self) -> Result<(), ClientError> {
        match self.selector_state.take() {
            Some(SelectorState { original: first, current: now }) if first != now => self.write_selector(first),
            _ => Ok(()),
        }
    }

    /// Whether the Channel Instance Selector had to be moved: the master that owns the gauge saw another instance meanwhile.
    #[must_use]
    pub const fn selector_moved(&self) -> bool {
        self.selector_moved
    }

    /// The unit of all pressures, read once.
    ///
    /// # Errors
    /// When it cannot be read.
    pub fn unit(&mut self) -> Result<Option<&'static Unit>, ClientError> {
        if self.unit.is_none() {
            let names = self.names();
            let via = self.records.via();
            let here = |named: &&NamedParameter| {
                self.selector_state.is_some_and(|shown| named.parameter.place.instance == shown.current)
            };
            let is_unit = |row: &Row| row.codes == Codes::Units && row.access.allows(via, Direction::Read);
            let mut units = names.all().iter().filter(|named| is_unit(named.parameter.row));
            // The unit is the same everywhere: best where nothing has to be selected.
            let Some(named) = units.clone().find(here).or_else(|| units.next()) else { return Ok(None) };
            self.select(named)?;
            if let Value::Integer(code) = Value::of(named.parameter.row, &self.read_record(named)?) {
                self.unit = u16::try_from(code).ok().and_then(|code| self.model.unit(code));
            }
        }
        Ok(self.unit)
    }

    fn unit_of(&mut self, named: &NamedParameter) -> Result<Option<&'static Unit>, ClientError> {
        if named.parameter.row.data_type == DataType::ByType { self.unit() } else { Ok(None) }
    }

    fn read_record(&mut self, named: &NamedParameter) -> Result<Vec<u8>, ClientError> {
        let (slot, index) = (named.parameter.place.slot, named.parameter.row.index);
        let record = self.records.read(slot, index);
        record.map_err(|error| ClientError::from_record(error, Operation::Read, self.location(named), Some(named)))
    }

    /// What the table does not allow is not asked for.
    fn check_access(&self, named: &NamedParameter, direction: Direction) -> Result<(), ClientError> {
        let access = named.parameter.row.access;
        let via = self.records.via();
        if access.allows(via, direction) {
            return Ok(());
        }
        let reason = super::access::refusal(access, via, direction, named);
        Err(ClientError::Access { place: self.location(named), reason })
    }

    /// Which instance a slot shows.
    fn selected_instance(&mut self, slot: u8) -> Result<u8, ClientError> {
        if let Some(SelectorState { current: now, .. }) = self.selector_state.filter(|shown| shown.current != UNKNOWN) {
            return Ok(now);
        }
        let Some(selector) = self.selector(slot) else { return Ok(0) };
        let now = self.read_record(&selector)?.first().copied().unwrap_or_default();
        let first = self.selector_state.map_or(now, |shown| shown.original);
        self.selector_state = Some(SelectorState { original: first, current: now });
        Ok(now)
    }

    /// Whether the slot shows the instance of a parameter, also after it was read: another tool may move the selector.
    pub(super) fn is_still_selected(&mut self, named: &NamedParameter) -> Result<bool, ClientError> {
        let place = named.parameter.place;
        if place.instance == 0 {
            return Ok(true);
        }
        self.invalidate_selector();
        Ok(self.selected_instance(place.slot)? == place.instance)
    }

    /// Which instance is shown has to be asked for again.
    fn invalidate_selector(&mut self) {
        self.selector_state = self.selector_state.map(|shown| SelectorState { current: UNKNOWN, ..shown });
    }

    /// Somebody else does not let the selector stand.
    pub(super) fn selector_contention(&self) -> ClientError {
        let reason =
            "somebody else keeps moving the Channel Instance Selector: read again when they are done".to_owned();
        ClientError::Unavailable { device: self.model.name, address: self.address, reason }
    }

    /// Makes the slot show the instance of a parameter.
    fn select(&mut self, named: &NamedParameter) -> Result<(), ClientError> {
        let place = named.parameter.place;
        if place.instance == 0 || self.selected_instance(place.slot)? == place.instance {
            return Ok(());
        }
        // Until it is known that the telegram arrived.
        self.invalidate_selector();
        self.selector_moved = true;
        self.write_selector(place.instance)?;
        self.selector_state = self.selector_state.map(|shown| SelectorState { current: place.instance, ..shown });
        Ok(())
    }

    fn write_selector(&mut self, instance: u8) -> Result<(), ClientError> {
        let names = self.names();
        let selector = names.all().iter().find(|named| named.parameter.row.name == SELECTOR);
        let selector = selector.ok_or_else(|| self.unknown_parameter("channel-instance-selector"))?;
        let (slot, index) = (selector.parameter.place.slot, selector.parameter.row.index);
        let mut written = self.records.write(slot, index, &[instance]);
        // Twice the same is no other instance.
        for _ in 1..ATTEMPTS {
            if !matches!(written, Err(RecordError::Interrupted(_))) {
                break;
            }
            written = self.records.write(slot, index, &[instance]);
        }
        written
            .map_err(|error| ClientError::from_record(error, Operation::Write, self.location(selector), Some(selector)))
    }

    fn selector(&self, slot: u8) -> Option<NamedParameter> {
        let is_selector =
            |named: &&NamedParameter| named.parameter.place.slot == slot && named.parameter.row.name == SELECTOR;
        self.names.all().iter().find(is_selector).cloned()
    }

    fn unknown_parameter(&self, text: &str) -> ClientError {
        TargetError::Unknown { device: self.model.name, text: text.to_owned(), alike: Vec::new() }.into()
    }

    pub(super) fn location(&self, named: &NamedParameter) -> Location {
        let place = named.parameter.place;
        Location {
            device: self.model.name,
            address: self.address,
            name: Some(named.name.clone()),
            slot: place.slot,
            instance: place.instance,
            index: named.parameter.row.index,
        }
    }

    fn raw_location(&self, slot: u8, index: u8) -> Location {
        Location { device: self.model.name, address: self.address, name: None, slot, instance: 0, index }
    }
}

/// The number of the measuring part or channel a parameter belongs to.
const fn instance_of(named: &NamedParameter) -> u8 {
    let place = named.parameter.place;
    if place.instance > 0 { place.instance } else { place.slot }
}

/// The code of a table that a value is.
#[expect(clippy::cast_possible_truncation, reason = "a code held by a float is small")]
fn code_of(row: &'static Row, value: &Value) -> Option<&'static Code> {
    match value {
        Value::Integer(number) => row.codes.code(*number),
        Value::Number(number) => row.codes.code(*number as i64),
        Value::Octets(octets) => match octets.as_slice() {
            [command, value] => row.codes.code(u16::from_be_bytes([*command, *value]).into()),
            _ => None,
        },
        Value::Text(_) => None,
    }
}
