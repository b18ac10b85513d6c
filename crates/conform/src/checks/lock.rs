//! The owner of a slave and other masters (profibus-wire 3.4).

use super::Check;
use super::start_up::truncated_cfg;
use crate::dialogue::{CheckOutcome, Dialogue, Step, require, set_prm_octets};
use crate::expected::Expected;
use profivac_wire::Sap;

pub const CHECKS: &[Check] = &[
    Check::new("lock.set-prm", "3.4", "Set_Prm of another master does not change the owner", set_prm)
        .after(&["start-up.owner", "start-up.exchange"]),
    Check::new("lock.undisturbed", "3.4", "Set_Prm of another master does not end data exchange", undisturbed)
        .after(&["start-up.exchange", "lock.set-prm"]),
    Check::new("lock.chk-cfg", "3.4", "Chk_Cfg of another master does not end data exchange", chk_cfg)
        .after(&["start-up.exchange"]),
    Check::new("lock.exchange", "3.4", "the slave exchanges data with its owner only", exchange)
        .after(&["start-up.exchange"]),
];

/// Sends a Set_Prm of another master, which the slave may acknowledge or refuse (profibus-wire 10, point 6).
fn foreign_set_prm(dialogue: &mut Dialogue<'_>) -> CheckOutcome {
    dialogue.start().prepared()?;
    let prm = set_prm_octets(&dialogue.prm([0, 0]));
    dialogue.tell_from(dialogue.other_master_address(), Sap::SetPrm, &prm)?;
    Ok(())
}

fn set_prm(dialogue: &mut Dialogue<'_>) -> CheckOutcome {
    foreign_set_prm(dialogue)?;
    dialogue.diagnosis().prepared()?.require_master(dialogue.own_address()).tested()
}

fn undisturbed(dialogue: &mut Dialogue<'_>) -> CheckOutcome {
    foreign_set_prm(dialogue)?;
    dialogue.expect_exchange().tested()
}

fn chk_cfg(dialogue: &mut Dialogue<'_>) -> CheckOutcome {
    dialogue.start().prepared()?;
    let cfg = truncated_cfg(dialogue);
    dialogue.tell_from(dialogue.other_master_address(), Sap::ChkCfg, &cfg)?;
    dialogue.expect_exchange().tested()
}

fn exchange(dialogue: &mut Dialogue<'_>) -> CheckOutcome {
    dialogue.start().prepared()?;
    let exchanging = dialogue.is_exchanging_with(dialogue.other_master_address())?;
    require(!exchanging, Expected::NoExchange).tested()
}
