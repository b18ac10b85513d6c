//! Those who act and are not who they were any more: what they held is free, and what they armed is never sent.

use crate::bench;
use crate::desk::{Answer, Ask, Desk, Page};
use profivac_station::auth::Role;
use profivac_station::control;
use serde_json::{Value, json};

/// A gauge in a vacuum in which it may be degassed, and a station around it with users.
fn plant() -> (bench::Desk, Desk) {
    let gauge = bench::Desk::new(1e-6);
    let desk = Desk::over(&gauge.plant);
    (gauge, desk)
}

fn post(desk: &Desk, page: &Page, path: &str, body: &Value) -> Answer {
    Ask::post(path, body).by(page).to(desk)
}

/// Somebody has the mastership and has armed a degas. The path by which it is fired.
fn armed(desk: &Desk, page: &Page) -> String {
    assert_eq!(post(desk, page, "/api/mastership/ask", &json!(null)).status, 200);
    let armed = post(desk, page, "/api/gauges/chamber/arm", &json!({ "command": "ba.degas-on" }));
    assert_eq!(armed.status, 200, "{armed:?}");
    format!("/api/orders/{}/fire", armed.json()["order"].as_str().unwrap())
}

/// What the audit trail says last about the mastership.
fn last(desk: &Desk, reader: &Page) -> (String, String) {
    assert!(desk.plant.recorder().flush());
    let rows = Ask::get("/api/audit").by(reader).to(desk).json();
    let row = rows.as_array().unwrap().iter().find(|row| row["what"] == "mastership").unwrap().clone();
    (row["who"].as_str().unwrap().to_owned(), row["outcome"].as_str().unwrap().to_owned())
}

fn until_free(desk: &Desk) {
    bench::until("the mastership is free", || control::holder(&desk.plant).is_none().then_some(()));
}

#[test]
fn who_logs_out_everywhere_has_no_mastership_and_nothing_armed() {
    let (gauge, desk) = plant();
    let (one, other, vera) = (desk.login("olga"), desk.login("olga"), desk.login("vera"));
    let fire = armed(&desk, &one);
    assert_eq!(post(&desk, &one, "/api/logout", &json!(null)).status, 204);
    assert!(control::holder(&desk.plant).is_some(), "another window of hers is open");
    assert_eq!(post(&desk, &other, "/api/logout", &json!(null)).status, 204);
    assert_eq!(control::holder(&desk.plant), None);
    let left = ("olga".to_owned(), "has left, and the mastership is free".to_owned());
    assert_eq!(last(&desk, &vera), left);
    let back = desk.login("olga");
    assert_eq!(post(&desk, &back, "/api/mastership/ask", &json!(null)).status, 200);
    let refused = post(&desk, &back, &fire, &json!(null));
    assert_eq!(refused.status, 409, "{refused:?}");
    assert!(refused.problem().contains("was disarmed when the mastership changed hands"), "{refused:?}");
    assert!(!gauge.is_degassing());
}

#[test]
fn who_logs_in_as_somebody_else_leaves_the_mastership() {
    let (_gauge, desk) = plant();
    let olga = desk.login("olga");
    armed(&desk, &olga);
    assert_eq!(Ask::login("vera", crate::desk::PASSWORD).cookie(&olga).to(&desk).status, 200);
    assert_eq!(control::holder(&desk.plant), None);
}

#[test]
fn who_is_removed_or_has_another_role_fires_nothing_that_they_armed() {
    let (gauge, desk) = plant();
    let (ada, olga, vera) = (desk.login("ada"), desk.login("olga"), desk.login("vera"));
    let fire = armed(&desk, &olga);
    desk.change(|users| users.remove("olga").unwrap());
    until_free(&desk);
    assert_eq!(last(&desk, &vera).1, "has left, and the mastership is free");
    assert_eq!(post(&desk, &olga, &fire, &json!(null)).status, 401);
    let fire = armed(&desk, &ada);
    desk.change(|users| users.get_mut("ada").unwrap().role = Role::Viewer);
    until_free(&desk);
    assert_eq!(last(&desk, &vera), ("ada".to_owned(), "has another role, and the mastership is free".to_owned()));
    let refused = post(&desk, &ada, &fire, &json!(null));
    assert!([403, 409].contains(&refused.status), "{refused:?}");
    assert!(!gauge.is_degassing());
}
