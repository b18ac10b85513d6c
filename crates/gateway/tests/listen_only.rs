//! The points of a segment that another master owns.

#![allow(clippy::unwrap_used, clippy::panic, clippy::indexing_slicing, reason = "a test")]

use profivac_devices::catalog::model_named;
use profivac_gateway::signal::{LINE_STATES, QUALITIES};
use profivac_gateway::{PointValue, ReadModel, Signal, Snapshot, State, Value};
use profivac_station::config::Config;
use profivac_station::station::Station;
use profivac_wire::{DataTelegram, MAX_TELEGRAM, Telegram};
use std::io::{ErrorKind, Read, Write};
use std::net::TcpListener;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::sync::{Arc, LazyLock};
use std::time::{Duration, Instant};

const MASTER: u8 = 2;
const SLAVE: u8 = 12;

fn telegram(da: u8, sa: u8, saps: Option<(u8, u8)>, fc: u8, du: &[u8]) -> Vec<u8> {
    let mut octets = vec![0; MAX_TELEGRAM];
    let (dsap, ssap) = saps.map_or((None, None), |(dsap, ssap)| (Some(dsap), Some(ssap)));
    let length = Telegram::Data(DataTelegram { da, sa, dsap, ssap, fc, du }).emit(&mut octets).unwrap();
    octets.truncate(length);
    octets
}

/// A controller starts a BCG450 with pressures in Torr.
fn start_up() -> Vec<Vec<u8>> {
    let model = model_named("bcg450").unwrap();
    let torr = model.unit_named("Torr").unwrap();
    let user = model.user_prm.iter().find(|prm| prm.unit_code() == torr.code).unwrap();
    let [high, low] = model.ident.to_be_bytes();
    let prm = [&[0x88, 1, 100, 11, high, low, 0][..], user.octets].concat();
    let diagnosis = [0x00, 0x0C, 0x00, MASTER, high, low];
    vec![
        telegram(SLAVE, MASTER, Some((61, 62)), 0x6D, &prm),
        vec![0xE5],
        telegram(SLAVE, MASTER, Some((62, 62)), 0x5D, model.configurations[1].octets),
        vec![0xE5],
        telegram(SLAVE, MASTER, Some((60, 62)), 0x7D, &[]),
        telegram(MASTER, SLAVE, Some((62, 60)), 0x08, &diagnosis),
    ]
}

/// A token and an exchange; every tenth request is repeated.
fn cycle(number: u64) -> Vec<Vec<u8>> {
    let inputs = [&[0x80, 0x00, 0x02][..], &1.0e-4_f32.to_be_bytes()].concat();
    let request = telegram(SLAVE, MASTER, None, if number.is_multiple_of(2) { 0x7D } else { 0x5D }, &[]);
    let repetition = if number.is_multiple_of(10) { vec![request.clone()] } else { Vec::new() };
    let answer = telegram(MASTER, SLAVE, None, 0x08, &inputs);
    [vec![vec![0xDC, MASTER, MASTER]], repetition, vec![request, answer]].concat()
}

/// A bus of another master behind a TCP port. It counts what the station sends.
struct ForeignBus {
    port: u16,
    starts: Arc<AtomicBool>,
    received: Arc<AtomicU64>,
}

impl ForeignBus {
    fn begin() -> Self {
        let listener = TcpListener::bind("127.0.0.1:0").unwrap();
        let port = listener.local_addr().unwrap().port();
        let (starts, received) = (Arc::new(AtomicBool::new(false)), Arc::new(AtomicU64::new(0)));
        let (own_starts, own_received) = (Arc::clone(&starts), Arc::clone(&received));
        std::thread::spawn(move || {
            let Ok((mut stream, _)) = listener.accept() else { return };
            // The time in which the station could send paces the bus.
            stream.set_read_timeout(Some(Duration::from_millis(10))).unwrap();
            stream.set_nodelay(true).unwrap();
            for number in 0_u64.. {
                let telegrams = if own_starts.swap(false, Ordering::Relaxed) { start_up() } else { cycle(number) };
                for telegram in telegrams {
                    if stream.write_all(&telegram).is_err() {
                        return;
                    }
                    match stream.read(&mut [0; 64]) {
                        Ok(0) => return,
                        Ok(count) => drop(own_received.fetch_add(count as u64, Ordering::Relaxed)),
                        Err(error) => assert!(matches!(error.kind(), ErrorKind::WouldBlock | ErrorKind::TimedOut)),
                    }
                }
            }
        });
        Self { port, starts, received }
    }
}

/// Waits for a snapshot that `is_it`.
fn until(what: &str, model: &ReadModel, is_it: impl Fn(&Snapshot) -> bool) -> Arc<Snapshot> {
    let end = Instant::now() + Duration::from_secs(60);
    loop {
        let snapshot = model.snapshot();
        if is_it(&snapshot) {
            return snapshot;
        }
        assert!(Instant::now() < end, "no {what}");
        std::thread::park_timeout(Duration::from_millis(20));
    }
}

/// The value of a point; one without a value before the segment has published its gauges.
fn value<'a>(snapshot: &'a Snapshot, subject: &str, signal: Signal) -> &'a PointValue {
    static NONE: LazyLock<PointValue> = LazyLock::new(PointValue::default);
    let found = snapshot.iter().find(|(point, _)| point.subject.name() == subject && point.signal == signal);
    found.map_or(&NONE, |(_, value)| value)
}

fn word(snapshot: &Snapshot, subject: &str, signal: Signal, words: &'static [&'static str]) -> &'static str {
    match value(snapshot, subject, signal).value {
        Value::Choice(number) => words[usize::from(number)],
        _ => "",
    }
}

fn text(snapshot: &Snapshot, subject: &str, signal: Signal) -> String {
    value(snapshot, subject, signal).value.to_string()
}

#[test]
fn a_gauge_of_another_master_is_assumed_until_its_unit_is_heard_and_its_line_has_statistics() {
    let folder = tempfile::tempdir().unwrap();
    let bus = ForeignBus::begin();
    let file = format!(
        "[[segment]]\nname = \"plc\"\nport = \"tcp://127.0.0.1:{}\"\nlisten-only = true\n\
         [[segment.gauge]]\nname = \"furnace\"\naddress = {SLAVE}\ndevice = \"bcg450\"\npoll = \"50 ms\"\n",
        bus.port
    );
    let station = Station::start(Config::parse(&file, &folder.path().join("plant.toml")).unwrap()).unwrap();
    let model = ReadModel::start(station.services()).unwrap();

    let assumed = until("assumed reading", &model, |it| word(it, "furnace", Signal::Quality, &QUALITIES) == "assumed");
    let pressure = value(&assumed, "furnace", Signal::Pressure);
    assert_eq!(
        (&pressure.value, pressure.state),
        (&Value::None, State::Invalid),
        "no number in a unit that is not known"
    );
    assert_eq!(text(&assumed, "furnace", Signal::Cause), "1.0e-4 mbar if the unit is mbar");
    assert_eq!(text(&assumed, "furnace", Signal::LineUnit), "");
    assert_ne!(text(&assumed, "furnace", Signal::Assumptions), "");

    bus.starts.store(true, Ordering::Relaxed);
    let heard = until("pressure and statistics", &model, |it| {
        let count = |subject, signal| matches!(value(it, subject, signal).value, Value::Integer(count) if count > 2);
        word(it, "furnace", Signal::Quality, &QUALITIES) == "valid"
            && text(it, "furnace", Signal::LineUnit) == "Torr"
            && count("furnace", Signal::Repetitions)
            && count("plc", Signal::Telegrams)
    });
    let pressure = value(&heard, "furnace", Signal::Pressure);
    let pa = pressure.value.float().unwrap();
    assert!((pa / 0.013_332_2 - 1.0).abs() < 1e-4 && pressure.state == State::Ok, "1e-4 Torr: {pa} Pa");
    assert_eq!(value(&heard, "furnace", Signal::ListenOnly).value, Value::Boolean(true));
    assert_eq!(word(&heard, "furnace", Signal::LineState, &LINE_STATES), "exchanging");
    assert_eq!(value(&heard, "furnace", Signal::Owner).value, Value::Integer(MASTER.into()));
    assert_eq!(value(&heard, "furnace", Signal::LongestSequence).value, Value::Integer(1));
    assert_eq!(value(&heard, "plc", Signal::SegmentListenOnly).value, Value::Boolean(true));
    assert_eq!(value(&heard, "plc", Signal::Master).value, Value::None, "the station has no master on it");
    assert_eq!(text(&heard, "plc", Signal::TokenRing), MASTER.to_string());
    assert!(
        heard.points.iter().all(|point| point.signal.subject() != profivac_gateway::signal::SubjectKind::Parameter)
    );
    station.stop();
    assert_eq!(bus.received.load(Ordering::Relaxed), 0, "the station sends nothing");
}
