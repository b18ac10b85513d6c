//! Who may speak when. Each telegram is judged as it begins, by the rules of profibus-wire 1.7, 1.10, 1.12 and 1.13.
//!
//! The referee knows what stations send, not what others make of it: noise, lost octets and cut cables are nobody's fault.
//! Times are taken where the rule applies: T_SDR at the responder, idle times at the sender, the slot time at the requester.

use crate::segment::StationId;
use crate::token::{Token, TokenUse};
use profivac_dp::link::active::BusParameters;
use profivac_dp::link::{Baud, BitTime, CHARACTER_TBIT, T_SYN_TBIT};
use profivac_wire::control::{Control, Function};
use profivac_wire::diag::SlaveDiag;
use profivac_wire::prm::SetPrm;
use profivac_wire::{BROADCAST, DataTelegram, Sap, Telegram};
use std::collections::VecDeque;
use std::fmt;

/// min T_SDR of a slave that nobody told otherwise.
const DEFAULT_MIN_TSDR_TBIT: u8 = 11;

/// How many telegrams back one can still be on the line.
const REMEMBERED: usize = 4;

/// What a station did wrong.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Rule {
    /// It spoke while another did.
    Collision,
    /// It sent something that is no telegram.
    NoTelegram,
    /// It paused inside a telegram.
    Gap,
    /// It began a request or a token inside T_SYN.
    Syn,
    /// It began a request inside T_ID1, after an answer or a token.
    Id1,
    /// It began a request inside T_ID2, after a request that is not answered.
    Id2,
    /// It began a request while the slot time of the one before was running and no answer had come.
    BeforeSlotTime,
    /// It answered before min T_SDR.
    Early,
    /// It answered after max T_SDR.
    Late,
    /// Its answer reached the requester after the slot time.
    Slot,
    /// It answered though nobody had asked it.
    Unrequested,
    /// It answered, or another did, though the answer had come already.
    SecondAnswer,
    /// It asked while another station had the token.
    NoToken,
    /// It passed a token while another station had one.
    SecondToken,
    /// It passed the token outside the ring that should be whole by now.
    Ring,
}

impl Rule {
    /// What happened and how it should be. Both in bit times where that says something.
    const fn words(self) -> (&'static str, Option<&'static str>) {
        match self {
            Self::Collision => ("it spoke while another station did", None),
            Self::NoTelegram => ("what it sent is no telegram", None),
            Self::Gap => ("it paused inside a telegram", None),
            Self::Syn => ("it began a request after an idle time of", Some("T_SYN")),
            Self::Id1 => ("it began a request after an idle time of", Some("T_ID1")),
            Self::Id2 => ("it began a request after an idle time of", Some("T_ID2")),
            Self::BeforeSlotTime => ("it did not wait for the answer: it began a request after", Some("T_SL")),
            Self::Early => ("it answered after", Some("min T_SDR")),
            Self::Late => ("it answered after", Some("max T_SDR")),
            Self::Slot => ("its answer reached the requester after", Some("T_SL")),
            Self::Unrequested => ("it answered, and nobody had asked it", None),
            Self::SecondAnswer => ("the request was answered already", None),
            Self::NoToken => ("it began a request, and another station has the token", None),
            Self::SecondToken => ("it passed a token, and another station has one", None),
            Self::Ring => ("it did not pass the token to its successor in the ring", None),
        }
    }
}

/// A broken rule. `Debug` and `Display` both tell the story, so that a failed test shows it.
#[derive(Clone, PartialEq, Eq)]
pub struct Violation {
    /// The rule.
    pub rule: Rule,
    /// The station that broke it.
    pub station: StationId,
    /// When its telegram began.
    pub at: BitTime,
    /// The time it took, in bit times, where the rule is about one.
    pub measured_tbit: u64,
    /// The time it should have taken at least or at most.
    pub limit_tbit: u64,
    /// What was on the line up to and including the telegram.
    pub trace: String,
}

impl fmt::Display for Violation {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let (what, limit) = self.rule.words();
        write!(f, "bit time {}, {}: {what}", self.at, self.station)?;
        if let Some(limit) = limit {
            write!(f, " {} bit times, {limit} is {}", self.measured_tbit, self.limit_tbit)?;
        }
        write!(f, "\n{}", self.trace)
    }
}

impl fmt::Debug for Violation {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        fmt::Display::fmt(self, f)
    }
}

impl std::error::Error for Violation {}

/// The times that depend on the bus parameters, in bit times. profibus-wire 1.12.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Limits {
    /// Idle before a request after an answer, an acknowledgement or a token.
    pub t_id1: u64,
    /// Idle before a request after one that is not answered.
    pub t_id2: u64,
    /// The latest start of an answer.
    pub max_tsdr: u64,
    /// T_SL, from the end of a request to the end of the first character of its answer.
    pub slot: u64,
}

impl Limits {
    /// The default set of a rate, and max T_SDR as a slave of this project declares it.
    #[must_use]
    pub fn of(baud: Baud) -> Self {
        let bus = BusParameters::new(0, baud);
        Self { max_tsdr: u64::from(baud.max_tsdr_tbit()), ..Self::of_bus(&bus) }
    }

    /// What a master keeps to and expects.
    #[must_use]
    pub fn of_bus(bus: &BusParameters) -> Self {
        Self {
            t_id1: bus.id1_tbit(),
            t_id2: bus.id2_tbit(),
            max_tsdr: u64::from(bus.max_tsdr_tbit),
            slot: u64::from(bus.slot_tbit),
        }
    }
}

/// Someone speaks: where, from when to when.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Transmission {
    pub(crate) station: StationId,
    pub(crate) position: u64,
    pub(crate) begin: BitTime,
    pub(crate) end: BitTime,
    /// The sender itself paused.
    pub(crate) paused: bool,
}

impl Transmission {
    fn distance(&self, other: &Self) -> u64 {
        self.position.abs_diff(other.position)
    }

    /// Whether it still is on the line at `place` when that one begins to speak there.
    fn covers(&self, place: &Self) -> bool {
        let away = self.distance(place);
        place.begin < self.end + away && self.begin + away < place.end
    }
}

/// What may come next.
#[derive(Clone, Debug, PartialEq, Eq)]
enum Expected {
    /// A request: nothing was said yet.
    FirstRequest,
    /// Whatever there is: the cable was mended, and nobody knows what both sides have heard.
    Anything,
    /// The answer to a request.
    Answer(PendingRequest),
    /// A request, after an answer to this one.
    AfterAnswer(PendingRequest),
    /// A request, after a token.
    AfterToken,
    /// A request, after one that is not answered.
    AfterUnconfirmed,
}

/// A request that is to be answered.
#[derive(Clone, Debug, PartialEq, Eq)]
struct PendingRequest {
    speech: Transmission,
    sa: u8,
    da: u8,
    /// The min T_SDR it brings, if it is a Set_Prm with one.
    min_tsdr: Option<u8>,
}

/// Judges what stations send.
#[derive(Clone, Debug)]
pub struct Referee {
    limits: Limits,
    allowed: Vec<Rule>,
    exempt: Vec<StationId>,
    recent: VecDeque<Transmission>,
    next: Expected,
    token: Token,
    /// The line was not what the stations sent since the last request, so nobody need know that it was one.
    disturbed: bool,
    /// min T_SDR by address, and what a Set_Prm from a master asked for that no diagnosis has confirmed yet.
    min_tsdr: [u8; 128],
    asked_tsdr: [Option<(u8, u8)>; 128],
}

/// A rule, and the time that was measured beside the one it allows.
pub(crate) type Verdict = Result<(), (Rule, u64, u64)>;

impl Referee {
    pub(crate) fn new(limits: Limits) -> Self {
        Self {
            limits,
            allowed: Vec::new(),
            exempt: Vec::new(),
            recent: VecDeque::new(),
            next: Expected::FirstRequest,
            token: Token::default(),
            disturbed: false,
            min_tsdr: [DEFAULT_MIN_TSDR_TBIT; 128],
            asked_tsdr: [None; 128],
        }
    }

    /// Judges by other times from now on.
    pub const fn set_limits(&mut self, limits: Limits) {
        self.limits = limits;
    }

    /// Does not stop the run for this rule any more.
    pub fn allow(&mut self, rule: Rule) {
        self.allowed.push(rule);
    }

    /// Stops the run for this rule again.
    pub fn disallow(&mut self, rule: Rule) {
        self.allowed.retain(|allowed| *allowed != rule);
    }

    /// From `from` on the token has to go around these stations; around none, it may go where it likes.
    pub fn expect_ring(&mut self, addresses: &[u8], from: BitTime) {
        if addresses.is_empty() { self.token.expect_nothing() } else { self.token.expect_ring(addresses, from) }
    }

    /// Lets this station send what and when it likes. What others do about it is still judged.
    pub fn exempt(&mut self, station: StationId) {
        self.exempt.push(station);
    }

    /// A station has lost its power at `now`, and with it the rest of what it said and the min T_SDR it was given.
    pub(crate) fn power_failed(&mut self, station: StationId, now: BitTime) {
        for speech in self.recent.iter_mut().filter(|speech| speech.station == station && speech.end > now) {
            speech.end = now;
            self.disturbed = true;
            self.token.forget();
        }
        self.min_tsdr = [DEFAULT_MIN_TSDR_TBIT; 128];
        self.asked_tsdr = [None; 128];
    }

    /// What was said last was not heard by everybody.
    pub(crate) fn forget(&mut self) {
        self.recent.clear();
        self.next = Expected::Anything;
        self.token.forget();
    }

    /// The line was disturbed.
    pub(crate) const fn disturb(&mut self) {
        self.disturbed = true;
        self.token.forget();
    }

    /// Someone begins to say `telegram`, or something that is none.
    pub(crate) fn check(&mut self, speech: Transmission, telegram: Option<&Telegram<'_>>) -> Verdict {
        let exempt = self.exempt.contains(&speech.station);
        let verdict = self.verdict(&speech, telegram);
        if self.recent.len() == REMEMBERED {
            self.recent.pop_front();
        }
        self.recent.push_back(speech);
        match verdict {
            Err((rule, ..)) if exempt || self.allowed.contains(&rule) => Ok(()),
            verdict => verdict,
        }
    }

    fn verdict(&mut self, speech: &Transmission, telegram: Option<&Telegram<'_>>) -> Verdict {
        let collides = self.recent.iter().any(|other| other.covers(speech) || speech.covers(other));
        let timing = match telegram {
            Some(Telegram::ShortAck) => self.answer(speech, None),
            Some(Telegram::Token { da, sa }) => {
                let token = self.check_token(speech, *sa, Some(*da));
                self.request(speech, Expected::AfterToken).and(token)
            }
            Some(Telegram::Data(frame)) => match frame.control() {
                Control::Response { .. } => self.answer(speech, Some(frame)),
                Control::Request { function, .. } => {
                    let next =
                        pending_request(speech, frame, function).map_or(Expected::AfterUnconfirmed, Expected::Answer);
                    let token = self.check_token(speech, frame.sa, None);
                    self.request(speech, next).and(token)
                }
            },
            None => Err((Rule::NoTelegram, 0, 0)),
        };
        if collides {
            self.token.forget();
            return Err((Rule::Collision, 0, 0));
        }
        if speech.paused {
            return Err((Rule::Gap, 0, 0));
        }
        timing
    }

    /// A station begins, as only the one with the token may.
    fn check_token(&mut self, speech: &Transmission, sa: u8, token_to: Option<u8>) -> Verdict {
        let idle_tbit = self.idle_since(speech).map(|since| speech.begin - since);
        self.token.check(TokenUse { sa, token_to, at: speech.begin, idle_tbit }, self.limits.slot)
    }

    /// When the last telegram ended where this one is sent.
    fn idle_since(&self, speech: &Transmission) -> Option<BitTime> {
        self.recent.iter().map(|other| other.end + other.distance(speech)).max()
    }

    /// A request or a token, after which `next` may come.
    fn request(&mut self, speech: &Transmission, next: Expected) -> Verdict {
        let before = std::mem::replace(&mut self.next, next);
        let disturbed = std::mem::take(&mut self.disturbed);
        let Some(quiet_since) = self.idle_since(speech) else { return Ok(()) };
        let idle = speech.begin - quiet_since;
        at_least(Rule::Syn, idle, T_SYN_TBIT)?;
        match before {
            Expected::FirstRequest | Expected::Anything => Ok(()),
            Expected::Answer(_) if disturbed => Ok(()),
            Expected::Answer(_) => at_least(Rule::BeforeSlotTime, idle, self.limits.slot),
            Expected::AfterAnswer(_) => at_least(Rule::Id1, idle, self.limits.t_id1),
            // A station that passes the token to itself sends it and receives it; profibus-wire 8.2 lets T_ID1 follow.
            Expected::AfterToken => at_least(Rule::Id1, idle, self.limits.t_id1),
            Expected::AfterUnconfirmed => at_least(Rule::Id2, idle, self.limits.t_id2),
        }
    }

    /// An answer; `None` is SC, which names nobody.
    fn answer(&mut self, speech: &Transmission, frame: Option<&DataTelegram<'_>>) -> Verdict {
        let unasked = Err((Rule::Unrequested, 0, 0));
        let asked = match &self.next {
            Expected::Answer(asked) | Expected::AfterAnswer(asked) => asked.clone(),
            Expected::Anything => return Ok(()),
            Expected::FirstRequest | Expected::AfterToken | Expected::AfterUnconfirmed => return unasked,
        };
        if frame.is_some_and(|frame| (frame.da, frame.sa) != (asked.sa, asked.da)) {
            return unasked;
        }
        if matches!(self.next, Expected::AfterAnswer(_)) {
            return Err((Rule::SecondAnswer, 0, 0));
        }
        let min_tsdr = u64::from(self.min_tsdr[usize::from(asked.da)]);
        self.learn_min_tsdr(&asked, frame);
        self.next = Expected::AfterAnswer(asked.clone());
        let away = asked.speech.distance(speech);
        let tsdr = speech.begin - (asked.speech.end + away);
        at_least(Rule::Early, tsdr, min_tsdr)?;
        at_most(Rule::Late, tsdr, self.limits.max_tsdr)?;
        let first_character = speech.begin + away + CHARACTER_TBIT;
        at_most(Rule::Slot, first_character - asked.speech.end, self.limits.slot)
    }

    /// Follows min T_SDR. Whether a slave took a Set_Prm is only known when its diagnosis names the master; until then both
    /// values are good.
    fn learn_min_tsdr(&mut self, asked: &PendingRequest, frame: Option<&DataTelegram<'_>>) {
        let slave = usize::from(asked.da);
        if let (Some(new), None) = (asked.min_tsdr, frame) {
            self.min_tsdr[slave] = self.min_tsdr[slave].min(new);
            self.asked_tsdr[slave] = Some((asked.sa, new));
        }
        let diag = frame.filter(|frame| Sap::from_octet(frame.ssap) == Sap::SlaveDiag);
        if let Some(Ok(diag)) = diag.map(|frame| SlaveDiag::parse(frame.du))
            && let Some((master, new)) = self.asked_tsdr[slave].take()
            && master == diag.master_add
        {
            self.min_tsdr[slave] = new;
        }
    }
}

/// The request, if its function is to be answered.
fn pending_request(speech: &Transmission, frame: &DataTelegram<'_>, function: Function) -> Option<PendingRequest> {
    let confirmed = match function {
        Function::SrdLow | Function::SrdHigh | Function::SdaLow | Function::SdaHigh => true,
        Function::FdlStatus | Function::Ident | Function::LsapStatus => true,
        Function::SdnLow | Function::SdnHigh | Function::Other(_) => false,
    };
    let set_prm = SetPrm::parse(frame.du).ok().filter(|_| Sap::from_octet(frame.dsap) == Sap::SetPrm);
    let min_tsdr = set_prm.map(|prm| prm.min_tsdr).filter(|tbit| *tbit != 0);
    (confirmed && frame.da != BROADCAST).then(|| PendingRequest {
        speech: *speech,
        sa: frame.sa,
        da: frame.da,
        min_tsdr: min_tsdr.map(|tbit| tbit.max(DEFAULT_MIN_TSDR_TBIT)),
    })
}

const fn at_least(rule: Rule, measured: u64, limit: u64) -> Verdict {
    if measured < limit { Err((rule, measured, limit)) } else { Ok(()) }
}

const fn at_most(rule: Rule, measured: u64, limit: u64) -> Verdict {
    if measured > limit { Err((rule, measured, limit)) } else { Ok(()) }
}
