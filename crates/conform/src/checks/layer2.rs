//! Layer 2: the telegrams that a slave answers, and repetitions (profibus-wire 1.7 to 1.11).

use super::Check;
use crate::dialogue::{Answer, CheckOutcome, Dialogue, octets, require, violated};
use crate::probe::Received;
use profivac_wire::{BROADCAST, Sap};

pub const CHECKS: &[Check] = &[
    Check {
        name: "layer2.fdl-status",
        rule: "FDL status is answered as a slave, without access points",
        section: "1.11",
        run: fdl_status,
    },
    Check {
        name: "layer2.damaged",
        rule: "a telegram with one altered octet is not answered",
        section: "1.8",
        run: damaged,
    },
    Check {
        name: "layer2.cut-off",
        rule: "a telegram that ends early is not answered, and the next one is",
        section: "1.7",
        run: cut_off,
    },
    Check {
        name: "layer2.not-for-it",
        rule: "broadcast requests, and its own address and 127 as a source, are not answered",
        section: "1.8",
        run: not_for_it,
    },
    Check {
        name: "layer2.no-request",
        rule: "tokens, SC and responses are not answered",
        section: "1.8",
        run: no_request,
    },
    Check {
        name: "layer2.closed",
        rule: "a request to a service access point that does not exist is answered with RS",
        section: "1.8",
        run: closed,
    },
    Check {
        name: "layer2.sd3",
        rule: "a request with eight octets of data is accepted as SD3",
        section: "1.2",
        run: sd3,
    },
    Check {
        name: "layer2.repetition",
        rule: "a repetition gets the same answer again",
        section: "1.9",
        run: repetition,
    },
    Check {
        name: "layer2.one-count",
        rule: "all services of a master share one frame count bit",
        section: "1.9",
        run: one_count,
    },
    Check {
        name: "layer2.other-master",
        rule: "a request of another master is new with any frame count bit",
        section: "1.9",
        run: other_master,
    },
];

/// Slave_Diag with FCV 0 and FCB 1, and with FCV 1 and FCB 0 and 1.
const SRD_HIGH_FIRST: u8 = 0x6D;
const SRD_HIGH_0: u8 = 0x5D;
const SRD_HIGH_1: u8 = 0x7D;
const FDL_STATUS: u8 = 0x49;

fn fdl_status_telegram(da: u8, sa: u8) -> Vec<u8> {
    octets(da, sa, Sap::Default, FDL_STATUS, &[])
}

fn slave_diag(dialogue: &Dialogue<'_>, fc: u8) -> Vec<u8> {
    octets(dialogue.slave.address, dialogue.own_address(), Sap::SlaveDiag, fc, &[])
}

/// The answer of the slave to FDL status of the master `own`.
fn fdl_status_answer(slave: u8, own: u8) -> Received {
    Received::Telegram(octets(own, slave, Sap::Default, 0x00, &[]))
}

fn fdl_status(dialogue: &mut Dialogue<'_>) -> CheckOutcome {
    let received = dialogue.send(&fdl_status_telegram(dialogue.slave.address, dialogue.own_address()))?;
    require(received == fdl_status_answer(dialogue.slave.address, dialogue.own_address()), "SD1 with FC 00")
}

fn damaged(dialogue: &mut Dialogue<'_>) -> CheckOutcome {
    for telegram in
        [fdl_status_telegram(dialogue.slave.address, dialogue.own_address()), slave_diag(dialogue, SRD_HIGH_FIRST)]
    {
        for place in 0..telegram.len() {
            let mut altered = telegram.clone();
            altered.get_mut(place).into_iter().for_each(|octet| *octet ^= 0x04);
            dialogue.expect_silence(&altered, &format!("octet {place} is altered"))?;
        }
    }
    Ok(())
}

fn cut_off(dialogue: &mut Dialogue<'_>) -> CheckOutcome {
    let complete = slave_diag(dialogue, SRD_HIGH_FIRST);
    for length in [1, 3, 6, complete.len().saturating_sub(1)] {
        dialogue
            .expect_silence(complete.get(..length).unwrap_or_default(), &format!("only {length} octets were sent"))?;
        fdl_status(dialogue)?;
    }
    Ok(())
}

fn not_for_it(dialogue: &mut Dialogue<'_>) -> CheckOutcome {
    let (slave, own) = (dialogue.slave.address, dialogue.own_address());
    dialogue.expect_silence(&fdl_status_telegram(BROADCAST, own), "no slave answers a broadcast request")?;
    dialogue.expect_silence(
        &octets(BROADCAST, own, Sap::SlaveDiag, SRD_HIGH_FIRST, &[]),
        "no slave answers a broadcast request",
    )?;
    dialogue.expect_silence(&fdl_status_telegram(slave, slave), "the source is the slave itself")?;
    dialogue.expect_silence(&fdl_status_telegram(slave, BROADCAST), "127 is not the address of a station")
}

fn no_request(dialogue: &mut Dialogue<'_>) -> CheckOutcome {
    let (slave, own) = (dialogue.slave.address, dialogue.own_address());
    dialogue.expect_silence(&[0xDC, slave, own], "a slave does not answer a token")?;
    dialogue.expect_silence(&[0xE5], "SC is not a request")?;
    dialogue.expect_silence(&octets(slave, own, Sap::SlaveDiag, 0x08, &[0; 6]), "a response is not a request")
}

fn closed(dialogue: &mut Dialogue<'_>) -> CheckOutcome {
    dialogue.expect_closed(Sap::Other(63), &[], "RS: access point 63 does not exist")
}

/// Sends Chk_Cfg to a slave that waits for parameters: the slave must answer, with any status.
fn sd3(dialogue: &mut Dialogue<'_>) -> CheckOutcome {
    dialogue.release()?;
    let (slave, own) = (dialogue.slave.address, dialogue.own_address());
    let body = [slave | 0x80, own | 0x80, SRD_HIGH_FIRST, 62, 62, 0, 0, 0, 0, 0, 0];
    let sum = body.iter().fold(0_u8, |sum, octet| sum.wrapping_add(*octet));
    let telegram: Vec<_> = [0xA2].into_iter().chain(body).chain([sum, 0x16]).collect();
    let received = dialogue.send(&telegram)?;
    require(matches!(received, Received::Telegram(_)), "an answer")
}

fn repetition(dialogue: &mut Dialogue<'_>) -> CheckOutcome {
    let first = slave_diag(dialogue, SRD_HIGH_FIRST);
    require(matches!(dialogue.send(&first)?, Received::Telegram(_)), "a diagnosis")?;
    let counted = slave_diag(dialogue, SRD_HIGH_0);
    let answer = dialogue.send(&counted)?;
    require(matches!(answer, Received::Telegram(_)), "a diagnosis")?;
    let repeated = dialogue.send(&counted)?;
    require(answer == repeated, "the same octets again")
}

fn one_count(dialogue: &mut Dialogue<'_>) -> CheckOutcome {
    for sap in [Sap::SlaveDiag, Sap::GetCfg, Sap::GetCfg, Sap::SlaveDiag] {
        let answer = dialogue.request(sap, &[])?;
        require(matches!(&answer, Answer::Data { du, .. } if !du.is_empty()), "an answer with data")?;
    }
    Ok(())
}

fn other_master(dialogue: &mut Dialogue<'_>) -> CheckOutcome {
    let (own, other) = (dialogue.own_address(), dialogue.other_master_address());
    dialogue.send(&slave_diag(dialogue, SRD_HIGH_FIRST))?;
    dialogue.send(&slave_diag(dialogue, SRD_HIGH_1))?;
    let request = octets(dialogue.slave.address, other, Sap::GetCfg, SRD_HIGH_1, &[]);
    let Received::Telegram(answer) = dialogue.send(&request)? else { return violated("an answer to the other master") };
    let to = answer.get(4).map(|da| da & 0x7F);
    require(to == Some(other), &format!("an answer to master {other}, not the held answer to master {own}"))
}
