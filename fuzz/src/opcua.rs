//! Messages of OPC UA, without sockets: chunks and requests as the library decodes them, then what the gateway does with a request for
//! history, a write, a call of a method, a filter of events or a read.
//!
//! Nothing panics or hangs. An answer with history has at most as many samples as the client asked for, and the next one goes on behind it.

use crate::script::Script;
use opcua_core::comms::chunker::Chunker;
use opcua_core::comms::message_chunk::{MessageChunk, MessageChunkHeader, MessageIsFinalType};
use opcua_core::comms::secure_channel::{Role, SecureChannel};
use opcua_core::{Message, RequestMessage};
use opcua_crypto::CertificateStore;
use opcua_server::address_space::{
    AddressSpace, CoreNamespace, DefaultTypeTree, Event, ParsedEventFilter, TypeTree, Variable,
};
use opcua_types::{
    ContextOwned, DataEncoding, DataValue, DecodingOptions, EventFilter, ExtensionObject, NamespaceMap, ObjectId,
    ReadRawModifiedDetails, SimpleBinaryDecodable, TimestampsToReturn, Variant,
};
use parking_lot::RwLock;
use profivac_gateway::command::given;
use profivac_gateway::model::Modeller;
use profivac_gateway::{Commander, Inputs, Signal};
use profivac_gateway_opcua::alarms::{self, ANONYMOUS, Condition, Conditions};
use profivac_gateway_opcua::plan::History;
use profivac_gateway_opcua::server::limits;
use profivac_gateway_opcua::{filters, history, value};
use profivac_recorder::{Deadband, Micros, Quality, Reader, Recorder, Sample, Settings};
use profivac_station::gateway_status::GatewayStatuses;
use profivac_station::services::Services;
use std::cell::LazyCell;
use std::path::Path;
use std::sync::Arc;
use std::time::Duration;
use tokio::runtime::{Builder, Runtime};

const PLANT: &str = r#"
[[segment]]
name = "hall"
port = "/dev/ttyUSB0"

[[segment.gauge]]
name = "chamber"
address = 5
device = "bcg450"

[[alarm]]
name = "Chamber high"
gauge = "chamber"
above = "1e-3 mbar"
priority = "high"
"#;

/// The requests whose contents reach the gateway, and some of the library alone.
const REQUESTS: [ObjectId; 12] = [
    ObjectId::HistoryReadRequest_Encoding_DefaultBinary,
    ObjectId::WriteRequest_Encoding_DefaultBinary,
    ObjectId::CallRequest_Encoding_DefaultBinary,
    ObjectId::CreateMonitoredItemsRequest_Encoding_DefaultBinary,
    ObjectId::ReadRequest_Encoding_DefaultBinary,
    ObjectId::ModifyMonitoredItemsRequest_Encoding_DefaultBinary,
    ObjectId::BrowseRequest_Encoding_DefaultBinary,
    ObjectId::TranslateBrowsePathsToNodeIdsRequest_Encoding_DefaultBinary,
    ObjectId::CreateSessionRequest_Encoding_DefaultBinary,
    ObjectId::ActivateSessionRequest_Encoding_DefaultBinary,
    ObjectId::OpenSecureChannelRequest_Encoding_DefaultBinary,
    ObjectId::QueryFirstRequest_Encoding_DefaultBinary,
];

/// What the server knows, without its sockets.
struct Server {
    _folder: tempfile::TempDir,
    _recorder: Recorder,
    runtime: Runtime,
    context: Arc<RwLock<ContextOwned>>,
    channel: SecureChannel,
    reader: Reader,
    tree: DefaultTypeTree,
    conditions: Conditions,
    events: Vec<Arc<Condition>>,
    variable: Variable,
}

/// The limits with which the server decodes.
fn options() -> DecodingOptions {
    let limits = limits();
    DecodingOptions {
        max_message_size: limits.max_message_size,
        max_chunk_count: limits.max_chunk_count,
        max_string_length: limits.max_string_length,
        max_byte_string_length: limits.max_byte_string_length,
        max_array_length: limits.max_array_length,
        ..DecodingOptions::default()
    }
}

impl Server {
    fn new() -> Self {
        let folder = tempfile::tempdir().expect("a folder");
        let database = folder.path().join("plant.db");
        let deadband = Deadband { decades: 0.0, max_interval: Duration::ZERO };
        let recorder =
            Recorder::start(&database, Settings { deadband, ..Settings::default() }).expect("a new database");
        let gauge: Arc<str> = Arc::from("chamber");
        let begin = Micros::now().0 - 100 * Micros::SECOND;
        for second in 0..40 {
            recorder.push(&gauge, Sample::new(Micros(begin + second * Micros::SECOND), Some(1.0), Quality::Valid));
        }
        assert!(recorder.flush());
        let reader = Reader::open(&database).expect("the database");
        // Logins need a file of users, and there is none: no change of an alarm is made.
        let other = Recorder::start(&folder.path().join("other.db"), Settings::default()).expect("a new database");
        let services = Arc::new(Services::new("hall".to_owned(), folder.path().join("other.db"), other));
        let commander = Arc::new(Commander::new(services, folder.path().join("absent.toml")));
        let conditions = Conditions::new(GatewayStatuses::default().add("opcua"), Some(commander));
        let config = profivac_config::parse(PLANT, Path::new("plant.toml")).expect("a right file");
        let snapshot = Modeller::default().next(Inputs::planned(&config), Micros(1));
        let events = conditions.update(2, &snapshot, None);
        let (mut space, mut tree) = (AddressSpace::new(), DefaultTypeTree::new());
        space.import_node_set(&CoreNamespace, tree.namespaces_mut());
        space.load_into_type_tree(&mut tree);
        alarms::register(&mut tree);
        let context = ContextOwned::new(NamespaceMap::default(), filters::loaders(), options());
        let context = Arc::new(RwLock::new(context));
        let store = Arc::new(RwLock::new(CertificateStore::new(folder.path())));
        let channel = SecureChannel::new(store, Role::Server, Arc::clone(&context));
        let mut variable = Variable::default();
        variable.set_data_value(DataValue::new_now(vec![1.0_f32, 2.0, 3.0]));
        let runtime = Builder::new_current_thread().enable_time().build().expect("a runtime");
        Self {
            _folder: folder,
            _recorder: recorder,
            runtime,
            context,
            channel,
            reader,
            tree,
            conditions,
            events,
            variable,
        }
    }

    /// The requests in a stream of chunks.
    fn chunks(&self, octets: &[u8]) {
        let (options, mut rest, mut chunks) = (options(), octets, Vec::new());
        while !rest.is_empty() {
            let Ok(header) = MessageChunkHeader::decode(&mut &rest[..], &options) else { return };
            // The relay has disconnected the client.
            if !(8..=rest.len()).contains(&(header.message_size as usize)) {
                return;
            }
            let Ok(chunk) = MessageChunk::decode(&mut rest, &options) else { return };
            chunks.push(chunk);
            if header.is_final == MessageIsFinalType::Intermediate && chunks.len() < options.max_chunk_count {
                continue;
            }
            if Chunker::validate_chunks(&self.channel, &chunks).is_err() {
                return;
            }
            match Chunker::decode::<RequestMessage>(&chunks, &self.channel, None) {
                Ok(request) => self.serve(request),
                Err(_) => return,
            }
            chunks.clear();
        }
    }

    /// A request without chunks around it.
    fn request(&self, id: ObjectId, mut octets: &[u8]) {
        let context = self.context.read();
        let request = RequestMessage::decode_by_object_id(&mut octets, id, &context.context());
        if let Ok(request) = request {
            self.serve(request);
        }
    }

    fn serve(&self, request: RequestMessage) {
        match request {
            RequestMessage::HistoryRead(request) => {
                if let Some(details) = request.history_read_details.inner_as::<ReadRawModifiedDetails>() {
                    self.history(details);
                }
            }
            RequestMessage::Write(request) => {
                for write in request.nodes_to_write.iter().flatten() {
                    write.value.value.as_ref().inspect(|variant| written(variant));
                }
            }
            RequestMessage::Call(request) => {
                for call in request.methods_to_call.iter().flatten() {
                    let arguments = call.input_arguments.as_deref().unwrap_or_default();
                    let nodes = [self.events.first().map_or(&call.object_id, |event| event.node()), &call.object_id];
                    for (object, user) in nodes.into_iter().zip(["erna", ANONYMOUS]) {
                        let called = self.conditions.call_as(user, object, &call.method_id, arguments);
                        assert!(self.runtime.block_on(called).is_err(), "no user may change an alarm");
                    }
                }
            }
            RequestMessage::CreateMonitoredItems(request) => {
                let items = request.items_to_create.iter().flatten();
                items.for_each(|item| self.filter(&item.requested_parameters.filter));
            }
            RequestMessage::ModifyMonitoredItems(request) => {
                let items = request.items_to_modify.iter().flatten();
                items.for_each(|item| self.filter(&item.requested_parameters.filter));
            }
            RequestMessage::Read(request) => {
                for read in request.nodes_to_read.iter().flatten() {
                    let (times, range) = (TimestampsToReturn::Both, &read.index_range);
                    let _ = self.variable.value(times, range, &DataEncoding::Binary, request.max_age);
                }
            }
            _ => {}
        }
    }

    fn history(&self, details: &ReadRawModifiedDetails) {
        let Ok((mut query, limit)) = history::query(details) else { return };
        let chamber = History::Series("chamber".to_owned());
        // Three pages: each has the samples behind those of the last one.
        for is_first in [true, false, false] {
            let answer = history::read(&self.reader, &chamber, query, limit).expect("the record");
            assert!(answer.rest.is_none() || !answer.values.is_empty(), "an answer without samples goes on");
            let history::Answer { values, rest } = history::with_bounds(answer, query, is_first, limit);
            assert!(values.len() <= limit as usize, "{} of {limit} values", values.len());
            let Some(rest) = rest else { return };
            assert_ne!(rest, query, "the same samples again");
            query = rest;
        }
    }

    /// A filter of events, and each condition as an event.
    fn filter(&self, filter: &ExtensionObject) {
        let Some(filter) = filter.inner_as::<EventFilter>() else { return };
        let tree: &dyn TypeTree = &self.tree;
        let (_, Ok(filter)) = ParsedEventFilter::new(filter.clone(), tree) else { return };
        for event in &self.events {
            let event: &dyn Event = &**event;
            let _ = filter.evaluate(event, 1, tree);
        }
    }
}

/// What the gateway makes of a value that a client writes.
fn written(variant: &Variant) {
    if let Some(value) = value::given(variant) {
        let _ = given(Signal::ParameterPressure, &value);
        let _ = given(Signal::State, &value);
    }
}

thread_local! {
    static SERVER: LazyCell<Server> = LazyCell::new(Server::new);
}

/// Runs the target: the first octet chooses a request, or a stream of chunks.
pub fn run(octets: &[u8]) {
    let mut script = Script::new(octets);
    let kind = usize::from(script.choice()) % (REQUESTS.len() + 1);
    SERVER.with(|server| match REQUESTS.get(kind) {
        Some(id) => server.request(*id, script.rest()),
        None => server.chunks(script.rest()),
    });
}
