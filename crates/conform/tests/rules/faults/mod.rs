//! The faulty slaves, one for each rule, in the order of the rules.

mod acyclic;
mod count;
mod exchange;
mod link;
mod lock;
mod noise;
mod states;
mod watchdog;

use super::counting::Counting;
use super::damaged;
use super::faulty::{
    CHK_CFG, FDL_STATUS, Fault, Frame, GET_CFG, GLOBAL_CONTROL, MANAGER, MS1, RD_INP, RD_OUTP, RR, RS, Reaction,
    SET_PRM, SET_SLAVE_ADD, SLAVE_DIAG, UE, as_first, diagnosis, is_exchanging, is_rs, is_waiting, leave, request, sc,
    status,
};
use super::slave::{ADDRESS, CFG, IDENT, MASTER};
use Fault::{Answers, ChangesAnswer, ChangesRequest, Counts, Reacts, RefusesOthers, Reports, Returns};
use profivac_conform::probe::Received;
use profivac_dp::slave::SlaveState;

/// A slave with one fault.
pub struct FaultySlave {
    /// The rule that it breaks.
    pub rule: &'static str,
    /// What it does, as a sentence without its subject.
    pub does: &'static str,
    pub fault: Fault,
}

const fn slave(rule: &'static str, does: &'static str, fault: Fault) -> FaultySlave {
    FaultySlave { rule, does, fault }
}

/// All faulty slaves.
pub fn all() -> impl Iterator<Item = &'static FaultySlave> {
    [
        link::SLAVES,
        states::SLAVES,
        lock::SLAVES,
        exchange::SLAVES,
        count::SLAVES,
        watchdog::SLAVES,
        acyclic::SLAVES,
        noise::SLAVES,
    ]
    .into_iter()
    .flatten()
}

/// Octets of a diagnosis.
const ONE: usize = 0;
const TWO: usize = 1;
const THREE: usize = 2;
const OWNER: usize = 3;

/// Bits of the first octet of Set_Prm.
const LOCK: u8 = 0x80;
const UNLOCK: u8 = 0x40;
const WD_ON: u8 = 0x08;

fn is_prm(request: &Frame) -> bool {
    request.dsap == SET_PRM && request.du.len() >= 7
}

fn has_ident(request: &Frame) -> bool {
    request.du.get(4..6) == Some(&IDENT.to_be_bytes())
}

/// Set_Prm with Lock_Req and the right ident number.
fn is_valid_prm(request: &Frame) -> bool {
    is_prm(request) && request.du[0] & (LOCK | UNLOCK) == LOCK && has_ident(request)
}

/// Set_Prm with Lock_Req and another ident number.
fn is_faulty_prm(request: &Frame) -> bool {
    is_prm(request) && request.du[0] & (LOCK | UNLOCK) == LOCK && !has_ident(request)
}

fn is_unlock(request: &Frame) -> bool {
    is_prm(request) && request.du[0] & UNLOCK != 0
}

/// Chk_Cfg with a truncated identifier.
fn is_truncated_cfg(request: &Frame) -> bool {
    request.dsap == CHK_CFG && request.du.last() == Some(&0xC0)
}

/// A slave that keeps a bit of the first octet of its diagnosis from a request until it is released.
fn latched(begins: fn(&Frame) -> bool, bit: u8) -> Box<Reaction> {
    let mut latched = false;
    Box::new(move |line, octets| {
        let received = line.send(octets);
        let Some(request) = Frame::parse(octets) else { return received };
        latched = (latched || begins(&request)) && !is_unlock(&request);
        let Some(mut answer) = Frame::parse_answer(&received) else { return received };
        diagnosis(&request, &mut answer, |du| {
            if latched {
                du[ONE] |= bit;
            }
        });
        Received::Telegram(answer.octets())
    })
}

/// A slave that leaves data exchange after a request.
fn ends_exchange(ends: fn(&Frame) -> bool) -> Box<Reaction> {
    Box::new(move |line, octets| {
        let was = is_exchanging(&line.slave);
        let received = line.send(octets);
        if was && Frame::parse(octets).is_some_and(|request| ends(&request)) {
            leave(line);
        }
        received
    })
}

/// A slave that acknowledges a request of its owner during data exchange and does not execute it.
fn ignores_in_exchange(ignores: fn(&Frame) -> bool) -> Box<Reaction> {
    Box::new(move |line, octets| match Frame::parse(octets) {
        Some(request) if is_exchanging(&line.slave) && request.sa == MASTER && ignores(&request) => sc(),
        _ => line.send(octets),
    })
}
