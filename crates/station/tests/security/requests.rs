//! Forged and malformed requests, and the headers of every answer.

use crate::security::test_station::{Answer, PASSWORD, Page, Request, TIMEOUT, TestStation};
use crate::until::pause;
use profivac_web_server::auth::Role;
use profivac_web_server::auth::rate_limit::{RateLimit, RateLimits};
use profivac_web_server::server::Limits;
use serde_json::json;
use std::io::{Read, Write};
use std::time::{Duration, Instant};

fn logout() -> Request {
    Request::post("/api/logout", &json!(null))
}

#[test]
fn a_change_without_the_token_is_refused() {
    for station in [TestStation::new(), TestStation::open(Role::Engineer)] {
        let (page, other) = if station.get("/api/session").json()["login"] == "not-required" {
            let token = station.get("/api/session").json()["token"].as_str().unwrap().to_owned();
            let page = Page { cookie: "a=b".to_owned(), token };
            (page, "0".repeat(64))
        } else {
            (station.login("ada"), station.login("ada").token)
        };
        for method in ["POST", "PUT", "DELETE", "PATCH", "OPTIONS", "TRACE", "BREW"] {
            for path in ["/api/logout", "/api/gauges", "/api/no/such/thing"] {
                let request = Request::new(method, path).cookie(&page);
                assert_eq!(request.to(&station).status, 403, "{method} {path}");
                assert_eq!(
                    request.header(&format!("x-csrf-token: {other}")).to(&station).status,
                    403,
                    "{method} {path}"
                );
            }
        }
        assert_eq!(Request::new("PUT", "/api/gauges").by(&page).to(&station).status, 405);
        assert_eq!(logout().by(&page).to(&station).status, 204);
    }
}

#[test]
fn a_request_from_a_foreign_page_is_refused() {
    let station = TestStation::new();
    let page = station.login("ada");
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
        for request in [logout().by(&page), Request::get("/api/gauges").by(&page), Request::login("ada", PASSWORD)] {
            let refused = request.header(line).to(&station);
            assert_eq!(
                (refused.status, refused.problem().as_str()),
                (403, "the request comes from a foreign page"),
                "{line}"
            );
            assert_eq!(refused.header("access-control-allow-origin"), None);
            assert_eq!(refused.header("set-cookie"), None);
        }
    }
    for line in ["origin: http://localhost", "origin: HTTP://LOCALHOST", "sec-fetch-site: same-origin", "accept: */*"] {
        assert_eq!(Request::get("/api/gauges").by(&page).header(line).to(&station).status, 200, "{line}");
    }
    assert_eq!(Request::get("/api/gauges").by(&page).header("sec-fetch-site: none").to(&station).status, 200);
    assert_eq!(logout().by(&page).header("sec-fetch-site: none").to(&station).status, 403);
    let events = station.access_events("refused for ada at 127.0.0.1");
    assert!(
        events.iter().any(|line| line.ends_with("\"/api/gauges\": the request comes from a foreign page")),
        "{events:?}"
    );
}

#[test]
fn a_form_of_a_foreign_page_cannot_log_in() {
    let station = TestStation::new();
    let body = json!({ "name": "ada", "password": PASSWORD }).to_string();
    for kind in
        ["text/plain", "application/x-www-form-urlencoded", "multipart/form-data", "text/plain; application/json"]
    {
        let request = Request::new("POST", "/api/login").header(&format!("content-type: {kind}")).body(&body);
        assert_eq!(request.to(&station).status, 415, "{kind}");
    }
    assert_eq!(Request::new("POST", "/api/login").body(&body).to(&station).status, 415);
    assert_eq!(
        Request::get("/api/login?name=ada&password=secret").to(&station).status,
        405,
        "credentials in a URL are not accepted"
    );
}

#[test]
fn a_get_request_cannot_override_its_method() {
    let station = TestStation::new();
    let page = station.login("ada");
    for line in ["x-http-method-override: POST", "x-http-method: POST", "x-method-override: DELETE"] {
        assert_eq!(Request::get("/api/logout").by(&page).header(line).to(&station).status, 405, "{line}");
    }
    assert_eq!(Request::get("/api/logout?_method=POST").by(&page).to(&station).status, 405);
    assert_eq!(Request::get("/api/gauges").by(&page).to(&station).status, 200);
}

#[test]
fn a_path_reaches_neither_other_handlers_nor_files() {
    let station = TestStation::new();
    let page = station.get("/").body;
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
        let answer = station.get(path);
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
        let status = station.get(path).status;
        assert!(status == 401 || status == 400, "{path}: {status}");
    }
    for target in ["http://localhost/api/gauges", "http://evil.example/api/gauges"] {
        assert_ne!(Request::get(target).to(&station).status, 200, "{target}");
    }
}

#[test]
fn a_request_for_another_host_is_refused() {
    let station = TestStation::new();
    for host in [
        "evil.example",
        "localhost.evil.example",
        "evil@localhost",
        "10.0.0.1",
        "",
        "localhost, evil.example",
        "127.0.0.1.evil.example",
    ] {
        let answer = Request::get("/").host(host).to(&station);
        assert!(answer.status == 421 || answer.status == 400, "{host:?}: {}", answer.status);
    }
    assert_eq!(
        Request::get("/").header("host: evil.example").to(&station).status,
        421,
        "two Host headers are ambiguous"
    );
    assert_eq!(Request::get("http://evil.example/").to(&station).status, 421);
    let forwarded = ["x-forwarded-host: evil.example", "x-forwarded-for: 10.0.0.1", "forwarded: host=evil.example"];
    let request = forwarded.iter().fold(Request::login("ada", PASSWORD), |request, line| request.header(line));
    assert_eq!(request.to(&station).status, 200);
    station.access_events("ada (engineer) logged in from 127.0.0.1");
}

#[test]
fn a_body_must_be_small_fast_and_json() {
    let limits = Limits { head: Duration::from_secs(2), ..Limits::default() };
    let station = TestStation::with(|setup, _| setup.limits = limits);
    let page = station.login("ada");
    let post = || Request::new("POST", "/api/password").by(&page).header("content-type: application/json");
    assert_eq!(post().body(&"a".repeat(64 << 10)).to(&station).status, 400);
    assert_eq!(post().body(&"a".repeat((64 << 10) + 1)).to(&station).status, 413);
    for body in [
        "null",
        "[]",
        "{}",
        "{\"current\":1,\"new\":2}",
        "{\"current\":\"a\",\"new\":\"b\",\"role\":\"engineer\"}",
        "{\"a\":",
        "\u{0}",
    ] {
        let refused = post().body(body).to(&station);
        assert_eq!(
            (refused.status, refused.problem().as_str()),
            (400, "expected a JSON body as /api/openapi.json describes it"),
            "{body}"
        );
    }
    let mut stream = station.connect();
    stream.write_all(post().header("content-length: 100").text().as_bytes()).unwrap();
    assert_eq!(Answer::read(&mut stream).status, 408, "a body that never arrives");
}

#[test]
fn an_address_above_the_request_limit_is_refused_with_a_waiting_time() {
    let rate_limits =
        RateLimits { requests: RateLimit::new(100, Duration::from_secs(86_400)), ..RateLimits::default() };
    let station = TestStation::with(|setup, _| setup.limits = Limits { rate_limits, ..Limits::default() });
    let page = station.login("ada");
    let request = Request::get("/api/session").by(&page);
    assert!((1..100).all(|_| request.to(&station).status == 200));
    let refused = request.to(&station);
    assert_eq!(refused.status, 429);
    // A day, less the time since the burst.
    let wait: u64 = refused.header("retry-after").unwrap().parse().unwrap();
    assert!((80_000..=86_400).contains(&wait), "{wait}");
    assert_eq!(station.get("/").status, 429, "the page is limited too");
}

#[test]
fn every_answer_has_the_security_headers() {
    let station = TestStation::new();
    let page = station.login("ada");
    let policy = |answer: &Answer| answer.header("content-security-policy").unwrap().to_owned();
    let answers = [
        station.get("/"),
        station.get("/assets/none.js"),
        station.get("/api/gauges"),
        Request::get("/api/gauges").by(&page).to(&station),
        Request::get("/").host("evil.example").to(&station),
        Request::new("POST", "/").to(&station),
        logout().to(&station),
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
fn an_api_answer_is_never_rendered_as_a_page_and_never_cached() {
    let station = TestStation::new();
    let page = station.login("ada");
    for path in
        ["/api/gauges", "/api/session", "/api/export.csv?from=0&to=1", "/api/openapi.json", "/api/gauges/%3Cscript%3E"]
    {
        let answer = Request::get(path).by(&page).to(&station);
        assert!(answer.header("content-security-policy").unwrap().ends_with("sandbox"), "{path}");
        assert_eq!(answer.header("cache-control"), Some("no-store"), "{path}");
        let kind = answer.header("content-type").unwrap();
        assert!(
            ["application/json", "application/problem+json", "text/csv; charset=utf-8"].contains(&kind),
            "{path}: {kind}"
        );
    }
    let export = Request::get("/api/export.csv?from=0&to=1").by(&page).to(&station);
    assert_eq!(export.header("content-disposition"), Some("attachment; filename=\"pressures.csv\""));
    assert_eq!(station.get("/").header("content-type"), Some("text/html; charset=utf-8"));
    assert_eq!(station.get("/api/session").header("cache-control"), Some("no-store"));
}

#[test]
fn a_name_is_never_part_of_an_sql_statement() {
    let station = TestStation::new();
    let page = station.login("ada");
    for name in ["%27%20OR%201=1--", "%22;DROP%20TABLE%20event;--", "%00", "%F0%9F%92%A5", "..%2F..%2Fplant.db"] {
        let answer = Request::get(&format!("/api/trend?series={name}&from=0&to=10")).by(&page).to(&station);
        assert_eq!((answer.status, answer.json()["title"].clone()), (404, json!("Not Found")), "{name}");
        let gauge = Request::get(&format!("/api/gauges/{name}")).by(&page).to(&station);
        assert_eq!(gauge.status, 404, "{name}");
    }
    // The table of events is still there.
    station.access_events("ada (engineer) logged in");
}

#[test]
fn no_answer_holds_a_password_or_its_hash() {
    let station = TestStation::new();
    let page = station.login("ada");
    station.access_events("ada (engineer) logged in");
    for path in [
        "/api/session",
        "/api/station",
        "/api/gauges",
        "/api/segments",
        "/api/openapi.json",
        "/api/events?from=0&to=9999999999999",
    ] {
        let answer = Request::get(path).by(&page).to(&station);
        let (_, id) = page.cookie.split_once('=').unwrap();
        assert_eq!(answer.status, 200, "{path}");
        for secret in ["argon2", PASSWORD, id] {
            assert!(!answer.body.contains(secret), "{path}: {secret}");
        }
    }
}

#[test]
fn a_client_that_reads_no_answer_is_disconnected() {
    let limits = Limits { stalled: Duration::from_millis(100), ..Limits::default() };
    let station = TestStation::with(|setup, _| setup.limits = limits);
    let page = station.get("/").body;
    let script = page.split('"').find(|part| part.ends_with(".js")).unwrap();
    let requests = format!("GET {script} HTTP/1.1\r\nhost: localhost\r\n\r\n").repeat(400);
    let mut greedy = station.connect();
    greedy.write_all(requests.as_bytes()).unwrap();
    assert_eq!(greedy.peek(&mut [0]).unwrap(), 1, "the first answer begins");
    // The buffers of both systems are full of answers. Reading nothing, the client sees the end when it writes.
    let end = Instant::now() + TIMEOUT;
    while greedy.write_all(b"GET").is_ok() {
        assert!(Instant::now() < end, "a client that reads nothing keeps its connection for ever");
        pause();
    }
}

#[test]
fn live_streams_of_a_session_are_bounded_and_other_users_get_theirs() {
    let station = TestStation::new();
    let vera = station.login("vera");
    let open = |page: &Page| {
        let mut stream = station.connect();
        stream.write_all(Request::get("/api/live").cookie(page).text().as_bytes()).unwrap();
        let mut status = [0; 12];
        stream.read_exact(&mut status).unwrap();
        (String::from_utf8_lossy(&status).into_owned(), stream)
    };
    let mut own: Vec<_> = (0..16).map(|_| open(&vera)).collect();
    assert!(own.iter().all(|(status, _)| status == "HTTP/1.1 200"));
    let refused = Request::get("/api/live").cookie(&vera).to(&station);
    let expected = "expected at most 16 live streams of one session: close another page of the dashboard";
    assert_eq!((refused.status, refused.problem()), (429, expected.to_owned()));
    // With further sessions the bound of the user comes first, and it leaves places for others.
    let sessions: Vec<_> = (0..4).map(|_| station.login("vera")).collect();
    let more: Vec<_> = sessions.iter().flat_map(|page| (0..8).map(|_| open(page)).collect::<Vec<_>>()).collect();
    let granted = more.iter().filter(|(status, _)| status == "HTTP/1.1 200").count();
    assert_eq!(granted, 16, "32 in all");
    let ada = station.login("ada");
    assert_eq!(open(&ada).0, "HTTP/1.1 200");
    // A page that is closed makes room.
    own.pop();
    let end = Instant::now() + TIMEOUT;
    while open(&vera).0 != "HTTP/1.1 200" {
        assert!(Instant::now() < end, "the place of a closed stream is not free again");
        pause();
    }
}

#[test]
fn silent_clients_on_every_connection_neither_keep_out_a_login_nor_end_a_live_stream() {
    let limits = Limits { head: Duration::from_secs(86_400), ..Limits::default() };
    let station = TestStation::with(|setup, _| setup.limits = limits);
    let vera = station.login("vera");
    let mut live = station.connect();
    live.write_all(Request::get("/api/live").cookie(&vera).text().as_bytes()).unwrap();
    assert_eq!(live.read(&mut [0; 12]).unwrap(), 12);
    let begun = "POST /api/login HTTP/1.1\r\nhost: localhost\r\n";
    let silent: Vec<_> = (0..limits.connections * 2)
        .map(|number| {
            let mut stream = station.connect();
            stream.write_all(&begun.as_bytes()[..number % begun.len()]).ok();
            stream
        })
        .collect();
    assert_eq!(Request::get("/api/gauges").by(&station.login("ada")).to(&station).status, 200);
    assert!(live.read(&mut [0; 100]).unwrap() > 0);
    drop(silent);
}

#[test]
fn a_user_above_the_write_limit_is_refused_and_other_users_are_not() {
    let rate_limits = RateLimits { writes: RateLimit::new(5, Duration::from_secs(600)), ..RateLimits::default() };
    let station = TestStation::with(|setup, _| setup.limits = Limits { rate_limits, ..Limits::default() });
    let (olga, ada) = (station.login("olga"), station.login("ada"));
    let status = |page| Request::post("/api/control-authority/request", &json!(null)).by(page).to(&station).status;
    assert_eq!((0..8).filter(|_| status(&olga) == 200).count(), 5);
    assert_eq!((status(&olga), status(&ada)), (429, 200));
    assert_eq!(Request::get("/api/gauges").by(&olga).to(&station).status, 200, "reading is not limited");
}
