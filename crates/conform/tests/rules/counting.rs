//! The frame count memory of the faulty slaves. The slave behind it gets first requests only, which it executes always. So an
//! answer is repeated as the faulty slave sent it.

use super::faulty::{Frame, GET_CFG, GLOBAL_CONTROL, SLAVE_DIAG, as_first, is_rs};
use profivac_conform::probe::Received;
use std::collections::BTreeMap;

/// The fault of a frame count memory.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Counting {
    /// It keeps the rules.
    Correct,
    /// It takes a first request for a counted one.
    CountsFirst,
    /// It takes every counted request of the same master for a repetition.
    IgnoresBit,
    /// It takes an uncounted request for a counted one with the bit 0.
    CountsUncounted,
    /// It remembers a bit and an answer for each access point.
    PerAccessPoint,
    /// It remembers nothing.
    None,
    /// It executes repetitions of Slave_Diag and Get_Cfg.
    ReadsAnew,
    /// It does not remember RS.
    ForgetsRefusals,
    /// It executes repetitions of Data_Exchange.
    ExchangesAnew,
    /// It does not remember the master.
    IgnoresSource,
    /// FDL status changes the bit.
    CountsFdlStatus,
    /// Global_Control changes the bit.
    CountsGlobalControl,
    /// A telegram with a wrong check octet changes the bit.
    CountsDamaged,
    /// It executes repeated polls of MS2.
    PollsAnew,
}

/// What a slave remembers.
#[derive(Clone)]
struct Last {
    sa: u8,
    bit: bool,
    answer: Received,
}

/// The memory.
pub struct Memory {
    kind: Counting,
    /// The last counted request, by access point if there is a memory for each.
    last: BTreeMap<Option<u8>, Last>,
}

impl Memory {
    pub const fn new(kind: Counting) -> Self {
        Self { kind, last: BTreeMap::new() }
    }

    fn key(&self, request: &Frame) -> Option<u8> {
        if self.kind == Counting::PerAccessPoint { request.dsap } else { None }
    }

    /// Answers a request from the memory, or passes it on.
    pub fn receive(&mut self, octets: &[u8], pass_on: &mut dyn FnMut(&[u8]) -> Received) -> Received {
        let Some(request) = Frame::parse(octets) else {
            if self.kind == Counting::CountsDamaged
                && let Some(fc) = octets.get(6)
            {
                self.set_bit(fc & 0x20 != 0);
            }
            return pass_on(octets);
        };
        let is_srd = matches!(request.function(), 0xC | 0xD) && request.fc & 0x40 != 0 && request.da != 127;
        if !is_srd {
            let counts_it = match self.kind {
                Counting::CountsFdlStatus => request.function() == 9,
                Counting::CountsGlobalControl => request.dsap == GLOBAL_CONTROL,
                _ => false,
            };
            if counts_it {
                self.set_bit(false);
            }
            return pass_on(octets);
        }
        match self.repeated(&request) {
            Some(answer) => answer,
            None => self.execute(&request, octets, pass_on),
        }
    }

    fn set_bit(&mut self, bit: bool) {
        self.last.values_mut().for_each(|last| last.bit = bit);
    }

    /// The remembered answer, if the request is a repetition.
    fn repeated(&self, request: &Frame) -> Option<Received> {
        let last = self.last.get(&self.key(request))?;
        let bit = match request.count() {
            Some(_) if is_first(request) && self.kind != Counting::CountsFirst => return None,
            Some(bit) => bit,
            None if self.kind == Counting::CountsUncounted => false,
            None => return None,
        };
        let same_bit = bit == last.bit || self.kind == Counting::IgnoresBit;
        let same_source = request.sa == last.sa || self.kind == Counting::IgnoresSource;
        let executes = match self.kind {
            Counting::None => true,
            Counting::ReadsAnew => matches!(request.dsap, GET_CFG | SLAVE_DIAG),
            Counting::ForgetsRefusals => is_rs(&last.answer),
            Counting::ExchangesAnew => request.is_exchange(),
            Counting::PollsAnew => request.is_connection() && request.du.is_empty(),
            _ => false,
        };
        (same_bit && same_source && !executes).then(|| last.answer.clone())
    }

    fn execute(&mut self, request: &Frame, octets: &[u8], pass_on: &mut dyn FnMut(&[u8]) -> Received) -> Received {
        // A first request stays as it is, because the fault may lie in its form.
        let answer = if is_first(request) { pass_on(octets) } else { pass_on(&as_first(request)) };
        if let Some(bit) = request.count() {
            self.last.insert(self.key(request), Last { sa: request.sa, bit, answer: answer.clone() });
        }
        answer
    }
}

/// Whether FCV is 0 and FCB is 1.
fn is_first(request: &Frame) -> bool {
    request.fc & 0x30 == 0x20
}
