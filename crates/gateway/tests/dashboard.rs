//! Every value that the dashboard gets from the API is a point. The views are taken apart field by field, without `..`: a new field does
//! not compile here until it is a point, or is named as something else than a value.

#![allow(clippy::unwrap_used, clippy::panic, clippy::indexing_slicing, clippy::expect_used, reason = "a test")]

use profivac_gateway::model::Modeller;
use profivac_gateway::signal::{ALARM_STATES, GAUGE_STATES, PRIORITIES, QUALITIES, SEGMENT_STATES};
use profivac_gateway::{Inputs, Signal, Snapshot, Value};
use profivac_listen::counts::Counts;
use profivac_listen::gauge::Origin;
use profivac_listen::report::{BusReport, Distribution, StationReport};
use profivac_listen::station::StationState;
use profivac_recorder::{Micros, Quality};
use profivac_station::alarm::AlarmState;
use profivac_station::alarm::view::{AlarmView, SuppressionView};
use profivac_station::view::{
    self, BusStationState, Gauge, Reading, RecorderView, Segment, SegmentState, WatchedParameter,
};
use std::path::Path;
use std::sync::Arc;

const FILE: &str = r#"
[[segment]]
name = "plc"
port = "/dev/ttyUSB0"
listen-only = true

[[segment.gauge]]
name = "furnace"
address = 12
device = "bcg450"

[[segment]]
name = "hall"
port = "/dev/ttyUSB1"

[[segment.gauge]]
name = "chamber"
address = 5
device = "bcg450"

[[alarm]]
name = "High"
gauge = "chamber"
above = "1e-3 mbar"
message = "Close valve 3."
"#;

fn times(longest_us: u64) -> Distribution {
    Distribution { count: 1, mean_us: Some(longest_us / 2), max_us: Some(longest_us), ..Distribution::default() }
}

fn on_line(address: u8, unit_origin: Origin) -> StationReport {
    let total = Counts { requests: 100, lost: 3, repeated: 4, damaged: 5, refused: 6, ..Counts::default() };
    StationReport {
        address,
        state: StationState::Exchanging,
        devices: vec!["bcg450".to_owned()],
        ident: Some("0x08E6".to_owned()),
        owner: Some(1),
        configuration_origin: Some(Origin::Heard),
        unit: Some("Torr".to_owned()),
        unit_origin: Some(unit_origin),
        total,
        last_minute: Counts::default(),
        repeated_percent: 4.0,
        longest_sequence: 2,
        diagnosis: vec!["a defect".to_owned()],
        diagnosis_history: Vec::new(),
        interval: Distribution::default(),
        unknown: Vec::new(),
    }
}

fn line(stations: Vec<StationReport>) -> Arc<BusReport> {
    Arc::new(BusReport {
        baud: 19_200,
        observed_ms: 61_500,
        telegrams: 1000,
        octets: 9000,
        damaged: 7,
        damaged_last_minute: 2,
        damaged_unattributed: 1,
        recorder_octets: 65_536,
        ring: vec![1, 3],
        cycle: times(20_000),
        rotation: times(30_000),
        masters: Vec::new(),
        stations,
        parameters: Vec::new(),
        events: Vec::new(),
    })
}

/// A plant in which every field has a value that can be recognised.
fn inputs() -> Inputs {
    let mut inputs = Inputs::planned(&profivac_config::parse(FILE, Path::new("plant.toml")).unwrap());
    inputs.station.started_ms = 1000;
    inputs.station.now_ms = 91_000;
    inputs.station.recorder = RecorderView {
        last_write_ms: Some(5000),
        error: Some("disk full".to_owned()),
        lost_samples: 8,
        lost_events: 9,
        last_check_ms: Some(6000),
        damage: None,
    };
    for segment in &mut inputs.segments {
        segment.state = SegmentState::Running;
        segment.problem = Some("a problem".to_owned());
        segment.cycle_ms = Some(12.5);
    }
    for gauge in &mut inputs.gauges {
        gauge.state = BusStationState::DataExchange;
        (gauge.age_ms, gauge.read_at) = (Some(10), Some(Micros(77_000_000)));
        gauge.problem = Some("none".to_owned());
        gauge.exceptions = vec!["defect".to_owned()];
        gauge.warnings = vec!["warning".to_owned()];
        let reading = &mut gauge.readings[0];
        (reading.quality, reading.pa, reading.corrected_pa) = (Quality::Valid, Some(0.5), Some(0.6));
        if let Some(parameter) = Arc::make_mut(&mut gauge.parameters).first_mut() {
            (parameter.number, parameter.quality, parameter.read_at) = (Some(4.0), Quality::Valid, Some(Micros(1)));
            "four".clone_into(&mut parameter.text);
        }
    }
    let furnace = &mut inputs.gauges[0];
    furnace.assumptions = vec!["The unit is assumed.".to_owned()];
    let reading = &mut furnace.readings[0];
    (reading.quality, reading.pa, reading.corrected_pa) = (Quality::Assumed, None, None);
    reading.cause = Some("1.0e-4 mbar if the unit is mbar".to_owned());
    for alarm in &mut inputs.alarms {
        alarm.state = AlarmState::OutOfService;
        alarm.since_ms = Some(3);
        alarm.occurrence = 4;
        alarm.value = Some(0.5);
        (alarm.acknowledged_by, alarm.acknowledged_ms) = (Some("Ada".to_owned()), Some(5));
        (alarm.raised_ms, alarm.raised_value) = (Some(2), Some(0.4));
        "above the limit".clone_into(&mut alarm.text);
        let reason = "maintenance".to_owned();
        alarm.out_of_service = Some(SuppressionView { user: "Bo".to_owned(), at_ms: 3, reason, until_ms: Some(9) });
    }
    inputs.buses.insert("plc".to_owned(), line(vec![on_line(12, Origin::Assumed)]));
    inputs.buses.insert("hall".to_owned(), line(vec![on_line(5, Origin::Heard)]));
    inputs
}

fn value<'a>(snapshot: &'a Snapshot, subject: &str, signal: Signal) -> &'a Value {
    let found = snapshot.iter().find(|(point, _)| point.subject.name() == subject && point.signal == signal);
    &found.unwrap_or_else(|| panic!("{subject} has no {signal:?}")).1.value
}

fn text(value: impl AsRef<str>) -> Value {
    Value::Text(Arc::from(value.as_ref()))
}

fn word(words: &[&str], word: &str) -> Value {
    let position = words.iter().position(|it| *it == word).unwrap_or_else(|| panic!("no {word} in {words:?}"));
    Value::Choice(u16::try_from(position).unwrap())
}

fn integer(number: impl TryInto<i64>) -> Value {
    Value::Integer(number.try_into().ok().unwrap())
}

/// Compares the points of a subject with what the API shows.
fn expect(snapshot: &Snapshot, subject: &str, expected: Vec<(Signal, Value)>) {
    for (signal, expected) in expected {
        assert_eq!(value(snapshot, subject, signal), &expected, "{subject} {signal:?}");
    }
}

fn shown() -> (Inputs, Snapshot) {
    let inputs = inputs();
    let snapshot = Modeller::default().next(inputs.clone(), Micros(90_000_000));
    (inputs, snapshot)
}

#[test]
fn every_value_of_the_station_and_its_recorder_is_a_point() {
    let (inputs, snapshot) = shown();
    // The name is part of the names of the points. A gateway that does not run has no points to say it with.
    // The archive is a gateway too, and damage is an alarm, which has points of its own.
    let view::Station { name: _, version, started_ms, now_ms, recorder, stopped_parts: _, archive_problem: _ } =
        inputs.station;
    let RecorderView { last_write_ms, error, lost_samples, lost_events, last_check_ms: _, damage: _ } = recorder;
    let expected = vec![
        (Signal::Version, text(version)),
        (Signal::Started, Value::Time(Micros(started_ms * 1000))),
        (Signal::Heartbeat, integer((now_ms - started_ms) / 1000)),
        (Signal::LastWrite, Value::Time(Micros(last_write_ms.unwrap() * 1000))),
        (Signal::Recording, Value::Boolean(error.is_none())),
        (Signal::RecorderProblem, text(error.unwrap())),
        (Signal::LostSamples, integer(lost_samples)),
        (Signal::LostEvents, integer(lost_events)),
    ];
    expect(&snapshot, "", expected);
}

#[test]
fn every_value_of_a_segment_and_its_line_is_a_point() {
    let (inputs, snapshot) = shown();
    for segment in inputs.segments {
        // The port is a setting. The stations are the gauges, and those of other masters in the statistics of the line.
        let Segment {
            name,
            port: _,
            baud,
            master,
            listen_only,
            state,
            problem,
            cycle_ms,
            damaged_telegrams: _,
            stations: _,
        } = segment;
        let bus = Arc::unwrap_or_clone(inputs.buses[&name].clone());
        // Octets, unattributed damage and buckets are details of the histogram page; parameters and events are lists of texts.
        let BusReport {
            baud: _,
            observed_ms,
            telegrams,
            octets: _,
            damaged,
            damaged_last_minute,
            damaged_unattributed: _,
            recorder_octets: _,
            ring,
            cycle,
            rotation,
            masters: _,
            stations,
            parameters: _,
            events: _,
        } = bus;
        assert_eq!((state, ring.as_slice()), (SegmentState::Running, &[1, 3][..]));
        let expected = vec![
            (Signal::Baud, integer(baud)),
            (Signal::Master, master.map_or(Value::None, integer)),
            (Signal::SegmentListenOnly, Value::Boolean(listen_only)),
            (Signal::SegmentState, word(&SEGMENT_STATES, "running")),
            (Signal::SegmentUp, Value::Boolean(true)),
            (Signal::SegmentProblem, text(problem.unwrap())),
            (Signal::CycleTime, Value::Float(cycle_ms.unwrap() / 1e3)),
            (Signal::ObservedTime, integer(observed_ms / 1000)),
            (Signal::Telegrams, integer(telegrams)),
            (Signal::DamagedTelegrams, integer(damaged)),
            (Signal::DamagedLastMinute, integer(damaged_last_minute)),
            (Signal::TokenRing, text("1 3")),
            (Signal::LongestCycle, Value::Float(cycle.max_us.unwrap() as f64 / 1e6)),
            (Signal::TokenRotation, Value::Float(rotation.mean_us.unwrap() as f64 / 1e6)),
            (Signal::LongestRotation, Value::Float(rotation.max_us.unwrap() as f64 / 1e6)),
            (Signal::SegmentRepetitions, integer(stations[0].total.repeated)),
            (Signal::SegmentLostCycles, integer(stations[0].total.lost)),
        ];
        expect(&snapshot, &name, expected);
    }
}

#[test]
fn every_value_of_a_gauge_is_a_point() {
    let (inputs, snapshot) = shown();
    for gauge in inputs.gauges {
        // The segment is part of a point. Levels, intervals, tables and DP-V1 are settings; ages follow from the time of the reading.
        let Gauge {
            name,
            // A slave has the same points, with parameters instead of readings.
            kind: _,
            segment,
            address,
            device,
            model: _,
            // The manufacturer of a slave in OPC UA.
            vendor: _,
            // The range of the pressure.
            integers: _,
            has_dpv1: _,
            state,
            problem,
            listen_only,
            assumptions,
            exceptions,
            warnings,
            gas,
            levels: _,
            readings,
            parameters,
            age_ms: _,
            read_at,
            lost_at: _,
            is_awaited: _,
            poll_ms: _,
            stale_after_ms: _,
        } = gauge;
        assert_eq!(state, BusStationState::DataExchange);
        let expected = vec![
            (Signal::Address, integer(address)),
            (Signal::Device, text(device)),
            (Signal::GaugeState, word(&GAUGE_STATES, "data exchange")),
            (Signal::Problem, text(problem.unwrap())),
            (Signal::ListenOnly, Value::Boolean(listen_only)),
            (Signal::Assumptions, text(assumptions.join(" "))),
            (Signal::Faults, text(exceptions.join(", "))),
            (Signal::Warnings, text(warnings.join(", "))),
            (Signal::Gas, text(gas)),
        ];
        expect(&snapshot, &name, expected);
        // Series, instance and principle name the subject and its range; the limit of a range is the pressure while it is beyond.
        // A defect is in the state.
        let Reading { series, instance: _, principle: _, pa, limit_pa: _, corrected_pa, quality, cause, is_defect: _ } =
            readings[0].clone();
        let float = |number: Option<f64>| number.map_or(Value::None, Value::Float);
        let expected = vec![
            (Signal::Pressure, float(pa)),
            (Signal::PressureLog10, float(pa.map(f64::log10))),
            (Signal::CorrectedPressure, float(corrected_pa)),
            (Signal::Usable, Value::Boolean(pa.is_some())),
            (Signal::Quality, word(&QUALITIES, quality.word())),
            (Signal::Cause, text(cause.unwrap_or_default())),
            (Signal::LastReading, Value::Time(read_at.unwrap())),
        ];
        expect(&snapshot, &series, expected);
        for WatchedParameter { target, name: _, unit, number, text: words, quality, read_at, lost_at: _ } in
            parameters.iter().take(1).cloned()
        {
            let signal = match unit {
                Some("Pa") => Signal::ParameterPressure,
                Some("%") => Signal::ParameterPercentage,
                _ => Signal::ParameterNumber,
            };
            assert!(read_at.is_some() && quality == Quality::Valid);
            expect(&snapshot, &target, vec![(signal, float(number)), (Signal::ParameterText, text(words))]);
        }
        on_the_line(&snapshot, &name, inputs.buses[&segment].stations[0].clone());
    }
}

/// What the statistics of the line show of a gauge. Percentages follow from the counters; the last minute and histories are details.
fn on_the_line(snapshot: &Snapshot, gauge: &str, station: StationReport) {
    let StationReport {
        address: _,
        state,
        devices: _,
        ident: _,
        owner,
        configuration_origin: _,
        unit,
        unit_origin,
        total,
        last_minute: _,
        repeated_percent: _,
        longest_sequence,
        diagnosis,
        diagnosis_history: _,
        interval: _,
        unknown: _,
    } = station;
    let Counts { requests, exchanges: _, unanswered: _, lost, repeated, damaged, refused, diagnoses: _ } = total;
    let known_unit = unit.filter(|_| unit_origin != Some(Origin::Assumed)).unwrap_or_default();
    let expected = vec![
        (Signal::LineState, word(&profivac_gateway::signal::LINE_STATES, state.text())),
        (Signal::Owner, integer(owner.unwrap())),
        (Signal::LineUnit, text(known_unit)),
        (Signal::Requests, integer(requests)),
        (Signal::LostCycles, integer(lost)),
        (Signal::Repetitions, integer(repeated)),
        (Signal::DamagedAnswers, integer(damaged)),
        (Signal::Refusals, integer(refused)),
        (Signal::LongestSequence, integer(longest_sequence)),
        (Signal::Diagnosis, text(diagnosis.join(", "))),
    ];
    expect(snapshot, gauge, expected);
}

#[test]
fn every_value_of_an_alarm_is_a_point() {
    let (inputs, snapshot) = shown();
    for alarm in inputs.alarms {
        // Condition and subject are settings; the time of the last change, also of a suppression, is that of the point.
        let AlarmView {
            name,
            condition: _,
            gauge: _,
            series: _,
            point: _,
            several: _,
            segment: _,
            priority,
            state,
            since_ms,
            occurrence,
            raised_ms,
            raised_value,
            text: why,
            value: number,
            limit,
            reset: _,
            unit,
            acknowledged_by,
            acknowledged_ms,
            shelved,
            out_of_service,
            suppressed,
            message,
        } = alarm;
        let priority = format!("{priority:?}").to_lowercase();
        let SuppressionView { user, at_ms, reason, until_ms } = out_of_service.or(shelved).or(suppressed).unwrap();
        assert_eq!(since_ms, Some(at_ms));
        let time = |ms: Option<i64>| Value::Time(Micros(ms.unwrap() * 1000));
        let expected = vec![
            (Signal::Priority, word(&PRIORITIES, &priority)),
            (Signal::AlarmState, word(&ALARM_STATES, "out of service")),
            (Signal::AlarmActive, Value::Boolean(state.is_active())),
            (Signal::AlarmAcknowledged, Value::Boolean(!state.needs_acknowledgement())),
            (Signal::Occurrence, integer(occurrence)),
            // It is out of service.
            (Signal::AlarmText, text(format!("when raised: {why}"))),
            (Signal::AlarmValue, number.map_or(Value::None, Value::Float)),
            (Signal::AlarmLimit, limit.map_or(Value::None, Value::Float)),
            (Signal::AlarmUnit, text(unit.unwrap_or_default())),
            (Signal::AcknowledgedBy, text(acknowledged_by.unwrap())),
            (Signal::AcknowledgedAt, time(acknowledged_ms)),
            (Signal::Raised, time(raised_ms)),
            (Signal::RaisedValue, raised_value.map_or(Value::None, Value::Float)),
            (Signal::OutOfService, text(reason)),
            (Signal::SuppressedBy, text(user)),
            (Signal::SuppressedUntil, time(until_ms)),
            (Signal::Instruction, text(message.unwrap_or_default())),
        ];
        expect(&snapshot, &name, expected);
        let point = snapshot.iter().find(|(point, _)| point.subject.name() == name).unwrap();
        assert_eq!(point.1.at, Some(Micros(since_ms.unwrap() * 1000)));
    }
}

#[test]
fn a_suppressed_alarm_tells_its_plant_state_and_when_it_ends() {
    let mut inputs = inputs();
    let name = inputs.alarms[0].name.clone();
    for alarm in &mut inputs.alarms {
        let reason = "Vented: leak search".to_owned();
        let suppression = SuppressionView { user: "Cy".to_owned(), at_ms: 3, reason, until_ms: Some(9) };
        (alarm.state, alarm.out_of_service, alarm.suppressed) = (AlarmState::Suppressed, None, Some(suppression));
    }
    let snapshot = Modeller::default().next(inputs, Micros(90_000_000));
    let expected = [
        (Signal::AlarmState, word(&ALARM_STATES, "suppressed")),
        (Signal::AlarmActive, Value::Boolean(false)),
        (Signal::AlarmAcknowledged, Value::Boolean(true)),
        (Signal::OutOfService, text("Vented: leak search")),
        (Signal::SuppressedBy, text("Cy")),
        (Signal::SuppressedUntil, Value::Time(Micros(9000))),
    ];
    for (signal, expected) in expected {
        assert_eq!(value(&snapshot, &name, signal), &expected, "{signal:?}");
    }
}
