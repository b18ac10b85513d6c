//! The labels of a gauge: `group`, `tags`, `location`, `calibrated` and `calibration-interval` of `[[segment.gauge]]`.

use super::error::{ConfigProblem, Located, NamedItem};
use super::names;
use super::segments::{GaugeToml, SegmentToml};
use crate::time_span::TimeSpan;
use jiff::ToSpan;
use jiff::civil::Date;
use profivac_station::directory::{Directory, GaugeLabels};
use std::ops::RangeInclusive;
use toml::{Spanned, Value};

/// The most characters of a group or tag. chosen: a filter shows them in one line.
pub const MAX_NAME: usize = 40;

/// The most characters of a location. chosen: a line of the page of a gauge.
const MAX_LOCATION: usize = 120;

/// The most tags of a gauge. chosen: more than a page shows beside a gauge.
const MAX_TAGS: usize = 16;

/// Seconds of a day.
const DAY: u64 = 86_400;

/// The range of a calibration interval, in days: to a century.
const INTERVAL: RangeInclusive<u64> = 1..=36_525;

/// The labels of all gauges.
pub fn directory(segments: &[SegmentToml]) -> Result<Directory, Located> {
    let gauges = segments.iter().flat_map(|segment| &segment.gauge);
    let labelled = gauges.map(|gauge| Ok((gauge.name.get_ref().clone(), labels(gauge)?)));
    let labelled = labelled.collect::<Result<Vec<_>, Located>>()?;
    let gauges = labelled.into_iter().filter(|(_, labels)| *labels != GaugeLabels::default()).collect();
    Ok(Directory { gauges, ..Directory::default() })
}

fn labels(gauge: &GaugeToml) -> Result<GaugeLabels, Located> {
    if let Some(group) = &gauge.group {
        names::check_length(NamedItem::Group, group, MAX_NAME)?;
    }
    if let Some(location) = &gauge.location {
        names::check_length(NamedItem::Location, location, MAX_LOCATION)?;
    }
    names::unique(NamedItem::Tag, gauge.tags.iter())?;
    gauge.tags.iter().try_for_each(|tag| names::check_length(NamedItem::Tag, tag, MAX_NAME))?;
    if let Some(tag) = gauge.tags.get(MAX_TAGS) {
        return Err(Located::new(tag.span(), ConfigProblem::TooManyTags { most: MAX_TAGS, found: gauge.tags.len() }));
    }
    let calibrated = gauge.calibrated.as_ref().map(date).transpose()?;
    Ok(GaugeLabels {
        group: gauge.group.as_ref().map(|group| group.get_ref().clone()),
        tags: gauge.tags.iter().map(|tag| tag.get_ref().clone()).collect(),
        location: gauge.location.as_ref().map(|location| location.get_ref().clone()),
        calibrated: calibrated.map(|date| date.to_string()),
        calibration_due: due(gauge, calibrated)?.map(|date| date.to_string()),
    })
}

/// A day without a time.
fn date(value: &Spanned<Value>) -> Result<Date, Located> {
    let given = value.get_ref();
    let day = given.as_datetime().filter(|given| given.time.is_none()).and_then(|given| given.date);
    let parts = day.and_then(|day| {
        Some((i16::try_from(day.year).ok()?, i8::try_from(day.month).ok()?, i8::try_from(day.day).ok()?))
    });
    parts
        .and_then(|(year, month, day)| Date::new(year, month, day).ok())
        .ok_or_else(|| Located::new(value.span(), ConfigProblem::CalibrationDate(shown(given))))
}

/// A value that is no day, for an error.
fn shown(value: &Value) -> String {
    match value {
        Value::String(text) => format!("{text:?}"),
        Value::Datetime(time) => time.to_string(),
        other => format!("a value of the type {}", other.type_str()),
    }
}

/// The last day on which the calibration is valid.
fn due(gauge: &GaugeToml, calibrated: Option<Date>) -> Result<Option<Date>, Located> {
    let Some(interval) = &gauge.calibration_interval else { return Ok(None) };
    let Some(calibrated) = calibrated else {
        return Err(Located::new(interval.span(), ConfigProblem::IntervalWithoutCalibration));
    };
    let days = interval.get_ref().parse::<TimeSpan>().ok().map(|time| time.as_secs() / DAY);
    let due = days.filter(|days| INTERVAL.contains(days)).and_then(|days| {
        let days = i64::try_from(days).ok()?;
        calibrated.checked_add(days.days()).ok()
    });
    let refused = || Located::new(interval.span(), ConfigProblem::CalibrationInterval(interval.get_ref().clone()));
    due.map(Some).ok_or_else(refused)
}
