//! The errors of the entries of a scenario.

use crate::action_text::UnknownName;
use crate::device_spec::SpecError;
use crate::gas_pressure::GasPressureError;
use crate::gsd_slave::FORMS;
use profivac_client::pressure::PressureError;
use profivac_client::suggestion::{self, with_suggestion};
use profivac_vacuum::gas::UnknownGas;
use std::fmt;
use std::ops::Range;

/// The error of an entry of a scenario: the expected and the found value.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum ScenarioEntryError {
    /// The text is no TOML, or has a wrong key, or a value of a wrong type.
    #[error("{}", with_suggestion(.0.message()))]
    Toml(Box<toml::de::Error>),
    /// A quantity has another form, or another unit.
    #[error("expected {what} like {example:?} in {}, got {found:?}", units.join(", "))]
    Form {
        /// The quantity: `a time`.
        what: &'static str,
        /// A valid text.
        example: &'static str,
        /// The units of the quantity.
        units: Vec<&'static str>,
        /// The text of the file.
        found: String,
    },
    /// A quantity is beyond every plant.
    #[error("expected {what} from {least} to {most}, got {found:?}")]
    OutOfRange {
        /// The quantity.
        what: &'static str,
        /// The lowest value.
        least: &'static str,
        /// The highest value.
        most: &'static str,
        /// The text of the file.
        found: String,
    },
    /// A quantity is zero.
    #[error("expected {what} above zero, got {found:?}")]
    Zero {
        /// The quantity.
        what: &'static str,
        /// The text of the file.
        found: String,
    },
    /// The pressure of a gas is wrong.
    #[error(transparent)]
    GasPressure(#[from] GasPressureError),
    /// The pressure of an expectation is wrong.
    #[error(transparent)]
    Pressure(#[from] PressureError),
    /// The pressure of an expectation is beyond every plant.
    #[error("expected a pressure up to 10 bar, got {0:?}")]
    HighPressure(String),
    /// A temperature has another form or is beyond every plant.
    #[error("expected a temperature like \"150 C\" or \"423 K\" from 1 K to 2000 K, got {0:?}")]
    Temperature(String),
    /// No gas has this name.
    #[error(transparent)]
    Gas(#[from] UnknownGas),
    /// A device spec is wrong.
    #[error(transparent)]
    Device(#[from] SpecError),
    /// A slave by its GSD file cannot be built, or does not carry out an order.
    #[error("{0}")]
    Slave(String),
    /// An expectation of a slave by its GSD file has a check that only a gauge has.
    #[error("expected only exchanging for a slave by its GSD file")]
    NotOfSlave,
    /// A name of the file, or of the program, is unknown.
    #[error("expected {what}, got {found:?}; {}", Known { known, found })]
    Unknown {
        /// The kind of name.
        what: &'static str,
        /// The text of the file.
        found: String,
        /// The names that exist.
        known: Vec<String>,
    },
    /// No gauge has this address.
    #[error("expected the address of a gauge, got {found}; known: {}", list(known))]
    UnknownAddress {
        /// The address of the file.
        found: u8,
        /// The gauges: `5 (bcg450)`.
        known: Vec<String>,
    },
    /// The address is that of a slave by its GSD file.
    #[error(
        "expected the address of a gauge, got {found}, which is {name}, a slave by its GSD file; write order = [...] with {}",
        orders(faults)
    )]
    AddressOfSlave {
        /// The address of the file.
        found: u8,
        /// Vendor and model of the slave.
        name: String,
        /// The orders that report what its file has words for.
        faults: Vec<String>,
    },
    /// The device has no such fault, button, switch or potentiometer.
    #[error("{device} at address {address} has {unknown}")]
    UnknownPart {
        /// The device.
        device: &'static str,
        /// Its address.
        address: u8,
        /// The missing part, and those that the device has.
        unknown: UnknownName,
    },
    /// The plant has too many volumes.
    #[error("expected at most {0} volumes with those of pockets")]
    TooManyVolumes(usize),
    /// Two parts have the same name.
    #[error("the name {0:?} is given twice")]
    DuplicateName(String),
    /// A part connects a volume with itself.
    #[error("expected another volume than {0:?}, got it twice")]
    SameVolume(String),
    /// A tube or a valve has no conductance.
    #[error("expected diameter and length, or conductance")]
    NoConductance,
    /// A compression is beyond every pump.
    #[error("expected a compression from 1 to 1e15, got {0:e}")]
    Compression(f64),
    /// The speeds of a roughing pump over its inlet pressure are no curve.
    #[error("{0}")]
    SpeedCurve(profivac_vacuum::pump::WrongCurve),
    /// A step is too long.
    #[error("expected a step of at most 1 h, got {0:?}")]
    LongStep(String),
    /// An event is after the end.
    #[error("expected a time before the end of the scenario, got {0:?}")]
    AfterEnd(String),
    /// An inlet has neither flow nor pressure, or both.
    #[error("expected a flow or a pressure")]
    NoSupply,
    /// The voltage of a potentiometer is beyond its supply.
    #[error("expected volts from -{most} to {most}, got {found}")]
    Volts {
        /// The highest voltage, either sign.
        most: f64,
        /// The number of the file.
        found: f64,
    },
    /// An expectation has no subject, or two.
    #[error("expected the key volume or the key device, and not both")]
    NoSubject,
    /// An expectation has no check.
    #[error("expected a check, like below = \"1e-6 mbar\"")]
    NoCheck,
    /// An expectation of a volume has a check that only a device has.
    #[error("expected only above, below or near for a volume")]
    NotOfVolume,
    /// An expectation of a relay lacks its number or its state.
    #[error("expected the keys relay and closed together")]
    HalfRelay,
    /// A tolerance has no value.
    #[error("expected the key near beside the key within")]
    NoNear,
    /// Bounds contradict each other.
    #[error("expected near, or above and below")]
    MixedBounds,
}

/// An error with its position in the text.
#[derive(Clone, Debug, PartialEq)]
pub struct TextError {
    /// The position in octets.
    pub at: usize,
    /// The error.
    pub error: ScenarioEntryError,
}

impl TextError {
    /// An error at the beginning of `span`.
    pub fn at(span: &Range<usize>, error: impl Into<ScenarioEntryError>) -> Self {
        Self { at: span.start, error: error.into() }
    }
}

/// The known names, and the most similar one.
struct Known<'a> {
    known: &'a [String],
    found: &'a str,
}

impl fmt::Display for Known<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if self.known.is_empty() { f.write_str("there is none") } else { write!(f, "known: {}", list(self.known)) }?;
        write_suggestion(f, self.known, self.found)
    }
}

/// The orders of a slave: those for its faults, or else the first words of all.
fn orders(faults: &[String]) -> String {
    match faults {
        [] => FORMS.map(|(word, _)| word).join(", "),
        faults => suggestion::list(faults),
    }
}

fn write_suggestion(f: &mut fmt::Formatter<'_>, known: &[String], found: &str) -> fmt::Result {
    match suggestion::closest(found, known.iter().map(String::as_str)) {
        Some(near) => write!(f, "; did you mean {near:?}?"),
        None => Ok(()),
    }
}

fn list(items: &[impl ToString]) -> String {
    items.iter().map(ToString::to_string).collect::<Vec<_>>().join(", ")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_unknown_name_is_an_error_with_a_suggestion() {
        let unknown = |found: &str| {
            let known = ["gate", "fore-valve"].map(str::to_owned).to_vec();
            ScenarioEntryError::Unknown { what: "a valve", found: found.to_owned(), known }.to_string()
        };
        let said = unknown("gaet");
        assert_eq!(said, "expected a valve, got \"gaet\"; known: gate, fore-valve; did you mean \"gate\"?");
        assert!(!unknown("turbo").contains("did you mean"));
    }
}
