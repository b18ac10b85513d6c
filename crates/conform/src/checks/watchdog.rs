//! The response watchdog (profibus-wire 3.6).

use super::Check;
use crate::dialogue::{CheckOutcome, Dialogue, Step};
use profivac_wire::diag::{NO_MASTER, StationStatus};
use std::time::Duration;

const EXCHANGE: &str = "start-up.exchange";
const EXPIRY: &str = "watchdog.expiry";

pub const CHECKS: &[Check] = &[
    Check::new("watchdog.no-bit", "2.3", "without a watchdog WD_On is 0", no_bit)
        .after(&["diagnosis.answer", EXCHANGE]),
    Check::new("watchdog.off", "3.6", "without a watchdog a pause does not end data exchange", off).after(&[EXCHANGE]),
    Check::new(EXPIRY, "3.6", "a slave without requests of its master leaves data exchange", expiry).after(&[EXCHANGE]),
    Check::new("watchdog.bit", "2.3", "a running watchdog is WD_On", bit).after(&["diagnosis.answer", EXPIRY]),
    Check::new("watchdog.no-owner", "3.2", "an expired watchdog ends the ownership", no_owner)
        .after(&[EXPIRY, "start-up.no-owner"]),
    Check::new("watchdog.restart", "3.6", "Data_Exchange restarts the watchdog", restart).after(&[EXPIRY]),
];

/// 10 x 1 x 10 ms.
const SHORT: [u8; 2] = [10, 1];

/// 40 x 1 x 10 ms.
const LONG: [u8; 2] = [40, 1];

/// Longer than the short watchdog.
const SILENCE: Duration = Duration::from_millis(500);

/// A quarter of the long watchdog.
const PERIOD: Duration = Duration::from_millis(100);

fn bit(dialogue: &mut Dialogue<'_>) -> CheckOutcome {
    dialogue.start_with(&dialogue.prm(LONG)).prepared()?;
    dialogue.diagnosis().prepared()?.require_set(StationStatus::WD_ON).tested()
}

fn no_bit(dialogue: &mut Dialogue<'_>) -> CheckOutcome {
    dialogue.start().prepared()?;
    dialogue.diagnosis().prepared()?.require_clear(StationStatus::WD_ON).tested()
}

fn off(dialogue: &mut Dialogue<'_>) -> CheckOutcome {
    dialogue.start().prepared()?;
    dialogue.wait(SILENCE)?;
    dialogue.expect_exchange().tested()
}

fn expiry(dialogue: &mut Dialogue<'_>) -> CheckOutcome {
    dialogue.start_with(&dialogue.prm(SHORT)).prepared()?;
    dialogue.wait(SILENCE)?;
    dialogue.expect_no_exchange().tested()
}

fn no_owner(dialogue: &mut Dialogue<'_>) -> CheckOutcome {
    dialogue.start_with(&dialogue.prm(SHORT)).prepared()?;
    dialogue.wait(SILENCE)?;
    dialogue.diagnosis().prepared()?.require_master(NO_MASTER).tested()
}

/// Twice the time of the watchdog.
fn restart(dialogue: &mut Dialogue<'_>) -> CheckOutcome {
    dialogue.start_with(&dialogue.prm(LONG)).prepared()?;
    for _ in 0..8 {
        dialogue.wait(PERIOD)?;
        dialogue.expect_exchange().tested()?;
    }
    Ok(())
}
