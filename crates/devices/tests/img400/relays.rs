//! The seven trip points. BG 5530 4.4.3; errata-pxg55x-img400 32, 137 to 146.

use crate::img400::{COMMANDS, Controller, FLOATS, exchanging, float, put_float, tester};
use crate::support::{Tester, hex};

/// Indices of a trip block.
const LOW: u8 = 19;
const ENABLE: u8 = 20;
const STATUS: u8 = 21;
const HYSTERESIS: u8 = 24;
const CHANNEL: u8 = 27;
const UPPER: u8 = 201;

/// Units by their code, and a pressure of 1 hPa in them.
const UNITS: [(&str, f32); 4] = [("13 01", 0.750_061_7), ("13 02", 750.061_7), ("13 08", 1.0), ("13 09", 100.0)];

/// A relay on channel 4.
fn trip(tester: &mut Tester<Controller>, slot: u8, low: f32, upper: f32) {
    put_float(tester, slot, LOW, low).unwrap();
    put_float(tester, slot, UPPER, upper).unwrap();
    tester.put(slot, CHANNEL, &[4]).unwrap();
    tester.put(slot, ENABLE, &[1]).unwrap();
}

fn near(a: f32, b: f32) -> bool {
    (a - b).abs() <= 1e-5 * b.abs()
}

#[test]
fn a_relay_closes_below_the_trip_point_and_opens_above_the_upper_threshold() {
    for (unit, one) in UNITS {
        let mut tester = tester();
        tester.bring_up(&hex(&format!("00 00 00 {unit}")), &hex(COMMANDS));
        trip(&mut tester, 5, one, 2.0 * one);
        for (hpa, closed) in
            [(10.0, 0), (1.5, 0), (1.01, 0), (0.99, 1), (1.5, 1), (1.99, 1), (2.01, 0), (1.5, 0), (0.2, 1), (1000.0, 0)]
        {
            tester.pressure_mbar(hpa);
            assert_eq!(tester.get(5, STATUS), [closed], "{hpa} hPa, unit {unit}");
            // Relay 1 is the first octet behind Channel Status.
            assert_eq!(tester.exchange(&[0, 0])[19..], [closed, 0, 0, 0, 0, 0, 0], "{hpa} hPa, unit {unit}");
        }
    }
}

#[test]
fn every_relay_has_its_own_trip_point() {
    // Slot = relay + 4 (145)
    let mut tester = exchanging(COMMANDS, 5.0);
    for relay in 1..=7u8 {
        trip(&mut tester, relay + 4, 10f32.powi(i32::from(relay)), 10f32.powi(i32::from(relay) + 1));
    }
    for hpa in [5.0, 50.0, 500.0] {
        tester.pressure_mbar(1e9);
        tester.pressure_mbar(hpa);
        let expected: Vec<u8> = (1..=7).map(|relay| u8::from(hpa < 10f64.powi(relay))).collect();
        assert_eq!(tester.exchange(&[0, 0])[19..], expected, "{hpa} hPa");
        let report = tester.report();
        assert!(report.relays.iter().map(|closed| u8::from(*closed)).eq(expected), "{hpa} hPa");
    }
}

#[test]
fn a_relay_needs_enable_and_a_reading() {
    let mut tester = exchanging(FLOATS, 1e-6);
    trip(&mut tester, 6, 1e-3, 2e-3);
    assert_eq!(tester.get(6, STATUS), [1]);
    tester.put(6, ENABLE, &[0]).unwrap();
    assert_eq!(tester.get(6, STATUS), [0]);
    tester.put(6, ENABLE, &[1]).unwrap();
    assert_eq!(tester.get(6, STATUS), [1]);
    // A gauge that is off or missing has no pressure (144).
    tester.put(6, CHANNEL, &[1]).unwrap();
    assert_eq!(tester.get(6, STATUS), [0]);
    tester.put(1, 105, &[1]).unwrap();
    assert_eq!(tester.get(6, STATUS), [1]);
    tester.fault("unplugged1", true);
    assert_eq!(tester.get(6, STATUS), [0]);
}

#[test]
fn hysteresis_and_upper_threshold_follow_each_other() {
    // ID 201 = ID 19 + ID 24 (138, 140)
    let mut tester = exchanging(FLOATS, 1.0);
    for (unit, _) in UNITS {
        tester.unlock();
        tester.bring_up(&hex(&format!("00 00 00 {unit}")), &hex(FLOATS));
        for slot in 5..=11 {
            put_float(&mut tester, slot, LOW, 2.0).unwrap();
            put_float(&mut tester, slot, UPPER, 5.0).unwrap();
            assert!(near(float(&mut tester, slot, HYSTERESIS), 3.0));
            put_float(&mut tester, slot, HYSTERESIS, 1.0).unwrap();
            assert!(near(float(&mut tester, slot, UPPER), 3.0));
            put_float(&mut tester, slot, LOW, 10.0).unwrap();
            assert!(near(float(&mut tester, slot, HYSTERESIS), 1.0), "hysteresis stays");
            assert!(near(float(&mut tester, slot, UPPER), 11.0));
            // (141)
            assert_eq!(put_float(&mut tester, slot, UPPER, 9.0), Err(2));
            assert!(near(float(&mut tester, slot, UPPER), 11.0));
            put_float(&mut tester, slot, UPPER, 10.0).unwrap();
            assert_eq!(float(&mut tester, slot, HYSTERESIS), 0.0);
        }
    }
}

#[test]
fn hysteresis_in_counts_is_a_factor() {
    // (32): 4000 counts are a decade.
    let mut tester = exchanging(FLOATS, 1.0);
    tester.unlock();
    tester.bring_up(&hex("00 00 00 10 01"), &hex(FLOATS));
    put_float(&mut tester, 5, LOW, 50_000.0).unwrap();
    put_float(&mut tester, 5, HYSTERESIS, 4000.0).unwrap();
    assert!(near(float(&mut tester, 5, UPPER), 54_000.0));
    put_float(&mut tester, 5, LOW, 46_000.0).unwrap();
    assert!(near(float(&mut tester, 5, UPPER), 50_000.0));
    assert!(near(float(&mut tester, 5, HYSTERESIS), 4000.0));
    tester.unlock();
    tester.bring_up(&hex("00 00 00 13 08"), &hex(FLOATS));
    assert!(near(float(&mut tester, 5, LOW), 0.1));
    assert!(near(float(&mut tester, 5, UPPER), 1.0));
    assert!(near(float(&mut tester, 5, HYSTERESIS), 0.9));
}

#[test]
fn all_blocks_show_the_same_unit_and_type() {
    // (142)
    let mut tester = exchanging(FLOATS, 1.0);
    for slot in 5..=11 {
        assert_eq!(tester.get(slot, 28), [0x13, 0x08]);
        assert_eq!(tester.get(slot, 29), [8]);
        assert_eq!(tester.put(slot, 28, &[0x13, 0x01]), Err(1));
        assert_eq!(tester.put(slot, 29, &[3]), Err(1));
    }
    tester.unlock();
    tester.put(3, 21, &[3]).unwrap();
    for slot in 5..=11 {
        assert_eq!(tester.get(slot, 29), [3]);
        // 1e-3 hPa is no whole hPa.
        assert_eq!(tester.get(slot, LOW), [0, 0]);
    }
}
