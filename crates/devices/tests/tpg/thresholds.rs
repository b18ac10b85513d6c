//! Relays and cold cathodes, and their thresholds. IF300P/IF301P manual 3.2.3.2, 3.2.4.2; errata-bpg-bcg-tpg 137 to 144.

use crate::tpg::master::{
    A1, B1, COLD_CATHODE_B, Exchange, LOWER, RELAY_1, SOURCE, UNDERRANGE_CONTROL, UNIT, UPPER, VALIDATION,
};
use crate::tpg::{BOARDS, COLD, PIRANI};
use profivac_devices::SimulatedDevice;
use profivac_devices::model::Fault;

/// Channel B1 in Sensor On_Off.
const B1_OFF: u8 = 0x10;
const B1_AUTOMATIC: u8 = 0x20;
const B1_ON: u8 = 0x30;

fn exchange() -> Exchange {
    Exchange::new(BOARDS)
}

fn relays(master: &mut Exchange) -> Vec<bool> {
    master.tester.device().report().relays.iter().copied().collect()
}

fn emission(master: &mut Exchange) -> Vec<bool> {
    master.tester.device().report().emission.iter().copied().collect()
}

#[test]
fn a_relay_switches_at_its_thresholds_with_hysteresis_in_every_unit() {
    for (unit, per_mbar) in [(1, 1.0), (2, 0.750_061_7), (3, 100.0f32)] {
        let mut master = exchange();
        master.write(A1, UNIT, unit).unwrap();
        master.thresholds(RELAY_1, 0.1 * per_mbar, 1.0 * per_mbar, A1).unwrap();
        for (mbar, activated) in [
            (10.0, false),
            (0.5, false),
            (0.101, false),
            (0.099, true),
            (0.5, true),
            (0.99, true),
            (1.01, false),
            (0.5, false),
            (1e-9, true),
            (2000.0, false),
        ] {
            master.pressure(mbar);
            assert_eq!(master.is_activated(RELAY_1), activated, "{mbar} mbar, unit {unit}");
            assert_eq!(relays(&mut master)[0], activated, "{mbar} mbar, unit {unit}");
        }
    }
}

#[test]
fn every_block_compares_its_own_source() {
    let mut master = Exchange::new([PIRANI; 4]);
    for slot in 5..=8 {
        master.thresholds(slot, 1.0, 2.0, slot - 4).unwrap();
    }
    for part in 0..4 {
        (0..4).for_each(|other| master.tester.device().sense(other, if other == part { 10.0 } else { 1e5 }));
        master.tester.device().settle();
        let activated: Vec<bool> = (5..=8).map(|slot| master.is_activated(slot)).collect();
        assert_eq!(activated, (0..4).map(|other| other == part).collect::<Vec<bool>>());
    }
}

#[test]
fn a_set_takes_effect_when_it_is_validated_in_order() {
    let mut master = exchange();
    master.pressure(0.5);
    assert!(!master.is_activated(RELAY_1));
    master.write(RELAY_1, VALIDATION, 0).unwrap();
    master.write_float(RELAY_1, LOWER, 1.0).unwrap();
    // While the set is open its values can be read, but the controller keeps the old one (139).
    assert_eq!(master.read_float(RELAY_1, LOWER), 1.0);
    assert_eq!(master.read_float(RELAY_1, UPPER), 2e-3);
    master.pressure(0.5);
    assert!(!master.is_activated(RELAY_1));
    // Lower above upper: range, and the block stays open (137).
    assert_eq!(master.write(RELAY_1, VALIDATION, 1), Err(2));
    assert_eq!(master.read(RELAY_1, VALIDATION), Ok(0));
    master.write_float(RELAY_1, UPPER, 1.0).unwrap();
    master.write(RELAY_1, VALIDATION, 1).unwrap();
    assert_eq!(master.read(RELAY_1, VALIDATION), Ok(1));
    assert!(master.is_activated(RELAY_1));
    // A second validation changes nothing.
    master.write(RELAY_1, VALIDATION, 1).unwrap();
    assert!(master.is_activated(RELAY_1));
    // Opening the set does not open the relay.
    master.write(RELAY_1, VALIDATION, 0).unwrap();
    assert!(master.is_activated(RELAY_1));
}

#[test]
fn thresholds_keep_their_pressure_when_the_unit_changes() {
    // (147)
    let mut master = exchange();
    master.thresholds(RELAY_1, 0.1, 1.0, A1).unwrap();
    for (unit, lower, upper) in [(2, 0.075_006_17, 0.750_061_7), (3, 10.0, 100.0), (1, 0.1, 1.0)] {
        master.write(A1, UNIT, unit).unwrap();
        assert_eq!(master.read_float(RELAY_1, LOWER), lower);
        assert_eq!(master.read_float(RELAY_1, UPPER), upper);
    }
}

#[test]
fn a_relay_without_a_reading_is_deactivated() {
    let mut master = exchange();
    master.thresholds(RELAY_1, 1.0, 2.0, A1).unwrap();
    for fault in [Fault::Sensor1, Fault::Electronics1, Fault::Unplugged1] {
        master.pressure(1e-6);
        assert!(master.is_activated(RELAY_1));
        master.fault(fault, true);
        assert!(!master.is_activated(RELAY_1), "{fault:?}");
        master.fault(fault, false);
        assert!(master.is_activated(RELAY_1), "{fault:?}");
    }
    master.command(0x01);
    assert!(!master.is_activated(RELAY_1), "switched off");
    let mut empty = Exchange::new([None, PIRANI, COLD, COLD]);
    empty.thresholds(RELAY_1, 1.0, 2.0, A1).unwrap();
    empty.pressure(1e-6);
    assert!(!empty.is_activated(RELAY_1), "no board");
}

/// The factory's thresholds let every channel measure at the pressure at which a virtual controller starts.
#[test]
fn as_delivered_all_channels_measure_at_1e_3_mbar() {
    let mut master = exchange();
    for (mbar, statuses) in
        [(1000.0, [0, 0, 4, 4]), (6e-3, [0, 0, 4, 4]), (1e-3, [0; 4]), (6e-3, [0; 4]), (1.1e-2, [0, 0, 4, 4])]
    {
        master.pressure(mbar);
        assert_eq!(master.statuses(), statuses, "{mbar} mbar");
    }
}

/// As delivered the cathodes follow the first Pirani gauge that is fitted.
#[test]
fn as_delivered_the_first_pirani_gauge_switches_the_cathodes() {
    for (boards, statuses) in
        [([COLD, PIRANI, COLD, None], [0, 0, 0, 5]), ([None, COLD, COLD, PIRANI], [5, 0, 0, 0]), ([COLD; 4], [4; 4])]
    {
        let mut master = Exchange::new(boards);
        master.pressure(1e-3);
        assert_eq!(master.statuses(), statuses);
    }
}

#[test]
fn an_automatic_cold_cathode_follows_the_block_of_its_board() {
    let mut master = exchange();
    master.thresholds(COLD_CATHODE_B, 1e-3, 1e-2, A1).unwrap();
    for (mbar, on) in [(1000.0, false), (5e-3, false), (9e-4, true), (5e-3, true), (1.1e-2, false), (5e-3, false)] {
        master.pressure(mbar);
        assert_eq!(emission(&mut master), [on, on], "{mbar} mbar");
        assert_eq!(master.is_activated(COLD_CATHODE_B), on, "{mbar} mbar");
        assert_eq!(master.statuses()[2..], if on { [0, 0] } else { [4, 4] }, "{mbar} mbar");
    }
}

/// (160)
#[test]
fn an_automatic_cold_cathode_goes_off_with_the_pirani_that_controls_it() {
    let mut master = exchange();
    master.pressure(1e-4);
    assert_eq!(emission(&mut master), [true, true]);
    // B1 is on by command, B2 automatic; then A1, their source as delivered, goes off.
    master.command(B1_ON);
    master.command(0x01);
    assert_eq!((emission(&mut master), master.statuses()), (vec![true, false], [4, 1, 0, 4]));
    // A1 automatic, which is on.
    master.command(0x02);
    assert_eq!((emission(&mut master), master.statuses()), (vec![true, true], [1, 1, 0, 0]));
}

#[test]
fn sensor_on_off_switches_each_channel_by_its_field() {
    let mut master = exchange();
    master.thresholds(COLD_CATHODE_B, 1e-3, 1e-2, A1).unwrap();
    master.pressure(5e-3);
    assert_eq!(emission(&mut master), [false, false]);
    master.command(B1_ON);
    assert_eq!(emission(&mut master), [true, false]);
    // Zeros change nothing, and neither does Clear (128).
    master.command(0);
    assert_eq!(emission(&mut master), [true, false]);
    master.command(B1_OFF);
    assert_eq!(emission(&mut master), [false, false]);
    master.pressure(1e-4);
    assert_eq!(emission(&mut master), [false, true], "off stays off");
    master.command(B1_AUTOMATIC);
    assert_eq!(emission(&mut master), [true, true]);
    // Read back through the parameter channel: the last octet (128).
    master.command(0xE4);
    assert_eq!(master.read(0, 20), Ok(0xE4));
    assert_eq!(master.statuses(), [1, 4, 0, 0]);
    master.command(0x0B);
    assert_eq!(master.statuses(), [1, 1, 0, 0]);
}

#[test]
fn self_monitoring_switches_a_cold_cathode_off_and_a_new_command_on() {
    // The example of 3.2.4.2: B1 with 1e-3 and 2e-3 mbar.
    let mut master = exchange();
    master.thresholds(COLD_CATHODE_B, 1e-3, 2e-3, B1).unwrap();
    master.pressure(1e-4);
    assert_eq!(emission(&mut master), [false, false], "it does not switch on");
    for command in [B1_ON, B1_AUTOMATIC] {
        master.command(B1_ON);
        master.command(command);
        master.pressure(1e-4);
        assert!(emission(&mut master)[0]);
        assert!(master.is_activated(COLD_CATHODE_B));
        master.pressure(1.9e-3);
        assert!(emission(&mut master)[0]);
        master.pressure(2.1e-3);
        assert!(!emission(&mut master)[0]);
        assert_eq!(master.statuses()[2], 4);
        // The unchanged command in the cyclic data does not switch on again.
        master.pressure(1e-4);
        assert!(!emission(&mut master)[0], "{command:02X}");
        master.command(0);
    }
    master.command(B1_ON);
    assert!(emission(&mut master)[0]);
}

#[test]
fn underrange_control_makes_a_cold_cathode_valid_after_ten_seconds_in_range() {
    // 3.2.3.2
    let mut master = exchange();
    master.thresholds(RELAY_1, 1e-3, 2e-3, B1).unwrap();
    master.pressure(1e-5);
    master.command(B1_ON);
    assert!(master.is_activated(RELAY_1), "0: nothing to wait for");
    master.pressure(1e-12);
    assert!(master.is_activated(RELAY_1), "0: underrange is valid");

    master.write(0, UNDERRANGE_CONTROL, 1).unwrap();
    assert!(!master.is_activated(RELAY_1));
    master.pressure(1e-5);
    master.advance(9.0);
    assert!(!master.is_activated(RELAY_1));
    // After less than ten seconds in range the value is invalid, and the ten seconds start again.
    master.pressure(1e-12);
    master.advance(5.0);
    assert!(!master.is_activated(RELAY_1));
    master.pressure(1e-5);
    master.advance(9.0);
    assert!(!master.is_activated(RELAY_1));
    master.advance(1.5);
    assert!(master.is_activated(RELAY_1));
    master.pressure(1e-12);
    master.advance(60.0);
    assert!(master.is_activated(RELAY_1), "remains on");
    // After off and on the ten seconds start again.
    master.command(B1_OFF);
    master.command(B1_ON);
    assert!(!master.is_activated(RELAY_1));
    // A Pirani gauge has no underrange control.
    master.thresholds(RELAY_1, 1e-2, 2e-2, A1).unwrap();
    assert!(master.is_activated(RELAY_1));
    assert_eq!(master.read(RELAY_1, SOURCE), Ok(1));
}
