//! What somebody wants to do to a gauge, what the gauge says to it, and what came of it.

use super::permissions::{self, Risk};
use crate::auth::Role;
use profivac_client::Condition;
use profivac_client::names::{NamedParameter, ParameterNames, Target, command_name, slug};
use profivac_client::values::hex;
use profivac_devices::model::{Code, Model};
use serde::Deserialize;
use std::fmt;
use utoipa::ToSchema;

/// A value as people and programs give it.
#[derive(Clone, Debug, PartialEq, Deserialize, ToSchema)]
#[serde(untagged)]
pub enum GivenValue {
    /// `1e-3 mbar`, `use-safe-value`
    Text(String),
    /// In the unit the gauge has.
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

/// What is to be armed: a command, or a parameter and its value.
#[derive(Clone, Debug, Default, PartialEq, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub struct OperationRequest {
    /// The command: `degas-on`, `ba.degas-on`.
    pub command: Option<String>,
    /// The parameter: `trip-point.1/high-trip-point`, `2/61`.
    pub target: Option<String>,
    /// Its value.
    pub value: Option<GivenValue>,
}

/// What a wish means for a device. No gauge was asked.
#[derive(Clone, Debug)]
pub struct Operation {
    /// The parameter, or the parameter by which the command is sent.
    pub named: NamedParameter,
    /// Its value as it was given, or the name of the command.
    pub text: String,
    /// The command.
    pub command: Option<&'static Code>,
}

/// What the gauge says to it before anything is sent.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct OperationPreview {
    /// Which device it is, and where: another one may have the name of the gauge later.
    pub device: &'static str,
    /// Its address on the bus.
    pub address: u8,
    /// The octets that are sent.
    pub octets: Vec<u8>,
    /// What it is now, in words with its unit, and the octets of it; nothing if it cannot be read.
    pub before: Option<(String, Vec<u8>)>,
    /// What it is to be, in words with its unit.
    pub after: String,
    /// What it risks.
    pub risk: Risk,
    /// All conditions.
    pub conditions: Vec<Condition>,
}

impl OperationPreview {
    /// The octets that are sent, as hexadecimal digits.
    #[must_use]
    pub fn octets_as_hex(&self) -> String {
        hex(&self.octets)
    }
}

/// What came of it.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Readback {
    /// What it was.
    pub before: Option<String>,
    /// What it is now; nothing if it cannot be read.
    pub after: Option<String>,
}

/// Why it was not done.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum OperationError {
    /// The parameter does not take this. Nothing was sent.
    #[error("{0}")]
    InvalidValue(String),
    /// Conditions that do not hold, among all. Nothing was sent.
    #[error("{}", unmet(.0))]
    ConditionsNotMet(Vec<Condition>),
    /// It is not as it was when it was armed. Nothing was sent.
    #[error("{0}")]
    Changed(String),
    /// It cannot be asked. Nothing was sent.
    #[error("{0}")]
    Unavailable(String),
    /// The gauge refused it.
    #[error("{0}")]
    Refused(String),
    /// It was sent, and nobody knows what came of it.
    #[error("{0}")]
    OutcomeUnknown(String),
}

impl OperationError {
    /// For the audit trail.
    #[must_use]
    pub fn outcome(&self) -> String {
        match self {
            Self::InvalidValue(_) | Self::ConditionsNotMet(_) | Self::Changed(_) | Self::Unavailable(_) => {
                format!("not sent: {self}")
            }
            Self::Refused(_) => format!("refused: {self}"),
            Self::OutcomeUnknown(_) => format!("not known: {self}"),
        }
    }
}

fn unmet(conditions: &[Condition]) -> String {
    conditions.iter().filter_map(|condition| condition.unmet.as_deref()).collect::<Vec<_>>().join("; ")
}

impl Operation {
    /// What a wish means for a device.
    ///
    /// # Errors
    /// In a sentence: what was expected and what came.
    pub fn of(model: &'static Model, wish: &OperationRequest) -> Result<Self, String> {
        let names = ParameterNames::of_catalog(model).ok_or_else(|| format!("{} has no parameters", model.name))?;
        match (&wish.command, &wish.target, &wish.value) {
            (Some(command), None, None) => Self::command(model, names, command),
            (None, Some(target), Some(value)) => Self::parameter(model, names, target, &value.to_string()),
            _ => Err("expected either a command, or a target and its value".to_owned()),
        }
    }

    fn command(model: &'static Model, names: &ParameterNames, text: &str) -> Result<Self, String> {
        let found = names.command(text).map_err(|error| error.to_string())?;
        let (named, code) = found.ok_or_else(|| format!("{} has no command {text:?}", model.name))?;
        Ok(Self { named: named.clone(), text: code.name.to_owned(), command: Some(code) })
    }

    fn parameter(model: &'static Model, names: &ParameterNames, target: &str, value: &str) -> Result<Self, String> {
        let named = match names.find(model.name, target).map_err(|error| error.to_string())? {
            Target::Parameter(named) => named.clone(),
            Target::CurrentInstance { slot, index } => {
                return Err(format!("expected the instance too, {slot}:INSTANCE/{index}, got {target:?}"));
            }
            Target::Raw { .. } => return Err(format!("{} has no parameter {target:?}", model.name)),
        };
        let codes = &named.parameter.row.codes;
        if !codes.is_command() {
            return Ok(Self { named, text: value.to_owned(), command: None });
        }
        let code = codes.codes().iter().find(|code| slug(code.name) == slug(value)).ok_or_else(|| {
            let commands = codes.codes().iter().map(|code| code.name).collect::<Vec<_>>().join(", ");
            format!("{}: expected one of {commands}, got {value:?}", named.name)
        })?;
        Ok(Self { named, text: code.name.to_owned(), command: Some(code) })
    }

    /// By what it is armed again: `ba.degas-on`, `trip-point.1/high-trip-point`.
    #[must_use]
    pub fn target(&self) -> String {
        self.command.map_or_else(|| self.named.name.clone(), |code| command_name(&self.named, code))
    }

    /// The manual's name and numbers: `High Trip Point (2/61)`.
    #[must_use]
    pub fn manual_name(&self) -> String {
        format!("{} ({})", self.named.parameter.row.name, self.named.parameter.numbers())
    }

    /// Who may do it.
    #[must_use]
    pub fn role(&self) -> Role {
        permissions::role(self.named.parameter.row, self.command)
    }

    /// Why nobody may do it from here.
    #[must_use]
    pub fn blocked_reason(&self) -> Option<&'static str> {
        permissions::blocked_reason(self.named.parameter.row)
    }
}
