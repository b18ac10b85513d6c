//! An active station: it takes the token, asks others and waits for their answers. profibus-wire 1.10, 1.12 and 1.13.
//!
//! For now a station that is alone: when the line has been silent for T_TO it claims the token, passes it to itself after
//! every visit, and goes back to listening as soon as another master is heard. The places where a ring of several masters
//! will differ are few: what ends `State::Listening`, to whom `Active::pass_token` passes, and what follows
//! `Departure::Token`.
//!
//! ```text
//! Listening ── silence T_TO ── token ── Claiming ── T_ID2 ── token ──┐
//!     ▲                                                              ▼
//!     │  another master                             ┌──────── Holding ◄───────────────┐
//!     └─────────────────────────────────────────────┤   asks the layer above for work │
//!                                                   │                                 │
//!                              request ── Waiting ──┴── answer T_ID1, silence T_SL ───┤
//!                              SDN, token ── Leaving ── T_ID2 ────────────────────────┘
//! ```

mod answer;
mod count;
mod gap;
mod parameters;
mod request;

pub use parameters::{BusParameters, OutOfRange};
pub use request::{Answer, Confirmation, Failure, Mismatch, Priority, Request, Requests};

use super::time::{BitTime, CHARACTER_TBIT};
use super::{Station, Transmit};
use count::FrameCounts;
use gap::Gap;
use profivac_wire::control::{Control, FrameCount, Function, StationType};
use profivac_wire::{BROADCAST, Frame, MAX_TELEGRAM, Telegram};
use request::{Asked, Kind};

/// How long the longest telegram takes.
const LONGEST_TBIT: u64 = (MAX_TELEGRAM as u64).saturating_mul(CHARACTER_TBIT);

/// An active station with `R` above it.
#[derive(Clone, Debug)]
pub struct Active<R> {
    /// The layer above.
    pub user: R,
    bus: BusParameters,
    state: State,
    visit: Visit,
    gap: Gap,
    counts: FrameCounts,
    /// When the line was last known to be busy.
    busy: BitTime,
    /// The master that was heard and made this one listen.
    other: Option<u8>,
    telegram: [u8; MAX_TELEGRAM],
    length: usize,
}

/// Who has the word.
#[derive(Clone, Copy, Debug)]
enum State {
    /// Perhaps somebody else. This station speaks again when nobody has for T_TO.
    Listening,
    /// Nobody, it seems: the token was sent once and will be sent again.
    Claiming { not_before: BitTime },
    /// This station, and nothing is on its way.
    Holding { not_before: BitTime },
    /// A telegram that nobody answers is leaving.
    Leaving(Departure),
    /// Another station is to answer.
    Waiting(Cycle),
}

/// A telegram that nobody answers.
#[derive(Clone, Copy, Debug)]
enum Departure {
    /// The first of the two tokens that claim the line.
    Claim,
    /// A token to this station.
    Token,
    /// A message of the layer above.
    Unconfirmed,
}

/// A message and its answer, with all repetitions, inside one token visit.
#[derive(Clone, Copy, Debug)]
struct Cycle {
    asked: Asked,
    /// Whether the layer above asked, or the GAP.
    from_user: bool,
    retries: u8,
    retries_left: u8,
    /// When to give up; nothing as long as the request has not left.
    deadline: Option<BitTime>,
    /// When to give up even if the line is still busy.
    limit: BitTime,
    /// What to report if no answer comes.
    failure: Failure,
}

/// What is true from one token to the next.
#[derive(Clone, Copy, Debug)]
struct Visit {
    /// When the token came.
    began: BitTime,
    /// The token hold time ends.
    hold_until: BitTime,
    part: Part,
}

/// How far a token visit has come.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Part {
    /// One message of high priority is allowed, however late the token came.
    First,
    /// Messages as long as there is time.
    Messages,
    /// Only the token is left to be sent.
    Over,
}

impl<R: Requests> Active<R> {
    /// A station that begins to listen at `now`.
    pub const fn new(bus: BusParameters, user: R, now: BitTime) -> Self {
        Self {
            user,
            bus,
            state: State::Listening,
            visit: Visit { began: now, hold_until: now, part: Part::Over },
            gap: Gap::new(bus.address, bus.hsa, bus.gap_factor),
            counts: FrameCounts::new(),
            busy: now,
            other: None,
            telegram: [0; MAX_TELEGRAM],
            length: 0,
        }
    }

    /// The bus parameters.
    pub const fn bus(&self) -> &BusParameters {
        &self.bus
    }

    /// Whether this station has the token.
    pub const fn has_token(&self) -> bool {
        !matches!(self.state, State::Listening | State::Claiming { .. } | State::Leaving(Departure::Claim))
    }

    /// The master that was heard and that this station leaves the line to. Its own address means a second station with
    /// that address, or an adapter that echoes.
    pub const fn other_master(&self) -> Option<u8> {
        self.other
    }

    /// Everybody that answered FDL status when asked last, by the GAP or by the layer above.
    pub fn live(&self) -> impl Iterator<Item = (u8, StationType)> {
        self.gap.live()
    }

    /// Begins anew at `now`, for instance because the port was lost: whatever was on its way has failed.
    pub fn listen(&mut self, now: BitTime) {
        self.busy = self.busy.max(now);
        match core::mem::replace(&mut self.state, State::Listening) {
            State::Waiting(cycle) => self.failed(now, &cycle, Failure::Interrupted),
            State::Leaving(Departure::Unconfirmed) => {
                self.user.confirm(now, Confirmation::Failed(Failure::Interrupted));
            }
            State::Leaving(Departure::Claim | Departure::Token)
            | State::Listening
            | State::Claiming { .. }
            | State::Holding { .. } => {}
        }
    }

    fn slot_tbit(&self) -> u64 {
        u64::from(self.bus.slot_tbit)
    }

    fn token_idle_tbit(&self) -> u64 {
        self.bus.token_idle_tbit.map_or_else(|| self.bus.id2_tbit(), u64::from)
    }

    /// Holds the token and may speak.
    fn work(&mut self, now: BitTime, not_before: BitTime) -> Option<Transmit<'_>> {
        let part = self.visit.part;
        let on_time = part != Part::Over && now < self.visit.hold_until;
        if part == Part::First {
            self.visit.part = Part::Messages;
        }
        let mut request = None;
        if on_time || part == Part::First {
            request = self.user.next(Priority::High, now);
        }
        if on_time && request.is_none() {
            request = self.user.next(Priority::Low, now);
        }
        match request {
            None => self.end_visit(not_before),
            Some(request) => {
                let asked = request.asked();
                let count = self.counts.next(&asked);
                let length = emit(&request, self.bus.address, count, &mut self.telegram);
                match length {
                    None => {
                        self.user.confirm(now, Confirmation::Failed(Failure::Impossible));
                        self.end_visit(not_before)
                    }
                    Some(length) => self.begin(asked, count, length, not_before),
                }
            }
        }
    }

    /// A message of the layer above is ready to leave.
    fn begin(&mut self, asked: Asked, count: FrameCount, length: usize, not_before: BitTime) -> Option<Transmit<'_>> {
        self.state = match asked.kind {
            Kind::Unconfirmed => State::Leaving(Departure::Unconfirmed),
            // A first contact is not repeated, nor is what does not count: profibus-wire 1.10.
            _ if matches!(count, FrameCount::Counted(_)) => State::Waiting(Cycle::new(asked, self.bus.retry_limit)),
            _ => State::Waiting(Cycle::new(asked, 0)),
        };
        self.transmit(length, not_before)
    }

    /// No message is left for this visit: at most one address of the GAP, then the token.
    fn end_visit(&mut self, not_before: BitTime) -> Option<Transmit<'_>> {
        let over = core::mem::replace(&mut self.visit.part, Part::Over) == Part::Over;
        match if over { None } else { self.gap.visit() } {
            None => self.pass_token(Departure::Token, not_before),
            Some(da) => {
                let request = Request { da, function: Function::FdlStatus, dsap: None, ssap: None, du: &[] };
                let length = emit(&request, self.bus.address, FrameCount::Uncounted, &mut self.telegram)?;
                self.state = State::Waiting(Cycle { from_user: false, ..Cycle::new(request.asked(), 0) });
                self.transmit(length, not_before)
            }
        }
    }

    /// A station that is alone passes the token to itself.
    fn pass_token(&mut self, departure: Departure, not_before: BitTime) -> Option<Transmit<'_>> {
        let token = Telegram::Token { da: self.bus.address, sa: self.bus.address };
        let length = token.emit(&mut self.telegram).ok()?;
        self.state = State::Leaving(departure);
        self.transmit(length, not_before)
    }

    fn transmit(&mut self, length: usize, not_before: BitTime) -> Option<Transmit<'_>> {
        self.length = length;
        Some(Transmit { not_before, octets: self.telegram.get(..length)? })
    }

    /// The token came at `now`. Its hold time is what the last rotation left of T_TR.
    fn begin_visit(&mut self, now: BitTime) {
        self.other = None;
        let hold_until = self.visit.began + u64::from(self.bus.rotation_tbit);
        self.visit = Visit { began: now, hold_until, part: Part::First };
        self.state = State::Holding { not_before: now + self.token_idle_tbit() };
    }

    /// The slot time or the patience with a busy line has expired.
    fn expire(&mut self, now: BitTime, mut cycle: Cycle) -> Option<Transmit<'_>> {
        if now < self.busy + self.slot_tbit() {
            // Longer than any telegram, and still not quiet.
            self.listen(now);
            return None;
        }
        let not_before = self.busy + self.slot_tbit().max(self.bus.id1_tbit());
        if cycle.retries_left > 0 {
            cycle.retries_left = cycle.retries_left.saturating_sub(1);
            cycle.retries = cycle.retries.saturating_add(1);
            cycle.deadline = None;
            self.state = State::Waiting(cycle);
            return self.transmit(self.length, not_before);
        }
        self.state = State::Holding { not_before };
        self.failed(now, &cycle, cycle.failure);
        self.work(now, not_before)
    }

    /// No answer will come: the station counts as not operational.
    fn failed(&mut self, now: BitTime, cycle: &Cycle, failure: Failure) {
        self.counts.forget(&cycle.asked);
        if cycle.asked.kind == Kind::FdlStatus && failure != Failure::Interrupted {
            self.gap.note(cycle.asked.da, None);
        }
        if cycle.from_user {
            self.user.confirm(now, Confirmation::Failed(failure));
        }
    }

    /// The answer came.
    fn answered(&mut self, end: BitTime, cycle: &Cycle, answer: Answer<'_>) {
        self.counts.answered(&cycle.asked);
        if cycle.asked.kind == Kind::FdlStatus {
            self.gap.note(cycle.asked.da, Some(answer.station));
        }
        // What was repeated may be answered twice, once too late. Both answers look alike, so the second must not fall
        // into the next message cycle: it gets a slot time to arrive in.
        let idle = if cycle.retries > 0 { self.slot_tbit().max(self.bus.id1_tbit()) } else { self.bus.id1_tbit() };
        self.state = State::Holding { not_before: end + idle };
        if cycle.from_user {
            self.user.confirm(end, Confirmation::Answer(Answer { retries: cycle.retries, ..answer }));
        }
    }

    /// A telegram of a responder, or one that cannot be anybody's.
    fn heard(&mut self, end: BitTime, telegram: &Telegram<'_>) {
        let State::Waiting(mut cycle) = self.state else { return self.line_is_busy(end, Failure::Damaged) };
        match answer::matched(&cycle.asked, self.bus.address, telegram) {
            Ok(answer) => self.answered(end, &cycle, answer),
            Err(mismatch) => {
                cycle.failure = Failure::Mismatch(mismatch);
                self.state = State::Waiting(cycle);
                self.line_is_busy(end, Failure::Mismatch(mismatch));
            }
        }
    }

    /// Something ended at `end` that is no answer: whatever waits for a quiet line waits longer.
    fn line_is_busy(&mut self, end: BitTime, failure: Failure) {
        let slot = self.slot_tbit();
        let idle = self.bus.id1_tbit();
        match &mut self.state {
            State::Waiting(cycle) => {
                if cycle.failure == Failure::Silence {
                    cycle.failure = failure;
                }
                if cycle.deadline.is_some() {
                    cycle.deadline = Some((end + slot).min(cycle.limit));
                }
            }
            State::Holding { not_before } | State::Claiming { not_before } => {
                *not_before = (*not_before).max(end + idle);
            }
            State::Listening | State::Leaving(_) => {}
        }
    }
}

impl Cycle {
    const fn new(asked: Asked, retries_left: u8) -> Self {
        let limit = BitTime(u64::MAX);
        Self { asked, from_user: true, retries: 0, retries_left, deadline: None, limit, failure: Failure::Silence }
    }
}

impl<R: Requests> Station for Active<R> {
    #[inline]
    fn telegram(&mut self, end: BitTime, telegram: &Telegram<'_>) -> Option<Transmit<'_>> {
        self.busy = self.busy.max(end);
        match master_behind(telegram) {
            Some(address) => {
                self.other = Some(address);
                self.listen(end);
            }
            None => self.heard(end, telegram),
        }
        None
    }

    #[inline]
    fn activity(&mut self, end: BitTime) {
        self.busy = self.busy.max(end);
        self.line_is_busy(end, Failure::Damaged);
    }

    fn sent(&mut self, end: BitTime) {
        self.busy = self.busy.max(end);
        let slot = self.slot_tbit();
        match &mut self.state {
            State::Waiting(cycle) if cycle.deadline.is_none() => {
                cycle.deadline = Some(end + slot);
                cycle.limit = end + slot + LONGEST_TBIT + slot;
            }
            State::Leaving(Departure::Claim) => {
                self.state = State::Claiming { not_before: end + self.token_idle_tbit() };
            }
            State::Leaving(Departure::Token) => self.begin_visit(end),
            State::Leaving(Departure::Unconfirmed) => {
                self.state = State::Holding { not_before: end + self.bus.id2_tbit() };
                self.user.confirm(end, Confirmation::Sent);
            }
            State::Waiting(_) | State::Holding { .. } | State::Claiming { .. } | State::Listening => {
                // The answer was faster than the news that the request has left.
                self.line_is_busy(end, Failure::Damaged);
            }
        }
    }

    fn poll(&mut self, now: BitTime) -> Option<Transmit<'_>> {
        if self.wake_at().is_none_or(|due| now < due) {
            return None;
        }
        match self.state {
            State::Listening => self.pass_token(Departure::Claim, now),
            State::Claiming { not_before } => self.pass_token(Departure::Token, not_before),
            State::Holding { not_before } => self.work(now, not_before),
            State::Waiting(cycle) => self.expire(now, cycle),
            State::Leaving(_) => None,
        }
    }

    fn wake_at(&self) -> Option<BitTime> {
        match self.state {
            State::Listening => Some(self.busy + self.bus.timeout_tbit()),
            State::Claiming { not_before } | State::Holding { not_before } => Some(not_before),
            State::Waiting(cycle) => cycle.deadline,
            State::Leaving(_) => None,
        }
    }
}

/// Writes a request to the front of `out`; nothing if no station can be sent such a message.
fn emit(request: &Request<'_>, sa: u8, count: FrameCount, out: &mut [u8]) -> Option<usize> {
    if !request.is_possible(sa) {
        return None;
    }
    let &Request { da, function, dsap, ssap, du } = request;
    let fc = Control::Request { function, count }.to_octet();
    Telegram::Frame(Frame { da, sa, dsap, ssap, fc, du }).emit(out).ok()
}

/// The master that only can have sent `telegram`. Nothing protects the addresses of a token, and no station is 127.
fn master_behind(telegram: &Telegram<'_>) -> Option<u8> {
    match telegram {
        Telegram::Token { da, sa } if *da < BROADCAST && *sa < BROADCAST => Some(*sa),
        Telegram::Frame(frame) if frame.sa < BROADCAST && matches!(frame.control(), Control::Request { .. }) => {
            Some(frame.sa)
        }
        Telegram::Token { .. } | Telegram::Frame(_) | Telegram::ShortAck => None,
    }
}
