//! Commands of a program to a master, in any order and at any time, on a line with faults: the list of slaves, the
//! images and the counters stay consistent.
#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic, reason = "helpers of tests are tests")]

use crate::support;

use profivac_dp::link::{Baud, BitTime};
use profivac_dp::master::{HandlerState, Master, Mode, Settings, SlaveParameters, services};
use profivac_wire::global::ControlCommand;
use std::collections::BTreeSet;
use support::line::{From, Line};
use support::plain::Plain;
use support::{Random, bus};

const IDENT: u16 = 0x1234;
/// Two octets in, two octets out.
const CFG: [u8; 2] = [0x11, 0x21];
/// Slaves on the line; the last address has none.
const ADDRESSES: [u8; 6] = [3, 4, 5, 9, 77, 50];

type Bus = Line<Master<5, 32>>;

fn random_call(line: &mut Bus, random: &mut Random) {
    let address = ADDRESSES[random.below(ADDRESSES.len())];
    let interval = [0, 0, 0, 4_000][random.below(4)];
    let parameters = SlaveParameters {
        group: random.below(256) as u8,
        min_interval_tbit: interval,
        sync: true,
        freeze: true,
        ..SlaveParameters::new(address, IDENT, &CFG)
    };
    let master = &mut line.master.user;
    let known = master.state(address).is_some();
    let room = master.addresses().count() < 5;
    match random.below(12) {
        0..=2 => assert_eq!(master.add(&parameters).is_ok(), !known && room),
        3 => assert_eq!(master.remove(address), known),
        4 => assert_eq!(master.reparameterise(&parameters).is_ok(), known),
        5 => assert_eq!(master.set_group(address, parameters.group).is_ok(), known),
        6 => master.release(address),
        7 => master.restart(address),
        8 => master.set_mode([Mode::Operate, Mode::Operate, Mode::Clear, Mode::Stop][random.below(4)]),
        9 => master.set_cleared_groups(random.below(256) as u8),
        10 => {
            let _ = master.control(ControlCommand::from_bits_retain(random.below(256) as u8), parameters.group);
        }
        _ => {
            let _ = master.submit_request(&services::slave_diag(address));
            let _ = master.take_confirmation();
        }
    }
    if random.below(20) == 0 {
        let index = random.below(line.slaves.len());
        line.slaves[index].power_up(ADDRESSES[index]);
    }
}

/// The invariants.
fn check(line: &Bus) {
    let master = &line.master.user;
    let addresses: Vec<u8> = master.addresses().collect();
    assert_eq!(addresses.iter().collect::<BTreeSet<_>>().len(), addresses.len(), "{addresses:?}");
    let exchanging =
        addresses.iter().filter(|address| matches!(master.state(**address), Some(HandlerState::Data { .. })));
    assert_eq!(exchanging.count(), master.exchanging());
    for address in ADDRESSES {
        assert_eq!(addresses.contains(&address), master.state(address).is_some());
        assert!(master.inputs(address).is_none_or(|inputs| inputs == [1, address]), "{address}");
    }
}

#[test]
fn commands_in_any_order_and_at_any_time_leave_counts_and_images_consistent() {
    let mut random = Random::new(0x0DD5_0DD5);
    let settings = Settings { control_cycles: 10, ..Settings::new(Baud::B1500000) };
    let mut line = Line::new(Master::on(bus().check().unwrap(), settings, BitTime(0)));
    for address in &ADDRESSES[..5] {
        let mut device = Plain::new(IDENT, &CFG);
        device.inputs = vec![1, *address];
        line.attach(device, *address);
    }
    let mut noise = Random::new(0x0DD5_0DD6);
    line.telegram_fault = Some(Box::new(move |from, octets| match (from, noise.below(40)) {
        (From::Slave(_), 0) => Vec::new(),
        _ => octets.to_vec(),
    }));
    let mut seen = [0; 6];
    for _ in 0..20_000 {
        random_call(&mut line, &mut random);
        let end = line.now + random.below(3_000) as u64;
        line.run_until(10_000, |line| {
            check(line);
            line.now >= end
        });
        while line.master.user.next_event().is_some() {}
        seen[line.master.user.exchanging()] += 1;
    }
    assert!(seen[..4].iter().all(|times| *times > 500), "how often each number of slaves exchanges data: {seen:?}");
    // Without further commands all present slaves exchange data, and no others.
    line.telegram_fault = None;
    line.master.user.set_mode(Mode::Operate);
    for address in ADDRESSES {
        line.master.user.restart(address);
    }
    let there = line.master.user.addresses().filter(|address| *address != 50).count();
    line.run_until(2_000_000, |line| line.master.user.exchanging() == there);
    line.run_for(5_000);
    check(&line);
}
