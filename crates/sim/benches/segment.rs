//! The speed of the simulation relative to real time: a master and 125 slaves at 12 Mbit/s, two octets in each direction, on
//! one core, with the referee. Run with `cargo bench -p profivac-sim --bench segment`.

use profivac_dp::link::active::BusParameters;
use profivac_dp::link::{Baud, BitTime};
use profivac_dp::master::{Master, Mode, Settings, SlaveParameters};
use profivac_dp::slave::{CfgFault, Device, Features, Outputs, PrmFault, Slave};
use profivac_sim::Segment;
use profivac_wire::cfg::Lengths;
use std::time::Instant;

const BAUD: Baud = Baud::B12000000;
const MASTER: u8 = 0;
const SLAVES: std::ops::RangeInclusive<u8> = 1..=125;
const IDENT: u16 = 0x1234;
const CFG: [u8; 2] = [0x11, 0x21];

/// Returns its outputs as inputs.
#[derive(Default)]
struct Mirror([u8; 2]);

impl Device for Mirror {
    fn ident_number(&self) -> u16 {
        IDENT
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
        &CFG
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

/// Simulates `ms` milliseconds with the stations at this number of positions of the cable.
fn run(places: u64, ms: u64) {
    let mut segment = Segment::new(BAUD);
    let bus = BusParameters::new(MASTER, BAUD).check().unwrap_or_else(|rejected| unreachable!("{rejected}"));
    let mut master = Master::<125, 8>::on(bus, Settings::new(BAUD), BitTime(0));
    for address in SLAVES {
        if let Err(rejected) = master.user.add(&SlaveParameters::new(address, IDENT, &CFG)) {
            println!("{rejected}");
        }
        segment.attach_at(u64::from(address) % places, Slave::<_>::new(Mirror::default(), address, BAUD));
    }
    master.user.set_mode(Mode::Operate);
    let master = segment.attach(master);
    let began = Instant::now();
    let outcome = segment.run_until(BitTime(BAUD.tbit_of_ms(ms)));
    let took = began.elapsed().as_secs_f64();
    if let Err(violation) = outcome {
        println!("{violation}");
    }
    let user = &segment.station(master).user;
    let counters = SLAVES.filter_map(|address| user.counters(address));
    let exchanges: u32 = counters.map(|counters| counters.exchanges).sum();
    let ratio = ms as f64 / 1000.0 / took;
    let each = took * 1e9 / f64::from(exchanges);
    println!(
        "{places:3} places: {ms} ms in {took:.3} s, {ratio:.1} x real time, {exchanges} exchanges, {each:.0} ns each"
    );
}

/// Runs all cases. With two arguments, a number of positions and of milliseconds, it runs that case alone, to count instructions.
fn main() {
    let numbers: Vec<u64> = std::env::args().filter_map(|argument| argument.parse().ok()).collect();
    match numbers.as_slice() {
        [places, ms] => run(*places, *ms),
        _ => [(1, 10_000), (2, 10_000), (6, 10_000), (125, 1000)].into_iter().for_each(|(places, ms)| run(places, ms)),
    }
}
