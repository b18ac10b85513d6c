//! The control service: one user at a time has control, arms commands and executes them.

use super::armed_commands::{ARMED_FOR, ArmedCommand, ArmedCommands};
use super::audit_entries;
use super::authority::{AuthorityError, ControlAuthority};
use super::error::{ControlError, OperationError, SegmentRequestError};
use super::operation::{Operation, OperationRequest, Readback};
use super::refusals::Refusals;
use super::requests::SegmentRequests;
use crate::recording::RecorderHandle;
use crate::snapshot::SnapshotStore;
use crate::view::{self, Gauge};
use profivac_recorder::{AuditAction, EventKind, Micros, WriteReceipt};
use profivac_web_server::auth::{Actor, Role, User};
use profivac_web_server::authenticator::ReleaseReason;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};

/// A segment that has not begun with a command after this time does not begin with it any more: the operator no longer expects it.
const START_TIMEOUT: Duration = Duration::from_secs(10);

/// A change of control authority that a user asks for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum AuthorityAction {
    /// Take control if it is free, otherwise ask its holder for it.
    Request,
    /// Give control back.
    Release,
    /// Give control to the user who requested it.
    Grant,
    /// Take control from its holder.
    TakeOver,
}

/// A command that was executed.
#[derive(Clone, Debug)]
pub struct Executed {
    /// The command.
    pub command: ArmedCommand,
    /// The value before and after.
    pub readback: Readback,
}

#[derive(Default)]
struct ControlState {
    authority: ControlAuthority,
    armed_commands: ArmedCommands,
    /// Commands armed since the start, for their ids.
    armed: u64,
    /// The user of a gateway whose request is being done: that user has no session and keeps control meanwhile.
    gateway_user: Option<Arc<str>>,
}

/// The holder of control, and the armed commands.
pub struct ControlService {
    state: Mutex<ControlState>,
    started: Micros,
    recorder: Arc<RecorderHandle>,
    snapshots: Arc<SnapshotStore>,
    requests: SegmentRequests,
    refusals: Refusals,
    /// One request of a gateway at a time.
    turn: Mutex<()>,
}

impl ControlService {
    /// A service in which control is free and no command is armed.
    #[must_use]
    pub fn new(recorder: Arc<RecorderHandle>, snapshots: Arc<SnapshotStore>) -> Self {
        let requests = SegmentRequests::new(Arc::clone(&snapshots));
        let refusals = Refusals::new(Arc::clone(&recorder));
        let (state, turn, started) = (Mutex::default(), Mutex::default(), Micros::now());
        Self { state, started, recorder, snapshots, requests, refusals, turn }
    }

    /// The check of roles, which records what it refuses.
    #[must_use]
    pub const fn refusals(&self) -> &Refusals {
        &self.refusals
    }

    /// The request queues of the segments.
    #[must_use]
    pub const fn requests(&self) -> &SegmentRequests {
        &self.requests
    }

    /// The holder of control at `now`, and the request for it.
    #[must_use]
    pub fn authority(&self, now: Instant) -> view::ControlAuthorityView {
        let state = self.state_at(now);
        let unix_ms = |since: Instant| {
            let ago = view::duration_ms(now.saturating_duration_since(since));
            view::unix_ms(Micros::now()).saturating_sub_unsigned(ago)
        };
        let holder = state.authority.holder();
        let request = holder.and_then(|holder| holder.request.as_ref());
        view::ControlAuthorityView {
            holder: holder.map(|holder| holder.user.name.to_string()),
            since_ms: holder.map(|holder| unix_ms(holder.since)),
            requested_by: request.map(|(user, _)| user.name.to_string()),
            requested_ms: request.map(|(_, since)| unix_ms(*since)),
        }
    }

    /// Changes who has control. On the disk when this returns, if the disk takes it in time.
    ///
    /// # Errors
    /// [`ControlError`] for a viewer, and for a user who cannot have or give control now.
    pub fn change_authority(&self, actor: &Actor, action: AuthorityAction, now: Instant) -> Result<(), ControlError> {
        let user = &actor.user;
        self.refusals.require(actor, Role::Operator, "control")?;
        let mut state = self.state_at(now);
        let authority = &mut state.authority;
        let change = match action {
            AuthorityAction::Request => authority.request(user, now),
            AuthorityAction::Release => authority.release(user, now),
            AuthorityAction::Grant => authority.grant(user, now),
            AuthorityAction::TakeOver => authority.take_over(user, now),
        }?;
        if change.changes_holder() {
            state.armed_commands.clear();
        }
        // The row is queued while the state is locked, so rows are in the order of the changes.
        let receipt = audit_entries::authority_changed(actor, &change).map(|entry| self.recorder.audit(entry));
        drop(state);
        receipt.map(WriteReceipt::wait);
        Ok(())
    }

    /// Whether a command that was given to its segment may still be sent: its user may have lost control while it waited.
    #[must_use]
    pub fn may_send(&self, command: &ArmedCommand) -> bool {
        self.state_at(Instant::now()).authority.holder().is_some_and(|holder| holder.user.name == command.user)
    }

    /// Asks the gauge, and arms the operation if all its conditions hold. Waits for the gauge.
    ///
    /// # Errors
    /// [`ControlError`] says why nothing is armed.
    pub fn arm(&self, actor: &Actor, gauge: &str, request: &OperationRequest) -> Result<ArmedCommand, ControlError> {
        let user = &actor.user;
        let gauge = self.snapshots.gauge_named(gauge)?;
        let Some(model) = gauge.model else {
            let reason = "the station sends a slave by its GSD file only the outputs of its file: change them there";
            return Err(ControlError::Blocked { target: gauge.name, reason });
        };
        let operation = Operation::resolve(model, request)?;
        self.refusals.require(actor, operation.role(), &operation.target())?;
        if let Some(reason) = operation.blocked_reason() {
            return Err(ControlError::Blocked { target: operation.target(), reason });
        }
        self.use_authority(user, Instant::now())?;
        let unknown = || OperationError::from(SegmentRequestError::from(self.snapshots.unknown_gauge(&gauge.name)));
        let connection = self.snapshots.connection(&gauge.name).ok_or_else(unknown)?;
        let preview = self.requests.preview(&gauge.name, operation.clone())?;
        if preview.conditions.iter().any(|condition| condition.unmet.is_some()) {
            let error = OperationError::ConditionsNotMet(preview.conditions.clone());
            let row = audit_entries::refused(actor, &gauge, &operation, &preview, error.to_string());
            self.recorder.audit(row).wait();
            return Err(error.into());
        }
        // Reading the gauge takes time: another user may have taken control meanwhile.
        let now = Instant::now();
        let mut state = self.state_at(now);
        state.authority.use_authority(user, now)?;
        state.armed = state.armed.saturating_add(1);
        let command = ArmedCommand {
            id: format!("{:x}-{}", self.started.0, state.armed),
            user: user.name.clone(),
            gauge: gauge.name,
            connection,
            operation,
            preview,
            expires_at: now + ARMED_FOR,
        };
        state.armed_commands.arm(command.clone())?;
        Ok(command)
    }

    /// Disarms a command.
    ///
    /// # Errors
    /// [`ControlError`] when the command is not armed, or was armed by another user.
    pub fn disarm(&self, actor: &Actor, id: &str) -> Result<(), ControlError> {
        let command = self.state_at(Instant::now()).armed_commands.disarm(id, &actor.user)?;
        let gauge = self.snapshots.gauge(&command.gauge);
        let row = audit_entries::executed_or_disarmed(actor, gauge.as_ref(), &command, AuditAction::Disarmed);
        self.recorder.audit(row).wait();
        Ok(())
    }

    /// Executes an armed command. Waits for the disk and for the gauge; continues when the requester has disconnected.
    ///
    /// # Errors
    /// [`ControlError`] says whether the command was sent, and why it failed.
    pub fn execute(&self, actor: &Actor, id: &str) -> Result<Executed, ControlError> {
        let command = self.take_to_execute(actor, id, Instant::now())?;
        let gauge = self.snapshots.gauge(&command.gauge);
        let row = audit_entries::executed_or_disarmed(actor, gauge.as_ref(), &command, AuditAction::Execute);
        let id = self.recorder.audit_before_sending(row.clone())?;
        let result = self.requests.execute(command.clone(), Instant::now() + START_TIMEOUT);
        let outcome = result.as_ref().map_or_else(OperationError::outcome, |_| "done".to_owned());
        self.record_command_event(actor, gauge.as_ref(), &command, &outcome);
        self.recorder.audit(audit_entries::outcome(row, id, result.as_ref().ok(), &outcome)).wait();
        Ok(Executed { command, readback: result? })
    }

    /// Arms and executes an operation for the user of a gateway, who has no session. Takes control if it is free and releases it
    /// afterwards; control that another user has stays there. A refusal is in the audit trail. Waits for the disk and for the gauge.
    ///
    /// # Errors
    /// As [`arm`](Self::arm) and [`execute`](Self::execute).
    pub fn execute_directly(
        &self,
        actor: &Actor,
        gauge: &str,
        request: &OperationRequest,
    ) -> Result<Executed, ControlError> {
        let _turn = self.turn.lock().unwrap_or_else(PoisonError::into_inner);
        let result = self.execute_in_turn(actor, gauge, request);
        self.state_at(Instant::now()).gateway_user = None;
        if let Err(error) = &result
            && !error.is_in_audit_trail()
        {
            self.recorder.audit(audit_entries::not_armed(actor, gauge, request, error.to_string())).wait();
        }
        result
    }

    fn execute_in_turn(
        &self,
        actor: &Actor,
        gauge: &str,
        request: &OperationRequest,
    ) -> Result<Executed, ControlError> {
        let user = &actor.user;
        self.refusals.require(actor, Role::Operator, "control")?;
        let has_control = match self.holder() {
            Some(holder) if holder.name != user.name => {
                return Err(AuthorityError::HeldByOther(holder.name.to_string()).into());
            }
            holder => holder.is_some(),
        };
        self.state_at(Instant::now()).gateway_user = Some(Arc::clone(&user.name));
        if !has_control {
            self.change_authority(actor, AuthorityAction::Request, Instant::now())?;
        }
        let result = self.arm(actor, gauge, request).and_then(|armed| self.execute(actor, &armed.id));
        if !has_control {
            // Control that was lost meanwhile needs no release.
            self.change_authority(actor, AuthorityAction::Release, Instant::now()).ok();
        }
        result
    }

    /// The user who has control, with the role at the time of taking it.
    #[must_use]
    pub fn holder(&self) -> Option<User> {
        self.state_at(Instant::now()).authority.holder().map(|holder| holder.user.clone())
    }

    /// Frees the control of a user, drops the request of the user, and disarms the commands.
    pub fn release_user(&self, name: &str, reason: ReleaseReason) {
        let mut state = self.state_at(Instant::now());
        let is_of_gateway = state.gateway_user.as_deref() == Some(name);
        if is_of_gateway && reason == ReleaseReason::SessionEnded {
            return;
        }
        if let Some(user) = state.authority.remove_user(name) {
            state.armed_commands.clear();
            self.recorder.audit(audit_entries::authority_released(&user, reason));
        }
    }

    fn use_authority(&self, user: &User, now: Instant) -> Result<(), AuthorityError> {
        self.state_at(now).authority.use_authority(user, now)
    }

    /// Takes a command out of the armed ones, if this user may execute it at `now`.
    fn take_to_execute(&self, actor: &Actor, id: &str, now: Instant) -> Result<ArmedCommand, ControlError> {
        let mut state = self.state_at(now);
        // An expired command is reported before a missing authority.
        let command = state.armed_commands.get(id, &actor.user)?;
        self.refusals.require(actor, command.operation.role(), &command.operation.target())?;
        state.authority.use_authority(&actor.user, now)?;
        Ok(state.armed_commands.take_to_execute(id, &actor.user)?)
    }

    /// Records the outcome as an event too: the recorder keeps the full sample rate around events.
    fn record_command_event(&self, actor: &Actor, gauge: Option<&Gauge>, command: &ArmedCommand, outcome: &str) {
        let ArmedCommand { operation, preview, .. } = command;
        let action = match operation.command {
            Some(_) => operation.target(),
            None => format!("{} = {}", operation.target(), preview.after),
        };
        let text = format!("{}: {action} by {}: {outcome}", command.gauge, actor.user.name);
        self.recorder.event_now(gauge.map(|gauge| gauge.name.as_str()), EventKind::Command, text);
    }

    /// The state at `now`: control that was not used for too long is free, and expired commands are gone.
    fn state_at(&self, now: Instant) -> MutexGuard<'_, ControlState> {
        let mut state = self.state.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some(user) = state.authority.expire(now) {
            state.armed_commands.clear();
            self.recorder.audit(audit_entries::authority_expired(&user));
        }
        state.armed_commands.expire(now);
        state
    }
}
