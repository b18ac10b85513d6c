//! Safe state and safe value. tira41d1 3.2.2.7, 3.2.2.8, (74) to (76).

use crate::bcg450::{FLOATS, exchanging, float, of_instance, tester};
use crate::support::hex;
use profivac_devices::SimulatedDevice;

/// The process value of the last cycle.
fn cyclic(du: &[u8]) -> f32 {
    f32::from_be_bytes(du[3..].try_into().unwrap())
}

/// 3.2.1.3, 3.2.2.7: the safe value belongs to the part that measured last and replaces its value in the cyclic data
/// (74).
#[test]
fn each_safe_state_shows_its_value_outside_executing() {
    for (pressure, instance, full_scale) in [(2e-3, 2, 2e-2), (0.5, 1, 1000.0), (50.0, 3, 1500.0)] {
        let mut tester = exchanging(FLOATS, pressure);
        assert_eq!(cyclic(&tester.exchange(&[])), pressure as f32);
        tester.put(1, 46, &[instance]).unwrap();
        tester.put(1, 40, &hex("42 F6 00 00")).unwrap();
        for command in [5, 2] {
            tester.command(command).unwrap();
            tester.pressure_mbar(0.1);
            for (mode, value) in [(0, 0.0), (1, full_scale), (2, pressure as f32), (3, 123.0)] {
                tester.put(1, 39, &[mode]).unwrap();
                let du = tester.exchange(&[]);
                assert_eq!(du[..3], [0xA0, 0x01, instance], "mode {mode}");
                assert_eq!(cyclic(&du), value, "mode {mode}");
                assert_eq!(float(&mut tester, instance, 19), value, "mode {mode} acyclically");
                assert_eq!(of_instance(&mut tester, instance, 23), [0], "Reading Valid");
            }
        }
        // Before the first measurement there is no last value, and without emission there is no BA reading (80).
        tester.put(1, 39, &[2]).unwrap();
        tester.device().set_power(false);
        tester.device().set_power(true);
        assert_eq!(tester.get(1, 47), [1]);
        assert_eq!(float(&mut tester, 1, 19), 0.0);
    }
}

#[test]
fn every_instance_has_its_own_mode_and_value() {
    let mut tester = tester();
    for (instance, value) in [(1, "3F 80 00 00"), (2, "40 00 00 00"), (3, "40 40 00 00")] {
        tester.put(1, 46, &[instance]).unwrap();
        tester.put(1, 40, &hex(value)).unwrap();
        tester.put(1, 39, &[3]).unwrap();
    }
    assert_eq!([1, 2, 3].map(|instance| float(&mut tester, instance, 19)), [1.0, 2.0, 3.0]);
    tester.put(1, 46, &[2]).unwrap();
    tester.put(1, 39, &[1]).unwrap();
    assert_eq!([1, 2, 3].map(|instance| float(&mut tester, instance, 19)), [1.0, 2e-2, 3.0]);
}

#[test]
fn the_last_valid_value_of_each_instance_is_held() {
    let mut tester = exchanging(FLOATS, 5.0);
    tester.put(1, 46, &[1]).unwrap();
    tester.put(1, 39, &[2]).unwrap();
    tester.put(1, 46, &[3]).unwrap();
    tester.put(1, 39, &[2]).unwrap();
    tester.pressure_mbar(7.0);
    tester.command(2).unwrap();
    tester.pressure_mbar(500.0);
    assert_eq!(tester.state(), 5);
    assert_eq!(float(&mut tester, 3, 19), 7.0);
    assert_eq!(float(&mut tester, 1, 19), 7.0);
    // It is lost with the power (76).
    tester.device().set_power(false);
    tester.device().set_power(true);
    assert_eq!(float(&mut tester, 3, 19), 0.0);
}

#[test]
fn a_sensor_alarm_concerns_its_own_part_a_common_one_all() {
    let mut tester = exchanging(FLOATS, 5.0);
    tester.fault("sensor1", true);
    assert_eq!(float(&mut tester, 1, 19), 0.0);
    assert_eq!(float(&mut tester, 3, 19), 5.0, "the diaphragm goes on");
    assert!(!tester.report().outputs_safe, "the diaphragm is active");
    tester.fault("sensor1", false);
    for fault in ["eeprom", "ram", "eprom", "comm"] {
        tester.fault(fault, true);
        assert_eq!([1, 3].map(|instance| float(&mut tester, instance, 19)), [0.0, 0.0], "{fault}");
        assert!(tester.report().outputs_safe, "{fault}");
        assert_eq!(tester.state(), 4, "{fault}");
        tester.fault(fault, false);
        assert_eq!(float(&mut tester, 3, 19), 5.0, "{fault} gone");
    }
    // Warnings and the range do not set the safe state.
    tester.fault("pirani-adjust", true);
    tester.pressure_mbar(2000.0);
    assert_eq!(float(&mut tester, 3, 19), 2000.0);
}

#[test]
fn a_safe_value_follows_the_unit_and_zero_stays_zero() {
    let mut tester = tester();
    tester.put(1, 46, &[1]).unwrap();
    tester.put(1, 40, &hex("41 20 00 00")).unwrap();
    // COUNTS, Torr, Micron, Pascal, mbar
    for (unit, value) in
        [("03 E9", 27000.0), ("05 15", 7.500_617), ("05 16", 7500.617), ("05 1D", 1000.0), ("05 1C", 10.0)]
    {
        tester.put(1, 22, &hex(unit)).unwrap();
        let read: f32 = float(&mut tester, 1, 40);
        assert!((read / value - 1.0).abs() < 1e-6, "{unit}: {read}");
        assert_eq!(float(&mut tester, 2, 40), 0.0, "{unit}");
    }
    // As an integer it is in whole units, when read and when written.
    tester.put(1, 21, &[3]).unwrap();
    assert_eq!(of_instance(&mut tester, 1, 40), hex("00 0A"));
    tester.put(1, 40, &hex("00 07")).unwrap();
    assert_eq!(of_instance(&mut tester, 1, 40), hex("00 07"));
    assert_eq!(tester.put(1, 40, &hex("80 00")), Err(2));
}

/// 3.2.2.7: "can be freely defined by the user"; no manual gives a range.
#[test]
fn a_safe_value_takes_every_pressure_and_no_other_number() {
    let mut tester = tester();
    let mut put = |number: f32| tester.put(1, 40, &number.to_be_bytes());
    assert_eq!([0.0, 1e-13, 1e-30, 2000.0, 1e20].map(&mut put), [Ok(()); 5]);
    assert_eq!([-1e-13, -1.0, f32::MAX, f32::INFINITY, f32::NAN].map(&mut put), [Err(2); 5]);
    assert_eq!(float(&mut tester, 1, 40), 1e20, "refused values change nothing");
    // A very low pressure has COUNTS below zero, and the value that is read can be written.
    tester.put(1, 40, &1e-13f32.to_be_bytes()).unwrap();
    tester.put(1, 22, &hex("03 E9")).unwrap();
    let counts = float(&mut tester, 1, 40);
    assert!((counts + 1000.0).abs() < 1e-2, "{counts}");
    tester.put(1, 40, &counts.to_be_bytes()).unwrap();
    tester.put(1, 22, &hex("05 1C")).unwrap();
    assert!((float(&mut tester, 1, 40) / 1e-13 - 1.0).abs() < 1e-4);
}
