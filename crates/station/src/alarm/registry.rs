//! All alarms of a station: pure, with neither clock nor thread nor disk. What is told to it comes with the time.
//!
//! Two times come in. `steady` is of a clock that nobody sets: delays and ends are counted on it. `at` is what the clock on the wall
//! shows: it is written down.

use super::evaluate::{Evaluation, Evaluator, Inputs};
use super::rule::Rule;
use super::state::{AlarmState, Input};
use profivac_recorder::Micros;
use std::time::Duration;

/// When something happens.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct AlarmTime {
    /// On a clock that nobody sets.
    pub monotonic: Micros,
    /// On the wall.
    pub wall: Micros,
}

/// Who did something, and when.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Attribution {
    /// Their name.
    pub user: String,
    /// When, on the wall.
    pub at: Micros,
}

/// Why it is out of service.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct OutOfService {
    /// Who took it away.
    pub by: Attribution,
    /// Why.
    pub reason: String,
    /// When it comes back by itself, on the wall.
    pub until: Option<Micros>,
}

/// What has become of an alarm: all that must survive the end of the program.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct AlarmStatus {
    /// Where it stands.
    pub state: AlarmState,
    /// Since when.
    pub since: Micros,
    /// The number of the time it was raised last: the milliseconds since 1970 at which it was, or one more than the last; 0 if it
    /// never was.
    pub occurrence: i64,
    /// When it was raised last.
    pub raised: Option<Micros>,
    /// The value that raised it.
    pub value: Option<f64>,
    /// What was seen then, in a sentence.
    pub text: String,
    /// Who knows.
    pub acknowledged: Option<Attribution>,
    /// Why it is out of service.
    pub out: Option<OutOfService>,
}

/// What happened to an alarm.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ChangeKind {
    /// It was raised.
    Raised,
    /// Its condition does not hold any more.
    Returned,
    /// Somebody knows.
    Acknowledged,
    /// It was taken out of service.
    TakenOutOfService,
    /// It was put back into service.
    ReturnedToService,
    /// It does not stand in the file any more.
    Removed,
}

impl ChangeKind {
    /// All of them.
    pub const ALL: [Self; 6] = [
        Self::Raised,
        Self::Returned,
        Self::Acknowledged,
        Self::TakenOutOfService,
        Self::ReturnedToService,
        Self::Removed,
    ];

    /// As it stands in the history.
    #[must_use]
    pub const fn word(self) -> &'static str {
        match self {
            Self::Raised => "raised",
            Self::Returned => "returned",
            Self::Acknowledged => "acknowledged",
            Self::TakenOutOfService => "taken-out-of-service",
            Self::ReturnedToService => "returned-to-service",
            Self::Removed => "removed",
        }
    }
}

/// One line of the history.
#[derive(Clone, Debug, PartialEq)]
pub struct AlarmChange {
    /// When, on the wall.
    pub at: Micros,
    /// The alarm as it is meant.
    pub rule: Rule,
    /// What happened.
    pub what: ChangeKind,
    /// Who did it; nothing if it came by itself.
    pub who: Option<String>,
    /// The value at that time.
    pub value: Option<f64>,
    /// A sentence.
    pub text: String,
    /// Where it stood before.
    pub was: AlarmState,
    /// What has become of it.
    pub status: AlarmStatus,
}

/// Why something is not done.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum AlarmError {
    /// There is no such alarm.
    #[error("there is no alarm {0:?}")]
    Unknown(String),
    /// It is not the one that somebody saw.
    #[error(
        "{name} was raised again since: expected occurrence {occurrence}, got {got}; look at it before you acknowledge it"
    )]
    OccurrenceChanged {
        /// The alarm.
        name: String,
        /// What it has.
        occurrence: i64,
        /// What came.
        got: i64,
    },
    /// There is nothing of the kind to be done.
    #[error("{name} is {state}{by}", state = state.word(), by = by.as_ref().map(|who| format!(" by {who} already")).unwrap_or_default())]
    NotApplicable {
        /// The alarm.
        name: String,
        /// Where it stands.
        state: AlarmState,
        /// Who did it before.
        by: Option<String>,
    },
}

/// An alarm.
#[derive(Clone, Debug)]
pub struct RegisteredAlarm {
    rule: Rule,
    status: AlarmStatus,
    evaluator: Evaluator,
    /// Whether its condition holds, delays counted.
    is_active: bool,
    /// Since when it is known to be otherwise, on the steady clock.
    differs_since: Option<Micros>,
    /// When it comes back into service, on the steady clock.
    returns_at: Option<Micros>,
    /// The value now.
    value: Option<f64>,
}

impl RegisteredAlarm {
    fn new(rule: Rule, life: AlarmStatus, now: AlarmTime) -> Self {
        let stands = life.state.is_active();
        let until = life.out.as_ref().and_then(|out| out.until);
        let back = until.map(|until| Micros(now.monotonic.0.saturating_add(until.0.saturating_sub(now.wall.0))));
        Self {
            rule,
            status: life,
            evaluator: Evaluator::default(),
            is_active: stands,
            differs_since: None,
            returns_at: back,
            value: None,
        }
    }

    /// As it is meant.
    #[must_use]
    pub const fn rule(&self) -> &Rule {
        &self.rule
    }

    /// What has become of it.
    #[must_use]
    pub const fn status(&self) -> &AlarmStatus {
        &self.status
    }

    /// The value now, if there is one.
    #[must_use]
    pub const fn value(&self) -> Option<f64> {
        self.value
    }

    /// Other words for the same alarm. Where another condition is meant, what it knew of the past is forgotten.
    fn reconfigure(&mut self, rule: Rule) {
        if (&self.rule.condition, &self.rule.subject) != (&rule.condition, &rule.subject) {
            self.evaluator = Evaluator::default();
            self.differs_since = None;
        }
        self.rule = rule;
    }

    fn evaluate(&mut self, sight: &Inputs, now: AlarmTime) -> Vec<AlarmChange> {
        let finding = self.evaluator.evaluate(&self.rule, self.is_active, sight, now.monotonic);
        self.value = finding.value;
        self.apply_delays(finding.holds, now.monotonic);
        let back =
            self.returns_at.filter(|back| *back <= now.monotonic).and_then(|_| self.return_to_service(None, now).ok());
        let input = if self.is_active { Input::ConditionMet } else { Input::ConditionCleared };
        let led = self.status.state.after(input).map(|state| self.raise_or_return(state, finding, now));
        back.into_iter().chain(led).collect()
    }

    /// On-delay and off-delay. What is not known neither begins nor ends one: between two readings that agree nothing else is assumed.
    fn apply_delays(&mut self, holds: Option<bool>, steady: Micros) {
        match holds {
            None => {}
            Some(holds) if holds == self.is_active => self.differs_since = None,
            Some(holds) => {
                let since = *self.differs_since.get_or_insert(steady);
                let delay = if holds { self.rule.delay } else { self.rule.off_delay };
                if since.after(delay) <= steady {
                    self.is_active = holds;
                    self.differs_since = None;
                }
            }
        }
    }

    /// It was raised, or is over.
    fn raise_or_return(&mut self, state: AlarmState, finding: Evaluation, now: AlarmTime) -> AlarmChange {
        let Evaluation { value, text, .. } = finding;
        if state == AlarmState::Unacknowledged {
            let occurrence = now.wall.0.div_euclid(1000).max(self.status.occurrence.saturating_add(1));
            let raised = Some(now.wall);
            let was = self.status.state;
            self.status =
                AlarmStatus { state: was, occurrence, raised, value, text: text.clone(), ..AlarmStatus::default() };
            self.change(ChangeKind::Raised, state, None, text, now)
        } else {
            self.change(ChangeKind::Returned, state, None, text, now)
        }
    }

    fn acknowledge(&mut self, occurrence: i64, who: &str, now: AlarmTime) -> Result<AlarmChange, AlarmError> {
        let AlarmStatus { state, occurrence: own, .. } = self.status;
        // Who has seen another occurrence has seen another alarm.
        if occurrence != own {
            return Err(AlarmError::OccurrenceChanged {
                name: self.rule.name.clone(),
                occurrence: own,
                got: occurrence,
            });
        }
        let next = state.after(Input::Acknowledge).ok_or_else(|| self.not_applicable())?;
        self.status.acknowledged = Some(Attribution { user: who.to_owned(), at: now.wall });
        Ok(self.change(ChangeKind::Acknowledged, next, Some(who), String::new(), now))
    }

    fn take_out_of_service(
        &mut self,
        by: &str,
        reason: &str,
        time: Option<Duration>,
        now: AlarmTime,
    ) -> Result<AlarmChange, AlarmError> {
        let next = self.status.state.after(Input::TakeOutOfService).ok_or_else(|| self.not_applicable())?;
        let until = time.map(|time| now.wall.after(time));
        self.returns_at = time.map(|time| now.monotonic.after(time));
        let was = self.status.state.word();
        self.status.out = Some(OutOfService {
            by: Attribution { user: by.to_owned(), at: now.wall },
            reason: reason.to_owned(),
            until,
        });
        Ok(self.change(ChangeKind::TakenOutOfService, next, Some(by), format!("{reason} (it was {was})"), now))
    }

    fn return_to_service(&mut self, who: Option<&str>, now: AlarmTime) -> Result<AlarmChange, AlarmError> {
        let next = self.status.state.after(Input::ReturnToService).ok_or_else(|| self.not_applicable())?;
        self.returns_at = None;
        self.status.out = None;
        let text = if who.is_some() { "" } else { "its time is over" };
        Ok(self.change(ChangeKind::ReturnedToService, next, who, text.to_owned(), now))
    }

    fn not_applicable(&self) -> AlarmError {
        let AlarmStatus { state, acknowledged, out, .. } = &self.status;
        let by = match state {
            AlarmState::Acknowledged => acknowledged.as_ref(),
            AlarmState::OutOfService => out.as_ref().map(|out| &out.by),
            _ => None,
        };
        AlarmError::NotApplicable { name: self.rule.name.clone(), state: *state, by: by.map(|by| by.user.clone()) }
    }

    fn change(
        &mut self,
        what: ChangeKind,
        state: AlarmState,
        who: Option<&str>,
        text: String,
        now: AlarmTime,
    ) -> AlarmChange {
        let was = std::mem::replace(&mut self.status.state, state);
        self.status.since = now.wall;
        AlarmChange {
            at: now.wall,
            rule: self.rule.clone(),
            what,
            who: who.map(str::to_owned),
            value: self.value,
            text,
            was,
            status: self.status.clone(),
        }
    }
}

/// All alarms, in the order of the file.
#[derive(Clone, Debug, Default)]
pub struct AlarmRegistry {
    entries: Vec<RegisteredAlarm>,
}

impl AlarmRegistry {
    /// All of them.
    #[must_use]
    pub fn entries(&self) -> &[RegisteredAlarm] {
        &self.entries
    }

    /// Becomes what the file says. What has become of an alarm goes with its name: from here, or from `kept` at the beginning. An alarm
    /// that is not meant any more and was not normal leaves a line in the history.
    pub fn reconfigure(
        &mut self,
        rules: Vec<Rule>,
        mut kept: Vec<(String, AlarmStatus)>,
        now: AlarmTime,
    ) -> Vec<AlarmChange> {
        let mut old = std::mem::take(&mut self.entries);
        for rule in rules {
            let here = old.iter().position(|entry| entry.rule.name == rule.name);
            let there = kept.iter().position(|(name, _)| *name == rule.name);
            self.entries.push(match (here, there) {
                (Some(place), _) => {
                    let mut entry = old.remove(place);
                    entry.reconfigure(rule);
                    entry
                }
                (None, Some(place)) => RegisteredAlarm::new(rule, kept.swap_remove(place).1, now),
                (None, None) => {
                    RegisteredAlarm::new(rule, AlarmStatus { since: now.wall, ..AlarmStatus::default() }, now)
                }
            });
        }
        let removed = |mut entry: RegisteredAlarm| {
            let text = format!("it does not stand in the file any more (it was {})", entry.status.state.word());
            entry.change(ChangeKind::Removed, AlarmState::Normal, None, text, now)
        };
        old.into_iter().filter(|entry| entry.status.state != AlarmState::Normal).map(removed).collect()
    }

    /// Looks at the plant.
    pub fn evaluate(&mut self, sight: &Inputs, now: AlarmTime) -> Vec<AlarmChange> {
        self.entries.iter_mut().flat_map(|entry| entry.evaluate(sight, now)).collect()
    }

    /// Somebody has seen this occurrence of an alarm.
    ///
    /// # Errors
    /// [`Refusal`] if there is none, if it is another one by now, or if it was acknowledged already.
    pub fn acknowledge(
        &mut self,
        name: &str,
        occurrence: i64,
        who: &str,
        now: AlarmTime,
    ) -> Result<AlarmChange, AlarmError> {
        self.entry(name)?.acknowledge(occurrence, who, now)
    }

    /// Somebody takes an alarm out of service, for a time or until somebody puts it back.
    ///
    /// # Errors
    /// [`Refusal`] if there is none, or if it is out of service already.
    pub fn take_out_of_service(
        &mut self,
        name: &str,
        who: &str,
        reason: &str,
        time: Option<Duration>,
        now: AlarmTime,
    ) -> Result<AlarmChange, AlarmError> {
        self.entry(name)?.take_out_of_service(who, reason, time, now)
    }

    /// Somebody puts an alarm back into service. If its condition holds, it is raised with the next look.
    ///
    /// # Errors
    /// [`Refusal`] if there is none, or if it is in service.
    pub fn return_to_service(&mut self, name: &str, who: &str, now: AlarmTime) -> Result<AlarmChange, AlarmError> {
        self.entry(name)?.return_to_service(Some(who), now)
    }

    fn entry(&mut self, name: &str) -> Result<&mut RegisteredAlarm, AlarmError> {
        let entry = self.entries.iter_mut().find(|entry| entry.rule.name == name);
        entry.ok_or_else(|| AlarmError::Unknown(name.to_owned()))
    }
}
