//! The acyclic requests of a master, and the parameter channel: who is asked next, and what became of it.
//!
//! A request is handed in and gets a [`Handle`]; its [`Outcome`] waits until it is taken. [`Notice`]s in the event queue say
//! that one waits. MS1 and MS2 are messages of low priority, one after the other in turn; the parameter channel needs no
//! messages of its own. Nothing here knows a slave: the master says which ones exchange data.

mod outcome;
mod pool;
mod response;
mod transaction;

pub use outcome::{Cause, ConnectionEnd, Outcome, SubmitError};
use pool::Pool;
pub(super) use pool::Pooled;
pub use pool::{Handle, Service};
pub(super) use response::ExpectedResponse;
pub use response::ResponseMismatch;
pub(super) use transaction::{Progress, Stage, Timeouts, Transaction};

use super::event::{Event, EventKind, Sink};
use super::{ms1, ms2, pkw};
use crate::link::BitTime;
use crate::link::active::{Confirmation, Request};
use profivac_wire::acyclic::Request as Pdu;

/// What an event says about a handle.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum AcyclicEvent {
    /// An outcome can be taken.
    OutcomeReady,
    /// The MS2 connection is gone.
    Ended(ConnectionEnd),
}

/// How a slave stands in data exchange.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct ExchangeStatus {
    /// How often it has come there.
    pub(super) starts: u32,
    /// It is sent its outputs, and not zeros.
    pub(super) operating: bool,
}

/// The next one to be asked for a message: first the connections of MS2, then the jobs of MS1.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct QueueIndex(usize);

/// Up to `PLACES` connections of MS2, as many jobs of MS1 and as many instructions in parameter channels.
#[derive(Clone, Debug)]
pub(super) struct Acyclic<const PLACES: usize> {
    pub(super) ms2: Pool<ms2::Connection, PLACES>,
    pub(super) ms1: Pool<ms1::Ms1Request, PLACES>,
    pub(super) pkw: Pool<pkw::PkwTask, PLACES>,
    /// Nothing was ever handed in: a master that only exchanges data pays nothing.
    idle: bool,
    turn: usize,
    /// A slave with which MS1 is out of step.
    late: Option<u8>,
}

impl<const PLACES: usize> Acyclic<PLACES> {
    pub(super) const fn new() -> Self {
        Self { ms2: Pool::new(), ms1: Pool::new(), pkw: Pool::new(), idle: true, turn: 0, late: None }
    }

    pub(super) fn open(&mut self, address: u8, parameters: &ms2::Ms2Parameters) -> Result<Handle, SubmitError> {
        self.idle = false;
        let full = SubmitError::Full { places: PLACES };
        self.ms2.insert(ms2::Connection::new(address, parameters)).ok_or(full)
    }

    pub(super) fn submit(
        &mut self,
        connection: Handle,
        expected: ExpectedResponse,
        octets: usize,
        pdu: &Pdu<'_>,
    ) -> Result<(), SubmitError> {
        self.ms2.get_mut(connection).ok_or(SubmitError::UnknownHandle)?.submit(expected, octets, pdu)
    }

    pub(super) fn ms1(&mut self, job: ms1::Ms1Request) -> Result<Handle, SubmitError> {
        self.idle = false;
        let is_same = |other: &ms1::Ms1Request| other.address() == job.address() && !other.is_over();
        if self.ms1.iter().any(is_same) {
            return Err(SubmitError::Busy);
        }
        self.ms1.insert(job).ok_or(SubmitError::Full { places: PLACES })
    }

    pub(super) fn pkw(&mut self, job: pkw::PkwTask) -> Result<Handle, SubmitError> {
        self.idle = false;
        let is_same = |other: &pkw::PkwTask| other.address() == job.address() && !other.is_over();
        if self.pkw.iter().any(is_same) {
            return Err(SubmitError::Busy);
        }
        self.pkw.insert(job).ok_or(SubmitError::Full { places: PLACES })
    }

    /// The outcome behind a handle, once. The last one uses the handle up.
    pub(super) fn outcome(&mut self, handle: Handle) -> Option<Outcome<'_>> {
        match handle.service() {
            Service::Ms2 => match self.ms2.get(handle)?.ended() {
                Some(end) => {
                    self.ms2.remove(handle);
                    Some(Outcome::Ended(end))
                }
                None => self.ms2.get_mut(handle)?.outcome(),
            },
            Service::Ms1 => self.ms1.get_mut(handle)?.outcome(),
            Service::Pkw => {
                let outcome = self.pkw.get(handle)?.outcome()?;
                self.pkw.remove(handle);
                Some(outcome)
            }
        }
    }

    /// Whether nothing more will become of it. What nobody holds is over.
    pub(super) fn is_over(&self, handle: Handle) -> bool {
        match handle.service() {
            Service::Ms2 => self.ms2.get(handle).is_none_or(Pooled::is_over),
            Service::Ms1 => self.ms1.get(handle).is_none_or(Pooled::is_over),
            Service::Pkw => self.pkw.get(handle).is_none_or(Pooled::is_over),
        }
    }

    /// Time has come to `now`. `stands` tells of a slave in data exchange how it stands there.
    pub(super) fn elapse(
        &mut self,
        now: BitTime,
        stands: impl Fn(u8) -> Option<ExchangeStatus>,
        events: &mut Sink<'_>,
    ) {
        if self.idle {
            return;
        }
        for number in 0..PLACES {
            self.elapse_ms2(now, number, events);
            self.elapse_ms1(now, number, &stands, events);
            self.elapse_pkw(now, number, &stands, events);
        }
    }

    fn elapse_ms2(&mut self, now: BitTime, number: usize, events: &mut Sink<'_>) {
        let notice = self.ms2.at(number).and_then(|it| Some((it.address(), it.elapse(now)?)));
        tell(now, self.ms2.handle(number), notice, events);
    }

    fn elapse_ms1(
        &mut self,
        now: BitTime,
        number: usize,
        stands: impl Fn(u8) -> Option<ExchangeStatus>,
        events: &mut Sink<'_>,
    ) {
        let Some(job) = self.ms1.at(number) else { return };
        let notice = match stands(job.address()) {
            Some(ExchangeStatus { starts, .. }) if starts == job.starts() => job.elapse(now),
            _ => job.fail(Cause::Left),
        };
        if notice.is_some() && job.is_late() {
            self.late = Some(job.address());
        }
        let notice = notice.map(|notice| (job.address(), notice));
        tell(now, self.ms1.handle(number), notice, events);
    }

    fn elapse_pkw(
        &mut self,
        now: BitTime,
        number: usize,
        stands: impl Fn(u8) -> Option<ExchangeStatus>,
        events: &mut Sink<'_>,
    ) {
        let Some(job) = self.pkw.at(number) else { return };
        let notice = match stands(job.address()) {
            Some(ExchangeStatus { starts, operating: true }) if starts == job.starts() => None,
            Some(ExchangeStatus { operating: false, .. }) => job.fail(Cause::NotOperating),
            _ => job.fail(Cause::Left),
        };
        let notice = notice.map(|notice| (job.address(), notice));
        tell(now, self.pkw.handle(number), notice, events);
    }

    /// The slave that MS1 is out of step with, once.
    pub(super) const fn take_late(&mut self) -> Option<u8> {
        self.late.take()
    }

    /// Whose turn it is to send a message.
    pub(super) fn due(&mut self, now: BitTime) -> Option<QueueIndex> {
        if self.idle {
            return None;
        }
        let all = PLACES.saturating_mul(2);
        let from = self.turn;
        let turn = (from..all).chain(0..from).find(|turn| self.is_due(*turn, now))?;
        self.turn = turn.saturating_add(1);
        Some(QueueIndex(turn))
    }

    fn is_due(&mut self, turn: usize, now: BitTime) -> bool {
        match turn.checked_sub(PLACES) {
            None => self.ms2.at(turn).is_some_and(|connection| connection.is_due(now)),
            Some(number) => self.ms1.at(number).is_some_and(|job| job.is_due(now)),
        }
    }

    /// The message of this turn.
    pub(super) fn message(&mut self, turn: QueueIndex) -> Option<Request<'_>> {
        match turn.0.checked_sub(PLACES) {
            None => self.ms2.at(turn.0)?.message(),
            Some(number) => self.ms1.at(number)?.message(),
        }
    }

    /// What became of it.
    pub(super) fn confirmed(
        &mut self,
        turn: QueueIndex,
        now: BitTime,
        confirmation: Confirmation<'_>,
        events: &mut Sink<'_>,
    ) {
        match turn.0.checked_sub(PLACES) {
            None => {
                let notice = self.ms2.at(turn.0).and_then(|it| Some((it.address(), it.confirmed(now, confirmation)?)));
                tell(now, self.ms2.handle(turn.0), notice, events);
            }
            Some(number) => {
                let Some(job) = self.ms1.at(number) else { return };
                let notice = job.confirmed(now, confirmation).map(|notice| (job.address(), notice));
                if notice.is_some() && job.is_late() {
                    self.late = Some(job.address());
                }
                tell(now, self.ms1.handle(number), notice, events);
            }
        }
    }

    /// Whether nothing was ever handed in. Then none of the other functions has anything to do.
    #[inline]
    pub(super) const fn is_idle(&self) -> bool {
        self.idle
    }

    /// The outputs of a slave as they are to be sent: with an instruction under way a copy in `du` with the channel put in.
    /// The image itself stays the user's.
    #[inline(never)]
    pub(super) fn with_channel<'a>(&mut self, address: u8, outputs: &'a [u8], du: &'a mut [u8]) -> &'a [u8] {
        let job = self.pkw.iter_mut().find(|job| job.address() == address && !job.is_over());
        let (Some(job), Some(copy)) = (job, du.get_mut(..outputs.len())) else { return outputs };
        copy.copy_from_slice(outputs);
        job.put(copy);
        copy
    }

    /// A slave has answered with these inputs.
    pub(super) fn exchanged(&mut self, now: BitTime, address: u8, inputs: &[u8], events: &mut Sink<'_>) {
        for number in 0..PLACES {
            let job = self.pkw.at(number).filter(|job| job.address() == address);
            let notice = job.and_then(|job| job.exchanged(inputs));
            tell(now, self.pkw.handle(number), notice.map(|notice| (address, notice)), events);
        }
    }
}

fn tell(at: BitTime, handle: Option<Handle>, notice: Option<(u8, AcyclicEvent)>, events: &mut Sink<'_>) {
    if let (Some(handle), Some((address, notice))) = (handle, notice) {
        events.push(Event { at, address, kind: EventKind::Acyclic(handle, notice) });
    }
}
