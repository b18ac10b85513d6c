//! Layer 2: who is answered, and what counts as a repetition. profibus-wire 1.7 to 1.11.

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
        rule: "everybody's requests, its own address and 127 as a source are not answered",
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
        rule: "a service access point that is not there answers RS",
        section: "1.8",
        run: closed,
    },
    Check {
        name: "layer2.sd3",
        rule: "a telegram with exactly eight octets of data may come as SD3",
        section: "1.2",
        run: sd3,
    },
    Check {
        name: "layer2.repetition",
        rule: "a repeated request gets the same answer once more",
        section: "1.9",
        run: repetition,
    },
    Check {
        name: "layer2.one-count",
        rule: "one frame count for all services of a master",
        section: "1.9",
        run: one_count,
    },
    Check {
        name: "layer2.other-master",
        rule: "a request of another master is new, whatever its frame count bit",
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

fn slave_diag(talk: &Dialogue<'_>, fc: u8) -> Vec<u8> {
    octets(talk.slave.address, talk.own_address(), Sap::SlaveDiag, fc, &[])
}

/// The answer of a slave with the address `slave` to FDL status of `us`.
fn is_there(slave: u8, us: u8) -> Received {
    Received::Telegram(octets(us, slave, Sap::Default, 0x00, &[]))
}

fn fdl_status(talk: &mut Dialogue<'_>) -> CheckOutcome {
    let came = talk.send(&fdl_status_telegram(talk.slave.address, talk.own_address()))?;
    require(came == is_there(talk.slave.address, talk.own_address()), "SD1 with FC 00")
}

fn damaged(talk: &mut Dialogue<'_>) -> CheckOutcome {
    for whole in [fdl_status_telegram(talk.slave.address, talk.own_address()), slave_diag(talk, SRD_HIGH_FIRST)] {
        for place in 0..whole.len() {
            let mut altered = whole.clone();
            altered.get_mut(place).into_iter().for_each(|octet| *octet ^= 0x04);
            talk.expect_silence(&altered, &format!("octet {place} is altered"))?;
        }
    }
    Ok(())
}

fn cut_off(talk: &mut Dialogue<'_>) -> CheckOutcome {
    let whole = slave_diag(talk, SRD_HIGH_FIRST);
    for length in [1, 3, 6, whole.len().saturating_sub(1)] {
        talk.expect_silence(whole.get(..length).unwrap_or_default(), &format!("only {length} octets came"))?;
        fdl_status(talk)?;
    }
    Ok(())
}

fn not_for_it(talk: &mut Dialogue<'_>) -> CheckOutcome {
    let (slave, us) = (talk.slave.address, talk.own_address());
    talk.expect_silence(&fdl_status_telegram(BROADCAST, us), "nobody answers a request to everybody")?;
    talk.expect_silence(
        &octets(BROADCAST, us, Sap::SlaveDiag, SRD_HIGH_FIRST, &[]),
        "nobody answers a request to everybody",
    )?;
    talk.expect_silence(&fdl_status_telegram(slave, slave), "the source is the slave itself")?;
    talk.expect_silence(&fdl_status_telegram(slave, BROADCAST), "no station has the address 127")
}

fn no_request(talk: &mut Dialogue<'_>) -> CheckOutcome {
    let (slave, us) = (talk.slave.address, talk.own_address());
    talk.expect_silence(&[0xDC, slave, us], "a slave takes no token")?;
    talk.expect_silence(&[0xE5], "nobody was asked")?;
    talk.expect_silence(&octets(slave, us, Sap::SlaveDiag, 0x08, &[0; 6]), "a response is no request")
}

fn closed(talk: &mut Dialogue<'_>) -> CheckOutcome {
    talk.expect_closed(Sap::Other(63), &[], "RS: there is no access point 63")
}

/// Chk_Cfg while it is not expected: whatever it says, it is answered.
fn sd3(talk: &mut Dialogue<'_>) -> CheckOutcome {
    talk.release()?;
    let (slave, us) = (talk.slave.address, talk.own_address());
    let body = [slave | 0x80, us | 0x80, SRD_HIGH_FIRST, 62, 62, 0, 0, 0, 0, 0, 0];
    let sum = body.iter().fold(0_u8, |sum, octet| sum.wrapping_add(*octet));
    let telegram: Vec<_> = [0xA2].into_iter().chain(body).chain([sum, 0x16]).collect();
    let came = talk.send(&telegram)?;
    require(matches!(came, Received::Telegram(_)), "an answer")
}

fn repetition(talk: &mut Dialogue<'_>) -> CheckOutcome {
    let first = slave_diag(talk, SRD_HIGH_FIRST);
    require(matches!(talk.send(&first)?, Received::Telegram(_)), "a diagnosis")?;
    let counted = slave_diag(talk, SRD_HIGH_0);
    let answer = talk.send(&counted)?;
    require(matches!(answer, Received::Telegram(_)), "a diagnosis")?;
    let again = talk.send(&counted)?;
    require(answer == again, "the same octets once more")
}

fn one_count(talk: &mut Dialogue<'_>) -> CheckOutcome {
    for sap in [Sap::SlaveDiag, Sap::GetCfg, Sap::GetCfg, Sap::SlaveDiag] {
        let answer = talk.request(sap, &[])?;
        require(matches!(&answer, Answer::Frame { du, .. } if !du.is_empty()), "an answer with data")?;
    }
    Ok(())
}

fn other_master(talk: &mut Dialogue<'_>) -> CheckOutcome {
    let (us, other) = (talk.own_address(), talk.other_master_address());
    talk.send(&slave_diag(talk, SRD_HIGH_FIRST))?;
    talk.send(&slave_diag(talk, SRD_HIGH_1))?;
    let asked = octets(talk.slave.address, other, Sap::GetCfg, SRD_HIGH_1, &[]);
    let Received::Telegram(came) = talk.send(&asked)? else { return violated("an answer to the other master") };
    let to = came.get(4).map(|da| da & 0x7F);
    require(to == Some(other), &format!("an answer to master {other}, not the held answer to master {us}"))
}
