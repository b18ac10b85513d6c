//! Safe state and safe value. tira36e1 3.2.2.7, 3.2.2.8, (74) to (76).

use crate::support::hex;
use crate::xpg400::{FLOATS, KINDS, exchanging, float, float_of, of_instance, tester};
use profivac_devices::SimulatedDevice;
use profivac_devices::xpg400::Xpg400Model;

/// 3.2.1.4, 3.2.2.7: the safe value belongs to the part that measured last and replaces its value in the cyclic data
/// (74).
#[test]
fn each_safe_state_shows_its_value_outside_executing() {
    for (kind, full_scale) in [(Xpg400Model::Bpg, 2e-2), (Xpg400Model::Hpg, 1.0)] {
        let mut tester = exchanging(kind, FLOATS, 2e-3);
        assert_eq!(float_of(&tester.exchange(&[])[3..]), 2e-3);
        tester.put(1, 46, &[2]).unwrap();
        tester.put(1, 40, &hex("42 F6 00 00")).unwrap();
        for command in [5, 2] {
            tester.command(command).unwrap();
            tester.pressure_mbar(500.0);
            for (mode, value) in [(0, 0.0), (1, full_scale), (2, 2e-3), (3, 123.0)] {
                tester.put(1, 39, &[mode]).unwrap();
                let du = tester.exchange(&[]);
                assert_eq!(du[..3], [0xA0, 0x01, 2], "mode {mode}");
                assert_eq!(float_of(&du[3..]), value, "mode {mode}");
                assert_eq!(float(&mut tester, 2, 19), value, "mode {mode} acyclically");
                assert_eq!(of_instance(&mut tester, 2, 23), [0], "Reading Valid");
            }
        }
        // Before the first measurement there is no last value, and without emission only the Pirani has a reading (80).
        tester.device().set_power(false);
        tester.device().set_power(true);
        assert_eq!(tester.get(1, 47), [1]);
        assert_eq!(float(&mut tester, 1, 19), 0.0);
    }
}

#[test]
fn every_instance_has_its_own_mode_and_value() {
    for (kind, full_scale) in [(Xpg400Model::Bpg, 2e-2), (Xpg400Model::Hpg, 1.0)] {
        let mut tester = tester(kind);
        for (instance, value) in [(1, "3F 80 00 00"), (2, "40 00 00 00")] {
            tester.put(1, 46, &[instance]).unwrap();
            tester.put(1, 40, &hex(value)).unwrap();
            tester.put(1, 39, &[3]).unwrap();
        }
        assert_eq!([1, 2].map(|instance| float(&mut tester, instance, 19)), [1.0, 2.0]);
        tester.put(1, 46, &[2]).unwrap();
        tester.put(1, 39, &[1]).unwrap();
        assert_eq!([1, 2].map(|instance| float(&mut tester, instance, 19)), [1.0, full_scale]);
    }
}

#[test]
fn the_last_valid_value_is_held_until_power_off() {
    let mut tester = exchanging(Xpg400Model::Bpg, FLOATS, 7.0);
    tester.put(1, 46, &[1]).unwrap();
    tester.put(1, 39, &[2]).unwrap();
    // The value is not valid, so it is not kept.
    tester.pressure_mbar(1013.0);
    tester.command(2).unwrap();
    tester.pressure_mbar(500.0);
    assert_eq!(float(&mut tester, 1, 19), 7.0);
    tester.device().set_power(false);
    tester.device().set_power(true);
    assert_eq!(float(&mut tester, 1, 19), 0.0);
}

/// (75): alarms set the safe state; warnings and the range do not.
#[test]
fn a_sensor_alarm_concerns_its_own_part_a_common_one_all() {
    for kind in KINDS {
        let mut tester = exchanging(kind, FLOATS, 5.0);
        tester.fault("sensor2", true);
        assert_eq!([1, 2].map(|instance| float(&mut tester, instance, 19)), [5.0, 0.0]);
        assert!(!tester.report().outputs_safe, "the Pirani is active");
        tester.fault("sensor2", false);
        for fault in ["eeprom", "ram", "eprom", "comm", "sensor1"] {
            tester.fault(fault, true);
            assert_eq!(float(&mut tester, 1, 19), 0.0, "{fault}");
            assert!(tester.report().outputs_safe, "{fault}");
            tester.fault(fault, false);
            assert_eq!(float(&mut tester, 1, 19), 5.0, "{fault} gone");
        }
        tester.fault("pirani-adjust", true);
        tester.pressure_mbar(1013.0);
        assert_eq!(float(&mut tester, 1, 19), 1013.0);
    }
}

#[test]
fn a_safe_value_follows_the_unit_of_its_scale_and_zero_stays_zero() {
    for (kind, counts) in [(Xpg400Model::Bpg, 27000.0), (Xpg400Model::Hpg, 29000.0)] {
        let mut tester = tester(kind);
        tester.put(1, 46, &[1]).unwrap();
        tester.put(1, 40, &hex("41 20 00 00")).unwrap();
        for (unit, value) in
            [("03 E9", counts), ("05 15", 7.500_617), ("05 16", 7500.617), ("05 1D", 1000.0), ("05 1C", 10.0)]
        {
            tester.put(1, 22, &hex(unit)).unwrap();
            let read: f32 = float(&mut tester, 1, 40);
            assert!((read / value - 1.0).abs() < 1e-6, "{kind:?} {unit}: {read}");
            assert_eq!(float(&mut tester, 2, 40), 0.0, "{unit}");
        }
    }
}
