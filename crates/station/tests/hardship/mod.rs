//! A segment in memory to which things happen: gauges lose power, the line is cut, somebody babbles.

#![allow(clippy::unwrap_used, clippy::panic, clippy::indexing_slicing, reason = "a test")]
#![allow(dead_code, reason = "each test uses its part")]

use profivac_dp::link::{Baud, BitTime, Listening, Station, Transmit};
use profivac_host::port::TcpServer;
use profivac_host::segment::Segment;
use profivac_station::config::Config;
use profivac_vacuum::Gas;
use profivac_virtual::device::{GasConditions, VirtualDevice};
use profivac_virtual::device_spec::DeviceSpec;
use profivac_virtual::nonvolatile::NonvolatileMemory;
use profivac_wire::Telegram;
use std::io::Write;
use std::net::TcpStream;
use std::path::Path;
use std::sync::mpsc::{Receiver, Sender, TryRecvError, channel};
use std::thread::JoinHandle;
use std::time::Duration;

pub const BAUD: Baud = Baud::B187500;

/// What happens.
#[derive(Clone, Copy, Debug)]
pub enum Blow {
    /// The gauge at this place loses power, or has it again.
    Power(u8, bool),
    /// The gauge at this place is exchanged for one of another kind.
    Swap(u8, &'static str),
    /// The gauge at this place answers no class 2 master, or does again.
    Deaf(u8, bool),
    /// Nobody serves the line any more.
    Cut,
    /// The line is served again.
    Mend,
}

/// Gauges behind a TCP port.
pub struct Bench {
    pub address: String,
    blows: Option<Sender<Blow>>,
    thread: Option<JoinHandle<()>>,
}

impl Bench {
    /// Switches `devices` on.
    pub fn start(devices: &[&str]) -> Self {
        let server = TcpServer::listen("127.0.0.1:0").unwrap();
        let address = profivac_host::port::Port::name(&server).to_owned();
        let devices: Vec<_> = devices.iter().map(|device| built(device)).collect();
        let (blows, inbox) = channel();
        let place = address.clone();
        let live = move || live(server, devices, &inbox, &place);
        Self { address, blows: Some(blows), thread: Some(std::thread::spawn(live)) }
    }

    pub fn strike(&self, blow: Blow) {
        self.blows.as_ref().unwrap().send(blow).unwrap();
    }

    /// Octets of no telegram on the line. A line that is cut takes none.
    pub fn babble(&self, octets: &[u8]) {
        if let Ok(mut stream) = TcpStream::connect(&self.address) {
            stream.write_all(octets).ok();
        }
    }
}

/// A station with a segment for each bench: all its devices, each taken every `poll`.
pub fn config(benches: &[Bench], devices: &[&str], poll: &str, folder: &Path) -> Config {
    let mut text = String::new();
    for (number, bench) in benches.iter().enumerate() {
        text += &format!(
            "[[segment]]\nname = \"s{number}\"\nport = \"tcp://{}\"\nbaud = 187500\nmaster = 1\n",
            bench.address
        );
        for device in devices {
            let (device, address) = device.split_once('@').unwrap();
            text += &format!(
                "[[segment.gauge]]\nname = \"g{number}.{address}\"\ndevice = \"{device}\"\naddress = {address}\npoll = \"{poll}\"\n"
            );
        }
    }
    Config::parse(&text, &folder.join("plant.toml")).unwrap()
}

impl Drop for Bench {
    fn drop(&mut self) {
        self.blows = None;
        self.thread.take().unwrap().join().unwrap();
    }
}

/// A device, and what was done to it.
struct Struck {
    device: VirtualDevice,
    is_deaf: bool,
}

/// Where class 2 masters knock: up to this service access point (profibus-wire 4.1).
const LAST_MS2: u8 = 50;

impl Station for Struck {
    fn telegram(&mut self, end: BitTime, telegram: &Telegram<'_>) -> Option<Transmit<'_>> {
        let is_ms2 = matches!(telegram, Telegram::Data(frame) if frame.dsap.is_some_and(|sap| sap <= LAST_MS2));
        if self.is_deaf && is_ms2 { None } else { self.device.telegram(end, telegram) }
    }

    fn poll(&mut self, now: BitTime) -> Option<Transmit<'_>> {
        self.device.poll(now)
    }

    fn wake_at(&self) -> Option<BitTime> {
        self.device.wake_at()
    }

    fn listening(&self) -> Listening {
        self.device.listening()
    }
}

fn built(text: &str) -> Struck {
    let spec: DeviceSpec = text.parse().unwrap();
    let conditions = GasConditions {
        pressure: "2e-3 mbar".parse().unwrap(),
        atmosphere: "1000 mbar".parse().unwrap(),
        gas: Gas::N2,
    };
    let unit = spec.build(NonvolatileMemory::volatile(), BAUD).unwrap();
    Struck { device: VirtualDevice::new(unit, spec.address, BAUD, conditions), is_deaf: false }
}

/// Serves the line, cut by cut, until nobody strikes any more.
fn live(server: TcpServer, mut devices: Vec<Struck>, blows: &Receiver<Blow>, address: &str) {
    let mut server = Some(server);
    loop {
        if let Some(server) = server.take() {
            match serve(server, devices, blows) {
                Some(rest) => devices = rest,
                None => return,
            }
        }
        match blows.recv() {
            Ok(Blow::Mend) => server = Some(TcpServer::listen(address).unwrap()),
            Ok(blow) => strike(&mut devices, blow),
            Err(_) => return,
        }
    }
}

/// Until the line is cut: then the devices are what is left.
fn serve(server: TcpServer, devices: Vec<Struck>, blows: &Receiver<Blow>) -> Option<Vec<Struck>> {
    let mut segment = Segment::new(Box::new(server), BAUD, false, devices);
    loop {
        segment.serve(&[], Duration::from_millis(20)).unwrap();
        match blows.try_recv() {
            Ok(Blow::Cut) => return Some(std::mem::take(segment.stations_mut())),
            Ok(blow) => strike(segment.stations_mut(), blow),
            Err(TryRecvError::Empty) => {}
            Err(TryRecvError::Disconnected) => return None,
        }
    }
}

fn strike(devices: &mut [Struck], blow: Blow) {
    match blow {
        Blow::Power(place, on) => at(devices, place).device.set_power(on),
        Blow::Deaf(place, is_deaf) => at(devices, place).is_deaf = is_deaf,
        Blow::Swap(place, other) => *at(devices, place) = built(other),
        Blow::Cut | Blow::Mend => {}
    }
}

fn at(devices: &mut [Struck], place: u8) -> &mut Struck {
    devices.iter_mut().find(|struck| struck.device.switch_address() == place).unwrap()
}
