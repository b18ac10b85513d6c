//! A station on segments in memory finds, samples and records gauges, recovers lost segments, and applies a changed file.

#![allow(clippy::unwrap_used, clippy::panic, clippy::indexing_slicing, reason = "a test")]

use crate::support::until;
use profivac_devices::Principle;
use profivac_recorder::audit::AuditQuery;
use profivac_recorder::{AuditAction, Micros, Quality};
use profivac_station::config::Config;
use profivac_station::control::AuthorityAction;
use profivac_station::control::operation::OperationRequest;
use profivac_station::services::Services;
use profivac_station::station::Station;
use profivac_station::view::{BusStationState, Gauge, Segment};
use profivac_virtual::segment_file::SegmentFile;
use profivac_web_server::auth::{Actor, Role, User};
use std::fs;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::Instant;
use tempfile::TempDir;

struct Fixture {
    folder: TempDir,
}

impl Fixture {
    fn new() -> Self {
        Self { folder: tempfile::tempdir().unwrap() }
    }

    fn path(&self, name: &str) -> PathBuf {
        self.folder.path().join(name)
    }

    /// Writes a segment in memory with these devices.
    fn memory_segment(&self, name: &str, devices: &[&str]) {
        let devices = devices.iter().map(|device| format!("{device:?}")).collect::<Vec<_>>().join(", ");
        let text = format!("devices = [{devices}]\nbaud = 187500\npressure = \"2e-3 mbar\"\n");
        SegmentFile::parse(&text, Path::new(name)).unwrap();
        fs::write(self.path(name), text).unwrap();
    }

    /// A station with these segments in memory: their names, and `name device address` of each gauge.
    fn config(&self, segments: &[(&str, &[&str])]) -> Config {
        let mut text = "[station]\nname = \"Plant\"\n".to_owned();
        for (name, gauges) in segments {
            let port = self.path(name);
            text += &format!(
                "[[segment]]\nname = {name:?}\nport = \"sim:{}\"\nbaud = 187500\nmaster = 1\n",
                port.display()
            );
            for gauge in *gauges {
                let [name, device, address] = gauge.split(' ').collect::<Vec<_>>()[..] else { panic!("{gauge}") };
                text += &format!(
                    "[[segment.gauge]]\nname = {name:?}\ndevice = {device:?}\naddress = {address}\npoll = \"50 ms\"\n"
                );
            }
        }
        profivac_config::parse(&text, &self.path("plant.toml")).unwrap()
    }
}

fn gauge(services: &Services, name: &str, wanted: impl Fn(&Gauge) -> bool) -> Gauge {
    until(name, || services.snapshots().gauge(name).filter(&wanted))
}

fn exchanging(services: &Services, name: &str) -> Gauge {
    gauge(services, name, |gauge| gauge.state == BusStationState::DataExchange)
}

fn segment(services: &Services, name: &str) -> Segment {
    services.snapshots().segments().into_iter().find(|segment| segment.name == name).unwrap()
}

#[test]
fn gauges_are_found_sampled_and_recorded() {
    let fixture = Fixture::new();
    fixture.memory_segment("hall", &["bcg450@5", "psg550@6", "img400@7", "tpg300@8"]);
    let gauges = ["chamber bcg450 5", "fore psg550 6", "rack img400 7", "old tpg300 8"];
    let station = Station::start(fixture.config(&[("hall", &gauges)])).unwrap();
    let services = station.services();
    let chamber = exchanging(&services, "chamber");
    assert_eq!((chamber.readings.len(), chamber.readings[0].series.as_str()), (1, "chamber"));
    let pa = chamber.readings[0].pa.unwrap();
    assert!((pa / 0.2 - 1.0).abs() < 0.01, "{pa}");
    exchanging(&services, "fore");
    let rack = gauge(&services, "rack", |gauge| gauge.readings.len() == 4);
    assert_eq!(rack.readings[3].series, "rack.4");
    let principles = |gauge: &Gauge| gauge.readings.iter().map(|reading| reading.principle).collect::<Vec<_>>();
    let expected = [Principle::HotCathode, Principle::HotCathode, Principle::Pirani, Principle::Diaphragm];
    assert_eq!(principles(&rack), expected.map(Some));
    let old = gauge(&services, "old", |gauge| !gauge.readings.is_empty());
    assert_eq!(principles(&old), [None; 4], "the controller does not report them");
    let map = segment(&services, "hall").stations;
    let addresses: Vec<_> = map.iter().map(|station| (station.address, station.state)).collect();
    assert_eq!(addresses[0], (1, BusStationState::OwnMaster));
    assert_eq!(addresses.iter().map(|(address, _)| *address).collect::<Vec<_>>(), [1, 5, 6, 7, 8]);
    station.stop().unwrap();
    let samples = services.recorder().open_reader().unwrap().samples("chamber", Micros(0), Micros(i64::MAX)).unwrap();
    assert_eq!(samples.first().unwrap().quality, Quality::Valid);
    assert_eq!(samples.last().unwrap().quality, Quality::Stale, "the end of the station is a gap");
}

#[test]
fn a_file_with_very_many_changes_has_a_row_that_counts_the_others() {
    let fixture = Fixture::new();
    fixture.memory_segment("hall", &["bcg450@5"]);
    fixture.memory_segment("lab", &["bcg450@5"]);
    let mut station = Station::start(fixture.config(&[("hall", &["chamber bcg450 5"])])).unwrap();
    let services = station.services();
    let gauges =
        |segment: &str| (6..76).map(|address| format!("{segment}{address} bcg450 {address}")).collect::<Vec<_>>();
    let (hall, lab) = (gauges("h"), gauges("l"));
    let hall: Vec<&str> = hall.iter().map(String::as_str).collect();
    let lab: Vec<&str> = lab.iter().map(String::as_str).collect();
    station.reconfigure(fixture.config(&[("hall", &hall), ("lab", &lab)]));
    station.stop().unwrap();
    let all = AuditQuery { from: Micros(0), to: Micros(i64::MAX), gauge: None, user: None, limit: 1000 };
    let mut rows = services.recorder().open_reader().unwrap().audit(&all).unwrap();
    rows.retain(|row| row.action == AuditAction::FileChanged);
    // 140 gauges, one segment and the gauge that is gone have four keys each.
    assert_eq!(rows.len(), 501);
    assert_eq!(rows[0].outcome.as_deref(), Some("68 more keys have changed"));
}

/// Key, before, after and outcome of the rows about changes of the file, the earliest first.
fn file_changes(services: &Services) -> Vec<[Option<String>; 4]> {
    let all =
        AuditQuery { from: Micros(0), to: Micros(i64::MAX), gauge: None, user: Some("file".to_owned()), limit: 1000 };
    assert!(services.recorder().flush());
    let rows = services.recorder().open_reader().unwrap().audit(&all).unwrap();
    let rows = rows.into_iter().rev().filter(|row| row.action == AuditAction::FileChanged);
    rows.map(|row| [row.target, row.before, row.after, row.outcome]).collect()
}

#[test]
fn a_file_that_was_changed_while_the_station_was_stopped_leaves_the_same_rows_with_these_words() {
    let fixture = Fixture::new();
    fixture.memory_segment("hall", &["bcg450@5", "psg550@6"]);
    let run = |gauges: &[&str], reload: Option<&[&str]>| {
        let mut station = Station::start(fixture.config(&[("hall", gauges)])).unwrap();
        let services = station.services();
        if let Some(gauges) = reload {
            station.reconfigure(fixture.config(&[("hall", gauges)]));
        }
        station.stop().unwrap();
        let events = services.recorder().open_reader().unwrap().events(Micros(0), Micros(i64::MAX), 100).unwrap();
        let texts: Vec<_> = events.into_iter().rev().map(|event| event.text).collect();
        (file_changes(&services), texts)
    };
    assert_eq!(run(&["chamber bcg450 5"], None).0, Vec::<[Option<String>; 4]>::new(), "a new database knows no file");
    assert_eq!(run(&["chamber bcg450 5"], None).0.len(), 0, "the same file");
    let (rows, events) = run(&["chamber bcg450 6"], None);
    let row = |key: &str, before: &str, after: &str, outcome: Option<&str>| {
        [Some(key.to_owned()), Some(before.to_owned()), Some(after.to_owned()), outcome.map(str::to_owned)]
    };
    let address = "segment \"hall\" gauge \"chamber\" address";
    let stopped = row(address, "5", "6", Some("changed while the station was stopped"));
    assert_eq!(rows, std::slice::from_ref(&stopped));
    let event = format!("the file was changed while the station was stopped: {address}: 5 -> 6");
    assert!(events.contains(&event), "{events:?}");
    let running = row(address, "6", "5", None);
    assert_eq!(run(&["chamber bcg450 6"], Some(&["chamber bcg450 5"])).0, [stopped.clone(), running.clone()]);
    assert_eq!(run(&["chamber bcg450 5"], None).0, [stopped, running], "what was read while it ran is known");
}

#[test]
fn the_first_request_after_the_start_finds_every_gauge() {
    let fixture = Fixture::new();
    fixture.memory_segment("hall", &["bcg450@5"]);
    fixture.memory_segment("lab", &["psg550@6"]);
    let segments: &[(&str, &[&str])] = &[("hall", &["chamber bcg450 5"]), ("lab", &["fore psg550 6"])];
    let mut station = Station::start(fixture.config(segments)).unwrap();
    let services = station.services();
    let names = || services.snapshots().gauges().into_iter().map(|gauge| gauge.name).collect::<Vec<_>>();
    assert_eq!(names(), ["chamber", "fore"]);
    station.reconfigure(fixture.config(&segments[..1]));
    station.reconfigure(fixture.config(segments));
    assert_eq!(names(), ["chamber", "fore"], "a segment that is new in the file");
    station.stop().unwrap();
}

#[test]
fn parameters_are_read_during_data_exchange() {
    let fixture = Fixture::new();
    fixture.memory_segment("hall", &["bcg450@5"]);
    let station = Station::start(fixture.config(&[("hall", &["chamber bcg450 5"])])).unwrap();
    let services = station.services();
    exchanging(&services, "chamber");
    let blocks = services.control().requests().blocks("chamber").unwrap();
    assert!(blocks.len() > 5, "{blocks:#?}");
    let all: Vec<_> = blocks.iter().flat_map(|block| &block.parameters).collect();
    let read = all.iter().filter(|parameter| parameter.value.is_some()).count();
    assert!(read > 50, "{read} of {}", all.len());
    assert_eq!(services.snapshots().gauge("chamber").unwrap().state, BusStationState::DataExchange);
    station.stop().unwrap();
}

#[test]
fn a_missing_gauge_and_another_device_are_reported_in_a_sentence() {
    let fixture = Fixture::new();
    fixture.memory_segment("hall", &["bcg450@5"]);
    let gauges = ["chamber bcg450 5", "other psg550 6"];
    let station = Station::start(fixture.config(&[("hall", &gauges)])).unwrap();
    let services = station.services();
    exchanging(&services, "chamber");
    let other = gauge(&services, "other", |gauge| gauge.problem.is_some());
    assert_eq!((other.state, other.problem.as_deref()), (BusStationState::Missing, Some("no slave answers")));
    station.stop().unwrap();
    // The services hold the database.
    drop(services);
    let wrong = Station::start(fixture.config(&[("hall", &["chamber psg550 5"])])).unwrap();
    let services = wrong.services();
    let chamber = gauge(&services, "chamber", |gauge| gauge.problem.is_some());
    assert_eq!(chamber.problem.as_deref(), Some("it is a bcg450, the station's file says psg550"));
    wrong.stop().unwrap();
}

#[test]
fn a_lost_segment_does_not_affect_another() {
    let fixture = Fixture::new();
    fixture.memory_segment("hall", &["bcg450@5"]);
    let config = fixture.config(&[("hall", &["chamber bcg450 5"]), ("annex", &["second bcg450 5"])]);
    let station = Station::start(config).unwrap();
    let services = station.services();
    exchanging(&services, "chamber");
    let annex = until("a problem of the annex", || {
        Some(segment(&services, "annex")).filter(|segment| segment.problem.is_some())
    });
    assert!(annex.problem.unwrap().contains("annex"));
    fixture.memory_segment("annex", &["bcg450@5"]);
    exchanging(&services, "second");
    assert_eq!(services.snapshots().gauge("chamber").unwrap().state, BusStationState::DataExchange);
    assert_eq!(segment(&services, "annex").problem, None);
    station.stop().unwrap();
}

#[test]
fn a_changed_file_does_not_disturb_unchanged_gauges() {
    let fixture = Fixture::new();
    fixture.memory_segment("hall", &["bcg450@5", "psg550@6"]);
    fixture.memory_segment("annex", &["bcg450@5"]);
    let before = fixture.config(&[("hall", &["chamber bcg450 5"])]);
    let mut station = Station::start(before).unwrap();
    let services = station.services();
    exchanging(&services, "chamber");
    station.reconfigure(
        fixture.config(&[("hall", &["vessel bcg450 5", "fore psg550 6"]), ("annex", &["second bcg450 5"])]),
    );
    exchanging(&services, "fore");
    exchanging(&services, "second");
    assert_eq!(exchanging(&services, "vessel").address, 5);
    assert_eq!(services.snapshots().gauge("chamber"), None);
    assert!(services.recorder().flush());
    let events = services.recorder().open_reader().unwrap().events(Micros(0), Micros(i64::MAX), 100).unwrap();
    let opened = events.iter().filter(|event| event.text.contains("hall is open")).count();
    assert_eq!(opened, 1, "the port stays open: {events:#?}");
    station.reconfigure(fixture.config(&[("annex", &["second bcg450 5"])]));
    until("the removal of the hall", || (services.snapshots().segments().len() == 1).then_some(()));
    exchanging(&services, "second");
    station.stop().unwrap();
}

#[test]
fn an_event_says_that_a_segment_begins_anew_and_why() {
    let fixture = Fixture::new();
    fixture.memory_segment("hall", &["bcg450@5"]);
    let config = || fixture.config(&[("hall", &["chamber bcg450 5"])]);
    let mut station = Station::start(config()).unwrap();
    let services = station.services();
    exchanging(&services, "chamber");
    let mut changed = config();
    changed.segments[0].master = 2;
    station.reconfigure(changed);
    let running = |segment: Segment| Some(segment).filter(|it| it.master == Some(2));
    until("the other master", || running(segment(&services, "hall")));
    exchanging(&services, "chamber");
    assert!(services.recorder().flush());
    let events = services.recorder().open_reader().unwrap().events(Micros(0), Micros(i64::MAX), 100).unwrap();
    let told: Vec<_> = events.iter().filter(|event| event.text.contains("begins anew")).collect();
    let [event] = told[..] else { panic!("{events:#?}") };
    let expected = "segment hall begins anew and releases its gauges and slaves: changed in the station's file: master";
    assert_eq!(event.text, expected);
    station.stop().unwrap();
}

#[test]
fn many_threads_read_the_snapshots() {
    let fixture = Fixture::new();
    fixture.memory_segment("hall", &["bcg450@5"]);
    let station = Station::start(fixture.config(&[("hall", &["chamber bcg450 5"])])).unwrap();
    let services = station.services();
    let watchers: Vec<_> = (0..8)
        .map(|_| {
            let services = Arc::clone(&services);
            std::thread::spawn(move || exchanging(&services, "chamber"))
        })
        .collect();
    watchers.into_iter().for_each(|watcher| {
        watcher.join().unwrap();
    });
    station.stop().unwrap();
}

#[test]
fn a_command_armed_for_one_gauge_is_not_sent_to_another_of_the_same_name() {
    let fixture = Fixture::new();
    fixture.memory_segment("hall", &["bcg450@5", "bcg450@6"]);
    fixture.memory_segment("annex", &["bcg450@6"]);
    let mut station = Station::start(fixture.config(&[("hall", &["chamber bcg450 5"])])).unwrap();
    let services = station.services();
    exchanging(&services, "chamber");
    let actor = Actor { user: User { name: Arc::from("Erna"), role: Role::Engineer }, peer: None };
    services.control().change_authority(&actor, AuthorityAction::Request, Instant::now()).unwrap();
    let request = OperationRequest { command: Some("stop".to_owned()), ..OperationRequest::default() };
    let command = services.control().arm(&actor, "chamber", &request).unwrap();
    station.reconfigure(fixture.config(&[("hall", &["chamber bcg450 6"])]));
    gauge(&services, "chamber", |gauge| gauge.address == 6 && gauge.state == BusStationState::DataExchange);
    let refused = services.control().execute(&actor, &command.id).unwrap_err().to_string();
    assert_eq!(refused, "chamber was bcg450 at address 5 when it was armed and is bcg450 at address 6 now");
    // The same device at the same address, on another segment.
    let command = services.control().arm(&actor, "chamber", &request).unwrap();
    station.reconfigure(fixture.config(&[("annex", &["chamber bcg450 6"])]));
    gauge(&services, "chamber", |gauge| gauge.segment == "annex" && gauge.state == BusStationState::DataExchange);
    let refused = services.control().execute(&actor, &command.id).unwrap_err().to_string();
    let [hall, annex] = ["hall", "annex"].map(|name| format!("segment {name} at sim:{}", fixture.path(name).display()));
    assert_eq!(refused, format!("chamber was on {hall} when it was armed and is on {annex} now"));
    station.stop().unwrap();
}
