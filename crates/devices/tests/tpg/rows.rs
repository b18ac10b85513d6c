//! Every row of the manual by the parameter channel, and the tables as a text to compare with it. The rows have no mark
//! for MS1 and MS2, which are refused (150).

use crate::support::rows::{Kind, Rig, Sample};
use crate::support::{golden, sense_all};
use crate::tpg::{BOARDS, Controller, controller};
use profivac_devices::SimulatedDevice;
use profivac_devices::model::Location;
use profivac_devices::tpg::table;
use profivac_dp::slave::{Device, Outputs};

const RIG: Rig<Controller> = Rig {
    model: &table::TPG500,
    make,
    select,
    user: "",
    cfgs: ["97 A7 93 93 93 93 A0", "97 A7 94 94 94 94 A0"],
    samples: &SAMPLES,
};

fn make() -> Controller {
    let mut controller = controller(BOARDS);
    sense_all(&mut controller, 1e-3);
    controller.settle();
    controller
}

/// Threshold validation 0, so that the set of a block can be written.
fn select(controller: &mut Controller, address: &Location) {
    if address.slot >= 5 {
        controller.outputs(Outputs::Data(&[0x20, address.slot, 20, 0, 0, 0, 0, 0, 0]));
        controller.outputs(Outputs::Data(&[0; 9]));
    }
}

const fn value(slot: u8, index: u8, good: &'static [&'static str], bad: &'static [&'static str]) -> Sample {
    Sample { at: (slot, 0, index), good, bad, kind: Kind::Value }
}

const fn command(slot: u8, index: u8, good: &'static [&'static str], bad: &'static [&'static str]) -> Sample {
    Sample { at: (slot, 0, index), good, bad, kind: Kind::Command }
}

const UNITS: &[&str] = &["03", "02", "01"];
const NO_UNITS: &[&str] = &["00", "04", "FF"];
const FILTERS: &[&str] = &["01", "03", "02"];
const NO_FILTERS: &[&str] = &["00", "04", "FF"];
/// 1.5, 1e-20 and 123456; zero, a number below zero, and NaN (137).
const PRESSURES: &[&str] = &["3F C0 00 00", "1E 3C E5 08", "47 F1 20 00"];
const NO_PRESSURES: &[&str] = &["00 00 00 00", "BF C0 00 00", "7F C0 00 00", "7F 80 00 00", "FF 80 00 00"];
const SOURCES: &[&str] = &["01", "02", "03", "04"];
const NO_SOURCES: &[&str] = &["00", "05", "FF"];

const FLAGS: &[&str] = &["01", "00"];
const NO_FLAGS: &[&str] = &["02", "FF"];

const SAMPLES: [Sample; 35] = [
    // 9919 is the last code that can be written (132).
    value(0, 24, &["04 D2", "27 0F", "00 00"], &["27 10", "80 00", "FF FF"]),
    value(0, 25, FLAGS, NO_FLAGS),
    command(0, 26, &["00", "01", "02"], &["03", "FF"]),
    value(1, 22, UNITS, NO_UNITS),
    value(2, 22, UNITS, NO_UNITS),
    value(3, 22, UNITS, NO_UNITS),
    value(4, 22, UNITS, NO_UNITS),
    value(1, 23, FILTERS, NO_FILTERS),
    value(2, 23, FILTERS, NO_FILTERS),
    value(3, 23, FILTERS, NO_FILTERS),
    value(4, 23, FILTERS, NO_FILTERS),
    command(5, 20, FLAGS, NO_FLAGS),
    value(5, 21, PRESSURES, NO_PRESSURES),
    value(5, 22, PRESSURES, NO_PRESSURES),
    value(5, 23, SOURCES, NO_SOURCES),
    command(6, 20, FLAGS, NO_FLAGS),
    value(6, 21, PRESSURES, NO_PRESSURES),
    value(6, 22, PRESSURES, NO_PRESSURES),
    value(6, 23, SOURCES, NO_SOURCES),
    command(7, 20, FLAGS, NO_FLAGS),
    value(7, 21, PRESSURES, NO_PRESSURES),
    value(7, 22, PRESSURES, NO_PRESSURES),
    value(7, 23, SOURCES, NO_SOURCES),
    command(8, 20, FLAGS, NO_FLAGS),
    value(8, 21, PRESSURES, NO_PRESSURES),
    value(8, 22, PRESSURES, NO_PRESSURES),
    value(8, 23, SOURCES, NO_SOURCES),
    command(9, 20, FLAGS, NO_FLAGS),
    value(9, 21, PRESSURES, NO_PRESSURES),
    value(9, 22, PRESSURES, NO_PRESSURES),
    value(9, 23, SOURCES, NO_SOURCES),
    command(10, 20, FLAGS, NO_FLAGS),
    value(10, 21, PRESSURES, NO_PRESSURES),
    value(10, 22, PRESSURES, NO_PRESSURES),
    value(10, 23, SOURCES, NO_SOURCES),
];

#[test]
fn the_tables_are_those_of_the_golden() {
    golden::check("tpg500.txt", &golden::print(&table::TPG500));
    // The TPG300 and the TPG500 differ in the name only.
    let tpg300 = golden::print(&table::TPG300).replace("TPG300", "TPG500").replace("tpg300", "tpg500");
    golden::check("tpg500.txt", &tpg300);
}

#[test]
fn every_row_is_read_as_marked() {
    RIG.every_row_is_read_as_marked();
}

#[test]
fn no_row_is_written_without_a_mark_or_with_another_length() {
    RIG.no_row_is_written_without_a_mark_or_with_another_length();
}

/// (157): the slot is the address of a block.
#[test]
fn other_slots_and_indices_are_refused() {
    RIG.other_slots_and_indices_are_refused();
}

#[test]
fn the_samples_are_complete() {
    RIG.samples_are_complete();
}

#[test]
fn every_value_is_checked_by_the_channel() {
    RIG.every_value_is_checked_by_the_channel();
}

#[test]
fn settings_that_were_not_stored_on_request_are_lost_with_the_power() {
    RIG.nonvolatile_values_are_restored_after_power_up();
}
