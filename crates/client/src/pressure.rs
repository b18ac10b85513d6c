//! A pressure with its units.

use profivac_devices::model::Pascal;
use std::fmt;
use std::str::FromStr;

/// The units and their size in mbar. Case does not matter.
const UNITS: [(&str, f64); 8] = [
    ("mbar", 1.0),
    ("Pa", 0.01),
    ("hPa", 1.0),
    ("kPa", 10.0),
    ("bar", 1e3),
    ("Torr", MBAR_PER_TORR),
    ("mTorr", MBAR_PER_TORR / 1e3),
    ("micron", MBAR_PER_TORR / 1e3),
];

const MBAR_PER_TORR: f64 = 1013.25 / 760.0;

/// A pressure. Stored in mbar, so that a text in mbar is printed unchanged. A parsed pressure is 0 or more and finite; the
/// constructors take every number.
///
/// ```
/// use profivac_client::Pressure;
///
/// let pressure: Pressure = "1e-3 mbar".parse()?;
/// assert_eq!(pressure.pa(), 0.1);
/// assert_eq!(pressure.to_string(), "1e-3 mbar");
/// assert_eq!(Pressure::from_pa(100.0), Pressure::from_mbar(1.0));
/// assert_eq!(Pressure::from_torr(1.0).torr(), 1.0);
/// assert!("1e-3".parse::<Pressure>().is_err(), "a pressure has a unit");
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq, PartialOrd)]
pub struct Pressure {
    mbar: f64,
}

/// A text that is no pressure.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum PressureError {
    /// The text has no number, or one that no pressure can have.
    #[error("expected a pressure like '1e-3 mbar', got {0:?}")]
    Number(String),
    /// The text has no unit, or an unknown one.
    #[error("expected a unit, one of {expected}, got {}", got(received), expected = units())]
    Unit {
        /// The text after the number.
        received: String,
    },
}

/// The text after the number, if there is any.
fn got(received: &str) -> String {
    if received.is_empty() { "none; '1e-3 mbar' has one".to_owned() } else { format!("{received:?}") }
}

impl Pressure {
    /// A pressure in mbar.
    #[must_use]
    pub const fn from_mbar(mbar: f64) -> Self {
        Self { mbar }
    }

    /// A pressure in Pa.
    #[must_use]
    pub const fn from_pa(pa: f64) -> Self {
        Self { mbar: pa / 100.0 }
    }

    /// A pressure in Torr.
    #[must_use]
    pub const fn from_torr(torr: f64) -> Self {
        Self { mbar: torr * MBAR_PER_TORR }
    }

    /// In Torr.
    #[must_use]
    pub const fn torr(self) -> f64 {
        self.mbar / MBAR_PER_TORR
    }

    /// In Pa.
    #[must_use]
    pub const fn pa(self) -> f64 {
        self.mbar * 100.0
    }

    /// In mbar.
    #[must_use]
    pub const fn mbar(self) -> f64 {
        self.mbar
    }
}

impl From<Pascal> for Pressure {
    fn from(pressure: Pascal) -> Self {
        Self::from_pa(pressure.0)
    }
}

impl FromStr for Pressure {
    type Err = PressureError;

    fn from_str(text: &str) -> Result<Self, PressureError> {
        let text = text.trim();
        let (number, unit) = split(text);
        let wrong = || PressureError::Number(text.to_owned());
        let value: f64 = number.parse().map_err(|_| wrong())?;
        let (_, mbar) = UNITS
            .iter()
            .find(|(name, _)| name.eq_ignore_ascii_case(unit))
            .ok_or_else(|| PressureError::Unit { received: unit.to_owned() })?;
        let mbar = value * mbar;
        if mbar.is_finite() && mbar >= 0.0 { Ok(Self { mbar }) } else { Err(wrong()) }
    }
}

impl fmt::Display for Pressure {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{:e} mbar", self.mbar())
    }
}

/// Splits `1e-3 mbar` or `1e-3mbar` into number and unit. A unit contains no digit, so it begins after the last one.
fn split(text: &str) -> (&str, &str) {
    let end = text.rfind(|letter: char| letter.is_ascii_digit() || letter == '.').map_or(0, |last| last + 1);
    let (number, unit) = text.split_at(end);
    (number, unit.trim_start())
}

fn units() -> String {
    UNITS.map(|(name, _)| name).join(", ")
}

#[cfg(test)]
mod tests {
    use super::*;

    fn pa(text: &str) -> f64 {
        text.parse::<Pressure>().unwrap().pa()
    }

    #[test]
    fn every_unit_is_parsed() {
        for (text, expected) in [
            ("1e-3 mbar", 0.1),
            ("1013.25mbar", 101_325.0),
            ("5 Pa", 5.0),
            ("2 hpa", 200.0),
            ("3 kPa", 3e3),
            ("1 bar", 1e5),
            ("760 Torr", 101_325.0),
            ("760 MTORR", 101.325),
            (" 760e3 micron ", 101_325.0),
            ("5.e-6 mbar", 5e-4),
            ("0 Pa", 0.0),
        ] {
            let relative = (pa(text) - expected).abs() / expected.max(1e-30);
            assert!(relative < 1e-12, "{text}: {}", pa(text));
        }
    }

    #[test]
    fn a_text_that_is_no_pressure_is_an_error_that_shows_it() {
        for text in ["", "mbar", "-1 mbar", "1e400 mbar", "nan mbar", "one mbar", "1e-3.2.1 mbar"] {
            assert_eq!(text.parse::<Pressure>(), Err(PressureError::Number(text.to_owned())), "{text}");
        }
        for (text, unit) in [("1e-3", ""), ("1 psi", "psi"), ("1 m bar", "m bar")] {
            assert_eq!(text.parse::<Pressure>(), Err(PressureError::Unit { received: unit.to_owned() }), "{text}");
        }
        let sentence = "1 psi".parse::<Pressure>().unwrap_err().to_string();
        assert_eq!(sentence, "expected a unit, one of mbar, Pa, hPa, kPa, bar, Torr, mTorr, micron, got \"psi\"");
    }

    #[test]
    fn a_pressure_is_displayed_in_mbar() {
        assert_eq!(Pressure::from_mbar(5e-6).to_string(), "5e-6 mbar");
    }
}
