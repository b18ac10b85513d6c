//! Values on the command line that several commands accept.

use profivac_config::time_span::TimeSpan;
use profivac_dp::link::Baud;
use profivac_virtual::scenario::INCLUDED;
use profivac_web_server::auth::Role;
use std::fmt;
use std::time::Duration;

/// The names of the included scenarios for a help text, in lines of at most 80 characters.
pub fn included_scenarios() -> String {
    let mut text = String::from("Included scenarios:");
    let mut width = usize::MAX;
    for included in INCLUDED {
        if width.saturating_add(included.name.len() + 1) > 80 {
            text += "\n ";
            width = 1;
        }
        text += " ";
        text += included.name;
        width += included.name.len() + 1;
    }
    text
}

/// A value that cannot be used: what was expected, and the text that was found.
#[derive(Clone, Debug, PartialEq)]
pub struct ValueError {
    expected: Expected,
    found: String,
}

/// The values that an option accepts.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Expected {
    Rate,
    RateOrAuto,
    Probability,
    Volume,
    Seconds,
    /// From 0 to this address.
    SlaveAddress(u8),
    Speed,
    Role,
    LinkType,
    Octets,
    Time,
    Number {
        min: f64,
        max: f64,
    },
}

impl Expected {
    /// The error for `text`.
    pub fn but_found(self, text: &str) -> ValueError {
        ValueError { expected: self, found: text.to_owned() }
    }
}

impl std::error::Error for ValueError {}

impl fmt::Display for ValueError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "expected {}, got {:?}", self.expected, self.found)
    }
}

impl fmt::Display for Expected {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let rates = || Baud::ALL.map(|baud| baud.bits_per_second().to_string()).join(", ");
        match self {
            Self::Rate => write!(f, "a PROFIBUS rate, one of {}", rates()),
            Self::RateOrAuto => write!(f, "auto or a PROFIBUS rate, one of {}", rates()),
            Self::Probability => f.write_str("a probability from 0 to 1"),
            Self::Volume => f.write_str("a volume like '50 l' or '1.2 m3'"),
            Self::Seconds => f.write_str("a number of seconds, or a time like '10 min' or 2d"),
            Self::SlaveAddress(last) => write!(f, "the address of a slave from 0 to {last}"),
            Self::Speed => f.write_str("a speed from 0.01 to 10000"),
            Self::Role => f.write_str("viewer, operator or engineer"),
            Self::LinkType => f.write_str("user0 or profibus-dl"),
            Self::Octets => f.write_str("octets in hex like '11 21'"),
            Self::Time => f.write_str(
                "a time like '2026-11-21 14:00', 2026-11-21, 14:00, yesterday, -2h, -7d or 2026-11-21T13:00:00Z",
            ),
            Self::Number { min, max } => write!(f, "a number from {min} to {max}"),
        }
    }
}

/// Parses a transmission rate in bits per second.
pub fn baud(text: &str) -> Result<Baud, ValueError> {
    let known = text.parse().ok().and_then(Baud::from_bits_per_second);
    known.ok_or_else(|| Expected::Rate.but_found(text))
}

/// A transmission rate, or `auto`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Rate {
    /// A rate given as a number.
    Known(Baud),
    /// The rate at which a telegram is received.
    Auto,
}

impl Rate {
    /// The rate to open the port with; for `auto` one that nearly every adapter has.
    pub const fn initial(self) -> Baud {
        match self {
            Self::Known(baud) => baud,
            Self::Auto => Baud::B19200,
        }
    }
}

/// Parses a transmission rate or `auto`.
pub fn rate(text: &str) -> Result<Rate, ValueError> {
    if text == "auto" {
        return Ok(Rate::Auto);
    }
    baud(text).map(Rate::Known).map_err(|_| Expected::RateOrAuto.but_found(text))
}

/// Parses a probability from 0 to 1.
pub fn probability(text: &str) -> Result<f64, ValueError> {
    let probability = text.parse().ok().filter(|number| (0.0..=1.0).contains(number));
    probability.ok_or_else(|| Expected::Probability.but_found(text))
}

/// Parses a volume with a unit, into m³.
pub fn volume(text: &str) -> Result<f64, ValueError> {
    let wrong = || Expected::Volume.but_found(text);
    let trimmed = text.trim();
    let end = trimmed.find(|letter: char| letter.is_alphabetic() && !"eE".contains(letter)).ok_or_else(wrong)?;
    let (number, unit) = trimmed.split_at(end);
    let one = match unit.trim() {
        "l" | "L" => 1e-3,
        "ml" | "cm3" | "cm³" => 1e-6,
        "m3" | "m³" => 1.0,
        _ => return Err(wrong()),
    };
    let volume = number.trim().parse::<f64>().ok().map(|number| number * one);
    volume.filter(|volume| volume.is_finite() && *volume > 0.0).ok_or_else(wrong)
}

/// Parses a time in seconds.
pub fn seconds(text: &str) -> Result<Duration, ValueError> {
    let duration = text.parse().ok().and_then(|seconds| Duration::try_from_secs_f64(seconds).ok());
    let duration = duration.or_else(|| text.parse::<TimeSpan>().ok().map(Duration::from));
    duration.ok_or_else(|| Expected::Seconds.but_found(text))
}

/// Parses the address of a slave that a master can own, 0 to 125.
pub fn slave_address(text: &str) -> Result<u8, ValueError> {
    let address = text.parse().ok().filter(|address| *address <= 125);
    address.ok_or_else(|| Expected::SlaveAddress(125).but_found(text))
}

/// Parses the address of a slave, 0 to 126; 126 is a slave without an address.
pub fn any_address(text: &str) -> Result<u8, ValueError> {
    let address = text.parse().ok().filter(|address| *address <= 126);
    address.ok_or_else(|| Expected::SlaveAddress(126).but_found(text))
}

/// Parses a speed relative to real time.
pub fn speed(text: &str) -> Result<f64, ValueError> {
    let speed = text.parse().ok().filter(|speed| (0.01..=10_000.0).contains(speed));
    speed.ok_or_else(|| Expected::Speed.but_found(text))
}

/// Parses the role of a user.
pub fn role(text: &str) -> Result<Role, ValueError> {
    let role = Role::ALL.into_iter().find(|role| role.to_string() == text);
    role.ok_or_else(|| Expected::Role.but_found(text))
}

/// Parses a number from `min` to `max`.
pub fn number(text: &str, min: f64, max: f64) -> Result<f64, ValueError> {
    let number = text.parse().ok().filter(|number| (min..=max).contains(number));
    number.ok_or_else(|| Expected::Number { min, max }.but_found(text))
}
/// Octets given in hex.
#[derive(Clone, Debug)]
pub struct Octets(pub Vec<u8>);

/// Parses octets in hex, with or without spaces.
pub fn octets(text: &str) -> Result<Octets, ValueError> {
    let digits: String = text.chars().filter(|letter| !letter.is_whitespace()).collect();
    let wrong = || Expected::Octets.but_found(text);
    // from_str_radix accepts a sign.
    if !digits.chars().all(|digit| digit.is_ascii_hexdigit()) || !digits.len().is_multiple_of(2) {
        return Err(wrong());
    }
    let pairs = digits.as_bytes().chunks(2).map(|pair| std::str::from_utf8(pair).unwrap_or_default());
    pairs.map(|pair| u8::from_str_radix(pair, 16)).collect::<Result<_, _>>().map(Octets).map_err(|_| wrong())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn octets_are_parsed_with_and_without_spaces() {
        assert_eq!(octets("11 21").unwrap().0, [0x11, 0x21]);
        assert_eq!(octets("c6878E").unwrap().0, [0xC6, 0x87, 0x8E]);
        for bad in ["1", "0x11", "zz", "1é", "+1", "11 -1"] {
            assert_eq!(
                octets(bad).unwrap_err().to_string(),
                format!("expected octets in hex like '11 21', got {bad:?}")
            );
        }
    }
}
