//! TLS.

use crate::security::test_station::{Answer, PASSWORD, Page, Request, TestStation, certificate, renew, tls};
use profivac_web_server::server::TlsFiles;
use profivac_web_server::server::{Keys, Limits};
use std::fs;
use std::io::{Read, Write};
use std::os::unix::fs::PermissionsExt;
use std::time::Duration;
use tokio_rustls::rustls::version::{TLS12, TLS13};

#[test]
fn over_tls_the_cookie_is_secure_and_hsts_is_set() {
    let station = TestStation::with_tls();
    assert!(station.server.url().starts_with("https://"));
    let send = |request: &Request| request.over(tls(&station, "a.pem", &[&TLS13]).unwrap());
    let answer = send(&Request::login("ada", PASSWORD).header("origin: https://localhost"));
    assert_eq!(answer.header("strict-transport-security"), Some("max-age=31622400"));
    let cookie = answer.header("set-cookie").unwrap();
    assert!(cookie.starts_with(&format!("__Host-profivac-{}=", station.port())), "{cookie}");
    assert!(cookie.ends_with("; Path=/; HttpOnly; SameSite=Strict; Secure"), "{cookie}");
    assert_eq!(send(&Request::get("/api/gauges").cookie(&Page::of(&answer))).status, 200);
    let refused = send(&Request::get("/").host("evil.example"));
    assert_eq!((refused.status, refused.header("strict-transport-security").is_some()), (421, true));
}

#[test]
fn tls_before_1_2_is_refused() {
    let station = TestStation::with_tls();
    for version in [&TLS12, &TLS13] {
        assert_eq!(Request::get("/").over(tls(&station, "a.pem", &[version]).unwrap()).status, 200);
    }
    let first = |version: [u8; 2]| {
        let mut stream = station.connect();
        stream.write_all(&hello(version)).unwrap();
        let mut record = [0; 7];
        stream.read_exact(&mut record).unwrap();
        record
    };
    assert_eq!(first([3, 3])[0], 22, "the same handshake with TLS 1.2 is answered");
    for version in [[3, 2], [3, 1], [3, 0]] {
        let record = first(version);
        assert_eq!((record[0], &record[5..]), (21, &[2, 70][..]), "protocol_version");
    }
}

/// A ClientHello for at most this version, with a cipher suite of TLS 1.2.
fn hello(version: [u8; 2]) -> Vec<u8> {
    const SUITES: [u8; 6] = [0, 2, 0xC0, 0x2B, 1, 0];
    const GROUPS: [u8; 8] = [0, 10, 0, 4, 0, 2, 0, 23];
    const POINTS: [u8; 6] = [0, 11, 0, 2, 1, 0];
    const SIGNATURES: [u8; 8] = [0, 13, 0, 4, 0, 2, 4, 3];
    let extensions = [&GROUPS[..], &POINTS, &SIGNATURES].concat();
    let mut body = [&version[..], &[7; 32], &[0], &SUITES, &[0, extensions.len() as u8]].concat();
    body.extend(extensions);
    let length = body.len() as u8;
    [&[22, 3, 1, 0, length + 4, 1, 0, 0, length][..], &body].concat()
}

#[test]
fn plain_http_on_a_tls_port_gets_a_fixed_answer() {
    let station = TestStation::with_tls();
    let answer = Request::login("ada", PASSWORD).to(&station);
    assert_eq!(answer.status, 400);
    assert_eq!(answer.body, "This port uses TLS: use an address that begins with https.\n");
    let mut stream = station.connect();
    stream.write_all(&[0; 600]).unwrap();
    // The connection ends, with or without an error.
    let _ended = stream.read_to_end(&mut Vec::new());
    assert_eq!(Request::get("/").over(tls(&station, "a.pem", &[&TLS13]).unwrap()).status, 200);
}

#[test]
fn an_unfinished_handshake_is_disconnected_at_its_timeout() {
    let station = TestStation::with(|setup, folder| {
        setup.tls = Some(certificate(folder));
        setup.limits = Limits { head: Duration::from_millis(50), ..Limits::default() };
    });
    for begun in [&[][..], &[22, 3, 1]] {
        let mut slow = station.connect();
        slow.write_all(begun).unwrap();
        // The connection ends, with or without an error.
        let _ended = slow.read_to_end(&mut Vec::new());
    }
}

#[test]
fn unfinished_handshakes_on_every_connection_do_not_keep_out_a_login() {
    let limits = Limits { head: Duration::from_secs(86_400), ..Limits::default() };
    let station = TestStation::with(|setup, folder| {
        setup.tls = Some(certificate(folder));
        setup.limits = limits;
    });
    let begin = || {
        let mut slow = station.connect();
        slow.write_all(&[22, 3, 1]).unwrap();
        slow
    };
    let mut slow: Vec<_> = (0..limits.connections + 50).map(|_| begin()).collect();
    let login = Request::login("ada", PASSWORD).header("origin: https://localhost");
    let answer = login.over(tls(&station, "a.pem", &[&TLS13]).unwrap());
    assert_eq!(answer.status, 200);
    slow.extend((0..50).map(|_| begin()));
    let gauges = Request::get("/api/gauges").cookie(&Page::of(&answer));
    assert_eq!(gauges.over(tls(&station, "a.pem", &[&TLS13]).unwrap()).status, 200);
}

#[test]
fn a_renewed_certificate_applies_to_new_connections() {
    let station = TestStation::with_tls();
    let files = TlsFiles { certificate: station.file("a.pem"), key: station.file("a.key") };
    let mut before = tls(&station, "a.pem", &[&TLS13]).unwrap();
    fs::copy(&files.certificate, station.file("old.pem")).unwrap();
    renew(&files);
    assert!(tls(&station, "a.pem", &[&TLS13]).is_err());
    station.server.renew().unwrap();
    assert!(tls(&station, "a.pem", &[&TLS13]).is_ok() && tls(&station, "old.pem", &[&TLS13]).is_err());
    fs::write(&files.key, "nonsense").unwrap();
    assert!(station.server.renew().unwrap_err().to_string().ends_with("a.key: expected a key in PEM, found none"));
    assert!(tls(&station, "a.pem", &[&TLS13]).is_ok());
    before.write_all(Request::get("/").text().as_bytes()).unwrap();
    assert_eq!(Answer::read(&mut before).status, 200);
}

#[test]
fn a_wrong_certificate_or_key_is_an_error_before_the_start() {
    let folder = tempfile::tempdir().unwrap();
    let files = certificate(&folder);
    let error = || Keys::read(files.clone()).err().map(|error| error.to_string()).unwrap_or_default();
    assert_eq!(error(), "");
    fs::set_permissions(&files.key, fs::Permissions::from_mode(0o644)).unwrap();
    assert!(error().contains("a.key holds secrets and is open to others (mode 644): chmod 600 "), "{}", error());
    fs::set_permissions(&files.key, fs::Permissions::from_mode(0o600)).unwrap();
    let key = fs::read(&files.key).unwrap();
    renew(&files);
    fs::write(&files.key, key).unwrap();
    assert!(error().contains("cannot be used together"), "{}", error());
    fs::write(&files.certificate, "").unwrap();
    assert!(error().ends_with("a.pem: expected a certificate in PEM, found none"), "{}", error());
    fs::remove_file(&files.key).unwrap();
    assert!(error().contains("a.key: "), "{}", error());
}
