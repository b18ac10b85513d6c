//! The edge node of Sparkplug B as a state machine: births, data, deaths, rebirth, primary host and backlog.

#![allow(clippy::unwrap_used, clippy::panic, reason = "a test")]

use profivac_devices::Principle;
use profivac_gateway::model::Modeller;
use profivac_gateway::{Inputs, Signal, Snapshot, State};
use profivac_gateway_mqtt::message::{Delivery, Message};
use profivac_gateway_mqtt::sparkplug::backlog::{Backlog, Batch, Recorded, Series};
use profivac_gateway_mqtt::sparkplug::edge_node::{EdgeNode, Names, Phase, REBIRTH, Reaction};
use profivac_gateway_mqtt::sparkplug::metric;
use profivac_gateway_mqtt::sparkplug::payload::{Metric, MetricValue, Payload, Property, datatype};
use profivac_recorder::{Micros, Point, PointKind, PointSample, Quality, Reader, Recorder, Sample, Settings};
use profivac_station::config::gateways::mqtt::DataStyle;
use profivac_station::view::BusStationState;
use prost::Message as _;
use std::collections::{BTreeSet, HashSet};
use std::path::Path;
use std::sync::Arc;

const FILE: &str = r#"
[[segment]]
name = "hall"
port = "sim:hall.toml"

[[segment.gauge]]
name = "chamber"
address = 5
device = "bcg450"

[[segment.gauge]]
name = "fore/line"
address = 6
device = "tpg300"

[[alarm]]
name = "Chamber high"
gauge = "chamber"
above = "1e-3 mbar"
priority = "high"
"#;

const SECOND: i64 = Micros::SECOND;
const NOW: Micros = Micros(1_800_000_000 * SECOND);

/// A station whose gauges can be changed.
struct Plant {
    modeller: Modeller,
    inputs: Inputs,
}

impl Plant {
    /// The gauge chamber measures 1 Pa; the controller is missing.
    fn new() -> Self {
        let inputs = Inputs::planned(&profivac_config::parse(FILE, Path::new("plant.toml")).unwrap());
        let mut plant = Self { modeller: Modeller::default(), inputs };
        plant.inputs.gauges[1].state = BusStationState::Missing;
        plant.measures(1.0, NOW);
        plant
    }

    fn measures(&mut self, pa: f64, at: Micros) {
        let gauge = &mut self.inputs.gauges[0];
        gauge.state = BusStationState::DataExchange;
        (gauge.age_ms, gauge.read_at) = (Some(10), Some(at));
        (gauge.readings[0].quality, gauge.readings[0].pa) = (Quality::Valid, Some(pa));
    }

    fn snapshot(&mut self) -> Arc<Snapshot> {
        Arc::new(self.modeller.next(self.inputs.clone(), NOW))
    }
}

fn names(primary_host: Option<&str>) -> Names {
    let primary_host = primary_host.map(str::to_owned);
    let (group, edge_node) = ("TargetHall".to_owned(), "station-1".to_owned());
    Names { group, edge_node, primary_host, data: DataStyle::Aliases }
}

fn payload(message: &Message) -> Payload {
    Payload::decode(&message.payload[..]).unwrap()
}

/// An edge node after its births, and the births.
fn born(plant: &mut Plant) -> (EdgeNode, Vec<Message>) {
    let mut node = EdgeNode::new(names(None), 7, None);
    node.subscribed();
    let births = node.births(&plant.snapshot(), &HashSet::new(), NOW);
    assert!(node.caught_up(NOW, NOW).is_empty());
    assert_eq!(node.phase(), Phase::Live);
    (node, births)
}

fn topics(messages: &[Message]) -> Vec<&str> {
    messages.iter().map(|message| message.topic.as_str()).collect()
}

fn named<'a>(payload: &'a Payload, name: &str) -> &'a Metric {
    payload.metrics.iter().find(|metric| metric.name.as_deref() == Some(name)).unwrap_or_else(|| panic!("no {name}"))
}

/// The pressures of a gauge.
fn pressures(name: &str) -> Series {
    Series::Pressures(Arc::from(name))
}

fn property<'a>(metric: &'a Metric, key: &str) -> Option<&'a Property> {
    let properties = metric.properties.as_ref()?;
    let position = properties.keys.iter().position(|it| it == key)?;
    properties.values[position].value.as_ref()
}

fn rebirth() -> Vec<u8> {
    let metric =
        Metric { name: Some(REBIRTH.to_owned()), value: Some(MetricValue::Boolean(true)), ..Metric::default() };
    Payload { timestamp: None, metrics: vec![metric], seq: None }.encode_to_vec()
}

const NCMD: &str = "spBv1.0/TargetHall/NCMD/station-1";

/// tck-id-payloads-ndeath-will-message, tck-id-topics-nbirth-bdseq-matching, tck-id-payloads-sequence-num-zero-nbirth,
/// tck-id-operational-behavior-data-commands-rebirth-name-aliases.
#[test]
fn the_birth_has_the_number_of_the_will_and_the_rebirth_command_without_an_alias() {
    let (node, births) = born(&mut Plant::new());
    let will = node.death(NOW);
    assert_eq!(
        (will.topic.as_str(), will.delivery, will.is_retained),
        ("spBv1.0/TargetHall/NDEATH/station-1", Delivery::AtLeastOnce, false)
    );
    assert_eq!(payload(&will).seq, None, "tck-id-payloads-sequence-num-always-included: except NDEATH");
    let birth = payload(&births[0]);
    assert_eq!((births[0].delivery, births[0].is_retained), (Delivery::AtMostOnce, false), "tck-id-topics-nbirth-mqtt");
    assert_eq!((birth.seq, birth.timestamp), (Some(0), Some(1_800_000_000_000)));
    let number = named(&birth, "bdSeq");
    assert_eq!((&number.value, number.datatype), (&Some(MetricValue::Long(7)), Some(datatype::INT64)));
    assert_eq!(payload(&will).metrics[0].value, number.value);
    let command = named(&birth, REBIRTH);
    assert_eq!((&command.value, command.alias), (&Some(MetricValue::Boolean(false)), None));
    assert_eq!(command.datatype, Some(datatype::BOOLEAN), "tck-id-operational-behavior-data-commands-rebirth-datatype");
}

/// tck-id-payloads-alias-uniqueness, tck-id-payloads-alias-birth-requirement, tck-id-topics-nbirth-metrics.
#[test]
fn every_point_is_born_once_with_name_alias_type_and_value_or_null() {
    let mut plant = Plant::new();
    plant.inputs.gauges[1].state = BusStationState::DataExchange;
    let (_, births) = born(&mut plant);
    let all = "spBv1.0/TargetHall/";
    assert_eq!(
        topics(&births),
        ["NBIRTH/station-1", "DBIRTH/station-1/chamber", "DBIRTH/station-1/fore%2Fline"].map(|it| format!("{all}{it}"))
    );
    let mut aliases = BTreeSet::new();
    for birth in births.iter().map(payload) {
        let mut names = BTreeSet::new();
        for metric in &birth.metrics {
            assert!(names.insert(metric.name.clone().unwrap()), "{metric:?}");
            assert!(metric.datatype.is_some() && metric.timestamp.is_some());
            assert_eq!(metric.value.is_none(), metric.is_null == Some(true), "{metric:?}");
            let is_control = ["bdSeq", REBIRTH].contains(&metric.name.as_deref().unwrap());
            assert!(metric.alias.map_or(is_control, |alias| aliases.insert(alias)), "{metric:?}");
        }
    }
    assert_eq!(aliases.len(), plant.snapshot().points.len(), "every point has its metric");
}

#[test]
fn the_birth_of_a_gauge_has_unit_range_limits_quality_and_says_that_it_is_virtual() {
    let (_, births) = born(&mut Plant::new());
    let birth = payload(&births[1]);
    let pressure = named(&birth, "Pressure");
    assert_eq!((&pressure.value, pressure.datatype), (&Some(MetricValue::Float(1.0)), Some(datatype::FLOAT)));
    assert_eq!(pressure.timestamp, Some(1_800_000_000_000), "the time of the reading");
    assert_eq!(property(pressure, "engUnit"), Some(&Property::String("Pa".to_owned())));
    assert_eq!(property(pressure, "simulated"), Some(&Property::Boolean(true)));
    assert_eq!(property(pressure, "Quality"), Some(&Property::Int(192)));
    let number = |key| match property(pressure, key) {
        Some(Property::Double(number)) => *number,
        other => panic!("{key}: {other:?}"),
    };
    let is_close = |key, pa: f64| (number(key) / pa - 1.0).abs() < 1e-9;
    assert!(is_close("engLow", 5e-8) && is_close("engHigh", 1.5e5) && is_close("limitHighHigh", 0.1));
    assert_eq!(named(&birth, "PressureLog10").value, Some(MetricValue::Float(0.0)));
    assert_eq!(named(&birth, "State").value, Some(MetricValue::Int(0)));
    named(&birth, "Alarm/Priority");
    named(&birth, "Alarm/Unacknowledged");
}

/// tck-id-payloads-sequence-num-incrementing, tck-id-payloads-alias-data-cmd-requirement.
#[test]
fn data_has_aliases_alone_and_the_next_sequence_number_which_wraps_after_255() {
    let mut plant = Plant::new();
    let (mut node, births) = born(&mut plant);
    let pressure = named(&payload(&births[1]), "Pressure").alias;
    let mut expected = births.len() as u64;
    for step in 1..=300_i32 {
        let at = Micros(NOW.0 + i64::from(step) * SECOND / 5);
        plant.measures(f64::from(step) + 1.0, at);
        let (messages, _) = node.snapshot(&plant.snapshot(), NOW);
        for message in &messages {
            let data = payload(message);
            assert_eq!(data.seq, Some(expected % 256));
            expected += 1;
            assert!(data.metrics.iter().all(|metric| metric.name.is_none() && metric.alias.is_some()));
        }
        let data = payload(messages.iter().find(|message| message.topic.ends_with("DDATA/station-1/chamber")).unwrap());
        let metric = data.metrics.iter().find(|metric| metric.alias == pressure).unwrap();
        assert_eq!(metric.value, Some(MetricValue::Float(step as f32 + 1.0)));
        assert_eq!(metric.timestamp, Some(metric::milliseconds(at)));
        assert_eq!(metric.is_historical, None);
    }
    assert!(expected > 300);
}

/// Hosts that do not keep births read data by names and data types; aliases in births would forbid names in data
/// (tck-id-payloads-alias-data-cmd-requirement).
#[test]
fn data_with_names_has_data_types_and_no_message_has_aliases() {
    let mut plant = Plant::new();
    let mut node = EdgeNode::new(Names { data: DataStyle::Names, ..names(None) }, 0, None);
    node.subscribed();
    let births = node.births(&plant.snapshot(), &HashSet::new(), NOW);
    let sample = Sample::new(Micros(NOW.0 - SECOND), Some(1.5), Quality::Valid);
    let history = node.samples(&[(pressures("chamber"), Recorded::Pressure(sample))], NOW);
    let present = node.caught_up(NOW, NOW);
    plant.measures(2.0, NOW);
    let (data, _) = node.snapshot(&plant.snapshot(), NOW);
    let metrics = |messages: &[Message]| messages.iter().flat_map(|it| payload(it).metrics).collect::<Vec<_>>();
    let all = [metrics(&births), metrics(&history), metrics(&present), metrics(&data)].concat();
    assert!(all.iter().all(|it| it.alias.is_none() && it.name.is_some() && it.datatype.is_some()), "{all:?}");
    let pressures = |messages: &[Message]| {
        let metrics = metrics(messages).into_iter().filter(|it| it.name.as_deref() == Some("Pressure"));
        metrics.map(|it| (it.value, it.datatype, it.is_historical)).collect::<Vec<_>>()
    };
    let float = Some(datatype::FLOAT);
    assert_eq!(pressures(&history), [(Some(MetricValue::Float(1.5)), float, Some(true))]);
    assert_eq!(pressures(&data), [(Some(MetricValue::Float(2.0)), float, None)]);
}

/// tck-id-operational-behavior-device-ddeath, tck-id-payloads-propertyset-quality-value-value.
#[test]
fn a_missing_gauge_dies_and_is_born_again_and_a_starting_one_does_neither() {
    let mut plant = Plant::new();
    let (mut node, births) = born(&mut plant);
    assert_eq!(births.len(), 2, "the missing controller has no birth");
    plant.inputs.gauges[0].state = BusStationState::Starting;
    let (messages, _) = node.snapshot(&plant.snapshot(), NOW);
    let data = payload(messages.iter().find(|message| message.topic.contains("/DDATA/")).unwrap());
    let pressure = named(&payload(&births[1]), "Pressure").alias;
    let metric = data.metrics.iter().find(|metric| metric.alias == pressure).unwrap();
    assert_eq!((&metric.value, metric.is_null), (&None, Some(true)));
    assert_eq!(property(metric, "Quality"), Some(&Property::Int(500)));
    plant.inputs.gauges[0].state = BusStationState::Missing;
    let (messages, _) = node.snapshot(&plant.snapshot(), NOW);
    assert!(topics(&messages).contains(&"spBv1.0/TargetHall/DDEATH/station-1/chamber"));
    assert!(!topics(&messages).iter().any(|topic| topic.contains("/DDATA/")), "no data of a device that has died");
    plant.measures(2.0, NOW);
    let (messages, _) = node.snapshot(&plant.snapshot(), NOW);
    assert!(topics(&messages).contains(&"spBv1.0/TargetHall/DBIRTH/station-1/chamber"));
}

/// tck-id-operational-behavior-data-commands-rebirth-action-1 to -3.
#[test]
fn a_rebirth_stops_data_gives_all_births_with_the_same_number_and_is_debounced() {
    let mut plant = Plant::new();
    let (mut node, _) = born(&mut plant);
    for _ in 0..50 {
        assert_eq!(node.message(NCMD, &rebirth(), NOW), Reaction::None);
    }
    plant.measures(2.0, Micros(NOW.0 + SECOND));
    assert_eq!(node.snapshot(&plant.snapshot(), NOW).0, [], "data stops");
    assert!(!node.is_rebirth_due(Micros(NOW.0 + SECOND)));
    let later = Micros(NOW.0 + 2 * SECOND);
    assert!(node.is_rebirth_due(later));
    let births = node.births(&plant.snapshot(), &HashSet::new(), later);
    assert_eq!(births.len(), 2);
    let birth = payload(&births[0]);
    assert_eq!((birth.seq, &named(&birth, "bdSeq").value), (Some(0), &Some(MetricValue::Long(7))));
    assert!(!node.is_rebirth_due(Micros(NOW.0 + 60 * SECOND)), "fifty commands are one rebirth");
    assert_eq!(node.phase(), Phase::Live);
}

#[test]
fn other_commands_and_damaged_ones_are_refused() {
    let (mut node, _) = born(&mut Plant::new());
    let write = Metric { name: Some("Pressure".to_owned()), value: Some(MetricValue::Float(1.0)), ..Metric::default() };
    let write = Payload { timestamp: None, metrics: vec![write], seq: None }.encode_to_vec();
    let Reaction::Refused(reason) = node.message(NCMD, &write, NOW) else { panic!("a write is refused") };
    assert!(reason.contains("read-only"), "{reason}");
    assert!(matches!(node.message("spBv1.0/TargetHall/DCMD/station-1/chamber", &write, NOW), Reaction::Refused(_)));
    for octets in [&[0xFF; 100][..], &[0x12, 0x7F, 1], &[0x0A]] {
        assert!(matches!(node.message(NCMD, octets, NOW), Reaction::Refused(_)), "{octets:?}");
    }
    assert!(!node.is_rebirth_due(Micros(NOW.0 + 60 * SECOND)));
}

/// tck-id-message-flow-edge-node-birth-publish-phid-wait, -phid-wait-id, -phid-wait-online, -phid-wait-timestamp,
/// tck-id-operational-behavior-edge-node-termination-host-offline.
#[test]
fn births_wait_for_the_primary_host_and_its_end_is_the_end_of_the_edge_node() {
    let host = "spBv1.0/STATE/scada";
    let state = |online, timestamp| format!("{{\"online\":{online},\"timestamp\":{timestamp}}}").into_bytes();
    let mut node = EdgeNode::new(names(Some("scada")), 0, Some(100));
    assert_eq!(names(Some("scada")).subscriptions().last().map(String::as_str), Some(host));
    node.subscribed();
    assert_eq!(node.phase(), Phase::Waiting);
    for (topic, payload) in [
        ("spBv1.0/STATE/other", state(true, 200)),
        (host, state(true, 99)),
        (host, state(false, 150)),
        (host, b"ONLINE".to_vec()),
        (host, state(true, u64::MAX)),
        (host, b"{\"online\":true}".to_vec()),
    ] {
        node.message(topic, &payload, NOW);
        assert_eq!(node.phase(), Phase::Waiting, "{topic}");
    }
    node.message(host, &state(true, 150), NOW);
    assert_eq!((node.phase(), node.host_at()), (Phase::Ready, Some(150)));
    let mut plant = Plant::new();
    node.births(&plant.snapshot(), &HashSet::new(), NOW);
    node.caught_up(NOW, NOW);
    assert_eq!(node.message(host, &state(false, 149), NOW), Reaction::None, "an old state");
    let Reaction::Disconnect(death) = node.message(host, &state(false, 150), NOW) else {
        panic!("the host is offline")
    };
    assert!(death.topic.contains("/NDEATH/"));
    assert_eq!(node.phase(), Phase::Ended);
    plant.measures(3.0, NOW);
    assert_eq!(node.snapshot(&plant.snapshot(), NOW).0, []);
}

#[test]
fn the_backlog_is_historical_with_original_times_and_comes_before_present_data() {
    let mut plant = Plant::new();
    let mut node = EdgeNode::new(names(None), 0, None);
    node.subscribed();
    let [chamber, line] = ["chamber", "fore/line.2"].map(pressures);
    let with_samples = HashSet::from([line.clone()]);
    let births = node.births(&plant.snapshot(), &with_samples, NOW);
    assert!(topics(&births).contains(&"spBv1.0/TargetHall/DBIRTH/station-1/fore%2Fline"), "its samples need its birth");
    let pressure = named(&payload(&births[1]), "Pressure").alias;
    let second = named(&payload(&births[2]), "2/Pressure").alias;
    plant.measures(5.0, Micros(NOW.0 + SECOND));
    assert_eq!(node.snapshot(&plant.snapshot(), NOW).0, [], "present data waits");
    let sample =
        |second: i64, pa, quality| Recorded::Pressure(Sample::new(Micros(NOW.0 - second * SECOND), pa, quality));
    let samples = [
        (chamber.clone(), sample(30, Some(1.5), Quality::Valid)),
        (line.clone(), sample(25, Some(9.0), Quality::Overrange)),
        (chamber.clone(), sample(20, None, Quality::Stale)),
        (pressures("no longer in the file"), sample(10, Some(1.0), Quality::Valid)),
    ];
    let messages = node.samples(&samples, NOW);
    assert_eq!(
        topics(&messages),
        ["spBv1.0/TargetHall/DDATA/station-1/chamber", "spBv1.0/TargetHall/DDATA/station-1/fore%2Fline"]
    );
    let all: Vec<Metric> = messages.iter().flat_map(|message| payload(message).metrics).collect();
    assert!(all.iter().all(|metric| metric.is_historical == Some(true)));
    let of = |alias| all.iter().filter(|metric| metric.alias == alias).collect::<Vec<_>>();
    let times: Vec<_> = of(pressure).iter().map(|metric| metric.timestamp.unwrap()).collect();
    assert_eq!(times, [1_799_999_970_000, 1_799_999_980_000]);
    assert_eq!((&of(pressure)[1].value, of(pressure)[1].is_null), (&None, Some(true)));
    assert_eq!(property(of(pressure)[1], "Quality"), Some(&Property::Int(500)));
    let bound = of(second)[0];
    assert_eq!((&bound.value, bound.is_null), (&None, Some(true)), "the end of the range is no value");
    assert_eq!(property(bound, "Quality"), Some(&Property::Int(0)));
    let present = node.caught_up(NOW, NOW);
    assert_eq!(node.phase(), Phase::Live);
    assert!(topics(&present).contains(&"spBv1.0/TargetHall/DDEATH/station-1/fore%2Fline"), "the controller is missing");
    let data = payload(present.iter().find(|message| message.topic.ends_with("DDATA/station-1/chamber")).unwrap());
    let metric = data.metrics.iter().find(|metric| metric.alias == pressure).unwrap();
    assert_eq!((&metric.value, metric.is_historical), (&Some(MetricValue::Float(5.0)), None));
}

/// A plant whose turbo pump is missing.
fn plant_with_turbo() -> Plant {
    let folder = tempfile::tempdir().unwrap();
    let gsd = "#Profibus_DP\nIdent_Number = 0x0FA7\nModule = \"m\" 0x12\n1\nEndModule\n";
    std::fs::write(folder.path().join("turbo.gsd"), gsd).unwrap();
    let slave = r#"
[[segment.slave]]
name = "turbo"
address = 9
gsd = "turbo.gsd"
[[segment.slave.point]]
name = "speed"
octet = 0
type = "u16"
unit = "Hz"
[[segment.slave.point]]
name = "state"
octet = 2
type = "u8"
texts = { 3 = "at speed" }
[[alarm]]"#;
    let config = profivac_config::parse(&FILE.replace("[[alarm]]", slave), &folder.path().join("plant.toml")).unwrap();
    let mut plant = Plant { modeller: Modeller::default(), inputs: Inputs::planned(&config) };
    plant.measures(1.0, NOW);
    plant
}

/// A point of the turbo, as it is recorded.
fn point(name: &str, unit: Option<&str>, kind: PointKind) -> Arc<Point> {
    Arc::new(Point { slave: "turbo".to_owned(), name: name.to_owned(), unit: unit.map(str::to_owned), kind })
}

#[test]
fn points_of_a_slave_are_in_the_backlog_with_their_numbers_qualities_and_times() {
    let mut plant = plant_with_turbo();
    let mut node = EdgeNode::new(names(None), 0, None);
    node.subscribed();
    let speed = Series::Point(point("speed", Some("Hz"), PointKind::Number));
    let state = Series::Point(point("state", None, PointKind::Code));
    let births = node.births(&plant.snapshot(), &HashSet::from([speed.clone()]), NOW);
    let birth = births.iter().find(|message| message.topic == "spBv1.0/TargetHall/DBIRTH/station-1/turbo");
    let birth = payload(birth.expect("its samples need its birth"));
    let alias = |name: &str| named(&birth, name).alias;
    let value = |second: i64, number, quality| {
        Recorded::Point(PointSample::new(Micros(NOW.0 - second * SECOND), number, quality))
    };
    let in_rpm = Series::Point(point("speed", Some("rpm"), PointKind::Number));
    let samples = [
        (in_rpm, value(40, Some(60_000.0), Quality::Valid)),
        (speed.clone(), value(30, Some(0.0), Quality::Valid)),
        (state, value(25, Some(3.0), Quality::Valid)),
        (speed.clone(), value(20, None, Quality::Fault)),
        (speed, value(10, None, Quality::Stale)),
    ];
    let messages = node.samples(&samples, NOW);
    assert_eq!(topics(&messages), ["spBv1.0/TargetHall/DDATA/station-1/turbo"]);
    let shown = payload(&messages[0]).metrics.into_iter().map(|metric| {
        assert_eq!(metric.is_historical, Some(true));
        let quality = property(&metric, "Quality").cloned().unwrap();
        (metric.alias, metric.timestamp.unwrap(), metric.value, quality)
    });
    let [speed, state] = ["Parameters/speed/Number", "Parameters/state/Number"].map(alias);
    let expected = [
        (speed, 1_799_999_970_000, Some(MetricValue::Float(0.0)), Property::Int(192)),
        (state, 1_799_999_975_000, Some(MetricValue::Float(3.0)), Property::Int(192)),
        (speed, 1_799_999_980_000, None, Property::Int(0)),
        (speed, 1_799_999_990_000, None, Property::Int(500)),
    ];
    assert_eq!(shown.collect::<Vec<_>>(), expected);
}

#[test]
fn a_backlog_has_pressures_and_points_in_the_order_of_their_times() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("plant.db");
    let recorder = Recorder::start(&path, Settings::default()).unwrap();
    let speed = point("speed", Some("Hz"), PointKind::Number);
    let now = Micros::now();
    let at = |second: i64| Micros(now.0 - second * SECOND);
    let pressure = |second, pa| Sample::new(at(second), Some(pa), Quality::Valid);
    let value = |second, number| PointSample::new(at(second), Some(number), Quality::Valid);
    for (second, number) in [(50, 1000.0), (40, 990.0), (30, 980.0)] {
        recorder.push_point(&speed, 0.0, value(second, number));
    }
    recorder.push(&Arc::from("chamber"), pressure(45, 1.0));
    recorder.push(&Arc::from("chamber"), pressure(35, 10.0));
    assert!(recorder.flush());
    let [of_chamber, of_speed, unrecorded] =
        [pressures("chamber"), Series::Point(speed), Series::Point(point("state", None, PointKind::Code))];
    let series = vec![of_chamber.clone(), of_speed.clone(), unrecorded];
    let mut backlog = Backlog::new(Reader::open(&path).unwrap(), series, at(45), now);
    assert_eq!(backlog.series().unwrap(), HashSet::from([of_chamber.clone(), of_speed.clone()]));
    let expected = vec![
        (of_speed.clone(), Recorded::Point(value(40, 990.0))),
        (of_chamber, Recorded::Pressure(pressure(35, 10.0))),
        (of_speed, Recorded::Point(value(30, 980.0))),
    ];
    assert_eq!(backlog.next(now).unwrap(), Batch::Samples(expected));
}

/// A host does not show a historical value as the present one.
#[test]
fn a_value_that_changed_during_the_backlog_is_published_as_present_also_if_it_was_a_sample() {
    let mut plant = Plant::new();
    let mut node = EdgeNode::new(names(None), 0, None);
    node.subscribed();
    let births = node.births(&plant.snapshot(), &HashSet::new(), NOW);
    let pressure = named(&payload(&births[1]), "Pressure").alias;
    let at = |second: i64| Micros(NOW.0 + second * SECOND);
    for second in 1..=6_i32 {
        let time = at(second.into());
        plant.measures(f64::from(second.min(3)) + 1.0, time);
        assert_eq!(node.snapshot(&plant.snapshot(), time).0, []);
    }
    let sample = Sample::new(at(3), Some(4.0), Quality::Valid);
    node.samples(&[(pressures("chamber"), Recorded::Pressure(sample))], at(6));
    let present = node.caught_up(at(4), at(6));
    let metrics: Vec<Metric> = present.iter().flat_map(|message| payload(message).metrics).collect();
    let values: Vec<_> = metrics.iter().filter(|metric| metric.alias == pressure).collect();
    assert_eq!(values.len(), 1, "{values:?}");
    assert_eq!((&values[0].value, values[0].is_historical), (&Some(MetricValue::Float(4.0)), None));
}

#[test]
fn a_gauge_that_changes_its_measuring_part_is_not_born_again() {
    let mut plant = Plant::new();
    let (mut node, _) = born(&mut plant);
    let before = plant.snapshot();
    let reading = &mut plant.inputs.gauges[0].readings[0];
    reading.principle = match reading.principle {
        Some(Principle::Pirani) => Some(Principle::HotCathode),
        _ => Some(Principle::Pirani),
    };
    plant.measures(2.0, NOW);
    let after = plant.snapshot();
    assert!(!after.has_points_of(&before), "the list of points was made again");
    assert_eq!(topics(&node.snapshot(&after, NOW).0), ["spBv1.0/TargetHall/DDATA/station-1/chamber"]);
}

#[test]
fn a_changed_file_gives_all_births_again() {
    let mut plant = Plant::new();
    let (mut node, births) = born(&mut plant);
    plant.inputs.gauges.truncate(1);
    let (messages, _) = node.snapshot(&plant.snapshot(), NOW);
    assert_eq!(topics(&messages), topics(&births));
    assert_eq!(payload(&messages[0]).seq, Some(0));
}

/// A host that does not look at `Quality` would take the end of the range for a pressure.
#[test]
fn a_pressure_beyond_the_range_is_null_and_bad_and_its_state_is_good() {
    let mut plant = Plant::new();
    let (mut node, births) = born(&mut plant);
    let birth = payload(&births[1]);
    for quality in [Quality::Underrange, Quality::Overrange] {
        let reading = &mut plant.inputs.gauges[0].readings[0];
        (reading.quality, reading.pa, reading.limit_pa) = (quality, None, Some(5e-8));
        let (messages, _) = node.snapshot(&plant.snapshot(), NOW);
        let data = payload(messages.iter().find(|message| message.topic.contains("/DDATA/")).unwrap());
        let metric = |name: &str| data.metrics.iter().find(|metric| metric.alias == named(&birth, name).alias).unwrap();
        for name in ["Pressure", "PressureLog10"] {
            assert_eq!((&metric(name).value, metric(name).is_null), (&None, Some(true)), "{name}");
            assert_eq!(property(metric(name), "Quality"), Some(&Property::Int(0)), "{name}");
        }
        for name in ["State", "StateText", "Usable"] {
            assert_eq!(property(metric(name), "Quality"), Some(&Property::Int(192)), "{name}");
        }
    }
    assert_eq!(metric::quality(Signal::LastReading, State::UnderRange, true), 192);
}

#[test]
fn the_names_of_metrics_are_those_of_the_documentation() {
    let snapshot = Plant::new().snapshot();
    let name = |signal, subject: &str| {
        let found = snapshot.points.iter().find(|point| point.signal == signal && point.subject.name() == subject);
        metric::name(found.unwrap_or_else(|| panic!("{subject} {signal:?}")))
    };
    assert_eq!(name(Signal::LastReading, "chamber"), "LastReading");
    assert_eq!(name(Signal::Pressure, "fore/line.2"), "2/Pressure");
    assert_eq!(name(Signal::SegmentUp, "hall"), "Segments/hall/Up");
    assert_eq!(name(Signal::AlarmState, "Chamber high"), "Alarms/Chamber high/State");
    assert_eq!(name(Signal::Heartbeat, ""), "Heartbeat");
}
