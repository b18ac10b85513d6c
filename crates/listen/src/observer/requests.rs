//! Requests, their repetitions, and requests without an answer.

use super::Observer;
use crate::event::EventKind;
use crate::station::{LastRequest, MISSING_AFTER};
use profivac_dp::link::BitTime;
use profivac_explain::cycle::Request;
use profivac_explain::frame::TimeSource;
use profivac_wire::control::{FrameCount, Function};
use profivac_wire::{DataTelegram, Sap};

/// A request beside the one before it to the same slave.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Relation {
    /// It repeats it for this time, damaged repetitions between them not counted.
    Repetition(u32),
    /// It is another one, and the one before has an answer, or there was none.
    New,
    /// It is another one, and the master gave the one before up.
    AfterLost,
}

impl Observer {
    pub(super) fn request(&mut self, frame: &DataTelegram<'_>, function: Function, count: FrameCount, start: BitTime) {
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
        self.service_request(frame, function, count, start);
    }

    /// Follows a request that its slave answers.
    fn service_request(&mut self, frame: &DataTelegram<'_>, function: Function, count: FrameCount, start: BitTime) {
        let damaged = self.take_damaged_requests(frame, start);
        let (epoch, slave, number) = (self.damage_epoch, frame.da, self.totals.telegrams);
        let sap = Sap::from_octet(frame.dsap);
        let Some(station) = self.station_mut(slave) else { return };
        let last = station.last.take();
        let relation = last.as_ref().map_or(Relation::New, |last| {
            let is_next = last.number.saturating_add(1) == number;
            let is_equal = is_same(&last.request, frame, function, count) && (is_next || count != FrameCount::First);
            let is_certain = last.damage_epoch == epoch || damaged > 0 && !last.is_answered;
            match last.is_answered {
                _ if is_equal && is_certain => Relation::Repetition(last.repetitions.saturating_add(1)),
                true => Relation::New,
                false => Relation::AfterLost,
            }
        });
        let (before, is_repetition) = match relation {
            Relation::Repetition(repetitions) => (repetitions, true),
            Relation::New | Relation::AfterLost => (0, false),
        };
        let repetitions = before.saturating_add(damaged);
        let is_first = repetitions == 0;
        let new_repetitions = u32::from(is_repetition).saturating_add(damaged);
        let mut request = last.map_or_else(|| empty(frame, function, count), |last| last.request);
        store(&mut request, frame, sap, function, count, start);
        station.longest_sequence = station.longest_sequence.max(repetitions);
        station.asked_at = Some(start);
        if matches!(sap, Sap::Default | Sap::SetPrm | Sap::ChkCfg) {
            station.wanted_at = Some(start);
        }
        station.last = Some(LastRequest { request, number, damage_epoch: epoch, is_answered: false, repetitions });
        let is_lost = relation == Relation::AfterLost;
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

    /// Counts the pending request as unanswered.
    pub(super) fn end_pending(&mut self, start: BitTime) {
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

    pub(super) fn no_answer(&mut self, address: u8, is_request: bool) {
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
}

/// Whether `frame` is an equal request with an equal, counted frame count bit.
fn is_same(request: &Request, frame: &DataTelegram<'_>, function: Function, count: FrameCount) -> bool {
    matches!(count, FrameCount::Counted(_) | FrameCount::First)
        && (request.count, request.function, request.master) == (count, function, frame.sa)
        && request.saps == [frame.dsap, frame.ssap]
        && request.du == frame.du
}

/// A request without contents, which [`store`] overwrites.
const fn empty(frame: &DataTelegram<'_>, function: Function, count: FrameCount) -> Request {
    Request {
        master: frame.sa,
        slave: frame.da,
        sap: Sap::Default,
        function,
        count,
        saps: [None; 2],
        du: Vec::new(),
        at: None,
    }
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
