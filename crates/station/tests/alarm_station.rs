//! Alarms of a station on a segment in memory: raised by the reading of a gauge, kept over a changed file and over a restart.

#![allow(clippy::unwrap_used, clippy::panic, reason = "a test")]

use crate::support;
use profivac_recorder::Micros;
use profivac_station::alarm::AlarmState;
use profivac_station::alarm::view::AlarmView;
use profivac_station::config::Config;
use profivac_station::services::Services;
use profivac_station::station::Station;
use profivac_web_server::auth::{Actor, Role, User};
use std::fs;
use std::path::Path;

/// A chamber at 2e-3 mbar, with a limit below and one above.
fn config(folder: &Path, more: &str) -> Config {
    let segment = folder.join("segment.toml");
    fs::write(&segment, "devices = [\"bcg450@5\"]\nbaud = 187500\npressure = \"2e-3 mbar\"\n").unwrap();
    let text = format!(
        "[[segment]]\nname = 'hall'\nport = 'sim:{}'\nbaud = 187500\nmaster = 1\n\
         [[segment.gauge]]\nname = 'chamber'\ndevice = 'bcg450'\naddress = 5\npoll = '50 ms'\n\
         [[alarm]]\nname = 'too high'\ngauge = 'chamber'\nabove = '1e-3 mbar'\ndelay = '0 s'\n\
         [[alarm]]\nname = 'much too high'\ngauge = 'chamber'\nabove = '1 mbar'\ndelay = '0 s'\n{more}",
        segment.display()
    );
    profivac_config::parse(&text, &folder.join("plant.toml")).unwrap()
}

fn alarm(services: &Services, name: &str) -> Option<AlarmView> {
    services.alarms().all().into_iter().find(|alarm| alarm.name == name)
}

fn until(services: &Services, name: &str, state: AlarmState) -> AlarmView {
    support::until(name, || alarm(services, name).filter(|alarm| alarm.state == state))
}

fn history(services: &Services) -> Vec<(String, String)> {
    assert!(services.recorder().flush());
    let lines =
        services.recorder().open_reader().unwrap().alarm_history(Micros(0), Micros(i64::MAX), None, 1000).unwrap();
    lines.into_iter().rev().map(|line| (line.alarm, line.change.as_str().to_owned())).collect()
}

#[test]
fn a_station_keeps_its_alarms_over_a_changed_file_and_a_restart() {
    let folder = tempfile::tempdir().unwrap();
    let mut station = Station::start(config(folder.path(), "")).unwrap();
    let services = station.services();
    let raised = until(&services, "too high", AlarmState::Unacknowledged);
    let pa = raised.raised_value.unwrap();
    assert!((pa / 0.2 - 1.0).abs() < 0.01, "{pa}");
    assert_eq!(alarm(&services, "much too high").unwrap().state, AlarmState::Normal);
    let ada = Actor { user: User { name: "Ada".into(), role: Role::Operator }, peer: None };
    services.alarms().acknowledge("too high", raised.occurrence, &ada).unwrap();
    station.reconfigure(config(
        folder.path(),
        "[[alarm]]\nname = 'low'\ngauge = 'chamber'\nbelow = '1 mbar'\ndelay = '0 s'\n",
    ));
    until(&services, "low", AlarmState::Unacknowledged);
    assert_eq!(alarm(&services, "too high").unwrap().acknowledged_by.as_deref(), Some("Ada"));
    station.stop().unwrap();
    drop(services);
    // The file no longer has the alarm `low`.
    let station = Station::start(config(folder.path(), "")).unwrap();
    let services = station.services();
    let kept = alarm(&services, "too high").unwrap();
    assert_eq!((kept.state, kept.occurrence), (AlarmState::Acknowledged, raised.occurrence));
    assert_eq!(alarm(&services, "low"), None);
    assert!(
        services.recorder().open_reader().unwrap().alarms().unwrap().iter().all(|(name, _)| name != "low")
            || services.recorder().flush()
    );
    station.stop().unwrap();
    let changes = history(&services);
    let changes: Vec<_> = changes.iter().map(|(alarm, what)| (alarm.as_str(), what.as_str())).collect();
    let expected = [("too high", "raised"), ("too high", "acknowledged"), ("low", "raised"), ("low", "removed")];
    assert_eq!(changes, expected, "a restart of the station is no alarm");
}

#[test]
fn the_station_notices_when_the_alarms_are_not_evaluated() {
    let folder = tempfile::tempdir().unwrap();
    let mut station = Station::start(config(folder.path(), "")).unwrap();
    let services = station.services();
    station.restart_ended_threads();
    until(&services, "too high", AlarmState::Unacknowledged);
    assert_eq!(services.alarms().overview().overview.problem, None);
    assert!(services.alarms().evaluated_ago().unwrap() < support::TIMEOUT);
    station.stop().unwrap();
    assert_eq!(services.alarms().evaluated_ago(), None, "no thread evaluates any more");
}
