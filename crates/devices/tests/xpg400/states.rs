//! The device state machine. tira36e1 3.1.2, (84) to (92).

use crate::support::{Tester, hex, selftest};
use crate::xpg400::{FLOATS, Gauge, KINDS, MBAR, exchanging, of_instance, tester};
use profivac_devices::SimulatedDevice;
use profivac_devices::xpg400::Xpg400Model;

const UNDEFINED: u8 = 0;
const SELF_TESTING: u8 = 1;
const IDLE: u8 = 2;
const SELF_TEST_EXCEPTION: u8 = 3;
const EXECUTING: u8 = 4;
const ABORT: u8 = 5;
const CRITICAL_FAULT: u8 = 6;

const RESET: u8 = 1;
const RECOVER: u8 = 3;
const EXECUTE: u8 = 4;
const STOP: u8 = 5;
const DIAGNOSTIC: u8 = 6;

/// Telegrams with the parameter channel in front.
const CHANNEL_FLOATS: &str = "C6 87 8E 0A 0A 05 05 05 08";

/// A gauge in this state, without data exchange.
fn in_state(kind: Xpg400Model, state: u8) -> Tester<Gauge> {
    let mut tester = tester(kind);
    let (fault, command) = match state {
        UNDEFINED => ("", RESET),
        SELF_TESTING => ("", DIAGNOSTIC),
        SELF_TEST_EXCEPTION => ("ram", DIAGNOSTIC),
        EXECUTING => ("", EXECUTE),
        ABORT => ("", 2),
        CRITICAL_FAULT => ("eprom ram", RESET),
        _ => ("", 0),
    };
    fault.split_whitespace().for_each(|fault| tester.fault(fault, true));
    tester.command(command).unwrap();
    if !fault.is_empty() {
        tester.device().settle();
    }
    assert_eq!(tester.state(), state);
    tester
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
    for (kind, (state, results)) in KINDS.into_iter().flat_map(|kind| table.map(|row| (kind, row))) {
        for (command, result) in (1..).zip(results) {
            let mut tester = in_state(kind, state);
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
    for fault in ["eeprom", "ram", "eprom", "comm", "sensor1", "sensor2", "electronics1", "electronics2"] {
        let mut tester = in_state(Xpg400Model::Hpg, EXECUTING);
        tester.fault(fault, true);
        assert_eq!(tester.state(), EXECUTING, "{fault} is found by a test only");
        tester.command(DIAGNOSTIC).unwrap();
        tester.device().settle();
        assert_eq!(tester.state(), SELF_TEST_EXCEPTION, "{fault}");
        tester.fault(fault, false);
        tester.command(DIAGNOSTIC).unwrap();
        tester.device().settle();
        // The state does not return to EXECUTING (88).
        assert_eq!(tester.state(), IDLE, "{fault} gone and tested");
    }
    // A warning is no fault.
    let mut tester = in_state(Xpg400Model::Bpg, IDLE);
    tester.fault("pirani-adjust", true);
    tester.command(DIAGNOSTIC).unwrap();
    tester.device().settle();
    assert_eq!(tester.state(), IDLE);
}

#[test]
fn only_reset_leads_out_of_a_critical_fault() {
    let mut tester = in_state(Xpg400Model::Bpg, CRITICAL_FAULT);
    tester.command(RESET).unwrap();
    tester.device().settle();
    assert_eq!(tester.state(), CRITICAL_FAULT, "the fault is still there");
    tester.fault("eprom", false);
    assert_eq!(tester.state(), CRITICAL_FAULT, "nothing happens by itself");
    tester.command(RESET).unwrap();
    tester.device().settle();
    assert_eq!(tester.state(), SELF_TEST_EXCEPTION, "the working memory is still defective");
    tester.fault("ram", false);
    tester.command(RESET).unwrap();
    tester.device().settle();
    assert_eq!(tester.state(), IDLE);
}

#[test]
fn a_memory_fault_is_an_exception_and_program_and_working_memory_together_are_critical() {
    for kind in KINDS {
        selftest::memories(|| tester(kind), MBAR, CHANNEL_FLOATS);
    }
}

/// (90)
#[test]
fn the_exchange_forces_executing_once_and_its_end_leads_to_idle() {
    let mut tester = exchanging(Xpg400Model::Hpg, FLOATS, 1e-3);
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
fn exchange_leads_to_executing_from_idle_only() {
    for state in [SELF_TEST_EXCEPTION, ABORT, CRITICAL_FAULT] {
        let mut tester = in_state(Xpg400Model::Bpg, state);
        tester.pressure_mbar(1e-3);
        tester.bring_up(&hex(MBAR), &hex(FLOATS));
        assert_eq!(tester.state(), state);
        // Safe State Zero.
        assert_eq!(tester.exchange(&[])[3..], [0; 4]);
    }
    let mut tester = in_state(Xpg400Model::Bpg, ABORT);
    tester.bring_up(&hex(MBAR), &hex(FLOATS));
    tester.command(RECOVER).unwrap();
    assert_eq!(tester.state(), IDLE, "the start of the exchange is over");
}

/// (92)
#[test]
fn reset_during_the_exchange_ends_in_idle_and_keeps_nonvolatile_values() {
    let mut tester = exchanging(Xpg400Model::Bpg, FLOATS, 1e-3);
    tester.put(1, 46, &[2]).unwrap();
    tester.put(1, 39, &[1]).unwrap();
    tester.put(1, 105, &[0]).unwrap();
    tester.command(RESET).unwrap();
    assert!(tester.is_exchanging());
    tester.device().settle();
    assert_eq!(tester.state(), IDLE);
    assert_eq!((tester.get(1, 46), tester.get(1, 39)), (vec![2], vec![1]));
    tester.command(EXECUTE).unwrap();
    assert_eq!(of_instance(&mut tester, 2, 105), [1], "the emission is automatic again");
}
