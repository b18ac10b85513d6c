//! Identity, station address and nonvolatile memory. tira36e1 1.2, 3.1, Appendix A, (8), (34) to (37), (73).

use crate::support::counting_store::CountingStore;
use crate::support::{Tester, hex, off};
use crate::xpg400::{FLOATS, Gauge, KINDS, exchanging, gauge, of_instance, restart, tester};
use profivac_devices::profile::{SerialNumber, Setup};
use profivac_devices::store::{Key, RamStore, Store};
use profivac_devices::xpg400::{Xpg400, Xpg400Model};
use profivac_devices::{Action, SimulatedDevice, Switch, UnsupportedAction};
use profivac_dp::slave::{Device, Dpv1Error, Relation};
use profivac_wire::acyclic::ErrorCode;
use profivac_wire::address::SetSlaveAdd;

#[test]
fn the_identity_is_that_of_the_manual() {
    for (kind, number, title) in [
        (Xpg400Model::Bpg, "353-505             ", "BPG400-SP"),
        (Xpg400Model::Hpg, "353-525             ", "HPG400-SP"),
    ] {
        let setup = Setup { serial: SerialNumber::new("4711"), ..Setup::new(5) };
        let mut tester = Tester::new(Gauge::new(RamStore::default(), kind, setup));
        for (index, text) in [
            (17, "CG      "),
            (18, "E54-0997 "),
            (19, "INFICON AG          "),
            (20, number),
            (21, "1.01    "),
            (22, "1.0     "),
            (23, "4711                          "),
            (24, format!("{title:<50}").as_str()),
        ] {
            assert_eq!(String::from_utf8(tester.get(0, index)).unwrap(), text, "{index}");
        }
        // (31)
        assert_eq!(tester.get(0, 16), hex("00 01 00 00"));
        assert_eq!(tester.get(1, 16), hex("00 03 00 00"));
        for (instance, block_type) in [(1, "00 0D 00 00"), (2, "00 10 00 00")] {
            assert_eq!(of_instance(&mut tester, instance, 101), hex(block_type));
        }
    }
}

/// (73)
#[test]
fn a_new_gauge_has_the_values_of_the_factory() {
    for kind in KINDS {
        let mut tester = tester(kind);
        assert_eq!(tester.get(1, 46), [1]);
        for (instance, index, octets) in
            [(1, 21, "08"), (1, 22, "05 1C"), (1, 39, "00"), (2, 39, "00"), (2, 40, "00 00 00 00"), (1, 140, "00")]
        {
            assert_eq!(of_instance(&mut tester, instance, index), hex(octets), "{instance}/{index}");
        }
    }
}

#[test]
fn the_selector_is_restored_after_power_up() {
    let mut tester = tester(Xpg400Model::Hpg);
    tester.put(1, 46, &[4]).unwrap();
    restart(&mut tester);
    assert_eq!(tester.get(1, 46), [4]);
}

const fn request(address: u8, no_add_chg: u8) -> SetSlaveAdd<'static> {
    SetSlaveAdd { address, ident: 0x06A8, no_add_chg, rem_slave_data: &[] }
}

/// 1.2, (8): 00 to 7D are an address; above 7D the address stored by Set_Slave_Add is valid.
#[test]
fn the_address_comes_from_the_switch_or_from_memory() {
    for switch in [0, 5, 125] {
        let mut gauge = Gauge::new(RamStore::default(), Xpg400Model::Hpg, Setup::new(switch));
        assert_eq!((gauge.station_address(), gauge.address_is_settable()), (switch, false));
        assert_eq!(gauge.set_address(&request(7, 0)), None);
    }
    for switch in [126, 127, 255] {
        let mut gauge = Gauge::new(RamStore::default(), Xpg400Model::Hpg, Setup::new(switch));
        assert_eq!((gauge.station_address(), gauge.address_is_settable()), (126, true));
        assert_eq!(gauge.set_address(&request(9, 0)), Some(9));
        gauge.set_power(false);
        gauge.set_power(true);
        assert_eq!(gauge.station_address(), 9);
    }
    let mut gauge = gauge(Xpg400Model::Bpg);
    gauge.operate(Action::Switch(Switch::Address(17))).unwrap();
    assert_eq!(gauge.station_address(), 5, "it is read at power-up");
    gauge.set_power(false);
    gauge.set_power(true);
    assert_eq!(gauge.station_address(), 17);
    let action = Action::Button(1);
    assert_eq!(gauge.operate(action), Err(UnsupportedAction { action }));
}

/// A write stores one value under one key, so that a power cut leaves the old or the new one; an equal value is not
/// stored again.
#[test]
fn a_write_is_stored_once() {
    let mut gauge = Xpg400::new(CountingStore::default(), Xpg400Model::Bpg, Setup::new(200));
    gauge.settle();
    let mut saved = |index, value| {
        let before = gauge.store().saved;
        gauge.write(Relation::Ms2(0), 1, index, &hex(value)).unwrap();
        gauge.store().saved - before
    };
    for (index, value) in [(22, "05 15"), (21, "03"), (39, "02"), (40, "00 07"), (46, "02")] {
        assert_eq!((saved(index, value), saved(index, value)), (1, 0), "{index}");
    }
}

/// A positive answer means stored, a failed save changes nothing.
#[test]
fn a_write_that_cannot_be_stored_is_refused_and_changes_nothing() {
    let mut gauge = Xpg400::new(CountingStore::broken(), Xpg400Model::Hpg, Setup::new(200));
    gauge.settle();
    let read = |gauge: &mut Xpg400<CountingStore>, index| {
        let mut record = [0; 240];
        let length = gauge.read(Relation::Ms2(0), 1, index, &mut record).unwrap();
        record[..length].to_vec()
    };
    for (index, value) in [(46, "03"), (39, "01"), (40, "3F 80 00 00"), (21, "03"), (22, "05 15")] {
        let before = read(&mut gauge, index);
        let result = gauge.write(Relation::Ms2(0), 1, index, &hex(value));
        assert_eq!(result, Err(Dpv1Error { code_1: ErrorCode(0xA1), code_2: 18 }), "{index}");
        assert_eq!(read(&mut gauge, index), before, "{index}");
    }
    // Volatile values stay.
    assert_eq!(gauge.write(Relation::Ms2(0), 0, 15, &[4]), Ok(()));
}

#[test]
fn a_stored_value_out_of_range_is_ignored() {
    let mut store = RamStore::<96>::default();
    for (instance, index, octets) in
        [(0, 46, "05"), (1, 39, "04"), (2, 40, "7F F8 00 00 00 00 00 00"), (0, 22, "13 08"), (0, 21, "05")]
    {
        store.save(Key::Parameter { slot: 1, instance, index }, &hex(octets)).unwrap();
    }
    store.save(Key::Internal(0), &hex("7F F0 00 00 00 00 00 00")).unwrap();
    let mut tester = Tester::new(Gauge::new(store, Xpg400Model::Bpg, Setup::new(5)));
    tester.pressure_mbar(1.0);
    tester.command(4).unwrap();
    assert_eq!(tester.get(1, 46), [1]);
    for (instance, index, octets) in
        [(1, 39, "00"), (2, 40, "00 00 00 00"), (1, 22, "05 1C"), (1, 21, "08"), (1, 19, "3F 80 00 00")]
    {
        assert_eq!(of_instance(&mut tester, instance, index), hex(octets), "{instance}/{index}");
    }
}

/// Without power the device does not change, and the simulation reports it.
#[test]
fn a_device_without_power_reports_off() {
    for kind in KINDS {
        off::shows_nothing(exchanging(kind, FLOATS, 1e-6).device());
    }
}
