//! An active station: it takes the token, asks others and waits for their answers. profibus-wire 1.10, 1.12 and 1.13.
//!
//! For now a station that is alone: when the line has been silent for T_TO it claims the token, passes it to itself after
//! every visit, and goes back to listening as soon as another master is heard. The places where a ring of several masters
//! will differ are few: what ends `State::Listening`, to whom `Active::pass_token` passes, and what follows
//! `Departure::Token`.
//!
//! ```text
//! Listening ── silence T_TO ── token ── Claiming ── T_ID1 ── token ──┐
//!     ▲                                                              ▼
//!     │  another master                             ┌──────── Holding ◄───────────────┐
//!     └─────────────────────────────────────────────┤   asks the layer above for work │
//!                                                   │                                 │
//!                              request ── Waiting ──┴── answer T_ID1, silence T_SL ───┤
//!                              SDN, token ── Leaving ── T_ID2 or T_ID1 ───────────────┘
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
    Claiming,
    /// This station. It speaks when the line has been idle for so long.
    Holding { idle_tbit: u64 },
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
    /// When the request has left.
    left: Option<BitTime>,
    /// What was wrong with the answer to something else that was heard since.
    mismatch: Option<Mismatch>,
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
        !matches!(self.state, State::Listening | State::Claiming | State::Leaving(Departure::Claim))
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
            | State::Claiming
            | State::Holding { .. } => {}
        }
    }

    fn slot_tbit(&self) -> u64 {
        u64::from(self.bus.slot_tbit)
    }

    fn token_idle_tbit(&self) -> u64 {
        self.bus.token_idle_tbit.map_or_else(|| self.bus.id1_tbit(), u64::from)
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
        let Some(request) = request else { return self.end_visit(not_before) };
        let asked = request.asked();
        let count = self.counts.next(&asked);
        match emit(&request, self.bus.address, count, &mut self.telegram) {
            Some(length) => self.begin(asked, count, length, not_before),
            None => {
                self.user.confirm(now, Confirmation::Failed(Failure::Impossible));
                self.end_visit(not_before)
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
        self.state = State::Holding { idle_tbit: self.token_idle_tbit() };
    }

    /// No answer has come in time: the request again, or the next one.
    fn expire(&mut self, now: BitTime, mut cycle: Cycle) -> Option<Transmit<'_>> {
        if now < self.busy + self.slot_tbit() {
            // Longer than any telegram, and still not quiet.
            self.listen(now);
            return None;
        }
        // T_SL is longer than T_ID1: BusParameters::check.
        let idle_tbit = self.slot_tbit();
        let not_before = self.busy + idle_tbit;
        if cycle.retries_left > 0 {
            cycle.retries_left = cycle.retries_left.saturating_sub(1);
            cycle.retries = cycle.retries.saturating_add(1);
            cycle.left = None;
            cycle.mismatch = None;
            self.state = State::Waiting(cycle);
            return self.transmit(self.length, not_before);
        }
        let failure = match cycle.mismatch {
            Some(mismatch) => Failure::Mismatch(mismatch),
            None if cycle.left.is_some_and(|left| left < self.busy) => Failure::Damaged,
            None => Failure::Silence,
        };
        self.state = State::Holding { idle_tbit };
        self.failed(now, &cycle, failure);
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
        // What was repeated may be answered twice, and the first answer may have been a late one. Both look alike, so the
        // second must not fall into the next message cycle: it comes within two slot times.
        let idle_tbit = match cycle.retries {
            0 => self.bus.id1_tbit(),
            _ => self.slot_tbit().saturating_mul(2),
        };
        self.state = State::Holding { idle_tbit };
        if cycle.from_user {
            self.user.confirm(end, Confirmation::Answer(Answer { retries: cycle.retries, ..answer }));
        }
    }

    /// A telegram of a responder, or one that cannot be anybody's.
    fn heard(&mut self, end: BitTime, telegram: &Telegram<'_>) {
        let slot = self.slot_tbit();
        match &mut self.state {
            State::Waiting(cycle) => match answer::matched(&cycle.asked, self.bus.address, telegram) {
                Ok(answer) => {
                    let cycle = *cycle;
                    self.answered(end, &cycle, answer);
                }
                Err(mismatch) => cycle.mismatch = Some(mismatch),
            },
            // A late answer: others may follow, and must not be taken for answers to the next request.
            State::Holding { idle_tbit } => *idle_tbit = slot.max(*idle_tbit),
            State::Listening | State::Claiming | State::Leaving(_) => {}
        }
    }

    /// When to give up waiting for an answer: a slot time after the line fell silent, but not much later than the longest
    /// answer could end.
    fn deadline(&self, cycle: &Cycle) -> Option<BitTime> {
        let slot = self.slot_tbit();
        Some((self.busy + slot).min(cycle.left? + slot + LONGEST_TBIT + slot))
    }
}

impl Cycle {
    const fn new(asked: Asked, retries_left: u8) -> Self {
        Self { asked, from_user: true, retries: 0, retries_left, left: None, mismatch: None }
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
    }

    fn sent(&mut self, end: BitTime) {
        self.busy = self.busy.max(end);
        match &mut self.state {
            State::Waiting(cycle) => cycle.left = Some(end),
            State::Leaving(Departure::Claim) => self.state = State::Claiming,
            State::Leaving(Departure::Token) => self.begin_visit(end),
            State::Leaving(Departure::Unconfirmed) => {
                self.state = State::Holding { idle_tbit: self.bus.id2_tbit() };
                self.user.confirm(end, Confirmation::Sent);
            }
            // The answer was faster than the news that the request has left.
            State::Holding { .. } | State::Claiming | State::Listening => {}
        }
    }

    fn poll(&mut self, now: BitTime) -> Option<Transmit<'_>> {
        let due = self.wake_at().filter(|due| *due <= now)?;
        match self.state {
            State::Listening => self.pass_token(Departure::Claim, due),
            State::Claiming => self.pass_token(Departure::Token, due),
            State::Holding { .. } => self.work(now, due),
            State::Waiting(cycle) => self.expire(now, cycle),
            State::Leaving(_) => None,
        }
    }

    /// Everything this station waits for is a line that has been quiet for long enough.
    #[inline]
    fn wake_at(&self) -> Option<BitTime> {
        match &self.state {
            State::Listening => Some(self.busy + self.bus.timeout_tbit()),
            State::Claiming => Some(self.busy + self.token_idle_tbit()),
            State::Holding { idle_tbit } => Some(self.busy + *idle_tbit),
            State::Waiting(cycle) => self.deadline(cycle),
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
