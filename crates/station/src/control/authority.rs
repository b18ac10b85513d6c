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

use crate::auth::{Role, User};
use std::time::{Duration, Instant};

/// A holder who does nothing for so long holds no more. free choice: a coffee, not a lunch.
pub const IDLE_TIMEOUT: Duration = Duration::from_secs(15 * 60);

/// A holder who has done nothing for so long since somebody asked has not reacted. free choice.
pub const RESPONSE_TIMEOUT: Duration = Duration::from_secs(60);

/// A wish is forgotten after so long. free choice: whoever still wants it asks again.
pub const REQUEST_TIMEOUT: Duration = Duration::from_secs(5 * 60);

/// Why somebody cannot have their way, in a sentence.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum AuthorityError {
    /// Nobody holds it.
    #[error("nobody has the mastership: ask for it first")]
    Free,
    /// Somebody else holds it.
    #[error("{0} has the mastership")]
    HeldByOther(String),
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
    NoRequest,
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
pub enum AuthorityChange {
    /// It was free, and somebody has it now.
    Taken,
    /// Somebody has it already and goes on.
    Kept,
    /// Somebody wants it.
    Requested,
    /// Its holder gave it back.
    Released,
    /// Its holder gave it to who asked.
    Granted(String),
    /// Somebody took it from its holder.
    TakenOver(String),
}

impl AuthorityChange {
    /// Whether somebody else has it now.
    #[must_use]
    pub const fn changes_holder(&self) -> bool {
        !matches!(self, Self::Kept | Self::Requested)
    }
}

/// Somebody who holds it.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Holder {
    /// Who.
    pub person: User,
    /// Since when.
    pub since: Instant,
    /// When they last did something.
    last_used: Instant,
    /// Who wants it, and since when.
    pub request: Option<(User, Instant)>,
}

impl Holder {
    const fn new(person: User, now: Instant) -> Self {
        Self { person, since: now, last_used: now, request: None }
    }

    fn is(&self, person: &User) -> bool {
        self.person.name == person.name
    }

    fn name(&self) -> String {
        self.person.name.to_string()
    }
}

/// The mastership.
#[derive(Debug, Default)]
pub struct ControlAuthority {
    holder: Option<Holder>,
}

impl ControlAuthority {
    /// Who holds it.
    #[must_use]
    pub const fn holder(&self) -> Option<&Holder> {
        self.holder.as_ref()
    }

    /// Time has passed. Says who has lost it by that.
    pub fn expire(&mut self, now: Instant) -> Option<User> {
        let holder = self.holder.as_mut()?;
        if now.saturating_duration_since(holder.last_used) >= IDLE_TIMEOUT {
            return self.holder.take().map(|holder| holder.person);
        }
        holder.request.take_if(|(_, since)| now.saturating_duration_since(*since) >= REQUEST_TIMEOUT);
        None
    }

    /// Somebody wants it: if it is free they have it, else its holder is told.
    ///
    /// # Errors
    /// [`NotYours::Before`] when somebody else asked first.
    pub fn request(&mut self, person: &User, now: Instant) -> Result<AuthorityChange, AuthorityError> {
        let Some(holder) = &mut self.holder else {
            self.holder = Some(Holder::new(person.clone(), now));
            return Ok(AuthorityChange::Taken);
        };
        if holder.is(person) {
            holder.last_used = now;
            return Ok(AuthorityChange::Kept);
        }
        match &holder.request {
            Some((before, _)) if before.name != person.name => {
                Err(AuthorityError::Before { holder: holder.name(), before: before.name.to_string() })
            }
            Some(_) => Ok(AuthorityChange::Requested),
            None => {
                holder.request = Some((person.clone(), now));
                Ok(AuthorityChange::Requested)
            }
        }
    }

    /// Its holder does something.
    ///
    /// # Errors
    /// [`NotYours`] when it is somebody else's, or nobody's.
    pub fn use_authority(&mut self, person: &User, now: Instant) -> Result<(), AuthorityError> {
        let holder = self.holder.as_mut().ok_or(AuthorityError::Free)?;
        if !holder.is(person) {
            return Err(AuthorityError::HeldByOther(holder.name()));
        }
        holder.last_used = now;
        Ok(())
    }

    /// Its holder gives it back.
    ///
    /// # Errors
    /// As [`act`](Self::act).
    pub fn release(&mut self, person: &User, now: Instant) -> Result<AuthorityChange, AuthorityError> {
        self.use_authority(person, now)?;
        self.holder = None;
        Ok(AuthorityChange::Released)
    }

    /// Its holder gives it to who asked.
    ///
    /// # Errors
    /// As [`act`](Self::act), and [`NotYours::NoWish`].
    pub fn grant(&mut self, person: &User, now: Instant) -> Result<AuthorityChange, AuthorityError> {
        self.use_authority(person, now)?;
        let wish = self.holder.as_mut().and_then(|holder| holder.request.take());
        let (next, _) = wish.ok_or(AuthorityError::NoRequest)?;
        let name = next.name.to_string();
        self.holder = Some(Holder::new(next, now));
        Ok(AuthorityChange::Granted(name))
    }

    /// Somebody takes it from its holder.
    ///
    /// # Errors
    /// [`NotYours::Wait`] for an operator whose wish is not old enough, or whose holder is at work.
    pub fn take_over(&mut self, person: &User, now: Instant) -> Result<AuthorityChange, AuthorityError> {
        let Some(holder) = &self.holder else { return self.request(person, now) };
        if holder.is(person) {
            return self.request(person, now);
        }
        let asked = holder.request.as_ref().filter(|(who, _)| who.name == person.name).map(|(_, since)| *since);
        let is_ignored =
            asked.is_some_and(|since| now.saturating_duration_since(since.max(holder.last_used)) >= RESPONSE_TIMEOUT);
        if person.role < Role::Engineer && !is_ignored {
            return Err(AuthorityError::Wait { holder: holder.name() });
        }
        let before = holder.name();
        self.holder = Some(Holder::new(person.clone(), now));
        Ok(AuthorityChange::TakenOver(before))
    }

    /// Somebody is gone: what they held is free, and what they wished is forgotten. Says who they were, if they held it.
    pub fn remove_user(&mut self, name: &str) -> Option<User> {
        if let Some(holder) = &mut self.holder {
            holder.request.take_if(|(person, _)| &*person.name == name);
        }
        self.holder.take_if(|holder| &*holder.person.name == name).map(|holder| holder.person)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::sync::Arc;

    fn person(name: &str, role: Role) -> User {
        User { name: Arc::from(name), role }
    }

    fn holder(mastership: &ControlAuthority) -> &str {
        mastership.holder().map_or("nobody", |holder| &holder.person.name)
    }

    #[test]
    fn who_asks_first_has_it_and_gives_it_to_who_asked_next() {
        let (mut mastership, now) = (ControlAuthority::default(), Instant::now());
        let [ada, bob, eve] = ["Ada", "Bob", "Eve"].map(|name| person(name, Role::Operator));
        assert_eq!(mastership.use_authority(&ada, now), Err(AuthorityError::Free));
        assert_eq!(mastership.request(&ada, now), Ok(AuthorityChange::Taken));
        assert_eq!(mastership.grant(&ada, now), Err(AuthorityError::NoRequest));
        assert_eq!(mastership.request(&bob, now), Ok(AuthorityChange::Requested));
        assert_eq!(mastership.use_authority(&bob, now), Err(AuthorityError::HeldByOther("Ada".to_owned())));
        let before = AuthorityError::Before { holder: "Ada".to_owned(), before: "Bob".to_owned() };
        assert_eq!(mastership.request(&eve, now), Err(before));
        assert_eq!(mastership.grant(&bob, now), Err(AuthorityError::HeldByOther("Ada".to_owned())));
        assert_eq!(mastership.grant(&ada, now), Ok(AuthorityChange::Granted("Bob".to_owned())));
        assert_eq!(holder(&mastership), "Bob");
        assert_eq!(mastership.release(&bob, now), Ok(AuthorityChange::Released));
        assert_eq!(holder(&mastership), "nobody");
    }

    #[test]
    fn an_engineer_takes_it_at_any_time_and_an_operator_when_nobody_reacts() {
        let (mut mastership, now) = (ControlAuthority::default(), Instant::now());
        let [ada, bob] = ["Ada", "Bob"].map(|name| person(name, Role::Operator));
        mastership.request(&ada, now).unwrap();
        let wait = Err(AuthorityError::Wait { holder: "Ada".to_owned() });
        assert_eq!(mastership.take_over(&bob, now + RESPONSE_TIMEOUT), wait, "Bob has not asked");
        mastership.request(&bob, now).unwrap();
        let early = now + RESPONSE_TIMEOUT - Duration::from_millis(1);
        assert_eq!(mastership.take_over(&bob, early), wait);
        mastership.use_authority(&ada, early).unwrap();
        assert_eq!(mastership.take_over(&bob, now + RESPONSE_TIMEOUT), wait, "Ada is at work");
        assert_eq!(
            mastership.take_over(&bob, early + RESPONSE_TIMEOUT),
            Ok(AuthorityChange::TakenOver("Ada".to_owned()))
        );
        let engineer = person("Eve", Role::Engineer);
        assert_eq!(mastership.take_over(&engineer, now), Ok(AuthorityChange::TakenOver("Bob".to_owned())));
    }

    #[test]
    fn who_does_nothing_or_is_gone_holds_nothing() {
        let (mut mastership, now) = (ControlAuthority::default(), Instant::now());
        let ada = person("Ada", Role::Operator);
        mastership.request(&ada, now).unwrap();
        let later = now + Duration::from_secs(60);
        mastership.use_authority(&ada, later).unwrap();
        assert_eq!(mastership.expire(now + IDLE_TIMEOUT), None);
        assert_eq!(mastership.expire(later + IDLE_TIMEOUT), Some(ada.clone()));
        assert_eq!(holder(&mastership), "nobody");
        mastership.request(&ada, now).unwrap();
        assert_eq!((mastership.remove_user("Bob"), mastership.remove_user("Ada")), (None, Some(ada)));
        assert_eq!(holder(&mastership), "nobody");
    }

    #[test]
    fn a_wish_grows_old() {
        let (mut mastership, now) = (ControlAuthority::default(), Instant::now());
        let [ada, bob] = ["Ada", "Bob"].map(|name| person(name, Role::Operator));
        mastership.request(&ada, now).unwrap();
        mastership.request(&bob, now).unwrap();
        mastership.expire(now + REQUEST_TIMEOUT - Duration::from_millis(1));
        assert!(mastership.holder().unwrap().request.is_some());
        mastership.expire(now + REQUEST_TIMEOUT);
        assert_eq!(mastership.holder().unwrap().request, None);
    }
}
