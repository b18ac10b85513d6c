//! Lengths of time, times of the day and addresses as a user writes them: `200 ms`, `7 days`; `03:00`; `127.0.0.1:8080`.

use jiff::civil::{Time, time};
use jiff::{SignedDuration, Span, SpanRelativeTo};
use std::fmt;
use std::net::{IpAddr, SocketAddr};
use std::ops::Deref;
use std::str::FromStr;
use std::time::Duration;

/// The number of seconds in a day of 24 hours.
const DAY: u64 = 86_400;

/// A length of time. A day has 24 hours, a week seven days; months and years have no fixed length and are refused.
///
/// ```
/// use profivac_config::time_span::TimeSpan;
///
/// assert_eq!("1w 2d".parse::<TimeSpan>()?.as_secs(), 9 * 86_400);
/// assert_eq!("200 ms".parse::<TimeSpan>()?.to_string(), "200ms");
/// # Ok::<(), profivac_config::time_span::TimeSpanError>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct TimeSpan(pub Duration);

/// A text that is no length of time.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("expected a time with its unit like \"200 ms\", \"10 min\" or \"7 days\", got {0:?}")]
pub struct TimeSpanError(String);

impl FromStr for TimeSpan {
    type Err = TimeSpanError;

    fn from_str(text: &str) -> Result<Self, TimeSpanError> {
        let time = text.parse::<Span>().ok().filter(|span| span.get_years() == 0 && span.get_months() == 0);
        let time = time.and_then(|span| span.to_duration(SpanRelativeTo::days_are_24_hours()).ok());
        let time = time.and_then(|time| Duration::try_from(time).ok());
        time.map(Self).ok_or_else(|| TimeSpanError(text.to_owned()))
    }
}

impl Deref for TimeSpan {
    type Target = Duration;

    fn deref(&self) -> &Duration {
        &self.0
    }
}

impl From<TimeSpan> for Duration {
    fn from(span: TimeSpan) -> Self {
        span.0
    }
}

impl fmt::Display for TimeSpan {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let days = self.0.as_secs() / DAY;
        let rest = self.0.saturating_sub(Duration::from_secs(days.saturating_mul(DAY)));
        match (days, SignedDuration::try_from(rest)) {
            (0, Ok(rest)) => write!(f, "{rest:#}"),
            (days, Ok(rest)) if !rest.is_zero() => write!(f, "{days}d {rest:#}"),
            (days, _) => write!(f, "{days}d"),
        }
    }
}

/// A time of the day for something that is done once a day, or `off`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct DailyTime(pub Option<Time>);

/// A text that is no time of the day.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("expected a time of the day like \"03:00\", or \"off\", got {0:?}")]
pub struct DailyTimeError(String);

impl Default for DailyTime {
    /// chosen: at night.
    fn default() -> Self {
        Self(Some(time(3, 0, 0, 0)))
    }
}

impl FromStr for DailyTime {
    type Err = DailyTimeError;

    fn from_str(text: &str) -> Result<Self, DailyTimeError> {
        match text {
            "off" => Ok(Self(None)),
            _ => {
                Time::strptime("%H:%M", text).map(|time| Self(Some(time))).map_err(|_| DailyTimeError(text.to_owned()))
            }
        }
    }
}

/// An address with a port at which a server listens.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Listen(pub SocketAddr);

/// A text that is no address with a port.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("expected an address with a port like {example:?}, got {found:?}")]
pub struct ListenError {
    example: String,
    found: String,
}

impl FromStr for Listen {
    type Err = ListenError;

    fn from_str(text: &str) -> Result<Self, ListenError> {
        let example = || match text.parse::<IpAddr>() {
            Ok(address) => SocketAddr::from((address, 8080)).to_string(),
            Err(_) => "127.0.0.1:8080".to_owned(),
        };
        text.parse().map(Self).map_err(|_| ListenError { example: example(), found: text.to_owned() })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_length_of_time_has_days_and_weeks_and_always_a_unit() {
        for (text, seconds, shown) in [
            ("0s", 0.0, "0s"),
            ("100 ms", 0.1, "100ms"),
            ("90 min", 5400.0, "1h 30m"),
            ("7d", 604_800.0, "7d"),
            ("7 days", 604_800.0, "7d"),
            ("1 week", 604_800.0, "7d"),
            ("2w", 1_209_600.0, "14d"),
            ("1d 1h", 90_000.0, "1d 1h"),
            ("1 day", 86_400.0, "1d"),
            ("36525days", 3_155_760_000.0, "36525d"),
        ] {
            let span: TimeSpan = text.parse().unwrap();
            assert_eq!((span.as_secs_f64(), span.to_string().as_str()), (seconds, shown), "{text}");
        }
        for text in ["", "100", "often", "-1 day", "1 day ago", "1 month", "1 year", "7 d d", "99999999999999 days"] {
            let error = text.parse::<TimeSpan>().unwrap_err().to_string();
            assert!(error.starts_with("expected a time with its unit like"), "{text}: {error}");
        }
    }

    #[test]
    fn a_time_of_the_day_has_hours_and_minutes_or_is_off() {
        for (text, expected) in [("03:00", Some(time(3, 0, 0, 0))), ("23:59", Some(time(23, 59, 0, 0))), ("off", None)]
        {
            assert_eq!(text.parse::<DailyTime>().unwrap().0, expected, "{text}");
        }
        for text in ["", "3", "24:00", "3 am", "03:00:00", "never"] {
            let error = text.parse::<DailyTime>().unwrap_err().to_string();
            assert_eq!(error, format!("expected a time of the day like \"03:00\", or \"off\", got {text:?}"));
        }
    }

    #[test]
    fn an_address_without_a_port_shows_itself_with_one() {
        assert_eq!("[::1]:80".parse::<Listen>().unwrap().0.port(), 80);
        for (text, example) in [("127.0.0.1", "127.0.0.1:8080"), ("::1", "[::1]:8080"), ("localhost", "127.0.0.1:8080")]
        {
            let expected = format!("expected an address with a port like {example:?}, got {text:?}");
            assert_eq!(text.parse::<Listen>().unwrap_err().to_string(), expected);
        }
    }
}
