//! Makes pieces of the divided octets.

use super::division::Candidate;
use super::{Framer, MAX_DAMAGED, Piece, PieceKind, TimeSource};
use profivac_dp::link::CHARACTER_TBIT;

/// The longest row of SC and tokens that wait for the octet behind them. chosen.
const MAX_SHORT: usize = 64;

impl Framer {
    /// Adds the octets up to `to`, which are damaged.
    pub(super) fn add_damaged(&mut self, to: usize, out: &mut Vec<Piece>) {
        if self.is_boundary(self.divided) {
            self.emit_short(PieceKind::Valid, out);
        } else {
            self.emit_short(PieceKind::Doubtful, out);
        }
        (self.divided, self.is_doubtful) = (to, true);
        while self.divided.saturating_sub(self.emitted) >= MAX_DAMAGED {
            self.emit(self.emitted.saturating_add(MAX_DAMAGED), PieceKind::Damaged, out);
        }
    }

    pub(super) fn add_telegram(&mut self, telegram: Candidate, out: &mut Vec<Piece>) {
        let is_boundary = self.is_boundary(telegram.from);
        if is_boundary || telegram.is_checked {
            self.emit_short(PieceKind::Valid, out);
        }
        if self.short.is_empty() {
            self.emit(telegram.from, PieceKind::Damaged, out);
        }
        self.is_doubtful &= !is_boundary && !telegram.is_checked;
        self.divided = telegram.to;
        if telegram.is_checked {
            return self.emit(telegram.to, PieceKind::Valid, out);
        }
        if self.is_doubtful {
            return self.emit(telegram.to, PieceKind::Doubtful, out);
        }
        self.short.push_back(telegram);
        if self.is_boundary(telegram.to) {
            self.emit_short(PieceKind::Valid, out);
        } else if self.short.len() > MAX_SHORT
            && let Some(first) = self.short.pop_front()
        {
            self.emit(first.to, PieceKind::Valid, out);
        }
    }

    /// Appends the SC and tokens that wait to `out`.
    fn emit_short(&mut self, kind: PieceKind, out: &mut Vec<Piece>) {
        while let Some(telegram) = self.short.pop_front() {
            self.emit(telegram.to, kind, out);
        }
    }

    /// Appends the divided octets that wait to `out`.
    pub(super) fn emit_waiting(&mut self, out: &mut Vec<Piece>) {
        self.emit_short(PieceKind::Valid, out);
        self.emit(self.divided, PieceKind::Damaged, out);
    }

    /// Appends the octets up to `to` as one piece to `out`, if there are any.
    fn emit(&mut self, to: usize, kind: PieceKind, out: &mut Vec<Piece>) {
        let from = self.emitted;
        if to <= from {
            return;
        }
        let octets = self.octets.get(from..to).unwrap_or_default().to_vec();
        let mut errors = Vec::new();
        while let Some(error) = self.errors.pop_front_if(|error| *error < to) {
            errors.push(error.saturating_sub(from));
        }
        while self.starts.get(1).is_some_and(|(at, _)| *at <= from) {
            self.starts.pop_front();
        }
        let start = self.starts.front().and_then(|(at, start)| {
            let before = from.saturating_sub(*at);
            start.map(|start| start + passed_tbit(self.times, before))
        });
        out.push(Piece { start, octets, errors, kind });
        self.emitted = to;
    }

    /// Removes the octets that are in pieces, and moves all positions.
    pub(super) fn drop_emitted(&mut self) {
        let gone = std::mem::take(&mut self.emitted);
        if gone == 0 {
            return;
        }
        self.octets.drain(..gone);
        self.errors.iter_mut().for_each(|at| *at = at.saturating_sub(gone));
        while self.boundaries.pop_front_if(|at| *at < gone).is_some() {}
        self.boundaries.iter_mut().for_each(|at| *at = at.saturating_sub(gone));
        while self.starts.get(1).is_some_and(|(at, _)| *at <= gone) {
            self.starts.pop_front();
        }
        for (at, start) in &mut self.starts {
            // The rest of a chunk becomes a chunk with a later start.
            let passed = passed_tbit(self.times, gone.saturating_sub(*at));
            *start = start.map(|start| start + passed);
            *at = at.saturating_sub(gone);
        }
        self.divided = self.divided.saturating_sub(gone);
        self.examined = self.examined.saturating_sub(gone);
        for candidate in self.open.iter_mut().chain(&mut self.short) {
            candidate.shift(gone);
        }
        for division in &mut self.divisions {
            if let Some(last) = &mut division.last {
                last.shift(gone);
            }
        }
    }
}

/// Time from the start of a chunk to its octet number `count`.
const fn passed_tbit(times: TimeSource, count: usize) -> u64 {
    match times {
        TimeSource::Exact => (count as u64).saturating_mul(CHARACTER_TBIT),
        TimeSource::Platform => 0,
    }
}
