//! A thousand million bit times with one bit in ten thousand inverted: data exchange continues, and no station ever accepts a
//! value that was not sent to it.

#![allow(clippy::unwrap_used, clippy::panic, reason = "a test")]

use profivac_dp::link::active::{Active, BusParameters};
use profivac_dp::link::{Baud, BitTime};
use profivac_dp::master::{Master, Mode, Settings, SlaveParameters};
use profivac_dp::slave::{CfgFault, Device, Features, Outputs, PrmFault, Slave};
use profivac_sim::{Fault, Noise, Segment, StationHandle};
use profivac_wire::address::SetSlaveAdd;
use profivac_wire::cfg::Lengths;

const BAUD: Baud = Baud::B1500000;
const MASTER: u8 = 2;
const SLAVES: std::ops::Range<u8> = 10..18;
const SEED: u64 = 20_260_801;

/// Eight octets in and out, two identifiers.
const CFG: [u8; 2] = [0x17, 0x27];
const USER_PRM: [u8; 3] = [0xC3, 0x5A, 0x0F];

/// The valid value of a station, a direction and a number: eight octets.
fn value(station: u8, direction: u8, number: u32) -> [u8; 8] {
    let mut mixed = u64::from(station) << 40 | u64::from(direction) << 32 | u64::from(number);
    mixed = (mixed ^ mixed >> 30).wrapping_mul(0xBF58_476D_1CE4_E5B9);
    let [high, low, ..] = (mixed ^ mixed >> 27).to_be_bytes();
    let [n1, n2, n3, n4] = number.to_be_bytes();
    [station, direction, n1, n2, n3, n4, high, low]
}

fn number(octets: &[u8]) -> u32 {
    u32::from_be_bytes([octets[2], octets[3], octets[4], octets[5]])
}

const OUT: u8 = 0x0F;
const IN: u8 = 0xF0;

/// A device that checks everything it receives.
struct Witness {
    address: u8,
    samples: u32,
    taken: u32,
    /// The received values that were not sent to it.
    wrong: Vec<String>,
}

impl Device for Witness {
    fn ident_number(&self) -> u16 {
        0x1234
    }

    fn features(&self) -> Features {
        Features::default()
    }

    fn set_prm(&mut self, user: &[u8]) -> Result<(), PrmFault> {
        if user == USER_PRM {
            return Ok(());
        }
        self.wrong.push(format!("user parameters {user:02X?}"));
        Err(PrmFault)
    }

    fn chk_cfg(&mut self, cfg: &[u8]) -> Result<Lengths, CfgFault> {
        if cfg == CFG {
            return Ok(Lengths { outputs: 8, inputs: 8 });
        }
        self.wrong.push(format!("configuration {cfg:02X?}"));
        Err(CfgFault)
    }

    fn get_cfg(&self) -> &[u8] {
        &CFG
    }

    fn outputs(&mut self, outputs: Outputs<'_>) {
        let Outputs::Data(data) = outputs else { return };
        self.taken += 1;
        if data != value(self.address, OUT, number(data)) {
            self.wrong.push(format!("outputs {data:02X?}"));
        }
    }

    fn inputs(&mut self, inputs: &mut [u8]) {
        self.samples += 1;
        inputs.copy_from_slice(&value(self.address, IN, self.samples));
    }

    fn address_is_settable(&self) -> bool {
        true
    }

    fn set_address(&mut self, request: &SetSlaveAdd<'_>) -> Option<u8> {
        self.wrong.push(format!("the address {}", request.address));
        None
    }
}

type Class1 = Active<Master<8, 8>>;

fn segment() -> (Segment, StationHandle<Class1>, Vec<StationHandle<Slave<Witness>>>) {
    let mut segment = Segment::new(BAUD);
    let mut master =
        Master::<8, 8>::on(BusParameters::new(MASTER, BAUD).check().unwrap(), Settings::new(BAUD), BitTime(0));
    for address in SLAVES {
        let mut slave = SlaveParameters::new(address, 0x1234, &CFG);
        slave.user_prm = &USER_PRM;
        master.user.add(&slave).unwrap();
    }
    master.user.set_mode(Mode::Operate);
    let slaves = SLAVES.map(|address| {
        let device = Witness { address, samples: 0, taken: 0, wrong: Vec::new() };
        segment.attach(Slave::new(device, address, BAUD))
    });
    let slaves = slaves.collect();
    let master = segment.attach(master);
    (segment, master, slaves)
}

#[test]
fn no_wrong_value_is_ever_accepted_or_stored() {
    println!("seed {SEED}");
    let (mut segment, master, slaves) = segment();
    segment.inject(Fault::Noise(Some(Noise::new(SEED, 1e-4))));
    let mut round = 0;
    // Shorter than a cycle, so that every value is checked before the next one.
    while segment.now() < BitTime(1_000_000_000) {
        round += 1;
        let now = segment.now();
        let user = &mut segment.station_mut(master).user;
        for address in SLAVES {
            user.outputs_mut(address).unwrap().copy_from_slice(&value(address, OUT, round));
            if let Some(inputs) = user.inputs(address) {
                assert_eq!(inputs, value(address, IN, number(inputs)), "inputs of {address}, bit time {now}");
            }
        }
        segment.run_for(1000).unwrap();
        slaves.iter().for_each(|slave| intact(segment.station(*slave)));
    }
    for (address, slave) in SLAVES.zip(&slaves) {
        let counters = segment.station(master).user.counters(address).unwrap();
        println!("slave {address}: {counters:?}, {} outputs taken", segment.station(*slave).device().taken);
        assert!(counters.exchanges > 200_000, "data exchange continues");
        assert!(counters.repetitions > 1000, "the noise causes repetitions");
    }
}

/// Asserts that a slave received valid values only.
fn intact(slave: &Slave<Witness>) {
    assert!(slave.device().wrong.is_empty(), "{:?}", slave.device().wrong);
    assert_eq!((slave.address(), slave.min_tsdr_tbit()), (slave.device().address, 11));
    if let Some(owner) = slave.state().owner() {
        let period = owner.watchdog.map(|watchdog| watchdog.period_tbit);
        assert_eq!((owner.master, owner.group, period), (MASTER, 0, Some(1_500_000)));
    }
}
