//! The device state machine. tira41d1 3.1.2, (84) to (92).

use crate::bcg450::{COMMANDS, FLOATS, Gauge, MBAR, exchanging, gauge, tester};
use crate::support::{Tester, hex, selftest};
use profivac_devices::model::Fault;
use profivac_devices::{Action, SimulatedDevice};
use profivac_dp::link::Baud;
use profivac_dp::slave::Slave;

const UNDEFINED: u8 = 0;
const SELF_TESTING: u8 = 1;
const IDLE: u8 = 2;
const SELF_TEST_EXCEPTION: u8 = 3;
const EXECUTING: u8 = 4;
const ABORT: u8 = 5;
const CRITICAL_FAULT: u8 = 6;

const RESET: u8 = 1;
const ABORT_COMMAND: u8 = 2;
const RECOVER: u8 = 3;
const EXECUTE: u8 = 4;
const STOP: u8 = 5;
const DIAGNOSTIC: u8 = 6;

/// Faults of program memory and working memory, which together are critical.
fn both_memories(tester: &mut Tester<Gauge>, defective: bool) {
    tester.fault("eprom", defective);
    tester.fault("ram", defective);
}

/// Telegrams with the parameter channel in front.
const CHANNEL_FLOATS: &str = "C6 87 8E 0A 0A 05 05 05 08";

/// A gauge in this state, without data exchange.
fn in_state(state: u8) -> Tester<Gauge> {
    let mut tester = tester();
    match state {
        UNDEFINED => tester.command(RESET).unwrap(),
        SELF_TESTING => tester.command(DIAGNOSTIC).unwrap(),
        SELF_TEST_EXCEPTION => {
            tester.fault("ram", true);
            tester.command(DIAGNOSTIC).unwrap();
            tester.device().settle();
        }
        EXECUTING => tester.command(EXECUTE).unwrap(),
        ABORT => tester.command(ABORT_COMMAND).unwrap(),
        CRITICAL_FAULT => {
            both_memories(&mut tester, true);
            tester.command(RESET).unwrap();
            tester.device().settle();
        }
        _ => {}
    }
    assert_eq!(tester.state(), state);
    tester
}

/// The states a gauge with these faults runs through after power-up.
fn phases(faults: &[&str]) -> Vec<&'static str> {
    let mut gauge = gauge();
    for name in faults {
        gauge.operate(Action::Fault { fault: Fault::from_name(name).unwrap(), active: true }).unwrap();
    }
    let mut names: Vec<&str> = core::iter::repeat_with(|| {
        let name = gauge.report().device_state.name();
        gauge.advance(0.05);
        name
    })
    .take(12)
    .collect();
    names.dedup();
    names
}

#[test]
fn a_gauge_starts_through_the_self_test_to_its_result() {
    assert_eq!(phases(&[]), ["INIT", "SELFTESTING", "IDLE"]);
    assert_eq!(phases(&["eprom"]), ["INIT", "SELFTESTING", "SELFTESTEXCEPTION"]);
    assert_eq!(phases(&["eprom", "ram"]), ["INIT", "SELFTESTING", "CRITICALFAULT"]);
}

/// (89): the result of each command in each state; a number is the code of the refusal.
#[test]
fn every_command_has_its_result_in_every_state() {
    let to = |state: u8| Ok(state);
    let table = [
        (UNDEFINED, [Err(201), Err(202), Err(202), Err(202), Err(202), Err(202)]),
        (SELF_TESTING, [to(UNDEFINED), Err(202), Err(202), Err(202), Err(202), Err(201)]),
        (IDLE, [to(UNDEFINED), to(ABORT), Err(201), to(EXECUTING), Err(201), to(SELF_TESTING)]),
        (SELF_TEST_EXCEPTION, [to(UNDEFINED), Err(202), Err(202), Err(202), Err(202), to(SELF_TESTING)]),
        (EXECUTING, [to(UNDEFINED), to(ABORT), Err(202), Err(201), to(IDLE), to(SELF_TESTING)]),
        (ABORT, [to(UNDEFINED), Err(201), to(IDLE), Err(202), Err(202), Err(202)]),
        (CRITICAL_FAULT, [to(UNDEFINED), Err(202), Err(202), Err(202), Err(202), Err(202)]),
    ];
    for (state, results) in table {
        for (command, result) in (1..).zip(results) {
            let mut tester = in_state(state);
            assert_eq!(tester.command(command), result.map(|_| ()), "command {command} in state {state}");
            assert_eq!(tester.state(), result.unwrap_or(state), "after command {command} in state {state}");
            // Inactive is always accepted, an unknown command never; an executed command is not read back.
            let after = tester.state();
            assert_eq!(tester.command(0), Ok(()));
            assert_eq!(tester.command(7), Err(2));
            assert_eq!((tester.state(), tester.get(0, 15)), (after, vec![0]));
        }
    }
}

#[test]
fn a_self_test_ends_in_idle_or_in_exception() {
    let mut tester = in_state(EXECUTING);
    tester.command(DIAGNOSTIC).unwrap();
    tester.device().settle();
    // The state does not return to EXECUTING (88).
    assert_eq!(tester.state(), IDLE);
    for fault in ["eeprom", "ram", "eprom", "comm", "sensor1", "sensor2", "sensor3", "electronics1"] {
        let mut tester = in_state(IDLE);
        tester.fault(fault, true);
        assert_eq!(tester.state(), IDLE, "{fault} is found by a test only");
        tester.command(DIAGNOSTIC).unwrap();
        tester.device().settle();
        assert_eq!(tester.state(), SELF_TEST_EXCEPTION, "{fault}");
        tester.fault(fault, false);
        assert_eq!(tester.state(), SELF_TEST_EXCEPTION, "{fault} gone");
        tester.command(DIAGNOSTIC).unwrap();
        tester.device().settle();
        assert_eq!(tester.state(), IDLE, "{fault} gone and tested");
    }
    // A warning is no fault.
    let mut tester = in_state(IDLE);
    tester.fault("pirani-adjust", true);
    tester.command(DIAGNOSTIC).unwrap();
    tester.device().settle();
    assert_eq!(tester.state(), IDLE);
}

#[test]
fn only_reset_leads_out_of_a_critical_fault() {
    let mut tester = in_state(CRITICAL_FAULT);
    tester.command(RESET).unwrap();
    tester.device().settle();
    assert_eq!(tester.state(), CRITICAL_FAULT, "the fault is still there");
    both_memories(&mut tester, false);
    assert_eq!(tester.state(), CRITICAL_FAULT, "nothing happens by itself");
    tester.command(RESET).unwrap();
    tester.device().settle();
    assert_eq!(tester.state(), IDLE);
}

#[test]
fn a_memory_fault_is_an_exception_and_program_and_working_memory_together_are_critical() {
    selftest::memories(tester, MBAR, CHANNEL_FLOATS);
}

/// 3.1.2 and (90)
#[test]
fn exchange_forces_executing_once_and_its_end_leads_to_idle() {
    let mut tester = exchanging(FLOATS, 1e-3);
    assert_eq!(tester.state(), EXECUTING);
    tester.command(STOP).unwrap();
    tester.exchange(&[]);
    assert_eq!(tester.state(), IDLE, "a Stop during the exchange is obeyed");
    tester.command(EXECUTE).unwrap();
    tester.unlock();
    assert_eq!(tester.state(), IDLE);
    tester.bring_up(&hex(MBAR), &hex(FLOATS));
    assert_eq!(tester.state(), EXECUTING, "a new start of the exchange");
}

#[test]
fn exchange_that_begins_during_the_start_leads_to_executing_later() {
    for seconds in [0.0, 0.2] {
        let mut device = gauge();
        device.advance(seconds);
        let mut tester = Tester::new(gauge());
        tester.slave = Slave::new(device, 5, Baud::B1500000);
        tester.bring_up(&hex(MBAR), &hex(FLOATS));
        assert!(tester.state() < IDLE);
        tester.device().settle();
        assert_eq!(tester.state(), EXECUTING);
    }
}

#[test]
fn exchange_leads_to_executing_from_idle_only() {
    for state in [SELF_TEST_EXCEPTION, ABORT, CRITICAL_FAULT] {
        let mut tester = in_state(state);
        tester.pressure_mbar(1e-3);
        tester.bring_up(&hex(MBAR), &hex(FLOATS));
        assert_eq!(tester.state(), state);
        // Safe State Zero.
        assert_eq!(tester.exchange(&[])[3..], [0; 4]);
        tester.unlock();
        assert_eq!(tester.state(), state);
    }
    let mut tester = in_state(ABORT);
    tester.bring_up(&hex(MBAR), &hex(FLOATS));
    tester.command(RECOVER).unwrap();
    assert_eq!(tester.state(), IDLE, "the start of the exchange is over");
}

/// (92)
#[test]
fn reset_during_the_exchange_ends_in_idle_and_keeps_nonvolatile_values() {
    let mut tester = exchanging(COMMANDS, 1e-3);
    tester.put(1, 46, &[2]).unwrap();
    tester.put(1, 39, &[1]).unwrap();
    tester.exchange(&[128, 0]);
    assert_eq!(tester.get(1, 201), [0], "manual mode");
    tester.command(RESET).unwrap();
    assert!(tester.is_exchanging());
    tester.device().settle();
    assert_eq!(tester.state(), IDLE);
    assert_eq!((tester.get(1, 46), tester.get(1, 39)), (vec![2], vec![1]));
    assert_eq!(tester.get(1, 201), [1], "automatic mode, as after power-up");
}
