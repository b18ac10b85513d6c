//! What is armed: the first of two steps, kept until somebody fires it, thinks better of it, or its time is over.
//!
//! A state machine without a clock: whoever calls says what time it is.

use super::draft::{Choice, Draft};
use crate::people::Person;
use std::collections::VecDeque;
use std::sync::Arc;
use std::time::{Duration, Instant};

/// How long something stays armed. free choice: long enough to read it, too short to forget it.
pub const ARMED: Duration = Duration::from_secs(30);

/// So many orders are armed at once. There is one writer: whoever arms more has lost count.
const MOST: usize = 16;

/// So many that have ended are remembered, to say what became of them.
const REMEMBERED: usize = 64;

/// Something that is armed.
#[derive(Clone, Debug)]
pub struct Order {
    /// What it is called.
    pub id: String,
    /// Who armed it.
    pub by: Arc<str>,
    /// The gauge.
    pub gauge: String,
    /// Its segment, and the port of that.
    pub line: (String, String),
    /// What was chosen.
    pub choice: Choice,
    /// What the gauge said when it was armed.
    pub draft: Draft,
    /// Until when.
    pub until: Instant,
}

/// Why an order is not carried out.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum NotArmed {
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
    #[error("{MOST} orders are armed already: fire or disarm them first")]
    Many,
}

/// Everything that is armed.
#[derive(Debug, Default)]
pub struct Orders {
    armed: Vec<Order>,
    ended: VecDeque<(String, &'static str)>,
}

impl Orders {
    /// Time has passed: what was armed too long is no more.
    pub fn pass(&mut self, now: Instant) {
        self.end("has expired", |order| order.until <= now);
    }

    /// Nothing survives a change of the mastership.
    pub fn clear(&mut self) {
        self.end("was disarmed when the mastership changed hands", |_| true);
    }

    /// Arms something.
    ///
    /// # Errors
    /// [`NotArmed::Many`].
    pub fn arm(&mut self, order: Order) -> Result<(), NotArmed> {
        if self.armed.len() >= MOST {
            return Err(NotArmed::Many);
        }
        self.armed.push(order);
        Ok(())
    }

    /// An order of this person that is armed.
    ///
    /// # Errors
    /// [`NotArmed`].
    pub fn look(&self, id: &str, person: &Person) -> Result<&Order, NotArmed> {
        let Some(order) = self.armed.iter().find(|order| order.id == id) else {
            let ended = self.ended.iter().find(|(ended, _)| ended == id);
            return Err(ended.map_or_else(|| NotArmed::Unknown(id.to_owned()), |(_, word)| NotArmed::Ended(word)));
        };
        if order.by == person.name { Ok(order) } else { Err(NotArmed::Others(order.by.to_string())) }
    }

    /// Takes an order to carry it out: it is armed no more, whatever comes of it.
    ///
    /// # Errors
    /// [`NotArmed`].
    pub fn fire(&mut self, id: &str, person: &Person) -> Result<Order, NotArmed> {
        self.take(id, person, "was fired already")
    }

    /// Takes an order to forget it.
    ///
    /// # Errors
    /// [`NotArmed`].
    pub fn disarm(&mut self, id: &str, person: &Person) -> Result<Order, NotArmed> {
        self.take(id, person, "was disarmed")
    }

    fn take(&mut self, id: &str, person: &Person, word: &'static str) -> Result<Order, NotArmed> {
        let order = self.look(id, person)?.clone();
        self.end(word, |armed| armed.id == order.id);
        Ok(order)
    }

    fn end(&mut self, word: &'static str, is_over: impl Fn(&Order) -> bool) {
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
    use super::super::allowed;
    use super::super::draft::Wish;
    use super::*;
    use crate::people::Role;
    use profivac_devices::bcg450::table::MODEL;

    fn person(name: &str) -> Person {
        Person { name: Arc::from(name), role: Role::Operator }
    }

    fn order(id: &str, until: Instant) -> Order {
        let choice = Choice::of(&MODEL, &Wish { command: Some("stop".to_owned()), ..Wish::default() }).unwrap();
        let risk = allowed::risk(choice.named.parameter.row, choice.command);
        let draft = Draft {
            device: "bcg450",
            address: 5,
            octets: vec![5],
            before: None,
            after: "stop".to_owned(),
            risk,
            conditions: Vec::new(),
        };
        let line = ("hall".to_owned(), "/dev/ttyUSB0".to_owned());
        Order { id: id.to_owned(), by: Arc::from("Ada"), gauge: "chamber".to_owned(), line, choice, draft, until }
    }

    #[test]
    fn what_is_armed_expires() {
        let (mut orders, now, ada) = (Orders::default(), Instant::now(), person("Ada"));
        orders.arm(order("1", now + ARMED)).unwrap();
        orders.pass(now + ARMED - Duration::from_millis(1));
        assert!(orders.look("1", &ada).is_ok());
        orders.pass(now + ARMED);
        assert_eq!(orders.fire("1", &ada).unwrap_err(), NotArmed::Ended("has expired"));
    }

    #[test]
    fn an_order_is_taken_once_and_by_its_owner() {
        let (mut orders, now, ada) = (Orders::default(), Instant::now(), person("Ada"));
        orders.arm(order("1", now + ARMED)).unwrap();
        orders.arm(order("2", now + ARMED)).unwrap();
        assert_eq!(orders.fire("1", &person("Bob")).unwrap_err(), NotArmed::Others("Ada".to_owned()));
        assert_eq!(orders.fire("1", &ada).unwrap().id, "1");
        assert_eq!(orders.fire("1", &ada).unwrap_err(), NotArmed::Ended("was fired already"));
        assert_eq!(orders.disarm("2", &ada).unwrap().id, "2");
        assert_eq!(orders.fire("2", &ada).unwrap_err(), NotArmed::Ended("was disarmed"));
        assert_eq!(orders.fire("3", &ada).unwrap_err(), NotArmed::Unknown("3".to_owned()));
    }

    #[test]
    fn only_so_many_are_armed() {
        let (mut orders, now) = (Orders::default(), Instant::now());
        for number in 0..MOST {
            orders.arm(order(&number.to_string(), now + ARMED)).unwrap();
        }
        assert_eq!(orders.arm(order("more", now + ARMED)), Err(NotArmed::Many));
        orders.clear();
        assert_eq!(orders.arm(order("more", now + ARMED)), Ok(()));
    }
}
