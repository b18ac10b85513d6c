//! A station with users on loopback, and a client that sends exactly the octets of a test.

use crate::until::pause;
use profivac_recorder::{Micros, Recorder, Settings};
use profivac_station::services::Services;
use profivac_web_server::auth::password::Hash;
use profivac_web_server::auth::users::Users;
use profivac_web_server::auth::{Access, Role};
use profivac_web_server::server::TlsFiles;
use profivac_web_server::server::{Server, Setup};
use rcgen::{CertifiedKey, generate_simple_self_signed};
use serde_json::Value;
use std::fs;
use std::io::{Read, Write};
use std::net::{SocketAddr, TcpStream};
use std::os::unix::fs::PermissionsExt;
use std::path::{Path, PathBuf};
use std::sync::{Arc, LazyLock};
use std::time::{Duration, Instant};
use tempfile::TempDir;
use tokio_rustls::rustls::crypto::ring::default_provider;
use tokio_rustls::rustls::pki_types::pem::PemObject;
use tokio_rustls::rustls::pki_types::{CertificateDer, ServerName};
use tokio_rustls::rustls::{
    self, ClientConfig, ClientConnection, RootCertStore, StreamOwned, SupportedProtocolVersion,
};

/// Longer than any step of a test.
pub const TIMEOUT: Duration = Duration::from_secs(60);

/// The password of all users.
pub const PASSWORD: &str = "tin whisker plateau";

static HASH: LazyLock<Hash> = LazyLock::new(|| Hash::of(PASSWORD).unwrap());

/// A running station.
pub struct TestStation {
    folder: TempDir,
    pub services: Arc<Services>,
    pub server: Server,
}

impl TestStation {
    /// A station with the users ada (engineer), olga (operator) and vera (viewer).
    pub fn new() -> Self {
        Self::with(|_, _| {})
    }

    /// The same station with TLS.
    pub fn with_tls() -> Self {
        Self::with(|setup, folder| setup.tls = Some(certificate(folder)))
    }

    /// A station without login, whose requests have this role.
    pub fn open(role: Role) -> Self {
        Self::with(|setup, _| setup.access = Access::anonymous("demo", role))
    }

    pub fn with(change: impl FnOnce(&mut Setup, &TempDir)) -> Self {
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join("plant.db");
        let recorder = Recorder::start(&file, Settings::default()).unwrap();
        let services = Arc::new(Services::new("Target hall".to_owned(), file, recorder));
        Self::around(services, folder, change)
    }

    /// A server for the services of a running station.
    pub fn over(services: &Arc<Services>) -> Self {
        Self::around(Arc::clone(services), tempfile::tempdir().unwrap(), |_, _| {})
    }

    /// The same with TLS.
    pub fn over_with_tls(services: &Arc<Services>) -> Self {
        let tls = |setup: &mut Setup, folder: &TempDir| setup.tls = Some(certificate(folder));
        Self::around(Arc::clone(services), tempfile::tempdir().unwrap(), tls)
    }

    fn around(services: Arc<Services>, folder: TempDir, change: impl FnOnce(&mut Setup, &TempDir)) -> Self {
        let users = folder.path().join("users.toml");
        Users::change(&users, |users| {
            users.add("ada", Role::Engineer, HASH.clone())?;
            users.add("olga", Role::Operator, HASH.clone())?;
            users.add("vera", Role::Viewer, HASH.clone())
        })
        .unwrap();
        Self::start(services, folder, change)
    }

    fn start(services: Arc<Services>, folder: TempDir, change: impl FnOnce(&mut Setup, &TempDir)) -> Self {
        let users = folder.path().join("users.toml");
        let mut setup = Setup::new("127.0.0.1:0".parse().unwrap(), Access::Users(users));
        change(&mut setup, &folder);
        let server = profivac_station::server::start(Arc::clone(&services), setup).unwrap();
        Self { folder, services, server }
    }

    /// The station after a restart, at another port and with another database. `while_stopped` gets the folder.
    pub fn restarted(self, while_stopped: impl FnOnce(&Path)) -> Self {
        let Self { folder, services, server } = self;
        drop((server, services));
        while_stopped(folder.path());
        let file = folder.path().join("restarted.db");
        let recorder = Recorder::start(&file, Settings::default()).unwrap();
        let services = Arc::new(Services::new("Target hall".to_owned(), file, recorder));
        Self::start(services, folder, |_, _| {})
    }

    pub fn file(&self, name: &str) -> PathBuf {
        self.folder.path().join(name)
    }

    pub fn port(&self) -> u16 {
        self.server.address().port()
    }

    /// A connection to the server.
    pub fn connect(&self) -> TcpStream {
        let stream = TcpStream::connect(SocketAddr::from(([127, 0, 0, 1], self.port()))).unwrap();
        stream.set_read_timeout(Some(TIMEOUT)).unwrap();
        stream
    }

    pub fn get(&self, path: &str) -> Answer {
        Request::get(path).to(self)
    }

    /// Logs in.
    pub fn login(&self, name: &str) -> Page {
        let answer = Request::login(name, PASSWORD).to(self);
        assert_eq!(answer.status, 200, "{answer:?}");
        Page::of(&answer)
    }

    /// The events about logins and refusals, the earliest first, as soon as one of them contains `sentence`.
    pub fn access_events(&self, sentence: &str) -> Vec<String> {
        let end = Instant::now() + TIMEOUT;
        loop {
            assert!(self.services.recorder().flush());
            let events =
                self.services.recorder().open_reader().unwrap().events(Micros(0), Micros(i64::MAX), 1000).unwrap();
            let access = events.into_iter().rev().filter(|event| event.kind.as_str() == "access");
            let texts: Vec<_> = access.map(|event| event.text).collect();
            if texts.iter().any(|text| text.contains(sentence)) {
                return texts;
            }
            assert!(Instant::now() < end, "no event contains {sentence:?}: {texts:?}");
            pause();
        }
    }

    /// Changes the users' file as `profivac user` does.
    pub fn change(&self, change: impl FnOnce(&mut Users)) {
        let changed = |users: &mut Users| {
            change(users);
            Ok(())
        };
        Users::change(&self.file("users.toml"), changed).unwrap();
    }
}

/// Creates a certificate for this computer and its key.
pub fn certificate(folder: &TempDir) -> TlsFiles {
    let files = TlsFiles { certificate: folder.path().join("a.pem"), key: folder.path().join("a.key") };
    renew(&files);
    files
}

/// Replaces certificate and key by new ones.
pub fn renew(files: &TlsFiles) {
    let names = ["localhost".to_owned(), "127.0.0.1".to_owned()];
    let CertifiedKey { cert, signing_key } = generate_simple_self_signed(names).unwrap();
    fs::write(&files.certificate, cert.pem()).unwrap();
    fs::write(&files.key, signing_key.serialize_pem()).unwrap();
    fs::set_permissions(&files.key, fs::Permissions::from_mode(0o600)).unwrap();
}

/// A request.
#[derive(Clone)]
pub struct Request {
    method: String,
    path: String,
    host: String,
    headers: Vec<String>,
    body: String,
}

impl Request {
    pub fn new(method: &str, path: &str) -> Self {
        let (method, path) = (method.to_owned(), path.to_owned());
        Self { method, path, host: "localhost".to_owned(), headers: Vec::new(), body: String::new() }
    }

    pub fn get(path: &str) -> Self {
        Self::new("GET", path)
    }

    /// A POST with a JSON body.
    pub fn post(path: &str, body: &Value) -> Self {
        Self::new("POST", path).header("content-type: application/json").body(&body.to_string())
    }

    pub fn login(name: &str, password: &str) -> Self {
        Self::post("/api/login", &serde_json::json!({ "name": name, "password": password }))
    }

    pub fn header(mut self, line: &str) -> Self {
        self.headers.push(line.to_owned());
        self
    }

    pub fn host(mut self, host: &str) -> Self {
        host.clone_into(&mut self.host);
        self
    }

    pub fn body(mut self, body: &str) -> Self {
        body.clone_into(&mut self.body);
        self
    }

    /// Adds the cookie of the session, without its token, as the request of a foreign page has it.
    pub fn cookie(self, page: &Page) -> Self {
        let line = format!("cookie: {}", page.cookie);
        self.header(&line)
    }

    /// Adds cookie and token, as the page of the station does.
    pub fn by(self, page: &Page) -> Self {
        let line = format!("x-csrf-token: {}", page.token);
        self.cookie(page).header(&line)
    }

    pub fn text(&self) -> String {
        let Self { method, path, host, headers, body } = self;
        let mut text = format!("{method} {path} HTTP/1.1\r\nhost: {host}\r\nconnection: close\r\n");
        headers.iter().for_each(|line| text += &format!("{line}\r\n"));
        if !body.is_empty() {
            text += &format!("content-length: {}\r\n", body.len());
        }
        text + "\r\n" + body
    }

    pub fn to(&self, station: &TestStation) -> Answer {
        self.over(station.connect())
    }

    pub fn over(&self, mut stream: impl Read + Write) -> Answer {
        // The server may close the connection before it has read the whole request.
        let _sent = stream.write_all(self.text().as_bytes());
        Answer::read(&mut stream)
    }
}

/// An answer.
#[derive(Debug)]
pub struct Answer {
    pub status: u16,
    pub headers: Vec<(String, String)>,
    pub body: String,
}

impl Answer {
    pub fn read(stream: &mut impl Read) -> Self {
        let mut octets = Vec::new();
        // An end without close_notify of TLS counts as an end.
        let _ended = stream.read_to_end(&mut octets);
        let text = String::from_utf8_lossy(&octets).into_owned();
        let (head, body) = text.split_once("\r\n\r\n").unwrap_or((&text, ""));
        let mut lines = head.lines();
        let status = lines.next().and_then(|line| line.split(' ').nth(1)).and_then(|status| status.parse().ok());
        let pair = |line: &str| line.split_once(": ").map(|(name, value)| (name.to_lowercase(), value.to_owned()));
        Self { status: status.unwrap_or(0), headers: lines.filter_map(pair).collect(), body: body.to_owned() }
    }

    pub fn header(&self, wanted: &str) -> Option<&str> {
        self.headers.iter().find(|(name, _)| name == wanted).map(|(_, value)| value.as_str())
    }

    pub fn json(&self) -> Value {
        serde_json::from_str(&self.body).unwrap_or_else(|error| panic!("{error}: {self:?}"))
    }

    pub fn problem(&self) -> String {
        self.json()["detail"].as_str().unwrap().to_owned()
    }
}

/// Cookie and token of a page after login.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Page {
    pub cookie: String,
    pub token: String,
}

impl Page {
    pub fn of(answer: &Answer) -> Self {
        let cookie = answer.header("set-cookie").unwrap();
        let cookie = cookie.split(';').next().unwrap().to_owned();
        Self { cookie, token: answer.json()["token"].as_str().unwrap().to_owned() }
    }

    /// The same cookie and token for a station at another port, whose cookie has another name.
    pub fn at(&self, station: &TestStation) -> Self {
        let (_, id) = self.cookie.split_once('=').unwrap();
        Self { cookie: format!("profivac-{}={id}", station.port()), token: self.token.clone() }
    }
}

/// A connection over TLS that trusts this certificate.
pub fn tls(
    station: &TestStation,
    certificate: &str,
    versions: &[&'static SupportedProtocolVersion],
) -> Result<StreamOwned<ClientConnection, TcpStream>, rustls::Error> {
    let mut roots = RootCertStore::empty();
    roots.add(CertificateDer::from_pem_file(station.file(certificate)).unwrap())?;
    let config = ClientConfig::builder_with_provider(Arc::new(default_provider()))
        .with_protocol_versions(versions)?
        .with_root_certificates(roots)
        .with_no_client_auth();
    let name = ServerName::try_from("localhost").unwrap();
    let mut connection = ClientConnection::new(Arc::new(config), name)?;
    let mut stream = station.connect();
    while connection.is_handshaking() {
        connection.complete_io(&mut stream).map_err(|error| rustls::Error::General(error.to_string()))?;
    }
    Ok(StreamOwned::new(connection, stream))
}
