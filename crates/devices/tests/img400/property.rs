//! Random actions of masters, operators and the power supply: the controller is in a named state, its copies are equal,
//! and no stored value is lost.

use crate::img400::{Controller, controller, every_combination, float};
use crate::support::random::Random;
use crate::support::{Tester, sense_all};
use profivac_devices::img400::table;
use profivac_devices::model::{DataType, Row};
use profivac_devices::{Action, SimulatedDevice, StateReport};
use profivac_dp::slave::Relation;
use std::collections::BTreeSet;

const STEPS: usize = 1_000_000;

/// Any row of the tables, with its slot.
fn any_row(random: &mut Random) -> (u8, &'static Row) {
    let placed = &table::MODEL.blocks[random.below(table::MODEL.blocks.len())];
    let address = &placed.locations[random.below(placed.locations.len())];
    (address.slot, &placed.block.rows[random.below(placed.block.rows.len())])
}

/// Octets that are mostly valid for a row.
fn any_value(random: &mut Random, row: &Row) -> Vec<u8> {
    if random.once_in(20) {
        let length = random.below(6);
        return random.octets(length);
    }
    match row.data_type {
        _ if row.name == "Reset Error Condition" => vec![random.octet()],
        DataType::Boolean | DataType::Uint8 => vec![random.octet() % 8],
        DataType::Record(_) => vec![random.one_of(&[0, 0, 1, 3, 4]), random.octet() % 2],
        DataType::Float => f32::to_be_bytes(random.below(8) as f32).to_vec(),
        DataType::ByType if random.once_in(2) => random.octets(2),
        _ => 10f32.powf(random.unit() as f32 * 16.0 - 10.0).to_be_bytes().to_vec(),
    }
}

fn relation(random: &mut Random) -> Relation {
    random.one_of(&[Relation::Ms1, Relation::Ms2(0), Relation::Ms2(1)])
}

/// Every parameter that keeps the value of a master.
fn kept(tester: &mut Tester<Controller>) -> Vec<Vec<u8>> {
    let mut values = Vec::new();
    for placed in table::MODEL.blocks {
        for address in placed.locations {
            for row in placed.block.rows.iter().filter(|row| row.is_stored()) {
                values.push(tester.get(address.slot, row.index));
            }
        }
    }
    values
}

/// A write to any parameter. A refused write changes nothing.
fn write(tester: &mut Tester<Controller>, random: &mut Random) {
    let (slot, row) = any_row(random);
    let octets = any_value(random, row);
    let before = random.once_in(100).then(|| kept(tester));
    let result = tester.write(relation(random), slot, row.index, &octets);
    if let (Some(before), Err(refusal)) = (before, result) {
        assert_eq!(kept(tester), before, "{slot}/{} refused with {refusal:02X?}", row.index);
    }
}

/// A read of any slot and index, known or unknown.
fn read(tester: &mut Tester<Controller>, random: &mut Random) {
    let (slot, row) = any_row(random);
    let index = if random.once_in(5) { random.octet() } else { row.index };
    let _ = tester.read(relation(random), slot, index);
}

/// A cycle, if there is an exchange, otherwise the bring-up of one.
fn cycle(tester: &mut Tester<Controller>, random: &mut Random) {
    let Some(length) = tester.outputs() else {
        let prm = &table::MODEL.user_prm[random.below(table::MODEL.user_prm.len())];
        let configuration = &table::MODEL.configurations[random.below(table::MODEL.configurations.len())];
        return tester.bring_up(prm.octets, configuration.octets);
    };
    let mut outputs = vec![0; length];
    if length >= 8 {
        let (slot, row) = any_row(random);
        let value = any_value(random, row);
        let width = value.len().min(4);
        outputs[..3].copy_from_slice(&[random.one_of(&[0, 0x10, 0x20, 0x30, 0xA0, 0x70]), slot, row.index]);
        outputs[8 - width..8].copy_from_slice(&value[..width]);
    }
    if length == 2 || length == 10 {
        outputs[length - 2..].copy_from_slice(&[random.one_of(&[0, 0, 1, 3, 4, 77]), random.octet() % 2]);
    }
    if random.once_in(50) {
        outputs.push(0);
    }
    let inputs = tester.exchange(&outputs);
    assert!([9, 17, 18, 25, 26, 34].contains(&inputs.len()), "{inputs:02X?}");
}

/// Power is lost and returns: nonvolatile values are as before.
fn power(tester: &mut Tester<Controller>, random: &mut Random) {
    let before = kept(tester);
    tester.device().set_power(false);
    sense_all(tester.device(), 1.0);
    tester.device().set_power(true);
    tester.slave.power_up(5);
    if random.once_in(2) {
        tester.device().settle();
    }
    assert_eq!(kept(tester), before);
}

/// An action of an operator at the controller.
fn operate(tester: &mut Tester<Controller>, random: &mut Random) {
    let action = match random.below(4) {
        0 => Action::Button(random.one_of(&[1, 2])),
        _ => Action::Fault { fault: random.one_of(table::MODEL.faults.faults), active: random.once_in(12) },
    };
    tester.device().operate(action).unwrap();
}

fn pressure(tester: &mut Tester<Controller>, random: &mut Random) {
    let pa = 10f64.powf(random.unit() * 18.0 - 12.0);
    match random.below(8) {
        part @ 0..4 => tester.device().sense(part, pa),
        _ => tester.pressure_mbar(pa / 100.0),
    }
}

/// The situations that the walk has met, so that it does not stay in one of them.
#[derive(Default)]
struct Seen {
    states: BTreeSet<&'static str>,
    exceptions: u8,
    degas: bool,
    relays: [bool; 7],
    units: usize,
}

impl Seen {
    fn note(&mut self, report: &StateReport) {
        self.states.insert(report.device_state.name());
        self.exceptions |= report.exception_status;
        self.degas |= report.degas.iter().any(|degas| *degas);
        for (seen, relay) in self.relays.iter_mut().zip(report.relays.iter()) {
            *seen |= relay;
        }
    }
}

/// The report and the cyclic data agree with the parameters.
fn check(tester: &mut Tester<Controller>) {
    let report = tester.report();
    let state = tester.state();
    assert_eq!(state == 4, report.device_state.name() == "EXECUTING", "{report:?}");
    assert!(matches!(state, 1..=6 | 100), "{state}");
    check_exceptions(tester, &report);
    check_cathodes(tester, &report);
    check_relays(tester, &report);
    check_cyclic(tester);
}

/// Exception Status and Channel Status agree with the states behind them.
fn check_exceptions(tester: &mut Tester<Controller>, report: &StateReport) {
    let status = tester.get(0, 26)[0];
    assert_eq!(status, report.exception_status);
    assert_eq!(status & 0x88, 0x80);
    assert_eq!(status & 0x01 != 0, status & 0x10 != 0, "{status:02X}");
    let alarms = (1..=4).any(|slot| tester.get(slot, 103) != [0, 0]);
    assert_eq!(status & 0x02 != 0, alarms, "{status:02X}");
    let extensions: Vec<u8> = (1..=4).map(|slot| tester.get(slot, 102)[0]).collect();
    assert_eq!(status & 0x20 != 0, extensions.iter().any(|extension| *extension != 0), "{status:02X}");
    assert_eq!(tester.get(0, 204), [extensions[1] << 4 | extensions[0], extensions[3] << 4 | extensions[2]]);
    for (slot, extension) in (1..).zip(extensions) {
        // Reading Invalid is set whenever Reading Valid is not.
        assert!(tester.get(slot, 23) == [1] || extension & 1 == 1, "{slot}: {extension:02X}");
        assert!([0, 1, 2, 3, 4, 5].contains(&extension));
    }
}

/// No degas without emission, no emission with an alarm.
fn check_cathodes(tester: &mut Tester<Controller>, report: &StateReport) {
    for (on, degas) in report.emission.iter().zip(report.degas.iter()) {
        assert!(*on || !degas, "{report:?}");
    }
    for slot in [1, 2] {
        let on = tester.get(slot, 105) == [1];
        assert!(!on || tester.get(slot, 103) == [0, 0], "channel {slot}");
        assert!(on || tester.get(slot, 102)[0] & 1 == 1, "channel {slot} is off and has no Reading Invalid");
    }
}

fn check_relays(tester: &mut Tester<Controller>, report: &StateReport) {
    for (slot, relay) in (5..).zip(report.relays.iter()) {
        assert_eq!(tester.get(slot, 21), [u8::from(*relay)]);
        assert!(!relay || tester.get(slot, 20) == [1], "relay in slot {slot} without enable");
        assert_eq!([tester.get(slot, 28), tester.get(slot, 29)], [tester.get(1, 22), tester.get(1, 21)]);
        if tester.get(1, 21) == [8] {
            assert!(float(tester, slot, 201) >= float(tester, slot, 19), "slot {slot}");
        }
    }
}

/// The end of every telegram agrees with the parameters.
fn check_cyclic(tester: &mut Tester<Controller>) {
    let Some(outputs) = tester.outputs() else { return };
    let inputs = tester.exchange(&vec![0; outputs]);
    let values: Vec<u8> = (1..=4).flat_map(|slot| tester.get(slot, 19)).collect();
    let relays: Vec<u8> = (5..=11).flat_map(|slot| tester.get(slot, 21)).collect();
    let short = [tester.get(0, 26), values].concat();
    let long = [short.clone(), tester.get(0, 204), relays].concat();
    assert!(inputs.ends_with(&short) || inputs.ends_with(&long), "{inputs:02X?}");
}

/// Through every unit and back: no physical value changes beyond the rounding of a float.
fn units_there_and_back(tester: &mut Tester<Controller>, seen: &mut Seen) {
    tester.unlock();
    tester.put(1, 21, &[8]).unwrap();
    tester.set_prm(&[0, 0, 0, 0x13, 0x08]);
    seen.units += 1;
    let values = |tester: &mut Tester<Controller>| {
        let safe = [1, 2, 3, 4].map(|slot| float(tester, slot, 40));
        let trips = [5, 6, 7, 8, 9, 10, 11].map(|slot| [float(tester, slot, 19), float(tester, slot, 201)]);
        [&safe[..], trips.as_flattened()].concat()
    };
    let before = values(tester);
    for unit in table::MODEL.user_prm {
        tester.set_prm(unit.octets);
        // Written back as read: the float is rounded once in this unit. 10^-12.5 hPa and less is no positive number of
        // COUNTS.
        for (slot, index) in [(1, 40), (2, 40), (3, 40), (4, 40), (5, 201), (6, 19), (7, 24)] {
            let octets = tester.get(slot, index);
            if float(tester, slot, index) > 0.01 || unit.name != "COUNTS" {
                let _ = tester.put(slot, index, &octets);
            }
        }
    }
    tester.set_prm(&[0, 0, 0, 0x13, 0x08]);
    for (before, after) in before.into_iter().zip(values(tester)) {
        let same = (f64::from(after) - f64::from(before)).abs() <= f64::from(before) * 5e-5 + 1e-37;
        assert!(same, "{before} became {after}");
    }
    tester.unlock();
}

#[test]
fn a_million_steps_leave_a_named_state_and_equal_copies() {
    let mut random = Random::new(400);
    let mut seen = Seen::default();
    let combinations: Vec<_> = every_combination().collect();
    let mut tester: Tester<Controller> = Tester::new(controller(combinations[40]));
    for step in 0..STEPS {
        match random.below(20) {
            0..7 => cycle(&mut tester, &mut random),
            7..11 => write(&mut tester, &mut random),
            11..13 => read(&mut tester, &mut random),
            13..16 => pressure(&mut tester, &mut random),
            16 => operate(&mut tester, &mut random),
            17 => tester.device().advance(random.unit() * 60.0),
            18 => drop(tester.command(random.one_of(&[1, 2, 3, 3, 4, 4, 4, 5, 6]))),
            _ => match random.below(40) {
                0..3 => power(&mut tester, &mut random),
                3..8 => tester.unlock(),
                8..13 => tester.request_sdn(&[0x02, 0x00]),
                13 => units_there_and_back(&mut tester, &mut seen),
                14 => tester = Tester::new(controller(random.one_of(&combinations))),
                _ => tester.device().settle(),
            },
        }
        if step % 200 == 0 {
            check(&mut tester);
            seen.note(&tester.report());
        }
    }
    assert_eq!(seen.states.len(), 7, "{:?}", seen.states);
    assert_eq!(seen.exceptions, 0xF7);
    assert!(seen.degas && seen.relays == [true; 7] && seen.units > 100, "{} units", seen.units);
}

#[test]
fn any_octets_as_parameters_or_outputs_leave_the_device_working() {
    let mut random = Random::new(40);
    let mut tester = crate::img400::tester();
    for _ in 0..50_000 {
        let length = random.below(12);
        let octets = random.octets(length);
        let (slot, index) = (random.octet() % 13, random.octet());
        let _ = tester.write(relation(&mut random), slot, index, &octets);
        let _ = tester.read(relation(&mut random), slot, index);
        cycle(&mut tester, &mut random);
        if let Some(length) = tester.outputs() {
            tester.exchange(&random.octets(length));
        }
    }
    check(&mut tester);
}
