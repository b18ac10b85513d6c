//! What went wrong with a gauge, in one sentence that names address, parameter, slot and index, what was refused and why,
//! and what to do.

use super::names::{NamedParameter, TargetError};
use super::records::{RecordError, RefusalCodes};
use super::values::ValueError;
use profivac_devices::model::Codes;
use profivac_host::session::SessionError;
use profivac_wire::acyclic::ErrorCode;
use std::fmt;

/// What was done when it went wrong.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Operation {
    /// A parameter was read.
    Read,
    /// A parameter was written, or a command sent.
    Write,
}

/// Which parameter of which device.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Location {
    /// The device.
    pub device: &'static str,
    /// The address of the slave.
    pub address: u8,
    /// The name of the parameter, if it has one.
    pub name: Option<String>,
    /// The slot.
    pub slot: u8,
    /// The instance that must be shown, 0 where the slot has only one.
    pub instance: u8,
    /// The index.
    pub index: u8,
}

/// Why something was not done.
#[derive(Debug, thiserror::Error)]
pub enum ClientError {
    /// The line.
    #[error(transparent)]
    Session(#[from] SessionError),
    /// Nobody is there.
    #[error("nobody answers at address {0}; `profivac scan` shows who is there")]
    NoAnswer(u8),
    /// Somebody is there who has no parameters.
    #[error("the station at address {0} is a master, not a gauge")]
    Master(u8),
    /// No device with this ident number is known.
    #[error(
        "the slave at address {address} has the ident number 0x{ident:04X}, which no known device has: its parameters have no names here"
    )]
    UnknownDevice {
        /// Its address.
        address: u8,
        /// Ident_Number.
        ident: u16,
    },
    /// No such parameter.
    #[error(transparent)]
    Target(#[from] TargetError),
    /// No such value.
    #[error("{place}: {error}")]
    Value {
        /// Where.
        place: Location,
        /// What the parameter takes.
        error: ValueError,
    },
    /// The table does not allow it.
    #[error("{place}: {reason}")]
    Access {
        /// Where.
        place: Location,
        /// Why, and what to do.
        reason: String,
    },
    /// A command whose conditions are not met. It was not sent.
    #[error("{place}: {command} was not sent: {reason}")]
    Condition {
        /// Where.
        place: Location,
        /// The command.
        command: &'static str,
        /// What is missing, and what to do.
        reason: String,
    },
    /// The slave refused.
    #[error("{place}: {doing} was refused with {refused}{advice}")]
    Refused {
        /// Where.
        place: Location,
        /// What was done.
        doing: Operation,
        /// Its codes.
        refused: RefusalCodes,
        /// What to do.
        advice: String,
    },
    /// The way to the records is not there.
    #[error("{device} at address {address}: {reason}")]
    Unavailable {
        /// The device.
        device: &'static str,
        /// The address of the slave.
        address: u8,
        /// Why, and which way there is.
        reason: String,
    },
    /// Nothing came, or nothing that can be used.
    #[error("{place}: {doing} was cut short: {reason}")]
    Interrupted {
        /// Where.
        place: Location,
        /// What was done.
        doing: Operation,
        /// What happened.
        reason: String,
    },
    /// A value is not what it was written to be.
    #[error("{place}: {written} was written, but it reads {found}")]
    NotKept {
        /// Where.
        place: Location,
        /// What was written.
        written: String,
        /// What is there.
        found: String,
    },
}

/// How bad an error is, for whoever makes an exit code of it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ErrorKind {
    /// The device refused, or would have.
    Refused,
    /// What was asked for cannot be.
    Usage,
    /// Nobody answers.
    Line,
}

impl ClientError {
    /// How bad it is.
    #[must_use]
    pub const fn kind(&self) -> ErrorKind {
        match self {
            Self::Session(SessionError::Parameters(_)) | Self::Target(_) | Self::UnknownDevice { .. } => {
                ErrorKind::Usage
            }
            Self::Value { error, .. } if !error.out_of_range => ErrorKind::Usage,
            Self::Session(_) | Self::NoAnswer(_) | Self::Interrupted { .. } => ErrorKind::Line,
            Self::Value { .. }
            | Self::Master(_)
            | Self::Access { .. }
            | Self::Condition { .. }
            | Self::Refused { .. }
            | Self::Unavailable { .. }
            | Self::NotKept { .. } => ErrorKind::Refused,
        }
    }

    /// What became of a record, at its place.
    pub(super) fn from_record(
        error: RecordError,
        doing: Operation,
        place: Location,
        named: Option<&NamedParameter>,
    ) -> Self {
        match error {
            RecordError::Session(error) => Self::Session(error),
            RecordError::Refused(refused) => Self::Refused { advice: advice(&refused, named), place, doing, refused },
            RecordError::Unavailable(reason) => {
                Self::Unavailable { device: place.device, address: place.address, reason }
            }
            RecordError::Interrupted(reason) => Self::Interrupted { place, doing, reason: advised(reason, doing) },
        }
    }
}

/// What is lost on the way may have arrived.
fn advised(reason: String, doing: Operation) -> String {
    match doing {
        Operation::Read => reason,
        Operation::Write => format!("{reason}; it may have been written, read it"),
    }
}

/// What to do about a refusal.
fn advice(refused: &RefusalCodes, named: Option<&NamedParameter>) -> String {
    let codes = named.map(|named| &named.parameter.row.codes);
    let is_presentation = named.is_some_and(|named| named.parameter.row.name.starts_with("Data "));
    let lock = named.filter(|named| super::settings::has_lock(named));
    if let (Some(named), RefusalCodes::MODE) = (lock, refused.code) {
        let place = named.name.rsplit_once(['.', '/']).map_or("", |(place, _)| place);
        let separator = if place.contains('.') { '/' } else { '.' };
        return format!(
            "; open the set first: write {place}{separator}threshold-validation open-for-changes, and valid afterwards"
        );
    }
    let text = match (refused.code_1, refused.code) {
        (_, RefusalCodes::ALREADY) => "nothing needs to be done",
        (_, RefusalCodes::MODE) if is_presentation => {
            "unit and number type change only in IDLE and without cyclic exchange: write stop first, or let the owning master go"
        }
        (_, RefusalCodes::MODE) => "read device.device-state, and the parameter that says who sets this one",
        (_, RefusalCodes::CONFLICT) if codes.is_some_and(Codes::is_command) => {
            "the state or the pressure does not allow it: read device.device-state and the process value"
        }
        (_, RefusalCodes::RANGE) => "`profivac list` shows what it takes",
        (Some(ErrorCode::INVALID_INDEX | ErrorCode::INVALID_SLOT), _) => {
            "this device does not have it now: a part that is not fitted, or another instance is shown"
        }
        (Some(ErrorCode::WRITE_ERROR), _) => {
            "its memory took nothing, and nothing has changed: read the exception details"
        }
        _ => return String::new(),
    };
    format!("; {text}")
}

impl fmt::Display for Operation {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Read => "reading",
            Self::Write => "writing",
        })
    }
}

impl fmt::Display for Location {
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
