//! What is written down of alarms: rows of the record, events, letters to webhooks.

use super::book::{By, Change, Life, Out, What};
use super::rule::{Priority, Rule, Subject};
use super::state::State;
use crate::act::Actor;
use crate::view::milliseconds;
use profivac_recorder::alarms::{Batch, Kept, Letter, Line};
use profivac_recorder::{Deed, Entry, Event, EventKind};
use serde_json::json;

impl From<&Life> for Kept {
    fn from(life: &Life) -> Self {
        let Life { state, since, occurrence, raised, value, text, acknowledged, out } = life;
        Self {
            state: state.word().to_owned(),
            since: *since,
            occurrence: *occurrence,
            raised: *raised,
            value: *value,
            text: text.clone(),
            acknowledged: acknowledged.as_ref().map(|by| (by.who.clone(), by.at)),
            out: out.as_ref().map(|out| (out.by.who.clone(), out.by.at, out.reason.clone())),
            out_until: out.as_ref().and_then(|out| out.until),
        }
    }
}

impl From<Kept> for Life {
    /// A state that this program does not know is one that somebody must look at.
    fn from(kept: Kept) -> Self {
        let Kept { state, since, occurrence, raised, value, text, acknowledged, out, out_until } = kept;
        let state = State::from_word(&state).unwrap_or(State::Returned);
        let out = out.map(|(who, at, reason)| Out { by: By { who, at }, reason, until: out_until });
        let acknowledged = acknowledged.map(|(who, at)| By { who, at });
        Self { state, since, occurrence, raised, value, text, acknowledged, out }
    }
}

/// A webhook that is to be told of alarms from some priority on.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Addressee {
    /// The name of the webhook.
    pub hook: String,
    /// The lowest priority it is told of.
    pub least: Priority,
}

/// What is written of changes, and the events that tell them. What somebody did stands in the audit trail, too.
#[must_use]
pub fn written(changes: &[Change], by: Option<&Actor>, station: &str, addressees: &[Addressee]) -> (Batch, Vec<Event>) {
    let mut batch = Batch::default();
    for change in changes {
        batch.audit.extend(by.and_then(|actor| entry(change, actor)));
        let is_there = change.what != What::Removed;
        batch.kept.insert(change.rule.name.clone(), is_there.then(|| Kept::from(&change.life)));
        batch.lines.push(line(change));
        let told = addressees.iter().filter(|addressee| addressee.least <= change.rule.priority);
        let body = body(change, station);
        batch.letters.extend(told.map(|addressee| Letter {
            id: 0,
            hook: addressee.hook.clone(),
            at: change.at,
            body: body.clone(),
        }));
    }
    (batch, changes.iter().map(event).collect())
}

/// A row of the audit trail; nothing for what nobody does.
fn entry(change: &Change, actor: &Actor) -> Option<Entry> {
    let Change { at, rule, what, was, life, .. } = change;
    let deed = match what {
        What::Acknowledged => Deed::Acknowledged,
        What::TakenOut => Deed::TakenOut,
        What::PutBack => Deed::PutBack,
        What::Raised | What::Returned | What::Removed => return None,
    };
    let reason = life.out.as_ref().filter(|_| *what == What::TakenOut).map(|out| out.reason.clone());
    let gauge = rule.subject.gauge().map(str::to_owned);
    let (target, before, after) = (rule.name.clone(), was.word().to_owned(), life.state.word().to_owned());
    let row =
        Entry { at: *at, gauge, target: Some(target), before: Some(before), after: Some(after), ..actor.row(deed) };
    Some(Entry { outcome: reason, ..row })
}

fn line(change: &Change) -> Line {
    let Change { at, rule, what, who, value, text, life, .. } = change;
    Line {
        at: *at,
        alarm: rule.name.clone(),
        what: what.word().to_owned(),
        state: life.state.word().to_owned(),
        priority: rule.priority.word().to_owned(),
        subject: subject(rule).map(str::to_owned),
        occurrence: life.occurrence,
        who: who.clone(),
        value: *value,
        unit: rule.condition.unit().map(str::to_owned),
        text: text.clone(),
    }
}

fn subject(rule: &Rule) -> Option<&str> {
    match &rule.subject {
        Subject::Series { series, .. } => Some(series),
        Subject::Gauge(name) | Subject::Segment(name) => Some(name),
        Subject::Station => None,
    }
}

fn event(change: &Change) -> Event {
    let Change { at, rule, what, who, text, .. } = change;
    let by = who.as_ref().map(|who| format!(" by {who}")).unwrap_or_default();
    let words = what.word().replace('-', " ");
    let more = if text.is_empty() { String::new() } else { format!(": {text}") };
    let text = format!("alarm {:?} ({}) {words}{by}{more}", rule.name, rule.priority.word());
    Event { at: *at, gauge: rule.subject.gauge().map(str::to_owned), kind: EventKind::Alarm, text }
}

/// What a webhook is told, but for the number that it gets on the disk.
fn body(change: &Change, station: &str) -> String {
    let Change { at, rule, what, who, value, text, life, .. } = change;
    let time = humantime::format_rfc3339_millis(at.to_system_time()).to_string();
    let body = json!({
        "station": station,
        "alarm": rule.name,
        "what": what.word(),
        "state": life.state.word(),
        "priority": rule.priority.word(),
        "condition": rule.condition.word(),
        "gauge": rule.subject.gauge(),
        "subject": subject(rule),
        "value": value,
        "limit": rule.condition.limit(),
        "unit": rule.condition.unit(),
        "at": time,
        "at_ms": milliseconds(*at),
        "occurrence": life.occurrence,
        "who": who,
        "text": text,
        "message": rule.message,
    });
    body.to_string()
}
