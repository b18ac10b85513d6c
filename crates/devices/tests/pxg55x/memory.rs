//! Nonvolatile values, the factory reset, and the run hours. 7.1.14, 7.1.23, 7.2.2, (76), (85),
//! (102).

use crate::pxg55x::{CHANNEL, FLOATS, Gauge, MBAR, exchanging, float, of_instance, pcg, psg, restart, tester};
use crate::support::{Tester, hex, off};
use profivac_devices::SimulatedDevice;
use profivac_devices::model::Octets;
use profivac_devices::profile::Setup;
use profivac_devices::pxg55x::{Pxg55x, Pxg55xModel};
use profivac_devices::store::{Key, RamStore, Store, StoreError};
use profivac_dp::slave::{Device, Relation};

fn run_hours(tester: &mut Tester<Gauge>) -> (u16, u32) {
    let [hours, quarters] = [36, 212].map(|index| tester.get(0, index));
    (u16::from_be_bytes(hours.try_into().unwrap()), u32::from_be_bytes(quarters.try_into().unwrap()))
}

#[test]
fn run_hours_count_device_time_and_persist() {
    let mut tester = tester(pcg());
    assert_eq!(run_hours(&mut tester), (0, 0));
    tester.device().advance(899.0);
    assert_eq!(run_hours(&mut tester), (0, 0));
    tester.device().advance(1.0);
    assert_eq!(run_hours(&mut tester), (0, 1));
    for _ in 0..3 {
        tester.device().advance(900.0);
    }
    assert_eq!(run_hours(&mut tester), (1, 4));
    restart(&mut tester);
    assert_eq!(run_hours(&mut tester), (1, 4));
    tester.device().advance(1800.0);
    assert_eq!((run_hours(&mut tester), tester.report().run_hours), ((1, 6), 1.5));
    // Neither simulated time nor settling counts while the power is off.
    tester.device().set_power(false);
    tester.device().advance(36_000.0);
    tester.device().set_power(true);
    assert_eq!(run_hours(&mut tester), (1, 6));
    // ID 36 = floor(ID 212 / 4), saturating (76).
    tester.device().advance(3600.0 * 70_000.0);
    assert_eq!(run_hours(&mut tester), (65_535, 280_006));
}

/// The settings of every block: slot, instance, index, a value that differs from the factory's.
const SETTINGS: [(u8, u8, u8, &str); 26] = [
    (1, 1, 39, "01"),
    (1, 2, 39, "02"),
    (1, 3, 39, "03"),
    (1, 1, 40, "3F 80 00 00"),
    (1, 2, 40, "40 00 00 00"),
    (1, 3, 40, "40 40 00 00"),
    (1, 1, 41, "01"),
    (1, 2, 201, "01"),
    (2, 0, 17, "42 C8 00 00"),
    (2, 0, 18, "01"),
    (2, 0, 19, "41 20 00 00"),
    (2, 0, 20, "00"),
    (2, 0, 31, "3F 80 00 00"),
    (2, 0, 32, "3F 00 00 00"),
    (2, 0, 201, "3F 00 00 00"),
    (2, 0, 202, "04"),
    (3, 0, 17, "42 48 00 00"),
    (3, 0, 18, "01"),
    (3, 0, 19, "3F 80 00 00"),
    (3, 0, 20, "00"),
    (3, 0, 31, "40 00 00 00"),
    (3, 0, 32, "3E 80 00 00"),
    (3, 0, 201, "3F 40 00 00"),
    (3, 0, 202, "04"),
    // Unit and number type last: the other values are floats in mbar.
    (1, 1, 22, "13 08"),
    (1, 1, 21, "08"),
];

fn read(tester: &mut Tester<Gauge>, slot: u8, instance: u8, index: u8) -> Vec<u8> {
    if instance == 0 { tester.get(slot, index) } else { of_instance(tester, instance, index) }
}

fn settings(tester: &mut Tester<Gauge>) -> Vec<Vec<u8>> {
    SETTINGS.iter().map(|(slot, instance, index, _)| read(tester, *slot, *instance, *index)).collect()
}

fn changed(kind: Pxg55xModel) -> Tester<Gauge> {
    let mut tester = tester(kind);
    for (slot, instance, index, value) in SETTINGS {
        if instance != 0 {
            tester.put(1, 46, &[instance]).unwrap();
        }
        tester.put(slot, index, &hex(value)).unwrap();
    }
    tester
}

#[test]
fn all_settings_are_restored_after_power_up() {
    let mut tester = changed(pcg());
    tester.put(1, 46, &[3]).unwrap();
    restart(&mut tester);
    assert_eq!(tester.get(1, 46), [3]);
    let expected: Vec<Vec<u8>> = SETTINGS.iter().map(|(.., value)| hex(value)).collect();
    assert_eq!(settings(&mut tester), expected);
}

/// In COUNTS a hysteresis is a distance; it is stored as a pressure.
#[test]
fn settings_in_counts_and_integers_are_restored_after_power_up() {
    let mut tester = changed(pcg());
    tester.put(1, 22, &hex("10 01")).unwrap();
    tester.put(1, 21, &[3]).unwrap();
    tester.put(2, 31, &hex("03 E8")).unwrap();
    let before = settings(&mut tester);
    restart(&mut tester);
    assert_eq!(settings(&mut tester), before);
    assert_eq!(tester.get(2, 31), hex("03 E8"));
}

/// (85), (102)
#[test]
fn a_new_gauge_has_the_trip_points_of_the_factory() {
    let mut tester = tester(pcg());
    assert_eq!((tester.get(1, 46), tester.get(1, 22), tester.get(1, 21)), (vec![1], hex("13 08"), vec![8]));
    for instance in [1, 2, 3] {
        assert_eq!(of_instance(&mut tester, instance, 39), [0]);
        assert_eq!(of_instance(&mut tester, instance, 40), [0; 4]);
    }
    assert_eq!((of_instance(&mut tester, 1, 41), of_instance(&mut tester, 2, 201)), (vec![0], vec![0]));
    for slot in [2, 3] {
        let floats = [17, 19, 31, 32].map(|index| crate::pxg55x::float_of(&tester.get(slot, index)));
        assert_eq!(floats, [5e-5, 5e-5, 5e-6, 5e-6]);
        assert_eq!([18, 20, 202].map(|index| tester.get(slot, index)), [[0], [1], [0]]);
    }
}

/// 7.2.2, command 128: "Used for reinitializing the device ... to the factory settings."
#[test]
fn a_factory_reset_resets_settings_and_adjustments_but_not_run_hours() {
    let factory = settings(&mut tester(pcg()));
    let mut tester = changed(pcg());
    tester.command(4).unwrap();
    tester.pressure_mbar(500.0);
    for (instance, command) in [(1, 0), (2, 1), (3, 1)] {
        tester.put(1, 46, &[instance]).unwrap();
        let _ = tester.put(1, 15, &[command, 0]);
    }
    tester.device().advance(7200.0);
    assert_eq!(float(&mut tester, 1, 19), 0.0);
    tester.command(128).unwrap();
    // The reset is stored: it holds after a power cycle.
    for power_cut in [false, true] {
        if power_cut {
            restart(&mut tester);
        }
        tester.device().settle();
        assert_eq!(settings(&mut tester), factory);
        tester.command(4).unwrap();
        let values = [1, 2, 3].map(|instance| float(&mut tester, instance, 19));
        assert_eq!(values, [500.0, 500.0, 1013.25]);
        assert_eq!((run_hours(&mut tester), tester.device().station_address()), ((2, 8), 5));
    }
}

/// Commands 1 and 129 reinitialise and keep nonvolatile values.
#[test]
fn other_resets_keep_the_settings() {
    for command in [1, 129] {
        let mut tester = changed(pcg());
        let before = settings(&mut tester);
        tester.command(command).unwrap();
        tester.device().settle();
        assert_eq!(settings(&mut tester), before, "command {command}");
    }
}

/// The unit and number type of a master hold as long as it exchanges data.
#[test]
fn a_factory_reset_during_data_exchange_keeps_the_unit() {
    let mut tester = tester(psg());
    tester.pressure_mbar(100.0);
    tester.bring_up(&hex("00 00 00 13 09"), &hex("C4 87 8A 0A 0A 05 03"));
    // By the parameter channel: AK 10, slot 0, index 15, 128.
    assert_eq!(tester.channel([0xA0, 0, 15, 0, 0, 0, 0, 128]), [0xB0, 0, 15, 0, 0, 0, 0, 128]);
    tester.device().settle();
    assert_eq!((tester.get(1, 22), tester.get(1, 21)), (hex("13 09"), vec![3]));
    tester.command(4).unwrap();
    assert_eq!(tester.exchange(&[0; 8])[8..], hex("80 27 10"));
}

/// The unit of the setup is stored at power-up.
#[test]
fn the_setup_sets_the_stored_unit() {
    for unit in pcg().variant().model.units {
        let setup = Setup { unit: Some(unit), ..Setup::new(5) };
        let mut tester = Tester::new(Gauge::new(RamStore::default(), pcg(), setup));
        assert_eq!(tester.get(1, 22), unit.code.to_be_bytes());
        restart(&mut tester);
        assert_eq!(tester.get(1, 22), unit.code.to_be_bytes());
    }
}

/// A memory that refuses every write.
#[derive(Default)]
struct Full(RamStore);

impl Store for Full {
    fn load(&self, key: Key, octets: &mut [u8]) -> Option<usize> {
        self.0.load(key, octets)
    }

    fn save_all(&mut self, _values: &mut dyn Iterator<Item = (Key, Octets)>) -> Result<(), StoreError> {
        Err(StoreError)
    }
}

#[test]
fn a_write_that_cannot_be_stored_is_refused_and_changes_nothing() {
    let mut tester = Tester::new(profivac_devices::pxg55x::Pxg55x::new(Full::default(), pcg(), Setup::new(5)));
    for (slot, index, value) in [(2, 19, "42 C8 00 00"), (2, 202, "04"), (1, 39, "01"), (1, 22, "13 01")] {
        let before = tester.get(slot, index);
        assert_eq!(tester.put(slot, index, &hex(value)), Err(18), "{slot}/{index}");
        assert_eq!(tester.get(slot, index), before, "{slot}/{index}");
    }
    // The gauge still accepts a master.
    tester.bring_up(&hex(MBAR), &hex(CHANNEL));
}

/// A memory whose power is cut after a number of saves.
struct Cut {
    store: RamStore,
    /// The number of saves that succeed before.
    saves_left: usize,
}

impl Store for Cut {
    fn load(&self, key: Key, octets: &mut [u8]) -> Option<usize> {
        self.store.load(key, octets)
    }

    fn save_all(&mut self, values: &mut dyn Iterator<Item = (Key, Octets)>) -> Result<(), StoreError> {
        self.saves_left = self.saves_left.checked_sub(1).ok_or(StoreError)?;
        self.store.save_all(values)
    }
}

/// The settings and the address after the next power-up with this memory.
fn kept_in(store: &RamStore) -> (Vec<Vec<u8>>, Option<[u8; 2]>) {
    let mut address = [0; 2];
    let address = store.load(Key::Address, &mut address).map(|_| address);
    (settings(&mut Tester::new(Gauge::new(store.clone(), pcg(), Setup::new(200)))), address)
}

/// A factory reset changes many values and lifts No_Add_Chg. A power cut at any instant of it leaves all old values or all
/// values of the factory.
#[test]
fn a_factory_reset_is_stored_in_whole_or_not_at_all() {
    let mut changed = changed(pcg()).device().store().clone();
    changed.save(Key::Address, &[9, 1]).unwrap();
    let (old, factory) = (kept_in(&changed), (settings(&mut tester(pcg())), Some([9, 0])));
    let kept = [0, 1].map(|saves_left| {
        let mut gauge = Pxg55x::new(Cut { store: changed.clone(), saves_left }, pcg(), Setup::new(200));
        gauge.settle();
        let result = gauge.write(Relation::Ms2(0), 0, 15, &[128]);
        assert_eq!(result.is_ok(), saves_left == 1, "{result:?}");
        kept_in(&gauge.store().store)
    });
    assert_eq!(kept, [old, factory]);
}

/// The unit of a master stays after data exchange: all settings "are overwritten" (8.1.6).
#[test]
fn the_unit_of_a_master_is_stored() {
    let mut tester = tester(pcg());
    tester.bring_up(&hex("00 00 00 13 01"), &hex("42 82 05 03"));
    tester.unlock();
    restart(&mut tester);
    assert_eq!((tester.get(1, 22), tester.get(1, 21)), (hex("13 01"), vec![3]));
}

/// Without power the device does not change, and the simulation reports it.
#[test]
fn a_device_without_power_reports_off() {
    for kind in Pxg55xModel::all() {
        off::shows_nothing(exchanging(kind, FLOATS, 1.0).device());
    }
}
