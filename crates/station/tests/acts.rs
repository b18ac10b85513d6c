//! Commands and parameter writes on a segment in memory: armed, executed, refused, and in the audit trail.

#![allow(clippy::unwrap_used, clippy::panic, clippy::indexing_slicing, reason = "a test")]

use crate::support::memory_station::{ENGINEER, MemoryStation, OPERATOR, Outside, VIEWER};
use crate::support::until;
use profivac_station::control::AuthorityAction;
use profivac_station::control::error::Unavailable;
use profivac_station::control::requests::SegmentRequest;
use profivac_station::view::BusStationState;
use profivac_web_server::auth::{Actor, Role, User};
use serde_json::{Value, json};
use std::sync::{Arc, Barrier};
use std::time::Instant;

const DEGAS: &str = "ba.degas-on";
const SAFE_VALUE: &str = "pirani.safe-value";

fn write(target: &str, value: &str) -> Value {
    json!({ "target": target, "value": value })
}

/// The rows of the audit trail, the earliest first: action, user, target, before, after, outcome.
fn trail(station: &MemoryStation) -> Vec<[String; 6]> {
    let (status, rows) = station.get(VIEWER, "/api/audit");
    assert_eq!(status, 200, "{rows}");
    let cell = |row: &Value, name: &str| row[name].as_str().unwrap_or_default().to_owned();
    let rows = rows.as_array().unwrap().iter().rev();
    rows.map(|row| ["action", "user", "target", "before", "after", "outcome"].map(|name| cell(row, name))).collect()
}

#[test]
fn a_degas_is_armed_executed_and_recorded() {
    let station = MemoryStation::new(1e-6);
    let (_, commands) = station.get(VIEWER, "/api/gauges/chamber/commands");
    let degas = commands.as_array().unwrap().iter().find(|command| command["command"] == DEGAS).unwrap();
    assert_eq!((&degas["role"], &degas["risk"]["class"]), (&json!("operator"), &json!("dangerous")));
    let wanted = json!([
        "the gauge is in EXECUTING",
        "the emission is on",
        "no degas runs",
        "ba.process-value is below 7.2e-6 mbar"
    ]);
    assert_eq!(degas["conditions"], wanted);
    station.take_control(OPERATOR);
    let (status, armed) = station.arm(OPERATOR, &json!({ "command": "degas on" }));
    assert_eq!(status, 200, "{armed}");
    assert_eq!(
        armed["conditions"].as_array().unwrap().iter().filter(|one| one["is_met"] == true).count(),
        4,
        "{armed}"
    );
    assert_eq!(armed["octets"], "01 01");
    assert!(armed["risk"]["description"].as_str().unwrap().starts_with("heats the electrodes"), "{armed}");
    assert!(!station.is_degassing(), "nothing has been sent");
    let (status, done) = station.execute(OPERATOR, &armed);
    assert_eq!(status, 200, "{done}");
    assert!(station.is_degassing());
    let (status, again) = station.arm(OPERATOR, &json!({ "command": "degas on" }));
    assert_eq!((status, &again["conditions"][2]["is_met"]), (409, &json!(false)), "{again}");
    assert!(
        again["detail"].as_str().unwrap().contains("a degas runs; it ends by itself, or write degas off"),
        "{again}"
    );
    let trail = trail(&station);
    let command = "Hot Cathode Block State Command (1:2/14)";
    assert_eq!(trail[1], ["execute", "Otto", command, "", "degas-on", ""], "{trail:#?}");
    assert_eq!(trail[2], ["outcome", "Otto", command, "", "", "done"], "{trail:#?}");
    assert_eq!(station.gauge().state, BusStationState::DataExchange);
}

#[test]
fn a_degas_above_its_pressure_limit_is_refused_with_the_reason() {
    let station = MemoryStation::new(5e-4);
    station.take_control(OPERATOR);
    let (status, refused) = station.arm(OPERATOR, &json!({ "command": DEGAS }));
    assert_eq!(status, 409, "{refused}");
    let pressure = &refused["conditions"][3];
    assert_eq!(pressure["is_met"], false);
    assert_eq!(pressure["expected"], "ba.process-value is below 7.2e-6 mbar");
    assert!(pressure["found"].as_str().unwrap().starts_with("it is "), "{refused}");
    assert!(refused["detail"].as_str().unwrap().contains("must be below 7.2e-6 mbar; pump down first"), "{refused}");
    let trail = trail(&station);
    assert_eq!(trail[1][0], "refused", "{trail:#?}");
    assert!(trail[1][5].contains("pump down first"), "{trail:#?}");
}

#[test]
fn a_pressure_that_rises_after_arming_prevents_the_execution() {
    let station = MemoryStation::new(1e-6);
    station.take_control(OPERATOR);
    let (_, armed) = station.arm(OPERATOR, &json!({ "command": DEGAS }));
    station.outside(|segment| segment.set_environment(Outside::mbar(5e-4)));
    station.until_pa(|pa| pa > 1e-2);
    let (status, refused) = station.execute(OPERATOR, &armed);
    assert_eq!((status, &refused["conditions"][3]["is_met"]), (409, &json!(false)), "{refused}");
    assert!(!station.is_degassing());
    assert!(trail(&station).last().unwrap()[5].starts_with("not sent: ba.process-value is "), "{:#?}", trail(&station));
}

#[test]
fn a_write_records_the_values_before_and_after() {
    let station = MemoryStation::new(1e-6);
    station.take_control(ENGINEER);
    let (status, armed) = station.arm(ENGINEER, &write(SAFE_VALUE, "12.5 Pascal"));
    assert_eq!(status, 200, "{armed}");
    assert_eq!((&armed["before"], &armed["after"]), (&json!("0 mbar"), &json!("0.125 mbar")), "{armed}");
    assert_eq!(armed["risk"]["class"], "persistent");
    let (status, done) = station.execute(ENGINEER, &armed);
    assert_eq!(status, 200, "{done}");
    assert_eq!((&done["before"], &done["after"]), (&json!("0 mbar"), &json!("0.125 mbar")), "{done}");
    assert_eq!(trail(&station)[2][3..], ["0 mbar", "0.125 mbar", "done"]);
    let (_, blocks) = station.get(VIEWER, "/api/gauges/chamber/blocks");
    let all = blocks.as_array().unwrap().iter().flat_map(|block| block["parameters"].as_array().unwrap());
    let safe = all.clone().find(|parameter| parameter["target"] == SAFE_VALUE).unwrap();
    assert_eq!(
        (&safe["value"], &safe["write"]["expects"]),
        (&json!("0.125 mbar"), &json!("a pressure of 0 or more with its unit, such as '1500 mbar'"))
    );
    let state = all.clone().find(|parameter| parameter["target"] == "pirani.safe-state").unwrap();
    assert_eq!(state["write"]["allowed_values"], json!(["zero", "full-scale", "hold-last-value", "use-safe-value"]));
}

#[test]
fn a_user_without_the_role_is_refused_and_told_which_role_it_needs() {
    let station = MemoryStation::new(1e-6);
    let (status, refused) = station.arm(VIEWER, &json!({ "command": DEGAS }));
    assert_eq!(status, 403, "{refused}");
    assert_eq!(refused["detail"], "ba.degas-on needs the role operator, Vera has viewer");
    assert_eq!(station.post(VIEWER, "/api/control-authority/request", None).0, 403);
    station.take_control(OPERATOR);
    let (status, refused) = station.arm(OPERATOR, &write(SAFE_VALUE, "1 mbar"));
    assert_eq!(
        (status, &refused["detail"]),
        (403, &json!("pirani.safe-value needs the role engineer, Otto has operator"))
    );
    assert_eq!(station.arm(OPERATOR, &json!({ "command": "manual-mode" })).0, 403);
}

/// The role at the time of the execution counts.
#[test]
fn a_user_whose_role_was_lowered_after_arming_executes_nothing() {
    let station = MemoryStation::new(1e-6);
    station.take_control(ENGINEER);
    let (_, armed) = station.arm(ENGINEER, &write(SAFE_VALUE, "1 mbar"));
    for (role, has) in [(Role::Viewer, "viewer"), (Role::Operator, "operator")] {
        let (status, refused) = station.execute((ENGINEER.0, role), &armed);
        let why = format!("pirani.safe-value needs the role engineer, Erna has {has}");
        assert_eq!((status, &refused["detail"]), (403, &json!(why)));
    }
    assert!(trail(&station).iter().all(|row| row[0] != "execute"), "{:#?}", trail(&station));
    assert_eq!(station.execute(ENGINEER, &armed).0, 200, "the command is still armed");
}

#[test]
fn a_command_is_executed_once_and_only_by_the_user_who_armed_it() {
    let station = MemoryStation::new(1e-6);
    station.take_control(ENGINEER);
    let (_, armed) = station.arm(ENGINEER, &write(SAFE_VALUE, "1 mbar"));
    let (status, refused) = station.execute(OPERATOR, &armed);
    assert_eq!((status, &refused["detail"]), (403, &json!("Erna armed this command: only Erna may execute it")));
    assert_eq!(station.execute(ENGINEER, &armed).0, 200);
    let (status, refused) = station.execute(ENGINEER, &armed);
    assert_eq!((status, &refused["detail"]), (409, &json!("the command was already executed: arm it again")));
    let (_, armed) = station.arm(ENGINEER, &write(SAFE_VALUE, "2 mbar"));
    assert_eq!(station.disarm(ENGINEER, &armed).0, 204);
    assert_eq!(station.execute(ENGINEER, &armed).1["detail"], "the command was disarmed: arm it again");
    assert_eq!(station.post(ENGINEER, "/api/armed-commands/nothing/execute", None).0, 404);
    assert_eq!(trail(&station).iter().filter(|row| row[0] == "execute").count(), 1);
}

#[test]
fn a_value_that_changed_after_arming_is_not_overwritten() {
    let station = MemoryStation::new(1e-6);
    station.take_control(ENGINEER);
    let (_, first) = station.arm(ENGINEER, &write(SAFE_VALUE, "1 mbar"));
    let (_, second) = station.arm(ENGINEER, &write(SAFE_VALUE, "2 mbar"));
    assert_eq!(station.execute(ENGINEER, &second).0, 200);
    let (status, refused) = station.execute(ENGINEER, &first);
    let sentence = "pirani.safe-value was 0 mbar when it was armed and is 2 mbar now";
    assert_eq!((status, &refused["detail"]), (409, &json!(sentence)));
    assert_eq!(trail(&station).last().unwrap()[5], format!("not sent: {sentence}"));
}

#[test]
fn a_change_of_control_disarms_all_commands() {
    let station = MemoryStation::new(1e-6);
    let (status, refused) = station.arm(OPERATOR, &json!({ "command": DEGAS }));
    assert_eq!((status, &refused["detail"]), (409, &json!("no one has control: request control first")));
    station.take_control(OPERATOR);
    let (_, armed) = station.arm(OPERATOR, &json!({ "command": DEGAS }));
    let (status, authority) = station.post(ENGINEER, "/api/control-authority/take-over", None);
    assert_eq!((status, &authority["holder"]), (200, &json!("Erna")));
    let (status, refused) = station.execute(OPERATOR, &armed);
    let sentence = "the command was disarmed when its user lost control: arm it again";
    assert_eq!((status, &refused["detail"]), (409, &json!(sentence)));
    let (status, refused) = station.arm(OPERATOR, &json!({ "command": DEGAS }));
    assert_eq!((status, &refused["detail"]), (409, &json!("Erna has control")));
    assert_eq!(station.post(OPERATOR, "/api/control-authority/request", None).1["requested_by"], "Otto");
    assert_eq!(station.post(ENGINEER, "/api/control-authority/grant", None).1["holder"], "Otto");
    let sentences: Vec<_> = trail(&station).into_iter().map(|row| row[5].clone()).collect();
    assert_eq!(
        sentences,
        ["took control, which was free", "took control over from Otto", "requested control", "granted control to Otto"]
    );
}

#[test]
fn of_many_simultaneous_requests_one_user_gets_control() {
    let station = MemoryStation::new(1e-6);
    for _ in 0..50 {
        let barrier = Arc::new(Barrier::new(8));
        let requesters: Vec<_> = (0..8)
            .map(|number| {
                let (services, barrier) = (Arc::clone(&station.services), Arc::clone(&barrier));
                let user = User { name: Arc::from(format!("user {number}")), role: Role::Operator };
                std::thread::spawn(move || {
                    barrier.wait();
                    let actor = Actor { user, peer: None };
                    services.control().change_authority(&actor, AuthorityAction::Request, Instant::now()).ok();
                    actor
                })
            })
            .collect();
        let requesters: Vec<_> = requesters.into_iter().map(|requester| requester.join().unwrap()).collect();
        let released = requesters.iter().filter(|requester| {
            station.services.control().change_authority(requester, AuthorityAction::Release, Instant::now()).is_ok()
        });
        assert_eq!(released.count(), 1);
    }
    assert!(station.services.recorder().flush());
    let (_, rows) = station.get(VIEWER, "/api/audit?limit=1000");
    let count = |words: &str| rows.as_array().unwrap().iter().filter(|row| row["outcome"] == words).count();
    assert_eq!((count("took control, which was free"), count("released control")), (50, 50));
}

#[test]
fn a_gauge_that_is_lost_after_arming_is_reported() {
    let station = MemoryStation::new(1e-6);
    station.take_control(OPERATOR);
    let (_, armed) = station.arm(OPERATOR, &json!({ "command": DEGAS }));
    station.outside(|segment| segment.devices_mut().for_each(|device| device.set_power(false)));
    let (status, refused) = station.execute(OPERATOR, &armed);
    assert_eq!(status, 409, "{refused}");
    assert!(trail(&station).last().unwrap()[5].starts_with("not sent: "), "{:#?}", trail(&station));
}

#[test]
fn a_refusal_of_the_gauge_is_reported_with_its_reason() {
    let station = MemoryStation::new(1e-6);
    station.take_control(ENGINEER);
    let (status, armed) = station.arm(ENGINEER, &write("ba.emission-current", "0.5"));
    assert_eq!(status, 200, "{armed}");
    let (status, refused) = station.execute(ENGINEER, &armed);
    assert_eq!(status, 409, "{refused}");
    let sentence = refused["detail"].as_str().unwrap();
    assert!(
        sentence.contains("writing was refused with ") && sentence.contains("code 2: lower or upper"),
        "{sentence}"
    );
    assert!(trail(&station).last().unwrap()[5].starts_with("refused: "), "{:#?}", trail(&station));
}

#[test]
fn nothing_is_sent_while_the_audit_trail_cannot_be_written() {
    let station = MemoryStation::new(1e-6);
    station.take_control(OPERATOR);
    let (_, armed) = station.arm(OPERATOR, &json!({ "command": DEGAS }));
    // Another program holds a write transaction.
    let other = rusqlite::Connection::open(station.database()).unwrap();
    other.execute_batch("BEGIN IMMEDIATE").unwrap();
    let (status, refused) = station.execute(OPERATOR, &armed);
    assert_eq!(status, 503, "{refused}");
    assert!(
        refused["detail"]
            .as_str()
            .unwrap()
            .starts_with("nothing was sent, because the audit trail cannot be written: ")
    );
    other.execute_batch("ROLLBACK").unwrap();
    assert!(!station.is_degassing());
    assert!(trail(&station).iter().all(|row| row[0] == "control-authority"), "{:#?}", trail(&station));
}

#[test]
fn the_unit_and_the_number_type_are_never_written() {
    let station = MemoryStation::new(1e-6);
    station.take_control(ENGINEER);
    for target in ["pirani.data-units", "pirani.data-type"] {
        let (status, refused) = station.arm(ENGINEER, &write(target, "Torr"));
        assert_eq!(status, 409, "{refused}");
        assert!(refused["detail"].as_str().unwrap().contains("profivac write"), "{refused}");
    }
}

#[test]
fn an_invalid_request_is_answered_with_what_was_expected() {
    let station = MemoryStation::new(1e-6);
    station.take_control(ENGINEER);
    for (request, status, part) in [
        (write("pirani.safe-state", "never"), 400, "expected one of zero, full-scale, hold-last-value"),
        (write("pirani.safe-valve", "1"), 400, "did you mean"),
        (json!({ "command": "explode" }), 400, "bcg450 has no command \"explode\""),
        (json!({ "target": SAFE_VALUE }), 400, "expected either a command, or a target and its value"),
        (json!({ "password": "orchid ladder" }), 400, "expected a JSON body as /api/openapi.json describes it"),
        (write("pirani.process-value", "1"), 400, "read-only"),
        (write("ba.hot-cathode-block-state-command", "explode"), 400, "expected one of inactive, degas-off"),
    ] {
        let (found, refused) = station.arm(ENGINEER, &request);
        assert_eq!(found, status, "{refused}");
        assert!(refused["detail"].as_str().unwrap().contains(part), "{refused}");
        assert!(!refused.to_string().contains("orchid"), "{refused}");
    }
    assert_eq!(station.post(ENGINEER, "/api/gauges/unknown/arm", Some(&write(SAFE_VALUE, "1 mbar"))).0, 404);
    // A number is a value of a parameter that has one unit, or none.
    let (status, armed) = station.arm(ENGINEER, &json!({ "target": "ba.emission-current", "value": 0.025 }));
    assert_eq!((status, &armed["after"]), (200, &json!("0.025 mA")), "{armed}");
    let percentage = "setpoint-a.percentage-of-atmosphere";
    let (status, armed) = station.arm(ENGINEER, &write(percentage, "50 %"));
    assert_eq!((status, &armed["octets"], &armed["after"]), (200, &json!("01 F4"), &json!("50 %")), "{armed}");
    let (status, refused) = station.arm(ENGINEER, &json!({ "target": percentage, "value": 50 }));
    assert_eq!(status, 400, "{refused}");
    assert!(
        refused["detail"].as_str().unwrap().ends_with("got \"50\" without its sign; 50 percent is '50 %'"),
        "{refused}"
    );
    let (status, refused) = station.arm(ENGINEER, &json!({ "target": SAFE_VALUE, "value": 0.25 }));
    let sentence = "bcg450 at address 5, pirani.safe-value (slot 1, index 40, instance 1): expected a pressure of 0 or more with its \
                    unit, such as '1500 mbar', got \"0.25\" without a unit; in the present unit of the gauge it is '0.25 mbar'";
    assert_eq!((status, &refused["detail"]), (400, &json!(sentence)));
}

#[test]
fn a_pressure_outside_the_measuring_range_is_armed_only_by_force_and_the_audit_trail_says_so() {
    let station = MemoryStation::new(1e-6);
    station.take_control(ENGINEER);
    let (status, refused) = station.arm(ENGINEER, &write(SAFE_VALUE, "1e9 mbar"));
    let sentence = "pirani.safe-value: 1e9 mbar is outside the measuring range, which is 5e-10 mbar to 1500 mbar; to write it all the \
                    same, request it with \"force\": true";
    assert_eq!((status, &refused["detail"]), (400, &json!(sentence)));
    let (status, armed) = station.arm(ENGINEER, &json!({ "target": SAFE_VALUE, "value": "1e9 mbar", "force": true }));
    assert_eq!((status, &armed["after"]), (200, &json!("1e9 mbar")), "{armed}");
    let condition = &armed["conditions"][0];
    let forced = "the request forces a pressure outside the measuring range, which is 5e-10 mbar to 1500 mbar";
    assert_eq!((&condition["expected"], &condition["found"]), (&json!(forced), &json!("it is 1e9 mbar")), "{armed}");
    let (status, done) = station.execute(ENGINEER, &armed);
    assert_eq!((status, &done["after"]), (200, &json!("1e9 mbar")), "{done}");
    let rows = trail(&station);
    let forced = "1e9 mbar, forced: 1e9 mbar is outside the measuring range, which is 5e-10 mbar to 1500 mbar";
    assert!(rows.iter().any(|row| row.iter().any(|cell| cell == forced)), "{rows:?}");
}

#[test]
fn the_audit_trail_is_exported_and_cannot_be_changed() {
    let station = MemoryStation::new(1e-6);
    let formula = ("=1+1", Role::Engineer);
    station.take_control(formula);
    station.post(formula, "/api/control-authority/release", None);
    station.take_control(ENGINEER);
    let (_, armed) = station.arm(ENGINEER, &write(SAFE_VALUE, "1 mbar"));
    assert_eq!(station.execute(ENGINEER, &armed).0, 200);
    let table = station.text("/api/audit.csv");
    let mut lines = table.lines();
    assert!(lines.next().unwrap().starts_with("id,time,action,refers_to,user,role,peer,gauge,segment,address,target,"));
    assert!(lines.next().unwrap().contains(",control-authority,,\"'=1+1\",engineer,"), "a name is no formula: {table}");
    assert!(table.contains(",\"0 mbar\",\"1 mbar\",\"done\","), "{table}");
    let (_, rows) = station.get(VIEWER, "/api/audit?gauge=chamber&user=Erna&limit=1");
    assert_eq!((rows.as_array().unwrap().len(), &rows[0]["action"]), (1, &json!("outcome")));
    assert_eq!(station.get(VIEWER, "/api/audit?user=Otto").1, json!([]));
    assert_eq!(station.get(VIEWER, "/api/audit?limit=0").0, 400);
    let other = rusqlite::Connection::open(station.database()).unwrap();
    for sql in ["UPDATE audit SET user_name = 'Eve'", "DELETE FROM audit"] {
        let refused = other.execute_batch(sql).unwrap_err().to_string();
        assert!(refused.contains("the audit trail is not "), "{refused}");
    }
}

#[test]
fn data_exchange_continues_while_commands_are_executed() {
    let station = MemoryStation::new(1e-6);
    station.take_control(ENGINEER);
    for value in ["1 mbar", "2 mbar", "3 mbar"] {
        let (_, armed) = station.arm(ENGINEER, &write(SAFE_VALUE, value));
        assert_eq!(station.execute(ENGINEER, &armed).0, 200);
    }
    let lost = station.ask_outside(|segment| segment.master().counters(5).unwrap().lost);
    assert_eq!(lost, 0);
    until("data exchange", || (station.gauge().state == BusStationState::DataExchange).then_some(()));
}

#[test]
fn an_outcome_is_recorded_when_the_browser_has_gone() {
    let station = MemoryStation::new(1e-6);
    station.take_control(ENGINEER);
    let (_, armed) = station.arm(ENGINEER, &write(SAFE_VALUE, "1 mbar"));
    station.execute_and_leave(ENGINEER, &armed, || (trail(&station).last()?[0] == "execute").then_some(()));
    until("the outcome", || trail(&station).last().filter(|row| row[5] == "done").cloned());
}

#[test]
fn a_body_that_is_no_request_is_refused() {
    let station = MemoryStation::new(1e-6);
    let path = "/api/gauges/chamber/arm";
    for body in ["{", "", "[]", "{\"command\": 1}"] {
        assert_eq!(station.send_as(ENGINEER, "POST", path, "application/json", body.to_owned()).0, 400, "{body}");
    }
}

#[test]
fn a_command_that_waits_is_not_sent_after_its_user_lost_control() {
    let station = MemoryStation::new(1e-6);
    station.take_control(OPERATOR);
    let user = User { name: Arc::from(OPERATOR.0), role: OPERATOR.1 };
    let actor = Actor { user, peer: None };
    let request = serde_json::from_value(json!({ "command": DEGAS })).unwrap();
    let command = station.services.control().arm(&actor, "chamber", &request).unwrap();
    station.services.control().change_authority(&actor, AuthorityAction::Release, Instant::now()).unwrap();
    let late = station
        .services
        .control()
        .requests()
        .execute(command, Instant::now() + std::time::Duration::from_secs(60))
        .unwrap_err();
    assert_eq!(late.outcome(), "not sent: Otto lost control before the command was sent");
    assert!(!station.is_degassing());
}

#[test]
fn viewers_leave_room_in_the_queue_for_operators() {
    let station = MemoryStation::new(1e-6);
    station.take_control(OPERATOR);
    let requests = station.services.control().requests().accept(&station.gauge().segment);
    std::thread::scope(|scope| {
        let (done, busy) = std::sync::mpsc::channel();
        for _ in 0..10 {
            let (station, done) = (&station, done.clone());
            // The two reads that wait are answered at the end, when the receiver may be gone.
            scope.spawn(move || {
                done.send(station.services.control().requests().blocks("chamber").is_err()).unwrap_or_default()
            });
        }
        (0..8).for_each(|_| {
            assert!(busy.recv_timeout(std::time::Duration::from_secs(30)).unwrap(), "only two reads wait")
        });
        let arm = scope.spawn(|| station.arm(OPERATOR, &json!({ "command": DEGAS })));
        for _ in 0..2 {
            let Ok(SegmentRequest::Blocks(_, answer)) = requests.recv() else { panic!("expected the reads first") };
            answer.send(Ok(Vec::new())).unwrap();
        }
        let Ok(SegmentRequest::Preview(_, _, answer)) = requests.recv() else { panic!("expected the preview") };
        answer.send(Err(Unavailable::SegmentDown("asked".to_owned()).into())).unwrap();
        assert_eq!(arm.join().unwrap().1["detail"], "asked");
    });
}

#[test]
fn requests_have_their_places_in_the_queue_until_they_are_answered() {
    let station = MemoryStation::new(1e-6);
    station.take_control(OPERATOR);
    let requests = station.services.control().requests().accept(&station.gauge().segment);
    std::thread::scope(|scope| {
        // The segment has taken eight requests and answered none.
        let mut taken = Vec::new();
        for _ in 0..8 {
            scope.spawn(|| station.arm(OPERATOR, &json!({ "command": DEGAS })));
            taken.push(requests.recv().unwrap());
        }
        let (status, problem) = station.arm(OPERATOR, &json!({ "command": DEGAS }));
        assert_eq!((status, &problem["detail"]), (409, &json!("the segment is busy with other requests: try again")));
        drop(taken);
        let arm = scope.spawn(|| station.arm(OPERATOR, &json!({ "command": DEGAS })));
        assert!(requests.recv().is_ok(), "a dropped request frees its place");
        drop(arm);
    });
}

#[test]
fn an_operator_makes_a_note_about_a_time_and_a_gauge() {
    let station = MemoryStation::new(1e-6);
    let note = json!({ "text": " the trap is filled ", "at_ms": 1_767_225_600_000_i64, "gauge": "chamber" });
    let (status, made) = station.post(OPERATOR, "/api/notes", Some(&note));
    let expected = json!({
        "at_ms": 1_767_225_600_000_i64, "gauge": "chamber", "kind": "note",
        "text": format!("{} noted: the trap is filled", OPERATOR.0)
    });
    assert_eq!((status, &made), (200, &expected));
    let (_, events) = station.get(VIEWER, "/api/events?from=1767225600000&to=1767225600001");
    assert_eq!(events, json!([expected]));
    let (status, made) = station.post(OPERATOR, "/api/notes", Some(&json!({ "text": "now" })));
    assert_eq!((status, &made["gauge"]), (200, &Value::Null));
    let at = made["at_ms"].as_i64().unwrap();
    let (_, events) = station.get(VIEWER, &format!("/api/events?from={at}&to={}", at + 1));
    assert!(events.as_array().unwrap().contains(&made), "{events}");
}

#[test]
fn a_note_that_is_refused_is_no_event() {
    let station = MemoryStation::new(1e-6);
    let refused = |user, note: Value| {
        let (status, problem) = station.post(user, "/api/notes", Some(&note));
        (status, problem["detail"].as_str().unwrap_or_default().to_owned())
    };
    assert_eq!(refused(VIEWER, json!({ "text": "a" })).0, 403);
    let unknown = refused(OPERATOR, json!({ "text": "a", "gauge": "attic" }));
    assert_eq!(unknown, (404, "there is no gauge \"attic\"; the gauges are chamber".to_owned()));
    let (status, problem) = station.post(OPERATOR, "/api/segments/attic/captures", None);
    assert_eq!((status, &problem["detail"]), (404, &json!("there is no segment \"attic\"; the segments are hall")));
    for (note, detail) in [
        (json!({ "text": " " }), "expected a note in one line of 1 to 500 characters"),
        (json!({ "text": "a", "at_ms": 4_102_444_800_000_i64 }), "at_ms: expected a time since 1970 that has passed"),
        (json!({ "text": "a\nb" }), "text: "),
        (json!({}), "expected a JSON body"),
    ] {
        let (status, text) = refused(OPERATOR, note.clone());
        assert!(status == 400 && text.contains(detail), "{note}: {status} {text}");
    }
    let (_, events) = station.get(VIEWER, "/api/events?from=0&to=4102444800000");
    assert!(events.as_array().unwrap().iter().all(|event| event["kind"] != "note"), "{events}");
}
