//! Commands and parameters over a segment in memory: armed, fired, refused, and written down.

#![allow(clippy::unwrap_used, clippy::panic, clippy::indexing_slicing, reason = "a test")]

mod bench;

use bench::{Desk, ENGINEER, OPERATOR, Outside, VIEWER, until};
use profivac_station::auth::{Role, User};
use profivac_station::control::operation::OperationError;
use profivac_station::control::{self, Actor, AuthorityAction};
use profivac_station::services::SegmentRequest;
use profivac_station::view::BusStationState;
use serde_json::{Value, json};
use std::sync::{Arc, Barrier};
use std::time::Instant;

const DEGAS: &str = "ba.degas-on";
const SAFE_VALUE: &str = "pirani.safe-value";

fn wish(target: &str, value: &str) -> Value {
    json!({ "target": target, "value": value })
}

/// What the audit trail says, the earliest first: what, who, target, before, after, outcome.
fn trail(desk: &Desk) -> Vec<[String; 6]> {
    let (status, rows) = desk.get(VIEWER, "/api/audit");
    assert_eq!(status, 200, "{rows}");
    let cell = |row: &Value, name: &str| row[name].as_str().unwrap_or_default().to_owned();
    let rows = rows.as_array().unwrap().iter().rev();
    rows.map(|row| ["what", "who", "target", "before", "after", "outcome"].map(|name| cell(row, name))).collect()
}

#[test]
fn a_degas_is_armed_and_fired_and_written_down() {
    let desk = Desk::new(1e-6);
    let (_, commands) = desk.get(VIEWER, "/api/gauges/chamber/commands");
    let degas = commands.as_array().unwrap().iter().find(|command| command["command"] == DEGAS).unwrap();
    assert_eq!((&degas["role"], &degas["risk"]["class"]), (&json!("operator"), &json!("dangerous")));
    let wanted = json!(["the gauge is in EXECUTING", "the emission is on", "ba.process-value is below 7.2e-6 mbar"]);
    assert_eq!(degas["conditions"], wanted);
    desk.masters(OPERATOR);
    let (status, armed) = desk.arm(OPERATOR, &json!({ "command": "degas on" }));
    assert_eq!(status, 200, "{armed}");
    assert_eq!(armed["conditions"].as_array().unwrap().iter().filter(|one| one["holds"] == true).count(), 3, "{armed}");
    assert_eq!(armed["octets"], "01 01");
    assert!(armed["risk"]["words"].as_str().unwrap().starts_with("heats the electrodes"), "{armed}");
    assert!(!desk.is_degassing(), "nothing was sent yet");
    let (status, done) = desk.fire(OPERATOR, &armed);
    assert_eq!(status, 200, "{done}");
    assert!(desk.is_degassing());
    let trail = trail(&desk);
    let command = "Hot Cathode Block State Command (1:2/14)";
    assert_eq!(trail[1], ["fired", "Otto", command, "", "degas-on", ""], "{trail:#?}");
    assert_eq!(trail[2], ["outcome", "Otto", command, "", "", "done"], "{trail:#?}");
    assert_eq!(desk.gauge().standing, BusStationState::Exchanging);
}

#[test]
fn a_degas_above_its_pressure_is_not_armed_and_says_why() {
    let desk = Desk::new(5e-4);
    desk.masters(OPERATOR);
    let (status, refused) = desk.arm(OPERATOR, &json!({ "command": DEGAS }));
    assert_eq!(status, 409, "{refused}");
    let pressure = &refused["conditions"][2];
    assert_eq!(pressure["holds"], false);
    assert_eq!(pressure["wanted"], "ba.process-value is below 7.2e-6 mbar");
    assert!(pressure["found"].as_str().unwrap().starts_with("it is "), "{refused}");
    assert!(refused["problem"].as_str().unwrap().contains("must be below 7.2e-6 mbar; pump down first"), "{refused}");
    let trail = trail(&desk);
    assert_eq!(trail[1][0], "refused", "{trail:#?}");
    assert!(trail[1][5].contains("pump down first"), "{trail:#?}");
}

#[test]
fn a_pressure_that_rises_between_arming_and_firing_counts() {
    let desk = Desk::new(1e-6);
    desk.masters(OPERATOR);
    let (_, armed) = desk.arm(OPERATOR, &json!({ "command": DEGAS }));
    desk.outside(|scene| scene.set_surroundings(Outside::mbar(5e-4)));
    desk.until_pa(|pa| pa > 1e-2);
    let (status, refused) = desk.fire(OPERATOR, &armed);
    assert_eq!((status, &refused["conditions"][2]["holds"]), (409, &json!(false)), "{refused}");
    assert!(!desk.is_degassing());
    assert!(trail(&desk).last().unwrap()[5].starts_with("not sent: ba.process-value is "), "{:#?}", trail(&desk));
}

#[test]
fn a_parameter_is_written_with_its_value_before_and_after() {
    let desk = Desk::new(1e-6);
    desk.masters(ENGINEER);
    let (status, armed) = desk.arm(ENGINEER, &wish(SAFE_VALUE, "12.5 Pascal"));
    assert_eq!(status, 200, "{armed}");
    assert_eq!((&armed["before"], &armed["after"]), (&json!("0 mbar"), &json!("0.125 mbar")), "{armed}");
    assert_eq!(armed["risk"]["class"], "kept");
    let (status, done) = desk.fire(ENGINEER, &armed);
    assert_eq!(status, 200, "{done}");
    assert_eq!((&done["before"], &done["after"]), (&json!("0 mbar"), &json!("0.125 mbar")), "{done}");
    assert_eq!(trail(&desk)[2][3..], ["0 mbar", "0.125 mbar", "done"]);
    let (_, blocks) = desk.get(VIEWER, "/api/gauges/chamber/blocks");
    let all = blocks.as_array().unwrap().iter().flat_map(|block| block["parameters"].as_array().unwrap());
    let safe = all.clone().find(|parameter| parameter["target"] == SAFE_VALUE).unwrap();
    assert_eq!(
        (&safe["value"], &safe["write"]["takes"]),
        (&json!("0.125 mbar"), &json!("a pressure of 0 mbar or more"))
    );
    let state = all.clone().find(|parameter| parameter["target"] == "pirani.safe-state").unwrap();
    assert_eq!(state["write"]["choices"], json!(["zero", "full-scale", "hold-last-value", "use-safe-value"]));
}

#[test]
fn a_role_that_may_not_is_told_which_may() {
    let desk = Desk::new(1e-6);
    let (status, refused) = desk.arm(VIEWER, &json!({ "command": DEGAS }));
    assert_eq!(status, 403, "{refused}");
    assert_eq!(refused["problem"], "ba.degas-on needs the role operator, Vera has viewer");
    assert_eq!(desk.post(VIEWER, "/api/mastership/ask", None).0, 403);
    desk.masters(OPERATOR);
    let (status, refused) = desk.arm(OPERATOR, &wish(SAFE_VALUE, "1"));
    assert_eq!(
        (status, &refused["problem"]),
        (403, &json!("pirani.safe-value needs the role engineer, Otto has operator"))
    );
    assert_eq!(desk.arm(OPERATOR, &json!({ "command": "manual-mode" })).0, 403);
}

/// The role counts when it is fired, and not when it was armed.
#[test]
fn who_may_less_than_when_they_armed_fires_nothing() {
    let desk = Desk::new(1e-6);
    desk.masters(ENGINEER);
    let (_, armed) = desk.arm(ENGINEER, &wish(SAFE_VALUE, "1"));
    for (role, has) in [(Role::Viewer, "viewer"), (Role::Operator, "operator")] {
        let (status, refused) = desk.fire((ENGINEER.0, role), &armed);
        let why = format!("pirani.safe-value needs the role engineer, Erna has {has}");
        assert_eq!((status, &refused["problem"]), (403, &json!(why)));
    }
    assert!(trail(&desk).iter().all(|row| row[0] != "fired"), "{:#?}", trail(&desk));
    assert_eq!(desk.fire(ENGINEER, &armed).0, 200, "it is armed still");
}

#[test]
fn an_order_is_fired_once_by_who_armed_it_in_time() {
    let desk = Desk::new(1e-6);
    desk.masters(ENGINEER);
    let (_, armed) = desk.arm(ENGINEER, &wish(SAFE_VALUE, "1"));
    let (status, refused) = desk.fire(OPERATOR, &armed);
    assert_eq!((status, &refused["problem"]), (403, &json!("the order is Erna's: only who armed it may fire it")));
    assert_eq!(desk.fire(ENGINEER, &armed).0, 200);
    let (status, refused) = desk.fire(ENGINEER, &armed);
    assert_eq!((status, &refused["problem"]), (409, &json!("the order was fired already: arm it again")));
    let (_, armed) = desk.arm(ENGINEER, &wish(SAFE_VALUE, "2"));
    assert_eq!(desk.delete(ENGINEER, &armed).0, 204);
    assert_eq!(desk.fire(ENGINEER, &armed).1["problem"], "the order was disarmed: arm it again");
    assert_eq!(desk.post(ENGINEER, "/api/orders/nothing/fire", None).0, 404);
    assert_eq!(trail(&desk).iter().filter(|row| row[0] == "fired").count(), 1);
}

#[test]
fn a_value_that_somebody_has_changed_meanwhile_is_not_overwritten() {
    let desk = Desk::new(1e-6);
    desk.masters(ENGINEER);
    let (_, first) = desk.arm(ENGINEER, &wish(SAFE_VALUE, "1"));
    let (_, second) = desk.arm(ENGINEER, &wish(SAFE_VALUE, "2"));
    assert_eq!(desk.fire(ENGINEER, &second).0, 200);
    let (status, refused) = desk.fire(ENGINEER, &first);
    let sentence = "pirani.safe-value was 0 mbar when it was armed and is 2 mbar now";
    assert_eq!((status, &refused["problem"]), (409, &json!(sentence)));
    assert_eq!(trail(&desk).last().unwrap()[5], format!("not sent: {sentence}"));
}

#[test]
fn nothing_armed_survives_a_change_of_mastership() {
    let desk = Desk::new(1e-6);
    let (status, refused) = desk.arm(OPERATOR, &json!({ "command": DEGAS }));
    assert_eq!((status, &refused["problem"]), (409, &json!("nobody has the mastership: ask for it first")));
    desk.masters(OPERATOR);
    let (_, armed) = desk.arm(OPERATOR, &json!({ "command": DEGAS }));
    let (status, mastership) = desk.post(ENGINEER, "/api/mastership/take-over", None);
    assert_eq!((status, &mastership["holder"]), (200, &json!("Erna")));
    let (status, refused) = desk.fire(OPERATOR, &armed);
    let sentence = "the order was disarmed when the mastership changed hands: arm it again";
    assert_eq!((status, &refused["problem"]), (409, &json!(sentence)));
    let (status, refused) = desk.arm(OPERATOR, &json!({ "command": DEGAS }));
    assert_eq!((status, &refused["problem"]), (409, &json!("Erna has the mastership")));
    assert_eq!(desk.post(OPERATOR, "/api/mastership/ask", None).1["asked_by"], "Otto");
    assert_eq!(desk.post(ENGINEER, "/api/mastership/grant", None).1["holder"], "Otto");
    let sentences: Vec<_> = trail(&desk).into_iter().map(|row| row[5].clone()).collect();
    assert_eq!(
        sentences,
        [
            "has taken the mastership, which was free",
            "has taken the mastership over from Otto",
            "has asked for the mastership",
            "has granted the mastership to Otto"
        ]
    );
}

#[test]
fn of_many_who_ask_at_once_one_has_it() {
    let desk = Desk::new(1e-6);
    for _ in 0..50 {
        let barrier = Arc::new(Barrier::new(8));
        let askers: Vec<_> = (0..8)
            .map(|number| {
                let (plant, barrier) = (Arc::clone(&desk.plant), Arc::clone(&barrier));
                let person = User { name: Arc::from(format!("asker {number}")), role: Role::Operator };
                std::thread::spawn(move || {
                    barrier.wait();
                    let actor = Actor { user: person, peer: None };
                    control::change_authority(&plant, &actor, AuthorityAction::Request, Instant::now()).ok();
                    actor
                })
            })
            .collect();
        let askers: Vec<_> = askers.into_iter().map(|asker| asker.join().unwrap()).collect();
        let released = askers.iter().filter(|asker| {
            control::change_authority(&desk.plant, asker, AuthorityAction::Release, Instant::now()).is_ok()
        });
        assert_eq!(released.count(), 1);
    }
    assert!(desk.plant.recorder().flush());
    let (_, rows) = desk.get(VIEWER, "/api/audit?most=1000");
    let count = |words: &str| rows.as_array().unwrap().iter().filter(|row| row["outcome"] == words).count();
    assert_eq!((count("has taken the mastership, which was free"), count("has released the mastership")), (50, 50));
}

#[test]
fn a_gauge_that_is_gone_between_arming_and_firing_is_told() {
    let desk = Desk::new(1e-6);
    desk.masters(OPERATOR);
    let (_, armed) = desk.arm(OPERATOR, &json!({ "command": DEGAS }));
    desk.outside(|scene| scene.devices_mut().for_each(|device| device.set_power(false)));
    let (status, refused) = desk.fire(OPERATOR, &armed);
    assert_eq!(status, 409, "{refused}");
    assert!(trail(&desk).last().unwrap()[5].starts_with("not sent: "), "{:#?}", trail(&desk));
}

#[test]
fn what_the_gauge_refuses_is_told_with_its_reason() {
    let desk = Desk::new(1e-6);
    desk.masters(ENGINEER);
    let (status, armed) = desk.arm(ENGINEER, &wish("ba.emission-current", "0.5"));
    assert_eq!(status, 200, "{armed}");
    let (status, refused) = desk.fire(ENGINEER, &armed);
    assert_eq!(status, 409, "{refused}");
    let sentence = refused["problem"].as_str().unwrap();
    assert!(
        sentence.contains("writing was refused with ") && sentence.contains("code 2: lower or upper"),
        "{sentence}"
    );
    assert!(trail(&desk).last().unwrap()[5].starts_with("refused: "), "{:#?}", trail(&desk));
}

#[test]
fn without_a_trail_nothing_is_sent() {
    let desk = Desk::new(1e-6);
    desk.masters(OPERATOR);
    let (_, armed) = desk.arm(OPERATOR, &json!({ "command": DEGAS }));
    // Somebody else writes into the file and does not end.
    let other = rusqlite::Connection::open(desk.file()).unwrap();
    other.execute_batch("BEGIN IMMEDIATE").unwrap();
    let (status, refused) = desk.fire(OPERATOR, &armed);
    assert_eq!(status, 503, "{refused}");
    assert!(
        refused["problem"]
            .as_str()
            .unwrap()
            .starts_with("nothing was sent, because the audit trail cannot be written: ")
    );
    other.execute_batch("ROLLBACK").unwrap();
    assert!(!desk.is_degassing());
    assert!(trail(&desk).iter().all(|row| row[0] == "mastership"), "{:#?}", trail(&desk));
}

#[test]
fn what_would_confuse_the_station_is_barred() {
    let desk = Desk::new(1e-6);
    desk.masters(ENGINEER);
    for target in ["pirani.data-units", "pirani.data-type"] {
        let (status, refused) = desk.arm(ENGINEER, &wish(target, "Torr"));
        assert_eq!(status, 409, "{refused}");
        assert!(refused["problem"].as_str().unwrap().contains("profivac write"), "{refused}");
    }
}

#[test]
fn what_makes_no_sense_is_answered_with_what_would() {
    let desk = Desk::new(1e-6);
    desk.masters(ENGINEER);
    for (wish, status, part) in [
        (wish("pirani.safe-state", "never"), 400, "expected one of zero, full-scale, hold-last-value"),
        (wish("pirani.safe-valve", "1"), 400, "did you mean"),
        (json!({ "command": "explode" }), 400, "bcg450 has no command \"explode\""),
        (json!({ "target": SAFE_VALUE }), 400, "expected either a command, or a target and its value"),
        (json!({ "password": "orchid ladder" }), 400, "expected JSON as /api/openapi.json describes it"),
        (wish("pirani.process-value", "1"), 400, "read-only"),
        (wish("ba.hot-cathode-block-state-command", "explode"), 400, "expected one of inactive, degas-off"),
    ] {
        let (found, refused) = desk.arm(ENGINEER, &wish);
        assert_eq!(found, status, "{refused}");
        assert!(refused["problem"].as_str().unwrap().contains(part), "{refused}");
        assert!(!refused.to_string().contains("orchid"), "{refused}");
    }
    assert_eq!(desk.post(ENGINEER, "/api/gauges/nobody/arm", Some(&wish(SAFE_VALUE, "1"))).0, 404);
    let (status, armed) = desk.arm(ENGINEER, &json!({ "target": SAFE_VALUE, "value": 0.25 }));
    assert_eq!((status, &armed["after"]), (200, &json!("0.25 mbar")));
}

#[test]
fn the_trail_is_a_table_that_nobody_changes() {
    let desk = Desk::new(1e-6);
    let formula = ("=1+1", Role::Engineer);
    desk.masters(formula);
    desk.post(formula, "/api/mastership/release", None);
    desk.masters(ENGINEER);
    let (_, armed) = desk.arm(ENGINEER, &wish(SAFE_VALUE, "1"));
    assert_eq!(desk.fire(ENGINEER, &armed).0, 200);
    let table = desk.text("/api/audit.csv");
    let mut lines = table.lines();
    assert!(lines.next().unwrap().starts_with("id,time,what,of,who,role,peer,gauge,segment,address,target,"));
    assert!(lines.next().unwrap().contains(",mastership,,\"'=1+1\",engineer,"), "no formula: {table}");
    assert!(table.contains(",\"0 mbar\",\"1 mbar\",\"done\","), "{table}");
    let (_, rows) = desk.get(VIEWER, "/api/audit?gauge=chamber&who=Erna&most=1");
    assert_eq!((rows.as_array().unwrap().len(), &rows[0]["what"]), (1, &json!("outcome")));
    assert_eq!(desk.get(VIEWER, "/api/audit?who=Otto").1, json!([]));
    assert_eq!(desk.get(VIEWER, "/api/audit?most=0").0, 400);
    let other = rusqlite::Connection::open(desk.file()).unwrap();
    for sql in ["UPDATE audit SET user_name = 'Eve'", "DELETE FROM audit"] {
        let refused = other.execute_batch(sql).unwrap_err().to_string();
        assert!(refused.contains("the audit trail is not "), "{refused}");
    }
}

#[test]
fn the_others_go_on_while_something_is_done() {
    let desk = Desk::new(1e-6);
    desk.masters(ENGINEER);
    for value in ["1", "2", "3"] {
        let (_, armed) = desk.arm(ENGINEER, &wish(SAFE_VALUE, value));
        assert_eq!(desk.fire(ENGINEER, &armed).0, 200);
    }
    let lost = desk.ask_outside(|scene| scene.master().unwrap().counters(5).unwrap().lost);
    assert_eq!(lost, 0);
    until("all exchange data", || (desk.gauge().standing == BusStationState::Exchanging).then_some(()));
}

#[test]
fn what_was_fired_is_written_down_also_when_the_browser_is_gone() {
    let desk = Desk::new(1e-6);
    desk.masters(ENGINEER);
    let (_, armed) = desk.arm(ENGINEER, &wish(SAFE_VALUE, "1"));
    desk.fire_and_leave(ENGINEER, &armed, || (trail(&desk).last()?[0] == "fired").then_some(()));
    until("its outcome", || trail(&desk).last().filter(|row| row[5] == "done").cloned());
}

#[test]
fn a_body_that_is_none_is_answered() {
    let desk = Desk::new(1e-6);
    let path = "/api/gauges/chamber/arm";
    for body in ["{", "", "[]", "{\"command\": 1}"] {
        assert_eq!(desk.send_as(ENGINEER, "POST", path, "application/json", body.to_owned()).0, 400, "{body}");
    }
}

#[test]
fn what_was_fired_before_the_mastership_was_lost_is_not_sent_after_it() {
    let desk = Desk::new(1e-6);
    desk.masters(OPERATOR);
    let person = User { name: Arc::from(OPERATOR.0), role: OPERATOR.1 };
    let actor = Actor { user: person, peer: None };
    let wish = serde_json::from_value(json!({ "command": DEGAS })).unwrap();
    let order = control::arm(&desk.plant, &actor, "chamber", &wish).unwrap();
    control::change_authority(&desk.plant, &actor, AuthorityAction::Release, Instant::now()).unwrap();
    let late = desk.plant.execute(order, Instant::now() + std::time::Duration::from_secs(60)).unwrap_err();
    assert_eq!(late.outcome(), "not sent: Otto has lost the mastership before it was sent");
    assert!(!desk.is_degassing());
}

#[test]
fn who_looks_leaves_room_for_who_acts() {
    let desk = Desk::new(1e-6);
    desk.masters(OPERATOR);
    let questions = desk.plant.accept_requests(&desk.gauge().segment);
    std::thread::scope(|scope| {
        let (done, busy) = std::sync::mpsc::channel();
        for _ in 0..10 {
            let (desk, done) = (&desk, done.clone());
            scope.spawn(move || done.send(desk.plant.blocks("chamber").is_err()).unwrap());
        }
        (0..8).for_each(|_| assert!(busy.recv_timeout(std::time::Duration::from_secs(30)).unwrap(), "only two wait"));
        let arm = scope.spawn(|| desk.arm(OPERATOR, &json!({ "command": DEGAS })));
        for _ in 0..2 {
            let Ok(SegmentRequest::Blocks(_, answer)) = questions.recv() else {
                panic!("expected those who look first")
            };
            answer.send(Ok(Vec::new())).unwrap();
        }
        let Ok(SegmentRequest::Preview(_, _, answer)) = questions.recv() else {
            panic!("expected what is to be armed")
        };
        answer.send(Err(OperationError::Unavailable("asked".to_owned()))).unwrap();
        assert_eq!(arm.join().unwrap().1["problem"], "asked");
    });
}
