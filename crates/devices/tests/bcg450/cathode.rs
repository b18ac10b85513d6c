//! Emission and degas. tira41d1 3.3.3.5 to 3.3.3.9 and 2.3, (95) to (102).

use crate::bcg450::{COMMANDS, Gauge, exchanging, float, of_instance};
use crate::support::Tester;
use profivac_devices::{Action, SimulatedDevice, Switch};

/// Hot Cathode Block State Command.
fn command(tester: &mut Tester<Gauge>, command: u8, value: u8) -> Result<(), u8> {
    tester.put(1, 46, &[2]).unwrap();
    tester.put(1, 14, &[command, value])
}

/// Emission Status, Emission Current in mA, Degas Status and Emission User Mode State.
fn status(tester: &mut Tester<Gauge>) -> (u8, f32, u8, u8) {
    let [emission, degas, mode] = [105, 109, 201].map(|index| of_instance(tester, 2, index)[0]);
    (emission, float(tester, 2, 106), degas, mode)
}

const OFF: (u8, f32, u8, u8) = (0, 0.0, 0, 1);
const LOW: (u8, f32, u8, u8) = (1, 0.025, 0, 1);
const HIGH: (u8, f32, u8, u8) = (2, 5.0, 0, 1);
const DEGAS: (u8, f32, u8, u8) = (3, 20.0, 3, 1);

#[test]
fn the_automatic_mode_has_two_thresholds() {
    let mut tester = exchanging(COMMANDS, 1000.0);
    for (mbar, expected) in [
        (1000.0, OFF),
        (2.41e-2, OFF),
        (2.39e-2, LOW),
        (3.19e-2, LOW),
        (3.21e-2, OFF),
        (2.41e-2, OFF),
        (1e-5, LOW),
        (7.1e-6, HIGH),
        (1e-10, HIGH),
        // The hysteresis prevents noise from switching the current.
        (7.8e-6, HIGH),
        (8.0e-6, LOW),
        (7.3e-6, LOW),
    ] {
        tester.pressure_mbar(mbar);
        assert_eq!(status(&mut tester), expected, "{mbar} mbar");
    }
    tester.command(5).unwrap();
    assert_eq!(status(&mut tester), OFF, "only in EXECUTING (73)");
}

/// 128: automatic mode. Switched off by hand, it stays off until the pressure was above 3.2e-2 and then below 2.4e-2.
#[test]
fn emission_that_was_switched_off_stays_off_until_the_pressure_was_high() {
    let mut tester = exchanging(COMMANDS, 1e-4);
    command(&mut tester, 3, 0).unwrap();
    for (mbar, expected) in
        [(1e-4, OFF), (1e-6, OFF), (3e-2, OFF), (1e-6, OFF), (3.3e-2, OFF), (2.5e-2, OFF), (2.3e-2, LOW)]
    {
        tester.pressure_mbar(mbar);
        assert_eq!(status(&mut tester), expected, "{mbar} mbar");
    }
    command(&mut tester, 3, 0).unwrap();
    command(&mut tester, 3, 1).unwrap();
    assert_eq!(status(&mut tester), LOW, "and by hand on again");
}

/// (102): a write of the present mode is accepted and has no effect.
#[test]
fn automatic_mode_set_again_does_not_switch_the_emission_on() {
    let mut tester = exchanging(COMMANDS, 1e-4);
    command(&mut tester, 3, 0).unwrap();
    command(&mut tester, 128, 1).unwrap();
    assert_eq!(status(&mut tester), OFF, "automatic mode again");
    command(&mut tester, 128, 0).unwrap();
    command(&mut tester, 128, 1).unwrap();
    assert_eq!(status(&mut tester), LOW, "automatic mode anew");
}

/// 128: manual mode. Above 3.2e-2 mbar the emission goes off and stays off.
#[test]
fn the_gauge_never_switches_the_emission_on_in_manual_mode() {
    let mut tester = exchanging(COMMANDS, 1e-8);
    command(&mut tester, 128, 0).unwrap();
    let manual = |(emission, current, degas, _): (u8, f32, u8, u8)| (emission, current, degas, 0);
    assert_eq!(status(&mut tester), manual(HIGH), "the mode alone switches nothing");
    tester.pressure_mbar(1e-1);
    tester.pressure_mbar(1e-8);
    assert_eq!(status(&mut tester), manual(OFF));
    // The Pirani is active far below its range: (57), (81).
    assert_eq!(tester.exchange(&[0, 0]), crate::support::hex("A0 01 01 3B B4 39 58"));
    assert_eq!(of_instance(&mut tester, 2, 102), [3], "the BA counts as overrange without emission");
    assert_eq!(float(&mut tester, 2, 19), 2e-2);
    command(&mut tester, 3, 1).unwrap();
    assert_eq!(status(&mut tester), manual(HIGH));
    assert_eq!(tester.exchange(&[0, 0])[..3], [0x80, 0, 2]);
    command(&mut tester, 3, 0).unwrap();
    command(&mut tester, 128, 1).unwrap();
    assert_eq!(status(&mut tester), HIGH, "automatic again");
}

/// (102)
#[test]
fn emission_is_refused_above_the_limit_with_an_alarm_and_outside_executing() {
    let mut tester = exchanging(COMMANDS, 2.4e-2);
    assert_eq!(command(&mut tester, 3, 1), Err(202));
    assert_eq!(tester.put(1, 105, &[1]), Err(202));
    assert_eq!(command(&mut tester, 3, 0), Ok(()), "off is always accepted");
    assert_eq!(command(&mut tester, 3, 2), Err(2));
    tester.pressure_mbar(1e-3);
    for fault in ["sensor1", "sensor2", "electronics1", "electronics2"] {
        tester.fault(fault, true);
        assert_eq!(status(&mut tester), OFF, "{fault}");
        assert_eq!(command(&mut tester, 3, 1), Err(202), "{fault}");
        tester.fault(fault, false);
    }
    tester.fault("sensor3", true);
    assert_eq!(command(&mut tester, 3, 1), Ok(()), "the diaphragm does not matter");
    tester.fault("sensor3", false);
    tester.command(5).unwrap();
    assert_eq!(command(&mut tester, 3, 1), Err(202));
}

/// (97): Emission Status is written like command 3.
#[test]
fn emission_status_switches_the_emission() {
    let mut tester = exchanging(COMMANDS, 1e-4);
    tester.put(1, 46, &[2]).unwrap();
    tester.put(1, 105, &[0]).unwrap();
    assert_eq!(status(&mut tester), OFF);
    tester.put(1, 105, &[1]).unwrap();
    assert_eq!(status(&mut tester), LOW);
    assert_eq!(tester.put(1, 105, &[2]), Err(2));
}

/// (98)
#[test]
fn the_gauge_chooses_the_current() {
    let mut tester = exchanging(COMMANDS, 1e-4);
    tester.put(1, 46, &[2]).unwrap();
    tester.put(1, 106, &5.0f32.to_be_bytes()).unwrap();
    assert_eq!(status(&mut tester), LOW);
    assert_eq!(tester.put(1, 106, &1.0f32.to_be_bytes()), Err(2));
}

/// 3.3.3.9, (95)
#[test]
fn degas_runs_three_minutes_below_its_limit() {
    let mut tester = exchanging(COMMANDS, 7e-6);
    command(&mut tester, 1, 1).unwrap();
    assert_eq!(status(&mut tester), DEGAS);
    assert!(tester.report().degas.iter().all(|on| *on));
    tester.device().advance(100.0);
    command(&mut tester, 1, 1).unwrap();
    tester.device().advance(79.9);
    assert_eq!(status(&mut tester), DEGAS, "a running degas is not prolonged");
    tester.device().settle();
    assert_eq!(status(&mut tester), DEGAS, "and settling does not let time pass");
    tester.device().advance(0.2);
    assert_eq!(status(&mut tester), HIGH);
    command(&mut tester, 1, 1).unwrap();
    command(&mut tester, 1, 0).unwrap();
    assert_eq!(status(&mut tester), HIGH, "degas off");
}

/// (95), (96)
#[test]
fn a_degas_that_is_refused_because_of_the_pressure_sets_a_warning() {
    let mut tester = exchanging(COMMANDS, 7.2e-6);
    let warning = |tester: &mut Tester<Gauge>| of_instance(tester, 2, 104)[1];
    assert_eq!(warning(&mut tester), 0, "no degas is requested");
    assert_eq!(command(&mut tester, 1, 1), Err(202));
    assert_eq!(warning(&mut tester), 0x08);
    assert_eq!(tester.exchange(&[0, 0])[0], 0xA0);
    assert_eq!(of_instance(&mut tester, 2, 23), [1], "the reading stays valid");
    command(&mut tester, 1, 0).unwrap();
    assert_eq!(warning(&mut tester), 0, "degas off");
    assert_eq!(command(&mut tester, 1, 1), Err(202));
    tester.pressure_mbar(7.1e-6);
    assert_eq!(warning(&mut tester), 0, "below the limit");
    tester.pressure_mbar(1e-3);
    assert_eq!(warning(&mut tester), 0, "and forgotten");
    // A running degas continues above the limit, with the warning, until the emission goes off.
    tester.pressure_mbar(1e-7);
    command(&mut tester, 1, 1).unwrap();
    tester.pressure_mbar(1e-4);
    assert_eq!((status(&mut tester), warning(&mut tester)), (DEGAS, 0x08));
    tester.pressure_mbar(1e-1);
    assert_eq!((status(&mut tester), warning(&mut tester)), (OFF, 0));
}

#[test]
fn degas_needs_emission_and_executing() {
    let mut tester = exchanging(COMMANDS, 1e-7);
    command(&mut tester, 3, 0).unwrap();
    assert_eq!(command(&mut tester, 1, 1), Err(202));
    tester.command(5).unwrap();
    assert_eq!(command(&mut tester, 1, 1), Err(202));
    assert_eq!(command(&mut tester, 1, 0), Ok(()));
    assert_eq!(command(&mut tester, 1, 2), Err(2));
}

/// (96): the warning depends on the pressure alone. Without emission the Pirani measures it, far above the degas limit only.
#[test]
fn a_degas_that_is_refused_without_emission_sets_no_pressure_warning() {
    let mut tester = exchanging(COMMANDS, 1e-7);
    command(&mut tester, 128, 0).unwrap();
    command(&mut tester, 3, 0).unwrap();
    for (mbar, warning) in [(1e-7, 0), (1e-2, 8), (1e-7, 0)] {
        tester.pressure_mbar(mbar);
        assert_eq!(command(&mut tester, 1, 1), Err(202), "{mbar} mbar");
        assert_eq!(of_instance(&mut tester, 2, 104), [0, warning], "{mbar} mbar");
    }
    tester.command(5).unwrap();
    assert_eq!(command(&mut tester, 1, 1), Err(202));
    assert_eq!(of_instance(&mut tester, 2, 104), [0, 0], "outside EXECUTING");
}

/// Appendix C, pin 7
#[test]
fn the_degas_input_starts_and_stops_degas() {
    let mut tester = exchanging(COMMANDS, 1e-7);
    let input = |tester: &mut Tester<Gauge>, on| tester.device().operate(Action::Switch(Switch::Degas(on)));
    input(&mut tester, true).unwrap();
    assert_eq!(status(&mut tester), DEGAS);
    input(&mut tester, false).unwrap();
    assert_eq!(status(&mut tester), HIGH);
    tester.pressure_mbar(1e-4);
    input(&mut tester, true).unwrap();
    assert_eq!(status(&mut tester), LOW);
    assert_eq!(of_instance(&mut tester, 2, 104), [0, 8]);
}

/// 2.3, (101): the cyclic transition command is executed when the pair changes, for any selected instance.
#[test]
fn a_cyclic_command_takes_effect_when_it_changes() {
    let mut tester = exchanging(COMMANDS, 1e-7);
    tester.put(1, 46, &[6]).unwrap();
    let emission = |tester: &mut Tester<Gauge>| *tester.report().emission.iter().next().unwrap();
    assert_eq!(tester.exchange(&[3, 0])[..3], [0xA0, 0x01, 1], "the answer shows it already");
    assert!(!emission(&mut tester));
    assert_eq!(tester.get(1, 46), [6]);
    // After another master has switched on again, the unchanged command has no effect.
    command(&mut tester, 3, 1).unwrap();
    tester.exchange(&[3, 0]);
    assert!(emission(&mut tester));
    tester.exchange(&[0, 0]);
    tester.exchange(&[3, 0]);
    assert!(!emission(&mut tester), "0 arms it");
    tester.exchange(&[3, 1]);
    assert!(emission(&mut tester), "another pair needs no 0");
    tester.exchange(&[1, 1]);
    assert_eq!(status(&mut tester), DEGAS);
    // Refused and unknown commands are not reported.
    tester.exchange(&[77, 1]);
    tester.exchange(&[3, 9]);
    assert_eq!(status(&mut tester), DEGAS);
    tester.exchange(&[128, 0]);
    assert_eq!(status(&mut tester).3, 0, "manual mode");
}

/// (101): without outputs the command is 0.
#[test]
fn after_clear_the_same_cyclic_command_takes_effect_again() {
    let mut tester = exchanging(COMMANDS, 1e-7);
    tester.exchange(&[3, 0]);
    command(&mut tester, 3, 1).unwrap();
    // Global_Control, Clear_Data, all slaves.
    tester.request_sdn(&[0x02, 0x00]);
    tester.exchange(&[3, 0]);
    assert_eq!(status(&mut tester), OFF);
}
