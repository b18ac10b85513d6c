//! Users who lose their session or their role while they have control authority: it is released, and armed commands are never sent.

use crate::desk::{Answer, Ask, Desk, Page};
use crate::support;
use crate::support::memory_station::MemoryStation;
use profivac_station::auth::Role;
use serde_json::{Value, json};

/// A gauge at a pressure that permits degassing, and a station with users around it.
fn plant() -> (MemoryStation, Desk) {
    let gauge = MemoryStation::new(1e-6);
    let desk = Desk::over(&gauge.services);
    (gauge, desk)
}

fn post(desk: &Desk, page: &Page, path: &str, body: &Value) -> Answer {
    Ask::post(path, body).by(page).to(desk)
}

/// Gets control authority and arms a degas. Returns the path that executes it.
fn armed(desk: &Desk, page: &Page) -> String {
    assert_eq!(post(desk, page, "/api/mastership/ask", &json!(null)).status, 200);
    let armed = post(desk, page, "/api/gauges/chamber/arm", &json!({ "command": "ba.degas-on" }));
    assert_eq!(armed.status, 200, "{armed:?}");
    format!("/api/orders/{}/fire", armed.json()["id"].as_str().unwrap())
}

/// User and outcome of the last audit entry about control authority.
fn last(desk: &Desk, reader: &Page) -> (String, String) {
    assert!(desk.plant.recorder().flush());
    let rows = Ask::get("/api/audit").by(reader).to(desk).json();
    let row = rows.as_array().unwrap().iter().find(|row| row["action"] == "control-authority").unwrap().clone();
    (row["user"].as_str().unwrap().to_owned(), row["outcome"].as_str().unwrap().to_owned())
}

fn until_free(desk: &Desk) {
    support::until("control authority is free", || desk.plant.control().holder().is_none().then_some(()));
}

#[test]
fn a_user_who_logs_out_everywhere_loses_control_authority_and_armed_commands() {
    let (gauge, desk) = plant();
    let (one, other, vera) = (desk.login("olga"), desk.login("olga"), desk.login("vera"));
    let execute = armed(&desk, &one);
    assert_eq!(post(&desk, &one, "/api/logout", &json!(null)).status, 204);
    assert!(desk.plant.control().holder().is_some(), "the user has another session");
    assert_eq!(post(&desk, &other, "/api/logout", &json!(null)).status, 204);
    assert_eq!(desk.plant.control().holder(), None);
    let left = ("olga".to_owned(), "lost control: the last session ended".to_owned());
    assert_eq!(last(&desk, &vera), left);
    let back = desk.login("olga");
    assert_eq!(post(&desk, &back, "/api/mastership/ask", &json!(null)).status, 200);
    let refused = post(&desk, &back, &execute, &json!(null));
    assert_eq!(refused.status, 409, "{refused:?}");
    assert!(refused.problem().contains("was disarmed when control changed hands"), "{refused:?}");
    assert!(!gauge.is_degassing());
}

#[test]
fn a_login_as_another_user_releases_control_authority() {
    let (_gauge, desk) = plant();
    let olga = desk.login("olga");
    armed(&desk, &olga);
    assert_eq!(Ask::login("vera", crate::desk::PASSWORD).cookie(&olga).to(&desk).status, 200);
    assert_eq!(desk.plant.control().holder(), None);
}

#[test]
fn a_user_who_is_removed_or_gets_another_role_executes_no_armed_command() {
    let (gauge, desk) = plant();
    let (ada, olga, vera) = (desk.login("ada"), desk.login("olga"), desk.login("vera"));
    let execute = armed(&desk, &olga);
    desk.change(|users| users.remove("olga").unwrap());
    until_free(&desk);
    assert_eq!(last(&desk, &vera).1, "lost control: the last session ended");
    assert_eq!(post(&desk, &olga, &execute, &json!(null)).status, 401);
    let execute = armed(&desk, &ada);
    desk.change(|users| users.get_mut("ada").unwrap().role = Role::Viewer);
    until_free(&desk);
    assert_eq!(last(&desk, &vera), ("ada".to_owned(), "lost control: the role changed".to_owned()));
    let refused = post(&desk, &ada, &execute, &json!(null));
    assert!([403, 409].contains(&refused.status), "{refused:?}");
    assert!(!gauge.is_degassing());
}
