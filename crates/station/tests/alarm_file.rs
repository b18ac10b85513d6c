//! Alarms and webhooks in the configuration file: settings, default alarms, errors with positions.

#![allow(clippy::unwrap_used, clippy::panic, clippy::indexing_slicing, reason = "a test")]

use profivac_config::ConfigError;
use profivac_station::alarm::{Condition, Priority, Rule, Series};
use profivac_station::config::Config;
use profivac_web_server::auth::file_permissions;
use std::fs;
use std::os::unix::fs::PermissionsExt;
use std::path::Path;
use std::time::Duration;

const FILE: &str = r#"
[[segment]]
name = "hall"
port = "/dev/ttyUSB0"
[[segment.gauge]]
name = "chamber"
address = 5
device = "bcg450"
[[segment.gauge]]
name = "tpg"
address = 6
device = "tpg500"

[[alarm]]
name = "too high"
gauge = "chamber"
above = "1e-3 mbar"
hysteresis = 0.5
delay = "2 s"
off-delay = "0 s"
priority = "high"
message = "close the valve"

[[alarm]]
name = "vented"
gauge = "tpg.2"
below = "1 mbar"
reset = "2 mbar"

[[alarm]]
name = "leak"
gauge = "chamber"
rise = 0.5
window = "20 s"
"#;

fn parse(text: &str) -> Result<Config, ConfigError> {
    profivac_config::parse(text, Path::new("hall.toml"))
}

fn rules(text: &str) -> Vec<Rule> {
    parse(text).unwrap().alarms
}

fn rule(rules: &[Rule], name: &str) -> Rule {
    rules.iter().find(|rule| rule.name == name).unwrap_or_else(|| panic!("no {name} among {rules:#?}")).clone()
}

fn series(gauge: &str, name: &str) -> Series {
    Series { gauge: gauge.to_owned(), name: name.to_owned() }
}

fn names(text: &str) -> Vec<String> {
    rules(text).into_iter().map(|rule| rule.name).collect()
}

#[test]
fn an_alarm_has_the_settings_of_the_file() {
    let all = rules(FILE);
    let high = rule(&all, "too high");
    let Condition::Above { series: chamber, limit, reset } = high.condition else { panic!("{high:?}") };
    assert_eq!(chamber, series("chamber", "chamber"));
    assert!((limit - 0.1).abs() < 1e-12 && (reset - 0.1 / 10_f64.sqrt()).abs() < 1e-12, "{limit} {reset}");
    assert_eq!((high.delay, high.off_delay, high.priority), (Duration::from_secs(2), Duration::ZERO, Priority::High));
    assert_eq!(high.message.as_deref(), Some("close the valve"));
    let vented = rule(&all, "vented");
    assert_eq!(vented.condition, Condition::Below { series: series("tpg", "tpg.2"), limit: 100.0, reset: 200.0 });
    assert_eq!(
        (vented.delay, vented.off_delay, vented.priority),
        (Duration::from_secs(1), Duration::from_secs(5), Priority::Medium)
    );
    let leak = rule(&all, "leak").condition;
    let (chamber, window) = (series("chamber", "chamber"), Duration::from_secs(20));
    assert_eq!(leak, Condition::Rise { series: chamber, limit: 0.5, reset: 0.25, window });
}

#[test]
fn every_gauge_and_segment_has_default_alarms() {
    assert_eq!(
        names(FILE),
        [
            "too high",
            "vented",
            "leak",
            "segment hall: down",
            "segment hall: damage",
            "chamber: fault",
            "chamber: no data",
            "tpg: fault",
            "tpg: no data",
            "chamber: limit not measurable",
            "tpg.2: limit not measurable",
            "station: not recording",
            "station: database damaged",
        ]
    );
    let all = rules(FILE);
    assert_eq!(rule(&all, "segment hall: down").priority, Priority::High);
    let stale = Condition::Stale { gauge: "chamber".to_owned(), behind_segment: Some("hall".to_owned()) };
    assert_eq!(rule(&all, "chamber: no data").condition, stale);
    assert_eq!(
        rule(&all, "tpg.2: limit not measurable").condition,
        Condition::NotMeasurable { series: series("tpg", "tpg.2"), limits: vec![100.0], has_fault_alarm: true }
    );
}

#[test]
fn a_default_alarm_can_be_changed_and_switched_off() {
    let file = FILE.to_owned()
        + "[alarms]\nfault = { priority = 'high', delay = '7 s' }\nstale = { except = ['tpg'] }\nsegment = { priority = 'off' }\n\
           damage = { limit = 100, off-delay = '9 s' }\nnot-measurable = { priority = 'off' }\ndatabase = { priority = 'off' }\ndatabase-damage = { priority = 'off' }\n";
    let all = rules(&file);
    assert_eq!(names(&file)[3..], ["segment hall: damage", "chamber: fault", "chamber: no data", "tpg: fault"]);
    assert_eq!(
        (rule(&all, "tpg: fault").priority, rule(&all, "tpg: fault").delay),
        (Priority::High, Duration::from_secs(7))
    );
    assert_eq!(
        rule(&all, "chamber: no data").condition,
        Condition::Stale { gauge: "chamber".to_owned(), behind_segment: None },
        "the alarm of the segment is off"
    );
    let damage = rule(&all, "segment hall: damage");
    assert_eq!(
        (damage.condition, damage.off_delay),
        (Condition::DamagedTelegrams { segment: "hall".to_owned(), limit: 100.0 }, Duration::from_secs(9))
    );
}

#[test]
fn an_error_names_its_position_and_what_was_expected() {
    let defaults = |line: &str| FILE.to_owned() + "[alarms]\n" + line + "\n";
    let altered = |from: &str, to: &str| FILE.replacen(from, to, 1);
    for (file, sentence) in [
        (
            altered("\"too high\"", "\"leak\""),
            "hall.toml:31:8: the alarm \"leak\" is defined twice; choose another name",
        ),
        (altered("\"too high\"", "\"\""), "hall.toml:15:8: expected a name for the alarm, found an empty string"),
        (
            altered("\"too high\"", "\"chamber: fault\""),
            "15:8: \"chamber: fault\" is the name of a default alarm; choose another name, or change",
        ),
        (altered("\"tpg.2\"", "\"tgp.2\""), "hall.toml:26:9: there is no gauge \"tgp.2\"; did you mean \"tpg\"?"),
        (altered("\"tpg.2\"", "\"tpg.x\""), "there is no gauge \"tpg.x\""),
        (
            altered("gauge = \"chamber\"\nabove", "gauge = \"Chambre\"\nabove"),
            "hall.toml:16:9: there is no gauge \"Chambre\"; did you mean \"chamber\"?",
        ),
        (altered("above = \"1e-3 mbar\"", "above = \"1e-3\""), "hall.toml:17:9: expected a unit, one of mbar"),
        (
            altered("above = \"1e-3 mbar\"", "above = \"0 mbar\""),
            "hall.toml:17:9: expected a pressure above 0, found 0",
        ),
        (
            altered("above = \"1e-3 mbar\"", ""),
            "hall.toml:15:8: expected one of above, below and rise for the alarm \"too high\"",
        ),
        (altered("hysteresis = 0.5", "below = \"1 mbar\""), "expected one of above, below and rise"),
        (
            altered("hysteresis = 0.5", "hysteresis = -0.5"),
            "hall.toml:18:14: expected a hysteresis in decades from 0 to 10, found -0.5",
        ),
        (altered("hysteresis = 0.5", "hysteresis = nan"), "hall.toml:18:14: expected a hysteresis"),
        (
            altered("hysteresis = 0.5", "reset = \"2e-3 mbar\""),
            "hall.toml:18:9: expected a reset not above the limit 1e-3 mbar, found 2e-3 mbar",
        ),
        (
            altered("\"2 mbar\"", "\"0.5 mbar\""),
            "hall.toml:28:9: expected a reset not below the limit 1e0 mbar, found 5e-1 mbar",
        ),
        (
            altered("reset = \"2 mbar\"", "reset = \"2 mbar\"\nhysteresis = 1.0"),
            "hall.toml:28:9: expected reset or hysteresis, found both",
        ),
        (altered("delay = \"2 s\"", "delay = \"2 h\""), "hall.toml:19:9: expected a delay of at most 1h, found 2h"),
        (
            altered("\"high\"\nmessage", "\"urgent\"\nmessage"),
            "hall.toml:21:12: expected a priority, one of high, medium, low, found \"urgent\"",
        ),
        (altered("rise = 0.5", "rise = 0.0"), "hall.toml:33:8: expected decades per minute above 0 to 10, found 0"),
        (altered("\"20 s\"", "\"1 s\""), "hall.toml:34:10: expected a window from 5s to 10m, found 1s"),
        (altered("message =", "window = \"20 s\"\nmessage ="), "hall.toml:22:10: window applies to rise only"),
        (altered("window =", "reset = \"1 mbar\"\nwindow ="), "hall.toml:34:9: reset does not apply to rise"),
        (altered("message =", "massage ="), "hall.toml:22:1: unknown field `massage`"),
        (
            defaults("fault = { priority = 'loud' }"),
            "expected a priority, one of high, medium, low, off, found \"loud\"",
        ),
        (
            defaults("stale = { except = ['chambre'] }"),
            "hall.toml:36:21: there is no gauge \"chambre\"; did you mean \"chamber\"?",
        ),
        (
            defaults("segment = { except = ['hal'] }"),
            "there is no segment \"hal\"; write the name of a [[segment]], or add one; did you mean \"hall\"?",
        ),
        (defaults("fault = { limit = 3 }"), "hall.toml:36:19: only damage has a limit"),
        (defaults("damage = { limit = 0.5 }"), "expected telegrams per minute from 1 to 1000000, found 0.5"),
        (defaults("stall = {}"), "unknown field `stall`"),
    ] {
        let error = parse(&file).unwrap_err().to_string();
        assert!(error.contains(sentence), "expected {sentence}\nfound {error}");
    }
}

#[test]
fn a_webhook_has_the_settings_of_the_file_and_hides_its_secret() {
    let folder = tempfile::tempdir().unwrap();
    let token = folder.path().join("ops.token");
    file_permissions::write(&token, "s3cret\n").unwrap();
    let file = FILE.to_owned()
        + "[[webhook]]\nurl = 'https://alarms.example.org:8443/hook/abc'\ntoken-file = 'ops.token'\npriority = 'medium'\n\
           quiet = '22:00-06:30'\nunacknowledged-after = '10 min'\n\
           [[webhook]]\nname = 'ours'\nurl = 'http://10.0.0.1/hook'\n";
    let path = folder.path().join("hall.toml");
    let config = profivac_config::parse(&file, &path).unwrap();
    assert!(config.is_private());
    let [first, second] = &config.webhooks[..] else { panic!("{:?}", config.webhooks) };
    assert_eq!((first.name.as_str(), first.min_priority), ("alarms.example.org", Priority::Medium));
    let target = first.target();
    let quiet = target.quiet.unwrap();
    assert_eq!((quiet.from.to_string(), quiet.to.to_string()), ("22:00:00".to_owned(), "06:30:00".to_owned()));
    assert_eq!(target.unacknowledged_after, Duration::from_secs(600));
    assert_eq!(first.token.as_ref().unwrap().reveal(), "s3cret");
    assert_eq!(first.origin(), "https://alarms.example.org:8443");
    assert_eq!((second.name.as_str(), second.min_priority, &second.token), ("ours", Priority::Low, &None));
    let shown = format!("{config:?}");
    assert!(!shown.contains("s3cret") && !shown.contains("hook/abc"), "{shown}");
    fs::set_permissions(&token, fs::Permissions::from_mode(0o640)).unwrap();
    let error = profivac_config::parse(&file, &path).unwrap_err().to_string();
    let wanted = format!("is open to others (mode 640): chmod 600 {}", token.display());
    assert!(error.contains("hall.toml:37:14: ") && error.ends_with(&wanted), "{error}");
}

#[test]
fn an_error_in_a_webhook_names_its_position_and_no_secret() {
    for (lines, sentence) in [
        ("url = 'ftp://host/x'", "hall.toml:36:7: expected a URL like https://host/path, found another scheme"),
        ("url = '/x'", "36:7: expected a URL like https://host/path, found a URL without a host"),
        ("url = 'https://a b/'", "hall.toml:36:7: "),
        ("url = 'https://me:s3cret@host/'", "found a URL with a password; use token or token-file instead"),
        (
            "url = 'http://host/'\ntoken = 's3cret'",
            "found http with a token, which would travel unencrypted; use https",
        ),
        (
            "url = 'https://host/'\ntoken = 's3 cret'",
            "37:9: expected a token of visible ASCII characters without spaces",
        ),
        ("url = 'https://host/'\ntoken = 3535", "37:9: expected a token in quotes"),
        (
            "url = 'https://host/'\ntoken = 's3cret'\ntoken-file = 'x'",
            "38:14: expected token or token-file, found both",
        ),
        (
            "url = 'https://host/'\nquiet = '22-6'",
            "37:9: expected the beginning and the end of the quiet hours such as",
        ),
        ("url = 'https://host/'\nquiet = '22:00-22:00'", "37:9: expected the beginning and the end of the quiet hours"),
        ("url = 'https://host/'\nquiet = '22:00-24:01'", "37:9: expected the beginning and the end of the quiet hours"),
        ("url = 'https://host/'\nunacknowledged-after = '0 s'", "37:24: expected a time from 1s to 1 day, found 0s"),
        ("url = 'https://host/'\ntoken-file = 'no/such'", "37:14: no/such cannot be read: "),
        ("url = 'https://host/'\nca-file = 'no/such'", "37:11: no/such cannot be read: "),
        ("url = 'https://host/'\npriority = 'off'", "expected a priority, one of high, medium, low, found \"off\""),
        (
            "url = 'https://host/'\n[[webhook]]\nurl = 'https://host/other'",
            "38:7: the webhook \"host\" is defined twice; give each a name of its own",
        ),
        ("name = ' '\nurl = 'https://host/'", "36:8: expected a name for the webhook, found an empty string"),
    ] {
        let error = profivac_config::parse(&format!("{FILE}[[webhook]]\n{lines}\n"), Path::new("hall.toml"))
            .unwrap_err()
            .to_string();
        assert!(error.contains(sentence), "expected {sentence}\nfound {error}");
        assert!(!error.contains("s3") && !error.contains("3535"), "{error}");
    }
}

/// The file, with an alarm about several gauges.
fn several(keys: &str) -> String {
    format!("{FILE}\n[[alarm]]\nname = \"hall vented\"\n{keys}\n")
}

#[test]
fn an_alarm_about_several_gauges_has_a_condition_for_each() {
    let rules = rules(&several("gauges = [\"chamber\", \"tpg.1\", \"tpg.3\"]\ncount = 2\nabove = \"1 mbar\""));
    let Condition::Several { conditions, count } = rule(&rules, "hall vented").condition else { panic!("{rules:?}") };
    let names: Vec<_> = conditions.iter().filter_map(Condition::series).map(|series| series.name.as_str()).collect();
    assert_eq!((names, count), (vec!["chamber", "tpg.1", "tpg.3"], 2));
    assert!(
        conditions.iter().all(|condition| matches!(condition, Condition::Above { limit: 100.0, .. })),
        "{conditions:?}"
    );
    // Each gauge whose reading does not decide the limit is reported.
    rule(&rules, "tpg.3: limit not measurable");
}

#[test]
fn an_impossible_list_of_gauges_is_an_error_at_its_place() {
    let cases = [
        (
            "gauges = [\"chamber\"]\ncount = 2\nabove = \"1 mbar\"",
            "expected count from 1 to the number of gauges, which is 1, got 2",
        ),
        (
            "gauges = []\ncount = 0\nabove = \"1 mbar\"",
            "expected count from 1 to the number of gauges, which is 0, got 0",
        ),
        (
            "gauges = [\"chamber\", \"chamber\"]\ncount = 1\nabove = \"1 mbar\"",
            "\"chamber\" is twice in the list of gauges",
        ),
        ("gauges = [\"chambre\"]\ncount = 1\nabove = \"1 mbar\"", "chambre"),
        ("gauges = [\"chamber\"]\nabove = \"1 mbar\"", "one of: gauge, or gauges and count,"),
        ("gauges = [\"chamber\"]\ncount = 1\nlost = 1.0", "one of: gauge, or gauges and count,"),
        ("gauges = [\"chamber\"]\ncount = 1", "expected one of above, below and rise"),
    ];
    for (keys, expected) in cases {
        let error = parse(&several(keys)).unwrap_err().to_string();
        assert!(error.starts_with("hall.toml:") && error.contains(expected), "{keys}: {error}");
    }
}
