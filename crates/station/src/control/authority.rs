//! Control authority: one user at a time may control gauges, on the whole station.
//!
//! ```text
//!  free ── request ──▶ held ── release, 15 min without use, session ended ──▶ free
//!                       │ ▲
//!    request by another │ grant to the requester; take-over by an engineer, or by the requester after 60 s without a response
//!                       ▼ │
//!                  held, and requested
//! ```
//!
//! A state machine without a clock: the caller passes the time.

use profivac_web_server::auth::{Role, User};
use std::time::{Duration, Instant};

/// A holder who does not use control for this time loses it. chosen: a coffee, not a lunch.
pub const IDLE_TIMEOUT: Duration = Duration::from_secs(15 * 60);

/// A holder who does not use control for this time after a request has not responded. chosen.
pub const RESPONSE_TIMEOUT: Duration = Duration::from_secs(60);

/// A request expires after this time. chosen: a user who still wants control requests it again.
pub const REQUEST_TIMEOUT: Duration = Duration::from_secs(5 * 60);

/// The reason why a user cannot use or get control.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum AuthorityError {
    /// No user has control.
    #[error("no one has control: request control first")]
    Free,
    /// Another user has control.
    #[error("{0} has control")]
    HeldByOther(String),
    /// Another user has requested control before.
    #[error("{holder} has control, and {before} has requested it before you")]
    Before {
        /// The user who has control.
        holder: String,
        /// The user who requested it.
        before: String,
    },
    /// No user has requested control.
    #[error("no one has requested control")]
    NoRequest,
    /// The user is no engineer, and the holder has responded.
    #[error(
        "{holder} has control: an engineer may take it over, an operator 60 s after requesting it if {holder} does not respond"
    )]
    Wait {
        /// The user who has control.
        holder: String,
    },
}

/// A change of control authority.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum AuthorityChange {
    /// Control was free, and the user took it.
    Taken,
    /// The user had control already and keeps it.
    Kept,
    /// The user requested control from its holder.
    Requested,
    /// The holder released control.
    Released,
    /// The holder granted control to this requester.
    Granted(String),
    /// The user took control over from this holder.
    TakenOver(String),
}

impl AuthorityChange {
    /// Whether another user, or no user, has control now.
    #[must_use]
    pub const fn changes_holder(&self) -> bool {
        !matches!(self, Self::Kept | Self::Requested)
    }
}

/// The user who has control.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Holder {
    /// The user.
    pub user: User,
    /// Since when.
    pub since: Instant,
    /// When the user last used control.
    last_used: Instant,
    /// The user who requests control, and since when.
    pub request: Option<(User, Instant)>,
}

impl Holder {
    const fn new(user: User, now: Instant) -> Self {
        Self { user, since: now, last_used: now, request: None }
    }

    fn is(&self, user: &User) -> bool {
        self.user.name == user.name
    }

    fn name(&self) -> String {
        self.user.name.to_string()
    }
}

/// The state of control authority.
#[derive(Debug, Default)]
pub struct ControlAuthority {
    holder: Option<Holder>,
}

impl ControlAuthority {
    /// The user who has control.
    #[must_use]
    pub const fn holder(&self) -> Option<&Holder> {
        self.holder.as_ref()
    }

    /// Lets time pass until `now`. Returns the user who lost control by that.
    pub fn expire(&mut self, now: Instant) -> Option<User> {
        let holder = self.holder.as_mut()?;
        if now.saturating_duration_since(holder.last_used) >= IDLE_TIMEOUT {
            return self.holder.take().map(|holder| holder.user);
        }
        holder.request.take_if(|(_, since)| now.saturating_duration_since(*since) >= REQUEST_TIMEOUT);
        None
    }

    /// The user takes control if it is free, or requests it from its holder.
    ///
    /// # Errors
    /// [`AuthorityError::Before`] when another user has requested control before.
    pub fn request(&mut self, user: &User, now: Instant) -> Result<AuthorityChange, AuthorityError> {
        let Some(holder) = &mut self.holder else {
            self.holder = Some(Holder::new(user.clone(), now));
            return Ok(AuthorityChange::Taken);
        };
        if holder.is(user) {
            holder.last_used = now;
            return Ok(AuthorityChange::Kept);
        }
        match &holder.request {
            Some((before, _)) if before.name != user.name => {
                Err(AuthorityError::Before { holder: holder.name(), before: before.name.to_string() })
            }
            Some(_) => Ok(AuthorityChange::Requested),
            None => {
                holder.request = Some((user.clone(), now));
                Ok(AuthorityChange::Requested)
            }
        }
    }

    /// The holder uses control.
    ///
    /// # Errors
    /// [`AuthorityError`] when another user has control, or no user.
    pub fn use_authority(&mut self, user: &User, now: Instant) -> Result<(), AuthorityError> {
        let holder = self.holder.as_mut().ok_or(AuthorityError::Free)?;
        if !holder.is(user) {
            return Err(AuthorityError::HeldByOther(holder.name()));
        }
        holder.last_used = now;
        Ok(())
    }

    /// The holder releases control.
    ///
    /// # Errors
    /// As [`use_authority`](Self::use_authority).
    pub fn release(&mut self, user: &User, now: Instant) -> Result<AuthorityChange, AuthorityError> {
        self.use_authority(user, now)?;
        self.holder = None;
        Ok(AuthorityChange::Released)
    }

    /// The holder grants control to the requester.
    ///
    /// # Errors
    /// As [`use_authority`](Self::use_authority), and [`AuthorityError::NoRequest`].
    pub fn grant(&mut self, user: &User, now: Instant) -> Result<AuthorityChange, AuthorityError> {
        self.use_authority(user, now)?;
        let request = self.holder.as_mut().and_then(|holder| holder.request.take());
        let (next, _) = request.ok_or(AuthorityError::NoRequest)?;
        let name = next.name.to_string();
        self.holder = Some(Holder::new(next, now));
        Ok(AuthorityChange::Granted(name))
    }

    /// The user takes control over from its holder.
    ///
    /// # Errors
    /// [`AuthorityError::Wait`] for an operator whose request is too new, or whose holder has responded.
    pub fn take_over(&mut self, user: &User, now: Instant) -> Result<AuthorityChange, AuthorityError> {
        let Some(holder) = &self.holder else { return self.request(user, now) };
        if holder.is(user) {
            return self.request(user, now);
        }
        let requested = holder.request.as_ref().filter(|(other, _)| other.name == user.name).map(|(_, since)| *since);
        let is_ignored = requested
            .is_some_and(|since| now.saturating_duration_since(since.max(holder.last_used)) >= RESPONSE_TIMEOUT);
        if user.role < Role::Engineer && !is_ignored {
            return Err(AuthorityError::Wait { holder: holder.name() });
        }
        let before = holder.name();
        self.holder = Some(Holder::new(user.clone(), now));
        Ok(AuthorityChange::TakenOver(before))
    }

    /// Frees the control and drops the request of a user. Returns the user if they had control.
    pub fn remove_user(&mut self, name: &str) -> Option<User> {
        if let Some(holder) = &mut self.holder {
            holder.request.take_if(|(user, _)| &*user.name == name);
        }
        self.holder.take_if(|holder| &*holder.user.name == name).map(|holder| holder.user)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::sync::Arc;

    fn user(name: &str, role: Role) -> User {
        User { name: Arc::from(name), role }
    }

    fn holder(authority: &ControlAuthority) -> &str {
        authority.holder().map_or("no one", |holder| &holder.user.name)
    }

    #[test]
    fn the_first_requester_has_control_and_grants_it_to_the_next() {
        let (mut authority, now) = (ControlAuthority::default(), Instant::now());
        let [ada, bob, eve] = ["Ada", "Bob", "Eve"].map(|name| user(name, Role::Operator));
        assert_eq!(authority.use_authority(&ada, now), Err(AuthorityError::Free));
        assert_eq!(authority.request(&ada, now), Ok(AuthorityChange::Taken));
        assert_eq!(authority.grant(&ada, now), Err(AuthorityError::NoRequest));
        assert_eq!(authority.request(&bob, now), Ok(AuthorityChange::Requested));
        assert_eq!(authority.use_authority(&bob, now), Err(AuthorityError::HeldByOther("Ada".to_owned())));
        let before = AuthorityError::Before { holder: "Ada".to_owned(), before: "Bob".to_owned() };
        assert_eq!(authority.request(&eve, now), Err(before));
        assert_eq!(authority.grant(&bob, now), Err(AuthorityError::HeldByOther("Ada".to_owned())));
        assert_eq!(authority.grant(&ada, now), Ok(AuthorityChange::Granted("Bob".to_owned())));
        assert_eq!(holder(&authority), "Bob");
        assert_eq!(authority.release(&bob, now), Ok(AuthorityChange::Released));
        assert_eq!(holder(&authority), "no one");
    }

    #[test]
    fn an_engineer_takes_control_over_at_any_time_and_an_operator_after_no_response() {
        let (mut authority, now) = (ControlAuthority::default(), Instant::now());
        let [ada, bob] = ["Ada", "Bob"].map(|name| user(name, Role::Operator));
        authority.request(&ada, now).unwrap();
        let wait = Err(AuthorityError::Wait { holder: "Ada".to_owned() });
        assert_eq!(authority.take_over(&bob, now + RESPONSE_TIMEOUT), wait, "Bob has not requested control");
        authority.request(&bob, now).unwrap();
        let early = now + RESPONSE_TIMEOUT - Duration::from_millis(1);
        assert_eq!(authority.take_over(&bob, early), wait);
        authority.use_authority(&ada, early).unwrap();
        assert_eq!(authority.take_over(&bob, now + RESPONSE_TIMEOUT), wait, "Ada has responded");
        assert_eq!(
            authority.take_over(&bob, early + RESPONSE_TIMEOUT),
            Ok(AuthorityChange::TakenOver("Ada".to_owned()))
        );
        let engineer = user("Eve", Role::Engineer);
        assert_eq!(authority.take_over(&engineer, now), Ok(AuthorityChange::TakenOver("Bob".to_owned())));
    }

    #[test]
    fn a_holder_who_is_idle_or_gone_loses_control() {
        let (mut authority, now) = (ControlAuthority::default(), Instant::now());
        let ada = user("Ada", Role::Operator);
        authority.request(&ada, now).unwrap();
        let later = now + Duration::from_secs(60);
        authority.use_authority(&ada, later).unwrap();
        assert_eq!(authority.expire(now + IDLE_TIMEOUT), None);
        assert_eq!(authority.expire(later + IDLE_TIMEOUT), Some(ada.clone()));
        assert_eq!(holder(&authority), "no one");
        authority.request(&ada, now).unwrap();
        assert_eq!((authority.remove_user("Bob"), authority.remove_user("Ada")), (None, Some(ada)));
        assert_eq!(holder(&authority), "no one");
    }

    #[test]
    fn a_request_expires() {
        let (mut authority, now) = (ControlAuthority::default(), Instant::now());
        let [ada, bob] = ["Ada", "Bob"].map(|name| user(name, Role::Operator));
        authority.request(&ada, now).unwrap();
        authority.request(&bob, now).unwrap();
        authority.expire(now + REQUEST_TIMEOUT - Duration::from_millis(1));
        assert!(authority.holder().unwrap().request.is_some());
        authority.expire(now + REQUEST_TIMEOUT);
        assert_eq!(authority.holder().unwrap().request, None);
    }
}
