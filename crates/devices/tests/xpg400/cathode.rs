//! Emission and degas. tira36e1 3.3.3.5 to 3.3.3.8, Appendix C, (93) to (99).

use crate::support::Tester;
use crate::xpg400::{FLOATS, Gauge, exchanging, float, of_instance, switch};
use profivac_devices::xpg400::Xpg400Model;
use profivac_devices::{Action, SimulatedDevice, Switch, UnsupportedAction};

/// Hot Cathode Block State Command.
fn command(tester: &mut Tester<Gauge>, command: u8, value: u8) -> Result<(), u8> {
    tester.put(1, 46, &[2]).unwrap();
    tester.put(1, 14, &[command, value])
}

/// Emission Status, Emission Current in mA and Degas Status.
fn status(tester: &mut Tester<Gauge>) -> (u8, f32, u8) {
    let [emission, degas] = [105, 109].map(|index| of_instance(tester, 2, index)[0]);
    (emission, float(tester, 2, 106), degas)
}

const OFF: (u8, f32, u8) = (0, 0.0, 0);
const LOW: (u8, f32, u8) = (1, 0.025, 0);
const HIGH: (u8, f32, u8) = (2, 5.0, 0);
const DEGAS: (u8, f32, u8) = (3, 20.0, 3);

#[test]
fn the_emission_of_a_bpg_has_two_thresholds_and_two_currents() {
    let mut tester = exchanging(Xpg400Model::Bpg, FLOATS, 1000.0);
    for (mbar, expected) in [
        (1000.0, OFF),
        (2.41e-2, OFF),
        (2.39e-2, LOW),
        (3.19e-2, LOW),
        (3.21e-2, OFF),
        (2.41e-2, OFF),
        (1e-5, LOW),
        (7.1e-6, HIGH),
        (1e-10, HIGH),
    ] {
        tester.pressure_mbar(mbar);
        assert_eq!(status(&mut tester), expected, "{mbar} mbar");
    }
    tester.command(5).unwrap();
    assert_eq!(status(&mut tester), OFF, "only in EXECUTING");
}

/// 3.2.1.4, (82): on at the switchover of position 0, off a third above it; one current (97).
#[test]
fn the_emission_of_an_hpg_is_on_or_off() {
    let mut tester = exchanging(Xpg400Model::Hpg, FLOATS, 1000.0);
    for (mbar, expected) in [(1000.0, 0), (1.01, 0), (0.99, 1), (1e-7, 1), (1.33, 1), (1.34, 0), (1.01, 0), (0.99, 1)] {
        tester.pressure_mbar(mbar);
        assert_eq!(of_instance(&mut tester, 2, 105), [expected], "{mbar} mbar");
        assert!(tester.report().emission.iter().eq([&(expected == 1)]));
        assert_eq!(tester.report().degas.iter().count(), 0);
    }
}

/// (97): off at any time, on only where the automatic control would switch it on.
#[test]
fn emission_status_switches_the_emission() {
    for (kind, too_high) in [(Xpg400Model::Bpg, 2.4e-2), (Xpg400Model::Hpg, 1.0)] {
        let mut tester = exchanging(kind, FLOATS, 1e-4);
        let emission = |tester: &mut Tester<Gauge>| of_instance(tester, 2, 105)[0];
        tester.put(1, 46, &[2]).unwrap();
        tester.put(1, 105, &[0]).unwrap();
        assert_eq!(emission(&mut tester), 0);
        // The Pirani is active far below its range: (57), (81).
        assert_eq!(tester.exchange(&[])[..3], [0xA0, 0x01, 1]);
        assert_eq!(of_instance(&mut tester, 2, 102), [3]);
        tester.put(1, 105, &[1]).unwrap();
        assert_eq!(emission(&mut tester), 1);
        assert_eq!(tester.exchange(&[])[..3], [0x80, 0x00, 2]);
        assert_eq!(tester.put(1, 105, &[2]), Err(2));
        tester.pressure_mbar(1000.0);
        tester.pressure_mbar(too_high);
        assert_eq!(tester.put(1, 105, &[1]), Err(202), "{kind:?}");
        assert_eq!(tester.put(1, 105, &[0]), Ok(()));
    }
}

#[test]
fn a_failed_sensor_has_no_emission() {
    for kind in crate::xpg400::KINDS {
        let mut tester = exchanging(kind, FLOATS, 1e-4);
        for fault in ["sensor1", "sensor2", "electronics1", "electronics2"] {
            assert_eq!(of_instance(&mut tester, 2, 105), [1], "before {fault}");
            tester.fault(fault, true);
            assert_eq!(of_instance(&mut tester, 2, 105), [0], "{fault}");
            assert_eq!(tester.put(1, 105, &[1]), Err(202), "{fault}");
            tester.fault(fault, false);
        }
    }
}

/// (98)
#[test]
fn the_gauge_chooses_the_current() {
    let mut tester = exchanging(Xpg400Model::Bpg, FLOATS, 1e-4);
    tester.put(1, 46, &[2]).unwrap();
    tester.put(1, 106, &5.0f32.to_be_bytes()).unwrap();
    assert_eq!(status(&mut tester), LOW);
    assert_eq!(tester.put(1, 106, &1.0f32.to_be_bytes()), Err(2));
}

/// 3.3.3.8, (95)
#[test]
fn degas_runs_three_minutes_below_its_limit() {
    let mut tester = exchanging(Xpg400Model::Bpg, FLOATS, 7.1e-6);
    command(&mut tester, 1, 1).unwrap();
    assert_eq!(status(&mut tester), DEGAS);
    assert!(tester.report().degas.iter().eq([&true]));
    tester.device().advance(179.9);
    assert_eq!(status(&mut tester), DEGAS);
    tester.device().settle();
    assert_eq!(status(&mut tester), DEGAS, "settling does not let time pass");
    tester.device().advance(0.2);
    assert_eq!(status(&mut tester), HIGH);
    command(&mut tester, 1, 1).unwrap();
    command(&mut tester, 1, 0).unwrap();
    assert_eq!(status(&mut tester), HIGH, "degas off");
}

/// (95): at 7.2e-6 mbar and above, without emission, outside EXECUTING. Off is always accepted.
#[test]
fn degas_is_refused_at_its_limit_and_without_emission() {
    let mut tester = exchanging(Xpg400Model::Bpg, FLOATS, 7.2e-6);
    assert_eq!(command(&mut tester, 1, 1), Err(202));
    assert_eq!(command(&mut tester, 1, 0), Ok(()));
    // The sensor warning of these gauges has no bit for it (96).
    assert_eq!((of_instance(&mut tester, 2, 104), tester.get(0, 26)), (vec![0, 0], vec![0x80]));
    tester.pressure_mbar(1e-7);
    tester.put(1, 105, &[0]).unwrap();
    assert_eq!(command(&mut tester, 1, 1), Err(202));
    tester.put(1, 105, &[1]).unwrap();
    command(&mut tester, 1, 1).unwrap();
    // A running degas continues above the limit until the emission goes off.
    tester.pressure_mbar(1e-4);
    assert_eq!(status(&mut tester), DEGAS);
    tester.pressure_mbar(1e-1);
    assert_eq!(status(&mut tester), OFF);
    tester.pressure_mbar(1e-7);
    assert_eq!(status(&mut tester), HIGH);
    command(&mut tester, 1, 1).unwrap();
    tester.command(5).unwrap();
    assert_eq!(status(&mut tester), OFF);
    assert_eq!(command(&mut tester, 1, 1), Err(202));
    assert_eq!(command(&mut tester, 1, 0), Ok(()));
}

/// Appendix C, pin 7: connected in the BPG400-SP only.
#[test]
fn the_degas_input_starts_and_stops_degas() {
    let mut tester = exchanging(Xpg400Model::Bpg, FLOATS, 1e-7);
    switch(&mut tester, Switch::Degas(true)).unwrap();
    assert_eq!(status(&mut tester), DEGAS);
    switch(&mut tester, Switch::Degas(false)).unwrap();
    assert_eq!(status(&mut tester), HIGH);
    tester.pressure_mbar(1e-4);
    switch(&mut tester, Switch::Degas(true)).unwrap();
    assert_eq!(status(&mut tester), LOW);
    let mut tester = exchanging(Xpg400Model::Hpg, FLOATS, 1e-7);
    let action = Action::Switch(Switch::Degas(true));
    assert_eq!(switch(&mut tester, Switch::Degas(true)), Err(UnsupportedAction { action }));
}

/// (94)
#[test]
fn the_hpg_has_no_degas() {
    let mut tester = exchanging(Xpg400Model::Hpg, FLOATS, 1e-5);
    assert_eq!(command(&mut tester, 1, 1), Err(3));
    assert_eq!(tester.put(1, 106, &5.0f32.to_be_bytes()), Err(3));
}
