//! A random walk: after any actions of masters, operators and the power supply a gauge is in a named state, values that
//! are in several locations agree, and no stored value is lost.

use super::random::Random;
use super::{Tester, sense_all};
use profivac_devices::model::{Configuration, DataType, Field, Model, NumberType, Row, Storage, UserPrm};
use profivac_devices::{Action, SimulatedDevice, StateReport};
use profivac_dp::slave::Relation;
use std::collections::BTreeSet;

/// The properties of a device.
pub struct Particular<D> {
    /// Its tables.
    pub model: &'static Model,
    /// Device Block State Commands to choose from.
    pub commands: &'static [u8],
    /// Whether a configuration is accepted after a user parameter string.
    pub fits: fn(&UserPrm, &Configuration) -> bool,
    /// The actions of an operator.
    pub action: fn(&mut Random) -> Action,
    /// Nonvolatile rows (slot and index) that can change without a write.
    pub moving: &'static [(u8, u8)],
    /// Further properties that must hold.
    pub check: fn(&mut Tester<D>),
}

/// The situations that the walk has met, so that it does not stay in one of them.
#[derive(Default)]
pub struct Seen {
    pub states: BTreeSet<&'static str>,
    pub active: BTreeSet<u8>,
    pub degas: bool,
    pub relays: [bool; 2],
    pub units: usize,
}

impl Seen {
    fn note(&mut self, report: &StateReport) {
        self.states.insert(report.device_state.name());
        self.active.insert(report.active_instance);
        self.degas |= report.degas.iter().eq([&true]);
        for (seen, relay) in self.relays.iter_mut().zip(report.relays.iter()) {
            *seen |= relay;
        }
    }
}

/// The state of a random walk.
pub struct Walk<D> {
    pub tester: Tester<D>,
    pub random: Random,
    pub seen: Seen,
    particular: Particular<D>,
    /// Slot, instance and row of every parameter.
    rows: Vec<(u8, u8, &'static Row)>,
}

impl<D: SimulatedDevice> Walk<D> {
    pub fn new(tester: Tester<D>, particular: Particular<D>, seed: u64) -> Self {
        let locations = particular.model.blocks.iter();
        let at = locations.flat_map(|placed| placed.locations.iter().map(move |address| (address, placed.block)));
        let rows = at.flat_map(|(at, block)| block.rows.iter().map(move |row| (at.slot, at.instance, row))).collect();
        Self { tester, random: Random::new(seed), seen: Seen::default(), particular, rows }
    }

    /// Runs this number of steps and checks all properties at intervals.
    pub fn steps(&mut self, steps: usize) {
        for step in 0..steps {
            self.step();
            if step % 200 == 0 {
                self.check();
                self.seen.note(&self.tester.report());
            }
        }
    }

    fn step(&mut self) {
        match self.random.below(20) {
            0..7 => self.cycle(),
            7..11 => self.write(),
            11..13 => self.read(),
            13..16 => self.pressure(),
            16 => self.operate(),
            17 => {
                let seconds = self.random.unit() * 60.0;
                self.tester.device().advance(seconds);
            }
            18 => drop(self.tester.command(self.random.one_of(self.particular.commands))),
            _ => self.seldom(),
        }
    }

    fn seldom(&mut self) {
        match self.random.below(40) {
            0..3 => self.power(),
            3..8 => self.tester.unlock(),
            8..13 => self.tester.request_sdn(&[0x02, 0x00]),
            13 => self.units_there_and_back(),
            _ => self.tester.device().settle(),
        }
    }

    /// The octets of slot 1 for an instance; the octets of another slot.
    fn get(&mut self, slot: u8, instance: u8, index: u8) -> Vec<u8> {
        if instance != 0 {
            self.tester.put(1, 46, &[instance]).unwrap();
        }
        self.tester.get(slot, index)
    }

    /// Reads something and restores the Channel Instance Selector.
    fn peek<T>(&mut self, look: impl FnOnce(&mut Self) -> T) -> T {
        let selected = self.tester.get(1, 46);
        let seen = look(self);
        self.tester.put(1, 46, &selected).unwrap();
        seen
    }

    /// All values that must survive a power cut.
    fn kept(&mut self) -> Vec<Vec<u8>> {
        let moving = self.particular.moving;
        let kept = |(slot, _, row): &(u8, u8, &'static Row)| row.is_stored() && !moving.contains(&(*slot, row.index));
        let rows: Vec<_> = self.rows.iter().copied().filter(kept).collect();
        self.peek(|walk| walk.read_all(&rows))
    }

    /// Rows in the order of the tables, so that the instance changes seldom.
    fn read_all(&mut self, rows: &[(u8, u8, &'static Row)]) -> Vec<Vec<u8>> {
        let mut selected = 0;
        let read = |(slot, instance, row): &(u8, u8, &'static Row)| {
            let again = std::mem::replace(&mut selected, *instance) == *instance;
            self.get(*slot, if again { 0 } else { *instance }, row.index)
        };
        rows.iter().map(read).collect()
    }

    fn any_row(&mut self) -> (u8, u8, &'static Row) {
        self.rows[self.random.below(self.rows.len())]
    }

    /// Octets that are mostly valid for a row of this type.
    fn any_value(&mut self, row: &Row) -> Vec<u8> {
        let random = &mut self.random;
        if random.once_in(20) {
            let length = random.below(6);
            return random.octets(length);
        }
        match row.data_type {
            DataType::Boolean | DataType::Uint8 => vec![random.octet() % 8],
            DataType::Uint16 if row.name.starts_with("Data Unit") => {
                let units = self.particular.model.units;
                units[random.below(units.len())].code.to_be_bytes().to_vec()
            }
            DataType::Uint16 => (random.below(1500) as u16).to_be_bytes().to_vec(),
            DataType::Record(2) => vec![random.one_of(&[0, 1, 3, 128]), random.octet() % 2],
            DataType::ByType if random.once_in(2) => random.octets(2),
            _ => (10f32.powf(random.unit() as f32 * 12.0 - 8.0)).to_be_bytes().to_vec(),
        }
    }

    fn relation(&mut self) -> Relation {
        self.random.one_of(&[Relation::Ms1, Relation::Ms2(0), Relation::Ms2(1)])
    }

    /// A write to any parameter. A refused write changes nothing.
    fn write(&mut self) {
        let (slot, instance, row) = self.any_row();
        let (octets, relation) = (self.any_value(row), self.relation());
        if instance != 0 && !self.random.once_in(10) {
            self.tester.put(1, 46, &[instance]).unwrap();
        }
        let before = self.random.once_in(50).then(|| self.kept());
        let result = self.tester.write(relation, slot, row.index, &octets);
        if let (Some(before), Err(refusal)) = (before, result) {
            assert_eq!(self.kept(), before, "{slot}/{} refused with {refusal:02X?}", row.index);
        }
    }

    /// A read of any slot and index, known or unknown.
    fn read(&mut self) {
        let (slot, _, row) = self.any_row();
        let index = if self.random.once_in(5) { self.random.octet() } else { row.index };
        let relation = self.relation();
        let _ = self.tester.read(relation, slot, index);
    }

    fn configuration(&mut self) -> &'static Configuration {
        let octets = self.tester.device().get_cfg().to_vec();
        self.particular.model.configuration(&octets).unwrap()
    }

    /// A cycle, if there is an exchange, otherwise the bring-up of one.
    pub fn cycle(&mut self) {
        if !self.tester.is_exchanging() {
            return self.bring_up();
        }
        let configuration = self.configuration();
        let mut outputs = Vec::new();
        for (_, field) in configuration.outputs.into_iter().flat_map(|telegram| telegram.layout()) {
            let octets = self.any_output(field);
            outputs.extend(octets);
        }
        if self.random.once_in(50) {
            outputs.push(0);
        }
        let inputs = self.tester.exchange(&outputs);
        assert_eq!(inputs.len(), configuration.input_octets(), "{inputs:02X?}");
    }

    /// With any configuration after any user parameters: accepted if they fit together.
    fn bring_up(&mut self) {
        let model = self.particular.model;
        let prm = &model.user_prm[self.random.below(model.user_prm.len())];
        let configuration = &model.configurations[self.random.below(model.configurations.len())];
        self.tester.set_prm(prm.octets);
        self.tester.chk_cfg(configuration.octets);
        assert_eq!(self.tester.is_exchanging(), (self.particular.fits)(prm, configuration), "{configuration:?}");
    }

    fn any_output(&mut self, field: Field) -> Vec<u8> {
        if field != Field::ParameterChannel {
            return (0..field.octets()).map(|_| self.random.one_of(&[0, 1, 1, 2, 3, 77, 128])).collect();
        }
        let (slot, _, row) = self.any_row();
        let value = self.any_value(row);
        let mut octets = vec![self.random.one_of(&[0, 0x10, 0x20, 0x30, 0xA0, 0x70]), slot, row.index, 0, 0, 0, 0, 0];
        let width = value.len().min(4);
        octets[8 - width..].copy_from_slice(&value[..width]);
        octets
    }

    /// Power is lost and returns: nonvolatile values are as before.
    fn power(&mut self) {
        let before = (self.tester.get(1, 46), self.kept());
        self.tester.device().set_power(false);
        sense_all(self.tester.device(), 1.0);
        self.tester.device().set_power(true);
        self.tester.slave.power_up(5);
        if self.random.once_in(2) {
            self.tester.device().settle();
        }
        assert_eq!((self.tester.get(1, 46), self.kept()), before);
    }

    /// An action of an operator at the gauge.
    fn operate(&mut self) {
        let action = if self.random.once_in(2) {
            Action::Fault {
                fault: self.random.one_of(self.particular.model.faults.faults),
                active: self.random.once_in(8),
            }
        } else {
            (self.particular.action)(&mut self.random)
        };
        self.tester.device().operate(action).unwrap();
    }

    /// The pressure of one part, or of the chamber.
    fn pressure(&mut self) {
        let parts = self.tester.device().parts().len();
        let pa = 10f64.powf(self.random.unit() * 18.0 - 11.0);
        match self.random.below(parts + 1) {
            part if part < parts => self.tester.device().sense(part, pa),
            _ => self.tester.pressure_mbar(pa / 100.0),
        }
    }

    /// The report and the cyclic data agree with the parameters.
    pub fn check(&mut self) {
        let names = ["INIT", "SELFTESTING", "IDLE", "SELFTESTEXCEPTION", "EXECUTING", "ABORT", "CRITICALFAULT"];
        let report = self.tester.report();
        assert_eq!(report.device_state.name(), names[usize::from(self.tester.state())]);
        assert_eq!(report.exception_status & 0x88, 0x80);
        assert_eq!(self.tester.get(0, 26), [report.exception_status]);
        assert_eq!(self.tester.get(1, 47), [report.active_instance]);
        self.check_inputs(&report);
        self.peek(|walk| (walk.particular.check)(&mut walk.tester));
        let executing = report.device_state.name() == "EXECUTING";
        assert!(executing || report.relays.iter().chain(report.emission.iter()).all(|on| !on), "{report:?}");
        assert!(report.emission.iter().eq([&true]) || report.degas.iter().all(|on| !on), "{report:?}");
        assert!(report.outputs_safe || executing, "{report:?}");
    }

    /// Every field of the inputs that is a parameter.
    fn check_inputs(&mut self, report: &StateReport) {
        let Some(outputs) = self.tester.outputs() else { return };
        let inputs = self.tester.exchange(&vec![0; outputs]);
        let telegram = self.configuration().inputs.unwrap();
        for (start, field) in telegram.layout() {
            let expected = match field {
                Field::ExceptionStatus => vec![report.exception_status],
                Field::StatusExtension => self.tester.get(1, 120),
                Field::PvSelector => vec![report.active_instance],
                Field::ProcessValue(_) => self.peek(|walk| walk.get(1, report.active_instance, 19)),
                Field::TripRelays(_) => [self.tester.get(2, 21), self.tester.get(3, 21)].concat(),
                _ => continue,
            };
            assert_eq!(inputs[start..start + field.octets()], expected, "{field:?}");
        }
    }

    /// Through every unit and back, in IDLE: no physical value changes beyond the rounding of a float.
    fn units_there_and_back(&mut self) {
        self.tester.unlock();
        self.particular.model.faults.names().for_each(|name| self.tester.fault(name, false));
        let _ = self.tester.command(1);
        self.tester.device().settle();
        assert_eq!(self.tester.state(), 2);
        self.seen.units += 1;
        self.peek(|walk| {
            let [number, unit] = [21, 22].map(|index| walk.get(1, 1, index));
            walk.tester.put(1, 21, &[NumberType::Float.code()]).unwrap();
            walk.set_unit("mbar");
            let before = walk.pressures();
            walk.particular.model.units.iter().for_each(|unit| walk.round_in(unit.name));
            walk.set_unit("mbar");
            for (before, after) in before.into_iter().zip(walk.pressures()) {
                let slack = f64::from(before) * 2e-5 + f64::from(f32::MIN_POSITIVE);
                assert!((f64::from(after) - f64::from(before)).abs() <= slack, "{before} became {after}");
            }
            walk.get(1, 1, 22);
            walk.tester.put(1, 22, &unit).unwrap();
            walk.tester.put(1, 21, &number).unwrap();
        });
    }

    fn set_unit(&mut self, name: &str) {
        let code = self.particular.model.unit_named(name).unwrap().code;
        self.get(1, 1, 22);
        self.tester.put(1, 22, &code.to_be_bytes()).unwrap();
    }

    /// Every Safe Value is written back as it is read, and so is rounded once in this unit. A pressure far below every
    /// range is no positive number of COUNTS.
    fn round_in(&mut self, unit: &str) {
        self.set_unit(unit);
        let parts: Vec<u8> = self.tester.report().indicated.iter().map(|indicated| indicated.instance).collect();
        for instance in parts {
            let octets = self.get(1, instance, 40);
            if f32::from_be_bytes(octets.clone().try_into().unwrap()) > 0.01 || unit != "COUNTS" {
                self.tester.put(1, 40, &octets).unwrap();
            }
        }
    }

    /// Every pressure that is no measured value.
    fn pressures(&mut self) -> Vec<f32> {
        let fixed = |row: &Row| row.data_type == DataType::ByType && row.storage == Storage::Nonvolatile;
        let rows: Vec<_> = self.rows.iter().copied().filter(|(_, _, row)| fixed(row)).collect();
        self.read_all(&rows).into_iter().map(|octets| f32::from_be_bytes(octets.try_into().unwrap())).collect()
    }

    /// Random octets as parameters and as outputs.
    pub fn any_octets(&mut self, rounds: usize) {
        for _ in 0..rounds {
            let length = self.random.below(12);
            let octets = self.random.octets(length);
            let (slot, index, relation) = (self.random.octet() % 7, self.random.octet(), self.relation());
            let _ = self.tester.write(relation, slot, index, &octets);
            let _ = self.tester.read(relation, slot, index);
            self.cycle();
            if let Some(length) = self.tester.outputs() {
                let outputs = self.random.octets(length);
                self.tester.exchange(&outputs);
            }
        }
        self.check();
    }
}
