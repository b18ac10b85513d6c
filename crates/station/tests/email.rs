//! E-mails about alarms, delivered to a mail server that others wrote (aiosmtpd).

#![allow(clippy::unwrap_used, clippy::panic, clippy::indexing_slicing, reason = "a test")]

use crate::support;
use crate::support::inputs::inputs;
use crate::until::pause;
use profivac_recorder::{Micros, Quality};
use profivac_station::config::{Config, Email};
use profivac_station::services::Services;
use profivac_station::webhook::{DeliverySettings, DeliveryThread, ReceiverKind, WebhookView};
use serde_json::{Value, json};
use std::fs;
use std::io::{BufRead, BufReader, Lines};
use std::os::unix::fs::PermissionsExt;
use std::path::Path;
use std::process::{Child, ChildStdout, Command, Stdio};
use std::sync::Arc;
use std::time::{Duration, Instant};
use tempfile::TempDir;

/// The longest wait, enough for a busy computer.
const LONG: Duration = Duration::from_secs(60);

/// Settings with short pauses.
const QUICK: DeliverySettings = DeliverySettings {
    poll_interval: Duration::from_millis(2),
    answer_timeout: LONG,
    first_pause: Duration::from_millis(1),
    longest_pause: Duration::from_millis(5),
    max_age: Duration::from_secs(86_400),
    max_queued: 10_000,
};

/// A running mail server.
struct MailServer {
    child: Child,
    lines: Lines<BufReader<ChildStdout>>,
    port: u16,
}

impl MailServer {
    fn start(folder: &Path, mode: &str, replies: &[&str]) -> Self {
        let certified = rcgen::generate_simple_self_signed(["localhost".to_owned()]).unwrap();
        let (certificate, key) = (folder.join("mail.pem"), folder.join("mail.key"));
        fs::write(&certificate, certified.cert.pem()).unwrap();
        fs::write(&key, certified.signing_key.serialize_pem()).unwrap();
        let root = Path::new(env!("CARGO_MANIFEST_DIR"));
        let python = root.join("../../target/venv/bin/python");
        assert!(python.exists(), "there is no {} with aiosmtpd: ./test makes it", python.display());
        let mut child = Command::new(python)
            .arg(root.join("tests/peers/smtp_server.py"))
            .args([mode.as_ref(), certificate.as_os_str(), key.as_os_str()])
            .args(replies)
            .stdin(Stdio::piped())
            .stdout(Stdio::piped())
            .spawn()
            .unwrap();
        let mut lines = BufReader::new(child.stdout.take().unwrap()).lines();
        let port = lines.next().unwrap().unwrap().parse().unwrap();
        Self { child, lines, port }
    }

    /// The next message that it got.
    fn message(&mut self) -> Value {
        serde_json::from_str(&self.lines.next().unwrap().unwrap()).unwrap()
    }
}

impl Drop for MailServer {
    fn drop(&mut self) {
        self.child.kill().ok();
        self.child.wait().ok();
    }
}

fn header<'a>(message: &'a Value, name: &str) -> &'a str {
    let all = message["headers"].as_array().unwrap();
    all.iter().find(|header| header[0] == name).map_or("", |header| header[1].as_str().unwrap())
}

struct Fixture {
    services: Arc<Services>,
    folder: TempDir,
    email: Option<Email>,
}

impl Fixture {
    fn new() -> Self {
        let folder = tempfile::tempdir().unwrap();
        fs::write(folder.path().join("smtp.password"), "tin whisker\n").unwrap();
        fs::set_permissions(folder.path().join("smtp.password"), fs::Permissions::from_mode(0o600)).unwrap();
        Self { services: support::services(folder.path()), folder, email: None }
    }

    fn config(&self, email: &str) -> Config {
        let file = format!(
            "[[segment]]\nname = 'hall'\nport = 'p'\n[[segment.gauge]]\nname = 'chamber'\naddress = 5\ndevice = 'bcg450'\n\
            [[alarm]]\nname = 'too high ü'\ngauge = 'chamber'\nabove = '1 Pa'\ndelay = '0 s'\noff-delay = '0 s'\n\
            message = 'Close the valve.'\n[alarms]\nblind = {{ priority = 'off' }}\n\
            [[email]]\nname = 'shift'\nfrom = 'Hall <hall@example.org>'\nto = ['ada@example.org', 'Bob <bob@example.org>']\n{email}"
        );
        profivac_config::parse(&file, &self.folder.path().join("plant.toml")).unwrap()
    }

    /// Starts to deliver to the server, which listens on `port`.
    fn deliver(&mut self, port: u16, security: &str, more: &str) -> DeliveryThread {
        let config = self.config(&format!("server = 'localhost:{port}'\nsecurity = '{security}'\n{more}"));
        let email = config.emails[0].clone();
        self.services.alarms().start(config.alarms, vec![email.target()]).unwrap();
        let (recorder, status) = (Arc::clone(self.services.recorder()), Arc::clone(self.services.webhooks()));
        self.email = Some(email.clone());
        DeliveryThread::start(email, recorder, status, QUICK).unwrap()
    }

    /// The pressure rises and falls once: two notifications.
    fn chatter(&self) {
        for pa in [5.0, 0.001] {
            self.services.alarms().evaluate(&inputs(pa, Quality::Valid));
        }
        assert!(self.services.recorder().flush());
    }

    /// Waits until the status of the e-mail is as wanted.
    fn until(&self, wanted: impl Fn(&WebhookView) -> bool) -> WebhookView {
        let end = Instant::now() + LONG;
        loop {
            let views = self.services.webhooks().views(&self.services.recorder().open_reader().unwrap()).unwrap();
            let view = views.into_iter().next().unwrap();
            if wanted(&view) {
                return view;
            }
            assert!(Instant::now() < end, "timed out: {view:?}");
            pause();
        }
    }

    fn events(&self) -> Vec<String> {
        assert!(self.services.recorder().flush());
        let events = self.services.recorder().open_reader().unwrap().events(Micros(0), Micros(i64::MAX), 1000).unwrap();
        events.into_iter().map(|event| event.text).filter(|text| text.starts_with("email")).rev().collect()
    }
}

const LOGIN: &str = "user = 'profivac'\npassword-file = 'smtp.password'\nca-file = 'mail.pem'\n";

#[test]
fn a_message_says_in_words_what_happened_over_starttls_with_a_login() {
    let mut fixture = Fixture::new();
    let mut server = MailServer::start(fixture.folder.path(), "starttls", &[]);
    let more = format!("{LOGIN}link = 'https://vacuum.example:8443/'");
    let _delivery = fixture.deliver(server.port, "starttls", &more);
    fixture.chatter();
    let first = server.message();
    assert_eq!((&first["encrypted"], &first["user"]), (&json!(true), &json!("profivac")));
    assert_eq!(
        (&first["sender"], &first["recipients"]),
        (&json!("hall@example.org"), &json!(["ada@example.org", "bob@example.org"]))
    );
    assert_eq!(header(&first, "Subject"), "Target hall: too high ü raised (medium)");
    assert_eq!(header(&first, "From"), "Hall <hall@example.org>");
    assert_eq!(header(&first, "Auto-Submitted"), "auto-generated");
    let text = first["text"].as_str().unwrap().replace("\r\n", "\n");
    let expected = "chamber shows 5.00e-2 mbar, above the limit of 1.00e-2 mbar\n\nClose the valve.\n\n\
        Alarm:     too high ü\nChange:    raised\nPriority:  medium\nState:     not acknowledged\nGauge:     chamber\n\
        Value:     5.00e-2 mbar\nLimit:     1.00e-2 mbar\nTime:      ";
    assert!(text.starts_with(expected), "{text}");
    assert!(
        text.trim_end().ends_with("\nStation:   Target hall\nDashboard: https://vacuum.example:8443/alarms"),
        "{text}"
    );
    let second = server.message();
    assert_eq!(header(&second, "Subject"), "Target hall: too high ü cleared (medium)");
    let text = second["text"].as_str().unwrap();
    assert!(
        text.contains("Change:    cleared\r\n") && text.contains("State:     cleared, not acknowledged\r\n"),
        "{text}"
    );
    assert_ne!(header(&first, "Message-ID"), header(&second, "Message-ID"));
    let view = fixture.until(|view| view.delivered == 2 && view.waiting == 0);
    assert_eq!((view.kind, view.at), (ReceiverKind::Email, format!("smtp://localhost:{}", server.port)));
}

#[test]
fn a_message_goes_over_tls_from_the_first_octet() {
    let mut fixture = Fixture::new();
    let mut server = MailServer::start(fixture.folder.path(), "tls", &[]);
    let _delivery = fixture.deliver(server.port, "tls", LOGIN);
    fixture.chatter();
    let first = server.message();
    assert_eq!((&first["encrypted"], &first["user"]), (&json!(true), &json!("profivac")));
}

#[test]
fn a_server_without_tls_or_with_a_foreign_certificate_gets_nothing() {
    for (mode, security, more, sentence) in [
        ("none", "starttls", LOGIN, "STARTTLS"),
        ("starttls", "starttls", "user = 'profivac'\npassword-file = 'smtp.password'", "certificate"),
    ] {
        let mut fixture = Fixture::new();
        let mut server = MailServer::start(fixture.folder.path(), mode, &[]);
        let _delivery = fixture.deliver(server.port, security, more);
        fixture.chatter();
        let view = fixture.until(|view| view.problem.is_some());
        assert!(view.problem.as_deref().unwrap().contains(sentence), "{view:?}");
        assert_eq!((view.delivered, view.waiting), (0, 2));
        server.child.kill().unwrap();
        assert!(server.lines.next().is_none(), "the server got a message");
    }
}

#[test]
fn a_message_that_is_refused_for_now_is_sent_again_with_its_id() {
    let mut fixture = Fixture::new();
    let mut server = MailServer::start(fixture.folder.path(), "none", &["451", "451", "250"]);
    let _delivery = fixture.deliver(server.port, "none", "");
    fixture.chatter();
    let messages: Vec<_> = (0..4).map(|_| server.message()).collect();
    let replies: Vec<_> = messages.iter().map(|message| message["reply"].as_str().unwrap()).collect();
    assert_eq!(replies, ["451", "451", "250", "250"]);
    let ids: Vec<_> = messages.iter().map(|message| header(message, "Message-ID")).collect();
    assert!(ids[0] == ids[1] && ids[1] == ids[2] && ids[2] != ids[3], "{ids:?}");
    fixture.until(|view| view.delivered == 2 && view.waiting == 0);
    let events = fixture.events();
    assert!(
        events[0].starts_with("email \"shift\" accepts no notifications: ") && events[0].contains("451"),
        "{events:?}"
    );
    assert_eq!(events[1], "email \"shift\" accepts notifications again");
}

#[test]
fn a_message_that_the_server_refuses_for_ever_does_not_delay_the_next_one() {
    let mut fixture = Fixture::new();
    let mut server = MailServer::start(fixture.folder.path(), "none", &["554", "250"]);
    let _delivery = fixture.deliver(server.port, "none", "");
    fixture.chatter();
    assert_eq!(server.message()["reply"], "554");
    assert_eq!(server.message()["reply"], "250");
    fixture.until(|view| view.delivered == 1 && view.given_up == 1 && view.waiting == 0);
}

#[test]
fn a_wrong_password_is_told_and_no_message_is_lost() {
    let mut fixture = Fixture::new();
    fs::write(fixture.folder.path().join("smtp.password"), "wrong").unwrap();
    let server = MailServer::start(fixture.folder.path(), "starttls", &[]);
    let delivery = fixture.deliver(server.port, "starttls", LOGIN);
    fixture.chatter();
    let view = fixture.until(|view| view.problem.is_some());
    assert!(view.problem.as_deref().unwrap().contains("535"), "{view:?}");
    assert_eq!((view.given_up, view.waiting), (0, 2));
    drop(delivery);
}

/// The sentence of a wrong `[[email]]`, after line and column.
fn wrong(email: &str) -> String {
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("open"), "secret").unwrap();
    fs::set_permissions(folder.path().join("open"), fs::Permissions::from_mode(0o644)).unwrap();
    let error = profivac_config::parse(
        &format!("[[email]]\n{email}\n[[segment]]\nname = 'hall'\nport = 'p'"),
        &folder.path().join("p.toml"),
    )
    .unwrap_err();
    format!("{}: {}", error.line, error.problem)
}

#[test]
fn wrong_settings_are_errors_with_their_position() {
    let usual = "server = 'mail.example.org'\nfrom = 'a@example.org'\nto = ['b@example.org']\n";
    for (email, expected) in [
        (usual.replace("mail.example.org", "http://mail/x"), "2: expected a mail server like"),
        (usual.replace("mail.example.org", "a@b"), "2: expected a mail server like"),
        (usual.to_owned() + "security = 'none'", "2: expected starttls or tls for the mail server mail.example.org"),
        (usual.to_owned() + "security = 'ssl'", "5: expected security, one of starttls, tls, none"),
        (usual.replace("'a@example.org'", "\"a@example.org\\r\\nBcc: e@example.org\""), "3: expected an address like"),
        (usual.replace("b@example.org", "b"), "4: expected an address like"),
        (usual.replace("'b@example.org'", ""), "4: expected 1 to 50 recipients, found 0"),
        (usual.to_owned() + "user = 'ada'", "5: expected user and password-file together"),
        (usual.to_owned() + "user = 'ada'\npassword-file = 'open'", "6: "),
        (usual.to_owned() + "link = 'ftp://x'", "5: expected a link like"),
        (usual.to_owned() + "password = 'x'", "5: unknown field `password`"),
        (usual.to_owned() + "name = 'x'\n[[webhook]]\nname = 'x'\nurl = 'https://a/b'", "5: "),
    ] {
        let sentence = wrong(&email);
        assert!(sentence.starts_with(expected), "{email}\n{sentence}");
    }
    assert!(wrong(&(usual.to_owned() + "user = 'ada'\npassword-file = 'open'")).contains("chmod 600"));
}
