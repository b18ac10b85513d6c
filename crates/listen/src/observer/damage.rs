//! Damaged pieces: the station to which each belongs, and bursts.

use super::{Burst, MAX_REQUEST, Observer};
use crate::event::EventKind;
use profivac_dp::link::{BitTime, T_SYN_TBIT};
use profivac_explain::frame::Piece;
use profivac_wire::control::{Control, Function};
use profivac_wire::{DataTelegram, Telegram};

/// The number of damaged pieces in a second that make a burst. free choice: more than a single disturbance causes.
const BURST: u32 = 10;

/// The number of octets that an inverted start or stop bit adds or hides. free choice.
const LOST_OCTETS: usize = 2;

/// The octets of an SD2 up to its frame control.
const HEADER: usize = 7;

/// Start delimiters.
const SD1: u8 = 0x10;
const SD2: u8 = 0x68;
const SD3: u8 = 0xA2;

impl Observer {
    pub(super) fn damaged(&mut self, piece: &Piece, start: BitTime, end: BitTime) {
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
        self.header_is_damaged = piece.errors.iter().any(|position| *position < HEADER);
        self.totals.unattributed = self.totals.unattributed.saturating_add(1);
    }

    /// Whether a telegram that begins at `start` can be an answer: masters wait longer.
    pub(super) fn is_answer_time(&self, start: BitTime) -> bool {
        self.slot_tbit.is_none_or(|slot_tbit| start - self.asked_end < slot_tbit)
    }

    /// The damaged pieces were followed by something else than a repetition: their master gave up. They belong to the slave that their
    /// addresses name, if both addresses are those of known stations.
    pub(super) fn forget_damaged_request(&mut self) {
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
    pub(super) fn damaged_slave(&self) -> Option<u8> {
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

    pub(super) fn count_burst(&mut self, start: BitTime) {
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
    pub(super) fn take_damaged_requests(&mut self, frame: &DataTelegram<'_>, start: BitTime) -> u32 {
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
}

/// Whether damaged octets are this telegram: their lengths are nearly the same, and at least half of the octets are, counted from the
/// beginning or from the end.
fn is_alike(damaged: &[u8], telegram: &[u8]) -> bool {
    let front = damaged.iter().zip(telegram).filter(|(one, other)| one == other).count();
    let back = damaged.iter().rev().zip(telegram.iter().rev()).filter(|(one, other)| one == other).count();
    let is_long = damaged.len().abs_diff(telegram.len()) <= LOST_OCTETS;
    is_long && front.max(back).saturating_mul(2) >= telegram.len()
}
