//! An operation: a command or a parameter write, resolved for a device, with the answer of the gauge before and after it.

use super::permissions;
use crate::view::Risk;
use profivac_client::Condition;
use profivac_client::names::{NamedParameter, ParameterNames, Target, TargetError, command_name, slug};
use profivac_client::values::{BeyondRange, hex};
use profivac_devices::catalog::is_built_in;
use profivac_devices::model::{Code, Model};
use profivac_web_server::auth::Role;
use serde::Deserialize;
use std::fmt;
use utoipa::ToSchema;

/// A value in a request.
#[derive(Clone, Debug, PartialEq, Deserialize, ToSchema)]
#[serde(untagged)]
pub enum GivenValue {
    /// A text: `1e-3 mbar`, `use-safe-value`.
    Text(String),
    /// A number without a unit: a pressure is a text with its unit.
    Number(f64),
    /// Yes or no.
    Flag(bool),
}

impl fmt::Display for GivenValue {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Text(text) => f.write_str(text),
            Self::Number(number) => write!(f, "{number}"),
            Self::Flag(flag) => write!(f, "{flag}"),
        }
    }
}

/// A request to arm a command, or a parameter with its value.
#[derive(Clone, Debug, Default, PartialEq, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub struct OperationRequest {
    /// The command: `degas-on`, `ba.degas-on`.
    pub command: Option<String>,
    /// The parameter: `trip-point.1/high-trip-point`, `2/61`.
    pub target: Option<String>,
    /// The value of the parameter. A pressure has its unit: `1e-3 mbar`.
    pub value: Option<GivenValue>,
    /// Writes a pressure outside the measuring range of the gauge; the audit trail says so.
    #[serde(default)]
    pub force: bool,
}

/// The reason why a request names no operation of a device.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum ResolveError {
    /// Neither a command, nor a target with a value.
    #[error("expected either a command, or a target and its value")]
    Incomplete,
    /// The device has no parameters at all.
    #[error("{0} has no parameters")]
    NoParameters(&'static str),
    /// The device has no such command.
    #[error("{device} has no command {command:?}")]
    UnknownCommand {
        /// The device.
        device: &'static str,
        /// The command.
        command: String,
    },
    /// The device has no such parameter.
    #[error("{device} has no parameter {target:?}")]
    UnknownParameter {
        /// The device.
        device: &'static str,
        /// The parameter.
        target: String,
    },
    /// The numbers do not say which instance.
    #[error("expected the instance too, {slot}:INSTANCE/{index}, got {target:?}")]
    NoInstance {
        /// The slot.
        slot: u8,
        /// The index.
        index: u8,
        /// The parameter as it was given.
        target: String,
    },
    /// The parameter has no such command.
    #[error("{parameter}: expected one of {commands}, got {value:?}")]
    UnknownCode {
        /// The parameter.
        parameter: String,
        /// The names of its commands.
        commands: String,
        /// The value as it was given.
        value: String,
    },
    /// The name is unknown, or means several parameters.
    #[error(transparent)]
    Target(#[from] TargetError),
}

/// A command or a parameter write, resolved for a device. The gauge has not been asked.
#[derive(Clone, Debug)]
pub struct Operation {
    /// The parameter, or the parameter by which the command is sent.
    pub named: NamedParameter,
    /// The value as it was given, or the name of the command.
    pub text: String,
    /// The command.
    pub command: Option<&'static Code>,
    /// A pressure outside the measuring range is intended.
    pub force: bool,
    /// The tables are those of a device file: its conditions and risks are as good as the file.
    pub from_device_file: bool,
}

/// The answer of the gauge before anything is sent.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct OperationPreview {
    /// The device: another device may have the name of the gauge later.
    pub device: &'static str,
    /// Its address on the bus.
    pub address: u8,
    /// The octets that are to be sent.
    pub octets: Vec<u8>,
    /// The present value as text with its unit and as octets; `None` if it cannot be read.
    pub before: Option<(String, Vec<u8>)>,
    /// The new value as text with its unit.
    pub after: String,
    /// The new value is outside the measuring range, and the request forces it.
    pub forced: Option<BeyondRange>,
    /// The risk.
    pub risk: Risk,
    /// All conditions of the operation.
    pub conditions: Vec<Condition>,
}

impl OperationPreview {
    /// The octets that are to be sent, as hexadecimal digits.
    #[must_use]
    pub fn octets_as_hex(&self) -> String {
        hex(&self.octets)
    }
}

/// The values before and after an operation.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Readback {
    /// The value before.
    pub before: Option<String>,
    /// The value that was read back; `None` if it cannot be read.
    pub after: Option<String>,
}

impl Operation {
    /// Resolves a request for a device.
    ///
    /// # Errors
    /// [`ResolveError`] says what was expected and what was given.
    pub fn resolve(model: &'static Model, request: &OperationRequest) -> Result<Self, ResolveError> {
        let names = ParameterNames::shared(model);
        match (&request.command, &request.target, &request.value) {
            (Some(command), None, None) => Self::command(model, names, command),
            (None, Some(target), Some(value)) => {
                let operation = Self::parameter(model, names, target, &value.to_string())?;
                Ok(Self { force: request.force, ..operation })
            }
            _ => Err(ResolveError::Incomplete),
        }
    }

    fn new(model: &Model, named: NamedParameter, text: &str, command: Option<&'static Code>) -> Self {
        Self { named, text: text.to_owned(), command, force: false, from_device_file: !is_built_in(model) }
    }

    fn command(model: &'static Model, names: &ParameterNames, text: &str) -> Result<Self, ResolveError> {
        let unknown = || ResolveError::UnknownCommand { device: model.name, command: text.to_owned() };
        let (named, code) = names.command(text)?.ok_or_else(unknown)?;
        Ok(Self::new(model, named.clone(), code.name, Some(code)))
    }

    fn parameter(
        model: &'static Model,
        names: &ParameterNames,
        target: &str,
        value: &str,
    ) -> Result<Self, ResolveError> {
        let named = match names.find_whole(model.name, target)? {
            Target::Parameter(named) => named.clone(),
            Target::CurrentInstance { slot, index } => {
                return Err(ResolveError::NoInstance { slot, index, target: target.to_owned() });
            }
            Target::Raw { .. } => {
                return Err(ResolveError::UnknownParameter { device: model.name, target: target.to_owned() });
            }
        };
        let codes = &named.parameter.row.codes;
        if !codes.is_command() {
            return Ok(Self::new(model, named, value, None));
        }
        let code = codes.codes().iter().find(|code| slug(code.name) == slug(value));
        let code = code.ok_or_else(|| ResolveError::UnknownCode {
            parameter: named.name.clone(),
            commands: codes.codes().iter().map(|code| code.name).collect::<Vec<_>>().join(", "),
            value: value.to_owned(),
        })?;
        Ok(Self::new(model, named, code.name, Some(code)))
    }

    /// The name by which the operation can be requested again: `ba.degas-on`, `trip-point.1/high-trip-point`.
    #[must_use]
    pub fn target(&self) -> String {
        self.command.map_or_else(|| self.named.name.clone(), |code| command_name(&self.named, code))
    }

    /// The manual's name and numbers: `High Trip Point (2/61)`.
    #[must_use]
    pub fn manual_name(&self) -> String {
        format!("{} ({})", self.named.parameter.row.name, self.named.parameter.numbers())
    }

    /// The role it needs.
    #[must_use]
    pub fn role(&self) -> Role {
        permissions::role(self.named.parameter.row, self.command)
    }

    /// The reason why the station never does it.
    #[must_use]
    pub fn blocked_reason(&self) -> Option<&'static str> {
        permissions::blocked_reason(self.named.parameter.row)
    }
}
