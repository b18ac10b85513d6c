//! Slaves by their GSD files: owned, heard, and read with RD_Inp.

use super::fixture::{Fixture, POLL, polled};
use super::plant::VirtualEdge;
use super::test_slave::TestSlave;
use crate::config::{self, PointType, SlavePoint, WatchedRecord};
use crate::segment::edge::SegmentCommand;
use crate::segment::heard_line::HeardLine;
use crate::segment::moment::Moment;
use crate::segment::polled_line::PolledLine;
use crate::segment::runner::Line;
use crate::segment::slave::{SegmentSlave, next_request};
use crate::view::{BusStationState, Gauge, GaugeKind, WatchedParameter};
use profivac_gsd::GsdFile;
use profivac_gsd_slave::{GsdSlave, ModuleChoice, Modules, Selection};
use profivac_recorder::{EventKind, Micros, PointKind, Quality};
use profivac_wire::{DataTelegram, MAX_TELEGRAM, Telegram};
use std::sync::Arc;
use std::time::{Duration, Instant};

/// A valve: the position and a limit switch as inputs.
const VALVE: &[u8] = b"#Profibus_DP
Vendor_Name = \"Invented\"
Model_Name = \"Valve 7\"
Ident_Number = 0x0FA7
Max_Input_Len = 2
Max_Output_Len = 0
Module = \"Position\" 0x11
1
EndModule
";

/// A pump controller: speed and state as inputs, a start bit as output.
const PUMP: &[u8] = b"#Profibus_DP
Vendor_Name = \"Invented\"
Model_Name = \"Pump 1\"
Ident_Number = 0x0FA1
Modular_Station = 1
Max_Module = 4
Max_Input_Len = 8
Max_Output_Len = 4
Max_Data_Len = 12
User_Prm_Data_Len = 2
User_Prm_Data = 0x11,0x22
Unit_Diag_Bit(1) = \"Bearing is hot\"
Channel_Diag(16) = \"No cooling water\"
Module = \"Speed\" 0x51
1
EndModule
Module = \"Control\" 0x20
2
EndModule
";

fn pump() -> Arc<GsdSlave> {
    let modules = Modules::InOrder(vec![ModuleChoice::Number(1), ModuleChoice::Number(2)]);
    let selection = Selection { modules, changes: Vec::new() };
    Arc::new(GsdSlave::new(Arc::new(GsdFile::read(PUMP)), &selection).unwrap())
}

fn point(name: &str, kind: PointType, octet: usize) -> SlavePoint {
    SlavePoint {
        name: name.to_owned(),
        place: format!("slot 1 Speed octet {octet}"),
        record: None,
        kind,
        octet,
        bit: 0,
        is_little_endian: false,
        scale: 1.0,
        offset: 0.0,
        unit: None,
        texts: Vec::new(),
        status: None,
        deadband: 0.0,
    }
}

fn slave(is_owned: bool) -> config::Slave {
    let speed = SlavePoint { unit: Some("Hz"), ..point("speed", PointType::U16, 0) };
    let texts = vec![(0, "off".to_owned()), (3, "at speed".to_owned())];
    let state = SlavePoint { texts, ..point("state", PointType::U8, 2) };
    config::Slave {
        name: "turbo".to_owned(),
        address: 12,
        gsd: pump(),
        is_owned,
        outputs: if is_owned { vec![0x01] } else { Vec::new() },
        poll: POLL,
        points: vec![speed, state],
    }
}

fn segment(is_owned: bool) -> config::Segment {
    config::Segment { slaves: vec![slave(is_owned)], ..polled(&[]) }
}

fn point_of<'a>(gauge: &'a Gauge, name: &str) -> &'a WatchedParameter {
    gauge.parameters.iter().find(|point| point.target == name).unwrap()
}

fn shown(gauge: &Gauge, name: &str) -> (Option<f64>, String, Quality) {
    let point = point_of(gauge, name);
    (point.number, point.text.clone(), point.quality)
}

#[test]
fn an_owned_slave_gets_parameters_and_outputs_of_the_file_and_its_points_are_shown() {
    let device = TestSlave::new(12, &pump());
    device.state().inputs = vec![0x03, 0xE8, 3, 0];
    let valve_gsd = Arc::new(GsdSlave::new(Arc::new(GsdFile::read(VALVE)), &Selection::default()).unwrap());
    let valve = TestSlave::new(13, &valve_gsd);
    valve.state().inputs = vec![0b10, 40];
    let edge = VirtualEdge::with_slaves(&["bcg450@5"]).and(&[&device, &valve]);
    let closed =
        SlavePoint { bit: 1, texts: vec![(1, "closed".to_owned())], ..point("limit switch", PointType::Bool, 0) };
    let gate = config::Slave {
        name: "gate".to_owned(),
        address: 13,
        gsd: valve_gsd,
        points: vec![closed],
        outputs: Vec::new(),
        ..slave(true)
    };
    let config = config::Segment { slaves: vec![slave(true), gate], ..polled(&["chamber bcg450 5"]) };
    let mut fixture = Fixture::<PolledLine>::new(config, edge);
    let gate = fixture.exchanging("gate");
    assert_eq!(shown(&gate, "limit switch"), (Some(1.0), "closed".to_owned(), Quality::Valid));
    let turbo = fixture.exchanging("turbo");
    assert_eq!((turbo.kind, turbo.device.as_str(), turbo.listen_only), (GaugeKind::Slave, "Invented Pump 1", false));
    assert_eq!(shown(&turbo, "speed"), (Some(1000.0), "1000 Hz".to_owned(), Quality::Valid));
    assert_eq!(shown(&turbo, "state"), (Some(3.0), "at speed".to_owned(), Quality::Valid));
    assert_eq!(device.state().user_prm, Some(vec![0x11, 0x22]));
    // The first data that it got are the outputs of the file, never zeros.
    let outputs: Vec<_> = device.state().outputs.iter().flatten().cloned().collect();
    assert_eq!(outputs, [[0x01]]);
    let chamber = fixture.exchanging("chamber");
    assert_eq!(chamber.kind, GaugeKind::Gauge);

    device.state().inputs = vec![0, 0, 0, 0];
    let is_off = |gauge: &Gauge| shown(gauge, "state").1 == "off";
    let turbo = fixture.until("turbo", Duration::from_secs(2), is_off);
    assert_eq!(shown(&turbo, "speed").0, Some(0.0), "zero is a number and no fault");
}

#[test]
fn the_diagnosis_of_a_slave_is_a_fault_and_an_event_in_the_words_of_its_file() {
    let device = TestSlave::new(12, &pump());
    let edge = VirtualEdge::with_slaves(&[]).and(&[&device]);
    let mut fixture = Fixture::<PolledLine>::new(segment(true), edge);
    fixture.exchanging("turbo");
    // A device-related block with bit 1, and error 16 of channel 2 of the second identifier.
    device.report(&[0x02, 0x02, 0x81, 0x42, 0x30]);
    let is_fault = |gauge: &Gauge| gauge.state == BusStationState::Fault;
    let turbo = fixture.until("turbo", Duration::from_secs(5), is_fault);
    let hot = "vendor-specific octets 02: Bearing is hot";
    let dry = "identifier 1 (slot 2, module Control), input channel 2 (bit): error 16 No cooling water";
    assert_eq!(turbo.exceptions, [hot, dry]);
    assert_eq!(fixture.events(&format!("turbo: {hot}; {dry}")).len(), 1);
    // An identifier that the channel names too is not told twice.
    device.report(&[0x42, 0x03, 0x81, 0x42, 0x30]);
    fixture.run_for(Duration::from_secs(1));
    let speed = "with diagnosis: identifier 0 (slot 1, module Speed)";
    assert_eq!(fixture.gauge("turbo").exceptions, [speed, dry]);
    device.report(&[]);
    let turbo = fixture.exchanging("turbo");
    assert!(turbo.exceptions.is_empty(), "{turbo:?}");
    assert_eq!(fixture.events("turbo: no diagnosis").len(), 1);
}

/// An alarm keeps its kind, slot and specifier when its bits have texts, and the texts are those of the module in its slot.
#[test]
fn an_alarm_of_a_slave_has_its_kind_its_slot_and_the_texts_of_the_module() {
    let with_alarms = "Max_Module = 4\nDPV1_Slave = 1\nDiagnostic_Alarm_supp = 1";
    let text = String::from_utf8(PUMP.to_vec()).unwrap().replace("Max_Module = 4", with_alarms);
    let text = text.replace("0x20\n2\n", "0x20\n2\nUnit_Diag_Bit(24) = \"Valve stuck\"\n");
    let modules = Modules::InOrder(vec![ModuleChoice::Number(1), ModuleChoice::Number(2)]);
    let file = Arc::new(GsdFile::read(text.as_bytes()));
    let gsd = Arc::new(GsdSlave::new(file, &Selection { modules, changes: Vec::new() }).unwrap());
    let device = TestSlave::new(12, &gsd);
    let config = config::Segment { slaves: vec![config::Slave { gsd, ..slave(true) }], ..polled(&[]) };
    let mut fixture = Fixture::<PolledLine>::new(config, VirtualEdge::with_slaves(&[]).and(&[&device]));
    fixture.exchanging("turbo");
    // A diagnostic alarm of slot 2 that appears, with bit 24.
    device.report(&[0x05, 0x01, 0x02, 0x09, 0x01]);
    let turbo = fixture.until("turbo", Duration::from_secs(5), |gauge| gauge.state == BusStationState::Fault);
    let alarm = "diagnostic alarm of slot 2, sequence number 1, appears: 01 (slot 2 is Control): Valve stuck";
    assert_eq!(turbo.exceptions, [alarm]);
}

/// A pump that has reported a fault is switched off, or heard with other modules: its diagnosis is no news at each sample.
#[test]
fn the_last_diagnosis_of_a_slave_without_values_is_no_flood_of_events() {
    let device = TestSlave::new(12, &pump());
    let mut fixture = Fixture::<PolledLine>::new(segment(true), VirtualEdge::with_slaves(&[]).and(&[&device]));
    fixture.exchanging("turbo");
    device.report(&[0x02, 0x02]);
    fixture.until("turbo", Duration::from_secs(5), |gauge| gauge.state == BusStationState::Fault);
    assert_eq!(fixture.events("turbo: vendor-specific octets 02: Bearing is hot").len(), 1);
    fixture.change(|plant| plant.is_silent = true);
    let turbo = fixture.until("turbo", Duration::from_secs(30), |gauge| gauge.state == BusStationState::Missing);
    fixture.run_for(Duration::from_secs(5));
    assert_eq!(fixture.events("turbo: vendor-specific octets 02: Bearing is hot").len(), 1);
    assert!(turbo.exceptions.is_empty(), "{turbo:?}");
    fixture.change(|plant| plant.is_silent = false);
    fixture.until("turbo", Duration::from_secs(60), |gauge| gauge.state == BusStationState::Fault);
    assert_eq!(fixture.events("turbo: vendor-specific octets 02: Bearing is hot").len(), 2, "it still has the fault");
}

/// Identifiers 2 and 20 belong to no module of the file, and neither stands for the other.
#[test]
fn each_identifier_without_a_module_is_reported() {
    let device = TestSlave::new(12, &pump());
    let mut fixture = Fixture::<PolledLine>::new(segment(true), VirtualEdge::with_slaves(&[]).and(&[&device]));
    fixture.exchanging("turbo");
    device.report(&[0x44, 0x04, 0x00, 0x10]);
    let turbo = fixture.until("turbo", Duration::from_secs(5), |gauge| gauge.state == BusStationState::Fault);
    assert_eq!(
        turbo.exceptions,
        ["with diagnosis: identifier 2 (beyond the modules), identifier 20 (beyond the modules)"]
    );
}

#[test]
fn a_diagnosis_that_toggles_is_no_flood_and_its_last_texts_are_told() {
    let device = TestSlave::new(12, &pump());
    let mut fixture = Fixture::<PolledLine>::new(segment(true), VirtualEdge::with_slaves(&[]).and(&[&device]));
    fixture.exchanging("turbo");
    for round in 0..100 {
        device.report(if round % 2 == 0 { &[0x02, 0x02] } else { &[] });
        fixture.run_for(Duration::from_millis(100));
    }
    let count = |fixture: &Fixture<_>, text| fixture.events(text).len();
    let told =
        count(&fixture, "turbo: vendor-specific octets 02: Bearing is hot") + count(&fixture, "turbo: no diagnosis");
    assert!((2..=6).contains(&told), "{told} events in 10 s");
    device.report(&[0x02, 0x02]);
    fixture.run_for(Duration::from_mins(1));
    let last = fixture.events("turbo: ").last().unwrap().text.clone();
    assert!(last.starts_with("turbo: vendor-specific octets 02: Bearing is hot ("), "{last}");
    assert!(last.contains(" earlier changes had no event: at most 6 a minute)"), "{last}");
}

/// An owned slave that is sampled once an hour shows its values when it gives them.
#[test]
fn a_slave_that_is_sampled_seldom_has_values_soon_after_its_start() {
    let device = TestSlave::new(12, &pump());
    let seldom = config::Slave { poll: Duration::from_secs(3600), ..slave(true) };
    let config = config::Segment { slaves: vec![seldom], ..polled(&[]) };
    let mut fixture = Fixture::<PolledLine>::new(config, VirtualEdge::with_slaves(&[]).and(&[&device]));
    fixture.exchanging("turbo");
}

#[test]
fn a_point_with_texts_that_changes_is_an_event_and_one_that_toggles_is_no_flood() {
    let device = TestSlave::new(12, &pump());
    let mut fixture = Fixture::<PolledLine>::new(segment(true), VirtualEdge::with_slaves(&[]).and(&[&device]));
    fixture.exchanging("turbo");
    assert!(fixture.events("turbo: state is").is_empty(), "the first value is no change");
    fixture.run_for(Duration::from_secs(11));
    device.state().inputs = vec![0x03, 0xE8, 3, 0];
    fixture.run_for(Duration::from_secs(1));
    assert_eq!(fixture.events("turbo: state is at speed").len(), 1);
    assert!(fixture.events("turbo: speed").is_empty(), "a quantity is no event");
    for round in 0..500 {
        device.state().inputs = vec![0, 0, if round % 2 == 0 { 0 } else { 3 }, 0];
        fixture.run_for(Duration::from_millis(40));
    }
    let events = fixture.events("turbo: state is").len();
    assert!((2..=4).contains(&events), "{events} events in 20 s");
}

#[test]
fn a_slave_that_is_lost_has_no_values_and_its_return_is_an_event() {
    let device = TestSlave::new(12, &pump());
    let mut fixture = Fixture::<PolledLine>::new(segment(true), VirtualEdge::with_slaves(&[]).and(&[&device]));
    fixture.exchanging("turbo");
    fixture.change(|plant| plant.is_silent = true);
    let is_lost = |gauge: &Gauge| gauge.state == BusStationState::Missing;
    let turbo = fixture.until("turbo", Duration::from_secs(30), is_lost);
    assert_eq!(shown(&turbo, "speed"), (None, String::new(), Quality::Stale));
    assert!(turbo.lost_at.is_some() && turbo.problem.is_some());
    fixture.change(|plant| plant.is_silent = false);
    let turbo = fixture.exchanging("turbo");
    assert_eq!(shown(&turbo, "speed").2, Quality::Valid);
    assert_eq!(fixture.events("turbo: in data exchange").len(), 2);
}

/// The master has tried each slave of a dead line only once or twice after a second.
#[test]
fn a_slave_that_is_silent_for_a_second_gives_no_answer_in_every_view() {
    let devices: Vec<_> = (12..24).map(|address| TestSlave::new(address, &pump())).collect();
    let named = |address: u8| config::Slave { name: format!("turbo{address}"), address, ..slave(true) };
    let slaves: Vec<_> = (12..24).map(named).collect();
    let names: Vec<_> = slaves.iter().map(|slave| slave.name.clone()).collect();
    let config = config::Segment { slaves, ..polled(&[]) };
    let edge = VirtualEdge::with_slaves(&[]).and(&devices.iter().collect::<Vec<_>>());
    let mut fixture = Fixture::<PolledLine>::new(config, edge);
    names.iter().for_each(|name| {
        fixture.exchanging(name);
    });
    fixture.change(|plant| plant.is_silent = true);
    fixture.run_for(Duration::from_millis(1_300));
    let stations = fixture.segment().stations;
    for name in &names {
        let turbo = fixture.gauge(name);
        assert_eq!((turbo.state, turbo.problem.as_deref()), (BusStationState::Missing, Some("no answer")), "{name}");
        let station = stations.iter().find(|station| station.address == turbo.address).unwrap();
        assert_eq!((station.state, station.description.as_str()), (BusStationState::Missing, "no answer"), "{name}");
        let events: Vec<_> = fixture.events(&format!("{name}: no answer")).iter().map(|event| Some(event.at)).collect();
        assert_eq!(events, [turbo.lost_at], "{name}");
    }
}

/// The recorded values of a point with their qualities.
fn recorded<L: Line>(fixture: &Fixture<L>, name: &str) -> Vec<(Option<f64>, Quality)> {
    fixture.point_samples("turbo", name).iter().map(|sample| (sample.number, sample.quality)).collect()
}

#[test]
fn the_points_of_a_slave_are_recorded_in_their_unit_and_a_loss_is_a_gap() {
    let device = TestSlave::new(12, &pump());
    device.state().inputs = vec![0x03, 0xE8, 3, 0];
    let mut fixture = Fixture::<PolledLine>::new(segment(true), VirtualEdge::with_slaves(&[]).and(&[&device]));
    let turbo = fixture.exchanging("turbo");
    let read_at = point_of(&turbo, "speed").read_at;
    // The recorder keeps all values around an event.
    fixture.services.recorder().event_now(None, EventKind::Note, "all");
    let samples = fixture.point_samples("turbo", "speed");
    assert!(
        samples.iter().any(|sample| Some(sample.at) == read_at),
        "the time of the exchange: {samples:?} {read_at:?}"
    );
    device.state().inputs = vec![0, 0, 0, 0];
    fixture.until("turbo", Duration::from_secs(2), |gauge| shown(gauge, "state").1 == "off");
    fixture.run_for(Duration::from_secs(3));
    fixture.change(|plant| plant.is_silent = true);
    fixture.until("turbo", Duration::from_secs(30), |gauge| gauge.state == BusStationState::Missing);
    let valid = |number| (Some(number), Quality::Valid);
    let distinct = |name| {
        let mut values = recorded(&fixture, name);
        values.dedup();
        values
    };
    assert_eq!(distinct("speed"), [valid(1000.0), valid(0.0), (None, Quality::Stale)]);
    assert_eq!(distinct("state"), [valid(3.0), valid(0.0), (None, Quality::Stale)]);
    let reader = fixture.services.recorder().open_reader().unwrap();
    let points: Vec<_> = reader.points().unwrap().into_iter().map(|it| (it.name, it.unit, it.kind)).collect();
    let (speed, state) = ("speed".to_owned(), "state".to_owned());
    assert_eq!(points, [(speed, Some("Hz".to_owned()), PointKind::Number), (state, None, PointKind::Code)]);
}

#[test]
fn the_record_of_points_ends_with_a_gap_when_the_segment_stops() {
    let device = TestSlave::new(12, &pump());
    let mut fixture = Fixture::<PolledLine>::new(segment(true), VirtualEdge::with_slaves(&[]).and(&[&device]));
    fixture.exchanging("turbo");
    fixture.commands.send(SegmentCommand::Stop).unwrap();
    while fixture.step() {}
    assert_eq!(recorded(&fixture, "speed").last(), Some(&(None, Quality::Stale)));
}

/// The deadband of the file is in the unit of the point.
#[test]
fn a_number_within_its_deadband_is_recorded_once() {
    let device = TestSlave::new(12, &pump());
    let mut turbo = slave(true);
    turbo.points[0].deadband = 10.0;
    let config = config::Segment { slaves: vec![turbo], ..polled(&[]) };
    let mut fixture = Fixture::<PolledLine>::new(config, VirtualEdge::with_slaves(&[]).and(&[&device]));
    device.state().inputs = vec![0, 100, 3, 0];
    fixture.exchanging("turbo");
    // The recorder keeps every value within 30 s of an event.
    fixture.run_for(Duration::from_secs(35));
    for speed in [105, 95, 110, 90, 111] {
        device.state().inputs = vec![0, speed, 3, 0];
        fixture.run_for(Duration::from_secs(1));
    }
    let mut numbers: Vec<_> = recorded(&fixture, "speed").into_iter().map(|(number, _)| number).collect();
    numbers.dedup();
    assert_eq!(numbers, [Some(100.0), Some(90.0), Some(111.0)]);
}

#[test]
fn a_slave_that_the_station_does_not_own_gets_no_parameters() {
    let device = TestSlave::new(12, &pump());
    let edge = VirtualEdge::with_slaves(&[]).and(&[&device]);
    let mut fixture = Fixture::<PolledLine>::new(segment(false), edge);
    let turbo = fixture.until_problem("turbo", "no master exchanges data with it: with own = true the station does");
    assert_eq!((turbo.listen_only, turbo.state), (true, BusStationState::Missing));
    fixture.run_for(Duration::from_secs(10));
    assert_eq!(device.state().user_prm, None);
    assert!(device.state().outputs.is_empty(), "{:?}", device.state().outputs);
}

#[test]
fn a_slave_of_a_master_that_is_not_heard_is_read_with_rd_inp() {
    let device = TestSlave::new(12, &pump());
    device.state().inputs = vec![0x03, 0xE8, 3, 0];
    let edge = VirtualEdge::with_slaves(&[]).and(&[&device]);
    let mut fixture = Fixture::<PolledLine>::new(segment(false), edge);
    // Locked, without a watchdog, min T_SDR 11.
    let set_prm = [0x80, 0, 0, 11, 0x0F, 0xA1, 0, 0x33];
    fixture.edge.master_7_sends(12, &[(Some(61), &set_prm), (Some(62), pump().chk_cfg()), (None, &[0x05])]);
    let turbo = fixture.exchanging("turbo");
    assert_eq!(shown(&turbo, "speed"), (Some(1000.0), "1000 Hz".to_owned(), Quality::Valid));
    assert!(turbo.listen_only);
    device.state().inputs = vec![0x01, 0xF4, 3, 0];
    fixture.until("turbo", Duration::from_secs(2), |gauge| shown(gauge, "speed").0 == Some(500.0));
    assert_eq!(recorded(&fixture, "speed").last(), Some(&(Some(500.0), Quality::Valid)));
    assert_eq!(device.state().user_prm, Some(vec![0x33]), "the parameters are those of its master");
    assert_eq!(device.state().outputs.last(), Some(&Some(vec![0x05])), "its outputs too");
}

#[test]
fn a_point_in_a_record_is_read_over_ms2_and_is_stale_after_three_missed_reads() {
    let device = TestSlave::new(12, &pump());
    device.state().inputs = vec![0x03, 0xE8, 3, 0];
    device.state().records.insert((1, 24), vec![0, 0, 0x2A]);
    let record = Some(WatchedRecord { slot: 1, index: 24, every: Duration::from_secs(10) });
    let hours = SlavePoint { record, unit: Some("h"), ..point("hours", PointType::U16, 1) };
    let beyond = SlavePoint { record, ..point("beyond", PointType::U8, 3) };
    let watched = config::Slave { points: [slave(false).points, vec![hours, beyond]].concat(), ..slave(false) };
    let config = config::Segment { slaves: vec![watched], ..polled(&[]) };
    let mut fixture = Fixture::<PolledLine>::new(config, VirtualEdge::with_slaves(&[]).and(&[&device]));
    fixture.edge.master_7_sends(12, &[(Some(61), &SET_PRM), (Some(62), pump().chk_cfg()), (None, &[0x05])]);
    let is_read = |gauge: &Gauge| shown(gauge, "hours").2 == Quality::Valid;
    let turbo = fixture.until("turbo", Duration::from_secs(10), is_read);
    assert_eq!(shown(&turbo, "hours"), (Some(42.0), "42 h".to_owned(), Quality::Valid));
    assert_eq!(shown(&turbo, "speed").0, Some(1000.0), "the inputs stay");
    assert_eq!(shown(&turbo, "beyond"), (None, "not in the record".to_owned(), Quality::Fault));
    device.state().records.insert((1, 24), vec![0, 1, 0]);
    fixture.run_for(Duration::from_secs(5));
    assert_eq!(shown(&fixture.gauge("turbo"), "hours").0, Some(42.0), "it is read every 10 s");
    fixture.until("turbo", Duration::from_secs(10), |gauge| shown(gauge, "hours").0 == Some(256.0));
    device.state().records.remove(&(1, 24));
    device.state().records.insert((1, 25), vec![0]);
    fixture.run_for(Duration::from_secs(21));
    assert_eq!(shown(&fixture.gauge("turbo"), "hours").0, Some(256.0), "two reads were refused");
    let turbo = fixture.until("turbo", Duration::from_secs(15), |gauge| shown(gauge, "hours").2 == Quality::Stale);
    assert_eq!((shown(&turbo, "hours").0, turbo.state), (None, BusStationState::DataExchange));
    let cause = shown(&turbo, "hours").1;
    assert!(cause.starts_with("record 1/24 was not read: refused with "), "{cause}");
    fixture.run_for(Duration::from_mins(2));
    let told: Vec<_> = fixture.events("turbo: record").into_iter().map(|event| event.text).collect();
    assert_eq!(told, [format!("turbo: {cause}")], "one event, not one for each read");
    device.state().records.insert((1, 24), vec![0, 0, 1]);
    let turbo = fixture.until("turbo", Duration::from_secs(15), is_read);
    assert_eq!(shown(&turbo, "hours").1, "1 h");
    assert_eq!(fixture.events("turbo: record 1/24 is read again").len(), 1);
    assert_eq!(device.state().user_prm, Some(vec![0x33]), "the station sends no Set_Prm");
}

/// The operating hours of a pump that is switched off are in a record, and MS2 needs no data exchange.
#[test]
fn a_slave_whose_points_are_all_in_records_is_read_while_no_master_exchanges_data_with_it() {
    let device = TestSlave::new(12, &pump());
    device.state().records.insert((1, 24), vec![0, 0x2A]);
    let record = Some(WatchedRecord { slot: 1, index: 24, every: Duration::from_secs(10) });
    let hours = SlavePoint { record, unit: Some("h"), ..point("hours", PointType::U16, 0) };
    let watched = config::Slave { points: vec![hours], ..slave(false) };
    let config = config::Segment { slaves: vec![watched], ..polled(&[]) };
    let mut fixture = Fixture::<PolledLine>::new(config, VirtualEdge::with_slaves(&[]).and(&[&device]));
    let is_read = |gauge: &Gauge| shown(gauge, "hours").2 == Quality::Valid;
    let turbo = fixture.until("turbo", Duration::from_secs(10), is_read);
    assert_eq!(shown(&turbo, "hours").1, "42 h");
    assert_eq!(turbo.state, BusStationState::Missing, "it is not in data exchange");
    let problem = "no master exchanges data with it: its records are read";
    assert_eq!(turbo.problem.as_deref(), Some(problem));
    for _ in 0..20 {
        fixture.run_for(Duration::from_secs(1));
        let turbo = fixture.gauge("turbo");
        assert!(is_read(&turbo) && turbo.age_ms.is_some_and(|age| age <= turbo.stale_after_ms), "{turbo:?}");
    }
    assert_eq!(fixture.events(&format!("turbo: {problem}")).len(), 1);
    assert_eq!(device.state().user_prm, None, "the station sends no Set_Prm");
    assert!(device.state().outputs.is_empty(), "{:?}", device.state().outputs);

    // Its master comes, and goes on with the values of the records.
    fixture.edge.master_7_sends(12, &[(Some(61), &SET_PRM), (Some(62), pump().chk_cfg()), (None, &[0x05])]);
    assert!(is_read(&fixture.exchanging("turbo")));
    fixture.change(|plant| plant.is_silent = true);
    let turbo = fixture.until_problem("turbo", "no slave answers");
    assert_eq!(shown(&turbo, "hours"), (None, String::new(), Quality::Stale));
    assert_eq!(recorded(&fixture, "hours").last(), Some(&(None, Quality::Stale)));
}

/// Set_Prm of master 7: locked, without a watchdog, min T_SDR 11.
const SET_PRM: [u8; 8] = [0x80, 0, 0, 11, 0x0F, 0xA1, 0, 0x33];

/// Modules with inputs of the same length, whose octets mean something else.
fn other_modules() -> Arc<GsdSlave> {
    let text = String::from_utf8(PUMP.to_vec()).unwrap().replace("\"Speed\" 0x51", "\"Current\" 0x13");
    let modules = Modules::InOrder(vec![ModuleChoice::Number(1), ModuleChoice::Number(2)]);
    let file = Arc::new(GsdFile::read(text.as_bytes()));
    Arc::new(GsdSlave::new(file, &Selection { modules, changes: Vec::new() }).unwrap())
}

#[test]
fn rd_inp_shows_no_values_of_a_slave_with_other_modules_of_the_same_length() {
    let (own, other) = (pump(), other_modules());
    assert_eq!(own.lengths().inputs, other.lengths().inputs);
    let device = TestSlave::new(12, &other);
    let mut fixture = Fixture::<PolledLine>::new(segment(false), VirtualEdge::with_slaves(&[]).and(&[&device]));
    fixture.edge.master_7_sends(12, &[(Some(61), &SET_PRM), (Some(62), other.chk_cfg()), (None, &[0x05])]);
    let turbo = fixture.until_problem("turbo", "correct modules");
    assert_eq!((turbo.state, shown(&turbo, "speed").2), (BusStationState::Missing, Quality::Stale));
}

/// The slave refuses Chk_Cfg, and Get_Cfg shows why.
#[test]
fn an_owned_slave_with_other_modules_plugged_says_which_configuration_it_has() {
    let device = TestSlave::new(12, &other_modules());
    let mut fixture = Fixture::<PolledLine>::new(segment(true), VirtualEdge::with_slaves(&[]).and(&[&device]));
    let remark = "(Cfg_Fault): it has the configuration 13 20, the chosen modules need 51 20";
    let turbo = fixture.until_problem("turbo", remark);
    assert_eq!((turbo.state, shown(&turbo, "speed").2), (BusStationState::Missing, Quality::Stale));
    fixture.run_for(Duration::from_secs(30));
    assert!(fixture.gauge("turbo").problem.is_some_and(|problem| problem.contains(remark)));
    assert_eq!(fixture.events("it has the configuration").len(), 1);
}

#[test]
fn a_slave_that_is_read_with_rd_inp_has_its_diagnosis() {
    let device = TestSlave::new(12, &pump());
    let mut fixture = Fixture::<PolledLine>::new(segment(false), VirtualEdge::with_slaves(&[]).and(&[&device]));
    device.report(&[0x02, 0x02]);
    fixture.edge.master_7_sends(12, &[(Some(61), &SET_PRM), (Some(62), pump().chk_cfg()), (None, &[0x05])]);
    let turbo = fixture.until("turbo", Duration::from_secs(30), |gauge| gauge.state == BusStationState::Fault);
    assert_eq!(
        (turbo.exceptions, turbo.parameters.len()),
        (vec!["vendor-specific octets 02: Bearing is hot".to_owned()], 2)
    );
}

#[test]
fn another_device_at_the_address_is_not_taken() {
    let other = GsdFile::read(&String::from_utf8(PUMP.to_vec()).unwrap().replace("0FA1", "0FA2").into_bytes());
    let modules = Modules::InOrder(vec![ModuleChoice::Number(1), ModuleChoice::Number(2)]);
    let other = Arc::new(GsdSlave::new(Arc::new(other), &Selection { modules, changes: Vec::new() }).unwrap());
    let device = TestSlave::new(12, &other);
    let mut fixture = Fixture::<PolledLine>::new(segment(true), VirtualEdge::with_slaves(&[]).and(&[&device]));
    fixture.until_problem("turbo", "0x0FA2");
    assert_eq!(device.state().user_prm, None);
}

/// Data_Exchange of master 1 with the slave at address 12: the request and its answer.
fn exchange(inputs: &[u8], toggle: bool) -> Vec<u8> {
    let fc = if toggle { 0x7D } else { 0x5D };
    let request = DataTelegram { da: 12, sa: 1, dsap: None, ssap: None, fc, du: &[0x01] };
    let answer = DataTelegram { da: 1, sa: 12, dsap: None, ssap: None, fc: 0x08, du: inputs };
    [octets(request), octets(answer)].concat()
}

fn octets(telegram: DataTelegram<'_>) -> Vec<u8> {
    let mut octets = [0; MAX_TELEGRAM];
    let length = Telegram::Data(telegram).emit(&mut octets).unwrap();
    octets[..length].to_vec()
}

fn hears_until_exchanging<L: crate::segment::runner::Line>(fixture: &mut Fixture<L>, inputs: &[u8]) -> Gauge {
    for round in 0..500 {
        fixture.change(|plant| plant.hear(exchange(inputs, round % 2 == 0)));
        fixture.run_for(Duration::from_millis(20));
        let turbo = fixture.gauge("turbo");
        if turbo.state == BusStationState::DataExchange && turbo.age_ms.is_some_and(|age| age < 1000) {
            return turbo;
        }
    }
    panic!("{:?}", fixture.gauge("turbo"));
}

#[test]
fn a_listener_hears_the_points_of_a_slave_of_another_master_and_their_loss() {
    let config = config::Segment { listen_only: true, ..segment(false) };
    let mut fixture = Fixture::<HeardLine>::new(config, VirtualEdge::with_slaves(&[]));
    let turbo = hears_until_exchanging(&mut fixture, &[0x01, 0xF4, 3, 0]);
    assert!(turbo.listen_only);
    assert_eq!(shown(&turbo, "speed"), (Some(500.0), "500 Hz".to_owned(), Quality::Valid));
    let turbo = fixture.until_problem("turbo", "not heard any more");
    assert_eq!(shown(&turbo, "speed").2, Quality::Stale);
    let values = recorded(&fixture, "speed");
    assert_eq!(values.first(), Some(&(Some(500.0), Quality::Valid)));
    assert_eq!(values.last(), Some(&(None, Quality::Stale)));
}

/// Answer to Slave_Diag of master 1: the slave at address 12 with this second octet of the status.
fn diagnosis(status_2: u8) -> Vec<u8> {
    let du = [0, status_2, 0, 1, 0x0F, 0xA1];
    let request = DataTelegram { da: 12, sa: 1, dsap: Some(60), ssap: Some(62), fc: 0x6D, du: &[] };
    let answer = DataTelegram { da: 1, sa: 12, dsap: Some(62), ssap: Some(60), fc: 0x08, du: &du };
    [octets(request), octets(answer)].concat()
}

/// profibus-wire 2.3: with Stat_Diag a slave has no valid process data.
#[test]
fn inputs_that_the_slave_calls_invalid_are_no_values() {
    let config = config::Segment { listen_only: true, ..segment(false) };
    let mut fixture = Fixture::<HeardLine>::new(config, VirtualEdge::with_slaves(&[]));
    hears_until_exchanging(&mut fixture, &[0x01, 0xF4, 3, 0]);
    for round in 0..20 {
        fixture.change(|plant| plant.hear(diagnosis(0x06)));
        fixture.run_for(Duration::from_millis(10));
        fixture.change(|plant| plant.hear(exchange(&[0x01, 0xF4, 3, 0], round % 2 == 0)));
        fixture.run_for(Duration::from_millis(20));
    }
    let turbo = fixture.gauge("turbo");
    assert!(turbo.problem.as_deref().is_some_and(|problem| problem.contains("Stat_Diag")), "{turbo:?}");
    assert_eq!(shown(&turbo, "speed"), (None, String::new(), Quality::Stale));
    fixture.change(|plant| plant.hear(diagnosis(0x04)));
    fixture.run_for(Duration::from_millis(10));
    hears_until_exchanging(&mut fixture, &[0x01, 0xF4, 3, 0]);
}

#[test]
fn a_slave_that_toggles_stat_diag_is_no_flood_and_the_changes_without_an_event_are_counted() {
    let config = config::Segment { listen_only: true, ..segment(false) };
    let mut fixture = Fixture::<HeardLine>::new(config, VirtualEdge::with_slaves(&[]));
    hears_until_exchanging(&mut fixture, &[0x01, 0xF4, 3, 0]);
    let mut hear = |status: u8, round: u64| {
        fixture.change(|plant| plant.hear(diagnosis(status)));
        fixture.run_for(Duration::from_millis(20));
        fixture.change(|plant| plant.hear(exchange(&[0x01, 0xF4, 3, 0], round.is_multiple_of(2))));
        fixture.run_for(Duration::from_millis(180));
        fixture.events("turbo: ").into_iter().map(|event| event.text).collect::<Vec<_>>()
    };
    let mut told = Vec::new();
    for round in 0..100 {
        told = hear(if round % 4 < 2 { 0x06 } else { 0x04 }, round);
    }
    assert!((3..=7).contains(&told.len()), "{} events in 20 s: {told:?}", told.len());
    for round in 0..300 {
        told = hear(0x04, round);
    }
    let last = told.last().unwrap();
    assert!(
        last.starts_with("turbo: in data exchange (")
            && last.ends_with(" earlier changes had no event: at most 6 a minute)"),
        "{last}"
    );
    assert!(told.len() <= 8, "{told:?}");
}

#[test]
fn inputs_of_another_length_than_the_modules_are_no_values() {
    let config = config::Segment { listen_only: true, ..segment(false) };
    let mut fixture = Fixture::<HeardLine>::new(config, VirtualEdge::with_slaves(&[]));
    for round in 0..50 {
        fixture.change(|plant| plant.hear(exchange(&[1, 2, 3], round % 2 == 0)));
        fixture.run_for(Duration::from_millis(20));
    }
    let turbo = fixture.gauge("turbo");
    assert_eq!(turbo.state, BusStationState::Missing);
    let problem = turbo.problem.unwrap();
    assert!(problem.contains("3 octets") && problem.contains("compare modules"), "{problem}");
}

/// Each request takes longer than the interval: both slaves are due again whenever one ends.
#[test]
fn slaves_whose_requests_take_long_are_asked_in_turn() {
    let mut now = Moment { at: Instant::now(), wall: Micros(0) };
    let named = |name: &str| SegmentSlave::new(config::Slave { name: name.to_owned(), ..slave(false) }, now);
    let mut slaves = [named("a"), named("b")];
    let mut asked = String::new();
    for _ in 0..4 {
        now.at += Duration::from_secs(4);
        asked += &next_request(&mut slaves, now).unwrap().config.name;
    }
    assert_eq!(asked, "abab");
}
