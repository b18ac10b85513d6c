//! All twelve devices with the master of this project, in bit time, over a pty and over TCP: brought up in every
//! configuration, every parameter read by MS2, MS1 and the parameter channel with equal values, and every writable one
//! written and restored.
#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic, reason = "this is test code")]

mod bit_time;
mod bring_up;
mod from_file;
mod hostile;
mod one_segment;
mod real_time;
mod rig;
mod walk;

use crate::golden;
use bit_time::InBitTime;
use profivac_devices::model::Model;
use profivac_virtual::device_spec::DEVICES;
use real_time::{Bench, InRealTime};
use rig::{Line, Rig};
use std::collections::BTreeSet;
use std::fmt::Write;

/// The address of the first device; the others follow.
const FIRST: u8 = 5;

/// All devices at consecutive addresses.
fn all() -> Vec<(u8, &'static Model)> {
    (FIRST..).zip(DEVICES.iter().map(|entry| entry.model)).collect()
}

/// Their device specs.
fn named() -> Vec<String> {
    all().into_iter().map(|(address, model)| format!("{}@{address}", model.name)).collect()
}

/// A device alone on a line.
fn alone(model: &Model) -> InBitTime {
    InBitTime::new(&[format!("{}@{FIRST}", model.name)])
}

#[test]
fn in_bit_time_every_device_is_brought_up_in_every_configuration() {
    bring_up::every_configuration(&mut InBitTime::new(&named()), &all());
}

#[test]
fn in_bit_time_every_readable_parameter_has_the_same_value_by_every_service() {
    for entry in &DEVICES {
        read_every_way(&mut alone(entry.model), FIRST, entry.model);
    }
}

fn read_every_way<L: Line>(line: &mut L, address: u8, model: &'static Model) {
    let mut rig = Rig::new(line, model, address);
    rig.bring_up();
    rig.open();
    let (read, compared) = walk::read_every_way(&mut rig);
    println!("{}: {read} parameters read, {compared} of them in more than one way", model.name);
    assert!(read > 20, "{}: {read}", model.name);
    rig.leave();
}

/// Read in IDLE by MS2, and in data exchange by every service.
#[test]
fn in_bit_time_every_writable_parameter_is_written_and_restored() {
    let mut text = String::new();
    for entry in &DEVICES {
        let (locations, mut changed) = (walk::writable(entry.model), BTreeSet::new());
        writeln!(text, "{}", entry.model.name).unwrap();
        for exchanging in [false, true] {
            let mut line = alone(entry.model);
            let mut rig = Rig::new(&mut line, entry.model, FIRST);
            if exchanging {
                rig.bring_up();
            }
            rig.open();
            let (lines, written) = walk::write_and_restore(&mut rig, &locations, |ways| ways);
            changed.extend(written);
            let state = if exchanging { "exchange" } else { "idle" };
            lines.iter().for_each(|line| writeln!(text, "  {state:<9}{line}").unwrap());
        }
        assert_eq!(locations, changed, "{}: every one was changed and restored", entry.model.name);
    }
    golden::compare("crates/virtual/tests/golden/written_parameters.txt", &text);
}

#[test]
fn over_a_pty_every_configuration_and_every_parameter() {
    everything_in_real_time(Bench::on_a_pty(&named()));
}

#[test]
fn over_tcp_every_configuration_and_every_parameter() {
    everything_in_real_time(Bench::on_tcp(&named()));
}

#[test]
fn over_a_pty_requests_disturb_no_data_exchange() {
    one_segment::requests_beside_the_exchange(Bench::on_a_pty(&one_segment::named()));
}

#[test]
fn over_tcp_requests_disturb_no_data_exchange() {
    one_segment::requests_beside_the_exchange(Bench::on_tcp(&one_segment::named()));
}

#[test]
fn over_tcp_a_second_master_reads_without_disturbing_the_first() {
    one_segment::a_second_master_looks(Bench::on_tcp(&one_segment::named()));
}

/// All devices on one segment: read and written one by one, then brought up in every configuration.
fn everything_in_real_time(bench: Bench) {
    let mut line = InRealTime::new(bench);
    for (address, model) in all() {
        write_once(&mut line, address, model);
        read_every_way(&mut line, address, model);
    }
    bring_up::every_configuration(&mut line, &all());
}

/// By MS2 where the device has it, otherwise in the parameter channel. Parameters that depend on data exchange are written
/// without it.
fn write_once<L: Line>(line: &mut L, address: u8, model: &'static Model) {
    let mut left = walk::writable(model);
    for exchanging in [true, false] {
        let mut rig = Rig::new(line, model, address);
        if exchanging {
            rig.bring_up();
        }
        rig.open();
        let (_, changed) = walk::write_and_restore(&mut rig, &left, |ways| ways.into_iter().take(1).collect());
        rig.leave();
        left.retain(|location| !changed.contains(location));
    }
    assert!(left.is_empty(), "{}: {left:?} was not changed and restored", model.name);
}
