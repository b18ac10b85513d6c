//! Gauges that are absent, deaf, exchanged for others, or not what the file says: the others do not feel it, and a sentence
//! says what is wrong.

#![allow(clippy::unwrap_used, clippy::panic, clippy::indexing_slicing, reason = "a test")]

mod hardship;

use hardship::{Bench, Blow};
use profivac_recorder::{Micros, Quality};
use profivac_station::auth::{Role, User};
use profivac_station::config::Config;
use profivac_station::control::operation::{GivenValue, OperationRequest, Readback};
use profivac_station::control::{self, Actor, AuthorityAction, ControlError};
use profivac_station::services::Services;
use profivac_station::station::Station;
use profivac_station::view::{BusStationState, Gauge};
use std::sync::Arc;
use std::time::{Duration, Instant};
use tempfile::TempDir;

const PATIENCE: Duration = Duration::from_secs(90);

struct Desk {
    _folder: TempDir,
    bench: Bench,
    station: Station,
    plant: Arc<Services>,
}

impl Desk {
    /// A station with these gauges (`name device address`) on a bench with these devices.
    fn new(devices: &[&str], gauges: &[&str]) -> Self {
        Self::beside(Bench::start(devices), gauges, "")
    }

    /// The same on this bench, beside other segments.
    fn beside(bench: Bench, gauges: &[&str], others: &str) -> Self {
        let folder = tempfile::tempdir().unwrap();
        let text = segment("hall", &bench, gauges) + others;
        let config = Config::parse(&text, &folder.path().join("plant.toml")).unwrap();
        let station = Station::start(config).unwrap();
        let plant = station.services();
        Self { _folder: folder, bench, station, plant }
    }

    fn until(&self, name: &str, wanted: impl Fn(&Gauge) -> bool) -> Gauge {
        let end = Instant::now() + PATIENCE;
        loop {
            let gauge = self.plant.gauge(name).filter(|gauge| wanted(gauge));
            if let Some(gauge) = gauge {
                return gauge;
            }
            assert!(Instant::now() < end, "{name}: {:#?}", self.plant.gauges());
            std::thread::yield_now();
        }
    }

    fn exchanging(&self, name: &str) -> Gauge {
        self.until(name, |gauge| gauge.standing == BusStationState::Exchanging)
    }

    fn until_trouble(&self, name: &str, part: &str) -> Gauge {
        self.until(name, |gauge| gauge.trouble.as_deref().is_some_and(|trouble| trouble.contains(part)))
    }

    /// How often a gauge was sampled.
    fn sampled(&self, name: &str) -> u32 {
        assert!(self.plant.recorder().flush());
        let bins = self.plant.open_reader().unwrap().trend(name, Micros(0), Micros(i64::MAX), 1).unwrap();
        bins.iter().map(|bin| bin.summary.count).sum()
    }
}

fn segment(name: &str, bench: &Bench, gauges: &[&str]) -> String {
    let head = format!("[[segment]]\nname = {name:?}\nport = \"tcp://{}\"\nbaud = 187500\nmaster = 1\n", bench.address);
    gauges.iter().fold(head, |text, gauge| {
        let [name, device, address] = gauge.split(' ').collect::<Vec<_>>()[..] else { panic!("{gauge}") };
        text + &format!(
            "[[segment.gauge]]\nname = {name:?}\ndevice = {device:?}\naddress = {address}\npoll = \"20 ms\"\n"
        )
    })
}

#[test]
fn gauges_that_are_absent_or_deaf_cost_the_others_nothing() {
    let gauges = ["chamber bcg450 5", "deaf bcg450 6", "absent bcg450 7", "away psg550 8", "gone bcg450 9"];
    let (hall, annex) = (Bench::start(&["bcg450@5", "bcg450@6"]), Bench::start(&["bcg450@5"]));
    hall.strike(Blow::Deaf(6, true));
    let desk = Desk::beside(hall, &gauges, &segment("annex", &annex, &["alone bcg450 5"]));
    desk.exchanging("chamber");
    desk.exchanging("alone");
    desk.until_trouble("deaf", "unit of the slave at address 6 cannot be read");
    desk.until_trouble("gone", "nobody answers");
    let begin = [desk.sampled("alone"), desk.sampled("chamber")];
    // Everybody is looked for every three seconds: meanwhile twice or so.
    desk.until("alone", |_| desk.sampled("alone") >= begin[0] + 300);
    let during = [desk.sampled("alone") - begin[0], desk.sampled("chamber") - begin[1]];
    assert!(during[1] * 10 >= during[0] * 9, "alone, in company: {during:?}");
    desk.bench.strike(Blow::Deaf(6, false));
    desk.exchanging("deaf");
    desk.station.stop();
}

#[test]
fn a_gauge_that_was_exchanged_for_another_is_named() {
    let desk = Desk::new(&["bcg450@5", "psg550@6"], &["chamber bcg450 5", "fore psg550 6"]);
    desk.exchanging("chamber");
    desk.exchanging("fore");
    desk.bench.strike(Blow::Swap(5, "psg550@5"));
    let chamber = desk.until_trouble("chamber", "the file says bcg450");
    assert_eq!(chamber.standing, BusStationState::Missing);
    assert!(chamber.readings.iter().all(|reading| (reading.pa, reading.quality) == (None, Quality::Gap.word())));
    assert_eq!(desk.plant.gauge("fore").unwrap().standing, BusStationState::Exchanging);
    // One of the right kind that shows another unit.
    desk.bench.strike(Blow::Swap(5, "bcg450@5:unit=torr"));
    let chamber = desk.exchanging("chamber");
    let pa = chamber.readings[0].pa.unwrap();
    assert!((pa / 0.2 - 1.0).abs() < 0.01, "{pa}");
    desk.station.stop();
}

#[test]
fn of_devices_that_share_an_ident_number_the_file_says_which() {
    let desk = Desk::new(&["psg550@5", "pcg550@6"], &["one psg550 5", "two pcg550 6"]);
    let principle = |name: &str| desk.exchanging(name).readings[0].principle;
    assert_eq!(principle("one"), Some("pirani"));
    principle("two");
    desk.station.stop();
}

#[test]
fn who_asks_for_parameters_makes_no_hole_in_the_record() {
    let desk = Desk::new(&["bcg450@5", "psg550@6"], &["chamber bcg450 5", "fore psg550 6"]);
    desk.exchanging("chamber");
    desk.exchanging("fore");
    let before = desk.sampled("fore");
    // Reading them takes some twenty sampling times, and between two readings there are one or two.
    (0..5).for_each(|_| assert!(desk.plant.blocks("chamber").unwrap().len() > 5));
    let during = desk.sampled("fore") - before;
    assert!(during > 30, "sampled {during} times");
    desk.station.stop();
}

#[test]
fn how_far_parameters_are_read_is_told() {
    let desk = Desk::new(&["bcg450@5"], &["chamber bcg450 5"]);
    desk.exchanging("chamber");
    let plant = Arc::clone(&desk.plant);
    let asked = std::thread::spawn(move || plant.blocks("chamber").unwrap());
    let end = Instant::now() + PATIENCE;
    let far = loop {
        if let Some(far) = desk.plant.read_progress().into_iter().find(|far| far.done > 10) {
            break far;
        }
        assert!(Instant::now() < end && !asked.is_finished(), "never seen");
        std::thread::yield_now();
    };
    assert!(far.gauge == "chamber" && far.done < far.of && far.of > 50, "{far:?}");
    assert!(!asked.join().unwrap().is_empty());
    assert_eq!(desk.plant.read_progress(), []);
    desk.station.stop();
}

fn engineer(desk: &Desk) -> Actor {
    let actor = Actor { user: User { name: Arc::from("Erna"), role: Role::Engineer }, peer: None };
    control::change_authority(&desk.plant, &actor, AuthorityAction::Request, Instant::now()).unwrap();
    actor
}

fn value(number: f64) -> OperationRequest {
    let (target, value) = (Some("pirani.safe-value".to_owned()), Some(GivenValue::Number(number)));
    OperationRequest { target, value, command: None }
}

/// Written in the end: a computer that is busy is late for a connection, which the gauge then holds for a while.
fn written(desk: &Desk, actor: &Actor, number: f64) -> Readback {
    let end = Instant::now() + PATIENCE;
    loop {
        let armed = control::arm(&desk.plant, actor, "chamber", &value(number));
        match armed.and_then(|order| control::execute(&desk.plant, actor, &order.id)) {
            Ok(fired) => return fired.done,
            Err(error) => assert!(Instant::now() < end, "{error}"),
        }
    }
}

#[test]
fn who_acts_makes_no_hole_in_the_record() {
    let desk = Desk::new(&["bcg450@5", "psg550@6"], &["chamber bcg450 5", "fore psg550 6"]);
    desk.exchanging("chamber");
    desk.exchanging("fore");
    let actor = engineer(&desk);
    let before = desk.sampled("fore");
    for number in 1..=20 {
        let done = written(&desk, &actor, f64::from(number));
        assert_eq!(done.after, Some(format!("{number} mbar")));
    }
    // A write and what is asked around it take some sampling times.
    let during = desk.sampled("fore") - before;
    assert!(during > 10, "sampled {during} times");
    assert_eq!(desk.plant.gauge("chamber").unwrap().standing, BusStationState::Exchanging);
    desk.station.stop();
}

#[test]
fn a_gauge_that_answers_nobody_is_told_and_holds_nobody_up() {
    let desk = Desk::new(&["bcg450@5", "psg550@6"], &["chamber bcg450 5", "fore psg550 6"]);
    desk.exchanging("chamber");
    let actor = engineer(&desk);
    let order = control::arm(&desk.plant, &actor, "chamber", &value(1.0)).unwrap();
    desk.bench.strike(Blow::Deaf(5, true));
    let ControlError::Conflict(sentence, _) = control::execute(&desk.plant, &actor, &order.id).unwrap_err() else {
        panic!("fired")
    };
    assert!(sentence.contains("bcg450 at address 5"), "{sentence}");
    desk.exchanging("fore");
    desk.bench.strike(Blow::Deaf(5, false));
    assert_eq!(written(&desk, &actor, 2.0).after.as_deref(), Some("2 mbar"));
    desk.station.stop();
}

#[test]
fn a_controller_without_dp_v1_says_how_it_is_written() {
    let desk = Desk::new(&["tpg300@8"], &["old tpg300 8"]);
    desk.until("old", |gauge| !gauge.readings.is_empty());
    let actor = engineer(&desk);
    let wish = OperationRequest { command: Some("store".to_owned()), ..OperationRequest::default() };
    let ControlError::Conflict(sentence, _) = control::arm(&desk.plant, &actor, "old", &wish).unwrap_err() else {
        panic!("armed")
    };
    assert!(sentence.contains("`profivac write --via pkw`"), "{sentence}");
    desk.station.stop();
}
