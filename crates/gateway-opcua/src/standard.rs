//! The nodes of OPC UA itself, with the methods of conditions.
//!
//! A client acknowledges with the identifier that OPC UA gives the method, and asks for a refresh at the type of conditions (OPC 10000-9,
//! 5.5.7 and 5.7.3). The library hands such a call to the manager of its own nodes, which knows no conditions: this manager stands in its
//! place, answers these calls, and passes everything else on.

use crate::abandoned::Abandoned;
use crate::alarms::{Conditions, Method};
use async_trait::async_trait;
use opcua_server::CreateMonitoredItem;
use opcua_server::address_space::DefaultTypeTree;
use opcua_server::diagnostics::NamespaceMetadata;
use opcua_server::node_manager::memory::{CoreNodeManagerBuilder, InMemoryNodeManagerBuilder};
use opcua_server::node_manager::{
    BrowseNode, BrowsePathItem, DynNodeManager, ExternalReferenceRequest, MethodCall, MonitoredItemRef,
    MonitoredItemUpdateRef, NodeManager, NodeManagerBuilder, ReadNode, RegisterNodeItem, RequestContext, ServerContext,
};
use opcua_types::{AttributeId, MonitoringMode, NodeId, StatusCode, TimestampsToReturn};
use std::fmt::{self, Debug, Write};
use std::sync::Arc;

/// The queue of a value that is not an event.
pub const VALUE_QUEUE: usize = 4;

/// The most items of events of a session: each has a long queue.
const MAX_EVENT_ITEMS: usize = 2;

/// The longest description of a filter in octets: some 500 fields.
const MAX_FILTER: usize = 128 << 10;

/// The manager.
pub struct Standard {
    inner: Arc<DynNodeManager>,
    conditions: Arc<Conditions>,
    abandoned: Arc<Abandoned>,
}

impl Standard {
    /// The builder for the server.
    #[must_use]
    pub fn builder(conditions: Arc<Conditions>, abandoned: Arc<Abandoned>) -> impl NodeManagerBuilder + 'static {
        move |context: ServerContext| {
            let inner = Box::new(InMemoryNodeManagerBuilder::new(CoreNodeManagerBuilder));
            Self { inner: inner.build(context), conditions, abandoned }
        }
    }
}

#[async_trait]
impl NodeManager for Standard {
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
        limit_queues(items.iter_mut().map(|item| &mut **item));
        self.abandoned.made(context.session_id, items.iter().map(|item| &**item));
        let mut places = MAX_EVENT_ITEMS.saturating_sub(event_items(context));
        let (mut accepted, mut refused) = (Vec::new(), Vec::new());
        for item in items {
            let is_event = item.item_to_monitor().attribute_id == AttributeId::EventNotifier;
            if is_event && (places == 0 || !is_short(item.filter())) {
                refused.push(&mut **item);
            } else {
                places = places.saturating_sub(usize::from(is_event));
                accepted.push(&mut **item);
            }
        }
        for item in refused {
            item.set_status(StatusCode::BadTooManyMonitoredItems);
        }
        self.inner.create_monitored_items(context, &mut accepted).await
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

    async fn call(&self, context: &RequestContext, calls: &mut [&mut MethodCall]) -> Result<(), StatusCode> {
        let (mut own, mut others) = (Vec::new(), Vec::new());
        for call in calls {
            let is_own = Method::of_type(call.method_id()).is_some();
            if is_own { own.push(&mut **call) } else { others.push(&mut **call) }
        }
        for call in own {
            let done = self.conditions.call(context, call.object_id(), call.method_id(), call.arguments()).await;
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

/// Whether a filter has few fields. The library does not tell their number, so this is the length of its description.
fn is_short(filter: &impl Debug) -> bool {
    struct Rest(usize);
    impl Write for Rest {
        fn write_str(&mut self, text: &str) -> fmt::Result {
            self.0 = self.0.checked_sub(text.len()).ok_or(fmt::Error)?;
            Ok(())
        }
    }
    write!(Rest(MAX_FILTER), "{filter:?}").is_ok()
}

/// Events wait in a long queue, values in a short one: the library has one limit for both.
pub fn limit_queues<'a>(items: impl Iterator<Item = &'a mut CreateMonitoredItem>) {
    for item in items.filter(|item| item.item_to_monitor().attribute_id != AttributeId::EventNotifier) {
        item.revise_queue_size(VALUE_QUEUE);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_filter_with_thousands_of_fields_is_not_short() {
        assert!(is_short(&vec!["a field of an event, with its type and its range"; 300]));
        assert!(!is_short(&vec!["a field of an event, with its type and its range"; 20_000]));
    }
}
