//! Trip points, atmosphere detection, push buttons, discrete outputs and relays. Chapters 10 and 11, (93) to (105).

use crate::pxg55x::{COUNTS, Gauge, MBAR, PASCAL, RELAYS, TORR, exchanging, float_of, pcg, pcg_without_atm, psg};
use crate::support::{Tester, hex};
use profivac_devices::pxg55x::Pxg55xModel;
use profivac_devices::{Action, SimulatedDevice};

/// Telegram 201: integers.
const INTEGERS: &str = "44 85 05 03 05 0A";

/// A unit, a point and a hysteresis that are round numbers in it, and the factor to mbar.
struct UnitCase {
    user: &'static str,
    point: f64,
    hysteresis: f64,
    mbar: fn(f64) -> f64,
}

/// 8.1.3
const UNITS: [UnitCase; 4] = [
    UnitCase { user: MBAR, point: 200.0, hysteresis: 8.0, mbar: |number| number },
    UnitCase { user: TORR, point: 300.0, hysteresis: 20.0, mbar: |number| number * 1.333_223_69 },
    UnitCase { user: PASCAL, point: 20_000.0, hysteresis: 400.0, mbar: |number| number / 100.0 },
    UnitCase {
        user: COUNTS,
        point: 29_000.0,
        hysteresis: 100.0,
        mbar: |number| 10f64.powf((number - 1.0) / 3511.0) / 1_048_576.0,
    },
];

const HIGH_POINT: u8 = 17;
const HIGH_ENABLE: u8 = 18;
const LOW_POINT: u8 = 19;
const LOW_ENABLE: u8 = 20;
const STATUS: u8 = 21;
const HIGH_HYSTERESIS: u8 = 31;
const LOW_HYSTERESIS: u8 = 32;
const FACTOR: u8 = 201;
const MODE: u8 = 202;

/// Writes a pressure in the present unit and number type.
fn put(tester: &mut Tester<Gauge>, slot: u8, index: u8, number: f64) -> Result<(), u8> {
    let octets = match tester.get(1, 21)[0] {
        3 => (number as u16).to_be_bytes().to_vec(),
        _ => (number as f32).to_be_bytes().to_vec(),
    };
    tester.put(slot, index, &octets)
}

/// The status of a trip point in each place that shows it; all must agree in EXECUTING.
fn status(tester: &mut Tester<Gauge>, slot: u8) -> bool {
    let trip = tester.get(slot, STATUS)[0];
    // The discrete output follows the trip point (93); its status is that of the gauge (166).
    let error = u8::from(tester.report().exception_status & 0x07 != 0);
    assert_eq!((tester.get(slot + 2, 19)[0], tester.get(slot + 2, 20)[0]), (trip, error));
    if tester.is_exchanging() {
        // The last two octets of telegrams 201 and 202 (103).
        let inputs = tester.exchange(&[]);
        assert_eq!(inputs[inputs.len() - 4 + usize::from(slot)], trip);
    }
    let relay = tester.report().relays.iter().nth(usize::from(slot - 2)).copied();
    assert_eq!(relay, Some(trip == 1));
    trip == 1
}

/// A gauge that exchanges with relays in its telegram; both points of both slots off.
fn bench(kind: Pxg55xModel, user: &str, cfg: &str) -> Tester<Gauge> {
    let mut tester = crate::pxg55x::tester(kind);
    tester.pressure_mbar(500.0);
    tester.bring_up(&hex(user), &hex(cfg));
    for slot in [2, 3] {
        tester.put(slot, LOW_ENABLE, &[0]).unwrap();
    }
    tester
}

/// Rises and falls in quarters of the hysteresis around a point, twice. `trips` and `holds` are the sentences of 11.1.1
/// for a distance from the point in quarters.
fn walk(tester: &mut Tester<Gauge>, slot: u8, case: &UnitCase, trips: fn(i32) -> bool, holds: fn(i32) -> bool) {
    let quarters: Vec<i32> = (-9..=9).chain((-9..=9).rev()).chain(-9..=9).chain((-2..=2).rev()).collect();
    let mut expected = status(tester, slot);
    for quarter in quarters {
        tester.pressure_mbar((case.mbar)(case.point + case.hysteresis * f64::from(quarter) / 4.0));
        expected = trips(quarter) || (expected && holds(quarter));
        assert_eq!(status(tester, slot), expected, "{} {quarter} quarters from {}", case.user, case.point);
    }
}

/// "Status will be set if the input (ProcessValue) is at or below the Low Trip Point. If the pressure (input) increases
/// above Low Trip Point + Low Trip Point Hysteresis, the Status will be reset."
#[test]
fn a_low_trip_point_works_in_every_unit_and_number_type() {
    for kind in [pcg(), pcg_without_atm(), psg()] {
        for case in UNITS {
            for (cfg, slot) in [(RELAYS, 2), (INTEGERS, 3)] {
                let mut tester = bench(kind, case.user, cfg);
                put(&mut tester, slot, LOW_POINT, case.point).unwrap();
                put(&mut tester, slot, LOW_HYSTERESIS, case.hysteresis).unwrap();
                tester.put(slot, LOW_ENABLE, &[1]).unwrap();
                walk(&mut tester, slot, &case, |quarter| quarter <= 0, |quarter| quarter <= 4);
                assert!(!status(&mut tester, 5 - slot), "the other one");
            }
        }
    }
}

/// "Status will be set if the input (ProcessValue) is at or above the High Trip Point. If the pressure (input)
/// decreases below High Trip Point - High Trip Point Hysteresis, the Status will be reset."
#[test]
fn a_high_trip_point_works_in_every_unit_and_number_type() {
    for kind in [pcg(), pcg_without_atm(), psg()] {
        for case in UNITS {
            for (cfg, slot) in [(RELAYS, 3), (INTEGERS, 2)] {
                let mut tester = bench(kind, case.user, cfg);
                put(&mut tester, slot, HIGH_POINT, case.point).unwrap();
                put(&mut tester, slot, HIGH_HYSTERESIS, case.hysteresis).unwrap();
                tester.put(slot, HIGH_ENABLE, &[1]).unwrap();
                walk(&mut tester, slot, &case, |quarter| quarter >= 0, |quarter| quarter >= -4);
                assert!(!status(&mut tester, 5 - slot), "the other one");
            }
        }
    }
}

/// 11.2.10 and 11.2.11, the printed examples.
#[test]
fn the_hysteresis_follows_the_examples_with_100_and_2() {
    let mut tester = bench(psg(), PASCAL, RELAYS);
    for (slot, point, hysteresis, enable) in
        [(2, HIGH_POINT, HIGH_HYSTERESIS, HIGH_ENABLE), (3, LOW_POINT, LOW_HYSTERESIS, LOW_ENABLE)]
    {
        put(&mut tester, slot, point, 100.0).unwrap();
        put(&mut tester, slot, hysteresis, 2.0).unwrap();
        tester.put(slot, enable, &[1]).unwrap();
    }
    for (pa, high, low) in [
        (103.0, true, false),
        (100.0, true, true),
        (98.0, true, true),
        (97.9, false, true),
        (99.9, false, true),
        (102.0, true, true),
        (102.1, true, false),
        (97.0, false, true),
    ] {
        tester.pressure_mbar(pa / 100.0);
        assert_eq!((status(&mut tester, 2), status(&mut tester, 3)), (high, low), "{pa} Pa");
    }
}

/// One status for two conditions, each with its own memory (97); none enabled, none (98).
#[test]
fn both_points_of_a_slot_switch_the_relay() {
    let mut tester = bench(psg(), MBAR, RELAYS);
    for (index, mbar) in [(LOW_POINT, 10.0), (HIGH_POINT, 90.0), (LOW_HYSTERESIS, 1.0), (HIGH_HYSTERESIS, 1.0)] {
        put(&mut tester, 2, index, mbar).unwrap();
    }
    for (low, high, expected) in [
        (1, 1, [true, true, false, false, true, true, false]),
        (1, 0, [true, true, false, false, false, false, false]),
        (0, 1, [false, false, false, false, true, true, false]),
        (0, 0, [false; 7]),
    ] {
        tester.pressure_mbar(50.0);
        tester.put(2, LOW_ENABLE, &[low]).unwrap();
        tester.put(2, HIGH_ENABLE, &[high]).unwrap();
        for (mbar, expected) in [10.0, 11.0, 11.1, 50.0, 90.0, 89.0, 88.9].into_iter().zip(expected) {
            tester.pressure_mbar(mbar);
            assert_eq!(status(&mut tester, 2), expected, "low {low}, high {high}, {mbar} mbar");
        }
    }
}

/// (98): "enabling evaluates the present value, inside the hysteresis band the result is 0".
#[test]
fn an_enabled_trip_point_starts_without_a_condition() {
    let mut tester = bench(psg(), MBAR, RELAYS);
    put(&mut tester, 2, LOW_POINT, 100.0).unwrap();
    put(&mut tester, 2, LOW_HYSTERESIS, 10.0).unwrap();
    for (mbar, expected) in [(100.0, true), (105.0, false), (120.0, false)] {
        tester.pressure_mbar(mbar);
        tester.put(2, LOW_ENABLE, &[1]).unwrap();
        assert_eq!(status(&mut tester, 2), expected, "{mbar} mbar");
        tester.put(2, LOW_ENABLE, &[0]).unwrap();
        assert!(!status(&mut tester, 2));
    }
}

/// (32): the two switching points keep their pressure when the unit changes.
#[test]
fn a_hysteresis_keeps_its_switching_points_in_every_unit() {
    let mut tester = crate::pxg55x::executing(psg(), 500.0);
    tester.command(5).unwrap();
    for (index, mbar) in [(LOW_POINT, 100.0), (LOW_HYSTERESIS, 900.0), (HIGH_POINT, 100.0), (HIGH_HYSTERESIS, 90.0)] {
        put(&mut tester, 2, index, mbar).unwrap();
    }
    // A decade above, a decade below: 3511 counts each.
    for (unit, low, high) in [
        ("10 01", 3511.0, 3511.0),
        ("13 01", 675.055_5, 67.505_55),
        ("13 09", 90_000.0, 9000.0),
        ("13 08", 900.0, 90.0),
    ] {
        tester.put(2, 28, &hex(unit)).unwrap();
        for (index, expected) in [(LOW_HYSTERESIS, low), (HIGH_HYSTERESIS, high)] {
            let found = float_of(&tester.get(2, index));
            assert!((f64::from(found) / expected - 1.0).abs() < 1e-6, "{unit}: {found} instead of {expected}");
        }
    }
}

/// 11.1.2: the point is factor x atmosphere, in any unit; the comparison is that of the setpoint function.
#[test]
fn atmosphere_detection_works_in_every_unit() {
    for case in UNITS {
        for (mode, point, hysteresis, enable, trips, holds) in [
            (
                1,
                LOW_POINT,
                LOW_HYSTERESIS,
                LOW_ENABLE,
                (|it| it <= 0) as fn(i32) -> bool,
                (|it| it <= 4) as fn(i32) -> bool,
            ),
            (2, HIGH_POINT, HIGH_HYSTERESIS, HIGH_ENABLE, |it| it >= 0, |it| it >= -4),
        ] {
            let mut tester = bench(pcg(), case.user, RELAYS);
            tester.put(2, FACTOR, &0.5f32.to_be_bytes()).unwrap();
            tester.put(2, MODE, &[mode]).unwrap();
            tester.put(2, enable, &[1]).unwrap();
            // Twice the point is the atmosphere.
            let atmosphere_mbar = 2.0 * (case.mbar)(case.point);
            tester.device().sense(2, atmosphere_mbar * 100.0);
            put(&mut tester, 2, hysteresis, case.hysteresis).unwrap();
            let shown = f64::from(float_of(&tester.get(2, point)));
            assert!((shown / case.point - 1.0).abs() < 1e-6, "{}: {shown} instead of {}", case.user, case.point);
            walk(&mut tester, 2, &case, trips, holds);
            // It cannot be written (101); the other point can.
            assert_eq!(put(&mut tester, 2, point, case.point), Err(17));
            assert_eq!(put(&mut tester, 2, HIGH_POINT + LOW_POINT - point, case.point), Ok(()));
        }
    }
}

/// The atmosphere changes and the chamber does not: the point follows the atmosphere.
#[test]
fn the_calculated_point_follows_the_atmosphere() {
    let mut tester = bench(pcg(), MBAR, RELAYS);
    tester.put(3, FACTOR, &0.9f32.to_be_bytes()).unwrap();
    tester.put(3, MODE, &[2]).unwrap();
    tester.put(3, HIGH_ENABLE, &[1]).unwrap();
    put(&mut tester, 3, HIGH_HYSTERESIS, 10.0).unwrap();
    tester.pressure_mbar(900.0);
    // 90 % of the atmosphere, and 10 mbar less before it is lost.
    for (atmosphere, expected) in [
        (1013.0, false),
        (1000.5, false),
        (999.9, true),
        (1011.0, true),
        (1011.2, false),
        (1001.0, false),
        (900.0, true),
    ] {
        tester.device().sense(2, atmosphere * 100.0);
        assert_eq!(status(&mut tester, 3), expected, "{atmosphere} mbar outside");
        let point = float_of(&tester.get(3, HIGH_POINT));
        assert!((f64::from(point) / (atmosphere * 0.9) - 1.0).abs() < 1e-6, "{point}");
    }
    // A failed sensor no longer moves the trip point.
    tester.fault("sensor3", true);
    tester.device().sense(2, 50_000.0);
    assert_eq!(float_of(&tester.get(3, HIGH_POINT)), 810.0);
    // In setpoint mode the last point stays and can be written.
    tester.fault("sensor3", false);
    tester.put(3, MODE, &[0]).unwrap();
    tester.device().sense(2, 101_300.0);
    assert_eq!(float_of(&tester.get(3, HIGH_POINT)), 450.0);
    assert_eq!(put(&mut tester, 3, HIGH_POINT, 700.0), Ok(()));
}

/// (100)
#[test]
fn modes_that_calculate_need_an_atmosphere_sensor() {
    for (kind, calculating) in [(pcg(), Ok(())), (pcg_without_atm(), Err(2)), (psg(), Err(2))] {
        let mut tester = crate::pxg55x::tester(kind);
        for (mode, result) in [(0, Ok(())), (1, calculating), (2, calculating), (3, Err(2)), (4, Ok(())), (5, Err(2))] {
            assert_eq!(tester.put(2, MODE, &[mode]), result, "mode {mode}");
        }
    }
}

/// 11.2.13: the point that the push button sets to the present pressure.
#[test]
fn a_push_button_sets_the_point_that_the_mode_allows() {
    // Mode; enables of low and high; whether low and high have changed.
    for (mode, low, high, moved) in [
        (0, 1, 1, (true, false)),
        (0, 1, 0, (true, false)),
        (0, 0, 1, (false, true)),
        (0, 0, 0, (false, false)),
        (1, 1, 1, (false, false)),
        (1, 0, 1, (false, true)),
        (2, 1, 1, (true, false)),
        (2, 0, 1, (false, false)),
        (4, 1, 1, (false, false)),
        (4, 1, 0, (false, false)),
        (4, 0, 1, (false, false)),
    ] {
        for (button, slot) in [(1, 2), (2, 3)] {
            let mut tester = bench(pcg(), MBAR, RELAYS);
            tester.put(slot, MODE, &[mode]).unwrap();
            tester.put(slot, LOW_ENABLE, &[low]).unwrap();
            tester.put(slot, HIGH_ENABLE, &[high]).unwrap();
            let points =
                |tester: &mut Tester<Gauge>, slot| [LOW_POINT, HIGH_POINT].map(|it| float_of(&tester.get(slot, it)));
            let (before, other) = (points(&mut tester, slot), points(&mut tester, 5 - slot));
            tester.pressure_mbar(321.0);
            tester.device().operate(Action::Button(button)).unwrap();
            let after = points(&mut tester, slot);
            assert_eq!((after[0] != before[0], after[1] != before[1]), moved, "mode {mode}, {low} {high}");
            assert!(moved == (false, false) || after.contains(&321.0), "{after:?}");
            assert_eq!(points(&mut tester, 5 - slot), other, "button {button} is that of slot {slot}");
        }
    }
}

#[test]
fn a_push_button_stores_a_trip_point_at_a_valid_pressure_only() {
    let mut tester = bench(psg(), MBAR, RELAYS);
    tester.put(2, LOW_ENABLE, &[1]).unwrap();
    tester.pressure_mbar(30.0);
    tester.device().operate(Action::Button(1)).unwrap();
    for (mbar, fault) in [(1300.0, ""), (40.0, "sensor1"), (40.0, "comm")] {
        tester.pressure_mbar(mbar);
        if !fault.is_empty() {
            tester.fault(fault, true);
        }
        tester.device().operate(Action::Button(1)).unwrap();
        assert_eq!(float_of(&tester.get(2, LOW_POINT)), 30.0, "{mbar} mbar {fault}");
        if !fault.is_empty() {
            tester.fault(fault, false);
        }
    }
    crate::pxg55x::restart(&mut tester);
    assert_eq!(float_of(&tester.get(2, LOW_POINT)), 30.0);
    tester.device().operate(Action::Button(1)).unwrap();
    assert_eq!(float_of(&tester.get(2, LOW_POINT)), 30.0, "not in IDLE");
}

/// (94), (104): outside EXECUTING the relay is off, and so is its trip point. No safe value is kept.
#[test]
fn a_relay_works_in_executing_only() {
    for kind in Pxg55xModel::all() {
        let mut tester = exchanging(kind, RELAYS, 10.0);
        put(&mut tester, 2, LOW_POINT, 100.0).unwrap();
        let closed = |tester: &mut Tester<Gauge>| tester.report().relays.iter().copied().collect::<Vec<_>>();
        assert_eq!(closed(&mut tester), [true, false]);
        for command in [5, 2, 3] {
            tester.command(command).unwrap();
            assert_eq!(closed(&mut tester), [false, false], "command {command}");
            assert_eq!((tester.get(2, 21), tester.get(4, 19)), (vec![0], vec![0]), "command {command}");
        }
        // Inside the hysteresis, above the point.
        put(&mut tester, 2, LOW_HYSTERESIS, 1000.0).unwrap();
        tester.pressure_mbar(101.0);
        tester.command(4).unwrap();
        assert_eq!(closed(&mut tester), [false, false]);
        tester.pressure_mbar(10.0);
        assert_eq!(closed(&mut tester), [true, false]);
        tester.command(5).unwrap();
        tester.command(4).unwrap();
        assert_eq!(closed(&mut tester), [true, false]);
        tester.device().set_power(false);
        assert_eq!(closed(&mut tester), [false, false]);
    }
}

/// A trip point compares the process value of the telegrams (96), also a safe value (104).
#[test]
fn a_trip_point_compares_the_active_value() {
    let mut tester = exchanging(pcg(), RELAYS, 100.0);
    put(&mut tester, 2, LOW_POINT, 90.0).unwrap();
    // The Pirani reads less, but the diaphragm is active.
    tester.device().sense(1, 5_000.0);
    assert!(!status(&mut tester, 2));
    tester.device().sense(0, 8_900.0);
    assert!(status(&mut tester, 2));
    tester.pressure_mbar(100.0);
    tester.put(1, 40, &95f32.to_be_bytes()).unwrap();
    tester.put(1, 39, &[3]).unwrap();
    tester.fault("sensor1", true);
    assert!(!status(&mut tester, 2));
    tester.put(1, 40, &85f32.to_be_bytes()).unwrap();
    assert!(status(&mut tester, 2));
}

#[test]
fn the_discrete_output_of_a_trip_point_is_instance_1() {
    let mut tester = crate::pxg55x::tester(psg());
    for slot in [2, 3] {
        assert_eq!(tester.get(slot, 26), [1]);
    }
}

/// Telegrams 203 and 204 have the relays too.
#[test]
fn the_relays_follow_the_parameter_channel_in_the_inputs() {
    for (cfg, place) in [("C6 87 8D 0A 0A 05 03 05 0A", 12), ("C6 87 8F 0A 0A 05 08 05 0A", 14)] {
        let mut tester = exchanging(psg(), cfg, 10.0);
        tester.put(2, HIGH_ENABLE, &[1]).unwrap();
        assert_eq!(tester.exchange(&[0; 8])[place..], [1, 0]);
        tester.put(3, HIGH_ENABLE, &[1]).unwrap();
        tester.put(2, HIGH_ENABLE, &[0]).unwrap();
        assert_eq!(tester.exchange(&[0; 8])[place..], [0, 1]);
    }
}
