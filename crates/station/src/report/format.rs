//! Numbers, times and names as text. All text from a file passes through [`escape`].

use jiff::Timestamp;
use jiff::tz::TimeZone;
use profivac_recorder::Micros;
use serde::Serialize;
use std::fmt::Write;
use std::str::FromStr;

/// The unit of pressures on a page.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
pub enum Unit {
    /// Millibar.
    #[default]
    #[serde(rename = "mbar")]
    Mbar,
    /// Pascal.
    Pa,
    /// Hectopascal.
    #[serde(rename = "hPa")]
    HPa,
    /// Torr.
    Torr,
    /// A millitorr.
    #[serde(rename = "micron")]
    Micron,
}

impl Unit {
    /// All units.
    pub const ALL: [Self; 5] = [Self::Mbar, Self::Pa, Self::HPa, Self::Torr, Self::Micron];

    /// The symbol of the unit.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Mbar => "mbar",
            Self::Pa => "Pa",
            Self::HPa => "hPa",
            Self::Torr => "Torr",
            Self::Micron => "micron",
        }
    }

    /// The unit in Pa.
    #[must_use]
    pub const fn pa(self) -> f64 {
        match self {
            Self::Mbar | Self::HPa => 100.0,
            Self::Pa => 1.0,
            Self::Torr => 101_325.0 / 760.0,
            Self::Micron => 101.325 / 760.0,
        }
    }
}

/// A text that is not a unit.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("expected a unit, one of {}, got {found:?}", Unit::ALL.map(Unit::name).join(", "))]
pub struct UnknownUnit {
    /// The text.
    pub found: String,
}

impl FromStr for Unit {
    type Err = UnknownUnit;

    fn from_str(text: &str) -> Result<Self, UnknownUnit> {
        let unit = Self::ALL.into_iter().find(|unit| unit.name().eq_ignore_ascii_case(text));
        unit.ok_or_else(|| UnknownUnit { found: text.to_owned() })
    }
}

/// Escapes text for HTML and replaces control characters and characters that change the writing direction.
#[must_use]
pub fn escape(text: &str) -> String {
    text.chars().fold(String::with_capacity(text.len()), |mut safe, letter| {
        match letter {
            '&' => safe.push_str("&amp;"),
            '<' => safe.push_str("&lt;"),
            '>' => safe.push_str("&gt;"),
            '"' => safe.push_str("&quot;"),
            '\'' => safe.push_str("&#39;"),
            '\u{200e}' | '\u{200f}' | '\u{202a}'..='\u{202e}' | '\u{2066}'..='\u{2069}' => safe.push('\u{fffd}'),
            control if control.is_control() => safe.push('\u{fffd}'),
            other => safe.push(other),
        }
        safe
    })
}

/// A pressure with two digits, three above 100: gauges are not more accurate.
#[must_use]
pub fn pressure(pa: f64, unit: Unit) -> String {
    number(pa / unit.pa())
}

/// A pressure with its unit.
#[must_use]
pub fn with_unit(pa: f64, unit: Unit) -> String {
    format!("{}\u{a0}{}", pressure(pa, unit), unit.name())
}

/// A number with two digits, three from 100 on.
#[must_use]
pub fn number(value: f64) -> String {
    let size = value.abs();
    match size {
        100.0..10_000.0 => {
            let step = if size < 1_000.0 { 1.0 } else { 10.0 };
            format!("{:.0}", (value / step).round() * step)
        }
        9.95..100.0 => format!("{value:.0}"),
        0.995..9.95 => format!("{value:.1}"),
        0.0995..0.995 => format!("{value:.2}"),
        0.00995..0.0995 => format!("{value:.3}"),
        _ => power(&format!("{value:.1e}")),
    }
}

/// A requested pressure as it was written, or with three digits if it was written in another unit.
#[must_use]
pub fn target_pressure(pa: f64, unit: Unit) -> String {
    let value = pa / unit.pa();
    // Rounding to twelve digits removes the error of the conversion.
    let whole = format!("{value:.11e}").parse().unwrap_or(value);
    let rounded = format!("{value:.2e}").parse().unwrap_or(value);
    let shortest = if format!("{whole:e}").len() > LONGEST { rounded } else { whole };
    if (0.01..10_000.0).contains(&shortest) { format!("{shortest}") } else { power(&format!("{shortest:e}")) }
}

/// A longer number than `1.25e-12` is the result of a conversion.
const LONGEST: usize = 8;

/// `1.5e-7` as 1.5 × 10⁻⁷, `1e-7` as 10⁻⁷.
fn power(scientific: &str) -> String {
    let Some((mantissa, exponent)) = scientific.split_once('e') else { return scientific.to_owned() };
    let mantissa = if mantissa == "1" { String::new() } else { format!("{mantissa}\u{a0}×\u{a0}") };
    format!("{mantissa}10{}", superscript(exponent))
}

fn superscript(exponent: &str) -> String {
    let raised = |letter| match letter {
        '-' => '⁻',
        '0' => '⁰',
        '1' => '¹',
        '2' => '²',
        '3' => '³',
        '4' => '⁴',
        '5' => '⁵',
        '6' => '⁶',
        '7' => '⁷',
        '8' => '⁸',
        '9' => '⁹',
        other => other,
    };
    exponent.chars().map(raised).collect()
}

/// The label of a power of ten.
#[must_use]
pub fn decade(exponent: i32) -> String {
    match exponent {
        -2..=3 => format!("{}", 10_f64.powi(exponent)),
        _ => format!("10{}", superscript(&exponent.to_string())),
    }
}

/// A duration in at most two units.
#[must_use]
pub fn duration(seconds: f64) -> String {
    let whole = seconds.round() as i64;
    match seconds {
        // Durations are given to a tenth of a second; time constants may be shorter.
        0.000_1..0.995 => format!("{}\u{a0}s", number(seconds)),
        ..99.95 => format!("{seconds:.1}\u{a0}s"),
        ..3_599.5 => two(whole / 60, "min", whole % 60, "s"),
        ..86_370.0 => {
            let minutes = (whole + 30) / 60;
            two(minutes / 60, "h", minutes % 60, "min")
        }
        _ => {
            let hours = (whole + 1_800) / 3_600;
            two(hours / 24, "d", hours % 24, "h")
        }
    }
}

fn two(large: i64, large_unit: &str, small: i64, small_unit: &str) -> String {
    let mut text = format!("{large}\u{a0}{large_unit}");
    if small > 0 {
        // Writing to a String cannot fail.
        write!(text, " {small}\u{a0}{small_unit}").ok();
    }
    text
}

/// A time as a timestamp.
#[must_use]
pub fn timestamp(at: Micros) -> Timestamp {
    Timestamp::from_microsecond(at.0).unwrap_or_default()
}

/// A time in a time zone, to the second: `2026-11-21 14:00:00 CET`.
#[must_use]
pub fn moment(at: Micros, zone: &TimeZone) -> String {
    timestamp(at).to_zoned(zone.clone()).strftime("%Y-%m-%d %H:%M:%S %Z").to_string()
}

/// The time of day in a time zone, with the date if it differs from that of `first`.
#[must_use]
pub fn time_of_day(at: Micros, first: Micros, zone: &TimeZone) -> String {
    let [at, first] = [at, first].map(|at| timestamp(at).to_zoned(zone.clone()));
    let pattern = if at.date() == first.date() { "%H:%M:%S" } else { "%d %b %H:%M:%S" };
    at.strftime(pattern).to_string()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_have_two_or_three_digits() {
        let shown = [1013.25, 999.6, 42.4, 9.96, 0.123, 0.0123, 1.234e-7, 5e12, 0.0].map(number);
        let expected = [
            "1010",
            "1000",
            "42",
            "10",
            "0.12",
            "0.012",
            "1.2\u{a0}×\u{a0}10⁻⁷",
            "5.0\u{a0}×\u{a0}10¹²",
            "0.0\u{a0}×\u{a0}10⁰",
        ];
        assert_eq!(shown, expected);
    }

    #[test]
    fn a_requested_pressure_is_shown_as_it_was_written() {
        let torr = 101_325.0 / 760.0;
        let shown =
            [(0.1, Unit::Mbar), (1e-5, Unit::Mbar), (2.5e-4, Unit::Mbar), (torr, Unit::Torr), (5e-4, Unit::Torr)];
        assert_eq!(
            shown.map(|(pa, unit)| target_pressure(pa, unit)),
            ["10⁻³", "10⁻⁷", "2.5\u{a0}×\u{a0}10⁻⁶", "1", "3.75\u{a0}×\u{a0}10⁻⁶"]
        );
    }

    #[test]
    fn a_duration_has_at_most_two_units() {
        let shown = [0.04, 13.84, 99.97, 725.0, 3_599.6, 11_520.0, 86_399.0, 187_300.0].map(duration);
        let plain = shown.map(|text| text.replace('\u{a0}', " "));
        assert_eq!(plain, ["0.040 s", "13.8 s", "1 min 40 s", "12 min 5 s", "1 h", "3 h 12 min", "1 d", "2 d 4 h"]);
    }

    #[test]
    fn escaped_text_is_never_markup() {
        assert_eq!(
            escape("<b onload='x' id=\"y\">&\u{202e}\n"),
            "&lt;b onload=&#39;x&#39; id=&quot;y&quot;&gt;&amp;\u{fffd}\u{fffd}"
        );
    }

    #[test]
    fn a_moment_has_its_zone_and_a_time_of_day_its_date() {
        let zone = TimeZone::fixed(jiff::tz::offset(1));
        let noon = Micros(1_795_262_400 * Micros::SECOND);
        assert_eq!(moment(noon, &TimeZone::UTC), "2026-11-21 12:00:00 UTC");
        assert_eq!(moment(noon, &zone), "2026-11-21 13:00:00 +01");
        let late = Micros(noon.0 + 12 * 3_600 * Micros::SECOND);
        assert_eq!([noon, late].map(|at| time_of_day(at, noon, &zone)), ["13:00:00", "22 Nov 01:00:00"]);
    }
}
