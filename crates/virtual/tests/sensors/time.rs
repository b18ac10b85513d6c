//! Processes that take time: lag, ignition, degas, a filament that burns out. They repeat exactly.

use super::{around, device, indicated, shown, start};
use profivac_devices::model::Fault;
use profivac_devices::{Action, Switch};
use profivac_vacuum::Gas;
use profivac_virtual::device::VirtualDevice;

const FOUR: &str = "img400";

fn real(name: &str, mbar: f64, seed: u64) -> VirtualDevice {
    let mut device = device(name, mbar).with_real_sensors(seed);
    start(&mut device);
    device
}

#[test]
fn each_seed_gives_a_different_gauge_and_the_same_seed_the_same_gauge() {
    let run = |name: &str, seed| {
        let mut device = real(name, 1e-3, seed);
        (0..200).map(|_| (device.advance(0.01), device.report()).1).collect::<Vec<_>>()
    };
    for name in ["pcg550", "bpg400", "bcg450", FOUR, "tpg500"] {
        assert_eq!(run(name, 7), run(name, 7), "{name}");
        assert_ne!(run(name, 7), run(name, 8), "{name}");
    }
}

#[test]
fn a_real_gauge_is_noisy_and_reads_near_the_true_pressure() {
    for (name, mbar, within) in [("bcg450", 1e-6, 0.2), ("bpg400", 0.1, 0.1), ("pcg550", 100.0, 0.02)] {
        let mut gauge = real(name, mbar, 3);
        gauge.advance(20.0 * 3600.0);
        let values: Vec<f64> = (0..50).map(|_| (gauge.advance(0.01), shown(&gauge)).1).collect();
        let mean = values.iter().sum::<f64>() / 50.0;
        assert!((mean / mbar - 1.0).abs() < within, "{name}: {mean} at {mbar} mbar");
        assert!(values.windows(2).all(|pair| pair[0] != pair[1]), "{name} is not noisy");
    }
}

#[test]
fn a_real_gauge_lags_and_an_ideal_one_does_not() {
    let mut ideal = device("psg550", 1.0);
    start(&mut ideal);
    ideal.set_environment(around(Gas::N2, 10.0));
    assert_eq!(shown(&ideal), 10.0);
    let mut gauge = real("psg550", 0.1, 1);
    gauge.set_environment(around(Gas::N2, 1.0));
    assert!(shown(&gauge) < 0.2);
    gauge.advance(0.08);
    assert!((0.6..0.75).contains(&shown(&gauge)), "{}", shown(&gauge));
    gauge.advance(1.0);
    assert!((0.95..1.05).contains(&shown(&gauge)), "{}", shown(&gauge));
}

/// While the discharge ignites, no value between no signal and the pressure is shown as valid.
#[test]
fn an_igniting_cold_cathode_never_shows_a_valid_ultra_high_vacuum() {
    for seed in 0..10 {
        let mut controller = device("tpg500", 2e-6).with_real_sensors(seed);
        controller.set_power(false);
        controller.set_power(true);
        let mut valid = 0;
        for _ in 0..3000 {
            controller.advance(0.01);
            let report = controller.report();
            let shown = report.indicated.iter().find(|it| it.instance == 3).unwrap();
            assert!(!shown.valid || shown.value_mbar > 1e-6, "seed {seed}: {:e} mbar", shown.value_mbar);
            valid += u32::from(shown.valid);
        }
        assert!(valid > 1000, "seed {seed}: it did not ignite");
    }
}

/// Until its discharge ignites, a cold cathode reads its lower limit, which looks like a good vacuum.
#[test]
fn a_cold_cathode_has_to_ignite() {
    let seconds = |mbar: f64| {
        // When it starts measuring, the Pirani of its board switches the high voltage on.
        let mut controller = device("tpg500", mbar).with_real_sensors(5);
        controller.set_power(false);
        controller.set_power(true);
        let lit = |controller: &VirtualDevice| indicated(controller, 3) > 0.5 * mbar;
        f64::from((1..10_000).find(|_| (controller.advance(0.1), lit(&controller)).1).unwrap()) / 10.0
    };
    // The filter of the controller adds a second or two.
    let (poor, good) = (seconds(1e-6), seconds(1e-8));
    assert!((1.0..6.0).contains(&poor), "{poor} s");
    assert!((100.0..310.0).contains(&good), "{good} s");
}

#[test]
fn a_degas_changes_the_reading_while_it_lasts() {
    let mut gauge = real("bcg450", 1e-8, 2);
    gauge.advance(60.0);
    let before = shown(&gauge);
    gauge.operate(Action::Switch(Switch::Degas(true))).unwrap();
    gauge.advance(2.0);
    assert!(shown(&gauge) > 50.0 * before, "{} after {before}", shown(&gauge));
    gauge.advance(179.0);
    gauge.advance(1.0);
    assert_eq!(gauge.report().degas.iter().collect::<Vec<_>>(), [&false]);
    assert!(shown(&gauge) < before, "{} after {before}", shown(&gauge));
}

/// A BCG450 is protected by its Pirani; a gauge that does not detect the rising pressure loses its filament.
#[test]
fn the_protection_limits_the_wear_of_the_filament_during_venting() {
    let mut gauge = real("bcg450", 1e-6, 4);
    let vent = |gauge: &mut VirtualDevice| {
        for _ in 0..1000 {
            gauge.set_environment(around(Gas::Air, 1000.0));
            gauge.advance(0.01);
        }
    };
    vent(&mut gauge);
    let wear = gauge.sensor_mut(2).unwrap().filament().unwrap().wear();
    assert!((1e-4..0.1).contains(&wear), "{wear}");
    assert_eq!(gauge.report().emission.iter().collect::<Vec<_>>(), [&false]);
    assert_eq!(gauge.report().exception_status & 0x0F, 0, "no alarm");
}

/// A Pirani that indicates vacuum keeps the emission on in air: after three seconds the filament is burnt out, and the
/// gauge reports it.
#[test]
fn without_its_protection_a_filament_burns_out() {
    let mut gauge = real("bcg450", 1e-6, 4);
    gauge.sensor_mut(1).unwrap().imperfections_mut().unwrap().gain = 0.0;
    gauge.set_environment(around(Gas::Air, 1000.0));
    let seconds = (1..1000).find(|_| (gauge.advance(0.01), gauge.report().exception_status & 0x0F != 0).1);
    let seconds = f64::from(seconds.unwrap()) / 100.0;
    assert!((2.0..5.0).contains(&seconds), "{seconds}");
    assert_eq!(gauge.report().emission.iter().collect::<Vec<_>>(), [&false]);
    assert!(gauge.sensor_mut(2).unwrap().filament().unwrap().is_broken());
}

#[test]
fn a_broken_filament_is_a_fault_of_the_device() {
    for (name, instance) in [("bcg450", 2), ("bpg400", 2), (FOUR, 1)] {
        let mut gauge = real(name, 1e-6, 4);
        assert_eq!(gauge.report().emission.iter().next(), Some(&true), "{name}");
        gauge.sensor_mut(instance).unwrap().filament_mut().unwrap().break_off();
        gauge.advance(0.01);
        let report = gauge.report();
        assert_eq!(report.emission.iter().next(), Some(&false), "{name}");
        assert!(!report.indicated.iter().find(|it| it.instance == instance).unwrap().valid, "{name}");
        // The filament is replaced and the fault cleared.
        gauge.sensor_mut(instance).unwrap().filament_mut().unwrap().replace();
        gauge.operate(Action::Fault { fault: Fault::of_sensor(instance).unwrap(), active: false }).unwrap();
        gauge.advance(1.0);
        assert_eq!(gauge.report().device_state.name(), "EXECUTING", "{name}");
    }
}

/// A contaminated Pirani does not detect high vacuum, so the gauge does not use its ionisation part.
#[test]
fn a_contaminated_pirani_keeps_the_ionisation_part_off() {
    let mut gauge = real("bpg400", 1e-6, 6);
    assert_eq!(gauge.report().active_instance, 2);
    gauge.sensor_mut(1).unwrap().contaminate(0.5);
    gauge.advance(1.0);
    assert_eq!(gauge.report().active_instance, 1);
    assert!((5e-3..2e-2).contains(&shown(&gauge)), "{}", shown(&gauge));
}
