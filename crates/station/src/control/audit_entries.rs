//! What the audit trail says of an act.

use super::armed_commands::ArmedCommand;
use super::authority::AuthorityChange;
use super::operation::{Operation, OperationError, OperationPreview, Readback};
use super::{Actor, ReleaseReason};
use crate::auth::User;
use crate::view::Gauge;
use profivac_recorder::{AuditAction, AuditEntry, Micros};

/// A row about nothing yet.
fn row(what: AuditAction, person: &User) -> AuditEntry {
    AuditEntry {
        at: Micros::now(),
        action: what,
        refers_to: None,
        user: person.name.to_string(),
        role: person.role.to_string(),
        peer: None,
        gauge: None,
        segment: None,
        address: None,
        target: None,
        before: None,
        after: None,
        outcome: None,
        command_id: None,
    }
}

impl Actor {
    /// A row about something they did.
    #[must_use]
    pub fn row(&self, what: AuditAction) -> AuditEntry {
        AuditEntry { peer: self.peer.map(|peer| peer.to_string()), ..row(what, &self.user) }
    }
}

fn about(entry: AuditEntry, gauge: &Gauge) -> AuditEntry {
    let Gauge { name, segment, address, .. } = gauge;
    AuditEntry { gauge: Some(name.clone()), segment: Some(segment.clone()), address: Some(*address), ..entry }
}

fn with(entry: AuditEntry, choice: &Operation, draft: &OperationPreview) -> AuditEntry {
    let before = draft.before.as_ref().map(|(text, _)| text.clone());
    AuditEntry { target: Some(choice.manual_name()), before, after: Some(draft.after.clone()), ..entry }
}

/// An order: fired, or disarmed.
pub fn executed_or_disarmed(
    actor: &Actor,
    gauge: Option<&Gauge>,
    order: &ArmedCommand,
    what: AuditAction,
) -> AuditEntry {
    let entry = actor.row(what);
    let entry = match gauge {
        Some(gauge) => about(entry, gauge),
        None => AuditEntry { gauge: Some(order.gauge.clone()), ..entry },
    };
    AuditEntry { command_id: Some(order.id.clone()), ..with(entry, &order.operation, &order.preview) }
}

/// What came of what the row `of` says.
pub fn outcome(fired: AuditEntry, of: i64, came: &Result<Readback, OperationError>, words: &str) -> AuditEntry {
    let (before, after) = match came {
        Ok(Readback { before, after }) => (before.clone(), after.clone()),
        Err(_) => (fired.before, None),
    };
    let outcome = Some(words.to_owned());
    AuditEntry { at: Micros::now(), action: AuditAction::Outcome, refers_to: Some(of), before, after, outcome, ..fired }
}

/// Nothing was armed.
pub fn refused(actor: &Actor, gauge: &Gauge, choice: &Operation, draft: &OperationPreview, why: String) -> AuditEntry {
    AuditEntry { outcome: Some(why), ..with(about(actor.row(AuditAction::Refused), gauge), choice, draft) }
}

/// The mastership.
pub fn authority_changed(actor: &Actor, change: &AuthorityChange) -> AuditEntry {
    let sentence = match change {
        AuthorityChange::Taken | AuthorityChange::Kept => "has taken the mastership, which was free".to_owned(),
        AuthorityChange::Requested => "has asked for the mastership".to_owned(),
        AuthorityChange::Released => "has released the mastership".to_owned(),
        AuthorityChange::Granted(name) => format!("has granted the mastership to {name}"),
        AuthorityChange::TakenOver(name) => format!("has taken the mastership over from {name}"),
    };
    AuditEntry { outcome: Some(sentence), ..actor.row(AuditAction::ControlAuthority) }
}

/// Its holder did nothing for long.
pub fn authority_expired(person: &User) -> AuditEntry {
    let sentence = "has lost the mastership by doing nothing for 15 minutes";
    AuditEntry { outcome: Some(sentence.to_owned()), ..row(AuditAction::ControlAuthority, person) }
}

/// Its holder has gone.
pub fn authority_released(person: &User, why: ReleaseReason) -> AuditEntry {
    let sentence = match why {
        ReleaseReason::SessionEnded => "has left, and the mastership is free",
        ReleaseReason::RoleChanged => "has another role, and the mastership is free",
    };
    AuditEntry { outcome: Some(sentence.to_owned()), ..row(AuditAction::ControlAuthority, person) }
}
