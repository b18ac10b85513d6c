//! How a command fails: a sentence for people and an exit code for scripts.

use profivac_client::cyclic::CyclicError;
use profivac_host::port::PortError;
use profivac_host::session::SessionError;
use profivac_station::auth::file_permissions::PermissionError;
use profivac_station::auth::users::{AccountError, UsersError};
use profivac_station::config::ConfigError;
use profivac_station::server::ServerError;
use profivac_station::station::StationError;
use profivac_virtual::device_spec::SpecError;
use profivac_virtual::scenario::{MemorySegmentError, ScenarioError};
use std::fmt;
use std::process::ExitCode;

/// Why a command ended early.
#[derive(Debug)]
pub struct Failure {
    kind: Kind,
    sentence: String,
}

/// The exit codes, as the help lists them.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Kind {
    Refused = 1,
    Usage = 2,
    Port = 3,
}

impl Failure {
    /// The device refused, or belongs to somebody else.
    pub fn refused(sentence: impl Into<String>) -> Self {
        Self { kind: Kind::Refused, sentence: sentence.into() }
    }

    /// Nobody reads the output any more: there is nobody to tell it to.
    pub const fn quiet() -> Self {
        Self { kind: Kind::Port, sentence: String::new() }
    }

    /// The command line asks for what cannot be, and that was said.
    pub const fn quiet_usage() -> Self {
        Self { kind: Kind::Usage, sentence: String::new() }
    }

    /// Whether there is nothing left to say.
    pub const fn is_quiet(&self) -> bool {
        self.sentence.is_empty()
    }

    /// The same kind, in other words.
    pub fn with_sentence(&self, sentence: &str) -> Self {
        Self { kind: self.kind, sentence: sentence.to_owned() }
    }

    /// The command line asks for what cannot be.
    pub fn usage(sentence: impl Into<String>) -> Self {
        Self { kind: Kind::Usage, sentence: sentence.into() }
    }

    /// Nobody answers, or another master has the line.
    pub fn no_answer(sentence: impl Into<String>) -> Self {
        Self { kind: Kind::Port, sentence: sentence.into() }
    }
}

impl From<SessionError> for Failure {
    fn from(error: SessionError) -> Self {
        match error {
            SessionError::Port(error) => error.into(),
            SessionError::Parameters(error) => Self::usage(error.to_string()),
            SessionError::LineInUse(_) | SessionError::AddressInUse(_) | SessionError::NeverIdle => {
                Self::no_answer(error.to_string())
            }
        }
    }
}

impl From<CyclicError> for Failure {
    fn from(error: CyclicError) -> Self {
        match error {
            CyclicError::Session(error) => error.into(),
            CyclicError::NoAnswer(_) => Self::no_answer(error.to_string()),
            CyclicError::OwnedByOther { .. }
            | CyclicError::UnknownDevice { .. }
            | CyclicError::UnreadableUnit { .. }
            | CyclicError::NoUnit(_) => Self::refused(error.to_string()),
        }
    }
}

impl From<PortError> for Failure {
    fn from(error: PortError) -> Self {
        let kind = match error {
            PortError::InvalidAddress(_) | PortError::NoBaudRate(_) | PortError::File(_) => Kind::Usage,
            PortError::NotFound(_)
            | PortError::InUse(_)
            | PortError::PermissionDenied(_)
            | PortError::NotSerial(_)
            | PortError::UnsupportedRate { .. }
            | PortError::UnsupportedCharacter { .. }
            | PortError::NoTelegram { .. }
            | PortError::UnresolvedHost { .. }
            | PortError::Unreachable { .. }
            | PortError::AlreadyExists(_)
            | PortError::Lost(_)
            | PortError::System { .. } => Kind::Port,
        };
        Self { kind, sentence: error.to_string() }
    }
}

impl From<AccountError> for Failure {
    fn from(error: AccountError) -> Self {
        Self::usage(error.to_string())
    }
}

impl From<SpecError> for Failure {
    fn from(error: SpecError) -> Self {
        Self { kind: Kind::Usage, sentence: error.to_string() }
    }
}

impl From<ConfigError> for Failure {
    fn from(error: ConfigError) -> Self {
        Self::usage(error.to_string())
    }
}

impl From<StationError> for Failure {
    fn from(error: StationError) -> Self {
        let kind = match error {
            StationError::Store(_) => Kind::Usage,
            StationError::Thread(_) => Kind::Port,
        };
        Self { kind, sentence: error.to_string() }
    }
}

impl From<ScenarioError> for Failure {
    fn from(error: ScenarioError) -> Self {
        Self { kind: Kind::Usage, sentence: error.to_string() }
    }
}

impl From<ServerError> for Failure {
    fn from(error: ServerError) -> Self {
        let kind = match error {
            ServerError::Listen { .. } => Kind::Port,
            _ => Kind::Usage,
        };
        Self { kind, sentence: error.to_string() }
    }
}

impl From<UsersError> for Failure {
    fn from(error: UsersError) -> Self {
        Self::usage(error.to_string())
    }
}

impl From<PermissionError> for Failure {
    fn from(error: PermissionError) -> Self {
        Self::usage(error.to_string())
    }
}

impl From<MemorySegmentError> for Failure {
    fn from(error: MemorySegmentError) -> Self {
        Self { kind: Kind::Usage, sentence: error.to_string() }
    }
}

impl From<std::io::Error> for Failure {
    /// What the system refuses beside a port: signals, the terminal.
    fn from(error: std::io::Error) -> Self {
        Self { kind: Kind::Port, sentence: error.to_string() }
    }
}

impl From<Failure> for ExitCode {
    fn from(failure: Failure) -> Self {
        Self::from(failure.kind as u8)
    }
}

impl fmt::Display for Failure {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.sentence)
    }
}
