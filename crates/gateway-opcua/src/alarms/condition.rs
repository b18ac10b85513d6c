//! An alarm as a condition, which is its event at the same time.

use super::fields::{self, SHELVING, below};
use crate::value::time;
use opcua_server::address_space::{Event, EventField};
use opcua_types::{
    AttributeId, ByteString, DateTime, LocalizedText, NodeId, NumericRange, ObjectId, ObjectTypeId, QualifiedName,
    StatusCode, UAString, Variant,
};
use profivac_recorder::Micros;
use profivac_station::alarm::SHELVED;
use std::sync::Arc;

/// An alarm as a condition, at one moment. It is the event that tells of it, too.
#[derive(Clone, Debug, PartialEq)]
pub struct Condition {
    pub(super) alarm: Arc<str>,
    pub(super) node: NodeId,
    pub(super) source: NodeId,
    pub(super) is_active: bool,
    pub(super) is_acknowledged: bool,
    pub(super) is_out_of_service: bool,
    pub(super) is_shelved: bool,
    pub(super) is_suppressed: bool,
    /// When it is unshelved.
    pub(super) until: Option<Micros>,
    /// Why it is shelved, out of service or suppressed.
    pub(super) reason: String,
    pub(super) severity: u16,
    pub(super) occurrence: i64,
    pub(super) text: String,
    pub(super) user: String,
    pub(super) at: Micros,
}

impl Condition {
    /// Its node.
    #[must_use]
    pub const fn node(&self) -> &NodeId {
        &self.node
    }

    /// Whether it is sent when a client asks for all conditions that stand.
    #[must_use]
    pub const fn is_retained(&self) -> bool {
        self.is_active || !self.is_acknowledged || self.is_shelved
    }

    /// The milliseconds until the alarm is unshelved, in whole seconds; 0 if it is not shelved.
    fn unshelve_time(&self, now: Micros) -> f64 {
        let until = self.until.filter(|_| self.is_shelved).map_or(0, |until| until.0.saturating_sub(now.0).max(0));
        (until as f64 / 1e6).ceil() * 1e3
    }

    /// The node of the time until the alarm is unshelved, with its value; `None` if it is not shelved.
    pub(super) fn countdown(&self, now: Micros) -> Option<(NodeId, Variant)> {
        let node = || below(&self.node, &format!("{SHELVING}/UnshelveTime"));
        self.is_shelved.then(|| (node(), Variant::from(self.unshelve_time(now))))
    }

    /// The identifier of the event: occurrence and time, so that the acknowledgement of an earlier occurrence is refused.
    pub(super) fn event_id(&self) -> ByteString {
        let suppression =
            u8::from(self.is_out_of_service) | (u8::from(self.is_shelved) << 1) | (u8::from(self.is_suppressed) << 2);
        let states = [u8::from(self.is_active), u8::from(self.is_acknowledged), suppression];
        let name = self.alarm.as_bytes();
        let octets = [&self.occurrence.to_be_bytes()[..], &self.at.0.to_be_bytes(), &states, name].concat();
        ByteString::from(octets)
    }

    /// The occurrence that an identifier of an event of this alarm names.
    pub(super) fn occurrence_of(&self, event: &ByteString) -> Option<i64> {
        let octets = event.value.as_deref()?;
        let (occurrence, rest) = octets.split_first_chunk()?;
        let (_, rest) = rest.split_first_chunk::<8>()?;
        let (_, name) = rest.split_first_chunk::<3>()?;
        (name == self.alarm.as_bytes()).then(|| i64::from_be_bytes(*occurrence))
    }

    const fn why_inactive(&self) -> &'static str {
        match (self.is_out_of_service, self.is_suppressed) {
            (true, _) => "out of service",
            (_, true) => "suppressed",
            _ => "the condition is not met",
        }
    }

    /// The value of a field: `["ActiveState"]`, `["ActiveState", "Id"]`.
    pub(super) fn field(&self, path: &[&str]) -> Option<Variant> {
        let text = |text: &str| Variant::from(LocalizedText::new("", text));
        let two = |is: bool, yes: &str, no: &str| text(if is { yes } else { no });
        let at = || Variant::from(time(self.at));
        Some(match path {
            ["EventId"] => Variant::from(self.event_id()),
            ["EventType"] => Variant::from(NodeId::from(ObjectTypeId::AlarmConditionType)),
            ["SourceNode"] => Variant::from(self.source.clone()),
            ["SourceName" | "ConditionName"] => Variant::from(UAString::from(&*self.alarm)),
            ["Time" | "ReceiveTime"] => at(),
            // The text says why the alarm was raised.
            ["Message"] if !self.is_active => text(&format!("{}: {}", self.alarm, self.why_inactive())),
            ["Message"] => text(if self.text.is_empty() { &self.alarm } else { &self.text }),
            ["Severity" | "LastSeverity"] => Variant::from(self.severity),
            ["ConditionClassId"] => Variant::from(NodeId::from(ObjectTypeId::ProcessConditionClassType)),
            ["ConditionClassName"] => text("ProcessConditionClassType"),
            ["BranchId" | "InputNode"] => Variant::from(NodeId::null()),
            ["Retain"] => Variant::from(self.is_retained()),
            ["EnabledState"] => text("Enabled"),
            ["EnabledState", "Id"] => Variant::from(true),
            ["Quality"] => Variant::from(StatusCode::Good),
            ["Quality" | "LastSeverity" | "Comment", "SourceTimestamp"] => at(),
            ["Comment"] => text(&self.reason),
            ["ClientUserId"] => Variant::from(UAString::from(self.user.as_str())),
            ["AckedState"] => two(self.is_acknowledged, "Acknowledged", "Unacknowledged"),
            ["AckedState", "Id"] => Variant::from(self.is_acknowledged),
            ["ActiveState"] => two(self.is_active, "Active", "Inactive"),
            ["ActiveState", "Id"] => Variant::from(self.is_active),
            ["OutOfServiceState"] => two(self.is_out_of_service, "Out of service", "In service"),
            ["OutOfServiceState", "Id"] => Variant::from(self.is_out_of_service),
            ["SuppressedState"] => two(self.is_suppressed, "Suppressed", "Unsuppressed"),
            ["SuppressedState", "Id"] => Variant::from(self.is_suppressed),
            ["SuppressedOrShelved"] => Variant::from(self.is_out_of_service || self.is_shelved || self.is_suppressed),
            [SHELVING, "CurrentState"] => two(self.is_shelved, "TimedShelved", "Unshelved"),
            [SHELVING, "CurrentState", "Id"] => Variant::from(NodeId::from(match self.is_shelved {
                true => ObjectId::ShelvedStateMachineType_TimedShelved,
                false => ObjectId::ShelvedStateMachineType_Unshelved,
            })),
            [SHELVING, "UnshelveTime"] => Variant::from(self.unshelve_time(Micros::now())),
            ["MaxTimeShelved"] => Variant::from(SHELVED.end().as_secs_f64() * 1e3),
            ["SupportsFilteredRetain"] => Variant::from(false),
            _ => return None,
        })
    }

    /// The nodes of the instance with their values.
    pub fn values(&self) -> impl Iterator<Item = (NodeId, Variant)> + '_ {
        fields::of_instance().flat_map(move |(path, role, _)| {
            let parts: Vec<&str> = path.split('/').collect();
            let node = below(&self.node, path);
            let second = role.second().and_then(|(name, _)| {
                Some((below(&node, name), self.field(&parts.iter().copied().chain([name]).collect::<Vec<_>>())?))
            });
            self.field(&parts).map(|value| (node, value)).into_iter().chain(second)
        })
    }
}

impl EventField for Condition {
    fn get_value(&self, attribute: AttributeId, range: &NumericRange, path: &[QualifiedName]) -> Variant {
        if path.is_empty() {
            return if attribute == AttributeId::NodeId { Variant::from(self.node.clone()) } else { Variant::Empty };
        }
        if attribute != AttributeId::Value || path.iter().any(|part| part.namespace_index != 0) {
            return Variant::Empty;
        }
        let path: Vec<&str> = path.iter().map(|part| part.name.as_ref()).collect();
        let value = self.field(&path).unwrap_or(Variant::Empty);
        value.range_of_owned(range).unwrap_or(Variant::Empty)
    }
}

impl Event for Condition {
    fn get_field(&self, _: &NodeId, attribute: AttributeId, range: &NumericRange, path: &[QualifiedName]) -> Variant {
        self.get_value(attribute, range, path)
    }

    fn time(&self) -> &DateTime {
        // The library reads it in its tests alone, and wants a reference.
        static NONE: std::sync::OnceLock<DateTime> = std::sync::OnceLock::new();
        NONE.get_or_init(DateTime::null)
    }

    fn event_type_id(&self) -> &NodeId {
        static TYPE: std::sync::OnceLock<NodeId> = std::sync::OnceLock::new();
        TYPE.get_or_init(|| ObjectTypeId::AlarmConditionType.into())
    }
}
