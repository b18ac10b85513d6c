//! Hostile and broken stations in a ring.

use super::line::{BAUD, Bounds, Line, TOKEN_RULES, parameters};
use crate::common::{CFG, IDENT, Plain};
use profivac_dp::link::{BitTime, Station, Transmit};
use profivac_dp::master::{Master, Mode, Settings, SlaveParameters};
use profivac_dp::slave::Slave;
use profivac_sim::{Fault, Random, Segment};
use profivac_wire::control::{Control, StationType, Status};
use profivac_wire::{DataTelegram, MAX_TELEGRAM, Telegram};

/// A station that reports itself as a master ready for the ring and never uses the token.
struct FalseMaster {
    address: u8,
    station: StationType,
    asked: u32,
    octets: [u8; MAX_TELEGRAM],
}

impl Station for FalseMaster {
    fn telegram(&mut self, end: BitTime, telegram: &Telegram<'_>) -> Option<Transmit<'_>> {
        let Telegram::Data(data) = telegram else { return None };
        if data.da != self.address {
            return None;
        }
        self.asked += 1;
        let control = Control::Response { station: self.station, status: Status::Ok };
        let answer = Telegram::Data(DataTelegram::short(data.sa, self.address, control));
        let length = answer.emit(&mut self.octets).ok()?;
        Some(Transmit { not_before: end + 11, octets: self.octets.get(..length)? })
    }

    fn activity(&mut self, _end: BitTime) {}

    fn sent(&mut self, _end: BitTime) {}

    fn poll(&mut self, _now: BitTime) -> Option<Transmit<'_>> {
        None
    }

    fn wake_at(&self) -> Option<BitTime> {
        None
    }
}

/// The false master costs three tokens with T_SL each, once per scan of the GAP and not at every token visit.
#[test]
fn a_station_that_only_claims_to_be_a_master_costs_little_time() {
    for station in [StationType::MasterReady, StationType::MasterInRing] {
        for address in [3, 5, 12] {
            let mut line = Line::complete(&[2, 9]);
            let false_master =
                line.segment.attach(FalseMaster { address, station, asked: 0, octets: [0; MAX_TELEGRAM] });
            TOKEN_RULES.into_iter().for_each(|rule| line.segment.allow(rule));
            let before = line.answers(&[2, 9]);
            let begin = line.segment.now();
            line.segment.run_for(300_000).unwrap();
            let asked = u64::from(line.segment.station(false_master).asked);
            // Between two scans there is at least the pause G x T_TR.
            assert!((3..=300_000 / 5_000 + 1).contains(&asked), "{address}: asked {asked} times");
            let after = line.answers(&[2, 9]);
            let spent = line.segment.now() - begin - asked * 3 * (33 + 300);
            for (before, after) in before.iter().zip(&after) {
                assert!(u64::from(after - before) > spent / Bounds::of(&[2, 9]).rotation(), "{before} {after}");
            }
            let lost: u32 = [2, 9].iter().map(|master| line.master(*master).ring_counters().lost_successors).sum();
            assert!(u64::from(lost).abs_diff(asked) <= 1, "{lost} of {asked}");
        }
    }
}

type Class1 = Master<8, 8>;

/// Slaves of two masters lose power and regain it every few exchanges; afterwards all exchange data.
#[test]
fn counters_stay_consistent_when_slaves_lose_and_regain_power() {
    for seed in 0..6 {
        let mut random = Random::new(seed);
        let mut segment = Segment::new(BAUD);
        let addresses: [[u8; 4]; 2] = [[30, 31, 32, 33], [40, 41, 42, 43]];
        let slaves: Vec<_> = addresses
            .iter()
            .flatten()
            .map(|address| segment.attach(Slave::new(Plain::new(), *address, BAUD)))
            .collect();
        let masters = [(2, addresses[0]), (5, addresses[1])].map(|(address, slaves)| {
            let mut master = Class1::on(parameters(address).check().unwrap(), Settings::new(BAUD), BitTime(0));
            for slave in slaves {
                master.user.add(&SlaveParameters::new(slave, IDENT, &CFG)).unwrap();
            }
            master.user.set_mode(Mode::Operate);
            segment.attach(master)
        });
        // A slave that loses power during an answer leaves an incomplete telegram.
        TOKEN_RULES.into_iter().for_each(|rule| segment.allow(rule));
        for _ in 0..1_000 {
            let slave = slaves[random.below(8) as usize];
            let on = random.below(3) > 0;
            if on {
                let address = segment.station(slave).address();
                segment.station_mut(slave).power_up(address);
            }
            segment.inject(Fault::Power(slave.id(), on));
            segment.run_for(random.below(3_000)).unwrap();
            for (master, addresses) in masters.iter().zip(addresses) {
                let master = &mut segment.station_mut(*master).user;
                let with_inputs = addresses.iter().filter(|slave| master.exchanged_at(**slave).is_some()).count();
                assert!(with_inputs <= master.exchanging() && master.exchanging() <= 4, "seed {seed}");
                while master.next_event().is_some() {}
                assert!(!master.take_overflow(), "seed {seed}");
            }
        }
        slaves.iter().for_each(|slave| segment.inject(Fault::Power(slave.id(), true)));
        segment.run_for(BAUD.tbit_of_ms(1_500)).unwrap();
        for master in masters {
            assert_eq!(segment.station(master).user.exchanging(), 4, "seed {seed}");
        }
    }
}
