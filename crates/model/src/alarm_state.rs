//! The states of an alarm and their transitions: ISA-18.2 (IEC 62682), clause 5, without latching.
//!
//! ```text
//!          condition met                acknowledged
//!   Normal ───────────► Unacknowledged ───────────────► Acknowledged
//!     ▲ ▲                  │       ▲                        │
//!     │ │          cleared │       │ condition met          │ cleared
//!     │ │                  ▼       │                        │
//!     │ └───────────── Returned ───┘                        │
//!     │   acknowledged                                      │
//!     └─────────────────────────────────────────────────────┘
//!
//!   from each of them: shelved ──────────────► Shelved ──────── unshelved, or its time is over ─► Normal
//!   from each of them: taken out of service ─► Out of service ─ returned to service ────────────► Normal
//!   from each of them: suppressed ───────────► Suppressed ───── unsuppressed ───────────────────► Normal
//! ```
//!
//! Only a user shelves an alarm or takes it out of service. A shelved alarm can be taken out of service; one that is out of service cannot
//! be shelved. A declared plant state suppresses alarms (ISA-18.2: suppressed by design). A suppressed alarm can be shelved and taken out
//! of service; one that is shelved or out of service stays so.

use crate::words;

words! {
    /// The state of an alarm.
    #[derive(Default)]
    pub enum AlarmState {
        /// The condition is not met.
        #[default]
        Normal = "normal",
        /// The condition is met, and the alarm is not acknowledged.
        Unacknowledged = "unacknowledged",
        /// The condition is met, and the alarm is acknowledged.
        Acknowledged = "acknowledged",
        /// The condition is no longer met, and the alarm is not acknowledged.
        Returned = "returned",
        /// An operator silenced the alarm for a while.
        Shelved = "shelved",
        /// An engineer took the alarm out of service.
        OutOfService = "out-of-service",
        /// The alarm means nothing in a plant state that a user has declared.
        Suppressed = "suppressed",
    }
}

/// An input of the state table.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum AlarmInput {
    /// The condition is met for longer than the delay.
    ConditionMet,
    /// The condition is not met for longer than the off-delay.
    ConditionCleared,
    /// A user acknowledges the alarm.
    Acknowledge,
    /// A user shelves the alarm.
    Shelve,
    /// A user unshelves the alarm, or its time is over.
    Unshelve,
    /// A user takes the alarm out of service.
    TakeOutOfService,
    /// A user returns the alarm to service, or its time out of service is over.
    ReturnToService,
    /// A plant state that suppresses the alarm is declared.
    Suppress,
    /// No plant state that suppresses the alarm is declared any more.
    Unsuppress,
}

impl AlarmState {
    /// The next state; `None` if the input changes nothing.
    #[must_use]
    pub const fn after(self, input: AlarmInput) -> Option<Self> {
        use AlarmInput::{
            Acknowledge, ConditionCleared, ConditionMet, ReturnToService, Shelve, Suppress, TakeOutOfService, Unshelve,
            Unsuppress,
        };
        use AlarmState::{Acknowledged, Normal, OutOfService, Returned, Shelved, Suppressed, Unacknowledged};
        match (self, input) {
            (Normal, ConditionMet) => Some(Unacknowledged),
            (Normal, Shelve) => Some(Shelved),
            (Normal, TakeOutOfService) => Some(OutOfService),
            (Normal, Suppress) => Some(Suppressed),
            (Normal, ConditionCleared | Acknowledge | Unshelve | ReturnToService | Unsuppress) => None,

            (Unacknowledged, ConditionCleared) => Some(Returned),
            (Unacknowledged, Acknowledge) => Some(Acknowledged),
            (Unacknowledged, Shelve) => Some(Shelved),
            (Unacknowledged, TakeOutOfService) => Some(OutOfService),
            (Unacknowledged, Suppress) => Some(Suppressed),
            (Unacknowledged, ConditionMet | Unshelve | ReturnToService | Unsuppress) => None,

            (Acknowledged, ConditionCleared) => Some(Normal),
            (Acknowledged, Shelve) => Some(Shelved),
            (Acknowledged, TakeOutOfService) => Some(OutOfService),
            (Acknowledged, Suppress) => Some(Suppressed),
            (Acknowledged, ConditionMet | Acknowledge | Unshelve | ReturnToService | Unsuppress) => None,

            (Returned, ConditionMet) => Some(Unacknowledged),
            (Returned, Acknowledge) => Some(Normal),
            (Returned, Shelve) => Some(Shelved),
            (Returned, TakeOutOfService) => Some(OutOfService),
            (Returned, Suppress) => Some(Suppressed),
            (Returned, ConditionCleared | Unshelve | ReturnToService | Unsuppress) => None,

            (Shelved, Unshelve) => Some(Normal),
            (Shelved, TakeOutOfService) => Some(OutOfService),
            (
                Shelved,
                ConditionMet | ConditionCleared | Acknowledge | Shelve | ReturnToService | Suppress | Unsuppress,
            ) => None,

            (OutOfService, ReturnToService) => Some(Normal),
            (
                OutOfService,
                ConditionMet | ConditionCleared | Acknowledge | Shelve | Unshelve | TakeOutOfService | Suppress
                | Unsuppress,
            ) => None,

            (Suppressed, Unsuppress) => Some(Normal),
            (Suppressed, Shelve) => Some(Shelved),
            (Suppressed, TakeOutOfService) => Some(OutOfService),
            (Suppressed, ConditionMet | ConditionCleared | Acknowledge | Unshelve | ReturnToService | Suppress) => None,
        }
    }

    /// Whether the condition is met in this state.
    #[must_use]
    pub const fn is_active(self) -> bool {
        matches!(self, Self::Unacknowledged | Self::Acknowledged)
    }

    /// Whether the alarm waits for an acknowledgement.
    #[must_use]
    pub const fn needs_acknowledgement(self) -> bool {
        matches!(self, Self::Unacknowledged | Self::Returned)
    }

    /// The words in sentences and in e-mails: those of the dashboard.
    #[must_use]
    pub const fn operator_words(self) -> &'static str {
        match self {
            Self::Unacknowledged => "not acknowledged",
            Self::Returned => "cleared, not acknowledged",
            Self::OutOfService => "out of service",
            Self::Normal | Self::Acknowledged | Self::Shelved | Self::Suppressed => self.word(),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::AlarmState::{Acknowledged, Normal, OutOfService, Returned, Shelved, Suppressed, Unacknowledged};
    use super::*;

    const INPUTS: [AlarmInput; 9] = [
        AlarmInput::ConditionMet,
        AlarmInput::ConditionCleared,
        AlarmInput::Acknowledge,
        AlarmInput::Shelve,
        AlarmInput::Unshelve,
        AlarmInput::TakeOutOfService,
        AlarmInput::ReturnToService,
        AlarmInput::Suppress,
        AlarmInput::Unsuppress,
    ];

    /// Row by row: the state, then the next state for each input; the state itself where nothing changes.
    #[rustfmt::skip]
    const TABLE: [(AlarmState, [AlarmState; 9]); 7] = [
        //                ConditionMet    Cleared       Acknowledge   Shelve        Unshelve        TakeOut       Return          Suppress
        //                Unsuppress
        (Normal,         [Unacknowledged, Normal,       Normal,       Shelved,      Normal,         OutOfService, Normal,         Suppressed,   Normal]),
        (Unacknowledged, [Unacknowledged, Returned,     Acknowledged, Shelved,      Unacknowledged, OutOfService, Unacknowledged, Suppressed,   Unacknowledged]),
        (Acknowledged,   [Acknowledged,   Normal,       Acknowledged, Shelved,      Acknowledged,   OutOfService, Acknowledged,   Suppressed,   Acknowledged]),
        (Returned,       [Unacknowledged, Returned,     Normal,       Shelved,      Returned,       OutOfService, Returned,       Suppressed,   Returned]),
        (Shelved,        [Shelved,        Shelved,      Shelved,      Shelved,      Normal,         OutOfService, Shelved,        Shelved,      Shelved]),
        (OutOfService,   [OutOfService,   OutOfService, OutOfService, OutOfService, OutOfService,   OutOfService, Normal,         OutOfService, OutOfService]),
        (Suppressed,     [Suppressed,     Suppressed,   Suppressed,   Shelved,      Suppressed,     OutOfService, Suppressed,     Suppressed,   Normal]),
    ];

    #[test]
    fn every_transition_is_as_in_the_table() {
        for (state, row) in TABLE {
            for (input, next) in INPUTS.into_iter().zip(row) {
                assert_eq!(state.after(input), (next != state).then_some(next), "{state:?} {input:?}");
            }
        }
    }

    #[test]
    fn an_unacknowledged_alarm_becomes_normal_only_by_a_user() {
        let waiting = TABLE.iter().filter(|(state, _)| state.needs_acknowledgement());
        for (state, [met, cleared, ..]) in waiting {
            assert!(![met, cleared].contains(&&Normal), "{state:?}");
        }
    }
}
