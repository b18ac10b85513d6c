//! Sessions after a restart of the station.

use crate::security::test_station::{PASSWORD, Page, Request, TIMEOUT, TestStation};
use crate::until::pause;
use profivac_web_server::auth::Role;
use profivac_web_server::auth::password::Hash;
use profivac_web_server::auth::users::Users;
use serde_json::{Value, json};
use std::fs;
use std::os::unix::fs::PermissionsExt;
use std::path::Path;
use std::time::Instant;

/// The file of the sessions, beside the users' file.
const FILE: &str = "users.toml-sessions";

fn status(station: &TestStation, page: &Page) -> u16 {
    Request::get("/api/gauges").cookie(page).to(station).status
}

/// Waits until the station has stored its sessions.
fn stored(station: &TestStation) -> String {
    let end = Instant::now() + TIMEOUT;
    loop {
        if let Ok(text) = fs::read_to_string(station.file(FILE)) {
            return text;
        }
        assert!(Instant::now() < end, "the sessions are not stored");
        pause();
    }
}

#[test]
fn a_session_continues_after_a_restart_with_its_token_and_without_control_authority() {
    let station = TestStation::new();
    let ada = station.login("ada");
    let request = |station: &TestStation, page: &Page| {
        Request::post("/api/control-authority/request", &json!(null)).by(page).to(station).status
    };
    assert_eq!(request(&station, &ada), 200);
    let station = station.restarted(|_| {});
    let ada = ada.at(&station);
    let session = Request::get("/api/session").by(&ada).to(&station).json();
    assert_eq!((&session["name"], &session["token"]), (&json!("ada"), &json!(ada.token)));
    let control = Request::get("/api/control-authority").by(&ada).to(&station).json();
    assert_eq!(control["holder"], Value::Null);
    // The open page goes on with the token that it has.
    assert_eq!(request(&station, &ada), 200);
    station.access_events("sessions that continue after the restart: 1");
}

#[test]
fn a_logout_holds_after_a_power_cut() {
    let station = TestStation::new();
    let (page, other) = (station.login("ada"), station.login("ada"));
    stored(&station);
    assert_eq!(Request::post("/api/logout", &json!(null)).by(&page).to(&station).status, 204);
    // What the disk has as soon as the logout is answered.
    let kept = stored(&station);
    let station = station.restarted(|folder| fs::write(folder.join(FILE), kept).unwrap());
    assert_eq!((status(&station, &page.at(&station)), status(&station, &other.at(&station))), (401, 200));
}

#[test]
fn a_session_whose_user_changed_while_the_station_was_stopped_does_not_continue() {
    let changes: [fn(&mut Users); 3] = [
        |users: &mut Users| users.remove("olga").unwrap(),
        |users: &mut Users| users.set_role("olga", Role::Engineer).unwrap(),
        |users: &mut Users| users.get_mut("olga").unwrap().password = Hash::of(PASSWORD).unwrap(),
    ];
    for change in changes {
        let station = TestStation::new();
        let (olga, vera) = (station.login("olga"), station.login("vera"));
        let changed = |users: &mut Users| {
            change(users);
            Ok(())
        };
        let station = station.restarted(|folder| Users::change(&folder.join("users.toml"), changed).unwrap());
        assert_eq!((status(&station, &olga.at(&station)), status(&station, &vera.at(&station))), (401, 200));
    }
}

/// Moves the time at which the sessions were stored back by half an hour.
fn age(folder: &Path) {
    let file = folder.join(FILE);
    let mut contents: Value = serde_json::from_str(&fs::read_to_string(&file).unwrap()).unwrap();
    contents["written_s"] = json!(contents["written_s"].as_u64().unwrap() - 30 * 60);
    fs::write(&file, contents.to_string()).unwrap();
}

#[test]
fn a_session_expires_while_the_station_is_stopped_and_that_of_a_wall_display_does_not() {
    let station = TestStation::new();
    station.change(|users| users.add_wall("screen", Hash::of(PASSWORD).unwrap()).unwrap());
    station.access_events("the user screen was added as viewer");
    let answer = Request::login("screen", PASSWORD).to(&station);
    assert!(answer.header("set-cookie").unwrap().ends_with("; Max-Age=31536000"), "{answer:?}");
    let (screen, vera) = (Page::of(&answer), station.login("vera"));
    let station = station.restarted(age);
    let (screen, vera) = (screen.at(&station), vera.at(&station));
    assert_eq!((status(&station, &vera), status(&station, &screen)), (401, 200));
    station.change(|users| users.remove("screen").unwrap());
    station.access_events("the user screen was removed");
    assert_eq!(status(&station, &screen), 401);
}

#[test]
fn a_thief_of_the_file_of_the_sessions_has_no_session() {
    let station = TestStation::new();
    let page = station.login("ada");
    let text = stored(&station);
    assert_eq!(fs::metadata(station.file(FILE)).unwrap().permissions().mode() & 0o777, 0o600);
    let (name, id) = page.cookie.split_once('=').unwrap();
    assert!(!text.contains(id) && !text.contains(&page.token) && !text.contains("argon2"), "{text}");
    let digests = text.split('"').filter(|part| part.len() == 64);
    for digest in digests.inspect(|digest| assert_ne!(*digest, id)) {
        let thief = Page { cookie: format!("{name}={digest}"), token: digest.to_owned() };
        assert_eq!(status(&station, &thief), 401);
        let owner = Page { token: digest.to_owned(), ..page.clone() };
        assert_eq!(Request::post("/api/logout", &json!(null)).by(&owner).to(&station).status, 403);
    }
}

#[test]
fn without_a_usable_file_of_the_sessions_users_log_in_again() {
    let damage: [fn(&Path); 4] = [
        |file: &Path| fs::remove_file(file).unwrap(),
        |file: &Path| fs::write(file, "{").unwrap(),
        |file: &Path| fs::set_permissions(file, fs::Permissions::from_mode(0o644)).unwrap(),
        // Another station with the same users has written it.
        |file: &Path| {
            let text = fs::read_to_string(file).unwrap();
            assert!(text.contains("\"127.0.0.1:0\""), "{text}");
            fs::write(file, text.replace("127.0.0.1:0", "127.0.0.1:9090")).unwrap();
        },
    ];
    for damage in damage {
        let station = TestStation::new();
        let page = station.login("vera");
        let station = station.restarted(|folder| damage(&folder.join(FILE)));
        assert_eq!(status(&station, &page.at(&station)), 401);
        assert_eq!(status(&station, &station.login("vera")), 200);
    }
}

#[test]
fn sessions_begin_although_they_cannot_be_stored() {
    // A folder of this name cannot be replaced by a file.
    let station = TestStation::with(|_, folder| fs::create_dir(folder.path().join(FILE)).unwrap());
    station.access_events("every user logs in again");
    let page = station.login("vera");
    station.access_events("the sessions cannot be stored");
    assert_eq!((status(&station, &page), status(&station, &station.login("ada"))), (200, 200));
}
