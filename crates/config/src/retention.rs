//! `[retention]`: how long rows of the database are kept, in recorded time.
//!
//! ```toml
//! [retention]
//! samples = "730 days"             # the default
//! spans = "1826 days"              # of 10 s; coarser spans are kept without limit
//! events = "1826 days"
//! alarm-history = "unlimited"
//! archive-batches = "1 day"        # batches that the archive has, in case it loses them
//! ```

use super::error::{ConfigProblem, Located};
use crate::time_span::TimeSpan;
use profivac_recorder::Retention;
use serde::Deserialize;
use std::ops::RangeInclusive;
use std::time::Duration;
use toml::Spanned;

/// The range of a retention. chosen: a pump-down takes less than a day, and more than a century is `unlimited`.
const RANGE: RangeInclusive<Duration> = Duration::from_secs(86_400)..=Duration::from_secs(36_525 * 86_400);

/// The word for no limit.
const UNLIMITED: &str = "unlimited";

/// The table `[retention]`.
#[derive(Debug, Default, Deserialize)]
#[serde(deny_unknown_fields, rename_all = "kebab-case")]
pub struct RetentionToml {
    /// Samples: 1 to 36525 days, or `unlimited`. Default: `730 days`.
    samples: Option<Spanned<String>>,
    /// Spans of 10 s: 1 to 36525 days, or `unlimited`; longer spans stay. Default: `1826 days`.
    spans: Option<Spanned<String>>,
    /// Events: 1 to 36525 days, or `unlimited`. Default: `1826 days`.
    events: Option<Spanned<String>>,
    /// The history of alarms: 1 to 36525 days, or `unlimited`. Default: `1826 days`.
    alarm_history: Option<Spanned<String>>,
    /// Batches that the database of the archive has, in case it loses them: 1 to 36525 days, or `unlimited`. Default: `1 day`.
    archive_batches: Option<Spanned<String>>,
}

/// The retention of a file.
pub fn retention(given: &RetentionToml) -> Result<Retention, Located> {
    let default = Retention::default();
    let [fine, rest @ ..] = default.spans;
    let spans = kept(given.spans.as_ref(), fine)?;
    let [second, third, fourth] = rest;
    Ok(Retention {
        samples: kept(given.samples.as_ref(), default.samples)?,
        spans: [spans, second, third, fourth],
        events: kept(given.events.as_ref(), default.events)?,
        alarm_history: kept(given.alarm_history.as_ref(), default.alarm_history)?,
        batches: kept(given.archive_batches.as_ref(), default.batches)?,
    })
}

/// A time, or `None` without limit.
fn kept(given: Option<&Spanned<String>>, default: Option<Duration>) -> Result<Option<Duration>, Located> {
    let Some(given) = given else { return Ok(default) };
    let text = given.get_ref();
    if text == UNLIMITED {
        return Ok(None);
    }
    match text.parse::<TimeSpan>() {
        Ok(time) if RANGE.contains(&*time) => Ok(Some(time.0)),
        _ => Err(Located::new(given.span(), ConfigProblem::Retention(text.clone()))),
    }
}
