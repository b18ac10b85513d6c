//! The failure of a command: a sentence for users and an exit code for scripts.

use crate::advice;
use crate::values::ValueError;
use profivac_client::ErrorKind;
use profivac_client::discover::CyclicError;
use profivac_client::records::RecordError;
use profivac_config::ConfigError;
use profivac_host::port::PortError;
use profivac_host::session::SessionError;
use profivac_station::station::StationError;
use profivac_virtual::device_spec::SpecError;
use profivac_virtual::gsd_slave::GsdSpecError;
use profivac_virtual::scenario::{MemorySegmentError, ScenarioError};
use profivac_web_server::auth::file_permissions::PermissionError;
use profivac_web_server::auth::users::{AccountError, UsersError};
use profivac_web_server::server::ServerError;
use std::fmt;
use std::process::ExitCode;

/// The reason why a command failed.
#[derive(Debug)]
pub struct Failure {
    kind: Kind,
    sentence: String,
}

/// The exit codes that the help lists.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Kind {
    Refused,
    Usage,
    Port,
    /// A signal ended the command.
    Interrupted,
}

impl Kind {
    const fn exit_code(self) -> u8 {
        match self {
            Self::Refused => 1,
            Self::Usage => 2,
            Self::Port | Self::Interrupted => 3,
        }
    }
}

impl Failure {
    /// The device refused, or another master owns it: exit code 1.
    pub fn refused(sentence: impl Into<String>) -> Self {
        Self { kind: Kind::Refused, sentence: sentence.into() }
    }

    /// `diff` has found differences and printed them: exit code 1, without a message.
    pub const fn quiet_differences() -> Self {
        Self { kind: Kind::Refused, sentence: String::new() }
    }

    /// The reader of standard output has closed it: exit code 3, without a message.
    pub const fn quiet() -> Self {
        Self { kind: Kind::Port, sentence: String::new() }
    }

    /// The command line is wrong, and the parser has already printed why: exit code 2.
    pub const fn quiet_usage() -> Self {
        Self { kind: Kind::Usage, sentence: String::new() }
    }

    /// Whether no message is left to print.
    pub const fn is_quiet(&self) -> bool {
        self.sentence.is_empty()
    }

    /// Whether the port failed, or no station answers.
    pub fn is_port(&self) -> bool {
        matches!(self.kind, Kind::Port | Kind::Interrupted)
    }

    /// A signal ended the command: exit code 3.
    pub fn interrupted() -> Self {
        Self { kind: Kind::Interrupted, sentence: SessionError::Interrupted.to_string() }
    }

    /// The same with its effect, in a few words.
    pub fn interrupted_with(effect: &str) -> Self {
        Self { kind: Kind::Interrupted, sentence: format!("{}; {effect}", SessionError::Interrupted) }
    }

    /// Whether a signal ended the command.
    pub fn is_interrupted(&self) -> bool {
        self.kind == Kind::Interrupted
    }

    /// The same exit code with another sentence.
    pub fn with_sentence(&self, sentence: &str) -> Self {
        Self { kind: self.kind, sentence: sentence.to_owned() }
    }

    /// The command line or a file is wrong: exit code 2.
    pub fn usage(sentence: impl Into<String>) -> Self {
        Self { kind: Kind::Usage, sentence: sentence.into() }
    }

    /// No station answers, the port failed, or another master uses the line: exit code 3.
    pub fn no_answer(sentence: impl Into<String>) -> Self {
        Self { kind: Kind::Port, sentence: sentence.into() }
    }
}

impl Failure {
    /// The failure of a record of the slave that `place` names.
    pub fn of_record(place: &str, error: RecordError) -> Self {
        match error {
            RecordError::Session(error) | RecordError::NotSent(error) => error.into(),
            error => Self { kind: error.kind().into(), sentence: format!("{place}: {error}") },
        }
    }
}

impl From<SessionError> for Failure {
    fn from(error: SessionError) -> Self {
        match error {
            SessionError::Port(error) => error.into(),
            SessionError::Parameters(error) => Self::usage(error.to_string()),
            SessionError::Interrupted => Self::interrupted(),
            _ => Self::no_answer(error.to_string()),
        }
    }
}

impl From<CyclicError> for Failure {
    fn from(error: CyclicError) -> Self {
        match error {
            CyclicError::Session(error) => error.into(),
            CyclicError::Client(error) => error.into(),
            _ => Self { kind: error.kind().into(), sentence: error.to_string() },
        }
    }
}

impl From<ErrorKind> for Kind {
    fn from(kind: ErrorKind) -> Self {
        match kind {
            ErrorKind::Refused => Self::Refused,
            ErrorKind::Usage => Self::Usage,
            ErrorKind::Line => Self::Port,
        }
    }
}

impl From<PortError> for Failure {
    fn from(error: PortError) -> Self {
        let kind = match error {
            PortError::InvalidAddress(_)
            | PortError::UnknownScheme(_)
            | PortError::NoBaudRate(_)
            | PortError::File(_)
            | PortError::NotCreatable { .. } => Kind::Usage,
            PortError::Interrupted(_) => Kind::Interrupted,
            _ => Kind::Port,
        };
        Self { kind, sentence: format!("{error}{}", advice::after_port(&error)) }
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

impl From<GsdSpecError> for Failure {
    fn from(error: GsdSpecError) -> Self {
        Self::usage(error.to_string())
    }
}

impl From<ConfigError> for Failure {
    fn from(error: ConfigError) -> Self {
        Self::usage(error.to_string())
    }
}

impl From<ValueError> for Failure {
    fn from(error: ValueError) -> Self {
        Self::usage(error.to_string())
    }
}

impl From<StationError> for Failure {
    fn from(error: StationError) -> Self {
        let kind = match error {
            StationError::Database(_) => Kind::Usage,
            _ => Kind::Port,
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
    /// Errors of the operating system other than those of a port: signals, the terminal.
    fn from(error: std::io::Error) -> Self {
        Self { kind: Kind::Port, sentence: error.to_string() }
    }
}

impl From<Failure> for ExitCode {
    fn from(failure: Failure) -> Self {
        Self::from(failure.kind.exit_code())
    }
}

impl fmt::Display for Failure {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.sentence)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use profivac_client::records::{Interruption, RecordError, Unavailable};

    #[test]
    fn a_unit_that_a_lost_answer_hides_is_no_refusal_of_the_device() {
        let unreadable = |error: RecordError| Failure::from(CyclicError::UnreadableUnit { address: 5, error });
        assert_eq!(unreadable(Interruption::NoAnswer.into()).kind, Kind::Port);
        assert_eq!(unreadable(SessionError::NeverIdle.into()).kind, Kind::Port);
        assert_eq!(unreadable(Interruption::UnknownUnit.into()).kind, Kind::Refused);
        assert_eq!(unreadable(Unavailable::NoMs1.into()).kind, Kind::Refused);
        assert_eq!(Failure::from(CyclicError::NoAnswer(9)).kind, Kind::Port);
    }
}
