//! Which notification target is told of which change: priorities, quiet hours, and alarms that no user acknowledges.
//!
//! | Target | Is told of |
//! |---|---|
//! | without further keys | every change, in the transaction of its history |
//! | with `unacknowledged-after` | an alarm that waits for its acknowledgement for this time, and then the changes of this occurrence |
//! | with `quiet` | in the quiet hours alarms of high priority only; at their end what still waits for an acknowledgement |
//!
//! A target is told that a plant state suppresses an alarm only while an occurrence is open; it is not told of the end: an alarm whose
//! condition is met then is raised.
//!
//! What a target was told is forgotten at the end of the station: after a start it is told again of alarms that still wait.

use super::registry::{AlarmChange, RegisteredAlarm};
use super::suppression::AlarmTime;
use jiff::Timestamp;
use jiff::civil::Time;
use jiff::tz::TimeZone;
use profivac_model::{AlarmChangeKind, Priority};
use profivac_recorder::Micros;
use std::collections::{BTreeMap, BTreeSet};
use std::time::Duration;

/// A part of each day in which only alarms of high priority are told.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct QuietHours {
    /// The beginning.
    pub from: Time,
    /// The end; before the beginning, it is on the next day.
    pub to: Time,
    /// The time zone of both.
    pub zone: TimeZone,
}

impl QuietHours {
    /// Whether the quiet hours contain this wall-clock time.
    #[must_use]
    pub fn contains(&self, at: Micros) -> bool {
        let Ok(at) = Timestamp::from_microsecond(at.0) else { return false };
        let time = at.to_zoned(self.zone.clone()).time();
        if self.from <= self.to { self.from <= time && time < self.to } else { self.from <= time || time < self.to }
    }
}

/// A webhook, and of what it is notified.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct NotificationTarget {
    /// The name of the webhook.
    pub webhook: String,
    /// The lowest priority of which it is notified.
    pub min_priority: Priority,
    /// It is told only of alarms that wait for their acknowledgement for this time; zero: of all, at once.
    pub unacknowledged_after: Duration,
    /// The hours in which it is told of alarms of high priority only.
    pub quiet: Option<QuietHours>,
}

impl NotificationTarget {
    /// A target that is told of every change from a priority on.
    #[must_use]
    pub const fn of_every_change(webhook: String, min_priority: Priority) -> Self {
        Self { webhook, min_priority, unacknowledged_after: Duration::ZERO, quiet: None }
    }

    const fn is_told_at_once(&self) -> bool {
        self.unacknowledged_after.is_zero()
    }

    const fn is_told_of_everything(&self) -> bool {
        self.is_told_at_once() && self.quiet.is_none()
    }

    fn is_quiet(&self, priority: Priority, at: Micros) -> bool {
        priority < Priority::High && self.quiet.as_ref().is_some_and(|quiet| quiet.contains(at))
    }
}

/// An occurrence that waits for its acknowledgement.
#[derive(Clone, Copy, Debug)]
struct Waiting {
    occurrence: i64,
    /// Since when, in monotonic time.
    since: Micros,
}

/// Decides which target is told of what.
#[derive(Clone, Debug, Default)]
pub struct Notifier {
    targets: Vec<NotificationTarget>,
    /// The last occurrence of an alarm that a target was told of, by webhook and alarm.
    told: BTreeMap<(String, String), i64>,
    /// The alarms that wait for their acknowledgement.
    waiting: BTreeMap<String, Waiting>,
}

impl Notifier {
    /// Applies the targets of a file.
    pub fn set_targets(&mut self, targets: Vec<NotificationTarget>) {
        self.told.retain(|(webhook, _), _| targets.iter().any(|target| target.webhook == *webhook));
        self.targets = targets;
    }

    /// Forgets who was told of alarms that are no longer registered.
    pub fn forget_removed(&mut self, registered: &[RegisteredAlarm]) {
        let names: BTreeSet<&str> = registered.iter().map(|alarm| alarm.rule().name.as_str()).collect();
        self.told.retain(|(_, alarm), _| names.contains(alarm.as_str()));
    }

    /// The webhooks that are told of a change when it happens.
    pub fn told_of(&mut self, change: &AlarmChange) -> Vec<String> {
        let AlarmChange { at, rule, kind, status, was, .. } = change;
        let is_open = was.is_active() || was.needs_acknowledgement();
        if *kind == AlarmChangeKind::Unsuppressed || (*kind == AlarmChangeKind::Suppressed && !is_open) {
            return Vec::new();
        }
        let told = &mut self.told;
        let mut is_told = |target: &&NotificationTarget| {
            if target.is_told_of_everything() {
                return true;
            }
            let key = (target.webhook.clone(), rule.name.clone());
            let is_quiet = target.is_quiet(rule.priority, *at);
            if *kind != AlarmChangeKind::Raised {
                return !is_quiet && told.get(&key) == Some(&status.occurrence);
            }
            let is_told = target.is_told_at_once() && !is_quiet;
            if is_told {
                told.insert(key, status.occurrence);
            }
            is_told
        };
        let targets = self.targets.iter().filter(|target| target.min_priority <= rule.priority);
        targets.filter(&mut is_told).map(|target| target.webhook.clone()).collect()
    }

    /// The webhooks that are told now of alarms that still wait for their acknowledgement, with these alarms.
    pub fn told_late<'a>(
        &mut self,
        alarms: &'a [RegisteredAlarm],
        now: AlarmTime,
    ) -> Vec<(String, &'a RegisteredAlarm)> {
        if self.targets.iter().all(NotificationTarget::is_told_of_everything) {
            return Vec::new();
        }
        self.note_waiting(alarms, now.monotonic);
        let mut late = Vec::new();
        for target in self.targets.iter().filter(|target| !target.is_told_of_everything()) {
            for alarm in alarms {
                let (name, priority) = (&alarm.rule().name, alarm.rule().priority);
                let Some(waiting) = self.waiting.get(name) else { continue };
                let is_due = waiting.since.after(target.unacknowledged_after) <= now.monotonic;
                if !is_due || priority < target.min_priority || target.is_quiet(priority, now.wall) {
                    continue;
                }
                let key = (target.webhook.clone(), name.clone());
                if self.told.insert(key, waiting.occurrence) != Some(waiting.occurrence) {
                    late.push((target.webhook.clone(), alarm));
                }
            }
        }
        late
    }

    /// Notes since when each alarm waits for the acknowledgement of its occurrence.
    fn note_waiting(&mut self, alarms: &[RegisteredAlarm], now: Micros) {
        let mut waiting = BTreeMap::new();
        for alarm in alarms.iter().filter(|alarm| alarm.status().state.needs_acknowledgement()) {
            let occurrence = alarm.status().occurrence;
            let before = self.waiting.remove(&alarm.rule().name).filter(|before| before.occurrence == occurrence);
            let begins = Waiting { occurrence, since: now };
            waiting.insert(alarm.rule().name.clone(), before.unwrap_or(begins));
        }
        self.waiting = waiting;
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use jiff::tz::offset;

    fn quiet(from: i8, to: i8) -> QuietHours {
        let hour = |hour| Time::constant(hour, 0, 0, 0);
        QuietHours { from: hour(from), to: hour(to), zone: TimeZone::fixed(offset(1)) }
    }

    /// The wall-clock time of an hour in UTC.
    fn at(hour: i64) -> Micros {
        Micros(1_767_225_600 * Micros::SECOND + hour * 3600 * Micros::SECOND)
    }

    #[test]
    fn quiet_hours_are_in_their_zone_and_may_go_over_midnight() {
        let night = quiet(22, 6);
        let hours: Vec<_> = (0..24).filter(|hour| night.contains(at(*hour))).collect();
        assert_eq!(hours, [0, 1, 2, 3, 4, 21, 22, 23]);
        let noon = quiet(12, 13);
        assert_eq!((0..24).filter(|hour| noon.contains(at(*hour))).collect::<Vec<_>>(), [11]);
        assert_eq!((0..24).filter(|hour| quiet(8, 8).contains(at(*hour))).count(), 0);
    }
}
