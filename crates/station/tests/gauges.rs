//! A gauge answers no class 2 master, was replaced, or is not the configured device: the station reports the problem, and the other
//! gauges are sampled as before. That gauges which do not answer cost the others no sample is tested in virtual time
//! (`segment/virtual_time`).

#![allow(clippy::unwrap_used, clippy::panic, clippy::indexing_slicing, reason = "a test")]

use crate::support::tcp_segment::{Fault, TcpSegment};
use crate::support::{TIMEOUT, until};
use profivac_devices::Principle;
use profivac_recorder::{Micros, Quality};
use profivac_station::control::operation::{GivenValue, OperationRequest, Readback};
use profivac_station::control::{AuthorityAction, ControlError};
use profivac_station::services::Services;
use profivac_station::station::Station;
use profivac_station::view::{BusStationState, Gauge};
use profivac_web_server::auth::{Actor, Role, User};
use std::sync::Arc;
use std::time::Instant;
use tempfile::TempDir;

struct Fixture {
    _folder: TempDir,
    hall: TcpSegment,
    station: Station,
    services: Arc<Services>,
}

impl Fixture {
    /// A station with these gauges (`name device address`) on a segment with these devices.
    fn new(devices: &[&str], gauges: &[&str]) -> Self {
        let hall = TcpSegment::start(devices);
        let folder = tempfile::tempdir().unwrap();
        let config = profivac_config::parse(&segment(&hall, gauges), &folder.path().join("plant.toml")).unwrap();
        let station = Station::start(config).unwrap();
        let services = station.services();
        Self { _folder: folder, hall, station, services }
    }

    fn until(&self, name: &str, wanted: impl Fn(&Gauge) -> bool) -> Gauge {
        until(name, || self.services.snapshots().gauge(name).filter(|gauge| wanted(gauge)))
    }

    fn exchanging(&self, name: &str) -> Gauge {
        self.until(name, |gauge| gauge.state == BusStationState::DataExchange)
    }

    fn until_problem(&self, name: &str, part: &str) -> Gauge {
        self.until(name, |gauge| gauge.problem.as_deref().is_some_and(|problem| problem.contains(part)))
    }

    /// The number of samples of a gauge.
    fn samples(&self, name: &str) -> u32 {
        assert!(self.services.recorder().flush());
        let spans =
            self.services.recorder().open_reader().unwrap().trend(name, Micros(0), Micros(i64::MAX), 1).unwrap();
        spans.iter().map(|span| span.summary.count).sum()
    }
}

fn segment(segment: &TcpSegment, gauges: &[&str]) -> String {
    let head =
        format!("[[segment]]\nname = \"hall\"\nport = \"tcp://{}\"\nbaud = 187500\nmaster = 1\n", segment.address);
    gauges.iter().fold(head, |text, gauge| {
        let [name, device, address] = gauge.split(' ').collect::<Vec<_>>()[..] else { panic!("{gauge}") };
        text + &format!(
            "[[segment.gauge]]\nname = {name:?}\ndevice = {device:?}\naddress = {address}\npoll = \"20 ms\"\n"
        )
    })
}

#[test]
fn a_gauge_that_was_replaced_by_another_device_is_reported() {
    let fixture = Fixture::new(&["bcg450@5", "psg550@6"], &["chamber bcg450 5", "fore psg550 6"]);
    fixture.exchanging("chamber");
    fixture.exchanging("fore");
    fixture.hall.apply(Fault::Swap(5, "psg550@5"));
    let chamber = fixture.until_problem("chamber", "the station's file says bcg450");
    assert_eq!(chamber.state, BusStationState::Missing);
    assert!(chamber.readings.iter().all(|reading| (reading.pa, reading.quality) == (None, Quality::Stale)));
    assert_eq!(fixture.services.snapshots().gauge("fore").unwrap().state, BusStationState::DataExchange);
    // The configured device with another unit.
    fixture.hall.apply(Fault::Swap(5, "bcg450@5:unit=torr"));
    let chamber = fixture.exchanging("chamber");
    let pa = chamber.readings[0].pa.unwrap();
    assert!((pa / 0.2 - 1.0).abs() < 0.01, "{pa}");
    fixture.station.stop().unwrap();
}

#[test]
fn the_file_says_which_of_two_devices_with_one_ident_number_is_connected() {
    let fixture = Fixture::new(&["psg550@5", "pcg550@6"], &["one psg550 5", "two pcg550 6"]);
    let principle = |name: &str| fixture.exchanging(name).readings[0].principle;
    assert_eq!(principle("one"), Some(Principle::Pirani));
    principle("two");
    fixture.station.stop().unwrap();
}

/// A Pirani that was taken for a diaphragm would be shown below 1 mbar where it is below 5e-5 mbar.
#[test]
fn a_device_with_the_ident_number_of_the_configured_one_is_reported_as_another() {
    let fixture = Fixture::new(&["psg552@5", "psg552@6"], &["wrong pcg550 5", "right psg552 6"]);
    fixture.exchanging("right");
    let wrong = fixture.until_problem("wrong", "it is a psg552, the station's file says pcg550");
    assert_eq!(wrong.state, BusStationState::Missing);
    assert!(wrong.readings.is_empty());
    fixture.station.stop().unwrap();
}

#[test]
fn reading_parameters_leaves_no_gap_in_the_samples() {
    let fixture = Fixture::new(&["bcg450@5", "psg550@6"], &["chamber bcg450 5", "fore psg550 6"]);
    fixture.exchanging("chamber");
    fixture.exchanging("fore");
    let before = fixture.samples("fore");
    // Reading all parameters takes about twenty poll intervals, with one or two between two readings.
    (0..5).for_each(|_| assert!(fixture.services.control().requests().blocks("chamber").unwrap().len() > 5));
    let during = fixture.samples("fore") - before;
    assert!(during > 30, "sampled {during} times");
    fixture.station.stop().unwrap();
}

#[test]
fn the_progress_of_reading_parameters_is_published() {
    let fixture = Fixture::new(&["bcg450@5"], &["chamber bcg450 5"]);
    fixture.exchanging("chamber");
    let services = Arc::clone(&fixture.services);
    let blocks = std::thread::spawn(move || services.control().requests().blocks("chamber").unwrap());
    let progress = until("progress", || {
        assert!(!blocks.is_finished(), "the blocks were read without progress");
        fixture.services.snapshots().read_progress().into_iter().find(|progress| progress.done > 10)
    });
    assert!(progress.gauge == "chamber" && progress.done < progress.total && progress.total > 50, "{progress:?}");
    assert!(!blocks.join().unwrap().is_empty());
    assert_eq!(fixture.services.snapshots().read_progress(), []);
    fixture.station.stop().unwrap();
}

fn engineer(fixture: &Fixture) -> Actor {
    let actor = Actor { user: User { name: Arc::from("Erna"), role: Role::Engineer }, peer: None };
    fixture.services.control().change_authority(&actor, AuthorityAction::Request, Instant::now()).unwrap();
    actor
}

fn value(number: f64) -> OperationRequest {
    let (target, value) = (Some("pirani.safe-value".to_owned()), Some(GivenValue::Text(format!("{number} mbar"))));
    OperationRequest { target, value, ..OperationRequest::default() }
}

/// Writes a value, with retries: a busy computer is late for a connection, which the gauge then keeps for a while.
fn written(fixture: &Fixture, actor: &Actor, number: f64) -> Readback {
    let end = Instant::now() + TIMEOUT;
    loop {
        let armed = fixture.services.control().arm(actor, "chamber", &value(number));
        match armed.and_then(|command| fixture.services.control().execute(actor, &command.id)) {
            Ok(executed) => return executed.readback,
            Err(error) => assert!(Instant::now() < end, "{error}"),
        }
    }
}

#[test]
fn executing_commands_leaves_no_gap_in_the_samples() {
    let fixture = Fixture::new(&["bcg450@5", "psg550@6"], &["chamber bcg450 5", "fore psg550 6"]);
    fixture.exchanging("chamber");
    fixture.exchanging("fore");
    let actor = engineer(&fixture);
    let before = fixture.samples("fore");
    for number in 1..=20 {
        let done = written(&fixture, &actor, f64::from(number));
        assert_eq!(done.after, Some(format!("{number} mbar")));
    }
    // A write and the requests around it take some poll intervals.
    let during = fixture.samples("fore") - before;
    assert!(during > 10, "sampled {during} times");
    assert_eq!(fixture.services.snapshots().gauge("chamber").unwrap().state, BusStationState::DataExchange);
    fixture.station.stop().unwrap();
}

#[test]
fn a_gauge_that_answers_no_class_2_master_is_reported_and_does_not_slow_the_others() {
    let fixture = Fixture::new(&["bcg450@5", "psg550@6"], &["chamber bcg450 5", "fore psg550 6"]);
    fixture.exchanging("chamber");
    let actor = engineer(&fixture);
    let command = fixture.services.control().arm(&actor, "chamber", &value(1.0)).unwrap();
    fixture.hall.apply(Fault::NoMs2(5, true));
    let error = fixture.services.control().execute(&actor, &command.id).unwrap_err();
    assert!(matches!(error, ControlError::Operation(_)), "{error:?}");
    assert!(error.to_string().contains("bcg450 at address 5"), "{error}");
    fixture.exchanging("fore");
    fixture.hall.apply(Fault::NoMs2(5, false));
    assert_eq!(written(&fixture, &actor, 2.0).after.as_deref(), Some("2 mbar"));
    fixture.station.stop().unwrap();
}

#[test]
fn a_controller_without_dp_v1_is_operated_in_the_parameter_channel_of_its_cyclic_data() {
    let fixture = Fixture::new(&["tpg300@8"], &["old tpg300 8"]);
    fixture.until("old", |gauge| !gauge.readings.is_empty());
    let actor = engineer(&fixture);
    let request = OperationRequest { command: Some("store".to_owned()), ..OperationRequest::default() };
    let command = fixture.services.control().arm(&actor, "old", &request).unwrap();
    fixture.services.control().execute(&actor, &command.id).unwrap();
    assert_eq!(fixture.services.snapshots().gauge("old").unwrap().state, BusStationState::DataExchange);
    fixture.station.stop().unwrap();
}
