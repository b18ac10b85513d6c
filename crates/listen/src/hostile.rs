//! Hostile traffic: random octets, and valid telegrams with any contents in any order, from and to every address. Nothing panics, and every
//! collection keeps its bound.

use crate::event::MAX_EVENTS;
use crate::flight::{FlightLimits, FlightRecorder};
use crate::gauge::Declared;
use crate::observer::Observer;
use crate::parameters::MAX_PARAMETERS;
use crate::report::BusReport;
use crate::station::MAX_DIAGNOSES;
use fastrand::Rng;
use profivac_devices::catalog::MODELS;
use profivac_dp::link::{Baud, BitTime};
use profivac_explain::divider::Divider;
use profivac_explain::frame::{Chunk, TimeSource};
use profivac_wire::{DataTelegram, MAX_TELEGRAM, Telegram};

/// The longest data unit.
const MAX_DU: usize = 246;

/// The longest text of an event: a diagnosis whose every three octets are a block of their own.
const MAX_TEXT: usize = 16 << 10;

/// The memory of the flight recorder in these tests.
const FLIGHT: usize = 1 << 16;

/// A listener as a segment of the station has one.
struct Listener {
    divider: Divider,
    observer: Observer,
    flight: FlightRecorder,
    octets: u64,
}

impl Listener {
    fn new(baud: Baud, times: TimeSource) -> Self {
        let limits = FlightLimits { memory_octets: FLIGHT, before_ms: 1000, after_ms: 100, ..FlightLimits::default() };
        let mut observer = Observer::new(baud, times);
        for (address, model) in (0..127).zip(MODELS.iter().cycle()) {
            let is_named = address % 3 == 0;
            let configuration = is_named.then_some(model.default_configuration);
            let unit = is_named.then(|| &model.units[0]);
            observer.declare(address, Declared { model, configuration, unit });
        }
        Self { divider: Divider::new(baud, times), observer, flight: FlightRecorder::new(baud, limits), octets: 0 }
    }

    fn hear(&mut self, chunk: &Chunk) {
        self.octets += chunk.octets.len() as u64;
        let mut pieces = Vec::new();
        self.divider.push(chunk, &mut pieces);
        for piece in &pieces {
            self.observer.piece(piece);
            self.flight.add(piece);
        }
        assert!(self.flight.memory_octets() <= FLIGHT);
    }

    fn is_bounded(&self) {
        assert!(self.observer.events().iter().count() <= MAX_EVENTS);
        assert!(self.observer.events().iter().all(|event| event.to_string().len() <= MAX_TEXT));
        assert!(self.observer.ring().len() <= 127);
        assert!(self.observer.held_request() <= MAX_TELEGRAM + 1);
        let mut stations = 0;
        for (address, station) in self.observer.stations() {
            stations += 1;
            assert!(station.diagnoses.len() <= MAX_DIAGNOSES && station.diagnosis_octets.len() <= MAX_DU);
            let reports = station.diagnoses.iter().map(|it| it.reports.iter().map(String::len).sum::<usize>());
            assert!(reports.max().unwrap_or(0) <= MAX_TEXT);
            assert!(station.set_prm.len() <= MAX_DU);
            assert!(station.last.as_ref().is_none_or(|last| last.request.du.len() <= MAX_DU));
            assert!(station.knowledge.inputs().len() <= MAX_DU);
            assert!(station.knowledge.heard_configuration().len() <= MAX_DU);
            assert!(station.knowledge.unknown().len() <= 6 && station.contradictions.len() <= 2);
            assert!(station.parameters.passed().len() <= MAX_PARAMETERS && station.parameters.is_bounded());
            assert!(station.parameters.passed().iter().all(|passed| passed.octets.len() <= MAX_DU));
            let _ = self.observer.reading(address);
        }
        assert!(stations <= 127);
    }
}

/// Octets of a telegram; none if the contents are too long.
fn emit(da: u8, sa: u8, saps: Option<(u8, u8)>, fc: u8, du: &[u8]) -> Vec<u8> {
    let mut octets = vec![0; MAX_TELEGRAM];
    let (dsap, ssap) = saps.map_or((None, None), |(dsap, ssap)| (Some(dsap), Some(ssap)));
    let length = Telegram::Data(DataTelegram { da, sa, dsap, ssap, fc, du }).emit(&mut octets).unwrap_or_default();
    octets.truncate(length);
    octets
}

/// Up to `most` octets, with the limits more often than other lengths.
fn octets(random: &mut Rng, most: usize) -> Vec<u8> {
    let length = match random.u8(0..4) {
        0 => 0,
        1 => most,
        2 => random.usize(0..=most.min(12)),
        _ => random.usize(0..=most),
    };
    (0..length).map(|_| random.u8(..)).collect()
}

/// The data unit of a service that the observer reads, and its access points.
fn service(random: &mut Rng) -> (Option<(u8, u8)>, Vec<u8>) {
    let model = random.choice(MODELS).expect("there are devices");
    let [high, low] = model.ident.to_be_bytes();
    let tail = octets(random, 230);
    match random.u8(0..8) {
        0 => (Some((61, 62)), [&[0x88, 1, 100, 11, high, low, 0][..], &tail].concat()),
        1 => (Some((62, 62)), random.choice(model.configurations).map_or(tail, |it| it.octets.to_vec())),
        2 => (Some((60, 62)), [&[random.u8(..), 0x0C, 0, random.u8(..), high, low][..], &tail].concat()),
        3 => (Some((59, 62)), tail),
        // Read, write, abort, initiate and fragments of them, on MS1 and on any MS2 connection.
        4 | 5 => {
            let function = [0x5E, 0x5F, 0x57, 0x58, 0xDE, 0xDF, 0xD7][random.usize(0..7)];
            let pdu = [&[function, random.u8(0..3), random.u8(..), random.u8(..)][..], &tail].concat();
            let length = if random.bool() { pdu.len() } else { random.usize(0..=pdu.len().min(6)) };
            let saps = if random.bool() { (51, 51) } else { (random.u8(0..50), 50) };
            (Some(saps), pdu.into_iter().take(length).collect())
        }
        _ => (None, tail),
    }
}

/// The next octets on the line: noise, a token, an answer, or a request and its answer.
fn next(random: &mut Rng) -> Vec<Vec<u8>> {
    let any = |random: &mut Rng| random.u8(0..=127);
    let (da, sa) = (any(random), any(random));
    match random.u8(0..10) {
        0 => vec![octets(random, 400)],
        1 => vec![vec![0xDC, random.u8(..), random.u8(..)]],
        2 => vec![vec![0xE5]],
        // Rings of every length.
        3 => {
            let length = random.u8(1..=127);
            (0..length).map(|index| vec![0xDC, (index + 1) % length, index]).collect()
        }
        kind => {
            let (saps, du) = service(random);
            let fc = if random.bool() { 0x5D | random.u8(0..4) << 4 } else { random.u8(..) };
            let request = emit(da, sa, saps, fc, &du);
            let (_, contents) = service(random);
            let answered = emit(sa, da, saps.map(|(dsap, ssap)| (ssap, dsap)), random.u8(0..16), &contents);
            let answer = if random.bool() { vec![0xE5] } else { answered };
            let mut all = vec![request.clone(), request, answer];
            if kind == 9 {
                all.truncate(random.usize(0..3));
            }
            for telegram in all.iter_mut().filter(|telegram| !telegram.is_empty()) {
                if random.u8(0..8) == 0 {
                    let index = random.usize(0..telegram.len());
                    telegram[index] = random.u8(..);
                }
            }
            all
        }
    }
}

/// Runs a listener on the traffic of `seed`.
fn listen(seed: u64, steps: u32) -> Listener {
    let mut random = Rng::with_seed(seed);
    let times = if random.bool() { TimeSource::Exact } else { TimeSource::Platform };
    let mut listener = Listener::new(random.choice(Baud::ALL).expect("there are rates"), times);
    for _ in 0..steps {
        for octets in next(&mut random) {
            let errors = if random.u8(0..16) == 0 { vec![random.usize(0..300)] } else { Vec::new() };
            let start = match random.u8(0..100) {
                0 => None,
                1 => Some(BitTime(random.u64(..))),
                2 => Some(BitTime(listener.observer.now().0.saturating_sub(random.u64(0..10_000)))),
                _ => Some(listener.observer.now() + random.u64(0..400)),
            };
            listener.hear(&Chunk { start, octets, errors, is_continued: random.u8(0..16) == 0 });
        }
        if random.u8(0..64) == 0 {
            listener.flight.trigger(listener.observer.now(), "a test");
        }
        if let Some(capture) = listener.flight.take_capture(listener.observer.now()) {
            // The packets of a capture have a header each; a piece has at least one octet.
            assert!(capture.file().len() < FLIGHT * 8);
        }
    }
    listener
}

#[test]
fn every_collection_keeps_its_bound_in_hostile_traffic() {
    for seed in 0..40 {
        println!("seed {seed}");
        let listener = listen(seed, 400);
        listener.is_bounded();
        let report = BusReport::of(&listener.observer);
        assert!(report.stations.len() <= 127 && report.events.len() <= 100);
        for station in &report.stations {
            assert!(station.total.repeated <= station.total.requests, "{station:?}");
        }
        let damaged: u64 = report.stations.iter().map(|station| station.total.damaged).sum();
        assert_eq!(damaged + report.damaged_unattributed, report.damaged);
    }
}

/// 100 million octets. It takes minutes; run it with `--release`.
#[test]
#[ignore = "100 million octets take minutes"]
fn a_hundred_million_octets_of_hostile_traffic_need_bounded_memory() {
    let resident = || {
        let pages = std::fs::read_to_string("/proc/self/statm").unwrap();
        pages.split_whitespace().nth(1).unwrap().parse::<u64>().unwrap() * 4096
    };
    let (mut octets, mut seed, mut at_first) = (0, 1000, None);
    while octets < 100_000_000 {
        let listener = listen(seed, 4000);
        listener.is_bounded();
        octets += listener.octets;
        seed += 1;
        if octets > 10_000_000 {
            at_first.get_or_insert_with(resident);
        }
    }
    let grown = resident().saturating_sub(at_first.unwrap());
    println!("{octets} octets, {} listeners, {at_first:?} octets of memory, {grown} more at the end", seed - 1000);
    assert!(grown < 4 << 20, "{grown}");
}
