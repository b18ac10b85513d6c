//! profirust in a thread. Its own ports refuse a pty and its clock is the wall clock, so the test supplies port and time.

use crate::peers::slave::Slave;
use crate::peers::watched::{Event, Watched};
use profirust::Baudrate;
use profirust::dp::{DpMaster, Peripheral, PeripheralEvent, PeripheralOptions};
use profirust::fdl::{FdlActiveStation, ParametersBuilder};
use profirust::phy::ProfibusPhy;
use profirust::time::Instant;
use rustix::event::{PollFd, PollFlags, Timespec, poll};
use std::fs::File;
use std::io::{Read, Write};
use std::path::Path;
use std::sync::mpsc::{Receiver, Sender, TryRecvError, channel};
use std::thread::{self, JoinHandle};

const MASTER: u8 = 2;

/// A slot time within which a loaded computer answers: 52 ms.
const SLOT_TBIT: u16 = 1000;

/// Sixteen requests without an answer take 0.8 s: longer than a pause of the computer, shorter than the muting in the tests. After
/// the last one this master stays offline (see `profirust_stays_offline_after_muted_answers_until_the_gauge_restarts`).
const RETRIES: u8 = 15;

/// The wait for octets between two looks at the clock: 1 ms.
const TICK: Timespec = Timespec { tv_sec: 0, tv_nsec: 1_000_000 };

/// A pty as a port of profirust.
struct PtyPhy {
    pty: File,
    received: Vec<u8>,
}

impl PtyPhy {
    fn open(path: &Path) -> Self {
        Self { pty: File::options().read(true).write(true).open(path).unwrap(), received: Vec::new() }
    }

    /// Waits briefly for octets. Returns whether any arrived.
    fn wait(&mut self) -> bool {
        if poll(&mut [PollFd::new(&self.pty, PollFlags::IN)], Some(&TICK)).unwrap() == 0 {
            return false;
        }
        let mut buffer = [0; 512];
        let length = self.pty.read(&mut buffer).unwrap();
        self.received.extend_from_slice(&buffer[..length]);
        true
    }
}

impl ProfibusPhy for PtyPhy {
    fn poll_transmission(&mut self, _now: Instant) -> bool {
        false
    }

    fn transmit_data<F: FnOnce(&mut [u8]) -> (usize, R), R>(&mut self, _now: Instant, fill: F) -> R {
        let mut buffer = [0; 256];
        let (length, result) = fill(&mut buffer);
        self.pty.write_all(&buffer[..length]).unwrap();
        result
    }

    fn receive_data<F: FnOnce(&[u8]) -> (usize, R), R>(&mut self, _now: Instant, take: F) -> R {
        let (taken, result) = take(&self.received);
        self.received.drain(..taken);
        result
    }
}

/// A master in a thread. The thread ends when this is dropped.
struct Running {
    stop: Option<Sender<()>>,
    thread: Option<JoinHandle<()>>,
}

impl Drop for Running {
    fn drop(&mut self) {
        self.stop = None;
        self.thread.take().map(JoinHandle::join);
    }
}

/// Brings a slave to Data_Exchange.
pub fn start(line: &Path, slave: &Slave) -> Watched {
    let (phy, slave) = (PtyPhy::open(line), slave.clone());
    Watched::start(|events| {
        let (stop, stopped) = channel();
        let thread = thread::spawn(move || run(phy, &slave, &events, &stopped));
        Running { stop: Some(stop), thread: Some(thread) }
    })
}

/// Exchanges data and reports changes, until it is stopped.
fn run(mut phy: PtyPhy, slave: &Slave, events: &Sender<Event>, stopped: &Receiver<()>) {
    let options = PeripheralOptions {
        ident_number: slave.ident,
        user_parameters: Some(&slave.user_prm),
        config: Some(&slave.cfg),
        max_tsdr: 60,
        ..PeripheralOptions::default()
    };
    let mut master = DpMaster::new(Vec::new());
    let gauge = master.add(Peripheral::new(slave.address, options, vec![0; slave.inputs], vec![0; slave.outputs]));
    let mut parameters = ParametersBuilder::new(MASTER, Baudrate::B19200);
    let parameters = parameters.slot_bits(SLOT_TBIT).max_retry_limit(RETRIES).build_verified(&master);
    let mut station = FdlActiveStation::new(parameters);
    station.set_online();
    master.enter_operate();
    let begin = std::time::Instant::now();
    let mut last = Vec::new();
    // The receiver is dropped when the test has its result.
    let tell = |event| events.send(event).unwrap_or(());
    while stopped.try_recv() == Err(TryRecvError::Empty) {
        let answered = phy.wait();
        let now = Instant::from_micros(i64::try_from(begin.elapsed().as_micros()).unwrap());
        station.poll(now, &mut phy, &mut master);
        match master.take_last_events().peripheral {
            Some((_, PeripheralEvent::Configured)) => tell(Event::Exchanging(true)),
            Some((_, PeripheralEvent::Offline)) => tell(Event::Exchanging(false)),
            _ => {}
        }
        let gauge = master.get_mut(gauge);
        if answered && !gauge.is_live() {
            tell(Event::Unheeded);
        }
        if gauge.is_running() && gauge.pi_i() != last {
            last = gauge.pi_i().to_vec();
            tell(Event::Inputs(last.clone()));
        }
    }
}
