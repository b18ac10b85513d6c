//! What a master has to tell about its slaves: one bounded queue.

use super::acyclic::{AcyclicEvent, Handle};
use super::state::HandlerState;
use crate::link::BitTime;
use crate::link::active::Failure;
use core::fmt;
use heapless::deque::{Deque, DequeView};
use profivac_wire::control::Status;

/// Something happened to a slave.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Event {
    /// When.
    pub at: BitTime,
    /// To which slave.
    pub address: u8,
    /// What.
    pub kind: EventKind,
}

/// What happened.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum EventKind {
    /// The handler has entered this state.
    Entered(HandlerState),
    /// Something keeps the slave from exchanging data. Told once, until it exchanges or something else does.
    Trouble(ExchangeError),
    /// The diagnosis says something new.
    Diagnosis,
    /// It has answered twice, or late. Told for the first time since the slave was called, then counted:
    /// [`Counters::strays`](super::Counters::strays).
    Stray,
    /// Something became of an acyclic request.
    Acyclic(Handle, AcyclicEvent),
    /// The slave has fallen out of data exchange, and [`Settings::auto_clear`](super::Settings::auto_clear) has taken the
    /// master to Clear.
    AutoClear,
}

impl fmt::Display for EventKind {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Entered(state) => state.fmt(f),
            Self::Trouble(trouble) => trouble.fmt(f),
            Self::Diagnosis => f.write_str("new diagnosis"),
            Self::Stray => f.write_str("it answered twice or late: is there another station at its address?"),
            Self::Acyclic(handle, AcyclicEvent::OutcomeReady) => {
                write!(f, "there is an outcome of {}", handle.service())
            }
            Self::Acyclic(_, AcyclicEvent::Ended(end)) => end.fmt(f),
            Self::AutoClear => f.write_str("it fell out of data exchange, and the master went to CLEAR"),
        }
    }
}

/// What keeps a slave from exchanging data.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ExchangeError {
    /// No answer, or none that is one.
    NoAnswer(Failure),
    /// Another master owns it.
    Owned {
        /// Diag_Master_Add.
        master: u8,
    },
    /// It is another device.
    Ident {
        /// The Ident_Number it should have.
        expected: u16,
        /// The one it has.
        received: u16,
    },
    /// It does not accept its parameters.
    PrmFault,
    /// It does not accept its configuration.
    CfgFault,
    /// It wants to be parameterised again.
    PrmReq,
    /// It has been checking its parameters for too long.
    NotReady,
    /// Static diagnosis: it has no valid process data yet.
    StaticDiag,
    /// A late response could be taken for another one: MS1 begins anew with data exchange.
    Ms1,
    /// It answers a service like this.
    Refused(Status),
    /// The data unit of an answer has the wrong length.
    Length {
        /// How many octets it should have, at least six in a diagnosis.
        expected: usize,
        /// How many it has.
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

/// The queue. What comes when it is full is lost, and remembered as an overflow.
#[derive(Clone, Debug)]
pub(super) struct Events<const EVENTS: usize> {
    queue: Deque<Event, EVENTS>,
    overflow: bool,
}

/// The end of the queue that events are put in, whatever its capacity.
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
    fn a_full_queue_keeps_the_oldest_and_says_so() {
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
