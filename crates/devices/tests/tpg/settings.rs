//! The settings of a master: units, filters, access code, storage on request. IF300P/IF301P manual
//! 3.2.3.2, 3.2.4.1; errata-bpg-bcg-tpg 131, 132, 143, 146, 147, 149.

use crate::support::{Tester, off};
use crate::tpg::master::{
    A1, ACCESS_CODE, B1, Exchange, FILTER, LOWER, RELAY_1, SOURCE, UNDERRANGE_CONTROL, UNIT, UPPER, VALIDATION,
    VOLATILITY,
};
use crate::tpg::{BOARDS, Controller, controller};
use profivac_devices::profile::Setup;
use profivac_devices::store::{Key, RamStore, Store};
use profivac_devices::tpg::{Tpg, table};
use profivac_devices::{Action, SimulatedDevice, Switch};
use profivac_dp::slave::Device;
use profivac_wire::address::SetSlaveAdd;

/// Volatility.
const STORE: u16 = 1;
const STORE_AND_HOTSTART: u16 = 2;

fn exchange() -> Exchange {
    Exchange::new(BOARDS)
}

#[test]
fn the_program_version_has_a_digit_in_each_nibble() {
    assert_eq!(exchange().read(0, 21), Ok(0x5097_3101));
    let mut tester: Tester<Controller> =
        Tester::new(Tpg::new(&table::TPG300, RamStore::default(), Setup::new(5), BOARDS));
    tester.bring_up(&[], &[0x97, 0xA7, 0xA0]);
    assert_eq!(tester.exchange(&[0x10, 0, 21, 0, 0, 0, 0, 0, 0]), [0x20, 0, 21, 0, 0x50, 0x97, 0x80, 0x06]);
}

#[test]
fn a_unit_written_to_one_block_holds_for_all_values() {
    let mut master = exchange();
    master.pressure(10.0);
    for (slot, unit, value) in [(2, 2, 7.500_617), (4, 3, 1000.0), (1, 1, 10.0f32)] {
        master.write(slot, UNIT, unit).unwrap();
        for slot in 1..=4 {
            assert_eq!(master.read(slot, UNIT), Ok(unit.into()));
        }
        assert_eq!(master.values()[..2], [value, value]);
    }
}

#[test]
fn a_slower_filter_shows_a_change_later() {
    let mut shares = Vec::new();
    for filter in 1..=3 {
        let mut master = exchange();
        master.write(A1, FILTER, filter).unwrap();
        master.pressure(1.0);
        master.tester.pressure_mbar(100.0);
        master.advance(0.2);
        shares.push(master.values()[0]);
        // Each channel has its own filter.
        assert_eq!(master.read(2, FILTER), Ok(2));
    }
    assert!(shares.is_sorted_by(|fast, slow| fast > slow), "{shares:?}");
    assert!(shares.iter().all(|share| *share > 1.0 && *share < 100.0), "{shares:?}");
}

#[test]
fn access_code_9919_can_never_be_changed() {
    let mut master = exchange();
    for code in [1212, 9999, 0, 9919] {
        assert_eq!(master.write(0, ACCESS_CODE, code), Ok(()));
        assert_eq!(master.read(0, ACCESS_CODE), Ok(code.into()));
    }
    assert_eq!(master.write(0, ACCESS_CODE, 0), Err(1));
    assert_eq!(master.read(0, ACCESS_CODE), Ok(9919));
}

/// Slot, index, another value than from the factory.
const BYTES: [(u8, u8, u16); 7] = [
    (0, ACCESS_CODE, 1234),
    (0, UNDERRANGE_CONTROL, 1),
    (A1, UNIT, 2),
    (A1, FILTER, 3),
    (2, FILTER, 1),
    (B1, FILTER, 3),
    (4, FILTER, 1),
];

fn write_everything(master: &mut Exchange) {
    for (slot, index, value) in BYTES {
        master.write(slot, index, value).unwrap();
    }
    for slot in 5..=10u8 {
        let lower = f32::from(slot);
        master.thresholds(slot, lower, 2.0 * lower, slot % 4 + 1).unwrap();
    }
}

fn assert_everything(master: &mut Exchange) {
    for (slot, index, value) in BYTES {
        assert_eq!(master.read(slot, index), Ok(value.into()), "{slot}/{index}");
    }
    for slot in 5..=10u8 {
        let lower = f32::from(slot);
        assert_eq!(master.read_float(slot, LOWER), lower);
        assert_eq!(master.read_float(slot, UPPER), 2.0 * lower);
        assert_eq!(master.read(slot, SOURCE), Ok((slot % 4 + 1).into()));
        assert_eq!(master.read(slot, VALIDATION), Ok(1));
    }
}

#[test]
fn a_setting_is_lost_with_the_power_unless_it_was_stored() {
    let mut master = exchange();
    write_everything(&mut master);
    assert_everything(&mut master);
    master.power_cycle();
    for (slot, index, value) in BYTES {
        assert_ne!(master.read(slot, index), Ok(value.into()), "{slot}/{index}");
    }
    assert_eq!(master.read_float(RELAY_1, LOWER), 1e-3);

    write_everything(&mut master);
    master.write(0, VOLATILITY, STORE).unwrap();
    assert_eq!(master.read(0, VOLATILITY), Ok(STORE.into()));
    master.advance(0.1);
    assert_eq!(master.read(0, VOLATILITY), Ok(0));
    // Changed after the request: not stored.
    master.write(A1, FILTER, 1).unwrap();
    master.power_cycle();
    assert_everything(&mut master);
    master.power_cycle();
    assert_everything(&mut master);
    // A write of 0 stores nothing.
    master.write(A1, UNIT, 3).unwrap();
    assert_eq!(master.write(0, VOLATILITY, 0), Ok(()));
    master.power_cycle();
    assert_everything(&mut master);
}

#[test]
fn a_set_in_preparation_is_not_stored() {
    let mut master = exchange();
    master.write(RELAY_1, VALIDATION, 0).unwrap();
    master.write_float(RELAY_1, UPPER, 5.0).unwrap();
    master.write(0, VOLATILITY, STORE).unwrap();
    master.power_cycle();
    assert_eq!(master.read(RELAY_1, VALIDATION), Ok(1));
    assert_eq!(master.read_float(RELAY_1, UPPER), 2e-3);
}

#[test]
fn a_power_cut_while_storing_leaves_the_thresholds_in_order() {
    // (137): only the lower threshold of the new set, 1 mbar, has reached the memory.
    let mut store = RamStore::default();
    store.save(Key::Parameter { slot: RELAY_1, instance: 0, index: LOWER }, &100f64.to_be_bytes()).unwrap();
    let mut master = Exchange::with(Tpg::new(&table::TPG500, store, Setup::new(5), BOARDS));
    assert_eq!(master.read(RELAY_1, VALIDATION), Ok(1));
    assert_eq!(master.read_float(RELAY_1, LOWER), 1.0);
    assert_eq!(master.read_float(RELAY_1, UPPER), 1.0);
}

#[test]
fn hotstart_restores_the_switches_of_the_sensors() {
    let mut master = exchange();
    master.pressure(1.0);
    // A2 and B2 off, B1 on although the pressure is too high for automatic control.
    master.command(0x74);
    assert_eq!(master.statuses(), [0, 4, 2, 4]);
    master.write(0, VOLATILITY, STORE_AND_HOTSTART).unwrap();
    master.power_cycle();
    assert_eq!(master.statuses(), [0, 4, 2, 4]);
    master.write(0, VOLATILITY, STORE).unwrap();
    master.power_cycle();
    assert_eq!(master.statuses(), [0, 0, 4, 4], "without hotstart");
}

#[test]
fn the_unit_of_the_setup_is_stored() {
    let setup = Setup { unit: table::TPG500.unit_named("torr"), ..Setup::new(5) };
    let mut master = Exchange::with(Tpg::new(&table::TPG500, RamStore::default(), setup, BOARDS));
    assert_eq!(master.read(A1, UNIT), Ok(2));
    master.write(A1, UNIT, 3).unwrap();
    master.power_cycle();
    assert_eq!(master.read(A1, UNIT), Ok(2));
}

#[test]
fn the_address_comes_from_the_switch_or_from_set_slave_add() {
    // (149)
    let mut device: Controller = Tpg::new(&table::TPG500, RamStore::default(), Setup::new(126), BOARDS);
    assert_eq!(device.station_address(), 126);
    let request = SetSlaveAdd { address: 17, ident: 0x05D9, no_add_chg: 0, rem_slave_data: &[] };
    assert_eq!(device.set_address(&request), Some(17));
    device.set_power(false);
    device.set_power(true);
    assert_eq!(device.station_address(), 17);
    device.operate(Action::Switch(Switch::Address(9))).unwrap();
    device.set_power(false);
    device.set_power(true);
    assert_eq!(device.station_address(), 9);
    assert!(!device.address_is_settable());
}

/// Without power the device does not change, and the simulation reports it.
#[test]
fn a_device_without_power_reports_off() {
    off::shows_nothing(&mut controller(BOARDS));
}
