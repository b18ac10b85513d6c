//! Changes to the list of slaves during operation, and the parameters of each slave: interval, groups, watchdog, min
//! T_SDR. profibus-wire 2.4 and 3.10.
#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic, reason = "helpers of tests are tests")]

use crate::support;

use profivac_dp::link::active::Active;
use profivac_dp::link::{Baud, BitTime};
use profivac_dp::master::{
    EventKind, ExchangeError, HandlerState, Master, Mode, Settings, SlaveListError, SlaveParameters,
};
use profivac_wire::global::ControlCommand;
use support::bus;
use support::line::{Entry, From, Line};
use support::plain::Plain;

const IDENT: u16 = 0x1234;
/// Two octets in, two octets out.
const CFG: [u8; 2] = [0x11, 0x21];

type Bus = Line<Master<8, 32>>;

fn settings() -> Settings {
    Settings { control_cycles: 0, ..Settings::new(Baud::B1500000) }
}

fn slave(address: u8) -> SlaveParameters<'static> {
    SlaveParameters::new(address, IDENT, &CFG)
}

fn line(slaves: &[SlaveParameters<'_>]) -> Bus {
    let mut master: Active<Master<8, 32>> = Master::on(bus().check().unwrap(), settings(), BitTime(0));
    for slave in slaves {
        master.user.add(slave).unwrap();
    }
    master.user.set_mode(Mode::Operate);
    let mut line = Line::new(master);
    for slave in slaves {
        let mut device = Plain::new(IDENT, slave.cfg);
        device.inputs.fill(slave.address);
        line.attach(device, slave.address);
    }
    all_exchange(&mut line);
    line.run_for(2_000);
    while line.master.user.next_event().is_some() {}
    line
}

fn all_exchange(line: &mut Bus) {
    line.run_until(300_000, |line| {
        line.master.user.addresses().all(|address| line.master.user.inputs(address).is_some())
    });
}

/// The requests of the cycle to one slave.
fn to(line: &Bus, first: usize, address: u8) -> Vec<Entry> {
    let of_master = line.trace[first..].iter().filter(|entry| entry.from == From::Master);
    of_master
        .filter(|entry| match entry.octets[..] {
            [0x10, da, ..] | [0x68, _, _, _, da, ..] => da & 0x7F == address,
            _ => false,
        })
        .cloned()
        .collect()
}

/// The longest time between the start of two requests to a slave.
fn longest_gap(line: &Bus, first: usize, address: u8) -> u64 {
    to(line, first, address).windows(2).map(|pair| pair[1].start - pair[0].start).max().unwrap()
}

#[test]
fn a_removed_slave_is_unlocked_and_its_place_is_free_while_the_others_exchange() {
    let addresses = [3, 4, 5, 6, 7, 8, 9, 10];
    for (gone, delay) in addresses.into_iter().zip((0..).step_by(331)) {
        let mut line = line(&addresses.map(slave));
        line.run_for(delay);
        // The request is from the cycle before.
        let first = line.trace.len() - 40;
        let index = addresses.iter().position(|address| *address == gone).unwrap();
        assert!(line.master.user.remove(gone));
        line.run_until(20_000, |line| line.master.user.state(gone).is_none());
        assert_eq!(line.slaves[index].state().owner(), None, "unlocked");
        let reported: Vec<_> = std::iter::from_fn(|| line.master.user.next_event()).map(|event| event.kind).collect();
        assert_eq!(reported, [EventKind::Entered(HandlerState::Release), EventKind::Entered(HandlerState::Inactive)]);
        line.run_for(20_000);
        let others: Vec<_> = addresses.into_iter().filter(|address| *address != gone).collect();
        assert_eq!(line.master.user.addresses().collect::<Vec<_>>(), others);
        assert_eq!(line.master.user.exchanging(), 7);
        for address in others {
            assert_eq!(line.master.user.inputs(address), Some(&[address; 2][..]));
            // Eight exchanges of 290 bit times and a token, or the unlocking instead of one.
            let gap = longest_gap(&line, first, address);
            assert!(gap < 3_000, "{gap} without {gone} at {address}");
        }
        // One more slave can be added, at the end.
        line.attach(Plain::new(IDENT, &CFG), 20);
        line.master.user.add(&slave(20)).unwrap();
        all_exchange(&mut line);
        assert_eq!(line.master.user.addresses().last(), Some(20));
        assert_eq!(line.master.user.inputs(gone), None);
        assert!(line.master.user.outputs_mut(gone).is_none());
    }
}

#[test]
fn a_slave_that_does_not_answer_is_removed_at_once() {
    let mut line = line(&[slave(3), slave(4)]);
    line.master.user.add(&slave(50)).unwrap();
    line.run_for(5_000);
    assert!(line.master.user.remove(50));
    assert_eq!(line.master.user.state(50), None);
    assert!(!line.master.user.remove(50), "it is gone");
    // A silent slave is removed after the miss limit, although the master cannot unlock it.
    line.telegram_fault =
        Some(Box::new(|from, octets| if from == From::Slave(0) { Vec::new() } else { octets.to_vec() }));
    assert!(line.master.user.remove(3));
    line.run_until(20_000, |line| line.master.user.state(3).is_none());
    // In Stop nothing is sent.
    line.master.user.set_mode(Mode::Stop);
    line.run_for(5_000);
    assert!(line.master.user.remove(4));
    let last = std::iter::from_fn(|| line.master.user.next_event()).last().map(|event| (event.address, event.kind));
    assert_eq!(last, Some((4, EventKind::Entered(HandlerState::Inactive))));
    assert_eq!((line.master.user.addresses().count(), line.master.user.exchanging()), (0, 0));
}

#[test]
fn the_answer_of_a_slave_removed_in_between_is_dropped() {
    let mut line = line(&[slave(3), slave(4), slave(5)]);
    // Slave 4 is being asked; in Stop it is removed at once, and 5 takes its place.
    line.run_until(5_000, |line| {
        line.trace.last().is_some_and(|entry| entry.from == From::Master && entry.octets.get(4) == Some(&4))
    });
    line.master.user.set_mode(Mode::Stop);
    line.master.user.remove(4);
    line.master.user.set_mode(Mode::Operate);
    let end = line.now + 5_000;
    line.run_until(10_000, |line| {
        assert_eq!(line.master.user.inputs(3), Some(&[3, 3][..]));
        assert_eq!(line.master.user.inputs(5), Some(&[5, 5][..]));
        line.now > end
    });
}

#[test]
fn new_parameters_reach_one_slave_while_the_others_exchange() {
    let mut line = line(&[slave(3), slave(4), slave(5)]);
    line.master.user.outputs_mut(4).unwrap().copy_from_slice(&[8, 8]);
    line.run_for(3_000);
    let first = line.trace.len();
    let other =
        SlaveParameters { user_prm: &[1, 2, 3], watchdog: Some([2, 50]), min_tsdr: 60, group: 0x10, ..slave(4) };
    assert_eq!(line.master.user.reparameterise(&other), Ok(()));
    assert_eq!(line.master.user.inputs(4), None, "until it exchanges again");
    all_exchange(&mut line);
    line.run_for(5_000);
    assert_eq!(line.slaves[1].device().user_prm, [1, 2, 3]);
    assert_eq!(line.slaves[1].device().outputs, Some(vec![8, 8]));
    let prm = to(&line, first, 4).into_iter().find(|entry| entry.octets[7] == 0x3D).unwrap().octets;
    assert_eq!(prm[9..19], [0x88, 2, 50, 60, 0x12, 0x34, 0x10, 1, 2, 3]);
    // This slave uses the new min T_SDR; the others keep theirs.
    for (index, least) in [(0, 11), (1, 60), (2, 11)] {
        let answers = line.trace[line.trace.len() - 20..].windows(2).filter(|pair| pair[1].from == From::Slave(index));
        let sdr: Vec<_> = answers.map(|pair| pair[1].start - pair[0].end).collect();
        assert!(sdr.len() > 1 && sdr.iter().all(|sdr| *sdr == least), "T_SDR of {index}: {sdr:?}");
    }
    for address in [3, 5] {
        let counters = line.master.user.counters(address).unwrap();
        assert_eq!((counters.starts, counters.lost, counters.repetitions), (1, 0, 0));
        let gap = longest_gap(&line, first, address);
        assert!(gap < 1_500, "{gap}");
    }
    assert_eq!(line.master.user.counters(4).unwrap().starts, 2);
    let reported: Vec<_> =
        std::iter::from_fn(|| line.master.user.next_event()).filter(|event| event.address != 4).collect();
    assert_eq!(reported, []);
}

#[test]
fn invalid_parameters_change_nothing() {
    let mut line = line(&[slave(3)]);
    assert_eq!(line.master.user.reparameterise(&slave(9)), Err(SlaveListError::Unknown(9)));
    assert_eq!(SlaveListError::Unknown(9).to_string(), "there is no slave with the address 9");
    assert_eq!(line.master.user.set_group(9, 1), Err(SlaveListError::Unknown(9)));
    let impossible = SlaveParameters { watchdog: Some([0, 1]), ..slave(3) };
    assert_eq!(line.master.user.reparameterise(&impossible), Err(SlaveListError::Watchdog));
    line.run_for(5_000);
    assert_eq!((line.master.user.counters(3).unwrap().starts, line.master.user.exchanging()), (1, 1));
}

#[test]
fn another_configuration_changes_the_images() {
    let mut line = line(&[slave(3), slave(4)]);
    line.slaves[1].device_mut().cfg = vec![0x10, 0x20];
    line.slaves[1].device_mut().inputs = vec![9];
    line.master.user.outputs_mut(4).unwrap().copy_from_slice(&[8, 8]);
    line.master.user.reparameterise(&SlaveParameters { cfg: &[0x10, 0x20], ..slave(4) }).unwrap();
    all_exchange(&mut line);
    assert_eq!(line.master.user.inputs(4), Some(&[9][..]));
    assert_eq!(
        line.master.user.outputs_mut(4).unwrap(),
        [0],
        "the old outputs have no meaning in the new configuration"
    );
}

#[test]
fn set_group_moves_a_slave_to_another_group() {
    let mut line = line(&[SlaveParameters { group: 1, freeze: true, ..slave(3) }, slave(4)]);
    let freeze = |line: &mut Bus, group, value| {
        line.master.user.control(ControlCommand::FREEZE, group).unwrap();
        line.run_for(4_000);
        line.slaves[0].device_mut().inputs = vec![value, value];
        line.run_for(4_000);
        line.master.user.inputs(3).unwrap()[0]
    };
    assert_eq!(freeze(&mut line, 2, 20), 20, "it is in group 1");
    line.master.user.set_group(3, 2).unwrap();
    all_exchange(&mut line);
    assert_eq!(freeze(&mut line, 1, 30), 30, "no more");
    assert_eq!(freeze(&mut line, 2, 40), 30, "frozen");
    assert_eq!(line.master.user.counters(4).unwrap().starts, 1);
}

#[test]
fn a_slave_is_not_asked_before_its_interval_and_the_others_do_not_wait_for_it() {
    let interval = Baud::B1500000.tbit_of_us(600 * 10);
    let slow = SlaveParameters { min_interval_tbit: interval, ..slave(4) };
    let mut line = line(&[slave(3), slow, slave(5)]);
    // For all requests: bring-up, exchange, diagnosis, parameters, an unanswered request.
    line.run_for(100_000);
    line.slaves[1].device_mut().diagnose(&[0x02, 0x01]);
    line.run_for(50_000);
    line.master.user.set_group(4, 1).unwrap();
    line.run_for(100_000);
    line.master.user.restart(4);
    line.run_for(200_000);
    let starts: Vec<_> = to(&line, 0, 4).iter().map(|entry| entry.start).collect();
    assert!(starts.len() > 40, "{}", starts.len());
    let gaps: Vec<_> = starts.windows(2).map(|pair| pair[1] - pair[0]).collect();
    assert_eq!(gaps.iter().filter(|gap| **gap < interval).count(), 0, "{gaps:?}");
    // It is asked as soon as it may be, with a cycle of the others in between at most.
    assert!(gaps.iter().filter(|gap| **gap < interval + 1_500).count() > gaps.len() / 2, "{gaps:?}");
    assert!(line.master.user.counters(3).unwrap().exchanges > 400);
}

#[test]
fn a_slave_with_a_watchdog_leaves_data_exchange_when_its_master_is_absent() {
    // Watchdogs of 20 ms and 40 ms, and a slave without one.
    let watchdogs = [Some([1, 2]), Some([2, 2]), None];
    let slaves: Vec<_> =
        (3..).zip(watchdogs).map(|(address, watchdog)| SlaveParameters { watchdog, ..slave(address) }).collect();
    let mut line = line(&slaves);
    line.telegram_fault = Some(Box::new(|_, _| Vec::new()));
    let owned = |line: &Bus| -> Vec<bool> { line.slaves.iter().map(|slave| slave.state().owner().is_some()).collect() };
    for (ms, expected) in [(19, [true, true, true]), (11, [false, true, true]), (20, [false, false, true])] {
        line.run_for(Baud::B1500000.tbit_of_ms(ms));
        assert_eq!(owned(&line), expected, "after {ms} ms more");
    }
}

#[test]
fn new_parameters_clear_the_error_and_the_pause() {
    let mut line = line(&[slave(3)]);
    line.slaves[0].device_mut().accepts_prm = false;
    line.master.user.restart(3);
    line.run_until(2_000_000, |line| line.master.user.exchange_error(3) == Some(ExchangeError::PrmFault));
    line.run_for(1_000_000);
    line.slaves[0].device_mut().accepts_prm = true;
    line.master.user.reparameterise(&slave(3)).unwrap();
    assert_eq!(line.master.user.exchange_error(3), None);
    // The restart follows at once, not after a pause of 250 ms.
    line.run_until(10_000, |line| line.master.user.inputs(3).is_some());
}
