//! Damaged telegrams leave the state of a slave unchanged (profibus-wire 1.8).

use super::Check;
use crate::dialogue::{CheckOutcome, Dialogue, octets, require};
use profivac_wire::Sap;

pub const CHECKS: &[Check] = &[Check {
    name: "noise.damaged-telegrams",
    rule: "damaged telegrams of every kind are not answered and change nothing",
    section: "1.8",
    run: damaged_telegrams,
}];

/// Every run sends the same telegrams.
const SEED: u64 = 1;

const TELEGRAMS: usize = 60;

fn damaged_telegrams(dialogue: &mut Dialogue<'_>) -> CheckOutcome {
    dialogue.start([0, 0])?;
    let before = dialogue.diagnosis()?;
    let mut random = fastrand::Rng::with_seed(SEED);
    for _ in 0..TELEGRAMS {
        let damaged = damaged_telegram(dialogue, &mut random);
        dialogue.expect_silence(&damaged, "the telegram is damaged")?;
    }
    require(dialogue.diagnosis()? == before, "the same diagnosis as before")?;
    dialogue.exchange()?;
    dialogue.release()
}

/// A telegram with one altered bit that would change the state of the slave if the slave accepted it.
fn damaged_telegram(dialogue: &Dialogue<'_>, random: &mut fastrand::Rng) -> Vec<u8> {
    let sap = random.choice([Sap::SetPrm, Sap::ChkCfg, Sap::Default, Sap::SetSlaveAdd]).unwrap_or(Sap::SetPrm);
    let du: Vec<_> = (0..random.usize(1..24)).map(|_| random.u8(..)).collect();
    let mut telegram = octets(dialogue.slave.address, dialogue.own_address(), sap, 0x6D, &du);
    // The check octet, the length octets or the delimiters show every single altered bit.
    let place = random.usize(..telegram.len());
    telegram.get_mut(place).into_iter().for_each(|octet| *octet ^= 1 << random.u8(..8));
    telegram
}
