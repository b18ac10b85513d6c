//! A gauge: its pressure, its parameters by name, its commands.

pub mod conditions;
mod typed;

use super::error::{AccessReason, ClientError, Operation, ParameterContext};
use super::identify;
use super::names::{NamedParameter, ParameterNames, Target, TargetError};
use super::pressure::Pressure;
use super::records::{RecordError, Records, Unavailable, UnrestoredRecord};
use super::values::{Value, ValueFormat};
use crate::ms2::Ms2;
use conditions::Condition;
use profivac_devices::model::{
    Access, AccessPath, Code, Codes, DataType, Direction, Model, NumberType, PressureFormat, Row, Unit,
};
use profivac_devices::reading::is_pressure;
use profivac_host::session::BusSession;
use std::sync::Arc;

/// The parameter that selects the instance a slot shows: tira41d1 3.2.1.2, tira56e1 9.1.1.
pub(super) const SELECTOR: &str = "Channel Instance Selector";

/// How often the selector is written when telegrams are lost.
const ATTEMPTS: usize = 3;

/// A gauge behind a service `R`.
///
/// Where several instances share a slot, a request for one of them moves the Channel Instance Selector. Dropping the gauge
/// moves it back, also when an error or a panic ends the work. If the line is lost at that moment, the bus session keeps the
/// original instance, and the next gauge at the same address restores it before its first request. So reading
/// changes nothing. [`restore_selector`](Self::restore_selector) does the same earlier and reports errors.
///
/// ```
/// # use profivac_client::Bus;
/// # let mut bus = Bus::builder("sim").open_on(profivac_virtual::open::devices(&["bcg450@5:unit=mbar"])?)?;
/// let mut gauge = bus.gauge(5)?;
/// println!("{} measures {}", gauge.model().title, gauge.parameter("pirani.process-value")?.text);
/// gauge.write("pirani.safe-value", "12.5 Pascal")?;
/// assert_eq!(gauge.parameter("pirani.safe-value")?.text, "0.125 mbar");
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub struct Gauge<R: Records> {
    records: R,
    address: u8,
    model: &'static Model,
    names: Arc<ParameterNames>,
    unit: Option<&'static Unit>,
    selector_state: Option<SelectorState>,
    selector_moved: bool,
}

/// An instance number that no device uses: the selector must be read again.
const UNKNOWN: u8 = 0;

/// The Channel Instance Selector as far as it is known.
#[derive(Clone, Copy, Debug)]
struct SelectorState {
    /// The instance before this gauge moved the selector.
    original: u8,
    /// The present instance, or [`UNKNOWN`].
    current: u8,
    /// The instance that this gauge wrote last, if it did.
    written: Option<u8>,
}

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
}

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

impl<R: Records> Drop for Gauge<R> {
    /// Restores the Channel Instance Selector.
    fn drop(&mut self) {
        self.restore_selector().ok();
    }
}

impl<'a> Gauge<Ms2<'a>> {
    /// Finds the gauge at `address` and reads it over MS2. Needs no parameterisation and changes nothing.
    ///
    /// # Errors
    /// [`ClientError::NoAnswer`], [`ClientError::Master`] or [`ClientError::UnknownDevice`].
    pub fn open(session: &'a mut BusSession, address: u8) -> Result<Self, ClientError> {
        let status = identify::wait_for_slave(session, address)?;
        Self::new(Ms2::new(session, address), address, status.ident)
    }
}

impl<R: Records> Gauge<R> {
    /// The gauge with this Ident_Number behind `records`.
    ///
    /// # Errors
    /// [`ClientError::UnknownDevice`].
    pub fn new(mut records: R, address: u8, ident: u16) -> Result<Self, ClientError> {
        let model = identify::model(ident, address, &mut records)?;
        Ok(Self::with_model(records, address, model))
    }

    /// A gauge whose model is known.
    pub fn with_model(records: R, address: u8, model: &'static Model) -> Self {
        let names = Arc::new(ParameterNames::of(model));
        Self { records, address, model, names, unit: None, selector_state: None, selector_moved: false }
    }

    /// The same gauge with a known unit, which is then not read.
    #[must_use]
    pub fn with_unit(mut self, unit: &'static Unit) -> Self {
        self.unit = Some(unit);
        self
    }

    /// The tables of the device.
    #[must_use]
    pub const fn model(&self) -> &'static Model {
        self.model
    }

    /// The address of the slave.
    #[must_use]
    pub const fn address(&self) -> u8 {
        self.address
    }

    /// The parameters of the device.
    #[must_use]
    pub fn names(&self) -> Arc<ParameterNames> {
        Arc::clone(&self.names)
    }

    /// The service behind the gauge.
    pub const fn records(&mut self) -> &mut R {
        &mut self.records
    }

    /// Finds the parameter that `text` names. Slot and index without an instance select the instance that the slot shows now.
    ///
    /// # Errors
    /// [`ClientError::Target`], and the errors of reading the selector.
    pub fn find(&mut self, text: &str) -> Result<NamedParameter, ClientError> {
        let names = self.names();
        match names.find(self.model.name, text)? {
            Target::Parameter(named) => Ok(named.clone()),
            Target::Raw { .. } => Err(self.unknown_parameter(text)),
            Target::CurrentInstance { slot, index } => {
                let instance = self.selected_instance(slot)?;
                names.at(slot, instance, index).cloned().ok_or_else(|| ClientError::Access {
                    place: self.raw_context(slot, index),
                    reason: AccessReason::NotInInstance { slot, instance, index },
                })
            }
        }
    }

    /// Reads a parameter by name (`pirani.process-value`) or numbers (`1:1/19`).
    ///
    /// # Errors
    /// [`ClientError`].
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

    /// Reads a parameter without checking that the selector [did not move](Self::is_still_selected) meanwhile.
    pub(super) fn read_once(&mut self, named: &NamedParameter) -> Result<ParameterReading, ClientError> {
        self.check_access(named, Direction::Read)?;
        self.select(named)?;
        let octets = self.read_record(named)?;
        let value = Value::of(named.parameter.row, &octets);
        let unit = self.unit_of(named)?;
        let text = ValueFormat { named, model: self.model, unit }.format(&value);
        Ok(ParameterReading { named: named.clone(), octets, value, text, unit: unit.map(|unit| unit.name) })
    }

    /// Reads a record that is in no table.
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

    /// Reads the pressure: of the instance that the PV Selector names, or of the first valid channel of a controller.
    ///
    /// ```
    /// # use profivac_client::Bus;
    /// # let mut bus = Bus::builder("sim").open_on(profivac_virtual::open::devices(&["bcg450@5"])?)?;
    /// # bus.gauge(5)?.command("execute")?;
    /// let reading = bus.gauge(5)?.pressure()?;
    /// let pressure = reading.pressure().ok_or("the reading is not valid")?;
    /// println!("{} mbar, {} Pa, {} Torr", pressure.mbar(), pressure.pa(), pressure.torr());
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    ///
    /// # Errors
    /// As [`parameter`](Self::parameter).
    pub fn pressure(&mut self) -> Result<PressureReading, ClientError> {
        let names = self.names();
        let selector = names.all().iter().find(|named| named.parameter.row.name.contains("PV Selector"));
        let active = selector.map(|selector| self.read(selector)).transpose()?;
        let active = active.and_then(|reading| reading.octets.first().copied()).unwrap_or_default();
        let parts = self.model.parts;
        let is_value = |named: &&NamedParameter| {
            let parameter = named.parameter;
            parameter.row.name.contains("Value (PV)")
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
    /// # Errors
    /// As [`parameter`](Self::parameter).
    pub fn pressure_of(&mut self, named: &NamedParameter) -> Result<PressureReading, ClientError> {
        let reading = self.read(named)?;
        let is_valid = self.is_valid(named)?;
        let instance = instance_of(named);
        Ok(PressureReading { pa: self.pa(&reading, instance).filter(|pa| is_valid && is_pressure(*pa)), instance })
    }

    /// Whether Reading Valid and Status Extension of the same instance declare the reading valid.
    ///
    /// # Errors
    /// As [`parameter`](Self::parameter).
    pub fn is_valid(&mut self, named: &NamedParameter) -> Result<bool, ClientError> {
        let names = self.names();
        let mut is_valid = true;
        for other in names.all().iter().filter(|other| other.is_same_instance(named)) {
            is_valid &= match other.parameter.row.name {
                "Reading Valid" => self.read(other)?.value == Value::Integer(1),
                "Status Extension" => self.read(other)?.octets.first().is_some_and(|octet| octet & 1 == 0),
                _ => true,
            };
        }
        Ok(is_valid)
    }

    /// A reading in Pa.
    fn pa(&self, reading: &ParameterReading, instance: u8) -> Option<f64> {
        let Value::Number(number) = reading.value else { return None };
        let spec = self.model.parts.iter().find(|spec| spec.part.instance == instance)?;
        let counts = spec.counts;
        let format = PressureFormat { unit: self.unit?, number: NumberType::Float, counts, max_integer: u16::MAX };
        format.pa_from_number(number)
    }

    /// Checks a value for a parameter, and the conditions of a command. Reads the present value; writes nothing.
    ///
    /// ```
    /// # use profivac_client::{Bus, ClientError};
    /// # let mut bus = Bus::builder("sim").open_on(profivac_virtual::open::devices(&["bcg450@5"])?)?;
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
    /// [`ClientError::Value`], or [`ClientError::Condition`] for a command whose conditions are not met.
    pub fn prepare(&mut self, named: &NamedParameter, text: &str) -> Result<PreparedWrite, ClientError> {
        let write = self.prepare_unchecked(named, text)?;
        conditions::check(self, named, write.code)?;
        Ok(write)
    }

    /// Checks a value for a parameter but not the [conditions](Self::conditions) of a command.
    ///
    /// # Errors
    /// [`ClientError::Value`].
    pub fn prepare_unchecked(&mut self, named: &NamedParameter, text: &str) -> Result<PreparedWrite, ClientError> {
        self.check_access(named, Direction::Write)?;
        let readable = named.parameter.row.access.allows(self.records.via(), Direction::Read);
        let before = if readable && !named.parameter.row.codes.is_command() { Some(self.read(named)?) } else { None };
        let number = match before.as_ref().map(|before| before.octets.len()) {
            Some(2) => NumberType::Integer,
            _ => NumberType::Float,
        };
        let unit = self.unit_of(named)?;
        let format = ValueFormat { named, model: self.model, unit };
        let octets = format.parse(text, number);
        let octets = octets.map_err(|error| ClientError::Value { place: self.context(named), error })?;
        let value = Value::of(named.parameter.row, &octets);
        let text = format.format(&value);
        let code = code_of(named.parameter.row, &value);
        Ok(PreparedWrite { named: named.clone(), octets, text, code, before })
    }

    /// The conditions of a prepared write, each with the present state of the gauge.
    ///
    /// # Errors
    /// The errors of reading.
    pub fn conditions(&mut self, write: &PreparedWrite) -> Result<Vec<Condition>, ClientError> {
        conditions::all(self, &write.named, write.code)
    }

    /// Sends a prepared write and reads the parameter back.
    ///
    /// # Errors
    /// [`ClientError::Refused`] with the codes of the device.
    pub fn execute(&mut self, write: PreparedWrite) -> Result<WriteResult, ClientError> {
        let PreparedWrite { named, octets, text, before, .. } = write;
        // Another master may have moved the selector since.
        self.invalidate_selector();
        self.recover_selector()?;
        self.select(&named)?;
        let (slot, index) = (named.parameter.place.slot, named.parameter.row.index);
        let written = self.records.write(slot, index, &octets);
        written
            .map_err(|error| ClientError::from_record(error, Operation::Write, self.context(&named), Some(&named)))?;
        if named.parameter.row.codes == Codes::Units {
            self.unit = None;
        }
        // The caller moves the selector on purpose: it stays where it is.
        if named.parameter.row.name == SELECTOR {
            self.selector_state = None;
        }
        let after = if before.is_some() { Some(self.read(&named)?) } else { None };
        Ok(WriteResult { named, before, after, text })
    }

    /// Writes a parameter by name or numbers, and reads it back.
    ///
    /// # Errors
    /// [`ClientError`].
    pub fn write(&mut self, text: &str, value: &str) -> Result<WriteResult, ClientError> {
        let named = self.find(text)?;
        let write = self.prepare(&named, value)?;
        self.execute(write)
    }

    /// Sends a command by name, such as `execute` or `degas on`, if its conditions are met.
    ///
    /// ```
    /// # use profivac_client::Bus;
    /// use profivac_devices::profile::DeviceState;
    ///
    /// # let mut bus = Bus::builder("sim").open_on(profivac_virtual::open::devices(&["bcg450@5"])?)?;
    /// let mut gauge = bus.gauge(5)?;
    /// if gauge.device_state()? == DeviceState::Idle {
    ///     gauge.command("execute")?;
    /// }
    /// assert_eq!(gauge.device_state()?, DeviceState::Executing);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    ///
    /// # Errors
    /// As [`write`](Self::write).
    pub fn command(&mut self, name: &str) -> Result<WriteResult, ClientError> {
        let names = self.names();
        let (named, code) = names.command(name)?.ok_or_else(|| self.unknown_parameter(name))?;
        let write = self.prepare(named, code.name)?;
        self.execute(write)
    }

    /// Moves the Channel Instance Selector back to the instance it showed at the beginning. Dropping the gauge does the same.
    ///
    /// # Errors
    /// The selector cannot be written. If the line is the reason, the next gauge at this address restores it.
    pub fn restore_selector(&mut self) -> Result<(), ClientError> {
        let Some(SelectorState { original, current, written: Some(written) }) = self.selector_state.take() else {
            return Ok(());
        };
        if original == current {
            return Ok(());
        }
        let restored = self.write_selector(original);
        if let (Err(ClientError::Session(_) | ClientError::Interrupted { .. }), Some(selector)) =
            (&restored, self.any_selector())
        {
            let (slot, index) = (selector.parameter.place.slot, selector.parameter.row.index);
            self.records.keep_unrestored(UnrestoredRecord { slot, index, written, original });
        }
        restored
    }

    /// Restores the selector that an earlier gauge at this address could not restore, unless another master has moved it since.
    fn recover_selector(&mut self) -> Result<(), ClientError> {
        let Some(record) = self.records.take_unrestored() else { return Ok(()) };
        let UnrestoredRecord { slot, index, written, original } = record;
        let read = self.records.read(slot, index);
        let restored = read.and_then(|octets| match octets.first() {
            Some(current) if *current == written => self.records.write(slot, index, &[original]),
            _ => Ok(()),
        });
        restored.map_err(|error| {
            self.records.keep_unrestored(record);
            ClientError::from_record(error, Operation::Write, self.raw_context(slot, index), None)
        })
    }

    /// Whether this gauge moved the Channel Instance Selector, so that the owner of the slave saw another instance meanwhile.
    #[must_use]
    pub const fn selector_moved(&self) -> bool {
        self.selector_moved
    }

    /// The unit of all pressures, read once.
    ///
    /// # Errors
    /// The errors of reading.
    pub fn unit(&mut self) -> Result<Option<&'static Unit>, ClientError> {
        if self.unit.is_none() {
            let names = self.names();
            let via = self.records.via();
            let is_selected = |named: &&NamedParameter| {
                self.selector_state.is_some_and(|state| named.parameter.place.instance == state.current)
            };
            let is_unit = |row: &Row| row.codes == Codes::Units && row.access.allows(via, Direction::Read);
            let mut units = names.all().iter().filter(|named| is_unit(named.parameter.row));
            // All instances have the same unit: prefer the one that needs no move of the selector.
            let Some(named) = units.clone().find(is_selected).or_else(|| units.next()) else { return Ok(None) };
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
        self.recover_selector()?;
        let (slot, index) = (named.parameter.place.slot, named.parameter.row.index);
        let record = self.records.read(slot, index);
        record.map_err(|error| ClientError::from_record(error, Operation::Read, self.context(named), Some(named)))
    }

    /// Fails without a request if the table forbids the access.
    fn check_access(&self, named: &NamedParameter, direction: Direction) -> Result<(), ClientError> {
        let via = self.records.via();
        if named.parameter.row.access.allows(via, direction) {
            return Ok(());
        }
        Err(ClientError::Access {
            place: self.context(named),
            reason: access_reason(named.parameter.row, via, direction),
        })
    }

    /// The instance that a slot shows.
    fn selected_instance(&mut self, slot: u8) -> Result<u8, ClientError> {
        if let Some(SelectorState { current, .. }) = self.selector_state.filter(|state| state.current != UNKNOWN) {
            return Ok(current);
        }
        let Some(selector) = self.selector(slot) else { return Ok(0) };
        let current = self.read_record(&selector)?.first().copied().unwrap_or_default();
        let state = self.selector_state.unwrap_or(SelectorState { original: current, current, written: None });
        self.selector_state = Some(SelectorState { current, ..state });
        Ok(current)
    }

    /// Whether the slot still shows the instance of a parameter after the parameter was read: another master may move the
    /// selector.
    pub(super) fn is_still_selected(&mut self, named: &NamedParameter) -> Result<bool, ClientError> {
        let place = named.parameter.place;
        if place.instance == 0 {
            return Ok(true);
        }
        self.invalidate_selector();
        Ok(self.selected_instance(place.slot)? == place.instance)
    }

    /// Marks the present instance as unknown.
    fn invalidate_selector(&mut self) {
        self.selector_state = self.selector_state.map(|state| SelectorState { current: UNKNOWN, ..state });
    }

    /// Another master moves the selector between every two requests.
    pub(super) const fn selector_contention(&self) -> ClientError {
        self.unavailable(Unavailable::SelectorContention)
    }

    pub(super) const fn unavailable(&self, reason: Unavailable) -> ClientError {
        ClientError::Unavailable { device: self.model.name, address: self.address, reason }
    }

    /// Makes the slot show the instance of a parameter.
    fn select(&mut self, named: &NamedParameter) -> Result<(), ClientError> {
        let place = named.parameter.place;
        if place.instance == 0 || self.selected_instance(place.slot)? == place.instance {
            return Ok(());
        }
        // Until the answer arrives, the selector may show either instance.
        let moving = |state| SelectorState { current: UNKNOWN, written: Some(place.instance), ..state };
        self.selector_state = self.selector_state.map(moving);
        self.selector_moved = true;
        self.write_selector(place.instance)?;
        self.selector_state = self.selector_state.map(|state| SelectorState { current: place.instance, ..state });
        Ok(())
    }

    fn write_selector(&mut self, instance: u8) -> Result<(), ClientError> {
        let selector = self.any_selector().ok_or_else(|| self.unknown_parameter("channel-instance-selector"))?;
        let (slot, index) = (selector.parameter.place.slot, selector.parameter.row.index);
        let mut written = self.records.write(slot, index, &[instance]);
        // Writing the same instance twice has no further effect, so a lost answer may be answered by a repetition.
        for _ in 1..ATTEMPTS {
            if !matches!(written, Err(RecordError::Interrupted(_))) {
                break;
            }
            written = self.records.write(slot, index, &[instance]);
        }
        written.map_err(|error| {
            ClientError::from_record(error, Operation::Write, self.context(&selector), Some(&selector))
        })
    }

    /// The selector of a slot.
    fn selector(&self, slot: u8) -> Option<NamedParameter> {
        let is_selector =
            |named: &&NamedParameter| named.parameter.place.slot == slot && named.parameter.row.name == SELECTOR;
        self.names.all().iter().find(is_selector).cloned()
    }

    /// The selector of the device. No device has two.
    fn any_selector(&self) -> Option<NamedParameter> {
        self.names.all().iter().find(|named| named.parameter.row.name == SELECTOR).cloned()
    }

    fn unknown_parameter(&self, text: &str) -> ClientError {
        TargetError::Unknown { device: self.model.name, text: text.to_owned(), alike: Vec::new() }.into()
    }

    /// The context of an error about a parameter.
    pub(super) fn context(&self, named: &NamedParameter) -> ParameterContext {
        let place = named.parameter.place;
        ParameterContext {
            device: self.model.name,
            address: self.address,
            name: Some(named.name.clone()),
            slot: place.slot,
            instance: place.instance,
            index: named.parameter.row.index,
        }
    }

    fn raw_context(&self, slot: u8, index: u8) -> ParameterContext {
        ParameterContext { device: self.model.name, address: self.address, name: None, slot, instance: 0, index }
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

/// The number of the measuring part or channel of a parameter.
const fn instance_of(named: &NamedParameter) -> u8 {
    let place = named.parameter.place;
    if place.instance > 0 { place.instance } else { place.slot }
}

/// The entry of the code table for a value.
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
