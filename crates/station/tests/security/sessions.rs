//! Sessions and their cookies.

use crate::desk::{Answer, Ask, Desk, PATIENCE, Page};
use profivac_station::auth::Role;
use profivac_station::auth::users::Users;
use serde_json::{Value, json};
use std::collections::HashSet;
use std::io::{Read, Write};
use std::time::Instant;

fn status(desk: &Desk, page: &Page) -> u16 {
    Ask::get("/api/gauges").cookie(page).to(desk).status
}

fn logout(desk: &Desk, page: &Page) -> Answer {
    Ask::post("/api/logout", &json!(null)).by(page).to(desk)
}

#[test]
fn session_identifiers_and_tokens_are_random_and_unique() {
    let desk = Desk::new();
    let pages: Vec<_> = (0..8).map(|_| desk.login("ada")).collect();
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
    let desk = Desk::new();
    let chosen = format!("cookie: profivac-{}={}", desk.port(), "ab".repeat(32));
    assert_eq!(Ask::get("/api/gauges").header(&chosen).to(&desk).status, 401);
    let answer = Ask::login("ada", crate::desk::PASSWORD).header(&chosen).to(&desk);
    assert!(!answer.header("set-cookie").unwrap().contains(&"ab".repeat(32)));
    assert_eq!(Ask::get("/api/gauges").header(&chosen).to(&desk).status, 401);
}

#[test]
fn a_second_login_ends_the_session_before() {
    let desk = Desk::new();
    let old = desk.login("vera");
    let new = Page::of(&Ask::login("ada", crate::desk::PASSWORD).cookie(&old).to(&desk));
    assert_ne!(old, new);
    assert_eq!((status(&desk, &old), status(&desk, &new)), (401, 200));
}

#[test]
fn a_logout_ends_the_session() {
    let desk = Desk::new();
    let (page, other) = (desk.login("ada"), desk.login("ada"));
    let left = logout(&desk, &page);
    assert_eq!(left.status, 204);
    let cookie = left.header("set-cookie").unwrap();
    assert!(cookie.starts_with(&format!("profivac-{}=;", desk.port())) && cookie.contains("Max-Age=0"), "{cookie}");
    assert_eq!((status(&desk, &page), status(&desk, &other)), (401, 200));
    assert_eq!(logout(&desk, &page).status, 401);
}

#[test]
fn removing_a_user_ends_the_session_and_its_stream() {
    let desk = Desk::new();
    let (ada, vera) = (desk.login("ada"), desk.login("vera"));
    let mut stream = desk.connect();
    stream.write_all(Ask::get("/api/live").cookie(&vera).text().as_bytes()).unwrap();
    assert_eq!(stream.read(&mut [0; 12]).unwrap(), 12);
    desk.change(|users| users.remove("vera").unwrap());
    let end = Instant::now() + PATIENCE;
    while stream.read(&mut [0; 4096]).unwrap() > 0 {
        assert!(Instant::now() < end, "the stream does not end");
    }
    assert_eq!((status(&desk, &vera), status(&desk, &ada)), (401, 200));
    desk.access_events("the user vera was removed");
}

#[test]
fn a_new_role_applies_at_once() {
    let desk = Desk::new();
    let ada = desk.login("ada");
    desk.change(|users| users.get_mut("ada").unwrap().role = Role::Viewer);
    desk.access_events("the user ada is now viewer");
    assert_eq!(Ask::get("/api/session").by(&ada).to(&desk).json()["role"], "viewer");
}

#[test]
fn the_cookie_is_limited_to_the_page_of_this_host() {
    let desk = Desk::new();
    let answer = Ask::login("ada", crate::desk::PASSWORD).to(&desk);
    let cookie = answer.header("set-cookie").unwrap();
    let (_, attributes) = cookie.split_once("; ").unwrap();
    assert_eq!(attributes, "Path=/; HttpOnly; SameSite=Strict");
    assert!(cookie.starts_with(&format!("profivac-{}=", desk.port())));
    assert!(!answer.body.contains(cookie.split_once('=').unwrap().1.split(';').next().unwrap()));
}

/// A host name that is not local is that of a proxy, and the proxy uses TLS.
#[test]
fn behind_a_proxy_the_cookie_is_secure() {
    let desk = Desk::with(|setup, _| setup.hosts = vec!["vacuum.example".to_owned()]);
    let origin = "origin: https://vacuum.example";
    let answer = Ask::login("ada", crate::desk::PASSWORD).host("vacuum.example").header(origin).to(&desk);
    let cookie = answer.header("set-cookie").unwrap();
    assert!(cookie.starts_with("__Host-profivac-") && cookie.ends_with("; Secure"), "{cookie}");
    let page = Page::of(&answer);
    assert_eq!(Ask::get("/api/gauges").host("vacuum.example").cookie(&page).to(&desk).status, 200);
    let renamed = Ask::post("/api/logout", &json!(null)).by(&page).host("vacuum.example:443").header(origin);
    assert_eq!(renamed.to(&desk).status, 204);
}

#[test]
fn foreign_and_duplicate_cookies_are_ignored() {
    let desk = Desk::new();
    let page = desk.login("ada");
    let ask = |cookies: &str| Ask::get("/api/gauges").header(&format!("cookie: {cookies}")).to(&desk).status;
    assert_eq!(ask(&format!("a=b; {}; c=d", page.cookie)), 200);
    assert_eq!(ask(&format!("{0}; {0}", page.cookie)), 401, "two cookies of the same name are ambiguous");
    assert_eq!(ask(&page.cookie.replace("profivac-", "__Host-profivac-")), 401);
    assert_eq!(ask(&page.cookie.to_uppercase()), 401);
    assert_eq!(ask(&format!("{}; {}", "a=b; ".repeat(4000), page.cookie)), 200);
    assert_eq!(ask(&"a".repeat(60_000)), 431);
    for cookie in ["=", ";;;", "profivac", "\u{7f}", "ä=ö"] {
        assert_eq!(ask(cookie), if cookie == "\u{7f}" { 400 } else { 401 }, "{cookie:?}");
    }
}

/// The user with control authority.
fn holder(desk: &Desk, page: &Page) -> Value {
    let answer = Ask::get("/api/mastership").by(page).to(desk);
    assert_eq!(answer.status, 200, "{answer:?}");
    answer.json()["holder"].clone()
}

#[test]
fn a_user_whose_last_session_ended_has_no_control_authority() {
    let desk = Desk::new();
    let (vera, one, other) = (desk.login("vera"), desk.login("olga"), desk.login("olga"));
    let post = |path: &str, page: &Page| Ask::post(path, &json!(null)).by(page).to(&desk).status;
    assert_eq!(post("/api/mastership/ask", &one), 200);
    assert_eq!(post("/api/logout", &one), 204);
    assert_eq!(holder(&desk, &vera), "olga", "the user has another session");
    assert_eq!(post("/api/logout", &other), 204);
    assert_eq!(holder(&desk, &vera), Value::Null);
}

#[test]
fn a_user_who_is_removed_or_becomes_viewer_has_no_control_authority() {
    let is_lowered = |users: &mut Users| users.get_mut("olga").unwrap().role = Role::Viewer;
    let is_removed = |users: &mut Users| users.remove("olga").unwrap();
    for (change, event) in
        [(is_lowered as fn(&mut Users), "the user olga is now viewer"), (is_removed, "the user olga was removed")]
    {
        let desk = Desk::new();
        let (vera, olga) = (desk.login("vera"), desk.login("olga"));
        assert_eq!(Ask::post("/api/mastership/ask", &json!(null)).by(&olga).to(&desk).status, 200);
        assert_eq!(holder(&desk, &vera), "olga");
        desk.change(change);
        desk.access_events(event);
        assert_eq!(holder(&desk, &vera), Value::Null, "{event}");
    }
}
