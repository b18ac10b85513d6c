//! Quantities with units, and the most similar name.

use super::error::{ScenarioEntryError, TextError};
use crate::gas_pressure::{GasPressure, HIGHEST_PA};
use profivac_client::pressure::Pressure;
use profivac_scenario_file::Text;
use profivac_vacuum::pump::flow_of_sccm;
use std::str::FromStr;

/// A kind of quantity: its name, an example, its units with their size in SI, and its bounds as text and in SI. Zero is
/// always below the lower bound and accepted.
///
/// chosen bounds: wider than any real plant, and narrow enough for every calculation.
pub struct Quantity {
    name: &'static str,
    example: &'static str,
    units: &'static [(&'static str, f64)],
    bounds: [(&'static str, f64); 2],
}

const TORR_PA: f64 = 101_325.0 / 760.0;

/// A time, in s.
pub const TIME: Quantity = Quantity {
    name: "a time",
    example: "90 s",
    units: &[("ms", 1e-3), ("s", 1.0), ("min", 60.0), ("h", 3600.0), ("d", 86_400.0)],
    bounds: [("1 ms", 1e-3), ("36500 d", 3.1536e9)],
};

/// A volume, in m³.
pub const VOLUME: Quantity = Quantity {
    name: "a volume",
    example: "100 l",
    units: &[("l", 1e-3), ("ml", 1e-6), ("mm3", 1e-9), ("m3", 1.0)],
    bounds: [("1 mm3", 1e-9), ("1e6 m3", 1e6)],
};

/// A length, in m.
pub const LENGTH: Quantity = Quantity {
    name: "a length",
    example: "40 mm",
    units: &[("mm", 1e-3), ("cm", 1e-2), ("m", 1.0)],
    bounds: [("0.001 mm", 1e-6), ("1000 m", 1e3)],
};

/// An area, in m².
pub const AREA: Quantity = Quantity {
    name: "an area",
    example: "1.5 m2",
    units: &[("m2", 1.0), ("cm2", 1e-4)],
    bounds: [("0.01 cm2", 1e-6), ("1e6 m2", 1e6)],
};

/// A pumping speed or a conductance, in m³/s.
pub const SPEED: Quantity = Quantity {
    name: "a pumping speed",
    example: "300 l/s",
    units: &[("l/s", 1e-3), ("m3/h", 1.0 / 3600.0), ("m3/s", 1.0)],
    bounds: [("1e-15 l/s", 1e-18), ("1e6 m3/s", 1e6)],
};

/// An amount of gas, in Pa m³.
pub const AMOUNT: Quantity = Quantity {
    name: "an amount of gas",
    example: "100 mbar l",
    units: &[("mbar l", 0.1), ("Pa m3", 1.0), ("Torr l", TORR_PA * 1e-3)],
    bounds: [("1e-9 mbar l", 1e-10), ("1e9 mbar l", 1e8)],
};

/// A permeability, in m²/s: Pa m³/s of gas per m of thickness, m² of area and Pa.
pub const PERMEABILITY: Quantity = Quantity {
    name: "a permeability",
    example: "1e-11 m2/s",
    units: &[("cm2/s", 1e-4), ("m2/s", 1.0)],
    bounds: [("1e-20 m2/s", 1e-20), ("1e-3 m2/s", 1e-3)],
};

/// A fraction, 0 to 1.
pub const PART: Quantity =
    Quantity { name: "a percentage", example: "50 %", units: &[("%", 0.01)], bounds: [("0 %", 0.0), ("100 %", 1.0)] };

/// A gas flow, in Pa m³/s. A flow in sccm is converted at room temperature, not by a factor.
const FLOW: Quantity = Quantity {
    name: "a gas flow",
    example: "1e-5 mbar l/s",
    units: &[("mbar l/s", 0.1), ("Pa m3/s", 1.0), ("Torr l/s", TORR_PA * 1e-3), ("sccm", 0.0)],
    bounds: [("0 mbar l/s", 0.0), ("1e7 mbar l/s", 1e6)],
};

impl Quantity {
    /// Parses a quantity. Returns it in SI.
    pub fn parse(&self, text: &Text) -> Result<f64, TextError> {
        let written = text.get_ref().trim();
        let split = |(unit, factor): &(&str, f64)| {
            let number: f64 = written.strip_suffix(unit)?.trim_end().parse().ok()?;
            (number.is_finite() && number >= 0.0).then_some((number, *factor))
        };
        let found = self.units.iter().find_map(split);
        let (number, factor) = found.ok_or_else(|| TextError::at(&text.span(), self.wrong_form(written)))?;
        let number = if factor == 0.0 { flow_of_sccm(number) } else { number * factor };
        let [(least, from), (most, to)] = self.bounds;
        // A bound in one unit and a value in another may differ in the last digit.
        if number == 0.0 || (from * (1.0 - 1e-9)..=to * (1.0 + 1e-9)).contains(&number) {
            return Ok(number);
        }
        let error = ScenarioEntryError::OutOfRange { what: self.name, least, most, found: written.to_owned() };
        Err(TextError::at(&text.span(), error))
    }

    fn wrong_form(&self, written: &str) -> ScenarioEntryError {
        let units = self.units.iter().map(|(name, _)| *name).collect();
        ScenarioEntryError::Form { what: self.name, example: self.example, units, found: written.to_owned() }
    }

    /// Parses a quantity above zero. Returns it in SI.
    pub fn positive(&self, text: &Text) -> Result<f64, TextError> {
        let number = self.parse(text)?;
        let zero = || ScenarioEntryError::Zero { what: self.name, found: text.get_ref().clone() };
        if number > 0.0 { Ok(number) } else { Err(TextError::at(&text.span(), zero())) }
    }
}

/// A gas flow, in Pa m³/s.
pub fn flow(text: &Text) -> Result<f64, TextError> {
    FLOW.parse(text)
}

/// The pressure of a gas, in Pa; never zero.
pub fn gas_pressure(text: &Text) -> Result<f64, TextError> {
    parsed::<GasPressure>(text).map(|pressure| pressure.0.pa())
}

/// A pressure to compare with, in Pa; it may be zero.
pub fn pressure(text: &Text) -> Result<f64, TextError> {
    let pressure: Pressure = parsed(text)?;
    let high = || TextError::at(&text.span(), ScenarioEntryError::HighPressure(text.get_ref().clone()));
    if pressure.pa() <= HIGHEST_PA { Ok(pressure.pa()) } else { Err(high()) }
}

/// A temperature in degrees Celsius or K, in K.
pub fn temperature(text: &Text) -> Result<f64, TextError> {
    let written = text.get_ref();
    let kelvin = match written.trim().rsplit_once(' ') {
        Some((number, "C")) => number.trim().parse::<f64>().ok().map(|celsius| celsius + 273.15),
        Some((number, "K")) => number.trim().parse().ok(),
        _ => None,
    };
    let possible = kelvin.filter(|kelvin| (1.0..=2000.0).contains(kelvin));
    possible.ok_or_else(|| TextError::at(&text.span(), ScenarioEntryError::Temperature(written.clone())))
}

/// Parses any type from a text.
pub fn parsed<T: FromStr>(text: &Text) -> Result<T, TextError>
where
    ScenarioEntryError: From<T::Err>,
{
    text.get_ref().parse().map_err(|error: T::Err| TextError::at(&text.span(), error))
}

/// The error for an unknown name, with the known names.
pub fn unknown<'a>(what: &'static str, name: &Text, known: impl Iterator<Item = &'a str>) -> TextError {
    let known = known.map(str::to_owned).collect();
    TextError::at(&name.span(), ScenarioEntryError::Unknown { what, found: name.get_ref().clone(), known })
}

#[cfg(test)]
mod tests {
    use super::*;
    use toml::Spanned;

    fn text(written: &str) -> Text {
        Spanned::new(7..9, written.to_owned())
    }

    #[test]
    fn quantities_are_parsed_with_their_units() {
        for (quantity, written, expected) in [
            (&TIME, "90 s", 90.0),
            (&TIME, "2h", 7200.0),
            (&TIME, "1.5 d", 129_600.0),
            (&TIME, "10 ms", 0.01),
            (&VOLUME, "100 l", 0.1),
            (&SPEED, "36 m3/h", 0.01),
            (&FLOW, "1e-5 mbar l/s", 1e-6),
            (&FLOW, "2e-3Pa m3/s", 2e-3),
            (&PART, "50 %", 0.5),
            (&AREA, "200 cm2", 0.02),
        ] {
            let read = quantity.parse(&text(written)).unwrap();
            assert!((read / expected - 1.0).abs() < 1e-12, "{written}: {read}");
        }
        assert!((flow(&text("60 sccm")).unwrap() / 0.10875 - 1.0).abs() < 1e-3);
        assert!((temperature(&text("150 C")).unwrap() - 423.15).abs() < 1e-9);
        assert_eq!(temperature(&text("77 K")), Ok(77.0));
    }

    #[test]
    fn an_invalid_quantity_is_an_error_with_an_example() {
        for written in ["", "s", "9", "-1 s", "nan s", "1e400 s", "1 s s", "1 m"] {
            let expected = format!("expected a time like \"90 s\" in ms, s, min, h, d, got {written:?}");
            let error = TIME.parse(&text(written)).unwrap_err();
            assert_eq!((error.at, error.error.to_string()), (7, expected), "{written}");
        }
        let zero = VOLUME.positive(&text("0 l")).unwrap_err().error.to_string();
        assert_eq!(zero, "expected a volume above zero, got \"0 l\"");
        let cold = temperature(&text("-300 C")).unwrap_err().error.to_string();
        assert_eq!(cold, "expected a temperature like \"150 C\" or \"423 K\" from 1 K to 2000 K, got \"-300 C\"");
    }
}
