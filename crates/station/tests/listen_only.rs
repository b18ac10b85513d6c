//! A segment on which the station only listens: readings, statistics and captures of the bus of another master, and no octet sent.

#![allow(clippy::unwrap_used, clippy::panic, clippy::indexing_slicing, reason = "a test")]

use crate::foreign_bus::{ForeignBus, Incident, MASTER, SLAVE};
use crate::support;
use crate::support::memory_station::MemoryStation;
use crate::support::until;
use jiff::tz::TimeZone;
use profivac_listen::gauge::Origin;
use profivac_listen::station::StationState;
use profivac_recorder::{Micros, Quality};
use profivac_station::config::Config;
use profivac_station::pumpdown::TimeRange;
use profivac_station::report::{GaugeInfo, Report, ReportRequest, Unit, page::page};
use profivac_station::services::Services;
use profivac_station::station::Station;
use profivac_station::view::{BusStationState, Reading, SegmentState};
use profivac_web_server::auth::Role;
use serde_json::Value;
use std::path::Path;
use std::sync::atomic::Ordering;

/// A device with several telegrams of five octets.
const AMBIGUOUS: &str = "psg550";

/// The file of a station that listens to the bus.
fn text(bus: &ForeignBus) -> String {
    format!(
        "[[segment]]\nname = \"plc\"\nport = \"tcp://127.0.0.1:{}\"\nlisten-only = true\n\
         [[segment.gauge]]\nname = \"furnace\"\naddress = {SLAVE}\ndevice = \"bcg450\"\npoll = \"50 ms\"\n\
         [[alarm]]\nname = \"repetitions\"\nsegment = \"plc\"\nstation = {SLAVE}\nrepetitions = 1.0\ndelay = \"0 s\"\n",
        bus.port
    )
}

fn config(bus: &ForeignBus, folder: &Path) -> Config {
    profivac_config::parse(&text(bus), &folder.join("plant.toml")).unwrap()
}

#[test]
fn a_listen_only_segment_records_the_gauges_of_another_master_and_sends_nothing() {
    let folder = tempfile::tempdir().unwrap();
    let bus = ForeignBus::begin();
    let station = Station::start(config(&bus, folder.path())).unwrap();
    let services = station.services();
    assert!(services.snapshots().gauge("furnace").is_some(), "the first request finds the gauge");
    let gauge = until("the gauge", || {
        let gauge = services.snapshots().gauge("furnace")?;
        (gauge.state == BusStationState::DataExchange && gauge.assumptions.is_empty()).then_some(gauge)
    });
    assert!(gauge.listen_only);
    let pa = gauge.readings[0].pa.unwrap();
    assert!((pa / 0.013_332_2 - 1.0).abs() < 1e-4, "1e-4 Torr: {pa}");
    assert_eq!((gauge.readings[0].quality, gauge.readings[0].series.as_str()), (Quality::Valid, "furnace"));
    let segment = services.snapshots().segments().remove(0);
    assert_eq!((segment.state, segment.listen_only, segment.master), (SegmentState::Running, true, None));
    let states: Vec<_> = segment.stations.iter().map(|station| (station.address, station.state)).collect();
    assert_eq!(states, [(MASTER, BusStationState::OtherMaster), (SLAVE, BusStationState::DataExchange)]);

    let report = until("the report", || {
        services
            .snapshots()
            .buses()
            .report("plc")
            .filter(|it| it.stations.len() == 2 && it.stations[1].total.repeated > 2)
    });
    let slave = &report.stations[1];
    assert_eq!(
        (slave.state, slave.configuration_origin, slave.unit_origin),
        (StationState::Exchanging, Some(Origin::Heard), Some(Origin::Heard))
    );
    assert_eq!((slave.longest_sequence, slave.owner, report.ring.as_slice()), (1, Some(MASTER), &[MASTER][..]));
    until("the alarm", || {
        services
            .alarms()
            .all()
            .into_iter()
            .find(|alarm| alarm.name == "repetitions" && alarm.value.is_some_and(|value| value > 1.0))
    });

    let refused = services.control().requests().blocks("furnace").unwrap_err().to_string();
    assert!(refused.contains("segment plc is listen-only: the station sends nothing on it"), "{refused}");

    assert!(services.snapshots().buses().request_capture("plc", "the test"));
    let captures = services.snapshots().buses().captures("plc").unwrap();
    let capture = until("a capture", || captures.list().unwrap().pop());
    let trace =
        profivac_sim::trace::pcapng::read(&captures.read(&capture.name).unwrap(), profivac_dp::link::Baud::B19200)
            .unwrap();
    assert!(trace.entries.len() > 20, "{}", trace.entries.len());

    station.stop().unwrap();
    assert_eq!(bus.sent_by_listener.load(Ordering::Relaxed), 0, "no octet was sent");
    let samples = services.recorder().open_reader().unwrap().samples("furnace", Micros(0), Micros(i64::MAX)).unwrap();
    assert!(samples.iter().any(|sample| sample.quality == Quality::Valid));
    assert_eq!(samples.last().unwrap().quality, Quality::Stale, "the end of the station is a gap");
}

/// The reading of the gauge, once it has one.
fn reading(services: &Services) -> Option<Reading> {
    services.snapshots().gauge("furnace").filter(|gauge| gauge.state == BusStationState::DataExchange)?.readings.pop()
}

/// 1e-4 in the unit of the master is 0.01 Pa in mbar, which a listener assumes, and 0.0133 Pa in Torr, which the start-up shows.
#[test]
fn a_pressure_in_an_assumed_unit_is_shown_and_recorded_as_assumed_until_the_unit_is_heard() {
    let folder = tempfile::tempdir().unwrap();
    let bus = ForeignBus::with(Incident::LateStartUp);
    let limit = "[[alarm]]\nname = \"high\"\ngauge = \"furnace\"\nabove = \"5e-5 mbar\"\ndelay = \"0 s\"\n";
    let config = profivac_config::parse(&(text(&bus) + limit), &folder.path().join("plant.toml")).unwrap();
    let station = Station::start(config).unwrap();
    let services = station.services();
    let assumed = until("a reading", || reading(&services));
    assert_eq!((assumed.quality, assumed.pa, assumed.limit_pa), (Quality::Assumed, None, None));
    assert_eq!(assumed.cause.as_deref(), Some("1.0e-4 mbar if the unit is mbar"));
    let samples = || {
        let reader = services.recorder().open_reader().unwrap();
        reader.samples("furnace", Micros(0), Micros(i64::MAX)).unwrap()
    };
    until("a sample", || samples().pop());
    let alarm = || services.alarms().all().into_iter().find(|alarm| alarm.name == "high").unwrap();
    assert_eq!(alarm().value, None, "an alarm does not evaluate an assumed pressure");

    bus.restart.store(true, Ordering::Relaxed);
    until("the pressure", || reading(&services).filter(|reading| reading.quality == Quality::Valid));
    until("the alarm", || alarm().value);
    station.stop().unwrap();
    let samples = samples();
    let qualities: Vec<_> = samples.iter().map(|sample| sample.quality).collect();
    assert_eq!(qualities.first(), Some(&Quality::Assumed), "{qualities:?}");
    assert!(qualities.contains(&Quality::Valid), "{qualities:?}");
    for pa in samples.iter().filter_map(|sample| sample.pa) {
        assert!((pa / 0.013_332_2 - 1.0).abs() < 1e-4, "1e-4 Torr: {pa}");
    }
}

/// The lengths of the exchange fit telegrams with floats and with integers of this device: nothing in the inputs is certain.
#[test]
fn nothing_of_an_assumed_configuration_is_recorded() {
    let folder = tempfile::tempdir().unwrap();
    let bus = ForeignBus::with(Incident::FiveOctets);
    let text = text(&bus).replace("bcg450", AMBIGUOUS).replace("poll =", "unit = \"mbar\"\npoll =");
    let station = Station::start(profivac_config::parse(&text, &folder.path().join("plant.toml")).unwrap()).unwrap();
    let services = station.services();
    let assumed = until("a reading", || reading(&services));
    assert_eq!((assumed.quality, assumed.pa, assumed.limit_pa), (Quality::Assumed, None, None));
    let cause = assumed.cause.unwrap();
    assert!(cause.ends_with(" if configuration and unit are the assumed ones"), "{cause}");
    // The start-up shows another device.
    bus.restart.store(true, Ordering::Relaxed);
    let problem = until("the problem", || services.snapshots().gauge("furnace")?.problem);
    assert_eq!(problem, format!("it is a bcg450, the station's file says {AMBIGUOUS}"));
    station.stop().unwrap();
    let reader = services.recorder().open_reader().unwrap();
    assert_eq!(reader.samples("furnace", Micros(0), Micros(i64::MAX)).unwrap(), []);
}

/// The beginning of the alarm in the file of the station.
const ALARM: &str = "[[alarm]]";

/// Waits for a capture of a bus with an incident. Returns the event that says why it was made.
fn capture_event(incident: Incident, has_alarm: bool) -> String {
    let folder = tempfile::tempdir().unwrap();
    let bus = ForeignBus::with(incident);
    let whole = text(&bus);
    let text = if has_alarm { whole.as_str() } else { whole.split(ALARM).next().unwrap() };
    let station = Station::start(profivac_config::parse(text, &folder.path().join("plant.toml")).unwrap()).unwrap();
    let services = station.services();
    let event = until("the event of a capture", || {
        let events = services.recorder().open_reader().unwrap().events(Micros(0), Micros(i64::MAX), 1000).unwrap();
        events.into_iter().map(|event| event.text).find(|text| text.starts_with("segment plc: capture "))
    });
    assert_eq!(services.snapshots().buses().captures("plc").unwrap().list().unwrap().len(), 1);
    station.stop().unwrap();
    assert_eq!(bus.sent_by_listener.load(Ordering::Relaxed), 0, "no octet was sent");
    event
}

#[test]
fn a_lost_station_triggers_a_capture() {
    let event = capture_event(Incident::Lost, false);
    assert!(event.ends_with("(station 12 does not answer any more)"), "{event}");
}

#[test]
fn a_burst_of_damage_triggers_a_capture() {
    let event = capture_event(Incident::Burst, false);
    assert!(event.ends_with("(10 damaged telegrams within a second)"), "{event}");
}

#[test]
fn a_diagnosis_triggers_a_capture() {
    let event = capture_event(Incident::Diagnosis, false);
    assert!(event.contains("(the diagnosis of station 12 reports "), "{event}");
}

#[test]
fn an_alarm_triggers_a_capture() {
    let event = capture_event(Incident::None, true);
    assert!(event.contains("repetitions"), "{event}");
}

/// A file stands where the folder of captures is to be created.
#[test]
fn a_capture_that_cannot_be_written_is_an_event_and_the_segment_goes_on() {
    let folder = tempfile::tempdir().unwrap();
    let bus = ForeignBus::begin();
    let station = Station::start(config(&bus, folder.path())).unwrap();
    let services = station.services();
    until("the report", || services.snapshots().buses().report("plc"));
    std::fs::write(services.recorder().captures(), "no folder").unwrap();
    assert!(services.snapshots().buses().request_capture("plc", "the test"));
    until("the event", || {
        let events = services.recorder().open_reader().unwrap().events(Micros(0), Micros(i64::MAX), 1000).unwrap();
        events.into_iter().find(|event| event.text.contains("cannot be written: "))
    });
    let telegrams = services.snapshots().buses().report("plc").unwrap().telegrams;
    until("more telegrams", || services.snapshots().buses().report("plc").filter(|it| it.telegrams > telegrams));
    station.stop().unwrap();
}

/// Trends and reports treat a gauge of another master like any other.
#[test]
fn a_gauge_of_another_master_has_trends_and_reports() {
    let folder = tempfile::tempdir().unwrap();
    let bus = ForeignBus::begin();
    let station = Station::start(config(&bus, folder.path())).unwrap();
    let services = station.services();
    let from = Micros::now().0 / 1000 - 60_000;
    let valid = || {
        let samples = services.recorder().open_reader().unwrap().samples("furnace", Micros(0), Micros(i64::MAX));
        samples.unwrap().into_iter().find(|sample| sample.quality == Quality::Valid)
    };
    until("a sample", valid);
    let to = Micros::now().0 / 1000 + 60_000;
    let path = format!("/api/trend?series=furnace&from={from}&to={to}&pixels=10");
    let (status, trend) = support::api::request(&services, "GET", &path, String::new(), Role::Viewer);
    assert_eq!(status, 200, "{trend}");
    let high: Vec<f64> = trend["high"].as_array().unwrap().iter().filter_map(Value::as_f64).collect();
    assert!(high.iter().any(|pa| (pa / 0.013_332_2 - 1.0).abs() < 1e-4), "{trend}");
    assert!(services.recorder().flush());
    let reader = services.recorder().open_reader().unwrap();
    let config = config(&bus, folder.path());
    let request = ReportRequest {
        title: "Furnace".to_owned(),
        station: None,
        record: "plant.db".to_owned(),
        span: TimeRange { start: Micros(from * 1000), end: Micros(to * 1000) },
        why: "the test".to_owned(),
        gauges: vec![("furnace".to_owned(), GaugeInfo::of(&config, "furnace"))],
        volume_m3: None,
        pressures: Vec::new(),
        unit: Unit::Mbar,
        zone: TimeZone::UTC,
        made: Micros(to * 1000),
    };
    let page = page(&Report::make(&reader, request).unwrap());
    assert!(page.contains("furnace") && page.contains("1.3\u{a0}×\u{a0}10⁻⁴"), "1e-4 Torr in mbar: {page}");
    station.stop().unwrap();
}

/// The line of the station's own master is observed too.
#[test]
fn a_segment_with_a_master_has_the_same_statistics() {
    let folder = tempfile::tempdir().unwrap();
    let devices = folder.path().join("hall.toml");
    std::fs::write(&devices, "devices = [\"bcg450@5\"]\nbaud = 187500\n").unwrap();
    let text = format!(
        "[[segment]]\nname = \"hall\"\nport = \"sim:{}\"\nbaud = 187500\nmaster = 1\n\
         [[segment.gauge]]\nname = \"chamber\"\naddress = 5\ndevice = \"bcg450\"\n",
        devices.display()
    );
    let station = Station::start(profivac_config::parse(&text, &folder.path().join("plant.toml")).unwrap()).unwrap();
    let services = station.services();
    let report = until("the report", || {
        let report = services.snapshots().buses().report("hall")?;
        let slave = report.stations.iter().find(|station| station.address == 5)?;
        (slave.state == StationState::Exchanging && slave.total.exchanges > 3).then_some(report)
    });
    assert_eq!((report.stations[0].address, report.stations[0].state), (1, StationState::Master));
    let slave = &report.stations[1];
    assert_eq!(
        (slave.configuration_origin, slave.devices.as_slice()),
        (Some(Origin::Heard), &["bcg450".to_owned()][..])
    );
    assert!(!report.parameters.is_empty(), "the station reads the unit over MS2");
    station.stop().unwrap();
}

/// The line of a segment in memory, as `profivac demo` shows it, too.
#[test]
fn the_line_of_a_segment_in_memory_has_live_list_statistics_and_captures() {
    let station = MemoryStation::new(1e-3);
    let buses = station.services.snapshots().buses();
    let report = until("the report", || {
        let report = buses.report("hall")?;
        let slave = report.stations.iter().find(|station| station.address == 5)?;
        (slave.state == StationState::Exchanging && slave.total.exchanges > 3).then_some(report)
    });
    assert_eq!((report.stations[0].address, report.stations[0].state), (1, StationState::Master));
    assert_eq!((report.ring.as_slice(), report.damaged), (&[1][..], 0));
    assert!(report.rotation.count > 0 && report.cycle.count > 0);
    let slave = &report.stations[1];
    assert_eq!((slave.configuration_origin, slave.unit_origin), (Some(Origin::Heard), Some(Origin::Heard)));

    station.outside(|segment| segment.set_noise(0.01));
    until("damage", || buses.report("hall").filter(|report| report.damaged > 3));
    until("the same count in the segment", || {
        station.services.snapshots().segments().into_iter().find(|segment| segment.damaged_telegrams > 3)
    });
    station.outside(|segment| segment.set_noise(0.0));
    assert!(buses.request_capture("hall", "the test"));
    let captures = buses.captures("hall").unwrap();
    let capture = until("a capture", || captures.list().unwrap().pop());
    let file = captures.read(&capture.name).unwrap();
    let trace = profivac_sim::trace::pcapng::read(&file, profivac_dp::link::Baud::B187500).unwrap();
    assert!(trace.entries.len() > 20 && trace.entries.iter().any(|entry| !entry.errors.is_empty()));
}

#[test]
fn the_keys_of_a_listen_only_segment_are_checked() {
    let config = |segment: &str, gauge: &str| {
        let text = format!(
            "[[segment]]\nname = \"plc\"\nport = \"/dev/null\"\n{segment}\n[[segment.gauge]]\nname = \"g\"\naddress = 0\ndevice = \"bcg450\"\n{gauge}\n"
        );
        profivac_config::parse(&text, Path::new("plant.toml")).map_err(|error| error.to_string())
    };
    let listening = config("listen-only = true", "unit = \"Torr\"").unwrap();
    let segment = &listening.segments[0];
    assert!(segment.listen_only && segment.detects_baud);
    assert_eq!(segment.gauges[0].unit.unwrap().name, "Torr");
    assert!(!config("listen-only = true\nbaud = 93750", "").unwrap().segments[0].detects_baud);
    let refused = |segment: &str, gauge: &str, expected: &str| {
        let error = config(segment, gauge).unwrap_err();
        assert!(error.contains(expected), "{error}");
    };
    refused("listen-only = true\nmaster = 1", "", "a segment with listen-only = true has no master");
    refused("master = 1", "unit = \"Torr\"", "the key unit is for segments with listen-only = true");
    refused("listen-only = true", "unit = \"parsec\"", "expected a unit of a bcg450");
    refused("listen-only = true", "configuration = \"00 11\"", "expected the octets of Chk_Cfg of a bcg450, one of: ");
}
