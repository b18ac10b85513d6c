//! The pressures that an integer with a pressure unit can show.

use profivac_devices::model::{Configuration, Counts, Model, NumberType, PressureFormat, Scale, Unit};
use std::fmt;

/// The pressures that the integers of a configuration show in a pressure unit. An integer shows whole units up to its highest number
/// (errata-bpg-bcg-tpg 70, errata-pxg55x-img400 16): a higher pressure is over range and a lower one is under range, whatever the gauge
/// measures.
///
/// ```
/// use profivac_client::cyclic::IntegerRange;
/// use profivac_devices::catalog::model_named;
///
/// let model = model_named("bcg450").ok_or("no such model")?;
/// // `5 T3/T6 PKW int`
/// let configuration = model.configurations.get(4).ok_or("no such configuration")?;
/// let range = |unit| IntegerRange::of(model, configuration, model.unit_named(unit)?);
/// assert_eq!(range("Pascal").ok_or("no range")?.highest_pa, 32767.0);
/// assert_eq!(range("COUNTS"), None);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct IntegerRange {
    /// The unit.
    pub unit: &'static Unit,
    /// One unit, in Pa.
    pub lowest_pa: f64,
    /// The highest number, in Pa.
    pub highest_pa: f64,
}

impl IntegerRange {
    /// The pressures of this configuration. `None` for floats and for COUNTS, which hold the range of every gauge.
    #[must_use]
    pub fn of(model: &Model, configuration: &Configuration, unit: &'static Unit) -> Option<Self> {
        let is_integer = configuration.number() == Some(NumberType::Integer);
        if !is_integer || unit.scale == Scale::Counts {
            return None;
        }
        // Only COUNTS depend on the scale of the part.
        let counts = Counts::Linear { per_mbar: 1.0 };
        let format = PressureFormat { unit, number: NumberType::Integer, counts, max_integer: model.max_integer };
        let (lowest_pa, highest_pa) = (format.pa_from_number(1.0)?, format.integer_end_pa()?);
        Some(Self { unit, lowest_pa, highest_pa })
    }
}

impl IntegerRange {
    /// The same in every pressure unit of the model, for a configuration whose unit is not known. Empty for floats.
    #[must_use]
    pub fn in_every_unit(model: &Model, configuration: &Configuration) -> Vec<Self> {
        model.units.iter().filter_map(|unit| Self::of(model, configuration, unit)).collect()
    }

    /// The limits in mbar: `0.01 to 327.67 mbar in Pascal`.
    #[must_use]
    pub fn limits(&self) -> String {
        format!("{} to {} mbar in {}", mbar(self.lowest_pa), mbar(self.highest_pa), self.unit.name)
    }
}

impl fmt::Display for IntegerRange {
    /// The limits in mbar: `its integers in Pascal show 0.01 to 327.67 mbar only ...`.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let (unit, lowest, highest) = (self.unit.name, mbar(self.lowest_pa), mbar(self.highest_pa));
        write!(
            f,
            "its integers in {unit} show {lowest} to {highest} mbar only: a higher pressure is over range, a lower one is under range; \
             a module with floats, or the unit COUNTS, shows the whole range of the gauge"
        )
    }
}

/// A pressure in mbar with at most five digits.
fn mbar(pa: f64) -> f64 {
    let mbar = pa / 100.0;
    format!("{mbar:.4e}").parse().unwrap_or(mbar)
}

#[cfg(test)]
mod tests {
    use super::*;
    use profivac_devices::catalog::{MODELS, model_named};

    fn sentence(device: &str, unit: &str) -> String {
        let model = model_named(device).unwrap();
        let integers = model.configurations.iter().find(|it| it.number() == Some(NumberType::Integer)).unwrap();
        IntegerRange::of(model, integers, model.unit_named(unit).unwrap()).unwrap().to_string()
    }

    #[test]
    fn the_sentence_has_the_limits_of_each_unit_in_mbar() {
        for (device, unit, limits) in [
            ("bcg450", "Pascal", "its integers in Pascal show 0.01 to 327.67 mbar only"),
            ("bcg450", "Micron", "its integers in Micron show 0.0013332 to 43.686 mbar only"),
            ("bcg450", "Torr", "its integers in Torr show 1.3332 to 43686 mbar only"),
            ("pcg550", "mbar", "its integers in mbar show 1 to 32767 mbar only"),
            ("img400", "Pa", "show 0.01 to 655.35 mbar only"),
        ] {
            let sentence = sentence(device, unit);
            assert!(sentence.contains(limits), "{sentence}");
        }
    }

    #[test]
    fn floats_and_counts_have_no_such_range() {
        for model in MODELS {
            for configuration in model.configurations {
                for unit in model.units {
                    let is_limited = configuration.number() == Some(NumberType::Integer) && unit.scale != Scale::Counts;
                    let range = IntegerRange::of(model, configuration, unit);
                    assert_eq!(range.is_some(), is_limited, "{} {}", model.name, unit.name);
                }
            }
        }
    }
}
