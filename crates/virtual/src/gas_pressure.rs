//! The pressure of a gas as users give it: a pressure that a chamber or the air around it can have.

use profivac_client::pressure::{Pressure, PressureError};
use std::str::FromStr;

/// The lowest pressure in Pa: 1e-15 mbar. With no gas at all, a mixture has no composition and a logarithm no value.
///
/// chosen: below every vacuum that was ever measured.
pub const LOWEST_PA: f64 = 1e-13;

/// The highest pressure in Pa: 10 bar.
///
/// chosen: above every chamber with a vacuum gauge.
pub const HIGHEST_PA: f64 = 1e6;

/// A pressure from [`LOWEST_PA`] to [`HIGHEST_PA`].
///
/// ```
/// use profivac_virtual::gas_pressure::GasPressure;
///
/// assert_eq!("5e-6 mbar".parse::<GasPressure>()?.0.mbar(), 5e-6);
/// assert!("0 mbar".parse::<GasPressure>().is_err());
/// # Ok::<(), profivac_virtual::gas_pressure::GasPressureError>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct GasPressure(pub Pressure);

/// A text that is no pressure of a gas.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum GasPressureError {
    /// The text is no pressure.
    #[error(transparent)]
    Text(#[from] PressureError),
    /// The pressure is zero, or beyond every chamber.
    #[error("expected a pressure from 1e-15 mbar to 10 bar, got {0:?}")]
    OutOfRange(String),
}

impl FromStr for GasPressure {
    type Err = GasPressureError;

    fn from_str(text: &str) -> Result<Self, GasPressureError> {
        let pressure: Pressure = text.parse()?;
        // A bound in one unit and a value in another may differ in the last digit.
        let is_possible = (LOWEST_PA * (1.0 - 1e-9)..=HIGHEST_PA * (1.0 + 1e-9)).contains(&pressure.pa());
        is_possible.then_some(Self(pressure)).ok_or_else(|| GasPressureError::OutOfRange(text.trim().to_owned()))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_gas_has_a_pressure_above_zero_and_up_to_ten_bar() {
        for (text, mbar) in [("1e-15 mbar", 1e-15), ("10 bar", 1e4), ("1e-13 Pa", 1e-15), ("1013.25 mbar", 1013.25)] {
            let read = text.parse::<GasPressure>().unwrap().0.mbar();
            assert!((read / mbar - 1.0).abs() < 1e-9, "{text}: {read}");
        }
        for text in ["0 mbar", "0 Pa", "-0 mbar", "1e-16 mbar", "10.1 bar", "1e300 mbar", "1e-320 mbar"] {
            let error = text.parse::<GasPressure>().unwrap_err();
            assert_eq!(error, GasPressureError::OutOfRange(text.to_owned()));
            assert_eq!(
                error.to_string(),
                format!("expected a pressure from 1e-15 mbar to 10 bar, got {text:?}"),
                "{text}"
            );
        }
        for text in ["-1 mbar", "nan mbar", "inf mbar", "1e400 mbar", "1e-3", "low"] {
            assert!(matches!(text.parse::<GasPressure>(), Err(GasPressureError::Text(_))), "{text}");
        }
    }
}
