//! Delays, users, changed files, restarts.

use super::{Fixture, above, rule, series};
use crate::support::inputs::inputs;
use profivac_recorder::Quality;
use profivac_station::alarm::{
    AlarmChangeKind, AlarmError, AlarmState, AlarmStatus, Condition, Inputs, Priority, Rule,
};
use std::time::Duration;

#[test]
fn an_alarm_is_raised_acknowledged_and_returns() {
    let mut fixture = Fixture::new(vec![above(0, 0)]);
    assert_eq!(fixture.evaluate_for(&inputs(0.9, Quality::Valid), 250), []);
    assert_eq!(fixture.evaluate_for(&inputs(1.1, Quality::Valid), 250), [AlarmChangeKind::Raised]);
    assert_eq!((fixture.state(), fixture.status().value), (AlarmState::Unacknowledged, Some(1.1)));
    assert_eq!(fixture.status().text, "chamber shows 1.10e-2 mbar, above the limit of 1.00e-2 mbar");
    let change = fixture.acknowledge().unwrap();
    assert_eq!(
        (change.user.as_deref(), change.value, fixture.state()),
        (Some("Ada"), Some(1.1), AlarmState::Acknowledged)
    );
    assert_eq!(fixture.evaluate_for(&inputs(0.4, Quality::Valid), 250), [AlarmChangeKind::Returned]);
    assert_eq!(fixture.state(), AlarmState::Normal);
    fixture.evaluate_for(&inputs(2.0, Quality::Valid), 250);
    assert_eq!(fixture.evaluate_for(&inputs(0.1, Quality::Valid), 250), [AlarmChangeKind::Returned]);
    assert_eq!(fixture.state(), AlarmState::Returned, "it is not acknowledged");
    fixture.acknowledge().unwrap();
    assert_eq!(fixture.state(), AlarmState::Normal);
}

#[test]
fn a_shelved_alarm_is_silent_until_its_end_and_then_raised_at_once() {
    let mut fixture = Fixture::new(vec![above(0, 0)]);
    let high = inputs(2.0, Quality::Valid);
    fixture.evaluate_for(&high, 250);
    let now = fixture.now();
    let shelved = fixture.registry.shelve("it", "Ada", "the lock is vented", Duration::from_secs(60), now).unwrap();
    assert_eq!((shelved.kind, shelved.user.as_deref()), (AlarmChangeKind::Shelved, Some("Ada")));
    assert_eq!(shelved.text, "the lock is vented (it was not acknowledged)");
    let again = fixture.registry.shelve("it", "Eve", "so", Duration::from_secs(60), now).unwrap_err();
    assert_eq!(again.to_string(), "it is shelved by Ada already");
    assert_eq!(fixture.acknowledge().unwrap_err().to_string(), "it is shelved by Ada already");
    assert_eq!(fixture.evaluate_for(&high, 59_999), []);
    assert_eq!(fixture.evaluate_for(&high, 1), []);
    assert_eq!(fixture.evaluate(&high), [AlarmChangeKind::Unshelved, AlarmChangeKind::Raised]);
    assert_eq!((fixture.state(), fixture.status().suppression.as_ref()), (AlarmState::Unacknowledged, None));
}

#[test]
fn an_engineer_takes_a_shelved_alarm_out_of_service_and_no_user_shelves_it_then() {
    let mut fixture = Fixture::new(vec![above(0, 0)]);
    let now = fixture.now();
    fixture.registry.shelve("it", "Ada", "so", Duration::from_secs(60), now).unwrap();
    fixture.registry.take_out_of_service("it", "Eve", "repair", None, now).unwrap();
    fixture.pass(120_000);
    assert_eq!(fixture.evaluate(&inputs(2.0, Quality::Valid)), [], "the end of the time on the shelf is forgotten");
    let now = fixture.now();
    assert!(fixture.registry.shelve("it", "Ada", "so", Duration::from_secs(60), now).is_err());
    assert!(fixture.registry.unshelve("it", "Ada", now).is_err());
    fixture.registry.return_to_service("it", "Eve", now).unwrap();
    assert_eq!(fixture.evaluate(&inputs(2.0, Quality::Valid)), [AlarmChangeKind::Raised]);
}

#[test]
fn a_shelved_alarm_stays_shelved_over_a_restart_and_ends_on_time() {
    let mut fixture = Fixture::new(vec![above(0, 0)]);
    let now = fixture.now();
    fixture.registry.shelve("it", "Ada", "so", Duration::from_secs(3600), now).unwrap();
    let stored = fixture.status().clone();
    let mut restarted = Fixture::new(Vec::new());
    restarted.pass(1_800_000);
    let now = restarted.now();
    restarted.registry.reconfigure(vec![above(0, 0)], vec![("it".to_owned(), stored)], now);
    assert_eq!(restarted.evaluate_for(&inputs(2.0, Quality::Valid), 1_800_000), []);
    assert_eq!(restarted.evaluate(&inputs(2.0, Quality::Valid)), [AlarmChangeKind::Unshelved, AlarmChangeKind::Raised]);
}

#[test]
fn a_clock_set_back_before_a_start_does_not_prolong_a_time_out_of_service() {
    let mut fixture = Fixture::new(vec![above(0, 0)]);
    let now = fixture.now();
    let hour = Some(Duration::from_secs(3600));
    fixture.registry.take_out_of_service("it", "Eve", "service", hour, now).unwrap();
    for days in [-3 * 365, 3 * 365] {
        let mut restarted = Fixture::new(Vec::new());
        restarted.wall_ms = fixture.wall_ms + days * 86_400_000;
        let (stored, now) = (fixture.status().clone(), restarted.now());
        restarted.registry.reconfigure(vec![above(0, 0)], vec![("it".to_owned(), stored)], now);
        restarted.pass(3_600_000);
        let expected = [AlarmChangeKind::ReturnedToService, AlarmChangeKind::Raised];
        assert_eq!(restarted.evaluate(&inputs(2.0, Quality::Valid)), expected, "{days}");
    }
}

#[test]
fn delays_are_exact_to_the_millisecond() {
    let mut fixture = Fixture::new(vec![above(2, 3)]);
    fixture.evaluate_for(&inputs(2.0, Quality::Valid), 1999);
    assert_eq!(fixture.evaluate_for(&inputs(2.0, Quality::Valid), 1), []);
    assert_eq!(fixture.evaluate(&inputs(2.0, Quality::Valid)), [AlarmChangeKind::Raised]);
    fixture.evaluate_for(&inputs(0.1, Quality::Valid), 2999);
    assert_eq!(fixture.evaluate_for(&inputs(0.1, Quality::Valid), 1), []);
    assert_eq!(fixture.evaluate(&inputs(0.1, Quality::Valid)), [AlarmChangeKind::Returned]);
}

#[test]
fn a_chattering_signal_raises_one_alarm() {
    let mut fixture = Fixture::new(vec![above(1, 5)]);
    let mut seen = Vec::new();
    for step in 0..4000 {
        // Nine of ten evaluations are above; the tenth is far below, for a quarter of a second.
        let pa = if step % 10 == 0 { 0.1 } else { 3.0 };
        seen.extend(fixture.evaluate_for(&inputs(pa, Quality::Valid), 250));
    }
    assert_eq!(seen, [AlarmChangeKind::Raised]);
    let mut fixture = Fixture::new(vec![above(1, 5)]);
    let spikes: Vec<_> = (0..4000)
        .flat_map(|step| {
            let pa = if step % 10 == 0 { 3.0 } else { 0.1 };
            fixture.evaluate_for(&inputs(pa, Quality::Valid), 250)
        })
        .collect();
    assert_eq!(spikes, [], "spikes shorter than the delay raise nothing");
}

#[test]
fn a_step_of_the_wall_clock_changes_no_delay() {
    let mut fixture = Fixture::new(vec![above(10, 10)]);
    fixture.evaluate(&inputs(2.0, Quality::Valid));
    fixture.wall_ms += 3_600_000;
    assert_eq!(
        fixture.evaluate_for(&inputs(2.0, Quality::Valid), 10_000),
        [],
        "an hour of wall-clock time is no delay"
    );
    fixture.wall_ms -= 7_200_000;
    assert_eq!(fixture.evaluate(&inputs(2.0, Quality::Valid)), [AlarmChangeKind::Raised]);
    let first = fixture.status().occurrence;
    fixture.wall_ms -= 7_200_000;
    fixture.evaluate_for(&inputs(0.1, Quality::Valid), 10_000);
    fixture.evaluate_for(&inputs(0.1, Quality::Valid), 0);
    fixture.evaluate_for(&inputs(2.0, Quality::Valid), 10_000);
    assert_eq!(fixture.evaluate(&inputs(2.0, Quality::Valid)), [AlarmChangeKind::Raised]);
    assert_eq!(
        fixture.status().occurrence,
        first + 1,
        "an occurrence is never used twice, even if the clock shows an earlier time"
    );
}

#[test]
fn an_acknowledgement_of_an_earlier_occurrence_is_refused() {
    let mut fixture = Fixture::new(vec![above(0, 0)]);
    fixture.evaluate_for(&inputs(2.0, Quality::Valid), 1000);
    let seen = fixture.status().occurrence;
    fixture.evaluate_for(&inputs(0.1, Quality::Valid), 1000);
    fixture.evaluate_for(&inputs(2.0, Quality::Valid), 1000);
    let now = fixture.now();
    let refused = fixture.registry.acknowledge("it", seen, "Ada", now).unwrap_err();
    assert_eq!(refused, AlarmError::OccurrenceChanged { name: "it".to_owned(), occurrence: seen + 2000, got: seen });
    assert_eq!(fixture.state(), AlarmState::Unacknowledged);
    fixture.acknowledge().unwrap();
    assert_eq!(fixture.acknowledge().unwrap_err().to_string(), "it is acknowledged by Ada already");
    assert_eq!(
        fixture.registry.acknowledge("other", 1, "Ada", now).unwrap_err().to_string(),
        "there is no alarm \"other\""
    );
}

#[test]
fn an_alarm_out_of_service_raises_nothing_and_returns_to_service() {
    let mut fixture = Fixture::new(vec![above(0, 0)]);
    let now = fixture.now();
    let hour = Some(Duration::from_secs(3600));
    fixture.registry.take_out_of_service("it", "Eve", "the gauge is being calibrated", hour, now).unwrap();
    assert_eq!(fixture.evaluate_for(&inputs(2.0, Quality::Valid), 3_599_999), []);
    let refused = fixture.registry.take_out_of_service("it", "Ada", "again", None, now).unwrap_err().to_string();
    assert_eq!(refused, "it is out of service by Eve already");
    // A step of the wall clock does not change the time out of service.
    fixture.wall_ms += 86_400_000;
    assert_eq!(fixture.evaluate_for(&inputs(2.0, Quality::Valid), 1), []);
    assert_eq!(
        fixture.evaluate(&inputs(2.0, Quality::Valid)),
        [AlarmChangeKind::ReturnedToService, AlarmChangeKind::Raised],
        "the condition is met, so it is raised"
    );
    let now = fixture.now();
    fixture.registry.take_out_of_service("it", "Eve", "for ever", None, now).unwrap();
    fixture.pass(100 * 86_400_000);
    assert_eq!(fixture.evaluate(&inputs(2.0, Quality::Valid)), []);
    let now = fixture.now();
    fixture.registry.return_to_service("it", "Eve", now).unwrap();
    assert_eq!(fixture.registry.return_to_service("it", "Eve", now).unwrap_err().to_string(), "it is normal");
    assert_eq!(fixture.evaluate(&inputs(0.1, Quality::Valid)), [], "the condition is no longer met");
}

#[test]
fn alarms_keep_their_state_when_the_file_changes() {
    let mut fixture = Fixture::new(vec![above(0, 0)]);
    fixture.evaluate(&inputs(2.0, Quality::Valid));
    fixture.acknowledge().unwrap();
    let (before, now) = (fixture.status().clone(), fixture.now());
    let low = Rule { priority: Priority::Low, message: Some("call Eve".to_owned()), ..above(3, 3) };
    assert_eq!(fixture.registry.reconfigure(vec![low], Vec::new(), now), []);
    assert_eq!((fixture.status(), fixture.registry.alarms()[0].rule().priority), (&before, Priority::Low));
    // With another limit the alarm returns if its condition is no longer met.
    let higher = rule(Condition::Above { series: series(), limit: 10.0, reset: 5.0 }, 0, 0);
    fixture.registry.reconfigure(vec![higher], Vec::new(), now);
    assert_eq!(fixture.state(), AlarmState::Acknowledged);
    assert_eq!(fixture.evaluate(&inputs(2.0, Quality::Valid)), [AlarmChangeKind::Returned]);
    assert_eq!(
        fixture.registry.clone().reconfigure(Vec::new(), Vec::new(), now),
        [],
        "a normal alarm is removed without a change"
    );
    fixture.evaluate(&inputs(20.0, Quality::Valid));
    let gone = fixture.registry.reconfigure(Vec::new(), Vec::new(), now);
    assert_eq!(gone.iter().map(|change| change.kind).collect::<Vec<_>>(), [AlarmChangeKind::Removed]);
}

#[test]
fn alarms_keep_their_state_over_a_restart() {
    // A suppressed alarm has the state that its plant states give it.
    for state in AlarmState::ALL.into_iter().filter(|state| *state != AlarmState::Suppressed) {
        let status = AlarmStatus { state, occurrence: 7, text: "it was so".to_owned(), ..AlarmStatus::default() };
        let mut fixture = Fixture::new(Vec::new());
        let now = fixture.now();
        fixture.registry.reconfigure(vec![above(1, 1)], vec![("it".to_owned(), status.clone())], now);
        assert_eq!(fixture.status(), &status);
        assert_eq!(fixture.evaluate_for(&Inputs::default(), 5000), [], "no input is known yet");
        let seen =
            [fixture.evaluate_for(&inputs(2.0, Quality::Valid), 1000), fixture.evaluate(&inputs(2.0, Quality::Valid))]
                .concat();
        let raised = matches!(state, AlarmState::Normal | AlarmState::Returned);
        assert_eq!(
            seen,
            [AlarmChangeKind::Raised][..usize::from(raised)],
            "{state:?}: an active alarm is not raised again"
        );
    }
}
