//! Layer 2: damaged telegrams are discarded without an answer (profibus-wire 1.7 and 1.8).

use super::Check;
use super::contact::{fdl_status, fdl_status_telegram};
use crate::dialogue::{CheckOutcome, Dialogue, SRD_HIGH_FIRST, Step, octets};
use crate::expected::Unanswered;
use profivac_wire::Sap;

pub const CHECKS: &[Check] = &[
    Check::new("damage.start-delimiter", "1.8", "an unknown first octet begins no telegram", start_delimiter),
    Check::new("damage.length", "1.8", "a telegram with LE unlike LEr is not answered", length),
    Check::new("damage.second-start", "1.8", "SD2 without the second 68 is not answered", second_start),
    Check::new("damage.check-octet", "1.8", "a telegram with a wrong check octet is not answered", check_octet),
    Check::new("damage.end-delimiter", "1.8", "a telegram with a wrong end delimiter is not answered", end_delimiter),
    Check::new("damage.cut-off", "1.7", "a telegram that ends early is not answered", cut_off),
    Check::new("damage.next", "1.7", "after a telegram that ended early the next one is answered", next)
        .after(&["layer2.fdl-status"]),
];

/// The bit that the checks alter.
const BIT: u8 = 0x04;

/// The places of LE and LEr in SD2.
const LENGTHS: [usize; 2] = [1, 2];

/// The place of the second 68 in SD2.
const SECOND_START: usize = 3;

/// The octets behind the body: check octet and end delimiter.
const TRAILER: usize = 2;

fn sd1(dialogue: &Dialogue<'_>) -> Vec<u8> {
    fdl_status_telegram(dialogue.slave.address, dialogue.own_address())
}

fn sd2(dialogue: &Dialogue<'_>) -> Vec<u8> {
    octets(dialogue.slave.address, dialogue.own_address(), Sap::SlaveDiag, SRD_HIGH_FIRST, &[])
}

/// Sends `telegram` with one altered octet, which the slave may not answer.
fn altered(dialogue: &mut Dialogue<'_>, mut telegram: Vec<u8>, index: usize) -> CheckOutcome {
    telegram.get_mut(index).into_iter().for_each(|octet| *octet ^= BIT);
    dialogue.send_unanswered(&telegram, Unanswered::Altered(index)).tested()
}

fn start_delimiter(dialogue: &mut Dialogue<'_>) -> CheckOutcome {
    altered(dialogue, sd1(dialogue), 0)?;
    altered(dialogue, sd2(dialogue), 0)
}

fn length(dialogue: &mut Dialogue<'_>) -> CheckOutcome {
    LENGTHS.into_iter().try_for_each(|index| altered(dialogue, sd2(dialogue), index))
}

fn second_start(dialogue: &mut Dialogue<'_>) -> CheckOutcome {
    altered(dialogue, sd2(dialogue), SECOND_START)
}

/// Each octet of the body in turn, then the check octet itself.
fn check_octet(dialogue: &mut Dialogue<'_>) -> CheckOutcome {
    for (telegram, first) in [(sd1(dialogue), 1), (sd2(dialogue), SECOND_START + 1)] {
        let end = telegram.len().saturating_sub(TRAILER);
        (first..=end).try_for_each(|index| altered(dialogue, telegram.clone(), index))?;
    }
    Ok(())
}

fn end_delimiter(dialogue: &mut Dialogue<'_>) -> CheckOutcome {
    for telegram in [sd1(dialogue), sd2(dialogue)] {
        let last = telegram.len().saturating_sub(1);
        altered(dialogue, telegram, last)?;
    }
    Ok(())
}

/// The beginnings of a telegram that are sent.
fn beginnings(dialogue: &Dialogue<'_>) -> Vec<Vec<u8>> {
    let complete = sd2(dialogue);
    let lengths = [1, 3, 6, complete.len().saturating_sub(1)];
    lengths.into_iter().map(|length| complete.iter().take(length).copied().collect()).collect()
}

fn cut_off(dialogue: &mut Dialogue<'_>) -> CheckOutcome {
    for beginning in beginnings(dialogue) {
        dialogue.send_unanswered(&beginning, Unanswered::CutOff(beginning.len())).tested()?;
    }
    Ok(())
}

fn next(dialogue: &mut Dialogue<'_>) -> CheckOutcome {
    for beginning in beginnings(dialogue) {
        dialogue.send(&beginning)?;
        fdl_status(dialogue).tested()?;
    }
    Ok(())
}
