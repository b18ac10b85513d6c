//! Pressures: with their unit as text, in the unit of the device on the bus.

use super::text::OR_MORE;
use super::{BeyondRange, Value, ValueFormat, ValueProblem};
use crate::names::NamedParameter;
use profivac_devices::model::{Counts, DataType, MeasuringRange, Model, NumberType, PressureFormat, Role, Scale, Unit};
use std::ops::RangeInclusive;

/// The limits of a measuring range also belong to it after a conversion to a 32-bit float of another unit, and a number that is
/// whole in one unit is whole after the conversion from another.
const SLACK: f64 = 1e-6;

impl ValueFormat<'_> {
    /// Whether a value is a pressure outside the measuring range of the gauge. 0 is inside: the manuals define it as a Safe
    /// Value (tira41d1 3.2.2.8), and a trip point of 0 is never reached. Without a range in the tables or a known unit, nothing is
    /// outside.
    #[must_use]
    pub fn beyond_range(&self, value: &Value) -> Option<BeyondRange> {
        self.beyond(value, self.range_in_unit()?)
    }

    /// The same with the range that the device reports for this location.
    pub(crate) fn beyond_reported_range(&self, value: &Value, range: MeasuringRange) -> Option<BeyondRange> {
        let format = self.pressure_format(self.unit?)?;
        self.beyond(value, format.number_from_pa(range.lowest_pa)..=format.number_from_pa(range.highest_pa))
    }

    fn beyond(&self, value: &Value, range: RangeInclusive<f64>) -> Option<BeyondRange> {
        let (Value::Number(number), DataType::ByType) = (value, self.row().data_type) else { return None };
        let (lowest, highest) = (*range.start(), *range.end());
        let is_inside = *number == 0.0 || (lowest * (1.0 - SLACK)..=highest * (1.0 + SLACK)).contains(number);
        let text = |number: f64| self.format(&Value::Number(number));
        (!is_inside).then(|| BeyondRange { given: text(*number), lowest: text(lowest), highest: text(highest) })
    }

    /// The measuring range in the present unit of the device; for a difference of pressures from 0 to the highest pressure.
    fn range_in_unit(&self) -> Option<RangeInclusive<f64>> {
        let (unit, location) = (self.unit?, self.named.parameter.location);
        let range = self.model.measuring_range_at(location)?;
        let is_difference = self.row().role == Some(Role::PressureDifference);
        let format = self.pressure_format(unit)?;
        let lowest = if is_difference { 0.0 } else { format.number_from_pa(range.lowest_pa) };
        Some(lowest..=format.number_from_pa(range.highest_pa))
    }

    /// The format of a pressure in a unit; `None` for COUNTS without a scale.
    fn pressure_format(&self, unit: &'static Unit) -> Option<PressureFormat> {
        pressure_format(self.model, self.named, unit, NumberType::Float)
    }

    /// A pressure that the gauge accepts: the highest of its range, and of integers the highest one that stands for itself.
    pub(super) fn example(&self, highest: Option<u16>) -> String {
        match (self.range_in_unit(), self.unit) {
            (Some(range), _) => {
                let end = *range.end();
                let example = highest.map_or(end, |highest| (end + SLACK).floor().min(f64::from(highest) - 1.0));
                self.format(&Value::Number(example))
            }
            (None, Some(unit)) => format!("1 {}", unit.name),
            (None, None) => "1 mbar".to_owned(),
        }
    }

    /// Parses `1e-3 mbar` in any unit of the device.
    pub(super) fn pressure(&self, text: &str, number: NumberType) -> Result<Vec<u8>, ValueProblem> {
        if text.ends_with(OR_MORE) {
            return Err(ValueProblem::EndOfIntegers);
        }
        let end = text.find(char::is_whitespace).unwrap_or_else(|| {
            text.char_indices()
                .find(|(at, it)| it.is_ascii_alphabetic() && !is_exponent(text, *at))
                .map_or(text.len(), |(at, _)| at)
        });
        let (digits, unit) = text.split_at(end);
        let value: f64 = digits.parse().map_err(|_| ValueProblem::NotAccepted)?;
        let value = match unit.trim() {
            "" if !is_writable_number(value) => return Err(ValueProblem::NotAccepted),
            "" => {
                let example = self.unit.map(|unit| format!("{digits} {}", unit.name));
                return Err(ValueProblem::NoUnit { example });
            }
            unit => {
                let units = || self.model.units.iter().map(|unit| unit.name).collect();
                let unit = self.model.unit_named(unit).ok_or_else(|| ValueProblem::UnknownUnit { units: units() })?;
                self.converted(value, unit)?
            }
        };
        self.encode_pressure(value, number)
    }

    /// The octets of a pressure in the present unit of the device, if they hold this number. A number other than 0 never
    /// becomes 0, which is a Safe Value and a trip point of its own meaning.
    #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "checked")]
    pub(crate) fn encode_pressure(&self, value: f64, number: NumberType) -> Result<Vec<u8>, ValueProblem> {
        if !is_writable_number(value) {
            return Err(ValueProblem::NotAccepted);
        }
        let (held, octets) = match number {
            NumberType::Float => (f64::from(value as f32), (value as f32).to_be_bytes().to_vec()),
            NumberType::Integer => {
                let whole = value.round().min(f64::from(self.model.max_integer));
                (whole, (whole as u16).to_be_bytes().to_vec())
            }
        };
        match (held - value).abs() <= SLACK * value {
            true => Ok(octets),
            false if held == 0.0 => Err(ValueProblem::BecomesZero),
            false => Err(ValueProblem::NotAccepted),
        }
    }

    /// Converts a number to the unit of the device.
    fn converted(&self, value: f64, from: &'static Unit) -> Result<f64, ValueProblem> {
        let not_convertible = || ValueProblem::NotConvertible { unit: self.unit.map(|unit| unit.name) };
        let to = self.unit.ok_or_else(not_convertible)?;
        match (from.scale, to.scale) {
            _ if from == to => Ok(value),
            (Scale::PerMbar(from), Scale::PerMbar(to)) => Ok(value / from * to),
            _ => {
                let format = |unit| self.pressure_format(unit).ok_or_else(not_convertible);
                let pa = format(from)?.pa_from_number(value).ok_or(ValueProblem::NotAccepted)?;
                Ok(format(to)?.number_from_pa(pa))
            }
        }
    }
}

/// The format of the pressures of a parameter in a unit. `None` for COUNTS without a scale in the tables, and for the COUNTS of
/// a difference, which depend on the point it starts from.
pub(crate) fn pressure_format(
    model: &Model,
    named: &NamedParameter,
    unit: &'static Unit,
    number: NumberType,
) -> Option<PressureFormat> {
    let is_difference = named.parameter.row.role == Some(Role::PressureDifference);
    let counts = match unit.scale {
        Scale::PerMbar(_) => Counts::Linear { per_mbar: 1.0 },
        Scale::Counts if is_difference => return None,
        Scale::Counts => model.counts_at(named.parameter.location)?,
    };
    Some(PressureFormat { unit, number, counts, max_integer: model.max_integer })
}

/// Whether a number of this size can be written as a pressure: 0 too, as a Safe Value; NaN cannot.
fn is_writable_number(number: f64) -> bool {
    (0.0..=f64::from(f32::MAX)).contains(&number)
}

/// Whether the letter at this position is the exponent sign of a number.
fn is_exponent(text: &str, at: usize) -> bool {
    let (before, rest) = text.split_at(at);
    rest.starts_with(['e', 'E'])
        && before.ends_with(|it: char| it.is_ascii_digit() || it == '.')
        && rest[1..].trim_start_matches(['-', '+']).starts_with(|it: char| it.is_ascii_digit())
}
