//! HTTP/2 over TLS, with the client of hyper.

use crate::security::test_station::{PASSWORD, Page, TestStation, certificate};
use crate::support;
use crate::support::inputs::{inputs, snapshot};
use axum::body::{Body, BodyDataStream, to_bytes};
use hyper::body::Incoming;
use hyper::client::conn::http2::{Builder, SendRequest};
use hyper::{Request, Response};
use hyper_util::rt::{TokioExecutor, TokioIo};
use profivac_recorder::Quality;
use profivac_web_server::server::Limits;
use serde_json::{Value, json};
use std::convert::Infallible;
use std::path::Path;
use std::sync::Arc;
use std::time::Duration;
use tokio::io::AsyncReadExt;
use tokio::net::TcpStream;
use tokio::task::{JoinHandle, JoinSet};
use tokio_rustls::TlsConnector;
use tokio_rustls::client::TlsStream;
use tokio_rustls::rustls::crypto::ring::default_provider;
use tokio_rustls::rustls::pki_types::pem::PemObject;
use tokio_rustls::rustls::pki_types::{CertificateDer, ServerName};
use tokio_rustls::rustls::{ClientConfig, RootCertStore};
use tokio_stream::StreamExt;

const ALARM: &str = r#"
[[segment]]
name = "hall"
port = "/dev/ttyUSB0"
[[segment.gauge]]
name = "chamber"
address = 5
device = "bcg450"
[[alarm]]
name = "too high"
gauge = "chamber"
above = "1e-3 mbar"
delay = "0 s"
"#;

fn run<T>(test: impl Future<Output = T>) -> T {
    tokio::runtime::Builder::new_current_thread().enable_all().build().unwrap().block_on(test)
}

/// A connection whose client offers these protocols.
async fn tls(station: &TestStation, protocols: &[&str]) -> TlsStream<TcpStream> {
    let mut roots = RootCertStore::empty();
    roots.add(CertificateDer::from_pem_file(station.file("a.pem")).unwrap()).unwrap();
    let mut config = ClientConfig::builder_with_provider(Arc::new(default_provider()))
        .with_safe_default_protocol_versions()
        .unwrap()
        .with_root_certificates(roots)
        .with_no_client_auth();
    config.alpn_protocols = protocols.iter().map(|name| name.as_bytes().to_vec()).collect();
    let stream = TcpStream::connect(("127.0.0.1", station.port())).await.unwrap();
    let name = ServerName::try_from("localhost").unwrap();
    TlsConnector::from(Arc::new(config)).connect(name, stream).await.unwrap()
}

/// A client on one connection.
struct Client {
    sender: SendRequest<Body>,
    connection: JoinHandle<hyper::Result<()>>,
}

impl Client {
    async fn new(station: &TestStation) -> Self {
        Self::with(station, &Builder::new(TokioExecutor::new())).await
    }

    async fn with(station: &TestStation, builder: &Builder<TokioExecutor>) -> Self {
        let stream = tls(station, &["h2", "http/1.1"]).await;
        let (sender, connection) = builder.handshake(TokioIo::new(stream)).await.unwrap();
        Self { sender, connection: tokio::spawn(connection) }
    }

    async fn send(&mut self, method: &str, path: &str, page: Option<&Page>, body: &str) -> Response<Incoming> {
        let mut request = Request::builder().method(method).uri(format!("https://localhost{path}"));
        if let Some(Page { cookie, token }) = page {
            request = request.header("cookie", cookie).header("x-csrf-token", token);
        }
        if method == "POST" {
            request = request.header("content-type", "application/json").header("origin", "https://localhost");
        }
        let request = request.body(Body::from(body.to_owned())).unwrap();
        self.sender.send_request(request).await.unwrap()
    }

    async fn json(&mut self, method: &str, path: &str, page: &Page, body: &Value) -> Value {
        let body = if method == "POST" { body.to_string() } else { String::new() };
        let response = self.send(method, path, Some(page), &body).await;
        assert_eq!(response.status().as_u16(), 200, "{path}");
        json_of(response).await
    }

    async fn login(&mut self, name: &str) -> Page {
        let body = json!({ "name": name, "password": PASSWORD }).to_string();
        let response = self.send("POST", "/api/login", None, &body).await;
        assert_eq!(response.status().as_u16(), 200);
        let cookie = response.headers()["set-cookie"].to_str().unwrap().split(';').next().unwrap().to_owned();
        assert!(cookie.starts_with("__Host-profivac-"), "{cookie}");
        let session = json_of(response).await;
        Page { cookie, token: session["token"].as_str().unwrap().to_owned() }
    }

    /// The events of a live stream.
    async fn live(&mut self, page: &Page) -> BodyDataStream {
        let response = self.send("GET", "/api/live", Some(page), "").await;
        assert_eq!(response.status().as_u16(), 200);
        Body::new(response.into_body()).into_data_stream()
    }
}

async fn json_of(response: Response<Incoming>) -> Value {
    let octets = to_bytes(Body::new(response.into_body()), usize::MAX).await.unwrap();
    serde_json::from_slice(&octets).unwrap()
}

#[test]
fn twelve_windows_share_a_connection_with_the_acknowledgement_of_an_alarm() {
    let folder = tempfile::tempdir().unwrap();
    let services = support::services(folder.path());
    let rules = profivac_config::parse(ALARM, Path::new("plant.toml")).unwrap().alarms;
    services.alarms().start(rules, Vec::new()).unwrap();
    services.snapshots().publish(snapshot(1.0, Quality::Valid));
    services.alarms().evaluate(&inputs(0.5, Quality::Valid));
    let station = TestStation::over_with_tls(&services);
    run(async {
        let mut client = Client::new(&station).await;
        let olga = client.login("olga").await;
        let mut windows = Vec::new();
        for _ in 0..12 {
            windows.push(client.live(&olga).await);
        }
        for window in &mut windows {
            assert!(!window.next().await.unwrap().unwrap().is_empty());
        }
        let alarms = client.json("GET", "/api/alarms", &olga, &Value::Null).await;
        let alarm = alarms.as_array().unwrap().iter().find(|alarm| alarm["name"] == "too high").unwrap();
        let seen = json!({ "occurrence": alarm["occurrence"] });
        let acknowledged = client.json("POST", "/api/alarms/too%20high/acknowledge", &olga, &seen).await;
        assert_eq!(acknowledged["state"], "acknowledged");
        assert_eq!(acknowledged["acknowledged_by"], "olga");
        for window in &mut windows {
            assert!(!window.next().await.unwrap().unwrap().is_empty(), "the streams go on");
        }
        assert!(!client.connection.is_finished());
    });
}

#[test]
fn a_client_that_offers_no_http2_gets_http_1_1() {
    let station = TestStation::with_tls();
    run(async {
        let offers: [(&[&str], Option<&[u8]>); 3] =
            [(&["h2", "http/1.1"], Some(b"h2")), (&["http/1.1"], Some(b"http/1.1")), (&[], None)];
        for (offered, chosen) in offers {
            let stream = tls(&station, offered).await;
            assert_eq!(stream.get_ref().1.alpn_protocol(), chosen, "{offered:?}");
        }
    });
}

#[test]
fn the_limits_of_a_request_hold_with_http2() {
    let station = TestStation::with_tls();
    run(async {
        let mut client = Client::new(&station).await;
        let ada = client.login("ada").await;
        let status = |response: Response<Incoming>| response.status().as_u16();
        let long = Page { cookie: format!("{}; a={}", ada.cookie, "a".repeat(40_000)), token: ada.token.clone() };
        assert_eq!(status(client.send("GET", "/api/gauges", Some(&long), "").await), 431);
        let body = format!("\"{}\"", "a".repeat(64 << 10));
        assert_eq!(status(client.send("POST", "/api/logout", Some(&ada), &body).await), 413);
        assert_eq!(status(client.send("GET", "/api/gauges", None, "").await), 401);
        let foreign = Page { token: "0".repeat(64), ..ada.clone() };
        assert_eq!(status(client.send("POST", "/api/logout", Some(&foreign), "").await), 403);
        for host in ["https://evil.example/", "https://localhost.evil.example/api/gauges"] {
            let request = Request::builder().uri(host).body(Body::empty()).unwrap();
            assert_eq!(status(client.sender.send_request(request).await.unwrap()), 421, "{host}");
        }
        // A refusal ends its request alone.
        assert_eq!(status(client.send("GET", "/api/gauges", Some(&ada), "").await), 200);
    });
}

#[test]
fn before_a_login_a_connection_has_few_bodies_at_the_same_time() {
    let station = TestStation::with_tls();
    run(async {
        let mut client = Client::new(&station).await;
        let long = json!({ "name": "ada", "password": "a".repeat(16 << 10) }).to_string();
        assert_eq!(client.send("POST", "/api/login", None, &long).await.status().as_u16(), 413);
        let mut sent = JoinSet::new();
        for _ in 0..5 {
            let endless = Body::from_stream(tokio_stream::pending::<Result<String, Infallible>>());
            let request = Request::post("https://localhost/api/login").header("content-type", "application/json");
            let request = request.header("origin", "https://localhost").body(endless).unwrap();
            let mut sender = client.sender.clone();
            sent.spawn(async move { sender.send_request(request).await });
        }
        // The others wait for their bodies.
        let refused = sent.join_next().await.unwrap().unwrap().unwrap();
        assert_eq!(refused.status().as_u16(), 429);
        assert_eq!(client.send("GET", "/api/session", None, "").await.status().as_u16(), 200);
    });
}

#[test]
fn a_connection_of_http2_without_requests_ends() {
    let station = TestStation::with(|setup, folder| {
        setup.tls = Some(certificate(folder));
        setup.limits = Limits { head: Duration::from_millis(500), ..Limits::default() };
    });
    run(async {
        // One that sends nothing, not even the first octets of HTTP/2.
        let mut silent = tls(&station, &["h2"]).await;
        let _ended = silent.read_to_end(&mut Vec::new()).await;
        let client = Client::new(&station).await;
        let _ended = client.connection.await.unwrap();
        drop(client.sender);
    });
}

#[test]
fn a_client_of_http2_that_reads_no_answer_is_disconnected() {
    let station = TestStation::with(|setup, folder| {
        setup.tls = Some(certificate(folder));
        setup.limits = Limits { stalled: Duration::from_millis(100), ..Limits::default() };
    });
    run(async {
        let vera = Client::new(&station).await.login("vera").await;
        let mut builder = Builder::new(TokioExecutor::new());
        // The station may send one octet of each answer.
        builder.initial_stream_window_size(1);
        let mut client = Client::with(&station, &builder).await;
        let unread = client.live(&vera).await;
        let _ended = client.connection.await.unwrap();
        drop(unread);
    });
}
