//! A token visit: messages of the layer above as long as there is hold time, one address of the GAP, the token.
//! profibus-wire 1.12.

use super::request::{Asked, Kind, Priority, Request, Requests};
use super::state::{Cycle, Departure, Part, State, Visit};
use super::{Active, Confirmation, Failure};
use crate::link::Transmit;
use crate::link::time::BitTime;
use profivac_wire::control::{Control, FrameCount, Function};
use profivac_wire::{Frame, Telegram};

impl<R: Requests> Active<R> {
    /// The token came at `now`. Its hold time is what the last rotation left of T_TR.
    pub(super) fn begin_visit(&mut self, now: BitTime, idle_tbit: u64) {
        let hold_until = self.visit.began + u64::from(self.bus.rotation_tbit);
        let part = if self.leaving { Part::Over } else { Part::First };
        self.visit = Visit { began: now, hold_until, part };
        self.state = State::Holding { idle_tbit };
        self.suspect = None;
        if !core::mem::take(&mut self.twin.lately) {
            self.twin.heard = 0;
        }
        if self.las.next() == self.bus.address {
            self.other = None;
        }
    }

    /// Holds the token and may speak.
    #[inline]
    pub(super) fn work(&mut self, now: BitTime, not_before: BitTime) -> Option<Transmit<'_>> {
        let part = self.visit.part;
        let on_time = part != Part::Over && now < self.visit.hold_until;
        if part == Part::First {
            self.visit.part = Part::Messages;
        }
        let mut request = None;
        if on_time || part == Part::First {
            request = self.user.next(Priority::High, now);
        }
        if on_time && request.is_none() {
            request = self.user.next(Priority::Low, now);
        }
        let Some(request) = request else { return self.end_visit(now, not_before) };
        let asked = request.asked();
        let count = self.counts.next(&asked);
        match emit(&request, self.bus.address, count, &mut self.telegram) {
            Some(length) => self.begin(asked, count, length, not_before),
            None => {
                self.user.confirm(now, Confirmation::Failed(Failure::Impossible));
                self.end_visit(now, not_before)
            }
        }
    }

    /// A message of the layer above is ready to leave.
    #[inline]
    fn begin(&mut self, asked: Asked, count: FrameCount, length: usize, not_before: BitTime) -> Option<Transmit<'_>> {
        self.state = match asked.kind {
            Kind::Unconfirmed => State::Leaving(Departure::Unconfirmed),
            // A first contact is not repeated, nor is what does not count: profibus-wire 1.10.
            _ if matches!(count, FrameCount::Counted(_)) => State::Waiting(Cycle::new(asked, self.bus.retry_limit)),
            _ => State::Waiting(Cycle::new(asked, 0)),
        };
        self.transmit(length, not_before)
    }

    /// No message is left for this visit: at most one address of the GAP, then the token.
    ///
    /// free choice: the GAP is asked even if the hold time is over, so that a busy ring does not keep newcomers out.
    fn end_visit(&mut self, now: BitTime, not_before: BitTime) -> Option<Transmit<'_>> {
        let over = core::mem::replace(&mut self.visit.part, Part::Over) == Part::Over;
        match if over { None } else { self.gap.visit(now, self.las.next()) } {
            None => self.pass_token(not_before),
            Some(da) => {
                let request = Request { da, function: Function::FdlStatus, dsap: None, ssap: None, du: &[] };
                let length = emit(&request, self.bus.address, FrameCount::Uncounted, &mut self.telegram)?;
                self.state = State::Waiting(Cycle { from_user: false, ..Cycle::new(request.asked(), 0) });
                self.transmit(length, not_before)
            }
        }
    }
}

/// Writes a request to the front of `out`; nothing if no station can be sent such a message.
#[inline]
fn emit(request: &Request<'_>, sa: u8, count: FrameCount, out: &mut [u8]) -> Option<usize> {
    if !request.is_possible(sa) {
        return None;
    }
    let &Request { da, function, dsap, ssap, du } = request;
    let fc = Control::Request { function, count }.to_octet();
    Telegram::Frame(Frame { da, sa, dsap, ssap, fc, du }).emit(out).ok()
}
