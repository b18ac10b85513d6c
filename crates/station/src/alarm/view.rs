//! Alarms as the API and the dashboard have them. Times are milliseconds since 1970.

use super::registry::RegisteredAlarm;
use super::rule::{Priority, Subject};
use super::state::AlarmState;
use crate::view::unix_ms;
use profivac_recorder::alarms::AlarmHistoryEntry;
use serde::Serialize;
use utoipa::ToSchema;

/// An alarm.
#[derive(Clone, Debug, PartialEq, Serialize, ToSchema)]
pub struct AlarmView {
    /// Its name.
    pub name: String,
    /// What is watched: `above`, `below`, `rise`, `blind`, `fault`, `stale`, `down`, `damage`, `unrecorded`.
    pub condition: &'static str,
    /// The gauge.
    pub gauge: Option<String>,
    /// The measuring part, by the name under which it is recorded.
    pub series: Option<String>,
    /// The segment, if the alarm is about one.
    pub segment: Option<String>,
    /// How soon somebody must do something.
    pub priority: Priority,
    /// Where it stands.
    pub state: AlarmState,
    /// Since when it stands there; nothing if nothing ever became of it.
    pub since_ms: Option<i64>,
    /// Which time it was raised, to be given when it is acknowledged; 0 if it never was.
    pub occurrence: i64,
    /// When it was raised last.
    pub raised_ms: Option<i64>,
    /// The value that raised it.
    pub raised_value: Option<f64>,
    /// What was seen when it was raised, in a sentence.
    pub text: String,
    /// The value now.
    pub value: Option<f64>,
    /// The limit.
    pub limit: Option<f64>,
    /// Where it is over.
    pub reset: Option<f64>,
    /// What values and limits are counted in.
    pub unit: Option<&'static str>,
    /// Who acknowledged it.
    pub acknowledged_by: Option<String>,
    /// When.
    pub acknowledged_ms: Option<i64>,
    /// Why it is out of service.
    pub out_of_service: Option<OutOfServiceView>,
    /// What is to be done, as the file says.
    pub message: Option<String>,
}

/// Why an alarm is out of service.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, ToSchema)]
pub struct OutOfServiceView {
    /// Who took it out.
    pub who: String,
    /// When.
    pub at_ms: i64,
    /// Why.
    pub reason: String,
    /// When it comes back by itself; nothing if somebody must put it back.
    pub until_ms: Option<i64>,
}

impl From<&RegisteredAlarm> for AlarmView {
    fn from(entry: &RegisteredAlarm) -> Self {
        let (rule, life) = (entry.rule(), entry.status());
        let (series, segment) = match &rule.subject {
            Subject::Series { series, .. } => (Some(series.clone()), None),
            Subject::Segment(segment) => (None, Some(segment.clone())),
            Subject::Gauge(_) | Subject::Station => (None, None),
        };
        let acknowledged = life.acknowledged.as_ref().filter(|_| life.state != AlarmState::Unacknowledged);
        let out = life.out.as_ref();
        Self {
            name: rule.name.clone(),
            condition: rule.condition.word(),
            gauge: rule.subject.gauge().map(str::to_owned),
            series,
            segment,
            priority: rule.priority,
            state: life.state,
            since_ms: (life.occurrence > 0 || life.state != AlarmState::Normal).then(|| unix_ms(life.since)),
            occurrence: life.occurrence,
            raised_ms: life.raised.map(unix_ms),
            raised_value: life.value,
            text: life.text.clone(),
            value: entry.value(),
            limit: rule.condition.limit(),
            reset: rule.condition.reset(),
            unit: rule.condition.unit(),
            acknowledged_by: acknowledged.map(|by| by.user.clone()),
            acknowledged_ms: acknowledged.map(|by| unix_ms(by.at)),
            out_of_service: out.map(|out| OutOfServiceView {
                who: out.by.user.clone(),
                at_ms: unix_ms(out.by.at),
                reason: out.reason.clone(),
                until_ms: out.until.map(unix_ms),
            }),
            message: rule.message.clone(),
        }
    }
}

/// How many alarms of a priority there are.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, ToSchema)]
pub struct AlarmCount {
    /// Whose condition holds.
    pub active: usize,
    /// That nobody has acknowledged, whether their condition holds or not any more.
    pub unacknowledged: usize,
}

/// What must be known about alarms at a moment.
#[derive(Clone, Debug, Default, PartialEq, Serialize, ToSchema)]
pub struct AlarmOverview {
    /// Why what is told here may be wrong: nobody has looked for long, or it cannot be written.
    pub trouble: Option<String>,
    /// Of high priority.
    pub high: AlarmCount,
    /// Of medium priority.
    pub medium: AlarmCount,
    /// Of low priority.
    pub low: AlarmCount,
    /// How many are out of service.
    pub out_of_service: usize,
    /// All that are neither normal nor out of service, the most urgent first; of very many only the first.
    pub list: Vec<AlarmView>,
    /// How many there are beyond the list.
    pub more: usize,
}

/// So many stand in the list of a moment, which is sent four times a second.
const MAX_LISTED: usize = 50;

impl AlarmOverview {
    /// What must be known about these.
    #[must_use]
    pub fn of(entries: &[RegisteredAlarm], trouble: Option<String>) -> Self {
        let mut standing = Self { trouble, ..Self::default() };
        let mut list = Vec::new();
        for entry in entries {
            let state = entry.status().state;
            let count = match entry.rule().priority {
                Priority::High => &mut standing.high,
                Priority::Medium => &mut standing.medium,
                Priority::Low => &mut standing.low,
            };
            count.active = count.active.saturating_add(usize::from(state.is_active()));
            count.unacknowledged = count.unacknowledged.saturating_add(usize::from(state.needs_acknowledgement()));
            match state {
                AlarmState::Normal => {}
                AlarmState::OutOfService => standing.out_of_service = standing.out_of_service.saturating_add(1),
                AlarmState::Unacknowledged | AlarmState::Acknowledged | AlarmState::Returned => {
                    list.push(AlarmView::from(entry))
                }
            }
        }
        list.sort_by(urgency);
        standing.more = list.len().saturating_sub(MAX_LISTED);
        list.truncate(MAX_LISTED);
        Self { list, ..standing }
    }
}

/// What holds comes first; among these the highest priority, then what nobody knows of, then the latest.
fn urgency(one: &AlarmView, other: &AlarmView) -> std::cmp::Ordering {
    let rank = |alarm: &AlarmView| {
        (alarm.state.is_active(), alarm.priority, alarm.state.needs_acknowledgement(), alarm.since_ms)
    };
    rank(other).cmp(&rank(one))
}

/// A line of the history.
#[derive(Clone, Debug, PartialEq, Serialize, ToSchema)]
pub struct AlarmHistoryView {
    /// When.
    pub at_ms: i64,
    /// The alarm.
    pub alarm: String,
    /// What happened: `raised`, `returned`, `acknowledged`, `taken-out-of-service`, `returned-to-service`, `removed`.
    pub what: String,
    /// Where it stood then.
    pub state: String,
    /// The priority it had.
    pub priority: String,
    /// The gauge or segment.
    pub subject: Option<String>,
    /// Which time it was raised.
    pub occurrence: i64,
    /// Who did it; nothing if it came by itself.
    pub who: Option<String>,
    /// The value at that time.
    pub value: Option<f64>,
    /// What it is counted in.
    pub unit: Option<String>,
    /// A sentence.
    pub text: String,
}

impl From<AlarmHistoryEntry> for AlarmHistoryView {
    fn from(line: AlarmHistoryEntry) -> Self {
        let AlarmHistoryEntry { at, alarm, change: what, state, priority, subject, occurrence, user: who, value, unit, text } =
            line;
        let at_ms = unix_ms(at);
        Self { at_ms, alarm, what, state, priority, subject, occurrence, who, value, unit, text }
    }
}
