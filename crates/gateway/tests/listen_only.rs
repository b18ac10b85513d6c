//! The points of a segment that another master owns.

#![allow(clippy::unwrap_used, clippy::panic, clippy::indexing_slicing, reason = "a test")]

use crate::foreign_bus::{ForeignBus, Incident, MASTER, SLAVE};
use crate::until::until;
use profivac_gateway::signal::{LINE_STATES, QUALITIES};
use profivac_gateway::{PointValue, ReadModel, Signal, Snapshot, State, Value};
use profivac_station::station::Station;
use std::sync::atomic::Ordering;
use std::sync::{Arc, LazyLock};

/// Waits for a snapshot that `is_it`.
fn snapshot_that(what: &str, model: &ReadModel, is_it: impl Fn(&Snapshot) -> bool) -> Arc<Snapshot> {
    until(what, || Some(model.snapshot()).filter(|snapshot| is_it(snapshot)))
}

/// The value of a point; one without a value before the segment has published its gauges.
fn value<'a>(snapshot: &'a Snapshot, subject: &str, signal: Signal) -> &'a PointValue {
    static NONE: LazyLock<PointValue> = LazyLock::new(PointValue::default);
    let found = snapshot.iter().find(|(point, _)| point.subject.name() == subject && point.signal == signal);
    found.map_or(&NONE, |(_, value)| value)
}

fn word(snapshot: &Snapshot, subject: &str, signal: Signal, words: &'static [&'static str]) -> &'static str {
    match value(snapshot, subject, signal).value {
        Value::Choice(number) => words[usize::from(number)],
        _ => "",
    }
}

fn text(snapshot: &Snapshot, subject: &str, signal: Signal) -> String {
    value(snapshot, subject, signal).value.to_string()
}

#[test]
fn a_gauge_of_another_master_is_assumed_until_its_unit_is_heard_and_its_line_has_statistics() {
    let folder = tempfile::tempdir().unwrap();
    let bus = ForeignBus::with(Incident::LateStartUp);
    let file = format!(
        "[[segment]]\nname = \"plc\"\nport = \"tcp://127.0.0.1:{}\"\nlisten-only = true\n\
         [[segment.gauge]]\nname = \"furnace\"\naddress = {SLAVE}\ndevice = \"bcg450\"\npoll = \"50 ms\"\n",
        bus.port
    );
    let station = Station::start(profivac_config::parse(&file, &folder.path().join("plant.toml")).unwrap()).unwrap();
    let model = ReadModel::start(station.services()).unwrap();

    let assumed =
        snapshot_that("assumed reading", &model, |it| word(it, "furnace", Signal::Quality, &QUALITIES) == "assumed");
    let pressure = value(&assumed, "furnace", Signal::Pressure);
    assert_eq!(
        (&pressure.value, pressure.state),
        (&Value::None, State::Invalid),
        "no number in a unit that is not known"
    );
    assert_eq!(text(&assumed, "furnace", Signal::Cause), "1.0e-4 mbar if the unit is mbar");
    assert_eq!(text(&assumed, "furnace", Signal::LineUnit), "");
    assert_ne!(text(&assumed, "furnace", Signal::Assumptions), "");

    bus.restart.store(true, Ordering::Relaxed);
    let heard = snapshot_that("pressure and statistics", &model, |it| {
        let count = |subject, signal| matches!(value(it, subject, signal).value, Value::Integer(count) if count > 2);
        word(it, "furnace", Signal::Quality, &QUALITIES) == "valid"
            && text(it, "furnace", Signal::LineUnit) == "Torr"
            && count("furnace", Signal::Repetitions)
            && count("plc", Signal::Telegrams)
    });
    let pressure = value(&heard, "furnace", Signal::Pressure);
    let pa = pressure.value.float().unwrap();
    assert!((pa / 0.013_332_2 - 1.0).abs() < 1e-4 && pressure.state == State::Ok, "1e-4 Torr: {pa} Pa");
    assert_eq!(value(&heard, "furnace", Signal::ListenOnly).value, Value::Boolean(true));
    assert_eq!(word(&heard, "furnace", Signal::LineState, &LINE_STATES), "exchanging");
    assert_eq!(value(&heard, "furnace", Signal::Owner).value, Value::Integer(MASTER.into()));
    assert_eq!(value(&heard, "furnace", Signal::LongestSequence).value, Value::Integer(1));
    assert_eq!(value(&heard, "plc", Signal::SegmentListenOnly).value, Value::Boolean(true));
    assert_eq!(value(&heard, "plc", Signal::Master).value, Value::None, "the station has no master on it");
    assert_eq!(text(&heard, "plc", Signal::TokenRing), MASTER.to_string());
    assert!(
        heard.points.iter().all(|point| point.signal.subject() != profivac_gateway::signal::SubjectKind::Parameter)
    );
    station.stop().unwrap();
    assert_eq!(bus.sent_by_listener.load(Ordering::Relaxed), 0, "the station sends nothing");
}
