//! The HTTPS server of an archive: its answers to requests octet by octet, without a database.

#![allow(clippy::unwrap_used, clippy::panic, reason = "a test")]

use profivac_archive::config::{Https, Sender};
use profivac_archive::https::{Job, MAX_BODY, MAX_REPLY, Server};
use profivac_archive::metrics::Metrics;
use profivac_archive::pending::{Pending, PendingError};
use profivac_web_server::tables::Secret;
use std::io::{Read, Write};
use std::net::{SocketAddr, TcpStream};
use std::sync::mpsc;
use tokio::runtime::Runtime;
use tokio::task::JoinHandle;

/// A server whose batches `take` commits or drops.
struct Running {
    address: SocketAddr,
    runtime: Runtime,
}

fn secret(text: &str) -> Secret {
    toml::from_str::<std::collections::BTreeMap<String, Secret>>(&format!("a = \"{text}\""))
        .unwrap()
        .remove("a")
        .unwrap()
}

fn sender(name: &str, token: &str) -> Sender {
    Sender { plant: "hall".to_owned(), name: name.to_owned(), token: secret(token) }
}

fn start(take: impl FnMut(Job) + Send + 'static) -> Running {
    start_and(|_| {}, take)
}

fn start_and(look: impl FnOnce(&Server), take: impl FnMut(Job) + Send + 'static) -> Running {
    let stations = vec![sender("hall-1", "token-of-hall-1"), sender("hall-2", "token-of-hall-2")];
    let https = Https { listen: "127.0.0.1:0".parse().unwrap(), tls: None, stations };
    let runtime = tokio::runtime::Builder::new_multi_thread().worker_threads(1).enable_all().build().unwrap();
    let server = runtime.block_on(Server::bind(&https, &Metrics::default())).unwrap();
    let address = server.url().strip_prefix("http://").unwrap().parse().unwrap();
    look(&server);
    drop(runtime.spawn(server.serve_with(take)));
    Running { address, runtime }
}

/// A server and the requests that its stations poll for.
fn start_with_requests() -> (Running, Pending) {
    let mut pending = None;
    let server = start_and(|server| pending = Some(server.pending()), |_| panic!("a batch came through"));
    (server, pending.unwrap())
}

/// Polls and returns the id and the body of the request that a user asks meanwhile.
fn poll(server: &Running, station: &str) -> (String, String) {
    let path = format!("/v1/hall/{station}/request");
    let answer = ask(server, "GET", &path, &with_token(&format!("token-of-{station}"), 0), b"");
    assert!(answer.starts_with("HTTP/1.1 200 "), "{answer}");
    let (head, body) = answer.split_once("\r\n\r\n").unwrap();
    let id = head.lines().find_map(|line| line.strip_prefix("profivac-request: ")).unwrap();
    (id.to_owned(), body.to_owned())
}

/// A user asks a station as soon as it polls.
fn user(server: &Running, pending: &Pending, station: &'static str) -> JoinHandle<Result<Vec<u8>, PendingError>> {
    let pending = pending.clone();
    server.runtime.spawn(async move {
        loop {
            match pending.ask("hall", station, b"{}".to_vec()).await {
                Err(PendingError::NotConnected) => tokio::task::yield_now().await,
                answer => return answer,
            }
        }
    })
}

/// The whole answer to a request that closes its connection.
fn ask(server: &Running, method: &str, path: &str, headers: &str, body: &[u8]) -> String {
    let mut stream = TcpStream::connect(server.address).unwrap();
    let head = format!("{method} {path} HTTP/1.1\r\nHost: archive\r\nConnection: close\r\n{headers}\r\n");
    stream.write_all(head.as_bytes()).unwrap();
    stream.write_all(body).unwrap();
    let mut answer = String::new();
    stream.read_to_string(&mut answer).unwrap();
    answer
}

fn with_token(token: &str, length: usize) -> String {
    format!("Authorization: Bearer {token}\r\nContent-Length: {length}\r\n")
}

#[test]
fn the_answer_follows_the_commit() {
    let (jobs, taken) = mpsc::channel();
    let server = start(move |job| jobs.send(job).unwrap());
    std::thread::scope(|scope| {
        let answer =
            scope.spawn(|| ask(&server, "POST", "/v1/hall/hall-1/5/7", &with_token("token-of-hall-1", 3), b"abc"));
        let job = taken.recv().unwrap();
        assert!(!answer.is_finished());
        let message = &job.message;
        assert_eq!((message.subject.as_str(), message.id.as_str()), ("profivac.v1.hall.hall-1.batch", "hall-1/5/7"));
        assert_eq!(message.payload, b"abc");
        job.committed.send(None).unwrap();
        assert!(answer.join().unwrap().starts_with("HTTP/1.1 204 "));
    });
}

#[test]
fn a_batch_without_commit_is_refused() {
    let server = start(drop);
    let answer = ask(&server, "POST", "/v1/hall/hall-1/5/7", &with_token("token-of-hall-1", 3), b"abc");
    assert!(answer.starts_with("HTTP/1.1 503 "), "{answer}");
    assert!(answer.contains("the database of the archive does not answer"), "{answer}");
}

#[test]
fn a_wrong_token_station_path_method_and_length_are_refused_before_the_body_is_read() {
    let server = start(|_| panic!("a batch came through"));
    let batch = "/v1/hall/hall-1/5/7";
    let cases = [
        ("POST", batch, String::new(), "401", "compare token-file at both ends"),
        ("POST", batch, with_token("token-of-hall-3", 9), "401", "compare token-file at both ends"),
        ("POST", batch, with_token("token-of-hall-2", 9), "403", "the token is that of station hall-2 of plant hall"),
        (
            "POST",
            "/v1/ring/hall-1/5/7",
            with_token("token-of-hall-1", 9),
            "403",
            "that of station hall-1 of plant hall",
        ),
        ("POST", batch, with_token("token-of-hall-1", MAX_BODY + 1), "413", "at most 786432 octets"),
        ("POST", "/v1/hall", with_token("token-of-hall-1", 9), "404", "expected /v1/PLANT/STATION/EPOCH/NUMBER"),
        ("GET", "/v1/hall/hall-1/request", String::new(), "401", "compare token-file at both ends"),
        (
            "GET",
            "/v1/hall/hall-1/request",
            with_token("token-of-hall-2", 0),
            "403",
            "that of station hall-2 of plant hall",
        ),
        ("POST", "/v1/hall/hall-1/request/5", with_token("token-of-hall-2", 9), "403", "that of station hall-2"),
        ("POST", "/v1/ring/hall-1/request/5", with_token("token-of-hall-1", 9), "403", "that of station hall-1"),
        ("POST", "/v1/hall/hall-1/request/5", with_token("token-of-hall-1", 9), "410", "no user waits for this reply"),
        ("POST", "/v1/hall/hall-1/x/7", with_token("token-of-hall-1", 9), "400", "x"),
        ("GET", batch, with_token("token-of-hall-1", 9), "405", "expected POST"),
    ];
    for (method, path, headers, status, reason) in cases {
        let answer = ask(&server, method, path, &headers, b"");
        assert!(answer.starts_with(&format!("HTTP/1.1 {status} ")), "{method} {path}: {answer}");
        assert!(answer.contains(reason), "{answer}\nexpected {reason}");
    }
}

#[test]
fn a_body_without_a_length_has_the_same_limit() {
    let server = start(|_| panic!("a batch came through"));
    let mut body = format!("{:x}\r\n", MAX_BODY + 1).into_bytes();
    body.resize(body.len() + MAX_BODY + 1, 0);
    let headers = "Authorization: Bearer token-of-hall-1\r\nTransfer-Encoding: chunked\r\n";
    let mut stream = TcpStream::connect(server.address).unwrap();
    write!(stream, "POST /v1/hall/hall-1/5/7 HTTP/1.1\r\nHost: archive\r\n{headers}\r\n").unwrap();
    // The server may close the connection before it has read everything.
    stream.write_all(&body).ok();
    let mut answer = [0; 12];
    match stream.read_exact(&mut answer) {
        Ok(()) => assert_eq!(&answer, b"HTTP/1.1 413"),
        Err(error) => assert_eq!(error.kind(), std::io::ErrorKind::ConnectionReset),
    }
}

#[test]
fn a_station_gets_its_own_requests_and_no_other_station_can_reply() {
    let (server, pending) = start_with_requests();
    let asked = user(&server, &pending, "hall-1");
    let (id, body) = poll(&server, "hall-1");
    assert_eq!((body.as_str(), id.len()), ("{}", 64));
    let foreign = format!("/v1/hall/hall-2/request/{id}");
    let answer = ask(&server, "POST", &foreign, &with_token("token-of-hall-2", 6), b"\"done\"");
    assert!(answer.starts_with("HTTP/1.1 410 "), "{answer}");
    let own = format!("/v1/hall/hall-1/request/{id}");
    let answer = ask(&server, "POST", &own, &with_token("token-of-hall-1", 6), b"\"done\"");
    assert!(answer.starts_with("HTTP/1.1 204 "), "{answer}");
    assert_eq!(server.runtime.block_on(asked).unwrap(), Ok(b"\"done\"".to_vec()));
}

#[test]
fn a_reply_that_is_too_long_ends_the_wait_of_its_user() {
    let (server, pending) = start_with_requests();
    let asked = user(&server, &pending, "hall-1");
    let (id, _) = poll(&server, "hall-1");
    let own = format!("POST /v1/hall/hall-1/request/{id} HTTP/1.1\r\nHost: archive\r\nConnection: close\r\n");
    let mut stream = TcpStream::connect(server.address).unwrap();
    write!(stream, "{own}{}\r\n", with_token("token-of-hall-1", MAX_REPLY + 1)).unwrap();
    // The server may close the connection before it has read everything.
    stream.write_all(&vec![b' '; MAX_REPLY + 1]).ok();
    assert_eq!(server.runtime.block_on(asked).unwrap(), Err(PendingError::Incomplete));
}

#[test]
fn a_reply_after_its_user_has_gone_is_refused_before_it_has_come() {
    let (server, pending) = start_with_requests();
    let asked = user(&server, &pending, "hall-1");
    let (id, _) = poll(&server, "hall-1");
    let mut stream = TcpStream::connect(server.address).unwrap();
    let head = format!("POST /v1/hall/hall-1/request/{id} HTTP/1.1\r\nHost: archive\r\nConnection: close\r\n");
    // The body never ends.
    write!(stream, "{head}{}\r\n ", with_token("token-of-hall-1", 9)).unwrap();
    asked.abort();
    let mut answer = String::new();
    stream.read_to_string(&mut answer).unwrap();
    assert!(answer.starts_with("HTTP/1.1 410 "), "{answer}");
}
