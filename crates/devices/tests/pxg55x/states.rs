//! The device state machine, as far as it differs from the BCG450, and the NET LED. 7.2, 3.4.

use crate::pxg55x::{CHANNEL, FLOATS, Gauge, MBAR, RELAYS, exchanging, gauge, pcg, psg, tester};
use crate::support::{Tester, hex, selftest};
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

fn led(tester: &mut Tester<Gauge>) -> &'static str {
    tester.report().led.name()
}

#[test]
fn the_manufacturers_resets_are_resets() {
    for kind in Pxg55xModel::all() {
        for command in [1, FACTORY_RESET, RESET] {
            let mut tester = tester(kind);
            for (to, commands) in [(IDLE, &[][..]), (EXECUTING, &[4]), (ABORT, &[2])] {
                commands.iter().for_each(|command| tester.command(*command).unwrap());
                assert_eq!(tester.state(), to);
                tester.command(command).unwrap();
                assert_eq!(tester.state(), INIT);
                // The gauge is in this state already; it begins nothing else.
                assert_eq!(tester.command(command), Err(201));
                assert_eq!(tester.command(4), Err(202));
                tester.device().settle();
                assert_eq!((tester.state(), tester.get(0, 15)), (IDLE, vec![0]));
            }
        }
        for command in (7..128).chain(130..=255) {
            assert_eq!(tester(kind).command(command), Err(2), "command {command}");
        }
    }
}

/// A gauge whose last self test has found these faults.
fn found(faults: &str, state: u8) -> Tester<Gauge> {
    let mut tester = tester(psg());
    faults.split_whitespace().for_each(|fault| tester.fault(fault, true));
    // In CRITICAL FAULT only 1 acts (22).
    tester.command(1).unwrap();
    tester.device().settle();
    assert_eq!(tester.state(), state, "{faults}");
    tester
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
        let mut tester = found(faults, state);
        faults.split_whitespace().for_each(|fault| tester.fault(fault, false));
        tester.command(command).unwrap();
        tester.device().settle();
        assert_eq!(tester.state(), IDLE, "{faults}");
    }
}

/// (163)
#[test]
fn a_memory_fault_is_an_exception_and_program_and_working_memory_together_are_critical() {
    for kind in [pcg(), psg()] {
        selftest::memories(|| tester(kind), MBAR, CHANNEL);
    }
}

/// (112): red as long as there is an alarm, in every state.
#[test]
fn the_led_shows_a_memory_fault_and_not_the_state() {
    for (faults, state) in [("eprom", SELF_TEST_EXCEPTION), ("eprom ram", CRITICAL_FAULT)] {
        let mut tester = found(faults, state);
        assert_eq!(led(&mut tester), "red", "{faults}");
        faults.split_whitespace().for_each(|fault| tester.fault(fault, false));
        assert_eq!((tester.state(), led(&mut tester)), (state, "green flashing"), "{faults} gone");
    }
}

/// (22): "Reset (1) is the only command that acts in CRITICAL FAULT".
#[test]
fn the_manufacturers_resets_have_no_effect_in_a_critical_fault() {
    let mut tester = found("eprom ram", CRITICAL_FAULT);
    tester.put(1, 39, &[3]).unwrap();
    for command in (2..=6).chain([FACTORY_RESET, RESET]) {
        assert_eq!(tester.command(command), Err(202), "command {command}");
        assert_eq!((tester.state(), tester.get(1, 39)), (CRITICAL_FAULT, vec![3]), "command {command}");
    }
    assert_eq!(tester.command(0), Ok(()));
}

/// 7.2: "As soon as cyclic data interchange is taken up, the gauge automatically changes to the EXECUTING status."
#[test]
fn exchange_leads_to_executing_and_its_end_to_idle() {
    for kind in Pxg55xModel::all() {
        let mut tester = exchanging(kind, FLOATS, 100.0);
        assert_eq!(tester.state(), EXECUTING);
        tester.unlock();
        assert_eq!(tester.state(), IDLE);
        // After Abort the exchange runs with safe values, and the state stays (24, 28).
        tester.command(2).unwrap();
        tester.bring_up(&hex(MBAR), &hex(FLOATS));
        assert_eq!((tester.state(), &tester.exchange(&[])[..2]), (ABORT, &[0xA0, 0x01][..]));
    }
}

/// 8.1.6: "it is not possible to change the pressure unit while the gauge is cyclically interchanging data", and "only
/// ... in the IDLE status"; 8.1.5: the data type only "if the device is not in cyclic data transfer" (84).
#[test]
fn unit_and_data_type_are_locked_in_the_modes_of_the_manual() {
    for (slot, unit, number) in [(1, 22, 21), (2, 28, 29), (3, 28, 29)] {
        let mut tester = tester(pcg());
        assert_eq!((tester.put(slot, unit, &hex("13 01")), tester.put(slot, number, &[3])), (Ok(()), Ok(())));
        tester.command(4).unwrap();
        assert_eq!((tester.put(slot, unit, &hex("13 08")), tester.put(slot, number, &[8])), (Err(17), Ok(())));
        tester.command(2).unwrap();
        assert_eq!((tester.put(slot, unit, &hex("13 08")), tester.put(slot, number, &[3])), (Err(17), Ok(())));
        tester.command(3).unwrap();
        assert_eq!((tester.put(slot, unit, &hex("13 08")), tester.put(slot, number, &[8])), (Ok(()), Ok(())));
        tester.bring_up(&hex(MBAR), &hex(FLOATS));
        assert_eq!((tester.put(slot, unit, &hex("13 01")), tester.put(slot, number, &[3])), (Err(17), Err(17)));
        // Also in IDLE, as long as data are exchanged (45).
        tester.command(5).unwrap();
        assert_eq!(tester.state(), IDLE);
        assert_eq!((tester.put(slot, unit, &hex("13 01")), tester.put(slot, number, &[3])), (Err(17), Err(17)));
    }
}

/// "A change of one data type parameter changes all others to the same value", and so with the unit.
#[test]
fn unit_and_data_type_are_one_for_all_blocks() {
    for (slot, unit, number) in [(1, 22, 21), (2, 28, 29), (3, 28, 29)] {
        let mut tester = tester(pcg());
        tester.put(slot, unit, &hex("10 01")).unwrap();
        tester.put(slot, number, &[3]).unwrap();
        for instance in 1..=3 {
            assert_eq!(crate::pxg55x::of_instance(&mut tester, instance, 22), hex("10 01"));
            assert_eq!(crate::pxg55x::of_instance(&mut tester, instance, 21), [3]);
        }
        for slot in [2, 3] {
            assert_eq!((tester.get(slot, 28), tester.get(slot, 29)), (hex("10 01"), vec![3]));
            assert_eq!(tester.get(slot, 17).len(), 2);
        }
    }
}

/// A master's configuration fixes the data type, its user parameters the unit: 8.1.5, 8.1.6.
#[test]
fn a_master_in_data_exchange_overrides_acyclic_settings() {
    let mut tester = tester(psg());
    tester.put(1, 22, &hex("13 09")).unwrap();
    tester.put(1, 21, &[3]).unwrap();
    tester.bring_up(&hex(MBAR), &hex(FLOATS));
    assert_eq!((tester.get(1, 22), tester.get(1, 21)), (hex("13 08"), vec![8]));
    tester.unlock();
    assert_eq!((tester.get(1, 22), tester.get(1, 21)), (hex("13 08"), vec![8]));
}

/// 3.4 (112)
#[test]
fn the_net_led_shows_four_states() {
    for kind in Pxg55xModel::all() {
        let mut tester = tester(kind);
        assert_eq!(led(&mut tester), "green flashing");
        tester.pressure_mbar(100.0);
        tester.bring_up(&hex(MBAR), &hex(RELAYS));
        assert_eq!(led(&mut tester), "green");
        for fault in ["ram", "comm", "sensor1", "electronics1"] {
            tester.fault(fault, true);
            assert_eq!(led(&mut tester), "red", "{fault}");
            tester.fault(fault, false);
            assert_eq!(led(&mut tester), "green", "{fault}");
        }
        // A warning is no error: overrange.
        tester.pressure_mbar(2000.0);
        assert_eq!((tester.get(0, 26)[0], led(&mut tester)), (0xA0, "green"));
        tester.unlock();
        assert_eq!(led(&mut tester), "green flashing");
        tester.device().set_power(false);
        assert_eq!((led(&mut tester), tester.report().device_state.name()), ("off", "OFF"));
    }
    // The atmosphere sensor is in no exception detail (74).
    let mut gauge = gauge(pcg());
    gauge.operate(Action::Fault { fault: Fault::Sensor3, active: true }).unwrap();
    assert_eq!(gauge.report().led.name(), "green flashing");
}

/// (44): Clear ends no exchange and does not change the state.
#[test]
fn a_gauge_stays_in_executing_in_clear() {
    for kind in [pcg(), psg()] {
        let mut tester = exchanging(kind, CHANNEL, 100.0);
        // Global_Control, Clear_Data, all slaves.
        tester.request_sdn(&[0x02, 0x00]);
        tester.exchange(&[0; 8]);
        assert_eq!((tester.is_exchanging(), tester.state()), (true, EXECUTING));
    }
}
