//! Damaged pieces: the station to which each belongs, and bursts.

use super::{Burst, MAX_REQUEST, Observer};
use crate::event::Change;
use profivac_dp::link::{BitTime, T_SYN_TBIT};
use profivac_explain::cycle::Request;
use profivac_explain::frame::Piece;
use profivac_wire::control::{Control, Function};
use profivac_wire::{DataTelegram, Telegram};
use std::ops::Range;

/// The number of damaged pieces in a second that make a burst. chosen: more than a single disturbance causes.
const BURST: u32 = 10;

/// The number of octets that an inverted start or stop bit adds or hides. chosen.
const LOST_OCTETS: usize = 2;

/// What inverted bits leave of the shortest request, an SD1 of six octets. Fewer octets are a disturbance of the idle line, or a token.
const SHORTEST_REQUEST: usize = 6 - LOST_OCTETS;

/// The octets of an SD2 up to its frame control.
const HEADER: usize = 7;

/// The position of the second SD in an SD2.
const SECOND_SD: usize = 3;

/// Addresses and frame control in an SD2, and in an SD1 or SD3.
const SD2_ADDRESSES: Range<usize> = 4..7;
const ADDRESSES: Range<usize> = 1..4;

/// Start and end delimiters.
const SD1: u8 = 0x10;
const SD2: u8 = 0x68;
const SD3: u8 = 0xA2;
const ED: u8 = 0x16;

impl Observer {
    pub(super) fn damaged(&mut self, piece: &Piece, start: BitTime, end: BitTime) {
        let is_continued = self.damage_end.is_some_and(|before| start - before < T_SYN_TBIT);
        self.damage_end = Some(end);
        self.damage_until = end;
        if is_continued {
            self.continue_damage(piece, start);
            return;
        }
        self.damage_begun = None;
        self.is_last_kept = false;
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
        self.totals.unattributed = self.totals.unattributed.saturating_add(1);
        self.may_be_request(piece, start);
    }

    /// Takes octets that follow damaged ones without a pause.
    fn continue_damage(&mut self, piece: &Piece, start: BitTime) {
        if let Some(mut begun) = self.damage_begun.take() {
            self.disturbances = self.disturbances.saturating_sub(1);
            let before = begun.octets.len();
            begun.errors.extend(piece.errors.iter().map(|position| position.saturating_add(before)));
            begun.octets.extend(piece.octets.iter().take(MAX_REQUEST));
            self.may_be_request(&begun, start);
        } else if self.is_last_kept {
            let room = MAX_REQUEST.saturating_sub(self.damaged_request.len());
            self.damaged_request.extend(piece.octets.iter().take(room));
        }
    }

    /// Takes a damaged piece at the time of a request, if it is long enough for one.
    fn may_be_request(&mut self, piece: &Piece, start: BitTime) {
        self.is_last_kept = false;
        if piece.octets.len() < SHORTEST_REQUEST {
            self.damage_begun = Some(piece.clone());
            if self.open.is_some() || self.damaged_requests > 0 {
                self.disturbances = self.disturbances.saturating_add(1);
            }
            return;
        }
        self.end_pending(start);
        self.damage_epoch = self.damage_epoch.saturating_add(1);
        self.keep_damaged_request(piece);
    }

    /// Keeps a damaged piece that may be a request. Of several in a row that may be the same request, one whose addresses are undamaged is
    /// kept.
    fn keep_damaged_request(&mut self, piece: &Piece) {
        let is_same_length = self.damaged_request.len().abs_diff(piece.octets.len()) <= LOST_OCTETS;
        let is_same = self.damaged_requests > 0 && is_same_length;
        self.damaged_requests = if is_same { self.damaged_requests.saturating_add(1) } else { 1 };
        if is_same && !self.addresses_are_damaged && self.damaged_slave().is_some() {
            return;
        }
        self.damaged_request.clear();
        self.damaged_request.extend(piece.octets.iter().take(MAX_REQUEST));
        self.is_last_kept = true;
        self.header_is_damaged = piece.errors.iter().any(|position| *position < HEADER);
        let is_sd2 = [0, SECOND_SD].iter().any(|position| piece.octets.get(*position) == Some(&SD2));
        let addresses = if is_sd2 { SD2_ADDRESSES } else { ADDRESSES };
        self.addresses_are_damaged = piece.errors.iter().any(|position| addresses.contains(position));
    }

    /// Whether a telegram that begins at `start` can be an answer: masters wait longer.
    pub(super) fn is_answer_time(&self, start: BitTime) -> bool {
        self.slot_tbit.is_none_or(|slot_tbit| start - self.asked_end < slot_tbit)
    }

    /// The damaged pieces were followed by something else than a repetition: their master gave up. They repeat the last request, or
    /// belong to the slave that their addresses name, if both addresses are those of known stations.
    pub(super) fn forget_damaged_request(&mut self) {
        let damaged = std::mem::take(&mut self.damaged_requests);
        if damaged > 0 {
            match self.repeated_slave() {
                Some(slave) => self.count_damaged_requests(slave, damaged, damaged),
                None => {
                    if let Some(slave) = self.damaged_slave() {
                        self.count_damaged_requests(slave, damaged, damaged.saturating_sub(1));
                        self.count(slave, |counts| counts.lost = counts.lost.saturating_add(1));
                    }
                }
            }
        }
        self.damaged_request.clear();
    }

    /// Counts damaged requests to a slave, some of which repeat the one before.
    fn count_damaged_requests(&mut self, slave: u8, damaged: u32, repeated: u32) {
        self.count(slave, |counts| {
            counts.requests = counts.requests.saturating_add(damaged.into());
            counts.repeated = counts.repeated.saturating_add(repeated.into());
            counts.damaged = counts.damaged.saturating_add(damaged.into());
        });
        if let Some(station) = self.station_mut(slave) {
            let before = station.last.as_ref().filter(|_| repeated == damaged).map_or(0, |last| last.repetitions);
            station.longest_sequence = station.longest_sequence.max(repeated.saturating_add(before));
        }
        self.totals.unattributed = self.totals.unattributed.saturating_sub(damaged.into());
        self.attribute_disturbances(slave);
    }

    /// Counts the disturbances that came while a master waited for the answer of this slave.
    pub(super) fn attribute_disturbances(&mut self, slave: u8) {
        let disturbances = u64::from(std::mem::take(&mut self.disturbances));
        if disturbances > 0 {
            self.count(slave, |counts| counts.damaged = counts.damaged.saturating_add(disturbances));
            self.totals.unattributed = self.totals.unattributed.saturating_sub(disturbances);
        }
    }

    /// The slave of the last request, if it is open and the damaged pieces repeat it.
    fn repeated_slave(&self) -> Option<u8> {
        let slave = self.open?;
        (self.open_likeness() > 0 && self.damaged_slave().is_none_or(|named| named == slave)).then_some(slave)
    }

    /// How much the damaged octets are those of the open request.
    fn open_likeness(&self) -> usize {
        let last = self.open.and_then(|slave| self.station(slave)?.last.as_ref());
        let Some(Request { master, slave, function, count, saps: [dsap, ssap], du, .. }) =
            last.map(|last| &last.request)
        else {
            return 0;
        };
        let fc = Control::Request { function: *function, count: *count }.to_octet();
        self.likeness(&DataTelegram { da: *slave, sa: *master, dsap: *dsap, ssap: *ssap, fc, du })
    }

    /// How much the damaged octets are those of this request: the number of equal octets, at least half of them and counted from the
    /// beginning or from the end; 1 if only the length is the same and the header is damaged, because an inverted start or stop bit shifts
    /// all bits behind it; otherwise 0.
    fn likeness(&self, data: &DataTelegram<'_>) -> usize {
        let mut octets = [0; MAX_REQUEST];
        let length = Telegram::Data(*data).emit(&mut octets).unwrap_or_default();
        let (damaged, request) = (&self.damaged_request, octets.get(..length).unwrap_or_default());
        if length == 0 || damaged.len().abs_diff(request.len()) > LOST_OCTETS {
            return 0;
        }
        let front = damaged.iter().zip(request).filter(|(one, other)| one == other).count();
        let back = damaged.iter().rev().zip(request.iter().rev()).filter(|(one, other)| one == other).count();
        let equal = front.max(back);
        if equal.saturating_mul(2) >= request.len() { equal } else { usize::from(self.header_is_damaged) }
    }

    /// The slave that the damaged request names.
    pub(super) fn damaged_slave(&self) -> Option<u8> {
        if self.addresses_are_damaged {
            return None;
        }
        let (da, sa, fc) = match self.damaged_request[..] {
            [SD2, _, _, _, da, sa, fc, ..]
            | [_, _, _, SD2, da, sa, fc, ..]
            | [SD1 | SD3, da, sa, fc, ..]
            | [_, da, sa, fc, _, ED] => (da & 0x7F, sa & 0x7F, fc),
            _ => return None,
        };
        let is_srd =
            matches!(Control::from_octet(fc), Control::Request { function: Function::SrdLow | Function::SrdHigh, .. });
        let is_slave = self.station(da).is_some_and(|station| station.master_at.is_none() && station.last.is_some());
        let is_master = self.station(sa).is_some_and(|station| station.master_at.is_some());
        (is_srd && is_slave && is_master).then_some(da)
    }

    pub(super) fn count_burst(&mut self, start: BitTime) {
        let second_tbit = self.baud.tbit_of_ms(1000);
        if start - self.burst.began >= second_tbit {
            let is_reported = self.burst.is_reported && self.burst.count >= BURST;
            self.burst = Burst { began: start, count: 0, is_reported };
        }
        self.burst.count = self.burst.count.saturating_add(1);
        if self.burst.count == BURST && !self.burst.is_reported {
            self.burst.is_reported = true;
            self.event(None, Change::Burst(BURST));
        }
    }

    /// How many of the last damaged pieces are this request. If they are rather the request before, which has no answer, they repeat that.
    pub(super) fn take_damaged_requests(&mut self, data: &DataTelegram<'_>, start: BitTime) -> u32 {
        if self.damaged_requests == 0 {
            return 0;
        }
        let likeness = self.likeness(data);
        let repeats_open =
            self.repeated_slave().is_some_and(|slave| slave != data.da) && self.open_likeness() >= likeness;
        let names_other = self.damaged_slave().is_some_and(|slave| slave != data.da);
        // Its master waits for an answer before it repeats a request.
        let has_waited = self.slot_tbit.is_some_and(|slot_tbit| start - self.damage_until >= slot_tbit);
        if !repeats_open && !names_other && (likeness > 1 || likeness == 1 && has_waited) {
            self.attribute_disturbances(data.da);
            self.damaged_request.clear();
            return std::mem::take(&mut self.damaged_requests);
        }
        self.forget_damaged_request();
        0
    }
}
