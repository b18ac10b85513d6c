//! Slaves that do what the reference allows beside what it recommends (profibus-wire 10), and slaves with fewer services. None
//! of them breaks a rule.

use super::faulty::{
    CHK_CFG, Fault, Frame, MANAGER, MS1, RR, RS, Reaction, SET_PRM, SLAVE_DIAG, is_exchanging, request, sc, status,
};
use super::slave::{CFG, MASTER};
use Fault::{Answers, ChangesAnswer, Reacts};
use profivac_conform::probe::Received;
use std::collections::VecDeque;

/// What the slave does, and how.
pub static ALTERNATIVES: &[(&str, Fault)] = &[
    (
        "refuses Set_Prm of another master with RS (point 6)",
        Answers(|slave, request, answer| {
            let locked = slave.state().is_locked_against(request.sa);
            if request.dsap == SET_PRM && locked { status(request, RS) } else { answer }
        }),
    ),
    (
        "refuses Chk_Cfg without Set_Prm and of another master with RS (point 7)",
        Reacts(|| {
            Box::new(|line, octets| match Frame::parse(octets) {
                Some(request) if request.dsap == CHK_CFG => {
                    let owned = line.slave.state().owner().is_some_and(|owner| owner.master == request.sa);
                    if owned { line.send(octets) } else { status(&request, RS) }
                }
                _ => line.send(octets),
            })
        }),
    ),
    (
        "refuses outputs of another length with RR and stays (point 10)",
        Reacts(|| {
            Box::new(|line, octets| match Frame::parse(octets) {
                Some(request) if request.is_exchange() && is_exchanging(&line.slave) && request.du.len() != 2 => {
                    status(&request, RR)
                }
                _ => line.send(octets),
            })
        }),
    ),
    (
        "accepts Unlock_Req of any master (point 12)",
        Reacts(|| {
            Box::new(|line, octets| {
                let unlocks = Frame::parse(octets)
                    .filter(|request| request.dsap == SET_PRM && request.du.first().is_some_and(|one| one & 0x40 != 0));
                match unlocks {
                    Some(unlock) => line.send(&Frame { sa: MASTER, ..unlock }.octets()),
                    None => line.send(octets),
                }
            })
        }),
    ),
    (
        "sends the response of DP-V1 at once (point 21)",
        Reacts(|| {
            Box::new(|line, octets| {
                let received = line.send(octets);
                match Frame::parse(octets) {
                    Some(pdu) if is_acyclic(&pdu) && !pdu.du.is_empty() && received == sc() && pdu.du[0] != 0x58 => {
                        line.send(&Frame { du: Vec::new(), ..pdu }.octets())
                    }
                    _ => received,
                }
            })
        }),
    ),
    ("has the response of DP-V1 at the third poll", Reacts(|| held_back(is_acyclic, 2))),
    (
        "has the answer of the resource manager at the first poll (point 25)",
        Reacts(|| held_back(|request| request.dsap == MANAGER, 0)),
    ),
    (
        "keeps Diag_Master_Add after a fault (point 31)",
        ChangesAnswer(|request, answer| {
            if request.dsap == SLAVE_DIAG && answer.du[0] & 0x44 != 0 {
                answer.du[3] = MASTER;
            }
        }),
    ),
    (
        "sends SD1 with NR for SC",
        Answers(|_, request, answer| if answer == sc() { status(request, 9) } else { answer }),
    ),
    (
        "has no RD_Inp and no RD_Outp",
        Answers(|_, request, answer| {
            if matches!(request.dsap, Some(56 | 57)) && answer != Received::Nothing {
                status(request, RS)
            } else {
                answer
            }
        }),
    ),
    (
        "has neither MS1 nor MS2",
        Answers(|_, request, answer| {
            if matches!(request.dsap, Some(0..=51)) && answer != Received::Nothing {
                status(request, RS)
            } else {
                answer
            }
        }),
    ),
    (
        "is ready after five requests for data",
        Reacts(|| {
            let mut left = 0;
            Box::new(move |line, octets| {
                let Some(request) = Frame::parse(octets) else { return line.send(octets) };
                if request.dsap == CHK_CFG && request.sa == MASTER {
                    left = 5;
                }
                let waits = request.is_exchange() && is_exchanging(&line.slave) && left > 0;
                if waits {
                    left -= 1;
                    return status(&request, RS);
                }
                line.send(octets)
            })
        }),
    ),
    (
        "adapts itself to another configuration",
        Reacts(|| {
            let mut cfg = CFG.to_vec();
            Box::new(move |line, octets| {
                let Some(received_request) = Frame::parse(octets) else { return line.send(octets) };
                match received_request.dsap {
                    CHK_CFG if profivac_wire::cfg::lengths(&received_request.du).is_ok() => {
                        cfg.clone_from(&received_request.du);
                        line.send(&request(received_request.sa, 62, &CFG))
                    }
                    Some(59) if received_request.da != MASTER => {
                        let answer = line.send(octets);
                        let Some(mut answer) = Frame::parse_answer(&answer) else { return answer };
                        answer.du.clone_from(&cfg);
                        Received::Telegram(answer.octets())
                    }
                    _ => line.send(octets),
                }
            })
        }),
    ),
];

/// Whether the request goes to MS1 or to an MS2 connection.
fn is_acyclic(request: &Frame) -> bool {
    request.dsap == MS1 || request.is_connection()
}

/// A slave that acknowledges requests and polls of a service before it sends their answer: after a request and `polls` polls.
fn held_back(service: fn(&Frame) -> bool, polls: usize) -> Box<Reaction> {
    let mut waiting: VecDeque<(Option<u8>, usize, Received)> = VecDeque::new();
    Box::new(move |line, octets| {
        let Some(request) = Frame::parse(octets).filter(|request| service(request) && request.sa == MASTER) else {
            return line.send(octets);
        };
        if let Some(index) = waiting.iter().position(|(sap, ..)| *sap == request.dsap)
            && request.du.is_empty()
        {
            let (_, left, _) = &mut waiting[index];
            if *left > 0 {
                *left -= 1;
                return sc();
            }
            return waiting.remove(index).unwrap().2;
        }
        // Abort drops a response.
        waiting.retain(|(sap, ..)| *sap != request.dsap);
        let received = line.send(octets);
        let has_data = Frame::parse_answer(&received).is_some_and(|answer| !answer.du.is_empty());
        if !has_data {
            return received;
        }
        waiting.push_back((request.dsap, polls, received));
        sc()
    })
}
