//! Random damage does not change the state of a slave (profibus-wire 1.8).

use super::Check;
use crate::dialogue::{CheckOutcome, Dialogue, SRD_HIGH_FIRST, Step, octets};
use crate::expected::Unanswered;
use profivac_wire::Sap;

/// The rules about each kind of damage.
const DAMAGE: &[&str] = &[
    "damage.start-delimiter",
    "damage.length",
    "damage.second-start",
    "damage.check-octet",
    "damage.end-delimiter",
    "damage.next",
];

pub const CHECKS: &[Check] = &[
    Check::new("noise.silence", "1.8", "telegrams with a random altered bit are not answered", silence).after(DAMAGE),
    Check::new("noise.state", "1.8", "telegrams with a random altered bit do not end data exchange", state)
        .after(&["noise.silence", "watchdog.off"]),
];

/// Every run sends the same telegrams.
const SEED: u64 = 1;

const TELEGRAMS: usize = 60;

fn silence(dialogue: &mut Dialogue<'_>) -> CheckOutcome {
    dialogue.release()?;
    let mut random = fastrand::Rng::with_seed(SEED);
    for _ in 0..TELEGRAMS {
        let damaged = damaged_telegram(dialogue, &mut random);
        dialogue.send_unanswered(&damaged, Unanswered::Damaged).tested()?;
    }
    Ok(())
}

fn state(dialogue: &mut Dialogue<'_>) -> CheckOutcome {
    dialogue.start().prepared()?;
    let mut random = fastrand::Rng::with_seed(SEED);
    for _ in 0..TELEGRAMS {
        let damaged = damaged_telegram(dialogue, &mut random);
        dialogue.send(&damaged)?;
    }
    dialogue.expect_exchange().tested()
}

/// A telegram with one altered bit that would change the state of the slave if the slave accepted it.
fn damaged_telegram(dialogue: &Dialogue<'_>, random: &mut fastrand::Rng) -> Vec<u8> {
    let sap = random.choice([Sap::SetPrm, Sap::ChkCfg, Sap::Default, Sap::SetSlaveAdd]).unwrap_or(Sap::SetPrm);
    let du: Vec<_> = (0..random.usize(1..24)).map(|_| random.u8(..)).collect();
    let mut telegram = octets(dialogue.slave.address, dialogue.own_address(), sap, SRD_HIGH_FIRST, &du);
    // The check octet, the length octets or the delimiters show every single altered bit.
    let index = random.usize(..telegram.len());
    telegram.get_mut(index).into_iter().for_each(|octet| *octet ^= 1 << random.u8(..8));
    telegram
}
