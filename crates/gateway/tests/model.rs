//! The points of a station, and what changes between two snapshots.

#![allow(clippy::unwrap_used, clippy::panic, clippy::indexing_slicing, reason = "a test")]

use profivac_client::cyclic::IntegerRange;
use profivac_devices::Principle;
use profivac_gateway::model::Modeller;
use profivac_gateway::{Inputs, Signal, Snapshot, State, Subject, Value};
use profivac_recorder::{Micros, Quality};
use profivac_station::alarm::{AlarmState, Priority};
use profivac_station::view::BusStationState;
use std::path::Path;
use std::sync::Arc;
use std::time::Duration;

const FILE: &str = r#"
[[segment]]
name = "hall"
port = "sim:hall.toml"

[[segment.gauge]]
name = "chamber"
address = 5
device = "bcg450"

[[segment.gauge]]
name = "fore line"
address = 6
device = "tpg300"

[[alarm]]
name = "Chamber high"
gauge = "chamber"
above = "1e-3 mbar"
priority = "high"

[[alarm]]
name = "Chamber not pumped"
gauge = "chamber"
above = "1e-4 mbar"
priority = "low"
"#;

/// A reading of a gauge that is polled every 200 ms is stale from this age on.
const STALE_AFTER: Duration = Duration::from_secs(3);

fn planned() -> Inputs {
    Inputs::planned(&profivac_config::parse(FILE, Path::new("plant.toml")).unwrap())
}

/// The gauge chamber measures this pressure.
fn measuring(pa: f64, read_at: i64) -> Inputs {
    let mut inputs = planned();
    let gauge = inputs.gauges.iter_mut().find(|gauge| gauge.name == "chamber").unwrap();
    gauge.state = BusStationState::DataExchange;
    (gauge.age_ms, gauge.read_at) = (Some(10), Some(Micros(read_at)));
    let reading = &mut gauge.readings[0];
    (reading.quality, reading.pa) = (Quality::Valid, Some(pa));
    inputs
}

fn position(snapshot: &Snapshot, subject: &str, signal: Signal) -> usize {
    let is_it = |(point, _): (&profivac_gateway::Point, _)| point.subject.name() == subject && point.signal == signal;
    snapshot.iter().position(is_it).unwrap_or_else(|| panic!("{subject} has no {signal:?}"))
}

#[test]
fn a_station_that_has_not_started_has_all_its_points_without_values() {
    let snapshot = Modeller::default().next(planned(), Micros(1));
    let pressures: Vec<_> = snapshot.iter().filter(|(point, _)| point.signal == Signal::Pressure).collect();
    let names: Vec<_> = pressures.iter().map(|(point, _)| point.subject.name()).collect();
    assert_eq!(names, ["chamber", "fore line.1", "fore line.2", "fore line.3", "fore line.4"]);
    assert!(pressures.iter().all(|(_, value)| value.value == Value::None && value.state == State::Stale));
    assert!(pressures.iter().all(|(point, _)| point.is_simulated));
    let Subject::Reading { channel, .. } = &pressures[2].0.subject else { panic!("a reading") };
    assert_eq!(*channel, Some(2));
}

#[test]
fn the_pressure_has_the_range_of_the_manual_and_the_limits_of_its_alarms() {
    let snapshot = Modeller::default().next(planned(), Micros(1));
    let point = &snapshot.points[position(&snapshot, "chamber", Signal::Pressure)];
    // BCG450: 5e-10 to 1500 mbar. Clients show each digit of the number.
    assert_eq!(point.range, Some((5e-8, 1.5e5)));
    let close = |limit: Option<f64>, pa: f64| (limit.unwrap() / pa - 1.0).abs() < 1e-9;
    assert!(close(point.limits.high_high, 0.1) && close(point.limits.high, 0.01), "{:?}", point.limits);
    assert_eq!((point.limits.low, point.limits.low_low), (None, None));
    let controller = &snapshot.points[position(&snapshot, "fore line.1", Signal::Pressure)];
    assert_eq!(controller.range, None, "the controller accepts several gauges");
    assert_eq!(controller.display_range(), Some((1e-9, 1e5)), "a client that draws a scale needs its ends");
    assert_eq!(point.display_range(), point.range);
    let state = &snapshot.points[position(&snapshot, "fore line.1", Signal::State)];
    assert_eq!(state.display_range(), None);
}

/// A telegram with integers in Pa holds 0.01 to 327.67 mbar, whatever the gauge measures.
#[test]
fn the_range_of_a_pressure_ends_where_the_integers_of_its_telegram_end() {
    let (mut modeller, mut inputs) = (Modeller::default(), planned());
    let model = inputs.gauges[0].model.unwrap();
    let mut range = |unit: &str| {
        // `5 T3/T6 PKW int`
        let (configuration, unit) = (&model.configurations[4], model.unit_named(unit).unwrap());
        inputs.gauges[0].integers = IntegerRange::of(model, configuration, unit);
        let snapshot = modeller.next(inputs.clone(), Micros(1));
        let range = |signal| snapshot.points[position(&snapshot, "chamber", signal)].range.unwrap();
        (range(Signal::Pressure), range(Signal::PressureLog10))
    };
    let close = |range: (f64, f64), low: f64, high: f64| {
        assert!((range.0 / low - 1.0).abs() < 1e-5 && (range.1 / high - 1.0).abs() < 1e-5, "{range:?} {low} {high}");
    };
    let (pascals, decades) = range("Pascal");
    close(pascals, 1.0, 32_767.0);
    assert!(decades.0.abs() < 1e-9 && (decades.1 - 32_767_f64.log10()).abs() < 1e-9, "{decades:?}");
    close(range("Torr").0, 133.322_37, 1.5e5);
    close(range("COUNTS").0, 5e-8, 1.5e5);
}

#[test]
fn a_change_is_a_new_version_with_the_time_of_the_reading_and_a_missed_one_is_counted() {
    let mut modeller = Modeller::default();
    let first = modeller.next(measuring(1.0, 1_000), Micros(5_000));
    let index = position(&first, "chamber", Signal::Pressure);
    let same = modeller.next(measuring(1.0, 2_000), Micros(6_000));
    assert!(same.has_points_of(&first));
    let changed: Vec<_> = same.changes_since(&first).map(|(index, _)| same.points[index].signal).collect();
    assert_eq!(changed, [Signal::LastReading], "the time of the reading is a point of its own");
    assert_eq!((same.values[index].at, same.values[index].version), (Some(Micros(2_000)), first.values[index].version));
    let _second = modeller.next(measuring(2.0, 3_000), Micros(7_000));
    let third = modeller.next(measuring(3.0, 4_000), Micros(8_000));
    let missed = third.changes_since(&same).find(|(changed, _)| *changed == index);
    assert_eq!(missed, Some((index, 1)), "one update was missed");
    assert_eq!(third.values[index].value, Value::Float(3.0));
    assert_eq!(third.values[index].at, Some(Micros(4_000)), "the time of the reading, not of the snapshot");
}

/// A combined gauge changes its sensor with the pressure. Sparkplug would publish new births each time if the points were others.
#[test]
fn another_sensor_of_a_combined_gauge_keeps_the_points() {
    let measured_by = |principle| {
        let mut inputs = measuring(1.0, 1_000);
        let gauge = inputs.gauges.iter_mut().find(|gauge| gauge.name == "chamber").unwrap();
        gauge.readings.iter_mut().for_each(|reading| reading.principle = Some(principle));
        inputs
    };
    let mut modeller = Modeller::default();
    let before = modeller.next(measured_by(Principle::Pirani), Micros(5_000));
    let after = modeller.next(measured_by(Principle::HotCathode), Micros(6_000));
    assert!(after.points == before.points, "the points are described as before");
}

#[test]
fn a_gauge_that_is_lost_keeps_its_points_and_loses_its_value() {
    let mut modeller = Modeller::default();
    let before = modeller.next(measuring(1.0, 1_000), Micros(5_000));
    let mut lost = measuring(1.0, 1_000);
    let gauge = lost.gauges.iter_mut().find(|gauge| gauge.name == "chamber").unwrap();
    gauge.readings.clear();
    gauge.state = BusStationState::Missing;
    let after = modeller.next(lost, Micros(9_000));
    assert!(after.has_points_of(&before));
    let value = &after.values[position(&after, "chamber", Signal::Pressure)];
    assert_eq!((&value.value, value.state), (&Value::None, State::Stale));
}

#[test]
fn an_old_reading_is_stale_although_its_segment_says_nothing() {
    let mut inputs = measuring(1.0, 1_000);
    inputs.gauges[0].age_ms = Some(inputs.gauges[0].stale_after_ms + 1);
    let snapshot = Modeller::default().next(inputs, Micros(1));
    let value = &snapshot.values[position(&snapshot, "chamber", Signal::Pressure)];
    assert_eq!((&value.value, value.state), (&Value::None, State::Stale));
    assert_eq!(value.at, Some(Micros(1_000).after(STALE_AFTER)), "it was stale from then on");
}

/// An archiver keeps one event for each time: a loss with the time of the last reading would not be stored.
#[test]
fn a_loss_and_the_start_that_follows_have_the_times_at_which_the_station_decided_them() {
    let mut modeller = Modeller::default();
    let mut inputs = measuring(1.0, 1_000);
    let times = |snapshot: &Snapshot| {
        [Signal::Pressure, Signal::PressureLog10, Signal::State, Signal::StateText, Signal::Usable, Signal::Quality]
            .map(|signal| snapshot.values[position(snapshot, "chamber", signal)].at)
    };
    assert_eq!(times(&modeller.next(inputs.clone(), Micros(2_000))), [Some(Micros(1_000)); 6]);
    inputs.gauges[0].readings[0] =
        profivac_station::view::Reading { pa: None, quality: Quality::Stale, ..inputs.gauges[0].readings[0].clone() };
    for (state, lost_at, shown) in [
        (BusStationState::Missing, 5_000, State::Stale),
        (BusStationState::Starting, 7_000, State::Starting),
        (BusStationState::Missing, 8_000, State::Stale),
    ] {
        (inputs.gauges[0].state, inputs.gauges[0].lost_at) = (state, Some(Micros(lost_at)));
        let snapshot = modeller.next(inputs.clone(), Micros(9_000));
        assert_eq!(times(&snapshot), [Some(Micros(lost_at)); 6], "{state:?}");
        let last = &snapshot.values[position(&snapshot, "chamber", Signal::LastReading)];
        assert_eq!((&last.value, last.state), (&Value::Time(Micros(1_000)), shown), "the last reading stays");
    }
}

#[test]
fn a_changed_file_keeps_the_values_of_the_points_that_stay() {
    let mut modeller = Modeller::default();
    let before = modeller.next(measuring(1.0, 1_000), Micros(5_000));
    let mut fewer = measuring(1.0, 1_000);
    fewer.gauges.retain(|gauge| gauge.name == "chamber");
    let after = modeller.next(fewer, Micros(6_000));
    assert!(!after.has_points_of(&before));
    let version = |snapshot: &Snapshot| snapshot.values[position(snapshot, "chamber", Signal::Pressure)].version;
    assert_eq!(version(&after), version(&before));
}

#[test]
fn the_parameters_of_a_gauge_are_points_of_their_own_with_the_time_of_their_reading() {
    let mut inputs = measuring(1.0, 1_000);
    let of_degas = |gauge: &profivac_station::view::Gauge| {
        gauge.parameters.iter().position(|parameter| parameter.target == "ba.degas-status").unwrap()
    };
    let snapshot = Modeller::default().next(inputs.clone(), Micros(1));
    let value = &snapshot.values[position(&snapshot, "ba.degas-status", Signal::ParameterNumber)];
    assert_eq!((&value.value, value.state), (&Value::None, State::NotRead), "not read yet");
    let gauge = &mut inputs.gauges[0];
    let index = of_degas(gauge);
    let degas = &mut Arc::make_mut(&mut gauge.parameters)[index];
    degas.quality = Quality::Valid;
    (degas.number, degas.text, degas.read_at) = (Some(3.0), "on".to_owned(), Some(Micros(77)));
    let snapshot = Modeller::default().next(inputs.clone(), Micros(100));
    let value = &snapshot.values[position(&snapshot, "ba.degas-status", Signal::ParameterNumber)];
    assert_eq!((&value.value, value.state, value.at), (&Value::Float(3.0), State::Ok, Some(Micros(77))));
    let mut old = inputs.clone();
    let degas = &mut Arc::make_mut(&mut old.gauges[0].parameters)[index];
    (degas.quality, degas.number, degas.text) = (Quality::Stale, None, String::new());
    degas.lost_at = Some(Micros(137));
    let snapshot = Modeller::default().next(old, Micros(150));
    for signal in [Signal::ParameterNumber, Signal::ParameterText] {
        let value = &snapshot.values[position(&snapshot, "ba.degas-status", signal)];
        let expected = (&Value::None, State::NotRead, Some(Micros(137)));
        assert_eq!((&value.value, value.state, value.at), expected, "it was read long ago: the time of that decision");
    }
    (inputs.gauges[0].state, inputs.gauges[0].lost_at) = (BusStationState::Missing, Some(Micros(150)));
    let snapshot = Modeller::default().next(inputs, Micros(200));
    let value = &snapshot.values[position(&snapshot, "ba.degas-status", Signal::ParameterText)];
    assert_eq!((&value.value, value.state), (&Value::None, State::Stale), "a missing gauge may have lost it");
    assert_eq!(value.at, Some(Micros(150)), "a value is lost when its gauge is lost");
}

/// A client that keeps one event for each time would lose the values of an alarm that stands for hours.
#[test]
fn the_value_of_an_alarm_has_the_time_of_the_reading_and_a_changed_limit_that_of_its_change() {
    let mut modeller = Modeller::default();
    let inputs = |pa: f64, read_at: i64| {
        let mut inputs = measuring(pa, read_at);
        for alarm in &mut inputs.alarms {
            (alarm.since_ms, alarm.value) = (Some(1), Some(pa));
        }
        inputs
    };
    let at = |snapshot: &Snapshot, signal| snapshot.values[position(snapshot, "Chamber high", signal)].at;
    let first = modeller.next(inputs(0.4, 2_000), Micros(2_500));
    assert_eq!(at(&first, Signal::AlarmValue), Some(Micros(2_000)));
    let second = modeller.next(inputs(0.7, 3_000), Micros(3_500));
    assert_eq!(at(&second, Signal::AlarmValue), Some(Micros(3_000)));
    assert_eq!(at(&second, Signal::AlarmState), Some(Micros(1_000)), "the alarm has not changed");
    assert_eq!(at(&second, Signal::AlarmLimit), Some(Micros(2_500)));
    let mut changed = inputs(0.7, 3_000);
    let alarm = changed.alarms.iter_mut().find(|alarm| alarm.name == "Chamber high").unwrap();
    (alarm.limit, alarm.priority) = (Some(0.2), Priority::Low);
    let third = modeller.next(changed, Micros(9_000));
    for signal in [Signal::AlarmLimit, Signal::Priority] {
        assert_eq!(at(&third, signal), Some(Micros(9_000)), "{signal:?}");
    }
    let mut lost = inputs(0.7, 3_000);
    lost.alarms.iter_mut().for_each(|alarm| alarm.value = None);
    (lost.gauges[0].state, lost.gauges[0].lost_at) = (BusStationState::Missing, Some(Micros(9_500)));
    assert_eq!(at(&modeller.next(lost, Micros(9_700)), Signal::AlarmValue), Some(Micros(9_500)), "lost with its gauge");
}

#[test]
fn the_text_of_an_alarm_that_is_not_active_says_that_it_was_true_when_the_alarm_was_raised() {
    let shown = |state| {
        let mut inputs = measuring(1.0, 1_000);
        let alarm = inputs.alarms.iter_mut().find(|alarm| alarm.name == "Chamber high").unwrap();
        (alarm.state, alarm.text) = (state, "chamber shows 1 mbar".to_owned());
        let snapshot = Modeller::default().next(inputs, Micros(2_000));
        snapshot.values[position(&snapshot, "Chamber high", Signal::AlarmText)].value.clone()
    };
    let text = |text: &str| Value::Text(Arc::from(text));
    for state in [AlarmState::Unacknowledged, AlarmState::Acknowledged] {
        assert_eq!(shown(state), text("chamber shows 1 mbar"), "{state:?}");
    }
    for state in [AlarmState::Normal, AlarmState::Returned, AlarmState::Suppressed, AlarmState::OutOfService] {
        assert_eq!(shown(state), text("when raised: chamber shows 1 mbar"), "{state:?}");
    }
}

#[test]
fn a_number_of_a_parameter_and_of_an_alarm_has_the_unit_in_which_people_read_it() {
    let snapshot = Modeller::default().next(planned(), Micros(1));
    let unit = |subject: &str, signal| snapshot.points[position(&snapshot, subject, signal)].unit;
    assert_eq!(unit("setpoint-a.percentage-of-atmosphere", Signal::ParameterPercentage), Some("%"));
    assert_eq!(unit("setpoint-a.process-value", Signal::ParameterPressure), Some("Pa"));
    assert_eq!(unit("setpoint-a.status", Signal::ParameterNumber), None);
    for signal in [Signal::AlarmValue, Signal::AlarmLimit, Signal::RaisedValue] {
        assert_eq!(unit("Chamber high", signal), Some("Pa"), "{signal:?}");
    }
    assert_eq!(unit("Chamber high", Signal::AlarmState), None);
    assert_eq!(unit("hall", Signal::Baud), Some("bit/s"));
}

#[test]
fn the_logarithm_of_a_pressure_has_the_range_in_decades() {
    let snapshot = Modeller::default().next(planned(), Micros(1));
    let range = |subject: &str| snapshot.points[position(&snapshot, subject, Signal::PressureLog10)].range;
    let (low, high) = range("chamber").unwrap();
    assert!((low - 5e-8_f64.log10()).abs() < 1e-9 && (high - 1.5e5_f64.log10()).abs() < 1e-9, "{low} {high}");
    assert_eq!(range("fore line.1"), None);
}

/// A client that shows no exponent shows two digits at the lower end of the range.
#[test]
fn a_number_has_the_decimals_that_the_lower_end_of_its_range_needs() {
    let snapshot = Modeller::default().next(planned(), Micros(1));
    let point = |subject: &str, signal| &snapshot.points[position(&snapshot, subject, signal)];
    let pressure = point("chamber", Signal::Pressure);
    // 5e-8 Pa is 5e-10 mbar.
    assert_eq!((pressure.decimals(), pressure.decimals_in(100.0)), (9, 11));
    assert_eq!(point("fore line.1", Signal::Pressure).decimals(), 10, "a controller has gauges of unknown ranges");
    assert_eq!(point("chamber", Signal::PressureLog10).decimals(), 2);
    assert_eq!(point("setpoint-a.percentage-of-atmosphere", Signal::ParameterPercentage).decimals(), 1);
    for code in ["ba.emission-status", "ba.degas-status", "setpoint-a.status"] {
        assert_eq!(point(code, Signal::ParameterNumber).decimals(), 0, "{code}: a code is no 3.00");
    }
    assert_eq!(point("hall", Signal::CycleTime).decimals(), 6);
    assert_eq!(point("chamber", Signal::State).decimals(), 0);
}

/// A TPG300 or TPG500 has no alarms of its own: the status of a channel reports its defect.
#[test]
fn a_defect_of_a_channel_is_a_fault_and_a_number_that_is_no_pressure_is_invalid() {
    for (is_defect, expected) in [(true, State::Fault), (false, State::Invalid)] {
        let mut inputs = planned();
        let gauge = inputs.gauges.iter_mut().find(|gauge| gauge.name == "fore line").unwrap();
        gauge.state = BusStationState::Fault;
        (gauge.age_ms, gauge.read_at) = (Some(10), Some(Micros(1)));
        let reading = &mut gauge.readings[0];
        (reading.quality, reading.is_defect) = (Quality::Fault, is_defect);
        assert!(gauge.exceptions.is_empty());
        let snapshot = Modeller::default().next(inputs, Micros(1));
        assert_eq!(snapshot.values[position(&snapshot, "fore line.1", Signal::Pressure)].state, expected);
    }
}

#[test]
fn the_state_in_words_has_the_whole_cause() {
    let mut inputs = measuring(1.0, 1_000);
    let reading = &mut inputs.gauges[0].readings[0];
    let cause = "a cause that is longer than the 39 octets of a text of EPICS";
    (reading.quality, reading.pa, reading.cause) = (Quality::Off, None, Some(cause.to_owned()));
    let snapshot = Modeller::default().next(inputs, Micros(1));
    let text = &snapshot.values[position(&snapshot, "chamber", Signal::StateText)].value;
    assert_eq!(text.to_string(), format!("Off: {cause}"));
}

/// An alarm about a line belongs to a segment; a changed file may give it another one.
#[test]
fn an_alarm_that_moves_to_another_segment_is_described_again() {
    let mut modeller = Modeller::default();
    let alarm_of = |segment: &str| {
        let mut inputs = planned();
        inputs.alarms.truncate(1);
        inputs.alarms[0].segment = Some(segment.to_owned());
        inputs
    };
    modeller.next(alarm_of("hall"), Micros(1));
    let moved = modeller.next(alarm_of("lab"), Micros(2));
    let point = &moved.points[position(&moved, "Chamber high", Signal::AlarmState)];
    assert_eq!(point.segment.as_deref(), Some("lab"));
}

/// The labels of the gauge chamber, as the file has them.
fn labelled(labels: &str) -> Inputs {
    let file = FILE.replacen("device = \"bcg450\"", &format!("device = \"bcg450\"\n{labels}"), 1);
    Inputs::planned(&profivac_config::parse(&file, Path::new("plant.toml")).unwrap())
}

const LABELS: [Signal; 5] = [Signal::Group, Signal::Tags, Signal::Location, Signal::Calibrated, Signal::CalibrationDue];

#[test]
fn the_labels_of_a_gauge_are_points_as_far_as_the_file_has_them() {
    let label = |snapshot: &Snapshot, signal| {
        let mut found = snapshot.iter().filter(|(point, _)| point.signal == signal);
        let text = found.next().map(|(point, value)| (point.subject.name().to_owned(), value.value.clone()));
        assert_eq!(found.count(), 0, "only one gauge has labels");
        text
    };
    let mut modeller = Modeller::default();
    let all = "group = \"target\"\ntags = [\"bake-out\", \"interlock\"]\nlocation = \"hall, platform\"\n\
               calibrated = 2026-05-01\ncalibration-interval = \"365 days\"";
    let snapshot = modeller.next(labelled(all), Micros(1));
    let texts = ["target", "bake-out, interlock", "hall, platform", "2026-05-01", "2027-05-01"];
    for (signal, text) in LABELS.into_iter().zip(texts) {
        assert_eq!(label(&snapshot, signal), Some(("chamber".to_owned(), Value::Text(text.into()))), "{signal:?}");
    }
    // The file was read again: another place, and nothing else.
    let snapshot = modeller.next(labelled("location = \"lab\""), Micros(2));
    let found = LABELS.map(|signal| label(&snapshot, signal));
    assert_eq!(found, [None, None, Some(("chamber".to_owned(), Value::Text("lab".into()))), None, None]);
    let snapshot = modeller.next(planned(), Micros(3));
    assert_eq!(LABELS.map(|signal| label(&snapshot, signal)), [const { None }; 5]);
}
