//! Which points are an alarm's, and the condition that they make.

use super::SEVERITIES;
use super::condition::Condition;
use crate::plan::identifier;
use opcua_types::NodeId;
use profivac_gateway::signal::alarm_state;
use profivac_gateway::{Signal, Snapshot, Subject, Value};
use std::collections::BTreeMap;
use std::sync::Arc;

/// The positions of the points of an alarm.
pub struct Row {
    alarm: Arc<str>,
    points: Vec<(Signal, usize)>,
}

impl Row {
    /// The identifier of the node of the alarm.
    fn source(&self) -> String {
        let id = identifier(&Subject::Alarm(Arc::clone(&self.alarm)), Signal::AlarmState);
        id.trim_end_matches(Signal::AlarmState.key()).trim_end_matches('/').to_owned()
    }

    /// That of its condition.
    pub fn node(&self) -> String {
        format!("{}/condition", self.source())
    }

    /// Whether a point of the alarm has changed. The present value that an alarm watches is no part of the condition.
    pub fn differs(&self, new: &Snapshot, old: &Snapshot) -> bool {
        let version = |snapshot: &Snapshot, index: usize| snapshot.values.get(index).map(|value| value.version);
        let points = self.points.iter().filter(|(signal, _)| *signal != Signal::AlarmValue);
        points.copied().any(|(_, index)| version(new, index) != version(old, index))
    }

    pub fn condition(&self, namespace: u16, snapshot: &Snapshot) -> Option<Condition> {
        let point = |signal| {
            let index = self.points.iter().find(|(own, _)| *own == signal)?.1;
            snapshot.values.get(index)
        };
        let is = |signal| point(signal).is_some_and(|it| it.value == Value::Boolean(true));
        let text = |signal| match point(signal).map(|it| &it.value) {
            Some(Value::Text(text)) => text.to_string(),
            _ => String::new(),
        };
        let occurrence = match point(Signal::Occurrence)?.value {
            Value::Integer(number) => number,
            _ => 0,
        };
        let priority = match point(Signal::Priority)?.value {
            Value::Choice(number) => usize::from(number),
            _ => 0,
        };
        let state = point(Signal::AlarmState)?;
        let until = match point(Signal::SuppressedUntil)?.value {
            Value::Time(until) => Some(until),
            _ => None,
        };
        let suppressed_by = text(Signal::SuppressedBy);
        Some(Condition {
            alarm: Arc::clone(&self.alarm),
            node: NodeId::new(namespace, self.node()),
            source: NodeId::new(namespace, self.source()),
            is_active: is(Signal::AlarmActive),
            is_acknowledged: is(Signal::AlarmAcknowledged),
            is_out_of_service: state.value == Value::Choice(alarm_state::OUT_OF_SERVICE),
            is_shelved: state.value == Value::Choice(alarm_state::SHELVED),
            is_suppressed: state.value == Value::Choice(alarm_state::SUPPRESSED),
            until,
            reason: text(Signal::OutOfService),
            severity: SEVERITIES.get(priority).copied().unwrap_or(1),
            occurrence,
            text: text(Signal::AlarmText),
            user: if suppressed_by.is_empty() { text(Signal::AcknowledgedBy) } else { suppressed_by },
            at: state.at.unwrap_or_default(),
        })
    }
}

/// The rows of the alarms of a list of points.
pub fn rows_of(snapshot: &Snapshot) -> Vec<Row> {
    let mut rows: BTreeMap<Arc<str>, Vec<(Signal, usize)>> = BTreeMap::new();
    for (index, point) in snapshot.points.iter().enumerate() {
        if let Subject::Alarm(name) = &point.subject {
            rows.entry(Arc::clone(name)).or_default().push((point.signal, index));
        }
    }
    rows.into_iter().map(|(alarm, points)| Row { alarm, points }).collect()
}
