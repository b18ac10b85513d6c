//! A message cycle: a request, its repetitions, and its answer. profibus-wire 1.10.

use super::request::{FdlUser, Kind};
use super::state::{FdlState, MessageCycle};
use super::{Active, Answer, Confirmation, Failure, LONGEST_TBIT, answer};
use crate::link::Transmit;
use crate::link::time::BitTime;
use profivac_wire::Telegram;
use profivac_wire::control::StationType;

impl<R: FdlUser> Active<R> {
    /// A telegram of a responder, or a token that no master can have sent.
    #[inline]
    pub(super) fn handle_answer(&mut self, end: BitTime, telegram: &Telegram<'_>) {
        let slot = self.slot_tbit();
        match &mut self.state {
            FdlState::Waiting(cycle) => match answer::matched(&cycle.request, self.bus.address, telegram) {
                Ok(answer) => {
                    let cycle = *cycle;
                    self.answered(end, &cycle, answer);
                }
                Err(mismatch) => cycle.mismatch = Some(mismatch),
            },
            // A second answer: more may follow, which must not be taken for answers to the next request.
            FdlState::Holding { idle_tbit, answered } => {
                *idle_tbit = slot.max(*idle_tbit);
                let answered = *answered;
                self.stray(end, answered, telegram);
            }
            FdlState::Passing(pass) => pass.heard = true,
            FdlState::Offline | FdlState::Listening | FdlState::Idle | FdlState::Claiming | FdlState::Sending(_) => {}
        }
    }

    /// An answer to no open request: a late one, or one of a second station with the same address. SC does not name its
    /// sender; it is attributed to the station that has just answered.
    #[cold]
    fn stray(&mut self, now: BitTime, answered: Option<u8>, telegram: &Telegram<'_>) {
        let sender = match telegram {
            Telegram::ShortAck => answered,
            Telegram::Data(data) => (data.da == self.bus.address).then_some(data.sa),
            Telegram::Token { .. } => None,
        };
        if let Some(sender) = sender {
            self.user.stray(now, sender);
        }
    }

    /// The answer came.
    #[inline]
    fn answered(&mut self, end: BitTime, cycle: &MessageCycle, answer: Answer<'_>) {
        self.counts.answered(&cycle.request);
        if cycle.request.kind == Kind::FdlStatus {
            self.station_found(cycle, answer.station);
        }
        // A repeated request may be answered twice, and the first answer may have been a late one. Both look alike, so the
        // second must not fall into the next message cycle: it comes within two slot times.
        let idle_tbit = match cycle.repetitions {
            0 => self.bus.id1_tbit(),
            _ => self.slot_tbit().saturating_mul(2),
        };
        self.state = FdlState::Holding { idle_tbit, answered: Some(cycle.request.da) };
        if cycle.from_user {
            self.user.confirm(end, Confirmation::Answer(Answer { repetitions: cycle.repetitions, ..answer }));
        }
    }

    /// A station answered FDL status. A master in the GAP that is ready is the new successor; a master that reports to be in a
    /// ring already is in another ring, which ends here.
    fn station_found(&mut self, cycle: &MessageCycle, station: StationType) {
        self.gap.set_station(cycle.request.da, Some(station));
        if !cycle.from_user && matches!(station, StationType::MasterReady | StationType::MasterInRing) {
            self.las.insert(cycle.request.da);
        }
    }

    /// No answer has come in time: repeats the request, or gives it up.
    pub(super) fn slot_expired(&mut self, now: BitTime, mut cycle: MessageCycle) -> Option<Transmit<'_>> {
        if now < self.busy_until + self.slot_tbit() {
            // The line has been busy for longer than any telegram.
            self.give_up_token(now);
            return None;
        }
        // T_SL is longer than T_ID1: BusParameters::check.
        let idle_tbit = self.slot_tbit();
        let not_before = self.busy_until + idle_tbit;
        if cycle.repetitions_left > 0 {
            cycle.repetitions_left = cycle.repetitions_left.saturating_sub(1);
            cycle.repetitions = cycle.repetitions.saturating_add(1);
            cycle.sent_at = None;
            cycle.mismatch = None;
            self.state = FdlState::Waiting(cycle);
            return self.transmit(self.length, not_before);
        }
        let failure = match cycle.mismatch {
            Some(mismatch) => Failure::Mismatch(mismatch),
            None if cycle.sent_at.is_some_and(|sent| sent < self.busy_until) => Failure::Damaged,
            None => Failure::Silence,
        };
        self.state = FdlState::Holding { idle_tbit, answered: None };
        self.failed(now, &cycle, failure);
        self.use_token(now, not_before)
    }

    /// The request has failed: the station counts as not operational.
    pub(super) fn failed(&mut self, now: BitTime, cycle: &MessageCycle, failure: Failure) {
        self.counts.forget(&cycle.request);
        if cycle.request.kind == Kind::FdlStatus && failure != Failure::Interrupted {
            self.gap.set_station(cycle.request.da, None);
        }
        if cycle.from_user {
            self.user.confirm(now, Confirmation::Failed(failure));
        }
    }

    /// When the wait for an answer ends: a slot time after the line became idle, but not much later than the longest answer
    /// could end.
    #[inline]
    pub(super) fn deadline(&self, cycle: &MessageCycle) -> Option<BitTime> {
        let slot = self.slot_tbit();
        Some((self.busy_until + slot).min(cycle.sent_at? + slot + LONGEST_TBIT + slot))
    }
}
