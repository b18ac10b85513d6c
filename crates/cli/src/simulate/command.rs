//! The lines `simulate` takes on standard input.

use profivac_client::pressure::Pressure;
use profivac_vacuum::Gas;
use profivac_virtual::action_text::ActionText as Action;
use profivac_virtual::device_spec::parse_address;

/// Thirty years: longer than any gauge is in use.
const MAX_SECONDS: f64 = 1e9;

/// More than a potentiometer of any gauge can give.
const MAX_VOLTS: f64 = 100.0;

/// One line.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Command<'a> {
    Pressure(Pressure),
    Atmosphere(Pressure),
    Gas(Gas),
    Advance(f64),
    /// To the device at this address.
    Device(u8, DeviceCommand<'a>),
    Quit,
}

/// What concerns one device.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum DeviceCommand<'a> {
    Operate(Action<'a>),
    Power(bool),
    State,
}

/// First words, and what must follow each.
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

impl<'a> Command<'a> {
    /// Reads a line, or says what was expected.
    pub fn parse(line: &'a str) -> Result<Self, String> {
        let words: Vec<&str> = line.split_whitespace().collect();
        match words[..] {
            ["pressure", _, ..] => Ok(Self::Pressure(pressure(line)?)),
            ["atmosphere", _, ..] => Ok(Self::Atmosphere(pressure(line)?)),
            ["gas", gas] => Ok(Self::Gas(gas.parse().map_err(|error| format!("{error}"))?)),
            ["advance", seconds] => Ok(Self::Advance(number(seconds, 0.0, MAX_SECONDS)?)),
            ["quit"] => Ok(Self::Quit),
            [word, place, ref rest @ ..] => {
                let order = DeviceCommand::parse(word, rest)?.ok_or_else(|| expected(word))?;
                Ok(Self::Device(parse_address(place).map_err(|error| error.to_string())?, order))
            }
            [word] => Err(expected(word)),
            [] => Err(expected("")),
        }
    }
}

impl<'a> DeviceCommand<'a> {
    /// `None` if the words do not fit together.
    fn parse(word: &str, rest: &[&'a str]) -> Result<Option<Self>, String> {
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

/// Everything behind the first word.
fn pressure(line: &str) -> Result<Pressure, String> {
    let text = line.trim_start().split_once(char::is_whitespace).map_or("", |(_, rest)| rest);
    text.parse().map_err(|error| format!("{error}"))
}

fn number(text: &str, min: f64, max: f64) -> Result<f64, String> {
    let number = text.parse().ok().filter(|number| (min..=max).contains(number));
    number.ok_or_else(|| format!("expected a number from {min} to {max}, got {text:?}"))
}

fn expected(word: &str) -> String {
    match FORMS.into_iter().find(|(known, _)| *known == word) {
        Some((_, rest)) => format!("expected {}", format!("{word} {rest}").trim_end()),
        None => format!("expected one of {}, got {word:?}", FORMS.map(|(known, _)| known).join(", ")),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_line_of_the_contract_is_read() {
        let operate = |action| Command::Device(5, DeviceCommand::Operate(action));
        for (line, order) in [
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
            ("quit", Command::Quit),
        ] {
            assert_eq!(Command::parse(line), Ok(order), "{line}");
        }
    }

    #[test]
    fn a_line_that_does_not_fit_is_answered_with_what_was_expected() {
        for (line, reason) in [
            ("pressure", "expected pressure PRESSURE"),
            ("pressure high", "expected a pressure like '1e-3 mbar', got \"high\""),
            ("fault 5", "expected fault ADDR NAME"),
            ("fault 5 a b", "expected fault ADDR NAME"),
            ("power 5 half", "expected power ADDR off|on"),
            ("button 5 one", "expected button ADDR N"),
            ("pot 5 c 1", "expected pot ADDR a|b VOLTS"),
            ("pot 5 a inf", "expected a number from -100 to 100, got \"inf\""),
            ("advance -1", "expected a number from 0 to 1000000000, got \"-1\""),
            ("state 127", "expected an address from 0 to 126, got \"127\""),
            ("state", "expected state ADDR"),
            ("quit now", "expected quit"),
        ] {
            assert_eq!(Command::parse(line), Err(reason.to_owned()), "{line}");
        }
        for line in ["", "dance", "dance 5 now"] {
            let reason = Command::parse(line).unwrap_err();
            assert!(reason.starts_with("expected one of pressure, atmosphere, gas, fault"), "{line}: {reason}");
        }
    }
}
