//! Helpers for configuration files: values written as text, baud rates, and the position of an error.

use profivac_dp::link::Baud;
use serde::de::{self, Error as _, Visitor};
use serde::{Deserialize, Deserializer};
use std::fmt::{self, Display};
use std::fs::File;
use std::io::{self, Read};
use std::marker::PhantomData;
use std::path::Path;
use std::str::FromStr;

/// The largest file that is read, in octets. chosen: configuration files are far smaller; a device file has no end.
const MAX_OCTETS: u64 = 256 * 1024;

/// Reads a text file of at most 256 KiB in UTF-8.
///
/// # Errors
/// An error of the system, or a file that is too large or not UTF-8.
pub fn read(path: &Path) -> io::Result<String> {
    read_at_most(path, MAX_OCTETS)
}

/// Reads a text file of at most this number of octets in UTF-8.
///
/// # Errors
/// An error of the system, or a file that is too large or not UTF-8.
pub fn read_at_most(path: &Path, most: u64) -> io::Result<String> {
    let mut octets = Vec::new();
    File::open(path)?.take(most.saturating_add(1)).read_to_end(&mut octets)?;
    if octets.len() as u64 > most {
        return Err(io::Error::other(format!("expected a text of at most {most} octets, got more")));
    }
    String::from_utf8(octets).map_err(|_| io::Error::other("expected a text in UTF-8, got other octets"))
}

/// A value that the file writes as a text and [`FromStr`] parses. The error of a bare number is the error of [`FromStr`], which says
/// what is missing: usually the unit.
#[derive(Debug)]
pub struct Parsed<T>(pub T);

impl<'de, T: FromStr<Err: Display>> Deserialize<'de> for Parsed<T> {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        deserializer.deserialize_any(ParsedText(PhantomData))
    }
}

/// Reads a text, and refuses a number with the words of the value.
struct ParsedText<T>(PhantomData<T>);

impl<T: FromStr<Err: Display>> ParsedText<T> {
    fn refuse<E: de::Error>(number: &str) -> E {
        number.parse::<T>().err().map_or_else(
            || E::custom(format_args!("expected a text in quotes, got {number}: write \"{number}\"")),
            E::custom,
        )
    }
}

impl<T: FromStr<Err: Display>> Visitor<'_> for ParsedText<T> {
    type Value = Parsed<T>;

    fn expecting(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        formatter.write_str("a text in quotes")
    }

    fn visit_str<E: de::Error>(self, text: &str) -> Result<Parsed<T>, E> {
        text.parse().map(Parsed).map_err(E::custom)
    }

    fn visit_i64<E: de::Error>(self, number: i64) -> Result<Parsed<T>, E> {
        Err(Self::refuse(&number.to_string()))
    }

    fn visit_u64<E: de::Error>(self, number: u64) -> Result<Parsed<T>, E> {
        Err(Self::refuse(&number.to_string()))
    }

    fn visit_f64<E: de::Error>(self, number: f64) -> Result<Parsed<T>, E> {
        Err(Self::refuse(&number.to_string()))
    }
}

/// The baud rate of a file without the key.
#[must_use]
pub const fn usual_baud() -> Baud {
    Baud::B19200
}

/// Deserialises a baud rate in bits per second.
///
/// # Errors
/// The number is not a PROFIBUS rate.
pub fn baud<'de, D: Deserializer<'de>>(deserializer: D) -> Result<Baud, D::Error> {
    let number = u32::deserialize(deserializer)?;
    Baud::from_bits_per_second(number).ok_or_else(|| {
        let rates = Baud::ALL.map(|baud| baud.bits_per_second().to_string()).join(", ");
        D::Error::custom(format!("expected a PROFIBUS rate, one of {rates}, got {number}"))
    })
}

/// The line and the column of an octet of `text`, both from 1.
#[must_use]
pub fn line_and_column(text: &str, offset: usize) -> (usize, usize) {
    let before = text.get(..offset).unwrap_or(text);
    let line = before.rsplit('\n').next().unwrap_or_default();
    (before.matches('\n').count().saturating_add(1), line.chars().count().saturating_add(1))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_a_text_of_limited_size_is_read() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("file");
        for (octets, expected) in [
            (b"baud = 19200".to_vec(), Ok("baud = 19200".to_owned())),
            (vec![0xFF, 0xFE, b'a', 0], Err("expected a text in UTF-8, got other octets".to_owned())),
            (vec![b' '; 256 * 1024 + 1], Err("expected a text of at most 262144 octets, got more".to_owned())),
        ] {
            std::fs::write(&path, octets).unwrap();
            assert_eq!(read(&path).map_err(|error| error.to_string()), expected);
        }
        let endless = read(Path::new("/dev/zero")).unwrap_err();
        assert_eq!(endless.to_string(), "expected a text of at most 262144 octets, got more");
    }

    #[test]
    fn places_are_counted_in_characters_from_one() {
        assert_eq!([0, 1, 3].map(|offset| line_and_column("a\nb", offset)), [(1, 1), (1, 2), (2, 2)]);
        assert_eq!(line_and_column("ab\ncä e", 7), (2, 4));
    }
}
