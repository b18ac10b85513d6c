//! Acyclic services in a ring of two masters: a class 1 master exchanges data with its slaves and reads by MS1, a class 2
//! master reads the same slaves by MS2. The referee checks every transmission; noise is switched on and off.
#![allow(clippy::unwrap_used, clippy::panic, reason = "a test")]

use crate::common;

use common::{CFG, IDENT, Plain};
use profivac_dp::link::active::{Active, BusParameters};
use profivac_dp::link::{Baud, BitTime};
use profivac_dp::master::{Handle, Master, Mode, Ms1Parameters, Ms2Parameters, Settings, SlaveParameters, ms1, ms2};
use profivac_dp::slave::{Features, Slave};
use profivac_sim::{Fault, Noise, Rule, Segment};

const BAUD: Baud = Baud::B1500000;
const SLAVES: [u8; 2] = [10, 11];

type Class1 = Active<Master<2, 8>>;
type Class2 = Active<Master<0, 0>>;

/// A ring of a class 1 master at 2 and a class 2 master at 3.
struct Ring {
    segment: Segment,
    class1: profivac_sim::StationHandle<Class1>,
    class2: profivac_sim::StationHandle<Class2>,
    connections: Vec<Option<Handle<ms2::Connect>>>,
    ms2_reads: Vec<Option<Handle<ms2::Read>>>,
    ms1_reads: Vec<Option<Handle<ms1::Read>>>,
    /// The number of records read by MS2 and MS1, and of failed connections and requests.
    records: [u32; 2],
    failed: u32,
}

impl Ring {
    fn new() -> Self {
        let mut segment = Segment::new(BAUD);
        let parameters = |address| BusParameters { hsa: 5, ..BusParameters::new(address, BAUD) };
        let mut master: Class1 = Master::on(parameters(2).check().unwrap(), Settings::new(BAUD), BitTime(0));
        for address in SLAVES {
            let features = Features { sync: true, freeze: true, dpv1: true, ms1: true };
            segment.attach(Slave::<_>::new(Plain { features, ..Plain::new() }, address, BAUD));
            let slave = SlaveParameters { user_prm: &[0x80, 0, 0], ..SlaveParameters::new(address, IDENT, &CFG) };
            master.user.add(&slave).unwrap();
        }
        master.user.set_mode(Mode::Operate);
        let class1 = segment.attach(master);
        let class2: Class2 = Master::on(parameters(3).check().unwrap(), Settings::new(BAUD), BitTime(0));
        let class2 = segment.attach(class2);
        segment.run_for(1_000_000).unwrap();
        let (connections, ms2_reads, ms1_reads) =
            (vec![None; SLAVES.len()], vec![None; SLAVES.len()], vec![None; SLAVES.len()]);
        Self { segment, class1, class2, connections, ms2_reads, ms1_reads, records: [0; 2], failed: 0 }
    }

    /// Runs with both masters reading continuously.
    fn run(&mut self, tbit: u64) {
        let end = self.segment.now() + tbit;
        while self.segment.now() < end {
            self.segment.run_for(1_500).unwrap();
            for (index, address) in SLAVES.into_iter().enumerate() {
                self.by_ms2(index, address);
                self.by_ms1(index, address);
            }
        }
    }

    fn by_ms2(&mut self, index: usize, address: u8) {
        let user = &mut self.segment.station_mut(self.class2).user;
        let Some(connection) = self.connections[index] else {
            self.connections[index] = user.ms2_open(address, &Ms2Parameters::new(BAUD)).ok();
            return;
        };
        let is_open = match self.ms2_reads[index] {
            None => match user.outcome(connection) {
                None => return,
                Some(opened) => opened.is_ok(),
            },
            Some(read) => match user.outcome(read) {
                None => return,
                Some(Ok(record)) => {
                    assert!(record.len() == 200 && record.iter().all(|octet| *octet == record[0]), "{record:02X?}");
                    self.records[0] += 1;
                    true
                }
                Some(Err(ms2::RequestError::Ended(_) | ms2::RequestError::NotExecuted(_))) => false,
                Some(Err(refused)) => panic!("{refused}"),
            },
        };
        if is_open {
            self.ms2_reads[index] = Some(user.ms2_read(connection, 1, 16, 240).unwrap());
        } else {
            self.failed += 1;
            (self.connections[index], self.ms2_reads[index]) = (None, None);
        }
    }

    fn by_ms1(&mut self, index: usize, address: u8) {
        let user = &mut self.segment.station_mut(self.class1).user;
        if let Some(read) = self.ms1_reads[index] {
            match user.outcome(read) {
                None => return,
                Some(Ok(record)) => {
                    assert!(record.len() == 200 && record.iter().all(|octet| *octet == record[0]), "{record:02X?}");
                    self.records[1] += 1;
                }
                Some(Err(ms1::RequestError::Refused(negative))) => panic!("{negative:?}"),
                Some(Err(_)) => self.failed += 1,
            }
        }
        self.ms1_reads[index] = user.ms1_read(address, 1, 16, 240, &Ms1Parameters::new(BAUD)).ok();
    }

    fn exchanges(&self) -> [u32; 2] {
        SLAVES.map(|address| self.segment.station(self.class1).user.counters(address).unwrap().exchanges)
    }
}

#[test]
fn two_masters_read_the_same_slaves_at_the_same_time() {
    let mut ring = Ring::new();
    let before = ring.exchanges();
    ring.run(3_000_000);
    assert!(ring.records.iter().all(|records| *records > 100), "{:?}", ring.records);
    assert_eq!(ring.failed, 0);
    let after = ring.exchanges();
    assert!(after[0] > before[0] + 500 && after[1] > before[1] + 500, "{before:?} {after:?}");
}

/// Noise may invert any bit. It never leads to a wrong value, and all services continue afterwards.
#[test]
fn noise_never_leads_to_a_wrong_record() {
    let mut ring = Ring::new();
    for rule in [
        Rule::Collision,
        Rule::NoTelegram,
        Rule::BeforeSlotTime,
        Rule::Unrequested,
        Rule::SecondAnswer,
        Rule::NoToken,
        Rule::SecondToken,
        Rule::Ring,
    ] {
        ring.segment.allow(rule);
    }
    for seed in 0..4 {
        ring.segment.inject(Fault::Noise(Some(Noise::new(seed, 2e-4))));
        ring.run(1_500_000);
        ring.segment.inject(Fault::Noise(None));
        // Longer than any timeout, so that every pending service has ended.
        ring.run(9_000_000);
        let before = ring.records;
        ring.run(1_500_000);
        let after = ring.records;
        assert!(after[0] > before[0] + 50 && after[1] > before[1] + 50, "seed {seed}: {before:?} {after:?}");
    }
}
