//! Requests of a check to the slave, and the answers that the check expects.
//!
//! A [`Dialogue`] logs every telegram, so that a violated rule can be shown with its octets. It keeps the frame count bits like
//! an initiator (profibus-wire 1.10).

use super::probe::Received;
use profivac_host::port::PortError;
use profivac_wire::acyclic::{self, Response};
use profivac_wire::cfg::{self, Lengths};
use profivac_wire::control::{Control, FrameCount, Function, Status};
use profivac_wire::diag::SlaveDiag;
use profivac_wire::prm::{PrmStatus, SetPrm};
use profivac_wire::sap::{MASTER_MS0, MASTER_MS2};
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

/// A message cycle in the log.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct LoggedCycle {
    /// The octets that the probe sent.
    pub sent: Vec<u8>,
    /// The answer.
    pub received: Received,
}

/// Reason why a check ended early.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum CheckError {
    /// The slave violates the rule.
    #[error("expected {expected}")]
    Violated {
        /// The expected answer.
        expected: String,
    },
    /// The rule does not apply to this slave.
    #[error("not applicable: {reason}")]
    NotApplicable {
        /// The reason, in one sentence.
        reason: &'static str,
    },
    /// The port is lost.
    #[error(transparent)]
    Port(#[from] PortError),
}

/// Result of a check or of a part of one.
pub type CheckOutcome<T = ()> = Result<T, CheckError>;

/// Ends the check: the slave did not give the expected answer.
pub fn violated<T>(expected: impl Into<String>) -> CheckOutcome<T> {
    Err(CheckError::Violated { expected: expected.into() })
}

/// Ends the check unless the condition `holds`.
///
/// # Errors
/// [`CheckError::Violated`] with the expected answer.
pub fn require(holds: bool, expected: &str) -> CheckOutcome {
    if holds { Ok(()) } else { violated(expected) }
}

/// A valid answer of the slave: the addresses and the access points are those of the request, swapped.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Answer {
    /// SC.
    ShortAck,
    /// A telegram with a status.
    Data {
        /// Status of the answer.
        status: Status,
        /// The data unit.
        du: Vec<u8>,
    },
}

/// Sends requests to the slave, checks its answers and logs both.
pub struct Dialogue<'a> {
    /// The slave under test.
    pub slave: &'a SlaveUnderTest,
    link: &'a mut dyn Link,
    /// The frame count bit of the next request of each source; `None` before the first request.
    counts: [Option<bool>; 128],
    log: Vec<LoggedCycle>,
}

impl<'a> Dialogue<'a> {
    /// A dialogue with an empty log.
    pub fn new(link: &'a mut dyn Link, slave: &'a SlaveUnderTest) -> Self {
        Self { slave, link, counts: [None; 128], log: Vec::new() }
    }

    /// The address of the testing master.
    pub fn own_address(&self) -> u8 {
        self.link.address()
    }

    /// The address of a second master, which the testing master uses too.
    pub fn other_master_address(&self) -> u8 {
        if self.own_address() == 3 { 4 } else { 3 }
    }

    /// Returns the log since the last call.
    pub fn take_log(&mut self) -> Vec<LoggedCycle> {
        std::mem::take(&mut self.log)
    }

    /// Sends nothing for this time.
    pub fn wait(&mut self, time: Duration) -> CheckOutcome {
        Ok(self.link.wait(time)?)
    }

    /// Sends octets unchanged. Returns the answer.
    pub fn send(&mut self, octets: &[u8]) -> CheckOutcome<Received> {
        let received = self.link.send_and_receive(octets)?;
        self.log.push(LoggedCycle { sent: octets.to_vec(), received: received.clone() });
        Ok(received)
    }

    /// Sends octets that no slave may answer.
    pub fn expect_silence(&mut self, octets: &[u8], reason: &str) -> CheckOutcome {
        let received = self.send(octets)?;
        require(received == Received::Nothing, &format!("silence: {reason}"))
    }

    /// Sends a counted SRD from `sa`. Repeats it once if no valid answer comes. Returns the answer.
    pub fn request_from(&mut self, sa: u8, sap: Sap, du: &[u8]) -> CheckOutcome<Answer> {
        let telegram = self.counted(sa, sap, du);
        let mut received = self.send(&telegram)?;
        if received == Received::Nothing || received == Received::Damaged {
            received = self.send(&telegram)?;
        }
        let answer = self.answer(sa, sap, &received)?;
        let next = self.counts.get_mut(usize::from(sa));
        next.into_iter().for_each(|count| *count = Some(!count.unwrap_or(true)));
        Ok(answer)
    }

    /// Sends a counted SRD from the testing master. Returns the answer.
    pub fn request(&mut self, sap: Sap, du: &[u8]) -> CheckOutcome<Answer> {
        self.request_from(self.own_address(), sap, du)
    }

    /// The telegram that [`request_from`](Self::request_from) sends next.
    pub fn counted(&self, sa: u8, sap: Sap, du: &[u8]) -> Vec<u8> {
        let count = self.counts.get(usize::from(sa)).copied().flatten();
        let count = count.map_or(FrameCount::First, FrameCount::Counted);
        let function = if is_ms2(sap) { Function::SrdLow } else { Function::SrdHigh };
        let fc = Control::Request { function, count }.to_octet();
        octets(self.slave.address, sa, sap, fc, du)
    }

    /// Parses `received` as the answer to a request of `sa` to `sap`.
    fn answer(&self, sa: u8, sap: Sap, received: &Received) -> CheckOutcome<Answer> {
        let octets = match received {
            Received::Telegram(octets) => octets,
            Received::Nothing => return violated("an answer within the slot time"),
            Received::Damaged => return violated("a whole telegram"),
        };
        match Telegram::parse(octets) {
            Ok(Telegram::ShortAck) => Ok(Answer::ShortAck),
            Ok(Telegram::Data(frame)) => {
                let Control::Response { status, .. } = frame.control() else { return violated("a response") };
                require((frame.sa, frame.da) == (self.slave.address, sa), "the addresses of the request, swapped")?;
                // An answer without data may omit the access points (profibus-wire 1.15).
                let bare = (frame.dsap, frame.ssap) == (None, None) && frame.du.is_empty();
                let swapped = (frame.dsap, frame.ssap) == (ssap_of(sap), sap.to_octet());
                require(bare || swapped, "the access points of the request, swapped")?;
                Ok(Answer::Data { status, du: frame.du.to_vec() })
            }
            Ok(Telegram::Token { .. }) | Err(_) => violated("an answer, not a token"),
        }
    }

    /// Sends a request that the slave must acknowledge with SC.
    pub fn expect_acknowledged(&mut self, sap: Sap, du: &[u8]) -> CheckOutcome {
        let answer = self.request(sap, du)?;
        require(answer == Answer::ShortAck, "SC")
    }

    /// Sends a request that the slave must answer with this status and no data.
    pub fn expect_status_from(&mut self, sa: u8, sap: Sap, du: &[u8], status: Status, expected: &str) -> CheckOutcome {
        let answer = self.request_from(sa, sap, du)?;
        require(answer == Answer::Data { status, du: Vec::new() }, expected)
    }

    /// Sends a request that the slave must answer with RS: the access point is closed.
    pub fn expect_closed(&mut self, sap: Sap, du: &[u8], expected: &str) -> CheckOutcome {
        self.expect_status_from(self.own_address(), sap, du, Status::ServiceNotActivated, expected)
    }

    /// Sends a request that the slave must answer with data of low priority. Returns the data.
    pub fn data_from(&mut self, sa: u8, sap: Sap) -> CheckOutcome<Vec<u8>> {
        match self.request_from(sa, sap, &[])? {
            Answer::Data { status: Status::DataLow, du } => Ok(du),
            _ => violated("DL with data"),
        }
    }

    /// Reads the diagnosis. Returns its fixed part.
    pub fn diagnosis(&mut self) -> CheckOutcome<[u8; 6]> {
        self.diagnosis_from(self.own_address())
    }

    /// Reads the diagnosis from `sa`. Returns its fixed part.
    pub fn diagnosis_from(&mut self, sa: u8) -> CheckOutcome<[u8; 6]> {
        let du = self.data_from(sa, Sap::SlaveDiag)?;
        require(SlaveDiag::parse(&du).is_ok() && du.len() <= MAX_DU, "a diagnosis of 6 to 244 octets")?;
        let fixed = du.first_chunk::<6>().copied();
        fixed.map_or_else(|| violated("a diagnosis of 6 to 244 octets"), Ok)
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

    /// Sends Set_Prm. The slave must acknowledge it, even if it refuses the parameters.
    pub fn set_prm(&mut self, prm: &SetPrm<'_>) -> CheckOutcome {
        self.expect_acknowledged(Sap::SetPrm, &set_prm_octets(prm))
    }

    /// Releases the slave: it waits for parameters afterwards.
    pub fn release(&mut self) -> CheckOutcome {
        let unlock =
            SetPrm { status: PrmStatus::UNLOCK_REQ, user: &[], wd_fact: [0, 0], min_tsdr: 0, ..self.prm([0, 0]) };
        self.set_prm(&unlock)
    }

    /// Starts data exchange, and waits until the slave is ready.
    pub fn start(&mut self, wd_fact: [u8; 2]) -> CheckOutcome {
        self.release()?;
        self.set_prm(&self.prm(wd_fact))?;
        self.expect_acknowledged(Sap::ChkCfg, &self.slave.cfg)?;
        for _ in 0..READY_TRIES {
            let [first, second, ..] = self.diagnosis()?;
            if first & NOT_IN_EXCHANGE == 0 && second & PRM_REQ == 0 {
                return Ok(());
            }
            self.wait(READY_PAUSE)?;
        }
        violated("data exchange after Set_Prm and Chk_Cfg")
    }

    /// Numbers of output and input octets.
    pub fn lengths(&self) -> Lengths {
        cfg::lengths(&self.slave.cfg).unwrap_or_default()
    }

    /// Outputs of zero.
    pub fn outputs(&self) -> Vec<u8> {
        vec![0; usize::from(self.lengths().outputs)]
    }

    /// Sends Data_Exchange, which the slave must answer with inputs of the configured length. Returns the inputs.
    pub fn exchange(&mut self) -> CheckOutcome<Vec<u8>> {
        let inputs = usize::from(self.lengths().inputs);
        match self.request(Sap::Default, &self.outputs())? {
            Answer::ShortAck if inputs == 0 => Ok(Vec::new()),
            Answer::Data { status: Status::DataLow | Status::DataHigh, du } if du.len() == inputs => Ok(du),
            _ => violated(format!("DL or DH with {inputs} octets")),
        }
    }

    /// Sends a request over MS2 and polls for the response. Returns the response.
    pub fn ms2(&mut self, sap: u8, request: &acyclic::Request<'_>) -> CheckOutcome<Vec<u8>> {
        let mut du = [0; MAX_DU];
        let length = request.emit(&mut du).unwrap_or_default();
        let mut answer = self.request(Sap::from_octet(Some(sap)), du.get(..length).unwrap_or_default())?;
        for _ in 0..READY_TRIES {
            match answer {
                Answer::Data { status: Status::DataLow, du } => return Ok(du),
                Answer::ShortAck => {}
                Answer::Data { .. } => return violated("SC, or DL with the response"),
            }
            answer = self.request(Sap::from_octet(Some(sap)), &[])?;
            if answer == Answer::ShortAck {
                self.wait(READY_PAUSE)?;
            }
        }
        violated("a response to the request")
    }
}

/// Number of polls for a slave that is not ready. With the pause between them they take one second.
const READY_TRIES: usize = 100;
const READY_PAUSE: Duration = Duration::from_millis(10);

/// Station_Not_Ready, Cfg_Fault and Prm_Fault.
const NOT_IN_EXCHANGE: u8 = 0x46;

/// Prm_Req, in the second octet.
const PRM_REQ: u8 = 0x01;

const fn is_ms2(sap: Sap) -> bool {
    matches!(sap, Sap::Ms2(_) | Sap::ResourceManager)
}

/// The access point of the master for an access point of the slave (profibus-wire 2.1).
fn ssap_of(sap: Sap) -> Option<u8> {
    match sap {
        Sap::Default => None,
        sap if is_ms2(sap) => Some(MASTER_MS2),
        _ => Some(MASTER_MS0),
    }
}

/// The octets of a telegram.
pub fn octets(da: u8, sa: u8, sap: Sap, fc: u8, du: &[u8]) -> Vec<u8> {
    let frame = DataTelegram { da, sa, dsap: sap.to_octet(), ssap: ssap_of(sap), fc, du };
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

/// Parses a response over MS2.
///
/// # Errors
/// [`CheckError::Violated`] if it is not a PDU of the DP-V1 services.
pub fn response(du: &[u8]) -> CheckOutcome<Response<'_>> {
    Response::parse(du).or_else(|_| violated("a PDU of the DP-V1 services"))
}
