//! A guard before the managers of the library: the limits of monitored items, and the methods of conditions.
//!
//! A client acknowledges with the identifier that OPC UA gives the method, and asks for a refresh at the type of conditions (OPC 10000-9,
//! 5.5.7 and 5.7.3). The library hands such a call to the manager of its own nodes, which knows no conditions: the [`Guard`] of that
//! manager answers these calls. Everything else passes on, except monitored items that would take too much.

use crate::abandoned::{Abandoned, MAX_EVENT_ITEMS, VALUE_QUEUE};
use crate::alarms::{Conditions, Method};
use async_trait::async_trait;
use opcua_server::CreateMonitoredItem;
use opcua_server::address_space::{AddressSpace, DefaultTypeTree};
use opcua_server::diagnostics::NamespaceMetadata;
use opcua_server::node_manager::memory::{
    CoreNodeManagerBuilder, InMemoryNodeManager, InMemoryNodeManagerBuilder, InMemoryNodeManagerImpl,
    InMemoryNodeManagerImplBuilder,
};
use opcua_server::node_manager::{
    BrowseNode, BrowsePathItem, DynNodeManager, ExternalReferenceRequest, HistoryNode, MethodCall, MonitoredItemRef,
    MonitoredItemUpdateRef, NodeManager, NodeManagerBuilder, ReadNode, RegisterNodeItem, RequestContext, ServerContext,
    WriteNode,
};
use opcua_types::{AttributeId, MonitoringMode, NodeId, ReadRawModifiedDetails, StatusCode, TimestampsToReturn};
use parking_lot::RwLock;
use std::fmt::{self, Debug, Write};
use std::sync::{Arc, OnceLock};

/// A manager of the library with limits.
pub struct Guard {
    inner: Arc<DynNodeManager>,
    space: Arc<RwLock<AddressSpace>>,
    abandoned: Arc<Abandoned>,
    /// Answers the methods of the types of conditions, before the manager of the nodes of OPC UA itself.
    conditions: Option<Arc<Conditions>>,
}

/// Where the builder of a manager puts it.
pub type Built<T> = Arc<OnceLock<Arc<InMemoryNodeManager<T>>>>;

impl Guard {
    /// The builder of the manager of the nodes of OPC UA itself.
    #[must_use]
    pub fn of_standard(conditions: Arc<Conditions>, abandoned: Arc<Abandoned>) -> impl NodeManagerBuilder + 'static {
        Self::of(CoreNodeManagerBuilder, Built::default(), Some(conditions), abandoned)
    }

    /// The builder of another manager, which is in `built` from then on.
    #[must_use]
    pub fn of<B>(
        builder: B,
        built: Built<B::Impl>,
        conditions: Option<Arc<Conditions>>,
        abandoned: Arc<Abandoned>,
    ) -> impl NodeManagerBuilder + 'static
    where
        B: InMemoryNodeManagerImplBuilder + 'static,
        B::Impl: InMemoryNodeManagerImpl,
    {
        move |context: ServerContext| {
            let inner = Box::new(InMemoryNodeManagerBuilder::new(builder)).build(context);
            let typed = Arc::clone(&inner).into_any_arc().downcast::<InMemoryNodeManager<B::Impl>>();
            let space = typed.as_ref().map(|typed| Arc::clone(typed.address_space())).unwrap_or_default();
            if let Ok(typed) = typed {
                built.set(typed).ok();
            }
            Self { inner, space, abandoned, conditions }
        }
    }

    /// Limits the items, and passes on those that are not refused.
    fn accepted<'a>(
        &self,
        context: &RequestContext,
        items: &'a mut [&mut CreateMonitoredItem],
    ) -> Vec<&'a mut CreateMonitoredItem> {
        let mut places = MAX_EVENT_ITEMS.saturating_sub(event_items(context));
        let space = self.space.read();
        let mut accepted = Vec::with_capacity(items.len());
        for item in items {
            let wanted = item.item_to_monitor();
            let is_event = wanted.attribute_id == AttributeId::EventNotifier;
            // The library keeps an entry for each node that was ever monitored, also for one that does not exist.
            let refusal = if !space.node_exists(&wanted.node_id) {
                Some(StatusCode::BadNodeIdUnknown)
            } else if is_event && places == 0 {
                Some(StatusCode::BadTooManyMonitoredItems)
            } else if !is_event && is_event_filter(item.filter()) {
                Some(StatusCode::BadFilterNotAllowed)
            } else {
                None
            };
            if let Some(status) = refusal {
                item.set_status(status);
                continue;
            }
            if is_event {
                places = places.saturating_sub(1);
            } else {
                // The library has one limit for both.
                item.revise_queue_size(VALUE_QUEUE);
            }
            accepted.push(&mut **item);
        }
        accepted
    }
}

#[async_trait]
impl NodeManager for Guard {
    fn owns_node(&self, id: &NodeId) -> bool {
        self.inner.owns_node(id)
    }

    fn name(&self) -> &str {
        self.inner.name()
    }

    fn namespaces_for_user(&self, context: &RequestContext) -> Vec<NamespaceMetadata> {
        self.inner.namespaces_for_user(context)
    }

    async fn init(&self, type_tree: &mut DefaultTypeTree, context: ServerContext) {
        self.inner.init(type_tree, context).await;
    }

    async fn resolve_external_references(&self, context: &RequestContext, items: &mut [&mut ExternalReferenceRequest]) {
        self.inner.resolve_external_references(context, items).await;
    }

    async fn read(
        &self,
        context: &RequestContext,
        max_age: f64,
        timestamps: TimestampsToReturn,
        nodes: &mut [&mut ReadNode],
    ) -> Result<(), StatusCode> {
        self.inner.read(context, max_age, timestamps, nodes).await
    }

    async fn browse(&self, context: &RequestContext, nodes: &mut [BrowseNode]) -> Result<(), StatusCode> {
        self.inner.browse(context, nodes).await
    }

    async fn translate_browse_paths_to_node_ids(
        &self,
        context: &RequestContext,
        nodes: &mut [&mut BrowsePathItem],
    ) -> Result<(), StatusCode> {
        self.inner.translate_browse_paths_to_node_ids(context, nodes).await
    }

    async fn register_nodes(
        &self,
        context: &RequestContext,
        nodes: &mut [&mut RegisterNodeItem],
    ) -> Result<(), StatusCode> {
        self.inner.register_nodes(context, nodes).await
    }

    async fn unregister_nodes(&self, context: &RequestContext, nodes: &[&NodeId]) -> Result<(), StatusCode> {
        self.inner.unregister_nodes(context, nodes).await
    }

    async fn create_monitored_items(
        &self,
        context: &RequestContext,
        items: &mut [&mut CreateMonitoredItem],
    ) -> Result<(), StatusCode> {
        let mut accepted = self.accepted(context, items);
        let created = self.inner.create_monitored_items(context, &mut accepted).await;
        if created.is_ok() {
            self.abandoned.made(context.session_id, accepted.iter().map(|item| &**item));
        }
        created
    }

    async fn modify_monitored_items(&self, context: &RequestContext, items: &[&MonitoredItemUpdateRef]) {
        self.inner.modify_monitored_items(context, items).await;
    }

    async fn set_monitoring_mode(&self, context: &RequestContext, mode: MonitoringMode, items: &[&MonitoredItemRef]) {
        self.inner.set_monitoring_mode(context, mode, items).await;
    }

    async fn delete_monitored_items(&self, context: &RequestContext, items: &[&MonitoredItemRef]) {
        self.inner.delete_monitored_items(context, items).await;
    }

    async fn write(&self, context: &RequestContext, nodes: &mut [&mut WriteNode]) -> Result<(), StatusCode> {
        self.inner.write(context, nodes).await
    }

    async fn history_read_raw_modified(
        &self,
        context: &RequestContext,
        details: &ReadRawModifiedDetails,
        nodes: &mut [&mut HistoryNode],
        timestamps: TimestampsToReturn,
    ) -> Result<(), StatusCode> {
        self.inner.history_read_raw_modified(context, details, nodes, timestamps).await
    }

    async fn call(&self, context: &RequestContext, calls: &mut [&mut MethodCall]) -> Result<(), StatusCode> {
        let Some(conditions) = &self.conditions else { return self.inner.call(context, calls).await };
        let (mut own, mut others) = (Vec::new(), Vec::new());
        for call in calls {
            let is_own = Method::of_type(call.method_id()).is_some();
            if is_own { own.push(&mut **call) } else { others.push(&mut **call) }
        }
        for call in own {
            let done = conditions.call(context, call.object_id(), call.method_id(), call.arguments()).await;
            call.set_status(done.err().unwrap_or(StatusCode::Good));
        }
        if others.is_empty() { Ok(()) } else { self.inner.call(context, &mut others).await }
    }
}

/// The items of events that a session has.
fn event_items(context: &RequestContext) -> usize {
    let Some(session) = context.subscriptions.get_session_subscriptions(context.session_id) else { return 0 };
    let session = session.lock();
    let subscriptions = session.subscription_ids().into_iter().filter_map(|id| session.get(id));
    let items = subscriptions.flat_map(|subscription| subscription.items());
    items.filter(|item| item.item_to_monitor().attribute_id == AttributeId::EventNotifier).count()
}

/// Whether a filter is one of events. The library keeps its type to itself, so this reads the name with which its description begins.
fn is_event_filter(filter: &impl Debug) -> bool {
    struct Name(bool);
    impl Write for Name {
        fn write_str(&mut self, text: &str) -> fmt::Result {
            self.0 = text == "EventFilter";
            Err(fmt::Error)
        }
    }
    let mut name = Name(false);
    write!(name, "{filter:?}").ok();
    name.0
}

#[cfg(test)]
mod tests {
    use super::*;

    #[derive(Debug)]
    #[expect(dead_code, reason = "Debug reads it")]
    struct EventFilter(u8);

    #[test]
    fn a_filter_of_events_is_told_by_its_name() {
        assert!(is_event_filter(&EventFilter(0)));
        assert!(!is_event_filter(&Some(EventFilter(0))));
        assert!(!is_event_filter(&"EventFilter"));
    }
}
