//! Random actions of masters, operators and the power supply: the gauge is in a named state, its copies are equal, and
//! no stored value is lost.

use crate::support::Tester;
use crate::support::random::Random;
use crate::support::walk::{Particular, Walk};
use crate::xpg400::exceptions::copies_are_equal;
use crate::xpg400::{Gauge, KINDS, of_instance, tester};
use profivac_devices::xpg400::Xpg400Model;
use profivac_devices::{Action, Potentiometer, Switch};

fn potentiometer(random: &mut Random) -> Action {
    Action::Potentiometer {
        potentiometer: random.one_of(&[Potentiometer::A, Potentiometer::B]),
        volts: random.unit() * 12.0 - 1.0,
    }
}

fn bpg_action(random: &mut Random) -> Action {
    match random.below(2) {
        0 => potentiometer(random),
        _ => Action::Switch(Switch::Degas(random.one_of(&[true, false]))),
    }
}

fn hpg_action(random: &mut Random) -> Action {
    match random.below(2) {
        0 => potentiometer(random),
        _ => {
            let switch = random.one_of(&[Switch::LowHigh as fn(u8) -> Switch, Switch::CalAdj]);
            Action::Switch(switch(random.one_of(&[0, 2, 5, 7, 8, 9])))
        }
    }
}

fn walk(kind: Xpg400Model, seed: u64) -> Walk<Gauge> {
    let particular = Particular {
        model: &kind.variant().model,
        commands: &[1, 2, 3, 3, 4, 4, 4, 5, 6],
        fits: |_, _| true,
        action: match kind {
            Xpg400Model::Bpg => bpg_action,
            Xpg400Model::Hpg => hpg_action,
        },
        moving: &[],
        check,
    };
    Walk::new(tester(kind), particular, seed)
}

fn check(tester: &mut Tester<Gauge>) {
    copies_are_equal(tester);
    let report = tester.report();
    for (relay, instance) in report.relays.iter().zip([3, 4]) {
        assert_eq!(of_instance(tester, instance, 20), [if *relay { 0x0A } else { 0 }]);
    }
    for indicated in report.indicated.iter() {
        assert_eq!(of_instance(tester, indicated.instance, 23), [u8::from(indicated.valid)]);
    }
    let emission = report.emission.iter().eq([&true]);
    assert_eq!(of_instance(tester, 2, 105)[0] != 0, emission);
    // Without emission only the Pirani measures (80); outside EXECUTING no part measures.
    let executing = report.device_state.name() == "EXECUTING";
    assert!(emission || report.active_instance == 1 || !executing, "{report:?}");
    // An adjustment runs in EXECUTING only (103).
    assert!(of_instance(tester, 1, 140) == [0] || executing, "{report:?}");
}

fn a_million_steps(kind: Xpg400Model, seed: u64) {
    let mut walk = walk(kind, seed);
    walk.steps(1_000_000);
    let seen = &walk.seen;
    assert_eq!(seen.states.len(), 7, "{:?}", seen.states);
    assert_eq!(seen.active.len(), 2, "{:?}", seen.active);
    assert_eq!(seen.degas, kind == Xpg400Model::Bpg);
    assert!(seen.relays == [true; 2] && seen.units > 100, "{} units", seen.units);
}

#[test]
fn a_million_steps_of_a_bpg400_leave_a_named_state_and_equal_copies() {
    a_million_steps(Xpg400Model::Bpg, 4001);
}

#[test]
fn a_million_steps_of_an_hpg400_leave_a_named_state_and_equal_copies() {
    a_million_steps(Xpg400Model::Hpg, 4002);
}

#[test]
fn any_octets_as_parameters_or_outputs_leave_the_device_working() {
    for kind in KINDS {
        walk(kind, 54).any_octets(50_000);
    }
}
