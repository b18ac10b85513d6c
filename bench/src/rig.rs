//! A slave in data exchange with a master that is a list of octets.

use profivac_dp::link::{Baud, BitTime, CHARACTER_TBIT, Received, Receiver, Station, T_SYN_TBIT};
use profivac_dp::slave::{CfgFault, Device, Features, Outputs, PrmFault, Slave};
use profivac_wire::cfg::{self, Lengths};
use profivac_wire::control::{Control, FrameCount, Function};
use profivac_wire::prm::{PrmStatus, SetPrm};
use profivac_wire::{DataTelegram, MAX_TELEGRAM, Sap, Telegram, sap};
use std::hint::black_box;

/// The address of the master.
pub const MASTER: u8 = 0;

/// The rate of all benchmarks.
pub const BAUD: Baud = Baud::B1500000;

/// The least there can be behind a slave: it keeps the outputs and returns the first of them. Its inputs may follow the outputs of the
/// exchange before, as those of a chip that answers from a buffer.
#[derive(Clone, Debug, Default)]
pub struct Mirror {
    /// The last outputs.
    pub outputs: [u8; 8],
    /// The slave may prepare its answers.
    pub may_prepare: bool,
}

impl Mirror {
    /// Its ident number.
    pub const IDENT: u16 = 0x1234;
}

impl Device for Mirror {
    fn ident_number(&self) -> u16 {
        Self::IDENT
    }

    fn features(&self) -> Features {
        Features::default()
    }

    fn set_prm(&mut self, _user: &[u8]) -> Result<(), PrmFault> {
        Ok(())
    }

    fn chk_cfg(&mut self, cfg: &[u8]) -> Result<Lengths, CfgFault> {
        cfg::lengths(cfg).map_err(|_| CfgFault)
    }

    fn get_cfg(&self) -> &[u8] {
        &[]
    }

    fn outputs(&mut self, outputs: Outputs<'_>) {
        match outputs {
            Outputs::Data(data) => self.outputs[..data.len()].copy_from_slice(data),
            Outputs::Safe => self.outputs = [0; 8],
        }
    }

    fn inputs(&mut self, inputs: &mut [u8]) {
        inputs.copy_from_slice(&self.outputs[..inputs.len()]);
    }

    fn keeps_inputs(&self, _before: &[u8], _outputs: &[u8]) -> bool {
        self.may_prepare
    }
}

/// A request to the slave at `da` as it is on the wire.
pub fn request(da: u8, service: Sap, count: FrameCount, du: &[u8]) -> Vec<u8> {
    let dsap = service.to_octet();
    let ssap = match service {
        Sap::Default => None,
        Sap::Ms1 => Some(sap::MASTER_MS1),
        _ => Some(sap::MASTER_MS0),
    };
    let fc = Control::Request { function: Function::SrdHigh, count }.to_octet();
    telegram(DataTelegram { da, sa: MASTER, dsap, ssap, fc, du })
}

/// A frame as it is on the wire.
pub fn telegram(frame: DataTelegram<'_>) -> Vec<u8> {
    let mut out = [0; MAX_TELEGRAM];
    let length = Telegram::Data(frame).emit(&mut out).unwrap_or(0);
    out[..length].to_vec()
}

/// A slave behind a receiver, in data exchange.
pub struct SlaveRig<D> {
    /// Receives the requests.
    pub receiver: Receiver,
    /// Answers them.
    pub slave: Slave<D>,
    /// When the last octet ended.
    pub now: BitTime,
}

impl<D: Device> SlaveRig<D> {
    /// The address of the slave.
    pub const ADDRESS: u8 = 5;

    /// A device that a master has brought into data exchange.
    pub fn exchanging(device: D, user: &[u8], cfg: &[u8]) -> Self {
        let ident = device.ident_number();
        let slave = Slave::new(device, Self::ADDRESS, BAUD);
        let mut rig = Self { receiver: Receiver::new(BitTime(0)), slave, now: BitTime(0) };
        let prm = SetPrm { status: PrmStatus::LOCK_REQ, wd_fact: [0, 0], min_tsdr: 11, ident, group: 0, user };
        let mut du = [0; 32];
        let length = prm.emit(&mut du).unwrap_or(0);
        rig.receive(&request(Self::ADDRESS, Sap::SetPrm, FrameCount::First, &du[..length]));
        rig.receive(&request(Self::ADDRESS, Sap::ChkCfg, FrameCount::Counted(false), cfg));
        rig
    }

    /// Receives a request in one piece after T_SYN, and returns the length of the answer.
    pub fn receive(&mut self, octets: &[u8]) -> usize {
        let first = self.now + T_SYN_TBIT + CHARACTER_TBIT;
        self.now = self.now + T_SYN_TBIT + CHARACTER_TBIT * octets.len() as u64;
        match self.receiver.octets(first, octets) {
            (_, Received::Telegram(telegram)) => answer(&mut self.slave, self.now, &telegram),
            _ => 0,
        }
    }

    /// The idle time after an answer, in which the slave prepares the next one.
    pub fn rest(&mut self) {
        self.slave.sent(self.now);
    }

    /// As [`receive`](Self::receive), octet by octet.
    pub fn receive_each(&mut self, octets: &[u8]) -> usize {
        let mut now = self.now + T_SYN_TBIT;
        let mut answered = 0;
        for octet in octets {
            now = now + CHARACTER_TBIT;
            if let Received::Telegram(telegram) = self.receiver.octet(now, *octet) {
                answered = answer(&mut self.slave, now, &telegram);
            }
        }
        self.now = now;
        answered
    }
}

/// How many octets the slave answers with.
fn answer<D: Device>(slave: &mut Slave<D>, now: BitTime, telegram: &Telegram<'_>) -> usize {
    slave.telegram(now, telegram).map_or(0, |answer| black_box(answer.octets).len())
}

/// Both values of the frame count bit by turns, so that no request is a repetition.
pub fn counted(of: impl Fn(FrameCount) -> Vec<u8>) -> [Vec<u8>; 2] {
    [true, false].map(|fcb| of(FrameCount::Counted(fcb)))
}
