//! The rows of the audit trail about commands and about control authority.

use super::armed_commands::ArmedCommand;
use super::authority::AuthorityChange;
use super::operation::{Operation, OperationPreview, OperationRequest, Readback};
use crate::view::Gauge;
use profivac_recorder::{AuditAction, AuditEntry, Micros};
use profivac_web_server::auth::{Actor, User};
use profivac_web_server::authenticator::ReleaseReason;

fn about(entry: AuditEntry, gauge: &Gauge) -> AuditEntry {
    let Gauge { name, segment, address, .. } = gauge;
    AuditEntry { gauge: Some(name.clone()), segment: Some(segment.clone()), address: Some(*address), ..entry }
}

fn with(entry: AuditEntry, operation: &Operation, preview: &OperationPreview) -> AuditEntry {
    let before = preview.before.as_ref().map(|(text, _)| text.clone());
    let after = match &preview.forced {
        Some(beyond) => format!("{}, forced: {beyond}", preview.after),
        None => preview.after.clone(),
    };
    AuditEntry { target: Some(operation.manual_name()), before, after: Some(after), ..entry }
}

/// A command is about to be sent, or was disarmed.
pub fn executed_or_disarmed(
    actor: &Actor,
    gauge: Option<&Gauge>,
    command: &ArmedCommand,
    action: AuditAction,
) -> AuditEntry {
    let entry = actor.audit_entry(action);
    let entry = match gauge {
        Some(gauge) => about(entry, gauge),
        None => AuditEntry { gauge: Some(command.gauge.clone()), ..entry },
    };
    AuditEntry { command_id: Some(command.id.clone()), ..with(entry, &command.operation, &command.preview) }
}

/// The outcome of the command in row `refers_to`, with the values that were read back if it succeeded.
pub fn outcome(executed: AuditEntry, refers_to: i64, readback: Option<&Readback>, sentence: &str) -> AuditEntry {
    let (before, after) = match readback {
        Some(Readback { before, after }) => (before.clone(), after.clone()),
        None => (executed.before, None),
    };
    let (action, outcome) = (AuditAction::Outcome.into(), Some(sentence.to_owned()));
    AuditEntry { at: Micros::now(), action, refers_to: Some(refers_to), before, after, outcome, ..executed }
}

/// A command was not armed.
pub fn refused(
    actor: &Actor,
    gauge: &Gauge,
    operation: &Operation,
    preview: &OperationPreview,
    reason: String,
) -> AuditEntry {
    let entry = about(actor.audit_entry(AuditAction::Refused), gauge);
    AuditEntry { outcome: Some(reason), ..with(entry, operation, preview) }
}

/// A request of a gateway was not armed.
pub fn not_armed(actor: &Actor, gauge: &str, request: &OperationRequest, reason: String) -> AuditEntry {
    AuditEntry {
        gauge: Some(gauge.to_owned()),
        target: request.command.clone().or_else(|| request.target.clone()),
        after: request.value.as_ref().map(ToString::to_string),
        outcome: Some(reason),
        ..actor.audit_entry(AuditAction::Refused)
    }
}

/// Control authority changed, or was requested; `None` if the user had it already.
pub fn authority_changed(actor: &Actor, change: &AuthorityChange) -> Option<AuditEntry> {
    let sentence = match change {
        AuthorityChange::Kept => return None,
        AuthorityChange::Taken => "took control, which was free".to_owned(),
        AuthorityChange::Requested => "requested control".to_owned(),
        AuthorityChange::Released => "released control".to_owned(),
        AuthorityChange::Granted(name) => format!("granted control to {name}"),
        AuthorityChange::TakenOver(name) => format!("took control over from {name}"),
    };
    Some(AuditEntry { outcome: Some(sentence), ..actor.audit_entry(AuditAction::ControlAuthority) })
}

/// The holder did not use control for too long.
pub fn authority_expired(user: &User) -> AuditEntry {
    let sentence = "lost control: it was not used for 15 minutes".to_owned();
    AuditEntry { outcome: Some(sentence), ..of_user(user) }
}

/// The holder can no longer have control.
pub fn authority_released(user: &User, reason: ReleaseReason) -> AuditEntry {
    let sentence = match reason {
        ReleaseReason::SessionEnded => "lost control: the last session ended",
        ReleaseReason::RoleChanged => "lost control: the role changed",
    };
    AuditEntry { outcome: Some(sentence.to_owned()), ..of_user(user) }
}

/// A row about a user that no request of the user caused.
fn of_user(user: &User) -> AuditEntry {
    Actor { user: user.clone(), peer: None }.audit_entry(AuditAction::ControlAuthority)
}
