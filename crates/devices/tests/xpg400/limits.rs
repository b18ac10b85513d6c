//! Full scale, overrange and underrange of every instance in every unit and type. tira36e1 3.2.2.6 to 3.2.3.10 and the
//! computed table of errata-bpg-bcg-tpg.

use crate::support::{Tester, hex};
use crate::xpg400::{Gauge, KINDS, float, of_instance, tester};
use profivac_devices::Potentiometer;
use profivac_devices::xpg400::Xpg400Model;

/// COUNTS, Torr, Micron, mbar, Pascal
const UNITS: [&str; 5] = ["03 E9", "05 15", "05 16", "05 1C", "05 1D"];

/// Instance, index; as computed, then as printed (61), (62), (63), (67), (68).
type Limit = (u8, u8, [f64; 5], [f64; 5]);

const BPG_PIRANI: [f64; 5] = [31000.0, 750.06168, 750061.68, 1000.0, 1e5];
const BA: [f64; 5] = [21602.06, 0.0150012336, 15.0012336, 0.02, 2.0];
const BPG: [Limit; 6] = [
    (1, 24, BPG_PIRANI, BPG_PIRANI),
    (1, 44, BPG_PIRANI, BPG_PIRANI),
    (1, 45, [20480.7254, 0.0041253392, 4.1253392, 0.0055, 0.55], [20480.7254, 4.12534e-3, 4.12534, 5.5e-3, 0.55]),
    (2, 24, BA, [21602.06, 1.5e-2, 15.0, 2e-2, 2.0]),
    (2, 44, BA, [21602.06, 1.5e-2, 15.0, 2e-2, 2.0]),
    (2, 45, [6397.94, 3.7503084e-10, 3.7503084e-7, 5e-10, 5e-8], [6397.95, 3.7503e-10, 3.7503e-7, 5e-10, 5e-8]),
];

const HPG_PIRANI: [f64; 5] = [30333.3333, 750.06168, 750061.68, 1000.0, 1e5];
const HP: [f64; 5] = [24333.3333, 0.75006168, 750.06168, 1.0, 100.0];
const HPG: [Limit; 6] = [
    (1, 24, HPG_PIRANI, [30333.0, 750.06168, 750061.68, 1000.0, 1e5]),
    (1, 44, HPG_PIRANI, [30333.0, 750.06168, 750061.68, 1000.0, 1e5]),
    (1, 45, [27000.0, 0.0075006168, 7.5006168, 0.01, 1.0], [27000.0, 7.50053e-3, 7.50053, 1e-2, 1.0]),
    (2, 24, HP, [24333.0, 7.5006168e-1, 7.5006168e2, 1.0, 100.0]),
    (2, 44, HP, [24333.0, 7.5006168e-1, 7.5006168e2, 1.0, 100.0]),
    (2, 45, [8333.3333, 7.5006168e-7, 7.5006168e-4, 1e-6, 1e-4], [8333.0, 7.5006168e-7, 7.5006168e-4, 1e-6, 1e-4]),
];

const fn limits(kind: Xpg400Model) -> &'static [Limit; 6] {
    match kind {
        Xpg400Model::Bpg => &BPG,
        Xpg400Model::Hpg => &HPG,
    }
}

#[test]
fn limits_are_exact_as_floats() {
    for kind in KINDS {
        let mut tester = tester(kind);
        for (position, unit) in UNITS.into_iter().enumerate() {
            tester.put(1, 22, &hex(unit)).unwrap();
            for (instance, index, computed, printed) in limits(kind) {
                let value = f64::from(float(&mut tester, *instance, *index));
                let close = |other: f64, tolerance: f64| (value / other - 1.0).abs() < tolerance;
                let (computed, printed) = (computed[position], printed[position]);
                assert!(close(computed, 1e-7), "{kind:?} {instance} {index} {unit}: {value}, not {computed}");
                assert!(close(printed, 1e-4), "{kind:?} {instance} {index} {unit}: {value}, printed {printed}");
            }
        }
    }
}

/// (69), (70): cut to whole units, never above 32767.
#[test]
fn limits_are_truncated_and_saturated_as_integers() {
    for kind in KINDS {
        let mut tester = tester(kind);
        tester.put(1, 21, &[3]).unwrap();
        for (position, unit) in UNITS.into_iter().enumerate() {
            tester.put(1, 22, &hex(unit)).unwrap();
            for (instance, index, computed, _) in limits(kind) {
                let word = u16::from_be_bytes(of_instance(&mut tester, *instance, *index).try_into().unwrap());
                let expected = computed[position].trunc().min(32767.0);
                assert_eq!(f64::from(word), expected, "{kind:?} {instance} {index} {unit}");
            }
        }
    }
}

/// The exponent of ten in mbar that COUNTS of an instance stand for.
type Formula = (Xpg400Model, u8, fn(f64) -> f64);

/// 3.2.2.1, 3.2.3.1, 3.2.4.1: what COUNTS mean on each scale (59, 64).
#[test]
fn counts_mean_the_pressure_of_the_printed_formulas() {
    let bpg: fn(f64) -> f64 = |counts| counts / 2000.0 - 12.5;
    let formulas: [Formula; 6] = [
        (Xpg400Model::Bpg, 1, bpg),
        (Xpg400Model::Bpg, 2, bpg),
        (Xpg400Model::Bpg, 3, bpg),
        (Xpg400Model::Hpg, 1, |counts| 6.0 * counts / 4000.0 - 42.5),
        (Xpg400Model::Hpg, 2, |counts| 6.0 * counts / 16000.0 - 9.125),
        (Xpg400Model::Hpg, 3, |counts| (counts - 22999.0) / 2444.0),
    ];
    for (kind, instance, exponent) in formulas {
        let mut tester = crate::xpg400::exchanging(kind, crate::xpg400::FLOATS, 1.3e-2);
        crate::xpg400::set_points::turn(&mut tester, Potentiometer::A, 5.0);
        let mbar = f64::from(float(&mut tester, instance, 19));
        tester.bring_up(&hex("00 00 00 03 E9"), &hex(crate::xpg400::FLOATS));
        let counts = f64::from(float(&mut tester, instance, 19));
        assert!((10f64.powf(exponent(counts)) / mbar - 1.0).abs() < 1e-4, "{kind:?} {instance}: {counts}, {mbar} mbar");
    }
}

/// (72): a write to one instance sets all.
#[test]
fn unit_and_type_are_those_of_the_device() {
    for kind in KINDS {
        let mut tester = tester(kind);
        for instance in 1..=4 {
            for unit in UNITS {
                tester.put(1, 46, &[instance]).unwrap();
                tester.put(1, 22, &hex(unit)).unwrap();
                for other in 1..=4 {
                    assert_eq!(of_instance(&mut tester, other, 22), hex(unit));
                }
            }
            for number in [3, 8] {
                tester.put(1, 46, &[instance]).unwrap();
                tester.put(1, 21, &[number]).unwrap();
                for other in 1..=4 {
                    assert_eq!(of_instance(&mut tester, other, 21), [number]);
                }
            }
        }
    }
}

/// Unit and type of the last exchange stay when it ends: 3.2.2.3, 3.2.2.4.
#[test]
fn the_exchange_overwrites_unit_and_type() {
    let mut tester = tester(Xpg400Model::Hpg);
    tester.bring_up(&hex("00 00 00 05 15"), &hex("44 84 05 05 05 03"));
    tester.unlock();
    assert_eq!((tester.get(1, 22), tester.get(1, 21)), (hex("05 15"), vec![3]));
}

/// (91): both conditions hold.
#[test]
fn unit_and_type_change_in_idle_outside_the_exchange_only() {
    let mut tester = tester(Xpg400Model::Bpg);
    let refused = |tester: &mut Tester<Gauge>| {
        assert_eq!(tester.put(1, 21, &[3]), Err(17));
        assert_eq!(tester.put(1, 22, &hex("05 15")), Err(17));
        assert_eq!((tester.get(1, 22), tester.get(1, 21)), (hex("05 1C"), vec![8]));
    };
    tester.command(4).unwrap();
    refused(&mut tester);
    tester.bring_up(&hex(crate::xpg400::MBAR), &hex(crate::xpg400::FLOATS));
    tester.command(5).unwrap();
    refused(&mut tester);
    tester.unlock();
    tester.command(2).unwrap();
    refused(&mut tester);
    tester.command(3).unwrap();
    assert_eq!(tester.put(1, 22, &hex("05 15")), Ok(()));
}
