//! Sensors with errors, and the adjustments of the manuals that correct them, now and after a power cut.

use super::{around, device, indicated, mean, shown, start, write};
use profivac_vacuum::Gas;
use profivac_virtual::device::VirtualDevice;

/// A measuring device with real sensors that have only the errors a test sets.
fn real(name: &str, mbar: f64) -> VirtualDevice {
    let mut device = device(name, mbar).with_real_sensors(11);
    start(&mut device);
    for instance in 1..=4 {
        if let Some(imperfections) = device.sensor_mut(instance).and_then(|sensor| sensor.imperfections_mut()) {
            (
                imperfections.gain,
                imperfections.zero_pa,
                imperfections.drift_pa,
                imperfections.noise,
                imperfections.floor_pa,
            ) = (1.0, 0.0, 0.0, 0.0, 0.0);
        }
    }
    device
}

fn spoil(device: &mut VirtualDevice, instance: u8, gain: f64, zero_pa: f64) {
    let imperfections = device.sensor_mut(instance).unwrap().imperfections_mut().unwrap();
    (imperfections.gain, imperfections.zero_pa) = (gain, zero_pa);
}

/// The reading at another pressure of nitrogen after the lag of the sensor.
fn at(device: &mut VirtualDevice, instance: u8, mbar: f64) -> f64 {
    device.set_environment(around(Gas::N2, mbar));
    device.advance(5.0);
    mean(device, instance)
}

/// Switches the power off and on, and starts measuring.
fn power_cut(device: &mut VirtualDevice) {
    device.set_power(false);
    device.set_power(true);
    start(device);
}

fn close(found: f64, expected: f64, tolerance: f64) -> bool {
    (found - expected).abs() <= tolerance * expected.abs()
}

/// tira56e1 8.1.1, also for a diaphragm that reads too low.
#[test]
fn a_zero_adjust_corrects_the_diaphragm_of_a_pcg() {
    for zero_pa in [35.0, -35.0] {
        let mut gauge = real("pcg550", 20.0);
        spoil(&mut gauge, 1, 1.0, zero_pa);
        assert!(close(at(&mut gauge, 1, 20.0), 20.0 + zero_pa / 100.0, 1e-6), "{zero_pa} Pa off");
        at(&mut gauge, 1, 1e-4);
        write(&mut gauge, 1, 46, &[1]).unwrap();
        write(&mut gauge, 1, 15, &[0, 0]).unwrap();
        assert!(close(at(&mut gauge, 1, 20.0), 20.0, 1e-5));
        power_cut(&mut gauge);
        assert!(close(at(&mut gauge, 1, 20.0), 20.0, 1e-5), "after a power cut: {}", shown(&gauge));
    }
}

/// tira56e1 8.1.11: while the Pirani indicates vacuum, the diaphragm adjusts its zero by itself.
#[test]
fn auto_zero_follows_a_diaphragm_that_drifts() {
    let mut gauge = real("pcg550", 1e-4);
    // Auto Zero Enable
    write(&mut gauge, 1, 46, &[1]).unwrap();
    write(&mut gauge, 1, 41, &[1]).unwrap();
    for zero_pa in [10.0, 30.0, -20.0] {
        spoil(&mut gauge, 1, 1.0, zero_pa);
        at(&mut gauge, 1, 1e-4);
        gauge.advance(1200.0);
        assert!(close(at(&mut gauge, 1, 20.0), 20.0, 1e-5), "{zero_pa} Pa off: {}", indicated(&gauge, 1));
    }
}

/// tira56e1 8.2.1: zero, then full scale at atmosphere.
#[test]
fn zero_and_gain_adjust_correct_a_pirani() {
    let mut gauge = real("psg550", 1e-6);
    spoil(&mut gauge, 1, 1.0, 0.8);
    assert!(at(&mut gauge, 1, 1e-3) > 8e-3);
    at(&mut gauge, 1, 1e-7);
    write(&mut gauge, 1, 15, &[0, 0]).unwrap();
    assert!(close(at(&mut gauge, 1, 1e-3), 1e-3, 1e-3), "{}", shown(&gauge));
    spoil(&mut gauge, 1, 0.98, 0.8);
    assert!(at(&mut gauge, 1, 1000.0) < 900.0);
    write(&mut gauge, 1, 15, &[1, 0]).unwrap();
    assert!(close(at(&mut gauge, 1, 1000.0), 1000.0, 1e-6));
    power_cut(&mut gauge);
    assert!(close(at(&mut gauge, 1, 1000.0), 1000.0, 1e-6));
}

/// tira56e1 8.3.1, tira41d1 3.3.5.2: the atmosphere sensor is adjusted to the diaphragm while the chamber is open.
#[test]
fn the_atmosphere_sensor_follows_the_diaphragm() {
    let mut gauge = real("pcg550", 1013.25);
    spoil(&mut gauge, 3, 0.97, 0.0);
    assert!(close(at(&mut gauge, 3, 1013.25), 0.97 * 1013.25, 1e-6));
    write(&mut gauge, 1, 46, &[3]).unwrap();
    write(&mut gauge, 1, 15, &[1, 0]).unwrap();
    assert!(close(at(&mut gauge, 3, 1013.25), 1013.25, 1e-6));
    power_cut(&mut gauge);
    assert!(close(at(&mut gauge, 3, 1013.25), 1013.25, 1e-6));
}

/// The relay of a BCG450 at 99 % of atmosphere never closes with a sensor that reads high, until it is adjusted.
#[test]
fn user_atm_adjust_corrects_the_relay_of_a_bcg() {
    let mut gauge = real("bcg450", 1.0);
    spoil(&mut gauge, 4, 1.05, 0.0);
    write(&mut gauge, 1, 46, &[5]).unwrap();
    write(&mut gauge, 1, 202, &990u16.to_be_bytes()).unwrap();
    write(&mut gauge, 1, 201, &[1]).unwrap();
    let relay = |gauge: &VirtualDevice| *gauge.report().relays.iter().next().unwrap();
    at(&mut gauge, 3, 1013.25);
    assert!(!relay(&gauge));
    write(&mut gauge, 1, 46, &[4]).unwrap();
    write(&mut gauge, 1, 14, &[128, 0]).unwrap();
    assert!(relay(&gauge));
    power_cut(&mut gauge);
    at(&mut gauge, 3, 1.0);
    assert!(!relay(&gauge));
    at(&mut gauge, 3, 1013.25);
    assert!(relay(&gauge), "after a power cut");
}

/// tira36e1 3.2.1.1
#[test]
fn full_scale_adjust_corrects_the_pirani_of_a_bpg() {
    for name in ["bpg400", "hpg400"] {
        let mut gauge = real(name, 1000.0);
        spoil(&mut gauge, 1, 0.985, 0.0);
        assert!(at(&mut gauge, 1, 1000.0) < 930.0);
        write(&mut gauge, 1, 15, &[1]).unwrap();
        gauge.advance(11.0);
        assert!(close(at(&mut gauge, 1, 1000.0), 1000.0, 1e-6), "{name}: {}", shown(&gauge));
        power_cut(&mut gauge);
        assert!(close(at(&mut gauge, 1, 1000.0), 1000.0, 1e-6), "{name}: {}", shown(&gauge));
    }
}

/// tira36e1 3.1.1.14
#[test]
fn cal_adj_corrects_the_sensitivity_of_a_tube() {
    let mut gauge = real("hpg400", 1e-2);
    spoil(&mut gauge, 2, 1.0 / 1.15, 0.0);
    assert!(at(&mut gauge, 2, 1e-2) < 8.8e-3);
    gauge.operate(profivac_devices::Action::Switch(profivac_devices::Switch::CalAdj(3))).unwrap();
    assert!(close(mean(&mut gauge, 2), 1e-2, 2e-3), "{}", indicated(&gauge, 2));
}

/// BG 5530 4.4.2: target 1 is zero, target 0 no offset.
#[test]
fn zero_adjust_corrects_the_diaphragm_on_an_img() {
    let mut controller = real("img400", 1e-5);
    spoil(&mut controller, 4, 1.0, -12.0);
    at(&mut controller, 4, 1e-5);
    write(&mut controller, 4, 15, &[0, 1]).unwrap();
    assert!(close(at(&mut controller, 4, 10.0), 10.0, 1e-5), "{}", indicated(&controller, 4));
    power_cut(&mut controller);
    assert!(close(at(&mut controller, 4, 10.0), 10.0, 1e-5), "{}", indicated(&controller, 4));
    write(&mut controller, 4, 15, &[0, 0]).unwrap();
    assert!(close(at(&mut controller, 4, 10.0), 9.88, 1e-5));
}
