#![doc = include_str!("../README.md")]
#![forbid(unsafe_code)]
#![warn(missing_docs, clippy::indexing_slicing, clippy::arithmetic_side_effects)]

// The tests of the workspace know the crate by this name.
#[cfg(test)]
extern crate self as profivac_gsd;

mod alarm;
mod configuration;
mod device;
mod diagnosis;
mod encoding;
mod file;
mod fit;
mod general;
mod lexer;
mod parameter;
mod problem;
mod reader;
mod reading;
mod statement;
mod words;
mod write;

pub use alarm::{Alarm, Alarms};
pub use configuration::{
    Chosen, Configuration, ConfigurationError, Place, PlacedParameter, Plugged, PrmError, Target, Warning,
};
pub use device::{Device, Module, Other, Slot};
pub use diagnosis::{DiagArea, Diagnosis, Finding, UnitDiag, Words};
pub use encoding::Encoding;
pub use file::GsdFile;
pub use fit::{Fit, FitError, FittedSlot};
pub use general::{General, RATES, Rate, RateError};
pub use parameter::{DataType, Interval, Parameter, PrmArea, PrmContent, PrmDefinition, PrmItem, PrmText};
pub use problem::{Fault, Problem, Severity, Tool};
pub use reading::{Difference, ReadValue, Reading, dpv1_status_bits};
pub use write::{commented_text, text};
