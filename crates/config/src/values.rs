//! Values that several tables have: delays, priorities, octets, when a webhook is notified.

use super::error::{ConfigProblem, Located};
use super::number_range::NumberRange;
use crate::time_span::TimeSpan;
use jiff::civil::Time;
use jiff::tz::TimeZone;
use profivac_host::text_file::Parsed;
use profivac_station::alarm::{Priority, QuietHours};
use std::ops::RangeInclusive;
use std::time::Duration;
use toml::Spanned;

/// The number `found` of a quantity, if it is in its range.
pub fn number(
    found: f64,
    span: std::ops::Range<usize>,
    quantity: &'static str,
    range: NumberRange,
) -> Result<f64, Located> {
    if range.contains(found) {
        Ok(found)
    } else {
        Err(Located::new(span, ConfigProblem::OutOfRange { quantity, range, found }))
    }
}

/// The longest delay. chosen.
const MAX_DELAY: Duration = Duration::from_secs(3600);

/// A delay of at most an hour, or its default.
pub fn delay(given: Option<&Spanned<Parsed<TimeSpan>>>, default: Duration) -> Result<Duration, Located> {
    match given {
        Some(given) if Duration::from(given.get_ref().0) > MAX_DELAY => {
            Err(Located::new(given.span(), ConfigProblem::Delay(given.get_ref().0)))
        }
        Some(given) => Ok(given.get_ref().0.into()),
        None => Ok(default),
    }
}

/// The shortest and the longest time after which a webhook is told of an alarm that no user acknowledges. chosen.
const UNACKNOWLEDGED_RANGE: RangeInclusive<Duration> = Duration::from_secs(1)..=Duration::from_secs(86_400);

/// The time after which a webhook is told of an alarm that no user acknowledges; zero without the key.
pub fn unacknowledged_after(given: Option<&Spanned<Parsed<TimeSpan>>>) -> Result<Duration, Located> {
    let Some(given) = given else { return Ok(Duration::ZERO) };
    let time = given.get_ref().0;
    if UNACKNOWLEDGED_RANGE.contains(&*time) {
        return Ok(time.into());
    }
    Err(Located::new(given.span(), ConfigProblem::UnacknowledgedAfter(time)))
}

/// Quiet hours such as `22:00-06:00`, in the time zone of the computer.
pub fn quiet_hours(given: &Spanned<String>) -> Result<QuietHours, Located> {
    let time = |text: &str| Time::strptime("%H:%M", text.trim()).ok();
    let ends = given.get_ref().split_once('-').and_then(|(from, to)| Some((time(from)?, time(to)?)));
    let wrong = || Located::new(given.span(), ConfigProblem::QuietHours(given.get_ref().clone()));
    let (from, to) = ends.filter(|(from, to)| from != to).ok_or_else(wrong)?;
    Ok(QuietHours { from, to, zone: TimeZone::system() })
}

/// A priority, or its default.
pub fn priority(given: Option<&Spanned<String>>, default: Priority) -> Result<Priority, Located> {
    given.map_or(Ok(default), |given| priority_word(given, false))
}

/// A priority; `None` for `off`.
pub fn priority_or_off(given: Option<&Spanned<String>>, default: Priority) -> Result<Option<Priority>, Located> {
    match given {
        Some(given) if given.get_ref() == "off" => Ok(None),
        Some(given) => priority_word(given, true).map(Some),
        None => Ok(Some(default)),
    }
}

fn priority_word(given: &Spanned<String>, may_be_off: bool) -> Result<Priority, Located> {
    let unknown = || {
        let found = given.get_ref().clone();
        Located::new(given.span(), ConfigProblem::UnknownPriority { found, may_be_off })
    };
    Priority::from_word(given.get_ref()).ok_or_else(unknown)
}

/// Octets in hexadecimal, with or without spaces.
pub fn hex(text: &str) -> Option<Vec<u8>> {
    let digits: Vec<u32> =
        text.chars().filter(|it| !it.is_whitespace()).map(|it| it.to_digit(16)).collect::<Option<_>>()?;
    let octet = |pair: &[u32]| match pair {
        [high, low] => u8::try_from((high << 4) | low).ok(),
        _ => None,
    };
    digits.chunks(2).map(octet).collect()
}
