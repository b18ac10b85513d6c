//! What a check says to the slave, and what it may expect.
//!
//! Everything that is said and heard is written down, so that a broken rule can be shown with the octets that broke it.
//! The frame count bits are kept as an initiator keeps them, profibus-wire 1.10.

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

/// The way to the slave.
pub trait Link {
    /// The address of the master that asks.
    fn address(&self) -> u8;

    /// Says `octets` and listens for a slot time.
    ///
    /// # Errors
    /// [`PortError`] when the port is gone.
    fn send_and_receive(&mut self, octets: &[u8]) -> Result<Received, PortError>;

    /// Says nothing for so long.
    ///
    /// # Errors
    /// [`PortError`] when the port is gone.
    fn wait(&mut self, time: Duration) -> Result<(), PortError>;
}

/// The slave that is looked at, and how it is brought into data exchange.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct SlaveUnderTest {
    /// Its address.
    pub address: u8,
    /// Ident_Number.
    pub ident: u16,
    /// Its configuration.
    pub cfg: Vec<u8>,
    /// User_Prm_Data that it takes.
    pub user_prm: Vec<u8>,
}

/// One thing said, and what came back.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct LoggedCycle {
    /// What was said.
    pub sent: Vec<u8>,
    /// What came back.
    pub received: Received,
}

/// Why a check did not come to its end.
#[derive(Debug)]
pub enum CheckError {
    /// This was expected and did not come.
    Violated(String),
    /// It cannot be said of this slave.
    NotApplicable(&'static str),
    /// The port is gone.
    Port(PortError),
}

impl From<PortError> for CheckError {
    fn from(error: PortError) -> Self {
        Self::Port(error)
    }
}

/// What a check or a part of one comes to.
pub type CheckOutcome<T = ()> = Result<T, CheckError>;

/// Says that `expected` did not come.
pub fn violated<T>(expected: impl Into<String>) -> CheckOutcome<T> {
    Err(CheckError::Violated(expected.into()))
}

/// Goes on only if it `holds`.
pub fn require(holds: bool, expected: &str) -> CheckOutcome {
    if holds { Ok(()) } else { violated(expected) }
}

/// An answer that came from the slave, to us, with the access points swapped.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Answer {
    /// SC.
    ShortAck,
    /// A frame.
    Frame {
        /// How it answers.
        status: Status,
        /// The data unit.
        du: Vec<u8>,
    },
}

/// A conversation with the slave.
pub struct Dialogue<'a> {
    /// Who is spoken to.
    pub slave: &'a SlaveUnderTest,
    link: &'a mut dyn Link,
    /// The frame count bit of the next request of each source, nothing before the first.
    counts: [Option<bool>; 128],
    log: Vec<LoggedCycle>,
}

impl<'a> Dialogue<'a> {
    /// Nothing was said yet.
    pub fn new(wire: &'a mut dyn Link, subject: &'a SlaveUnderTest) -> Self {
        Self { slave: subject, link: wire, counts: [None; 128], log: Vec::new() }
    }

    /// Our address.
    pub fn own_address(&self) -> u8 {
        self.link.address()
    }

    /// Another master's address, which the slave does not know from ours by anything else.
    pub fn other_master_address(&self) -> u8 {
        if self.own_address() == 3 { 4 } else { 3 }
    }

    /// What was said since this was asked last.
    pub fn take_log(&mut self) -> Vec<LoggedCycle> {
        std::mem::take(&mut self.log)
    }

    /// Says nothing for so long.
    pub fn wait(&mut self, time: Duration) -> CheckOutcome {
        Ok(self.link.wait(time)?)
    }

    /// Says octets as they are.
    pub fn send(&mut self, octets: &[u8]) -> CheckOutcome<Received> {
        let came = self.link.send_and_receive(octets)?;
        self.log.push(LoggedCycle { sent: octets.to_vec(), received: came.clone() });
        Ok(came)
    }

    /// Says octets that nobody may answer.
    pub fn expect_silence(&mut self, octets: &[u8], why: &str) -> CheckOutcome {
        let came = self.send(octets)?;
        require(came == Received::Nothing, &format!("silence: {why}"))
    }

    /// A counted SRD from `sa`, and the answer. Repeated once if nothing comes, as every master does.
    pub fn request_from(&mut self, sa: u8, sap: Sap, du: &[u8]) -> CheckOutcome<Answer> {
        let telegram = self.counted(sa, sap, du);
        let mut came = self.send(&telegram)?;
        if came == Received::Nothing || came == Received::Damaged {
            came = self.send(&telegram)?;
        }
        let answer = self.answer(sa, sap, &came)?;
        let next = self.counts.get_mut(usize::from(sa));
        next.into_iter().for_each(|count| *count = Some(!count.unwrap_or(true)));
        Ok(answer)
    }

    /// A counted SRD from us, and the answer.
    pub fn request(&mut self, sap: Sap, du: &[u8]) -> CheckOutcome<Answer> {
        self.request_from(self.own_address(), sap, du)
    }

    /// The telegram that [`request_from`](Self::request_from) says next.
    pub fn counted(&self, sa: u8, sap: Sap, du: &[u8]) -> Vec<u8> {
        let count = self.counts.get(usize::from(sa)).copied().flatten();
        let count = count.map_or(FrameCount::First, FrameCount::Counted);
        let function = if is_ms2(sap) { Function::SrdLow } else { Function::SrdHigh };
        let fc = Control::Request { function, count }.to_octet();
        octets(self.slave.address, sa, sap, fc, du)
    }

    /// The answer in `came`, if it is one to a request of `sa` to `sap`.
    fn answer(&self, sa: u8, sap: Sap, came: &Received) -> CheckOutcome<Answer> {
        let octets = match came {
            Received::Telegram(octets) => octets,
            Received::Nothing => return violated("an answer within the slot time"),
            Received::Damaged => return violated("a whole telegram"),
        };
        match Telegram::parse(octets) {
            Ok(Telegram::ShortAck) => Ok(Answer::ShortAck),
            Ok(Telegram::Data(frame)) => {
                let Control::Response { status, .. } = frame.control() else { return violated("a response") };
                require((frame.sa, frame.da) == (self.slave.address, sa), "the addresses of the request, swapped")?;
                // Answers without data may leave the access points out: profibus-wire 1.15.
                let bare = (frame.dsap, frame.ssap) == (None, None) && frame.du.is_empty();
                let swapped = (frame.dsap, frame.ssap) == (ssap_of(sap), sap.to_octet());
                require(bare || swapped, "the access points of the request, swapped")?;
                Ok(Answer::Frame { status, du: frame.du.to_vec() })
            }
            Ok(Telegram::Token { .. }) | Err(_) => violated("an answer, not a token"),
        }
    }

    /// A request that must be acknowledged by SC.
    pub fn expect_acknowledged(&mut self, sap: Sap, du: &[u8]) -> CheckOutcome {
        let answer = self.request(sap, du)?;
        require(answer == Answer::ShortAck, "SC")
    }

    /// A request that must be answered without data, like RS.
    pub fn expect_status_from(&mut self, sa: u8, sap: Sap, du: &[u8], status: Status, why: &str) -> CheckOutcome {
        let answer = self.request_from(sa, sap, du)?;
        require(answer == Answer::Frame { status, du: Vec::new() }, why)
    }

    /// A request that must be answered with RS: the access point is closed.
    pub fn expect_closed(&mut self, sap: Sap, du: &[u8], why: &str) -> CheckOutcome {
        self.expect_status_from(self.own_address(), sap, du, Status::ServiceNotActivated, why)
    }

    /// A request that must be answered with data of low priority.
    pub fn data_from(&mut self, sa: u8, sap: Sap) -> CheckOutcome<Vec<u8>> {
        match self.request_from(sa, sap, &[])? {
            Answer::Frame { status: Status::DataLow, du } => Ok(du),
            _ => violated("DL with data"),
        }
    }

    /// The fixed part of the diagnosis.
    pub fn diagnosis(&mut self) -> CheckOutcome<[u8; 6]> {
        self.diagnosis_from(self.own_address())
    }

    /// The fixed part of the diagnosis, as `sa` reads it.
    pub fn diagnosis_from(&mut self, sa: u8) -> CheckOutcome<[u8; 6]> {
        let du = self.data_from(sa, Sap::SlaveDiag)?;
        require(SlaveDiag::parse(&du).is_ok() && du.len() <= MAX_DU, "a diagnosis of 6 to 244 octets")?;
        let fixed = du.first_chunk::<6>().copied();
        fixed.map_or_else(|| violated("a diagnosis of 6 to 244 octets"), Ok)
    }

    /// The data unit of a Set_Prm that the slave takes: locked, watchdog as `wd_fact` says, off for zeros.
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

    /// Set_Prm, which is acknowledged whatever it says.
    pub fn set_prm(&mut self, prm: &SetPrm<'_>) -> CheckOutcome {
        self.expect_acknowledged(Sap::SetPrm, &emitted(prm))
    }

    /// Whatever the slave was doing for us, it waits for parameters now.
    pub fn release(&mut self) -> CheckOutcome {
        let unlock =
            SetPrm { status: PrmStatus::UNLOCK_REQ, user: &[], wd_fact: [0, 0], min_tsdr: 0, ..self.prm([0, 0]) };
        self.set_prm(&unlock)
    }

    /// Brings the slave into data exchange with us, and waits until it is ready.
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

    /// How many octets go each way.
    pub fn lengths(&self) -> Lengths {
        cfg::lengths(&self.slave.cfg).unwrap_or_default()
    }

    /// Outputs that do nothing.
    pub fn outputs(&self) -> Vec<u8> {
        vec![0; usize::from(self.lengths().outputs)]
    }

    /// One Data_Exchange that is answered with inputs of the right length.
    pub fn exchange(&mut self) -> CheckOutcome<Vec<u8>> {
        let inputs = usize::from(self.lengths().inputs);
        match self.request(Sap::Default, &self.outputs())? {
            Answer::ShortAck if inputs == 0 => Ok(Vec::new()),
            Answer::Frame { status: Status::DataLow | Status::DataHigh, du } if du.len() == inputs => Ok(du),
            _ => violated(format!("DL or DH with {inputs} octets")),
        }
    }

    /// A request over MS2 and its response, which is polled for.
    pub fn ms2(&mut self, sap: u8, request: &acyclic::Request<'_>) -> CheckOutcome<Vec<u8>> {
        let mut du = [0; MAX_DU];
        let length = request.emit(&mut du).unwrap_or_default();
        let mut answer = self.request(Sap::from_octet(Some(sap)), du.get(..length).unwrap_or_default())?;
        for _ in 0..READY_TRIES {
            match answer {
                Answer::Frame { status: Status::DataLow, du } => return Ok(du),
                Answer::ShortAck => {}
                Answer::Frame { .. } => return violated("SC, or DL with the response"),
            }
            answer = self.request(Sap::from_octet(Some(sap)), &[])?;
            if answer == Answer::ShortAck {
                self.wait(READY_PAUSE)?;
            }
        }
        violated("a response to the request")
    }
}

/// How often a slave is asked whether it is ready, and how long it is left alone between: a second in all.
const READY_TRIES: usize = 100;
const READY_PAUSE: Duration = Duration::from_millis(10);

/// Station_Not_Ready, Cfg_Fault and Prm_Fault.
const NOT_IN_EXCHANGE: u8 = 0x46;

/// Prm_Req, in the second octet.
const PRM_REQ: u8 = 0x01;

const fn is_ms2(sap: Sap) -> bool {
    matches!(sap, Sap::Ms2(_) | Sap::ResourceManager)
}

/// The access point of a master that belongs to one of a slave, profibus-wire 2.1.
fn ssap_of(sap: Sap) -> Option<u8> {
    match sap {
        Sap::Default => None,
        sap if is_ms2(sap) => Some(MASTER_MS2),
        _ => Some(MASTER_MS0),
    }
}

/// A telegram in octets.
pub fn octets(da: u8, sa: u8, sap: Sap, fc: u8, du: &[u8]) -> Vec<u8> {
    let frame = DataTelegram { da, sa, dsap: sap.to_octet(), ssap: ssap_of(sap), fc, du };
    let mut out = [0; MAX_TELEGRAM];
    let length = Telegram::Data(frame).emit(&mut out).unwrap_or_default();
    out.get(..length).unwrap_or_default().to_vec()
}

/// A Set_Prm in octets.
pub fn emitted(prm: &SetPrm<'_>) -> Vec<u8> {
    let mut du = [0; MAX_DU];
    let length = prm.emit(&mut du).unwrap_or_default();
    du.get(..length).unwrap_or_default().to_vec()
}

/// What a response over MS2 says.
pub fn response(du: &[u8]) -> CheckOutcome<Response<'_>> {
    Response::parse(du).or_else(|_| violated("a PDU of the DP-V1 services"))
}
