//! The readings of every device in nitrogen, argon and helium from 1e-11 to 2000 mbar as tables, and their properties:
//! the switchover between the parts of a gauge, each with its own factor for the gas.

use super::{around, device, indicated, shown, start};
use crate::golden;
use profivac_vacuum::Gas;
use profivac_virtual::device::VirtualDevice;
use std::fmt::Write;

const GASES: [Gas; 3] = [Gas::N2, Gas::Ar, Gas::He];

/// 1, 2 and 5 of each decade from 1e-11 to 2000 mbar.
fn pressures() -> impl Iterator<Item = f64> {
    let digits = |decade| [1, 2, 5].map(|digit| format!("{digit}e{decade}").parse().unwrap());
    (-11..=3).flat_map(digits).filter(|mbar: &f64| *mbar <= 2000.0)
}

/// Compares a table with its golden.
fn check(name: &str, text: &str) {
    golden::compare(&format!("crates/virtual/tests/golden/sensors/{name}.txt"), text);
}

/// A device at the pressures of the tables.
fn sweep<T>(name: &str, gas: Gas, look: impl Fn(&VirtualDevice) -> T) -> Vec<T> {
    sweep_of(name, gas, pressures(), look)
}

/// The readings of a device at rising pressures of a gas.
pub fn sweep_of<T>(
    name: &str,
    gas: Gas,
    pressures: impl Iterator<Item = f64>,
    look: impl Fn(&VirtualDevice) -> T,
) -> Vec<T> {
    let mut device = device(name, 1e-11);
    start(&mut device);
    let look = |mbar| {
        device.settle_in(around(gas, mbar));
        // Filters of controllers, and delays of trip points.
        device.advance(60.0);
        look(&device)
    };
    pressures.map(look).collect()
}

fn table(title: &str, columns: &[String], rows: &[Vec<String>]) -> String {
    let mut text = format!("{title}\n{:>8}", "true");
    columns.iter().for_each(|column| write!(text, "{column:>14}").unwrap());
    for (index, mbar) in pressures().enumerate() {
        write!(text, "\n{:>8}", format!("{mbar:e}")).unwrap();
        rows.iter().for_each(|row| write!(text, "{:>14}", row[index]).unwrap());
    }
    text + "\n"
}

fn number(mbar: f64, valid: bool) -> String {
    format!("{mbar:.3e}{}", if valid { ' ' } else { '!' })
}

#[test]
fn gauges_of_one_value() {
    for name in ["pcg550", "psg550", "bpg400", "hpg400", "bcg450"] {
        let look = |device: &VirtualDevice| {
            let report = device.report();
            let of = report.indicated.iter().find(|it| it.instance == report.active_instance).unwrap();
            format!("{}{}", number(of.value_mbar, of.valid), of.instance)
        };
        let rows = GASES.map(|gas| sweep(name, gas, look));
        let title = format!("{name}, ideal sensors: mbar, ! where not valid, and the instance that measures");
        check(name, &table(&title, &GASES.map(|gas| gas.to_string()), &rows));
    }
}

#[test]
fn controllers() {
    for name in ["img400", "tpg500"] {
        let (mut columns, mut rows) = (Vec::new(), Vec::new());
        for gas in GASES {
            for instance in [1, 2, 3, 4].into_iter().filter(|it| name == "img400" || [1, 3].contains(it)) {
                let look = |device: &VirtualDevice| {
                    let report = device.report();
                    let of = *report.indicated.iter().find(|it| it.instance == instance).unwrap();
                    number(of.value_mbar, of.valid)
                };
                columns.push(format!("{gas} {instance}"));
                rows.push(sweep(name, gas, look));
            }
        }
        let title = format!("{name}, ideal sensors, channel by channel: mbar, ! where not valid");
        check(name, &table(&title, &columns, &rows));
    }
}

/// Gauges are calibrated with nitrogen.
#[test]
fn in_nitrogen_an_ideal_gauge_reads_the_true_pressure_over_its_whole_range() {
    for (name, low, high) in [
        ("pcg550", 5e-5, 1500.0),
        ("psg550", 5e-5, 1200.0),
        ("bpg400", 5e-10, 1000.0),
        ("hpg400", 1e-6, 1000.0),
        ("bcg450", 5e-10, 1500.0),
    ] {
        for (mbar, shown) in pressures().zip(sweep(name, Gas::N2, shown)) {
            if (low..=high).contains(&mbar) {
                assert!((shown / mbar - 1.0).abs() < 1e-12, "{name}: {shown} at {mbar} mbar");
            }
        }
    }
}

/// The reading divided by the true pressure.
fn ratio(device: &mut VirtualDevice, gas: Gas, mbar: f64) -> f64 {
    device.settle_in(around(gas, mbar));
    shown(device) / mbar
}

/// tira36e1 3.2.1.4: the switchover is at 5.5e-3 mbar of the Pirani, and each part has its own factor.
#[test]
fn a_gas_causes_a_step_at_the_switchover() {
    for (gas, ion, pirani) in [(Gas::Ar, 0.8, 1.7), (Gas::He, 5.9, 0.8), (Gas::N2, 1.0, 1.0)] {
        let mut gauge = device("bpg400", 1e-4);
        start(&mut gauge);
        let edge = 5.5e-3 * pirani;
        assert!((ratio(&mut gauge, gas, edge * 0.999) * ion - 1.0).abs() < 1e-9, "{gas}");
        assert!((ratio(&mut gauge, gas, edge * 1.001) * pirani - 1.0).abs() < 1e-9, "{gas}");
    }
}

/// tira41d1 3.2.1.3: the BCG450 joins its parts between 5.5e-3 and 2e-2 and between 1 and 10 mbar of the Pirani.
#[test]
fn between_two_joined_parts_the_factor_of_a_gas_changes_steadily() {
    for (gas, ion, pirani) in [(Gas::Ar, 0.8, 1.7), (Gas::He, 5.9, 0.8)] {
        let mut gauge = device("bcg450", 1e-4);
        start(&mut gauge);
        let mut at = |read_mbar: f64| ratio(&mut gauge, gas, read_mbar * pirani);
        let [below, low, middle, high, above] = [5e-3, 8e-3, 1.05e-2, 1.5e-2, 2.1e-2].map(&mut at);
        assert!((below * ion - 1.0).abs() < 1e-9 && (above * pirani - 1.0).abs() < 1e-9, "{gas}: {below} {above}");
        assert!((middle * (ion * pirani).sqrt() - 1.0).abs() < 0.01, "{gas}: {middle} in the middle");
        assert!([below, low, middle, high, above].is_sorted_by(|a, b| (a > b) == (ion < pirani)), "{gas}");
        // The diaphragm is active, which does not depend on the gas.
        gauge.settle_in(around(gas, 900.0));
        assert!((shown(&gauge) / 900.0 - 1.0).abs() < 1e-9, "{gas}: {}", shown(&gauge));
    }
}

/// tira56e1 9.1.2, errata-pxg55x-img400 67: the diaphragm measures from 10 mbar upwards, and keeps measuring down to 9
/// mbar.
#[test]
fn argon_causes_a_step_with_a_hysteresis_between_pirani_and_diaphragm() {
    let mut gauge = device("pcg550", 1.0);
    start(&mut gauge);
    for (mbar, active, low, high) in
        [(9.5, 2, 0.5, 0.6), (10.1, 1, 1.0, 1.0), (9.5, 1, 1.0, 1.0), (8.9, 2, 0.5, 0.6), (9.5, 2, 0.5, 0.6)]
    {
        let ratio = ratio(&mut gauge, Gas::Ar, mbar);
        assert_eq!(gauge.report().active_instance, active, "{mbar} mbar");
        assert!((low - 1e-9..high + 1e-9).contains(&ratio), "{mbar} mbar: {ratio}");
    }
}

/// During venting with argon a Pirani reads far too low, with helium far too high; the diaphragm reads the true pressure.
#[test]
fn at_atmosphere_only_the_diaphragm_reads_argon_correctly() {
    for (name, low, high) in [("psg550", 50.0, 200.0), ("bpg400", 50.0, 200.0), ("pcg550", 999.9, 1000.1)] {
        let mut gauge = device(name, 1000.0);
        start(&mut gauge);
        gauge.settle_in(around(Gas::Ar, 1000.0));
        assert!((low..high).contains(&shown(&gauge)), "{name}: {}", shown(&gauge));
    }
    let mut gauge = device("psg550", 1.0);
    start(&mut gauge);
    gauge.settle_in(around(Gas::He, 100.0));
    assert!(indicated(&gauge, 1) > 1000.0);
}
