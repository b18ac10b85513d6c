//! What a check says to the slave, and what it may expect.
//!
//! Everything that is said and heard is written down, so that a broken rule can be shown with the octets that broke it.
//! The frame count bits are kept as an initiator keeps them, profibus-wire 1.10.

use super::probe::Heard;
use profivac_host::port::PortError;
use profivac_wire::acyclic::{self, Response};
use profivac_wire::cfg::{self, Lengths};
use profivac_wire::control::{Control, FrameCount, Function, Status};
use profivac_wire::diag::SlaveDiag;
use profivac_wire::prm::{PrmStatus, SetPrm};
use profivac_wire::sap::{MASTER_MS0, MASTER_MS2};
use profivac_wire::{Frame, MAX_DU, MAX_TELEGRAM, Sap, Telegram};
use std::time::Duration;

/// The way to the slave.
pub trait Wire {
    /// The address of the master that asks.
    fn address(&self) -> u8;

    /// Says `octets` and listens for a slot time.
    ///
    /// # Errors
    /// [`PortError`] when the port is gone.
    fn ask(&mut self, octets: &[u8]) -> Result<Heard, PortError>;

    /// Says nothing for so long.
    ///
    /// # Errors
    /// [`PortError`] when the port is gone.
    fn wait(&mut self, time: Duration) -> Result<(), PortError>;
}

/// The slave that is looked at, and how it is brought into data exchange.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Subject {
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
pub struct Exchange {
    /// What was said.
    pub asked: Vec<u8>,
    /// What came back.
    pub came: Heard,
}

/// Why a check did not come to its end.
#[derive(Debug)]
pub enum Wrong {
    /// This was expected and did not come.
    Broken(String),
    /// It cannot be said of this slave.
    NotApplicable(&'static str),
    /// The port is gone.
    Port(PortError),
}

impl From<PortError> for Wrong {
    fn from(error: PortError) -> Self {
        Self::Port(error)
    }
}

/// What a check or a part of one comes to.
pub type Checked<T = ()> = Result<T, Wrong>;

/// Says that `expected` did not come.
pub fn broken<T>(expected: impl Into<String>) -> Checked<T> {
    Err(Wrong::Broken(expected.into()))
}

/// Goes on only if it `holds`.
pub fn must(holds: bool, expected: &str) -> Checked {
    if holds { Ok(()) } else { broken(expected) }
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
pub struct Talk<'a> {
    /// Who is spoken to.
    pub subject: &'a Subject,
    wire: &'a mut dyn Wire,
    /// The frame count bit of the next request of each source, nothing before the first.
    counts: [Option<bool>; 128],
    log: Vec<Exchange>,
}

impl<'a> Talk<'a> {
    /// Nothing was said yet.
    pub fn new(wire: &'a mut dyn Wire, subject: &'a Subject) -> Self {
        Self { subject, wire, counts: [None; 128], log: Vec::new() }
    }

    /// Our address.
    pub fn us(&self) -> u8 {
        self.wire.address()
    }

    /// Another master's address, which the slave does not know from ours by anything else.
    pub fn other(&self) -> u8 {
        if self.us() == 3 { 4 } else { 3 }
    }

    /// What was said since this was asked last.
    pub fn take_log(&mut self) -> Vec<Exchange> {
        std::mem::take(&mut self.log)
    }

    /// Says nothing for so long.
    pub fn wait(&mut self, time: Duration) -> Checked {
        Ok(self.wire.wait(time)?)
    }

    /// Says octets as they are.
    pub fn say(&mut self, octets: &[u8]) -> Checked<Heard> {
        let came = self.wire.ask(octets)?;
        self.log.push(Exchange { asked: octets.to_vec(), came: came.clone() });
        Ok(came)
    }

    /// Says octets that nobody may answer.
    pub fn silence(&mut self, octets: &[u8], why: &str) -> Checked {
        let came = self.say(octets)?;
        must(came == Heard::Nothing, &format!("silence: {why}"))
    }

    /// A counted SRD from `sa`, and the answer. Repeated once if nothing comes, as every master does.
    pub fn request_from(&mut self, sa: u8, sap: Sap, du: &[u8]) -> Checked<Answer> {
        let telegram = self.counted(sa, sap, du);
        let mut came = self.say(&telegram)?;
        if came == Heard::Nothing || came == Heard::Damaged {
            came = self.say(&telegram)?;
        }
        let answer = self.answer(sa, sap, &came)?;
        let next = self.counts.get_mut(usize::from(sa));
        next.into_iter().for_each(|count| *count = Some(!count.unwrap_or(true)));
        Ok(answer)
    }

    /// A counted SRD from us, and the answer.
    pub fn request(&mut self, sap: Sap, du: &[u8]) -> Checked<Answer> {
        self.request_from(self.us(), sap, du)
    }

    /// The telegram that [`request_from`](Self::request_from) says next.
    pub fn counted(&self, sa: u8, sap: Sap, du: &[u8]) -> Vec<u8> {
        let count = self.counts.get(usize::from(sa)).copied().flatten();
        let count = count.map_or(FrameCount::First, FrameCount::Counted);
        let function = if is_ms2(sap) { Function::SrdLow } else { Function::SrdHigh };
        let fc = Control::Request { function, count }.to_octet();
        octets(self.subject.address, sa, sap, fc, du)
    }

    /// The answer in `came`, if it is one to a request of `sa` to `sap`.
    fn answer(&self, sa: u8, sap: Sap, came: &Heard) -> Checked<Answer> {
        let octets = match came {
            Heard::Telegram(octets) => octets,
            Heard::Nothing => return broken("an answer within the slot time"),
            Heard::Damaged => return broken("a whole telegram"),
        };
        match Telegram::parse(octets) {
            Ok(Telegram::ShortAck) => Ok(Answer::ShortAck),
            Ok(Telegram::Frame(frame)) => {
                let Control::Response { status, .. } = frame.control() else { return broken("a response") };
                must((frame.sa, frame.da) == (self.subject.address, sa), "the addresses of the request, swapped")?;
                // Answers without data may leave the access points out: profibus-wire 1.15.
                let bare = (frame.dsap, frame.ssap) == (None, None) && frame.du.is_empty();
                let swapped = (frame.dsap, frame.ssap) == (ssap_of(sap), sap.to_octet());
                must(bare || swapped, "the access points of the request, swapped")?;
                Ok(Answer::Frame { status, du: frame.du.to_vec() })
            }
            Ok(Telegram::Token { .. }) | Err(_) => broken("an answer, not a token"),
        }
    }

    /// A request that must be acknowledged by SC.
    pub fn acknowledged(&mut self, sap: Sap, du: &[u8]) -> Checked {
        let answer = self.request(sap, du)?;
        must(answer == Answer::ShortAck, "SC")
    }

    /// A request that must be answered without data, like RS.
    pub fn refused_from(&mut self, sa: u8, sap: Sap, du: &[u8], status: Status, why: &str) -> Checked {
        let answer = self.request_from(sa, sap, du)?;
        must(answer == Answer::Frame { status, du: Vec::new() }, why)
    }

    /// A request that must be answered with RS: the access point is closed.
    pub fn closed(&mut self, sap: Sap, du: &[u8], why: &str) -> Checked {
        self.refused_from(self.us(), sap, du, Status::ServiceNotActivated, why)
    }

    /// A request that must be answered with data of low priority.
    pub fn data_from(&mut self, sa: u8, sap: Sap) -> Checked<Vec<u8>> {
        match self.request_from(sa, sap, &[])? {
            Answer::Frame { status: Status::DataLow, du } => Ok(du),
            _ => broken("DL with data"),
        }
    }

    /// The fixed part of the diagnosis.
    pub fn diagnosis(&mut self) -> Checked<[u8; 6]> {
        self.diagnosis_from(self.us())
    }

    /// The fixed part of the diagnosis, as `sa` reads it.
    pub fn diagnosis_from(&mut self, sa: u8) -> Checked<[u8; 6]> {
        let du = self.data_from(sa, Sap::SlaveDiag)?;
        must(SlaveDiag::parse(&du).is_ok() && du.len() <= MAX_DU, "a diagnosis of 6 to 244 octets")?;
        let fixed = du.first_chunk::<6>().copied();
        fixed.map_or_else(|| broken("a diagnosis of 6 to 244 octets"), Ok)
    }

    /// The data unit of a Set_Prm that the slave takes: locked, watchdog as `wd_fact` says, off for zeros.
    pub fn prm(&self, wd_fact: [u8; 2]) -> SetPrm<'a> {
        let watched = if wd_fact == [0, 0] { PrmStatus::empty() } else { PrmStatus::WD_ON };
        SetPrm {
            status: PrmStatus::LOCK_REQ | watched,
            wd_fact,
            min_tsdr: 11,
            ident: self.subject.ident,
            group: 0,
            user: &self.subject.user_prm,
        }
    }

    /// Set_Prm, which is acknowledged whatever it says.
    pub fn set_prm(&mut self, prm: &SetPrm<'_>) -> Checked {
        self.acknowledged(Sap::SetPrm, &emitted(prm))
    }

    /// Whatever the slave was doing for us, it waits for parameters now.
    pub fn release(&mut self) -> Checked {
        let unlock =
            SetPrm { status: PrmStatus::UNLOCK_REQ, user: &[], wd_fact: [0, 0], min_tsdr: 0, ..self.prm([0, 0]) };
        self.set_prm(&unlock)
    }

    /// Brings the slave into data exchange with us, and waits until it is ready.
    pub fn start(&mut self, wd_fact: [u8; 2]) -> Checked {
        self.release()?;
        self.set_prm(&self.prm(wd_fact))?;
        self.acknowledged(Sap::ChkCfg, &self.subject.cfg)?;
        for _ in 0..READY_TRIES {
            let [first, second, ..] = self.diagnosis()?;
            if first & NOT_IN_EXCHANGE == 0 && second & PRM_REQ == 0 {
                return Ok(());
            }
            self.wait(READY_PAUSE)?;
        }
        broken("data exchange after Set_Prm and Chk_Cfg")
    }

    /// How many octets go each way.
    pub fn lengths(&self) -> Lengths {
        cfg::lengths(&self.subject.cfg).unwrap_or_default()
    }

    /// Outputs that do nothing.
    pub fn outputs(&self) -> Vec<u8> {
        vec![0; usize::from(self.lengths().outputs)]
    }

    /// One Data_Exchange that is answered with inputs of the right length.
    pub fn exchange(&mut self) -> Checked<Vec<u8>> {
        let inputs = usize::from(self.lengths().inputs);
        match self.request(Sap::Default, &self.outputs())? {
            Answer::ShortAck if inputs == 0 => Ok(Vec::new()),
            Answer::Frame { status: Status::DataLow | Status::DataHigh, du } if du.len() == inputs => Ok(du),
            _ => broken(format!("DL or DH with {inputs} octets")),
        }
    }

    /// A request over MS2 and its response, which is polled for.
    pub fn ms2(&mut self, sap: u8, request: &acyclic::Request<'_>) -> Checked<Vec<u8>> {
        let mut du = [0; MAX_DU];
        let length = request.emit(&mut du).unwrap_or_default();
        let mut answer = self.request(Sap::from_octet(Some(sap)), du.get(..length).unwrap_or_default())?;
        for _ in 0..READY_TRIES {
            match answer {
                Answer::Frame { status: Status::DataLow, du } => return Ok(du),
                Answer::ShortAck => {}
                Answer::Frame { .. } => return broken("SC, or DL with the response"),
            }
            answer = self.request(Sap::from_octet(Some(sap)), &[])?;
            if answer == Answer::ShortAck {
                self.wait(READY_PAUSE)?;
            }
        }
        broken("a response to the request")
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
    let frame = Frame { da, sa, dsap: sap.to_octet(), ssap: ssap_of(sap), fc, du };
    let mut out = [0; MAX_TELEGRAM];
    let length = Telegram::Frame(frame).emit(&mut out).unwrap_or_default();
    out.get(..length).unwrap_or_default().to_vec()
}

/// A Set_Prm in octets.
pub fn emitted(prm: &SetPrm<'_>) -> Vec<u8> {
    let mut du = [0; MAX_DU];
    let length = prm.emit(&mut du).unwrap_or_default();
    du.get(..length).unwrap_or_default().to_vec()
}

/// What a response over MS2 says.
pub fn response(du: &[u8]) -> Checked<Response<'_>> {
    Response::parse(du).or_else(|_| broken("a PDU of the DP-V1 services"))
}
