//! Requests of a check to the slave, and its answers.
//!
//! Every step fails with a [`StepError`]. A check decides what that means: [`Step::tested`] makes it a broken rule,
//! [`Step::prepared`] makes the rule one that was not tested.

use super::expected::{Closed, Expected, Pdu, Reason, Service, Unanswered};
use super::probe::Received;
use profivac_host::port::PortError;
use profivac_wire::acyclic::{self, Response};
use profivac_wire::cfg::{self, Lengths};
use profivac_wire::control::{Control, FrameCount, Function, Status};
use profivac_wire::diag::{SlaveDiag, StationStatus};
use profivac_wire::prm::{PrmStatus, SetPrm};
use profivac_wire::sap::{MASTER_MS0, MASTER_MS1, MASTER_MS2};
use profivac_wire::{DataTelegram, MAX_DU, MAX_TELEGRAM, Sap, Telegram};
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
}

/// A message cycle.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct LoggedCycle {
    /// The octets that the probe sent.
    pub sent: Vec<u8>,
    /// The answer.
    pub received: Received,
}

/// The reason why a step failed.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum StepError {
    /// The slave did something else.
    #[error("expected {0}")]
    Unexpected(Expected),
    /// The port is lost.
    #[error(transparent)]
    Port(#[from] PortError),
}

/// Result of a step.
pub type StepResult<T = ()> = Result<T, StepError>;

/// The reason why a check ended early.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum CheckError {
    /// The slave breaks the rule.
    #[error("expected {0}")]
    Broken(Expected),
    /// The rule was not tested.
    #[error("not tested: {0}")]
    NotTested(Reason),
    /// The port is lost.
    #[error(transparent)]
    Port(#[from] PortError),
}

/// Result of a check.
pub type CheckOutcome<T = ()> = Result<T, CheckError>;

/// What the failure of a step means for the rule.
pub trait Step<T> {
    /// The rule itself: the slave breaks it.
    ///
    /// # Errors
    /// [`CheckError::Broken`].
    fn tested(self) -> CheckOutcome<T>;

    /// A preparation: the rule was not tested.
    ///
    /// # Errors
    /// [`CheckError::NotTested`].
    fn prepared(self) -> CheckOutcome<T>;
}

impl<T> Step<T> for StepResult<T> {
    fn tested(self) -> CheckOutcome<T> {
        self.map_err(|error| match error {
            StepError::Unexpected(expected) => CheckError::Broken(expected),
            StepError::Port(error) => CheckError::Port(error),
        })
    }

    fn prepared(self) -> CheckOutcome<T> {
        self.map_err(|error| match error {
            StepError::Unexpected(expected) => CheckError::NotTested(Reason::Unprepared(expected)),
            StepError::Port(error) => CheckError::Port(error),
        })
    }
}

/// Fails unless the condition `holds`.
///
/// # Errors
/// [`StepError::Unexpected`].
pub fn require(holds: bool, expected: Expected) -> StepResult {
    if holds { Ok(()) } else { Err(StepError::Unexpected(expected)) }
}

/// Fails unless `received` is the telegram `before` once more.
///
/// # Errors
/// [`StepError::Unexpected`].
pub fn require_same(received: Received, before: Received) -> StepResult {
    match before {
        Received::Telegram(octets) => {
            require(received == Received::Telegram(octets.clone()), Expected::SameAnswer(octets))
        }
        Received::Nothing | Received::Damaged => Err(StepError::Unexpected(Expected::Answer)),
    }
}

/// Ends the check: the slave does not have the service.
///
/// # Errors
/// [`CheckError::NotTested`], always.
pub const fn without<T>(service: Service) -> CheckOutcome<T> {
    Err(CheckError::NotTested(Reason::Without(service)))
}

/// A valid answer of the slave. SC is the same as SD1 with NR (profibus-wire 1.5). Addresses and access points are not
/// compared with the request: two rules of their own do that.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Answer {
    /// Its status.
    pub status: Status,
    /// Its data unit.
    pub du: Vec<u8>,
}

impl Answer {
    /// Whether it is SC or NR.
    #[must_use]
    pub fn is_acknowledgement(&self) -> bool {
        self.status == Status::NoReply && self.du.is_empty()
    }

    /// Whether it is RS.
    #[must_use]
    pub fn is_closed(&self) -> bool {
        self.status == Status::ServiceNotActivated
    }

    /// Whether it has the status of an answer with data, DL or DH.
    #[must_use]
    pub const fn has_data_status(&self) -> bool {
        matches!(self.status, Status::DataLow | Status::DataHigh)
    }
}

/// The frame count bits of the requests (profibus-wire 1.10).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum CountMode {
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
}

impl<'a> Dialogue<'a> {
    /// A dialogue that has sent nothing.
    pub fn new(link: &'a mut dyn Link, slave: &'a SlaveUnderTest) -> Self {
        Self { slave, link, mode: CountMode::First, counts: [None; 128], last: None, has_withheld: false }
    }

    /// Changes the frame count bits of all further requests.
    pub fn set_count_mode(&mut self, mode: CountMode) {
        self.mode = mode;
    }

    /// The address of the testing master.
    pub fn own_address(&self) -> u8 {
        self.link.address()
    }

    /// The address of a second master, which the testing master uses too.
    pub fn other_master_address(&self) -> u8 {
        if self.own_address() == 3 { 4 } else { 3 }
    }

    /// Returns the last message cycle since the last call.
    pub const fn take_last(&mut self) -> Option<LoggedCycle> {
        self.last.take()
    }

    /// Keeps `cycle` as the last message cycle: the one that a broken rule is shown with.
    pub fn show(&mut self, cycle: Option<LoggedCycle>) {
        self.last = cycle;
    }

    /// Whether the link has withheld a request since the last call.
    pub const fn take_withheld(&mut self) -> bool {
        std::mem::replace(&mut self.has_withheld, false)
    }

    /// Sends nothing for this time.
    pub fn wait(&mut self, time: Duration) -> CheckOutcome {
        // The check is not tested any more.
        if !self.has_withheld {
            self.link.wait(time)?;
        }
        Ok(())
    }

    /// Sends octets unchanged. Returns the answer.
    pub fn send(&mut self, octets: &[u8]) -> Result<Received, PortError> {
        if !self.link.permits(octets) {
            self.has_withheld = true;
            return Ok(Received::Nothing);
        }
        let received = self.link.send_and_receive(octets)?;
        self.last = Some(LoggedCycle { sent: octets.to_vec(), received: received.clone() });
        Ok(received)
    }

    /// Sends octets that no slave may answer.
    pub fn send_unanswered(&mut self, octets: &[u8], reason: Unanswered) -> StepResult {
        let received = self.send(octets)?;
        require(received == Received::Nothing, Expected::Silence(reason))
    }

    /// Sends a request. Repeats it once if no valid answer comes. Returns the answer.
    pub fn request_from(&mut self, sa: u8, sap: Sap, du: &[u8]) -> StepResult<Answer> {
        let telegram = self.next_telegram(sa, sap, du);
        self.transmit(sa, &telegram)
    }

    /// As [`request_from`](Self::request_from) with the telegram itself, made by [`next_telegram`](Self::next_telegram).
    pub fn transmit(&mut self, sa: u8, telegram: &[u8]) -> StepResult<Answer> {
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
    pub fn request(&mut self, sap: Sap, du: &[u8]) -> StepResult<Answer> {
        self.request_from(self.own_address(), sap, du)
    }

    /// Sends a request whose answer does not matter.
    pub fn tell_from(&mut self, sa: u8, sap: Sap, du: &[u8]) -> Result<(), PortError> {
        match self.request_from(sa, sap, du) {
            Ok(_) | Err(StepError::Unexpected(_)) => Ok(()),
            Err(StepError::Port(error)) => Err(error),
        }
    }

    /// Sends a request from the testing master whose answer does not matter.
    pub fn tell(&mut self, sap: Sap, du: &[u8]) -> Result<(), PortError> {
        self.tell_from(self.own_address(), sap, du)
    }

    /// The telegram that [`request_from`](Self::request_from) sends next.
    pub fn next_telegram(&self, sa: u8, sap: Sap, du: &[u8]) -> Vec<u8> {
        self.telegram(sa, sap, self.next_count(sa), du)
    }

    /// The frame count of the next request of `sa`.
    pub fn next_count(&self, sa: u8) -> FrameCount {
        let next = self.counts.get(usize::from(sa)).copied().flatten();
        match self.mode {
            CountMode::First => FrameCount::First,
            CountMode::Alternating => next.map_or(FrameCount::First, FrameCount::Counted),
        }
    }

    /// The telegram of a request with this frame count.
    pub fn telegram(&self, sa: u8, sap: Sap, count: FrameCount, du: &[u8]) -> Vec<u8> {
        let function = if is_acyclic(sap) { Function::SrdLow } else { Function::SrdHigh };
        octets(self.slave.address, sa, sap, Control::Request { function, count }.to_octet(), du)
    }

    /// Sends a request with this frame count, from the testing master. Returns the whole answer.
    pub fn counted(&mut self, count: FrameCount, sap: Sap, du: &[u8]) -> Result<Received, PortError> {
        let own = self.own_address();
        let telegram = self.telegram(own, sap, count, du);
        let received = self.send(&telegram)?;
        self.keep_count(own, matches!(received, Received::Telegram(_)).then_some(count));
        Ok(received)
    }

    /// Sends a request that the slave must acknowledge.
    pub fn expect_acknowledged(&mut self, sap: Sap, du: &[u8]) -> StepResult {
        let answer = self.request(sap, du)?;
        require(answer.is_acknowledgement(), Expected::Acknowledgement)
    }

    /// Sends a request that the slave must answer with RS.
    pub fn expect_closed(&mut self, sa: u8, sap: Sap, du: &[u8], reason: Closed) -> StepResult {
        let answer = self.request_from(sa, sap, du)?;
        require(answer.is_closed(), Expected::Closed(reason))
    }

    /// Reads the diagnosis from `sa`. Returns its octets, at least six.
    pub fn diagnosis_octets(&mut self, sa: u8) -> StepResult<Vec<u8>> {
        let answer = self.request_from(sa, Sap::SlaveDiag, &[])?;
        let whole = answer.has_data_status() && SlaveDiag::parse(&answer.du).is_ok() && answer.du.len() <= MAX_DU;
        require(whole, Expected::Diagnosis)?;
        Ok(answer.du)
    }

    /// Reads the diagnosis. Returns its fixed part.
    pub fn diagnosis(&mut self) -> StepResult<Diagnosis> {
        let du = self.diagnosis_octets(self.own_address())?;
        let diag = SlaveDiag::parse(&du).map_err(|_| StepError::Unexpected(Expected::Diagnosis))?;
        Ok(Diagnosis { status: diag.status, master_add: diag.master_add, ident: diag.ident })
    }

    /// A Set_Prm that the slave accepts: with Lock_Req, and with the watchdog factors `wd_fact`; zeros switch the watchdog off.
    pub fn prm(&self, wd_fact: [u8; 2]) -> SetPrm<'a> {
        let watched = if wd_fact == [0, 0] { PrmStatus::empty() } else { PrmStatus::WD_ON };
        SetPrm {
            status: PrmStatus::LOCK_REQ | watched,
            wd_fact,
            min_tsdr: 11,
            ident: self.slave.ident,
            group: 0,
            user: &self.slave.user_prm,
        }
    }

    /// Sends Set_Prm. Only the diagnosis shows whether the slave accepts it.
    pub fn set_prm(&mut self, prm: &SetPrm<'_>) -> Result<(), PortError> {
        self.tell(Sap::SetPrm, &set_prm_octets(prm))
    }

    /// A Set_Prm that releases the slave.
    pub fn unlock_prm(&self) -> SetPrm<'a> {
        SetPrm { status: PrmStatus::UNLOCK_REQ, user: &[], wd_fact: [0, 0], min_tsdr: 0, ..self.prm([0, 0]) }
    }

    /// Releases the slave: it waits for parameters afterwards.
    pub fn release(&mut self) -> Result<(), PortError> {
        self.set_prm(&self.unlock_prm())
    }

    /// Releases the slave. Returns whether it answers at all: this, or else FDL status.
    pub fn release_and_listen(&mut self) -> Result<bool, PortError> {
        let answer = self.request(Sap::SetPrm, &set_prm_octets(&self.unlock_prm()));
        match answer {
            Ok(_) => Ok(true),
            Err(StepError::Port(error)) => Err(error),
            Err(StepError::Unexpected(_)) => {
                let fc = Control::Request { function: Function::FdlStatus, count: FrameCount::Uncounted }.to_octet();
                let telegram = octets(self.slave.address, self.own_address(), Sap::Default, fc, &[]);
                Ok(matches!(self.send(&telegram)?, Received::Telegram(_)))
            }
        }
    }

    /// Sends the configuration under test. Only the diagnosis shows whether the slave accepts it.
    pub fn chk_cfg(&mut self) -> Result<(), PortError> {
        self.tell(Sap::ChkCfg, &self.slave.cfg)
    }

    /// Releases the slave and parameterises it: it waits for its configuration afterwards.
    pub fn parameterise(&mut self) -> Result<(), PortError> {
        self.release()?;
        self.set_prm(&self.prm([0, 0]))
    }

    /// Starts data exchange with the watchdog off.
    pub fn start(&mut self) -> StepResult {
        self.start_with(&self.prm([0, 0]))
    }

    /// Starts data exchange with these parameters, and waits until the slave is ready.
    pub fn start_with(&mut self, prm: &SetPrm<'_>) -> StepResult {
        self.release()?;
        self.set_prm(prm)?;
        self.chk_cfg()?;
        self.await_exchange()
    }

    /// Sends Data_Exchange until the slave takes part in it. No slave needs Slave_Diag for that (profibus-wire 3.3).
    pub fn await_exchange(&mut self) -> StepResult {
        for _ in 0..READY_TRIES {
            if self.is_exchanging()? {
                return Ok(());
            }
            self.link.wait(READY_PAUSE)?;
        }
        Err(StepError::Unexpected(Expected::Ready))
    }

    /// Numbers of output and input octets.
    pub fn lengths(&self) -> Lengths {
        cfg::lengths(&self.slave.cfg).unwrap_or_default()
    }

    /// Outputs of zero.
    pub fn outputs(&self) -> Vec<u8> {
        vec![0; usize::from(self.lengths().outputs)]
    }

    /// Sends Data_Exchange with `outputs` from `sa`. Returns whether the slave took part: with inputs of any length, or with SC.
    pub fn is_exchanging_with(&mut self, sa: u8, outputs: &[u8]) -> Result<bool, PortError> {
        match self.request_from(sa, Sap::Default, outputs) {
            Ok(answer) => Ok(answer.has_data_status() || answer.is_acknowledgement()),
            Err(StepError::Unexpected(_)) => Ok(false),
            Err(StepError::Port(error)) => Err(error),
        }
    }

    /// As [`is_exchanging_with`](Self::is_exchanging_with) with the testing master and outputs of zero.
    pub fn is_exchanging(&mut self) -> Result<bool, PortError> {
        self.is_exchanging_with(self.own_address(), &self.outputs())
    }

    /// Requires that the slave takes part in data exchange.
    pub fn expect_exchange(&mut self) -> StepResult {
        let exchanging = self.is_exchanging()?;
        require(exchanging, Expected::Exchange)
    }

    /// Requires that the slave does not take part in data exchange.
    pub fn expect_no_exchange(&mut self) -> StepResult {
        let exchanging = self.is_exchanging()?;
        require(!exchanging, Expected::NoExchange)
    }

    /// Reads the inputs with Data_Exchange.
    pub fn inputs(&mut self) -> StepResult<Vec<u8>> {
        let answer = self.request(Sap::Default, &self.outputs())?;
        let count = usize::from(self.lengths().inputs);
        let whole = answer.has_data_status() || (answer.is_acknowledgement() && count == 0);
        require(whole && answer.du.len() == count, Expected::Octets(count))?;
        Ok(answer.du)
    }

    /// Polls an access point of DP-V1 for a response.
    pub fn poll(&mut self, sap: Sap) -> StepResult<Answer> {
        for _ in 0..READY_TRIES {
            let answer = self.request(sap, &[])?;
            if !answer.is_acknowledgement() {
                return Ok(answer);
            }
            self.link.wait(READY_PAUSE)?;
        }
        Err(StepError::Unexpected(Expected::Pdu(Pdu::Response)))
    }

    /// Sends a request of DP-V1 and polls for the response. Returns the answer with the response.
    pub fn acyclic(&mut self, sap: Sap, request: &acyclic::Request<'_>) -> StepResult<Answer> {
        self.acyclic_octets(sap, &request_octets(request))
    }

    /// As [`acyclic`](Self::acyclic) with any octets.
    pub fn acyclic_octets(&mut self, sap: Sap, du: &[u8]) -> StepResult<Answer> {
        let answer = self.request(sap, du)?;
        // The response may come at once (profibus-wire 4.2).
        if answer.is_acknowledgement() { self.poll(sap) } else { Ok(answer) }
    }
}

/// The fixed part of a diagnosis.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Diagnosis {
    /// Station_Status.
    pub status: StationStatus,
    /// Diag_Master_Add.
    pub master_add: u8,
    /// Ident_Number.
    pub ident: u16,
}

impl Diagnosis {
    /// Requires that all `bits` are 1.
    ///
    /// # Errors
    /// [`StepError::Unexpected`].
    pub fn require_set(&self, bits: StationStatus) -> StepResult {
        require(self.status.contains(bits), Expected::set(bits))
    }

    /// Requires that all `bits` are 0.
    ///
    /// # Errors
    /// [`StepError::Unexpected`].
    pub fn require_clear(&self, bits: StationStatus) -> StepResult {
        require(!self.status.intersects(bits), Expected::clear(bits))
    }

    /// Requires this Diag_Master_Add.
    ///
    /// # Errors
    /// [`StepError::Unexpected`].
    pub fn require_master(&self, master: u8) -> StepResult {
        require(self.master_add == master, Expected::MasterAdd(master))
    }
}

/// Number of polls for a slave that is not ready. With the pause between them they take one second.
const READY_TRIES: usize = 100;
const READY_PAUSE: Duration = Duration::from_millis(10);

const fn is_acyclic(sap: Sap) -> bool {
    matches!(sap, Sap::Ms1 | Sap::Ms2(_) | Sap::ResourceManager)
}

/// The access point of the master for an access point of the slave (profibus-wire 2.1).
#[must_use]
pub const fn ssap_of(sap: Sap) -> Option<u8> {
    match sap {
        Sap::Default => None,
        Sap::Ms1 => Some(MASTER_MS1),
        Sap::Ms2(_) | Sap::ResourceManager => Some(MASTER_MS2),
        _ => Some(MASTER_MS0),
    }
}

/// The octets of a telegram.
pub fn octets(da: u8, sa: u8, sap: Sap, fc: u8, du: &[u8]) -> Vec<u8> {
    frame_octets(DataTelegram { da, sa, dsap: sap.to_octet(), ssap: ssap_of(sap), fc, du })
}

/// The octets of a data telegram.
pub fn frame_octets(frame: DataTelegram<'_>) -> Vec<u8> {
    let mut out = [0; MAX_TELEGRAM];
    let length = Telegram::Data(frame).emit(&mut out).unwrap_or_default();
    out.get(..length).unwrap_or_default().to_vec()
}

/// The octets of a Set_Prm.
pub fn set_prm_octets(prm: &SetPrm<'_>) -> Vec<u8> {
    let mut du = [0; MAX_DU];
    let length = prm.emit(&mut du).unwrap_or_default();
    du.get(..length).unwrap_or_default().to_vec()
}

/// The octets of a PDU.
pub fn request_octets(request: &acyclic::Request<'_>) -> Vec<u8> {
    let mut du = [0; MAX_DU];
    let length = request.emit(&mut du).unwrap_or_default();
    du.get(..length).unwrap_or_default().to_vec()
}

/// Parses an answer.
///
/// # Errors
/// [`StepError::Unexpected`] if it is not a valid answer.
pub fn parse_answer(received: &Received) -> StepResult<Answer> {
    let invalid = || StepError::Unexpected(Expected::Answer);
    let Received::Telegram(octets) = received else { return Err(invalid()) };
    match Telegram::parse(octets) {
        Ok(Telegram::ShortAck) => Ok(Answer { status: Status::NoReply, du: Vec::new() }),
        Ok(Telegram::Data(frame)) => match frame.control() {
            Control::Response { status, .. } => Ok(Answer { status, du: frame.du.to_vec() }),
            Control::Request { .. } => Err(invalid()),
        },
        Ok(Telegram::Token { .. }) | Err(_) => Err(invalid()),
    }
}

/// Parses a response of DP-V1.
///
/// # Errors
/// [`StepError::Unexpected`] with `expected` if it is none.
pub fn response(du: &[u8], expected: Pdu) -> StepResult<Response<'_>> {
    Response::parse(du).map_err(|_| StepError::Unexpected(Expected::Pdu(expected)))
}
