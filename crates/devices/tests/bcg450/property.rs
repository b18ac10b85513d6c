//! Random actions of masters, operators and the power supply: the gauge is in a named state, its copies are equal, and
//! no stored value is lost.

use crate::bcg450::exceptions::copies_are_equal;
use crate::bcg450::{Gauge, of_instance, tester};
use crate::support::Tester;
use crate::support::walk::{Particular, Walk};
use profivac_devices::bcg450::table;
use profivac_devices::{Action, Potentiometer, Switch};

fn walk(seed: u64) -> Walk<Gauge> {
    let particular = Particular {
        model: &table::MODEL,
        commands: &[1, 2, 3, 3, 4, 4, 4, 5, 6],
        fits: |_, _| true,
        action: |random| match random.below(2) {
            0 => Action::Potentiometer {
                potentiometer: random.one_of(&[Potentiometer::A, Potentiometer::B]),
                volts: random.unit() * 12.0 - 1.0,
            },
            _ => Action::Switch(Switch::Degas(random.one_of(&[true, false]))),
        },
        moving: &[],
        check,
    };
    Walk::new(tester(), particular, seed)
}

fn check(tester: &mut Tester<Gauge>) {
    copies_are_equal(tester);
    for (relay, instance) in tester.report().relays.iter().zip([5, 6]) {
        assert_eq!(of_instance(tester, instance, 20), [if *relay { 0x0A } else { 0 }]);
    }
}

#[test]
fn a_million_steps_leave_a_named_state_and_equal_copies() {
    let mut walk = walk(450);
    walk.steps(1_000_000);
    let seen = &walk.seen;
    assert_eq!(seen.states.len(), 7, "{:?}", seen.states);
    assert_eq!(seen.active.len(), 3, "{:?}", seen.active);
    assert!(seen.degas && seen.relays == [true; 2] && seen.units > 100, "{} units", seen.units);
}

#[test]
fn any_octets_as_parameters_or_outputs_leave_the_device_working() {
    walk(54).any_octets(50_000);
}
