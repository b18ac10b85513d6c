//! The table of docs/readings.md: what a reading of each device is under each condition, through the codec and both state machines.

#![allow(clippy::unwrap_used, clippy::panic, clippy::indexing_slicing, reason = "a test")]

use profivac_client::cyclic::{ChannelValue, CyclicSlave, ReportedChannels};
use profivac_client::ms2::Ms2;
use profivac_client::pressure::Pressure;
use profivac_client::{Gauge, names::NamedParameter};
use profivac_devices::catalog::MODELS;
use profivac_devices::model::{Model, Role};
use profivac_devices::reading::Quality;
use profivac_dp::link::Baud;
use profivac_dp::link::active::BusParameters;
use profivac_dp::slave::Relation;
use profivac_vacuum::Gas;
use profivac_virtual::action_text::ActionText;
use profivac_virtual::device::{GasConditions, VirtualDevice};
use profivac_virtual::device_spec::{DeviceSpec, entry};
use profivac_virtual::memory_segment::MemorySegment;
use profivac_virtual::nonvolatile::NonvolatileMemory;
use profivac_virtual::scenario::cyclic_configuration;

const TABLE: &str = include_str!("../../../docs/readings.md");
const ADDRESS: u8 = 5;
const BAUD: Baud = Baud::B1500000;

/// The time after which every device exchanges data and shows a changed pressure, in seconds.
const SETTLED_S: f64 = 2.0;

/// The conditions of the table, beside the pressure.
#[derive(Clone, Copy, PartialEq)]
enum Condition<'a> {
    Fault(&'a str),
    Emission(bool),
    /// Pirani OFF, tira56e1 12.2.5.
    HeatingOff,
}

/// A row of the table: device spec, pressure in mbar, more conditions, the readings.
struct Row<'a> {
    spec: &'a str,
    mbar: f64,
    conditions: Vec<Condition<'a>>,
    readings: &'a str,
}

fn rows() -> Vec<Row<'static>> {
    let table = TABLE.split("## Each device").nth(1).unwrap();
    let lines = table.lines().filter(|line| line.starts_with("| `"));
    lines
        .map(|line| {
            let cells: Vec<_> = line.trim_matches('|').split('|').map(str::trim).collect();
            let [spec, pressure, more, readings] = cells[..] else { panic!("{line}") };
            let conditions = more.split(", ").filter(|it| !it.is_empty()).map(condition).collect();
            let mbar = pressure.strip_suffix(" mbar").unwrap().parse().unwrap();
            Row { spec: spec.trim_matches('`'), mbar, conditions, readings }
        })
        .collect()
}

fn condition(text: &str) -> Condition<'_> {
    match text {
        "emission on" => Condition::Emission(true),
        "emission off" => Condition::Emission(false),
        "heating off" => Condition::HeatingOff,
        _ => Condition::Fault(text.strip_prefix("fault ").unwrap_or_else(|| panic!("unknown condition {text}"))),
    }
}

/// A segment with one device and a master.
fn segment(row: &Row<'_>) -> MemorySegment {
    let (name, keys) =
        row.spec.split_once(':').map_or((row.spec, String::new()), |(name, keys)| (name, format!(":{keys}")));
    let spec: DeviceSpec = format!("{name}@{ADDRESS}{keys}").parse().unwrap();
    let pressure = Pressure::from_mbar(row.mbar);
    let around = GasConditions { pressure, atmosphere: Pressure::from_mbar(1013.25), gas: Gas::N2 };
    let device = spec.build(NonvolatileMemory::volatile(), BAUD).unwrap();
    let device = VirtualDevice::new(device, ADDRESS, BAUD, around);
    let model = entry(&spec.device).unwrap().model;
    let slave = CyclicSlave {
        address: ADDRESS,
        model,
        configuration: cyclic_configuration(model),
        unit: model.unit_named("mbar").unwrap(),
        channels: ReportedChannels::of_parts(model, device.ranges()),
    };
    MemorySegment::new(vec![device], vec![slave], BusParameters::new(1, BAUD).check().unwrap(), BAUD).unwrap()
}

/// Gives the device a condition.
fn set(device: &mut VirtualDevice, condition: Condition<'_>) {
    let model = device.device().name();
    let mut write = |slot: u8, index: u8, octets: &[u8]| {
        device.device_mut().write(Relation::Ms2(0), slot, index, octets).unwrap();
    };
    match condition {
        Condition::Fault(name) => device.operate_text(ActionText::Fault { name, present: true }).unwrap(),
        // Channel Instance Selector, then Hot Cathode Block State Command.
        Condition::Emission(on) if model == "img400" => {
            (1..=2).for_each(|slot| write(slot, 14, &[3, u8::from(on)]));
        }
        Condition::Emission(on) => {
            write(1, 46, &[2]);
            write(1, 14, &[3, u8::from(on)]);
        }
        Condition::HeatingOff => write(1, 201, &[2]),
    }
}

fn shown(values: &[ChannelValue]) -> String {
    let one = |value: &ChannelValue| match (value.quality, value.pa.or(value.limit_pa)) {
        (Quality::Valid, Some(_)) => "valid".to_owned(),
        (Quality::Underrange, Some(pa)) => format!("underrange < {:.1e} mbar", pa / 100.0),
        (Quality::Overrange, Some(pa)) => format!("overrange > {:.1e} mbar", pa / 100.0),
        (quality, _) => quality.word().to_owned(),
    };
    values.iter().map(one).collect::<Vec<_>>().join("; ")
}

/// The device of a row under its conditions.
fn settled(row: &Row<'_>) -> MemorySegment {
    let mut segment = segment(row);
    segment.run_until(SETTLED_S);
    row.conditions.iter().for_each(|condition| segment.devices_mut().for_each(|device| set(device, *condition)));
    segment.run_until(2.0 * SETTLED_S);
    segment
}

/// Compares every row with the readings that `read` gives.
fn check(rows: impl Iterator<Item = Row<'static>>, read: impl Fn(&mut MemorySegment) -> Vec<ChannelValue>) {
    let mut wrong = Vec::new();
    for row in rows {
        let values = read(&mut settled(&row));
        assert!(values.iter().all(|value| value.pa.is_some() == (value.quality == Quality::Valid)));
        let found = shown(&values);
        if found != row.readings {
            wrong.push(format!("{} at {} mbar: expected {}, got {found}", row.spec, row.mbar, row.readings));
        }
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}

#[test]
fn every_device_has_the_reading_of_the_table_under_each_condition() {
    check(rows().into_iter(), |segment| segment.values(&segment.slaves()[0]).values);
}

fn model(row: &Row<'_>) -> &'static Model {
    entry(row.spec.split(':').next().unwrap()).unwrap().model
}

#[test]
fn every_dpv1_device_has_the_same_readings_over_ms2() {
    check(rows().into_iter().filter(|row| model(row).features.dpv1), |segment| {
        let model = segment.slaves()[0].model;
        let mut gauge = Gauge::with_model(Ms2::new(segment, ADDRESS), ADDRESS, model);
        let names = gauge.names();
        let is_channel = |named: &&NamedParameter| {
            let parameter = named.parameter;
            let is_part = model.parts.iter().any(|spec| spec.part.instance == parameter.location.slot);
            parameter.row.role == Some(Role::ProcessValue) && is_part
        };
        if model.name == "img400" {
            return names.all().iter().filter(is_channel).map(|named| gauge.pressure_of(named).unwrap()).collect();
        }
        vec![gauge.pressure().unwrap()]
    });
}

#[test]
fn the_table_has_every_device_below_within_and_above_its_range_and_with_a_fault() {
    for model in MODELS {
        let rows: Vec<_> = rows().into_iter().filter(|row| row.spec.split(':').next() == Some(model.name)).collect();
        for quality in ["underrange", "overrange", "valid", "fault"] {
            assert!(rows.iter().any(|row| row.readings.contains(quality)), "{}: {quality}", model.name);
        }
    }
}

/// Channel 2 has switched its emission off. The cyclic data have an alarm of the controller and do not tell of which channel.
#[test]
fn an_alarm_of_a_controller_is_no_fault_of_a_channel_and_its_channel_is_named_over_ms2() {
    let conditions = vec![Condition::Emission(true)];
    let mut segment = settled(&Row { spec: "img400", mbar: 1e-3, conditions, readings: "" });
    let slave = segment.slaves()[0];
    let values = segment.values(&slave);
    assert_eq!(values.alarms(), ["device alarm"]);
    assert!(values.has_fault(), "the controller has an alarm");
    let texts: Vec<_> = values.values.iter().map(ChannelValue::text).collect();
    assert_eq!(texts[1], "off: the controller reports an alarm");
    assert!(values.values.iter().all(|value| value.quality != Quality::Fault), "{texts:?}");
    let mut gauge = Gauge::with_model(Ms2::new(&mut segment, ADDRESS), ADDRESS, slave.model);
    let defects = gauge.defects().unwrap();
    assert_eq!(defects.device, ["channel 2: emission switched off, the pressure was too high"]);
}
