//! Frame count bits (profibus-wire 1.9). Each check sends requests whose effect or answer shows whether the slave executed
//! them, with frame count bits of its own. A repetition carries other data than the request that it seems to repeat: the slave
//! may look at its source and its bit only.

use super::contact::fdl_status_telegram;
use super::{Check, NO_SERVICE};
use crate::dialogue::{
    self, CheckOutcome, Dialogue, Step, StepError, parse_answer, require, require_same, set_prm_octets,
};
use crate::expected::{Expected, Unanswered};
use crate::probe::Received;
use profivac_wire::control::FrameCount::{Counted, First, Uncounted};
use profivac_wire::diag::SlaveDiag;
use profivac_wire::global::ControlCommand;
use profivac_wire::{BROADCAST, Sap, Telegram};

const NEW: &str = "count.new";
const REPETITION: &str = "count.repetition";
const ANSWER: &str = "count.answer";

pub const CHECKS: &[Check] = &[
    Check::new(NEW, "1.9", "a request with the other frame count bit is executed", new)
        .after(&["diagnosis.answer", super::FIRST_REQUEST]),
    Check::new("count.uncounted", "1.9", "a request without a frame count bit is executed", uncounted)
        .after(&["diagnosis.answer", super::FIRST_REQUEST]),
    Check::new("count.station", "1.9", "all services share one frame count bit", station)
        .after(&[NEW, "start-up.owner"]),
    Check::new(REPETITION, "1.9", "a request with the same frame count bit is not executed", repetition).after(&[
        NEW,
        "start-up.owner",
        "start-up.no-owner",
    ]),
    Check::new(ANSWER, "1.9", "a repetition gets the answer once more", answer).after(&[
        REPETITION,
        "count.station",
        "get-cfg.identifiers",
    ]),
    Check::new("count.refusal", "1.9", "RS is an answer that a repetition gets once more", refusal)
        .after(&[ANSWER, "layer2.closed"]),
    Check::new("count.exchange", "1.9", "a repetition of Data_Exchange is not executed", exchange).after(&[
        REPETITION,
        "exchange.wrong-length",
        "exchange.inputs",
    ]),
    Check::new("count.other-master", "1.9", "a request of another master is executed, whatever its bit", other_master)
        .after(&[NEW, "layer2.addresses"])
        .unless_broken(&["diagnosis.any-master", "get-cfg.any-master"]),
    Check::new("count.fdl-status", "1.9", "FDL status does not change the remembered bit", fdl_status).after(&[NEW]),
    Check::new("count.global-control", "1.9", "Global_Control does not change the remembered bit", global_control)
        .after(&[NEW])
        .unless_broken(&["count.fdl-status"]),
    Check::new("count.damaged", "1.9", "a damaged telegram does not change the remembered bit", damaged)
        .after(&[NEW, "damage.check-octet"]),
];

/// Requires a valid answer that is not `before`.
fn require_new(received: &Received, before: &Received) -> CheckOutcome {
    parse_answer(received).tested()?;
    require(received != before, Expected::NewAnswer).tested()
}

/// An answer, without which a repetition cannot be tested.
fn answered(received: Received) -> CheckOutcome<Received> {
    parse_answer(&received).prepared()?;
    Ok(received)
}

/// Diag_Master_Add of a diagnosis.
fn master_add(received: &Received) -> CheckOutcome<u8> {
    let answer = parse_answer(received).prepared()?;
    let diagnosis = SlaveDiag::parse(&answer.du).map_err(|_| StepError::Unexpected(Expected::Diagnosis)).prepared()?;
    Ok(diagnosis.master_add)
}

fn new(dialogue: &mut Dialogue<'_>) -> CheckOutcome {
    let mut before = dialogue.counted(First, Sap::SlaveDiag, &[])?;
    for (count, sap) in [(false, Sap::GetCfg), (true, Sap::SlaveDiag), (false, Sap::GetCfg)] {
        let received = dialogue.counted(Counted(count), sap, &[])?;
        require_new(&received, &before)?;
        before = received;
    }
    Ok(())
}

fn uncounted(dialogue: &mut Dialogue<'_>) -> CheckOutcome {
    dialogue.counted(First, Sap::SlaveDiag, &[])?;
    let before = dialogue.counted(Counted(false), Sap::SlaveDiag, &[])?;
    // Its bit is 0 too.
    let received = dialogue.counted(Uncounted, Sap::GetCfg, &[])?;
    require_new(&received, &before)
}

/// Between the two requests for the diagnosis, which have the same bit, Set_Prm has the other one. A slave with a memory for
/// each access point sends the old diagnosis.
fn station(dialogue: &mut Dialogue<'_>) -> CheckOutcome {
    let own = dialogue.own_address();
    dialogue.counted(First, Sap::SetPrm, &set_prm_octets(&dialogue.unlock_prm()))?;
    dialogue.counted(Counted(false), Sap::SlaveDiag, &[])?;
    dialogue.counted(Counted(true), Sap::SetPrm, &set_prm_octets(&dialogue.prm([0, 0])))?;
    let diagnosis = dialogue.counted(Counted(false), Sap::SlaveDiag, &[])?;
    require(master_add(&diagnosis)? == own, Expected::MasterAdd(own)).tested()
}

/// The repetition of the Set_Prm that locks the slave carries the one that releases it.
fn repetition(dialogue: &mut Dialogue<'_>) -> CheckOutcome {
    let own = dialogue.own_address();
    dialogue.counted(First, Sap::SetPrm, &set_prm_octets(&dialogue.unlock_prm()))?;
    dialogue.counted(Counted(false), Sap::SetPrm, &set_prm_octets(&dialogue.prm([0, 0])))?;
    dialogue.counted(Counted(false), Sap::SetPrm, &set_prm_octets(&dialogue.unlock_prm()))?;
    let diagnosis = dialogue.counted(Counted(true), Sap::SlaveDiag, &[])?;
    require(master_add(&diagnosis)? == own, Expected::MasterAdd(own)).tested()
}

/// The repetition of Get_Cfg requests the diagnosis.
fn answer(dialogue: &mut Dialogue<'_>) -> CheckOutcome {
    dialogue.counted(First, Sap::SlaveDiag, &[])?;
    let before = answered(dialogue.counted(Counted(false), Sap::GetCfg, &[])?)?;
    let received = dialogue.counted(Counted(false), Sap::SlaveDiag, &[])?;
    require_same(received, before).tested()
}

fn refusal(dialogue: &mut Dialogue<'_>) -> CheckOutcome {
    dialogue.counted(First, Sap::SlaveDiag, &[])?;
    let before = answered(dialogue.counted(Counted(false), Sap::Other(NO_SERVICE), &[])?)?;
    let received = dialogue.counted(Counted(false), Sap::SlaveDiag, &[])?;
    require_same(received, before).tested()
}

/// The repetition has outputs of another length: a slave that executes it refuses it or leaves data exchange. So the outputs
/// stay zero.
fn exchange(dialogue: &mut Dialogue<'_>) -> CheckOutcome {
    dialogue.start().prepared()?;
    let outputs = dialogue.outputs();
    let longer: Vec<_> = outputs.iter().copied().chain([0]).collect();
    dialogue.counted(First, Sap::SlaveDiag, &[])?;
    let before = answered(dialogue.counted(Counted(false), Sap::Default, &outputs)?)?;
    let received = dialogue.counted(Counted(false), Sap::Default, &longer)?;
    require_same(received, before).tested()?;
    dialogue.expect_exchange().tested()
}

fn other_master(dialogue: &mut Dialogue<'_>) -> CheckOutcome {
    let other = dialogue.other_master_address();
    dialogue.counted(First, Sap::SlaveDiag, &[])?;
    dialogue.counted(Counted(false), Sap::SlaveDiag, &[])?;
    let request = dialogue.telegram(other, Sap::GetCfg, Counted(false), &[]);
    let received = dialogue.send(&request)?;
    parse_answer(&received).tested()?;
    let expected = Expected::Addresses { da: other, sa: dialogue.slave.address };
    // SC has no address.
    require(destination(&received).is_none_or(|da| da == other), expected).tested()
}

/// The destination of an answer.
fn destination(received: &Received) -> Option<u8> {
    let Received::Telegram(octets) = received else { return None };
    match Telegram::parse(octets) {
        Ok(Telegram::Data(data)) => Some(data.da),
        Ok(Telegram::ShortAck | Telegram::Token { .. }) | Err(_) => None,
    }
}

/// Sends `between`, which has FCB 0, between requests with FCB 1 and 0. A slave that remembers its bit takes the second request
/// for a repetition.
fn undisturbed_by(dialogue: &mut Dialogue<'_>, between: &[u8]) -> CheckOutcome {
    let before = dialogue.counted(First, Sap::SlaveDiag, &[])?;
    dialogue.send(between)?;
    let received = dialogue.counted(Counted(false), Sap::GetCfg, &[])?;
    require_new(&received, &before)
}

fn fdl_status(dialogue: &mut Dialogue<'_>) -> CheckOutcome {
    let between = fdl_status_telegram(dialogue.slave.address, dialogue.own_address());
    undisturbed_by(dialogue, &between)
}

fn global_control(dialogue: &mut Dialogue<'_>) -> CheckOutcome {
    let operate = ControlCommand::empty();
    let between = dialogue::global_control(BROADCAST, dialogue.own_address(), operate, 0);
    undisturbed_by(dialogue, &between)
}

/// The damaged telegram is a request with FCB 0 and a wrong check octet.
fn damaged(dialogue: &mut Dialogue<'_>) -> CheckOutcome {
    let mut between = dialogue.telegram(dialogue.own_address(), Sap::GetCfg, Counted(false), &[]);
    let check_octet = between.len().saturating_sub(2);
    between.get_mut(check_octet).into_iter().for_each(|octet| *octet ^= 0x04);
    dialogue.send_unanswered(&between, Unanswered::Altered(check_octet)).prepared()?;
    undisturbed_by(dialogue, &between)
}
