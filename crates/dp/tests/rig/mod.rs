//! A test rig for a slave: masters that send it one telegram after the other.
//!
//! The rig keeps time in bit times and one frame count bit per master, so a dialogue needs neither; every answer is
//! checked for its earliest moment, its addresses and its access points before the test sees it.

#![allow(clippy::panic, clippy::expect_used, reason = "a rig that cannot go on stops the test")]

mod device;
pub mod golden;

pub use crate::octets::{hex, text};
pub use device::{Gauge, Seen};

use profivac_dp::link::{Baud, BitTime, CHARACTER_TBIT, Station, T_SYN_TBIT};
use profivac_dp::slave::Slave;
use profivac_wire::acyclic::Response;
use profivac_wire::control::{Control, FrameCount, Function, Status};
use profivac_wire::{DataTelegram, MAX_TELEGRAM, Telegram};
use std::collections::HashMap;

/// The addresses of the slave and of the master in the printed examples.
pub const SLAVE: u8 = 8;
pub const MASTER: u8 = 2;

/// The answer of the slave.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Answer {
    Silence,
    Ack,
    Status(Status),
    Low(Vec<u8>),
    High(Vec<u8>),
}

pub const RS: Answer = Answer::Status(Status::ServiceNotActivated);
pub const RR: Answer = Answer::Status(Status::NoResource);

/// DL with the octets of `text`.
pub fn low(text: &str) -> Answer {
    Answer::Low(hex(text))
}

/// Initiate.req as printed in profibus-wire 4.6.6: Send_Timeout 1 s, no profile.
pub const INITIATE: &str = "57 00 00 00 00 64 01 00 00 00 00 00 00 02 00 02 00 00 00 00";

/// A slave and the time.
pub struct Rig<const CONNECTIONS: usize = 2> {
    pub slave: Slave<Gauge, CONNECTIONS>,
    pub now: BitTime,
    /// The end of the last request.
    pub request_end: BitTime,
    counts: HashMap<u8, FrameCount>,
    /// The last telegram sent.
    last: Vec<u8>,
}

impl Rig {
    pub fn new(device: Gauge) -> Self {
        Self::at(device, Baud::B1500000)
    }

    /// Master 2 owns the slave and exchanges data; DPV1_Enable is set.
    pub fn exchanging(device: Gauge) -> Self {
        let mut rig = Self::new(device);
        rig.start(MASTER, "80 00 00");
        rig
    }
}

impl<const CONNECTIONS: usize> Rig<CONNECTIONS> {
    /// A slave that has just been switched on.
    pub fn at(device: Gauge, baud: Baud) -> Self {
        let slave = Slave::with_connections(device, SLAVE, baud);
        Self { slave, now: BitTime(0), request_end: BitTime(0), counts: HashMap::new(), last: Vec::new() }
    }

    /// Master `sa` parameterises with `user` octets and configures.
    pub fn start(&mut self, sa: u8, user: &str) {
        let prm = hex(&format!("80 01 01 00 12 34 00 {user}"));
        assert_eq!(self.ms0(sa, 61, &prm), Answer::Ack);
        assert_eq!(self.ms0(sa, 62, &hex("11 21")), Answer::Ack);
    }

    pub fn device(&mut self) -> &mut Gauge {
        self.slave.device_mut()
    }

    /// Passes time; timers expire one after the other.
    pub fn pass(&mut self, tbit: u64) {
        let until = self.now + tbit;
        while let Some(wake) = self.slave.wake_at().filter(|wake| *wake <= until) {
            self.now = self.now.max(wake);
            assert_eq!(self.slave.poll(self.now), None, "a slave sends answers only");
            assert!(self.slave.wake_at().is_none_or(|next| next > wake), "an expired timer does not expire again");
        }
        self.now = until;
    }

    /// Sends octets as they are and returns the answer as it comes.
    pub fn raw(&mut self, octets: &[u8]) -> Option<Vec<u8>> {
        self.last = octets.to_vec();
        self.pass(T_SYN_TBIT + CHARACTER_TBIT * octets.len() as u64);
        self.request_end = self.now;
        let telegram = Telegram::parse(octets).expect("the rig sends telegrams");
        let transmit = self.slave.telegram(self.now, &telegram)?;
        assert!(transmit.not_before >= self.now + 11, "answered before min T_SDR");
        let answer = transmit.octets.to_vec();
        self.now = transmit.not_before + CHARACTER_TBIT * answer.len() as u64;
        self.slave.sent(self.now);
        Some(answer)
    }

    /// Sends a telegram of the reference, an SRD with the frame count bit this master has reached, and returns the answer as
    /// the reference would print it.
    pub fn dialogue(&mut self, request: &str) -> String {
        let octets = hex(request);
        let Ok(Telegram::Data(data)) = Telegram::parse(&octets) else { panic!("no telegram: {request}") };
        let counts = matches!(data.control(), Control::Request { function: Function::SrdLow | Function::SrdHigh, .. });
        let answer = if counts { self.counted(data) } else { self.raw(&octets) };
        answer.map_or_else(|| "silence".to_owned(), |answer| text(&answer))
    }

    /// Octets 0 to 3 of the diagnosis, as master `sa` reads it.
    pub fn diag(&mut self, sa: u8) -> String {
        match self.ms0(sa, 60, &[]) {
            Answer::Low(du) => text(&du[..4]),
            other => panic!("no diagnosis: {other:?}"),
        }
    }

    /// The same octets once more, because the answer was lost.
    pub fn again(&mut self) -> String {
        let last = self.last.clone();
        self.raw(&last).map_or_else(|| "silence".to_owned(), |answer| text(&answer))
    }

    /// A counted request.
    pub fn srd(&mut self, sa: u8, dsap: Option<u8>, ssap: Option<u8>, du: &[u8]) -> Answer {
        self.request(Function::SrdLow, sa, (dsap, ssap), du)
    }

    fn request(&mut self, function: Function, sa: u8, (dsap, ssap): (Option<u8>, Option<u8>), du: &[u8]) -> Answer {
        let fc = Control::Request { function, count: FrameCount::Uncounted }.to_octet();
        let data = DataTelegram { da: self.slave.address(), sa, dsap, ssap, fc, du };
        let answer = self.counted(data);
        read(&data, answer.as_deref())
    }

    /// A service of DP-V0, with the source access point of a class 1 master.
    pub fn ms0(&mut self, sa: u8, dsap: u8, du: &[u8]) -> Answer {
        self.srd(sa, Some(dsap), Some(62), du)
    }

    /// Data_Exchange with high priority, as masters send it.
    pub fn dx(&mut self, sa: u8, outputs: &[u8]) -> Answer {
        self.request(Function::SrdHigh, sa, (None, None), outputs)
    }

    /// Octets of a PDU to SAP 51, empty for a poll.
    pub fn ms1(&mut self, pdu: &str) -> Answer {
        self.srd(MASTER, Some(51), Some(51), &hex(pdu))
    }

    /// Octets of a PDU to SAP 51, and the response that the first poll fetches.
    pub fn ms1_job(&mut self, pdu: &str) -> Answer {
        assert_eq!(self.ms1(pdu), Answer::Ack);
        self.ms1("")
    }

    /// Octets of a PDU to an MS2 access point, empty for a poll.
    pub fn ms2(&mut self, sa: u8, sap: u8, pdu: &str) -> Answer {
        self.srd(sa, Some(sap), Some(50), &hex(pdu))
    }

    /// Octets of a PDU to an MS2 access point, and the response that the first poll fetches.
    pub fn ms2_job(&mut self, sa: u8, sap: u8, pdu: &str) -> Answer {
        assert_eq!(self.ms2(sa, sap, pdu), Answer::Ack);
        self.ms2(sa, sap, "")
    }

    /// Opens a connection and returns its access point.
    pub fn connect(&mut self, sa: u8) -> u8 {
        let Answer::Low(answer) = self.ms2(sa, 49, INITIATE) else { panic!("no connection is free") };
        let Ok(Response::ResourceManager(answer)) = Response::parse(&answer) else { panic!("no RM PDU: {answer:?}") };
        let opened = self.ms2(sa, answer.server_sap, "");
        assert_eq!(opened, low("57 F0 01 00 00 00 00 00 00 02 00 02 00 00 00 00"));
        answer.server_sap
    }

    /// The telegram with the count that this master has reached.
    fn counted(&mut self, data: DataTelegram<'_>) -> Option<Vec<u8>> {
        let Control::Request { function, .. } = data.control() else { panic!("no request") };
        let count = self.counts.get(&data.sa).copied().unwrap_or(FrameCount::First);
        self.counts.insert(data.sa, FrameCount::Counted(count == FrameCount::Counted(false)));
        let data = DataTelegram { fc: Control::Request { function, count }.to_octet(), ..data };
        self.raw(&emit(&Telegram::Data(data)))
    }
}

pub fn emit(telegram: &Telegram<'_>) -> Vec<u8> {
    let mut out = [0; MAX_TELEGRAM];
    let length = telegram.emit(&mut out).expect("the rig sends telegrams");
    out[..length].to_vec()
}

/// The answer to `request`, which swaps addresses and access points.
pub fn read(request: &DataTelegram<'_>, answer: Option<&[u8]>) -> Answer {
    let Some(octets) = answer else { return Answer::Silence };
    let data = match Telegram::parse(octets).expect("a slave sends telegrams") {
        Telegram::ShortAck => return Answer::Ack,
        Telegram::Token { .. } => panic!("a slave has no token"),
        Telegram::Data(data) => data,
    };
    assert_eq!((data.da, data.sa), (request.sa, request.da));
    let Control::Response { status, .. } = data.control() else { panic!("a slave sends no request") };
    if !matches!(status, Status::DataLow | Status::DataHigh) {
        assert_eq!((data.dsap, data.ssap, data.du), (None, None, &[][..]));
        return Answer::Status(status);
    }
    assert_eq!((data.dsap, data.ssap), (request.ssap, request.dsap));
    let du = data.du.to_vec();
    if status == Status::DataLow { Answer::Low(du) } else { Answer::High(du) }
}
