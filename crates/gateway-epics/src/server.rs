//! All sockets of the gateway, and the publisher that gives the connections the newest values.

use crate::ca;
use crate::connection::{self, Shared};
use crate::database::{Database, World, held};
use crate::names::NameError;
use crate::put::{Puts, Writer};
use crate::pva;
use crate::socket::{beacon_address, circuit_listener, search_socket};
use profivac_gateway::thread::{Context, GatewayThread};
use profivac_gateway::{ReadModel, Snapshot, Subscription};
use profivac_recorder::Micros;
use profivac_station::config::gateways::epics::{Interface, Settings};
use profivac_station::services::Services;
use std::io;
use std::net::{Ipv4Addr, SocketAddrV4};
use std::sync::Arc;
use tokio::net::{TcpListener, UdpSocket};
use tokio::sync::watch;
use tokio::task::JoinSet;

/// The port to which beacons of Channel Access go, where the port of the server is the usual one or free.
const CA_BEACON_PORT: u16 = 5065;

/// The reason why the gateway does not serve.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum EpicsError {
    /// The address cannot be used.
    #[error("cannot listen on {address}: {error}; change interfaces or the port in [epics]")]
    Listen {
        /// The address.
        address: SocketAddrV4,
        /// The error of the operating system.
        error: io::Error,
    },
    /// The names cannot be published.
    #[error(transparent)]
    Names(#[from] NameError),
}

/// Starts the gateway.
///
/// # Errors
/// When the system gives no thread.
pub fn start(settings: Settings, model: Arc<ReadModel>, services: Arc<Services>) -> io::Result<GatewayThread> {
    GatewayThread::start("epics", model, services, move |context| serve(settings.clone(), context))
}

async fn serve(settings: Settings, context: Context) -> Result<(), EpicsError> {
    let station = context.services.name().to_owned();
    let mut subscription = context.model.subscribe();
    let snapshot = Arc::clone(&subscription.borrow_and_update());
    let (worlds, world) = watch::channel(Arc::new(first_world(&station, snapshot, &settings)?));
    let new_writer = |write| Arc::new(Writer::new(Arc::clone(&context.services), write, world.clone()));
    let writer = settings.write.clone().map(new_writer);
    let shared = Shared::new(world, Arc::clone(&context.status), context.stop.clone(), writer);
    let mut tasks = JoinSet::new();
    let mut addresses = Vec::new();
    for interface in &settings.interfaces {
        if let Some(port) = settings.ca_port {
            addresses.push(format!("ca {}", channel_access(interface, port, &shared, &mut tasks).await?));
        }
        if let Some(ports) = settings.pva_ports {
            addresses.push(format!("pva {}", pv_access(interface, ports, &shared, &mut tasks).await?));
        }
    }
    context.status.runs(addresses.join(", "));
    let mut stop = context.stop.clone();
    let ended = tokio::select! {
        ended = publish(&station, &settings, &worlds, &mut subscription) => ended,
        () = stop.stopped() => Ok(()),
    };
    tasks.shutdown().await;
    Ok(ended?)
}

fn first_world(station: &str, snapshot: Arc<Snapshot>, settings: &Settings) -> Result<World, NameError> {
    let database = Arc::new(Database::new(station, &snapshot, settings)?);
    Ok(World { database, held: held(&[], &snapshot, false, settings), snapshot })
}

/// Gives every snapshot to the connections, until the read model ends. The connections end with it, so that no client keeps old values.
async fn publish(
    station: &str,
    settings: &Settings,
    worlds: &watch::Sender<Arc<World>>,
    subscription: &mut Subscription,
) -> Result<(), NameError> {
    while subscription.changed().await.is_ok() {
        let snapshot = Arc::clone(&subscription.borrow_and_update());
        let old = worlds.borrow().clone();
        let is_same_list = snapshot.has_points_of(&old.snapshot);
        let database = if is_same_list {
            Arc::clone(&old.database)
        } else {
            Arc::new(Database::new(station, &snapshot, settings)?)
        };
        let held = held(&old.held, &snapshot, is_same_list, settings);
        worlds.send_replace(Arc::new(World { database, snapshot, held }));
    }
    Ok(())
}

/// Serves Channel Access at an interface, and returns the address of its circuits.
async fn channel_access(
    interface: &Interface,
    port: u16,
    shared: &Shared,
    tasks: &mut JoinSet<()>,
) -> Result<SocketAddrV4, EpicsError> {
    let (listener, address) = listen(interface.address, port).await?;
    // Clients search at the port of the file; port 0 means that search and circuits share a free one.
    let search_port = if port == 0 { address.port() } else { port };
    for of_interface in search_addresses(interface) {
        let socket = searched(of_interface, search_port)?;
        tasks.spawn(ca::search::serve(socket, address.port(), shared.clone()));
    }
    let beacons = searched(interface.address, 0)?;
    let beacon_port = if port == 0 || port == 5064 { CA_BEACON_PORT } else { port.saturating_add(1) };
    let to = (beacon_address(interface), beacon_port);
    tasks.spawn(ca::search::beacons(beacons, to, address.port(), shared.clone()));
    let protocol = move |shared: &Shared, host| {
        let puts = Puts::new(shared.writer.clone(), host);
        ca::circuit::Circuit::new(host, address.port(), Arc::clone(&shared.status), shared.slots(), puts)
    };
    tasks.spawn(connection::accept(listener, shared.clone(), protocol));
    Ok(address)
}

/// Serves PV Access at an interface, and returns the address of its circuits.
async fn pv_access(
    interface: &Interface,
    (port, search_port): (u16, u16),
    shared: &Shared,
    tasks: &mut JoinSet<()>,
) -> Result<SocketAddrV4, EpicsError> {
    let (listener, address) = listen(interface.address, port).await?;
    let mut guid = [0; 12];
    // Without random numbers the time distinguishes the starts.
    if getrandom::fill(&mut guid).is_err() {
        guid[..8].copy_from_slice(&Micros::now().0.to_le_bytes());
    }
    for of_interface in search_addresses(interface) {
        let socket = searched(of_interface, search_port)?;
        tasks.spawn(pva::search::serve(socket, guid, address.port(), shared.clone()));
    }
    let beacons = searched(interface.address, 0)?;
    let to = (beacon_address(interface), search_port);
    tasks.spawn(pva::search::beacons(beacons, to, guid, address.port(), shared.clone()));
    let protocol = move |shared: &Shared, host| {
        let puts = Puts::new(shared.writer.clone(), host);
        pva::circuit::Circuit::new(host, (address.port(), guid), Arc::clone(&shared.status), shared.slots(), puts)
    };
    tasks.spawn(connection::accept(listener, shared.clone(), protocol));
    Ok(address)
}

/// The addresses at which searches for an interface arrive: its own, and that of broadcasts.
fn search_addresses(interface: &Interface) -> impl Iterator<Item = Ipv4Addr> {
    std::iter::once(interface.address).chain(interface.broadcast)
}

async fn listen(address: Ipv4Addr, port: u16) -> Result<(TcpListener, SocketAddrV4), EpicsError> {
    let problem = |error| EpicsError::Listen { address: SocketAddrV4::new(address, port), error };
    let listener = circuit_listener(address, port).await.map_err(problem)?;
    let port = listener.local_addr().map_err(problem)?.port();
    Ok((listener, SocketAddrV4::new(address, port)))
}

fn searched(address: Ipv4Addr, port: u16) -> Result<UdpSocket, EpicsError> {
    search_socket(address, port)
        .map_err(|error| EpicsError::Listen { address: SocketAddrV4::new(address, port), error })
}
