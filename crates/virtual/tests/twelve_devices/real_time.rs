//! The line in real time: a master at one end of a port, and virtual devices in a thread at the other.

use crate::twelve_devices::rig::{BAUD, Line, MASTER};
use profivac_client::pressure::Pressure;
use profivac_dp::link::active::BusParameters;
use profivac_host::clock::tbit_of;
use profivac_host::port::{Delivery, Port, Pty, TcpServer};
use profivac_host::segment::Segment;
use profivac_host::session::{BusMaster, BusSession, bus_parameters};
use profivac_vacuum::Gas;
use profivac_virtual::device::{GasConditions, VirtualDevice};
use profivac_virtual::device_spec::DeviceSpec;
use profivac_virtual::nonvolatile::NonvolatileMemory;
use profivac_virtual::open;
use std::io::{Read, Write};
use std::os::unix::net::UnixStream;
use std::sync::mpsc::{Receiver, Sender, TryRecvError, channel};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};
use tempfile::TempDir;

/// The longest wait for any event.
pub const TIMEOUT: Duration = Duration::from_secs(30);

/// The longest interval between two runs of the line.
const SLICE: Duration = Duration::from_millis(100);

type Order = Box<dyn FnOnce(&mut [VirtualDevice]) + Send>;

/// Devices on a port, in a thread that ends when this is dropped.
pub struct Bench {
    orders: Option<Sender<Order>>,
    bell: UnixStream,
    thread: Option<JoinHandle<()>>,
    /// The name of the port for the other end.
    pub name: String,
    /// The path of a pty.
    _folder: Option<TempDir>,
}

impl Bench {
    pub fn on_a_pty(devices: &[String]) -> Self {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("line");
        let pty = Pty::create(&path).unwrap();
        Self::serve(Box::new(pty), path.to_str().unwrap().to_owned(), Some(folder), devices)
    }

    pub fn on_tcp(devices: &[String]) -> Self {
        let server = TcpServer::listen("127.0.0.1:0").unwrap();
        let name = format!("tcp://{}", server.name());
        Self::serve(Box::new(server), name, None, devices)
    }

    fn serve(port: Box<dyn Port>, name: String, folder: Option<TempDir>, devices: &[String]) -> Self {
        let devices = devices.iter().map(|device| powered(device)).collect();
        let (orders, heard) = channel();
        let (bell, rung) = UnixStream::pair().unwrap();
        rung.set_nonblocking(true).unwrap();
        let thread = std::thread::spawn(move || live(Segment::new(port, BAUD, false, devices), &heard, rung));
        Self { orders: Some(orders), bell, thread: Some(thread), name, _folder: folder }
    }

    /// Runs a closure on the devices and waits for it.
    pub fn order<T: Send + 'static>(&mut self, order: impl FnOnce(&mut [VirtualDevice]) -> T + Send + 'static) -> T {
        let (done, waits) = channel();
        let order = move |devices: &mut [VirtualDevice]| done.send(order(devices)).unwrap();
        self.orders.as_ref().unwrap().send(Box::new(order)).unwrap();
        self.bell.write_all(&[0]).unwrap();
        waits.recv_timeout(TIMEOUT).unwrap()
    }

    /// A master at the other end.
    pub fn session(&self, bus: BusParameters) -> BusSession {
        BusSession::new(open::port(&self.name, BAUD).unwrap(), BAUD, bus, TIMEOUT).unwrap()
    }
}

impl Drop for Bench {
    fn drop(&mut self) {
        self.orders = None;
        self.bell.write_all(&[0]).ok();
        let ended = self.thread.take().map(JoinHandle::join);
        assert!(std::thread::panicking() || ended.is_some_and(|ended| ended.is_ok()), "the devices ended early");
    }
}

/// A device in a good vacuum, where everything can be switched on.
fn powered(device: &str) -> VirtualDevice {
    let spec: DeviceSpec = device.parse().unwrap();
    let unit = spec.build(NonvolatileMemory::volatile(), BAUD).unwrap();
    VirtualDevice::new(unit, spec.address, BAUD, conditions(1e-6))
}

/// Nitrogen at this pressure in mbar.
pub fn conditions(mbar: f64) -> GasConditions {
    let pressure = |text: &str| text.parse::<Pressure>().unwrap();
    GasConditions { pressure: pressure(&format!("{mbar} mbar")), atmosphere: pressure("1000 mbar"), gas: Gas::N2 }
}

fn live(mut segment: Segment<Vec<VirtualDevice>>, orders: &Receiver<Order>, mut bell: UnixStream) {
    loop {
        segment.serve(&[profivac_host::readiness::Readiness::of(&bell)], Duration::from_secs(1)).unwrap();
        let _silenced = bell.read(&mut [0; 16]);
        loop {
            match orders.try_recv() {
                Ok(order) => order(segment.stations_mut()),
                Err(TryRecvError::Empty) => break,
                Err(TryRecvError::Disconnected) => return,
            }
        }
    }
}

/// The longest pause of a thread on a busy machine. With shorter slot times the result would depend on the machine: a late
/// answer is no answer.
const SLOT: Duration = Duration::from_millis(400);

/// The bus parameters of a master in a small ring, without a GAP behind the last station.
pub fn bus_of(address: u8, hsa: u8) -> BusParameters {
    let slot_tbit = u32::try_from(tbit_of(BAUD, SLOT)).unwrap();
    BusParameters { hsa, slot_tbit, retry_limit: 3, ..bus_parameters(address, BAUD, Delivery::Unpaced) }
}

/// A master and its devices in real time.
pub struct InRealTime {
    pub session: BusSession,
    pub bench: Bench,
    begun: Instant,
}

impl InRealTime {
    pub fn new(bench: Bench) -> Self {
        Self { session: bench.session(bus_of(MASTER, MASTER)), bench, begun: Instant::now() }
    }
}

impl Line for InRealTime {
    fn master(&mut self) -> &mut BusMaster {
        self.session.master()
    }

    fn step(&mut self) {
        self.session.serve(&[], SLICE).unwrap();
        while self.session.master().next_event().is_some() {}
    }

    fn elapsed(&self) -> Duration {
        self.begun.elapsed()
    }

    fn settle(&mut self) {
        self.bench.order(|devices| {
            devices.iter_mut().for_each(|device| device.settle_in(*device.environment()));
        });
    }
}
