//! Acting on gauges: commands and parameters in two steps, by one person at a time, each on the disk before it is sent.
//!
//! ```text
//! arm ── the gauge is asked, conditions hold ── armed for 30 s ── fire ── "fired" is on the disk ── conditions and the value
//!                                                                             before again ── sent ── "outcome" on the disk
//! ```
//!
//! | Module | Holds |
//! |---|---|
//! | [`mod@mastership`] | who may act now |
//! | [`orders`] | what is armed |
//! | [`draft`] | what somebody wants, what the gauge says to it, what came of it |
//! | [`allowed`] | risks, roles, and what nobody may |
//! | `trail` | what the audit trail says of it |

pub mod armed_commands;
mod audit_entries;
pub mod authority;
pub mod operation;
pub mod permissions;

use crate::auth::{Role, User};
use crate::services::{SegmentRequestError, Services};
use crate::view::{self, Gauge};
use armed_commands::{ARMED_FOR, ArmedCommand, ArmedCommandError, ArmedCommands};
use authority::{AuthorityChange, AuthorityError, ControlAuthority};
use operation::{Operation, OperationError, OperationRequest, Readback};
use profivac_client::Condition;
use profivac_recorder::{AuditAction, EventKind, Micros, WriteReceipt};
use profivac_virtual::device_spec::entry;
use std::net::IpAddr;
use std::sync::{Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};

/// A segment that has not begun with what was fired after so long does not begin any more: nobody expects it by then.
const START_TIMEOUT: Duration = Duration::from_secs(10);

/// Somebody who acts.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Actor {
    /// Who.
    pub user: User,
    /// From where, if it is known.
    pub peer: Option<IpAddr>,
}

/// Why something was not done.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum ControlError {
    /// There is no such gauge, or no such order.
    #[error("{0}")]
    Unknown(String),
    /// It makes no sense.
    #[error("{0}")]
    Bad(String),
    /// Their role does not allow it.
    #[error("{0}")]
    Forbidden(String),
    /// It cannot be done now, and with which conditions.
    #[error("{0}")]
    Conflict(String, Vec<Condition>),
    /// The audit trail cannot be kept, so nothing was done.
    #[error("nothing was sent, because the audit trail cannot be written: {0}")]
    Disk(String),
}

impl From<AuthorityError> for ControlError {
    fn from(error: AuthorityError) -> Self {
        Self::Conflict(error.to_string(), Vec::new())
    }
}

impl From<ArmedCommandError> for ControlError {
    fn from(error: ArmedCommandError) -> Self {
        match error {
            ArmedCommandError::Unknown(_) => Self::Unknown(error.to_string()),
            ArmedCommandError::Others(_) => Self::Forbidden(error.to_string()),
            ArmedCommandError::Ended(_) | ArmedCommandError::Many => Self::Conflict(error.to_string(), Vec::new()),
        }
    }
}

impl From<OperationError> for ControlError {
    fn from(refusal: OperationError) -> Self {
        let sentence = refusal.to_string();
        match refusal {
            OperationError::InvalidValue(_) => Self::Bad(sentence),
            OperationError::ConditionsNotMet(conditions) => Self::Conflict(sentence, conditions),
            OperationError::Changed(_)
            | OperationError::Unavailable(_)
            | OperationError::Refused(_)
            | OperationError::OutcomeUnknown(_) => Self::Conflict(sentence, Vec::new()),
        }
    }
}

impl From<SegmentRequestError> for OperationError {
    fn from(error: SegmentRequestError) -> Self {
        Self::Unavailable(error.to_string())
    }
}

/// What somebody may do with the mastership.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum AuthorityAction {
    /// Have it, or let its holder know that one wants it.
    Request,
    /// Give it back.
    Release,
    /// Give it to who asked.
    Grant,
    /// Take it from its holder.
    TakeOver,
}

/// Who may act, and what is armed.
#[derive(Default)]
pub struct ControlState {
    state: Mutex<State>,
}

#[derive(Default)]
struct State {
    authority: ControlAuthority,
    armed_commands: ArmedCommands,
    armed: u64,
}

impl ControlState {
    fn locked(&self) -> MutexGuard<'_, State> {
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

/// The state at `now`.
fn at(plant: &Services, now: Instant) -> MutexGuard<'_, State> {
    let mut state = plant.control().locked();
    if let Some(person) = state.authority.expire(now) {
        state.armed_commands.clear();
        plant.recorder().audit(audit_entries::authority_expired(&person));
    }
    state.armed_commands.expire(now);
    state
}

/// Who has the mastership.
#[must_use]
pub fn authority(plant: &Services, now: Instant) -> view::ControlAuthorityView {
    let state = at(plant, now);
    let ago = |since: Instant| {
        let ago = view::duration_ms(now.saturating_duration_since(since));
        view::unix_ms(Micros::now()).saturating_sub_unsigned(ago)
    };
    let holder = state.authority.holder();
    let wish = holder.and_then(|holder| holder.request.as_ref());
    view::ControlAuthorityView {
        holder: holder.map(|holder| holder.person.name.to_string()),
        since_ms: holder.map(|holder| ago(holder.since)),
        asked_by: wish.map(|(person, _)| person.name.to_string()),
        asked_ms: wish.map(|(_, since)| ago(*since)),
    }
}

/// Somebody wants something with the mastership.
///
/// # Errors
/// [`NotDone`]: a viewer, or somebody whose it is not.
pub fn change_authority(
    plant: &Services,
    actor: &Actor,
    wanted: AuthorityAction,
    now: Instant,
) -> Result<(), ControlError> {
    let person = &actor.user;
    may(person, Role::Operator, "the mastership")?;
    let mut state = at(plant, now);
    let authority = &mut state.authority;
    let change = match wanted {
        AuthorityAction::Request => authority.request(person, now),
        AuthorityAction::Release => authority.release(person, now),
        AuthorityAction::Grant => authority.grant(person, now),
        AuthorityAction::TakeOver => authority.take_over(person, now),
    }?;
    if change.changes_holder() {
        state.armed_commands.clear();
    }
    // Rows stand in the order in which things happened: they are handed over before anybody else can do anything.
    let written = (change != AuthorityChange::Kept)
        .then(|| plant.recorder().audit(audit_entries::authority_changed(actor, &change)));
    drop(state);
    wait(written);
    Ok(())
}

/// Who has the mastership, with the role they had when they got it.
#[must_use]
pub fn holder(plant: &Services) -> Option<User> {
    at(plant, Instant::now()).authority.holder().map(|holder| holder.person.clone())
}

/// Why somebody does not act any more.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ReleaseReason {
    /// Their last session has ended: they logged out, were away for too long, or are no user any more.
    SessionEnded,
    /// They have another role.
    RoleChanged,
}

/// Somebody does not act any more: what they held is free, and what they armed is not armed any more.
pub fn release_user(plant: &Services, name: &str, why: ReleaseReason) {
    let mut state = at(plant, Instant::now());
    if let Some(holder) = state.authority.remove_user(name) {
        state.armed_commands.clear();
        plant.recorder().audit(audit_entries::authority_released(&holder, why));
    }
}

/// Whether what was fired may still be sent: it has waited for its segment, and the mastership may have changed hands meanwhile.
#[must_use]
pub fn may_send(plant: &Services, order: &ArmedCommand) -> bool {
    at(plant, Instant::now()).authority.holder().is_some_and(|holder| holder.person.name == order.user)
}

/// Waits until a row is on the disk, as long as one can. If it is not there then, the recorder keeps it and says so.
fn wait(written: Option<WriteReceipt>) {
    written.map(WriteReceipt::wait);
}

fn may(person: &User, needed: Role, what: &str) -> Result<(), ControlError> {
    person.require(needed, what).map_err(|problem| ControlError::Forbidden(problem.to_string()))
}

/// The first step: the gauge is asked, and if all conditions hold it is armed. Waits for the gauge.
///
/// # Errors
/// [`NotDone`] says why nothing is armed.
pub fn arm(plant: &Services, actor: &Actor, name: &str, wish: &OperationRequest) -> Result<ArmedCommand, ControlError> {
    let person = &actor.user;
    let gauge = plant.gauge(name).ok_or_else(|| ControlError::Unknown(format!("there is no gauge {name:?}")))?;
    let model = entry(&gauge.device).map_err(|error| ControlError::Bad(error.to_string()))?.model;
    let choice = Operation::of(model, wish).map_err(ControlError::Bad)?;
    may(person, choice.role(), &choice.target())?;
    if let Some(reason) = choice.blocked_reason() {
        return Err(ControlError::Conflict(format!("{}: {reason}", choice.target()), Vec::new()));
    }
    at(plant, Instant::now()).authority.use_authority(person, Instant::now())?;
    let line = plant.segment_and_port(name).map_err(OperationError::from)?;
    let draft = plant.preview(name, choice.clone())?;
    if draft.conditions.iter().any(|condition| condition.unmet.is_some()) {
        let refusal = OperationError::ConditionsNotMet(draft.conditions.clone());
        let entry = audit_entries::refused(actor, &gauge, &choice, &draft, refusal.to_string());
        wait(Some(plant.recorder().audit(entry)));
        return Err(refusal.into());
    }
    // Reading takes time: somebody may have taken the mastership over meanwhile.
    let now = Instant::now();
    let mut state = at(plant, now);
    state.authority.use_authority(person, now)?;
    state.armed = state.armed.saturating_add(1);
    let id = format!("{:x}-{}", plant.started().0, state.armed);
    let by = person.name.clone();
    let order = ArmedCommand {
        id,
        user: by,
        gauge: gauge.name,
        line,
        operation: choice,
        preview: draft,
        expires_at: now + ARMED_FOR,
    };
    state.armed_commands.arm(order.clone())?;
    Ok(order)
}

/// Somebody thinks better of it.
///
/// # Errors
/// [`NotDone`] when there is no such order, or it is somebody else's.
pub fn disarm(plant: &Services, actor: &Actor, id: &str) -> Result<(), ControlError> {
    let order = at(plant, Instant::now()).armed_commands.disarm(id, &actor.user)?;
    let entry =
        audit_entries::executed_or_disarmed(actor, plant.gauge(&order.gauge).as_ref(), &order, AuditAction::Disarmed);
    wait(Some(plant.recorder().audit(entry)));
    Ok(())
}

/// The second step. Waits for the gauge and the disk; whoever calls this in a thread of its own may go meanwhile.
///
/// # Errors
/// [`NotDone`] says why it was not done, or that nobody knows whether it was.
pub fn execute(plant: &Services, actor: &Actor, id: &str) -> Result<Executed, ControlError> {
    let order = take_to_execute(plant, actor, id, Instant::now())?;
    let gauge = plant.gauge(&order.gauge);
    let entry = audit_entries::executed_or_disarmed(actor, gauge.as_ref(), &order, AuditAction::Execute);
    let row = plant.recorder().audit_before_sending(entry.clone()).map_err(|error| ControlError::Disk(error.to_string()))?;
    let came = plant.execute(order.clone(), Instant::now() + START_TIMEOUT);
    let outcome = came.as_ref().map_or_else(OperationError::outcome, |_| "done".to_owned());
    record_command_event(plant, actor, gauge.as_ref(), &order, &outcome);
    // If the disk does not take it now, it is kept and tried again.
    wait(Some(plant.recorder().audit(audit_entries::outcome(entry, row, &came, &outcome))));
    Ok(Executed { order, done: came? })
}

/// What was fired, and what came of it.
#[derive(Clone, Debug)]
pub struct Executed {
    /// The order.
    pub order: ArmedCommand,
    /// What it was, and what it is.
    pub done: Readback,
}

/// Takes an order out of what is armed, if this person may fire it now.
fn take_to_execute(plant: &Services, actor: &Actor, id: &str, now: Instant) -> Result<ArmedCommand, ControlError> {
    let mut state = at(plant, now);
    // Whose order has ended wants to know that first, and not that the mastership is gone.
    let known = state.armed_commands.get(id, &actor.user)?;
    may(&actor.user, known.operation.role(), &known.operation.target())?;
    state.authority.use_authority(&actor.user, now)?;
    Ok(state.armed_commands.take_to_execute(id, &actor.user)?)
}

/// The same for the list of events: full rate is recorded around it.
fn record_command_event(plant: &Services, actor: &Actor, gauge: Option<&Gauge>, order: &ArmedCommand, outcome: &str) {
    let ArmedCommand { operation: choice, preview: draft, .. } = order;
    let what = match choice.command {
        Some(_) => choice.target(),
        None => format!("{} = {}", choice.target(), draft.after),
    };
    let name = gauge.map(|gauge| gauge.name.as_str());
    let text = format!("{}: {what} by {}: {outcome}", order.gauge, actor.user.name);
    plant.record_event(name, EventKind::Command, text);
}
