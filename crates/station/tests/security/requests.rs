//! Forged and malformed requests, and what stands above every answer.

use crate::desk::{Answer, Ask, Desk};
use profivac_station::auth::Role;
use profivac_station::auth::rate_limit::{RateLimit, RateLimits};
use profivac_station::server::Limits;
use serde_json::json;
use std::io::{Read, Write};
use std::time::{Duration, Instant};

fn logout() -> Ask {
    Ask::post("/api/logout", &json!(null))
}

#[test]
fn without_the_token_nothing_is_done() {
    for desk in [Desk::new(), Desk::open(Role::Engineer)] {
        let (page, other) = if desk.get("/api/session").json()["door"] == "open" {
            let token = desk.get("/api/session").json()["token"].as_str().unwrap().to_owned();
            let page = crate::desk::Page { cookie: "a=b".to_owned(), token };
            (page, "0".repeat(64))
        } else {
            (desk.login("ada"), desk.login("ada").token)
        };
        for method in ["POST", "PUT", "DELETE", "PATCH", "OPTIONS", "TRACE", "BREW"] {
            for path in ["/api/logout", "/api/gauges", "/api/no/such/thing"] {
                let ask = Ask::new(method, path).cookie(&page);
                assert_eq!(ask.to(&desk).status, 403, "{method} {path}");
                assert_eq!(ask.header(&format!("x-csrf-token: {other}")).to(&desk).status, 403, "{method} {path}");
            }
        }
        assert_eq!(Ask::new("PUT", "/api/gauges").by(&page).to(&desk).status, 405);
        assert_eq!(logout().by(&page).to(&desk).status, 204);
    }
}

#[test]
fn a_page_from_elsewhere_can_ask_for_nothing() {
    let desk = Desk::new();
    let page = desk.login("ada");
    let foreign = [
        "origin: https://evil.example",
        "origin: null",
        "origin: http://localhost:9",
        "origin: http://localhost.evil.example",
        "origin: http://evil@localhost",
        "origin: localhost",
        "sec-fetch-site: cross-site",
        "sec-fetch-site: same-site",
        "sec-fetch-site: \"same-origin\"",
    ];
    for line in foreign {
        for ask in [logout().by(&page), Ask::get("/api/gauges").by(&page), Ask::login("ada", crate::desk::PASSWORD)] {
            let refused = ask.header(line).to(&desk);
            assert_eq!(
                (refused.status, refused.problem().as_str()),
                (403, "this comes from a page that is not ours"),
                "{line}"
            );
            assert_eq!(refused.header("access-control-allow-origin"), None);
            assert_eq!(refused.header("set-cookie"), None);
        }
    }
    for line in ["origin: http://localhost", "origin: HTTP://LOCALHOST", "sec-fetch-site: same-origin", "accept: */*"] {
        assert_eq!(Ask::get("/api/gauges").by(&page).header(line).to(&desk).status, 200, "{line}");
    }
    assert_eq!(Ask::get("/api/gauges").by(&page).header("sec-fetch-site: none").to(&desk).status, 200);
    assert_eq!(logout().by(&page).header("sec-fetch-site: none").to(&desk).status, 403);
    let told = desk.told("refused for ada at 127.0.0.1");
    assert!(
        told.iter().any(|line| line.ends_with("\"/api/gauges\": this comes from a page that is not ours")),
        "{told:?}"
    );
}

#[test]
fn a_form_from_elsewhere_is_no_login() {
    let desk = Desk::new();
    let body = json!({ "name": "ada", "password": crate::desk::PASSWORD }).to_string();
    for kind in
        ["text/plain", "application/x-www-form-urlencoded", "multipart/form-data", "text/plain; application/json"]
    {
        let ask = Ask::new("POST", "/api/login").header(&format!("content-type: {kind}")).body(&body);
        assert_eq!(ask.to(&desk).status, 415, "{kind}");
    }
    assert_eq!(Ask::new("POST", "/api/login").body(&body).to(&desk).status, 415);
    assert_eq!(Ask::get("/api/login?name=ada&password=secret").to(&desk).status, 405, "never in an address");
}

#[test]
fn no_other_method_hides_behind_a_harmless_one() {
    let desk = Desk::new();
    let page = desk.login("ada");
    for line in ["x-http-method-override: POST", "x-http-method: POST", "x-method-override: DELETE"] {
        assert_eq!(Ask::get("/api/logout").by(&page).header(line).to(&desk).status, 405, "{line}");
    }
    assert_eq!(Ask::get("/api/logout?_method=POST").by(&page).to(&desk).status, 405);
    assert_eq!(Ask::get("/api/gauges").by(&page).to(&desk).status, 200);
}

#[test]
fn paths_lead_nowhere_else() {
    let desk = Desk::new();
    let page = desk.get("/").body;
    assert!(page.contains("<div id=\"app\">"));
    for path in [
        "//api/gauges",
        "/x/../api/gauges",
        "/%61pi/gauges",
        "/api%2fgauges",
        "/API/gauges",
        "/api",
        "/api;/gauges",
        "/./api/gauges",
        "/assets/../../Cargo.toml",
        "/..%2f..%2fetc/passwd",
        "/%2e%2e/%2e%2e/etc/passwd",
        "/.git/config",
        "/users.toml",
        "/plant.db",
    ] {
        let answer = desk.get(path);
        assert!(answer.body == page || answer.status == 404, "{path}: {answer:?}");
    }
    for path in [
        "/api//gauges",
        "/api/../gauges",
        "/api/./gauges",
        "/api/%67auges",
        "/api/gauges/",
        "/api/gauges/..%2f..%2fsession",
        "/api/login/",
        "/api/login%00",
        "/api/session/../gauges",
        "/api/login;/../gauges",
        "/api/gauges?x=/api/login",
        "/api/gauges#/api/login",
    ] {
        let status = desk.get(path).status;
        assert!(status == 401 || status == 400, "{path}: {status}");
    }
    for target in ["http://localhost/api/gauges", "http://evil.example/api/gauges"] {
        assert_ne!(Ask::get(target).to(&desk).status, 200, "{target}");
    }
}

#[test]
fn who_means_another_computer_is_not_answered() {
    let desk = Desk::new();
    for host in [
        "evil.example",
        "localhost.evil.example",
        "evil@localhost",
        "10.0.0.1",
        "",
        "localhost, evil.example",
        "127.0.0.1.evil.example",
    ] {
        let answer = Ask::get("/").host(host).to(&desk);
        assert!(answer.status == 421 || answer.status == 400, "{host:?}: {}", answer.status);
    }
    assert_eq!(Ask::get("/").header("host: evil.example").to(&desk).status, 421, "two are none");
    assert_eq!(Ask::get("http://evil.example/").to(&desk).status, 421);
    let forwarded = ["x-forwarded-host: evil.example", "x-forwarded-for: 10.0.0.1", "forwarded: host=evil.example"];
    let ask = forwarded.iter().fold(Ask::login("ada", crate::desk::PASSWORD), |ask, line| ask.header(line));
    assert_eq!(ask.to(&desk).status, 200);
    desk.told("ada (engineer) logged in from 127.0.0.1");
}

#[test]
fn bodies_are_small_quick_and_json() {
    let limits = Limits { head: Duration::from_secs(2), ..Limits::default() };
    let desk = Desk::with(|setup, _| setup.limits = limits);
    let page = desk.login("ada");
    let post = || Ask::new("POST", "/api/password").by(&page).header("content-type: application/json");
    assert_eq!(post().body(&"a".repeat(64 << 10)).to(&desk).status, 400);
    assert_eq!(post().body(&"a".repeat((64 << 10) + 1)).to(&desk).status, 413);
    for body in [
        "null",
        "[]",
        "{}",
        "{\"current\":1,\"new\":2}",
        "{\"current\":\"a\",\"new\":\"b\",\"role\":\"engineer\"}",
        "{\"a\":",
        "\u{0}",
    ] {
        let refused = post().body(body).to(&desk);
        assert_eq!(
            (refused.status, refused.problem().as_str()),
            (400, "expected JSON as /api/openapi.json describes it"),
            "{body}"
        );
    }
    let mut stream = desk.connect();
    stream.write_all(post().header("content-length: 100").text().as_bytes()).unwrap();
    assert_eq!(Answer::read(&mut stream).status, 408, "who never sends a body is left");
}

#[test]
fn who_asks_for_too_much_waits() {
    let paces = RateLimits { requests: RateLimit::new(100, Duration::from_secs(86_400)), ..RateLimits::default() };
    let desk = Desk::with(|setup, _| setup.limits = Limits { paces, ..Limits::default() });
    let page = desk.login("ada");
    let ask = Ask::get("/api/session").by(&page);
    assert!((1..100).all(|_| ask.to(&desk).status == 200));
    let refused = ask.to(&desk);
    assert_eq!(refused.status, 429);
    // A day, but for what has passed meanwhile.
    let wait: u64 = refused.header("retry-after").unwrap().parse().unwrap();
    assert!((80_000..=86_400).contains(&wait), "{wait}");
    assert_eq!(desk.get("/").status, 429, "the page as well");
}

#[test]
fn every_answer_says_what_browsers_may_do_with_it() {
    let desk = Desk::new();
    let page = desk.login("ada");
    let policy = |answer: &Answer| answer.header("content-security-policy").unwrap().to_owned();
    let answers = [
        desk.get("/"),
        desk.get("/assets/none.js"),
        desk.get("/api/gauges"),
        Ask::get("/api/gauges").by(&page).to(&desk),
        Ask::get("/").host("evil.example").to(&desk),
        Ask::new("POST", "/").to(&desk),
        logout().to(&desk),
    ];
    assert_eq!(answers.each_ref().map(|answer| answer.status), [200, 404, 401, 200, 421, 405, 401]);
    for answer in &answers {
        assert_eq!(answer.header("x-content-type-options"), Some("nosniff"));
        assert_eq!(answer.header("x-frame-options"), Some("DENY"));
        assert_eq!(answer.header("referrer-policy"), Some("no-referrer"));
        assert_eq!(answer.header("cross-origin-opener-policy"), Some("same-origin"));
        assert_eq!(answer.header("cross-origin-resource-policy"), Some("same-origin"));
        assert!(answer.header("permissions-policy").unwrap().contains("camera=()"));
        assert_eq!(answer.header("access-control-allow-origin"), None);
        assert_eq!(answer.header("server"), None);
        for part in ["default-src 'none'", "object-src 'none'", "base-uri 'none'", "frame-ancestors 'none'"] {
            assert!(policy(answer).contains(part), "{part}: {}", policy(answer));
        }
        assert!(!policy(answer).contains("unsafe-eval") && !policy(answer).contains("script-src 'self' "));
    }
    assert!(policy(&answers[0]).contains("script-src 'self';"));
}

#[test]
fn what_is_no_page_is_never_drawn_as_one_and_never_kept() {
    let desk = Desk::new();
    let page = desk.login("ada");
    for path in
        ["/api/gauges", "/api/session", "/api/export.csv?from=0&to=1", "/api/openapi.json", "/api/gauges/%3Cscript%3E"]
    {
        let answer = Ask::get(path).by(&page).to(&desk);
        assert!(answer.header("content-security-policy").unwrap().ends_with("sandbox"), "{path}");
        assert_eq!(answer.header("cache-control"), Some("no-store"), "{path}");
        let kind = answer.header("content-type").unwrap();
        assert!(kind == "application/json" || kind == "text/csv; charset=utf-8", "{path}: {kind}");
    }
    let export = Ask::get("/api/export.csv?from=0&to=1").by(&page).to(&desk);
    assert_eq!(export.header("content-disposition"), Some("attachment; filename=\"pressures.csv\""));
    assert_eq!(desk.get("/").header("content-type"), Some("text/html; charset=utf-8"));
    assert_eq!(desk.get("/api/session").header("cache-control"), Some("no-store"));
}

#[test]
fn a_name_is_a_name_and_no_query() {
    let desk = Desk::new();
    let page = desk.login("ada");
    for name in ["%27%20OR%201=1--", "%22;DROP%20TABLE%20event;--", "%00", "%F0%9F%92%A5", "..%2F..%2Fplant.db"] {
        let answer = Ask::get(&format!("/api/trend?series={name}&from=0&to=10")).by(&page).to(&desk);
        assert_eq!((answer.status, answer.json()["start_ms"].clone()), (200, json!([])), "{name}");
        let gauge = Ask::get(&format!("/api/gauges/{name}")).by(&page).to(&desk);
        assert_eq!(gauge.status, 404, "{name}");
    }
    desk.told("ada (engineer) logged in");
}

#[test]
fn no_answer_holds_a_password_or_its_hash() {
    let desk = Desk::new();
    let page = desk.login("ada");
    desk.told("ada (engineer) logged in");
    for path in [
        "/api/session",
        "/api/station",
        "/api/gauges",
        "/api/segments",
        "/api/openapi.json",
        "/api/events?from=0&to=9999999999999",
    ] {
        let answer = Ask::get(path).by(&page).to(&desk);
        let (_, id) = page.cookie.split_once('=').unwrap();
        assert_eq!(answer.status, 200, "{path}");
        for secret in ["argon2", crate::desk::PASSWORD, id] {
            assert!(!answer.body.contains(secret), "{path}: {secret}");
        }
    }
}

#[test]
fn who_takes_no_answer_is_left() {
    let limits = Limits { connections: 1, stalled: Duration::from_millis(100), ..Limits::default() };
    let desk = Desk::with(|setup, _| setup.limits = limits);
    let page = desk.get("/").body;
    let script = page.split('"').find(|part| part.ends_with(".js")).unwrap();
    let ask = format!("GET {script} HTTP/1.1\r\nhost: localhost\r\n\r\n").repeat(400);
    let end = Instant::now() + crate::desk::PATIENCE;
    let mut greedy = loop {
        // The place of who asked before is free in a moment.
        let mut stream = desk.connect();
        if stream.write_all(ask.as_bytes()).is_ok() && stream.peek(&mut [0]).is_ok_and(|read| read == 1) {
            break stream;
        }
        assert!(Instant::now() < end);
    };
    while desk.get("/api/session").status != 200 {
        assert!(Instant::now() < end, "whoever reads nothing has the only place for ever");
        std::thread::yield_now();
    }
    assert!(greedy.write_all(b"GET").is_err() || greedy.read_to_end(&mut Vec::new()).is_err());
}

#[test]
fn who_changes_very_much_waits_and_keeps_nobody_else_out() {
    let paces = RateLimits { acts: RateLimit::new(5, Duration::from_secs(600)), ..RateLimits::default() };
    let desk = Desk::with(|setup, _| setup.limits = Limits { paces, ..Limits::default() });
    let (olga, ada) = (desk.login("olga"), desk.login("ada"));
    let ask = |page| Ask::post("/api/mastership/ask", &json!(null)).by(page).to(&desk).status;
    assert_eq!((0..8).filter(|_| ask(&olga) == 200).count(), 5);
    assert_eq!((ask(&olga), ask(&ada)), (429, 200));
    assert_eq!(Ask::get("/api/gauges").by(&olga).to(&desk).status, 200, "looking is no act");
}
