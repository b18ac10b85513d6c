//! Events of a master, in one bounded queue.

use super::acyclic::{AcyclicEvent, AcyclicId};
use super::state::HandlerState;
use crate::link::BitTime;
use crate::link::active::Failure;
use core::fmt;
use heapless::deque::{Deque, DequeView};
use profivac_wire::control::Status;

/// An event of a slave.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Event {
    /// The time.
    pub at: BitTime,
    /// The address of the slave.
    pub address: u8,
    /// The kind of event.
    pub kind: EventKind,
}

/// The kind of an event.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[non_exhaustive]
pub enum EventKind {
    /// The handler has entered this state.
    Entered(HandlerState),
    /// The slave does not exchange data. Reported once, until it exchanges data or the reason changes.
    Error(ExchangeError),
    /// The diagnosis has changed.
    Diagnosis,
    /// The slave has answered twice, or late. Reported once after the slave was found, then only counted:
    /// [`Counters::strays`](super::Counters::strays).
    Stray,
    /// An event of an acyclic request or connection.
    Acyclic(AcyclicId, AcyclicEvent),
    /// The slave has left data exchange, and [`Settings::auto_clear`](super::Settings::auto_clear) has set the master to
    /// Clear.
    AutoClear,
}

impl fmt::Display for EventKind {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Entered(state) => state.fmt(f),
            Self::Error(error) => error.fmt(f),
            Self::Diagnosis => f.write_str("new diagnosis"),
            Self::Stray => f.write_str("it answered twice or late: another station may have its address"),
            Self::Acyclic(id, AcyclicEvent::OutcomeReady) => {
                write!(f, "an outcome of {} is ready", id.service())
            }
            Self::Acyclic(_, AcyclicEvent::Ended(end)) => end.fmt(f),
            Self::AutoClear => f.write_str("it left data exchange, and the master went to CLEAR"),
        }
    }
}

/// The reason why a slave does not exchange data.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[non_exhaustive]
pub enum ExchangeError {
    /// No valid answer came.
    NoAnswer(Failure),
    /// Another master owns the slave.
    Owned {
        /// Diag_Master_Add.
        master: u8,
    },
    /// The slave is another device.
    Ident {
        /// The Ident_Number expected.
        expected: u16,
        /// The Ident_Number received.
        received: u16,
    },
    /// The slave does not accept its parameters.
    PrmFault,
    /// The slave does not accept its configuration.
    CfgFault,
    /// The slave asks to be parameterised again.
    PrmReq,
    /// The slave has not become ready in time.
    NotReady,
    /// Static diagnosis: the slave has no valid process data yet.
    StaticDiag,
    /// MS1 failed, and a late response could be taken for another one: the slave is restarted.
    Ms1,
    /// The slave answers a service with this status.
    Refused(Status),
    /// The data unit of an answer has the wrong length.
    Length {
        /// The expected length in octets; the least length for a diagnosis.
        expected: usize,
        /// The received length in octets.
        received: usize,
    },
}

impl fmt::Display for ExchangeError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::NoAnswer(failure) => failure.fmt(f),
            Self::Owned { master } => write!(f, "it belongs to master {master}"),
            Self::Ident { expected, received } => {
                write!(f, "it is another device: ident number {received:04X} instead of {expected:04X}")
            }
            Self::PrmFault => f.write_str("it does not accept its parameters (Prm_Fault)"),
            Self::CfgFault => f.write_str("it does not accept its configuration (Cfg_Fault)"),
            Self::PrmReq => f.write_str("it asks to be parameterised again (Prm_Req)"),
            Self::NotReady => f.write_str("it does not become ready (Station_Not_Ready)"),
            Self::StaticDiag => f.write_str("it has no valid process data yet (Stat_Diag)"),
            Self::Ms1 => f.write_str("it did not respond to MS1 in time, or wrongly"),
            Self::Refused(Status::ServiceNotActivated) => f.write_str("it does not exchange data with us (RS)"),
            Self::Refused(Status::NoResource) => f.write_str("it has no room for the data (RR)"),
            Self::Refused(Status::UserError) => f.write_str("its application has failed (UE)"),
            Self::Refused(Status::NoReply) => f.write_str("it acknowledges where it should answer with data"),
            Self::Refused(status) if status.carries_data() => {
                f.write_str("it answers with data where it should only acknowledge")
            }
            Self::Refused(status) => write!(f, "it answers {status:?}"),
            Self::Length { expected, received } => {
                write!(f, "its answer has {received} octets instead of {expected}")
            }
        }
    }
}

impl core::error::Error for ExchangeError {}

/// The queue. An event that comes while it is full is lost and counts as an overflow.
#[derive(Clone, Debug)]
pub(super) struct Events<const EVENTS: usize> {
    queue: Deque<Event, EVENTS>,
    overflow: bool,
}

/// The queue without its capacity in the type, for functions that only add events.
pub(super) struct Sink<'a> {
    queue: &'a mut DequeView<Event>,
    overflow: &'a mut bool,
}

impl<const EVENTS: usize> Events<EVENTS> {
    pub(super) const fn new() -> Self {
        Self { queue: Deque::new(), overflow: false }
    }

    pub(super) fn sink(&mut self) -> Sink<'_> {
        Sink { queue: &mut self.queue, overflow: &mut self.overflow }
    }

    pub(super) fn pop(&mut self) -> Option<Event> {
        self.queue.pop_front()
    }

    pub(super) fn take_overflow(&mut self) -> bool {
        core::mem::take(&mut self.overflow)
    }
}

impl Sink<'_> {
    pub(super) fn push(&mut self, event: Event) {
        *self.overflow |= self.queue.push_back(event).is_err();
    }
}

#[cfg(test)]
mod tests {
    extern crate std;
    use super::*;

    #[test]
    fn a_full_queue_keeps_the_oldest_events_and_reports_the_overflow() {
        let mut events = Events::<2>::new();
        let event = |address| Event { at: BitTime(0), address, kind: EventKind::Diagnosis };
        (1..=3).for_each(|address| events.sink().push(event(address)));
        assert_eq!(events.pop(), Some(event(1)));
        assert_eq!(events.pop(), Some(event(2)));
        assert_eq!(events.pop(), None);
        assert!(events.take_overflow());
        assert!(!events.take_overflow());
    }
}
