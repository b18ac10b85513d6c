//! All alarms of a station: pure, with neither clock nor thread nor disk. What is told to it comes with the time.
//!
//! Two times come in. `steady` is of a clock that nobody sets: delays and ends are counted on it. `at` is what the clock on the wall
//! shows: it is written down.

use super::judge::{Finding, Judge, Sight};
use super::rule::Rule;
use super::state::{Input, State};
use profivac_recorder::Micros;
use std::time::Duration;

/// When something happens.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Now {
    /// On a clock that nobody sets.
    pub steady: Micros,
    /// On the wall.
    pub at: Micros,
}

/// Who did something, and when.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct By {
    /// Their name.
    pub who: String,
    /// When, on the wall.
    pub at: Micros,
}

/// Why it is out of service.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Out {
    /// Who took it away.
    pub by: By,
    /// Why.
    pub reason: String,
    /// When it comes back by itself, on the wall.
    pub until: Option<Micros>,
}

/// What has become of an alarm: all that must survive the end of the program.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Life {
    /// Where it stands.
    pub state: State,
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
    pub acknowledged: Option<By>,
    /// Why it is out of service.
    pub out: Option<Out>,
}

/// What happened to an alarm.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum What {
    /// It was raised.
    Raised,
    /// Its condition does not hold any more.
    Returned,
    /// Somebody knows.
    Acknowledged,
    /// It was taken out of service.
    TakenOut,
    /// It was put back into service.
    PutBack,
    /// It does not stand in the file any more.
    Removed,
}

impl What {
    /// All of them.
    pub const ALL: [Self; 6] =
        [Self::Raised, Self::Returned, Self::Acknowledged, Self::TakenOut, Self::PutBack, Self::Removed];

    /// As it stands in the history.
    #[must_use]
    pub const fn word(self) -> &'static str {
        match self {
            Self::Raised => "raised",
            Self::Returned => "returned",
            Self::Acknowledged => "acknowledged",
            Self::TakenOut => "taken-out-of-service",
            Self::PutBack => "returned-to-service",
            Self::Removed => "removed",
        }
    }
}

/// One line of the history.
#[derive(Clone, Debug, PartialEq)]
pub struct Change {
    /// When, on the wall.
    pub at: Micros,
    /// The alarm as it is meant.
    pub rule: Rule,
    /// What happened.
    pub what: What,
    /// Who did it; nothing if it came by itself.
    pub who: Option<String>,
    /// The value at that time.
    pub value: Option<f64>,
    /// A sentence.
    pub text: String,
    /// Where it stood before.
    pub was: State,
    /// What has become of it.
    pub life: Life,
}

/// Why something is not done.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum Refusal {
    /// There is no such alarm.
    #[error("there is no alarm {0:?}")]
    Unknown(String),
    /// It is not the one that somebody saw.
    #[error(
        "{name} was raised again since: expected occurrence {occurrence}, got {got}; look at it before you acknowledge it"
    )]
    Changed {
        /// The alarm.
        name: String,
        /// What it has.
        occurrence: i64,
        /// What came.
        got: i64,
    },
    /// There is nothing of the kind to be done.
    #[error("{name} is {state}{by}", state = state.word(), by = by.as_ref().map(|who| format!(" by {who} already")).unwrap_or_default())]
    Idle {
        /// The alarm.
        name: String,
        /// Where it stands.
        state: State,
        /// Who did it before.
        by: Option<String>,
    },
}

/// An alarm.
#[derive(Clone, Debug)]
pub struct Entry {
    rule: Rule,
    life: Life,
    judge: Judge,
    /// Whether its condition holds, delays counted.
    stands: bool,
    /// Since when it is known to be otherwise, on the steady clock.
    otherwise: Option<Micros>,
    /// When it comes back into service, on the steady clock.
    back: Option<Micros>,
    /// The value now.
    value: Option<f64>,
}

impl Entry {
    fn new(rule: Rule, life: Life, now: Now) -> Self {
        let stands = life.state.is_active();
        let until = life.out.as_ref().and_then(|out| out.until);
        let back = until.map(|until| Micros(now.steady.0.saturating_add(until.0.saturating_sub(now.at.0))));
        Self { rule, life, judge: Judge::default(), stands, otherwise: None, back, value: None }
    }

    /// As it is meant.
    #[must_use]
    pub const fn rule(&self) -> &Rule {
        &self.rule
    }

    /// What has become of it.
    #[must_use]
    pub const fn life(&self) -> &Life {
        &self.life
    }

    /// The value now, if there is one.
    #[must_use]
    pub const fn value(&self) -> Option<f64> {
        self.value
    }

    /// Other words for the same alarm. Where another condition is meant, what it knew of the past is forgotten.
    fn become_like(&mut self, rule: Rule) {
        if (&self.rule.condition, &self.rule.subject) != (&rule.condition, &rule.subject) {
            self.judge = Judge::default();
            self.otherwise = None;
        }
        self.rule = rule;
    }

    fn look(&mut self, sight: &Sight, now: Now) -> Vec<Change> {
        let finding = self.judge.look(&self.rule, self.stands, sight, now.steady);
        self.value = finding.value;
        self.settle(finding.holds, now.steady);
        let back = self.back.filter(|back| *back <= now.steady).and_then(|_| self.put_back(None, now).ok());
        let input = if self.stands { Input::Stands } else { Input::Cleared };
        let led = self.life.state.after(input).map(|state| self.led(state, finding, now));
        back.into_iter().chain(led).collect()
    }

    /// On-delay and off-delay. What is not known neither begins nor ends one: between two readings that agree nothing else is assumed.
    fn settle(&mut self, holds: Option<bool>, steady: Micros) {
        match holds {
            None => {}
            Some(holds) if holds == self.stands => self.otherwise = None,
            Some(holds) => {
                let since = *self.otherwise.get_or_insert(steady);
                let delay = if holds { self.rule.delay } else { self.rule.off_delay };
                if since.after(delay) <= steady {
                    self.stands = holds;
                    self.otherwise = None;
                }
            }
        }
    }

    /// It was raised, or is over.
    fn led(&mut self, state: State, finding: Finding, now: Now) -> Change {
        let Finding { value, text, .. } = finding;
        if state == State::Unacknowledged {
            let occurrence = now.at.0.div_euclid(1000).max(self.life.occurrence.saturating_add(1));
            let raised = Some(now.at);
            let was = self.life.state;
            self.life = Life { state: was, occurrence, raised, value, text: text.clone(), ..Life::default() };
            self.change(What::Raised, state, None, text, now)
        } else {
            self.change(What::Returned, state, None, text, now)
        }
    }

    fn acknowledge(&mut self, occurrence: i64, who: &str, now: Now) -> Result<Change, Refusal> {
        let Life { state, occurrence: own, .. } = self.life;
        // Who has seen another occurrence has seen another alarm.
        if occurrence != own {
            return Err(Refusal::Changed { name: self.rule.name.clone(), occurrence: own, got: occurrence });
        }
        let next = state.after(Input::Acknowledge).ok_or_else(|| self.idle())?;
        self.life.acknowledged = Some(By { who: who.to_owned(), at: now.at });
        Ok(self.change(What::Acknowledged, next, Some(who), String::new(), now))
    }

    fn take_out(&mut self, by: &str, reason: &str, time: Option<Duration>, now: Now) -> Result<Change, Refusal> {
        let next = self.life.state.after(Input::TakeOut).ok_or_else(|| self.idle())?;
        let until = time.map(|time| now.at.after(time));
        self.back = time.map(|time| now.steady.after(time));
        let was = self.life.state.word();
        self.life.out = Some(Out { by: By { who: by.to_owned(), at: now.at }, reason: reason.to_owned(), until });
        Ok(self.change(What::TakenOut, next, Some(by), format!("{reason} (it was {was})"), now))
    }

    fn put_back(&mut self, who: Option<&str>, now: Now) -> Result<Change, Refusal> {
        let next = self.life.state.after(Input::PutBack).ok_or_else(|| self.idle())?;
        self.back = None;
        self.life.out = None;
        let text = if who.is_some() { "" } else { "its time is over" };
        Ok(self.change(What::PutBack, next, who, text.to_owned(), now))
    }

    fn idle(&self) -> Refusal {
        let Life { state, acknowledged, out, .. } = &self.life;
        let by = match state {
            State::Acknowledged => acknowledged.as_ref(),
            State::OutOfService => out.as_ref().map(|out| &out.by),
            _ => None,
        };
        Refusal::Idle { name: self.rule.name.clone(), state: *state, by: by.map(|by| by.who.clone()) }
    }

    fn change(&mut self, what: What, state: State, who: Option<&str>, text: String, now: Now) -> Change {
        let was = std::mem::replace(&mut self.life.state, state);
        self.life.since = now.at;
        Change {
            at: now.at,
            rule: self.rule.clone(),
            what,
            who: who.map(str::to_owned),
            value: self.value,
            text,
            was,
            life: self.life.clone(),
        }
    }
}

/// All alarms, in the order of the file.
#[derive(Clone, Debug, Default)]
pub struct Book {
    entries: Vec<Entry>,
}

impl Book {
    /// All of them.
    #[must_use]
    pub fn entries(&self) -> &[Entry] {
        &self.entries
    }

    /// Becomes what the file says. What has become of an alarm goes with its name: from here, or from `kept` at the beginning. An alarm
    /// that is not meant any more and was not normal leaves a line in the history.
    pub fn become_like(&mut self, rules: Vec<Rule>, mut kept: Vec<(String, Life)>, now: Now) -> Vec<Change> {
        let mut old = std::mem::take(&mut self.entries);
        for rule in rules {
            let here = old.iter().position(|entry| entry.rule.name == rule.name);
            let there = kept.iter().position(|(name, _)| *name == rule.name);
            self.entries.push(match (here, there) {
                (Some(place), _) => {
                    let mut entry = old.remove(place);
                    entry.become_like(rule);
                    entry
                }
                (None, Some(place)) => Entry::new(rule, kept.swap_remove(place).1, now),
                (None, None) => Entry::new(rule, Life { since: now.at, ..Life::default() }, now),
            });
        }
        let removed = |mut entry: Entry| {
            let text = format!("it does not stand in the file any more (it was {})", entry.life.state.word());
            entry.change(What::Removed, State::Normal, None, text, now)
        };
        old.into_iter().filter(|entry| entry.life.state != State::Normal).map(removed).collect()
    }

    /// Looks at the plant.
    pub fn look(&mut self, sight: &Sight, now: Now) -> Vec<Change> {
        self.entries.iter_mut().flat_map(|entry| entry.look(sight, now)).collect()
    }

    /// Somebody has seen this occurrence of an alarm.
    ///
    /// # Errors
    /// [`Refusal`] if there is none, if it is another one by now, or if it was acknowledged already.
    pub fn acknowledge(&mut self, name: &str, occurrence: i64, who: &str, now: Now) -> Result<Change, Refusal> {
        self.entry(name)?.acknowledge(occurrence, who, now)
    }

    /// Somebody takes an alarm out of service, for a time or until somebody puts it back.
    ///
    /// # Errors
    /// [`Refusal`] if there is none, or if it is out of service already.
    pub fn take_out(
        &mut self,
        name: &str,
        who: &str,
        reason: &str,
        time: Option<Duration>,
        now: Now,
    ) -> Result<Change, Refusal> {
        self.entry(name)?.take_out(who, reason, time, now)
    }

    /// Somebody puts an alarm back into service. If its condition holds, it is raised with the next look.
    ///
    /// # Errors
    /// [`Refusal`] if there is none, or if it is in service.
    pub fn put_back(&mut self, name: &str, who: &str, now: Now) -> Result<Change, Refusal> {
        self.entry(name)?.put_back(Some(who), now)
    }

    fn entry(&mut self, name: &str) -> Result<&mut Entry, Refusal> {
        let entry = self.entries.iter_mut().find(|entry| entry.rule.name == name);
        entry.ok_or_else(|| Refusal::Unknown(name.to_owned()))
    }
}
