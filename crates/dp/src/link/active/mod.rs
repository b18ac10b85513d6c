//! An active station: it takes the token, sends requests and waits for answers, and passes the token on.
//! profibus-wire 1.10, 1.12 and 1.13.
//!
//! ```text
//!              T_TO: token, token
//! Listening ───────────────────────────► Holding ◄──────────────────────────────────┐
//!   │  ▲                                  │  ▲  │                                    │
//!   │  │ token skips us                   │  │  └─ request ── Waiting ── answer T_ID1, silence T_SL
//!   │  │                          GAP, token │     SDN ────── Sending ── T_ID2 ───────┤
//!   │  │                                  ▼  │     token to itself, if alone ─────────┘
//!   │ Idle ◄── any telegram ─────────── Passing ◄── silence T_SL: again, twice, then the next successor
//!   │  │                                     │
//!   └──┴──────── token from PS, T_TO ────────┘
//! ```
//!
//! `token` has the table for the telegrams of other masters in each state, `las` the list of the masters in the ring, `gap`
//! the search for newcomers, `visit` the use of the token, and `cycle` a request with its answer.

mod answer;
mod cycle;
mod frame_count;
mod gap;
mod las;
mod parameters;
mod request;
mod state;
mod token;
mod visit;

pub use parameters::{BusParameter, BusParameters, CheckedBus, OutOfRange};
pub use request::{Answer, Confirmation, Failure, FdlUser, Mismatch, Priority, Request};
pub use state::{RingCounters, RingState};

use super::time::{BitTime, CHARACTER_TBIT};
use super::{Station, Transmit};
use frame_count::FrameCounts;
use gap::Gap;
use las::Las;
use profivac_wire::control::StationType;
use profivac_wire::{MAX_TELEGRAM, Telegram};
use state::{DuplicateAddress, FdlState, Pass, SilentVisits, Unconfirmed, Visit, VisitPhase};
use token::ForeignTelegram;

/// The duration of the longest telegram.
const LONGEST_TBIT: u64 = (MAX_TELEGRAM as u64).saturating_mul(CHARACTER_TBIT);

/// An active station with the FDL user `R` above it.
#[derive(Clone, Debug)]
pub struct Active<R> {
    /// The FDL user, the layer above.
    pub user: R,
    bus: BusParameters,
    state: FdlState,
    visit: Visit,
    gap: Gap,
    las: Las,
    counts: FrameCounts,
    counters: RingCounters,
    /// The end of the last known activity of the line.
    busy_until: BitTime,
    /// The master that sent a telegram last.
    other: Option<u8>,
    /// The master that sent this station the token and is not its predecessor.
    suspect: Option<u8>,
    duplicate: DuplicateAddress,
    silent_visits: SilentVisits,
    /// This station passes the token on and does not take it again.
    leaving_ring: bool,
    /// The adapter may echo the telegram sent last.
    may_echo: bool,
    telegram: [u8; MAX_TELEGRAM],
    length: usize,
}

impl<R: FdlUser> Active<R> {
    /// A station that begins to listen at `now`.
    pub const fn new(bus: CheckedBus, user: R, now: BitTime) -> Self {
        let bus = bus.get();
        Self {
            user,
            state: FdlState::Listening,
            visit: Visit { began: now, hold_until: now, phase: VisitPhase::Over },
            gap: Gap::new(bus.address, bus.hsa, bus.gap_pause_tbit()),
            las: Las::new(bus.address),
            bus,
            counts: FrameCounts::new(),
            counters: RingCounters::NONE,
            busy_until: now,
            other: None,
            suspect: None,
            duplicate: DuplicateAddress::NONE,
            silent_visits: SilentVisits::NONE,
            leaving_ring: false,
            may_echo: false,
            telegram: [0; MAX_TELEGRAM],
            length: 0,
        }
    }

    /// The bus parameters.
    pub const fn bus(&self) -> &BusParameters {
        &self.bus
    }

    /// Sets the highest station address. A new scan of the GAP starts.
    ///
    /// # Errors
    /// [`OutOfRange`]: it is below the address of this station or above 126, and nothing has changed.
    pub fn set_hsa(&mut self, hsa: u8) -> Result<(), OutOfRange> {
        self.bus = BusParameters { hsa, ..self.bus }.check()?.get();
        self.gap.set_hsa(hsa);
        Ok(())
    }

    /// Raises the slot time to `slot_tbit`; a shorter one changes nothing. Only for a station that is alone in the ring: all
    /// masters of a ring have the same slot time.
    pub const fn raise_slot_time(&mut self, slot_tbit: u32) {
        if slot_tbit > self.bus.slot_tbit {
            self.bus.slot_tbit = slot_tbit;
        }
    }

    /// Scans the GAP only after the first pause. For a program that has left by then: each FDL status request costs a slot
    /// time, which is long on a port of an operating system.
    pub const fn delay_gap_scan(&mut self) {
        self.gap.delay_scans();
    }

    /// Whether this station has the token.
    pub const fn has_token(&self) -> bool {
        match self.state {
            FdlState::Holding { .. } | FdlState::Waiting(_) => true,
            FdlState::Sending(unconfirmed) => !matches!(unconfirmed, Unconfirmed::Claim),
            FdlState::Offline | FdlState::Listening | FdlState::Idle | FdlState::Claiming | FdlState::Passing(_) => {
                false
            }
        }
    }

    /// The relation of this station to the ring.
    pub const fn ring_state(&self) -> RingState {
        match self.state {
            FdlState::Offline => RingState::Offline,
            _ if self.duplicate.yielded => RingState::AddressTaken,
            FdlState::Listening if self.las.is_complete() => RingState::Ready,
            FdlState::Listening | FdlState::Claiming | FdlState::Sending(Unconfirmed::Claim) => RingState::Listening,
            _ => RingState::InRing,
        }
    }

    /// The masters in the ring, in the order of their addresses, as far as this station knows, itself included.
    pub fn masters(&self) -> impl Iterator<Item = u8> + use<R> {
        let own = self.bus.address;
        let itself = (self.ring_state() == RingState::InRing).then_some(own);
        let (below, above) = (self.las.others(), self.las.others());
        let below = below.take_while(move |address| *address < own);
        below.chain(itself).chain(above.skip_while(move |address| *address < own))
    }

    /// The counters of token errors.
    pub const fn ring_counters(&self) -> &RingCounters {
        &self.counters
    }

    /// The master that sent a telegram last, unless this station is alone in the ring again. While this station waits to be let
    /// into the ring, that master holds the line.
    pub const fn other_master(&self) -> Option<u8> {
        self.other
    }

    /// The stations that answered the last FDL status request, of the GAP or of the FDL user.
    pub fn live_list(&self) -> impl Iterator<Item = (u8, StationType)> {
        self.gap.live_list()
    }

    /// Restarts at `now`, for instance because the port was lost: a pending request has failed.
    pub fn listen(&mut self, now: BitTime) {
        self.busy_until = self.busy_until.max(now);
        self.give_up_token(now);
        self.state = FdlState::Listening;
        self.las = Las::new(self.bus.address);
        (self.leaving_ring, self.may_echo) = (false, false);
        (self.suspect, self.duplicate) = (None, DuplicateAddress::NONE);
    }

    /// Leaves the ring. A station that has the token finishes its message and passes the token on; then
    /// [`ring_state`](Self::ring_state) is [`RingState::Offline`]. [`listen`](Self::listen) reverses this.
    pub const fn leave(&mut self) {
        self.leaving_ring = true;
        self.visit.phase = VisitPhase::Over;
        if matches!(
            self.state,
            FdlState::Listening | FdlState::Idle | FdlState::Claiming | FdlState::Sending(Unconfirmed::Claim)
        ) {
            self.state = FdlState::Offline;
        }
    }

    fn slot_tbit(&self) -> u64 {
        u64::from(self.bus.slot_tbit)
    }

    fn token_idle_tbit(&self) -> u64 {
        self.bus.token_idle_tbit.map_or_else(|| self.bus.id1_tbit(), u64::from)
    }

    #[inline]
    fn transmit(&mut self, length: usize, not_before: BitTime) -> Option<Transmit<'_>> {
        self.length = length;
        self.may_echo = true;
        Some(Transmit { not_before, octets: self.telegram.get(..length)? })
    }
}

impl<R: FdlUser> Station for Active<R> {
    #[inline]
    fn telegram(&mut self, end: BitTime, telegram: &Telegram<'_>) -> Option<Transmit<'_>> {
        self.busy_until = self.busy_until.max(end);
        self.silent_visits.count = 0;
        match ForeignTelegram::of(telegram, self.bus.address) {
            Some(foreign) => self.handle_foreign(end, telegram, foreign),
            None => {
                self.handle_answer(end, telegram);
                None
            }
        }
    }

    #[inline]
    fn activity(&mut self, end: BitTime) {
        self.busy_until = self.busy_until.max(end);
        if let FdlState::Passing(pass) = &mut self.state {
            pass.heard = true;
        }
    }

    #[inline]
    fn sent(&mut self, end: BitTime) {
        self.busy_until = self.busy_until.max(end);
        match &mut self.state {
            FdlState::Waiting(cycle) => cycle.sent_at = Some(end),
            FdlState::Sending(Unconfirmed::Claim) => self.state = FdlState::Claiming,
            FdlState::Sending(Unconfirmed::Token) => {
                let idle_tbit = self.token_idle_tbit().saturating_add(self.silent_visits.begin_visit(self.bus.address));
                self.begin_visit(end, idle_tbit);
            }
            FdlState::Sending(Unconfirmed::Pass(pass)) => self.state = FdlState::Passing(*pass),
            FdlState::Sending(Unconfirmed::Message) => {
                self.state = FdlState::Holding { idle_tbit: self.bus.id2_tbit(), answered: None };
                self.user.confirm(end, Confirmation::Sent);
            }
            // The telegram was an answer of this station, or the answer to the request came before this report.
            FdlState::Offline | FdlState::Listening | FdlState::Idle => {}
            FdlState::Holding { .. } | FdlState::Claiming | FdlState::Passing(_) => {}
        }
    }

    #[inline]
    fn poll(&mut self, now: BitTime) -> Option<Transmit<'_>> {
        let due = self.wake_at().filter(|due| *due <= now)?;
        match self.state {
            FdlState::Listening | FdlState::Idle => self.claim(now, due),
            FdlState::Claiming => self.send_token(self.bus.address, Unconfirmed::Token, due),
            FdlState::Holding { .. } => self.use_token(now, due),
            FdlState::Waiting(cycle) => self.slot_expired(now, cycle),
            FdlState::Passing(pass) => self.check_pass(now, pass, due),
            FdlState::Sending(_) | FdlState::Offline => None,
        }
    }

    /// Every wait of this station is for a line that has been idle long enough.
    #[inline]
    fn wake_at(&self) -> Option<BitTime> {
        match &self.state {
            FdlState::Listening | FdlState::Idle => Some(self.busy_until + self.bus.timeout_tbit()),
            FdlState::Claiming => Some(self.busy_until + self.token_idle_tbit()),
            FdlState::Holding { idle_tbit, .. } => Some(self.busy_until + *idle_tbit),
            FdlState::Waiting(cycle) => self.deadline(cycle),
            FdlState::Passing(Pass { .. }) => Some(self.busy_until + self.slot_tbit()),
            FdlState::Sending(_) | FdlState::Offline => None,
        }
    }
}
