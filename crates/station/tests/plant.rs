//! A station on segments in memory: gauges are found, watched and recorded; what is lost comes back; segments do not touch
//! each other.

#![allow(clippy::unwrap_used, clippy::panic, clippy::indexing_slicing, reason = "a test")]

use profivac_recorder::{Micros, Quality};
use profivac_station::auth::{Role, User};
use profivac_station::config::Config;
use profivac_station::control::operation::OperationRequest;
use profivac_station::control::{self, Actor, AuthorityAction};
use profivac_station::services::Services;
use profivac_station::station::Station;
use profivac_station::view::{BusStationState, Gauge, Segment};
use profivac_virtual::segment_file::SegmentFile;
use std::fs;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::{Duration, Instant};
use tempfile::TempDir;

/// Long enough for a computer that is busy with something else.
const PATIENCE: Duration = Duration::from_secs(60);

struct Desk {
    folder: TempDir,
}

impl Desk {
    fn new() -> Self {
        Self { folder: tempfile::tempdir().unwrap() }
    }

    fn path(&self, name: &str) -> PathBuf {
        self.folder.path().join(name)
    }

    /// A segment in memory with these devices.
    fn bench(&self, name: &str, devices: &[&str]) {
        let devices = devices.iter().map(|device| format!("{device:?}")).collect::<Vec<_>>().join(", ");
        let text = format!("devices = [{devices}]\nbaud = 187500\npressure = \"2e-3 mbar\"\n");
        SegmentFile::parse(&text, Path::new(name)).unwrap();
        fs::write(self.path(name), text).unwrap();
    }

    /// A station with a segment for each of `segments`: its bench, and `name device address` of each gauge.
    fn config(&self, segments: &[(&str, &[&str])]) -> Config {
        let mut text = "[station]\nname = \"Plant\"\n".to_owned();
        for (bench, gauges) in segments {
            let port = self.path(bench);
            text += &format!(
                "[[segment]]\nname = {bench:?}\nport = \"sim:{}\"\nbaud = 187500\nmaster = 1\n",
                port.display()
            );
            for gauge in *gauges {
                let [name, device, address] = gauge.split(' ').collect::<Vec<_>>()[..] else { panic!("{gauge}") };
                text += &format!(
                    "[[segment.gauge]]\nname = {name:?}\ndevice = {device:?}\naddress = {address}\npoll = \"50 ms\"\n"
                );
            }
        }
        Config::parse(&text, &self.path("plant.toml")).unwrap()
    }
}

/// Waits until something is seen.
fn until<T>(what: &str, mut seen: impl FnMut() -> Option<T>) -> T {
    let end = Instant::now() + PATIENCE;
    loop {
        if let Some(seen) = seen() {
            return seen;
        }
        assert!(Instant::now() < end, "never seen: {what}");
        std::thread::yield_now();
    }
}

fn gauge(plant: &Services, name: &str, wanted: impl Fn(&Gauge) -> bool) -> Gauge {
    until(name, || plant.gauge(name).filter(&wanted))
}

fn exchanging(plant: &Services, name: &str) -> Gauge {
    gauge(plant, name, |gauge| gauge.standing == BusStationState::Exchanging)
}

fn segment(plant: &Services, name: &str) -> Segment {
    plant.segments().into_iter().find(|segment| segment.name == name).unwrap()
}

#[test]
fn gauges_are_found_watched_and_recorded() {
    let desk = Desk::new();
    desk.bench("hall", &["bcg450@5", "psg550@6", "img400@7", "tpg300@8"]);
    let gauges = ["chamber bcg450 5", "fore psg550 6", "rack img400 7", "old tpg300 8"];
    let station = Station::start(desk.config(&[("hall", &gauges)])).unwrap();
    let plant = station.services();
    let chamber = exchanging(&plant, "chamber");
    assert_eq!((chamber.readings.len(), chamber.readings[0].series.as_str()), (1, "chamber"));
    let pa = chamber.readings[0].pa.unwrap();
    assert!((pa / 0.2 - 1.0).abs() < 0.01, "{pa}");
    exchanging(&plant, "fore");
    let rack = gauge(&plant, "rack", |gauge| gauge.readings.len() == 4);
    assert_eq!(rack.readings[3].series, "rack.4");
    let principles = |gauge: &Gauge| gauge.readings.iter().map(|reading| reading.principle).collect::<Vec<_>>();
    assert_eq!(principles(&rack), ["hot-cathode", "hot-cathode", "pirani", "diaphragm"].map(Some));
    let old = gauge(&plant, "old", |gauge| !gauge.readings.is_empty());
    assert_eq!(principles(&old), [None; 4], "it tells nobody");
    let map = segment(&plant, "hall").stations;
    let addresses: Vec<_> = map.iter().map(|station| (station.address, station.standing)).collect();
    assert_eq!(addresses[0], (1, BusStationState::Ourselves));
    assert_eq!(addresses.iter().map(|(address, _)| *address).collect::<Vec<_>>(), [1, 5, 6, 7, 8]);
    station.stop();
    let samples = plant.open_reader().unwrap().samples("chamber", Micros(0), Micros(i64::MAX)).unwrap();
    assert_eq!(samples.first().unwrap().quality, Quality::Valid);
    assert_eq!(samples.last().unwrap().quality, Quality::Gap, "a station that ends leaves a gap");
}

#[test]
fn parameters_are_read_while_gauges_are_watched() {
    let desk = Desk::new();
    desk.bench("hall", &["bcg450@5"]);
    let station = Station::start(desk.config(&[("hall", &["chamber bcg450 5"])])).unwrap();
    let plant = station.services();
    exchanging(&plant, "chamber");
    let blocks = plant.blocks("chamber").unwrap();
    assert!(blocks.len() > 5, "{blocks:#?}");
    let all: Vec<_> = blocks.iter().flat_map(|block| &block.parameters).collect();
    let read = all.iter().filter(|parameter| parameter.value.is_some()).count();
    assert!(read > 50, "{read} of {}", all.len());
    assert_eq!(plant.gauge("chamber").unwrap().standing, BusStationState::Exchanging);
    station.stop();
}

#[test]
fn what_is_wrong_is_told_in_a_sentence() {
    let desk = Desk::new();
    desk.bench("hall", &["bcg450@5"]);
    let gauges = ["chamber bcg450 5", "other psg550 6"];
    let station = Station::start(desk.config(&[("hall", &gauges)])).unwrap();
    let plant = station.services();
    exchanging(&plant, "chamber");
    let other = gauge(&plant, "other", |gauge| gauge.trouble.is_some());
    assert_eq!((other.standing, other.trouble.as_deref()), (BusStationState::Missing, Some("nobody answers")));
    station.stop();
    // Whoever has the plant has its record.
    drop(plant);
    let wrong = Station::start(desk.config(&[("hall", &["chamber psg550 5"])])).unwrap();
    let plant = wrong.services();
    let chamber = gauge(&plant, "chamber", |gauge| gauge.trouble.is_some());
    assert_eq!(chamber.trouble.as_deref(), Some("it is a bcg450, the file says psg550"));
    wrong.stop();
}

#[test]
fn a_lost_segment_touches_no_other() {
    let desk = Desk::new();
    desk.bench("hall", &["bcg450@5"]);
    let config = desk.config(&[("hall", &["chamber bcg450 5"]), ("annex", &["second bcg450 5"])]);
    let station = Station::start(config).unwrap();
    let plant = station.services();
    exchanging(&plant, "chamber");
    let annex =
        until("the annex is in trouble", || Some(segment(&plant, "annex")).filter(|segment| segment.trouble.is_some()));
    assert!(annex.trouble.unwrap().contains("annex"));
    desk.bench("annex", &["bcg450@5"]);
    exchanging(&plant, "second");
    assert_eq!(plant.gauge("chamber").unwrap().standing, BusStationState::Exchanging);
    assert_eq!(segment(&plant, "annex").trouble, None);
    station.stop();
}

#[test]
fn a_changed_file_leaves_alone_what_did_not_change() {
    let desk = Desk::new();
    desk.bench("hall", &["bcg450@5", "psg550@6"]);
    desk.bench("annex", &["bcg450@5"]);
    let before = desk.config(&[("hall", &["chamber bcg450 5"])]);
    let mut station = Station::start(before).unwrap();
    let plant = station.services();
    exchanging(&plant, "chamber");
    station
        .reconfigure(desk.config(&[("hall", &["vessel bcg450 5", "fore psg550 6"]), ("annex", &["second bcg450 5"])]))
        .unwrap();
    exchanging(&plant, "fore");
    exchanging(&plant, "second");
    assert_eq!(exchanging(&plant, "vessel").address, 5);
    assert_eq!(plant.gauge("chamber"), None);
    assert!(plant.recorder().flush());
    let events = plant.open_reader().unwrap().events(Micros(0), Micros(i64::MAX), 100).unwrap();
    let opened = events.iter().filter(|event| event.text.contains("hall is open")).count();
    assert_eq!(opened, 1, "the port stays open: {events:#?}");
    station.reconfigure(desk.config(&[("annex", &["second bcg450 5"])])).unwrap();
    until("the hall is gone", || (plant.segments().len() == 1).then_some(()));
    exchanging(&plant, "second");
    station.stop();
}

#[test]
fn a_station_is_shared_by_all_who_look() {
    let desk = Desk::new();
    desk.bench("hall", &["bcg450@5"]);
    let station = Station::start(desk.config(&[("hall", &["chamber bcg450 5"])])).unwrap();
    let plant = station.services();
    let watchers: Vec<_> = (0..8)
        .map(|_| {
            let plant = Arc::clone(&plant);
            std::thread::spawn(move || exchanging(&plant, "chamber"))
        })
        .collect();
    watchers.into_iter().for_each(|watcher| {
        watcher.join().unwrap();
    });
    station.stop();
}

#[test]
fn what_was_armed_for_one_gauge_is_not_fired_at_another_of_the_same_name() {
    let desk = Desk::new();
    desk.bench("hall", &["bcg450@5", "bcg450@6"]);
    desk.bench("annex", &["bcg450@6"]);
    let mut station = Station::start(desk.config(&[("hall", &["chamber bcg450 5"])])).unwrap();
    let plant = station.services();
    exchanging(&plant, "chamber");
    let actor = Actor { user: User { name: Arc::from("Erna"), role: Role::Engineer }, peer: None };
    control::change_authority(&plant, &actor, AuthorityAction::Request, Instant::now()).unwrap();
    let wish = OperationRequest { command: Some("stop".to_owned()), ..OperationRequest::default() };
    let order = control::arm(&plant, &actor, "chamber", &wish).unwrap();
    station.reconfigure(desk.config(&[("hall", &["chamber bcg450 6"])])).unwrap();
    gauge(&plant, "chamber", |gauge| gauge.address == 6 && gauge.standing == BusStationState::Exchanging);
    let refused = control::execute(&plant, &actor, &order.id).unwrap_err().to_string();
    assert_eq!(refused, "chamber was bcg450 at address 5 when it was armed and is bcg450 at 6 now");
    // The same device at the same address, on another line.
    let order = control::arm(&plant, &actor, "chamber", &wish).unwrap();
    station.reconfigure(desk.config(&[("annex", &["chamber bcg450 6"])])).unwrap();
    gauge(&plant, "chamber", |gauge| gauge.segment == "annex" && gauge.standing == BusStationState::Exchanging);
    let refused = control::execute(&plant, &actor, &order.id).unwrap_err().to_string();
    let [hall, annex] = ["hall", "annex"].map(|bench| format!("segment {bench} at sim:{}", desk.path(bench).display()));
    assert_eq!(refused, format!("chamber was on {hall} when it was armed and is on {annex} now"));
    station.stop();
}
