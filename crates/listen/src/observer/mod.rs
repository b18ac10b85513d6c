//! The observer: it gets telegrams and damaged pieces with their times and keeps the state of the line in bounded memory.
//!
//! | Module | Holds |
//! |---|---|
//! | `requests`, `answers` | message cycles: repetitions, lost stations, refusals |
//! | `damage` | the station to which a damaged piece belongs |
//! | `contents` | cyclic data, diagnosis, parameters and configuration |
//! | `ring` | token ring, cycle times |
//!
//! It composes no sentences: a change is data, and its text is made when it is shown.

mod answers;
mod contents;
mod damage;
mod requests;
mod ring;

use crate::counts::{Counts, CountsOverTime};
use crate::event::{Change, Event, Events};
use crate::gauge::{Declared, GaugeReading};
use crate::histogram::Histogram;
use crate::parameters::Passed;
use crate::station::{Station, StationState};
use profivac_dp::link::{Baud, BitTime, CHARACTER_TBIT};
use profivac_explain::divider::character_tbit;
use profivac_explain::frame::{Piece, PieceKind, TimeSource};
use profivac_explain::gsd::Files;
use profivac_explain::names::DeviceTables;
use profivac_wire::control::Control;
use profivac_wire::{Sap, Telegram};

/// The addresses of stations: 0 to 126.
const ADDRESSES: usize = 127;

/// The longest piece that may be a damaged request.
const MAX_REQUEST: usize = 256;

/// Totals of the line.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Totals {
    /// Valid telegrams.
    pub telegrams: u64,
    /// Octets of valid telegrams and of damaged pieces.
    pub octets: u64,
    /// Damaged pieces; those without a pause between them count once.
    pub damaged: u64,
    /// Damaged pieces that are neither the answer of a station nor a request that was repeated.
    pub unattributed: u64,
    /// Tokens.
    pub tokens: u64,
}

/// The state of a line.
#[derive(Clone, Debug)]
pub struct Observer {
    /// The rate whose bit times the times of the pieces are.
    baud: Baud,
    /// The rate of the line, and the duration of a character on it.
    line: Baud,
    character_tbit: u64,
    /// Where the times of the pieces come from: those of an operating system are too coarse to measure a delay.
    times: TimeSource,
    /// The time of the last piece, or of the last `advance`.
    now: BitTime,
    /// The start of the first piece.
    began: Option<BitTime>,
    /// The GSD files of slaves.
    files: Files,
    /// The stations by address.
    stations: Vec<Option<Box<Station>>>,
    totals: Totals,
    events: Events,

    /// The slave whose request has no answer yet.
    pending: Option<u8>,
    /// The slave of the last request, until it has a valid answer or its master gives it up: it may be repeated.
    open: Option<u8>,
    /// Master and address of an FDL status request that has no answer yet.
    pending_status: Option<(u8, u8)>,
    /// The end of the last valid telegram.
    asked_end: BitTime,
    /// The shortest time in which a master gave up waiting for an answer: an answer begins before it. `None` until a master has.
    slot_tbit: Option<u64>,

    /// Damaged pieces of the line in the last minute.
    damage_counts: CountsOverTime,
    /// The number of damaged pieces that may be requests.
    damage_epoch: u64,
    /// The last damaged piece that may be a request, with the pieces that continue it.
    damaged_request: Vec<u8>,
    /// The last damaged piece is the kept one: octets that follow without a pause continue it.
    is_last_kept: bool,
    /// The beginning of damage that is too short for a request so far.
    damage_begun: Option<Piece>,
    /// Damaged pieces too short for a request that came while a master waited for an answer.
    disturbances: u32,
    /// How many pieces of this length came one after the other.
    damaged_requests: u32,
    /// A character of its header was received with an error.
    header_is_damaged: bool,
    /// One of its addresses or its frame control was.
    addresses_are_damaged: bool,
    /// The end of the last damaged piece.
    damage_until: BitTime,
    /// The end of the last piece if it was damaged.
    damage_end: Option<BitTime>,
    burst: Burst,

    /// The station to which each master passed the token last, by the address of the master.
    next: [u8; ADDRESSES],
    /// The masters in the order of the token.
    ring: Vec<u8>,
    rotation: Histogram,
    cycle: Histogram,
}

/// Damaged pieces in the present second.
#[derive(Clone, Copy, Debug, Default)]
struct Burst {
    began: BitTime,
    count: u32,
    is_reported: bool,
}

/// No master has passed a token.
const NO_STATION: u8 = u8::MAX;

impl Observer {
    /// An observer without any traffic yet. Times of an operating system are too coarse to tell a damaged answer from a damaged
    /// repetition by its delay.
    #[must_use]
    pub fn new(baud: Baud, times: TimeSource) -> Self {
        Self {
            baud,
            line: baud,
            character_tbit: CHARACTER_TBIT,
            times,
            now: BitTime(0),
            began: None,
            files: Files::default(),
            stations: vec![None; ADDRESSES],
            totals: Totals::default(),
            events: Events::default(),
            pending: None,
            open: None,
            pending_status: None,
            asked_end: BitTime(0),
            slot_tbit: None,
            damage_counts: CountsOverTime::new(baud),
            damage_epoch: 0,
            damaged_request: Vec::with_capacity(MAX_REQUEST),
            is_last_kept: false,
            damage_begun: None,
            disturbances: 0,
            damaged_requests: 0,
            header_is_damaged: false,
            addresses_are_damaged: false,
            damage_until: BitTime(0),
            damage_end: None,
            burst: Burst::default(),
            next: [NO_STATION; ADDRESSES],
            ring: Vec::new(),
            rotation: Histogram::default(),
            cycle: Histogram::default(),
        }
    }

    /// The observer, for a line with another rate than the one that counts the times. Only with [`TimeSource::Platform`].
    #[must_use]
    pub fn with_line_rate(self, line: Baud) -> Self {
        Self { line, character_tbit: character_tbit(self.baud, line), ..self }
    }

    /// The observer, with the GSD files of slaves.
    #[must_use]
    pub fn with_gsd(mut self, files: Files) -> Self {
        self.files = files;
        self
    }

    /// The rate whose bit times the times of the pieces are.
    #[must_use]
    pub const fn baud(&self) -> Baud {
        self.baud
    }

    /// The rate of the line.
    #[must_use]
    pub const fn line_baud(&self) -> Baud {
        self.line
    }

    /// The time of the last piece, or of the last [`advance`](Self::advance).
    #[must_use]
    pub const fn now(&self) -> BitTime {
        self.now
    }

    /// The bit times since the first piece.
    #[must_use]
    pub fn observed_tbit(&self) -> u64 {
        self.began.map_or(0, |began| self.now - began)
    }

    /// Totals of the line.
    #[must_use]
    pub const fn totals(&self) -> &Totals {
        &self.totals
    }

    /// Damaged pieces of the last minute.
    #[must_use]
    pub fn damaged_last_minute(&self) -> u64 {
        self.damage_counts.last_minute(self.now).damaged
    }

    /// Time passes on a silent line.
    pub fn advance(&mut self, now: BitTime) {
        self.now = self.now.max(now);
    }

    /// What the user says about the gauge at `address`.
    pub fn declare(&mut self, address: u8, declared: Declared) {
        if let Some(station) = self.station_mut(address) {
            station.knowledge.declare(declared);
            station.tables.model = Some(declared.model);
            station.tables.unit = station.tables.unit.or(declared.unit);
        }
    }

    /// The stations with their addresses.
    pub fn stations(&self) -> impl Iterator<Item = (u8, &Station)> {
        (0_u8..).zip(&self.stations).filter_map(|(address, station)| Some((address, &**station.as_ref()?)))
    }

    /// The station at `address`, if a telegram showed one or the user declared a gauge.
    #[must_use]
    pub fn station(&self, address: u8) -> Option<&Station> {
        self.stations.get(usize::from(address))?.as_deref()
    }

    /// The state of the station at `address` in the live list.
    #[must_use]
    pub fn state(&self, address: u8) -> Option<StationState> {
        self.station(address)?.state(self.now, self.baud)
    }

    /// The pressures in the last inputs of the slave at `address`.
    #[must_use]
    pub fn reading(&self, address: u8) -> Option<GaugeReading> {
        self.station(address)?.knowledge.reading(address)
    }

    /// The masters in the order of the token, beginning with the lowest address.
    #[must_use]
    pub fn ring(&self) -> &[u8] {
        &self.ring
    }

    /// The durations of token rotations.
    #[must_use]
    pub const fn rotation(&self) -> &Histogram {
        &self.rotation
    }

    /// The durations of cycles of all masters.
    #[must_use]
    pub const fn cycle(&self) -> &Histogram {
        &self.cycle
    }

    /// The events.
    #[must_use]
    pub const fn events(&self) -> &Events {
        &self.events
    }

    /// The name and the value of a parameter that passed, from the tables of its slave.
    #[must_use]
    pub fn parameter_text(&self, address: u8, passed: &Passed) -> (String, String) {
        let tables = self.station(address).map_or_else(DeviceTables::default, |station| station.tables);
        let (slot, index) = passed.location;
        let value = if passed.octets.is_empty() { String::new() } else { tables.value(slot, index, &passed.octets) };
        (tables.name(slot, index), value)
    }

    /// Adds a piece of the traffic.
    pub fn piece(&mut self, piece: &Piece) {
        let start = piece.start.unwrap_or(self.now);
        let length_tbit = (piece.octets.len() as u64).saturating_mul(self.character_tbit);
        self.now = self.now.max(start + length_tbit);
        self.began.get_or_insert(start);
        self.totals.octets = self.totals.octets.saturating_add(piece.octets.len() as u64);
        match (piece.kind, Telegram::parse(&piece.octets)) {
            (PieceKind::Valid, Ok(telegram)) => {
                self.totals.telegrams = self.totals.telegrams.saturating_add(1);
                self.telegram(&telegram, start);
                self.damage_end = None;
                self.asked_end = self.now;
            }
            // A doubtful SC counts only as the answer to a pending request.
            (PieceKind::Doubtful, Ok(Telegram::ShortAck)) if self.pending.is_some() => self.short_ack(start),
            _ => self.damaged(piece, start, start + length_tbit),
        }
    }

    /// The octets of a damaged request that are kept.
    #[cfg(test)]
    pub(crate) fn held_request(&self) -> usize {
        self.damaged_request.len()
    }

    fn station_mut(&mut self, address: u8) -> Option<&mut Station> {
        let (baud, files) = (self.baud, &self.files);
        let entry = self.stations.get_mut(usize::from(address))?;
        Some(entry.get_or_insert_with(|| Box::new(Station::new(baud, files.clone()))))
    }

    fn count(&mut self, address: u8, change: impl Fn(&mut Counts)) {
        let now = self.now;
        if let Some(station) = self.station_mut(address) {
            station.counts.count(now, change);
        }
    }

    fn event(&mut self, station: Option<u8>, change: Change) {
        self.events.add(self.now, station, change);
    }

    fn telegram(&mut self, telegram: &Telegram<'_>, start: BitTime) {
        match telegram {
            Telegram::ShortAck => self.short_ack(start),
            Telegram::Token { da, sa } => {
                self.end_pending(start);
                self.end_cycle();
                self.token(*sa, *da, start);
            }
            Telegram::Data(data) => match data.control() {
                Control::Request { function, count } => self.request(data, function, count, start),
                Control::Response { station, status } => self.response(data, station, status, start),
            },
        }
    }

    /// The events with a higher number.
    pub fn events_since(&self, number: u64) -> impl Iterator<Item = &Event> {
        self.events.since(number)
    }
}

const fn is_acyclic(sap: Sap) -> bool {
    matches!(sap, Sap::Ms1 | Sap::Ms2(_) | Sap::ResourceManager | Sap::Alarm)
}
