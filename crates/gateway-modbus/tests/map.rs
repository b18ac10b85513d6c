//! The map of a station: where its points are, what the registers contain, and that the places stay.

#![allow(clippy::unwrap_used, clippy::panic, reason = "a test")]

#[path = "../../../tests/support/until.rs"]
mod until;

use profivac_devices::model::Role;
use profivac_gateway::model::Modeller;
use profivac_gateway::{Inputs, ReadModel, Snapshot, points};
use profivac_gateway_modbus::image::{Encoder, Image};
use profivac_gateway_modbus::map::{Map, MapError, PARAMETERS, Row};
use profivac_gateway_modbus::names;
use profivac_gateway_modbus::pdu::{Exception, Identity, answer};
use profivac_recorder::{Micros, Quality};
use profivac_station::alarm::{AlarmState, Priority};
use profivac_station::config::Config;
use profivac_station::config::gateways::GatewaySettings;
use profivac_station::config::gateways::modbus::Settings;
use profivac_station::station::Station;
use profivac_station::view::BusStationState;
use std::collections::BTreeSet;
use std::path::Path;
use std::sync::Arc;
use until::until;

const HEAD: &str = "[[segment]]\nname = \"hall\"\nport = \"sim:hall.toml\"\n";

/// A gauge of the file.
fn gauge(name: &str, address: u8, device: &str, more: &str) -> String {
    format!("[[segment.gauge]]\nname = \"{name}\"\naddress = {address}\ndevice = \"{device}\"\n{more}\n")
}

fn config(gauges: &[String], table: &str) -> Config {
    let text = format!("{HEAD}{}[modbus]\n{table}", gauges.concat());
    profivac_config::parse(&text, Path::new("plant.toml")).unwrap()
}

fn settings(config: &Config) -> Settings {
    let [GatewaySettings::Modbus(settings)] = &config.gateways[..] else { panic!("one gateway") };
    settings.clone()
}

/// The rows of the map of this file.
fn rows(gauges: &[String]) -> Vec<Row> {
    let config = config(gauges, "");
    Map::of(&points(&Inputs::planned(&config)), &settings(&config)).unwrap().rows
}

/// The register of a value.
fn register(rows: &[Row], subject: &str, name: &str) -> u16 {
    let row = rows.iter().find(|row| &*row.subject == subject && row.name == name);
    row.unwrap_or_else(|| panic!("no {subject} {name}")).register
}

fn plant() -> Vec<String> {
    vec![
        gauge("chamber", 5, "bcg450", ""),
        gauge("fore line", 6, "tpg300", ""),
        gauge("lock", 7, "pcg550", "modbus = 1"),
    ]
}

#[test]
fn slots_are_those_of_the_file_then_the_lowest_free_ones_in_order() {
    let rows = rows(&plant());
    let slot = |subject: &str| (register(&rows, subject, "pressure") - 100) / 20;
    assert_eq!(["chamber", "lock", "fore line.1", "fore line.4"].map(slot), [0, 1, 2, 5]);
}

#[test]
fn a_gauge_that_is_added_moves_no_other_one_with_a_slot_and_none_before_it() {
    let before = rows(&plant());
    let mut more = plant();
    more.push(gauge("new", 8, "bcg450", ""));
    let after = rows(&more);
    let places = |rows: &[Row]| -> BTreeSet<(u16, String, String)> {
        // Each gauge brings alarms by default, which are behind those of the file.
        let own = rows.iter().filter(|row| !row.name.ends_with("-check") && row.register < 62_000);
        own.map(|row| (row.register, row.subject.to_string(), row.name.clone())).collect()
    };
    assert!(places(&before).is_subset(&places(&after)));
    let value = |rows: &[Row], name: &str| rows.iter().find(|row| row.name == name).unwrap().source;
    assert_ne!(value(&before, "slot-check"), value(&after, "slot-check"), "the check tells that the map has changed");
    assert_ne!(value(&before, "alarm-check"), value(&after, "alarm-check"));
    let mut first = vec![gauge("new", 8, "bcg450", "")];
    first.extend(plant());
    assert_eq!(register(&rows(&first), "lock", "pressure"), register(&before, "lock", "pressure"));
}

#[test]
fn no_two_rows_share_a_register() {
    let config = config(&plant(), "");
    let map = Map::of(&points(&Inputs::planned(&config)), &settings(&config)).unwrap();
    let mut next = 0;
    for row in &map.rows {
        assert!(row.register >= next, "{row:?} begins before {next}");
        next = row.register + if row.source.kind().ends_with("32") { 2 } else { 1 };
        let is_in = |(first, length): &(u16, u16)| row.register >= *first && next <= first + length;
        assert!(map.areas.iter().any(is_in), "{row:?} is outside the areas");
    }
    let table = names(&points(&Inputs::planned(&config)), &settings(&config)).unwrap();
    assert_eq!(table.rows().len(), map.rows.len());
    assert_eq!(
        table.csv().lines().nth(1),
        Some("0,float32,,test-float,,\"The number 1.0, to find the order of octets and words\"")
    );
}

#[test]
fn the_channels_of_a_controller_may_not_reach_another_gauge() {
    let gauges = [gauge("a", 5, "tpg300", "modbus = 3"), gauge("b", 6, "bcg450", "modbus = 4")];
    let config = config(&gauges, "");
    let found = Map::of(&points(&Inputs::planned(&config)), &settings(&config)).unwrap_err();
    let expected = MapError::Overlap { gauge: "b".to_owned(), first: 4, slot: 4, other: "a".to_owned() };
    assert_eq!(found, expected);
    assert!(found.to_string().contains("give one of them another number"), "{found}");
}

#[test]
fn the_parameters_of_every_device_fit_into_its_slot() {
    for model in profivac_devices::catalog::MODELS {
        let parameters = profivac_station::segment::planned_parameters(model).len();
        assert!(parameters <= PARAMETERS, "{}: {parameters}", model.name);
    }
}

/// A slave with 100 points, and a gauge before and behind it, with these keys of the slave and of the gauge behind it.
fn with_slave(of_slave: &str, of_last: &str) -> (Config, tempfile::TempDir) {
    const GSD: &str = "#Profibus_DP\nIdent_Number = 0x0FA7\nModule = \"m\" 0x1F\n1\nEndModule\n";
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("valve.gsd"), GSD).unwrap();
    let point = |number: usize| {
        let (octet, bit) = (number / 8, number % 8);
        format!("[[segment.slave.point]]\nname = \"p{number}\"\noctet = {octet}\nbit = {bit}\ntype = \"bool\"\n")
    };
    let slave = "[[segment.slave]]\nname = \"gate\"\naddress = 9\ngsd = \"valve.gsd\"\n";
    let points_of_slave: String = (0..100).map(point).collect();
    let (first, last) = (gauge("first", 5, "bcg450", ""), gauge("last", 6, "bcg450", of_last));
    let text = format!("{HEAD}{first}{slave}{of_slave}\n{points_of_slave}{last}[modbus]\n");
    (profivac_config::parse(&text, &folder.path().join("plant.toml")).unwrap(), folder)
}

/// The rows of a station with a gauge of this device, and a slave with these points, each a name with further keys; then two segments.
fn rows_of(device: &str, points_of_slave: &[(&str, &str)], segments: [&str; 2]) -> Vec<Row> {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(
        folder.path().join("valve.gsd"),
        "#Profibus_DP\nIdent_Number = 0x0FA7\nModule = \"m\" 0x1F\n1\nEndModule\n",
    )
    .unwrap();
    let slave = "[[segment.slave]]\nname = \"gate\"\naddress = 9\ngsd = \"valve.gsd\"\n";
    let point = |(number, (name, keys)): (usize, &(&str, &str))| {
        format!("[[segment.slave.point]]\nname = \"{name}\"\noctet = {number}\ntype = \"u8\"\n{keys}\n")
    };
    let all: String = points_of_slave.iter().enumerate().map(point).collect();
    let segment = |name: &str| format!("[[segment]]\nname = \"{name}\"\nport = \"sim:{name}.toml\"\n");
    let more: String = segments.iter().map(|name| segment(name)).collect();
    let text = format!("{HEAD}{}{slave}{all}{more}[modbus]\n", gauge("chamber", 5, device, ""));
    let config = profivac_config::parse(&text, &folder.path().join("plant.toml")).unwrap();
    Map::of(&points(&Inputs::planned(&config)), &settings(&config)).unwrap().rows
}

#[test]
fn the_check_value_changes_when_a_register_gets_another_parameter_point_unit_or_segment() {
    let segments = ["east", "west"];
    let before = rows_of("bcg450", &[("speed", ""), ("current", "unit = \"A\"")], segments);
    let check = |rows: &[Row]| rows.iter().find(|row| row.name == "slot-check").unwrap().source;
    let inserted = rows_of("bcg450", &[("state", ""), ("speed", ""), ("current", "unit = \"A\"")], segments);
    assert_ne!(register(&before, "gate", "speed"), register(&inserted, "gate", "speed"), "the points are shifted");
    let changed = [
        ("a point before others", inserted),
        ("points in another order", rows_of("bcg450", &[("current", "unit = \"A\""), ("speed", "")], segments)),
        ("a point with another name", rows_of("bcg450", &[("rpm", ""), ("current", "unit = \"A\"")], segments)),
        ("a point in another unit", rows_of("bcg450", &[("speed", ""), ("current", "unit = \"mA\"")], segments)),
        ("a gauge with other parameters", rows_of("pcg550", &[("speed", ""), ("current", "unit = \"A\"")], segments)),
        (
            "segments in another order",
            rows_of("bcg450", &[("speed", ""), ("current", "unit = \"A\"")], ["west", "east"]),
        ),
    ];
    for (what, rows) in changed {
        assert_ne!(check(&before), check(&rows), "{what}");
    }
    // What a register shows stays the same with another scale.
    let scaled = rows_of("bcg450", &[("speed", "scale = 0.1"), ("current", "unit = \"A\"")], segments);
    assert_eq!(check(&before), check(&scaled));
}

#[test]
fn a_point_of_a_slave_has_its_unit_in_the_map() {
    let rows = rows_of("bcg450", &[("speed", "unit = \"Hz\""), ("state", "")], ["east", "west"]);
    let unit = |name: &str| rows.iter().find(|row| row.name == name).unwrap().unit;
    assert_eq!((unit("speed"), unit("state")), ("Hz", ""));
}

#[test]
fn every_point_of_a_slave_has_a_register() {
    let (config, _folder) = with_slave("", "");
    let map = Map::of(&points(&Inputs::planned(&config)), &settings(&config)).unwrap();
    let snapshot = Modeller::default().next(Inputs::planned(&config), Micros(1));
    let image = Encoder::new(map.clone(), &settings(&config)).image(&snapshot, Micros(1));
    let place = |name: &str| register(&map.rows, "gate", name);
    // The gauges have the slots 0 and 1.
    assert_eq!(["p0", "p45", "p46", "p91", "p92", "p99"].map(place), [10_200, 10_290, 10_300, 10_390, 10_400, 10_414]);
    assert_eq!(place("state"), 143);
    assert_eq!(place("gauge-state"), 10_292);
    for slot in [140, 160, 180] {
        assert!(float(&image, slot).is_nan(), "a slave has no pressure");
        assert_eq!((word(&image, slot + 2), word(&image, slot + 3), word(&image, slot + 5)), (0x8000, 4, u16::MAX));
    }
    let (config, _folder) = with_slave("modbus = 20", "");
    let rows = Map::of(&points(&Inputs::planned(&config)), &settings(&config)).unwrap().rows;
    assert_eq!(["p0", "p99"].map(|name| register(&rows, "gate", name)), [12_000, 12_214]);
    assert_eq!(register(&rows, "last", "pressure"), 120);
}

#[test]
fn the_points_of_a_slave_may_not_reach_another_gauge() {
    let (config, _folder) = with_slave("modbus = 20", "modbus = 22");
    let found = Map::of(&points(&Inputs::planned(&config)), &settings(&config)).unwrap_err();
    let expected = MapError::Overlap { gauge: "gate".to_owned(), first: 20, slot: 22, other: "last".to_owned() };
    assert_eq!(found, expected);
}

#[test]
fn a_parameter_has_its_register_with_the_unit_of_its_number() {
    let rows = rows(&plant());
    let unit = |name: &str| rows.iter().find(|row| row.name == name).unwrap_or_else(|| panic!("no {name}")).unit;
    assert_eq!(unit("setpoint-a.percentage-of-atmosphere"), "%");
    assert_eq!((unit("setpoint-a.process-value"), unit("setpoint-a.status")), ("Pa", ""));
}

#[test]
fn a_wrong_table_has_an_error_with_its_place() {
    let problem = |gauges: &[String], table: &str| {
        let text = format!("{HEAD}{}[modbus]\n{table}", gauges.concat());
        profivac_config::parse(&text, Path::new("plant.toml")).unwrap_err().to_string()
    };
    let one = [gauge("a", 5, "bcg450", "")];
    let exposed = problem(&one, "listen = \"0.0.0.0:1502\"");
    assert!(
        exposed.contains(":10:10: [modbus] listens beyond loopback on 0.0.0.0:1502, which needs allow"),
        "{exposed}"
    );
    assert!(problem(&one, "idle = \"1ms\"").contains("expected an idle time from 1s to 1h, found 1ms"));
    assert!(problem(&one, "connections = 0").contains("expected connections from 1 to 1000, found 0"));
    assert!(problem(&one, "allow = [\"10.0.0.0/40\"]").contains("expected an address like 192.168.1.5"));
    assert!(problem(&one, "wordorder = \"x\"").contains("unknown field"));
    let slots = [gauge("a", 5, "bcg450", "modbus = 2"), gauge("b", 6, "bcg450", "modbus = 2")];
    assert!(problem(&slots, "").contains("the slot 2 belongs to the gauge \"a\""));
    assert!(
        problem(&[gauge("a", 5, "bcg450", "modbus = 495")], "").contains("expected a slot from 0 to 494, found 495")
    );
}

/// The registers of a plant whose chamber has this reading.
struct Plant {
    encoder: Encoder,
    modeller: Modeller,
    config: Config,
}

impl Plant {
    fn new(table: &str) -> Self {
        let config = config(&plant(), table);
        let map = Map::of(&points(&Inputs::planned(&config)), &settings(&config)).unwrap();
        Self { encoder: Encoder::new(map, &settings(&config)), modeller: Modeller::default(), config }
    }

    fn image(&mut self, quality: Quality, pa: Option<f64>, limit_pa: Option<f64>, read_at: i64) -> Image {
        let mut inputs = Inputs::planned(&self.config);
        let gauge = &mut inputs.gauges[0];
        gauge.state = BusStationState::DataExchange;
        (gauge.age_ms, gauge.read_at) = (Some(10), Some(Micros(read_at)));
        let reading = &mut gauge.readings[0];
        (reading.quality, reading.pa, reading.limit_pa) = (quality, pa, limit_pa);
        let parameters = Arc::make_mut(&mut gauge.parameters);
        if let Some(emission) = parameters.iter_mut().find(|it| it.target.ends_with("emission-status")) {
            emission.quality = Quality::Valid;
            (emission.text, emission.number, emission.read_at) = ("on".to_owned(), Some(1.0), Some(Micros(read_at)));
        }
        let snapshot: Snapshot = self.modeller.next(inputs, Micros(read_at));
        self.encoder.image(&snapshot, Micros(read_at + 1_250_000))
    }
}

fn float(image: &Image, register: u16) -> f32 {
    let &[high, low] = image.read(register, 2).unwrap() else { panic!("two registers") };
    f32::from_bits(u32::from(high) << 16 | u32::from(low))
}

fn word(image: &Image, register: u16) -> u16 {
    image.read(register, 1).unwrap()[0]
}

#[test]
fn a_slot_has_pressure_logarithm_state_age_and_unit() {
    let image = Plant::new("").image(Quality::Valid, Some(5.2e-4), None, 1_700_000_000_000_000);
    assert_eq!((word(&image, 0), word(&image, 1), word(&image, 2), word(&image, 3)), (0x3F80, 0, 0x0102, 0x0304));
    assert_eq!((float(&image, 100), float(&image, 106)), (5.2e-4, 5.2e-6));
    assert_eq!((word(&image, 102) as i16, word(&image, 103), word(&image, 105), word(&image, 108)), (-3284, 0, 12, 1));
    // Emission, simulated, measured, data exchange; state 0.
    assert_eq!(word(&image, 104), 1 << 2 | 1 << 8 | 1 << 10 | 1 << 11);
    // The alarms by default have no limit; the range is that of the manual.
    assert!(float(&image, 110).is_nan() && float(&image, 118) > 1e5);
    // The lock has given no reading.
    assert!(float(&image, 120).is_nan());
    assert_eq!((word(&image, 122), word(&image, 123), word(&image, 125)), (0x8000, 4, u16::MAX));
    assert_eq!(word(&image, 8), ((1_700_000_001_u32 >> 16) & 0xFFFF) as u16);
}

#[test]
fn beyond_the_range_a_slot_has_the_end_of_the_range_and_without_a_pressure_it_has_nan() {
    let mut plant = Plant::new("");
    let states = [
        (Quality::Overrange, Some(1.5e5), 1, State::OVER),
        (Quality::Underrange, Some(5e-8), 2, State::UNDER),
        (Quality::Off, None, 3, State::OFF),
        (Quality::Fault, None, 3, State::INVALID),
        (Quality::Stale, None, 4, State::STALE),
    ];
    for (quality, limit, code, number) in states {
        let image = plant.image(quality, None, limit, 1);
        assert_eq!(limit.map(|pa: f64| pa as f32), Some(float(&image, 100)).filter(|pa| !pa.is_nan()), "{quality:?}");
        assert_eq!((word(&image, 103), word(&image, 104) >> 12), (code, number), "{quality:?}");
        assert_eq!(word(&image, 104) & 1, u16::from(quality == Quality::Stale));
    }
}

/// The numbers of the states in the bits 12 to 15.
struct State;

impl State {
    const UNDER: u16 = 1;
    const OVER: u16 = 2;
    const OFF: u16 = 3;
    const INVALID: u16 = 5;
    const STALE: u16 = 7;
}

#[test]
fn the_words_of_a_float_can_be_exchanged_and_the_octets_not() {
    let image = Plant::new("word-order = \"low-first\"\nunit = \"torr\"").image(Quality::Valid, Some(1.0), None, 1);
    assert_eq!((word(&image, 0), word(&image, 1), word(&image, 2), word(&image, 3)), (0, 0x3F80, 0x0304, 0x0102));
    assert_eq!((word(&image, 100), word(&image, 101)), (0, 0x3F80));
    assert_eq!((word(&image, 108), word(&image, 15)), (2, 1));
}

#[test]
fn each_reading_is_counted_once() {
    let mut plant = Plant::new("");
    let counts = [1, 1, 2, 3].map(|at| word(&plant.image(Quality::Valid, Some(1.0), None, at), 109));
    assert_eq!(counts, [1, 1, 2, 3]);
}

/// A loss has its own time; the age counts from the last reading.
#[test]
fn a_loss_is_no_reading_and_makes_no_reading_younger() {
    let mut plant = Plant::new("");
    plant.image(Quality::Valid, Some(1.0), None, 1_000_000);
    let mut inputs = Inputs::planned(&plant.config);
    let gauge = &mut inputs.gauges[0];
    gauge.state = BusStationState::Missing;
    (gauge.age_ms, gauge.read_at, gauge.lost_at) = (Some(4_000), Some(Micros(1_000_000)), Some(Micros(2_000_000)));
    let snapshot = plant.modeller.next(inputs, Micros(5_000_000));
    let image = plant.encoder.image(&snapshot, Micros(5_000_000));
    assert_eq!((word(&image, 105), word(&image, 109)), (40, 1), "4 s, and one reading");
}

#[test]
fn a_block_within_an_area_is_read_and_one_beyond_its_end_is_refused() {
    let image = Plant::new("").image(Quality::Valid, Some(1.0), None, 1);
    let identity = Identity { version: String::new(), station: String::new() };
    let read = |first: u16, count: u16| {
        let [a, b] = first.to_be_bytes();
        let [c, d] = count.to_be_bytes();
        let [three, four] = [3, 4].map(|function| answer(&[function, a, b, c, d], Some(&image), &identity));
        assert_eq!(three.0[1..], four.0[1..], "the same registers");
        (three.0.len(), three.1)
    };
    // Six slots: 0 to 219.
    assert_eq!(read(0, 125), (252, None));
    assert_eq!(read(95, 125), (252, None));
    assert_eq!(read(219, 1), (4, None));
    for (first, count) in [(219, 2), (220, 1), (9_999, 2), (30_000, 1), (65_535, 1), (65_535, 125)] {
        assert_eq!(read(first, count), (2, Some(Exception::IllegalAddress)), "{first} {count}");
    }
    assert_eq!(read(60_000, 20), (42, None));
}

/// The bits of all readings of a gauge of this device whose parameters have these numbers, each with its word.
fn bits_of(device: &str, numbers: &[(&str, u16, &str)]) -> Vec<u16> {
    let config = config(&[gauge("rack", 5, device, "")], "");
    let map = Map::of(&points(&Inputs::planned(&config)), &settings(&config)).unwrap();
    let mut inputs = Inputs::planned(&config);
    let gauge = &mut inputs.gauges[0];
    gauge.state = BusStationState::DataExchange;
    let readings = u16::try_from(gauge.readings.len()).unwrap();
    let parameters = Arc::make_mut(&mut gauge.parameters);
    for (target, number, text) in numbers {
        let parameter = parameters.iter_mut().find(|it| it.target == *target);
        let parameter = parameter.unwrap_or_else(|| panic!("{device} has no {target}"));
        parameter.quality = Quality::Valid;
        (parameter.text, parameter.number) = ((*text).to_owned(), Some(f64::from(*number)));
        parameter.read_at = Some(Micros(1));
    }
    let snapshot = Modeller::default().next(inputs, Micros(1));
    let image = Encoder::new(map, &settings(&config)).image(&snapshot, Micros(1));
    (0..readings).map(|slot| word(&image, 104 + 20 * slot)).collect()
}

/// Bit 2 is the emission, bit 3 the degas.
#[test]
fn every_word_of_emission_and_degas_is_on_or_off() {
    let mut words = BTreeSet::new();
    for model in profivac_devices::catalog::MODELS {
        let rows = || model.blocks.iter().flat_map(|placed| placed.block.rows);
        for (role, name, bit) in [(Role::EmissionStatus, "emission-status", 2), (Role::DegasStatus, "degas-status", 3)]
        {
            let Some(row) = rows().find(|row| row.role == Some(role)) else { continue };
            let planned = profivac_station::segment::planned_parameters(model);
            let Some(target) = planned.iter().map(|it| &it.target).find(|target| target.ends_with(name)) else {
                continue;
            };
            for code in row.codes.codes() {
                let bits = bits_of(model.name, &[(target, code.number, code.name)])[0];
                assert_eq!(bits >> bit & 1, u16::from(code.name != "off"), "{}: {target} {}", model.name, code.name);
                words.insert(format!("{name} {}", code.name));
            }
        }
    }
    let expected = [
        "degas-status off",
        "degas-status on",
        "emission-status degas",
        "emission-status off",
        "emission-status on",
        "emission-status on-25-microampere",
        "emission-status on-5-milliampere",
        "emission-status on-high",
    ];
    assert_eq!(words, expected.map(str::to_owned).into());
}

#[test]
fn each_channel_has_its_own_emission_and_degas() {
    let [emission, degas] = [1 << 2, 1 << 3];
    let on = |target| (target, 1, "on");
    let flags = |numbers: &[_]| -> Vec<u16> {
        bits_of("img400", numbers).into_iter().map(|bits| bits & (emission | degas)).collect()
    };
    assert_eq!(flags(&[on("channel.1/emission-status")]), [emission, 0, 0, 0]);
    assert_eq!(flags(&[on("channel.2/emission-status")]), [0, emission, 0, 0]);
    assert_eq!(
        flags(&[on("channel.1/emission-status"), on("channel.2/emission-status"), on("channel.2/degas-status")]),
        [emission, emission | degas, 0, 0]
    );
}

/// The status of the degas of a BCG450 is read each 6 h; 60 s later the station does not know it, and 0 would be a false "off".
#[test]
fn a_degas_that_was_not_read_lately_is_not_known() {
    let mut plant = Plant::new("");
    let mut words = |degas: Option<f64>| {
        let mut inputs = Inputs::planned(&plant.config);
        let gauge = &mut inputs.gauges[0];
        gauge.state = BusStationState::DataExchange;
        (gauge.age_ms, gauge.read_at) = (Some(10), Some(Micros(1)));
        let reading = &mut gauge.readings[0];
        (reading.quality, reading.pa) = (Quality::Valid, Some(1e-4));
        let parameters = Arc::make_mut(&mut gauge.parameters);
        let status = parameters.iter_mut().find(|it| it.target.ends_with("degas-status")).unwrap();
        status.quality = if degas.is_some() { Quality::Valid } else { Quality::Stale };
        (status.number, status.read_at) = (degas, Some(Micros(1)));
        let snapshot = plant.modeller.next(inputs, Micros(1));
        let image = plant.encoder.image(&snapshot, Micros(1));
        (word(&image, 104) >> 3 & 1, word(&image, 59_500) >> 1 & 1)
    };
    assert_eq!(words(None), (0, 0), "nothing is known of a degas");
    assert_eq!(words(Some(1.0)), (1, 1));
    assert_eq!(words(Some(0.0)), (0, 1), "known to be off");
}

/// Modbus has no texts: the map says what each number means.
#[test]
fn the_map_has_the_words_of_each_number_that_is_a_choice() {
    let rows = rows(&plant());
    let text = |register: u16| rows.iter().find(|row| row.register == register).unwrap().text.as_str();
    assert_eq!(text(60_000), "State of the segment: 0 waiting, 1 listening, 2 running");
    assert_eq!(text(10_092), "State of the gauge on the bus: 0 data exchange, 1 fault, 2 starting, 3 missing");
    assert!(text(62_000).starts_with("State of the alarm: 0 normal, 1 unacknowledged, "), "{}", text(62_000));
    assert_eq!(text(62_001), "Priority of the alarm: 0 none, 1 low, 2 medium, 3 high");
    assert_eq!(text(10_093), "Bus address");
}

#[test]
fn the_bits_of_a_slave_show_its_alarms_and_its_data_exchange() {
    let (config, _folder) = with_slave("", "");
    let map = Map::of(&points(&Inputs::planned(&config)), &settings(&config)).unwrap();
    let mut inputs = Inputs::planned(&config);
    let position = inputs.gauges.iter().position(|gauge| gauge.name == "gate").unwrap();
    inputs.gauges[position].listen_only = false;
    let without = Modeller::default().next(inputs.clone(), Micros(1));
    inputs.gauges[position].state = BusStationState::DataExchange;
    let alarm = inputs.alarms.first_mut().unwrap();
    (alarm.gauge, alarm.state, alarm.priority) = (Some("gate".to_owned()), AlarmState::Unacknowledged, Priority::High);
    let with = Modeller::default().next(inputs, Micros(1));
    let mut encoder = Encoder::new(map, &settings(&config));
    // Stale and simulated, with the number of the state that has no reading; the slave has three slots.
    let none = 1 | 1 << 8 | State::STALE << 12;
    for (snapshot, expected) in [(without, none), (with, none | 1 << 4 | 1 << 7 | 1 << 11)] {
        let image = encoder.image(&snapshot, Micros(1));
        assert_eq!([144, 164, 184].map(|register| word(&image, register)), [expected; 3]);
    }
}

/// A station with these segments in memory, each with one gauge that measures this pressure: `segment`, `gauge`, `pressure`.
fn station_of(folder: &Path, segments: &[(&str, &str, &str)]) -> Config {
    let segment = |(segment, gauge, pressure): &(&str, &str, &str)| {
        let port = folder.join(format!("{segment}.toml"));
        let text = format!("baud = 1500000\ndevices = [\"pcg550@6\"]\npressure = \"{pressure}\"\n");
        std::fs::write(&port, text).unwrap();
        let head = format!("[[segment]]\nname = \"{segment}\"\nport = \"sim:{}\"\nbaud = 1500000\n", port.display());
        format!("{head}[[segment.gauge]]\nname = \"{gauge}\"\naddress = 6\ndevice = \"pcg550\"\n")
    };
    let text: String = segments.iter().map(segment).collect();
    profivac_config::parse(&format!("{text}[modbus]\n"), &folder.join("plant.toml")).unwrap()
}

/// Where the map says that the points of this file are.
fn planned_places(config: &Config) -> Vec<(u16, String, String)> {
    places(&Map::of(&points(&Inputs::planned(config)), &settings(config)).unwrap())
}

fn places(map: &Map) -> Vec<(u16, String, String)> {
    map.rows.iter().map(|row| (row.register, row.subject.to_string(), row.name.clone())).collect()
}

/// The running map and its registers as soon as all these registers have these pressures.
fn running(model: &ReadModel, config: &Config, pressures: &[(u16, f32)]) -> Map {
    until("the pressures", || {
        let snapshot = model.snapshot();
        let map = Map::of(&snapshot.points, &settings(config)).unwrap();
        let image = Encoder::new(map.clone(), &settings(config)).image(&snapshot, Micros::now());
        let is_there = |(register, pa): &(u16, f32)| {
            image.read(*register, 2).is_some() && (float(&image, *register) / pa - 1.0).abs() < 0.05
        };
        pressures.iter().all(is_there).then_some(map)
    })
}

/// A running station, and its map as soon as the registers have these pressures.
fn started(config: &Config, pressures: &[(u16, f32)]) -> (Station, ReadModel, Map) {
    let station = Station::start(config.clone()).unwrap();
    let model = ReadModel::start(station.services()).unwrap();
    let map = running(&model, config, pressures);
    (station, model, map)
}

#[test]
fn the_running_registers_are_those_of_the_map_whatever_the_names_of_segments_are() {
    let folder = tempfile::tempdir().unwrap();
    let config = station_of(folder.path(), &[("z line", "first", "1 Pa"), ("a line", "second", "10 Pa")]);
    let (station, model, map) = started(&config, &[(100, 1.0), (120, 10.0)]);
    assert_eq!(places(&map), planned_places(&config));
    drop(model);
    station.stop().unwrap();
}

#[test]
fn a_segment_that_a_reload_appends_moves_no_register_and_one_before_others_has_its_place() {
    let folder = tempfile::tempdir().unwrap();
    let (first, second) = (("m line", "first", "1 Pa"), ("z line", "second", "10 Pa"));
    let config = station_of(folder.path(), &[first, second]);
    let (mut station, model, map) = started(&config, &[(100, 1.0), (120, 10.0)]);
    assert_eq!(places(&map), planned_places(&config));
    let third = ("a line", "third", "100 Pa");
    for (segments, pressures) in [
        ([first, second, third], [(100, 1.0), (120, 10.0), (140, 100.0)]),
        ([second, first, third], [(100, 10.0), (120, 1.0), (140, 100.0)]),
    ] {
        let config = station_of(folder.path(), &segments);
        station.reconfigure(config.clone());
        assert_eq!(places(&running(&model, &config, &pressures)), planned_places(&config));
    }
    drop(model);
    station.stop().unwrap();
}

/// A gauge that was not found yet has the registers of the configuration in the file.
#[test]
fn a_controller_that_was_never_heard_has_the_channels_of_the_file() {
    let folder = tempfile::tempdir().unwrap();
    // Two channels.
    let octets = "97 A7 94 94 A0";
    let gauges =
        [gauge("controller", 5, "tpg300", &format!("configuration = \"{octets}\"")), gauge("behind", 6, "pcg550", "")];
    let head = "[[segment]]\nname = \"hall\"\nport = \"/dev/absent\"\nlisten-only = true\n";
    let text = format!("{head}{}[modbus]\n", gauges.concat());
    let config = profivac_config::parse(&text, &folder.path().join("plant.toml")).unwrap();
    let station = Station::start(config.clone()).unwrap();
    let model = ReadModel::start(station.services()).unwrap();
    let map = Map::of(&model.snapshot().points, &settings(&config)).unwrap();
    assert_eq!(register(&map.rows, "behind", "pressure"), 140);
    assert_eq!(places(&map), planned_places(&config));
    drop(model);
    station.stop().unwrap();
}
