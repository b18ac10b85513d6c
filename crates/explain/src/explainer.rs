//! From telegrams to the story: requests find their answers, stations their state, and what changes is told.

use super::cycle::{Answer, Request};
use super::frame::{Piece, PieceKind};
use super::note::{Kind, Note, Notes};
use super::ring::Ring;
use super::slave::{Counters, Slave};
use profivac_dp::link::Baud;
use profivac_sim::describe::{Hex, global_control};
use profivac_wire::control::{Control, Function, StationType, Status};
use profivac_wire::global::GlobalControl;
use profivac_wire::{DataTelegram, Sap, Telegram};
use std::collections::BTreeMap;

/// How many octets of something damaged are shown.
const SHOWN: usize = 24;

/// Tells what happens on a line.
#[derive(Clone, Debug)]
pub struct Explainer {
    baud: Baud,
    pending: Option<Request>,
    /// What each station was asked last, by which a repetition is known.
    last: BTreeMap<u8, Request>,
    slaves: BTreeMap<u8, Slave>,
    masters: BTreeMap<u8, StationType>,
    ring: Ring,
    /// What each master ordered last.
    orders: BTreeMap<u8, String>,
    summary: Summary,
}

/// What was seen in all.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Summary {
    /// Telegrams, doubtful ones not counted.
    pub telegrams: u64,
    /// SC and tokens that may be part of something damaged.
    pub doubtful: u64,
    /// Damaged pieces.
    pub damaged: u64,
    /// How many telegrams each station sent.
    pub sent: BTreeMap<u8, u64>,
}

impl Explainer {
    /// Nothing was heard yet.
    #[must_use]
    pub fn new(baud: Baud) -> Self {
        Self {
            baud,
            pending: None,
            last: BTreeMap::new(),
            slaves: BTreeMap::new(),
            masters: BTreeMap::new(),
            ring: Ring::default(),
            orders: BTreeMap::new(),
            summary: Summary::default(),
        }
    }

    /// What was seen in all.
    #[must_use]
    pub const fn summary(&self) -> &Summary {
        &self.summary
    }

    /// The slaves that were asked something, by address, with what is known of them.
    pub fn slaves(&self) -> impl Iterator<Item = (u8, &Slave)> {
        self.slaves.iter().map(|(address, slave)| (*address, slave))
    }

    /// What became of the requests to a station.
    #[must_use]
    pub fn counters(&self, address: u8) -> Counters {
        self.slaves.get(&address).map(|slave| slave.counters).unwrap_or_default()
    }

    /// A piece, the `number`th. What it tells is appended to `told`; returned is what it means to the station concerned,
    /// beyond what every telegram says by itself.
    pub fn piece(&mut self, piece: &Piece, number: usize, told: &mut Vec<Note>) -> String {
        let mut notes = Notes { at: piece.start, number, list: told };
        match (piece.kind, Telegram::parse(&piece.octets)) {
            (PieceKind::Valid, Ok(telegram)) => {
                self.summary.telegrams = self.summary.telegrams.saturating_add(1);
                self.telegram(&telegram, piece, &mut notes)
            }
            (PieceKind::Doubtful, Ok(telegram)) => {
                self.summary.doubtful = self.summary.doubtful.saturating_add(1);
                // Only an SC somebody waits for is believed, and no token.
                if telegram == Telegram::ShortAck { self.short_ack(&mut notes) } else { String::new() }
            }
            _ => {
                self.summary.damaged = self.summary.damaged.saturating_add(1);
                notes.add(None, Kind::Damaged, damaged(piece));
                String::new()
            }
        }
    }

    fn telegram(&mut self, telegram: &Telegram<'_>, piece: &Piece, notes: &mut Notes<'_>) -> String {
        match telegram {
            Telegram::ShortAck => self.short_ack(notes),
            Telegram::Token { da, sa } => {
                self.silence(notes);
                self.count(*sa);
                self.ring.token(*sa, *da, notes);
                String::new()
            }
            Telegram::Data(frame) => {
                self.count(frame.sa);
                match frame.control() {
                    Control::Request { function, .. } => self.request(frame, function, piece, notes),
                    Control::Response { station, status } => self.response(frame, station, status, notes),
                }
            }
        }
    }

    fn count(&mut self, station: u8) {
        let sent = self.summary.sent.entry(station).or_default();
        *sent = sent.saturating_add(1);
    }

    fn short_ack(&mut self, notes: &mut Notes<'_>) -> String {
        let Some(request) = self.pending.take() else { return String::new() };
        self.count(request.slave);
        self.finish(&request, Answer { status: Status::Ok, du: &[] }, notes)
    }

    fn request(
        &mut self,
        frame: &DataTelegram<'_>,
        function: Function,
        piece: &Piece,
        notes: &mut Notes<'_>,
    ) -> String {
        self.silence(notes);
        let Some(request) = Request::of(frame, piece.start) else {
            self.order(frame, notes);
            return String::new();
        };
        if matches!(function, Function::FdlStatus | Function::Ident | Function::LsapStatus) {
            self.pending = Some(request);
            return String::new();
        }
        let is_retry = self.last.get(&request.slave).is_some_and(|last| last.is_repeated_by(&request));
        let slave = self.slaves.entry(request.slave).or_insert_with(|| Slave::new(request.slave));
        let meaning = slave.request(&request, is_retry);
        self.last.insert(request.slave, request.clone());
        self.pending = Some(request);
        meaning
    }

    /// The request before got no answer.
    fn silence(&mut self, notes: &mut Notes<'_>) {
        let Some(request) = self.pending.take() else { return };
        if let Some(slave) = self.slaves.get_mut(&request.slave).filter(|_| is_counted(request.function)) {
            slave.unanswered(&request, notes);
        }
    }

    fn response(
        &mut self,
        frame: &DataTelegram<'_>,
        station: StationType,
        status: Status,
        notes: &mut Notes<'_>,
    ) -> String {
        let Some(request) = self.pending.take_if(|request| request.is_answered_by(frame)) else { return String::new() };
        if is_counted(request.function) {
            return self.finish(&request, Answer { status, du: frame.du }, notes);
        }
        if station != StationType::Slave && self.masters.insert(frame.sa, station) != Some(station) {
            let state = match station {
                StationType::MasterInRing => "is a master in the token ring",
                StationType::MasterReady => "is a master that wants into the token ring",
                StationType::MasterNotReady | StationType::Slave => "is a master that is not ready for the token ring",
            };
            notes.about(frame.sa, Kind::Presence, state);
        }
        String::new()
    }

    fn finish(&mut self, request: &Request, answer: Answer<'_>, notes: &mut Notes<'_>) -> String {
        let Some(slave) = self.slaves.get_mut(&request.slave) else { return String::new() };
        slave.answer(request, answer, self.baud, notes)
    }

    /// What is sent without an answer: Global_Control.
    fn order(&mut self, frame: &DataTelegram<'_>, notes: &mut Notes<'_>) {
        let (Sap::GlobalControl, Ok(control)) = (Sap::from_octet(frame.dsap), GlobalControl::parse(frame.du)) else {
            return;
        };
        let order = global_control(control);
        if self.orders.get(&frame.sa) != Some(&order) {
            let whom = if frame.da == profivac_wire::BROADCAST { "all".to_owned() } else { frame.da.to_string() };
            notes.add(None, Kind::Control, format!("master {} orders{order} to {whom}", frame.sa));
            self.orders.insert(frame.sa, order);
        }
    }
}

/// Whether a request goes to a service, not only to a station.
const fn is_counted(function: Function) -> bool {
    !matches!(function, Function::FdlStatus | Function::Ident | Function::LsapStatus)
}

/// What is wrong with a damaged piece.
fn damaged(piece: &Piece) -> String {
    let reason = match (&piece.errors[..], Telegram::parse(&piece.octets)) {
        ([], Err(defect)) => defect.to_string(),
        ([], Ok(_)) => "not between valid ones".to_owned(),
        (errors, _) => {
            let places: Vec<String> = errors.iter().map(|place| place.saturating_add(1).to_string()).collect();
            format!("character error in octet {}", places.join(", "))
        }
    };
    let shown = piece.octets.get(..SHOWN).unwrap_or(&piece.octets);
    let more = if shown.len() < piece.octets.len() { " ..." } else { "" };
    format!("damaged, {} octets: {reason}: {}{more}", piece.octets.len(), Hex(shown))
}
