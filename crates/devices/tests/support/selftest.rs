//! The result of a self test with defective memories, the same for all block devices: tira41d1 and tira36e1 3.1.2, tira56e1
//! 7.2.1, BG 5530 4.4.1.

use super::{Desk, hex};
use profivac_devices::SimulatedDevice;

const IDLE: u8 = 2;
const SELF_TEST_EXCEPTION: u8 = 3;
const CRITICAL_FAULT: u8 = 6;

const RESET: u8 = 1;
const DIAGNOSTIC: u8 = 6;

/// Common alarm and common warning of Exception Status.
const COMMON: u8 = 0x11;

/// The memories of a device, and what the self test makes of those that are defective.
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
fn power_cycle<D: SimulatedDevice>(desk: &mut Desk<D>) {
    desk.device().set_power(false);
    assert_eq!(desk.report().device_state, "OFF");
    desk.device().set_power(true);
}

/// Every combination of defective memories, found in every way. `user` and `cfg` lead to an exchange with a parameter
/// channel in front and a float of the process at the end.
pub fn memories<D: SimulatedDevice>(new: impl Fn() -> Desk<D>, user: &str, cfg: &str) {
    // The ways into a self test.
    let ways: [fn(&mut Desk<D>); 3] =
        [power_cycle, |desk| desk.command(RESET).unwrap(), |desk| desk.command(DIAGNOSTIC).unwrap()];
    for (faults, state, name) in CASES {
        for way in ways {
            let mut desk = new();
            desk.pressure_mbar(1e-3);
            faults.iter().for_each(|fault| desk.fault(fault, true));
            assert_eq!(desk.state(), IDLE, "{faults:?} are found by a test only");
            way(&mut desk);
            desk.device().settle();
            let report = desk.report();
            assert_eq!((desk.state(), report.device_state), (state, name), "{faults:?}");
            assert_eq!(report.exception_status & COMMON, if faults.is_empty() { 0 } else { COMMON }, "{faults:?}");
            assert!(report.outputs_safe, "{faults:?}");
            if !faults.is_empty() {
                exchanges_safe_values(&mut desk, state, user, cfg);
                leaves(&mut desk, state, faults);
            }
        }
    }
}

/// The device is on the bus, with safe values and a parameter channel that tells its state; the state stays.
fn exchanges_safe_values<D: SimulatedDevice>(desk: &mut Desk<D>, state: u8, user: &str, cfg: &str) {
    desk.bring_up(&hex(user), &hex(cfg));
    let mut outputs = vec![0; desk.outputs().unwrap()];
    outputs[..8].copy_from_slice(&[0x10, 0, 25, 0, 0, 0, 0, 0]);
    let inputs = desk.exchange(&outputs);
    assert_eq!(inputs[..8], [0xB0, 0, 25, 0, 0, 0, 0, state]);
    assert_eq!(inputs[inputs.len() - 4..], [0; 4], "Safe State Zero");
    desk.unlock();
    assert_eq!(desk.state(), state);
}

/// Commands that are refused, and those that lead to IDLE once the memories are sound again.
fn leaves<D: SimulatedDevice>(desk: &mut Desk<D>, state: u8, faults: &[&str]) {
    for command in 2..=5 {
        assert_eq!(desk.command(command), Err(202), "command {command} in {state}");
    }
    faults.iter().for_each(|fault| desk.fault(fault, false));
    assert_eq!((desk.state(), desk.report().exception_status), (state, 0xA0), "the state stays, the alarm is over");
    if state == CRITICAL_FAULT {
        assert_eq!(desk.command(DIAGNOSTIC), Err(202));
        desk.command(RESET).unwrap();
    } else {
        desk.command(DIAGNOSTIC).unwrap();
    }
    desk.device().settle();
    assert_eq!(desk.state(), IDLE, "{faults:?} are gone");
}
