//! The audit trail: which user did what to which gauge or alarm, when, and with what outcome.

use crate::micros::Micros;
use crate::words;
use crate::words::Word;
use serde::Serialize;
use std::fmt;
use utoipa::ToSchema;

words! {
    /// The action of an audit entry.
    pub enum AuditAction {
        /// A command is about to be sent. Written before it is sent.
        Execute = "execute",
        /// The outcome of a command.
        Outcome = "outcome",
        /// A command was not armed because a condition does not hold, or the role of the user does not permit an action.
        Refused = "refused",
        /// The user disarmed a command.
        Disarmed = "disarmed",
        /// Control authority was requested, granted, taken or released.
        ControlAuthority = "control-authority",
        /// The user acknowledged an alarm.
        Acknowledged = "acknowledged",
        /// The user shelved an alarm.
        Shelved = "shelved",
        /// The user unshelved an alarm.
        Unshelved = "unshelved",
        /// The user took an alarm out of service.
        TakenOutOfService = "taken-out-of-service",
        /// The user returned an alarm to service.
        ReturnedToService = "returned-to-service",
        /// The user changed the settings of an alarm.
        AlarmSettings = "alarm-settings",
        /// The user declared a plant state.
        PlantStateDeclared = "plant-state-declared",
        /// The user gave a declared plant state a later end.
        PlantStateExtended = "plant-state-extended",
        /// The user ended a declared plant state.
        PlantStateEnded = "plant-state-ended",
        /// A copy of the database is about to be made. Written before it is made.
        Backup = "backup",
        /// The station has read its file again, and a value in it has changed.
        FileChanged = "file-changed",
    }
}

words! {
    /// The role of a user. A role includes the permissions of all lower roles.
    #[derive(PartialOrd, Ord)]
    pub enum Role {
        /// Reads.
        Viewer = "viewer",
        /// Operates the plant: acknowledges alarms, executes commands.
        Operator = "operator",
        /// Changes the plant: writes parameters, takes alarms out of service.
        Engineer = "engineer",
    }
}

impl fmt::Display for Role {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        formatter.write_str(self.word())
    }
}

/// An entry of the audit trail.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, ToSchema)]
pub struct AuditEntry {
    /// The number of the entry. Later entries have higher numbers. An entry that is not written yet has 0.
    pub id: i64,
    /// The time, in milliseconds since 1970.
    #[serde(rename = "at_ms")]
    #[schema(value_type = i64)]
    pub at: Micros,
    /// The action.
    #[schema(value_type = AuditAction)]
    pub action: Word<AuditAction>,
    /// For an `outcome` or `disarmed`, the number of the entry that it belongs to.
    pub refers_to: Option<i64>,
    /// The name of the user.
    pub user: String,
    /// The role of the user at that time.
    #[schema(value_type = Role)]
    pub role: Word<Role>,
    /// The address of the user's computer.
    pub peer: Option<String>,
    /// The gauge.
    pub gauge: Option<String>,
    /// The segment of the gauge.
    pub segment: Option<String>,
    /// The bus address of the gauge.
    pub address: Option<u8>,
    /// The manual's name and numbers of the parameter, or the name of the alarm or plant state.
    pub target: Option<String>,
    /// The value before the action.
    pub before: Option<String>,
    /// The requested value; for an `outcome`, the value that was read back.
    pub after: Option<String>,
    /// The result, in a sentence.
    pub outcome: Option<String>,
    /// The identifier of the armed command.
    pub command_id: Option<String>,
}
