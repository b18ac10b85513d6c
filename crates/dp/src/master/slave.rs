//! One slave as its class 1 master sees it: the handler of profibus-wire 3.10.
//!
//! The state says which message comes next ([`Handler::ask`]), the answer to it says which state comes next
//! ([`Handler::confirmed`]). Every slave gets at most one message per cycle, so one that errs again and again costs the
//! others no more than one that works.

use super::backoff::BackOff;
use super::diagnosis::Diagnosis;
use super::event::{Event, Sink, Trouble, What};
use super::parameters::{Rejected, Settings, SlaveParameters};
use super::state::{Ask, Counters, State};
use crate::link::BitTime;
use crate::link::active::{Answer, Confirmation, Failure};
use heapless::Vec;
use profivac_wire::cfg::{self, Lengths};
use profivac_wire::control::Status;
use profivac_wire::prm::{PrmStatus, SetPrm};

/// The longest User_Prm_Data: 244 octets without the seven fixed ones.
const MAX_USER_PRM: usize = 237;

/// What the master must know when a handler has done its work.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Change {
    Nothing,
    /// The slave exchanges data no more: something went wrong, unless it was told so.
    FellOut,
    /// The slave was to be removed, and has been given back.
    Gone,
}

/// What all handlers share, and where they report.
pub(super) struct Context<'a> {
    pub(super) now: BitTime,
    /// TS.
    pub(super) address: u8,
    pub(super) settings: &'a Settings,
    pub(super) events: Sink<'a>,
    /// How many slaves exchange data.
    pub(super) exchanging: &'a mut usize,
    /// The slaves are to be told the mode of the master.
    pub(super) control_due: &'a mut bool,
    /// When the message was handed out that is being confirmed.
    pub(super) asked_at: BitTime,
    pub(super) change: Change,
}

/// One slave.
#[derive(Clone, Debug)]
pub(super) struct Handler<const OCTETS: usize> {
    pub(super) address: u8,
    pub(super) ident: u16,
    watchdog: Option<[u8; 2]>,
    min_tsdr: u8,
    min_interval_tbit: u64,
    pub(super) group: u8,
    requests: PrmStatus,
    fail_safe: bool,
    pub(super) dpv1: bool,
    pub(super) diag_update_delay: u8,
    cfg: Vec<u8, OCTETS>,
    user_prm: Vec<u8, OCTETS>,
    lengths: Lengths,
    pub(super) state: State,
    /// Message cycles in a row that failed.
    pub(super) misses: u8,
    back_off: BackOff,
    /// To be forgotten once it is inactive.
    leaving: bool,
    trouble: Option<Trouble>,
    pub(super) diagnosis: Option<Diagnosis<OCTETS>>,
    pub(super) counters: Counters,
    /// When the inputs came; nothing unless they are from the present data exchange.
    exchanged: Option<BitTime>,
    inputs: [u8; OCTETS],
    outputs: [u8; OCTETS],
}

impl<const OCTETS: usize> Handler<OCTETS> {
    pub(super) fn new(parameters: &SlaveParameters<'_>) -> Result<Self, Rejected> {
        let lengths = cfg::lengths(parameters.cfg).map_err(Rejected::Cfg)?;
        fits("inputs", lengths.inputs.into(), OCTETS)?;
        fits("outputs", lengths.outputs.into(), OCTETS)?;
        if parameters.watchdog.is_some_and(|factors| factors.contains(&0)) {
            return Err(Rejected::Watchdog);
        }
        let mut requests = PrmStatus::empty();
        requests.set(PrmStatus::WD_ON, parameters.watchdog.is_some());
        requests.set(PrmStatus::SYNC_REQ, parameters.sync);
        requests.set(PrmStatus::FREEZE_REQ, parameters.freeze);
        Ok(Self {
            address: parameters.address,
            ident: parameters.ident,
            watchdog: parameters.watchdog,
            min_tsdr: parameters.min_tsdr,
            min_interval_tbit: parameters.min_interval_tbit,
            group: parameters.group,
            requests,
            fail_safe: parameters.fail_safe,
            dpv1: parameters.dpv1,
            diag_update_delay: parameters.diag_update_delay,
            cfg: copied("configuration", parameters.cfg, OCTETS)?,
            user_prm: copied("user parameters", parameters.user_prm, OCTETS.min(MAX_USER_PRM))?,
            lengths,
            state: State::Offline,
            misses: 0,
            back_off: BackOff::new(),
            leaving: false,
            trouble: None,
            diagnosis: None,
            counters: Counters::default(),
            exchanged: None,
            inputs: [0; OCTETS],
            outputs: [0; OCTETS],
        })
    }

    pub(super) const fn state(&self) -> State {
        self.state
    }

    pub(super) const fn trouble(&self) -> Option<Trouble> {
        self.trouble
    }

    pub(super) const fn counters(&self) -> &Counters {
        &self.counters
    }

    pub(super) fn cfg(&self) -> &[u8] {
        &self.cfg
    }

    pub(super) fn user_prm(&self) -> &[u8] {
        &self.user_prm
    }

    pub(super) fn inputs(&self) -> Option<&[u8]> {
        self.inputs.get(..self.lengths.inputs.into()).filter(|_| self.exchanged.is_some())
    }

    pub(super) const fn exchanged_at(&self) -> Option<BitTime> {
        self.exchanged
    }

    pub(super) fn outputs(&self) -> &[u8] {
        self.outputs.get(..self.lengths.outputs.into()).unwrap_or_default()
    }

    pub(super) fn outputs_mut(&mut self) -> &mut [u8] {
        self.outputs.get_mut(..self.lengths.outputs.into()).unwrap_or_default()
    }

    /// How many octets Clear sends: zeros, or none at all. profibus-wire 3.8.
    pub(super) fn cleared_outputs(&self) -> usize {
        if self.fail_safe { 0 } else { self.lengths.outputs.into() }
    }

    /// The data unit of Set_Prm.
    pub(super) fn set_prm(&self) -> SetPrm<'_> {
        SetPrm {
            status: PrmStatus::LOCK_REQ | self.requests,
            wd_fact: self.watchdog.unwrap_or_default(),
            min_tsdr: self.min_tsdr,
            ident: self.ident,
            group: self.group,
            user: &self.user_prm,
        }
    }

    /// The data unit of the Set_Prm that gives the slave back, profibus-wire 2.4.
    pub(super) const fn unlock(&self) -> SetPrm<'static> {
        SetPrm { status: PrmStatus::UNLOCK_REQ, wd_fact: [0; 2], min_tsdr: 0, ident: self.ident, group: 0, user: &[] }
    }

    /// The message for this slave in the present cycle.
    #[inline]
    pub(super) fn ask(&self, now: BitTime) -> Option<Ask> {
        self.state.asks().filter(|_| self.back_off.is_over(now))
    }

    /// What became of the message.
    pub(super) fn confirmed(&mut self, ask: Ask, confirmation: Confirmation<'_>, context: &mut Context<'_>) {
        self.took_place(ask, confirmation, context);
        self.keep_distance(context.asked_at);
    }

    /// Min_Slave_Interval.
    #[inline]
    fn keep_distance(&mut self, asked: BitTime) {
        if self.min_interval_tbit > 0 {
            self.back_off.not_before(asked + self.min_interval_tbit);
        }
    }

    fn took_place(&mut self, ask: Ask, confirmation: Confirmation<'_>, context: &mut Context<'_>) {
        if self.state.asks() != Some(ask) {
            // Released or taken up again while the message was on its way.
            return;
        }
        match (ask, confirmation) {
            // Nothing is known about the slave then, and no message of a handler goes without an answer.
            (_, Confirmation::Failed(Failure::Interrupted) | Confirmation::Sent) => {}
            (_, Confirmation::Failed(failure)) => self.missed(failure, context),
            (Ask::DataExch, Confirmation::Answer(answer)) => self.exchanged(&answer, context),
            (Ask::SlaveDiag, Confirmation::Answer(answer)) => self.diagnosed(&answer, context),
            (Ask::SetPrm, Confirmation::Answer(answer)) => self.acknowledged(&answer, State::Cfg, context),
            (Ask::ChkCfg, Confirmation::Answer(answer)) => {
                self.acknowledged(&answer, State::Diag2 { since: context.now, prm_reqs: 0 }, context);
            }
            (Ask::FdlStatus, Confirmation::Answer(_)) => self.enter(State::Diag1, context),
            (Ask::Unlock, Confirmation::Answer(_)) => self.enter(State::Inactive, context),
        }
    }

    /// Takes the slave into the cycle, or anew.
    pub(super) fn start(&mut self, context: &mut Context<'_>) {
        self.enter(State::Offline, context);
        self.back_off.begin_anew(context.now + self.min_interval_tbit);
        self.leaving = false;
        self.trouble = None;
    }

    /// Gives the slave back if it may be ours.
    pub(super) fn release(&mut self, context: &mut Context<'_>) {
        match self.state {
            State::Offline | State::Diag1 => self.enter(State::Inactive, context),
            State::Prm | State::Cfg | State::Diag2 { .. } | State::Data { .. } => self.enter(State::Release, context),
            State::Release | State::Inactive => {}
        }
    }

    /// The same, to be forgotten afterwards.
    pub(super) fn remove(&mut self, context: &mut Context<'_>) {
        self.leaving = true;
        self.release(context);
    }

    /// Takes over other parameters; what was counted and learnt stays.
    pub(super) fn adopt(&mut self, fresh: Self, context: &mut Context<'_>) {
        let old = core::mem::replace(self, fresh);
        if self.lengths.outputs == old.lengths.outputs {
            self.outputs = old.outputs;
        }
        self.state = old.state;
        self.leaving = old.leaving;
        self.back_off = old.back_off;
        self.counters = old.counters;
        self.diagnosis = old.diagnosis;
        self.parameterise(context);
    }

    /// Puts the slave into other groups.
    pub(super) fn set_group(&mut self, group: u8, context: &mut Context<'_>) {
        self.group = group;
        self.parameterise(context);
    }

    /// Set_Prm and all that follows, if it was sent before.
    fn parameterise(&mut self, context: &mut Context<'_>) {
        self.trouble = None;
        match self.state {
            State::Prm | State::Cfg | State::Diag2 { .. } | State::Data { .. } => self.enter(State::Diag1, context),
            State::Offline | State::Diag1 | State::Release | State::Inactive => {}
        }
        self.back_off.begin_anew(context.now + self.min_interval_tbit);
    }

    /// Because of this slave all go to safe outputs.
    pub(super) fn auto_clear(&self, context: &mut Context<'_>) {
        self.note(What::AutoClear, context);
    }

    pub(super) const fn is_exchanging(&self) -> bool {
        matches!(self.state, State::Data { .. })
    }

    /// The usual case: an exchange with as many inputs as there should be, and nothing to be told. Whether it was that.
    #[inline]
    pub(super) fn took_inputs(
        &mut self,
        ask: Ask,
        confirmation: &Confirmation<'_>,
        at: BitTime,
        asked: BitTime,
    ) -> bool {
        let (State::Data { diag: false }, Ask::DataExch, Confirmation::Answer(answer)) =
            (self.state, ask, confirmation)
        else {
            return false;
        };
        let diag = match answer.status {
            Status::DataLow | Status::NoReply => false,
            Status::DataHigh => true,
            _ => return false,
        };
        let Some(image) = self.inputs.get_mut(..usize::from(self.lengths.inputs)) else { return false };
        if image.len() != answer.du.len() {
            return false;
        }
        image.copy_from_slice(answer.du);
        self.count_retries(answer);
        self.took(diag, at);
        self.keep_distance(asked);
        true
    }

    /// profibus-wire 2.8, master rules; without the usual case, [`took_inputs`](Self::took_inputs).
    fn exchanged(&mut self, answer: &Answer<'_>, context: &mut Context<'_>) {
        self.count_retries(answer);
        match answer.status {
            Status::DataLow | Status::DataHigh | Status::NoReply => {
                let (expected, received) = (usize::from(self.lengths.inputs), answer.du.len());
                self.restart(Trouble::Length { expected, received }, context);
            }
            Status::ServiceNotActivated => self.restart(Trouble::Refused(answer.status), context),
            status => self.refused(status, context),
        }
    }

    /// An exchange was good: whatever went wrong before is over.
    #[inline]
    fn took(&mut self, diag: bool, now: BitTime) {
        self.state = State::Data { diag };
        self.counters.exchanges = self.counters.exchanges.wrapping_add(1);
        self.misses = 0;
        self.trouble = None;
        self.exchanged = Some(now);
    }

    /// No data this time. Again and again, and the slave is started anew.
    fn refused(&mut self, status: Status, context: &mut Context<'_>) {
        self.misses = self.misses.saturating_add(1);
        if self.misses >= context.settings.miss_limit {
            self.restart(Trouble::Refused(status), context);
        }
    }

    /// No valid answer, after all repetitions.
    fn missed(&mut self, failure: Failure, context: &mut Context<'_>) {
        if self.state == State::Offline {
            self.report(Trouble::Lost(failure), context);
            return self.back_off.failed(context.now, context.settings);
        }
        self.counters.lost = self.counters.lost.wrapping_add(1);
        self.misses = self.misses.saturating_add(1);
        if self.misses >= context.settings.miss_limit {
            let next = if self.state == State::Release { State::Inactive } else { State::Offline };
            self.report(Trouble::Lost(failure), context);
            self.enter(next, context);
            self.back_off.failed(context.now, context.settings);
        } else if let Failure::Mismatch(_) = failure {
            self.report(Trouble::Lost(failure), context);
        }
    }

    /// Set_Prm and Chk_Cfg are answered by SC, right or wrong; the diagnosis tells.
    fn acknowledged(&mut self, answer: &Answer<'_>, next: State, context: &mut Context<'_>) {
        self.count_retries(answer);
        match answer.status {
            Status::NoReply => self.enter(next, context),
            status => self.restart(Trouble::Refused(status), context),
        }
    }

    /// Back to the first diagnosis, at once if exchange was good before, after a growing pause otherwise.
    pub(super) fn restart(&mut self, trouble: Trouble, context: &mut Context<'_>) {
        self.report(trouble, context);
        self.enter(State::Diag1, context);
        self.back_off.failed(context.now, context.settings);
    }

    pub(super) fn count_retries(&mut self, answer: &Answer<'_>) {
        self.counters.retries = self.counters.retries.wrapping_add(answer.retries.into());
    }

    pub(super) fn report(&mut self, trouble: Trouble, context: &mut Context<'_>) {
        if self.trouble != Some(trouble) {
            self.trouble = Some(trouble);
            self.note(What::Trouble(trouble), context);
        }
    }

    /// The only place where a state is entered that was not before.
    pub(super) fn enter(&mut self, state: State, context: &mut Context<'_>) {
        let is = matches!(state, State::Data { .. });
        match (matches!(self.state, State::Data { .. }), is) {
            (false, true) => {
                *context.exchanging = context.exchanging.saturating_add(1);
                *context.control_due = true;
                self.back_off.well(context.now);
            }
            (true, false) => {
                *context.exchanging = context.exchanging.saturating_sub(1);
                context.change = Change::FellOut;
            }
            (true, true) | (false, false) => {}
        }
        self.exchanged = self.exchanged.filter(|_| is);
        self.misses = 0;
        self.back_off.end(context.now);
        if self.leaving && state == State::Inactive {
            context.change = Change::Gone;
        }
        if self.state != state {
            self.state = state;
            self.note(What::Entered(state), context);
        }
    }

    pub(super) fn note(&self, what: What, context: &mut Context<'_>) {
        context.events.push(Event { at: context.now, address: self.address, what });
    }
}

fn copied<const OCTETS: usize>(what: &'static str, octets: &[u8], room: usize) -> Result<Vec<u8, OCTETS>, Rejected> {
    fits(what, octets.len(), room)?;
    Vec::from_slice(octets).map_err(|_| Rejected::TooLong { what, octets: octets.len(), room })
}

const fn fits(what: &'static str, octets: usize, room: usize) -> Result<(), Rejected> {
    if octets <= room { Ok(()) } else { Err(Rejected::TooLong { what, octets, room }) }
}
