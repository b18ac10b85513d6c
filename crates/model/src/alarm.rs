//! The priority, the status and the history of an alarm, and the declaration of a plant state.

use crate::alarm_state::AlarmState;
use crate::micros::Micros;
use crate::words;
use crate::words::Word;
use serde::Serialize;
use utoipa::ToSchema;

words! {
    /// How soon an operator must respond. Ordered: `High` is the greatest.
    #[derive(PartialOrd, Ord)]
    pub enum Priority {
        /// Today.
        Low = "low",
        /// Soon.
        Medium = "medium",
        /// At once.
        High = "high",
    }
}

words! {
    /// The kind of the condition of an alarm.
    pub enum ConditionKind {
        /// The pressure is above a limit.
        Above = "above",
        /// The pressure is below a limit.
        Below = "below",
        /// The pressure rises quickly.
        Rise = "rise",
        /// Several gauges are beyond a limit at the same time.
        Several = "several",
        /// A point of a slave is beyond a limit, or has a text.
        Point = "point",
        /// A fresh gauge does not decide a limit.
        NotMeasurable = "not-measurable",
        /// The gauge reports a fault.
        Fault = "fault",
        /// The gauge gives no data.
        Stale = "stale",
        /// The segment does not run.
        SegmentDown = "segment-down",
        /// Many telegrams arrive damaged.
        DamagedTelegrams = "damaged-telegrams",
        /// Many requests to a station of the line are repeated, lost or answered damaged.
        BusRate = "bus-rate",
        /// The database records nothing.
        NotRecording = "not-recording",
        /// The last check of the database has found damage.
        DatabaseDamaged = "database-damaged",
        /// The archive does not answer, or does not store.
        NotArchived = "not-archived",
    }
}

words! {
    /// The kind of a change of an alarm.
    pub enum AlarmChangeKind {
        /// The condition is met.
        Raised = "raised",
        /// The condition is no longer met.
        Returned = "returned",
        /// A user acknowledged the alarm.
        Acknowledged = "acknowledged",
        /// A user shelved the alarm.
        Shelved = "shelved",
        /// The alarm was unshelved.
        Unshelved = "unshelved",
        /// A user took the alarm out of service.
        TakenOutOfService = "taken-out-of-service",
        /// The alarm was returned to service.
        ReturnedToService = "returned-to-service",
        /// A plant state that suppresses the alarm was declared.
        Suppressed = "suppressed",
        /// No plant state suppresses the alarm any more.
        Unsuppressed = "unsuppressed",
        /// The station's file no longer has the alarm.
        Removed = "removed",
        /// A user changed the settings of the alarm.
        SettingsChanged = "settings-changed",
    }
}

impl AlarmChangeKind {
    /// The words in an event and in an e-mail: those of the dashboard, on which an alarm that has returned is *cleared*.
    #[must_use]
    pub fn operator_words(self) -> String {
        match self {
            Self::Returned => "cleared".to_owned(),
            _ => self.word().replace('-', " "),
        }
    }
}

/// The user who did something, and when.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Attribution {
    /// The name of the user.
    pub user: String,
    /// The wall-clock time.
    pub at: Micros,
}

/// Why an alarm is shelved, out of service or suppressed.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Suppression {
    /// The user who shelved it, took it out of service, or declared the plant state that suppresses it.
    pub by: Attribution,
    /// The reason; of a plant state with its name before it.
    pub reason: String,
    /// The wall-clock time at which it ends by itself. A shelved or suppressed alarm has one.
    pub until: Option<Micros>,
}

/// The user who declared a plant state, the reason, and the end.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Declaration {
    /// The user who declared it.
    pub by: Attribution,
    /// The reason of the declaration, or of the last extension.
    pub reason: String,
    /// The wall-clock time at which it ends by itself.
    pub until: Micros,
}

/// The status of an alarm: everything that survives a restart.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct AlarmStatus {
    /// The state.
    pub state: AlarmState,
    /// The time of the last change.
    pub since: Micros,
    /// The number of the last occurrence: the time at which it was raised in milliseconds since 1970, or one more than the
    /// occurrence before; 0 if the alarm was never raised.
    pub occurrence: i64,
    /// When it was raised last.
    pub raised: Option<Micros>,
    /// The value that raised it.
    pub value: Option<f64>,
    /// A sentence about why it was raised.
    pub text: String,
    /// The user who acknowledged it.
    pub acknowledged: Option<Attribution>,
    /// Why it is shelved, out of service or suppressed.
    pub suppression: Option<Suppression>,
}

/// A row of the alarm history.
#[derive(Clone, Debug, PartialEq, Serialize, ToSchema)]
pub struct AlarmHistoryEntry {
    /// When it happened.
    #[serde(rename = "at_ms")]
    #[schema(value_type = i64)]
    pub at: Micros,
    /// The alarm.
    pub alarm: String,
    /// The change.
    #[schema(value_type = AlarmChangeKind)]
    pub change: Word<AlarmChangeKind>,
    /// The state after the change.
    #[schema(value_type = AlarmState)]
    pub state: Word<AlarmState>,
    /// The priority at that time.
    #[schema(value_type = Priority)]
    pub priority: Word<Priority>,
    /// The series, gauge or segment.
    pub subject: Option<String>,
    /// The number of the occurrence.
    pub occurrence: i64,
    /// The user who made the change; `null` if the station did.
    pub user: Option<String>,
    /// The value at that time.
    pub value: Option<f64>,
    /// The unit of the value.
    pub unit: Option<String>,
    /// A sentence.
    pub text: String,
}
