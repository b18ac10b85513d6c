//! All alarms of a station, without clock, thread and disk: the caller passes the time, and gets the changes.
//!
//! Two times come in. Delays and ends are counted on the monotonic time. The wall-clock time is stored and shown.

use super::evaluate::{Evaluation, Evaluator, Inputs};
use super::plant_state::PlantStates;
use super::rule::Rule;
use super::suppression::AlarmTime;
use profivac_model::{AlarmChangeKind, AlarmInput, AlarmState, AlarmStatus, Attribution, Micros, Suppression};
use std::time::Duration;

/// A change of an alarm.
#[derive(Clone, Debug, PartialEq)]
pub struct AlarmChange {
    /// The wall-clock time.
    pub at: Micros,
    /// The rule of the alarm.
    pub rule: Rule,
    /// The kind of the change.
    pub kind: AlarmChangeKind,
    /// The user who made it; `None` if the station did.
    pub user: Option<String>,
    /// The value at that time.
    pub value: Option<f64>,
    /// A sentence.
    pub text: String,
    /// The state before.
    pub was: AlarmState,
    /// The status after.
    pub status: AlarmStatus,
}

/// The reason why a user cannot change an alarm.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum AlarmError {
    /// No alarm has this name.
    #[error("there is no alarm {0:?}")]
    Unknown(String),
    /// The alarm was raised again since the user saw it.
    #[error(
        "{name} has another occurrence: expected {occurrence}, got {got}; look at the alarm before you acknowledge it"
    )]
    OccurrenceChanged {
        /// The alarm.
        name: String,
        /// Its last occurrence.
        occurrence: i64,
        /// The occurrence in the request.
        got: i64,
    },
    /// The change makes no sense in this state.
    #[error("{name} is {state}{by}", state = state.operator_words(), by = by.as_ref().map(|user| format!(" by {user} already")).unwrap_or_default())]
    NotApplicable {
        /// The alarm.
        name: String,
        /// Its state.
        state: AlarmState,
        /// The user who made the change before.
        by: Option<String>,
    },
}

/// An alarm with its rule and its status.
#[derive(Clone, Debug)]
pub struct RegisteredAlarm {
    rule: Rule,
    status: AlarmStatus,
    evaluator: Evaluator,
    /// Whether the condition is met, after the delays.
    is_active: bool,
    /// Since when the condition is known to differ from `is_active`, in monotonic time.
    differs_since: Option<Micros>,
    /// When it is unshelved or returns to service, in monotonic time.
    returns_at: Option<Micros>,
    /// Whether it was unshelved, returned to service or unsuppressed since the last evaluation.
    has_resumed: bool,
    /// The present value.
    value: Option<f64>,
}

impl RegisteredAlarm {
    fn new(rule: Rule, status: AlarmStatus, now: AlarmTime) -> Self {
        let is_active = status.state.is_active();
        // The plant state that suppresses an alarm has the end.
        let own = status.suppression.as_ref().filter(|_| status.state != AlarmState::Suppressed);
        let until = own.and_then(|it| it.until);
        let taken = status.suppression.as_ref().map_or(now.wall, |it| it.by.at);
        // A clock that was set back since does not suppress it for longer than the user asked for.
        let remaining = |until: Micros| until.0.saturating_sub(now.wall.0).min(until.0.saturating_sub(taken.0));
        let returns_at = until.map(|until| Micros(now.monotonic.0.saturating_add(remaining(until))));
        Self {
            rule,
            status,
            evaluator: Evaluator::default(),
            is_active,
            differs_since: None,
            returns_at,
            has_resumed: false,
            value: None,
        }
    }

    /// The rule.
    #[must_use]
    pub const fn rule(&self) -> &Rule {
        &self.rule
    }

    /// The status.
    #[must_use]
    pub const fn status(&self) -> &AlarmStatus {
        &self.status
    }

    /// The present value, if there is one.
    #[must_use]
    pub const fn value(&self) -> Option<f64> {
        self.value
    }

    /// Applies a changed rule. Another condition starts without a past.
    fn reconfigure(&mut self, rule: Rule) {
        if self.rule.condition != rule.condition {
            self.evaluator = Evaluator::default();
            self.differs_since = None;
        }
        self.rule = rule;
    }

    /// `suppression` is that of a declared plant state.
    ///
    /// The off-delay does not keep an alarm that is no longer suppressed, shelved or out of service: a user would get an alarm for a
    /// pressure that is good again.
    fn evaluate(&mut self, inputs: &Inputs, suppression: Option<&Suppression>, now: AlarmTime) -> Vec<AlarmChange> {
        let is_due = self.returns_at.is_some_and(|at| at <= now.monotonic);
        let is_unsuppressed = suppression.is_none() && self.status.state == AlarmState::Suppressed;
        let resumes = std::mem::take(&mut self.has_resumed) || is_due || is_unsuppressed;
        let evaluation = self.evaluator.evaluate(&self.rule, self.is_active, inputs, now.monotonic);
        self.value = evaluation.value;
        if resumes && evaluation.holds == Some(false) {
            self.is_active = false;
        }
        self.apply_delays(evaluation.holds, now.monotonic);
        let returned = is_due.then(|| self.end_suppression(None, now).ok()).flatten();
        let suppressed = self.apply_plant_state(suppression, now);
        self.has_resumed = false;
        let input = if self.is_active { AlarmInput::ConditionMet } else { AlarmInput::ConditionCleared };
        let next = self.status.state.after(input).map(|state| self.raise_or_return(state, evaluation, now));
        returned.into_iter().chain(suppressed).chain(next).collect()
    }

    /// Suppresses the alarm while a plant state does. Its condition is evaluated meanwhile, so that an alarm whose condition is met at the
    /// end is raised at once, with an occurrence of its own.
    fn apply_plant_state(&mut self, suppression: Option<&Suppression>, now: AlarmTime) -> Option<AlarmChange> {
        let Some(wanted) = suppression else {
            let next = self.status.state.after(AlarmInput::Unsuppress)?;
            self.status.suppression = None;
            self.has_resumed = true;
            return Some(self.change(AlarmChangeKind::Unsuppressed, next, None, String::new(), now));
        };
        if self.status.state == AlarmState::Suppressed {
            // An extended declaration, or another one, is no change of the alarm.
            if self.status.suppression.as_ref() != Some(wanted) {
                self.status.suppression = Some(wanted.clone());
            }
            return None;
        }
        let next = self.status.state.after(AlarmInput::Suppress)?;
        let was = self.status.state.operator_words();
        self.status.suppression = Some(wanted.clone());
        let text = format!("{} (it was {was})", wanted.reason);
        Some(self.change(AlarmChangeKind::Suppressed, next, None, text, now))
    }

    /// Applies on-delay and off-delay. An unknown condition neither starts nor ends a delay: between two evaluations that agree the
    /// condition is assumed to stay.
    fn apply_delays(&mut self, holds: Option<bool>, now: Micros) {
        match holds {
            None => {}
            Some(holds) if holds == self.is_active => self.differs_since = None,
            Some(holds) => {
                let since = *self.differs_since.get_or_insert(now);
                let delay = if holds { self.rule.delay } else { self.rule.off_delay };
                if since.after(delay) <= now {
                    self.is_active = holds;
                    self.differs_since = None;
                }
            }
        }
    }

    fn raise_or_return(&mut self, state: AlarmState, evaluation: Evaluation, now: AlarmTime) -> AlarmChange {
        let Evaluation { value, text, .. } = evaluation;
        if state != AlarmState::Unacknowledged {
            return self.change(AlarmChangeKind::Returned, state, None, text, now);
        }
        // The pressure may be unknown when a user returns an active alarm to service.
        let text = if text.is_empty() { "its condition was met when it was last known".to_owned() } else { text };
        let occurrence = now.wall.0.div_euclid(1000).max(self.status.occurrence.saturating_add(1));
        self.status = AlarmStatus {
            state: self.status.state,
            occurrence,
            raised: Some(now.wall),
            value,
            text: text.clone(),
            ..AlarmStatus::default()
        };
        self.change(AlarmChangeKind::Raised, state, None, text, now)
    }

    fn acknowledge(&mut self, occurrence: i64, user: &str, now: AlarmTime) -> Result<AlarmChange, AlarmError> {
        let AlarmStatus { state, occurrence: own, .. } = self.status;
        if occurrence != own {
            let name = self.rule.name.clone();
            return Err(AlarmError::OccurrenceChanged { name, occurrence: own, got: occurrence });
        }
        let next = state.after(AlarmInput::Acknowledge).ok_or_else(|| self.not_applicable())?;
        self.status.acknowledged = Some(Attribution { user: user.to_owned(), at: now.wall });
        Ok(self.change(AlarmChangeKind::Acknowledged, next, Some(user), String::new(), now))
    }

    fn suppress(
        &mut self,
        by: &SuppressedBy<'_>,
        time: Option<Duration>,
        now: AlarmTime,
    ) -> Result<AlarmChange, AlarmError> {
        let SuppressedBy { input, user, reason } = by;
        let next = self.status.state.after(*input).ok_or_else(|| self.not_applicable())?;
        let by = Attribution { user: (*user).to_owned(), at: now.wall };
        let until = time.map(|time| now.wall.after(time));
        self.returns_at = time.map(|time| now.monotonic.after(time));
        let was = self.status.state.operator_words();
        self.status.suppression = Some(Suppression { by, reason: (*reason).to_owned(), until });
        let kind =
            if next == AlarmState::Shelved { AlarmChangeKind::Shelved } else { AlarmChangeKind::TakenOutOfService };
        Ok(self.change(kind, next, Some(user), format!("{reason} (it was {was})"), now))
    }

    /// Unshelves the alarm, or returns it to service.
    fn end_suppression(&mut self, user: Option<&str>, now: AlarmTime) -> Result<AlarmChange, AlarmError> {
        match self.status.state {
            AlarmState::Shelved => self.unshelve(user, now),
            _ => self.return_to_service(user, now),
        }
    }

    fn unshelve(&mut self, user: Option<&str>, now: AlarmTime) -> Result<AlarmChange, AlarmError> {
        self.resume(AlarmInput::Unshelve, AlarmChangeKind::Unshelved, (user, "its time on the shelf is over"), now)
    }

    fn return_to_service(&mut self, user: Option<&str>, now: AlarmTime) -> Result<AlarmChange, AlarmError> {
        self.resume(
            AlarmInput::ReturnToService,
            AlarmChangeKind::ReturnedToService,
            (user, "its time out of service is over"),
            now,
        )
    }

    /// `over` is the sentence if no user makes the change.
    fn resume(
        &mut self,
        input: AlarmInput,
        kind: AlarmChangeKind,
        (user, over): (Option<&str>, &str),
        now: AlarmTime,
    ) -> Result<AlarmChange, AlarmError> {
        let next = self.status.state.after(input).ok_or_else(|| self.not_applicable())?;
        self.returns_at = None;
        self.has_resumed = true;
        self.status.suppression = None;
        let text = if user.is_some() { "" } else { over };
        Ok(self.change(kind, next, user, text.to_owned(), now))
    }

    fn not_applicable(&self) -> AlarmError {
        let AlarmStatus { state, acknowledged, suppression, .. } = &self.status;
        let by = match state {
            AlarmState::Acknowledged => acknowledged.as_ref(),
            AlarmState::Shelved | AlarmState::OutOfService | AlarmState::Suppressed => {
                suppression.as_ref().map(|it| &it.by)
            }
            _ => None,
        };
        AlarmError::NotApplicable { name: self.rule.name.clone(), state: *state, by: by.map(|by| by.user.clone()) }
    }

    fn change(
        &mut self,
        kind: AlarmChangeKind,
        state: AlarmState,
        user: Option<&str>,
        text: String,
        now: AlarmTime,
    ) -> AlarmChange {
        let was = std::mem::replace(&mut self.status.state, state);
        self.status.since = now.wall;
        AlarmChange {
            at: now.wall,
            rule: self.rule.clone(),
            kind,
            user: user.map(str::to_owned),
            value: self.value,
            text,
            was,
            status: self.status.clone(),
        }
    }
}

/// The user who suppresses an alarm, how and why.
struct SuppressedBy<'a> {
    /// [`AlarmInput::Shelve`] or [`AlarmInput::TakeOutOfService`].
    input: AlarmInput,
    user: &'a str,
    reason: &'a str,
}

/// All alarms, in the order of the station's file.
#[derive(Clone, Debug, Default)]
pub struct AlarmRegistry {
    alarms: Vec<RegisteredAlarm>,
    plant_states: PlantStates,
}

impl AlarmRegistry {
    /// All alarms.
    #[must_use]
    pub fn alarms(&self) -> &[RegisteredAlarm] {
        &self.alarms
    }

    /// All plant states.
    #[must_use]
    pub const fn plant_states(&self) -> &PlantStates {
        &self.plant_states
    }

    /// All plant states, to declare and end them. [`Self::suppress`] applies a change to the alarms.
    pub const fn plant_states_mut(&mut self) -> &mut PlantStates {
        &mut self.plant_states
    }

    /// Suppresses the alarms of declared plant states, and those of ended ones no longer; [`Self::evaluate`] does the same. If the
    /// condition of an alarm is met, the next evaluation raises it.
    pub fn suppress(&mut self, now: AlarmTime) -> Vec<AlarmChange> {
        let Self { alarms, plant_states } = self;
        let suppress = |alarm: &mut RegisteredAlarm| {
            let suppression = plant_states.suppression_of(&alarm.rule.name);
            alarm.apply_plant_state(suppression, now)
        };
        alarms.iter_mut().filter_map(suppress).collect()
    }

    /// Applies the rules of a file. An alarm keeps its status by its name, from here or, at the start, from `stored`. An alarm that
    /// is removed and was not normal gives a change.
    pub fn reconfigure(
        &mut self,
        rules: Vec<Rule>,
        mut stored: Vec<(String, AlarmStatus)>,
        now: AlarmTime,
    ) -> Vec<AlarmChange> {
        let mut old = std::mem::take(&mut self.alarms);
        for rule in rules {
            let present = old.iter().position(|alarm| alarm.rule.name == rule.name);
            let known = stored.iter().position(|(name, _)| *name == rule.name);
            self.alarms.push(match (present, known) {
                (Some(index), _) => {
                    let mut alarm = old.remove(index);
                    alarm.reconfigure(rule);
                    alarm
                }
                (None, Some(index)) => RegisteredAlarm::new(rule, stored.swap_remove(index).1, now),
                (None, None) => {
                    RegisteredAlarm::new(rule, AlarmStatus { since: now.wall, ..AlarmStatus::default() }, now)
                }
            });
        }
        let removed = |mut alarm: RegisteredAlarm| {
            let text = removed_text(alarm.status.state);
            alarm.change(AlarmChangeKind::Removed, AlarmState::Normal, None, text, now)
        };
        old.into_iter().filter(|alarm| alarm.status.state != AlarmState::Normal).map(removed).collect()
    }

    /// Evaluates all alarms.
    pub fn evaluate(&mut self, inputs: &Inputs, now: AlarmTime) -> Vec<AlarmChange> {
        let Self { alarms, plant_states } = self;
        let evaluate = |alarm: &mut RegisteredAlarm| {
            let suppression = plant_states.suppression_of(&alarm.rule.name);
            alarm.evaluate(inputs, suppression, now)
        };
        alarms.iter_mut().flat_map(evaluate).collect()
    }

    /// Acknowledges an occurrence of an alarm.
    ///
    /// # Errors
    /// [`AlarmError`] if there is no such alarm, if it was raised again since, or if it is acknowledged already.
    pub fn acknowledge(
        &mut self,
        name: &str,
        occurrence: i64,
        user: &str,
        now: AlarmTime,
    ) -> Result<AlarmChange, AlarmError> {
        self.alarm(name)?.acknowledge(occurrence, user, now)
    }

    /// Takes an alarm out of service, for a time or until a user returns it.
    ///
    /// # Errors
    /// [`AlarmError`] if there is no such alarm, or if it is out of service already.
    pub fn take_out_of_service(
        &mut self,
        name: &str,
        user: &str,
        reason: &str,
        time: Option<Duration>,
        now: AlarmTime,
    ) -> Result<AlarmChange, AlarmError> {
        self.alarm(name)?.suppress(&SuppressedBy { input: AlarmInput::TakeOutOfService, user, reason }, time, now)
    }

    /// Shelves an alarm for a time.
    ///
    /// # Errors
    /// [`AlarmError`] if there is no such alarm, or if it is shelved or out of service.
    pub fn shelve(
        &mut self,
        name: &str,
        user: &str,
        reason: &str,
        time: Duration,
        now: AlarmTime,
    ) -> Result<AlarmChange, AlarmError> {
        self.alarm(name)?.suppress(&SuppressedBy { input: AlarmInput::Shelve, user, reason }, Some(time), now)
    }

    /// Unshelves an alarm. If its condition is met, the next evaluation raises it.
    ///
    /// # Errors
    /// [`AlarmError`] if there is no such alarm, or if it is not shelved.
    pub fn unshelve(&mut self, name: &str, user: &str, now: AlarmTime) -> Result<AlarmChange, AlarmError> {
        self.alarm(name)?.unshelve(Some(user), now)
    }

    /// Returns an alarm to service. If its condition is met, the next evaluation raises it.
    ///
    /// # Errors
    /// [`AlarmError`] if there is no such alarm, or if it is in service.
    pub fn return_to_service(&mut self, name: &str, user: &str, now: AlarmTime) -> Result<AlarmChange, AlarmError> {
        self.alarm(name)?.return_to_service(Some(user), now)
    }

    fn alarm(&mut self, name: &str) -> Result<&mut RegisteredAlarm, AlarmError> {
        let alarm = self.alarms.iter_mut().find(|alarm| alarm.rule.name == name);
        alarm.ok_or_else(|| AlarmError::Unknown(name.to_owned()))
    }
}

/// The sentence about an alarm that the station's file no longer has.
pub fn removed_text(state: AlarmState) -> String {
    format!("the station's file no longer has it (it was {})", state.operator_words())
}
