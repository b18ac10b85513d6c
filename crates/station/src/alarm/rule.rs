//! What is watched, and when it is an alarm: as the file says, or by itself for every gauge and segment.

use serde::{Deserialize, Serialize};
use std::time::Duration;
use utoipa::ToSchema;

/// How soon somebody must do something. Ordered: the highest is the greatest.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize, ToSchema)]
#[serde(rename_all = "lowercase")]
pub enum Priority {
    /// Today.
    Low,
    /// Soon.
    Medium,
    /// Now.
    High,
}

impl Priority {
    /// All, the highest first.
    pub const ALL: [Self; 3] = [Self::High, Self::Medium, Self::Low];

    /// As it is written.
    #[must_use]
    pub const fn word(self) -> &'static str {
        match self {
            Self::High => "high",
            Self::Medium => "medium",
            Self::Low => "low",
        }
    }

    /// The one with this word.
    #[must_use]
    pub fn from_word(word: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|priority| priority.word() == word)
    }
}

/// What is watched.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Subject {
    /// One measuring part: a gauge, and the name under which the part is recorded.
    Series {
        /// The gauge.
        gauge: String,
        /// `gauge`, or `gauge.N` for channel N of a controller.
        series: String,
    },
    /// A gauge.
    Gauge(String),
    /// A segment.
    Segment(String),
    /// The station itself.
    Station,
}

impl Subject {
    /// The gauge, if it is one.
    #[must_use]
    pub fn gauge(&self) -> Option<&str> {
        match self {
            Self::Series { gauge, .. } | Self::Gauge(gauge) => Some(gauge),
            Self::Segment(_) | Self::Station => None,
        }
    }
}

/// When it is an alarm.
#[derive(Clone, Debug, PartialEq)]
pub enum Condition {
    /// The pressure is above a limit, until it is below where it is over, both in Pa.
    Above {
        /// Above this.
        limit: f64,
        /// Until it is below this, which is not above the limit.
        reset: f64,
    },
    /// The pressure is below a limit, until it is above where it is over, both in Pa.
    Below {
        /// Below this.
        limit: f64,
        /// Until it is above this, which is not below the limit.
        reset: f64,
    },
    /// The pressure rises by so many decades in a minute, until by less than where it is over.
    Rise {
        /// Faster than this.
        limit: f64,
        /// Until it is slower than this.
        reset: f64,
        /// The line through so much of the past is taken.
        window: Duration,
    },
    /// Nothing can be told about limits of a part whose gauge is heard: there is no valid reading, or the range ends before a limit.
    NotMeasurable {
        /// These limits, in Pa.
        limits: Vec<f64>,
    },
    /// The gauge reports a fault.
    Fault,
    /// The gauge gives no fresh data: it is missing, belongs to another master, or is being started.
    Stale {
        /// Its segment tells when it does not run, and then its gauges do not as well.
        behind_segment: Option<String>,
    },
    /// The segment does not run.
    SegmentDown,
    /// More telegrams arrive damaged than so many in a minute.
    DamagedTelegrams {
        /// So many.
        limit: f64,
    },
    /// Nothing is being recorded.
    NotRecording,
}

impl Condition {
    /// The word for it in the API.
    #[must_use]
    pub const fn word(&self) -> &'static str {
        match self {
            Self::Above { .. } => "above",
            Self::Below { .. } => "below",
            Self::Rise { .. } => "rise",
            Self::NotMeasurable { .. } => "blind",
            Self::Fault => "fault",
            Self::Stale { .. } => "stale",
            Self::SegmentDown => "down",
            Self::DamagedTelegrams { .. } => "damage",
            Self::NotRecording => "unrecorded",
        }
    }

    /// What its value and its limit are counted in, if it has them.
    #[must_use]
    pub const fn unit(&self) -> Option<&'static str> {
        match self {
            Self::Above { .. } | Self::Below { .. } => Some("Pa"),
            Self::Rise { .. } => Some("decades/min"),
            Self::DamagedTelegrams { .. } => Some("telegrams/min"),
            Self::NotMeasurable { .. } | Self::Fault | Self::Stale { .. } | Self::SegmentDown | Self::NotRecording => {
                None
            }
        }
    }

    /// The limit, if it has one.
    #[must_use]
    pub const fn limit(&self) -> Option<f64> {
        match self {
            Self::Above { limit, .. }
            | Self::Below { limit, .. }
            | Self::Rise { limit, .. }
            | Self::DamagedTelegrams { limit } => Some(*limit),
            Self::NotMeasurable { .. } | Self::Fault | Self::Stale { .. } | Self::SegmentDown | Self::NotRecording => {
                None
            }
        }
    }

    /// Where it is over, if that is a number.
    #[must_use]
    pub const fn reset(&self) -> Option<f64> {
        match self {
            Self::Above { reset, .. } | Self::Below { reset, .. } | Self::Rise { reset, .. } => Some(*reset),
            Self::DamagedTelegrams { limit } => Some(*limit / 2.0),
            Self::NotMeasurable { .. } | Self::Fault | Self::Stale { .. } | Self::SegmentDown | Self::NotRecording => {
                None
            }
        }
    }
}

/// An alarm as it is meant.
#[derive(Clone, Debug, PartialEq)]
pub struct Rule {
    /// Its name, which no other alarm has.
    pub name: String,
    /// What is watched.
    pub subject: Subject,
    /// When it is an alarm.
    pub condition: Condition,
    /// How soon somebody must do something.
    pub priority: Priority,
    /// The condition must hold for so long before it is an alarm.
    pub delay: Duration,
    /// It must not hold for so long before the alarm is over.
    pub off_delay: Duration,
    /// What is to be done, in the words of whoever wrote the file.
    pub message: Option<String>,
}
