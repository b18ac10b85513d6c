//! The observer: it gets telegrams and damaged pieces with their times and keeps the state of the line in bounded memory.
//!
//! It composes no sentence for a telegram: sentences exist for changes, and texts of values are made when they are shown.

use crate::counts::Counts;
use crate::event::{Event, EventKind, Events};
use crate::gauge::{Declared, GaugeReading};
use crate::histogram::Histogram;
use crate::parameters::{Done, Passed, Path};
use crate::station::{CycleState, Diagnosis, LastRequest, MAX_DIAGNOSES, MISSING_AFTER, Station, StationState};
use profivac_dp::link::{Baud, BitTime, CHARACTER_TBIT, T_SYN_TBIT};
use profivac_explain::cycle::{Answer, Request, status_text};
use profivac_explain::frame::{Piece, PieceKind, TimeSource};
use profivac_explain::names::DeviceTables;
use profivac_explain::slave::diagnosis_reports;
use profivac_sim::describe::Hex;
use profivac_wire::acyclic::Response;
use profivac_wire::control::{Control, FrameCount, Function, StationType, Status};
use profivac_wire::diag::{NO_MASTER, SlaveDiag};
use profivac_wire::prm::SetPrm;
use profivac_wire::{DataTelegram, Sap, Telegram};

/// The addresses of stations: 0 to 126.
const ADDRESSES: usize = 127;

/// The number of damaged pieces in a second that make a burst. free choice: more than a single disturbance causes.
const BURST: u32 = 10;

/// The longest piece that may be a damaged request.
const MAX_REQUEST: usize = 256;

/// The number of octets that an inverted start or stop bit adds or hides. free choice.
const LOST_OCTETS: usize = 2;

/// The octets of an SD2 up to its frame control.
const HEADER: usize = 7;

/// Start delimiters.
const SD1: u8 = 0x10;
const SD2: u8 = 0x68;
const SD3: u8 = 0xA2;

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
    baud: Baud,
    now: BitTime,
    began: Option<BitTime>,
    stations: Vec<Option<Box<Station>>>,
    /// The slave whose request has no answer yet.
    pending: Option<u8>,
    /// Master and address of an FDL status request that has no answer yet.
    pending_status: Option<(u8, u8)>,
    totals: Totals,
    /// Totals of a line are also counted as those of a station, for the last minute.
    damage_counts: crate::counts::CountsOverTime,
    /// The number of damaged pieces that may be requests.
    damage_epoch: u64,
    /// The last damaged piece that may be a request, and how many of this length came one after the other.
    damaged_request: Vec<u8>,
    damaged_requests: u32,
    /// A character of its header was received with an error, so its addresses may be wrong.
    header_is_damaged: bool,
    /// The end of the last damaged piece.
    damage_until: BitTime,
    times: TimeSource,
    /// The end of the last request, and the shortest time in which a master gave up waiting for an answer: an answer begins before it.
    asked_end: BitTime,
    slot_tbit: Option<u64>,
    /// The end of the last piece if it was damaged.
    damage_end: Option<BitTime>,
    burst: Burst,
    /// The station to which each master passed the token last.
    next: [u8; ADDRESSES],
    ring: Vec<u8>,
    rotation: Histogram,
    cycle: Histogram,
    events: Events,
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
            times,
            asked_end: BitTime(0),
            slot_tbit: None,
            damaged_requests: 0,
            header_is_damaged: false,
            damage_until: BitTime(0),
            baud,
            now: BitTime(0),
            began: None,
            stations: vec![None; ADDRESSES],
            pending: None,
            pending_status: None,
            totals: Totals::default(),
            damage_counts: crate::counts::CountsOverTime::new(baud),
            damage_epoch: 0,
            damaged_request: Vec::with_capacity(MAX_REQUEST),
            damage_end: None,
            burst: Burst::default(),
            next: [NO_STATION; ADDRESSES],
            ring: Vec::new(),
            rotation: Histogram::default(),
            cycle: Histogram::default(),
            events: Events::default(),
        }
    }

    /// The baud rate.
    #[must_use]
    pub const fn baud(&self) -> Baud {
        self.baud
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
        let (slot, index) = passed.place;
        let value = if passed.octets.is_empty() { String::new() } else { tables.value(slot, index, &passed.octets) };
        (tables.name(slot, index), value)
    }

    /// Adds a piece of the traffic.
    pub fn piece(&mut self, piece: &Piece) {
        let start = piece.start.unwrap_or(self.now);
        let length_tbit = (piece.octets.len() as u64).saturating_mul(CHARACTER_TBIT);
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

    fn station_mut(&mut self, address: u8) -> Option<&mut Station> {
        let baud = self.baud;
        let place = self.stations.get_mut(usize::from(address))?;
        Some(place.get_or_insert_with(|| Box::new(Station::new(baud))))
    }

    fn count(&mut self, address: u8, change: impl Fn(&mut Counts)) {
        let now = self.now;
        if let Some(station) = self.station_mut(address) {
            station.counts.count(now, change);
        }
    }

    fn event(&mut self, station: Option<u8>, kind: EventKind, text: String) {
        self.events.add(self.now, station, kind, text);
    }

    fn telegram(&mut self, telegram: &Telegram<'_>, start: BitTime) {
        match telegram {
            Telegram::ShortAck => self.short_ack(start),
            Telegram::Token { da, sa } => {
                self.end_pending(start);
                self.forget_damaged_request();
                self.token(*sa, *da, start);
            }
            Telegram::Data(frame) => match frame.control() {
                Control::Request { function, count } => self.request(frame, function, count, start),
                Control::Response { station, status } => self.response(frame, station, status, start),
            },
        }
    }

    // --- damage ---

    fn damaged(&mut self, piece: &Piece, start: BitTime, end: BitTime) {
        let is_continued = self.damage_end.is_some_and(|before| start - before < T_SYN_TBIT);
        self.damage_end = Some(end);
        self.damage_until = end;
        if is_continued {
            let room = MAX_REQUEST.saturating_sub(self.damaged_request.len());
            if self.damaged_requests > 0 {
                self.damaged_request.extend(piece.octets.iter().take(room));
            }
            return;
        }
        self.totals.damaged = self.totals.damaged.saturating_add(1);
        self.damage_counts.count(self.now, |counts| counts.damaged = counts.damaged.saturating_add(1));
        self.count_burst(start);
        if self.is_answer_time(start) {
            // Only the station that was asked may send now.
            if let Some(slave) = self.pending.take() {
                self.count(slave, |counts| counts.damaged = counts.damaged.saturating_add(1));
                return;
            }
            if self.pending_status.take().is_some() {
                self.totals.unattributed = self.totals.unattributed.saturating_add(1);
                return;
            }
        }
        self.end_pending(start);
        self.damage_epoch = self.damage_epoch.saturating_add(1);
        let is_same_length = self.damaged_request.len().abs_diff(piece.octets.len()) <= LOST_OCTETS;
        self.damaged_requests = if is_same_length { self.damaged_requests.saturating_add(1) } else { 1 };
        self.damaged_request.clear();
        self.damaged_request.extend(piece.octets.iter().take(MAX_REQUEST));
        self.header_is_damaged = piece.errors.iter().any(|place| *place < HEADER);
        self.totals.unattributed = self.totals.unattributed.saturating_add(1);
    }

    /// Whether a telegram that begins at `start` can be an answer: masters wait longer.
    fn is_answer_time(&self, start: BitTime) -> bool {
        self.slot_tbit.is_none_or(|slot_tbit| start - self.asked_end < slot_tbit)
    }

    /// The damaged pieces were followed by something else than a repetition: their master gave up. They belong to the slave that their
    /// addresses name, if both addresses are those of known stations.
    fn forget_damaged_request(&mut self) {
        let damaged = std::mem::take(&mut self.damaged_requests);
        if damaged > 0
            && let Some(slave) = self.damaged_slave()
        {
            let repeated = damaged.saturating_sub(1);
            self.count(slave, |counts| {
                counts.requests = counts.requests.saturating_add(damaged.into());
                counts.repeated = counts.repeated.saturating_add(repeated.into());
                counts.damaged = counts.damaged.saturating_add(damaged.into());
                counts.lost = counts.lost.saturating_add(1);
            });
            if let Some(station) = self.station_mut(slave) {
                station.longest_sequence = station.longest_sequence.max(repeated);
            }
            self.totals.unattributed = self.totals.unattributed.saturating_sub(damaged.into());
        }
        self.damaged_request.clear();
    }

    /// The slave that the damaged request names.
    fn damaged_slave(&self) -> Option<u8> {
        if self.header_is_damaged {
            return None;
        }
        let (da, sa, fc) = match self.damaged_request[..] {
            [SD2, _, _, SD2, da, sa, fc, ..] | [SD1 | SD3, da, sa, fc, ..] => (da & 0x7F, sa & 0x7F, fc),
            _ => return None,
        };
        let is_srd =
            matches!(Control::from_octet(fc), Control::Request { function: Function::SrdLow | Function::SrdHigh, .. });
        let is_slave = self.station(da).is_some_and(|station| station.master_at.is_none() && station.last.is_some());
        let is_master = self.station(sa).is_some_and(|station| station.master_at.is_some());
        (is_srd && is_slave && is_master).then_some(da)
    }

    fn count_burst(&mut self, start: BitTime) {
        let second_tbit = self.baud.tbit_of_ms(1000);
        if start - self.burst.began >= second_tbit {
            let is_reported = self.burst.is_reported && self.burst.count >= BURST;
            self.burst = Burst { began: start, count: 0, is_reported };
        }
        self.burst.count = self.burst.count.saturating_add(1);
        if self.burst.count == BURST && !self.burst.is_reported {
            self.burst.is_reported = true;
            self.event(None, EventKind::Burst, format!("{BURST} damaged telegrams within a second"));
        }
    }

    /// How many of the last damaged pieces are this request.
    fn take_damaged_requests(&mut self, frame: &DataTelegram<'_>, start: BitTime) -> u32 {
        if self.damaged_requests == 0 {
            return 0;
        }
        let mut octets = [0; MAX_REQUEST];
        let length = Telegram::Data(*frame).emit(&mut octets).unwrap_or_default();
        let request = octets.get(..length).unwrap_or_default();
        let names_other = self.damaged_slave().is_some_and(|slave| slave != frame.da);
        // An inverted start or stop bit shifts all bits behind it, so that no octet is the same; but its master waits for an answer.
        let has_waited = self.slot_tbit.is_some_and(|slot_tbit| start - self.damage_until >= slot_tbit);
        let is_shifted =
            self.header_is_damaged && has_waited && self.damaged_request.len().abs_diff(request.len()) <= LOST_OCTETS;
        let is_request = length > 0 && !names_other && (is_shifted || is_alike(&self.damaged_request, request));
        if is_request {
            self.damaged_request.clear();
            return std::mem::take(&mut self.damaged_requests);
        }
        self.forget_damaged_request();
        0
    }

    // --- requests ---

    fn request(&mut self, frame: &DataTelegram<'_>, function: Function, count: FrameCount, start: BitTime) {
        self.end_pending(start);
        self.master_heard(frame.sa, start);
        match function {
            Function::FdlStatus => {
                self.forget_damaged_request();
                self.pending_status = Some((frame.sa, frame.da));
                return;
            }
            Function::Ident | Function::LsapStatus | Function::SdnLow | Function::SdnHigh => {
                self.forget_damaged_request();
                return;
            }
            _ => {}
        }
        let damaged = self.take_damaged_requests(frame, start);
        let was_damaged = damaged > 0;
        let (epoch, slave, number) = (self.damage_epoch, frame.da, self.totals.telegrams);
        let sap = Sap::from_octet(frame.dsap);
        let Some(station) = self.station_mut(slave) else { return };
        let (before, is_lost, new_repetitions) = match station.last.take() {
            Some(mut last) => {
                let is_next = last.number.saturating_add(1) == number;
                let is_equal =
                    is_same(&last.request, frame, function, count) && (is_next || count != FrameCount::First);
                let is_repetition = is_equal && (last.damage_epoch == epoch || was_damaged && !last.is_answered);
                let is_lost = !is_repetition && !last.is_answered;
                let repetitions =
                    if is_repetition { last.repetitions.saturating_add(1).saturating_add(damaged) } else { damaged };
                store(&mut last.request, frame, sap, function, count, start);
                last.repetitions = repetitions;
                (last, is_lost, u32::from(is_repetition).saturating_add(damaged))
            }
            None => {
                let saps = [frame.dsap, frame.ssap];
                let request = Request {
                    master: frame.sa,
                    slave,
                    sap,
                    function,
                    count,
                    saps,
                    du: frame.du.to_vec(),
                    at: Some(start),
                };
                let repetitions = damaged;
                (LastRequest { request, number, damage_epoch: epoch, is_answered: false, repetitions }, false, damaged)
            }
        };
        let repetitions = before.repetitions;
        let is_first = repetitions == 0;
        station.longest_sequence = station.longest_sequence.max(repetitions);
        station.asked_at = Some(start);
        if matches!(sap, Sap::Default | Sap::SetPrm | Sap::ChkCfg) {
            station.wanted_at = Some(start);
        }
        station.last = Some(LastRequest { number, damage_epoch: epoch, is_answered: false, ..before });
        self.count(slave, |counts| {
            counts.requests = counts.requests.saturating_add(1).saturating_add(damaged.into());
            counts.repeated = counts.repeated.saturating_add(new_repetitions.into());
            counts.damaged = counts.damaged.saturating_add(damaged.into());
            counts.lost = counts.lost.saturating_add(u64::from(is_lost));
        });
        self.totals.unattributed = self.totals.unattributed.saturating_sub(damaged.into());
        self.pending = Some(slave);
        self.note_contents(slave, frame, sap, is_first, start);
    }

    /// Records the contents of a request.
    fn note_contents(&mut self, slave: u8, frame: &DataTelegram<'_>, sap: Sap, is_first: bool, start: BitTime) {
        if sap == Sap::Default && is_first {
            self.cycle_request(frame.sa, slave, start);
        }
        let Some(station) = self.station_mut(slave) else { return };
        match sap {
            Sap::Default => {
                if has_channel(station)
                    && let Some(telegram) = station.knowledge.layout().and_then(|configuration| configuration.outputs)
                {
                    station.parameters.outputs(telegram, frame.sa, frame.du);
                }
            }
            Sap::Ms1 | Sap::Ms2(_) => {
                if let Some(last) = &station.last {
                    station.parameters.request(&last.request);
                }
            }
            _ => {}
        }
    }

    /// Measures the interval of the slave and the cycle of the master.
    fn cycle_request(&mut self, master: u8, slave: u8, start: BitTime) {
        if let Some(station) = self.station_mut(slave)
            && let Some(before) = station.exchange_requested_at.replace(start)
        {
            station.interval.add(start - before);
        }
        let bit = 1_u128.checked_shl(slave.into()).unwrap_or_default();
        let Some(master) = self.station_mut(master) else { return };
        if master.cycle_state.served & bit == 0 {
            if master.cycle_state.served == 0 {
                master.cycle_state.began = start;
            }
            master.cycle_state.served |= bit;
            return;
        }
        let cycle_tbit = start - master.cycle_state.began;
        master.cycle_state = CycleState { served: bit, began: start };
        master.cycle.add(cycle_tbit);
        self.cycle.add(cycle_tbit);
    }

    /// Counts the pending request as unanswered.
    fn end_pending(&mut self, start: BitTime) {
        if self.times == TimeSource::Exact && (self.pending.is_some() || self.pending_status.is_some()) {
            let waited_tbit = start - self.asked_end;
            self.slot_tbit = Some(self.slot_tbit.map_or(waited_tbit, |slot_tbit| slot_tbit.min(waited_tbit)));
        }
        if let Some((_, address)) = self.pending_status.take() {
            // An unanswered FDL status shows something only about a station that has answered before.
            self.no_answer(address, false);
        }
        let Some(slave) = self.pending.take() else { return };
        self.count(slave, |counts| counts.unanswered = counts.unanswered.saturating_add(1));
        self.no_answer(slave, true);
    }

    fn no_answer(&mut self, address: u8, is_request: bool) {
        let now = self.now;
        let is_known = self.station(address).is_some_and(|station| station.heard_at.is_some());
        if !is_request && !is_known {
            return;
        }
        let Some(station) = self.station_mut(address) else { return };
        station.asked_at = Some(now);
        station.unanswered_in_a_row = station.unanswered_in_a_row.saturating_add(1);
        if station.unanswered_in_a_row == MISSING_AFTER && !station.is_reported_lost && is_known {
            station.is_reported_lost = true;
            station.is_exchanging = false;
            self.event(Some(address), EventKind::Lost, format!("station {address} does not answer any more"));
        }
    }

    // --- answers ---

    fn short_ack(&mut self, start: BitTime) {
        if let Some(slave) = self.pending.take() {
            self.finish(slave, Answer { status: Status::Ok, du: &[] }, start);
        }
    }

    fn response(&mut self, frame: &DataTelegram<'_>, station: StationType, status: Status, start: BitTime) {
        self.forget_damaged_request();
        if station != StationType::Slave {
            self.master_heard(frame.sa, start);
        }
        if self.pending_status == Some((frame.da, frame.sa)) {
            self.pending_status = None;
            self.heard(frame.sa, start);
            return;
        }
        let is_answer = self
            .pending
            .and_then(|slave| self.station(slave)?.last.as_ref())
            .is_some_and(|last| last.request.is_answered_by(frame));
        if is_answer && let Some(slave) = self.pending.take() {
            self.finish(slave, Answer { status, du: frame.du }, start);
        } else if self.station(frame.sa).is_some() {
            // The request was not received: the next one may look like a repetition.
            self.damage_epoch = self.damage_epoch.saturating_add(1);
            self.heard(frame.sa, start);
        }
    }

    /// Records that a station sent something.
    fn heard(&mut self, address: u8, start: BitTime) {
        let Some(station) = self.station_mut(address) else { return };
        let is_new = station.heard_at.replace(start).is_none();
        let unanswered = std::mem::take(&mut station.unanswered_in_a_row);
        let was_lost = std::mem::take(&mut station.is_reported_lost);
        if was_lost {
            self.event(
                Some(address),
                EventKind::Returned,
                format!("station {address} answers again after {unanswered} unanswered requests"),
            );
        } else if is_new {
            self.event(Some(address), EventKind::Returned, format!("station {address} answers"));
        }
    }

    fn finish(&mut self, slave: u8, answer: Answer<'_>, start: BitTime) {
        self.heard(slave, start);
        let Some(station) = self.station_mut(slave) else { return };
        let Some(mut last) = station.last.take() else { return };
        last.is_answered = true;
        let is_refusal = answer.is_refusal()
            || matches!(answer.status, Status::DataLowNotTaken | Status::DataHighNotTaken)
            || (is_acyclic(last.request.sap) && matches!(Response::parse(answer.du), Ok(Response::Negative(_))));
        if is_refusal {
            self.count(slave, |counts| counts.refused = counts.refused.saturating_add(1));
        }
        match last.request.sap {
            Sap::Default => self.exchanged(slave, &last.request, answer, start),
            Sap::SlaveDiag => self.diagnosed(slave, answer.du),
            Sap::SetPrm if answer.is_ack() => self.parameterised(slave, &last.request),
            Sap::ChkCfg if answer.is_ack() => self.configured(slave, last.request.master, &last.request.du),
            Sap::GetCfg if !answer.du.is_empty() => {
                if let Some(station) = self.station_mut(slave) {
                    station.knowledge.configure(answer.du);
                }
            }
            sap if is_acyclic(sap) => self.record_answered(slave, &last.request, answer.du, start),
            _ => {}
        }
        if let Some(station) = self.station_mut(slave) {
            station.last = Some(last);
        }
    }

    fn exchanged(&mut self, slave: u8, request: &Request, answer: Answer<'_>, start: BitTime) {
        let is_valid = matches!(answer.status, Status::Ok | Status::DataLow | Status::DataHigh | Status::NoReply);
        let Some(station) = self.station_mut(slave) else { return };
        station.is_exchanging = is_valid;
        if !is_valid {
            if !std::mem::replace(&mut station.refuses_exchange, true) {
                let text = format!("station {slave} refuses to exchange data: {}", status_text(answer.status));
                self.event(Some(slave), EventKind::Refused, text);
            }
            return;
        }
        station.refuses_exchange = false;
        station.knowledge.exchange(request.du.len(), answer.du, start);
        let layout = if has_channel(station) { station.knowledge.layout() } else { None };
        let inputs = layout.and_then(|configuration| configuration.inputs);
        let tables = station.tables;
        let passed =
            inputs.and_then(|telegram| station.parameters.inputs(telegram, &tables, answer.du, start)).cloned();
        self.count(slave, |counts| counts.exchanges = counts.exchanges.saturating_add(1));
        if let Some(passed) = passed {
            self.learn(slave, &passed);
        }
    }

    fn diagnosed(&mut self, slave: u8, du: &[u8]) {
        self.count(slave, |counts| counts.diagnoses = counts.diagnoses.saturating_add(1));
        let now = self.now;
        let Some(station) = self.station_mut(slave) else { return };
        if station.diagnosis_octets == du {
            return;
        }
        let Ok(diag) = SlaveDiag::parse(du) else { return };
        station.diagnosis_octets.clear();
        station.diagnosis_octets.extend_from_slice(du);
        station.status = Some(diag.status);
        let owner = station.owner.replace(diag.master_add);
        identify(station, diag.ident);
        let reports = diagnosis_reports(&diag);
        let before = station.diagnoses.back();
        let is_first = before.is_none();
        let has_changed = before.is_none_or(|before| before.reports != reports);
        let is_report = has_changed && !(is_first && reports.is_empty());
        if has_changed {
            if station.diagnoses.len() >= MAX_DIAGNOSES {
                station.diagnoses.pop_front();
            }
            station.diagnoses.push_back(Diagnosis { at: now, reports: reports.clone() });
        }
        if owner.is_some_and(|owner| owner != diag.master_add) {
            let text = match diag.master_add {
                NO_MASTER => format!("station {slave} has no owner any more"),
                owner => format!("station {slave} belongs to master {owner}"),
            };
            self.event(Some(slave), EventKind::Owner, text);
        }
        if is_report {
            let contents = if reports.is_empty() { "nothing".to_owned() } else { reports.join(", ") };
            self.event(
                Some(slave),
                EventKind::Diagnosis,
                format!("the diagnosis of station {slave} reports {contents}"),
            );
        }
    }

    fn parameterised(&mut self, slave: u8, request: &Request) {
        let Ok(prm) = SetPrm::parse(&request.du) else { return };
        let Some(station) = self.station_mut(slave) else { return };
        identify(station, prm.ident);
        station.knowledge.parameterise(prm.user);
        station.tables.unit = station
            .knowledge
            .model()
            .and_then(|(model, _)| model.user_prm(prm.user))
            .and_then(|known| station.tables.model?.unit(known.unit_code()))
            .or(station.tables.unit);
        let is_changed = !station.set_prm.is_empty() && station.set_prm != request.du;
        let is_first = station.set_prm.is_empty();
        station.set_prm.clone_from(&request.du);
        let text = match (is_first, is_changed) {
            (true, _) => format!("master {} sets parameters of station {slave}", request.master),
            (_, true) => format!(
                "master {} sets other parameters of station {slave} than before: {}",
                request.master,
                Hex(&request.du)
            ),
            _ => format!("master {} sets the same parameters of station {slave} again", request.master),
        };
        self.event(Some(slave), EventKind::Configuration, text);
    }

    fn configured(&mut self, slave: u8, master: u8, du: &[u8]) {
        let Some(station) = self.station_mut(slave) else { return };
        let is_first = station.knowledge.heard_configuration().is_empty();
        let is_new = station.knowledge.configure(du);
        station.tables.model = station.knowledge.model().map(|(model, _)| model).or(station.tables.model);
        if is_new {
            let other = if is_first { "the" } else { "another" };
            let text = format!("master {master} asks station {slave} for {other} configuration {}", Hex(du));
            self.event(Some(slave), EventKind::Configuration, text);
        }
    }

    fn record_answered(&mut self, slave: u8, request: &Request, du: &[u8], start: BitTime) {
        let Some(station) = self.station_mut(slave) else { return };
        let passed = station.parameters.answer(request, du, start).cloned();
        if let Some(passed) = passed {
            self.learn(slave, &passed);
        }
    }

    /// Takes a value that changes the meaning of others, and reports a write.
    fn learn(&mut self, slave: u8, passed: &Passed) {
        let Some(station) = self.station_mut(slave) else { return };
        let (slot, index) = passed.place;
        if passed.done != Done::Refused {
            let before = station.tables.unit.map(|unit| unit.code);
            station.tables.learn(slot, index, &passed.octets);
            if let Some(unit) = station.tables.unit.filter(|unit| Some(unit.code) != before) {
                station.knowledge.learn_unit(unit.code);
            }
        }
        if passed.done == Done::Written {
            let (name, value) = self.parameter_text(slave, passed);
            let way = path_text(passed.path);
            let text = format!("master {} writes {name} = {value} of station {slave} ({way})", passed.requester);
            self.event(Some(slave), EventKind::Parameter, text);
        }
    }

    // --- masters ---

    fn master_heard(&mut self, address: u8, start: BitTime) {
        if let Some(station) = self.station_mut(address) {
            station.master_at = Some(start);
            station.heard_at = Some(start);
            station.unanswered_in_a_row = 0;
        }
    }

    fn token(&mut self, from: u8, to: u8, start: BitTime) {
        self.totals.tokens = self.totals.tokens.saturating_add(1);
        self.master_heard(from, start);
        if let Some(station) = self.station_mut(to)
            && let Some(before) = station.token_at.replace(start)
        {
            let rotation_tbit = start - before;
            station.rotation.add(rotation_tbit);
            self.rotation.add(rotation_tbit);
        }
        let Some(next) = self.next.get_mut(usize::from(from)) else { return };
        if std::mem::replace(next, to) != to || !self.ring.contains(&from) {
            self.follow_ring(from);
        }
    }

    /// Reports the ring if it closes and has changed.
    fn follow_ring(&mut self, start: u8) {
        let mut ring = vec![start];
        let mut here = self.next_of(start);
        while here != start {
            if here == NO_STATION || ring.contains(&here) {
                return;
            }
            ring.push(here);
            here = self.next_of(here);
        }
        let lowest = ring.iter().enumerate().min_by_key(|(_, station)| **station).map_or(0, |(place, _)| place);
        ring.rotate_left(lowest);
        if ring == self.ring {
            return;
        }
        let text = match ring[..] {
            [alone] => format!("master {alone} is alone in the token ring"),
            _ => format!("token ring: {}", ring.iter().map(ToString::to_string).collect::<Vec<_>>().join(" -> ")),
        };
        self.event(None, EventKind::Ring, text);
        for address in 0..ADDRESSES {
            if !ring.iter().any(|station| usize::from(*station) == address)
                && let Some(next) = self.next.get_mut(address)
            {
                *next = NO_STATION;
            }
        }
        self.ring = ring;
    }

    fn next_of(&self, address: u8) -> u8 {
        self.next.get(usize::from(address)).copied().unwrap_or(NO_STATION)
    }

    /// The events with a higher number.
    pub fn events_since(&self, number: u64) -> impl Iterator<Item = &Event> {
        self.events.since(number)
    }
}

/// Whether damaged octets are this telegram: their lengths are nearly the same, and at least half of the octets are, counted from the
/// beginning or from the end.
fn is_alike(damaged: &[u8], telegram: &[u8]) -> bool {
    let front = damaged.iter().zip(telegram).filter(|(one, other)| one == other).count();
    let back = damaged.iter().rev().zip(telegram.iter().rev()).filter(|(one, other)| one == other).count();
    let is_long = damaged.len().abs_diff(telegram.len()) <= LOST_OCTETS;
    is_long && front.max(back).saturating_mul(2) >= telegram.len()
}

/// The words for the way of a parameter.
#[must_use]
pub const fn path_text(path: Path) -> &'static str {
    match path {
        Path::ParameterChannel => "parameter channel",
        Path::Ms1 => "MS1",
        Path::Ms2 => "MS2",
    }
}

/// Takes Ident_Number, and the tables of the device.
fn identify(station: &mut Station, ident: u16) {
    if station.knowledge.ident() == Some(ident) {
        return;
    }
    station.knowledge.identify(ident);
    let model = station.knowledge.model().map(|(model, _)| model);
    if model.map(|model| model.name) != station.tables.model.map(|model| model.name) {
        station.tables = DeviceTables { model, ..DeviceTables::default() };
    }
}

/// Whether the device has a parameter channel at all: all others need no look into their images.
fn has_channel(station: &Station) -> bool {
    station.tables.model.is_some_and(|model| !model.channel_rules.tasks.is_empty())
}

const fn is_acyclic(sap: Sap) -> bool {
    matches!(sap, Sap::Ms1 | Sap::Ms2(_) | Sap::ResourceManager | Sap::Alarm)
}

/// Whether `frame` is an equal request with an equal, counted frame count bit.
fn is_same(request: &Request, frame: &DataTelegram<'_>, function: Function, count: FrameCount) -> bool {
    matches!(count, FrameCount::Counted(_) | FrameCount::First)
        && (request.count, request.function, request.master) == (count, function, frame.sa)
        && request.saps == [frame.dsap, frame.ssap]
        && request.du == frame.du
}

/// Overwrites a request; its buffer stays.
fn store(
    request: &mut Request,
    frame: &DataTelegram<'_>,
    sap: Sap,
    function: Function,
    count: FrameCount,
    start: BitTime,
) {
    request.master = frame.sa;
    request.slave = frame.da;
    (request.sap, request.function, request.count) = (sap, function, count);
    request.saps = [frame.dsap, frame.ssap];
    request.du.clear();
    request.du.extend_from_slice(frame.du);
    request.at = Some(start);
}
