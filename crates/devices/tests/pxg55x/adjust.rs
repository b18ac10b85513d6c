//! Zero and gain adjust, auto zero, Pirani OFF: 8.1.1, 8.1.11, 8.2.1, 8.3.1, 12.2.5, (78) to (80), (91), (107).

use crate::pxg55x::{FLOATS, Gauge, exchanging, executing, float, of_instance, pcg, psg, restart};
use crate::support::Tester;
use profivac_devices::SimulatedDevice;

/// AIBlockAdjust Command; the target value is ignored.
fn adjust(tester: &mut Tester<Gauge>, instance: u8, command: u8) -> Result<(), u8> {
    tester.put(1, 46, &[instance]).unwrap();
    tester.put(1, 15, &[command, 0x55])
}

/// The sensors of a PCG550 in this order, in mbar.
fn sense(tester: &mut Tester<Gauge>, cdg: f64, pirani: f64, atm: f64) {
    for (part, mbar) in [cdg, pirani, atm].into_iter().enumerate() {
        tester.device().sense(part, mbar * 100.0);
    }
}

fn close(found: f32, expected: f64) -> bool {
    (f64::from(found) - expected).abs() <= expected.abs() * 1e-6 + 1e-9
}

/// 8.1.1: "Used to calibrate diaphragm zero pressure value."
#[test]
fn a_zero_adjust_of_the_diaphragm_moves_its_zero() {
    let mut tester = executing(pcg(), 100.0);
    sense(&mut tester, 0.7, 1e-4, 1013.0);
    assert!(close(float(&mut tester, 1, 19), 0.7));
    adjust(&mut tester, 1, 0).unwrap();
    assert_eq!(float(&mut tester, 1, 19), 0.0);
    sense(&mut tester, 500.7, 500.0, 1013.0);
    assert!(close(float(&mut tester, 1, 19), 500.0));
    // Only the diaphragm is adjusted, and the adjustment is stored.
    assert!(close(float(&mut tester, 2, 19), 500.0));
    restart(&mut tester);
    tester.command(4).unwrap();
    assert!(close(float(&mut tester, 1, 19), 500.0));
}

/// 8.2.1: "Used to calibrate pirani zero pressure value", "... fullscale pressure value".
#[test]
fn the_adjustments_of_the_pirani_move_zero_and_gain() {
    for (kind, instance, part) in [(pcg(), 2, 1), (psg(), 1, 0)] {
        let mut tester = executing(kind, 100.0);
        tester.device().sense(part, 3e-3 * 100.0);
        adjust(&mut tester, instance, 0).unwrap();
        assert_eq!(float(&mut tester, instance, 19), 0.0);
        tester.device().sense(part, 870.0 * 100.0);
        adjust(&mut tester, instance, 1).unwrap();
        assert!(close(float(&mut tester, instance, 19), 1000.0));
        // The zero does not change.
        tester.device().sense(part, 3e-3 * 100.0);
        assert!(float(&mut tester, instance, 19) < 1e-9);
        restart(&mut tester);
        tester.command(4).unwrap();
        tester.device().sense(part, 870.0 * 100.0);
        assert!(close(float(&mut tester, instance, 19), 1000.0));
    }
}

/// 8.3.1: "the ATM sensor value will be set to the same value as at that time measured by the diaphragm gauge."
#[test]
fn the_atmosphere_sensor_is_set_to_the_diaphragm() {
    let mut tester = executing(pcg(), 100.0);
    sense(&mut tester, 1005.0, 1000.0, 990.0);
    adjust(&mut tester, 3, 1).unwrap();
    assert!(close(float(&mut tester, 3, 19), 1005.0));
    sense(&mut tester, 100.0, 100.0, 495.0);
    assert!(close(float(&mut tester, 3, 19), 502.5));
    assert!(close(float(&mut tester, 1, 19), 100.0));
}

/// 8.2.1 and 8.3.1, (164): "vent to atmosphere" comes first.
#[test]
fn a_gain_adjust_in_vacuum_is_refused_and_changes_nothing() {
    for (mbar, pirani, atm) in [
        (1e-3, Err(202), Err(202)),
        (99.0, Err(202), Err(202)),
        (101.0, Ok(()), Err(202)),
        (299.0, Ok(()), Err(202)),
        (301.0, Ok(()), Ok(())),
        (1201.0, Ok(()), Err(202)),
    ] {
        let mut tester = executing(pcg(), 100.0);
        sense(&mut tester, mbar, mbar, 1000.0);
        let before = [2, 3].map(|instance| float(&mut tester, instance, 19));
        assert_eq!([adjust(&mut tester, 2, 1), adjust(&mut tester, 3, 1)], [pirani, atm], "{mbar} mbar");
        let after = [2, 3].map(|instance| float(&mut tester, instance, 19));
        assert_eq!([before[0] == after[0], before[1] == after[1]], [pirani.is_err(), atm.is_err()], "{mbar} mbar");
    }
}

#[test]
fn commands_without_a_name_are_accepted_and_have_no_effect() {
    let mut tester = executing(pcg(), 100.0);
    sense(&mut tester, 100.0, 90.0, 1000.0);
    for (instance, commands) in [(1, 1..=255), (2, 2..=255), (3, 2..=255)] {
        for command in commands {
            assert_eq!(adjust(&mut tester, instance, command), Ok(()));
        }
    }
    // 0 is reserved for the atmosphere sensor (80).
    adjust(&mut tester, 3, 0).unwrap();
    assert_eq!([1, 2, 3].map(|instance| float(&mut tester, instance, 19)), [100.0, 90.0, 1000.0]);
    assert_eq!(tester.get(1, 15), [0, 0]);
}

#[test]
fn a_part_without_a_reading_is_not_adjusted() {
    let mut tester = executing(pcg(), 100.0);
    tester.fault("sensor1", true);
    assert_eq!([adjust(&mut tester, 1, 0), adjust(&mut tester, 3, 1)], [Err(202); 2]);
    tester.fault("sensor1", false);
    tester.put(1, 46, &[2]).unwrap();
    tester.put(1, 201, &[2]).unwrap();
    assert_eq!([adjust(&mut tester, 2, 0), adjust(&mut tester, 2, 1)], [Err(202); 2]);
    tester.put(1, 201, &[0]).unwrap();
    sense(&mut tester, 0.0, 0.0, 0.0);
    assert_eq!([adjust(&mut tester, 2, 1), adjust(&mut tester, 3, 1)], [Err(202); 2]);
    tester.command(2).unwrap();
    assert_eq!(adjust(&mut tester, 1, 0), Err(202));
}

/// A command is executed once and not stored (78).
#[test]
fn a_restart_adjusts_nothing() {
    let mut tester = executing(psg(), 100.0);
    adjust(&mut tester, 1, 1).unwrap();
    tester.pressure_mbar(50.0);
    restart(&mut tester);
    tester.command(4).unwrap();
    assert!(close(float(&mut tester, 1, 19), 500.0));
}

/// 8.1.11: "automatically and periodically".
#[test]
fn auto_zero_adjusts_the_diaphragm_while_the_pirani_reads_a_low_pressure() {
    let drifted = |enabled: bool, pirani: f64, seconds: f64, fault: &str| {
        let mut tester = executing(pcg(), 100.0);
        tester.put(1, 41, &[u8::from(enabled)]).unwrap();
        if !fault.is_empty() {
            tester.fault(fault, true);
        }
        sense(&mut tester, 0.3, pirani, 1013.0);
        tester.device().advance(seconds);
        tester.device().advance(seconds);
        tester.fault("sensor2", false);
        float(&mut tester, 1, 19) != 0.0
    };
    assert!(!drifted(true, 1e-3, 300.0, ""));
    assert!(!drifted(true, 0.01, 300.0, ""));
    assert!(drifted(true, 0.011, 300.0, ""), "above two decades below the range");
    assert!(drifted(true, 1e-3, 299.0, ""), "before the time");
    assert!(drifted(false, 1e-3, 10_000.0, ""), "not enabled");
    assert!(drifted(true, 1e-3, 300.0, "sensor2"), "no Pirani to trust");
}

/// 12.2.5
#[test]
fn a_pirani_that_is_off_has_no_reading() {
    let mut tester = exchanging(pcg(), FLOATS, 1e-2);
    assert_eq!(tester.exchange(&[])[..3], [0x80, 0, 2]);
    tester.put(1, 46, &[2]).unwrap();
    tester.put(1, 201, &[2]).unwrap();
    // The diaphragm stays active at any pressure, below its range here; its reading is invalid there.
    assert_eq!(tester.exchange(&[])[..3], [0xA0, 0x05, 1]);
    assert_eq!(of_instance(&mut tester, 2, 23), [0]);
    tester.pressure_mbar(5.0);
    assert_eq!(tester.exchange(&[])[..3], [0x80, 0, 1]);
    tester.put(1, 201, &[0]).unwrap();
    assert_eq!(tester.exchange(&[])[..3], [0x80, 0, 2]);
}

/// "1: Pirani switches off automatically (by default at pressures above 12 mbar ...)"
#[test]
fn the_automatic_mode_switches_the_pirani_off_above_12_mbar() {
    let mut tester = exchanging(pcg(), FLOATS, 1.0);
    tester.put(1, 46, &[2]).unwrap();
    tester.put(1, 201, &[1]).unwrap();
    for (mbar, valid) in [(1.0, 1), (11.9, 1), (12.0, 1), (12.1, 0), (1000.0, 0), (11.5, 0), (10.9, 1), (1.0, 1)] {
        tester.pressure_mbar(mbar);
        assert_eq!(of_instance(&mut tester, 2, 23), [valid], "{mbar} mbar");
        // The gauge continues to measure.
        assert_eq!(tester.exchange(&[])[..2], [0x80, 0], "{mbar} mbar");
    }
    // A PSG55x has nothing else (107): its reading is invalid, and not out of range.
    let mut tester = exchanging(psg(), FLOATS, 1.0);
    tester.put(1, 201, &[1]).unwrap();
    for (mbar, status) in [(12.0, [0x80, 0]), (12.1, [0xA0, 1]), (10.9, [0x80, 0])] {
        tester.pressure_mbar(mbar);
        assert_eq!(tester.exchange(&[])[..2], status, "{mbar} mbar");
    }
}
