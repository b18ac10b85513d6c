//! Settings of alarms that an engineer changes over HTTP: in the file, in the running alarm, in the audit trail.

#![allow(clippy::unwrap_used, clippy::panic, clippy::indexing_slicing, reason = "a test")]

use crate::support;
use crate::support::inputs::{inputs, snapshot};
use profivac_recorder::Quality;
use profivac_station::services::Services;
use profivac_web_server::auth::Role;
use serde_json::{Value, json};
use std::fs;
use std::os::unix::fs::PermissionsExt;
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

[[alarm]]
name = "too high"
gauge = "chamber"
above = "1e-3 mbar"  # from the process
hysteresis = 0
delay = "0 s"
off-delay = "0 s"
priority = "high"

[alarms]
stale = { priority = "off" }
"#;

struct Fixture {
    services: Arc<Services>,
    folder: TempDir,
}

impl Fixture {
    fn new() -> Self {
        let folder = tempfile::tempdir().unwrap();
        let services = support::services(folder.path());
        let fixture = Self { services, folder };
        fs::write(fixture.file(), FILE).unwrap();
        fs::set_permissions(fixture.file(), fs::Permissions::from_mode(0o640)).unwrap();
        let config = profivac_config::read(&fixture.file()).unwrap();
        fixture.services.alarm_editor().set_source(config.source);
        fixture.services.alarms().start(config.alarms, Vec::new()).unwrap();
        fixture.services.snapshots().publish(snapshot(1.0, Quality::Valid));
        fixture
    }

    fn file(&self) -> PathBuf {
        self.folder.path().join("plant.toml")
    }

    fn text(&self) -> String {
        fs::read_to_string(self.file()).unwrap()
    }

    /// Evaluates the alarms while the gauge shows this pressure.
    fn evaluate(&self, pa: f64) {
        self.services.alarms().evaluate(&inputs(pa, Quality::Valid));
    }

    fn ask(&self, method: &str, path: &str, body: &Value, role: Role) -> (u16, Value) {
        support::api::request(&self.services, method, path, body.to_string(), role)
    }

    fn get(&self, path: &str) -> Value {
        let (status, json) = self.ask("GET", path, &Value::Null, Role::Engineer);
        assert_eq!(status, 200, "{path}: {json}");
        json
    }

    fn settings(&self) -> Value {
        self.get("/api/alarms/too%20high/settings")
    }

    fn change(&self, seen: &Value, changes: &Value, role: Role) -> (u16, Value) {
        let mut new = seen.clone();
        new.as_object_mut().unwrap().extend(changes.as_object().unwrap().clone());
        let body = json!({ "seen": seen, "new": new, "reason": "the process changed" });
        self.ask("POST", "/api/alarms/too%20high/settings", &body, role)
    }

    /// Status and sentence of a refused change, after which file and alarm are as before.
    fn refused(&self, seen: &Value, changes: &Value) -> (u16, String) {
        let (text, alarms) = (self.text(), self.get("/api/alarms"));
        let (status, answer) = self.change(seen, changes, Role::Engineer);
        assert_eq!((self.text(), self.get("/api/alarms")), (text, alarms), "{answer}");
        assert_eq!(self.audit(), json!([]));
        (status, answer["detail"].as_str().unwrap().to_owned())
    }

    /// The rows of the audit trail, without refusals for a missing role.
    fn audit(&self) -> Value {
        assert!(self.services.recorder().flush());
        let rows = self.get("/api/audit?limit=10");
        rows.as_array().unwrap().iter().filter(|row| row["action"] != "refused").cloned().collect()
    }

    fn alarm(&self) -> Value {
        self.get("/api/alarms")[0].clone()
    }
}

#[test]
fn a_new_limit_is_in_the_file_in_the_running_alarm_and_in_the_audit_trail() {
    let fixture = Fixture::new();
    fixture.evaluate(0.05);
    assert_eq!(fixture.alarm()["state"], "normal");
    let changes = json!({ "above": "4e-4 mbar", "delay": null, "off_delay": "2 s" });
    let (status, answer) = fixture.change(&fixture.settings(), &changes, Role::Engineer);
    assert_eq!((status, &answer["limit"]), (200, &json!(0.04)), "{answer}");
    let expected = FILE
        .replace("above = \"1e-3 mbar\"", "above = \"4e-4 mbar\"")
        .replace("\ndelay = \"0 s\"", "")
        .replace("off-delay = \"0 s\"", "off-delay = \"2 s\"");
    assert_eq!(fixture.text(), expected, "comments and order stay");
    assert_eq!(fs::metadata(fixture.file()).unwrap().permissions().mode() & 0o777, 0o640);
    assert_eq!(profivac_config::read(&fixture.file()).unwrap().alarms[0].condition.limit(), Some(0.04));
    let audit = fixture.audit();
    let row = &audit[0];
    assert_eq!(
        (&row["action"], &row["user"], &row["target"]),
        (&json!("alarm-settings"), &json!("Ada"), &json!("too high"))
    );
    assert!(row["before"].as_str().unwrap().starts_with("above = \"1e-3 mbar\", hysteresis = 0.0, delay = \"0 s\""));
    assert!(row["after"].as_str().unwrap().starts_with("above = \"4e-4 mbar\", hysteresis = 0.0, off-delay = \"2 s\""));
    assert_eq!(row["outcome"], "the process changed");
    let history = fixture.get(&format!("/api/alarms/history?from=0&to={}", i64::MAX));
    assert_eq!((&history[0]["change"], &history[0]["user"]), (&json!("settings-changed"), &json!("Ada")));
    // A second change starts from the first.
    let (status, answer) = fixture.change(&fixture.settings(), &json!({ "delay": "0 s" }), Role::Engineer);
    assert_eq!(status, 200, "{answer}");
    fixture.evaluate(0.05);
    assert_eq!(fixture.alarm()["state"], "unacknowledged", "the new limit applies");
}

#[test]
fn an_acknowledged_alarm_stays_acknowledged_until_its_condition_ends() {
    let fixture = Fixture::new();
    fixture.evaluate(0.5);
    let seen = json!({ "occurrence": fixture.alarm()["occurrence"] });
    fixture.ask("POST", "/api/alarms/too%20high/acknowledge", &seen, Role::Operator);
    let (status, answer) = fixture.change(&fixture.settings(), &json!({ "above": "2e-3 mbar" }), Role::Engineer);
    assert_eq!((status, &answer["state"]), (200, &json!("acknowledged")), "{answer}");
    fixture.evaluate(0.5);
    let alarm = fixture.alarm();
    assert_eq!((&alarm["state"], &alarm["acknowledged_by"]), (&json!("acknowledged"), &json!("Ada")));
    fixture.change(&fixture.settings(), &json!({ "above": "1e-2 mbar" }), Role::Engineer);
    fixture.evaluate(0.5);
    assert_eq!(fixture.alarm()["state"], "normal", "an acknowledged alarm whose condition ends is normal");
    fixture.change(&fixture.settings(), &json!({ "above": "1e-3 mbar" }), Role::Engineer);
    fixture.evaluate(0.5);
    let again = fixture.alarm();
    assert_eq!(again["state"], "unacknowledged", "the next occurrence needs an acknowledgement of its own");
    assert!(again["occurrence"].as_i64() > alarm["occurrence"].as_i64());
}

#[test]
fn an_alarm_that_waits_for_its_acknowledgement_waits_on_after_a_change() {
    let fixture = Fixture::new();
    fixture.evaluate(0.5);
    fixture.change(&fixture.settings(), &json!({ "above": "1e-2 mbar" }), Role::Engineer);
    fixture.evaluate(0.5);
    assert_eq!(fixture.alarm()["state"], "returned");
}

#[test]
fn a_wrong_value_is_refused_with_the_sentence_of_a_start() {
    let fixture = Fixture::new();
    let seen = fixture.settings();
    for (changes, sentence) in [
        (json!({ "above": "1e9 mbar" }), "bcg450"),
        (json!({ "above": "-1 mbar" }), "-1"),
        (json!({ "above": "1e-3 bananas" }), "bananas"),
        (json!({ "delay": "2 h" }), "2h"),
        (json!({ "hysteresis": 99 }), "hysteresis"),
        (json!({ "reset": "1e-4 mbar" }), "reset"),
        (json!({ "priority": "urgent" }), "urgent"),
        (json!({ "above": null, "below": "1e-3 mbar" }), "expected a value for above alone"),
    ] {
        let (status, detail) = fixture.refused(&seen, &changes);
        assert_eq!(status, 400, "{detail}");
        assert!(detail.contains(sentence), "{changes}: {detail}");
    }
}

#[test]
fn only_an_engineer_changes_settings() {
    let fixture = Fixture::new();
    for role in [Role::Viewer, Role::Operator] {
        let (status, answer) = fixture.change(&fixture.settings(), &json!({ "above": "2e-3 mbar" }), role);
        assert_eq!(status, 403, "{answer}");
    }
    assert_eq!(fixture.text(), FILE);
}

#[test]
fn a_file_that_was_changed_meanwhile_stays() {
    let fixture = Fixture::new();
    let seen = fixture.settings();
    fs::write(fixture.file(), FILE.replace("1e-3 mbar", "5e-3 mbar")).unwrap();
    let (status, detail) = fixture.refused(&seen, &json!({ "above": "2e-3 mbar" }));
    assert_eq!(status, 409);
    assert!(detail.contains("was changed since the station has read it"), "{detail}");
    fs::write(fixture.file(), FILE).unwrap();
    let (status, _) = fixture.change(&seen, &json!({ "above": "2e-3 mbar" }), Role::Engineer);
    assert_eq!(status, 200);
    // A second engineer has not seen the change of the first.
    let (status, answer) = fixture.change(&seen, &json!({ "above": "3e-3 mbar" }), Role::Engineer);
    assert_eq!(status, 409, "{answer}");
    assert!(answer["detail"].as_str().unwrap().starts_with("the settings are now above = \"2e-3 mbar\""), "{answer}");
}

#[test]
fn a_read_only_file_is_not_replaced() {
    let fixture = Fixture::new();
    fs::set_permissions(fixture.file(), fs::Permissions::from_mode(0o440)).unwrap();
    let (status, detail) = fixture.refused(&fixture.settings(), &json!({ "above": "2e-3 mbar" }));
    assert_eq!(status, 503);
    assert!(detail.contains("plant.toml cannot be changed: the file is read-only; nothing was changed"), "{detail}");
}

#[test]
fn a_link_to_the_file_stays_a_link() {
    let fixture = Fixture::new();
    let real = fixture.folder.path().join("real.toml");
    fs::rename(fixture.file(), &real).unwrap();
    std::os::unix::fs::symlink(&real, fixture.file()).unwrap();
    let (status, answer) = fixture.change(&fixture.settings(), &json!({ "above": "2e-3 mbar" }), Role::Engineer);
    assert_eq!(status, 200, "{answer}");
    assert!(fs::symlink_metadata(fixture.file()).unwrap().is_symlink());
    assert!(fs::read_to_string(real).unwrap().contains("2e-3 mbar"));
}

#[test]
fn a_default_alarm_an_unknown_alarm_and_a_station_without_a_file_have_no_settings() {
    let fixture = Fixture::new();
    let problem = |path: &str| {
        let (status, answer) = fixture.ask("GET", path, &Value::Null, Role::Engineer);
        (status, answer["detail"].as_str().unwrap().to_owned())
    };
    let (status, detail) = problem("/api/alarms/chamber:%20fault/settings");
    assert!(status == 409 && detail.contains("a default alarm has its settings in [alarms]"), "{detail}");
    assert_eq!(problem("/api/alarms/none/settings").0, 404);
    fs::remove_file(fixture.file()).unwrap();
    let (status, detail) = problem("/api/alarms/too%20high/settings");
    assert!(status == 409 && detail.starts_with("this station has no file"), "{detail}");
}
