//! Walks through the parameters of a device: reads each by every service, writes and restores the writable ones.

use crate::twelve_devices::rig::{Line, Rig, Told, Way, rows};
use profivac_devices::model::{Access, DataType, Location, Model, Row};
use std::collections::BTreeSet;

/// Whether the access marks of a row allow this service.
fn is_readable(row: &Row, way: Way) -> bool {
    match way {
        Way::Ms2 => row.access.contains(Access::READ_2),
        Way::Ms1 => row.access.contains(Access::READ_1),
        Way::Pkw => row.access.intersects(Access::READ) && is_carried(row),
    }
}

fn is_writable(row: &Row, way: Way) -> bool {
    match way {
        Way::Ms2 => row.access.contains(Access::WRITE_2),
        Way::Ms1 => row.access.contains(Access::WRITE_1),
        Way::Pkw => row.access.intersects(Access::WRITE) && is_carried(row),
    }
}

/// The parameter channel transfers up to four octets and no texts: errata-bpg-bcg-tpg 19 and 20, errata-pxg55x-img400 4.
fn is_carried(row: &Row) -> bool {
    match row.data_type {
        DataType::Visible(_) => false,
        DataType::OctetString(octets) | DataType::Array(octets) | DataType::Record(octets) => octets <= 4,
        _ => true,
    }
}

/// Reads every parameter by every service. Returns the number of parameters, and of those with more than one service.
pub fn read_every_way<L: Line>(rig: &mut Rig<'_, L>) -> (usize, usize) {
    let (mut read, mut compared) = (0, 0);
    for (address, row) in rig.rows() {
        rig.select(address);
        let mut values = values(rig, address, row);
        // A value that changes by itself may differ between two services, but not every time.
        for _ in 0..3 {
            if !are_equal(&values) {
                values = self::values(rig, address, row);
            }
        }
        let what = format!("{} {}:{}/{} {}", rig.model.name, address.slot, address.instance, row.index, row.name);
        assert!(are_equal(&values), "{what}: {values:02X?}");
        read += usize::from(!values.is_empty());
        compared += usize::from(values.len() > 1);
    }
    (read, compared)
}

fn are_equal(values: &[Vec<u8>]) -> bool {
    values.windows(2).all(|pair| pair[0] == pair[1])
}

/// The values read by each service; services that the access marks forbid refuse.
fn values<L: Line>(rig: &mut Rig<'_, L>, address: &Location, row: &Row) -> Vec<Vec<u8>> {
    let mut values = Vec::new();
    for way in rig.ways() {
        let told = rig.read(way, address.slot, row.index);
        let what = format!("{} {}/{} {} by {way:?}", rig.model.name, address.slot, row.index, row.name);
        assert_eq!(matches!(told, Told::Octets(_)), is_readable(row, way), "{what}: {told}");
        if let Told::Octets(octets) = told {
            values.push(without_padding(row, octets));
        }
    }
    values
}

/// In the channel an array of three octets follows a zero: errata-bpg-bcg-tpg 20.
fn without_padding(row: &Row, octets: Vec<u8>) -> Vec<u8> {
    match row.data_type {
        DataType::Array(3) if octets.len() == 4 => octets[1..].to_vec(),
        _ => octets,
    }
}

/// Candidates for a trial write, given the present value: the first that the device accepts.
fn candidates(row: &Row, present: &[u8]) -> Vec<Vec<u8>> {
    let count = |step: i64| {
        let value = present.iter().fold(0u32, |value, octet| value << 8 | u32::from(*octet));
        let moved = (i64::from(value) + step) as u32;
        moved.to_be_bytes()[4 - present.len()..].to_vec()
    };
    let all = match (row.data_type, present) {
        _ if is_switch(row) => vec![vec![u8::from(present == [0])]],
        (DataType::Visible(_), text) => vec![vec![b'A'; text.len()], vec![b'1'; text.len()]],
        (DataType::Float | DataType::ByType, [a, b, c, d]) => {
            let value = f32::from_be_bytes([*a, *b, *c, *d]);
            let others =
                [value * 1.25, value * 0.8, value * 2.0, value * 0.5, value + 1.0, value - 1.0, 1.0, 0.01, 0.0];
            others.iter().map(|other| other.to_be_bytes().to_vec()).collect()
        }
        (_, octets) if octets.len() <= 4 => [1, -1, 2, -2, 3, -3, 4, -4, 5, -5, 7, -7, 8, -8].map(count).to_vec(),
        (_, octets) => vec![octets.iter().map(|octet| octet ^ 1).collect()],
    };
    all.into_iter().filter(|other| other != present).collect()
}

/// Writes another value, reads it back and restores the value before. Returns a line about it.
fn there_and_back<L: Line>(rig: &mut Rig<'_, L>, way: Way, slot: u8, row: &Row) -> String {
    let read = |rig: &mut Rig<'_, L>| {
        let ways = rig.ways();
        let by = ways.into_iter().find(|by| is_readable(row, *by)).unwrap();
        match rig.read(by, slot, row.index) {
            Told::Octets(octets) => octets,
            other => panic!("{slot}/{}: {other}", row.index),
        }
    };
    let before = read(rig);
    let mut last = Told::Written;
    for other in candidates(row, &before) {
        last = rig.write(way, slot, row.index, &other);
        if last == Told::Written {
            let what = format!("{} {slot}/{} {} by {way:?}", rig.model.name, row.index, row.name);
            if !is_switch(row) {
                assert_eq!(read(rig), other, "{what}");
            }
            // A switch is written 0 and 1, and may display a specific "on" value.
            let back = if is_switch(row) { vec![u8::from(before != [0])] } else { before.clone() };
            assert_eq!(rig.write(way, slot, row.index, &back), Told::Written, "{what}: back");
            assert_eq!(read(rig), before, "{what}: restored");
            return format!("{} {} and back", Told::Octets(before), Told::Octets(other));
        }
        assert_eq!(read(rig), before, "a refused value changes nothing");
    }
    // A selector without alternatives accepts its present value.
    match rig.write(way, slot, row.index, &before) {
        Told::Written => format!("{} again and back", Told::Octets(before)),
        _ => last.to_string(),
    }
}

/// The commands of a block are 14 and 15 in the manuals of the gauges, and Volatility is one at the controllers
/// (errata-bpg-bcg-tpg 143); Emission Current 106 need not follow what is written (98). The tests of the devices cover
/// their effect.
fn is_command(row: &Row) -> bool {
    [14, 15].contains(&row.index) || [(26, "Volatility"), (106, "Emission Current")].contains(&(row.index, row.name))
}

/// A cathode is switched by 0 and 1 and then displays its state, which has more values.
fn is_switch(row: &Row) -> bool {
    row.name == "Emission Status"
}

/// A parameter that can be written and read back.
fn is_value(row: &Row) -> bool {
    let both = row.access.intersects(Access::WRITE) && row.access.intersects(Access::READ);
    both && !is_command(row)
}

/// A valid set of thresholds cannot be changed: errata-bpg-bcg-tpg 138.
fn unlock<L: Line>(rig: &mut Rig<'_, L>, slot: u8, row: &Row) {
    if ["Upper threshold", "Lower threshold", "Threshold source"].contains(&row.name) {
        assert_eq!(rig.write(Way::Pkw, slot, 20, &[0]), Told::Written);
    }
}

/// Writes the parameters at `locations` by the services that `chosen` selects, and restores them. Returns a line for each, and
/// the locations of those that changed.
pub fn write_and_restore<L: Line>(
    rig: &mut Rig<'_, L>,
    locations: &BTreeSet<String>,
    chosen: fn(Vec<Way>) -> Vec<Way>,
) -> (Vec<String>, BTreeSet<String>) {
    let (mut lines, mut changed) = (Vec::new(), BTreeSet::new());
    let rows = if rig.ways().is_empty() { Vec::new() } else { rig.rows() };
    for (address, row) in rows {
        let location = location(address, row);
        if !locations.contains(&location) {
            continue;
        }
        rig.select(address);
        unlock(rig, address.slot, row);
        let ways = rig.ways().into_iter().filter(|way| is_writable(row, *way)).collect();
        let told =
            chosen(ways).into_iter().map(|way| format!("{way:?} {}", there_and_back(rig, way, address.slot, row)));
        let told: Vec<_> = told.collect();
        lines.push(format!("{location:<9}{:<44}{}", row.name, told.join("; ")));
        if told.iter().any(|told| told.ends_with("and back")) {
            changed.insert(location);
        }
    }
    (lines, changed)
}

/// The locations of the parameters that can be written and read back.
pub fn writable(model: &Model) -> BTreeSet<String> {
    rows(model).into_iter().filter(|(_, row)| is_value(row)).map(|(address, row)| location(address, row)).collect()
}

fn location(address: &Location, row: &Row) -> String {
    format!("{}:{}/{}", address.slot, address.instance, row.index)
}
