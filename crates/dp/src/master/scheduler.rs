//! The acyclic requests of a master: the next message among them, and its confirmation.
//!
//! The user submits a request and gets a [`Handle`]; the outcome waits until the user takes it. An [`AcyclicEvent`] in the
//! event queue announces it. MS1 and MS2 send messages of low priority, one after the other in turn; the parameter channel
//! needs no messages of its own. The scheduler knows no slaves: the master passes it the state of those that exchange data.

use super::acyclic::{
    AcyclicEvent, AcyclicId, ConnectionEnd, ExpectedResponse, Handle, Key, Pool, Pooled, Service, SubmitError,
};
use super::event::{Event, EventKind, Sink};
use super::ms1::{self, Ms1Request};
use super::ms2::{self, Connection, Ms2Parameters, Opened};
use super::pkw::{self, PkwTask, TaskError};
use crate::link::BitTime;
use crate::link::active::{Confirmation, Request};
use profivac_wire::acyclic::Request as Pdu;

/// An acyclic operation. [`Handle<O>`](Handle) names one, and [`Master::outcome`](super::Master::outcome) returns its
/// outcome.
///
/// Implemented by the types in [`ms1`], [`ms2`] and [`pkw`] only.
pub trait Operation: Sized {
    /// The type of the outcome.
    type Outcome<'a>;

    #[doc(hidden)]
    const SERVICE: Service;

    #[doc(hidden)]
    fn take<const SLOTS: usize>(scheduler: &mut Scheduler<SLOTS>, handle: Handle<Self>) -> Option<Self::Outcome<'_>>;

    #[doc(hidden)]
    fn is_over<const SLOTS: usize>(scheduler: &Scheduler<SLOTS>, handle: Handle<Self>) -> bool;
}

impl<O: Operation> Handle<O> {
    /// The identification in events. The requests of an MS2 connection have that of the connection.
    #[must_use]
    pub const fn id(self) -> AcyclicId {
        AcyclicId::new(O::SERVICE, self.key)
    }
}

/// The operations of MS1, whose outcomes differ in the type of the value only.
macro_rules! ms1_operation {
    ($operation:ty, $value:ty, $of:expr) => {
        impl Operation for $operation {
            type Outcome<'a> = Result<$value, ms1::RequestError>;
            const SERVICE: Service = Service::Ms1;

            fn take<const SLOTS: usize>(
                scheduler: &mut Scheduler<SLOTS>,
                handle: Handle<Self>,
            ) -> Option<Self::Outcome<'_>> {
                scheduler.ms1.get_mut(handle.key)?.take_outcome().map(|outcome| outcome.map($of))
            }

            fn is_over<const SLOTS: usize>(scheduler: &Scheduler<SLOTS>, handle: Handle<Self>) -> bool {
                scheduler.ms1.get(handle.key).is_none_or(Pooled::is_over)
            }
        }
    };
}

ms1_operation!(ms1::Read, &'a [u8], |record| record);
ms1_operation!(ms1::Write, (), drop);
ms1_operation!(ms1::AcknowledgeAlarm, (), drop);

/// The requests of MS2, whose outcomes differ in the type of the value only.
macro_rules! ms2_operation {
    ($operation:ty, $value:ty, $of:expr) => {
        impl Operation for $operation {
            type Outcome<'a> = Result<$value, ms2::RequestError>;
            const SERVICE: Service = Service::Ms2;

            fn take<const SLOTS: usize>(
                scheduler: &mut Scheduler<SLOTS>,
                handle: Handle<Self>,
            ) -> Option<Self::Outcome<'_>> {
                scheduler.take_ms2(handle.key, handle.request).map(|outcome| outcome.map($of))
            }

            fn is_over<const SLOTS: usize>(scheduler: &Scheduler<SLOTS>, handle: Handle<Self>) -> bool {
                let connection = scheduler.ms2.get(handle.key);
                connection.is_none_or(|connection| connection.is_over() || !connection.is_running(handle.request))
            }
        }
    };
}

ms2_operation!(ms2::Read, &'a [u8], |record| record);
ms2_operation!(ms2::Write, (), drop);
ms2_operation!(ms2::Transport, &'a [u8], |data| data);

impl Operation for ms2::Connect {
    type Outcome<'a> = Result<Opened, ConnectionEnd>;
    const SERVICE: Service = Service::Ms2;

    fn take<const SLOTS: usize>(scheduler: &mut Scheduler<SLOTS>, handle: Handle<Self>) -> Option<Self::Outcome<'_>> {
        let connection = scheduler.ms2.get_mut(handle.key)?;
        if let Some(opened) = connection.take_opened() {
            return Some(Ok(opened));
        }
        let end = connection.ended()?;
        scheduler.ms2.remove(handle.key);
        Some(Err(end))
    }

    fn is_over<const SLOTS: usize>(scheduler: &Scheduler<SLOTS>, handle: Handle<Self>) -> bool {
        scheduler.ms2.get(handle.key).is_none_or(Pooled::is_over)
    }
}

impl Operation for pkw::Task {
    type Outcome<'a> = Result<pkw::Value, TaskError>;
    const SERVICE: Service = Service::Pkw;

    fn take<const SLOTS: usize>(scheduler: &mut Scheduler<SLOTS>, handle: Handle<Self>) -> Option<Self::Outcome<'_>> {
        let outcome = scheduler.pkw.get(handle.key)?.outcome()?;
        scheduler.pkw.remove(handle.key);
        Some(outcome)
    }

    fn is_over<const SLOTS: usize>(scheduler: &Scheduler<SLOTS>, handle: Handle<Self>) -> bool {
        scheduler.pkw.get(handle.key).is_none_or(Pooled::is_over)
    }
}

/// The state of a slave in data exchange.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct ExchangeStatus {
    /// How often the slave has entered data exchange.
    pub(super) starts: u32,
    /// The master sends the slave its outputs, and not zeros.
    pub(super) operating: bool,
}

/// A place in the queue for messages: a slot of MS2 or of MS1.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum QueueIndex {
    Ms2(usize),
    Ms1(usize),
}

/// Up to `SLOTS` connections of MS2, as many requests of MS1 and as many tasks in parameter channels.
#[derive(Clone, Debug)]
pub struct Scheduler<const SLOTS: usize> {
    pub(super) ms2: Pool<Connection, SLOTS>,
    ms1: Pool<Ms1Request, SLOTS>,
    pkw: Pool<PkwTask, SLOTS>,
    /// The user has submitted nothing yet, so a master that only exchanges data skips all work here.
    idle: bool,
    /// The place in the queue that is considered first.
    first: usize,
    /// The slaves that may still respond to an MS1 request that has failed: one bit for each address.
    late: u128,
    /// The slaves that have no MS2 connection of this station address left, as a search has shown: one bit for each address.
    clean: u128,
}

impl<const SLOTS: usize> Scheduler<SLOTS> {
    pub(super) const fn new() -> Self {
        Self { ms2: Pool::new(), ms1: Pool::new(), pkw: Pool::new(), idle: true, first: 0, late: 0, clean: 0 }
    }

    pub(super) fn open(
        &mut self,
        address: u8,
        parameters: &Ms2Parameters,
    ) -> Result<Handle<ms2::Connect>, SubmitError> {
        self.idle = false;
        let searches = self.clean & bit(address) == 0;
        named(self.ms2.insert(Connection::new(address, parameters, searches)), SLOTS)
    }

    /// Submits a request on a connection; `octets` is the length of the record.
    pub(super) fn submit_ms2<O: Operation>(
        &mut self,
        connection: Handle<ms2::Connect>,
        expected: ExpectedResponse,
        octets: usize,
        pdu: &Pdu<'_>,
    ) -> Result<Handle<O>, SubmitError> {
        let number =
            self.ms2.get_mut(connection.key).ok_or(SubmitError::UnknownHandle)?.submit(expected, octets, pdu)?;
        Ok(Handle::new(connection.key, number))
    }

    /// The outcome of a request on a connection. If the connection has ended its slot becomes free.
    fn take_ms2(&mut self, key: Key, number: u32) -> Option<Result<&[u8], ms2::RequestError>> {
        let connection = self.ms2.get(key).filter(|connection| connection.has_request(number))?;
        if let Some(end) = connection.ended() {
            let is_delivered = connection.is_delivered();
            self.ms2.remove(key);
            let error = if is_delivered { ms2::RequestError::Ended } else { ms2::RequestError::NotExecuted };
            return Some(Err(error(end)));
        }
        let outcome = self.ms2.get_mut(key)?.take_outcome()?;
        Some(outcome.map_err(ms2::RequestError::Refused))
    }

    pub(super) fn submit_ms1<O: Operation>(&mut self, request: Ms1Request) -> Result<Handle<O>, SubmitError> {
        self.idle = false;
        if self.ms1.iter().any(|other| other.address() == request.address() && !other.is_over()) {
            return Err(SubmitError::Busy);
        }
        named(self.ms1.insert(request), SLOTS)
    }

    pub(super) fn submit_pkw(&mut self, task: PkwTask) -> Result<Handle<pkw::Task>, SubmitError> {
        self.idle = false;
        if self.pkw.iter().any(|other| other.address() == task.address() && !other.is_over()) {
            return Err(SubmitError::Busy);
        }
        named(self.pkw.insert(task), SLOTS)
    }

    /// Advances the time of the MS2 connections to `now`.
    #[inline]
    pub(super) fn elapse_connections(&mut self, now: BitTime, events: &mut Sink<'_>) {
        let (shared, searched) = (self.shared(), self.searched());
        for (key, connection) in self.ms2.entries() {
            let address = connection.address();
            // Its time begins when it may send.
            if searched & bit(address) != 0 && connection.waits_for_search() {
                continue;
            }
            if let Some(event) = connection.elapse(now, shared & bit(address) == 0) {
                note_leftover(&mut self.clean, connection);
                push(now, address, AcyclicId::new(Service::Ms2, key), event, events);
            }
        }
    }

    /// The slaves to which this master has several connections: one bit for each address.
    fn shared(&self) -> u128 {
        let connections = self.ms2.iter().filter(|connection| !connection.is_over());
        let (_, shared) = connections.fold((0, 0), |(once, twice), connection| {
            let bit = bit(connection.address());
            (once | bit, twice | (once & bit))
        });
        shared
    }

    /// The slaves at which a connection searches: one bit for each address.
    fn searched(&self) -> u128 {
        let searching = self.ms2.iter().filter(|connection| connection.is_searching());
        searching.fold(0, |bits, connection| bits | bit(connection.address()))
    }

    /// Whether the user has ever submitted a request that belongs to a data exchange: MS1 or the parameter channel.
    #[inline]
    pub(super) const fn has_class_1(&self) -> bool {
        self.ms1.used() > 0 || self.pkw.used() > 0
    }

    /// Advances the time of the MS1 requests and tasks to `now`. `status` gives the state of a slave that exchanges data.
    pub(super) fn elapse_class_1(
        &mut self,
        now: BitTime,
        status: impl Fn(u8) -> Option<ExchangeStatus>,
        events: &mut Sink<'_>,
    ) {
        self.elapse_ms1(now, &status, events);
        self.elapse_pkw(now, &status, events);
    }

    fn elapse_ms1(&mut self, now: BitTime, status: impl Fn(u8) -> Option<ExchangeStatus>, events: &mut Sink<'_>) {
        for (key, request) in self.ms1.entries() {
            let event = match status(request.address()) {
                Some(ExchangeStatus { starts, .. }) if starts == request.starts() => request.elapse(now),
                _ => request.left_exchange(),
            };
            if let Some(event) = event {
                self.late |= late(request);
                push(now, request.address(), AcyclicId::new(Service::Ms1, key), event, events);
            }
        }
    }

    fn elapse_pkw(&mut self, now: BitTime, status: impl Fn(u8) -> Option<ExchangeStatus>, events: &mut Sink<'_>) {
        for (key, task) in self.pkw.entries() {
            let event = match status(task.address()) {
                Some(ExchangeStatus { starts, operating: true }) if starts == task.starts() => None,
                Some(ExchangeStatus { operating: false, .. }) => task.fail(TaskError::NotOperating),
                _ => task.fail(TaskError::LeftExchange),
            };
            if let Some(event) = event {
                push(now, task.address(), AcyclicId::new(Service::Pkw, key), event, events);
            }
        }
    }

    /// One of the slaves that may still respond to a failed MS1 request; each once.
    #[inline]
    pub(super) fn take_late(&mut self) -> Option<u8> {
        if self.late == 0 { None } else { self.take_next_late() }
    }

    /// Kept out of the cycle: it is rare.
    #[cold]
    fn take_next_late(&mut self) -> Option<u8> {
        let address = self.late.trailing_zeros();
        self.late ^= 1_u128.checked_shl(address)?;
        u8::try_from(address).ok()
    }

    /// The place in the queue that sends the next message: first the slots of MS2, then those of MS1, in turn.
    pub(super) fn due(&mut self, now: BitTime) -> Option<QueueIndex> {
        if self.idle {
            return None;
        }
        let ms2 = self.ms2.used();
        let all = ms2.saturating_add(self.ms1.used());
        let first = self.first.min(all);
        let index_of = |turn: usize| turn.checked_sub(ms2).map_or(QueueIndex::Ms2(turn), QueueIndex::Ms1);
        let turn = (first..all).chain(0..first).find(|turn| self.is_due(index_of(*turn), now))?;
        self.first = turn.saturating_add(1);
        Some(index_of(turn))
    }

    fn is_due(&mut self, index: QueueIndex, now: BitTime) -> bool {
        match index {
            QueueIndex::Ms2(number) => {
                // A new connection waits until a search at its slave is over, which could end it.
                let searched = self.searched();
                let may_send = |connection: &mut Connection| {
                    connection.is_due(now) && (connection.is_searching() || searched & bit(connection.address()) == 0)
                };
                self.ms2.at(number).is_some_and(may_send)
            }
            QueueIndex::Ms1(number) => self.ms1.at(number).is_some_and(|request| request.is_due(now)),
        }
    }

    /// The message at this place in the queue.
    pub(super) fn message(&mut self, index: QueueIndex) -> Option<Request<'_>> {
        match index {
            QueueIndex::Ms2(number) => self.ms2.at(number)?.message(),
            QueueIndex::Ms1(number) => self.ms1.at(number)?.message(),
        }
    }

    /// Evaluates the confirmation of that message.
    pub(super) fn confirmed(
        &mut self,
        index: QueueIndex,
        now: BitTime,
        confirmation: Confirmation<'_>,
        events: &mut Sink<'_>,
    ) {
        match index {
            QueueIndex::Ms2(number) => {
                let shared = self.shared();
                let Some((key, connection)) = self.ms2.entry(number) else { return };
                let is_alone = shared & bit(connection.address()) == 0;
                if let Some(event) = connection.confirmed(now, confirmation, is_alone) {
                    note_leftover(&mut self.clean, connection);
                    push(now, connection.address(), AcyclicId::new(Service::Ms2, key), event, events);
                }
            }
            QueueIndex::Ms1(number) => {
                let Some((key, request)) = self.ms1.entry(number) else { return };
                if let Some(event) = request.confirmed(now, confirmation) {
                    self.late |= late(request);
                    push(now, request.address(), AcyclicId::new(Service::Ms1, key), event, events);
                }
            }
        }
    }

    /// Whether the user has never submitted anything. Then none of the other functions has anything to do.
    #[inline]
    pub(super) const fn is_idle(&self) -> bool {
        self.idle
    }

    /// The outputs of a slave as they are sent: with a task under way, a copy in `du` that has the channel filled in. The
    /// image itself belongs to the user.
    #[inline(never)]
    pub(super) fn with_channel<'a>(&mut self, address: u8, outputs: &'a [u8], du: &'a mut [u8]) -> &'a [u8] {
        let task = self.pkw.iter_mut().find(|task| task.address() == address && !task.is_over());
        let (Some(task), Some(copy)) = (task, du.get_mut(..outputs.len())) else { return outputs };
        copy.copy_from_slice(outputs);
        task.put(copy);
        copy
    }

    /// Evaluates the inputs of a slave.
    pub(super) fn exchanged(&mut self, now: BitTime, address: u8, inputs: &[u8], events: &mut Sink<'_>) {
        for (key, task) in self.pkw.entries().filter(|(_, task)| task.address() == address) {
            if let Some(event) = task.exchanged(inputs) {
                push(now, address, AcyclicId::new(Service::Pkw, key), event, events);
            }
        }
    }
}

/// The handle of a slot that was found.
fn named<O>(key: Option<Key>, slots: usize) -> Result<Handle<O>, SubmitError> {
    key.map(|key| Handle::new(key, 0)).ok_or(SubmitError::Full { slots })
}

/// The bit of an address.
fn bit(address: u8) -> u128 {
    1_u128.checked_shl(address.into()).unwrap_or_default()
}

/// The bit of a slave that may still respond to this failed request.
fn late(request: &Ms1Request) -> u128 {
    if request.may_respond_late() { bit(request.address()) } else { 0 }
}

/// Notes what a connection says about the slave: whether a connection of this master may be left there.
fn note_leftover(clean: &mut u128, connection: &Connection) {
    match connection.leftover() {
        Some(true) => *clean &= !bit(connection.address()),
        Some(false) => *clean |= bit(connection.address()),
        None => {}
    }
}

fn push(at: BitTime, address: u8, id: AcyclicId, event: AcyclicEvent, events: &mut Sink<'_>) {
    events.push(Event { at, address, kind: EventKind::Acyclic(id, event) });
}
