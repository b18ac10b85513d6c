//! Two class 1 masters in one ring whose token rotation time is too short for all services: no master loses a slave or a
//! connection.

use super::line::{BAUD, TOKEN_RULES, parameters};
use crate::common::{CFG, IDENT, Plain};
use profivac_dp::link::BitTime;
use profivac_dp::link::active::{Active, BusParameters};
use profivac_dp::master::{EventKind, Master, Mode, Ms2Parameters, Phase, Settings, SlaveParameters, ms2, services};
use profivac_dp::slave::{Features, Slave};
use profivac_sim::stations::Tester;
use profivac_sim::{Random, Segment, StationHandle};

type Class1 = Master<4, 8>;

/// A master in Operate with four slaves and the target rotation time `rotation_tbit`.
fn class1(address: u8, slaves: &[u8], rotation_tbit: u32) -> Active<Class1> {
    let segment = BusParameters { rotation_tbit, ..parameters(address) };
    let mut master = Class1::on(segment.check().unwrap(), Settings::new(BAUD), BitTime(0));
    for slave in slaves {
        let watchdog = Some([20, 1]);
        master.user.add(&SlaveParameters { watchdog, ..SlaveParameters::new(*slave, IDENT, &CFG) }).unwrap();
    }
    master.user.set_mode(Mode::Operate);
    master
}

struct Pair {
    segment: Segment,
    masters: [StationHandle<Active<Class1>>; 2],
    connections: [profivac_dp::master::Handle<ms2::Connect>; 2],
    pending: [Option<profivac_dp::master::Handle<ms2::Read>>; 2],
    reads: [u32; 2],
    raw: [u32; 2],
}

const SLAVES: [[u8; 4]; 2] = [[30, 31, 32, 33], [40, 41, 42, 43]];

impl Pair {
    fn new(rotation_tbit: u32) -> Self {
        let mut segment = Segment::new(BAUD);
        for address in SLAVES.iter().flatten() {
            let features = Features { sync: true, freeze: true, dpv1: true, ms1: true };
            segment.attach(Slave::new(Plain { features, ..Plain::new() }, *address, BAUD));
        }
        let masters = [(2, SLAVES[0]), (5, SLAVES[1])];
        let masters = masters.map(|(address, slaves)| segment.attach(class1(address, &slaves, rotation_tbit)));
        segment.run_for(BAUD.tbit_of_ms(200)).unwrap();
        // Each master has a connection to a slave of the other.
        let connections = [0, 1].map(|number| {
            let parameters =
                Ms2Parameters { send_timeout: 10, response_timeout: 10, pace_tbit: 0, ..Ms2Parameters::new(BAUD) };
            let master = &mut segment.station_mut(masters[number]).user;
            while master.next_event().is_some() {}
            master.ms2_open(SLAVES[1 - number][0], &parameters).unwrap()
        });
        segment.run_for(BAUD.tbit_of_ms(200)).unwrap();
        Self { segment, masters, connections, pending: [None; 2], reads: [0; 2], raw: [0; 2] }
    }

    /// Takes the results and sends new requests.
    fn work(&mut self) {
        for (number, slaves) in SLAVES.iter().enumerate() {
            let master = &mut self.segment.station_mut(self.masters[number]).user;
            let connection = self.connections[number];
            if let Some(Err(end)) = master.outcome(connection) {
                panic!("{number}: {end}");
            }
            match self.pending[number].and_then(|read| master.outcome(read)) {
                Some(Err(ms2::RequestError::Ended(end) | ms2::RequestError::NotExecuted(end))) => {
                    panic!("{number}: {end}")
                }
                Some(_) => self.reads[number] += 1,
                None => {}
            }
            if master.ms2_phase(connection) == Some(Phase::Open)
                // Busy: the previous request is pending.
                && let Ok(read) = master.ms2_read(connection, 1, 16, 8)
            {
                self.pending[number] = Some(read);
            }
            self.raw[number] += u32::from(master.take_confirmation().is_some());
            let _ = master.submit_request(&services::slave_diag(slaves[1]));
        }
    }

    /// Asserts that both masters exchange data with all their slaves and have no further events.
    fn nothing_was_lost(&mut self, name: &str) {
        for (station, slaves) in self.masters.into_iter().zip(SLAVES) {
            let master = &mut self.segment.station_mut(station).user;
            assert_eq!(master.exchanging(), 4, "{name}");
            let report = std::iter::from_fn(|| master.next_event());
            let report: Vec<_> = report.filter(|event| !matches!(event.kind, EventKind::Acyclic(..))).collect();
            assert_eq!(report, [], "{name}");
            assert_eq!(slaves.map(|slave| master.counters(slave).unwrap().starts), [1; 4], "{name}");
        }
    }
}

/// T_TR in bit times. A rotation with all services takes about 5000, one with a single exchange each about 800.
const ROTATIONS: [u32; 5] = [1000, 1300, 2000, 3000, 5000];

#[test]
fn no_master_loses_a_slave_or_a_connection_with_a_short_rotation_time() {
    for rotation in ROTATIONS {
        let mut pair = Pair::new(rotation);
        for _ in 0..2000 {
            pair.segment.run_for(1000).unwrap();
            pair.work();
        }
        pair.nothing_was_lost(&rotation.to_string());
        let lost = |pair: &Pair, number: usize| {
            let master = &pair.segment.station(pair.masters[number]).user;
            SLAVES[number].map(|slave| master.counters(slave).unwrap().lost)
        };
        assert_eq!([lost(&pair, 0), lost(&pair, 1)], [[0; 4]; 2], "{rotation}");
        let Pair { reads, raw, .. } = pair;
        assert!(reads.iter().all(|reads| *reads >= 5), "{rotation}: {reads:?}");
        assert!(raw.iter().all(|raw| *raw >= 10), "{rotation}: {raw:?}");
    }
}

/// A spurious token makes the holder abandon its message cycle. The slave and the connection are not affected.
#[test]
fn a_message_cycle_abandoned_for_another_master_loses_no_slave_or_connection() {
    for (seed, rotation) in (0..).zip(ROTATIONS) {
        let mut random = Random::new(seed);
        let mut pair = Pair::new(rotation);
        let tester = pair.segment.attach(Tester::new());
        pair.segment.exempt(tester.id());
        TOKEN_RULES.into_iter().for_each(|rule| pair.segment.allow(rule));
        for _ in 0..100 {
            let token = [[0xDC, 2, 5], [0xDC, 5, 2]][random.below(2) as usize];
            let at = pair.segment.now() + random.below(20_000);
            pair.segment.station_mut(tester).send(at, &token);
            for _ in 0..20 {
                pair.segment.run_for(1000).unwrap();
                pair.work();
            }
        }
        let given_up = pair.masters.map(|master| pair.segment.station(master).ring_counters().given_up);
        assert!(given_up.iter().sum::<u32>() >= 20, "{rotation}: {given_up:?}");
        pair.nothing_was_lost(&rotation.to_string());
    }
}
