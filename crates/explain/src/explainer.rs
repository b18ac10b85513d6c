//! Explains telegrams: matches answers with requests, keeps the state of each station, and adds a note about each change.

use super::cycle::{Answer, Request, status_text};
use super::frame::{Piece, PieceKind};
use super::gsd::Files;
use super::note::{Kind, Note, Notes, octets};
use super::ring::Ring;
use super::slave::{Counters, Slave};
use profivac_dp::link::Baud;
use profivac_sim::describe::{Hex, global_control};
use profivac_wire::control::{Control, Function, StationType, Status};
use profivac_wire::global::GlobalControl;
use profivac_wire::{DataTelegram, Sap, Telegram, TelegramLength};
use std::collections::BTreeMap;

/// The number of octets of a damaged piece that a note shows.
const SHOWN: usize = 24;

/// Octets of the shortest request, an SD1.
const SHORTEST_REQUEST: usize = 6;

/// Keeps the state of a line and explains its telegrams.
#[derive(Clone, Debug)]
pub struct Explainer {
    baud: Baud,
    /// The request that has no answer yet.
    pending: Option<Request>,
    /// The last request to each station: a repetition equals it.
    last: BTreeMap<u8, LastRequest>,
    slaves: BTreeMap<u8, Slave>,
    masters: BTreeMap<u8, StationType>,
    ring: Ring,
    /// The last Global_Control of each master.
    global_controls: BTreeMap<u8, String>,
    summary: Summary,
    files: Files,
}

/// The last request to a station.
#[derive(Clone, Debug)]
struct LastRequest {
    request: Request,
    damage: Damage,
    is_answered: bool,
    /// It is a repetition, so that further ones have no note.
    is_repetition: bool,
}

/// Damaged octets behind a request.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Damage {
    None,
    /// Only the answer is damaged.
    Answer,
    /// Other requests may be damaged: an equal frame count bit does not show a repetition.
    Requests,
}

/// Part of a station in the traffic.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Role {
    /// It has sent requests or tokens, or says that it is a master.
    Master,
    /// It has only sent answers.
    Slave,
}

/// Totals of the traffic.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Summary {
    /// Valid telegrams; doubtful ones are not counted.
    pub telegrams: u64,
    /// SC and tokens that may be part of damaged octets.
    pub doubtful: u64,
    /// Damaged pieces.
    pub damaged: u64,
    /// The octets of all pieces.
    pub octets: OctetCounts,
    /// Valid telegrams by the address of their sender.
    pub sent: BTreeMap<u8, u64>,
    /// The stations that have sent.
    pub roles: BTreeMap<u8, Role>,
}

/// Octets by the kind of their piece.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct OctetCounts {
    /// Octets of valid telegrams.
    pub telegrams: u64,
    /// Octets of SC and tokens that may be part of damaged octets.
    pub doubtful: u64,
    /// Damaged octets.
    pub damaged: u64,
}

impl OctetCounts {
    fn add(&mut self, piece: &Piece) {
        let count = match piece.kind {
            PieceKind::Valid => &mut self.telegrams,
            PieceKind::Doubtful => &mut self.doubtful,
            PieceKind::Damaged => &mut self.damaged,
        };
        *count = count.saturating_add(piece.octets.len() as u64);
    }
}

impl Explainer {
    /// An explainer without any traffic yet.
    #[must_use]
    pub fn new(baud: Baud) -> Self {
        Self {
            baud,
            pending: None,
            last: BTreeMap::new(),
            slaves: BTreeMap::new(),
            masters: BTreeMap::new(),
            ring: Ring::default(),
            global_controls: BTreeMap::new(),
            summary: Summary::default(),
            files: Files::default(),
        }
    }

    /// The explainer, with the GSD files of slaves.
    #[must_use]
    pub fn with_gsd(mut self, files: Files) -> Self {
        self.files = files;
        self
    }

    /// Totals of the traffic.
    #[must_use]
    pub const fn summary(&self) -> &Summary {
        &self.summary
    }

    /// The slaves that a master has sent a request to, by address.
    pub fn slaves(&self) -> impl Iterator<Item = (u8, &Slave)> {
        self.slaves.iter().map(|(address, slave)| (*address, slave))
    }

    /// The counters of the requests to a slave.
    #[must_use]
    pub fn counters(&self, address: u8) -> Counters {
        self.slaves.get(&address).map(|slave| slave.counters).unwrap_or_default()
    }

    /// Explains the piece with this number. Appends notes about changes to `list`. Returns the meaning of the telegram for its
    /// station, beyond its plain description; empty if there is none.
    pub fn piece(&mut self, piece: &Piece, number: usize, list: &mut Vec<Note>) -> String {
        let mut notes = Notes { at: piece.start, number, list };
        self.summary.octets.add(piece);
        match (piece.kind, Telegram::parse(&piece.octets)) {
            (PieceKind::Valid, Ok(telegram)) => {
                self.summary.telegrams = self.summary.telegrams.saturating_add(1);
                self.telegram(&telegram, piece, &mut notes)
            }
            (PieceKind::Doubtful, Ok(telegram)) => {
                self.summary.doubtful = self.summary.doubtful.saturating_add(1);
                // A doubtful SC counts only as the answer to a pending request; a doubtful token never counts.
                if telegram == Telegram::ShortAck { self.short_ack(&mut notes) } else { String::new() }
            }
            _ => {
                self.summary.damaged = self.summary.damaged.saturating_add(1);
                self.disturb(piece);
                notes.add(None, Kind::Damaged, damaged(piece));
                String::new()
            }
        }
    }

    fn telegram(&mut self, telegram: &Telegram<'_>, piece: &Piece, notes: &mut Notes<'_>) -> String {
        match telegram {
            Telegram::ShortAck => self.short_ack(notes),
            Telegram::Token { da, sa } => {
                self.end_pending(notes);
                self.count(*sa, Role::Master);
                self.ring.token(*sa, *da, notes);
                String::new()
            }
            Telegram::Data(data) => {
                let role = match data.control() {
                    Control::Response { station: StationType::Slave, .. } => Role::Slave,
                    Control::Request { .. } | Control::Response { .. } => Role::Master,
                };
                self.count(data.sa, role);
                match data.control() {
                    Control::Request { function, .. } => self.request(data, function, piece, notes),
                    Control::Response { station, status } => self.response(data, station, status, notes),
                }
            }
        }
    }

    fn count(&mut self, station: u8, role: Role) {
        let known = self.summary.roles.entry(station).or_insert(role);
        if role == Role::Master {
            *known = role;
        }
        let sent = self.summary.sent.entry(station).or_default();
        *sent = sent.saturating_add(1);
    }

    fn short_ack(&mut self, notes: &mut Notes<'_>) -> String {
        let Some(request) = self.pending.take() else { return String::new() };
        self.count(request.slave, Role::Slave);
        self.finish(&request, Answer { status: Status::Ok, du: &[] }, notes)
    }

    fn request(&mut self, data: &DataTelegram<'_>, function: Function, piece: &Piece, notes: &mut Notes<'_>) -> String {
        self.end_pending(notes);
        let Some(request) = Request::of(data, piece.start) else {
            self.global_control(data, notes);
            return String::new();
        };
        if matches!(function, Function::FdlStatus | Function::Ident | Function::LsapStatus) {
            self.pending = Some(request);
            return String::new();
        }
        let repeated = self.last.remove(&request.slave).filter(|last| last.is_repeated_by(&request));
        let is_repetition = repeated.is_some();
        let slave = self.slaves.entry(request.slave).or_insert_with(|| Slave::new(request.slave, self.files.clone()));
        if let Some(last) = repeated.filter(|last| !last.is_repetition) {
            slave.repeated(&request, last.reason(), notes);
        }
        let meaning = slave.request(&request, is_repetition);
        let last = LastRequest { request: request.clone(), damage: Damage::None, is_answered: false, is_repetition };
        self.last.insert(request.slave, last);
        self.pending = Some(request);
        meaning
    }

    /// Records damaged octets: they may be the answer to the pending request, or requests to any station.
    fn disturb(&mut self, piece: &Piece) {
        let is_one_telegram = match TelegramLength::of(&piece.octets) {
            TelegramLength::Known(length) => piece.octets.len() <= usize::from(length),
            TelegramLength::Incomplete | TelegramLength::Invalid(_) => piece.octets.len() < SHORTEST_REQUEST,
        };
        let pending = self.pending.as_ref().map(|request| request.slave);
        for (address, last) in &mut self.last {
            let is_answer = pending == Some(*address) && is_one_telegram && last.damage == Damage::None;
            last.damage = if is_answer { Damage::Answer } else { Damage::Requests };
        }
    }

    /// Counts the pending request as unanswered.
    fn end_pending(&mut self, notes: &mut Notes<'_>) {
        let Some(request) = self.pending.take() else { return };
        if let Some(slave) = self.slaves.get_mut(&request.slave).filter(|_| is_counted(request.function)) {
            slave.unanswered(&request, notes);
        }
    }

    fn response(
        &mut self,
        data: &DataTelegram<'_>,
        station: StationType,
        status: Status,
        notes: &mut Notes<'_>,
    ) -> String {
        let Some(request) = self.pending.take_if(|request| request.is_answered_by(data)) else {
            if (Answer { status, du: data.du }).is_refusal() {
                let text =
                    format!("refuses a request of master {} that was not received: {}", data.da, status_text(status));
                notes.about(data.sa, Kind::Refused, text);
            }
            return String::new();
        };
        if is_counted(request.function) {
            return self.finish(&request, Answer { status, du: data.du }, notes);
        }
        if station != StationType::Slave && self.masters.insert(data.sa, station) != Some(station) {
            let state = match station {
                StationType::MasterInRing => "is a master in the token ring",
                StationType::MasterReady => "is a master that is ready for the token ring",
                StationType::MasterNotReady | StationType::Slave => "is a master that is not ready for the token ring",
            };
            notes.about(data.sa, Kind::Presence, state);
        }
        String::new()
    }

    fn finish(&mut self, request: &Request, answer: Answer<'_>, notes: &mut Notes<'_>) -> String {
        let Some(slave) = self.slaves.get_mut(&request.slave) else { return String::new() };
        if let Some(last) = self.last.get_mut(&request.slave) {
            last.is_answered = true;
        }
        slave.answer(request, answer, self.baud, notes)
    }

    /// Adds a note about a Global_Control, which has no answer, if it differs from the last one of the master.
    fn global_control(&mut self, data: &DataTelegram<'_>, notes: &mut Notes<'_>) {
        let (Sap::GlobalControl, Ok(control)) = (Sap::from_octet(data.dsap), GlobalControl::parse(data.du)) else {
            return;
        };
        let control = global_control(control);
        if self.global_controls.get(&data.sa) != Some(&control) {
            let target = if data.da == profivac_wire::BROADCAST { "all".to_owned() } else { data.da.to_string() };
            notes.add(None, Kind::Control, format!("master {} sends Global_Control{control} to {target}", data.sa));
            self.global_controls.insert(data.sa, control);
        }
    }
}

impl LastRequest {
    /// Whether `request` is a repetition. Where other requests may be damaged, an equal frame count bit shows nothing.
    fn is_repeated_by(&self, request: &Request) -> bool {
        self.damage != Damage::Requests && self.request.is_repeated_by(request)
    }

    /// The reason for a repetition.
    const fn reason(&self) -> &'static str {
        match (self.is_answered, self.damage) {
            (true, _) => "its master did not receive the answer",
            (false, Damage::None) => "no answer came",
            (false, Damage::Answer | Damage::Requests) => "the answer is damaged",
        }
    }
}

/// Whether the counters of a slave include a request: all but FDL status, Ident and LSAP status.
const fn is_counted(function: Function) -> bool {
    !matches!(function, Function::FdlStatus | Function::Ident | Function::LsapStatus)
}

/// The text of the note about a damaged piece.
fn damaged(piece: &Piece) -> String {
    let reason = match (&piece.errors[..], Telegram::parse(&piece.octets)) {
        ([], Err(defect)) => defect.to_string(),
        ([], Ok(_)) => "not plausible as a telegram".to_owned(),
        (errors, _) => {
            let places: Vec<String> = errors.iter().map(|index| index.saturating_add(1).to_string()).collect();
            format!("character error in octet {}", places.join(", "))
        }
    };
    let shown = piece.octets.get(..SHOWN).unwrap_or(&piece.octets);
    let more = if shown.len() < piece.octets.len() { " ..." } else { "" };
    format!("damaged, {}: {reason}: {}{more}", octets(piece.octets.len()), Hex(shown))
}
