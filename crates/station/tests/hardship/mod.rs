//! A segment in memory to which things happen: gauges lose power, the line is cut, somebody babbles.

#![allow(clippy::unwrap_used, clippy::panic, clippy::indexing_slicing, reason = "a test")]

use profivac_dp::link::Baud;
use profivac_host::bench::{Conditions, VirtualDevice};
use profivac_host::instrument::Spec;
use profivac_host::memory::Memory;
use profivac_host::port::TcpServer;
use profivac_host::segment::Segment;
use profivac_vacuum::Gas;
use std::io::Write;
use std::net::TcpStream;
use std::sync::mpsc::{Receiver, Sender, TryRecvError, channel};
use std::thread::JoinHandle;
use std::time::Duration;

pub const BAUD: Baud = Baud::B187500;

/// What happens.
#[derive(Clone, Copy, Debug)]
pub enum Blow {
    /// The gauge at this place loses power, or has it again.
    Power(u8, bool),
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

impl Drop for Bench {
    fn drop(&mut self) {
        self.blows = None;
        self.thread.take().unwrap().join().unwrap();
    }
}

fn built(text: &str) -> VirtualDevice {
    let spec: Spec = text.parse().unwrap();
    let conditions =
        Conditions { pressure: "2e-3 mbar".parse().unwrap(), atmosphere: "1000 mbar".parse().unwrap(), gas: Gas::N2 };
    VirtualDevice::new(spec.build(Memory::volatile(), BAUD).unwrap(), spec.place, BAUD, conditions)
}

/// Serves the line, cut by cut, until nobody strikes any more.
fn live(server: TcpServer, mut devices: Vec<VirtualDevice>, blows: &Receiver<Blow>, address: &str) {
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
            Ok(Blow::Power(place, on)) => power(&mut devices, place, on),
            Ok(Blow::Cut) => {}
            Err(_) => return,
        }
    }
}

/// Until the line is cut: then the devices are what is left.
fn serve(server: TcpServer, devices: Vec<VirtualDevice>, blows: &Receiver<Blow>) -> Option<Vec<VirtualDevice>> {
    let mut segment = Segment::new(Box::new(server), BAUD, false, devices);
    loop {
        segment.serve(&[], Duration::from_millis(20)).unwrap();
        match blows.try_recv() {
            Ok(Blow::Power(place, on)) => power(segment.stations_mut(), place, on),
            Ok(Blow::Cut) => return Some(std::mem::take(segment.stations_mut())),
            Ok(Blow::Mend) | Err(TryRecvError::Empty) => {}
            Err(TryRecvError::Disconnected) => return None,
        }
    }
}

fn power(devices: &mut [VirtualDevice], place: u8, on: bool) {
    devices.iter_mut().filter(|device| device.place() == place).for_each(|device| device.power(on));
}
