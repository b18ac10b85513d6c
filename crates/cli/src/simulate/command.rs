//! The commands that `simulate` reads from standard input.

use crate::values::{ValueError, number};
use profivac_client::pressure::Pressure;
use profivac_client::suggestion::list;
use profivac_vacuum::Gas;
use profivac_vacuum::gas::UnknownGas;
use profivac_virtual::action_text::{ActionText as Action, UnknownName};
use profivac_virtual::device_spec::{SpecError, parse_address};
use profivac_virtual::gas_pressure::{GasPressure, GasPressureError};
use profivac_virtual::gsd_slave::{self, Order, OrderError, Refused};
use std::fmt;

/// The longest `advance`: thirty years.
const MAX_SECONDS: f64 = 1e9;

/// The limit for `pot`: more than a potentiometer of any gauge can give.
const MAX_VOLTS: f64 = 100.0;

/// A command line.
#[derive(Clone, Debug, PartialEq)]
pub enum Command<'a> {
    Pressure(Pressure),
    Atmosphere(Pressure),
    Gas(Gas),
    Advance(f64),
    /// A command for the device at this address.
    Device(u8, DeviceCommand<'a>),
    Quit,
}

/// A command for one device.
#[derive(Clone, Debug, PartialEq)]
pub enum DeviceCommand<'a> {
    /// Of a gauge.
    Operate(Action<'a>),
    /// Of a slave by its GSD file.
    Order(Order),
    Power(bool),
    State,
}

/// The first word of each command and its arguments.
const FORMS: [(&str, &str); 12] = [
    ("pressure", "PRESSURE"),
    ("atmosphere", "PRESSURE"),
    ("gas", "GAS"),
    ("fault", "ADDR NAME"),
    ("clear", "ADDR NAME"),
    ("power", "ADDR off|on"),
    ("button", "ADDR N"),
    ("switch", "ADDR NAME VALUE"),
    ("pot", "ADDR a|b VOLTS"),
    ("advance", "SECONDS"),
    ("state", "ADDR"),
    ("quit", ""),
];

/// Every command: those of gauges and of the segment, then those of slaves by their GSD files.
fn forms() -> impl Iterator<Item = (&'static str, &'static str)> {
    FORMS.into_iter().chain(gsd_slave::FORMS)
}

/// The reason why a command was not executed.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum CommandError {
    /// The words do not fit the command with this first word.
    #[error("expected {}", Form(.0))]
    Form(String),
    /// No command has this first word.
    #[error("expected one of {known}, got {word:?}", known = forms().map(|(word, _)| word).collect::<Vec<_>>().join(", "))]
    UnknownCommand { word: String },
    #[error(transparent)]
    Number(#[from] ValueError),
    #[error(transparent)]
    Pressure(#[from] GasPressureError),
    #[error(transparent)]
    Gas(#[from] UnknownGas),
    #[error(transparent)]
    Address(#[from] SpecError),
    /// The command would change conditions that a scenario sets.
    #[error("the scenario controls the chamber; start `simulate` without --scenario to use this command")]
    ScenarioRuns,
    /// `known` are the stations of the line.
    #[error("no device at address {address}; known: {known}")]
    NoDevice { address: u8, known: String },
    #[error(transparent)]
    Order(#[from] OrderError),
    #[error(transparent)]
    Refused(#[from] Refused),
    /// A slave by its GSD file has neither pressure nor faults nor controls.
    #[error("{name} at address {address} is a slave by its GSD file, without gauge; expected {SLAVE_WORDS}{}", Faults(.faults))]
    NoGauge { name: String, address: u8, faults: Vec<String> },
    /// A gauge has its inputs from its sensors.
    #[error(
        "{device} at address {address} is a gauge, whose inputs and diagnosis follow from pressure and faults; expected {GAUGE_WORDS}"
    )]
    IsGauge { device: &'static str, address: u8 },
    /// The segment has only slaves by their GSD files.
    #[error("there is no gauge on the line; a slave by its GSD file takes {SLAVE_WORDS}")]
    NoGauges,
    /// The device does not have this fault, button, switch or potentiometer.
    #[error("{device} at address {address} has {unknown}")]
    NoPart { device: &'static str, address: u8, unknown: UnknownName },
}

/// The commands of one kind of station.
const SLAVE_WORDS: &str = "input, diagnosis, channel-error, alarm, record, power or state";
const GAUGE_WORDS: &str = "fault, clear, power, button, switch, pot or state";

/// The lines that report a fault of the file of a slave; nothing without one.
struct Faults<'a>(&'a [String]);

impl fmt::Display for Faults<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if self.0.is_empty() { Ok(()) } else { write!(f, "; faults of its file: {}", list(self.0)) }
    }
}

/// The form of a command, by its first word.
struct Form<'a>(&'a str);

impl fmt::Display for Form<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let arguments = forms().find(|(word, _)| *word == self.0).map_or("", |(_, arguments)| arguments);
        f.write_str(format!("{} {arguments}", self.0).trim_end())
    }
}

impl<'a> Command<'a> {
    /// Parses a line.
    pub fn parse(line: &'a str) -> Result<Self, CommandError> {
        let words: Vec<&str> = line.split_whitespace().collect();
        match words[..] {
            ["pressure", _, ..] => Ok(Self::Pressure(pressure(line)?)),
            ["atmosphere", _, ..] => Ok(Self::Atmosphere(pressure(line)?)),
            ["gas", gas] => Ok(Self::Gas(gas.parse()?)),
            ["advance", seconds] => Ok(Self::Advance(number(seconds, 0.0, MAX_SECONDS)?)),
            ["quit"] => Ok(Self::Quit),
            [word, address, ref rest @ ..] => {
                let command = match Order::parse(word, rest) {
                    Some(order) => DeviceCommand::Order(order?),
                    None => DeviceCommand::parse(word, rest)?.ok_or_else(|| expected(word))?,
                };
                Ok(Self::Device(parse_address(address)?, command))
            }
            [word] => Err(expected(word)),
            [] => Err(expected("")),
        }
    }
}

impl<'a> DeviceCommand<'a> {
    /// Parses the words after the address. `None` if they do not fit the first word.
    fn parse(word: &str, rest: &[&'a str]) -> Result<Option<Self>, ValueError> {
        Ok(Some(match (word, rest) {
            ("fault", [name]) => Self::Operate(Action::Fault { name, present: true }),
            ("clear", [name]) => Self::Operate(Action::Fault { name, present: false }),
            ("button", [number]) => match number.parse() {
                Ok(number) => Self::Operate(Action::Button(number)),
                Err(_) => return Ok(None),
            },
            ("switch", [name, value]) => Self::Operate(Action::Switch { name, value }),
            ("pot", [which @ ("a" | "b"), volts]) => {
                let which = if *which == "a" { 'a' } else { 'b' };
                Self::Operate(Action::Pot { which, volts: number(volts, -MAX_VOLTS, MAX_VOLTS)? })
            }
            ("power", ["on"]) => Self::Power(true),
            ("power", ["off"]) => Self::Power(false),
            ("state", []) => Self::State,
            _ => return Ok(None),
        }))
    }
}

/// Parses the rest of the line after the first word.
fn pressure(line: &str) -> Result<Pressure, GasPressureError> {
    let text = line.trim_start().split_once(char::is_whitespace).map_or("", |(_, rest)| rest);
    text.parse().map(|GasPressure(pressure)| pressure)
}

/// The error for words that are no command.
fn expected(word: &str) -> CommandError {
    match forms().any(|(known, _)| known == word) {
        true => CommandError::Form(word.to_owned()),
        false => CommandError::UnknownCommand { word: word.to_owned() },
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_command_of_the_contract_is_parsed() {
        let operate = |action| Command::Device(5, DeviceCommand::Operate(action));
        for (line, command) in [
            ("pressure 5e-6 mbar", Command::Pressure(Pressure::from_mbar(5e-6))),
            ("  pressure  5e-6mbar ", Command::Pressure(Pressure::from_mbar(5e-6))),
            ("atmosphere 1000 mbar", Command::Atmosphere(Pressure::from_mbar(1000.0))),
            ("gas ar", Command::Gas(Gas::Ar)),
            ("fault 5 eeprom", operate(Action::Fault { name: "eeprom", present: true })),
            ("clear 5 eeprom", operate(Action::Fault { name: "eeprom", present: false })),
            ("power 5 off", Command::Device(5, DeviceCommand::Power(false))),
            ("power 5 on", Command::Device(5, DeviceCommand::Power(true))),
            ("button 5 1", operate(Action::Button(1))),
            ("switch 5 low-high high", operate(Action::Switch { name: "low-high", value: "high" })),
            ("pot 5 a 7.5", operate(Action::Pot { which: 'a', volts: 7.5 })),
            ("pot 5 b -1", operate(Action::Pot { which: 'b', volts: -1.0 })),
            ("advance 180", Command::Advance(180.0)),
            ("state 126", Command::Device(126, DeviceCommand::State)),
            (
                "input 9 2 16#1F 00",
                Command::Device(9, DeviceCommand::Order(Order::Input { slot: 2, at: 0, octets: vec![0x1F, 0] })),
            ),
            ("quit", Command::Quit),
        ] {
            assert_eq!(Command::parse(line), Ok(command), "{line}");
        }
    }

    #[test]
    fn the_error_for_a_wrong_line_names_what_was_expected() {
        for (line, reason) in [
            ("pressure", "expected pressure PRESSURE"),
            ("pressure high", "expected a pressure like '1e-3 mbar', got \"high\""),
            ("pressure 0 mbar", "expected a pressure from 1e-15 mbar to 10 bar, got \"0 mbar\""),
            ("pressure 1e300 mbar", "expected a pressure from 1e-15 mbar to 10 bar, got \"1e300 mbar\""),
            ("pressure inf mbar", "expected a pressure like '1e-3 mbar', got \"inf mbar\""),
            ("pressure nan mbar", "expected a pressure like '1e-3 mbar', got \"nan mbar\""),
            ("atmosphere 0 mbar", "expected a pressure from 1e-15 mbar to 10 bar, got \"0 mbar\""),
            ("atmosphere -1 mbar", "expected a pressure like '1e-3 mbar', got \"-1 mbar\""),
            ("atmosphere 1e300 mbar", "expected a pressure from 1e-15 mbar to 10 bar, got \"1e300 mbar\""),
            ("fault 5", "expected fault ADDR NAME"),
            ("fault 5 a b", "expected fault ADDR NAME"),
            ("power 5 half", "expected power ADDR off|on"),
            ("button 5 one", "expected button ADDR N"),
            ("pot 5 c 1", "expected pot ADDR a|b VOLTS"),
            ("pot 5 a inf", "expected a number from -100 to 100, got \"inf\""),
            ("pot 5 a nan", "expected a number from -100 to 100, got \"nan\""),
            ("pot 5 b 1e300", "expected a number from -100 to 100, got \"1e300\""),
            ("advance nan", "expected a number from 0 to 1000000000, got \"nan\""),
            ("advance inf", "expected a number from 0 to 1000000000, got \"inf\""),
            ("advance 1e300", "expected a number from 0 to 1000000000, got \"1e300\""),
            ("advance -1", "expected a number from 0 to 1000000000, got \"-1\""),
            ("state 127", "expected an address from 0 to 126, got \"127\""),
            ("state", "expected state ADDR"),
            ("quit now", "expected quit"),
            ("record 9 1", "expected record ADDR SLOT INDEX [OCTET|TYPE:VALUE ...]"),
            ("channel-error", "expected channel-error ADDR SLOT CHANNEL ERROR|TEXT on|off"),
        ] {
            assert_eq!(Command::parse(line).unwrap_err().to_string(), reason, "{line}");
        }
        for line in ["", "dance", "dance 5 now"] {
            let reason = Command::parse(line).unwrap_err().to_string();
            assert!(reason.starts_with("expected one of pressure, atmosphere, gas, fault"), "{line}: {reason}");
            assert!(reason.contains("quit, input, diagnosis, channel-error, alarm, record, got"), "{line}: {reason}");
        }
    }
}
