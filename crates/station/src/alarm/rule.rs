//! The rule of an alarm: its condition, its priority and its delays, from the station's file or by default for each gauge and segment.

use profivac_model::{ConditionKind, Priority};
use std::time::Duration;

/// One measuring part of a gauge, by the name under which it is recorded.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Series {
    /// The gauge.
    pub gauge: String,
    /// `gauge`, or `gauge.N` for channel N of a controller.
    pub name: String,
}

/// The condition of an alarm, with its subject.
#[derive(Clone, Debug, PartialEq)]
pub enum Condition {
    /// The pressure is above a limit.
    Above {
        /// The measuring part.
        series: Series,
        /// The limit in Pa.
        limit: f64,
        /// The condition ends at or below this pressure in Pa, which is not above the limit.
        reset: f64,
    },
    /// The pressure is below a limit.
    Below {
        /// The measuring part.
        series: Series,
        /// The limit in Pa.
        limit: f64,
        /// The condition ends at or above this pressure in Pa, which is not below the limit.
        reset: f64,
    },
    /// The pressure rises quickly.
    Rise {
        /// The measuring part.
        series: Series,
        /// The limit in decades per minute.
        limit: f64,
        /// The condition ends at or below this rate.
        reset: f64,
        /// The rate is the slope of the line through the readings of this time.
        window: Duration,
    },
    /// At least `count` of the conditions are met at the same time.
    Several {
        /// Conditions [`Self::Above`], [`Self::Below`] or [`Self::Rise`] of one kind with one limit.
        conditions: Vec<Condition>,
        /// How many must be met: 1 to all.
        count: usize,
    },
    /// A point of a slave is beyond a limit, or has a text.
    Point {
        /// The slave.
        gauge: String,
        /// The point.
        point: String,
        /// What raises the alarm.
        test: PointTest,
        /// The unit of the point.
        unit: Option<&'static str>,
    },
    /// A fresh gauge does not show whether limits are exceeded: it shows no pressure, or its range ends before a limit.
    NotMeasurable {
        /// The measuring part.
        series: Series,
        /// The limits in Pa.
        limits: Vec<f64>,
        /// The gauge has an alarm for its faults: a reading that is a fault raises that one, and no second alarm.
        has_fault_alarm: bool,
    },
    /// The gauge reports a fault.
    Fault {
        /// The gauge.
        gauge: String,
    },
    /// The gauge gives no fresh data: it is missing, belongs to another master, or is being started.
    Stale {
        /// The gauge.
        gauge: String,
        /// A segment with an alarm of its own: while it is down, its gauges raise no alarm.
        behind_segment: Option<String>,
    },
    /// The segment does not run, or none of its gauges, two or more, has given data since the station started.
    SegmentDown {
        /// The segment.
        segment: String,
    },
    /// Many telegrams arrive damaged.
    DamagedTelegrams {
        /// The segment.
        segment: String,
        /// The limit in telegrams per minute. The condition ends at half of it.
        limit: f64,
    },
    /// Many requests to a station of the line are repeated, lost or answered damaged.
    BusRate {
        /// The segment.
        segment: String,
        /// The address of the station.
        station: u8,
        /// The counted occurrence.
        quantity: BusQuantity,
        /// The limit in percent of the requests of the last minute. The condition ends at half of it.
        limit: f64,
    },
    /// The recorder does not write.
    NotRecording,
    /// The last check of the database has found damage.
    DatabaseDamaged,
    /// The archive has not answered for some time, puts batches aside, or so many wait that some were deleted.
    NotArchived {
        /// The limit in hours since its last answer.
        limit: f64,
    },
}

/// What raises the alarm of a point.
#[derive(Clone, Debug, PartialEq)]
pub enum PointTest {
    /// The number is above a limit.
    Above {
        /// The limit, in the unit of the point.
        limit: f64,
        /// The condition ends at or below this number, which is not above the limit.
        reset: f64,
    },
    /// The number is below a limit.
    Below {
        /// The limit, in the unit of the point.
        limit: f64,
        /// The condition ends at or above this number, which is not below the limit.
        reset: f64,
    },
    /// The text is this one.
    Is(String),
}

/// What the alarm of a station on the line counts.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum BusQuantity {
    /// Repetitions.
    Repetitions,
    /// Lost message cycles.
    Lost,
    /// Damaged telegrams.
    Damaged,
}

impl BusQuantity {
    /// The words for users.
    #[must_use]
    pub const fn text(self) -> &'static str {
        match self {
            Self::Repetitions => "repetitions",
            Self::Lost => "lost message cycles",
            Self::Damaged => "damaged telegrams",
        }
    }
}

impl Condition {
    /// Its kind.
    #[must_use]
    pub const fn kind(&self) -> ConditionKind {
        match self {
            Self::Above { .. } => ConditionKind::Above,
            Self::Below { .. } => ConditionKind::Below,
            Self::Rise { .. } => ConditionKind::Rise,
            Self::Several { .. } => ConditionKind::Several,
            Self::Point { .. } => ConditionKind::Point,
            Self::NotMeasurable { .. } => ConditionKind::NotMeasurable,
            Self::Fault { .. } => ConditionKind::Fault,
            Self::Stale { .. } => ConditionKind::Stale,
            Self::SegmentDown { .. } => ConditionKind::SegmentDown,
            Self::DamagedTelegrams { .. } => ConditionKind::DamagedTelegrams,
            Self::BusRate { .. } => ConditionKind::BusRate,
            Self::NotRecording => ConditionKind::NotRecording,
            Self::DatabaseDamaged => ConditionKind::DatabaseDamaged,
            Self::NotArchived { .. } => ConditionKind::NotArchived,
        }
    }

    /// The measuring part, if the condition is about one.
    #[must_use]
    pub const fn series(&self) -> Option<&Series> {
        match self {
            Self::Above { series, .. }
            | Self::Below { series, .. }
            | Self::Rise { series, .. }
            | Self::NotMeasurable { series, .. } => Some(series),
            Self::Several { .. }
            | Self::Point { .. }
            | Self::Fault { .. }
            | Self::Stale { .. }
            | Self::SegmentDown { .. }
            | Self::DamagedTelegrams { .. }
            | Self::BusRate { .. }
            | Self::NotRecording
            | Self::DatabaseDamaged
            | Self::NotArchived { .. } => None,
        }
    }

    /// All measuring parts that the condition is about.
    #[must_use]
    pub fn all_series(&self) -> Vec<&Series> {
        match self {
            Self::Several { conditions, .. } => conditions.iter().filter_map(Self::series).collect(),
            other => other.series().into_iter().collect(),
        }
    }

    /// The pressure limit in Pa, if the condition, or each of its conditions, has one.
    #[must_use]
    pub fn pressure_limit(&self) -> Option<f64> {
        match self {
            Self::Above { limit, .. } | Self::Below { limit, .. } => Some(*limit),
            Self::Several { conditions, .. } => conditions.first().and_then(Self::pressure_limit),
            _ => None,
        }
    }

    /// The gauge, if the condition is about one.
    #[must_use]
    pub fn gauge(&self) -> Option<&str> {
        match self {
            Self::Fault { gauge } | Self::Stale { gauge, .. } | Self::Point { gauge, .. } => Some(gauge),
            other => other.series().map(|series| series.gauge.as_str()),
        }
    }

    /// The segment, if the condition is about one.
    #[must_use]
    pub fn segment(&self) -> Option<&str> {
        match self {
            Self::SegmentDown { segment } | Self::DamagedTelegrams { segment, .. } | Self::BusRate { segment, .. } => {
                Some(segment)
            }
            _ => None,
        }
    }

    /// The name of the series, gauge or segment.
    #[must_use]
    pub fn subject(&self) -> Option<&str> {
        let series = self.series().map(|series| series.name.as_str());
        series.or_else(|| self.gauge()).or_else(|| self.segment())
    }

    /// The unit of value and limit, if it has them.
    #[must_use]
    pub const fn unit(&self) -> Option<&'static str> {
        match self {
            Self::Above { .. } | Self::Below { .. } => Some("Pa"),
            Self::Rise { .. } => Some("decades/min"),
            Self::DamagedTelegrams { .. } => Some("telegrams/min"),
            Self::BusRate { .. } => Some("%"),
            Self::NotArchived { .. } => Some("h"),
            // The value is the number of gauges.
            Self::Several { .. } => Some("gauges"),
            Self::Point { unit, .. } => *unit,
            Self::NotMeasurable { .. }
            | Self::Fault { .. }
            | Self::Stale { .. }
            | Self::SegmentDown { .. }
            | Self::NotRecording
            | Self::DatabaseDamaged => None,
        }
    }

    /// The limit, if it has one.
    #[must_use]
    pub const fn limit(&self) -> Option<f64> {
        match self {
            Self::Above { limit, .. }
            | Self::Below { limit, .. }
            | Self::Rise { limit, .. }
            | Self::DamagedTelegrams { limit, .. }
            | Self::BusRate { limit, .. }
            | Self::NotArchived { limit } => Some(*limit),
            Self::Several { count, .. } => Some(*count as f64),
            Self::Point { test: PointTest::Above { limit, .. } | PointTest::Below { limit, .. }, .. } => Some(*limit),
            Self::Point { .. }
            | Self::NotMeasurable { .. }
            | Self::Fault { .. }
            | Self::Stale { .. }
            | Self::SegmentDown { .. }
            | Self::NotRecording
            | Self::DatabaseDamaged => None,
        }
    }

    /// The value at which the condition ends, if that is a number.
    #[must_use]
    pub const fn reset(&self) -> Option<f64> {
        match self {
            Self::Above { reset, .. } | Self::Below { reset, .. } | Self::Rise { reset, .. } => Some(*reset),
            Self::Point { test: PointTest::Above { reset, .. } | PointTest::Below { reset, .. }, .. } => Some(*reset),
            Self::DamagedTelegrams { limit, .. } | Self::BusRate { limit, .. } => Some(*limit / 2.0),
            Self::Several { .. }
            | Self::Point { .. }
            | Self::NotMeasurable { .. }
            | Self::Fault { .. }
            | Self::Stale { .. }
            | Self::SegmentDown { .. }
            | Self::NotRecording
            | Self::DatabaseDamaged
            | Self::NotArchived { .. } => None,
        }
    }
}

/// The rule of an alarm.
#[derive(Clone, Debug, PartialEq)]
pub struct Rule {
    /// The name, which no other alarm has.
    pub name: String,
    /// The condition.
    pub condition: Condition,
    /// How soon an operator must respond.
    pub priority: Priority,
    /// The condition must be met for this time before the alarm is raised.
    pub delay: Duration,
    /// The condition must not be met for this time before the alarm returns to normal.
    pub off_delay: Duration,
    /// The instruction for the operator, from the station's file.
    pub message: Option<String>,
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_kind_has_the_word_of_the_api() {
        for kind in ConditionKind::ALL {
            assert_eq!(serde_json::to_value(kind).unwrap(), kind.word());
        }
    }
}
