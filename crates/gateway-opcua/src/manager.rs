//! The station's part of the server: its namespace, reading of history, and the refusal of writes.

use crate::history::{self, Answer, Query};
use crate::plan::NAMESPACE;
use async_trait::async_trait;
use opcua_server::ContinuationPoint;
use opcua_server::address_space::AddressSpace;
use opcua_server::diagnostics::NamespaceMetadata;
use opcua_server::node_manager::memory::{
    InMemoryNodeManager, InMemoryNodeManagerBuilder, InMemoryNodeManagerImpl, InMemoryNodeManagerImplBuilder,
};
use opcua_server::node_manager::{HistoryNode, NodeManagerBuilder, RequestContext, ServerContext, WriteNode};
use opcua_types::{HistoryData, NodeId, ReadRawModifiedDetails, StatusCode, TimestampsToReturn};
use parking_lot::RwLock;
use profivac_station::gateway_status::GatewayStatus;
use profivac_station::services::Services;
use std::collections::HashMap;
use std::sync::{Arc, Mutex, PoisonError};
use std::time::Duration;
use tokio::sync::Semaphore;
use tokio::time::timeout;

/// Queries of the record that run at the same time, and the longest wait for one to begin.
const MAX_QUERIES: usize = 2;
const QUERY_TIMEOUT: Duration = Duration::from_secs(10);

/// The node manager of the station.
pub type StationNodes = InMemoryNodeManager<StationNodesImpl>;

/// What the node manager needs of the station.
pub struct StationNodesBuilder {
    /// The station.
    pub services: Arc<Services>,
    /// Where refused writes are counted.
    pub status: Arc<GatewayStatus>,
}

impl StationNodesBuilder {
    /// The builder for the server.
    #[must_use]
    pub fn into_builder(self) -> impl NodeManagerBuilder + 'static {
        InMemoryNodeManagerBuilder::new(self)
    }
}

impl InMemoryNodeManagerImplBuilder for StationNodesBuilder {
    type Impl = StationNodesImpl;

    fn build(self, context: ServerContext, space: &mut AddressSpace) -> StationNodesImpl {
        let namespace = context.type_tree.write().namespaces_mut().add_namespace(NAMESPACE);
        space.add_namespace(NAMESPACE, namespace);
        StationNodesImpl {
            namespace,
            services: self.services,
            status: self.status,
            histories: Mutex::default(),
            slots: Arc::new(Semaphore::new(MAX_QUERIES)),
        }
    }
}

/// The station's part of the server.
pub struct StationNodesImpl {
    namespace: u16,
    services: Arc<Services>,
    status: Arc<GatewayStatus>,
    /// The series of the record that is the history of a node.
    histories: Mutex<HashMap<NodeId, String>>,
    slots: Arc<Semaphore>,
}

impl StationNodesImpl {
    /// The index of the station's namespace.
    #[must_use]
    pub const fn namespace(&self) -> u16 {
        self.namespace
    }

    /// Sets which nodes have a history.
    pub fn set_histories(&self, histories: HashMap<NodeId, String>) {
        *self.histories.lock().unwrap_or_else(PoisonError::into_inner) = histories;
    }

    fn series(&self, node: &NodeId) -> Option<String> {
        self.histories.lock().unwrap_or_else(PoisonError::into_inner).get(node).cloned()
    }

    /// Reads the record on a blocking thread, as soon as a slot is free.
    async fn read_record(&self, series: String, query: Query, limit: u32) -> Result<Answer, StatusCode> {
        let slot = timeout(QUERY_TIMEOUT, Arc::clone(&self.slots).acquire_owned()).await;
        let Ok(Ok(slot)) = slot else { return Err(StatusCode::BadTooManyOperations) };
        let services = Arc::clone(&self.services);
        let task = tokio::task::spawn_blocking(move || {
            let _slot = slot;
            let reader = services.recorder().open_reader()?;
            history::read(&reader, &series, query, limit)
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

    async fn read_history(&self, details: &ReadRawModifiedDetails, node: &mut HistoryNode) -> Result<(), StatusCode> {
        let series = self.series(node.node_id()).ok_or(StatusCode::BadHistoryOperationUnsupported)?;
        let (asked, limit) = history::query(details)?;
        let query = match node.continuation_point() {
            None => asked,
            Some(point) => *point.get::<Query>().ok_or(StatusCode::BadContinuationPointInvalid)?,
        };
        let is_first = node.continuation_point().is_none();
        let Answer { values, rest } = self.read_record(series, query, limit).await?;
        let values = match details.return_bounds {
            true => history::with_bounds(values, query, is_first, rest.is_none()),
            false => values,
        };
        node.set_status(if values.is_empty() { StatusCode::GoodNoData } else { StatusCode::Good });
        node.set_result(HistoryData { data_values: Some(values) });
        node.set_next_continuation_point(rest.map(|rest| ContinuationPoint::new(Box::new(rest))));
        Ok(())
    }
}

#[async_trait]
impl InMemoryNodeManagerImpl for StationNodesImpl {
    async fn init(&self, _space: &mut AddressSpace, _context: ServerContext) {}

    fn name(&self) -> &'static str {
        "station"
    }

    fn namespaces(&self) -> Vec<NamespaceMetadata> {
        vec![NamespaceMetadata {
            namespace_uri: NAMESPACE.to_owned(),
            namespace_index: self.namespace,
            is_namespace_subset: Some(false),
            namespace_version: Some(env!("CARGO_PKG_VERSION").to_owned()),
            ..Default::default()
        }]
    }

    async fn history_read_raw_modified(
        &self,
        _context: &RequestContext,
        details: &ReadRawModifiedDetails,
        nodes: &mut [&mut &mut HistoryNode],
        _timestamps: TimestampsToReturn,
    ) -> Result<(), StatusCode> {
        for node in nodes {
            if let Err(status) = self.read_history(details, node).await {
                node.set_status(status);
            }
        }
        Ok(())
    }

    async fn write(
        &self,
        _context: &RequestContext,
        _space: &RwLock<AddressSpace>,
        nodes: &mut [&mut WriteNode],
    ) -> Result<(), StatusCode> {
        for node in nodes {
            self.status.refused("a write: the gateway is read-only");
            node.set_status(StatusCode::BadNotWritable);
        }
        Ok(())
    }
}
