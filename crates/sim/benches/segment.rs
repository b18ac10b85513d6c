//! How much faster than the real thing a full segment is simulated: a master and 125 slaves at 12 Mbit/s, two octets each
//! way, on one core, with the referee on. Run with `cargo bench -p profivac-sim --bench segment`.

use profivac_dp::link::{Baud, BitTime};
use profivac_dp::slave::{CfgFault, Device, Features, Outputs, PrmFault, Slave};
use profivac_sim::stations::Poller;
use profivac_sim::{Bus, Limits};
use profivac_wire::cfg::Lengths;
use profivac_wire::{Frame, MAX_TELEGRAM, Telegram};
use std::time::Instant;

const BAUD: Baud = Baud::B12000000;
const SLAVES: u8 = 125;
const MASTER: u8 = 0;

/// Returns its outputs as inputs.
#[derive(Default)]
struct Mirror([u8; 2]);

impl Device for Mirror {
    fn ident_number(&self) -> u16 {
        0x1234
    }
    fn features(&self) -> Features {
        Features::default()
    }
    fn set_prm(&mut self, _user: &[u8]) -> Result<(), PrmFault> {
        Ok(())
    }
    fn chk_cfg(&mut self, _cfg: &[u8]) -> Result<Lengths, CfgFault> {
        Ok(Lengths { outputs: 2, inputs: 2 })
    }
    fn get_cfg(&self) -> &[u8] {
        &[0x11, 0x21]
    }
    fn outputs(&mut self, outputs: Outputs<'_>) {
        if let Outputs::Data(data) = outputs {
            self.0.copy_from_slice(data);
        }
    }
    fn inputs(&mut self, inputs: &mut [u8]) {
        inputs.copy_from_slice(&self.0);
    }
}

fn request(da: u8, fc: u8, dsap: Option<u8>, du: &[u8]) -> Vec<u8> {
    let frame = Frame { da, sa: MASTER, dsap, ssap: dsap.map(|_| 62), fc, du };
    let mut octets = vec![0; MAX_TELEGRAM];
    let length = Telegram::Frame(frame).emit(&mut octets).unwrap_or_default();
    octets.truncate(length);
    octets
}

/// Set_Prm with a watchdog of a second and Chk_Cfg for all, then two exchanges with each for ever.
fn poller() -> Poller {
    let mut requests = Vec::new();
    for slave in 1..=SLAVES {
        requests.push(request(slave, 0x6D, Some(61), &[0x88, 10, 10, 11, 0x12, 0x34, 0]));
        requests.push(request(slave, 0x5D, Some(62), &[0x11, 0x21]));
    }
    let again = requests.len();
    for fc in [0x7D, 0x5D] {
        requests.extend((1..=SLAVES).map(|slave| request(slave, fc, None, &[slave, fc])));
    }
    Poller::new(Limits::of(BAUD), requests, again)
}

/// Simulates `ms` milliseconds with the stations spread over so many places of the cable.
fn run(places: u64, ms: u64) {
    let mut bus = Bus::new(BAUD);
    let master = bus.attach(poller());
    for slave in 1..=SLAVES {
        bus.attach_at(u64::from(slave) % places, Slave::new(Mirror::default(), slave, BAUD));
    }
    let began = Instant::now();
    let outcome = bus.run_until(BitTime(BAUD.tbit_of_ms(ms)));
    let took = began.elapsed().as_secs_f64();
    if let Err(foul) = outcome {
        println!("{foul}");
    }
    let answers = bus.station(master).answers;
    let ratio = ms as f64 / 1000.0 / took;
    let each = took * 1e9 / answers as f64;
    println!("{places:3} places: {ms} ms in {took:.3} s, {ratio:.1} x real time, {answers} answers, {each:.0} ns each");
}

/// Without arguments all of it; with a number of places and milliseconds that alone, for an instruction count.
fn main() {
    let numbers: Vec<u64> = std::env::args().filter_map(|argument| argument.parse().ok()).collect();
    match numbers.as_slice() {
        [places, ms] => run(*places, *ms),
        _ => [(1, 10_000), (2, 10_000), (6, 10_000), (125, 1000)].into_iter().for_each(|(places, ms)| run(places, ms)),
    }
}
