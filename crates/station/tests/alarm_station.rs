//! Alarms of a station that runs on a segment in memory: raised by what a gauge says, left where they stand by a changed file, by an end and by
//! a beginning.

#![allow(clippy::unwrap_used, clippy::panic, reason = "a test")]

use profivac_recorder::Micros;
use profivac_station::alarm::AlarmState;
use profivac_station::alarm::view::AlarmView;
use profivac_station::auth::{Role, User};
use profivac_station::config::Config;
use profivac_station::control::Actor;
use profivac_station::services::Services;
use profivac_station::station::Station;
use std::fs;
use std::path::Path;
use std::time::{Duration, Instant};

/// Long enough for a computer that is busy with something else.
const PATIENCE: Duration = Duration::from_secs(60);

/// A chamber at 2e-3 mbar, and limits around it.
fn config(folder: &Path, more: &str) -> Config {
    let bench = folder.join("bench.toml");
    fs::write(&bench, "devices = [\"bcg450@5\"]\nbaud = 187500\npressure = \"2e-3 mbar\"\n").unwrap();
    let text = format!(
        "[[segment]]\nname = 'hall'\nport = 'sim:{}'\nbaud = 187500\nmaster = 1\n\
         [[segment.gauge]]\nname = 'chamber'\ndevice = 'bcg450'\naddress = 5\npoll = '50 ms'\n\
         [[alarm]]\nname = 'too high'\ngauge = 'chamber'\nabove = '1e-3 mbar'\ndelay = '0 s'\n\
         [[alarm]]\nname = 'much too high'\ngauge = 'chamber'\nabove = '1 mbar'\ndelay = '0 s'\n{more}",
        bench.display()
    );
    Config::parse(&text, &folder.join("plant.toml")).unwrap()
}

fn alarm(plant: &Services, name: &str) -> Option<AlarmView> {
    plant.alarms().all().into_iter().find(|alarm| alarm.name == name)
}

fn until(plant: &Services, name: &str, state: AlarmState) -> AlarmView {
    let end = Instant::now() + PATIENCE;
    loop {
        let alarm = alarm(plant, name).unwrap();
        if alarm.state == state {
            return alarm;
        }
        assert!(Instant::now() < end, "it never was {state:?}: {alarm:?}");
        std::thread::yield_now();
    }
}

fn history(plant: &Services) -> Vec<(String, String)> {
    assert!(plant.recorder().flush());
    let lines = plant.open_reader().unwrap().alarm_history(Micros(0), Micros(i64::MAX), None, 1000).unwrap();
    lines.into_iter().rev().map(|line| (line.alarm, line.change)).collect()
}

#[test]
fn a_station_raises_alarms_and_keeps_them_whatever_becomes_of_it() {
    let folder = tempfile::tempdir().unwrap();
    let mut station = Station::start(config(folder.path(), "")).unwrap();
    let plant = station.services();
    let raised = until(&plant, "too high", AlarmState::Unacknowledged);
    let pa = raised.raised_value.unwrap();
    assert!((pa / 0.2 - 1.0).abs() < 0.01, "{pa}");
    assert_eq!(alarm(&plant, "much too high").unwrap().state, AlarmState::Normal);
    let ada = Actor { user: User { name: "Ada".into(), role: Role::Operator }, peer: None };
    plant.alarms().acknowledge(plant.recorder(), "too high", raised.occurrence, &ada).unwrap();
    station
        .reconfigure(config(
            folder.path(),
            "[[alarm]]\nname = 'low'\ngauge = 'chamber'\nbelow = '1 mbar'\ndelay = '0 s'\n",
        ))
        .unwrap();
    until(&plant, "low", AlarmState::Unacknowledged);
    assert_eq!(alarm(&plant, "too high").unwrap().acknowledged_by.as_deref(), Some("Ada"));
    station.stop();
    drop(plant);
    // The alarm `low` is not meant any more.
    let station = Station::start(config(folder.path(), "")).unwrap();
    let plant = station.services();
    let kept = alarm(&plant, "too high").unwrap();
    assert_eq!((kept.state, kept.occurrence), (AlarmState::Acknowledged, raised.occurrence));
    assert_eq!(alarm(&plant, "low"), None);
    assert!(
        plant.open_reader().unwrap().alarms().unwrap().iter().all(|(name, _)| name != "low")
            || plant.recorder().flush()
    );
    station.stop();
    let told = history(&plant);
    let told: Vec<_> = told.iter().map(|(alarm, what)| (alarm.as_str(), what.as_str())).collect();
    let expected = [("too high", "raised"), ("too high", "acknowledged"), ("low", "raised"), ("low", "removed")];
    assert_eq!(told, expected, "that a station ends and begins is no alarm");
}

#[test]
fn who_looks_for_alarms_is_looked_after() {
    let folder = tempfile::tempdir().unwrap();
    let mut station = Station::start(config(folder.path(), "")).unwrap();
    let plant = station.services();
    station.restart_ended_threads().unwrap();
    until(&plant, "too high", AlarmState::Unacknowledged);
    assert_eq!(plant.alarms().overview().trouble, None);
    assert!(plant.alarms().evaluated_ago().unwrap() < PATIENCE);
    station.stop();
    assert_eq!(plant.alarms().evaluated_ago(), None, "nobody is to look any more");
}
