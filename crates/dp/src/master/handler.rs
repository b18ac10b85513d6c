//! One slave as its class 1 master sees it: the handler of profibus-wire 3.10.
//!
//! The state says which message comes next ([`Handler::ask`]), the answer to it says which state comes next
//! ([`Handler::confirmed`]). Every slave gets at most one message per cycle, so one that errs again and again costs the
//! others no more than one that works.

use super::backoff::BackOff;
use super::diagnosis::Diagnosis;
use super::event::{Event, EventKind, ExchangeError, Sink};
use super::parameters::{Settings, SlaveListError, SlaveParameters};
use super::state::{Counters, CyclicRequest, HandlerState};
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
    LeftExchange,
    /// The slave was to be removed, and has been given back.
    Released,
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
    pub(super) state: HandlerState,
    /// Message cycles in a row that failed.
    pub(super) misses: u8,
    back_off: BackOff,
    /// To be forgotten once it is inactive.
    leaving: bool,
    /// An answer to nothing was told of.
    stray_reported: bool,
    error: Option<ExchangeError>,
    pub(super) diagnosis: Option<Diagnosis<OCTETS>>,
    pub(super) counters: Counters,
    /// When the inputs came; nothing unless they are from the present data exchange.
    exchanged: Option<BitTime>,
    inputs: [u8; OCTETS],
    outputs: [u8; OCTETS],
}

impl<const OCTETS: usize> Handler<OCTETS> {
    pub(super) fn new(parameters: &SlaveParameters<'_>) -> Result<Self, SlaveListError> {
        let lengths = cfg::lengths(parameters.cfg).map_err(SlaveListError::Cfg)?;
        fits("inputs", lengths.inputs.into(), OCTETS)?;
        fits("outputs", lengths.outputs.into(), OCTETS)?;
        if parameters.watchdog.is_some_and(|factors| factors.contains(&0)) {
            return Err(SlaveListError::Watchdog);
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
            state: HandlerState::Offline,
            misses: 0,
            back_off: BackOff::new(),
            leaving: false,
            stray_reported: false,
            error: None,
            diagnosis: None,
            counters: Counters::default(),
            exchanged: None,
            inputs: [0; OCTETS],
            outputs: [0; OCTETS],
        })
    }

    pub(super) const fn state(&self) -> HandlerState {
        self.state
    }

    pub(super) const fn error(&self) -> Option<ExchangeError> {
        self.error
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
    pub(super) fn next_request(&self, now: BitTime) -> Option<CyclicRequest> {
        self.state.request().filter(|_| self.back_off.is_over(now))
    }

    /// What became of the message.
    pub(super) fn confirmed(&mut self, ask: CyclicRequest, confirmation: Confirmation<'_>, context: &mut Context<'_>) {
        self.handle_confirmation(ask, confirmation, context);
        self.enforce_min_interval(context.asked_at);
    }

    /// Min_Slave_Interval.
    #[inline]
    fn enforce_min_interval(&mut self, asked: BitTime) {
        if self.min_interval_tbit > 0 {
            self.back_off.not_before(asked + self.min_interval_tbit);
        }
    }

    fn handle_confirmation(&mut self, ask: CyclicRequest, confirmation: Confirmation<'_>, context: &mut Context<'_>) {
        if self.state.request() != Some(ask) {
            // Released or taken up again while the message was on its way.
            return;
        }
        match (ask, confirmation) {
            // Nothing is known about the slave then, and no message of a handler goes without an answer.
            (_, Confirmation::Failed(Failure::Interrupted) | Confirmation::Sent) => {}
            (_, Confirmation::Failed(failure)) => self.no_answer(failure, context),
            (CyclicRequest::DataExch, Confirmation::Answer(answer)) => self.exchanged(&answer, context),
            (CyclicRequest::SlaveDiag, Confirmation::Answer(answer)) => self.diagnosed(&answer, context),
            (CyclicRequest::SetPrm, Confirmation::Answer(answer)) => {
                self.acknowledged(&answer, HandlerState::Cfg, context)
            }
            (CyclicRequest::ChkCfg, Confirmation::Answer(answer)) => {
                self.acknowledged(&answer, HandlerState::Diag2 { since: context.now, prm_reqs: 0 }, context);
            }
            (CyclicRequest::FdlStatus, Confirmation::Answer(_)) => self.enter(HandlerState::Diag1, context),
            (CyclicRequest::Unlock, Confirmation::Answer(_)) => self.enter(HandlerState::Inactive, context),
        }
    }

    /// Takes the slave into the cycle, or anew.
    pub(super) fn start(&mut self, context: &mut Context<'_>) {
        self.enter(HandlerState::Offline, context);
        self.back_off.reset(context.now + self.min_interval_tbit);
        self.leaving = false;
        self.error = None;
    }

    /// Gives the slave back if it may be ours.
    pub(super) fn release(&mut self, context: &mut Context<'_>) {
        match self.state {
            HandlerState::Offline | HandlerState::Diag1 => self.enter(HandlerState::Inactive, context),
            HandlerState::Prm | HandlerState::Cfg | HandlerState::Diag2 { .. } | HandlerState::Data { .. } => {
                self.enter(HandlerState::Release, context)
            }
            HandlerState::Release | HandlerState::Inactive => {}
        }
    }

    /// The same, to be forgotten afterwards.
    pub(super) fn remove(&mut self, context: &mut Context<'_>) {
        self.leaving = true;
        self.release(context);
    }

    /// Takes over other parameters; what was counted and learnt stays.
    pub(super) fn replace_parameters(&mut self, fresh: Self, context: &mut Context<'_>) {
        let old = core::mem::replace(self, fresh);
        if self.lengths.outputs == old.lengths.outputs {
            self.outputs = old.outputs;
        }
        self.state = old.state;
        self.leaving = old.leaving;
        self.stray_reported = old.stray_reported;
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
        self.error = None;
        match self.state {
            HandlerState::Prm | HandlerState::Cfg | HandlerState::Diag2 { .. } | HandlerState::Data { .. } => {
                self.enter(HandlerState::Diag1, context)
            }
            HandlerState::Offline | HandlerState::Diag1 | HandlerState::Release | HandlerState::Inactive => {}
        }
        self.back_off.reset(context.now + self.min_interval_tbit);
    }

    /// It has answered, and nothing was asked.
    pub(super) fn stray_answer(&mut self, context: &mut Context<'_>) {
        self.counters.strays = self.counters.strays.saturating_add(1);
        if !core::mem::replace(&mut self.stray_reported, true) {
            self.push_event(EventKind::Stray, context);
        }
    }

    /// Because of this slave all go to safe outputs.
    pub(super) fn auto_clear(&self, context: &mut Context<'_>) {
        self.push_event(EventKind::AutoClear, context);
    }

    pub(super) const fn is_exchanging(&self) -> bool {
        matches!(self.state, HandlerState::Data { .. })
    }

    /// The usual case: an exchange with as many inputs as there should be, and nothing to be told. Whether it was that.
    #[inline]
    pub(super) fn accept_inputs(
        &mut self,
        ask: CyclicRequest,
        confirmation: &Confirmation<'_>,
        at: BitTime,
        asked: BitTime,
    ) -> bool {
        let (HandlerState::Data { diag: false }, CyclicRequest::DataExch, Confirmation::Answer(answer)) =
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
        self.exchange_succeeded(diag, at);
        self.enforce_min_interval(asked);
        true
    }

    /// profibus-wire 2.8, master rules; without the usual case, [`took_inputs`](Self::took_inputs).
    fn exchanged(&mut self, answer: &Answer<'_>, context: &mut Context<'_>) {
        self.count_retries(answer);
        match answer.status {
            Status::DataLow | Status::DataHigh | Status::NoReply => {
                let (expected, received) = (usize::from(self.lengths.inputs), answer.du.len());
                self.restart(ExchangeError::Length { expected, received }, context);
            }
            Status::ServiceNotActivated => self.restart(ExchangeError::Refused(answer.status), context),
            status => self.refused(status, context),
        }
    }

    /// An exchange was good: whatever went wrong before is over.
    #[inline]
    fn exchange_succeeded(&mut self, diag: bool, now: BitTime) {
        self.state = HandlerState::Data { diag };
        self.counters.exchanges = self.counters.exchanges.wrapping_add(1);
        self.misses = 0;
        self.error = None;
        self.exchanged = Some(now);
    }

    /// No data this time. Again and again, and the slave is started anew.
    fn refused(&mut self, status: Status, context: &mut Context<'_>) {
        self.misses = self.misses.saturating_add(1);
        if self.misses >= context.settings.miss_limit {
            self.restart(ExchangeError::Refused(status), context);
        }
    }

    /// No valid answer, after all repetitions.
    fn no_answer(&mut self, failure: Failure, context: &mut Context<'_>) {
        if self.state == HandlerState::Offline {
            self.report(ExchangeError::NoAnswer(failure), context);
            return self.back_off.failed(context.now, context.settings);
        }
        self.counters.lost = self.counters.lost.wrapping_add(1);
        self.misses = self.misses.saturating_add(1);
        if self.misses >= context.settings.miss_limit {
            let next = if self.state == HandlerState::Release { HandlerState::Inactive } else { HandlerState::Offline };
            self.report(ExchangeError::NoAnswer(failure), context);
            self.enter(next, context);
            self.back_off.failed(context.now, context.settings);
        } else if let Failure::Mismatch(_) = failure {
            self.report(ExchangeError::NoAnswer(failure), context);
        }
    }

    /// Set_Prm and Chk_Cfg are answered by SC, right or wrong; the diagnosis tells.
    fn acknowledged(&mut self, answer: &Answer<'_>, next: HandlerState, context: &mut Context<'_>) {
        self.count_retries(answer);
        match answer.status {
            Status::NoReply => self.enter(next, context),
            status => self.restart(ExchangeError::Refused(status), context),
        }
    }

    /// Back to the first diagnosis, at once if exchange was good before, after a growing pause otherwise.
    pub(super) fn restart(&mut self, trouble: ExchangeError, context: &mut Context<'_>) {
        self.report(trouble, context);
        self.enter(HandlerState::Diag1, context);
        self.back_off.failed(context.now, context.settings);
    }

    pub(super) fn count_retries(&mut self, answer: &Answer<'_>) {
        self.counters.retries = self.counters.retries.wrapping_add(answer.retries.into());
    }

    pub(super) fn report(&mut self, trouble: ExchangeError, context: &mut Context<'_>) {
        if self.error != Some(trouble) {
            self.error = Some(trouble);
            self.push_event(EventKind::Trouble(trouble), context);
        }
    }

    /// The only place where a state is entered that was not before.
    pub(super) fn enter(&mut self, state: HandlerState, context: &mut Context<'_>) {
        let is = matches!(state, HandlerState::Data { .. });
        match (matches!(self.state, HandlerState::Data { .. }), is) {
            (false, true) => {
                *context.exchanging = context.exchanging.saturating_add(1);
                *context.control_due = true;
                self.back_off.exchange_began(context.now);
            }
            (true, false) => {
                *context.exchanging = context.exchanging.saturating_sub(1);
                context.change = Change::LeftExchange;
            }
            (true, true) | (false, false) => {}
        }
        self.exchanged = self.exchanged.filter(|_| is);
        self.stray_reported &= state != HandlerState::Offline;
        self.misses = 0;
        self.back_off.clear_pause(context.now);
        if self.leaving && state == HandlerState::Inactive {
            context.change = Change::Released;
        }
        if self.state != state {
            self.state = state;
            self.push_event(EventKind::Entered(state), context);
        }
    }

    pub(super) fn push_event(&self, kind: EventKind, context: &mut Context<'_>) {
        context.events.push(Event { at: context.now, address: self.address, kind });
    }
}

fn copied<const OCTETS: usize>(
    what: &'static str,
    octets: &[u8],
    room: usize,
) -> Result<Vec<u8, OCTETS>, SlaveListError> {
    fits(what, octets.len(), room)?;
    Vec::from_slice(octets).map_err(|_| SlaveListError::TooLong { what, octets: octets.len(), room })
}

const fn fits(what: &'static str, octets: usize, room: usize) -> Result<(), SlaveListError> {
    if octets <= room { Ok(()) } else { Err(SlaveListError::TooLong { what, octets, room }) }
}
