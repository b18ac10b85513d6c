//! Random readings, acknowledgements, times out of service, plant states, clock steps and changed files.

use super::plant_states::state;
use super::{Fixture, above};
use crate::support::inputs::inputs;
use profivac_recorder::Quality;
use profivac_station::alarm::{AlarmChangeKind, AlarmState, Priority, Rule};
use std::time::Duration;

/// Random readings, acknowledgements, times out of service, plant states, clock steps and changed files.
#[test]
fn no_raised_alarm_is_lost_in_random_sequences() {
    let mut random = fastrand::Rng::with_seed(11);
    let mut raised = 0;
    for _ in 0..300 {
        raised += random_walk(&mut random);
    }
    assert!(raised > 3000, "{raised} alarms were raised");
}

fn random_walk(random: &mut fastrand::Rng) -> usize {
    let (delay, off_delay) = (random.u64(0..4), random.u64(0..4));
    let mut fixture = Fixture::new(vec![above(delay, off_delay)]);
    let now = fixture.now();
    fixture.registry.plant_states_mut().reconfigure(vec![state("Vented", &["it"])], Vec::new(), now);
    // Since when the condition is known to be met without interruption.
    let mut holds: Option<i64> = None;
    let (mut raised, mut acknowledged) = (0, 0);
    for _ in 0..400 {
        let pa = if random.bool() { 2.0 } else { 0.1 };
        for _ in 0..random.usize(1..12) {
            let quality = [Quality::Valid, Quality::Valid, Quality::Valid, Quality::Fault][random.usize(0..4)];
            let now = fixture.now();
            fixture.registry.plant_states_mut().end_due(now);
            let before = fixture.state();
            let changes = fixture.registry.evaluate(&inputs(pa, quality), now);
            if quality == Quality::Valid {
                holds = (pa > 1.0).then(|| holds.unwrap_or(fixture.monotonic_ms));
            }
            for change in &changes {
                raised += usize::from(change.kind == AlarmChangeKind::Raised);
                assert!(change.kind != AlarmChangeKind::Returned || before.is_active(), "only an active alarm returns");
            }
            assert!(
                !before.needs_acknowledgement() || fixture.state().needs_acknowledgement(),
                "an evaluation never removes an unacknowledged alarm"
            );
            let long = holds.is_some_and(|since| fixture.monotonic_ms - since >= delay as i64 * 1000);
            let is_suppressed =
                matches!(fixture.state(), AlarmState::Shelved | AlarmState::OutOfService | AlarmState::Suppressed);
            let is_raised = fixture.state().is_active() || is_suppressed;
            assert!(
                !(long && quality == Quality::Valid) || is_raised,
                "the condition is met for longer than the delay and the state is {:?}",
                fixture.state()
            );
            fixture.pass(250);
        }
        acknowledged += usize::from(random_action(random, &mut fixture));
    }
    let open = usize::from(fixture.state().needs_acknowledgement());
    assert!(acknowledged + open <= raised, "each occurrence is acknowledged at most once");
    raised
}

/// A random action. Returns whether an alarm was acknowledged.
fn random_action(random: &mut fastrand::Rng, fixture: &mut Fixture) -> bool {
    let now = fixture.now();
    match random.usize(0..12) {
        0 | 1 => return fixture.acknowledge().is_ok(),
        2 if random.usize(0..8) == 0 => {
            fixture
                .registry
                .take_out_of_service("it", "Eve", "so", Some(Duration::from_secs(random.u64(1..20))), now)
                .ok();
        }
        3 => {
            fixture.registry.return_to_service("it", "Eve", now).ok();
        }
        8 if random.usize(0..8) == 0 => {
            let time = Duration::from_secs(random.u64(1..20));
            fixture.registry.shelve("it", "Ada", "so", time, now).ok();
        }
        9 => {
            fixture.registry.unshelve("it", "Ada", now).ok();
        }
        10 if random.usize(0..8) == 0 => {
            let time = Duration::from_secs(60 + random.u64(0..20));
            fixture.registry.plant_states_mut().declare("Vented", "Ada", "so", time, now).ok();
            fixture.registry.suppress(now);
        }
        11 => {
            fixture.registry.plant_states_mut().end("Vented", "Ada", "", now).ok();
            fixture.registry.suppress(now);
        }
        4 => fixture.wall_ms += random.i64(-10_000_000..10_000_000),
        5 => {
            let rule = fixture.registry.alarms()[0].rule().clone();
            fixture.registry.reconfigure(vec![Rule { priority: Priority::Low, ..rule }], Vec::new(), now);
        }
        _ => {}
    }
    false
}
