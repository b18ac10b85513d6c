//! The numbers of a report, in machine-readable form: pressures in Pa, times in seconds since the beginning and as timestamps.

use super::format::{Unit, target_pressure};
use crate::config::Config;
use crate::identification::view::PlantView;
use crate::pumpdown::compare::Direction;
use crate::pumpdown::time_range::seconds;
use crate::pumpdown::{TimeRange, Trace};
use crate::view::{IntervalView, RiseCause};
use jiff::Timestamp;
use jiff::tz::TimeZone;
use profivac_model::{EventKind, Micros, Word};
use profivac_vacuum::Gas;
use serde::Serialize;

/// The entry of a gauge in the station's configuration file.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct GaugeInfo {
    /// The title of the device model.
    pub device: Option<String>,
    /// The bus address.
    pub address: Option<u8>,
    /// The segment.
    pub segment: Option<String>,
    /// The gas in the chamber, unless it is air or nitrogen.
    pub gas: Option<String>,
    /// Horizontal lines in the trend: names and pressures in Pa.
    #[serde(skip)]
    pub levels: Vec<(String, f64)>,
}

impl GaugeInfo {
    /// The entry for a series: that of the gauge, or of the controller whose channel it is (`name.2`).
    #[must_use]
    pub fn of(config: &Config, series: &str) -> Self {
        let gauges =
            || config.segments.iter().flat_map(|segment| segment.gauges.iter().map(move |gauge| (segment, gauge)));
        let channel = series.rsplit_once('.').map_or(series, |(name, _)| name);
        let found = gauges().find(|(_, gauge)| gauge.name == series);
        let found = found.or_else(|| gauges().find(|(_, gauge)| gauge.name == channel));
        found.map_or_else(Self::default, |(segment, gauge)| Self {
            device: Some(gauge.device.title.to_owned()),
            address: Some(gauge.address),
            segment: Some(segment.name.clone()),
            gas: (gauge.gas != Gas::N2).then(|| gauge.gas.to_string()),
            levels: gauge.levels.iter().map(|(name, level)| (name.clone(), level.pa())).collect(),
        })
    }
}

/// The contents of a report.
#[derive(Clone, Debug)]
pub struct ReportRequest {
    /// The heading.
    pub title: String,
    /// The name of the station, if known.
    pub station: Option<String>,
    /// The path of the database.
    pub record: String,
    /// The time range.
    pub span: TimeRange,
    /// How the time range was chosen, in a sentence.
    pub why: String,
    /// The names of the series, and their gauges.
    pub gauges: Vec<(String, GaugeInfo)>,
    /// The volume, in m³.
    pub volume_m3: Option<f64>,
    /// Pressures for the table of times, in Pa, besides decades and levels.
    pub pressures: Vec<f64>,
    /// The unit of pressures on the page.
    pub unit: Unit,
    /// The time zone of the page, besides UTC.
    pub zone: TimeZone,
    /// The time at which the report is made.
    pub made: Micros,
}

/// A pressure in the table of times.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct TargetPressure {
    /// The pressure in Pa.
    pub pa: f64,
    /// The name of the level, if it is a level of a gauge.
    pub name: Option<String>,
}

/// When a gauge reached a pressure.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Reached {
    /// The pressure in Pa.
    pub pa: f64,
    /// Whether and how exactly the time is known.
    pub outcome: Outcome,
    /// The time in seconds since the beginning; with `between` and `before` the latest possible.
    pub s: Option<f64>,
    /// The same time as a timestamp.
    pub at: Option<Timestamp>,
    /// With `between`, the earliest possible time in seconds; with `unknown`, when the pressure was below the range for the
    /// first time.
    pub from_s: Option<f64>,
    /// With `unknown`, the lower end of the range in Pa.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub limit_pa: Option<f64>,
}

/// Whether a gauge reached a pressure, and how exactly the time is known.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Outcome {
    /// At this time.
    Reached,
    /// In a gap without valid samples.
    Between,
    /// At this time or before: the gauge could not measure so high a pressure before.
    Before,
    /// From the beginning.
    Already,
    /// The pressure was below the range of the gauge, which does not show whether it was reached.
    Unknown,
    /// Not at all.
    Not,
}

/// A pressure at a time.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct PressurePoint {
    /// The pressure in Pa.
    pub pa: f64,
    /// The time in seconds since the beginning.
    pub s: f64,
    /// The same time as a timestamp.
    pub at: Timestamp,
}

/// A fall of the pressure.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Falling {
    /// The time in seconds since the beginning.
    pub s: f64,
    /// The pressure in the middle of the fall, in Pa.
    pub pa: f64,
    /// The time constant, in which the pressure falls to 1/e, in seconds.
    pub time_constant_s: f64,
    /// The effective pumping speed in m³/s, if the volume is known.
    pub speed_m3_per_s: Option<f64>,
}

/// The slope at the end.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Slope {
    /// The exponent n in `p ~ t^-n`.
    pub exponent: f64,
    /// The standard error of n.
    pub error: f64,
    /// The beginning of the fitted time, in seconds since the beginning.
    pub from_s: f64,
    /// The end of the fitted time, in seconds since the beginning.
    pub to_s: f64,
}

/// A rise of the pressure.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Rising {
    /// Its beginning.
    pub from: PressurePoint,
    /// Its end.
    pub to: PressurePoint,
    /// The time of pumping before it, in seconds, if the beginning of its pump-down is in the time range.
    pub pumped_s: Option<f64>,
    /// The cause; `None` if the rise is not that of a closed volume.
    pub cause: Option<RiseCause>,
    /// Why the rise has no leak and no outgassing with an interval; `None` if it has both.
    pub note: Option<&'static str>,
    /// The leak, in Pa/s.
    pub leak_pa_per_s: Option<IntervalView>,
    /// The outgassing at the beginning, in Pa/s.
    pub outgassing_pa_per_s: Option<IntervalView>,
    /// The leak, in Pa m³/s, if the volume is known.
    pub leak_pa_m3_per_s: Option<IntervalView>,
    /// The outgassing at the beginning, in Pa m³/s, if the volume is known.
    pub outgassing_pa_m3_per_s: Option<IntervalView>,
    /// The effective pumping speed at the pressure before the rise in m³/s, if the volume is known: both at the beginning over that
    /// pressure.
    pub speed_m3_per_s: Option<f64>,
}

/// The data behind the numbers of a gauge.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct DataCoverage {
    /// The number of stored samples.
    pub samples: usize,
    /// The median time between two samples, in seconds.
    pub spacing_s: Option<f64>,
    /// The length of the longest span used in place of samples, in seconds; `None` if all samples are stored.
    pub coarsest_s: Option<f64>,
    /// The time with valid pressures, in seconds. The names are those of the qualities of a reading.
    pub valid_s: f64,
    /// The time above the range, in seconds.
    pub overrange_s: f64,
    /// The time below the range, in seconds.
    pub underrange_s: f64,
    /// The time in which the gauge did not measure, in seconds.
    pub off_s: f64,
    /// The time without a gauge on the channel, in seconds.
    pub missing_s: f64,
    /// The time with a fault of the gauge, in seconds.
    pub fault_s: f64,
    /// The time without samples, in seconds.
    pub stale_s: f64,
    /// The time in which the unit or the configuration of a gauge of another master was assumed, in seconds.
    pub assumed_s: f64,
}

/// A gauge, or a channel of a controller.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Gauge {
    /// The name of the series.
    pub name: String,
    /// Its entry in the configuration file.
    #[serde(flatten)]
    pub identity: GaugeInfo,
    /// The first valid pressure: of the first valid sample, or the one that the gauge held at the beginning.
    pub first: Option<PressurePoint>,
    /// The lowest valid pressure, after a running median of five samples.
    pub lowest: Option<PressurePoint>,
    /// The last valid pressure: of the last valid sample, or the one that the gauge held at the end.
    pub last: Option<PressurePoint>,
    /// The times at which it reached the pressures, in the order of [`Report::targets`].
    pub times: Vec<Reached>,
    /// The fastest fall.
    pub quickest: Option<Falling>,
    /// The falls, from high to low pressure.
    pub falls: Vec<Falling>,
    /// The slope at the end.
    pub slope: Option<Slope>,
    /// The rises.
    pub rises: Vec<Rising>,
    /// The data behind these numbers.
    #[serde(rename = "standing")]
    pub coverage: DataCoverage,
    /// The curve.
    #[serde(skip)]
    pub trace: Trace,
}

/// The times of a pump-down beside those of the usual ones.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct UsualTimes {
    /// The series.
    pub gauge: String,
    /// The deviation as a sentence without a full stop, or that there is none.
    pub text: String,
    /// What a deviation looks like.
    pub likeness: Option<String>,
    /// The changes of the indication that look like helium at a leak, as sentences without a full stop.
    pub sprays: Vec<String>,
    /// The times to each decade of mbar, the highest pressure first.
    pub levels: Vec<UsualTime>,
}

/// The time to a pressure beside the usual one.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct UsualTime {
    /// The pressure in Pa.
    pub pa: f64,
    /// The time in seconds; `None` if it was not reached or lies in a gap.
    pub s: Option<f64>,
    /// The median of the usual times in seconds.
    pub usual_s: Option<f64>,
    /// The limits beyond which a time deviates, in seconds.
    pub limits_s: Option<[f64; 2]>,
    /// The direction of a deviation.
    pub deviation: Option<Direction>,
}

/// An event.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct ReportEvent {
    /// Its number in the charts.
    pub number: usize,
    /// Its time.
    pub at: Timestamp,
    /// The gauge that it is about.
    pub gauge: Option<String>,
    /// The kind of event.
    pub kind: Word<EventKind>,
    /// The event in a sentence.
    pub text: String,
    /// Its time, to the microsecond.
    #[serde(skip)]
    pub moment: Micros,
}

/// A report.
#[derive(Clone, Debug, Serialize)]
pub struct Report {
    /// The program that made it.
    pub generator: &'static str,
    /// The time at which it was made.
    pub made: Timestamp,
    /// The heading.
    pub title: String,
    /// The name of the station, if known.
    pub station: Option<String>,
    /// The path of the database.
    pub record: String,
    /// The beginning.
    pub begin: Timestamp,
    /// The end.
    pub end: Timestamp,
    /// The duration in seconds.
    pub seconds: f64,
    /// How the time range was chosen, in a sentence.
    pub why: String,
    /// The unit of the page. Pressures in this structure are in Pa.
    pub unit: Unit,
    /// The volume, in m³.
    pub volume_m3: Option<f64>,
    /// The pressures of the table of times, from high to low.
    #[serde(rename = "asked")]
    pub targets: Vec<TargetPressure>,
    /// The gauges.
    pub gauges: Vec<Gauge>,
    /// The plant, identified from the record of the leading gauge; `None` without a volume, or if it cannot be identified.
    pub plant: Option<PlantView>,
    /// Why the plant cannot be identified.
    pub plant_note: Option<String>,
    /// The times of the leading gauge beside the usual ones.
    pub usual: Option<UsualTimes>,
    /// The events, the earliest first.
    pub events: Vec<ReportEvent>,
    /// Whether there were more events than the report lists.
    pub has_more_events: bool,
    /// The default deadband of a recorder, in decades.
    pub dead_band_decades: f64,
    /// The time range in microseconds.
    #[serde(skip)]
    pub span: TimeRange,
    /// The time zone of the page.
    #[serde(skip)]
    pub zone: TimeZone,
}

impl Report {
    /// The leading gauge: the one that measured from the beginning, if any, and over the most decades.
    #[must_use]
    pub fn lead(&self) -> Option<&Gauge> {
        let rank = |gauge: &Gauge| {
            let (first, lowest) = gauge.first.zip(gauge.lowest)?;
            Some((first.s < 1.0, (first.pa / lowest.pa).log10()))
        };
        let ranked = self.gauges.iter().filter_map(|gauge| Some((rank(gauge)?, gauge)));
        let best = ranked.reduce(|best, one| if one.0 > best.0 { one } else { best });
        best.map(|(_, gauge)| gauge)
    }
}

impl TargetPressure {
    /// The pressure with its unit, after the name of the level.
    #[must_use]
    pub fn words(&self, unit: Unit) -> String {
        let pressure = format!("{}\u{a0}{}", target_pressure(self.pa, unit), unit.name());
        self.name.as_ref().map_or(pressure.clone(), |name| format!("{name}: {pressure}"))
    }
}

/// The time of an event, in seconds since the beginning.
#[must_use]
pub fn since(report: &Report, at: Micros) -> f64 {
    seconds(report.span.start, at)
}
