//! Slaves by their GSD files: owned, heard, and read with RD_Inp.

use super::fixture::{Fixture, POLL, polled};
use super::plant::VirtualEdge;
use super::test_slave::TestSlave;
use crate::config::{self, PointType, SlavePoint};
use crate::segment::heard_line::HeardLine;
use crate::segment::moment::Moment;
use crate::segment::polled_line::PolledLine;
use crate::segment::slave::{SegmentSlave, next_request};
use crate::view::{BusStationState, Gauge, GaugeKind, WatchedParameter};
use profivac_gsd::GsdFile;
use profivac_gsd_slave::{GsdSlave, ModuleChoice, Modules, Selection};
use profivac_recorder::{Micros, Quality};
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
        kind,
        octet,
        bit: 0,
        is_little_endian: false,
        scale: 1.0,
        offset: 0.0,
        unit: None,
        texts: Vec::new(),
        status: None,
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
    assert_eq!(turbo.exceptions, ["Bearing is hot", "slot 2 Control channel 2: No cooling water"]);
    assert_eq!(fixture.events("turbo: Bearing is hot, slot 2 Control channel 2: No cooling water").len(), 1);
    device.report(&[]);
    let turbo = fixture.exchanging("turbo");
    assert!(turbo.exceptions.is_empty(), "{turbo:?}");
    assert_eq!(fixture.events("turbo: no diagnosis").len(), 1);
}

/// A pump that has reported a fault is switched off, or heard with other modules: its diagnosis is no news at each sample.
#[test]
fn the_last_diagnosis_of_a_slave_without_values_is_no_flood_of_events() {
    let device = TestSlave::new(12, &pump());
    let mut fixture = Fixture::<PolledLine>::new(segment(true), VirtualEdge::with_slaves(&[]).and(&[&device]));
    fixture.exchanging("turbo");
    device.report(&[0x02, 0x02]);
    fixture.until("turbo", Duration::from_secs(5), |gauge| gauge.state == BusStationState::Fault);
    assert_eq!(fixture.events("turbo: Bearing is hot").len(), 1);
    fixture.change(|plant| plant.is_silent = true);
    let turbo = fixture.until("turbo", Duration::from_secs(30), |gauge| gauge.state == BusStationState::Missing);
    fixture.run_for(Duration::from_secs(5));
    assert_eq!(fixture.events("turbo: Bearing is hot").len(), 1);
    assert!(turbo.exceptions.is_empty(), "{turbo:?}");
    fixture.change(|plant| plant.is_silent = false);
    fixture.until("turbo", Duration::from_secs(60), |gauge| gauge.state == BusStationState::Fault);
    assert_eq!(fixture.events("turbo: Bearing is hot").len(), 2, "it still has the fault");
}

/// Identifiers 2 and 20 belong to no module of the file, and neither stands for the other.
#[test]
fn each_identifier_without_a_module_is_reported() {
    let device = TestSlave::new(12, &pump());
    let mut fixture = Fixture::<PolledLine>::new(segment(true), VirtualEdge::with_slaves(&[]).and(&[&device]));
    fixture.exchanging("turbo");
    device.report(&[0x44, 0x04, 0x00, 0x10]);
    let turbo = fixture.until("turbo", Duration::from_secs(5), |gauge| gauge.state == BusStationState::Fault);
    assert_eq!(turbo.exceptions, ["identifier 2 reports a diagnosis", "identifier 20 reports a diagnosis"]);
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
    let told = count(&fixture, "turbo: Bearing is hot") + count(&fixture, "turbo: no diagnosis");
    assert!((2..=6).contains(&told), "{told} events in 10 s");
    device.report(&[0x02, 0x02]);
    fixture.run_for(Duration::from_mins(1));
    assert_eq!(fixture.events("turbo: ").last().unwrap().text, "turbo: Bearing is hot");
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

#[test]
fn a_slave_that_the_station_does_not_own_gets_no_parameters() {
    let device = TestSlave::new(12, &pump());
    let edge = VirtualEdge::with_slaves(&[]).and(&[&device]);
    let mut fixture = Fixture::<PolledLine>::new(segment(false), edge);
    let turbo = fixture.until_problem("turbo", "in data exchange with no master");
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
    assert_eq!(device.state().user_prm, Some(vec![0x33]), "the parameters are those of its master");
    assert_eq!(device.state().outputs.last(), Some(&Some(vec![0x05])), "its outputs too");
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

#[test]
fn a_slave_that_is_read_with_rd_inp_has_its_diagnosis() {
    let device = TestSlave::new(12, &pump());
    let mut fixture = Fixture::<PolledLine>::new(segment(false), VirtualEdge::with_slaves(&[]).and(&[&device]));
    device.report(&[0x02, 0x02]);
    fixture.edge.master_7_sends(12, &[(Some(61), &SET_PRM), (Some(62), pump().chk_cfg()), (None, &[0x05])]);
    let turbo = fixture.until("turbo", Duration::from_secs(30), |gauge| gauge.state == BusStationState::Fault);
    assert_eq!((turbo.exceptions, turbo.parameters.len()), (vec!["Bearing is hot".to_owned()], 2));
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
