//! The principle of each part of a device, and how the device drives it.

use super::{around, device, start, write};
use profivac_devices::Drive::{self, Off, On};
use profivac_devices::model::Fault;
use profivac_devices::{Action, Principle, Switch};
use profivac_vacuum::Gas;
use profivac_virtual::device::VirtualDevice;
use profivac_virtual::device_spec::DEVICES;

const fn emission(milliamperes: f64) -> Drive {
    Drive::Emission { milliamperes, degas: false }
}

fn drives(device: &VirtualDevice) -> Vec<Drive> {
    let simulated = device.device();
    (0..simulated.parts().len()).map(|part| simulated.drive(part)).collect()
}

fn close(found: Drive, expected: Drive) -> bool {
    match (found, expected) {
        (Drive::Emission { milliamperes: a, degas: x }, Drive::Emission { milliamperes: b, degas: y }) => {
            (a / b - 1.0).abs() < 1e-6 && x == y
        }
        _ => found == expected,
    }
}

#[test]
fn every_part_of_every_device_has_a_principle_and_a_range() {
    for entry in &DEVICES {
        let device = device(entry.model.name, 1e-3);
        let simulated = device.device();
        for (part, of) in simulated.parts().iter().enumerate() {
            let span = simulated.measuring_range(part);
            assert!(0.0 < span.lowest_pa && span.lowest_pa < span.highest_pa, "{}: {of:?}", simulated.name());
            // Ion gauges end far below atmosphere; the others reach it.
            let ionises = matches!(of.principle, Principle::HotCathode | Principle::ColdCathode);
            assert_eq!(ionises, span.highest_pa < 1e3, "{}: {of:?} up to {} Pa", simulated.name(), span.highest_pa);
        }
    }
}

#[test]
fn without_power_no_part_is_driven() {
    for entry in &DEVICES {
        let mut device = device(entry.model.name, 1e-6);
        device.set_power(false);
        assert!(drives(&device).iter().all(|drive| *drive == Off), "{}", entry.model.name);
    }
}

/// tira41d1 3.3.3.6: the current depends on the pressure and is 20 mA during degas.
#[test]
fn the_emission_of_a_bcg_and_a_bpg_follows_the_pressure_and_degas() {
    for name in ["bcg450", "bpg400"] {
        let mut gauge = device(name, 1.0);
        start(&mut gauge);
        for (mbar, expected) in [(1.0, Off), (1e-3, emission(0.025)), (1e-7, emission(5.0))] {
            gauge.settle_in(around(Gas::N2, mbar));
            assert!(close(drives(&gauge)[1], expected), "{name} at {mbar} mbar: {:?}", drives(&gauge));
        }
        gauge.operate(Action::Switch(Switch::Degas(true))).unwrap();
        let degas = Drive::Emission { milliamperes: 20.0, degas: true };
        assert!(close(drives(&gauge)[1], degas), "{name}: {:?}", drives(&gauge));
        gauge.advance(181.0);
        assert!(close(drives(&gauge)[1], emission(5.0)), "{name}: {:?}", drives(&gauge));
        assert_eq!(drives(&gauge)[0], On, "{name}: the Pirani");
    }
}

/// tira36e1 3.3.3.6: one current.
#[test]
fn the_emission_of_an_hpg_is_on_or_off() {
    let mut gauge = device("hpg400", 10.0);
    start(&mut gauge);
    for (mbar, expected) in [(10.0, Off), (0.1, emission(0.025)), (1e-6, emission(0.025))] {
        gauge.settle_in(around(Gas::N2, mbar));
        assert!(close(drives(&gauge)[1], expected), "{mbar} mbar: {:?}", drives(&gauge));
    }
}

/// tira56e1 12.2.5: Pirani OFF.
#[test]
fn a_pcg_heats_its_pirani_by_its_off_mode() {
    let mut gauge = device("pcg550", 1.0);
    start(&mut gauge);
    write(&mut gauge, 1, 46, &[2]).unwrap();
    for (mode, drive) in [(2, Off), (0, On)] {
        write(&mut gauge, 1, 201, &[mode]).unwrap();
        assert_eq!(drives(&gauge), [On, drive, On], "mode {mode}");
    }
}

/// BG 5530 4.4.4, ID 107: codes.
#[test]
fn the_emission_of_an_img_follows_its_code() {
    let mut controller = device("img400", 1e-7);
    controller.device_mut().set_exchanging(true);
    assert_eq!(drives(&controller), [Off, Off, On, On]);
    start(&mut controller);
    for (code, milliamperes) in [(1, 0.1), (2, 1.0), (3, 1.6), (4, 10.0), (5, 45.0), (6, 90.0)] {
        write(&mut controller, 1, 107, &(code as f32).to_be_bytes()).unwrap();
        assert!(close(drives(&controller)[0], emission(milliamperes)), "{code}: {:?}", drives(&controller));
    }
    write(&mut controller, 2, 14, &[1, 1]).unwrap();
    assert!(matches!(drives(&controller)[1], Drive::Emission { degas: true, .. }));
    controller.operate(Action::Fault { fault: Fault::Power, active: true }).unwrap();
    assert_eq!(drives(&controller)[2..], [Off, Off], "the general supply feeds channels 3 and 4");
}

/// IF300P/IF301P manual 3.2.3.2: the high voltage of channels 3 and 4.
#[test]
fn a_tpg_switches_the_high_voltage() {
    let mut controller = device("tpg500", 1000.0);
    assert_eq!(drives(&controller), [On, On, Off, Off]);
    start(&mut controller);
    controller.settle_in(around(Gas::N2, 1e-5));
    assert_eq!(drives(&controller), [On, On, On, On]);
}

/// A value that is not a number counts as no pressure.
#[test]
fn a_sensor_value_that_is_not_a_number_gives_no_reading() {
    for entry in &DEVICES {
        let mut device = device(entry.model.name, 1.0);
        start(&mut device);
        for part in 0..device.device().parts().len() {
            device.device_mut().sense(part, f64::NAN);
        }
        let report = device.report();
        assert!(report.indicated.iter().all(|it| it.value_mbar.is_finite()), "{}: {report:?}", entry.model.name);
    }
}
