//! Identity, station address and nonvolatile memory. tira41d1 1.2, 3.1, Appendix A, (8), (34) to (37), (73).

use crate::bcg450::{FLOATS, Gauge, MBAR, gauge, tester};
use crate::support::counting_store::CountingStore;
use crate::support::{Tester, hex, off, sense_all};
use profivac_devices::bcg450::{Bcg450, table};
use profivac_devices::profile::{SerialNumber, Setup};
use profivac_devices::store::{Key, RamStore, Store};
use profivac_devices::{Action, SimulatedDevice, Switch, UnsupportedAction};
use profivac_dp::slave::{Device, Dpv1Error, Relation};
use profivac_wire::acyclic::ErrorCode;
use profivac_wire::address::SetSlaveAdd;

#[test]
fn the_identity_is_that_of_the_manual() {
    let mut tester =
        Tester::new(Gauge::new(RamStore::default(), Setup { serial: SerialNumber::new("4711"), ..Setup::new(5) }));
    for (index, text) in [
        (17, "CG      "),
        (18, "E54-0997 "),
        (19, "INFICON AG          "),
        (20, "353-554             "),
        (22, "1.0     "),
        (23, "4711                          "),
        (24, "BCG450-SP                                         "),
    ] {
        assert_eq!(String::from_utf8(tester.get(0, index)).unwrap(), text, "{index}");
    }
    // xxx_y.yy (36)
    let revision = tester.get(0, 21);
    assert_eq!((revision.len(), revision[3], revision[5]), (8, b'_', b'.'));
    // Types of Appendix B (32), constant (117), as a word and two zeros (31).
    assert_eq!(tester.get(0, 16), hex("00 01 00 00"));
    assert_eq!(tester.get(1, 16), hex("00 03 00 00"));
    for (instance, block_type) in [(1, "00 0D 00 00"), (2, "00 10 00 00"), (3, "00 0E 00 00"), (4, "01 00 00 00")] {
        assert_eq!(crate::bcg450::of_instance(&mut tester, instance, 101), hex(block_type));
    }
}

/// (73), (100), (111), (113)
#[test]
fn a_new_gauge_has_the_values_of_the_factory() {
    let mut tester = tester();
    assert_eq!(tester.get(1, 46), [1]);
    for (instance, index, octets) in [
        (1, 21, "08"),
        (1, 22, "05 1C"),
        (1, 39, "00"),
        (2, 40, "00 00 00 00"),
        (2, 201, "01"),
        (5, 201, "00"),
        (6, 202, "00 32"),
    ] {
        assert_eq!(crate::bcg450::of_instance(&mut tester, instance, index), hex(octets), "{instance}/{index}");
    }
}

#[test]
fn the_selector_is_restored_after_power_up() {
    let mut tester = tester();
    tester.put(1, 46, &[6]).unwrap();
    tester.device().set_power(false);
    tester.device().set_power(true);
    assert_eq!(tester.get(1, 46), [6]);
}

#[test]
fn the_setup_sets_the_unit_that_is_stored() {
    let unit = table::MODEL.unit_named("pascal");
    assert!(unit.is_some());
    let mut tester = Tester::new(Gauge::new(RamStore::default(), Setup { unit, ..Setup::new(5) }));
    assert_eq!(tester.get(1, 22), hex("05 1D"));
    tester.device().set_power(false);
    tester.device().set_power(true);
    assert_eq!(tester.get(1, 22), hex("05 1D"));
    for (name, code) in
        [("COUNTS", 1001), ("torr", 1301), ("micron", 1302), ("mtorr", 1302), ("mbar", 1308), ("Pa", 1309)]
    {
        assert_eq!(table::MODEL.unit_named(name).map(|unit| unit.code), Some(code), "{name}");
    }
    assert_eq!(table::MODEL.unit_named("psi"), None);
}

#[test]
fn a_valid_switch_is_the_address_and_closes_set_slave_add() {
    for switch in [0, 5, 125] {
        let mut gauge = Gauge::new(RamStore::default(), Setup::new(switch));
        assert_eq!((gauge.station_address(), gauge.address_is_settable()), (switch, false));
        assert_eq!(gauge.set_address(&request(7, 0)), None);
        assert_eq!(gauge.station_address(), switch);
    }
}

const fn request(address: u8, no_add_chg: u8) -> SetSlaveAdd<'static> {
    SetSlaveAdd { address, ident: 0x08E6, no_add_chg, rem_slave_data: &[] }
}

#[test]
fn the_stored_address_holds_with_a_switch_above_125() {
    for switch in [126, 127, 255] {
        let mut gauge = Gauge::new(RamStore::default(), Setup::new(switch));
        assert_eq!((gauge.station_address(), gauge.address_is_settable()), (126, true));
        assert_eq!(gauge.set_address(&request(126, 0)), None);
        assert_eq!(gauge.set_address(&request(9, 0)), Some(9));
        assert_eq!(gauge.set_address(&request(10, 0xFF)), Some(10));
        assert_eq!(gauge.set_address(&request(11, 0)), None, "No_Add_Chg");
        gauge.set_power(false);
        gauge.set_power(true);
        assert_eq!(gauge.station_address(), 10);
        assert_eq!(gauge.set_address(&request(11, 0)), None, "No_Add_Chg survives the power-up");
    }
}

/// 1.2: the switch is read at power-up, and a valid setting is stored.
#[test]
fn the_switch_is_read_at_power_up() {
    let mut gauge = gauge();
    gauge.operate(Action::Switch(Switch::Address(17))).unwrap();
    assert_eq!(gauge.station_address(), 5);
    gauge.set_power(false);
    gauge.set_power(true);
    assert_eq!(gauge.station_address(), 17);
    gauge.operate(Action::Switch(Switch::Address(200))).unwrap();
    assert_eq!((gauge.station_address(), gauge.address_is_settable()), (17, false));
    gauge.set_power(false);
    gauge.set_power(true);
    assert_eq!((gauge.station_address(), gauge.address_is_settable()), (17, true));
    let action = Action::Button(1);
    assert_eq!(gauge.operate(action), Err(UnsupportedAction { action }));
}

/// A write stores one value under one key, so that a power cut leaves the old or the new one; an equal value is not
/// stored again.
#[test]
fn a_write_is_stored_once() {
    let mut gauge = Bcg450::new(CountingStore::default(), Setup::new(200));
    gauge.settle();
    let saved = |gauge: &mut Bcg450<CountingStore>, index, value| {
        let before = gauge.store().saved;
        gauge.write(Relation::Ms2(0), 1, index, &hex(value)).unwrap();
        gauge.store().saved - before
    };
    for (index, value) in [(22, "05 15"), (21, "03"), (39, "02"), (40, "00 07"), (46, "05"), (202, "00 64")] {
        assert_eq!(saved(&mut gauge, index, value), 1, "{index}");
        assert_eq!(saved(&mut gauge, index, value), 0, "{index} again");
    }
}

/// A positive answer means stored, a failed save changes nothing.
#[test]
fn a_write_that_cannot_be_stored_is_refused_and_changes_nothing() {
    let mut gauge = Bcg450::new(CountingStore::broken(), Setup::new(200));
    gauge.settle();
    let storage = Err(Dpv1Error { code_1: ErrorCode(0xA1), code_2: 18 });
    let read = |gauge: &mut Bcg450<CountingStore>, index| {
        let mut record = [0; 240];
        let length = gauge.read(Relation::Ms2(0), 1, index, &mut record).unwrap();
        record[..length].to_vec()
    };
    for (index, value) in [(46, "03"), (39, "01"), (40, "3F 80 00 00"), (21, "03"), (22, "05 15")] {
        let before = read(&mut gauge, index);
        assert_eq!(gauge.write(Relation::Ms2(0), 1, index, &hex(value)), storage, "{index}");
        assert_eq!(read(&mut gauge, index), before, "{index}");
    }
    assert_eq!(gauge.set_address(&request(9, 0)), None);
    // Volatile values stay.
    assert_eq!(gauge.write(Relation::Ms2(0), 0, 15, &[4]), Ok(()));
    // The unit of the exchange is not stored, but it stays.
    assert_eq!(gauge.set_prm(&hex("00 00 00 05 15")), Ok(()));
    assert_eq!(read(&mut gauge, 22), hex("05 15"));
    // The write of the same unit has to be stored, so it is refused: a positive answer means stored.
    gauge.write(Relation::Ms2(0), 0, 15, &[5]).unwrap();
    assert_eq!(gauge.write(Relation::Ms2(0), 1, 22, &hex("05 15")), storage);
}

#[test]
fn a_stored_value_out_of_range_is_ignored() {
    let mut store = RamStore::<96>::default();
    for (instance, index, octets) in [
        (0, 46, "09"),
        (1, 39, "04"),
        (2, 39, "01 02"),
        (3, 40, "7F F8 00 00 00 00 00 00"),
        (0, 22, "00 00"),
        (0, 21, "08"),
        (5, 202, "FF FF"),
    ] {
        store.save(Key::Parameter { slot: 1, instance, index }, &hex(octets)).unwrap();
    }
    store.save(Key::Internal(0), &hex("01")).unwrap();
    store.save(Key::Address, &hex("09")).unwrap();
    let mut gauge = Gauge::new(store, Setup::new(200));
    sense_all(&mut gauge, 1.0);
    assert_eq!(gauge.station_address(), 126);
    let mut tester = Tester::new(gauge);
    assert_eq!(tester.get(1, 46), [1]);
    for (instance, index, octets) in
        [(1, 39, "00"), (2, 39, "00"), (3, 40, "00 00 00 00"), (1, 22, "05 1C"), (5, 202, "00 32")]
    {
        assert_eq!(crate::bcg450::of_instance(&mut tester, instance, index), hex(octets), "{instance}/{index}");
    }
}

/// Without power the device does not change, and the simulation reports it.
#[test]
fn a_device_without_power_reports_off() {
    let mut tester = tester();
    tester.bring_up(&hex(MBAR), &hex(FLOATS));
    off::shows_nothing(tester.device());
    assert_eq!((tester.report().device_state.name(), tester.report().run_hours), ("INIT", 0.0));
    tester.device().advance(3600.0);
    assert_eq!(tester.report().run_hours, 1.0);
}

/// (29): the instance that one master selects is the one that all masters read.
#[test]
fn all_masters_share_one_selector() {
    let mut tester = crate::bcg450::exchanging("C6 87 8E 0A 0A 05 05 05 08", 1e-3);
    for instance in 1..=6 {
        tester.write(Relation::Ms2(0), 1, 46, &[instance]).unwrap();
        assert_eq!(tester.read(Relation::Ms1, 1, 46), Ok(vec![instance]));
    }
}

/// (33): the sensor blocks have a type, the blocks behind them have none.
#[test]
fn the_block_type_of_slot_1_is_the_same_for_every_instance() {
    let mut tester = tester();
    let types: Vec<_> = (1..=6).map(|instance| crate::bcg450::of_instance(&mut tester, instance, 16)).collect();
    assert_eq!(types, vec![hex("00 03 00 00"); 6]);
}
