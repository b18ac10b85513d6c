//! Deliveries to servers that fail, hang, redirect, refuse, and accept at last.

#![allow(clippy::unwrap_used, clippy::panic, clippy::indexing_slicing, reason = "a test")]

use crate::support;
use crate::support::inputs::inputs;
use crate::until::pause;
use profivac_recorder::alarms::{AlarmBatch, Notification};
use profivac_recorder::{Micros, Quality};
use profivac_station::config::{Config, Webhook};
use profivac_station::services::Services;
use profivac_station::webhook::{DeliverySettings, DeliveryThread, WebhookView};
use serde_json::Value;
use std::fs;
use std::io::{BufRead, BufReader, Read, Write};
use std::net::TcpListener;
use std::path::Path;
use std::sync::Arc;
use std::sync::mpsc::{Receiver, channel};
use std::time::{Duration, Instant};
use tempfile::TempDir;
use tokio_rustls::rustls::pki_types::PrivateKeyDer;
use tokio_rustls::rustls::{ServerConfig, ServerConnection, StreamOwned, crypto};

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

/// What a server does with a request.
#[derive(Clone, Copy)]
enum Reaction {
    Answers(&'static str),
    Hangs,
    Closes,
}

use Reaction::{Answers, Closes, Hangs};

/// A request that the server got.
struct Received {
    head: String,
    body: Value,
}

impl Received {
    fn header(&self, name: &str) -> Option<&str> {
        let lines = self.head.lines().filter_map(|line| line.split_once(": "));
        lines.into_iter().find(|(key, _)| key.eq_ignore_ascii_case(name)).map(|(_, value)| value)
    }
}

/// A server with these reactions, one per request, the last one repeated. Returns its address and the requests.
fn server(reactions: &'static [Reaction]) -> (String, Receiver<Received>) {
    let listener = TcpListener::bind("127.0.0.1:0").unwrap();
    let address = listener.local_addr().unwrap().to_string();
    let (sender, came) = channel();
    std::thread::spawn(move || {
        // Hanging connections stay open.
        let mut kept = Vec::new();
        for number in 0.. {
            let Ok((stream, _)) = listener.accept() else { return };
            let reaction = reactions[number.min(reactions.len() - 1)];
            let Some(request) = read(&stream) else { continue };
            match reaction {
                Answers(status) => {
                    let (mut stream, answer) = (&stream, format!("HTTP/1.1 {status}\r\ncontent-length: 0\r\n\r\n"));
                    stream.write_all(answer.as_bytes()).ok();
                }
                Hangs => kept.push(stream),
                Closes => {}
            }
            if sender.send(request).is_err() {
                return;
            }
        }
    });
    (address, came)
}

fn read(stream: impl Read) -> Option<Received> {
    let mut reader = BufReader::new(stream);
    let mut head = String::new();
    while !head.ends_with("\r\n\r\n") {
        if reader.read_line(&mut head).ok()? == 0 {
            return None;
        }
    }
    let length = head.lines().filter_map(|line| line.split_once(": "));
    let length = length.into_iter().find(|(name, _)| name.eq_ignore_ascii_case("content-length"))?.1.parse().ok()?;
    let mut body = vec![0; length];
    reader.read_exact(&mut body).ok()?;
    Some(Received { head, body: serde_json::from_slice(&body).ok()? })
}

struct Fixture {
    services: Arc<Services>,
    folder: TempDir,
}

impl Fixture {
    fn new(hooks: &[&Webhook]) -> Self {
        let folder = tempfile::tempdir().unwrap();
        Self { services: open(folder.path(), hooks), folder }
    }

    /// The pressure rises and falls once: two notifications.
    fn chatter(&self) {
        for pa in [5.0, 0.001] {
            self.services.alarms().evaluate(&inputs(pa, Quality::Valid));
        }
        assert!(self.services.recorder().flush());
    }

    fn start(&self, webhook: &Webhook, settings: DeliverySettings) -> DeliveryThread {
        let (recorder, status) = (Arc::clone(self.services.recorder()), Arc::clone(self.services.webhooks()));
        DeliveryThread::start(webhook.clone(), recorder, status, settings).unwrap()
    }

    /// Waits until the status of the webhook is as wanted.
    fn until(&self, name: &str, wanted: impl Fn(&WebhookView) -> bool) -> WebhookView {
        let end = Instant::now() + LONG;
        loop {
            let views = self.services.webhooks().views(&self.services.recorder().open_reader().unwrap()).unwrap();
            let view = views.into_iter().find(|view| view.name == name).unwrap();
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
        events.into_iter().map(|event| event.text).filter(|text| text.starts_with("webhook")).rev().collect()
    }
}

fn open(folder: &Path, hooks: &[&Webhook]) -> Arc<Services> {
    let services = support::services(folder);
    let targets = hooks.iter().map(|hook| hook.target()).collect();
    services.alarms().start(config("").alarms, targets).unwrap();
    services
}

fn config(more: &str) -> Config {
    let file = "[[segment]]\nname = 'hall'\nport = 'p'\n[[segment.gauge]]\nname = 'chamber'\naddress = 5\ndevice = 'bcg450'\n\
        [[alarm]]\nname = 'too high'\ngauge = 'chamber'\nabove = '1 Pa'\ndelay = '0 s'\noff-delay = '0 s'\n\
        [alarms]\nblind = { priority = 'off' }\n";
    profivac_config::parse(&format!("{file}{more}"), Path::new("plant.toml")).unwrap()
}

fn webhook(address: &str, more: &str) -> Webhook {
    config(&format!("[[webhook]]\nname = 'ops'\nurl = 'http://{address}/hook?key=abc'\n{more}")).webhooks.remove(0)
}

#[test]
fn a_notification_has_all_fields_and_its_token() {
    let (address, came) = server(&[Answers("204 No Content")]);
    let hook = webhook(&address, "token = 's3cret'");
    let fixture = Fixture::new(&[&hook]);
    let _delivery = fixture.start(&hook, QUICK);
    fixture.chatter();
    let first = came.recv_timeout(LONG).unwrap();
    assert!(first.head.starts_with("POST /hook?key=abc HTTP/1.1\r\n"), "{}", first.head);
    assert_eq!(first.header("authorization"), Some("Bearer s3cret"));
    assert_eq!(
        (first.header("content-type"), first.header("host")),
        (Some("application/json"), Some(address.as_str()))
    );
    for (key, value) in [
        ("station", "Target hall".into()),
        ("alarm", "too high".into()),
        ("change", "raised".into()),
        ("state", "unacknowledged".into()),
        ("priority", "medium".into()),
        ("gauge", "chamber".into()),
        ("value", 5.0.into()),
        ("limit", 1.0.into()),
        ("unit", "Pa".into()),
        ("user", Value::Null),
    ] {
        assert_eq!(first.body[key], value, "{key}");
    }
    let second = came.recv_timeout(LONG).unwrap();
    assert_eq!((&second.body["change"], &second.body["state"]), (&"returned".into(), &"returned".into()));
    let text = second.body["text"].as_str().unwrap();
    assert!(text.contains(" mbar, not above the "), "the text says where the pressure is: {text}");
    assert_ne!(first.body["id"], second.body["id"]);
    let view = fixture.until("ops", |view| view.delivered == 2 && view.waiting == 0);
    assert_eq!((view.at, view.problem), (format!("http://{address}"), None));
    let shown = format!(
        "{hook:?} {:?}",
        fixture.services.webhooks().views(&fixture.services.recorder().open_reader().unwrap()).unwrap()
    ) + &fixture.events().concat();
    assert!(!shown.contains("s3cret") && !shown.contains("abc"), "{shown}");
}

#[test]
fn a_notification_is_repeated_until_it_is_accepted_and_in_order() {
    static REACTIONS: [Reaction; 6] = [
        Answers("500 Oh"),
        Closes,
        Hangs,
        Answers("302 Found\r\nlocation: /elsewhere"),
        Answers("429 Slower"),
        Answers("200 OK"),
    ];
    let (address, came) = server(&REACTIONS);
    let hook = webhook(&address, "");
    let fixture = Fixture::new(&[&hook]);
    fixture.chatter();
    // A server that answers at all answers sooner, also on a busy computer.
    let _delivery = fixture.start(&hook, DeliverySettings { answer_timeout: Duration::from_secs(3), ..QUICK });
    let all: Vec<_> = (0..7).map(|_| came.recv_timeout(LONG).unwrap()).collect();
    assert!(all.iter().all(|came| came.head.starts_with("POST /hook?key=abc ")), "redirects are not followed");
    let ids: Vec<_> = all.iter().map(|came| &came.body["id"]).collect();
    assert!(ids[..6].iter().all(|id| *id == ids[0]), "a server recognises a repeated notification: {ids:?}");
    assert_eq!((&all[5].body["change"], &all[6].body["change"]), (&"raised".into(), &"returned".into()));
    fixture.until("ops", |view| view.delivered == 2 && view.problem.is_none() && view.failing_since_ms.is_none());
    assert_eq!(
        fixture.events(),
        [
            "webhook \"ops\" accepts no notifications: the answer is 500; the station tries again",
            "webhook \"ops\" accepts notifications again"
        ]
    );
}

#[test]
fn a_server_that_hangs_does_not_delay_the_others() {
    let (slow, _came) = server(&[Hangs]);
    let (quick, came) = server(&[Answers("200 OK")]);
    let hanging = webhook(&slow, "");
    let other = Webhook { name: "other".to_owned(), ..webhook(&quick, "") };
    let fixture = Fixture::new(&[&hanging, &other]);
    let hangs = fixture.start(&hanging, DeliverySettings { answer_timeout: Duration::from_secs(86_400), ..QUICK });
    let _other = fixture.start(&other, QUICK);
    for _ in 0..5 {
        fixture.chatter();
    }
    (0..10).for_each(|_| drop(came.recv_timeout(LONG).unwrap()));
    fixture.until("ops", |view| view.waiting == 10);
    // The end of the thread does not wait for the answer, which would take a day.
    let (sender, ended) = channel();
    std::thread::spawn(move || {
        drop(hangs);
        sender.send(()).unwrap();
    });
    ended.recv_timeout(LONG).unwrap();
}

#[test]
fn a_waiting_notification_is_delivered_after_a_restart() {
    let (address, came) = server(&[Answers("503 Later"), Answers("200 OK")]);
    let hook = webhook(&address, "");
    let fixture = Fixture::new(&[&hook]);
    fixture.chatter();
    let long_pause = DeliverySettings { first_pause: LONG, longest_pause: LONG, ..QUICK };
    let delivery = fixture.start(&hook, long_pause);
    let first = came.recv_timeout(LONG).unwrap();
    fixture.until("ops", |view| view.problem.as_deref() == Some("the answer is 503"));
    drop(delivery);
    let Fixture { services, folder } = fixture;
    drop(services);
    let fixture = Fixture { services: open(folder.path(), &[&hook]), folder };
    let _delivery = fixture.start(&hook, QUICK);
    let again = came.recv_timeout(LONG).unwrap();
    assert_eq!(first.body, again.body, "with the same number");
}

#[test]
fn a_notification_that_is_refused_or_too_old_or_one_too_many_is_given_up() {
    let (address, came) = server(&[Answers("400 What"), Answers("200 OK")]);
    let hook = webhook(&address, "");
    let fixture = Fixture::new(&[&hook]);
    fixture.chatter();
    let delivery = fixture.start(&hook, QUICK);
    assert_eq!(came.recv_timeout(LONG).unwrap().body["change"], "raised");
    assert_eq!(came.recv_timeout(LONG).unwrap().body["change"], "returned");
    fixture.until("ops", |view| (view.delivered, view.given_up) == (1, 1));
    drop(delivery);
    fixture.chatter();
    let delivery = fixture.start(&hook, DeliverySettings { max_queued: 1, ..QUICK });
    assert_eq!(came.recv_timeout(LONG).unwrap().body["change"], "returned", "the older one is given up");
    fixture.until("ops", |view| (view.delivered, view.given_up) == (1, 1));
    drop(delivery);
    fixture.chatter();
    let _delivery = fixture.start(&hook, DeliverySettings { max_age: Duration::ZERO, ..QUICK });
    fixture.until("ops", |view| (view.delivered, view.given_up, view.waiting) == (0, 2, 0));
    let events = fixture.events();
    assert_eq!(events[0], "webhook \"ops\" did not get 1 notification: the answer is 400");
    assert_eq!(events[1], "webhook \"ops\" did not get 1 notification: too many wait");
    assert_eq!(events[2], "webhook \"ops\" did not get 2 notifications: too old");
}

#[test]
fn notifications_are_delivered_after_the_database_was_deleted() {
    let (address, came) = server(&[Answers("200 OK")]);
    let hook = webhook(&address, "");
    let fixture = Fixture::new(&[&hook]);
    let _delivery = fixture.start(&hook, QUICK);
    for delivered in [2, 4] {
        fixture.chatter();
        (0..2).for_each(|_| drop(came.recv_timeout(LONG).unwrap()));
        fixture.until("ops", |view| view.delivered == delivered && view.waiting == 0);
        // The following notifications are in a new file and have the numbers of earlier ones.
        fs::remove_file(fixture.folder.path().join("plant.db")).unwrap();
        assert!(fixture.services.recorder().flush());
    }
}

#[test]
fn many_old_notifications_are_given_up_together() {
    let (address, _came) = server(&[Answers("200 OK")]);
    let hook = webhook(&address, "");
    let fixture = Fixture::new(&[&hook]);
    let old = |at| Notification { id: 0, webhook: hook.name.clone(), at: Micros(at), body: "{}".to_owned() };
    let batch = AlarmBatch { notifications: (0..2000).map(old).collect(), ..AlarmBatch::default() };
    assert!(fixture.services.recorder().record_alarms_with_receipt(batch, Vec::new()).wait());
    let _delivery = fixture.start(&hook, DeliverySettings { max_age: Duration::ZERO, ..QUICK });
    fixture.until("ops", |view| (view.delivered, view.given_up, view.waiting) == (0, 2000, 0));
    assert_eq!(fixture.events(), ["webhook \"ops\" did not get 2000 notifications: too old"]);
}

/// A server with a certificate of its own, and the file with it. It takes everything.
fn secure(folder: &Path) -> (String, Receiver<Received>) {
    let made = rcgen::generate_simple_self_signed(["localhost".to_owned()]).unwrap();
    fs::write(folder.join("ca.pem"), made.cert.pem()).unwrap();
    let key = PrivateKeyDer::try_from(made.signing_key.serialize_der()).unwrap();
    let provider = Arc::new(crypto::ring::default_provider());
    let config = ServerConfig::builder_with_provider(provider).with_safe_default_protocol_versions().unwrap();
    let config = Arc::new(config.with_no_client_auth().with_single_cert(vec![made.cert.der().clone()], key).unwrap());
    let listener = TcpListener::bind("127.0.0.1:0").unwrap();
    let port = listener.local_addr().unwrap().port();
    let (sender, came) = channel();
    std::thread::spawn(move || {
        for stream in listener.incoming() {
            let connection = ServerConnection::new(Arc::clone(&config)).unwrap();
            let mut stream = StreamOwned::new(connection, stream.unwrap());
            let Some(request) = read(&mut stream) else { continue };
            stream.write_all(b"HTTP/1.1 200 OK\r\ncontent-length: 0\r\n\r\n").ok();
            stream.flush().ok();
            if sender.send(request).is_err() {
                return;
            }
        }
    });
    (format!("localhost:{port}"), came)
}

#[test]
fn over_https_only_a_trusted_server_is_notified() {
    let folder = tempfile::tempdir().unwrap();
    let (address, came) = secure(folder.path());
    let stranger = webhook(&address, "");
    let url = format!("https://{address}/hook").parse().unwrap();
    let stranger = Webhook { url, token: webhook("127.0.0.1:1", "token = 's3cret'").token, ..stranger };
    let known = Webhook { name: "known".to_owned(), ca_file: Some(folder.path().join("ca.pem")), ..stranger.clone() };
    let fixture = Fixture::new(&[&stranger, &known]);
    fixture.chatter();
    let _delivery = fixture.start(&stranger, QUICK);
    let view = fixture.until("ops", |view| view.problem.is_some());
    assert!(view.problem.unwrap().starts_with("there is no secure connection: invalid peer certificate"));
    assert!(came.try_recv().is_err(), "no notification was sent");
    let _delivery = fixture.start(&known, QUICK);
    assert_eq!(came.recv_timeout(LONG).unwrap().header("authorization"), Some("Bearer s3cret"));
    fixture.until("known", |view| view.delivered == 2);
}

#[test]
fn a_file_with_certificates_that_appears_later_is_read_then() {
    let folder = tempfile::tempdir().unwrap();
    let (address, came) = secure(folder.path());
    let late = folder.path().join("late.pem");
    let url = format!("https://{address}/hook").parse().unwrap();
    let hook = Webhook { url, ca_file: Some(late.clone()), ..webhook(&address, "") };
    let fixture = Fixture::new(&[&hook]);
    fixture.chatter();
    let delivery = fixture.start(&hook, QUICK);
    let view = fixture.until("ops", |view| view.problem.is_some());
    assert!(view.problem.unwrap().contains("late.pem"));
    assert!(!delivery.has_ended(), "it tries again");
    fs::copy(folder.path().join("ca.pem"), &late).unwrap();
    came.recv_timeout(LONG).unwrap();
    fixture.until("ops", |view| view.delivered == 2);
    let events = fixture.events();
    assert!(events[0].contains("late.pem cannot be read"), "{events:?}");
    assert_eq!(
        events.iter().filter(|event| event.contains("late.pem")).count(),
        1,
        "once, not at each attempt: {events:?}"
    );
    assert_eq!(events[1], "webhook \"ops\" accepts notifications again");
}

#[test]
fn a_webhook_is_not_notified_below_its_lowest_priority() {
    let (address, _came) = server(&[Answers("200 OK")]);
    let (all, high) = (webhook(&address, ""), webhook(&address, "priority = 'high'"));
    let high = Webhook { name: "high".to_owned(), ..high };
    let fixture = Fixture::new(&[&all, &high]);
    fixture.chatter();
    let reader = fixture.services.recorder().open_reader().unwrap();
    assert_eq!(
        (reader.queued_notifications("ops").unwrap().len(), reader.queued_notifications("high").unwrap().len()),
        (2, 0)
    );
    assert_eq!(reader.notifications_for_other_webhooks(&["high".to_owned()]).unwrap().len(), 2);
}

#[test]
fn an_alarm_that_waits_too_long_for_its_acknowledgement_is_delivered_as_such() {
    let (address, came) = server(&[Answers("200 OK")]);
    let mut hook = webhook(&address, "");
    // The shortest time of the station's file is a second.
    hook.unacknowledged_after = Duration::from_millis(1);
    let fixture = Fixture::new(&[&hook]);
    let _delivery = fixture.start(&hook, QUICK);
    let deadline = Instant::now() + LONG;
    let received = loop {
        fixture.services.alarms().evaluate(&inputs(5.0, Quality::Valid));
        match came.try_recv() {
            Ok(received) => break received,
            Err(_) if Instant::now() > deadline => panic!("nothing came"),
            Err(_) => pause(),
        }
    };
    let body = &received.body;
    assert_eq!((&body["change"], &body["state"]), (&"not-acknowledged".into(), &"unacknowledged".into()));
    assert_eq!((&body["value"], &body["unit"], &body["user"]), (&5.0.into(), &"Pa".into(), &Value::Null));
    assert!(body["text"].as_str().unwrap().starts_with("chamber shows 5.00e-2 mbar, above the limit"), "{body}");
}
