//! The errors of a gauge. Each message names address, parameter, slot and index, the reason, and what to do.

use super::names::{NamedParameter, TargetError};
use super::records::{ErrorKind, Interruption, RecordError, RefusalCodes, Unavailable, WriteEffect};
use super::values::{BeyondRange, ValueError, format_number};
use profivac_devices::model::{AccessPath, Codes, LengthError, Role};
use profivac_devices::profile::{DeviceState, StateEvent};
use profivac_host::session::SessionError;
use profivac_wire::acyclic::ErrorCode;
use std::{fmt, io};

/// The operation that failed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Operation {
    /// Reading a parameter.
    Read,
    /// Writing a parameter, or sending a command.
    Write,
    /// Moving the Channel Instance Selector to the instance of a parameter, or back.
    Select,
}

/// The device and the parameter that an error is about.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct ParameterContext {
    /// The device.
    pub device: &'static str,
    /// The address of the slave.
    pub address: u8,
    /// The name of the parameter. A record outside the tables has none.
    pub name: Option<String>,
    /// The slot.
    pub slot: u8,
    /// The instance, 0 where the slot has only one.
    pub instance: u8,
    /// The index.
    pub index: u8,
}

/// The reason why an operation on a gauge failed.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum ClientError {
    /// The bus session failed.
    #[error(transparent)]
    Session(#[from] SessionError),
    /// The thread of an [`AsyncBus`](crate::AsyncBus) has ended because its port is lost.
    #[error("the bus is closed")]
    Closed,
    /// The system has no thread or no socket left.
    #[error(transparent)]
    System(#[from] io::Error),
    /// No station answers at the address.
    #[error("no station answers at address {0}")]
    NoAnswer(u8),
    /// The station is a master.
    #[error("the station at address {0} is a master, not a gauge")]
    Master(u8),
    /// No known device has this Ident_Number.
    #[error(
        "the slave at address {address} has the ident number 0x{ident:04X}, which no known device has: its parameters have no names here"
    )]
    UnknownDevice {
        /// The address.
        address: u8,
        /// Ident_Number.
        ident: u16,
    },
    /// Device files describe several devices with this Ident_Number.
    #[error(
        "the slave at address {address} has the ident number 0x{ident:04X} of {}: name the device file of one of them only",
        .names.join(" and ")
    )]
    SeveralDevices {
        /// The address.
        address: u8,
        /// Ident_Number.
        ident: u16,
        /// The devices.
        names: Vec<&'static str>,
    },
    /// The text names no parameter or command.
    #[error(transparent)]
    Target(#[from] TargetError),
    /// The parameter does not accept the value.
    #[error("{location}: {error}")]
    Value {
        /// The parameter.
        location: ParameterContext,
        /// The accepted values.
        error: Box<ValueError>,
    },
    /// The pressure is outside the measuring range of the gauge. It was not sent.
    #[error("{location}: {error}")]
    BeyondRange {
        /// The parameter.
        location: ParameterContext,
        /// The pressure and the range.
        error: Box<BeyondRange>,
    },
    /// The table does not allow the access.
    #[error("{location}: {reason}")]
    Access {
        /// The parameter.
        location: ParameterContext,
        /// The reason.
        reason: AccessReason,
    },
    /// A condition of a command is not met. The command was not sent.
    #[error("{location}: {command} was not sent: {unmet}")]
    Condition {
        /// The parameter.
        location: ParameterContext,
        /// The command.
        command: &'static str,
        /// The condition.
        unmet: Unmet,
    },
    /// The slave refused.
    #[error("{location}: {doing} was refused with {refused}{}", advice_text(advice))]
    Refused {
        /// The parameter.
        location: ParameterContext,
        /// The operation.
        doing: Operation,
        /// The codes of the slave.
        refused: RefusalCodes,
        /// Advice, where the codes are specific enough.
        advice: Option<Advice>,
    },
    /// The slave answered with a record that is no value of the parameter.
    #[error("{location}: {doing} gave no value: {error}")]
    Malformed {
        /// The parameter.
        location: ParameterContext,
        /// The operation.
        doing: Operation,
        /// The number of octets.
        error: LengthError,
    },
    /// The slave does not offer the service.
    #[error("{device} at address {address}: {reason}")]
    Unavailable {
        /// The device.
        device: &'static str,
        /// The address of the slave.
        address: u8,
        /// The reason.
        reason: Unavailable,
    },
    /// No usable answer arrived.
    #[error("{location}: {doing} was cut short: {reason}{}", interrupted_effect(*.doing, .reason))]
    Interrupted {
        /// The parameter.
        location: ParameterContext,
        /// The operation.
        doing: Operation,
        /// The reason.
        reason: Interruption,
    },
    /// The bus session failed while a write was under way. The device may have accepted the value.
    #[error("{location}: writing was cut short: {error}{MAY_BE_WRITTEN}")]
    WriteLost {
        /// The parameter.
        location: ParameterContext,
        /// The reason.
        error: SessionError,
    },
    /// The device has accepted the value, and reading it back failed.
    #[error("{location}: the value was written; reading it back failed: {}", without_location(error, location))]
    NotReadBack {
        /// The parameter.
        location: ParameterContext,
        /// The error of reading.
        error: Box<ClientError>,
    },
    /// A typed parameter cannot be used.
    #[error("{location}: {error}")]
    Typed {
        /// The parameter.
        location: ParameterContext,
        /// The reason.
        error: TypedError,
    },
    /// The unit of the gauge has changed since the value was checked. The value was not sent.
    #[error(
        "{location}: not written: the unit of the gauge was {prepared} when the value was checked and is {present} now; try again"
    )]
    UnitChanged {
        /// The parameter.
        location: ParameterContext,
        /// The unit of the value.
        prepared: &'static str,
        /// The present unit.
        present: &'static str,
    },
    /// The parameter does not have the value that was written.
    #[error("{location}: {written} was written, but it reads {found}")]
    NotKept {
        /// The parameter.
        location: ParameterContext,
        /// The written value.
        written: String,
        /// The value that was read back.
        found: String,
    },
}

/// What to do after a write whose effect is not known.
const MAY_BE_WRITTEN: &str = "; it may have been written, read it";

/// The text of an error without the parameter that it begins with.
fn without_location(error: &ClientError, location: &ParameterContext) -> String {
    let text = error.to_string();
    text.strip_prefix(&format!("{location}: ")).map_or_else(|| text.clone(), str::to_owned)
}

/// The effect of an interrupted operation, if it changes something.
const fn interrupted_effect(doing: Operation, reason: &Interruption) -> &'static str {
    match (doing, reason.write_effect()) {
        (Operation::Write, WriteEffect::PossiblyExecuted) => MAY_BE_WRITTEN,
        (Operation::Write, _) => "; nothing was written",
        (Operation::Read | Operation::Select, _) => "",
    }
}

/// The reason why a typed parameter cannot be used.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum TypedError {
    /// The model has no such parameter at this location.
    #[error("it has no {parameter} at {location}")]
    NotOnModel {
        /// The name of the parameter.
        parameter: &'static str,
        /// The name of the location.
        location: &'static str,
    },
    /// The value is not in the code table, or has another length.
    #[error("{} is no value of its table", crate::values::hex(octets))]
    UnknownCode {
        /// The octets of the record.
        octets: Vec<u8>,
    },
    /// The integer is the highest of its format and stands for every higher pressure.
    #[error(
        "the integer {} is the highest of its format and stands for every higher pressure: choose the data type float",
        crate::values::hex(octets)
    )]
    HighestInteger {
        /// The octets of the record.
        octets: Vec<u8>,
    },
    /// The integer 0 of a measured pressure stands for every pressure below one unit, or for none.
    #[error("the integer 0 is no measured pressure, or less than one unit: choose the data type float")]
    BelowOneUnit,
    /// The unit of the pressure is in no table of the device, or the tables have no scale for its COUNTS.
    #[error("the unit of the pressure is not known")]
    NoUnit,
}

/// The reason why the access column of a table forbids an access. `marks` is the column as the manual prints it.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum AccessReason {
    /// Another service may do it.
    #[error("the manual allows it only by {} (access {marks})", path_name(*.path))]
    OtherPath {
        /// The access column.
        marks: &'static str,
        /// The service.
        path: AccessPath,
    },
    /// Only Set_Prm sets the parameter.
    #[error("only the user parameters of its master set it (access {marks})")]
    UserParameters {
        /// The access column.
        marks: &'static str,
    },
    /// The parameter is part of the cyclic data only.
    #[error("it is in the cyclic data only (access {marks})")]
    CyclicOnly {
        /// The access column.
        marks: &'static str,
    },
    /// No service reads it.
    #[error("it cannot be read (access {marks})")]
    NotReadable {
        /// The access column.
        marks: &'static str,
    },
    /// No service writes it.
    #[error("it is read-only (access {marks})")]
    ReadOnly {
        /// The access column.
        marks: &'static str,
    },
    /// The instance that the slot shows has no such index.
    #[error(
        "slot {slot} shows instance {instance} now, which has no index {index}; name the instance: {slot}:INSTANCE/{index}"
    )]
    NotInInstance {
        /// The slot.
        slot: u8,
        /// The instance that the Channel Instance Selector selects.
        instance: u8,
        /// The index.
        index: u8,
    },
}

/// The name of a service.
const fn path_name(path: AccessPath) -> &'static str {
    match path {
        AccessPath::Class2 => "MS2",
        AccessPath::Class1 => "MS1",
        AccessPath::ParameterChannel => "the parameter channel",
    }
}

/// The condition of a command that is not met, and what to do. `found` is `None` for a code that is no device state.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub enum Unmet {
    /// The state diagram has no such transition from the present state.
    State {
        /// The present state.
        found: Option<DeviceState>,
        /// The command as an event of the state diagram.
        event: StateEvent,
    },
    /// The gauge must be in EXECUTING.
    NotExecuting {
        /// The present state.
        found: Option<DeviceState>,
    },
    /// The emission must be on.
    EmissionOff,
    /// A degas runs already.
    DegasRuns,
    /// A pressure is on the wrong side of a limit.
    WrongPressure {
        /// The process value.
        parameter: String,
        /// The pressure.
        found: FoundPressure,
        /// The limit.
        limit: PressureLimit,
    },
    /// A pressure must be on one side of a limit and is not valid.
    NoPressure {
        /// The process value.
        parameter: String,
        /// The limit.
        limit: PressureLimit,
    },
}

/// The side of a limit in Pa on which a pressure must be.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum PressureLimit {
    /// Below it.
    Below(f64),
    /// Above it.
    Above(f64),
}

/// A pressure in Pa as a gauge shows it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum FoundPressure {
    /// The pressure.
    At(f64),
    /// Below the range of the gauge, which begins here.
    Below(f64),
    /// Above the range of the gauge, which ends here.
    Above(f64),
}

impl fmt::Display for PressureLimit {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Below(pa) => write!(f, "below {}", mbar(*pa)),
            Self::Above(pa) => write!(f, "above {}", mbar(*pa)),
        }
    }
}

impl fmt::Display for FoundPressure {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::At(pa) => f.write_str(&mbar(*pa)),
            Self::Below(pa) => write!(f, "below {}", mbar(*pa)),
            Self::Above(pa) => write!(f, "above {}", mbar(*pa)),
        }
    }
}

impl PressureLimit {
    /// Whether a pressure is on the required side. A gauge that is out of range bounds the pressure. `None` if that does not
    /// tell the side.
    pub(crate) fn is_met_by(self, found: FoundPressure) -> Option<bool> {
        match (self, found) {
            (Self::Below(limit), FoundPressure::At(pa)) => Some(pa < limit),
            (Self::Above(limit), FoundPressure::At(pa)) => Some(pa > limit),
            (Self::Below(limit), FoundPressure::Below(end)) => (end <= limit).then_some(true),
            (Self::Above(limit), FoundPressure::Below(end)) => (end <= limit).then_some(false),
            (Self::Below(limit), FoundPressure::Above(end)) => (end >= limit).then_some(false),
            (Self::Above(limit), FoundPressure::Above(end)) => (end >= limit).then_some(true),
        }
    }
}

impl fmt::Display for Unmet {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::State { found, event } => {
                let (found, from) = (state_name(*found), source_states(*event));
                write!(f, "the gauge is in {found}, and it is possible from {from} only")
            }
            Self::NotExecuting { found } => {
                write!(f, "the gauge is in {} and must be in EXECUTING; write execute first", state_name(*found))
            }
            Self::EmissionOff => f.write_str("the emission is off; it must be on"),
            Self::DegasRuns => f.write_str("a degas runs; it ends by itself, or write degas off"),
            Self::WrongPressure { parameter, found, limit } => {
                let advice = match limit {
                    PressureLimit::Below(_) => "pump down first",
                    PressureLimit::Above(_) => "vent first",
                };
                write!(f, "{parameter} is {found} and must be {limit}; {advice}")
            }
            Self::NoPressure { parameter, limit } => write!(f, "{parameter} is not valid now, and must be {limit}"),
        }
    }
}

/// All device states.
pub(crate) const STATES: [DeviceState; 6] = [
    DeviceState::SelfTesting,
    DeviceState::Idle,
    DeviceState::SelfTestException,
    DeviceState::Executing,
    DeviceState::Abort,
    DeviceState::CriticalFault,
];

/// The name of a state.
pub(crate) const fn state_name(state: Option<DeviceState>) -> &'static str {
    match state {
        Some(state) => state.name(),
        None => "no known state",
    }
}

/// The states from which an event has a transition.
pub(crate) fn source_states(event: StateEvent) -> String {
    let from: Vec<_> = STATES.into_iter().filter(|state| state.next(event).is_ok()).map(DeviceState::name).collect();
    from.join(", ")
}

/// A pressure in mbar.
pub(crate) fn mbar(pa: f64) -> String {
    format!("{} mbar", format_number(pa / 100.0))
}

/// Advice about a refusal.
#[derive(Clone, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum Advice {
    /// The parameter belongs to a set that must be opened for changes. `lock` is the parameter that opens it.
    OpenSet {
        /// The name of the parameter.
        lock: String,
    },
    /// The gauge is already in the requested state.
    NothingToDo,
    /// Unit and number type change only in IDLE and without cyclic exchange.
    StopFirst,
    /// The operating mode does not allow it.
    CheckMode,
    /// The state or the pressure does not allow it.
    CheckStateAndPressure,
    /// The value is outside the range.
    CheckRange,
    /// The part is not fitted, or the slot shows another instance.
    NotFitted,
    /// The nonvolatile memory of the device failed.
    ReadExceptions,
}

impl fmt::Display for Advice {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::OpenSet { lock } => {
                return write!(f, "open the set first: write {lock} open-for-changes, and valid afterwards");
            }
            Self::NothingToDo => "nothing needs to be done",
            Self::StopFirst => {
                "unit and number type change only in IDLE and without cyclic exchange: write stop first, or end the exchange in the owning master"
            }
            Self::CheckMode => "read device.device-state, and the parameter that says who sets this one",
            Self::CheckStateAndPressure => {
                "the state or the pressure does not allow it: read device.device-state and the process value"
            }
            Self::CheckRange => "the device does not accept this value now",
            Self::NotFitted => "this device does not have it now: a part that is not fitted, or another instance is shown",
            Self::ReadExceptions => "its nonvolatile memory failed and nothing has changed: read the exception details",
        })
    }
}

fn advice_text(advice: &Option<Advice>) -> String {
    advice.as_ref().map_or_else(String::new, |advice| format!("; {advice}"))
}

impl ClientError {
    /// The class of the error.
    ///
    /// ```
    /// use profivac_client::{Bus, ErrorKind};
    ///
    /// let mut bus = Bus::on(profivac_virtual::open::devices(&["bcg450@5"])?).open()?;
    /// let mut gauge = bus.gauge(5)?;
    /// let unknown = gauge.read("pirani.proces-value").unwrap_err();
    /// assert_eq!(unknown.kind(), ErrorKind::Usage);
    /// let read_only = gauge.write("pirani.process-value", "1 mbar").unwrap_err();
    /// assert_eq!(read_only.kind(), ErrorKind::Refused);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    #[must_use]
    pub const fn kind(&self) -> ErrorKind {
        match self {
            Self::Session(SessionError::Parameters(_))
            | Self::Target(_)
            | Self::UnknownDevice { .. }
            | Self::SeveralDevices { .. }
            | Self::Value { .. }
            | Self::BeyondRange { .. }
            | Self::Typed { error: TypedError::NotOnModel { .. }, .. } => ErrorKind::Usage,
            Self::Session(_)
            | Self::Closed
            | Self::System(_)
            | Self::NoAnswer(_)
            | Self::Interrupted { .. }
            | Self::WriteLost { .. } => ErrorKind::Line,
            Self::NotReadBack { error, .. } => error.kind(),
            Self::Master(_)
            | Self::Access { .. }
            | Self::Condition { .. }
            | Self::Refused { .. }
            | Self::Unavailable { .. }
            | Self::Malformed { .. }
            | Self::Typed { .. }
            | Self::UnitChanged { .. }
            | Self::NotKept { .. } => ErrorKind::Refused,
        }
    }

    /// The effect of a write, a command or a typed write that ended with this error.
    ///
    /// ```
    /// use profivac_client::Bus;
    /// use profivac_client::records::WriteEffect;
    ///
    /// let mut bus = Bus::on(profivac_virtual::open::devices(&["bcg450@5"])?).open()?;
    /// let mut gauge = bus.gauge(5)?;
    /// let unmet = gauge.command("degas on").unwrap_err();
    /// assert_eq!(unmet.write_effect(), WriteEffect::NotSent);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    #[must_use]
    pub const fn write_effect(&self) -> WriteEffect {
        match self {
            Self::NotReadBack { .. } | Self::NotKept { .. } => WriteEffect::Executed,
            Self::WriteLost { .. } | Self::Closed | Self::Malformed { doing: Operation::Write, .. } => {
                WriteEffect::PossiblyExecuted
            }
            Self::Interrupted { doing: Operation::Write, reason, .. } => reason.write_effect(),
            Self::Refused { doing: Operation::Write, .. } => WriteEffect::Refused,
            // Reading and selecting come before the write; their errors after it are `NotReadBack`.
            Self::Interrupted { doing: Operation::Read | Operation::Select, .. }
            | Self::Refused { doing: Operation::Read | Operation::Select, .. }
            | Self::Malformed { doing: Operation::Read | Operation::Select, .. }
            // The errors of finding the gauge and of checking the value. An error of the session during the write is `WriteLost`.
            | Self::Session(_)
            | Self::System(_)
            | Self::NoAnswer(_)
            | Self::Master(_)
            | Self::UnknownDevice { .. }
            | Self::SeveralDevices { .. }
            | Self::Target(_)
            | Self::Value { .. }
            | Self::BeyondRange { .. }
            | Self::Access { .. }
            | Self::Condition { .. }
            | Self::Unavailable { .. }
            | Self::Typed { .. }
            | Self::UnitChanged { .. } => WriteEffect::NotSent,
        }
    }

    /// The error of a record, with its context.
    pub(super) fn from_record(
        error: RecordError,
        doing: Operation,
        location: ParameterContext,
        named: Option<&NamedParameter>,
    ) -> Self {
        match error {
            RecordError::Session(error) if doing == Operation::Write => Self::WriteLost { location, error },
            RecordError::Session(error) | RecordError::NotSent(error) => Self::Session(error),
            RecordError::Refused(refused) => {
                Self::Refused { advice: advice(&refused, named), location, doing, refused }
            }
            RecordError::Unavailable(reason) => {
                Self::Unavailable { device: location.device, address: location.address, reason }
            }
            RecordError::Interrupted(reason) => Self::Interrupted { location, doing, reason },
            RecordError::Malformed(error) => Self::Malformed { location, doing, error },
        }
    }
}

/// The advice that refusal codes and parameter suggest.
fn advice(refused: &RefusalCodes, named: Option<&NamedParameter>) -> Option<Advice> {
    let codes = named.map(|named| &named.parameter.row.codes);
    let is_presentation =
        named.is_some_and(|named| matches!(named.parameter.row.role, Some(Role::Unit | Role::NumberType)));
    let lock = named.and_then(NamedParameter::lock_name);
    Some(match (refused.code_1, refused.code, lock) {
        (_, RefusalCodes::MODE, Some(lock)) => Advice::OpenSet { lock },
        (_, RefusalCodes::ALREADY, _) => Advice::NothingToDo,
        (_, RefusalCodes::MODE, None) if is_presentation => Advice::StopFirst,
        (_, RefusalCodes::MODE, None) => Advice::CheckMode,
        (_, RefusalCodes::CONFLICT, _) if codes.is_some_and(Codes::is_command) => Advice::CheckStateAndPressure,
        (_, RefusalCodes::RANGE, _) => Advice::CheckRange,
        (Some(ErrorCode::INVALID_INDEX | ErrorCode::INVALID_SLOT), _, _) => Advice::NotFitted,
        (Some(ErrorCode::WRITE_ERROR), _, _) => Advice::ReadExceptions,
        _ => return None,
    })
}

impl fmt::Display for Operation {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Read => "reading",
            Self::Write => "writing",
            Self::Select => "selecting the instance",
        })
    }
}

impl fmt::Display for ParameterContext {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { device, address, name, slot, instance, index } = self;
        write!(f, "{device} at address {address}, {}", name.as_deref().unwrap_or("record"))?;
        write!(f, " (slot {slot}, index {index}")?;
        if *instance > 0 {
            write!(f, ", instance {instance}")?;
        }
        f.write_str(")")
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use profivac_devices::model::{DataType, Length};

    fn location() -> ParameterContext {
        ParameterContext { device: "bcg450", address: 5, name: None, slot: 1, instance: 0, index: 40 }
    }

    #[test]
    fn an_error_of_reading_back_names_the_parameter_once() {
        let lost = ClientError::from_record(Interruption::NoAnswer.into(), Operation::Read, location(), None);
        for (error, reason) in [
            (lost, "reading was cut short: no answer"),
            (ClientError::Session(SessionError::Interrupted), "interrupted by a signal"),
        ] {
            let error = ClientError::NotReadBack { location: location(), error: Box::new(error) };
            let expected =
                "bcg450 at address 5, record (slot 1, index 40): the value was written; reading it back failed: ";
            assert_eq!(error.to_string(), format!("{expected}{reason}"));
        }
    }

    #[test]
    fn the_effect_of_a_write_is_the_same_with_the_context_of_a_parameter_and_without() {
        let length = LengthError { data_type: DataType::Float, expected: Length::Exactly(4), found: 3 };
        let refused = RefusalCodes { code_1: None, code: 2 };
        let errors: [fn(LengthError, RefusalCodes) -> RecordError; 7] = [
            |_, _| RecordError::Session(SessionError::NeverIdle),
            |_, _| RecordError::NotSent(SessionError::NeverIdle),
            |_, refused| RecordError::Refused(refused),
            |_, _| Unavailable::NoConnection.into(),
            |_, _| Interruption::NoAnswer.into(),
            |_, _| RecordError::NotSent(SessionError::Interrupted),
            |length, _| RecordError::Malformed(length),
        ];
        for error in errors {
            let effect = error(length, refused).write_effect();
            let text = error(length, refused).to_string();
            let with_context = ClientError::from_record(error(length, refused), Operation::Write, location(), None);
            assert_eq!(with_context.write_effect(), effect, "{text}");
            // A value is read, or an instance selected, before the write is sent.
            for doing in [Operation::Read, Operation::Select] {
                let before = ClientError::from_record(error(length, refused), doing, location(), None);
                assert_eq!(before.write_effect(), WriteEffect::NotSent, "{doing}: {text}");
            }
        }
    }
}
