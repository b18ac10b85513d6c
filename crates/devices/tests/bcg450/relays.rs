//! Set points, relays and the atmosphere functions. tira41d1 3.2.5, 3.3.5, (106) to (116).

use crate::support::{Desk, hex};
use crate::{FLOATS, Gauge, exchanging, float, of_instance};
use profivac_devices::{Action, Potentiometer, SimulatedDevice};

fn turn(desk: &mut Desk<Gauge>, potentiometer: Potentiometer, volts: f64) {
    desk.device().operate(Action::Potentiometer { potentiometer, volts }).unwrap();
}

/// The voltage of a threshold in mbar: 3.2.5.1, solved for U.
fn volts(mbar: f64) -> f64 {
    (mbar.log10() + 9.301_029_99) / 1.23011
}

fn relays(desk: &mut Desk<Gauge>) -> Vec<bool> {
    desk.report().relays.iter().copied().collect()
}

/// The ambient sensor, in mbar.
fn atmosphere(desk: &mut Desk<Gauge>, mbar: f64) {
    desk.device().sense(3, mbar * 100.0);
}

#[test]
fn the_threshold_is_read_in_the_unit_of_the_device() {
    let mut desk = exchanging(FLOATS, 1e-3);
    for (u, mbar) in [(0.0, 5e-10), (5.0, 7.072e-4), (10.0, 1000.16)] {
        turn(&mut desk, Potentiometer::A, u);
        assert!((float(&mut desk, 5, 19) / mbar - 1.0).abs() < 1e-4, "{u} V reads {} mbar", float(&mut desk, 5, 19));
        // COUNTS = 2000 x (log10 p + 12.5)
        desk.unlock();
        desk.put(1, 22, &hex("03 E9")).unwrap();
        let counts = 2000.0 * (f64::from(mbar).log10() + 12.5);
        assert!((f64::from(float(&mut desk, 5, 19)) - counts).abs() < 0.5, "{u} V");
        desk.bring_up(&hex(crate::MBAR), &hex(FLOATS));
    }
    turn(&mut desk, Potentiometer::A, 77.0);
    assert_eq!(float(&mut desk, 5, 19).round(), 1000.0, "a potentiometer ends at 10 V");
}

/// 3.2.5.1, 3.2.5.2, (106), (108)
#[test]
fn a_relay_closes_below_its_threshold_and_opens_ten_percent_above() {
    let mut desk = exchanging(FLOATS, 1000.0);
    turn(&mut desk, Potentiometer::A, volts(1.0));
    turn(&mut desk, Potentiometer::B, volts(1e-4));
    for (mbar, a, b) in [
        (1000.0, false, false),
        (1.001, false, false),
        (0.999, true, false),
        (1.09, true, false),
        (1.11, false, false),
        (9.9e-5, true, true),
        (1.09e-4, true, true),
        (1.11e-4, true, false),
    ] {
        desk.pressure_mbar(mbar);
        assert_eq!(relays(&mut desk), [a, b], "{mbar} mbar");
        let status = [a, b].map(|closed| if closed { 0x0A } else { 0 });
        assert_eq!([5, 6].map(|instance| of_instance(&mut desk, instance, 20)[0]), status, "{mbar} mbar");
        // With function 0 the relay is no warning (114).
        assert_eq!(desk.get(0, 211), [0]);
        assert_eq!([5, 6].map(|instance| of_instance(&mut desk, instance, 203)[0]), [0, 0]);
    }
}

/// (107): unlike the sister gauges there is no limit at 100 mbar.
#[test]
fn a_threshold_above_100_mbar_works() {
    let mut desk = exchanging(FLOATS, 400.0);
    turn(&mut desk, Potentiometer::A, volts(500.0));
    assert_eq!(relays(&mut desk), [true, false]);
}

/// 3.2.5.6
#[test]
fn a_relay_opens_outside_executing_and_with_any_sensor_alarm() {
    let mut desk = exchanging(FLOATS, 1e-3);
    turn(&mut desk, Potentiometer::A, volts(1.0));
    for fault in ["sensor1", "sensor2", "sensor3", "electronics3"] {
        assert_eq!(relays(&mut desk), [true, false]);
        desk.fault(fault, true);
        assert_eq!(relays(&mut desk), [false, false], "{fault}");
        desk.fault(fault, false);
    }
    desk.fault("ram", true);
    assert_eq!(relays(&mut desk), [true, false], "no sensor alarm");
    desk.command(5).unwrap();
    assert_eq!(relays(&mut desk), [false, false]);
}

/// 3.2.5.6 to 3.2.5.8, (112), (114)
#[test]
fn atmosphere_control_closes_at_a_percentage_of_the_ambient_pressure() {
    let mut desk = exchanging(FLOATS, 1.0);
    atmosphere(&mut desk, 1000.0);
    desk.put(1, 46, &[6]).unwrap();
    desk.put(1, 201, &[1]).unwrap();
    // The worked example: 50 % is 500.
    desk.put(1, 202, &500u16.to_be_bytes()).unwrap();
    turn(&mut desk, Potentiometer::B, volts(2e-5));
    for (mbar, closed) in [(499.0, false), (500.0, true), (451.0, true), (449.0, false), (1200.0, true)] {
        desk.pressure_mbar(mbar);
        assert_eq!(relays(&mut desk), [false, closed], "{mbar} mbar");
        assert_eq!(of_instance(&mut desk, 6, 203), [u8::from(closed)], "{mbar} mbar");
        assert_eq!(desk.get(0, 211), [if closed { 0x04 } else { 0 }], "{mbar} mbar");
        assert_eq!(desk.exchange(&[])[0], if closed { 0xC0 } else { 0x80 }, "{mbar} mbar");
        assert_eq!(of_instance(&mut desk, 3, 23), [1], "the reading stays valid");
        // The potentiometer is shown in both functions.
        assert!((float(&mut desk, 6, 19) / 2e-5 - 1.0).abs() < 1e-4);
    }
    desk.put(1, 46, &[6]).unwrap();
    desk.put(1, 201, &[0]).unwrap();
    assert_eq!(relays(&mut desk), [false, false], "back to the potentiometer");
    // Closed by the potentiometer, within the hysteresis of the other function: the contacts fall back.
    turn(&mut desk, Potentiometer::B, 10.0);
    desk.pressure_mbar(470.0);
    assert_eq!(relays(&mut desk), [false, true]);
    desk.put(1, 201, &[1]).unwrap();
    assert_eq!(relays(&mut desk), [false, false]);
    // 5 % as from the factory, relay A is bit 1 (113).
    assert_eq!(of_instance(&mut desk, 5, 202), 50u16.to_be_bytes());
    desk.put(1, 201, &[1]).unwrap();
    assert_eq!((relays(&mut desk), desk.get(0, 211)), (vec![true, false], vec![0x02]));
}

#[test]
fn a_percentage_beyond_the_range_of_the_gauge_is_legal() {
    let mut desk = exchanging(FLOATS, 1400.0);
    desk.put(1, 46, &[5]).unwrap();
    desk.put(1, 202, &1400u16.to_be_bytes()).unwrap();
    desk.put(1, 201, &[1]).unwrap();
    desk.pressure_mbar(1418.0);
    assert_eq!(relays(&mut desk), [false, false], "140 % of 1013.25 mbar");
    desk.pressure_mbar(1419.0);
    assert_eq!(relays(&mut desk), [true, false]);
}

/// 3.3.5.2, (116): the ambient sensor shows what the diaphragm shows, now and after a power cycle.
#[test]
fn the_ambient_sensor_is_adjusted_to_the_diaphragm() {
    let mut desk = exchanging(FLOATS, 1000.0);
    // 20 mbar wrong.
    atmosphere(&mut desk, 1020.0);
    desk.put(1, 46, &[5]).unwrap();
    desk.put(1, 201, &[1]).unwrap();
    desk.put(1, 202, &1000u16.to_be_bytes()).unwrap();
    desk.pressure_mbar(1.0);
    desk.pressure_mbar(1010.0);
    assert_eq!(relays(&mut desk), [false, false], "100 % are 1020 mbar");
    desk.pressure_mbar(1000.0);
    desk.put(1, 46, &[4]).unwrap();
    desk.put(1, 14, &[128, 0]).unwrap();
    assert_eq!(relays(&mut desk), [true, false], "100 % are 1000 mbar");
    desk.device().set_power(false);
    desk.device().set_power(true);
    desk.device().settle();
    desk.unlock();
    desk.pressure_mbar(1.0);
    desk.bring_up(&hex(crate::MBAR), &hex(FLOATS));
    desk.pressure_mbar(990.0);
    assert_eq!(relays(&mut desk), [false, false], "after power too");
    desk.pressure_mbar(1001.0);
    assert_eq!(relays(&mut desk), [true, false]);
    desk.put(1, 46, &[4]).unwrap();
    desk.put(1, 14, &[128, 1]).unwrap();
    desk.pressure_mbar(1.0);
    desk.pressure_mbar(1010.0);
    assert_eq!(relays(&mut desk), [false, false], "adjustment off");
    assert_eq!(desk.put(1, 14, &[1, 0]), Err(2));
}
