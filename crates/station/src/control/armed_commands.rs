//! What is armed: the first of two steps, kept until somebody fires it, thinks better of it, or its time is over.
//!
//! A state machine without a clock: whoever calls says what time it is.

use super::operation::{Operation, OperationPreview};
use crate::auth::User;
use std::collections::VecDeque;
use std::sync::Arc;
use std::time::{Duration, Instant};

/// How long something stays armed. free choice: long enough to read it, too short to forget it.
pub const ARMED_FOR: Duration = Duration::from_secs(30);

/// So many orders are armed at once. There is one writer: whoever arms more has lost count.
const MAX_ARMED: usize = 16;

/// So many that have ended are remembered, to say what became of them.
const REMEMBERED: usize = 64;

/// Something that is armed.
#[derive(Clone, Debug)]
pub struct ArmedCommand {
    /// What it is called.
    pub id: String,
    /// Who armed it.
    pub user: Arc<str>,
    /// The gauge.
    pub gauge: String,
    /// Its segment, and the port of that.
    pub line: (String, String),
    /// What was chosen.
    pub operation: Operation,
    /// What the gauge said when it was armed.
    pub preview: OperationPreview,
    /// Until when.
    pub expires_at: Instant,
}

/// Why an order is not carried out.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum ArmedCommandError {
    /// There never was one, or long ago.
    #[error("there is no order {0:?}")]
    Unknown(String),
    /// Somebody else's.
    #[error("the order is {0}'s: only who armed it may fire it")]
    Others(String),
    /// It is no more.
    #[error("the order {0}: arm it again")]
    Ended(&'static str),
    /// Too many.
    #[error("{MAX_ARMED} orders are armed already: fire or disarm them first")]
    Many,
}

/// Everything that is armed.
#[derive(Debug, Default)]
pub struct ArmedCommands {
    armed: Vec<ArmedCommand>,
    ended: VecDeque<(String, &'static str)>,
}

impl ArmedCommands {
    /// Time has passed: what was armed too long is no more.
    pub fn expire(&mut self, now: Instant) {
        self.end("has expired", |order| order.expires_at <= now);
    }

    /// Nothing survives a change of the mastership.
    pub fn clear(&mut self) {
        self.end("was disarmed when the mastership changed hands", |_| true);
    }

    /// Arms something.
    ///
    /// # Errors
    /// [`NotArmed::Many`].
    pub fn arm(&mut self, order: ArmedCommand) -> Result<(), ArmedCommandError> {
        if self.armed.len() >= MAX_ARMED {
            return Err(ArmedCommandError::Many);
        }
        self.armed.push(order);
        Ok(())
    }

    /// An order of this person that is armed.
    ///
    /// # Errors
    /// [`NotArmed`].
    pub fn get(&self, id: &str, person: &User) -> Result<&ArmedCommand, ArmedCommandError> {
        let Some(order) = self.armed.iter().find(|order| order.id == id) else {
            let ended = self.ended.iter().find(|(ended, _)| ended == id);
            return Err(ended.map_or_else(
                || ArmedCommandError::Unknown(id.to_owned()),
                |(_, word)| ArmedCommandError::Ended(word),
            ));
        };
        if order.user == person.name { Ok(order) } else { Err(ArmedCommandError::Others(order.user.to_string())) }
    }

    /// Takes an order to carry it out: it is armed no more, whatever comes of it.
    ///
    /// # Errors
    /// [`NotArmed`].
    pub fn take_to_execute(&mut self, id: &str, person: &User) -> Result<ArmedCommand, ArmedCommandError> {
        self.take(id, person, "was fired already")
    }

    /// Takes an order to forget it.
    ///
    /// # Errors
    /// [`NotArmed`].
    pub fn disarm(&mut self, id: &str, person: &User) -> Result<ArmedCommand, ArmedCommandError> {
        self.take(id, person, "was disarmed")
    }

    fn take(&mut self, id: &str, person: &User, word: &'static str) -> Result<ArmedCommand, ArmedCommandError> {
        let order = self.get(id, person)?.clone();
        self.end(word, |armed| armed.id == order.id);
        Ok(order)
    }

    fn end(&mut self, word: &'static str, is_over: impl Fn(&ArmedCommand) -> bool) {
        for order in self.armed.extract_if(.., |order| is_over(order)).collect::<Vec<_>>() {
            self.remember(order.id, word);
        }
    }

    fn remember(&mut self, id: String, word: &'static str) {
        self.ended.push_front((id, word));
        self.ended.truncate(REMEMBERED);
    }
}

#[cfg(test)]
mod tests {
    use super::super::operation::OperationRequest;
    use super::super::permissions;
    use super::*;
    use crate::auth::Role;
    use profivac_devices::bcg450::table::MODEL;

    fn person(name: &str) -> User {
        User { name: Arc::from(name), role: Role::Operator }
    }

    fn order(id: &str, until: Instant) -> ArmedCommand {
        let choice = Operation::of(
            &MODEL,
            &OperationRequest { command: Some("stop".to_owned()), ..OperationRequest::default() },
        )
        .unwrap();
        let risk = permissions::risk(choice.named.parameter.row, choice.command);
        let draft = OperationPreview {
            device: "bcg450",
            address: 5,
            octets: vec![5],
            before: None,
            after: "stop".to_owned(),
            risk,
            conditions: Vec::new(),
        };
        let line = ("hall".to_owned(), "/dev/ttyUSB0".to_owned());
        ArmedCommand {
            id: id.to_owned(),
            user: Arc::from("Ada"),
            gauge: "chamber".to_owned(),
            line,
            operation: choice,
            preview: draft,
            expires_at: until,
        }
    }

    #[test]
    fn what_is_armed_expires() {
        let (mut orders, now, ada) = (ArmedCommands::default(), Instant::now(), person("Ada"));
        orders.arm(order("1", now + ARMED_FOR)).unwrap();
        orders.expire(now + ARMED_FOR - Duration::from_millis(1));
        assert!(orders.get("1", &ada).is_ok());
        orders.expire(now + ARMED_FOR);
        assert_eq!(orders.take_to_execute("1", &ada).unwrap_err(), ArmedCommandError::Ended("has expired"));
    }

    #[test]
    fn an_order_is_taken_once_and_by_its_owner() {
        let (mut orders, now, ada) = (ArmedCommands::default(), Instant::now(), person("Ada"));
        orders.arm(order("1", now + ARMED_FOR)).unwrap();
        orders.arm(order("2", now + ARMED_FOR)).unwrap();
        assert_eq!(
            orders.take_to_execute("1", &person("Bob")).unwrap_err(),
            ArmedCommandError::Others("Ada".to_owned())
        );
        assert_eq!(orders.take_to_execute("1", &ada).unwrap().id, "1");
        assert_eq!(orders.take_to_execute("1", &ada).unwrap_err(), ArmedCommandError::Ended("was fired already"));
        assert_eq!(orders.disarm("2", &ada).unwrap().id, "2");
        assert_eq!(orders.take_to_execute("2", &ada).unwrap_err(), ArmedCommandError::Ended("was disarmed"));
        assert_eq!(orders.take_to_execute("3", &ada).unwrap_err(), ArmedCommandError::Unknown("3".to_owned()));
    }

    #[test]
    fn only_so_many_are_armed() {
        let (mut orders, now) = (ArmedCommands::default(), Instant::now());
        for number in 0..MAX_ARMED {
            orders.arm(order(&number.to_string(), now + ARMED_FOR)).unwrap();
        }
        assert_eq!(orders.arm(order("more", now + ARMED_FOR)), Err(ArmedCommandError::Many));
        orders.clear();
        assert_eq!(orders.arm(order("more", now + ARMED_FOR)), Ok(()));
    }
}
