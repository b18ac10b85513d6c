//! The handler of one slave in its class 1 master. profibus-wire 3.10.
//!
//! The state determines the next request ([`Handler::next_request`]), its answer the next state ([`Handler::confirmed`]). Every
//! slave gets at most one request per cycle, so a faulty slave costs the others no more time than a working one.

mod backoff;
mod diagnosis;

use super::event::{Event, EventKind, ExchangeError, Sink};
use super::parameters::{Settings, SlaveData, SlaveListError, SlaveParameters};
use super::state::{Counters, CyclicRequest, HandlerState};
use crate::link::BitTime;
use crate::link::active::{Answer, Confirmation, Failure};
use backoff::BackOff;
use diagnosis::Diagnosis;
use heapless::Vec;
use profivac_wire::cfg::{self, Lengths};
use profivac_wire::control::Status;
use profivac_wire::prm::{PrmStatus, SetPrm};

/// The longest User_Prm_Data: 244 octets without the seven fixed ones.
const MAX_USER_PRM: usize = 237;

/// A change that the master must react to.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Change {
    Nothing,
    /// The slave has left data exchange, because of a fault or because the user released it.
    LeftExchange,
    /// The slave was released and is to be removed.
    Released,
}

/// The data of the master that a handler needs.
pub(super) struct Context<'a> {
    pub(super) now: BitTime,
    /// TS.
    pub(super) address: u8,
    pub(super) settings: &'a Settings,
    pub(super) events: Sink<'a>,
    /// The number of slaves that exchange data.
    pub(super) exchanging: &'a mut usize,
    /// The mode of the master must be sent to the slaves.
    pub(super) control_due: &'a mut bool,
    /// When the request was sent that is being confirmed.
    pub(super) requested_at: BitTime,
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
    /// The number of message cycles in a row that failed.
    pub(super) misses: u8,
    back_off: BackOff,
    /// The slave is removed once it is inactive.
    leaving: bool,
    /// A stray answer was reported.
    stray_reported: bool,
    error: Option<ExchangeError>,
    diagnosis: Option<Diagnosis<OCTETS>>,
    pub(super) counters: Counters,
    /// When the inputs came; `None` unless they are from the present data exchange.
    exchanged: Option<BitTime>,
    inputs: [u8; OCTETS],
    outputs: [u8; OCTETS],
}

impl<const OCTETS: usize> Handler<OCTETS> {
    pub(super) fn new(parameters: &SlaveParameters<'_>) -> Result<Self, SlaveListError> {
        let lengths = cfg::lengths(parameters.cfg).map_err(SlaveListError::Cfg)?;
        fits(SlaveData::Inputs, lengths.inputs.into(), OCTETS)?;
        fits(SlaveData::Outputs, lengths.outputs.into(), OCTETS)?;
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
            cfg: copied(SlaveData::Configuration, parameters.cfg, OCTETS)?,
            user_prm: copied(SlaveData::UserParameters, parameters.user_prm, OCTETS.min(MAX_USER_PRM))?,
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

    /// The number of zeros that Clear sends. profibus-wire 3.8.
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

    /// The data unit of the Set_Prm that unlocks the slave, profibus-wire 2.4.
    pub(super) const fn unlock(&self) -> SetPrm<'static> {
        SetPrm { status: PrmStatus::UNLOCK_REQ, wd_fact: [0; 2], min_tsdr: 0, ident: self.ident, group: 0, user: &[] }
    }

    /// The request to this slave in the present cycle.
    #[inline]
    pub(super) fn next_request(&self, now: BitTime) -> Option<CyclicRequest> {
        self.state.request().filter(|_| self.back_off.is_over(now))
    }

    /// Evaluates the confirmation of a request.
    pub(super) fn confirmed(
        &mut self,
        request: CyclicRequest,
        confirmation: Confirmation<'_>,
        context: &mut Context<'_>,
    ) {
        self.handle_confirmation(request, confirmation, context);
        self.enforce_min_interval(context.requested_at);
    }

    /// Min_Slave_Interval.
    #[inline]
    fn enforce_min_interval(&mut self, requested_at: BitTime) {
        if self.min_interval_tbit > 0 {
            self.back_off.not_before(requested_at + self.min_interval_tbit);
        }
    }

    fn handle_confirmation(
        &mut self,
        request: CyclicRequest,
        confirmation: Confirmation<'_>,
        context: &mut Context<'_>,
    ) {
        if self.state.request() != Some(request) {
            // The slave was released or restarted while the request was under way.
            return;
        }
        match (request, confirmation) {
            // An interruption is no failure of the slave, and every request of a handler has an answer.
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

    /// Starts or restarts the slave.
    pub(super) fn start(&mut self, context: &mut Context<'_>) {
        self.enter(HandlerState::Offline, context);
        self.back_off.reset(context.now + self.min_interval_tbit);
        self.leaving = false;
        self.error = None;
    }

    /// Releases the slave, with an unlock if this master may own it.
    pub(super) fn release(&mut self, context: &mut Context<'_>) {
        match self.state {
            HandlerState::Offline | HandlerState::Diag1 => self.enter(HandlerState::Inactive, context),
            HandlerState::Prm | HandlerState::Cfg | HandlerState::Diag2 { .. } | HandlerState::Data { .. } => {
                self.enter(HandlerState::Release, context)
            }
            HandlerState::Release | HandlerState::Inactive => {}
        }
    }

    /// Releases the slave and removes it afterwards.
    pub(super) fn remove(&mut self, context: &mut Context<'_>) {
        self.leaving = true;
        self.release(context);
    }

    /// Takes over other parameters; counters, pauses and diagnosis stay.
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

    /// Assigns the slave to other groups.
    pub(super) fn set_group(&mut self, group: u8, context: &mut Context<'_>) {
        self.group = group;
        self.parameterise(context);
    }

    /// Parameterises the slave again if it was parameterised before.
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

    /// The slave has sent an answer without a request.
    pub(super) fn stray_answer(&mut self, context: &mut Context<'_>) {
        self.counters.strays = self.counters.strays.saturating_add(1);
        if !core::mem::replace(&mut self.stray_reported, true) {
            self.push_event(EventKind::Stray, context);
        }
    }

    /// Reports that the master goes to Clear because of this slave.
    pub(super) fn auto_clear(&self, context: &mut Context<'_>) {
        self.push_event(EventKind::AutoClear, context);
    }

    pub(super) const fn is_exchanging(&self) -> bool {
        self.state.is_exchanging()
    }

    /// The usual case, an exchange with inputs of the right length and nothing to report. Returns whether it was that.
    #[inline]
    pub(super) fn accept_inputs(
        &mut self,
        request: CyclicRequest,
        confirmation: &Confirmation<'_>,
        at: BitTime,
        requested_at: BitTime,
    ) -> bool {
        let (HandlerState::Data { diag: false }, CyclicRequest::DataExch, Confirmation::Answer(answer)) =
            (self.state, request, confirmation)
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
        self.count_repetitions(answer);
        self.exchange_succeeded(diag, at);
        self.enforce_min_interval(requested_at);
        true
    }

    /// profibus-wire 2.8, master rules; without the usual case, [`accept_inputs`](Self::accept_inputs).
    fn exchanged(&mut self, answer: &Answer<'_>, context: &mut Context<'_>) {
        self.count_repetitions(answer);
        match answer.status {
            Status::DataLow | Status::DataHigh | Status::NoReply => {
                let (expected, received) = (usize::from(self.lengths.inputs), answer.du.len());
                self.restart(ExchangeError::Length { expected, received }, context);
            }
            Status::ServiceNotActivated => self.restart(ExchangeError::Refused(answer.status), context),
            status => self.refused(status, context),
        }
    }

    /// An exchange succeeded: earlier errors are over.
    #[inline]
    fn exchange_succeeded(&mut self, diag: bool, now: BitTime) {
        self.state = HandlerState::Data { diag };
        self.counters.exchanges = self.counters.exchanges.wrapping_add(1);
        self.misses = 0;
        self.error = None;
        self.exchanged = Some(now);
    }

    /// The slave answered without data. After several such answers in a row it is restarted.
    fn refused(&mut self, status: Status, context: &mut Context<'_>) {
        self.misses = self.misses.saturating_add(1);
        if self.misses >= context.settings.miss_limit {
            self.restart(ExchangeError::Refused(status), context);
        }
    }

    /// No valid answer came, after all repetitions.
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

    /// A slave answers Set_Prm and Chk_Cfg with SC, right or wrong; the diagnosis shows the result.
    fn acknowledged(&mut self, answer: &Answer<'_>, next: HandlerState, context: &mut Context<'_>) {
        self.count_repetitions(answer);
        match answer.status {
            Status::NoReply => self.enter(next, context),
            status => self.restart(ExchangeError::Refused(status), context),
        }
    }

    /// Back to the first diagnosis, at once after a good data exchange, otherwise after a growing pause.
    pub(super) fn restart(&mut self, error: ExchangeError, context: &mut Context<'_>) {
        self.report(error, context);
        self.enter(HandlerState::Diag1, context);
        self.back_off.failed(context.now, context.settings);
    }

    pub(super) fn count_repetitions(&mut self, answer: &Answer<'_>) {
        self.counters.repetitions = self.counters.repetitions.wrapping_add(answer.repetitions.into());
    }

    pub(super) fn report(&mut self, error: ExchangeError, context: &mut Context<'_>) {
        if self.error != Some(error) {
            self.error = Some(error);
            self.push_event(EventKind::Error(error), context);
        }
    }

    /// Enters a state. This is the only place that changes from one state to another.
    pub(super) fn enter(&mut self, state: HandlerState, context: &mut Context<'_>) {
        let is = state.is_exchanging();
        match (self.state.is_exchanging(), is) {
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

fn copied<const OCTETS: usize>(data: SlaveData, octets: &[u8], room: usize) -> Result<Vec<u8, OCTETS>, SlaveListError> {
    fits(data, octets.len(), room)?;
    Vec::from_slice(octets).map_err(|_| SlaveListError::TooLong { data, octets: octets.len(), room })
}

const fn fits(data: SlaveData, octets: usize, room: usize) -> Result<(), SlaveListError> {
    if octets <= room { Ok(()) } else { Err(SlaveListError::TooLong { data, octets, room }) }
}
