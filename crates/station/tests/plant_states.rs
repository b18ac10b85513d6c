//! Plant states over HTTP: what the API shows, which role may change what, what is recorded, and what survives a restart.

#![allow(clippy::unwrap_used, clippy::panic, clippy::indexing_slicing, reason = "a test")]

use crate::support;
use crate::support::inputs::inputs;
use profivac_recorder::{Micros, Quality, Reader};
use profivac_station::alarm::{NotificationTarget, Priority};
use profivac_station::services::Services;
use profivac_web_server::auth::Role;
use serde_json::{Value, json};
use std::path::Path;
use std::sync::Arc;
use tempfile::TempDir;

const FILE: &str = r#"
[[segment]]
name = "hall"
port = "/dev/ttyUSB0"
[[segment.gauge]]
name = "chamber"
address = 5
device = "bcg450"
[[alarm]]
name = "too high"
gauge = "chamber"
above = "1e-3 mbar"
delay = "0 s"
off-delay = "0 s"
priority = "high"
[alarms]
stale = { priority = "off" }
[[plant-state]]
name = "Vented"
description = "The chamber is open."
gauges = ["chamber"]
longest = "8 h"
[[plant-state]]
name = "Bake-out"
kinds = ["fault"]
role = "engineer"
"#;

struct Fixture {
    services: Arc<Services>,
    folder: TempDir,
}

impl Fixture {
    fn new() -> Self {
        Self::at(tempfile::tempdir().unwrap(), FILE)
    }

    /// A station that starts with the database in a folder.
    fn at(folder: TempDir, file: &str) -> Self {
        let services = support::services(folder.path());
        let config = profivac_config::parse(file, Path::new("plant.toml")).unwrap();
        let target = NotificationTarget::of_every_change("ops".to_owned(), Priority::Low);
        services.alarms().start(config.alarms, vec![target]).unwrap();
        services.alarms().start_plant_states(config.plant_states).unwrap();
        Self { services, folder }
    }

    fn restarted(self, file: &str) -> Self {
        let Self { services, folder } = self;
        assert!(services.recorder().flush());
        drop(services);
        Self::at(folder, file)
    }

    fn evaluate(&self, pa: f64) {
        self.services.alarms().evaluate(&inputs(pa, Quality::Valid));
    }

    fn get(&self, path: &str) -> Value {
        let (status, json) = support::api::request(&self.services, "GET", path, String::new(), Role::Viewer);
        assert_eq!(status, 200, "{path}: {json}");
        json
    }

    fn post(&self, path: &str, body: &Value, role: Role) -> (u16, Value) {
        support::api::request(&self.services, "POST", path, body.to_string(), role)
    }

    fn declare(&self) -> Value {
        let body = json!({ "reason": " leak search ", "minutes": 60 });
        let (status, state) = self.post("/api/plant-states/Vented/declare", &body, Role::Operator);
        assert_eq!(status, 200, "{state}");
        state
    }

    fn alarm(&self, name: &str) -> Value {
        let all = self.get("/api/alarms");
        all.as_array().unwrap().iter().find(|alarm| alarm["name"] == name).unwrap().clone()
    }

    fn state(&self) -> String {
        self.alarm("too high")["state"].as_str().unwrap().to_owned()
    }

    fn reader(&self) -> Reader {
        assert!(self.services.recorder().flush());
        Reader::open(&support::database(self.folder.path())).unwrap()
    }

    /// The changes in the history, the first one first.
    fn history(&self) -> Vec<String> {
        let rows = self.reader().alarm_history(Micros(0), Micros(i64::MAX), Some("too high"), 100).unwrap();
        rows.into_iter().rev().map(|row| row.change.as_str().to_owned()).collect()
    }

    fn events(&self) -> Vec<String> {
        let events = self.reader().events(Micros(0), Micros(i64::MAX), 100).unwrap();
        events.into_iter().rev().map(|event| event.text).filter(|text| text.starts_with("plant state")).collect()
    }
}

fn problem(answer: &(u16, Value)) -> (u16, &str) {
    (answer.0, answer.1["detail"].as_str().unwrap())
}

#[test]
fn the_plant_states_of_the_file_are_listed_with_their_alarms() {
    let fixture = Fixture::new();
    let states = fixture.get("/api/plant-states");
    let vented = json!({
        "name": "Vented",
        "description": "The chamber is open.",
        "longest_minutes": 480,
        "role": "operator",
        "alarms": ["chamber: limit not measurable", "too high"],
        "declared": null,
    });
    assert_eq!(states[0], vented);
    let bake_out = (&states[1]["name"], &states[1]["role"], &states[1]["alarms"], &states[1]["longest_minutes"]);
    assert_eq!(bake_out, (&json!("Bake-out"), &json!("engineer"), &json!(["chamber: fault"]), &json!(1440)));
}

#[test]
fn a_declared_plant_state_suppresses_its_alarms_at_once_and_their_end_raises_those_that_hold() {
    let fixture = Fixture::new();
    fixture.evaluate(5.0);
    assert_eq!(fixture.state(), "unacknowledged");
    let state = fixture.declare();
    let declared = &state["declared"];
    assert_eq!((&declared["user"], &declared["reason"]), (&json!("Ada"), &json!("leak search")));
    assert_eq!(declared["until_ms"].as_i64().unwrap() - declared["at_ms"].as_i64().unwrap(), 3_600_000);
    let alarm = fixture.alarm("too high");
    assert_eq!((&alarm["state"], &alarm["shelved"]), (&json!("suppressed"), &Value::Null), "before an evaluation");
    assert_eq!(alarm["suppressed"]["reason"], "Vented: leak search");
    assert_eq!(alarm["suppressed"]["until_ms"], declared["until_ms"]);
    let now = fixture.services.alarms().overview();
    let overview = serde_json::to_value(&now.overview).unwrap();
    assert_eq!((&overview["high"]["active"], &overview["suppressed"]), (&json!(0), &json!(2)));
    assert_eq!(overview["plant_states"], json!([declared]));
    assert!(now.standing.is_empty(), "{now:?}");
    fixture.evaluate(5.0);
    assert_eq!(fixture.state(), "suppressed");
    let (status, ended) = fixture.post("/api/plant-states/Vented/end", &json!({ "reason": "closed" }), Role::Operator);
    assert_eq!((status, &ended["declared"]), (200, &Value::Null));
    fixture.evaluate(5.0);
    assert_eq!(fixture.state(), "unacknowledged");
    assert_eq!(fixture.history(), ["raised", "suppressed", "unsuppressed", "raised"]);
    assert_eq!(fixture.alarm("chamber: fault")["state"], "normal", "a fault means something in this state");
}

#[test]
fn a_refused_request_says_what_was_expected_and_changes_nothing() {
    let fixture = Fixture::new();
    let body = json!({ "reason": "leak search", "minutes": 60 });
    let viewer = fixture.post("/api/plant-states/Vented/declare", &body, Role::Viewer);
    assert_eq!(problem(&viewer), (403, "declaring a plant state needs the role operator, Ada has viewer"));
    let operator = fixture.post("/api/plant-states/Bake-out/declare", &body, Role::Operator);
    assert_eq!(
        problem(&operator),
        (403, "declaring the plant state Bake-out needs the role engineer, Ada has operator")
    );
    let unknown = fixture.post("/api/plant-states/Ventd/declare", &body, Role::Operator);
    assert_eq!(problem(&unknown), (404, "there is no plant state \"Ventd\"; expected one of: Vented, Bake-out"));
    let long =
        fixture.post("/api/plant-states/Vented/declare", &json!({ "reason": "so", "minutes": 481 }), Role::Operator);
    let expected = "expected minutes from 1 to 480, the longest time of Vented in the station's file, found 481";
    assert_eq!(problem(&long), (400, expected));
    for reason in ["", " ", "a\nb", &"x".repeat(501)] {
        let body = json!({ "reason": reason, "minutes": 60 });
        assert_eq!(fixture.post("/api/plant-states/Vented/declare", &body, Role::Operator).0, 400, "{reason:?}");
    }
    let not_declared = (409, "Vented is not declared; look at the plant states before you change one");
    assert_eq!(problem(&fixture.post("/api/plant-states/Vented/end", &json!({}), Role::Operator)), not_declared);
    assert_eq!(problem(&fixture.post("/api/plant-states/Vented/extend", &body, Role::Operator)), not_declared);
    fixture.declare();
    let again = fixture.post("/api/plant-states/Vented/declare", &body, Role::Engineer);
    assert_eq!(problem(&again), (409, "Vented is declared by Ada already; extend it, or end it first"));
    assert_eq!(fixture.post("/api/plant-states/Vented/end", &json!({}), Role::Viewer).0, 403);
    let declared = fixture.get("/api/plant-states");
    assert_eq!((&declared[0]["declared"]["reason"], &declared[1]["declared"]), (&json!("leak search"), &Value::Null));
    assert!(fixture.services.recorder().flush());
    let rows = fixture.get("/api/audit");
    let actions: Vec<_> = rows.as_array().unwrap().iter().rev().map(|row| row["action"].clone()).collect();
    let expected = ["refused", "refused", "plant-state-declared", "refused"].map(|action| json!(action));
    assert_eq!(actions, expected, "two declarations and an end for a missing role: {rows}");
}

#[test]
fn declaring_extending_and_ending_are_in_the_audit_trail_and_in_the_events() {
    let fixture = Fixture::new();
    fixture.declare();
    let body = json!({ "reason": "still open", "minutes": 120 });
    let (status, state) = fixture.post("/api/plant-states/Vented/extend", &body, Role::Engineer);
    assert_eq!((status, &state["declared"]["reason"]), (200, &json!("still open")));
    assert_eq!(fixture.post("/api/plant-states/Vented/end", &json!({}), Role::Operator).0, 200);
    // The answer comes after the write: no flush is needed.
    let rows = fixture.get("/api/audit");
    let rows: Vec<_> = rows.as_array().unwrap().iter().rev().collect();
    let actions: Vec<_> = rows.iter().map(|row| row["action"].as_str().unwrap()).collect();
    assert_eq!(actions, ["plant-state-declared", "plant-state-extended", "plant-state-ended"]);
    let outcomes: Vec<_> = rows.iter().map(|row| row["outcome"].clone()).collect();
    assert_eq!(outcomes, [json!("leak search"), json!("still open"), Value::Null]);
    assert!(rows.iter().all(|row| row["target"] == "Vented" && row["user"] == "Ada" && row["peer"] == "10.0.0.7"));
    assert_eq!((&rows[0]["before"], &rows[2]["after"]), (&json!("not declared"), &json!("not declared")));
    assert_eq!(rows[0]["after"], rows[1]["before"]);
    assert!(rows[0]["after"].as_str().unwrap().starts_with("declared until 20"), "{}", rows[0]);
    let events = fixture.events();
    assert!(events[0].starts_with("plant state \"Vented\" declared by Ada until 20"), "{events:?}");
    assert!(events[0].ends_with("Z, suppresses 2 alarms: leak search"), "{events:?}");
    assert!(events[1].starts_with("plant state \"Vented\" extended by Ada until 20"), "{events:?}");
    assert_eq!(events[2], "plant state \"Vented\" ended by Ada");
}

#[test]
fn a_declaration_survives_a_restart_with_its_alarms() {
    let fixture = Fixture::new();
    fixture.evaluate(5.0);
    let declared = fixture.declare()["declared"].clone();
    let restarted = fixture.restarted(FILE);
    assert_eq!(restarted.get("/api/plant-states")[0]["declared"], declared);
    restarted.evaluate(5.0);
    assert_eq!(restarted.state(), "suppressed");
    assert_eq!(restarted.history(), ["raised", "suppressed"], "a restart changes nothing");
    assert_eq!(restarted.post("/api/plant-states/Vented/end", &json!({}), Role::Operator).0, 200);
    let restarted = restarted.restarted(FILE);
    assert_eq!(restarted.get("/api/plant-states")[0]["declared"], Value::Null, "an ended one stays ended");
    restarted.evaluate(5.0);
    assert_eq!(restarted.state(), "unacknowledged");
}

#[test]
fn a_declaration_of_a_plant_state_that_the_file_no_longer_has_ends_at_the_start() {
    let fixture = Fixture::new();
    fixture.declare();
    let without = FILE.split("[[plant-state]]").next().unwrap();
    let restarted = fixture.restarted(without);
    restarted.evaluate(5.0);
    assert_eq!(restarted.state(), "unacknowledged");
    assert_eq!(restarted.reader().plant_states().unwrap(), []);
    assert_eq!(restarted.events().last().unwrap(), "plant state \"Vented\" ended: the station's file no longer has it");
    assert_eq!(restarted.get("/api/plant-states"), json!([]));
}

#[test]
fn suppressed_alarms_send_no_notification_and_count_apart() {
    let fixture = Fixture::new();
    fixture.declare();
    fixture.evaluate(5.0);
    fixture.evaluate(0.01);
    fixture.evaluate(5.0);
    assert_eq!(fixture.reader().queued_notifications("ops").unwrap(), []);
    let now = Micros::now().0 / 1000;
    let path = format!("/api/alarms/performance?from={}&to={}", now - 3_600_000, now + 60_000);
    let figures = fixture.get(&path);
    assert_eq!((&figures["raised"], &figures["suppressed"]), (&json!(0), &json!(2)));
    assert_eq!((&figures["chattering"], &figures["long_active"]), (&json!([]), &json!([])));
    assert_eq!(fixture.post("/api/plant-states/Vented/end", &json!({}), Role::Operator).0, 200);
    fixture.evaluate(5.0);
    assert_eq!(fixture.reader().queued_notifications("ops").unwrap().len(), 1, "the raised alarm");
    let figures = fixture.get(&path);
    assert_eq!((&figures["raised"], &figures["suppressed"]), (&json!(1), &json!(2)));
}

#[test]
fn a_shelved_alarm_stays_shelved_and_an_operator_shelves_a_suppressed_one() {
    let fixture = Fixture::new();
    let body = json!({ "alarms": ["too high"], "reason": "so", "minutes": 30 });
    assert_eq!(fixture.post("/api/alarms/shelve", &body, Role::Operator).0, 200);
    fixture.declare();
    fixture.evaluate(5.0);
    assert_eq!(fixture.state(), "shelved");
    let unshelve = json!({ "alarms": ["too high"] });
    assert_eq!(fixture.post("/api/alarms/unshelve", &unshelve, Role::Operator).0, 200);
    fixture.evaluate(5.0);
    assert_eq!(fixture.state(), "suppressed");
    assert_eq!(fixture.post("/api/alarms/shelve", &body, Role::Operator).1["changed"], json!(["too high"]));
    assert_eq!(fixture.get(&format!("/api/alarms/history?from=0&to={}", i64::MAX))[0]["change"], "shelved");
}
