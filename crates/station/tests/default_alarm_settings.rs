//! Settings of default alarms that an engineer changes over HTTP: in the file, in the running alarms, in the audit trail.

#![allow(clippy::unwrap_used, clippy::panic, clippy::indexing_slicing, reason = "a test")]

use crate::support;
use crate::support::inputs::{inputs, silent};
use profivac_recorder::Quality;
use profivac_station::known_file::{changes_while_stopped, remember};
use profivac_station::services::Services;
use profivac_web_server::auth::Role;
use serde_json::{Value, json};
use std::fs;
use std::path::PathBuf;
use std::sync::Arc;
use tempfile::TempDir;

const FILE: &str = r#"# The hall, as it was built.
[[segment]]
name = "hall"
port = "/dev/ttyUSB0"
[[segment.gauge]]
name = "chamber"   # on top
address = 5
device = "bcg450"

[[plant-state]]
name = "Vented"
kinds = ["fault"]

[alarms]
# Longer than a restart.
stale = { delay = "0 s", except = [] } # of each gauge

[station]
name = "hall"
"#;

struct Fixture {
    services: Arc<Services>,
    folder: TempDir,
}

impl Fixture {
    fn new(file: &str) -> Self {
        let folder = tempfile::tempdir().unwrap();
        let services = support::services(folder.path());
        let fixture = Self { services, folder };
        fs::write(fixture.file(), file).unwrap();
        let config = profivac_config::read(&fixture.file()).unwrap();
        fixture.services.alarm_editor().set_source(config.source);
        fixture.services.alarms().start(config.alarms, Vec::new()).unwrap();
        fixture.services.alarms().start_plant_states(config.plant_states).unwrap();
        fixture
    }

    fn file(&self) -> PathBuf {
        self.folder.path().join("plant.toml")
    }

    fn text(&self) -> String {
        fs::read_to_string(self.file()).unwrap()
    }

    fn ask(&self, method: &str, path: &str, body: &Value, role: Role) -> (u16, Value) {
        support::api::request(&self.services, method, path, body.to_string(), role)
    }

    fn get(&self, path: &str) -> Value {
        let (status, json) = self.ask("GET", path, &Value::Null, Role::Viewer);
        assert_eq!(status, 200, "{path}: {json}");
        json
    }

    fn default_alarm(&self, name: &str) -> Value {
        let all = self.get("/api/default-alarms");
        all.as_array().unwrap().iter().find(|alarm| alarm["name"] == name).unwrap().clone()
    }

    fn change(&self, name: &str, changes: &Value, role: Role) -> (u16, Value) {
        let seen = self.default_alarm(name)["settings"].clone();
        self.change_seen(name, &seen, changes, role)
    }

    fn change_seen(&self, name: &str, seen: &Value, changes: &Value, role: Role) -> (u16, Value) {
        let mut new = seen.clone();
        new.as_object_mut().unwrap().extend(changes.as_object().unwrap().clone());
        let body = json!({ "seen": seen, "new": new, "reason": "a restart takes longer" });
        self.ask("POST", &format!("/api/default-alarms/{name}/settings"), &body, role)
    }

    fn alarms(&self) -> Vec<(String, String)> {
        let all = self.get("/api/alarms");
        let text = |alarm: &Value, key: &str| alarm[key].as_str().unwrap().to_owned();
        all.as_array().unwrap().iter().map(|alarm| (text(alarm, "name"), text(alarm, "state"))).collect()
    }
}

#[test]
fn a_default_alarm_is_changed_in_the_file_in_the_running_alarms_and_in_the_audit_trail() {
    let fixture = Fixture::new(FILE);
    let stale = fixture.default_alarm("stale");
    assert_eq!((&stale["settings"]["delay"], &stale["settings"]["priority"]), (&json!("0 s"), &Value::Null));
    assert_eq!((&stale["defaults"]["delay"], &stale["defaults"]["priority"]), (&json!("15 s"), &json!("medium")));
    fixture.services.alarms().evaluate(&silent());
    let of_chamber = ("chamber: no data".to_owned(), "unacknowledged".to_owned());
    assert!(fixture.alarms().contains(&of_chamber));
    let changes = json!({ "delay": "30 s", "priority": "high", "except": null });
    let (status, answer) = fixture.change("stale", &changes, Role::Engineer);
    assert_eq!((status, &answer["delay"]), (200, &json!("30 s")), "{answer}");
    let text = fixture.text();
    assert!(text.contains("# Longer than a restart.\nstale = {"), "{text}");
    assert!(text.contains("} # of each gauge\n") && !text.contains("except"), "{text}");
    assert_eq!(text.lines().filter(|line| !line.starts_with("stale")).count(), FILE.lines().count() - 1);
    let config = profivac_config::read(&fixture.file()).unwrap();
    let rule = config.alarms.iter().find(|rule| rule.name == "chamber: no data").unwrap();
    assert_eq!((rule.delay.as_secs(), rule.priority.word()), (30, "high"));
    assert!(fixture.alarms().contains(&of_chamber), "the state stays");
    let row = fixture.get("/api/audit?limit=10")[0].clone();
    assert_eq!((&row["action"], &row["target"]), (&json!("alarm-settings"), &json!("[alarms] stale")));
    assert_eq!(
        (&row["before"], &row["outcome"]),
        (&json!("delay = \"0 s\", except = []"), &json!("a restart takes longer"))
    );
    assert_eq!(row["after"], "priority = \"high\", delay = \"30 s\"");
}

#[test]
fn a_default_alarm_without_settings_gets_them_and_one_that_is_off_is_gone() {
    for file in [FILE, FILE.split("[alarms]").next().unwrap()] {
        let fixture = Fixture::new(file);
        assert_eq!(fixture.change("damage", &json!({ "limit": 100.0 }), Role::Engineer).0, 200);
        let config = profivac_config::read(&fixture.file()).unwrap();
        let damage = config.alarms.iter().find(|rule| rule.name == "segment hall: damage").unwrap();
        assert_eq!(damage.condition.limit(), Some(100.0), "{}", fixture.text());
        assert_eq!(fixture.change("stale", &json!({ "priority": "off" }), Role::Engineer).0, 200);
        assert!(fixture.alarms().iter().all(|(name, _)| name != "chamber: no data"));
        fixture.services.alarms().evaluate(&inputs(1.0, Quality::Valid));
    }
}

#[test]
fn settings_that_the_dashboard_has_changed_are_no_change_of_the_file_at_the_next_start() {
    let fixture = Fixture::new(FILE);
    let changed = || {
        assert!(fixture.services.recorder().flush());
        let source = profivac_config::read(&fixture.file()).unwrap().source;
        changes_while_stopped(fixture.services.recorder(), &source).len()
    };
    remember(fixture.services.recorder(), &profivac_config::read(&fixture.file()).unwrap().source);
    assert_eq!(fixture.change("stale", &json!({ "delay": "30 s" }), Role::Engineer).0, 200);
    assert_eq!(changed(), 0);
    fs::write(fixture.file(), fixture.text().replace("30 s", "40 s")).unwrap();
    assert_eq!(changed(), 1);
}

#[test]
fn a_key_with_its_former_name_keeps_it() {
    let fixture = Fixture::new(&FILE.replace("[alarms]\n", "[alarms]\nrecord = { delay = '20 s' }\n"));
    assert_eq!(fixture.default_alarm("database")["settings"]["delay"], "20 s");
    assert_eq!(fixture.change("database", &json!({ "delay": "40 s" }), Role::Engineer).0, 200);
    assert!(fixture.text().contains("record = { delay = \"40 s\" }"), "{}", fixture.text());
}

#[test]
fn a_refused_change_leaves_file_and_alarms_as_they_were() {
    let fixture = Fixture::new(FILE);
    let seen = fixture.default_alarm("stale")["settings"].clone();
    let (before, alarms) = (fixture.text(), fixture.alarms());
    for (name, seen, changes, role, status, sentence) in [
        ("stale", &seen, json!({ "delay": "1 s" }), Role::Operator, 403, "needs the role engineer"),
        (
            "stales",
            &seen,
            json!({}),
            Role::Engineer,
            404,
            "there is no default alarm \"stales\"; expected one of: fault, ",
        ),
        ("stale", &seen, json!({ "delay": "2 h" }), Role::Engineer, 400, "expected a delay of at most 1h, found 2h"),
        ("stale", &seen, json!({ "limit": 3.0 }), Role::Engineer, 400, "only damage has a limit"),
        ("stale", &seen, json!({ "except": ["lock"] }), Role::Engineer, 400, "there is no gauge \"lock\""),
        ("stale", &json!({}), json!({ "delay": "1 s" }), Role::Engineer, 409, "the settings are now delay = \"0 s\""),
        (
            "fault",
            &json!({}),
            json!({ "priority": "off" }),
            Role::Engineer,
            400,
            "kinds: the plant state \"Vented\" has no ",
        ),
    ] {
        let (found, answer) = fixture.change_seen(name, seen, &changes, role);
        assert_eq!(found, status, "{changes}: {answer}");
        assert!(answer["detail"].as_str().unwrap().contains(sentence), "{changes}: {answer}");
        assert_eq!((fixture.text(), fixture.alarms()), (before.clone(), alarms.clone()));
    }
    assert!(fixture.services.recorder().flush());
    let rows = fixture.get("/api/audit");
    let actions: Vec<_> = rows.as_array().unwrap().iter().map(|row| row["action"].clone()).collect();
    assert_eq!(actions, [json!("refused")], "only the refusal for a missing role: {rows}");
}
