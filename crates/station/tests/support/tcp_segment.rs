//! Virtual devices behind a TCP port, with faults: a gauge loses power, the line is cut, noise is on the line.

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

/// A fault, or its end.
#[derive(Clone, Copy, Debug)]
pub enum Fault {
    /// The gauge at this address loses power, or gets it back.
    Power(u8, bool),
    /// The gauge at this address is replaced by another device.
    Swap(u8, &'static str),
    /// The gauge at this address answers no class 2 master, or answers again.
    NoMs2(u8, bool),
    /// The line is cut.
    Cut,
    /// The line is served again.
    Mend,
}

/// Virtual devices behind a TCP port.
pub struct TcpSegment {
    pub address: String,
    faults: Option<Sender<Fault>>,
    thread: Option<JoinHandle<()>>,
}

impl TcpSegment {
    /// Switches `devices` on.
    pub fn start(devices: &[&str]) -> Self {
        let server = TcpServer::listen("127.0.0.1:0").unwrap();
        let address = profivac_host::port::Port::name(&server).to_owned();
        let devices: Vec<_> = devices.iter().map(|device| built(device)).collect();
        let (faults, inbox) = channel();
        let own = address.clone();
        let run = move || run(server, devices, &inbox, &own);
        Self { address, faults: Some(faults), thread: Some(std::thread::spawn(run)) }
    }

    pub fn apply(&self, fault: Fault) {
        self.faults.as_ref().unwrap().send(fault).unwrap();
    }

    /// Puts octets on the line that are no telegram, unless the line is cut.
    pub fn send_noise(&self, octets: &[u8]) {
        if let Ok(mut stream) = TcpStream::connect(&self.address) {
            stream.write_all(octets).ok();
        }
    }
}

/// The configuration of a station with all these segments, whose gauges are polled every `poll`.
pub fn config(segments: &[TcpSegment], devices: &[&str], poll: &str, folder: &Path) -> Config {
    let mut text = String::new();
    for (number, segment) in segments.iter().enumerate() {
        text += &format!(
            "[[segment]]\nname = \"s{number}\"\nport = \"tcp://{}\"\nbaud = 187500\nmaster = 1\n",
            segment.address
        );
        for device in devices {
            let (device, address) = device.split_once('@').unwrap();
            text += &format!(
                "[[segment.gauge]]\nname = \"g{number}.{address}\"\ndevice = \"{device}\"\naddress = {address}\npoll = \"{poll}\"\n"
            );
        }
    }
    profivac_config::parse(&text, &folder.join("plant.toml")).unwrap()
}

impl Drop for TcpSegment {
    fn drop(&mut self) {
        self.faults = None;
        self.thread.take().unwrap().join().unwrap();
    }
}

/// A device with its faults.
struct FaultyDevice {
    device: VirtualDevice,
    has_no_ms2: bool,
}

/// Class 2 masters use the service access points up to this one (profibus-wire 4.1).
const LAST_MS2: u8 = 50;

impl Station for FaultyDevice {
    fn telegram(&mut self, end: BitTime, telegram: &Telegram<'_>) -> Option<Transmit<'_>> {
        let is_ms2 = matches!(telegram, Telegram::Data(frame) if frame.dsap.is_some_and(|sap| sap <= LAST_MS2));
        if self.has_no_ms2 && is_ms2 { None } else { self.device.telegram(end, telegram) }
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

fn built(text: &str) -> FaultyDevice {
    let spec: DeviceSpec = text.parse().unwrap();
    let conditions = GasConditions {
        pressure: "2e-3 mbar".parse().unwrap(),
        atmosphere: "1000 mbar".parse().unwrap(),
        gas: Gas::N2,
    };
    let unit = spec.build(NonvolatileMemory::volatile(), BAUD).unwrap();
    FaultyDevice { device: VirtualDevice::new(unit, spec.address, BAUD, conditions), has_no_ms2: false }
}

/// Serves the line, from cut to cut, until the segment is dropped.
fn run(server: TcpServer, mut devices: Vec<FaultyDevice>, faults: &Receiver<Fault>, address: &str) {
    let mut server = Some(server);
    loop {
        if let Some(server) = server.take() {
            match serve(server, devices, faults) {
                Some(rest) => devices = rest,
                None => return,
            }
        }
        match faults.recv() {
            Ok(Fault::Mend) => server = Some(TcpServer::listen(address).unwrap()),
            Ok(fault) => apply(&mut devices, fault),
            Err(_) => return,
        }
    }
}

/// Serves the line until it is cut, and returns the devices; `None` when the segment is dropped.
fn serve(server: TcpServer, devices: Vec<FaultyDevice>, faults: &Receiver<Fault>) -> Option<Vec<FaultyDevice>> {
    let mut segment = Segment::new(Box::new(server), BAUD, false, devices);
    loop {
        segment.serve(&[], Duration::from_millis(20)).unwrap();
        match faults.try_recv() {
            Ok(Fault::Cut) => return Some(std::mem::take(segment.stations_mut())),
            Ok(fault) => apply(segment.stations_mut(), fault),
            Err(TryRecvError::Empty) => {}
            Err(TryRecvError::Disconnected) => return None,
        }
    }
}

fn apply(devices: &mut [FaultyDevice], fault: Fault) {
    match fault {
        Fault::Power(address, on) => at(devices, address).device.set_power(on),
        Fault::NoMs2(address, has_no_ms2) => at(devices, address).has_no_ms2 = has_no_ms2,
        Fault::Swap(address, other) => *at(devices, address) = built(other),
        Fault::Cut | Fault::Mend => {}
    }
}

fn at(devices: &mut [FaultyDevice], address: u8) -> &mut FaultyDevice {
    devices.iter_mut().find(|faulty| faulty.device.switch_address() == address).unwrap()
}
