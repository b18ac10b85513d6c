//! Data exchange, the images and Global_Control (profibus-wire 2.8 to 2.11). The outputs are zero, like those of a master in
//! Clear.

use super::Check;
use super::contact;
use crate::dialogue::{Answer, CheckError, CheckOutcome, Dialogue, Step, StepError, global_control, require, without};
use crate::expected::{Closed, Expected, Reason, Service, Unanswered};
use profivac_wire::control::Status;
use profivac_wire::diag::StationStatus;
use profivac_wire::global::ControlCommand;
use profivac_wire::prm::{PrmStatus, SetPrm};
use profivac_wire::{BROADCAST, Sap};

const EXCHANGE: &[&str] = &["start-up.exchange"];
const CLOSED: &[&str] = &["start-up.unlock", "layer2.closed"];
const SYNC: &[&str] = &["control.sync"];

pub const CHECKS: &[Check] = &[
    Check::new("exchange.inputs", "2.8", "Data_Exchange returns the number of inputs of the configuration", inputs)
        .after(EXCHANGE),
    Check::new(
        "exchange.wrong-length",
        "2.8",
        "outputs of another length are refused or end data exchange",
        wrong_length,
    )
    .after(EXCHANGE),
    Check::new(
        "exchange.diagnosis-flag",
        "3.3",
        "a diagnosis that the owner has read is not announced",
        diagnosis_flag,
    )
    .after(&["start-up.exchange", "diagnosis.answer"]),
    Check::new("exchange.fdl-status", "1.11", "FDL status is answered during data exchange", fdl_status)
        .after(&["start-up.exchange", "layer2.fdl-status"]),
    Check::new("exchange.undisturbed", "3.2", "Slave_Diag and Get_Cfg do not end data exchange", undisturbed)
        .after(EXCHANGE),
    Check::new("exchange.set-slave-add", "2.11", "Set_Slave_Add is closed during data exchange", set_slave_add)
        .after(&["start-up.exchange", "layer2.closed"]),
    Check::new("read.inputs-closed", "2.2", "RD_Inp is closed outside data exchange", inputs_closed).after(CLOSED),
    Check::new("read.outputs-closed", "2.2", "RD_Outp is closed outside data exchange", outputs_closed)
        .after(CLOSED)
        .unless_broken(&["read.inputs-closed"]),
    Check::new("read.inputs", "2.10", "RD_Inp returns the number of inputs of the configuration", read_inputs)
        .after(EXCHANGE),
    Check::new("read.inputs-image", "2.10", "RD_Inp returns the inputs of Data_Exchange", inputs_image)
        .after(&["read.inputs", "exchange.inputs"]),
    Check::new("read.inputs-any-master", "2.10", "any master can read the inputs", inputs_any_master)
        .after(&["read.inputs"])
        .unless_broken(&["diagnosis.any-master"]),
    Check::new("read.outputs", "2.10", "RD_Outp returns the number of outputs of the configuration", read_outputs)
        .after(EXCHANGE),
    Check::new("read.outputs-image", "2.10", "RD_Outp returns the outputs of Data_Exchange", outputs_image)
        .after(&["read.outputs"]),
    Check::new("control.broadcast", "2.9", "Global_Control to all slaves is not answered", control_broadcast)
        .after(EXCHANGE)
        .unless_broken(&["layer2.broadcast", "layer2.other-station"]),
    Check::new("control.single", "2.9", "Global_Control to one slave is not answered", control_single)
        .after(EXCHANGE)
        .unless_broken(&["control.broadcast"]),
    Check::new("control.clear", "3.2", "Clear_Data does not end data exchange", control_clear).after(EXCHANGE),
    Check::new("control.sync", "2.9", "Sync is Sync_Mode in the diagnosis", sync)
        .after(&["start-up.exchange", "diagnosis.answer"]),
    Check::new("control.unsync", "2.9", "Unsync ends Sync_Mode", unsync).after(SYNC),
    Check::new("control.owner", "2.9", "Global_Control of another master is ignored", control_owner)
        .after(SYNC)
        .unless_broken(&["lock.set-prm"]),
    Check::new("control.group", "2.9", "Global_Control to another group is ignored", control_group).after(SYNC),
    Check::new("control.freeze", "2.9", "Freeze is Freeze_Mode in the diagnosis", freeze)
        .after(&["start-up.exchange", "diagnosis.answer"])
        .unless_broken(&["control.sync"]),
    Check::new("control.unfreeze", "2.9", "Unfreeze ends Freeze_Mode", unfreeze).after(&["control.freeze"]),
];

fn inputs(dialogue: &mut Dialogue<'_>) -> CheckOutcome {
    dialogue.start().prepared()?;
    for _ in 0..4 {
        dialogue.inputs().tested()?;
    }
    Ok(())
}

fn wrong_length(dialogue: &mut Dialogue<'_>) -> CheckOutcome {
    dialogue.start().prepared()?;
    let longer: Vec<_> = dialogue.outputs().into_iter().chain([0]).collect();
    let refused = |answer: &Answer| answer.status == Status::NoResource;
    match dialogue.request(Sap::Default, &longer) {
        Ok(answer) if refused(&answer) => Ok(()),
        Ok(_) | Err(StepError::Unexpected(_)) => dialogue.expect_no_exchange().tested(),
        Err(StepError::Port(error)) => Err(error.into()),
    }
}

fn diagnosis_flag(dialogue: &mut Dialogue<'_>) -> CheckOutcome {
    dialogue.start().prepared()?;
    dialogue.diagnosis().prepared()?;
    let outputs = dialogue.outputs();
    let answer = dialogue.request(Sap::Default, &outputs).prepared()?;
    let announced = answer.status == Status::DataHigh;
    let cycle = dialogue.take_last();
    // Static diagnosis stays announced after it was read.
    let is_static = announced && dialogue.diagnosis().prepared()?.status.contains(StationStatus::STAT_DIAG);
    dialogue.show(cycle);
    require(!announced || is_static, Expected::NotAnnounced).tested()
}

fn fdl_status(dialogue: &mut Dialogue<'_>) -> CheckOutcome {
    dialogue.start().prepared()?;
    contact::fdl_status(dialogue).tested()
}

fn undisturbed(dialogue: &mut Dialogue<'_>) -> CheckOutcome {
    dialogue.start().prepared()?;
    for sa in [dialogue.own_address(), dialogue.other_master_address()] {
        for sap in [Sap::SlaveDiag, Sap::GetCfg] {
            dialogue.tell_from(sa, sap, &[])?;
        }
    }
    dialogue.expect_exchange().tested()
}

/// The request has the present address and another ident number, so that it changes nothing if the slave executes it.
fn set_slave_add(dialogue: &mut Dialogue<'_>) -> CheckOutcome {
    dialogue.start().prepared()?;
    let [high, low] = (dialogue.slave.ident ^ 0x0101).to_be_bytes();
    let du = [dialogue.slave.address, high, low, 0];
    dialogue.expect_closed(dialogue.own_address(), Sap::SetSlaveAdd, &du, Closed::Exchanging).tested()
}

fn inputs_closed(dialogue: &mut Dialogue<'_>) -> CheckOutcome {
    dialogue.release()?;
    dialogue.expect_closed(dialogue.own_address(), Sap::RdInp, &[], Closed::NotExchanging).tested()
}

fn outputs_closed(dialogue: &mut Dialogue<'_>) -> CheckOutcome {
    dialogue.release()?;
    dialogue.expect_closed(dialogue.own_address(), Sap::RdOutp, &[], Closed::NotExchanging).tested()
}

/// Reads an image during data exchange. A slave without the service refuses the request.
fn image(dialogue: &mut Dialogue<'_>, sap: Sap, service: Service) -> CheckOutcome<Answer> {
    match dialogue.request(sap, &[]) {
        Ok(answer) if answer.is_closed() => without(service),
        Ok(answer) => Ok(answer),
        Err(error) => Err(error).prepared(),
    }
}

/// Requires an image of `length` octets; SC if it is empty.
fn require_image(answer: &Answer, length: u8) -> CheckOutcome {
    let length = usize::from(length);
    let has_status = if length == 0 { answer.is_acknowledgement() } else { answer.has_data_status() };
    require(has_status && answer.du.len() == length, Expected::Octets(length)).tested()
}

fn read_inputs(dialogue: &mut Dialogue<'_>) -> CheckOutcome {
    dialogue.start().prepared()?;
    let answer = image(dialogue, Sap::RdInp, Service::RdInp)?;
    require_image(&answer, dialogue.lengths().inputs)
}

fn inputs_image(dialogue: &mut Dialogue<'_>) -> CheckOutcome {
    dialogue.start().prepared()?;
    let before = dialogue.inputs().prepared()?;
    let answer = image(dialogue, Sap::RdInp, Service::RdInp)?;
    let cycle = dialogue.take_last();
    if dialogue.inputs().prepared()? != before {
        return Err(CheckError::NotTested(Reason::InputsChange));
    }
    dialogue.show(cycle);
    require(answer.du == before, Expected::Image(before)).tested()
}

fn inputs_any_master(dialogue: &mut Dialogue<'_>) -> CheckOutcome {
    dialogue.start().prepared()?;
    let answer = dialogue.request_from(dialogue.other_master_address(), Sap::RdInp, &[]).tested()?;
    require_image(&answer, dialogue.lengths().inputs)
}

fn read_outputs(dialogue: &mut Dialogue<'_>) -> CheckOutcome {
    dialogue.start().prepared()?;
    let answer = image(dialogue, Sap::RdOutp, Service::RdOutp)?;
    require_image(&answer, dialogue.lengths().outputs)
}

fn outputs_image(dialogue: &mut Dialogue<'_>) -> CheckOutcome {
    dialogue.start().prepared()?;
    let answer = image(dialogue, Sap::RdOutp, Service::RdOutp)?;
    let outputs = dialogue.outputs();
    require(answer.du == outputs, Expected::Image(outputs)).tested()
}

/// Group_Select of all slaves.
const ALL_GROUPS: u8 = 0;

/// The group of the slave in the checks of groups, and another one.
const OWN_GROUP: u8 = 0x01;
const OTHER_GROUP: u8 = 0x02;

fn control(dialogue: &mut Dialogue<'_>, sa: u8, command: ControlCommand, group: u8) -> CheckOutcome {
    dialogue.send(&global_control(BROADCAST, sa, command, group))?;
    Ok(())
}

fn control_broadcast(dialogue: &mut Dialogue<'_>) -> CheckOutcome {
    dialogue.start().prepared()?;
    let command = global_control(BROADCAST, dialogue.own_address(), ControlCommand::CLEAR_DATA, ALL_GROUPS);
    dialogue.send_unanswered(&command, Unanswered::Unconfirmed).tested()
}

fn control_single(dialogue: &mut Dialogue<'_>) -> CheckOutcome {
    dialogue.start().prepared()?;
    let (da, sa) = (dialogue.slave.address, dialogue.own_address());
    let command = global_control(da, sa, ControlCommand::CLEAR_DATA, ALL_GROUPS);
    dialogue.send_unanswered(&command, Unanswered::Unconfirmed).tested()
}

fn control_clear(dialogue: &mut Dialogue<'_>) -> CheckOutcome {
    dialogue.start().prepared()?;
    control(dialogue, dialogue.own_address(), ControlCommand::CLEAR_DATA, ALL_GROUPS)?;
    dialogue.expect_exchange().tested()
}

/// Starts data exchange with a feature of Global_Control, in the group of the checks.
pub(super) fn start_with(dialogue: &mut Dialogue<'_>, feature: PrmStatus, service: Service) -> CheckOutcome {
    let prm = dialogue.prm([0, 0]);
    dialogue.start_with(&SetPrm { status: prm.status | feature, group: OWN_GROUP, ..prm }).prepared()?;
    let status = dialogue.diagnosis().prepared()?.status;
    if status.contains(StationStatus::NOT_SUPPORTED) { without(service) } else { Ok(()) }
}

fn sync(dialogue: &mut Dialogue<'_>) -> CheckOutcome {
    start_with(dialogue, PrmStatus::SYNC_REQ, Service::Sync)?;
    control(dialogue, dialogue.own_address(), ControlCommand::SYNC, ALL_GROUPS)?;
    dialogue.diagnosis().prepared()?.require_set(StationStatus::SYNC_MODE).tested()
}

fn unsync(dialogue: &mut Dialogue<'_>) -> CheckOutcome {
    start_with(dialogue, PrmStatus::SYNC_REQ, Service::Sync)?;
    control(dialogue, dialogue.own_address(), ControlCommand::SYNC, ALL_GROUPS)?;
    control(dialogue, dialogue.own_address(), ControlCommand::UNSYNC, ALL_GROUPS)?;
    dialogue.diagnosis().prepared()?.require_clear(StationStatus::SYNC_MODE).tested()
}

fn control_owner(dialogue: &mut Dialogue<'_>) -> CheckOutcome {
    start_with(dialogue, PrmStatus::SYNC_REQ, Service::Sync)?;
    control(dialogue, dialogue.other_master_address(), ControlCommand::SYNC, ALL_GROUPS)?;
    dialogue.diagnosis().prepared()?.require_clear(StationStatus::SYNC_MODE).tested()
}

fn control_group(dialogue: &mut Dialogue<'_>) -> CheckOutcome {
    start_with(dialogue, PrmStatus::SYNC_REQ, Service::Sync)?;
    control(dialogue, dialogue.own_address(), ControlCommand::SYNC, OTHER_GROUP)?;
    dialogue.diagnosis().prepared()?.require_clear(StationStatus::SYNC_MODE).tested()
}

fn freeze(dialogue: &mut Dialogue<'_>) -> CheckOutcome {
    start_with(dialogue, PrmStatus::FREEZE_REQ, Service::Freeze)?;
    control(dialogue, dialogue.own_address(), ControlCommand::FREEZE, ALL_GROUPS)?;
    dialogue.diagnosis().prepared()?.require_set(StationStatus::FREEZE_MODE).tested()
}

fn unfreeze(dialogue: &mut Dialogue<'_>) -> CheckOutcome {
    start_with(dialogue, PrmStatus::FREEZE_REQ, Service::Freeze)?;
    control(dialogue, dialogue.own_address(), ControlCommand::FREEZE, ALL_GROUPS)?;
    control(dialogue, dialogue.own_address(), ControlCommand::UNFREEZE, ALL_GROUPS)?;
    dialogue.diagnosis().prepared()?.require_clear(StationStatus::FREEZE_MODE).tested()
}
