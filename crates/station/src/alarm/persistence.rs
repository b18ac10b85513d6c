//! The rows, events and notifications of a change.

use super::notify::Notifier;
use super::plant_state::{PlantStateChange, PlantStateChangeKind, rfc3339};
use super::registry::{AlarmChange, RegisteredAlarm};
use super::rule::Rule;
use crate::view::unix_ms;
use profivac_model::{
    AlarmChangeKind, AlarmHistoryEntry, AlarmStatus, AuditAction, AuditEntry, Declaration, Event, EventKind, Micros,
};
use profivac_recorder::alarms::{AlarmBatch, Notification};
use profivac_web_server::auth::Actor;
use serde_json::json;

/// The rows and the events of changed plant states. A change made by a user also gets a row of the audit trail.
#[must_use]
pub fn plant_state_rows(changes: &[PlantStateChange], by: Option<&Actor>) -> (AlarmBatch, Vec<Event>) {
    let mut batch = AlarmBatch::default();
    for change in changes {
        batch.plant_states.insert(change.name.clone(), change.after.clone());
        batch.audit.extend(by.map(|actor| plant_state_entry(change, actor)));
    }
    (batch, changes.iter().map(plant_state_event).collect())
}

fn plant_state_entry(change: &PlantStateChange, actor: &Actor) -> AuditEntry {
    let PlantStateChange { at, name, kind, reason, before, after, .. } = change;
    let action = match kind {
        PlantStateChangeKind::Declared => AuditAction::PlantStateDeclared,
        PlantStateChangeKind::Extended => AuditAction::PlantStateExtended,
        PlantStateChangeKind::Ended => AuditAction::PlantStateEnded,
    };
    let words = |declaration: &Option<Declaration>| match declaration {
        Some(declaration) => format!("declared until {}", rfc3339(declaration.until)),
        None => "not declared".to_owned(),
    };
    AuditEntry {
        at: *at,
        target: Some(name.clone()),
        before: Some(words(before)),
        after: Some(words(after)),
        outcome: Some(reason.clone()).filter(|reason| !reason.is_empty()),
        ..actor.audit_entry(action)
    }
}

fn plant_state_event(change: &PlantStateChange) -> Event {
    let PlantStateChange { at, name, kind, user, reason, after, alarms, .. } = change;
    let what = match kind {
        PlantStateChangeKind::Declared => "declared",
        PlantStateChangeKind::Extended => "extended",
        PlantStateChangeKind::Ended => "ended",
    };
    let by = user.as_ref().map(|user| format!(" by {user}")).unwrap_or_default();
    let plural = if *alarms == 1 { "alarm" } else { "alarms" };
    let until = after.as_ref().map(|it| format!(" until {}, suppresses {alarms} {plural}", rfc3339(it.until)));
    let why = if reason.is_empty() { String::new() } else { format!(": {reason}") };
    let text = format!("plant state {name:?} {what}{by}{}{why}", until.unwrap_or_default());
    Event { at: *at, gauge: None, kind: EventKind::Alarm.into(), text }
}

/// Former ends of the names of default alarms, and the present ones. Version 0.1 stored states under the former.
const RENAMED: [(&str, &str); 2] =
    [(": blind", ": limit not measurable"), ("record: not written", "station: not recording")];

/// The stored alarms under their present names, and the rows that make the change permanent. A former name that a rule has stays.
pub fn rename(
    stored: Vec<(String, AlarmStatus)>,
    has_rule: impl Fn(&str) -> bool,
) -> (Vec<(String, AlarmStatus)>, AlarmBatch) {
    let mut rows = AlarmBatch::default();
    let present = |name: &str| {
        let renamed = RENAMED.iter().find_map(|(old, new)| Some(format!("{}{new}", name.strip_suffix(old)?)));
        renamed.filter(|new| !has_rule(name) && has_rule(new))
    };
    let renamed = stored.into_iter().map(|(name, alarm)| {
        let Some(new) = present(&name) else { return (name, alarm) };
        rows.alarms.insert(name, None);
        rows.alarms.insert(new.clone(), Some(alarm.clone()));
        (new, alarm)
    });
    (renamed.collect(), rows)
}

/// The rows and the events of changes. A change made by a user also gets a row of the audit trail.
#[must_use]
pub fn rows_and_events(
    changes: &[AlarmChange],
    by: Option<&Actor>,
    station: &str,
    notifier: &mut Notifier,
) -> (AlarmBatch, Vec<Event>) {
    let mut batch = AlarmBatch::default();
    for change in changes {
        batch.audit.extend(by.and_then(|actor| audit_entry(change, actor)));
        let stored = (change.kind != AlarmChangeKind::Removed).then(|| change.status.clone());
        batch.alarms.insert(change.rule.name.clone(), stored);
        batch.history.push(history_entry(change));
        let body = notification_body(&Told::from(change), &change.status, station);
        let told = notifier.told_of(change).into_iter();
        batch.notifications.extend(told.map(|webhook| notification(webhook, change.at, body.clone())));
    }
    (batch, changes.iter().map(event).collect())
}

/// The notifications about alarms that still wait for their acknowledgement.
#[must_use]
pub fn late_notifications(late: Vec<(String, &RegisteredAlarm)>, station: &str, at: Micros) -> AlarmBatch {
    let notifications = late.into_iter().map(|(webhook, alarm)| {
        let status = alarm.status().clone();
        let text = status.text.clone();
        let told =
            Told { at, rule: alarm.rule(), change: NOT_ACKNOWLEDGED, user: None, value: alarm.value(), text: &text };
        notification(webhook, at, notification_body(&told, &status, station))
    });
    AlarmBatch { notifications: notifications.collect(), ..AlarmBatch::default() }
}

fn notification(webhook: String, at: Micros, body: String) -> Notification {
    Notification { id: 0, webhook, at, body }
}

/// The row of the audit trail; `None` for a change that the station makes itself.
fn audit_entry(change: &AlarmChange, actor: &Actor) -> Option<AuditEntry> {
    let AlarmChange { at, rule, kind, was, status, .. } = change;
    let action = match kind {
        AlarmChangeKind::Acknowledged => AuditAction::Acknowledged,
        AlarmChangeKind::Shelved => AuditAction::Shelved,
        AlarmChangeKind::Unshelved => AuditAction::Unshelved,
        AlarmChangeKind::TakenOutOfService => AuditAction::TakenOutOfService,
        AlarmChangeKind::ReturnedToService => AuditAction::ReturnedToService,
        AlarmChangeKind::Raised
        | AlarmChangeKind::Returned
        | AlarmChangeKind::Suppressed
        | AlarmChangeKind::Unsuppressed
        | AlarmChangeKind::Removed
        | AlarmChangeKind::SettingsChanged => return None,
    };
    let suppressed = matches!(kind, AlarmChangeKind::Shelved | AlarmChangeKind::TakenOutOfService);
    let suppression = status.suppression.as_ref().filter(|_| suppressed);
    Some(AuditEntry {
        at: *at,
        gauge: rule.condition.gauge().map(str::to_owned),
        target: Some(rule.name.clone()),
        before: Some(was.word().to_owned()),
        after: Some(status.state.word().to_owned()),
        outcome: suppression.map(|it| it.reason.clone()),
        ..actor.audit_entry(action)
    })
}

/// A change of the settings of an alarm by a user.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct SettingsChange<'a> {
    /// The settings before, as the file writes them.
    pub before: String,
    /// The settings after.
    pub after: String,
    /// Why.
    pub reason: &'a str,
}

/// The rows and the event of changed settings.
#[must_use]
pub fn settings_rows(
    change: &SettingsChange<'_>,
    alarm: &RegisteredAlarm,
    actor: &Actor,
    at: Micros,
) -> (AlarmBatch, Event) {
    let SettingsChange { before, after, reason } = change;
    let (rule, status) = (alarm.rule(), alarm.status());
    let text = format!("{before} becomes {after}: {reason}");
    let gauge = rule.condition.gauge().map(str::to_owned);
    let user = actor.user.name.to_string();
    let entry = AuditEntry {
        at,
        gauge: gauge.clone(),
        target: Some(rule.name.clone()),
        before: Some(before.clone()),
        after: Some(after.clone()),
        outcome: Some((*reason).to_owned()),
        ..actor.audit_entry(AuditAction::AlarmSettings)
    };
    let history = AlarmHistoryEntry {
        at,
        alarm: rule.name.clone(),
        change: AlarmChangeKind::SettingsChanged.into(),
        state: status.state.into(),
        priority: rule.priority.into(),
        subject: rule.condition.subject().map(str::to_owned),
        occurrence: status.occurrence,
        user: Some(user.clone()),
        value: None,
        unit: None,
        text: text.clone(),
    };
    let text = format!("alarm {:?}: settings changed by {user}: {text}", rule.name);
    let batch = AlarmBatch { audit: vec![entry], history: vec![history], ..AlarmBatch::default() };
    (batch, Event { at, gauge, kind: EventKind::Alarm.into(), text })
}

/// The rows and the event of changed settings of a default alarm.
#[must_use]
pub fn default_settings_rows(
    change: &SettingsChange<'_>,
    name: &str,
    actor: &Actor,
    at: Micros,
) -> (AlarmBatch, Event) {
    let SettingsChange { before, after, reason } = change;
    let entry = AuditEntry {
        at,
        target: Some(format!("[alarms] {name}")),
        before: Some(before.clone()),
        after: Some(after.clone()),
        outcome: Some((*reason).to_owned()),
        ..actor.audit_entry(AuditAction::AlarmSettings)
    };
    let user = &actor.user.name;
    let text = format!("default alarm {name}: settings changed by {user}: {before} becomes {after}: {reason}");
    let batch = AlarmBatch { audit: vec![entry], ..AlarmBatch::default() };
    (batch, Event { at, gauge: None, kind: EventKind::Alarm.into(), text })
}

fn history_entry(change: &AlarmChange) -> AlarmHistoryEntry {
    let AlarmChange { at, rule, kind, user, value, text, status, .. } = change;
    AlarmHistoryEntry {
        at: *at,
        alarm: rule.name.clone(),
        change: (*kind).into(),
        state: status.state.into(),
        priority: rule.priority.into(),
        subject: rule.condition.subject().map(str::to_owned),
        occurrence: status.occurrence,
        user: user.clone(),
        value: *value,
        unit: rule.condition.unit().map(str::to_owned),
        text: text.clone(),
    }
}

fn event(change: &AlarmChange) -> Event {
    let AlarmChange { at, rule, kind, user, text, .. } = change;
    let by = user.as_ref().map(|user| format!(" by {user}")).unwrap_or_default();
    let words = kind.operator_words();
    let more = if text.is_empty() { String::new() } else { format!(": {text}") };
    let text = format!("alarm {:?} ({}) {words}{by}{more}", rule.name, rule.priority.word());
    Event { at: *at, gauge: rule.condition.gauge().map(str::to_owned), kind: EventKind::Alarm.into(), text }
}

/// The word for an alarm that a webhook is told of because it still waits for its acknowledgement.
const NOT_ACKNOWLEDGED: &str = "not-acknowledged";

/// What a notification says besides the status of the alarm.
struct Told<'a> {
    at: Micros,
    rule: &'a Rule,
    change: &'a str,
    user: Option<&'a str>,
    value: Option<f64>,
    text: &'a str,
}

impl<'a> From<&'a AlarmChange> for Told<'a> {
    fn from(AlarmChange { at, rule, kind, user, value, text, .. }: &'a AlarmChange) -> Self {
        Self { at: *at, rule, change: kind.word(), user: user.as_deref(), value: *value, text }
    }
}

/// The body of a notification, without the id that it gets in the database.
fn notification_body(told: &Told<'_>, status: &AlarmStatus, station: &str) -> String {
    let Told { at, rule, change, user, value, text } = told;
    let time = at.to_iso(3);
    let body = json!({
        "station": station,
        "alarm": rule.name,
        "change": change,
        "state": status.state.word(),
        "priority": rule.priority.word(),
        "condition": rule.condition.kind(),
        "gauge": rule.condition.gauge(),
        "subject": rule.condition.subject(),
        "value": value,
        "limit": rule.condition.limit(),
        "unit": rule.condition.unit(),
        "at": time,
        "at_ms": unix_ms(*at),
        "occurrence": status.occurrence,
        "user": user,
        "text": text,
        "message": rule.message,
    });
    body.to_string()
}

#[cfg(test)]
mod tests {
    use super::*;
    use profivac_model::AlarmState;

    #[test]
    fn a_state_under_a_former_name_is_that_of_the_present_alarm() {
        let rules = ["chamber: limit not measurable", "station: not recording", "mine: blind"];
        let alarm = AlarmStatus { state: AlarmState::Acknowledged, ..AlarmStatus::default() };
        let stored = ["chamber: blind", "record: not written", "mine: blind", "gone: blind"];
        let stored = stored.map(|name| (name.to_owned(), alarm.clone())).to_vec();
        let (present, rows) = rename(stored, |name| rules.contains(&name));
        let names: Vec<_> = present.iter().map(|(name, _)| name.as_str()).collect();
        assert_eq!(names, [rules[0], rules[1], "mine: blind", "gone: blind"], "an own alarm keeps its name");
        let changes: Vec<_> = rows.alarms.iter().map(|(name, row)| (name.as_str(), row.is_some())).collect();
        let expected = [("chamber: blind", false), (rules[0], true), ("record: not written", false), (rules[1], true)];
        assert_eq!(changes, expected);
    }
}
