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
pub enum State {
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
    Stands,
    /// Its condition does not hold, and has not for as long as it is to.
    Cleared,
    /// Somebody says that they know.
    Acknowledge,
    /// Somebody takes it out of service.
    TakeOut,
    /// Somebody puts it back into service, or the time is over.
    PutBack,
}

impl State {
    /// All of them.
    pub const ALL: [Self; 5] =
        [Self::Normal, Self::Unacknowledged, Self::Acknowledged, Self::Returned, Self::OutOfService];

    /// Where it stands afterwards; nothing if this changes nothing.
    #[must_use]
    pub const fn after(self, input: Input) -> Option<Self> {
        use Input::{Acknowledge, Cleared, PutBack, Stands, TakeOut};
        use State::{Acknowledged, Normal, OutOfService, Returned, Unacknowledged};
        match (self, input) {
            (Normal, Stands) => Some(Unacknowledged),
            (Normal, TakeOut) => Some(OutOfService),
            (Normal, Cleared | Acknowledge | PutBack) => None,

            (Unacknowledged, Cleared) => Some(Returned),
            (Unacknowledged, Acknowledge) => Some(Acknowledged),
            (Unacknowledged, TakeOut) => Some(OutOfService),
            (Unacknowledged, Stands | PutBack) => None,

            (Acknowledged, Cleared) => Some(Normal),
            (Acknowledged, TakeOut) => Some(OutOfService),
            (Acknowledged, Stands | Acknowledge | PutBack) => None,

            (Returned, Stands) => Some(Unacknowledged),
            (Returned, Acknowledge) => Some(Normal),
            (Returned, TakeOut) => Some(OutOfService),
            (Returned, Cleared | PutBack) => None,

            (OutOfService, PutBack) => Some(Normal),
            (OutOfService, Stands | Cleared | Acknowledge | TakeOut) => None,
        }
    }

    /// Whether it says that its condition holds.
    #[must_use]
    pub const fn is_active(self) -> bool {
        matches!(self, Self::Unacknowledged | Self::Acknowledged)
    }

    /// Whether it waits for somebody to say that they know.
    #[must_use]
    pub const fn wants_acknowledgement(self) -> bool {
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
    use super::Input::{Acknowledge, Cleared, PutBack, Stands, TakeOut};
    use super::State::{Acknowledged, Normal, OutOfService, Returned, Unacknowledged};
    use super::*;

    /// Row by row: the state, then what each input makes of it; the state itself where it changes nothing.
    const TABLE: [(State, [State; 5]); 5] = [
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
            for (input, next) in [Stands, Cleared, Acknowledge, TakeOut, PutBack].into_iter().zip(row) {
                assert_eq!(state.after(input), (next != state).then_some(next), "{state:?} {input:?}");
            }
        }
    }

    #[test]
    fn an_alarm_that_stands_becomes_normal_only_through_a_person() {
        let silent = TABLE.iter().filter(|(state, _)| state.wants_acknowledgement());
        for (state, [stands, cleared, ..]) in silent {
            assert!(![stands, cleared].contains(&&Normal), "{state:?}");
        }
    }

    #[test]
    fn a_word_means_one_state() {
        for state in State::ALL {
            assert_eq!(State::from_word(state.word()), Some(state));
            assert_eq!(serde_json::to_value(state).unwrap(), state.word());
        }
    }
}
