//! Set points, relays and the atmosphere functions. tira41d1 3.2.5, 3.3.5, (106) to (116).

use crate::bcg450::{FLOATS, Gauge, exchanging, float, of_instance};
use crate::support::{Tester, hex};
use profivac_devices::{Action, Potentiometer, SimulatedDevice};

fn turn(tester: &mut Tester<Gauge>, potentiometer: Potentiometer, volts: f64) {
    tester.device().operate(Action::Potentiometer { potentiometer, volts }).unwrap();
}

/// The voltage of a threshold in mbar: 3.2.5.1, solved for U.
fn volts(mbar: f64) -> f64 {
    (mbar.log10() + 9.301_029_99) / 1.23011
}

fn relays(tester: &mut Tester<Gauge>) -> Vec<bool> {
    tester.report().relays.iter().copied().collect()
}

/// The ambient sensor, in mbar.
fn atmosphere(tester: &mut Tester<Gauge>, mbar: f64) {
    tester.device().sense(3, mbar * 100.0);
}

/// (71): and in its data type.
#[test]
fn the_threshold_is_read_in_the_unit_of_the_device() {
    let mut tester = exchanging(FLOATS, 1e-3);
    for (u, mbar) in [(0.0, 5e-10), (5.0, 7.072e-4), (10.0, 1000.16)] {
        turn(&mut tester, Potentiometer::A, u);
        assert!(
            (float(&mut tester, 5, 19) / mbar - 1.0).abs() < 1e-4,
            "{u} V reads {} mbar",
            float(&mut tester, 5, 19)
        );
        // COUNTS = 2000 x (log10 p + 12.5)
        tester.unlock();
        tester.put(1, 22, &hex("03 E9")).unwrap();
        let counts = 2000.0 * (f64::from(mbar).log10() + 12.5);
        assert!((f64::from(float(&mut tester, 5, 19)) - counts).abs() < 0.5, "{u} V");
        tester.bring_up(&hex(crate::bcg450::MBAR), &hex(FLOATS));
    }
    turn(&mut tester, Potentiometer::A, 77.0);
    assert_eq!(float(&mut tester, 5, 19).round(), 1000.0, "a potentiometer ends at 10 V");
}

/// 3.2.5.1, 3.2.5.2, (106), (108)
#[test]
fn a_relay_closes_below_its_threshold_and_opens_ten_percent_above() {
    let mut tester = exchanging(FLOATS, 1000.0);
    turn(&mut tester, Potentiometer::A, volts(1.0));
    turn(&mut tester, Potentiometer::B, volts(1e-4));
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
        tester.pressure_mbar(mbar);
        assert_eq!(relays(&mut tester), [a, b], "{mbar} mbar");
        let status = [a, b].map(|closed| if closed { 0x0A } else { 0 });
        assert_eq!([5, 6].map(|instance| of_instance(&mut tester, instance, 20)[0]), status, "{mbar} mbar");
        // With function 0 the relay is no warning (114).
        assert_eq!(tester.get(0, 211), [0]);
        assert_eq!([5, 6].map(|instance| of_instance(&mut tester, instance, 203)[0]), [0, 0]);
    }
}

/// (107): unlike on the BPG400-SP and HPG400-SP there is no limit at 100 mbar.
#[test]
fn a_threshold_above_100_mbar_works() {
    let mut tester = exchanging(FLOATS, 400.0);
    turn(&mut tester, Potentiometer::A, volts(500.0));
    assert_eq!(relays(&mut tester), [true, false]);
}

/// 3.2.5.6
#[test]
fn a_relay_opens_outside_executing_and_with_any_sensor_alarm() {
    let mut tester = exchanging(FLOATS, 1e-3);
    turn(&mut tester, Potentiometer::A, volts(1.0));
    for fault in ["sensor1", "sensor2", "sensor3", "electronics3"] {
        assert_eq!(relays(&mut tester), [true, false]);
        tester.fault(fault, true);
        assert_eq!(relays(&mut tester), [false, false], "{fault}");
        tester.fault(fault, false);
    }
    tester.fault("ram", true);
    assert_eq!(relays(&mut tester), [true, false], "no sensor alarm");
    tester.command(5).unwrap();
    assert_eq!(relays(&mut tester), [false, false]);
}

/// 3.2.5.6 to 3.2.5.8, (112), (114)
#[test]
fn atmosphere_control_closes_at_a_percentage_of_the_ambient_pressure() {
    let mut tester = exchanging(FLOATS, 1.0);
    atmosphere(&mut tester, 1000.0);
    tester.put(1, 46, &[6]).unwrap();
    tester.put(1, 201, &[1]).unwrap();
    // The worked example: 50 % is 500.
    tester.put(1, 202, &500u16.to_be_bytes()).unwrap();
    turn(&mut tester, Potentiometer::B, volts(2e-5));
    for (mbar, closed) in [(499.0, false), (500.0, true), (451.0, true), (449.0, false), (1200.0, true)] {
        tester.pressure_mbar(mbar);
        assert_eq!(relays(&mut tester), [false, closed], "{mbar} mbar");
        assert_eq!(of_instance(&mut tester, 6, 203), [u8::from(closed)], "{mbar} mbar");
        assert_eq!(tester.get(0, 211), [if closed { 0x04 } else { 0 }], "{mbar} mbar");
        assert_eq!(tester.exchange(&[])[0], if closed { 0xC0 } else { 0x80 }, "{mbar} mbar");
        assert_eq!(of_instance(&mut tester, 3, 23), [1], "the reading stays valid");
        // The potentiometer is shown in both functions.
        assert!((float(&mut tester, 6, 19) / 2e-5 - 1.0).abs() < 1e-4);
    }
    tester.put(1, 46, &[6]).unwrap();
    tester.put(1, 201, &[0]).unwrap();
    assert_eq!(relays(&mut tester), [false, false], "back to the potentiometer");
    // Closed by the potentiometer, within the hysteresis of the other function: the contacts fall back.
    turn(&mut tester, Potentiometer::B, 10.0);
    tester.pressure_mbar(470.0);
    assert_eq!(relays(&mut tester), [false, true]);
    tester.put(1, 201, &[1]).unwrap();
    assert_eq!(relays(&mut tester), [false, false]);
    // 5 % as from the factory, relay A is bit 1 (113).
    assert_eq!(of_instance(&mut tester, 5, 202), 50u16.to_be_bytes());
    tester.put(1, 201, &[1]).unwrap();
    assert_eq!((relays(&mut tester), tester.get(0, 211)), (vec![true, false], vec![0x02]));
}

#[test]
fn a_percentage_beyond_the_range_of_the_gauge_is_legal() {
    let mut tester = exchanging(FLOATS, 1400.0);
    tester.put(1, 46, &[5]).unwrap();
    tester.put(1, 202, &1400u16.to_be_bytes()).unwrap();
    tester.put(1, 201, &[1]).unwrap();
    tester.pressure_mbar(1418.0);
    assert_eq!(relays(&mut tester), [false, false], "140 % of 1013.25 mbar");
    tester.pressure_mbar(1419.0);
    assert_eq!(relays(&mut tester), [true, false]);
}

/// 3.2.5.1, (113): the relay closes below the end of the range, 1500 mbar, and opens when its threshold moves beyond it.
#[test]
fn a_threshold_at_the_end_of_the_range_is_never_reached() {
    let mut tester = exchanging(FLOATS, 1100.0);
    tester.put(1, 46, &[5]).unwrap();
    tester.put(1, 202, &1400u16.to_be_bytes()).unwrap();
    tester.put(1, 201, &[1]).unwrap();
    for (ambient, mbar, closed) in [
        (1500.0 / 1.4, 1550.0, false),
        (1100.0, 1550.0, false),
        (1071.5, 1550.0, false),
        (1071.0, 1499.0, false),
        (1071.0, 1499.5, true),
        (1072.0, 1550.0, false),
        (1071.0, 1550.0, true),
    ] {
        tester.pressure_mbar(1.0);
        atmosphere(&mut tester, ambient);
        tester.pressure_mbar(mbar);
        assert_eq!(relays(&mut tester), [closed, false], "140 % of {ambient} mbar at {mbar} mbar");
        assert_eq!(of_instance(&mut tester, 5, 203), [u8::from(closed)], "140 % of {ambient} mbar at {mbar} mbar");
    }
    atmosphere(&mut tester, 1072.0);
    assert_eq!(relays(&mut tester), [false, false], "the threshold has moved beyond the end");
}

/// 3.3.5.2, (159): "vent to atmospheric pressure" comes first. Otherwise "atmospheric pressure reached" would be 1 in vacuum.
#[test]
fn the_ambient_sensor_is_not_adjusted_in_vacuum_or_to_a_broken_diaphragm() {
    let mut tester = exchanging(FLOATS, 1e-3);
    atmosphere(&mut tester, 1000.0);
    tester.put(1, 46, &[5]).unwrap();
    tester.put(1, 201, &[1]).unwrap();
    tester.put(1, 202, &990u16.to_be_bytes()).unwrap();
    for (mbar, fault, adjusted) in [
        (1e-3, "", Err(202)),
        (299.0, "", Err(202)),
        (1201.0, "", Err(202)),
        (1000.0, "sensor3", Err(202)),
        (1000.0, "electronics3", Err(202)),
        (1000.0, "", Ok(())),
    ] {
        tester.pressure_mbar(mbar);
        atmosphere(&mut tester, 1000.0);
        if !fault.is_empty() {
            tester.fault(fault, true);
        }
        tester.put(1, 46, &[4]).unwrap();
        assert_eq!(tester.put(1, 14, &[128, 0]), adjusted, "{mbar} mbar {fault}");
        // Off can be sent at any pressure: it restores the adjustment of the factory.
        assert_eq!(tester.put(1, 14, &[128, 1]), Ok(()));
        if !fault.is_empty() {
            tester.fault(fault, false);
        }
    }
    tester.pressure_mbar(1e-3);
    atmosphere(&mut tester, 1000.0);
    assert_eq!(of_instance(&mut tester, 5, 203), [0], "the atmosphere is not reached in vacuum");
}

/// 3.3.5.2, (116): the ambient sensor has the reading of the diaphragm, also after a power cycle.
#[test]
fn the_ambient_sensor_is_adjusted_to_the_diaphragm() {
    let mut tester = exchanging(FLOATS, 1000.0);
    // 20 mbar wrong.
    atmosphere(&mut tester, 1020.0);
    tester.put(1, 46, &[5]).unwrap();
    tester.put(1, 201, &[1]).unwrap();
    tester.put(1, 202, &1000u16.to_be_bytes()).unwrap();
    tester.pressure_mbar(1.0);
    tester.pressure_mbar(1010.0);
    assert_eq!(relays(&mut tester), [false, false], "100 % are 1020 mbar");
    tester.pressure_mbar(1000.0);
    tester.put(1, 46, &[4]).unwrap();
    tester.put(1, 14, &[128, 0]).unwrap();
    assert_eq!(relays(&mut tester), [true, false], "100 % are 1000 mbar");
    tester.device().set_power(false);
    tester.device().set_power(true);
    tester.device().settle();
    tester.unlock();
    tester.pressure_mbar(1.0);
    tester.bring_up(&hex(crate::bcg450::MBAR), &hex(FLOATS));
    tester.pressure_mbar(990.0);
    assert_eq!(relays(&mut tester), [false, false], "after power too");
    tester.pressure_mbar(1001.0);
    assert_eq!(relays(&mut tester), [true, false]);
    tester.put(1, 46, &[4]).unwrap();
    tester.put(1, 14, &[128, 1]).unwrap();
    tester.pressure_mbar(1.0);
    tester.pressure_mbar(1010.0);
    assert_eq!(relays(&mut tester), [false, false], "adjustment off");
    assert_eq!(tester.put(1, 14, &[1, 0]), Err(2));
}
