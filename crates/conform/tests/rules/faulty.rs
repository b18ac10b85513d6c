//! A slave with one fault: the small slave, and between it and the line something that changes what it hears or says.

use super::counting::{Counting, Memory};
use super::slave::{ADDRESS, Line, MASTER, SampleSlave};
use profivac_conform::dialogue::{Link, telegram_octets};
use profivac_conform::probe::Received;
use profivac_dp::slave::SlaveState;
use profivac_host::port::PortError;
use profivac_wire::{DataTelegram, Telegram};
use std::time::Duration;

/// A data telegram.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Frame {
    pub da: u8,
    pub sa: u8,
    pub dsap: Option<u8>,
    pub ssap: Option<u8>,
    pub fc: u8,
    pub du: Vec<u8>,
}

impl Frame {
    /// The data telegram in `octets`, if they are one.
    pub fn parse(octets: &[u8]) -> Option<Self> {
        let Ok(Telegram::Data(data)) = Telegram::parse(octets) else { return None };
        let DataTelegram { da, sa, dsap, ssap, fc, du } = data;
        Some(Self { da, sa, dsap, ssap, fc, du: du.to_vec() })
    }

    /// The data telegram in an answer.
    pub fn parse_answer(received: &Received) -> Option<Self> {
        match received {
            Received::Telegram(octets) => Self::parse(octets),
            Received::Nothing | Received::Damaged => None,
        }
    }

    pub fn octets(&self) -> Vec<u8> {
        let Self { da, sa, dsap, ssap, fc, du } = self;
        telegram_octets(DataTelegram { da: *da, sa: *sa, dsap: *dsap, ssap: *ssap, fc: *fc, du })
    }

    /// The function code of a request.
    pub fn function(&self) -> u8 {
        self.fc & 0x0F
    }

    /// The frame count bit, if it is valid or the request is a first one.
    pub fn count(&self) -> Option<bool> {
        let (fcb, fcv) = (self.fc & 0x20 != 0, self.fc & 0x10 != 0);
        (fcv || fcb).then_some(fcb)
    }

    /// Whether it is Data_Exchange.
    pub fn is_exchange(&self) -> bool {
        self.dsap.is_none() && matches!(self.function(), 0xC | 0xD)
    }

    /// Whether it goes to the access point of an MS2 connection.
    pub fn is_connection(&self) -> bool {
        matches!(self.dsap, Some(0..=48))
    }
}

pub const FDL_STATUS: u8 = 0x9;
pub const MANAGER: Option<u8> = Some(49);
pub const MS1: Option<u8> = Some(51);
pub const SET_SLAVE_ADD: Option<u8> = Some(55);
pub const RD_INP: Option<u8> = Some(56);
pub const RD_OUTP: Option<u8> = Some(57);
pub const GLOBAL_CONTROL: Option<u8> = Some(58);
pub const GET_CFG: Option<u8> = Some(59);
pub const SLAVE_DIAG: Option<u8> = Some(60);
pub const SET_PRM: Option<u8> = Some(61);
pub const CHK_CFG: Option<u8> = Some(62);

/// SC.
pub fn sc() -> Received {
    Received::Telegram(vec![0xE5])
}

pub const UE: u8 = 1;
pub const RR: u8 = 2;
pub const RS: u8 = 3;

/// An answer without data.
pub fn status(request: &Frame, status: u8) -> Received {
    let answer = Frame { da: request.sa, sa: request.da, dsap: None, ssap: None, fc: status, du: Vec::new() };
    Received::Telegram(answer.octets())
}

/// Whether the answer is RS.
pub fn is_rs(received: &Received) -> bool {
    matches!(received, Received::Telegram(octets) if Frame::parse(octets).is_some_and(|answer| answer.fc == RS))
}

/// How a faulty slave differs from the correct one.
pub enum Fault {
    /// It takes a request for another one.
    ChangesRequest(fn(&mut Frame)),
    /// It changes its answers that are data telegrams. The first argument is the request.
    ChangesAnswer(fn(&Frame, &mut Frame)),
    /// It changes its diagnosis.
    Reports(fn(&mut [u8])),
    /// It changes the data that it returns on an access point.
    Returns(Option<u8>, fn(&mut Vec<u8>)),
    /// It refuses the service of an access point to other masters than the testing one.
    RefusesOthers(Option<u8>),
    /// It has a fault in its frame count memory.
    Counts(Counting),
    /// It replaces its answers. The arguments are the slave, the request and the answer.
    Answers(fn(&SampleSlave, &Frame, Received) -> Received),
    /// It does anything else with the octets of a request.
    Reacts(fn() -> Box<Reaction>),
}

/// What a faulty slave does with the octets of a request.
pub type Reaction = dyn FnMut(&mut Line<SampleSlave>, &[u8]) -> Received;

/// A slave with a fault on its line.
pub struct FaultyLine {
    line: Line<SampleSlave>,
    memory: Memory,
    react: Box<Reaction>,
}

impl FaultyLine {
    pub fn new(line: Line<SampleSlave>, fault: &Fault) -> Self {
        let react: Box<Reaction> = match *fault {
            Fault::ChangesRequest(change) => Box::new(move |line, octets| {
                let Some(mut request) = Frame::parse(octets) else { return line.send(octets) };
                change(&mut request);
                line.send(&request.octets())
            }),
            Fault::ChangesAnswer(change) => changes_answer(change),
            Fault::Reports(change) => changes_answer(move |request, answer| diagnosis(request, answer, change)),
            Fault::Returns(dsap, change) => changes_answer(move |request, answer| {
                const DATA_LOW: u8 = 8;
                if request.dsap == dsap && answer.fc == DATA_LOW {
                    change(&mut answer.du);
                }
            }),
            Fault::RefusesOthers(dsap) => Box::new(move |line, octets| {
                let received = line.send(octets);
                match Frame::parse(octets) {
                    Some(request) if request.dsap == dsap && request.sa != MASTER && received != Received::Nothing => {
                        status(&request, RS)
                    }
                    _ => received,
                }
            }),
            Fault::Answers(change) => Box::new(move |line, octets| {
                let received = line.send(octets);
                match Frame::parse(octets) {
                    Some(request) => change(&line.slave, &request, received),
                    None => received,
                }
            }),
            Fault::Counts(_) => Box::new(Line::send),
            Fault::Reacts(make) => make(),
        };
        let counting = if let Fault::Counts(counting) = fault { *counting } else { Counting::Correct };
        Self { line, memory: Memory::new(counting), react }
    }
}

/// A slave that changes its answers that are data telegrams.
fn changes_answer(change: impl Fn(&Frame, &mut Frame) + 'static) -> Box<Reaction> {
    Box::new(move |line, octets| {
        let received = line.send(octets);
        let (Some(request), Some(mut answer)) = (Frame::parse(octets), Frame::parse_answer(&received)) else {
            return received;
        };
        change(&request, &mut answer);
        Received::Telegram(answer.octets())
    })
}

/// A diagnosis, which `change` alters.
pub fn diagnosis(request: &Frame, answer: &mut Frame, change: impl FnOnce(&mut [u8])) {
    if request.dsap == SLAVE_DIAG && answer.du.len() >= 6 {
        change(&mut answer.du);
    }
}

impl Link for FaultyLine {
    fn address(&self) -> u8 {
        MASTER
    }

    fn send_and_receive(&mut self, octets: &[u8]) -> Result<Received, PortError> {
        let Self { line, memory, react } = self;
        Ok(memory.receive(octets, &mut |octets| react(line, octets)))
    }

    fn wait(&mut self, time: Duration) -> Result<(), PortError> {
        self.line.pass(time);
        Ok(())
    }
}

/// Whether the slave exchanges data.
pub fn is_exchanging(slave: &SampleSlave) -> bool {
    matches!(slave.state(), SlaveState::DataExch(..))
}

/// Whether the slave waits for parameters.
pub fn is_waiting(slave: &SampleSlave) -> bool {
    matches!(slave.state(), SlaveState::WaitPrm(_))
}

/// Ends the slave's data exchange, as Unlock_Req of its owner does.
pub fn leave(line: &mut Line<SampleSlave>) {
    line.slave.return_to_wait_prm();
}

/// A first request to the slave.
pub fn request(sa: u8, dsap: u8, du: &[u8]) -> Vec<u8> {
    Frame { da: ADDRESS, sa, dsap: Some(dsap), ssap: Some(62), fc: 0x6D, du: du.to_vec() }.octets()
}

/// The same request as a first one, which the slave executes whatever it remembers.
pub fn as_first(request: &Frame) -> Vec<u8> {
    Frame { fc: request.fc & 0x4F | 0x20, ..request.clone() }.octets()
}
