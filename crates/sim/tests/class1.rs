//! A class 1 master and its groups, checked by the referee: modes, Sync and Freeze, slaves that are added and removed.

#![allow(clippy::unwrap_used, clippy::panic, reason = "a test")]

use crate::common;

use common::{CFG, IDENT, OWN, Plain};
use profivac_dp::link::active::{Active, BusParameters};
use profivac_dp::link::{Baud, BitTime};
use profivac_dp::master::{Master, Mode, Settings, SlaveParameters};
use profivac_dp::slave::Slave;
use profivac_sim::{Segment, StationHandle};
use profivac_wire::global::ControlCommand;

type Class1 = Active<Master<4, 8>>;

/// The addresses, and the group of each.
const SLAVES: [(u8, u8); 4] = [(10, 1), (11, 1), (12, 2), (13, 0)];

fn parameters(address: u8, group: u8) -> SlaveParameters<'static> {
    SlaveParameters { group, sync: true, freeze: true, ..SlaveParameters::new(address, IDENT, &CFG) }
}

/// A master and slaves at different positions of the cable, all slaves in data exchange.
fn exchanging(baud: Baud) -> (Segment, StationHandle<Class1>, [StationHandle<Slave<Plain>>; 4]) {
    let mut segment = Segment::new(baud);
    let mut master =
        Master::<4, 8>::on(BusParameters::new(OWN, baud).check().unwrap(), Settings::new(baud), BitTime(0));
    for (address, group) in SLAVES {
        master.user.add(&parameters(address, group)).unwrap();
    }
    master.user.set_mode(Mode::Operate);
    let slaves =
        SLAVES.map(|(address, _)| segment.attach_at(u64::from(address) - 10, Slave::new(Plain::new(), address, baud)));
    let master = segment.attach(master);
    segment.run_for(baud.tbit_of_ms(500).max(50_000)).unwrap();
    assert_eq!(segment.station(master).user.exchanging(), 4);
    (segment, master, slaves)
}

fn put(segment: &mut Segment, master: StationHandle<Class1>, outputs: [u8; 2]) {
    for (address, _) in SLAVES {
        segment.station_mut(master).user.outputs_mut(address).unwrap().copy_from_slice(&outputs);
    }
}

/// The present outputs of each slave.
fn outputs(segment: &Segment, slaves: &[StationHandle<Slave<Plain>>; 4]) -> [Option<Vec<u8>>; 4] {
    slaves.map(|slave| segment.station(slave).device().outputs.last().cloned().flatten())
}

/// Long enough for a few cycles at any rate.
const WHILE: u64 = 20_000;

#[test]
fn modes_groups_sync_and_freeze_at_three_rates() {
    for baud in [Baud::B19200, Baud::B1500000, Baud::B12000000] {
        let (mut segment, master, slaves) = exchanging(baud);
        let data = |value: u8| Some(vec![value, value]);
        put(&mut segment, master, [5, 5]);
        segment.station_mut(master).user.control(ControlCommand::SYNC, 1).unwrap();
        segment.run_for(WHILE).unwrap();
        put(&mut segment, master, [6, 6]);
        segment.run_for(WHILE).unwrap();
        assert_eq!(outputs(&segment, &slaves), [data(5), data(5), data(6), data(6)], "{baud}: group 1 holds");
        segment.station_mut(master).user.control(ControlCommand::UNSYNC, 0).unwrap();
        segment.run_for(WHILE).unwrap();
        assert_eq!(outputs(&segment, &slaves), [data(6), data(6), data(6), data(6)]);

        // The first input counts the samples of the inputs: only that of the frozen slave does not change.
        segment.station_mut(master).user.control(ControlCommand::FREEZE, 2).unwrap();
        segment.run_for(WHILE).unwrap();
        let image = |segment: &Segment, address| segment.station(master).user.inputs(address).unwrap()[0];
        let before = [10, 12].map(|address| image(&segment, address));
        // The number of cycles is not a multiple of 256 for any cycle time.
        let exchanges = |segment: &Segment| segment.station(master).user.counters(10).unwrap().exchanges;
        let begin = exchanges(&segment);
        while exchanges(&segment) < begin + 7 {
            segment.run_for(100).unwrap();
        }
        assert_ne!(image(&segment, 10), before[0], "{baud}");
        assert_eq!(image(&segment, 12), before[1], "{baud}: frozen");

        segment.station_mut(master).user.set_cleared_groups(2);
        segment.run_for(WHILE).unwrap();
        assert_eq!(outputs(&segment, &slaves), [data(6), data(6), data(0), data(6)], "{baud}: group 2 in Clear");
        segment.station_mut(master).user.set_mode(Mode::Stop);
        // Before the watchdogs switch the outputs to the safe state on a slow line.
        segment.run_for(WHILE / 2).unwrap();
        assert_eq!(outputs(&segment, &slaves), [data(0), data(0), data(0), data(0)], "{baud}: stopped");
    }
}

#[test]
fn slaves_are_added_and_removed_without_a_violation() {
    let (mut segment, master, _slaves) = exchanging(Baud::B12000000);
    for round in 0..200u64 {
        let (address, group) = SLAVES[(round % 4) as usize];
        // At every position of a cycle.
        segment.run_for(37 * round).unwrap();
        let user = &mut segment.station_mut(master).user;
        match round % 7 {
            0 | 1 => user
                .reparameterise(&SlaveParameters { min_tsdr: 11 + round as u8 % 90, ..parameters(address, group) })
                .unwrap(),
            2 => user.set_group(address, group ^ 4).unwrap(),
            3 => user.set_mode(Mode::Stop),
            4 => user.set_mode(Mode::Operate),
            5 => assert!(user.remove(address)),
            _ => user.control(ControlCommand::SYNC | ControlCommand::FREEZE, group).unwrap(),
        }
        segment.run_for(10_000).unwrap();
        if round % 7 == 5 {
            let user = &mut segment.station_mut(master).user;
            assert_eq!(user.state(address), None, "removed");
            user.add(&parameters(address, group)).unwrap();
            segment.run_for(1_000_000).unwrap();
            assert_eq!(segment.station(master).user.exchanging(), 4);
        }
    }
    for (address, _) in SLAVES {
        assert_eq!(segment.station(master).user.counters(address).unwrap().lost, 0);
    }
}
