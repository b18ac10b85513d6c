//! Alarms and webhooks in the file: what stands there, what there is by itself, and what is wrong, with its place.

#![allow(clippy::unwrap_used, clippy::panic, clippy::indexing_slicing, reason = "a test")]

use profivac_station::alarm::{Condition, Priority, Rule, Subject};
use profivac_station::auth::file_permissions;
use profivac_station::config::{Config, ConfigError};
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
    Config::parse(text, Path::new("hall.toml"))
}

fn rules(text: &str) -> Vec<Rule> {
    parse(text).unwrap().alarms
}

fn rule(rules: &[Rule], name: &str) -> Rule {
    rules.iter().find(|rule| rule.name == name).unwrap_or_else(|| panic!("no {name} among {rules:#?}")).clone()
}

fn names(text: &str) -> Vec<String> {
    rules(text).into_iter().map(|rule| rule.name).collect()
}

#[test]
fn alarms_of_the_file_are_as_it_says() {
    let all = rules(FILE);
    let high = rule(&all, "too high");
    assert_eq!(high.subject, Subject::Series { gauge: "chamber".to_owned(), series: "chamber".to_owned() });
    let Condition::Above { limit, reset } = high.condition else { panic!("{high:?}") };
    assert!((limit - 0.1).abs() < 1e-12 && (reset - 0.1 / 10_f64.sqrt()).abs() < 1e-12, "{limit} {reset}");
    assert_eq!((high.delay, high.off_delay, high.priority), (Duration::from_secs(2), Duration::ZERO, Priority::High));
    assert_eq!(high.message.as_deref(), Some("close the valve"));
    let vented = rule(&all, "vented");
    assert_eq!(vented.subject, Subject::Series { gauge: "tpg".to_owned(), series: "tpg.2".to_owned() });
    assert_eq!(vented.condition, Condition::Below { limit: 100.0, reset: 200.0 });
    assert_eq!(
        (vented.delay, vented.off_delay, vented.priority),
        (Duration::from_secs(1), Duration::from_secs(5), Priority::Medium)
    );
    let leak = rule(&all, "leak").condition;
    assert_eq!(leak, Condition::Rise { limit: 0.5, reset: 0.25, window: Duration::from_secs(20) });
}

#[test]
fn every_gauge_and_segment_has_alarms_by_itself() {
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
            "chamber: blind",
            "tpg.2: blind",
            "record: not written",
        ]
    );
    let all = rules(FILE);
    assert_eq!(rule(&all, "segment hall: down").priority, Priority::High);
    assert_eq!(rule(&all, "chamber: no data").condition, Condition::Stale { behind_segment: Some("hall".to_owned()) });
    assert_eq!(rule(&all, "tpg.2: blind").condition, Condition::NotMeasurable { limits: vec![100.0] });
}

#[test]
fn what_there_is_by_itself_can_be_changed_and_switched_off() {
    let file = FILE.to_owned()
        + "[alarms]\nfault = { priority = 'high', delay = '7 s' }\nstale = { except = ['tpg'] }\nsegment = { priority = 'off' }\n\
           damage = { limit = 100, off-delay = '9 s' }\nblind = { priority = 'off' }\nrecord = { priority = 'off' }\n";
    let all = rules(&file);
    assert_eq!(names(&file)[3..], ["segment hall: damage", "chamber: fault", "chamber: no data", "tpg: fault"]);
    assert_eq!(
        (rule(&all, "tpg: fault").priority, rule(&all, "tpg: fault").delay),
        (Priority::High, Duration::from_secs(7))
    );
    assert_eq!(
        rule(&all, "chamber: no data").condition,
        Condition::Stale { behind_segment: None },
        "nobody else tells it"
    );
    let damage = rule(&all, "segment hall: damage");
    assert_eq!(
        (damage.condition, damage.off_delay),
        (Condition::DamagedTelegrams { limit: 100.0 }, Duration::from_secs(9))
    );
}

#[test]
fn what_is_wrong_is_told_with_its_place() {
    let defaults = |line: &str| FILE.to_owned() + "[alarms]\n" + line + "\n";
    let altered = |from: &str, to: &str| FILE.replacen(from, to, 1);
    for (file, sentence) in [
        (altered("\"too high\"", "\"leak\""), "hall.toml:31:8: the alarm \"leak\" stands twice"),
        (altered("\"too high\"", "\"\""), "hall.toml:15:8: expected the name of an alarm, got nothing"),
        (
            altered("\"too high\"", "\"chamber: fault\""),
            "15:8: there is an alarm \"chamber: fault\" by itself; [alarms] says how it is",
        ),
        (altered("\"tpg.2\"", "\"tgp.2\""), "hall.toml:26:9: there is no gauge \"tgp.2\"; did you mean \"tpg\"?"),
        (altered("\"tpg.2\"", "\"tpg.x\""), "there is no gauge \"tpg.x\""),
        (
            altered("gauge = \"chamber\"\nabove", "gauge = \"Chambre\"\nabove"),
            "hall.toml:16:9: there is no gauge \"Chambre\"; did you mean \"chamber\"?",
        ),
        (altered("above = \"1e-3 mbar\"", "above = \"1e-3\""), "hall.toml:17:9: expected a unit out of mbar"),
        (altered("above = \"1e-3 mbar\"", "above = \"0 mbar\""), "hall.toml:17:9: expected a pressure above nothing"),
        (
            altered("above = \"1e-3 mbar\"", ""),
            "hall.toml:15:8: expected one of above, below and rise for the alarm \"too high\"",
        ),
        (altered("hysteresis = 0.5", "below = \"1 mbar\""), "expected one of above, below and rise"),
        (
            altered("hysteresis = 0.5", "hysteresis = -0.5"),
            "hall.toml:18:14: expected a hysteresis in decades from 0 to 10, got -0.5",
        ),
        (altered("hysteresis = 0.5", "hysteresis = nan"), "hall.toml:18:14: expected a hysteresis"),
        (
            altered("hysteresis = 0.5", "reset = \"2e-3 mbar\""),
            "hall.toml:18:9: an alarm cannot be over above its limit: expected not above 1e-3 mbar, got 2e-3 mbar",
        ),
        (altered("\"2 mbar\"", "\"0.5 mbar\""), "hall.toml:28:9: an alarm cannot be over below its limit"),
        (
            altered("reset = \"2 mbar\"", "reset = \"2 mbar\"\nhysteresis = 1.0"),
            "hall.toml:28:9: expected reset or hysteresis, got both",
        ),
        (altered("delay = \"2 s\"", "delay = \"2 h\""), "hall.toml:19:9: expected a time up to 1h, got 2h"),
        (
            altered("\"high\"\nmessage", "\"urgent\"\nmessage"),
            "hall.toml:21:12: expected a priority out of high, medium, low, got \"urgent\"",
        ),
        (altered("rise = 0.5", "rise = 0.0"), "hall.toml:33:8: expected decades per minute above 0 to 10, got 0"),
        (altered("\"20 s\"", "\"1 s\""), "hall.toml:34:10: expected a window from 5s to 10m, got 1s"),
        (altered("message =", "window = \"20 s\"\nmessage ="), "hall.toml:22:10: a window belongs to rise alone"),
        (altered("window =", "reset = \"1 mbar\"\nwindow ="), "hall.toml:34:9: a rise has no reset"),
        (altered("message =", "massage ="), "hall.toml:22:1: unknown field `massage`"),
        (defaults("fault = { priority = 'loud' }"), "expected a priority out of high, medium, low, off, got \"loud\""),
        (
            defaults("stale = { except = ['chambre'] }"),
            "hall.toml:36:21: there is no gauge \"chambre\"; did you mean \"chamber\"?",
        ),
        (defaults("segment = { except = ['hal'] }"), "there is no segment \"hal\"; did you mean \"hall\"?"),
        (defaults("fault = { limit = 3 }"), "hall.toml:36:19: only damage has a limit"),
        (defaults("damage = { limit = 0.5 }"), "expected from 1 to 1000000 telegrams per minute, got 0.5"),
        (defaults("stall = {}"), "unknown field `stall`"),
    ] {
        let told = parse(&file).unwrap_err().to_string();
        assert!(told.contains(sentence), "expected {sentence}\ngot {told}");
    }
}

#[test]
fn a_webhook_is_as_the_file_says_and_keeps_its_secret() {
    let folder = tempfile::tempdir().unwrap();
    let token = folder.path().join("ops.token");
    file_permissions::write(&token, "s3cret\n").unwrap();
    let file = FILE.to_owned()
        + "[[webhook]]\nurl = 'https://alarms.example.org:8443/hook/abc'\ntoken-file = 'ops.token'\npriority = 'medium'\n\
           [[webhook]]\nname = 'ours'\nurl = 'http://10.0.0.1/hook'\n";
    let path = folder.path().join("hall.toml");
    let config = Config::parse(&file, &path).unwrap();
    assert!(config.is_private());
    let [first, second] = &config.webhooks[..] else { panic!("{:?}", config.webhooks) };
    assert_eq!((first.name.as_str(), first.min_priority), ("alarms.example.org", Priority::Medium));
    assert_eq!(first.token.as_ref().unwrap().reveal(), "s3cret");
    assert_eq!(first.origin(), "https://alarms.example.org:8443");
    assert_eq!((second.name.as_str(), second.min_priority, &second.token), ("ours", Priority::Low, &None));
    let shown = format!("{config:?}");
    assert!(!shown.contains("s3cret") && !shown.contains("hook/abc"), "{shown}");
    fs::set_permissions(&token, fs::Permissions::from_mode(0o640)).unwrap();
    let told = Config::parse(&file, &path).unwrap_err().to_string();
    let wanted = format!("is open to others (mode 640): chmod 600 {}", token.display());
    assert!(told.contains("hall.toml:37:14: ") && told.ends_with(&wanted), "{told}");
}

#[test]
fn a_webhook_that_cannot_be_is_told_with_its_place() {
    for (lines, sentence) in [
        ("url = 'ftp://host/x'", "hall.toml:36:7: expected an address like https://host/path, got another scheme"),
        ("url = '/x'", "36:7: expected an address like https://host/path, got one without a host"),
        ("url = 'https://a b/'", "hall.toml:36:7: "),
        ("url = 'https://me:s3cret@host/'", "got one with a password: token and token-file are for that"),
        ("url = 'http://host/'\ntoken = 's3cret'", "got http with a token, which everybody on the way could read"),
        ("url = 'https://host/'\ntoken = 's3 cret'", "37:9: expected a token of visible ASCII without spaces"),
        ("url = 'https://host/'\ntoken = 3535", "37:9: expected a token in quotes"),
        ("url = 'https://host/'\ntoken = 's3cret'\ntoken-file = 'x'", "38:14: expected token or token-file, got both"),
        ("url = 'https://host/'\ntoken-file = 'no/such'", "37:14: no/such cannot be read: "),
        ("url = 'https://host/'\nca-file = 'no/such'", "37:11: no/such holds no certificates: "),
        ("url = 'https://host/'\npriority = 'off'", "expected a priority out of high, medium, low, got \"off\""),
        (
            "url = 'https://host/'\n[[webhook]]\nurl = 'https://host/other'",
            "38:7: the webhook \"host\" stands twice: name tells them apart",
        ),
        ("name = ' '\nurl = 'https://host/'", "36:8: expected the name of a webhook, got nothing"),
    ] {
        let told =
            Config::parse(&format!("{FILE}[[webhook]]\n{lines}\n"), Path::new("hall.toml")).unwrap_err().to_string();
        assert!(told.contains(sentence), "expected {sentence}\ngot {told}");
        assert!(!told.contains("s3") && !told.contains("3535"), "{told}");
    }
}
