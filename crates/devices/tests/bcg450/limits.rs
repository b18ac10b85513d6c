//! Full scale, overrange and underrange of every instance in every unit and type. tira41d1 3.2.2.6 to 3.2.4.10 and the
//! computed table of errata-bpg-bcg-tpg.

use crate::bcg450::{float, of_instance, tester};
use crate::support::hex;

/// COUNTS, Torr, Micron, mbar, Pascal
const UNITS: [&str; 5] = ["03 E9", "05 15", "05 16", "05 1C", "05 1D"];

/// Instance, index; as computed, then as printed (62), (63).
const LIMITS: [(u8, u8, [f64; 5], [f64; 5]); 9] = [
    (1, 24, [31000.0, 750.06168, 750061.68, 1000.0, 1e5], [31000.0, 750.06168, 750061.68, 1000.0, 1e5]),
    (1, 44, [31000.0, 750.06168, 750061.68, 1000.0, 1e5], [31000.0, 750.06168, 750061.68, 1000.0, 1e5]),
    (1, 45, [20480.7254, 0.0041253392, 4.1253392, 0.0055, 0.55], [20480.7254, 4.12534e-3, 4.12534, 5.5e-3, 0.55]),
    (2, 24, [21602.06, 0.0150012336, 15.0012336, 0.02, 2.0], [21602.0, 1.5e-2, 15.0, 2e-2, 2.0]),
    (2, 44, [21602.06, 0.0150012336, 15.0012336, 0.02, 2.0], [21602.0, 1.5e-2, 15.0, 2e-2, 2.0]),
    (2, 45, [6397.94, 3.7503084e-10, 3.7503084e-7, 5e-10, 5e-8], [6397.95, 3.7503e-10, 3.7503e-7, 5e-10, 5e-8]),
    (3, 24, [31352.1825, 1125.09252, 1125092.52, 1500.0, 1.5e5], [31352.0, 1125.09252, 1125092.0, 1500.0, 1.5e5]),
    (3, 44, [31352.1825, 1125.09252, 1125092.52, 1500.0, 1.5e5], [31352.0, 1125.09252, 1125092.0, 1500.0, 1.5e5]),
    (3, 45, [25000.0, 0.75006168, 750.06168, 1.0, 100.0], [25000.0, 0.75006168, 750.06168, 1.0, 100.0]),
];

#[test]
fn limits_are_exact_as_floats() {
    let mut tester = tester();
    for (position, unit) in UNITS.into_iter().enumerate() {
        tester.put(1, 22, &hex(unit)).unwrap();
        for (instance, index, computed, printed) in LIMITS {
            let value = f64::from(float(&mut tester, instance, index));
            let close = |other: f64, tolerance: f64| (value / other - 1.0).abs() < tolerance;
            let (computed, printed) = (computed[position], printed[position]);
            assert!(close(computed, 1e-7), "{instance} {index} {unit}: {value} instead of {computed}");
            assert!(close(printed, 1e-4), "{instance} {index} {unit}: {value}, printed {printed}");
        }
    }
}

/// (69), (70): cut to whole units, never above 32767.
#[test]
fn limits_are_truncated_and_saturated_as_integers() {
    let mut tester = tester();
    tester.put(1, 21, &[3]).unwrap();
    for (position, unit) in UNITS.into_iter().enumerate() {
        tester.put(1, 22, &hex(unit)).unwrap();
        for (instance, index, computed, _) in LIMITS {
            let word = u16::from_be_bytes(of_instance(&mut tester, instance, index).try_into().unwrap());
            assert_eq!(f64::from(word), computed[position].trunc().min(32767.0), "{instance} {index} {unit}");
        }
    }
}

/// (72): a write to one instance sets all.
#[test]
fn unit_and_type_are_those_of_the_device() {
    let mut tester = tester();
    for instance in [1, 2, 3, 5, 6] {
        for unit in UNITS {
            tester.put(1, 46, &[instance]).unwrap();
            tester.put(1, 22, &hex(unit)).unwrap();
            for other in [1, 2, 3, 5, 6] {
                assert_eq!(of_instance(&mut tester, other, 22), hex(unit));
            }
        }
        for number in [3, 8] {
            tester.put(1, 46, &[instance]).unwrap();
            tester.put(1, 21, &[number]).unwrap();
            for other in [1, 2, 3, 5, 6] {
                assert_eq!(of_instance(&mut tester, other, 21), [number]);
            }
        }
    }
}

/// Unit and type of the last exchange stay when it ends: 3.2.2.3, 3.2.2.4.
#[test]
fn the_exchange_overwrites_unit_and_type() {
    let mut tester = tester();
    tester.bring_up(&hex("00 00 00 05 15"), &hex("44 84 05 05 05 03"));
    tester.unlock();
    assert_eq!((tester.get(1, 22), tester.get(1, 21)), (hex("05 15"), vec![3]));
}

/// (91): both conditions hold.
#[test]
fn unit_and_type_change_in_idle_outside_the_exchange_only() {
    let mut tester = tester();
    let refused = |tester: &mut crate::support::Tester<crate::bcg450::Gauge>| {
        assert_eq!(tester.put(1, 21, &[3]), Err(17));
        assert_eq!(tester.put(1, 22, &hex("05 15")), Err(17));
        assert_eq!((tester.get(1, 22), tester.get(1, 21)), (hex("05 1C"), vec![8]));
    };
    tester.command(4).unwrap();
    refused(&mut tester);
    tester.bring_up(&hex("00 00 00 05 1C"), &hex("44 86 05 05 05 08"));
    tester.command(5).unwrap();
    refused(&mut tester);
    tester.unlock();
    tester.command(2).unwrap();
    refused(&mut tester);
    tester.command(3).unwrap();
    assert_eq!(tester.put(1, 22, &hex("05 15")), Ok(()));
}

/// (69): a float is the exact value of the formula, also below zero; zero means no pressure (74). (3): an
/// integer is never negative.
#[test]
fn a_float_in_counts_may_be_negative_and_an_integer_is_not() {
    for (cfg, below, above) in [("44 86 05 05 05 08", -1000.0, 1000.0), ("44 84 05 05 05 03", 0.0, 1000.0)] {
        let mut tester = tester();
        tester.bring_up(&hex("00 00 00 03 E9"), &hex(cfg));
        for (mbar, counts) in [(1e-12, above), (1e-13, below), (0.0, 0.0)] {
            tester.pressure_mbar(mbar);
            let inputs = tester.exchange(&[]);
            let value = match &inputs[3..] {
                [a, b, c, d] => f32::from_be_bytes([*a, *b, *c, *d]),
                [high, low] => i16::from_be_bytes([*high, *low]).into(),
                other => panic!("{other:02X?}"),
            };
            assert!((value - counts).abs() < 1e-3, "{value} counts at {mbar} mbar");
        }
    }
}
