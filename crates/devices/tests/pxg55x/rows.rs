//! Every row of tira56e1, by MS1, MS2 and parameter channel, and the tables as a text to compare with the manual.

use crate::pxg55x::{Gauge, gauge};
use crate::support::rows::{Kind as SampleKind, Rig, Sample};
use crate::support::{golden, sense_all};
use profivac_devices::SimulatedDevice;
use profivac_devices::model::Location;
use profivac_devices::pxg55x::Pxg55xModel;
use profivac_dp::slave::{Device, Relation};

/// Channel Instance Selector, where the address has an instance.
fn select(gauge: &mut Gauge, address: &Location) {
    if address.instance != 0 {
        gauge.write(Relation::Ms2(0), 1, 46, &[address.instance]).unwrap();
    }
}

/// The gauge with this number, in IDLE.
fn make<const NUMBER: usize>() -> Gauge {
    let mut gauge = gauge(Pxg55xModel::all().nth(NUMBER).unwrap());
    sense_all(&mut gauge, 1e-3);
    gauge.settle();
    gauge
}

fn rig<const NUMBER: usize>() -> Rig<Gauge> {
    let version = Pxg55xModel::all().nth(NUMBER).unwrap().variant();
    let family = version.family;
    Rig {
        model: &version.model,
        make: make::<NUMBER>,
        select,
        user: "00 00 00 13 08",
        cfgs: ["C6 87 8C 0A 0A 05 05 05 03", "C6 87 8E 0A 0A 05 05 05 08"],
        samples: samples(family.cdg.is_some(), family.atm.is_some()).leak(),
    }
}

fn value(at: (u8, u8, u8), good: &'static [&'static str], bad: &'static [&'static str]) -> Sample {
    Sample { at, good, bad, kind: SampleKind::Value }
}

fn presentation(at: (u8, u8, u8), good: &'static [&'static str], bad: &'static [&'static str]) -> Sample {
    Sample { at, good, bad, kind: SampleKind::Presentation }
}

fn command(at: (u8, u8, u8), good: &'static [&'static str], bad: &'static [&'static str]) -> Sample {
    Sample { at, good, bad, kind: SampleKind::Command }
}

/// The decimal codes of other devices are out of range (14), and so is micron (62).
const UNITS: &[&str] = &["10 01", "13 01", "13 09", "13 08"];
const NO_UNITS: &[&str] = &["00 00", "13 02", "03 E9", "05 15", "05 1C", "05 1D", "10 00", "FF FF"];
const TYPES: &[&str] = &["03", "08"];
const NO_TYPES: &[&str] = &["00", "02", "04", "05", "07", "09", "FF"];
const BOOLEANS: &[&str] = &["01", "00"];
const NO_BOOLEANS: &[&str] = &["02", "FF"];
const SAFE_STATES: &[&str] = &["01", "02", "03", "00"];
const NO_SAFE_STATES: &[&str] = &["04", "FF"];
/// 1.5, 1e-20, 0 and 123456; a number below zero, and NaN.
const PRESSURES: &[&str] = &["3F C0 00 00", "1E 3C E5 08", "00 00 00 00", "47 F1 20 00"];
const NO_PRESSURES: &[&str] = &["BF C0 00 00", "7F C0 00 00", "7F 80 00 00", "FF 80 00 00", "7F 7F FF FF"];
/// 0, 0.9 and 2.
const FACTORS: &[&str] = &["00 00 00 00", "3F 66 66 66", "40 00 00 00"];
const NO_FACTORS: &[&str] = &["BF 80 00 00", "7F C0 00 00", "7F 80 00 00"];
/// A command without a name is accepted and has no effect (79); a record of zeros is a zero adjust (78).
const ADJUSTMENTS: &[&str] = &["02 00", "FF FF", "00 00"];

/// Instances of slot 1.
fn instances(cdg: bool, atm: bool) -> std::ops::RangeInclusive<u8> {
    1..=1 + u8::from(cdg) + u8::from(atm)
}

/// Every writable row. The selector has the range of the instances (68).
fn samples(cdg: bool, atm: bool) -> Vec<Sample> {
    let pirani = if cdg { 2 } else { 1 };
    let mut samples = vec![
        command((0, 0, 15), &["00"], &["07", "7F", "82", "FF"]),
        value((1, pirani, 201), &["01", "02", "00"], &["03", "FF"]),
    ];
    samples.push(match (cdg, atm) {
        (_, true) => command((1, 0, 46), &["01", "02", "03"], &["00", "04", "FF"]),
        (true, false) => command((1, 0, 46), &["01", "02"], &["00", "03", "04", "FF"]),
        (false, false) => command((1, 0, 46), &["01"], &["00", "02", "03", "FF"]),
    });
    if cdg {
        samples.push(value((1, 1, 41), BOOLEANS, NO_BOOLEANS));
    }
    for instance in instances(cdg, atm) {
        samples.extend([
            command((1, instance, 15), ADJUSTMENTS, &[]),
            value((1, instance, 39), SAFE_STATES, NO_SAFE_STATES),
            value((1, instance, 40), PRESSURES, NO_PRESSURES),
            presentation((1, instance, 21), TYPES, NO_TYPES),
            presentation((1, instance, 22), UNITS, NO_UNITS),
        ]);
    }
    for slot in [2, 3] {
        samples.extend([
            value((slot, 0, 17), PRESSURES, NO_PRESSURES),
            value((slot, 0, 18), BOOLEANS, NO_BOOLEANS),
            value((slot, 0, 19), PRESSURES, NO_PRESSURES),
            value((slot, 0, 20), BOOLEANS, NO_BOOLEANS),
            value((slot, 0, 31), PRESSURES, NO_PRESSURES),
            value((slot, 0, 32), PRESSURES, NO_PRESSURES),
            value((slot, 0, 201), FACTORS, NO_FACTORS),
            presentation((slot, 0, 28), UNITS, NO_UNITS),
            presentation((slot, 0, 29), TYPES, NO_TYPES),
            // There is no mode 3; modes 1 and 2 need an atmosphere sensor (100).
            if atm {
                value((slot, 0, 202), &["01", "02", "04", "00"], &["03", "05", "FF"])
            } else {
                value((slot, 0, 202), &["04", "00"], &["01", "02", "03", "05", "FF"])
            },
        ]);
    }
    samples
}

/// The generated tests of one gauge.
macro_rules! rows {
    ($($gauge:ident $number:literal;)+) => { $(
        mod $gauge {
            use super::rig;

            #[test]
            fn every_row_is_read_as_marked() {
                rig::<$number>().every_row_is_read_as_marked();
            }

            #[test]
            fn no_row_is_written_without_a_mark_or_with_another_length() {
                rig::<$number>().no_row_is_written_without_a_mark_or_with_another_length();
            }

            #[test]
            fn other_slots_and_indices_are_refused() {
                rig::<$number>().other_slots_and_indices_are_refused();
            }

            #[test]
            fn the_samples_are_complete() {
                rig::<$number>().samples_are_complete();
            }

            #[test]
            fn every_value_is_checked_by_dpv1() {
                rig::<$number>().every_value_is_checked_by_dpv1();
            }

            #[test]
            fn every_value_is_checked_by_the_channel() {
                rig::<$number>().every_value_is_checked_by_the_channel();
            }

            #[test]
            fn nonvolatile_values_are_restored_after_power_up() {
                rig::<$number>().nonvolatile_values_are_restored_after_power_up();
            }
        }
    )+ };
}

rows! {
    pcg550_with_atm 0;
    pcg552_with_atm 1;
    pcg554_with_atm 2;
    pcg550 3;
    pcg552 4;
    pcg554 5;
    psg550 6;
    psg552 7;
    psg554 8;
}

/// (57), (89)
#[test]
fn the_tables_are_those_of_the_goldens() {
    let print = |number| golden::print(&Pxg55xModel::all().nth(number).unwrap().variant().model);
    for (first, name) in [(0, "pcg550-with-atm.txt"), (3, "pcg550.txt"), (6, "psg550.txt")] {
        golden::check(name, &print(first));
        // The models of a family differ in their names only.
        for (number, digit) in [(first + 1, "2"), (first + 2, "4")] {
            let text =
                print(number).replace(&format!("G55{digit} (p"), "G550 (p").replace(&format!("g55{digit})"), "g550)");
            assert_eq!(text, print(first));
        }
    }
}
