//! Pressures as numbers: conversions, scales, saturation, and which instance measures. 8.1.3, 8.3.3, 9.1.2, (14) to
//! (18), (67), (81) to (83), (86).

use crate::pxg55x::{
    COUNTS, FLOATS, Gauge, MBAR, PASCAL, TORR, exchanging, executing, float, of_instance, pcg, psg, tester,
};
use crate::support::{Tester, hex};
use profivac_devices::SimulatedDevice;
use profivac_devices::pxg55x::Pxg55xModel;

fn set_unit(tester: &mut Tester<Gauge>, user: &str) {
    tester.put(1, 22, &hex(user)[3..]).unwrap();
}

/// 3511 x log10(p x 2^20) + 1 (81).
fn log_counts(mbar: f64) -> f64 {
    3511.0 * (mbar * 1_048_576.0).log10() + 1.0
}

/// Instance, and its Full Scale, Overrange (90) and Underrange in mbar (86).
const PCG_LIMITS: [(u8, [f64; 3]); 3] =
    [(1, [1500.0, 1500.0, 1.0]), (2, [1000.0, 1200.0, 5e-5]), (3, [1200.0, 1200.0, 300.0])];
const PSG_LIMITS: [(u8, [f64; 3]); 1] = [(1, [1000.0, 1200.0, 5e-5])];

#[test]
fn the_limits_of_every_instance_in_every_unit_and_type() {
    let of_kind =
        |kind: Pxg55xModel, limits: &[(u8, [f64; 3])]| limits.iter().map(move |it| (kind, it.0, it.1)).collect();
    let limits: [Vec<_>; 2] = [of_kind(pcg(), &PCG_LIMITS), of_kind(psg(), &PSG_LIMITS)];
    for (kind, instance, limits) in limits.concat() {
        let is_atm = instance == 3;
        for (user, convert) in [
            (MBAR, (|mbar, _| mbar) as fn(f64, bool) -> f64),
            (TORR, |mbar, _| mbar / 1.333_223_69),
            (PASCAL, |mbar, _| mbar * 100.0),
            // The atmosphere sensor counts linearly (82).
            (COUNTS, |mbar, is_atm| if is_atm { mbar * 16.0 } else { log_counts(mbar) }),
        ] {
            let mut tester = tester(kind);
            set_unit(&mut tester, user);
            for (index, mbar) in [24, 44, 45].into_iter().zip(limits) {
                let expected = convert(mbar, is_atm);
                let found = f64::from(float(&mut tester, instance, index));
                assert!((found / expected - 1.0).abs() < 1e-6, "{instance}/{index}: {found}, not {expected}");
            }
            tester.put(1, 21, &[3]).unwrap();
            for (index, mbar) in [24, 44, 45].into_iter().zip(limits) {
                // Cut (17) and saturated (16).
                let expected = (convert(mbar, is_atm) + 1e-6).floor().min(32767.0) as u16;
                let found = of_instance(&mut tester, instance, index);
                assert_eq!(found, expected.to_be_bytes(), "{instance}/{index}: not {expected}");
            }
        }
    }
}

/// Calculated by hand: log10(2^20) = 6.02060, so 1 mbar is 3511 x 6.02060 + 1 = 21139.3 counts, and a decade 3511.
#[test]
fn counts_of_round_pressures() {
    for (mbar, counts) in [(0.01, 14117), (1.0, 21139), (10.0, 24650), (1000.0, 31672)] {
        let mut tester = executing(psg(), mbar);
        tester.command(5).unwrap();
        set_unit(&mut tester, COUNTS);
        tester.put(1, 21, &[3]).unwrap();
        tester.command(4).unwrap();
        assert_eq!(of_instance(&mut tester, 1, 19), u16::to_be_bytes(counts), "{mbar} mbar");
    }
}

/// 8.3.3
#[test]
fn the_atmosphere_sensor_counts_sixteen_to_the_mbar() {
    let mut tester = executing(pcg(), 1e-3);
    tester.device().sense(2, 98_712.5);
    tester.command(5).unwrap();
    set_unit(&mut tester, COUNTS);
    tester.command(4).unwrap();
    assert_eq!(float(&mut tester, 3, 19), 15_794.0);
    tester.put(1, 21, &[3]).unwrap();
    assert_eq!(of_instance(&mut tester, 3, 19), 15_794u16.to_be_bytes());
    // The others stay logarithmic, and so do the cyclic data.
    assert_eq!(of_instance(&mut tester, 2, 19), 10_606u16.to_be_bytes());
}

#[test]
fn integers_saturate_and_small_pressures_are_zero() {
    for (user, mbar, value) in [
        (PASCAL, 327.0, 32_700),
        (PASCAL, 327.67, 32_767),
        (PASCAL, 1000.0, 32_767),
        (PASCAL, 0.0099, 0),
        (MBAR, 0.999, 0),
        (MBAR, 1.5, 1),
        (TORR, 1000.0, 750),
        // The lowest count is 2^-20 mbar.
        (COUNTS, 9e-7, 0),
        (COUNTS, 0.0, 0),
    ] {
        let mut tester = tester(psg());
        tester.pressure_mbar(mbar);
        tester.bring_up(&hex(user), &hex("42 82 05 03"));
        let found = tester.exchange(&[]);
        assert_eq!(found[1..], u16::to_be_bytes(value), "{mbar} mbar with {user}");
    }
}

/// (66), (67): the diaphragm at and above 10 mbar, the Pirani below, a small hysteresis; the atmosphere sensor never.
#[test]
fn the_active_instance_follows_the_diaphragm() {
    let mut tester = exchanging(pcg(), FLOATS, 1000.0);
    for (mbar, active) in
        [(50.0, 1), (10.0, 1), (9.5, 1), (9.0, 1), (8.9, 2), (9.5, 2), (9.99, 2), (10.0, 1), (1e-4, 2)]
    {
        tester.pressure_mbar(mbar);
        assert_eq!(tester.exchange(&[])[2], active, "{mbar} mbar");
        assert_eq!((tester.get(1, 47), tester.report().active_instance), (vec![active], active), "{mbar} mbar");
    }
    let mut tester = exchanging(psg(), FLOATS, 1000.0);
    for mbar in [1e-4, 9.5, 10.0, 1000.0] {
        tester.pressure_mbar(mbar);
        assert_eq!(tester.exchange(&[])[2], 1, "{mbar} mbar");
    }
}

/// The cyclic value is that of the active instance, with any selected instance (69).
#[test]
fn the_selector_has_no_effect_on_the_cyclic_data() {
    let mut tester = exchanging(pcg(), FLOATS, 100.0);
    tester.device().sense(1, 9_000.0);
    for instance in [1, 2, 3] {
        tester.put(1, 46, &[instance]).unwrap();
        assert_eq!(tester.exchange(&[])[2..], [&[1][..], &100f32.to_be_bytes()].concat());
    }
    assert_eq!(float(&mut tester, 2, 19), 90.0);
}

/// (32): values that are pressures keep their pressure.
#[test]
fn a_change_of_unit_changes_no_pressure() {
    let mut tester = tester(pcg());
    let values =
        [("13 08", 250.0), ("13 01", 187.515_42), ("13 09", 25_000.0), ("10 01", 29_558.494), ("13 08", 250.0)];
    for (slot, index) in [(1, 40), (2, 17), (2, 19), (3, 17), (3, 19)] {
        tester.put(slot, index, &250f32.to_be_bytes()).unwrap();
        for (unit, value) in values {
            tester.put(1, 22, &hex(unit)).unwrap();
            let found = crate::pxg55x::float_of(&tester.get(slot, index));
            assert!((found / value - 1.0).abs() < 1e-6, "{slot}/{index} in {unit}: {found} instead of {value}");
        }
    }
}
