//! The device state machine where the IMG 400 differs, and Safe State. BG 5530 4.4.1, 4.4.2; errata-pxg55x-img400 19 to
//! 28, 32 to 36.

use crate::img400::{CHANNEL, COMMANDS, Controller, FLOATS, HPA, controller, exchanging, float, put_float, tester};
use crate::support::{Tester, hex, selftest};
use profivac_devices::SimulatedDevice;
use profivac_devices::img400::Gauges;
use profivac_dp::link::Baud;
use profivac_dp::slave::{Relation, Slave};

/// Device State.
const SELF_TESTING: u8 = 1;
const IDLE: u8 = 2;
const SELF_TEST_EXCEPTION: u8 = 3;
const EXECUTING: u8 = 4;
const INIT: u8 = 100;

fn state(device: &mut Controller) -> u8 {
    use profivac_dp::slave::Device;
    let mut record = [0; 240];
    assert_eq!(device.read(Relation::Ms2(0), 0, 25, &mut record), Ok(1));
    record[0]
}

#[test]
fn a_gauge_starts_through_init_and_self_test_to_idle() {
    let mut device = controller(Gauges::default());
    assert_eq!(state(&mut device), INIT);
    device.advance(0.2);
    assert_eq!(state(&mut device), SELF_TESTING);
    device.advance(0.5);
    assert_eq!(state(&mut device), IDLE);
}

#[test]
fn the_board_stays_in_init_without_an_answer_of_the_controller() {
    // 3.2, 4.4.1: "waiting for AYT response from IMG 400"
    let mut tester = tester();
    tester.fault("comm", true);
    tester.device().set_power(false);
    tester.device().set_power(true);
    tester.device().settle();
    tester.device().advance(1000.0);
    assert_eq!(tester.state(), INIT);
    assert_eq!(tester.report().device_state.name(), "INIT");
    // The device is on the bus, with safe values.
    tester.bring_up(&hex(HPA), &hex(FLOATS));
    let inputs = tester.exchange(&[]);
    assert_eq!(inputs[0], 0xB1);
    assert_eq!(inputs[1..], [0; 16]);
    tester.fault("comm", false);
    tester.device().settle();
    assert_eq!(tester.state(), EXECUTING);
}

#[test]
fn the_self_test_tests_memories_and_internal_communication() {
    for (name, found) in [
        ("comm", SELF_TEST_EXCEPTION),
        ("eeprom", SELF_TEST_EXCEPTION),
        ("ram", SELF_TEST_EXCEPTION),
        ("eprom", SELF_TEST_EXCEPTION),
        ("power", IDLE),
        ("sensor1", IDLE),
    ] {
        let mut tester = tester();
        tester.fault(name, true);
        // Perform Diagnostic (21)
        tester.command(6).unwrap();
        tester.device().settle();
        assert_eq!(tester.state(), found, "{name}");
    }
}

/// (163)
#[test]
fn a_memory_fault_is_an_exception_and_program_and_working_memory_together_are_critical() {
    selftest::memories(tester, HPA, CHANNEL);
}

#[test]
fn exchange_leads_to_executing_once_and_its_end_to_idle() {
    // (23, 24)
    let mut tester = exchanging(FLOATS, 1.0);
    assert_eq!(tester.state(), EXECUTING);
    tester.command(5).unwrap();
    tester.exchange(&[]);
    assert_eq!(tester.state(), IDLE, "Stop has the last word");
    tester.command(4).unwrap();
    assert_eq!(tester.state(), EXECUTING);
    tester.unlock();
    assert_eq!(tester.state(), IDLE);
}

#[test]
fn every_command_in_every_state_is_answered_as_in_the_diagram() {
    // Rows: commands 1 to 6; the code of the refusal, or the state after it.
    let reach: [(u8, &[u8]); 4] = [(IDLE, &[]), (EXECUTING, &[4]), (5, &[2]), (SELF_TESTING, &[6])];
    let expected = [
        (IDLE, [Ok(INIT), Ok(5), Err(()), Ok(EXECUTING), Err(()), Ok(SELF_TESTING)]),
        (EXECUTING, [Ok(INIT), Ok(5), Err(()), Err(()), Ok(IDLE), Ok(SELF_TESTING)]),
        (5, [Ok(INIT), Err(()), Ok(IDLE), Err(()), Err(()), Err(())]),
        (SELF_TESTING, [Ok(INIT), Err(()), Err(()), Err(()), Err(()), Err(())]),
    ];
    for ((from, commands), (row, results)) in reach.into_iter().zip(expected) {
        assert_eq!(from, row);
        for (command, result) in (1..).zip(results) {
            let mut tester = tester();
            commands.iter().for_each(|command| tester.command(*command).unwrap());
            assert_eq!(tester.state(), from);
            let answer = tester.command(command);
            assert_eq!(answer.is_ok(), result.is_ok(), "command {command} in {from}: {answer:?}");
            assert_eq!(tester.state(), result.unwrap_or(from), "command {command} in {from}");
        }
    }
}

#[test]
fn reset_restarts_the_controller() {
    let mut tester = exchanging(COMMANDS, 1e-6);
    tester.exchange(&[3, 1]);
    tester.put(0, 203, &[3]).unwrap();
    tester.fault("power", true);
    tester.fault("power", false);
    assert_eq!(tester.get(0, 26)[0] & 0x44, 0x44);
    tester.command(1).unwrap();
    tester.device().settle();
    assert_eq!(tester.get(0, 203), [0], "key lock is volatile");
    assert_eq!(tester.get(0, 26)[0] & 0x44, 0, "errors are forgotten");
    assert_eq!([tester.get(1, 105), tester.get(2, 105)], [[0], [0]], "emission is off");
}

#[test]
fn the_safe_state_decides_all_four_channels_outside_executing() {
    // 4.4.2, ID 39
    let mut tester = exchanging(FLOATS, 100.0);
    put_float(&mut tester, 4, 40, 12.5).unwrap();
    for (mode, value) in [(0, 0.0), (1, 1000.0), (2, 100.0), (3, 12.5)] {
        tester.put(4, 39, &[mode]).unwrap();
        tester.command(5).unwrap();
        assert_eq!(float(&mut tester, 4, 19), value, "mode {mode}");
        assert_eq!(tester.get(4, 23), [0], "reading valid");
        assert_eq!(tester.get(4, 102), [1]);
        let inputs = tester.exchange(&[]);
        assert_eq!(inputs[13..17], f32::to_be_bytes(value), "mode {mode}");
        assert_eq!(inputs[9..13], [0; 4], "channel 3 has its own mode");
        tester.command(4).unwrap();
        assert_eq!(float(&mut tester, 4, 19), 100.0);
    }
}

#[test]
fn hold_last_value_holds_the_last_valid_value_of_executing() {
    // (33)
    let mut tester = tester();
    tester.put(4, 39, &[2]).unwrap();
    tester.pressure_mbar(100.0);
    assert_eq!(float(&mut tester, 4, 19), 0.0, "nothing yet");
    tester.command(4).unwrap();
    tester.pressure_mbar(50.0);
    tester.command(5).unwrap();
    tester.pressure_mbar(700.0);
    assert_eq!(float(&mut tester, 4, 19), 50.0);
}

#[test]
fn a_supply_alarm_concerns_all_channels_and_a_switch_off_only_its_own() {
    // (35): manufacturer alarms concern all channels, a sensor alarm its own channel.
    let mut tester = exchanging(FLOATS, 1e-6);
    tester.put(1, 105, &[1]).unwrap();
    tester.put(2, 105, &[1]).unwrap();
    // Overpressure on channel 2 alone.
    tester.device().sense(1, 100.0);
    assert_eq!([tester.get(1, 23), tester.get(2, 23)], [[1], [0]]);
    assert_eq!(float(&mut tester, 1, 19), 1e-6);
    assert_eq!(float(&mut tester, 2, 19), 0.0);
    tester.fault("sensor2", true);
    assert_eq!([tester.get(1, 23), tester.get(4, 23)], [[0], [0]]);
    assert_eq!(float(&mut tester, 1, 19), 0.0);
}

#[test]
fn exception_status_shows_the_invalid_readings_in_idle() {
    // (36)
    let mut tester: Tester<Controller> = tester();
    tester.pressure_mbar(1.0);
    assert_eq!(tester.get(0, 26), [0xA0]);
    let slave = Slave::new(controller(Gauges::default()), 5, Baud::B1500000);
    assert_eq!(slave.device().report().exception_status, 0xA0);
}
