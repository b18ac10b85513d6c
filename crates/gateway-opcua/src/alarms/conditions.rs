//! All conditions of the station, and the refresh for a client that starts.

use super::SEVERITIES;
use super::condition::Condition;
use super::fields::{SHELVING, text_of};
use super::rows::{Row, rows_of};
use crate::value::time;
use opcua_server::address_space::{Event, EventField, TypeTree};
use opcua_server::node_manager::RequestContext;
use opcua_types::{
    AttributeId, ByteString, DateTime, LocalizedText, NodeId, NumericRange, ObjectId, ObjectTypeId, QualifiedName,
    StatusCode, UAString, Variant,
};
use profivac_gateway::{Commander, Snapshot};
use profivac_recorder::Micros;
use profivac_station::gateway_status::GatewayStatus;
use std::collections::{BTreeMap, BTreeSet};
use std::sync::{Arc, Mutex, PoisonError};
use std::time::{Duration, Instant};

/// The shortest time between two refreshes of a subscription. chosen: as fast as a person can ask.
pub(super) const REFRESH_PAUSE: Duration = Duration::from_secs(1);

/// The most refreshes of all clients in that time.
pub(super) const MAX_REFRESHES: usize = 16;

/// The conditions of the station, and what clients do with them.
pub struct Conditions {
    pub(super) status: Arc<GatewayStatus>,
    pub(super) commander: Option<Arc<Commander>>,
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

    /// The times until the shelved alarms are unshelved, by node: they pass without a change of the alarm.
    pub fn countdowns(&self, now: Micros) -> Vec<(NodeId, Variant)> {
        let present = self.present.lock().unwrap_or_else(PoisonError::into_inner);
        present.conditions.values().filter_map(|condition| condition.countdown(now)).collect()
    }

    /// The condition with this node, or with this node as its state of shelving.
    pub(super) fn find(&self, node: &NodeId) -> Option<Arc<Condition>> {
        let (present, id) = (self.present.lock().unwrap_or_else(PoisonError::into_inner), text_of(node));
        let id = id.strip_suffix(SHELVING).and_then(|id| id.strip_suffix('/')).unwrap_or(id);
        present.conditions.get(id).cloned()
    }

    fn retained(&self) -> Vec<Arc<Condition>> {
        let present = self.present.lock().unwrap_or_else(PoisonError::into_inner);
        present.conditions.values().filter(|it| it.is_retained()).map(Arc::clone).collect()
    }

    /// Whether the last refresh of a subscription is long enough ago: a client that asks without end takes no processor from others.
    pub(super) fn may_refresh(&self, subscription: u32, now: Instant) -> bool {
        let mut refreshed = self.refreshed.lock().unwrap_or_else(PoisonError::into_inner);
        refreshed.retain(|_, at| now.saturating_duration_since(*at) < REFRESH_PAUSE);
        let is_free = refreshed.len() < MAX_REFRESHES && !refreshed.contains_key(&subscription);
        if is_free {
            refreshed.insert(subscription, now);
        }
        is_free
    }

    /// Sends the conditions that stand to the event items of one subscription of the session.
    ///
    /// # Errors
    /// The status for the client.
    pub(super) fn refresh(
        &self,
        context: &RequestContext,
        subscription: u32,
        item: Option<u32>,
    ) -> Result<(), StatusCode> {
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
