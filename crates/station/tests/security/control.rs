//! Users who lose their session or their role while they have control authority: it is released, and armed commands are never sent.

use crate::security::test_station::{Answer, Page, Request, TestStation};
use crate::support;
use crate::support::memory_station::MemoryStation;
use profivac_web_server::auth::Role;
use serde_json::{Value, json};

/// A gauge at a pressure that permits degassing, and a station with users around it.
fn acting_station() -> (MemoryStation, TestStation) {
    let gauge = MemoryStation::new(1e-6);
    let station = TestStation::over(&gauge.services);
    (gauge, station)
}

fn post(station: &TestStation, page: &Page, path: &str, body: &Value) -> Answer {
    Request::post(path, body).by(page).to(station)
}

/// Gets control authority and arms a degas. Returns the path that executes it.
fn armed(station: &TestStation, page: &Page) -> String {
    assert_eq!(post(station, page, "/api/control-authority/request", &json!(null)).status, 200);
    let armed = post(station, page, "/api/gauges/chamber/arm", &json!({ "command": "ba.degas-on" }));
    assert_eq!(armed.status, 200, "{armed:?}");
    format!("/api/armed-commands/{}/execute", armed.json()["id"].as_str().unwrap())
}

/// User and outcome of the last audit entry about control authority.
fn last(station: &TestStation, reader: &Page) -> (String, String) {
    assert!(station.services.recorder().flush());
    let rows = Request::get("/api/audit").by(reader).to(station).json();
    let row = rows.as_array().unwrap().iter().find(|row| row["action"] == "control-authority").unwrap().clone();
    (row["user"].as_str().unwrap().to_owned(), row["outcome"].as_str().unwrap().to_owned())
}

fn until_free(station: &TestStation) {
    support::until("control authority is free", || station.services.control().holder().is_none().then_some(()));
}

#[test]
fn a_user_who_logs_out_everywhere_loses_control_authority_and_armed_commands() {
    let (gauge, station) = acting_station();
    let (one, other, vera) = (station.login("olga"), station.login("olga"), station.login("vera"));
    let execute = armed(&station, &one);
    assert_eq!(post(&station, &one, "/api/logout", &json!(null)).status, 204);
    assert!(station.services.control().holder().is_some(), "the user has another session");
    assert_eq!(post(&station, &other, "/api/logout", &json!(null)).status, 204);
    assert_eq!(station.services.control().holder(), None);
    let left = ("olga".to_owned(), "lost control: the last session ended".to_owned());
    assert_eq!(last(&station, &vera), left);
    let back = station.login("olga");
    assert_eq!(post(&station, &back, "/api/control-authority/request", &json!(null)).status, 200);
    let refused = post(&station, &back, &execute, &json!(null));
    assert_eq!(refused.status, 409, "{refused:?}");
    assert!(refused.problem().contains("was disarmed when its user lost control"), "{refused:?}");
    assert!(!gauge.is_degassing());
}

#[test]
fn a_login_as_another_user_releases_control_authority() {
    let (_gauge, station) = acting_station();
    let olga = station.login("olga");
    armed(&station, &olga);
    assert_eq!(Request::login("vera", crate::security::test_station::PASSWORD).cookie(&olga).to(&station).status, 200);
    assert_eq!(station.services.control().holder(), None);
}

#[test]
fn a_user_who_is_removed_or_gets_another_role_executes_no_armed_command() {
    let (gauge, station) = acting_station();
    let (ada, olga, vera) = (station.login("ada"), station.login("olga"), station.login("vera"));
    let execute = armed(&station, &olga);
    station.change(|users| users.remove("olga").unwrap());
    until_free(&station);
    assert_eq!(last(&station, &vera).1, "lost control: the last session ended");
    assert_eq!(post(&station, &olga, &execute, &json!(null)).status, 401);
    let execute = armed(&station, &ada);
    station.change(|users| users.get_mut("ada").unwrap().role = Role::Viewer);
    until_free(&station);
    assert_eq!(last(&station, &vera), ("ada".to_owned(), "lost control: the role changed".to_owned()));
    let refused = post(&station, &ada, &execute, &json!(null));
    assert_eq!(refused.status, 409, "{refused:?}");
    assert!(!gauge.is_degassing());
}
