//! Moments as people write them.

use jiff::civil::{Date, DateTime, Time};
use jiff::tz::TimeZone;
use jiff::{SignedDuration, Timestamp, ToSpan, Zoned};

/// What a moment may look like.
const EXPECTED: &str =
    "expected a time like '2026-11-21 14:00', 2026-11-21, 14:00, yesterday, -2h or 2026-11-21T13:00:00Z";

/// The moment that `text` names, in the zone of `now`.
pub fn parse_time(text: &str, now: &Zoned) -> Result<Timestamp, String> {
    let text = text.trim();
    let wrong = || format!("{EXPECTED}, got {text:?}");
    if let Some(ago) = text.strip_prefix('-') {
        let ago: SignedDuration = ago.trim().parse().map_err(|_| wrong())?;
        return now.timestamp().checked_sub(ago).map_err(|_| wrong());
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
    // A date alone is read as its midnight, too.
    let written = text.parse::<DateTime>().ok();
    written.or_else(|| text.parse::<Time>().ok().map(|time| today.to_datetime(time)))
}

fn in_zone(civil: DateTime, zone: &TimeZone) -> Option<Timestamp> {
    civil.to_zoned(zone.clone()).ok().map(|zoned| zoned.timestamp())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn read(text: &str) -> Result<String, String> {
        // Two hours before UTC, so that today is not the day in UTC.
        let zone = TimeZone::fixed(jiff::tz::offset(-2));
        let now = "2026-11-22T01:30:00Z".parse::<Timestamp>().unwrap().to_zoned(zone);
        parse_time(text, &now).map(|moment| moment.to_string())
    }

    #[test]
    fn moments_are_read_as_people_write_them() {
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
        ] {
            assert_eq!(read(text).as_deref(), Ok(expected), "{text}");
        }
    }

    #[test]
    fn what_is_no_moment_is_told_with_what_would_be() {
        for text in ["", "soon", "-", "-2", "2026-13-01", "25:00", "2026-11-21 14"] {
            let told = read(text);
            if text == "2026-11-21 14" {
                // An hour without minutes is a time, too.
                assert_eq!(told.as_deref(), Ok("2026-11-21T16:00:00Z"));
                continue;
            }
            assert!(told.as_ref().is_err_and(|told| told.starts_with("expected a time like")), "{text}: {told:?}");
        }
    }
}
