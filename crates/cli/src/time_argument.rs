//! Times on the command line.

use crate::values::{Expected, ValueError};
use jiff::civil::{Date, DateTime, Time};
use jiff::tz::TimeZone;
use jiff::{Span, Timestamp, ToSpan, Zoned};

/// Checks a time of the command line where clap reads it. The command parses it again with the time of its beginning.
pub fn checked(text: &str) -> Result<String, ValueError> {
    parse_time(text, &Zoned::now()).map(|_| text.to_owned())
}

/// Parses a time, in the zone of `now` unless it has its own.
pub fn parse_time(text: &str, now: &Zoned) -> Result<Timestamp, ValueError> {
    let text = text.trim();
    let wrong = || Expected::Time.but_found(text);
    if let Some(ago) = text.strip_prefix('-') {
        // A day before a change of the clocks has 23 or 25 hours: the same time of that day is meant.
        let ago = ago.trim().parse::<Span>().ok().filter(|ago| !ago.is_negative()).ok_or_else(wrong)?;
        return now.checked_sub(ago).map(|time| time.timestamp()).map_err(|_| wrong());
    }
    let today = now.date();
    let civil = match text.to_lowercase().as_str() {
        "now" => return Ok(now.timestamp()),
        "today" => today.to_datetime(Time::midnight()),
        "yesterday" => today.checked_sub(1.day()).map_err(|_| wrong())?.to_datetime(Time::midnight()),
        _ => match text.parse::<Timestamp>() {
            Ok(timestamp) => return Ok(timestamp),
            Err(_) => civil(text, today).ok_or_else(wrong)?,
        },
    };
    in_zone(civil, now.time_zone()).ok_or_else(wrong)
}

/// A date and a time, a date, or a time of today.
fn civil(text: &str, today: Date) -> Option<DateTime> {
    // A date alone means its midnight.
    let written = text.parse::<DateTime>().ok();
    written.or_else(|| text.parse::<Time>().ok().map(|time| today.to_datetime(time)))
}

fn in_zone(civil: DateTime, zone: &TimeZone) -> Option<Timestamp> {
    civil.to_zoned(zone.clone()).ok().map(|zoned| zoned.timestamp())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn read(text: &str) -> Result<String, ValueError> {
        // Two hours before UTC, so that today is not the day in UTC.
        let zone = TimeZone::fixed(jiff::tz::offset(-2));
        let now = "2026-11-22T01:30:00Z".parse::<Timestamp>().unwrap().to_zoned(zone);
        parse_time(text, &now).map(|moment| moment.to_string())
    }

    #[test]
    fn times_are_parsed_in_every_form() {
        for (text, expected) in [
            ("2026-11-21T13:00:00Z", "2026-11-21T13:00:00Z"),
            ("2026-11-21T13:00:00+01:00", "2026-11-21T12:00:00Z"),
            ("2026-11-21 14:00", "2026-11-21T16:00:00Z"),
            ("2026-11-21T14:00:05", "2026-11-21T16:00:05Z"),
            ("2026-11-21", "2026-11-21T02:00:00Z"),
            ("14:00", "2026-11-21T16:00:00Z"),
            ("today", "2026-11-21T02:00:00Z"),
            ("Yesterday", "2026-11-20T02:00:00Z"),
            ("now", "2026-11-22T01:30:00Z"),
            ("-2h", "2026-11-21T23:30:00Z"),
            ("-90 min", "2026-11-22T00:00:00Z"),
            ("-1h30m", "2026-11-22T00:00:00Z"),
            ("-7d", "2026-11-15T01:30:00Z"),
            ("-2 weeks", "2026-11-08T01:30:00Z"),
            ("-1d 12h", "2026-11-20T13:30:00Z"),
        ] {
            assert_eq!(read(text).as_deref(), Ok(expected), "{text}");
        }
    }

    #[test]
    fn the_error_for_a_wrong_time_shows_examples() {
        for text in ["", "soon", "-", "-2", "--2h", "-2h ago", "-7 dys", "2026-13-01", "25:00", "2026-11-21 14"] {
            let read = read(text);
            if text == "2026-11-21 14" {
                // An hour without minutes is also a time.
                assert_eq!(read.as_deref(), Ok("2026-11-21T16:00:00Z"));
                continue;
            }
            let error = read.unwrap_err().to_string();
            assert!(error.starts_with("expected a time like"), "{text}: {error}");
        }
    }
}
