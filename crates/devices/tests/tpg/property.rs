//! Random actions of master, operators and the power supply: statuses and relays agree, sets stay in order, and stored
//! settings are restored.

use crate::support::random::Random;
use crate::tpg::master::{
    ACCESS_CODE, Exchange, FILTER, LOWER, SETPOINT_STATUS, SOURCE, UNDERRANGE_CONTROL, UNIT, UPPER, VALIDATION,
    VOLATILITY,
};
use crate::tpg::{COLD, PIRANI, controller};
use profivac_devices::model::{DataType, Row};
use profivac_devices::tpg::{TpgGauge, table};
use profivac_devices::{Action, SimulatedDevice};

const STEPS: usize = 1_000_000;

/// A random walk, with the values that must survive power loss.
struct Walk {
    master: Exchange,
    random: Random,
    boards: [Option<TpgGauge>; 4],
    /// The values that a request to store saves, in the order of [`settings`].
    stored: Vec<u32>,
}

/// Slot and index of the values that are stored on request.
fn settings() -> impl Iterator<Item = (u8, u8)> {
    let device = [(0, ACCESS_CODE), (0, UNDERRANGE_CONTROL), (1, UNIT)];
    let filters = (1..=4).map(|slot| (slot, FILTER));
    let limits = (5..=10).flat_map(|slot| [UPPER, LOWER, SOURCE].map(|index| (slot, index)));
    device.into_iter().chain(filters).chain(limits)
}

/// Boards at random.
fn any_boards(random: &mut Random) -> [Option<TpgGauge>; 4] {
    [(); 4].map(|()| random.one_of(&[None, PIRANI, PIRANI, COLD, COLD]))
}

impl Walk {
    fn new(mut random: Random) -> Self {
        let boards = any_boards(&mut random);
        let mut master = Exchange::with(controller(boards));
        let stored = settings().map(|(slot, index)| master.read(slot, index).unwrap()).collect();
        Self { master, random, boards, stored }
    }

    /// Any row, with its slot.
    fn any_row(&mut self) -> (u8, &'static Row) {
        let placed = &table::TPG500.blocks[self.random.below(table::TPG500.blocks.len())];
        let address = &placed.locations[self.random.below(placed.locations.len())];
        (address.slot, &placed.block.rows[self.random.below(placed.block.rows.len())])
    }

    /// A random request, mostly a valid one. Volatility is left to [`store`](Self::store).
    fn request(&mut self) {
        let (slot, row) = self.any_row();
        if row.name == "Volatility" {
            return;
        }
        let value = match row.data_type {
            _ if self.random.once_in(20) => self.random.octets(4),
            DataType::ByType => 10f32.powf(self.random.unit() as f32 * 12.0 - 8.0).to_be_bytes().to_vec(),
            DataType::Int16 => vec![0, 0, self.random.octet() % 40, self.random.octet()],
            _ => vec![0, 0, 0, self.random.octet() % 6],
        };
        let ak = self.random.one_of(&[0, 0x10, 0x20, 0x20, 0x30, 0x30, 0xA0]);
        let request: [u8; 8] = [&[ak, slot, row.index, 0], &value[..]].concat().try_into().unwrap();
        let answer = self.master.cycle(request);
        assert_eq!(answer[1..4], [slot, row.index, 0][..], "{request:02X?}");
        assert!([0x00, 0x10, 0x20, 0x70, 0xB0].contains(&answer[0]), "{answer:02X?}");
        if answer[0] == 0x70 {
            // 148
            assert!([0, 1, 2, 3, 5, 17].contains(&answer[7]), "{answer:02X?}");
            assert_eq!(answer[4..7], [0; 3]);
        }
    }

    /// Validates open sets, so that the settings that are read are those that are stored, and asks for storage.
    fn store(&mut self) {
        for slot in 5..=10 {
            if self.master.write(slot, VALIDATION, 1).is_err() {
                return;
            }
        }
        let request = self.random.one_of(&[1, 2]);
        if self.master.write(0, VOLATILITY, request).is_ok() {
            self.stored = self.all();
        }
    }

    fn all(&mut self) -> Vec<u32> {
        settings().map(|(slot, index)| self.master.read(slot, index).unwrap()).collect()
    }

    fn power(&mut self) {
        self.master.power_cycle();
        assert_eq!(self.all(), self.stored);
        for slot in 5..=10 {
            assert_eq!(self.master.read(slot, VALIDATION), Ok(1));
        }
    }

    fn pressure(&mut self) {
        let parts = self.master.tester.device().parts().len();
        let pa = 10f64.powf(self.random.unit() * 18.0 - 12.0);
        match self.random.below(8) {
            part @ 0..4 if part < parts => self.master.tester.device().sense(part, pa),
            _ => self.master.tester.pressure_mbar(pa / 100.0),
        }
    }

    fn fault(&mut self) {
        let fault = self.random.one_of(table::TPG500.faults.faults);
        let active = self.random.once_in(12);
        self.master.tester.device().operate(Action::Fault { fault, active }).unwrap();
    }

    /// To another unit and back: no threshold changes beyond the rounding of a float.
    fn units_there_and_back(&mut self) {
        let limits = |walk: &mut Self| -> Vec<f32> {
            (5..=10).flat_map(|slot| [UPPER, LOWER].map(|index| walk.master.read_float(slot, index))).collect()
        };
        if self.master.write(1, UNIT, 1).is_err() {
            return;
        }
        let before = limits(self);
        for unit in [2, 3, 2, 1] {
            self.master.write(4, UNIT, unit).unwrap();
        }
        assert_eq!(limits(self), before);
    }

    fn step(&mut self) {
        match self.random.below(24) {
            0..10 => self.request(),
            10..13 => self.pressure(),
            13..15 => {
                self.master.sensor_on_off = self.random.octet();
                self.master.cycle([0; 8]);
            }
            15..18 => {
                let seconds = self.random.unit() * 20.0;
                self.master.advance(seconds);
            }
            18 => self.fault(),
            19..21 => {
                self.master.tester.device().settle();
                self.master.cycle([0; 8]);
            }
            21 => self.master.tester.request_sdn(&[0x02, 0x00]),
            _ => match self.random.below(60) {
                0 => self.power(),
                1..4 => self.store(),
                4 => self.units_there_and_back(),
                5..8 => {
                    self.master.tester.unlock();
                    self.master.bring_up();
                }
                _ => {}
            },
        }
    }

    /// The report agrees with the parameters.
    fn check(&mut self, seen: &mut Seen) {
        self.master.cycle([0; 8]);
        let (statuses, values) = (self.master.statuses(), self.master.values());
        for ((status, value), board) in statuses.into_iter().zip(values).zip(self.boards) {
            assert!(status <= 5);
            // 154, and a value in range otherwise
            assert_eq!(status >= 3, value == 0.0, "{statuses:?} {values:?}");
            assert!(board.is_some() || [3, 5].contains(&status));
            seen.statuses[usize::from(status)] = true;
        }
        let report = self.master.tester.device().report();
        for (slot, relay) in (5..).zip(report.relays.iter()) {
            assert_eq!(self.master.read(slot, SETPOINT_STATUS), Ok(u32::from(!relay)));
            seen.relays[slot as usize - 5] |= relay;
        }
        for slot in 5..=10 {
            let open = self.master.read(slot, VALIDATION) == Ok(0);
            assert!(open || self.master.read_float(slot, LOWER) <= self.master.read_float(slot, UPPER));
        }
        let units: Vec<_> = (1..=4).map(|slot| self.master.read(slot, UNIT)).collect();
        assert!(units.iter().all(|unit| *unit == units[0]));
        assert!(self.master.read(0, ACCESS_CODE).unwrap() <= 9999);
        // A cold cathode has status "off" exactly when it has no emission.
        let cathodes = (0..4).filter(|channel| self.boards[*channel] == COLD).map(|channel| statuses[channel]);
        for (status, on) in cathodes.zip(report.emission.iter()) {
            assert!(status == 3 || (status == 4) != *on, "{statuses:?} {report:?}");
        }
    }
}

/// The situations that the walk has met, so that it does not stay in one of them.
#[derive(Default)]
struct Seen {
    statuses: [bool; 6],
    relays: [bool; 4],
}

#[test]
fn a_million_steps_leave_statuses_relays_and_settings_consistent() {
    let mut walk = Walk::new(Random::new(300));
    let mut seen = Seen::default();
    for step in 0..STEPS {
        walk.step();
        if step % 200 == 0 {
            walk.check(&mut seen);
        }
        if step % 20_000 == 0 {
            walk = Walk::new(walk.random);
        }
    }
    assert_eq!(seen.statuses, [true; 6]);
    assert_eq!(seen.relays, [true; 4]);
}
