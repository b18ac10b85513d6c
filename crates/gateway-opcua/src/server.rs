//! The server: its endpoints, its limits, and the loop that brings new values.

use crate::OpcuaError;
use crate::abandoned::{Abandoned, MAX_OCTETS};
use crate::alarms::{Condition, Conditions};
use crate::certificates::{self, KEY, OWN};
use crate::filters;
use crate::manager::{StationNodes, StationNodesBuilder, StationNodesImpl};
use crate::relay;
use crate::space::Space;
use crate::standard::{Built, Guard};
use crate::users::Logins;
use opcua_crypto::SecurityPolicy;
use opcua_server::address_space::Event;
use opcua_server::diagnostics::DiagnosticsNodeManagerBuilder;
use opcua_server::{Limits, OperationalLimits, ServerBuilder, ServerEndpoint, ServerHandle, SubscriptionLimits};
use opcua_types::{BuildInfo, DataValue, MessageSecurityMode, NodeId, ObjectId, Variant};
use profivac_gateway::thread::Context;
use profivac_gateway::{Commander, Snapshot};
use profivac_recorder::Micros;
use profivac_station::config::gateways::opcua::{Policy, Settings};
use std::net::{Ipv4Addr, SocketAddr};
use std::sync::Arc;
use std::sync::atomic::Ordering;
use std::time::Duration;
use tokio::net::TcpListener;
use tokio::sync::oneshot;
use tokio::task::JoinError;
use tokio::time::{MissedTickBehavior, interval, sleep, timeout};

/// The time in which a connection must begin: HELLO, then the secure channel.
const HELLO_TIMEOUT_S: u32 = 5;

/// The time between two looks for expired subscriptions and due notifications, in milliseconds.
const POLL_MS: u64 = 50;

/// The shortest sampling and publishing interval, in milliseconds: that of the snapshots.
const MIN_INTERVAL_MS: f64 = 100.0;

/// The time between two looks at the rejected certificates.
const PRUNE_PERIOD: Duration = Duration::from_secs(10);

/// The time between two looks at the subscriptions that clients have left behind.
const ABANDONED_PERIOD: Duration = Duration::from_secs(1);

/// The pause before the next server.
const RESTART_PAUSE: Duration = Duration::from_secs(1);

/// The longest time that the library gets to end its connections.
const END_TIMEOUT: Duration = Duration::from_secs(1);

/// The longest queue of events: more alarms than stand at once in a large plant. Values have a queue of four.
const EVENT_QUEUE: usize = 2_000;

/// The intervals without a request of its client after which a subscription ends. A subscription outlives its session, so its values stay
/// in memory for this time when a client disconnects without closing the session: one minute at the shortest interval, ten minutes at a
/// second.
const LIFETIME_COUNT: u32 = 600;

/// The pause before the next look whether the library listens.
const START_PAUSE: Duration = Duration::from_millis(10);

/// The URI of the application, which its certificate holds as well.
fn application_uri(station: &str) -> String {
    let letter = |it: char| if it.is_ascii_alphanumeric() || it == '-' { it } else { '-' };
    format!("urn:profivac:server:{}", station.chars().map(letter).collect::<String>())
}

/// What one client may take. The worst case is some 600 MiB: 64 sessions of 4 subscriptions of 2,000 values, 4 queued for each; and two
/// queues of events for each session, which 2,000 changes of alarms fill.
#[must_use]
pub fn limits() -> Limits {
    Limits {
        max_sessions: 64,
        max_message_size: 4 << 20,
        max_chunk_count: 64,
        max_array_length: 2_000,
        // A reason has at most 500 characters. Beyond that these two limit what a session keeps of its client's description.
        max_string_length: 1_024,
        max_byte_string_length: 65_535,
        max_browse_continuation_points: 20,
        // The library refuses one too many, and OPC 10000-4, 7.9 demands that the oldest is freed. So they are not limited, but count as
        // memory that is left.
        max_history_continuation_points: 0,
        max_query_continuation_points: 1,
        subscriptions: SubscriptionLimits {
            max_subscriptions_per_session: 4,
            max_monitored_items_per_sub: 2_000,
            max_monitored_item_queue_size: EVENT_QUEUE,
            min_sampling_interval_ms: MIN_INTERVAL_MS,
            min_publishing_interval_ms: MIN_INTERVAL_MS,
            max_lifetime_count: LIFETIME_COUNT,
            // Part 4, 5.14.2: at most a third of the lifetime.
            max_keep_alive_count: LIFETIME_COUNT / 3,
            ..SubscriptionLimits::default()
        },
        operational: OperationalLimits {
            max_nodes_per_read: 2_000,
            max_nodes_per_write: 100,
            max_nodes_per_history_read_data: 10,
            max_nodes_per_node_management: 1,
            max_references_per_references_management: 1,
            ..OperationalLimits::default()
        },
        ..Limits::default()
    }
}

const fn security_policy(policy: Policy) -> SecurityPolicy {
    match policy {
        Policy::Basic256Sha256 => SecurityPolicy::Basic256Sha256,
        Policy::Aes128Sha256RsaOaep => SecurityPolicy::Aes128Sha256RsaOaep,
        Policy::Aes256Sha256RsaPss => SecurityPolicy::Aes256Sha256RsaPss,
    }
}

/// The builder of the server, and where its manager of the station will be.
fn builder(
    settings: &Settings,
    context: &Context,
    abandoned: &Arc<Abandoned>,
) -> (ServerBuilder, Built<StationNodesImpl>) {
    let station = context.services.name();
    let uri = application_uri(station);
    let url = format!("opc.tcp://{}:{}/", settings.host, settings.listen.port());
    let build = BuildInfo {
        product_uri: "urn:profivac".into(),
        manufacturer_name: "profivac".into(),
        product_name: "profivac".into(),
        software_version: env!("CARGO_PKG_VERSION").into(),
        ..BuildInfo::default()
    };
    let commander = || Arc::new(Commander::new(Arc::clone(&context.services), settings.users.clone()));
    let commander = settings.write.then(commander);
    let conditions = Arc::new(Conditions::new(Arc::clone(&context.status), commander.clone()));
    let nodes = StationNodesBuilder {
        services: Arc::clone(&context.services),
        status: Arc::clone(&context.status),
        commander,
        conditions: Arc::clone(&conditions),
        abandoned: Arc::clone(abandoned),
    };
    let built = Built::default();
    let of_station = Guard::of(nodes, Arc::clone(&built), None, Arc::clone(abandoned));
    let mut builder = ServerBuilder::new()
        .application_name(format!("profivac {station}"))
        .application_uri(uri)
        .product_uri("urn:profivac")
        .build_info(build)
        .create_sample_keypair(false)
        .certificate_path(OWN)
        .private_key_path(KEY)
        .pki_dir(&settings.certificates)
        .trust_client_certs(false)
        .host(settings.host.clone())
        .port(settings.listen.port())
        .hello_timeout(HELLO_TIMEOUT_S)
        .subscription_poll_interval_ms(POLL_MS)
        .limits(limits())
        .discovery_urls(vec![url])
        .with_authenticator(Arc::new(Logins::new(settings.users.clone(), Arc::clone(&context.status))))
        .without_node_managers()
        .with_node_manager(Guard::of_standard(conditions, Arc::clone(abandoned)))
        .with_node_manager(DiagnosticsNodeManagerBuilder)
        .with_node_manager(of_station);
    if settings.is_anonymous {
        builder = builder.add_endpoint("open", ServerEndpoint::new_none("/", &[]));
    }
    for policy in &settings.policies {
        let policy = security_policy(*policy);
        let endpoint = ServerEndpoint::new("/", policy, MessageSecurityMode::SignAndEncrypt, &[]);
        builder = builder.add_endpoint(policy.to_str(), endpoint);
    }
    (builder, built)
}

/// Why a server that was told to end has ended.
enum Ended {
    /// The gateway is to stop.
    Stopped,
    /// Subscriptions have left this many octets.
    Abandoned(u64),
}

/// Serves until the gateway is told to stop. A server in which subscriptions have left too much is followed by another.
pub async fn serve(settings: Settings, context: Context) -> Result<(), OpcuaError> {
    while let Ended::Abandoned(octets) = serve_once(&settings, &context).await? {
        context.status.fails(&format!(
            "the server starts again to free what clients have left behind: some {} MiB of subscriptions, at most {} may be",
            octets >> 20,
            MAX_OCTETS >> 20
        ));
        sleep(RESTART_PAUSE).await;
    }
    Ok(())
}

async fn serve_once(settings: &Settings, context: &Context) -> Result<Ended, OpcuaError> {
    let address = settings.listen;
    let listener = TcpListener::bind(address).await.map_err(|error| OpcuaError::Listen { address, error })?;
    let address = listener.local_addr().unwrap_or(address);
    prepare_certificates(settings, context).await?;
    let abandoned = Arc::new(Abandoned::default());
    let (builder, built) = builder(settings, context, &abandoned);
    let (server, handle) = builder.build().map_err(OpcuaError::Build)?;
    let nodes = built.get().ok_or(OpcuaError::Task("the manager of the station's nodes"))?;
    *handle.info().type_loaders.write() = filters::loaders();
    let internal = |error| OpcuaError::Listen { address: (Ipv4Addr::LOCALHOST, 0).into(), error };
    let library = TcpListener::bind((Ipv4Addr::LOCALHOST, 0)).await.map_err(internal)?;
    let library_address = library.local_addr().map_err(internal)?;
    let mut serving = tokio::spawn(server.run_with(library));
    let mut stop = context.stop.clone();
    let (filled, is_filled) = oneshot::channel();
    let ended = tokio::select! {
        ended = &mut serving => return result(ended),
        octets = watch_abandoned(&handle, &abandoned) => Ended::Abandoned(octets),
        () = relay_clients(listener, library_address, &handle, is_filled, context) => Ended::Stopped,
        () = bring_values(&handle, nodes, context, address, filled) => Ended::Stopped,
        () = prune_certificates(settings) => Ended::Stopped,
        () = stop.stopped() => Ended::Stopped,
    };
    handle.cancel();
    if timeout(END_TIMEOUT, &mut serving).await.is_err() {
        serving.abort();
    }
    Ok(ended)
}

/// How the server of the library has ended by itself.
fn result(ended: Result<Result<(), String>, JoinError>) -> Result<Ended, OpcuaError> {
    ended.map_err(|_| OpcuaError::Task("the server"))?.map_err(OpcuaError::Server).map(|()| Ended::Stopped)
}

/// Returns the octets that subscriptions have left as soon as they are as many as may be.
async fn watch_abandoned(handle: &ServerHandle, abandoned: &Abandoned) -> u64 {
    let max_values = limits().subscriptions.max_monitored_items_per_sub;
    let mut due = interval(ABANDONED_PERIOD);
    due.set_missed_tick_behavior(MissedTickBehavior::Delay);
    let mut looks = 0;
    loop {
        due.tick().await;
        // The library tells a number only when it gives it away; so each look takes one.
        looks += 1;
        let numbered = u64::from(handle.info().subscription_id_handle.next()).saturating_sub(looks);
        let octets = abandoned.octets(handle.subscriptions(), numbered, max_values);
        if octets >= MAX_OCTETS {
            return octets;
        }
    }
}

async fn prepare_certificates(settings: &Settings, context: &Context) -> Result<(), OpcuaError> {
    if settings.policies.is_empty() {
        return Ok(());
    }
    let (folder, host) = (settings.certificates.clone(), settings.host.clone());
    let uri = application_uri(context.services.name());
    let prepared = tokio::task::spawn_blocking(move || certificates::prepare(&folder, &uri, &host)).await;
    prepared.unwrap_or(Err(OpcuaError::Task("making of the certificate")))
}

/// The URLs of the endpoints have the port of the relay. The library sets the port of its own listener once, when it starts.
async fn set_port(handle: &ServerHandle, port: u16) {
    let present = &handle.info().port;
    while present.load(Ordering::Relaxed) == 0 {
        sleep(START_PAUSE).await;
    }
    present.store(port, Ordering::Relaxed);
}

/// Serves clients as soon as the library listens and the nodes are there: items of nodes that do not exist are refused, and a client that
/// connects again would not ask for them a second time.
async fn relay_clients(
    listener: TcpListener,
    library: SocketAddr,
    handle: &ServerHandle,
    is_filled: oneshot::Receiver<()>,
    context: &Context,
) {
    if let Ok(address) = listener.local_addr() {
        set_port(handle, address.port()).await;
    }
    // Without the sender the other task has ended, and with it the server.
    is_filled.await.ok();
    relay::run(listener, library, Arc::clone(&context.status), context.stop.clone()).await;
}

async fn prune_certificates(settings: &Settings) {
    let mut due = interval(PRUNE_PERIOD);
    due.set_missed_tick_behavior(MissedTickBehavior::Delay);
    loop {
        due.tick().await;
        certificates::prune(&settings.certificates);
    }
}

/// Brings every new snapshot into the address space. A subscription that is behind gets the newest values.
async fn bring_values(
    handle: &ServerHandle,
    nodes: &StationNodes,
    context: &Context,
    address: SocketAddr,
    filled: oneshot::Sender<()>,
) {
    let mut filled = Some(filled);
    let namespaces = nodes.inner().namespaces();
    let mut space = Space::new(namespaces, nodes.inner().may_write());
    let mut snapshots = context.model.subscribe();
    let mut before: Option<Arc<Snapshot>> = None;
    let mut second = 0;
    while snapshots.changed().await.is_ok() {
        let snapshot = Arc::clone(&snapshots.borrow_and_update());
        if before.as_ref().is_none_or(|before| !before.has_points_of(&snapshot)) {
            space.update(&snapshot, &mut nodes.address_space().write());
            nodes.inner().set_histories(space.histories());
            nodes.inner().set_parameters(space.parameters());
        }
        let values: Vec<_> = space.values(&snapshot, before.as_deref()).collect();
        context.status.sent(values.len() as u64);
        let values = values.into_iter().map(|(id, value)| (id, None, value));
        if let Err(status) = nodes.set_values(handle.subscriptions(), values) {
            context.status.error(&format!("a value could not be shown: {status}"));
        }
        let conditions = nodes.inner().conditions().update(namespaces.station, &snapshot, before.as_deref());
        show_conditions(handle, nodes, &conditions, before.is_some());
        let now = Micros::now();
        if now.0 / Micros::SECOND != second {
            second = now.0 / Micros::SECOND;
            show(handle, nodes, nodes.inner().conditions().countdowns(now));
        }
        if let Some(filled) = filled.take() {
            context.status.runs(address.to_string());
            filled.send(()).ok();
        }
        before = Some(snapshot);
    }
}

/// Shows the conditions that have changed, and tells subscribers of events of them, except at the start, when they ask for a refresh.
fn show_conditions(handle: &ServerHandle, nodes: &StationNodes, changed: &[Arc<Condition>], is_event: bool) {
    show(handle, nodes, changed.iter().flat_map(|condition| condition.values()).collect());
    if is_event {
        let server = NodeId::from(ObjectId::Server);
        let events = changed.iter().map(|condition| (&**condition as &dyn Event, &server));
        handle.subscriptions().notify_events(events);
    }
}

/// Sets nodes of conditions.
fn show(handle: &ServerHandle, nodes: &StationNodes, values: Vec<(NodeId, Variant)>) {
    let values: Vec<_> = values.into_iter().map(|(id, value)| (id, DataValue::new_now(value))).collect();
    // An alarm whose node is gone is shown with the next list of points.
    nodes.set_values(handle.subscriptions(), values.iter().map(|(id, value)| (id, None, value.clone()))).ok();
}
