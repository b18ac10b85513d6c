//! Webhooks against servers that fail, hang, redirect, refuse, and take it in the end.

#![allow(clippy::unwrap_used, clippy::panic, clippy::indexing_slicing, reason = "a test")]

mod desk;

use desk::sight;
use profivac_recorder::alarms::{AlarmBatch, Notification};
use profivac_recorder::{Micros, Recorder, Settings};
use profivac_station::alarm::NotificationTarget;
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

/// Long enough for a computer that is busy with something else.
const LONG: Duration = Duration::from_secs(60);

/// Hardly any pause.
const QUICK: DeliverySettings = DeliverySettings {
    poll_interval: Duration::from_millis(2),
    answer_timeout: LONG,
    first_pause: Duration::from_millis(1),
    longest_pause: Duration::from_millis(5),
    max_age: Duration::from_secs(86_400),
    max_queued: 10_000,
};

/// What a receiver does with a request.
#[derive(Clone, Copy)]
enum Mood {
    Answers(&'static str),
    Hangs,
    Closes,
}

use Mood::{Answers, Closes, Hangs};

/// A request that came.
struct Came {
    head: String,
    body: Value,
}

impl Came {
    fn header(&self, name: &str) -> Option<&str> {
        let lines = self.head.lines().filter_map(|line| line.split_once(": "));
        lines.into_iter().find(|(key, _)| key.eq_ignore_ascii_case(name)).map(|(_, value)| value)
    }
}

/// Serves each request in the next mood, and at last in the last one for ever. Gives its address and what came.
fn receiver(moods: &'static [Mood]) -> (String, Receiver<Came>) {
    let listener = TcpListener::bind("127.0.0.1:0").unwrap();
    let address = listener.local_addr().unwrap().to_string();
    let (sender, came) = channel();
    std::thread::spawn(move || {
        // Those that hang are kept open.
        let mut kept = Vec::new();
        for number in 0.. {
            let Ok((stream, _)) = listener.accept() else { return };
            let mood = moods[number.min(moods.len() - 1)];
            let Some(request) = read(&stream) else { continue };
            match mood {
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

fn read(stream: impl Read) -> Option<Came> {
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
    Some(Came { head, body: serde_json::from_slice(&body).ok()? })
}

struct Desk {
    plant: Arc<Services>,
    folder: TempDir,
}

impl Desk {
    fn new(hooks: &[&Webhook]) -> Self {
        let folder = tempfile::tempdir().unwrap();
        Self { plant: open(folder.path(), hooks), folder }
    }

    /// The pressure goes up and down once: two letters.
    fn chatter(&self) {
        for pa in [5.0, 0.001] {
            self.plant.alarms().evaluate(self.plant.recorder(), &sight(pa, "valid"));
        }
        assert!(self.plant.recorder().flush());
    }

    fn start(&self, webhook: &Webhook, patience: DeliverySettings) -> DeliveryThread {
        DeliveryThread::start(webhook.clone(), Arc::clone(&self.plant), patience).unwrap()
    }

    /// Waits until the webhook is as wanted.
    fn until(&self, name: &str, wanted: impl Fn(&WebhookView) -> bool) -> WebhookView {
        let end = Instant::now() + LONG;
        loop {
            let views = self.plant.webhooks().views(&self.plant.open_reader().unwrap()).unwrap();
            let view = views.into_iter().find(|view| view.name == name).unwrap();
            if wanted(&view) {
                return view;
            }
            assert!(Instant::now() < end, "it never was: {view:?}");
            std::thread::yield_now();
        }
    }

    fn events(&self) -> Vec<String> {
        assert!(self.plant.recorder().flush());
        let events = self.plant.open_reader().unwrap().events(Micros(0), Micros(i64::MAX), 1000).unwrap();
        events.into_iter().map(|event| event.text).filter(|text| text.starts_with("webhook")).rev().collect()
    }
}

fn open(folder: &Path, hooks: &[&Webhook]) -> Arc<Services> {
    let file = folder.join("plant.db");
    let recorder = Recorder::start(&file, Settings::default()).unwrap();
    let plant = Arc::new(Services::new("Target hall".to_owned(), file, recorder));
    let addressees = hooks
        .iter()
        .map(|hook| NotificationTarget { webhook: hook.name.clone(), min_priority: hook.min_priority })
        .collect();
    plant.alarms().begin(&plant, config("").alarms, addressees).unwrap();
    plant
}

fn config(more: &str) -> Config {
    let file = "[[segment]]\nname = 'hall'\nport = 'p'\n[[segment.gauge]]\nname = 'chamber'\naddress = 5\ndevice = 'bcg450'\n\
        [[alarm]]\nname = 'too high'\ngauge = 'chamber'\nabove = '1 Pa'\ndelay = '0 s'\noff-delay = '0 s'\n\
        [alarms]\nblind = { priority = 'off' }\n";
    Config::parse(&format!("{file}{more}"), Path::new("plant.toml")).unwrap()
}

fn webhook(address: &str, more: &str) -> Webhook {
    config(&format!("[[webhook]]\nname = 'ops'\nurl = 'http://{address}/hook?key=abc'\n{more}")).webhooks.remove(0)
}

#[test]
fn a_letter_says_everything_and_goes_with_its_token() {
    let (address, came) = receiver(&[Answers("204 No Content")]);
    let hook = webhook(&address, "token = 's3cret'");
    let desk = Desk::new(&[&hook]);
    let _courier = desk.start(&hook, QUICK);
    desk.chatter();
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
        ("what", "raised".into()),
        ("state", "unacknowledged".into()),
        ("priority", "medium".into()),
        ("gauge", "chamber".into()),
        ("value", 5.0.into()),
        ("limit", 1.0.into()),
        ("unit", "Pa".into()),
        ("who", Value::Null),
    ] {
        assert_eq!(first.body[key], value, "{key}");
    }
    let second = came.recv_timeout(LONG).unwrap();
    assert_eq!((&second.body["what"], &second.body["state"]), (&"returned".into(), &"returned".into()));
    assert_ne!(first.body["id"], second.body["id"]);
    let view = desk.until("ops", |view| view.delivered == 2 && view.waiting == 0);
    assert_eq!((view.at, view.problem), (format!("http://{address}"), None));
    let shown = format!("{hook:?} {:?}", desk.plant.webhooks().views(&desk.plant.open_reader().unwrap()).unwrap())
        + &desk.events().concat();
    assert!(!shown.contains("s3cret") && !shown.contains("abc"), "{shown}");
}

#[test]
fn what_is_not_taken_is_told_again_until_it_is_and_in_order() {
    static MOODS: [Mood; 6] = [
        Answers("500 Oh"),
        Closes,
        Hangs,
        Answers("302 Found\r\nlocation: /elsewhere"),
        Answers("429 Slower"),
        Answers("200 OK"),
    ];
    let (address, came) = receiver(&MOODS);
    let hook = webhook(&address, "");
    let desk = Desk::new(&[&hook]);
    desk.chatter();
    // Who answers at all answers sooner than that, also on a computer that is busy.
    let _courier = desk.start(&hook, DeliverySettings { answer_timeout: Duration::from_secs(3), ..QUICK });
    let all: Vec<_> = (0..7).map(|_| came.recv_timeout(LONG).unwrap()).collect();
    assert!(all.iter().all(|came| came.head.starts_with("POST /hook?key=abc ")), "redirects are not followed");
    let ids: Vec<_> = all.iter().map(|came| &came.body["id"]).collect();
    assert!(ids[..6].iter().all(|id| *id == ids[0]), "whoever gets it twice knows it again: {ids:?}");
    assert_eq!((&all[5].body["what"], &all[6].body["what"]), (&"raised".into(), &"returned".into()));
    desk.until("ops", |view| view.delivered == 2 && view.problem.is_none() && view.failing_since_ms.is_none());
    assert_eq!(
        desk.events(),
        [
            "webhook \"ops\" takes no letters: the answer is 500; it is tried again",
            "webhook \"ops\" takes letters again"
        ]
    );
}

#[test]
fn one_that_hangs_holds_up_nobody() {
    let (slow, _came) = receiver(&[Hangs]);
    let (quick, came) = receiver(&[Answers("200 OK")]);
    let hanging = webhook(&slow, "");
    let other = Webhook { name: "other".to_owned(), ..webhook(&quick, "") };
    let desk = Desk::new(&[&hanging, &other]);
    let hangs = desk.start(&hanging, QUICK);
    let _other = desk.start(&other, QUICK);
    for _ in 0..5 {
        desk.chatter();
    }
    (0..10).for_each(|_| drop(came.recv_timeout(LONG).unwrap()));
    desk.until("ops", |view| view.waiting == 10);
    // It is not waited for.
    let begun = Instant::now();
    drop(hangs);
    assert!(begun.elapsed() < LONG / 2);
}

#[test]
fn what_was_not_taken_is_told_by_the_next_program() {
    let (address, came) = receiver(&[Answers("503 Later"), Answers("200 OK")]);
    let hook = webhook(&address, "");
    let desk = Desk::new(&[&hook]);
    desk.chatter();
    let asleep = DeliverySettings { first_pause: LONG, longest_pause: LONG, ..QUICK };
    let courier = desk.start(&hook, asleep);
    let first = came.recv_timeout(LONG).unwrap();
    desk.until("ops", |view| view.problem.as_deref() == Some("the answer is 503"));
    drop(courier);
    let Desk { plant, folder } = desk;
    drop(plant);
    let plant = open(folder.path(), &[&hook]);
    let _courier = DeliveryThread::start(hook, plant, QUICK).unwrap();
    let again = came.recv_timeout(LONG).unwrap();
    assert_eq!(first.body, again.body, "with the same number");
}

#[test]
fn what_nobody_understands_and_what_is_too_old_or_too_much_is_given_up() {
    let (address, came) = receiver(&[Answers("400 What"), Answers("200 OK")]);
    let hook = webhook(&address, "");
    let desk = Desk::new(&[&hook]);
    desk.chatter();
    let courier = desk.start(&hook, QUICK);
    assert_eq!(came.recv_timeout(LONG).unwrap().body["what"], "raised");
    assert_eq!(came.recv_timeout(LONG).unwrap().body["what"], "returned");
    desk.until("ops", |view| (view.delivered, view.given_up) == (1, 1));
    drop(courier);
    desk.chatter();
    let courier = desk.start(&hook, DeliverySettings { max_queued: 1, ..QUICK });
    assert_eq!(came.recv_timeout(LONG).unwrap().body["what"], "returned", "the older one is given up");
    desk.until("ops", |view| (view.delivered, view.given_up) == (1, 1));
    drop(courier);
    desk.chatter();
    let _courier = desk.start(&hook, DeliverySettings { max_age: Duration::ZERO, ..QUICK });
    desk.until("ops", |view| (view.delivered, view.given_up, view.waiting) == (0, 2, 0));
    let events = desk.events();
    assert_eq!(events[0], "webhook \"ops\" was not told of 1 letters: the answer is 400");
    assert_eq!(events[1], "webhook \"ops\" was not told of 1 letters: there are too many");
    assert_eq!(events[2], "webhook \"ops\" was not told of 2 letters: it is too old");
}
#[test]
fn a_record_that_was_deleted_is_told_of_like_any_other() {
    let (address, came) = receiver(&[Answers("200 OK")]);
    let hook = webhook(&address, "");
    let desk = Desk::new(&[&hook]);
    let _courier = desk.start(&hook, QUICK);
    for delivered in [2, 4] {
        desk.chatter();
        (0..2).for_each(|_| drop(came.recv_timeout(LONG).unwrap()));
        desk.until("ops", |view| view.delivered == delivered && view.waiting == 0);
        // What comes next lies in a new file, whose letters have the numbers of those before.
        fs::remove_file(desk.folder.path().join("plant.db")).unwrap();
        assert!(desk.plant.recorder().flush());
    }
}

#[test]
fn a_day_of_letters_is_given_up_at_once() {
    let (address, _came) = receiver(&[Answers("200 OK")]);
    let hook = webhook(&address, "");
    let desk = Desk::new(&[&hook]);
    let letter = |at| Notification { id: 0, webhook: hook.name.clone(), at: Micros(at), body: "{}".to_owned() };
    let batch = AlarmBatch { notifications: (0..2000).map(letter).collect(), ..AlarmBatch::default() };
    assert!(desk.plant.recorder().record_alarms_with_receipt(batch, Vec::new()).wait());
    let _courier = desk.start(&hook, QUICK);
    desk.until("ops", |view| (view.delivered, view.given_up, view.waiting) == (0, 2000, 0));
    assert_eq!(desk.events(), ["webhook \"ops\" was not told of 2000 letters: it is too old"]);
}

/// A server with a certificate of its own, and the file with it. It takes everything.
fn secure(folder: &Path) -> (String, Receiver<Came>) {
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
fn over_https_only_those_are_told_for_whom_somebody_vouches() {
    let folder = tempfile::tempdir().unwrap();
    let (address, came) = secure(folder.path());
    let stranger = webhook(&address, "");
    let url = format!("https://{address}/hook").parse().unwrap();
    let stranger = Webhook { url, token: webhook("127.0.0.1:1", "token = 's3cret'").token, ..stranger };
    let known = Webhook { name: "known".to_owned(), ca_file: Some(folder.path().join("ca.pem")), ..stranger.clone() };
    let desk = Desk::new(&[&stranger, &known]);
    desk.chatter();
    let _courier = desk.start(&stranger, QUICK);
    let view = desk.until("ops", |view| view.problem.is_some());
    assert!(view.problem.unwrap().starts_with("there is no secure connection: invalid peer certificate"));
    assert!(came.try_recv().is_err(), "nobody was told anything");
    let _courier = desk.start(&known, QUICK);
    assert_eq!(came.recv_timeout(LONG).unwrap().header("authorization"), Some("Bearer s3cret"));
    desk.until("known", |view| view.delivered == 2);
}

#[test]
fn who_is_told_of_high_ones_alone_is_not_told_of_others() {
    let (address, _came) = receiver(&[Answers("200 OK")]);
    let (all, high) = (webhook(&address, ""), webhook(&address, "priority = 'high'"));
    let high = Webhook { name: "high".to_owned(), ..high };
    let desk = Desk::new(&[&all, &high]);
    desk.chatter();
    let reader = desk.plant.open_reader().unwrap();
    assert_eq!(
        (reader.queued_notifications("ops").unwrap().len(), reader.queued_notifications("high").unwrap().len()),
        (2, 0)
    );
    assert_eq!(reader.notifications_for_other_webhooks(&["high".to_owned()]).unwrap().len(), 2);
}
