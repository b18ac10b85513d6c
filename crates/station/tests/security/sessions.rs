//! Sessions and their cookies.

use crate::security::test_station::{Answer, Page, Request, TIMEOUT, TestStation};
use profivac_web_server::auth::Role;
use profivac_web_server::auth::users::Users;
use serde_json::{Value, json};
use std::collections::HashSet;
use std::io::{Read, Write};
use std::time::Instant;

fn status(station: &TestStation, page: &Page) -> u16 {
    Request::get("/api/gauges").cookie(page).to(station).status
}

fn logout(station: &TestStation, page: &Page) -> Answer {
    Request::post("/api/logout", &json!(null)).by(page).to(station)
}

#[test]
fn session_identifiers_and_tokens_are_random_and_unique() {
    let station = TestStation::new();
    let pages: Vec<_> = (0..8).map(|_| station.login("ada")).collect();
    let secrets: HashSet<_> = pages.iter().flat_map(|page| [&page.cookie, &page.token]).collect();
    assert_eq!(secrets.len(), 16);
    for page in &pages {
        let (_, id) = page.cookie.split_once('=').unwrap();
        assert_eq!((id.len(), page.token.len()), (64, 64), "256 bits");
        assert_ne!(id, page.token);
    }
}

#[test]
fn a_session_identifier_chosen_by_the_client_is_refused() {
    let station = TestStation::new();
    let chosen = format!("cookie: profivac-{}={}", station.port(), "ab".repeat(32));
    assert_eq!(Request::get("/api/gauges").header(&chosen).to(&station).status, 401);
    let answer = Request::login("ada", crate::security::test_station::PASSWORD).header(&chosen).to(&station);
    assert!(!answer.header("set-cookie").unwrap().contains(&"ab".repeat(32)));
    assert_eq!(Request::get("/api/gauges").header(&chosen).to(&station).status, 401);
}

#[test]
fn a_second_login_ends_the_session_before() {
    let station = TestStation::new();
    let old = station.login("vera");
    let new = Page::of(&Request::login("ada", crate::security::test_station::PASSWORD).cookie(&old).to(&station));
    assert_ne!(old, new);
    assert_eq!((status(&station, &old), status(&station, &new)), (401, 200));
}

#[test]
fn a_logout_ends_the_session() {
    let station = TestStation::new();
    let (page, other) = (station.login("ada"), station.login("ada"));
    let left = logout(&station, &page);
    assert_eq!(left.status, 204);
    let cookie = left.header("set-cookie").unwrap();
    assert!(cookie.starts_with(&format!("profivac-{}=;", station.port())) && cookie.contains("Max-Age=0"), "{cookie}");
    assert_eq!((status(&station, &page), status(&station, &other)), (401, 200));
    assert_eq!(logout(&station, &page).status, 401);
}

#[test]
fn removing_a_user_ends_the_session_and_its_stream() {
    let station = TestStation::new();
    let (ada, vera) = (station.login("ada"), station.login("vera"));
    let mut stream = station.connect();
    stream.write_all(Request::get("/api/live").cookie(&vera).text().as_bytes()).unwrap();
    assert_eq!(stream.read(&mut [0; 12]).unwrap(), 12);
    station.change(|users| users.remove("vera").unwrap());
    let end = Instant::now() + TIMEOUT;
    while stream.read(&mut [0; 4096]).unwrap() > 0 {
        assert!(Instant::now() < end, "the stream does not end");
    }
    assert_eq!((status(&station, &vera), status(&station, &ada)), (401, 200));
    station.access_events("the user vera was removed");
}

#[test]
fn a_new_role_applies_at_once() {
    let station = TestStation::new();
    let ada = station.login("ada");
    station.change(|users| users.get_mut("ada").unwrap().role = Role::Viewer);
    station.access_events("the user ada is now viewer");
    assert_eq!(Request::get("/api/session").by(&ada).to(&station).json()["role"], "viewer");
}

#[test]
fn the_cookie_is_limited_to_the_page_of_this_host() {
    let station = TestStation::new();
    let answer = Request::login("ada", crate::security::test_station::PASSWORD).to(&station);
    let cookie = answer.header("set-cookie").unwrap();
    let (_, attributes) = cookie.split_once("; ").unwrap();
    assert_eq!(attributes, "Path=/; HttpOnly; SameSite=Strict");
    assert!(cookie.starts_with(&format!("profivac-{}=", station.port())));
    assert!(!answer.body.contains(cookie.split_once('=').unwrap().1.split(';').next().unwrap()));
}

/// A host name that is not local is that of a proxy, and the proxy uses TLS.
#[test]
fn behind_a_proxy_the_cookie_is_secure() {
    let station = TestStation::with(|setup, _| setup.hosts = vec!["vacuum.example".to_owned()]);
    let origin = "origin: https://vacuum.example";
    let answer = Request::login("ada", crate::security::test_station::PASSWORD)
        .host("vacuum.example")
        .header(origin)
        .to(&station);
    let cookie = answer.header("set-cookie").unwrap();
    assert!(cookie.starts_with("__Host-profivac-") && cookie.ends_with("; Secure"), "{cookie}");
    let page = Page::of(&answer);
    assert_eq!(Request::get("/api/gauges").host("vacuum.example").cookie(&page).to(&station).status, 200);
    let renamed = Request::post("/api/logout", &json!(null)).by(&page).host("vacuum.example:443").header(origin);
    assert_eq!(renamed.to(&station).status, 204);
}

#[test]
fn foreign_and_duplicate_cookies_are_ignored() {
    let station = TestStation::new();
    let page = station.login("ada");
    let status = |cookies: &str| Request::get("/api/gauges").header(&format!("cookie: {cookies}")).to(&station).status;
    assert_eq!(status(&format!("a=b; {}; c=d", page.cookie)), 200);
    assert_eq!(status(&format!("{0}; {0}", page.cookie)), 401, "two cookies of the same name are ambiguous");
    assert_eq!(status(&page.cookie.replace("profivac-", "__Host-profivac-")), 401);
    assert_eq!(status(&page.cookie.to_uppercase()), 401);
    assert_eq!(status(&format!("{}; {}", "a=b; ".repeat(4000), page.cookie)), 200);
    assert_eq!(status(&"a".repeat(60_000)), 431);
    for cookie in ["=", ";;;", "profivac", "\u{7f}", "ä=ö"] {
        assert_eq!(status(cookie), if cookie == "\u{7f}" { 400 } else { 401 }, "{cookie:?}");
    }
}

/// The user with control authority.
fn holder(station: &TestStation, page: &Page) -> Value {
    let answer = Request::get("/api/control-authority").by(page).to(station);
    assert_eq!(answer.status, 200, "{answer:?}");
    answer.json()["holder"].clone()
}

#[test]
fn a_user_whose_last_session_ended_has_no_control_authority() {
    let station = TestStation::new();
    let (vera, one, other) = (station.login("vera"), station.login("olga"), station.login("olga"));
    let post = |path: &str, page: &Page| Request::post(path, &json!(null)).by(page).to(&station).status;
    assert_eq!(post("/api/control-authority/request", &one), 200);
    assert_eq!(post("/api/logout", &one), 204);
    assert_eq!(holder(&station, &vera), "olga", "the user has another session");
    assert_eq!(post("/api/logout", &other), 204);
    assert_eq!(holder(&station, &vera), Value::Null);
}

#[test]
fn a_user_who_is_removed_or_becomes_viewer_has_no_control_authority() {
    let is_lowered = |users: &mut Users| users.get_mut("olga").unwrap().role = Role::Viewer;
    let is_removed = |users: &mut Users| users.remove("olga").unwrap();
    for (change, event) in
        [(is_lowered as fn(&mut Users), "the user olga is now viewer"), (is_removed, "the user olga was removed")]
    {
        let station = TestStation::new();
        let (vera, olga) = (station.login("vera"), station.login("olga"));
        assert_eq!(Request::post("/api/control-authority/request", &json!(null)).by(&olga).to(&station).status, 200);
        assert_eq!(holder(&station, &vera), "olga");
        station.change(change);
        station.access_events(event);
        assert_eq!(holder(&station, &vera), Value::Null, "{event}");
    }
}
