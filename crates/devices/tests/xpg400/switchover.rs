//! The switches on the side of the HPG400-SP. tira36e1 3.1.1.13, 3.1.1.14, 3.2.1.4, (38), (66), (77), (82).

use crate::support::hex;
use crate::xpg400::{FLOATS, exchanging, float_of, of_instance, restart, switch, tester};
use profivac_devices::xpg400::Xpg400Model;
use profivac_devices::{Action, Switch, UnsupportedAction};

/// 3.1.1.13: the position, mbar and COUNTS as the errata have them.
const POSITIONS: [(u8, f64, u16); 10] = [
    (0, 1.0, 28333),
    (1, 1.0, 28333),
    (2, 0.5, 28132),
    (3, 0.5, 28132),
    (4, 0.2, 27867),
    (5, 0.2, 27867),
    (6, 0.1, 27666),
    (7, 0.1, 27666),
    (8, 0.05, 27465),
    (9, 0.05, 27465),
];

#[test]
fn the_switchover_is_read_in_unit_and_type_of_the_device() {
    let mut tester = tester(Xpg400Model::Hpg);
    for (position, mbar, counts) in POSITIONS {
        switch(&mut tester, Switch::LowHigh(position)).unwrap();
        for (number, unit, factor) in [(8, "05 1C", 1.0), (8, "05 15", 0.75006168), (8, "05 1D", 100.0)] {
            tester.put(1, 21, &[number]).unwrap();
            tester.put(1, 22, &hex(unit)).unwrap();
            let value = f64::from(float_of(&tester.get(0, 202)));
            assert!((value / (mbar * factor) - 1.0).abs() < 1e-6, "position {position}: {value}");
        }
        tester.put(1, 21, &[3]).unwrap();
        // 0 where the threshold is less than one unit (38).
        tester.put(1, 22, &hex("05 1C")).unwrap();
        assert_eq!(tester.get(0, 202), (mbar.trunc() as u16).to_be_bytes(), "position {position}");
        tester.put(1, 22, &hex("03 E9")).unwrap();
        assert_eq!(tester.get(0, 202), counts.to_be_bytes(), "position {position}");
    }
}

#[test]
fn the_hpg_switches_over_at_the_pressure_of_low_high() {
    let mut tester = exchanging(Xpg400Model::Hpg, FLOATS, 1000.0);
    for (position, mbar, _) in POSITIONS {
        switch(&mut tester, Switch::LowHigh(position)).unwrap();
        for (factor, active) in [(2.0, 1), (1.0, 1), (0.99, 2), (0.1, 2), (1.01, 1)] {
            tester.pressure_mbar(mbar * factor);
            assert_eq!(tester.get(1, 47), [active], "position {position}, {factor} x {mbar} mbar");
            assert_eq!(tester.exchange(&[])[..3], [0x80, 0, active], "position {position}, {factor} x {mbar} mbar");
        }
    }
}

/// (82): the emission switches on at the same pressure.
#[test]
fn the_emission_goes_on_at_the_switchover() {
    let mut tester = exchanging(Xpg400Model::Hpg, FLOATS, 0.3);
    for (position, emission) in [(0, 1), (9, 0), (4, 0), (2, 1)] {
        switch(&mut tester, Switch::LowHigh(position)).unwrap();
        assert_eq!(of_instance(&mut tester, 2, 105), [emission], "position {position}");
    }
}

#[test]
fn cal_adj_reads_as_its_position_and_scales_the_ionisation_part() {
    let mut tester = exchanging(Xpg400Model::Hpg, FLOATS, 1e-3);
    assert_eq!(tester.get(0, 203), [0]);
    let factors = [1.0f32, 1.05, 1.1, 1.15, 1.2, 1.25, 0.8, 0.85, 0.9, 0.95];
    for (position, factor) in (0..=9u8).zip(factors) {
        switch(&mut tester, Switch::CalAdj(position)).unwrap();
        assert_eq!(tester.get(0, 203), [position]);
        let read = float_of(&tester.exchange(&[])[3..]);
        assert!((read / 1e-3 / factor - 1.0).abs() < 1e-6, "position {position}: {read} mbar");
    }
    // A switch keeps its position without power, and it has no effect on the Pirani.
    restart(&mut tester);
    tester.command(4).unwrap();
    assert!((float_of(&of_instance(&mut tester, 2, 19)) / 9.5e-4 - 1.0).abs() < 1e-6);
    tester.pressure_mbar(10.0);
    assert!((float_of(&of_instance(&mut tester, 1, 19)) / 10.0 - 1.0).abs() < 1e-6);
}

#[test]
fn a_switch_keeps_its_position_without_power() {
    let mut tester = tester(Xpg400Model::Hpg);
    switch(&mut tester, Switch::LowHigh(6)).unwrap();
    switch(&mut tester, Switch::CalAdj(7)).unwrap();
    restart(&mut tester);
    assert_eq!((float_of(&tester.get(0, 202)), tester.get(0, 203)), (0.1, vec![7]));
}

#[test]
fn a_gauge_rejects_a_position_or_a_switch_that_it_does_not_have() {
    let mut tester = tester(Xpg400Model::Hpg);
    for position in [10, 255] {
        assert!(switch(&mut tester, Switch::LowHigh(position)).is_err(), "{position}");
        assert!(switch(&mut tester, Switch::CalAdj(position)).is_err(), "{position}");
    }
    assert_eq!((float_of(&tester.get(0, 202)), tester.get(0, 203)), (1.0, vec![0]));
    let mut tester = crate::xpg400::tester(Xpg400Model::Bpg);
    let action = Action::Switch(Switch::LowHigh(1));
    assert_eq!(switch(&mut tester, Switch::LowHigh(1)), Err(UnsupportedAction { action }));
}

/// The BPG400-SP has its switchover at 5.5e-3 mbar of the Pirani (77).
#[test]
fn the_pirani_decides_the_active_instance() {
    let mut tester = exchanging(Xpg400Model::Bpg, FLOATS, 1e-3);
    for (pirani, ion, active, value) in [
        (5.4e-3, 6e-3, 2, 6e-3f32),
        (5.5e-3, 5e-3, 1, 5.5e-3),
        (6e-3, 5e-3, 1, 6e-3),
        // Emission off: only the Pirani measures.
        (1e-1, 1e-8, 1, 1e-1),
    ] {
        profivac_devices::SimulatedDevice::sense(tester.device(), 0, pirani * 100.0);
        profivac_devices::SimulatedDevice::sense(tester.device(), 1, ion * 100.0);
        let du = tester.exchange(&[]);
        assert_eq!(du[2], active, "{pirani} and {ion} mbar");
        assert!((float_of(&du[3..]) / value - 1.0).abs() < 1e-6, "{pirani} and {ion} mbar");
    }
}
