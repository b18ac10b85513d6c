//! Names, values, alarms and fields of records.

#![allow(clippy::unwrap_used, clippy::panic, reason = "a test")]

use crate::common::{Plant, config, parsed};
use profivac_gateway::model::Modeller;
use profivac_gateway::{EpicsSeverity, EpicsStatus, Inputs, Point, PointValue, Signal, Value};
use profivac_gateway_epics::database::{Database, World, held};
use profivac_gateway_epics::listing;
use profivac_gateway_epics::names::NameError;
use profivac_gateway_epics::record::{Answer, Data, Record, RecordType};
use profivac_recorder::{Micros, Quality};
use profivac_station::config::Config;
use profivac_station::config::gateways::GatewaySettings;
use profivac_station::config::gateways::epics::Settings;
use profivac_station::config::gateways::write::Write;
use profivac_station::view::BusStationState;
use std::collections::BTreeSet;
use std::sync::Arc;

fn read<'a>(world: &'a World, name: &str) -> Answer<'a> {
    world.read(world.database.find(name).unwrap_or_else(|| panic!("no {name}"))).unwrap()
}

fn number(world: &World, name: &str) -> f64 {
    match read(world, name).sample.data {
        Data::Double(number) => number,
        other => panic!("{name} is {other:?}"),
    }
}

fn text(world: &World, name: &str) -> String {
    match read(world, name).sample.data {
        Data::Text(text) => text.to_string(),
        other => panic!("{name} is {other:?}"),
    }
}

fn alarm(world: &World, name: &str) -> (EpicsSeverity, EpicsStatus) {
    let sample = read(world, name).sample;
    (sample.severity, sample.status)
}

fn close(number: f64, expected: f64) -> bool {
    (number / expected - 1.0).abs() < 1e-9
}

/// The station with each parameter of the chamber at 5, in the unit of the parameter.
fn with_parameters(epics: &str) -> World {
    let mut plant = Plant::new(epics);
    plant.reads("chamber", Quality::Valid, Some(5e-4), 1);
    plant.reads_parameters("chamber", 5.0);
    plant.world()
}

fn names(epics: &str) -> Result<Vec<String>, NameError> {
    let (config, settings) = config(epics);
    listed(&config, &settings)
}

fn listed(config: &Config, settings: &Settings) -> Result<Vec<String>, NameError> {
    let snapshot = Modeller::default().next(Inputs::planned(config), Micros(1));
    let table = listing::names(&config.name, &snapshot, settings)?;
    Ok(table.rows().iter().map(|row| row[0].clone()).collect())
}

#[test]
fn every_point_has_a_record_and_the_names_are_those_of_the_documentation() {
    let names = names("prefix = 'VAC:'").unwrap();
    for name in [
        "VAC:CHAMBER:P",
        "VAC:CHAMBER:PLOG",
        "VAC:CHAMBER:STATE",
        "VAC:CHAMBER:P_STR",
        "VAC:CHAMBER:OK",
        "VAC:CHAMBER:ALARM",
        "VAC:CHAMBER:UNACK",
        "VAC:FORE_LINE:CH2:P",
        "VAC:CHAMBER:SP_A_ATM_P_REACHED_STR",
        "VAC:HALL:SEG_OK",
        "VAC:HALL:CYCLE",
        "VAC:HALL:REPETITIONS",
        "VAC:HEARTBEAT",
        "VAC:VERSION",
        "VAC:TABLE",
        "VAC:ALARM:CHAMBER_HIGH:ALARM_STATE",
    ] {
        assert!(names.iter().any(|it| it == name), "no {name} in {names:?}");
    }
    let (config, _) = config("");
    let snapshot = Modeller::default().next(Inputs::planned(&config), Micros(1));
    let without_limit = |it: &(&Point, &PointValue)| it.0.signal == Signal::AlarmLimit && it.1.value == Value::None;
    let absent = snapshot.iter().filter(without_limit).count();
    assert!(absent > 0, "the alarm \"no data\" has no limit, and no record of one");
    let records = snapshot.points.len() - absent + 1;
    assert_eq!((names.len(), names.iter().collect::<BTreeSet<_>>().len()), (records, records));
}

#[test]
fn templates_presets_renames_and_aliases_make_the_names_of_a_site() {
    let lcls =
        names("name = 'SITE:{segment}:{device}:{address}:{signal}'\npreset = 'lcls'\nsignals = { state = 'STA' }")
            .unwrap();
    for name in [
        "SITE:hall:bcg450:5:PRESS_RBV",
        "SITE:hall:bcg450:5:STA",
        "SITE:hall:bcg450:5:PRESS_OK_RBV",
        "SITE:hall:tpg300:6:CH2:PRESS_RBV",
    ] {
        assert!(lcls.iter().any(|it| it == name), "no {name} in {lcls:?}");
    }
    let placed =
        names("name = '{GAUGE}{channel}:{signal}'\n[epics.alias]\n'FE:VA{CCG:1}P-I' = 'fore line.2.pressure'").unwrap();
    assert!(placed.iter().any(|it| it == "FORE_LINE2:P") && placed.iter().any(|it| it == "FE:VA{CCG:1}P-I"));
}

/// The alarms that a station has without a row in its file are named after gauges too, and after the channel of a controller.
#[test]
fn the_usual_names_of_every_device_leave_20_characters_for_prefix_and_gauge() {
    let segment = "[[segment]]\nname = 's'\nport = '/dev/ttyUSB0'\n".to_owned();
    let gauge = |(address, device): (usize, &str)| {
        let gauge = format!("[[segment.gauge]]\nname = 'g{address:02}'\naddress = {address}\ndevice = '{device}'\n");
        let limited = if device.starts_with("tpg") || device.starts_with("img") { ".1" } else { "" };
        (gauge, format!("[[alarm]]\nname = 'a{address}'\ngauge = 'g{address:02}{limited}'\nabove = '1e-3 mbar'\n"))
    };
    let devices = profivac_devices::catalog::MODELS.iter().map(|model| model.name);
    let (gauges, alarms): (String, String) = (10..).zip(devices).map(gauge).unzip();
    let (config, settings) = parsed(&format!("{segment}{gauges}{alarms}[epics]\n"));
    let names = listed(&config, &settings).unwrap();
    assert!(names.iter().any(|name| name == "ALARM:G10_LIMIT_NOT_MEASURABLE:ACKED"), "{names:?}");
    for name in names {
        let of_gauge = if name.contains("_1_LIMIT") { "G21_1" } else { "G10" };
        let with_twenty = name.len() - of_gauge.len() + 20;
        assert!(with_twenty <= 60, "{name} would have {with_twenty} characters");
    }
}

#[test]
fn names_that_are_too_long_equal_or_unknown_are_errors_that_say_what_to_do() {
    let error = |epics: &str| names(epics).unwrap_err().to_string();
    let long = error(&format!("prefix = '{}'", "A".repeat(55)));
    assert!(long.contains("EPICS allows 60") && long.contains("shorten name or prefix"), "{long}");
    let equal = error("name = 'VAC:{address}:{signal}'");
    assert!(equal.contains("both have the name VAC:5:GAUGE_STATE") && equal.contains("{segment}"), "{equal}");
    let table = error("signals = { heartbeat = 'TABLE' }");
    assert!(table.contains("the table of all gauges"), "{table}");
    let signal = error("signals = { presure = 'P' }");
    assert!(signal.contains("no signal \"presure\"") && signal.contains("did you mean \"pressure\"?"), "{signal}");
    let alias = error("[epics.alias]\n'A:P' = 'chamer.pressure'");
    assert!(alias.contains("did you mean \"chamber.pressure\"?"), "{alias}");
}

#[test]
fn a_pressure_has_the_unit_the_range_the_limits_and_the_time_of_the_reading() {
    let mut plant = Plant::new("unit = 'mbar'");
    plant.reads("chamber", Quality::Valid, Some(5e-4), 7_000_000);
    let world = plant.world();
    let answer = read(&world, "CHAMBER:P");
    assert!(close(number(&world, "CHAMBER:P"), 5e-6) && close(number(&world, "CHAMBER:PLOG"), 5e-6_f64.log10()));
    assert_eq!((answer.meta.unit.as_str(), answer.sample.at), ("mbar", Micros(7_000_000)));
    assert!(close(answer.meta.display.0, 5e-10) && close(answer.meta.display.1, 1500.0));
    let limits = answer.meta.limits;
    assert!(
        close(limits.high_high, 1e-3) && close(limits.high, 1e-4) && limits.low.is_nan() && limits.low_low.is_nan()
    );
    assert_eq!(text(&world, "CHAMBER:P_STR"), "5.00e-06 mbar");
    assert_eq!(alarm(&world, "CHAMBER:P"), (EpicsSeverity::None, EpicsStatus::None));
    let torr = {
        let mut plant = Plant::new("unit = 'TORR'");
        plant.reads("chamber", Quality::Valid, Some(133.322_368_421), 1);
        number(&plant.world(), "CHAMBER:P")
    };
    assert!((torr - 1.0).abs() < 1e-9);
}

/// pyepics and panels show a number without an exponent with the decimals of `PREC`.
#[test]
fn a_number_has_decimals_and_ends_so_that_a_client_without_exponents_shows_it() {
    let meta = |world: &World, name: &str| read(world, name).meta.into_owned();
    let mbar = with_parameters("unit = 'mbar'");
    let pressure = meta(&mbar, "CHAMBER:P");
    assert_eq!((pressure.precision, pressure.is_exponential), (11, true), "5e-10 mbar has two digits");
    assert_eq!(meta(&with_parameters("unit = 'Pa'"), "CHAMBER:P").precision, 9);
    assert_eq!(meta(&mbar, "FORE_LINE:CH1:P").precision, 12, "a controller has gauges of unknown ranges");
    let channel = meta(&mbar, "FORE_LINE:CH1:P").display;
    assert!(close(channel.0, 1e-11) && close(channel.1, 1e3), "HOPR and LOPR are not both 0: {channel:?}");
    assert_eq!(meta(&mbar, "CHAMBER:SP_A_STAT").precision, 0, "a code");
    let logarithm = meta(&mbar, "CHAMBER:PLOG");
    assert!(close(logarithm.display.0, 5e-10_f64.log10()) && close(logarithm.display.1, 1500_f64.log10()));
    assert_eq!((logarithm.precision, logarithm.is_exponential), (2, false));
    assert_eq!(logarithm.description, "chamber: log10 of the pressure in mbar");
    let cycle = meta(&mbar, "HALL:CYCLE");
    assert_eq!((cycle.unit.as_str(), cycle.precision, cycle.is_exponential), ("s", 6, true));
    let whole = |record: &&Record| record.kind == RecordType::Int64in && record.meta.unit == "s";
    let seconds: Vec<_> = mbar.database.records.iter().filter(whole).collect();
    assert!(seconds.iter().any(|record| record.signal == Signal::Heartbeat));
    assert!(seconds.iter().any(|record| record.signal == Signal::ObservedTime));
    assert!(seconds.iter().all(|record| !record.meta.is_exponential), "3600 s is no 3.60e+03 s");
}

#[test]
fn every_number_has_the_unit_in_which_people_read_it() {
    let world = with_parameters("unit = 'mbar'");
    for (name, unit, value) in [
        ("CHAMBER:SP_A_PCT_OF_ATM", "%", 5.0),
        ("CHAMBER:SP_A_PROC_VALUE", "mbar", 0.05),
        ("CHAMBER:SP_A_STAT", "", 5.0),
        ("ALARM:CHAMBER_HIGH:ALARM_LIMIT", "mbar", 1e-3),
    ] {
        assert!(close(number(&world, name), value), "{name}: {}", number(&world, name));
        assert_eq!(text(&world, &format!("{name}.EGU")), unit, "{name}");
    }
    assert_eq!(text(&world, "ALARM:CHAMBER_HIGH:ALARM_UNIT"), "mbar");
    assert_eq!(text(&world, "HALL:BAUD.EGU"), "bit/s");
    let too_long = world.database.records.iter().filter(|record| record.meta.unit.len() > 7);
    assert_eq!(too_long.map(|record| record.name.to_string()).collect::<Vec<_>>(), [""; 0]);
}

#[test]
fn a_pressure_beyond_a_limit_has_the_severity_of_the_limit() {
    let mut plant = Plant::new("");
    for (pa, expected) in [
        (0.005, (EpicsSeverity::None, EpicsStatus::None)),
        (0.05, (EpicsSeverity::Minor, EpicsStatus::High)),
        (0.5, (EpicsSeverity::Major, EpicsStatus::HiHi)),
    ] {
        plant.reads("chamber", Quality::Valid, Some(pa), 1);
        assert_eq!(alarm(&plant.world(), "CHAMBER:P"), expected, "{pa} Pa");
    }
    let world = plant.world();
    for (field, expected) in [("HHSV", 2), ("HSV", 1), ("LSV", 0), ("LLSV", 0), ("SEVR", 2), ("STAT", 3)] {
        assert_eq!(read(&world, &format!("CHAMBER:P.{field}")).sample.data, Data::Enum(expected), "{field}");
    }
}

/// The number of an occurrence is its time in milliseconds: `caget` would show 1.76723e+12, which acknowledges nothing.
#[test]
fn an_occurrence_is_a_text_with_all_its_digits() {
    let mut plant = Plant::new("");
    plant.occurs(1_767_225_600_123);
    assert_eq!(text(&plant.world(), "ALARM:CHAMBER_HIGH:OCCURRENCE"), "1767225600123");
}

#[test]
fn the_severity_of_a_state_is_that_of_the_file() {
    let mut plant = Plant::new("severity = { underrange = 'minor', overrange = 'none', gap = 'major' }");
    plant.reads("chamber", Quality::Underrange, Some(5e-8), 1);
    assert_eq!(alarm(&plant.world(), "CHAMBER:P"), (EpicsSeverity::Minor, EpicsStatus::HwLimit));
    assert_eq!(text(&plant.world(), "CHAMBER:P_STR"), "< 5.00e-10 mbar");
    plant.reads("copy", Quality::Overrange, Some(1.5e5), 1);
    assert_eq!(alarm(&plant.world(), "COPY:P").0, EpicsSeverity::None);
    plant.loses("chamber");
    assert_eq!(alarm(&plant.world(), "CHAMBER:STATE").0, EpicsSeverity::Major);
    let mut usual = Plant::new("");
    usual.reads("chamber", Quality::Underrange, Some(5e-8), 1);
    assert_eq!(alarm(&usual.world(), "CHAMBER:P"), (EpicsSeverity::Minor, EpicsStatus::HwLimit));
}

/// Archives and panels show the number without the state beside it.
#[test]
fn the_end_of_the_range_has_an_alarm_and_words_that_say_what_it_is() {
    let mut plant = Plant::new("");
    let below = "below range: the value is its lower end";
    plant.reads("chamber", Quality::Underrange, Some(5e-8), 1);
    plant.reads("copy", Quality::Underrange, Some(5e-8), 1);
    let world = plant.world();
    for name in ["CHAMBER:P", "CHAMBER:PLOG", "COPY:P"] {
        assert_eq!(alarm(&world, name), (EpicsSeverity::Minor, EpicsStatus::HwLimit), "{name}");
        assert_eq!(text(&world, &format!("{name}.AMSG")), below, "{name}");
    }
    assert_eq!(text(&world, "CHAMBER:STATE.AMSG"), "Under range");
    plant.reads("chamber", Quality::Valid, Some(5e-4), 1);
    assert_eq!(text(&plant.world(), "CHAMBER:P.AMSG"), "");
    // The alarm of a limit has the severity; the words stay.
    plant.reads("chamber", Quality::Overrange, Some(1.5e5), 1);
    let world = plant.world();
    assert_eq!(alarm(&world, "CHAMBER:P").1, EpicsStatus::HiHi);
    for name in ["CHAMBER:P", "CHAMBER:PLOG"] {
        assert_eq!(text(&world, &format!("{name}.AMSG")), "above range: the value is its upper end", "{name}");
    }
    // A site may want no alarm: the words stay.
    let mut quiet = Plant::new("severity = { underrange = 'none' }");
    quiet.reads("chamber", Quality::Underrange, Some(5e-8), 1);
    let world = quiet.world();
    assert_eq!((alarm(&world, "CHAMBER:P").0, text(&world, "CHAMBER:P.AMSG")), (EpicsSeverity::None, below.to_owned()));
}

#[test]
fn a_lost_gauge_is_invalid_and_its_value_is_not_plausible_unless_it_is_held() {
    for (epics, is_held) in [("", false), ("on-invalid = 'hold'", true)] {
        let mut plant = Plant::new(epics);
        plant.reads("chamber", Quality::Valid, Some(5e-4), 7_000_000);
        plant.world();
        plant.loses("chamber");
        let world = plant.world();
        assert_eq!(alarm(&world, "CHAMBER:P"), (EpicsSeverity::Invalid, EpicsStatus::Comm));
        let value = number(&world, "CHAMBER:P");
        assert!(if is_held { close(value, 5e-6) } else { value.is_nan() }, "{epics}: {value}");
        assert_eq!(read(&world, "CHAMBER:P.UDF").sample.data, Data::Long(i64::from(!is_held)));
    }
}

/// Panels colour a record that is INVALID: what an alarm does not have is no fault of the plant.
#[test]
fn what_an_alarm_or_a_controller_does_not_have_is_no_alarm() {
    let mut plant = Plant::new("");
    plant.reads("chamber", Quality::Valid, Some(5e-4), 1);
    plant.reads("fore line", Quality::Valid, Some(5e-4), 1);
    let world = plant.world();
    let never = [Signal::RaisedValue, Signal::Raised, Signal::AcknowledgedAt, Signal::SuppressedUntil];
    let absent = world.database.records.iter().filter(|record| {
        never.contains(&record.signal)
            || (record.signal == Signal::AlarmValue && record.meta.unit.is_empty())
            || &*record.name == "FORE_LINE:CH1:P_CORR"
    });
    let absent: Vec<_> = absent.map(|record| &*record.name).collect();
    assert!(absent.len() > 10, "{absent:?}");
    for name in absent {
        assert_eq!(alarm(&world, name), (EpicsSeverity::None, EpicsStatus::None), "{name}");
        assert_eq!(text(&world, &format!("{name}.AMSG")), "there is none", "{name}");
    }
    let value = "ALARM:CHAMBER_HIGH:ALARM_VALUE";
    assert_eq!(alarm(&world, value), (EpicsSeverity::Invalid, EpicsStatus::Undefined), "an alarm with a limit has one");
}

#[test]
fn a_parameter_that_was_not_read_lately_does_not_say_that_the_gauge_does_not_communicate() {
    let mut plant = Plant::new("");
    plant.reads("chamber", Quality::Valid, Some(5e-4), 7_000_000);
    let name = "CHAMBER:SP_A_PCT_OF_ATM";
    let world = plant.world();
    assert_eq!(alarm(&world, name), (EpicsSeverity::Invalid, EpicsStatus::Scan));
    assert_eq!(text(&world, &format!("{name}.AMSG")), "Not read lately");
    plant.decides("chamber", BusStationState::Missing, 8_000_000);
    assert_eq!(alarm(&plant.world(), name), (EpicsSeverity::Invalid, EpicsStatus::Comm));
}

/// The Archiver Appliance drops an event with the time of the one before, and would show the last pressure until the gauge returns.
#[test]
fn a_loss_is_an_event_with_a_time_of_its_own() {
    for epics in ["", "on-invalid = 'hold'"] {
        let mut plant = Plant::new(epics);
        plant.reads("chamber", Quality::Valid, Some(5e-4), 7_000_000);
        let event = |plant: &mut Plant| {
            let world = plant.world();
            let sample = &read(&world, "CHAMBER:P").sample;
            (sample.severity, sample.status, sample.at)
        };
        assert_eq!(event(&mut plant).2, Micros(7_000_000));
        plant.decides("chamber", BusStationState::Missing, 8_000_000);
        assert_eq!(event(&mut plant), (EpicsSeverity::Invalid, EpicsStatus::Comm, Micros(8_000_000)), "{epics}");
        plant.decides("chamber", BusStationState::Starting, 9_000_000);
        assert_eq!(event(&mut plant), (EpicsSeverity::Invalid, EpicsStatus::State, Micros(9_000_000)), "{epics}");
    }
}

#[test]
fn a_virtual_gauge_is_marked_as_simulated() {
    let mut plant = Plant::new("");
    plant.reads("copy", Quality::Valid, Some(5e-4), 1);
    plant.reads("chamber", Quality::Valid, Some(5e-4), 1);
    let world = plant.world();
    assert_eq!(alarm(&world, "COPY:P"), (EpicsSeverity::None, EpicsStatus::Simulated));
    assert_eq!(text(&world, "COPY:P.DESC"), "virtual copy: pressure");
    assert_eq!(text(&world, "CHAMBER:P.DESC"), "chamber: pressure");
    let modes = ["COPY:P.SIMM", "CHAMBER:P.SIMM"].map(|name| read(&world, name).sample.data);
    assert_eq!(modes, [Data::Enum(1), Data::Enum(0)]);
}

#[test]
fn the_fields_that_archivers_ask_for_exist() {
    let mut plant = Plant::new("");
    plant.reads("chamber", Quality::Valid, Some(5e-4), 1);
    let world = plant.world();
    for field in [
        "NAME", "ADEL", "MDEL", "RTYP", "HIHI", "HIGH", "LOW", "LOLO", "LOPR", "HOPR", "EGU", "PREC", "DESC", "SEVR",
        "SCAN",
    ] {
        read(&world, &format!("CHAMBER:P.{field}"));
    }
    assert_eq!(
        (text(&world, "CHAMBER:P.NAME"), text(&world, "CHAMBER:P.RTYP")),
        ("CHAMBER:P".to_owned(), "ai".to_owned())
    );
    assert!(close(number(&world, "CHAMBER:P.ADEL"), 5e-6 / 20.0), "5 % of the value");
    assert_eq!(
        (text(&world, "CHAMBER:STATE.ONST"), text(&world, "CHAMBER:OK.ONAM")),
        ("Under range".to_owned(), "Yes".to_owned())
    );
    for absent in ["CHAMBER:P.XYZ", "CHAMBER:STATE.PREC", "CHAMBER:P.ZRST", "CHAMBER:Q", "", ".", "CHAMBER:P."] {
        assert_eq!(world.database.find(absent), None, "{absent:?}");
    }
}

#[test]
fn every_signal_has_a_value_a_description_and_a_type() {
    let mut plant = Plant::new("");
    plant.labels("chamber");
    let world = plant.world();
    for record in &world.database.records {
        let answer = read(&world, &record.name);
        assert!(!answer.meta.description.is_empty() && answer.meta.description.len() <= 39, "{}", record.name);
        assert_eq!(text(&world, &format!("{}.RTYP", record.name)), record.kind.name());
    }
    let signals: BTreeSet<_> = world.database.records.iter().map(|record| record.signal).collect();
    assert_eq!(signals.len(), Signal::ALL.len(), "every signal is published");
}

#[test]
fn each_row_of_the_names_has_the_unit_the_words_and_the_sentence_of_its_own_record() {
    let (config, mut settings) = config("prefix = 'VAC:'\nunit = 'Torr'");
    settings.write = Some(Write { user: "epics".to_owned(), users: "plant.users.toml".into(), clients: Vec::new() });
    let snapshot = Modeller::default().next(Inputs::planned(&config), Micros(1));
    let table = listing::names(&config.name, &snapshot, &settings).unwrap();
    let row = |name: &str| {
        let found = table.rows().iter().find(|row| row[0] == name).unwrap_or_else(|| panic!("no {name}"));
        found[1..].iter().map(String::as_str).collect::<Vec<_>>()
    };
    let logarithm = "Decimal logarithm of the indicated pressure in Torr";
    assert_eq!(row("VAC:CHAMBER:PLOG"), ["ai", "", "", "chamber.pressure-log10", logarithm]);
    let commands = "Takes the commands of the gauge; it has no value";
    assert_eq!(row("VAC:CHAMBER:CMD"), ["stringin", "", "", "chamber", commands]);
    let acknowledged = "Takes the number of the occurrence that is acknowledged";
    assert_eq!(row("VAC:ALARM:CHAMBER_HIGH:ACK"), ["int64in", "", "", "Chamber high", acknowledged]);
    assert_eq!(row("VAC:CHAMBER:P")[..2], ["ai", "Torr"]);
    assert_eq!(row("VAC:ALARM:CHAMBER_HIGH:ALARM_LIMIT")[..2], ["ai", "Torr"]);
    // No sentence names a unit that its record does not have.
    let pascals: Vec<_> = table.rows().iter().filter(|row| row[5].contains("Pa")).collect();
    assert!(pascals.iter().all(|row| !row[5].split([' ', ',', ';']).any(|word| word == "Pa")), "{pascals:?}");
    let world = with_parameters("unit = 'Torr'");
    assert_eq!(text(&world, "CHAMBER:PLOG.INP"), logarithm);
}

#[test]
fn the_lists_for_archiver_and_phoebus_name_records_that_exist() {
    let (config, settings) = config("prefix = 'VAC:'");
    let snapshot = Modeller::default().next(Inputs::planned(&config), Micros(1));
    let known: BTreeSet<_> = names("prefix = 'VAC:'").unwrap().into_iter().collect();
    let archived = listing::archiver(&config.name, &snapshot, &settings).unwrap();
    assert!(archived.lines().any(|line| line == "VAC:CHAMBER:P") && archived.lines().all(|line| known.contains(line)));
    assert!(!archived.contains("HEARTBEAT") && !archived.contains("P_STR"));
    let screen = listing::bob("A & B", &snapshot, &settings).unwrap();
    assert!(screen.contains("<name>A &amp; B</name>") && screen.ends_with("</display>\n"));
    let pvs: Vec<_> = screen.split("<pv_name>").skip(1).filter_map(|rest| rest.split('<').next()).collect();
    assert!(pvs.contains(&"VAC:FORE_LINE:CH4:P") && pvs.iter().all(|pv| known.contains(*pv)), "{pvs:?}");
}

/// A turbo pump by its GSD file, with a speed in Hz and a state in words.
#[test]
fn the_points_of_a_slave_have_records_in_their_own_unit() {
    const GSD: &str = "#Profibus_DP\nVendor_Name = \"Invented\"\nModel_Name = \"Pump\"\nIdent_Number = 0x0FA1\nModule = \"All\" 0x12\n1\nEndModule\n";
    const FILE: &str = r#"
[epics]
prefix = "VAC:"
[[segment]]
name = "hall"
port = "/dev/ttyUSB0"
[[segment.slave]]
name = "turbo"
address = 9
gsd = "pump.gsd"
[[segment.slave.point]]
name = "speed"
type = "u16"
unit = "Hz"
[[segment.slave.point.alarm]]
below = 1200
priority = "high"
[[segment.slave.point.alarm]]
below = 1400
[[segment.slave.point]]
name = "state"
octet = 2
type = "u8"
texts = { 3 = "at speed" }
"#;
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("pump.gsd"), GSD).unwrap();
    let config = profivac_config::parse(FILE, &folder.path().join("plant.toml")).unwrap();
    let [GatewaySettings::Epics(settings)] = &config.gateways[..] else { panic!("one gateway") };
    let mut inputs = Inputs::planned(&config);
    let turbo = &mut inputs.gauges[0];
    (turbo.state, turbo.age_ms) = (BusStationState::DataExchange, Some(10));
    let values = [(1000.0, "1000 Hz"), (3.0, "at speed")];
    for (point, (number, text)) in Arc::make_mut(&mut turbo.parameters).iter_mut().zip(values) {
        (point.number, point.quality, point.read_at) = (Some(number), Quality::Valid, Some(Micros(1)));
        point.text = text.to_owned();
    }
    let snapshot = Arc::new(Modeller::default().next(inputs, Micros(2)));
    let database = Arc::new(Database::new(&config.name, &snapshot, settings).unwrap());
    let held = held(&[], &snapshot, false, settings);
    let world = World { database, snapshot, held };
    assert!(close(number(&world, "VAC:TURBO:SPEED"), 1000.0));
    assert_eq!(text(&world, "VAC:TURBO:SPEED.EGU"), "Hz");
    // The limits of its alarms, in Hz.
    assert_eq!(alarm(&world, "VAC:TURBO:SPEED"), (EpicsSeverity::Major, EpicsStatus::LoLo));
    assert!(
        close(number(&world, "VAC:TURBO:SPEED.LOLO"), 1200.0) && close(number(&world, "VAC:TURBO:SPEED.LOW"), 1400.0)
    );
    assert!(number(&world, "VAC:TURBO:SPEED.HIHI").is_nan());
    assert_eq!(alarm(&world, "VAC:TURBO:STATE"), (EpicsSeverity::None, EpicsStatus::None));
    assert_eq!(text(&world, "VAC:TURBO:STATE_STR"), "at speed");
    assert_eq!(text(&world, "VAC:TURBO:FAULTS"), "");
}
