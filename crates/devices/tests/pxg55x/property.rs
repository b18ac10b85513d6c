//! Random actions of masters, operators and the power supply: the gauge is in a named state, its copies are equal, and
//! no stored value is lost.

use crate::pxg55x::exceptions::copies_are_equal;
use crate::pxg55x::{Gauge, TTR, hex, of_instance, pcg, pcg_without_atm, psg, tester};
use crate::support::Tester;
use crate::support::walk::{Particular, Walk};
use profivac_devices::pxg55x::Pxg55xModel;
use profivac_devices::{Action, Switch};

fn walk(kind: Pxg55xModel, seed: u64) -> Walk<Gauge> {
    let particular = Particular {
        model: &kind.variant().model,
        commands: &[1, 2, 3, 3, 4, 4, 4, 4, 4, 5, 6, 128, 129],
        // (49)
        fits: |prm, configuration| (prm.octets == hex(TTR)) == (configuration.octets == [0xA1, 0x91]),
        action: |random| match random.below(2) {
            0 => Action::Button(random.one_of(&[1, 2])),
            _ => Action::Switch(Switch::Address(random.one_of(&[5, 126, 255]))),
        },
        // The atmosphere moves a trip point (11.1.2), and in COUNTS a hysteresis is a distance from it.
        moving: &[(2, 17), (2, 19), (2, 31), (2, 32), (3, 17), (3, 19), (3, 31), (3, 32)],
        check,
    };
    Walk::new(tester(kind), particular, seed)
}

fn check(tester: &mut Tester<Gauge>) {
    copies_are_equal(tester);
    let report = tester.report();
    let alarm = report.exception_status & 0x07 != 0;
    let led = if alarm {
        "red"
    } else if tester.is_exchanging() {
        "green"
    } else {
        "green flashing"
    };
    assert_eq!(report.led.name(), led);
    for (slot, relay) in [2, 3].into_iter().zip(report.relays.iter()) {
        let trip = tester.get(slot, 21)[0];
        assert_eq!((tester.get(slot + 2, 19)[0], *relay), (trip, trip == 1));
        // None enabled, none tripped (98).
        assert!(trip == 0 || tester.get(slot, 18) == [1] || tester.get(slot, 20) == [1]);
        assert_eq!((tester.get(slot, 28), tester.get(slot, 29)), (tester.get(1, 22), tester.get(1, 21)));
    }
    for indicated in report.indicated.iter() {
        assert_eq!(of_instance(tester, indicated.instance, 23), [u8::from(indicated.valid)]);
    }
    let [hours, quarters] =
        [36, 212].map(|index| tester.get(0, index).iter().fold(0u32, |sum, it| sum << 8 | u32::from(*it)));
    assert_eq!(hours, (quarters / 4).min(65_535));
    assert!((report.run_hours - f64::from(quarters) / 4.0) < 0.25);
}

fn a_million_steps(kind: Pxg55xModel, seed: u64, active: &[u8]) {
    let mut walk = walk(kind, seed);
    walk.steps(1_000_000);
    let seen = &walk.seen;
    assert_eq!(seen.states.len(), 7, "{:?}", seen.states);
    assert!(seen.active.iter().eq(active), "{:?}", seen.active);
    assert!(seen.relays == [true; 2] && seen.units > 100, "{} units", seen.units);
}

#[test]
fn a_million_steps_of_a_pcg550_with_atmosphere_sensor_leave_a_named_state_and_equal_copies() {
    a_million_steps(pcg(), 5501, &[1, 2]);
}

#[test]
fn a_million_steps_of_a_pcg550_leave_a_named_state_and_equal_copies() {
    a_million_steps(pcg_without_atm(), 5502, &[1, 2]);
}

#[test]
fn a_million_steps_of_a_psg550_leave_a_named_state_and_equal_copies() {
    a_million_steps(psg(), 5503, &[1]);
}

#[test]
fn any_octets_as_parameters_or_outputs_leave_the_device_working() {
    for kind in Pxg55xModel::all() {
        walk(kind, 55).any_octets(10_000);
    }
}
