//! What is written down of alarms: rows of the record, events, letters to webhooks.

use super::registry::{AlarmChange, AlarmStatus, Attribution, ChangeKind, OutOfService};
use super::rule::{Priority, Rule, Subject};
use super::state::AlarmState;
use crate::control::Actor;
use crate::view::unix_ms;
use profivac_recorder::alarms::{AlarmBatch, AlarmHistoryEntry, Notification, StoredAlarm};
use profivac_recorder::{AuditAction, AuditEntry, Event, EventKind};
use serde_json::json;

impl From<&AlarmStatus> for StoredAlarm {
    fn from(life: &AlarmStatus) -> Self {
        let AlarmStatus { state, since, occurrence, raised, value, text, acknowledged, out } = life;
        Self {
            state: state.word().to_owned(),
            since: *since,
            occurrence: *occurrence,
            raised_at: *raised,
            value: *value,
            text: text.clone(),
            acknowledged: acknowledged.as_ref().map(|by| (by.user.clone(), by.at)),
            out_of_service: out.as_ref().map(|out| (out.by.user.clone(), out.by.at, out.reason.clone())),
            out_until: out.as_ref().and_then(|out| out.until),
        }
    }
}

impl From<StoredAlarm> for AlarmStatus {
    /// A state that this program does not know is one that somebody must look at.
    fn from(kept: StoredAlarm) -> Self {
        let StoredAlarm {
            state,
            since,
            occurrence,
            raised_at: raised,
            value,
            text,
            acknowledged,
            out_of_service: out,
            out_until,
        } = kept;
        let state = AlarmState::from_word(&state).unwrap_or(AlarmState::Returned);
        let out =
            out.map(|(who, at, reason)| OutOfService { by: Attribution { user: who, at }, reason, until: out_until });
        let acknowledged = acknowledged.map(|(who, at)| Attribution { user: who, at });
        Self { state, since, occurrence, raised, value, text, acknowledged, out }
    }
}

/// A webhook that is to be told of alarms from some priority on.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct NotificationTarget {
    /// The name of the webhook.
    pub webhook: String,
    /// The lowest priority it is told of.
    pub min_priority: Priority,
}

/// What is written of changes, and the events that tell them. What somebody did stands in the audit trail, too.
#[must_use]
pub fn rows_and_events(
    changes: &[AlarmChange],
    by: Option<&Actor>,
    station: &str,
    addressees: &[NotificationTarget],
) -> (AlarmBatch, Vec<Event>) {
    let mut batch = AlarmBatch::default();
    for change in changes {
        batch.audit.extend(by.and_then(|actor| audit_entry(change, actor)));
        let is_there = change.what != ChangeKind::Removed;
        batch.alarms.insert(change.rule.name.clone(), is_there.then(|| StoredAlarm::from(&change.status)));
        batch.history.push(history_entry(change));
        let told = addressees.iter().filter(|addressee| addressee.min_priority <= change.rule.priority);
        let body = notification_body(change, station);
        batch.notifications.extend(told.map(|addressee| Notification {
            id: 0,
            webhook: addressee.webhook.clone(),
            at: change.at,
            body: body.clone(),
        }));
    }
    (batch, changes.iter().map(event).collect())
}

/// A row of the audit trail; nothing for what nobody does.
fn audit_entry(change: &AlarmChange, actor: &Actor) -> Option<AuditEntry> {
    let AlarmChange { at, rule, what, was, status: life, .. } = change;
    let deed = match what {
        ChangeKind::Acknowledged => AuditAction::Acknowledged,
        ChangeKind::TakenOutOfService => AuditAction::TakenOutOfService,
        ChangeKind::ReturnedToService => AuditAction::ReturnedToService,
        ChangeKind::Raised | ChangeKind::Returned | ChangeKind::Removed => return None,
    };
    let reason = life.out.as_ref().filter(|_| *what == ChangeKind::TakenOutOfService).map(|out| out.reason.clone());
    let gauge = rule.subject.gauge().map(str::to_owned);
    let (target, before, after) = (rule.name.clone(), was.word().to_owned(), life.state.word().to_owned());
    let row = AuditEntry {
        at: *at,
        gauge,
        target: Some(target),
        before: Some(before),
        after: Some(after),
        ..actor.row(deed)
    };
    Some(AuditEntry { outcome: reason, ..row })
}

fn history_entry(change: &AlarmChange) -> AlarmHistoryEntry {
    let AlarmChange { at, rule, what, who, value, text, status: life, .. } = change;
    AlarmHistoryEntry {
        at: *at,
        alarm: rule.name.clone(),
        change: what.word().to_owned(),
        state: life.state.word().to_owned(),
        priority: rule.priority.word().to_owned(),
        subject: subject(rule).map(str::to_owned),
        occurrence: life.occurrence,
        user: who.clone(),
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

fn event(change: &AlarmChange) -> Event {
    let AlarmChange { at, rule, what, who, text, .. } = change;
    let by = who.as_ref().map(|who| format!(" by {who}")).unwrap_or_default();
    let words = what.word().replace('-', " ");
    let more = if text.is_empty() { String::new() } else { format!(": {text}") };
    let text = format!("alarm {:?} ({}) {words}{by}{more}", rule.name, rule.priority.word());
    Event { at: *at, gauge: rule.subject.gauge().map(str::to_owned), kind: EventKind::Alarm, text }
}

/// What a webhook is told, but for the number that it gets on the disk.
fn notification_body(change: &AlarmChange, station: &str) -> String {
    let AlarmChange { at, rule, what, who, value, text, status: life, .. } = change;
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
        "at_ms": unix_ms(*at),
        "occurrence": life.occurrence,
        "who": who,
        "text": text,
        "message": rule.message,
    });
    body.to_string()
}
