//! The alarm registry without clock, thread and disk.
//!
//! | Module | Holds |
//! |---|---|
//! | `limits` | limits of a pressure, their texts, and ends of ranges |
//! | `conditions` | all other conditions |
//! | `lifecycle` | delays, users, changed files, restarts |
//! | `plant_states` | which alarms a declared plant state suppresses |
//! | `notify` | which notification target is told of which change |
//! | `random` | random sequences |

#![allow(clippy::unwrap_used, clippy::panic, clippy::indexing_slicing, reason = "a test")]

mod conditions;
mod lifecycle;
mod limits;
mod notify;
mod plant_states;
mod random;

use profivac_recorder::Micros;
use profivac_station::alarm::{
    AlarmChange, AlarmChangeKind, AlarmError, AlarmRegistry, AlarmState, AlarmStatus, AlarmTime, Condition, Inputs,
    Priority, Rule, Series,
};
use std::time::Duration;

const NEW_YEAR_S: i64 = 1_767_225_600;

/// A registry with a monotonic clock and a wall clock.
struct Fixture {
    registry: AlarmRegistry,
    monotonic_ms: i64,
    wall_ms: i64,
}

impl Fixture {
    fn new(rules: Vec<Rule>) -> Self {
        let mut fixture = Self { registry: AlarmRegistry::default(), monotonic_ms: 0, wall_ms: NEW_YEAR_S * 1000 };
        fixture.registry.reconfigure(rules, Vec::new(), fixture.now());
        fixture
    }

    fn now(&self) -> AlarmTime {
        AlarmTime { monotonic: Micros(self.monotonic_ms * 1000), wall: Micros(self.wall_ms * 1000) }
    }

    fn pass(&mut self, ms: i64) {
        self.monotonic_ms += ms;
        self.wall_ms += ms;
    }

    fn evaluate(&mut self, inputs: &Inputs) -> Vec<AlarmChangeKind> {
        let now = self.now();
        self.registry.evaluate(inputs, now).into_iter().map(|change| change.kind).collect()
    }

    /// Evaluates, then lets time pass.
    fn evaluate_for(&mut self, inputs: &Inputs, ms: i64) -> Vec<AlarmChangeKind> {
        let changes = self.evaluate(inputs);
        self.pass(ms);
        changes
    }

    fn status(&self) -> &AlarmStatus {
        self.registry.alarms()[0].status()
    }

    fn state(&self) -> AlarmState {
        self.status().state
    }

    fn acknowledge(&mut self) -> Result<AlarmChange, AlarmError> {
        let (occurrence, now) = (self.status().occurrence, self.now());
        self.registry.acknowledge("it", occurrence, "Ada", now)
    }
}

fn series() -> Series {
    Series { gauge: "chamber".to_owned(), name: "chamber".to_owned() }
}

fn rule(condition: Condition, delay_s: u64, off_delay_s: u64) -> Rule {
    Rule {
        name: "it".to_owned(),
        condition,
        priority: Priority::High,
        delay: Duration::from_secs(delay_s),
        off_delay: Duration::from_secs(off_delay_s),
        message: None,
    }
}

/// Above 1 Pa until below 0.5 Pa.
fn above(delay_s: u64, off_delay_s: u64) -> Rule {
    rule(Condition::Above { series: series(), limit: 1.0, reset: 0.5 }, delay_s, off_delay_s)
}
