//! Logins, passwords and the event log.

use crate::security::test_station::{PASSWORD, Page, Request, TestStation};
use profivac_web_server::auth::password::Hash;
use profivac_web_server::auth::rate_limit::{RateLimit, RateLimits};
use profivac_web_server::auth::users::Users;
use profivac_web_server::auth::{Access, Role};
use profivac_web_server::server::Limits;
use serde_json::json;
use std::fs;
use std::io::{Read, Write};
use std::net::SocketAddr;
use std::os::unix::fs::PermissionsExt;
use std::time::Duration;

#[test]
fn the_api_answers_nothing_before_login() {
    let station = TestStation::new();
    let description: serde_json::Value = serde_json::from_str(&profivac_station::api::description()).unwrap();
    let paths: Vec<_> =
        description["paths"].as_object().unwrap().keys().map(|path| path.replace("{name}", "a")).collect();
    for path in paths.iter().map(String::as_str).chain(["/api/openapi.json", "/api/no/such/thing", "/api/"]) {
        let (get, post) = match path {
            "/api/session" => (200, 401),
            "/api/login" | "/api/openid/login" => (405, 400),
            "/api/openid/begin" => (405, 404),
            _ => (401, 401),
        };
        assert_eq!(station.get(path).status, get, "{path}");
        assert_eq!(Request::post(path, &json!({})).to(&station).status, post, "{path}");
    }
    let anonymous = station.get("/api/session").json();
    let expected = json!({
        "name": "anonymous", "role": "viewer", "token": "", "login": "logged-out", "has_password": false, "provider": null,
    });
    assert_eq!(anonymous, expected);
    assert_eq!(station.get("/").status, 200, "the page itself needs no login");
}

#[test]
fn a_session_has_the_name_and_the_role_of_its_user() {
    let station = TestStation::new();
    for (name, role) in [("ada", "engineer"), ("olga", "operator"), ("vera", "viewer")] {
        let page = station.login(name);
        let session = Request::get("/api/session").by(&page).to(&station).json();
        let expected = json!({
            "name": name, "role": role, "token": page.token, "login": "logged-in", "has_password": true, "provider": null,
        });
        assert_eq!(session, expected);
    }
    let events = station.access_events("vera (viewer) logged in from 127.0.0.1");
    assert_eq!(events.len(), 3);
}

#[test]
fn a_station_has_no_default_users() {
    let station = TestStation::open(Role::Viewer);
    for name in ["root", "admin", "engineer", "profivac", "demo", "anonymous", ""] {
        let refused = Request::login(name, name).header(&format!("x-csrf-token: {}", token(&station))).to(&station);
        assert_eq!((refused.status, refused.problem().starts_with("this station has no users")), (404, true), "{name}");
    }
}

fn token(station: &TestStation) -> String {
    station.get("/api/session").json()["token"].as_str().unwrap().to_owned()
}

#[test]
fn a_wrong_name_and_a_wrong_password_get_the_same_answer() {
    let station = TestStation::new();
    let answers = [("ada", "wrong"), ("unknown", "wrong"), ("unknown", PASSWORD), ("", "")];
    let answers = answers.map(|(name, password)| Request::login(name, password).to(&station));
    for answer in &answers {
        assert_eq!((answer.status, &answer.body), (401, &answers[0].body));
        assert_eq!(answer.headers.len(), answers[0].headers.len());
        assert_eq!(answer.header("set-cookie"), None);
    }
}

#[test]
fn a_password_is_compared_exactly_as_typed() {
    let station = TestStation::new();
    let long = format!("{PASSWORD}, and a very long sentence after it: äöü 气压计 {}", "x".repeat(300));
    station.change(|users| users.get_mut("vera").unwrap().password = Hash::of(&long).unwrap());
    station.access_events("the password of vera was changed");
    assert_eq!(Request::login("vera", &long).to(&station).status, 200);
    for near in [long[..long.len() - 1].to_owned(), format!("{long} "), format!(" {long}"), long.to_uppercase()] {
        assert_eq!(Request::login("vera", &near).to(&station).status, 401);
    }
}

#[test]
fn a_user_changes_the_own_password_with_the_current_one() {
    let station = TestStation::new();
    let (page, other) = (station.login("vera"), station.login("vera"));
    let change = |page: &Page, current: &str, new: &str| {
        Request::post("/api/password", &json!({ "current": current, "new": new })).by(page).to(&station)
    };
    let new = "orchid ladder seventeen";
    assert_eq!(change(&page, "wrong", new).status, 403);
    for unfit in ["short", "password1", "1234567890", "verahall", "vera1234", "qwertyuiop"] {
        let refused = change(&page, PASSWORD, unfit);
        assert_eq!(refused.status, 400, "{unfit}: {}", refused.body);
    }
    let changed = change(&page, PASSWORD, new);
    assert_eq!(changed.status, 200, "{changed:?}");
    let fresh = Page::of(&changed);
    assert_ne!((&fresh.cookie, &fresh.token), (&page.cookie, &page.token));
    for (page, status) in [(&fresh, 200), (&page, 401), (&other, 401)] {
        assert_eq!(Request::get("/api/gauges").cookie(page).to(&station).status, status);
    }
    assert_eq!(Request::login("vera", PASSWORD).to(&station).status, 401);
    assert_eq!(Request::login("vera", new).to(&station).status, 200);
    station.access_events("the password of vera was changed");
}

#[test]
fn an_address_that_guesses_gets_429_with_the_time_to_wait() {
    // One login an hour: on a slow computer twenty password checks take long.
    let rate_limits = RateLimits { logins: RateLimit::new(20, Duration::from_secs(3600)), ..RateLimits::default() };
    let station = TestStation::with(|setup, _| setup.limits = Limits { rate_limits, ..Limits::default() });
    let page = station.login("vera");
    let answers: Vec<_> =
        (0..24).map(|number| Request::login("ada", &format!("guess {number}")).to(&station)).collect();
    assert!(answers.iter().take(19).all(|answer| answer.status == 401));
    let last = answers.last().unwrap();
    assert_eq!(last.status, 429);
    let wait: u64 = last.header("retry-after").unwrap().parse().unwrap();
    assert!((3_000..=3_601).contains(&wait), "{wait}");
    let right = Request::login("ada", PASSWORD).to(&station);
    assert_eq!(right.status, 429, "an attacker does not learn that a guess is right");
    assert_eq!(Request::get("/api/gauges").by(&page).to(&station).status, 200, "an existing session continues");
    station.access_events("too many logins from 127.0.0.1");
}

#[test]
fn the_event_log_holds_no_secret() {
    let station = TestStation::new();
    let page = station.login("ada");
    let typed_into_the_wrong_field = "orchid ladder seventeen";
    Request::login(typed_into_the_wrong_field, "").to(&station);
    Request::login("ada", typed_into_the_wrong_field).to(&station);
    Request::login("evil\r\nname\u{202e}\u{1b}[31m", "wrong").to(&station);
    Request::post("/api/logout", &json!(null)).cookie(&page).header("x-csrf-token: nonsense").to(&station);
    Request::post("/api/logout", &json!(null)).by(&page).to(&station);
    let events = station.access_events("ada logged out from 127.0.0.1");
    assert_eq!(
        events,
        [
            "ada (engineer) logged in from 127.0.0.1",
            "login from 127.0.0.1 refused: unknown name",
            "login of ada from 127.0.0.1 refused: wrong password",
            "login from 127.0.0.1 refused: unknown name",
            "refused for ada at 127.0.0.1, \"/api/logout\": expected the header x-csrf-token with the token that /api/session gives",
            "ada logged out from 127.0.0.1",
        ]
    );
}

#[test]
fn a_users_file_that_is_wrong_or_open_to_others_changes_nothing() {
    use std::os::unix::fs::PermissionsExt;
    let station = TestStation::new();
    let file = station.file("users.toml");
    let page = station.login("ada");
    // Renamed, as an editor does it: an empty file would end the sessions of all users.
    let written = station.file("written");
    fs::write(&written, "[[user]]\nname = \"eve\"\nrole = \"engineer\"\npassword = \"orchid ladder\"\n").unwrap();
    fs::set_permissions(&written, fs::Permissions::from_mode(0o600)).unwrap();
    fs::rename(&written, &file).unwrap();
    let events = station.access_events("the users stay as they were");
    assert!(events.last().unwrap().ends_with("line 4, column 12 of their file is wrong"), "{events:?}");
    fs::set_permissions(&file, fs::Permissions::from_mode(0o644)).unwrap();
    let events = station.access_events("is open to others (mode 644): chmod 600");
    assert!(events.iter().all(|line| !line.contains("orchid")), "{events:?}");
    assert_eq!(Request::get("/api/gauges").by(&page).to(&station).status, 200);
}

/// A server that other computers reach has TLS and users, or it does not start.
#[test]
fn listening_beyond_loopback_requires_tls_and_users() {
    use profivac_recorder::{Recorder, Settings};
    use profivac_station::services::Services;
    use profivac_web_server::server::Setup;
    let folder = tempfile::tempdir().unwrap();
    let users = folder.path().join("users.toml");
    Users::change(&users, |_| Ok(())).unwrap();
    let file = folder.path().join("plant.db");
    let recorder = Recorder::start(&file, Settings::default()).unwrap();
    let services = std::sync::Arc::new(Services::new("hall".to_owned(), file, recorder));
    let everywhere: SocketAddr = "0.0.0.0:0".parse().unwrap();
    let start = |access: Access, with_tls: bool| {
        let tls = with_tls.then(|| crate::security::test_station::certificate(&folder));
        let setup = Setup { tls, ..Setup::new(everywhere, access) };
        profivac_station::server::start(std::sync::Arc::clone(&services), setup)
            .map(drop)
            .map_err(|error| error.to_string())
    };
    let of_file = || Access::Users(users.clone());
    assert!(start(of_file(), false).unwrap_err().contains("needs TLS"));
    for access in [of_file(), Access::anonymous_viewer(), Access::anonymous("demo", Role::Engineer)] {
        assert!(start(access, true).unwrap_err().contains("needs users"));
    }
    let behind = |access: Access| {
        let hosts = vec!["vacuum.example".to_owned()];
        let setup = Setup { hosts, ..Setup::new("127.0.0.1:0".parse().unwrap(), access) };
        profivac_station::server::start(std::sync::Arc::clone(&services), setup)
            .map(drop)
            .map_err(|error| error.to_string())
    };
    assert!(behind(Access::anonymous_viewer()).unwrap_err().contains("through a proxy, which needs users"));
    let hash = Hash::of(PASSWORD).unwrap();
    Users::change(&users, |users| users.add("ada", Role::Engineer, hash)).unwrap();
    assert_eq!((start(of_file(), true), behind(of_file())), (Ok(()), Ok(())));
    assert!(start(of_file(), false).unwrap_err().contains("needs TLS"));
}

#[test]
fn the_first_user_takes_effect_without_a_restart() {
    let station =
        TestStation::with(|setup, folder| setup.access = Access::UsersWhenPresent(folder.path().join("first.toml")));
    assert_eq!(station.get("/api/session").json()["login"], "not-required");
    assert_eq!(station.get("/api/gauges").status, 200);
    let mut stream = station.connect();
    stream.write_all(Request::get("/api/live").text().as_bytes()).unwrap();
    assert_eq!(stream.read(&mut [0; 12]).unwrap(), 12);
    let file = station.file("first.toml");
    // A file without users, or with an error, changes nothing.
    Users::change(&file, |_| Ok(())).unwrap();
    fs::set_permissions(&file, fs::Permissions::from_mode(0o644)).unwrap();
    station.access_events("is open to others (mode 644): chmod 600");
    assert_eq!(station.get("/api/gauges").status, 200);
    fs::set_permissions(&file, fs::Permissions::from_mode(0o600)).unwrap();
    let hash = Hash::of(PASSWORD).unwrap();
    Users::change(&file, |users| users.add("ada", Role::Engineer, hash)).unwrap();
    let events = station.access_events("the user ada was added as engineer");
    assert!(events.contains(&"the station has users: every request needs a login from now on".to_owned()));
    assert_eq!(station.get("/api/gauges").status, 401);
    assert_eq!(station.get("/api/session").json()["login"], "logged-out");
    while stream.read(&mut [0; 4096]).unwrap() > 0 {}
    assert_eq!(Request::get("/api/gauges").by(&station.login("ada")).to(&station).status, 200);
    fs::remove_file(&file).unwrap();
    station.access_events("does not exist");
    assert_eq!(station.get("/api/gauges").status, 401, "without the file the users stay as they were");
}
