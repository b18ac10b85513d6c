//! Logins at an OpenID provider that is right, wrong, silent or hostile.

use crate::security::test_provider::{Reply, SigningKey, TestProvider, description, message, token, with_signature};
use crate::security::test_station::{Answer, PASSWORD, Page, Request, TestStation};
use crate::until::pause;
use profivac_web_server::auth::Access;
use profivac_web_server::auth::rate_limit::{RateLimit, RateLimits};
use profivac_web_server::server::{Limits, Server, Setup};
use ring::hmac;
use serde_json::{Value, json};
use std::time::Duration;

/// A station and its provider.
struct Lab {
    provider: TestProvider,
    key: SigningKey,
    station: TestStation,
}

/// A login that has begun.
#[derive(Clone)]
struct Begun {
    cookie: String,
    url: String,
    state: String,
    nonce: String,
}

impl Lab {
    fn new() -> Self {
        Self::with(|_| {})
    }

    fn with(change: impl FnOnce(&mut Setup)) -> Self {
        let key = SigningKey::new("first");
        let provider = TestProvider::start(&key);
        let station = TestStation::with(|setup, _| {
            setup.openid = Some(provider.settings());
            // A test logs in more often than a user.
            let rate_limits =
                RateLimits { openid: RateLimit::new(1000, Duration::from_secs(1)), ..RateLimits::default() };
            setup.limits = Limits { rate_limits, ..Limits::default() };
            change(setup);
        });
        Self { provider, key, station }
    }

    fn begin(&self) -> Begun {
        begun(&begin().to(&self.station))
    }

    /// Completes a login for which the provider issues this token.
    fn finish_with(&self, begun: &Begun, issued: &str) -> Answer {
        self.provider.issue(token(issued));
        finish(begun).to(&self.station)
    }

    /// Logs in with claims that differ from right ones.
    fn login_with(&self, change: impl FnOnce(&mut Value)) -> Answer {
        let begun = self.begin();
        let mut claims = self.provider.claims(&begun.nonce);
        change(&mut claims);
        self.finish_with(&begun, &self.key.sign(&claims))
    }

    /// Logs in with a token made from right claims.
    fn login_by(&self, make: impl FnOnce(&Value) -> String) -> Answer {
        let begun = self.begin();
        let claims = self.provider.claims(&begun.nonce);
        self.finish_with(&begun, &make(&claims))
    }

    fn session(&self, page: &Page) -> Value {
        Request::get("/api/session").by(page).to(&self.station).json()
    }
}

fn begin() -> Request {
    Request::post("/api/openid/begin", &json!({}))
}

fn begun(answer: &Answer) -> Begun {
    assert_eq!(answer.status, 200, "{answer:?}");
    let url = answer.json()["url"].as_str().unwrap().to_owned();
    let parameter = |name: &str| {
        let (_, query) = url.split_once('?').unwrap();
        let value = query.split('&').find_map(|pair| pair.strip_prefix(&format!("{name}="))).unwrap();
        value.to_owned()
    };
    let cookie = answer.header("set-cookie").unwrap().split(';').next().unwrap().to_owned();
    Begun { cookie, state: parameter("state"), nonce: parameter("nonce"), url }
}

/// The page of the station completes a login.
fn finish(begun: &Begun) -> Request {
    let body = json!({ "state": begun.state, "code": "a code" });
    Request::post("/api/openid/login", &body).header(&format!("cookie: {}", begun.cookie))
}

/// Checks that a login is refused with this sentence and gives no session.
fn assert_refused(answer: &Answer, status: u16, sentence: &str) {
    assert_eq!(answer.status, status, "{answer:?}");
    assert!(answer.problem().contains(sentence), "expected {sentence:?}: {}", answer.problem());
    assert_eq!(answer.header("set-cookie"), None);
}

#[test]
fn a_user_of_the_provider_has_a_session_with_the_role_of_the_claim() {
    let lab = Lab::new();
    let anonymous = lab.station.get("/api/session").json();
    assert_eq!(anonymous["provider"], "Lab login");
    let answer = lab.login_with(|_| {});
    assert_eq!(answer.status, 200, "{answer:?}");
    let page = Page::of(&answer);
    let session = lab.session(&page);
    assert_eq!(
        session,
        json!({
            "name": "openid:erna", "role": "engineer", "token": page.token, "login": "logged-in", "has_password": false,
            "provider": "Lab login",
        })
    );
    let cookies: Vec<_> = answer.headers.iter().filter(|(name, _)| name == "set-cookie").map(|(_, it)| it).collect();
    assert!(cookies[1].contains("-openid=; ") && cookies[1].contains("Max-Age=0"), "{cookies:?}");
    let control = Request::post("/api/control-authority/request", &json!(null)).by(&page).to(&lab.station);
    assert_eq!(control.status, 200, "{control:?}");
    let audit = Request::get("/api/audit").by(&page).to(&lab.station).body;
    assert!(audit.contains("openid:erna"), "{audit}");
    let events = lab.station.access_events("openid:erna (engineer) logged in from 127.0.0.1, subject \"4711\"");
    let secrets = [&page.token, "a code", "id_token"];
    assert!(events.iter().all(|event| secrets.iter().all(|secret| !event.contains(secret))), "{events:?}");
    let change = json!({ "current": PASSWORD, "new": "orchid ladder seventeen" });
    let refused = Request::post("/api/password", &change).by(&page).to(&lab.station);
    assert_eq!((refused.status, refused.problem().starts_with("the provider keeps")), (403, true));
    let left = Request::post("/api/logout", &json!(null)).by(&page).to(&lab.station);
    let back = form_urlencoded::byte_serialize(format!("{}/", lab.station.server.url()).as_bytes()).collect::<String>();
    let expected = format!("{}/logout?client_id=profivac&post_logout_redirect_uri={back}", lab.provider.issuer);
    assert_eq!((left.status, left.json()), (200, json!({ "url": expected })));
    assert_eq!(Request::get("/api/gauges").by(&page).to(&lab.station).status, 401);
}

#[test]
fn the_browser_and_the_provider_get_what_the_flow_needs_and_no_secret() {
    let lab = Lab::new();
    let answer = begin().to(&lab.station);
    let cookie = answer.header("set-cookie").unwrap();
    assert!(cookie.ends_with("; Path=/; HttpOnly; SameSite=Strict; Max-Age=600"), "{cookie}");
    let begun = begun(&answer);
    let start = format!("{}/authorize?tenant=lab&response_type=code&client_id=profivac&", lab.provider.issuer);
    assert!(begun.url.starts_with(&start), "{}", begun.url);
    let back =
        form_urlencoded::byte_serialize(format!("{}/openid", lab.station.server.url()).as_bytes()).collect::<String>();
    let parameters =
        [format!("redirect_uri={back}"), "scope=openid+profile".into(), "code_challenge_method=S256".into()];
    assert!(parameters.iter().all(|parameter| begun.url.contains(parameter.as_str())), "{}", begun.url);
    assert_eq!(lab.finish_with(&begun, &lab.key.sign(&lab.provider.claims(&begun.nonce))).status, 200);
    let asked = lab.provider.asked("/token");
    assert_eq!(asked.len(), 1);
    let form: Vec<_> = form_urlencoded::parse(asked[0].as_bytes()).into_owned().collect();
    let value = |name: &str| form.iter().find(|(other, _)| other == name).map(|(_, value)| value.clone()).unwrap();
    assert_eq!((value("grant_type"), value("code")), ("authorization_code".to_owned(), "a code".to_owned()));
    let digest = ring::digest::digest(&ring::digest::SHA256, value("code_verifier").as_bytes());
    let challenge = base64::Engine::encode(&base64::engine::general_purpose::URL_SAFE_NO_PAD, digest);
    assert!(begun.url.contains(&format!("code_challenge={challenge}&")), "{}", begun.url);
    for secret in [value("code_verifier").as_str(), "a secret", begun.cookie.split('=').nth(1).unwrap()] {
        assert!(!begun.url.contains(secret), "{secret}");
    }
    assert!(!form.iter().any(|(name, _)| name == "client_secret"), "it is in a header");
}

#[test]
fn a_token_that_is_not_for_this_login_is_refused() {
    let lab = Lab::new();
    let now = lab.provider.claims("")["iat"].as_u64().unwrap();
    let cases: [(&str, Value, &str); 19] = [
        ("iss", json!("http://evil.example"), "expected an ID token of"),
        ("iss", json!(null), "expected the claim iss"),
        ("aud", json!("other"), "for another client"),
        ("aud", json!(["other"]), "for another client"),
        ("aud", json!(["profivac", "other"]), "for another client"),
        ("aud", json!(null), "the audience (aud) of the ID token is empty"),
        ("aud", json!([]), "the audience (aud) of the ID token is empty"),
        ("aud", json!(""), "the audience (aud) of the ID token is empty"),
        ("azp", json!("other"), "for another client"),
        ("exp", json!(now - 120), "exp is -"),
        ("exp", json!("never"), "expected the claim exp"),
        ("exp", json!(null), "expected the claim exp"),
        ("iat", json!(now + 600), "iat is "),
        ("iat", json!(now - 900), "iat is -"),
        ("iat", json!([now]), "expected the claim iat"),
        ("nbf", json!(now + 600), "nbf is "),
        ("nonce", json!("ab".repeat(32)), "belongs to another login"),
        ("nonce", json!(null), "expected the claim nonce"),
        ("sub", json!(""), "expected the claim sub"),
    ];
    for (claim, value, sentence) in cases {
        let answer = lab.login_with(|claims| claims[claim] = value.clone());
        assert_refused(&answer, 403, sentence);
    }
    let several = lab.login_with(|claims| {
        claims["aud"] = json!(["profivac", "other"]);
        claims["azp"] = json!("profivac");
    });
    assert_eq!(several.status, 200, "the clocks differ by less than a minute, and it is for this client");
    let skewed = lab.login_with(|claims| {
        let now = claims["iat"].as_u64().unwrap();
        claims["iat"] = json!(now + 50);
        claims["exp"] = json!(now - 10);
    });
    assert_eq!(skewed.status, 200, "{skewed:?}");
}

#[test]
fn a_token_that_the_provider_has_not_signed_is_refused() {
    let lab = Lab::new();
    let (key, foreign) = (&lab.key, SigningKey::new("first"));
    let unsigned = |algorithm: &str| {
        let header = json!({ "alg": algorithm, "kid": "first" });
        lab.login_by(|claims| message(&header, claims) + ".")
    };
    for algorithm in ["none", "None", "NONE", "", "RS1", "es256"] {
        assert_refused(&unsigned(algorithm), 403, "expected an ID token signed with RS256");
    }
    assert_refused(&unsigned("ES256"), 403, "the signature of the ID token is wrong");
    for secret in [key.octets(), key.public().to_string().into_bytes()] {
        let shared = lab.login_by(|claims| {
            let message = message(&json!({ "alg": "HS256", "kid": "first" }), claims);
            let tag = hmac::sign(&hmac::Key::new(hmac::HMAC_SHA256, &secret), message.as_bytes());
            with_signature(&message, tag.as_ref())
        });
        assert_refused(&shared, 403, "expected an ID token signed with RS256");
    }
    assert_refused(&lab.login_by(|claims| foreign.sign(claims)), 403, "the signature of the ID token is wrong");
    let confused = lab.login_by(|claims| key.sign_as(&json!({ "alg": "RS256", "kid": "first" }), claims));
    assert_refused(&confused, 403, "signed with a key that the provider publishes");
    let changed = lab.login_by(|claims| {
        let token = key.sign(claims);
        let (_, signature) = token.rsplit_once('.').unwrap();
        let mut claims = claims.clone();
        claims["preferred_username"] = "ada".into();
        format!("{}.{signature}", message(&json!({ "alg": "ES256", "kid": "first" }), &claims))
    });
    assert_refused(&changed, 403, "the signature of the ID token is wrong");
    let own_key = json!({ "alg": "ES256", "jwk": foreign.public() });
    assert_refused(&lab.login_by(|claims| foreign.sign_as(&own_key, claims)), 403, "the signature of the ID token");
    let critical = json!({ "alg": "ES256", "kid": "first", "crit": ["b64"], "b64": false });
    assert_refused(&lab.login_by(|claims| key.sign_as(&critical, claims)), 403, "expected a signed ID token");
    for text in ["", "..", "a.b.c", "e30.e30.", "eyJhbGciOiJFUzI1NiJ9.W10.AAAA", &"a".repeat(40_000), "ä.ö.ü"] {
        assert_refused(&lab.login_by(|_| text.to_owned()), 403, "expected a signed ID token");
    }
    assert_eq!(lab.login_by(|claims| key.sign_as(&json!({ "alg": "ES256" }), claims)).status, 200, "one key, no name");
}

#[test]
fn an_unknown_key_reloads_the_keys_a_few_times_only() {
    let lab = Lab::new();
    assert_eq!(lab.login_with(|_| {}).status, 200);
    assert_eq!(lab.login_with(|_| {}).status, 200);
    assert_eq!(lab.provider.asked("/keys").len(), 1, "the keys are kept");
    let second = SigningKey::new("second");
    lab.provider.publish(Reply::Json(200, json!({ "keys": [{ "kty": "unknown" }, second.public()] })));
    assert_eq!(lab.login_by(|claims| second.sign(claims)).status, 200, "the provider has a new key");
    assert_refused(&lab.login_with(|_| {}), 403, "signed with a key that the provider publishes");
    for _ in 0..12 {
        let unknown = SigningKey::new("unknown");
        assert_refused(
            &lab.login_by(|claims| unknown.sign(claims)),
            403,
            "signed with a key that the provider publishes",
        );
    }
    assert_eq!(lab.provider.asked("/keys").len(), 1 + 3, "further reloads wait");
}

#[test]
fn a_login_is_completed_once_and_by_the_browser_that_began_it() {
    let lab = Lab::new();
    let (one, other) = (lab.begin(), lab.begin());
    let issue = |begun: &Begun| lab.provider.issue(token(&lab.key.sign(&lab.provider.claims(&begun.nonce))));
    let not_pending = "this login began more than 10 minutes ago, in another window or in another browser";
    issue(&one);
    let stolen = Begun { cookie: other.cookie.clone(), ..one.clone() };
    assert_refused(&finish(&stolen).to(&lab.station), 403, not_pending);
    let without = Request::post("/api/openid/login", &json!({ "state": one.state, "code": "a code" }));
    assert_refused(&without.to(&lab.station), 403, not_pending);
    for state in ["", "x", &"0".repeat(64), &one.nonce] {
        let guessed = Begun { state: state.to_owned(), ..one.clone() };
        assert_refused(&finish(&guessed).to(&lab.station), 403, not_pending);
    }
    assert!(lab.provider.asked("/token").is_empty(), "the provider is not asked for a login that is not pending");
    assert_eq!(finish(&one).to(&lab.station).status, 200, "the attempts of others do not end it");
    assert_refused(&finish(&one).to(&lab.station), 403, not_pending);
    // The token of one login is none of another one.
    assert_refused(&finish(&other).to(&lab.station), 403, "belongs to another login");
}

#[test]
fn a_foreign_page_neither_begins_nor_completes_a_login() {
    let lab = Lab::new();
    let pending = lab.begin();
    for line in
        ["sec-fetch-site: cross-site", "sec-fetch-site: same-site", "origin: http://evil.example", "origin: null"]
    {
        assert_eq!(begin().header(line).to(&lab.station).status, 403, "{line}");
        assert_eq!(finish(&pending).header(line).to(&lab.station).status, 403, "{line}");
    }
    for path in ["/api/openid/begin", "/api/openid/login"] {
        let form = Request::new("POST", path).header("content-type: application/x-www-form-urlencoded").body("state=a");
        assert_eq!(form.to(&lab.station).status, 415, "{path}");
        assert_eq!(Request::new("POST", path).to(&lab.station).status, 400, "{path}: without a body");
        assert_eq!(lab.station.get(path).status, 405, "{path}");
    }
    let page = lab.station.get("/openid?code=a&state=b");
    assert_eq!(
        (page.status, page.header("location"), page.header("set-cookie")),
        (200, None, None),
        "a page, no redirect"
    );
    assert_eq!(page.header("referrer-policy"), Some("no-referrer"));
}

#[test]
fn a_page_at_another_address_is_told_where_the_login_works() {
    let lab = Lab::with(|setup| {
        setup.hosts = vec!["vacuum.example".to_owned()];
        setup.openid.as_mut().unwrap().url = Some("https://vacuum.example".to_owned());
    });
    let at = |host: &str, origin: &str| begin().host(host).header(&format!("origin: {origin}")).to(&lab.station);
    assert_refused(&at("localhost", "http://localhost"), 403, "open https://vacuum.example to log in");
    let right = at("vacuum.example", "https://vacuum.example");
    let cookie = right.header("set-cookie").unwrap();
    assert!(cookie.starts_with("__Host-profivac-") && cookie.contains("; Secure"), "{cookie}");
    assert!(begun(&right).url.contains("redirect_uri=https%3A%2F%2Fvacuum.example%2Fopenid&"));
}

#[test]
fn a_user_without_a_role_or_with_an_unusable_name_is_refused_with_the_claim() {
    let lab = Lab::new();
    let no_role = lab.login_with(|claims| claims["groups"] = json!(["staff"]));
    assert_refused(&no_role, 403, "openid:erna has no role at this station: expected in the claim groups a value");
    let no_name = lab.login_with(|claims| claims["preferred_username"] = json!(null));
    assert_refused(&no_name, 403, "expected the name of the user in the claim preferred_username");
    for name in ["a\u{202E}b", "../ada", "a\u{1b}[31m"] {
        let refused = lab.login_with(|claims| claims["preferred_username"] = name.into());
        assert_refused(&refused, 403, "the claim preferred_username has no usable name");
    }
    lab.station.access_events("by Lab login refused: openid:erna has no role at this station");
}

#[test]
fn a_name_of_two_users_of_the_provider_or_of_the_file_is_never_the_same() {
    let lab = Lab::new();
    let erna = Page::of(&lab.login_with(|_| {}));
    let other = lab.login_with(|claims| claims["sub"] = "4712".into());
    assert_refused(&other, 403, "another user of the provider is logged in as openid:erna");
    assert_eq!(lab.session(&erna)["login"], "logged-in");
    let ada = Page::of(&lab.login_with(|claims| claims["preferred_username"] = "ada".into()));
    let of_the_file = lab.station.login("ada");
    assert_eq!([&ada, &of_the_file].map(|page| lab.session(page)["name"].clone()), ["openid:ada", "ada"]);
    lab.station.change(|users| users.remove("ada").unwrap());
    lab.station.access_events("the user ada was removed");
    assert_eq!(Request::get("/api/gauges").by(&of_the_file).to(&lab.station).status, 401);
    assert_eq!(Request::get("/api/gauges").by(&ada).to(&lab.station).status, 200);
}

#[test]
fn a_login_with_another_role_takes_control_authority_away() {
    let lab = Lab::new();
    let engineer = Page::of(&lab.login_with(|_| {}));
    let request = Request::post("/api/control-authority/request", &json!(null)).by(&engineer).to(&lab.station);
    assert_eq!(request.status, 200, "{request:?}");
    let viewer = Page::of(&lab.login_with(|claims| claims["groups"] = json!(["viewer"])));
    assert_eq!(Request::get("/api/gauges").by(&engineer).to(&lab.station).status, 401, "the role of before has ended");
    let control = Request::get("/api/control-authority").by(&viewer).to(&lab.station).json();
    assert_eq!(control["holder"], Value::Null, "{control}");
}

#[test]
fn a_provider_with_wrong_answers_gives_a_sentence() {
    let lab = Lab::new();
    let beyond = "it did not answer";
    let describe = |reply: Reply, sentence: &str| {
        lab.provider.describe(reply);
        let answer = begin().to(&lab.station);
        assert_refused(&answer, 503, sentence);
        assert!(answer.problem().starts_with("Lab login cannot be asked: "), "{}", answer.problem());
        assert!(answer.problem().ends_with("; try again, or log in with a name and a password of this station"));
        assert!(!answer.problem().contains(beyond));
    };
    describe(Reply::Endless, "its answer cannot be read (at most 262144 octets)");
    describe(Reply::Json(500, json!({})), "expected an answer with status 200 from 127.0.0.1, found 500");
    describe(Reply::Json(302, json!({})), "found 302");
    describe(Reply::Json(200, json!([])), "expected its description as JSON");
    describe(Reply::Json(200, description("http://127.0.0.1:1")), "expected the issuer");
    let mut elsewhere = description(&lab.provider.issuer);
    elsewhere["token_endpoint"] = "http://10.0.0.1/token".into();
    describe(Reply::Json(200, elsewhere), "expected a URL with https as its token_endpoint");
    lab.provider.describe(Reply::Json(200, description(&lab.provider.issuer)));
    let finished = |issued: Reply, sentence: &str| {
        let begun = lab.begin();
        lab.provider.issue(issued);
        assert_refused(&finish(&begun).to(&lab.station), 503, sentence);
    };
    finished(Reply::Endless, "its answer cannot be read");
    finished(
        Reply::Json(400, json!({ "error": "invalid_grant<script>\u{202E}" })),
        "it does not accept the request of the station: invalid_grantscript;",
    );
    finished(Reply::Json(200, json!({ "access_token": "a" })), "expected an ID token in its answer");
    let right = || token(&lab.key.sign(&lab.provider.claims("")));
    lab.provider.publish(Reply::Endless);
    finished(right(), "its answer cannot be read");
    lab.provider.publish(Reply::Json(200, json!({ "keys": 5 })));
    finished(right(), "expected its keys as a JSON Web Key Set");
    let begun = lab.begin();
    let refusal = json!({ "state": begun.state, "error": "access_denied" });
    let refused = Request::post("/api/openid/login", &refusal).header(&format!("cookie: {}", begun.cookie));
    assert_refused(&refused.to(&lab.station), 403, "Lab login has refused the login: access_denied");
    let begun = lab.begin();
    let other = json!({ "state": begun.state, "code": "a", "iss": "http://evil.example" });
    let other = Request::post("/api/openid/login", &other).header(&format!("cookie: {}", begun.cookie));
    assert_refused(&other.to(&lab.station), 403, "the answer is not that of Lab login");
}

#[test]
fn a_silent_provider_delays_neither_passwords_nor_other_requests() {
    let lab = Lab::new();
    lab.provider.describe(Reply::Silence);
    let waiting: Vec<_> = (0..8)
        .map(|_| {
            let mut stream = lab.station.connect();
            std::io::Write::write_all(&mut stream, begin().text().as_bytes()).unwrap();
            stream
        })
        .collect();
    while lab.provider.asked("/.well-known/openid-configuration").is_empty() {
        pause();
    }
    let page = lab.station.login("ada");
    assert_eq!(Request::get("/api/gauges").by(&page).to(&lab.station).status, 200);
    let mut streams = waiting;
    for stream in &mut streams {
        stream.set_nonblocking(true).unwrap();
        let mut octet = [0];
        let read = std::io::Read::read(stream, &mut octet);
        assert!(matches!(read, Err(error) if error.kind() == std::io::ErrorKind::WouldBlock), "all logins still wait");
    }
}

#[test]
fn a_silent_provider_is_given_up_with_a_sentence() {
    let lab = Lab::with(|setup| setup.openid.as_mut().unwrap().timeout = Duration::from_millis(50));
    lab.provider.describe(Reply::Silence);
    assert_refused(&begin().to(&lab.station), 503, "it did not answer within 0.05 s; try again");
    lab.station.access_events("login from 127.0.0.1 by Lab login refused: Lab login cannot be asked");
}

#[test]
fn a_provider_that_is_down_at_the_start_is_found_later() {
    let lab = Lab::new();
    lab.provider.describe(Reply::Json(503, json!({})));
    assert_refused(&begin().to(&lab.station), 503, "found 503");
    assert_eq!(lab.station.login("ada").token.len(), 64);
    lab.provider.describe(Reply::Json(200, description(&lab.provider.issuer)));
    assert_eq!(lab.login_with(|_| {}).status, 200);
}

#[test]
fn steps_of_logins_are_limited_and_passwords_are_not_affected() {
    let rate_limits = RateLimits { openid: RateLimit::new(4, Duration::from_secs(3600)), ..RateLimits::default() };
    let lab = Lab::with(|setup| setup.limits = Limits { rate_limits, ..Limits::default() });
    let statuses: Vec<_> = (0..6).map(|_| begin().to(&lab.station).status).collect();
    assert_eq!(statuses, [200, 200, 200, 200, 429, 429]);
    lab.station.login("ada");
}

#[test]
fn a_provider_must_know_where_the_dashboard_is() {
    let lab = Lab::new();
    let access = Access::Users(lab.station.file("users.toml"));
    let setup = Setup::new("0.0.0.0:0".parse().unwrap(), access);
    let error = Server::check(&Setup { openid: Some(lab.provider.settings()), ..setup }).unwrap_err().to_string();
    assert!(error.contains("needs url in [openid]"), "{error}");
}

#[test]
fn a_station_without_a_provider_has_no_such_login() {
    let station = TestStation::new();
    assert_eq!(station.get("/api/session").json()["provider"], Value::Null);
    assert_refused(&begin().to(&station), 404, "this station has no OpenID provider");
    let completed = Request::post("/api/openid/login", &json!({ "state": "a", "code": "b" }));
    assert_refused(&completed.to(&station), 404, "this station has no OpenID provider");
}
