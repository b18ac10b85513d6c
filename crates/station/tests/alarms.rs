//! The alarm registry without clock, thread and disk: limits, delays, users, changed files, and random sequences.

#![allow(clippy::unwrap_used, clippy::panic, clippy::indexing_slicing, reason = "a test")]

mod support;

use profivac_recorder::{Micros, Quality};
use profivac_station::alarm::{
    AlarmChange, AlarmError, AlarmRegistry, AlarmState, AlarmStatus, AlarmTime, ChangeKind, Condition, Inputs,
    Priority, Rule, Series,
};
use profivac_station::view::{BusStationState, SegmentState};
use std::time::Duration;
use support::inputs::{inputs, silent};

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

    fn evaluate(&mut self, inputs: &Inputs) -> Vec<ChangeKind> {
        let now = self.now();
        self.registry.evaluate(inputs, now).into_iter().map(|change| change.kind).collect()
    }

    /// Evaluates, then lets time pass.
    fn evaluate_for(&mut self, inputs: &Inputs, ms: i64) -> Vec<ChangeKind> {
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

#[test]
fn an_alarm_is_raised_acknowledged_and_returns() {
    let mut fixture = Fixture::new(vec![above(0, 0)]);
    assert_eq!(fixture.evaluate_for(&inputs(0.9, Quality::Valid), 250), []);
    assert_eq!(fixture.evaluate_for(&inputs(1.1, Quality::Valid), 250), [ChangeKind::Raised]);
    assert_eq!((fixture.state(), fixture.status().value), (AlarmState::Unacknowledged, Some(1.1)));
    assert_eq!(fixture.status().text, "chamber shows 1.10e-2 mbar, above the limit of 1.00e-2 mbar");
    let change = fixture.acknowledge().unwrap();
    assert_eq!(
        (change.user.as_deref(), change.value, fixture.state()),
        (Some("Ada"), Some(1.1), AlarmState::Acknowledged)
    );
    assert_eq!(fixture.evaluate_for(&inputs(0.4, Quality::Valid), 250), [ChangeKind::Returned]);
    assert_eq!(fixture.state(), AlarmState::Normal);
    fixture.evaluate_for(&inputs(2.0, Quality::Valid), 250);
    assert_eq!(fixture.evaluate_for(&inputs(0.1, Quality::Valid), 250), [ChangeKind::Returned]);
    assert_eq!(fixture.state(), AlarmState::Returned, "it is not acknowledged");
    fixture.acknowledge().unwrap();
    assert_eq!(fixture.state(), AlarmState::Normal);
}

#[test]
fn a_limit_alarm_is_raised_at_the_limit_and_returns_at_the_reset() {
    let mut fixture = Fixture::new(vec![above(0, 0)]);
    assert_eq!(fixture.evaluate(&inputs(1.0, Quality::Valid)), [], "the limit itself is not above the limit");
    assert_eq!(fixture.evaluate(&inputs(1.000_001, Quality::Valid)), [ChangeKind::Raised]);
    for pa in [0.99, 0.500_001, 1.5, 0.7] {
        assert_eq!(fixture.evaluate(&inputs(pa, Quality::Valid)), [], "{pa}");
    }
    assert_eq!(fixture.evaluate(&inputs(0.5, Quality::Valid)), [ChangeKind::Returned]);
    assert_eq!(fixture.evaluate(&inputs(0.99, Quality::Valid)), [], "after the return the limit counts again");
    let mut fixture = Fixture::new(vec![rule(Condition::Below { series: series(), limit: 1.0, reset: 2.0 }, 0, 0)]);
    assert_eq!(fixture.evaluate(&inputs(1.0, Quality::Valid)), []);
    assert_eq!(fixture.evaluate(&inputs(0.999, Quality::Valid)), [ChangeKind::Raised]);
    assert_eq!(fixture.evaluate(&inputs(1.999, Quality::Valid)), []);
    assert_eq!(fixture.evaluate(&inputs(2.0, Quality::Valid)), [ChangeKind::Returned]);
}

#[test]
fn the_text_of_a_change_states_where_the_pressure_is() {
    let above = |limit, reset| Condition::Above { series: series(), limit, reset };
    let below = |limit, reset| Condition::Below { series: series(), limit, reset };
    let table = [
        (above(100.0, 50.0), 200.0, "2.00e0 mbar, above the limit of 1.00e0 mbar"),
        (above(100.0, 50.0), 7.75e-5, "7.75e-7 mbar, not above the reset value of 5.00e-1 mbar"),
        (above(100.0, 50.0), 50.0, "5.00e-1 mbar, not above the reset value of 5.00e-1 mbar"),
        (above(100.0, 100.0), 100.0, "1.00e0 mbar, not above the limit of 1.00e0 mbar"),
        (below(100.0, 200.0), 50.0, "5.00e-1 mbar, below the limit of 1.00e0 mbar"),
        (below(100.0, 200.0), 300.0, "3.00e0 mbar, not below the reset value of 2.00e0 mbar"),
        (below(100.0, 100.0), 150.0, "1.50e0 mbar, not below the limit of 1.00e0 mbar"),
    ];
    for (condition, pa, expected) in table {
        let mut fixture = Fixture::new(vec![rule(condition.clone(), 0, 0)]);
        let now = fixture.now();
        let mut text = fixture.registry.evaluate(&inputs(pa, Quality::Valid), now).pop().map(|change| change.text);
        if text.is_none() {
            let beyond = if matches!(condition, Condition::Above { .. }) { 1e4 } else { 1e-4 };
            assert_eq!(fixture.evaluate(&inputs(beyond, Quality::Valid)), [ChangeKind::Raised]);
            text = fixture.registry.evaluate(&inputs(pa, Quality::Valid), now).pop().map(|change| change.text);
        }
        assert_eq!(text, Some(format!("chamber shows {expected}")), "{condition:?}");
    }
}

#[test]
fn an_alarm_raised_between_limit_and_reset_does_not_claim_the_limit() {
    let mut fixture = Fixture::new(vec![above(0, 0)]);
    fixture.evaluate(&inputs(2.0, Quality::Valid));
    let now = fixture.now();
    fixture.registry.take_out_of_service("it", "Eve", "service", None, now).unwrap();
    fixture.registry.return_to_service("it", "Eve", now).unwrap();
    assert_eq!(fixture.evaluate(&inputs(0.7, Quality::Valid)), [ChangeKind::Raised]);
    let expected = "chamber shows 7.00e-3 mbar, above the reset value of 5.00e-3 mbar";
    assert_eq!(fixture.status().text, expected);
    fixture.registry.take_out_of_service("it", "Eve", "service", None, now).unwrap();
    fixture.registry.return_to_service("it", "Eve", now).unwrap();
    assert_eq!(fixture.evaluate(&silent()), [ChangeKind::Raised]);
    assert_eq!(fixture.status().text, "its condition was met when it was last known");
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
        let expected = [ChangeKind::ReturnedToService, ChangeKind::Raised];
        assert_eq!(restarted.evaluate(&inputs(2.0, Quality::Valid)), expected, "{days}");
    }
}

#[test]
fn delays_are_exact_to_the_millisecond() {
    let mut fixture = Fixture::new(vec![above(2, 3)]);
    fixture.evaluate_for(&inputs(2.0, Quality::Valid), 1999);
    assert_eq!(fixture.evaluate_for(&inputs(2.0, Quality::Valid), 1), []);
    assert_eq!(fixture.evaluate(&inputs(2.0, Quality::Valid)), [ChangeKind::Raised]);
    fixture.evaluate_for(&inputs(0.1, Quality::Valid), 2999);
    assert_eq!(fixture.evaluate_for(&inputs(0.1, Quality::Valid), 1), []);
    assert_eq!(fixture.evaluate(&inputs(0.1, Quality::Valid)), [ChangeKind::Returned]);
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
    assert_eq!(seen, [ChangeKind::Raised]);
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
    assert_eq!(fixture.evaluate(&inputs(2.0, Quality::Valid)), [ChangeKind::Raised]);
    let first = fixture.status().occurrence;
    fixture.wall_ms -= 7_200_000;
    fixture.evaluate_for(&inputs(0.1, Quality::Valid), 10_000);
    fixture.evaluate_for(&inputs(0.1, Quality::Valid), 0);
    fixture.evaluate_for(&inputs(2.0, Quality::Valid), 10_000);
    assert_eq!(fixture.evaluate(&inputs(2.0, Quality::Valid)), [ChangeKind::Raised]);
    assert_eq!(
        fixture.status().occurrence,
        first + 1,
        "an occurrence is never used twice, even if the clock shows an earlier time"
    );
}

#[test]
fn an_unknown_pressure_neither_raises_nor_clears_an_alarm() {
    let without_pressure = [Quality::Fault, Quality::Stale, Quality::Off, Quality::Missing];
    for nothing in without_pressure.map(|quality| inputs(0.1, quality)).into_iter().chain([silent(), Inputs::default()])
    {
        let mut fixture = Fixture::new(vec![above(0, 0)]);
        assert_eq!(fixture.evaluate(&nothing), []);
        fixture.evaluate(&inputs(2.0, Quality::Valid));
        assert_eq!(fixture.evaluate(&nothing), [], "{nothing:?}");
        assert_eq!(fixture.state(), AlarmState::Unacknowledged);
        assert_eq!(fixture.evaluate(&inputs(0.1, Quality::Valid)), [ChangeKind::Returned]);
    }
}

#[test]
fn the_end_of_a_range_bounds_the_pressure() {
    let table = [
        // end of the range, quality, whether the limit of 1 Pa is exceeded
        (2.0, Quality::Overrange, Some(true)),
        (0.5, Quality::Overrange, None),
        (0.2, Quality::Underrange, Some(false)),
        (2.0, Quality::Underrange, None),
    ];
    for (pa, quality, known) in table {
        let mut fixture = Fixture::new(vec![above(0, 0)]);
        assert_eq!(fixture.evaluate(&inputs(pa, quality)).is_empty(), known != Some(true), "{pa} {quality:?}");
        let mut fixture = Fixture::new(vec![above(0, 0)]);
        fixture.evaluate(&inputs(9.0, Quality::Valid));
        assert_eq!(fixture.evaluate(&inputs(pa, quality)).is_empty(), known != Some(false), "{pa} {quality:?}");
        let blind = Condition::NotMeasurable { series: series(), limits: vec![1.0] };
        let mut fixture = Fixture::new(vec![rule(blind, 0, 0)]);
        assert_eq!(
            fixture.evaluate(&inputs(pa, quality)).is_empty(),
            known.is_some(),
            "{pa} {quality:?} is not measurable"
        );
    }
}

/// The limit is 1 Pa, the reset value 0.5 Pa, and the range of the gauge ends at 0.7 Pa.
#[test]
fn an_alarm_returns_below_the_range_of_its_gauge_although_the_reset_value_is_below_the_range() {
    let mut fixture = Fixture::new(vec![above(0, 0)]);
    fixture.evaluate(&inputs(2.0, Quality::Valid));
    assert_eq!(fixture.evaluate(&inputs(0.8, Quality::Valid)), [], "not past the reset value");
    let now = fixture.now();
    let changes = fixture.registry.evaluate(&inputs(0.7, Quality::Underrange), now);
    assert_eq!(changes[0].kind, ChangeKind::Returned);
    assert_eq!(changes[0].text, "chamber shows under range (< 7.00e-3 mbar), not above the limit of 1.00e-2 mbar");
}

#[test]
fn the_text_of_a_change_says_on_which_side_of_the_limit_the_pressure_is() {
    let mut fixture = Fixture::new(vec![above(0, 0)]);
    let now = fixture.now();
    let raised = fixture.registry.evaluate(&inputs(2.0, Quality::Valid), now);
    assert_eq!(raised[0].text, "chamber shows 2.00e-2 mbar, above the limit of 1.00e-2 mbar");
    let returned = fixture.registry.evaluate(&inputs(0.4, Quality::Valid), now);
    assert_eq!(returned[0].text, "chamber shows 4.00e-3 mbar, not above the reset value of 5.00e-3 mbar");
}

/// At a good high vacuum 14 Piranis are below their range, and the ion gauges of a controller are off.
#[test]
fn a_gauge_below_its_range_or_off_reports_no_fault() {
    for quality in [Quality::Underrange, Quality::Overrange, Quality::Off, Quality::Missing] {
        let mut fixture = Fixture::new(vec![rule(Condition::Fault { gauge: "chamber".to_owned() }, 0, 0)]);
        assert_eq!(fixture.evaluate(&inputs(1.0, quality)), [], "{quality:?}");
    }
}

#[test]
fn an_invalid_reading_is_not_measurable_and_a_silent_gauge_is_stale() {
    let blind = || Fixture::new(vec![rule(Condition::NotMeasurable { series: series(), limits: vec![1.0] }, 0, 0)]);
    assert_eq!(blind().evaluate(&inputs(1.0, Quality::Fault)), [ChangeKind::Raised]);
    assert_eq!(blind().evaluate(&inputs(1.0, Quality::Valid)), []);
    assert_eq!(blind().evaluate(&silent()), []);
    let series = Series { gauge: "chamber".to_owned(), name: "chamber.2".to_owned() };
    let mut fixture = Fixture::new(vec![rule(Condition::NotMeasurable { series, limits: vec![1.0] }, 0, 0)]);
    assert_eq!(fixture.evaluate(&inputs(1.0, Quality::Valid)), [ChangeKind::Raised]);
    assert_eq!(fixture.status().text, "chamber has no series chamber.2");
}

#[test]
fn a_rise_is_the_slope_over_its_window() {
    let rise = Condition::Rise { series: series(), limit: 0.5, reset: 0.25, window: Duration::from_secs(20) };
    let walk = |decades_per_minute: f64, seconds: i64| {
        let mut fixture = Fixture::new(vec![rule(rise.clone(), 0, 0)]);
        let seen: Vec<_> = (0..seconds * 4)
            .filter(|step| {
                let pa = 10_f64.powf(-6.0 + decades_per_minute * *step as f64 / 240.0);
                !fixture.evaluate_for(&inputs(pa, Quality::Valid), 250).is_empty()
            })
            .collect();
        (seen, fixture)
    };
    assert_eq!(walk(0.49, 60).0, Vec::<i64>::new(), "slower than the limit");
    assert_eq!(walk(-5.0, 60).0, Vec::<i64>::new(), "a pump-down is no rise");
    let (seen, mut fixture) = walk(0.51, 60);
    assert_eq!(seen, [40], "as soon as half of the window is covered");
    assert!((fixture.registry.alarms()[0].value().unwrap() - 0.51).abs() < 1e-6);
    let end = 10_f64.powf(-6.0 + 0.51);
    let still: Vec<_> = (0..80).flat_map(|_| fixture.evaluate_for(&inputs(end, Quality::Valid), 250)).collect();
    assert_eq!(still, [ChangeKind::Returned]);
    let (_, mut fixture) = walk(0.51, 60);
    fixture.evaluate_for(&inputs(1.0, Quality::Fault), 250);
    assert_eq!(
        fixture.evaluate(&inputs(1e-6, Quality::Valid)),
        [],
        "readings before a gap are not compared with readings after it"
    );
    assert_eq!(fixture.registry.alarms()[0].value(), None);
}

#[test]
fn a_fault_alarm_returns_when_the_gauge_exchanges_data_without_exceptions() {
    let mut fixture = Fixture::new(vec![rule(Condition::Fault { gauge: "chamber".to_owned() }, 0, 0)]);
    let with = |state, exceptions: &[&str]| {
        let mut inputs = inputs(1.0, Quality::Valid);
        inputs.gauges[0].state = state;
        inputs.gauges[0].exceptions = exceptions.iter().map(|&words| words.to_owned()).collect();
        inputs
    };
    assert_eq!(fixture.evaluate(&with(BusStationState::DataExchange, &[])), []);
    assert_eq!(
        fixture.evaluate(&with(BusStationState::Fault, &["filament broken", "Pirani error"])),
        [ChangeKind::Raised]
    );
    assert_eq!(fixture.status().text, "chamber reports filament broken, Pirani error");
    assert_eq!(fixture.evaluate(&with(BusStationState::Missing, &[])), [], "a missing gauge does not clear its fault");
    let now = fixture.now();
    let changes = fixture.registry.evaluate(&with(BusStationState::DataExchange, &[]), now);
    assert_eq!(changes.iter().map(|change| change.kind).collect::<Vec<_>>(), [ChangeKind::Returned]);
    assert_eq!(changes[0].text, "", "a return has no sentence about the fault");
}

#[test]
fn a_stale_gauge_raises_an_alarm_unless_its_segment_is_down() {
    let stale = |behind: Option<&str>| {
        let behind_segment = behind.map(str::to_owned);
        Fixture::new(vec![rule(Condition::Stale { gauge: "chamber".to_owned(), behind_segment }, 0, 0)])
    };
    assert_eq!(stale(Some("hall")).evaluate(&inputs(1.0, Quality::Valid)), []);
    let mut fixture = stale(Some("hall"));
    assert_eq!(fixture.evaluate(&silent()), [ChangeKind::Raised]);
    assert_eq!(fixture.status().text, "chamber gives no data, the last are 60 s old");
    let now = fixture.now();
    assert_eq!(fixture.registry.evaluate(&inputs(1.0, Quality::Valid), now)[0].text, "");
    let mut lost = silent();
    lost.segments[0].state = SegmentState::Waiting;
    assert_eq!(stale(Some("hall")).evaluate(&lost), [], "the alarm of the segment is raised instead");
    assert_eq!(stale(None).evaluate(&lost), [ChangeKind::Raised]);
    let mut slow = silent();
    slow.gauges[0].poll_ms = 30_000;
    assert_eq!(stale(None).evaluate(&slow), [], "a gauge polled every 30 s is fresh after a minute");
    let mut never = silent();
    never.gauges[0].age_ms = None;
    assert_eq!(stale(None).evaluate(&never), [ChangeKind::Raised]);
}

#[test]
fn a_segment_that_does_not_run_or_is_absent_raises_an_alarm() {
    let down = || Fixture::new(vec![rule(Condition::SegmentDown { segment: "hall".to_owned() }, 0, 0)]);
    assert_eq!(down().evaluate(&inputs(1.0, Quality::Valid)), []);
    let mut lost = inputs(1.0, Quality::Valid);
    lost.segments[0].state = SegmentState::Waiting;
    lost.segments[0].problem = Some("the port is lost".to_owned());
    let mut fixture = down();
    assert_eq!(fixture.evaluate(&lost), [ChangeKind::Raised]);
    assert_eq!(fixture.status().text, "segment hall does not run: the port is lost");
    let now = fixture.now();
    assert_eq!(fixture.registry.evaluate(&inputs(1.0, Quality::Valid), now)[0].text, "");
    assert_eq!(down().evaluate(&Inputs::default()), [ChangeKind::Raised]);
}

#[test]
fn damaged_telegrams_are_counted_over_a_minute() {
    let damage = rule(Condition::DamagedTelegrams { segment: "hall".to_owned(), limit: 30.0 }, 0, 0);
    let run = |per_second: f64| {
        let mut fixture = Fixture::new(vec![damage.clone()]);
        let seen: Vec<_> = (0..180)
            .flat_map(|second| {
                let mut inputs = inputs(1.0, Quality::Valid);
                inputs.segments[0].damaged_telegrams = 1000 + (per_second * f64::from(second)) as u32;
                fixture.evaluate_for(&inputs, 1000)
            })
            .collect();
        (seen, fixture)
    };
    assert_eq!(run(0.5).0, []);
    let (seen, mut fixture) = run(0.6);
    assert_eq!(seen, [ChangeKind::Raised]);
    let mut anew = inputs(1.0, Quality::Valid);
    anew.segments[0].damaged_telegrams = 3;
    assert_eq!(fixture.evaluate(&anew), [ChangeKind::Returned], "a restarted master counts from zero");
}

#[test]
fn a_recorder_that_does_not_write_raises_an_alarm() {
    let mut fixture = Fixture::new(vec![rule(Condition::NotRecording, 0, 0)]);
    let full = Inputs { recorder_error: Some("the disk is full".to_owned()), ..Inputs::default() };
    assert_eq!((fixture.evaluate(&Inputs::default()), fixture.evaluate(&full)), (vec![], vec![ChangeKind::Raised]));
    assert_eq!(fixture.status().text, "the recorder does not write: the disk is full");
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
    assert_eq!(refused, "it is out-of-service by Eve already");
    // A step of the wall clock does not change the time out of service.
    fixture.wall_ms += 86_400_000;
    assert_eq!(fixture.evaluate_for(&inputs(2.0, Quality::Valid), 1), []);
    assert_eq!(
        fixture.evaluate(&inputs(2.0, Quality::Valid)),
        [ChangeKind::ReturnedToService, ChangeKind::Raised],
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
    assert_eq!(fixture.evaluate(&inputs(2.0, Quality::Valid)), [ChangeKind::Returned]);
    assert_eq!(
        fixture.registry.clone().reconfigure(Vec::new(), Vec::new(), now),
        [],
        "a normal alarm is removed without a change"
    );
    fixture.evaluate(&inputs(20.0, Quality::Valid));
    let gone = fixture.registry.reconfigure(Vec::new(), Vec::new(), now);
    assert_eq!(gone.iter().map(|change| change.kind).collect::<Vec<_>>(), [ChangeKind::Removed]);
}

#[test]
fn alarms_keep_their_state_over_a_restart() {
    for state in AlarmState::ALL {
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
        assert_eq!(seen, [ChangeKind::Raised][..usize::from(raised)], "{state:?}: an active alarm is not raised again");
    }
}

/// Random readings, acknowledgements, times out of service, clock steps and changed files.
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
    // Since when the condition is known to be met without interruption.
    let mut holds: Option<i64> = None;
    let (mut raised, mut acknowledged) = (0, 0);
    for _ in 0..400 {
        let pa = if random.bool() { 2.0 } else { 0.1 };
        for _ in 0..random.usize(1..12) {
            let quality = [Quality::Valid, Quality::Valid, Quality::Valid, Quality::Fault][random.usize(0..4)];
            let before = fixture.state();
            let now = fixture.now();
            let changes = fixture.registry.evaluate(&inputs(pa, quality), now);
            if quality == Quality::Valid {
                holds = (pa > 1.0).then(|| holds.unwrap_or(fixture.monotonic_ms));
            }
            for change in &changes {
                raised += usize::from(change.kind == ChangeKind::Raised);
                assert!(change.kind != ChangeKind::Returned || before.is_active(), "only an active alarm returns");
            }
            assert!(
                !before.needs_acknowledgement() || fixture.state().needs_acknowledgement(),
                "an evaluation never removes an unacknowledged alarm"
            );
            let long = holds.is_some_and(|since| fixture.monotonic_ms - since >= delay as i64 * 1000);
            let is_raised = fixture.state().is_active() || fixture.state() == AlarmState::OutOfService;
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
    match random.usize(0..8) {
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
        4 => fixture.wall_ms += random.i64(-10_000_000..10_000_000),
        5 => {
            let rule = fixture.registry.alarms()[0].rule().clone();
            fixture.registry.reconfigure(vec![Rule { priority: Priority::Low, ..rule }], Vec::new(), now);
        }
        _ => {}
    }
    false
}
