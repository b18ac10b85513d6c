//! The adjustment of the Pirani at atmospheric pressure. tira36e1 3.2.1.1, 3.3.2.5, (103).

use crate::support::Tester;
use crate::xpg400::{FLOATS, Gauge, KINDS, exchanging, float, of_instance, restart, tester};
use profivac_devices::SimulatedDevice;

/// AI Block Adjust Command.
fn adjust(tester: &mut Tester<Gauge>, value: u8) -> Result<(), u8> {
    tester.put(1, 15, &[value])
}

/// Full Scale State.
fn state(tester: &mut Tester<Gauge>) -> u8 {
    of_instance(tester, 1, 140)[0]
}

fn close(found: f32, expected: f64) -> bool {
    (f64::from(found) / expected - 1.0).abs() < 1e-6
}

#[test]
fn an_adjusted_pirani_reads_full_scale_also_after_power_up() {
    for kind in KINDS {
        let mut tester = exchanging(kind, FLOATS, 1e-3);
        tester.device().sense(0, 87_000.0);
        assert_eq!(state(&mut tester), 0);
        adjust(&mut tester, 1).unwrap();
        assert_eq!(state(&mut tester), 1);
        tester.device().settle();
        assert_eq!(state(&mut tester), 1, "settling does not let time pass");
        tester.device().advance(9.9);
        assert!(close(float(&mut tester, 1, 19), 870.0), "still running");
        tester.device().advance(0.2);
        assert_eq!(state(&mut tester), 0);
        assert!(close(float(&mut tester, 1, 19), 1000.0));
        tester.device().sense(0, 8_700.0);
        assert!(close(float(&mut tester, 1, 19), 100.0));
        // The other part is not adjusted.
        tester.device().sense(0, 0.0);
        assert!(close(float(&mut tester, 2, 19), 1e-3));
        restart(&mut tester);
        tester.device().sense(0, 43_500.0);
        tester.command(4).unwrap();
        assert!(close(float(&mut tester, 1, 19), 500.0));
    }
}

#[test]
fn an_unknown_command_and_a_second_start_are_refused() {
    let mut tester = exchanging(KINDS[0], FLOATS, 900.0);
    assert_eq!(adjust(&mut tester, 0), Ok(()));
    assert_eq!(state(&mut tester), 0, "0 does nothing");
    assert_eq!([2, 3, 255].map(|value| adjust(&mut tester, value)), [Err(2); 3]);
    adjust(&mut tester, 1).unwrap();
    assert_eq!(adjust(&mut tester, 1), Err(201));
    adjust(&mut tester, 0).unwrap();
    assert_eq!(state(&mut tester), 1, "0 stops nothing");
}

#[test]
fn the_adjustment_needs_executing_and_a_working_pirani() {
    let mut tester = tester(KINDS[1]);
    assert_eq!(adjust(&mut tester, 1), Err(202), "IDLE");
    let mut tester = exchanging(KINDS[1], FLOATS, 900.0);
    tester.fault("sensor1", true);
    assert_eq!(adjust(&mut tester, 1), Err(202));
}

/// Events that interrupt an adjustment.
type Interruption = (&'static str, fn(&mut Tester<Gauge>));

#[test]
fn an_interrupted_adjustment_changes_nothing() {
    let interruptions: [Interruption; 4] = [
        ("stop", |tester| tester.command(5).unwrap()),
        ("fault", |tester| tester.fault("electronics1", true)),
        ("reset", |tester| tester.command(1).unwrap()),
        ("power", restart),
    ];
    for (what, break_off) in interruptions {
        let mut tester = exchanging(KINDS[0], FLOATS, 900.0);
        adjust(&mut tester, 1).unwrap();
        break_off(&mut tester);
        assert_eq!(state(&mut tester), 0, "{what}");
        tester.fault("electronics1", false);
        tester.device().settle();
        let _ = tester.command(4);
        tester.device().advance(60.0);
        tester.pressure_mbar(900.0);
        assert!(close(float(&mut tester, 1, 19), 900.0), "{what}");
    }
}

#[test]
fn an_adjustment_outside_air_changes_nothing() {
    // Pressure zero, below zero (a zero error), high vacuum, and foreline pressure.
    for sensed_pa in [0.0, -0.5, 0.1, 9_990.0] {
        let mut tester = exchanging(KINDS[0], FLOATS, 1e-3);
        tester.device().sense(0, sensed_pa);
        adjust(&mut tester, 1).unwrap();
        tester.device().advance(10.0);
        assert_eq!(state(&mut tester), 0);
        tester.pressure_mbar(900.0);
        assert!(close(float(&mut tester, 1, 19), 900.0), "{sensed_pa} Pa");
    }
}
