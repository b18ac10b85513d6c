//! Plant states: an operator declares that the plant, or a part of it, is vented or baked out, and the alarms that mean nothing then are
//! suppressed by design (ISA-18.2). A declaration always ends.
//!
//! Two times come in, as in the registry: an end is counted on the monotonic time, and stored and shown as wall-clock time.

use super::suppression::AlarmTime;
use profivac_model::{Attribution, Declaration, Micros, Suppression};
use profivac_web_server::auth::Role;
use std::collections::BTreeSet;
use std::ops::RangeInclusive;
use std::time::Duration;

/// The times for which a plant state can be declared, whatever the station's file permits. chosen: a bake-out lasts for weeks.
pub const DECLARED: RangeInclusive<Duration> = Duration::from_secs(60)..=Duration::from_secs(31 * 86_400);

/// A plant state of the station's file.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct PlantStateRule {
    /// The name, which no other plant state has.
    pub name: String,
    /// A sentence about it.
    pub description: Option<String>,
    /// The longest time for which it is declared or extended, within [`DECLARED`].
    pub longest: Duration,
    /// The lowest role that declares and extends it.
    pub role: Role,
    /// The names of the alarms that mean nothing in it.
    pub alarms: BTreeSet<String>,
}

/// A plant state with its declaration.
#[derive(Clone, Debug)]
pub struct PlantState {
    rule: PlantStateRule,
    declared: Option<Declared>,
}

/// A declaration, and what it says about each alarm that it suppresses.
#[derive(Clone, Debug)]
struct Declared {
    declaration: Declaration,
    suppression: Suppression,
    /// When it ends, in monotonic time.
    ends_at: Micros,
}

impl Declared {
    fn new(state: &str, declaration: Declaration, ends_at: Micros) -> Self {
        let Declaration { by, reason, until } = declaration.clone();
        let suppression = Suppression { by, reason: format!("{state}: {reason}"), until: Some(until) };
        Self { declaration, suppression, ends_at }
    }
}

impl PlantState {
    /// The plant state of the station's file.
    #[must_use]
    pub const fn rule(&self) -> &PlantStateRule {
        &self.rule
    }

    /// Its declaration; `None` unless it is declared.
    #[must_use]
    pub fn declaration(&self) -> Option<&Declaration> {
        self.declared.as_ref().map(|declared| &declared.declaration)
    }

    fn check_time(&self, time: Duration) -> Result<(), PlantStateError> {
        if (*DECLARED.start()..=self.rule.longest).contains(&time) {
            return Ok(());
        }
        let (longest, found) = (minutes(self.rule.longest), minutes(time));
        Err(PlantStateError::Time { name: self.rule.name.clone(), longest, found })
    }
}

fn minutes(time: Duration) -> u64 {
    time.as_secs() / 60
}

/// The kind of a change of a plant state.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum PlantStateChangeKind {
    /// A user declared it.
    Declared,
    /// A user gave it a later end.
    Extended,
    /// A user ended it, its time is over, or the station's file no longer has it.
    Ended,
}

/// A change of a plant state.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct PlantStateChange {
    /// The wall-clock time.
    pub at: Micros,
    /// The plant state.
    pub name: String,
    /// The kind of the change.
    pub kind: PlantStateChangeKind,
    /// The user who made it; `None` if the station did.
    pub user: Option<String>,
    /// The reason; empty if the user gave none.
    pub reason: String,
    /// The declaration before.
    pub before: Option<Declaration>,
    /// The declaration after.
    pub after: Option<Declaration>,
    /// The number of alarms that it suppresses while it is declared.
    pub alarms: usize,
}

/// The reason why a plant state cannot be changed.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum PlantStateError {
    /// The station's file has no such plant state.
    #[error("there is no plant state {name:?}; {}", known_states(.known))]
    Unknown {
        /// The name.
        name: String,
        /// Those of the station's file.
        known: Vec<String>,
    },
    /// The time is out of range.
    #[error("expected minutes from 1 to {longest}, the longest time of {name} in the station's file, found {found}")]
    Time {
        /// The plant state.
        name: String,
        /// Its longest time in minutes.
        longest: u64,
        /// The time in minutes.
        found: u64,
    },
    /// It is declared already.
    #[error("{name} is declared by {by} already; extend it, or end it first")]
    Declared {
        /// The plant state.
        name: String,
        /// The user who declared it.
        by: String,
    },
    /// It is not declared.
    #[error("{name} is not declared; look at the plant states before you change one")]
    NotDeclared {
        /// The plant state.
        name: String,
    },
    /// An extension would end it earlier.
    #[error("{name} is declared until {} already; choose a later end, or end it", rfc3339(*.until))]
    NotLater {
        /// The plant state.
        name: String,
        /// Its end.
        until: Micros,
    },
}

fn known_states(known: &[String]) -> String {
    if known.is_empty() {
        return "the station's file has no [[plant-state]]".to_owned();
    }
    format!("expected one of: {}", known.join(", "))
}

/// A time in UTC, to the second.
pub(super) fn rfc3339(at: Micros) -> String {
    at.to_iso(0)
}

/// All plant states, in the order of the station's file.
#[derive(Clone, Debug, Default)]
pub struct PlantStates {
    states: Vec<PlantState>,
}

impl PlantStates {
    /// All plant states.
    #[must_use]
    pub fn all(&self) -> &[PlantState] {
        &self.states
    }

    /// Applies the plant states of a file. One keeps its declaration by its name, from here or, at the start, from `stored`. A declaration
    /// of a plant state that is removed ends, and gives a change.
    pub fn reconfigure(
        &mut self,
        rules: Vec<PlantStateRule>,
        stored: Vec<(String, Declaration)>,
        now: AlarmTime,
    ) -> Vec<PlantStateChange> {
        let mut old: Vec<(String, Declaration, Option<Micros>)> =
            stored.into_iter().map(|(name, declaration)| (name, declaration, None)).collect();
        for PlantState { rule, declared } in std::mem::take(&mut self.states) {
            old.extend(declared.map(|it| (rule.name, it.declaration, Some(it.ends_at))));
        }
        for rule in rules {
            let known = old.iter().position(|(name, _, _)| *name == rule.name);
            let declared = known.map(|index| {
                let (name, declaration, ends_at) = old.swap_remove(index);
                // After a restart: a clock that was set back since does not prolong it beyond the longest time.
                let remaining = || {
                    let longest = i64::try_from(rule.longest.as_micros()).unwrap_or(i64::MAX);
                    Micros(now.monotonic.0.saturating_add(declaration.until.0.saturating_sub(now.wall.0).min(longest)))
                };
                let ends_at = ends_at.unwrap_or_else(remaining);
                Declared::new(&name, declaration, ends_at)
            });
            self.states.push(PlantState { rule, declared });
        }
        let removed = old.into_iter().map(|(name, declaration, _)| PlantStateChange {
            at: now.wall,
            name,
            kind: PlantStateChangeKind::Ended,
            user: None,
            reason: "the station's file no longer has it".to_owned(),
            before: Some(declaration),
            after: None,
            alarms: 0,
        });
        removed.collect()
    }

    /// The plant state of this name.
    ///
    /// # Errors
    /// [`PlantStateError::Unknown`] if the station's file has none.
    pub fn state(&self, name: &str) -> Result<&PlantState, PlantStateError> {
        self.states.iter().find(|state| state.rule.name == name).ok_or_else(|| self.unknown(name))
    }

    fn unknown(&self, name: &str) -> PlantStateError {
        let known = self.states.iter().map(|state| state.rule.name.clone()).collect();
        PlantStateError::Unknown { name: name.to_owned(), known }
    }

    fn state_mut(&mut self, name: &str) -> Result<&mut PlantState, PlantStateError> {
        let unknown = self.unknown(name);
        self.states.iter_mut().find(|state| state.rule.name == name).ok_or(unknown)
    }

    /// Declares a plant state for a time.
    ///
    /// # Errors
    /// [`PlantStateError`] if there is no such plant state, if it is declared already, or if the time is out of its range.
    pub fn declare(
        &mut self,
        name: &str,
        user: &str,
        reason: &str,
        time: Duration,
        now: AlarmTime,
    ) -> Result<PlantStateChange, PlantStateError> {
        let state = self.state_mut(name)?;
        if let Some(declaration) = state.declaration() {
            return Err(PlantStateError::Declared { name: name.to_owned(), by: declaration.by.user.clone() });
        }
        state.check_time(time)?;
        let by = Attribution { user: user.to_owned(), at: now.wall };
        let declaration = Declaration { by, reason: reason.to_owned(), until: now.wall.after(time) };
        Ok(state.set(PlantStateChangeKind::Declared, user, declaration, time, now))
    }

    /// Gives a declared plant state a later end: `time` from now. The user who declared it and that time stay.
    ///
    /// # Errors
    /// [`PlantStateError`] if there is no such plant state, if it is not declared, if the time is out of its range, or if it would end
    /// earlier.
    pub fn extend(
        &mut self,
        name: &str,
        user: &str,
        reason: &str,
        time: Duration,
        now: AlarmTime,
    ) -> Result<PlantStateChange, PlantStateError> {
        let state = self.state_mut(name)?;
        let declared = state.declared.as_ref();
        let declared = declared.ok_or_else(|| PlantStateError::NotDeclared { name: name.to_owned() })?;
        state.check_time(time)?;
        if now.monotonic.after(time) <= declared.ends_at {
            return Err(PlantStateError::NotLater { name: name.to_owned(), until: declared.declaration.until });
        }
        let by = declared.declaration.by.clone();
        let declaration = Declaration { by, reason: reason.to_owned(), until: now.wall.after(time) };
        Ok(state.set(PlantStateChangeKind::Extended, user, declaration, time, now))
    }

    /// Ends a declared plant state.
    ///
    /// # Errors
    /// [`PlantStateError`] if there is no such plant state, or if it is not declared.
    pub fn end(
        &mut self,
        name: &str,
        user: &str,
        reason: &str,
        now: AlarmTime,
    ) -> Result<PlantStateChange, PlantStateError> {
        let state = self.state_mut(name)?;
        state.end(Some(user), reason, now).ok_or_else(|| PlantStateError::NotDeclared { name: name.to_owned() })
    }

    /// Ends the plant states whose time is over.
    pub fn end_due(&mut self, now: AlarmTime) -> Vec<PlantStateChange> {
        let is_due = |state: &&mut PlantState| state.declared.as_ref().is_some_and(|it| it.ends_at <= now.monotonic);
        let due = self.states.iter_mut().filter(is_due);
        due.filter_map(|state| state.end(None, "its time is over", now)).collect()
    }

    /// Why a plant state suppresses an alarm: the declaration that ends last.
    #[must_use]
    pub(super) fn suppression_of(&self, alarm: &str) -> Option<&Suppression> {
        let declared = self.states.iter().filter_map(|state| Some((&state.rule, state.declared.as_ref()?)));
        let of_alarm = declared.filter(|(rule, _)| rule.alarms.contains(alarm)).map(|(_, declared)| declared);
        of_alarm.max_by_key(|declared| declared.ends_at).map(|declared| &declared.suppression)
    }
}

impl PlantState {
    fn set(
        &mut self,
        kind: PlantStateChangeKind,
        user: &str,
        declaration: Declaration,
        time: Duration,
        now: AlarmTime,
    ) -> PlantStateChange {
        let name = self.rule.name.clone();
        let declared = Declared::new(&name, declaration.clone(), now.monotonic.after(time));
        let before = self.declared.replace(declared).map(|it| it.declaration);
        PlantStateChange {
            at: now.wall,
            name,
            kind,
            user: Some(user.to_owned()),
            reason: declaration.reason.clone(),
            before,
            after: Some(declaration),
            alarms: self.rule.alarms.len(),
        }
    }

    fn end(&mut self, user: Option<&str>, reason: &str, now: AlarmTime) -> Option<PlantStateChange> {
        let before = self.declared.take()?.declaration;
        Some(PlantStateChange {
            at: now.wall,
            name: self.rule.name.clone(),
            kind: PlantStateChangeKind::Ended,
            user: user.map(str::to_owned),
            reason: reason.to_owned(),
            before: Some(before),
            after: None,
            alarms: self.rule.alarms.len(),
        })
    }
}
