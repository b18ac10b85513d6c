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
        .after(&["start-up.exchange"])
        .unless_broken(&["lock.set-prm"]),
    Check::new("lock.exchange", "3.4", "the slave exchanges data with its owner only", exchange)
        .after(&["start-up.exchange"])
        .unless_broken(&["lock.set-prm", "lock.chk-cfg"]),
];

/// Sends a Set_Prm of another master, which the slave may acknowledge or refuse (profibus-wire 10, point 6). Runs `test`, and
/// releases the slave in case the other master owns it.
fn with_foreign_prm(dialogue: &mut Dialogue<'_>, test: impl FnOnce(&mut Dialogue<'_>) -> CheckOutcome) -> CheckOutcome {
    let other = dialogue.other_master_address();
    let [prm, unlock] = [dialogue.prm([0, 0]), dialogue.unlock_prm()].map(|prm| set_prm_octets(&prm));
    dialogue.start().prepared()?;
    dialogue.tell_from(other, Sap::SetPrm, &prm)?;
    let result = test(dialogue);
    let cycle = dialogue.take_last();
    dialogue.tell_from(other, Sap::SetPrm, &unlock)?;
    dialogue.show(cycle);
    result
}

fn set_prm(dialogue: &mut Dialogue<'_>) -> CheckOutcome {
    with_foreign_prm(dialogue, |dialogue| {
        dialogue.diagnosis().prepared()?.require_master(dialogue.own_address()).tested()
    })
}

fn undisturbed(dialogue: &mut Dialogue<'_>) -> CheckOutcome {
    with_foreign_prm(dialogue, |dialogue| dialogue.expect_exchange().tested())
}

fn chk_cfg(dialogue: &mut Dialogue<'_>) -> CheckOutcome {
    dialogue.start().prepared()?;
    let cfg = truncated_cfg(dialogue);
    dialogue.tell_from(dialogue.other_master_address(), Sap::ChkCfg, &cfg)?;
    dialogue.expect_exchange().tested()
}

fn exchange(dialogue: &mut Dialogue<'_>) -> CheckOutcome {
    dialogue.start().prepared()?;
    let exchanging = dialogue.is_exchanging_with(dialogue.other_master_address(), &dialogue.outputs())?;
    require(!exchanging, Expected::NoExchange).tested()
}
