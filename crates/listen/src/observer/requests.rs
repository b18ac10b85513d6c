//! Requests, their repetitions, and requests without an answer.

use super::{ADDRESSES, Observer};
use crate::event::Change;
use crate::station::{LastRequest, MISSING_AFTER};
use profivac_dp::link::BitTime;
use profivac_explain::cycle::Request;
use profivac_explain::frame::TimeSource;
use profivac_wire::control::{FrameCount, Function};
use profivac_wire::{DataTelegram, Sap};

/// A request that a slave answers, as its master sent it.
#[derive(Clone, Copy)]
pub(super) struct Sent<'a> {
    pub(super) data: &'a DataTelegram<'a>,
    pub(super) sap: Sap,
    function: Function,
    count: FrameCount,
    pub(super) start: BitTime,
}

impl Observer {
    pub(super) fn request(&mut self, data: &DataTelegram<'_>, function: Function, count: FrameCount, start: BitTime) {
        self.end_pending(start);
        self.master_heard(data.sa, start);
        match function {
            Function::FdlStatus => {
                self.end_cycle();
                self.pending_status = Some((data.sa, data.da));
            }
            Function::Ident | Function::LsapStatus | Function::SdnLow | Function::SdnHigh => self.end_cycle(),
            Function::SdaLow | Function::SdaHigh | Function::SrdLow | Function::SrdHigh | Function::Other(_) => {
                let sap = Sap::from_octet(data.dsap);
                self.service_request(&Sent { data, sap, function, count, start });
            }
        }
    }

    /// Follows a request that its slave answers.
    fn service_request(&mut self, sent: &Sent<'_>) {
        if usize::from(sent.data.da) >= ADDRESSES {
            // No station answers a request to all of them.
            self.end_cycle();
            return;
        }
        let damaged = self.take_damaged_requests(sent.data, sent.start);
        let before = self.repeated_before(sent, damaged);
        if before.is_none() || self.open != Some(sent.data.da) {
            self.give_up();
        }
        self.attribute_disturbances(sent.data.da);
        let repetitions = before.unwrap_or_default().saturating_add(damaged);
        self.keep_request(sent, repetitions);
        self.count_request(sent.data.da, before.is_some(), damaged);
        (self.pending, self.open) = (Some(sent.data.da), Some(sent.data.da));
        self.note_contents(sent, repetitions == 0);
    }

    /// How often the request was received valid before, with `damaged` damaged ones between the last of them and this one. `None` if it is
    /// another one than the last to its slave.
    fn repeated_before(&self, sent: &Sent<'_>, damaged: u32) -> Option<u32> {
        let last = self.station(sent.data.da).and_then(|station| station.last.as_ref())?;
        let is_next = last.number.saturating_add(1) == self.totals.telegrams;
        let is_equal = sent.is_same(&last.request) && (is_next || sent.count != FrameCount::First);
        let is_certain = last.damage_epoch == self.damage_epoch || damaged > 0 && !last.is_answered;
        (is_equal && is_certain).then_some(last.repetitions.saturating_add(1))
    }

    /// The master sends something else than a repetition of its last request.
    pub(super) fn end_cycle(&mut self) {
        self.forget_damaged_request();
        self.give_up();
    }

    /// The last request had no valid answer, and its master gave it up.
    pub(super) fn give_up(&mut self) {
        if let Some(slave) = self.open.take() {
            self.attribute_disturbances(slave);
            self.count(slave, |counts| counts.lost = counts.lost.saturating_add(1));
        }
        self.disturbances = 0;
    }

    /// Keeps the request as the last one to its slave.
    fn keep_request(&mut self, sent: &Sent<'_>, repetitions: u32) {
        let (damage_epoch, number) = (self.damage_epoch, self.totals.telegrams);
        let Some(station) = self.station_mut(sent.data.da) else { return };
        let mut request = station.last.take().map_or_else(|| sent.without_contents(), |last| last.request);
        sent.store(&mut request);
        station.last = Some(LastRequest { request, number, damage_epoch, is_answered: false, repetitions });
        station.longest_sequence = station.longest_sequence.max(repetitions);
        station.asked_at = Some(sent.start);
        if matches!(sent.sap, Sap::Default | Sap::SetPrm | Sap::ChkCfg) {
            station.wanted_at = Some(sent.start);
        }
    }

    /// Counts a request, and the damaged ones that it repeats.
    fn count_request(&mut self, slave: u8, is_repetition: bool, damaged: u32) {
        let damaged = u64::from(damaged);
        self.count(slave, |counts| {
            counts.requests = counts.requests.saturating_add(1).saturating_add(damaged);
            counts.repeated = counts.repeated.saturating_add(u64::from(is_repetition)).saturating_add(damaged);
            counts.damaged = counts.damaged.saturating_add(damaged);
        });
        self.totals.unattributed = self.totals.unattributed.saturating_sub(damaged);
    }

    /// Counts the pending request as unanswered.
    pub(super) fn end_pending(&mut self, start: BitTime) {
        if self.times == TimeSource::Exact && (self.pending.is_some() || self.pending_status.is_some()) {
            let waited_tbit = start - self.asked_end;
            self.slot_tbit = Some(self.slot_tbit.map_or(waited_tbit, |slot_tbit| slot_tbit.min(waited_tbit)));
        }
        if let Some((_, address)) = self.pending_status.take() {
            // An unanswered FDL status shows something only about a station that has answered before, and about a gauge of the file.
            self.no_answer(address, false);
        }
        let Some(slave) = self.pending.take() else { return };
        self.count(slave, |counts| counts.unanswered = counts.unanswered.saturating_add(1));
        self.no_answer(slave, true);
    }

    pub(super) fn no_answer(&mut self, address: u8, is_request: bool) {
        let now = self.now;
        let is_known = self.station(address).is_some_and(|station| station.heard_at.is_some());
        let is_declared = self.station(address).is_some_and(|station| station.knowledge.is_declared());
        if !is_request && !is_known && !is_declared {
            return;
        }
        let Some(station) = self.station_mut(address) else { return };
        station.asked_at = Some(now);
        station.unanswered_in_a_row = station.unanswered_in_a_row.saturating_add(1);
        if station.unanswered_in_a_row == MISSING_AFTER && !station.is_reported_lost && is_known {
            station.is_reported_lost = true;
            station.is_exchanging = false;
            self.event(Some(address), Change::Lost);
        }
    }
}

impl Sent<'_> {
    /// Whether it is an equal request with an equal, counted frame count bit.
    fn is_same(&self, request: &Request) -> bool {
        let data = self.data;
        matches!(self.count, FrameCount::Counted(_) | FrameCount::First)
            && (request.count, request.function, request.master) == (self.count, self.function, data.sa)
            && request.saps == [data.dsap, data.ssap]
            && request.du == data.du
    }

    /// A request that [`store`](Self::store) completes.
    const fn without_contents(&self) -> Request {
        Request {
            master: self.data.sa,
            slave: self.data.da,
            sap: self.sap,
            function: self.function,
            count: self.count,
            saps: [self.data.dsap, self.data.ssap],
            du: Vec::new(),
            at: Some(self.start),
        }
    }

    /// Overwrites a request; its buffer stays.
    fn store(&self, request: &mut Request) {
        let du = std::mem::take(&mut request.du);
        *request = Request { du, ..self.without_contents() };
        request.du.clear();
        request.du.extend_from_slice(self.data.du);
    }
}
