//! `[[alarm]]`: alarms about the pressure of a gauge.
//!
//! ```toml
//! [[alarm]]
//! name = "chamber too high"
//! gauge = "chamber"                # or a channel of a controller: "tpg.2"
//! above = "1e-3 mbar"              # or below = "…", or rise = 0.5 decades per minute
//! hysteresis = 0.1                 # decades; or reset = "8e-4 mbar"
//! delay = "1 s"
//! off-delay = "5 s"
//! priority = "high"                # high, medium, low
//! message = "close the valve to the lock"
//!
//! [[alarm]]
//! name = "hall vented"
//! gauges = ["a", "b", "c"]         # at least `count` of them
//! count = 2
//! above = "1e-2 mbar"
//!
//! [[alarm]]
//! name = "repetitions of station 9"
//! segment = "hall"                 # a station of the line, also of another master
//! station = 9
//! repetitions = 1.0                # or lost, or damaged: percent of the requests of the last minute
//! ```

use super::default_alarms::{DefaultAlarmsToml, default_alarms};
use super::error::{ConfigProblem, Located, NamedItem};
use super::names::unique;
use super::number_range::NumberRange;
use super::segments::{SegmentToml, gauge_names};
use super::slaves;
use super::values::{delay, number, priority};
use crate::time_span::TimeSpan;
use profivac_client::cyclic::open_instances;
use profivac_client::pressure::Pressure;
use profivac_client::suggestion::closest;
use profivac_host::text_file::Parsed;
use profivac_station::alarm::{BusQuantity, Condition, Priority, Rule, Series};
use profivac_web_server::visible_text::check_lines;
use serde::Deserialize;
use std::collections::HashSet;
use std::ops::RangeInclusive;
use std::time::Duration;
use toml::Spanned;

/// Defaults. chosen: readings flicker by less than a tenth of a decade, and a single wrong reading lasts less than a second.
const HYSTERESIS: f64 = 0.1;
const DELAY: Duration = Duration::from_secs(1);
const OFF_DELAY: Duration = Duration::from_secs(5);
const WINDOW: Duration = Duration::from_secs(30);

/// The range of windows over which a rise is fitted.
const WINDOW_RANGE: RangeInclusive<Duration> = Duration::from_secs(5)..=Duration::from_secs(600);

/// The largest hysteresis in decades, and the largest rise in decades per minute.
const MAX_DECADES: f64 = 10.0;

/// A hysteresis may be 0.
const HYSTERESIS_RANGE: NumberRange = NumberRange::Between(0.0, MAX_DECADES);

/// The rounding of a pressure that is converted to another unit.
const ROUNDING: f64 = 1e-6;

/// One `[[alarm]]`.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields, rename_all = "kebab-case")]
pub struct AlarmToml {
    /// The name, unique among the alarms. It is the identity of the alarm in the history.
    name: Spanned<String>,
    /// The gauge, or `NAME.N` for channel N of a controller.
    gauge: Option<Spanned<String>>,
    /// Several gauges; the alarm needs `count` of them beyond the limit.
    gauges: Option<Spanned<Vec<Spanned<String>>>>,
    /// How many of `gauges` must be beyond the limit: 1 to their number.
    count: Option<Spanned<usize>>,
    /// The segment of `station`.
    segment: Option<Spanned<String>>,
    /// The address of the station whose requests are counted, 0 to 126.
    station: Option<Spanned<u8>>,
    /// Raised above this percentage of repeated requests in the last minute, up to 100.
    repetitions: Option<Spanned<f64>>,
    /// Raised above this percentage of requests without an answer in the last minute, up to 100.
    lost: Option<Spanned<f64>>,
    /// Raised above this percentage of damaged answers in the last minute, up to 100.
    damaged: Option<Spanned<f64>>,
    /// Raised above this pressure: a number and its unit.
    above: Option<Spanned<Parsed<Pressure>>>,
    /// Raised below this pressure: a number and its unit.
    below: Option<Spanned<Parsed<Pressure>>>,
    /// Raised by a rise of more than this many decades per minute, up to 10.
    rise: Option<Spanned<f64>>,
    /// The pressure at which `above` or `below` ends, in place of `hysteresis`.
    reset: Option<Spanned<Parsed<Pressure>>>,
    /// How far back the pressure must go: decades, 0 to 10, default 0.1; for `rise` decades per minute, default half of the limit.
    hysteresis: Option<Spanned<f64>>,
    /// The time over which a rise is fitted, 5 s to 10 min. Default: `30 s`.
    window: Option<Spanned<Parsed<TimeSpan>>>,
    /// The condition must hold for this time, up to 1 h. Default: `1 s`.
    delay: Option<Spanned<Parsed<TimeSpan>>>,
    /// The condition must be over for this time, up to 1 h. Default: `5 s`.
    off_delay: Option<Spanned<Parsed<TimeSpan>>>,
    /// `high`, `medium` or `low`. Default: `medium`.
    priority: Option<Spanned<String>>,
    /// What an operator shall do, shown with the alarm.
    message: Option<Spanned<String>>,
}

/// All alarms: those of the file, then the default alarms.
pub fn rules(
    alarms: &[AlarmToml],
    defaults: &DefaultAlarmsToml,
    segments: &[SegmentToml],
) -> Result<Vec<Rule>, Located> {
    unique(NamedItem::Alarm, alarms.iter().map(|alarm| &alarm.name))?;
    let mut rules = alarms.iter().map(|alarm| rule(alarm, segments)).collect::<Result<Vec<_>, _>>()?;
    for (place, rule) in slaves::rules(segments.iter().flat_map(|segment| &segment.slave))? {
        if rules.iter().any(|other| other.name == rule.name) {
            return Err(Located::new(place, ConfigProblem::Duplicate { item: NamedItem::Alarm, name: rule.name }));
        }
        rules.push(rule);
    }
    let defaults = default_alarms(&rules, defaults, segments)?;
    let taken: HashSet<_> = defaults.iter().map(|rule| rule.name.as_str()).collect();
    if let Some(alarm) = alarms.iter().find(|alarm| taken.contains(alarm.name.get_ref().as_str())) {
        let problem = ConfigProblem::DefaultAlarmName(alarm.name.get_ref().clone());
        return Err(Located::new(alarm.name.span(), problem));
    }
    rules.extend(defaults);
    Ok(rules)
}

fn rule(alarm: &AlarmToml, segments: &[SegmentToml]) -> Result<Rule, Located> {
    let (delay, off_delay) = (delay(alarm.delay.as_ref(), DELAY)?, delay(alarm.off_delay.as_ref(), OFF_DELAY)?);
    let message = alarm.message.as_ref();
    message.map_or(Ok(()), |text| {
        check_lines(text.get_ref()).map_err(|problem| Located::new(text.span(), ConfigProblem::Text(problem)))
    })?;
    Ok(Rule {
        name: alarm.name.get_ref().clone(),
        condition: of_gauge_or_station(alarm, segments)?,
        priority: priority(alarm.priority.as_ref(), Priority::Medium)?,
        delay,
        off_delay,
        message: message.map(|text| text.get_ref().clone()),
    })
}

/// The condition about a gauge, or about a station of the line.
fn of_gauge_or_station(alarm: &AlarmToml, segments: &[SegmentToml]) -> Result<Condition, Located> {
    let has_rate = [&alarm.repetitions, &alarm.lost, &alarm.damaged].iter().any(|it| it.is_some());
    match (&alarm.gauge, &alarm.gauges, &alarm.count, &alarm.segment, &alarm.station) {
        (Some(gauge), None, None, None, None) if !has_rate => of_gauge(alarm, gauge, segments),
        (None, Some(gauges), Some(count), None, None) if !has_rate => several(alarm, gauges, count, segments),
        (None, None, None, Some(segment), Some(station)) => bus_rate(alarm, segment, *station.get_ref(), segments),
        _ => Err(Located::new(alarm.name.span(), ConfigProblem::AlarmSubject(alarm.name.get_ref().clone()))),
    }
}

/// The condition about the pressure of one gauge.
fn of_gauge(alarm: &AlarmToml, gauge: &Spanned<String>, segments: &[SegmentToml]) -> Result<Condition, Located> {
    let series = series(gauge, segments)?;
    check_range(alarm, &series, segments)?;
    condition(alarm, series)
}

/// The condition about several gauges, of which `count` must be beyond the limit.
fn several(
    alarm: &AlarmToml,
    gauges: &Spanned<Vec<Spanned<String>>>,
    count: &Spanned<usize>,
    segments: &[SegmentToml],
) -> Result<Condition, Located> {
    let (names, wanted) = (gauges.get_ref(), *count.get_ref());
    let mut seen = HashSet::new();
    if let Some(again) = names.iter().find(|name| !seen.insert(name.get_ref())) {
        return Err(Located::new(again.span(), ConfigProblem::RepeatedGauge(again.get_ref().clone())));
    }
    if !(1..=names.len()).contains(&wanted) {
        let problem = ConfigProblem::CountOfGauges { count: wanted, gauges: names.len() };
        return Err(Located::new(count.span(), problem));
    }
    let conditions = names.iter().map(|gauge| of_gauge(alarm, gauge, segments)).collect::<Result<Vec<_>, _>>()?;
    Ok(Condition::Several { conditions, count: wanted })
}

/// The condition about the requests to a station of the line.
fn bus_rate(
    alarm: &AlarmToml,
    segment: &Spanned<String>,
    station: u8,
    segments: &[SegmentToml],
) -> Result<Condition, Located> {
    let names = || segments.iter().map(|segment| segment.name.get_ref().as_str());
    let name = segment.get_ref();
    if !names().any(|known| known == name) {
        let suggestion = closest(name, names()).map(str::to_owned);
        return Err(Located::new(segment.span(), ConfigProblem::UnknownSegment { name: name.clone(), suggestion }));
    }
    let given = [
        (&alarm.repetitions, BusQuantity::Repetitions),
        (&alarm.lost, BusQuantity::Lost),
        (&alarm.damaged, BusQuantity::Damaged),
    ];
    let given: Vec<_> = given.into_iter().filter_map(|(limit, quantity)| Some((limit.as_ref()?, quantity))).collect();
    let others = [
        alarm.above.is_some(),
        alarm.below.is_some(),
        alarm.rise.is_some(),
        alarm.reset.is_some(),
        alarm.hysteresis.is_some(),
        alarm.window.is_some(),
    ];
    let ([(limit, quantity)], false) = (&given[..], others.contains(&true)) else {
        return Err(Located::new(alarm.name.span(), ConfigProblem::AlarmSubject(alarm.name.get_ref().clone())));
    };
    let limit = number(*limit.get_ref(), limit.span(), "percent of the requests", NumberRange::AboveZero(100.0))?;
    Ok(Condition::BusRate { segment: name.clone(), station, quantity: *quantity, limit })
}

/// The gauge of this name, or the gauge and the channel that `gauge.N` names.
pub fn series(name: &Spanned<String>, segments: &[SegmentToml]) -> Result<Series, Located> {
    let series = name.get_ref();
    let channel = series.rsplit_once('.').filter(|(_, channel)| channel.parse::<u8>().is_ok());
    let found = |wanted: &str| gauge_names(segments).find(|known| *known == wanted);
    let gauge = found(series).or_else(|| found(channel?.0));
    let unknown = || {
        let suggestion = closest(channel.map_or(series.as_str(), |(gauge, _)| gauge), gauge_names(segments));
        let suggestion = suggestion.map(str::to_owned);
        let known = gauge_names(segments).map(str::to_owned).collect();
        Located::new(name.span(), ConfigProblem::UnknownGauge { name: series.clone(), suggestion, known })
    };
    Ok(Series { gauge: gauge.ok_or_else(unknown)?.to_owned(), name: series.clone() })
}

/// A limit that no reading of the gauge can be beyond is an error: the alarm could never be raised. The range of a controller
/// depends on its gauges, which the file does not name.
fn check_range(alarm: &AlarmToml, series: &Series, segments: &[SegmentToml]) -> Result<(), Located> {
    let mut gauges = segments.iter().flat_map(|segment| &segment.gauge);
    let model = gauges.find(|gauge| *gauge.name.get_ref() == series.gauge).and_then(|gauge| gauge.model);
    let Some(model) = model.filter(|model| open_instances(model).is_empty() && !model.parts.is_empty()) else {
        return Ok(());
    };
    let ends = model.parts.iter().map(|spec| (spec.limits.under_pa, spec.limits.over_pa));
    let (lowest, highest) =
        ends.fold((f64::MAX, 0.0_f64), |(low, high), (under, over)| (low.min(under), high.max(over)));
    let is_above = |limit: &&Spanned<Parsed<Pressure>>| limit.get_ref().0.pa() > highest * (1.0 + ROUNDING);
    let is_below = |limit: &&Spanned<Parsed<Pressure>>| {
        let pa = limit.get_ref().0.pa();
        pa > 0.0 && pa < lowest * (1.0 - ROUNDING)
    };
    let undecidable = alarm.above.as_ref().filter(is_above).or_else(|| alarm.below.as_ref().filter(is_below));
    undecidable.map_or(Ok(()), |limit| {
        let problem = ConfigProblem::LimitBeyondRange {
            limit: limit.get_ref().0.to_string(),
            device: model.name,
            lowest: Pressure::from_pa(lowest).to_string(),
            highest: Pressure::from_pa(highest).to_string(),
        };
        Err(Located::new(limit.span(), problem))
    })
}

fn condition(alarm: &AlarmToml, series: Series) -> Result<Condition, Located> {
    let AlarmToml { above, below, rise, reset, hysteresis, window, .. } = alarm;
    if let Some(window) = window.as_ref().filter(|_| rise.is_none()) {
        return Err(Located::new(window.span(), ConfigProblem::WindowWithoutRise));
    }
    match (above, below, rise) {
        (Some(limit), None, None) => {
            let reset = limit_reset(limit, reset.as_ref(), hysteresis.as_ref(), -1.0)?;
            Ok(Condition::Above { series, limit: limit.get_ref().0.pa(), reset })
        }
        (None, Some(limit), None) => {
            let reset = limit_reset(limit, reset.as_ref(), hysteresis.as_ref(), 1.0)?;
            Ok(Condition::Below { series, limit: limit.get_ref().0.pa(), reset })
        }
        (None, None, Some(limit)) => rising(series, limit, reset.as_ref(), hysteresis.as_ref(), window.as_ref()),
        _ => Err(Located::new(alarm.name.span(), ConfigProblem::OneCondition(alarm.name.get_ref().clone()))),
    }
}

/// The pressure in Pa at which a limit alarm returns to normal. `side` is -1 if that is below the limit, 1 if it is above.
fn limit_reset(
    limit: &Spanned<Parsed<Pressure>>,
    reset: Option<&Spanned<Parsed<Pressure>>>,
    hysteresis: Option<&Spanned<f64>>,
    side: f64,
) -> Result<f64, Located> {
    let (limit_span, limit) = (limit.span(), limit.get_ref().0);
    if limit.pa() <= 0.0 {
        return Err(Located::new(limit_span, ConfigProblem::LimitNotPositive(limit.to_string())));
    }
    match (reset, hysteresis) {
        (Some(reset), Some(_)) => Err(Located::new(reset.span(), ConfigProblem::ResetAndHysteresis)),
        (Some(given), None) => {
            let reset = given.get_ref().0;
            let beyond = (reset.pa() - limit.pa()) * side < 0.0;
            if !beyond {
                return Ok(reset.pa());
            }
            let side = if side < 0.0 { "above" } else { "below" };
            let (limit, reset) = (limit.to_string(), reset.to_string());
            Err(Located::new(given.span(), ConfigProblem::ResetBeyondLimit { side, limit, reset }))
        }
        (None, decades) => {
            let quantity = "a hysteresis in decades";
            let decades = decades.map_or(Ok(HYSTERESIS), |given| in_range(given, quantity, HYSTERESIS_RANGE))?;
            Ok(limit.pa() * 10_f64.powf(side * decades))
        }
    }
}

fn rising(
    series: Series,
    limit: &Spanned<f64>,
    reset: Option<&Spanned<Parsed<Pressure>>>,
    hysteresis: Option<&Spanned<f64>>,
    window: Option<&Spanned<Parsed<TimeSpan>>>,
) -> Result<Condition, Located> {
    if let Some(reset) = reset {
        return Err(Located::new(reset.span(), ConfigProblem::ResetWithRise));
    }
    let rate = in_range(limit, "decades per minute", NumberRange::AboveZero(MAX_DECADES))?;
    let quantity = "a hysteresis in decades per minute";
    // chosen: by default the alarm returns to normal at half the rate.
    let hysteresis = hysteresis.map_or(Ok(rate / 2.0), |given| in_range(given, quantity, HYSTERESIS_RANGE))?;
    let window = match window {
        Some(given) if !WINDOW_RANGE.contains(&*given.get_ref().0) => {
            return Err(Located::new(given.span(), ConfigProblem::Window(given.get_ref().0)));
        }
        Some(given) => given.get_ref().0.into(),
        None => WINDOW,
    };
    Ok(Condition::Rise { series, limit: rate, reset: rate - hysteresis, window })
}

fn in_range(given: &Spanned<f64>, quantity: &'static str, range: NumberRange) -> Result<f64, Located> {
    number(*given.get_ref(), given.span(), quantity, range)
}
