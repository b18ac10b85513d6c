//! Where an alarm stands, and what leads from where to where: ISA-18.2 (IEC 62682), clause 5, without latching.
//!
//! ```text
//!              stands                    acknowledged
//!   Normal ───────────► Unacknowledged ───────────────► Acknowledged
//!     ▲ ▲                  │       ▲                        │
//!     │ │          cleared │       │ stands                 │ cleared
//!     │ │                  ▼       │                        │
//!     │ └───────────── Returned ───┘                        │
//!     │   acknowledged                                      │
//!     └─────────────────────────────────────────────────────┘
//!
//!   from each of them: taken out ─► Out of service ─ put back ─► Normal
//! ```
//!
//! The standard's shelving is being out of service with an end. What puts an alarm out of service is always a person.

use serde::{Deserialize, Serialize};
use utoipa::ToSchema;

/// Where an alarm stands.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash, Serialize, Deserialize, ToSchema)]
#[serde(rename_all = "kebab-case")]
pub enum AlarmState {
    /// Its condition does not hold, and nobody needs to know anything.
    #[default]
    Normal,
    /// Its condition holds, and nobody has said that they know.
    Unacknowledged,
    /// Its condition holds, and somebody knows.
    Acknowledged,
    /// Its condition held, and nobody has said that they know.
    Returned,
    /// Somebody has taken it away, with a reason.
    OutOfService,
}

/// What happens to an alarm.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Input {
    /// Its condition holds, and has for as long as it is to.
    ConditionMet,
    /// Its condition does not hold, and has not for as long as it is to.
    ConditionCleared,
    /// Somebody says that they know.
    Acknowledge,
    /// Somebody takes it out of service.
    TakeOutOfService,
    /// Somebody puts it back into service, or the time is over.
    ReturnToService,
}

impl AlarmState {
    /// All of them.
    pub const ALL: [Self; 5] =
        [Self::Normal, Self::Unacknowledged, Self::Acknowledged, Self::Returned, Self::OutOfService];

    /// Where it stands afterwards; nothing if this changes nothing.
    #[must_use]
    pub const fn after(self, input: Input) -> Option<Self> {
        use AlarmState::{Acknowledged, Normal, OutOfService, Returned, Unacknowledged};
        use Input::{Acknowledge, ConditionCleared, ConditionMet, ReturnToService, TakeOutOfService};
        match (self, input) {
            (Normal, ConditionMet) => Some(Unacknowledged),
            (Normal, TakeOutOfService) => Some(OutOfService),
            (Normal, ConditionCleared | Acknowledge | ReturnToService) => None,

            (Unacknowledged, ConditionCleared) => Some(Returned),
            (Unacknowledged, Acknowledge) => Some(Acknowledged),
            (Unacknowledged, TakeOutOfService) => Some(OutOfService),
            (Unacknowledged, ConditionMet | ReturnToService) => None,

            (Acknowledged, ConditionCleared) => Some(Normal),
            (Acknowledged, TakeOutOfService) => Some(OutOfService),
            (Acknowledged, ConditionMet | Acknowledge | ReturnToService) => None,

            (Returned, ConditionMet) => Some(Unacknowledged),
            (Returned, Acknowledge) => Some(Normal),
            (Returned, TakeOutOfService) => Some(OutOfService),
            (Returned, ConditionCleared | ReturnToService) => None,

            (OutOfService, ReturnToService) => Some(Normal),
            (OutOfService, ConditionMet | ConditionCleared | Acknowledge | TakeOutOfService) => None,
        }
    }

    /// Whether it says that its condition holds.
    #[must_use]
    pub const fn is_active(self) -> bool {
        matches!(self, Self::Unacknowledged | Self::Acknowledged)
    }

    /// Whether it waits for somebody to say that they know.
    #[must_use]
    pub const fn needs_acknowledgement(self) -> bool {
        matches!(self, Self::Unacknowledged | Self::Returned)
    }

    /// As it stands in the file and in the API.
    #[must_use]
    pub const fn word(self) -> &'static str {
        match self {
            Self::Normal => "normal",
            Self::Unacknowledged => "unacknowledged",
            Self::Acknowledged => "acknowledged",
            Self::Returned => "returned",
            Self::OutOfService => "out-of-service",
        }
    }

    /// The state with this word.
    #[must_use]
    pub fn from_word(word: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|state| state.word() == word)
    }
}

#[cfg(test)]
mod tests {
    use super::AlarmState::{Acknowledged, Normal, OutOfService, Returned, Unacknowledged};
    use super::Input::{Acknowledge, ConditionCleared, ConditionMet, ReturnToService, TakeOutOfService};
    use super::*;

    /// Row by row: the state, then what each input makes of it; the state itself where it changes nothing.
    const TABLE: [(AlarmState, [AlarmState; 5]); 5] = [
        //                 Stands          Cleared       Acknowledge   TakeOut       PutBack
        (Normal, [Unacknowledged, Normal, Normal, OutOfService, Normal]),
        (Unacknowledged, [Unacknowledged, Returned, Acknowledged, OutOfService, Unacknowledged]),
        (Acknowledged, [Acknowledged, Normal, Acknowledged, OutOfService, Acknowledged]),
        (Returned, [Unacknowledged, Returned, Normal, OutOfService, Returned]),
        (OutOfService, [OutOfService, OutOfService, OutOfService, OutOfService, Normal]),
    ];

    #[test]
    fn each_input_leads_from_each_state_where_the_table_says() {
        for (state, row) in TABLE {
            for (input, next) in
                [ConditionMet, ConditionCleared, Acknowledge, TakeOutOfService, ReturnToService].into_iter().zip(row)
            {
                assert_eq!(state.after(input), (next != state).then_some(next), "{state:?} {input:?}");
            }
        }
    }

    #[test]
    fn an_alarm_that_stands_becomes_normal_only_through_a_person() {
        let silent = TABLE.iter().filter(|(state, _)| state.needs_acknowledgement());
        for (state, [stands, cleared, ..]) in silent {
            assert!(![stands, cleared].contains(&&Normal), "{state:?}");
        }
    }

    #[test]
    fn a_word_means_one_state() {
        for state in AlarmState::ALL {
            assert_eq!(AlarmState::from_word(state.word()), Some(state));
            assert_eq!(serde_json::to_value(state).unwrap(), state.word());
        }
    }
}
