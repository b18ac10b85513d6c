//! Requests of a check to the slave, and its answers.
//!
//! Every step fails with a `StepError`. A check decides what that means: `Step::tested` makes it a broken rule, `Step::prepared`
//! makes the rule one that was not tested. Only checks take steps: from outside, a [`Dialogue`] is made and given to a check.

mod services;
mod step;
mod telegrams;

pub use step::{CheckError, CheckOutcome};
pub(crate) use step::{Step, StepError, StepResult, require, require_same, without};
pub(crate) use telegrams::{
    Answer, FDL_STATUS, SRD_HIGH_FIRST, global_control, parse_answer, request_octets, response, set_prm_octets,
};
pub use telegrams::{octets, telegram_octets};

use super::expected::{Expected, Unanswered};
use super::probe::Received;
use profivac_host::port::PortError;
use profivac_wire::Sap;
use profivac_wire::control::{Control, FrameCount, Function};
use serde::{Deserialize, Serialize};
use std::time::Duration;

/// Sends octets to the slave and receives its answers.
pub trait Link {
    /// The address of the master that sends.
    fn address(&self) -> u8;

    /// Sends `octets` and waits for an answer for one slot time.
    ///
    /// # Errors
    /// [`PortError`] if the port is lost.
    fn send_and_receive(&mut self, octets: &[u8]) -> Result<Received, PortError>;

    /// Whether the link sends `octets`. A link may withhold requests that change the slave; a rule that needs one of them is
    /// not tested.
    fn permits(&self, _octets: &[u8]) -> bool {
        true
    }

    /// Sends nothing for this time.
    ///
    /// # Errors
    /// [`PortError`] if the port is lost.
    fn wait(&mut self, time: Duration) -> Result<(), PortError>;

    /// Whether the line or the computer has disturbed the test since the last call: octets behind the slot time, or a stall. Such
    /// a test shows nothing about the slave. A link without a clock reports nothing.
    fn take_disturbed(&mut self) -> bool {
        false
    }
}

/// The slave under test, with the parameters that start its data exchange.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct SlaveUnderTest {
    /// Address.
    pub address: u8,
    /// Ident_Number.
    pub ident: u16,
    /// Configuration for Chk_Cfg.
    pub cfg: Vec<u8>,
    /// User_Prm_Data that the slave accepts.
    pub user_prm: Vec<u8>,
    /// What its GSD file states, if there is one.
    pub stated: Option<Stated>,
}

/// What a GSD file states about a slave.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Stated {
    /// Max_Diag_Data_Len, in octets.
    pub max_diag_len: Option<u8>,
    /// Sync_Mode_supp.
    pub sync: bool,
    /// Freeze_Mode_supp.
    pub freeze: bool,
    /// Fail_Safe: outputs of length 0 are understood.
    pub fail_safe: bool,
    /// DPV1_Slave: the user parameters begin with the DP-V1 status.
    pub dpv1: bool,
    /// C1_Read_Write_supp.
    pub ms1: bool,
    /// C2_Read_Write_supp.
    pub ms2: bool,
}

/// A message cycle.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct LoggedCycle {
    /// The octets that the probe sent.
    pub sent: Vec<u8>,
    /// The answer.
    pub received: Received,
}

/// The frame count bits of the requests (profibus-wire 1.10).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum CountMode {
    /// Every request is a first one, which a slave executes whatever it remembers.
    First,
    /// The bit alternates, as that of a master.
    Alternating,
}

/// Sends requests to the slave and keeps the last message cycle, so that a broken rule can be shown with its octets.
pub struct Dialogue<'a> {
    /// The slave under test.
    pub slave: &'a SlaveUnderTest,
    link: &'a mut dyn Link,
    mode: CountMode,
    /// The frame count bit of the next request of each source; `None` before the first request.
    counts: [Option<bool>; 128],
    last: Option<LoggedCycle>,
    /// The link has withheld a request of this check.
    has_withheld: bool,
    /// An answer of this test was damaged.
    has_damaged: bool,
    /// A request for a connection of MS2 was sent since the last [`settle`](Self::settle).
    has_initiated: bool,
}

impl<'a> Dialogue<'a> {
    /// A dialogue that has sent nothing.
    pub fn new(link: &'a mut dyn Link, slave: &'a SlaveUnderTest) -> Self {
        Self {
            slave,
            link,
            mode: CountMode::First,
            counts: [None; 128],
            last: None,
            has_withheld: false,
            has_damaged: false,
            has_initiated: false,
        }
    }

    /// Changes the frame count bits of all further requests.
    pub(crate) fn set_count_mode(&mut self, mode: CountMode) {
        self.mode = mode;
    }

    /// The address of the testing master.
    pub(crate) fn own_address(&self) -> u8 {
        self.link.address()
    }

    /// The address of a second master, which the testing master uses too.
    pub(crate) fn other_master_address(&self) -> u8 {
        if self.own_address() == 3 { 4 } else { 3 }
    }

    /// Returns the last message cycle since the last call.
    pub(crate) const fn take_last(&mut self) -> Option<LoggedCycle> {
        self.last.take()
    }

    /// Keeps `cycle` as the last message cycle: the one that a broken rule is shown with.
    pub(crate) fn show(&mut self, cycle: Option<LoggedCycle>) {
        self.last = cycle;
    }

    /// Whether the link has withheld a request since the last call.
    pub(crate) const fn take_withheld(&mut self) -> bool {
        std::mem::replace(&mut self.has_withheld, false)
    }

    /// Whether the line has delivered something since the last call that it may have damaged or delayed itself.
    pub(crate) fn take_disturbed(&mut self) -> bool {
        std::mem::replace(&mut self.has_damaged, false) | self.link.take_disturbed()
    }

    /// Sends nothing for this time.
    pub(crate) fn wait(&mut self, time: Duration) -> CheckOutcome {
        // A request was withheld: the rule ends as not tested, and the time is spared.
        if !self.has_withheld {
            self.link.wait(time)?;
        }
        Ok(())
    }

    /// Sends octets unchanged. Returns the answer.
    pub(crate) fn send(&mut self, octets: &[u8]) -> Result<Received, PortError> {
        if !self.link.permits(octets) {
            self.has_withheld = true;
            return Ok(Received::Nothing);
        }
        let received = self.link.send_and_receive(octets)?;
        self.has_damaged |= received == Received::Damaged;
        self.last = Some(LoggedCycle { sent: octets.to_vec(), received: received.clone() });
        Ok(received)
    }

    /// Sends octets that no slave may answer.
    pub(crate) fn send_unanswered(&mut self, octets: &[u8], reason: Unanswered) -> StepResult {
        let received = self.send(octets)?;
        require(received == Received::Nothing, Expected::Silence(reason))
    }

    /// Sends a request. Repeats it once if no valid answer comes. Returns the answer.
    pub(crate) fn request_from(&mut self, sa: u8, sap: Sap, du: &[u8]) -> StepResult<Answer> {
        let telegram = self.next_telegram(sa, sap, du);
        self.transmit(sa, &telegram)
    }

    /// As [`request_from`](Self::request_from) with the telegram itself, made by [`next_telegram`](Self::next_telegram).
    pub(crate) fn transmit(&mut self, sa: u8, telegram: &[u8]) -> StepResult<Answer> {
        let mut received = self.send(telegram)?;
        if !matches!(received, Received::Telegram(_)) {
            received = self.send(telegram)?;
        }
        let answer = parse_answer(&received);
        // Without an answer the next request is a first one again (profibus-wire 1.10).
        let sent = answer.is_ok().then(|| self.next_count(sa));
        self.keep_count(sa, sent);
        answer
    }

    /// Keeps the bit of the next request of `sa` after one that was `sent` and answered.
    fn keep_count(&mut self, sa: u8, sent: Option<FrameCount>) {
        let Some(next) = self.counts.get_mut(usize::from(sa)) else { return };
        *next = match sent {
            Some(FrameCount::First | FrameCount::Counted(true)) => Some(false),
            Some(FrameCount::Counted(false)) => Some(true),
            Some(FrameCount::Uncounted) => *next,
            None => None,
        };
    }

    /// Sends a request from the testing master. Returns the answer.
    pub(crate) fn request(&mut self, sap: Sap, du: &[u8]) -> StepResult<Answer> {
        self.request_from(self.own_address(), sap, du)
    }

    /// Sends a request whose answer does not matter.
    pub(crate) fn tell_from(&mut self, sa: u8, sap: Sap, du: &[u8]) -> Result<(), PortError> {
        match self.request_from(sa, sap, du) {
            Ok(_) | Err(StepError::Unexpected(_)) => Ok(()),
            Err(StepError::Port(error)) => Err(error),
        }
    }

    /// Sends a request from the testing master whose answer does not matter.
    pub(crate) fn tell(&mut self, sap: Sap, du: &[u8]) -> Result<(), PortError> {
        self.tell_from(self.own_address(), sap, du)
    }

    /// The telegram that [`request_from`](Self::request_from) sends next.
    pub(crate) fn next_telegram(&mut self, sa: u8, sap: Sap, du: &[u8]) -> Vec<u8> {
        self.has_initiated |= sap == Sap::ResourceManager;
        self.telegram(sa, sap, self.next_count(sa), du)
    }

    /// The frame count of the next request of `sa`.
    pub(crate) fn next_count(&self, sa: u8) -> FrameCount {
        let next = self.counts.get(usize::from(sa)).copied().flatten();
        match self.mode {
            CountMode::First => FrameCount::First,
            CountMode::Alternating => next.map_or(FrameCount::First, FrameCount::Counted),
        }
    }

    /// The telegram of a request with this frame count.
    pub(crate) fn telegram(&self, sa: u8, sap: Sap, count: FrameCount, du: &[u8]) -> Vec<u8> {
        let function = if is_acyclic(sap) { Function::SrdLow } else { Function::SrdHigh };
        octets(self.slave.address, sa, sap, Control::Request { function, count }.to_octet(), du)
    }

    /// Sends a request with this frame count, from the testing master. Returns the whole answer.
    pub(crate) fn counted(&mut self, count: FrameCount, sap: Sap, du: &[u8]) -> Result<Received, PortError> {
        let own = self.own_address();
        let telegram = self.telegram(own, sap, count, du);
        let received = self.send(&telegram)?;
        self.keep_count(own, matches!(received, Received::Telegram(_)).then_some(count));
        Ok(received)
    }
}

const fn is_acyclic(sap: Sap) -> bool {
    matches!(sap, Sap::Ms1 | Sap::Ms2(_) | Sap::ResourceManager)
}
