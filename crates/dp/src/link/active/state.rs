//! The states of an active station, and its public state and counters.

use super::request::{Mismatch, OpenRequest};
use crate::link::time::{BitTime, T_SYN_TBIT};
use core::fmt;

/// The state of an active station. Brackets contain the names of the standard.
#[derive(Clone, Copy, Debug)]
pub(super) enum FdlState {
    /// The station has left the ring [Offline].
    Offline,
    /// The station is not in the ring and learns its masters [Listen_Token].
    Listening,
    /// The station is in the ring and does not have the token [Active_Idle].
    Idle,
    /// The station claims the token: it has sent it once and sends it again [Claim_Token].
    Claiming,
    /// The station has the token and sends when the line has been idle for this time [Use_Token, Check_Access_Time].
    /// `answered` is the station that has just answered.
    Holding { idle_tbit: u64, answered: Option<u8> },
    /// The station sends a telegram without an answer [Use_Token, Pass_Token].
    Sending(Unconfirmed),
    /// The station waits for an answer [Await_Data_Response, Await_Status_Response].
    Waiting(MessageCycle),
    /// The station waits for the successor to use the token [Check_Token_Pass].
    Passing(Pass),
}

/// A telegram without an answer.
#[derive(Clone, Copy, Debug)]
pub(super) enum Unconfirmed {
    /// The first of the two tokens that claim the line.
    Claim,
    /// A token to this station.
    Token,
    /// A token to the successor.
    Pass(Pass),
    /// A request of the FDL user.
    Message,
}

/// A token to the successor, with its repetitions.
#[derive(Clone, Copy, Debug)]
pub(super) struct Pass {
    /// The successor.
    pub(super) da: u8,
    /// How often the token may be sent again.
    pub(super) repetitions_left: u8,
    /// Characters were received since, but no telegram yet.
    pub(super) heard: bool,
}

/// A request and its answer, with all repetitions, inside one token visit.
#[derive(Clone, Copy, Debug)]
pub(super) struct MessageCycle {
    pub(super) request: OpenRequest,
    /// The request comes from the FDL user, not from the GAP.
    pub(super) from_user: bool,
    pub(super) repetitions: u8,
    pub(super) repetitions_left: u8,
    /// When the last bit of the request was sent.
    pub(super) sent_at: Option<BitTime>,
    /// The mismatch of a telegram received since.
    pub(super) mismatch: Option<Mismatch>,
}

impl MessageCycle {
    pub(super) const fn new(request: OpenRequest, repetitions_left: u8) -> Self {
        Self { request, from_user: true, repetitions: 0, repetitions_left, sent_at: None, mismatch: None }
    }
}

/// A token visit.
#[derive(Clone, Copy, Debug)]
pub(super) struct Visit {
    /// When the token came.
    pub(super) began: BitTime,
    /// The end of the token hold time.
    pub(super) hold_until: BitTime,
    pub(super) phase: VisitPhase,
}

/// The phase of a token visit.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum VisitPhase {
    /// One message of high priority is allowed, even if the token came late.
    First,
    /// Messages are allowed during the token hold time.
    Messages,
    /// Only the token remains to be sent.
    Over,
}

/// Another station with the address of this one.
#[derive(Clone, Copy, Debug)]
pub(super) struct DuplicateAddress {
    /// The number of its telegrams.
    pub(super) heard: u8,
    /// Whether one of them came since the last token visit. A single one may have been noise.
    pub(super) heard_since_visit: bool,
    /// This station has yielded the address.
    pub(super) yielded: bool,
}

impl DuplicateAddress {
    pub(super) const NONE: Self = Self { heard: 0, heard_since_visit: false, yielded: false };
}

/// The successive token visits without a received telegram, in a station that passes the token to itself.
///
/// Two masters that are each alone in their own ring may send in the same bit times: neither receives the other, no slave
/// understands either, and the silence after that synchronises them again. So a station that receives nothing sometimes
/// listens a little longer, in a pattern that is its address: two stations differ in at least one bit, and the one that waits
/// receives the other. The standard compares the sent octets with the line instead, which few adapters can do.
#[derive(Clone, Copy, Debug)]
pub(super) struct SilentVisits {
    /// The visits since the last received telegram.
    pub(super) count: u8,
    /// The next bit of the address.
    address_bit: u8,
}

/// chosen: after this many visits the silence is no coincidence.
const SILENT_VISITS_LIMIT: u8 = 4;

/// The number of bits of an address.
const ADDRESS_BITS: u8 = 7;

impl SilentVisits {
    pub(super) const NONE: Self = Self { count: 0, address_bit: 0 };

    /// Begins a visit. Returns how much longer the station `own` listens before it sends, in bit times: 0, or more than a
    /// character.
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

/// The relation of an active station to the ring.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum RingState {
    /// The station has left the ring and sends nothing.
    Offline,
    /// The station learns the masters of the ring; it answers FDL status with "not ready".
    Listening,
    /// The station knows the ring and waits until its predecessor finds it in the GAP and passes the token.
    Ready,
    /// The station is in the ring.
    InRing,
    /// Another station uses the address, so this station sends nothing until the other has gone.
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

/// Counters of token errors. They stop at the highest value.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[non_exhaustive]
pub struct RingCounters {
    /// The line was idle for T_TO, and this station took the token.
    pub claimed: u32,
    /// The station sent the token again because the successor did not use it.
    pub repeated: u32,
    /// A successor never used the token and was removed from the list.
    pub lost_successors: u32,
    /// Another master sent a telegram while this station had the token; this station gave the token up.
    pub given_up: u32,
    /// The token skipped this station.
    pub left_out: u32,
    /// Another station sent a telegram with the address of this one.
    pub own_address: u32,
}

impl RingCounters {
    pub(super) const NONE: Self =
        Self { claimed: 0, repeated: 0, lost_successors: 0, given_up: 0, left_out: 0, own_address: 0 };
}

/// Increments a counter.
pub(super) const fn increment(counter: &mut u32) {
    *counter = counter.saturating_add(1);
}
