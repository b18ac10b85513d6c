//! Every row of tira36e1, by MS1, MS2 and parameter channel, and the tables as a text to compare with the manual.

use crate::support::rows::{Kind::Command, Kind::Presentation, Kind::Value, Rig, Sample};
use crate::support::{golden, rows, sense_all};
use crate::xpg400::{Gauge, KINDS, gauge};
use profivac_devices::SimulatedDevice;
use profivac_devices::model::Location;
use profivac_devices::xpg400::Xpg400Model;
use profivac_dp::slave::{Device, Relation};

fn rigs() -> [Rig<Gauge>; 2] {
    [
        rig(Xpg400Model::Bpg, || settled(Xpg400Model::Bpg), &SAMPLES),
        // The HPG400-SP has neither degas command nor emission current (94).
        rig(Xpg400Model::Hpg, || settled(Xpg400Model::Hpg), &SAMPLES[2..]),
    ]
}

fn rig(kind: Xpg400Model, make: fn() -> Gauge, samples: &'static [Sample]) -> Rig<Gauge> {
    Rig {
        model: &kind.variant().model,
        make,
        select,
        user: "00 00 00 05 1C",
        cfgs: ["C6 87 8C 0A 0A 05 05 05 03", "C6 87 8E 0A 0A 05 05 05 08"],
        samples,
    }
}

fn settled(kind: Xpg400Model) -> Gauge {
    let mut gauge = gauge(kind);
    sense_all(&mut gauge, 1e-3);
    gauge.settle();
    gauge
}

/// Channel Instance Selector, where the address has an instance.
fn select(gauge: &mut Gauge, address: &Location) {
    if address.instance != 0 {
        gauge.write(Relation::Ms2(0), 1, 46, &[address.instance]).unwrap();
    }
}

const fn sample(
    kind: rows::Kind,
    at: (u8, u8, u8),
    good: &'static [&'static str],
    bad: &'static [&'static str],
) -> Sample {
    Sample { at, good, bad, kind }
}

/// errata-bpg-bcg-tpg 5: the hexadecimal codes of other devices are out of range.
const UNITS: &[&str] = &["03 E9", "05 15", "05 16", "05 1D", "05 1C"];
const NO_UNITS: &[&str] = &["00 00", "10 01", "13 01", "13 02", "13 08", "13 09", "05 17", "FF FF"];
const TYPES: &[&str] = &["03", "08"];
const NO_TYPES: &[&str] = &["00", "02", "04", "05", "07", "09", "FF"];
const SAFE_STATES: &[&str] = &["01", "02", "03", "00"];
const NO_SAFE_STATES: &[&str] = &["04", "FF"];
/// 1.5, 1e-20, 0 and 123456; a number below zero, and NaN.
const PRESSURES: &[&str] = &["3F C0 00 00", "1E 3C E5 08", "00 00 00 00", "47 F1 20 00"];
const NO_PRESSURES: &[&str] = &["BF C0 00 00", "7F C0 00 00", "7F 80 00 00", "FF 80 00 00", "7F 7F FF FF"];
const COMMANDS: &[&str] = &["00 00", "00 07", "01 00"];
/// Emission and user mode are commands of the BCG450-SP.
const NO_COMMANDS: &[&str] = &["01 02", "02 00", "03 00", "03 01", "80 00", "FF 00"];
/// 0, 0.025, 5 and 20 mA
const CURRENTS: &[&str] = &["00 00 00 00", "3C CC CC CD", "40 A0 00 00", "41 A0 00 00"];
const NO_CURRENTS: &[&str] = &["3F 80 00 00", "7F C0 00 00"];

/// Type and unit last, so that pressures are floats in mbar during the test.
const SAMPLES: [Sample; 18] = [
    sample(Command, (1, 2, 14), COMMANDS, NO_COMMANDS),
    sample(Command, (1, 2, 106), CURRENTS, NO_CURRENTS),
    sample(Command, (1, 2, 105), &["00"], &["02", "03", "FF"]),
    sample(Command, (0, 0, 15), &["00"], &["07", "80", "FF"]),
    sample(Command, (1, 0, 15), &["00"], &["02", "80", "FF"]),
    sample(Command, (1, 0, 46), &["01", "02", "03", "04"], &["00", "05", "06", "FF"]),
    sample(Value, (1, 1, 39), SAFE_STATES, NO_SAFE_STATES),
    sample(Value, (1, 2, 39), SAFE_STATES, NO_SAFE_STATES),
    sample(Value, (1, 1, 40), PRESSURES, NO_PRESSURES),
    sample(Value, (1, 2, 40), PRESSURES, NO_PRESSURES),
    sample(Presentation, (1, 1, 21), TYPES, NO_TYPES),
    sample(Presentation, (1, 2, 21), TYPES, NO_TYPES),
    sample(Presentation, (1, 3, 21), TYPES, NO_TYPES),
    sample(Presentation, (1, 4, 21), TYPES, NO_TYPES),
    sample(Presentation, (1, 1, 22), UNITS, NO_UNITS),
    sample(Presentation, (1, 2, 22), UNITS, NO_UNITS),
    sample(Presentation, (1, 3, 22), UNITS, NO_UNITS),
    sample(Presentation, (1, 4, 22), UNITS, NO_UNITS),
];

#[test]
fn the_tables_are_those_of_the_goldens() {
    for kind in KINDS {
        let model = &kind.variant().model;
        golden::check(&format!("{}.txt", model.name), &golden::print(model));
    }
}

#[test]
fn every_row_is_read_as_marked() {
    rigs().iter().for_each(Rig::every_row_is_read_as_marked);
}

#[test]
fn no_row_is_written_without_a_mark_or_with_another_length() {
    rigs().iter().for_each(Rig::no_row_is_written_without_a_mark_or_with_another_length);
}

/// (27), (28), (30): slots 0 and 1, and the rows of the instance that the selector shows.
#[test]
fn other_slots_and_indices_are_refused() {
    rigs().iter().for_each(Rig::other_slots_and_indices_are_refused);
}

#[test]
fn the_samples_are_complete() {
    rigs().iter().for_each(Rig::samples_are_complete);
}

/// (121): a refusal has the code of DP-V1, and the code of the parameter channel as its second one.
#[test]
fn every_value_is_checked_by_dpv1() {
    rigs().iter().for_each(Rig::every_value_is_checked_by_dpv1);
}

#[test]
fn every_value_is_checked_by_the_channel() {
    rigs().iter().for_each(Rig::every_value_is_checked_by_the_channel);
}

#[test]
fn nonvolatile_values_are_restored_after_power_up() {
    rigs().iter().for_each(Rig::nonvolatile_values_are_restored_after_power_up);
}

/// (38), (39), (94), (104): the rows in which the variants differ.
#[test]
fn each_gauge_has_the_rows_of_its_variant() {
    for (slot, instance, index, kinds) in [
        (0, 1, 202, [false, true]),
        (0, 1, 203, [false, true]),
        (0, 1, 210, [false, false]),
        (0, 1, 211, [false, false]),
        (1, 2, 106, [true, false]),
        (1, 2, 109, [true, false]),
        (1, 1, 140, [true, true]),
        (1, 2, 140, [false, false]),
        (1, 2, 201, [false, false]),
        (1, 3, 201, [false, false]),
    ] {
        for (kind, there) in KINDS.into_iter().zip(kinds) {
            let mut tester = crate::xpg400::tester(kind);
            tester.put(1, 46, &[instance]).unwrap();
            let read = tester.read(Relation::Ms2(0), slot, index);
            assert_eq!(read.map_err(|refusal| refusal.code_2).err(), (!there).then_some(3), "{kind:?} {slot}/{index}");
        }
    }
}
