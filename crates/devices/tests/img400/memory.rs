//! Nonvolatile values. BG 5530 tables 1 to 4, Appendix B; errata-pxg55x-img400 26, 119, 143, 153, 154.

use crate::img400::{COMMANDS, Controller, FLOATS, HPA, controller, exchanging, float, put_float, tester};
use crate::support::{Tester, hex, off};
use profivac_devices::img400::{Gauges, Img400, table};
use profivac_devices::profile::Setup;
use profivac_devices::store::RamStore;
use profivac_devices::{Action, SimulatedDevice, Switch};
use profivac_dp::slave::Device;
use profivac_wire::address::SetSlaveAdd;

fn power_cycle(tester: &mut Tester<Controller>) {
    tester.device().set_power(false);
    tester.device().set_power(true);
    tester.slave.power_up(5);
    tester.device().settle();
}

#[test]
fn unit_and_adjustments_are_restored_after_power_up() {
    let mut tester = exchanging(FLOATS, 0.5);
    tester.put(4, 15, &[0, 1]).unwrap();
    tester.unlock();
    tester.set_prm(&hex("00 00 00 13 09"));
    power_cycle(&mut tester);
    assert_eq!(tester.get(2, 22), [0x13, 0x09]);
    tester.bring_up(&hex(HPA), &hex(FLOATS));
    assert_eq!(float(&mut tester, 4, 19), 0.0);
    tester.pressure_mbar(1.5);
    assert_eq!(float(&mut tester, 4, 19), 1.0);
}

#[test]
fn a_trip_point_is_restored_as_it_was_in_any_order_of_writes() {
    let writes: [&[(u8, f32)]; 5] = [
        &[(19, 5.0)],
        &[(19, 1e-30), (201, 1.0)],
        &[(19, 5.0), (24, 2.0)],
        &[(201, 9.0), (19, 5.0)],
        &[(24, 4.0), (19, 1e-6), (201, 2e-6)],
    ];
    for writes in writes {
        let mut tester = exchanging(FLOATS, 1.0);
        for (index, value) in writes {
            put_float(&mut tester, 8, *index, *value).unwrap();
        }
        let before = [19, 24, 201].map(|index| float(&mut tester, 8, index));
        // A change to another unit in between has no effect on the numbers.
        tester.unlock();
        tester.set_prm(&hex("00 00 00 10 01"));
        power_cycle(&mut tester);
        tester.set_prm(&hex(HPA));
        let after = [19, 24, 201].map(|index| float(&mut tester, 8, index));
        for (before, after) in before.into_iter().zip(after) {
            assert!((after - before).abs() <= 1e-6 * before, "{writes:?}: {before} became {after}");
        }
    }
}

#[test]
fn commands_and_volatile_values_are_lost_with_the_power() {
    // (26, 150)
    let mut tester = exchanging(FLOATS, 1e-6);
    tester.put(1, 14, &[3, 1]).unwrap();
    tester.put(0, 203, &[2]).unwrap();
    power_cycle(&mut tester);
    assert_eq!(tester.get(1, 105), [0]);
    assert_eq!(tester.get(0, 203), [0]);
    assert_eq!(tester.state(), 2);
    assert_eq!([tester.get(0, 15), tester.get(1, 14)], [vec![0], vec![0, 0]]);
}

#[test]
fn the_block_of_a_channel_is_fixed_until_the_next_start() {
    // (154): channel 4 has a diaphragm gauge.
    let mut tester = tester();
    assert_eq!(tester.get(4, 101), [0, 14, 0, 0]);
    tester.fault("unplugged4", true);
    assert_eq!(tester.get(4, 101), [0, 14, 0, 0]);
    power_cycle(&mut tester);
    assert_eq!(tester.get(4, 101), [0, 13, 0, 0], "a place holder");
    assert_eq!(float(&mut tester, 4, 45), 8e-4, "of a Pirani gauge (156)");
    tester.fault("unplugged4", false);
    assert_eq!(tester.get(4, 101), [0, 13, 0, 0]);
    assert_eq!(tester.get(4, 102), [1], "plugged in too late");
    tester.command(1).unwrap();
    tester.device().settle();
    assert_eq!(tester.get(4, 101), [0, 14, 0, 0]);
    assert_eq!(float(&mut tester, 4, 45), 0.1);
}

#[test]
fn the_unit_of_the_setup_is_stored() {
    let setup = Setup { unit: table::MODEL.unit_named("torr"), ..Setup::new(5) };
    let mut tester: Tester<Controller> = Tester::new(Img400::new(RamStore::default(), setup, Gauges::default()));
    assert_eq!(tester.get(1, 22), [0x13, 0x01]);
    power_cycle(&mut tester);
    assert_eq!(tester.get(1, 22), [0x13, 0x01]);
}

#[test]
fn the_address_comes_from_the_switch_or_from_set_slave_add() {
    // (119)
    for switch in [126, 127, 255] {
        let mut device: Controller = Img400::new(RamStore::default(), Setup::new(switch), Gauges::default());
        assert_eq!(device.station_address(), 126);
        let request = SetSlaveAdd { address: 17, ident: 0x0947, no_add_chg: 0, rem_slave_data: &[] };
        assert_eq!(device.set_address(&request), Some(17));
        device.set_power(false);
        device.set_power(true);
        assert_eq!(device.station_address(), 17);
    }
    let mut device = controller(Gauges::default());
    assert!(!device.address_is_settable());
    device.operate(Action::Switch(Switch::Address(126))).unwrap();
    assert_eq!(device.station_address(), 5, "the switch is read at power-up");
}

/// Without power the device does not change, and the simulation reports it.
#[test]
fn a_device_without_power_reports_off() {
    let mut tester = exchanging(COMMANDS, 1e-6);
    tester.exchange(&[3, 1]);
    assert!(tester.report().emission.iter().eq([&true, &true]));
    off::shows_nothing(tester.device());
}
