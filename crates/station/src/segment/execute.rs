//! Previews and executes an operation beside the cyclic data exchange.

use crate::control::armed_commands::ArmedCommand;
use crate::control::error::{ChangedSinceArmed, OperationError, OutcomeUnknown, Unavailable};
use crate::control::operation::{Operation, OperationPreview, Readback};
use crate::control::permissions;
use profivac_client::cyclic::CyclicSlave;
use profivac_client::records::{Records, WriteEffect};
use profivac_client::values::BeyondRange;
use profivac_client::{self, ClientError, Condition, Gauge};

/// Asks the gauge what an operation would do. Nothing is changed.
pub fn preview<R: Records>(
    slave: &CyclicSlave,
    records: R,
    operation: &Operation,
) -> Result<OperationPreview, OperationError> {
    let mut gauge = open(slave, records);
    let preview = read_preview(&mut gauge, operation).map(|(_, preview)| preview);
    // A gauge that no longer answers keeps the selector where it is.
    gauge.restore_selector().ok();
    preview
}

/// Executes an armed command, if the device, its values and its conditions are as they were.
pub fn execute<R: Records>(
    slave: &CyclicSlave,
    records: R,
    command: &ArmedCommand,
) -> Result<Readback, OperationError> {
    let armed = (command.preview.device, command.preview.address);
    let now = (slave.model.name, slave.address);
    if armed != now {
        return Err(ChangedSinceArmed::Device { gauge: command.gauge.clone(), armed, now }.into());
    }
    let mut gauge = open(slave, records);
    let readback = execute_checked(&mut gauge, command);
    gauge.restore_selector().ok();
    readback
}

fn open<R: Records>(slave: &CyclicSlave, records: R) -> Gauge<R> {
    Gauge::with_model(records, slave.address, slave.model).with_unit(slave.unit)
}

fn read_preview<R: Records>(
    gauge: &mut Gauge<R>,
    operation: &Operation,
) -> Result<(profivac_client::PreparedWrite, OperationPreview), OperationError> {
    let write = gauge.prepare_unchecked(&operation.named, &operation.text).map_err(before_sending)?;
    let mut conditions = gauge.conditions(&write).map_err(before_sending)?;
    if let Some(beyond) = &write.beyond_range {
        if !operation.force {
            return Err(OperationError::BeyondRange { target: operation.named.name.clone(), error: beyond.clone() });
        }
        conditions.push(forced_condition(beyond));
    }
    let preview = OperationPreview {
        device: gauge.model().name,
        address: gauge.address(),
        octets: write.octets.clone(),
        before: write.before.as_ref().map(|before| (before.text.clone(), before.octets.clone())),
        after: write.text.clone(),
        forced: write.beyond_range.clone(),
        risk: permissions::risk(operation.named.parameter.row, write.code),
        conditions,
    };
    Ok((write, preview))
}

/// A line of the preview: the user sees before the execution that the value is outside the measuring range.
fn forced_condition(BeyondRange { given, lowest, highest }: &BeyondRange) -> Condition {
    let required = format!("the request forces a pressure outside the measuring range, which is {lowest} to {highest}");
    Condition { required, found: format!("it is {given}"), unmet: None }
}

fn execute_checked<R: Records>(gauge: &mut Gauge<R>, command: &ArmedCommand) -> Result<Readback, OperationError> {
    let (write, preview) = read_preview(gauge, &command.operation)?;
    if preview.conditions.iter().any(|condition| condition.unmet.is_some()) {
        return Err(OperationError::ConditionsNotMet(preview.conditions));
    }
    check_unchanged(command, &preview)?;
    let before = preview.before.map(|(text, _)| text);
    match gauge.execute(write) {
        Ok(written) => Ok(Readback { before, after: written.after.map(|after| after.text) }),
        Err(error) => Err(after_sending(error)),
    }
}

/// Compares the present answer of the gauge with its answer when the command was armed.
fn check_unchanged(command: &ArmedCommand, now: &OperationPreview) -> Result<(), ChangedSinceArmed> {
    let (armed, operation) = (&command.preview, &command.operation);
    let text = |before: &Option<(String, Vec<u8>)>| {
        before.as_ref().map_or_else(|| "unreadable".to_owned(), |(text, _)| text.clone())
    };
    if armed.before != now.before {
        return Err(ChangedSinceArmed::Value {
            target: operation.named.name.clone(),
            armed: text(&armed.before),
            now: text(&now.before),
        });
    }
    if armed.octets != now.octets {
        return Err(ChangedSinceArmed::Meaning {
            given: operation.text.clone(),
            armed: armed.after.clone(),
            now: now.after.clone(),
        });
    }
    Ok(())
}

/// An error before anything was sent.
fn before_sending(error: ClientError) -> OperationError {
    match error {
        ClientError::Value { .. } | ClientError::Target(_) | ClientError::Access { .. } => {
            OperationError::InvalidValue(Box::new(error))
        }
        error => Unavailable::Client(Box::new(error)).into(),
    }
}

/// An error of the execution.
fn after_sending(error: ClientError) -> OperationError {
    match error.write_effect() {
        WriteEffect::Refused => OperationError::Refused(Box::new(error)),
        WriteEffect::NotSent => Unavailable::Client(Box::new(error)).into(),
        WriteEffect::PossiblyExecuted => OutcomeUnknown::Line(Box::new(error)).into(),
        WriteEffect::Executed => OutcomeUnknown::NotReadBack(Box::new(error)).into(),
    }
}
