//! The station's part of the server: its namespace, reading of history, and writes.

use crate::abandoned::{Abandoned, Rest};
use crate::alarms::{self, ANONYMOUS, Conditions};
use crate::history::{self, Answer, Query};
use crate::plan::{History, NAMESPACE};
use crate::space::Parameter;
use crate::types::{self, Namespaces};
use crate::value;
use async_trait::async_trait;
use opcua_server::ContinuationPoint;
use opcua_server::CreateMonitoredItem;
use opcua_server::address_space::AddressSpace;
use opcua_server::diagnostics::NamespaceMetadata;
use opcua_server::node_manager::memory::{
    InMemoryNodeManager, InMemoryNodeManagerImpl, InMemoryNodeManagerImplBuilder,
};
use opcua_server::node_manager::{HistoryNode, MethodCall, ParsedWriteValue, RequestContext, ServerContext, WriteNode};
use opcua_types::{AttributeId, HistoryData, NodeId, ReadRawModifiedDetails, StatusCode, TimestampsToReturn};
use parking_lot::RwLock;
use profivac_gateway::command::given;
use profivac_gateway::{Commander, WriteError, WriteRequest};
use profivac_station::control::{ControlError, OperationError};
use profivac_station::gateway_status::GatewayStatus;
use profivac_station::services::Services;
use std::collections::HashMap;
use std::sync::{Arc, Mutex, PoisonError};
use std::time::Duration;
use tokio::sync::{OwnedSemaphorePermit, Semaphore};
use tokio::time::{Instant, timeout_at};

/// Queries of the record that run at the same time.
const MAX_QUERIES: usize = 2;

/// The time for all nodes of one request: what has not begun by then is refused.
const REQUEST_TIMEOUT: Duration = Duration::from_secs(10);

/// The node manager of the station.
pub type StationNodes = InMemoryNodeManager<StationNodesImpl>;

/// What the node manager needs of the station.
pub struct StationNodesBuilder {
    /// The station.
    pub services: Arc<Services>,
    /// Where refused writes are counted.
    pub status: Arc<GatewayStatus>,
    /// Writes for users who log in, if the file permits it.
    pub commander: Option<Arc<Commander>>,
    /// The alarms as conditions.
    pub conditions: Arc<Conditions>,
    /// What clients leave in memory.
    pub abandoned: Arc<Abandoned>,
}

impl InMemoryNodeManagerImplBuilder for StationNodesBuilder {
    type Impl = StationNodesImpl;

    fn build(self, context: ServerContext, space: &mut AddressSpace) -> StationNodesImpl {
        let mut tree = context.type_tree.write();
        let mut namespace = |uri| {
            let index = tree.namespaces_mut().add_namespace(uri);
            space.add_namespace(uri, index);
            index
        };
        // The station comes first, so that its index does not depend on the specifications that are used.
        let namespaces =
            Namespaces { station: namespace(NAMESPACE), di: namespace(types::DI), pa_dim: namespace(types::PA_DIM) };
        // Later, with clients, a writer of the tree could wait for a reader that reads it a second time.
        alarms::register(&mut tree);
        drop(tree);
        types::insert(namespaces, space);
        StationNodesImpl {
            namespaces,
            conditions: self.conditions,
            abandoned: self.abandoned,
            services: self.services,
            status: self.status,
            commander: self.commander,
            histories: Mutex::default(),
            parameters: Mutex::default(),
            slots: Arc::new(Semaphore::new(MAX_QUERIES)),
        }
    }
}

/// The station's part of the server.
pub struct StationNodesImpl {
    namespaces: Namespaces,
    conditions: Arc<Conditions>,
    abandoned: Arc<Abandoned>,
    services: Arc<Services>,
    status: Arc<GatewayStatus>,
    commander: Option<Arc<Commander>>,
    /// The parameters that users write, by node.
    parameters: Mutex<HashMap<NodeId, Parameter>>,
    /// What the recorder keeps of the nodes that have a history.
    histories: Mutex<HashMap<NodeId, History>>,
    slots: Arc<Semaphore>,
}

impl StationNodesImpl {
    /// The indexes of the namespaces.
    #[must_use]
    pub const fn namespaces(&self) -> Namespaces {
        self.namespaces
    }

    /// The alarms as conditions.
    #[must_use]
    pub const fn conditions(&self) -> &Arc<Conditions> {
        &self.conditions
    }

    /// Sets which nodes have a history.
    pub fn set_histories(&self, histories: HashMap<NodeId, History>) {
        *self.histories.lock().unwrap_or_else(PoisonError::into_inner) = histories;
    }

    /// Whether users who log in may write.
    #[must_use]
    pub const fn may_write(&self) -> bool {
        self.commander.is_some()
    }

    /// Sets which nodes are parameters that users write.
    pub fn set_parameters(&self, parameters: HashMap<NodeId, Parameter>) {
        *self.parameters.lock().unwrap_or_else(PoisonError::into_inner) = parameters;
    }

    /// Writes one value for the user of a session; the error has the status and why.
    async fn write_one(&self, user: &str, write: &ParsedWriteValue) -> Result<(), (StatusCode, String)> {
        let read_only = || (StatusCode::BadNotWritable, "the gateway is read-only for this node".to_owned());
        let commander = self.commander.as_ref().ok_or_else(read_only)?;
        if write.attribute_id != AttributeId::Value || write.index_range.has_range() {
            return Err(read_only());
        }
        let parameters = self.parameters.lock().unwrap_or_else(PoisonError::into_inner).get(&write.node_id).cloned();
        let Parameter { gauge, target, signal } = parameters.ok_or_else(read_only)?;
        if user == ANONYMOUS {
            return Err((StatusCode::BadUserAccessDenied, "only users who log in write".to_owned()));
        }
        let mismatch = || (StatusCode::BadTypeMismatch, "the value has another type than the node".to_owned());
        let value = write.value.value.as_ref().and_then(value::given).ok_or_else(mismatch)?;
        let request = WriteRequest::Parameter { gauge, target, value: given(signal, &value) };
        commander.execute(user, request, None).await.map_err(|error| (write_status(&error), error.to_string()))
    }

    fn history(&self, node: &NodeId) -> Option<History> {
        self.histories.lock().unwrap_or_else(PoisonError::into_inner).get(node).cloned()
    }

    /// Reads the record on a blocking thread, as soon as a slot is free.
    async fn read_record(
        &self,
        history: History,
        query: Query,
        limit: u32,
        deadline: Instant,
    ) -> Result<Answer, StatusCode> {
        let slot = slot_before(deadline, &self.slots).await?;
        let services = Arc::clone(&self.services);
        let task = tokio::task::spawn_blocking(move || {
            let _slot = slot;
            let reader = services.recorder().open_reader()?;
            history::read(&reader, &history, query, limit)
        });
        match task.await {
            Ok(Ok(answer)) => Ok(answer),
            Ok(Err(error)) => {
                self.status.error(&format!("the history cannot be read: {error}"));
                Err(StatusCode::BadResourceUnavailable)
            }
            Err(_) => Err(StatusCode::BadInternalError),
        }
    }

    async fn read_history(
        &self,
        details: &ReadRawModifiedDetails,
        node: &mut HistoryNode,
        deadline: Instant,
    ) -> Result<(), StatusCode> {
        let history = self.history(node.node_id()).ok_or(StatusCode::BadHistoryOperationUnsupported)?;
        let (asked, limit) = history::query(details)?;
        let query = match node.continuation_point() {
            None => asked,
            Some(point) => point.get::<Rest>().ok_or(StatusCode::BadContinuationPointInvalid)?.query,
        };
        let is_first = node.continuation_point().is_none();
        let answer = self.read_record(history, query, limit, deadline).await?;
        let Answer { values, rest } = match details.return_bounds {
            true => history::with_bounds(answer, query, is_first, limit),
            false => answer,
        };
        node.set_status(if values.is_empty() { StatusCode::GoodNoData } else { StatusCode::Good });
        node.set_result(HistoryData { data_values: Some(values) });
        let rest = rest.map(|query| Box::new(self.abandoned.rest(query)));
        node.set_next_continuation_point(rest.map(ContinuationPoint::new));
        Ok(())
    }
}

#[async_trait]
impl InMemoryNodeManagerImpl for StationNodesImpl {
    async fn init(&self, _space: &mut AddressSpace, _context: ServerContext) {}

    async fn create_value_monitored_items(
        &self,
        context: &RequestContext,
        space: &RwLock<AddressSpace>,
        items: &mut [&mut &mut CreateMonitoredItem],
    ) {
        let space = space.read();
        for item in items {
            item.set_initial_value(space.read(context, item.item_to_monitor(), 0.0, TimestampsToReturn::Both));
            item.set_status(StatusCode::Good);
        }
    }

    async fn call(
        &self,
        context: &RequestContext,
        _space: &RwLock<AddressSpace>,
        calls: &mut [&mut &mut MethodCall],
    ) -> Result<(), StatusCode> {
        for call in calls {
            let done = self.conditions.call(context, call.object_id(), call.method_id(), call.arguments()).await;
            call.set_status(done.err().unwrap_or(StatusCode::Good));
        }
        Ok(())
    }

    fn name(&self) -> &'static str {
        "station"
    }

    fn namespaces(&self) -> Vec<NamespaceMetadata> {
        let subset = |uri: &str, index| NamespaceMetadata {
            namespace_uri: uri.to_owned(),
            namespace_index: index,
            is_namespace_subset: Some(true),
            ..Default::default()
        };
        let own = NamespaceMetadata {
            namespace_uri: NAMESPACE.to_owned(),
            namespace_index: self.namespaces.station,
            is_namespace_subset: Some(false),
            namespace_version: Some(env!("CARGO_PKG_VERSION").to_owned()),
            ..Default::default()
        };
        vec![own, subset(types::DI, self.namespaces.di), subset(types::PA_DIM, self.namespaces.pa_dim)]
    }

    async fn history_read_raw_modified(
        &self,
        _context: &RequestContext,
        details: &ReadRawModifiedDetails,
        nodes: &mut [&mut &mut HistoryNode],
        _timestamps: TimestampsToReturn,
    ) -> Result<(), StatusCode> {
        let deadline = Instant::now() + REQUEST_TIMEOUT;
        for node in nodes {
            if let Err(status) = self.read_history(details, node, deadline).await {
                node.set_status(status);
            }
        }
        Ok(())
    }

    async fn write(
        &self,
        context: &RequestContext,
        _space: &RwLock<AddressSpace>,
        nodes: &mut [&mut WriteNode],
    ) -> Result<(), StatusCode> {
        let user = context.token.0.clone();
        for node in nodes {
            let status = match self.write_one(&user, node.value()).await {
                Ok(()) => StatusCode::Good,
                Err((status, reason)) => {
                    self.status.refused(&format!("a write of {user}: {reason}"));
                    status
                }
            };
            node.set_status(status);
        }
        Ok(())
    }
}

/// A slot for a query of the record. After the deadline there is none, also when one is free.
async fn slot_before(deadline: Instant, slots: &Arc<Semaphore>) -> Result<OwnedSemaphorePermit, StatusCode> {
    if Instant::now() >= deadline {
        return Err(StatusCode::BadTooManyOperations);
    }
    match timeout_at(deadline, Arc::clone(slots).acquire_owned()).await {
        Ok(Ok(slot)) => Ok(slot),
        Ok(Err(_)) | Err(_) => Err(StatusCode::BadTooManyOperations),
    }
}

/// The status of a write that was not done.
fn write_status(error: &WriteError) -> StatusCode {
    let WriteError::Control(error) = error else {
        return match error {
            WriteError::Busy => StatusCode::BadTooManyOperations,
            WriteError::Users(_) | WriteError::UnknownUser(_) | WriteError::Forbidden(_) => {
                StatusCode::BadUserAccessDenied
            }
            _ => StatusCode::BadInternalError,
        };
    };
    match &**error {
        ControlError::Forbidden(_) => StatusCode::BadUserAccessDenied,
        ControlError::Request(_) => StatusCode::BadTypeMismatch,
        ControlError::Audit(_) => StatusCode::BadResourceUnavailable,
        ControlError::Operation(error) => match error {
            OperationError::InvalidValue(_) | OperationError::BeyondRange { .. } => StatusCode::BadOutOfRange,
            OperationError::Unavailable(_) => StatusCode::BadNoCommunication,
            OperationError::Refused(_) => StatusCode::BadDeviceFailure,
            OperationError::OutcomeUnknown(_) => StatusCode::UncertainNoCommunicationLastUsableValue,
            _ => StatusCode::BadInvalidState,
        },
        // Control that another user has, conditions that do not hold, and what the station never writes.
        _ => StatusCode::BadInvalidState,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[tokio::test]
    async fn after_the_deadline_of_a_request_its_further_nodes_wait_for_no_slot() {
        let (slots, deadline) = (Arc::new(Semaphore::new(0)), Instant::now() + Duration::from_millis(1));
        // The first node waits until the deadline, the second one not at all, even though a slot is free then.
        assert_eq!(slot_before(deadline, &slots).await.unwrap_err(), StatusCode::BadTooManyOperations);
        slots.add_permits(1);
        assert_eq!(slot_before(deadline, &slots).await.unwrap_err(), StatusCode::BadTooManyOperations);
        assert!(slot_before(Instant::now() + REQUEST_TIMEOUT, &slots).await.is_ok());
    }
}
