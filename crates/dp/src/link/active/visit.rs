//! A token visit: requests of the FDL user during the token hold time, one address of the GAP, the token.
//! profibus-wire 1.12.

use super::request::{FdlUser, Kind, OpenRequest, Priority, Request};
use super::state::{FdlState, MessageCycle, Unconfirmed, Visit, VisitPhase};
use super::{Active, Confirmation, Failure};
use crate::link::Transmit;
use crate::link::time::BitTime;
use profivac_wire::control::{Control, FrameCount, Function};
use profivac_wire::{DataTelegram, Telegram};

impl<R: FdlUser> Active<R> {
    /// The token came at `now`. The hold time is T_TR less the duration of the last rotation.
    pub(super) fn begin_visit(&mut self, now: BitTime, idle_tbit: u64) {
        let hold_until = self.visit.began + u64::from(self.bus.rotation_tbit);
        let phase = if self.leaving_ring { VisitPhase::Over } else { VisitPhase::First };
        self.visit = Visit { began: now, hold_until, phase };
        self.state = FdlState::Holding { idle_tbit, answered: None };
        self.suspect = None;
        if !core::mem::take(&mut self.duplicate.heard_since_visit) {
            self.duplicate.heard = 0;
        }
        if self.las.next() == self.bus.address {
            self.other = None;
        }
    }

    /// Sends the next telegram of a station that has the token.
    #[inline]
    pub(super) fn use_token(&mut self, now: BitTime, not_before: BitTime) -> Option<Transmit<'_>> {
        let phase = self.visit.phase;
        let on_time = phase != VisitPhase::Over && now < self.visit.hold_until;
        if phase == VisitPhase::First {
            self.visit.phase = VisitPhase::Messages;
        }
        let mut request = None;
        if on_time || phase == VisitPhase::First {
            request = self.user.next_request(Priority::High, now);
        }
        if on_time && request.is_none() {
            request = self.user.next_request(Priority::Low, now);
        }
        let Some(request) = request else { return self.end_visit(now, not_before) };
        let asked = request.open_request();
        let count = self.counts.next(&asked);
        match emit(&request, self.bus.address, count, &mut self.telegram) {
            Some(length) => self.send_request(asked, count, length, not_before),
            None => {
                self.user.confirm(now, Confirmation::Failed(Failure::Impossible));
                self.end_visit(now, not_before)
            }
        }
    }

    /// Sends a request of the FDL user.
    #[inline]
    fn send_request(
        &mut self,
        asked: OpenRequest,
        count: FrameCount,
        length: usize,
        not_before: BitTime,
    ) -> Option<Transmit<'_>> {
        self.state = match asked.kind {
            Kind::Unconfirmed => FdlState::Sending(Unconfirmed::Message),
            // A first contact is not repeated, nor is an uncounted request: profibus-wire 1.10.
            _ if matches!(count, FrameCount::Counted(_)) => {
                FdlState::Waiting(MessageCycle::new(asked, self.bus.retry_limit))
            }
            _ => FdlState::Waiting(MessageCycle::new(asked, 0)),
        };
        self.transmit(length, not_before)
    }

    /// Ends the messages of this visit: at most one address of the GAP, then the token.
    ///
    /// chosen: the station asks the GAP even after the hold time, so that a busy ring does not keep newcomers out.
    fn end_visit(&mut self, now: BitTime, not_before: BitTime) -> Option<Transmit<'_>> {
        let over = core::mem::replace(&mut self.visit.phase, VisitPhase::Over) == VisitPhase::Over;
        match if over { None } else { self.gap.next_address(now, self.las.next()) } {
            None => self.pass_token(not_before),
            Some(da) => {
                let request = Request { da, function: Function::FdlStatus, dsap: None, ssap: None, du: &[] };
                let length = emit(&request, self.bus.address, FrameCount::Uncounted, &mut self.telegram)?;
                self.state = FdlState::Waiting(MessageCycle {
                    from_user: false,
                    ..MessageCycle::new(request.open_request(), 0)
                });
                self.transmit(length, not_before)
            }
        }
    }
}

/// Writes a request to the front of `out`; `None` if it is impossible.
#[inline]
fn emit(request: &Request<'_>, sa: u8, count: FrameCount, out: &mut [u8]) -> Option<usize> {
    if !request.is_possible(sa) {
        return None;
    }
    let &Request { da, function, dsap, ssap, du } = request;
    let fc = Control::Request { function, count }.to_octet();
    Telegram::Data(DataTelegram { da, sa, dsap, ssap, fc, du }).emit(out).ok()
}
