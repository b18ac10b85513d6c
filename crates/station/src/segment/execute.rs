//! What is done to a gauge beside the cycle: a draft of it first, and the deed itself when it was fired.

use crate::control::armed_commands::ArmedCommand;
use crate::control::operation::{Operation, OperationError, OperationPreview, Readback};
use crate::control::permissions;
use profivac_client::cyclic::CyclicSlave;
use profivac_client::records::Records;
use profivac_client::{self, ClientError, ErrorKind, Gauge};

/// What the gauge says to what somebody wants. Nothing is changed.
pub fn preview<R: Records>(
    name: &str,
    watched: &CyclicSlave,
    records: R,
    choice: &Operation,
) -> Result<OperationPreview, OperationError> {
    let mut gauge = open(name, watched, records)?;
    let drafted = read_preview(&mut gauge, choice).map(|(_, draft)| draft);
    // The instance that was shown before is shown again, if the gauge still answers.
    gauge.restore_selector().ok();
    drafted
}

/// Carries out what was armed, if everything is as it was then.
pub fn execute<R: Records>(
    watched: &CyclicSlave,
    records: R,
    order: &ArmedCommand,
) -> Result<Readback, OperationError> {
    let (was, is) = ((order.preview.device, order.preview.address), (watched.model.name, watched.address));
    if was != is {
        let sentence = format!(
            "{} was {} at address {} when it was armed and is {} at {} now",
            order.gauge, was.0, was.1, is.0, is.1
        );
        return Err(OperationError::Changed(sentence));
    }
    let mut gauge = open(&order.gauge, watched, records)?;
    let done = execute_checked(&mut gauge, order);
    gauge.restore_selector().ok();
    done
}

/// MS2 alone: the parameter channel is not part of the data that the station exchanges.
fn open<R: Records>(name: &str, watched: &CyclicSlave, records: R) -> Result<Gauge<R>, OperationError> {
    if !watched.model.features.dpv1 {
        let sentence = format!(
            "{name} has no DP-V1, and the data the station exchanges with it have no parameter channel: take it out of the \
             station's file and use `profivac write --via pkw`"
        );
        return Err(OperationError::Unavailable(sentence));
    }
    Ok(Gauge::with_model(records, watched.address, watched.model).with_unit(watched.unit))
}

fn read_preview<R: Records>(
    gauge: &mut Gauge<R>,
    choice: &Operation,
) -> Result<(profivac_client::PreparedWrite, OperationPreview), OperationError> {
    let order = gauge.prepare_unchecked(&choice.named, &choice.text).map_err(|error| before_sending(&error))?;
    let conditions = gauge.conditions(&order).map_err(|error| before_sending(&error))?;
    let draft = OperationPreview {
        device: gauge.model().name,
        address: gauge.address(),
        octets: order.octets.clone(),
        before: order.before.as_ref().map(|before| (before.text.clone(), before.octets.clone())),
        after: order.text.clone(),
        risk: permissions::risk(choice.named.parameter.row, order.code),
        conditions,
    };
    Ok((order, draft))
}

fn execute_checked<R: Records>(gauge: &mut Gauge<R>, order: &ArmedCommand) -> Result<Readback, OperationError> {
    let (now, draft) = read_preview(gauge, &order.operation)?;
    if draft.conditions.iter().any(|condition| condition.unmet.is_some()) {
        return Err(OperationError::ConditionsNotMet(draft.conditions));
    }
    if let Some(sentence) = change_since_armed(order, &draft) {
        return Err(OperationError::Changed(sentence));
    }
    let before = draft.before.map(|(text, _)| text);
    match gauge.execute(now) {
        Ok(written) => Ok(Readback { before, after: written.after.map(|after| after.text) }),
        Err(error) => Err(after_sending(&error)),
    }
}

/// What is not as it was when it was armed.
fn change_since_armed(order: &ArmedCommand, now: &OperationPreview) -> Option<String> {
    let (was, is) = (&order.preview, now);
    let words = |before: &Option<(String, Vec<u8>)>| before.as_ref().map_or("unreadable", |(text, _)| text).to_owned();
    if was.before != is.before {
        return Some(format!(
            "{} was {} when it was armed and is {} now",
            order.operation.named.name,
            words(&was.before),
            words(&is.before)
        ));
    }
    (was.octets != is.octets)
        .then(|| format!("{} meant {} when it was armed and means {} now", order.operation.text, was.after, is.after))
}

/// Nothing was sent yet.
fn before_sending(error: &ClientError) -> OperationError {
    match error {
        ClientError::Value { .. } | ClientError::Target(_) | ClientError::Access { .. } => {
            OperationError::InvalidValue(error.to_string())
        }
        _ => OperationError::Unavailable(error.to_string()),
    }
}

fn after_sending(error: &ClientError) -> OperationError {
    match error {
        ClientError::Refused { doing: profivac_client::Operation::Write, .. } => {
            OperationError::Refused(error.to_string())
        }
        _ if error.kind() == ErrorKind::Line => OperationError::OutcomeUnknown(error.to_string()),
        // It was taken, and is not read back.
        _ => OperationError::OutcomeUnknown(format!("it was sent and taken, but {error}")),
    }
}
