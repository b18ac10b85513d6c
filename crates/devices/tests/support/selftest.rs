//! The result of a self test with defective memories, the same for all block devices: tira41d1 and tira36e1 3.1.2, tira56e1
//! 7.2.1, BG 5530 4.4.1.

use super::{Tester, hex};
use profivac_devices::SimulatedDevice;

const IDLE: u8 = 2;
const SELF_TEST_EXCEPTION: u8 = 3;
const CRITICAL_FAULT: u8 = 6;

const RESET: u8 = 1;
const DIAGNOSTIC: u8 = 6;

/// Common alarm and common warning of Exception Status.
const COMMON: u8 = 0x11;

/// The memories of a device, and the result of the self test for each combination of defects.
const CASES: [(&[&str], u8, &str); 8] = [
    (&[], IDLE, "IDLE"),
    (&["eprom"], SELF_TEST_EXCEPTION, "SELFTESTEXCEPTION"),
    (&["ram"], SELF_TEST_EXCEPTION, "SELFTESTEXCEPTION"),
    (&["eeprom"], SELF_TEST_EXCEPTION, "SELFTESTEXCEPTION"),
    (&["eprom", "eeprom"], SELF_TEST_EXCEPTION, "SELFTESTEXCEPTION"),
    (&["ram", "eeprom"], SELF_TEST_EXCEPTION, "SELFTESTEXCEPTION"),
    (&["eprom", "ram"], CRITICAL_FAULT, "CRITICALFAULT"),
    (&["eprom", "ram", "eeprom"], CRITICAL_FAULT, "CRITICALFAULT"),
];

/// Power is lost and returns.
fn power_cycle<D: SimulatedDevice>(tester: &mut Tester<D>) {
    tester.device().set_power(false);
    assert_eq!(tester.report().device_state.name(), "OFF");
    tester.device().set_power(true);
}

/// Starts a self test; a device in CRITICAL FAULT refuses it.
fn diagnose<D: SimulatedDevice>(tester: &mut Tester<D>) {
    let expected = if tester.state() == CRITICAL_FAULT { Err(202) } else { Ok(()) };
    assert_eq!(tester.command(DIAGNOSTIC), expected);
}

/// A fault that is critical acts at once in every state that is not the start; another one waits for a self test.
/// Transition 9 of BG 5530 4.4.1; errata-bpg-bcg-tpg 158.
fn is_detected_at_once<D: SimulatedDevice>(new: &impl Fn() -> Tester<D>) {
    const EXECUTING: u8 = 4;
    const ABORT: u8 = 5;
    let repaired = |tester: &mut Tester<D>, state: u8| {
        for fault in ["eprom", "ram", "eeprom"] {
            tester.fault(fault, false);
        }
        assert_eq!(tester.state(), CRITICAL_FAULT, "from {state}: the state stays");
        tester.command(RESET).unwrap();
        tester.device().settle();
        assert_eq!(tester.state(), IDLE, "from {state}");
    };
    for (command, state) in [(0, IDLE), (4, EXECUTING), (2, ABORT), (DIAGNOSTIC, SELF_TEST_EXCEPTION)] {
        let mut tester = new();
        tester.pressure_mbar(1e-3);
        if state == SELF_TEST_EXCEPTION {
            tester.fault("eeprom", true);
        }
        tester.command(command).unwrap();
        tester.device().settle();
        assert_eq!(tester.state(), state);
        tester.fault("eprom", true);
        assert_eq!(tester.state(), state, "one defective memory waits for a self test");
        tester.fault("ram", true);
        let report = tester.report();
        assert_eq!((tester.state(), report.device_state.name()), (CRITICAL_FAULT, "CRITICALFAULT"), "from {state}");
        assert!(report.outputs_safe, "from {state}");
        repaired(&mut tester, state);
    }
}

/// Every combination of defective memories, found by every self test. `user` and `cfg` lead to an exchange with a parameter
/// channel in front and a float of the process at the end.
pub fn memories<D: SimulatedDevice>(new: impl Fn() -> Tester<D>, user: &str, cfg: &str) {
    is_detected_at_once(&new);
    // The events that start a self test.
    let ways: [fn(&mut Tester<D>); 3] = [power_cycle, |tester| tester.command(RESET).unwrap(), diagnose];
    for (faults, state, name) in CASES {
        for way in ways {
            let mut tester = new();
            tester.pressure_mbar(1e-3);
            faults.iter().for_each(|fault| tester.fault(fault, true));
            let detected = if state == CRITICAL_FAULT { CRITICAL_FAULT } else { IDLE };
            assert_eq!(tester.state(), detected, "{faults:?}: all but a critical fault are found by a test only");
            way(&mut tester);
            tester.device().settle();
            let report = tester.report();
            assert_eq!((tester.state(), report.device_state.name()), (state, name), "{faults:?}");
            assert_eq!(report.exception_status & COMMON, if faults.is_empty() { 0 } else { COMMON }, "{faults:?}");
            assert!(report.outputs_safe, "{faults:?}");
            if !faults.is_empty() {
                exchanges_safe_values(&mut tester, state, user, cfg);
                leaves(&mut tester, state, faults);
            }
        }
    }
}

/// The device is on the bus, with safe values and a parameter channel that reads its state; the state stays.
fn exchanges_safe_values<D: SimulatedDevice>(tester: &mut Tester<D>, state: u8, user: &str, cfg: &str) {
    tester.bring_up(&hex(user), &hex(cfg));
    let mut outputs = vec![0; tester.outputs().unwrap()];
    outputs[..8].copy_from_slice(&[0x10, 0, 25, 0, 0, 0, 0, 0]);
    let inputs = tester.exchange(&outputs);
    assert_eq!(inputs[..8], [0xB0, 0, 25, 0, 0, 0, 0, state]);
    assert_eq!(inputs[inputs.len() - 4..], [0; 4], "Safe State Zero");
    tester.unlock();
    assert_eq!(tester.state(), state);
}

/// Commands that are refused, and those that lead to IDLE after the memories are repaired.
fn leaves<D: SimulatedDevice>(tester: &mut Tester<D>, state: u8, faults: &[&str]) {
    for command in 2..=5 {
        assert_eq!(tester.command(command), Err(202), "command {command} in {state}");
    }
    faults.iter().for_each(|fault| tester.fault(fault, false));
    assert_eq!((tester.state(), tester.report().exception_status), (state, 0xA0), "the state stays, the alarm is over");
    if state == CRITICAL_FAULT {
        assert_eq!(tester.command(DIAGNOSTIC), Err(202));
        tester.command(RESET).unwrap();
    } else {
        tester.command(DIAGNOSTIC).unwrap();
    }
    tester.device().settle();
    assert_eq!(tester.state(), IDLE, "{faults:?} are gone");
}
