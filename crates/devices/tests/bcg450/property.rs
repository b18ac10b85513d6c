//! Whatever masters, people and power do: the gauge is in a named state, its copies are equal, nothing stored is lost.

use crate::exceptions::copies_are_equal;
use crate::support::random::Random;
use crate::support::{Desk, hex, sense_all};
use crate::{Gauge, desk, float, of_instance};
use profivac_devices::bcg450::table;
use profivac_devices::model::{Access, DataType, Row};
use profivac_devices::{Action, Instrument, Report};
use profivac_dp::slave::Relation;
use std::collections::BTreeSet;

const STEPS: usize = 1_000_000;

/// Nonvolatile parameters of slot 1: instance and its indices.
const KEPT: [(u8, &[u8]); 5] =
    [(1, &[39, 40, 21, 22]), (2, &[39, 40]), (3, &[39, 40]), (5, &[201, 202]), (6, &[201, 202])];

/// What must be there after any power cut.
fn kept(desk: &mut Desk<Gauge>) -> Vec<Vec<u8>> {
    let selected = desk.get(1, 46);
    let mut values = vec![];
    for (instance, indices) in KEPT {
        desk.put(1, 46, &[instance]).unwrap();
        values.extend(indices.iter().map(|index| desk.get(1, *index)));
    }
    desk.put(1, 46, &selected).unwrap();
    values.push(selected);
    values
}

fn any<T>(random: &mut Random, items: &'static [T]) -> &'static T {
    &items[random.below(items.len())]
}

/// A row of the tables, its slot and its instance.
fn any_row(random: &mut Random) -> (u8, u8, &'static Row) {
    let place = any(random, table::MODEL.places);
    let address = any(random, place.addresses);
    (address.slot, address.instance, any(random, place.block.rows))
}

/// Octets that a row of this type might take, more often than not.
fn any_value(random: &mut Random, row: &Row) -> Vec<u8> {
    if random.once_in(20) {
        let length = random.below(6);
        return random.octets(length);
    }
    match row.data_type {
        DataType::Boolean | DataType::Uint8 => vec![random.octet() % 8],
        DataType::Uint16 if row.name == "Data Units" => any(random, table::MODEL.units).code.to_be_bytes().to_vec(),
        DataType::Uint16 => (random.below(1500) as u16).to_be_bytes().to_vec(),
        DataType::Record(2) => vec![random.one_of(&[0, 1, 3, 128]), random.octet() % 2],
        DataType::ByType if random.once_in(2) => random.octets(2),
        _ => (10f32.powf(random.unit() as f32 * 12.0 - 8.0)).to_be_bytes().to_vec(),
    }
}

fn relation(random: &mut Random) -> Relation {
    random.one_of(&[Relation::Ms1, Relation::Ms2(0), Relation::Ms2(1)])
}

/// A write anywhere. What is refused has changed nothing.
fn write(desk: &mut Desk<Gauge>, random: &mut Random) {
    let (slot, instance, row) = any_row(random);
    let octets = any_value(random, row);
    if instance != 0 && !random.once_in(10) {
        desk.put(1, 46, &[instance]).unwrap();
    }
    let before = random.once_in(50).then(|| kept(desk));
    let result = desk.write(relation(random), slot, row.id, &octets);
    if let (Some(before), Err(refusal)) = (before, result) {
        assert_eq!(kept(desk), before, "{slot}/{} refused with {refusal:02X?}", row.id);
    }
}

/// A read anywhere, known or not.
fn read(desk: &mut Desk<Gauge>, random: &mut Random) {
    let (slot, _, row) = any_row(random);
    let index = if random.once_in(5) { random.octet() } else { row.id };
    let _ = desk.read(relation(random), slot, index);
}

/// A cycle, if there is an exchange, otherwise the bring-up of one.
fn cycle(desk: &mut Desk<Gauge>, random: &mut Random) {
    let Some(length) = desk.outputs() else {
        let unit = any(random, table::MODEL.user_prm).octets;
        let cfg = any(random, table::MODEL.configurations).octets;
        return desk.bring_up(unit, cfg);
    };
    let mut outputs = vec![0; length];
    if length >= 8 {
        let (slot, _, row) = any_row(random);
        let value = any_value(random, row);
        let ak = random.one_of(&[0, 0x10, 0x20, 0x30, 0xA0, 0x70]);
        outputs[..3].copy_from_slice(&[ak, slot, row.id]);
        let width = value.len().min(4);
        outputs[8 - width..8].copy_from_slice(&value[..width]);
    }
    if let [.., command, value] = &mut outputs[if length < 8 { 0 } else { 8 }..] {
        [*command, *value] = [random.one_of(&[0, 1, 3, 128, 77]), random.octet() % 3];
    }
    if random.once_in(50) {
        outputs.push(0);
    }
    let inputs = desk.exchange(&outputs);
    assert!([5, 7, 13, 15].contains(&inputs.len()), "{inputs:02X?}");
}

/// Power goes and returns: what was nonvolatile is as before.
fn power(desk: &mut Desk<Gauge>, random: &mut Random) {
    let before = kept(desk);
    desk.device().power(false);
    sense_all(desk.device(), 1.0);
    desk.device().power(true);
    desk.slave.power_up(5);
    if random.once_in(2) {
        desk.device().settle();
    }
    assert_eq!(kept(desk), before);
}

/// Somebody does something at the gauge.
fn operate(desk: &mut Desk<Gauge>, random: &mut Random) {
    let action = match random.below(4) {
        0 | 1 => Action::Fault { name: random.one_of(table::MODEL.faults.names), present: random.once_in(8) },
        2 => Action::Pot { which: random.one_of(&['a', 'b']), volts: random.unit() * 12.0 - 1.0 },
        _ => Action::Switch { name: "degas", value: random.one_of(&["on", "off"]) },
    };
    desk.device().operate(action).unwrap();
}

fn pressure(desk: &mut Desk<Gauge>, random: &mut Random) {
    let part = random.below(5);
    let pa = 10f64.powf(random.unit() * 18.0 - 11.0);
    match part {
        4 => desk.pressure_mbar(pa / 100.0),
        _ => desk.device().sense(part, pa),
    }
}

/// What the walk has come across, so that it does not stay in one corner.
#[derive(Default)]
struct Seen {
    states: BTreeSet<&'static str>,
    degas: bool,
    relays: [bool; 2],
    units: usize,
}

impl Seen {
    fn note(&mut self, report: &Report) {
        self.states.insert(report.device_state);
        self.degas |= report.degas.iter().eq([&true]);
        for (seen, relay) in self.relays.iter_mut().zip(report.relays.iter()) {
            *seen |= relay;
        }
    }
}

/// The bench's view is the bus's view, and the cyclic data are the parameters.
fn check(desk: &mut Desk<Gauge>) {
    let names = ["INIT", "SELFTESTING", "IDLE", "SELFTESTEXCEPTION", "EXECUTING", "ABORT", "CRITICALFAULT"];
    let report = desk.report();
    assert_eq!(report.device_state, names[usize::from(desk.state())]);
    assert_eq!(report.exception_status & 0x88, 0x80);
    assert_eq!(desk.get(0, 26), [report.exception_status]);
    copies_are_equal(desk);
    let selected = desk.get(1, 46);
    assert_eq!(desk.get(1, 47), [report.active_instance]);
    let value = of_instance(desk, report.active_instance, 19);
    desk.put(1, 46, &selected).unwrap();
    let mut inputs = [0; 15];
    let outputs = desk.outputs();
    if let Some(outputs) = outputs {
        let du = desk.exchange(&vec![0; outputs]);
        inputs[..du.len()].copy_from_slice(&du);
        let process = if du.len() > 8 { &du[8..] } else { &du[..] };
        assert_eq!(process[..3], [report.exception_status, desk.get(1, 120)[0], report.active_instance]);
        assert_eq!(process[3..], value);
    }
    for (relay, instance) in report.relays.iter().zip([5, 6]) {
        assert_eq!(of_instance(desk, instance, 20), [if *relay { 0x0A } else { 0 }]);
    }
    desk.put(1, 46, &selected).unwrap();
    let executing = report.device_state == "EXECUTING";
    assert!(executing || report.relays.iter().chain(report.emission.iter()).all(|on| !on), "{report:?}");
    assert!(report.emission.iter().eq([&true]) || report.degas.iter().all(|on| !on), "{report:?}");
    assert!(report.outputs_safe || executing, "{report:?}");
}

/// There and back through every unit, in IDLE: no physical value changes beyond the rounding of a float.
fn units_there_and_back(desk: &mut Desk<Gauge>, seen: &mut Seen) {
    desk.unlock();
    table::MODEL.faults.names.iter().for_each(|name| desk.fault(name, false));
    let _ = desk.command(1);
    desk.device().settle();
    assert_eq!(desk.state(), 2);
    seen.units += 1;
    let selected = desk.get(1, 46);
    desk.put(1, 46, &[1]).unwrap();
    let [number, unit] = [21, 22].map(|index| desk.get(1, index));
    desk.put(1, 21, &[8]).unwrap();
    desk.put(1, 22, &hex("05 1C")).unwrap();
    let values = |desk: &mut Desk<Gauge>| {
        let indices = [(1, 40), (2, 40), (3, 40), (1, 45), (3, 24), (5, 19), (6, 19)];
        indices.map(|(instance, index)| float(desk, instance, index))
    };
    let before = values(desk);
    for other in table::MODEL.units {
        desk.put(1, 46, &[1]).unwrap();
        desk.put(1, 22, &other.code.to_be_bytes()).unwrap();
        // Written back as read: the float is rounded once in this unit. A pressure of 3e-13 mbar and less is no positive
        // number of COUNTS.
        for instance in [1, 2, 3] {
            let octets = of_instance(desk, instance, 40);
            if float(desk, instance, 40) > 0.01 || other.name != "COUNTS" {
                desk.put(1, 40, &octets).unwrap();
            }
        }
    }
    desk.put(1, 46, &[1]).unwrap();
    desk.put(1, 22, &hex("05 1C")).unwrap();
    for (before, after) in before.into_iter().zip(values(desk)) {
        let same =
            (f64::from(after) - f64::from(before)).abs() <= f64::from(before) * 2e-5 + f64::from(f32::MIN_POSITIVE);
        assert!(same, "{before} became {after}");
    }
    desk.put(1, 22, &unit).unwrap();
    desk.put(1, 21, &number).unwrap();
    desk.put(1, 46, &selected).unwrap();
}

#[test]
fn a_million_steps_leave_a_named_state_and_equal_copies() {
    let mut random = Random::new(450);
    let mut desk = desk();
    let mut seen = Seen::default();
    for step in 0..STEPS {
        match random.below(20) {
            0..7 => cycle(&mut desk, &mut random),
            7..11 => write(&mut desk, &mut random),
            11..13 => read(&mut desk, &mut random),
            13..16 => pressure(&mut desk, &mut random),
            16 => operate(&mut desk, &mut random),
            17 => desk.device().advance(random.unit() * 60.0),
            18 => drop(desk.command(random.one_of(&[1, 2, 3, 3, 4, 4, 4, 5, 6]))),
            _ => match random.below(40) {
                0..3 => power(&mut desk, &mut random),
                3..8 => desk.unlock(),
                8..13 => desk.request_sdn(&[0x02, 0x00]),
                13 => units_there_and_back(&mut desk, &mut seen),
                _ => desk.device().settle(),
            },
        }
        if step % 200 == 0 {
            check(&mut desk);
            seen.note(&desk.report());
        }
    }
    assert_eq!(seen.states.len(), 7, "{:?}", seen.states);
    assert!(seen.degas && seen.relays == [true; 2] && seen.units > 100, "{} units", seen.units);
}

#[test]
fn any_octets_as_parameters_or_outputs_are_survived() {
    let mut random = Random::new(54);
    let mut desk = desk();
    for _ in 0..50_000 {
        let length = random.below(12);
        let octets = random.octets(length);
        let (slot, index) = (random.octet() % 3, random.octet());
        let _ = desk.write(relation(&mut random), slot, index, &octets);
        let _ = desk.read(relation(&mut random), slot, index);
        cycle(&mut desk, &mut random);
        if let Some(length) = desk.outputs() {
            desk.exchange(&random.octets(length));
        }
    }
    check(&mut desk);
}

/// What no mark lets a master write is not in the list of what is kept.
#[test]
fn the_list_of_what_is_kept_is_complete() {
    let mut kept: Vec<(u8, u8)> = Vec::new();
    for place in table::MODEL.places {
        for address in place.addresses.iter().filter(|address| address.instance != 0) {
            for row in place.block.rows.iter().filter(|row| row.is_kept() && row.access.intersects(Access::WRITE)) {
                kept.push((address.instance, row.id));
            }
        }
    }
    // Unit and type are those of the device.
    kept.retain(|(instance, index)| !matches!(index, 21 | 22) || *instance == 1);
    let mut listed: Vec<(u8, u8)> =
        KEPT.iter().flat_map(|(instance, indices)| indices.iter().map(|index| (*instance, *index))).collect();
    kept.sort_unstable();
    listed.sort_unstable();
    assert_eq!(listed, kept);
}
