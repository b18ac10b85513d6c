//! Alarms as conditions (OPC 10000-9): an instance of `AlarmConditionType` for each alarm, an event for each change, `Acknowledge` and
//! `ConditionRefresh`.
//!
//! The library has events with filters, and no conditions. This module makes one from the points of an alarm:
//!
//! | State of the alarm | `ActiveState` | `AckedState` | `OutOfServiceState` | `Retain` |
//! |---|---|---|---|---|
//! | normal | Inactive | Acknowledged | In service | false |
//! | unacknowledged | Active | Unacknowledged | In service | true |
//! | acknowledged | Active | Acknowledged | In service | true |
//! | returned | Inactive | Unacknowledged | In service | true |
//! | out of service | Inactive | Acknowledged | Out of service | false |
//! | shelved | Inactive | Acknowledged | In service | false |
//!
//! `SuppressedOrShelved` is true in the last two.

use crate::plan::identifier;
use crate::value::time;
use opcua_server::address_space::{
    AddressSpace, DefaultTypeTree, Event, EventField, MethodBuilder, ObjectBuilder, ReferenceDirection, TypeTree,
    VariableBuilder,
};
use opcua_server::node_manager::RequestContext;
use opcua_types::{
    Argument, AttributeId, ByteString, DataTypeId, DateTime, LocalizedText, MethodId, NodeClass, NodeId, NumericRange,
    ObjectId, ObjectTypeId, QualifiedName, ReferenceTypeId, StatusCode, UAString, VariableTypeId, Variant,
};
use profivac_gateway::{Commander, Signal, Snapshot, Subject, Value, WriteError, WriteRequest};
use profivac_recorder::Micros;
use profivac_station::alarm::AlarmServiceError;
use profivac_station::alarm::registry::AlarmError;
use profivac_station::gateway_status::GatewayStatus;
use std::collections::{BTreeMap, BTreeSet};
use std::sync::{Arc, Mutex, PoisonError};
use std::time::{Duration, Instant};

/// The library's name of a user who has not logged in; names of users are in lower case.
pub const ANONYMOUS: &str = "ANONYMOUS";

/// The severities of the priorities none, low, medium and high. free choice: the middle of the bands that OPC 10000-5 suggests.
const SEVERITIES: [u16; 4] = [1, 200, 500, 800];

/// The shortest time between two refreshes of a subscription. free choice: as fast as a person can ask.
const REFRESH_PAUSE: Duration = Duration::from_secs(1);

/// The most refreshes of all clients in that time.
const MAX_REFRESHES: usize = 16;

/// The types of which a condition is an instance, beside the base type of events.
const TYPES: [ObjectTypeId; 3] =
    [ObjectTypeId::ConditionType, ObjectTypeId::AcknowledgeableConditionType, ObjectTypeId::AlarmConditionType];

/// What a field of a condition is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Role {
    /// A property.
    Property,
    /// A variable with two states, which has `Id` as a property.
    TwoState,
    /// A variable with the time since when it holds.
    Timed,
}

/// The mandatory fields of `AlarmConditionType` and `OutOfServiceState`.
const FIELDS: [(&str, Role, DataTypeId); 27] = [
    ("EventId", Role::Property, DataTypeId::ByteString),
    ("EventType", Role::Property, DataTypeId::NodeId),
    ("SourceNode", Role::Property, DataTypeId::NodeId),
    ("SourceName", Role::Property, DataTypeId::String),
    ("Time", Role::Property, DataTypeId::UtcTime),
    ("ReceiveTime", Role::Property, DataTypeId::UtcTime),
    ("Message", Role::Property, DataTypeId::LocalizedText),
    ("Severity", Role::Property, DataTypeId::UInt16),
    ("ConditionClassId", Role::Property, DataTypeId::NodeId),
    ("ConditionClassName", Role::Property, DataTypeId::LocalizedText),
    ("ConditionName", Role::Property, DataTypeId::String),
    ("BranchId", Role::Property, DataTypeId::NodeId),
    ("Retain", Role::Property, DataTypeId::Boolean),
    ("EnabledState", Role::TwoState, DataTypeId::LocalizedText),
    ("Quality", Role::Timed, DataTypeId::StatusCode),
    ("LastSeverity", Role::Timed, DataTypeId::UInt16),
    ("Comment", Role::Timed, DataTypeId::LocalizedText),
    ("ClientUserId", Role::Property, DataTypeId::String),
    ("AckedState", Role::TwoState, DataTypeId::LocalizedText),
    ("ActiveState", Role::TwoState, DataTypeId::LocalizedText),
    ("InputNode", Role::Property, DataTypeId::NodeId),
    ("SuppressedOrShelved", Role::Property, DataTypeId::Boolean),
    ("OutOfServiceState", Role::TwoState, DataTypeId::LocalizedText),
    // Of events alone; an instance need not have them.
    ("LocalTime", Role::Property, DataTypeId::TimeZoneDataType),
    ("ConditionSubClassId", Role::Property, DataTypeId::NodeId),
    ("ConditionSubClassName", Role::Property, DataTypeId::LocalizedText),
    ("SupportsFilteredRetain", Role::Property, DataTypeId::Boolean),
];

/// The fields that an instance has.
const ON_INSTANCE: usize = 23;

/// A method of a condition.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Method {
    /// Acknowledges the alarm.
    Acknowledge,
    /// Adds a comment, which the station does not keep.
    AddComment,
    /// Conditions are always enabled.
    Enable,
    /// A client disables no alarm.
    Disable,
    /// Sends the conditions that stand to one subscription.
    Refresh,
    /// The same to one monitored item.
    Refresh2,
}

impl Method {
    /// The methods that an instance has.
    const ON_INSTANCE: [(Self, &'static str); 4] = [
        (Self::Acknowledge, "Acknowledge"),
        (Self::AddComment, "AddComment"),
        (Self::Enable, "Enable"),
        (Self::Disable, "Disable"),
    ];

    /// The method with this identifier of OPC UA. Clients call it with a condition as the object.
    #[must_use]
    pub fn of_type(id: &NodeId) -> Option<Self> {
        Some(match id.as_method_id().ok()? {
            MethodId::AcknowledgeableConditionType_Acknowledge => Self::Acknowledge,
            MethodId::ConditionType_AddComment => Self::AddComment,
            MethodId::ConditionType_Enable => Self::Enable,
            MethodId::ConditionType_Disable => Self::Disable,
            MethodId::ConditionType_ConditionRefresh => Self::Refresh,
            MethodId::ConditionType_ConditionRefresh2 => Self::Refresh2,
            _ => return None,
        })
    }

    /// The method of an instance with this node.
    fn of_instance(id: &NodeId) -> Option<Self> {
        let opcua_types::Identifier::String(text) = &id.identifier else { return None };
        let (_, name) = text.as_ref().rsplit_once('/')?;
        Self::ON_INSTANCE.iter().find(|(_, own)| *own == name).map(|(method, _)| *method)
    }
}

/// An alarm as a condition, at one moment. It is the event that tells of it, too.
#[derive(Clone, Debug, PartialEq)]
pub struct Condition {
    alarm: Arc<str>,
    node: NodeId,
    source: NodeId,
    is_active: bool,
    is_acknowledged: bool,
    is_out_of_service: bool,
    is_shelved: bool,
    severity: u16,
    occurrence: i64,
    text: String,
    user: String,
    at: Micros,
}

impl Condition {
    /// Whether it is sent when a client asks for all conditions that stand.
    #[must_use]
    pub const fn is_retained(&self) -> bool {
        self.is_active || !self.is_acknowledged
    }

    /// The identifier of the event: occurrence and time, so that the acknowledgement of an earlier occurrence is refused.
    fn event_id(&self) -> ByteString {
        let suppression = u8::from(self.is_out_of_service) | (u8::from(self.is_shelved) << 1);
        let states = [u8::from(self.is_active), u8::from(self.is_acknowledged), suppression];
        let name = self.alarm.as_bytes();
        let octets = [&self.occurrence.to_be_bytes()[..], &self.at.0.to_be_bytes(), &states, name].concat();
        ByteString::from(octets)
    }

    /// The occurrence that an identifier of an event of this alarm names.
    fn occurrence_of(&self, event: &ByteString) -> Option<i64> {
        let octets = event.value.as_deref()?;
        let (occurrence, rest) = octets.split_first_chunk()?;
        let (_, rest) = rest.split_first_chunk::<8>()?;
        let (_, name) = rest.split_first_chunk::<3>()?;
        (name == self.alarm.as_bytes()).then(|| i64::from_be_bytes(*occurrence))
    }

    /// The value of a field: `["ActiveState"]`, `["ActiveState", "Id"]`.
    fn field(&self, path: &[&str]) -> Option<Variant> {
        let text = |text: &str| Variant::from(LocalizedText::new("", text));
        let two = |is: bool, yes: &str, no: &str| text(if is { yes } else { no });
        let at = || Variant::from(time(self.at));
        Some(match path {
            ["EventId"] => Variant::from(self.event_id()),
            ["EventType"] => Variant::from(NodeId::from(ObjectTypeId::AlarmConditionType)),
            ["SourceNode"] => Variant::from(self.source.clone()),
            ["SourceName" | "ConditionName"] => Variant::from(UAString::from(&*self.alarm)),
            ["Time" | "ReceiveTime"] => at(),
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
            ["Comment"] => text(""),
            ["ClientUserId"] => Variant::from(UAString::from(self.user.as_str())),
            ["AckedState"] => two(self.is_acknowledged, "Acknowledged", "Unacknowledged"),
            ["AckedState", "Id"] => Variant::from(self.is_acknowledged),
            ["ActiveState"] => two(self.is_active, "Active", "Inactive"),
            ["ActiveState", "Id"] => Variant::from(self.is_active),
            ["OutOfServiceState"] => two(self.is_out_of_service, "Out of service", "In service"),
            ["OutOfServiceState", "Id"] => Variant::from(self.is_out_of_service),
            ["SuppressedOrShelved"] => Variant::from(self.is_out_of_service || self.is_shelved),
            ["SupportsFilteredRetain"] => Variant::from(false),
            _ => return None,
        })
    }

    /// The nodes of the instance with their values.
    pub fn values(&self) -> impl Iterator<Item = (NodeId, Variant)> + '_ {
        let field = |path: &[&str]| {
            let id = format!("{}/{}", text_of(&self.node), path.join("/"));
            Some((NodeId::new(self.node.namespace, id), self.field(path)?))
        };
        FIELDS.iter().take(ON_INSTANCE).flat_map(move |(name, role, _)| {
            let second = second_of(*role).and_then(|second| field(&[name, second]));
            field(&[name]).into_iter().chain(second)
        })
    }
}

/// The field of a field: what tells the state as a Boolean, or since when it holds.
const fn second_of(role: Role) -> Option<&'static str> {
    match role {
        Role::Property => None,
        Role::TwoState => Some("Id"),
        Role::Timed => Some("SourceTimestamp"),
    }
}

fn text_of(id: &NodeId) -> &str {
    match &id.identifier {
        opcua_types::Identifier::String(text) => text.as_ref(),
        _ => "",
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

/// The beginning or the end of what `ConditionRefresh` sends.
#[derive(Debug)]
struct Bracket {
    event_type: NodeId,
    number: i64,
    at: DateTime,
}

impl EventField for Bracket {
    fn get_value(&self, attribute: AttributeId, _: &NumericRange, path: &[QualifiedName]) -> Variant {
        let [name] = path else { return Variant::Empty };
        if attribute != AttributeId::Value || name.namespace_index != 0 {
            return Variant::Empty;
        }
        match name.name.as_ref() {
            "EventId" => Variant::from(ByteString::from(self.number.to_be_bytes().to_vec())),
            "EventType" => Variant::from(self.event_type.clone()),
            "SourceNode" => Variant::from(NodeId::from(ObjectId::Server)),
            "SourceName" => Variant::from(UAString::from("Server")),
            "Time" | "ReceiveTime" => Variant::from(self.at),
            "Message" => Variant::from(LocalizedText::new("", "Refresh of the conditions")),
            "Severity" => Variant::from(SEVERITIES.first().copied().unwrap_or_default()),
            _ => Variant::Empty,
        }
    }
}

impl Event for Bracket {
    fn get_field(&self, _: &NodeId, attribute: AttributeId, range: &NumericRange, path: &[QualifiedName]) -> Variant {
        self.get_value(attribute, range, path)
    }

    fn time(&self) -> &DateTime {
        &self.at
    }

    fn event_type_id(&self) -> &NodeId {
        &self.event_type
    }
}

/// The positions of the points of an alarm.
struct Row {
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
    fn node(&self) -> String {
        format!("{}/condition", self.source())
    }

    /// Whether a point of the alarm has changed. The present value that an alarm watches is no part of the condition.
    fn differs(&self, new: &Snapshot, old: &Snapshot) -> bool {
        let version = |snapshot: &Snapshot, index: usize| snapshot.values.get(index).map(|value| value.version);
        let points = self.points.iter().filter(|(signal, _)| *signal != Signal::AlarmValue);
        points.copied().any(|(_, index)| version(new, index) != version(old, index))
    }

    fn condition(&self, namespace: u16, snapshot: &Snapshot) -> Option<Condition> {
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
        Some(Condition {
            alarm: Arc::clone(&self.alarm),
            node: NodeId::new(namespace, self.node()),
            source: NodeId::new(namespace, self.source()),
            is_active: is(Signal::AlarmActive),
            is_acknowledged: is(Signal::AlarmAcknowledged),
            is_out_of_service: state.value == Value::Choice(OUT_OF_SERVICE),
            is_shelved: state.value == Value::Choice(SHELVED),
            severity: SEVERITIES.get(priority).copied().unwrap_or(1),
            occurrence,
            text: text(Signal::AlarmText),
            user: text(Signal::AcknowledgedBy),
            at: state.at.unwrap_or_default(),
        })
    }
}

/// The positions of two states in [`ALARM_STATES`](profivac_gateway::signal::ALARM_STATES).
const OUT_OF_SERVICE: u16 = 4;
const SHELVED: u16 = 5;

/// The rows of the alarms of a list of points.
fn rows_of(snapshot: &Snapshot) -> Vec<Row> {
    let mut rows: BTreeMap<Arc<str>, Vec<(Signal, usize)>> = BTreeMap::new();
    for (index, point) in snapshot.points.iter().enumerate() {
        if let Subject::Alarm(name) = &point.subject {
            rows.entry(Arc::clone(name)).or_default().push((point.signal, index));
        }
    }
    rows.into_iter().map(|(alarm, points)| Row { alarm, points }).collect()
}

/// The conditions of the station, and what clients do with them.
pub struct Conditions {
    status: Arc<GatewayStatus>,
    commander: Option<Arc<Commander>>,
    present: Mutex<Present>,
    /// When subscriptions got their last refresh.
    refreshed: Mutex<BTreeMap<u32, Instant>>,
}

/// The alarms of the last snapshot.
#[derive(Default)]
struct Present {
    rows: Vec<Row>,
    /// By the identifier of the node.
    conditions: BTreeMap<String, Arc<Condition>>,
}

impl Conditions {
    /// No conditions yet. Without a commander no user acknowledges.
    #[must_use]
    pub fn new(status: Arc<GatewayStatus>, commander: Option<Arc<Commander>>) -> Self {
        Self { status, commander, present: Mutex::default(), refreshed: Mutex::default() }
    }

    /// Takes over the alarms of a snapshot, and returns those that differ from the snapshot before.
    pub fn update(&self, namespace: u16, snapshot: &Snapshot, before: Option<&Snapshot>) -> Vec<Arc<Condition>> {
        let mut present = self.present.lock().unwrap_or_else(PoisonError::into_inner);
        let Present { rows, conditions } = &mut *present;
        let before = before.filter(|before| before.has_points_of(snapshot));
        if before.is_none() {
            *rows = rows_of(snapshot);
            let nodes: BTreeSet<String> = rows.iter().map(Row::node).collect();
            conditions.retain(|id, _| nodes.contains(id));
        }
        let mut changed = Vec::new();
        for row in rows.iter().filter(|row| before.is_none_or(|before| row.differs(snapshot, before))) {
            let Some(condition) = row.condition(namespace, snapshot).map(Arc::new) else { continue };
            let old = conditions.insert(row.node(), Arc::clone(&condition));
            if old.as_ref() != Some(&condition) {
                changed.push(condition);
            }
        }
        changed
    }

    fn find(&self, node: &NodeId) -> Option<Arc<Condition>> {
        self.present.lock().unwrap_or_else(PoisonError::into_inner).conditions.get(text_of(node)).cloned()
    }

    /// Calls a method of a condition.
    ///
    /// # Errors
    /// The status for the client.
    pub async fn call(
        &self,
        context: &RequestContext,
        object: &NodeId,
        method: &NodeId,
        arguments: &[Variant],
    ) -> Result<(), StatusCode> {
        let found = Method::of_type(method).or_else(|| Method::of_instance(method));
        match (found.ok_or(StatusCode::BadMethodInvalid)?, arguments) {
            (Method::Refresh, [subscription]) => self.refresh(context, number(subscription)?, None),
            (Method::Refresh2, [subscription, item]) => {
                self.refresh(context, number(subscription)?, Some(number(item)?))
            }
            (Method::Acknowledge, [Variant::ByteString(event), _comment]) => {
                let condition = self.find(object).ok_or(StatusCode::BadNodeIdUnknown)?;
                let done = self.acknowledge(&context.token.0, &condition, event).await;
                done.map_err(|(status, reason)| {
                    self.status.refused(&format!("an acknowledgement of {}: {reason}", context.token.0));
                    status
                })
            }
            (Method::Enable, []) => Err(StatusCode::BadConditionAlreadyEnabled),
            (Method::Disable, []) | (Method::AddComment, [_, _]) => {
                self.status.refused(&format!("a call of {}: the gateway only acknowledges alarms", context.token.0));
                Err(StatusCode::BadUserAccessDenied)
            }
            (Method::Acknowledge, [_, _]) => Err(StatusCode::BadInvalidArgument),
            (_, []) | (Method::Acknowledge | Method::AddComment | Method::Refresh2, [_]) => {
                Err(StatusCode::BadArgumentsMissing)
            }
            _ => Err(StatusCode::BadTooManyArguments),
        }
    }

    async fn acknowledge(
        &self,
        user: &str,
        condition: &Condition,
        event: &ByteString,
    ) -> Result<(), (StatusCode, String)> {
        let denied = |reason: &str| (StatusCode::BadUserAccessDenied, reason.to_owned());
        let commander = self.commander.as_ref().ok_or_else(|| denied("the gateway is read-only"))?;
        if user == ANONYMOUS {
            return Err(denied("only users who log in acknowledge"));
        }
        let unknown = || (StatusCode::BadEventIdUnknown, "the event is not of this alarm".to_owned());
        let occurrence = condition.occurrence_of(event).ok_or_else(unknown)?;
        let request = WriteRequest::Acknowledge { alarm: Arc::clone(&condition.alarm), occurrence };
        commander.execute(user, request, None).await.map_err(|error| (status_of(&error), error.to_string()))
    }

    fn retained(&self) -> Vec<Arc<Condition>> {
        let present = self.present.lock().unwrap_or_else(PoisonError::into_inner);
        present.conditions.values().filter(|it| it.is_retained()).map(Arc::clone).collect()
    }

    /// Whether the last refresh of a subscription is long enough ago: a client that asks without end takes no processor from others.
    fn may_refresh(&self, subscription: u32, now: Instant) -> bool {
        let mut refreshed = self.refreshed.lock().unwrap_or_else(PoisonError::into_inner);
        refreshed.retain(|_, at| now.saturating_duration_since(*at) < REFRESH_PAUSE);
        let is_free = refreshed.len() < MAX_REFRESHES && !refreshed.contains_key(&subscription);
        if is_free {
            refreshed.insert(subscription, now);
        }
        is_free
    }

    /// Sends the conditions that stand to the event items of one subscription of the session.
    fn refresh(&self, context: &RequestContext, subscription: u32, item: Option<u32>) -> Result<(), StatusCode> {
        let retained = self.retained();
        let id = subscription;
        let session = context.subscriptions.get_session_subscriptions(context.session_id);
        let session = session.ok_or(StatusCode::BadSubscriptionIdInvalid)?;
        let type_tree = context.type_tree.read();
        let mut session = session.lock();
        let subscription = session.get_mut(subscription).ok_or(StatusCode::BadSubscriptionIdInvalid)?;
        let is_event = |id: &u32| {
            let found = subscription.get(id);
            found.is_some_and(|it| it.item_to_monitor().attribute_id == AttributeId::EventNotifier)
        };
        let items: Vec<u32> = match item {
            Some(item) => vec![item],
            None => subscription.items().map(|it| it.id()).filter(is_event).collect(),
        };
        if !items.iter().all(is_event) {
            return Err(StatusCode::BadMonitoredItemIdInvalid);
        }
        if !self.may_refresh(id, Instant::now()) {
            return Err(StatusCode::BadRefreshInProgress);
        }
        let now = Micros::now();
        let bracket = |kind: ObjectTypeId| Bracket { event_type: kind.into(), number: now.0, at: time(now) };
        let begin = bracket(ObjectTypeId::RefreshStartEventType);
        let end = bracket(ObjectTypeId::RefreshEndEventType);
        let retained = retained.iter().map(|it| &**it as &dyn Event);
        let events: Vec<&dyn Event> =
            std::iter::once(&begin as &dyn Event).chain(retained).chain([&end as _]).collect();
        let tree: &dyn TypeTree = &*type_tree;
        for item in items {
            events.iter().for_each(|event| subscription.notify_event(&item, *event, tree));
        }
        Ok(())
    }
}

fn number(value: &Variant) -> Result<u32, StatusCode> {
    if let Variant::UInt32(number) = value { Ok(*number) } else { Err(StatusCode::BadInvalidArgument) }
}

/// The status of an acknowledgement that was not done.
fn status_of(error: &WriteError) -> StatusCode {
    match error {
        WriteError::Busy => StatusCode::BadTooManyOperations,
        WriteError::Users(_) | WriteError::UnknownUser(_) | WriteError::Forbidden(_) => StatusCode::BadUserAccessDenied,
        WriteError::Alarm(AlarmServiceError::Refused(
            AlarmError::OccurrenceChanged { .. } | AlarmError::Unknown(_),
        )) => StatusCode::BadEventIdUnknown,
        WriteError::Alarm(AlarmServiceError::Refused(AlarmError::NotApplicable { .. })) => {
            StatusCode::BadConditionBranchAlreadyAcked
        }
        WriteError::Alarm(AlarmServiceError::NotStored) => StatusCode::BadResourceUnavailable,
        _ => StatusCode::BadInternalError,
    }
}

/// Makes the fields of conditions known to the check of event filters, which looks for a field in the very type that a client names,
/// and not in its parents; and which leaves out unknown fields, so that all later ones would move. The empty path is `ConditionId`.
pub fn register(tree: &mut DefaultTypeTree) {
    for kind in TYPES {
        let kind = NodeId::from(kind);
        tree.add_type_property(&kind, &kind, &[], NodeClass::Object);
        for (name, role, _) in FIELDS {
            let first = QualifiedName::new(0, name);
            tree.add_type_property(&kind, &kind, &[&first], NodeClass::Variable);
            if let Some(second) = second_of(role) {
                tree.add_type_property(&kind, &kind, &[&first, &QualifiedName::new(0, second)], NodeClass::Variable);
            }
        }
    }
}

/// Inserts the condition of the alarm at `source`.
pub fn insert(source: &NodeId, space: &mut AddressSpace) {
    let own = NodeId::new(source.namespace, format!("{}/condition", text_of(source)));
    ObjectBuilder::new(&own, QualifiedName::new(own.namespace, "Condition"), "Condition")
        .has_type_definition(ObjectTypeId::AlarmConditionType)
        .component_of(source.clone())
        .reference(source.clone(), ReferenceTypeId::HasCondition, ReferenceDirection::Inverse)
        .insert(space);
    for (name, role, data_type) in FIELDS.iter().take(ON_INSTANCE) {
        let id = NodeId::new(own.namespace, format!("{}/{name}", text_of(&own)));
        let field = VariableBuilder::new(&id, QualifiedName::new(0, *name), *name).data_type(*data_type);
        let field = match role {
            Role::Property => field.has_type_definition(VariableTypeId::PropertyType).property_of(own.clone()),
            Role::TwoState => field.has_type_definition(VariableTypeId::TwoStateVariableType).component_of(own.clone()),
            Role::Timed => field.has_type_definition(VariableTypeId::ConditionVariableType).component_of(own.clone()),
        };
        field.insert(space);
        if let Some(second) = second_of(*role) {
            let data_type = if *role == Role::TwoState { DataTypeId::Boolean } else { DataTypeId::UtcTime };
            let second_id = NodeId::new(own.namespace, format!("{}/{second}", text_of(&id)));
            VariableBuilder::new(&second_id, QualifiedName::new(0, second), second)
                .data_type(data_type)
                .has_type_definition(VariableTypeId::PropertyType)
                .property_of(id)
                .insert(space);
        }
    }
    for (method, name) in Method::ON_INSTANCE {
        insert_method(&own, method, name, space);
    }
}

fn insert_method(own: &NodeId, method: Method, name: &str, space: &mut AddressSpace) {
    let id = NodeId::new(own.namespace, format!("{}/{name}", text_of(own)));
    let builder = MethodBuilder::new(&id, QualifiedName::new(0, name), name).component_of(own.clone());
    if matches!(method, Method::Acknowledge | Method::AddComment) {
        let argument = |name: &str, data_type: DataTypeId, description: &str| Argument {
            name: name.into(),
            data_type: data_type.into(),
            value_rank: -1,
            array_dimensions: None,
            description: LocalizedText::new("", description),
        };
        let arguments = [
            argument("EventId", DataTypeId::ByteString, "The event that the user has seen"),
            argument("Comment", DataTypeId::LocalizedText, "Not kept by the station"),
        ];
        let id = NodeId::new(own.namespace, format!("{}/{name}/InputArguments", text_of(own)));
        builder.input_args(space, &id, &arguments).insert(space);
    } else {
        builder.insert(space);
    }
}

/// Deletes the condition of the alarm at `source`.
pub fn delete(source: &NodeId, space: &mut AddressSpace) {
    let own = format!("{}/condition", text_of(source));
    let node = |id: String| NodeId::new(source.namespace, id);
    for (name, role, _) in FIELDS.iter().take(ON_INSTANCE) {
        if let Some(second) = second_of(*role) {
            space.delete(&node(format!("{own}/{name}/{second}")), true);
        }
        space.delete(&node(format!("{own}/{name}")), true);
    }
    for (_, name) in Method::ON_INSTANCE {
        space.delete(&node(format!("{own}/{name}/InputArguments")), true);
        space.delete(&node(format!("{own}/{name}")), true);
    }
    space.delete(&node(own), true);
}

#[cfg(test)]
#[allow(clippy::unwrap_used, reason = "a test")]
mod tests {
    use super::*;
    use profivac_gateway::Inputs;
    use profivac_gateway::model::Modeller;
    use profivac_station::alarm::AlarmState;
    use profivac_station::config::Config;
    use profivac_station::gateway_status::GatewayStatuses;
    use std::path::Path;

    const PLANT: &str = r#"
        [[segment]]
        name = "hall"
        port = "sim:hall.toml"
        [[segment.gauge]]
        name = "chamber"
        address = 5
        device = "bcg450"
        [[alarm]]
        name = "a/b"
        gauge = "chamber"
        above = "1e-3 mbar"
        priority = "high"
    "#;

    fn inputs() -> Inputs {
        Inputs::planned(&Config::parse(PLANT, Path::new("plant.toml")).unwrap())
    }

    fn with(state: AlarmState, occurrence: i64) -> Inputs {
        let mut inputs = inputs();
        let alarm = inputs.alarms.iter_mut().find(|alarm| alarm.name == "a/b").unwrap();
        (alarm.state, alarm.occurrence) = (state, occurrence);
        inputs
    }

    fn conditions() -> Conditions {
        Conditions::new(GatewayStatuses::default().add("opcua"), None)
    }

    fn condition(state: AlarmState, occurrence: i64) -> Arc<Condition> {
        let snapshot = Modeller::default().next(with(state, occurrence), Micros(1));
        let changed = conditions().update(2, &snapshot, None);
        changed.into_iter().find(|it| &*it.alarm == "a/b").unwrap()
    }

    fn is(condition: &Condition, path: &[&str]) -> bool {
        condition.field(path) == Some(Variant::Boolean(true))
    }

    #[test]
    fn the_states_of_an_alarm_are_those_of_the_table() {
        for (state, row) in [
            (AlarmState::Normal, [false, true, false, false, false]),
            (AlarmState::Unacknowledged, [true, false, false, false, true]),
            (AlarmState::Acknowledged, [true, true, false, false, true]),
            (AlarmState::Returned, [false, false, false, false, true]),
            (AlarmState::OutOfService, [false, true, true, true, false]),
            (AlarmState::Shelved, [false, true, false, true, false]),
        ] {
            let condition = condition(state, 1);
            let paths: [&[&str]; 5] = [
                &["ActiveState", "Id"],
                &["AckedState", "Id"],
                &["OutOfServiceState", "Id"],
                &["SuppressedOrShelved"],
                &["Retain"],
            ];
            assert_eq!(paths.map(|path| is(&condition, path)), row, "{state:?}");
        }
    }

    #[test]
    fn an_event_belongs_to_one_occurrence_of_one_alarm() {
        let (first, second) = (condition(AlarmState::Unacknowledged, 1), condition(AlarmState::Unacknowledged, 2));
        assert_eq!(second.occurrence_of(&first.event_id()), Some(1));
        assert_ne!(first.event_id(), second.event_id());
        let other = Condition { alarm: Arc::from("other"), ..(*first).clone() };
        assert_eq!(other.occurrence_of(&first.event_id()), None);
        for octets in [vec![], vec![0; 8], vec![0; 18], vec![0xFF; 5000]] {
            assert_eq!(first.occurrence_of(&ByteString::from(octets)), None);
        }
        assert_eq!(first.occurrence_of(&ByteString::null()), None);
    }

    #[test]
    fn only_alarms_that_differ_are_told_and_removed_ones_are_gone() {
        let (mut modeller, conditions) = (Modeller::default(), conditions());
        let first = modeller.next(with(AlarmState::Normal, 0), Micros(1));
        assert_eq!(conditions.update(2, &first, None).len(), inputs().alarms.len());
        let same = modeller.next(with(AlarmState::Normal, 0), Micros(2));
        assert_eq!(conditions.update(2, &same, Some(&first)), []);
        let raised = modeller.next(with(AlarmState::Unacknowledged, 1), Micros(3));
        let told = conditions.update(2, &raised, Some(&same));
        assert_eq!(told.iter().map(|it| &*it.alarm).collect::<Vec<_>>(), ["a/b"]);
        let node = told.first().unwrap().node.clone();
        assert_eq!(text_of(&node), "alarm/a%2Fb/condition");
        let mut inputs = with(AlarmState::Unacknowledged, 1);
        inputs.alarms.retain(|alarm| alarm.name != "a/b");
        let without = modeller.next(inputs, Micros(4));
        assert_eq!(conditions.update(2, &without, Some(&raised)), []);
        assert!(conditions.find(&node).is_none());
    }

    #[test]
    fn a_subscription_is_refreshed_once_a_second_and_all_together_not_without_end() {
        let (conditions, now) = (conditions(), Instant::now());
        assert!(conditions.may_refresh(1, now));
        assert!(!conditions.may_refresh(1, now + REFRESH_PAUSE / 2));
        assert!(conditions.may_refresh(1, now + REFRESH_PAUSE));
        let granted = (2..100).filter(|id| conditions.may_refresh(*id, now + REFRESH_PAUSE)).count();
        assert_eq!(granted, MAX_REFRESHES - 1);
    }

    #[test]
    fn every_field_of_an_instance_has_a_value() {
        let condition = condition(AlarmState::Normal, 0);
        let expected: usize =
            FIELDS.iter().take(ON_INSTANCE).map(|(_, role, _)| 1 + usize::from(second_of(*role).is_some())).sum();
        assert_eq!(condition.values().count(), expected);
    }

    #[test]
    fn what_is_inserted_is_deleted_whole() {
        let mut space = AddressSpace::new();
        space.add_namespace("urn:test", 2);
        let source = NodeId::new(2, "alarm/x");
        insert(&source, &mut space);
        let own = NodeId::new(2, "alarm/x/condition/Acknowledge/InputArguments");
        assert!(space.node_exists(&own));
        delete(&source, &mut space);
        for (name, _, _) in FIELDS {
            assert!(!space.node_exists(&NodeId::new(2, format!("alarm/x/condition/{name}"))), "{name}");
        }
        assert!(!space.node_exists(&own) && !space.node_exists(&NodeId::new(2, "alarm/x/condition")));
    }
}
