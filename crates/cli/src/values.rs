//! Values on the command line that more than one command takes.

use profivac_dp::link::Baud;
use std::time::Duration;

/// A transmission rate in bits per second.
pub fn baud(text: &str) -> Result<Baud, String> {
    let known = text.parse().ok().and_then(Baud::from_bits_per_second);
    known.ok_or_else(|| {
        let rates = Baud::ALL.map(|baud| baud.bits_per_second().to_string()).join(", ");
        format!("expected a PROFIBUS rate out of {rates}, got {text:?}")
    })
}

/// A transmission rate, or the wish to have it found.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Rate {
    /// This one.
    Known(Baud),
    /// The one at which somebody is heard.
    Auto,
}

impl Rate {
    /// The rate to begin with: nearly every adapter has the one that stands in for those to be tried.
    pub const fn initial(self) -> Baud {
        match self {
            Self::Known(baud) => baud,
            Self::Auto => Baud::B19200,
        }
    }
}

/// A transmission rate, or `auto`.
pub fn rate(text: &str) -> Result<Rate, String> {
    if text == "auto" {
        return Ok(Rate::Auto);
    }
    baud(text).map(Rate::Known).map_err(|error| format!("{error}; or auto"))
}

/// A probability.
pub fn probability(text: &str) -> Result<f64, String> {
    let probability = text.parse().ok().filter(|number| (0.0..=1.0).contains(number));
    probability.ok_or_else(|| format!("expected a probability from 0 to 1, got {text:?}"))
}

/// A volume in m³.
pub fn volume(text: &str) -> Result<f64, String> {
    let wrong = || format!("expected a volume like '50 l' or '1.2 m3', got {text:?}");
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

/// A time in seconds.
pub fn seconds(text: &str) -> Result<Duration, String> {
    let duration = text.parse().ok().and_then(|seconds| Duration::try_from_secs_f64(seconds).ok());
    duration.ok_or_else(|| format!("expected a number of seconds, got {text:?}"))
}

/// The address of a slave that can be owned.
pub fn slave_address(text: &str) -> Result<u8, String> {
    let address = text.parse().ok().filter(|address| *address <= 125);
    address.ok_or_else(|| format!("expected the address of a slave from 0 to 125, got {text:?}"))
}

/// The address of a slave, also of one that waits for its address.
pub fn any_address(text: &str) -> Result<u8, String> {
    let address = text.parse().ok().filter(|address| *address <= 126);
    address.ok_or_else(|| format!("expected the address of a slave from 0 to 126, got {text:?}"))
}

/// How much faster than real time.
pub fn speed(text: &str) -> Result<f64, String> {
    let speed = text.parse().ok().filter(|speed| (0.01..=10_000.0).contains(speed));
    speed.ok_or_else(|| format!("expected a speed from 0.01 to 10000, got {text:?}"))
}
