//! Which notification target is told of which change.

use super::{Fixture, above};
use crate::support::inputs::inputs;
use jiff::civil::Time;
use jiff::tz::TimeZone;
use profivac_recorder::Quality;
use profivac_station::alarm::notify::Notifier;
use profivac_station::alarm::{AlarmChangeKind, NotificationTarget, Priority, QuietHours, Rule};
use std::time::Duration;

/// A registry and the notification targets of its changes.
struct Told {
    fixture: Fixture,
    notifier: Notifier,
}

impl Told {
    fn new(priority: Priority, targets: Vec<NotificationTarget>) -> Self {
        let mut notifier = Notifier::default();
        notifier.set_targets(targets);
        Self { fixture: Fixture::new(vec![Rule { priority, ..above(0, 0) }]), notifier }
    }

    /// Lets time pass, evaluates at this pressure, and returns who is told of which change; `late` for alarms that still wait.
    fn after(&mut self, seconds: i64, pa: f64) -> Vec<(String, &'static str)> {
        self.fixture.pass(seconds * 1000);
        let now = self.fixture.now();
        let changes = self.fixture.registry.evaluate(&inputs(pa, Quality::Valid), now);
        let mut told = Vec::new();
        for change in &changes {
            told.extend(self.notifier.told_of(change).into_iter().map(|webhook| (webhook, change.kind.word())));
        }
        let late = self.notifier.told_late(self.fixture.registry.alarms(), now);
        told.extend(late.into_iter().map(|(webhook, _)| (webhook, "late")));
        told
    }

    fn acknowledge(&mut self) -> Vec<String> {
        let change = self.fixture.acknowledge().unwrap();
        assert_eq!(change.kind, AlarmChangeKind::Acknowledged);
        self.notifier.told_of(&change)
    }
}

fn target(name: &str) -> NotificationTarget {
    NotificationTarget::of_every_change(name.to_owned(), Priority::Low)
}

fn after_ten_minutes(name: &str) -> NotificationTarget {
    NotificationTarget { unacknowledged_after: Duration::from_secs(600), ..target(name) }
}

/// Quiet from midnight to six: the fixture begins at midnight of the new year.
fn quiet_at_night(name: &str) -> NotificationTarget {
    let hour = |hour| Time::constant(hour, 0, 0, 0);
    NotificationTarget { quiet: Some(QuietHours { from: hour(0), to: hour(6), zone: TimeZone::UTC }), ..target(name) }
}

const HIGH: f64 = 2.0;
const LOW: f64 = 0.1;

fn told(webhooks: &[&str], what: &'static str) -> Vec<(String, &'static str)> {
    webhooks.iter().map(|webhook| ((*webhook).to_owned(), what)).collect()
}

#[test]
fn the_boss_is_told_only_of_an_alarm_that_is_not_acknowledged_in_time() {
    let mut told_who = Told::new(Priority::Medium, vec![target("shift"), after_ten_minutes("boss")]);
    assert_eq!(told_who.after(0, HIGH), told(&["shift"], "raised"));
    assert_eq!(told_who.after(599, HIGH), []);
    assert_eq!(told_who.after(1, HIGH), told(&["boss"], "late"));
    assert_eq!(told_who.after(3600, HIGH), [], "once for each occurrence");
    assert_eq!(told_who.acknowledge(), ["shift", "boss"], "who was told of the alarm is told of its end");
    assert_eq!(told_who.after(1, LOW), told(&["shift", "boss"], "returned"));
    assert_eq!(told_who.after(1, HIGH), told(&["shift"], "raised"), "another occurrence");
    assert_eq!(told_who.acknowledge(), ["shift"]);
    assert_eq!(told_who.after(601, LOW), told(&["shift"], "returned"));
}

#[test]
fn who_was_told_of_a_removed_alarm_is_forgotten() {
    for (is_removed, told_of_the_end) in [(false, vec!["boss"]), (true, vec![])] {
        let mut told_who = Told::new(Priority::Medium, vec![after_ten_minutes("boss")]);
        assert_eq!(told_who.after(0, HIGH), []);
        assert_eq!(told_who.after(600, HIGH), told(&["boss"], "late"));
        let registered = if is_removed { &[] } else { told_who.fixture.registry.alarms() };
        told_who.notifier.forget_removed(registered);
        assert_eq!(told_who.acknowledge(), told_of_the_end);
    }
}

#[test]
fn an_alarm_that_cleared_without_an_acknowledgement_is_told_too() {
    let mut told_who = Told::new(Priority::Low, vec![after_ten_minutes("boss")]);
    assert_eq!(told_who.after(0, HIGH), []);
    assert_eq!(told_who.after(10, LOW), []);
    assert_eq!(told_who.after(590, LOW), told(&["boss"], "late"));
}

#[test]
fn quiet_hours_end_with_the_alarms_that_still_wait() {
    let mut told_who = Told::new(Priority::Medium, vec![quiet_at_night("ada")]);
    assert_eq!(told_who.after(3600, HIGH), []);
    assert_eq!(told_who.after(5 * 3600 - 1, HIGH), []);
    assert_eq!(told_who.after(1, HIGH), told(&["ada"], "late"));
    assert_eq!(told_who.after(60, LOW), told(&["ada"], "returned"));
    let mut solved = Told::new(Priority::Medium, vec![quiet_at_night("ada")]);
    assert_eq!(solved.after(3600, HIGH), []);
    assert_eq!(solved.acknowledge(), Vec::<String>::new());
    assert_eq!(solved.after(6 * 3600, LOW), [], "another user has acknowledged it during the night");
}

#[test]
fn alarms_of_high_priority_are_told_in_quiet_hours() {
    let mut told_who = Told::new(Priority::High, vec![quiet_at_night("ada")]);
    assert_eq!(told_who.after(3600, HIGH), told(&["ada"], "raised"));
    assert_eq!(told_who.acknowledge(), ["ada"]);
}

#[test]
fn a_target_is_not_told_late_of_an_alarm_below_its_lowest_priority() {
    let high_only = NotificationTarget { min_priority: Priority::High, ..after_ten_minutes("boss") };
    let mut told_who = Told::new(Priority::Medium, vec![high_only]);
    assert_eq!(told_who.after(0, HIGH), []);
    assert_eq!(told_who.after(700, HIGH), []);
}

#[test]
fn a_clock_that_is_set_makes_no_alarm_old() {
    let mut told_who = Told::new(Priority::Medium, vec![after_ten_minutes("boss")]);
    assert_eq!(told_who.after(0, HIGH), []);
    told_who.fixture.wall_ms += 86_400_000;
    assert_eq!(told_who.after(1, HIGH), []);
    assert_eq!(told_who.after(599, HIGH), told(&["boss"], "late"));
}
