//! Data_Exchange as a slave sees it, from the first octet of the request to the answer.

use profivac_dp::link::{Baud, BitTime, CHARACTER_TBIT, Heard, Receiver, Station, T_SYN_TBIT};
use profivac_dp::slave::{CfgFault, Device, Features, Outputs, PrmFault, Slave};
use profivac_wire::cfg::{self, Lengths};
use profivac_wire::control::{Control, FrameCount, Function};
use profivac_wire::prm::{PrmStatus, SetPrm};
use profivac_wire::{Frame, MAX_TELEGRAM, Sap, Telegram, sap};
use std::hint::black_box;

const MASTER: u8 = 2;
const ADDRESS: u8 = 5;

/// Five octets out, two in.
const CFG: [u8; 2] = [0x24, 0x11];
const OUTPUTS: [u8; 5] = [1, 2, 3, 4, 5];

/// The least there can be behind a slave: it keeps the outputs and returns two of them.
#[derive(Clone, Debug, Default)]
struct Mirror {
    outputs: [u8; 5],
}

impl Device for Mirror {
    fn ident_number(&self) -> u16 {
        0x1234
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
        &CFG
    }

    fn outputs(&mut self, outputs: Outputs<'_>) {
        match outputs {
            Outputs::Data(data) => self.outputs.copy_from_slice(data),
            Outputs::Safe => self.outputs = [0; 5],
        }
    }

    fn inputs(&mut self, inputs: &mut [u8]) {
        inputs.copy_from_slice(&self.outputs[..2]);
    }
}

/// A request as it is on the wire.
fn request(service: Sap, count: FrameCount, du: &[u8]) -> Vec<u8> {
    let dsap = service.to_octet();
    let fc = Control::Request { function: Function::SrdHigh, count }.to_octet();
    let frame = Frame { da: ADDRESS, sa: MASTER, dsap, ssap: dsap.and(Some(sap::MASTER_MS0)), fc, du };
    let mut out = [0; MAX_TELEGRAM];
    let length = Telegram::Frame(frame).emit(&mut out).unwrap_or(0);
    out[..length].to_vec()
}

/// A slave behind a receiver, in data exchange.
struct Bench {
    receiver: Receiver,
    slave: Slave<Mirror>,
    now: BitTime,
}

impl Bench {
    fn exchanging() -> Self {
        let mut bench = Self {
            receiver: Receiver::new(BitTime(0)),
            slave: Slave::new(Mirror::default(), ADDRESS, Baud::B1500000),
            now: BitTime(0),
        };
        let prm =
            SetPrm { status: PrmStatus::LOCK_REQ, wd_fact: [0, 0], min_tsdr: 11, ident: 0x1234, group: 0, user: &[] };
        let mut du = [0; 7];
        let _ = prm.emit(&mut du);
        bench.hear(&request(Sap::SetPrm, FrameCount::First, &du));
        bench.hear(&request(Sap::ChkCfg, FrameCount::Counted(false), &CFG));
        bench
    }

    /// Hears a request that arrives in one piece after T_SYN, and returns the length of the answer.
    fn hear(&mut self, octets: &[u8]) -> usize {
        let first = self.now + T_SYN_TBIT + CHARACTER_TBIT;
        self.now = self.now + T_SYN_TBIT + CHARACTER_TBIT * octets.len() as u64;
        match self.receiver.octets(first, octets) {
            (_, Heard::Telegram(telegram)) => answer(&mut self.slave, self.now, &telegram),
            _ => 0,
        }
    }

    /// The same, octet by octet.
    fn hear_each(&mut self, octets: &[u8]) -> usize {
        self.now = self.now + T_SYN_TBIT;
        let mut answered = 0;
        for octet in octets {
            self.now = self.now + CHARACTER_TBIT;
            if let Heard::Telegram(telegram) = self.receiver.octet(self.now, *octet) {
                answered = answer(&mut self.slave, self.now, &telegram);
            }
        }
        answered
    }
}

/// How many octets the slave answers with.
fn answer(slave: &mut Slave<Mirror>, now: BitTime, telegram: &Telegram<'_>) -> usize {
    slave.telegram(now, telegram).map_or(0, |answer| black_box(answer.octets).len())
}

/// Requests with both values of the frame count bit, so that none is a repetition.
fn requests() -> [Vec<u8>; 2] {
    [true, false].map(|fcb| request(Sap::Default, FrameCount::Counted(fcb), &OUTPUTS))
}

/// The whole exchange, the request in one piece.
pub fn in_one_piece(times: u32) {
    let mut bench = Bench::exchanging();
    for request in requests().iter().cycle().take(times as usize) {
        black_box(bench.hear(black_box(request)));
    }
}

/// The whole exchange, the request octet by octet.
pub fn octet_by_octet(times: u32) {
    let mut bench = Bench::exchanging();
    for request in requests().iter().cycle().take(times as usize) {
        black_box(bench.hear_each(black_box(request)));
    }
}

/// All octets of the request but the last; then the line is disturbed, so that the next request begins anew.
pub fn all_but_last(times: u32) {
    let mut bench = Bench::exchanging();
    for request in requests().iter().cycle().take(times as usize) {
        let [octets @ .., _] = black_box(request.as_slice()) else { continue };
        black_box(bench.hear_each(octets));
        bench.receiver.character_error(bench.now);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_request_is_answered_with_two_octets() {
        let mut bench = Bench::exchanging();
        for request in requests() {
            assert_eq!(request.len(), 14);
            assert_eq!(bench.hear(&request), 11);
        }
        for request in requests() {
            assert_eq!(bench.hear_each(&request), 11);
        }
        assert_eq!(bench.slave.device().outputs, OUTPUTS);
    }

    #[test]
    fn a_request_without_its_last_octet_is_not_answered() {
        let mut bench = Bench::exchanging();
        assert_eq!(bench.hear_each(&requests()[0][..13]), 0);
    }
}
