//! A class 1 master and its groups on a cable, under the referee: modes, Sync and Freeze, slaves that come and go.

#![allow(clippy::unwrap_used, clippy::panic, reason = "a test")]

mod common;

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

/// One after the other along the cable, all of them in data exchange.
fn exchanging(baud: Baud) -> (Segment, StationHandle<Class1>, [StationHandle<Slave<Plain>>; 4]) {
    let mut bus = Segment::new(baud);
    let mut master = Master::<4, 8>::on(BusParameters::new(OWN, baud), Settings::new(baud), BitTime(0));
    for (address, group) in SLAVES {
        master.user.add(&parameters(address, group)).unwrap();
    }
    master.user.set_mode(Mode::Operate);
    let slaves =
        SLAVES.map(|(address, _)| bus.attach_at(u64::from(address) - 10, Slave::new(Plain::new(), address, baud)));
    let master = bus.attach(master);
    bus.run_for(baud.tbit_of_ms(500).max(50_000)).unwrap();
    assert_eq!(bus.station(master).user.exchanging(), 4);
    (bus, master, slaves)
}

fn put(bus: &mut Segment, master: StationHandle<Class1>, outputs: [u8; 2]) {
    for (address, _) in SLAVES {
        bus.station_mut(master).user.outputs_mut(address).unwrap().copy_from_slice(&outputs);
    }
}

/// What each process has now.
fn outputs(bus: &Segment, slaves: &[StationHandle<Slave<Plain>>; 4]) -> [Option<Vec<u8>>; 4] {
    slaves.map(|slave| bus.station(slave).device().outputs.last().cloned().flatten())
}

/// Long enough for a few cycles at any rate.
const WHILE: u64 = 20_000;

#[test]
fn modes_groups_sync_and_freeze_at_three_rates() {
    for baud in [Baud::B19200, Baud::B1500000, Baud::B12000000] {
        let (mut bus, master, slaves) = exchanging(baud);
        let data = |value: u8| Some(vec![value, value]);
        put(&mut bus, master, [5, 5]);
        bus.station_mut(master).user.control(ControlCommand::SYNC, 1).unwrap();
        bus.run_for(WHILE).unwrap();
        put(&mut bus, master, [6, 6]);
        bus.run_for(WHILE).unwrap();
        assert_eq!(outputs(&bus, &slaves), [data(5), data(5), data(6), data(6)], "{baud}: group 1 holds");
        bus.station_mut(master).user.control(ControlCommand::UNSYNC, 0).unwrap();
        bus.run_for(WHILE).unwrap();
        assert_eq!(outputs(&bus, &slaves), [data(6), data(6), data(6), data(6)]);

        // The first input counts how often inputs were sampled: only the frozen one stands still.
        bus.station_mut(master).user.control(ControlCommand::FREEZE, 2).unwrap();
        bus.run_for(WHILE).unwrap();
        let image = |bus: &Segment, address| bus.station(master).user.inputs(address).unwrap()[0];
        let before = [10, 12].map(|address| image(&bus, address));
        // A number of cycles that is not a multiple of 256 whatever they last.
        let exchanges = |bus: &Segment| bus.station(master).user.counters(10).unwrap().exchanges;
        let begin = exchanges(&bus);
        while exchanges(&bus) < begin + 7 {
            bus.run_for(100).unwrap();
        }
        assert_ne!(image(&bus, 10), before[0], "{baud}");
        assert_eq!(image(&bus, 12), before[1], "{baud}: frozen");

        bus.station_mut(master).user.set_cleared_groups(2);
        bus.run_for(WHILE).unwrap();
        assert_eq!(outputs(&bus, &slaves), [data(6), data(6), data(0), data(6)], "{baud}: group 2 in Clear");
        bus.station_mut(master).user.set_mode(Mode::Stop);
        // Before the watchdogs of a slow line take them to the safe state.
        bus.run_for(WHILE / 2).unwrap();
        assert_eq!(outputs(&bus, &slaves), [data(0), data(0), data(0), data(0)], "{baud}: stopped");
    }
}

#[test]
fn slaves_come_and_go_under_the_referee() {
    let (mut bus, master, _slaves) = exchanging(Baud::B12000000);
    for round in 0..200u64 {
        let (address, group) = SLAVES[(round % 4) as usize];
        // At every place of a cycle.
        bus.run_for(37 * round).unwrap();
        let user = &mut bus.station_mut(master).user;
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
        bus.run_for(10_000).unwrap();
        if round % 7 == 5 {
            let user = &mut bus.station_mut(master).user;
            assert_eq!(user.state(address), None, "removed");
            user.add(&parameters(address, group)).unwrap();
            bus.run_for(1_000_000).unwrap();
            assert_eq!(bus.station(master).user.exchanging(), 4);
        }
    }
    for (address, _) in SLAVES {
        assert_eq!(bus.station(master).user.counters(address).unwrap().lost, 0);
    }
}
