//! The rules of the referee and their violations. profibus-wire 1.7, 1.10, 1.12 and 1.13.

use crate::station_id::StationId;
use profivac_dp::link::BitTime;
use std::fmt;

/// A rule for stations. Each variant names its violation.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Rule {
    /// The station sent while another station was sending.
    Collision,
    /// The station sent octets that are not a telegram.
    NoTelegram,
    /// The station paused inside a telegram.
    Gap,
    /// The station began a request or a token within T_SYN.
    Syn,
    /// The station began a request within T_ID1 after an answer or a token.
    Id1,
    /// The station began a request within T_ID2 after a request without answer.
    Id2,
    /// The station began a request within the slot time of the previous request, before an answer.
    BeforeSlotTime,
    /// The station answered before min T_SDR.
    Early,
    /// The station answered after max T_SDR.
    Late,
    /// The answer of the station reached the requester after the slot time.
    Slot,
    /// The station answered without a request.
    Unrequested,
    /// The station answered a request that was already answered.
    SecondAnswer,
    /// The station began a request while another station had the token.
    NoToken,
    /// The station passed a token while another station had one.
    SecondToken,
    /// The station passed the token to another station than its successor in the expected ring.
    Ring,
}

impl Rule {
    /// The violation, and the name of the limit if the rule has one in bit times.
    const fn words(self) -> (&'static str, Option<&'static str>) {
        match self {
            Self::Collision => ("it sent while another station was sending", None),
            Self::NoTelegram => ("its octets are no telegram", None),
            Self::Gap => ("it paused inside a telegram", None),
            Self::Syn => ("it began a request after an idle time of", Some("T_SYN")),
            Self::Id1 => ("it began a request after an idle time of", Some("T_ID1")),
            Self::Id2 => ("it began a request after an idle time of", Some("T_ID2")),
            Self::BeforeSlotTime => ("it did not wait for the answer: it began a request after", Some("T_SL")),
            Self::Early => ("it answered after", Some("min T_SDR")),
            Self::Late => ("it answered after", Some("max T_SDR")),
            Self::Slot => ("its answer reached the requester after", Some("T_SL")),
            Self::Unrequested => ("it answered without a request", None),
            Self::SecondAnswer => ("the request was answered already", None),
            Self::NoToken => ("it began a request, and another station has the token", None),
            Self::SecondToken => ("it passed a token, and another station has one", None),
            Self::Ring => ("it did not pass the token to its successor in the ring", None),
        }
    }
}

/// A violation of a rule. `Debug` prints the same text as `Display`, so a failed test shows it.
#[derive(Clone, PartialEq, Eq)]
pub struct Violation {
    /// The violated rule.
    pub rule: Rule,
    /// The station that violated it.
    pub station: StationId,
    /// The begin of its telegram.
    pub at: BitTime,
    /// The measured time in bit times; 0 if the rule has no time.
    pub measured_tbit: u64,
    /// The minimum or maximum in bit times; 0 if the rule has no time.
    pub limit_tbit: u64,
    /// The trace up to and including the telegram.
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

/// A violated rule, with the measured time and its limit; both are 0 if the rule has no time.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Violated {
    pub(crate) rule: Rule,
    pub(crate) measured_tbit: u64,
    pub(crate) limit_tbit: u64,
}

/// The judgement of the referee about one telegram.
pub(crate) type Verdict = Result<(), Violated>;

/// A rule without a time is violated.
pub(crate) const fn violates(rule: Rule) -> Verdict {
    Err(Violated { rule, measured_tbit: 0, limit_tbit: 0 })
}

/// Checks a minimum.
pub(crate) const fn at_least(rule: Rule, measured_tbit: u64, limit_tbit: u64) -> Verdict {
    if measured_tbit < limit_tbit { Err(Violated { rule, measured_tbit, limit_tbit }) } else { Ok(()) }
}

/// Checks a maximum.
pub(crate) const fn at_most(rule: Rule, measured_tbit: u64, limit_tbit: u64) -> Verdict {
    if measured_tbit > limit_tbit { Err(Violated { rule, measured_tbit, limit_tbit }) } else { Ok(()) }
}
