//! The device state machine, as far as it is particular here, and the NET LED. 7.2, 3.4.

use crate::support::{Desk, hex, selftest};
use crate::{CHANNEL, FLOATS, Gauge, MBAR, RELAYS, desk, exchanging, gauge, pcg, psg};
use profivac_devices::model::Fault;
use profivac_devices::pxg55x::Pxg55xModel;
use profivac_devices::{Action, SimulatedDevice};

const INIT: u8 = 0;
const IDLE: u8 = 2;
const SELF_TEST_EXCEPTION: u8 = 3;
const EXECUTING: u8 = 4;
const ABORT: u8 = 5;
const CRITICAL_FAULT: u8 = 6;

/// 7.2.2
const FACTORY_RESET: u8 = 128;
const RESET: u8 = 129;

fn led(desk: &mut Desk<Gauge>) -> &'static str {
    desk.report().led
}

#[test]
fn the_manufacturers_resets_are_resets() {
    for kind in Pxg55xModel::all() {
        for command in [1, FACTORY_RESET, RESET] {
            let mut desk = desk(kind);
            for (to, commands) in [(IDLE, &[][..]), (EXECUTING, &[4]), (ABORT, &[2])] {
                commands.iter().for_each(|command| desk.command(*command).unwrap());
                assert_eq!(desk.state(), to);
                desk.command(command).unwrap();
                assert_eq!(desk.state(), INIT);
                // Already there; and nothing else begins.
                assert_eq!(desk.command(command), Err(201));
                assert_eq!(desk.command(4), Err(202));
                desk.device().settle();
                assert_eq!((desk.state(), desk.get(0, 15)), (IDLE, vec![0]));
            }
        }
        for command in (7..128).chain(130..=255) {
            assert_eq!(desk(kind).command(command), Err(2), "command {command}");
        }
    }
}

/// A gauge whose last self test has found these faults.
fn found(faults: &str, state: u8) -> Desk<Gauge> {
    let mut desk = desk(psg());
    faults.split_whitespace().for_each(|fault| desk.fault(fault, true));
    desk.command(RESET).unwrap();
    desk.device().settle();
    assert_eq!(desk.state(), state, "{faults}");
    desk
}

#[test]
fn a_reset_ends_the_exception_of_a_fault_that_is_gone() {
    for (command, faults, state) in [
        (1, "ram", SELF_TEST_EXCEPTION),
        (FACTORY_RESET, "ram", SELF_TEST_EXCEPTION),
        (RESET, "ram", SELF_TEST_EXCEPTION),
        (1, "eprom", SELF_TEST_EXCEPTION),
        (1, "eprom ram", CRITICAL_FAULT),
    ] {
        let mut desk = found(faults, state);
        faults.split_whitespace().for_each(|fault| desk.fault(fault, false));
        desk.command(command).unwrap();
        desk.device().settle();
        assert_eq!(desk.state(), IDLE, "{faults}");
    }
}

#[test]
fn a_memory_fault_is_an_exception_and_program_and_working_memory_together_are_critical() {
    for kind in [pcg(), psg()] {
        selftest::memories(|| desk(kind), MBAR, CHANNEL);
    }
}

/// (112): red as long as there is an alarm, in every state.
#[test]
fn the_led_shows_a_memory_fault_and_not_the_state() {
    for (faults, state) in [("eprom", SELF_TEST_EXCEPTION), ("eprom ram", CRITICAL_FAULT)] {
        let mut desk = found(faults, state);
        assert_eq!(led(&mut desk), "red", "{faults}");
        faults.split_whitespace().for_each(|fault| desk.fault(fault, false));
        assert_eq!((desk.state(), led(&mut desk)), (state, "green flashing"), "{faults} gone");
    }
}

/// (22): "Reset (1) is the only command that acts in CRITICAL FAULT".
#[test]
fn the_manufacturers_resets_do_not_act_in_a_critical_fault() {
    let mut desk = found("eprom ram", CRITICAL_FAULT);
    desk.put(1, 39, &[3]).unwrap();
    for command in (2..=6).chain([FACTORY_RESET, RESET]) {
        assert_eq!(desk.command(command), Err(202), "command {command}");
        assert_eq!((desk.state(), desk.get(1, 39)), (CRITICAL_FAULT, vec![3]), "command {command}");
    }
    assert_eq!(desk.command(0), Ok(()));
}

/// 7.2: "As soon as cyclic data interchange is taken up, the gauge automatically changes to the EXECUTING status."
#[test]
fn exchange_leads_to_executing_and_its_end_to_idle() {
    for kind in Pxg55xModel::all() {
        let mut desk = exchanging(kind, FLOATS, 100.0);
        assert_eq!(desk.state(), EXECUTING);
        desk.unlock();
        assert_eq!(desk.state(), IDLE);
        // After Abort the exchange runs with safe values, and the state stays (24, 28).
        desk.command(2).unwrap();
        desk.bring_up(&hex(MBAR), &hex(FLOATS));
        assert_eq!((desk.state(), &desk.exchange(&[])[..2]), (ABORT, &[0xA0, 0x01][..]));
    }
}

/// 8.1.6: "it is not possible to change the pressure unit while the gauge is cyclically interchanging data", and "only
/// ... in the IDLE status"; 8.1.5: the data type only "if the device is not in cyclic data transfer" (84).
#[test]
fn unit_and_data_type_are_locked_in_the_modes_of_the_manual() {
    for (slot, unit, number) in [(1, 22, 21), (2, 28, 29), (3, 28, 29)] {
        let mut desk = desk(pcg());
        assert_eq!((desk.put(slot, unit, &hex("13 01")), desk.put(slot, number, &[3])), (Ok(()), Ok(())));
        desk.command(4).unwrap();
        assert_eq!((desk.put(slot, unit, &hex("13 08")), desk.put(slot, number, &[8])), (Err(17), Ok(())));
        desk.command(2).unwrap();
        assert_eq!((desk.put(slot, unit, &hex("13 08")), desk.put(slot, number, &[3])), (Err(17), Ok(())));
        desk.command(3).unwrap();
        assert_eq!((desk.put(slot, unit, &hex("13 08")), desk.put(slot, number, &[8])), (Ok(()), Ok(())));
        desk.bring_up(&hex(MBAR), &hex(FLOATS));
        assert_eq!((desk.put(slot, unit, &hex("13 01")), desk.put(slot, number, &[3])), (Err(17), Err(17)));
        // Also in IDLE, as long as data are exchanged (45).
        desk.command(5).unwrap();
        assert_eq!(desk.state(), IDLE);
        assert_eq!((desk.put(slot, unit, &hex("13 01")), desk.put(slot, number, &[3])), (Err(17), Err(17)));
    }
}

/// "A change of one data type parameter changes all others to the same value", and so with the unit.
#[test]
fn unit_and_data_type_are_one_for_all_blocks() {
    for (slot, unit, number) in [(1, 22, 21), (2, 28, 29), (3, 28, 29)] {
        let mut desk = desk(pcg());
        desk.put(slot, unit, &hex("10 01")).unwrap();
        desk.put(slot, number, &[3]).unwrap();
        for instance in 1..=3 {
            assert_eq!(crate::of_instance(&mut desk, instance, 22), hex("10 01"));
            assert_eq!(crate::of_instance(&mut desk, instance, 21), [3]);
        }
        for slot in [2, 3] {
            assert_eq!((desk.get(slot, 28), desk.get(slot, 29)), (hex("10 01"), vec![3]));
            assert_eq!(desk.get(slot, 17).len(), 2);
        }
    }
}

/// A master's configuration fixes the data type, its user parameters the unit: 8.1.5, 8.1.6.
#[test]
fn a_master_overrides_what_was_set_acyclically() {
    let mut desk = desk(psg());
    desk.put(1, 22, &hex("13 09")).unwrap();
    desk.put(1, 21, &[3]).unwrap();
    desk.bring_up(&hex(MBAR), &hex(FLOATS));
    assert_eq!((desk.get(1, 22), desk.get(1, 21)), (hex("13 08"), vec![8]));
    desk.unlock();
    assert_eq!((desk.get(1, 22), desk.get(1, 21)), (hex("13 08"), vec![8]));
}

/// 3.4 (112)
#[test]
fn the_net_led_shows_four_states() {
    for kind in Pxg55xModel::all() {
        let mut desk = desk(kind);
        assert_eq!(led(&mut desk), "green flashing");
        desk.pressure_mbar(100.0);
        desk.bring_up(&hex(MBAR), &hex(RELAYS));
        assert_eq!(led(&mut desk), "green");
        for fault in ["ram", "comm", "sensor1", "electronics1"] {
            desk.fault(fault, true);
            assert_eq!(led(&mut desk), "red", "{fault}");
            desk.fault(fault, false);
            assert_eq!(led(&mut desk), "green", "{fault}");
        }
        // A warning is no error: overrange.
        desk.pressure_mbar(2000.0);
        assert_eq!((desk.get(0, 26)[0], led(&mut desk)), (0xA0, "green"));
        desk.unlock();
        assert_eq!(led(&mut desk), "green flashing");
        desk.device().set_power(false);
        assert_eq!((led(&mut desk), desk.report().device_state), ("off", "OFF"));
    }
    // The atmosphere sensor is in no exception detail (74).
    let mut gauge = gauge(pcg());
    gauge.operate(Action::Fault { fault: Fault::Sensor3, active: true }).unwrap();
    assert_eq!(gauge.report().led, "green flashing");
}
