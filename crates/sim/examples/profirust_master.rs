//! profirust as the master of one slave behind a TCP port: `profirust_master HOST:PORT ADDRESS IDENT CFG USER_PRM OUTPUTS INPUTS`, with
//! numbers in decimal and IDENT, CFG and USER_PRM in hexadecimal digits.
//!
//! Prints a line for each event: `exchanging`, `offline`, `diagnosis FLAGS IDENT MASTER`, `inputs OCTETS`. A line of hexadecimal
//! digits on standard input becomes the outputs. Ends with standard input. `firmware/check.py` runs it against a gauge in QEMU.

use profirust::Baudrate;
use profirust::dp::{DpMaster, Peripheral, PeripheralEvent, PeripheralOptions};
use profirust::fdl::{FdlActiveStation, ParametersBuilder};
use profirust::phy::ProfibusPhy;
use profirust::time::Instant;
use std::error::Error;
use std::io::{self, ErrorKind, Read, Write};
use std::net::TcpStream;
use std::sync::mpsc::{Receiver, TryRecvError, channel};
use std::thread;
use std::time::Duration;

const MASTER: u8 = 2;

/// A slot time within which an emulated gauge on a loaded computer answers: 52 ms.
const SLOT_TBIT: u16 = 1000;

/// profirust does not exchange data again after it has given up (`crates/cli/tests/peers`), so it gives up late.
const RETRIES: u8 = 15;

/// The wait for octets between two looks at the clock.
const TICK: Duration = Duration::from_millis(1);

/// A TCP stream as a port of profirust.
struct TcpPhy {
    stream: TcpStream,
    received: Vec<u8>,
    error: Option<io::Error>,
}

impl TcpPhy {
    fn open(address: &str) -> io::Result<Self> {
        let stream = TcpStream::connect(address)?;
        stream.set_nodelay(true)?;
        stream.set_read_timeout(Some(TICK))?;
        Ok(Self { stream, received: Vec::new(), error: None })
    }

    /// Waits briefly for octets.
    fn wait(&mut self) -> io::Result<()> {
        let mut buffer = [0; 512];
        match self.stream.read(&mut buffer) {
            Ok(0) => Err(ErrorKind::UnexpectedEof.into()),
            Ok(length) => {
                self.received.extend(buffer.iter().take(length));
                Ok(())
            }
            Err(error) if matches!(error.kind(), ErrorKind::WouldBlock | ErrorKind::TimedOut) => Ok(()),
            Err(error) => Err(error),
        }
    }
}

impl ProfibusPhy for TcpPhy {
    fn poll_transmission(&mut self, _now: Instant) -> bool {
        false
    }

    fn transmit_data<F: FnOnce(&mut [u8]) -> (usize, R), R>(&mut self, _now: Instant, fill: F) -> R {
        let mut buffer = [0; 256];
        let (length, result) = fill(&mut buffer);
        self.error = self.stream.write_all(buffer.get(..length).unwrap_or_default()).err();
        result
    }

    fn receive_data<F: FnOnce(&[u8]) -> (usize, R), R>(&mut self, _now: Instant, take: F) -> R {
        let (taken, result) = take(&self.received);
        self.received.drain(..taken);
        result
    }
}

fn octets(digits: &str) -> Result<Vec<u8>, Box<dyn Error>> {
    let octet = |at| digits.get(at..at + 2).ok_or("an octet has two digits");
    (0..digits.len()).step_by(2).map(|at| Ok(u8::from_str_radix(octet(at)?, 16)?)).collect()
}

fn digits(octets: &[u8]) -> String {
    octets.iter().map(|octet| format!("{octet:02x}")).collect()
}

/// The lines of standard input. The channel closes at its end.
fn lines() -> Receiver<String> {
    let (sender, lines) = channel();
    thread::spawn(move || io::stdin().lines().map_while(Result::ok).try_for_each(|line| sender.send(line)));
    lines
}

fn main() -> Result<(), Box<dyn Error>> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let [port, address, ident, cfg, user_prm, outputs, inputs] = arguments.as_slice() else {
        return Err("expected HOST:PORT ADDRESS IDENT CFG USER_PRM OUTPUTS INPUTS".into());
    };
    let (cfg, user_prm) = (octets(cfg)?, octets(user_prm)?);
    let options = PeripheralOptions {
        ident_number: u16::from_str_radix(ident, 16)?,
        user_parameters: Some(&user_prm),
        config: Some(&cfg),
        max_tsdr: 60,
        ..PeripheralOptions::default()
    };
    let mut phy = TcpPhy::open(port)?;
    let mut master = DpMaster::new(Vec::new());
    let gauge = Peripheral::new(address.parse()?, options, vec![0; inputs.parse()?], vec![0; outputs.parse()?]);
    let gauge = master.add(gauge.with_diag_buffer(vec![0; 244]));
    let mut parameters = ParametersBuilder::new(MASTER, Baudrate::B19200);
    let parameters = parameters.slot_bits(SLOT_TBIT).max_retry_limit(RETRIES).build_verified(&master);
    let mut station = FdlActiveStation::new(parameters);
    station.set_online();
    master.enter_operate();
    let (lines, begin) = (lines(), std::time::Instant::now());
    let (mut last, mut told) = (Vec::new(), String::new());
    loop {
        match lines.try_recv() {
            Ok(line) => {
                let wanted = octets(line.trim())?;
                let target = master.get_mut(gauge).pi_q_mut();
                if target.len() != wanted.len() {
                    return Err(format!("{} octets of outputs instead of {}", wanted.len(), target.len()).into());
                }
                target.copy_from_slice(&wanted);
            }
            Err(TryRecvError::Empty) => {}
            Err(TryRecvError::Disconnected) => return Ok(()),
        }
        phy.wait()?;
        station.poll(Instant::from_micros(i64::try_from(begin.elapsed().as_micros())?), &mut phy, &mut master);
        if let Some(error) = phy.error.take() {
            return Err(error.into());
        }
        match master.take_last_events().peripheral {
            Some((_, PeripheralEvent::Configured)) => println!("exchanging"),
            Some((_, PeripheralEvent::Offline)) => println!("offline"),
            _ => {}
        }
        let gauge = master.get_mut(gauge);
        if let Some(diagnosis) = gauge.last_diagnostics() {
            let (ident, owner) = (diagnosis.ident_number, diagnosis.master_address);
            let owner = owner.map_or_else(|| "none".to_owned(), |owner| owner.to_string());
            let line = format!("diagnosis {:04x} {ident:04x} {owner}", diagnosis.flags.bits());
            if line != told {
                println!("{line}");
                told = line;
            }
        }
        if gauge.is_running() && gauge.pi_i() != last {
            last = gauge.pi_i().to_vec();
            println!("inputs {}", digits(&last));
        }
    }
}
