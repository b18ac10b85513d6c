//! The server with hostile and slow clients.

#![allow(clippy::unwrap_used, clippy::panic, clippy::indexing_slicing, reason = "a test")]

use profivac_recorder::{Recorder, Settings};
use profivac_station::services::Services;
use profivac_web_server::auth::Access;
use profivac_web_server::server::{Limits, Server, Setup};
use std::io::{Read, Write};
use std::net::TcpStream;
use std::sync::Arc;
use std::time::Duration;
use tempfile::TempDir;

/// Longer than any step of a test.
const TIMEOUT: Duration = Duration::from_secs(60);

struct TestStation {
    _folder: TempDir,
    server: Server,
}

impl TestStation {
    fn new(address: &str, limits: Limits) -> Self {
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join("plant.db");
        let recorder = Recorder::start(&file, Settings::default()).unwrap();
        let services = Arc::new(Services::new("hall".to_owned(), file, recorder));
        let setup = Setup { limits, ..Setup::new(address.parse().unwrap(), Access::anonymous_viewer()) };
        let server = profivac_station::server::start(services, setup).unwrap();
        Self { _folder: folder, server }
    }

    fn connect(&self) -> TcpStream {
        let stream = TcpStream::connect(self.server.address()).unwrap();
        stream.set_read_timeout(Some(TIMEOUT)).unwrap();
        stream
    }

    /// The status line of the answer to a request for this host; empty if the connection is closed.
    fn status(&self, host: &str) -> String {
        let mut stream = self.connect();
        let _sent = write!(stream, "GET /api/station HTTP/1.1\r\nHost: {host}\r\nConnection: close\r\n\r\n");
        let mut answer = Vec::new();
        // A refused connection may close before the request is sent or before the answer is read.
        let _ended = stream.read_to_end(&mut answer);
        let answer = String::from_utf8_lossy(&answer).into_owned();
        answer.lines().next().unwrap_or_default().to_owned()
    }
}

#[test]
fn a_server_on_loopback_accepts_only_loopback_hosts() {
    let station = TestStation::new("127.0.0.1:0", Limits::default());
    for host in ["localhost", "127.0.0.1:8080", "[::1]:9"] {
        assert_eq!(station.status(host), "HTTP/1.1 200 OK", "{host}");
    }
    for host in ["evil.example", "evil.example:8080", "192.0.2.1", ""] {
        assert_eq!(station.status(host), "HTTP/1.1 421 Misdirected Request", "{host}");
    }
}

#[test]
fn the_loopback_address_of_ipv6_is_loopback() {
    let station = TestStation::new("[::1]:0", Limits::default());
    assert_eq!(station.status("[::1]:8080"), "HTTP/1.1 200 OK");
    assert_eq!(station.status("evil.example"), "HTTP/1.1 421 Misdirected Request");
}

#[test]
fn an_unfinished_request_is_disconnected() {
    let station = TestStation::new("127.0.0.1:0", Limits { head: Duration::from_millis(50), ..Limits::default() });
    for begun in ["", "GET /api/station HTTP/1.1\r\nHost: localhost\r\nX-Slow: "] {
        let mut stream = station.connect();
        stream.write_all(begun.as_bytes()).unwrap();
        // The connection ends, with or without an answer.
        stream.read_to_end(&mut Vec::new()).unwrap();
    }
}

#[test]
fn a_head_of_32_kib_is_answered_and_a_longer_one_is_refused() {
    let station = TestStation::new("127.0.0.1:0", Limits::default());
    let (begin, end) = ("GET /api/station HTTP/1.1\r\nHost: localhost\r\nConnection: close\r\nX-Long: ", "\r\n\r\n");
    for (length, status) in [(32_768, "200 OK"), (32_769, "431 Request Header Fields Too Large"), (1 << 20, "431 ")] {
        let mut stream = station.connect();
        write!(stream, "{begin}{}{end}", "a".repeat(length - begin.len() - end.len())).unwrap();
        let mut answer = String::new();
        stream.read_to_string(&mut answer).unwrap();
        assert!(answer.starts_with(&format!("HTTP/1.1 {status}")), "{length}: {answer}");
    }
}

#[test]
fn a_line_of_a_head_that_ends_with_lf_alone_is_refused() {
    let station = TestStation::new("127.0.0.1:0", Limits::default());
    for head in
        ["GET /api/station HTTP/1.1\nHost: localhost\r\n\r\n", "GET /api/station HTTP/1.1\r\nHost: localhost\n\r\n"]
    {
        let mut stream = station.connect();
        stream.write_all(head.repeat(2).as_bytes()).unwrap();
        let mut answer = String::new();
        stream.read_to_string(&mut answer).unwrap();
        assert!(answer.starts_with("HTTP/1.1 400 Bad Request"), "{answer}");
        assert_eq!(answer.matches("HTTP/1.1").count(), 1, "{answer}");
    }
}

#[test]
fn connections_above_the_limit_are_closed_and_the_others_stay() {
    let station = TestStation::new("127.0.0.1:0", Limits { connections: 16, ..Limits::default() });
    // Two live streams are an eighth, and the user holds their connections.
    let mut held: Vec<_> = (0..2).map(|_| station.connect()).collect();
    for stream in &mut held {
        write!(stream, "GET /api/live HTTP/1.1\r\nHost: localhost\r\n\r\n").unwrap();
        assert_eq!(stream.read(&mut [0; 12]).unwrap(), 12);
    }
    let mut silent: Vec<_> = (0..60).map(|_| station.connect()).collect();
    assert_eq!(station.status("localhost"), "HTTP/1.1 200 OK", "a request gets the place of a silent connection");
    assert!(held.iter_mut().all(|stream| stream.read(&mut [0; 100]).unwrap() > 0), "connections with a user stay");
    assert!(!matches!(silent[0].read(&mut [0; 1]), Ok(1..)), "the oldest silent connection is closed");
}
