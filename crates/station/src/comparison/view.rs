//! Compared pump-downs as the API shows them.

use super::recorded::{Recorded, excess_of, usual_before};
use super::words::{likeness, sentence};
use crate::identification::sprays::SprayView;
use crate::pumpdown::compare::{Comparison, Direction, Level, Pattern};
use crate::pumpdown::excess::Excess;
use crate::view::{RisePoint, unix_ms};
use jiff::tz::TimeZone;
use serde::Serialize;
use utoipa::ToSchema;

/// Compared pump-downs of one series.
#[derive(Clone, Debug, PartialEq, Serialize, ToSchema)]
pub struct PumpDowns {
    /// The series.
    pub series: String,
    /// The pump-downs, the latest first.
    pub runs: Vec<PumpDownView>,
    /// The number of pump-downs in the time range; `runs` may have fewer.
    pub found: usize,
}

/// A pump-down beside the usual ones.
#[derive(Clone, Debug, PartialEq, Serialize, ToSchema)]
pub struct PumpDownView {
    /// The beginning, in milliseconds since 1970.
    pub start_ms: i64,
    /// The last sample or the venting, in milliseconds since 1970.
    pub end_ms: i64,
    /// The pressure at the beginning in Pa.
    pub start_pa: f64,
    /// The lowest pressure in Pa.
    pub lowest_pa: f64,
    /// Whether a venting ended it.
    pub is_vented: bool,
    /// The times to each decade of mbar, the highest pressure first.
    pub levels: Vec<LevelView>,
    /// The deviation from the usual pump-downs; `null` if there is none.
    pub deviation: Option<DeviationView>,
    /// Changes of the indication that look like helium at a leak, the earliest first.
    pub sprays: Vec<SprayView>,
    /// At most 120 points, evenly on a logarithmic axis of time.
    pub curve: Vec<RisePoint>,
}

/// The time to a pressure.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, ToSchema)]
pub struct LevelView {
    /// The pressure in Pa.
    pub pa: f64,
    /// The time in seconds; `null` if it was not reached or lies in a gap.
    pub s: Option<f64>,
    /// The usual time; `null` if fewer than five usual pump-downs have reached it.
    pub usual: Option<UsualView>,
    /// Whether the time deviates from the usual one, and how.
    #[schema(inline)]
    pub deviation: Option<DirectionView>,
}

/// The usual time to a pressure.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, ToSchema)]
pub struct UsualView {
    /// The median in seconds.
    pub s: f64,
    /// A shorter time deviates.
    pub least_s: f64,
    /// A longer time deviates.
    pub most_s: f64,
    /// The number of pump-downs; 1 with a chosen reference.
    pub runs: usize,
}

/// The direction of a deviation.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, ToSchema)]
#[serde(rename_all = "kebab-case")]
pub enum DirectionView {
    /// Later than usual, or not yet reached.
    Later,
    /// Earlier than usual.
    Earlier,
}

/// Where a pump-down deviates.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, ToSchema)]
#[serde(rename_all = "kebab-case")]
pub enum PatternView {
    /// At every compared level.
    FromTheBeginning,
    /// At low pressure only.
    AtLowPressure,
    /// At high pressure only.
    AtHighPressure,
}

/// What the pressure above the usual one looks like.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, ToSchema)]
#[serde(rename_all = "kebab-case")]
pub enum ExcessView {
    /// It is constant, as with a leak.
    Leak,
    /// It falls with a power of the time, as with outgassing.
    Outgassing,
    /// It falls exponentially, as with a virtual leak.
    VirtualLeak,
}

/// A deviation from the usual pump-downs.
#[derive(Clone, Debug, PartialEq, Serialize, ToSchema)]
pub struct DeviationView {
    /// The deviation at the lowest deviating pressure, in words.
    #[schema(
        example = "20 min later to 1e-5 mbar than usual: 80 min; usual 60 min, the median of the last 10, at most 66 min"
    )]
    pub text: String,
    /// What it looks like, in words.
    pub likeness: String,
    /// Where it deviates.
    #[schema(inline)]
    pub pattern: PatternView,
    /// The shape of the pressure above the usual one; `null` if it is none of these, or too small.
    #[schema(inline)]
    pub excess: Option<ExcessView>,
    /// The beginning of the first of the deviating pump-downs in a row, in milliseconds since 1970.
    pub since_ms: i64,
}

impl PumpDowns {
    /// The last `limit` of the compared pump-downs.
    #[must_use]
    pub fn new(series: String, runs: &[Recorded], compared: &[Comparison], limit: usize) -> Self {
        let first = compared.len().saturating_sub(limit);
        let views =
            compared.iter().zip(runs).enumerate().skip(first).map(|(index, (comparison, own))| {
                PumpDownView::new(comparison, own, &usual_before(runs, compared, index))
            });
        let mut views: Vec<PumpDownView> = views.collect();
        views.reverse();
        Self { series, runs: views, found: runs.len() }
    }
}

impl PumpDownView {
    fn new(comparison: &Comparison, own: &Recorded, usual: &[&Recorded]) -> Self {
        let run = &comparison.run;
        Self {
            start_ms: unix_ms(run.start),
            end_ms: unix_ms(run.end),
            start_pa: run.start_pa,
            lowest_pa: run.lowest_pa,
            is_vented: run.is_vented,
            levels: comparison.levels.iter().map(LevelView::from).collect(),
            deviation: DeviationView::new(comparison, excess_of(comparison, own, usual)),
            sprays: own.sprays(),
            curve: own.curve().into_iter().map(|(s, pa)| RisePoint { s, pa }).collect(),
        }
    }
}

impl DeviationView {
    fn new(comparison: &Comparison, excess: Option<Excess>) -> Option<Self> {
        Some(Self {
            text: sentence(comparison, &TimeZone::UTC)?,
            likeness: likeness(comparison, excess)?,
            pattern: match comparison.pattern()? {
                Pattern::FromTheBeginning => PatternView::FromTheBeginning,
                Pattern::AtLowPressure => PatternView::AtLowPressure,
                Pattern::AtHighPressure => PatternView::AtHighPressure,
            },
            excess: excess.map(|excess| match excess {
                Excess::Constant { .. } => ExcessView::Leak,
                Excess::Outgassing { .. } => ExcessView::Outgassing,
                Excess::VirtualLeak { .. } => ExcessView::VirtualLeak,
            }),
            since_ms: unix_ms(comparison.since.unwrap_or(comparison.run.start)),
        })
    }
}

impl From<&Level> for LevelView {
    fn from(level: &Level) -> Self {
        let usual = |usual: crate::pumpdown::compare::Usual| UsualView {
            s: usual.s,
            least_s: usual.least_s,
            most_s: usual.most_s,
            runs: usual.runs,
        };
        let deviation = level.deviation.map(|direction| match direction {
            Direction::Later => DirectionView::Later,
            Direction::Earlier => DirectionView::Earlier,
        });
        Self { pa: level.pa, s: level.s, usual: level.usual.map(usual), deviation }
    }
}
