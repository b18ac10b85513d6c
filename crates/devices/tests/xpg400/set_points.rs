//! Set points and relays. tira36e1 3.2.4, (106) to (109).

use crate::support::{Tester, hex};
use crate::xpg400::{FLOATS, Gauge, KINDS, exchanging, float, of_instance};
use profivac_devices::xpg400::Xpg400Model;
use profivac_devices::{Action, Potentiometer, SimulatedDevice};

pub fn turn(tester: &mut Tester<Gauge>, potentiometer: Potentiometer, volts: f64) {
    tester.device().operate(Action::Potentiometer { potentiometer, volts }).unwrap();
}

/// The voltage of a threshold in mbar: 3.2.4.1, solved for U (109).
fn volts(kind: Xpg400Model, mbar: f64) -> f64 {
    match kind {
        Xpg400Model::Bpg => (mbar.log10() + 9.301_029_99) / 1.23011,
        Xpg400Model::Hpg => (mbar.log10() + 6.0) / 0.9,
    }
}

fn relays(tester: &mut Tester<Gauge>) -> Vec<bool> {
    tester.report().relays.iter().copied().collect()
}

/// U and the threshold in mbar and COUNTS, computed from the printed formulas.
const THRESHOLDS: [(Xpg400Model, f64, f64, f64); 6] = [
    (Xpg400Model::Bpg, 0.0, 5.0e-10, 6397.94),
    (Xpg400Model::Bpg, 5.0, 7.0715e-4, 18699.04),
    (Xpg400Model::Bpg, 10.0, 1000.16, 31000.14),
    (Xpg400Model::Hpg, 0.0, 1e-6, 8335.0),
    (Xpg400Model::Hpg, 5.0, 3.16228e-2, 19333.0),
    (Xpg400Model::Hpg, 10.0, 1000.0, 30331.0),
];

/// (71): and in its data type.
#[test]
fn the_threshold_is_read_in_the_unit_of_the_device() {
    for (kind, u, mbar, counts) in THRESHOLDS {
        let mut tester = exchanging(kind, FLOATS, 1e-3);
        turn(&mut tester, Potentiometer::B, u);
        let read = f64::from(float(&mut tester, 4, 19));
        assert!((read / mbar - 1.0).abs() < 1e-4, "{kind:?}: {u} V reads {read} mbar");
        tester.bring_up(&hex("00 00 00 03 E9"), &hex("44 84 05 05 05 03"));
        assert_eq!(of_instance(&mut tester, 4, 19), (counts as u16).to_be_bytes(), "{kind:?}: {u} V");
    }
}

#[test]
fn a_potentiometer_has_no_more_than_10_volts() {
    for kind in KINDS {
        let mut tester = exchanging(kind, FLOATS, 1e-3);
        turn(&mut tester, Potentiometer::A, 77.0);
        assert_eq!(float(&mut tester, 3, 19).round(), 1000.0);
    }
}

/// 3.2.4.1, 3.2.4.2, (106), (108)
#[test]
fn a_relay_closes_below_its_threshold_and_opens_ten_percent_above() {
    for kind in KINDS {
        let mut tester = exchanging(kind, FLOATS, 1000.0);
        turn(&mut tester, Potentiometer::A, volts(kind, 2.0));
        turn(&mut tester, Potentiometer::B, volts(kind, 1e-4));
        for (mbar, a, b) in [
            (1000.0, false, false),
            (2.002, false, false),
            (1.998, true, false),
            (2.19, true, false),
            (2.21, false, false),
            (9.9e-5, true, true),
            (1.09e-4, true, true),
            (1.11e-4, true, false),
        ] {
            tester.pressure_mbar(mbar);
            assert_eq!(relays(&mut tester), [a, b], "{kind:?} {mbar} mbar");
            let status = [a, b].map(|closed| if closed { 0x0A } else { 0 });
            assert_eq!(
                [3, 4].map(|instance| of_instance(&mut tester, instance, 20)[0]),
                status,
                "{kind:?} {mbar} mbar"
            );
        }
    }
}

/// 3.2.4.1: "If a higher threshold has been selected, the relay is only activated at pressures lower than 100 mbar."
/// (107)
#[test]
fn a_relay_stays_open_above_100_mbar() {
    for kind in KINDS {
        let mut tester = exchanging(kind, FLOATS, 1000.0);
        turn(&mut tester, Potentiometer::A, volts(kind, 500.0));
        for (mbar, closed) in [(400.0, false), (100.0, false), (99.0, true), (109.0, true), (111.0, false)] {
            tester.pressure_mbar(mbar);
            assert_eq!(relays(&mut tester), [closed, false], "{kind:?} {mbar} mbar");
        }
        assert!((float(&mut tester, 3, 19) / 500.0 - 1.0).abs() < 1e-4, "the setting is shown as it is");
    }
}

#[test]
fn a_relay_opens_outside_executing_and_with_any_sensor_alarm() {
    for kind in KINDS {
        let mut tester = exchanging(kind, FLOATS, 1e-3);
        turn(&mut tester, Potentiometer::A, volts(kind, 1.0));
        for fault in ["sensor1", "sensor2", "electronics2"] {
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
}
