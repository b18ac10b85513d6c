//! Modes, groups, Sync and Freeze: commands of a master to many slaves at once, and their effect. profibus-wire 2.9,
//! 3.8 and 3.10.
#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic, reason = "helpers of tests are tests")]

use crate::support;

use profivac_dp::link::active::{Active, Failure};
use profivac_dp::link::{Baud, BitTime};
use profivac_dp::master::{
    ControlError, EventKind, ExchangeError, HandlerState, MAX_PENDING_COMMANDS, Master, Mode, Settings, SlaveParameters,
};
use profivac_wire::diag::StationStatus;
use profivac_wire::global::ControlCommand;
use support::bus;
use support::line::{From, Line};
use support::plain::Plain;

const IDENT: u16 = 0x1234;
/// Two octets in, two octets out.
const CFG: [u8; 2] = [0x11, 0x21];

const OPERATE: &str = "68 07 07 68 FF 82 46 3A 3E 00 00 3F 16";
const CLEAR: &str = "68 07 07 68 FF 82 46 3A 3E 02 00 41 16";
/// The configurations that profibus-wire 2.9 prints.
const SYNC_1: &str = "68 07 07 68 FF 82 46 3A 3E 20 01 60 16";
const FREEZE_1: &str = "68 07 07 68 FF 82 46 3A 3E 08 01 48 16";

type Bus = Line<Master<8, 32>>;

fn settings() -> Settings {
    // Global_Control only when something changes.
    Settings { control_cycles: 0, ..Settings::new(Baud::B1500000) }
}

/// A slave in some groups.
fn slave(address: u8, group: u8) -> SlaveParameters<'static> {
    SlaveParameters { group, sync: true, freeze: true, ..SlaveParameters::new(address, IDENT, &CFG) }
}

/// Master and slaves in data exchange, with inputs 01 ADDRESS.
fn line(settings: Settings, slaves: &[SlaveParameters<'_>]) -> Bus {
    let mut master: Active<Master<8, 32>> = Master::on(bus().check().unwrap(), settings, BitTime(0));
    for slave in slaves {
        master.user.add(slave).unwrap();
    }
    master.user.set_mode(Mode::Operate);
    let mut line = Line::new(master);
    for slave in slaves {
        let mut device = Plain::new(IDENT, &CFG);
        device.inputs = vec![1, slave.address];
        device.features.dpv1 = !slave.user_prm.is_empty();
        line.attach(device, slave.address);
    }
    line.run_until(300_000, |line| {
        line.master.user.addresses().all(|address| line.master.user.inputs(address).is_some())
    });
    line.run_for(2_000);
    while line.master.user.next_event().is_some() {}
    line
}

/// Puts the same outputs into the images of all slaves.
fn put(line: &mut Bus, outputs: [u8; 2]) {
    let addresses: Vec<_> = line.master.user.addresses().collect();
    for address in addresses {
        line.master.user.outputs_mut(address).unwrap().copy_from_slice(&outputs);
    }
}

/// The outputs of the processes behind the slaves.
fn outputs(line: &Bus) -> Vec<Option<Vec<u8>>> {
    line.slaves.iter().map(|slave| slave.device().outputs.clone()).collect()
}

fn all(outputs: [[u8; 2]; 3]) -> Vec<Option<Vec<u8>>> {
    outputs.iter().map(|octets| Some(octets.to_vec())).collect()
}

fn control(line: &mut Bus, command: ControlCommand, group: u8) {
    assert_eq!(line.master.user.control(command, group), Ok(()));
    line.run_until(20_000, |line| line.master.user.pending_commands() == 0);
    line.run_for(3_000);
}

#[test]
fn sync_holds_the_outputs_of_a_group_until_the_next_sync_and_ends_with_unsync() {
    let mut line = line(settings(), &[slave(3, 1), slave(4, 1), slave(5, 2)]);
    put(&mut line, [1, 1]);
    let first = line.trace.len();
    control(&mut line, ControlCommand::SYNC, 1);
    assert_eq!(line.messages(first).iter().filter(|text| *text == SYNC_1).count(), 1);
    // Sync applies the outputs set before the call.
    assert_eq!(outputs(&line), all([[1, 1], [1, 1], [1, 1]]));
    put(&mut line, [2, 2]);
    line.run_for(10_000);
    assert_eq!(outputs(&line), all([[1, 1], [1, 1], [2, 2]]), "group 2 is not affected");
    control(&mut line, ControlCommand::SYNC, 1);
    assert_eq!(outputs(&line), all([[2, 2], [2, 2], [2, 2]]));
    put(&mut line, [3, 3]);
    line.run_for(10_000);
    assert_eq!(outputs(&line), all([[2, 2], [2, 2], [3, 3]]), "still held");
    control(&mut line, ControlCommand::UNSYNC, 1);
    put(&mut line, [4, 4]);
    line.run_for(3_000);
    assert_eq!(outputs(&line), all([[4, 4], [4, 4], [4, 4]]));
}

/// The outputs of all slaves change when Sync is executed, neither an exchange earlier nor later.
#[test]
fn sync_waits_until_every_slave_of_the_group_has_the_outputs() {
    let mut line = line(settings(), &[slave(3, 1), slave(4, 1), slave(5, 1)]);
    control(&mut line, ControlCommand::SYNC, 1);
    for delay in 0..40 {
        // Sync is submitted at each position in the cycle.
        line.run_for(29);
        let held = outputs(&line);
        put(&mut line, [delay + 10, delay]);
        assert_eq!(line.master.user.control(ControlCommand::SYNC, 1), Ok(()));
        line.run_until(20_000, |line| outputs(line) != held);
        assert_eq!(outputs(&line), all([[delay + 10, delay]; 3]), "all at once, and all of them");
    }
}

#[test]
fn sync_waits_for_a_slave_that_is_not_asked_in_every_cycle() {
    let slow = SlaveParameters { min_interval_tbit: 5_000, ..slave(4, 1) };
    let mut line = line(settings(), &[slave(3, 1), slow, slave(5, 1)]);
    control(&mut line, ControlCommand::SYNC, 1);
    for value in 10..20 {
        line.run_for(1_777);
        let held = outputs(&line);
        put(&mut line, [value, value]);
        assert_eq!(line.master.user.control(ControlCommand::SYNC, 1), Ok(()));
        line.run_until(20_000, |line| outputs(line) != held);
        assert_eq!(outputs(&line), all([[value, value]; 3]));
    }
}

#[test]
fn freeze_keeps_the_inputs_of_a_group_until_the_next_freeze_and_ends_with_unfreeze() {
    let mut line = line(settings(), &[slave(3, 1), slave(4, 2)]);
    let change = |line: &mut Bus, value| line.slaves.iter_mut().for_each(|slave| slave.device_mut().inputs[0] = value);
    let seen = |line: &Bus| [3, 4].map(|address| line.master.user.inputs(address).unwrap()[0]);
    let first = line.trace.len();
    control(&mut line, ControlCommand::FREEZE, 1);
    assert_eq!(line.messages(first).iter().filter(|text| *text == FREEZE_1).count(), 1);
    change(&mut line, 7);
    line.run_for(5_000);
    assert_eq!(seen(&line), [1, 7]);
    control(&mut line, ControlCommand::FREEZE, 1);
    assert_eq!(seen(&line), [7, 7]);
    change(&mut line, 8);
    line.run_for(5_000);
    assert_eq!(seen(&line), [7, 8]);
    control(&mut line, ControlCommand::UNFREEZE, 0);
    assert_eq!(seen(&line), [8, 8]);
}

#[test]
fn the_diagnosis_reports_the_effect_of_a_command() {
    let mut line = line(settings(), &[slave(3, 1)]);
    control(&mut line, ControlCommand::SYNC | ControlCommand::FREEZE, 1);
    line.slaves[0].device_mut().diagnose(&[]);
    line.run_for(5_000);
    let status = line.master.user.diagnosis(3).unwrap().status;
    assert!(status.contains(StationStatus::SYNC_MODE | StationStatus::FREEZE_MODE), "{status:?}");
    control(&mut line, ControlCommand::UNSYNC | ControlCommand::UNFREEZE, 1);
    line.slaves[0].device_mut().diagnose(&[]);
    line.run_for(5_000);
    let status = line.master.user.diagnosis(3).unwrap().status;
    assert!(!status.intersects(StationStatus::SYNC_MODE | StationStatus::FREEZE_MODE), "{status:?}");
}

#[test]
fn commands_keep_their_order_and_their_number_is_limited() {
    let mut line = line(settings(), &[slave(3, 1)]);
    let first = line.trace.len();
    for group in 1..=8 {
        assert_eq!(line.master.user.control(ControlCommand::FREEZE, group), Ok(()));
    }
    assert_eq!((MAX_PENDING_COMMANDS, line.master.user.pending_commands()), (8, 8));
    assert_eq!(line.master.user.control(ControlCommand::FREEZE, 9), Err(ControlError::Full));
    line.run_for(20_000);
    let sent: Vec<_> = line.trace[first..]
        .iter()
        .filter(|entry| entry.octets.get(4) == Some(&0xFF))
        .map(|entry| entry.octets[10])
        .collect();
    assert_eq!(sent, [1, 2, 3, 4, 5, 6, 7, 8]);
}

#[test]
fn an_invalid_command_is_refused_with_a_text() {
    let mut line = line(settings(), &[slave(3, 1)]);
    let sentence = |line: &mut Bus, command| line.master.user.control(command, 0).unwrap_err().to_string();
    for (command, bits) in [
        (ControlCommand::CLEAR_DATA, "02"),
        (ControlCommand::empty(), "00"),
        (ControlCommand::RESERVED | ControlCommand::SYNC, "E1"),
    ] {
        let expected = format!("control command {bits} is not made of Sync, Unsync, Freeze and Unfreeze");
        assert_eq!(sentence(&mut line, command), expected);
    }
    line.master.user.set_mode(Mode::Stop);
    assert_eq!(line.master.user.control(ControlCommand::SYNC, 0), Err(ControlError::NoSlaveExchanging));
}

#[test]
fn commands_are_dropped_when_no_slave_exchanges_data() {
    let mut line = line(settings(), &[slave(3, 1)]);
    line.telegram_fault = Some(Box::new(|_, _| Vec::new()));
    assert_eq!(line.master.user.control(ControlCommand::SYNC, 1), Ok(()));
    line.run_until(100_000, |line| line.master.user.exchanging() == 0);
    line.telegram_fault = None;
    let first = line.trace.len();
    line.run_until(2_000_000, |line| line.master.user.inputs(3).is_some());
    line.run_for(5_000);
    assert_eq!(line.master.user.pending_commands(), 0);
    assert!(!line.messages(first).contains(&SYNC_1.to_string()));
}

#[test]
fn a_group_is_kept_in_clear_while_the_others_operate() {
    let mut line = line(Settings { control_cycles: 10, ..settings() }, &[slave(3, 1), slave(4, 2), slave(5, 6)]);
    put(&mut line, [9, 9]);
    line.run_for(3_000);
    line.master.user.set_cleared_groups(2);
    assert_eq!(line.master.user.cleared_groups(), 2);
    let first = line.trace.len();
    for _ in 0..30 {
        line.run_for(2_000);
        assert_eq!(outputs(&line), all([[9, 9], [0, 0], [0, 0]]));
    }
    // The master repeats Operate to all slaves and Clear to the group.
    let reported: Vec<_> = line.messages(first).into_iter().filter(|text| text.contains("FF 82 46 3A 3E")).collect();
    let clear_2 = "68 07 07 68 FF 82 46 3A 3E 02 02 43 16";
    assert!(reported.len() > 8, "{reported:?}");
    assert!(reported.chunks_exact(2).all(|pair| pair == [OPERATE, clear_2]), "{reported:?}");
    line.master.user.set_cleared_groups(0);
    line.run_for(3_000);
    assert_eq!(outputs(&line), all([[9, 9]; 3]));
}

#[test]
fn a_cleared_group_gets_the_empty_data_unit_where_the_slave_declares_fail_safe() {
    let fail_safe = SlaveParameters { fail_safe: true, ..slave(3, 1) };
    let mut line = line(settings(), &[fail_safe, slave(4, 1)]);
    put(&mut line, [9, 9]);
    line.run_for(3_000);
    let lengths = |line: &Bus, first: usize| -> Vec<(u8, u8)> {
        let of_master = line.trace[first..].iter().filter(|entry| entry.from == From::Master);
        of_master
            .filter_map(|entry| match entry.octets[..] {
                [0x10, da @ 3..=4, ..] => Some((da, 0)),
                [0x68, le, _, _, da @ 3..=4, ..] => Some((da, le - 3)),
                _ => None,
            })
            .collect()
    };
    let exchanges_in = |line: &mut Bus, change: &dyn Fn(&mut Bus)| {
        change(line);
        // The exchange in progress does not count.
        line.run_for(600);
        let first = line.trace.len();
        line.run_for(1_200);
        lengths(line, first)
    };
    let cleared = exchanges_in(&mut line, &|line| line.master.user.set_cleared_groups(1));
    assert!(cleared.contains(&(3, 0)) && cleared.contains(&(4, 2)) && !cleared.contains(&(3, 2)), "{cleared:?}");
}

/// profibus-wire 3.8: zeros; with Fail_Safe the empty data unit, which sets this slave's outputs to the safe state.
#[test]
fn clear_reaches_slaves_without_watchdog_with_zeros_or_with_nothing() {
    let unwatched = SlaveParameters { watchdog: None, ..slave(3, 0) };
    let fail_safe = SlaveParameters { fail_safe: true, user_prm: &[0xC0, 0, 0], ..slave(5, 0) };
    let mut line = line(settings(), &[unwatched, slave(4, 0), fail_safe]);
    put(&mut line, [7, 7]);
    line.run_for(3_000);
    assert_eq!(outputs(&line), all([[7, 7]; 3]));
    line.master.user.set_mode(Mode::Clear);
    line.run_for(3_000);
    assert_eq!(outputs(&line), [Some(vec![0, 0]), Some(vec![0, 0]), None]);
    assert_eq!(line.master.user.inputs(3), Some(&[1, 3][..]), "inputs are valid in Clear");
    line.master.user.set_mode(Mode::Operate);
    line.run_for(3_000);
    assert_eq!(outputs(&line), all([[7, 7]; 3]));
    for address in 3..6 {
        assert_eq!(line.master.user.counters(address).unwrap().starts, 1);
    }
}

#[test]
fn stop_goes_through_clear_so_that_no_slave_keeps_its_outputs() {
    let unwatched = SlaveParameters { watchdog: None, ..slave(3, 0) };
    for delay in 0..20 {
        let mut line = line(settings(), &[unwatched, slave(4, 0), slave(5, 0)]);
        put(&mut line, [7, 7]);
        line.run_for(3_000 + delay * 71);
        line.master.user.set_mode(Mode::Stop);
        assert_eq!((line.master.user.mode(), line.master.user.inputs(3)), (Mode::Stop, None));
        let first = line.trace.len();
        line.run_for(5_000);
        assert_eq!(outputs(&line), all([[0, 0]; 3]));
        let reported = line.messages(first);
        assert_eq!(reported.iter().filter(|text| *text == CLEAR).count(), 1, "{reported:?}");
        // After the request in progress: Clear and one exchange with each slave.
        assert!(reported.len() <= 1 + 2 * 3 + 2, "{reported:?}");
        // Then silence; afterwards no slave has to be restarted.
        let first = line.trace.len();
        line.run_for(50_000);
        assert_eq!(line.messages(first), Vec::<String>::new());
        line.master.user.set_mode(Mode::Operate);
        line.run_for(5_000);
        assert_eq!(outputs(&line), all([[7, 7]; 3]));
        assert_eq!(line.master.user.counters(3).unwrap().starts, 1);
    }
}

#[test]
fn a_master_stops_although_a_slave_does_not_answer() {
    let mut line = line(settings(), &[slave(3, 0), slave(4, 0)]);
    line.telegram_fault =
        Some(Box::new(|from, octets| if from == From::Slave(0) { Vec::new() } else { octets.to_vec() }));
    line.master.user.set_mode(Mode::Stop);
    line.run_for(20_000);
    let first = line.trace.len();
    line.run_for(50_000);
    assert_eq!(line.messages(first), Vec::<String>::new());
}

#[test]
fn a_stopping_master_starts_no_slave() {
    // A silent slave delays the shutdown; another powers up meanwhile and asks for parameters.
    let mut line = line(Settings { miss_limit: 10, ..settings() }, &[slave(3, 0), slave(4, 0)]);
    line.telegram_fault =
        Some(Box::new(|from, octets| if from == From::Slave(0) { Vec::new() } else { octets.to_vec() }));
    line.slaves[1].power_up(4);
    line.master.user.set_mode(Mode::Stop);
    line.run_for(50_000);
    assert_eq!(line.slaves[1].state().owner(), None);
}

#[test]
fn auto_clear_takes_all_slaves_to_safe_outputs_when_one_is_lost() {
    let mut line = line(Settings { auto_clear: true, ..settings() }, &[slave(3, 0), slave(4, 0), slave(5, 0)]);
    put(&mut line, [7, 7]);
    line.run_for(3_000);
    line.telegram_fault =
        Some(Box::new(|from, octets| if from == From::Slave(1) { Vec::new() } else { octets.to_vec() }));
    line.run_until(50_000, |line| line.master.user.mode() == Mode::Clear);
    line.run_for(3_000);
    assert_eq!((&outputs(&line)[0], &outputs(&line)[2]), (&Some(vec![0, 0]), &Some(vec![0, 0])));
    let reported: Vec<_> = std::iter::from_fn(|| line.master.user.next_event()).collect();
    let what: Vec<_> = reported.iter().map(|event| event.kind).collect();
    let lost = ExchangeError::NoAnswer(Failure::Silence);
    assert_eq!(what, [EventKind::Error(lost), EventKind::Entered(HandlerState::Offline), EventKind::AutoClear]);
    assert!(reported.iter().all(|event| event.address == 4));
    // The mode stays Clear when the slave is back, until the user changes it.
    line.telegram_fault = None;
    line.run_until(2_000_000, |line| line.master.user.exchanging() == 3);
    assert_eq!(line.master.user.mode(), Mode::Clear);
    line.master.user.set_mode(Mode::Operate);
    line.run_for(5_000);
    assert_eq!(outputs(&line), all([[7, 7]; 3]));
}

#[test]
fn auto_clear_reacts_to_faults_and_not_to_user_actions() {
    let mut line = line(Settings { auto_clear: true, ..settings() }, &[slave(3, 0), slave(4, 0), slave(5, 0)]);
    line.master.user.release(3);
    line.master.user.restart(4);
    line.master.user.set_group(5, 4).unwrap();
    line.run_for(20_000);
    assert_eq!((line.master.user.exchanging(), line.master.user.mode()), (2, Mode::Operate));
}

#[test]
fn without_auto_clear_the_others_keep_exchanging() {
    let mut line = line(settings(), &[slave(3, 0), slave(4, 0)]);
    line.slaves[0].power_up(3);
    line.run_for(3_000);
    assert_eq!(line.master.user.mode(), Mode::Operate);
}
