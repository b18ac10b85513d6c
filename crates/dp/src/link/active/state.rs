//! What an active station is in the middle of, and what can be told of it.

use super::request::{Mismatch, OpenRequest};
use crate::link::time::{BitTime, T_SYN_TBIT};
use core::fmt;

/// Who has the word. In brackets the names of the standard.
#[derive(Clone, Copy, Debug)]
pub(super) enum FdlState {
    /// Somebody else for ever: this station has left the ring [Offline].
    Offline,
    /// Somebody else: this station is not in the ring, and learns who is [Listen_Token].
    Listening,
    /// Somebody else in the ring [Active_Idle].
    Idle,
    /// Nobody, it seems: the token was sent once and will be sent again [Claim_Token].
    Claiming,
    /// This station. It speaks when the line has been idle for so long [Use_Token, Check_Access_Time]. If it was answered
    /// just now: who was asked.
    Holding { idle_tbit: u64, answered: Option<u8> },
    /// A telegram that nobody answers is leaving [Use_Token, Pass_Token].
    Sending(Unconfirmed),
    /// Another station is to answer [Await_Data_Response, Await_Status_Response].
    Waiting(MessageCycle),
    /// The successor, if it got the token [Check_Token_Pass].
    Passing(Pass),
}

/// A telegram that nobody answers.
#[derive(Clone, Copy, Debug)]
pub(super) enum Unconfirmed {
    /// The first of the two tokens that claim the line.
    Claim,
    /// A token to this station.
    Token,
    /// A token to the successor.
    Pass(Pass),
    /// A message of the layer above.
    Message,
}

/// A token to the successor, with its repetitions.
#[derive(Clone, Copy, Debug)]
pub(super) struct Pass {
    /// To whom.
    pub(super) da: u8,
    /// How often it may be sent again.
    pub(super) retries_left: u8,
    /// Something was heard since, no telegram yet.
    pub(super) heard: bool,
}

/// A message and its answer, with all repetitions, inside one token visit.
#[derive(Clone, Copy, Debug)]
pub(super) struct MessageCycle {
    pub(super) request: OpenRequest,
    /// Whether the layer above asked, or the GAP.
    pub(super) from_user: bool,
    pub(super) retries: u8,
    pub(super) retries_left: u8,
    /// When the request has left.
    pub(super) sent_at: Option<BitTime>,
    /// What was wrong with the answer to something else that was heard since.
    pub(super) mismatch: Option<Mismatch>,
}

impl MessageCycle {
    pub(super) const fn new(asked: OpenRequest, retries_left: u8) -> Self {
        Self { request: asked, from_user: true, retries: 0, retries_left, sent_at: None, mismatch: None }
    }
}

/// What is true from one token to the next.
#[derive(Clone, Copy, Debug)]
pub(super) struct Visit {
    /// When the token came.
    pub(super) began: BitTime,
    /// The token hold time ends.
    pub(super) hold_until: BitTime,
    pub(super) phase: VisitPhase,
}

/// How far a token visit has come.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum VisitPhase {
    /// One message of high priority is allowed, however late the token came.
    First,
    /// Messages as long as there is time.
    Messages,
    /// Only the token is left to be sent.
    Over,
}

/// Another station with the address of this one.
#[derive(Clone, Copy, Debug)]
pub(super) struct DuplicateAddress {
    /// How often it was heard.
    pub(super) heard: u8,
    /// Whether it was since the last token visit. A single time may have been noise.
    pub(super) heard_since_visit: bool,
    /// This station leaves the address to it.
    pub(super) yielded: bool,
}

impl DuplicateAddress {
    pub(super) const NONE: Self = Self { heard: 0, heard_since_visit: false, yielded: false };
}

/// How long nobody was heard by a station that passes the token to itself.
///
/// Two masters that are alone, each for itself, may speak at the same bit times: neither hears the other, no slave
/// understands either, and the silence after it brings them into step again. So a station that hears nobody listens a
/// little longer now and then, in a pattern that is its address: two stations differ in one bit at least, and the one
/// that waits hears the other begin. The standard compares what is sent with what is on the line instead; few adapters
/// can.
#[derive(Clone, Copy, Debug)]
pub(super) struct SilentVisits {
    /// Token visits since a telegram was heard.
    pub(super) count: u8,
    /// Which bit of the address is next.
    address_bit: u8,
}

/// free choice: so many visits in a row are no accident.
const SILENT_VISITS_LIMIT: u8 = 4;

/// The bits of an address.
const ADDRESS_BITS: u8 = 7;

impl SilentVisits {
    pub(super) const NONE: Self = Self { count: 0, address_bit: 0 };

    /// A visit begins. How much longer the station `own` listens before it speaks: more than a character.
    pub(super) fn begin_visit(&mut self, own: u8) -> u64 {
        self.count = self.count.saturating_add(1);
        if self.count < SILENT_VISITS_LIMIT {
            return 0;
        }
        let waits = own.checked_shr(self.address_bit.into()).unwrap_or_default() & 1 == 1;
        *self = Self {
            count: 0,
            address_bit: self.address_bit.saturating_add(1).checked_rem(ADDRESS_BITS).unwrap_or_default(),
        };
        if waits { T_SYN_TBIT } else { 0 }
    }
}

/// Where an active station stands to the ring.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum RingState {
    /// It has left and says nothing.
    Offline,
    /// It learns who is in the ring; it says nothing but that it is not ready.
    Listening,
    /// It knows the ring and waits to be let in.
    Ready,
    /// It is in the ring.
    InRing,
    /// Another station uses its address, so it says nothing until that one is gone.
    AddressTaken,
}

impl fmt::Display for RingState {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Offline => "has left the ring",
            Self::Listening => "listens to the ring",
            Self::Ready => "waits to be let into the ring",
            Self::InRing => "is in the ring",
            Self::AddressTaken => "keeps silent, another station uses its address",
        })
    }
}

/// What went wrong with the token. Counters stop at the highest value.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct RingCounters {
    /// The line was silent for T_TO, and this station took the token.
    pub claimed: u32,
    /// The token was sent again because the successor did not speak.
    pub repeated: u32,
    /// A successor never spoke and was left out.
    pub lost_successors: u32,
    /// Another master spoke while this station had the token; it gave the token up.
    pub given_up: u32,
    /// The token went past this station.
    pub left_out: u32,
    /// A station spoke with the address of this one.
    pub own_address: u32,
}

impl RingCounters {
    pub(super) const NONE: Self =
        Self { claimed: 0, repeated: 0, lost_successors: 0, given_up: 0, left_out: 0, own_address: 0 };
}

/// One more.
pub(super) const fn increment(counter: &mut u32) {
    *counter = counter.saturating_add(1);
}
