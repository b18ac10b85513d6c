//! Who may act: one person at a time, station-wide.
//!
//! ```text
//!  free ── ask ──▶ held ── release, 15 min without an act, gone ──▶ free
//!                   │ ▲
//!         ask (another) │ grant to who asked; take-over by an engineer, or after 60 s without a reaction by who asked
//!                   ▼ │
//!              held, and wanted
//! ```
//!
//! A state machine without a clock: whoever calls says what time it is.

use crate::people::{Person, Role};
use std::time::{Duration, Instant};

/// A holder who does nothing for so long holds no more. free choice: a coffee, not a lunch.
pub const IDLE: Duration = Duration::from_secs(15 * 60);

/// A holder who has done nothing for so long since somebody asked has not reacted. free choice.
pub const REACTION: Duration = Duration::from_secs(60);

/// A wish is forgotten after so long. free choice: whoever still wants it asks again.
pub const WISH: Duration = Duration::from_secs(5 * 60);

/// Why somebody cannot have their way, in a sentence.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum NotYours {
    /// Nobody holds it.
    #[error("nobody has the mastership: ask for it first")]
    Free,
    /// Somebody else holds it.
    #[error("{0} has the mastership")]
    Held(String),
    /// Another one asked before.
    #[error("{holder} has the mastership, and {before} has asked before")]
    Before {
        /// Who holds it.
        holder: String,
        /// Who asked.
        before: String,
    },
    /// Nobody has asked for it.
    #[error("nobody has asked for the mastership")]
    NoWish,
    /// Neither an engineer, nor somebody who was let wait.
    #[error(
        "{holder} has the mastership: an engineer may take it over, an operator 60 s after asking if {holder} does nothing meanwhile"
    )]
    Wait {
        /// Who holds it.
        holder: String,
    },
}

/// What has become of it.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Change {
    /// It was free, and somebody has it now.
    Taken,
    /// Somebody has it already and goes on.
    Kept,
    /// Somebody wants it.
    Asked,
    /// Its holder gave it back.
    Released,
    /// Its holder gave it to who asked.
    Granted(String),
    /// Somebody took it from its holder.
    TakenOver(String),
}

impl Change {
    /// Whether somebody else has it now.
    #[must_use]
    pub const fn changes_hands(&self) -> bool {
        !matches!(self, Self::Kept | Self::Asked)
    }
}

/// Somebody who holds it.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Holder {
    /// Who.
    pub person: Person,
    /// Since when.
    pub since: Instant,
    /// When they last did something.
    acted: Instant,
    /// Who wants it, and since when.
    pub wish: Option<(Person, Instant)>,
}

impl Holder {
    const fn new(person: Person, now: Instant) -> Self {
        Self { person, since: now, acted: now, wish: None }
    }

    fn is(&self, person: &Person) -> bool {
        self.person.name == person.name
    }

    fn name(&self) -> String {
        self.person.name.to_string()
    }
}

/// The mastership.
#[derive(Debug, Default)]
pub struct Mastership {
    holder: Option<Holder>,
}

impl Mastership {
    /// Who holds it.
    #[must_use]
    pub const fn holder(&self) -> Option<&Holder> {
        self.holder.as_ref()
    }

    /// Time has passed. Says who has lost it by that.
    pub fn pass(&mut self, now: Instant) -> Option<Person> {
        let holder = self.holder.as_mut()?;
        if now.saturating_duration_since(holder.acted) >= IDLE {
            return self.holder.take().map(|holder| holder.person);
        }
        holder.wish.take_if(|(_, since)| now.saturating_duration_since(*since) >= WISH);
        None
    }

    /// Somebody wants it: if it is free they have it, else its holder is told.
    ///
    /// # Errors
    /// [`NotYours::Before`] when somebody else asked first.
    pub fn ask(&mut self, person: &Person, now: Instant) -> Result<Change, NotYours> {
        let Some(holder) = &mut self.holder else {
            self.holder = Some(Holder::new(person.clone(), now));
            return Ok(Change::Taken);
        };
        if holder.is(person) {
            holder.acted = now;
            return Ok(Change::Kept);
        }
        match &holder.wish {
            Some((before, _)) if before.name != person.name => {
                Err(NotYours::Before { holder: holder.name(), before: before.name.to_string() })
            }
            Some(_) => Ok(Change::Asked),
            None => {
                holder.wish = Some((person.clone(), now));
                Ok(Change::Asked)
            }
        }
    }

    /// Its holder does something.
    ///
    /// # Errors
    /// [`NotYours`] when it is somebody else's, or nobody's.
    pub fn act(&mut self, person: &Person, now: Instant) -> Result<(), NotYours> {
        let holder = self.holder.as_mut().ok_or(NotYours::Free)?;
        if !holder.is(person) {
            return Err(NotYours::Held(holder.name()));
        }
        holder.acted = now;
        Ok(())
    }

    /// Its holder gives it back.
    ///
    /// # Errors
    /// As [`act`](Self::act).
    pub fn release(&mut self, person: &Person, now: Instant) -> Result<Change, NotYours> {
        self.act(person, now)?;
        self.holder = None;
        Ok(Change::Released)
    }

    /// Its holder gives it to who asked.
    ///
    /// # Errors
    /// As [`act`](Self::act), and [`NotYours::NoWish`].
    pub fn grant(&mut self, person: &Person, now: Instant) -> Result<Change, NotYours> {
        self.act(person, now)?;
        let wish = self.holder.as_mut().and_then(|holder| holder.wish.take());
        let (next, _) = wish.ok_or(NotYours::NoWish)?;
        let name = next.name.to_string();
        self.holder = Some(Holder::new(next, now));
        Ok(Change::Granted(name))
    }

    /// Somebody takes it from its holder.
    ///
    /// # Errors
    /// [`NotYours::Wait`] for an operator whose wish is not old enough, or whose holder is at work.
    pub fn take_over(&mut self, person: &Person, now: Instant) -> Result<Change, NotYours> {
        let Some(holder) = &self.holder else { return self.ask(person, now) };
        if holder.is(person) {
            return self.ask(person, now);
        }
        let asked = holder.wish.as_ref().filter(|(who, _)| who.name == person.name).map(|(_, since)| *since);
        let is_ignored = asked.is_some_and(|since| now.saturating_duration_since(since.max(holder.acted)) >= REACTION);
        if person.role < Role::Engineer && !is_ignored {
            return Err(NotYours::Wait { holder: holder.name() });
        }
        let before = holder.name();
        self.holder = Some(Holder::new(person.clone(), now));
        Ok(Change::TakenOver(before))
    }

    /// Somebody is gone: what they held is free, and what they wished is forgotten. Says who they were, if they held it.
    pub fn gone(&mut self, name: &str) -> Option<Person> {
        if let Some(holder) = &mut self.holder {
            holder.wish.take_if(|(person, _)| &*person.name == name);
        }
        self.holder.take_if(|holder| &*holder.person.name == name).map(|holder| holder.person)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::sync::Arc;

    fn person(name: &str, role: Role) -> Person {
        Person { name: Arc::from(name), role }
    }

    fn holder(mastership: &Mastership) -> &str {
        mastership.holder().map_or("nobody", |holder| &holder.person.name)
    }

    #[test]
    fn who_asks_first_has_it_and_gives_it_to_who_asked_next() {
        let (mut mastership, now) = (Mastership::default(), Instant::now());
        let [ada, bob, eve] = ["Ada", "Bob", "Eve"].map(|name| person(name, Role::Operator));
        assert_eq!(mastership.act(&ada, now), Err(NotYours::Free));
        assert_eq!(mastership.ask(&ada, now), Ok(Change::Taken));
        assert_eq!(mastership.grant(&ada, now), Err(NotYours::NoWish));
        assert_eq!(mastership.ask(&bob, now), Ok(Change::Asked));
        assert_eq!(mastership.act(&bob, now), Err(NotYours::Held("Ada".to_owned())));
        let before = NotYours::Before { holder: "Ada".to_owned(), before: "Bob".to_owned() };
        assert_eq!(mastership.ask(&eve, now), Err(before));
        assert_eq!(mastership.grant(&bob, now), Err(NotYours::Held("Ada".to_owned())));
        assert_eq!(mastership.grant(&ada, now), Ok(Change::Granted("Bob".to_owned())));
        assert_eq!(holder(&mastership), "Bob");
        assert_eq!(mastership.release(&bob, now), Ok(Change::Released));
        assert_eq!(holder(&mastership), "nobody");
    }

    #[test]
    fn an_engineer_takes_it_at_any_time_and_an_operator_when_nobody_reacts() {
        let (mut mastership, now) = (Mastership::default(), Instant::now());
        let [ada, bob] = ["Ada", "Bob"].map(|name| person(name, Role::Operator));
        mastership.ask(&ada, now).unwrap();
        let wait = Err(NotYours::Wait { holder: "Ada".to_owned() });
        assert_eq!(mastership.take_over(&bob, now + REACTION), wait, "Bob has not asked");
        mastership.ask(&bob, now).unwrap();
        let early = now + REACTION - Duration::from_millis(1);
        assert_eq!(mastership.take_over(&bob, early), wait);
        mastership.act(&ada, early).unwrap();
        assert_eq!(mastership.take_over(&bob, now + REACTION), wait, "Ada is at work");
        assert_eq!(mastership.take_over(&bob, early + REACTION), Ok(Change::TakenOver("Ada".to_owned())));
        let engineer = person("Eve", Role::Engineer);
        assert_eq!(mastership.take_over(&engineer, now), Ok(Change::TakenOver("Bob".to_owned())));
    }

    #[test]
    fn who_does_nothing_or_is_gone_holds_nothing() {
        let (mut mastership, now) = (Mastership::default(), Instant::now());
        let ada = person("Ada", Role::Operator);
        mastership.ask(&ada, now).unwrap();
        let later = now + Duration::from_secs(60);
        mastership.act(&ada, later).unwrap();
        assert_eq!(mastership.pass(now + IDLE), None);
        assert_eq!(mastership.pass(later + IDLE), Some(ada.clone()));
        assert_eq!(holder(&mastership), "nobody");
        mastership.ask(&ada, now).unwrap();
        assert_eq!((mastership.gone("Bob"), mastership.gone("Ada")), (None, Some(ada)));
        assert_eq!(holder(&mastership), "nobody");
    }

    #[test]
    fn a_wish_grows_old() {
        let (mut mastership, now) = (Mastership::default(), Instant::now());
        let [ada, bob] = ["Ada", "Bob"].map(|name| person(name, Role::Operator));
        mastership.ask(&ada, now).unwrap();
        mastership.ask(&bob, now).unwrap();
        mastership.pass(now + WISH - Duration::from_millis(1));
        assert!(mastership.holder().unwrap().wish.is_some());
        mastership.pass(now + WISH);
        assert_eq!(mastership.holder().unwrap().wish, None);
    }
}
