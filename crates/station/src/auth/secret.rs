//! Numbers that nobody can guess, from the system.

use std::fmt;
use subtle::ConstantTimeEq;

/// 256 bits.
const OCTETS: usize = 32;

/// A number that nobody can guess, as 64 hexadecimal digits: the name of a session, or the proof that a request comes from our page.
#[derive(Clone, PartialEq, Eq, Hash)]
pub struct Secret(String);

impl Secret {
    /// A new one.
    ///
    /// # Errors
    /// When the system gives no random numbers.
    pub fn new() -> std::io::Result<Self> {
        let mut octets = [0; OCTETS];
        getrandom::fill(&mut octets).map_err(|error| std::io::Error::other(format!("no random numbers: {error}")))?;
        Ok(Self(octets.iter().map(|octet| format!("{octet:02x}")).collect()))
    }

    /// What somebody says it is, if it can be one at all.
    #[must_use]
    pub fn parse(text: &str) -> Option<Self> {
        let digits = text.bytes().all(|octet| octet.is_ascii_digit() || (b'a'..=b'f').contains(&octet));
        (digits && text.len() == 2 * OCTETS).then(|| Self(text.to_owned()))
    }

    /// Its digits, for whoever it belongs to.
    #[must_use]
    pub fn reveal(&self) -> &str {
        &self.0
    }

    /// Whether this is it; how long that takes tells nothing.
    #[must_use]
    pub fn matches(&self, told: &[u8]) -> bool {
        self.0.as_bytes().ct_eq(told).into()
    }
}

/// Never in a log.
impl fmt::Debug for Secret {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        formatter.write_str("Secret")
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn two_are_never_the_same_and_none_is_shown() {
        let (one, other) = (Secret::new().unwrap(), Secret::new().unwrap());
        assert_ne!(one.reveal(), other.reveal());
        assert!(one.matches(one.reveal().as_bytes()) && !one.matches(other.reveal().as_bytes()) && !one.matches(b""));
        assert_eq!(format!("{one:?}"), "Secret");
    }

    #[test]
    fn only_what_looks_like_one_can_be_one() {
        let secret = Secret::new().unwrap();
        assert_eq!(Secret::parse(secret.reveal()), Some(secret.clone()));
        for wrong in ["", "ab", &"g".repeat(64), &"A".repeat(64), &"a".repeat(65), &"ä".repeat(32)] {
            assert_eq!(Secret::parse(wrong), None, "{wrong}");
        }
    }
}
