//! Alarms over HTTP: what the API shows, which role may change what, and which requests are refused.

#![allow(clippy::unwrap_used, clippy::panic, clippy::indexing_slicing, reason = "a test")]

use crate::support;
use crate::support::inputs::{inputs, snapshot};
use profivac_recorder::{Micros, Quality};
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
message = "close the valve"
[[alarm]]
name = "history"
gauge = "chamber"
above = "1e-2 mbar"
delay = "0 s"
off-delay = "0 s"
[alarms]
stale = { priority = "off" }
"#;

struct Fixture {
    services: Arc<Services>,
    _folder: TempDir,
}

impl Fixture {
    fn new() -> Self {
        let folder = tempfile::tempdir().unwrap();
        let services = support::services(folder.path());
        let rules = profivac_config::parse(FILE, Path::new("plant.toml")).unwrap().alarms;
        services.alarms().start(rules, Vec::new()).unwrap();
        services.snapshots().publish(snapshot(1.0, Quality::Valid));
        Self { services, _folder: folder }
    }

    /// Evaluates the alarms while the gauge shows this pressure.
    fn evaluate(&self, pa: f64) {
        self.services.alarms().evaluate(&inputs(pa, Quality::Valid));
    }

    fn ask(&self, method: &str, path: &str, body: &str, role: Role) -> (u16, Value) {
        support::api::request(&self.services, method, path, body.to_owned(), role)
    }

    fn get(&self, path: &str) -> Value {
        let (status, json) = self.ask("GET", path, "", Role::Viewer);
        assert_eq!(status, 200, "{path}: {json}");
        json
    }

    fn post(&self, path: &str, body: &Value, role: Role) -> (u16, Value) {
        self.ask("POST", path, &body.to_string(), role)
    }

    fn alarm(&self, name: &str) -> Value {
        let all = self.get("/api/alarms");
        all.as_array().unwrap().iter().find(|alarm| alarm["name"] == name).unwrap().clone()
    }
}

fn problem(answer: &(u16, Value)) -> (u16, &str) {
    (answer.0, answer.1["detail"].as_str().unwrap())
}

#[test]
fn an_alarm_is_raised_acknowledged_and_returns() {
    let fixture = Fixture::new();
    assert_eq!(fixture.alarm("too high")["state"], "normal");
    fixture.evaluate(0.5);
    let alarm = fixture.alarm("too high");
    for (key, value) in [
        ("state", json!("unacknowledged")),
        ("priority", json!("high")),
        ("condition", json!("above")),
        ("gauge", json!("chamber")),
        ("limit", json!(0.1)),
        ("unit", json!("Pa")),
        ("raised_value", json!(0.5)),
        ("message", json!("close the valve")),
        ("acknowledged_by", Value::Null),
    ] {
        assert_eq!(alarm[key], value, "{key}");
    }
    let seen = json!({ "occurrence": alarm["occurrence"] });
    let (status, acknowledged) = fixture.post("/api/alarms/too%20high/acknowledge", &seen, Role::Operator);
    assert_eq!(
        (status, &acknowledged["state"], &acknowledged["acknowledged_by"]),
        (200, &json!("acknowledged"), &json!("Ada"))
    );
    fixture.evaluate(0.01);
    assert_eq!(fixture.alarm("too high")["state"], "normal");
    assert!(fixture.services.recorder().flush());
    let history = fixture.get(&format!("/api/alarms/history?from=0&to={}", i64::MAX));
    let told: Vec<_> =
        history.as_array().unwrap().iter().map(|line| (line["change"].as_str().unwrap(), &line["user"])).collect();
    assert_eq!(told, [("returned", &Value::Null), ("acknowledged", &json!("Ada")), ("raised", &Value::Null)]);
    assert_eq!(
        (&history[2]["value"], &history[2]["unit"], &history[2]["subject"]),
        (&json!(0.5), &json!("Pa"), &json!("chamber"))
    );
    let events = fixture.get(&format!("/api/events?from=0&to={}", i64::MAX));
    let cleared = events[0]["text"].as_str().unwrap();
    assert!(cleared.starts_with("alarm \"too high\" (high) cleared: "), "{cleared}");
    assert_eq!(events[1]["text"], "alarm \"too high\" (high) acknowledged by Ada");
    assert_eq!(fixture.get(&format!("/api/alarms/history?from=0&to={}&alarm=other", i64::MAX)), json!([]));
}

#[test]
fn a_user_without_the_role_is_refused_and_nothing_changes() {
    let fixture = Fixture::new();
    fixture.evaluate(0.5);
    let seen = json!({ "occurrence": fixture.alarm("too high")["occurrence"] });
    let leave = json!({ "reason": "calibration" });
    for (path, body, role, sentence) in [
        (
            "too%20high/acknowledge",
            &seen,
            Role::Viewer,
            "acknowledging an alarm needs the role operator, Ada has viewer",
        ),
        (
            "too%20high/out-of-service",
            &leave,
            Role::Operator,
            "taking an alarm out of service needs the role engineer, Ada has operator",
        ),
        (
            "too%20high/return-to-service",
            &leave,
            Role::Operator,
            "returning an alarm to service needs the role engineer, Ada has operator",
        ),
    ] {
        assert_eq!(problem(&fixture.post(&format!("/api/alarms/{path}"), body, role)), (403, sentence));
    }
    let all = json!({ "alarms": [{ "name": "too high", "occurrence": seen["occurrence"] }] });
    assert_eq!(fixture.post("/api/alarms/acknowledge", &all, Role::Viewer).0, 403);
    assert_eq!(fixture.alarm("too high")["state"], "unacknowledged");
}

#[test]
fn an_acknowledgement_of_an_earlier_occurrence_is_refused() {
    let fixture = Fixture::new();
    fixture.evaluate(0.5);
    let seen = json!({ "occurrence": fixture.alarm("too high")["occurrence"] });
    fixture.evaluate(0.01);
    fixture.evaluate(0.5);
    let (status, sentence) = fixture.post("/api/alarms/too%20high/acknowledge", &seen, Role::Operator);
    assert_eq!(status, 409);
    assert!(sentence["detail"].as_str().unwrap().starts_with("too high has another occurrence"), "{sentence}");
    let unknown = fixture.post("/api/alarms/unknown/acknowledge", &seen, Role::Operator);
    assert_eq!(problem(&unknown), (404, "there is no alarm \"unknown\""));
    let now = json!({ "occurrence": fixture.alarm("too high")["occurrence"] });
    assert_eq!(fixture.post("/api/alarms/too%20high/acknowledge", &now, Role::Engineer).0, 200);
    let again = fixture.post("/api/alarms/too%20high/acknowledge", &now, Role::Operator);
    assert_eq!(problem(&again), (409, "too high is acknowledged by Ada already"));
}

#[test]
fn several_occurrences_are_acknowledged_together_and_no_others() {
    let fixture = Fixture::new();
    fixture.evaluate(5.0);
    let occurrence = |name| fixture.alarm(name)["occurrence"].as_i64().unwrap();
    let seen = json!({ "alarms": [
        { "name": "too high", "occurrence": occurrence("too high") },
        { "name": "history", "occurrence": occurrence("history") - 1 },
        { "name": "unknown", "occurrence": 1 },
    ] });
    let (status, told) = fixture.post("/api/alarms/acknowledge", &seen, Role::Operator);
    assert_eq!((status, &told["acknowledged"]), (200, &json!(["too high"])));
    assert_eq!((&told["refused"][0]["name"], &told["refused"][1]["name"]), (&json!("history"), &json!("unknown")));
    assert_eq!(fixture.alarm("history")["state"], "unacknowledged");
    // A name that is also a path.
    let seen = json!({ "occurrence": occurrence("history") });
    assert_eq!(fixture.post("/api/alarms/history/acknowledge", &seen, Role::Operator).0, 200);
}

#[test]
fn an_operator_shelves_several_alarms_and_unshelves_them() {
    let fixture = Fixture::new();
    fixture.evaluate(5.0);
    let both = json!({ "alarms": ["too high", "unknown", "history"], "reason": " venting ", "minutes": 30 });
    let (status, told) = fixture.post("/api/alarms/shelve", &both, Role::Operator);
    assert_eq!((status, &told["changed"]), (200, &json!(["too high", "history"])));
    assert_eq!(told["refused"], json!([{ "name": "unknown", "problem": "there is no alarm \"unknown\"" }]));
    let shelved = fixture.alarm("too high");
    assert_eq!((&shelved["state"], &shelved["out_of_service"]), (&json!("shelved"), &Value::Null));
    let why = &shelved["shelved"];
    assert_eq!((&why["user"], &why["reason"]), (&json!("Ada"), &json!("venting")));
    assert_eq!(why["until_ms"].as_i64().unwrap() - why["at_ms"].as_i64().unwrap(), 1_800_000);
    fixture.evaluate(5.0);
    assert_eq!(fixture.alarm("history")["state"], "shelved");
    let (status, told) = fixture.post("/api/alarms/unshelve", &json!({ "alarms": ["too high"] }), Role::Operator);
    assert_eq!((status, &told["changed"]), (200, &json!(["too high"])));
    fixture.evaluate(5.0);
    assert_eq!(
        (fixture.alarm("too high")["state"].as_str(), fixture.alarm("history")["state"].as_str()),
        (Some("unacknowledged"), Some("shelved"))
    );
    let rows = fixture.get("/api/audit");
    let rows: Vec<_> =
        rows.as_array().unwrap().iter().map(|row| (row["action"].clone(), row["target"].clone())).collect();
    let expected = [("unshelved", "too high"), ("shelved", "history"), ("shelved", "too high")];
    assert_eq!(rows, expected.map(|(action, alarm)| (json!(action), json!(alarm))));
}

#[test]
fn alarms_are_shelved_by_an_operator_for_at_most_a_shift() {
    let fixture = Fixture::new();
    let body = |minutes: u32| json!({ "alarms": ["too high"], "reason": "so", "minutes": minutes });
    assert_eq!(fixture.post("/api/alarms/shelve", &body(5), Role::Viewer).0, 403);
    assert_eq!(fixture.post("/api/alarms/unshelve", &json!({ "alarms": ["too high"] }), Role::Viewer).0, 403);
    let refused = fixture.post("/api/alarms/shelve", &body(721), Role::Engineer);
    assert_eq!(problem(&refused), (400, "expected minutes from 1 to 720, found 721"));
    assert_eq!(fixture.post("/api/alarms/shelve", &body(0), Role::Operator).0, 400);
    for wrong in
        [json!({ "alarms": ["too high"], "reason": "so" }), json!({ "alarms": [], "reason": "so", "minutes": 5 })]
    {
        assert_eq!(fixture.post("/api/alarms/shelve", &wrong, Role::Operator).0, 400, "{wrong}");
    }
    let empty = json!({ "alarms": ["too high"], "reason": " ", "minutes": 5 });
    let refused = fixture.post("/api/alarms/shelve", &empty, Role::Operator);
    assert_eq!(problem(&refused), (400, "expected a reason in one line of 1 to 500 characters"));
    assert_eq!(fixture.alarm("too high")["state"], "normal");
}

#[test]
fn the_figures_count_what_was_raised() {
    let fixture = Fixture::new();
    for _ in 0..3 {
        fixture.evaluate(0.5);
        fixture.evaluate(0.01);
    }
    fixture.evaluate(5.0);
    assert!(fixture.services.recorder().flush());
    let now = Micros::now().0 / 1000;
    let figures = fixture.get(&format!("/api/alarms/performance?from={}&to={}", now - 3_600_000, now + 60_000));
    assert_eq!(
        (&figures["raised"], &figures["by_priority"]),
        (&json!(5), &json!({ "high": 4, "medium": 1, "low": 0 }))
    );
    assert_eq!(figures["most_frequent"][0], json!({ "alarm": "too high", "raised": 4, "percent": 80.0 }));
    assert_eq!((&figures["chattering"], &figures["long_active"]), (&json!(["too high"]), &json!([])));
    assert_eq!(figures["worst_ten_minutes"]["raised"], 5);
    let (from, to) = (now - 366 * 86_400_000 - 1, now);
    let refused = fixture.ask("GET", &format!("/api/alarms/performance?from={from}&to={to}"), "", Role::Viewer);
    assert_eq!(problem(&refused), (400, "expected at most 366 days from from to to"));
}

#[test]
fn an_alarm_is_taken_out_of_service_and_returned() {
    let fixture = Fixture::new();
    let leave = json!({ "reason": " calibration ", "minutes": 30 });
    let (status, out) = fixture.post("/api/alarms/too%20high/out-of-service", &leave, Role::Engineer);
    let told = &out["out_of_service"];
    assert_eq!((status, &told["user"], &told["reason"]), (200, &json!("Ada"), &json!("calibration")));
    assert_eq!(told["until_ms"].as_i64().unwrap() - told["at_ms"].as_i64().unwrap(), 1_800_000);
    fixture.evaluate(0.5);
    assert_eq!(fixture.alarm("too high")["state"], "out-of-service");
    let again = fixture.post("/api/alarms/too%20high/out-of-service", &leave, Role::Engineer);
    assert_eq!(problem(&again), (409, "too high is out of service by Ada already"));
    assert_eq!(
        fixture.post("/api/alarms/too%20high/return-to-service", &json!({}), Role::Engineer).1["state"],
        "normal"
    );
    fixture.evaluate(0.5);
    assert_eq!(fixture.alarm("too high")["state"], "unacknowledged");
}

#[test]
fn changes_by_users_are_in_the_audit_trail() {
    let fixture = Fixture::new();
    fixture.evaluate(0.5);
    let seen = json!({ "occurrence": fixture.alarm("too high")["occurrence"] });
    assert_eq!(fixture.post("/api/alarms/too%20high/acknowledge", &seen, Role::Operator).0, 200);
    assert_eq!(fixture.post("/api/alarms/too%20high/acknowledge", &seen, Role::Operator).0, 409);
    let leave = json!({ "reason": "calibration", "minutes": 30 });
    assert_eq!(fixture.post("/api/alarms/too%20high/out-of-service", &leave, Role::Engineer).0, 200);
    assert_eq!(fixture.post("/api/alarms/too%20high/return-to-service", &json!({}), Role::Engineer).0, 200);
    // The answer comes after the write: no flush is needed.
    let rows = fixture.get("/api/audit?gauge=chamber");
    let cell = |row: &Value, name: &str| row[name].as_str().unwrap_or_default().to_owned();
    let columns = ["action", "user", "role", "peer", "target", "before", "after", "outcome"];
    let rows: Vec<_> = rows.as_array().unwrap().iter().rev().map(|row| columns.map(|name| cell(row, name))).collect();
    let at = "10.0.0.7";
    assert_eq!(
        rows,
        [
            ["acknowledged", "Ada", "operator", at, "too high", "unacknowledged", "acknowledged", ""],
            [
                "taken-out-of-service",
                "Ada",
                "engineer",
                at,
                "too high",
                "acknowledged",
                "out-of-service",
                "calibration"
            ],
            ["returned-to-service", "Ada", "engineer", at, "too high", "out-of-service", "normal", ""],
        ]
    );
}

#[test]
fn an_invalid_request_is_refused_with_a_sentence() {
    let fixture = Fixture::new();
    let path = |rest: &str| format!("/api/alarms/too%20high/{rest}");
    for (rest, body) in [
        ("acknowledge", ""),
        ("acknowledge", "{"),
        ("acknowledge", "{}"),
        ("acknowledge", "{\"occurrence\": 1.5}"),
        ("acknowledge", "{\"occurrence\": 99999999999999999999}"),
        ("acknowledge", "{\"occurrence\": 1, \"more\": 2}"),
        ("out-of-service", "{\"reason\": \"\"}"),
        ("out-of-service", "{\"reason\": \"  \\t \"}"),
        ("out-of-service", "{\"reason\": \"one\\ntwo\"}"),
        ("out-of-service", "{\"reason\": \"so\", \"minutes\": 0}"),
        ("out-of-service", "{\"reason\": \"so\", \"minutes\": 44641}"),
        ("out-of-service", "{\"minutes\": 5}"),
    ] {
        let (status, told) = fixture.ask("POST", &path(rest), body, Role::Engineer);
        assert!(status == 400 && told["detail"].is_string(), "{rest} {body}: {status} {told}");
    }
    let long = json!({ "reason": "x".repeat(501) });
    assert_eq!(fixture.post(&path("out-of-service"), &long, Role::Engineer).0, 400);
    let huge = json!({ "reason": "x".repeat(1 << 20) });
    assert_eq!(fixture.post(&path("out-of-service"), &huge, Role::Engineer).0, 400);
    assert_eq!(fixture.post("/api/alarms/acknowledge", &json!({ "alarms": [] }), Role::Operator).0, 400);
    assert_eq!(fixture.ask("GET", &path("acknowledge"), "", Role::Operator).0, 405);
    assert_eq!(fixture.ask("POST", "/api/alarms", "{}", Role::Operator).0, 405);
    for query in ["", "?from=2&to=1", "?from=0&to=1&limit=0", "?from=a&to=1"] {
        assert_eq!(fixture.ask("GET", &format!("/api/alarms/history{query}"), "", Role::Viewer).0, 400, "{query}");
    }
    assert_eq!(fixture.alarm("too high")["state"], "normal");
}

#[test]
fn the_most_urgent_alarms_stand_first() {
    let fixture = Fixture::new();
    fixture.evaluate(5.0);
    let now = fixture.services.alarms().overview();
    let overview = serde_json::to_value(&now.overview).unwrap();
    assert_eq!(overview["high"], json!({ "active": 1, "unacknowledged": 1 }));
    assert_eq!(overview["medium"], json!({ "active": 1, "unacknowledged": 1 }));
    let names: Vec<_> = now.standing.iter().map(|alarm| alarm.name.as_str()).collect();
    assert_eq!((names, &overview["problem"]), (vec!["too high", "history"], &Value::Null));
}
