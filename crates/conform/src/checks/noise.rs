//! Whatever comes, a slave stays what it was. profibus-wire 1.8.

use super::Check;
use crate::dialogue::{CheckOutcome, Dialogue, octets, require};
use profivac_wire::Sap;

pub const CHECKS: &[Check] = &[Check {
    name: "noise.damaged-telegrams",
    rule: "damaged telegrams of every kind are not answered and change nothing",
    section: "1.8",
    run: damaged_telegrams,
}];

/// The same noise for everybody.
const SEED: u64 = 1;

const TELEGRAMS: usize = 60;

fn damaged_telegrams(talk: &mut Dialogue<'_>) -> CheckOutcome {
    talk.start([0, 0])?;
    let before = talk.diagnosis()?;
    let mut random = fastrand::Rng::with_seed(SEED);
    for _ in 0..TELEGRAMS {
        let damaged = damaged_telegram(talk, &mut random);
        talk.expect_silence(&damaged, "the telegram is damaged")?;
    }
    require(talk.diagnosis()? == before, "the diagnosis as it was before")?;
    talk.exchange()?;
    talk.release()
}

/// A telegram that would change something if it was taken, with one altered bit.
fn damaged_telegram(talk: &Dialogue<'_>, random: &mut fastrand::Rng) -> Vec<u8> {
    let sap = random.choice([Sap::SetPrm, Sap::ChkCfg, Sap::Default, Sap::SetSlaveAdd]).unwrap_or(Sap::SetPrm);
    let du: Vec<_> = (0..random.usize(1..24)).map(|_| random.u8(..)).collect();
    let mut telegram = octets(talk.slave.address, talk.own_address(), sap, 0x6D, &du);
    // One bit alone is always noticed: by the sum, the lengths or the delimiters.
    let place = random.usize(..telegram.len());
    telegram.get_mut(place).into_iter().for_each(|octet| *octet ^= 1 << random.u8(..8));
    telegram
}
