//! Every row of BG 5530 by MS1, MS2 and parameter channel, and the tables as a text to compare with the manual.

use crate::img400::{Controller, controller};
use crate::support::rows::{Kind, Rig, Sample};
use crate::support::{golden, sense_all};
use profivac_devices::SimulatedDevice;
use profivac_devices::img400::{Gauges, table};
use profivac_devices::model::Location;

const RIG: Rig<Controller> = Rig {
    model: &table::MODEL,
    make,
    select,
    user: "00 00 00 13 08",
    cfgs: ["C7 87 90 0A 0A 05 03 03 03 03", "C9 89 98 0A 05 05 0A 05 08 08 08 08"],
    samples: &SAMPLES,
};

fn make() -> Controller {
    let mut controller = controller(Gauges::default());
    sense_all(&mut controller, 1.0);
    controller.settle();
    controller
}

/// The IMG 400 has no selector.
fn select(_controller: &mut Controller, _address: &Location) {}

const fn value(slot: u8, index: u8, good: &'static [&'static str], bad: &'static [&'static str]) -> Sample {
    Sample { at: (slot, 0, index), good, bad, kind: Kind::Value }
}

const fn presentation(slot: u8, index: u8, good: &'static [&'static str], bad: &'static [&'static str]) -> Sample {
    Sample { at: (slot, 0, index), good, bad, kind: Kind::Presentation }
}

const fn command(slot: u8, index: u8, good: &'static [&'static str], bad: &'static [&'static str]) -> Sample {
    Sample { at: (slot, 0, index), good, bad, kind: Kind::Command }
}

const TYPES: &[&str] = &["03", "08"];
const NO_TYPES: &[&str] = &["00", "02", "04", "05", "07", "09", "FF"];
const SAFE_STATES: &[&str] = &["01", "02", "03", "00"];
const NO_SAFE_STATES: &[&str] = &["04", "FF"];
/// 1.5, 1e-20, 0 and 123456; a number below zero, and NaN.
const PRESSURES: &[&str] = &["3F C0 00 00", "1E 3C E5 08", "00 00 00 00", "47 F1 20 00"];
const NO_PRESSURES: &[&str] = &["BF C0 00 00", "7F C0 00 00", "7F 80 00 00", "FF 80 00 00", "7F 7F FF FF"];
/// The trip point is at 1e-3: 1.5, 0, 123456.
const HYSTERESES: &[&str] = &["3F C0 00 00", "00 00 00 00", "47 F1 20 00"];
/// 1.5, 1e-3 (the trip point itself), 123456; 9e-4 and 0 lie below it (141).
const UPPERS: &[&str] = &["3F C0 00 00", "3A 83 12 6F", "47 F1 20 00"];
const NO_UPPERS: &[&str] = &["3A 6B ED FA", "00 00 00 00", "BF C0 00 00", "7F C0 00 00", "7F 80 00 00"];
const FLAGS: &[&str] = &["01", "00"];
const NO_FLAGS: &[&str] = &["02", "FF"];
const CHANNELS: &[&str] = &["02", "03", "04", "01"];
const NO_CHANNELS: &[&str] = &["00", "05", "FF"];
/// Commands without effect on a gauge that is off, and unknown commands (150).
const COMMANDS: &[&str] = &["00 00", "00 07", "01 00", "03 00", "04 00", "04 01"];
const NO_COMMANDS: &[&str] = &["01 02", "02 00", "03 02", "04 02", "80 00", "FF 00"];
/// The codes of 0, 0.1, 1, 1.6, 10, 45 and 90 mA (147); 0.1, 7, -1 and NaN.
const CURRENTS: &[&str] =
    &["3F 80 00 00", "40 00 00 00", "40 40 00 00", "40 80 00 00", "40 A0 00 00", "40 C0 00 00", "00 00 00 00"];
const NO_CURRENTS: &[&str] = &["3D CC CC CD", "40 E0 00 00", "BF 80 00 00", "7F C0 00 00"];
const NO_ADJUSTMENTS: &[&str] = &["00 02", "01 00", "80 00", "FF FF"];

/// Data Type last, so that pressures are floats in hPa during the test.
const SAMPLES: [Sample; 60] = [
    command(0, 15, &["00"], &["07", "80", "FF"]),
    value(0, 203, &["01", "02", "03", "00"], &["04", "FF"]),
    command(0, 205, &["00", "01", "02", "04", "08", "10", "20", "40", "80", "FF"], &[]),
    // Zero adjust on ionisation gauges, none on a Pirani gauge (131).
    command(1, 15, &["00 01"], NO_ADJUSTMENTS),
    command(2, 15, &["00 01"], NO_ADJUSTMENTS),
    command(3, 15, &[], NO_ADJUSTMENTS),
    command(4, 15, &["00 01", "00 00"], NO_ADJUSTMENTS),
    value(1, 39, SAFE_STATES, NO_SAFE_STATES),
    value(2, 39, SAFE_STATES, NO_SAFE_STATES),
    value(3, 39, SAFE_STATES, NO_SAFE_STATES),
    value(4, 39, SAFE_STATES, NO_SAFE_STATES),
    value(1, 40, PRESSURES, NO_PRESSURES),
    value(2, 40, PRESSURES, NO_PRESSURES),
    value(3, 40, PRESSURES, NO_PRESSURES),
    value(4, 40, PRESSURES, NO_PRESSURES),
    value(5, 19, PRESSURES, NO_PRESSURES),
    value(5, 20, FLAGS, NO_FLAGS),
    value(5, 24, HYSTERESES, NO_PRESSURES),
    value(5, 27, CHANNELS, NO_CHANNELS),
    value(5, 201, UPPERS, NO_UPPERS),
    value(6, 19, PRESSURES, NO_PRESSURES),
    value(6, 20, FLAGS, NO_FLAGS),
    value(6, 24, HYSTERESES, NO_PRESSURES),
    value(6, 27, CHANNELS, NO_CHANNELS),
    value(6, 201, UPPERS, NO_UPPERS),
    value(7, 19, PRESSURES, NO_PRESSURES),
    value(7, 20, FLAGS, NO_FLAGS),
    value(7, 24, HYSTERESES, NO_PRESSURES),
    value(7, 27, CHANNELS, NO_CHANNELS),
    value(7, 201, UPPERS, NO_UPPERS),
    value(8, 19, PRESSURES, NO_PRESSURES),
    value(8, 20, FLAGS, NO_FLAGS),
    value(8, 24, HYSTERESES, NO_PRESSURES),
    value(8, 27, CHANNELS, NO_CHANNELS),
    value(8, 201, UPPERS, NO_UPPERS),
    value(9, 19, PRESSURES, NO_PRESSURES),
    value(9, 20, FLAGS, NO_FLAGS),
    value(9, 24, HYSTERESES, NO_PRESSURES),
    value(9, 27, CHANNELS, NO_CHANNELS),
    value(9, 201, UPPERS, NO_UPPERS),
    value(10, 19, PRESSURES, NO_PRESSURES),
    value(10, 20, FLAGS, NO_FLAGS),
    value(10, 24, HYSTERESES, NO_PRESSURES),
    value(10, 27, CHANNELS, NO_CHANNELS),
    value(10, 201, UPPERS, NO_UPPERS),
    value(11, 19, PRESSURES, NO_PRESSURES),
    value(11, 20, FLAGS, NO_FLAGS),
    value(11, 24, HYSTERESES, NO_PRESSURES),
    value(11, 27, CHANNELS, NO_CHANNELS),
    value(11, 201, UPPERS, NO_UPPERS),
    command(1, 14, COMMANDS, NO_COMMANDS),
    command(2, 14, COMMANDS, NO_COMMANDS),
    command(1, 105, &["01", "00"], NO_FLAGS),
    command(2, 105, &["00"], NO_FLAGS),
    value(1, 107, CURRENTS, NO_CURRENTS),
    value(2, 107, CURRENTS, NO_CURRENTS),
    presentation(1, 21, TYPES, NO_TYPES),
    presentation(2, 21, TYPES, NO_TYPES),
    presentation(3, 21, TYPES, NO_TYPES),
    presentation(4, 21, TYPES, NO_TYPES),
];

#[test]
fn the_tables_are_those_of_the_golden() {
    golden::check("img400.txt", &golden::print(&table::MODEL));
}

#[test]
fn every_row_is_read_as_marked() {
    RIG.every_row_is_read_as_marked();
}

#[test]
fn no_row_is_written_without_a_mark_or_with_another_length() {
    RIG.no_row_is_written_without_a_mark_or_with_another_length();
}

/// (30), (52), (120), (160)
#[test]
fn other_slots_and_indices_are_refused() {
    RIG.other_slots_and_indices_are_refused();
}

#[test]
fn the_samples_are_complete() {
    RIG.samples_are_complete();
}

/// (13), (43)
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
