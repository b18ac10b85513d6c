//! How certain the numbers of a plant are, and what would help, in words.

use profivac_identify::Interval;
use profivac_identify::plant::Remedy;

/// Above this the fit does not describe the record. chosen
pub const MISFIT: f64 = 2.0;

/// A quantity whose bounds differ by more than this factor cannot be determined, one whose lower bound is below this part of the
/// upper one cannot be told from zero. chosen
const FACTOR: f64 = 10.0;
const NONE: f64 = 1e-3;

/// The widest interval of a known exponent: 1/2 is diffusion, 1 is the water of a wall. chosen
const EXPONENT: f64 = 0.5;

/// A number of a plant.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Parameter {
    /// The volume, from a dose.
    Volume,
    /// The effective pumping speed at a pressure.
    Speed,
    /// The leak.
    Leak,
    /// The outgassing after an hour.
    Outgassing,
    /// The exponent of the outgassing.
    Exponent,
    /// The ultimate pressure of the pump.
    Ultimate,
}

/// How well a record determines a number.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Certainty {
    /// Within its interval.
    Determined,
    /// It may be zero: only the upper bound is known.
    UpperBound,
    /// Its interval is too wide to be of use.
    Undetermined,
}

/// How well a record determines a number.
#[must_use]
pub fn certainty(parameter: Parameter, found: Interval) -> Certainty {
    let is_wide = match parameter {
        Parameter::Exponent => found.high - found.low > EXPONENT,
        _ => found.high > FACTOR * found.low,
    };
    let may_be_zero = found.low <= NONE * found.high;
    match parameter {
        Parameter::Leak | Parameter::Ultimate if may_be_zero => Certainty::UpperBound,
        _ if is_wide || !found.high.is_finite() => Certainty::Undetermined,
        _ => Certainty::Determined,
    }
}

/// What a number without a value means, and what to record; `None` if it is determined.
#[must_use]
pub fn note(parameter: Parameter, found: Interval) -> Option<&'static str> {
    match (certainty(parameter, found), parameter) {
        (Certainty::Determined, _) => None,
        (Certainty::UpperBound, Parameter::Leak) => {
            Some("cannot be told from zero: only its upper bound is known. A rise after longer pumping lowers it")
        }
        (Certainty::UpperBound, _) => {
            Some("cannot be told from zero: only its upper bound is known. Leak or outgassing covers it")
        }
        (Certainty::Undetermined, Parameter::Volume) => {
            Some("cannot be determined: the dose raises the pressure too little. Let in a larger one")
        }
        (Certainty::Undetermined, Parameter::Speed) => Some(
            "cannot be determined at this pressure: the gas that enters covers it. Record a rise with the valve closed",
        ),
        (Certainty::Undetermined, Parameter::Leak) => {
            Some("cannot be determined: outgassing explains the record as well. Record a rise after longer pumping")
        }
        (Certainty::Undetermined, Parameter::Outgassing) => Some(
            "cannot be determined: a leak or the pump explains the record as well. Pump longer, then record a rise",
        ),
        (Certainty::Undetermined, Parameter::Exponent) => {
            Some("cannot be determined: outgassing falls over too short a time, or other gas covers it. Pump longer")
        }
        (Certainty::Undetermined, Parameter::Ultimate) => {
            Some("cannot be determined: leak or outgassing covers it. Pump longer")
        }
    }
}

/// A remedy as an imperative or a noun.
#[must_use]
pub const fn remedy(remedy: Remedy) -> &'static str {
    match remedy {
        Remedy::CloseLeak => "close the leak",
        Remedy::Bake => "bake (a hundredth of the outgassing)",
        Remedy::LargerPump => "a pump of twice the speed",
        Remedy::BetterPump => "a pump with a tenth of the ultimate pressure",
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const fn interval(low: f64, high: f64) -> Interval {
        Interval { mean: f64::midpoint(low, high), low, high }
    }

    #[test]
    fn a_number_that_the_record_does_not_determine_says_so() {
        for (parameter, low, high, expected) in [
            (Parameter::Leak, 0.0, 1e-7, Certainty::UpperBound),
            (Parameter::Leak, 1e-8, 2e-7, Certainty::Undetermined),
            (Parameter::Leak, 1e-8, 2e-8, Certainty::Determined),
            (Parameter::Ultimate, 1e-9, 1e-5, Certainty::UpperBound),
            (Parameter::Outgassing, 1e-12, 1e-5, Certainty::Undetermined),
            (Parameter::Speed, 0.1, f64::INFINITY, Certainty::Undetermined),
            (Parameter::Exponent, 0.3, 2.0, Certainty::Undetermined),
            (Parameter::Exponent, 0.9, 1.1, Certainty::Determined),
        ] {
            let found = interval(low, high);
            assert_eq!(certainty(parameter, found), expected, "{parameter:?} {found:?}");
            assert_eq!(note(parameter, found).is_none(), expected == Certainty::Determined, "{parameter:?} {found:?}");
        }
    }

    #[test]
    fn a_number_without_a_value_has_an_advice_that_says_that_it_cannot_be_known() {
        for parameter in [
            Parameter::Volume,
            Parameter::Speed,
            Parameter::Leak,
            Parameter::Outgassing,
            Parameter::Exponent,
            Parameter::Ultimate,
        ] {
            let text = note(parameter, interval(0.001, 1e3)).unwrap_or_default();
            assert!(text.starts_with("cannot be "), "{parameter:?}: {text}");
        }
    }
}
