//! The metrics of a station: which series there are, with which values, and which are absent.

#![allow(clippy::unwrap_used, clippy::panic, reason = "a test")]

use profivac_gateway::model::Modeller;
use profivac_gateway::{Inputs, Signal};
use profivac_gateway_prometheus::family::{Family, Form};
use profivac_gateway_prometheus::metrics::{Layout, Others};
use profivac_listen::report::{Bucket, BusReport, Distribution};
use profivac_recorder::{Micros, Quality};
use profivac_station::config::gateways::GatewaySettings;
use profivac_station::gateway_status::GatewayStatuses;
use profivac_station::view::BusStationState;
use profivac_web_server::exposition::Format;
use std::collections::BTreeMap;
use std::os::unix::fs::PermissionsExt;
use std::path::Path;
use std::sync::Arc;

const FILE: &str = r#"
[[segment]]
name = "hall"
port = "sim:hall.toml"

[[segment.gauge]]
name = 'cham"ber'
address = 5
device = "bcg450"

[[segment.gauge]]
name = "fore line"
address = 6
device = "tpg300"

[[alarm]]
name = "Chamber high"
gauge = 'cham"ber'
above = "1e-3 mbar"
priority = "high"
"#;

/// The first gauge has a reading of this quality.
fn inputs(quality: Quality, pa: Option<f64>, limit_pa: Option<f64>) -> Inputs {
    let mut inputs = Inputs::planned(&profivac_config::parse(FILE, Path::new("plant.toml")).unwrap());
    let gauge = &mut inputs.gauges[0];
    gauge.state = BusStationState::DataExchange;
    (gauge.age_ms, gauge.read_at) = (Some(10), Some(Micros(1_700_000_000_250_000)));
    let reading = &mut gauge.readings[0];
    (reading.quality, reading.pa, reading.limit_pa) = (quality, pa, limit_pa);
    inputs
}

fn text(inputs: Inputs, others: &Others, format: Format) -> String {
    let snapshot = Modeller::default().next(inputs, Micros(1));
    Layout::of(&snapshot.points).text(&snapshot, others, format)
}

/// The lines of the samples of this name.
fn samples<'a>(text: &'a str, name: &str) -> Vec<&'a str> {
    text.lines().filter(|line| line.split(['{', ' ']).next() == Some(name)).collect()
}

const LABELS: &str = r#"segment="hall",gauge="cham\"ber""#;

#[test]
fn a_measured_pressure_has_value_state_time_range_and_limit() {
    let text = text(inputs(Quality::Valid, Some(5.2e-7), None), &Others::default(), Format::OpenMetrics);
    let has = |line: &str| assert!(text.lines().any(|it| it == line), "no {line} in\n{text}");
    has(&format!("profivac_reading_pressure_pascals{{{LABELS}}} 5.2e-7"));
    has(&format!("profivac_reading_state{{{LABELS},state=\"ok\"}} 1"));
    has(&format!("profivac_reading_state{{{LABELS},state=\"over_range\"}} 0"));
    has(&format!("profivac_reading_timestamp_seconds{{{LABELS}}} 1700000000.250000"));
    has(&format!("profivac_reading_limit_pascals{{{LABELS},limit=\"high_high\"}} 0.1"));
    assert_eq!(samples(&text, "profivac_reading_range_low_pascals").len(), 1, "the controller has no range");
    assert!(text.ends_with("\n# EOF\n"));
}

/// A series that stays at its last value looks alive for ever, and the end of the range is no measured pressure.
#[test]
fn a_pressure_that_is_not_measured_is_absent_and_its_state_says_why() {
    let states = [
        (Quality::Overrange, Some(1.5e5), "over_range"),
        (Quality::Underrange, Some(5e-8), "under_range"),
        (Quality::Off, None, "off"),
        (Quality::Fault, None, "invalid"),
        (Quality::Stale, None, "stale"),
    ];
    for (quality, limit, word) in states {
        let text = text(inputs(quality, None, limit), &Others::default(), Format::OpenMetrics);
        for name in ["pressure_pascals", "pressure_log10", "corrected_pressure_pascals"] {
            assert_eq!(samples(&text, &format!("profivac_reading_{name}")), [""; 0], "{quality:?}");
        }
        let help = text.lines().find(|line| line.starts_with("# HELP profivac_reading_pressure_pascals")).unwrap();
        assert!(help.ends_with("Indicated pressure; absent while it is not measured."), "{help}");
        let state = format!("profivac_reading_state{{{LABELS},state=\"{word}\"}} 1");
        assert!(samples(&text, "profivac_reading_state").contains(&state.as_str()), "{state}");
    }
}

#[test]
fn every_signal_is_published_or_left_out_on_purpose() {
    let text = text(inputs(Quality::Valid, Some(1.0), None), &Others::default(), Format::OpenMetrics);
    for signal in Signal::ALL {
        let Family { name, form, .. } = Family::of(*signal);
        let is_described = text.contains(&format!("# TYPE {name} "));
        assert_eq!(is_described, form != Form::Absent, "{signal:?}: {name}");
        let has_numbers = matches!(signal, Signal::StateText | Signal::Cause | Signal::AlarmText);
        assert!(form != Form::Absent || has_numbers, "{signal:?}");
    }
    assert_eq!(
        samples(&text, "profivac_device_info")[0],
        format!(
            r#"profivac_device_info{{{LABELS},device="bcg450",address="5",gas="n2",simulated="true",listen_only="false"}} 1"#
        )
    );
    assert_eq!(
        samples(&text, "profivac_alarm_active")
            .iter()
            .filter(|line| line.contains(r#"alarm="Chamber high",priority="high""#))
            .count(),
        1
    );
}

#[test]
fn a_family_is_described_once_and_its_samples_follow_it() {
    let text = text(inputs(Quality::Valid, Some(1.0), None), &Others::default(), Format::OpenMetrics);
    let mut families = Vec::new();
    for line in text.lines().filter(|line| *line != "# EOF") {
        if let Some(rest) = line.strip_prefix("# TYPE ") {
            families.push(rest.split(' ').next().unwrap());
        }
        let family = families.last().unwrap();
        let name = line.trim_start_matches("# HELP ").trim_start_matches("# UNIT ").trim_start_matches("# TYPE ");
        assert!(name.starts_with(*family), "{line} in the family {family}");
    }
    let count = families.len();
    families.sort_unstable();
    families.dedup();
    assert_eq!(families.len(), count);
}

fn bus(buckets: Vec<Bucket>) -> BusReport {
    let count = buckets.iter().map(|bucket| bucket.count).sum();
    let sum_us = buckets.iter().map(|bucket| bucket.end_us * bucket.count).sum();
    BusReport {
        baud: 500_000,
        observed_ms: 0,
        telegrams: 0,
        octets: 0,
        damaged: 0,
        damaged_last_minute: 0,
        damaged_unattributed: 0,
        recorder_octets: 0,
        ring: Vec::new(),
        cycle: Distribution { count, sum_us, buckets, ..Distribution::default() },
        rotation: Distribution::default(),
        masters: Vec::new(),
        stations: Vec::new(),
        parameters: Vec::new(),
        events: Vec::new(),
    }
}

#[test]
fn the_cycles_are_a_histogram_with_the_same_bounds_for_every_segment() {
    let buckets = vec![Bucket { end_us: 900, count: 3 }, Bucket { end_us: 2_600, count: 2 }];
    let buses =
        BTreeMap::from([("hall".to_owned(), Arc::new(bus(buckets))), ("lab".to_owned(), Arc::new(bus(Vec::new())))]);
    let text =
        text(inputs(Quality::Valid, Some(1.0), None), &Others { buses, ..Others::default() }, Format::OpenMetrics);
    let bound = |le: &str| {
        let start = format!("profivac_segment_cycle_seconds_bucket{{segment=\"hall\",le=\"{le}\"}} ");
        text.lines().find_map(|line| line.strip_prefix(&start)).unwrap_or_else(|| panic!("{start}")).to_owned()
    };
    assert_eq!(["0.0005", "0.001", "0.0025", "0.005", "10.0", "+Inf"].map(bound), ["0", "3", "3", "5", "5", "5"]);
    assert_eq!(samples(&text, "profivac_segment_cycle_seconds_bucket").len(), 2 * 15);
    assert_eq!(samples(&text, "profivac_segment_cycle_seconds_count").len(), 2);
    let sums = samples(&text, "profivac_segment_cycle_seconds_sum");
    assert_eq!((sums.len(), sums[0].ends_with(" 0.007900")), (2, true), "{sums:?}");
}

#[test]
fn a_gateway_has_its_clients_and_its_errors() {
    let statuses = GatewayStatuses::default();
    let status = statuses.add("modbus");
    status.runs("127.0.0.1:1502".to_owned());
    status.client_connected();
    status.dropped_updates(3);
    status.refused("a write");
    let others = Others { gateways: statuses.views(), ..Others::default() };
    let text = text(inputs(Quality::Valid, Some(1.0), None), &others, Format::Prometheus);
    let value = |name: &str| samples(&text, name)[0].rsplit(' ').next().unwrap().to_owned();
    assert_eq!(value("profivac_gateway_up"), "1");
    assert_eq!(value("profivac_gateway_clients"), "1");
    assert_eq!(value("profivac_gateway_dropped_updates_total"), "3");
    assert_eq!(value("profivac_gateway_refused_total"), "1");
    assert!(value("profivac_gateway_last_error_timestamp_seconds").parse::<f64>().unwrap() > 1.7e9);
    assert!(!text.contains("# EOF") && text.contains("# TYPE profivac_device_info gauge"));
}

#[test]
fn a_station_with_an_archive_has_what_waits_and_when_the_archive_answered() {
    let statuses = GatewayStatuses::default();
    let archive = statuses.add("archive");
    let of = |statuses: &GatewayStatuses| {
        let others = Others { gateways: statuses.views(), ..Others::default() };
        text(inputs(Quality::Valid, Some(1.0), None), &others, Format::Prometheus)
    };
    // The types are there, for rules that name the metrics; nothing is known yet.
    let before = of(&statuses);
    assert!(before.contains("# TYPE profivac_archive_lost_batches gauge"), "{before}");
    assert!(!before.lines().any(|line| line.starts_with("profivac_archive_")), "{before}");
    archive.batches(3, Some(Micros(1_700_000_000 * Micros::SECOND)), 7);
    archive.put_aside(2, Some("a time before 2000"));
    archive.archive_answered();
    let text = of(&statuses);
    let value = |name: &str| samples(&text, name)[0].rsplit(' ').next().unwrap().parse::<f64>().unwrap();
    assert_eq!(value("profivac_archive_waiting_batches"), 3.0);
    assert_eq!(value("profivac_archive_lost_batches"), 7.0);
    assert_eq!(value("profivac_archive_put_aside_batches"), 2.0);
    assert_eq!(value("profivac_archive_oldest_batch_timestamp_seconds"), 1_700_000_000.0);
    assert!(value("profivac_archive_last_answer_timestamp_seconds") > 1.7e9);
}

#[test]
fn a_layout_serves_the_snapshots_of_the_same_points() {
    let mut modeller = Modeller::default();
    let first = modeller.next(inputs(Quality::Valid, Some(1.0), None), Micros(1));
    let second = modeller.next(inputs(Quality::Valid, Some(2.0), None), Micros(2));
    let mut layout = Layout::of(&first.points);
    assert!(layout.fits(&second));
    let text = layout.text(&second, &Others::default(), Format::OpenMetrics);
    assert_eq!(
        samples(&text, "profivac_reading_pressure_pascals"),
        [format!("profivac_reading_pressure_pascals{{{LABELS}}} 2")]
    );
    let mut fewer = inputs(Quality::Valid, Some(2.0), None);
    fewer.gauges.pop();
    assert!(!layout.fits(&modeller.next(fewer, Micros(3))));
}

/// Nothing is readable from other computers without TLS and a token.
#[test]
fn other_computers_need_tls_and_a_token() {
    let folder = tempfile::tempdir().unwrap();
    let token = folder.path().join("token");
    std::fs::write(&token, "secret\n").unwrap();
    let parse = |text: &str| profivac_config::parse(&format!("{FILE}{text}"), &folder.path().join("plant.toml"));
    let tls = "[tls]\ncertificate = \"c.pem\"\nkey = \"k.pem\"\n";
    let exposed = "[prometheus]\nlisten = \"0.0.0.0:9464\"\n";
    let problem = |text: &str| parse(text).unwrap_err().to_string();
    assert!(problem(exposed).contains("which needs [tls] with certificate and key; without, listen on 127.0.0.1"));
    assert!(problem(&format!("{tls}{exposed}")).contains("which needs token-file"));
    let complete = format!("{tls}{exposed}token-file = \"token\"\n");
    std::fs::set_permissions(&token, std::fs::Permissions::from_mode(0o644)).unwrap();
    assert!(
        problem(&complete).contains("token holds secrets and is open to others (mode 644)"),
        "{}",
        problem(&complete)
    );
    std::fs::set_permissions(&token, std::fs::Permissions::from_mode(0o600)).unwrap();
    let config = parse(&complete).unwrap();
    let [GatewaySettings::Prometheus(settings)] = &config.gateways[..] else { panic!("one gateway") };
    assert_eq!(settings.tls.as_ref().unwrap().key, folder.path().join("k.pem"));
    assert_eq!(settings.token.as_ref().unwrap().reveal(), "secret");
    assert!(config.is_private() && !format!("{settings:?}").contains("\"secret\""));
    let plain = parse("[prometheus]\n").unwrap();
    let [GatewaySettings::Prometheus(settings)] = &plain.gateways[..] else { panic!("one gateway") };
    assert_eq!(
        (settings.listen.to_string().as_str(), &settings.token, &settings.tls),
        ("127.0.0.1:9464", &None, &None)
    );
}

/// The chamber has these parameters, with numbers and texts.
fn with_parameters(parameters: &[(&str, f64, &str)]) -> String {
    let mut inputs = inputs(Quality::Valid, Some(1.0), None);
    for parameter in Arc::make_mut(&mut inputs.gauges[0].parameters) {
        let Some((_, number, text)) = parameters.iter().find(|(target, ..)| *target == parameter.target) else {
            continue;
        };
        (parameter.number, parameter.text) = (Some(*number), (*text).to_owned());
        (parameter.quality, parameter.read_at) = (Quality::Valid, Some(Micros(1)));
    }
    text(inputs, &Others::default(), Format::OpenMetrics)
}

/// Each value would begin a new series, and the old ones would stay in the database of Prometheus.
#[test]
fn a_parameter_in_words_is_one_series_whose_label_changes_and_a_number_has_no_text() {
    for word in ["off", "on"] {
        let text = with_parameters(&[("ba.degas-status", 1.0, word), ("setpoint-a.process-value", 5.0, "0.05 mbar")]);
        let expected =
            format!(r#"profivac_parameter_text_info{{{LABELS},parameter="ba.degas-status",text="{word}"}} 1"#);
        assert_eq!(samples(&text, "profivac_parameter_text_info"), [expected]);
        let number =
            format!(r#"profivac_parameter_pressure_pascals{{{LABELS},parameter="setpoint-a.process-value"}} 5"#);
        assert_eq!(samples(&text, "profivac_parameter_pressure_pascals"), [number]);
    }
}

/// The limit of an alarm has the unit of its condition, the number of a point that of the file.
#[test]
fn a_number_without_a_unit_in_its_name_has_its_unit_as_a_label() {
    let text = text(inputs(Quality::Valid, Some(1.0), None), &Others::default(), Format::OpenMetrics);
    let limits = samples(&text, "profivac_alarm_limit");
    assert!(limits.contains(&r#"profivac_alarm_limit{alarm="Chamber high",unit="Pa"} 0.1"#), "{limits:?}");
    assert!(samples(&text, "profivac_segment_cycle_time_seconds").iter().all(|line| !line.contains("unit=")));
}

/// SIGHUP changes the place of a gauge and the priority of an alarm.
#[test]
fn the_description_of_an_info_series_says_that_its_labels_may_change() {
    let text = text(inputs(Quality::Valid, Some(1.0), None), &Others::default(), Format::OpenMetrics);
    for family in ["profivac_device", "profivac_alarm", "profivac_station"] {
        let start = format!("# HELP {family} ");
        let help = text.lines().find_map(|line| line.strip_prefix(&start)).unwrap_or_else(|| panic!("no {family}"));
        assert_eq!(help, "Facts in the labels, the value is always 1; a fact that changes begins a new series.");
    }
}

#[test]
fn the_labels_of_a_gauge_are_labels_of_its_info_series() {
    let labels = "device = \"bcg450\"\ngroup = \"target\"\ntags = [\"bake-out\"]\nlocation = \"hall, \\\"A\\\"\"\n\
                  calibrated = 2026-05-01\ncalibration-interval = \"365 days\"";
    let file = FILE.replacen("device = \"bcg450\"", labels, 1);
    let inputs = Inputs::planned(&profivac_config::parse(&file, Path::new("plant.toml")).unwrap());
    let text = text(inputs, &Others::default(), Format::OpenMetrics);
    let expected = format!(
        r#"profivac_device_info{{{LABELS},device="bcg450",address="5",gas="n2",group="target",tags="bake-out",location="hall, \"A\"",calibrated="2026-05-01",calibration_due="2027-05-01",simulated="true",listen_only="false"}} 1"#
    );
    assert_eq!(samples(&text, "profivac_device_info")[0], expected);
    assert_eq!(samples(&text, "profivac_device_info").len(), 2, "a series for each gauge");
}
