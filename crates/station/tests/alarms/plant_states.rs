//! Plant states: which alarms a declaration suppresses, and what happens at its end.

use super::{Fixture, above};
use crate::support::inputs::inputs;
use profivac_recorder::{Micros, Quality};
use profivac_station::alarm::notify::Notifier;
use profivac_station::alarm::plant_state::PlantStateChangeKind;
use profivac_station::alarm::{
    AlarmChangeKind, AlarmState, AlarmStatus, Attribution, Declaration, NotificationTarget, PlantStateRule, Priority,
};
use profivac_web_server::auth::Role;
use std::collections::BTreeSet;
use std::time::Duration;

const HOUR: Duration = Duration::from_secs(3600);

/// A plant state that suppresses these alarms, for a day at most.
pub fn state(name: &str, alarms: &[&str]) -> PlantStateRule {
    PlantStateRule {
        name: name.to_owned(),
        description: None,
        longest: 24 * HOUR,
        role: Role::Operator,
        alarms: alarms.iter().map(|alarm| (*alarm).to_owned()).collect::<BTreeSet<_>>(),
    }
}

/// One alarm, and the plant states Vented, which suppresses it, and Bake-out, which does too, and Empty, which does not.
fn fixture() -> Fixture {
    let mut fixture = Fixture::new(vec![above(0, 0)]);
    let states = vec![state("Vented", &["it"]), state("Bake-out", &["it"]), state("Empty", &["another"])];
    let now = fixture.now();
    assert_eq!(fixture.registry.plant_states_mut().reconfigure(states, Vec::new(), now), []);
    fixture
}

impl Fixture {
    fn declare(&mut self, name: &str, time: Duration) -> Result<PlantStateChangeKind, String> {
        let now = self.now();
        let change = self.registry.plant_states_mut().declare(name, "Ada", "leak search", time, now);
        change.map(|change| change.kind).map_err(|error| error.to_string())
    }

    fn extend(&mut self, name: &str, time: Duration) -> Result<PlantStateChangeKind, String> {
        let now = self.now();
        let change = self.registry.plant_states_mut().extend(name, "Eve", "still open", time, now);
        change.map(|change| change.kind).map_err(|error| error.to_string())
    }

    /// Ends the plant states that are over, then evaluates.
    fn next(&mut self, pa: f64) -> Vec<AlarmChangeKind> {
        let now = self.now();
        self.registry.plant_states_mut().end_due(now);
        self.evaluate(&inputs(pa, Quality::Valid))
    }
}

#[test]
fn an_alarm_is_suppressed_until_the_plant_state_ends_and_is_then_raised_as_a_new_one() {
    let mut fixture = fixture();
    fixture.next(2.0);
    let first = fixture.status().occurrence;
    fixture.acknowledge().unwrap();
    fixture.declare("Vented", HOUR).unwrap();
    assert_eq!(fixture.next(2.0), [AlarmChangeKind::Suppressed]);
    let suppression = fixture.status().suppression.clone().unwrap();
    assert_eq!((fixture.state(), suppression.by.user.as_str()), (AlarmState::Suppressed, "Ada"));
    assert_eq!(suppression.reason, "Vented: leak search");
    assert_eq!(suppression.until, Some(Micros(fixture.now().wall.0 + 3_600_000_000)));
    assert_eq!(fixture.acknowledge().unwrap_err().to_string(), "it is suppressed by Ada already");
    fixture.pass(3_599_999);
    assert_eq!(fixture.next(2.0), []);
    fixture.pass(1);
    assert_eq!(fixture.next(2.0), [AlarmChangeKind::Unsuppressed, AlarmChangeKind::Raised]);
    assert_eq!((fixture.state(), fixture.status().suppression.as_ref()), (AlarmState::Unacknowledged, None));
    assert!(fixture.status().occurrence > first, "a new occurrence, which no user has acknowledged");
}

#[test]
fn an_alarm_whose_condition_has_cleared_meanwhile_is_normal_at_the_end() {
    let mut fixture = fixture();
    fixture.declare("Vented", HOUR).unwrap();
    assert_eq!(fixture.next(2.0), [AlarmChangeKind::Suppressed]);
    assert_eq!(fixture.next(0.1), []);
    let now = fixture.now();
    fixture.registry.plant_states_mut().end("Vented", "Eve", "", now).unwrap();
    assert_eq!(fixture.next(0.1), [AlarmChangeKind::Unsuppressed]);
    assert_eq!(fixture.state(), AlarmState::Normal);
}

#[test]
fn the_condition_is_evaluated_with_its_delay_while_the_alarm_is_suppressed() {
    let mut fixture = Fixture::new(vec![above(60, 0)]);
    let now = fixture.now();
    fixture.registry.plant_states_mut().reconfigure(vec![state("Vented", &["it"])], Vec::new(), now);
    fixture.declare("Vented", HOUR).unwrap();
    assert_eq!(fixture.next(2.0), [AlarmChangeKind::Suppressed]);
    fixture.pass(60_000);
    assert_eq!(fixture.next(2.0), []);
    let now = fixture.now();
    fixture.registry.plant_states_mut().end("Vented", "Ada", "", now).unwrap();
    assert_eq!(
        fixture.next(2.0),
        [AlarmChangeKind::Unsuppressed, AlarmChangeKind::Raised],
        "the delay is not waited for again"
    );
}

#[test]
fn a_pressure_that_is_good_again_raises_no_alarm_at_the_end_of_its_suppression() {
    // The off-delay of a minute has not passed.
    let mut fixture = Fixture::new(vec![above(0, 60)]);
    let now = fixture.now();
    fixture.registry.plant_states_mut().reconfigure(vec![state("Vented", &["it"])], Vec::new(), now);
    fixture.declare("Vented", HOUR).unwrap();
    assert_eq!(fixture.next(2.0), [AlarmChangeKind::Suppressed]);
    let now = fixture.now();
    fixture.registry.plant_states_mut().end("Vented", "Eve", "", now).unwrap();
    assert_eq!(fixture.next(0.1), [AlarmChangeKind::Unsuppressed]);
    fixture.declare("Vented", HOUR).unwrap();
    assert_eq!(fixture.next(2.0), [AlarmChangeKind::Suppressed]);
    let now = fixture.now();
    fixture.registry.plant_states_mut().end("Vented", "Eve", "", now).unwrap();
    // A user who ends a plant state sees its alarms at once, before the next evaluation.
    let kinds: Vec<_> = fixture.registry.suppress(now).into_iter().map(|change| change.kind).collect();
    assert_eq!(kinds, [AlarmChangeKind::Unsuppressed]);
    assert_eq!(fixture.next(0.1), []);
    let now = fixture.now();
    fixture.registry.shelve("it", "Ada", "so", HOUR, now).unwrap();
    fixture.next(2.0);
    fixture.registry.unshelve("it", "Ada", now).unwrap();
    assert_eq!(fixture.next(0.1), []);
    fixture.registry.take_out_of_service("it", "Eve", "repair", Some(HOUR), now).unwrap();
    fixture.next(2.0);
    fixture.pass(3_600_000);
    assert_eq!(fixture.next(0.1), [AlarmChangeKind::ReturnedToService]);
    assert_eq!(fixture.next(2.0), [AlarmChangeKind::Raised]);
}

#[test]
fn an_alarm_of_two_declared_plant_states_is_suppressed_until_the_last_ends() {
    let mut fixture = fixture();
    fixture.declare("Bake-out", 2 * HOUR).unwrap();
    fixture.declare("Vented", HOUR).unwrap();
    fixture.declare("Empty", 24 * HOUR).unwrap();
    assert_eq!(fixture.next(2.0), [AlarmChangeKind::Suppressed]);
    assert_eq!(fixture.status().suppression.as_ref().unwrap().reason, "Bake-out: leak search", "it ends last");
    fixture.pass(3_600_000);
    assert_eq!(fixture.next(2.0), []);
    fixture.pass(3_600_000);
    assert_eq!(fixture.next(2.0), [AlarmChangeKind::Unsuppressed, AlarmChangeKind::Raised]);
}

#[test]
fn an_extension_is_shown_at_once_and_is_no_change_of_the_alarm() {
    let mut fixture = fixture();
    fixture.declare("Vented", HOUR).unwrap();
    fixture.next(2.0);
    fixture.pass(1_800_000);
    let begin = fixture.now().wall.0 - 1_800_000_000;
    let earlier = fixture.extend("Vented", HOUR / 2).unwrap_err();
    assert_eq!(earlier, "Vented is declared until 2026-01-01T01:00:00Z already; choose a later end, or end it");
    assert_eq!(fixture.extend("Vented", HOUR), Ok(PlantStateChangeKind::Extended));
    assert_eq!(fixture.next(2.0), []);
    let suppression = fixture.status().suppression.as_ref().unwrap();
    assert_eq!(suppression.reason, "Vented: still open");
    assert_eq!(suppression.by, Attribution { user: "Ada".to_owned(), at: Micros(begin) }, "who declared it stays");
    fixture.pass(3_599_999);
    assert_eq!(fixture.next(2.0), []);
    fixture.pass(1);
    assert_eq!(fixture.next(2.0), [AlarmChangeKind::Unsuppressed, AlarmChangeKind::Raised]);
    assert_eq!(
        fixture.extend("Vented", HOUR).unwrap_err(),
        "Vented is not declared; look at the plant states before you change one"
    );
}

#[test]
fn a_refused_declaration_says_what_was_expected() {
    let mut fixture = fixture();
    assert_eq!(
        fixture.declare("Ventd", HOUR).unwrap_err(),
        "there is no plant state \"Ventd\"; expected one of: Vented, Bake-out, Empty"
    );
    let expected = "expected minutes from 1 to 1440, the longest time of Vented in the station's file, found ";
    for (time, found) in [(Duration::ZERO, "0"), (24 * HOUR + Duration::from_secs(60), "1441")] {
        assert_eq!(fixture.declare("Vented", time).unwrap_err(), format!("{expected}{found}"));
    }
    fixture.declare("Vented", 24 * HOUR).unwrap();
    assert_eq!(
        fixture.declare("Vented", HOUR).unwrap_err(),
        "Vented is declared by Ada already; extend it, or end it first"
    );
    let now = fixture.now();
    let empty = Fixture::new(Vec::new()).registry.plant_states_mut().end("Vented", "Ada", "", now).unwrap_err();
    assert_eq!(empty.to_string(), "there is no plant state \"Vented\"; the station's file has no [[plant-state]]");
}

#[test]
fn a_user_who_shelved_an_alarm_or_took_it_out_of_service_is_not_overruled() {
    let mut fixture = fixture();
    let now = fixture.now();
    fixture.registry.shelve("it", "Ada", "so", HOUR / 2, now).unwrap();
    fixture.declare("Vented", HOUR).unwrap();
    assert_eq!(fixture.next(2.0), []);
    assert_eq!(fixture.state(), AlarmState::Shelved);
    fixture.pass(1_800_000);
    assert_eq!(
        fixture.next(2.0),
        [AlarmChangeKind::Unshelved, AlarmChangeKind::Suppressed],
        "its time on the shelf is over"
    );
    let now = fixture.now();
    fixture.registry.take_out_of_service("it", "Eve", "repair", None, now).unwrap();
    fixture.pass(1_800_000);
    assert_eq!(fixture.next(2.0), []);
    assert_eq!(fixture.state(), AlarmState::OutOfService);
    let now = fixture.now();
    fixture.registry.return_to_service("it", "Eve", now).unwrap();
    assert_eq!(fixture.next(2.0), [AlarmChangeKind::Raised]);
}

#[test]
fn a_declaration_holds_over_a_restart_until_its_end_and_no_clock_prolongs_it() {
    let mut fixture = fixture();
    fixture.declare("Vented", HOUR).unwrap();
    fixture.next(2.0);
    let declaration = fixture.registry.plant_states().state("Vented").unwrap().declaration().unwrap().clone();
    let stored: Vec<(String, AlarmStatus)> = vec![("it".to_owned(), fixture.status().clone())];
    // The wall clock at the start in hours after the declaration, and the hours until the end.
    for (clock, hours) in [(0, 1), (-100, 24), (100, 0)] {
        let mut restarted = Fixture::new(Vec::new());
        restarted.wall_ms = fixture.wall_ms + clock * 3_600_000;
        let now = restarted.now();
        restarted.registry.reconfigure(vec![above(0, 0)], stored.clone(), now);
        let declarations: Vec<(String, Declaration)> = vec![("Vented".to_owned(), declaration.clone())];
        restarted.registry.plant_states_mut().reconfigure(vec![state("Vented", &["it"])], declarations, now);
        if hours > 0 {
            restarted.pass(hours * 3_600_000 - 1);
            assert_eq!(restarted.next(2.0), [], "{clock}");
            restarted.pass(1);
        }
        assert_eq!(restarted.next(2.0), [AlarmChangeKind::Unsuppressed, AlarmChangeKind::Raised], "{clock}");
    }
}

#[test]
fn a_changed_file_keeps_a_declaration_by_its_name_and_ends_that_of_a_removed_plant_state() {
    let mut fixture = fixture();
    fixture.declare("Vented", HOUR).unwrap();
    fixture.declare("Bake-out", 2 * HOUR).unwrap();
    fixture.next(2.0);
    let now = fixture.now();
    let changes = fixture.registry.plant_states_mut().reconfigure(vec![state("Vented", &["it"])], Vec::new(), now);
    let told: Vec<_> = changes.iter().map(|it| (it.name.as_str(), it.kind, it.reason.as_str())).collect();
    assert_eq!(told, [("Bake-out", PlantStateChangeKind::Ended, "the station's file no longer has it")]);
    assert_eq!(fixture.next(2.0), []);
    fixture.pass(3_600_000);
    assert_eq!(fixture.next(2.0), [AlarmChangeKind::Unsuppressed, AlarmChangeKind::Raised]);
    fixture.declare("Vented", HOUR).unwrap();
    fixture.next(2.0);
    let now = fixture.now();
    fixture.registry.plant_states_mut().reconfigure(vec![state("Vented", &["another"])], Vec::new(), now);
    assert_eq!(
        fixture.next(2.0),
        [AlarmChangeKind::Unsuppressed, AlarmChangeKind::Raised],
        "it no longer selects the alarm"
    );
}

#[test]
fn a_suppressed_alarm_tells_no_target_of_its_condition_and_waits_for_no_acknowledgement() {
    let every = NotificationTarget::of_every_change("shift".to_owned(), Priority::Low);
    let late = NotificationTarget { unacknowledged_after: HOUR / 6, webhook: "boss".to_owned(), ..every.clone() };
    let mut notifier = Notifier::default();
    notifier.set_targets(vec![every, late]);
    let mut fixture = fixture();
    let mut told = |fixture: &mut Fixture, pa: f64| {
        let now = fixture.now();
        fixture.registry.plant_states_mut().end_due(now);
        let changes = fixture.registry.evaluate(&inputs(pa, Quality::Valid), now);
        let mut told: Vec<String> = Vec::new();
        for change in changes {
            told.extend(notifier.told_of(&change).iter().map(|target| format!("{target} {}", change.kind.word())));
        }
        let late = notifier.told_late(fixture.registry.alarms(), now);
        told.extend(late.iter().map(|(target, _)| format!("{target} late")));
        told
    };
    fixture.declare("Vented", HOUR).unwrap();
    assert_eq!(told(&mut fixture, 0.1), Vec::<String>::new());
    assert_eq!(told(&mut fixture, 2.0), Vec::<String>::new());
    fixture.pass(3_599_999);
    assert_eq!(told(&mut fixture, 2.0), Vec::<String>::new(), "no escalation");
    fixture.pass(1);
    assert_eq!(told(&mut fixture, 2.0), ["shift raised"]);
    fixture.declare("Vented", HOUR).unwrap();
    assert_eq!(told(&mut fixture, 2.0), ["shift suppressed"], "a target that was told of the occurrence");
    fixture.pass(3_600_000);
    assert_eq!(told(&mut fixture, 0.1), Vec::<String>::new());
}
