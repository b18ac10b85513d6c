//! The commands that are armed: each waits until its user executes or disarms it, or until it expires.
//!
//! A state machine without a clock: the caller passes the time.

use super::operation::{Operation, OperationPreview};
use crate::snapshot::Connection;
use profivac_web_server::auth::User;
use std::collections::VecDeque;
use std::fmt;
use std::sync::Arc;
use std::time::{Duration, Instant};

/// How long a command stays armed. chosen: long enough to read the preview, too short to forget the command.
pub const ARMED_FOR: Duration = Duration::from_secs(30);

/// The most commands that are armed at once. One user has control, and executes one command at a time.
const MAX_ARMED: usize = 16;

/// The number of ended commands whose outcome is kept.
const REMEMBERED: usize = 64;

/// An armed command.
#[derive(Clone, Debug)]
pub struct ArmedCommand {
    /// Its id.
    pub id: String,
    /// The user who armed it.
    pub user: Arc<str>,
    /// The name of the gauge.
    pub gauge: String,
    /// Where the gauge was connected when the command was armed.
    pub connection: Connection,
    /// The command or the parameter write.
    pub operation: Operation,
    /// The answer of the gauge when the command was armed.
    pub preview: OperationPreview,
    /// When it expires.
    pub expires_at: Instant,
}

/// How a command ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Ended {
    /// It was not executed in time.
    Expired,
    /// It was executed.
    Executed,
    /// Its user disarmed it.
    Disarmed,
    /// Another user got control.
    ControlChanged,
}

impl fmt::Display for Ended {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Expired => "has expired",
            Self::Executed => "was already executed",
            Self::Disarmed => "was disarmed",
            Self::ControlChanged => "was disarmed when its user lost control",
        })
    }
}

/// The reason why a command is not armed.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum ArmedCommandError {
    /// No command has this id, or it ended long ago.
    #[error("there is no armed command {0:?}")]
    Unknown(String),
    /// Another user armed it.
    #[error("{0} armed this command: only {0} may execute it")]
    OtherUser(String),
    /// It has ended.
    #[error("the command {0}: arm it again")]
    Ended(Ended),
    /// Too many commands are armed.
    #[error("{MAX_ARMED} commands are armed already: execute or disarm them first")]
    TooMany,
}

/// All armed commands.
#[derive(Debug, Default)]
pub struct ArmedCommands {
    armed: Vec<ArmedCommand>,
    ended: VecDeque<(String, Ended)>,
}

impl ArmedCommands {
    /// Ends the commands that have expired at `now`.
    pub fn expire(&mut self, now: Instant) {
        self.end(Ended::Expired, |command| command.expires_at <= now);
    }

    /// Ends all commands, because their user has lost control.
    pub fn clear(&mut self) {
        self.end(Ended::ControlChanged, |_| true);
    }

    /// Arms a command.
    ///
    /// # Errors
    /// [`ArmedCommandError::TooMany`].
    pub fn arm(&mut self, command: ArmedCommand) -> Result<(), ArmedCommandError> {
        if self.armed.len() >= MAX_ARMED {
            return Err(ArmedCommandError::TooMany);
        }
        self.armed.push(command);
        Ok(())
    }

    /// An armed command of this user.
    ///
    /// # Errors
    /// [`ArmedCommandError`] when the command has ended or belongs to another user.
    pub fn get(&self, id: &str, user: &User) -> Result<&ArmedCommand, ArmedCommandError> {
        let Some(command) = self.armed.iter().find(|command| command.id == id) else {
            let ended = self.ended.iter().find(|(ended, _)| ended == id);
            return Err(match ended {
                Some((_, how)) => ArmedCommandError::Ended(*how),
                None => ArmedCommandError::Unknown(id.to_owned()),
            });
        };
        if command.user == user.name {
            Ok(command)
        } else {
            Err(ArmedCommandError::OtherUser(command.user.to_string()))
        }
    }

    /// Takes a command to execute it: it ends, whatever its outcome.
    ///
    /// # Errors
    /// As [`get`](Self::get).
    pub fn take_to_execute(&mut self, id: &str, user: &User) -> Result<ArmedCommand, ArmedCommandError> {
        self.take(id, user, Ended::Executed)
    }

    /// Disarms a command.
    ///
    /// # Errors
    /// As [`get`](Self::get).
    pub fn disarm(&mut self, id: &str, user: &User) -> Result<ArmedCommand, ArmedCommandError> {
        self.take(id, user, Ended::Disarmed)
    }

    fn take(&mut self, id: &str, user: &User, how: Ended) -> Result<ArmedCommand, ArmedCommandError> {
        let command = self.get(id, user)?.clone();
        self.end(how, |armed| armed.id == command.id);
        Ok(command)
    }

    fn end(&mut self, how: Ended, is_over: impl Fn(&ArmedCommand) -> bool) {
        for command in self.armed.extract_if(.., |command| is_over(command)) {
            self.ended.push_front((command.id, how));
        }
        self.ended.truncate(REMEMBERED);
    }
}

#[cfg(test)]
mod tests {
    use super::super::operation::OperationRequest;
    use super::super::permissions;
    use super::*;
    use profivac_devices::bcg450::table::MODEL;
    use profivac_web_server::auth::Role;

    fn user(name: &str) -> User {
        User { name: Arc::from(name), role: Role::Operator }
    }

    fn command(id: &str, expires_at: Instant) -> ArmedCommand {
        let request = OperationRequest { command: Some("stop".to_owned()), ..OperationRequest::default() };
        let operation = Operation::resolve(&MODEL, &request).unwrap();
        let preview = OperationPreview {
            device: "bcg450",
            address: 5,
            octets: vec![5],
            before: None,
            after: "stop".to_owned(),
            forced: None,
            risk: permissions::risk(operation.named.parameter.row, operation.command),
            conditions: Vec::new(),
        };
        ArmedCommand {
            id: id.to_owned(),
            user: Arc::from("Ada"),
            gauge: "chamber".to_owned(),
            connection: Connection { segment: "hall".to_owned(), port: "/dev/ttyUSB0".to_owned() },
            operation,
            preview,
            expires_at,
        }
    }

    #[test]
    fn an_armed_command_expires() {
        let (mut commands, now, ada) = (ArmedCommands::default(), Instant::now(), user("Ada"));
        commands.arm(command("1", now + ARMED_FOR)).unwrap();
        commands.expire(now + ARMED_FOR - Duration::from_millis(1));
        assert!(commands.get("1", &ada).is_ok());
        commands.expire(now + ARMED_FOR);
        assert_eq!(commands.take_to_execute("1", &ada).unwrap_err(), ArmedCommandError::Ended(Ended::Expired));
    }

    #[test]
    fn a_command_is_executed_once_and_only_by_its_user() {
        let (mut commands, now, ada) = (ArmedCommands::default(), Instant::now(), user("Ada"));
        commands.arm(command("1", now + ARMED_FOR)).unwrap();
        commands.arm(command("2", now + ARMED_FOR)).unwrap();
        let other = ArmedCommandError::OtherUser("Ada".to_owned());
        assert_eq!(commands.take_to_execute("1", &user("Bob")).unwrap_err(), other);
        assert_eq!(commands.take_to_execute("1", &ada).unwrap().id, "1");
        assert_eq!(commands.take_to_execute("1", &ada).unwrap_err(), ArmedCommandError::Ended(Ended::Executed));
        assert_eq!(commands.disarm("2", &ada).unwrap().id, "2");
        assert_eq!(commands.take_to_execute("2", &ada).unwrap_err(), ArmedCommandError::Ended(Ended::Disarmed));
        assert_eq!(commands.take_to_execute("3", &ada).unwrap_err(), ArmedCommandError::Unknown("3".to_owned()));
    }

    #[test]
    fn no_more_than_the_limit_of_commands_is_armed() {
        let (mut commands, now) = (ArmedCommands::default(), Instant::now());
        for number in 0..MAX_ARMED {
            commands.arm(command(&number.to_string(), now + ARMED_FOR)).unwrap();
        }
        assert_eq!(commands.arm(command("more", now + ARMED_FOR)), Err(ArmedCommandError::TooMany));
        commands.clear();
        assert_eq!(commands.arm(command("more", now + ARMED_FOR)), Ok(()));
    }
}
