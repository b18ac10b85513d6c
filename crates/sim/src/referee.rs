//! The referee checks each telegram at its start against the timing and token rules of profibus-wire 1.7, 1.10, 1.12 and 1.13.
//!
//! The referee uses the telegrams as sent, so noise, lost octets and cut cables violate no rule. It measures each time where
//! the rule applies: T_SDR at the responder, idle times at the sender, the slot time at the requester.

use crate::rule::{Rule, Verdict, Violated, at_least, at_most, violates};
use crate::station_id::StationId;
use crate::token::{Token, TokenUse};
use profivac_dp::link::active::BusParameters;
use profivac_dp::link::{Baud, BitTime, CHARACTER_TBIT, T_SYN_TBIT};
use profivac_wire::control::{Control, Function};
use profivac_wire::diag::SlaveDiag;
use profivac_wire::prm::SetPrm;
use profivac_wire::{BROADCAST, DataTelegram, Sap, Telegram};
use std::collections::VecDeque;

/// min T_SDR of a slave before its first Set_Prm.
const DEFAULT_MIN_TSDR_TBIT: u8 = 11;

/// The number of previous telegrams that can still be on the line.
const REMEMBERED: usize = 4;

/// The limits from the bus parameters, in bit times. profibus-wire 1.12.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Limits {
    /// Idle time before a request after an answer, an acknowledgement or a token.
    pub id1_tbit: u64,
    /// Idle time before a request after a request without answer.
    pub id2_tbit: u64,
    /// The latest start of an answer.
    pub max_tsdr_tbit: u64,
    /// T_SL, from the end of a request to the end of the first character of its answer.
    pub slot_tbit: u64,
}

impl Limits {
    /// The default limits of a baud rate, with max T_SDR as the slaves of this project declare it.
    #[must_use]
    pub fn of(baud: Baud) -> Self {
        let bus = BusParameters::new(0, baud);
        Self { max_tsdr_tbit: u64::from(baud.max_tsdr_tbit()), ..Self::of_bus(&bus) }
    }

    /// The limits of a master with these bus parameters.
    #[must_use]
    pub fn of_bus(bus: &BusParameters) -> Self {
        Self {
            id1_tbit: bus.id1_tbit(),
            id2_tbit: bus.id2_tbit(),
            max_tsdr_tbit: u64::from(bus.max_tsdr_tbit),
            slot_tbit: u64::from(bus.slot_tbit),
        }
    }
}

/// A transmission: station, position and times.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Transmission {
    pub(crate) station: StationId,
    pub(crate) position: u64,
    pub(crate) begin: BitTime,
    pub(crate) end: BitTime,
    /// The sender paused inside the telegram.
    pub(crate) paused: bool,
}

impl Transmission {
    fn distance(&self, other: &Self) -> u64 {
        self.position.abs_diff(other.position)
    }

    /// Whether this transmission overlaps with `other` at the position of `other`.
    fn covers(&self, other: &Self) -> bool {
        let away = self.distance(other);
        other.begin < self.end + away && self.begin + away < other.end
    }
}

/// The telegrams that may follow.
#[derive(Clone, Debug, PartialEq, Eq)]
enum Expected {
    /// A request: the line is unused so far.
    FirstRequest,
    /// Any telegram: after the repair of a cable the two sides have received different telegrams.
    Anything,
    /// The answer to this request.
    Answer(PendingRequest),
    /// A request, after the answer to this request.
    AfterAnswer(PendingRequest),
    /// A request, after a token.
    AfterToken,
    /// A request, after a request without answer.
    AfterUnconfirmed,
}

/// A request that needs an answer.
#[derive(Clone, Debug, PartialEq, Eq)]
struct PendingRequest {
    transmission: Transmission,
    sa: u8,
    da: u8,
    /// The min T_SDR of a Set_Prm that sets it.
    min_tsdr: Option<u8>,
}

/// Checks the transmissions of all stations.
#[derive(Clone, Debug)]
pub struct Referee {
    limits: Limits,
    allowed: Vec<Rule>,
    exempt: Vec<StationId>,
    recent: VecDeque<Transmission>,
    next: Expected,
    token: Token,
    /// The line was disturbed since the last request, so the stations may not have received it.
    disturbed: bool,
    /// min T_SDR by address, and the value of a Set_Prm that no diagnosis has confirmed yet, with its master.
    min_tsdr: [u8; 128],
    asked_tsdr: [Option<(u8, u8)>; 128],
    /// The station that answered last, by address.
    answered_by: [Option<StationId>; 128],
}

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
            answered_by: [None; 128],
        }
    }

    /// Changes the limits.
    pub const fn set_limits(&mut self, limits: Limits) {
        self.limits = limits;
    }

    /// Ignores violations of this rule.
    pub fn allow(&mut self, rule: Rule) {
        self.allowed.push(rule);
    }

    /// Reports violations of this rule again.
    pub fn disallow(&mut self, rule: Rule) {
        self.allowed.retain(|allowed| *allowed != rule);
    }

    /// Expects the token to go around these stations from `from` on. Without addresses any token is accepted.
    pub fn expect_ring(&mut self, addresses: &[u8], from: BitTime) {
        if addresses.is_empty() { self.token.expect_nothing() } else { self.token.expect_ring(addresses, from) }
    }

    /// Ignores violations of this station. The reactions of other stations are still checked.
    pub fn exempt(&mut self, station: StationId) {
        self.exempt.push(station);
    }

    /// Notes that a station lost its power at `now`: its transmission ends and its min T_SDR is lost.
    pub(crate) fn power_failed(&mut self, station: StationId, now: BitTime) {
        for transmission in
            self.recent.iter_mut().filter(|transmission| transmission.station == station && transmission.end > now)
        {
            transmission.end = now;
            self.disturbed = true;
            self.token.forget();
        }
        for (address, _) in self.answered_by.iter().enumerate().filter(|(_, by)| **by == Some(station)) {
            self.min_tsdr[address] = DEFAULT_MIN_TSDR_TBIT;
            self.asked_tsdr[address] = None;
        }
    }

    /// Deletes the last transmissions: not every station has received them.
    pub(crate) fn forget(&mut self) {
        self.recent.clear();
        self.next = Expected::Anything;
        self.token.forget();
    }

    /// Notes a disturbance of the line.
    pub(crate) const fn disturb(&mut self) {
        self.disturbed = true;
        self.token.forget();
    }

    /// Checks the start of a transmission. `telegram` is `None` if the octets are not a telegram.
    pub(crate) fn check(&mut self, transmission: Transmission, telegram: Option<&Telegram<'_>>) -> Verdict {
        let exempt = self.exempt.contains(&transmission.station);
        let verdict = self.verdict(&transmission, telegram);
        if self.recent.len() == REMEMBERED {
            self.recent.pop_front();
        }
        self.recent.push_back(transmission);
        match verdict {
            Err(Violated { rule, .. }) if exempt || self.allowed.contains(&rule) => Ok(()),
            verdict => verdict,
        }
    }

    fn verdict(&mut self, transmission: &Transmission, telegram: Option<&Telegram<'_>>) -> Verdict {
        let collides = self.recent.iter().any(|other| other.covers(transmission) || transmission.covers(other));
        let timing = match telegram {
            Some(Telegram::ShortAck) => self.answer(transmission, None),
            Some(Telegram::Token { da, sa }) => {
                let token = self.check_token(transmission, *sa, Some(*da));
                self.request(transmission, Expected::AfterToken).and(token)
            }
            Some(Telegram::Data(data)) => match data.control() {
                Control::Response { .. } => self.answer(transmission, Some(data)),
                Control::Request { function, .. } => {
                    let next = pending_request(transmission, data, function)
                        .map_or(Expected::AfterUnconfirmed, Expected::Answer);
                    let token = self.check_token(transmission, data.sa, None);
                    self.request(transmission, next).and(token)
                }
            },
            None => violates(Rule::NoTelegram),
        };
        if collides {
            self.token.forget();
            return violates(Rule::Collision);
        }
        if transmission.paused {
            return violates(Rule::Gap);
        }
        timing
    }

    /// Checks a transmission that only the holder of the token may begin.
    fn check_token(&mut self, transmission: &Transmission, sa: u8, token_to: Option<u8>) -> Verdict {
        let idle_tbit = self.idle_since(transmission).map(|since| transmission.begin - since);
        self.token.check(TokenUse { sa, token_to, at: transmission.begin, idle_tbit }, self.limits.slot_tbit)
    }

    /// The end of the last telegram at the position of this one.
    fn idle_since(&self, transmission: &Transmission) -> Option<BitTime> {
        self.recent.iter().map(|other| other.end + other.distance(transmission)).max()
    }

    /// Checks a request or a token; `next` may follow it.
    fn request(&mut self, transmission: &Transmission, next: Expected) -> Verdict {
        let before = std::mem::replace(&mut self.next, next);
        let disturbed = std::mem::take(&mut self.disturbed);
        let Some(quiet_since) = self.idle_since(transmission) else { return Ok(()) };
        let idle = transmission.begin - quiet_since;
        at_least(Rule::Syn, idle, T_SYN_TBIT)?;
        match before {
            Expected::FirstRequest | Expected::Anything => Ok(()),
            Expected::Answer(_) if disturbed => Ok(()),
            Expected::Answer(_) => at_least(Rule::BeforeSlotTime, idle, self.limits.slot_tbit),
            Expected::AfterAnswer(_) => at_least(Rule::Id1, idle, self.limits.id1_tbit),
            // A station that passes the token to itself both sends and receives it; T_ID1 applies: profibus-wire 8.2.
            Expected::AfterToken => at_least(Rule::Id1, idle, self.limits.id1_tbit),
            Expected::AfterUnconfirmed => at_least(Rule::Id2, idle, self.limits.id2_tbit),
        }
    }

    /// Checks an answer; `None` is SC, which has no addresses.
    fn answer(&mut self, transmission: &Transmission, data: Option<&DataTelegram<'_>>) -> Verdict {
        let unasked = violates(Rule::Unrequested);
        let asked = match &self.next {
            Expected::Answer(asked) | Expected::AfterAnswer(asked) => asked.clone(),
            Expected::Anything => return Ok(()),
            Expected::FirstRequest | Expected::AfterToken | Expected::AfterUnconfirmed => return unasked,
        };
        if data.is_some_and(|data| (data.da, data.sa) != (asked.sa, asked.da)) {
            return unasked;
        }
        if matches!(self.next, Expected::AfterAnswer(_)) {
            return violates(Rule::SecondAnswer);
        }
        let min_tsdr = u64::from(self.min_tsdr[usize::from(asked.da)]);
        self.answered_by[usize::from(asked.da)] = Some(transmission.station);
        self.learn_min_tsdr(&asked, data);
        self.next = Expected::AfterAnswer(asked.clone());
        let away = asked.transmission.distance(transmission);
        let tsdr = transmission.begin - (asked.transmission.end + away);
        at_least(Rule::Early, tsdr, min_tsdr)?;
        at_most(Rule::Late, tsdr, self.limits.max_tsdr_tbit)?;
        let first_character = transmission.begin + away + CHARACTER_TBIT;
        at_most(Rule::Slot, first_character - asked.transmission.end, self.limits.slot_tbit)
    }

    /// Tracks min T_SDR. A diagnosis that names the master confirms that the slave accepted its Set_Prm; until then both values
    /// are permitted.
    fn learn_min_tsdr(&mut self, asked: &PendingRequest, data: Option<&DataTelegram<'_>>) {
        let slave = usize::from(asked.da);
        if let (Some(new), None) = (asked.min_tsdr, data) {
            self.min_tsdr[slave] = self.min_tsdr[slave].min(new);
            self.asked_tsdr[slave] = Some((asked.sa, new));
        }
        let diag = data.filter(|data| Sap::from_octet(data.ssap) == Sap::SlaveDiag);
        if let Some(Ok(diag)) = diag.map(|data| SlaveDiag::parse(data.du))
            && let Some((master, new)) = self.asked_tsdr[slave].take()
            && master == diag.master_add
        {
            self.min_tsdr[slave] = new;
        }
    }
}

/// The request, if its function needs an answer.
fn pending_request(transmission: &Transmission, data: &DataTelegram<'_>, function: Function) -> Option<PendingRequest> {
    let confirmed = match function {
        Function::SrdLow | Function::SrdHigh | Function::SdaLow | Function::SdaHigh => true,
        Function::FdlStatus | Function::Ident | Function::LsapStatus => true,
        Function::SdnLow | Function::SdnHigh | Function::Other(_) => false,
    };
    let set_prm = SetPrm::parse(data.du).ok().filter(|_| Sap::from_octet(data.dsap) == Sap::SetPrm);
    let min_tsdr = set_prm.map(|prm| prm.min_tsdr).filter(|tbit| *tbit != 0);
    (confirmed && data.da != BROADCAST).then(|| PendingRequest {
        transmission: *transmission,
        sa: data.sa,
        da: data.da,
        min_tsdr: min_tsdr.map(|tbit| tbit.max(DEFAULT_MIN_TSDR_TBIT)),
    })
}
