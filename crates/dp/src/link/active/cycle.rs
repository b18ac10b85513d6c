//! A message cycle: a request, its repetitions, and its answer. profibus-wire 1.10.

use super::request::{Kind, Requests};
use super::state::{Cycle, State};
use super::{Active, Answer, Confirmation, Failure, LONGEST_TBIT, answer};
use crate::link::Transmit;
use crate::link::time::BitTime;
use profivac_wire::Telegram;
use profivac_wire::control::StationType;

impl<R: Requests> Active<R> {
    /// A telegram of a responder, or one that cannot be anybody's.
    #[inline]
    pub(super) fn heard(&mut self, end: BitTime, telegram: &Telegram<'_>) {
        let slot = self.slot_tbit();
        match &mut self.state {
            State::Waiting(cycle) => match answer::matched(&cycle.asked, self.bus.address, telegram) {
                Ok(answer) => {
                    let cycle = *cycle;
                    self.answered(end, &cycle, answer);
                }
                Err(mismatch) => cycle.mismatch = Some(mismatch),
            },
            // A late answer: others may follow, and must not be taken for answers to the next request.
            State::Holding { idle_tbit } => *idle_tbit = slot.max(*idle_tbit),
            State::Passing(pass) => pass.heard = true,
            State::Offline | State::Listening | State::Idle | State::Claiming | State::Leaving(_) => {}
        }
    }

    /// The answer came.
    #[inline]
    fn answered(&mut self, end: BitTime, cycle: &Cycle, answer: Answer<'_>) {
        self.counts.answered(&cycle.asked);
        if cycle.asked.kind == Kind::FdlStatus {
            self.found(cycle, answer.station);
        }
        // What was repeated may be answered twice, and the first answer may have been a late one. Both look alike, so the
        // second must not fall into the next message cycle: it comes within two slot times.
        let idle_tbit = match cycle.retries {
            0 => self.bus.id1_tbit(),
            _ => self.slot_tbit().saturating_mul(2),
        };
        self.state = State::Holding { idle_tbit };
        if cycle.from_user {
            self.user.confirm(end, Confirmation::Answer(Answer { retries: cycle.retries, ..answer }));
        }
    }

    /// Somebody is there. A master in the GAP that is ready is the new successor; one that takes itself for a member of the
    /// ring is in another one, which ends here.
    fn found(&mut self, cycle: &Cycle, station: StationType) {
        self.gap.note(cycle.asked.da, Some(station));
        if !cycle.from_user && matches!(station, StationType::MasterReady | StationType::MasterInRing) {
            self.las.insert(cycle.asked.da);
        }
    }

    /// No answer has come in time: the request again, or the next one.
    pub(super) fn expire(&mut self, now: BitTime, mut cycle: Cycle) -> Option<Transmit<'_>> {
        if now < self.busy + self.slot_tbit() {
            // Longer than any telegram, and still not quiet.
            self.give_way(now);
            return None;
        }
        // T_SL is longer than T_ID1: BusParameters::check.
        let idle_tbit = self.slot_tbit();
        let not_before = self.busy + idle_tbit;
        if cycle.retries_left > 0 {
            cycle.retries_left = cycle.retries_left.saturating_sub(1);
            cycle.retries = cycle.retries.saturating_add(1);
            cycle.left = None;
            cycle.mismatch = None;
            self.state = State::Waiting(cycle);
            return self.transmit(self.length, not_before);
        }
        let failure = match cycle.mismatch {
            Some(mismatch) => Failure::Mismatch(mismatch),
            None if cycle.left.is_some_and(|left| left < self.busy) => Failure::Damaged,
            None => Failure::Silence,
        };
        self.state = State::Holding { idle_tbit };
        self.failed(now, &cycle, failure);
        self.work(now, not_before)
    }

    /// No answer will come: the station counts as not operational.
    pub(super) fn failed(&mut self, now: BitTime, cycle: &Cycle, failure: Failure) {
        self.counts.forget(&cycle.asked);
        if cycle.asked.kind == Kind::FdlStatus && failure != Failure::Interrupted {
            self.gap.note(cycle.asked.da, None);
        }
        if cycle.from_user {
            self.user.confirm(now, Confirmation::Failed(failure));
        }
    }

    /// When to give up waiting for an answer: a slot time after the line fell silent, but not much later than the longest
    /// answer could end.
    #[inline]
    pub(super) fn deadline(&self, cycle: &Cycle) -> Option<BitTime> {
        let slot = self.slot_tbit();
        Some((self.busy + slot).min(cycle.left? + slot + LONGEST_TBIT + slot))
    }
}
