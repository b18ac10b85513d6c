//! A master and eight slaves along the cable, at every baud rate: all slaves exchange data, no station violates a rule, and
//! the cycle has the length of profibus-wire 8.1.

#![allow(clippy::unwrap_used, clippy::panic, reason = "a test")]

use crate::common;

use common::{CFG, IDENT, OWN, Plain};
use profivac_dp::link::active::BusParameters;
use profivac_dp::link::{Baud, BitTime};
use profivac_dp::master::{Master, Mode, Settings, SlaveParameters};
use profivac_dp::slave::Slave;
use profivac_sim::{Segment, StationHandle};

type Class1 = profivac_dp::link::active::Active<Master<8, 8>>;
type Slaves = Vec<StationHandle<Slave<Plain>>>;

/// A master and eight slaves, `apart` bit times apart.
fn segment(baud: Baud, apart: u64) -> (Segment, StationHandle<Class1>, Slaves) {
    let mut segment = Segment::new(baud);
    let parameters = BusParameters::new(OWN, baud);
    let mut master = Master::<8, 8>::on(parameters.check().unwrap(), Settings::new(baud), BitTime(0));
    for address in 10..18 {
        let mut slave = SlaveParameters::new(address, IDENT, &CFG);
        slave.min_tsdr = address;
        master.user.add(&slave).unwrap();
    }
    master.user.set_mode(Mode::Operate);
    let slaves = (10..18)
        .map(|address| segment.attach_at(u64::from(address - 10) * apart, Slave::new(Plain::new(), address, baud)));
    let slaves = slaves.collect();
    let master = segment.attach_at(3 * apart, master);
    (segment, master, slaves)
}

#[test]
fn all_slaves_exchange_data_and_no_station_violates_a_rule() {
    for baud in Baud::ALL {
        for apart in [0, 1, 3] {
            let (mut segment, master, slaves) = segment(baud, apart);
            segment.run_until(BitTime(1_000_000)).unwrap();
            let user = &segment.station(master).user;
            assert_eq!(user.exchanging(), 8, "{baud}\n{}", segment.trace());
            for (address, slave) in (10..18).zip(&slaves) {
                let counters = user.counters(address).unwrap();
                assert!(counters.exchanges > 100, "{baud}, slave {address}: {counters:?}");
                assert_eq!(segment.station(*slave).min_tsdr_tbit(), address.max(11));
            }
        }
    }
}

#[test]
fn an_exchange_takes_the_time_of_the_specification() {
    for baud in Baud::ALL {
        let (mut segment, master, _) = segment(baud, 0);
        segment.set_trace_length(10_000);
        segment.run_until(BitTime(1_000_000)).unwrap();
        let t_id1 = segment.station(master).bus().id1_tbit();
        // Two exchanges with slave 12, and between them one with slave 13: request, T_SDR, answer, T_ID1 each. profibus-wire 8.1:
        // 198 + 11 (O + I) + T_SDR + T_ID1.
        let requests: Vec<_> = segment.trace().entries.iter().filter(|entry| entry.octets.len() == 11).collect();
        let begin =
            |da| move |pair: &[&profivac_sim::trace::Entry]| pair[0].octets[4] == da && pair[1].octets[4] == OWN;
        let exchange = requests.windows(3).rev().find(|three| begin(12)(three)).unwrap();
        assert_eq!(exchange[2].start - exchange[0].start, 198 + 11 * 4 + 12 + t_id1, "{baud}");
    }
}
