//! All conditions but limits.

use super::{Fixture, rule, series};
use crate::support::inputs::{inputs, silent};
use profivac_recorder::Quality;
use profivac_station::alarm::{AlarmChangeKind, Condition, Inputs, PointTest, Rule, Series};
use profivac_station::gateway_status::ArchiveState;
use profivac_station::view::{BusStationState, Gauge, SegmentState, WatchedParameter};
use std::sync::Arc;
use std::time::Duration;

/// At a good high vacuum 14 Piranis are below their range, and the ion gauges of a controller are off.
#[test]
fn a_gauge_below_its_range_or_off_reports_no_fault() {
    for quality in [Quality::Underrange, Quality::Overrange, Quality::Off, Quality::Missing] {
        let mut fixture = Fixture::new(vec![rule(Condition::Fault { gauge: "chamber".to_owned() }, 0, 0)]);
        assert_eq!(fixture.evaluate(&inputs(1.0, quality)), [], "{quality:?}");
    }
}

/// Inputs with three gauges a, b and c, which show these readings.
fn three(readings: [(f64, Quality); 3]) -> Inputs {
    let mut all = inputs(1.0, Quality::Valid);
    all.gauges.clear();
    for (name, (pa, quality)) in ["a", "b", "c"].into_iter().zip(readings) {
        let mut gauge = inputs(pa, quality).gauges.remove(0);
        name.clone_into(&mut gauge.name);
        name.clone_into(&mut gauge.readings[0].series);
        all.gauges.push(gauge);
    }
    all
}

#[test]
fn two_of_three_gauges_raise_an_alarm_and_one_does_not() {
    let condition = |name: &str| Condition::Above {
        series: Series { gauge: name.to_owned(), name: name.to_owned() },
        limit: 1.0,
        reset: 0.5,
    };
    let conditions = ["a", "b", "c"].map(condition).to_vec();
    let mut fixture = Fixture::new(vec![rule(Condition::Several { conditions, count: 2 }, 0, 0)]);
    let (high, between, low) = ((2.0, Quality::Valid), (0.7, Quality::Valid), (0.1, Quality::Valid));
    let unknown = (2.0, Quality::Fault);
    assert_eq!(fixture.evaluate(&three([high, low, low])), []);
    assert_eq!(fixture.evaluate(&three([high, unknown, low])), [], "one more may be above the limit, or not");
    assert_eq!(fixture.evaluate(&three([high, low, high])), [AlarmChangeKind::Raised]);
    assert_eq!(fixture.status().value, Some(2.0));
    let text = "2 of 3: a shows 2.00e-2 mbar, above the limit of 1.00e-2 mbar; c shows 2.00e-2 mbar, above the limit of 1.00e-2 mbar";
    assert_eq!(fixture.status().text, text);
    assert_eq!(fixture.evaluate(&three([high, low, between])), [], "the reset value counts");
    assert_eq!(fixture.evaluate(&three([high, unknown, low])), [], "the second may still be above the reset value");
    assert_eq!(fixture.evaluate(&three([high, low, low])), [AlarmChangeKind::Returned]);
}

/// A slave whose point speed has this value.
fn speed(number: Option<f64>, text: &str, quality: Quality) -> Inputs {
    let mut all = inputs(1.0, Quality::Valid);
    let point = WatchedParameter {
        target: "speed".to_owned(),
        name: "slot 1 octet 0".to_owned(),
        unit: Some("Hz"),
        number,
        text: text.to_owned(),
        quality,
        read_at: None,
        lost_at: None,
    };
    all.gauges[0].parameters = Arc::from([point]);
    all
}

#[test]
fn the_alarm_of_a_point_is_raised_beyond_its_limit_and_a_bad_value_decides_nothing() {
    let condition =
        |test| Condition::Point { gauge: "chamber".to_owned(), point: "speed".to_owned(), test, unit: Some("Hz") };
    let valid = |number: f64| speed(Some(number), &format!("{number} Hz"), Quality::Valid);
    let mut fixture = Fixture::new(vec![rule(condition(PointTest::Below { limit: 900.0, reset: 900.0 }), 0, 0)]);
    assert_eq!(fixture.evaluate(&valid(900.0)), []);
    assert_eq!(fixture.evaluate(&speed(None, "bad", Quality::Fault)), []);
    assert_eq!(fixture.evaluate(&valid(899.0)), [AlarmChangeKind::Raised]);
    assert_eq!((fixture.status().value, fixture.status().text.as_str()), (Some(899.0), "chamber: speed is 899 Hz"));
    assert_eq!(fixture.evaluate(&speed(None, "bad", Quality::Fault)), [], "a bad value does not end it");
    assert_eq!(fixture.evaluate(&valid(900.0)), [AlarmChangeKind::Returned]);

    let mut fixture = Fixture::new(vec![rule(condition(PointTest::Above { limit: 900.0, reset: 900.0 }), 0, 0)]);
    assert_eq!(fixture.evaluate(&valid(900.0)), []);
    assert_eq!(fixture.evaluate(&valid(901.0)), [AlarmChangeKind::Raised]);

    let above = PointTest::Above { limit: 900.0, reset: 890.0 };
    let mut fixture = Fixture::new(vec![rule(condition(above), 0, 0)]);
    assert_eq!(fixture.evaluate(&valid(895.0)), [], "the reset value raises nothing");
    assert_eq!(fixture.evaluate(&valid(901.0)), [AlarmChangeKind::Raised]);
    assert_eq!(fixture.evaluate(&valid(891.0)), [], "not back past the reset value");
    assert_eq!(fixture.evaluate(&valid(890.0)), [AlarmChangeKind::Returned]);

    let below = PointTest::Below { limit: 900.0, reset: 910.0 };
    let mut fixture = Fixture::new(vec![rule(condition(below), 0, 0)]);
    assert_eq!(fixture.evaluate(&valid(905.0)), []);
    assert_eq!(fixture.evaluate(&valid(899.0)), [AlarmChangeKind::Raised]);
    assert_eq!(fixture.evaluate(&valid(909.0)), []);
    assert_eq!(fixture.evaluate(&valid(910.0)), [AlarmChangeKind::Returned]);

    let mut fixture = Fixture::new(vec![rule(condition(PointTest::Is("off".to_owned())), 0, 0)]);
    assert_eq!(fixture.evaluate(&speed(Some(1.0), "on", Quality::Valid)), []);
    assert_eq!(fixture.evaluate(&speed(Some(0.0), "off", Quality::Valid)), [AlarmChangeKind::Raised]);
    assert_eq!(fixture.evaluate(&speed(Some(0.0), "off (uncertain)", Quality::Valid)), [], "it is off all the same");
    assert_eq!(fixture.evaluate(&speed(Some(1.0), "on (uncertain)", Quality::Valid)), [AlarmChangeKind::Returned]);
}

#[test]
fn an_invalid_reading_is_not_measurable_and_a_silent_gauge_is_stale() {
    let blind = || Fixture::new(vec![rule(not_measurable(series(), false), 0, 0)]);
    assert_eq!(blind().evaluate(&inputs(1.0, Quality::Fault)), [AlarmChangeKind::Raised]);
    assert_eq!(blind().evaluate(&inputs(1.0, Quality::Valid)), []);
    assert_eq!(blind().evaluate(&silent()), []);
    let series = Series { gauge: "chamber".to_owned(), name: "chamber.2".to_owned() };
    let mut fixture = Fixture::new(vec![rule(not_measurable(series, false), 0, 0)]);
    assert_eq!(fixture.evaluate(&inputs(1.0, Quality::Valid)), [AlarmChangeKind::Raised]);
    assert_eq!(fixture.status().text, "chamber has no series chamber.2");
}

/// A broken filament is one alarm, and its text names what is broken.
#[test]
fn a_fault_raises_its_own_alarm_and_no_second_one() {
    let mut broken = inputs(1.0, Quality::Fault);
    broken.gauges[0].state = BusStationState::Fault;
    broken.gauges[0].exceptions = vec!["ionisation part: electronics or sensor failure".to_owned()];
    let fault = rule(Condition::Fault { gauge: "chamber".to_owned() }, 0, 0);
    let blind = Rule { name: "blind".to_owned(), ..rule(not_measurable(series(), true), 0, 0) };
    let mut fixture = Fixture::new(vec![fault, blind.clone()]);
    assert_eq!(fixture.evaluate(&broken), [AlarmChangeKind::Raised]);
    assert_eq!(fixture.status().text, "chamber reports ionisation part: electronics or sensor failure");
    // A reading without a pressure that is no fault is still an alarm.
    let mut fixture = Fixture::new(vec![blind]);
    assert_eq!(fixture.evaluate(&broken), []);
    assert_eq!(fixture.evaluate(&inputs(1.0, Quality::Off)), [AlarmChangeKind::Raised]);
    assert_eq!(fixture.evaluate(&broken), [], "a fault ends it no more than it raises it");
}

fn not_measurable(series: Series, has_fault_alarm: bool) -> Condition {
    Condition::NotMeasurable { series, limits: vec![1.0], has_fault_alarm }
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
    assert_eq!(still, [AlarmChangeKind::Returned]);
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
        [AlarmChangeKind::Raised]
    );
    assert_eq!(fixture.status().text, "chamber reports filament broken, Pirani error");
    assert_eq!(fixture.evaluate(&with(BusStationState::Missing, &[])), [], "a missing gauge does not clear its fault");
    let now = fixture.now();
    let changes = fixture.registry.evaluate(&with(BusStationState::DataExchange, &[]), now);
    assert_eq!(changes.iter().map(|change| change.kind).collect::<Vec<_>>(), [AlarmChangeKind::Returned]);
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
    assert_eq!(fixture.evaluate(&silent()), [AlarmChangeKind::Raised]);
    assert_eq!(fixture.status().text, "chamber gives no data, the last are 60 s old");
    let now = fixture.now();
    assert_eq!(fixture.registry.evaluate(&inputs(1.0, Quality::Valid), now)[0].text, "");
    let mut lost = silent();
    lost.segments[0].state = SegmentState::Waiting;
    assert_eq!(stale(Some("hall")).evaluate(&lost), [], "the alarm of the segment is raised instead");
    assert_eq!(stale(None).evaluate(&lost), [AlarmChangeKind::Raised]);
    let mut slow = silent();
    slow.gauges[0].poll_ms = 30_000;
    assert_eq!(stale(None).evaluate(&slow), [], "a gauge polled every 30 s is fresh after a minute");
    let mut never = silent();
    never.gauges[0].age_ms = None;
    assert_eq!(stale(None).evaluate(&never), [AlarmChangeKind::Raised]);
}

/// Gauges of the segment hall that have given no data since the start; those in `awaited` were not asked yet.
fn silent_from_start(names: &[&str], awaited: &[&str]) -> Inputs {
    let mut all = inputs(1.0, Quality::Stale);
    let silent = |name: &&str| {
        let is_awaited = awaited.contains(name);
        let problem = (!is_awaited).then(|| "no answer".to_owned());
        Gauge { name: (*name).to_owned(), age_ms: None, problem, is_awaited, ..all.gauges[0].clone() }
    };
    let gauges = names.iter().map(silent).collect();
    all.gauges = gauges;
    all
}

fn no_data(name: &str) -> Rule {
    let condition = Condition::Stale { gauge: name.to_owned(), behind_segment: Some("hall".to_owned()) };
    Rule { name: format!("{name}: no data"), ..rule(condition, 0, 0) }
}

#[test]
fn a_gauge_is_missed_when_the_first_round_of_its_segment_is_over() {
    let mut fixture = Fixture::new(vec![no_data("a"), no_data("b")]);
    let mut started = silent_from_start(&["a", "b"], &["b"]);
    assert_eq!(fixture.evaluate(&started), [], "none has answered, and b was not asked yet");
    started.gauges[1].age_ms = Some(10);
    assert_eq!(fixture.evaluate(&started), [AlarmChangeKind::Raised], "b answers, so a is missing");
    let mut other = Fixture::new(vec![no_data("a"), no_data("b")]);
    let mut late = silent_from_start(&["a", "b"], &["b"]);
    late.gauges[0].age_ms = Some(10);
    assert_eq!(other.evaluate(&late), [], "b was not asked yet");
}

/// A silent line: no slave answers, but the master is in the ring.
#[test]
fn a_segment_that_never_starts_is_one_alarm() {
    let down =
        Rule { name: "hall: down".to_owned(), ..rule(Condition::SegmentDown { segment: "hall".to_owned() }, 0, 0) };
    let names = ["a", "b", "c"];
    let rules: Vec<_> = std::iter::once(down).chain(names.map(no_data)).collect();
    let mut fixture = Fixture::new(rules.clone());
    assert_eq!(fixture.evaluate(&silent_from_start(&names, &["c"])), [], "the first round is not over");
    assert_eq!(fixture.evaluate(&silent_from_start(&names, &[])), [AlarmChangeKind::Raised]);
    let text = "segment hall gives no data: none of its 3 gauges has answered since the start; a: no answer";
    assert_eq!(fixture.status().text, text);
    assert_eq!(fixture.evaluate(&silent_from_start(&names, &["c"])), [], "a gauge that is added ends no alarm");
    let mut one = silent_from_start(&names, &[]);
    one.gauges[2].age_ms = Some(10);
    let changes = fixture.evaluate(&one);
    assert_eq!(
        changes,
        [AlarmChangeKind::Returned, AlarmChangeKind::Raised, AlarmChangeKind::Raised],
        "a and b are missing"
    );
    // One gauge alone has its own alarm.
    let mut alone = Fixture::new(rules[..2].to_vec());
    assert_eq!(alone.evaluate(&silent_from_start(&["a"], &[])), [AlarmChangeKind::Raised]);
}

#[test]
fn a_segment_that_does_not_run_or_is_absent_raises_an_alarm() {
    let down = || Fixture::new(vec![rule(Condition::SegmentDown { segment: "hall".to_owned() }, 0, 0)]);
    assert_eq!(down().evaluate(&inputs(1.0, Quality::Valid)), []);
    let mut lost = inputs(1.0, Quality::Valid);
    lost.segments[0].state = SegmentState::Waiting;
    lost.segments[0].problem = Some("the port is lost".to_owned());
    let mut fixture = down();
    assert_eq!(fixture.evaluate(&lost), [AlarmChangeKind::Raised]);
    assert_eq!(fixture.status().text, "segment hall does not run: the port is lost");
    let now = fixture.now();
    assert_eq!(fixture.registry.evaluate(&inputs(1.0, Quality::Valid), now)[0].text, "");
    assert_eq!(down().evaluate(&Inputs::default()), [AlarmChangeKind::Raised]);
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
    assert_eq!(seen, [AlarmChangeKind::Raised]);
    let mut anew = inputs(1.0, Quality::Valid);
    anew.segments[0].damaged_telegrams = 3;
    assert_eq!(fixture.evaluate(&anew), [AlarmChangeKind::Returned], "a restarted master counts from zero");
}

#[test]
fn a_recorder_that_does_not_write_raises_an_alarm() {
    let mut fixture = Fixture::new(vec![rule(Condition::NotRecording, 0, 0)]);
    let full = Inputs { recorder_error: Some("the disk is full".to_owned()), ..Inputs::default() };
    assert_eq!(
        (fixture.evaluate(&Inputs::default()), fixture.evaluate(&full)),
        (vec![], vec![AlarmChangeKind::Raised])
    );
    assert_eq!(fixture.status().text, "the recorder does not write: the disk is full");
}

#[test]
fn a_damaged_database_raises_an_alarm_that_a_check_without_damage_clears() {
    let mut fixture = Fixture::new(vec![rule(Condition::DatabaseDamaged, 0, 0)]);
    let damaged = Inputs { damage: Some("the database is damaged: page 7".to_owned()), ..Inputs::default() };
    let sound = Inputs::default();
    let seen = [&sound, &damaged, &damaged, &sound].map(|inputs| fixture.evaluate(inputs));
    assert_eq!(seen, [vec![], vec![AlarmChangeKind::Raised], vec![], vec![AlarmChangeKind::Returned]]);
    assert!(fixture.status().text.starts_with("the database is damaged: page 7"), "{}", fixture.status().text);
}

#[test]
fn an_archive_that_is_silent_for_hours_or_has_a_problem_raises_an_alarm() {
    let of = |hours: f64, problem: Option<&str>| {
        let silence = Duration::from_secs_f64(3_600.0 * hours);
        Inputs { archive: Some(ArchiveState { silence, problem: problem.map(str::to_owned) }), ..Inputs::default() }
    };
    let mut fixture = Fixture::new(vec![rule(Condition::NotArchived { limit: 4.0 }, 0, 0)]);
    assert_eq!(fixture.evaluate(&of(4.0, None)), []);
    assert_eq!(fixture.evaluate(&of(4.1, None)), [AlarmChangeKind::Raised]);
    assert_eq!(fixture.status().text, "the archive has not answered for 4.1 h");
    assert_eq!(fixture.evaluate(&of(0.0, None)), [AlarmChangeKind::Returned]);
    assert_eq!(fixture.evaluate(&of(0.0, Some("2 batches were put aside"))), [AlarmChangeKind::Raised]);
    assert_eq!(fixture.status().text, "2 batches were put aside");
}
