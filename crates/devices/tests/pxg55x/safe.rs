//! Safe State and Safe Value: 8.1.9, 8.1.10, (32) to (35).

use crate::pxg55x::{CHANNEL, FLOATS, exchanging, float, float_of, of_instance, pcg, psg};

fn process_value(tester: &mut crate::support::Tester<crate::pxg55x::Gauge>) -> f32 {
    float_of(&tester.exchange(&[])[3..])
}

/// The value of each mode at 100 mbar after a last valid value of 50 mbar; Safe Value is 7 mbar.
#[test]
fn each_safe_state_shows_its_value_outside_executing_and_with_an_alarm() {
    for (kind, full_scale) in [(pcg(), 1500.0), (psg(), 1000.0)] {
        for (mode, value) in [(0, 0.0), (1, full_scale), (2, 50.0), (3, 7.0)] {
            for fault in ["", "ram", "comm", "sensor1", "electronics1"] {
                let mut tester = exchanging(kind, FLOATS, 50.0);
                tester.put(1, 39, &[mode]).unwrap();
                tester.put(1, 40, &7f32.to_be_bytes()).unwrap();
                if fault.is_empty() {
                    tester.command(5).unwrap();
                } else {
                    tester.fault(fault, true);
                }
                tester.pressure_mbar(100.0);
                assert!(tester.report().outputs_safe, "{fault}");
                assert_eq!(process_value(&mut tester), value, "mode {mode}, {fault:?}");
            }
        }
    }
}

#[test]
fn before_the_first_valid_value_hold_last_value_is_zero() {
    let mut tester = crate::pxg55x::tester(psg());
    tester.pressure_mbar(100.0);
    tester.put(1, 39, &[2]).unwrap();
    assert_eq!(float(&mut tester, 1, 19), 0.0);
}

#[test]
fn warnings_and_range_do_not_set_the_error_bit() {
    let mut tester = exchanging(psg(), FLOATS, 1300.0);
    assert_eq!((process_value(&mut tester), tester.report().outputs_safe), (1300.0, false));
}

/// An alarm of one sensor does not concern the others (35).
#[test]
fn every_instance_has_its_own_safe_state() {
    let mut tester = exchanging(pcg(), CHANNEL, 100.0);
    for (instance, mode) in [(1, 1), (2, 3), (3, 1)] {
        tester.put(1, 46, &[instance]).unwrap();
        tester.put(1, 39, &[mode]).unwrap();
    }
    tester.fault("sensor3", true);
    assert_eq!([1, 2, 3].map(|it| float(&mut tester, it, 19)), [100.0, 100.0, 1200.0]);
    tester.fault("electronics1", true);
    assert_eq!([1, 2, 3].map(|it| float(&mut tester, it, 19)), [1500.0, 100.0, 1200.0]);
    tester.command(5).unwrap();
    assert_eq!([1, 2, 3].map(|it| float(&mut tester, it, 19)), [1500.0, 0.0, 1200.0]);
}

/// "If this value is set to zero, it will remain on zero when the data unit is changed."
#[test]
fn a_safe_value_is_converted_but_zero_stays_zero() {
    let mut tester = crate::pxg55x::tester(psg());
    tester.put(1, 40, &1000f32.to_be_bytes()).unwrap();
    for (unit, value) in [([0x13, 0x01], 750.061_7), ([0x13, 0x09], 100_000.0), ([0x10, 0x01], 31_672.326)] {
        tester.put(1, 22, &unit).unwrap();
        let found = float(&mut tester, 1, 40);
        assert!((found / value - 1.0).abs() < 1e-6, "{found} instead of {value}");
    }
    tester.put(1, 40, &[0; 4]).unwrap();
    for unit in [[0x13, 0x08], [0x13, 0x01], [0x13, 0x09], [0x10, 0x01]] {
        tester.put(1, 22, &unit).unwrap();
        assert_eq!(of_instance(&mut tester, 1, 40), [0; 4], "{unit:02X?}");
    }
}
