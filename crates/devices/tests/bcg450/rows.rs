//! Every row of tira41d1, by MS1, MS2 and parameter channel, and the tables as a text to compare with the manual.

use crate::bcg450::{Gauge, gauge};
use crate::support::rows::{Kind, Rig, Sample};
use crate::support::{golden, sense_all};
use profivac_devices::SimulatedDevice;
use profivac_devices::bcg450::table;
use profivac_devices::model::Location;
use profivac_dp::slave::{Device, Relation};

const RIG: Rig<Gauge> = Rig {
    model: &table::MODEL,
    make,
    select,
    user: "00 00 00 05 1C",
    cfgs: ["C6 87 8C 0A 0A 05 05 05 03", "C8 89 8E 0A 05 05 0A 05 05 05 08"],
    samples: &SAMPLES,
};

fn make() -> Gauge {
    let mut gauge = gauge();
    sense_all(&mut gauge, 1e-3);
    gauge.settle();
    gauge
}

/// Channel Instance Selector, where the address has an instance. The ambient sensor is adjusted in a vented chamber (159).
fn select(gauge: &mut Gauge, address: &Location) {
    if address.instance == table::ATMOSPHERE.instance {
        sense_all(gauge, 1000.0);
    }
    if address.instance != 0 {
        gauge.write(Relation::Ms2(0), 1, 46, &[address.instance]).unwrap();
    }
}

const fn value(at: (u8, u8, u8), good: &'static [&'static str], bad: &'static [&'static str]) -> Sample {
    Sample { at, good, bad, kind: Kind::Value }
}

const fn presentation(at: (u8, u8, u8), good: &'static [&'static str], bad: &'static [&'static str]) -> Sample {
    Sample { at, good, bad, kind: Kind::Presentation }
}

const fn command(at: (u8, u8, u8), good: &'static [&'static str], bad: &'static [&'static str]) -> Sample {
    Sample { at, good, bad, kind: Kind::Command }
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
const PERCENTAGES: &[&str] = &["00 0A", "05 78", "01 F4"];
const NO_PERCENTAGES: &[&str] = &["00 00", "00 09", "05 79", "FF FF"];

/// Type and unit last, so that pressures are floats in mbar during the test.
const SAMPLES: [Sample; 26] = [
    command((0, 0, 15), &["00"], &["07", "80", "FF"]),
    command((1, 0, 46), &["01", "02", "03", "04", "05", "06"], &["00", "07", "FF"]),
    value((1, 1, 39), SAFE_STATES, NO_SAFE_STATES),
    value((1, 2, 39), SAFE_STATES, NO_SAFE_STATES),
    value((1, 3, 39), SAFE_STATES, NO_SAFE_STATES),
    value((1, 1, 40), PRESSURES, NO_PRESSURES),
    value((1, 2, 40), PRESSURES, NO_PRESSURES),
    value((1, 3, 40), PRESSURES, NO_PRESSURES),
    value((1, 5, 201), &["01", "00"], &["02", "FF"]),
    value((1, 6, 201), &["01", "00"], &["02", "FF"]),
    value((1, 5, 202), PERCENTAGES, NO_PERCENTAGES),
    value((1, 6, 202), PERCENTAGES, NO_PERCENTAGES),
    command(
        (1, 2, 14),
        &["00 00", "00 07", "01 00", "03 00", "80 00", "80 01"],
        &["01 02", "02 00", "03 02", "80 02", "FF 00"],
    ),
    command((1, 2, 105), &["00"], &["02", "03", "FF"]),
    // 0, 0.025, 5 and 20 mA
    command(
        (1, 2, 106),
        &["00 00 00 00", "3C CC CC CD", "40 A0 00 00", "41 A0 00 00"],
        &["3F 80 00 00", "7F C0 00 00"],
    ),
    command((1, 4, 14), &["00 00", "80 00", "80 01"], &["01 00", "80 02", "FF 00"]),
    presentation((1, 1, 21), TYPES, NO_TYPES),
    presentation((1, 2, 21), TYPES, NO_TYPES),
    presentation((1, 3, 21), TYPES, NO_TYPES),
    presentation((1, 5, 21), TYPES, NO_TYPES),
    presentation((1, 6, 21), TYPES, NO_TYPES),
    presentation((1, 1, 22), UNITS, NO_UNITS),
    presentation((1, 2, 22), UNITS, NO_UNITS),
    presentation((1, 3, 22), UNITS, NO_UNITS),
    presentation((1, 5, 22), UNITS, NO_UNITS),
    presentation((1, 6, 22), UNITS, NO_UNITS),
];

#[test]
fn the_tables_are_those_of_the_golden() {
    golden::check("bcg450.txt", &golden::print(&table::MODEL));
}

#[test]
fn every_row_is_read_as_marked() {
    RIG.every_row_is_read_as_marked();
}

#[test]
fn no_row_is_written_without_a_mark_or_with_another_length() {
    RIG.no_row_is_written_without_a_mark_or_with_another_length();
}

/// (27), (28), (30): slots 0 and 1, and the rows of the instance that the selector shows.
#[test]
fn other_slots_and_indices_are_refused() {
    RIG.other_slots_and_indices_are_refused();
}

#[test]
fn the_samples_are_complete() {
    RIG.samples_are_complete();
}

/// (121): a refusal has the code of DP-V1, and the code of the parameter channel as its second one.
#[test]
fn every_value_is_checked_by_dpv1() {
    RIG.every_value_is_checked_by_dpv1();
}

#[test]
fn every_value_is_checked_by_the_channel() {
    RIG.every_value_is_checked_by_the_channel();
}

#[test]
fn nonvolatile_values_are_restored_after_power_up() {
    RIG.nonvolatile_values_are_restored_after_power_up();
}
